"""A part of a motion between two events, as a sum of oscillations."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.wings.compliant.motion.crossing import (
    ComplexArray,
    changes,
    integral,
    oscillations,
    real_sum,
)

DECAYED = 40.0
"""Times the time constant of an oscillation after which nothing is left of it."""


class Segment(NamedTuple):
    """The motion between two events, in m oscillations.

    Attributes:
        start: time of the first event [s].
        length: time until the second [s].
        rate: (m,) λ of each oscillation; its real part is the rate at which it decays, zero without
            dampers [rad/s].
        level: (r,) part of the forces of all elements that stays constant; at rest they would have
            it.
        wave: (r, m) with their other part, Re(wave · exp(λt)).
        swing: (d, m) with the part of u that oscillates, Re(swing · exp(λt)).
        drift, acceleration: (d,) the part of u at the start that no spring resists, and the
            constant rate at which it changes.
        jump: (d,) u(start) − u(0).
        displacement: (d,) ∫u dt until the start.
    """

    start: float
    length: float
    rate: ComplexArray
    level: Array
    wave: ComplexArray
    swing: ComplexArray
    drift: Array
    acceleration: Array
    jump: Array
    displacement: Array

    def forces(self, t: Array) -> Array:
        """The forces (..., r) at times t (...) after the start."""
        return self.level + oscillations(t[..., None] * self.rate, self.wave)

    def after(self, t: Array) -> tuple[Array, Array]:
        """The change of u since impact and ∫u dt (..., d), at times t (...) after the start."""
        t = t[..., None]
        # Of slow oscillations no digits cancel.
        change = changes(t * self.rate, self.swing) + t * self.acceleration
        path = real_sum(integral(self.rate, t), self.swing)
        path = path + t * self.drift + t * t / 2.0 * self.acceleration
        return self.jump + change, self.displacement + path

    def pieces(self) -> Iterator["Segment"]:
        """The forces in parts, each longer than the one before.

        The oscillations that decay fastest are only in the first.
        """
        begin, fastest = 0.0, float(-self.rate.real.min(initial=0.0))
        end = DECAYED / fastest if fastest > 0.0 else np.inf
        while begin < self.length:
            end = min(end, self.length)
            wave = self.wave * np.exp(self.rate * begin)
            yield self._replace(start=self.start + begin, length=end - begin, wave=wave)
            begin, end = end, 3.0 * end

    def impulse(self, t: float) -> Array:
        """The impulses (r,) of the forces from the start until a time t after it."""
        return np.asarray(t * self.level + real_sum(integral(self.rate, np.asarray(t)), self.wave))
