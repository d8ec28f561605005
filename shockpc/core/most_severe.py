"""The most and the least severe strike for a point.

They are the singular values of its 3 × 3 map from strike to shock.
"""

from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array

CLEARLY_APART = 1e-3
"""Part of the largest eigenvalue of AᵀA by which the next one has to be less for its formula to
keep all but three digits.
"""


class ExtremeDirections(NamedTuple):
    """The impact directions with the largest and the smallest shock at a point.

    Attributes:
        most_severe: (..., 3) unit direction of the strike with the largest shock, world axes;
            pointing into the ground.
        most_severe_shock: (...) shock there [1].
        least_severe: (..., 3) unit direction of the strike with the smallest shock; it may be
            level.
        least_severe_shock: (...) shock there [1].
    """

    most_severe: Array
    most_severe_shock: Array
    least_severe: Array
    least_severe_shock: Array


def extreme_directions(maps: Array, up: Array) -> ExtremeDirections:
    """Over all strikes of one speed, the largest |A v| / |v| and the smallest.

    Args:
        maps: (..., 3, 3) jump of a point's velocity for unit strikes along x, y and z; where it is
            not finite, the result is NaN.
        up: (3,) unit normal of the ground; of a direction and its opposite the one that approaches
            the ground is given.
    """
    lost = np.asarray(~np.isfinite(maps).all(axis=(-1, -2)))
    _, s, Vt = np.linalg.svd(np.where(lost[..., None, None], 0.0, maps))
    s[lost] = np.nan
    Vt[lost] = np.nan
    return ExtremeDirections(
        most_severe=_downwards(Vt[..., 0, :], up),
        most_severe_shock=s[..., 0],
        least_severe=_downwards(Vt[..., 2, :], up),
        least_severe_shock=s[..., 2],
    )


def most_severe_direction(maps: Array, up: Array) -> tuple[Array, Array]:
    """The direction (N, 3) and the shock (N,) of the most severe strike.

    As `extreme_directions`, which takes five times as long.

    The direction is the eigenvector of AᵀA with the largest eigenvalue, and the shock √ of that.
    Where the two largest eigenvalues are nearly equal the formulas for these lose digits; singular
    values are computed there.

    Args:
        maps: (N, 3, 3), as for `extreme_directions`.
        up: (3,), likewise.
    """
    # The posture comes last, so that every operation runs over contiguous numbers.
    A = maps.transpose(1, 2, 0).copy()
    with np.errstate(all="ignore"):
        scale = np.abs(A).max(axis=(0, 1))
        A /= scale
        AtA = (A[:, :, None] * A[:, None]).sum(axis=0)
        largest, second = _largest_eigenvalues(AtA)
        direction = _eigenvector(AtA, largest)
        jump = (A * direction).sum(axis=1)
        shock = scale * np.sqrt((jump**2).sum(axis=0))
        clear = largest - second > CLEARLY_APART * largest
    direction = direction.T
    unclear = np.flatnonzero(~clear)
    if unclear.size:
        extremes = extreme_directions(maps[unclear], up)
        direction[unclear] = extremes.most_severe
        shock[unclear] = extremes.most_severe_shock
    return _downwards(direction, up), shock


def _largest_eigenvalues(S: Array) -> tuple[Array, Array]:
    """The two largest eigenvalues (N,) of symmetric matrices S (3, 3, N), by trigonometry.

    They are those of S without its mean diagonal, plus that (Smith 1961, "Eigenvalues of a
    symmetric 3 × 3 matrix").
    """
    mean = np.einsum("iin->n", S) / 3.0
    (a, d, e), (_, b, f), (_, _, c) = S - mean * np.eye(3)[:, :, None]
    # Sum of squares of all entries, and the determinant by the first row.
    diagonal = a * a + b * b + c * c
    squares = diagonal + 2.0 * (d * d + e * e + f * f)
    width = 2.0 * np.sqrt(squares / 6.0)
    determinant = a * (b * c - f * f)
    determinant = determinant - d * (d * c - e * f) + e * (d * f - b * e)
    cosine = np.clip(4.0 * determinant / width**3, -1.0, 1.0)
    angle = np.arccos(cosine) / 3.0
    return mean + width * np.cos(angle), mean + width * np.cos(angle - 2.0 * np.pi / 3.0)


def _eigenvector(S: Array, eigenvalue: Array) -> Array:
    """The unit eigenvectors (3, N) of symmetric matrices S (3, 3, N) with simple eigenvalues (N,).

    The rows of S − λ are perpendicular to it; of the products of two rows the longest is determined
    best.
    """
    rows = S - eigenvalue * np.eye(3)[:, :, None]
    products = np.stack([_cross(rows[i], rows[i - 1]) for i in range(3)])
    longest = (products**2).sum(axis=1).argmax(axis=0)
    direction = products[longest, :, np.arange(S.shape[2])].T
    return np.asarray(direction / np.sqrt((direction**2).sum(axis=0)))


def _cross(a: Array, b: Array) -> Array:
    """Products (3, N) of vectors (3, N)."""
    x, y, z = a
    u, v, w = b
    return np.stack([y * w - z * v, z * u - x * w, x * v - y * u])


def _downwards(direction: Array, up: Array) -> Array:
    """The one of a direction and its opposite that approaches the ground."""
    leaving = direction @ up > 0.0
    return np.asarray(np.where(leaving[..., None], -direction, direction) + 0.0)
