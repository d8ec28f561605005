"""The landing of a profile over time, and how stiff its links have to be to count as rigid."""

from typing import TYPE_CHECKING

from shockpc.core.memo import memoized
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.wings.compliant.landing import landing_motion
from shockpc.wings.compliant.links.bending import Bending, rigid_links

if TYPE_CHECKING:
    from shockpc.wings.compliant.over_time.compliant_landing import CompliantLanding


def compliant_of(profile: ShockProfile) -> "CompliantLanding | None":
    """The landing over time; None where the scene gives no stiffness of the contacts."""
    return landing_motion(profile.landing, None)


@memoized()
def rigid_links_of(profile: ShockProfile) -> Bending | str | None:
    """Requirement on links to be taken as rigid, as of `rigid_links`."""
    return rigid_links(profile.landing, lambda: profile.value("effective_mass", "contact"))
