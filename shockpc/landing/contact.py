"""Contact points: names, offsets and directions, described as rows of J_c."""

import contextlib
import itertools
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from shockpc.core.spatial import Array, cross, cross_matrix
from shockpc.landing.scenes.directions import across, unit_directions
from shockpc.landing.scenes.scene import ORIGIN, Contact, Scene
from shockpc.method.constraints import NO_AXES, Constraint
from shockpc.robot.feet_and_sensors import each_foot
from shockpc.robot.robot import STOP, Robot
from shockpc.robot.shapes.convex import Shape
from shockpc.robot.shapes.geometry import body_outline
from shockpc.robot.shapes.lowest import equally_low, lowest_point
from shockpc.robot.shapes.striking import own_shapes
from shockpc.text.errors import SceneError, ShockError
from shockpc.text.printed import listed


def match_contacts(robot: Robot, pattern: str) -> tuple[str, ...]:
    """The frames that a name or a glob means, as in `Robot.match_frames`.

    After "stop:" they are the end stops of joints.

    Raises:
        UnknownName: nothing fits; the text names the robot's feet.
    """
    if pattern.startswith(STOP) and pattern not in robot.frames:
        return tuple(STOP + name for name in robot.match_joints(pattern.removeprefix(STOP)))
    return robot.match_frames(pattern, "contact", _feet(robot))


def landing_frames(robot: Robot, text: str) -> list[tuple[str, ...]]:
    """The landings that a text means.

    There is one for each frame that a name or glob matches, or for A+B one on all of both.

    Raises:
        UnknownName: nothing fits a name.
        SceneError: a name is empty, or stands there twice.
    """
    names = [text]
    if text not in robot.frames:
        names = [part.strip() for part in text.split("+")]
    if not all(names):
        raise SceneError(
            f'contact "{text}" holds an empty name; valid are a name, A+B, or a glob such as '
            f'"*_foot"'
        )
    twice = [name for k, name in enumerate(names) if name in names[:k]]
    if twice:
        raise SceneError(
            f'contact "{text}" names "{twice[0]}" twice; remove one of them', constraints=twice[:1]
        )
    parts = [match_contacts(robot, name) for name in names]
    if len(parts) == 1:
        return [(frame,) for frame in parts[0]]
    return [tuple(dict.fromkeys(itertools.chain(*parts)))]


def contact_name(scene: Scene) -> str:
    """The name of what strikes: frames with + between them."""
    return "+".join(contact.frame for contact in scene.contact)


def contacts_like(contacts: Sequence[Contact], names: Iterable[str]) -> tuple[Contact, ...]:
    """Contacts at some frames.

    Each is as the contact there, or else with all that the first contact is given but its velocity.
    """
    alike = {contact.frame: contact for contact in reversed(contacts)}
    first = replace(contacts[0], velocity=None) if contacts else Contact(frame="")
    return tuple(alike.get(name, replace(first, frame=name)) for name in names)


def contact_constraint(
    robot: Robot, contact: Contact, up: Array, kind: Literal["contact", "stance"] = "contact"
) -> Constraint:
    """The rows of a contact, or of a foot that is down already.

    Such a foot stays where it is, whatever strikes elsewhere.

    Args:
        robot: the robot.
        contact: as the scene states it; one whose point and kind are not resolved yet is a point at
            the frame.
        up: (3,) unit normal of the ground, world axes.
        kind: what it is.

    Raises:
        UnknownName: the robot has no such frame.
        SceneError: the frame does not move, the link has no collision geometry to find a lowest
            point on, or a direction has no length.
    """
    if contact.frame not in robot.frames:
        raise robot.unknown("contact", contact.frame, robot.frames, _feet(robot))
    frame = robot.frames[contact.frame]
    name = f'{kind} "{contact.frame}"'
    if frame.body < 0:
        raise SceneError(
            f"{name} is fixed to the world, so no impulse moves it; name a frame on a moving link",
            constraints=[contact.frame],
        )
    up = _normal(contact, up, name)
    directions = _directions(contact, up, name)
    point = frame.rotation @ np.asarray(contact.offset or ORIGIN, dtype=float)
    lowest = _shapes(robot, contact.frame) if contact.at == "lowest" else ()
    if not lowest:
        point = frame.offset + point
    velocity = None if contact.velocity is None else np.array(contact.velocity, dtype=float)
    return Constraint(
        kind,
        contact.frame,
        frame.body,
        point,
        directions,
        _moments(contact, up, name),
        restitution=contact.restitution,
        rebound=_rebound(directions, up) if contact.restitution_along == "normal" else None,
        normal=up,
        velocity=velocity,
        lowest=lowest,
    )


def _normal(contact: Contact, up: Array, name: str) -> Array:
    """The normal (3,) of the ground at a contact: that of the contact, else up.

    Raises:
        SceneError: that of the contact has no length.
    """
    if contact.normal is None:
        return up
    if not any(contact.normal):
        raise SceneError(
            f"the normal of {name} has no length; give the direction away from the ground, "
            f"such as 0,0,1",
            constraints=[contact.frame],
        )
    return np.asarray(unit_directions(f"the normal of {name}", (contact.normal,))[0])


def _directions(contact: Contact, up: Array, name: str) -> Array:
    """The unit vectors (n, 3) along which a contact is stopped.

    Raises:
        SceneError: one has no length, or all are along the ground.
    """
    directions = unit_directions(name, contact.directions)
    if not np.any(np.abs(directions @ up) > 1e-9):
        raise SceneError(
            f"{name} keeps only directions along the ground, so nothing stops its fall; "
            f"add the ground's normal ({', '.join(f'{u:g}' for u in up)}) to its directions",
            constraints=[contact.frame],
        )
    return directions


def _rebound(directions: Array, up: Array) -> Array:
    """The direction (3,) of a rebound along the normal: its part in the span of the directions."""
    _, s, basis = np.linalg.svd(directions, full_matrices=False)
    rounding = s[0] * max(directions.shape) * np.finfo(float).eps
    rank = int(np.sum(s > rounding))
    if rank == 3:
        return up
    along = basis[:rank].T @ (basis[:rank] @ up)
    return np.asarray(along / np.linalg.norm(along))


def _moments(contact: Contact, up: Array, name: str) -> Array:
    """The axes (m, 3) about which a contact is held.

    A flat contact tilts about none, an edge about its own.

    What sticks does not twist about the normal, but for a point, which is free to turn.

    Args:
        contact: as the scene states it.
        up: (3,) unit normal of the ground, world axes.
        name: of the contact, for messages.

    Raises:
        SceneError: an edge has no direction, or one along the normal.
    """
    if contact.edge is not None and contact.kind != "edge":
        raise SceneError(
            f'{name} is given the direction of an edge, which a contact of kind "{contact.kind}" '
            f"has not; leave it out, or give "
            'kind = "edge"',
            constraints=[contact.frame],
        )
    if contact.kind in ("auto", "point"):
        return NO_AXES
    twist = up[None] if contact.sticks else NO_AXES
    if contact.kind == "flat":
        return np.concatenate([np.array(across(up)), twist])
    if contact.kind == "edge":
        # The moment about the edge is free. That about the axis across it, which would lift one
        # end, is held.
        across_edge = cross(up, np.asarray(contact.edge or (0.0, 0.0, 0.0), dtype=float))
        length = float(np.linalg.norm(across_edge))
        if not length > 0.0:
            raise SceneError(
                f"{name} is an edge without a direction along the ground; give that in a scene "
                f"file (edge = [x, y, z]), or another "
                "kind of contact",
                constraints=[contact.frame],
            )
        return np.concatenate([across_edge[None] / length, twist])
    return twist


def locate_lowest_point(contact: Constraint, rotation: Array) -> Constraint:
    """A contact with its point in each posture, if that is the lowest one.

    Args:
        contact: as described in any posture.
        rotation: (N, 3, 3) of its body, body to world.
    """
    if not contact.lowest:
        return contact
    points = [lowest_point(contact.lowest, R.T @ contact.normal) for R in rotation]
    return contact._replace(point=contact.point + np.stack(points))


def _feet(robot: Robot) -> str:
    """The robot's feet, for messages."""
    return f"the feet of this robot: {listed(each_foot(robot), 12)}"


def _shapes(robot: Robot, name: str) -> tuple[Shape, ...]:
    """The shapes on which the lowest point of a frame is sought, as `own_shapes`.

    Raises:
        SceneError: there is none.
    """
    (shapes, _), frame = own_shapes(robot, name), robot.frame(name)
    if not shapes:
        links = dict.fromkeys(shape.link for shape in body_outline(robot).shapes[frame.body])
        remedy = f"; of its body, {listed(links, 4)} has some" if links else ""
        raise SceneError(
            f'{frame.kind} "{name}" has no collision geometry that could be read, so it has no '
            f"lowest point{remedy}; "
            "give the contact point by its offset, or name a link that has collision geometry",
            constraints=[name],
        )
    return shapes


def lowest_point_turned(contact: Constraint, rotation: Array) -> Array:
    """Displacement (N, 3, 3) of a lowest point over its body by rotation at 1 rad/s: it rolls [m].

    The body rotates about world x, y and z.

    It stays at a corner; over a rounding E, an ellipsoid with the semi-axes in its columns, it is E
    Eᵀ u / |Eᵀ u| along u, down. Where several points are equally low it jumps: NaN.

    Args:
        contact: at the lowest point.
        rotation: (N, 3, 3) of its body, body to world.
    """
    out = np.zeros_like(rotation)
    for k, R in enumerate(rotation):
        down = -R.T @ contact.normal
        lowest = equally_low([shape.farthest(down) for shape in contact.lowest], -down)
        if sum(int(is_lowest.sum()) for is_lowest in lowest) > 1:
            out[k] = np.nan
            continue
        is_lowest = [bool(points.any()) for points in lowest]
        E = contact.lowest[is_lowest.index(True)].rounding
        along = down @ E
        length = float(np.linalg.norm(along))
        if length > 1e-6 * float(np.abs(E).max()):
            unit = np.eye(3) - np.outer(along, along) / length**2
            hessian = E @ unit @ E.T / length
            # As the body turns by ω, the direction in its axes turns by −ω.
            out[k] = R @ hessian @ cross_matrix(down) @ R.T
        elif E.any():
            out[k] = np.nan
    return out


def first_contact(robot: Robot, texts: Iterable[str]) -> str:
    """The first text that means one landing of the robot.

    It is the first that is not empty if none does.
    """
    distinct = list(dict.fromkeys(filter(str.strip, texts)))
    for text in distinct:
        with contextlib.suppress(ShockError):
            if len(landing_frames(robot, text)) == 1:
                return text
    return next(iter(distinct), "")


def check_holds_normal(contact: Contact, constraint: Constraint, option: str) -> None:
    """Refuse a contact whose directions do not span the normal of the ground.

    An option needs them to.
    """
    rank = np.linalg.matrix_rank(constraint.forces)
    if np.linalg.matrix_rank(np.vstack([constraint.forces, constraint.normal]), tol=1e-9) > rank:
        raise SceneError(
            f'contact "{contact.frame}" has {option}, so the directions in which it is held have '
            "to span the ground's normal; give directions along the normal and along the ground, "
            "such as x and z",
            constraints=[contact.frame],
        )
