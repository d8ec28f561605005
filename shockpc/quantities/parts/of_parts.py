"""Quantities of parts: margins by velocity change, by acceleration and by torque."""

from collections.abc import Callable
from typing import Any

import numpy as np

from shockpc.core.percussion import norm
from shockpc.core.pulse import Pulse, peak_acceleration
from shockpc.core.spatial import Array
from shockpc.impact.impact import Impact
from shockpc.impact.landing_motion import motion_of
from shockpc.landing.landing import PosedLanding
from shockpc.landing.places import Place, joint_places
from shockpc.landing.ratings import (
    Strength,
    TorqueStrength,
    strength,
    torque_limits,
    torque_strength,
)
from shockpc.landing.scenes.strike import GRAVITY
from shockpc.quantities.of_joints import MULTIAXIAL, REDUNDANT
from shockpc.quantities.of_points import (
    DELTA_V,
    NEEDS_PULSE,
    SHOCK,
    lacks_bandwidth,
    largest_reading,
    point_velocity,
    pulse_peak,
    readings,
)
from shockpc.quantities.parts.peaks import ALONG, joint_peaks, point_peaks
from shockpc.quantities.quantity import EXACT_IF_RIGID, Places, Quantity, Scope, largest_jump

NO_PULSE = "the scene gives neither a pulse nor a contact stiffness"
NO_TORQUE = "no torque or effort limit is known"
NO_TIME = (
    f"{NO_PULSE}, nor the part the duration of its torque; or the joint has a spring whose torque "
    f"is not computed"
)
NEEDS_TORQUE, NEEDS_TIME = "needs a momentary torque", "needs a pulse, stiffness or duration"
NEEDS_ROTOR, NEEDS_STIFFNESS = "needs the rotor of its spring", "needs a contact stiffness"
REMEDIES = {
    NEEDS_TORQUE: (
        "; give the part a momentary_torque, because no effort limit above zero of its joint is "
        "read from the file"
    ),
    NEEDS_TIME: "; give the scene a pulse or a contact stiffness, or the part a torque_duration",
    NEEDS_ROTOR: (
        ", which decides the spring's torque; give it with --rotor, and a contact stiffness"
    ),
    NEEDS_STIFFNESS: ", because its spring gives its torque after the instant of the impact",
}
"""Remedies where a part of a joint has no margin, by reason."""

OF_A_JOINT, OF_A_POINT = "the part is of a joint", "the part is at a point"

Compute = Callable[[Impact, Places], Any]


def _only(
    has_value: Callable[[Place], bool], compute: Compute, components: tuple[int, ...]
) -> Compute:
    """A formula of some of the parts: no value at the others.

    Args:
        has_value: whether a part has a value.
        compute: the formula.
        components: (3,) of a vector, () of a number.
    """

    def of_some(impact: Impact, places: Places) -> Any:
        with_value = [k for k, place in enumerate(places) if has_value(place)]
        if with_value and len(with_value) == len(places):
            return compute(impact, places)
        if not with_value:
            return np.full((1, 1, len(places), *components), np.nan)
        values = compute(impact, [places[k] for k in with_value])
        shape = (*values.shape[:2], len(places), *components)
        out = np.full(shape, np.nan, dtype=values.dtype)
        out[:, :, with_value] = values
        return out

    return of_some


def _of_points(compute: Compute, components: tuple[int, ...] = ()) -> Compute:
    """A formula of parts at points: no value at those of joints."""
    return _only(lambda place: place.joint < 0, compute, components)


def _of_joints(compute: Compute) -> Compute:
    """A formula of parts of joints: no value at those at points."""
    return _only(lambda place: place.joint >= 0, compute, ())


def _strengths(landing: PosedLanding, places: Places) -> list[Strength]:
    """The damage boundaries of parts at points."""
    return [strength(landing.scene.part[place.number]) for place in places]


def _torque_strengths(landing: PosedLanding, places: Places) -> list[TorqueStrength]:
    """The torques that parts of joints withstand."""
    strengths = []
    for place, joint in zip(places, _joints(landing, places), strict=True):
        part = landing.scene.part[place.number]
        strengths.append(torque_strength(landing.robot, part, joint.name))
    return strengths


def _joints(landing: PosedLanding, places: Places) -> list[Place]:
    """The joints of parts."""
    joints = {place.number: place for place in joint_places(landing.robot)}
    return [joints[place.joint] for place in places]


def _quotient(impact: Impact, critical: list[float], values: Any, size: float) -> Any:
    """Critical values over actual ones (N, S, n).

    It is infinite where there is no load, and NaN where one of the two is not known.
    """
    numbers = impact.rounded(values, lambda _: size)
    known = np.isfinite(np.array(critical))
    loaded = known & ~np.isnan(numbers) & (numbers != 0.0)
    unloaded = np.where(known & (numbers == 0.0), np.inf, np.nan)
    quotient = impact.exact(np.where(known, critical, 0.0)) / np.where(loaded, values, 1.0)
    return np.where(loaded, quotient, unloaded)


def _velocity_margin(impact: Impact, places: Places) -> Any:
    """Critical velocity changes over |Δv| (N, S, n); infinite where a part does not move."""
    critical = [strength.velocity_change for strength in _strengths(impact.landing, places)]
    speed = norm(point_velocity(impact, places))
    return _quotient(impact, critical, speed, largest_jump(impact, speed))


def pulse_of_parts(landing: PosedLanding) -> Pulse | None:
    """The scene's pulse, by which parts and torques are judged.

    Returns: None in a landing that lasts, which gives the peaks.
    """
    return None if landing.scene.yields else landing.pulse


def _peak(impact: Impact, places: Places) -> Any:
    """Peak accelerations (N, S, n) of a landing that lasts, else for the pulse [g]."""
    motion = motion_of(impact.landing)
    if motion is None:
        return pulse_peak(impact, places)
    peaks, _ = point_peaks(motion, places)
    return peaks[None, None] / GRAVITY


def _largest_peak(impact: Impact, values: Array) -> float:
    """The largest component of a jump of a body as a peak [g]."""
    pulse = pulse_of_parts(impact.landing)
    if pulse is None:
        return 0.0
    return peak_acceleration(largest_jump(impact, values), pulse) / GRAVITY


def _lacks_peak(landing: PosedLanding) -> str:
    """Message of what a landing lacks for a peak of a part; empty if nothing."""
    if landing.pulse or landing.scene.yields:
        return ""
    return f"{NEEDS_PULSE}, or a contact stiffness"


def _acceleration_margin(impact: Impact, places: Places) -> Any:
    """Critical accelerations over peaks (N, S, n)."""
    critical = [strength.acceleration for strength in _strengths(impact.landing, places)]
    peak = _peak(impact, places)
    return _quotient(impact, critical, peak, _largest_peak(impact, peak))


def _point_margin(impact: Impact, places: Places) -> Any:
    """Margins (N, S, n) of parts at points.

    It is the lesser of the two where a part has to be below both, else the greater; that of the
    velocity change where no peak is known.
    """
    by_velocity = _velocity_margin(impact, places)
    by_acceleration = _acceleration_margin(impact, places)
    velocity = impact.rounded(by_velocity, lambda _: 0.0)
    acceleration = impact.rounded(by_acceleration, lambda _: 0.0)
    both = np.array([strength.both for strength in _strengths(impact.landing, places)])
    governs = np.where(both, velocity <= acceleration, velocity >= acceleration)
    return np.where(governs | np.isnan(acceleration), by_velocity, by_acceleration)


def _torque(impact: Impact, places: Places, durations: Array) -> Any:
    """Torques (N, S, n) along the axes of joints; NaN where they are not known [N m, N].

    The torque is the peak of a landing that lasts; else the impulse along the axis gives the
    peak of a pulse as the scene has it, or the mean over a duration.

    Args:
        impact: the impact.
        places: the joints.
        durations: (n,) for which a part says that a joint withstands its torque [s]; NaN where none
            does.
    """
    motion = motion_of(impact.landing)
    if motion is not None:
        _, _, torques = joint_peaks(motion, places)
        return torques[None, None]
    impulse = ALONG.compute(impact, places)
    rates = _rates(impact, durations)
    numbers = impact.rounded(impulse, lambda values: ALONG.size(impact, values))
    # A spring before a rotor gives no impulse in the instant of the impact, but a torque
    # afterwards.
    stiffness = impact.landing.joint_model.drive_stiffness
    sprung = np.isfinite(stiffness[[place.number for place in places]])
    determined = impact.unique[:, None].all(axis=-1, keepdims=True)
    known = determined & ~np.isnan(numbers) & ~np.isnan(rates) & ~sprung
    size = np.where(numbers < 0.0, -impulse, impulse)
    torque = size * impact.exact(np.nan_to_num(rates))
    return np.where(known, torque, np.nan)


def _rates(impact: Impact, durations: Array) -> Array:
    """Torque (n,) for an impulse of 1 along the axis [1/s].

    It is the peak of the scene's pulse, else the mean over a duration (n,) [s].
    """
    pulse = pulse_of_parts(impact.landing)
    if pulse is None:
        return 1.0 / durations
    return np.full(len(durations), peak_acceleration(1.0, pulse))


def _torque_size(impact: Impact, durations: Array, values: Array) -> float:
    """The natural size of torques: that of the largest load, with the shortest duration."""
    largest_rate = np.nan_to_num(_rates(impact, durations)).max(initial=0.0)
    return float(ALONG.size(impact, values) * largest_rate)


def _part_torque(impact: Impact, places: Places) -> Any:
    """Torques (N, S, n) of parts of joints, as `_torque`."""
    landing = impact.landing
    durations = [strength.duration for strength in _torque_strengths(landing, places)]
    return _torque(impact, _joints(landing, places), np.array(durations))


def _part_torque_size(impact: Impact, values: Array) -> float:
    durations = [part.torque_duration or np.nan for part in impact.landing.scene.part]
    return _torque_size(impact, np.array(durations), values)


def _torque_margin(impact: Impact, places: Places) -> Any:
    """Momentary torques over actual ones (N, S, n)."""
    limits = [strength.momentary_torque for strength in _torque_strengths(impact.landing, places)]
    torque = _part_torque(impact, places)
    return _quotient(impact, limits, torque, _part_torque_size(impact, torque))


def part_margin(impact: Impact, places: Places) -> Any:
    """The governing margin (N, S, n) of parts; NaN where none is known."""
    of_joints = np.array([place.joint >= 0 for place in places])
    by_torque = _of_joints(_torque_margin)(impact, places)
    of_points = _of_points(_point_margin)(impact, places)
    return np.where(of_joints, by_torque, of_points)


def not_judged(landing: PosedLanding, place: Place, redundant: bool) -> str:
    """The reason why a part of a joint has no margin.

    Args: redundant, whether contacts or loops are.
    """
    (joint,) = _joints(landing, [place])
    (strength,) = _torque_strengths(landing, [place])
    if landing.robot.joint(joint.name).axis is None:
        return MULTIAXIAL
    if np.isnan(strength.momentary_torque):
        return NEEDS_TORQUE
    if np.isfinite(landing.joint_model.drive_stiffness[joint.number]):
        unknown = landing.joint_model.rotor_unknown[joint.number]
        return NEEDS_ROTOR if unknown else NEEDS_STIFFNESS
    return "contacts or loops are redundant" if redundant else NEEDS_TIME


def torque_share(impact: Impact, places: Places) -> Any:
    """Torque (N, S, n) along the axes of joints, of their momentary torques."""
    limits, durations = _limits(impact)
    numbers = [place.number for place in places]
    limit = limits[numbers]
    torque = _torque(impact, places, durations[numbers])
    known = ~np.isnan(torque.astype(float)) & ~np.isnan(limit)
    share = np.where(known, torque, 0.0) / impact.exact(np.where(np.isnan(limit), 1.0, limit))
    return np.where(known, share, np.nan)


def _limits(impact: Impact) -> tuple[Array, Array]:
    """The momentary torques (nv,) of joints [N m, N] and their durations (nv,) [s]."""
    return torque_limits(impact.landing.robot, impact.landing.scene.part)


def _share_size(impact: Impact, values: Array) -> float:
    limits, durations = _limits(impact)
    rates = np.nan_to_num(_rates(impact, durations) / limits)
    return float(ALONG.size(impact, values) * rates.max(initial=0.0))


PARTS = (
    *(
        entry._replace(
            of="part",
            scope=entry.scope._replace(missing=OF_A_JOINT, parts_of="point"),
            relations=entry.relations._replace(also=()),
            compute=_of_points(entry.compute, components),
        )
        for entry, components in ((DELTA_V, (3,)), (SHOCK, ()))
    ),
    Quantity(
        "velocity_margin",
        "part",
        "critical velocity change, of that of the part",
        "1",
        "less",
        _of_points(_velocity_margin),
        scope=Scope(OF_A_JOINT, parts_of="point"),
    ),
    Quantity(
        "peak_g",
        "part",
        "peak acceleration",
        "g",
        "greater",
        _of_points(_peak),
        _largest_peak,
        scope=Scope(
            f"{NO_PULSE}; or {OF_A_JOINT}",
            parts_of="point",
            lacks=_lacks_peak,
        ),
        computation=EXACT_IF_RIGID,
    ),
    Quantity(
        "filtered_peak",
        "part",
        "peak acceleration behind the filter of an accelerometer",
        "g",
        "greater",
        _of_points(lambda impact, places: readings(impact, places, parts=True)),
        largest_reading,
        scope=Scope(
            f"the part has no bandwidth; or {OF_A_JOINT}", parts_of="point", lacks=lacks_bandwidth
        ),
        computation=EXACT_IF_RIGID,
    ),
    Quantity(
        "acceleration_margin",
        "part",
        "critical acceleration, of the peak at the part",
        "1",
        "less",
        _of_points(_acceleration_margin),
        scope=Scope(
            f"{NO_PULSE}, or the part no critical acceleration; or {OF_A_JOINT}", parts_of="point"
        ),
        computation=EXACT_IF_RIGID,
    ),
    Quantity(
        "along",
        "part",
        "impulse along the axis of the part's joint",
        "N m s, N s",
        "greater",
        _of_joints(lambda impact, places: ALONG.compute(impact, _joints(impact.landing, places))),
        ALONG.size,
        form="signed",
        scope=Scope(f"{ALONG.scope.missing}; or {OF_A_POINT}", shared=True, parts_of="joint"),
    ),
    Quantity(
        "torque",
        "part",
        "torque along the axis of the part's joint: peak, or mean over the duration of its rating",
        "N m, N",
        "greater",
        _of_joints(_part_torque),
        _part_torque_size,
        scope=Scope(f"{MULTIAXIAL}; {NO_TIME}; {REDUNDANT}; or {OF_A_POINT}", parts_of="joint"),
        computation=EXACT_IF_RIGID,
    ),
    Quantity(
        "part_margin",
        "part",
        "margin of the part, by velocity change, acceleration or torque",
        "1",
        "less",
        part_margin,
        scope=Scope(f"of a joint: {MULTIAXIAL}; {NO_TORQUE}; {NO_TIME}; or {REDUNDANT}"),
        computation=EXACT_IF_RIGID,
    ),
    Quantity(
        "joint_torque_share",
        "joint",
        "torque along the axis, of the momentary torque or the effort limit",
        "1",
        "greater",
        torque_share,
        _share_size,
        scope=Scope(
            f"{MULTIAXIAL}; no torque or effort limit is known; {NO_PULSE}, nor a part the "
            f"duration of the torque; or {REDUNDANT}"
        ),
        computation=EXACT_IF_RIGID,
    ),
)
