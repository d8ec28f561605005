"""What a contact has to stop: effective masses, and how well joints keep an impact from the body behind them.

All from the Delassus matrix A = J H⁻¹ Jᵀ of one contact point: how fast the point gives way to an impulse.
"""

import numpy as np

from shockpc.core.impulse import solve_impact
from shockpc.core.spatial import Array

__all__ = ["delassus", "effective_masses", "impact_mitigation"]


def delassus(H: Array, J: Array, K: Array) -> Array:
    """A = J P Jᵀ (..., 3, 3) [1/kg], with P = H⁻¹ − H⁻¹Kᵀ (K H⁻¹ Kᵀ)⁺ K H⁻¹ where other rows K (…, nk, nv) stay held.

    What unit impulses at the point set moving, the held rows undo like an impact: their rank is decided as everywhere else.

    Args:
        H: (..., nv, nv) joint-space inertia.
        J: (..., 3, nv) velocity of the contact point along x, y and z.
        K: (..., nk, nv) rows that are held besides; nk may be 0.
    """
    moved = np.linalg.solve(H, np.swapaxes(J, -1, -2))
    if K.shape[-2]:
        moved = moved + solve_impact(H, K, K @ moved).delta_qd
    A = J @ moved
    return np.asarray(0.5 * (A + np.swapaxes(A, -1, -2)))


def effective_masses(A: Array, n: Array) -> tuple[float, float]:
    """Mass that resists along n: frictionless 1 / (nᵀ A n), and sticking nᵀ A⁻¹ n [kg].

    They differ: a contact that sticks stops the point sideways too. Infinite where the point cannot move along n at all.

    Args:
        A: (3, 3) Delassus matrix of the contact point [1/kg].
        n: (3,) unit normal of the ground.
    """
    gives = float(n @ A @ n)
    size = float(np.abs(A).max())
    if gives <= 1e-13 * size or size == 0.0:
        return np.inf, np.inf
    values, vectors = np.linalg.eigh(A)
    along = vectors.T @ n
    stuck = values <= 1e-13 * values[-1]
    # A direction that cannot move takes any impulse; it makes n immovable only if n has a part along it.
    if np.any(np.abs(along[stuck]) > 1e-7):
        return 1.0 / gives, np.inf
    return 1.0 / gives, float(np.sum(along[~stuck] ** 2 / values[~stuck]))


def impact_mitigation(A: Array, A_locked: Array) -> float | None:
    """Impact mitigation factor det(I − Λ Λ_L⁻¹), Λ = A⁻¹ and Λ_L with every joint locked (Wensing et al., T-RO 2017).

    1 when the joints hide all of the robot's inertia from the ground, 0 when they hide none. It needs a free base.

    Args:
        A: (3, 3) Delassus matrix of the contact point.
        A_locked: (3, 3) the same with every joint locked.

    Returns: None where the contact cannot give way in some direction, and where the joints can do nothing in one: across the plane
    of a planar mechanism the factor is zero whatever its joints are.
    """
    values = np.linalg.eigvalsh(A)
    if values[0] <= 1e-13 * values[-1]:
        return None
    moving = np.linalg.eigvalsh(A - A_locked)
    if moving[0] <= 1e-9 * moving[-1] and moving[-1] > 1e-9 * values[-1]:
        return None
    return float(np.linalg.det(np.eye(3) - np.linalg.solve(A, A_locked)))
