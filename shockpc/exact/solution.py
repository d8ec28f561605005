"""The impact of one landing in ball arithmetic: rows, impulses along them and the jump of every body."""

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np
from flint import arb, arb_mat, ctx

from shockpc.core.impulse import RowChoice
from shockpc.core.spatial import Array, Plane, velocity_at
from shockpc.exact.balls import Balls, balls, matrix
from shockpc.exact.equation import Mechanism, Response, SingularError, articulate, place_of, respond, wrenches
from shockpc.exact.kinematics import Tree, poses
from shockpc.model.columns import Base
from shockpc.model.motion import Motion
from shockpc.model.rows import Block, slices_of
from shockpc.robot.robot import Robot

__all__ = ["ExactImpact", "Inputs", "beside", "cross_columns", "free_mechanism", "stacked", "work"]


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


def free_mechanism(inputs: Inputs, tree: Tree) -> Mechanism:
    """The robot in its posture, with the velocities that are free."""
    robot, found = inputs.robot, poses(tree, inputs.q, inputs.robot.free_base)
    locked, armature = inputs.locked.copy(), [arb(value) for value in inputs.armature.tolist()]
    shift = arb(robot.mass)
    for mimic in robot.mimics:
        follower = robot.joint(mimic.joint).v.start
        leaders = {robot.joint(name).v.start: by for name, by in mimic.leaders.items() if not locked[robot.joint(name).v.start]}
        if not leaders:
            locked[follower] = True
        if len(leaders) != 1:
            continue
        ((leader, multiplier),) = leaders.items()
        # Armature may move from a leader to its follower without any effect on motions in which one follows the other. It keeps
        # D invertible where the follower carries no inertia of its own. Powers of π cancel neither one another nor an inertia, as
        # doubles do: a massless joint in the middle of a chain of followers with multiplier 1 would give away all that it gets.
        shift *= arb.pi()
        armature[follower] += shift
        armature[leader] -= arb(multiplier) ** 2 * shift
    S: list[arb_mat | None] = []
    v: list[list[int]] = []
    for k, node in enumerate(tree.nodes):
        columns = list(range(node.joint.v.start, node.joint.v.stop))
        own: arb_mat | None = node.S
        if k == 0 and robot.free_base and inputs.base != "free":
            columns, own = ([-1, -1, -1], _planar(inputs.plane, found[0].rotation)) if inputs.base == "planar" else ([], None)
        else:
            kept = [c for c, column in enumerate(columns) if not locked[column]]
            if len(kept) < len(columns):
                own = arb_mat([node.S.transpose().table()[c] for c in kept]).transpose() if kept else None
                columns = [columns[c] for c in kept]
        S.append(own)
        v.append(columns)
    arm = [[arb(0) if column < 0 else armature[column] for column in columns] for columns in v]
    return Mechanism(robot, tree, found, S, v, arm, np.asarray(inputs.q[:3], dtype=float) if robot.free_base else np.zeros(3))


def _planar(plane: Plane, rotation: arb_mat) -> arb_mat:
    """Twists (6, 3) of a base that translates in a plane and rotates about its normal, in the base's own frame."""
    axes = (rotation.transpose() * matrix(np.stack([plane.e1, plane.e2, plane.normal], axis=1))).transpose().table()
    zero = [arb(0)] * 3
    return arb_mat([[*zero, *axes[0]], [*zero, *axes[1]], [*axes[2], *zero]]).transpose()


class ExactImpact:
    """An impact evaluated at the precision of the present context; what is derived is computed when it is read.

    Args:
        inputs: what it depends on.
        tree: the robot at this precision.

    Raises:
        SingularError: no inertia resists a motion, the rows depend on one another, or the precision is too low to tell.
    """

    def __init__(self, inputs: Inputs, tree: Tree) -> None:
        self.inputs, self.bits = inputs, int(ctx.prec)
        self.mechanism = free_mechanism(inputs, tree)
        self.articulated = articulate(self.mechanism)
        self.slices = slices_of(inputs.blocks)

    @cached_property
    def wrenches(self) -> list[list[tuple[int, arb_mat]]]:
        """The unit impulses of each block on the nodes that it acts on."""
        return [wrenches(self.mechanism, block) for block in self.inputs.blocks]

    @cached_property
    def _solved(self) -> tuple[Response, arb_mat]:
        """What unit impulses along the independent rows and the ties do, and how large (m, 4) the impact's are (Eq. 4)."""
        rows = self.inputs.choice.rows.tolist()
        loads, torques, m = self._unit_impulses(rows)
        response = respond(self.articulated, loads, torques, m)
        if not m:
            return response, arb_mat(0, 4)
        speeds = self.speeds.table()
        right = arb_mat([speeds[row] for row in rows] + [[arb(0)] * 4] * (m - len(rows)))
        try:
            return response, -work(response, loads, torques, m).solve(right)
        except ZeroDivisionError:
            raise SingularError from None

    def _unit_impulses(self, rows: list[int]) -> tuple[dict[int, arb_mat], dict[int, arb_mat], int]:
        """Unit impulses along some rows, then those that tie followers to leaders: wrenches, torques and their number."""
        ties = self._ties()
        m = len(rows) + len(ties)
        columns: dict[int, list[list[arb]]] = {}
        place = {row: k for k, row in enumerate(rows)}
        for own, found in zip(self.slices, self.wrenches, strict=True):
            for node, wrench in found:
                for row, column in zip(range(own.start, own.stop), wrench.transpose().table(), strict=True):
                    if row in place:
                        columns.setdefault(node, [[arb(0)] * 6] * m)
                        columns[node] = [*columns[node][: place[row]], column, *columns[node][place[row] + 1 :]]
        loads = {node: arb_mat(found).transpose() for node, found in columns.items()}
        torques: dict[int, arb_mat] = {}
        for k, tie in enumerate(ties):
            for node, factor in tie:
                torques.setdefault(node, arb_mat(1, m))[0, len(rows) + k] = arb(factor)
        return loads, torques, m

    def _ties(self) -> list[list[tuple[int, float]]]:
        """For each follower that is free: its node with the factor 1, and those of its free leaders with −multiplier."""
        robot, mechanism = self.inputs.robot, self.mechanism
        node = {found.joint.name: k for k, found in enumerate(mechanism.tree.nodes)}
        ties = [
            [
                (node[name], factor)
                for name, factor in ({mimic.joint: 1.0} | {name: -by for name, by in mimic.leaders.items()}).items()
            ]
            for mimic in robot.mimics
        ]
        return [
            [(k, factor) for k, factor in tie if mechanism.S[k] is not None] for tie in ties if mechanism.S[tie[0][0]] is not None
        ]

    @cached_property
    def twists_before(self) -> list[arb_mat]:
        """Twist (6, 4) of every node before the impact in its own frame: unit velocities along x, y and z, and the scene's own."""
        before, mechanism = self.inputs.before, self.mechanism
        world = np.zeros((6, 4))
        world[3:, :3] = np.eye(3)
        world[:3, 3], world[3:, 3] = before.omega, before.velocity
        omega, v = matrix(world[:3]), matrix(world[3:])
        spin = cross_columns(omega)
        found: list[arb_mat] = []
        moving = before.joint_rates.any()
        for node, pose in zip(mechanism.tree.nodes, mechanism.poses, strict=True):
            Rt = pose.rotation.transpose()
            twist = stacked(Rt * omega, Rt * (v + spin(pose.position)))
            if moving:
                # The rates of the joints before and of its own; those of a floating base are part of the world's motion.
                if node.parent >= 0:
                    twist = pose.X * found[node.parent]
                rates = before.joint_rates[node.joint.v]
                if rates.any() and not (self.inputs.robot.free_base and not found):
                    twist = twist + node.S * matrix(np.concatenate([np.zeros((len(rates), 3)), rates[:, None]], axis=1))
            found.append(twist)
        return found

    @cached_property
    def body_twists_before(self) -> Balls:
        """Twist (nb, 6) of every body before the impact in its own frame, for the scene's own motion."""
        tree = self.mechanism.tree
        carried = [self.twists_before[node] for node in tree.carrier]
        found = [twist if frame is None else frame * twist for twist, frame in zip(carried, tree.frame, strict=True)]
        return np.array([twist.table() for twist in found], dtype=object)[..., 3]

    @cached_property
    def body_jumps(self) -> Balls:
        """The jumps (nb, 6, 4) as an array."""
        return np.array([jump.table() for jump in self.jumps], dtype=object)

    @cached_property
    def speeds(self) -> arb_mat:
        """Speeds b (nc, 4) that the impact undoes along each row: for unit strikes along world x, y and z, and the scene's own."""
        rows: list[list[arb]] = []
        for block, found in zip(self.inputs.blocks, self.wrenches, strict=True):
            if block.kind != "contact":
                rows += [[arb(0)] * 4] * block.size
                continue
            (node, wrench), *_ = found
            rows += (wrench.transpose() * self.twists_before[node] * (1 + arb(block.restitution))).table()
        return arb_mat(rows)

    @cached_property
    def impulse(self) -> arb_mat:
        """Impulses (nc, 4) along all rows, of the ground on the robot [N s]."""
        r = len(self.inputs.choice.rows)
        chosen = arb_mat(self._solved[1].table()[:r])
        return chosen if r == len(self.inputs.choice.spread) else matrix(self.inputs.choice.spread) * chosen

    @cached_property
    def independent_impulse(self) -> arb_mat:
        """Impulses (nc, 4) along the independent rows, and none along the others: they do the same to the robot [N s]."""
        found = [[arb(0)] * 4 for _ in range(len(self.inputs.choice.spread))]
        for row, own in zip(self.inputs.choice.rows.tolist(), self._solved[1].table(), strict=False):
            found[row] = own
        return arb_mat(found)

    @cached_property
    def node_jumps(self) -> list[arb_mat]:
        """Jump (6, 4) of every node's twist in its own frame."""
        return [twist * self._solved[1] for twist in self._solved[0].twists]

    @cached_property
    def jumps(self) -> list[arb_mat]:
        """Jump (Δω, Δv), (6, 4), of every body in body coordinates at its frame's origin (Eqs. 8 and 9)."""
        tree = self.mechanism.tree
        carried = [self.node_jumps[node] for node in tree.carrier]
        return [jump if frame is None else frame * jump for jump, frame in zip(carried, tree.frame, strict=True)]

    @cached_property
    def delta_qd(self) -> list[list[arb]]:
        """Jumps (nv, 4) of all joint velocities, Pinocchio's layout."""
        response, impulse = self._solved
        return self._velocities(Response(self.node_jumps, [rate * impulse for rate in response.rates]), 4)

    def _velocities(self, response: Response, m: int) -> list[list[arb]]:
        """All joint velocities (nv, m) of a response to m impulses, Pinocchio's layout."""
        found = [[arb(0)] * m for _ in range(self.inputs.robot.model.nv)]
        for rate, v, twist in zip(response.rates, self.mechanism.v, response.twists, strict=True):
            if rate.nrows() and v[0] < 0:
                # A planar base: its twist in its own frame, linear part first.
                found[:6] = [*twist.table()[3:], *twist.table()[:3]]
                continue
            for column, row in zip(v, rate.table(), strict=True):
                found[column] = row
        return found

    @cached_property
    def places(self) -> list[tuple[arb_mat, arb_mat]]:
        """Rotation (3, 3) to the world and position (3, 1) from the base of every body's frame."""
        return [place_of(self.mechanism, body) for body in range(len(self.inputs.robot.bodies))]

    def points(self, bodies: Sequence[int], r: Array | Balls) -> Balls:
        """Positions (n, 3) of points of bodies, world axes, from the base [m]. Args: r (n, 3) in the bodies' frames [m]."""
        places = (self.places[body] for body in bodies)
        found = [(R * matrix(point[:, None]) + p).entries() for (R, p), point in zip(places, r, strict=True)]
        return np.array(found, dtype=object).reshape(-1, 3)

    def velocities_before(self, bodies: Sequence[int], r: Array) -> Balls:
        """Velocities (n, 3) of points of bodies before the impact, world axes [m/s]. Args: as for `points`."""
        twists = self.body_twists_before[list(bodies)]
        local = velocity_at(twists[:, :3], twists[:, 3:], balls(r))
        return np.asarray(np.sum(self.orientations[list(bodies)] * local[:, None], axis=-1))

    @cached_property
    def orientations(self) -> Balls:
        """Rotations (nb, 3, 3) of the bodies' frames, body to world."""
        return np.array([R.table() for R, _ in self.places], dtype=object)

    @cached_property
    def kinetic_energy_before(self) -> arb:
        """½ Σ Vᵀ I V + ½ q̇ᵀ diag(armature) q̇ of the scene's own motion [J]."""
        total = arb(0)
        for node, twist in zip(self.mechanism.tree.nodes, self.twists_before, strict=True):
            V = arb_mat([[row[3]] for row in twist.table()])
            total += (V.transpose() * node.inertia * V)[0, 0]
        for rate, armature in zip(self.inputs.before.joint_rates.tolist(), self.inputs.armature.tolist(), strict=True):
            total += arb(armature) * arb(rate) * arb(rate)
        return total / 2

    @cached_property
    def joint_loads(self) -> list[arb_mat]:
        """Wrench (6, 1) that every node receives from its parent, in its own frame, leaf to root: F_i = I_i ΔV_i − f_i + Σ F_child.

        For the scene's own strike. The wrench of a free base is what is left over, and is zero.
        """
        nodes, posed = self.mechanism.tree.nodes, self.mechanism.poses
        last = matrix([[0.0], [0.0], [0.0], [1.0]])
        found = [node.inertia * (jump * last) for node, jump in zip(nodes, self.node_jumps, strict=True)]
        for own, wrenches_ in zip(self.slices, self.wrenches, strict=True):
            impulse = arb_mat([[row[3]] for row in self.impulse.table()[own]])
            for node, wrench in wrenches_:
                found[node] = found[node] - wrench * impulse
        for i in range(len(nodes) - 1, -1, -1):
            parent = nodes[i].parent
            if parent >= 0:
                found[parent] = found[parent] + posed[i].X.transpose() * found[i]
        return found

    def mobility(self, block: Block, held: list[int]) -> arb_mat:
        """Delassus matrix (n, n) of the rows of a block while others stay held: J P Jᵀ, with P the inverse inertia on these [1/kg].

        Args:
            block: the rows, as a unit impulse each.
            held: indices of independent rows of the landing that stay held.

        Raises:
            SingularError: the held rows depend on one another.
        """
        (node, wrench), *_ = wrenches(self.mechanism, block)
        return wrench.transpose() * self._held_response(node, wrench, held).twists[node]

    def held_velocities(self, body: int) -> list[list[arb]]:
        """Jumps (nv, 6) of all joint velocities by unit moments and forces on a body, while the landing's rows stay held.

        The moments and forces are those whose power is each component of the body's twist (ω, v) in its own frame.

        Raises:
            SingularError: the rows depend on one another.
        """
        tree = self.mechanism.tree
        frame = tree.frame[body]
        wrench = matrix(np.eye(6)) if frame is None else frame.transpose()
        return self._velocities(self._held_response(tree.carrier[body], wrench, self.inputs.choice.rows.tolist()), 6)

    def _held_response(self, node: int, wrench: arb_mat, held: list[int]) -> Response:
        """What wrenches (6, n) on a node cause while some rows, and joints that follow others, are held."""
        n = wrench.ncols()
        loads, torques, m = self._unit_impulses(held)
        everything = {}
        for k in {node, *loads}:
            left = wrench if k == node else arb_mat(6, n)
            right = loads.get(k, arb_mat(6, m))
            everything[k] = beside(left, right)
        torques = {k: beside(arb_mat(torque.nrows(), n), torque) for k, torque in torques.items()}
        response = respond(self.articulated, everything, torques, n + m)
        if not m:
            return response
        speeds = work(response, everything, torques, n + m).table()[n:]
        across, A = (arb_mat([row[part] for row in speeds]) for part in (slice(n), slice(n, None)))
        try:
            impulse = A.solve(across)
        except ZeroDivisionError:
            raise SingularError from None

        def relieved(found: arb_mat) -> arb_mat:
            table = found.table()
            own, other = (
                arb_mat(len(table), k, [x for row in table for x in row[part]]) for k, part in ((n, slice(n)), (m, slice(n, None)))
            )
            return own - other * impulse

        return Response([relieved(twist) for twist in response.twists], [relieved(rate) for rate in response.rates])


def work(response: Response, loads: dict[int, arb_mat], torques: dict[int, arb_mat], m: int) -> arb_mat:
    """Velocity (m, m) along each of m impulses that each of them causes."""
    total = arb_mat(m, m)
    for node, load in loads.items():
        total = total + load.transpose() * response.twists[node]
    for node, torque in torques.items():
        total = total + torque.transpose() * response.rates[node]
    return total


def stacked(upper: arb_mat, lower: arb_mat) -> arb_mat:
    """One matrix above another."""
    return arb_mat([*upper.table(), *lower.table()])


def beside(left: arb_mat, right: arb_mat) -> arb_mat:
    """One matrix beside another."""
    return arb_mat([[*a, *b] for a, b in zip(left.table(), right.table(), strict=True)]) if right.ncols() else left


def cross_columns(omega: arb_mat) -> Callable[[arb_mat], arb_mat]:
    """The function r (3, 1) → ω × r (3, k) of columns ω (3, k)."""
    x, y, z = omega.table()

    def spin(r: arb_mat) -> arb_mat:
        a, b, c = r.entries()
        return arb_mat(
            [
                [p * c - q * b for p, q in zip(y, z, strict=True)],
                [q * a - o * c for q, o in zip(z, x, strict=True)],
                [o * b - p * a for o, p in zip(x, y, strict=True)],
            ]
        )

    return spin
