"""Surfaces of triangles, and the points that decide how far they reach."""

import functools
import itertools
from typing import Any, NamedTuple

import numpy as np

from shockpc.core.spatial import Array

FEW = 100
"""Vertices of which none is left out."""

_FLAT, _BENEATH = 1e-5, 1e-6
"""Six times the volume of a tetrahedron up to which it is left out, for points scaled to a cube;
depth below its outer face, as a
share of its height, from which a point counts as inside. Barycentric coordinates of 1e-11 are
rounding then."""


class Mesh(NamedTuple):
    """A surface that need not be convex, nor closed.

    Attributes:
        vertices: (n, 3) [m].
        triangles: (m, 3) indices into the vertices.
        y_up: whether it is from a COLLADA file that says that y is up.
    """

    vertices: Array
    triangles: np.ndarray
    y_up: bool = False


def hull(points: Array) -> Any | None:
    """The convex hull of points (n, 3), of SciPy; None if it has no volume."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        return ConvexHull(points)
    except (QhullError, ValueError):
        return None


def outer_vertices(vertices: Array) -> Array:
    """The vertices (n, 3) without those that are clearly inside their hull, in their order.

    Every analysis evaluates the extremes over them. Some that are no corners remain: a vertex is
    left out where it is inside a tetrahedron of which three corners are the vertices that reach
    farthest in neighbouring directions, and the fourth is the mean of all such. The hull itself
    would need SciPy's module for it, which takes longer to import than most analyses.
    """
    with np.errstate(all="ignore"):
        size = np.ptp(vertices, axis=0)
        if len(vertices) <= FEW or not (size > 0.0).all():
            return vertices
        x = (vertices - vertices.mean(axis=0)) / size
        for level in (1, 2):
            outside = ~_inside(x, level)
            x, vertices = x[outside], vertices[outside]
    return vertices


def _inside(x: Array, level: int) -> np.ndarray:
    """Mask (n,) of the points x (n, 3) inside one of the tetrahedra of `outer_vertices`."""
    directions, triangles = _directions(level)
    farthest = np.array([(x @ direction).argmax() for direction in directions])
    middle = x[sorted(set(farthest.tolist()))].mean(axis=0)
    edges = np.swapaxes(x[farthest[triangles]] - middle, -1, -2)
    solid = np.abs(np.linalg.det(edges)) > _FLAT
    inverse = np.linalg.inv(edges[solid])
    inside = []
    for part in np.split(x - middle, range(FEW, len(x), FEW)):
        # A point is Σ share_k edge_k from the middle; inside, all shares are positive, and their
        # sum is below 1.
        shares = (inverse.reshape(-1, 3) @ part.T).reshape(len(inverse), 3, len(part))
        positive = shares.min(axis=1) >= 0.0
        beneath = shares.sum(axis=1) < 1.0 - _BENEATH
        inside.append((positive & beneath).any(axis=0))
    return np.concatenate(inside)


@functools.cache
def _directions(level: int) -> tuple[Array, np.ndarray]:
    """Directions (n, 3), and the triangles (m, 3) of neighbours.

    They are those of an octahedron, each divided into four so many times.
    """
    signs = np.array(list(itertools.product([-1.0, 1.0], repeat=3)))
    triangles = signs[:, :, None] * np.eye(3)
    for _ in range(level):
        middles = triangles + triangles[:, [1, 2, 0]]
        middles /= np.linalg.norm(middles, axis=-1, keepdims=True)
        corners = []
        for k in range(3):
            corner = [triangles[:, k], middles[:, k], middles[:, k - 1]]
            corners.append(np.stack(corner, axis=1))
        triangles = np.concatenate([middles, *corners])
    points = [tuple(point) for point in (triangles.reshape(-1, 3) + 0.0).tolist()]
    directions = sorted(set(points))
    index = {point: n for n, point in enumerate(directions)}
    neighbours = np.array([index[point] for point in points])
    return np.array(directions), neighbours.reshape(-1, 3)
