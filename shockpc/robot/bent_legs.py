"""A posture for robots without one in which they stand: neutral, with those legs bent that are straight there.

A leg that is straight carries the strike to the trunk as a column does, and its posture is singular; no robot lands so.
"""

import math
import re
from collections.abc import Iterator

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array
from shockpc.robot.catalogue import closing_scene
from shockpc.robot.elements import Joint
from shockpc.robot.feet_and_sensors import each_foot, is_foot
from shockpc.robot.robot import Robot

ANGLE = math.radians(30.0)
"""By how much knees are bent, or as far as their limits allow."""

STRAIGHT = math.radians(15.0)
"""Angle of a knee up to which a leg counts as straight, such as where the limits of the knee leave out a straight leg."""

PARALLEL = math.radians(5.0)
"""Angle between axes up to which they count as parallel, and room of a knee up to which it has none."""

LEG_PART = r"(?i)ankle|leg(?!ro)|thigh|knee|calf|shank"
"""Names of parts of a leg; no finger of an "allegro" hand."""

SHORT_SHARE = 0.25
"""Share of the distance from a leg's first joint to its foot up to which a part of it is neither thigh nor shank."""


def bent_legs(robot: Robot) -> Array | None:
    """The neutral configuration (nq,) with straight legs bent by 30° at the knee; None where no leg can be.

    A leg is what `ends_leg` says. Its knee is the first joint whose axis is parallel to that of a joint before it, the hip, with a
    thigh between them and a shank beyond, which ends at the next joint with such an axis, the ankle, or at the foot. The knee turns
    to the side on which its limits leave more room, or forward; the hip turns so that the end of the shank stays on the line from
    the hip on which it was, and the ankle keeps the direction of the foot.
    """
    if robot.loops:
        return None
    placed, q = robot.joint_placements(robot.start), np.array(robot.start)
    for foot in each_foot(robot):
        if ends_leg(robot, foot):
            for joint, turn in _turns(robot, placed, foot):
                joint.set(joint.value(robot.start) + turn, q)
    robot.set_followers(q)
    # Limbs that a scene of the catalogue joins to one another cannot bend alone.
    return None if (q == robot.start).all() or closing_scene(robot.source.path) else q


def ends_leg(robot: Robot, foot: str, wheels: bool = True) -> bool:
    """Whether the limb of a foot is a leg: a link or joint of it is named like a foot, a part of a leg or, if asked, a wheel."""
    part = f"{LEG_PART}|wheel" if wheels else LEG_PART
    return any(is_foot(name) or re.search(part, name) for name in (foot, *_limb_names(robot, robot.frames[foot].body)))


def _limb_names(robot: Robot, body: int) -> Iterator[str]:
    """The names of the links and joints of a limb, from its last body to the first beyond the base."""
    while body > 0:
        yield from robot.bodies[body].links
        yield robot.joints[body].name
        body = robot.parents[body]


def _turns(robot: Robot, placed: list[pin.SE3], foot: str) -> Iterator[tuple[Joint, float]]:
    """The joints of a leg that turn, and by how much [rad]; none of a leg that is bent already, or has no knee."""
    frame = robot.frames[foot]
    body = robot.bodies[frame.body]
    end = placed[body.joint].act(body.offset + body.rotation @ frame.offset)
    leg: list[tuple[Joint, Array, Array]] = []  # joints, their axes and places, from the trunk
    number = frame.body
    while number >= 0:
        joint, place = robot.joints[number], placed[robot.bodies[number].joint]
        if joint.axis is not None and joint.kind in ("revolute", "continuous") and joint.name not in robot.followers:
            leg.insert(0, (joint, place.rotation @ joint.axis, np.array(place.translation)))
        number = robot.parents[number]
    for k, (knee, axis, at) in enumerate(leg):
        along = [(joint, float(axis @ other), place) for joint, other, place in leg]
        above, below = ([one for one in part if abs(one[1]) > math.cos(PARALLEL)] for part in (along[:k], along[k + 1 :]))
        if not above:
            continue
        hip, hip_sign, hip_place = above[-1]
        plane = np.eye(3) - np.outer(axis, axis)
        thigh, shank = plane @ (at - hip_place), plane @ ((below[0][2] if below else end) - at)
        if min(np.linalg.norm(thigh), np.linalg.norm(shank)) <= SHORT_SHARE * np.linalg.norm(end - leg[0][2]):
            continue
        room = _room(knee, robot.start)
        if abs(_angle(thigh, shank, axis)) > STRAIGHT or max(room) <= PARALLEL:
            return
        forward = np.cross(axis, thigh)[0] <= 0.0  # the knee goes forward as the hip turns back
        more = room[1] - room[0]
        side = 1.0 if more > PARALLEL or (abs(more) <= PARALLEL and forward) else -1.0
        bend = side * min(ANGLE, room[side > 0.0])
        back = -_angle(thigh + shank, thigh + pin.AngleAxis(bend, axis).toRotationMatrix() @ shank, axis)
        yield knee, bend
        yield hip, _within(math.copysign(back, back * hip_sign), _room(hip, robot.start))
        for ankle, ankle_sign, _ in below[:1]:
            yield ankle, _within(math.copysign(1.0, -ankle_sign) * (bend + back), _room(ankle, robot.start))
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
