"""How far parts are from their ratings: margins by velocity change and by acceleration, and shares of the torques of joints."""

from typing import Any

import numpy as np

from shockpc.core.percussion import norm
from shockpc.core.pulse import peak_acceleration
from shockpc.core.spatial import Array
from shockpc.impact import Impact
from shockpc.quantities.ground import ALONG, GROUND
from shockpc.quantities.joints import AXES, REDUNDANT
from shockpc.quantities.points import POINTS, point_velocity
from shockpc.quantities.quantity import Places, Quantity, largest_jump
from shockpc.ratings import Strength, strength, torque_limits
from shockpc.scene import GRAVITY

NO_PULSE = "the scene gives neither a pulse nor a contact stiffness"
PEAK_TORQUE = next(entry for entry in GROUND if entry.key == "peak_torque")


def _strengths(impact: Impact, places: Places) -> list[Strength]:
    return [strength(impact.landing.scene.part[place.number]) for place in places]


def _speed(impact: Impact, places: Places) -> Array:
    """|Δv| (N, S, n) of the parts in doubles [m/s]."""
    return impact.rounded(norm(point_velocity(impact, places)), lambda values: largest_jump(impact, values))


def _margin(critical: list[float], values: Array) -> Array:
    """Critical values over actual ones; infinite where there is no load, NaN where one of the two is not known."""
    with np.errstate(divide="ignore"):
        return np.asarray(np.array(critical) / values)


def _velocity_margin(impact: Impact, places: Places) -> Any:
    """Critical velocity changes over |Δv| (N, S, n), in the arithmetic of the impact; infinite where a part does not move."""
    speed, still = norm(point_velocity(impact, places)), _speed(impact, places) == 0.0
    critical = impact.exact(np.array([one.velocity_change for one in _strengths(impact, places)]))
    return np.where(still, np.inf, critical / np.where(still, 1.0, speed))


def _peak(impact: Impact, places: Places) -> Array:
    """Peak accelerations (N, S, n) for the pulse of the scene, or on its contact stiffness [g]."""
    landing = impact.landing
    if landing.scene.contact_stiffness is not None:
        from shockpc.compliance import compliant_landing

        return compliant_landing(landing).peaks(point_velocity, places)[0][None, None] / GRAVITY
    speed = _speed(impact, places)
    return speed * (np.nan if landing.pulse is None else peak_acceleration(1.0, landing.pulse) / GRAVITY)


def _acceleration_margin(impact: Impact, places: Places) -> Array:
    return _margin([one.acceleration for one in _strengths(impact, places)], _peak(impact, places))


def _part_margin(impact: Impact, places: Places) -> Array:
    velocity = impact.rounded(_velocity_margin(impact, places), lambda values: 0.0)
    acceleration = _acceleration_margin(impact, places)
    both = [one.both for one in _strengths(impact, places)]
    return np.where(both, np.fmin(velocity, acceleration), np.fmax(velocity, acceleration))


def _torque_share(impact: Impact, places: Places) -> Any:
    """Torque (N, S, n) along the axes of joints, of their momentary torques.

    The torque is the peak on contacts of finite stiffness; else the impulse along the axis gives the peak of a pulse as the scene
    has it, or the mean over the duration that a part gives.
    """
    landing, numbers = impact.landing, [place.number for place in places]
    limit, duration = (values[numbers] for values in torque_limits(landing.robot, landing.scene.part))
    if landing.scene.contact_stiffness is not None:
        return PEAK_TORQUE.formula(impact, places) / limit
    if not impact.unique.all():
        return np.full((*impact.v_in.shape, len(places)), np.nan)
    impulse = np.abs(impact.rounded(ALONG.formula(impact, places), lambda values: ALONG.size(impact, values)))
    return impulse * (1.0 / duration if landing.pulse is None else peak_acceleration(1.0, landing.pulse)) / limit


PARTS = (
    *(entry._replace(of="part") for entry in POINTS if entry.key in ("delta_v", "shock")),
    Quantity("velocity_margin", "part", "critical velocity change, of that of the part", "1", "less", _velocity_margin),
    Quantity("peak_g", "part", "peak acceleration", "g", "greater", _peak, missing=NO_PULSE, posed=True, unproven=True),
    Quantity("acceleration_margin", "part", "critical acceleration, of the peak at the part", "1", "less", _acceleration_margin,
        missing=f"{NO_PULSE}, or the part no critical acceleration", posed=True, unproven=True),
    Quantity("part_margin", "part", "margin of the part, by velocity change or acceleration", "1", "less", _part_margin, posed=True,
        unproven=True),
    Quantity("joint_torque_share", "joint", "torque along the axis, of the momentary torque or the effort limit", "1", "greater",
        _torque_share, missing=f"{AXES}; no torque or effort limit is known; {NO_PULSE}, nor a part the duration of the torque; or "
        f"{REDUNDANT}", posed=True, unproven=True),
)  # fmt: skip
