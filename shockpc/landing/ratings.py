"""What parts withstand: a rating as a text, the damage boundary that follows from it, and the torques of joints.

Damage boundary (Newton 1968; ASTM D3332): no pulse damages a part whose velocity change is below the critical one, and none whose
peak acceleration is below the critical one. Both follow from the largest acceleration R that a part of one natural frequency f
survives, without damping: a short pulse of velocity change V makes it respond with 2π f V, and a single pulse of peak A with 2 A at
most. A pulse that it survived shows such an R where f is known. Where f is not known, a longer pulse with a smaller velocity change
is survived too, whatever f is, because the response divided by f T falls with f T; a shorter one, if its peak is also below half of
the peak survived.
"""

import math
import re
from typing import NamedTuple

import numpy as np

from shockpc.core.pulse import SHAPES, Pulse, pulse_from, velocity_change
from shockpc.core.spatial import Array
from shockpc.core.spectrum import amplification
from shockpc.landing.scene import GRAVITY, Part
from shockpc.robot.robot import Robot
from shockpc.text.errors import SceneError
from shockpc.text.printed import printable
from shockpc.text.toml import LARGEST

IMPULSIVE = 0.3
"""Length of a pulse in periods of a part, below which only its velocity change counts."""

CHANGES = {"half-sine": "2AT/π", "saw-tooth": "AT/2", "haversine": "AT/2", "rectangle": "AT"}
"""Velocity change of each shape with peak A and length T."""

UNLIMITED = 1e300
"""Effort from which a limit of a file is none [N m, N]."""


class Strength(NamedTuple):
    """The damage boundary of a part.

    Attributes:
        velocity_change: critical, or a lower bound of it [m/s].
        acceleration: the same [g]; NaN where it is not known.
        both: whether a landing has to be below both, because only a survived pulse is known; else one of them is enough.
        basis: what the numbers follow from, and what is assumed.
    """

    velocity_change: float
    acceleration: float
    both: bool
    basis: str


def strength(part: Part) -> Strength:
    """The damage boundary of a part that is mounted at a point.

    Raises:
        SceneError: it has no rating and no critical velocity change, or one that is not valid.
    """
    _check(part, "critical_velocity_change", "natural_frequency")
    given, f = part.critical_velocity_change, part.natural_frequency
    if part.rating is None and given is None:
        raise SceneError(
            f'part "{printable(part.name)}" does not say what it withstands; give a rating, such as "half-sine 1500 g 0.5 ms", '
            "or a critical_velocity_change [m/s]"
        )
    pulse, peak = _rating(part) if part.rating is not None else (Pulse("half-sine", math.nan), math.nan)
    survived = velocity_change(peak * GRAVITY, pulse)
    if f is not None:
        largest = 0.0 if given is None else 2.0 * math.pi * f * given / GRAVITY
        if part.rating is not None:
            largest = max(largest, peak * amplification(pulse.shape, f * pulse.length))
        basis = f"lower bounds from the response of {largest:.3g} g at {f:g} Hz without damping, which it survives"
        return Strength(largest * GRAVITY / (2.0 * math.pi * f), largest / 2.0, False, basis)
    if given is not None:
        # A pulse survived beyond the critical velocity change had a peak below the critical acceleration.
        slow = survived > given
        return Strength(
            given, peak / 2.0 if slow else math.nan, False, "as given" + f", and half of the {peak:g} g survived" * slow
        )
    basis = (
        f"{CHANGES[pulse.shape]} of the pulse survived, a lower bound of the critical velocity change for pulses of its shape of "
        f"{1e3 * pulse.length:.3g} ms or more, or natural frequencies below {IMPULSIVE / pulse.length:.4g} Hz; the peak, if it "
        "is known, also has to be below half of the one survived"
    )
    return Strength(survived, peak / 2.0, True, basis)


def torque_limits(robot: Robot, parts: tuple[Part, ...]) -> tuple[Array, Array]:
    """What the joints withstand: momentary torque (nv,) [N m, N] and its duration (nv,) [s]; NaN where there is none.

    Raises:
        UnknownName: a pattern fits no joint.
        SceneError: a number is not valid.
    """
    limit = np.array(robot.model.upperEffortLimit, dtype=float)
    limit[~((limit > 0.0) & (limit < UNLIMITED))] = np.nan
    duration = np.full(len(limit), np.nan)
    for part in parts:
        _check(part, "momentary_torque", "torque_duration")
        for name in robot.match_joints(part.joint) if part.joint is not None else ():
            v = robot.joint(name).v
            limit[v] = limit[v] if part.momentary_torque is None else part.momentary_torque
            duration[v] = duration[v] if part.torque_duration is None else part.torque_duration
    return limit, duration


def check_parts(parts: tuple[Part, ...]) -> None:
    """Refuse parts of one name, and those that are neither at a point nor of joints.

    Raises:
        SceneError: the text says what would be valid.
    """
    names = [part.name for part in parts]
    for part in parts:
        name = printable(part.name)
        if names.count(part.name) > 1:
            raise SceneError(f'two parts are called "{name}"; rename one of them')
        of_a_point = [part.rating, part.critical_velocity_change, part.natural_frequency]
        of_a_joint = [part.momentary_torque, part.torque_duration]
        if (part.at is None) == (part.joint is None):
            raise SceneError(f'part "{name}" needs a place: at = "FRAME:x,y,z", or joint = "NAME" for the gears of joints')
        if any(value is not None for value in (of_a_joint if part.joint is None else of_a_point)):
            raise SceneError(
                f'part "{name}": a part at a frame takes rating, critical_velocity_change and natural_frequency, and one of joints '
                "momentary_torque and torque_duration"
            )


def _rating(part: Part) -> tuple[Pulse, float]:
    """The pulse of a rating, and its peak [g]."""
    refusal = SceneError(
        f'part "{printable(part.name)}": rating "{printable(part.rating or "", 60)}" cannot be read; give a shape '
        f'({", ".join(SHAPES)}), a peak in g and a length in s, ms or µs, both above zero, such as "half-sine 1500 g 0.5 ms"'
    )
    found = re.fullmatch(r"(\S+)\s+(\S+?)\s*g\s+([^\s:]+?)\s*(us|µs|ms|s)", (part.rating or "").strip())
    if found is None:
        raise refusal
    shape, peak, length, unit = found.groups()
    try:
        pulse, size = pulse_from(f"{shape}:{length}{unit}"), float(peak)
    except ValueError:
        raise refusal from None
    if not (1.0 / LARGEST <= size <= LARGEST and 1.0 / LARGEST <= pulse.length <= LARGEST):
        raise refusal
    return pulse, size


def _check(part: Part, *keys: str) -> None:
    """Refuse numbers that are not above zero."""
    for key in keys:
        value = getattr(part, key)
        if value is not None and not value >= 1.0 / LARGEST:
            raise SceneError(f'part "{printable(part.name)}": {key} is {value:g}, and it has to be above zero')
