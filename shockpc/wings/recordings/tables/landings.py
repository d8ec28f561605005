"""Landings of a recorded table: rows with a configuration and a motion before the impact.

The rows are in arrays.
"""

import contextlib
import functools
import hashlib
import itertools
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.evaluation.landings import ROWS, Chunk, Group, Refusal
from shockpc.landing.before_impact import with_loops
from shockpc.landing.closure import assemble, closure_constraint, follow, moved_joints
from shockpc.landing.landing import PosedLanding
from shockpc.landing.posture import fixed_joints, refuse_beyond_turn
from shockpc.landing.resolve import landing_of
from shockpc.landing.scenes.scene import Posture, Scene
from shockpc.method.approach import Motion
from shockpc.method.dynamics import dynamics
from shockpc.profile import profile_of
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.robot.bodies_and_joints import Joint
from shockpc.robot.robot import Robot
from shockpc.text.errors import SceneError, ShockError, StudyError, UnknownName
from shockpc.wings.recordings.tables.rows import RecordedRows
from shockpc.wings.recordings.tables.scene_of_row import with_scene_of_row

OPEN = 0.1
"""Largest change of a position that the table gives, to close a loop [rad, m]."""

CLOSED_BY, RATES_BY = "closed by", "rates closed by"
"""Columns of the largest changes that close the loops.

They are of a given position [rad, m], and of a given rate [rad/s, m/s].
"""


class ClosedRow(NamedTuple):
    """A configuration and rates with which all loops are closed.

    Attributes:
        q: (nq,) configuration.
        rates: (nv,) of the joints.
        by: largest change of a position that the table gives [rad, m].
        rates_by: largest change of a rate that it gives [rad/s, m/s].
    """

    q: Array
    rates: Array
    by: float
    rates_by: float


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
        first = min(set(range(self.rows)) - self.table.messages.keys())
        return self.table.scenes[int(self.table.scene[first])]

    @functools.cached_property
    def chunks(self) -> tuple[tuple[int, int], ...]:
        """First and last row of every chunk, the last one excluded."""
        most = 1024
        if not self.closes:
            most = min(ROWS, max(1024, 2**25 // self.robot.model.nv**2))
        count = -(-self.rows // most)
        ends = [self.rows * k // count for k in range(count + 1)]
        return tuple(itertools.pairwise(ends))

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
        labels = {key: values.tolist() for key, values in table.labels.items()}
        text = hashlib.sha256(repr((table.scenes, labels, table.messages)).encode())
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
        Q = table.Q.copy()
        rates = table.before.joint_rates.copy()
        messages = dict(table.messages)
        for row in set(range(self.rows)) - messages.keys():
            try:
                closed = self._closed(self._landing(table.key(row)), Q[row], rates[row])
            except ShockError as error:
                messages[row] = str(error)
                continue
            Q[row] = closed.q
            rates[row] = closed.rates
        if len(messages) == self.rows:
            raise StudyError(messages[0])
        before = table.before._replace(joint_rates=rates)
        return table._replace(Q=Q, before=before, messages=messages, closed=True)

    @functools.cached_property
    def _landings(self) -> dict[int, PosedLanding]:
        return {}

    def _landing(self, key: tuple[int, float | None]) -> PosedLanding:
        """The landing of rows of one key; whether they approach the ground is looked at later."""
        number, friction = key
        if number not in self._landings:
            self._landings[number] = landing_of(self.table.scenes[number], self.robot)
        landing = self._landings[number]
        if friction is None:
            return landing
        return replace(landing, scene=replace(landing.scene, friction=friction))

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

        def profile(i: int) -> ShockProfile:
            return profile_of(landing(i))

        return Chunk(data.labels, self._groups(data, Q, before), profile, landing)

    def _groups(self, data: RecordedRows, Q: Array, before: Motion) -> Iterator[Group | Refusal]:
        """The groups of a chunk; loops are closed in its configurations and motions."""
        n = len(Q)
        changes = {name: np.full(n, np.nan) for name in self.extra_headings}
        for i, text in data.messages.items():
            yield Refusal(np.array([i]), StudyError(text))
        known = np.array([i for i in range(n) if i not in data.messages], dtype=int)
        # NaN is not equal to itself: rows without friction would never be one group.
        friction = np.nan_to_num(data.friction if self.by_friction else np.zeros(n), nan=-1.0)
        # Rows with the same contacts and friction share a landing, and are computed together.
        keys = np.stack([data.scene[known], friction[known]])
        _, first, group = np.unique(keys, axis=1, return_index=True, return_inverse=True)
        for k, i in enumerate(known[first].tolist()):
            of_group = known[group.ravel() == k]
            try:
                landing = self._landing(data.key(i))
            except ShockError as error:
                yield Refusal(of_group, error)
                continue
            # A loop that cannot be closed refuses its own row alone.
            rows: list[int] = []
            for row in of_group.tolist():
                try:
                    if self.closes:
                        closed = self._closed(landing, Q[row], before.joint_rates[row])
                        Q[row] = closed.q
                        before.joint_rates[row] = closed.rates
                        changes[CLOSED_BY][row] = closed.by
                        changes[RATES_BY][row] = closed.rates_by
                    rows.append(row)
                except ShockError as error:
                    yield Refusal(np.array([row]), error)
            if rows:
                motion = Motion(*(part[rows] for part in before))
                moving = landing.moving(motion, data.contact_velocity[rows])
                columns = {name: values[rows] for name, values in changes.items()}
                yield Group(np.array(rows), moving, Q[rows], extra_columns=columns)

    def _closed(self, landing: PosedLanding, q: Array, rates: Array) -> ClosedRow:
        """A configuration and rates with which all loops are closed.

        First by the joints that the table does not give; if these cannot close them, by the minimum
        change of all, or of the scene's `assemble`.

        Raises:
            SceneError: the loops cannot be closed, or not within the limit.
        """
        robot = self.robot
        table = self.table
        fixed = fixed_joints(robot, Posture(), landing.scene.assemble)
        in_table = robot.velocities(table.joints)
        try:
            closed = follow(robot, landing.q, q, landing.loops, landing.plane, fixed | in_table)
        except SceneError:
            closed = assemble(robot, q, landing.loops, landing.plane, fixed).q
        by = 0.0
        for name, change, _ in moved_joints(robot, q, closed):
            if name in table.joints:
                by = max(by, abs(change))
        if by > OPEN:
            raise SceneError(
                f"the loops are open: closing them changes a joint that the table gives by "
                f"{by:.3g} rad (m), and at most {OPEN:g} "
                "is taken for a measuring error; correct the table, or leave columns out with "
                "--map COLUMN="
            )
        # What is locked in the impact may have moved before it, and keeps its rate.
        state = dynamics(robot, closed[None])
        loops = [closure_constraint(loop) for loop in landing.loops]
        held = fixed | robot.velocities(robot.followers)
        rates_in_table = robot.velocities(table.rates)
        try:
            moving = with_loops(robot, state, loops, rates, held | rates_in_table, landing.plane)
        except SceneError:
            moving = with_loops(robot, state, loops, rates, held, landing.plane)
        rates_by = np.abs((moving - rates)[rates_in_table]).max(initial=0.0)
        return ClosedRow(closed, moving, by, float(rates_by))

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
        q = self.table.Q[row]
        before = Motion(*(part[row] for part in self.table.before))
        if self.closes:
            closed = self._closed(self._landing(self.table.key(row)), q, before.joint_rates)
            q = closed.q
            before = before._replace(joint_rates=closed.rates)
        return self._row(self.table, row, q, before)

    def _row(self, rows: RecordedRows, i: int, q: Array, before: Motion) -> PosedLanding:
        """The landing of a row, with its scene. Args: q and before, in which loops are closed."""
        landing = self._landing(rows.key(i)).at(q).moving(before, rows.contact_velocity[i])
        return with_scene_of_row(with_torque(landing, rows.effort[i]), self.table.joints)

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
            if joint.axis is None:
                self._refuse_joint(landing, joint)
            elif joint.name not in self.robot.followers:
                refuse_beyond_turn(
                    joint, joint.value(landing.q), f"position of the table in row {row}", StudyError
                )
        return landing.scene

    def _refuse_joint(self, landing: PosedLanding, joint: Joint) -> None:
        """Refuse a joint of several axes whose position or rates a scene cannot hold."""
        same = np.array_equal(landing.q[joint.q], self.first.q[joint.q])
        moved = joint.kind != "ball" and not same
        # Rates that the table does not give follow from the loops.
        turns = joint.name in self.table.rates and landing.before.joint_rates[joint.v].any()
        if moved or turns:
            raise StudyError(
                f'joint "{joint.name}" has {joint.v.stop - joint.v.start} degrees of freedom, '
                f"whose {'position' if moved else 'rates'} a scene cannot hold; analyze the "
                "landing in Python, as profile(row)"
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
