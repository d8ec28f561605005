"""The reading of an accelerometer of a given bandwidth, in closed form.

It is the acceleration behind a low-pass filter.

Of first order the transfer function is ω / (s + ω), of second order that of a Butterworth filter,
ω² / (s² + √2 ω s + ω²); at the frequency f = ω / 2π both let pass 1/√2.

A pulse of one sign that changes a velocity by Δv makes at most h Δv, however short it is, with the
maximum h of the response to a unit impulse: ω of first order, exp(−π/4) ω = 0.456 ω of second
order.
"""

import functools
import math
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from shockpc.core.number import number_within
from shockpc.core.pulse import SHAPES, Pulse, peak_acceleration
from shockpc.core.spatial import Array

ComplexArray: TypeAlias = np.ndarray[Any, np.dtype[np.complex128]]

FREQUENCY = {"Hz": 1.0, "kHz": 1e3}
"""Units of frequencies [Hz]."""

LOWEST, HIGHEST = 1e-3, 1e9
"""Frequency of a filter [Hz]."""

SETTLES = 1.0
"""Times 1/f after the end of a motion until which its filtered peak is looked for: the filter lags
by up to 0.2.
"""

SAMPLES, ZOOMS = 1001, 3
"""Number of times at which the response to a pulse is computed, in a part of it and then between
the two beside the largest, and how often it is so narrowed.
"""

TERMS = 20
"""Terms of the series of the exponential function, up to an argument of 1."""


class LowPass(NamedTuple):
    """A low-pass filter.

    Attributes:
        frequency: at which it lets pass 1/√2, its bandwidth [Hz].
        order: 1, or 2 for a Butterworth filter.
    """

    frequency: float
    order: int

    def __str__(self) -> str:
        return f"{self.frequency:g} Hz, {'first' if self.order == 1 else 'second'} order"

    @property
    def tail(self) -> float:
        """Time after the end of a motion until which its filtered peak is looked for [s]."""
        return SETTLES / self.frequency

    @property
    def bound(self) -> float:
        """Largest reading for a unit change of velocity by a pulse of one sign [1/s].

        It holds for any length of the pulse.
        """
        omega = 2.0 * math.pi * self.frequency
        if self.order == 1:
            return omega
        return omega * math.exp(-math.pi / 4.0)

    @property
    def poles(self) -> tuple[ComplexArray, ComplexArray]:
        """Poles (order,) of the transfer function, and its residues there [1/s].

        The pole above the real axis comes first.
        """
        omega = 2.0 * math.pi * self.frequency
        if self.order == 1:
            return np.array([complex(-omega)]), np.array([complex(omega)])
        pole = omega * complex(-1.0, 1.0) / math.sqrt(2.0)
        residue = omega**2 / (2.0j * pole.imag)
        poles = np.array([pole, pole.conjugate()])
        residues = np.array([residue, residue.conjugate()])
        return poles, residues


@functools.lru_cache(maxsize=256)
def low_pass_from(text: str) -> LowPass:
    """A filter from its text: "200Hz", "0.2kHz:1" or "200Hz:2".

    Without an order it is of first order.

    Raises:
        ValueError: it has no frequency from 1 mHz to 1 GHz, or another order.
    """
    frequency, colon, order = text.partition(":")
    try:
        hertz = number_within(frequency, FREQUENCY, LOWEST, HIGHEST)
        valid = not colon or order in ("1", "2")
    except ValueError:
        valid = False
    if not valid:
        raise ValueError(
            f'"{text}" is not a bandwidth; give a frequency from {LOWEST:g} to {HIGHEST:g} Hz, and '
            f":2 for a filter of second order "
            "(Butterworth), such as 200Hz, 200Hz:1 or 1.5kHz:2"
        )
    return LowPass(hertz, int(order or 1))


@functools.lru_cache(maxsize=256)
def pulse_reading(pulse: Pulse, low_pass: LowPass) -> float:
    """The largest reading for a pulse that changes a velocity by 1 m/s [1/s].

    It is sought at samples of the times within which the filter settles, and then between the
    samples beside the largest.
    """
    # The filter settles within the tail after each end of the pulse.
    length = pulse.length
    tail = low_pass.tail
    parts = ((0.0, min(length, tail)), (0.0, length), (length, length + tail))
    times = np.unique([np.linspace(start, end, SAMPLES) for start, end in parts])
    for _ in range(ZOOMS):
        largest = int(np.abs(_reading(pulse, low_pass, times)).argmax())
        start = times[max(largest - 1, 0)]
        end = times[min(largest + 1, len(times) - 1)]
        # The time of the largest stays among them: it may be a corner, as at the end of a pulse.
        times = np.sort(np.append(np.linspace(start, end, SAMPLES), times[largest]))
    peak = float(np.abs(_reading(pulse, low_pass, times)).max())
    return peak * SHAPES[pulse.shape] / length


def _reading(pulse: Pulse, low_pass: LowPass, t: Array) -> Array:
    """(n,) what the accelerometer reads at times [s], for a pulse with the peak 1.

    The response of the filter is the sum over its poles p of the residues r of the transfer
    function times the convolution c of exp(p t) with the pulse; after the pulse, which ends at T,
    c(t) = c(T) exp(p (t − T)).
    """
    during = np.minimum(t, pulse.length)
    after = np.maximum(t - pulse.length, 0.0)
    response = np.zeros(len(t), dtype=complex)
    for pole, residue in zip(*low_pass.poles, strict=True):
        response += residue * _convolution(pulse, pole, during) * np.exp(pole * after)
    return response.real


def _convolution(pulse: Pulse, pole: complex, t: Array) -> ComplexArray:
    """∫ exp(p (t − s)) a(s) ds from 0 to t (n,), of a pulse a with the peak 1 until its end."""
    turn = 1.0j * math.pi / pulse.length
    if pulse.shape == "half-sine":  # (exp(turn s) − exp(−turn s)) / 2i
        return (_of_exponential(turn, pole, t) - _of_exponential(-turn, pole, t)) / 2.0j
    if pulse.shape == "haversine":  # 1/2 − (exp(2 turn s) + exp(−2 turn s)) / 4
        swings = _of_exponential(2.0 * turn, pole, t) + _of_exponential(-2.0 * turn, pole, t)
        return _of_exponential(0.0j, pole, t) / 2.0 - swings / 4.0
    if pulse.shape == "rectangle":
        return _of_exponential(0.0j, pole, t)
    # The saw-tooth s / T: (exp(p t) − 1 − p t) / (p² T), as a series where digits would cancel.
    angle = pole * t
    series = np.zeros_like(angle)
    for k in range(TERMS, 1, -1):
        series = series * angle + 1.0 / math.factorial(k)
    is_small = np.abs(angle) < 1.0
    closed = np.where(is_small, series * angle**2, np.expm1(angle) - angle)
    return np.asarray(closed / (pole**2 * pulse.length))


def _of_exponential(rate: complex, pole: complex, t: Array) -> ComplexArray:
    """∫ exp(p (t − s)) exp(λ s) ds from 0 to t (n,): (exp(λ t) − exp(p t)) / (λ − p)."""
    return np.asarray(np.exp(rate * t) * np.expm1((pole - rate) * t) / (pole - rate))


def peak_of(pulse: Pulse | None, low_pass: LowPass | None) -> float:
    """Peak acceleration, or reading behind a filter, for a jump of velocity of 1 m/s [1/s].

    Without a pulse it is the bound of the filter, without either NaN.
    """
    if low_pass is None:
        return math.nan if pulse is None else peak_acceleration(1.0, pulse)
    return low_pass.bound if pulse is None else pulse_reading(pulse, low_pass)
