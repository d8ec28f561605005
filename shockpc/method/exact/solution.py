"""Eq. 4 in one posture in an arithmetic: rows, impulses along them and the jump of every body.

Rows and recursions are those of double precision, evaluated on arrays of numbers. Linear systems
are solved by their matrices, in the free velocities, the last joint's first. Along the tree the
cost grows with the number of joints, not with its cube. Joints that follow others couple its
branches: H is eliminated then, in an order in which the tree's zeros stay zeros, each velocity in a
unit in which its inertia is about one, so that pivots stay on the diagonal. Both keep the balls
narrow.
"""

import itertools
from collections.abc import Sequence
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from shockpc.core.impulse import RowSpace
from shockpc.core.spatial import Array, body_jumps, in_body_axes
from shockpc.method.approach import Motion, approach_speeds
from shockpc.method.constraints import Constraint, constraint_wrenches, row_jacobian
from shockpc.method.dynamics import geared_bodies
from shockpc.method.equation import Posed
from shockpc.method.exact.arithmetic import Arithmetic, Matrix, Numbers, entries, solve
from shockpc.method.exact.kinematics import (
    Data,
    body_coms,
    body_inertia,
    data_of,
    forward_kinematics,
    joint_inertia,
    rotor_inertia,
    shift,
)

BASE = {"free": [True] * 6, "planar": [True, True, False, False, False, True], "fixed": [False] * 6}
"""Flags of the velocities of a floating base that are free: along the plane's first and second axis
and its normal, then about them.
"""


class ExactSolution:
    """Eq. 4 and the jumps of the bodies in one posture in an arithmetic; computed when it is read.

    What is linear in the strike has four columns: for 1 m/s along world x, y and z, and for the
    motion before the impact. All arrays have a leading axis of one posture.

    Args:
        posed: the system in its posture, and what is held.
        row_space: which of the rows are independent.
        data: the robot's numbers; by default as loaded.

    Attributes:
        arithmetic: of its numbers.
        posed: the system in its posture, and what is held.
        row_space: which of the rows are independent.
        before: the motion before the impact, which may be set until the speeds are read.
        state: the robot in the posture (N = 1).
        own_inertia: (nv,) reflected inertia of the joints without the coupling to other links
            [kg m², kg].
        joint_origins: (1, n, 3) origins of the frames of the robot's `single_joints`, from the base
            [m].

    Raises:
        SingularError: no inertia resists a motion, the rows depend on one another, or the precision
            is too low to tell.
    """

    arithmetic: Arithmetic
    before: Motion | None

    def __init__(self, posed: Posed, row_space: RowSpace, data: Data | None = None) -> None:
        system = posed.system
        robot = system.robot
        self.posed, self.row_space = posed, row_space
        self.before = system.before
        self._data = data or data_of(robot)
        kinematics = forward_kinematics(self.arithmetic, robot, self._data, posed.q, system.plane)
        self.state = kinematics.state
        self._placements = kinematics.placements
        self.joint_origins = kinematics.origins
        self._moments = self._body_moments()
        self.own_inertia = self.exact(system.armature) - self.exact(system.coupling)

        # Which velocities are free, the last joint's first.
        column = {joint.name: joint.v.start for joint in robot.single_joints}
        self._mimics = []
        for mimic in robot.mimics:
            leaders = [(column[name], by) for name, by in mimic.leaders.items()]
            self._mimics.append((column[mimic.joint], leaders))
        free = ~system.locked
        if robot.free_base:
            free[:6] = BASE[system.base]
        free[[follower for follower, _ in self._mimics]] = False
        self._free = np.flatnonzero(free)[::-1]
        self._degrees = [int(free[joint.v].sum()) for joint in robot.joints]

    def _body_moments(self) -> list[Matrix]:
        """Inertias (6, 6) of the bodies about their joints' origins, with the coupling of rotors.

        In world axes.
        """
        system = self.posed.system
        moments = []
        carried = zip(self._data.mass, self._data.lever, self._data.inertia, strict=True)
        for constants, (R, _) in zip(carried, self._placements, strict=True):
            moments.append(body_inertia(self.arithmetic, *constants, R))
        for v, body in geared_bodies(system.robot, system.coupling):
            rotor = rotor_inertia(self.arithmetic, system.coupling[v], self.state.J[0, :3, v])
            moments[body] = moments[body] + rotor
            parent = system.robot.parents[body]
            moments[parent] = moments[parent] - rotor
        return moments

    def exact(self, values: Array) -> Numbers:
        """Doubles as numbers of the arithmetic."""
        return self.arithmetic.numbers(values)

    @property
    def masses(self) -> Numbers:
        """Masses (1, nb) of the bodies [kg]."""
        return self.exact(self._data.mass)[None]

    @cached_property
    def coms(self) -> Numbers:
        """Centres of mass (1, nb, 3) of the bodies, in their frames [m]."""
        return body_coms(self.arithmetic, self._data)[None]

    @cached_property
    def _joint_inertia(self) -> Numbers:
        """H (nv, nv), which only joints that follow others need."""
        robot = self.posed.system.robot
        return joint_inertia(
            self.arithmetic, robot, self.state.J[0], self.body_inertias, self.own_inertia
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
        """Rows (n, ny) in the free velocities, of rows (n, nv) in all (Eq. 7).

        Velocities that follow are parts of those that lead.
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
        full = self.exact(np.zeros((len(self.posed.system.locked), rates.ncols())))
        full[self._free] = entries(rates) * self._unit[:, None]
        for follower, leaders in self._mimics:
            for leader, by in leaders:
                full[follower] = full[follower] + full[leader] * by
        return full

    def _in_base_axes(self, rates: Numbers) -> Numbers:
        """Velocities (nv, m) in Pinocchio's layout."""
        plane = self.posed.system.plane
        if self.posed.system.robot.free_base:
            axes = np.stack([plane.e1, plane.e2, plane.normal], axis=1)
            turn = entries(self._placements[0][0].transpose()) @ axes
            rates = np.concatenate([turn @ rates[:3], turn @ rates[3:6], rates[6:]])
        return rates

    @cached_property
    def _rows(self) -> Numbers:
        """The rows (nc, ny) in the free velocities."""
        return self._reduced(row_jacobian(self.state, self.posed.constraints)[0])

    @cached_property
    def _by_rows(self) -> tuple[Matrix, Matrix]:
        """Free velocities (ny, r) by unit impulses along the independent rows, and their mobility.

        The mobility (r, r) is the Delassus matrix of these rows.
        """
        J = self.arithmetic.matrix(self._rows[self.row_space.rows.tolist()])
        X = self._by_inertia(J.transpose())
        return X, self.arithmetic.symmetric(J * X)

    @cached_property
    def _solution(self) -> tuple[Matrix, Matrix]:
        """Jumps (ny, 4) of free velocities and impulses (r, 4) along independent rows (Eq. 4)."""
        X, delassus = self._by_rows
        b = self.arithmetic.matrix(self.speeds[0, self.row_space.rows.tolist()])
        # λ = −(J_c H⁻¹ J_cᵀ)⁻¹ b,   Δẏ = H⁻¹ J_cᵀ λ
        impulse = -solve(delassus, b)
        return X * impulse, impulse

    @cached_property
    def speeds(self) -> Numbers:
        """Speeds b (1, nc, 4) that the impact undoes along each row [m/s, rad/s]."""
        return np.asarray(approach_speeds(self.state, self.posed.constraints, self.before))

    @cached_property
    def impulse(self) -> Numbers:
        """Impulses (1, nc, 4) along all rows, of the ground on the robot [N s]."""
        distribution = self.row_space.distribution
        if distribution.shape[0] == distribution.shape[1]:
            return self.independent_impulse
        return entries(self.arithmetic.matrix(distribution) * self._solution[1])[None]

    @cached_property
    def independent_impulse(self) -> Numbers:
        """Impulses (1, nc, 4), as `impulse`, with none along rows that depend on others."""
        impulse = self.exact(np.zeros((1, len(self.row_space.distribution), 4)))
        impulse[0, self.row_space.rows] = entries(self._solution[1])
        return impulse

    @cached_property
    def delta_qd(self) -> Numbers:
        """Jumps (1, nv, 4) of the joint velocities, Pinocchio's layout [rad/s, m/s]."""
        return self._in_base_axes(self._full(self._solution[0]))[None]

    @cached_property
    def jumps(self) -> Numbers:
        """Jumps (1, nb, 6, 4) (Δω, Δv) of the bodies, body coordinates (Eqs. 8 and 9)."""
        state, robot = self.state, self.posed.system.robot
        rates = self._full(self._solution[0])[None]
        columns = [joint.v for joint in robot.joints]
        jumps = body_jumps(state.J, columns, robot.parents, state.position, rates)
        return in_body_axes(jumps, state.rotation)

    @cached_property
    def body_inertias(self) -> list[Matrix]:
        """Inertias (6, 6) of the bodies about the base, world axes."""
        inertias = []
        for (_, p), moments in zip(self._placements, self._moments, strict=True):
            T = shift(self.arithmetic, p)
            inertias.append(T * moments * T.transpose())
        return inertias

    @property
    def spatial_inertias(self) -> Numbers:
        """Inertias (1, nb, 6, 6) of the bodies about the base's origin, world axes."""
        tables = [inertia.table() for inertia in self.body_inertias]
        return np.array(tables, dtype=object)[None]

    @cached_property
    def constrained(self) -> np.ndarray:
        """Mask (nv,) of the joint velocities that are locked, follow others or lead them."""
        constrained = self.posed.system.locked.copy()
        for follower, leaders in self._mimics:
            constrained[follower] = True
            constrained[[leader for leader, _ in leaders]] = True
        return constrained

    def delassus(
        self, constraint: Constraint, fixed: Sequence[Constraint], independent: list[int]
    ) -> Any:
        """Delassus matrix (n, n) of a constraint's rows while others stay held [1/kg].

        J P Jᵀ, with P the inverse inertia on the rows that stay held.

        Args:
            constraint: the rows, as a unit impulse each.
            fixed: rows that stay held.
            independent: which of these are independent.

        Raises:
            SingularError: the held rows depend on one another.
        """
        J = self.arithmetic.matrix(self._reduced(row_jacobian(self.state, [constraint])[0]))
        if not independent:
            return J * self._fixed_response(J, None)
        R = self._reduced(row_jacobian(self.state, fixed)[0])[independent]
        return J * self._fixed_response(J, R)

    def rigid_mobility(self, constraint: Constraint) -> Any:
        """Mobility (n, n) of a constraint's rows with the robot as one rigid body [1/kg].

        It is J P Jᵀ as in `delassus`, with every joint locked, the base free, and nothing held.
        """
        wrenches = self.arithmetic.matrix(constraint_wrenches(self.state, constraint)[0])
        total = sum(self.body_inertias, start=self.arithmetic.block(6, 6))
        return wrenches * solve(total, wrenches.transpose(), of_inertia=True)

    def _fixed_response(self, J: Matrix, fixed: Numbers | None) -> Any:
        """Free velocities (ny, n) by unit impulses along rows J (n, ny), other rows held.

        Args:
            J: rows of the unit impulses.
            fixed: (r, ny) rows that are held.
        """
        free = self._by_inertia(J.transpose())
        if fixed is None:
            return free
        R = self.arithmetic.matrix(fixed)
        by_fixed = self._by_inertia(R.transpose())
        return free - by_fixed * solve(R * by_fixed, R * free)

    def _by_inertia(self, B: Matrix) -> Any:
        """H⁻¹ B (ny, m) by articulated-body inertias (Featherstone 2008, Chapter 7).

        Where joints follow others it is by elimination.

        Each inertia is about its joint's origin: about a distant one its terms would cancel, and
        balls widen at every joint.
        """
        if self._mimics:
            return solve(self._free_inertia, B, of_inertia=True)
        # Featherstone 2008, Table 7.1 (doi:10.1007/978-1-4899-7560-7), for impulses instead of
        # forces: no velocity products, and the right side B in place of the joint forces τ.
        parents = self.posed.system.robot.parents
        joints = self._articulated_joints(B)
        # Pass 2: twists a of the bodies, from the base to the leaves; the last one is the world's.
        twists = [self.arithmetic.block(6, B.ncols())] * (len(parents) + 1)
        rates: list[list[Any]] = []
        for i, (joint, parent) in enumerate(zip(joints, parents, strict=True)):
            # a' = X a_parent,   Δẏ = D⁻¹ (u − Uᵀ a'),   a = a' + S Δẏ
            carried = joint.X * twists[parent]
            joint_rates = joint.rates - joint.by_twist * carried
            twists[i] = carried + joint.S * joint_rates
            rates.append(joint_rates.entries())
        # The free velocities are ordered from the last joint's to the first's.
        ordered = itertools.chain.from_iterable(reversed(rates))
        return self.arithmetic.block(len(self._free), B.ncols(), list(ordered))

    def _articulated_joints(self, B: Matrix) -> "list[_ArticulatedJoint]":
        """The joints after pass 1: inertias I^A and bias impulses p^A from the leaves to the base.

        Args: B, (ny, m) the right side.
        """
        symmetric = self.arithmetic.symmetric
        parents = self.posed.system.robot.parents
        columns = self._columns_of_bodies()
        I_A = list(self._moments)
        p_A = [self.arithmetic.block(6, B.ncols())] * len(parents)
        joints: list[_ArticulatedJoint] = []
        for i in reversed(range(len(parents))):
            joint = self._articulated(i, columns[i], I_A[i], p_A[i], B)
            joints.append(joint)
            parent = parents[i]
            if parent >= 0:
                # I^a = I^A − U D⁻¹ Uᵀ,   p^a = p^A + U D⁻¹ u,   both about the parent's origin
                I_a = symmetric(I_A[i] - joint.U * joint.by_twist)
                p_a = p_A[i] + joint.U * joint.rates
                X_T = joint.X.transpose()
                I_A[parent] = I_A[parent] + symmetric(X_T * I_a * joint.X)
                p_A[parent] = p_A[parent] + X_T * p_a
        return joints[::-1]

    def _columns_of_bodies(self) -> list[slice]:
        """Where the free velocities of each body's joint are; those of the last body come first."""
        columns, end = [], 0
        for degrees in reversed(self._degrees):
            columns.append(slice(end, end + degrees))
            end += degrees
        return columns[::-1]

    def _articulated(
        self, body: int, columns: slice, I_A: Matrix, p_A: Matrix, B: Matrix
    ) -> "_ArticulatedJoint":
        """The quantities of a body's joint in pass 1.

        Args:
            body: its index.
            columns: of the joint, among the free velocities.
            I_A: (6, 6) articulated inertia of the body, about its joint's origin.
            p_A: (6, m) its bias impulse.
            B: (ny, m) the right side.
        """
        block = self.arithmetic.block
        origin = self._placements[body][1]
        parent = self.posed.system.robot.parents[body]
        X = block(6, 6)
        if parent >= 0:
            X = shift(self.arithmetic, origin - self._placements[parent][1]).transpose()
        if not self._degrees[body]:
            return _ArticulatedJoint(block(6, 0), block(6, 0), block(0, 6), block(0, B.ncols()), X)
        twists = block(self.state.J[0].T[self._free[columns]].tolist()).transpose()
        S = shift(self.arithmetic, origin).transpose() * twists
        # U = I^A S,   D = Sᵀ U + armature,   u = B − Sᵀ p^A
        U = I_A * S
        D = S.transpose() * U
        for k, inertia in enumerate(self.own_inertia[self._free[columns]].tolist()):
            D[k, k] += inertia
        u = block(B.table()[columns]) - S.transpose() * p_A
        # D⁻¹ Uᵀ and D⁻¹ u
        by_twist = solve(D, U.transpose(), of_inertia=True)
        return _ArticulatedJoint(S, U, by_twist, solve(D, u, of_inertia=True), X)


class _ArticulatedJoint(NamedTuple):
    """A joint in the articulated-body algorithm, with n free velocities.

    Attributes:
        S: (6, n) its motion subspace, about its own origin.
        U: (6, n) I^A S.
        by_twist: (n, 6) D⁻¹ Uᵀ: rates that a twist of the parent takes away.
        rates: (n, m) D⁻¹ u: rates while the parent rests.
        X: (6, 6) takes a twist of the parent to its own origin; zero where the world is the parent.
    """

    S: Matrix
    U: Matrix
    by_twist: Matrix
    rates: Matrix
    X: Matrix
