"""Shell completion of words besides commands and options.

They are robots, names in the robot that is typed, and quantities.
"""

import contextlib
import os
import re
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, TypeAlias

from shockpc.text.errors import ShockError

if TYPE_CHECKING:
    from shockpc.robot.robot import Robot

ASKED = "_SHOCKPC_COMPLETE"
"""The variable by which a shell asks, as Typer's scripts set it."""

LARGEST_FILE = 1_000_000
"""Size of a scene or robot file above which the names in it are not completed [bytes]."""

PLAIN_NAME = re.compile(r"[A-Za-z0-9_.:/+-]+")
"""A name that every shell inserts as it is.

Names in robot files are data, and shells run parts of others.
"""

Completer: TypeAlias = Callable[[str], Iterable[str]]


def words_typed() -> list[str]:
    """The words typed so far after the name of the program."""
    return (os.environ.get("COMP_WORDS") or os.environ.get("_TYPER_COMPLETE_ARGS", "")).split()[1:]


def completer(name: str, form: str | None) -> Completer | None:
    """The function that completes a parameter, or nothing.

    Args: name; form, of its value.
    """
    if name in ("contact", "stance"):
        return _contacts
    return COMPLETERS.get(re.split("[^A-Z]", form or "")[0])


def _robots(incomplete: str) -> Iterable[str]:
    from shockpc.robot.catalogue import catalogue

    names: list[str] = []
    for entry in catalogue():
        names += [entry.name, *entry.aliases]
    return names


def _robot() -> "Robot | None":
    """The robot of the first word that names one, or a scene, in a file that is read quickly."""
    from shockpc.cli.scenes import scene_named
    from shockpc.landing.scenes.scene_file import robot_of

    for word in words_typed()[1:]:
        if os.path.isfile(word) and os.path.getsize(word) > LARGEST_FILE:
            continue
        with contextlib.suppress(ShockError):
            scene = scene_named(word)
            return robot_of(scene) if _is_read_quickly(scene.robot) else None
    return None


def _is_read_quickly(robot: str) -> bool:
    """True if the file of a robot is at most `LARGEST_FILE` long and needs no xacro.

    xacro runs what the file says.

    Raises:
        ShockError: there is no such file.
    """
    from shockpc.robot.catalogue import find_robot
    from shockpc.robot.files.reading import read_text

    path, _ = find_robot(robot)
    if path.suffix == ".xacro" or not path.is_file() or path.stat().st_size > LARGEST_FILE:
        return False
    return "xacro:" not in read_text(path)


def _plain(names: Iterable[str]) -> list[str]:
    """The names that every shell inserts as they are."""
    return [name for name in names if PLAIN_NAME.fullmatch(name)]


def _contacts(incomplete: str) -> Iterable[str]:
    """Feet, and all that may be a contact, also after A+."""
    from shockpc.robot.feet_and_sensors import each_foot

    robot, before = _robot(), incomplete[: incomplete.rfind("+") + 1]
    if robot is None or (before and not _plain([before])):
        return []
    return [before + name for name in _plain(dict.fromkeys([*each_foot(robot), *robot.frames]))]


def _frames(incomplete: str) -> Iterable[str]:
    robot = _robot()
    return [] if robot is None else _plain(robot.frames)


def _joints(incomplete: str) -> Iterable[str]:
    robot = _robot()
    return [] if robot is None else _plain(robot.joint_names)


def _quantities(incomplete: str) -> Iterable[str]:
    """The keys, and the places after an @."""
    from shockpc.quantities.selection import selections

    key, at, _ = incomplete.partition("@")
    if not at:
        return list(selections())
    return [f"{key}@{name}" for name in (*_frames(""), *_joints(""))]


COMPLETERS: dict[str, Completer] = {
    **dict.fromkeys(("ROBOT", "SCENE", "DESIGN"), _robots),
    **dict.fromkeys(("FRAME", "BODY", "LINK"), _frames),
    "JOINT": _joints,
    "KEY": _quantities,
}
"""Functions that complete values, by the first word of their form."""
