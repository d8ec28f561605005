"""A sweep in a few numbers: least, median and greatest shock of every point, and how far double precision was off."""

from collections import Counter
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.studies.sweep.rows import Sweep

__all__ = ["Extent", "SweepSummary", "summarise"]

BINS = 80
"""Of the distributions."""


class Extent(NamedTuple):
    """The range of one column of shocks.

    Attributes:
        heading: of the column.
        least: [1]
        median: [1]
        greatest: [1]
        least_row: row of the least one.
        greatest_row: row of the greatest one; −1 if no row could be computed.
        counts: number of rows in each of equal intervals from the least to the greatest.
        values: (rows,) all of them where they are drawn as a curve or a map; None otherwise.
    """

    heading: str
    least: float
    median: float
    greatest: float
    least_row: int
    greatest_row: int
    counts: np.ndarray
    values: Array | None


class SweepSummary(NamedTuple):
    """A sweep in a few numbers.

    Attributes:
        sweep: what was computed.
        extents: of every shock.
        messages: why rows could not be computed, with the number of such rows, most frequent first.
        failed: number of rows that could not be computed.
        proven: number of rows that asked for a proof and have one.
        compared: number of other rows that were proven as well.
        largest_error: how far double precision was off there at most, relative to the most severe shock of the same point.
    """

    sweep: Sweep
    extents: tuple[Extent, ...]
    messages: tuple[tuple[str, int], ...]
    failed: int
    proven: int
    compared: int
    largest_error: float


def summarise(sweep: Sweep, read: Callable[[str], Iterator[Any]]) -> SweepSummary:
    """Summarise a sweep.

    Args:
        sweep: the sweep.
        read: heading of a column, or "message" → its parts in order, (n,) each.
    """
    messages: Counter[str] = Counter()
    for part in read("message"):
        messages.update(text for text in part if text)
    proven = compared = 0
    largest = 0.0
    for flags, errors in zip(read("proven"), read("double_error"), strict=True):
        proven += int(np.sum(flags))
        others = errors[~flags & ~np.isnan(errors)]
        compared, largest = compared + len(others), max(largest, float(np.max(others, initial=0.0)))
    drawn = sweep.sample is None and len(sweep.variations) <= 2
    headings = [column.name for column in sweep.computed if column.shock]
    extents = tuple(_extent(heading, _whole(sweep.rows, read(heading)), drawn) for heading in headings)
    return SweepSummary(sweep, extents, tuple(messages.most_common()), sum(messages.values()), proven, compared, largest)


def _whole(rows: int, parts: Iterator[Array]) -> Array:
    """A column (rows,) of all parts."""
    values = np.empty(rows)
    end = 0
    for part in parts:
        values[end : end + len(part)] = part
        end += len(part)
    return values


def _extent(heading: str, values: Array, keep: bool) -> Extent:
    """The range of a column. Of ten million rows no copy is made: the values are sorted in place unless they are kept."""
    missing = np.isnan(values)
    if missing.all():
        return Extent(heading, np.nan, np.nan, np.nan, -1, -1, np.zeros(BINS, dtype=int), values if keep else None)
    low, high = int(np.nanargmin(values)), int(np.nanargmax(values))
    least, greatest = float(values[low]), float(values[high])
    known = values[~missing] if keep or missing.any() else values
    counts, _ = np.histogram(known, BINS, (least, greatest))
    median = float(np.median(known, overwrite_input=True))
    return Extent(heading, least, median, greatest, low, high, counts, values if keep else None)
