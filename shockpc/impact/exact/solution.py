"""The impact of one landing in ball arithmetic: rows, impulses along them and the jump of every body.

Rows and recursions are those of double precision, evaluated on arrays of balls. Linear systems are solved by matrices of balls, in
the free velocities, the last joint's first. Along the tree the cost grows with the number of joints, not with its cube. Joints that
follow others couple its branches: H is eliminated then, in an order in which the tree's zeros stay zeros, each velocity in a unit
in which its inertia is about one, so that pivots stay on the diagonal. Both keep the balls narrow.
"""

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import numpy as np
from flint import arb_mat

from shockpc.core.bodies import body_jumps, in_body_axes
from shockpc.core.impulse import RowChoice
from shockpc.core.spatial import Array
from shockpc.impact.exact.balls import Balls, SingularError, balls, entries, matrix, to_double
from shockpc.impact.exact.kinematics import Data, body_coms, body_inertia, data_of, forward_kinematics, joint_inertia, shift
from shockpc.impact.impact import Impact
from shockpc.landing.constraints import ConstraintBlock, block_wrenches, row_jacobian
from shockpc.landing.landing import PosedLanding
from shockpc.landing.motion import approach_speeds

BASE = {"free": [True] * 6, "planar": [True, True, False, False, False, True], "fixed": [False] * 6}
"""Which velocities of a floating base are free: along the plane's first and second axis and its normal, then about them."""


class BallImpact(Impact):
    """An impact in one posture (N = S = 1) at the precision of the present context; what is derived is computed when it is read.

    Args:
        landing: the landing.
        choice: which of its rows are independent.
        data: the robot's numbers; by default as loaded.

    Raises:
        SingularError: no inertia resists a motion, the rows depend on one another, or the precision is too low to tell.
    """

    def __init__(self, landing: PosedLanding, choice: RowChoice, data: Data | None = None) -> None:
        robot, locked = landing.robot, landing.joint_model.locked
        self.landing, self.blocks, self.choice, self.unique = landing, landing.blocks, choice, choice.unique[None]
        self._data = data or data_of(robot)
        self.state, self._places, self._origins = forward_kinematics(robot, self._data, landing.q, landing.plane)
        carried = zip(self._data.mass, self._data.lever, self._data.inertia, strict=True)
        self._moments = [body_inertia(*constants, R) for constants, (R, _) in zip(carried, self._places, strict=True)]
        column = {joint.name: joint.v.start for joint in robot.single_joints}
        self._mimics = [(column[m.joint], [(column[name], by) for name, by in m.leaders.items()]) for m in robot.mimics]
        free = ~locked
        if robot.free_base:
            free[:6] = BASE[landing.base]
        free[[follower for follower, _ in self._mimics]] = False
        self._free, flags = np.flatnonzero(free)[::-1], free.tolist()
        self._degrees = [sum(flags[joint.v]) for joint in robot.joints]
        self.resistances: dict[int, Any] = {}

    def exact(self, values: Array) -> Balls:
        """Doubles as balls."""
        return balls(values)

    def rounded(self, values: Balls, size: Callable[[Array], Any]) -> Array:
        """The doubles nearest to balls; doubles as they are."""
        values = np.asarray(values)
        return values + 0.0 if values.dtype == float else to_double(values, size(values.astype(float)))

    @property
    def masses(self) -> Balls:
        """As in `Impact`."""
        return balls(self._data.mass)[None]

    @cached_property
    def coms(self) -> Balls:
        """As in `Impact`."""
        return body_coms(self._data)[None]

    @cached_property
    def _joint_inertia(self) -> Balls:
        """H (nv, nv), which only joints that follow others need."""
        return joint_inertia(self.landing.robot, self.state.J[0], self._inertias, self.landing.joint_model.armature)

    @cached_property
    def _unit(self) -> Array:
        """Units (ny,) of the free velocities: a power of two, with which a product is exact."""
        if not self._mimics:
            return np.ones(len(self._free))
        inertia = np.array([abs(float(self._joint_inertia[k, k])) for k in self._free])
        return np.asarray(np.ldexp(1.0, -np.frexp(inertia)[1] // 2))

    @cached_property
    def _free_inertia(self) -> arb_mat:
        """H (ny, ny) of the free velocities, in their units."""
        return matrix(self._reduced(self._reduced(self._joint_inertia).T))

    def _reduced(self, rows: Balls) -> Balls:
        """Rows (n, nv) in the free velocities (n, ny): those that follow are parts of those that lead (Eq. 7)."""
        rows = rows.copy()
        for follower, leaders in reversed(self._mimics):
            for leader, by in leaders:
                rows[:, leader] += rows[:, follower] * by
        return np.asarray(rows[:, self._free] * self._unit)

    def _full(self, rates: arb_mat) -> Balls:
        """All velocities (nv, m), those of a floating base in the axes of the plane. Args: rates (ny, m) of the free ones."""
        found = balls(np.zeros((self.landing.robot.model.nv, rates.ncols())))
        found[self._free] = entries(rates) * self._unit[:, None]
        for follower, leaders in self._mimics:
            found[follower] = sum((found[leader] * by for leader, by in leaders), start=found[follower])
        return found

    def _in_base_axes(self, rates: Balls) -> Balls:
        """Velocities (nv, m) in Pinocchio's layout."""
        plane = self.landing.plane
        if self.landing.robot.free_base:
            turn = entries(self._places[0][0].transpose()) @ np.stack([plane.e1, plane.e2, plane.normal], axis=1)
            rates = np.concatenate([turn @ rates[:3], turn @ rates[3:6], rates[6:]])
        return rates

    @cached_property
    def _rows(self) -> Balls:
        """The landing's rows (nc, ny) in the free velocities."""
        return self._reduced(row_jacobian(self.state, self.blocks)[0])

    @cached_property
    def _solution(self) -> tuple[arb_mat, arb_mat]:
        """Jumps (ny, 4) of the free velocities and impulses (r, 4) along the independent rows (Eq. 4)."""
        rows = self.choice.rows.tolist()
        J = matrix(self._rows[rows])
        X = self._by_inertia(J.transpose())
        impulse = -_solve(J * X, matrix(self.speeds[0, rows]))
        return X * impulse, impulse

    @cached_property
    def speeds(self) -> Balls:
        """As in `Impact`."""
        return np.asarray(approach_speeds(self.state, self.blocks, self.landing.before))

    @cached_property
    def impulse(self) -> Balls:
        """As in `Impact`."""
        distribution = self.choice.distribution
        return (
            self.independent_impulse
            if distribution.shape[0] == distribution.shape[1]
            else entries(matrix(distribution) * self._solution[1])[None]
        )

    @cached_property
    def independent_impulse(self) -> Balls:
        """As in `Impact`."""
        impulse = balls(np.zeros((1, len(self.choice.distribution), 4)))
        impulse[0, self.choice.rows] = entries(self._solution[1])
        return impulse

    @cached_property
    def delta_qd(self) -> Balls:
        """As in `Impact`."""
        return self._in_base_axes(self._full(self._solution[0]))[None]

    @cached_property
    def jumps(self) -> Balls:
        """As in `Impact`."""
        state, robot, rates = self.state, self.landing.robot, self._full(self._solution[0])[None]
        jumps = body_jumps(state.J, [joint.v for joint in robot.joints], robot.parents, state.position, rates)
        return in_body_axes(jumps, state.rotation)

    @property
    def joint_origins(self) -> Balls:
        """As in `Impact`."""
        return self._origins

    @cached_property
    def _inertias(self) -> list[arb_mat]:
        """Inertias (6, 6) of the bodies about the base, world axes."""
        return [(T := shift(p)) * moments * T.transpose() for (_, p), moments in zip(self._places, self._moments, strict=True)]

    @property
    def spatial_inertias(self) -> Balls:
        """As in `Impact`."""
        return np.array([inertia.table() for inertia in self._inertias], dtype=object)[None]

    def joint_power(self, joints: Sequence[tuple[int, int]]) -> Balls:
        """As in `Impact`; −armature · Δq̇ where only the drive resists (a row of Eq. 4), which sums no balls that cancel."""
        columns = [column for _, column in joints]
        drive = self.along(self.delta_qd)[..., columns] * -self.landing.joint_model.armature[columns]
        coupled = [column for follower, leaders in self._mimics for column in (follower, *(leader for leader, _ in leaders))]
        constrained = self.landing.joint_model.locked[columns] | np.isin(columns, coupled)
        return np.asarray(np.where(constrained, super().joint_power(joints), drive))

    def delassus(self, block: ConstraintBlock, fixed: Sequence[ConstraintBlock], independent: list[int]) -> arb_mat:
        """Delassus matrix (n, n) of the rows of a block while others stay held: J P Jᵀ, with P the inverse inertia on these [1/kg].

        Args:
            block: the rows, as a unit impulse each.
            fixed: rows that stay held.
            independent: which of these are independent.

        Raises:
            SingularError: the held rows depend on one another.
        """
        J = matrix(self._reduced(row_jacobian(self.state, [block])[0]))
        R = self._reduced(row_jacobian(self.state, fixed)[0])[independent] if independent else None
        return J * self._fixed_response(J, R)

    def rigid_mobility(self, block: ConstraintBlock) -> arb_mat:
        """The same (n, n) of the whole robot as one rigid body: every joint locked, the base free, and nothing held."""
        wrenches = matrix(block_wrenches(self.state, block)[0])
        return wrenches * _solve(sum(self._inertias, start=arb_mat(6, 6)), wrenches.transpose(), of_inertia=True)

    def _fixed_response(self, J: arb_mat, fixed: Balls | None) -> arb_mat:
        """Free velocities (ny, n) by unit impulses along rows J (n, ny) while rows (r, ny) are held."""
        free = self._by_inertia(J.transpose())
        if fixed is None:
            return free
        R = matrix(fixed)
        by_fixed = self._by_inertia(R.transpose())
        return free - by_fixed * _solve(R * by_fixed, R * free)

    def _by_inertia(self, B: arb_mat) -> arb_mat:
        """H⁻¹ B (ny, m) by articulated-body inertias (Featherstone 2008, Chapter 7), or by elimination where joints follow others.

        Each inertia is about its joint's origin: about a distant one its terms would cancel, and balls widen at every joint.
        """
        if self._mimics:
            return _solve(self._free_inertia, B, of_inertia=True)
        parents, m, end = self.landing.robot.parents, B.ncols(), 0
        twists, right, armature = (
            self.state.J[0].T[self._free].tolist(),
            B.table(),
            self.landing.joint_model.armature[self._free].tolist(),
        )
        origins, inertia = [p for _, p in self._places], list(self._moments)
        push, steps = [arb_mat(6, m)] * len(parents), []
        for i in range(len(parents) - 1, -1, -1):
            A, p, parent, columns = inertia[i], push[i], parents[i], slice(end, end + self._degrees[i])
            S, W, rates, end = arb_mat(6, 0), arb_mat(0, 6), arb_mat(0, m), columns.stop
            if self._degrees[i]:
                S = shift(origins[i]).transpose() * arb_mat(twists[columns]).transpose()
                U, St = A * S, S.transpose()
                D = St * U
                for k, value in enumerate(armature[columns]):
                    D[k, k] += value
                W, rates = _solve(D, U.transpose(), True), _solve(D, arb_mat(right[columns]) - St * p, True)
                A, p = A - U * W, p + U * rates
            T = shift(origins[i] - origins[parent]) if parent >= 0 else arb_mat(6, 6)
            steps.append((Tt := T.transpose(), S, W, rates))
            if parent >= 0:
                inertia[parent], push[parent] = inertia[parent] + T * A * Tt, push[parent] + T * p
        moved, found = [arb_mat(6, m)] * (len(parents) + 1), []  # the last twist is the world's
        for i, (Tt, S, W, rates) in enumerate(reversed(steps)):
            twist = Tt * moved[parents[i]]
            rates = rates - W * twist
            moved[i] = twist + S * rates
            found.append(rates.entries())
        return arb_mat(end, m, [rate for columns in reversed(found) for rate in columns])


def _solve(A: arb_mat, B: arb_mat, of_inertia: bool = False) -> arb_mat:
    try:
        return A.solve(B, algorithm="lu")
    except ZeroDivisionError:
        raise SingularError(of_inertia) from None
