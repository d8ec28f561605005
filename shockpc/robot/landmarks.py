"""Places on a robot that its names give away: feet to land on, sensors to protect."""

import re

from shockpc.robot.robot import Robot

__all__ = ["each_foot", "feet", "is_imu", "sensors"]

FOOT = re.compile(r"foot(?!print)|feet|sole|toe|hoof|paw", re.IGNORECASE)
LEG_END = re.compile(r"ankle|wheel", re.IGNORECASE)
IMU = re.compile(r"imu|gyro|acceleromet", re.IGNORECASE)
SENSOR = re.compile(rf"{IMU.pattern}|camera", re.IGNORECASE)


def feet(robot: Robot) -> tuple[str, ...]:
    """Links that a robot is likely to land on: those named like a foot, else the last link of every leg, else of every limb."""
    named = tuple(link for link in robot.links if FOOT.search(link) and not SENSOR.search(link))
    if named:
        return named
    parents = {robot.model.parents[body.joint] for body in robot.bodies}
    tips = tuple(body.links[-1] for body in robot.bodies if body.joint not in parents)
    return tuple(tip for tip in tips if LEG_END.search(tip)) or tips


def each_foot(robot: Robot) -> tuple[str, ...]:
    """One link for each foot: its sole if one is named so, else the first; a foot that carries another is no end of a leg."""
    links: dict[int, list[str]] = {}
    for link in feet(robot):
        links.setdefault(robot.frames[link].body, []).append(link)
    carried = {robot.parents[body] for body in links}
    return tuple(
        next((link for link in own if "sole" in link.casefold()), own[0]) for body, own in links.items() if body not in carried
    )


def sensors(robot: Robot) -> tuple[str, ...]:
    """Links and sites named like a sensor, on bodies that move."""
    return tuple(f.name for f in robot.frames.values() if f.kind != "joint" and f.body >= 0 and SENSOR.search(f.name))


def is_imu(name: str) -> bool:
    """Whether a sensor is named like one that measures motion."""
    return IMU.search(name) is not None
