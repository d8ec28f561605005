"""The first bending mode of the links between a contact and the base.

It is what it would be with links of a bending stiffness.

Frequencies are those of the free robot, its joints as in the impact: a rotor behind a gear ties
links together, so that a leg with drives swings far slower than one without. They follow from
masses and geometry alone, f = α √EI for links of one EI.

Of a straight bar of one metal the moment of inertia about its axis and its bending stiffness both
come from the second moments of its section: J = ρ (I₁ + I₂) L and, of the mean of both planes, EI =
(E/ρ) J / 2L, whatever the section is, solid or a tube. E/ρ is 26e6 m²/s² of steel, aluminium,
titanium and magnesium alike. A link of which all is such a bar, with no motor, bearing or cover in
its inertia, is as stiff as its inertia lets metal be. Frequencies grow with √(E/ρ): a tube of
carbon fibre has 31e6 m²/s² with fibres in all directions, and up to 75e6 with fibres along it.
"""

import math
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from shockpc.core.memo import memoized
from shockpc.core.spatial import Array
from shockpc.core.threads import one_thread
from shockpc.landing.landing import PosedLanding
from shockpc.robot.tolerances import inertia_fault
from shockpc.wings.compliant.links.flexes import Flex
from shockpc.wings.compliant.links.segments import Division

if TYPE_CHECKING:
    from shockpc.wings.compliant.links.bent_landing import FlexibleLanding

THIN, UNKNOWN = 1e-9, 1e9
"""Share of a moment of inertia that says nothing of a section, and EI then [N m²].

Below this share of the moments of inertia, that about the axis says nothing.
"""

HELD = 1e-6
"""Share of the highest frequency below which one is rounding."""

SPECIFIC_STIFFNESS = 26e6
"""E/ρ of steel, aluminium, titanium and magnesium [m²/s²]."""

ALONG_FIBRES = 75e6
"""E/ρ of carbon fibre along its fibres [m²/s²], the largest of a tube."""


class LegModes(NamedTuple):
    """The first bending mode of the links between a contact and the base.

    Attributes:
        links: their names, from the contact on.
        alpha: its frequency for an EI of 1 N m² [Hz].
        metal: the same of links that are bars of metal with their inertias about their axes [Hz].
    """

    links: tuple[str, ...]
    alpha: float
    metal: float

    @property
    def carbon(self) -> float:
        """First bending frequency with tubes of carbon fibre, with fibres along them [Hz]."""
        return self.metal * math.sqrt(ALONG_FIBRES / SPECIFIC_STIFFNESS)

    def stiffness(self, frequency: float) -> float:
        """The EI of all links with which the first bending mode has a frequency [N m²]."""
        return (frequency / self.alpha) ** 2


@memoized()
def leg_modes(landing: PosedLanding, contact: int) -> LegModes | None:
    """The first bending mode of the links between a contact and the base.

    None where no link has an inertia.

    A contact on the base bends that; an end stop bends nothing.

    Raises:
        RobotError: a link cannot be divided.
    """
    names = _slender_links(landing, contact)
    if not names:
        return None
    from shockpc.wings.compliant.links.bent_landing import (
        flexible_landing,  # which short runs do not need
    )

    bending = flexible_landing(landing.without_stops, tuple((name, Flex(EI=1.0)) for name in names))
    flexible = bending.flexible
    # Springs of hinges are in proportion to the EI of their link.
    stiffness = np.array(flexible.stiffness)
    for body, division in flexible.divisions.items():
        EI = _of_metal(division, landing.robot.bodies[body].inertia)
        for segment in flexible.segments[body][1:]:
            stiffness[flexible.robot.joints[segment].v] *= EI
    of_metal = replace(bending, flexible=replace(flexible, stiffness=stiffness))
    with one_thread(flexible.robot.model.nv):
        return LegModes(names, _first_frequency(bending), _first_frequency(of_metal))


def _slender_links(landing: PosedLanding, contact: int) -> tuple[str, ...]:
    """Names of the links with an inertia between a contact and the base, from the contact on."""
    robot, struck = landing.robot, landing.contacts[contact]
    body, links = struck.body, list[int]()
    if struck.kind == "stop":
        return ()
    while body >= 0:
        # Body 0 of a free robot is its base, which bends only where the contact is on it; of a
        # fixed one it is the first link.
        if body == 0 and links and robot.free_base:
            break
        links.append(body)
        body = robot.parents[body]
    names = []
    for link in (robot.bodies[k] for k in links):
        if link.mass > 0.0 and inertia_fault(link.mass, link.inertia) is None:
            names.append(link.name)
    return tuple(names)


def _of_metal(division: Division, inertia: Array) -> float:
    """EI = (E/ρ) J / 2L of a bar of metal with the moment of inertia J about its axis [N m²]."""
    length = division.spacing * len(division.along)
    about_axis = float(division.axis @ inertia @ division.axis)
    if about_axis > THIN * np.trace(inertia):
        return SPECIFIC_STIFFNESS * about_axis / (2.0 * length)
    return UNKNOWN


def _first_frequency(bending: "FlexibleLanding") -> float:
    """The first frequency that is no rounding, as where loops hold links against bending [Hz]."""
    frequencies = bending.elastic_frequencies()
    bends = frequencies > HELD * frequencies[-1]
    return float(frequencies[bends][0])
