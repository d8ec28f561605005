"""Balls (midpoint and radius, python-flint's `arb`): from doubles, which are exact numbers, and back to the nearest doubles."""

from typing import TypeAlias

import numpy as np
from flint import arb, arb_mat
from numpy.typing import ArrayLike, NDArray

from shockpc.core.spatial import Array

__all__ = [
    "BallMatrix",
    "Balls",
    "PrecisionError",
    "balls",
    "blocks",
    "cross_matrix",
    "entries",
    "matrix",
    "nearest",
    "rotation_matrix",
    "unit_vector",
]

Balls: TypeAlias = NDArray[np.object_]
"""An array of balls."""

BallMatrix: TypeAlias = arb_mat
"""A matrix of balls, with the operations of linear algebra."""

ENOUGH = 2.0**-60
"""Largest radius, relative to the number or to a share of its natural size, with which a ball is rounded to a double."""

NEGLIGIBLE = 1e-15
"""Share of its natural size below which a number is enclosed relative to that share, not to itself."""


class PrecisionError(ArithmeticError):
    """A ball is too wide to be rounded to a double: the precision has to be raised."""


def matrix(values: ArrayLike) -> arb_mat:
    """A matrix (n, m) of doubles, exactly, or of balls."""
    array = np.asarray(values)
    rows, columns = array.shape
    return arb_mat(rows, columns, array.ravel().tolist())


def balls(values: ArrayLike) -> Balls:
    """An array of doubles, exactly."""
    array = np.asarray(values, dtype=float)
    out = np.empty(array.size, dtype=object)
    out[:] = [arb(value) for value in array.ravel().tolist()]
    return out.reshape(array.shape)


def entries(M: arb_mat) -> Balls:
    """The entries (n, m) of a matrix as an array."""
    out = np.empty(M.nrows() * M.ncols(), dtype=object)
    out[:] = M.entries()
    return out.reshape(M.nrows(), M.ncols())


def nearest(values: Balls | arb, size: ArrayLike) -> Array:
    """The doubles nearest to some balls.

    Args:
        values: (...) of any shape.
        size: natural size of the numbers, of a shape that broadcasts against theirs, above or equal to zero. A number far below it,
            such as a component that vanishes, is enclosed relative to this size; one that may be zero is returned as zero.

    Raises:
        PrecisionError: a ball is too wide.
    """
    array = np.asarray(values, dtype=object)
    floor = np.broadcast_to(np.asarray(size, dtype=float) * NEGLIGIBLE, array.shape).ravel().tolist()
    out = []
    for ball, least in zip(array.ravel().tolist(), floor, strict=True):
        value, radius = float(ball), float(ball.rad())
        if not radius <= ENOUGH * max(abs(value), least):
            raise PrecisionError
        out.append(0.0 if abs(value) <= radius else value)
    return np.array(out).reshape(array.shape)


def cross_matrix(r: arb_mat) -> arb_mat:
    """The matrix [r]× with [r]× u = r × u. Args: r (3, 1)."""
    x, y, z = r.entries()
    return arb_mat(3, 3, [0, -z, y, z, 0, -x, -y, x, 0])


def unit_vector(values: Array) -> "list[arb]":
    """A vector of doubles (3,) divided by its length."""
    x, y, z = (arb(value) for value in values.tolist())
    length = (x * x + y * y + z * z).sqrt()
    return [x / length, y / length, z / length]


def rotation_matrix(quaternion: Array | Balls) -> arb_mat:
    """The rotation (3, 3) of a quaternion (x, y, z, w), of doubles or balls, divided by its length: exactly orthogonal."""
    x, y, z, w = (arb(value) for value in quaternion.tolist())
    s = 2 / (x * x + y * y + z * z + w * w)
    xx, yy, zz, xy, xz, yz, wx, wy, wz = (s * p for p in (x * x, y * y, z * z, x * y, x * z, y * z, w * x, w * y, w * z))
    return arb_mat([[1 - yy - zz, xy - wz, xz + wy], [xy + wz, 1 - xx - zz, yz - wx], [xz - wy, yz + wx, 1 - xx - yy]])


def blocks(A: arb_mat, B: arb_mat | None, C: arb_mat | None, D: arb_mat) -> arb_mat:
    """The matrix [[A, B], [C, D]] of 3 × 3 blocks; None is zero."""
    a, b, c, d = ([0] * 9 if part is None else part.entries() for part in (A, B, C, D))
    rows = [*a[:3], *b[:3], *a[3:6], *b[3:6], *a[6:], *b[6:], *c[:3], *d[:3], *c[3:6], *d[3:6], *c[6:], *d[6:]]
    return arb_mat(6, 6, rows)
