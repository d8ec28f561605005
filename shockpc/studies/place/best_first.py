"""The best places in a region that need not be convex: best-first search over convex cells.

Every cell has a lower bound: first that of a tangent, then that of its cone program. The cell with
the lowest bound comes first, so that the optimum of the first solved cell is the optimum of the
region. Where a place is not allowed, because it lies inside another shape of the body or too near
to a place found before, its cell is divided along the faces of that convex set; what remains
outside is convex again. A surface of a hundred thousand triangles needs a few dozen programs.
"""

import heapq
import itertools
from collections.abc import Iterator, Sequence

import numpy as np

from shockpc.core.spatial import Array
from shockpc.robot.shapes.convex import HalfSpaces
from shockpc.studies.place.cone import ConvexCell, Optimum, least_shock
from shockpc.studies.place.field import Fields

INSIDE = 1e-7
"""Depth inside a set above which a place is not allowed [m].

Cone programs leave their half-spaces by less.
"""


def box_faces(low: Array, high: Array) -> HalfSpaces:
    """An axis-parallel box by two opposite corners (3,) [m]."""
    return HalfSpaces(np.concatenate([np.eye(3), -np.eye(3)]), np.concatenate([high, -low]))


def best_places(
    fields: Fields,
    cells: Sequence[ConvexCell],
    outside: Sequence[HalfSpaces] = (),
    apart: float = 0.0,
) -> Iterator[Optimum]:
    """The best place of a region, then the next best ones.

    Each has the proof that no other place is better.

    Args:
        fields: shock over the body.
        cells: convex sets that make up the region together.
        outside: convex sets whose inside does not belong to the region.
        apart: distance along at least one axis of the body's frame that each place keeps from those
            before [m].

    Returns: places in the order of what they are compared by. The bound of each is that of the
        region without what is near to the places before.
    """
    forbidden = list(outside)
    # The cell with the lowest bound is the first one; its optimum is None until it is solved.
    number = itertools.count()
    queue: list[tuple[float, int, ConvexCell, Optimum | None]] = []
    for bound, cell in zip(first_bounds(fields, cells), cells, strict=True):
        heapq.heappush(queue, (bound, next(number), cell, None))
    while queue:
        bound, _, cell, optimum = heapq.heappop(queue)
        if optimum is None:
            optimum = least_shock(fields, cell)
            if optimum is not None:
                heapq.heappush(queue, (max(bound, optimum.bound), next(number), cell, optimum))
            continue
        around = next((hull for hull in forbidden if hull.depth(optimum.point) > INSIDE), None)
        if around is not None:
            # What of the cell is outside a face of the set, for each face.
            for normal, offset in zip(around.normals, around.offsets, strict=True):
                part = cell.within(normal, offset)
                if part is not None:
                    heapq.heappush(queue, (bound, next(number), part, None))
            continue
        yield Optimum(optimum.point, optimum.value, bound)
        forbidden.append(box_faces(optimum.point - apart, optimum.point + apart))
        heapq.heappush(queue, (bound, next(number), cell, optimum))


def first_bounds(fields: Fields, cells: Sequence[ConvexCell]) -> list[float]:
    """A lower bound over each cell: that of the tangent at the middle of its points."""
    if not cells:
        return []
    counts = np.array([len(cell.points) for cell in cells])
    start = np.cumsum(counts) - counts
    points = np.concatenate([cell.points for cell in cells])
    middles = np.add.reduceat(points, start) / counts[:, None]
    values, slopes = fields.tangents(middles)
    # value + min_points slope · (point − middle) − |slope · rounding|
    from_middle = points - np.repeat(middles, counts, axis=0)
    steps = np.sum(from_middle * np.repeat(slopes, counts, axis=0), axis=1)
    rounding = np.array([cell.rounding for cell in cells])
    reach = np.linalg.norm(np.einsum("ni,nij->nj", slopes, rounding), axis=1)
    bounds = values + np.minimum.reduceat(steps, start) - reach
    return [float(bound) for bound in np.maximum(bounds, 0.0)]
