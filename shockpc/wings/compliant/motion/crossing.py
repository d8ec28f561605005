"""The first time at which one of several sums of oscillations falls below zero.

The oscillations are harmonic and may decay.

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

SAMPLES = (64, 128, 256, 512, *[1024] * (MOST_SAMPLES // 1024))
"""Steps of the intervals that are searched one after another."""

REFINEMENTS = 3
"""Number of times that a step in which a signal may dip is divided by 16."""

NEGLIGIBLE = 1e-11
"""Share of the amplitudes of a signal below which its start counts as zero."""

EARLY = 1e-3
"""Angle of the fastest mode [rad] after which the sign of a signal that starts at zero is read."""

MOST_TERMS = 2**31
"""Most terms of oscillations that are evaluated for the events of a motion, or for a peak.

They take some ten seconds.
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
    """Signals whose fall below −tolerance is sought: sums of a parabola and oscillations.

    s = start + linear t + square t² + Re Σ_j wave_j (exp(λ_j t) − 1)

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
    start = signals.start + signals.tolerance
    if len(start) and start.min() < 0.0:
        return 0.0, int(start.argmin())
    search = _Search(rate, signals._replace(start=start), effort)
    decays = bool(rate.real.any())

    a, end = 0.0, horizon
    for count in SAMPLES:
        # Amplitudes that decay allow wider steps later.
        if a == 0.0 or decays:
            search.bound_after(a)
            if search.step == np.inf and horizon == np.inf:
                return search.first_fall_of_parabolas(a)
        if a == 0.0 and horizon < np.inf:
            end = min(horizon, max(search.last_possible_fall(), search.step))
        b = min(a + count * search.step, end)
        event = search.first_in(a, b, count, REFINEMENTS)
        if event is not None:
            return event
        if b == end:
            return horizon, None
        a = b
    earlier = ", or end the motion earlier" if horizon < np.inf else ""
    raise ArithmeticError(
        f"nothing changes within {a:.3g} s, {MOST_SAMPLES // 25} periods of the fastest mode; take "
        f"the stiffest springs as rigid{earlier}"
    )


class _Search:
    """The search for the first fall of signals below zero.

    Args:
        rate: (m,) λ [rad/s].
        signals: s of them, which start above zero; their tolerance is not looked at.
        effort: of the whole motion.

    Attributes:
        step: time between samples, a quarter of a radian of the fastest change; infinite if nothing
            oscillates [s].
        bound: (s,) bound of |s̈|.
    """

    def __init__(self, rate: ComplexArray, signals: Signals, effort: Effort) -> None:
        self._rate, self._signals, self._effort = rate, signals, effort
        self._amplitude = np.abs(signals.wave)
        self._centre = signals.start - signals.wave.real.sum(axis=1)
        self.step = np.inf
        self.bound = np.zeros(len(signals.start))

    def bound_after(self, time: float) -> None:
        """Set the step and the bound of the curvature from a time on."""
        amplitude = self._amplitude * np.exp(self._rate.real * time)
        frequency = rate_of_change(self._rate, amplitude, np.abs(self._centre))
        fastest = float(frequency.max(initial=0.0))
        self.step = 0.25 / fastest if fastest > 0.0 else np.inf
        # |s̈| ≤ Σ_j |λ_j|² |amplitude_j|, and 2 square where the parabola curves upwards.
        of_waves = np.minimum(amplitude @ np.abs(self._rate) ** 2, self._signals.bound)
        self.bound = of_waves + 2.0 * np.maximum(self._signals.square, 0.0)

    def first_fall_of_parabolas(self, time: float) -> tuple[float, int | None]:
        """The first fall where nothing oscillates.

        It is the time that is passed and None if none falls.
        """
        falls = [_falls(*parabola) for parabola in self._parabolas(self._centre)]
        first = min(falls, default=np.inf)
        if first == np.inf:
            return time, None
        return first, falls.index(first)

    def last_possible_fall(self) -> float:
        """The time after which no signal falls.

        A signal is below its parabola by its amplitudes at most.

        One that grows faster than it oscillates is the gap of a contact that opened for good.
        """
        lowest = self._centre - self._amplitude.sum(axis=1)
        return max((_stays(*parabola) for parabola in self._parabolas(lowest)), default=0.0)

    def _parabolas(self, level: Array) -> list[tuple[float, float, float]]:
        """Coefficients of level + linear t + square t² of each signal."""
        linear, square = self._signals.linear.tolist(), self._signals.square.tolist()
        return list(zip(level.tolist(), linear, square, strict=True))

    def first_in(self, a: float, b: float, count: int, depth: int) -> tuple[float, int] | None:
        """The first fall between times a and b, and its signal; None if there is none.

        Args:
            a: start of the interval [s].
            b: its end [s].
            count: number of steps in it.
            depth: how often a step in which a signal may dip is divided.
        """
        signals = self._signals
        self._effort.spend((count + 1) * signals.wave.size)
        width = (b - a) / count
        t = a + width * np.arange(count + 1.0)
        t[-1] = b
        T = t[:, None]
        # s(t) = start + linear t + square t² + Re Σ_j wave_j (exp(λ_j t) − 1)
        parabola = signals.start + T * (signals.linear + T * signals.square)
        value = parabola + changes(T * self._rate, signals.wave)

        # Between two samples a signal lies above s + (change − curve) x + curve x², 0 ≤ x ≤ 1. That
        # has its minimum inside for |change| < curve, and below zero for
        # 4 curve s < (curve − change)².
        change = value[1:] - value[:-1]
        curve = np.maximum(self.bound * width**2 / 2.0, 1e-300)
        inside = np.abs(change) < curve
        dips = inside & (4.0 * curve * value[:-1] < (curve - change) ** 2)
        crosses = value[1:] < 0.0
        for k in np.flatnonzero((dips | crosses).any(axis=1)).tolist():
            if depth and dips[k].any():
                event = self.first_in(t[k], t[k + 1], 16, depth - 1)
                if event is not None:
                    return event
            if crosses[k].any():
                fallen = np.flatnonzero(crosses[k]).tolist()
                ends = slice(k, k + 2)
                return min((self._root(i, t[ends], value[ends, i]), i) for i in fallen)
        return None

    def _root(self, i: int, times: Array, values: Array) -> float:
        """The time at which signal i falls below zero, by Newton's method kept within the interval.

        Args:
            i: the signal.
            times: (2,) of the interval [s].
            values: (2,) of the signal at these; the second is below zero.
        """
        a, b = times.tolist()
        above, below = values.tolist()
        # The chord starts inside the interval where a signal rises from zero first.
        share = above / (above - below) if above > 0.0 else 0.5
        t, last = a + (b - a) * share, np.inf
        start, linear = float(self._signals.start[i]), float(self._signals.linear[i])
        square, wave = float(self._signals.square[i]), self._signals.wave[i]
        # Numbers of Python: arrays of so few modes take ten times as long.
        rates = self._rate.real.tolist(), self._rate.imag.tolist()
        modes = list(zip(*rates, wave.real.tolist(), wave.imag.tolist(), strict=True))
        for _ in range(100):
            value = start + t * (linear + t * square)
            slope = linear + 2.0 * t * square
            value, slope = _with_waves(value, slope, t, modes)
            if value > 0.0:
                a = t
            else:
                b = t
            newton = t - value / slope if slope < 0.0 else np.inf
            step = abs(newton - t)
            # Near the root a step that is not much smaller than the last one is rounding.
            rounding = step > last / 4.0 and last <= 1e-11 * t
            if rounding or step <= 1e-15 * t or b - a <= 1e-15 * b:
                break
            last = step
            t = newton if a < newton < b else (a + b) / 2.0
        return float(t)


def _with_waves(
    value: float, slope: float, t: float, modes: list[tuple[float, float, float, float]]
) -> tuple[float, float]:
    """A value and its slope with Re Σ_j w_j (exp(λ_j t) − 1) added.

    No digits are cancelled at small times.

    Args:
        value: without the waves.
        slope: the same [1/s].
        t: the time [s].
        modes: real and imaginary part of each λ_j = σ + iω [rad/s], and of w_j.
    """
    for decay, frequency, real, imaginary in modes:
        # Of w exp(iωt) the change of its real part, with 1 − cos ωt = 2 sin²(ωt/2), and its
        # imaginary part.
        sin, cos = math.sin(frequency * t / 2.0), math.cos(frequency * t / 2.0)
        change = -2.0 * sin * (sin * real + cos * imaginary)
        imaginary_part = 2.0 * sin * cos * real + (cos * cos - sin * sin) * imaginary
        if decay:
            # Times exp(σt), so that Re(w exp(λt)) = real + change.
            lost = math.expm1(decay * t)
            change += lost * (real + change)
            imaginary_part *= 1.0 + lost
            slope += decay * (real + change)
        # d/dt Re(w exp(λt)) = σ Re(w exp(λt)) − ω Im(w exp(λt))
        value += change
        slope -= frequency * imaginary_part
    return value, slope


def _stays(lowest: float, linear: float, square: float) -> float:
    """The time from which on lowest + linear t + square t² stays positive.

    It is infinite if it does not.
    """
    line_falls = linear < 0.0 or linear == 0.0 >= lowest
    if square < 0.0 or (square == 0.0 and line_falls):
        return np.inf
    if lowest > 0.0 <= linear:
        return 0.0
    root = math.sqrt(max(linear**2 - 4.0 * square * lowest, 0.0))
    if linear < 0.0:
        return (root - linear) / (2.0 * square)
    return -2.0 * lowest / (linear + root) if linear + root > 0.0 else 0.0


def _falls(level: float, linear: float, square: float) -> float:
    """The time at which level + linear t + square t², of a level above zero, falls below zero.

    It is infinite if it does not fall.
    """
    root = linear**2 - 4.0 * square * level
    if square >= 0.0 and (linear >= 0.0 or root < 0.0):
        return np.inf
    return 2.0 * level / (math.sqrt(root) - linear)


def _with_first_sign(rate: ComplexArray, signals: Signals) -> Signals:
    """Signals with the signs that count.

    Of one that may have either, that is the sign of its start, or if this is zero soon after.
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
    """Re Σ_j wave_j (exp(x_j) − 1), (..., s), of exponents (..., m) and waves (s, m).

    No digits are cancelled at small exponents.
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
    """The frequency (...) with which signals change [rad/s], by their amplitude (..., m).

    It follows from the bounds of |s̈| and |s|.
    """
    size = constant + amplitude.sum(axis=-1)
    acceleration = (amplitude * np.abs(rate) ** 2).sum(axis=-1)
    return np.asarray(np.sqrt(acceleration / np.where(size > 0.0, size, 1.0)))
