"""Quantities of contacts and standing feet: what the ground does, and how the robot resists."""

from typing import Any

import numpy as np

from shockpc.core.percussion import dot, norm
from shockpc.core.spatial import Array, cross
from shockpc.impact.impact import Impact
from shockpc.method.constraints import (
    Constraint,
    constraint_axes,
    constraint_point,
    slices_of,
    world_point,
)
from shockpc.quantities.effective_mass import resistance
from shockpc.quantities.quantity import (
    IN_DOUBLES_WHERE_CLEAR,
    Places,
    Quantity,
    Relations,
    Scope,
    of_ratio,
    once_per_impact,
    reach,
)

STANDS = "a standing foot has no contact velocity"
REDUNDANT = "contacts are redundant, so the impulse of a single one is not determined"
PULLED = f"{REDUNDANT}; or the contact receives no impulse, or the ground would have to pull it"
MITIGATION = (
    "it requires a free base, no stance, no loop that ties the robot to the world, and no end stop"
)


STEEP = 1e-9
"""Component along the normal from which on a force of a contact pushes or pulls [1]."""

PULLS = 1e-12
"""Share of the impulse of a contact from which on its pull is no rounding [1]."""


def _rows(impact: Impact, places: Places) -> list[tuple[Constraint, slice]]:
    """The constraint of each contact, and where its rows are."""
    slices = slices_of(impact.constraints)
    return [(impact.constraints[place.number], slices[place.number]) for place in places]


def _forces(impact: Impact, places: Places) -> Any:
    """Impulses (N, S, n, 3) of contacts [N s], determined or not."""
    forces = [_force(impact, contact, rows) for contact, rows in _rows(impact, places)]
    return np.stack(forces, axis=-2)


def _force(impact: Impact, contact: Constraint, rows: slice) -> Any:
    """Impulse (N, S, 3) of a contact [N s]: the sum of those along the axes of its forces."""
    n = len(contact.forces)
    impulse = impact.along(impact.impulse)[..., rows][..., :n]
    if contact.kind != "stop":
        return impulse @ impact.exact(contact.forces)
    axes = constraint_axes(impact.state, contact)[:, None, :n]
    # A hinge's stop has no force, whose sum is no ball.
    return (impulse[..., None, :] @ axes)[..., 0, :] + impact.exact(np.zeros(3))


def _determined(impact: Impact, places: Places) -> np.ndarray:
    """(N, 1, n) bool, True where the impulse of a contact is determined."""
    known = []
    for contact, rows in _rows(impact, places):
        unique = impact.unique[:, None, rows]
        known.append(unique[..., : len(contact.forces)].all(axis=-1))
    return np.stack(known, axis=-1)


def _moment_determined(impact: Impact, places: Places) -> np.ndarray:
    """(N, 1, n) bool, True where force and moment of a contact are determined."""
    known = [impact.unique[:, None, rows].all(axis=-1) for _, rows in _rows(impact, places)]
    return np.stack(known, axis=-1)


def _point(impact: Impact, places: Places) -> Any:
    """Points (N, 1, n, 3) at which the contacts strike, world [m]."""
    origin = impact.exact(impact.state.origin)
    points = [
        constraint_point(impact.state, contact) + origin for contact, _ in _rows(impact, places)
    ]
    return np.stack(points, axis=1)[:, None]


def _impulse(impact: Impact, places: Places) -> Any:
    """Impulses (N, S, n, 3) of contacts [N s]; NaN where they are not determined."""
    forces = _forces(impact, places)
    return np.where(_determined(impact, places)[..., None], forces, np.nan)


def _moment(impact: Impact, places: Places) -> Any:
    """Moments (N, S, n, 3) about the contact points [N m s]; NaN of a point."""
    impulse = impact.along(impact.impulse)
    moments = []
    for contact, rows in _rows(impact, places):
        n = len(contact.forces)
        axes = impact.exact(contact.moments)
        if contact.kind == "stop":
            axes = constraint_axes(impact.state, contact)[:, None, n:]
        moment = (impulse[..., rows][..., None, n:] @ axes)[..., 0, :]
        known = len(contact.moments) and impact.unique[:, None, rows].all(axis=-1, keepdims=True)
        moments.append(np.where(known, moment, np.nan))
    return np.stack(moments, axis=-2)


def _normal_impulse(impact: Impact, places: Places) -> tuple[Any, Any, np.ndarray]:
    """Impulses (N, S, n) along the normals, the normals (n, 3), and where the ground pushes.

    The last is (N, S, n) bool.
    """
    up = impact.exact(np.array([contact.normal for contact, _ in _rows(impact, places)]))
    normal = dot(_forces(impact, places), up)
    # A normal impulse that may be zero is none: of a ball around zero the midpoint has either sign.
    numbers = impact.rounded(normal, lambda values: _impulse_size(impact, values))
    pressed = (numbers > 0.0) & _determined(impact, places)
    return normal, up, pressed


def _per_normal(values: Any, normal: Any, pressed: np.ndarray) -> Any:
    """Values (N, S, n) per normal impulse; NaN where the ground does not push."""
    return np.where(pressed, values / np.where(pressed, normal, 1), np.nan)


def friction_needed(impact: Impact, places: Places) -> Any:
    """Tangential over normal impulse (N, S, n) [1]; NaN where the ground would have to pull."""
    normal, up, pressed = _normal_impulse(impact, places)
    tangential = norm(_forces(impact, places) - normal[..., None] * up)
    return _per_normal(tangential, normal, pressed)


def _centre_of_pressure(impact: Impact, places: Places) -> Any:
    """Points (N, S, n, 3) at which the normal impulses act, world [m].

    r = p + n × M / (n · ι) of the contact point p.
    """
    normal, up, pressed = _normal_impulse(impact, places)
    pressed = pressed & _moment_determined(impact, places)
    points = np.broadcast_to(_point(impact, places), (*pressed.shape, 3))
    # A point, and a corner that slides, have no moment.
    has_moment = np.array([len(contact.moments) > 0 for contact, _ in _rows(impact, places)])
    known = (pressed & has_moment)[..., None]
    moment = np.where(known, _moment(impact, places), impact.exact(np.zeros(3)))
    pushed = np.where(pressed, normal, 1)[..., None]
    aside = cross(np.broadcast_to(up, moment.shape), moment) / pushed
    return np.where(pressed[..., None], points + aside, np.nan)


def _twist_needed(impact: Impact, places: Places) -> Any:
    """Friction (N, S, n) that the twist of each contact needs [1]; NaN of a point.

    It is |n · M| / (n · ι · d). d is the mean distance of the corners of the sole from the centre
    of pressure, as if each carried the same.
    """
    normal, up, pressed = _normal_impulse(impact, places)
    pressed = pressed & _moment_determined(impact, places)
    twist = np.abs(dot(_moment(impact, places), up))
    origin = impact.exact(impact.state.origin)[:, None, None]
    centres = _centre_of_pressure(impact, places) - origin
    needed = []
    for k, (contact, _) in enumerate(_rows(impact, places)):
        if not len(contact.sole) or not len(contact.moments):
            needed.append(np.full(pressed.shape[:-1], np.nan))
            continue
        corners = [world_point(impact.state, contact.body, corner) for corner in contact.sole]
        distances = [norm(centres[:, :, k] - corner[:, None]) for corner in corners]
        arm = np.sum(distances, axis=0) / len(corners)
        needed.append(_per_normal(twist[..., k], normal[..., k] * arm, pressed[..., k]))
    return np.stack(needed, axis=-1)


@once_per_impact
def pull(impact: Impact, places: Places) -> Any:
    """Impulses (N, S, n) with which the ground would have to pull [N s].

    They are 0 where it pushes, and NaN where the impulse is not determined.
    """
    impulse = impact.along(impact.impulse)
    pulls = []
    for contact, rows in _rows(impact, places):
        unique = impact.unique[:, None, rows]
        along = impulse[..., rows]
        if contact.kind == "stop":
            push = along[..., 0].astype(float)
            pulls.append(np.where(unique[..., 0], np.maximum(-push, 0.0), np.nan))
            continue
        rising = contact.forces @ contact.normal
        steep = np.flatnonzero(np.abs(rising) > STEEP)
        along = along[..., : len(rising)].astype(float)
        normal = along[..., steep] @ rising[steep]
        least = PULLS * np.linalg.norm(along, axis=-1)
        pulled = np.where(normal < -least, -normal, 0.0)
        pulls.append(np.where(unique[..., steep].all(axis=-1), pulled, np.nan))
    return np.stack(pulls, axis=-1)


def _approach(impact: Impact, places: Places) -> Any:
    """Velocity (N, S, n, 3) of the contact points before the impact; NaN of a standing foot."""
    none = np.full((*impact.approach.shape[:2], 3), np.nan)
    velocities = []
    for place in places:
        strikes = place.number < len(impact.contacts)
        velocities.append(impact.approach[:, :, place.number] if strikes else none)
    return np.stack(velocities, axis=-2)


def _impulse_size(impact: Impact, values: Array) -> float:
    """The largest impulse along a row [N s, N m s]."""
    del values
    return float(np.abs(impact.along(impact.impulse).astype(float)).max(initial=0.0))


def _fastest(impact: Impact, values: Array) -> float:
    """The largest component of the motion before the impact [m/s, rad/s]."""
    del values
    return float(np.abs(np.concatenate(impact.landing.before)).max())


IMPULSE = Quantity(
    "impulse",
    "contact",
    "impulse of the ground on the robot, world axes",
    "N s",
    "greater",
    _impulse,
    _impulse_size,
    form="vector",
    scope=Scope(REDUNDANT),
    relations=Relations(also=("friction",), linear=True),
)

CONTACTS = (
    Quantity(
        "point", "contact", "contact point, world", "m", "neither", _point, reach, form="vector"
    ),
    IMPULSE,
    Quantity(
        "friction_needed",
        "contact",
        "friction to stick",
        "1",
        "greater",
        friction_needed,
        of_ratio,
        scope=Scope(PULLED),
    ),
    Quantity(
        "approach",
        "contact",
        "velocity before the impact, world axes",
        "m/s",
        "neither",
        _approach,
        _fastest,
        form="vector",
        scope=Scope(STANDS, strikes=True),
    ),
    Quantity(
        "effective_mass_sticking",
        "contact",
        "effective mass if it sticks",
        "kg",
        "greater",
        resistance("sticking"),
        scope=Scope(STANDS, strikes=True),
        computation=IN_DOUBLES_WHERE_CLEAR,
    ),
    Quantity(
        "effective_mass_frictionless",
        "contact",
        "effective mass if it slides",
        "kg",
        "greater",
        resistance("frictionless"),
        scope=Scope(STANDS, strikes=True),
        computation=IN_DOUBLES_WHERE_CLEAR,
    ),
    Quantity(
        "mitigation",
        "contact",
        "impact mitigation factor if it sticks",
        "1",
        "less",
        resistance("mitigation"),
        of_ratio,
        scope=Scope(MITIGATION),
        computation=IN_DOUBLES_WHERE_CLEAR,
    ),
    Quantity(
        "mitigation_frictionless",
        "contact",
        "impact mitigation factor if it slides",
        "1",
        "less",
        resistance("mitigation_frictionless"),
        of_ratio,
        scope=Scope(MITIGATION),
        computation=IN_DOUBLES_WHERE_CLEAR,
    ),
    Quantity(
        "moment",
        "contact",
        "moment about the contact point, world axes",
        "N m s",
        "greater",
        _moment,
        _impulse_size,
        form="vector",
        scope=Scope(f"{REDUNDANT}; or it is a point"),
    ),
    Quantity(
        "effective_mass",
        "contact",
        "effective mass",
        "kg",
        "greater",
        resistance("effective"),
        scope=Scope(STANDS, strikes=True),
        computation=IN_DOUBLES_WHERE_CLEAR,
    ),
    Quantity(
        "centre_of_pressure",
        "contact",
        "centre of pressure, world",
        "m",
        "neither",
        _centre_of_pressure,
        reach,
        form="vector",
        scope=Scope(PULLED),
    ),
    Quantity(
        "twist_needed",
        "contact",
        "friction against twist",
        "1",
        "greater",
        _twist_needed,
        of_ratio,
        scope=Scope(f"{PULLED}; or it is a point, or a sole that is not known"),
    ),
    Quantity(
        "tensile_impulse",
        "contact",
        "impulse with which the ground would have to pull",
        "N s",
        "greater",
        pull,
        scope=Scope(REDUNDANT),
        relations=Relations(role="pull"),
    ),
)
