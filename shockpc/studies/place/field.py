"""Shock over a body for several landings, and the number that a place is compared by.

For each landing, the shock at a point r of a body is the norm of an affine function of r: |c + A
r|. Therefore their largest and their weighted mean are convex functions of r.
"""

import math
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array, cross_matrix

CHUNK = 4096
"""Points at which all landings are evaluated together."""


class Fields(NamedTuple):
    """Shock over one body in L landings.

    Attributes:
        c: (L, 3) Δv / v_in at the origin of the body's frame [1].
        A: (L, 3, 3) its derivative by the point [1/m].
        weights: (L,) of the landings, with sum 1, if places are compared by the weighted mean; None
            for the largest shock.
        limit: where places are compared by the weighted mean, the largest shock that they may have
            in any landing [1].
    """

    c: Array
    A: Array
    weights: Array | None = None
    limit: float = math.inf

    def of(self, landings: list[int]) -> "Fields":
        """The same for some of the landings; weights stay as they are."""
        return self._replace(
            c=self.c[landings],
            A=self.A[landings],
            weights=None if self.weights is None else self.weights[landings],
        )

    def vectors(self, points: Array) -> Array:
        """The vectors c + A r (..., L, 3) at points (..., 3) [m]."""
        return np.asarray(self.c + np.einsum("lij,...j->...li", self.A, points))

    def shocks(self, points: Array) -> Array:
        """Shock (..., L) at points (..., 3) [m]."""
        return np.asarray(np.linalg.norm(self.vectors(points), axis=-1))

    def combined(self, shocks: Array) -> Array:
        """The number that places are compared by (...), from the shocks (..., L): the largest, or
        the weighted mean.
        """
        return np.asarray(shocks.max(axis=-1) if self.weights is None else shocks @ self.weights)

    def at(self, points: Array) -> Array:
        """The number that places are compared by, at points (n, 3) [m]."""
        parts = [
            self.combined(self.shocks(points[k : k + CHUNK])) for k in range(0, len(points), CHUNK)
        ]
        return np.concatenate([np.zeros(0), *parts])

    def tangents(self, points: Array) -> tuple[Array, Array]:
        """Value (n,) and a gradient (n, 3) at points (n, 3): the function nowhere lies below this
        tangent, because it is convex.
        """
        values, gradients = [np.zeros(0)], [np.zeros((0, 3))]
        for k in range(0, len(points), CHUNK):
            vectors = self.vectors(points[k : k + CHUNK])
            shocks = np.linalg.norm(vectors, axis=-1)
            share = np.zeros_like(shocks)
            if self.weights is None:
                np.put_along_axis(share, shocks.argmax(axis=-1)[:, None], 1.0, axis=-1)
            else:
                share[:] = self.weights
            y = vectors * (share / np.where(shocks > 0.0, shocks, 1.0))[..., None]
            values.append(self.combined(shocks))
            gradients.append(np.einsum("nli,lij->nj", y, self.A))
        return np.concatenate(values), np.concatenate(gradients)


def fields_of(
    delta_omega: Array, delta_v: Array, v_in: Array, weights: Array | None = None
) -> Fields:
    """Shock over a body from its jumps.

    Args:
        delta_omega: (L, 3) jump of angular velocity in each landing, body axes [rad/s].
        delta_v: (L, 3) jump of velocity of the body frame's origin, body axes [m/s].
        v_in: (L,) speed by which shock is normalised [m/s].
        weights: (L,) not negative, for the weighted mean; None for the largest.
    """
    return Fields(
        delta_v / v_in[:, None],
        cross_matrix(delta_omega) / v_in[:, None, None],
        None if weights is None else weights / weights.sum(),
    )
