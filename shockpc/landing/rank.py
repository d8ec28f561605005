"""How many rows a mechanism can meet independently in any posture; what rounding of its file adds
does not count.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from shockpc.core.impulse import column_sizes, in_terms
from shockpc.core.memo import memoized
from shockpc.core.spatial import Array, Plane, cross_matrix
from shockpc.landing.closure import closed_nearby
from shockpc.landing.movable import free_columns
from shockpc.method.base import Base
from shockpc.method.constraints import ConstraintBlock, row_jacobian, row_terms, row_tolerance
from shockpc.method.dynamics import Dynamics, dynamics
from shockpc.robot.elements import Loop
from shockpc.robot.robot import Robot
from shockpc.robot.rounding import rounding_of

POSTURES = 2
"""Other postures that are tried, of which the one with the most independent rows counts: one may be
singular by chance.
"""

JOINT_STEP, LOOP_STEP = 0.5, 0.05
"""How far joints move to get there, and how far where loops have to stay closed [rad, m]."""

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

    def most_independent(
        self, blocks: Sequence[ConstraintBlock], state: Dynamics, near: Array | None = None
    ) -> Callable[[int], tuple[int, float]]:
        """The largest number of independent rows that these blocks have in any posture, up to what
        rounding of the file leaves.

        A singular value of the rows, in units of their terms, counts as zero where rounding of the
        file's angles and lengths can make as much of a zero, in other postures too: one that is
        small in one posture alone is that of a singular posture.

        Args:
            blocks: rows.
            state: the robot in N postures to start from, loops closed.
            near: (nq,) a posture from which the search starts for all that are beside it, loops
                closed.

        Returns: posture → that number, and the largest effect of rounding on the others, relative
            to the terms of the rows.
        """
        count = sum(block.size for block in blocks)
        single = self.base == "free" and len(blocks) == 1 and not self.loops
        if not blocks or single or not np.any(rounding_of(self.robot) > LEAST_ROUNDING):
            return lambda _: (count, 0.0)
        known, attitude = _known(self.robot), self._attitude(blocks, state)
        structure = tuple(
            (b.kind, b.body, b.other, b.axes_body, b.forces.tobytes(), b.moments.tobytes())
            for b in blocks
        )
        mechanism = (
            self.base,
            self.plane.normal.tobytes(),
            self.locked.tobytes(),
            *(loop.name for loop in self.loops),
        )

        def most(k: int) -> tuple[int, float]:
            at = [b._replace(point=b.point if b.point.ndim == 1 else b.point[k]) for b in blocks]
            # The lowest point of a shape is another one in every posture, so it is not on an axis
            # in all of them.
            points = tuple(b"" if b.lowest else b.point.tobytes() for b in at)
            # With loops other postures are near by, so that their number depends on where one is.
            start = state.Q[k] if near is None or np.abs(state.Q[k] - near).max() > BESIDE else near
            key = (*mechanism, *structure, points, (start if self.loops else attitude[k]).tobytes())
            if key not in known:
                if len(known) >= MOST_KNOWN:
                    known.clear()
                q = start if self.loops else state.Q[k]
                s = self._rows(at, dynamics(self.robot, q[None])).s
                clear = len(s) == count and s[-1] > CLEAR
                known[key] = (
                    (count, 0.0)
                    if clear
                    else max(
                        self._independent(at, other)
                        for other in [*[q][: len(self.loops)], *self._others(q)]
                    )
                )
            return known[key]

        return most

    def independent_here(self, blocks: Sequence[ConstraintBlock], state: Dynamics) -> int:
        """The number of independent rows in one posture (N = 1), without those that rounding of the
        file alone may leave.
        """
        at = [
            block._replace(point=block.point if block.point.ndim == 1 else block.point[0])
            for block in blocks
        ]
        return self._independent(at, state.Q[0])[0]

    def _attitude(self, blocks: Sequence[ConstraintBlock], state: Dynamics) -> Array:
        """What of the attitude of the base (N, ...) the number of independent rows depends on."""
        rotation = state.rotation[:, 0]
        whole = all(len(block.forces) == 3 and not len(block.moments) for block in blocks)
        if self.base == "free" or not self.robot.free_base or (self.base == "fixed" and whole):
            return np.zeros((len(rotation), 0))
        part = self.plane.normal @ rotation if self._turns else rotation
        return np.asarray(part.round(9) + 0.0)

    @property
    def _turns(self) -> bool:
        """Whether the base turns in the plane from one posture to another; loops may tie it to the
        world.
        """
        return self.base == "planar" and not self.loops

    def _others(self, q: Array) -> list[Array]:
        """Other postures, loops closed."""
        free = free_columns(
            self.robot,
            self.base,
            self.plane,
            dynamics(self.robot, q[None]).rotation[:, 0],
            self.locked,
        )
        rng, nv, model = np.random.default_rng(0), self.robot.model.nv, self.robot.model
        columns = np.eye(nv) if free is None else free[0]
        others = []
        for _ in range(POSTURES):
            step = columns @ rng.uniform(-1.0, 1.0, columns.shape[1])
            step[: (3 if self._turns else 6) * self.robot.free_base] = 0.0
            other = pin.integrate(model, q, step * (LOOP_STEP if self.loops else JOINT_STEP))
            others.append(
                closed_nearby(self.robot, other, self.loops, self.plane, self.locked)
                if self.loops
                else other
            )
        return [q if other is None else other for other in others]

    def _independent(self, blocks: Sequence[ConstraintBlock], q: Array) -> tuple[int, float]:
        """The same in one posture."""
        state = dynamics(self.robot, q[None])
        columns, term_size, size, U, s, Vt = self._rows(blocks, state)
        rank = int(np.sum(s > row_tolerance(blocks) * np.sqrt(len(term_size))))
        changes = (
            row_jacobian(_displaced(self.robot, state), blocks) - row_jacobian(state, blocks)
        ) @ columns
        changes = (
            changes
            / term_size[:, None]
            / size
            * (np.repeat(rounding_of(self.robot), 3) / STEP)[:, None, None]
        )
        while rank:
            # The part of the change that the rows which are kept do not have already.
            change = (U[:, rank - 1] @ changes) @ Vt[rank - 1 :].T
            if s[rank - 1] > SLACK * np.linalg.norm(change, axis=1).sum():
                break
            rank -= 1
        effect = np.linalg.norm(U[:, rank:].T @ changes, axis=-1).sum(axis=0)
        return rank, SLACK * float(effect.max(initial=0.0))

    def _rows(self, blocks: Sequence[ConstraintBlock], state: Dynamics) -> "_Rows":
        """The rows in one posture (N = 1), in units of their terms."""
        free = free_columns(self.robot, self.base, self.plane, state.rotation[:, 0], self.locked)
        columns = np.eye(self.robot.model.nv) if free is None else free[0]
        terms = row_terms(state, blocks)[0] @ np.abs(columns)
        size = column_sizes(terms)
        term_size, scaled = in_terms(row_jacobian(state, blocks)[0] @ columns, terms, size)
        return _Rows(columns, term_size, size, *np.linalg.svd(scaled))


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
def _known(robot: Robot) -> dict[tuple[object, ...], tuple[int, float]]:
    """What `most_independent` has found of a robot, by what is free and held."""
    return {}


def _displaced(robot: Robot, state: Dynamics) -> Dynamics:
    """The robot (N = 6 nb) with every body, and what it carries, turned about its joint or shifted
    by `STEP`, by axis.
    """
    nb, J, position = len(robot.bodies), state.J[0], state.position[0]
    motions = STEP * np.tile(np.eye(6), (nb, 1))
    omega, shift = motions[:, None, :3], motions[:, None, 3:]
    which = np.repeat(np.arange(nb), 6)
    carried = state.ancestors[:, [joint.v.start for joint in robot.joints]].T[which]
    behind = carried[:, np.argmax(state.ancestors, axis=0), None]
    # of the joint that carries each body
    origins = np.array([-body.rotation.T @ body.offset for body in robot.bodies])
    pivot = (position + (state.rotation[0] @ origins[..., None])[..., 0])[which, None]
    v = shift - np.cross(omega, pivot)
    angular, linear = J[:3].T, J[3:].T
    change = (
        np.concatenate(
            [np.cross(omega, angular), np.cross(omega, linear) + np.cross(v, angular)], axis=-1
        )
        * behind
    )
    return state._replace(
        J=J + np.swapaxes(change, -1, -2),
        position=position + (np.cross(omega, position) + v) * carried[..., None],
        rotation=state.rotation[0]
        + (cross_matrix(omega) @ state.rotation[0]) * carried[..., None, None],
        origin=np.repeat(state.origin, 6 * nb, axis=0),
    )
