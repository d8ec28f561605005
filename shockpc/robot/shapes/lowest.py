"""The lowest points of the shapes of a body, in its frame, over ground with any normal."""

from collections.abc import Sequence

import numpy as np

from shockpc.core.spatial import Array
from shockpc.robot.shapes.convex import Shape

LEVEL_SHARE, LEAST_EXTENT = 1e-6, 1e-6
"""Points are equally low within this share of their extent, which is at least the second [1, m]."""


def height_of_lowest(shapes: Sequence[Shape], up: Array) -> float:
    """Height of the lowest point of some shapes over the origin of their body [m].

    Args: up, (3,) in the body's axes.
    """
    return -max(float(shape.reach(-up[None])[0]) for shape in shapes)


def lowest_points(shapes: Sequence[Shape], up: Array, tolerance: float) -> Array:
    """The lowest points (k, 3) of some shapes, within a tolerance [m]. Args: up as above."""
    points = np.concatenate([shape.farthest(-up) for shape in shapes])
    height = points @ up
    return np.asarray(points[height <= height.min() + tolerance])


def lowest_point(shapes: Sequence[Shape], up: Array) -> Array:
    """The lowest point (3,) of some shapes.

    It is the mean of the lowest ones where several are equally low.

    Args: up as above.
    """
    candidates = [shape.farthest(-up) for shape in shapes]
    points = np.concatenate(candidates)
    return np.asarray(points[np.concatenate(equally_low(candidates, up))].mean(axis=0))


def equally_low(candidates: Sequence[Array], up: Array) -> list[np.ndarray]:
    """Masks (k,) of the points that are the lowest of all, for several groups (k, 3) of points.

    A foot's sole is level to rounding only; its extent sets what counts as level.
    """
    points = np.concatenate(candidates)
    extent = float(np.ptp(points, axis=0).max())
    limit = (points @ up).min() + LEVEL_SHARE * max(extent, LEAST_EXTENT)
    return [np.asarray(group @ up <= limit) for group in candidates]


def lowest_in_postures(shapes: Sequence[Shape], down: Array) -> Array:
    """The lowest points (N, 3) of some shapes in N postures.

    Args: down, (N, 3) unit vectors in the body's axes.
    """
    lowest = np.stack([_farthest_along(shape, down) for shape in shapes], axis=1)
    deepest = np.einsum("nki,ni->nk", lowest, down).argmax(axis=1)
    return np.asarray(lowest[np.arange(len(down)), deepest])


def _farthest_along(shape: Shape, directions: Array) -> Array:
    """The points (N, 3) of a shape farthest along unit vectors d (N, 3).

    From a corner on to the surface of the ellipsoid E that rounds it: E Eᵀ d / |Eᵀ d|.
    """
    corners = shape.points[(directions @ shape.points.T).argmax(axis=1)]
    along = directions @ shape.rounding
    length = np.linalg.norm(along, axis=1, keepdims=True)
    unit = along / np.where(length > 0.0, length, 1.0)
    return np.asarray(corners + unit @ shape.rounding.T)
