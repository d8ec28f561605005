"""What stays the same in a landing on elements of finite stiffness."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from shockpc.core.spatial import Array
from shockpc.wings.compliant.motion.elements import Elements

NEGLIGIBLE = 1e-11
"""Share of the exciting motion below which what moves or presses counts as rounding.

It is the motion that excites the elements.
"""

EASED = 0.01
"""Share of the largest force, compression or impact speed below which nothing is noticeable.

Force and compression are those of a contact.
"""

SMALLEST_PIVOT = 1e-7
"""Smallest diagonal entry of a Cholesky factor with which M counts as positive definite.

The factor is that of M, scaled to a unit diagonal.
"""


def coordinates_along(rows: Array, M: Array) -> tuple[Array, Array, Array]:
    """The coordinates u along some rows: W, to_velocity and from_velocity as in `ScaledSystem`.

    They have unit inertia: from M = LLᵀ, scaled to a unit diagonal, and rows L⁻ᵀ = Rᵀ Qᵀ.

    Args:
        rows: (r, n) of the elements.
        M: (n, n) inertia.

    Raises:
        ArithmeticError: M is not positive definite in double precision.
    """
    diagonal = np.diagonal(M)
    if np.all(diagonal > 0.0):
        size = np.sqrt(diagonal)
        try:
            L = np.linalg.cholesky(M / size / size[:, None])
        except np.linalg.LinAlgError:
            L = np.zeros_like(M)
        if np.diagonal(L).min() > SMALLEST_PIVOT:
            inverse = np.linalg.inv(L).T / size[:, None]
            Q, R = np.linalg.qr((rows @ inverse).T)
            return R.T, inverse @ Q, Q.T @ (L.T * size)
    raise ArithmeticError(
        "the inertia is not positive definite in double precision; give moving bodies mass, or "
        "lock their joints"
    )


@dataclass(frozen=True, eq=False)
class ScaledSystem:
    """The elements, and the velocity before the impact, in the coordinates u.

    All forces are scaled: they are those of the elements divided by −slope, √κ.

    Attributes:
        elements: the springs and dampers.
        W: (r, d) velocity along each element for unit u.
        to_velocity: (n, d) from u to velocities.
        from_velocity: (d, n) back.
        velocity: (n,) before the impact [rad/s, m/s].
        gravity: (n,) accelerations of free fall [rad/s², m/s²].
    """

    elements: Elements
    W: Array
    to_velocity: Array
    from_velocity: Array
    velocity: Array
    gravity: Array

    @cached_property
    def u(self) -> Array:
        """Coordinates (d,) at the impact."""
        return np.asarray(self.from_velocity @ self.velocity)

    @cached_property
    def _fall(self) -> Array:
        """Rate (d,) at which gravity changes u."""
        return np.asarray(self.from_velocity @ self.gravity)

    @cached_property
    def unresisted_velocity(self) -> Array:
        """Part (n,) of the velocity before the impact that no element resists [rad/s, m/s]."""
        return np.asarray(self.velocity - self.to_velocity @ self.u)

    @cached_property
    def unresisted_gravity(self) -> Array:
        """Part (n,) of the accelerations of free fall that no element resists [rad/s², m/s²]."""
        return np.asarray(self.gravity - self.to_velocity @ self._fall)

    @cached_property
    def sprung(self) -> np.ndarray:
        """Mask (r,) of the elements that have a spring; the others give constant forces."""
        return np.asarray(self.elements.stiffness > 0.0)

    @cached_property
    def rigid(self) -> np.ndarray:
        """Mask (r,) of the elements that are held once they are unloaded."""
        return np.asarray(self.elements.restitution == 0.0)

    @cached_property
    def grounded(self) -> np.ndarray:
        """Mask (r,) of the elements of contacts."""
        return np.asarray(self.elements.contact >= 0)

    @cached_property
    def lossy(self) -> np.ndarray:
        """Mask (r,) of normals, and of elements that are unloaded in another way than loaded."""
        return np.asarray(self.elements.normal | (self.elements.restitution < 1.0))

    @cached_property
    def slope(self) -> Array:
        """√κ (r,) of the elements while they are loaded."""
        return np.asarray(np.sqrt(self.elements.stiffness))

    @cached_property
    def viscous(self) -> Array:
        """Scaled force (r,) of each damper beside a spring for a unit rate, c / √κ."""
        return np.asarray(self.elements.damping / np.where(self.sprung, self.slope, 1.0))

    @cached_property
    def steady(self) -> Array:
        """Constant forces (r,) of the elements without a spring [N, N m]."""
        return np.where(self.sprung, 0.0, self.elements.load)

    @cached_property
    def pull(self) -> Array:
        """Rate (d,) at which gravity and constant forces change u."""
        return np.asarray(self._fall + self.W.T @ self.steady)

    @cached_property
    def length(self) -> Array:
        """Lengths (r,) of the rows of W."""
        return np.asarray(np.linalg.norm(self.W, axis=1))

    @cached_property
    def rigid_length(self) -> Array:
        """Lengths (r,) of the rows of W on a robot whose links stay straight.

        They are those of W (1 − S⁺ S), of the rows S of hinges.
        """
        W, hinges = self.W, self.elements.straight
        if not hinges.any():
            return self.length
        S = W[hinges]
        of_hinges = np.linalg.pinv(S, rcond=1e-9) @ S
        return np.asarray(np.linalg.norm(W - W @ of_hinges, axis=1))

    @cached_property
    def _frequency(self) -> Array:
        """Natural frequency (r,) of each element alone, √κ |W_i| [rad/s]."""
        return np.asarray(self.slope * self.length)

    @cached_property
    def fastest(self) -> float:
        """Largest natural frequency of a single element [rad/s]."""
        return float(self._frequency.max())

    @cached_property
    def approaches(self) -> np.ndarray:
        """Mask (r,) of the normals of contacts that approach the ground.

        A contact at rest approaches by no more than rounding.
        """
        speed = float(np.linalg.norm(self.u))
        return np.asarray(self.elements.normal & (self.W @ self.u < -1e-13 * self.length * speed))

    @cached_property
    def slowly(self) -> Array:
        """Rate (r,) up to which an element is slow: a share of that of the fastest strike."""
        closing = self.approaches
        approach = -(self.W @ self.u)[closing] / self.rigid_length[closing]
        strike = float(np.max(approach, initial=0.0))
        return np.asarray(EASED * strike * self.rigid_length)

    @cached_property
    def noise(self) -> float:
        """Size of z and u that counts as rounding.

        It is a share of the speed, and of that at which single contacts come to rest.
        """
        speed = float(np.linalg.norm(self.u))
        slowest = float(self._frequency[self.elements.normal].min())
        at_rest = float(np.linalg.norm(self.pull)) / slowest
        return NEGLIGIBLE * (speed + at_rest)

    @cached_property
    def push_noise(self) -> Array:
        """Scaled forces (r,) of spring and damper that count as rounding."""
        return np.asarray(self.noise * (1.0 + self.viscous * self.length))
