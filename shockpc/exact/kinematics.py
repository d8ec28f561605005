"""Kinematics of a robot in ball arithmetic: the transforms between its joints and the places of its bodies.

Every joint is split into elementary ones (a composite joint has several, with massless bodies between them), and the transform
through an elementary joint is affine in the sine and cosine of its angle, or in its displacement. Twists are (ω, v) and wrenches
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
        transform: the parts (6, 6) that add up to the transform of twists from the parent's frame into its own, with the factors
            of `factors`; for a joint that has a rotation of its own, the transform at rest.
        place: the same for homogeneous placements (4, 4) of its frame in the parent's.
        S: (6, n) twists of its unit velocities in its own frame.
        inertia: (6, 6) spatial inertia of its body in its own frame.
    """

    parent: int
    body: int
    joint: Joint
    transform: tuple[arb_mat, ...]
    place: tuple[arb_mat, ...]
    S: arb_mat
    inertia: arb_mat


class Tree(NamedTuple):
    """A robot at some precision.

    Attributes:
        nodes: the elementary joints, each after its parent.
        carrier: index of the node that carries each body.
        frame: transform (6, 6) of twists from that node's frame into the body's; None where they are the same.
        frame_place: placement (4, 4) of the body's frame in the node's; None where they are the same.
    """

    nodes: tuple[Node, ...]
    carrier: tuple[int, ...]
    frame: tuple[arb_mat | None, ...]
    frame_place: tuple[arb_mat | None, ...]


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
    frames, places = [], []
    for quaternion, offset in zip(data.body_rotation, data.body_offset, strict=True):
        same = not quaternion[:3].any() and not offset.any()
        R, p = rotation_matrix(quaternion), [arb(x) for x in offset.tolist()]
        frames.append(None if same else _transform(R, p))
        places.append(None if same else _homogeneous(R, p, 1))
    return Tree(tuple(nodes), tuple(carrier), tuple(frames), tuple(places))


def _node(parent: int, body: int, joint: Joint, data: Data, k: int, inertia: arb_mat) -> Node:
    """One elementary joint."""
    R, p = rotation_matrix(data.rotation[k]), [arb(x) for x in data.offset[k].tolist()]
    rest, place = _transform(R, p), _homogeneous(R, p, 1)
    zero = [arb(0)] * 3
    if joint.axis is None:
        planar = joint.kind == "planar"
        spins, slides = (EYE.table()[2:], EYE.table()[:2]) if planar else (EYE.table(), EYE.table())
        columns = [[*zero, *slide] for slide in slides] if joint.kind in ("free", "planar") else []
        columns += [[*spin, *zero] for spin in spins]
        return Node(parent, body, joint, (rest,), (place,), arb_mat(columns).transpose(), inertia)
    a = unit_vector(data.axis[k])
    if joint.kind == "prismatic":
        slide = blocks(arb_mat(3, 3), None, arb_mat(cross_matrix([-x for x in a])), arb_mat(3, 3)) * rest
        shift = place * _homogeneous(arb_mat(3, 3), a, 0)
        return Node(parent, body, joint, (rest, slide), (place, shift), arb_mat([zero + a]).transpose(), inertia)
    # Rodrigues' formula R = a aᵀ + cos (1 − a aᵀ) + sin [a]×; twists are turned by Rᵀ.
    along, K = arb_mat([[x * y for y in a] for x in a]), arb_mat(cross_matrix(a))
    turns = (along, EYE - along, K)
    return Node(
        parent,
        body,
        joint,
        tuple(blocks(T.transpose(), None, None, T.transpose()) * rest for T in turns),
        tuple(place * _homogeneous(T, zero, int(T is along)) for T in turns),
        arb_mat([a + zero]).transpose(),
        inertia,
    )


def _transform(R: arb_mat, p: list[arb]) -> arb_mat:
    """Transform (6, 6) of twists into a frame placed at (R, p): (Rᵀ ω, Rᵀ (v + ω × p))."""
    Rt = R.transpose()
    return blocks(Rt, None, Rt * arb_mat(cross_matrix([-x for x in p])), Rt)


def _homogeneous(R: arb_mat, p: list[arb], one: int) -> arb_mat:
    """The matrix [[R, p], [0, one]]."""
    return arb_mat([[*row, x] for row, x in zip(R.table(), p, strict=True)] + [[0, 0, 0, one]])


def _spatial_inertia(mass: float, lever: Array, inertia: Array) -> arb_mat:
    """Spatial inertia (6, 6) at the frame's origin of a mass with its inertia about its centre (Featherstone 2008, Eq. 2.63)."""
    m, C = arb(mass), arb_mat(cross_matrix([arb(x) for x in lever.tolist()]))
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
    homogeneous: list[arb_mat] = []
    for k, node in enumerate(tree.nodes):
        X, T = _through(node, q, free_base and k == 0)
        if node.parent >= 0:
            T = homogeneous[node.parent] * T
        homogeneous.append(T)
        a, b, c, _ = T.table()
        found.append(Pose(X, arb_mat([a[:3], b[:3], c[:3]]), arb_mat([a[3:], b[3:], c[3:]])))
    return found


def _through(node: Node, q: Array | Balls, base: bool) -> tuple[arb_mat, arb_mat]:
    """Transform of twists and placement through a joint."""
    kind, at = node.joint.kind, q[node.joint.q]
    if kind == "revolute" or kind == "continuous":
        if kind == "revolute":
            sine, cosine = arb(at[0]).sin_cos()
        else:
            c, s = arb(at[0]), arb(at[1])
            length = (c * c + s * s).sqrt()
            sine, cosine = s / length, c / length
        (X0, X1, X2), (T0, T1, T2) = node.transform, node.place
        return X0 + X1 * cosine + X2 * sine, T0 + T1 * cosine + T2 * sine
    if kind == "prismatic":
        d = arb(at[0])
        return node.transform[0] + node.transform[1] * d, node.place[0] + node.place[1] * d
    p = [arb(0)] * 3
    if kind == "planar":
        p = [arb(at[0]), arb(at[1]), arb(0)]
        c, s = arb(at[2]), arb(at[3])
        length = (c * c + s * s).sqrt()
        c, s = c / length, s / length
        R = arb_mat([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    else:
        R = rotation_matrix(at[-4:])
        if kind == "free" and not base:
            p = [arb(x) for x in at[:3].tolist()]
    return _transform(R, p) * node.transform[0], node.place[0] * _homogeneous(R, p, 1)
