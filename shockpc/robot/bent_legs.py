"""A posture for robots without one in which they stand: neutral, with those legs bent that are straight there.

A leg that is straight carries the strike to the trunk as a column does, and its posture is singular; no robot lands so.
"""

import math
import re
from collections.abc import Iterator

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array
from shockpc.robot.landmarks import LEG_END, each_foot, is_foot
from shockpc.robot.record import Joint, Robot

ANGLE = math.radians(30.0)
"""By how much knees are bent, or as far as their limits allow."""

STRAIGHT = math.radians(5.0)
"""Angle of a knee up to which a leg counts as straight."""

SHORT = 0.1
"""Share of the distance from a leg's first joint to its foot up to which a part of it is neither thigh nor shank."""


def bent_legs(robot: Robot) -> Array | None:
    """The neutral configuration (nq,) with straight legs bent by 30° at the knee; None where no leg can be.

    A leg ends in a link named like a foot, an ankle or a wheel. Its knee is the first joint whose axis is parallel to that of a
    joint before it, the hip, with a thigh between them and a shank beyond, which ends at the next joint with such an axis, the
    ankle, or at the foot. The knee turns to the side on which its limits leave more room, or forward; the hip turns so that the end
    of the shank stays on the line from the hip on which it was, and the ankle keeps the direction of the foot.
    """
    if robot.loops:
        return None
    data, q = robot.model.createData(), np.array(robot.start)
    pin.forwardKinematics(robot.model, data, robot.start)
    for foot in each_foot(robot):
        if any(is_foot(name) or re.search(LEG_END, name) for name in (foot, *robot.bodies[robot.frames[foot].body].links)):
            for joint, turn in _turns(robot, data, foot):
                joint.set(joint.value(robot.start) + turn, q)
    robot.set_followers(q)
    return None if (q == robot.start).all() else q


def _turns(robot: Robot, data: pin.Data, foot: str) -> Iterator[tuple[Joint, float]]:
    """The joints of a leg that turn, and by how much [rad]; none of a leg that is bent already, or has no knee."""
    followers, frame = {mimic.joint for mimic in robot.mimics}, robot.frames[foot]
    body, carrier = robot.bodies[frame.body], data.oMi[robot.bodies[frame.body].joint]
    end = carrier.act(body.offset + body.rotation @ frame.offset)
    chain, axes, places = [], [], []
    number = frame.body
    while number >= 0:
        joint, placement = robot.joints[number], data.oMi[robot.bodies[number].joint]
        if joint.axis is not None and joint.kind in ("revolute", "continuous") and joint.name not in followers:
            chain.insert(0, joint)
            axes.insert(0, placement.rotation @ joint.axis)
            places.insert(0, np.array(placement.translation))
        number = robot.parents[number]
    for k in range(1, len(chain)):
        axis = axes[k]
        along = [float(axis @ other) for other in axes]
        parallel = [i for i, cosine in enumerate(along) if abs(cosine) > math.cos(STRAIGHT)]
        at = parallel.index(k)
        if at == 0:
            continue
        hip, ankle = parallel[at - 1], next(iter(parallel[at + 1 :]), None)
        plane = np.eye(3) - np.outer(axis, axis)
        thigh, shank = plane @ (places[k] - places[hip]), plane @ ((end if ankle is None else places[ankle]) - places[k])
        if min(np.linalg.norm(thigh), np.linalg.norm(shank)) <= SHORT * np.linalg.norm(end - places[0]):
            continue
        room = _room(chain[k], robot.start)
        if abs(_angle(thigh, shank, axis)) > STRAIGHT or max(room) <= STRAIGHT:
            return
        forward = np.cross(axis, thigh)[0] <= 0.0  # as the hip turns back, by which the knee goes forward
        side = 1.0 if room[1] - room[0] > STRAIGHT or (abs(room[1] - room[0]) <= STRAIGHT and forward) else -1.0
        knee = side * min(ANGLE, room[side > 0.0])
        turned = pin.AngleAxis(knee, axis).toRotationMatrix() @ shank
        back = -_angle(thigh + shank, thigh + turned, axis)
        yield chain[k], knee
        yield chain[hip], _within(math.copysign(1.0, along[hip]) * back, _room(chain[hip], robot.start))
        if ankle is not None:
            yield chain[ankle], _within(-math.copysign(1.0, along[ankle]) * (knee + back), _room(chain[ankle], robot.start))
        return


def _room(joint: Joint, q: Array) -> tuple[float, float]:
    """How far a joint can turn to either side within its limits [rad]."""
    low, high = joint.limits if joint.kind == "revolute" else (-math.inf, math.inf)
    return joint.value(q) - low, high - joint.value(q)


def _within(turn: float, room: tuple[float, float]) -> float:
    return min(max(turn, -room[0]), room[1])


def _angle(first: Array, second: Array, axis: Array) -> float:
    """The angle about an axis from one vector to another [rad]."""
    return math.atan2(float(axis @ np.cross(first, second)), float(first @ second))
