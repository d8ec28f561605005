"""The oscillations of springs and dampers between two events, in the modes of the springs.

In these modes p are the deflections from rest and υ the velocities, both in √J. Dampers beside
springs make C, those in series with springs make R:

    ṗ = σ υ − R p,    υ̇ = −σ p − C υ

Without dampers (p, υ) rotate by the angles σt. With those beside springs, the 2m eigenvectors of
the m modes with σ > 0 are those of the quadratic eigenproblem λ² + λ C + σ². At a critical damping
two of them are parallel: dampers that are larger by 1e-9 then give a motion that differs as little.
"""

from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.wings.compliant.motion.crossing import ComplexArray

PARALLEL = 1e6
"""Size of the coefficients from which eigenvectors count as parallel.

They are those of a state of length 1, as the eigenvectors.
"""

CHANGED = (0.0, 1e-9, 1e-8, 1e-7, 1e-6)
"""Shares by which dampers are larger, until the eigenvectors span all states."""


class Oscillations(NamedTuple):
    """The motion Re(p exp(λt)), Re(velocity exp(λt)) of d modes in k oscillations.

    Attributes:
        rate: (k,) λ [rad/s].
        deflection, velocity: (d, k) p and υ [√J]; (d,) the diagonals where each mode is one
            oscillation.
        bounds: of the lengths of the first and second derivatives of (p, υ), infinite without
            dampers [√J/s, √J/s²].
    """

    rate: ComplexArray
    deflection: ComplexArray
    velocity: ComplexArray
    bounds: tuple[float, float]


class Damped(NamedTuple):
    """The eigenvectors of modes with dampers.

    Attributes:
        deflects: (d,) which of the modes have a deflection, p of them: with dampers in series, all.
        moves: (d,) which of them have a frequency, m of them.
        A: (p + m, p + m) the rates of (p, υ).
        rate, vectors, inverse: eigenvalues, eigenvectors, and the inverse of their matrix.
    """

    deflects: np.ndarray
    moves: np.ndarray
    A: Array
    rate: ComplexArray
    vectors: ComplexArray
    inverse: ComplexArray


def undamped(sigma: Array, deflection: Array, velocity: Array) -> Oscillations:
    """The oscillations of modes of the frequencies sigma (d,).

    They start from a deflection (d,) and a velocity (d,).
    """
    turning: ComplexArray = np.empty(len(sigma), dtype=complex)
    turning.real, turning.imag = deflection, np.where(sigma > 0.0, -velocity, 0.0)
    rate: ComplexArray = np.zeros(len(sigma), dtype=complex)
    rate.imag = sigma
    return Oscillations(rate, turning, 1j * turning, (np.inf, np.inf))


def damped_modes(sigma: Array, dampers: Array, in_series: Array) -> Damped:
    """The eigenvectors of modes with dampers.

    Args:
        sigma: (d,) frequencies without dampers [rad/s].
        dampers: (k, d) √c times the velocity of each damper for unit velocities of the modes; zero
            for modes without frequency.
        in_series: (l, d) √γ times the deflection of each spring that has a damper in series, for
            unit deflections of the modes; γ is the rate at which that lets its force decay.

    Raises:
        ArithmeticError: they do not span all states.
    """
    moves = sigma > 0.0
    deflects = moves | (len(in_series) > 0)
    S, G, R = np.diag(sigma)[deflects][:, moves], dampers[:, moves], in_series[:, deflects]
    differ, differs = (1.0 + np.arange(len(part)) / max(len(part), 1) for part in (G, R))
    for change in CHANGED:
        in_series_decay = -(R.T * (1.0 + change * differs)) @ R
        dampers_decay = -(G.T * (1.0 + change * differ)) @ G
        A = np.block([[in_series_decay, S], [-S.T, dampers_decay]])
        rate, vectors = np.linalg.eig(A)
        try:
            inverse = np.linalg.inv(vectors)
        except np.linalg.LinAlgError:
            continue
        if np.abs(inverse).max(initial=0.0) <= PARALLEL:
            # No oscillation grows.
            decaying = np.minimum(rate.real, 0.0) + 1j * rate.imag
            return Damped(deflects, moves, A, decaying, vectors + 0.0j, inverse + 0.0j)
    raise ArithmeticError(
        "the oscillations of contacts with dampers cannot be told apart; change the damping "
        "slightly"
    )


def damped(modes: Damped, deflection: Array, velocity: Array) -> Oscillations:
    """The oscillations of modes with dampers, from a deflection (d,) and a velocity (d,).

    A state x becomes Σ_j v_j (V⁻¹ x)_j exp(λ_j t), of the eigenvectors v_j, columns of V.
    """
    deflects, moves, A, rate, vectors, inverse = modes
    state = np.concatenate([deflection[deflects], velocity[moves]])
    # One of each two conjugate ones, twice.
    kept = rate.imag >= 0.0
    twice = np.where(rate.imag > 0.0, 2.0, 1.0)
    waves = (vectors * (inverse @ state) * twice)[:, kept]
    p = int(np.count_nonzero(deflects))
    deflections, velocities = np.zeros((2, len(moves), waves.shape[1]), dtype=complex)
    deflections[deflects], velocities[moves] = waves[:p], waves[p:]
    change = A @ state
    bounds = float(np.linalg.norm(change)), float(np.linalg.norm(A @ change))
    return Oscillations(rate[kept], deflections, velocities, bounds)


def along(rows: Array, waves: ComplexArray) -> ComplexArray:
    """Rows (r, d) of modes times their waves (d, k), or a diagonal (d,) of these: (r, k)."""
    return np.asarray(rows * waves if waves.ndim == 1 else rows @ waves)
