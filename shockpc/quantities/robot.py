"""What an impact does to the robot as a whole, and how far its numbers are known."""

from typing import Any

import numpy as np

from shockpc.core.spatial import Array
from shockpc.impact import Impact
from shockpc.model.rows import block_point
from shockpc.plausibility import levels
from shockpc.quantities.quantity import Places, Quantity

__all__ = ["ROBOT"]

UNKNOWN = "the base is fixed, or a foot stands, so the energy before the impact is not determined"


def _one(values: Any) -> Any:
    """Values of the one robot: (N, S, ...) as (N, S, 1, ...)."""
    return values[:, :, None]


def _works(impact: Impact) -> Any:
    """λᵢ bᵢ (1 − e) / (1 + e) of each row (N, S, nc), whose sum is −2 times the energy lost [J].

    The energy is −½ λᵀ (v⁻ + v⁺): with v⁺ = −e v⁻ = v⁻ − b that is −½ λᵀ b (1 − e) / (1 + e).
    """
    e = impact.exact(np.repeat([block.restitution for block in impact.blocks], [block.size for block in impact.blocks]))
    return impact.along(impact.independent_impulse) * impact.along(impact.speeds) * (1 - e) / (1 + e)


def _energy_lost(impact: Impact, places: Places) -> Any:
    del places
    return _one(-np.sum(_works(impact), axis=-1) / 2)


def _energy_share(impact: Impact, places: Places) -> Any:
    lost, before = _energy_lost(impact, places), _one(impact.kinetic_energy_before)
    known = np.full(before.shape, impact.landing.floating) & (before.astype(float) > 0.0)
    return np.where(known, lost / np.where(known, before, 1), np.nan)


def _energy_size(impact: Impact, values: Array) -> Any:
    del values
    return np.abs(_works(impact).astype(float)).sum(axis=-1)[..., None]


def _force_size(impact: Impact, values: Array) -> Any:
    del values
    return np.abs(impact.along(impact.independent_impulse).astype(float)).sum(axis=-1)[..., None, None]


def _moment_size(impact: Impact, values: Array) -> Any:
    size = float(np.abs(impact.state.position.astype(float)).max()) + float(np.abs(impact.landing.robot.coms).max())
    return _force_size(impact, values) * (size or 1.0)


def _depth(impact: Impact, places: Places) -> Array:
    """How far (N, 1, 1) the geometry of other links reaches below the lowest contact or standing foot [m]; from doubles."""
    del places
    state, blocks = impact.state, impact.blocks[: len(impact.landing.contact_places)]
    points = np.stack([block_point(state, block) for block in blocks], axis=1)
    found = levels(impact.landing, *(part.astype(float) for part in (state.rotation, state.position, points)))
    lowest = found.surface[:, found.others].min(axis=1, initial=np.inf)
    depth = np.maximum(found.contacts.min(axis=1) - lowest, 0.0) if found.others.size else np.full(len(lowest), np.nan)
    return np.asarray(depth[:, None, None])


ROBOT = (
    Quantity("mass", "robot", "mass", "kg", "neither", lambda i, p: np.full((*i.v_in.shape, 1), i.landing.robot.mass)),
    Quantity("v_in", "robot", "speed that shock is relative to", "m/s", "neither", lambda i, p: _one(i.v_in), lambda i,
        x: 1e-12 * float(np.abs(np.concatenate(i.landing.before)).max())),
    Quantity("total_impulse", "robot", "impulse of the ground, world axes", "N s", "greater", lambda i,
        p: _one(i.ground_impulse[0]), _force_size, vector=True),
    Quantity("total_moment", "robot", "its moment about the centre of mass, world axes", "N m s", "greater", lambda i,
        p: _one(i.ground_impulse[1]), _moment_size, vector=True),
    Quantity("energy_lost", "robot", "kinetic energy lost", "J", "greater", _energy_lost, _energy_size),
    Quantity("energy_share", "robot", "kinetic energy lost, of that before", "1", "greater", _energy_share, lambda i, x: 1.0,
        UNKNOWN),
    Quantity("depth", "robot", "depth of other geometry below the contacts", "m", "greater", _depth,
        missing="the robot has no geometry"),
    Quantity("rank", "robot", "independent contact and closure rows", "1", posed=True),
    Quantity("rows", "robot", "contact and closure rows", "1", posed=True),
    Quantity("error_bound", "robot", "proven error of the jumps, for the robot as loaded", "1", "greater", posed=True),
    Quantity("double_error", "robot", "error of double precision", "1", "greater", posed=True),
    Quantity("data_sensitivity", "robot", "effect of the last digit of the data", "1", "greater", posed=True),
    Quantity("bits", "robot", "precision of the proof", "bit", posed=True),
)  # fmt: skip
