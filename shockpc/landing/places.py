"""Places of a landing that numbers belong to: the robot, its bodies, points on them, parts, joints
and contacts.
"""

from typing import Literal, NamedTuple

import numpy as np

from shockpc.core.memo import memoized
from shockpc.core.spatial import Array, read_only
from shockpc.landing.scene import Part, Point
from shockpc.landing.scene_file import point_at
from shockpc.robot.feet_and_sensors import sensors
from shockpc.robot.robot import Robot
from shockpc.text.errors import SceneError, StudyError
from shockpc.text.printed import printable

PlaceKind = Literal["robot", "body", "point", "joint", "contact", "part"]


class Place(NamedTuple):
    """What a number belongs to.

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
    named = [
        point_place(robot, point)
        for point in (*(Point(frame=name) for name in sensors(robot)), *points)
    ]
    return tuple({place.name: place for place in named}.values())


def part_places(robot: Robot, parts: tuple[Part, ...]) -> tuple[Place, ...]:
    """The parts, at a point of a body or of a joint.

    A part of several joints is one of each: PART/JOINT, or JOINT where the part has the name of its
    pattern.

    Raises:
        UnknownName: the robot has no frame, or no joint, of that name.
        SceneError: the point is not a single one, or fixed to the world; or two parts have one
            name.
    """
    places, joints = [], {place.name: place for place in joint_places(robot)}
    for k, part in enumerate(parts):
        if part.at is not None:
            places.append(
                point_place(robot, point_at(robot, part.at))._replace(name=part.name, number=k)
            )
        elif part.joint is not None:
            matched = [joints[name] for name in robot.match_joints(part.joint)]
            one = len(matched) == 1
            names = [
                part.name if one else p.name if part.name == part.joint else f"{part.name}/{p.name}"
                for p in matched
            ]
            places += [
                Place(name, place.body, number=k, joint=place.number)
                for name, place in zip(names, matched, strict=True)
            ]
    names = [place.name for place in places]
    if twice := [name for name in names if names.count(name) > 1]:
        raise SceneError(f'two parts are called "{printable(twice[0])}"; rename one of them')
    if fixed := [place.name for place in places if place.body < 0]:
        raise SceneError(
            f'part "{printable(fixed[0])}" is fixed to the world, so no impact moves it; name a '
            f"frame on a moving link"
        )
    return tuple(places)


@memoized()
def joint_places(robot: Robot) -> tuple[Place, ...]:
    """The joints between bodies, as the file has them."""
    carried = (
        (i, part) for i, joint in enumerate(robot.joints) for part in joint.parts or (joint,)
    )
    return tuple(
        Place(part.name, i, number=part.v.start) for i, part in carried if i or not robot.free_base
    )
