"""How a sensor is turned, so that none of its axes sees much: each axis has its own range.

The greatest component of some vectors in a turned frame is a function of the rotation that changes by at most the length of the
longest vector times the angle. A quarter turn about an axis only exchanges axes, so all frames that differ are within a cube of
Rodrigues vectors (axis times the tangent of half the angle) of half-side tan(π/8). Dividing this cube, and leaving out parts whose
bound exceeds a value found elsewhere, gives the optimum with a proven gap.
"""

import itertools
import math
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array, cross_matrix

GAP = 1e-3
"""Gap at which the search ends, as a share of the longest vector."""

MOST_ROTATIONS = 200_000
"""Parts of the cube that are kept at once; with more, the search ends with the gap that it has reached."""

CHUNK = 4096
"""Rotations that are evaluated together."""


class Mounting(NamedTuple):
    """A rotation of a sensor.

    Attributes:
        rotation: (3, 3) from the sensor's axes to those of the body.
        greatest: the greatest component along any of its axes.
        bound: no rotation has a smaller one.
    """

    rotation: Array
    greatest: float
    bound: float

    @property
    def rpy_deg(self) -> tuple[float, float, float]:
        """Roll, pitch and yaw [deg]."""
        R = self.rotation
        angles = (math.atan2(R[2, 1], R[2, 2]), -math.asin(min(1.0, max(-1.0, R[2, 0]))), math.atan2(R[1, 0], R[0, 0]))
        roll, pitch, yaw = (round(math.degrees(angle), 9) + 0.0 for angle in angles)
        return roll, pitch, yaw


def best_mounting(vectors: Array) -> Mounting:
    """The rotation in which the greatest component of vectors (n, 3) is least; of several, the one with the smallest angle."""
    longest = float(np.linalg.norm(vectors, axis=1).max(initial=0.0))
    if longest == 0.0:
        return Mounting(np.eye(3), 0.0, 0.0)
    half = math.tan(math.pi / 8.0) / 4.0
    steps = half * np.array([-3.0, -1.0, 1.0, 3.0])
    cells = np.array(list(itertools.product(steps, repeat=3)))
    best, least = np.zeros(3), float(np.abs(vectors).max())
    while True:
        values = np.concatenate([_greatest(cells[k : k + CHUNK], vectors) for k in range(0, len(cells), CHUNK)])
        k = int(np.lexsort((np.linalg.norm(cells, axis=1).round(9), values.round(12)))[0])
        if values[k] < least - 1e-12 * longest:
            best, least = cells[k], float(values[k])
        # Rodrigues vectors that differ by δ are at most 2|δ| apart, and |δ| is at most half the diagonal of a part.
        bounds = values - longest * 2.0 * math.sin(min(math.sqrt(3.0) * half, math.pi / 2.0))
        open_ = bounds < least - GAP / 2.0 * longest
        # What was left out is not below the second of these.
        bound = min(float(bounds.min()), least - GAP / 2.0 * longest)
        if not open_.any() or least - bound <= GAP * longest or 8 * int(open_.sum()) > MOST_ROTATIONS:
            return Mounting(_rotations(best[None])[0], least, max(bound, longest / math.sqrt(3.0)))
        half /= 2.0
        corners = half * np.array(list(itertools.product([-1.0, 1.0], repeat=3)))
        cells = (cells[open_][:, None] + corners).reshape(-1, 3)


def _rotations(rodrigues: Array) -> Array:
    """Rotation matrices (n, 3, 3) of Rodrigues vectors (n, 3)."""
    K, squared = cross_matrix(rodrigues), np.sum(rodrigues**2, axis=1)[:, None, None]
    return np.asarray(np.eye(3) + 2.0 / (1.0 + squared) * (K + K @ K))


def _greatest(rodrigues: Array, vectors: Array) -> Array:
    """The greatest component (n,) of vectors in the axes of rotations: those of Rᵀ v."""
    return np.asarray(np.abs(vectors @ _rotations(rodrigues)).max(axis=(1, 2)))
