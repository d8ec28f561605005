"""Accelerometers and gyros of a log, and the jumps of velocity that they measured.

Columns ax@FRAME, ay@FRAME, az@FRAME are what an accelerometer at a frame reads, in its axes [m/s²]:
it reads the acceleration less that of gravity, 9.81 upwards at rest. Columns wx@FRAME … are those
of a gyro [rad/s].

A jump of velocity is that of the integral of an accelerometer until a time after the touchdown,
less the straight line on which the integral ran before. The line contains gravity and the motion
that goes on, and the axes are taken to turn little in that time.
"""

import functools
from collections.abc import Iterator, Mapping

import numpy as np

from shockpc.core.spatial import Array, velocity_at
from shockpc.landing.places import Place, body_places, point_place, point_places
from shockpc.landing.scenes.scene import Point
from shockpc.text.errors import StudyError
from shockpc.text.printed import listed
from shockpc.wings.recordings.logs.detection import FEWEST
from shockpc.wings.recordings.logs.logged_motion import LoggedMotion
from shockpc.wings.recordings.logs.logs import Log

LINE = 20e-3
"""Time before a touchdown through which the line of the motion goes that is no jump [s].

At least half of it has to be there.
"""

GOOD = 500.0
"""Rate below which an accelerometer has few samples in an impact [Hz]."""

SATURATES, FASTEST_TURN = 19.6, 35.0
"""Smallest end of a range of accelerations [m/s²], and largest angular velocity of gyros [rad/s].

Usual gyros do not exceed it.
"""


class Sensors:
    """The accelerometers and gyros of a log.

    Attributes:
        warnings: what follows from none of them.
    """

    def __init__(self, log: Log, motion: LoggedMotion) -> None:
        self.log, self.motion, robot = log, motion, motion.robot
        kinds: dict[str, dict[str, Place]] = {"a": {}, "w": {}}
        # The columns of accelerometers are called ax@FRAME, and those of gyros wx@FRAME.
        for name in log.sensors:
            kind, frame = name[0], name[3:]
            place = point_place(robot, Point(frame=frame))
            if place.body < 0:
                raise StudyError(
                    f'column {name}: frame "{frame}" is fixed to the world, so it measures no '
                    f"landing"
                )
            kinds[kind][frame] = place
        self.accelerometers = kinds["a"]
        for kind, frames in kinds.items():
            for frame in frames:
                if absent := [
                    f"{kind}{axis}@{frame}"
                    for axis in "xyz"
                    if f"{kind}{axis}@{frame}" not in log.sensors
                ]:
                    raise StudyError(
                        f'a sensor at "{frame}" has three axes; the log lacks {listed(absent)}'
                    )
        # Rates of turning (n, 3) of bodies in their axes, by a gyro on each.
        self.turning = {
            place.body: self._samples("w", frame) @ place.axes.T
            for frame, place in kinds["w"].items()
        }
        if motion.gyro is not None:
            self.turning.setdefault(0, motion.gyro)
        self.points = [
            place
            for place in point_places(robot, motion.landing.scene.point)
            if place.name not in self.accelerometers
        ]
        # From one accelerometer the motion of another point of its body follows only with a gyro.
        measured = {place.body for place in self.accelerometers.values()}
        self.warnings = [
            f'the accelerometer at "{frame}" has {rate:.0f} samples a second: its integral is '
            f"right if it averages between them"
            for frame in self.accelerometers
            if (rate := (1.0 + 1e-3) / log.period[f"ax@{frame}"]) < GOOD
        ]
        self.warnings += self._doubts()
        self.warnings += [
            f'no jump of "{place.name}": an accelerometer is on its body, and no gyro'
            for place in self.points
            if place.body in measured - self.turning.keys()
        ]

    def _samples(self, kind: str, frame: str) -> Array:
        return np.stack([self.log.sensors[f"{kind}{axis}@{frame}"] for axis in "xyz"], axis=1)

    def _doubts(self) -> Iterator[str]:
        """Values that are those of another unit, or of the end of a range."""
        for frame in self.accelerometers:
            a = self._samples("a", frame)
            if 0.8 < (usual := float(np.nanmedian(np.linalg.norm(a, axis=1)))) < 1.2:
                yield (
                    f'the accelerometer at "{frame}" mostly reads {usual:.2f}, as if in g; '
                    "its columns are in m/s²"
                )
            for axis, values in zip("xyz", np.abs(a).T, strict=True):
                held = values == (largest := np.nanmax(values))
                if largest > SATURATES and (held[2:] & held[1:-1] & held[:-2]).any():
                    yield (
                        f"a{axis}@{frame} stays at {largest:.4g} m/s², its maximum; "
                        "if that is its range, jumps are too small"
                    )
        for body, w in self.turning.items():
            if (fastest := float(np.nanmax(np.abs(w)))) > FASTEST_TURN:
                name = body_places(self.motion.robot)[body].name
                yield (
                    f'the gyro of "{name}" reads up to {fastest:.3g} rad/s, beyond 2000 deg/s; '
                    "convert it if it is in degrees"
                )

    @functools.cached_property
    def _velocities(self) -> Mapping[str, Array]:
        """Integrals (n, 3) of the accelerometers by frame, in its axes, by trapezoids [m/s].

        They are NaN where a sample is missing.
        """
        step, velocities = np.diff(self.log.time)[:, None], {}
        for frame in self.accelerometers:
            a = self._samples("a", frame)
            known = np.where(np.isfinite(a), a, 0.0)
            v = np.concatenate(
                [np.zeros((1, 3)), np.cumsum(0.5 * step * (known[1:] + known[:-1]), axis=0)]
            )
            velocities[frame] = np.where(np.isfinite(a), v, np.nan)
        return velocities

    def jumps(
        self, since: int, first: int, last: int, time: float, window: float
    ) -> dict[str, float]:
        """Jumps by quantity; NaN where unknown.

        They are of the points that accelerometers and gyros tell and of the rates of turning.

        Args:
            since: first sample of the motion before.
            first: sample before the first foot touches.
            last: the same of the last one.
            time: after that [s].
            window: length of the window in which the velocity after is the mean [s].
        """
        found, robot = dict[str, Array](), self.motion.robot
        begin, end = self.motion.around(self.log.time[last] + time, window)
        rows = None
        if last < begin and end <= self.motion.run(first)[1]:
            rows = (since, first, begin, end)
        turned = {body: self._jump(w, rows) for body, w in self.turning.items()}
        moved = {frame: self._jump(v, rows) for frame, v in self._velocities.items()}
        for body, jump in turned.items():
            found[f"delta_omega@{body_places(robot)[body].name}"] = jump
        for frame, jump in moved.items():
            found[f"delta_v@{frame}"] = jump
        for place in self.points:
            if place.body not in turned:
                continue
            # Δv at the point = Δv + Δω × r, from the first accelerometer on its body.
            for frame, origin in self.accelerometers.items():
                if origin.body == place.body:
                    delta_v = velocity_at(
                        turned[place.body], origin.axes @ moved[frame], place.r - origin.r
                    )
                    found[f"delta_v@{place.name}"] = place.axes.T @ delta_v
                    break
        return {
            f"{name.replace('@', f'.{axis}@', 1)}": float(jump[k])
            for name, jump in found.items()
            for k, axis in enumerate("xyz")
        }

    def _jump(self, values: Array, rows: tuple[int, int, int, int] | None) -> Array:
        """The mean (3,) of samples from `begin` to `end` less a line.

        The line is through those since some sample up to the first touch.

        NaN if any sample is missing, because an integral over it is wrong.
        """
        if rows is None:
            return np.full(3, np.nan)
        since, first, begin, end = rows
        t = self.log.time - self.log.time[first]
        before = np.arange(max(since, int(np.searchsorted(t, -LINE - 1e-9))), first + 1)
        known = np.isfinite(values[before[0] : end + 1]).all()
        if not known or len(before) < FEWEST or t[before[0]] > -0.5 * LINE:
            return np.full(3, np.nan)
        line = np.polynomial.polynomial.polyfit(t[before], values[before], 1)
        after = slice(begin, end + 1)
        return np.asarray(values[after].mean(axis=0) - line[0] - line[1] * t[after].mean())
