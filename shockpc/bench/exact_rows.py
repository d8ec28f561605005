"""What is held, at full length: contacts, feet that stand, loops, followers."""

import mpmath
import numpy as np
from mpmath import mp

from shockpc.bench.exact import Exact, Reader, cross, rotation_nearest, widen
from shockpc.bench.exact_bodies import Mechanism, Row, free_bodies
from shockpc.landing import Landing
from shockpc.model.closure import loop_of
from shockpc.robot.couplings import Loop
from shockpc.robot.robot import Robot
from shockpc.scene import Scene

__all__ = ["mechanism"]


def mechanism(robot: Robot, scene: Scene, landing: Landing, read: Reader = widen) -> Mechanism:
    """Everything that the impact depends on; arguments as for `free_bodies`. Call it inside `mp.workdps(DIGITS)`.

    Contact points given by a frame and an offset are placed anew; those sought on the geometry are taken as found.
    """
    found = free_bodies(robot, scene, landing, read)
    before = _before(robot, landing, found)
    rows = [*_contact_rows(robot, scene, landing, found, before, read), *_stance_rows(robot, scene, found, read)]
    for loop in (*robot.loops, *(loop_of(robot, closure) for closure in scene.closure)):
        rows += _loop_rows(found, loop, read)
    return found._replace(rows=(*rows, *_mimic_rows(robot, found.place)))


def _before(robot: Robot, landing: Landing, found: Mechanism) -> list[Exact]:
    """Twist (6,) of every body before the impact."""
    omega, velocity = widen(landing.before.omega), widen(landing.before.velocity)
    origin = found.position[0] if robot.free_base else widen(np.zeros(3))
    base = np.concatenate([omega, velocity - cross(omega, origin)])
    twists: list[Exact] = []
    for i, p in enumerate(found.parent):
        twists.append(base if p < 0 else twists[p])
        for v, (body, k) in found.place.items():
            if body == i and landing.before.joint_rates[v] != 0.0:
                twists[i] = twists[i] + found.S[i][:, k] * mpmath.mpf(float(landing.before.joint_rates[v]))
    return twists


def _point(found: Mechanism, body: int, point: Exact) -> Exact:
    """A point of a body in the world; of the world itself for body −1."""
    return point if body < 0 else found.position[body] + found.rotation[body] @ point


def _force(point: Exact, axis: Exact) -> Exact:
    """Unit impulse along an axis at a point, as a wrench about the origin."""
    return np.concatenate([cross(point, axis), axis])


def _contact_rows(robot: Robot, scene: Scene, landing: Landing, found: Mechanism, before: list[Exact], read: Reader) -> list[Row]:
    """Rows of the contacts: (1 + e) times what they approach with is undone."""
    rows = []
    for contact, touch in zip(scene.contact, landing.touches, strict=True):
        frame = robot.frame(contact.frame)
        point = read(touch.point)
        if contact.at == "frame":
            point = read(frame.offset) + rotation_nearest(frame.rotation, read) @ read(np.asarray(contact.offset))
        place = _point(found, touch.body, point)
        wrenches = [_force(place, axis) for axis in widen(touch.directions)]
        wrenches += [np.concatenate([axis, widen(np.zeros(3))]) for axis in widen(touch.turns)]
        undone = 1 + mpmath.mpf(float(touch.restitution))
        rows += [Row({touch.body: wrench}, {}, undone * (wrench @ before[touch.body])) for wrench in wrenches]
    return rows


def _stance_rows(robot: Robot, scene: Scene, found: Mechanism, read: Reader) -> list[Row]:
    """Rows of the feet that stay where they are."""
    rows = []
    for name in scene.stance:
        frame = robot.frame(name)
        place = _point(found, frame.body, read(frame.offset))
        rows += [Row({frame.body: _force(place, axis)}, {}, mp.zero) for axis in widen(np.eye(3))]
    return rows


def _loop_rows(found: Mechanism, loop: Loop, read: Reader) -> list[Row]:
    """Rows of a loop: along the axes of its first end, the first body goes where the second end goes."""
    frame = rotation_nearest(loop.rotations[0], read)
    if loop.bodies[0] >= 0:
        frame = found.rotation[loop.bodies[0]] @ frame
    end = _point(found, loop.bodies[1], read(loop.points[1]))
    wrenches = [_force(end, frame @ axis) for axis in widen(loop.axes)]
    if loop.turns:
        wrenches += [np.concatenate([frame @ axis, widen(np.zeros(3))]) for axis in widen(np.eye(3))]
    rows = []
    for unit in wrenches:
        wrench: dict[int, Exact] = {}
        for body, part in ((loop.bodies[0], unit), (loop.bodies[1], -unit)):
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
