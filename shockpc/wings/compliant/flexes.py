"""Bending of links, as a scene says it."""

from collections.abc import Mapping

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
