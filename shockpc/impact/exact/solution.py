"""The impact of one landing in an arithmetic: rows, impulses along them and the jump of every body.

Rows and recursions are those of double precision, evaluated on arrays of numbers. Linear systems
are solved by their matrices, in the free velocities, the last joint's first. Along the tree the
cost grows with the number of joints, not with its cube. Joints that follow others couple its
branches: H is eliminated then, in an order in which the tree's zeros stay zeros, each velocity in a
unit in which its inertia is about one, so that pivots stay on the diagonal. Both keep the balls
narrow.
"""

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np

from shockpc.core.impulse import RowChoice
from shockpc.core.spatial import Array, body_jumps, in_body_axes
from shockpc.impact.exact.arithmetic import Arithmetic, Matrix, Numbers, entries, solve
from shockpc.impact.exact.kinematics import (
    Data,
    body_coms,
    body_inertia,
    data_of,
    forward_kinematics,
    joint_inertia,
    rotor_inertia,
    shift,
)
from shockpc.impact.impact import Impact
from shockpc.landing.constraints import ConstraintBlock, block_wrenches, row_jacobian
from shockpc.landing.dynamics import geared_bodies
from shockpc.landing.landing import PosedLanding
from shockpc.landing.motion import approach_speeds

BASE = {"free": [True] * 6, "planar": [True, True, False, False, False, True], "fixed": [False] * 6}
"""Which velocities of a floating base are free: along the plane's first and second axis and its
normal, then about them.
"""


class ExactImpact(Impact):
    """An impact in one posture (N = S = 1) in an arithmetic; what is derived is computed when it is
    read.

    Args:
        landing: the landing.
        choice: which of its rows are independent.
        data: the robot's numbers; by default as loaded.

    Attributes:
        arithmetic: that of its numbers.

    Raises:
        SingularError: no inertia resists a motion, the rows depend on one another, or the precision
            is too low to tell.
    """

    arithmetic: Arithmetic

    def __init__(self, landing: PosedLanding, choice: RowChoice, data: Data | None = None) -> None:
        robot, locked = landing.robot, landing.joint_model.locked
        self.landing, self.blocks, self.choice, self.unique = (
            landing,
            landing.blocks,
            choice,
            choice.unique[None],
        )
        self._data = data or data_of(robot)
        self.state, self._places, self._origins = forward_kinematics(
            self.arithmetic, robot, self._data, landing.q, landing.plane
        )
        carried = zip(self._data.mass, self._data.lever, self._data.inertia, strict=True)
        self._moments = [
            body_inertia(self.arithmetic, *constants, R)
            for constants, (R, _) in zip(carried, self._places, strict=True)
        ]
        coupling = landing.joint_model.coupling
        for v, body in geared_bodies(robot, coupling):
            moments = rotor_inertia(self.arithmetic, coupling[v], self.state.J[0, :3, v])
            self._moments[body] = self._moments[body] + moments
            self._moments[robot.parents[body]] = self._moments[robot.parents[body]] - moments
        self._armature = self.exact(landing.joint_model.armature) - self.exact(coupling)
        column = {joint.name: joint.v.start for joint in robot.single_joints}
        self._mimics = [
            (column[m.joint], [(column[name], by) for name, by in m.leaders.items()])
            for m in robot.mimics
        ]
        free = ~locked
        if robot.free_base:
            free[:6] = BASE[landing.base]
        free[[follower for follower, _ in self._mimics]] = False
        self._free, flags = np.flatnonzero(free)[::-1], free.tolist()
        self._degrees = [sum(flags[joint.v]) for joint in robot.joints]

    def exact(self, values: Array) -> Numbers:
        """Doubles as numbers of the arithmetic."""
        return self.arithmetic.numbers(values)

    @property
    def masses(self) -> Numbers:
        """As in `Impact`."""
        return self.exact(self._data.mass)[None]

    @cached_property
    def coms(self) -> Numbers:
        """As in `Impact`."""
        return body_coms(self.arithmetic, self._data)[None]

    @cached_property
    def _joint_inertia(self) -> Numbers:
        """H (nv, nv), which only joints that follow others need."""
        return joint_inertia(
            self.arithmetic, self.landing.robot, self.state.J[0], self._inertias, self._armature
        )

    @cached_property
    def _unit(self) -> Array:
        """Units (ny,) of the free velocities: a power of two, with which a product is exact."""
        return np.ones(len(self._free))

    @cached_property
    def _free_inertia(self) -> Any:
        """H (ny, ny) of the free velocities, in their units."""
        return self.arithmetic.matrix(self._reduced(self._reduced(self._joint_inertia).T))

    def _reduced(self, rows: Numbers) -> Numbers:
        """Rows (n, nv) in the free velocities (n, ny): those that follow are parts of those that
        lead (Eq. 7).
        """
        rows = rows.copy()
        for follower, leaders in reversed(self._mimics):
            for leader, by in leaders:
                rows[:, leader] += rows[:, follower] * by
        return np.asarray(rows[:, self._free] * self._unit)

    def _full(self, rates: Matrix) -> Numbers:
        """All velocities (nv, m), those of a floating base in the axes of the plane.

        Args: rates (ny, m) of the free ones.
        """
        found = self.exact(np.zeros((self.landing.robot.model.nv, rates.ncols())))
        found[self._free] = entries(rates) * self._unit[:, None]
        for follower, leaders in self._mimics:
            found[follower] = sum(
                (found[leader] * by for leader, by in leaders), start=found[follower]
            )
        return found

    def _in_base_axes(self, rates: Numbers) -> Numbers:
        """Velocities (nv, m) in Pinocchio's layout."""
        plane = self.landing.plane
        if self.landing.robot.free_base:
            turn = entries(self._places[0][0].transpose()) @ np.stack(
                [plane.e1, plane.e2, plane.normal], axis=1
            )
            rates = np.concatenate([turn @ rates[:3], turn @ rates[3:6], rates[6:]])
        return rates

    @cached_property
    def _rows(self) -> Numbers:
        """The landing's rows (nc, ny) in the free velocities."""
        return self._reduced(row_jacobian(self.state, self.blocks)[0])

    @cached_property
    def _by_rows(self) -> tuple[Matrix, Matrix]:
        """Free velocities (ny, r) by unit impulses along the independent rows, and the Delassus
        matrix (r, r) of these.
        """
        J = self.arithmetic.matrix(self._rows[self.choice.rows.tolist()])
        X = self._by_inertia(J.transpose())
        return X, self.arithmetic.symmetric(J * X)

    @cached_property
    def _solution(self) -> tuple[Matrix, Matrix]:
        """Jumps (ny, 4) of the free velocities and impulses (r, 4) along the independent rows (Eq.
        4).
        """
        X, delassus = self._by_rows
        impulse = -solve(
            delassus, self.arithmetic.matrix(self.speeds[0, self.choice.rows.tolist()])
        )
        return X * impulse, impulse

    @cached_property
    def speeds(self) -> Numbers:
        """As in `Impact`."""
        return np.asarray(approach_speeds(self.state, self.blocks, self.landing.before))

    @cached_property
    def impulse(self) -> Numbers:
        """As in `Impact`."""
        distribution = self.choice.distribution
        return (
            self.independent_impulse
            if distribution.shape[0] == distribution.shape[1]
            else entries(self.arithmetic.matrix(distribution) * self._solution[1])[None]
        )

    @cached_property
    def independent_impulse(self) -> Numbers:
        """As in `Impact`."""
        impulse = self.exact(np.zeros((1, len(self.choice.distribution), 4)))
        impulse[0, self.choice.rows] = entries(self._solution[1])
        return impulse

    @cached_property
    def delta_qd(self) -> Numbers:
        """As in `Impact`."""
        return self._in_base_axes(self._full(self._solution[0]))[None]

    @cached_property
    def jumps(self) -> Numbers:
        """As in `Impact`."""
        state, robot, rates = self.state, self.landing.robot, self._full(self._solution[0])[None]
        jumps = body_jumps(
            state.J, [joint.v for joint in robot.joints], robot.parents, state.position, rates
        )
        return in_body_axes(jumps, state.rotation)

    @property
    def joint_origins(self) -> Numbers:
        """As in `Impact`."""
        return self._origins

    @cached_property
    def _inertias(self) -> list[Matrix]:
        """Inertias (6, 6) of the bodies about the base, world axes."""
        return [
            (T := shift(self.arithmetic, p)) * moments * T.transpose()
            for (_, p), moments in zip(self._places, self._moments, strict=True)
        ]

    @property
    def spatial_inertias(self) -> Numbers:
        """As in `Impact`."""
        return np.array([inertia.table() for inertia in self._inertias], dtype=object)[None]

    def joint_power(self, joints: Sequence[tuple[int, int]]) -> Numbers:
        """As in `Impact`; −A Δq̇ where only the drive resists (a row of Eq. 4), which sums no balls
        that cancel.

        A rotor that couples to the link that carries it resists with −(A − c) Δq̇ − c a·Δω.
        """
        bodies, columns = ([joint[k] for joint in joints] for k in (0, 1))
        drive = self.along(self.delta_qd)[..., columns] * -self._armature[columns]
        drive = drive - np.sum(
            np.swapaxes(self.state.J[:, :3, columns], 1, 2)[:, None]
            * self.rotor_moments[:, :, bodies],
            axis=-1,
        )
        coupled = [
            column
            for follower, leaders in self._mimics
            for column in (follower, *(leader for leader, _ in leaders))
        ]
        constrained = self.landing.joint_model.locked[columns] | np.isin(columns, coupled)
        return np.asarray(np.where(constrained, super().joint_power(joints), drive))

    def delassus(
        self, block: ConstraintBlock, fixed: Sequence[ConstraintBlock], independent: list[int]
    ) -> Any:
        """Delassus matrix (n, n) of the rows of a block while others stay held: J P Jᵀ, with P the
        inverse inertia on these [1/kg].

        Args:
            block: the rows, as a unit impulse each.
            fixed: rows that stay held.
            independent: which of these are independent.

        Raises:
            SingularError: the held rows depend on one another.
        """
        J = self.arithmetic.matrix(self._reduced(row_jacobian(self.state, [block])[0]))
        R = self._reduced(row_jacobian(self.state, fixed)[0])[independent] if independent else None
        return J * self._fixed_response(J, R)

    def rigid_mobility(self, block: ConstraintBlock) -> Any:
        """The same (n, n) of the whole robot as one rigid body: every joint locked, the base free,
        and nothing held.
        """
        wrenches = self.arithmetic.matrix(block_wrenches(self.state, block)[0])
        return wrenches * solve(
            sum(self._inertias, start=self.arithmetic.block(6, 6)),
            wrenches.transpose(),
            of_inertia=True,
        )

    def _fixed_response(self, J: Matrix, fixed: Numbers | None) -> Any:
        """Free velocities (ny, n) by unit impulses along rows J (n, ny) while rows (r, ny) are
        held.
        """
        free = self._by_inertia(J.transpose())
        if fixed is None:
            return free
        R = self.arithmetic.matrix(fixed)
        by_fixed = self._by_inertia(R.transpose())
        return free - by_fixed * solve(R * by_fixed, R * free)

    def _by_inertia(self, B: Matrix) -> Any:
        """H⁻¹ B (ny, m) by articulated-body inertias (Featherstone 2008, Chapter 7), or by
        elimination where joints follow others.

        Each inertia is about its joint's origin: about a distant one its terms would cancel, and
        balls widen at every joint.
        """
        if self._mimics:
            return solve(self._free_inertia, B, of_inertia=True)
        symmetric, block, parents, m, end = (
            self.arithmetic.symmetric,
            self.arithmetic.block,
            self.landing.robot.parents,
            B.ncols(),
            0,
        )
        twists, right, armature = (
            self.state.J[0].T[self._free].tolist(),
            B.table(),
            self._armature[self._free].tolist(),
        )
        origins, inertia = [p for _, p in self._places], list(self._moments)
        push, steps = [block(6, m)] * len(parents), []
        for i in range(len(parents) - 1, -1, -1):
            A, p, parent, columns = (
                inertia[i],
                push[i],
                parents[i],
                slice(end, end + self._degrees[i]),
            )
            S, W, rates, end = block(6, 0), block(0, 6), block(0, m), columns.stop
            if self._degrees[i]:
                S = (
                    shift(self.arithmetic, origins[i]).transpose()
                    * block(twists[columns]).transpose()
                )
                U, St = A * S, S.transpose()
                D = St * U
                for k, value in enumerate(armature[columns]):
                    D[k, k] += value
                W, rates = (
                    solve(D, U.transpose(), True),
                    solve(D, block(right[columns]) - St * p, True),
                )
                A, p = symmetric(A - U * W), p + U * rates
            T = shift(self.arithmetic, origins[i] - origins[parent]) if parent >= 0 else block(6, 6)
            steps.append((Tt := T.transpose(), S, W, rates))
            if parent >= 0:
                inertia[parent], push[parent] = (
                    inertia[parent] + symmetric(T * A * Tt),
                    push[parent] + T * p,
                )
        moved, found = [block(6, m)] * (len(parents) + 1), []  # the last twist is the world's
        for i, (Tt, S, W, rates) in enumerate(reversed(steps)):
            twist = Tt * moved[parents[i]]
            rates = rates - W * twist
            moved[i] = twist + S * rates
            found.append(rates.entries())
        return block(end, m, [rate for columns in reversed(found) for rate in columns])
