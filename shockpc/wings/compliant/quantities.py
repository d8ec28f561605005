"""Quantities of contacts of finite stiffness, and of links that can be taken as rigid.

They are in double precision, without a proof.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from shockpc.core.spatial import Array
from shockpc.impact.impact import Impact
from shockpc.landing.landing import PosedLanding
from shockpc.landing.places import PlaceKind
from shockpc.landing.scenes.strike import GRAVITY
from shockpc.quantities.of_contacts import CONTACTS
from shockpc.quantities.parts.peaks import contact_peaks, joint_peaks, point_peaks
from shockpc.quantities.quantity import (
    IN_DOUBLES,
    Places,
    Quantity,
    Scope,
    once_per_impact,
    quantity_values,
)
from shockpc.quantities.with_friction import OF_THE_IMPACT, where_given
from shockpc.wings.compliant.links.bending import FOR_JUMPS, FOR_TORQUES, Bending, rigid_links

if TYPE_CHECKING:
    from shockpc.wings.compliant.over_time.compliant_landing import CompliantLanding

(EFFECTIVE_MASS,) = (entry for entry in CONTACTS if entry.key == "effective_mass")

UNKNOWN = "the scene gives neither a contact stiffness nor a pulse, or its links bend already"

JUMPS = tuple(entry for entry in OF_THE_IMPACT if "stiffness" in entry.relations.also)
"""Quantities of the jumps only, which a landing on finite stiffness has at each time."""


def _solved(landing: PosedLanding) -> "CompliantLanding":
    """The landing over time; what solves it is imported where a scene gives a stiffness."""
    from shockpc.wings.compliant.over_time.compliant_landing import compliant_landing

    return compliant_landing(landing)


def _stiff(
    key: str,
    of: PlaceKind,
    title: str,
    unit: str,
    read: "Callable[[CompliantLanding, Places], Array]",
    missing: str = "",
) -> Quantity:
    """A quantity of a landing on contacts of finite stiffness; read gives its values (n,)."""
    entry = Quantity(
        key, of, title, unit, "neither" if unit == "s" else "greater", read, scope=Scope(missing)
    )
    return where_given(
        entry,
        "contact_stiffness",
        _solved,
        lambda compliant, _, places: read(compliant, places)[None, None],
    )


def _after(entry: Quantity, when: str, title: str, end: int) -> Quantity:
    """A quantity of the jumps from the impact until one of the ends of a landing.

    The landing is one on contacts of finite stiffness.
    """
    compute = once_per_impact(entry.compute)
    named = entry._replace(key=f"{entry.key}_{when}", title=f"{entry.title}, {title}")
    return where_given(
        named,
        "contact_stiffness",
        _solved,
        lambda compliant, _, places: compliant.ends(compute, places)[:, end : end + 1],
    )


def _of_contacts(values: Array, places: Places) -> Array:
    """Values (n,) of contacts, and none of standing feet. Args: values (c,) of all contacts."""
    numbers = np.array([place.number for place in places], dtype=int)
    of_contacts = np.full(len(places), np.nan)
    of_contacts[numbers < len(values)] = values[numbers[numbers < len(values)]]
    return of_contacts


PEAK_TORQUE = _stiff(
    "peak_torque",
    "joint",
    "peak torque along the joint's axis",
    "N m, N",
    lambda compliant, places: joint_peaks(compliant, places)[2],
    "the joint has more than one axis, or a spring before a rotor of unknown inertia",
)

ON_FINITE_STIFFNESS = (
    _stiff(
        "peak_acceleration",
        "point",
        "peak acceleration on contacts of finite stiffness",
        "g",
        lambda compliant, places: point_peaks(compliant, places)[0] / GRAVITY,
    ),
    _stiff(
        "peak_acceleration_time",
        "point",
        "time of the peak acceleration",
        "s",
        lambda compliant, places: point_peaks(compliant, places)[1],
    ),
    _stiff(
        "duration",
        "contact",
        "duration of 99 % of the normal impulse",
        "s",
        lambda compliant, places: _of_contacts(compliant.duration, places),
    ),
    _stiff(
        "peak_force",
        "contact",
        "peak force",
        "N",
        lambda compliant, places: contact_peaks(compliant, places)[0],
    ),
    _stiff(
        "peak_force_time",
        "contact",
        "time of the peak force",
        "s",
        lambda compliant, places: contact_peaks(compliant, places)[1],
    ),
    _stiff(
        "peak_joint_force",
        "joint",
        "peak force through the joint",
        "N",
        lambda compliant, places: joint_peaks(compliant, places)[0],
    ),
    _stiff(
        "peak_joint_moment",
        "joint",
        "peak moment through the joint",
        "N m",
        lambda compliant, places: joint_peaks(compliant, places)[1],
    ),
    PEAK_TORQUE,
    _stiff(
        "peak_stop",
        "joint",
        "peak torque of the joint's end stop",
        "N m, N",
        lambda compliant, places: np.array(
            [compliant.stop_peaks.get(place.name, 0.0) for place in places]
        ),
    ),
    _stiff(
        "restitution",
        "contact",
        "restitution, with the contact's damping",
        "1",
        lambda compliant, places: _of_contacts(compliant.restitution, places),
    ),
    _stiff(
        "stiffness_difference",
        "robot",
        "difference from the impulse model",
        "1",
        lambda compliant, places: np.array([compliant.difference]),
    ),
    _stiff(
        "compression",
        "robot",
        "time at which the contacts are compressed",
        "s",
        lambda compliant, places: np.array([compliant.compressed]),
    ),
    *(_after(entry, "compressed", "at the end of compression", 0) for entry in JUMPS),
    *(_after(entry, "separated", "at the end of contact", 1) for entry in JUMPS),
)


def _bending(impact: Impact, _: Places) -> Array:
    """The numbers of `BENDING` (1, 1, 5); NaN where there are none."""
    landing, places = impact.landing, impact.landing.places("contact")
    links = rigid_links(landing, lambda: quantity_values(EFFECTIVE_MASS, impact, places)[0, 0])
    if not isinstance(links, Bending):
        return np.full((1, 1, 5), np.nan)
    lowest = [links.lowest(product) for product in (FOR_JUMPS, FOR_TORQUES)]
    return np.array([[[*lowest, *map(links.modes.stiffness, lowest), links.modes.metal]]])


def _of_bending(k: int, key: str, title: str, unit: str) -> Quantity:
    """The number k of `_bending`."""
    return Quantity(
        key,
        "robot",
        title,
        unit,
        "neither",
        lambda impact, places: _bending(impact, places)[..., k : k + 1],
        scope=Scope(UNKNOWN),
        computation=IN_DOUBLES,
    )


RIGID = "are those of rigid links, by a force without steps"
MODE, EI = "first bending mode of the leg", "EI of the links of the leg"
METAL = f"{MODE} if its links were bars or tubes of metal with their inertias"

BENDING = (
    _of_bending(0, "lowest_bending_for_jumps", f"{MODE} above which jumps {RIGID}", "Hz"),
    _of_bending(1, "lowest_bending_for_torques", f"{MODE} above which torques {RIGID}", "Hz"),
    _of_bending(2, "bending_stiffness_for_jumps", f"{EI} above which jumps {RIGID}", "N m²"),
    _of_bending(3, "bending_stiffness_for_torques", f"{EI} above which torques {RIGID}", "N m²"),
    _of_bending(4, "bending_of_metal", METAL, "Hz"),
)
"""Quantities that the first bending mode of the links between contacts and base has to reach."""

QUANTITIES = (*ON_FINITE_STIFFNESS, *BENDING)
"""All of these."""
