"""Panels of a page with a landing over time."""

from typing import Any

import numpy as np

from shockpc.quantities.shock_profile import ShockProfile
from shockpc.show.html.charts import history
from shockpc.wings.compliant.over_time.compliant_landing import CompliantLanding
from shockpc.wings.compliant.show.histories import (
    contact_forces,
    moving_points,
    point_accelerations,
)

SAMPLES = 400
"""Times of a curve."""


def force_and_acceleration(
    profile: ShockProfile, compliant: CompliantLanding
) -> list[dict[str, Any]]:
    """Forces of the contacts, and accelerations of the points that move, over time."""
    times = np.linspace(0.0, compliant.motion.duration, SAMPLES)
    contacts = profile.places("contact")[: len(profile.contacts)]
    forces = zip((place.name for place in contacts), contact_forces(compliant, times), strict=True)
    panels = [history("force of a contact [N]", times, forces)]
    points = moving_points(profile.landing.points)
    if points:
        accelerations = point_accelerations(compliant, points, times)
        named = zip((place.name for place in points), accelerations, strict=True)
        panels.append(history("acceleration of a point [g]", times, named))
    return panels
