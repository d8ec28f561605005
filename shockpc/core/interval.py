"""A number that is known, or an interval that holds it."""

from typing import TypeAlias

Interval: TypeAlias = float | tuple[float, float]
"""A number, or the smallest and the largest that it may be."""


def ends(value: Interval) -> tuple[float, float]:
    """The smallest and the largest number of an interval."""
    return value if isinstance(value, tuple) else (value, value)


def middle(value: Interval) -> float:
    """The number that is computed with: the arithmetic middle of an interval."""
    low, high = ends(value)
    return low + 0.5 * (high - low)


def interval_fault(value: Interval) -> str:
    """Why this is no interval of numbers of one sign; empty if it is."""
    low, high = ends(value)
    if low > high:
        return f"is {low:g} to {high:g}; give the smaller number first"
    return f"is {low:g} to {high:g}, which has both signs" if low < 0.0 < high else ""


def interval_text(value: Interval) -> str:
    """An interval for messages, such as "0.01" or "0.005 to 0.02"."""
    return " to ".join(f"{end:g}" for end in dict.fromkeys(ends(value)))
