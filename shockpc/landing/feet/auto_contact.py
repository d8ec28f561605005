"""Where a contact strikes, and what of its sole carries, where a scene leaves that open.

Both are resolved once, in the scene's posture. A contact is at its frame's origin if an offset is
given or the link has no geometry, and where the origin lies in the middle of a foot or on the
centre line of a beam; else at the lowest point of its geometry. If that has a sole, the contact is
what carries of it: all (flat), an edge or a corner. A foot that the others lift is left out. As a
point in the middle of a sole, a humanoid's foot would pivot, and the shock be several times too
small.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace

import numpy as np

from shockpc.core.spatial import Array
from shockpc.landing.contact import contact_constraint
from shockpc.landing.feet.faces import carrying_faces, entering_speeds
from shockpc.landing.feet.soles import (
    INSIDE,
    LEVEL,
    SHARE,
    distance_aside,
    ends_of,
    is_thin,
    most_inside,
    sole_corners,
)
from shockpc.landing.landing import PosedLanding
from shockpc.landing.scenes.directions import across
from shockpc.landing.scenes.scene import Contact
from shockpc.method.constraints import Constraint
from shockpc.robot.robot import Robot
from shockpc.robot.shapes.geometry import robot_size
from shockpc.robot.shapes.lowest import height_of_lowest, lowest_points
from shockpc.robot.shapes.striking import Striking, own_shapes, striking
from shockpc.text.diagnostic import Diagnostic
from shockpc.text.printed import listed

MIDDLE = 1e-6
"""Difference in height of points in whose middle a contact is, as a share of what they span."""

ENTERS = 1e-3
"""Share of the speed of a strike from which on a foot that is left out enters the ground [1]."""

LIFTED = "lifted"
"""Kind of the warning of a foot that is left out."""


def resolve_contacts(landing: PosedLanding) -> PosedLanding:
    """The landing with its contacts at definite points and of definite kinds; what is given stays.

    Args:
        landing: as it was asked for.

    Raises:
        SolveError: what of the soles carries is not found.
    """
    if not any("auto" in (contact.at, contact.kind) for contact in landing.asked):
        return landing
    unread = list[Diagnostic]()
    for contact, constraint in zip(landing.asked, landing.asked_rows, strict=True):
        if constraint.kind != "stop":
            unread += _unread_geometry(landing.robot, contact)
    if unread:
        landing = replace(landing, warnings=(*landing.warnings, *unread))
    return _with_faces(with_flat_soles(landing), carrying_faces)


def with_own_faces(landing: PosedLanding) -> PosedLanding:
    """The landing with its own faces: what of its soles carries with its joint model.

    Whoever changes the joint model of a landing calls this: for locked joints, for rotors at one
    end of their range. A landing without soles is returned as it is, and so is one in another
    posture than that of its scene, whose contacts are definite.

    Raises:
        SolveError: what of the soles carries is not found.
    """
    has_soles = bool(landing.lifted) or any(len(constraint.sole) for constraint in landing.contacts)
    if not has_soles or not landing.asked_rows:
        return landing
    return _with_faces(with_flat_soles(landing), carrying_faces)


def with_faces_of(
    landing: PosedLanding,
    mechanism: Callable[[PosedLanding], PosedLanding],
) -> PosedLanding:
    """The landing with what of its soles carries in another mechanism, such as links that bend.

    It keeps its own faces where these have another number of contacts, because a foot is lifted.

    Args:
        landing: with its own faces.
        mechanism: makes the landing of flat soles one of the mechanism, with the same contacts.

    Raises:
        SolveError: what of the soles carries is not found.
    """
    has_sole = any(len(constraint.sole) for constraint in landing.contacts)
    if not landing.asked_rows or not has_sole:
        return landing
    flat = with_flat_soles(landing)
    carried = _with_faces(flat, lambda landing: carrying_faces(mechanism(landing)))
    return landing if landing.lifted or carried.lifted else carried


def with_flat_soles(landing: PosedLanding) -> PosedLanding:
    """The landing that was asked for, with every sole whose kind is open as a flat contact."""
    contacts = dict[int, Contact]()
    soles = dict[int, Array]()
    for number, (contact, constraint) in enumerate(
        zip(landing.asked, landing.asked_rows, strict=True)
    ):
        if constraint.kind == "stop":
            contacts[number] = _as_point(contact)
            continue
        at_point = _placed(landing, contact, constraint)
        sole = _sole(landing, contact, constraint)
        if sole is not None:
            soles[number] = sole
            at_point = replace(at_point, kind="flat")
        contacts[number] = at_point
    return _with_contacts(landing, contacts, soles)


def _as_point(contact: Contact) -> Contact:
    """A contact that is open as a point at its frame."""
    at = "frame" if contact.at == "auto" else contact.at
    return replace(contact, at=at, kind="point" if contact.kind == "auto" else contact.kind)


def _with_contacts(
    landing: PosedLanding,
    contacts: Mapping[int, Contact],
    soles: Mapping[int, Array],
    lifted: tuple[int, ...] = (),
    warnings: tuple[Diagnostic, ...] | None = None,
) -> PosedLanding:
    """The landing with some of its contacts, by their number among those that it was asked for.

    Args:
        landing: which was asked for its contacts.
        contacts: definite ones.
        soles: corners (n, 3) of those that have a sole, in the frame of their body [m].
        lifted: bodies of the feet that are left out.
        warnings: by default those of the landing.
    """
    rows = []
    for number, contact in contacts.items():
        constraint = landing.asked_rows[number]
        if constraint.kind != "stop" and contact != landing.asked[number]:
            constraint = contact_constraint(landing.robot, contact, constraint.normal)
        rows.append(constraint._replace(sole=soles[number]) if number in soles else constraint)
    return replace(
        landing,
        scene=replace(landing.scene, contact=tuple(contacts.values())),
        contacts=tuple(rows),
        lifted=lifted,
        warnings=landing.warnings if warnings is None else warnings,
    )


def _placed(landing: PosedLanding, contact: Contact, constraint: Constraint) -> Contact:
    """A contact at a definite point, as a point if its kind is open."""
    at_point = _as_point(contact)
    if contact.at != "auto" or contact.offset is not None:
        return at_point
    robot, strikes = landing.robot, striking(landing.robot, contact.frame)
    is_point = not strikes.shapes or (strikes.is_place and not strikes.is_foot)
    up = constraint.normal @ landing.state.rotation[0, constraint.body]
    origin, tolerance = np.reshape(constraint.point, 3), landing.scene.ground_tolerance
    if is_point or _is_near_lowest(robot, strikes, origin, up, tolerance):
        return at_point
    shapes = own_shapes(robot, contact.frame)[0]
    if shapes and height_of_lowest(shapes, up) <= height_of_lowest(strikes.shapes, up) + LEVEL:
        return replace(at_point, at="lowest")
    frame = robot.frame(contact.frame)
    low = lowest_points(strikes.shapes, up, 0.0)
    span = float(np.ptp(low, axis=0).max())
    middle = lowest_points(strikes.shapes, up, MIDDLE * max(span, MIDDLE)).mean(axis=0)
    offset = frame.rotation.T @ (middle - frame.offset)
    return replace(at_point, offset=(float(offset[0]), float(offset[1]), float(offset[2])))


def _is_near_lowest(
    robot: Robot,
    strikes: Striking,
    point: Array,
    up: Array,
    tolerance: float,
) -> bool:
    """True if a point (3,) of a body is near the lowest points of shapes, in height and aside."""
    height = float(up @ point) - height_of_lowest(strikes.shapes, up)
    aside = distance_aside(point, lowest_points(strikes.shapes, up, tolerance), up)
    distance = max(height, aside)
    # Without its meshes, which need not be read then, the robot measures less.
    return distance <= INSIDE + SHARE * robot_size(robot, False) or distance <= most_inside(robot)


def _sole(landing: PosedLanding, contact: Contact, constraint: Constraint) -> Array | None:
    """The corners (n, 3) of a contact's sole, in its body's frame [m]; None without a choice."""
    if contact.kind != "auto" or contact.offset is not None:
        return None
    x, y, z = (constraint.normal @ landing.state.rotation[0, constraint.body]).tolist()
    return sole_corners(landing.robot, contact.frame, (x, y, z), landing.scene.ground_tolerance)


def _unread_geometry(robot: Robot, contact: Contact) -> list[Diagnostic]:
    """A warning where geometry of an open contact could not be read."""
    if "auto" not in (contact.at, contact.kind) or contact.offset is not None:
        return []
    strikes = striking(robot, contact.frame)
    if not strikes.unread:
        return []
    names = listed(dict.fromkeys(lost.mesh or lost.reason for lost in strikes.unread), 3)
    consequence = "it strikes at the origin of its frame, as a point"
    if strikes.shapes and not strikes.is_place:
        consequence = "only its other shapes decide where it strikes"
    text = (
        f'the geometry of contact "{contact.frame}" could not be read ({names}), so {consequence}; '
        "say where the meshes are (packages), or give the point by an offset"
    )
    return [Diagnostic("geometry", contact.frame, None, text)]


def _with_faces(
    flat: PosedLanding,
    faces_of: Callable[[PosedLanding], Mapping[int, np.ndarray]],
) -> PosedLanding:
    """The landing of flat soles with what carries of them.

    A foot that the others lift does not stick either, so the others are solved again without it.

    Args:
        flat: as of `with_flat_soles`.
        faces_of: finds the faces of such a landing, as `carrying_faces` does.
    """
    contacts = dict(enumerate(flat.scene.contact))
    soles: dict[int, Array] = {}
    for number, constraint in enumerate(flat.contacts):
        if len(constraint.sole):
            soles[number] = constraint.sole
    if not soles:
        return flat
    landing = flat
    lifted: list[int] = []
    while True:
        numbers = list(contacts)
        faces = {numbers[k]: face for k, face in faces_of(landing).items()}
        risen = [number for number, face in faces.items() if not len(face)]
        if not risen or len(risen) == len(contacts):
            break
        for number in risen:
            del contacts[number], soles[number]
        lifted += risen
        landing = _with_contacts(flat, contacts, soles)
    for number, face in faces.items():
        if len(face):
            contacts[number] = _on_face(flat, number, face)
    bodies = tuple(flat.contacts[number].body for number in lifted)
    warnings = [warning for warning in flat.warnings if warning.kind != LIFTED]
    warnings += _lifted_warnings(flat, lifted)
    return _with_contacts(flat, contacts, soles, bodies, tuple(warnings))


def _lifted_warnings(flat: PosedLanding, lifted: list[int]) -> Iterator[Diagnostic]:
    """A warning for each foot that the impact on the others lifts.

    Args:
        flat: as of `with_flat_soles`.
        lifted: numbers of the contacts.
    """
    if not lifted:
        return
    for number, share in zip(lifted, entering_speeds(flat, lifted), strict=True):
        frame = flat.contacts[number].frame
        text = (
            f"{frame} is lifted by the impact on the other feet, so it takes no impulse and is "
            f"left out"
        )
        if share > ENTERS:
            text += (
                f"; yet without it, it enters the ground at {share:.0%} of the contact velocity, "
                "so this is no landing on flat ground. Compare it with --contact-kind point"
            )
        yield Diagnostic(LIFTED, frame, None, text)


def _on_face(landing: PosedLanding, number: int, face: np.ndarray) -> Contact:
    """A contact of a landing of flat soles as what carries of its sole: all, an edge, or a corner.

    Args:
        landing: as of `with_flat_soles`.
        number: of the contact.
        face: numbers of the corners that carry.
    """
    contact, constraint = landing.scene.contact[number], landing.contacts[number]
    frame, rotation = landing.robot.frame(contact.frame), landing.state.rotation[0, constraint.body]
    outline = constraint.sole @ rotation.T @ np.transpose(across(constraint.normal))
    if len(face) == len(constraint.sole) and not is_thin(outline):
        return contact
    if landing.asked[number].at == "frame":
        # A point that is given stays where it is.
        return replace(contact, kind="point")
    first, second = ends_of(constraint.sole[face])
    middle = frame.rotation.T @ ((first + second) / 2.0 - frame.offset)
    x, y, z = middle.tolist()
    at_face = replace(contact, at="frame", offset=(x, y, z), kind="corner")
    along = rotation @ (second - first)
    length = float(np.linalg.norm(along))
    if not length > 0.0:
        return at_face
    x, y, z = (along / length).tolist()
    return replace(at_face, kind="edge", edge=(x, y, z))
