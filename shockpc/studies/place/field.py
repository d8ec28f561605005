"""Shock over a body for several landings, and the number that points are compared by.

For each landing, the shock at a point r of a body is the norm of an affine function of r: |c + A
r|. Therefore their largest and their mean are convex functions of r.
"""

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
        limit: None if points are compared by the largest shock. With a limit they are compared by
            the mean over the landings, and the shock in each may be at most this [1].
    """

    c: Array
    A: Array
    limit: float | None = None

    def of(self, landings: list[int]) -> "Fields":
        """The fields of some of the landings."""
        return self._replace(c=self.c[landings], A=self.A[landings])

    def vectors(self, points: Array) -> Array:
        """The vectors c + A r (..., L, 3) at points (..., 3) [m]."""
        return np.asarray(self.c + np.einsum("lij,...j->...li", self.A, points))

    def shocks(self, points: Array) -> Array:
        """Shock (..., L) at points (..., 3) [m]."""
        return np.asarray(np.linalg.norm(self.vectors(points), axis=-1))

    def combined(self, shocks: Array) -> Array:
        """The number that points are compared by (...), from the shocks (..., L)."""
        if self.limit is None:
            return np.asarray(shocks.max(axis=-1))
        return np.asarray(shocks.mean(axis=-1))

    def at(self, points: Array) -> Array:
        """The number that points are compared by, at points (n, 3) [m]."""
        values = [np.zeros(0)]
        for k in range(0, len(points), CHUNK):
            shocks = self.shocks(points[k : k + CHUNK])
            values.append(self.combined(shocks))
        return np.concatenate(values)

    def tangents(self, points: Array) -> tuple[Array, Array]:
        """Value (n,) and a gradient (n, 3) of the number at points (n, 3).

        The number is convex, so that it is nowhere below such a tangent.
        """
        values, gradients = [np.zeros(0)], [np.zeros((0, 3))]
        for k in range(0, len(points), CHUNK):
            vectors = self.vectors(points[k : k + CHUNK])
            shocks = np.linalg.norm(vectors, axis=-1)
            values.append(self.combined(shocks))
            gradients.append(self._gradients(vectors, shocks))
        return np.concatenate(values), np.concatenate(gradients)

    def _gradients(self, vectors: Array, shocks: Array) -> Array:
        """Gradients (n, 3) from the vectors v (n, L, 3) and their lengths, the shocks (n, L)."""
        # The number is Σ_l share_l |v_l|.
        share = np.zeros_like(shocks)
        if self.limit is None:
            largest = shocks.argmax(axis=-1)[:, None]
            np.put_along_axis(share, largest, 1.0, axis=-1)
        else:
            share[:] = 1.0 / shocks.shape[-1]
        # Σ_l share_l A_lᵀ v_l / |v_l|
        lengths = np.where(shocks > 0.0, shocks, 1.0)
        y = vectors * (share / lengths)[..., None]
        return np.asarray(np.einsum("nli,lij->nj", y, self.A))


def fields_of(delta_omega: Array, delta_v: Array, v_in: Array) -> Fields:
    """Shock over a body from its jumps.

    Args:
        delta_omega: (L, 3) jump of angular velocity in each landing, body axes [rad/s].
        delta_v: (L, 3) jump of velocity of the body frame's origin, body axes [m/s].
        v_in: (L,) speed by which shock is normalised [m/s].
    """
    return Fields(delta_v / v_in[:, None], cross_matrix(delta_omega) / v_in[:, None, None])
