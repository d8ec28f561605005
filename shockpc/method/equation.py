"""The impulsive equation of motion in the free velocities (shock paper, Eqs. 4 and 7)."""

from typing import NamedTuple

import numpy as np

from shockpc.core.impulse import TOLERANCE, RowLimit, RowSpace, column_sizes, independent_rows
from shockpc.core.inertia import Inertia, definite, diagonal_of, matrix_of
from shockpc.core.spatial import Array, Plane
from shockpc.method.approach import Motion, approach_speeds
from shockpc.method.base import Base
from shockpc.method.constraints import Constraint, row_jacobian, row_terms, row_tolerance
from shockpc.method.dynamics import Dynamics
from shockpc.method.selection_matrix import free_columns
from shockpc.robot.robot import Robot


class System(NamedTuple):
    """The data of Eq. 4 beside a posture and the constraints.

    Attributes:
        robot: the robot.
        base: how its base may move.
        plane: of the study, in which a planar base moves.
        locked: (nv,) joint velocities that are held at zero.
        armature: (nv,) reflected inertia of the joints [kg m², kg].
        coupling: (nv,) of the joints to the links that carry their rotors [kg m²]; part of the
            armature.
        before: the motion before the impact; None where only unit strikes are asked for.
    """

    robot: Robot
    base: Base
    plane: Plane
    locked: np.ndarray
    armature: Array
    coupling: Array
    before: Motion | None = None


class Posed(NamedTuple):
    """A system in one posture, from which balls are evaluated.

    Attributes:
        system: the robot, and what of it is free.
        q: (nq,) its configuration.
        constraints: what is held, each with one point (3,).
    """

    system: System
    q: Array
    constraints: tuple[Constraint, ...]


class Equation(NamedTuple):
    """The impulsive equation of motion in N postures, in the free velocities ẏ.

    Attributes:
        inertia: GᵀHG, armature included.
        J_c: (N, nc, ny) J_c G, closure rows included.
        b: (N, nc, k) speeds to be undone along each row, (1 + e) J_c q̇⁻ [m/s, rad/s].
        G: (N, nv, ny), or None where all velocities are free.
        state: the robot.
        constraints: the rows.
        system: the robot, and what of it is free.
    """

    inertia: Inertia
    J_c: Array
    b: Array
    G: Array | None
    state: Dynamics
    constraints: tuple[Constraint, ...]
    system: System

    @property
    def H(self) -> Array:
        """(N, ny, ny) GᵀHG [kg, kg m, kg m²]."""
        return matrix_of(self.inertia)

    @property
    def tolerance(self) -> float:
        """Relative error of the terms of the rows, as in `independent_rows`."""
        return row_tolerance(self.constraints)

    def terms(self) -> Array:
        """Sizes (N, nc, ny) of the terms that the entries of J_c are sums of."""
        terms = row_terms(self.state, self.constraints)
        return terms if self.G is None else np.asarray(terms @ np.abs(self.G))

    def cancellation(self) -> Array:
        """Cancellation (N,) of terms in the entries of J_c, in the row where it is largest [1].

        Rows along which nothing can move do not count. On a free base the rows of contacts hold its
        velocity: little cancels.
        """
        weight = 1.0 / np.sqrt(np.maximum(diagonal_of(self.inertia), 1e-300))[:, None]
        length = np.linalg.norm(self.J_c * weight, axis=-1)
        of_terms = np.linalg.norm(self.terms() * weight, axis=-1)
        moves = length > TOLERANCE * of_terms
        ratio = np.where(moves, of_terms, 1.0) / np.where(moves, length, 1.0)
        return np.asarray(np.max(ratio, axis=-1, initial=1.0))

    def row_space(self, limit: RowLimit, scale: Array | None = None) -> RowSpace:
        """The independent rows of the first posture, by their singular values in doubles.

        Args:
            limit: of its rows.
            scale: (nc,) brings each row to unit mobility; 1 by default.
        """
        J_c, terms = self.J_c[0], self.terms()[0]
        if scale is None:
            scale = np.ones(len(J_c))
        return independent_rows(J_c, terms, column_sizes(terms), scale, self.tolerance, limit)

    def full(self, delta: Array) -> Array:
        """Jumps (N, nv, k) of all joint velocities, q̇ = G ẏ. Args: delta (N, ny, k)."""
        return delta if self.G is None else np.asarray(self.G @ delta)


def equation_of(system: System, state: Dynamics, constraints: tuple[Constraint, ...]) -> Equation:
    """Eq. 4, left: H, J_c and b = (1 + e) J_c q̇⁻, reduced to the free velocities (Eq. 7).

    Args:
        system: the robot, and what of it is free.
        state: it in N postures, with the armature of its joints.
        constraints: what is held.
    """
    G = free_columns(system.robot, system.base, system.plane, state.rotation[:, 0], system.locked)
    J_c = row_jacobian(state, constraints)
    b = approach_speeds(state, constraints, system.before)
    inertia = state.inertia
    if G is not None:
        inertia = np.swapaxes(G, -1, -2) @ state.H @ G
        J_c = J_c @ G
    if system.robot.negative_moments:
        inertia = definite(inertia)  # NaN, which is refused by name where a landing is solved
    return Equation(inertia, J_c, b, G, state, constraints, system)
