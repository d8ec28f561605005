"""Numbers as they are given: in texts, with their units, and in arrays.

What is not wholly a number is refused.
"""

import math
import re
from collections.abc import Mapping, Sequence
from numbers import Real
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from shockpc.core.spatial import Array

NUMBER = r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?"
"""Pattern of a number: decimal digits with at most one point and an exponent.

Blanks, other signs and other digits are in none.
"""

_WITH_UNIT = re.compile(rf"({NUMBER})\s*(.*)")

NO_UNIT: Mapping[str, float] = {"": 1.0}

NUMERIC = "biuf"
"""Kinds of arrays of real numbers: booleans, integers and floating-point numbers."""


def number_from(text: str, units: Mapping[str, float] = NO_UNIT) -> float:
    """The finite number that a text gives, times the factor of its unit.

    Args:
        text: a number, and behind it, after any blanks, a unit.
        units: the factor of each unit that may be given; that of the empty one where none has to be
            given.

    Raises:
        ValueError: it is not a number, or has another unit.
    """
    value = math.nan
    match = _WITH_UNIT.fullmatch(text.strip())
    if match and match[2] in units:
        value = float(match[1]) * units[match[2]]
    if not math.isfinite(value):
        raise ValueError(f'"{text}" is not a number')
    return value


def number_within(text: str, units: Mapping[str, float], least: float, most: float) -> float:
    """The number that a text gives, as `number_from`, from `least` to `most`.

    Raises:
        ValueError: it is not a number, has another unit, or is not within the bounds.
    """
    value = number_from(text, units)
    if not least <= value <= most:
        raise ValueError(f'"{text}" is not from {least:g} to {most:g}')
    return value


def factor_texts(texts: Sequence[str]) -> tuple[list[str], bool]:
    """Texts of numbers without the x of factors, and True if they are factors."""
    stripped = [text.strip() for text in texts]
    if all(text.endswith("x") for text in stripped):
        return [text.removesuffix("x") for text in stripped], True
    return stripped, False


def whole_from(text: str) -> int:
    """The whole number that a text gives.

    Raises: ValueError: it is none, or has more than 300 digits.
    """
    if not re.fullmatch("[-+]?[0-9]{1,300}", text.strip()):
        raise ValueError(f'"{text}" is not a whole number')
    return int(text)


def numbers_from(values: Any) -> "Array":
    """Real numbers as an array of doubles.

    Raises:
        TypeError: one is a text, a date, a complex number or anything else.
        ValueError: their shape is not that of an array.
    """
    import numpy as np  # the help of a command needs no arrays

    array = np.asarray(values)
    real = array.dtype.kind in NUMERIC
    if array.dtype.kind == "O":
        real = all(isinstance(value, Real) for value in array.ravel().tolist())
    if not real:
        raise TypeError("only real numbers are numbers here")
    return array.astype(float)
