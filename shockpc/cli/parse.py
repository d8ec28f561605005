"""Words of the command line to values; every refusal names the option and shows what would be valid."""

import math
from collections.abc import Iterable
from pathlib import Path

from shockpc.errors import SceneError

__all__ = ["assignment", "number", "package_folders", "vector", "xacro_arguments"]


def number(option: str, text: str) -> float:
    """A finite number.

    Raises:
        SceneError: it is not one.
    """
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise SceneError(f'{option}: "{text}" is not a finite number')
    return value


def vector(option: str, text: str, valid: str) -> tuple[float, float, float]:
    """Three numbers with commas between them.

    Args:
        option: what it was typed for.
        text: as typed.
        valid: what would be valid, such as "0,0,-0.02", for the message.

    Raises:
        SceneError: they are not.
    """
    parts = text.split(",")
    if len(parts) != 3:
        raise SceneError(f'{option}: "{text}" is not three numbers with commas between them, such as {valid}')
    x, y, z = (number(option, part) for part in parts)
    return x, y, z


def assignment(option: str, text: str, form: str, valid: str) -> tuple[str, str]:
    """NAME=VALUE, or NAME:=VALUE as xacro writes it.

    Args:
        option: what it was typed for.
        text: as typed.
        form: what the option takes, such as "JOINT=VALUE", for the message.
        valid: an example, for the message.

    Raises:
        SceneError: there is no name or no value.
    """
    name, equals, value = text.partition("=")
    name = name.removesuffix(":").strip()
    if not (name and equals and value.strip()):
        raise SceneError(f'{option}: "{text}" is not {form}, such as {valid}')
    return name, value.strip()


def xacro_arguments(texts: Iterable[str]) -> dict[str, str]:
    """The values of --xacro, by name."""
    return dict(assignment("--xacro", text, "NAME:=VALUE", "payload:=1.5") for text in texts)


def package_folders(texts: Iterable[str]) -> dict[str, str]:
    """The folders of --package, by name; a shell leaves the ~ behind the = to us."""
    pairs = (assignment("--package", text, "NAME=DIR", "dog_description=../dog") for text in texts)
    return {name: str(Path(folder).expanduser()) for name, folder in pairs}
