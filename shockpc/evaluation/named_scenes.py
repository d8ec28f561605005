"""Landings by name: as a study takes them, with default contacts, and their one robot."""

from collections.abc import Mapping

from shockpc.landing.contact import contact_name
from shockpc.landing.feet.level_feet import with_contacts
from shockpc.landing.scenes.scene import Scene
from shockpc.landing.scenes.scene_file import robot_of, scene_of
from shockpc.robot.robot import Robot
from shockpc.text.errors import StudyError


def named_scenes(landings: Scene | str | Mapping[str, Scene | str]) -> dict[str, Scene]:
    """Landings by name, each as `scene_of`; the name of a single one is empty.

    Raises:
        StudyError: there is no landing.
    """
    if isinstance(landings, Scene | str):
        landings = {"": landings}
    if not landings:
        raise StudyError("no landing is given; give at least one scene")
    return {name: scene_of(scene) for name, scene in landings.items()}


def with_default_landings(landings: Mapping[str, Scene], robot: Robot) -> dict[str, Scene]:
    """Landings by name, those of a scene without contacts by its name and what strikes.

    Raises:
        ShockError: as for `default_landings`.
    """
    named: dict[str, Scene] = {}
    for name, scene in landings.items():
        for landing in with_contacts(scene, robot):
            full_name = name if scene.contact else f"{name} {contact_name(landing)}".strip()
            named[full_name] = landing
    return named


def common_robot(landings: Mapping[str, Scene]) -> Robot:
    """The robot of all landings, which are given by name.

    Raises:
        StudyError: there is no landing, or they are of different robots.
    """
    robots = {name: robot_of(scene) for name, scene in named_scenes(landings).items()}
    first, robot = next(iter(robots.items()))
    differing = [name for name, another in robots.items() if another is not robot]
    if differing:
        raise StudyError(
            f'the landings "{first}" and "{differing[0]}" are of different robots; give scenes '
            "that have the file, xacro arguments, packages and SRDF in common, and in an MJCF the "
            "robot that has the contact"
        )
    return robot
