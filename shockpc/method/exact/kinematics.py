"""A robot in one posture in an arithmetic, as the record of `method.dynamics`.

`method.dynamics` computes the same record in doubles with Pinocchio.

Every joint is split into elementary ones (a composite joint has several, with massless bodies
between them). The rotation through an elementary joint is affine in the sine and cosine of its
angle, and its place in its displacement. Twists (ω, v) and wrenches (moment, force) are written in
world axes at the base's origin, where those of different bodies may be added.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from shockpc.core.memo import memoized
from shockpc.core.spatial import Array, Plane, quaternion_of
from shockpc.method.dynamics import Dynamics
from shockpc.method.exact.arithmetic import Arithmetic, Matrix, Numbers, entries
from shockpc.robot.bodies_and_joints import Joint
from shockpc.robot.robot import Robot


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
    """The numbers of a robot as loaded.

    Rotation matrices become quaternions, so that they can be made exactly orthogonal.
    """
    parts = robot.single_joints
    axes = np.zeros((len(parts), 3))
    for k, part in enumerate(parts):
        if part.axis is not None:
            axes[k] = part.axis
    carried = [robot.model.inertias[body.joint] for body in robot.bodies]
    return Data(
        mass=np.array([float(rigid.mass) for rigid in carried]),
        lever=np.array([rigid.lever for rigid in carried]),
        inertia=np.array([rigid.inertia for rigid in carried]),
        rotation=np.array([quaternion_of(part.rotation) for part in parts]),
        offset=np.array([part.offset for part in parts]),
        axis=axes,
        body_rotation=np.array([quaternion_of(body.rotation) for body in robot.bodies]),
        body_offset=np.array([body.offset for body in robot.bodies]),
    )


class Kinematics(NamedTuple):
    """A robot in one posture.

    Attributes:
        state: Jacobian and placements of the bodies (N = 1), without H, which few robots need.
        placements: rotation (3, 3) and origin (3, 1) of the frame of each joint that carries a
            body.
        origins: (1, n, 3) of the frames of the elementary joints.
    """

    state: Dynamics
    placements: list[tuple[Matrix, Matrix]]
    origins: Numbers


def forward_kinematics(
    arithmetic: Arithmetic, robot: Robot, data: Data, q: Array | Numbers, plane: Plane
) -> Kinematics:
    """A robot in one posture, in an arithmetic.

    Args:
        arithmetic: that of the result; balls have the precision of the present context.
        robot: the robot.
        data: its numbers.
        q: (nq,) configuration in Pinocchio's layout, as doubles or numbers.
        plane: along and about whose axes the velocities of a floating base are counted.
    """
    q = arithmetic.numbers(q)
    joints = _joints(arithmetic, robot, data, q, plane)
    # The frame of a body is fixed to that of its joint, and is not the same.
    frames = _body_frames(arithmetic, robot, data, joints.placements)
    rotations = [R.table() for R, _ in frames]
    positions = [p.entries() for _, p in frames]
    state = Dynamics(
        inertia=np.zeros((1, 0, 0)),
        J=np.array(joints.twists, dtype=object).T[None],
        rotation=np.array(rotations, dtype=object)[None],
        position=np.array(positions, dtype=object)[None],
        origin=(q[:3] if robot.free_base else arithmetic.numbers(np.zeros(3)))[None],
        ancestors=robot.ancestors,
        Q=q[None],
    )
    origins = np.array(joints.origins, dtype=object)[None]
    return Kinematics(state, joints.placements, origins)


class _Joints(NamedTuple):
    """The joints of a robot in one posture.

    Attributes:
        placements: of the joints that carry a body, as of `Kinematics`.
        origins: (3,) of the frame of each elementary joint.
        twists: (6,) of each unit joint velocity.
    """

    placements: list[tuple[Matrix, Matrix]]
    origins: list[list[Any]]
    twists: list[list[Any]]


def _joints(arithmetic: Arithmetic, robot: Robot, data: Data, q: Numbers, plane: Plane) -> _Joints:
    """The joints from the base to the leaves: p ← p + R p_i and R ← R R_i for elementary joint i.

    Args: as of `forward_kinematics`.
    """
    result = _Joints([], [], [])
    constants = zip(data.rotation.tolist(), data.offset.tolist(), data.axis.tolist(), strict=True)
    for i, joint in enumerate(robot.joints):
        R, p = arithmetic.eye(3), arithmetic.block(3, 1)
        if joint.parent >= 0:
            R, p = result.placements[joint.parent]
        for part in joint.parts or (joint,):
            passed = _through(arithmetic, part, q[part.q], *next(constants))
            p = p + R * passed.origin
            R = R * passed.rotation
            if i == 0 and robot.free_base:
                # The base stands at the origin, and moves along and about the plane's axes.
                p = arithmetic.block(3, 1)
                slides = spins = arithmetic.matrix(np.stack([plane.e1, plane.e2, plane.normal], 1))
            else:
                slides, spins = R * passed.slides, R * passed.spins
            result.origins.append(p.entries())
            result.twists.extend(_twists(arithmetic, p, slides, spins))
        result.placements.append((R, p))
    return result


def _twists(arithmetic: Arithmetic, p: Matrix, slides: Matrix, spins: Matrix) -> list[list[Any]]:
    """Twists (ω, v) of unit displacements along axes (3, k), then of unit rotations about axes.

    The axes of rotation go through a point p (3, 1): v = p × a.
    """
    zero = arithmetic.number(0)
    twists = [[zero, zero, zero, *axis] for axis in slides.transpose().table()]
    moments = (arithmetic.cross_matrix(p) * spins).transpose().table()
    for axis, moment in zip(spins.transpose().table(), moments, strict=True):
        twists.append([*axis, *moment])
    return twists


def _body_frames(
    arithmetic: Arithmetic, robot: Robot, data: Data, placements: list[tuple[Matrix, Matrix]]
) -> list[tuple[Matrix, Matrix]]:
    """Rotation and origin of the frame of each body, of those of the joints that carry them."""
    if robot.body_frames is None:
        return placements
    frames: list[tuple[Matrix, Matrix]] = []
    in_joint = zip(data.body_rotation.tolist(), data.body_offset.tolist(), strict=True)
    for (R, p), (quaternion, r) in zip(placements, in_joint, strict=True):
        turned = R * _rotation(arithmetic, quaternion)
        frames.append((turned, p + R * arithmetic.column(r)))
    return frames


class _Passed(NamedTuple):
    """An elementary joint in its configuration, in the frame before it.

    Attributes:
        rotation: (3, 3) of its frame.
        origin: (3, 1) of it [m].
        slides: (3, k) axes of its displacements.
        spins: (3, k) axes of its rotations.
    """

    rotation: Matrix
    origin: Matrix
    slides: Matrix
    spins: Matrix


def _through(
    arithmetic: Arithmetic,
    joint: Joint,
    at: Numbers,
    quaternion: Sequence[float],
    offset: Sequence[float],
    axis: Sequence[float],
) -> _Passed:
    """An elementary joint in its configuration.

    Args:
        arithmetic: of the result.
        joint: its record.
        at: its configuration.
        quaternion: of its frame at rest.
        offset: (3,) origin of that.
        axis: (3,) of a joint of one coordinate.
    """
    rest = _rotation(arithmetic, quaternion)
    p = arithmetic.column(offset)
    nothing = arithmetic.block(3, 0)
    eye = arithmetic.eye(3)
    values = at.tolist()
    if joint.kind == "ball":
        return _Passed(rest * arithmetic.rotation(at), p, nothing, eye)
    if joint.kind == "free":
        moved = p + rest * arithmetic.column(values[:3])
        return _Passed(rest * arithmetic.rotation(at[3:]), moved, eye, eye)
    a = arithmetic.column([0.0, 0.0, 1.0] if joint.kind == "planar" else axis)
    a = a / (a.transpose() * a)[0, 0].sqrt()
    if joint.kind == "prismatic":
        return _Passed(rest, p + rest * a * values[0], a, nothing)
    sine, cosine = _sine_and_cosine(joint, values)
    # Rodrigues' formula: 1 cos φ + [a]× sin φ + a aᵀ (1 − cos φ)
    turn = eye * cosine + arithmetic.cross_matrix(a) * sine + a * a.transpose() * (1 - cosine)
    if joint.kind == "planar":
        moved = p + rest * arithmetic.column([*values[:2], 0])
        slides = arithmetic.block(3, 2, [1, 0, 0, 1, 0, 0])
        return _Passed(rest * turn, moved, slides, a)
    return _Passed(rest * turn, p, nothing, a)


def _sine_and_cosine(joint: Joint, values: list[Any]) -> tuple[Any, Any]:
    """Sine and cosine of a joint's angle, or its cosine and sine divided by their length."""
    if joint.kind == "revolute":
        sine, cosine = values[0].sin_cos()
        return sine, cosine
    cosine, sine = values[-2:]
    length = (cosine * cosine + sine * sine).sqrt()
    return sine / length, cosine / length


def _rotation(arithmetic: Arithmetic, quaternion: Sequence[float]) -> Any:
    return arithmetic.rotation(quaternion) if any(quaternion[:3]) else arithmetic.eye(3)


def shift(arithmetic: Arithmetic, r: Matrix) -> Any:
    """The matrix T (6, 6) for wrenches about a point r (3, 1) behind: T w.

    Twists go the other way by Tᵀ; inertias are T I Tᵀ.
    """
    T, (x, y, z) = arithmetic.eye(6), r.entries()
    T[0, 5], T[1, 3], T[2, 4] = y, z, x
    T[0, 4], T[1, 5], T[2, 3] = -z, -x, -y
    return T


def body_coms(arithmetic: Arithmetic, data: Data) -> Numbers:
    """Centres of mass (nb, 3) in the bodies' frames [m]."""
    levers = (arithmetic.numbers(data.lever) - data.body_offset).tolist()
    coms: list[list[Any]] = []
    for quaternion, lever in zip(data.body_rotation.tolist(), levers, strict=True):
        to_body = _rotation(arithmetic, quaternion).transpose()
        coms.append((to_body * arithmetic.column(lever)).entries())
    return np.array(coms, dtype=object)


def body_inertia(
    arithmetic: Arithmetic, mass: Any, lever: Array | Numbers, inertia: Array | Numbers, R: Matrix
) -> Any:
    """Inertia (6, 6) of a body about its joint's origin, world axes (Featherstone 2008, Eq. 2.63).

    Args:
        arithmetic: of the result.
        mass: [kg].
        lever: (3,) as in `Data`.
        inertia: (3, 3) as in `Data`.
        R: (3, 3) rotation of the joint's frame.
    """
    # [ R I Rᵀ − m C C,  m C ]
    # [ (m C)ᵀ,          m 1 ]
    C = arithmetic.cross_matrix(R * arithmetic.column(lever.tolist()))
    mC = C * arithmetic.number(mass)
    about_com = R * arithmetic.matrix(inertia) * R.transpose()
    a = arithmetic.symmetric(about_com - mC * C).entries()
    b = mC.entries()
    c = mC.transpose().entries()
    upper = [*a[:3], *b[:3], *a[3:6], *b[3:6], *a[6:], *b[6:]]
    lower = [*c[:3], mass, 0, 0, *c[3:6], 0, mass, 0, *c[6:], 0, 0, mass]
    return arithmetic.block(6, 6, [*upper, *lower])


def rotor_inertia(arithmetic: Arithmetic, coupling: float, axis: Numbers) -> Any:
    """Moments (6, 6) of a rotor's coupling about its axis (3,) in the bodies beside it.

    c a aᵀ and no forces, as `spatial_inertias` of `method.dynamics`.
    """
    zero = arithmetic.number(0)
    a = axis.tolist()
    entries: list[Any] = []
    for first in a:
        entries += [first * second * coupling for second in a]
        entries += [zero] * 3
    return arithmetic.block(6, 6, [*entries, *[zero] * 18])


def joint_inertia(
    arithmetic: Arithmetic, robot: Robot, J: Numbers, inertias: Sequence[Matrix], armature: Numbers
) -> Numbers:
    """Joint-space inertia H (nv, nv) in an arithmetic.

    H_ij = J_iᵀ F_j where velocity i also moves what velocity j moves, with F_j the momentum of all
    that j moves.

    Args:
        arithmetic: of the result.
        robot: the robot.
        J: (6, nv) twists of unit joint velocities.
        inertias: (6, 6) of each body.
        armature: (nv,) inertia of the joints that is in none of the bodies [kg m², kg].
    """
    composite = list(inertias)
    twists = J.T.tolist()
    H = np.zeros((len(armature), len(armature)), dtype=object)
    for i in reversed(range(len(composite))):
        v = robot.joints[i].v
        F = composite[i] * arithmetic.block(twists[v]).transpose()
        before = np.flatnonzero(robot.ancestors[i])
        H[before, v] = entries(arithmetic.block([twists[k] for k in before]) * F)
        H[v, before] = H[before, v].T
        parent = robot.parents[i]
        if parent >= 0:
            composite[parent] = composite[parent] + composite[i]
    H[np.diag_indices(len(H))] += armature
    return H
