"""The motion of a robot's base unless a scene states it.

It follows from what the robot's file says, and from its limbs.
"""

import re
from typing import Literal, NamedTuple, TypeAlias

from shockpc.core.memo import memoized
from shockpc.robot.bent_legs import ends_leg
from shockpc.robot.bodies_and_joints import WORLD
from shockpc.robot.feet_and_sensors import each_foot
from shockpc.robot.robot import Robot

Reason: TypeAlias = Literal["falls", "file", "weld", "world", "legs", "arm"]
"""Why: nothing holds it; the file gives it no joint; a weld of the file holds it; the root link is
called "world"; it is called
so, but legs hang on it; the robot is an arm."""

JOINTS = 3
"""The least number of joints of an arm."""

TRAVELS = r"(?i)wheel|caster|rotor_?\d|propell|thruster|copter|drone|flying|uav"
"""Names of links of robots that roll or fly."""


class UsualBase(NamedTuple):
    """The motion of the base unless a scene states it, and the reason."""

    base: Literal["free", "fixed"]
    reason: Reason


@memoized()
def usual_base(robot: Robot) -> UsualBase:
    """The motion of a robot's base unless a scene states it, and the reason.

    A file that holds the base fixes it: by a weld, by giving it no joint, or by a root link called
    "world". If legs hang on a root link of that name, it is freed: exports for simulators hold
    legged robots in the air so. An arm is fixed.
    """
    if not robot.free_base:
        return UsualBase("fixed", "file")
    if robot.welded:
        return UsualBase("fixed", "weld")
    if robot.root == WORLD:
        return UsualBase("free", "legs") if has_legs_on_base(robot) else UsualBase("fixed", "world")
    return UsualBase("fixed", "arm") if is_arm(robot) else UsualBase("free", "falls")


@memoized()
def has_legs_on_base(robot: Robot) -> bool:
    """True if two legs or more hang on the base without a joint between.

    Such a joint is that of a rail, on which the robot could fall.
    """
    base = 0 if robot.free_base else -1
    limbs = set()
    for foot in each_foot(robot):
        body = robot.frames[foot].body
        if body > base and ends_leg(robot, foot, wheels=False):
            while robot.parents[body] > base:
                body = robot.parents[body]
            limbs.add(body)
    return len(limbs) > 1


def hangs(robot: Robot, base: str | None) -> bool:
    """True if a robot with legs hangs on its base, which its file holds.

    Args: base, how it moves in a landing.
    """
    return base == "fixed" and usual_base(robot).base == "fixed" and has_legs_on_base(robot)


def is_arm(robot: Robot) -> bool:
    """True if a robot of a URDF hangs on its root by one chain, without feet.

    No name in it is that of a foot, leg, wheel or propeller.

    With fewer than three joints its end could not be stopped in space. Other formats say themselves
    whether the base moves, and so does a URDF in which a joint carries the whole robot.
    """
    says_nothing = robot.source.kind == "urdf" and robot.joints[0].name == "root_joint"
    if not says_nothing or robot.parents.count(0) != 1 or len(robot.independent_joints) < JOINTS:
        return False
    if any(ends_leg(robot, foot) for foot in each_foot(robot)):
        return False
    return not any(re.search(TRAVELS, link) for link in robot.links)
