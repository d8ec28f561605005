"""A posture for robots without one in which they stand.

Straight legs are bent, with level feet under the hips.

A leg that is straight carries the strike to the trunk as a column does, and its posture is
singular; no robot lands so.
"""

import math
import re
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array
from shockpc.robot.bodies_and_joints import Frame, Joint
from shockpc.robot.catalogue import closing_scene
from shockpc.robot.feet_and_sensors import each_foot, is_foot
from shockpc.robot.robot import Robot
from shockpc.robot.shapes.lowest import lowest_in_postures
from shockpc.robot.shapes.striking import striking

ANGLE = math.radians(30.0)
"""By how much knees are bent, or as far as their limits allow."""

STRAIGHT = math.radians(15.0)
"""Angle of a knee up to which a leg counts as straight."""

PARALLEL = math.radians(5.0)
"""Angle between axes up to which they count as parallel, and room of a knee up to which it has
none.
"""

LEG_PART = r"(?i)ankle|leg(?!ro)|thigh|femur|knee|calf|shank|shin|tibia"
"""Names of parts of a leg; no finger of an "allegro" hand."""

SHORT_SHARE = 0.25
"""Share of the distance from a leg's first joint to its foot up to which a part is neither thigh
nor shank.
"""

DOWN = np.array([0.0, 0.0, -1.0])
"""Downward, world axes."""


class Axis(NamedTuple):
    """A joint of a limb that turns, with all joints at zero.

    Attributes:
        joint: the joint.
        direction: (3,) of its axis, unit length, world axes.
        origin: (3,) in the world [m].
    """

    joint: Joint
    direction: Array
    origin: Array


class Hinge(NamedTuple):
    """A joint of a leg whose axis is parallel to that of the knee.

    Its angles are about the knee's axis [rad].

    Attributes:
        joint: the joint.
        sign: 1 if its axis points as that of the knee does, -1 if the other way.
        start: its angle in the neutral posture: zero, or the limit nearest to zero.
        low: smallest angle.
        high: largest angle.
    """

    joint: Joint
    sign: float
    start: float
    low: float
    high: float

    def clamped(self, angle: float) -> float:
        """The angle within the limits that is nearest to a given one."""
        return min(max(angle, self.low), self.high)


class Leg(NamedTuple):
    """A leg with all joints at zero, in the plane across the axis of its knee.

    Attributes:
        axis: (3,) of the knee, unit length, world axes.
        thigh: (3,) from hip to knee [m].
        shank: (3,) from knee to ankle, or to the foot if there is no ankle [m].
        hip: the last hinge before the knee that has a thigh between them.
        knee: the knee.
        ankle: the next hinge beyond it; None if there is none.
    """

    axis: Array
    thigh: Array
    shank: Array
    hip: Hinge
    knee: Hinge
    ankle: Hinge | None


def bent_legs(robot: Robot) -> Array | None:
    """The neutral configuration (nq,) with straight legs bent and feet level under the hips.

    None if no joint turns.

    A leg is what `ends_leg` says. Its knee is the first joint whose axis is parallel to that of a
    joint before it, the hip, with a thigh between them and a shank beyond. The shank ends at the
    next such joint, the ankle, or at the foot.
    """
    if robot.loops:
        return None
    q = np.array(robot.start)
    placements = robot.joint_placements(_at_zero(robot))
    for foot in each_foot(robot):
        if not ends_leg(robot, foot):
            continue
        leg = _leg_of(robot, placements, robot.frames[foot])
        if leg is None:
            continue
        for hinge, angle in zip((leg.hip, leg.knee, leg.ankle), stance_of(leg), strict=True):
            if hinge is not None and angle != hinge.start:
                hinge.joint.set(hinge.sign * angle, q)
    robot.set_followers(q)
    # Limbs that a scene of the catalogue joins to one another cannot bend alone.
    return None if (q == robot.start).all() or closing_scene(robot.source.path) else q


def stance_of(leg: Leg) -> tuple[float, float, float]:
    """The angles of hip, knee and ankle about the axis of the knee [rad].

    They are from zero and within their limits.

    A knee that is straight in the neutral posture is bent by 30° from there; a bent one stays. Then

        hip = -angle(thigh + shank, thigh + R shank)   with R the rotation by the angle of the knee,
        ankle = -(hip + knee),

    so that the shank ends on its line from the hip, and the foot is as level, as with all joints at
    zero. If a limit of the ankle leaves the foot tilted, the hip levels it; if a limit of the hip
    still does, the knee.
    """
    knee = _knee_angle(leg)
    hip = leg.hip.clamped(_hip_angle(leg, knee))
    if leg.ankle is None:
        return hip, knee, 0.0
    level = -(hip + knee)
    ankle = leg.ankle.clamped(level)
    if ankle != level:
        hip = leg.hip.clamped(-(knee + ankle))
        knee = leg.knee.clamped(-(hip + ankle))
    return hip, knee, ankle


def _knee_angle(leg: Leg) -> float:
    """The angle of the knee [rad]: as in the neutral posture, or bent.

    A leg that is straight in the neutral posture is bent by 30° more.

    It bends to the side on which its limits leave more room, and without limits to negative angles
    of its joint, as those of quadrupeds do. If the limits leave the same, it goes forward, unless a
    limit of the hip then keeps the foot farther from its line than on the other side.
    """
    knee = leg.knee
    below, above = knee.start - knee.low, knee.high - knee.start
    is_bent = abs(_angle(leg.thigh, _turned(leg, knee.start), leg.axis)) > STRAIGHT
    if is_bent or max(below, above) <= PARALLEL:
        return knee.start
    less, more = knee.start - min(ANGLE, below), knee.start + min(ANGLE, above)
    if math.isinf(below) and math.isinf(above):
        return less
    if abs(above - below) > PARALLEL:
        return more if above > below else less
    # A positive turn moves the end of the shank along axis × thigh, and the knee the other way, as
    # the hip turns back.
    more_is_forward = np.cross(leg.axis, leg.thigh)[0] <= 0.0
    forward, backward = (more, less) if more_is_forward else (less, more)

    def beyond_limits(knee: float) -> float:
        hip = _hip_angle(leg, knee)
        return abs(leg.hip.clamped(hip) - hip)

    return forward if beyond_limits(forward) <= beyond_limits(backward) else backward


def _hip_angle(leg: Leg, knee: float) -> float:
    """The angle of the hip that keeps the end of the shank on its line [rad].

    Args: knee, its angle [rad].
    """
    return -_angle(leg.thigh + leg.shank, leg.thigh + _turned(leg, knee), leg.axis)


def _turned(leg: Leg, knee: float) -> Array:
    """The shank (3,) turned by the angle of the knee [m]."""
    return np.asarray(pin.AngleAxis(knee, leg.axis).toRotationMatrix() @ leg.shank)


def ends_leg(robot: Robot, foot: str, wheels: bool = True) -> bool:
    """True if the limb of a foot is a leg.

    A link or joint of it is named like a foot, a part of a leg or, if asked, a wheel.
    """
    part = f"{LEG_PART}|wheel" if wheels else LEG_PART
    names = (foot, *_limb_names(robot, robot.frames[foot].body))
    return any(is_foot(name) or re.search(part, name) for name in names)


def _limb_names(robot: Robot, body: int) -> Iterator[str]:
    """The names of a limb's links and joints, from its last body to the first beyond the base."""
    while body > 0:
        yield from robot.bodies[body].links
        yield robot.joints[body].name
        body = robot.parents[body]


def _at_zero(robot: Robot) -> Array:
    """The configuration (nq,) with all joints of one coordinate at zero, whatever their limits."""
    q = np.array(robot.start)
    for joint in robot.independent_joints:
        joint.set(0.0, q)
    robot.set_followers(q)
    return q


def _leg_of(robot: Robot, placements: list[pin.SE3], foot: Frame) -> Leg | None:
    """The leg that ends at a foot; None if it has no knee.

    Args:
        robot: the robot.
        placements: of its joints with all at zero.
        foot: frame of the foot; the shank itself if its origin is at the knee, and its lowest point
            is then the end.
    """
    body = robot.bodies[foot.body]
    end = placements[body.joint].act(body.offset + body.rotation @ foot.offset)
    axes = _axes(robot, placements, foot.body)
    for k, knee in enumerate(axes):
        before = _parallel(axes[:k], knee)
        beyond = _parallel(axes[k + 1 :], knee)
        if not before:
            continue
        hip = before[-1]
        # The leg lies in the plane across the axis of the knee.
        across = np.eye(3) - np.outer(knee.direction, knee.direction)
        short = SHORT_SHARE * np.linalg.norm(end - axes[0].origin)
        thigh = across @ (knee.origin - hip.origin)
        shank = across @ ((beyond[0].origin if beyond else end) - knee.origin)
        if not beyond and np.linalg.norm(shank) <= short:
            shank = across @ (_lowest_point(robot, placements, foot) - knee.origin)
        if min(np.linalg.norm(thigh), np.linalg.norm(shank)) > short:
            return Leg(
                axis=knee.direction,
                thigh=thigh,
                shank=shank,
                hip=_hinge(robot, hip, knee),
                knee=_hinge(robot, knee, knee),
                ankle=_hinge(robot, beyond[0], knee) if beyond else None,
            )
    return None


def _axes(robot: Robot, placements: list[pin.SE3], body: int) -> list[Axis]:
    """The joints from the base to a body that turn and follow no other, with all joints at zero."""
    axes: list[Axis] = []
    while body >= 0:
        joint = robot.joints[body]
        turns = joint.axis is not None and joint.kind in ("revolute", "continuous")
        if turns and joint.name not in robot.followers:
            placement = placements[robot.bodies[body].joint]
            direction = placement.rotation @ joint.axis
            axes.insert(0, Axis(joint, direction, np.array(placement.translation)))
        body = robot.parents[body]
    return axes


def _parallel(axes: list[Axis], knee: Axis) -> list[Axis]:
    """Those of some axes that are parallel to that of the knee."""
    return [axis for axis in axes if abs(axis.direction @ knee.direction) > math.cos(PARALLEL)]


def _hinge(robot: Robot, axis: Axis, knee: Axis) -> Hinge:
    """A joint of a leg with its angles about the axis of the knee."""
    joint, sign = axis.joint, math.copysign(1.0, float(axis.direction @ knee.direction))
    limits = joint.limits if joint.kind == "revolute" else (-math.inf, math.inf)
    low, high = sorted(sign * limit for limit in limits)
    return Hinge(joint, sign, sign * joint.value(robot.start), low, high)


def _lowest_point(robot: Robot, placements: list[pin.SE3], foot: Frame) -> Array:
    """The lowest point (3,) of a foot in the world [m].

    Without shapes it is the one that the foot's centre of mass halves.
    """
    body = robot.bodies[foot.body]
    placement = placements[body.joint] * pin.SE3(body.rotation, body.offset)
    shapes = striking(robot, foot.name).shapes
    if not shapes:
        return np.asarray(placement.act(2.0 * body.com))
    down = placement.rotation.T @ DOWN
    return np.asarray(placement.act(lowest_in_postures(shapes, down[None])[0]))


def _angle(first: Array, second: Array, axis: Array) -> float:
    """The angle about an axis from one vector to another [rad]."""
    return math.atan2(float(axis @ np.cross(first, second)), float(first @ second))
