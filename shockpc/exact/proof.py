"""The proof of a landing: enclosures of its results, and how far double precision was off.

The precision is raised until every enclosure is narrow enough to be rounded to the nearest double. Proven means: for the robot as
loaded, the posture, and the rows that were found independent.
"""

from collections.abc import Callable
from typing import NamedTuple, TypeVar

import numpy as np
from flint import ctx

from shockpc.core.spatial import Array
from shockpc.exact.balls import Balls, PrecisionError, SingularError, nearest, radii
from shockpc.exact.solution import ExactImpact, Inputs

__all__ = ["Enclosure", "Proof", "motion", "prove", "rounded"]

T = TypeVar("T")

LEAST_BITS, MOST_BITS = 128, 8192
"""Precision to begin with, and at which a pivot that still may be zero is zero."""

AT_REST = 1e-200
"""Share of the fastest motion below which a body is proven to be at rest, and not how fast it moves."""


class Enclosure:
    """An impact that can be evaluated at any precision. Args: inputs, what it depends on."""

    def __init__(self, inputs: Inputs) -> None:
        self.inputs = inputs
        self.bits = LEAST_BITS
        self._impact: ExactImpact | None = None

    def read(self, compute: Callable[[ExactImpact], T], bits: int = LEAST_BITS) -> T:
        """What `compute` makes of the impact, at the least precision at which it raises no `PrecisionError` or `SingularError`.

        Args:
            compute: what to read.
            bits: precision to use at least.

        Raises:
            SingularError: a pivot may be zero at the highest precision: no inertia resists a motion, or rows are dependent.
        """
        if bits > self.bits:
            self.bits, self._impact = bits, None
        while True:
            with ctx.workprec(self.bits):
                try:
                    if self._impact is None:
                        self._impact = ExactImpact(self.inputs)
                    return compute(self._impact)
                except (PrecisionError, SingularError):
                    if self.bits >= MOST_BITS:
                        raise
            self.bits *= 2
            self._impact = None


class Proof(NamedTuple):
    """What was proven of a landing.

    Attributes:
        enclosure: from which everything else can be read.
        jumps: (nb, 6, 4) jump (Δω, Δv) of every body in body coordinates at its frame's origin, for strikes of 1 m/s along world x,
            y and z and for the scene's own [rad/s, m/s]; the doubles nearest to the exact ones.
        delta_qd: (nv, 4) jump of the joint velocities [rad/s, m/s].
        impulse: (nc, 4) impulse along every row, of the ground on the robot [N s].
        bounds: (nb,) proven error of the scene's own jumps relative to each body's motion, `AT_REST` at least [1].
        bits: precision at which they were proven.
    """

    enclosure: Enclosure
    jumps: Array
    delta_qd: Array
    impulse: Array
    bounds: Array
    bits: int


def prove(inputs: Inputs, length: Array) -> Proof:
    """Enclose the impact.

    Args:
        inputs: what it depends on.
        length: (nb,) by which the rotation of a body counts as a speed [m].

    Raises:
        SingularError: no inertia resists a motion, or the rows depend on one another.
    """
    enclosure = Enclosure(inputs)
    jumps, bounds = enclosure.read(lambda impact: _jumps(impact, length))
    delta_qd = enclosure.read(lambda impact: rounded(impact.delta_qd))
    impulse = enclosure.read(lambda impact: nearest(impact.impulse, np.abs(impact.impulse.astype(float)).max(initial=0.0)))
    return Proof(enclosure, jumps, delta_qd, impulse, bounds, enclosure.bits)


def _jumps(impact: ExactImpact, length: Array) -> tuple[Array, Array]:
    """The jumps of all bodies as doubles (nb, 6, 4), and the proven error (nb,) of the last column relative to the motion."""
    values, radius = impact.body_jumps.astype(float), radii(impact.body_jumps)
    size, width = motion(values, length), motion(radius, length)
    own = np.maximum(size[:, 3], AT_REST * size[:, 3].max())
    if np.any(width[:, 3] > 2.0**-70 * own) or np.any(width > 2.0**-70 * np.maximum(size, size.max(axis=1, keepdims=True))):
        raise PrecisionError
    # What may be zero is zero; the rest is off by its rounding to a double at most.
    values[np.abs(values) <= radius] = 0.0
    lost = np.abs(values[..., 3]) * 2.0**-53 + 2.0 * radius[..., 3]
    return values, motion(lost[..., None], length)[:, 0] / np.where(own > 0.0, own, 1.0)


def motion(jumps: Array, length: Array) -> Array:
    """Size (nb, k) of jumps (nb, 6, k) as speeds: velocity of the frame's origin, and rotation times a length (nb,)."""
    # Unlike a sum of squares, hypot does not underflow.
    return np.asarray(np.hypot.reduce(np.concatenate([jumps[:, :3] * length[:, None, None], jumps[:, 3:]], axis=1), axis=1))


def rounded(velocities: Balls) -> Array:
    """Joint velocities (nv, m) as doubles, each joint's relative to its own.

    Raises:
        PrecisionError: a ball is too wide.
    """
    size = np.abs(velocities.astype(float))
    return nearest(velocities, np.maximum(size.max(axis=1, keepdims=True), 1e-30 * size.max(initial=0.0)))
