"""Shock response spectrum: the largest acceleration of oscillators on a moving base.

The base moves with a given acceleration (ISO 18431-4).
"""

import functools
import math
from typing import NamedTuple

import numpy as np

from shockpc.core.low_pass import ComplexArray
from shockpc.core.spatial import Array

SAMPLES_A_PERIOD = 20.0
"""Smallest number of samples in a period of an oscillator."""


LONG = 20.0
"""Periods of an oscillator that a pulse lasts, from which on its response is taken as that of a
slow one.
"""


@functools.lru_cache(maxsize=64)
def amplification(shape: str, periods: float) -> float:
    """Largest acceleration of an undamped oscillator for a single pulse of its base [1].

    It is relative to the peak of the pulse.

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
    history = waves[shape][:, None]
    response = shock_response(history, 1.0 / n, np.array([periods]), damping=0.0)
    return float(response[0, 0])


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
    _refuse(frequencies, step, damping)
    oscillators = _Oscillators.of(frequencies, step, damping)
    c = np.zeros((len(frequencies), acceleration.shape[1]), dtype=complex)
    if not len(acceleration):
        return np.zeros(c.shape)
    largest = np.zeros(c.shape)
    before = oscillators.instant(c, acceleration[0])
    for base in acceleration[1:]:
        after = oscillators.instant(oscillators.after_step(before, base), base)
        largest = np.maximum(largest, np.abs(after.value))
        _raise_to_turning(largest, oscillators, before, after)
        before = after
    return np.maximum(largest, oscillators.largest_of_decay(before.c))


def _refuse(frequencies: Array, step: float, damping: float) -> None:
    """Refuse a damping or frequencies for which the response is not defined or not accurate.

    Raises:
        ValueError: one is.
    """
    if not 0.0 <= damping < 1.0:
        raise ValueError(f"damping must lie in [0, 1), not {damping:g}")
    sampled = frequencies * step * SAMPLES_A_PERIOD <= 1.0 + 1e-9
    if not np.all((frequencies > 0.0) & sampled):
        raise ValueError(
            f"with samples every {step:g} s, frequencies must lie above 0 and up to "
            f"{1.0 / SAMPLES_A_PERIOD / step:g} Hz, "
            f"not from {frequencies.min():g} to {frequencies.max():g} Hz"
        )


class _Oscillators(NamedTuple):
    """Oscillators of f frequencies, and what a step of time makes of their states c (f, m).

    Attributes:
        r: (f, 1) poles −ζω + iω_d [1/s].
        weight: (f, 1) with which the acceleration of the mass is Re(weight c) [1/s].
        damped: (f, 1) ω_d [rad/s].
        step: h, length of a step [s].
        grow: (f, 1) exp(r h).
        hold: (f, 1) ∫ exp(r (h − s)) ds from 0 to h.
        ramp: (f, 1) ∫ exp(r (h − s)) s/h ds.
    """

    r: ComplexArray
    weight: ComplexArray
    damped: Array
    step: float
    grow: ComplexArray
    hold: ComplexArray
    ramp: ComplexArray

    @staticmethod
    def of(frequencies: Array, step: float, damping: float) -> "_Oscillators":
        """Oscillators of natural frequencies (f,) [Hz]."""
        omega = 2.0 * np.pi * frequencies[:, None]
        damped = omega * np.sqrt(1.0 - damping**2)
        r = -damping * omega + 1j * damped
        x = r * step
        # (exp(x) − 1 − x) / x² by its series: the closed form cancels.
        series: ComplexArray = np.zeros_like(x)
        for k in range(16):
            series = series + x**k / math.factorial(k + 2)
        return _Oscillators(
            r=r,
            weight=-2.0 * damping * omega + 1j * omega**2 * (1.0 - 2.0 * damping**2) / damped,
            damped=damped,
            step=step,
            grow=np.exp(x),
            hold=np.expm1(x) / r,
            ramp=step * series,
        )

    def instant(self, c: ComplexArray, base: Array) -> "_Instant":
        """An instant with states (f, m) and accelerations (m,) of the base."""
        value = (self.weight * c).real
        rate = (self.weight * (self.r * c - base)).real
        return _Instant(base, c, value, rate)

    def after_step(self, start: "_Instant", base: Array) -> ComplexArray:
        """The states (f, m) after a step at whose end the base has accelerations (m,)."""
        held = (self.hold - self.ramp) * start.base
        return np.asarray(self.grow * start.c - held - self.ramp * base)

    def largest_of_decay(self, c: ComplexArray) -> Array:
        """The largest accelerations (f, m) after the history.

        They are at the first extremum of the decay, where Re(weight r c exp(rt)) is zero.
        """
        turning = np.pi / 2.0 - np.angle(self.weight * self.r * c)
        t = turning % np.pi / self.damped
        return np.abs((self.weight * c * np.exp(self.r * t)).real)


class _Instant(NamedTuple):
    """The base and the oscillators at a sample of time.

    Attributes:
        base: (m,) accelerations of the base [m/s²].
        c: (f, m) states.
        value: (f, m) accelerations of the masses [m/s²].
        rate: (f, m) their rates of change [m/s³].
    """

    base: Array
    c: ComplexArray
    value: Array
    rate: Array


def _raise_to_turning(
    largest: Array, oscillators: _Oscillators, before: _Instant, after: _Instant
) -> None:
    """Raise the largest accelerations (f, m) to those at which an acceleration turns in a step.

    Args:
        largest: changed.
        oscillators: the oscillators.
        before: the start of the step.
        after: its end.
    """
    f, m = np.nonzero(before.rate * after.rate < 0.0)
    # About where a parabola turns; a maximum there is refined if it may be the largest.
    rate = before.rate[f, m]
    t = oscillators.step * rate / (before.rate - after.rate)[f, m]
    about = np.abs(before.value[f, m] + rate * t / 2.0)
    refined = about > 0.99 * largest[f, m]
    if not refined.any():
        return
    f = f[refined]
    m = m[refined]
    turning = _turning_value(
        oscillators.r[f, 0],
        oscillators.weight[f, 0],
        before.c[f, m],
        before.base[m],
        (after.base - before.base)[m] / oscillators.step,
        t[refined],
        oscillators.step,
    )
    largest[f, m] = np.maximum(largest[f, m], turning)


def _turning_value(
    r: ComplexArray,
    weight: ComplexArray,
    c: ComplexArray,
    before: Array,
    slope: Array,
    t: Array,
    step: float,
) -> Array:
    """|Re(weight · c)| (k,) where its derivative is zero, near times t (k,) of one step.

    ċ = r c − before − slope t.

    With g = ċ and s = slope, ġ = r g − s: the derivative is Re(weight (g₀ − s/r) exp(rt) + weight
    s/r). Newton's method.
    """
    level = weight * slope / r
    start = weight * (r * c - before) - level
    for _ in range(2):
        wave = start * np.exp(r * t)
        rate = (wave + level).real
        bend = (r * wave).real
        newton = np.divide(rate, bend, out=np.zeros_like(t), where=bend != 0.0)
        t = np.clip(t - newton, 0.0, step)
    # c = (ċ + before + s t) / r
    turned = start * np.exp(r * t) + level + weight * (before + slope * t)
    return np.abs((turned / r).real)
