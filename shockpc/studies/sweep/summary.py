"""Many landings in a few numbers: ranges and percentiles, what they depend on, and how far double
precision was off.
"""

from collections.abc import Sequence
from typing import Generic, NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.evaluation.column import Column
from shockpc.evaluation.evaluate import Evaluation, L
from shockpc.evaluation.table import Table, percentile
from shockpc.evaluation.variation import Variation
from shockpc.text.printed import Cause, causes

PERCENTILES = (5, 95, 99)
"""Of a sample, besides its median."""

RANKED = 100_000
"""Rows of which ranks are compared: what chance adds to their correlation is 0.003."""

BINS = 80
"""Of the distributions."""

CONSTANT = 1e-9
"""Share of the largest value by which values differ at least, for intervals of doubles to lie
between them.
"""


class Extent(NamedTuple):
    """The range of one column, in the unit of its quantity.

    Attributes:
        column: the column.
        least: value.
        median: value.
        greatest: value.
        percentiles: the values at `PERCENTILES`, as `percentile` takes them.
        least_row: row of the smallest one.
        greatest_row: row of the largest one; −1 if no row could be computed.
        best_row: row of the best value among the landings that flat ground allows; −1 if there is
            none.
        span: the smallest and the largest finite value; wider where they differ only by rounding.
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
        gained: the impact would make energy; none with friction, where contacts slide.
        below: another link is below the ground.
    """

    rows: int
    pulled: int
    gained: int
    below: int


class Summary(NamedTuple, Generic[L]):
    """Many landings in a few numbers.

    Attributes:
        evaluation: what was computed.
        rows: number of rows, those too that are left out.
        extents: of the columns that are summarised.
        varied: what differs between the rows of a sample and is a number.
        correlations: (v, e) rank correlation (Spearman) of each of these with each of the extents'
            columns; NaN of a constant.
        ranked: number of rows of which they are.
        messages: why rows could not be computed, with the number of such rows and the first of
            them, most frequent first.
        failed: number of rows that could not be computed.
        refused: numbers of rows that flat ground does not allow, left out or not.
        tilted: number of rows that it allows only if the robot is tilted a little, as other feet
            are level.
        proven: number of rows that needed a proof and have one.
        compared: number of other rows that were proven as well.
        largest_error: how far double precision was off there at most, relative to the most severe
            shock of the same point.
    """

    evaluation: Evaluation[L]
    rows: int
    extents: tuple[Extent, ...]
    varied: tuple[Variation, ...]
    correlations: Array
    ranked: int
    messages: tuple[Cause, ...]
    failed: int
    refused: Refused
    tilted: int
    proven: int
    compared: int
    largest_error: float

    @property
    def chance(self) -> float:
        """The rank correlation that columns which do not depend on one another stay below in 19 of
        20 samples.
        """
        return float(2.0 / max(self.ranked, 1) ** 0.5)


def summarise(
    evaluation: Evaluation[L], table: Table, varied: Sequence[Variation] = (), keep: bool = False
) -> Summary[L]:
    """Summarise landings.

    Args:
        evaluation: what was computed.
        table: its rows.
        varied: what differs between the rows and is a number, with which results are correlated.
        keep: whether the values are drawn as a curve or a map.
    """
    messages = causes((int(table.numbers[i]), text) for i, text in table.messages.items())
    flags, errors = table.columns["proven"].astype(bool), table.columns["double_error"]
    others = errors[~flags & ~np.isnan(errors)]
    feasible, rows = table.feasible, evaluation.landings.rows
    columns = [column for column in evaluation.computed if column.shock or column.requested]
    step = -(-rows // RANKED)
    drivers = [_whole(table, rows, variation.column)[::step] for variation in varied]
    extents, effects = [], []
    for column in columns:
        effects += [_whole(table, rows, column.name)[::step]] if varied else []
        extents.append(_extent(column, table, feasible, rows if keep else 0))
    correlations = np.array([[_correlation(x, y) for y in effects] for x in drivers]).reshape(
        len(drivers), len(columns)
    )
    return Summary(
        evaluation,
        rows,
        tuple(extents),
        tuple(varied),
        correlations,
        int(np.sum(~np.isnan(drivers[0]))) if drivers else 0,
        tuple(messages),
        sum(cause.rows for cause in messages),
        Refused(sum(table.refused), *table.refused),
        int(np.sum(table.tilted)),
        int(flags.sum()),
        len(others),
        float(np.max(others, initial=0.0)),
    )


def _whole(table: Table, rows: int, name: str) -> Array:
    """A column (rows,) with NaN in rows that are left out."""
    values = np.full(rows, np.nan)
    values[table.numbers] = table.columns[name]
    return values


def _correlation(x: Array, y: Array) -> float:
    """Rank correlation of two columns (n,) in the rows that have both; NaN if one is constant
    there.
    """
    known = ~(np.isnan(x) | np.isnan(y))
    a, b = _ranks(x[known]), _ranks(y[known])
    if not (np.ptp(a) if len(a) else 0.0) or not np.ptp(b):
        return np.nan
    return float(np.corrcoef(a, b)[0, 1])


def _ranks(x: Array) -> Array:
    """The rank (n,) of each of some values; equal ones share the mean of theirs.

    SciPy's takes longer to import than a sweep.
    """
    _, number, count = np.unique(x, return_inverse=True, return_counts=True)
    return np.asarray((np.cumsum(count) - 0.5 * (count - 1))[number])


def _extent(column: Column, table: Table, feasible: np.ndarray, drawn: int) -> Extent:
    """The range of a column.

    Args: feasible (n,) of the rows; drawn, the number of all rows if the values are drawn.
    """
    values, numbers = np.array(table.columns[column.name]), table.numbers
    missing, whole = np.isnan(values), _whole(table, drawn, column.name) if drawn else None
    if missing.all():
        nothing = (np.nan,) * len(PERCENTILES)
        return Extent(
            column,
            np.nan,
            np.nan,
            np.nan,
            nothing,
            -1,
            -1,
            -1,
            (0.0, 0.0),
            np.zeros(BINS, dtype=int),
            whole,
        )
    allowed = np.flatnonzero(feasible & ~missing)
    best = np.argmax if column.selection.quantity.worse == "less" else np.argmin
    best_row = int(numbers[allowed[best(values[allowed])]]) if allowed.size else -1
    low, high = int(np.nanargmin(values)), int(np.nanargmax(values))
    least, greatest = float(values[low]), float(values[high])
    # Of ten million rows no further copy is made: the values are sorted in place.
    known = values[~missing] if missing.any() else values
    finite = known if np.isfinite([least, greatest]).all() else known[np.isfinite(known)]
    span = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 0.0)
    margin = max(CONSTANT * max(map(abs, span)), np.finfo(float).tiny)
    if span[1] - span[0] < margin:
        span = (span[0] - margin, span[1] + margin)
    counts, _ = np.histogram(finite, BINS, span)
    median = float(np.median(known, overwrite_input=True))
    percentiles = tuple(percentile(known, PERCENTILES).tolist())
    ends = int(numbers[low]), int(numbers[high])
    return Extent(
        column, least, median, greatest, percentiles, *ends, best_row, span, counts, whole
    )
