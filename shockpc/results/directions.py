"""The most and the least severe impact direction of a place: singular values of its map from strike to shock."""

import numpy as np

from shockpc.core.directions import ExtremeDirections, extreme_directions
from shockpc.core.spatial import Array
from shockpc.exact.balls import Balls, balls, nearest
from shockpc.exact.proof import Enclosure
from shockpc.exact.solution import ExactImpact

__all__ = ["directions_at"]


def directions_at(enclosure: Enclosure, bodies: list[int], r: Array, up: Array) -> ExtremeDirections:
    """The extreme directions of points of bodies; arrays over the points. The shocks are right to 1e-15 of the largest.

    Args:
        enclosure: of the landing.
        bodies: index of the body of each point.
        r: (n, 3) the points in their bodies' frames [m].
        up: (3,) unit normal of the ground, world axes.
    """

    def maps(impact: ExactImpact) -> Array:
        found = _map_in(impact, bodies, r)
        size = np.abs(np.array([[float(x) for x in one.ravel()] for one in found])).max(axis=1, initial=0.0)
        return nearest(found, size[:, None, None] + 1e-300)

    return extreme_directions(enclosure.read(maps), up)


def _map_in(impact: ExactImpact, bodies: list[int], r: Array) -> Balls:
    """The maps (n, 3, 3) of points, in balls."""
    jumps, (x, y, z) = impact.body_jumps[bodies][:, :, :3], balls(r).T[..., None]
    a, b, c = (jumps[:, i] for i in range(3))
    return np.stack([jumps[:, 3] + b * z - c * y, jumps[:, 4] + c * x - a * z, jumps[:, 5] + a * y - b * x], axis=1)
