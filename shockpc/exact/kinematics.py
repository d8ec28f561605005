"""Kinematics of a robot in ball arithmetic: the transforms between its joints and the places of its bodies.

Every joint is split into elementary ones (a composite joint has several, with massless bodies between them). The rotation through
an elementary joint is affine in the sine and cosine of its angle, and its place in its displacement. Twists are (ω, v) and wrenches
(moment, force), both written at the origin and in the axes of the joint's own frame (Featherstone 2008, Chapter 2).
"""

import functools
from typing import NamedTuple

import numpy as np
from flint import arb, arb_mat

from shockpc.core.spatial import Array, quaternion_of
from shockpc.exact.balls import Balls, blocks, cross_matrix, matrix, rotation_matrix, unit_vector
from shockpc.robot.robot import Joint, Robot

__all__ = ["Data", "Node", "Pose", "Tree", "data_of", "elementary", "loaded_tree", "poses", "tree_of"]

EYE = arb_mat(3, 3, [1, 0, 0, 0, 1, 0, 0, 0, 1])


class Data(NamedTuple):
    """The numbers of a robot that a result depends on; doubles, taken as exact.

    Attributes:
        mass: (nb,) [kg].
        lever: (nb, 3) centres of mass in the joints' frames [m].
        inertia: (nb, 3, 3) about the centres of mass, axes of the joints' frames [kg m²].
        rotation: (n, 4) quaternion of every elementary joint's frame at rest in the frame before.
        offset: (n, 3) its origin there [m].
        axis: (n, 3) axes of the elementary joints of one coordinate.
        body_rotation: (nb, 4) quaternion of every body's frame in its joint's frame.
        body_offset: (nb, 3) its origin there [m].
    """

    mass: Array
    lever: Array
    inertia: Array
    rotation: Array
    offset: Array
    axis: Array
    body_rotation: Array
    body_offset: Array


class Node(NamedTuple):
    """An elementary joint with what it carries, at some precision.

    Attributes:
        parent: index of the node before; −1 for the world.
        body: index of the body that it carries; −1 inside a composite joint.
        joint: its record.
        rotation: (3, 3) of its frame at rest in the parent's.
        offset: (3, 1) its origin there [m].
        parts: what its coordinate does to them: the rotation becomes parts[0] + parts[1] cos q + parts[2] sin q, or the origin
            moves by parts[0] q; empty for a joint of several coordinates.
        S: (6, n) twists of its unit velocities in its own frame.
        inertia: (6, 6) spatial inertia of its body in its own frame.
    """

    parent: int
    body: int
    joint: Joint
    rotation: arb_mat
    offset: arb_mat
    parts: tuple[arb_mat, ...]
    S: arb_mat
    inertia: arb_mat


class Tree(NamedTuple):
    """A robot at some precision.

    Attributes:
        nodes: the elementary joints, each after its parent.
        carrier: index of the node that carries each body.
        frame: transform (6, 6) of twists from that node's frame into the body's; None where they are the same.
        frame_place: rotation (3, 3) and origin (3, 1) of the body's frame in the node's; None where they are the same.
    """

    nodes: tuple[Node, ...]
    carrier: tuple[int, ...]
    frame: tuple[arb_mat | None, ...]
    frame_place: tuple[tuple[arb_mat, arb_mat] | None, ...]


class Pose(NamedTuple):
    """A node in one posture.

    Attributes:
        X: (6, 6) transform of twists from the parent's frame.
        rotation: (3, 3) to the world's axes.
        position: (3, 1) from the base [m].
    """

    X: arb_mat
    rotation: arb_mat
    position: arb_mat


def elementary(joint: Joint) -> tuple[Joint, ...]:
    """The elementary joints of a joint."""
    return tuple(part for inner in joint.parts for part in elementary(inner)) or (joint,)


@functools.lru_cache(maxsize=8)
def data_of(robot: Robot) -> Data:
    """The numbers of a robot as loaded. Rotation matrices become quaternions, so that they can be made exactly orthogonal."""
    parts: list[tuple[Array, Array, Joint]] = []
    for joint in robot.joints:
        inner = elementary(joint)
        parts += [(part.rotation, part.offset, part) for part in inner]
        if joint.parts:
            # The placement of a composite joint comes before that of its first part.
            rotation, offset = joint.rotation @ inner[0].rotation, joint.offset + joint.rotation @ inner[0].offset
            parts[-len(inner)] = (rotation, offset, inner[0])
    carried = [robot.model.inertias[body.joint] for body in robot.bodies]
    return Data(
        mass=np.array([float(own.mass) for own in carried]),
        lever=np.array([own.lever for own in carried]),
        inertia=np.array([own.inertia for own in carried]),
        rotation=np.array([quaternion_of(rotation) for rotation, _, _ in parts]),
        offset=np.array([offset for _, offset, _ in parts]),
        axis=np.array([np.zeros(3) if part.axis is None else part.axis for *_, part in parts]),
        body_rotation=np.array([quaternion_of(body.rotation) for body in robot.bodies]),
        body_offset=np.array([body.offset for body in robot.bodies]),
    )


@functools.lru_cache(maxsize=16)
def loaded_tree(robot: Robot, bits: int) -> Tree:
    """The tree of a robot as loaded. Args: bits of the context in which it is called."""
    del bits
    return tree_of(robot, data_of(robot))


def tree_of(robot: Robot, data: Data) -> Tree:
    """The tree of a robot with some numbers, at the precision of the present context."""
    nodes: list[Node] = []
    carrier: list[int] = []
    for i, joint in enumerate(robot.joints):
        parent = carrier[joint.parent] if joint.parent >= 0 else -1
        inner = elementary(joint)
        for part in inner:
            last = part is inner[-1]
            inertia = _spatial_inertia(data.mass[i], data.lever[i], data.inertia[i]) if last else arb_mat(6, 6)
            nodes.append(_node(parent, i if last else -1, part, data, len(nodes), inertia))
            parent = len(nodes) - 1
        carrier.append(parent)
    places: list[tuple[arb_mat, arb_mat] | None] = []
    for quaternion, offset in zip(data.body_rotation, data.body_offset, strict=True):
        same = not quaternion[:3].any() and not offset.any()
        places.append(None if same else (_rotation(quaternion), arb_mat(3, 1, offset.tolist())))
    frames = tuple(None if place is None else _transform(*place) for place in places)
    return Tree(tuple(nodes), tuple(carrier), frames, tuple(places))


def _node(parent: int, body: int, joint: Joint, data: Data, k: int, inertia: arb_mat) -> Node:
    """One elementary joint."""
    R, p = _rotation(data.rotation[k]), arb_mat(3, 1, data.offset[k].tolist())
    zero = [arb(0)] * 3
    if joint.axis is None:
        planar = joint.kind == "planar"
        spins, slides = (EYE.table()[2:], EYE.table()[:2]) if planar else (EYE.table(), EYE.table())
        columns = [[*zero, *slide] for slide in slides] if joint.kind in ("free", "planar") else []
        columns += [[*spin, *zero] for spin in spins]
        return Node(parent, body, joint, R, p, (), arb_mat(columns).transpose(), inertia)
    axis = unit_vector(data.axis[k])
    a = arb_mat(3, 1, axis)
    if joint.kind == "prismatic":
        return Node(parent, body, joint, R, p, (R * a,), arb_mat(6, 1, [*zero, *axis]), inertia)
    # Rodrigues' formula R = a aᵀ + cos (1 − a aᵀ) + sin [a]×.
    along = R * a * a.transpose()
    return Node(parent, body, joint, R, p, (along, R - along, R * cross_matrix(a)), arb_mat(6, 1, [*axis, *zero]), inertia)


def _rotation(quaternion: Array) -> arb_mat:
    """The rotation (3, 3) of a quaternion."""
    return rotation_matrix(quaternion) if quaternion[:3].any() else EYE


def _transform(R: arb_mat, p: arb_mat) -> arb_mat:
    """Transform (6, 6) of twists into a frame placed at (R, p): (Rᵀ ω, Rᵀ (v + ω × p))."""
    Rt = R.transpose()
    return blocks(Rt, None, Rt * cross_matrix(-p), Rt)


def _spatial_inertia(mass: float, lever: Array, inertia: Array) -> arb_mat:
    """Spatial inertia (6, 6) at the frame's origin of a mass with its inertia about its centre (Featherstone 2008, Eq. 2.63)."""
    m, C = arb(mass), cross_matrix(arb_mat(3, 1, lever.tolist()))
    mC = C * m
    return blocks(matrix(inertia) + mC * C.transpose(), mC, mC.transpose(), EYE * m)


def poses(tree: Tree, q: Array | Balls, free_base: bool) -> list[Pose]:
    """Every node in one posture.

    Args:
        tree: the robot.
        q: (nq,) configuration in Pinocchio's layout, as doubles or balls.
        free_base: whether the first joint is a floating base, from whose place positions are counted.
    """
    found: list[Pose] = []
    for k, node in enumerate(tree.nodes):
        R, p = _through(node, q, free_base and k == 0)
        X = _transform(R, p)
        if node.parent >= 0:
            before = found[node.parent]
            R, p = before.rotation * R, before.position + before.rotation * p
        found.append(Pose(X, R, p))
    return found


def _through(node: Node, q: Array | Balls, base: bool) -> tuple[arb_mat, arb_mat]:
    """Rotation (3, 3) and origin (3, 1) of a node's frame in its parent's."""
    kind, at = node.joint.kind, q[node.joint.q]
    if kind == "revolute" or kind == "continuous":
        if kind == "revolute":
            sine, cosine = arb(at[0]).sin_cos()
        else:
            c, s = arb(at[0]), arb(at[1])
            length = (c * c + s * s).sqrt()
            sine, cosine = s / length, c / length
        rest, even, odd = node.parts
        return rest + even * cosine + odd * sine, node.offset
    if kind == "prismatic":
        return node.rotation, node.offset + node.parts[0] * arb(at[0])
    p = arb_mat(3, 1)
    if kind == "planar":
        p = arb_mat(3, 1, [arb(at[0]), arb(at[1]), 0])
        c, s = arb(at[2]), arb(at[3])
        length = (c * c + s * s).sqrt()
        c, s = c / length, s / length
        R = arb_mat([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    else:
        R = rotation_matrix(at[-4:])
        if kind == "free" and not base:
            p = arb_mat(3, 1, [arb(x) for x in at[:3].tolist()])
    return node.rotation * R, node.offset + node.rotation * p
