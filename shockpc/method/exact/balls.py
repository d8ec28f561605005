"""Eq. 4 in balls (midpoint and radius, python-flint's `arb`), and the doubles nearest to them."""

from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
from flint import arb, arb_mat

from shockpc.core.spatial import Array
from shockpc.method.exact.arithmetic import Arithmetic
from shockpc.method.exact.solution import ExactSolution

BALLS = Arithmetic(arb, arb_mat)
"""Ball arithmetic, at the precision of the present context."""

Balls: TypeAlias = np.ndarray[Any, np.dtype[Any]]
"""An array of balls; what is written for doubles takes it as well."""

BallMatrix: TypeAlias = arb_mat
"""A matrix of balls, with the operations of linear algebra."""

ENOUGH = 2.0**-60
"""Largest radius, relative to the number or to a share of its natural size, with which a ball is
rounded to a double.
"""

NEGLIGIBLE = 1e-15
"""Share of its natural size below which a number is enclosed relative to that share, not to itself.
"""


class PrecisionError(ArithmeticError):
    """A ball is too wide to be rounded to a double: the precision has to be raised."""


def radii(values: Balls | arb) -> Array:
    """Upper bounds of the radii of some balls, of the same shape; 0 for an exact double."""
    array = np.asarray(values, dtype=object)
    out = np.zeros(array.size)
    for k, ball in enumerate(array.ravel().tolist()):
        if not isinstance(ball, float):
            out[k] = float(ball.rad())
    return out.reshape(array.shape)


def to_double(values: Balls | arb, size: Array | float) -> Array:
    """The doubles nearest to some balls.

    Args:
        values: (...) of any shape; where a thing does not exist, NaN or infinite doubles.
        size: natural size of the numbers, of a shape that broadcasts against theirs, above or equal
            to zero. A number far below it, such as a component that vanishes, is enclosed relative
            to this size; one that may be zero is returned as zero.

    Raises:
        PrecisionError: a ball is too wide.
    """
    rounded, radius = np.asarray(values, dtype=object).astype(float), radii(values)
    reference = np.maximum(np.abs(rounded), np.asarray(size, dtype=float) * NEGLIGIBLE)
    narrow = (radius == 0.0) | (radius <= ENOUGH * reference)
    if not np.all(narrow):
        raise PrecisionError
    return np.asarray(np.where(np.abs(rounded) <= radius, 0.0, rounded))


class BallSolution(ExactSolution):
    """Eq. 4 and the jumps in balls, at the precision of the present context.

    Arguments are as of `ExactSolution`.
    """

    arithmetic = BALLS

    @cached_property
    def _unit(self) -> Array:
        """In its unit each inertia is about one, so that pivots stay on the diagonal of balls."""
        if not self._mimics:
            return super()._unit
        inertia = np.array([abs(float(self._joint_inertia[k, k])) for k in self._free])
        return np.asarray(np.ldexp(1.0, -np.frexp(inertia)[1] // 2))
