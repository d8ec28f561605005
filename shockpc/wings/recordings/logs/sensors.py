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
        self.log = log
        self.motion = motion
        by_kind = self._read_places()
        self.accelerometers = by_kind["a"]
        # Rates of turning (n, 3) of bodies in their axes, by a gyro on each.
        self.turning: dict[int, Array] = {}
        for frame, place in by_kind["w"].items():
            self.turning[place.body] = self._samples("w", frame) @ place.axes.T
        if motion.gyro is not None:
            self.turning.setdefault(0, motion.gyro)
        self.points: list[Place] = []
        for place in point_places(motion.robot, motion.landing.scene.point):
            if place.name not in self.accelerometers:
                self.points.append(place)
        self.warnings = [*self._slow(), *self._implausible(), *self._without_jump()]

    def _read_places(self) -> dict[str, dict[str, Place]]:
        """Places of the accelerometers ("a") and the gyros ("w") by frame.

        Raises:
            StudyError: one is fixed to the world, or an axis is absent.
        """
        kinds: dict[str, dict[str, Place]] = {"a": {}, "w": {}}
        # The columns of accelerometers are called ax@FRAME, and those of gyros wx@FRAME.
        for name in self.log.sensors:
            kind, frame = name[0], name[3:]
            place = point_place(self.motion.robot, Point(frame=frame))
            if place.body < 0:
                raise StudyError(
                    f'column {name}: frame "{frame}" is fixed to the world, so it measures no '
                    f"landing"
                )
            kinds[kind][frame] = place
        for kind, frames in kinds.items():
            for frame in frames:
                names = [f"{kind}{axis}@{frame}" for axis in "xyz"]
                absent = [name for name in names if name not in self.log.sensors]
                if absent:
                    raise StudyError(
                        f'a sensor at "{frame}" has three axes; the log lacks {listed(absent)}'
                    )
        return kinds

    def _slow(self) -> Iterator[str]:
        """Warnings of accelerometers with few samples."""
        for frame in self.accelerometers:
            rate = (1.0 + 1e-3) / self.log.period[f"ax@{frame}"]
            if rate < GOOD:
                yield (
                    f'the accelerometer at "{frame}" has {rate:.0f} samples a second: its integral '
                    f"is right if it averages between them"
                )

    def _without_jump(self) -> Iterator[str]:
        """Warnings of points whose jump does not follow.

        From one accelerometer the motion of another point of its body follows only with a gyro.
        """
        measured = {place.body for place in self.accelerometers.values()}
        for place in self.points:
            if place.body in measured - self.turning.keys():
                yield f'no jump of "{place.name}": an accelerometer is on its body, and no gyro'

    def _implausible(self) -> Iterator[str]:
        """Warnings of values that are those of another unit, or of the end of a range."""
        for frame in self.accelerometers:
            a = self._samples("a", frame)
            usual = float(np.nanmedian(np.linalg.norm(a, axis=1)))
            if 0.8 < usual < 1.2:
                yield (
                    f'the accelerometer at "{frame}" mostly reads {usual:.2f}, as if in g; '
                    "its columns are in m/s²"
                )
            for axis, values in zip("xyz", np.abs(a).T, strict=True):
                largest = np.nanmax(values)
                at_largest = values == largest
                # Three samples in a row.
                stays = (at_largest[2:] & at_largest[1:-1] & at_largest[:-2]).any()
                if largest > SATURATES and stays:
                    yield (
                        f"a{axis}@{frame} stays at {largest:.4g} m/s², its maximum; "
                        "if that is its range, jumps are too small"
                    )
        for body, w in self.turning.items():
            fastest = float(np.nanmax(np.abs(w)))
            if fastest > FASTEST_TURN:
                name = body_places(self.motion.robot)[body].name
                yield (
                    f'the gyro of "{name}" reads up to {fastest:.3g} rad/s, beyond 2000 deg/s; '
                    "convert it if it is in degrees"
                )

    def _samples(self, kind: str, frame: str) -> Array:
        return np.stack([self.log.sensors[f"{kind}{axis}@{frame}"] for axis in "xyz"], axis=1)

    @functools.cached_property
    def _velocities(self) -> Mapping[str, Array]:
        """Integrals (n, 3) of the accelerometers by frame, in its axes, by trapezoids [m/s].

        They are NaN where a sample is missing.
        """
        step = np.diff(self.log.time)[:, None]
        velocities: dict[str, Array] = {}
        for frame in self.accelerometers:
            a = self._samples("a", frame)
            known = np.where(np.isfinite(a), a, 0.0)
            v = np.zeros_like(known)
            v[1:] = np.cumsum(0.5 * step * (known[1:] + known[:-1]), axis=0)
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
        places = body_places(self.motion.robot)
        begin, end = self.motion.around(self.log.time[last] + time, window)
        rows = None
        if last < begin and end <= self.motion.run(first)[1]:
            rows = (since, first, begin, end)
        turned = {body: self._jump(w, rows) for body, w in self.turning.items()}
        moved = {frame: self._jump(v, rows) for frame, v in self._velocities.items()}
        vectors: list[tuple[str, str, Array]] = []
        for body, jump in turned.items():
            vectors.append(("delta_omega", places[body].name, jump))
        for frame, jump in moved.items():
            vectors.append(("delta_v", frame, jump))
        for place in self.points:
            if place.body not in turned:
                continue
            # Δv at the point = Δv + Δω × r, from the first accelerometer on its body.
            for frame, origin in self.accelerometers.items():
                if origin.body == place.body:
                    at_origin = origin.axes @ moved[frame]
                    delta_v = velocity_at(turned[place.body], at_origin, place.r - origin.r)
                    vectors.append(("delta_v", place.name, place.axes.T @ delta_v))
                    break
        jumps: dict[str, float] = {}
        for quantity, name, jump in vectors:
            for k, axis in enumerate("xyz"):
                jumps[f"{quantity}.{axis}@{name}"] = float(jump[k])
        return jumps

    def _jump(self, values: Array, rows: tuple[int, int, int, int] | None) -> Array:
        """The mean (3,) of samples from `begin` to `end` less a line.

        The line is through those since some sample up to the first touch.

        NaN if any sample is missing, because an integral over it is wrong.
        """
        unknown = np.full(3, np.nan)
        if rows is None:
            return unknown
        since, first, begin, end = rows
        t = self.log.time - self.log.time[first]
        start = max(since, int(np.searchsorted(t, -LINE - 1e-9)))
        before = slice(start, first + 1)
        after = slice(begin, end + 1)
        if not np.isfinite(values[start : end + 1]).all():
            return unknown
        if first + 1 - start < FEWEST or t[start] > -0.5 * LINE:
            return unknown
        offset, slope = np.polynomial.polynomial.polyfit(t[before], values[before], 1)
        return np.asarray(values[after].mean(axis=0) - offset - slope * t[after].mean())
