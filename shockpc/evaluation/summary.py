"""A sweep in a few numbers: ranges and percentiles, what they depend on, and how far double precision was off."""

import itertools
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from typing import Any, NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.evaluation.columns import Column, percentile
from shockpc.evaluation.variation import Variation
from shockpc.evaluation.varied import Sweep
from shockpc.text.printed import alike

PERCENTILES = (5, 95, 99)
"""Of a sample, besides its median."""

RANKED = 100_000
"""Rows of which ranks are compared: what chance adds to their correlation is 0.003."""

BINS = 80
"""Of the distributions."""

CONSTANT = 1e-9
"""Share of the largest value by which values differ at least, for intervals of doubles to lie between them."""


class Extent(NamedTuple):
    """The range of one column, in the unit of its quantity.

    Attributes:
        column: the column.
        least: value.
        median: value.
        greatest: value.
        percentiles: the values at `PERCENTILES`, as `percentile` takes them.
        least_row: row of the least one.
        greatest_row: row of the greatest one; −1 if no row could be computed.
        best_row: row of the best value among the landings that flat ground allows; −1 if there is none.
        span: the least and the greatest finite value; wider where they differ by rounding alone.
        counts: number of rows in each of equal intervals between these.
        values: (rows,) all of them where they are drawn as a curve or a map; None otherwise.
    """

    column: Column
    least: float
    median: float
    greatest: float
    percentiles: tuple[float, ...]
    least_row: int
    greatest_row: int
    best_row: int
    span: tuple[float, float]
    counts: np.ndarray
    values: Array | None


class Refused(NamedTuple):
    """Numbers of rows that flat ground does not allow, each counted for its first cause.

    Attributes:
        rows: all of them.
        pulled: a contact would have to be pulled; none with friction, where it opens.
        below: another link is below the ground.
    """

    rows: int
    pulled: int
    below: int


class SweepSummary(NamedTuple):
    """A sweep in a few numbers.

    Attributes:
        sweep: what was computed.
        extents: of every shock, and of every further quantity.
        varied: what differs between the rows of a sample and is a number.
        correlations: (v, e) rank correlation (Spearman) of each of these with each of the extents' columns; NaN of a constant.
        ranked: number of rows of which they are.
        messages: why rows could not be computed, with the number of such rows, most frequent first.
        failed: number of rows that could not be computed.
        refused: numbers of rows that flat ground does not allow, left out or not.
        proven: number of rows that needed a proof and have one.
        compared: number of other rows that were proven as well.
        largest_error: how far double precision was off there at most, relative to the most severe shock of the same point.
    """

    sweep: Sweep
    extents: tuple[Extent, ...]
    varied: tuple[Variation, ...]
    correlations: Array
    ranked: int
    messages: tuple[tuple[str, int], ...]
    failed: int
    refused: Refused
    proven: int
    compared: int
    largest_error: float

    @property
    def chance(self) -> float:
        """The rank correlation that columns which do not depend on one another stay below in 19 of 20 samples."""
        return float(2.0 / max(self.ranked, 1) ** 0.5)


def summarise(sweep: Sweep, read: Callable[[str], Iterator[Any]], refused: Iterable[tuple[int, ...]]) -> SweepSummary:
    """Summarise a sweep.

    Args:
        sweep: the sweep.
        read: heading of a column, or "message" → its parts in order, (n,) each.
        refused: of each part the numbers of rows that flat ground does not allow, as in `Chunk`.
    """
    messages: Counter[str] = Counter()
    for part in read("message"):
        messages.update(alike(text for text in part if text))
    proven = compared = 0
    largest = 0.0
    for flags, errors in zip(read("proven"), read("double_error"), strict=True):
        proven += int(np.sum(flags))
        others = errors[~flags & ~np.isnan(errors)]
        compared, largest = compared + len(others), max(largest, float(np.max(others, initial=0.0)))
    feasible = _whole(sweep, read, sweep.feasible_column)
    pulled, below = (sum(counts) for counts in zip(*refused, strict=True))
    drawn = sweep.sample is None and len(sweep.variations) <= 2
    columns = [column for column in sweep.computed if column.shock or column.asked]
    varied = tuple(variation for variation in sweep.variations if sweep.sample is not None and variation.kind != "contact")
    step = -(-sweep.rows // RANKED)
    drivers = [_whole(sweep, read, variation.column)[::step].copy() for variation in varied]
    extents, effects = [], []
    for column in columns:
        values = _whole(sweep, read, column.name)
        effects.append(values[::step].copy() if varied else values[:0])
        extents.append(_extent(column, values, drawn, feasible == 1.0))
    correlations = np.array([[_correlation(x, y) for y in effects] for x in drivers]).reshape(len(drivers), len(effects))
    ranked = int(np.sum(~np.isnan(drivers[0]))) if drivers else 0
    return SweepSummary(
        sweep,
        tuple(extents),
        varied,
        correlations,
        ranked,
        tuple(messages.most_common()),
        sum(messages.values()),
        Refused(pulled + below, pulled, below),
        proven,
        compared,
        largest,
    )


def _whole(sweep: Sweep, read: Callable[[str], Iterator[Array]], name: str) -> Array:
    """A column (rows,) of all parts; NaN in rows that are left out."""
    values, end = np.full(sweep.rows, np.nan), 0
    for part, own in zip(read(name), read("row") if sweep.feasible else itertools.repeat(None), strict=False):
        values[slice(end, end + len(part)) if own is None else own.astype(int)] = part
        end += len(part)
    return values


def _correlation(x: Array, y: Array) -> float:
    """Rank correlation of two columns (n,) in the rows that have both; NaN if one is constant there."""
    from scipy.stats import rankdata

    known = ~(np.isnan(x) | np.isnan(y))
    a, b = rankdata(x[known]), rankdata(y[known])
    if not (np.ptp(a) if len(a) else 0.0) or not np.ptp(b):
        return np.nan
    return float(np.corrcoef(a, b)[0, 1])


def _extent(column: Column, values: Array, keep: bool, feasible: np.ndarray) -> Extent:
    """The range of a column. Of ten million rows no copy is made: the values are sorted in place unless they are kept."""
    missing, kept = np.isnan(values), values if keep else None
    if missing.all():
        nothing = (np.nan,) * len(PERCENTILES)
        return Extent(column, np.nan, np.nan, np.nan, nothing, -1, -1, -1, (0.0, 0.0), np.zeros(BINS, dtype=int), kept)
    allowed = np.flatnonzero(feasible & ~missing)
    best = np.argmax if column.selection.quantity.worse == "less" else np.argmin
    best_row = int(allowed[best(values[allowed])]) if allowed.size else -1
    low, high = int(np.nanargmin(values)), int(np.nanargmax(values))
    least, greatest = float(values[low]), float(values[high])
    known = values[~missing] if keep or missing.any() else values
    finite = known if np.isfinite([least, greatest]).all() else known[np.isfinite(known)]
    span = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 0.0)
    margin = max(CONSTANT * max(map(abs, span)), np.finfo(float).tiny)
    if span[1] - span[0] < margin:
        span = (span[0] - margin, span[1] + margin)
    counts, _ = np.histogram(finite, BINS, span)
    median = float(np.median(known, overwrite_input=True))
    percentiles = tuple(percentile(known, PERCENTILES).tolist())
    return Extent(column, least, median, greatest, percentiles, low, high, best_row, span, counts, kept)
