"""Directions in which a contact or a closure holds a point: axes by name, or vectors."""

import numpy as np

from shockpc.core.spatial import Array, cross
from shockpc.text.errors import SceneError

UNIT_VECTORS = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


def span_space(owner: str, directions: tuple[str | tuple[float, float, float], ...]) -> bool:
    """True if directions span space, so that nothing slides."""
    return bool(np.linalg.matrix_rank(unit_directions(owner, directions)) == 3)


def unit_directions(owner: str, directions: tuple[str | tuple[float, float, float], ...]) -> Array:
    """Directions as unit vectors (n, 3); "x", "y" and "z" are the axes.

    Raises:
        SceneError: there is none, or one has no length.
    """
    if not directions:
        raise SceneError(
            f'{owner} keeps no direction, so nothing stops it; valid are "x", "y", "z" and vectors'
        )
    vectors = np.zeros((len(directions), 3))
    for k, direction in enumerate(directions):
        vectors[k] = UNIT_VECTORS[direction] if isinstance(direction, str) else direction
    lengths = np.linalg.norm(vectors, axis=1)
    if not (np.all(np.isfinite(vectors)) and np.all(lengths > 0.0)):
        raise SceneError(
            f'{owner} has a direction without a length; valid are "x", "y", "z" and vectors'
        )
    return np.asarray(vectors / lengths[:, None])


def across(up: Array) -> tuple[Array, Array]:
    """Two unit vectors that span the ground."""
    first = cross(up, np.eye(3)[np.argmin(np.abs(up))])
    first /= np.linalg.norm(first)
    return first, cross(up, first)
