"""Forces and accelerations of a landing on contacts of finite stiffness over time."""

from collections.abc import Sequence

import numpy as np

from shockpc.core.spatial import Array
from shockpc.landing.places import Place
from shockpc.landing.scenes.strike import GRAVITY
from shockpc.quantities.of_points import point_velocity
from shockpc.wings.compliant.over_time.compliant_landing import CompliantLanding


def contact_forces(compliant: CompliantLanding, times: Array) -> Array:
    """Sizes (nc, T) of the forces of the contacts at times (T,) [N].

    Those of the end stop of a hinge are in N m.
    """
    force = compliant.motion.at(times).force
    numbers = range(len(compliant.landing.contacts))
    sizes = [np.linalg.norm(force[:, compliant.number == c], axis=1) for c in numbers]
    return np.stack(sizes)


def point_accelerations(
    compliant: CompliantLanding, points: Sequence[Place], times: Array
) -> Array:
    """Sizes (n, T) of the accelerations of points at times (T,) [g]."""
    rates = compliant.history(point_velocity, tuple(points), times)
    return np.asarray(np.linalg.norm(rates, axis=2).T / GRAVITY)


def moving_points(places: Sequence[Place]) -> list[Place]:
    """The points that are on a body."""
    return [place for place in places if place.body >= 0]
