"""Long numbers: arrays of mpmath numbers, and rotations made of them.

In products the array stands first: mpmath, asked to multiply by an array, looks long for what it might be.
"""

from collections.abc import Callable
from typing import Any, TypeAlias

import mpmath
import numpy as np
from mpmath import mp
from numpy.typing import NDArray

from shockpc.core.spatial import Array

__all__ = [
    "DIGITS",
    "Exact",
    "Reader",
    "cross",
    "cross_matrix",
    "quaternion",
    "rotation_nearest",
    "shaken",
    "turn",
    "unit",
    "widen",
]

DIGITS = 100
"""Digits carried. The worst case of the suite loses thirty of them, so more than fifty are left."""

Exact: TypeAlias = NDArray[np.object_]
"""An array of mpmath numbers."""

Reader: TypeAlias = Callable[[Array], Exact]
"""How the model's doubles become long numbers: `widen`, or `shaken`."""


def widen(values: Array) -> Exact:
    """Doubles as mpmath numbers, exactly."""
    flat = [mpmath.mpf(float(value)) for value in np.asarray(values, dtype=float).ravel()]
    out = np.empty(len(flat), dtype=object)
    out[:] = flat
    return out.reshape(np.shape(values))


def cross(a: Exact, b: Exact) -> Exact:
    """Vector product of two (3,)."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]], dtype=object)


def cross_matrix(r: Exact) -> Exact:
    """The matrix (3, 3) with [r]× u = r × u."""
    x, y, z = r
    return np.array([[mp.zero, -z, y], [z, mp.zero, -x], [-y, x, mp.zero]], dtype=object)


def unit(values: Exact) -> Exact:
    """A vector at length one."""
    return np.asarray(values / mp.sqrt(values @ values))


def shaken(seed: int) -> Reader:
    """A reader that changes every double by up to eight units in its last place: another model that is meant as much as this one.

    Eight, and not the half that rounding takes: an axis that was computed before it was written is off by several roundings, and
    what those make of a zero has to show as noise.
    """
    rng = np.random.default_rng(seed)

    def read(values: Array) -> Exact:
        change = widen(rng.uniform(-1.0, 1.0, np.shape(values))) * mpmath.mpf(2) ** -49
        return np.asarray(widen(values) * (change + 1))

    return read


def rotation_nearest(values: Array, read: Reader) -> Exact:
    """The rotation nearest to nine doubles: Newton's iteration R ← R (3 − RᵀR) / 2, which squares what is left each time."""
    if np.array_equal(values, np.eye(3)):
        return widen(values)
    R = read(values)
    for _ in range(3):
        R = np.asarray(R @ (3 * widen(np.eye(3)) - R.T @ R) / 2)
    return R


def turn(axis: Exact, cosine: Any, sine: Any) -> Exact:
    """Rotation about a unit axis (Rodrigues)."""
    K = cross_matrix(axis)
    return np.asarray(widen(np.eye(3)) + K * sine + (K @ K) * (1 - cosine))


def quaternion(values: Exact) -> Exact:
    """Rotation of a quaternion (x, y, z, w), normalised first."""
    x, y, z, w = unit(values)
    K = cross_matrix(np.array([x, y, z], dtype=object))
    return np.asarray(widen(np.eye(3)) + K * (2 * w) + (K @ K) * 2)
