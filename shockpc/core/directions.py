"""The most and the least severe strike for a point: singular values of its 3 × 3 map from strike to shock."""

from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array

__all__ = ["ExtremeDirections", "extreme_directions", "most_severe_directions"]

SEPARATED = 0.01
"""Share of the greatest eigenvalue by which it exceeds the next where its closed form keeps all digits of the eigenvector."""


class ExtremeDirections(NamedTuple):
    """The impact directions with the greatest and the least shock at a point.

    Attributes:
        most_severe: (..., 3) unit direction of the strike with the greatest shock, world axes; pointing into the ground.
        most_severe_shock: (...) shock there [1].
        least_severe: (..., 3) unit direction of the strike with the least shock; it may be level.
        least_severe_shock: (...) shock there [1].
    """

    most_severe: Array
    most_severe_shock: Array
    least_severe: Array
    least_severe_shock: Array


def extreme_directions(maps: Array, up: Array) -> ExtremeDirections:
    """Over all strikes of one speed, the greatest |A v| / |v| and the least.

    Args:
        maps: (..., 3, 3) jump of a point's velocity for unit strikes along x, y and z.
        up: (3,) unit normal of the ground; of a direction and its opposite the one that approaches the ground is given.
    """
    _, s, Vt = np.linalg.svd(maps)
    most_severe, least_severe = Vt[..., 0, :], Vt[..., 2, :]

    return ExtremeDirections(_downwards(most_severe, up), s[..., 0], _downwards(least_severe, up), s[..., 2])


def most_severe_directions(maps: Array, up: Array) -> tuple[Array, Array]:
    """The most severe strike alone, for many maps: a tenth of the time of `extreme_directions`.

    The greatest eigenvalue of AᵀA is a root of a cubic (Smith 1961), and its eigenvector a column of adj(AᵀA − λ); one more round
    with the Rayleigh quotient brings the vector to full precision. Maps whose two greatest eigenvalues are near are left to the
    singular value decomposition.

    Args:
        maps: (N, 3, 3) jump of a point's velocity for unit strikes along x, y and z.
        up: (3,) unit normal of the ground.

    Returns: directions (N, 3) as in `ExtremeDirections`, and the shock (N,) there [1].
    """
    size = np.abs(maps).max(axis=(1, 2))
    size = np.where(size > 0.0, size, 1.0)
    a, b, c = (maps[:, :, k].T / size for k in range(3))
    xx, yy, zz, xy, xz, yz = _dot(a, a), _dot(b, b), _dot(c, c), _dot(a, b), _dot(a, c), _dot(b, c)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        mean = (xx + yy + zz) / 3.0
        dx, dy, dz = xx - mean, yy - mean, zz - mean
        p = np.sqrt((dx * dx + dy * dy + dz * dz + 2.0 * (xy * xy + xz * xz + yz * yz)) / 6.0)
        det = dx * (dy * dz - yz * yz) - xy * (xy * dz - yz * xz) + xz * (xy * yz - dy * xz)
        angle = np.arccos(np.clip(det / (2.0 * p**3), -1.0, 1.0)) / 3.0
        largest = mean + 2.0 * p * np.cos(angle)
        gap = 2.0 * np.sqrt(3.0) * p * np.sin(np.pi / 3.0 - angle)
        for _ in range(2):
            v = _adjugate_column(xx - largest, yy - largest, zz - largest, xy, xz, yz)
            image = a * v[0] + b * v[1] + c * v[2]
            largest = _dot(image, image)
        direction, shock = _downwards(v.T, up), np.sqrt(largest) * size
        unclear = np.flatnonzero(~(gap > SEPARATED * largest))
    if len(unclear):
        found = extreme_directions(maps[unclear], up)
        direction[unclear], shock[unclear] = found.most_severe, found.most_severe_shock
    return direction, shock


def _downwards(direction: Array, up: Array) -> Array:
    """Of a direction and its opposite, the one that approaches the ground."""
    leaving = direction @ up > 0.0
    return np.asarray(np.where(leaving[..., None], -direction, direction) + 0.0)


def _dot(a: Array, b: Array) -> Array:
    """Scalar products (N,) of columns (3, N)."""
    return np.asarray(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


def _adjugate_column(x: Array, y: Array, z: Array, xy: Array, xz: Array, yz: Array) -> Array:
    """The largest column (3, N) of the adjugate of symmetric matrices, as a unit vector."""
    xx, yy, zz = y * z - yz * yz, x * z - xz * xz, x * y - xy * xy
    ab, ac, bc = xz * yz - xy * z, xy * yz - xz * y, xy * xz - yz * x
    diagonal = np.abs(np.stack([xx, yy, zz]))
    first, second = diagonal[0] >= np.maximum(diagonal[1], diagonal[2]), diagonal[1] >= diagonal[2]
    v = np.stack([np.where(first, i, np.where(second, j, k)) for i, j, k in ((xx, ab, ac), (ab, yy, bc), (ac, bc, zz))])
    return np.asarray(v / np.sqrt(_dot(v, v)))
