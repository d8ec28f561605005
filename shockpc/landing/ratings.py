"""The strength of parts.

It is a rating as a text, the damage boundary that follows from it, and the torques of joints.

Damage boundary (Newton 1968; ASTM D3332): no pulse damages a part whose velocity change is below
the critical one, and none whose peak acceleration is below the critical one. Both follow from the
largest acceleration R that a part of one natural frequency f survives, without damping: a short
pulse of velocity change V makes it respond with 2π f V, and a single pulse of peak A with 2 A at
most. A pulse that it survived shows such an R where f is known. Where f is not known, a longer
pulse with a smaller velocity change is survived too, whatever f is, because the response divided by
f T falls with f T; a shorter one, if its peak is also below half of the peak survived.
"""

import math
import re
from typing import NamedTuple

import numpy as np

from shockpc.core.number import NO_UNIT, number_within
from shockpc.core.pulse import SHAPES, UNITS, Pulse, pulse_from, velocity_change
from shockpc.core.spatial import Array
from shockpc.core.spectrum import amplification
from shockpc.landing.scenes.scene import Part
from shockpc.landing.scenes.strike import GRAVITY
from shockpc.robot.drives.motors import effort_limits
from shockpc.robot.robot import Robot
from shockpc.text.arguments import LARGEST_NUMBER
from shockpc.text.errors import SceneError
from shockpc.text.printed import printable

IMPULSIVE = 0.3
"""Length of a pulse in periods of a part, below which only its velocity change matters."""

CHANGES = {"half-sine": "2AT/π", "saw-tooth": "AT/2", "haversine": "AT/2", "rectangle": "AT"}
"""Velocity change of each shape with peak A and length T."""


_ABOVE_ZERO = 1.0 / LARGEST_NUMBER, LARGEST_NUMBER
"""Bounds of a number that has to be above zero."""

_UNIT = "|".join(UNITS)
_TIME = rf"(\S+?\s*(?:{_UNIT}))"
_TORQUE = re.compile(rf"(\S+?)\s*(N\s*m|N)(?:\s+{_TIME})?")
_PULSE = re.compile(rf"(\S+)\s+(\S+?)\s*g\s+([^\s:]+?\s*(?:{_UNIT}))")
_WITH_BANDWIDTH = re.compile(r"(.*s)\s+(\S+\s*Hz\S*)")


class Strength(NamedTuple):
    """The damage boundary of a part.

    Attributes:
        velocity_change: critical, or a lower bound of it [m/s].
        acceleration: the same [g]; NaN where it is not known.
        both: whether a landing has to be below both, because only a survived pulse is known; else
            one of them is enough.
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
    critical, f = part.critical_velocity_change, part.natural_frequency
    if part.rating is None and critical is None:
        raise SceneError(
            f'part "{printable(part.name)}" has no strength; give a rating, such as "half-sine '
            '1500 g 0.5 ms", or a critical_velocity_change [m/s]'
        )
    pulse, peak = (
        _rating(part) if part.rating is not None else (Pulse("half-sine", math.nan), math.nan)
    )
    survived = velocity_change(peak * GRAVITY, pulse)
    if f is not None:
        # An oscillator of frequency f responds to a short pulse with 2π f Δv.
        largest = 0.0
        if critical is not None:
            largest = 2.0 * math.pi * f * critical / GRAVITY
        if part.rating is not None:
            largest = max(largest, peak * amplification(pulse.shape, f * pulse.length))
        basis = (
            f"lower bounds: the part survived a response of {largest:.3g} g at {f:g} Hz without "
            f"damping"
        )
        return Strength(largest * GRAVITY / (2.0 * math.pi * f), largest / 2.0, False, basis)
    if critical is not None:
        basis = "as given, the boundary of damage by short pulses"
        if part.rating is not None:
            basis += "; with a natural_frequency the pulse survived gives a critical peak too"
        return Strength(critical, math.nan, False, basis)
    basis = (
        f"survived {survived:.4g} m/s ({CHANGES[pulse.shape]}), a lower bound of the critical "
        f"velocity change "
        f"for pulses of this shape of {1e3 * pulse.length:.3g} ms or more, or natural frequencies "
        f"below "
        f"{IMPULSIVE / pulse.length:.4g} Hz. Only half of its {peak:g} g counts, because a "
        f"resonant part may "
        "feel twice the peak of its base"
    )
    return Strength(survived, peak / 2.0, True, basis)


class TorqueStrength(NamedTuple):
    """The strength of a joint, according to a part.

    Attributes:
        momentary_torque: that it bears; NaN where it is not known [N m, N].
        duration: for which it does; NaN where it is not known [s].
        in_part: whether the part gives the torque; else it is the effort limit of the robot's file.
    """

    momentary_torque: float
    duration: float
    in_part: bool


def torque_strength(robot: Robot, part: Part, joint: str) -> TorqueStrength:
    """The strength of a joint, according to a part of joints.

    It is the part's torque, else the effort limit of the robot's file.

    Raises:
        UnknownName: the robot has no such joint.
        SceneError: a number of the part is not valid.
    """
    _check(part, "momentary_torque", "torque_duration")
    torque = part.momentary_torque
    if torque is None:
        first = robot.joint(joint).v.start
        torque = float(effort_limits(robot)[first])
    duration = math.nan if part.torque_duration is None else part.torque_duration
    return TorqueStrength(torque, duration, part.momentary_torque is not None)


def part_from(robot: Robot, at: str, rating: str) -> Part:
    """A part as it is typed: a frame and a pulse, or joints and the torque that they withstand.

    A torque is such as "50 N m" or "50 N m 20 ms". Behind a pulse may stand the bandwidth of a part
    that is an accelerometer, as in "half-sine 1500 g 0.5 ms 200Hz:2".

    Raises:
        UnknownName: a torque is given, and the robot has no such joint.
        SceneError: the torque is no number above zero, or has the unit of another kind of joint.
    """
    matched = _TORQUE.fullmatch(rating.strip())
    if matched is None:
        return _part_at_frame(at, rating)
    torque, unit, length = matched.groups()
    duration = None
    try:
        momentary_torque = number_within(torque, NO_UNIT, *_ABOVE_ZERO)
        if length is not None:
            duration = number_within(length, UNITS, *_ABOVE_ZERO)
    except ValueError:
        raise SceneError(
            f'part "{printable(at)}": torque "{printable(rating, 60)}" cannot be read; give '
            'numbers above zero, such as "50 N m", or "50 N m 20 ms" with the duration for which '
            "the joint withstands it"
        ) from None
    for name in robot.match_joints(at):
        right = "N" if robot.joint(name).kind == "prismatic" else "N m"
        if unit.replace(" ", "") != right.replace(" ", ""):
            raise SceneError(
                f'part "{printable(at)}": the load of joint "{name}" is in {right}, and "{rating}" '
                f"is in {unit}"
            )
    return Part(name=at, joint=at, momentary_torque=momentary_torque, torque_duration=duration)


def _part_at_frame(at: str, rating: str) -> Part:
    """A part at a frame: a pulse, and the bandwidth of a sensor if one stands behind it."""
    matched = _WITH_BANDWIDTH.fullmatch(rating.strip())
    if matched is None:
        return Part(name=at, at=at, rating=rating)
    return Part(name=at, at=at, rating=matched[1], imu_bandwidth=matched[2])


def torque_limits(robot: Robot, parts: tuple[Part, ...]) -> tuple[Array, Array]:
    """The strength of the joints: momentary torque (nv,) [N m, N] and its duration (nv,) [s].

    NaN where there is none.

    Raises:
        UnknownName: a pattern fits no joint.
        SceneError: a number is not valid.
    """
    limit = effort_limits(robot)
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
        of_a_point = [
            part.rating,
            part.critical_velocity_change,
            part.natural_frequency,
            part.imu_bandwidth,
        ]
        of_a_joint = [part.momentary_torque, part.torque_duration]
        if (part.at is None) == (part.joint is None):
            raise SceneError(
                f'part "{name}" needs a place: at = "FRAME:x,y,z", or joint = "NAME" for the gears '
                f"of joints"
            )
        unfit = of_a_joint if part.joint is None else of_a_point
        if any(value is not None for value in unfit):
            raise SceneError(
                f'part "{name}": a part at a frame takes rating, critical_velocity_change, '
                "natural_frequency and imu_bandwidth; a part that is a joint takes "
                "momentary_torque and torque_duration"
            )


def _rating(part: Part) -> tuple[Pulse, float]:
    """The pulse of a rating, and its peak [g]."""
    refusal = SceneError(
        f'part "{printable(part.name)}": rating "{printable(part.rating or "", 60)}" cannot be '
        f"read; give a shape "
        f"({', '.join(SHAPES)}), a peak in g and a length in s, ms or µs, both above zero, such as "
        f'"half-sine 1500 g 0.5 ms"'
    )
    matched = _PULSE.fullmatch((part.rating or "").strip())
    if matched is None:
        raise refusal
    shape, peak, length = matched.groups()
    try:
        return pulse_from(f"{shape}:{length}"), number_within(peak, NO_UNIT, *_ABOVE_ZERO)
    except ValueError:
        raise refusal from None


def _check(part: Part, *keys: str) -> None:
    """Refuse numbers that are not above zero."""
    for key in keys:
        value = getattr(part, key)
        if value is not None and not value >= 1.0 / LARGEST_NUMBER:
            raise SceneError(
                f'part "{printable(part.name)}": {key} is {value:g}, and it has to be above zero'
            )
