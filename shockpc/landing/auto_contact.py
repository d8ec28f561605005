"""Where a contact strikes, and what of its sole carries, where a scene leaves that open.

Both are resolved once, in the scene's posture. A contact is at its frame's origin if an offset is
given or the link has no geometry, and where the origin lies in the middle of a foot or on the
centre line of a beam; else at the lowest point of its geometry. If that has a sole, the contact is
what carries of it: all (flat), an edge or a corner. A foot that the others lift is left out. As a
point in the middle of a sole, a humanoid's foot would pivot, and the shock be several times too
small.
"""

from dataclasses import replace

import numpy as np

from shockpc.core.spatial import Array
from shockpc.landing.constraints import ConstraintBlock
from shockpc.landing.contact import contact_block
from shockpc.landing.faces import carrying_faces, ends_of, is_whole
from shockpc.landing.landing import PosedLanding
from shockpc.landing.scene import Contact
from shockpc.landing.soles import (
    INSIDE,
    SHARE,
    distance_aside,
    height_of_lowest,
    lowest_points,
    most_inside,
    sole_corners,
)
from shockpc.robot.geometry import robot_size
from shockpc.robot.robot import Robot
from shockpc.robot.striking import Striking, striking
from shockpc.text.diagnostic import Diagnostic
from shockpc.text.printed import listed

MIDDLE = 1e-6
"""Difference in height of points in whose middle a contact is, as a share of what they span."""


def resolve_contacts(landing: PosedLanding) -> PosedLanding:
    """The landing with its contacts at definite points and of definite kinds; what is given stays.

    Args:
        landing: its rows take contacts that are not resolved as points at their frames.

    Raises:
        SolveError: what of the soles carries is not found.
    """
    asked = landing.scene.contact
    if not any("auto" in (contact.at, contact.kind) for contact in asked):
        return landing
    landing = replace(landing, asked=asked, asked_rows=landing.contacts)
    warnings, definite, soles = list(landing.warnings), list[Contact](), dict[int, Array]()
    for number, (contact, block) in enumerate(zip(asked, landing.contacts, strict=True)):
        if block.kind == "stop":
            definite.append(_as_point(contact))
            continue
        placed = _placed(landing, contact, block)
        if (sole := _sole(landing, contact, block)) is not None:
            soles[number] = sole
            placed = replace(placed, kind="flat")
        definite.append(placed)
        warnings += _unread_geometry(landing.robot, contact)
    landing = _with_contacts(replace(landing, warnings=tuple(warnings)), dict(enumerate(definite)))
    return _with_faces(landing, soles) if soles else landing


def with_own_faces(landing: PosedLanding) -> PosedLanding:
    """The landing with its own faces: what of its soles carries with its joint model.

    Whoever changes the joint model of a landing calls this: for locked joints, for rotors at one
    end of their range. A landing without soles is returned as it is.

    Raises:
        SolveError: what of the soles carries is not found.
    """
    open_contacts = zip(landing.asked, landing.asked_rows, strict=True)
    if all(_sole(landing, contact, block) is None for contact, block in open_contacts):
        return landing
    asked = replace(landing.scene, contact=landing.asked)
    return resolve_contacts(replace(landing, scene=asked, contacts=landing.asked_rows, lifted=()))


def _as_point(contact: Contact) -> Contact:
    """A contact that is open as a point at its frame."""
    at = "frame" if contact.at == "auto" else contact.at
    return replace(contact, at=at, kind="point" if contact.kind == "auto" else contact.kind)


def _with_contacts(landing: PosedLanding, contacts: dict[int, Contact]) -> PosedLanding:
    """The landing with some of its contacts, by their number among those that it was asked for."""
    rows = []
    for number, contact in contacts.items():
        block = landing.asked_rows[number]
        unchanged = block.kind == "stop" or contact == landing.asked[number]
        rows.append(block if unchanged else contact_block(landing.robot, contact, block.normal))
    scene = replace(landing.scene, contact=tuple(contacts.values()))
    return replace(landing, scene=scene, contacts=tuple(rows))


def _placed(landing: PosedLanding, contact: Contact, block: ConstraintBlock) -> Contact:
    """A contact at a definite point, as a point if its kind is open."""
    placed = _as_point(contact)
    if contact.at != "auto" or contact.offset is not None:
        return placed
    robot, strikes = landing.robot, striking(landing.robot, contact.frame)
    is_place = strikes.marks or not strikes.shapes
    up = block.normal @ landing.state.rotation[0, block.body]
    origin, tolerance = np.reshape(block.point, 3), landing.scene.ground_tolerance
    if is_place or _is_near_lowest(robot, strikes, origin, up, tolerance):
        return placed
    if strikes.of_frame:
        return replace(placed, at="lowest")
    frame = robot.frame(contact.frame)
    low = lowest_points(strikes.shapes, up, 0.0)
    span = float(np.ptp(low, axis=0).max())
    middle = lowest_points(strikes.shapes, up, MIDDLE * max(span, MIDDLE)).mean(axis=0)
    offset = frame.rotation.T @ (middle - frame.offset)
    return replace(placed, offset=(float(offset[0]), float(offset[1]), float(offset[2])))


def _is_near_lowest(
    robot: Robot,
    strikes: Striking,
    point: Array,
    up: Array,
    tolerance: float,
) -> bool:
    """Whether a point (3,) of a body is near the lowest points of some shapes, in height and aside."""
    height = float(up @ point) - height_of_lowest(strikes.shapes, up)
    aside = distance_aside(point, lowest_points(strikes.shapes, up, tolerance), up)
    distance = max(height, aside)
    # Without its meshes, which need not be read then, the robot measures less.
    return distance <= INSIDE + SHARE * robot_size(robot, False) or distance <= most_inside(robot)


def _sole(landing: PosedLanding, contact: Contact, block: ConstraintBlock) -> Array | None:
    """The corners (n, 3) of a contact's sole, from the base [m]; None of a point or a given kind."""
    if contact.kind != "auto" or contact.offset is not None or block.kind == "stop":
        return None
    rotation, position = (
        landing.state.rotation[0, block.body],
        landing.state.position[0, block.body],
    )
    x, y, z = (block.normal @ rotation).tolist()
    corners = sole_corners(landing.robot, contact.frame, (x, y, z), landing.scene.ground_tolerance)
    return None if corners is None else position + corners @ rotation.T


def _unread_geometry(robot: Robot, contact: Contact) -> list[Diagnostic]:
    """A warning where geometry of an open contact could not be read."""
    if "auto" not in (contact.at, contact.kind) or contact.offset is not None:
        return []
    strikes = striking(robot, contact.frame)
    if not strikes.unread:
        return []
    names = listed(dict.fromkeys(lost.mesh or lost.reason for lost in strikes.unread), 3)
    consequence = "it strikes at the origin of its frame, as a point"
    if strikes.shapes and not strikes.marks:
        consequence = "only its other shapes decide where it strikes"
    text = (
        f'the geometry of contact "{contact.frame}" could not be read ({names}), so {consequence}; say where the meshes are '
        "(packages), or give the point by an offset"
    )
    return [Diagnostic("geometry", contact.frame, None, text)]


def _with_faces(landing: PosedLanding, soles: dict[int, Array]) -> PosedLanding:
    """The landing of flat soles with what carries of them.

    Args:
        landing: with its soles as flat contacts.
        soles: their corners (n, 3), from the base [m], by the number of the contact.
    """
    faces = carrying_faces(landing, soles)
    contacts, lifted, warnings = (
        dict(enumerate(landing.scene.contact)),
        list[int](),
        list(landing.warnings),
    )
    for number, face in faces.items():
        contact, block = contacts[number], landing.contacts[number]
        if is_whole(face, soles[number], block.normal):
            continue
        if len(face):
            # A point that is given stays where it is.
            is_given = landing.asked[number].at == "frame"
            on_face = _on_face(landing, contact, block, face)
            contacts[number] = replace(contact, kind="point") if is_given else on_face
            continue
        del contacts[number]
        lifted.append(block.body)
        text = f"{contact.frame} is lifted by the impact on the other feet, so it takes no impulse and is left out"
        warnings.append(Diagnostic("contact", contact.frame, None, text))
    carried = _with_contacts(landing, contacts)
    return replace(carried, lifted=tuple(lifted), warnings=tuple(warnings))


def _on_face(
    landing: PosedLanding,
    contact: Contact,
    block: ConstraintBlock,
    face: Array,
) -> Contact:
    """A contact at the edge or corner (k, 3) of its sole that carries, from the base [m]."""
    frame, rotation = landing.robot.frame(contact.frame), landing.state.rotation[0, block.body]
    first, second = ends_of(face)
    middle = rotation.T @ ((first + second) / 2.0 - landing.state.position[0, block.body])
    x, y, z = (frame.rotation.T @ (middle - frame.offset)).tolist()
    at_face = replace(contact, at="frame", offset=(x, y, z), kind="corner")
    along = second - first
    length = float(np.linalg.norm(along))
    if not length > 0.0:
        return at_face
    x, y, z = (along / length).tolist()
    return replace(at_face, kind="edge", edge=(x, y, z))
