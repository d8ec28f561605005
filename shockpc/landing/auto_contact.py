"""Where a contact strikes, and whether it is a sole, where a scene leaves that open: resolved once, in the scene's posture.

A contact is at its frame's origin if an offset is given or the link has no geometry, and where the origin lies in the middle of a
foot or on the centre line of a beam; else at the lowest point of the link's geometry. It is flat where that geometry has a sole
that carries the flat landing: its centre of pressure lies in the sole. As a point in the middle of a sole, a humanoid's foot would
pivot, and the shock be several times too small. The centre of pressure of a round foot lies far beside it, and a wheel rolls.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from shockpc.core.impulse import solve_impact
from shockpc.core.memo import memoized
from shockpc.core.spatial import Array, cross
from shockpc.landing.constraints import ConstraintBlock, block_point, slices_of
from shockpc.landing.contact import contact_block
from shockpc.landing.directions import across
from shockpc.landing.landing import PosedLanding
from shockpc.landing.scene import Contact
from shockpc.robot.geometry import robot_size, shapes_of
from shockpc.robot.robot import Robot
from shockpc.robot.shapes import Shape
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


@memoized()
def most_inside(robot: Robot) -> float:
    """How far a contact point may lie above the lowest point of its link [m]."""
    return INSIDE + SHARE * robot_size(robot)


def resolve_contacts(landing: PosedLanding) -> PosedLanding:
    """The landing with all contacts at a definite point and of a definite kind; what a scene gives stays as it is.

    Contacts that have a sole are flat first. Those whose sole does not carry the landing are points, until all others' do.

    Args:
        landing: its rows take contacts that are not resolved as points at their frames.
    """
    given, blocks = landing.scene.contact, landing.contacts
    if not any("auto" in (contact.at, contact.kind) for contact in given):
        return landing
    found, soles, warnings = [], dict[int, Array](), []
    for k, (contact, block) in enumerate(zip(given, blocks, strict=True)):
        definite, sole, warning = _placed(landing, contact, block)
        found.append(definite)
        if sole is not None:
            soles[k] = sole
        if warning is not None:
            warnings.append(warning)
    landing = replace(landing, warnings=(*landing.warnings, *warnings))
    while True:
        contacts = tuple(replace(contact, kind="flat") if k in soles else contact for k, contact in enumerate(found))
        rows = tuple(_block(landing, *three) for three in zip(contacts, given, blocks, strict=True))
        landing = replace(landing, scene=replace(landing.scene, contact=contacts), contacts=rows)
        if not (tipping := _tipping(landing, soles) if soles else set()):
            return landing
        soles = {k: sole for k, sole in soles.items() if k not in tipping}


def _block(landing: PosedLanding, contact: Contact, given: Contact, block: ConstraintBlock) -> ConstraintBlock:
    """The rows of a contact. Args: given, block, the same before it was resolved."""
    return block if block.kind == "stop" or contact == given else contact_block(landing.robot, contact, block.normal)


def _placed(landing: PosedLanding, contact: Contact, block: ConstraintBlock) -> tuple[Contact, Array | None, Diagnostic | None]:
    """A contact at a definite point, its `_sole` if its kind is open, and a warning where its geometry could not be read."""
    if "auto" not in (contact.at, contact.kind):
        return contact, None, None
    open_at, open_kind = contact.at == "auto", contact.kind == "auto"
    definite = replace(contact, at="frame" if open_at else contact.at, kind="point" if open_kind else contact.kind)
    if block.kind == "stop" or any(contact.offset):
        return definite, None, None
    robot, state = landing.robot, landing.state
    rotation, position = state.rotation[0, block.body], state.position[0, block.body]
    shapes, unread = shapes_of(robot, contact.frame)
    up = block.normal @ rotation
    if shapes and open_at and (depth := _depth(block, shapes, up)) > INSIDE + SHARE * robot_size(robot, False):
        definite = replace(definite, at="frame" if depth <= most_inside(robot) else "lowest")
    sole = None
    if open_kind and (shapes or not unread):
        face = _sole(robot, contact.frame, (float(up[0]), float(up[1]), float(up[2])), landing.scene.ground_tolerance)
        sole = None if face is None else position + face @ rotation.T
    if not unread:
        return definite, sole, None
    names = listed(dict.fromkeys(lost.mesh or lost.reason for lost in unread), 3)
    text = (
        f'the geometry of contact "{contact.frame}" could not be read ({names}), so '
        + ("only its other shapes decide where it strikes" if shapes else "it strikes at the origin of its frame, as a point")
        + "; say where the meshes are (packages), or give the point by an offset"
    )
    return definite, sole, Diagnostic("geometry", contact.frame, None, text)


def _depth(block: ConstraintBlock, shapes: Sequence[Shape], up: Array) -> float:
    """Height of a frame's origin above the lowest point of some shapes of its body [m].

    Args:
        block: at the frame.
        shapes: of its link.
        up: (3,) the ground's normal, in the axes of the body.
    """
    return float(up @ np.reshape(block.point, 3)) - _low(shapes, up)


def _low(shapes: Sequence[Shape], up: Array) -> float:
    """Height of the lowest point of some shapes over the origin of their body [m]. Args: up, (3,) in the body's axes."""
    return -max(float(shape.reach(-up[None])[0]) for shape in shapes)


@memoized(most=100)
def _sole(robot: Robot, name: str, normal: tuple[float, float, float], tolerance: float) -> Array | None:
    """Points (n, 3) of the face by which a frame's geometry lies on the ground, in the frame of its body [m].

    None if most of what is near the ground is round. A frame without geometry may lie in the middle of a sole of its body: a toe
    and the end of a beam do not.

    Args:
        robot: the robot.
        name: of the frame.
        normal: unit normal of the ground, in the axes of the body.
        tolerance: of the ground [m].
    """
    frame, up = robot.frame(name), np.array(normal)
    shapes, _ = shapes_of(robot, name)
    of_body = not shapes
    if of_body:
        # A frame of the base marks a point.
        links = robot.bodies[frame.body].links if robot.parents[frame.body] >= 0 else ()
        shapes = tuple(shape for link in links for shape in shapes_of(robot, link)[0])
    if not shapes or (of_body and abs(up @ frame.offset - _low(shapes, up)) > most_inside(robot)):
        return None
    low, tolerance, axes = _low(shapes, up), tolerance + LEVEL, np.array(across(up))
    semi_axes = np.linalg.norm(shapes[0].rounding, axis=0)
    # The usual foot is a ball; to represent it by points would take a fiftieth of a short run.
    if len(shapes) == 1 and len(shapes[0].points) == 1 and semi_axes.min() > max(tolerance, (1.0 - LEVEL) * semi_axes.max()):
        return None
    points = np.concatenate([_below(shape, up, low + tolerance) for shape in shapes])
    flat = points @ axes.T
    outer = _outer(flat)
    points = points[_above_face(flat - outer.mean(axis=0), points @ up - low) <= PLANE * tolerance]
    if not len(points) or not _area(_outer(points @ axes.T)) > FLAT * _area(outer):
        return None
    if of_body:
        aside = (points - frame.offset) @ axes.T @ _DIRECTIONS
        width = np.ptp(aside, axis=0)
        if not (width.min() > WIDE * most_inside(robot) and np.all(np.abs(aside.min(axis=0) + aside.max(axis=0)) <= width / 2.0)):
            return None
    return points


def _tipping(landing: PosedLanding, soles: Mapping[int, Array]) -> set[int]:
    """Which soles do not carry a landing in which they are flat: the centre of pressure is beside their face.

    Args:
        landing: which has them as flat contacts.
        soles: their faces (n, 3), from the base, by the number of the contact [m].
    """
    state = landing.state
    equation = landing.equation(state)
    most = landing.most_independent(state, equation.blocks)
    solution = solve_impact(equation.inertia, equation.J_c, equation.b, equation.terms, equation.tolerance, most)
    tipping, parts = set(), slices_of(equation.blocks)
    for k, face in soles.items():
        block, impulse = equation.blocks[k], solution.impulse[0, parts[k], 3]
        n, up = len(block.forces), block.normal
        force = impulse[:n] @ block.forces
        # Moment about each point of the face; along an edge that tips it is of one sign.
        moment = impulse[n:] @ block.moments + cross(block_point(state, block) - face, force)
        aside = cross(up, moment) @ np.transpose(across(up)) @ _DIRECTIONS
        if not (force @ up > 0.0 and np.all(aside.min(axis=0) <= 0.0)):
            tipping.add(k)
    return tipping


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


def _outer(flat: Array) -> Array:
    """Of points (n, 2) those (64, 2) that are the farthest in each of the directions; their mean is a middle of the hull."""
    (x, y), (dx, dy) = flat.T, _DIRECTIONS[:, : _DIRECTIONS.shape[1] // 2, None]
    along = dx * x + dy * y
    return np.asarray(flat[np.concatenate([along.argmax(axis=1), along.argmin(axis=1)])])


def _area(outer: Array) -> float:
    """Area of a polygon by its corners (n, 2) [m²]."""
    x, y = outer.T
    return float(0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1)))


def _below(shape: Shape, up: Array, height: float) -> Array:
    """Points (n, 3) whose hull is the part of a shape below a height [m]; round shapes are represented by points on them.

    All is in the frame of the body.
    """
    if shape.mesh is not None:
        points, edges = shape.mesh.vertices, shape.mesh.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    else:
        points = shape.points
        if shape.rounding.any():
            points = (points[:, None] + _ball(up @ shape.rounding) @ shape.rounding.T).reshape(-1, 3)
        edges = np.stack(np.triu_indices(len(points), 1), axis=1)
    over = points @ up - height
    one, other = edges[over[edges[:, 0]] * over[edges[:, 1]] < 0.0].T
    share = (over[one] / (over[one] - over[other]))[:, None]
    return np.concatenate([points[over <= 0.0], points[one] + share * (points[other] - points[one])])


def _ball(axis: Array) -> Array:
    """Points (n, 3) on the unit ball, on parallels about an axis, which may be zero."""
    length = float(np.linalg.norm(axis))
    axis = axis / length if length > 0.0 else np.array([0.0, 0.0, 1.0])
    latitude = math.pi * np.arange(1, RINGS - 1) / (RINGS - 1)
    angle = 2.0 * math.pi * np.arange(AROUND) / AROUND
    first, second = across(axis)
    around = np.cos(angle)[:, None] * first + np.sin(angle)[:, None] * second
    parallels = np.cos(latitude)[:, None, None] * axis + np.sin(latitude)[:, None, None] * around
    return np.concatenate([[axis, -axis], parallels.reshape(-1, 3)])
