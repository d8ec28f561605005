"""The tables of a landing: every quantity at every place.

People read views of them, the rows and columns that decide.
"""

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from shockpc.judgement.drive_range import range_of
from shockpc.judgement.first_number import shock_of
from shockpc.landing.contact import contact_name
from shockpc.landing.places import Place, PlaceKind
from shockpc.landing.ratings import TorqueStrength
from shockpc.quantities.records import ContactImpulse, PartMargin, StanceImpulse
from shockpc.quantities.selection import quantities_of, quantity
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.robot.robot import STOP
from shockpc.show.tables import Cell, Heading, Row, Sheet
from shockpc.show.wording import mostly_off_plane
from shockpc.studies.analyze.first_lines import range_ends, shown_places
from shockpc.text.wings import from_wings

TITLES: dict[PlaceKind, dict[str, str]] = {
    "body": {
        "copc": "CoPc {} [m]",
        "ropc": "RoPc [m]",
        "shock_com": "shock at CoM [-]",
        "shock_min": "minimum [-]",
        "shock_max": "maximum [-]",
        "out_of_plane_share": "out of plane [%]",
    },
    "point": {
        "delta_v": "Δv {} [m/s]",
        "peak_g": "peak [g]",
        "range_share": "largest peak along an axis, of the range [%]",
        "filtered_peak": "reading [g]",
        "filtered_peak_axes": "reading {} [g]",
    },
    "contact": {
        "impulse": "impulse {} [N s]",
        "friction_needed": "friction to stick [-]",
        "impulse_friction": "impulse with friction {} [N s]",
        "slip": "velocity after {} [m/s]",
    },
    "part": {
        "velocity_margin": "margin [-]",
        "peak_g": "peak [g]",
        "filtered_peak": "reading [g]",
        "acceleration_margin": "margin by peak [-]",
        "along": "impulse along the axis [N m s, N s]",
        "part_margin": "governing [-]",
    },
    "joint": {
        "joint_impulse": "force [N s]",
        "joint_moment": "moment [N m s]",
        "along": "along the axis [N m s, N s]",
        "joint_torque_share": "of the torque limit [-]",
    },
}
"""Headings that people read, with {} for the component of a vector.

Other quantities are headed by their keys. Those of wings follow.
"""

ALWAYS: dict[PlaceKind, tuple[str, ...]] = {
    "body": tuple(TITLES["body"]),
    "contact": ("impulse", "friction_needed"),
}
"""Quantities that have a column even if no place has a value."""

MODELS = ("shock_free", "shock", "shock_locked", "shock_springs_free", "shock_friction")
"""Shocks of the table of these, besides those of wings."""

EXTREMES = ("most_severe", "most_severe_direction", "least_severe", "least_severe_direction")
"""Quantities of bodies and points that have a table of their own."""

CRITICAL = (
    Heading("critical_velocity_change", "critical", "m/s"),
    Heading("critical_acceleration", "critical peak", "g"),
    Heading("both", "both"),
    Heading("momentary_torque", "withstands", "N m, N"),
    Heading("torque_duration", "withstands it for", "s"),
)
"""Columns of what parts withstand."""

PARALLEL = math.radians(1.0)
"""Largest angle to the ground of an impact direction that is called parallel to it."""


def landing_tables(
    profile: ShockProfile, bodies: Sequence[int] | None = None
) -> dict[str, Callable[[], Sheet]]:
    """All tables of a landing by name, each made when it is read.

    Args:
        profile: the result.
        bodies: indices of the only bodies that are shown.
    """
    makers: dict[str, tuple[Any, Callable[[ShockProfile], Sheet]]] = {
        "bodies": (True, partial(bodies_sheet, bodies=bodies)),
        "points": (True, points_sheet),
        "parts": (profile.parts, parts_sheet),
        "contacts": (True, contacts_sheet),
        "shocks": (True, shocks_sheet),
        "directions": (
            any(contact.kind != "stop" for contact in profile.landing.contacts),
            directions_sheet,
        ),
        "joints": (profile.robot.joint_names, joints_sheet),
    }
    shown = {name: make for name, (there, make) in makers.items() if there}
    for tables_of in from_wings("report", "tables"):
        shown |= tables_of(profile)
    shown["landing"] = landing_sheet
    return {name: partial(make, profile) for name, make in shown.items()}


def _quantities(
    profile: ShockProfile, kind: PlaceKind, places: Sequence[Place] | None = None, *keys: str
) -> dict[Any, Any]:
    """Columns of the quantities of a kind that this landing has; of a vector three.

    Args: places, all without; keys, the same.
    """
    titles = dict(TITLES.get(kind, {}))
    for of_wing in from_wings("report", "TITLES"):
        titles |= of_wing.get(kind, {})
    if not keys:
        others = [entry.key for entry in quantities_of(kind) if entry.key not in EXTREMES]
        keys = tuple(dict.fromkeys([*titles, *others]))
    columns: dict[Any, Any] = {}
    for key in keys:
        entry = quantity(kind, key)
        values = profile.value(key, kind, places)
        if np.isnan(values).all() and key not in ALWAYS.get(kind, ()):
            continue
        unit = "" if entry.flag else f" [{entry.unit_text}]"
        head = titles.get(key, f"{key}{' {}' * entry.vector}{unit}")
        components = {"": values}
        if entry.vector:
            components = dict(zip("xyz", values.T, strict=True))
        for axis, component in components.items():
            heading = Heading.of(head.format(axis))._replace(key=f"{key}_{axis}".removesuffix("_"))
            columns[heading] = component.astype(bool) if entry.flag else component
    return columns


def bodies_sheet(profile: ShockProfile, bodies: Sequence[int] | None = None) -> Sheet:
    """One row for each body; a word says why a CoPc is missing, or describes little of the motion.

    Args:
        profile: the result.
        bodies: indices of the only bodies that are shown.
    """
    named: dict[Any, Any] = {
        "contact": [contact_name(profile.scene)] * len(profile.bodies),
        "body": profile.bodies,
    }
    spin = {Heading("delta_omega", "|Δω|", "rad/s"): np.linalg.norm(profile.delta_omega, axis=1)}
    motion = [_motion(profile, i) for i in range(len(profile.bodies))]
    title = "bodies (CoPc in body coordinates; shock: |Δv| / v_in)"
    sheet = Sheet.of(title, {**named, **spin, **_quantities(profile, "body"), "motion": motion})
    if bodies is None:
        return sheet
    return sheet._replace(rows=[sheet.rows[i] for i in bodies])


def _motion(profile: ShockProfile, i: int) -> str | None:
    """A word on the motion of a body that does not rotate in the plane; else None.

    It is to be known before the CoPc and the RoPc are read.
    """
    if profile.translates[i]:
        return "translates" if math.isnan(profile.screw_pitch[i]) else "out of plane"
    return "mostly out of plane" if mostly_off_plane(profile)[i] else None


def landing_sheet(profile: ShockProfile) -> Sheet:
    """The quantities of the whole robot, in one row."""
    keys = [entry.key for entry in quantities_of("robot") if entry.computation.on != "health"]
    return Sheet.of(
        "landing",
        {"contact": [contact_name(profile.scene)], **_quantities(profile, "robot", None, *keys)},
    )


def contacts_sheet(profile: ShockProfile) -> Sheet:
    """One row for each contact and each stance foot, and their sum where there are several."""
    places = profile.places("contact")
    feet: list[ContactImpulse | StanceImpulse] = [*profile.contacts, *profile.stance]
    states = [None] * len(places) if profile.friction is None else profile.friction.state
    columns = {
        "contact": [place.name for place in places],
        **_quantities(profile, "contact"),
        "state": states,
    }
    columns["what"] = [_what(profile, k, foot) for k, foot in enumerate(feet)]
    sheet = Sheet.of("contacts", columns)
    if len(places) < 2:
        return sheet
    sums: dict[str, Cell] = {"contact": "total"}
    for axis, impulse in zip("xyz", profile.total_impulse.tolist(), strict=True):
        sums[f"impulse_{axis}"] = impulse
    return sheet._replace(rows=[*sheet.rows, [sums.get(key) for key in sheet.keys]])


def _what(profile: ShockProfile, k: int, contact: ContactImpulse | StanceImpulse) -> str | None:
    """Words on a contact that are to be known before its numbers are read; else None."""
    is_stance = k >= len(profile.contacts)
    words = ["stance"] if is_stance else []
    if not is_stance and profile.scene.contact[k].kind in ("edge", "corner"):
        words.append(profile.scene.contact[k].kind)
    if contact.impulse is None:
        words.append("not unique")
    elif contact.frame.startswith(STOP) and contact.frame not in profile.robot.frames:
        words.append("end stop")
    elif contact.friction_needed is None:
        words.append("tensile")
    return ", ".join(words) or None


def directions_sheet(profile: ShockProfile) -> Sheet:
    """The impact directions with the largest and the smallest shock, at the same speed.

    They are of each body's CoM and each point.
    """
    header: list[str | Heading] = ["place"]
    for key, word in (("most_severe", "most"), ("least_severe", "least")):
        header.append(Heading(key, f"{word} severe", "-"))
        header += [Heading(f"{key}_direction_{axis}", f"{word} {axis}", "-") for axis in "xyz"]
    header.append("to the ground")
    extremes: list[tuple[Any, ...]] = []
    for name, *of_body in zip(profile.bodies, *profile.directions, strict=True):
        extremes.append((f"CoM of {name}", *of_body))
    extremes += [(point.frame, *point.directions) for point in profile.points]
    rows: list[Row] = []
    for place, most, most_shock, least, least_shock in extremes:
        way = "parallel" if abs(least @ profile.landing.up) < PARALLEL else "towards"
        rows.append((place, most_shock, *most, least_shock, *least, way))
    title = "most and least severe impact direction (unit vector of the velocity, world axes)"
    note = (
        "over all directions towards the ground or parallel to it; an impact parallel to the "
        "ground is no landing"
    )
    return Sheet(title, header, rows, [note])


def points_sheet(profile: ShockProfile) -> Sheet:
    """One row for each sensor and each requested point."""
    named: dict[Any, Any] = {"point": [point.frame for point in profile.points]}
    named[Heading("body", "on body")] = [point.body for point in profile.points]
    return Sheet.of("sensors and points", {**named, **_quantities(profile, "point")})


def parts_sheet(profile: ShockProfile) -> Sheet:
    """One row for each part: margins by velocity change and acceleration, or by torque.

    It says which margin counts, or what is missing.
    """
    parts = profile.parts
    withstood = [_critical(part) for part in parts]
    critical: dict[Any, Any] = {}
    for k, column in enumerate(CRITICAL):
        critical[column] = [values[k] for values in withstood]
    return Sheet.of(
        "parts (margin: survivable contact velocity / contact velocity)",
        {
            "part": [part.part for part in parts],
            "body": [part.body for part in parts],
            "joint": [part.joint or None for part in parts],
            Heading("speed_change", "|Δv|", "m/s"): [part.speed_change for part in parts],
            **critical,
            "basis": [basis_of(part) for part in parts],
            **_quantities(profile, "part"),
            Heading("governed_by", "by"): [part.governed_by or None for part in parts],
            "missing": [part.missing or None for part in parts],
        },
    )


def _critical(part: PartMargin) -> Row:
    """The critical values of a part: velocity change, acceleration, if both; or torque, time."""
    strength = part.strength
    if isinstance(strength, TorqueStrength):
        return (None, None, None, strength.momentary_torque, strength.duration)
    return (strength.velocity_change, strength.acceleration, strength.both, None, None)


def basis_of(part: PartMargin) -> str | None:
    """The source of the critical values of a part."""
    if not isinstance(part.strength, TorqueStrength):
        return part.strength.basis
    if math.isnan(part.strength.momentary_torque):
        return None
    return "the torque given" if part.strength.in_part else "the effort limit of the robot's file"


def joints_sheet(profile: ShockProfile) -> Sheet:
    """The position of each joint, as `--set` takes it, and every quantity of it."""
    joints = [profile.robot.joint(place.name) for place in profile.places("joint")]
    angles: list[float | None] = []
    distances: list[float | None] = []
    for joint in joints:
        value = None if joint.axis is None else joint.value(profile.q)
        slides = joint.kind == "prismatic"
        angles.append(None if value is None or slides else math.degrees(value))
        distances.append(value if slides else None)
    columns: dict[Any, Any] = {
        "contact": [contact_name(profile.scene)] * len(joints),
        "joint": [joint.name for joint in joints],
        "position [deg]": angles,
        "position [m]": distances,
        **_quantities(profile, "joint"),
    }
    notes = []
    if profile.health.rank < profile.health.rows:
        notes.append(
            "contact or closure rows are redundant: these are the joint loads of minimum norm"
        )
    return Sheet.of("impulse through the joints", columns, notes)


def shocks_sheet(profile: ShockProfile) -> Sheet:
    """Shocks at the heaviest body's centre of mass, sensors and points.

    They are with other joints, with friction, and on soft contacts. The range over the drives is of
    the places of the first lines and of the heaviest body.
    """
    keys = [*MODELS]
    for of_wing in from_wings("report", "SHOCKS"):
        keys += of_wing
    places = profile.bracketed
    shown = {place.name for place in (places[0], *shown_places(profile))}
    ranges = []
    for place in places:
        over_drives = range_of(profile, shock_of(profile), place) if place.name in shown else None
        ranges.append(over_drives)
    smallest, largest = range_ends(ranges)
    columns: dict[Any, Any] = {
        "shock at": [place.title for place in places],
        **_quantities(profile, "point", places, *keys),
    }
    if any(end is not None for end in smallest):
        columns["smallest found [-]"] = smallest
        columns["largest found [-]"] = largest
    return Sheet.of("shocks", columns)
