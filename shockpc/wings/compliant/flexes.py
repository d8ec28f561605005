"""Bending of links, as a scene says it."""

from collections.abc import Iterable, Mapping

from shockpc.robot.robot import Robot
from shockpc.text.errors import SceneError
from shockpc.wings.compliant.motion.segments import Flex, flex_from


def flexes_of(given: Mapping[str, str]) -> tuple[tuple[str, Flex], ...]:
    """Bending of links, each with its pattern.

    Args: given, of a scene.

    Raises:
        SceneError: a text says nothing of it.
    """
    flexes = []
    for pattern, text in given.items():
        try:
            flexes.append((pattern, flex_from(text)))
        except ValueError as refusal:
            raise SceneError(f'flex of "{pattern}": {refusal}', bodies=[pattern]) from None
    return tuple(flexes)


def flexes_by_body(robot: Robot, flexes: Iterable[tuple[str, Flex]]) -> dict[int, Flex]:
    """Bending of the bodies that bend, by their index.

    Args: flexes, each with its name or a glob; of two that fit a body the latter.

    Raises:
        UnknownName: a pattern fits no body.
    """
    by_body: dict[int, Flex] = {}
    for pattern, flex in flexes:
        by_body |= dict.fromkeys(robot.match_bodies(pattern), flex)
    return by_body
