"""The values of what varies in the rows of a chunk: on a grid, or in a random sample.

A chunk has m postures with S strikes each. What varies the strikes of a posture has values of shape
(1, S); everything else has values of shape (m, 1).
"""

from collections.abc import Sequence

import numpy as np

from shockpc.core.permutation import permuted
from shockpc.evaluation.variations.variation import Variation

RowValues = dict[Variation, np.ndarray]
"""Values (m, 1) or (1, S) by what varies."""


def grid_values(axes: Sequence[Variation], postures: np.ndarray, strikes: int) -> RowValues:
    """The values on a grid, of which the last axis changes fastest.

    Args:
        axes: what varies, that of strikes last.
        postures: (m,) numbers of the postures.
        strikes: number of strikes of each posture.
    """
    of_postures = [varied for varied in axes if varied.stage < 2]
    of_strikes = [varied for varied in axes if varied.stage == 2]
    indices = [index[:, None] for index in _unraveled(of_postures, postures)]
    indices += [index[None, :] for index in _unraveled(of_strikes, np.arange(strikes))]
    return {
        varied: np.asarray(varied.values)[index]
        for varied, index in zip(axes, indices, strict=True)
    }


def _unraveled(axes: Sequence[Variation], numbers: np.ndarray) -> tuple[np.ndarray, ...]:
    """The indices of values, an array for each axis, of points of their grid by number."""
    if not axes:
        return ()
    return np.unravel_index(numbers, [len(varied.values) for varied in axes])


def sample_values(
    axes: Sequence[Variation], k: int, rows: np.ndarray, count: int, seed: int, lhs: bool
) -> RowValues:
    """The values of rows of a random sample.

    Args:
        axes: what varies.
        k: number of the chunk.
        rows: (m,) numbers of its rows.
        count: number of rows of the sample.
        seed: of the random numbers.
        lhs: whether the sample is a Latin hypercube: each of `count` equal intervals of a
            distribution has one value.
    """
    u = np.random.default_rng([seed, 1, k]).random((len(axes), len(rows)))
    if lhs:
        intervals = [permuted(count, rows, seed, axis) for axis in range(len(axes))]
        u = (u + intervals) / count
    return {varied: varied.drawn(of_axis)[:, None] for varied, of_axis in zip(axes, u, strict=True)}


def of_row(values: RowValues, posture: int, strike: int) -> dict[Variation, object]:
    """The values of one row, by the numbers of its posture and strike in the chunk."""
    chosen = {}
    for varied, x in values.items():
        i = posture if len(x) > 1 else 0
        j = strike if x.shape[1] > 1 else 0
        chosen[varied] = x[i, j]
    return chosen


def equal_rows(columns: Sequence[np.ndarray]) -> list[np.ndarray]:
    """The indices of rows with the same values in all columns (m,), a group for each."""
    codes = [np.unique(x, return_inverse=True)[1] for x in columns]
    _, code = np.unique(np.stack(codes), axis=1, return_inverse=True)
    code = code.ravel()
    order = np.argsort(code, kind="stable")
    ends = np.flatnonzero(np.diff(code[order])) + 1
    return np.split(order, ends)
