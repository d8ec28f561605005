"""The first time at which one of several sums of harmonic oscillations falls below zero.

Between two samples a signal lies above the parabola through them whose curvature is the bound Σ_j σ_j² |amplitude_j|. Where that
stays positive there is no root; elsewhere the samples are refined. No root is passed over unless the signal dips by less than 1e-9
of its amplitude.
"""

import math
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from shockpc.core.spatial import Array

ComplexArray: TypeAlias = np.ndarray[Any, np.dtype[np.complex128]]

MOST_SAMPLES = 2**18
"""Bound of the number of samples, from which the frequencies lie too far apart."""

NEGLIGIBLE = 1e-11
"""Share of the amplitudes of a signal below which its start counts as zero."""

EARLY = 1e-3
"""Angle of the fastest mode [rad] after which the sign of a signal that starts at zero is read."""

MOST_TERMS = 2**31
"""Bound of the number of terms of oscillations that are evaluated for the events of a motion, or for a peak: some ten seconds."""


class Effort:
    """The terms that were evaluated. What takes too long is refused by their number, which is the same on every machine."""

    def __init__(self) -> None:
        self.terms = 0

    def spend(self, terms: int) -> None:
        """Add some terms; ArithmeticError above `MOST_TERMS`."""
        self.terms += terms
        if self.terms > MOST_TERMS:
            raise ArithmeticError(
                f"forces that oscillate at far different frequencies take more than {MOST_TERMS:.1g} terms to follow; take the "
                "stiffest springs as rigid, or a stiffer contact"
            )


class Signals(NamedTuple):
    """Signals s, start + linear t + square t² + Re Σ_j wave_j (exp(iσ_j t) − 1), whose fall below −tolerance is sought.

    Written from their start, slow oscillations of large amplitude, as of what falls against a soft spring, cancel no digits.

    Attributes:
        either: (s,) whether the signal may have either sign at first, and counts with that sign.
        tolerance: (s,) what counts as zero; negative where a signal must stay above it.
        start, linear, square: (s,) coefficients.
        wave: (s, m) complex coefficients.
    """

    either: np.ndarray
    tolerance: Array
    start: Array
    linear: Array
    square: Array
    wave: ComplexArray


def first_crossing(sigma: Array, signals: Signals, horizon: float, effort: Effort) -> tuple[float, int | None]:
    """Find the first time at which a signal falls below −tolerance.

    Args:
        sigma: (m,) frequencies [rad/s].
        signals: s of them.
        horizon: where the search ends [s]; may be infinite.
        effort: of the whole motion.

    Returns: the time [s] and the index of the signal; the horizon (or zero, if that is infinite) and None if no signal falls.

    Raises:
        ArithmeticError: the horizon, or the first fall, is too many periods away, or takes too many terms.
    """
    if signals.either.any():
        signals = _with_first_sign(sigma, signals)
    start, linear, square, wave = signals.start + signals.tolerance, *signals[3:]
    amplitude, centre = np.abs(wave), start - wave.real.sum(axis=1)
    bound = amplitude @ sigma**2 + 2.0 * np.maximum(square, 0.0)
    if len(start) and start.min() < 0.0:
        return 0.0, int(start.argmin())

    def search(a: float, b: float, count: int, depth: int) -> tuple[float, int] | None:
        effort.spend((count + 1) * wave.size)
        t = a + (b - a) / count * np.arange(count + 1.0)
        t[-1] = b
        value = start + t[:, None] * (linear + t[:, None] * square) + changes(t[:, None] * sigma, wave)
        # Between two samples a signal lies above the parabola through them that curves by the bound.
        change, curve = value[1:] - value[:-1], np.maximum(bound * ((b - a) / count) ** 2 / 2.0, 1e-300)
        dips = (np.abs(change) < curve) & (value[:-1] < (curve - change) ** 2 / (4.0 * curve))
        crosses = value[1:] < 0.0
        for k in np.nonzero((dips | crosses).any(axis=1))[0].tolist():
            if depth and dips[k].any() and (event := search(t[k], t[k + 1], 16, depth - 1)):
                return event
            if crosses[k].any():
                return min((root(i, t[k], t[k + 1], *value[k : k + 2, i]), i) for i in np.nonzero(crosses[k])[0].tolist())
        return None

    def root(i: int, a: float, b: float, above: float, below: float) -> float:
        # By the chord, which starts inside the interval where a signal rises from zero first.
        t, last = a + (b - a) * (above / (above - below) if above > 0.0 else 0.5), np.inf
        level, rate, bend = float(start[i]), float(linear[i]), float(square[i])
        # Numbers of Python: arrays of so few modes take ten times as long.
        modes = list(zip(sigma.tolist(), wave[i].real.tolist(), wave[i].imag.tolist(), strict=True))
        for _ in range(100):
            value, slope = level + t * (rate + t * bend), rate + 2.0 * t * bend
            for frequency, real, imaginary in modes:
                sin, cos = math.sin(frequency * t / 2.0), math.cos(frequency * t / 2.0)
                value -= 2.0 * sin * (sin * real + cos * imaginary)
                slope -= frequency * (2.0 * sin * cos * real + (cos * cos - sin * sin) * imaginary)
            a, b = (t, b) if value > 0.0 else (a, t)
            newton = t - value / slope if slope < 0.0 else np.inf
            step = abs(newton - t)
            # Near the root a step that is not much smaller than the last one is rounding.
            if step <= 1e-15 * t or b - a <= 1e-15 * b or (step > last / 4.0 and last <= 1e-11 * t):
                break
            last = step
            t = newton if a < newton < b else (a + b) / 2.0
        return t

    rate = float(rate_of_change(sigma, amplitude, np.abs(centre)).max(initial=0.0))
    if rate == 0.0 and horizon == np.inf:
        return 0.0, None
    step, a, end = 0.25 / rate if rate > 0.0 else np.inf, 0.0, horizon
    if horizon < np.inf:
        # A signal that grows faster than it oscillates cannot fall any more, as the gap of a contact that has opened for good.
        lowest = centre - amplitude.sum(axis=1)
        last = [_stays(*terms) for terms in zip(lowest.tolist(), linear.tolist(), square.tolist(), strict=True)]
        end = min(horizon, max([*last, step]))
    for count in (64, 128, 256, 512, *[1024] * (MOST_SAMPLES // 1024)):
        b = min(a + count * step, end)
        if event := search(a, b, count, 3):
            return event
        if b == end:
            return horizon, None
        a = b
    raise ArithmeticError(
        f"nothing changes within {a:.3g} s, {MOST_SAMPLES // 25} periods of the fastest mode; take the stiffest springs as rigid"
        + (", or end the motion earlier" if horizon < np.inf else "")
    )


def _stays(lowest: float, linear: float, square: float) -> float:
    """The time from which on lowest + linear t + square t² stays positive; infinite if it does not."""
    if square < 0.0 or (square == 0.0 and (linear < 0.0 or linear == 0.0 >= lowest)):
        return np.inf
    if lowest > 0.0 <= linear:
        return 0.0
    root = math.sqrt(max(linear**2 - 4.0 * square * lowest, 0.0))
    if linear < 0.0:
        return (root - linear) / (2.0 * square)
    return -2.0 * lowest / (linear + root) if linear + root > 0.0 else 0.0


def _with_first_sign(sigma: Array, signals: Signals) -> Signals:
    """Signals with the signs that count: of one that may have either, that of its start, or if this is zero soon after."""
    soon = EARLY / (float(sigma.max(initial=0.0)) or 1.0)
    change = soon * (signals.linear + soon * signals.square) + changes(soon * sigma, signals.wave)
    zero = np.abs(signals.start) <= NEGLIGIBLE * np.abs(signals.wave).sum(axis=1)
    sign = np.where(signals.either & (np.where(zero, change, signals.start) < 0.0), -1.0, 1.0)
    start, linear, square, wave = signals[2:]
    return Signals(signals.either, signals.tolerance, sign * start, sign * linear, sign * square, sign[:, None] * wave)


def changes(angle: Array, wave: ComplexArray) -> Array:
    """Re Σ_j wave_j (exp(i angle_j) − 1), (..., s), of angles (..., m) and waves (s, m), without cancellation at small angles."""
    sin, cos = np.sin(angle / 2.0), np.cos(angle / 2.0)
    return np.asarray(-2.0 * ((sin * sin) @ wave.real.T + (sin * cos) @ wave.imag.T))


def oscillations(angle: Array, wave: ComplexArray) -> Array:
    """Re Σ_j wave_j exp(i angle_j), (..., s), of angles (..., m) and waves (s, m)."""
    return np.asarray(np.cos(angle) @ wave.real.T - np.sin(angle) @ wave.imag.T)


def rate_of_change(sigma: Array, amplitude: Array, constant: Array | float = 0.0) -> Array:
    """The frequency (...) with which signals change [rad/s], from the bounds of |s̈| and |s|; amplitude (..., m)."""
    size = constant + amplitude.sum(axis=-1)
    return np.asarray(np.sqrt((amplitude * sigma**2).sum(axis=-1) / np.where(size > 0.0, size, 1.0)))
