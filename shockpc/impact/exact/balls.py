"""Balls (midpoint and radius, python-flint's `arb`): from doubles, which are exact numbers, and back to the nearest doubles."""

from collections.abc import Iterable
from typing import Any, TypeAlias

import numpy as np
from flint import arb, arb_mat

from shockpc.core.spatial import Array

Balls: TypeAlias = np.ndarray[Any, np.dtype[Any]]
"""An array of balls; what is written for doubles takes it as well."""

BallMatrix: TypeAlias = arb_mat
"""A matrix of balls, with the operations of linear algebra."""

ENOUGH = 2.0**-60
"""Largest radius, relative to the number or to a share of its natural size, with which a ball is rounded to a double."""

NEGLIGIBLE = 1e-15
"""Share of its natural size below which a number is enclosed relative to that share, not to itself."""


class PrecisionError(ArithmeticError):
    """A ball is too wide to be rounded to a double: the precision has to be raised."""


class SingularError(ArithmeticError):
    """A pivot may be zero: no inertia resists a motion, rows depend on one another, or the precision is too low to tell.

    Attributes:
        of_inertia: whether it is the inertia's.
    """

    def __init__(self, of_inertia: bool) -> None:
        super().__init__(of_inertia)
        self.of_inertia = of_inertia


def matrix(values: Array | Balls) -> arb_mat:
    """A matrix (n, m) of doubles, exactly, or of balls."""
    array = np.asarray(values)
    rows, columns = array.shape
    return arb_mat(rows, columns, array.ravel().tolist())


def balls(values: Array | Balls) -> Balls:
    """An array of doubles, exactly, or of balls."""
    array = np.asarray(values)
    out = np.empty(array.size, dtype=object)
    out[:] = [arb(value) for value in array.ravel().tolist()]
    return out.reshape(array.shape)


def entries(M: arb_mat) -> Balls:
    """The entries (n, m) of a matrix as an array."""
    out = np.empty(M.nrows() * M.ncols(), dtype=object)
    out[:] = M.entries()
    return out.reshape(M.nrows(), M.ncols())


def radii(values: Balls | arb) -> Array:
    """Upper bounds of the radii of some balls, of the same shape; of a double, which is exact, 0."""
    array = np.asarray(values, dtype=object)
    flat = array.ravel().tolist()
    return np.array([0.0 if isinstance(ball, float) else float(ball.rad()) for ball in flat]).reshape(array.shape)


def to_double(values: Balls | arb, size: Array | float) -> Array:
    """The doubles nearest to some balls.

    Args:
        values: (...) of any shape; where a thing does not exist, NaN or infinite doubles.
        size: natural size of the numbers, of a shape that broadcasts against theirs, above or equal to zero. A number far below it,
            such as a component that vanishes, is enclosed relative to this size; one that may be zero is returned as zero.

    Raises:
        PrecisionError: a ball is too wide.
    """
    rounded, radius = np.asarray(values, dtype=object).astype(float), radii(values)
    if not np.all((radius == 0.0) | (radius <= ENOUGH * np.maximum(np.abs(rounded), np.asarray(size, dtype=float) * NEGLIGIBLE))):
        raise PrecisionError
    return np.asarray(np.where(np.abs(rounded) <= radius, 0.0, rounded))


def cross_matrix(r: arb_mat) -> arb_mat:
    """The matrix [r]× with [r]× u = r × u. Args: r (3, 1)."""
    x, y, z = r.entries()
    return arb_mat(3, 3, [0, -z, y, z, 0, -x, -y, x, 0])


def rotation_matrix(quaternion: Iterable[Any]) -> arb_mat:
    """The rotation (3, 3) of a quaternion (x, y, z, w), of doubles or balls, divided by its length: exactly orthogonal."""
    x, y, z, w = (arb(value) for value in quaternion)
    s = 2 / (x * x + y * y + z * z + w * w)
    xx, yy, zz, xy, xz, yz, wx, wy, wz = (s * p for p in (x * x, y * y, z * z, x * y, x * z, y * z, w * x, w * y, w * z))
    return arb_mat([[1 - yy - zz, xy - wz, xz + wy], [xy + wz, 1 - xx - zz, yz - wx], [xz - wy, yz + wx, 1 - xx - yy]])
