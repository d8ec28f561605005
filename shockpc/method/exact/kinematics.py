"""A robot in one posture in an arithmetic: the same record that `method.dynamics` computes in
doubles with Pinocchio.

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
from shockpc.robot.elements import Joint
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
    arithmetic: Arithmetic, robot: Robot, data: Data, q: Array | Numbers, plane: Plane
) -> tuple[Dynamics, list[tuple[Matrix, Matrix]], Numbers]:
    """A robot in one posture, in an arithmetic.

    Args:
        arithmetic: that of the result; balls have the precision of the present context.
        robot: the robot.
        data: its numbers.
        q: (nq,) configuration in Pinocchio's layout, as doubles or numbers.
        plane: along and about whose axes the velocities of a floating base are counted.

    Returns: Jacobian and placements of the bodies (N = 1), without H, which few robots need;
        rotation (3, 3) and origin (3, 1) of the frame of each joint that carries a body; and
        origins (1, n, 3) of the frames of the elementary joints.
    """
    q = arithmetic.numbers(q)
    constants = zip(data.rotation.tolist(), data.offset.tolist(), data.axis.tolist(), strict=True)
    axes, zero = (
        arithmetic.matrix(np.stack([plane.e1, plane.e2, plane.normal], axis=1)),
        arithmetic.number(0),
    )
    places: list[tuple[Matrix, Matrix]] = []
    origins: list[list[Any]] = []
    columns: list[list[Any]] = []
    for joint in robot.joints:
        R, p = (
            places[joint.parent]
            if joint.parent >= 0
            else (arithmetic.eye(3), arithmetic.block(3, 1))
        )
        for part in joint.parts or (joint,):
            base = robot.free_base and not places
            turned, moved, slides, spins = _through(arithmetic, part, q[part.q], *next(constants))
            R, p = R * turned, arithmetic.block(3, 1) if base else p + R * moved
            origins.append(p.entries())
            slides, spins = (axes, axes) if base else (R * slides, R * spins)
            columns += [[*[zero] * 3, *slide] for slide in slides.transpose().table()]
            levers = (arithmetic.cross_matrix(p) * spins).transpose().table()
            columns += [
                [*spin, *lever]
                for spin, lever in zip(spins.transpose().table(), levers, strict=True)
            ]
        places.append((R, p))
    frames = places
    if robot.body_frames is not None:
        placed = zip(places, data.body_rotation.tolist(), data.body_offset.tolist(), strict=True)
        frames = [
            (R * _rotation(arithmetic, turn), p + R * arithmetic.column(r))
            for (R, p), turn, r in placed
        ]
    state = Dynamics(
        np.zeros((1, 0, 0)),
        np.array(columns, dtype=object).T[None],
        np.array([R.table() for R, _ in frames], dtype=object)[None],
        np.array([p.entries() for _, p in frames], dtype=object)[None],
        (q[:3] if robot.free_base else arithmetic.numbers(np.zeros(3)))[None],
        robot.ancestors,
        q[None],
    )
    return state, places, np.array(origins, dtype=object)[None]


def _through(
    arithmetic: Arithmetic,
    joint: Joint,
    at: Numbers,
    quaternion: Sequence[float],
    offset: Sequence[float],
    axis: Sequence[float],
) -> tuple[Any, Any, Any, Any]:
    """An elementary joint: its frame (3, 3) and (3, 1) in the one before, and the axes (3, k) of
    its displacements and rotations.

    Args:
        arithmetic: of the result.
        joint: its record.
        at: its configuration.
        quaternion: of its frame at rest.
        offset: (3,) origin of that.
        axis: (3,) of a joint of one coordinate.
    """
    rest, p, nothing, values = (
        _rotation(arithmetic, quaternion),
        arithmetic.column(offset),
        arithmetic.block(3, 0),
        at.tolist(),
    )
    eye = arithmetic.eye(3)
    if joint.kind == "ball":
        return rest * arithmetic.rotation(at), p, nothing, eye
    if joint.kind == "free":
        return (
            rest * arithmetic.rotation(at[3:]),
            p + rest * arithmetic.column(values[:3]),
            eye,
            eye,
        )
    a = arithmetic.column([0.0, 0.0, 1.0] if joint.kind == "planar" else axis)
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
    turned = rest * (
        eye * cosine + arithmetic.cross_matrix(a) * sine + a * a.transpose() * (1 - cosine)
    )
    if joint.kind == "planar":
        return (
            turned,
            p + rest * arithmetic.column([*values[:2], 0]),
            arithmetic.block(3, 2, [1, 0, 0, 1, 0, 0]),
            a,
        )
    return turned, p, nothing, a


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
    turns = [
        _rotation(arithmetic, quaternion).transpose() for quaternion in data.body_rotation.tolist()
    ]
    levers = (arithmetic.numbers(data.lever) - data.body_offset).tolist()
    return np.array(
        [(R * arithmetic.column(lever)).entries() for R, lever in zip(turns, levers, strict=True)],
        dtype=object,
    )


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
    C = arithmetic.cross_matrix(R * arithmetic.column(lever.tolist()))
    mC = C * arithmetic.number(mass)
    moments = arithmetic.symmetric(R * arithmetic.matrix(inertia) * R.transpose() - mC * C)
    a, b, c = moments.entries(), mC.entries(), mC.transpose().entries()
    upper = [*a[:3], *b[:3], *a[3:6], *b[3:6], *a[6:], *b[6:]]
    return arithmetic.block(
        6, 6, [*upper, *c[:3], mass, 0, 0, *c[3:6], 0, mass, 0, *c[6:], 0, 0, mass]
    )


def rotor_inertia(arithmetic: Arithmetic, coupling: float, axis: Numbers) -> Any:
    """Moments (6, 6) of a coupling about its axis (3,) in the bodies beside it, as
    `spatial_inertias` of `method.dynamics`.
    """
    x, y, z = axis.tolist()
    row = [arithmetic.number(0)] * 3
    moments = [[*(part * other * coupling for other in (x, y, z)), *row] for part in (x, y, z)]
    return arithmetic.block(
        6, 6, [entry for line in (*moments, *[row + row] * 3) for entry in line]
    )


def joint_inertia(
    arithmetic: Arithmetic, robot: Robot, J: Numbers, inertias: Sequence[Matrix], armature: Numbers
) -> Numbers:
    """H (nv, nv): H_ij = J_iᵀ F_j where velocity i also moves what velocity j moves, F_j the
    momentum of all that j moves.

    Args:
        arithmetic: of the result.
        robot: the robot.
        J: (6, nv) twists of unit joint velocities.
        inertias: (6, 6) of each body.
        armature: (nv,) inertia of the joints that is in none of the bodies [kg m², kg].
    """
    composite, columns, H = (
        list(inertias),
        J.T.tolist(),
        np.zeros((len(armature), len(armature)), dtype=object),
    )
    for i in range(len(composite) - 1, -1, -1):
        v, before = robot.joints[i].v, np.flatnonzero(robot.ancestors[i])
        momenta = composite[i] * arithmetic.block(columns[v]).transpose()
        H[before, v] = entries(arithmetic.block([columns[k] for k in before]) * momenta)
        H[v, before] = H[before, v].T
        if robot.parents[i] >= 0:
            composite[robot.parents[i]] = composite[robot.parents[i]] + composite[i]
    H[np.diag_indices(len(H))] += armature
    return H
