"""Where sampled functions cross zero and where their extrema are: cubic splines, parabolas, and lines that meet."""

import numpy as np
from scipy.interpolate import CubicSpline

from shockpc.core.spatial import Array

BISECTIONS = 50
"""Of a piece of a spline."""


def crossings(x: Array, y: Array) -> tuple[np.ndarray, Array]:
    """Where rows of samples y (m, n) at x (n,) change sign: rows (k,) and places (k,), on cubic splines, ascending."""
    inside = y <= 0.0
    row, j = np.nonzero(inside[:, 1:] != inside[:, :-1])
    pieces = CubicSpline(x, y, axis=1).c[:, j, row]
    low, high = np.zeros(len(j)), x[j + 1] - x[j]
    for _ in range(BISECTIONS):
        middle = (low + high) / 2.0
        first = (np.polyval(pieces, middle) <= 0.0) == inside[row, j]
        low, high = np.where(first, middle, low), np.where(first, high, middle)
    return row, x[j] + (low + high) / 2.0


def vertices(x: Array, y: Array) -> Array:
    """The vertex (m,) of parabolas through three points (m, 3), kept between the outer ones; the middle one where there is none."""
    with np.errstate(all="ignore"):
        slopes = np.diff(y) / np.diff(x)
        vertex = (x[:, 0] + x[:, 1] - slopes[:, 0] * (x[:, 2] - x[:, 0]) / (slopes[:, 1] - slopes[:, 0])) / 2.0
    return np.clip(np.where(np.isfinite(vertex), vertex, x[:, 1]), x[:, 0], x[:, 2])


def kinks(x: Array, y: Array) -> Array:
    """Where the least of samples y (n,) at x (n,) may lie between two if branches meet there: where lines through two each meet."""
    k = np.argmin(y) + np.array([[-2, -1, 0, 1], [-1, 0, 1, 2]])
    a, b, c, d = k[(k >= 0).all(axis=1) & (k < len(x)).all(axis=1)].T
    with np.errstate(all="ignore"):
        left, right = (y[b] - y[a]) / (x[b] - x[a]), (y[d] - y[c]) / (x[d] - x[c])
        at = (y[c] - y[b] + left * x[b] - right * x[c]) / (left - right)
    return np.asarray(at[(at >= x[b]) & (at <= x[c])])
