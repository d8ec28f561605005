"""The columns of a sweep: what is computed of every landing, from maps in double precision or from a proven profile."""

import functools
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from shockpc.core.directions import most_severe_directions
from shockpc.core.extremes import Pieces, greatest_shock
from shockpc.core.percussion import percussion, translation
from shockpc.core.spatial import Array, jump_at
from shockpc.landing import Landing, contact_velocity
from shockpc.model.motion import com_velocity
from shockpc.profile import impact_jumps, joined, needs_proof
from shockpc.result import ShockProfile
from shockpc.results.percussion import ROUNDED, robot_length
from shockpc.results.points import Spot
from shockpc.robot.record import Robot

__all__ = ["Solved", "Targets", "columns", "proven_columns", "solve"]

BLOCK = 256
"""Postures that are solved together, so that their arrays stay in the processor's cache."""

AXES = "xyz"
NOWHERE = np.full((1, 3), np.nan)


class Targets(NamedTuple):
    """What the columns are about.

    Attributes:
        spots: points.
        bodies: indices of bodies.
        pieces: geometry of each of these bodies, if the greatest shock over it is wanted; else empty.
    """

    spots: tuple[Spot, ...]
    bodies: tuple[int, ...]
    pieces: tuple[Pieces, ...]

    @property
    def carriers(self) -> tuple[int, ...]:
        """Indices of all bodies that a column needs, each once."""
        return tuple(dict.fromkeys([*(spot.frame.body for spot in self.spots), *self.bodies]))

    def shock_headings(self, robot: Robot) -> dict[str, str]:
        """The columns that hold a shock for the row's own strike, each with that of the most severe shock of the same point."""
        points = {f"{spot.label} shock [-]": f"{spot.label} most severe shock [-]" for spot in self.spots}
        severe = {robot.bodies[i].name: f"{robot.bodies[i].name} CoM most severe shock [-]" for i in self.bodies}
        greatest = {f"{name} greatest shock [-]": of for name, of in severe.items() if self.pieces}
        return points | {f"{name} shock at CoM [-]": of for name, of in severe.items()} | greatest

    def headings(self, robot: Robot) -> tuple[str, ...]:
        """The headings of all columns, with units."""
        nan, greatest = np.full(1, np.nan), np.full(1, np.nan) if self.pieces else None
        points = [_of_point(spot.label, nan, nan, NOWHERE) for spot in self.spots]
        bodies = [_of_body(robot.bodies[i].name, nan, greatest, NOWHERE, nan, nan, NOWHERE) for i in self.bodies]
        return (*(heading for part in (*points, *bodies) for heading in part), "friction needed [-]", "condition [-]")


def _of_point(label: str, shock: Array, severe: Array, directions: Array) -> dict[str, Array]:
    """The columns of a point. Args: severe, shock of the most severe impact direction; directions (…, 3), that direction."""
    return {
        f"{label} shock [-]": shock,
        f"{label} most severe shock [-]": severe,
        **{f"{label} most severe direction {axis} [-]": directions[..., k] for k, axis in enumerate(AXES)},
    }


def _of_body(
    name: str, shock: Array, greatest: Array | None, copc: Array, ropc: Array, severe: Array, directions: Array
) -> dict[str, Array]:
    """The columns of a body; shock and the most severe impact direction are those of its centre of mass."""
    centre = _of_point(f"{name} CoM", shock, severe, directions)
    del centre[f"{name} CoM shock [-]"]
    return {
        f"{name} shock at CoM [-]": shock,
        **({} if greatest is None else {f"{name} greatest shock [-]": greatest}),
        **{f"{name} CoPc {axis} [m]": copc[..., k] for k, axis in enumerate(AXES)},
        f"{name} RoPc [m]": ropc,
        **centre,
    }


class Solved(NamedTuple):
    """Steps 1 and 2 in m postures of one landing, of what the columns need.

    Attributes:
        jumps: (m, n, 6, k) of the carriers, world axes, for 1 m/s along x, y and z, then for the landing's own motion if that is
            more than a velocity of the base.
        rotation: (m, n, 3, 3) of the carriers.
        impulse: (m, nc, k) of the ground along every row; NaN where it is not determined.
        condition: (m,) of the solution.
        prove: (m,) whether it needs a proof.
        approach: (m, c, 3) velocity of every contact before the impact; None where it is that of the base everywhere.
        com: (m, 3) velocity of the robot's centre of mass, likewise, if shock is relative to it.
    """

    jumps: Array
    rotation: Array
    impulse: Array
    condition: Array
    prove: np.ndarray
    approach: Array | None
    com: Array | None


def solve(landing: Landing, Q: Array, targets: Targets) -> Solved:
    """Steps 1 and 2 in many postures (m, nq) of one landing."""
    own = bool(landing.before.omega.any() or landing.before.joint_rates.any())
    blocks = [_solve(landing, Q[k : k + BLOCK], targets.carriers, own) for k in range(0, len(Q), BLOCK)]
    jumps, rotation, impulse, condition, prove = (joined(part) for part in list(zip(*blocks, strict=True))[:5])
    before = [None if part[0] is None else np.concatenate(part) for part in list(zip(*blocks, strict=True))[5:]]
    return Solved(jumps, rotation, impulse, condition, prove, *before)


def _solve(landing: Landing, Q: Array, carriers: Sequence[int], own: bool) -> Solved:
    """The same in one block; own: whether the motion before the impact is more than a velocity of the base."""
    equation, impact, jumps = impact_jumps(landing, Q, own, carriers)
    condition, prove = needs_proof(landing, equation, impact)
    impulse = impact.impulse
    for k, choice in impact.choices.items():
        impulse[k, ~choice.unique] = np.nan
    state, approach, com = equation.state, None, None
    if own:
        strikes = equation.blocks[: len(landing.contacts)]
        approach = np.stack([contact_velocity(landing, state, block) for block in strikes], axis=1)
        com = com_velocity(landing.robot, state, landing.before) if landing.scene.v_in == "com" else None
    return Solved(jumps, state.rotation[:, carriers], impulse, condition, prove, approach, com)


def columns(landing: Landing, solved: Solved, strikes: Array, targets: Targets) -> tuple[dict[str, Array], np.ndarray]:
    """Every column for m postures and S strikes of each.

    Args:
        landing: the landing.
        solved: its postures.
        strikes: (m, S, 3) velocities of the base before the impact, world axes [m/s].
        targets: what the columns are about.

    Returns: columns (m, S) by heading, in order; and which contacts (m, S, c) do not approach the ground.
    """
    change = strikes - landing.before.velocity
    approach = strikes[:, :, None] if solved.approach is None else solved.approach[:, None] + change[:, :, None]
    speeds = _length(approach)
    parting = approach @ landing.up >= -1e-9 * speeds
    v_in = speeds.max(axis=-1)
    if landing.scene.v_in == "com":
        v_in = _length(strikes if solved.com is None else solved.com[:, None] + change)
    # Where the base only translates, the jump is the product of the map and the strike; else the landing's own jump and the change.
    product = functools.partial(_product, velocity=strikes if solved.approach is None else change, own=solved.approach is not None)
    found: dict[str, Array] = {}
    place = {body: k for k, body in enumerate(targets.carriers)}

    def at_point(body: int, r: Array) -> tuple[Array, Array, Array]:
        """Shock (m, S) of a point of a body, and its most severe impact direction (m, 1, 3), which depends on no strike."""
        maps = jump_at(solved.jumps[:, place[body]], solved.rotation[:, place[body]] @ r)
        directions, severe = most_severe_directions(maps[..., :3], landing.up)
        return _length(product(maps)) / v_in, severe[:, None], directions[:, None]

    with np.errstate(invalid="ignore", divide="ignore"):
        for spot in targets.spots:
            found |= _of_point(spot.label, *at_point(spot.frame.body, spot.r))
        for number, body in enumerate(targets.bodies):
            jumps, rotation = solved.jumps[:, place[body]], solved.rotation[:, place[body]]
            to_body = rotation[:, None]
            omega, v = ((product(part)[..., None, :] @ to_body)[..., 0, :] for part in (jumps[:, :3], jumps[:, 3:]))
            greatest = greatest_shock(omega, v, targets.pieces[number]) / v_in if targets.pieces else None
            normal = np.broadcast_to((landing.plane.normal @ rotation)[:, None], omega.shape)
            translates, still = translation(omega, v, normal, v_in, robot_length(landing), ROUNDED)
            centre = percussion(omega, v, normal, v_in, translates, still)
            copc, ropc = np.where(translates[..., None], np.nan, centre.copc), np.where(translates, np.inf, centre.ropc)
            shock, severe, directions = at_point(body, landing.robot.coms[body])
            found |= _of_body(landing.robot.bodies[body].name, shock, greatest, copc, ropc, severe, directions)
        found["friction needed [-]"] = _friction(landing, product(solved.impulse))
    found["condition [-]"] = solved.condition[:, None]
    return {heading: np.broadcast_to(x, v_in.shape) for heading, x in found.items()}, parting


def proven_columns(profile: ShockProfile, targets: Targets) -> dict[str, float]:
    """The same columns of one landing, proven."""
    found: dict[str, Any] = {}
    points = {point.frame: point for point in profile.points}
    for point in (points[spot.label] for spot in targets.spots):
        severe = point.directions
        found |= _of_point(point.frame, np.array(point.shock), severe.most_severe_shock, severe.most_severe)
    severe = profile.directions
    for i in targets.bodies:
        greatest = profile.shock_max[i] if targets.pieces else None
        own = profile.copc[i], profile.ropc[i], severe.most_severe_shock[i], severe.most_severe[i]
        found |= _of_body(profile.bodies[i], profile.shock_com[i], greatest, *own)
    friction = [np.nan if contact.friction_needed is None else contact.friction_needed for contact in profile.contacts]
    return {heading: float(x) for heading, x in found.items()} | {"friction needed [-]": float(np.max(friction))}


def _product(maps: Array, velocity: Array, own: bool) -> Array:
    """Maps (m, …, k) times velocities (m, S, 3), plus the landing's own motion if it counts: (m, S, …)."""
    extra = (None,) * (maps.ndim - 2)
    total = maps[:, None, ..., 0] * velocity[..., 0][(..., *extra)]
    for k in (1, 2):
        total += maps[:, None, ..., k] * velocity[..., k][(..., *extra)]
    return np.asarray(total + maps[:, None, ..., 3] if own else total)


def _friction(landing: Landing, impulse: Array) -> Array:
    """Largest friction (m, S) that a contact needs to stick [1]; NaN where one would be pulled, or is not determined."""
    worst = np.zeros(impulse.shape[:2])
    start = 0
    for contact in landing.contacts:
        n = len(contact.forces)
        force = impulse[..., start : start + n] @ contact.forces
        normal = force @ landing.up
        friction = _length(force - normal[..., None] * landing.up) / normal
        worst = np.maximum(worst, np.where(normal > 0.0, friction, np.nan))
        start += n + len(contact.moments)
    return worst


def _length(v: Array) -> Array:
    """Lengths (…) of vectors (…, 3)."""
    return np.asarray(np.sqrt(v[..., 0] * v[..., 0] + v[..., 1] * v[..., 1] + v[..., 2] * v[..., 2]))
