"""A scene's numbers at full length: what the reference works on.

Masses, inertias, joint placements, q and the contact points are doubles in the model, and are taken as exact. Everything that
follows from them (placements in the world, joint axes, rows) is computed anew with `DIGITS` digits, and nothing is read from what
the product has rounded on its way.
"""

from typing import Any, NamedTuple, TypeAlias

import mpmath
import numpy as np
import pinocchio as pin
from mpmath import mp
from numpy.typing import NDArray

from shockpc.core.spatial import Array
from shockpc.model.closure import loop_of
from shockpc.model.couplings import Loop
from shockpc.model.robot import Robot
from shockpc.scene import Scene
from shockpc.setting import Setting

__all__ = ["DIGITS", "Exact", "Mechanism", "Row", "cross", "mechanism", "widen"]

DIGITS = 100
"""Digits carried. The worst case of the suite loses thirty of them, so more than fifty are left."""

Exact: TypeAlias = NDArray[np.object_]
"""An array of mpmath numbers."""


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
        rows: what is held.
    """

    parent: tuple[int, ...]
    inertia: tuple[Exact, ...]
    S: tuple[Exact, ...]
    armature: tuple[Exact, ...]
    rotation: tuple[Exact, ...]
    position: tuple[Exact, ...]
    com: tuple[Exact, ...]
    rows: tuple[Row, ...]


def widen(values: Array) -> Exact:
    """Doubles as mpmath numbers, exactly."""
    flat = [mpmath.mpf(float(value)) for value in np.asarray(values, dtype=float).ravel()]
    out = np.empty(len(flat), dtype=object)
    out[:] = flat
    return out.reshape(np.shape(values))


def cross(a: Exact, b: Exact) -> Exact:
    """Vector product of two (3,)."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]], dtype=object)


def mechanism(robot: Robot, scene: Scene, setting: Setting) -> Mechanism:
    """Everything that the impact depends on. Call it, and all that follows, inside `mp.workdps(DIGITS)`.

    Args:
        robot: the robot.
        scene: the scene, complete.
        setting: of the scene; only what it read is used (q, contact points, drives), nothing that it placed in the world.
    """
    model = robot.model
    q = widen(setting.q)
    placed: list[tuple[Exact, Exact]] = [(widen(np.eye(3)), widen(np.zeros(3)))]
    parent, inertia, S, armature, rotation, position, com = [], [], [], [], [], [], []
    index: dict[int, tuple[int, int]] = {}
    for i, body in enumerate(robot.bodies):
        j = body.joint
        R, p = _onto(placed[model.parents[j]], model.jointPlacements[j])
        R, p, columns = _move(model.joints[j], R, p, q)
        placed.append((R, p))
        moves, numbers = _free_columns(robot, scene, setting, i, columns, p)
        for k, v in enumerate(numbers):
            index[v] = (i, k)
        S.append(moves)
        armature.append(widen(np.array([0.0 if v < 0 else setting.drives.armature[v] for v in numbers])))
        parent.append(int(model.parents[j]) - 1)
        own = model.inertias[j]
        c = p + R @ widen(own.lever)
        inertia.append(_about_origin(mpmath.mpf(own.mass), c, R @ widen(own.inertia) @ R.T))
        rotation.append(R @ _rotation(body.rotation))
        position.append(p + R @ widen(body.offset))
        com.append(c)
    found = Mechanism(tuple(parent), tuple(inertia), tuple(S), tuple(armature), tuple(rotation), tuple(position), tuple(com), ())
    before = _before(robot, setting, found, index)
    rows = [*_contact_rows(robot, scene, setting, found, before), *_stance_rows(robot, scene, found)]
    for loop in (*robot.loops, *(loop_of(robot, closure) for closure in scene.closure)):
        rows += _loop_rows(found, loop)
    return found._replace(rows=(*rows, *_mimic_rows(robot, index)))


def _rotation(values: Array) -> Exact:
    """The rotation nearest to nine doubles: Newton's iteration R ← R (3 − RᵀR) / 2, which squares what is left each time."""
    R = widen(values)
    if np.array_equal(values, np.eye(3)):
        return R
    for _ in range(4):
        R = np.asarray(R @ (3 * widen(np.eye(3)) - R.T @ R) / 2)
    return R


def _onto(base: tuple[Exact, Exact], step: pin.SE3) -> tuple[Exact, Exact]:
    """A placement after another."""
    R, p = base
    return R @ _rotation(step.rotation), p + R @ widen(step.translation)


def _turn(axis: Exact, cosine: Any, sine: Any) -> Exact:
    """Rotation about a unit axis (Rodrigues)."""
    x, y, z = axis
    K = np.array([[mp.zero, -z, y], [z, mp.zero, -x], [-y, x, mp.zero]], dtype=object)
    return np.asarray(widen(np.eye(3)) + sine * K + (1 - cosine) * (K @ K))


def _move(joint: Any, R: Exact, p: Exact, q: Exact) -> tuple[Exact, Exact, list[Exact]]:
    """Carry a placement through a joint: where it ends, and the columns (6,) of its motion in the world, one for each velocity."""
    kind = joint.shortname()
    at = q[joint.idx_q : joint.idx_q + joint.nq]
    if kind == "JointModelComposite":
        columns: list[Exact] = []
        inner = joint.extract()
        for part, step in zip(inner.joints, inner.jointPlacements, strict=True):
            R, p = _onto((R, p), step)
            R, p, own = _move(part, R, p, q)
            columns += own
        return R, p, columns
    if kind == "JointModelFreeFlyer":
        p = p + R @ at[:3]
        R = R @ _from_quaternion(at[3:])
        return R, p, [*_slides(R.T), *_turns(R.T, p)]
    if kind == "JointModelSpherical":
        R = R @ _from_quaternion(at)
        return R, p, _turns(R.T, p)
    if kind == "JointModelPlanar":
        p = p + R @ np.array([at[0], at[1], mp.zero], dtype=object)
        R = R @ _turn(widen(np.array([0.0, 0.0, 1.0])), *_unit(at[2:]))
        return R, p, [*_slides(R.T[:2]), *_turns(R.T[2:], p)]
    data = joint.createData()
    joint.calc(data, np.zeros(joint.idx_q + joint.nq), np.zeros(joint.idx_v + joint.nv))
    twist = np.asarray(data.S, dtype=float).ravel()
    if twist[3:].any():
        axis = _unit(widen(twist[3:]))
        cosine, sine = _unit(at) if joint.nq == 2 else (mp.cos(at[0]), mp.sin(at[0]))
        columns = _turns((R @ axis)[None], p)
        return R @ _turn(axis, cosine, sine), p, columns
    axis = _unit(widen(twist[:3]))
    return R, p + R @ axis * at[0], _slides((R @ axis)[None])


def _unit(values: Exact) -> Exact:
    """A vector at length one."""
    return np.asarray(values / mp.sqrt(values @ values))


def _from_quaternion(values: Exact) -> Exact:
    """Rotation of a quaternion (x, y, z, w), normalised first."""
    x, y, z, w = _unit(values)
    K = np.array([[mp.zero, -z, y], [z, mp.zero, -x], [-y, x, mp.zero]], dtype=object)
    return np.asarray(widen(np.eye(3)) + 2 * w * K + 2 * (K @ K))


def _turns(axes: Exact, p: Exact) -> list[Exact]:
    """Columns of rotations about axes (n, 3) through p: (a, p × a)."""
    return [np.concatenate([axis, cross(p, axis)]) for axis in axes]


def _slides(axes: Exact) -> list[Exact]:
    """Columns of translations along axes (n, 3): (0, a)."""
    return [np.concatenate([widen(np.zeros(3)), axis]) for axis in axes]


def _free_columns(robot: Robot, scene: Scene, setting: Setting, i: int, columns: list[Exact], p: Exact) -> tuple[Exact, list[int]]:
    """The columns of a body's joint that may move, and which joint velocity each is; −1 for the three of a planar base."""
    joint = robot.model.joints[robot.bodies[i].joint]
    base = robot.free_base and i == 0
    numbers = [joint.idx_v + k for k in range(joint.nv)]
    if base and scene.base == "fixed":
        kept = []
    elif base and scene.base == "planar":
        e1, e2, normal = (widen(v) for v in (setting.plane.e1, setting.plane.e2, setting.plane.normal))
        columns = [*_slides(np.stack([e1, e2])), *_turns(normal[None], p)]
        numbers, kept = [-1, -1, -1], [0, 1, 2]
    else:
        kept = [k for k, v in enumerate(numbers) if not setting.drives.locked[v]]
    S = np.stack([columns[k] for k in kept], axis=1) if kept else np.empty((6, 0), dtype=object)
    return S, [numbers[k] for k in kept]


def _about_origin(m: Any, c: Exact, I_c: Exact) -> Exact:
    """Spatial inertia (6, 6) about the world's origin of a mass m at c with I_c about c."""
    x, y, z = c
    K = m * np.array([[mp.zero, -z, y], [z, mp.zero, -x], [-y, x, mp.zero]], dtype=object)
    shift = m * ((c @ c) * widen(np.eye(3)) - np.outer(c, c))
    return np.block([[I_c + shift, K], [-K, m * widen(np.eye(3))]])


def _before(robot: Robot, setting: Setting, found: Mechanism, index: dict[int, tuple[int, int]]) -> list[Exact]:
    """Twist (6,) of every body before the impact."""
    omega, velocity = widen(setting.before.omega), widen(setting.before.velocity)
    origin = found.position[0] if robot.free_base else widen(np.zeros(3))
    base = np.concatenate([omega, velocity - cross(omega, origin)])
    twists: list[Exact] = []
    for i, p in enumerate(found.parent):
        twists.append(base if p < 0 else twists[p])
        for v, (body, k) in index.items():
            if body == i and setting.before.joint_rates[v] != 0.0:
                twists[i] = twists[i] + found.S[i][:, k] * mpmath.mpf(float(setting.before.joint_rates[v]))
    return twists


def _point(found: Mechanism, body: int, point: Exact) -> Exact:
    """A point of a body in the world; of the world itself for body −1."""
    return point if body < 0 else found.position[body] + found.rotation[body] @ point


def _force(point: Exact, axis: Exact) -> Exact:
    """Unit impulse along an axis at a point, as a wrench about the origin."""
    return np.concatenate([cross(point, axis), axis])


def _contact_rows(robot: Robot, scene: Scene, setting: Setting, found: Mechanism, before: list[Exact]) -> list[Row]:
    """Rows of the contacts: (1 + e) times what they approach with is undone."""
    rows = []
    for contact, touch in zip(scene.contact, setting.touches, strict=True):
        frame = robot.frame(contact.frame)
        point = widen(touch.point)
        if contact.at == "frame":
            point = widen(frame.offset) + _rotation(frame.rotation) @ widen(np.asarray(contact.offset))
        place = _point(found, touch.body, point)
        wrenches = [_force(place, axis) for axis in widen(touch.directions)]
        wrenches += [np.concatenate([axis, widen(np.zeros(3))]) for axis in widen(touch.turns)]
        undone = 1 + mpmath.mpf(float(touch.restitution))
        rows += [Row({touch.body: wrench}, {}, undone * (wrench @ before[touch.body])) for wrench in wrenches]
    return rows


def _stance_rows(robot: Robot, scene: Scene, found: Mechanism) -> list[Row]:
    """Rows of the feet that stay where they are."""
    rows = []
    for name in scene.stance:
        frame = robot.frame(name)
        place = _point(found, frame.body, widen(frame.offset))
        rows += [Row({frame.body: _force(place, axis)}, {}, mp.zero) for axis in widen(np.eye(3))]
    return rows


def _loop_rows(found: Mechanism, loop: Loop) -> list[Row]:
    """Rows of a loop: its ends may not part along the axes of its first end."""
    frame = _rotation(loop.rotations[0])
    if loop.bodies[0] >= 0:
        frame = found.rotation[loop.bodies[0]] @ frame
    places = [_point(found, body, widen(point)) for body, point in zip(loop.bodies, loop.points, strict=True)]
    pairs = [[_force(place, frame @ axis) for place in places] for axis in widen(loop.axes)]
    if loop.turns:
        pairs += [[np.concatenate([frame @ axis, widen(np.zeros(3))])] * 2 for axis in widen(np.eye(3))]
    rows = []
    for a, b in pairs:
        wrench: dict[int, Exact] = {}
        for body, part in ((loop.bodies[0], a), (loop.bodies[1], -b)):
            if body >= 0:
                wrench[body] = part
        rows.append(Row(wrench, {}, mp.zero))
    return rows


def _mimic_rows(robot: Robot, index: dict[int, tuple[int, int]]) -> list[Row]:
    """Rows q̇_follower − multiplier · q̇_leader = 0: both rates are kept and tied here, where the product leaves one out."""
    velocity = {robot.model.names[body.joint]: robot.model.joints[body.joint].idx_v for body in robot.bodies}
    rows = []
    for mimic in robot.mimics:
        follower = index.get(velocity[mimic.joint])
        if follower is None:
            continue
        torque = {follower: mp.one}
        leader = index.get(velocity.get(mimic.leader, -1))
        if leader is not None:
            torque[leader] = -mpmath.mpf(float(mimic.multiplier))
        rows.append(Row({}, torque, mp.zero))
    return rows
