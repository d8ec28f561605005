"""The first time at which one of several sums of harmonic oscillations, which may decay, falls
below zero.

Between two samples a signal lies above the parabola through them whose curvature is the bound Σ_j
|λ_j|² |amplitude_j|. Where that stays positive there is no root; elsewhere the samples are refined.
No root is passed over unless the signal dips by less than 1e-9 of its amplitude.
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
"""Bound of the number of terms of oscillations that are evaluated for the events of a motion, or
for a peak: some ten seconds.
"""


class Effort:
    """The terms that were evaluated.

    What takes too long is refused by their number, which is the same on every machine.
    """

    def __init__(self) -> None:
        self.terms = 0

    def spend(self, terms: int) -> None:
        """Add some terms; ArithmeticError above `MOST_TERMS`."""
        self.terms += terms
        if self.terms > MOST_TERMS:
            raise ArithmeticError(
                f"forces that oscillate at far different frequencies take more than "
                f"{MOST_TERMS:.1g} terms to follow; take the "
                "stiffest springs as rigid, or a stiffer contact"
            )


class Signals(NamedTuple):
    """Signals s, start + linear t + square t² + Re Σ_j wave_j (exp(λ_j t) − 1), whose fall below
    −tolerance is sought.

    Written from their start, slow oscillations of large amplitude, as of what falls against a soft
    spring, cancel no digits.

    Attributes:
        either: (s,) whether the signal may have either sign at first, and counts with that sign.
        tolerance: (s,) what counts as zero; negative where a signal must stay above it.
        start, linear, square: (s,) coefficients.
        wave: (s, m) complex coefficients.
        bound: of the second derivative of the last term (s,), where one is known: oscillations that
            decay at nearly equal rates have large coefficients that cancel.
    """

    either: np.ndarray
    tolerance: Array
    start: Array
    linear: Array
    square: Array
    wave: ComplexArray
    bound: Array | float = np.inf


def first_crossing(
    rate: ComplexArray, signals: Signals, horizon: float, effort: Effort
) -> tuple[float, int | None]:
    """Find the first time at which a signal falls below −tolerance.

    Args:
        rate: (m,) λ, of which the real parts are not positive [rad/s].
        signals: s of them.
        horizon: where the search ends [s]; may be infinite.
        effort: of the whole motion.

    Returns: the time [s] and the index of the signal; the horizon (or zero, if that is infinite)
        and None if no signal falls.

    Raises:
        ArithmeticError: the horizon, or the first fall, is too many periods away, or takes too many
            terms.
    """
    if signals.either.any():
        signals = _with_first_sign(rate, signals)
    start, (linear, square, wave) = signals.start + signals.tolerance, signals[3:6]
    amplitude, centre = np.abs(wave), start - wave.real.sum(axis=1)
    decay, decays = rate.real, bool(rate.real.any())
    if len(start) and start.min() < 0.0:
        return 0.0, int(start.argmin())

    def search(a: float, b: float, count: int, depth: int) -> tuple[float, int] | None:
        effort.spend((count + 1) * wave.size)
        t = a + (b - a) / count * np.arange(count + 1.0)
        t[-1] = b
        value = (
            start + t[:, None] * (linear + t[:, None] * square) + changes(t[:, None] * rate, wave)
        )
        # Between two samples a signal lies above the parabola through them that curves by the
        # bound.
        change, curve = (
            value[1:] - value[:-1],
            np.maximum(bound * ((b - a) / count) ** 2 / 2.0, 1e-300),
        )
        dips = (np.abs(change) < curve) & (4.0 * curve * value[:-1] < (curve - change) ** 2)
        crosses = value[1:] < 0.0
        for k in np.nonzero((dips | crosses).any(axis=1))[0].tolist():
            if depth and dips[k].any() and (event := search(t[k], t[k + 1], 16, depth - 1)):
                return event
            if crosses[k].any():
                return min(
                    (root(i, t[k], t[k + 1], *value[k : k + 2, i]), i)
                    for i in np.nonzero(crosses[k])[0].tolist()
                )
        return None

    def root(i: int, a: float, b: float, above: float, below: float) -> float:
        # By the chord, which starts inside the interval where a signal rises from zero first.
        t, last = a + (b - a) * (above / (above - below) if above > 0.0 else 0.5), np.inf
        level, speed, bend = float(start[i]), float(linear[i]), float(square[i])
        # Numbers of Python: arrays of so few modes take ten times as long.
        modes = list(
            zip(
                decay.tolist(),
                rate.imag.tolist(),
                wave[i].real.tolist(),
                wave[i].imag.tolist(),
                strict=True,
            )
        )
        for _ in range(100):
            value, slope = level + t * (speed + t * bend), speed + 2.0 * t * bend
            for falls, frequency, real, imaginary in modes:
                sin, cos = math.sin(frequency * t / 2.0), math.cos(frequency * t / 2.0)
                # Of wave · exp(iσt): the change of its real part, and its imaginary part.
                change, other = (
                    -2.0 * sin * (sin * real + cos * imaginary),
                    2.0 * sin * cos * real + (cos * cos - sin * sin) * imaginary,
                )
                if falls:
                    lost = math.expm1(falls * t)
                    change, other = change + lost * (real + change), (1.0 + lost) * other
                    slope += falls * (real + change)
                value += change
                slope -= frequency * other
            a, b = (t, b) if value > 0.0 else (a, t)
            newton = t - value / slope if slope < 0.0 else np.inf
            step = abs(newton - t)
            # Near the root a step that is not much smaller than the last one is rounding.
            if step <= 1e-15 * t or b - a <= 1e-15 * b or (step > last / 4.0 and last <= 1e-11 * t):
                break
            last = step
            t = newton if a < newton < b else (a + b) / 2.0
        return t

    a, step, end, bound = 0.0, 0.0, horizon, np.zeros(len(start))
    for count in (64, 128, 256, 512, *[1024] * (MOST_SAMPLES // 1024)):
        if a == 0.0 or decays:
            left = amplitude * np.exp(decay * a)
            fastest = float(rate_of_change(rate, left, np.abs(centre)).max(initial=0.0))
            if fastest == 0.0 and horizon == np.inf:
                falls = [
                    _falls(*terms)
                    for terms in zip(centre.tolist(), linear.tolist(), square.tolist(), strict=True)
                ]
                first = min(falls, default=np.inf)
                return (first, falls.index(first)) if first < np.inf else (a, None)
            step = 0.25 / fastest if fastest > 0.0 else np.inf
            bound = np.minimum(left @ np.abs(rate) ** 2, signals.bound) + 2.0 * np.maximum(
                square, 0.0
            )
        if a == 0.0 and horizon < np.inf:
            # A signal that grows faster than it oscillates cannot fall any more, as the gap of a
            # contact that has opened for good.
            lowest = centre - amplitude.sum(axis=1)
            last = [
                _stays(*terms)
                for terms in zip(lowest.tolist(), linear.tolist(), square.tolist(), strict=True)
            ]
            end = min(horizon, max([*last, step]))
        b = min(a + count * step, end)
        if event := search(a, b, count, 3):
            return event
        if b == end:
            return horizon, None
        a = b
    raise ArithmeticError(
        f"nothing changes within {a:.3g} s, {MOST_SAMPLES // 25} periods of the fastest mode; take "
        f"the stiffest springs as rigid"
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


def _falls(level: float, linear: float, square: float) -> float:
    """The time at which level + linear t + square t², of a level above zero, falls below zero;
    infinite if it does not.
    """
    root = linear**2 - 4.0 * square * level
    if square >= 0.0 and (linear >= 0.0 or root < 0.0):
        return np.inf
    return 2.0 * level / (math.sqrt(root) - linear)


def _with_first_sign(rate: ComplexArray, signals: Signals) -> Signals:
    """Signals with the signs that count: of one that may have either, that of its start, or if this
    is zero soon after.
    """
    soon = EARLY / (float(np.abs(rate).max(initial=0.0)) or 1.0)
    change = soon * (signals.linear + soon * signals.square) + changes(soon * rate, signals.wave)
    zero = np.abs(signals.start) <= NEGLIGIBLE * np.abs(signals.wave).sum(axis=1)
    sign = np.where(signals.either & (np.where(zero, change, signals.start) < 0.0), -1.0, 1.0)
    start, linear, square, wave = signals[2:6]
    return signals._replace(
        start=sign * start, linear=sign * linear, square=sign * square, wave=sign[:, None] * wave
    )


def growth(exponent: ComplexArray) -> ComplexArray:
    """exp(x) − 1 without cancellation at small x."""
    half = exponent.imag / 2.0
    sin, cos = np.sin(half), np.cos(half)
    real, imaginary = -2.0 * (sin * sin), 2.0 * (sin * cos)
    if exponent.real.any():
        lost = np.expm1(exponent.real)
        real, imaginary = real + lost * (1.0 + real), (1.0 + lost) * imaginary
    return np.asarray(real + 1j * imaginary)


def integral(rate: ComplexArray, t: Array) -> ComplexArray:
    """∫ exp(λt') dt' from zero to times t, (exp(λt) − 1) / λ without cancellation."""
    exponent = rate * t
    return np.divide(growth(exponent), rate, out=exponent * 0.0 + t, where=rate != 0.0)


def real_sum(values: ComplexArray, wave: ComplexArray) -> Array:
    """Re Σ_j wave_j value_j, (..., s), of values (..., m) and waves (s, m)."""
    return np.asarray(values.real @ wave.real.T - values.imag @ wave.imag.T)


def changes(exponent: ComplexArray, wave: ComplexArray) -> Array:
    """Re Σ_j wave_j (exp(x_j) − 1), (..., s), of exponents (..., m) and waves (s, m), without
    cancellation at small exponents.
    """
    return real_sum(growth(exponent), wave)


def oscillations(exponent: ComplexArray, wave: ComplexArray) -> Array:
    """Re Σ_j wave_j exp(x_j), (..., s), of exponents (..., m) and waves (s, m)."""
    cos, sin = np.cos(exponent.imag), np.sin(exponent.imag)
    if exponent.real.any():
        left = np.exp(exponent.real)
        cos, sin = left * cos, left * sin
    return np.asarray(cos @ wave.real.T - sin @ wave.imag.T)


def rate_of_change(rate: ComplexArray, amplitude: Array, constant: Array | float = 0.0) -> Array:
    """The frequency (...) with which signals change [rad/s], from the bounds of |s̈| and |s|;
    amplitude (..., m).
    """
    size = constant + amplitude.sum(axis=-1)
    return np.asarray(
        np.sqrt((amplitude * np.abs(rate) ** 2).sum(axis=-1) / np.where(size > 0.0, size, 1.0))
    )
