"""Shock response spectra of points of a landing on contacts of finite stiffness."""

from collections.abc import Sequence

import numpy as np

from shockpc.core.low_pass import LowPass
from shockpc.core.spatial import Array
from shockpc.core.spectrum import SAMPLES_A_PERIOD, shock_response
from shockpc.landing.places import Place
from shockpc.text.errors import SolveError
from shockpc.wings.compliant.over_time.compliant_landing import CompliantLanding, Compute

SPECTRUM = tuple(float(f) for f in np.geomspace(10.0, 2000.0, 93).round(3))
"""Natural frequencies of the shock response spectrum [Hz]."""

DAMPING = (0.0, 0.05)
"""Damping ratios of the same."""

LONGEST_SPECTRUM = 2.0
"""Longest duration of a contact, with what a filter lags, for which there is a spectrum [s].

The samples follow from frequencies.
"""


def spectrum(
    compliant: CompliantLanding,
    compute: Compute,
    places: Sequence[Place],
    damping: float,
    low_pass: LowPass | None = None,
) -> Array:
    """Largest acceleration (f, n) of oscillators at n points.

    The oscillators have the frequencies `SPECTRUM`, and the axis is that in which it is largest.

    The acceleration of the points is that until the end of the motion, less what gravity gives
    them, which an oscillator carries before the impact.

    Args:
        compliant: the landing.
        compute: of a quantity that is linear in jumps, as velocities of points.
        places: the points.
        damping: ratio of the oscillators.
        low_pass: a filter that the acceleration goes through before.

    Raises:
        SolveError: the contact lasts longer than `LONGEST_SPECTRUM`.
    """
    if not places:
        return np.zeros((len(SPECTRUM), 0))
    duration = compliant.filtered(low_pass).duration
    if duration > LONGEST_SPECTRUM:
        k = compliant.landing.scene.contact_stiffness
        lasts = f"on {k:g} N/m the contact lasts {duration:.3g} s"
        if low_pass is not None:
            lasts += " with what the filter lags"
        limit = f"a shock response spectrum is computed of up to {LONGEST_SPECTRUM:g} s"
        raise SolveError(f"{lasts}, and {limit}; take stiffer contacts, or leave --spectrum out")
    samples_needed = duration * SAMPLES_A_PERIOD * SPECTRUM[-1]
    count = int(np.ceil(samples_needed)) + 64
    times = np.linspace(0.0, duration, count + 1)
    _, before = compliant.readout(compute, places)
    history = compliant.history(compute, places, times, low_pass) - before
    samples = history.reshape(count + 1, -1)
    response = shock_response(samples, float(times[1]), np.array(SPECTRUM), damping)
    return np.asarray(response.reshape(len(SPECTRUM), len(places), -1).max(axis=2))
