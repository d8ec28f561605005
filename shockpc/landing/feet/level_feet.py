"""The feet that land together: those whose lowest points are level.

With them the landings of a robot without contacts.

Feet that touch one after another and stay where they are end with the same jump in any order. A
robot that stands level therefore lands on all level feet; tilted a little, on those of an edge of
their support polygon, or on a single foot. The worst of these landings is the worst of all subsets
of the feet, or nearly so.
"""

import itertools
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.landing.closure import all_loops, assemble
from shockpc.landing.feet.soles import LEVEL, most_inside, sole_corners
from shockpc.landing.landing import Landing, PosedLanding
from shockpc.landing.posture import configuration, fixed_joints
from shockpc.landing.scenes.scene import Contact, Scene
from shockpc.landing.scenes.scene_file import check_scene, ground_normal, plane_of
from shockpc.method.constraints import Constraint
from shockpc.method.dynamics import Dynamics, dynamics
from shockpc.robot.feet_and_sensors import each_foot, is_foot, recognised
from shockpc.robot.robot import Robot
from shockpc.robot.shapes.convex import Shape
from shockpc.robot.shapes.lowest import height_of_lowest, lowest_in_postures
from shockpc.robot.shapes.striking import striking
from shockpc.robot.usual_base import usual_base
from shockpc.text.errors import SceneError

STRAIGHT = 0.01
"""Distance from an edge of the support polygon up to which a foot lies on it, as a share of the
largest distance of two feet.
"""

LIKE = ("directions", "restitution", "restitution_along", "normal")
"""The fields that the feet that land together have in common with the one that is given."""


class FootPoints(NamedTuple):
    """Where the feet of a robot are lowest in N postures.

    Attributes:
        names: of the n feet.
        bodies: (n,) which they belong to.
        points: (N, n, 3) their lowest points, or the origins of all their frames if one of the feet
            has no geometry, so that heights compare, from the base [m].
    """

    names: tuple[str, ...]
    bodies: np.ndarray
    points: Array


def foot_points(robot: Robot, rotation: Array, position: Array, up: Array) -> FootPoints:
    """The lowest points of a robot's feet in N postures.

    Args:
        robot: the robot.
        rotation: (N, nb, 3, 3) of the body frames, body to world.
        position: (N, nb, 3) their origins, from the base [m].
        up: (3,) unit normal of the ground, world axes.
    """
    feet = each_foot(robot)
    frames = [robot.frame(name) for name in feet]
    shapes = [_struck_shapes(robot, name) for name in feet]
    points = np.empty((len(rotation), len(feet), 3))
    for k, frame in enumerate(frames):
        R = rotation[:, frame.body]
        low = np.broadcast_to(frame.offset, (len(R), 3))
        if all(shapes):
            low = lowest_in_postures(shapes[k], -up @ R)
        points[:, k] = position[:, frame.body] + (R @ low[..., None])[..., 0]
    return FootPoints(feet, np.array([frame.body for frame in frames], dtype=int), points)


def feet_beside(landing: Landing, rotation: Array, position: Array) -> np.ndarray:
    """Mask (N, n) of the feet that do not strike in N postures, and are as low as the contacts.

    It has none of the tips that are not recognised as feet.

    Args:
        landing: names the contacts.
        rotation: as for `foot_points`.
        position: as for `foot_points`.
    """
    robot, up = landing.robot, landing.up
    if not recognised(robot):
        return np.zeros((len(rotation), len(each_foot(robot))), dtype=bool)
    feet = foot_points(robot, rotation, position, up)
    tolerance = landing.scene.ground_tolerance + LEVEL
    height = feet.points @ up
    lowest = np.full(len(rotation), np.inf)
    for contact in landing.contacts:
        R = rotation[:, contact.body]
        low, inside = _lowest_of_contact(robot, contact, -up @ R)
        reached = (position[:, contact.body] + (R @ low[..., None])[..., 0]) @ up
        # A contact stands for the foot of its body, unless it is on a part of the leg above that.
        foot = height[:, feet.bodies == contact.body].min(axis=1, initial=np.inf)
        is_of_foot = reached <= foot + inside + tolerance
        lowest = np.minimum(lowest, np.where(is_of_foot, foot, reached))
    struck = {contact.body for contact in landing.contacts} | {*landing.lifted}
    strikes = np.isin(feet.bodies, list(struck))
    apart = np.abs(height - lowest[:, None])
    return np.asarray(~strikes & (apart <= tolerance))


def _lowest_of_contact(robot: Robot, contact: Constraint, down: Array) -> tuple[Array, float]:
    """The lowest points (N or 1, 3) of a contact in its body's frame, and a height [m].

    They may lie that far above the lowest point of its foot.

    Args: down, (N, 3) unit vectors in the axes of the body.
    """
    if contact.kind == "contact":
        shapes = _struck_shapes(robot, contact.frame)
        if shapes:
            return lowest_in_postures(shapes, down), 0.0
    return robot.frame(contact.frame).offset, most_inside(robot)


def whole_feet(landing: PosedLanding) -> Scene | None:
    """The landing on the whole of feet of which it strikes parts, such as one of several geoms.

    None where it strikes no part of a foot that has other parts as low.
    """
    contacts = tuple(_whole_foot(landing, contact) for contact in landing.asked)
    changed = contacts != landing.asked
    return replace(landing.scene, contact=tuple(dict.fromkeys(contacts))) if changed else None


def _whole_foot(landing: PosedLanding, contact: Contact) -> Contact:
    """A contact at the whole foot of which it strikes a part; itself where it does not."""
    robot = landing.robot
    is_open = contact.at == "auto" and contact.kind == "auto" and contact.offset is None
    if not is_open or contact.frame not in robot.frames or contact.frame in each_foot(robot):
        return contact
    frame = robot.frame(contact.frame)
    if frame.kind == "joint" or not recognised(robot):
        return contact
    rotation = landing.state.rotation[0, frame.body]
    up = landing.up @ rotation
    tolerance = landing.scene.ground_tolerance
    for foot in each_foot(robot):
        if robot.frame(foot).body != frame.body:
            continue
        sole = sole_corners(robot, foot, (float(up[0]), float(up[1]), float(up[2])), tolerance)
        if sole is None:
            continue
        # The part is one of those that are lowest.
        shapes = _struck_shapes(robot, contact.frame)
        if shapes:
            low = height_of_lowest(shapes, up)
        else:
            low = float(up @ frame.offset) - most_inside(robot)
        if low <= float((sole @ up).min()) + tolerance + LEVEL:
            return replace(contact, frame=foot)
    return contact


def together(landing: PosedLanding) -> Scene | None:
    """The landing on all level feet, where one of some of them is given.

    It is the landing's scene with a contact more for each other foot.

    These are as its first contact, at their own points. None where no other foot is level, or the
    landing is no drop on all feet.
    """
    scene = whole_feet(landing) or replace(landing.scene, contact=landing.asked)
    if landing.base == "fixed" or landing.stance or not landing.translates:
        return None
    beside = feet_beside(landing, landing.state.rotation, landing.state.position)[0]
    if not beside.any():
        return None
    feet = each_foot(landing.robot)
    first = scene.contact[0]
    like = Contact(**{name: getattr(first, name) for name in LIKE}, frame="")
    added = [replace(like, frame=feet[k]) for k in np.flatnonzero(beside)]
    return replace(scene, contact=(*scene.contact, *added))


def default_landings(
    robot: Robot, scene: Scene, normal: tuple[float, float, float] | None = None
) -> list[tuple[Contact, ...]]:
    """The contacts of each landing of a robot whose scene names none.

    In this order: all level feet together; those of each edge of their support polygon; each foot
    alone. With a fixed base or standing feet, and for tips of limbs that are not recognised as
    feet, each one alone, without what stands.

    Args:
        robot: the robot.
        scene: its posture, base, tolerance of the ground and standing feet.
        normal: of the ground; vertical by default.

    Raises:
        ShockError: the scene's posture has no meaning, or no foot is left to land on.
    """
    scene = check_scene(scene)
    standing = {robot.frame(name).body for name in scene.stance if name in robot.frames}
    feet = [name for name in each_foot(robot) if robot.frame(name).body not in standing]
    if not feet:
        left = " besides those that stand" if standing else ""
        example = f', such as "{robot.links[-1]}"' if not standing else ""
        raise SceneError(
            f'no contact is defined for robot "{robot.name}", and it has no feet{left}; name one '
            f"with --contact{example}"
        )
    landings: list[tuple[str, ...]] = [(foot,) for foot in feet]
    may_stand = len(feet) > 1 and not standing
    is_free = may_stand and (scene.base or usual_base(robot).base) != "fixed"
    land_together = is_free and recognised(robot)
    have_carriers = any(_carriers_of_foot(robot, foot) for foot in feet)
    if land_together or have_carriers:
        state, up = _posed(robot, scene, normal)
        tolerance = scene.ground_tolerance + LEVEL
        if land_together:
            landings = [*_together(robot, state, up, tolerance), *landings]
        if have_carriers:
            landings = _with_level_parts(robot, state, up, tolerance, landings)
    contacts: list[tuple[Contact, ...]] = []
    for frames in landings:
        contacts.append(tuple(Contact(frame=name) for name in frames))
    return contacts


def _with_level_parts(
    robot: Robot, state: Dynamics, up: Array, tolerance: float, landings: list[tuple[str, ...]]
) -> list[tuple[str, ...]]:
    """Landings with the carriers of their feet that are as low as these."""
    complete: list[tuple[str, ...]] = []
    for feet in landings:
        parts: list[str] = []
        for foot in feet:
            parts += _level_parts(robot, foot, state, up, tolerance)
        complete.append(tuple(parts))
    return complete


def with_contacts(scene: Scene, robot: Robot) -> list[Scene]:
    """A scene that has contacts; of one that has none a scene for each of its `default_landings`.

    Raises:
        ShockError: as for `default_landings`.
    """
    if scene.contact:
        return [scene]
    return [replace(scene, contact=contacts) for contacts in default_landings(robot, scene)]


def _carriers_of_foot(robot: Robot, foot: str) -> tuple[str, ...]:
    """The bodies named like a foot that carry a foot, such as that of a toe with a joint."""
    carriers, body = list[str](), robot.parents[robot.frame(foot).body]
    while body > 0 and is_foot(robot.bodies[body].links[0]):
        carriers.append(robot.bodies[body].links[0])
        body = robot.parents[body]
    return tuple(carriers)


def _level_parts(
    robot: Robot, foot: str, state: Dynamics, up: Array, tolerance: float
) -> tuple[str, ...]:
    """A foot, and those of its carriers that are as low: flat ground meets all of them."""
    lowest = dict[str, float]()
    for name in (foot, *_carriers_of_foot(robot, foot)):
        body = robot.frame(name).body
        shapes = _struck_shapes(robot, name)
        if shapes:
            height = height_of_lowest(shapes, up @ state.rotation[0, body])
            lowest[name] = height + float(state.position[0, body] @ up)
    limit = min(lowest.values(), default=0.0) + tolerance
    return (foot, *(name for name, height in lowest.items() if name != foot and height <= limit))


def _posed(
    robot: Robot, scene: Scene, normal: tuple[float, float, float] | None
) -> tuple[Dynamics, Array]:
    """A robot in the posture of a scene, and the normal of the ground."""
    plane = plane_of(scene)
    q = configuration(robot, scene.posture)
    loops = all_loops(robot, scene.closure)
    if loops:
        fixed = fixed_joints(robot, scene.posture, scene.assemble)
        q = assemble(robot, q, loops, plane, fixed).q
    if normal is None:
        up = ground_normal(plane, scene.strike.velocity or (0.0, 0.0, -1.0))
    else:
        up = np.array(normal) / (np.linalg.norm(normal) or 1.0)
    return dynamics(robot, q[None]), up


def _together(robot: Robot, state: Dynamics, up: Array, tolerance: float) -> list[tuple[str, ...]]:
    """All level feet, and those of each edge of their support polygon.

    Nothing if a single foot is the lowest.
    """
    feet = foot_points(robot, state.rotation, state.position, up)
    height = feet.points[0] @ up
    level = np.flatnonzero(height <= height.min() + tolerance)
    if len(level) < 2:
        return []
    every = tuple(feet.names[k] for k in level)
    landings = [every]
    for edge in _edges(feet.points[0, level], up):
        landings.append(tuple(every[k] for k in edge))
    return landings


def _edges(points: Array, up: Array) -> list[tuple[int, ...]]:
    """The points on each edge of the polygon around some points (n, 3) over the ground.

    None where all lie on one line.
    """
    flat = points - np.outer(points @ up, up)
    size = float(np.linalg.norm(flat[:, None] - flat, axis=2).max())
    edges: list[tuple[int, ...]] = []
    for i, j in itertools.combinations(range(len(flat)), 2):
        along = flat[j] - flat[i]
        length = float(np.linalg.norm(along))
        if length <= STRAIGHT * size:
            continue
        aside = (flat - flat[i]) @ np.cross(up, along / length) / size
        on_edge = tuple(np.flatnonzero(np.abs(aside) <= STRAIGHT).tolist())
        all_beside = aside.min() >= -STRAIGHT or aside.max() <= STRAIGHT
        if all_beside and len(on_edge) < len(flat) and on_edge not in edges:
            edges.append(on_edge)
    # Of three feet on one edge each pair finds it, and perhaps without the third.
    complete: list[tuple[int, ...]] = []
    for edge in edges:
        if not any(set(edge) < set(longer) for longer in edges):
            complete.append(edge)
    return complete


def _struck_shapes(robot: Robot, name: str) -> tuple[Shape, ...]:
    """The shapes with which a frame strikes; none where it is a place on a body."""
    strikes = striking(robot, name)
    return () if strikes.is_place else strikes.shapes
