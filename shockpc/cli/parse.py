"""Words of the command line to values; every refusal names the option and shows what would be valid."""

import math

from shockpc.errors import SceneError

__all__ = ["assignment", "number", "vector"]


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


def vector(option: str, text: str) -> tuple[float, float, float]:
    """Three numbers with commas between them.

    Raises:
        SceneError: they are not.
    """
    parts = text.split(",")
    if len(parts) != 3:
        raise SceneError(f'{option}: "{text}" is not three numbers with commas between them, such as 0,0,-0.02')
    x, y, z = (number(option, part) for part in parts)
    return x, y, z


def assignment(option: str, text: str, example: str) -> tuple[str, str]:
    """NAME=VALUE, or NAME:=VALUE as xacro writes it.

    Raises:
        SceneError: there is no name or no value.
    """
    name, equals, value = text.partition("=")
    name = name.removesuffix(":").strip()
    if not (name and equals and value.strip()):
        raise SceneError(f'{option}: "{text}" is not NAME=VALUE, such as {example}')
    return name, value.strip()
