"""Balls (midpoint and radius, python-flint's `arb`): an impact in them, and the doubles nearest to
them.
"""

from collections.abc import Callable
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
from flint import arb, arb_mat

from shockpc.core.impulse import RowChoice
from shockpc.core.spatial import Array
from shockpc.impact.exact.arithmetic import Arithmetic
from shockpc.impact.exact.kinematics import Data
from shockpc.impact.exact.solution import ExactImpact
from shockpc.landing.landing import PosedLanding

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
    """Upper bounds of the radii of some balls, of the same shape; of a double, which is exact, 0."""
    array = np.asarray(values, dtype=object)
    flat = array.ravel().tolist()
    return np.array(
        [0.0 if isinstance(ball, float) else float(ball.rad()) for ball in flat]
    ).reshape(array.shape)


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
    if not np.all(
        (radius == 0.0)
        | (
            radius
            <= ENOUGH * np.maximum(np.abs(rounded), np.asarray(size, dtype=float) * NEGLIGIBLE)
        )
    ):
        raise PrecisionError
    return np.asarray(np.where(np.abs(rounded) <= radius, 0.0, rounded))


class BallImpact(ExactImpact):
    """An impact in balls, at the precision of the present context; arguments as of `ExactImpact`."""

    arithmetic = BALLS

    def __init__(self, landing: PosedLanding, choice: RowChoice, data: Data | None = None) -> None:
        super().__init__(landing, choice, data)
        self.resistances: dict[int, Any] = {}

    def rounded(self, values: Balls, size: Callable[[Array], Any]) -> Array:
        """The doubles nearest to balls; doubles as they are."""
        values = np.asarray(values)
        return (
            values + 0.0 if values.dtype == float else to_double(values, size(values.astype(float)))
        )

    @cached_property
    def _unit(self) -> Array:
        """In its unit each inertia is about one, so that pivots stay on the diagonal of balls."""
        if not self._mimics:
            return super()._unit
        inertia = np.array([abs(float(self._joint_inertia[k, k])) for k in self._free])
        return np.asarray(np.ldexp(1.0, -np.frexp(inertia)[1] // 2))
