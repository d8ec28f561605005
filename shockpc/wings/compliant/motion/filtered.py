"""A motion behind a low-pass filter, in closed form.

Between two events of a motion all forces are sums of oscillations. Behind a filter each of these is
multiplied by the transfer function at its rate λ, and oscillations of the filter's own poles join
the parts of the motion smoothly. What follows is again a motion in oscillations, whose peaks are
found as those of any other.
"""

import numpy as np

from shockpc.core.low_pass import LowPass
from shockpc.core.spatial import Array
from shockpc.wings.compliant.motion.segment import Segment
from shockpc.wings.compliant.motion.stiff_motion import StiffMotion

TOGETHER = 1e-5
"""Share of a pole within which an oscillation has the rate of the filter.

The oscillation is moved by as much then.
"""


def filtered(motion: StiffMotion, low_pass: LowPass, tail: float = 0.0) -> StiffMotion:
    """A motion whose forces are those behind a filter.

    What follows from them is what an accelerometer reads.

    Before the impact the filter has settled on the forces of the springs between bodies and of the
    motors.

    Args:
        motion: the motion.
        low_pass: the filter.
        tail: time that is added at the end, without forces [s].
    """
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
    segment: Segment, low_pass: LowPass, value: Array, rate: Array
) -> tuple[Segment, Array, Array]:
    """A segment behind a filter, and the filtered forces (r,) and their rates at its end.

    Args: both at its start.
    """
    poles, _ = low_pass.poles
    pole = poles[0]
    rates = segment.rate
    # Oscillations that decay as those of the filter do would have terms t exp(λt).
    gaps = np.abs(rates[:, None] - poles).min(axis=1)
    close = gaps < TOGETHER * abs(pole)
    rates = np.where(close, rates * (1.0 + 2.0 * TOGETHER), rates)
    # Π −pole / (λ − pole), of each oscillation
    passed = np.prod(-poles / (rates[:, None] - poles), axis=1)
    wave = segment.wave * passed
    missing = value - segment.level - wave.real.sum(axis=1)
    own = missing + 0.0j
    if low_pass.order == 2:
        # Re(own exp(pole t)) has the missing value and, with that, the missing rate.
        missing_rate = rate - (rates * wave).real.sum(axis=1)
        own -= 1.0j * (missing_rate - pole.real * missing) / pole.imag
    rates, wave = np.append(rates, pole), np.column_stack([wave, own])
    end = wave * np.exp(rates * segment.length)
    swing = np.pad(segment.swing, ((0, 0), (0, 1)))
    piece = segment._replace(rate=rates, wave=wave, swing=swing)
    return piece, segment.level + end.real.sum(axis=1), (rates * end).real.sum(axis=1)
