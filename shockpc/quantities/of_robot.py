"""Quantities of the robot as a whole, and errors of its numbers."""

from typing import Any, Literal

import numpy as np

from shockpc.core.memo import memoized
from shockpc.core.spatial import Array
from shockpc.impact.impact import DoubleImpact, Impact
from shockpc.landing.feet.level_feet import feet_beside
from shockpc.method.approach import approach_speeds
from shockpc.method.constraints import constraint_point
from shockpc.quantities.ground.levels import Levels, levels, on_ground
from shockpc.quantities.of_contacts import pull
from shockpc.quantities.quantity import Computation, Places, Quantity, Relations, Scope, of_ratio

DRIVEN = "a motor holds the rate of a joint and does work"

GAINS = "with friction and restitution the impact would gain energy"

ROUNDING = 1e-9
"""Share of the work of the impulse on the approach below which a gain of energy is rounding.

A full rebound loses none.
"""

UNKNOWN = (
    "the base is fixed, a foot stands or a contact has a velocity, so the energy before the impact "
    "is not determined"
)


def _one(values: Any) -> Any:
    """Values of the one robot: (N, S, ...) as (N, S, 1, ...)."""
    return values[:, :, None]


def _v_in(impact: Impact, places: Places) -> Any:
    """The speed (N, S, 1) that shock is relative to [m/s]."""
    del places
    return _one(impact.v_in)


def _v_in_size(impact: Impact, values: Array) -> float:
    """The size of a speed that is no rounding of the largest component before the impact [m/s]."""
    del values
    return 1e-12 * float(np.abs(np.concatenate(impact.landing.before)).max())


def _mass(impact: Impact, places: Places) -> Array:
    """The mass of the bodies that move (N, S, 1) [kg]."""
    del places
    moving = impact.inertias.mass[:, impact.landing.robot.movable(impact.landing.base)]
    total = np.asarray(sum(moving.T))[:, None, None]
    return np.array(np.broadcast_to(total, (*impact.v_in.shape, 1)))


def _approach(impact: Impact) -> Any:
    """v⁻ along each row (N, nc, 4 or 3), as `approach_speeds` without restitution [m/s, rad/s]."""
    has_strike = impact.speeds.shape[-1] == 4
    before = impact.landing.before if has_strike else None
    plastic = [constraint._replace(restitution=0.0) for constraint in impact.constraints]
    return approach_speeds(impact.state, plastic, before)


def _works(impact: Impact) -> Any:
    """λᵢ (v⁻ᵢ + v⁺ᵢ) of each row (N, S, nc), whose sum is −2 times the energy lost [J].

    v⁺ = v⁻ − b.
    """
    both = impact.along(2 * _approach(impact) - impact.speeds)
    return impact.along(impact.independent_impulse) * both


def _energy_lost(impact: Impact, places: Places) -> Any:
    del places
    lost = _one(-np.sum(_works(impact), axis=-1) / 2)
    return np.where(_motors_work(impact), np.nan, lost)


def _energy_gained(impact: Impact, places: Places) -> Array:
    """Kinetic energy (N, S, 1) that the impact would make [J].

    It is 0 where the impact loses some, or gains no more than rounding.
    """
    gained = -_energy_lost(impact, places).astype(float)
    works = impact.along(impact.independent_impulse) * impact.along(_approach(impact))
    work = np.abs(works.astype(float)).sum(axis=-1)
    # NaN stays NaN.
    nothing = 0.0 * gained + 0.0
    return np.asarray(np.where(gained > ROUNDING * _one(work), gained, nothing))


def _motors_work(impact: Impact) -> bool:
    """True if a motor holds the rate of a joint that moves, and so does work in the impact."""
    rates = np.asarray(impact.landing.before.joint_rates, dtype=float)
    return bool(np.any(impact.landing.joint_model.locked & (rates != 0.0)))


def _energy_share(impact: Impact, places: Places) -> Any:
    """Energy lost, of that before (N, S, 1); NaN where the latter is not determined."""
    landing = impact.landing
    lost = _energy_lost(impact, places)
    before = _one(impact.kinetic_energy_before)
    known = before.astype(float) > 0.0
    driven = any(contact.velocity is not None for contact in landing.contacts)
    if not landing.floating or driven or _motors_work(impact):
        return np.full(lost.shape, np.nan)
    return np.where(known, lost / np.where(known, before, 1), np.nan)


def _energy_size(impact: Impact, values: Array) -> Any:
    del values
    return np.abs(_works(impact).astype(float)).sum(axis=-1)[..., None]


def _force_size(impact: Impact, values: Array) -> Any:
    del values
    impulse = impact.along(impact.independent_impulse).astype(float)
    return np.abs(impulse).sum(axis=-1)[..., None, None]


def _moment_size(impact: Impact, values: Array) -> Any:
    positions = np.abs(impact.state.position.astype(float)).max()
    centres = np.abs(impact.inertias.com).max()
    size = float(positions) + float(centres)
    return _force_size(impact, values) * (size or 1.0)


@memoized()
def _levels(impact: Impact) -> Levels | None:
    """Heights of the robot's geometry, from doubles; None where no contact is on flat ground."""
    landing = impact.landing
    on_flat = on_ground(landing)
    if not on_flat:
        return None
    state = impact.state
    points = np.stack([constraint_point(state, impact.constraints[k]) for k in on_flat], axis=1)
    rotation = state.rotation.astype(float, copy=False)
    position = state.position.astype(float, copy=False)
    return levels(landing, rotation, position, points.astype(float, copy=False))


def _depth(impact: Impact, places: Places) -> Array:
    """Depth (N, 1, 1) of other links below the lowest contact on flat ground [m].

    Standing feet count as contacts; NaN where no contact is on flat ground.
    """
    del places
    heights = _levels(impact)
    depth = np.full(len(impact.state.J), np.nan) if heights is None else heights.depth
    return np.asarray(_one(depth[:, None]))


def _feasible(impact: Impact, places: Places) -> Array:
    """(N, S, 1) 1 where a drop on flat ground is this landing, else 0.

    Flat ground allows it, and no other foot is level.
    """
    return np.asarray(_allowed(impact) * (1.0 - _others_level(impact)))


def _feasible_if_tilted(impact: Impact, places: Places) -> Array:
    """(N, S, 1) 1 where flat ground allows the landing and other feet are level with its contacts.

    It is 0 elsewhere.
    """
    return np.asarray(_allowed(impact) * _others_level(impact))


def _others_level(impact: Impact) -> Array:
    """(N, S, 1) 1 where feet that do not strike are as low as the contacts, else 0.

    With a fixed base, standing feet, or feet that approach at different speeds, because the robot
    or its joints turn, no feet land together.
    """
    landing, state = impact.landing, impact.state
    before = landing.before
    driven = any(contact.velocity is not None for contact in landing.contacts)
    is_free = landing.base != "fixed" and not landing.stance
    level = np.zeros(len(state.J), dtype=bool)
    if is_free and not driven and on_ground(landing):
        rotation = state.rotation.astype(float, copy=False)
        position = state.position.astype(float, copy=False)
        turns = before.omega.any(axis=-1) | before.joint_rates.any(axis=-1)
        beside = feet_beside(landing, rotation, position).any(axis=1)
        level = np.asarray(beside & ~turns)
    every = np.broadcast_to(level[:, None, None], (*impact.v_in.shape, 1))
    return every.astype(float)


def _allowed(impact: Impact) -> Array:
    """(N, S, 1) 1 where flat ground allows the landing, else 0.

    It pulls nothing, touches all contacts and meets no other link; and an impact that would make
    energy is no landing either.

    Heights of lowest points count as equal up to the scene's `ground_tolerance`; without geometry
    only contact points are compared. With the scene's friction nothing is pulled: a contact that
    would be opens, and one that needs more friction slides. In doubles NaN where the impact may
    then gain energy, which the analysis of the landing refuses.
    """
    landing = impact.landing
    pulled = (pull(impact, landing.contact_places) > 0.0).any(axis=-1)
    gains = _energy_gained(impact, ())[..., 0] > 0.0
    refused = (pulled | gains) & (landing.scene.friction is None)
    heights = _levels(impact)
    if heights is not None:
        refused = refused | heights.uneven[:, None]
        if landing.base != "fixed":
            refused = refused | heights.below[:, None]
    allowed = np.where(refused, 0.0, 1.0)
    if isinstance(impact, DoubleImpact):
        from shockpc.impact.friction import may_gain_with_friction

        allowed = np.where(may_gain_with_friction(impact), np.nan, allowed)
    return np.asarray(_one(allowed))


def _health(
    key: str, title: str, unit: str = "1", worse: Literal["greater", "neither"] = "greater"
) -> Quantity:
    """A number of the profile's health, which the document has as a record."""
    return Quantity(
        key,
        "robot",
        title,
        unit,
        worse,
        lambda health, _: [getattr(health, key)],
        computation=Computation("health", postures="one"),
    )


ENERGY_LOST = Quantity(
    "energy_lost",
    "robot",
    "kinetic energy lost",
    "J",
    "greater",
    _energy_lost,
    _energy_size,
    scope=Scope(DRIVEN),
)

FEASIBLE_IF_TILTED = Quantity(
    "feasible_if_tilted",
    "robot",
    "whether a drop on flat ground is this landing if the robot is tilted slightly",
    "1",
    "neither",
    _feasible_if_tilted,
    scope=Scope(GAINS),
    relations=Relations(role="tilt"),
)
"""A column of sweeps beside `feasible`, by which landings on some of several level feet are kept.
"""

ROBOT = (
    Quantity("mass", "robot", "mass", "kg", "neither", _mass),
    Quantity(
        "v_in",
        "robot",
        "speed that shock is relative to",
        "m/s",
        "neither",
        _v_in,
        _v_in_size,
    ),
    Quantity(
        "total_impulse",
        "robot",
        "impulse of the ground, world axes",
        "N s",
        "greater",
        lambda i, p: _one(i.ground_impulse[0]),
        _force_size,
        form="vector",
        relations=Relations(also=("friction",)),
    ),
    Quantity(
        "total_moment",
        "robot",
        "its moment about the centre of mass, world axes",
        "N m s",
        "greater",
        lambda i, p: _one(i.ground_impulse[1]),
        _moment_size,
        form="vector",
        relations=Relations(also=("friction",)),
    ),
    ENERGY_LOST,
    Quantity(
        "energy_share",
        "robot",
        "kinetic energy lost, of that before",
        "1",
        "greater",
        _energy_share,
        of_ratio,
        scope=Scope(UNKNOWN),
    ),
    Quantity(
        "energy_gained",
        "robot",
        "kinetic energy that the impact would gain",
        "J",
        "greater",
        _energy_gained,
        scope=Scope(DRIVEN),
        relations=Relations(role="gain"),
    ),
    Quantity(
        "depth_below_contacts",
        "robot",
        "depth of other geometry below the contacts",
        "m",
        "greater",
        _depth,
        scope=Scope("the robot has no geometry, or no contact is on flat ground"),
    ),
    Quantity(
        "feasible",
        "robot",
        "whether a drop on flat ground is this landing, on all level feet",
        "1",
        "less",
        _feasible,
        scope=Scope(GAINS),
        relations=Relations(role="feasible"),
    ),
    FEASIBLE_IF_TILTED,
    _health("rank", "independent contact and closure rows", worse="neither"),
    _health("rows", "contact and closure rows", worse="neither"),
    _health("error_bound", "bound on the rounding error of the jumps, for the robot as loaded"),
    _health("double_error", "error of double precision"),
    _health("data_sensitivity", "effect of the last digit of the data"),
    _health("bits", "precision of the ball arithmetic", "bit", "neither"),
)
