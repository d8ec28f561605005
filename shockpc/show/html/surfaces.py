"""Surfaces of a robot's bodies with as many triangles as a screen shows.

Vertices are merged in the cells of a grid, which keeps closed surfaces closed, at the point nearest
to the planes of their triangles (Lindstrom 2000, "Out-of-core simplification of large polygonal
models"). Long edges are divided, because shock is not linear between the corners of a large
triangle.
"""

from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array, corners_of_box, cross
from shockpc.robot.shapes.convex import Shape, facets

FINEST, LONGEST = 1 / 2000, 1 / 30
"""Smallest cell of the grid, and longest edge of a triangle, as shares of the robot's size."""

MOST_DIVIDED = 8
"""Largest number of triangles while edges are divided, relative to that in the end."""

FLAT = 1e-2
"""Share of the largest curvature of a sum of squares below which a direction counts as flat.

There a vertex stays at the mean.
"""


SAMPLED = 4000
"""Triangles of a body, about, by which the number of those that remain is estimated."""


class Surface(NamedTuple):
    """Triangles.

    Attributes:
        vertices: (n, 3) [m].
        triangles: (m, 3) indices into the vertices.
    """

    vertices: Array
    triangles: np.ndarray


def surfaces(bodies: Sequence[Sequence[Shape]], most: int) -> list[Surface]:
    """The surface of each body, in its frame.

    Args:
        bodies: the shapes of each body.
        most: number of triangles of all bodies together, about; `MOST_DIVIDED` times as many while
            edges are divided.
    """
    meshes = [_joined(map(_triangles, shapes)) for shapes in bodies]
    size = max(map(_extent, meshes), default=0.0) or 1.0

    # Merged once before edges are divided, so that few are, and once after.
    cell = _coarser(meshes, FINEST * size, most)
    meshes = [_clustered(mesh, cell) for mesh in meshes]
    left = MOST_DIVIDED * most
    for k, mesh in enumerate(meshes):
        meshes[k] = _divided(mesh, LONGEST * size, left)
        left -= len(meshes[k].triangles)
    cell = _coarser(meshes, cell, most)
    return [_clustered(mesh, cell) for mesh in meshes]


def _extent(surface: Surface) -> float:
    """The longest side of the box around a surface [m]; zero without vertices."""
    if not len(surface.vertices):
        return 0.0
    return float(np.ptp(corners_of_box(surface.vertices), axis=0).max())


def _triangles(shape: Shape) -> Surface:
    """The surface of a shape."""
    if shape.mesh is not None:
        return Surface(shape.mesh.vertices, shape.mesh.triangles)
    corners = [np.zeros((0, 3))]
    for facet in facets(shape):
        if len(facet) > 3:  # a flat shape, whose corners are in no order
            off = facet - facet.mean(axis=0)
            _, _, axes = np.linalg.svd(off)
            x, y = axes[:2] @ off.T
            facet = facet[np.argsort(np.arctan2(y, x))]
        corners += [facet[[0, k, k + 1]] for k in range(1, len(facet) - 1)]
    vertices, index = np.unique(np.concatenate(corners), axis=0, return_inverse=True)
    return Surface(vertices, index.reshape(-1, 3))


def _joined(parts: Iterable[Surface]) -> Surface:
    vertices, triangles, count = [np.zeros((0, 3))], [np.zeros((0, 3), dtype=np.int64)], 0
    for part in parts:
        vertices.append(part.vertices)
        triangles.append(part.triangles + count)
        count += len(part.vertices)
    return Surface(np.concatenate(vertices), np.concatenate(triangles))


def _cells(surface: Surface, cell: float) -> np.ndarray:
    """The number (n,) of the cell of each vertex.

    It is the same for all if the cell is larger than the surface.
    """
    low = corners_of_box(surface.vertices)[0] if len(surface.vertices) else np.inf
    return _numbers(((surface.vertices - low) / cell).astype(np.int64))


def _numbers(cells: np.ndarray) -> np.ndarray:
    """The numbers (...) of cells by their indices (..., 3) along the axes."""
    return np.asarray((cells[..., 0] << 42) + (cells[..., 1] << 21) + cells[..., 2])


def _coarser(meshes: Sequence[Surface], cell: float, most: int) -> float:
    """The cell, or a larger one in which at most so many triangles remain."""
    every = [1 + len(mesh.triangles) // SAMPLED for mesh in meshes]
    samples = [mesh.vertices[mesh.triangles[::n]] for mesh, n in zip(meshes, every, strict=True)]

    def estimate(cell: float) -> int:
        """The number of triangles between three cells, estimated from some triangles.

        Several triangles between the same cells may become one.
        """
        left = 0
        for n, corners in zip(every, samples, strict=True):
            a, b, c = _numbers(np.floor(corners / cell).astype(np.int64)).T
            different = (a != b) & (b != c) & (c != a)
            left += n * int(different.sum())
        return left

    def count(cell: float) -> int:
        return sum(_count(mesh, cell) for mesh in meshes)

    estimated = _enlarged(cell, estimate, most)
    # Where many triangles become one, the estimate is far too high.
    return _enlarged(estimated if count(estimated) > most / 2 else cell, count, most)


def _enlarged(cell: float, count: Callable[[float], int], most: int) -> float:
    """The cell, enlarged until at most so many triangles are counted."""
    while (left := count(cell)) > most:
        cell *= min(max(1.1, (left / most) ** 0.5), 1.5)
    return cell


def _count(surface: Surface, cell: float) -> int:
    """Number of triangles that remain where the vertices of each cell are merged."""
    low, middle, high = np.sort(_cells(surface, cell)[surface.triangles], axis=1).T
    different = (low != middle) & (middle != high)
    # Two of them have the same product by chance once in 2^64 / n² times, which changes nothing but
    # the count.
    products = (low * _ODD + middle) * _ODD + high
    return len(np.unique(products[different]))


_ODD = np.int64(0x5851F42D4C957F2D)
"""A factor that spreads numbers over 64 bits, Knuth's of MMIX."""


def _clustered(surface: Surface, cell: float) -> Surface:
    """The surface with the vertices of each cell merged, without the triangles that vanish.

    The merged vertex is the point nearest to the planes of all triangles at the cell, which keeps
    flat faces and their edges.
    """
    _, index = np.unique(_cells(surface, cell), return_inverse=True)
    count = int(index.max(initial=-1)) + 1
    means = _sums(index, surface.vertices.T, count) / np.bincount(index)[:, None]
    merged = means + _towards_planes(surface, index, means, cell)

    # Triangles between three different cells, each once.
    triangles = index[surface.triangles]
    a, b, c = triangles.T
    triangles = triangles[(a != b) & (b != c) & (c != a)]
    low, middle, high = np.sort(triangles, axis=1).T
    _, first = np.unique((low * count + middle) * count + high, return_index=True)
    triangles = triangles[first]
    used = np.zeros(count, dtype=bool)
    used[triangles] = True
    return Surface(merged[used], (np.cumsum(used) - 1)[triangles])


def _sums(index: np.ndarray, columns: Iterable[Array], count: int) -> Array:
    """Sums (count, k) of k columns (n,) over the entries of each index."""
    return np.stack([np.bincount(index, column, count) for column in columns], axis=1, dtype=float)


def _towards_planes(surface: Surface, index: np.ndarray, means: Array, cell: float) -> Array:
    """The way (count, 3) from the mean of each cell to the point nearest to its planes [m].

    The planes are those of the triangles at the cell; the way is at most a cell along each axis.
    Σ n nᵀ x = Σ n h over the corners of triangles at the cell, h the height of the plane over the
    mean, n of the length of twice the area; a ridge keeps x at zero along directions in which it is
    flat.

    Args:
        surface: the surface.
        index: (n,) cell of each vertex.
        means: (count, 3) of the vertices of each cell.
        cell: its side [m].
    """
    count = len(means)
    corners = surface.vertices[surface.triangles]
    triangles = index[surface.triangles]
    first, second, third = corners[:, 0], corners[:, 1], corners[:, 2]
    normals = cross(second - first, third - first)
    height = np.einsum("ti,tki->tk", normals, corners - means[triangles]).ravel()
    # Of each corner of each triangle, contiguous, so that the sums are fast.
    cells = triangles.ravel()
    x, y, z = np.repeat(normals.T, 3, axis=1)
    b = _sums(cells, (x * height, y * height, z * height), count)
    products = _sums(cells, (x * x, x * y, x * z, y * y, y * z, z * z), count)
    A = products[:, [0, 1, 2, 1, 3, 4, 2, 4, 5]].reshape(-1, 3, 3)
    trace = np.trace(A, axis1=1, axis2=2)[:, None, None]
    ridge = np.where(trace > 0.0, FLAT * trace, 1.0)
    ways = np.linalg.solve(A + ridge * np.eye(3), b[..., None])[..., 0]
    return np.asarray(np.clip(ways, -cell, cell))


def _divided(surface: Surface, longest: float, most: int) -> Surface:
    """The surface with edges halved until none is longer than a limit [m].

    Both triangles at an edge are divided there. Edges stay longer where there would be more
    triangles: a round makes at most four of one.
    """
    vertices, triangles = surface
    short: list[np.ndarray] = []
    count = 0
    while len(triangles) and count + 4 * len(triangles) <= most:
        # Sides of triangles (m, 3), from a corner to the next, and those that are too long.
        start, end = triangles, np.roll(triangles, -1, axis=1)
        divide = np.linalg.norm(vertices[start] - vertices[end], axis=2) > longest
        number = divide.sum(axis=1)
        short.append(triangles[number == 0])
        count += len(short[-1])

        # A vertex in the middle of each of these edges, which two triangles share.
        low = np.minimum(start, end)[divide]
        high = np.maximum(start, end)[divide]
        edges, index = np.unique(low * len(vertices) + high, return_inverse=True)
        low, high = np.divmod(edges, len(vertices))
        middle = np.zeros_like(triangles)
        middle[divide] = len(vertices) + index
        vertices = np.concatenate([vertices, (vertices[low] + vertices[high]) / 2.0])
        long = number > 0
        triangles = _parts_of(triangles[long], middle[long], divide[long], number[long])
    return Surface(vertices, np.concatenate([*short, triangles]))


def _parts_of(
    triangles: np.ndarray, middle: np.ndarray, divide: np.ndarray, number: np.ndarray
) -> np.ndarray:
    """The parts of triangles (m, 3) of which `number` (m,) edges are divided.

    Args:
        triangles: their corners.
        middle: (m, 3) the vertex in the middle of the edge behind each corner.
        divide: (m, 3) whether that edge is divided.
        number: how many are, from one to three.
    """
    # Corners in an order in which the edges to divide come first.
    first = np.where(number == 1, divide.argmax(axis=1), (divide.argmin(axis=1) + 1) % 3)
    order = (first[:, None] + np.arange(3)) % 3
    ordered = [np.take_along_axis(part, order, axis=1) for part in (triangles, middle)]
    corners = np.concatenate(ordered, axis=1)
    parts = []
    for n, of_corners in _PARTS.items():
        parts.append(corners[number == n][:, of_corners].reshape(-1, 3))
    return np.concatenate(parts)


_PARTS = {
    1: [[0, 3, 2], [3, 1, 2]],
    2: [[3, 1, 4], [0, 3, 4], [0, 4, 2]],
    3: [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]],
}
"""The parts of a triangle with corners 0, 1, 2 by the number of its edges that are divided.

They are divided at 3 (of 0 and 1), 4 and 5.
"""
