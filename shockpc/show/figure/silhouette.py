"""The outline of a body in the plane of the figure: the union of the projections of its shapes.

Polyhedra are projected exactly; round shapes as polygons inside their projection, with 64 corners
to an ellipse, short by 0.12 %. A mesh may have a hundred thousand triangles, holes and gaps, so its
projection is counted on a fine grid, triangle by triangle, and contoured; that works for any set of
triangles and costs a few milliseconds.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple, TypeAlias

import contourpy
import numpy as np
import shapely
from numpy.typing import NDArray

from shockpc.core.spatial import Array, Plane, corners_of_box
from shockpc.robot.shapes.convex import Shape

PlaneShape: TypeAlias = Any
"""A shapely Polygon or MultiPolygon in plane coordinates [m]; shapely comes without type stubs."""

CIRCLE = np.exp(2j * np.pi * np.arange(64) / 64).view(float).reshape(-1, 2)
"""Corners (64, 2) of the polygon that represents a unit circle."""

LARGEST_GRID = 2500
"""Most cells along a side, whatever resolution is requested."""


MOST_CROSSINGS = 10**7
"""Largest number of rows of the grid that the edges of a mesh cross, all together.

A mesh that would cross more has a coarser grid.
"""


def to_plane(points: Array, plane: Plane) -> Array:
    """Plane coordinates (..., 2) of world points (..., 3): along e1 and e2 [m]."""
    return np.asarray(points @ np.stack([plane.e1, plane.e2], axis=1))


def surface(shapes: Sequence[Shape]) -> Array:
    """Points (n, 3) of some shapes [m]: corners, and of round ones the extremes along the axes."""
    sides = np.concatenate([np.eye(3), -np.eye(3)])
    points = []
    for shape in shapes:
        directions = sides if shape.rounding.any() else sides[:1]
        points += [shape.farthest(side) for side in directions]
    return np.concatenate(points)


def projection(shape: Shape, plane: Plane) -> PlaneShape:
    """The projection of a convex shape on a plane."""
    axes, lengths, _ = np.linalg.svd(to_plane(shape.rounding.T, plane).T, full_matrices=False)
    rim = (CIRCLE * lengths) @ axes.T
    return shapely.MultiPoint(
        (to_plane(shape.points, plane)[:, None] + rim).reshape(-1, 2)
    ).convex_hull


class Edges(NamedTuple):
    """The edges of a mesh.

    Attributes:
        low, high: (k,) vertices at their ends, the lower index first.
        edge: (3 m,) that of each side of the triangles: of all first sides, all second sides and
            all third sides.
        sense: (3 m,) 1 for a side that runs from low to high, else −1.
    """

    low: NDArray[np.int64]
    high: NDArray[np.int64]
    edge: NDArray[np.int64]
    sense: Array

    @classmethod
    def of(cls, triangles: NDArray[np.int64], count: int) -> "Edges":
        """The edges of triangles (m, 3) between so many vertices."""
        start, end = triangles.T.ravel(), np.roll(triangles, -1, axis=1).T.ravel()
        edges, edge = np.unique(
            np.minimum(start, end) * count + np.maximum(start, end), return_inverse=True
        )
        return cls(*np.divmod(edges, count), edge, np.where(start < end, 1.0, -1.0))


def silhouette(
    shapes: Sequence[Shape], plane: Plane, resolution: float, edges: dict[int, Edges] | None = None
) -> PlaneShape:
    """The union of the projections of shapes on a plane; empty if there are none.

    Args:
        shapes: with meshes or without.
        plane: onto which they are projected.
        resolution: largest distance of the outline from the true one [m].
        edges: those of meshes by the identity of their triangles, which shapes at several places
            share; new ones are added.
    """
    known = {} if edges is None else edges
    parts = []
    for shape in shapes:
        if shape.mesh is None:
            part = projection(shape, plane)
        else:
            vertices, triangles, _ = shape.mesh
            if id(triangles) not in known:
                known[id(triangles)] = Edges.of(triangles, len(vertices))
            corners = to_plane(vertices, plane)
            part = _projection(corners, triangles, known[id(triangles)], 0.7 * resolution)
        if part.is_empty:
            continue
        # A plate seen from its edge has no area, so it gets a width.
        parts.append(part if part.area > resolution**2 else part.buffer(resolution))
    return shapely.union_all(parts).simplify(resolution / 2.0)


def _projection(
    vertices: Array, triangles: NDArray[np.int64], edges: Edges, pixel: float
) -> PlaneShape:
    """The union of triangles (m, 3) between vertices (n, 2) [m].

    It is contoured around the cells [m] whose centres the triangles cover. Along the centre line of
    every row each triangle covers one interval: its edges add one at the start and subtract one at
    the end, so the cumulative sum is the number of triangles over each cell.
    """
    low, high = corners_of_box(vertices)
    pixel = _cell_size(vertices, edges, pixel, high - low)
    width, height = (int(n) + 5 for n in (high - low) / pixel)
    x, y = ((vertices - low) / pixel + 2.0).T
    covered = _covered_cells(x, y, triangles, edges, (width, height))
    columns = low[0] + (np.arange(width) - 2.0) * pixel
    rows = low[1] + (np.arange(height) - 2.0) * pixel
    contours: Any = contourpy.contour_generator(
        columns, rows, covered.astype(float), fill_type=contourpy.FillType.ChunkCombinedOffsetOffset
    )
    (points,), (rings,), (polygons,) = contours.filled(0.5, 2.0)
    if points is None:
        return shapely.MultiPoint(vertices).convex_hull
    areas = shapely.from_ragged_array(shapely.GeometryType.POLYGON, points, (rings, polygons))
    return shapely.union_all(shapely.buffer(areas, 0.0))


def _cell_size(vertices: Array, edges: Edges, pixel: float, extent: Array) -> float:
    """The side of a cell [m], enlarged where a grid would have too many cells or crossings."""
    pixel = max(pixel, float(extent.max()) / LARGEST_GRID)
    climbs = np.abs(vertices[edges.high, 1] - vertices[edges.low, 1])
    crossings = float(climbs.sum()) / pixel
    return pixel * max(1.0, crossings / MOST_CROSSINGS)


def _covered_cells(
    x: Array, y: Array, triangles: NDArray[np.int64], edges: Edges, size: tuple[int, int]
) -> NDArray[np.bool_]:
    """The cells (height, width) whose centres triangles cover.

    Args:
        x: (n,) horizontal coordinates of the vertices in cells.
        y: (n,) vertical ones.
        triangles: (m, 3) of these.
        edges: of the triangles.
        size: width and height of the grid.
    """
    width, height = size
    row = np.ceil(y).astype(np.int64)
    # The contributions of two neighbours to their common edge cancel: only folds and rims remain,
    # few of a fine mesh.
    sides = np.tile(_turns(x, y, triangles), 3) * edges.sense
    change = np.bincount(edges.edge, weights=sides, minlength=len(edges.low))
    change *= np.sign(row[edges.low] - row[edges.high])
    (kept,) = np.nonzero(change)
    start, end, change = edges.low[kept], edges.high[kept], change[kept]

    # The rows that each edge crosses, one after the other, and the column in each.
    first = np.minimum(row[start], row[end])
    count = np.abs(row[end] - row[start])
    slope = (x[end] - x[start]) / (y[end] - y[start])
    before = np.repeat(np.cumsum(count) - count, count)
    rise = np.arange(int(count.sum())) - before
    at_first = x[start] + slope * (first - y[start])
    column = np.ceil(np.repeat(at_first, count) + np.repeat(slope, count) * rise)

    cell = (np.repeat(first, count) + rise) * width + column.astype(np.int64)
    steps = np.bincount(cell, weights=np.repeat(change, count), minlength=width * height)
    return np.asarray(np.cumsum(steps.reshape(height, width), axis=1) > 0.5)


def _turns(x: Array, y: Array, triangles: NDArray[np.int64]) -> Array:
    """The signs (m,) of (b − a) × (c − a): 1 for corners a, b, c in the positive sense."""
    a, b, c = triangles.T
    x_ab, y_ab = x[b] - x[a], y[b] - y[a]
    x_ac, y_ac = x[c] - x[a], y[c] - y[a]
    return np.asarray(np.sign(x_ab * y_ac - x_ac * y_ab))
