"""Step 1: solve the impulsive equation of motion for the jump in joint velocity (shock paper, Eq. 4).

    [ H    J_cᵀ ] [ Δq̇ ]   [  0 ]
    [ J_c   0   ] [ −λ ] = [ −b ]         b = (1 + e) J_c q̇⁻

Works on arrays alone; it neither loads robots nor chooses contacts. What closes a loop is a row with b = 0; what cannot move is
a column left out (Eq. 7, with H and J_c reduced before they come here). All arrays may carry leading axes.
"""

from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.errors import SolveError

__all__ = ["Impact", "independent_rows", "least_impulse", "residuals", "solve_impact", "weakest_columns"]


class Impact(NamedTuple):
    """What an impact does to a mechanism.

    Attributes:
        delta_qd: (..., nv, k) jump of the joint velocities [rad/s, m/s], one column for each column of b.
        impulse: (..., nc, k) impulse of the ground on the robot along each row [N s]: positive where the row is pushed forward.
        unique: (..., nc) whether the row's impulse is determined; where rows repeat each other only their sum is. A row that
            nothing can move along takes no impulse.
        dead: (..., nc) rows that nothing can move along.
        scale: (..., nc) by which each row was brought to unit mobility; zero for dead ones.
        rank: (...) how many rows are independent.
        weakest: (...) smallest singular value that was kept over the largest [1]: rounding in the rows shows divided by it.
        condition: (...) how many times rounding in the inertia is enlarged, 1 / min(L_ii)² of its Cholesky factor, at least [1].
        marginal: (...) whether rounding may have decided the rank: a singular value comes near to where they are left out, or the
            rows by themselves have another.
    """

    delta_qd: Array
    impulse: Array
    unique: np.ndarray
    dead: np.ndarray
    scale: Array
    rank: np.ndarray
    weakest: Array
    condition: Array
    marginal: np.ndarray


MARGIN = 1.0 / 32.0, 8.0
"""Shares of the tolerance: what rounding makes of a zero in fact, and where a singular value is surely none. In between nobody can
tell."""


def solve_impact(H: Array, J_c: Array, b: Array) -> Impact:
    """The jump of least kinetic energy that meets the contact: Δq̇ = −H⁻¹ J_cᵀ (J_c H⁻¹ J_cᵀ)⁺ b, λ = −(J_c H⁻¹ J_cᵀ)⁺ b.

    H = L Lᵀ turns the contact rows into X = L⁻¹ J_cᵀ, and the singular values of X (with H scaled to a unit diagonal and the
    columns of X to unit length) decide the rank; working on X and not on XᵀX keeps twice the digits. Rows count as repeated when a
    singular value falls below 8 n ε / min(L_ii), which bounds what rounding in H can make of a zero; `marginal` tells where one
    came near that, on either side, and where the rows by themselves, without H, have another rank. No damping.

    Args:
        H: (..., nv, nv) joint-space inertia, symmetric positive definite [kg, kg m, kg m²].
        J_c: (..., nc, nv) contact and closure rows.
        b: (..., nc, k) speed to be undone along each row, (1 + e) times the approach [m/s].

    Raises:
        SolveError: H is not positive definite (ask `weakest_columns` which columns are to blame).
    """
    eps = np.finfo(float).eps
    diagonal = np.diagonal(H, axis1=-2, axis2=-1)
    # Below this a diagonal is what rounding made of a zero: the square of 1e-13 in a lever arm.
    if not np.all(diagonal > 1e-26 * diagonal.max(axis=-1, keepdims=True, initial=0.0)):
        raise SolveError("the joint-space inertia has a zero or negative diagonal, so it cannot be inverted")
    d = 1.0 / np.sqrt(diagonal)
    scaled = H * d[..., :, None]
    scaled *= d[..., None, :]
    try:
        L = np.asarray(np.linalg.cholesky(scaled), dtype=np.float64)
    except np.linalg.LinAlgError:
        raise SolveError("the joint-space inertia is not positive definite, so it cannot be inverted") from None
    X = _substitute(L, np.swapaxes(J_c * d[..., None, :], -1, -2))

    n = max(H.shape[-1], J_c.shape[-2])
    least = np.diagonal(L, axis1=-2, axis2=-1).min(axis=-1, initial=1.0)
    tolerance = 8 * n * eps / least
    length = np.linalg.norm(X, axis=-2)
    # A row that nothing can move along is a zero, however loudly its rounding would speak once scaled to unit length.
    dead = length <= tolerance[..., None] * length.max(axis=-1, keepdims=True, initial=0.0)
    c = np.where(dead, 0.0, 1.0 / np.where(dead, 1.0, length))
    U, s, Vt = np.linalg.svd(X * c[..., None, :], full_matrices=False)
    bound = tolerance[..., None] * s.max(axis=-1, keepdims=True, initial=0.0)
    kept = s > bound
    marginal = np.any((s > MARGIN[0] * bound) & (s < MARGIN[1] * bound), axis=-1)
    if not kept.all():
        marginal |= kept.sum(axis=-1) != _own_rank(J_c * d[..., None, :])
    s_inv = np.where(kept, 1.0 / np.where(kept, s, 1.0), 0.0)

    largest = s.max(axis=-1, initial=0.0)
    weakest = np.where(kept, s, np.inf).min(axis=-1, initial=np.inf) / np.where(largest > 0.0, largest, 1.0)

    along = s_inv[..., None] * (Vt @ (c[..., None] * b))
    # What no row reaches stays exactly where it is; the factors leave rounding there.
    y = np.where(X.any(axis=-1, keepdims=True), -(U @ along), 0.0)
    delta_qd = d[..., None] * _substitute_back(L, y)
    V = np.swapaxes(Vt, -1, -2)
    impulse = -c[..., None] * (V @ (s_inv[..., None] * along))
    # A row's impulse is unique when its unit vector lies in the row space that was kept.
    unique = dead | (np.sum((V * kept[..., None, :]) ** 2, axis=-1) > 1.0 - 1e-9)
    return Impact(delta_qd, impulse, unique, dead, c, kept.sum(axis=-1), weakest, 1.0 / least**2, marginal)


def _own_rank(J: Array) -> np.ndarray:
    """How many rows (..., nc, nv) are independent before any inertia couples them; in exact numbers inertia cannot change that."""
    threshold = 8 * max(J.shape[-2:]) * np.finfo(float).eps
    length = np.linalg.norm(J, axis=-1, keepdims=True)
    alive = length > threshold * length.max(axis=-2, keepdims=True, initial=0.0)
    s = np.linalg.svd(np.where(alive, J / np.where(alive, length, 1.0), 0.0), compute_uv=False)
    return np.asarray((s > threshold * s.max(axis=-1, keepdims=True, initial=0.0)).sum(axis=-1))


def _substitute(L: Array, B: Array) -> Array:
    """The X (..., n, k) with L X = B for a lower triangular L: row by row, for all postures at once."""
    X = np.empty(np.broadcast_shapes(L.shape[:-2], B.shape[:-2]) + B.shape[-2:])
    for i in range(B.shape[-2]):
        known = L[..., i : i + 1, :i] @ X[..., :i, :]
        X[..., i, :] = (B[..., i, :] - known[..., 0, :]) / L[..., i, i, None]
    return X


def _substitute_back(L: Array, B: Array) -> Array:
    """The X (..., n, k) with Lᵀ X = B."""
    upside_down = np.swapaxes(L, -1, -2)[..., ::-1, ::-1]
    return _substitute(upside_down, B[..., ::-1, :])[..., ::-1, :]


def independent_rows(H: Array, J_c: Array, rank: int, dead: np.ndarray) -> np.ndarray:
    """Indices of `rank` rows that all others follow from, the farthest from one another first found.

    Rows and not mixtures of them: mixing a row that hardly gives way with one that gives way easily would cost digits.

    Args:
        H: (nv, nv) joint-space inertia.
        J_c: (nc, nv) rows.
        rank: how many are independent, as `solve_impact` found.
        dead: (nc,) rows that nothing can move along, as `solve_impact` found.
    """
    if rank == len(J_c):
        return np.arange(rank)
    X = np.linalg.solve(np.linalg.cholesky(H), J_c.T)
    length = np.linalg.norm(X, axis=0)
    X = X / np.where(dead, np.inf, length)
    chosen: list[int] = []
    for _ in range(rank):
        chosen.append(int(np.argmax(np.linalg.norm(X, axis=0))))
        e = X[:, chosen[-1]] / np.linalg.norm(X[:, chosen[-1]])
        X = X - np.outer(e, e @ X)
        X[:, chosen] = 0.0
    return np.array(sorted(chosen), dtype=int)


def least_impulse(J_c: Array, scale: Array, chosen: np.ndarray, impulse: Array) -> Array:
    """Of all impulses that do what those of some rows do, the one that `solve_impact` gives: of least norm at unit mobility.

    Args:
        J_c: (nc, nv) rows.
        scale: (nc,) that brings them to unit mobility.
        chosen: (r,) indices of rows that all others follow from.
        impulse: (r, k) along those.

    Returns: (nc, k).
    """
    rank = len(chosen)
    if rank == len(J_c):
        return impulse
    U, s, Vt = np.linalg.svd((scale[:, None] * J_c).T, full_matrices=False)
    return np.asarray(scale[:, None] * (Vt[:rank].T @ ((U[:, :rank].T @ (J_c[chosen].T @ impulse)) / s[:rank, None])))


def residuals(H: Array, J_c: Array, b: Array, delta_qd: Array, impulse: Array) -> tuple[Array, Array]:
    """Violation of the two lines of Eq. 4, each relative to the size of its own terms [1].

    The first says whether momentum balances; it is rounding, always. The second, row by row, says above rounding that a row
    contradicts others, or asks for a motion that the mechanism does not have. Terms count with their absolute values, so that the
    large rates of a nearly singular posture are not taken for a contradiction. Arguments as for `solve_impact` and `Impact`.

    Returns: (...) of the momentum line, (..., nc) of every row of the contact line.
    """
    J_T = np.swapaxes(J_c, -1, -2)
    momentum = np.abs(H @ delta_qd - J_T @ impulse).max(axis=(-2, -1), initial=0.0)
    moved = (np.abs(H) @ np.abs(delta_qd) + np.abs(J_T) @ np.abs(impulse)).max(axis=(-2, -1), initial=0.0)
    left = np.abs(J_c @ delta_qd + b).max(axis=-1, initial=0.0)
    # A row that nothing moves along holds rounding alone; the speeds of the other rows say how little that is.
    asked = np.abs(b).max(axis=(-2, -1), initial=0.0)[..., None]
    terms = np.maximum((np.abs(J_c) @ np.abs(delta_qd) + np.abs(b)).max(axis=-1, initial=0.0), asked)
    return momentum / np.where(moved > 0.0, moved, 1.0), left / np.where(terms > 0.0, terms, 1.0)


def weakest_columns(H: Array) -> list[int]:
    """The columns of an inertia that cannot be inverted which hold no inertia of their own, or between them share one.

    Args:
        H: (nv, nv) symmetric.

    Returns: indices, ascending.
    """
    d = np.sqrt(np.abs(np.diagonal(H)))
    empty = d <= 1e-13 * d.max(initial=0.0)
    if empty.any() or not d.size:
        return [int(i) for i in np.flatnonzero(empty)]
    _, vectors = np.linalg.eigh(H / d[:, None] / d[None, :])
    weight = np.abs(vectors[:, 0])
    return [int(i) for i in np.flatnonzero(weight > 0.3 * weight.max())]
