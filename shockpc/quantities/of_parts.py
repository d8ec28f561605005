"""How far parts are from their ratings: margins by velocity change, by acceleration and by the
torques of joints.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from shockpc.core.percussion import norm
from shockpc.core.pulse import Pulse, peak_acceleration
from shockpc.core.spatial import Array
from shockpc.impact.impact import Impact
from shockpc.impact.motion import motion_of
from shockpc.landing.landing import PosedLanding
from shockpc.landing.places import Place, joint_places
from shockpc.landing.ratings import (
    Strength,
    TorqueStrength,
    strength,
    torque_limits,
    torque_strength,
)
from shockpc.landing.strike import GRAVITY
from shockpc.quantities.of_joints import MULTIAXIAL, REDUNDANT
from shockpc.quantities.of_points import (
    DELTA_V,
    NEEDS_PULSE,
    SHOCK,
    lacks_bandwidth,
    largest_reading,
    point_velocity,
    readings,
)
from shockpc.quantities.peaks import ALONG, joint_peaks, point_peaks
from shockpc.quantities.quantity import PROVEN_IF_RIGID, Places, Quantity, Scope, largest_jump

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
    NEEDS_ROTOR: ", which decides the spring's torque; give it with --rotor, and a contact stiffness",
    NEEDS_STIFFNESS: ", because its spring gives its torque after the instant of the impact",
}
"""What to change where a part of a joint has no margin."""

OF_A_JOINT, OF_A_POINT = "the part is of a joint", "the part is at a point"

Compute = Callable[[Impact, Places], Any]


def _of_points(compute: Compute, joints: bool = False, vector: bool = False) -> Compute:
    """A formula of parts only at points, or of those of joints: no value at the others."""
    axes = (3,) if vector else ()

    def chosen(impact: Impact, places: Places) -> Any:
        wanted = [k for k, place in enumerate(places) if (place.joint >= 0) == joints]
        if wanted and len(wanted) == len(places):
            return compute(impact, places)
        values = (
            compute(impact, [places[k] for k in wanted]) if wanted else np.zeros((1, 1, 0, *axes))
        )
        out = np.full((*values.shape[:2], len(places), *axes), np.nan, dtype=values.dtype)
        out[:, :, wanted] = values
        return out

    return chosen


def _of_joints(compute: Compute) -> Compute:
    """A formula of parts of joints only, of the places of these joints as parts are: no value at
    the others.
    """
    return _of_points(compute, joints=True)


def _strengths(impact: Impact, places: Places) -> list[Strength]:
    return [strength(impact.landing.scene.part[place.number]) for place in places]


def _torque_strengths(landing: PosedLanding, places: Places) -> list[TorqueStrength]:
    robot, parts = landing.robot, landing.scene.part
    joints = _joints(landing, places)
    return [
        torque_strength(robot, parts[part.number], joint.name)
        for part, joint in zip(places, joints, strict=True)
    ]


def _joints(landing: PosedLanding, places: Places) -> list[Place]:
    """The joints of parts."""
    joints = {place.number: place for place in joint_places(landing.robot)}
    return [joints[place.joint] for place in places]


def _quotient(impact: Impact, critical: list[float], values: Any, size: float) -> Any:
    """Critical values over actual ones (N, S, n); infinite where there is no load, NaN where one of
    the two is not known.
    """
    numbers, known = impact.rounded(values, lambda _: size), np.isfinite(np.array(critical))
    loaded = known & ~np.isnan(numbers) & (numbers != 0.0)
    quotient = impact.exact(np.where(known, critical, 0.0)) / np.where(loaded, values, 1.0)
    return np.where(loaded, quotient, np.where(known & (numbers == 0.0), np.inf, np.nan))


def _velocity_margin(impact: Impact, places: Places) -> Any:
    """Critical velocity changes over |Δv| (N, S, n); infinite where a part does not move."""
    critical, speed = (
        [one.velocity_change for one in _strengths(impact, places)],
        norm(point_velocity(impact, places)),
    )
    return _quotient(impact, critical, speed, largest_jump(impact, speed))


def pulse_of_parts(landing: PosedLanding) -> Pulse | None:
    """The scene's pulse, by which parts and torques are judged; None on contacts of finite
    stiffness, which give the peaks.
    """
    return landing.pulse if not landing.scene.yields else None


def _peak(impact: Impact, places: Places) -> Any:
    """Peak accelerations (N, S, n) for the pulse of the scene, or on its contact stiffness in
    doubles [g].
    """
    landing = impact.landing
    if (motion := motion_of(landing)) is not None:
        return point_peaks(motion, places)[0][None, None] / GRAVITY
    speed = norm(point_velocity(impact, places))
    return (
        np.full(speed.shape, np.nan)
        if landing.pulse is None
        else peak_acceleration(speed, landing.pulse) / GRAVITY
    )


def _largest_peak(impact: Impact, values: Array) -> float:
    """The largest component of a jump of a body as a peak [g]."""
    pulse = pulse_of_parts(impact.landing)
    return (
        0.0 if pulse is None else peak_acceleration(largest_jump(impact, values), pulse) / GRAVITY
    )


def _acceleration_margin(impact: Impact, places: Places) -> Any:
    peak = _peak(impact, places)
    return _quotient(
        impact,
        [one.acceleration for one in _strengths(impact, places)],
        peak,
        _largest_peak(impact, peak),
    )


def _point_margin(impact: Impact, places: Places) -> Any:
    margins = [_velocity_margin(impact, places), _acceleration_margin(impact, places)]
    velocity, acceleration = (impact.rounded(margin, lambda _: 0.0) for margin in margins)
    less = np.isnan(acceleration) | (velocity <= acceleration)
    both = np.array([one.both for one in _strengths(impact, places)])
    return np.where(
        np.where(both, less, np.isnan(acceleration) | (velocity >= acceleration)), *margins
    )


def _torque(impact: Impact, places: Places, durations: Array) -> Any:
    """Torques (N, S, n) along the axes of joints; NaN where they are not known [N m, N].

    The torque is the peak on contacts of finite stiffness; else the impulse along the axis gives
    the peak of a pulse as the scene has it, or the mean over a duration.

    Args:
        impact: the impact.
        places: the joints.
        durations: (n,) for which a part says that a joint withstands its torque [s]; NaN where none
            does.
    """
    if (motion := motion_of(impact.landing)) is not None:
        return joint_peaks(motion, places)[2][None, None]
    impulse, rates = ALONG.compute(impact, places), _rates(impact, durations)
    numbers = impact.rounded(impulse, lambda values: ALONG.size(impact, values))
    # A spring before a rotor gives no impulse in the instant of the impact, but a torque
    # afterwards.
    sprung = np.isfinite(impact.landing.joint_model.drive_stiffness)[
        [place.number for place in places]
    ]
    known = (
        impact.unique[:, None].all(axis=-1, keepdims=True)
        & ~np.isnan(numbers)
        & ~np.isnan(rates)
        & ~sprung
    )
    return np.where(
        known,
        np.where(numbers < 0.0, -impulse, impulse) * impact.exact(np.nan_to_num(rates)),
        np.nan,
    )


def _rates(impact: Impact, durations: Array) -> Array:
    """Torque (n,) for an impulse of 1 along the axis [1/s]: of the scene's pulse, else the mean
    over a duration (n,) [s].
    """
    pulse = pulse_of_parts(impact.landing)
    return (
        1.0 / durations if pulse is None else np.full(len(durations), peak_acceleration(1.0, pulse))
    )


def _torque_size(impact: Impact, durations: Array, values: Array) -> float:
    """The natural size of torques: that of the largest load of a joint, with the shortest duration."""
    return float(
        ALONG.size(impact, values) * np.nan_to_num(_rates(impact, durations)).max(initial=0.0)
    )


def _part_durations(impact: Impact, places: Places) -> Array:
    return np.array([one.duration for one in _torque_strengths(impact.landing, places)])


def _part_torque(impact: Impact, places: Places) -> Any:
    return _torque(impact, _joints(impact.landing, places), _part_durations(impact, places))


def _part_torque_size(impact: Impact, values: Array) -> float:
    durations = [part.torque_duration or np.nan for part in impact.landing.scene.part]
    return _torque_size(impact, np.array(durations), values)


def _torque_margin(impact: Impact, places: Places) -> Any:
    limits = [one.momentary_torque for one in _torque_strengths(impact.landing, places)]
    torque = _part_torque(impact, places)
    return _quotient(impact, limits, torque, _part_torque_size(impact, torque))


def part_margin(impact: Impact, places: Places) -> Any:
    """The governing margin (N, S, n) of parts; NaN where none is known."""
    of_joints = np.array([place.joint >= 0 for place in places])
    return np.where(
        of_joints,
        _of_joints(_torque_margin)(impact, places),
        _of_points(_point_margin)(impact, places),
    )


def not_judged(landing: PosedLanding, place: Place, redundant: bool) -> str:
    """Why a part of a joint has no margin. Args: redundant, whether contacts or loops are."""
    joint, strength = _joints(landing, [place])[0], _torque_strengths(landing, [place])[0]
    if landing.robot.joint(joint.name).axis is None:
        return MULTIAXIAL
    if np.isnan(strength.momentary_torque):
        return NEEDS_TORQUE
    if np.isfinite(landing.joint_model.drive_stiffness[joint.number]):
        return NEEDS_ROTOR if landing.joint_model.rotor_unknown[joint.number] else NEEDS_STIFFNESS
    return "contacts or loops are redundant" if redundant else NEEDS_TIME


def torque_share(impact: Impact, places: Places) -> Any:
    """Torque (N, S, n) along the axes of joints, of their momentary torques."""
    limits, durations = (values[[p.number for p in places]] for values in _limits(impact))
    torque = _torque(impact, places, durations)
    known = ~np.isnan(torque.astype(float)) & ~np.isnan(limits)
    return np.where(
        known,
        np.where(known, torque, 0.0) / impact.exact(np.where(np.isnan(limits), 1.0, limits)),
        np.nan,
    )


def _limits(impact: Impact) -> tuple[Array, Array]:
    return torque_limits(impact.landing.robot, impact.landing.scene.part)


def _share_size(impact: Impact, values: Array) -> float:
    limits, durations = _limits(impact)
    return float(
        ALONG.size(impact, values)
        * np.nan_to_num(_rates(impact, durations) / limits).max(initial=0.0)
    )


PARTS = (
    *(
        entry._replace(
            of="part",
            scope=entry.scope._replace(missing=OF_A_JOINT, parts_of="point"),
            relations=entry.relations._replace(also=()),
            compute=_of_points(entry.compute, vector=vector),
        )
        for entry, vector in ((DELTA_V, True), (SHOCK, False))
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
            lacks=lambda landing: (
                ""
                if landing.pulse or landing.scene.contact_stiffness
                else f"{NEEDS_PULSE}, or a contact stiffness"
            ),
        ),
        evaluation=PROVEN_IF_RIGID,
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
        evaluation=PROVEN_IF_RIGID,
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
        evaluation=PROVEN_IF_RIGID,
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
        evaluation=PROVEN_IF_RIGID,
    ),
    Quantity(
        "part_margin",
        "part",
        "margin of the part, by velocity change, acceleration or torque",
        "1",
        "less",
        part_margin,
        scope=Scope(f"of a joint: {MULTIAXIAL}; {NO_TORQUE}; {NO_TIME}; or {REDUNDANT}"),
        evaluation=PROVEN_IF_RIGID,
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
            f"{MULTIAXIAL}; no torque or effort limit is known; {NO_PULSE}, nor a part the duration of "
            f"the "
            f"torque; or {REDUNDANT}"
        ),
        evaluation=PROVEN_IF_RIGID,
    ),
)
