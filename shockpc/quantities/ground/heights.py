"""Heights by which flat ground allows a landing, and how fast they change.

They have either sign, so that a constraint on a posture can follow them.
"""

from collections.abc import Sequence

import numpy as np

from shockpc.core.spatial import Array
from shockpc.impact.impact import Impact
from shockpc.landing.landing import Landing
from shockpc.landing.places import Place
from shockpc.method.constraints import Constraint, constraint_point, wrenches
from shockpc.method.dynamics import Dynamics
from shockpc.quantities.ground.levels import Levels, levels, lowest_points_of_shapes, on_ground
from shockpc.quantities.quantity import Quantity
from shockpc.robot.shapes.geometry import body_outline


def _levels_of_all(landing: Landing, state: Dynamics, constraints: Sequence[Constraint]) -> Levels:
    """Heights of every body in N postures."""
    points = _grounded_points(landing, state, constraints)
    return levels(landing, state.rotation, state.position, points, every=True)


def _grounded_points(landing: Landing, state: Dynamics, constraints: Sequence[Constraint]) -> Array:
    """Points (N, c, 3) of the contacts and standing feet on flat ground, from the base [m]."""
    return np.stack([constraint_point(state, constraints[k]) for k in on_ground(landing)], axis=1)


def _clearances(landing: Landing, heights: Levels, places: Sequence[Place]) -> Array:
    """`CLEARANCE` (N, n) of n bodies in N postures; inf of one without other shapes."""
    bodies = body_outline(landing.robot).pieces.body
    low = heights.contacts.min(axis=1)
    clearances = np.empty((len(low), len(places)))
    for k, place in enumerate(places):
        own = heights.of_no_contact & (bodies == place.body)
        clearances[:, k] = heights.surface[:, own].min(axis=1, initial=np.inf) - low
    return clearances


def _reach(
    landing: Landing, state: Dynamics, constraints: Sequence[Constraint], places: Sequence[Place]
) -> tuple[Array, np.ndarray]:
    """`REACH` of n contacts without shapes in N postures, (N, n), and the lowest shapes (N, n).

    Where it is less than a contact point may lie inside, the shape does not count as that of the
    contact, and `CLEARANCE` jumps.
    """
    heights = _levels_of_all(landing, state, constraints)
    bodies = body_outline(landing.robot).pieces.body
    cores = []
    points = []
    for place in places:
        contact = constraints[place.number]
        own = heights.of_no_contact & (bodies == contact.body)
        cores.append(np.where(own, heights.core, np.inf))
        points.append(constraint_point(state, contact) @ landing.up)
    core = np.stack(cores, axis=1)
    return core.min(axis=2) - np.stack(points, axis=1), core.argmin(axis=2)


def _spread_of(impact: Impact, places: Sequence[Place]) -> Array:
    """`SPREAD` (N, 1, 1) in N postures."""
    del places
    heights = _levels_of_all(impact.landing, impact.state, impact.constraints)
    return heights.spread[:, None, None]


def _clearance_of(impact: Impact, places: Sequence[Place]) -> Array:
    """`CLEARANCE` (N, 1, n) in N postures."""
    heights = _levels_of_all(impact.landing, impact.state, impact.constraints)
    return _clearances(impact.landing, heights, places)[:, None]


def _reach_of(impact: Impact, places: Sequence[Place]) -> Array:
    """`REACH` (N, 1, n) in N postures."""
    reaches, _ = _reach(impact.landing, impact.state, impact.constraints, places)
    return reaches[:, None]


SPREAD = Quantity(
    "spread", "robot", "difference in height of the contacts", "m", "neither", _spread_of
)
CLEARANCE = Quantity(
    "clearance",
    "body",
    "height of the body above the lowest contact",
    "m",
    "neither",
    _clearance_of,
)
REACH = Quantity(
    "reach",
    "contact",
    "height of the link's lowest point above the contact",
    "m",
    "neither",
    _reach_of,
)
HEIGHTS = (SPREAD, CLEARANCE, REACH)
"""Numbers by which `feasible` decides; they have either sign, so that a constraint can follow."""


def reach_rates(
    landing: Landing,
    state: Dynamics,
    constraints: Sequence[Constraint],
    twists: Array,
    places: Sequence[Place],
) -> tuple[Array, Array]:
    """`REACH` of n contacts, (N, n) in N postures, and how fast (N, n, d) it changes.

    Args: as for `height_rates`.
    """
    values, lowest = _reach(landing, state, constraints, places)
    low = np.take_along_axis(lowest_points_of_shapes(landing, state), lowest[..., None], axis=1)
    contacts = [constraints[place.number] for place in places]
    arms = low - np.stack([constraint_point(state, contact) for contact in contacts], axis=1)
    # Both points turn with the body: the rate is (r × n) · ω.
    turning = twists[:, [contact.body for contact in contacts], :3]
    return values, (np.cross(arms, landing.up)[:, :, None] @ turning)[:, :, 0]


def height_rates(
    landing: Landing,
    state: Dynamics,
    constraints: Sequence[Constraint],
    twists: Array,
    places: Sequence[Place],
) -> tuple[Array, Array]:
    """`SPREAD` and `CLEARANCE` of n bodies (N, 1 + n), and their rates (N, 1 + n, d) in d motions.

    Spread and clearance change as the lowest points rise: each at ω · (p × n) + v · n, with the
    ground's normal n. Which points are the lowest changes at kinks.

    Args:
        landing: names the contacts and the standing feet.
        state: the robot in the postures.
        constraints: the rows of the contacts, then of the standing feet.
        twists: (N, nb, 6, d) of the bodies in d motions, world axes, about the base.
        places: the n bodies; the clearance of a place that is none is infinite.
    """
    levels_here = _levels_of_all(landing, state, constraints)
    clearances = _clearances(landing, levels_here, places)
    spread = levels_here.spread[:, None]
    values = np.concatenate([spread, clearances], axis=1)

    # Points that may be the lowest ones: of all shapes, and of the contacts.
    grounded = _grounded_points(landing, state, constraints)
    points = np.concatenate([lowest_points_of_shapes(landing, state), grounded], axis=1)
    of_contacts = [constraints[k].body for k in on_ground(landing)]
    bodies = np.append(body_outline(landing.robot).pieces.body, of_contacts)

    # The height of the lowest contact, of the highest one, and of each body; among the points of
    # all bodies, of all, and of that body. The lowest point of a contact is that of one of the
    # link's shapes, or the contact point.
    lowest = levels_here.contacts.min(axis=1)[:, None]
    sought = np.concatenate([lowest, lowest + values], axis=1)
    every = bodies >= 0
    among = np.array([every, every, *(bodies == place.body for place in places)])
    away = np.abs((points @ landing.up)[:, None] - sought[..., None])
    nearest = np.where(among, away, np.inf).argmin(axis=2)

    # Each point rises at ω · (p × n) + v · n.
    at = np.take_along_axis(points, nearest[..., None], axis=1)
    up = np.broadcast_to(landing.up, (*nearest.shape, 1, 3))
    of_bodies = twists[np.arange(len(twists))[:, None], bodies[nearest]]
    rates = (wrenches(at, up, 1) @ of_bodies)[:, :, 0]
    return values, rates[:, 1:] - rates[:, :1]
