"""From a jump in velocity to a peak acceleration, for the pulse shapes of IEC 60068-2-27.

The rigid-body model gives Δv; how long the impact lasts is the weakest input of all, so the jump is
always reported first.
"""

import math
from typing import NamedTuple

from shockpc.core.number import number_from

SHAPES = {"half-sine": math.pi / 2.0, "saw-tooth": 2.0, "haversine": 2.0, "rectangle": 1.0}
"""Peak over mean acceleration of each shape."""

UNITS = {"us": 1e-6, "\u00b5s": 1e-6, "\u03bcs": 1e-6, "ms": 1e-3, "s": 1.0}
"""Units of a length in seconds; microseconds with the micro sign or the Greek letter."""


class Pulse(NamedTuple):
    """A pulse of acceleration: a shape of `SHAPES` and its length [s]."""

    shape: str
    length: float


def peak_acceleration(delta_v: float, pulse: Pulse) -> float:
    """Peak acceleration [m/s²] of a pulse that changes a velocity by delta_v [m/s].

    For a half-sine of length T it is π Δv / (2T).
    """
    return SHAPES[pulse.shape] * delta_v / pulse.length


def velocity_change(peak: float, pulse: Pulse) -> float:
    """Velocity change [m/s] of a pulse with a peak acceleration [m/s²].

    For a half-sine of peak A and length T it is 2AT/π.
    """
    return peak * pulse.length / SHAPES[pulse.shape]


SHORTEST, LONGEST = 1e-9, 1e3
"""Length of a pulse [s]."""


def pulse_from(text: str) -> Pulse:
    """A pulse from its text, such as "half-sine:5ms".

    Raises:
        ValueError: it has no known shape, or no length from 1 ns to 1000 s.
    """
    shape, _, length = text.partition(":")
    valid = f"valid are {', '.join(SHAPES)}, with a length such as half-sine:5ms"
    if shape not in SHAPES:
        raise ValueError(f'there is no pulse shape "{shape}"; {valid}')
    try:
        seconds = number_from(length, UNITS)
    except ValueError:
        raise ValueError(f'"{length}" is not the length of a pulse; {valid}') from None
    if not SHORTEST <= seconds <= LONGEST:
        raise ValueError(
            f'a pulse has a length from {SHORTEST:g} to {LONGEST:g} s, not "{length}"; {valid}'
        )
    return Pulse(shape, seconds)
