"""A landing on contacts of finite stiffness over time, as it is drawn."""

from collections.abc import Sequence

import numpy as np

from shockpc.core.spatial import Array
from shockpc.impact.stiffness import CompliantLanding
from shockpc.landing.places import Place
from shockpc.landing.strike import GRAVITY
from shockpc.quantities.of_points import point_velocity


def contact_forces(compliant: CompliantLanding, times: Array) -> Array:
    """Sizes (nc, T) of the forces of the contacts at times (T,) [N; of the end stop of a hinge N m]."""
    force = compliant.motion.at(times).force
    return np.stack([np.linalg.norm(force[:, compliant.number == c], axis=1) for c in range(len(compliant.landing.contacts))])


def point_accelerations(compliant: CompliantLanding, points: Sequence[Place], times: Array) -> Array:
    """Sizes (n, T) of the accelerations of points at times (T,) [g]."""
    rates = compliant.history(point_velocity, tuple(points), times)
    return np.asarray(np.linalg.norm(rates, axis=2).T / GRAVITY)
