"""Places on a robot that its names and its standing posture give away: how it stands, feet to land on, sensors to protect."""

import functools
import re

import numpy as np
import pinocchio as pin

from shockpc.robot.robot import Robot

STANDING = ("standing", "half_sitting", "stand", "home")
"""Reference postures taken for a landing when none is asked for, in this order."""

VARIANTS = ("standing.*", "homing.*")
"""Names of the postures of which the first is taken if a robot has none of those."""

KEYFRAMES = ("(?i).*stand.*", "(?i).*home.*", "(?i).*(walk|default|init).*")
"""The same for keyframes of an MJCF, which are postures of a whole robot; a file's only keyframe is taken whatever its name."""

BENT = "neutral_bent"
"""The posture of a robot without a standing one whose straight legs can be bent, as `bent_legs` has it."""

FOOT = r"(?i)foot(?!print)|feet|sole|toe|hoof|paw"
LEG_END = r"(?i)ankle|wheel"
IMU = r"(?i)imu|gyro|acceleromet"
SENSOR = rf"{IMU}|camera"

NEAR = 0.1
"""Height of a foot above the lowest point of its limb, as a share of the height of the robot."""

LOW = 0.3
"""Height of a limb's end that is not named like a foot above the lowest point of the robot, as such a share."""


def standing_posture(robot: Robot) -> str:
    """The name of the posture in which a robot stands; if none is known to be one, that with bent legs, or else "neutral"."""
    mjcf, names = robot.source.kind == "mjcf", tuple(robot.postures)
    for pattern in (*STANDING, *VARIANTS, *(KEYFRAMES if mjcf else ())):
        for name in names:
            if re.fullmatch(pattern, name):
                return name
    if mjcf and len(names) == 1:
        return names[0]
    return BENT if BENT in names else "neutral"


@functools.lru_cache(maxsize=8)
def _heights(robot: Robot) -> dict[str, float]:
    """Height of every link, site and geom that moves, in the standing posture [m]; empty where none is above another."""
    q = pin.normalize(robot.model, np.array(robot.postures.get(standing_posture(robot), robot.start)))
    placed = robot.joint_placements(q)
    heights = {}
    for frame in robot.frames.values():
        if frame.kind != "joint" and frame.body >= 0:
            body = robot.bodies[frame.body]
            place = placed[body.joint] * pin.SE3(body.rotation, body.offset)
            heights[frame.name] = float(place.act(frame.offset)[2])
    return heights


def _limbs(robot: Robot) -> list[int]:
    """The limb of each body: the first body of the branch that it is on, beyond the last body that carries all others."""
    trunk = 0
    while robot.parents.count(trunk) == 1:
        trunk = robot.parents.index(trunk)
    limbs: list[int] = []
    for body, parent in enumerate(robot.parents):
        limbs.append(body if parent in (trunk, -1) or body <= trunk else limbs[parent])
    return limbs


def _ends(robot: Robot, names: tuple[str, ...]) -> tuple[str, ...]:
    """Those of some frames that are at the end of a limb: no other of them is beyond, and nothing of the limb much lower."""
    heights, limbs = _heights(robot), _limbs(robot)
    whole = max(heights.values()) - min(heights.values())
    lowest: dict[int, float] = {}
    for name, height in heights.items():
        limb = limbs[robot.frames[name].body]
        lowest[limb] = min(height, lowest.get(limb, height))
    carriers = set()
    for name in names:
        body = robot.parents[robot.frames[name].body]
        while body >= 0 and body not in carriers:
            carriers.add(body)
            body = robot.parents[body]
    bodies = {name: robot.frames[name].body for name in names}
    low = {body for name, body in bodies.items() if heights[name] - lowest[limbs[body]] <= NEAR * whole}
    return tuple(name for name, body in bodies.items() if body in low - carriers) or names


def feet(robot: Robot) -> tuple[str, ...]:
    """What a robot is likely to land on: links named like a foot, else a site or geom of each body named so, else the limbs' ends.

    A foot is at the end of its limb, and low in the standing posture; rods of an ankle, hands and cameras are not. The end of a
    limb is the site or geom of its last body that is farthest from the body's origin, or else the body's last link.
    """
    links = tuple(link for link in robot.links if re.search(FOOT, link) and not re.search(SENSOR, link))
    if links:
        return _ends(robot, links)
    places = [f for f in robot.frames.values() if f.kind in ("site", "geom") and f.body >= 0 and not re.search(SENSOR, f.name)]
    named = {place.body: place.name for place in reversed(places) if re.search(FOOT, place.name)}
    if named:
        return _ends(robot, tuple(named[body] for body in sorted(named)))
    ends = [i for i in range(len(robot.bodies)) if i not in robot.parents]
    tips = {i: [place for place in places if place.body == i] for i in ends}
    names = {
        i: max(candidates, key=lambda place: float(np.linalg.norm(place.offset))).name if candidates else robot.bodies[i].links[-1]
        for i, candidates in tips.items()
    }
    if legs := [i for i in ends if re.search(LEG_END, robot.bodies[i].links[-1])]:
        return _ends(robot, tuple(names[i] for i in legs))
    heights = _heights(robot)
    limit = min(heights.values()) + LOW * (max(heights.values()) - min(heights.values()))
    return tuple(name for name in names.values() if heights[name] <= limit) or tuple(names.values())


def each_foot(robot: Robot) -> tuple[str, ...]:
    """One frame for each foot: its sole if one is named so, else the first."""
    links: dict[int, list[str]] = {}
    for link in feet(robot):
        links.setdefault(robot.frames[link].body, []).append(link)
    return tuple(next((link for link in names if "sole" in link.casefold()), names[0]) for names in links.values())


def sensors(robot: Robot) -> tuple[str, ...]:
    """Links and sites named like a sensor, on bodies that move."""
    return tuple(f.name for f in robot.frames.values() if f.kind in ("link", "site") and f.body >= 0 and re.search(SENSOR, f.name))


def is_foot(name: str) -> bool:
    """Whether a link is named like a foot."""
    return re.search(FOOT, name) is not None


def is_imu(name: str) -> bool:
    """Whether a sensor is named like one that measures motion."""
    return re.search(IMU, name) is not None
