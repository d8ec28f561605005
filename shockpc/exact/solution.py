"""The impact of one landing in ball arithmetic: rows, impulses along them and the jump of every body.

Rows and recursions are those of double precision, evaluated on arrays of balls. Linear systems are solved by matrices of balls, in
the free velocities, the last joint's first. Along the tree the cost grows with the number of joints, not with its cube. Joints that
follow others couple its branches: H is eliminated then, in an order in which the tree's zeros stay zeros, each velocity in a unit
in which its inertia is about one, so that pivots stay on the diagonal. Both keep the balls narrow.
"""

from collections.abc import Sequence
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from flint import arb, arb_mat, ctx

from shockpc.core.bodies import body_jumps
from shockpc.core.impulse import RowChoice
from shockpc.core.spatial import Array, Plane, velocity_at
from shockpc.exact.balls import Balls, SingularError, balls, entries, matrix
from shockpc.exact.kinematics import Data, data_of, joint_inertia, posed, shift
from shockpc.model.columns import Base
from shockpc.model.motion import Motion, approach_speeds, twist_before
from shockpc.model.rows import Block, block_wrenches, row_jacobian, slices_of
from shockpc.robot.record import Robot

__all__ = ["ExactImpact", "Inputs"]

BASE = {"free": [True] * 6, "planar": [True, True, False, False, False, True], "fixed": [False] * 6}
"""Which velocities of a floating base are free: along the plane's first and second axis and its normal, then about them."""


class Inputs(NamedTuple):
    """All that an impact depends on besides the robot's own numbers; doubles, taken as exact.

    Attributes:
        robot: the robot.
        q: (nq,) configuration; balls where it lies between doubles.
        blocks: what is held.
        choice: which of its rows are independent.
        base: how the base may move.
        plane: in which a planar base moves.
        armature: (nv,) [kg m², kg].
        locked: (nv,) which joint velocities are held at zero.
        before: motion before the impact.
    """

    robot: Robot
    q: Array | Balls
    blocks: tuple[Block, ...]
    choice: RowChoice
    base: Base
    plane: Plane
    armature: Array
    locked: np.ndarray
    before: Motion


class ExactImpact:
    """An impact evaluated at the precision of the present context; what is derived is computed when it is read.

    Args:
        inputs: what it depends on.
        data: the robot's own numbers; by default as loaded.

    Raises:
        SingularError: no inertia resists a motion, the rows depend on one another, or the precision is too low to tell.
    """

    def __init__(self, inputs: Inputs, data: Data | None = None) -> None:
        robot = inputs.robot
        self.inputs, self.bits, self.slices = inputs, int(ctx.prec), slices_of(inputs.blocks)
        self.state, self._places, self._own_inertias = posed(robot, data or data_of(robot), inputs.q, inputs.plane)
        column = {joint.name: joint.v.start for joint in robot.single_joints}
        self._ties = [(column[m.joint], [(column[name], by) for name, by in m.leaders.items()]) for m in robot.mimics]
        free = ~inputs.locked
        if robot.free_base:
            free[:6] = BASE[inputs.base]
        free[[follower for follower, _ in self._ties]] = False
        self._free, flags = np.flatnonzero(free)[::-1], free.tolist()
        self._degrees = [sum(flags[joint.v]) for joint in robot.joints]
        self._unit = np.ones(len(self._free))
        if self._ties:
            H = joint_inertia(robot, self.state.J[0], self._inertias, inputs.armature)
            inertia = np.array([abs(float(H[k, k])) for k in self._free])
            # A product with a power of two is exact.
            self._unit = np.ldexp(1.0, -np.frexp(inertia)[1] // 2)
            self._H = matrix(self._reduced(self._reduced(H).T))

    def _reduced(self, rows: Balls) -> Balls:
        """Rows (n, nv) in the free velocities (n, ny): those that follow are parts of those that lead (Eq. 7)."""
        rows = rows.copy()
        for follower, leaders in reversed(self._ties):
            for leader, by in leaders:
                rows[:, leader] += rows[:, follower] * by
        return np.asarray(rows[:, self._free] * self._unit)

    def _full(self, rates: arb_mat) -> Balls:
        """All velocities (nv, m), those of a floating base in the axes of the plane. Args: rates (ny, m) of the free ones."""
        found = balls(np.zeros((len(self.inputs.locked), rates.ncols())))
        found[self._free] = entries(rates) * self._unit[:, None]
        for follower, leaders in self._ties:
            found[follower] = sum((found[leader] * by for leader, by in leaders), start=found[follower])
        return found

    def _in_base_axes(self, rates: Balls) -> Balls:
        """Velocities (nv, m) in Pinocchio's layout."""
        plane = self.inputs.plane
        if self.inputs.robot.free_base:
            turn = entries(self._places[0][0].transpose()) @ np.stack([plane.e1, plane.e2, plane.normal], axis=1)
            rates = np.concatenate([turn @ rates[:3], turn @ rates[3:6], rates[6:]])
        return rates

    @cached_property
    def _inertias(self) -> list[arb_mat]:
        """Inertias (6, 6) of the bodies about the base, world axes."""
        return [(T := shift(p)) * own * T.transpose() for (_, p), own in zip(self._places, self._own_inertias, strict=True)]

    def _bodies(self, rates: Balls, at: Balls) -> Balls:
        """Twists (nb, 6, m) of the bodies, world axes. Args: rates (nv, m); at (nb, 3) points at which they are written."""
        robot = self.inputs.robot
        return np.asarray(body_jumps(self.state.J, [joint.v for joint in robot.joints], robot.parents, at[None], rates[None])[0])

    @cached_property
    def _rows(self) -> Balls:
        """The landing's rows (nc, ny) in the free velocities."""
        blocks = self.inputs.blocks
        return self._reduced(row_jacobian(self.state, blocks)[0]) if blocks else np.zeros((0, len(self._free)))

    @cached_property
    def _solved(self) -> tuple[arb_mat, arb_mat]:
        """Jumps (ny, 4) of the free velocities and impulses (r, 4) along the independent rows (Eq. 4)."""
        rows = self.inputs.choice.rows.tolist()
        J = matrix(self._rows[rows])
        X = self._by_inertia(J.transpose())
        impulse = -_solve(J * X, matrix(self.speeds[rows]))
        return X * impulse, impulse

    @cached_property
    def speeds(self) -> Balls:
        """Speeds b (nc, 4) that the impact undoes along each row: for unit strikes along world x, y and z, and the scene's own."""
        return np.asarray(approach_speeds(self.state, self.inputs.blocks, self.inputs.before)[0])

    @cached_property
    def impulse(self) -> Balls:
        """Impulses (nc, 4) along all rows, of the ground on the robot [N s]."""
        spread = self.inputs.choice.spread
        return self.independent_impulse if spread.shape[0] == spread.shape[1] else entries(matrix(spread) * self._solved[1])

    @cached_property
    def independent_impulse(self) -> Balls:
        """Impulses (nc, 4) along the independent rows, and none along the others: they do the same to the robot [N s]."""
        found = balls(np.zeros((len(self.inputs.choice.spread), 4)))
        found[self.inputs.choice.rows] = entries(self._solved[1])
        return found

    @cached_property
    def delta_qd(self) -> Balls:
        """Jumps (nv, 4) of all joint velocities, Pinocchio's layout."""
        return self._in_base_axes(self._full(self._solved[0]))

    @cached_property
    def body_jumps(self) -> Balls:
        """Jump (nb, 6, 4) of every body (Δω, Δv) in body coordinates at its frame's origin (Eqs. 8 and 9)."""
        jumps = self._bodies(self._full(self._solved[0]), self.state.position[0])
        return np.asarray(np.swapaxes(self.orientations, -1, -2)[:, None] @ jumps.reshape(-1, 2, 3, 4)).reshape(-1, 6, 4)

    @property
    def orientations(self) -> Balls:
        """Rotations (nb, 3, 3) of the bodies' frames, body to world."""
        return np.asarray(self.state.rotation[0])

    @property
    def joint_origins(self) -> Balls:
        """Origins (nb, 3) of the frames of the bodies' joints, world axes, from the base [m]."""
        return np.array([p.entries() for _, p in self._places], dtype=object)

    def points(self, bodies: Sequence[int], r: Array | Balls) -> Balls:
        """Positions (n, 3) of points of bodies, world axes, from the base [m]. Args: r (n, 3) in the bodies' frames [m]."""
        bodies = list(bodies)
        return np.asarray(self.state.position[0, bodies] + (self.orientations[bodies] @ r[..., None])[..., 0])

    def velocities_before(self, bodies: Sequence[int], r: Array) -> Balls:
        """Velocities (n, 3) of points of bodies before the impact, world axes [m/s]. Args: as for `points`."""
        twists = np.array([twist_before(self.state, self.inputs.before, body)[0] for body in bodies])
        return np.asarray(velocity_at(twists[:, :3], twists[:, 3:], self.points(bodies, r)))

    @cached_property
    def kinetic_energy_before(self) -> Any:
        """½ Σ Vᵀ I V + ½ q̇ᵀ diag(armature) q̇ of the scene's own motion [J]."""
        before, total = self.inputs.before, arb(0)
        for i, inertia in enumerate(self._inertias):
            V = matrix(twist_before(self.state, before, i).T)
            total += (V.transpose() * inertia * V)[0, 0]
        return (total + np.sum(balls(self.inputs.armature) * balls(before.joint_rates) ** 2)) / 2

    @cached_property
    def joint_loads(self) -> Balls:
        """Wrench (nb, 6) that every body receives through its joint, about the base and in world axes, for the scene's own strike.

        Leaf to root F_i = I_i ΔV_i − f_i + Σ F_child. That of a free base is what is left over, and is zero.
        """
        parents = self.inputs.robot.parents
        twists = self._bodies(self._full(self._solved[0])[:, 3:], 0 * self.state.position[0])
        loads = np.array([(inertia * matrix(twist)).entries() for inertia, twist in zip(self._inertias, twists, strict=True)])
        for block, own in zip(self.inputs.blocks, self.slices, strict=True):
            wrench = self.impulse[own, 3] @ block_wrenches(self.state, block)[0]
            for body, sign in ((block.body, 1), (block.other, -1)):
                if body >= 0:
                    loads[body] -= sign * wrench
        for i in range(len(parents) - 1, 0, -1):
            if parents[i] >= 0:
                loads[parents[i]] += loads[i]
        return loads

    def mobility(self, block: Block, held: list[int]) -> arb_mat:
        """Delassus matrix (n, n) of the rows of a block while others stay held: J P Jᵀ, with P the inverse inertia on these [1/kg].

        Args:
            block: the rows, as a unit impulse each.
            held: indices of independent rows of the landing that stay held.

        Raises:
            SingularError: the held rows depend on one another.
        """
        J = matrix(self._reduced(row_jacobian(self.state, [block])[0]))
        return J * self._held_response(J, held)

    def rigid_mobility(self, block: Block) -> arb_mat:
        """The same (n, n) of the whole robot as one rigid body: every joint locked, the base free, and nothing held."""
        wrenches = matrix(block_wrenches(self.state, block)[0])
        return wrenches * _solve(sum(self._inertias, start=arb_mat(6, 6)), wrenches.transpose(), of_inertia=True)

    def held_velocities(self, body: int) -> Balls:
        """Jumps (nv, 6) of all joint velocities by unit moments and forces on a body, while the landing's rows stay held.

        The moments and forces are those whose power is each component of the body's twist (ω, v) in its own frame.

        Raises:
            SingularError: the rows depend on one another.
        """
        held = Block("stance", "", body, np.zeros(3), np.eye(3), np.eye(3), axes_body=body)
        # The rows of forces come first.
        J = matrix(self._reduced(np.roll(row_jacobian(self.state, [held])[0], 3, axis=0)))
        return self._in_base_axes(self._full(self._held_response(J, self.inputs.choice.rows.tolist())))

    def _held_response(self, J: arb_mat, held: list[int]) -> arb_mat:
        """Free velocities (ny, n) that unit impulses along rows J (n, ny) cause while some rows are held."""
        if not held:
            return self._by_inertia(J.transpose())
        R = matrix(self._rows[held])
        free, by_held = self._by_inertia(J.transpose()), self._by_inertia(R.transpose())
        return free - by_held * _solve(R * by_held, R * free)

    def _by_inertia(self, B: arb_mat) -> arb_mat:
        """H⁻¹ B (ny, m) by articulated-body inertias (Featherstone 2008, Chapter 7), or by elimination where joints follow others.

        Each inertia is about its joint's own origin: about a distant one its terms would cancel, and balls widen at every joint.
        """
        if self._ties:
            return _solve(self._H, B, of_inertia=True)
        parents, m, end = self.inputs.robot.parents, B.ncols(), 0
        twists, right, armature = self.state.J[0].T[self._free].tolist(), B.table(), self.inputs.armature[self._free].tolist()
        origins, inertia = [p for _, p in self._places], list(self._own_inertias)
        push, steps = [arb_mat(6, m)] * len(parents), []
        for i in range(len(parents) - 1, -1, -1):
            A, p, parent, own = inertia[i], push[i], parents[i], slice(end, end + self._degrees[i])
            S, W, rates, end = arb_mat(6, 0), arb_mat(0, 6), arb_mat(0, m), own.stop
            if self._degrees[i]:
                S = shift(origins[i]).transpose() * arb_mat(twists[own]).transpose()
                U, St = A * S, S.transpose()
                D = St * U
                for k, value in enumerate(armature[own]):
                    D[k, k] += value
                W, rates = _solve(D, U.transpose(), True), _solve(D, arb_mat(right[own]) - St * p, True)
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
        return arb_mat(end, m, [rate for own in reversed(found) for rate in own])


def _solve(A: arb_mat, B: arb_mat, of_inertia: bool = False) -> arb_mat:
    """A⁻¹ B."""
    try:
        return A.solve(B, algorithm="lu")
    except ZeroDivisionError:
        raise SingularError(of_inertia) from None
