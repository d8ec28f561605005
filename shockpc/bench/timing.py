"""The clock: warmed up, repeated, median and quartiles, and nothing but the work between its hands."""

import time
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

__all__ = ["Timing", "timed"]

LONG = 0.2
"""A run of this many seconds is not repeated to warm up [s]."""


class Timing(NamedTuple):
    """How long something took.

    Attributes:
        median: of all runs [s].
        low: first quartile [s].
        high: third quartile [s].
        runs: how many.
    """

    median: float
    low: float
    high: float
    runs: int


def timed(run: Callable[[], Any], budget: float, most: int = 1000) -> tuple[Any, Timing]:
    """Run until the budget is spent, three times at least unless one run is long, and give the last result.

    The first run loads and fills caches; it counts only if it is not repeated.

    Args:
        run: the work.
        budget: time to spend [s]; without any, once is enough.
        most: runs.
    """
    start = time.perf_counter()
    result = run()
    first = time.perf_counter() - start
    if first > max(LONG, budget) or budget <= 0.0:
        return result, Timing(first, first, first, 1)
    seconds: list[float] = []
    while len(seconds) < most and (len(seconds) < 3 or sum(seconds) < budget):
        start = time.perf_counter()
        result = run()
        seconds.append(time.perf_counter() - start)
    low, median, high = (float(value) for value in np.quantile(seconds, (0.25, 0.5, 0.75)))
    return result, Timing(median, low, high, len(seconds))
