"""The most and the least severe strike for a point: singular values of its 3 × 3 map from strike to shock."""

from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array


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
        maps: (..., 3, 3) jump of a point's velocity for unit strikes along x, y and z; where it is not finite, the result is NaN.
        up: (3,) unit normal of the ground; of a direction and its opposite the one that approaches the ground is given.
    """
    lost = np.asarray(~np.isfinite(maps).all(axis=(-1, -2)))
    _, s, Vt = np.linalg.svd(np.where(lost[..., None, None], 0.0, maps))
    s[lost], Vt[lost] = np.nan, np.nan
    most_severe, least_severe = Vt[..., 0, :], Vt[..., 2, :]

    return ExtremeDirections(_downwards(most_severe, up), s[..., 0], _downwards(least_severe, up), s[..., 2])


def _downwards(direction: Array, up: Array) -> Array:
    """Of a direction and its opposite, the one that approaches the ground."""
    leaving = direction @ up > 0.0
    return np.asarray(np.where(leaving[..., None], -direction, direction) + 0.0)
