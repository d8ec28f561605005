"""Beyond the paper: the beam of Figure 1 with bending, against Eqs. 1 to 3.

A contact of finite stiffness strikes it.

The beam is free, uniform and slender, of unit mass and length, and strikes an elastic point with
unit speed. How long the contact lasts, compared with the first bending oscillation, decides what of
the rigid answer holds.
"""

import functools
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.core.threads import one_thread
from shockpc.wings.compliant.links.segments import chain_inertia, divide
from shockpc.wings.compliant.motion.contacts import simulate_landing
from shockpc.wings.compliant.motion.elements import Elements

STRIKES = (0.0, 0.1, 1.0 / 6.0, 0.2, 0.3, 0.4, 0.5)
"""Distances of the contact from the centre of mass, over the length.

At 1/6 the other end is the CoPc.
"""

RATIOS = (0.3, 0.4, 0.5, 0.65, 0.8, 1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0)
"""Tc/T1: duration of contact of the rigid beam, over the period of the first bending mode."""

MODES, HINGES, SAMPLES = 16, 4, 400
"""Bending modes of the exact beam, hinges of the segmented one, and number of times.

At the times velocities are compared.
"""

LIMIT = 0.1
"""Largest error with which the rigid answer counts as right.

It is a share of the speed of the impact, or of the impulse.
"""


class Beam(NamedTuple):
    """A beam of unit mass and length that bends, in n coordinates.

    Attributes:
        M: (n, n) inertia.
        springs: (s, n) deflections for unit coordinates.
        stiffness: (s,) of these, for an EI with which the first bending frequency is 1 Hz.
        across: the velocity (..., n) across the beam at distances (...) from its centre, for unit
            velocities.
        falling: (n,) velocities with which all of it moves with unit speed.
    """

    M: Array
    springs: Array
    stiffness: Array
    across: Callable[[Array], Array]
    falling: Array


class Struck(NamedTuple):
    """Differences from the rigid answer, over the impulse or the speed of the impact [1].

    Attributes:
        impulse: until the contact ends, less the rigid one, over that.
        end: change of the velocity of the other end when the contact ends, less the rigid one.
        copc: largest change of the velocity of the CoPc of the contact, which is zero in Eq. 2; NaN
            at the centre.
    """

    impulse: float
    end: float
    copc: float


@functools.cache
def exact_beam() -> Beam:
    """The beam in its modes of Euler and Bernoulli: cos β cosh β = 1, of unit modal mass."""
    beta = (np.arange(MODES) + 1.5) * np.pi
    # Newton's method for cos β − 1 / cosh β = 0.
    for _ in range(5):
        value = np.cos(beta) - 1.0 / np.cosh(beta)
        slope = np.tanh(beta) / np.cosh(beta) - np.sin(beta)
        beta = beta - value / slope
    size = np.sinh(beta) - np.sin(beta)
    ratio = (np.cosh(beta) - np.cos(beta)) / size
    rest = (np.cos(beta) - np.sin(beta) - np.exp(-beta)) / size

    def across(distance: Array) -> Array:
        x = np.asarray(distance)[..., None]
        # cosh − ratio · sinh, without the difference of large numbers.
        angle = beta * (x + 0.5)
        hyperbolic = (rest * np.exp(angle) + (1.0 + ratio) * np.exp(-angle)) / 2.0
        bent = np.cos(angle) - ratio * np.sin(angle) + hyperbolic
        return np.concatenate([np.ones_like(x), math.sqrt(12.0) * x, bent], axis=-1)

    omega = 2.0 * math.pi * (beta / beta[0]) ** 2
    eye = np.eye(MODES + 2)
    return Beam(eye, eye[2:], omega**2, across, eye[0])


@functools.cache
def segmented_beam(hinges: int = HINGES) -> Beam:
    """The beam as the segments and hinges of `--flex`, in its plane.

    Links of robots bend with them.
    """
    inertia = np.diag([0.0, 1.0, 1.0]) / 12.0
    start, end = np.array([-0.5, 0, 0]), np.array([0.5, 0, 0])
    division = divide(1.0, np.zeros(3), inertia, start, end, hinges)
    upright = int(np.abs(division.across[:, 1]).argmax())
    sign = float(division.across[upright, 1])
    chosen = [1, 5, *range(6 + upright, 6 + 2 * hinges, 2)]
    EI = 4.730040744862704**-4 * (2.0 * math.pi) ** 2

    def across(distance: Array) -> Array:
        x = np.asarray(distance)[..., None]
        behind = np.maximum(x - division.along, 0.0)
        return np.concatenate([-x, np.ones_like(x), -sign * behind], axis=-1)

    M = chain_inertia(division)[np.ix_(chosen, chosen)]
    stiffness = np.full(hinges, EI / division.spacing)
    unit = np.eye(hinges + 2)
    return Beam(M, unit[2:], stiffness, across, unit[1])


def struck(beam: Beam, distance: float, ratio: float) -> Struck:
    """A beam that strikes an elastic contact.

    Args:
        beam: the beam.
        distance: of the contact from the centre of mass, over the length.
        ratio: Tc/T1.
    """
    mass = 1.0 / (1.0 + 12.0 * distance**2)
    # Tc = π √(m/k), and T1 = 1
    stiffness = mass * (math.pi / ratio) ** 2
    contact = Elements.alike(beam.across(np.array([distance])), stiffness, 1.0, 0, True)
    elements = Elements.joined(contact, Elements.alike(beam.springs, beam.stiffness))
    motion = simulate_landing(beam.M, elements, -beam.falling)
    impulse = sum(float(segment.impulse(segment.length)[0]) for segment in motion.segments)
    jumps = motion.at(np.linspace(0.0, motion.duration, SAMPLES)).jump
    rigid = 2.0 * mass * (1.0 - 6.0 * distance)
    end = float(jumps[-1] @ beam.across(np.array(-0.5)))
    at_copc = math.nan
    if distance > 1.0 / 6.0 - 1e-9:  # the CoPc is on the beam
        copc = np.array(-1.0 / (12.0 * distance))
        at_copc = float(np.abs(jumps @ beam.across(copc)).max())
    return Struck(impulse / (2.0 * mass) - 1.0, end - rigid, at_copc)


class BeamErrors(NamedTuple):
    """The largest differences from the rigid answer over all `STRIKES`, at one Tc/T1.

    They are with exact modes, and by segments.
    """

    ratio: float
    exact: Struck
    segments: Struck


@functools.cache
def beam_study() -> tuple[BeamErrors, ...]:
    """The beam of Figure 1 with bending, at each of `RATIOS`."""
    errors = []
    with one_thread(MODES):
        for ratio in RATIOS:
            exact, segments = _largest(exact_beam(), ratio), _largest(segmented_beam(), ratio)
            errors.append(BeamErrors(ratio, exact, segments))
    return tuple(errors)


def _largest(beam: Beam, ratio: float) -> Struck:
    """The largest differences over all `STRIKES`. Args: ratio, Tc/T1."""
    errors = np.abs([struck(beam, distance, ratio) for distance in STRIKES])
    return Struck(*np.nanmax(errors, axis=0).tolist())


def holds_from(errors: Array) -> float:
    """The Tc/T1 of `RATIOS` from which on errors stay below `LIMIT`; infinite if they do not."""
    above = np.flatnonzero(np.asarray(errors) >= LIMIT)
    first = int(above[-1]) + 1 if len(above) else 0
    return RATIOS[first] if first < len(RATIOS) else math.inf
