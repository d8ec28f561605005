"""A touchdown of a log as a row: posture, velocities before and after, measured jumps.

The jumps are those of accelerometers and gyros.
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from shockpc.wings.recordings.logs.detection import FEWEST
from shockpc.wings.recordings.logs.logged_motion import TWIST, LoggedMotion, StatePart
from shockpc.wings.recordings.logs.odometry import base_velocity
from shockpc.wings.recordings.logs.sensors import Sensors
from shockpc.wings.recordings.touchdowns.flags import Flag

CUT_OFF = "the log, or a part of it without gaps, begins too soon before it for velocities"


SENSOR_WINDOW = 3e-3
"""Longest window for jumps of sensors [s]."""


class TouchSamples(NamedTuple):
    """The samples of a touchdown, and the contacts by number.

    Attributes:
        since: first sample after the touchdown before this one, or of the part of the log without
            gaps.
        first: last sample before the first of its feet touches.
        last: the same of its last foot.
        contacts: those that touch.
        stance: those that stand already.
    """

    since: int
    first: int
    last: int
    contacts: Sequence[int]
    stance: Sequence[int]


class Missing:
    """Texts of what a row lacks, each with times.

    These are the times after the touchdown [ms] for which it holds; they are put in place of {}.
    """

    def __init__(self) -> None:
        self._times = dict[str, dict[str, None]]()  # which keeps their order, and each once

    def add(self, text: str, time: str = "") -> None:
        """Note what is missing, at a time."""
        self._times.setdefault(text, {})[time] = None

    def __str__(self) -> str:
        return "; ".join(text.format(", ".join(times)) for text, times in self._times.items())


class RowReader:
    """Reads the rows of touchdowns: posture, velocities before and after, and jumps of sensors.

    Velocities are those of lines through the samples in a window before the touchdown, or around a
    time after it.

    Attributes:
        known: velocities of the base that the log gives.
        odometry: whether the base's velocity is that of the standing feet, as the log lacks it.
    """

    def __init__(
        self,
        motion: LoggedMotion,
        sensors: Sensors,
        flags: Mapping[int, Flag],
        windows: Mapping[StatePart, float],
    ) -> None:
        self.motion = motion
        self.time = motion.time
        self.sensors = sensors
        self.flags = flags
        self.windows = windows
        needed = _directions_that_move(motion)
        self.known: tuple[str, ...] = ()
        if np.isfinite(windows["base"]):
            self.known = motion.names["base"]
        self.odometry = motion.free and not set(needed) <= set(self.known)

    def __call__(
        self, touch: TouchSamples, after: tuple[float, ...]
    ) -> tuple[dict[str, Any] | None, str]:
        """The row by names of columns, or None; and what is missing.

        Args: after, times after the touchdown [s].
        """
        motion = self.motion
        row = self._posture(touch.first)
        missing = Missing()
        for part in self._parts():
            samples = self._before(part, touch.first)
            if samples is None:
                return None, CUT_OFF
            row |= self._velocities("", part, *samples)
            if part == "joints" and self.odometry:
                row |= self._by_feet("", touch.stance, *samples, missing, "no base velocity: ")
            if motion.rail is not None:
                rate = self._rail_before(touch.first, *samples)
                row[f"before_{motion.rail}"] = rate
                if np.isnan(rate):
                    return (
                        None,
                        f'how fast "{motion.rail}" slides is not known: no flight before it that '
                        f"begins upwards",
                    )
            for time in after:
                self._after(row, part, touch, time, missing)
        if self.odometry and np.isinf(self.windows["joints"]):
            row |= {key: np.nan for key in TWIST if key not in row}
            missing.add("no base velocity: the joints have too few samples")
        for time in after:
            row |= self._jumps(touch, time, missing)
        return row, str(missing)

    def _parts(self) -> list[StatePart]:
        """The parts of the state that have velocities in a row."""
        parts: list[StatePart] = []
        for part, window in self.windows.items():
            by_feet = part == "joints" and self.odometry
            if np.isfinite(window) and (self.motion.names[part] or by_feet):
                parts.append(part)
        return parts

    def _before(self, part: StatePart, touch: int) -> tuple[int, int] | None:
        """The first and the last sample of the line before a touchdown.

        None where the log begins too late for it.
        """
        t = self.time
        period = self.motion.period[part]
        start = self.motion.run(touch)[0]
        # Between samples of a slower clock, the line to the next one is bent by the touchdown.
        end = touch
        if period >= 1.5 * self.motion.interval:
            end = int(np.searchsorted(t, t[touch] - period))
        begin = int(np.searchsorted(t, t[end] - self.windows[part] - 1e-9))
        begin = max(min(begin, end - FEWEST + 1), start)
        if t[end] - t[start] < (FEWEST - 1) * period * (1.0 - 1e-3) or end - begin < FEWEST - 1:
            return None
        return begin, end

    def _jumps(self, touch: TouchSamples, time: float, missing: Missing) -> dict[str, float]:
        """The jumps that sensors measured until a time after a touchdown [s]."""
        text = f"{1e3 * time:g}"
        windows = [window for window in self.windows.values() if np.isfinite(window)]
        jumps = self.sensors.jumps(
            touch.since, touch.first, touch.last, time, min([*windows, SENSOR_WINDOW])
        )
        if jumps and np.isnan(list(jumps.values())).any():
            missing.add(
                "no jumps of sensors {} ms after it: no line before it, or samples are missing",
                text,
            )
        return {f"after{text}ms_{name}": x for name, x in jumps.items()}

    def _posture(self, sample: int) -> dict[str, Any]:
        """Position and attitude of the base, as far as the log has them, and joint positions."""
        motion = self.motion
        row: dict[str, Any] = {}
        if motion.free:
            row |= {key: motion.Q[sample, k] for k, key in enumerate("xyz") if motion.has(key)}
            # Velocities from axes of the base are in the world's by the scene's attitude, so that
            # belongs to them.
            if motion.has("w") or self.odometry or motion.gyro is not None:
                row |= dict(zip(("qx", "qy", "qz", "qw"), motion.Q[sample, 3:7], strict=True))
        for name, x in zip(motion.joints, motion.positions["joints"][sample], strict=True):
            row[f"q_{name}"] = x
        return row

    def _velocities(self, prefix: str, part: StatePart, begin: int, end: int) -> dict[str, float]:
        """The velocities that the log gives, of a line through some samples."""
        names = self.motion.names[part]
        values = self.motion.velocities(part, begin, end)
        if not prefix and part == "joints":
            prefix = "before_"
        return {prefix + name: x for name, x in zip(names, values, strict=True)}

    def _by_feet(
        self,
        prefix: str,
        feet: Sequence[int],
        begin: int,
        end: int,
        missing: Missing,
        message: str,
        time: str = "",
    ) -> dict[str, float]:
        """Velocities of the base that the log lacks.

        Args: missing gets `message` and the reason, with the time [ms].
        """
        standing = [c for c in feet if self._stands_throughout(c, begin, end)]
        velocities, reason = base_velocity(self.motion, standing, begin, end, not prefix)
        if reason:
            missing.add(message + reason, time)
        return {prefix + key: x for key, x in velocities.items() if key not in self.known}

    def _stands_throughout(self, c: int, begin: int, end: int) -> bool:
        """True if a contact has no flag, or this says contact in all samples of a range."""
        if c not in self.flags:
            return True
        return bool((self.flags[c].signal[begin : end + 1] > 1.0).all())

    def _after(
        self,
        row: dict[str, Any],
        part: StatePart,
        touch: TouchSamples,
        time: float,
        missing: Missing,
    ) -> None:
        """Add the velocities at a time after a touchdown [s] to a row.

        They are NaN where the log does not reach so far.
        """
        motion = self.motion
        window = self.windows[part]
        text = f"{1e3 * time:g}"
        prefix = f"after{text}ms_"
        by_feet = part == "joints" and self.odometry
        row |= {prefix + name: np.nan for name in motion.names[part]}
        if by_feet:
            row |= {prefix + name: np.nan for name in TWIST}

        at = self.time[touch.last] + time
        begin, end = motion.around(at, window)
        run_end = motion.run(touch.first)[1]
        if end > run_end or at + 0.5 * window > self.time[run_end] + 1e-9:
            missing.add("no velocities {} ms after it, where the log ends or has a gap", text)
            return
        if begin <= touch.last:
            missing.add("no velocities {} ms after it, as their samples begin before it", text)
            return
        row |= self._velocities(prefix, part, begin, end)
        if by_feet:
            feet = (*touch.stance, *touch.contacts)
            message = "no base velocity {} ms after it: "
            row |= self._by_feet(prefix, feet, begin, end, missing, message, text)

    def _rail_before(self, touch: int, begin: int, end: int) -> float:
        """Rate of a rail that the log lacks, by the flight since the last contact [m/s].

        NaN without such a flight.
        """
        # Last sample of contact before the touchdown, and which contact it is.
        lift, c = -1, 0
        for number, flag in self.flags.items():
            on = np.flatnonzero(flag.signal[: touch + 1] > 1.0)
            if len(on):
                lift, c = max((lift, c), (int(on[-1]), number))
        if lift < self.motion.run(touch)[0]:
            return np.nan
        landed = next(c for c, flag in self.flags.items() if flag.signal[touch + 1] > 1.0)
        return self.motion.rail_before(lift, touch, (c, landed), begin, end)


def _directions_that_move(motion: LoggedMotion) -> list[str]:
    """Components of the base's velocity that are not zero because its motion is planar."""
    if motion.landing.base != "planar":
        return list(TWIST[:3])
    across = np.abs(motion.landing.plane.normal) > 1.0 - 1e-9
    return [key for key, fixed in zip(TWIST[:3], across, strict=True) if not fixed]
