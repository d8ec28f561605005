"""The impulse of soles whose corners push and do not enter the ground: a convex problem.

    minimize ½ fᵀ W f + bᵀ f   over   f = F x + C y,   y ≥ 0

    ⇔   y ≥ 0,   u = Cᵀ(W f + b) ≥ 0,   y · u = 0,   Fᵀ(W f + b) = 0

W = J_c H⁻¹ J_cᵀ is the Delassus matrix of the rows of all contacts, with all soles flat. F are the
combinations of rows that act in both directions, such as forces along the ground. Each column of C
is the unit push of a corner. The problem is the dual of Gauss's principle: of all jumps that stop
the rows F and let no corner enter the ground, it finds that of least kinetic energy. The speeds u
of the corners are unique, because H is positive definite; their pushes y need not be.
"""

from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array

SMALL = 1e-12
"""Share of the largest one below which a singular value, a gain or a push is rounding."""


class CornerImpulse(NamedTuple):
    """The solution of the complementarity problem.

    Attributes:
        impulse: (nc,) f along the rows [N s, N m s].
        push: (m,) y of the corners [N s].
        speed: (m,) u at which the corners leave the ground, times 1 for an inelastic impact [m/s].
    """

    impulse: Array
    push: Array
    speed: Array


def corner_impulse(X: Array, b: Array, free: Array, corners: Array) -> CornerImpulse:
    """The impulse of all contacts of which the corners only push.

    With W = Xᵀ X and b = Xᵀ s, the minimum over x leaves a problem in y alone: minimize
    |P (X C y + s)|, P the projection across the range of X F.

    Args:
        X: (nv, nc) L⁻¹ J_cᵀ, with the Cholesky factor L of the inertia.
        b: (nc,) speeds to be undone along the rows [m/s, rad/s].
        free: (nc, p) F.
        corners: (nc, m) C.

    Raises:
        ArithmeticError: the search does not end.
    """
    s = np.linalg.lstsq(X.T, b, rcond=SMALL)[0]
    U, size, _ = np.linalg.svd(X @ free, full_matrices=False)
    range_of_free = U[:, size > SMALL * size.max(initial=0.0)]
    by_corner = X @ corners
    by_corner = by_corner - range_of_free @ (range_of_free.T @ by_corner)
    s_across = s - range_of_free @ (range_of_free.T @ s)
    # Columns of unit length make the gains of corners comparable.
    length = np.linalg.norm(by_corner, axis=0)
    length = np.where(length > 0.0, length, 1.0)
    push = nonnegative_least_squares(by_corner / length, -s_across) / length
    of_corners = corners @ push
    x = np.linalg.lstsq(X @ free, -(s + X @ of_corners), rcond=SMALL)[0]
    return CornerImpulse(of_corners + free @ x, push, by_corner.T @ (by_corner @ push + s_across))


def nonnegative_least_squares(B: Array, d: Array) -> Array:
    """The y ≥ 0 (m,) that minimizes |B y − d|.

    By the active sets of Lawson and Hanson ("Solving Least Squares Problems", 1974, Section 23.3).
    SciPy, which has the same, takes longer to import than a landing to compute.

    Args:
        B: (n, m), columns of unit length or zero.
        d: (n,)

    Raises:
        ArithmeticError: the search does not end.
    """
    m = B.shape[1]
    y, active = np.zeros(m), np.zeros(m, dtype=bool)
    dependent = np.zeros(m, dtype=bool)
    for _ in range(10 * (m + 1)):
        gain = np.where(active | dependent, -np.inf, B.T @ (d - B @ y))
        entering = int(gain.argmax()) if m else -1
        if m == 0 or gain[entering] <= SMALL * np.linalg.norm(d):
            return y
        trial = active.copy()
        trial[entering] = True
        z = _least_squares(B, d, trial)
        if z[entering] <= 0.0:
            # Only rounding says that this column, which depends on the active ones, would gain.
            dependent[entering] = True
            continue
        active, y = _until_nonnegative(B, d, y, trial, z)
        dependent[:] = False
    raise ArithmeticError("the search for the corners that push does not end")


def _until_nonnegative(
    B: Array,
    d: Array,
    y: Array,
    active: np.ndarray,
    z: Array,
) -> tuple[np.ndarray, Array]:
    """The active set (m,) without what would be negative, and its least-squares solution (m,).

    Args:
        B: as of `nonnegative_least_squares`.
        d: as there.
        y: (m,) ≥ 0, from which the search goes towards z.
        active: (m,) which entries may be above zero.
        z: (m,) least-squares solution over these.
    """
    while np.any(z[active] <= 0.0):
        negative = np.flatnonzero(active & (z <= 0.0))
        steps = y[negative] / (y[negative] - z[negative])
        y = y + steps.min() * (z - y)
        active = active & (y > SMALL * y.max(initial=0.0))
        active[negative[steps.argmin()]] = False
        y = np.where(active, y, 0.0)
        z = _least_squares(B, d, active)
    return active, z


def _least_squares(B: Array, d: Array, active: np.ndarray) -> Array:
    """The y (m,) that minimizes |B y − d| of which only the active entries (m,) are not zero."""
    y = np.zeros(B.shape[1])
    if active.any():
        y[active] = np.linalg.lstsq(B[:, active], d, rcond=SMALL)[0]
    return y
