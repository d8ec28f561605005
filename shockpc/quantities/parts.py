"""How far parts are from their ratings: margins by velocity change and by acceleration, and shares of the torques of joints."""

from typing import Any

import numpy as np

from shockpc.core.percussion import norm
from shockpc.core.pulse import peak_acceleration
from shockpc.core.spatial import Array
from shockpc.impact.impact import Impact
from shockpc.landing.places import joint_places
from shockpc.landing.ratings import Strength, strength, torque_limits
from shockpc.landing.scene import GRAVITY
from shockpc.quantities.ground import ALONG, PEAK_TORQUE, point_peaks
from shockpc.quantities.joints import AXES, REDUNDANT
from shockpc.quantities.points import DELTA_V, NEEDS_PULSE, SHOCK, point_velocity
from shockpc.quantities.quantity import Places, Quantity, largest_jump

NO_PULSE = "the scene gives neither a pulse nor a contact stiffness"


def _strengths(impact: Impact, places: Places) -> list[Strength]:
    return [strength(impact.landing.scene.part[place.number]) for place in places]


def _quotient(impact: Impact, critical: list[float], values: Any, size: float) -> Any:
    """Critical values over actual ones (N, S, n); infinite where there is no load, NaN where one of the two is not known."""
    numbers, known = impact.rounded(values, lambda _: size), np.isfinite(np.array(critical))
    loaded = known & ~np.isnan(numbers) & (numbers != 0.0)
    quotient = impact.exact(np.where(known, critical, 0.0)) / np.where(loaded, values, 1.0)
    return np.where(loaded, quotient, np.where(known & (numbers == 0.0), np.inf, np.nan))


def _velocity_margin(impact: Impact, places: Places) -> Any:
    """Critical velocity changes over |Δv| (N, S, n); infinite where a part does not move."""
    critical, speed = [one.velocity_change for one in _strengths(impact, places)], norm(point_velocity(impact, places))
    return _quotient(impact, critical, speed, largest_jump(impact, speed))


def _peak(impact: Impact, places: Places) -> Any:
    """Peak accelerations (N, S, n) for the pulse of the scene, or on its contact stiffness in doubles [g]."""
    landing = impact.landing
    if landing.scene.contact_stiffness is not None:
        from shockpc.impact.stiffness import compliant_landing

        return point_peaks(compliant_landing(landing), places)[0][None, None] / GRAVITY
    speed = norm(point_velocity(impact, places))
    return np.full(speed.shape, np.nan) if landing.pulse is None else peak_acceleration(speed, landing.pulse) / GRAVITY


def _largest_peak(impact: Impact, values: Array) -> float:
    """The largest component of a jump of a body as a peak [g]."""
    pulse = impact.landing.pulse
    return 0.0 if pulse is None else peak_acceleration(largest_jump(impact, values), pulse) / GRAVITY


def _acceleration_margin(impact: Impact, places: Places) -> Any:
    peak = _peak(impact, places)
    return _quotient(impact, [one.acceleration for one in _strengths(impact, places)], peak, _largest_peak(impact, peak))


def _part_margin(impact: Impact, places: Places) -> Any:
    margins = [_velocity_margin(impact, places), _acceleration_margin(impact, places)]
    velocity, acceleration = (impact.rounded(margin, lambda _: 0.0) for margin in margins)
    less = np.isnan(acceleration) | (velocity <= acceleration)
    both = np.array([one.both for one in _strengths(impact, places)])
    return np.where(np.where(both, less, np.isnan(acceleration) | (velocity >= acceleration)), *margins)


def _torque_share(impact: Impact, places: Places) -> Any:
    """Torque (N, S, n) along the axes of joints, of their momentary torques.

    The torque is the peak on contacts of finite stiffness; else the impulse along the axis gives the peak of a pulse as the scene
    has it, or the mean over the duration that a part gives.
    """
    limit = torque_limits(impact.landing.robot, impact.landing.scene.part)[0][[place.number for place in places]]
    if impact.landing.scene.contact_stiffness is not None:
        return PEAK_TORQUE.compute(impact, places) / limit
    impulse, shares = ALONG.compute(impact, places), _shares(impact, places)
    numbers = impact.rounded(impulse, lambda values: ALONG.size(impact, values))
    known = impact.unique[:, None].all(axis=-1, keepdims=True) & ~np.isnan(numbers) & ~np.isnan(shares)
    share = np.where(known, np.where(numbers < 0.0, -impulse, impulse), 0.0) * impact.exact(np.nan_to_num(shares))
    return np.where(known, share, np.nan)


def _shares(impact: Impact, places: Places) -> Array:
    """Shares (n,) of the momentary torque for an impulse of 1 along the axis [1/(N m s), 1/(N s)]; NaN where not known."""
    numbers, pulse = [place.number for place in places], impact.landing.pulse
    limit, duration = (values[numbers] for values in torque_limits(impact.landing.robot, impact.landing.scene.part))
    return np.asarray((1.0 / duration if pulse is None else peak_acceleration(1.0, pulse)) / limit)


def _share_size(impact: Impact, values: Array) -> float:
    return float(ALONG.size(impact, values) * np.nan_to_num(_shares(impact, joint_places(impact.landing.robot))).max(initial=0.0))


PARTS = (
    *(entry._replace(of="part", also=()) for entry in (DELTA_V, SHOCK)),
    Quantity("velocity_margin", "part", "critical velocity change, of that of the part", "1", "less", _velocity_margin),
    Quantity("peak_g", "part", "peak acceleration", "g", "greater", _peak, _largest_peak, NO_PULSE, with_stiffness=True,
        lacks=lambda landing: "" if landing.pulse or landing.scene.contact_stiffness else f"{NEEDS_PULSE}, or a contact stiffness"),
    Quantity("acceleration_margin", "part", "critical acceleration, of the peak at the part", "1", "less", _acceleration_margin,
        missing=f"{NO_PULSE}, or the part no critical acceleration", with_stiffness=True),
    Quantity("part_margin", "part", "margin of the part, by velocity change or acceleration", "1", "less", _part_margin,
        with_stiffness=True),
    Quantity("joint_torque_share", "joint", "torque along the axis, of the momentary torque or the effort limit", "1", "greater",
        _torque_share, _share_size, f"{AXES}; no torque or effort limit is known; {NO_PULSE}, nor a part the duration of the "
        f"torque; or {REDUNDANT}", with_stiffness=True),
)  # fmt: skip
