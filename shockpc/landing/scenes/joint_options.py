"""The joints as a scene states them.

A model of all, and inertias, springs, torques and locks of some.
"""

from collections.abc import Mapping
from dataclasses import field, replace
from typing import Literal

from shockpc.core.frozen import frozen
from shockpc.core.interval import Interval
from shockpc.landing.scenes.scene_fields import JOINT_MODEL, SOFT, Record, documented, option
from shockpc.robot.gear import Gear

JointModelName = Literal["free", "geared", "rigid", "locked"]
"""The model of all joints."""


@frozen(kw_only=True)
class Rotor(Record):
    """A motor behind a gearbox.

    Attributes:
        inertia: of the rotor about its axis, or [low, high] [kg m²].
        gear_ratio: turns of the rotor for one of the joint, or [low, high] [1]; by default that of
            the robot's file.
        stiffness: of a spring between gearbox and joint (series elastic) [N m/rad, N/m]; rigid by
            default.
        gear: its kind, from which the sense in which the rotor turns follows; by default its
            coupling to the link is left out.
    """

    inertia: Interval
    gear_ratio: Interval | None = None
    stiffness: float | None = None
    gear: Gear | None = None


@documented
@frozen(kw_only=True)
class Joints(Record):
    """The drives as a scene states them.

    Patterns are joint names or globs, of which later ones go over earlier ones.

    An interval [low, high] says that the number is between the two; its arithmetic middle is
    computed with.

    Attributes:
        armature: reflected inertia by pattern, or [low, high] [kg m²; kg for a prismatic joint].
        rotor: rotor and gearbox by pattern; their reflected inertia is gear_ratio² · inertia.
        stiffness: of springs of the joints themselves, such as in a leg with springs, by pattern [N
            m/rad, N/m].
        locked: patterns of joints that hold the rate that they have before the impact: none, or
            that of the strike's joint velocities.
    """

    model: JointModelName | None = option(
        None,
        "Reflected inertia: none, as given, with rigid springs, or locked. free: no reflected "
        "inertia, even if the robot's file, --drives or the catalogue gives one; geared: springs "
        "yield; rigid: springs do not yield (a joint with a spring is locked, a rotor behind a "
        "spring is joined to its joint); locked: no joint moves. By default each joint has the "
        "model of its drive.",
        JOINT_MODEL,
        name="joints",
    )
    drives: str | None = option(
        None,
        "A file or robot that has the drives, or none. Joints of the same names have the drives "
        "of that robot. By default a robot of the catalogue has its known drives in place of the "
        "values in its file; none keeps the values of the file. Files have the form of "
        "robots/drives.toml.",
        JOINT_MODEL,
        "FILE|NAME|none",
    )
    motors: Literal["none", "flight", "standing"] | None = option(
        None,
        "Constant torques of the motors on contacts of finite stiffness: those that hold the load "
        "of springs before touchdown "
        "(flight), those that also hold the robot's weight on its contacts (standing), or none.",
        SOFT,
        default="flight",
        wing="compliant",
    )
    carried: bool = option(
        True,
        "Leave out the coupling of rotors to the links that carry them (joints.carried = false in "
        "a scene). Its "
        "sign follows from the gears of the drives.",
        JOINT_MODEL,
        name="no-carried",
    )
    armature: Mapping[str, Interval] = field(default_factory=dict)
    rotor: Mapping[str, Rotor] = field(default_factory=dict)
    stiffness: Mapping[str, float] = field(default_factory=dict)
    torque: Mapping[str, float] = option(
        dict,
        "Constant torque of motors on contacts of finite stiffness, by joint, in place of the "
        "torque of --motors [N m; N if prismatic].",
        SOFT,
        "JOINT=TORQUE",
        wing="compliant",
    )
    locked: tuple[str, ...] = ()


def with_model(joints: Joints, model: JointModelName | None) -> Joints:
    """The joints with another model, without what has no effect on it.

    Drives have no effect on free joints, springs too none on locked ones.
    """
    if model == "free":
        joints = replace(joints, armature={}, rotor={}, drives=None)
    if model == "locked":
        joints = replace(joints, armature={}, rotor={}, stiffness={})
    return replace(joints, model=model)
