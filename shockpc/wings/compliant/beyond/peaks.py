"""What is compared of a landing with bodies that bend, and of one with rigid ones."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.landing.places import Place
from shockpc.quantities.of_contacts import IMPULSE
from shockpc.quantities.of_points import point_velocity
from shockpc.quantities.parts.peaks import ALONG
from shockpc.wings.compliant.over_time.compliant_landing import CompliantLanding


class LandingPeaks(NamedTuple):
    """Results of a landing on one contact.

    Attributes:
        jump: change of the velocity of a point until the contact ends [m/s].
        acceleration: its maximum [m/s²].
        force: maximum of the contact [N].
        along: (n,) maxima of the torques or forces along the axes of joints [N m, N].
    """

    jump: float
    acceleration: float
    force: float
    along: Array


def landing_peaks(landing: CompliantLanding, point: Place, joints: Sequence[Place]) -> LandingPeaks:
    """The results of a landing on one contact, at a point and at joints."""
    contacts = landing.landing.places("contact")
    jump = np.linalg.norm(landing.ends(point_velocity, [point])[0, 1, 0])
    acceleration, _ = landing.peaks(point_velocity, [point])
    force, _ = landing.peaks(IMPULSE.compute, contacts)
    along = np.zeros(0)
    if joints:
        along, _ = landing.peaks(ALONG.compute, joints)
    return LandingPeaks(float(jump), float(acceleration[0]), float(force[0]), along)
