"""A robot in one posture in ball arithmetic: the same record that `model.dynamics` computes in doubles with Pinocchio.

Every joint is split into elementary ones (a composite joint has several, with massless bodies between them). The rotation through
an elementary joint is affine in the sine and cosine of its angle, and its place in its displacement. Twists (ω, v) and wrenches
(moment, force) are written in world axes at the base's origin, where those of different bodies may be added.
"""

from typing import Any, NamedTuple, TypeAlias

import numpy as np
from flint import arb, arb_mat

from shockpc.core.memo import memoized
from shockpc.core.spatial import Array, Plane, quaternion_of
from shockpc.impact.exact.balls import Balls, balls, cross_matrix, entries, matrix, rotation_matrix
from shockpc.landing.dynamics import Dynamics
from shockpc.robot.elements import Joint
from shockpc.robot.robot import Robot

Numbers: TypeAlias = list[float]

EYE, EYE_6 = matrix(np.eye(3)), matrix(np.eye(6))


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


@memoized()
def data_of(robot: Robot) -> Data:
    """The numbers of a robot as loaded. Rotation matrices become quaternions, so that they can be made exactly orthogonal."""
    parts = robot.single_joints
    carried = [robot.model.inertias[body.joint] for body in robot.bodies]
    return Data(
        mass=np.array([float(rigid.mass) for rigid in carried]),
        lever=np.array([rigid.lever for rigid in carried]),
        inertia=np.array([rigid.inertia for rigid in carried]),
        rotation=np.array([quaternion_of(part.rotation) for part in parts]),
        offset=np.array([part.offset for part in parts]),
        axis=np.array([np.zeros(3) if part.axis is None else part.axis for part in parts]),
        body_rotation=np.array([quaternion_of(body.rotation) for body in robot.bodies]),
        body_offset=np.array([body.offset for body in robot.bodies]),
    )


def forward_kinematics(
    robot: Robot, data: Data, q: Array | Balls, plane: Plane
) -> tuple[Dynamics, list[tuple[arb_mat, arb_mat]], Balls]:
    """A robot in one posture, at the precision of the present context.

    Args:
        robot: the robot.
        data: its numbers.
        q: (nq,) configuration in Pinocchio's layout, as doubles or balls.
        plane: along and about whose axes the velocities of a floating base are counted.

    Returns: Jacobian and placements of the bodies (N = 1), without H, which few robots need; rotation (3, 3) and origin (3, 1) of
        the frame of each joint that carries a body; and origins (1, n, 3) of the frames of the elementary joints.
    """
    q, numbers = balls(q), zip(data.rotation.tolist(), data.offset.tolist(), data.axis.tolist(), strict=True)
    axes = matrix(np.stack([plane.e1, plane.e2, plane.normal], axis=1))
    places: list[tuple[arb_mat, arb_mat]] = []
    origins: list[list[arb]] = []
    columns: list[list[arb]] = []
    for joint in robot.joints:
        R, p = places[joint.parent] if joint.parent >= 0 else (EYE, arb_mat(3, 1))
        for part in joint.parts or (joint,):
            base = robot.free_base and not places
            turned, moved, slides, spins = _through(part, q[part.q], *next(numbers))
            R, p = R * turned, arb_mat(3, 1) if base else p + R * moved
            origins.append(p.entries())
            slides, spins = (axes, axes) if base else (R * slides, R * spins)
            columns += [[*[arb(0)] * 3, *slide] for slide in slides.transpose().table()]
            levers = (cross_matrix(p) * spins).transpose().table()
            columns += [[*spin, *lever] for spin, lever in zip(spins.transpose().table(), levers, strict=True)]
        places.append((R, p))
    frames = places
    if robot.body_frames is not None:
        turns, offsets = data.body_rotation.tolist(), data.body_offset.tolist()
        frames = [(R * _rotation(turn), p + R * _column(r)) for (R, p), turn, r in zip(places, turns, offsets, strict=True)]
    state = Dynamics(
        np.zeros((1, 0, 0)),
        np.array(columns, dtype=object).T[None],
        np.array([R.table() for R, _ in frames], dtype=object)[None],
        np.array([p.entries() for _, p in frames], dtype=object)[None],
        (q[:3] if robot.free_base else balls(np.zeros(3)))[None],
        robot.ancestors,
        q[None],
    )
    return state, places, np.array(origins, dtype=object)[None]


def _through(
    joint: Joint, at: Balls, quaternion: Numbers, offset: Numbers, axis: Numbers
) -> tuple[arb_mat, arb_mat, arb_mat, arb_mat]:
    """An elementary joint: its frame (3, 3) and (3, 1) in the one before, and the axes (3, k) of its displacements and rotations.

    Args:
        joint: its record.
        at: its configuration.
        quaternion: of its frame at rest.
        offset: (3,) origin of that.
        axis: (3,) of a joint of one coordinate.
    """
    rest, p, nothing, values = _rotation(quaternion), _column(offset), arb_mat(3, 0), at.tolist()
    if joint.kind == "ball":
        return rest * rotation_matrix(at), p, nothing, EYE
    if joint.kind == "free":
        return rest * rotation_matrix(at[3:]), p + rest * arb_mat(3, 1, values[:3]), EYE, EYE
    a = _column([0.0, 0.0, 1.0] if joint.kind == "planar" else axis)
    a = a / (a.transpose() * a)[0, 0].sqrt()
    if joint.kind == "prismatic":
        return rest, p + rest * a * values[0], a, nothing
    if joint.kind == "revolute":
        sine, cosine = values[0].sin_cos()
    else:
        cosine, sine = values[-2:]
        length = (cosine * cosine + sine * sine).sqrt()
        cosine, sine = cosine / length, sine / length
    # Rodrigues' formula.
    turned = rest * (EYE * cosine + cross_matrix(a) * sine + a * a.transpose() * (1 - cosine))
    if joint.kind == "planar":
        return turned, p + rest * arb_mat(3, 1, [*values[:2], 0]), arb_mat(3, 2, [1, 0, 0, 1, 0, 0]), a
    return turned, p, nothing, a


def _rotation(quaternion: Numbers) -> arb_mat:
    return rotation_matrix(quaternion) if any(quaternion[:3]) else EYE


def _column(values: Numbers) -> arb_mat:
    return arb_mat(3, 1, values)


def shift(r: arb_mat) -> arb_mat:
    """The matrix T (6, 6) for wrenches about a point r (3, 1) behind: T w. Twists go the other way by Tᵀ; inertias are T I Tᵀ."""
    T, (x, y, z) = arb_mat(EYE_6), r.entries()
    T[0, 5], T[1, 3], T[2, 4] = y, z, x
    T[0, 4], T[1, 5], T[2, 3] = -z, -x, -y
    return T


def body_coms(data: Data) -> Balls:
    """Centres of mass (nb, 3) in the bodies' frames [m]."""
    turns = [_rotation(quaternion).transpose() for quaternion in data.body_rotation.tolist()]
    levers = balls(data.lever) - data.body_offset
    return np.array([(R * arb_mat(3, 1, lever)).entries() for R, lever in zip(turns, levers.tolist(), strict=True)], dtype=object)


def body_inertia(mass: Any, lever: Array | Balls, inertia: Array | Balls, R: arb_mat) -> arb_mat:
    """Inertia (6, 6) of a body about its joint's origin, world axes (Featherstone 2008, Eq. 2.63).

    Args:
        mass: [kg].
        lever: (3,) as in `Data`.
        inertia: (3, 3) as in `Data`.
        R: (3, 3) rotation of the joint's frame.
    """
    C = cross_matrix(R * _column(lever.tolist()))
    mC = C * arb(mass)
    a, b, c = (R * matrix(inertia) * R.transpose() - mC * C).entries(), mC.entries(), mC.transpose().entries()
    upper = [*a[:3], *b[:3], *a[3:6], *b[3:6], *a[6:], *b[6:]]
    return arb_mat(6, 6, [*upper, *c[:3], mass, 0, 0, *c[3:6], 0, mass, 0, *c[6:], 0, 0, mass])


def joint_inertia(robot: Robot, J: Balls, inertias: list[arb_mat], armature: Array) -> Balls:
    """H (nv, nv): H_ij = J_iᵀ F_j where velocity i also moves what velocity j moves, F_j the momentum of all that j moves.

    Args:
        robot: the robot.
        J: (6, nv) twists of unit joint velocities.
        inertias: (6, 6) of each body.
        armature: (nv,) reflected inertia of the joints [kg m², kg].
    """
    composite, columns, H = list(inertias), J.T.tolist(), np.zeros((len(armature), len(armature)), dtype=object)
    for i in range(len(composite) - 1, -1, -1):
        v, before = robot.joints[i].v, np.flatnonzero(robot.ancestors[i])
        H[before, v] = entries(arb_mat([columns[k] for k in before]) * (composite[i] * arb_mat(columns[v]).transpose()))
        H[v, before] = H[before, v].T
        if robot.parents[i] >= 0:
            composite[robot.parents[i]] = composite[robot.parents[i]] + composite[i]
    H[np.diag_indices(len(H))] += balls(armature)
    return H
