"""Requirement on the links of a computed landing to be taken as rigid."""

from typing import TYPE_CHECKING

from shockpc.core.memo import memoized
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.text.errors import RobotError
from shockpc.wings.compliant.links.bending import Bending, bending

if TYPE_CHECKING:
    from shockpc.wings.compliant.over_time.compliant_landing import CompliantLanding


def compliant_of(profile: ShockProfile) -> "CompliantLanding | None":
    """The landing over time; None where the scene gives no stiffness of the contacts."""
    if profile.scene.contact_stiffness is None:
        return None
    from shockpc.wings.compliant.over_time.compliant_landing import compliant_landing

    return compliant_landing(profile.landing)


@memoized()
def rigid_links(profile: ShockProfile) -> Bending | str | None:
    """Requirement on links to be taken as rigid, on the contact stiffness or for the pulse.

    Returns: why that is not known, as a text; None without a stiffness and a pulse.
    """
    landing, k = profile.landing, profile.scene.contact_stiffness
    if k is None and landing.pulse is None:
        return None
    try:
        return bending(landing, profile.value("effective_mass", "contact"), k)
    except RobotError as refusal:
        return str(refusal)
