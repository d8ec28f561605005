"""Where a contact strikes, and whether it is a sole, where a scene leaves that open: resolved once, in the scene's posture.

A contact is at its frame's origin if an offset is given or the link has no geometry, and where the origin lies in the middle of a
foot or on the centre line of a beam; else at the lowest point of the link's geometry. It is flat where that geometry has a sole
that carries the flat landing: its centre of pressure lies in the sole. As a point in the middle of a sole, a humanoid's foot would
pivot, and the shock be several times too small. The centre of pressure of a round foot lies far beside it, and a wheel rolls.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from shockpc.core.impulse import solve_impact
from shockpc.core.spatial import Array, cross
from shockpc.landing.contact import across, contact_block, locate_lowest_point
from shockpc.landing.landing import PosedLanding
from shockpc.landing.rows import Block, block_point
from shockpc.landing.scene import Contact
from shockpc.robot.geometry import Shape, robot_size, shapes_of
from shockpc.robot.robot import Robot
from shockpc.text.diagnostic import Diagnostic
from shockpc.text.printed import listed

INSIDE, SHARE = 0.02, 0.01
"""A contact point may lie in the middle of a foot or on the centre line of a beam: 2 cm [m] and a hundredth of the robot's size
above the lowest point of its link."""

RINGS, AROUND = 17, 16
"""Parallels of a round shape, and points on each, by which its part near the ground is represented."""

_ANGLES = 2.0 * math.pi * np.arange(64) / 64
_DIRECTIONS = np.stack([np.cos(_ANGLES), np.sin(_ANGLES)])
"""Directions (2, 64) in which the extent of an area is measured."""

PLANE, FLAT = 0.1, 0.5
"""Height above the face under the centre of pressure up to which points belong to that face, as a share of the ground's tolerance;
share of the area near the ground that the face of a sole has at least: it is 0.1 for a ball, 0.3 for a wheel."""

WIDE = 1.5
"""Width of the sole in which a frame without geometry lies, in units of `most_inside`: the end of a beam is narrower [1]."""

LEVEL = 1e-9
"""Height up to which points are equally high, whatever the ground's tolerance is [m]."""

FAR, HIGH = 10.0, 1e3
"""Distance and height of the auxiliary points with which the search for a face begins [m]."""


def most_inside(robot: Robot) -> float:
    """How far a contact point may lie above the lowest point of its link [m]."""
    return INSIDE + SHARE * robot_size(robot)


def resolve_contacts(landing: PosedLanding) -> PosedLanding:
    """The landing with all contacts at a definite point and of a definite kind; what a scene gives stays as it is.

    Args:
        landing: its rows take contacts that are not resolved as points at their frames.
    """
    contacts, warnings = zip(*(_resolved(landing, k) for k in range(len(landing.contacts))), strict=True)
    blocks = (
        block if contact == given else _block(landing, contact, block)
        for contact, given, block in zip(contacts, landing.scene.contact, landing.contacts, strict=True)
    )
    return replace(
        landing,
        scene=replace(landing.scene, contact=contacts),
        contacts=tuple(blocks),
        warnings=(*landing.warnings, *(one for one in warnings if one is not None)),
    )


def _block(landing: PosedLanding, contact: Contact, block: Block) -> Block:
    """The rows of a contact. Args: block, the same as a point at the frame."""
    return block if block.kind == "stop" else contact_block(landing.robot, contact, block.normal)


def _resolved(landing: PosedLanding, number: int) -> tuple[Contact, Diagnostic | None]:
    """A contact at a definite point and of a definite kind, and a warning where its geometry could not be read."""
    contact, block = landing.scene.contact[number], landing.contacts[number]
    if "auto" not in (contact.at, contact.kind):
        return contact, None
    open_at, open_kind = contact.at == "auto", contact.kind == "auto"
    definite = replace(contact, at="frame" if open_at else contact.at, kind="point" if open_kind else contact.kind)
    if block.kind == "stop" or any(contact.offset):
        return definite, None
    robot = landing.robot
    shapes, unread = shapes_of(robot, contact.frame)
    if shapes and open_at and (depth := _depth(landing, block, shapes)) > INSIDE + SHARE * robot_size(robot, False):
        definite = replace(definite, at="frame" if depth <= most_inside(robot) else "lowest")
    if open_kind:
        sole = shapes
        if not shapes and not unread and robot.parents[block.body] >= 0:
            # A frame without shapes may lie in a sole of its body; one of the base marks a point.
            body = tuple(shape for link in robot.bodies[block.body].links for shape in shapes_of(robot, link)[0])
            sole = body if body and abs(_depth(landing, block, body)) <= most_inside(robot) else ()
        if sole and _lands_flat(landing, _block(landing, replace(definite, kind="flat"), block), sole, not shapes):
            definite = replace(definite, kind="flat")
    if not unread:
        return definite, None
    names = listed(dict.fromkeys(lost.mesh or lost.reason for lost in unread), 3)
    text = (
        f'the geometry of contact "{contact.frame}" could not be read ({names}), so '
        + ("its other shapes alone decide where it strikes" if shapes else "it strikes at the origin of its frame, as a point")
        + "; say where the meshes are (packages), or give the point by an offset"
    )
    return definite, Diagnostic("geometry", contact.frame, None, text)


def _depth(landing: PosedLanding, block: Block, shapes: Sequence[Shape]) -> float:
    """Height of a frame's origin above the lowest point of its link's shapes [m]. Args: block, at the frame."""
    up = block.normal @ landing.state.rotation[0, block.body]
    return float(up @ np.reshape(block.point, 3)) + max(float(shape.reach(-up[None])[0]) for shape in shapes)


def _lands_flat(landing: PosedLanding, sole: Block, shapes: Sequence[Shape], in_the_middle: bool) -> bool:
    """Whether the centre of pressure of the flat landing of one contact lies in the area by which it touches the ground.

    Args:
        landing: whose other contacts are left out.
        sole: the rows of the contact, flat.
        shapes: of its link.
        in_the_middle: whether its point has to lie in the middle of a wide area: a toe and the end of a beam do not.
    """
    state, up = landing.state, sole.normal
    rotation, position = state.rotation[0, sole.body], state.position[0, sole.body]
    down = -up @ rotation
    low = float(up @ position) - max(float(shape.reach(down[None])[0]) for shape in shapes)
    centre = _centre_of_pressure(landing, sole, low)
    # Round feet end here: their centre of pressure is beside all that they have.
    axes = np.array(across(up))
    for direction in (*axes, *-axes):
        reach = max(float(shape.reach((direction @ rotation)[None])[0]) for shape in shapes)
        if not direction @ (centre - position) < reach:
            return False
    tolerance = landing.scene.ground_tolerance + LEVEL
    points = np.concatenate([_below(shape, rotation, position, up, low + tolerance) for shape in shapes])
    flat, height = (points - centre) @ axes.T, points @ up
    face = flat[_above_face(flat, height - low) <= PLANE * tolerance]
    if not len(face) or not _area(face) > FLAT * _area(flat):
        return False
    ends = np.stack([(face @ _DIRECTIONS).min(axis=0), (face @ _DIRECTIONS).max(axis=0)])
    beside = np.abs((block_point(state, sole)[0] - centre) @ axes.T @ _DIRECTIONS - ends.mean(axis=0))
    width = np.ptp(ends, axis=0)
    return not in_the_middle or bool(width.min() > WIDE * most_inside(landing.robot) and np.all(beside <= width / 4.0))


def _above_face(flat: Array, height: Array) -> Array:
    """Heights (n,) of points above the face of their hull that lies below or above the origin; infinite if there is none.

    The face is found by the simplex method: the convex combination of points that is at the origin and lowest. It begins with
    three auxiliary points.

    Args:
        flat: (n, 2) their horizontal positions [m].
        height: (n,) [m].
    """
    angle = 2.0 * math.pi * np.arange(3) / 3
    rows = np.concatenate([FAR * np.stack([np.cos(angle), np.sin(angle)], axis=1), flat])
    rows, cost = np.column_stack([np.ones(len(rows)), rows]), np.concatenate([np.full(3, HIGH), height])
    chosen = np.arange(3)
    for _ in range(len(rows)):
        above = cost - rows @ np.linalg.solve(rows[chosen], cost[chosen])
        entering = int(above.argmin())
        if above[entering] > -LEVEL:
            break
        shares, change = np.linalg.solve(rows[chosen].T, np.stack([[1.0, 0.0, 0.0], rows[entering]], axis=1)).T
        ratio = np.where(change > LEVEL, shares / np.where(change > LEVEL, change, 1.0), np.inf)
        chosen[int(ratio.argmin())] = entering
    return above[3:] if chosen.min() > 2 else np.full(len(flat), np.inf)


def _area(flat: Array) -> float:
    """Area of the hull of points (n, 2), from those that are farthest in some directions [m²]."""
    x, y = flat[(flat @ _DIRECTIONS).argmax(axis=0)].T
    return float(0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1)))


def _centre_of_pressure(landing: PosedLanding, sole: Block, low: float) -> Array:
    """Where (3,) the impulse of a flat contact alone acts on the ground, from the base [m]; NaN where there is none.

    Args:
        landing: whose other contacts are left out.
        sole: the rows of the contact.
        low: height of the ground from the base along its normal [m].
    """
    state, up = landing.state, sole.normal
    alone = replace(landing, contacts=(sole,))
    equation = alone.equation(state)
    most = alone.most_independent(state, equation.blocks)
    solution = solve_impact(equation.inertia, equation.J_c, equation.b, equation.terms, equation.tolerance, most)
    impulse, n = solution.impulse[0, : sole.size, 3], len(sole.forces)
    point = block_point(state, locate_lowest_point(sole, state.rotation[:, sole.body]))[0]
    on_ground = point - (up @ point - low) * up
    force = impulse[:n] @ sole.forces
    moment = impulse[n:] @ sole.moments + cross(point - on_ground, force)
    with np.errstate(all="ignore"):
        return np.asarray(on_ground + cross(up, moment) / (force @ up))


def _below(shape: Shape, rotation: Array, position: Array, up: Array, least: float) -> Array:
    """Points (n, 3) whose hull is the part of a shape below a height [m]; round shapes are represented by points on them."""
    if shape.mesh is not None:
        points, edges = shape.mesh.vertices, shape.mesh.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    else:
        points = shape.points
        if shape.rounding.any():
            points = (points[:, None] + _ball(up @ rotation @ shape.rounding) @ shape.rounding.T).reshape(-1, 3)
        edges = np.stack(np.triu_indices(len(points), 1), axis=1)
    world = position + points @ rotation.T
    over = world @ up - least
    one, other = edges[over[edges[:, 0]] * over[edges[:, 1]] < 0.0].T
    share = (over[one] / (over[one] - over[other]))[:, None]
    return np.concatenate([world[over <= 0.0], world[one] + share * (world[other] - world[one])])


def _ball(axis: Array) -> Array:
    """Points (n, 3) on the unit ball, on parallels about an axis, which may be zero."""
    length = float(np.linalg.norm(axis))
    axis = axis / length if length > 0.0 else np.array([0.0, 0.0, 1.0])
    latitude, angle = np.meshgrid(math.pi * np.arange(RINGS) / (RINGS - 1), 2.0 * math.pi * np.arange(AROUND) / AROUND)
    first, second = across(axis)
    along = np.stack([np.cos(latitude), np.sin(latitude) * np.cos(angle), np.sin(latitude) * np.sin(angle)], axis=-1)
    return np.unique((along.reshape(-1, 3) @ np.array([axis, first, second])).round(15), axis=0)
