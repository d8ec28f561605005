"""What several studies ask for: one robot, a point that moves, the strike angle, and nothing given that has no effect."""

from collections.abc import Mapping

import numpy as np

from shockpc.errors import StudyError
from shockpc.landing import Landing
from shockpc.places import Place, point_place
from shockpc.robot.record import Robot
from shockpc.scene import Point, Scene, robot_of


def common_robot(landings: Mapping[str, Scene]) -> Robot:
    """The robot of all landings, which are given by name.

    Raises:
        StudyError: there is no landing, or they are of different robots.
    """
    robots = {name: robot_of(scene) for name, scene in landings.items()}
    if not robots:
        raise StudyError("no landing is given; give at least one scene")
    (first, robot), *_ = robots.items()
    other = next((name for name, another in robots.items() if another is not robot), None)
    if other is not None:
        raise StudyError(
            f'the landings "{first}" and "{other}" are of different robots; give scenes that have the file, xacro arguments, '
            "packages and SRDF in common, and in an MJCF the robot that has the contact"
        )
    return robot


def moving_point(robot: Robot, point: Point) -> Place:
    """A point on a body.

    Raises:
        UnknownName: the robot has no frame of that name.
        StudyError: the frame is fixed to the world.
    """
    place = point_place(robot, point)
    if place.body < 0:
        raise StudyError(f'point "{place.name}" is fixed to the world, so no strike moves it; name a frame on a moving link')
    return place


def strike_angle(landing: Landing) -> float:
    """Angle of the base's velocity in the plane, from straight down towards forward [rad]."""
    velocity = landing.before.velocity
    return float(np.arctan2(velocity @ landing.plane.forward, -velocity[2]))


def refuse_ground(scene: Scene, *, friction: bool = True, others: str = "use shockpc analyze, sweep, check or compare") -> None:
    """Refuse what a study of contacts that stick and are rigid would ignore.

    Args:
        scene: a landing of the study.
        friction: whether a coefficient of friction has no effect either.
        others: what else can be done.

    Raises:
        StudyError: the scene gives a contact stiffness, or a friction.
    """
    given = {"contact stiffness": scene.contact_stiffness, "friction": scene.friction if friction else None}
    ignored = [name for name, value in given.items() if value is not None]
    if ignored:
        raise StudyError(
            f"the scene gives a {' and a '.join(ignored)}, which would change nothing here: this study is of the impulse of "
            f"contacts that stick; leave it out, or {others}"
        )
