"""Many landings in a few numbers: ranges, percentiles, correlations, and the error of doubles."""

import math
from collections.abc import Sequence
from typing import Generic, NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.evaluation.column import Column
from shockpc.evaluation.evaluate import Evaluation, L
from shockpc.evaluation.table import Table, percentile
from shockpc.evaluation.variations.variation import Variation
from shockpc.text.printed import Cause, causes

PERCENTILES = (5, 95, 99)
"""Percentiles of a sample, besides its median."""

RANKED = 100_000
"""Rows of which ranks are compared: what chance adds to their correlation is 0.003."""

BINS = 80
"""Number of intervals of the distributions."""

CONSTANT = 1e-9
"""Share of the largest value by which values have to differ to be divided into intervals.

Intervals of doubles lie between them then.
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

    @property
    def most_severe_row(self) -> int:
        """Row of the most severe value; of the largest one where neither direction is worse."""
        if self.column.selection.quantity.worse == "less":
            return self.least_row
        return self.greatest_row

    @property
    def has_best(self) -> bool:
        """True if flat ground allows a landing with a value, of which one is the best."""
        return self.best_row >= 0 and self.column.selection.quantity.worse != "neither"


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
        """The rank correlation of independent columns that 19 of 20 samples stay below."""
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
    named = [(int(table.numbers[i]), text) for i, text in table.messages.items()]
    messages = causes(named)
    proven = table.columns["proven"].astype(bool)
    errors = table.columns["double_error"]
    compared = errors[~proven & ~np.isnan(errors)]
    rows = evaluation.landings.rows
    columns = [column for column in evaluation.computed if column.shock or column.requested]
    drawn = rows if keep else 0
    extents = [_extent(column, table, drawn) for column in columns]
    correlations, ranked = _correlations(table, rows, varied, columns)
    return Summary(
        evaluation=evaluation,
        rows=rows,
        extents=tuple(extents),
        varied=tuple(varied),
        correlations=correlations,
        ranked=ranked,
        messages=tuple(messages),
        failed=sum(cause.rows for cause in messages),
        refused=Refused(sum(table.refused), *table.refused),
        tilted=int(np.sum(table.tilted)),
        proven=int(proven.sum()),
        compared=len(compared),
        largest_error=float(np.max(compared, initial=0.0)),
    )


def _correlations(
    table: Table, rows: int, varied: Sequence[Variation], columns: Sequence[Column]
) -> tuple[Array, int]:
    """Rank correlations (v, e) of what varies with results, and the number of rows that have them.

    Args:
        table: the rows.
        rows: number of all rows.
        varied: what varies.
        columns: of the results.
    """
    correlations = np.full((len(varied), len(columns)), np.nan)
    if not varied:
        return correlations, 0
    # Of more than RANKED rows every step-th one is ranked.
    step = math.ceil(rows / RANKED)
    inputs = [_by_row(table, rows, variation.column)[::step] for variation in varied]
    for k, column in enumerate(columns):
        results = _by_row(table, rows, column.name)[::step]
        for i, values in enumerate(inputs):
            correlations[i, k] = _correlation(values, results)
    return correlations, int(np.sum(~np.isnan(inputs[0])))


def _by_row(table: Table, rows: int, name: str) -> Array:
    """A column (rows,) with NaN in rows that are left out."""
    values = np.full(rows, np.nan)
    values[table.numbers] = table.columns[name]
    return values


def _correlation(x: Array, y: Array) -> float:
    """Rank correlation of two columns (n,) in rows that have both; NaN if one is constant there."""
    known = ~(np.isnan(x) | np.isnan(y))
    if not known.any():
        return np.nan
    a = _ranks(x[known])
    b = _ranks(y[known])
    if np.ptp(a) == 0.0 or np.ptp(b) == 0.0:
        return np.nan
    return float(np.corrcoef(a, b)[0, 1])


def _ranks(x: Array) -> Array:
    """The rank (n,) of each of some values; equal ones share the mean of theirs.

    SciPy's takes longer to import than a sweep.
    """
    _, number, count = np.unique(x, return_inverse=True, return_counts=True)
    return np.asarray((np.cumsum(count) - 0.5 * (count - 1))[number])


def _extent(column: Column, table: Table, drawn: int) -> Extent:
    """The range of a column. Args: drawn, the number of all rows if the values are drawn."""
    values = np.array(table.columns[column.name])
    missing = np.isnan(values)
    of_rows = None
    if drawn:
        of_rows = _by_row(table, drawn, column.name)
    if missing.all():
        return _no_extent(column, of_rows)
    best = _best_row(column, values, np.flatnonzero(table.feasible & ~missing))
    low, high = int(np.nanargmin(values)), int(np.nanargmax(values))
    least, greatest = float(values[low]), float(values[high])

    # Of ten million rows no other copy is made: the values are sorted in place.
    known = values
    if missing.any():
        known = values[~missing]
    finite = known
    if not (math.isfinite(least) and math.isfinite(greatest)):
        finite = known[np.isfinite(known)]
    span = _span(finite)
    counts, _ = np.histogram(finite, BINS, span)
    median = float(np.median(known, overwrite_input=True))
    return Extent(
        column=column,
        least=least,
        median=median,
        greatest=greatest,
        percentiles=tuple(percentile(known, PERCENTILES).tolist()),
        least_row=int(table.numbers[low]),
        greatest_row=int(table.numbers[high]),
        best_row=-1 if best is None else int(table.numbers[best]),
        span=span,
        counts=counts,
        values=of_rows,
    )


def _no_extent(column: Column, of_rows: Array | None) -> Extent:
    """The range of a column without a value."""
    nothing = (np.nan,) * len(PERCENTILES)
    counts = np.zeros(BINS, dtype=int)
    ends = np.nan, np.nan, np.nan
    return Extent(column, *ends, nothing, -1, -1, -1, (0.0, 0.0), counts, of_rows)


def _best_row(column: Column, values: Array, allowed: np.ndarray) -> int | None:
    """Index of the best of values (n,) in some rows; None without any."""
    if not allowed.size:
        return None
    best = np.argmin
    if column.selection.quantity.worse == "less":
        best = np.argmax
    return int(allowed[best(values[allowed])])


def _span(finite: Array) -> tuple[float, float]:
    """Smallest and largest of some values, wider where they differ only by rounding."""
    if not finite.size:
        low = high = 0.0
    else:
        low, high = float(finite.min()), float(finite.max())
    margin = max(CONSTANT * max(abs(low), abs(high)), np.finfo(float).tiny)
    if high - low < margin:
        return low - margin, high + margin
    return low, high
