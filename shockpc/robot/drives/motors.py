"""The joints that have a motor, and the effort of each, as a robot's file says."""

from collections.abc import Sequence

import numpy as np

from shockpc.core.spatial import Array
from shockpc.robot.robot import Robot

UNLIMITED = 1e300
"""Effort limit from which on it is none [N m, N]; Pinocchio writes the largest double."""

SAME = 1e-6
"""Relative difference up to which two numbers of a file are the same."""

MANY = 3
"""Joints with one reflected inertia, and no effort, from which on the number may be a setting of a
simulator.
"""

PLANETARY = (1e-4, 1e-3)
"""Reflected inertia over effort limit of drives with planetary gears up to 25:1 [kg m² per N m].

Mini Cheetah, Cheetah 3, Go1, G1, H1 and T-Motor's AK series lie between; harmonic drives are above.
"""

MOST_EFFORT = 20.0
"""Effort limit per mass of the robot from which on it is a placeholder [N m/kg]; legged robots have
2 to 5.
"""


def efforts(robot: Robot) -> Array:
    """The effort (nv,) that motors can exert [N m, N]; NaN where none is given.

    It is the effort limit, of an MJCF also of its actuators.
    """
    limit = effort_limits(robot)
    for name, effort in robot.motors.items():
        v = robot.joint(name).v
        known = effort if 0.0 < effort < UNLIMITED else np.nan
        limit[v] = np.where(np.isnan(limit[v]), known, limit[v])
    return limit


def effort_limits(robot: Robot) -> Array:
    """The effort limits (nv,) of the robot's file; NaN where there is none [N m, N]."""
    limit = np.array(robot.model.upperEffortLimit, dtype=float)
    limit[~((limit > 0.0) & (limit < UNLIMITED))] = np.nan
    return limit


def passive(robot: Robot) -> np.ndarray:
    """Mask (nv,) of the velocities of joints without a motor.

    The file gives motors or effort limits, and none of these joints.

    A file that gives none at all, such as many that CAD programs write, says nothing of any joint.
    So does a file in whose format a joint without an effort limit has an unlimited effort.
    """
    if robot.source.all_driven:
        return np.zeros(robot.model.nv, dtype=bool)
    driven = np.isfinite(efforts(robot)) | robot.velocities((*robot.motors, *robot.gear_ratios))
    if not (driven & robot.actuated_dofs).any():
        return np.zeros(robot.model.nv, dtype=bool)
    return np.asarray(robot.actuated_dofs & ~driven & (robot.model.armature == 0.0))


def effort_hint(robot: Robot, joints: Sequence[str]) -> str:
    """The reflected inertia that the effort limits of joints suggest, as a text.

    Empty where they suggest nothing.
    """
    v = [robot.joint(name).v.start for name in joints if robot.joint(name).unit == "rad"]
    known = [effort for effort in efforts(robot)[v] if effort <= MOST_EFFORT * robot.mass]
    if not known:
        return ""
    least, most = PLANETARY[0] * min(known), PLANETARY[1] * max(known)
    return f"planetary drives of such effort limits have {least:.2g} to {most:.2g} kg m²"


def simulator_settings(robot: Robot) -> frozenset[str]:
    """The joints whose reflected inertia in the file is a setting of a simulator.

    It is one number for joints of different or unknown effort.

    Motors that exert different torques have different rotors or gears, so such a number is a
    setting of a simulator. Where a file gives one number to `MANY` joints or more and the effort of
    none, nothing says that their drives are the same.
    """
    effort = efforts(robot)
    # The reflected inertia of each joint that has one, and its index of velocity.
    inertias: dict[str, float] = {}
    indices: dict[str, int] = {}
    for joint in robot.single_joints:
        if joint.kind != "free" and robot.model.armature[joint.v].any():
            inertias[joint.name] = float(robot.model.armature[joint.v.start])
            indices[joint.name] = joint.v.start
    settings: set[str] = set()
    for number in set(inertias.values()):
        tolerance = SAME * number
        alike = [name for name, inertia in inertias.items() if abs(inertia - number) <= tolerance]
        efforts_alike = effort[[indices[name] for name in alike]]
        known = efforts_alike[np.isfinite(efforts_alike)]
        if known.size:
            is_setting = bool(known.max() > known.min() * (1.0 + SAME))
        else:
            is_setting = len(alike) >= MANY
        if is_setting:
            settings.update(alike)
    return frozenset(settings)
