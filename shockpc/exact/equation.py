"""Steps 1 and 2 in ball arithmetic: articulated-body inertias give H⁻¹ J_cᵀ (Eq. 4) and the jumps of the bodies at once.

With articulated-body inertias (Featherstone 2008, Chapter 7) the cost grows with the number of joints, not with its cube. A joint
that follows another is a row of its own, q̇_follower − multiplier · q̇_leader = 0; double precision leaves out its column (Eq. 7).
"""

from typing import NamedTuple

import numpy as np
from flint import arb, arb_mat

from shockpc.core.spatial import Array
from shockpc.exact.balls import matrix
from shockpc.exact.kinematics import Pose, Tree
from shockpc.model.rows import Block
from shockpc.robot.robot import Robot

__all__ = [
    "Articulated",
    "Factor",
    "Mechanism",
    "Response",
    "SingularError",
    "articulate",
    "block_axes",
    "block_point",
    "place_of",
    "respond",
    "wrenches",
]


class SingularError(ArithmeticError):
    """A pivot may be zero: no inertia resists a motion, rows depend on one another, or the precision is too low to tell.

    Attributes:
        body: index of the body whose joint no inertia resists; −1 if the rows are the cause.
    """

    def __init__(self, body: int = -1) -> None:
        super().__init__(body)
        self.body = body


class Mechanism(NamedTuple):
    """A robot in one posture with the joints that are free.

    Attributes:
        robot: the robot.
        tree: its elementary joints.
        poses: of these.
        S: (6, k) twists of the free velocities of each, in its own frame; None where it holds.
        v: the joint velocities that these are; for the three of a planar base −1.
        armature: of each of these velocities [kg m², kg].
        origin: (3,) position of the base in the world [m].
    """

    robot: Robot
    tree: Tree
    poses: list[Pose]
    S: list[arb_mat | None]
    v: list[list[int]]
    armature: list[list[arb]]
    origin: Array


class Factor(NamedTuple):
    """Articulated-body inertia of a node that is free to move.

    Attributes:
        S: (6, k) its free twists.
        U: (6, k) inertia times these.
        D: inverse (k, k) of their inertia.
        UD: U D⁻¹.
    """

    S: arb_mat
    U: arb_mat
    D: arb_mat
    UD: arb_mat


class Articulated(NamedTuple):
    """Articulated-body inertias of a mechanism: a factor for each node, None where it holds."""

    mechanism: Mechanism
    factors: list[Factor | None]


class Response(NamedTuple):
    """What impulses do to a mechanism, for m of them at once.

    Attributes:
        twists: (6, m) jump of each node in its own frame.
        rates: (k, m) jumps of its free velocities; k = 0 where it holds.
    """

    twists: list[arb_mat]
    rates: list[arb_mat]


def articulate(mechanism: Mechanism) -> Articulated:
    """Articulated-body inertias, leaf to root: I_a = I − U D⁻¹ Uᵀ with U = I S, D = Sᵀ U + armature.

    Raises:
        SingularError: D may be singular.
    """
    nodes, poses = mechanism.tree.nodes, mechanism.poses
    inertia = [node.inertia for node in nodes]
    factors: list[Factor | None] = [None] * len(nodes)
    for i in range(len(nodes) - 1, -1, -1):
        S, I_a, parent = mechanism.S[i], inertia[i], nodes[i].parent
        if S is not None:
            U = I_a * S
            own = S.transpose() * U
            for k, armature in enumerate(mechanism.armature[i]):
                own[k, k] += armature
            try:
                D = own.inv()
            except ZeroDivisionError:
                raise SingularError(nodes[i].body) from None
            factors[i] = factor = Factor(S, U, D, U * D)
            if parent >= 0:
                I_a = I_a - factor.UD * U.transpose()
        if parent >= 0:
            X = poses[i].X
            inertia[parent] = inertia[parent] + X.transpose() * I_a * X
    return Articulated(mechanism, factors)


def respond(articulated: Articulated, loads: dict[int, arb_mat], torques: dict[int, arb_mat], m: int) -> Response:
    """The jump that impulses cause, H⁻¹ (Jᵀ f + τ).

    Args:
        articulated: the mechanism.
        loads: (6, m) wrenches on nodes, in their own frames.
        torques: (k, m) on the free velocities of nodes.
        m: number of impulses.
    """
    mechanism = articulated.mechanism
    nodes, poses = mechanism.tree.nodes, mechanism.poses
    push: list[arb_mat | None] = [loads.get(i) for i in range(len(nodes))]
    drive: list[arb_mat | None] = [None] * len(nodes)
    for i in range(len(nodes) - 1, -1, -1):
        p, factor = push[i], articulated.factors[i]
        if factor is not None:
            u = torques.get(i)
            if p is not None:
                u = factor.S.transpose() * p if u is None else u + factor.S.transpose() * p
            drive[i] = u
            if u is not None and nodes[i].parent >= 0:
                left = factor.UD * u
                p = -left if p is None else p - left
        parent = nodes[i].parent
        if p is not None and parent >= 0:
            carried = poses[i].X.transpose() * p
            before = push[parent]
            push[parent] = carried if before is None else before + carried
    twists: list[arb_mat] = []
    rates: list[arb_mat] = []
    rest = arb_mat(6, m)
    for i, node in enumerate(nodes):
        before = twists[node.parent] if node.parent >= 0 else None
        twist = rest if before is None or before is rest else poses[i].X * before
        factor, u = articulated.factors[i], drive[i]
        rate = arb_mat(0 if factor is None else factor.S.ncols(), m)
        if factor is not None:
            if twist is not rest:
                held = factor.U.transpose() * twist
                u = -held if u is None else u - held
            if u is not None:
                rate = factor.D * u
                twist = factor.S * rate if twist is rest else twist + factor.S * rate
        twists.append(twist)
        rates.append(rate)
    return Response(twists, rates)


def wrenches(mechanism: Mechanism, block: Block) -> list[tuple[int, arb_mat]]:
    """The unit impulses of a block on its nodes, (6, n) each in the node's own frame.

    The point of the block is at P, its axes are a: a force is (r × a, a) with r from the node's origin to P, a moment (a, 0).
    """
    point, axes = block_point(mechanism, block), block_axes(mechanism, block)
    n = len(block.forces)
    found = []
    for body, sign in ((block.body, 1), (block.other, -1)):
        if body < 0:
            continue
        node = mechanism.tree.carrier[body]
        Rt = mechanism.poses[node].rotation.transpose()
        x, y, z = (Rt * (point - mechanism.poses[node].position)).entries()
        columns: list[list[arb]] = []
        for k, (a, b, c) in enumerate((Rt * axes * sign).transpose().table()):
            columns.append([y * c - z * b, z * a - x * c, x * b - y * a, a, b, c] if k < n else [a, b, c, *[arb(0)] * 3])
        found.append((node, arb_mat(columns).transpose()))
    return found


def block_point(mechanism: Mechanism, block: Block) -> arb_mat:
    """Position (3, 1) of the point of a block, world axes, from the base."""
    point = matrix(np.reshape(block.point, (3, 1)))
    if block.carrier < 0:
        return point - matrix(np.reshape(mechanism.origin, (3, 1)))
    rotation, position = place_of(mechanism, block.carrier)
    return rotation * point + position


def block_axes(mechanism: Mechanism, block: Block) -> arb_mat:
    """Axes (3, n + m) of the forces, then of the moments, in the world."""
    axes = matrix(np.concatenate([block.forces, block.moments]).T)
    return axes if block.axes_body < 0 else place_of(mechanism, block.axes_body)[0] * axes


def place_of(mechanism: Mechanism, body: int) -> tuple[arb_mat, arb_mat]:
    """Rotation (3, 3) to the world and position (3, 1) of a body's frame."""
    node = mechanism.tree.carrier[body]
    rotation, position = mechanism.poses[node].rotation, mechanism.poses[node].position
    place = mechanism.tree.frame_place[body]
    return (rotation, position) if place is None else (rotation * place[0], rotation * place[1] + position)
