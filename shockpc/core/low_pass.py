"""What an accelerometer of a given bandwidth reads: accelerations behind a low-pass filter, in
closed form.

Between two events of a motion all forces are sums of oscillations. Behind a filter each of these is
multiplied by the transfer function at its rate λ, and oscillations of the filter's own poles join
the parts of the motion smoothly. What follows is again a motion in oscillations, whose peaks are
found as those of any other. Of first order the transfer function is ω / (s + ω), of second order
that of a Butterworth filter, ω² / (s² + √2 ω s + ω²); at the frequency f = ω / 2π both let pass
1/√2.

A pulse of one sign that changes a velocity by Δv makes at most h Δv, however short it is, with the
maximum h of the response to a unit impulse: ω of first order, exp(−π/4) ω = 0.456 ω of second
order.
"""

import functools
import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from shockpc.core.number import number_from
from shockpc.core.pulse import SHAPES, Pulse, peak_acceleration
from shockpc.core.spatial import Array

if TYPE_CHECKING:  # a scene needs only the filter
    from shockpc.core.stiff_motion import Segment, StiffMotion

LOWEST, HIGHEST = 1e-3, 1e9
"""Frequency of a filter [Hz]."""

TOGETHER = 1e-5
"""Share of a pole within which an oscillation, which is then moved by as much, has the rate of the
filter.
"""

SETTLES = 1.0
"""Times 1/f after the end of a motion until which its filtered peak is looked for: the filter lags
by up to 0.2.
"""

RAMP = 1e-4
"""Angle [rad] of a sine that stands for a ramp, which it is but for a share of RAMP²/6."""


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
        """Largest reading for a unit change of velocity by a pulse of one sign, whatever its length
        [1/s].
        """
        return (
            2.0 * math.pi * self.frequency * (1.0 if self.order == 1 else math.exp(-math.pi / 4.0))
        )

    def _pole(self) -> complex:
        omega = 2.0 * math.pi * self.frequency
        return complex(-omega) if self.order == 1 else omega * complex(-1.0, 1.0) / math.sqrt(2.0)


@functools.lru_cache(maxsize=256)
def low_pass_from(text: str) -> LowPass:
    """A filter from its text: "200Hz", "0.2kHz:1" or "200Hz:2"; without an order it is of first
    order.

    Raises:
        ValueError: it has no frequency from 1 mHz to 1 GHz, or another order.
    """
    frequency, colon, order = text.partition(":")
    try:
        hertz = number_from(frequency, {"Hz": 1.0, "kHz": 1e3})
    except ValueError:
        hertz = math.nan
    if (colon and order not in ("1", "2")) or not LOWEST <= hertz <= HIGHEST:
        raise ValueError(
            f'"{text}" is not a bandwidth; give a frequency from {LOWEST:g} to {HIGHEST:g} Hz, and '
            f":2 for a filter of second order "
            "(Butterworth), such as 200Hz, 200Hz:1 or 1.5kHz:2"
        )
    return LowPass(hertz, int(order or 1))


def filtered(motion: "StiffMotion", low_pass: LowPass, tail: float = 0.0) -> "StiffMotion":
    """A motion whose forces are those behind a filter, so that what follows from them is what an
    accelerometer reads.

    Before the impact the filter has settled on the forces of the springs between bodies and of the
    motors.

    Args:
        motion: the motion.
        low_pass: the filter.
        tail: time that is added at the end, without forces [s].
    """
    from shockpc.core.stiff_motion import Segment

    segments = motion.segments
    if tail:
        last, no_waves = segments[-1], np.zeros((len(motion.elements.rows), 0), dtype=complex)
        jump, displacement = last.after(np.asarray(last.length))
        at_rest = np.zeros_like(last.acceleration)
        segments += (
            Segment(
                start=motion.duration,
                length=tail,
                rate=np.zeros(0, dtype=complex),
                level=np.zeros_like(last.level),
                wave=no_waves,
                swing=np.zeros((len(jump), 0), dtype=complex),
                drift=at_rest,
                acceleration=at_rest,
                jump=jump,
                displacement=displacement,
            ),
        )
    at_first = segments[0].forces(np.zeros(()))
    value = np.where(motion.elements.contact < 0, at_first, 0.0)
    rate = np.zeros_like(value)
    pieces = []
    for segment in segments:
        piece, value, rate = _filtered(segment, low_pass, value, rate)
        pieces.append(piece)
    return motion._replace(segments=tuple(pieces))


def _filtered(
    segment: "Segment", low_pass: LowPass, value: Array, rate: Array
) -> tuple["Segment", Array, Array]:
    """A segment behind a filter, and the filtered forces (r,) and their rates at its end.

    Args: both at its start.
    """
    pole = low_pass._pole()
    poles = np.array([pole, pole.conjugate()])[: low_pass.order]
    rates = segment.rate
    # Oscillations that decay as those of the filter do would have terms t exp(λt).
    gaps = np.abs(rates[:, None] - poles).min(axis=1)
    rates = np.where(gaps < TOGETHER * abs(pole), rates * (1.0 + 2.0 * TOGETHER), rates)
    passed = np.prod(-poles / (rates[:, None] - poles), axis=1)
    wave = segment.wave * passed
    missing = value - segment.level - wave.real.sum(axis=1)
    own = missing + 0.0j
    if low_pass.order == 2:
        own -= 1.0j * (rate - (rates * wave).real.sum(axis=1) - pole.real * missing) / pole.imag
    rates, wave = np.append(rates, pole), np.column_stack([wave, own])
    end = wave * np.exp(rates * segment.length)
    swing = np.pad(segment.swing, ((0, 0), (0, 1)))
    piece = segment._replace(rate=rates, wave=wave, swing=swing)
    return piece, segment.level + end.real.sum(axis=1), (rates * end).real.sum(axis=1)


@functools.lru_cache(maxsize=256)
def pulse_reading(pulse: Pulse, low_pass: LowPass) -> float:
    """The largest reading for a pulse that changes a velocity by 1 m/s [1/s]; the saw-tooth has its
    peak at the end.
    """
    from shockpc.core.crossing import Effort
    from shockpc.core.stiff_motion import Segment, largest_lengths

    T = pulse.length
    # Of each shape the constant part, the rate and the amplitude of its oscillation.
    level, rate, wave = {
        "half-sine": (0.0, 1.0j * math.pi / T, -1.0j),
        "haversine": (0.5, 2.0j * math.pi / T, -0.5 + 0.0j),
        "rectangle": (1.0, 0.0j, 0.0j),
        "saw-tooth": (0.0, 1.0j * RAMP / T, -1.0j / math.sin(RAMP)),
    }[pulse.shape]
    none, still = np.zeros(1), np.zeros((1, 1), dtype=complex)
    during = Segment(
        0.0, T, np.array([rate]), none + level, np.array([[wave]]), still, none, none, none, none
    )
    first, value, slope = _filtered(during, low_pass, none, none)
    after = during._replace(start=T, length=low_pass.tail, level=none, wave=still)
    pieces = [
        piece
        for segment in (first, _filtered(after, low_pass, value, slope)[0])
        for piece in segment.pieces()
    ]
    peak = largest_lengths(np.ones((1, 1, 1)), pieces, none, Effort())[0][0]
    return float(peak) * SHAPES[pulse.shape] / T


def peak_of(pulse: Pulse | None, low_pass: LowPass | None) -> float:
    """Peak acceleration, or reading behind a filter, for a jump of velocity of 1 m/s [1/s].

    Without a pulse it is the bound of the filter, without either NaN.
    """
    if low_pass is None:
        return math.nan if pulse is None else peak_acceleration(1.0, pulse)
    return low_pass.bound if pulse is None else pulse_reading(pulse, low_pass)
