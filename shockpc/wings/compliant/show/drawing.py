"""Drawing of links that bend, in the figure in the plane."""

import numpy as np

from shockpc.core.spatial import Array
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.show.figure.silhouette import to_plane
from shockpc.wings.compliant.over_time.compliant_landing import CompliantLanding
from shockpc.wings.compliant.show.histories import bent_links

BENT = 0.2
"""Largest deflection of a link that bends as it is drawn, as a share of its length, about."""

SLIGHT = 0.05
"""Share of the largest deflection up to which that of a link is not drawn."""


def bent_axes(profile: ShockProfile, compliant: CompliantLanding) -> tuple[list[Array], str]:
    """The axes (k, 2) of links that bend, in the plane, and a note of how they are drawn."""
    links, origin = bent_links(compliant), profile.landing.state.origin[0]
    shares = []
    for points, deflection in links:
        length = np.linalg.norm(points[-1] - points[0])
        shares.append(float(np.linalg.norm(deflection, axis=1).max() / length))
    factor = 1.0
    if max(shares) > 0.0:
        factor = float(f"{BENT / max(shares):.0e}")
    axes = []
    for (points, deflection), share in zip(links, shares, strict=True):
        if share > SLIGHT * max(shares):
            axes.append(to_plane(origin + points + factor * deflection, profile.plane))
    note = (
        f"dashed: the axes of links that bend, when they bend most; deflections {factor:g} times "
        f"as large."
    )
    return axes, note
