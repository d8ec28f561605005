"""What a log says of one touchdown: posture, velocities before and after it, and jumps that
accelerometers and gyros measured.
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


class Touch(NamedTuple):
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
    """What a row lacks: texts, each with the times after the touchdown [ms] for which it holds in
    place of {}.
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
        self.motion, self.time, self.sensors, self.flags, self.windows = (
            motion,
            motion.time,
            sensors,
            flags,
            windows,
        )
        plane = motion.landing.plane
        across = (
            np.abs(plane.normal) > 1.0 - 1e-9
            if motion.landing.base == "planar"
            else np.zeros(3, dtype=bool)
        )
        needed = [key for key, fixed in zip(TWIST[:3], across, strict=True) if not fixed]
        self.known = motion.names["base"] if np.isfinite(windows["base"]) else ()
        self.odometry = motion.free and not set(needed) <= set(self.known)

    def __call__(self, touch: Touch, after: tuple[float, ...]) -> tuple[dict[str, Any] | None, str]:
        """The row by names of columns, or None; and what is missing.

        Args: after, times after the touchdown [s].
        """
        motion, row, missing = self.motion, self._posture(touch.first), Missing()
        for part, window in self.windows.items():
            if not np.isfinite(window) or not (
                motion.names[part] or (part == "joints" and self.odometry)
            ):
                continue
            samples = self._before(part, touch.first)
            if samples is None:
                return None, CUT_OFF
            row |= self._velocities("", part, *samples)
            if part == "joints" and self.odometry:
                row |= self._by_feet("", touch.stance, *samples, missing, "no base velocity: ")
            if motion.rail is not None:
                row[f"before_{motion.rail}"] = rate = self._rail_before(touch.first, *samples)
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

    def _before(self, part: StatePart, touch: int) -> tuple[int, int] | None:
        """The first and the last sample of the line before a touchdown; None where the log begins
        too late for it.
        """
        t, period, start = self.time, self.motion.period[part], self.motion.run(touch)[0]
        # Between samples of a slower clock, the line to the next one is bent by the touchdown.
        end = (
            touch
            if period < 1.5 * self.motion.interval
            else int(np.searchsorted(t, t[touch] - period))
        )
        begin = max(
            min(int(np.searchsorted(t, t[end] - self.windows[part] - 1e-9)), end - FEWEST + 1),
            start,
        )
        if t[end] - t[start] < (FEWEST - 1) * period * (1.0 - 1e-3) or end - begin < FEWEST - 1:
            return None
        return begin, end

    def _jumps(self, touch: Touch, time: float, missing: Missing) -> dict[str, float]:
        """The jumps that sensors measured until a time after a touchdown [s]."""
        window, text = (
            min(w for w in (*self.windows.values(), 3e-3) if np.isfinite(w)),
            f"{1e3 * time:g}",
        )
        jumps = self.sensors.jumps(touch.since, touch.first, touch.last, time, window)
        if jumps and np.isnan(list(jumps.values())).any():
            missing.add(
                "no jumps of sensors {} ms after it: no line before it, or samples are missing",
                text,
            )
        return {f"after{text}ms_{name}": x for name, x in jumps.items()}

    def _posture(self, sample: int) -> dict[str, Any]:
        """Where the base is, as far as the log knows, and all joints at a sample."""
        motion, row = self.motion, dict[str, Any]()
        if motion.free:
            row |= {key: motion.Q[sample, k] for k, key in enumerate("xyz") if motion.has(key)}
            # Velocities from axes of the base are in the world's by the scene's attitude, so that
            # belongs to them.
            turned = motion.has("w") or self.odometry or motion.gyro is not None
            row |= {
                key: motion.Q[sample, 3 + k]
                for k, key in enumerate(("qx", "qy", "qz", "qw"))
                if turned
            }
        return row | {
            f"q_{name}": x
            for name, x in zip(motion.joints, motion.positions["joints"][sample], strict=True)
        }

    def _velocities(self, prefix: str, part: StatePart, begin: int, end: int) -> dict[str, float]:
        """The velocities that the log gives, of a line through some samples."""
        names, values = self.motion.names[part], self.motion.velocities(part, begin, end)
        prefix = prefix or ("before_" if part == "joints" else "")
        return {prefix + name: x for name, x in zip(names, values, strict=True)}

    def _by_feet(
        self,
        prefix: str,
        feet: Sequence[int],
        begin: int,
        end: int,
        missing: Missing,
        what: str,
        time: str = "",
    ) -> dict[str, float]:
        """Velocities of the base that the log lacks.

        Args: missing gets `what` and the reason, with the time [ms].
        """
        standing = [
            c
            for c in feet
            if c not in self.flags or (self.flags[c].signal[begin : end + 1] > 1.0).all()
        ]
        velocities, reason = base_velocity(self.motion, standing, begin, end, not prefix)
        if reason:
            missing.add(what + reason, time)
        return {prefix + key: x for key, x in velocities.items() if key not in self.known}

    def _after(
        self, row: dict[str, Any], part: StatePart, touch: Touch, time: float, missing: Missing
    ) -> None:
        """Add the velocities at a time after a touchdown [s] to a row; NaN where the log does not
        reach so far.
        """
        motion, t, window, text = self.motion, self.time, self.windows[part], f"{1e3 * time:g}"
        run, (begin, end) = motion.run(touch.first), motion.around(t[touch.last] + time, window)
        prefix = f"after{text}ms_"
        by_feet = part == "joints" and self.odometry
        row |= {
            prefix + name: np.nan for name in (*motion.names[part], *(TWIST if by_feet else ()))
        }
        if end > run[1] or t[touch.last] + time + 0.5 * window > t[run[1]] + 1e-9:
            missing.add("no velocities {} ms after it, where the log ends or has a gap", text)
        elif begin <= touch.last:
            missing.add("no velocities {} ms after it, as their samples begin before it", text)
        else:
            row |= self._velocities(prefix, part, begin, end)
            if by_feet:
                feet = (*touch.stance, *touch.contacts)
                row |= self._by_feet(
                    prefix, feet, begin, end, missing, "no base velocity {} ms after it: ", text
                )

    def _rail_before(self, touch: int, begin: int, end: int) -> float:
        """Rate of a rail that the log lacks, by the flight since the last contact; NaN without one
        [m/s].
        """
        lifts = [
            (int(on[-1]), c)
            for c, flag in self.flags.items()
            if len(on := np.flatnonzero(flag.signal[: touch + 1] > 1.0))
        ]
        lift, c = max(lifts, default=(-1, 0))
        if lift < self.motion.run(touch)[0]:
            return np.nan
        landed = next(c for c, flag in self.flags.items() if flag.signal[touch + 1] > 1.0)
        return self.motion.rail_before(lift, touch, (c, landed), begin, end)
