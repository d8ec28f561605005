"""Places on a robot that its names and its standing posture give away.

They are its way to stand, feet to land on, and sensors to protect.
"""

import math
import re
from collections.abc import Iterator

import numpy as np
import pinocchio as pin

from shockpc.core.memo import memoized
from shockpc.robot.bodies_and_joints import Body, Frame
from shockpc.robot.robot import Robot

STANDING = ("standing", "half_sitting", "stand", "home")
"""Reference postures taken for a landing when none is asked for, in this order."""

VARIANTS = ("standing.*", "homing.*")
"""Names of the postures of which the first is taken if a robot has none of those."""

KEYFRAMES = ("(?i).*stand.*", "(?i).*home.*", "(?i).*(walk|default|init).*")
"""Patterns for keyframes of an MJCF, which are postures of a whole robot; a file's only keyframe is
taken whatever its name.
"""

BENT = "neutral_bent"
"""The posture of a robot without a standing one whose straight legs can be bent, as `bent_legs` has
it.
"""

FOOT = r"(?i)foot(?!print)|feet|sole|toe|hoof|paw"
LEG_END = r"(?i)ankle|wheel"
IMU = r"(?i)imu|gyro|acceleromet"
SENSOR = rf"{IMU}|camera"
FASTENER = r"(?i)screw|bolt|rivet|washer|constraint|linkage"

LOW_END_SHARE = 0.1
"""Height of a foot above the lowest point of its limb, as a share of the height of the robot."""

LOW = 0.3
"""Height above the lowest point, as such a share: of a limb's end that is not named like a foot,
above that of the robot; of
further links of a foot that are named so, above that of the limb."""

ALIKE = 0.05
"""Relative difference of masses up to which limbs are legs of the same make."""


def standing_posture(robot: Robot) -> str:
    """The name of the posture in which a robot stands.

    It is that with bent legs if it was needed, one named so, or else "neutral".
    """
    mjcf, names = robot.source.kind == "mjcf", tuple(robot.postures)
    if BENT in names:
        return BENT
    for pattern in (*STANDING, *VARIANTS, *(KEYFRAMES if mjcf else ())):
        for name in names:
            if re.fullmatch(pattern, name):
                return name
    if mjcf and len(names) == 1:
        return names[0]
    return "neutral"


@memoized()
def _heights(robot: Robot, posture: str) -> dict[str, float]:
    """Height of every link, site and geom that moves, in a posture [m].

    Empty where none is above another.
    """
    q = pin.normalize(robot.model, np.array(robot.postures.get(posture, robot.start)))
    placements = robot.body_placements(q)
    heights = {}
    for frame in robot.frames.values():
        if frame.kind != "joint" and frame.body >= 0 and not _marks(robot, frame):
            heights[frame.name] = float(placements[frame.body].act(frame.offset)[2])
    return heights


def _marks(robot: Robot, frame: Frame) -> bool:
    """True if a frame is a named place of a URDF.

    There the links tell the feet; in an MJCF sites and geoms do so.
    """
    return robot.source.kind == "urdf" and frame.kind == "site"


def _trunk(robot: Robot) -> int:
    """The last body that carries all others."""
    trunk = 0
    while robot.parents.count(trunk) == 1:
        trunk = robot.parents.index(trunk)
    return trunk


def _not_fixed_to_trunk(robot: Robot, names: tuple[str, ...]) -> tuple[str, ...]:
    """The frames that are not fixed to the trunk, of some frames of a robot with limbs.

    Those fixed to it are such as pads under it. Without limbs all frames are returned.
    """
    trunk = _trunk(robot)
    if robot.parents.count(trunk) < 2:
        return names
    bodies = {body.name for body in robot.bodies}
    return tuple(name for name in names if robot.frames[name].body > trunk or name in bodies)


def _limbs(robot: Robot) -> list[int]:
    """The limb of each body: the first body of the branch that it is on.

    Branches begin beyond the last body that carries all others.
    """
    trunk = _trunk(robot)
    limbs: list[int] = []
    for body, parent in enumerate(robot.parents):
        is_first = body <= trunk or parent in (trunk, -1)
        limbs.append(body if is_first else limbs[parent])
    return limbs


def _ends(robot: Robot, names: tuple[str, ...]) -> tuple[str, ...]:
    """The frames that are at the end of a limb, of some frames.

    No other of them is beyond, and nothing of the limb is much lower.

    A frame beyond which a body of the limb reaches lower is part of the leg, and left out whatever
    it is named.
    """
    heights, limbs = _heights(robot, standing_posture(robot)), _limbs(robot)
    height_of_robot = max(heights.values()) - min(heights.values())

    # The lowest height of each limb, and of what each body carries.
    lowest: dict[int, float] = {}
    beyond = [math.inf] * len(limbs)
    for name, height in heights.items():
        body = robot.frames[name].body
        lowest[limbs[body]] = min(height, lowest.get(limbs[body], height))
        for carrier in _carriers(robot, body):
            beyond[carrier] = min(height, beyond[carrier])

    # Frames that nothing of what their body carries reaches below, and their heights above the
    # lowest point of the limb, as shares of the robot's height.
    bodies = {}
    above = {}
    for name in names:
        body = robot.frames[name].body
        if heights[name] <= beyond[body]:
            bodies[name] = body
            drop = heights[name] - lowest[limbs[body]]
            above[name] = drop / height_of_robot if height_of_robot else 0.0

    carriers: set[int] = set()
    for body in bodies.values():
        carriers.update(_carriers(robot, body))
    low = {body for name, body in bodies.items() if above[name] <= LOW_END_SHARE} - carriers
    ends = tuple(name for name, body in bodies.items() if body in low and above[name] <= LOW)
    return ends or tuple(bodies)


def _carriers(robot: Robot, body: int) -> Iterator[int]:
    """The bodies that carry one, from the next to the base."""
    while (body := robot.parents[body]) >= 0:
        yield body


def _tip(body: Body, frames: list[Frame]) -> str:
    """The name of the end of a body that is the last of its limb.

    Args: frames: its sites and geoms.
    """
    if frames:
        return max(frames, key=lambda frame: float(np.linalg.norm(frame.offset))).name
    for link in reversed(body.links):
        if not re.search(FASTENER, link):
            return link
    return body.links[-1]


def _with_twins(robot: Robot, low: list[int], ends: list[int]) -> list[int]:
    """The last bodies of limbs that are low, and those of limbs with the same masses.

    Some of these may be drawn folded.
    """
    limbs = _limbs(robot)

    def masses(end: int) -> list[float]:
        on_limb = [body for body in (end, *_carriers(robot, end)) if limbs[body] == limbs[end]]
        return [robot.bodies[body].mass for body in on_limb]

    def alike(end: int, low_end: int) -> bool:
        a, b = masses(end), masses(low_end)
        return len(a) == len(b) and bool(np.allclose(a, b, rtol=ALIKE))

    def is_foot(end: int) -> bool:
        return end in low or any(alike(end, other) for other in low)

    return [end for end in ends if is_foot(end)]


@memoized()
def _feet_or_tips(robot: Robot) -> tuple[tuple[str, ...], bool]:
    """The frames of `feet`, and True if they are recognised as feet.

    They are recognised by their names or because they are low.
    """
    named = _links_named_like_feet(robot) or _places_named_like_feet(robot)
    if named:
        return named, True
    ends = [i for i in range(len(robot.bodies)) if i not in robot.parents]
    legs = [i for i in ends if re.search(LEG_END, robot.bodies[i].links[-1])]
    if legs:
        # The body itself: a site on it may be the hub of a wheel.
        return _ends(robot, tuple(_tip(robot.bodies[i], []) for i in legs)), True

    # Nothing is named like a foot: the tips that are low.
    places = _places(robot)
    tips = {}
    for i in ends:
        tips[i] = _tip(robot.bodies[i], [place for place in places if place.body == i])
    heights = _heights(robot, standing_posture(robot))
    lowest = min(heights[name] for name in _not_fixed_to_trunk(robot, tuple(heights)))
    limit = lowest + LOW * (max(heights.values()) - lowest)
    low = [i for i in ends if heights[tips[i]] <= limit]
    if low:
        return tuple(tips[i] for i in _with_twins(robot, low, ends)), True
    return tuple(tips.values()), False


def _links_named_like_feet(robot: Robot) -> tuple[str, ...]:
    """The links named like a foot that are at the end of a limb."""
    feet = [link for link in robot.links if re.search(FOOT, link)]
    no_sensors = [link for link in feet if not re.search(SENSOR, link)]
    links = _not_fixed_to_trunk(robot, tuple(no_sensors))
    return _ends(robot, links) if links else ()


def _places(robot: Robot) -> list[Frame]:
    """The sites and geoms that move, but for sensors and the named places of a URDF."""
    places = []
    for frame in robot.frames.values():
        on_body = frame.kind in ("site", "geom") and frame.body >= 0
        if on_body and not _marks(robot, frame) and not re.search(SENSOR, frame.name):
            places.append(frame)
    return places


def _places_named_like_feet(robot: Robot) -> tuple[str, ...]:
    """A site or geom named like a foot, the first of each body, at the end of a limb."""
    named: dict[int, str] = {}
    for frame in _places(robot):
        if re.search(FOOT, frame.name):
            named.setdefault(frame.body, frame.name)
    if not named:
        return ()
    return _ends(robot, tuple(named[body] for body in sorted(named)))


def feet(robot: Robot) -> tuple[str, ...]:
    """The frames on which a robot is likely to land.

    They are links named like a foot, else a site or geom of each body named so, else the limbs'
    ends.

    A foot is at the end of its limb, and low in the standing posture; rods of an ankle, hands and
    cameras are not. The end of a limb is the site or geom of its last body that is farthest from
    the body's origin, or else its last link but for screws.
    """
    return _feet_or_tips(robot)[0]


@memoized()
def recognised(robot: Robot) -> bool:
    """True if `feet` are named like feet or wheels, or are the low ends of limbs.

    False where they are tips anywhere.
    """
    return _feet_or_tips(robot)[1]


@memoized()
def each_foot(robot: Robot) -> tuple[str, ...]:
    """The frame of each foot.

    It is the foot's sole if one is named so, its body if it has several parts, else its only part.
    """
    parts: dict[int, list[str]] = {}
    for name in feet(robot):
        parts.setdefault(robot.frames[name].body, []).append(name)
    return tuple(_foot_of_parts(robot, names) for names in parts.values())


def _foot_of_parts(robot: Robot, names: list[str]) -> str:
    """The name of the foot with some parts, all on one body."""
    first = robot.frames[names[0]]
    body = robot.bodies[first.body].links[0]
    soles = [name for name in names if "sole" in name.casefold()]
    if len(soles) == 1:
        return soles[0]
    if robot.parents[first.body] < 0:
        return names[0]
    if len(names) > 1:
        return body
    if first.kind not in ("geom", "site"):
        return names[0]
    # Of several geoms or sites of a foot, only one is among the names that were found.
    alike = [f for f in robot.frames.values() if (f.kind, f.body) == (first.kind, first.body)]
    if re.search(FOOT, first.name):
        alike = [frame for frame in alike if re.search(FOOT, frame.name)]
    return body if len(alike) > 1 else names[0]


def sensors(robot: Robot) -> tuple[str, ...]:
    """Links and sites that move and are named like a sensor or are IMUs by the file.

    A site in the place of such a link is none.
    """
    links, sites = [], []
    for frame in robot.frames.values():
        is_sensor = re.search(SENSOR, frame.name) is not None or frame.name in robot.imus
        if is_sensor and frame.body >= 0 and frame.kind == "link":
            links.append(frame)
        elif is_sensor and frame.body >= 0 and frame.kind == "site":
            sites.append(frame)

    def repeats(site: Frame) -> bool:
        on_body = [link for link in links if link.body == site.body]
        return any(np.allclose(link.offset, site.offset) for link in on_body)

    apart = {site.name for site in sites if not repeats(site)} | {link.name for link in links}
    return tuple(name for name in robot.frames if name in apart)


def is_foot(name: str) -> bool:
    """True if a link is named like a foot."""
    return re.search(FOOT, name) is not None


def is_imu(name: str) -> bool:
    """True if a sensor is named like one that measures motion."""
    return re.search(IMU, name) is not None
