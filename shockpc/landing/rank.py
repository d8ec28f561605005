"""The number of rows that a mechanism can meet independently in any posture.

Rows that rounding of its file adds do not count.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from shockpc.core.impulse import RowLimit, RowLimits, column_sizes, in_terms
from shockpc.core.memo import memoized
from shockpc.core.spatial import Array, Plane, cross_matrix
from shockpc.landing.closure import closed_nearby
from shockpc.landing.movable import movable_columns
from shockpc.method.base import Base
from shockpc.method.constraints import Constraint, row_jacobian, row_terms, row_tolerance
from shockpc.method.dynamics import Dynamics, dynamics
from shockpc.robot.bodies_and_joints import Loop
from shockpc.robot.robot import Robot
from shockpc.robot.rounding import rounding_of

POSTURES = 2
"""Other postures that are tried, of which the one with the most independent rows counts: one may be
singular by chance.
"""

JOINT_STEP, LOOP_STEP = 0.5, 0.05
"""Motion of joints to get there, and where loops have to stay closed [rad, m]."""

BESIDE = LOOP_STEP / 10.0
"""Distance from a posture up to which others have nearby what it has [rad, m]."""

LEAST_ROUNDING = 1e-15
"""Rounding of angles [rad] and lengths [m] below which they are exact in double precision."""

STEP = 1e-4
"""Displacement with which the effect of rounding is computed, which is linear in it [rad, m]."""

CLEAR = 0.1
"""Smallest singular value of the rows, in units of their terms, from which rounding has left none
of them.
"""

SLACK = 2.0
"""Times the effect of rounding, to first order, that still counts as that."""

MOST_KNOWN = 64
"""Postures and rows of a robot of which this is kept."""


class Mechanism(NamedTuple):
    """A robot and what of it is free.

    Attributes:
        robot: the robot.
        base: how its base may move.
        plane: of the study.
        locked: (nv,) joint velocities that are zero.
        loops: what is closed.
    """

    robot: Robot
    base: Base
    plane: Plane
    locked: np.ndarray
    loops: tuple[Loop, ...]

    def row_limits(
        self, constraints: Sequence[Constraint], state: Dynamics, near: Array | None = None
    ) -> RowLimits:
        """The number of constraints' rows that can be independent in any posture.

        It is up to what rounding of the file leaves.

        A singular value of the rows, in units of their terms, counts as zero where rounding of the
        file's angles and lengths can make as much of a zero, in other postures too: one that is
        small in one posture alone is that of a singular posture.

        Args:
            constraints: rows.
            state: the robot in N postures to start from, loops closed.
            near: (nq,) a posture from which the search starts for all that are beside it, loops
                closed.

        Returns: posture → that number, and the largest effect of rounding on the others, relative
            to the terms of the rows.
        """
        count = sum(constraint.size for constraint in constraints)
        single = self.base == "free" and len(constraints) == 1 and not self.loops
        if not constraints or single or not np.any(rounding_of(self.robot) > LEAST_ROUNDING):
            return lambda _: RowLimit(count)
        known = _known(self.robot)
        attitude = self._attitude(constraints, state)
        fixed_key = (*self._key(), *map(_structure, constraints))

        def limit(k: int) -> RowLimit:
            at = [_in_posture(constraint, k) for constraint in constraints]
            # With loops other postures are near by, so that their number depends on where one is.
            q = state.Q[k]
            if self.loops and near is not None and np.abs(q - near).max() <= BESIDE:
                q = near
            depends_on = q if self.loops else attitude[k]
            key = (*fixed_key, *map(_point_key, at), depends_on.tobytes())
            if key not in known:
                if len(known) >= MOST_KNOWN:
                    known.clear()
                known[key] = self._most_from(at, q, count)
            return known[key]

        return limit

    def _most_from(self, constraints: Sequence[Constraint], q: Array, count: int) -> RowLimit:
        """The largest number of independent rows, and the effect of rounding on the others.

        It is that in other postures than q, and with loops in q too.

        Args: count, of all rows.
        """
        s = self._rows(constraints, dynamics(self.robot, q[None])).s
        if len(s) == count and s[-1] > CLEAR:
            return RowLimit(count)
        postures = self._others(q)
        if self.loops:
            postures = [q, *postures]
        return max(self._independent(constraints, posture) for posture in postures)

    def independent_here(self, constraints: Sequence[Constraint], state: Dynamics) -> int:
        """The number of independent rows in one posture (N = 1).

        It is without those that rounding of the file alone may leave.
        """
        rank, _ = self._independent(
            [_in_posture(constraint, 0) for constraint in constraints], state.Q[0]
        )
        return rank

    def _key(self) -> tuple[object, ...]:
        """The key that identifies a mechanism of a robot."""
        loops = tuple(loop.name for loop in self.loops)
        return self.base, self.plane.normal.tobytes(), self.locked.tobytes(), *loops

    def _attitude(self, constraints: Sequence[Constraint], state: Dynamics) -> Array:
        """The part (N, ...) of the base's attitude that affects the number of independent rows."""
        rotation = state.rotation[:, 0]
        has_full_force = all(len(constraint.forces) == 3 for constraint in constraints)
        has_moment = any(len(constraint.moments) for constraint in constraints)
        fixed_on_points = self.base == "fixed" and has_full_force and not has_moment
        if self.base == "free" or not self.robot.free_base or fixed_on_points:
            return np.zeros((len(rotation), 0))
        part = self.plane.normal @ rotation if self._turns else rotation
        return np.asarray(part.round(9) + 0.0)

    @property
    def _turns(self) -> bool:
        """True if the base turns in the plane from one posture to another.

        Loops may tie it to the world.
        """
        return self.base == "planar" and not self.loops

    def _columns(self, base_rotation: Array) -> Array:
        """The columns (nv, ny) of the free joint velocities. Args: base_rotation (1, 3, 3)."""
        free = movable_columns(self.robot, self.base, self.plane, base_rotation, self.locked)
        return np.eye(self.robot.model.nv) if free is None else np.asarray(free[0])

    def _others(self, q: Array) -> list[Array]:
        """Other postures, loops closed; q where they do not close."""
        columns = self._columns(dynamics(self.robot, q[None]).rotation[:, 0])
        rng = np.random.default_rng(0)
        held = 0
        if self.robot.free_base:
            held = 3 if self._turns else 6
        postures: list[Array] = []
        for _ in range(POSTURES):
            step = columns @ rng.uniform(-1.0, 1.0, columns.shape[1])
            step[:held] = 0.0
            size = LOOP_STEP if self.loops else JOINT_STEP
            posture = pin.integrate(self.robot.model, q, step * size)
            if self.loops:
                closed = closed_nearby(self.robot, posture, self.loops, self.plane, self.locked)
                posture = q if closed is None else closed
            postures.append(posture)
        return postures

    def _independent(self, constraints: Sequence[Constraint], q: Array) -> RowLimit:
        """The number of independent rows in one posture, and the effect of rounding on the rest."""
        state = dynamics(self.robot, q[None])
        rows = self._rows(constraints, state)
        changes = self._changes_by_rounding(constraints, state, rows)
        bound = row_tolerance(constraints) * np.sqrt(len(rows.term_size))
        rank = int(np.sum(rows.s > bound))
        while rank:
            # The part of the change that the rows which are kept do not have already.
            change = (rows.U[:, rank - 1] @ changes) @ rows.Vt[rank - 1 :].T
            by_rounding = SLACK * np.linalg.norm(change, axis=1).sum()
            if rows.s[rank - 1] > by_rounding:
                break
            rank -= 1
        effect = np.linalg.norm(rows.U[:, rank:].T @ changes, axis=-1).sum(axis=0)
        return RowLimit(rank, SLACK * float(effect.max(initial=0.0)))

    def _changes_by_rounding(
        self, constraints: Sequence[Constraint], state: Dynamics, rows: "_Rows"
    ) -> Array:
        """The change (6 nb, nc, ny) of the rows by the rounding of each body's angles and lengths.

        Rows are in units of their terms.
        """
        J = row_jacobian(state, constraints)
        changes = (row_jacobian(_displaced(self.robot, state), constraints) - J) @ rows.columns
        in_terms_of = changes / rows.term_size[:, None] / rows.size
        rounding = np.repeat(rounding_of(self.robot), 3) / STEP
        return np.asarray(in_terms_of * rounding[:, None, None])

    def _rows(self, constraints: Sequence[Constraint], state: Dynamics) -> "_Rows":
        """The rows in one posture (N = 1), in units of their terms."""
        columns = self._columns(state.rotation[:, 0])
        terms = row_terms(state, constraints)[0] @ np.abs(columns)
        size = column_sizes(terms)
        term_size, scaled = in_terms(row_jacobian(state, constraints)[0] @ columns, terms, size)
        return _Rows(columns, term_size, size, *np.linalg.svd(scaled))


def _in_posture(constraint: Constraint, k: int) -> Constraint:
    """A constraint with the point (3,) that it has in posture k."""
    return (
        constraint if constraint.point.ndim == 1 else constraint._replace(point=constraint.point[k])
    )


def _structure(constraint: Constraint) -> tuple[object, ...]:
    """The key that identifies a constraint, but for its point."""
    ends = constraint.kind, constraint.body, constraint.other_body, constraint.axes_body
    return *ends, constraint.forces.tobytes(), constraint.moments.tobytes()


def _point_key(constraint: Constraint) -> bytes:
    """The key that identifies a constraint's point.

    The lowest point of a shape is another one in every posture, so it is not on an axis in all of
    them.
    """
    return b"" if constraint.lowest else constraint.point.tobytes()


class _Rows(NamedTuple):
    """Rows in units of their terms, and their singular values.

    Attributes:
        columns: (nv, ny) free joint velocities.
        term_size: (nc,) size of the terms of each row.
        size: (ny,) by which joint velocities are measured.
        U: (nc, nc) combinations of rows.
        s: singular values.
        Vt: (ny, ny) combinations of joint velocities.
    """

    columns: Array
    term_size: Array
    size: Array
    U: Array
    s: Array
    Vt: Array


@memoized()
def _known(robot: Robot) -> dict[tuple[object, ...], RowLimit]:
    """The results of `row_limits` for a robot, by what is free and held."""
    return {}


def _displaced(robot: Robot, state: Dynamics) -> Dynamics:
    """The robot (N = 6 nb) with every body turned about its joint or shifted by `STEP`, by axis.

    A body moves what it carries.
    """
    nb = len(robot.bodies)
    position, rotation = state.position[0], state.rotation[0]
    # Which bodies body i carries, itself too, and which joint velocities are those of such bodies;
    # the first body that a velocity moves is the one behind its joint.
    carries = state.ancestors[:, [joint.v.start for joint in robot.joints]].T
    carried = np.repeat(carries, 6, axis=0)
    first_moved = np.argmax(state.ancestors, axis=0)
    behind = carried[:, first_moved, None]

    # The turn is about the joint that carries the body, so that v = shift − ω × pivot.
    motions = STEP * np.tile(np.eye(6), (nb, 1))
    omega = motions[:, None, :3]
    joints = np.array([-body.rotation.T @ body.offset for body in robot.bodies])
    pivots = position + (rotation @ joints[..., None])[..., 0]
    v = motions[:, None, 3:] - np.cross(omega, np.repeat(pivots, 6, axis=0)[:, None])

    # dJ = V × J, dp = ω × p + v, dR = ω × R
    J = state.J[0]
    angular, linear = J[:3].T, J[3:].T
    d_angular = np.cross(omega, angular)
    d_linear = np.cross(omega, linear) + np.cross(v, angular)
    d_J = np.concatenate([d_angular, d_linear], axis=-1) * behind
    d_position = (np.cross(omega, position) + v) * carried[..., None]
    d_rotation = (cross_matrix(omega) @ rotation) * carried[..., None, None]
    return state._replace(
        J=J + np.swapaxes(d_J, -1, -2),
        position=position + d_position,
        rotation=rotation + d_rotation,
        origin=np.repeat(state.origin, 6 * nb, axis=0),
    )
