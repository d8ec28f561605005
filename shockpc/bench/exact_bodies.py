"""A robot in a posture at full length: where its bodies stand, how its joints move, what they weigh.

Masses, inertias, joint placements and q are doubles in the model, and are taken as exact. Everything that follows from them is
computed anew with `DIGITS` digits; nothing is read from what the product has rounded on its way.
"""

from typing import Any, NamedTuple

import mpmath
import numpy as np
import pinocchio as pin
from mpmath import mp

from shockpc.bench.exact import Exact, Reader, cross, cross_matrix, quaternion, rotation_nearest, turn, unit, widen
from shockpc.landing import Landing
from shockpc.robot.robot import Robot
from shockpc.scene import Scene

__all__ = ["Mechanism", "Row", "free_bodies"]


class Row(NamedTuple):
    """Something that is held: a unit impulse, whose velocity is what it does work on.

    Attributes:
        wrench: moment about the world's origin and force (6,) on each body that it acts on, by the body's index.
        torque: generalised force on single joint rates, by (body, column): what ties a follower to its leader.
        b: speed to be undone.
    """

    wrench: dict[int, Exact]
    torque: dict[tuple[int, int], Any]
    b: Any


class Mechanism(NamedTuple):
    """Free bodies, joints and rows; world axes, twists (ω, v) written at the world's origin.

    Attributes:
        parent: index of the body that each body hangs on; −1 for the world.
        inertia: (6, 6) of each body, about the world's origin.
        S: (6, n) motion of each body against its parent for unit joint rates; n = 0 if its joint holds.
        armature: (n,) reflected inertia of those rates.
        rotation: (3, 3) of each body frame, body to world.
        position: (3,) of its origin.
        com: (3,) of the centre of mass.
        place: (body, column of S) of each joint velocity that may move.
        rows: what is held.
    """

    parent: tuple[int, ...]
    inertia: tuple[Exact, ...]
    S: tuple[Exact, ...]
    armature: tuple[Exact, ...]
    rotation: tuple[Exact, ...]
    position: tuple[Exact, ...]
    com: tuple[Exact, ...]
    place: dict[int, tuple[int, int]]
    rows: tuple[Row, ...] = ()


def free_bodies(robot: Robot, scene: Scene, landing: Landing, read: Reader) -> Mechanism:
    """Bodies and joints, nothing held yet. Call it, and all that follows, inside `mp.workdps(DIGITS)`.

    Args:
        robot: the robot.
        scene: the scene, complete.
        landing: of the scene; only what it read is used (q and the drives), nothing that it placed in the world.
        read: how lengths, angles and axes are read from the model.
    """
    model = robot.model
    q = read(landing.q)
    placed: list[tuple[Exact, Exact]] = [(widen(np.eye(3)), widen(np.zeros(3)))]
    parent, inertia, S, armature, rotation, position, com = [], [], [], [], [], [], []
    place: dict[int, tuple[int, int]] = {}
    for i, body in enumerate(robot.bodies):
        j = body.joint
        R, p = _onto(placed[model.parents[j]], model.jointPlacements[j], read)
        R, p, columns = _move(model.joints[j], R, p, q, read)
        placed.append((R, p))
        moves, numbers = _free_columns(robot, scene, landing, i, columns, p)
        place |= {v: (i, k) for k, v in enumerate(numbers) if v >= 0}
        S.append(moves)
        armature.append(widen(np.array([0.0 if v < 0 else landing.drives.armature[v] for v in numbers])))
        parent.append(int(model.parents[j]) - 1)
        own = model.inertias[j]
        c = p + R @ read(own.lever)
        inertia.append(_about_origin(mpmath.mpf(own.mass), c, R @ widen(own.inertia) @ R.T))
        rotation.append(R @ rotation_nearest(body.rotation, read))
        position.append(p + R @ read(body.offset))
        com.append(c)
    return Mechanism(tuple(parent), tuple(inertia), tuple(S), tuple(armature), tuple(rotation), tuple(position), tuple(com), place)


def _onto(base: tuple[Exact, Exact], step: pin.SE3, read: Reader) -> tuple[Exact, Exact]:
    """A placement after another."""
    R, p = base
    return R @ rotation_nearest(step.rotation, read), p + R @ read(step.translation)


def _move(joint: Any, R: Exact, p: Exact, q: Exact, read: Reader) -> tuple[Exact, Exact, list[Exact]]:
    """Carry a placement through a joint: where it ends, and the columns (6,) of its motion in the world, one for each velocity."""
    kind = joint.shortname()
    at = q[joint.idx_q : joint.idx_q + joint.nq]
    if kind == "JointModelComposite":
        columns: list[Exact] = []
        inner = joint.extract()
        for part, step in zip(inner.joints, inner.jointPlacements, strict=True):
            R, p = _onto((R, p), step, read)
            R, p, own = _move(part, R, p, q, read)
            columns += own
        return R, p, columns
    if kind == "JointModelFreeFlyer":
        p = p + R @ at[:3]
        R = R @ quaternion(at[3:])
        return R, p, [*_slides(R.T), *_turns(R.T, p)]
    if kind == "JointModelSpherical":
        R = R @ quaternion(at)
        return R, p, _turns(R.T, p)
    if kind == "JointModelPlanar":
        p = p + R @ np.array([at[0], at[1], mp.zero], dtype=object)
        R = R @ turn(widen(np.array([0.0, 0.0, 1.0])), *unit(at[2:]))
        return R, p, [*_slides(R.T[:2]), *_turns(R.T[2:], p)]
    data = joint.createData()
    joint.calc(data, np.zeros(joint.idx_q + joint.nq), np.zeros(joint.idx_v + joint.nv))
    twist = np.asarray(data.S, dtype=float).ravel()
    if twist[3:].any():
        axis = unit(read(twist[3:]))
        cosine, sine = unit(at) if joint.nq == 2 else (mp.cos(at[0]), mp.sin(at[0]))
        columns = _turns((R @ axis)[None], p)
        return R @ turn(axis, cosine, sine), p, columns
    axis = unit(read(twist[:3]))
    return R, p + R @ axis * at[0], _slides((R @ axis)[None])


def _turns(axes: Exact, p: Exact) -> list[Exact]:
    """Columns of rotations about axes (n, 3) through p: (a, p × a)."""
    return [np.concatenate([axis, cross(p, axis)]) for axis in axes]


def _slides(axes: Exact) -> list[Exact]:
    """Columns of translations along axes (n, 3): (0, a)."""
    return [np.concatenate([widen(np.zeros(3)), axis]) for axis in axes]


def _free_columns(robot: Robot, scene: Scene, landing: Landing, i: int, columns: list[Exact], p: Exact) -> tuple[Exact, list[int]]:
    """The columns of a body's joint that may move, and which joint velocity each is; −1 for the three of a planar base."""
    joint = robot.model.joints[robot.bodies[i].joint]
    base = robot.free_base and i == 0
    numbers = [joint.idx_v + k for k in range(joint.nv)]
    if base and scene.base == "fixed":
        kept = []
    elif base and scene.base == "planar":
        e1, e2, normal = (widen(v) for v in (landing.plane.e1, landing.plane.e2, landing.plane.normal))
        columns = [*_slides(np.stack([e1, e2])), *_turns(normal[None], p)]
        numbers, kept = [-1, -1, -1], [0, 1, 2]
    else:
        kept = [k for k, v in enumerate(numbers) if not landing.drives.locked[v]]
    S = np.stack([columns[k] for k in kept], axis=1) if kept else np.empty((6, 0), dtype=object)
    return S, [numbers[k] for k in kept]


def _about_origin(m: Any, c: Exact, I_c: Exact) -> Exact:
    """Spatial inertia (6, 6) about the world's origin of a mass m at c with I_c about c."""
    K = cross_matrix(c) * m
    shift = (widen(np.eye(3)) * (c @ c) - np.outer(c, c)) * m
    return np.block([[I_c + shift, K], [-K, widen(np.eye(3)) * m]])
