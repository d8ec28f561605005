"""What an impact does to the robot as a whole, and how far its numbers are known."""

from typing import Any, Literal

import numpy as np

from shockpc.core.memo import memoized
from shockpc.core.spatial import Array
from shockpc.impact.impact import DoubleImpact, Impact
from shockpc.landing.level_feet import feet_beside
from shockpc.method.approach import approach_speeds
from shockpc.method.constraints import block_point
from shockpc.quantities.heights import Levels, levels, on_ground
from shockpc.quantities.of_contacts import pull
from shockpc.quantities.quantity import Evaluation, Places, Quantity, Relations, Scope

DRIVEN = "a motor holds the rate of a joint and does work"

GAINS = "with friction and restitution the impact would gain energy"

ROUNDING = 1e-9
"""Share of the work of the impulse on the approach below which a gain of energy is rounding: a full
rebound loses none.
"""

UNKNOWN = (
    "the base is fixed, a foot stands or a contact has a velocity, so the energy before the impact "
    "is not determined"
)


def _one(values: Any) -> Any:
    """Values of the one robot: (N, S, ...) as (N, S, 1, ...)."""
    return values[:, :, None]


def _mass(impact: Impact, places: Places) -> Array:
    del places
    moving = impact.inertias.mass[:, impact.landing.robot.movable(impact.landing.base)]
    return np.array(
        np.broadcast_to(np.asarray(sum(moving.T))[:, None, None], (*impact.v_in.shape, 1))
    )


def _approach(impact: Impact) -> Any:
    """v⁻ along each row (N, nc, 4 or 3), as `approach_speeds` without restitution [m/s, rad/s]."""
    before = impact.landing.before if impact.speeds.shape[-1] == 4 else None
    return approach_speeds(
        impact.state, [block._replace(restitution=0.0) for block in impact.blocks], before
    )


def _works(impact: Impact) -> Any:
    """λᵢ (v⁻ᵢ + v⁺ᵢ) of each row (N, S, nc), whose sum is −2 times the energy lost [J]; v⁺ = v⁻ −
    b.
    """
    return impact.along(impact.independent_impulse) * impact.along(
        2 * _approach(impact) - impact.speeds
    )


def _energy_lost(impact: Impact, places: Places) -> Any:
    del places
    lost = _one(-np.sum(_works(impact), axis=-1) / 2)
    return np.where(_motors_work(impact), np.nan, lost)


def _energy_gained(impact: Impact, places: Places) -> Array:
    """Kinetic energy (N, S, 1) that the impact would make [J]; 0 where it loses some, or gains no
    more than rounding.
    """
    made = -_energy_lost(impact, places).astype(float)
    work = np.abs(
        (impact.along(impact.independent_impulse) * impact.along(_approach(impact))).astype(float)
    ).sum(axis=-1)
    return np.asarray(np.where(made > ROUNDING * _one(work), made, 0.0 * made + 0.0))


def _motors_work(impact: Impact) -> bool:
    """Whether a motor holds the rate of a joint that moves, and so does work during the impact."""
    landing = impact.landing
    return bool(
        np.any(
            landing.joint_model.locked
            & (np.asarray(landing.before.joint_rates, dtype=float) != 0.0)
        )
    )


def _energy_share(impact: Impact, places: Places) -> Any:
    lost, before = _energy_lost(impact, places), _one(impact.kinetic_energy_before)
    driven = any(
        contact.velocity is not None for contact in impact.landing.contacts
    ) or _motors_work(impact)
    known = np.full(before.shape, impact.landing.floating and not driven) & (
        before.astype(float) > 0.0
    )
    return np.where(known, lost / np.where(known, before, 1), np.nan)


def _energy_size(impact: Impact, values: Array) -> Any:
    del values
    return np.abs(_works(impact).astype(float)).sum(axis=-1)[..., None]


def _force_size(impact: Impact, values: Array) -> Any:
    del values
    return np.abs(impact.along(impact.independent_impulse).astype(float)).sum(axis=-1)[
        ..., None, None
    ]


def _moment_size(impact: Impact, values: Array) -> Any:
    size = float(np.abs(impact.state.position.astype(float)).max()) + float(
        np.abs(impact.inertias.com).max()
    )
    return _force_size(impact, values) * (size or 1.0)


@memoized()
def _levels(impact: Impact) -> Levels | None:
    """Heights of the robot's geometry, from doubles; None where no contact is on flat ground."""
    if not (level := on_ground(impact.landing)):
        return None
    state = impact.state
    points = np.stack([block_point(state, impact.blocks[k]) for k in level], axis=1)
    rotation, position, points = (
        part.astype(float, copy=False) for part in (state.rotation, state.position, points)
    )
    return levels(impact.landing, rotation, position, points)


def _depth(impact: Impact, places: Places) -> Array:
    """How far (N, 1, 1) the geometry of other links reaches below the lowest contact or standing
    foot on flat ground [m].
    """
    del places
    here = _levels(impact)
    return np.asarray(
        _one((np.full(len(impact.state.J), np.nan) if here is None else here.depth)[:, None])
    )


def _feasible(impact: Impact, places: Places) -> Array:
    """Whether (N, S, 1) a drop on flat ground is this landing: flat ground allows it, and no other
    foot is level; 0 or 1.
    """
    return np.asarray(_allowed(impact) * (1.0 - _others_level(impact)))


def _feasible_if_tilted(impact: Impact, places: Places) -> Array:
    """Whether (N, S, 1) flat ground allows the landing, and other feet are level with its contacts;
    0 or 1.
    """
    return np.asarray(_allowed(impact) * _others_level(impact))


def _others_level(impact: Impact) -> Array:
    """Whether (N, S, 1) feet are as low as the contacts and do not strike, where the robot comes
    down as a whole; 0 or 1.

    With a fixed base, standing feet, or feet that approach at different speeds, because the robot
    or its joints turn, no feet land together.
    """
    landing, state = impact.landing, impact.state
    level = np.zeros(len(state.J), dtype=bool)
    if landing.base != "fixed" and not landing.stance and on_ground(landing):
        rotation, position = (
            part.astype(float, copy=False) for part in (state.rotation, state.position)
        )
        beside = feet_beside(landing, rotation, position)
        before = landing.before
        turns = before.omega.any(axis=-1) | before.joint_rates.any(axis=-1)
        driven = any(contact.velocity is not None for contact in landing.contacts)
        level = np.asarray(beside.any(axis=1) & ~turns & (not driven))
    return np.broadcast_to(level[:, None, None], (*impact.v_in.shape, 1)).astype(float)


def _allowed(impact: Impact) -> Array:
    """Whether (N, S, 1) flat ground allows the landing: it pulls nothing, touches all contacts and
    meets no other link; 0 or 1.

    An impact that would make energy is no landing either.

    Heights of lowest points count as equal up to the scene's `ground_tolerance`; without geometry
    only contact points are compared. With the scene's friction nothing is pulled: a contact that
    would be opens, and one that needs more friction slides. In doubles NaN where the impact may
    then gain energy, which the analysis of the landing refuses.
    """
    landing = impact.landing
    refused = (pull(impact, landing.contact_places) > 0.0).any(axis=-1) | (
        _energy_gained(impact, ())[..., 0] > 0.0
    )
    refused = refused & (landing.scene.friction is None)
    if (here := _levels(impact)) is not None:
        refused = refused | here.uneven[:, None] | (here.below & (landing.base != "fixed"))[:, None]
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
        evaluation=Evaluation("health", postures="one"),
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
        lambda i, p: _one(i.v_in),
        lambda i, x: 1e-12 * float(np.abs(np.concatenate(i.landing.before)).max()),
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
        lambda i, x: 1.0,
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
