"""The surface of a body, as flat convex facets, and the half-spaces whose intersection a convex shape is."""

from typing import Any, NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.robot.geometry import Shape, ball_points

__all__ = ["HalfSpaces", "facets", "half_spaces"]


class HalfSpaces(NamedTuple):
    """The convex set of the points r with normals · r ≤ offsets.

    Attributes:
        normals: (m, 3) unit vectors, outward.
        offsets: (m,) [m].
    """

    normals: Array
    offsets: Array

    def depth(self, r: Array) -> float:
        """How far inside all faces a point (3,) lies; below zero outside [m]."""
        return float((self.offsets - self.normals @ r).min())


def facets(shape: Shape) -> list[Array]:
    """The surface of a shape, each facet as its corners (k, 3) in the body's frame [m].

    The surface of a mesh is its triangles. A rounded shape is a polyhedron with its corners on the sphere, inside it by at most
    0.25 % of the radius. A flat shape is its own surface.
    """
    if shape.mesh is not None:
        return list(shape.mesh.vertices[shape.mesh.triangles])
    points = _corners(shape)
    hull = _hull(points)
    return [points] if hull is None else list(points[hull.simplices])


def half_spaces(shape: Shape) -> HalfSpaces | None:
    """The half-spaces of a convex shape; None for a mesh, which need not be convex, and for a flat shape, which has no inside."""
    hull = None if shape.mesh is not None else _hull(_corners(shape))
    if hull is None:
        return None
    faces = np.unique(hull.equations.round(12), axis=0)
    return HalfSpaces(faces[:, :3], -faces[:, 3])


def _corners(shape: Shape) -> Array:
    """Points (k, 3) whose hull is the shape."""
    if shape.radius == 0.0:
        return shape.points
    return np.asarray((shape.points[:, None] + shape.radius * ball_points()).reshape(-1, 3))


def _hull(points: Array) -> Any | None:
    """The convex hull; None if it has no volume."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        return ConvexHull(points)
    except (QhullError, ValueError):
        return None
