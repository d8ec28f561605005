"""Quantities of points: jump of velocity, shock, and extreme impact directions."""

from typing import Any

import numpy as np

from shockpc.core.low_pass import LowPass, peak_of
from shockpc.core.most_severe import ExtremeDirections, extreme_directions, most_severe_direction
from shockpc.core.percussion import norm
from shockpc.core.pulse import peak_acceleration
from shockpc.core.spatial import Array, jump_at, velocity_at
from shockpc.impact.impact import Impact
from shockpc.impact.landing_motion import LandingMotion, motion_of
from shockpc.landing.bandwidths import low_pass_of_part, low_passes_of, scene_low_pass
from shockpc.landing.landing import PosedLanding
from shockpc.landing.scenes.strike import GRAVITY
from shockpc.quantities.quantity import (
    EXACT_IF_RIGID,
    Computation,
    Places,
    Quantity,
    Relations,
    Scope,
    largest_jump,
    largest_shock,
    once_per_impact,
    reach,
)

NEEDS_BANDWIDTH = (
    "the reading of an accelerometer follows from its bandwidth, and the scene has none; give it "
    "an imu_bandwidth, such as 200Hz"
)
NO_BANDWIDTH = "the scene gives no bandwidth of the accelerometer there"
NEEDS_PULSE = (
    "peak_g needs the duration of the impact, and the scene has none; give it a pulse = "
    '"half-sine:5ms"'
)


def _r(impact: Impact, places: Places) -> Any:
    """The points (N or 1, n, 3) in their bodies' frames [m]."""
    coms = impact.coms
    points = []
    for place in places:
        fixed = np.broadcast_to(place.r, (len(coms), 3))
        points.append(coms[:, place.body] if place.centre else fixed)
    return np.stack(points, axis=1)


def point_velocity(impact: Impact, places: Places) -> Any:
    """Jumps (N, S, n, 3) of points' velocities, axes of their bodies' frames [m/s] (Eq. 10)."""
    jumps = impact.jumps_of([place.body for place in places])
    return velocity_at(jumps[..., :3], jumps[..., 3:], impact.exact(_r(impact, places))[:, None])


def _delta_v(impact: Impact, places: Places) -> Any:
    axes = impact.exact(np.array([place.axes.T for place in places]))
    return (axes @ point_velocity(impact, places)[..., None])[..., 0]


def shock_at_points(impact: Impact, places: Places) -> Any:
    """|Δv| / v_in (N, S, n) (Eq. 2)."""
    return norm(point_velocity(impact, places)) / impact.v_in[..., None]


def pulse_peak(impact: Impact, places: Places) -> Any:
    """Peak accelerations (N, S, n) of points for the scene's pulse [g]; NaN without one."""
    speed = norm(point_velocity(impact, places))
    pulse = impact.landing.pulse
    if pulse is None:
        return np.full(speed.shape, np.nan)
    return peak_acceleration(speed, pulse) / GRAVITY


def _lacks_pulse(landing: PosedLanding) -> str:
    """Message of what a landing lacks for a peak; empty if nothing."""
    return NEEDS_PULSE if landing.pulse is None else ""


def low_passes(landing: PosedLanding, places: Places, parts: bool = False) -> list[LowPass | None]:
    """The filters of the sensors at some points; None where none is known.

    Args: parts, whether these are parts of the scene.
    """
    scene = landing.scene
    if parts:
        return [low_pass_of_part(scene, place.number) for place in places]
    return [scene_low_pass(scene)] * len(places)


def axis_jumps(impact: Impact, places: Places) -> Any:
    """Jumps along each axis of points, as vectors of one component (N, S, 3 n, 1) [m/s]."""
    values = np.asarray(_delta_v(impact, places))
    return values.reshape(*values.shape[:2], -1, 1)


def readings(impact: Impact, places: Places, parts: bool = False, along: bool = False) -> Any:
    """Peaks that accelerometers at points read behind their filters [g]; NaN without one.

    In a landing that lasts they are those of the motion, else of the pulse, else the bound for a
    pulse of any length.

    Args:
        impact: the impact.
        places: where.
        parts: whether these are parts of the scene.
        along: whether along each axis of a place (N, S, n, 3), else of the whole vector (N, S, n).
    """
    filters = low_passes(impact.landing, places, parts)
    motion = motion_of(impact.landing)
    if motion is None:
        return _readings_of_pulse(impact, places, filters, along)
    return _readings_of_motion(motion, places, filters, along)


def _readings_of_pulse(
    impact: Impact, places: Places, filters: list[LowPass | None], along: bool
) -> Any:
    """Readings of a pulse, as `readings`: each jump times the peak for a jump of 1 m/s."""
    scale = np.full(len(places), np.nan)
    for k, low_pass in enumerate(filters):
        if low_pass is not None:
            scale[k] = peak_of(impact.landing.pulse, low_pass) / GRAVITY
    if along:
        jumps = np.abs(_delta_v(impact, places))
        scale = scale[:, None]
    else:
        jumps = norm(point_velocity(impact, places))
    return np.where(np.isnan(scale), np.nan, jumps * impact.exact(np.nan_to_num(scale)))


def _readings_of_motion(
    motion: LandingMotion, places: Places, filters: list[LowPass | None], along: bool
) -> Array:
    """Readings of a motion, as `readings`: those of one filter at all its places together."""
    components = 3 if along else 1
    compute = axis_jumps if along else point_velocity
    peaks = np.full((len(places), components), np.nan)
    for low_pass in set(filters) - {None}:
        at = [k for k, own in enumerate(filters) if own == low_pass]
        values, _ = motion.peaks(compute, [places[k] for k in at], low_pass)
        peaks[at] = values.reshape(len(at), components) / GRAVITY
    return peaks[None, None] if along else peaks[None, None, :, 0]


def largest_reading(impact: Impact, values: Array) -> float:
    """The largest component of a jump of a body as a reading [g]."""
    landing = impact.landing
    scales = [peak_of(landing.pulse, low_pass) for low_pass in low_passes_of(landing.scene)]
    return largest_jump(impact, values) * max(scales, default=0.0) / GRAVITY


def lacks_bandwidth(landing: PosedLanding) -> str:
    """Message of what a landing lacks for readings of accelerometers; empty if nothing.

    The bandwidth of one accelerometer is enough.
    """
    return "" if low_passes_of(landing.scene) else NEEDS_BANDWIDTH


def world_position(impact: Impact, places: Places) -> Any:
    """Positions (N, 1, n, 3) of points in the world [m]."""
    origin = impact.exact(impact.state.origin)[:, None]
    return (impact.points([place.body for place in places], _r(impact, places)) + origin)[:, None]


@once_per_impact
def most_and_least_severe(impact: Impact, places: Places) -> ExtremeDirections:
    """The extreme impact directions (N, 1, n, ...) of points, in double precision.

    They are right to 1e-15 of the largest shock.
    """
    maps = _maps(impact, places)
    flat = extreme_directions(maps.reshape(-1, 3, 3), impact.landing.up)
    shape = len(maps), 1, len(places)
    return ExtremeDirections(
        flat.most_severe.reshape(*shape, 3),
        flat.most_severe_shock.reshape(shape),
        flat.least_severe.reshape(*shape, 3),
        flat.least_severe_shock.reshape(shape),
    )


@once_per_impact
def _most_severe(impact: Impact, places: Places) -> tuple[Array, Array]:
    """The most severe impact directions (N, 1, n, 3) of points and the shocks there (N, 1, n).

    In many postures the least severe ones are not computed.
    """
    maps = _maps(impact, places)
    if len(maps) == 1:
        return most_and_least_severe(impact, places)[:2]
    direction, shock = most_severe_direction(maps.reshape(-1, 3, 3), impact.landing.up)
    return direction.reshape(len(maps), 1, len(places), 3), shock.reshape(len(maps), 1, len(places))


def _maps(impact: Impact, places: Places) -> Array:
    """Jumps (N, n, 3, 3) of the velocities of points for unit strikes along x, y and z.

    They are in the axes of the bodies' frames.
    """
    jumps = impact.maps_of([place.body for place in places])
    r = np.broadcast_to(_r(impact, places), (*jumps.shape[:2], 3)).reshape(-1, 3)
    maps = jump_at(jumps.reshape(-1, 6, 3), impact.exact(r))
    maps = impact.rounded(
        maps, lambda values: np.abs(values).max(axis=(1, 2), keepdims=True) + 1e-300
    )
    return np.asarray(maps.reshape(*jumps.shape[:2], 3, 3))


DELTA_V = Quantity(
    "delta_v",
    "point",
    "Δv, axes of the frame",
    "m/s",
    "greater",
    _delta_v,
    largest_jump,
    form="vector",
    relations=Relations(also=("friction", "stiffness"), linear=True),
)
MOST_SEVERE = Quantity(
    "most_severe",
    "point",
    "shock of the most severe impact direction",
    "1",
    "greater",
    lambda i, p: _most_severe(i, p)[1],
)
SHOCK = Quantity(
    "shock",
    "point",
    "shock",
    "1",
    "greater",
    shock_at_points,
    largest_shock,
    relations=Relations(most_severe=MOST_SEVERE, also=("friction", "stiffness"), length_of=DELTA_V),
)
AT_CENTRE = (
    Quantity(
        "most_severe_direction",
        "point",
        "most severe impact direction, world axes",
        "1",
        "neither",
        lambda i, p: _most_severe(i, p)[0],
        form="vector",
    ),
    MOST_SEVERE,
    Quantity(
        "least_severe_direction",
        "point",
        "least severe impact direction, world axes",
        "1",
        "neither",
        lambda i, p: most_and_least_severe(i, p).least_severe,
        form="vector",
    ),
    Quantity(
        "least_severe",
        "point",
        "shock of the least severe impact direction",
        "1",
        "greater",
        lambda i, p: most_and_least_severe(i, p).least_severe_shock,
    ),
    Quantity(
        "peak_g",
        "point",
        "peak acceleration",
        "g",
        "greater",
        pulse_peak,
        scope=Scope(
            "the scene gives no pulse",
            lacks=_lacks_pulse,
        ),
        relations=Relations(also=("friction",), length_of=DELTA_V),
    ),
)
"""Quantities that bodies have too, at their centres of mass."""

POINTS = (
    DELTA_V,
    SHOCK,
    *AT_CENTRE,
    Quantity(
        "position",
        "point",
        "position in the world",
        "m",
        "neither",
        world_position,
        reach,
        form="vector",
        scope=Scope(fixed=lambda place: place.r),
    ),
    Quantity(
        "filtered_peak",
        "point",
        "peak acceleration behind the filter of an accelerometer",
        "g",
        "greater",
        readings,
        largest_reading,
        scope=Scope(NO_BANDWIDTH, lacks=lacks_bandwidth),
        computation=EXACT_IF_RIGID,
        relations=Relations(also=("friction",)),
    ),
    Quantity(
        "filtered_peak_axes",
        "point",
        "the same along each axis of the frame",
        "g",
        "greater",
        lambda i, p: readings(i, p, along=True),
        largest_reading,
        form="vector",
        scope=Scope(NO_BANDWIDTH, lacks=lacks_bandwidth),
        computation=EXACT_IF_RIGID,
        relations=Relations(also=("friction",)),
    ),
    Quantity(
        "shock_free",
        "point",
        "shock with free joints",
        "1",
        "greater",
        shock_at_points,
        largest_shock,
        scope=Scope("not solvable with free joints"),
        computation=Computation("free", postures="one"),
    ),
    Quantity(
        "shock_locked",
        "point",
        "shock with locked joints",
        "1",
        "greater",
        shock_at_points,
        largest_shock,
        scope=Scope("not solvable with locked joints"),
        computation=Computation("locked", postures="one"),
    ),
    Quantity(
        "shock_springs_free",
        "point",
        "shock with locked joints but those with springs",
        "1",
        "greater",
        shock_at_points,
        largest_shock,
        scope=Scope("no joint has a spring, or not solvable"),
        computation=Computation("springs_free", postures="one"),
    ),
)
