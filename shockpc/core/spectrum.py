"""Shock response spectrum: the largest acceleration of oscillators whose base moves with a given
acceleration (ISO 18431-4).
"""

import functools
from itertools import pairwise

import numpy as np

from shockpc.core.spatial import Array

SAMPLES_A_PERIOD = 20.0
"""Smallest number of samples in a period of an oscillator."""


LONG = 20.0
"""Periods of an oscillator that a pulse lasts, from which on its response is taken as that of a
slow one.
"""


@functools.lru_cache(maxsize=64)
def amplification(shape: str, periods: float) -> float:
    """Largest acceleration of an undamped oscillator for a single pulse of its base, relative to
    the peak of the pulse [1].

    Args:
        shape: one of `pulse.SHAPES`; the saw-tooth has its peak at the end.
        periods: of the oscillator that the pulse lasts, f T. Above 20 the value is that for long
            pulses, at most 3 % low: 1, or 2 for a rectangle.
    """
    if periods > LONG:
        return 2.0 if shape == "rectangle" else 1.0
    n = max(400, int(5.0 * SAMPLES_A_PERIOD * periods))
    t = np.linspace(0.0, 1.0, n + 1)
    waves = {
        "half-sine": np.sin(np.pi * t),
        "saw-tooth": t,
        "haversine": np.sin(np.pi * t) ** 2,
        "rectangle": np.ones(n + 1),
    }
    return float(shock_response(waves[shape][:, None], 1.0 / n, np.array([periods]), 0.0)[0, 0])


def shock_response(
    acceleration: Array, step: float, frequencies: Array, damping: float = 0.05
) -> Array:
    """The largest absolute acceleration of each oscillator, during the history and after it.

    An oscillator ẅ + 2ζω ẇ + ω² w = −a starts at rest; its mass has the acceleration −2ζω ẇ − ω² w.
    With its pole r = −ζω + iω_d, c = ẇ − r̄ w obeys ċ = r c − a, which is solved exactly for an
    acceleration that is linear between samples (Nigam and Jennings 1969, Bull. Seismol. Soc. Am.
    59:909).

    Args:
        acceleration: (N, m) m histories of the base [m/s²], zero before and after.
        step: time between samples [s].
        frequencies: (f,) natural frequencies of the oscillators without damping [Hz].
        damping: ζ, from 0 to below 1.

    Returns: (f, m) [m/s²].

    Raises:
        ValueError: a frequency is not above zero or has fewer than `SAMPLES_A_PERIOD` samples a
            period, or ζ is outside [0, 1).
    """
    frequencies = np.asarray(frequencies, dtype=float)
    if not 0.0 <= damping < 1.0:
        raise ValueError(f"damping must lie in [0, 1), not {damping:g}")
    if not np.all((frequencies > 0.0) & (frequencies * step * SAMPLES_A_PERIOD <= 1.0 + 1e-9)):
        raise ValueError(
            f"with samples every {step:g} s, frequencies must lie above 0 and up to "
            f"{1.0 / SAMPLES_A_PERIOD / step:g} Hz, "
            f"not from {frequencies.min():g} to {frequencies.max():g} Hz"
        )
    omega = 2.0 * np.pi * frequencies[:, None]
    damped = omega * np.sqrt(1.0 - damping**2)
    r = -damping * omega + 1j * damped
    # ∫ exp(r (h − s)) ds and ∫ exp(r (h − s)) s/h ds over one step h; the latter by its series, for
    # exp(x) − 1 − x cancels.
    x = r * step
    ramp = step * sum(x**k / float(np.prod(np.arange(1.0, k + 3.0))) for k in range(16))
    hold = np.expm1(x) / r
    # The acceleration of the mass is Re(weight · c).
    weight = -2.0 * damping * omega + 1j * omega**2 * (1.0 - 2.0 * damping**2) / damped
    c = np.zeros((len(frequencies), acceleration.shape[1]), dtype=complex)
    value, largest = c.real, np.zeros(c.shape)
    rate = -weight.real * acceleration[0] if len(acceleration) else value
    grow = np.exp(x)
    for before, after in pairwise(acceleration):
        last, value_before, rate_before = c, value, rate
        c = grow * c - (hold - ramp) * before - ramp * after
        value, rate = (weight * c).real, (weight * (r * c - after)).real
        largest = np.maximum(largest, np.abs(value))
        f, m = np.nonzero(rate_before * rate < 0.0)
        # About where a parabola turns; a maximum there is refined if it may be the largest.
        t = step * rate_before[f, m] / (rate_before - rate)[f, m]
        higher = np.abs(value_before[f, m] + rate_before[f, m] * t / 2.0) > 0.99 * largest[f, m]
        if higher.any():
            f, m, t = f[higher], m[higher], t[higher]
            value_there = _turning_value(
                r[f, 0], weight[f, 0], last[f, m], before[m], (after - before)[m] / step, t, step
            )
            largest[f, m] = np.maximum(largest[f, m], value_there)
    # Afterwards the oscillation decays: its first extremum is the largest, where the derivative
    # Re(weight r c exp(rt)) is zero.
    t = (np.pi / 2.0 - np.angle(weight * r * c)) % np.pi / damped
    return np.asarray(np.maximum(largest, np.abs((weight * c * np.exp(r * t)).real)))


def _turning_value(
    r: Array, weight: Array, c: Array, before: Array, slope: Array, t: Array, step: float
) -> Array:
    """|Re(weight · c)| (k,) where its derivative is zero, near times t (k,) of one step; ċ = r c −
    before − slope t.

    With g = ċ and s = slope, ġ = r g − s: the derivative is Re(weight (g₀ − s/r) exp(rt) + weight
    s/r). Newton's method.
    """
    level = weight * slope / r
    start = weight * (r * c - before) - level
    for _ in range(2):
        wave = start * np.exp(r * t)
        bend = (r * wave).real
        t = np.clip(
            t - np.divide((wave + level).real, bend, out=np.zeros_like(t), where=bend != 0.0),
            0.0,
            step,
        )
    return np.abs(((start * np.exp(r * t) + level + weight * (before + slope * t)) / r).real)
