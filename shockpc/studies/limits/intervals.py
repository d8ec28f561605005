"""Intervals of values that keep a bound.

They are cut where flat ground begins or ceases to allow the landing.
"""

import math
from collections.abc import Iterable, Sequence
from typing import Literal, NamedTuple

import numpy as np

from shockpc.studies.limits.question import Strikes
from shockpc.studies.limits.scan import Run, Scan

EndedBy = Literal["bound", "range", "loop", "ground"]


class Interval(NamedTuple):
    """Values that keep the bound, all of which flat ground allows, or none.

    Attributes:
        low: smallest value [rad, m; unit of the variation].
        high: largest value.
        low_end: what ends it there: the bound, the range of the study, a loop that cannot be closed
            beyond, or flat ground, which begins or ceases to allow the landing.
        high_end: the same at the largest value.
        feasible: whether flat ground allows the landing.
    """

    low: float
    high: float
    low_end: EndedBy
    high_end: EndedBy
    feasible: bool


class StrikeLimits(NamedTuple):
    """The values that keep the bound at one strike angle, or at all of a range.

    Attributes:
        strikes: smallest and largest strike angle, equal for a single one [rad].
        intervals: values for which the number keeps the bound for each of these strikes, ascending.
        best: best number over the feasible values of the scan, of the worst of these strikes [its
            unit]; NaN if there is none.
        best_at: value where that is.
    """

    strikes: Strikes
    intervals: tuple[Interval, ...]
    best: float
    best_at: float

    @property
    def usable(self) -> tuple[Run, ...]:
        """Values that keep the bound and for which flat ground allows the landing, ascending."""
        intervals = self.intervals
        return tuple((interval.low, interval.high) for interval in intervals if interval.feasible)


def strike_limits(
    scan: Scan, span: tuple[float, float], targets: Sequence[Strikes]
) -> tuple[StrikeLimits, ...]:
    """The intervals that keep the bound, for each of some ranges of strikes.

    Args:
        scan: the numbers.
        span: the range of values of the study.
        targets: the ranges of strikes.
    """
    limits = []
    for strikes, roots in zip(targets, scan.crossings(targets), strict=True):
        number, _ = scan.worst(strikes)
        violation = scan.bound.violation(number)
        edges: list[tuple[float, EndedBy]] = [(root, "bound") for root in roots.tolist()]
        first, last = float(scan.values[0]), float(scan.values[-1])
        if violation[0] <= 0.0:
            edges.insert(0, (first, "range" if first <= span[0] else "loop"))
        if violation[-1] <= 0.0:
            edges.append((last, "range" if last >= span[1] else "loop"))

        runs = scan.feasible_runs(strikes)
        intervals = []
        for low, high in zip(edges[::2], edges[1::2], strict=True):
            intervals += _cut(low, high, runs)

        # The best number where flat ground allows the landings.
        best, best_at = math.nan, math.nan
        k = int(np.argmin(np.where(scan.feasible(strikes), violation, np.inf)))
        if runs and np.isfinite(number[k]):
            best, best_at = float(number[k]), float(scan.values[k])
        limits.append(StrikeLimits(strikes, tuple(intervals), best, best_at))
    return tuple(limits)


def _cut(
    low: tuple[float, EndedBy], high: tuple[float, EndedBy], runs: Iterable[Run]
) -> list[Interval]:
    """An interval in pieces, each of which flat ground allows as a whole, or nowhere.

    Args:
        low: smallest value, and what ends the interval there.
        high: largest value, and what ends the interval there.
        runs: first and last values for which flat ground allows the landing.
    """
    pieces = []
    begin = low
    for first, last in runs:
        if last < low[0] or first > high[0]:
            continue
        if first > begin[0]:
            pieces.append(Interval(begin[0], first, begin[1], "ground", False))
            begin = first, "ground"
        end = high if last >= high[0] else (last, "ground")
        pieces.append(Interval(begin[0], end[0], begin[1], end[1], True))
        begin = end[0], "ground"
    if begin[0] < high[0] or not pieces:
        pieces.append(Interval(begin[0], high[0], begin[1], high[1], False))
    return pieces
