"""Which rows say something, and which only repeat others: decided by what the model's own doubles can tell.

In long numbers a zero that the model means is rarely a zero: three axes that should lie in a plane do so to sixteen digits, and
with masses over eight decades what is left may look like a twelfth digit. But it is noise, and noise is told by shaking: of a
mechanism whose doubles differ in their last digits, a direction that exists keeps its size, and one that is rounding takes on
another.
"""

from collections.abc import Callable

import mpmath
import numpy as np
from mpmath import mp

from shockpc.bench.exact import Exact, widen

__all__ = ["least_impulse"]

CLEAR = 1e-6
"""SingularError values above this share of the largest are not rounding; below it the mechanism is shaken."""

SHAKES = (1, 2, 3, 4, 5, 6)
"""Seeds of the mechanisms that doubles cannot tell from this one: so many that noise does not keep its size by chance."""

STEADY = 1.25
"""A direction that rounding changes by more than this factor is no direction."""

NOTHING = mpmath.mpf(10) ** -60
"""What lies below this share of the largest eigenvalue is an exact zero."""


def least_impulse(A: Exact, b: Exact, shake: Callable[[int], Exact]) -> tuple[Exact, int]:
    """Impulses x of least norm (rows scaled to unit mobility) with A x = b as far as it can be met, and the rank of A.

    Args:
        A: (nc, nc) symmetric, the speed along each row for a unit impulse along each other.
        b: (nc,) speeds.
        shake: seed → A of a mechanism that rounding cannot tell from this one.
    """
    x = widen(np.zeros(len(b)))
    diagonal = [A[i, i] for i in range(len(b))]
    top = max(diagonal, default=mp.zero)
    others: list[Exact] = []
    if any(NOTHING * top < value < CLEAR**2 * top for value in diagonal):
        others = [shake(seed) for seed in SHAKES]
    alive = [i for i, value in enumerate(diagonal) if value > NOTHING * top and _steady([value, *(B[i, i] for B in others)])]
    if not alive:
        return x, 0
    values, Q, scale = _spectrum(A, alive)
    if NOTHING * values[0] < min(value for value in values if value > NOTHING * values[0]) < CLEAR**2 * values[0]:
        others = others or [shake(seed) for seed in SHAKES]
    spectra = [values, *(_spectrum(B, alive)[0] for B in others)]
    rank = 0
    while rank < len(alive) and values[rank] > NOTHING * values[0] and _steady([spectrum[rank] for spectrum in spectra]):
        rank += 1
    along = Q[:, :rank].T @ (b[alive] * scale)
    x[alive] = (Q[:, :rank] @ (along / values[:rank])) * scale
    return x, rank


def _steady(squares: list[mpmath.mpf]) -> bool:
    """Whether eigenvalues, squares of singular values, are one and the same but for rounding."""
    roots = [mp.sqrt(max(square, mp.zero)) for square in squares]
    return bool(max(roots) < STEADY * min(roots))


def _spectrum(A: Exact, alive: list[int]) -> tuple[Exact, Exact, Exact]:
    """Eigenvalues, largest first, and eigenvectors of the rows that are left, scaled to unit mobility; and that scaling."""
    scale = np.array([1 / mp.sqrt(A[i, i]) for i in alive], dtype=object)
    scaled = A[np.ix_(alive, alive)] * scale[:, None] * scale[None, :]
    values, vectors = mp.eigsy(mpmath.matrix(scaled.tolist()))
    order = sorted(range(len(alive)), key=lambda k: values[k], reverse=True)
    Q = np.array(vectors.tolist(), dtype=object).reshape(len(alive), len(alive))
    return np.array([values[k] for k in order], dtype=object), Q[:, order], scale
