"""Warnings of this wing."""

from collections.abc import Callable, Iterable, Iterator

import numpy as np

from shockpc.quantities.shock_profile import ShockProfile
from shockpc.text.diagnostic import Diagnostic
from shockpc.wings.compliant.links.bending import BENDS, Bending, bends, rings
from shockpc.wings.compliant.of_profile import compliant_of, rigid_links_of

DIFFERS, LEAST_DIFFERENCE = 0.1, 1e-3
"""Relative difference of shock from which a warning says so, and least difference of one [1].

The shock is that on contacts of finite stiffness, against that of the impulse model.
"""


def _beyond_the_impulse(profile: ShockProfile) -> Iterator[Diagnostic]:
    """Warnings where a finite stiffness makes another result than the impulse model."""
    compliant = compliant_of(profile)
    if compliant is None:
        return
    from shockpc.wings.compliant.over_time.warnings import warnings_of

    places = [*profile.bracketed, *profile.landing.mounted]
    impulse = profile.value("shock", "point", places)
    finite = profile.value("shock_separated", "point", places)
    differs = np.abs(finite - impulse)
    clearly = (differs > DIFFERS * np.minimum(impulse, finite)) & (differs > LEAST_DIFFERENCE)
    rigid = " with rigid links" if profile.scene.flex else ""
    texts = set[str]()
    for k in np.flatnonzero(clearly).tolist():
        name = places[k].name
        text = (
            f"shock at {name} is {finite[k]:.3g} at the end of contact on "
            f"{profile.scene.contact_stiffness:g} N/m, but {impulse[k]:.3g} in the other tables, "
            f"which are of the impulse model{rigid}: the impulse model does not hold there"
        )
        if text not in texts:  # a part may be at a sensor
            yield Diagnostic("contact", name, float(differs[k]), text)
        texts.add(text)
    yield from warnings_of(compliant)


def _bending(profile: ShockProfile) -> Iterator[Diagnostic]:
    """A warning where not even links of metal are stiff enough to be taken as rigid."""
    links = rigid_links_of(profile)
    if isinstance(links, Bending):
        yield from bends(links)


CHECKS: tuple[Callable[[ShockProfile], Iterable[Diagnostic]], ...] = (
    _beyond_the_impulse,
    _bending,
    lambda profile: rings(profile.landing),
)

SHARED = {BENDS: _bending}
"""Checks whose worst warning studies of many landings show, by its kind and subject."""
