"""Places on a robot that its names give away: feet to land on, sensors to protect."""

import re

from shockpc.robot.robot import Robot

__all__ = ["feet", "sensors"]

FOOT = re.compile(r"foot(?!print)|feet|sole|toe|hoof|paw", re.IGNORECASE)
SENSOR = re.compile(r"imu|gyro|acceleromet|camera", re.IGNORECASE)


def feet(robot: Robot) -> tuple[str, ...]:
    """Links that a robot is likely to land on: those named like a foot, else the last link of every limb."""
    named = tuple(link for link in robot.links if FOOT.search(link) and not SENSOR.search(link))
    if named:
        return named
    parents = {robot.model.parents[body.joint] for body in robot.bodies}
    return tuple(body.links[-1] for body in robot.bodies if body.joint not in parents)


def sensors(robot: Robot) -> tuple[str, ...]:
    """Links and sites named like a sensor, on bodies that move."""
    return tuple(f.name for f in robot.frames.values() if f.kind != "joint" and f.body >= 0 and SENSOR.search(f.name))
