"""Frequency of the first bending mode from which on links can be taken as rigid.

From there on the mode makes no difference.

A contact lasts about Tc = π √(m/k), with its effective mass m and its stiffness k, or as long as
the pulse. Several contacts share the mass that they stop, so that they last less than each alone.
What counts is Tc f1, of the first bending mode f1 of the free robot with its rotors. On legs of
quadrupeds and humanoids, from 1e4 to 1e7 N/m, jumps of velocity were within 10 % from Tc f1 = 2 on,
peaks of accelerometers of up to 200 Hz from 3, raw ones from 5, the contact's force from 4, the
largest torque of a joint from 7 and other torques from 15 on. With a damper in series with the
contact, its force is largest sooner, and Tc is twice the time until then.

That is for forces without a step. By hysteresis, a row of a contact with restitution 0 is held from
its largest force on. With rigid links its force falls to zero at once, or stays until the others
let it go. Links that bend, however stiff, swing about that force, with as much amplitude as it
changed by: the contact opens within a period of theirs, while the ground still slows the foot along
its tangents, and torques ring.
"""

import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.landing.landing import PosedLanding
from shockpc.text.diagnostic import Diagnostic
from shockpc.text.errors import RobotError
from shockpc.text.printed import few
from shockpc.wings.compliant.links.leg_modes import LegModes, leg_modes

FOR_JUMPS, FOR_TORQUES = 3.0, 7.0
"""Smallest Tc f1 with which jumps, and with which torques, are within 10 %.

With jumps is what an accelerometer reads; of the torques it is the largest one of a joint.
"""

STEEP = 0.2
"""Restitution by hysteresis below which the force of a contact falls so fast that it is a step."""

ABRUPT = "rectangle", "saw-tooth"
"""Pulses with a step."""

RINGS = "torques ring, and jumps may differ, however stiff links are"
"""Effect of a step of force."""

BENDS = "contact", "bending"
"""Kind and subject of the warning that not even links of metal are stiff enough."""


class Bending(NamedTuple):
    """Requirement on the first bending mode of links to be taken as rigid.

    Attributes:
        contact_time: Tc [s].
        mass: of the contact with that [kg], less what it is shortened by; NaN for a pulse.
        modes: of the links between its contact and the base.
        step: where the force has a step, and how to be without; empty if it has none.
    """

    contact_time: float
    mass: float
    modes: LegModes
    step: str = ""

    def lowest(self, product: float) -> float:
        """The lowest frequency of the first bending mode [Hz]. Args: product, smallest Tc f1."""
        return product / self.contact_time

    def stiffest(self, product: float) -> float:
        """Largest stiffness of a contact for which links of metal are stiff enough [N/m].

        The links have these inertias.
        """
        return self.mass * (math.pi * self.modes.metal / product) ** 2

    @property
    def never(self) -> bool:
        """True if not even links of metal are stiff enough for jumps."""
        return self.modes.metal < self.lowest(FOR_JUMPS)

    @property
    def _held(self) -> str:
        milliseconds = f"{1e3 * self.contact_time:.2g} ms"
        if math.isnan(self.mass):
            return f"in a pulse of {milliseconds}"
        return (
            f"on contacts of {self.mass * (math.pi / self.contact_time) ** 2:.3g} N/m "
            f"({milliseconds})"
        )

    @property
    def lines(self) -> tuple[str, str]:
        """Text of what the links have to be, and of what metal and carbon fibre would reach."""
        lowest = [self.lowest(product) for product in (FOR_JUMPS, FOR_TORQUES)]
        EI = [f"{self.modes.stiffness(frequency):.2g}" for frequency in lowest]
        first = (
            f"rigid links {self._held} are right within some 10 % if the first bending mode of "
            f"{few(self.modes.links, 3)}, in the assembled robot, is above {_hertz(lowest[0])} for "
            f"velocity jumps, and above {_hertz(lowest[1])} for forces (EI of {EI[0]} and {EI[1]} "
            f"N m²)"
        )
        if self.step:
            first += f". This needs a force without a step, but {self.step}"
        limits = [f"{self.stiffest(product):.2g}" for product in (FOR_JUMPS, FOR_TORQUES)]
        reach = (
            f"jumps on contacts of up to {limits[0]} N/m, and for forces of up to {limits[1]} N/m"
        )
        if math.isnan(self.mass):
            limits = [
                f"{1e3 * product / self.modes.metal:.2g}" for product in (FOR_JUMPS, FOR_TORQUES)
            ]
            reach = f"jumps in pulses of {limits[0]} ms or longer, and for forces of {limits[1]} ms"
        metal = (
            f"bars or tubes of metal with these inertias reach {_hertz(self.modes.metal)}, enough "
            f"for {reach}"
        )
        carbon = f"tubes of carbon fibre reach at most {_hertz(self.modes.carbon)}"
        return first, f"{metal}; {carbon}. Real links are softer: shockpc guide bending"


def _hertz(frequency: float) -> str:
    return f"{float(f'{frequency:.3g}'):g} Hz"


def rigid_links(landing: PosedLanding, masses: Callable[[], Array]) -> Bending | str | None:
    """Requirement on the links of a landing to be taken as rigid, or why it is not known.

    Args:
        landing: the landing.
        masses: computes the (c,) effective masses of its contacts, each alone [kg].

    Returns: None where neither a stiffness nor a pulse says how long the contact lasts, and as of
        `bending`.
    """
    stiffness = landing.scene.contact_stiffness
    if stiffness is None and landing.pulse is None:
        return None
    try:
        return bending(landing, masses(), stiffness)
    except RobotError as refusal:
        return str(refusal)


def bending(landing: PosedLanding, masses: Array, stiffness: float | None) -> Bending | None:
    """Requirement on the links of a landing to be taken as rigid.

    The links are those between the base and the contact with the smallest effective mass.

    Args:
        landing: the landing.
        masses: (c,) effective masses of its contacts, each alone [kg].
        stiffness: of the contacts [N/m]; None where only a pulse is given.

    Returns: None with neither, where links bend already, and where none bends or no contact yields.

    Raises:
        RobotError: a link cannot be divided.
    """
    yielding = _yielding(landing, masses)
    if landing.scene.flex or not yielding:
        return None
    # Of contacts with equal masses the last.
    mass, contact = min(yielding, key=lambda pair: (pair[0], -pair[1]))
    if stiffness is not None and len(yielding) > 1:
        mass = min(mass, unit_frequency(landing) ** -2)
    of_pulse = math.inf if landing.pulse is None else landing.pulse.length
    # Tc = π √(m/k)
    of_contact = math.inf if stiffness is None else math.pi * math.sqrt(mass / stiffness)
    if landing.scene.contact_law == "damper":
        shortening = _shortening(landing.contacts[contact].restitution)
        mass, of_contact = mass * shortening**2, of_contact * shortening
    time = min(of_pulse, of_contact)
    if not 0.0 < time < math.inf:
        return None
    modes = leg_modes(landing, contact)
    if modes is None:
        return None
    if of_contact <= of_pulse:
        return Bending(time, mass, modes, step_of_force(landing))
    assert landing.pulse is not None
    shape, step = landing.pulse.shape, ""
    if shape in ABRUPT:
        step = f"a {shape} has one: {RINGS}; take a half-sine"
    return Bending(time, math.nan, modes, step)


def _shortening(restitution: float) -> float:
    """Twice the time until the force of a contact with a damper is largest, over π √(m/k)."""
    from shockpc.wings.compliant.motion.laws import rise, series_damping

    return float(rise(series_damping(np.array(restitution)))) * 2.0 / math.pi


def _yielding(landing: PosedLanding, masses: Array) -> list[tuple[float, int]]:
    """The contacts that can yield: the effective mass [kg] and the number of each."""
    yielding = []
    for k, (mass, constraint) in enumerate(zip(masses.tolist(), landing.contacts, strict=False)):
        if constraint.kind != "stop" and math.isfinite(mass):
            yielding.append((mass, k))
    return yielding


def unit_frequency(landing: PosedLanding) -> float:
    """The ω = 1/√m [rad/s] of the mass m that all contacts stop, each with a stiffness of 1 N/m."""
    from shockpc.impact.contact_rows import contact_rows

    rows = contact_rows(landing, stands=True)
    return rows.frequency(np.ones(len(rows.speeds)), np.zeros((0, len(rows.M))))


def step_of_force(landing: PosedLanding) -> str:
    """Text of where the contact forces have a step, and how to be without; empty without a step.

    The contacts have a finite stiffness.
    """
    from shockpc.impact.contact_rows import row_layout

    remedy = f"a step: {RINGS}; take --contact-law damper"
    if landing.scene.contact_damping is not None:
        return f"the force of --contact-damping starts with {remedy}"
    rows = row_layout(landing.without_stops.constraints, stands=True)
    if landing.scene.contact_law == "damper" or rows.restitution.min(initial=1.0) >= STEEP:
        return ""
    along = "" if rows.restitution[rows.normal].min(initial=1.0) < STEEP else " along the ground"
    return f"hysteresis with a restitution below {STEEP:g}{along} ends with {remedy}"


def bends(links: Bending | None) -> Iterator[Diagnostic]:
    """A warning where not even links of metal are stiff enough."""
    if links is not None and links.never:
        need, metal = links.lowest(FOR_JUMPS), links.modes.metal
        text = (
            f"links bend in a contact of {1e3 * links.contact_time:.2g} ms, so peaks and torques "
            f"may be wrong by factors: the leg's first bending mode would have to be above "
            f"{_hertz(need)}, but links of metal reach {_hertz(metal)}, and of carbon fibre "
            f"{_hertz(links.modes.carbon)}. Describe the links with flex (--flex), or take a "
            f"softer contact"
        )
        yield Diagnostic(*BENDS, need / metal, text)


def rings(landing: PosedLanding) -> Iterator[Diagnostic]:
    """A warning where links bend, and the force of contacts has a step. Args: landing."""
    if not landing.scene.flex or not landing.scene.yields:
        return
    step = step_of_force(landing)
    if step:
        text = f"links that bend ring after a step of force, and {step}"
        yield Diagnostic("contact", "", None, text)
