"""The motion of a robot in a log: its configurations and velocities.

Velocities are slopes of straight lines through the configurations.
"""

import functools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from shockpc.core.spatial import Array, cross
from shockpc.landing.contact import locate_lowest_point
from shockpc.landing.landing import PosedLanding
from shockpc.landing.resolve import landing_of
from shockpc.landing.scenes.scene import Contact, Scene
from shockpc.landing.scenes.strike import GRAVITY
from shockpc.method.constraints import constraint_point
from shockpc.method.dynamics import Dynamics, dynamics
from shockpc.robot.bodies_and_joints import Joint
from shockpc.robot.feet_and_sensors import each_foot
from shockpc.robot.robot import Robot
from shockpc.text.printed import listed
from shockpc.wings.recordings.logs.bags import QUATERNION
from shockpc.wings.recordings.logs.detection import FEWEST, noise, slope_noise
from shockpc.wings.recordings.logs.logs import Log
from shockpc.wings.recordings.tables.column_meaning import column_name
from shockpc.wings.recordings.tables.reader import rows_of

StatePart = Literal["joints", "base"]

PARTS: tuple[StatePart, StatePart] = ("joints", "base")

TWIST = ("vx", "vy", "vz", "wx", "wy", "wz")
"""Columns of the velocity and the angular velocity of the base."""

ATTITUDE = (*QUATERNION, "roll", "pitch", "yaw")
"""Columns of its attitude."""

CHUNK = 4096
"""Samples whose kinematics are computed together."""

LAG, LEAST_LAG, ALIKE = 20e-3, 1e-3, 0.9
"""Longest and smallest lag of a rate that is searched [s], and the smallest correlation at it."""

MOST_SAMPLES = 20_000
"""Samples in which lags and noise are looked for."""


def _columns_of_base(log: Log, robot: Robot) -> dict[str, str]:
    """By name of a column of the base's state before the landing, what it is."""
    of_base: dict[str, str] = {}
    for name in (*log.positions, *log.rates):
        column = column_name(name, robot)
        if column is not None and column.base and not column.after:
            of_base[name] = column.base
    return of_base


class LoggedMotion:
    """The motion of a robot as a log tells it.

    Attributes:
        robot: the robot.
        time: (n,) of the samples, rising [s].
        interval: median time between them [s].
        Q: (n, nq) configurations; what the log does not give is the scene's.
        runs: first and last samples of the parts of the log without gaps.
        free: whether the base moves freely.
        joints: those whose positions the log has.
        unknown: what of the motion of the whole robot it lacks, so that the heights of the feet do
            not follow; in words.
        rail: the joint that alone is unknown, if it slides, and the base is fixed.
        period: time between samples of positions, by part of the robot; infinite where there are
            none [s].
        names: of the velocities of each part: joints, and those of `TWIST` that the log has.
        warnings: what is left out, or taken from the scene.
    """

    def __init__(self, log: Log, landing: PosedLanding) -> None:
        rows = rows_of({**log.positions, **log.rates}, landing)
        self.landing = landing
        self.robot = landing.robot
        self.time = log.time
        self.Q = rows.Q
        self._rows = rows
        self.interval = float(np.median(np.diff(log.time)))
        self.joints = tuple(name for name in self.robot.joint_names if name in rows.joints)
        self.warnings = list(rows.warnings)
        # No slope is taken across a gap.
        self.runs = self._parts_without_gaps(log)
        self.free = self.robot.free_base and landing.base != "fixed"

        # With qpos, the positions of base and joints are one column, of one clock.
        self._whole = "qpos" in log.positions
        of_base = _columns_of_base(log, self.robot)
        self._base = set(of_base.values())
        self._read_clocks(log, of_base)
        self.names = {
            "joints": self.joints,
            "base": tuple(key for key in TWIST if self.free and self.has(key)),
        }

        # By contact, which of the joints that nothing states carry it.
        absent = self._absent_joints()
        self._lacking = [self._carriers(contact.body, absent) for contact in landing.contacts]
        lacking = [joint for joint in absent if any(joint in joints for joints in self._lacking)]
        self.unknown = [f'joint "{joint.name}"' for joint in lacking]
        rails = [joint.name for joint in lacking if joint.kind == "prismatic"]
        self.rail = rails[0] if not self.free and len(self.unknown) == len(rails) == 1 else None
        if self.free and not self.has("z"):
            self.unknown.append("the height of the base (z)")
        # What the log lacks is taken from the scene, with a warning.
        of_scene = ("position", "base attitude") if self.free else ("position",)
        for part in rows.missing:
            if part.startswith(of_scene):
                self.warnings.append(f"not in this log: {part}; taken from the scene")

    def _parts_without_gaps(self, log: Log) -> list[tuple[int, int]]:
        """First and last samples of the parts of a log without gaps.

        A sample that cannot be used is left out with a warning, and ends a part as a gap does.
        """
        messages = self._rows.messages
        known = np.ones(len(self.time), dtype=bool)
        known[list(messages)] = False
        if not known.all():
            first = min(messages)
            self.warnings.append(
                f"{np.sum(~known)} of {len(known)} samples are left out; row {first}: "
                f"{messages[first]}"
            )
        ends = np.flatnonzero(np.diff(log.segment).astype(bool) | np.diff(known))
        firsts = [0, *(ends + 1).tolist()]
        lasts = [*ends.tolist(), len(known) - 1]
        return [pair for pair in zip(firsts, lasts, strict=True) if known[pair[0]]]

    def _read_clocks(self, log: Log, of_base: Mapping[str, str]) -> None:
        """Set the time between samples of the gyro, and of the positions of each part.

        Args: log; of_base, what its columns of the base are.
        """
        gyro = [name for name in log.rates if of_base.get(name) in TWIST[3:]]
        self._gyro = {of_base[name] for name in gyro} >= set(TWIST[3:])
        self._gyro_period = max((log.period[name] for name in gyro), default=np.inf)
        attitude = [name for name in log.positions if of_base.get(name) in ATTITUDE]
        self._slow_attitude = self._gyro and any(
            log.period[name] > 1.5 * self._gyro_period for name in attitude
        )

        # A slow attitude does not count, because the gyro tells the turning.
        counted = [name for name in log.positions if not (self._slow_attitude and name in attitude)]
        # The base's own velocities count where no positions tell them.
        for name in log.rates:
            key = of_base.get(name)
            if key in TWIST and not self._from_positions(key):
                counted.append(name)

        # The slowest column of a part is its clock; qpos has both parts.
        periods: dict[StatePart, list[float]] = {part: [] for part in PARTS}
        for name in counted:
            if self._whole or name not in of_base:
                periods["joints"].append(log.period[name])
            if self._whole or name in of_base:
                periods["base"].append(log.period[name])
        self.period = {part: max(values, default=np.inf) for part, values in periods.items()}

    def _absent_joints(self) -> list[Joint]:
        """The joints whose positions neither the log nor the scene states.

        A guess of one would move the height of each contact that it carries.
        """
        if self._whole:
            return []
        posture = self.landing.scene.posture
        stated = {*self.joints, *self.robot.followers}
        for pattern in (*posture.joints, *posture.joints_deg, *posture.joint_quaternions):
            stated.update(self.robot.match_joints(pattern))
        return [
            joint
            for joint in self.robot.single_joints
            if joint.kind != "free" and joint.name not in stated
        ]

    def _carriers(self, body: int, joints: Sequence[Joint]) -> list[Joint]:
        """Those of some joints that carry a body."""
        return [joint for joint in joints if self.robot.ancestors[body, joint.v].any()]

    def has(self, key: str) -> bool:
        """True if the log has a position, an attitude or a velocity of the base.

        Args: key, "x", "y" or "z" of its position, "w" of its attitude, or one of `TWIST`.
        """
        if key in TWIST:
            return key in self._base or self._from_positions(key)
        turned = key == "w" and ("qw" in self._base or {"roll", "pitch", "yaw"} <= self._base)
        return self._whole or turned or key in self._base

    def carried(self, contact: int) -> bool:
        """True if all joints that carry a contact are known.

        Args: contact, its number.
        """
        return not self._lacking[contact]

    def _from_positions(self, key: str) -> bool:
        """True if a velocity of the base follows from its position, or from a fast attitude.

        Fast is as fast as a gyro. Args: key, of `TWIST`.
        """
        return self.has(key[1]) if key[0] == "v" else self.has("w") and not self._slow_attitude

    @functools.cached_property
    def gyro(self) -> Array | None:
        """Angular velocities (n, 3) of the base that the log has, in its axes [rad/s].

        None where the log lacks them.
        """
        if not (self.free and self._gyro):
            return None
        from scipy.spatial.transform import Rotation

        rotation = Rotation.from_quat(self.Q[:, 3:7]).as_matrix() @ self.robot.bodies[0].rotation
        return np.asarray((rotation.swapaxes(1, 2) @ self._rows.before.omega[..., None])[..., 0])

    def turning(self, begin: int, end: int, before: bool) -> Array | None:
        """Angular velocity (3,) of the base, world axes, by a gyro or else its attitude [rad/s].

        None where the log has neither.

        Args: the first and last sample; and whether a touchdown follows on the last one.
        """
        if self._gyro:
            # Between samples of a slower clock, the line to the next one is bent by a touchdown.
            if before:
                slower = round(self._gyro_period / self.interval) - 1
                end = max(end - slower, self.run(end)[0])
            return np.asarray(self._rows.before.omega[min(begin, end) : end + 1].mean(axis=0))
        if self.has("w") and self.period["base"] < 1.5 * self.interval:
            return self.velocities("base", begin, end)[-3:]
        return None

    def run(self, sample: int) -> tuple[int, int]:
        """First and last sample of the part without gaps that a sample is in."""
        return next(run for run in self.runs if run[0] <= sample <= run[1])

    @functools.cached_property
    def positions(self) -> dict[StatePart, Array]:
        """Positions (n, k) of the joints [rad, m], and of a free base.

        Those of the base are its position [m] and its quaternion x, y, z, w, without jumps.
        """
        joints = np.empty((len(self.time), len(self.joints)))
        for k, name in enumerate(self.joints):
            cosine, *sine = self.Q[:, self.robot.joint(name).q].T
            joints[:, k] = np.unwrap(np.arctan2(sine[0], cosine)) if sine else cosine
        base = self.Q[:, :7].copy() if self.robot.free_base else np.empty((len(self.time), 0))
        if self.robot.free_base:
            flips = np.sum(base[1:, 3:] * base[:-1, 3:], axis=1) < 0.0
            base[1:, 3:] *= np.where(np.cumsum(flips) % 2, -1.0, 1.0)[:, None]
        return {"joints": joints, "base": base}

    def around(self, time: float, window: float) -> tuple[int, int]:
        """First and last sample of a window around a time [s].

        They are those of the `FEWEST` nearest samples where it holds fewer.
        """
        half = 0.5 * window + 1e-9
        begin, end = np.searchsorted(self.time, (time - half, time + half)).tolist()
        if end - begin < FEWEST:
            near = np.arange(max(begin - FEWEST, 0), min(end + FEWEST, len(self.time)))
            distance = np.abs(self.time[near] - time)
            nearest = np.argsort(distance, kind="stable")[:FEWEST]
            begin = int(near[nearest].min())
            end = begin + FEWEST
        return begin, end - 1

    def velocities(self, part: StatePart, begin: int, end: int) -> Array:
        """Velocities, as in `names`: slopes of the lines through samples begin … end.

        Those of the base are in world axes.

        The angular velocity is 2 q̇ q̄ of the quaternion. What the log has without its positions is
        the mean over the samples.
        """
        samples = slice(begin, end + 1)
        t = self.time[samples] - self.time[samples].mean()
        x = self.positions[part][samples]
        slopes = t @ (x - x[0]) / (t @ t)
        if part == "joints":
            return np.asarray(slopes)
        before = self._rows.before
        twist = np.empty(6)
        for k, axis in enumerate("xyz"):
            twist[k] = slopes[k] if self.has(axis) else before.velocity[samples, k].mean()
        if self._from_positions("wx"):
            twist[3:] = _angular_velocity(x[:, 3:].mean(axis=0), slopes[3:])
        else:
            twist[3:] = before.omega[samples].mean(axis=0)
        return twist[[self.has(key) for key in TWIST]]

    def uncertainty(self, part: StatePart, window: float) -> float:
        """Standard deviation of such a slope by the noise of positions [m/s, rad/s].

        It is that of the noisiest position of a part.
        """
        first, last = max(self.runs, key=lambda run: run[1] - run[0])
        columns = self.positions[part][first : min(last + 1, first + MOST_SAMPLES)].T
        if part == "base":
            columns = columns[:3]
        n = max(1, round(window / self.interval))
        deviations = [slope_noise(noise(column), self.interval, n) for column in columns]
        return max(deviations, default=0.0)

    def points(self) -> Array:
        """Positions (n, c, 3) of the contacts of the landing in world axes [m]."""
        points = np.empty((len(self.time), len(self.landing.contacts), 3))
        for a in range(0, len(points), CHUNK):
            state = dynamics(self.robot, self.Q[a : a + CHUNK])
            for c, contact in enumerate(self.landing.contacts):
                constraint = locate_lowest_point(contact, state.rotation[:, contact.body])
                points[a : a + CHUNK, c] = state.origin + constraint_point(state, constraint)
        return points

    def rail_before(
        self, lift: int, touch: int, contacts: tuple[int, int], begin: int, end: int
    ) -> float:
        """Rate of the rail before a touchdown by the flight before it [m/s].

        NaN if the flight implies no upward speed at its beginning.

        In a flight of time T the centre of mass falls freely: it comes down with Δz / T − g T / 2,
        where Δz is the difference of its heights above the foot, and left with Δz / T + g T / 2.
        The rail is taken to be vertical, and without friction.

        Args:
            lift: last sample with contact before the flight.
            touch: last sample of the flight.
            contacts: numbers of the contacts that leave and touch.
            begin: first sample of the window in whose middle the rate is that.
            end: its last sample.
        """
        up = self.landing.up
        state = dynamics(self.robot, self.Q[[lift, touch, *range(begin, end + 1)]])
        com = self._heights_of_com(state)
        feet = [constraint_point(state, self.landing.contacts[c]) @ up for c in contacts]
        T = self.time[touch] - self.time[lift]
        rise = (com[1] - feet[1][1]) - (com[0] - feet[0][0])
        if rise / T + 0.5 * GRAVITY * T <= 0.0:
            return np.nan
        # What the other joints add is the slope of the height of the centre of mass.
        t = self.time[begin : end + 1]
        from_middle = t - t.mean()
        moving = from_middle @ (com[2:] - com[2]) / (from_middle @ from_middle)
        falling = rise / T - 0.5 * GRAVITY * T + GRAVITY * (self.time[touch] - t.mean())
        return float(falling - moving)

    def _heights_of_com(self, state: Dynamics) -> Array:
        """Heights (n,) of the robot's centre of mass in some states [m]."""
        robot = self.robot
        coms = state.position + (state.rotation @ robot.coms[..., None])[..., 0]
        heights = np.einsum("b,nbk,k->n", robot.masses / robot.mass, coms, self.landing.up)
        return np.asarray(heights)

    def lags(self) -> Iterator[str]:
        """Warnings of rates that lag behind the slopes of their positions.

        The lag is the one at which both correlate best.
        """
        # The longest part without gaps has most to correlate.
        first, last = max(self.runs, key=lambda run: run[1] - run[0])
        last, lags = min(last, first + MOST_SAMPLES), dict[str, float]()
        most = min(round(LAG / self.interval), (last - first) // 4)
        inner = slice(most, last + 1 - first - most)
        for name in self._rows.rates if most else ():
            if name not in self.joints:
                continue
            rate = self._rows.before.joint_rates[first : last + 1, self.robot.joint(name).v.start]
            values = self.positions["joints"][first : last + 1, self.joints.index(name)]
            slope = np.gradient(values, self.time[first : last + 1])[inner]
            # The rate moved by −most to most samples: where it is most like the slope, the shift is
            # the lag.
            shifted = np.lib.stride_tricks.sliding_window_view(rate, len(slope))
            if np.std(slope) > 0.0 and (np.std(shifted, axis=1) > 0.0).all():
                r = [np.corrcoef(slope, part)[0, 1] for part in shifted]
                lag = (int(np.argmax(r)) - most) * self.interval
                if max(r) >= ALIKE and lag > max(LEAST_LAG, 1.5 * self.interval):
                    lags[name] = 1e3 * lag
        if lags:
            least, greatest = min(lags.values()), max(lags.values())
            extent = f"{least:.1f}" if greatest - least < 0.05 else f"{least:.1f} to {greatest:.1f}"
            yield (
                f"rates lag behind the slopes of their positions by {extent} ms, and are not used: "
                f"{listed(lags, 8)}"
            )


def watched_motion(
    log: Log, scene: Scene, robot: Robot, frames: Sequence[str] | None = None
) -> LoggedMotion:
    """The motion of a robot and of what may touch down.

    That is some frames, or all feet and the contacts of the scene.

    A contact of the scene stands for the foot of its body. Where the log lacks what the heights of
    the other feet follow from, the scene's contacts only are watched.
    """
    in_scene = {contact.frame: contact for contact in scene.contact}
    if frames is not None:
        contacts = tuple(in_scene.get(frame, Contact(frame=frame)) for frame in frames)
        return LoggedMotion(log, landing_of(replace(scene, contact=contacts), robot))
    bodies = {robot.frame(frame).body for frame in in_scene if frame in robot.frames}
    feet = [foot for foot in each_foot(robot) if robot.frame(foot).body not in bodies]
    contacts = (*scene.contact, *(Contact(frame=foot) for foot in feet))
    motion = LoggedMotion(log, landing_of(replace(scene, contact=contacts), robot))
    if feet and in_scene and motion.unknown:
        lacking = listed(motion.unknown, 4)
        motion = LoggedMotion(log, landing_of(scene, robot))
        motion.warnings.append(
            f"{listed(feet, 8)}: no touchdowns are looked for, because the log lacks {lacking}"
        )
    return motion


def _angular_velocity(q: Array, dq: Array) -> Array:
    """Angular velocity (3,) of a quaternion q (4,) with the rate q̇: 2 q̇ q̄ / |q|²."""
    v, w = q[:3], q[3]
    dv, dw = dq[:3], dq[3]
    return np.asarray(2.0 * (w * dv - dw * v + cross(v, dv)) / (q @ q))
