"""A landing on contacts of finite stiffness over time, as it is drawn."""

from collections.abc import Sequence

import numpy as np

from shockpc.core.spatial import Array
from shockpc.landing.places import Place
from shockpc.landing.scenes.strike import GRAVITY
from shockpc.quantities.of_points import point_velocity
from shockpc.wings.compliant.links.bent_landing import FlexibleLanding
from shockpc.wings.compliant.over_time.compliant_landing import CompliantLanding

SAMPLES = 400
"""Times at which the largest deflection is sought."""


def contact_forces(compliant: CompliantLanding, times: Array) -> Array:
    """Sizes (nc, T) of the forces of the contacts at times (T,) [N].

    Those of the end stop of a hinge are in N m.
    """
    force = compliant.motion.at(times).force
    numbers = range(len(compliant.landing.contacts))
    sizes = [np.linalg.norm(force[:, compliant.number == c], axis=1) for c in numbers]
    return np.stack(sizes)


def bent_links(compliant: CompliantLanding) -> list[tuple[Array, Array]]:
    """Axes of the links that bend, when they do most: points (k, 3) and deflections [m].

    The points are in world axes; a deflection is the distance from a straight link.

    The points are from the base: where the link begins, its hinges, and where it ends.
    """
    landing = compliant.moving
    if not isinstance(landing, FlexibleLanding):
        return []
    times = np.linspace(0.0, compliant.motion.duration, SAMPLES)
    moved, links = compliant.displacements(times), []
    for body, division in landing.flexible.divisions.items():
        first, *segments = landing.flexible.segments[body]
        # Hinges are in the middle of their parts, so that the link ends half a spacing beyond them.
        half = 0.5 * division.spacing * division.axis
        points = np.vstack([division.places[0] - half, division.places, division.places[-1] + half])
        # A hinge turned by small angles α moves points behind it by α × their arms.
        off = np.zeros((len(moved), *points.shape))
        for segment, place in zip(segments, division.places, strict=True):
            start = landing.robot.joints[segment].v.start
            beyond = np.maximum((points - place) @ division.axis, 0.0)
            arms = np.cross(division.across[:, None], beyond[:, None] * division.axis)
            off += np.einsum("ta,aki->tki", moved[:, start : start + 2], arms)
        R = landing.state.rotation[0, first]
        links.append((landing.state.position[0, first] + points @ R.T, off @ R.T))
    # The time at which the end of some link is farthest from where a straight link has it.
    ends = [np.linalg.norm(off[:, -1], axis=1) for _, off in links]
    most = int(np.argmax(np.max(ends, axis=0)))
    return [(points, off[most]) for points, off in links]


def point_accelerations(
    compliant: CompliantLanding, points: Sequence[Place], times: Array
) -> Array:
    """Sizes (n, T) of the accelerations of points at times (T,) [g]."""
    rates = compliant.history(point_velocity, tuple(points), times)
    return np.asarray(np.linalg.norm(rates, axis=2).T / GRAVITY)
