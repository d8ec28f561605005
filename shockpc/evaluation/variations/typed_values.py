"""The grammar of values that vary, as they are typed: lists, grids, ranges and distributions."""

import math
from collections.abc import Iterable, Sequence
from typing import Any, Literal, NamedTuple

import numpy as np

from shockpc.core.number import factor_texts, number_from, numbers_from, whole_from
from shockpc.text.errors import StudyError

FORM = (
    "a:b:n (n values from a to b), a,b,c (these values) or, with --sample, a:b (any value "
    "between), a:b:log (log-uniform) or m±s "
    "(normal, cut off at 3 s; also typed m+-s)"
)

CUT = 3.0
"""Standard deviations from the mean at which a normal distribution is cut off."""

Law = Literal["uniform", "log-uniform", "normal"]

MOST_VALUES = 1_000_000
"""Values of one quantity in a grid."""


class Values(NamedTuple):
    """Numbers that are computed, or a range from which they are drawn.

    Attributes:
        numbers: to be computed.
        span: smallest and largest number that is drawn; None if the numbers are given.
        law: distribution of the numbers that are drawn; a normal one has its mean in the middle of
            the span, which is six standard deviations.
        factor: whether the numbers are factors of what the landing has.
        mean: whether a normal distribution was typed with its mean.
    """

    numbers: tuple[float, ...] = ()
    span: tuple[float, float] | None = None
    law: Law = "uniform"
    factor: bool = False
    mean: bool = True

    @property
    def smallest(self) -> float:
        """The smallest number."""
        return min(self.span or self.numbers)


def values_from(subject: str, values: Any) -> Values:
    """Values from a text, from a number, or from several.

    Args:
        subject: what varies, which messages begin with.
        values: a text as `FORM` describes, with an x behind each number of a list or range of
            factors, or "±5%" for factors with this standard deviation; or numbers.

    Raises:
        StudyError: the text is not of this form, a number is not finite, or there is none.
    """
    if isinstance(values, str):
        return _from_text(subject, values)
    if isinstance(values, np.ndarray):
        values = values.tolist()
    several = isinstance(values, Iterable) and not isinstance(values, bytes)
    listed = list(values) if several else [values]
    if not listed:
        raise StudyError(f"{subject}: the list of values is empty; give at least one")
    return Values(tuple(_number(subject, value) for value in listed))


def _from_text(subject: str, text: str) -> Values:
    mean, sign, deviation = text.replace("+-", "±").partition("±")
    if sign:
        return _normal(subject, text, mean, deviation.strip())
    if ":" in text:
        return _range(subject, text)
    numbers, factor = _numbers(subject, text.split(","))
    return Values(numbers, factor=factor)


def _normal(subject: str, text: str, mean: str, deviation: str) -> Values:
    """A normal distribution m±s, or ±p% for factors with mean 1."""
    factor = deviation.endswith("%") and not mean.strip()
    if factor:
        size = _number(subject, deviation.removesuffix("%")) / 100.0
    else:
        size = _number(subject, deviation)
    middle = 1.0 if factor else 0.0
    if mean.strip():
        middle = _number(subject, mean.strip())
    if not size > 0.0:
        raise StudyError(
            f'{subject}: "{text}" has no standard deviation above zero; valid are {FORM}'
        )
    span = (middle - CUT * size, middle + CUT * size)
    return Values((), span, "normal", factor, mean=bool(mean))


def _range(subject: str, text: str) -> Values:
    """A range a:b or a:b:log, from which numbers are drawn; or the n numbers of a:b:n."""
    parts = text.split(":")
    count = parts.pop() if len(parts) == 3 else None
    bounds, factor = _numbers(subject, parts)
    if len(bounds) != 2:
        raise StudyError(f'{subject}: "{text}" is not understood; valid are {FORM}')
    low, high = bounds
    logarithmic = count is not None and count.strip() == "log"
    if count is not None and not logarithmic:
        return Values(_grid(low, high, _count(subject, count)), factor=factor)
    if not low < high:
        raise StudyError(
            f"{subject}: the range {low:g}:{high:g} is empty; give the smaller value first"
        )
    return Values((), (low, high), "log-uniform" if logarithmic else "uniform", factor)


def _grid(low: float, high: float, n: int) -> tuple[float, ...]:
    """N equidistant numbers from low to high, both as typed."""
    if n == 1:
        return (low,)
    # A share k / (n − 1) gives the same number for every n.
    shares = [k / (n - 1) for k in range(n - 1)]
    return (*(low + (high - low) * share for share in shares), high)


def _count(subject: str, text: str) -> int:
    try:
        n = whole_from(text)
    except ValueError:
        n = 0
    if not 1 <= n <= MOST_VALUES:
        raise StudyError(
            f'{subject}: "{text}" is not a number of values from 1 to {MOST_VALUES}; valid are '
            f"{FORM}"
        )
    return n


def _numbers(subject: str, parts: Sequence[str]) -> tuple[tuple[float, ...], bool]:
    """The numbers, and whether they are factors."""
    texts, factor = factor_texts(parts)
    return tuple(_number(subject, text) for text in texts), factor


def _number(subject: str, value: Any) -> float:
    """A finite number from a text, or from a number of any type."""
    number = math.nan
    try:
        if isinstance(value, str):
            number = number_from(value)
        elif not isinstance(value, bool | bytes) and not np.ndim(value):
            number = float(numbers_from(value))
    except (ValueError, TypeError, OverflowError):
        number = math.nan
    if not math.isfinite(number):
        raise StudyError(f'{subject}: "{value}" is not a finite number; valid are {FORM}')
    return number
