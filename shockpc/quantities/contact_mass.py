"""The mass that all contacts of a landing stop together."""

import math

from shockpc.core.memo import memoized
from shockpc.core.spatial import Array
from shockpc.impact.companions import frictionless
from shockpc.impact.landed import solution_in_doubles
from shockpc.landing.landing import PosedLanding
from shockpc.method.constraints import slices_of


def mass_of_contacts(landing: PosedLanding, impulse: Array) -> float:
    """The effective mass of all contacts together along the ground's normal [kg].

    It is the impulse of the ground for an approach of 1 m/s along the normal, without rebound. NaN
    if the contacts differ in normal or restitution.

    Args:
        landing: the landing.
        impulse: (nc, 3 or 4) impulses along all rows, whose first columns are those for 1 m/s along
            world x, y and z [N s].
    """
    contacts = landing.contacts
    ends = {(contact.kind, contact.restitution, *contact.normal.tolist()) for contact in contacts}
    if len(ends) > 1 or contacts[0].kind == "stop":
        return math.nan
    # For a strike of 1 m/s against the normal n: m = Σ n · ι / (1 + e).
    along = impulse[:, :3] @ -landing.up
    pushed = 0.0
    for contact, rows in zip(contacts, slices_of(contacts), strict=True):
        rising = contact.forces @ landing.up
        pushed += float(rising @ along[rows][: len(rising)])
    return pushed / (1.0 + contacts[0].restitution)


@memoized()
def normal_mass(landing: PosedLanding) -> float:
    """The effective mass of all contacts together if none has friction (Khatib) [kg].

    It is NaN as `mass_of_contacts`.
    """
    companion = frictionless(landing)
    return mass_of_contacts(companion, solution_in_doubles(companion).impulse[0])
