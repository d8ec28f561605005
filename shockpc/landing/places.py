"""Places of a landing that numbers belong to.

They are the robot, its bodies, points on them, parts, joints and contacts.
"""

from typing import Literal, NamedTuple

import numpy as np

from shockpc.core.memo import memoized
from shockpc.core.spatial import Array, read_only
from shockpc.landing.scenes.scene import Part, Point
from shockpc.landing.scenes.scene_file import point_at
from shockpc.robot.feet_and_sensors import sensors
from shockpc.robot.robot import Robot
from shockpc.text.errors import SceneError, StudyError
from shockpc.text.printed import printable

PlaceKind = Literal["robot", "body", "point", "joint", "contact", "part"]


class Place(NamedTuple):
    """A place that a number belongs to.

    Attributes:
        name: as it is typed.
        body: index of the body; −1 for the world, the robot and contacts.
        r: (3,) the point in the body's frame [m].
        axes: (3, 3) axes of the point's frame, in the body's frame.
        centre: whether the point is the body's centre of mass, wherever it is of the robot that is
            computed.
        number: of a contact among the landing's contacts and standing feet; of a joint, where its
            velocities begin in q̇; of a part among those of the scene.
        joint: of a part of a joint: where the velocities of that begin in q̇; −1 for all else.
    """

    name: str
    body: int = -1
    r: Array = read_only(np.zeros(3))
    axes: Array = read_only(np.eye(3))
    centre: bool = False
    number: int = 0
    joint: int = -1

    @property
    def title(self) -> str:
        """Its name as people read it."""
        return f"CoM of {self.name}" if self.centre else self.name


@memoized()
def body_places(robot: Robot) -> tuple[Place, ...]:
    """The bodies, each with its centre of mass."""
    return tuple(Place(body.name, i, body.com, centre=True) for i, body in enumerate(robot.bodies))


def point_place(robot: Robot, point: Point) -> Place:
    """The point that a scene or a study names.

    Raises:
        UnknownName: the robot has no frame of that name.
    """
    frame = robot.frame(point.frame)
    r = read_only(frame.offset + frame.rotation @ np.asarray(point.offset, dtype=float))
    return Place(point.label, frame.body, r, frame.rotation)


def moving_point(robot: Robot, point: Point) -> Place:
    """A point on a body.

    Raises:
        UnknownName: the robot has no frame of that name.
        StudyError: the frame is fixed to the world.
    """
    place = point_place(robot, point)
    if place.body < 0:
        raise StudyError(
            f'point "{place.name}" is fixed to the world, so no impact moves it; name a frame on '
            "a moving link"
        )
    return place


def point_places(robot: Robot, points: tuple[Point, ...]) -> tuple[Place, ...]:
    """The robot's sensors, then the points asked for; each once.

    Raises:
        UnknownName: the robot has no frame of that name.
    """
    of_sensors = [Point(frame=name) for name in sensors(robot)]
    places: dict[str, Place] = {}
    for point in (*of_sensors, *points):
        place = point_place(robot, point)
        places[place.name] = place
    return tuple(places.values())


def part_places(robot: Robot, parts: tuple[Part, ...]) -> tuple[Place, ...]:
    """The parts, at a point of a body or of a joint.

    A part of several joints is one of each: PART/JOINT, or JOINT where the part has the name of its
    pattern.

    Raises:
        UnknownName: the robot has no frame, or no joint, of that name.
        SceneError: the point is not a single one, or fixed to the world; or two parts have one
            name.
    """
    places: list[Place] = []
    for number, part in enumerate(parts):
        if part.at is not None:
            at = point_place(robot, point_at(robot, part.at))
            places.append(at._replace(name=part.name, number=number))
        elif part.joint is not None:
            places += _joints_of_part(robot, part, part.joint, number)
    names = [place.name for place in places]
    twice = [name for name in names if names.count(name) > 1]
    if twice:
        raise SceneError(f'two parts are called "{printable(twice[0])}"; rename one of them')
    fixed = [place.name for place in places if place.body < 0]
    if fixed:
        raise SceneError(
            f'part "{printable(fixed[0])}" is fixed to the world, so no impact moves it; name a '
            f"frame on a moving link"
        )
    return tuple(places)


def _joints_of_part(robot: Robot, part: Part, pattern: str, number: int) -> list[Place]:
    """A part of joints at each of those that its pattern means."""
    joints = {place.name: place for place in joint_places(robot)}
    matched = [joints[name] for name in robot.match_joints(pattern)]
    places: list[Place] = []
    for joint in matched:
        name = f"{part.name}/{joint.name}"
        if len(matched) == 1:
            name = part.name
        elif part.name == pattern:
            name = joint.name
        places.append(Place(name, joint.body, number=number, joint=joint.number))
    return places


@memoized()
def joint_places(robot: Robot) -> tuple[Place, ...]:
    """The joints between bodies, as the file has them."""
    places: list[Place] = []
    for i, joint in enumerate(robot.joints):
        if i == 0 and robot.free_base:
            continue
        for part in joint.parts or (joint,):
            places.append(Place(part.name, i, number=part.v.start))
    return tuple(places)
