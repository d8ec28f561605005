"""Landings of a recorded table: rows with a configuration and a motion before the impact.

The rows are in arrays.
"""

import contextlib
import functools
import hashlib
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from shockpc.core.spatial import Array
from shockpc.evaluation.landings import ROWS, Chunk, Group, Refusal
from shockpc.landing.before_impact import with_loops
from shockpc.landing.closure import assemble, closure_constraint, follow, moved_joints
from shockpc.landing.landing import PosedLanding
from shockpc.landing.posture import fixed_joints, refuse_beyond_turn
from shockpc.landing.resolve import landing_of
from shockpc.landing.scenes.scene import Posture, Scene
from shockpc.landing.scenes.strike import Strike
from shockpc.method.approach import Motion
from shockpc.method.dynamics import dynamics
from shockpc.profile import profile_of
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.robot.robot import Robot
from shockpc.text.errors import SceneError, ShockError, StudyError, UnknownName
from shockpc.wings.recordings.logs.rows import RecordedRows

OPEN = 0.1
"""Largest change of a position that the table gives, to close a loop [rad, m]."""

CLOSED_BY, RATES_BY = "closed by", "rates closed by"
"""Columns of the largest changes that close the loops.

They are of a given position [rad, m], and of a given rate [rad/s, m/s].
"""


@dataclass(frozen=True, eq=False)
class RecordedLandings:
    """The landings of a table, to be computed in chunks.

    Attributes:
        robot: the robot.
        table: the rows.
        by_friction: whether rows of different friction are computed apart, because a column depends
            on it in arrays too.
    """

    robot: Robot = field(repr=False)
    table: RecordedRows = field(repr=False)
    by_friction: bool = False

    noun, strikes, opens, base_scene = "table", 1, False, None

    def __getstate__(self) -> dict[str, Any]:
        # The rows are sent with the chunks that they are of.
        lean = {
            "robot": self.robot,
            "by_friction": self.by_friction,
            "table": self.table.chunk(0, 0),
        }
        return lean | {"chunks": self.chunks, "closes": self.closes}

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(self.table.Q)

    @property
    def scene(self) -> Scene:
        """The scene of the first row that has one."""
        return self.table.scenes[
            int(self.table.scene[min(set(range(self.rows)) - self.table.messages.keys())])
        ]

    @functools.cached_property
    def chunks(self) -> tuple[tuple[int, int], ...]:
        """First and last row of every chunk, the last one excluded."""
        most = 1024 if self.closes else min(ROWS, max(1024, 2**25 // self.robot.model.nv**2))
        count = -(-self.rows // most)
        return tuple((self.rows * k // count, self.rows * (k + 1) // count) for k in range(count))

    @property
    def extra_headings(self) -> tuple[str, ...]:
        """Headings of the changes that closed loops, if there are any."""
        return (CLOSED_BY, RATES_BY) if self.closes else ()

    @property
    def headings(self) -> tuple[str, ...]:
        """Those of the labels of the rows."""
        return tuple(self.table.labels)

    @property
    def description(self) -> dict[str, Any]:
        """Settings that the rows depend on, besides scene and robot."""
        table = self.table
        text = hashlib.sha256(
            repr(
                (table.scenes, {key: x.tolist() for key, x in table.labels.items()}, table.messages)
            ).encode()
        )
        for part in (
            table.Q,
            *table.before,
            table.scene,
            table.contact_velocity,
            table.friction,
            table.effort,
        ):
            text.update(np.ascontiguousarray(part).tobytes())
        return {"table": {"rows": self.rows, "sha256": text.hexdigest()}}

    @functools.cached_property
    def first(self) -> PosedLanding:
        """The landing of the first row that has one, in the posture of its scene."""
        return self._landing((self.table.scenes.index(self.scene), None))

    @functools.cached_property
    def closes(self) -> bool:
        """True if there are loops that the rows may leave open."""
        return bool(self.first.loops) and not self.table.closed

    @property
    def closed(self) -> RecordedRows:
        """The rows with all loops closed; where they cannot be closed, a row is no landing.

        Raises:
            StudyError: they can be closed in no row.
        """
        table = self.table
        if not self.closes:
            return table
        Q, rates, messages = table.Q.copy(), table.before.joint_rates.copy(), dict(table.messages)
        for row in set(range(self.rows)) - messages.keys():
            try:
                Q[row], rates[row], *_ = self._closed(
                    self._landing(table.key(row)), Q[row], rates[row]
                )
            except ShockError as error:
                messages[row] = str(error)
        if len(messages) == self.rows:
            raise StudyError(messages[0])
        return table._replace(
            Q=Q, before=table.before._replace(joint_rates=rates), messages=messages, closed=True
        )

    @functools.cached_property
    def _known(self) -> dict[int, PosedLanding]:
        return {}

    def _landing(self, key: tuple[int, float | None]) -> PosedLanding:
        """The landing of rows of one key; whether they approach the ground is looked at later."""
        number, friction = key
        if number not in self._known:
            self._known[number] = landing_of(self.table.scenes[number], self.robot)
        landing = self._known[number]
        return (
            landing
            if friction is None
            else replace(landing, scene=replace(landing.scene, friction=friction))
        )

    def compared(self, count: int) -> np.ndarray:
        """Rows (n,), evenly spaced, at most so many."""
        return np.unique(np.linspace(0, self.rows - 1, min(count, self.rows)).astype(int))

    def data(self, k: int) -> RecordedRows:
        """The rows of a chunk."""
        return self.table.chunk(*self.chunks[k])

    def chunk(self, k: int, data: RecordedRows) -> Chunk:
        """The rows of a chunk, grouped by their landing."""
        before = Motion(data.before.velocity, data.before.omega, data.before.joint_rates.copy())
        Q = data.Q.copy()

        def landing(i: int) -> PosedLanding:
            return self._row(data, i, Q[i], Motion(*(part[i] for part in before)))

        return Chunk(
            data.labels, self._groups(data, Q, before), lambda i: profile_of(landing(i)), landing
        )

    def _groups(self, data: RecordedRows, Q: Array, before: Motion) -> Iterator[Group | Refusal]:
        """The groups of a chunk; loops are closed in its configurations and motions."""
        n, closing = len(Q), {name: np.full(len(Q), np.nan) for name in self.extra_headings}
        yield from (Refusal(np.array([i]), StudyError(text)) for i, text in data.messages.items())
        known = np.array([i for i in range(n) if i not in data.messages], dtype=int)
        # NaN is not equal to itself: rows without friction would never be one group.
        friction = np.nan_to_num(data.friction if self.by_friction else np.zeros(n), nan=-1.0)[
            known
        ]
        # Rows with the same contacts and friction share a landing, and are computed together.
        _, first, group = np.unique(
            np.stack([data.scene[known], friction]), axis=1, return_index=True, return_inverse=True
        )
        for k, i in enumerate(known[first].tolist()):
            chosen = known[group.ravel() == k]
            try:
                landing = self._landing(data.key(i))
            except ShockError as error:
                yield Refusal(chosen, error)
                continue
            # A loop that cannot be closed refuses its own row alone.
            closed = []
            for row in chosen.tolist():
                try:
                    if self.closes:
                        Q[row], before.joint_rates[row], *by = self._closed(
                            landing, Q[row], before.joint_rates[row]
                        )
                        for name, x in zip(self.extra_headings, by, strict=True):
                            closing[name][row] = x
                    closed.append(row)
                except ShockError as error:
                    yield Refusal(np.array([row]), error)
            if closed:
                at = np.array(closed)
                moving = landing.moving(
                    Motion(*(part[at] for part in before)), data.contact_velocity[at]
                )
                yield Group(
                    at, moving, Q[at], extra_columns={name: x[at] for name, x in closing.items()}
                )

    def _closed(
        self, landing: PosedLanding, q: Array, rates: Array
    ) -> tuple[Array, Array, float, float]:
        """A configuration and rates with which all loops are closed, and the largest changes.

        The changes are of what the table gives.

        First by the joints that the table does not give; if these cannot close them, by the minimum
        change of all, or of the scene's `assemble`.

        Raises:
            SceneError: the loops cannot be closed, or not within the limit.
        """
        robot, table, blocks = (
            self.robot,
            self.table,
            [closure_constraint(loop) for loop in landing.loops],
        )
        others = fixed_joints(robot, Posture(), landing.scene.assemble)
        given, followers = robot.velocities(table.joints), robot.velocities(robot.followers)
        try:
            closed = follow(robot, landing.q, q, landing.loops, landing.plane, others | given)
        except SceneError:
            closed = assemble(robot, q, landing.loops, landing.plane, others).q
        by = max(
            (abs(by) for name, by, _ in moved_joints(robot, q, closed) if name in table.joints),
            default=0.0,
        )
        if by > OPEN:
            raise SceneError(
                f"the loops are open: closing them changes a joint that the table gives by "
                f"{by:.3g} rad (m), and at most {OPEN:g} "
                "is taken for a measuring error; correct the table, or leave columns out with "
                "--map COLUMN="
            )
        # What is locked in the impact may have moved before it, and keeps its rate.
        state, known = dynamics(robot, closed[None]), robot.velocities(table.rates)
        try:
            moving = with_loops(
                robot, state, blocks, rates, others | followers | known, landing.plane
            )
        except SceneError:
            moving = with_loops(robot, state, blocks, rates, others | followers, landing.plane)
        return closed, moving, by, float(np.abs((moving - rates)[known]).max(initial=0.0))

    def profile(self, row: int) -> ShockProfile:
        """The landing of one row, with a proof.

        Raises:
            ShockError: it cannot be computed.
        """
        return profile_of(self.landing(row))

    def landing(self, row: int) -> PosedLanding:
        """The landing of a row, with its scene, in a configuration and motion that close the loops.

        Raises:
            ShockError: there is none, or they cannot be closed.
        """
        if row in self.table.messages:
            raise StudyError(self.table.messages[row])
        q, before = self.table.Q[row], Motion(*(x[row] for x in self.table.before))
        if self.closes:
            q, rates, *_ = self._closed(self._landing(self.table.key(row)), q, before.joint_rates)
            before = before._replace(joint_rates=rates)
        return self._row(self.table, row, q, before)

    def _row(self, rows: RecordedRows, i: int, q: Array, before: Motion) -> PosedLanding:
        """The landing of a row, with its scene. Args: q and before, in which loops are closed."""
        landing = self._landing(rows.key(i)).at(q).moving(before, rows.contact_velocity[i])
        return self._written(with_torque(landing, rows.effort[i]))

    @property
    def resolved(self) -> Iterator[PosedLanding]:
        """The landings of which the rows are, those that can be resolved."""
        for number in range(len(self.table.scenes)):
            with contextlib.suppress(ShockError):
                yield self._landing((number, None))

    def row_named(self, name: str) -> int:
        """The number of the row of a name.

        Raises:
            UnknownName: there is none.
        """
        if name not in self.table.names:
            raise UnknownName("landing", name, self.table.names[:1000].tolist(), "the table", "")
        return int(np.flatnonzero(self.table.names == name)[0])

    def case(self, row: int) -> Scene:
        """The landing of one row as a scene.

        Raises:
            ShockError: there is none, or a scene cannot hold its posture.
        """
        landing = self.landing(row)
        for joint in self.robot.single_joints[self.robot.free_base :]:
            moved = joint.kind != "ball" and not np.array_equal(
                landing.q[joint.q], self.first.q[joint.q]
            )
            # Rates that the table does not give follow from the loops.
            turns = joint.name in self.table.rates and landing.before.joint_rates[joint.v].any()
            if joint.axis is None and (moved or turns):
                raise StudyError(
                    f'joint "{joint.name}" has {joint.v.stop - joint.v.start} degrees of freedom, '
                    f"whose "
                    f"{'position' if moved else 'rates'} a scene cannot hold; analyze the landing "
                    f"in Python, as profile(row)"
                )
            if joint.axis is not None and joint.name not in self.robot.followers:
                refuse_beyond_turn(
                    joint, joint.value(landing.q), f"position of the table in row {row}", StudyError
                )
        return landing.scene

    def _written(self, landing: PosedLanding) -> PosedLanding:
        """A landing with the scene of its row, in which loops are closed already."""
        robot, q, before, scene = self.robot, landing.q, landing.before, landing.scene
        # Rates of a closed loop depend on one another, so that all are written if any is not zero.
        loops_move = bool(landing.loops) and before.joint_rates.any()
        moving = [
            joint
            for joint in robot.independent_joints
            if loops_move or before.joint_rates[joint.v].any()
        ]
        balls = [
            joint
            for joint in robot.single_joints
            if joint.kind == "ball" and (landing.loops or joint.name in self.table.joints)
        ]
        # Values of the row go over those of the scene, in whichever way that gives them.
        posture = replace(
            scene.posture,
            joints={joint.name: joint.value(q) for joint in robot.independent_joints},
            joints_deg={},
            joint_quaternions={
                **scene.posture.joint_quaternions,
                **{ball.name: tuple(q[ball.q].tolist()) for ball in balls},
            },
        )
        if robot.free_base:
            position, quaternion = tuple(q[:3].tolist()), tuple(q[3:7].tolist())
            posture = replace(
                posture, base_rpy_deg=None, base_position=position, base_quaternion=quaternion
            )
        strike = Strike(
            velocity=tuple(before.velocity.tolist()),
            angular_velocity=tuple(before.omega.tolist()) if before.omega.any() else None,
            joint_velocities={
                joint.name: float(before.joint_rates[joint.v][0]) for joint in moving
            },
        )
        velocities = (
            None if block.velocity is None else tuple(block.velocity.tolist())
            for block in landing.contacts
        )
        contact = tuple(
            replace(c, velocity=velocity)
            for c, velocity in zip(scene.contact, velocities, strict=True)
        )
        # Torques have an effect on finite stiffness only.
        joints, torque = scene.joints, landing.joint_model.torque
        if np.isfinite(torque).any() and scene.yields:
            of_axes = {
                joint.name: float(torque[joint.v][0])
                for joint in robot.single_joints
                if joint.axis is not None
            }
            joints = replace(
                joints,
                torque={name: value for name, value in of_axes.items() if np.isfinite(value)},
            )
        return replace(
            landing,
            scene=replace(scene, posture=posture, strike=strike, contact=contact, joints=joints),
        )


def with_torque(landing: PosedLanding, effort: Array) -> PosedLanding:
    """A landing with the torques (nv,) of its row; NaN where they are the scene's."""
    if not np.isfinite(effort).any():
        return landing
    model = landing.joint_model
    return replace(
        landing,
        joint_model=model._replace(torque=np.where(np.isfinite(effort), effort, model.torque)),
    )
