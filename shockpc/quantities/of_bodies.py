"""Quantities of bodies: step 3 (shock paper, Eqs. 11 and 12), and shock over their geometry."""

from typing import Any, NamedTuple

import numpy as np

from shockpc.core.extremes import Pieces, maximum_shock, shock_extremes
from shockpc.core.memo import memoized
from shockpc.core.percussion import dot, off_plane_share, translation
from shockpc.core.spatial import Array, velocity_at
from shockpc.impact.impact import Impact
from shockpc.landing.places import Place
from shockpc.method.exact.arithmetic import NoValueError
from shockpc.method.shock import centre_of_percussion, radius_of_percussion
from shockpc.quantities.of_points import (
    AT_CENTRE,
    DELTA_V,
    MOST_SEVERE,
    point_velocity,
    shock_at_points,
    world_position,
)
from shockpc.quantities.quantity import (
    Computation,
    Places,
    Quantity,
    Relations,
    Scope,
    largest_jump,
    largest_shock,
    of_ratio,
    once_per_impact,
    reach,
)
from shockpc.quantities.trust import Health
from shockpc.robot.robot import Robot
from shockpc.robot.shapes.geometry import body_outline

NEGLIGIBLE_ROTATION = 1e-12
"""Share of the strike's speed up to which a body is at rest."""

ROUNDED = 1e-9
"""Share of the strike by which a rotation has to move some point of the robot to count.

Files give angles and lengths with ten digits or so, and their rounding rotates bodies by as much.
"""

STILL = "the body does not rotate in the plane"
NO_GEOMETRY = "the body has no geometry to take the shock over; take its shock at a point instead"


class Percussion(NamedTuple):
    """The centre of percussion, where a body's shock is zero, and how fast it grows from there.

    Attributes:
        copc: (..., 3) centre of percussion from the body frame's origin, in the plane through that
            origin [m]; meaningless if the body only translates.
        ropc: (...) radius of percussion, the distance from the centre at which shock equals the
            strike [m]; likewise.
        pitch: (...) pitch of the spatial screw, ω·v / |ω|² [m/rad]; meaningless if the body does
            not rotate.
    """

    copc: Any
    ropc: Any
    pitch: Any


def percussion(
    delta_omega: Any, delta_v: Any, normal: Any, v_in: Any, translates: Any, still: Any
) -> Percussion:
    """The planar centre and radius of percussion of bodies (Eqs. 11 and 12), and their pitch.

    Args:
        delta_omega: (..., 3) jump of angular velocity [rad/s].
        delta_v: (..., 3) jump of velocity of the body frame's origin [m/s].
        normal: (..., 3) unit normal of the plane.
        v_in: speed of the strike [m/s], above zero.
        translates: (...) which bodies have no centre and no radius, as `translation` finds.
        still: (...) which do not rotate.
    """
    turn = np.where(translates, 1, dot(delta_omega, normal))
    spin = np.where(still, 1, dot(delta_omega, delta_omega))
    return Percussion(
        centre_of_percussion(delta_v, normal, turn),
        radius_of_percussion(v_in, turn),
        dot(delta_omega, delta_v) / spin,
    )


def _split(impact: Impact, places: Places) -> tuple[Any, Any]:
    """Jumps Δω and Δv (N, S, n, 3) of the bodies."""
    jumps = impact.jumps_of([place.body for place in places])
    return jumps[..., :3], jumps[..., 3:]


def _normal(impact: Impact, places: Places) -> Any:
    """The plane's normal (N, 1, n, 3) in the axes of the bodies: Rᵀ n."""
    rotation = impact.orientations([place.body for place in places])
    normal = impact.exact(impact.landing.plane.normal)[:, None]
    return np.sum(rotation * normal, axis=-2)[:, None]


@once_per_impact
def translations(impact: Impact, places: Places) -> tuple[Any, Any]:
    """(N, S, n) bool twice, True for bodies that do not rotate in the plane, and not at all.

    Rotation by no more than the rounding of files is none.
    """
    if not impact.has_values:  # then the centre of a body that does not rotate is infinite or NaN
        still = np.zeros((1, 1, len(places)), dtype=bool)
        return still, still
    omega, v = _split(impact, places)
    omega, v = omega.astype(float), v.astype(float)
    normal = _normal(impact, places).astype(float)
    v_in = impact.v_in.astype(float)[..., None]
    return translation(omega, v, normal, v_in, impact.landing.length, ROUNDED)


@once_per_impact
def _percussion(impact: Impact, places: Places) -> Percussion:
    """Centre, radius and pitch; NaN or infinite where a body does not rotate."""
    translates, still = translations(impact, places)
    omega, v = _split(impact, places)
    normal = _normal(impact, places)
    of_all = percussion(omega, v, normal, impact.v_in[..., None], translates, still)
    return Percussion(
        np.where(translates[..., None], np.nan, of_all.copc),
        np.where(translates, np.inf, of_all.ropc),
        np.where(still, np.nan, of_all.pitch),
    )


def _translates(impact: Impact, places: Places) -> Array:
    """1 (N, S, n) of bodies that do not rotate in the plane, else 0.

    Raises:
        NoValueError: symbols have no values to be compared.
    """
    if not impact.has_values:
        raise NoValueError
    return np.asarray(translations(impact, places)[0].astype(float))


def _copc_world(impact: Impact, places: Places) -> Any:
    """Centres of percussion (N, S, n, 3) in the world [m]: R c + p; NaN where there is none."""
    bodies = [place.body for place in places]
    copc = _percussion(impact, places).copc
    turned = (impact.orientations(bodies)[:, None] @ copc[..., None])[..., 0]
    origin = impact.state.position[:, bodies] + impact.exact(impact.state.origin)[:, None]
    translates, _ = translations(impact, places)
    return np.where(translates[..., None], np.nan, turned + origin[:, None])


def _out_of_plane(impact: Impact, places: Places) -> Any:
    """Shares (N, S, n) of the motion out of the plane, as `off_plane_share`."""
    omega, v = _split(impact, places)
    bodies = [place.body for place in places]
    com = impact.exact(impact.inertias.com[:, None, bodies])
    gyration = impact.exact(impact.inertias.gyration[:, None, bodies])
    at_rest = NEGLIGIBLE_ROTATION * impact.v_in.astype(float)[..., None]
    v_com = velocity_at(omega, v, com)
    return off_plane_share(omega, v_com, _normal(impact, places), gyration, at_rest)


@once_per_impact
def _extremes(impact: Impact, places: Places) -> Array:
    """Smallest and largest shock (2, N, S, n) over the bodies' geometry, from the rounded jumps.

    They are NaN without geometry.
    """
    omega, v = _split(impact, places)
    omega, v = omega.astype(float), v.astype(float)
    v_in = impact.v_in.astype(float)
    pieces = _pieces(impact.landing.robot, *(place.body for place in places))
    extremes = np.empty((2, *omega.shape[:3]))
    for k in np.ndindex(v_in.shape):
        extremes[:, *k] = shock_extremes(omega[k], v[k], pieces, float(v_in[k]))
    return extremes


def _least(impact: Impact, places: Places) -> Array:
    """Smallest shock (N, S, n) over the bodies' geometry, as `_extremes`."""
    return np.asarray(_extremes(impact, places)[0])


def _greatest(impact: Impact, places: Places) -> Array:
    """Largest shock (N, S, n) over the bodies' geometry, as `_extremes`.

    That of many landings is computed body by body, which is faster.
    """
    if impact.v_in.size == 1:
        return np.asarray(_extremes(impact, places)[1])
    omega, v = _split(impact, places)
    omega, v = omega.astype(float), v.astype(float)
    speeds = []
    for k, place in enumerate(places):
        piece = _pieces(impact.landing.robot, place.body)
        speeds.append(maximum_shock(omega[:, :, k], v[:, :, k], piece))
    v_in = impact.v_in.astype(float)[..., None]
    return np.asarray(np.stack(speeds, axis=-1) / v_in)


@memoized()
def _pieces(robot: Robot, *bodies: int) -> Pieces:
    """The convex pieces of some bodies."""
    shapes = body_outline(robot).shapes
    pieces = []
    for body in bodies:
        pieces.append([(shape.points, shape.rounding) for shape in shapes[body]])
    return Pieces.of(pieces)


def _length(impact: Impact, values: Array) -> Any:
    """The robot's length, and the distance itself [m]."""
    distance = np.abs(values).max(axis=-1, keepdims=True)
    return impact.landing.length + np.nan_to_num(distance, posinf=0.0)


def _length_in_world(impact: Impact, values: Array) -> Any:
    """The robot's length, the distance itself, and the robot's from the world's origin [m]."""
    return _length(impact, values) + reach(impact, values)


def _pitch_size(impact: Impact, values: Array) -> Any:
    """The robot's length, and the largest |Δv| over the smallest |Δω| that is not zero [m]."""
    jumps = impact.strike_jumps.astype(float)
    spin = np.linalg.norm(jumps[..., :3], axis=-1)
    least = np.where(spin > 0.0, spin, 1.0).min()
    return impact.landing.length + np.linalg.norm(jumps[..., 3:], axis=-1).max() / least


def _position(impact: Impact, places: Places) -> Any:
    """The origins (N, 1, n, 3) of the bodies' frames in the world [m]."""
    return world_position(impact, [Place(place.name, place.body) for place in places])


def _greatest_delta_v(impact: Impact, places: Places) -> Array:
    """Largest |Δv| (N, S, n) over the bodies' geometry [m/s]."""
    return np.asarray(_greatest(impact, places) * impact.v_in.astype(float)[..., None])


def _error_bounds(health: Health, places: Places) -> list[float]:
    return [health.body_error_bounds[place.body] for place in places]


BODIES = (
    Quantity(
        "position",
        "body",
        "origin of the frame in the world",
        "m",
        "neither",
        _position,
        reach,
        form="vector",
    ),
    Quantity(
        "delta_omega",
        "body",
        "Δω, body axes",
        "rad/s",
        "greater",
        lambda i, p: _split(i, p)[0],
        largest_jump,
        form="vector",
        relations=Relations(also=("friction",), linear=True),
    ),
    Quantity(
        "delta_v",
        "body",
        "Δv of the frame's origin, body axes",
        "m/s",
        "greater",
        lambda i, p: _split(i, p)[1],
        largest_jump,
        form="vector",
        relations=Relations(also=("friction",), linear=True),
    ),
    Quantity(
        "copc",
        "body",
        "CoPc, body coordinates",
        "m",
        "neither",
        lambda i, p: _percussion(i, p).copc,
        _length,
        form="vector",
        scope=Scope(STILL),
        relations=Relations(also=("friction",)),
    ),
    Quantity(
        "copc_world",
        "body",
        "CoPc in the world",
        "m",
        "neither",
        _copc_world,
        _length_in_world,
        form="vector",
        scope=Scope(STILL),
    ),
    Quantity(
        "ropc",
        "body",
        "radius of percussion",
        "m",
        "less",
        lambda i, p: _percussion(i, p).ropc,
        relations=Relations(reciprocal="1 / RoPc, the shock per metre", also=("friction",)),
    ),
    Quantity(
        "translates", "body", "no rotation in the plane", "1", "neither", _translates, form="flag"
    ),
    Quantity(
        "screw_pitch",
        "body",
        "pitch of the screw motion, v along the axis over ω",
        "m/rad",
        "neither",
        lambda i, p: _percussion(i, p).pitch,
        _pitch_size,
        form="signed",
        scope=Scope("the body does not rotate"),
    ),
    Quantity(
        "out_of_plane_share",
        "body",
        "share of the motion out of the plane",
        "1",
        "neither",
        _out_of_plane,
        of_ratio,
    ),
    Quantity(
        "shock_com",
        "body",
        "shock at the centre of mass",
        "1",
        "greater",
        shock_at_points,
        largest_shock,
        relations=Relations(
            most_severe=MOST_SEVERE, also=("friction", "stiffness"), length_of=DELTA_V
        ),
    ),
    Quantity(
        "shock_min",
        "body",
        "minimum shock over the body",
        "1",
        "greater",
        _least,
        scope=Scope(NO_GEOMETRY),
    ),
    Quantity(
        "shock_max",
        "body",
        "maximum shock over the body",
        "1",
        "greater",
        _greatest,
        scope=Scope(NO_GEOMETRY),
        relations=Relations(most_severe=MOST_SEVERE),
    ),
    *(
        entry._replace(
            of="body",
            title=f"{entry.title}, at the centre of mass",
            relations=entry.relations._replace(also=()),
        )
        for entry in AT_CENTRE
    ),
    Quantity(
        "delta_v_com",
        "body",
        "Δv of the centre of mass, body axes",
        "m/s",
        "greater",
        point_velocity,
        largest_jump,
        form="vector",
        relations=Relations(linear=True),
    ),
    Quantity(
        "error_bound",
        "body",
        "bound on the rounding error of the jump, relative to the motion",
        "1",
        "greater",
        _error_bounds,
        computation=Computation("health", postures="one"),
    ),
    Quantity(
        "delta_v_max",
        "body",
        "maximum |Δv| over the body",
        "m/s",
        "greater",
        _greatest_delta_v,
        scope=Scope(NO_GEOMETRY),
    ),
)
