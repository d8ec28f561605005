"""Where bodies and points of them are at the moment of the impact."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.exact.balls import balls, nearest
from shockpc.exact.proof import Proof
from shockpc.exact.solution import ExactImpact
from shockpc.landing import Landing

__all__ = ["Placement", "placement", "world"]


class Placement(NamedTuple):
    """The frames of the bodies; index i of every array is body i.

    Attributes:
        position: (nb, 3) origins, world [m].
        rotation: (nb, 3, 3) body to world.
    """

    position: Array
    rotation: Array


def placement(landing: Landing, proof: Proof) -> Placement:
    """The frames of all bodies."""
    bodies = range(len(landing.robot.bodies))
    zero = np.zeros((len(bodies), 3))
    return proof.enclosure.read(lambda impact: Placement(world(impact, landing, bodies, zero), nearest(impact.orientations, 1.0)))


def world(impact: ExactImpact, landing: Landing, bodies: Sequence[int], r: Array) -> Array:
    """Positions (n, 3) of points of bodies, world [m]. Args: r (n, 3) in the bodies' frames [m]; the others as elsewhere.

    Raises:
        PrecisionError: a ball is too wide.
    """
    origin, points = landing.state.origin[0], impact.points(bodies, r)
    size = np.abs(origin).max(initial=0.0) + np.abs(landing.state.position[0]).max(initial=0.0) + np.abs(r).max(initial=0.0)
    return nearest(points + balls(origin), size)
