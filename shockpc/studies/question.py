"""Checks shared by studies: landings of one robot, and no option that would have no effect."""

from collections.abc import Mapping

from shockpc.landing.scene import Scene
from shockpc.landing.scene_file import robot_of
from shockpc.robot.robot import Robot
from shockpc.text.errors import StudyError


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
