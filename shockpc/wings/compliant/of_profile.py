"""On which contacts a landing loses a margin, and on which its links can be taken as rigid."""

import math
from typing import TYPE_CHECKING

from shockpc.core.memo import memoized
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.text.errors import RobotError
from shockpc.wings.compliant.bending import Bending, bending

if TYPE_CHECKING:
    from shockpc.wings.compliant.course import CompliantLanding
    from shockpc.wings.compliant.margin_lost import MarginLost


def compliant_of(profile: ShockProfile) -> "CompliantLanding | None":
    """The landing over time; None where the scene gives no stiffness of the contacts."""
    if profile.scene.contact_stiffness is None:
        return None
    from shockpc.wings.compliant.course import compliant_landing

    return compliant_landing(profile.landing)


@memoized()
def lost_margin(profile: ShockProfile) -> "MarginLost | None":
    """The contact stiffness from which on a margin is lost; None without parts, or without limits
    and a contact stiffness.
    """
    if profile.landing.parts or profile.scene.yields:
        from shockpc.wings.compliant.margin_lost import margin_lost

        return margin_lost(profile.landing)
    return None


@memoized()
def rigid_links(profile: ShockProfile) -> Bending | str | None:
    """When links can be taken as rigid, on the contact stiffness, for the pulse, or where a margin
    of a part is lost.

    Returns: why that is not known, as a text; None where it makes no difference.
    """
    landing, k = profile.landing, profile.scene.contact_stiffness
    if k is None and landing.pulse is None:
        if not landing.parts:
            return None
        lost = lost_margin(profile)
        if lost is None or not 0.0 < lost.contact_stiffness < math.inf:
            return None
        k = lost.contact_stiffness
    try:
        return bending(landing, profile.value("effective_mass", "contact"), k)
    except RobotError as refusal:
        return str(refusal)
