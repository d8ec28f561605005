"""Eq. 4 assembled: what `core.impulse` solves, in the velocities that are free."""

from typing import NamedTuple

import numpy as np

from shockpc.core.impulse import TOLERANCE
from shockpc.core.inertia import Inertia, diagonal_of, matrix_of
from shockpc.core.spatial import Array
from shockpc.model.dynamics import Dynamics
from shockpc.model.rows import Block, row_terms

__all__ = ["Equation"]


class Equation(NamedTuple):
    """The impulsive equation of motion in N postures, in the free velocities ẏ.

    Attributes:
        inertia: GᵀHG, armature included.
        J_c: (N, nc, ny) J_c G, closure rows included.
        b: (N, nc, k) speeds to be undone along each row, (1 + e) J_c q̇⁻ [m/s, rad/s].
        G: (N, nv, ny), or None where all velocities are free.
        state: the robot.
        blocks: the rows.
    """

    inertia: Inertia
    J_c: Array
    b: Array
    G: Array | None
    state: Dynamics
    blocks: tuple[Block, ...]

    @property
    def H(self) -> Array:
        """(N, ny, ny) GᵀHG [kg, kg m, kg m²]."""
        return matrix_of(self.inertia)

    def terms(self, k: int) -> Array:
        """Sizes (nc, ny) of the terms that the entries of J_c are sums of, in one posture."""
        terms = row_terms(self.state, self.blocks)[k]
        return terms if self.G is None else np.asarray(terms @ np.abs(self.G[k]))

    def cancellation(self) -> Array:
        """By how much (N,) terms cancel in the entries of J_c, in the row where they do so most [1].

        Rows along which nothing can move do not count. On a free base the rows of contacts hold its own velocity: little cancels.
        """
        weight = 1.0 / np.sqrt(np.maximum(diagonal_of(self.inertia), 1e-300))[:, None]
        terms = row_terms(self.state, self.blocks)
        terms = terms if self.G is None else terms @ np.abs(self.G)
        length, whole = (np.linalg.norm(entries * weight, axis=-1) for entries in (self.J_c, terms))
        moves = length > TOLERANCE * whole
        return np.asarray(np.max(np.where(moves, whole, 1.0) / np.where(moves, length, 1.0), axis=-1, initial=1.0))

    def full(self, delta: Array) -> Array:
        """Jumps (N, nv, k) of all joint velocities, q̇ = G ẏ. Args: delta (N, ny, k)."""
        return delta if self.G is None else np.asarray(self.G @ delta)
