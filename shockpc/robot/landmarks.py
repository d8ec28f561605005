"""Places on a robot that its names give away: feet to land on, sensors to protect."""

import re

import numpy as np

from shockpc.robot.record import Robot

__all__ = ["each_foot", "feet", "is_imu", "sensors"]

FOOT = r"(?i)foot(?!print)|feet|sole|toe|hoof|paw"
LEG_END = r"(?i)ankle|wheel"
IMU = r"(?i)imu|gyro|acceleromet"
SENSOR = rf"{IMU}|camera"


def feet(robot: Robot) -> tuple[str, ...]:
    """What a robot is likely to land on: links named like a foot, else a site or geom of each body named so, else the limbs' ends.

    The end of a limb is the site or geom of its last body that is farthest from the body's origin, or else the body's last link.
    """
    links = tuple(link for link in robot.links if re.search(FOOT, link) and not re.search(SENSOR, link))
    if links:
        return links
    places = [f for f in robot.frames.values() if f.kind in ("site", "geom") and f.body >= 0 and not re.search(SENSOR, f.name)]
    feet = {place.body: place.name for place in reversed(places) if re.search(FOOT, place.name)}
    if feet:
        return tuple(feet[body] for body in sorted(feet))
    ends = [i for i in range(len(robot.bodies)) if i not in robot.parents]
    ends = [i for i in ends if re.search(LEG_END, robot.bodies[i].links[-1])] or ends
    tips = {i: [place for place in places if place.body == i] for i in ends}
    return tuple(
        max(candidates, key=lambda place: float(np.linalg.norm(place.offset))).name if candidates else robot.bodies[i].links[-1]
        for i, candidates in tips.items()
    )


def each_foot(robot: Robot) -> tuple[str, ...]:
    """One frame for each foot: its sole if one is named so, else the first; a foot that carries another is no end of a leg."""
    links: dict[int, list[str]] = {}
    for link in feet(robot):
        links.setdefault(robot.frames[link].body, []).append(link)
    carried = {robot.parents[body] for body in links}
    return tuple(
        next((link for link in names if "sole" in link.casefold()), names[0])
        for body, names in links.items()
        if body not in carried
    )


def sensors(robot: Robot) -> tuple[str, ...]:
    """Links and sites named like a sensor, on bodies that move."""
    return tuple(f.name for f in robot.frames.values() if f.kind in ("link", "site") and f.body >= 0 and re.search(SENSOR, f.name))


def is_imu(name: str) -> bool:
    """Whether a sensor is named like one that measures motion."""
    return re.search(IMU, name) is not None
