"""The tables of a landing: bodies, points, parts, contacts, directions and joints; friction and contacts of finite stiffness."""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from shockpc.core.directions import ExtremeDirections
from shockpc.landing.places import Place, PlaceKind
from shockpc.landing.ratings import TorqueStrength
from shockpc.quantities.profile import ShockProfile
from shockpc.quantities.table import Selection, quantities_of, quantity
from shockpc.robot.robot import STOP
from shockpc.show.reports.answer import in_plane, without_geometry
from shockpc.show.tables import Row, Sheet
from shockpc.show.wording import contact_name, count, vector_text
from shockpc.text.printed import few

BODIES = {
    "|Δω| [rad/s]": "delta_omega",
    "CoPc {} [m]": "copc",
    "RoPc [m]": "ropc",
    "shock at CoM [-]": "shock_com",
    "least [-]": "shock_min",
    "greatest [-]": "shock_max",
    "out of plane [%]": "off_plane",
}
"""Quantities of the table of bodies by their headings, as `_columns` takes them."""

FACTORS = {"%": 100.0, "ms": 1e3}
"""Of units of headings that are not those of the quantities."""

OUT_OF_PLANE = 25.0
"""Share of a body's motion out of the plane above which a note says what its CoPc and RoPc describe [%]."""

PARALLEL = math.radians(1.0)
"""Largest angle to the ground of an impact direction that is called parallel to it."""


def _columns(
    profile: ShockProfile, kind: PlaceKind, headed: Mapping[str, str], places: Sequence[Place] | None = None
) -> dict[str, Any]:
    """Columns of quantities by heading, in its unit; of a vector three where the heading has {} for x, y and z, else the length."""
    columns: dict[str, Any] = {}
    for head, key in headed.items():
        entry = quantity(kind, key)
        values = FACTORS.get(head.rpartition("[")[2].removesuffix("]"), 1.0) * profile.values(entry, places)
        parts = dict(zip("xyz", values.T, strict=True)) if "{}" in head else {"": Selection(key, entry).scalar(values)}
        columns |= {head.format(axis): part for axis, part in parts.items()}
    return columns


def bodies_sheet(profile: ShockProfile, bodies: Sequence[int] | None = None) -> Sheet:
    """One row for each body that the impact moves; a word says why a CoPc is missing.

    Args:
        profile: the result.
        bodies: indices of the only bodies that are shown.
    """
    matching = range(len(profile.bodies)) if bodies is None else bodies
    shown = [i for i in matching if profile.moved[i]]
    columns = {"body": profile.bodies, **_columns(profile, "body", BODIES)}
    rows = []
    for i in shown:
        name, spin, *plane = (column[i] for column in columns.values())
        x, *others = (in_plane(profile, i, number) for number in plane[:4])
        if profile.translates[i]:
            x = "translates" if math.isnan(profile.pitch[i]) else "out of plane"
        rows.append((name, spin, x, *others, *plane[4:]))
    notes = []
    if any(100.0 * profile.off_plane[i] > OUT_OF_PLANE for i in shown):
        notes.append(
            f"out of plane above {OUT_OF_PLANE:.0f} %: CoPc and RoPc describe only the part of that body's motion that lies in the "
            "plane; the shock is that of the whole motion"
        )
    notes += without_geometry(profile, shown)
    if still := [profile.bodies[i] for i in matching if i not in shown]:
        notes.append(f"{count(len(still), 'body')} not shown, not moved by the impact: {few(still, 6)}")
    if hidden := len(profile.bodies) - len(matching):
        notes.append(f"{count(hidden, 'body')} not shown, no match for --body")
    return Sheet("bodies (CoPc in body coordinates; shock relative to the strike)", tuple(columns), rows, notes)


def every_body_sheet(profile: ShockProfile, bodies: Sequence[int] | None) -> Sheet:
    """The same for a spreadsheet, in which several landings can stand one below the other."""
    turns = ["yes" if translates else "no" for translates in profile.translates]
    named = {"contact": [contact_name(profile)] * len(turns), "body": profile.bodies}
    sheet = Sheet.of("", {**named, **_columns(profile, "body", BODIES), "no rotation in the plane": turns})
    return sheet if bodies is None else sheet._replace(rows=[sheet.rows[i] for i in bodies])


def contacts_sheet(profile: ShockProfile) -> Sheet:
    """One row for each contact and each stance foot, and their sum where there are several."""
    rows: list[Row] = []
    notes = []
    named = [(contact.frame, contact) for contact in profile.contacts]
    for name, contact in named + [(f"{foot.frame} (stance)", foot) for foot in profile.stance]:
        if contact.impulse is None:
            rows.append((name, "not unique", None, None, None))
            notes = ["the contact rows are redundant, so only the sum of the impulses is unique"]
        else:
            stop = name.startswith(STOP) and name not in profile.robot.frames
            needed = "end stop" if stop else "tensile" if contact.friction_needed is None else contact.friction_needed
            rows.append((name, *contact.impulse, needed))
    if len(rows) > 1:
        rows.append(("total", *profile.total_impulse, None))
        notes.append(f"total moment ({vector_text(profile.total_moment)}) N m s about the centre of mass of the robot")
    header = ("contact", "impulse x [N s]", "impulse y [N s]", "impulse z [N s]", "friction to stick [-]")
    return Sheet("contacts (impulse of the ground on the robot, world axes)", header, rows, notes)


def directions_sheet(profile: ShockProfile, most: int | None = None) -> Sheet:
    """The impact directions with the greatest and the least shock at each place, at the same speed.

    Args:
        profile: the result.
        most: rows to show, those of the greatest shock; the heaviest body, sensors and points always.
    """

    def row(place: str, extremes: ExtremeDirections) -> Row:
        way = "parallel" if abs(extremes.least_severe @ profile.landing.up) < PARALLEL else "towards"
        return place, extremes.most_severe_shock, *extremes.most_severe, extremes.least_severe_shock, *extremes.least_severe, way

    bodies = profile.robot.bodies
    moved = [k for k in range(len(bodies)) if profile.moved[k]]
    heaviest = max(bodies, key=lambda body: body.mass)
    rows = [row(f"CoM of {bodies[k].name}", ExtremeDirections(*(part[k] for part in profile.directions))) for k in moved]
    sizes = [math.inf if bodies[k] is heaviest else profile.directions.most_severe_shock[k] for k in moved]
    header = ("place", "most severe [-]", "x [-]", "y [-]", "z [-]", "least severe [-]", "x [-]", "y [-]", "z [-]", "to the ground")
    title = "most and least severe impact direction (unit vector of the velocity, world axes)"
    note = "over all directions towards the ground or parallel to it; an impact parallel to the ground is no landing"
    sheet = Sheet(title, header, rows, [note]).largest(most, "body", sizes)
    return sheet._replace(rows=[*sheet.rows, *(row(point.frame, point.directions) for point in profile.points)])


def points_sheet(profile: ShockProfile) -> Sheet:
    """One row for each sensor and each requested point; peak accelerations where the scene gives a pulse."""
    pulse, range_g = profile.scene.pulse, profile.scene.range_g
    named = {"point": [point.frame for point in profile.points], "on body": [point.body for point in profile.points]}
    headed = {"Δv {} [m/s]": "delta_v", "shock [-]": "shock"} | ({"peak [g]": "peak_g"} if pulse else {})
    columns = {**named, **_columns(profile, "point", headed)}
    if range_g is not None:
        columns[f"largest peak along an axis of {range_g:g} g [%]"] = 100.0 * profile.value("range_share", "point")
    of_pulse = "" if pulse is None else f"; peak acceleration for a pulse {pulse}"
    of_pulse += ", of the impulse model" if pulse and profile.stiffness is not None else ""
    return Sheet.of(f"sensors and points (Δv in the frame's axes{of_pulse})", columns)


def parts_sheet(profile: ShockProfile) -> Sheet:
    """One row for each part: margins by velocity change and acceleration, or by torque, and which counts or what is missing."""
    kinds = [isinstance(one.strength, TorqueStrength) for one in profile.parts]
    points, joints, peaks = not all(kinds), any(kinds), profile.impact_length is not None
    heads = ["part", *["|Δv| [m/s]", "critical [m/s]", "margin [-]"] * points]
    heads += ["peak [g]", "critical [g]", "margin by peak [-]"] * (points and peaks)
    heads += ["impulse along the axis [N m s, N s]", "torque [N m, N]", "withstands [N m, N]"] * joints
    heads += ["governing [-]", "by"] * (peaks or joints)
    rows: list[Row] = []
    bases: dict[str, list[str]] = {}
    for one in profile.parts:
        bound: Row
        if isinstance(one.strength, TorqueStrength):
            bound = (None,) * (3 * points + 3 * (points and peaks))
            bound += (None if one.along is None else abs(one.along), one.torque, one.strength.momentary_torque)
            basis = "the torque given" if one.strength.given else "the effort limit of the robot's file"
            bases.setdefault("" if math.isnan(one.strength.momentary_torque) else basis, []).append(one.part)
        else:
            bound = (one.speed_change, one.strength.velocity_change, one.velocity_margin)
            bound += (one.peak_g, one.strength.acceleration, one.acceleration_margin) * peaks + (None, None, None) * joints
            bases.setdefault(one.strength.basis, []).append(one.part)
        rows.append((one.part, *bound, one.part_margin, one.governed_by or one.missing)[: len(heads)])
    notes = [f"critical values of {few(names, 6)}: {basis}" for basis, names in bases.items() if basis]
    if profile.stiffness is not None and profile.scene.pulse is not None:
        notes.append("peaks and torques are those on the contact stiffness, whatever the pulse")
    if not peaks and points:
        notes.append("margins by velocity change alone, because a peak needs a pulse or a contact stiffness")
    if joints and profile.stiffness is None and any(one.torque is not None for one in profile.parts):
        notes.append(_torque_note(profile).replace("of the torque limit", "torque"))
    title = "parts (margin: factor on the speed of the strike below which the part survives)"
    return Sheet(title, heads, rows, notes)


def _torque_note(profile: ShockProfile) -> str:
    """What the torque of a joint is, of which its share is."""
    if profile.landing.pulse is not None:
        return f"of the torque limit: peak of a torque that has the pulse {profile.scene.pulse} and the impulse along the axis"
    return "of the torque limit: impulse along the axis over the duration for which the joint withstands its torque, a mean"


def posture_sheet(profile: ShockProfile) -> Sheet:
    """Where every joint of one coordinate stands, as `--set` takes it."""
    joints = [joint for joint in profile.robot.single_joints if joint.axis is not None]
    sizes = [1.0 if joint.kind == "prismatic" else math.degrees(1.0) for joint in joints]
    values = [joint.value(profile.q) * size for joint, size in zip(joints, sizes, strict=True)]
    return Sheet.of("posture", {"joint": [joint.name for joint in joints], "position [deg; m if prismatic]": values})


def joints_sheet(profile: ShockProfile) -> Sheet:
    """Every quantity of the joints that this landing has, a row for each joint; of a vector its length."""
    names = [place.name for place in profile.places("joint")]
    columns: dict[str, Iterable[Any]] = {"contact": [contact_name(profile)] * len(names), "joint": names}
    for entry in quantities_of("joint"):
        values = profile.numbers(Selection(entry.key, entry), profile.places("joint"))
        if not np.isnan(values).all():
            columns[f"{entry.key} [{entry.unit.replace('1', '-')}]"] = values
    return Sheet.of("", columns)


def _shocks_at(profile: ShockProfile, headed: Mapping[str, str]) -> dict[str, Iterable[Any]]:
    """Columns of shocks at the heaviest body's centre of mass, sensors and points. Args: headed, as in `_columns`."""
    places = profile.bracketed
    names = [f"CoM of {place.name}" if place.centre else place.name for place in places]
    return {"shock at": names, **_columns(profile, "point", headed, places)}


def bracket_sheet(profile: ShockProfile) -> Sheet:
    """The same landing with free joints, with the joints as modelled, and with locked joints."""
    headed = {"joints free [-]": "shock_free", "as modelled [-]": "shock", "joints locked [-]": "shock_locked"}
    named = {"free": "joints free", "locked": "joints locked", "springs_free": "locked, springs free"}
    # Without the remedy, which would be that of a scene with such joints.
    reasons = {model: text.removeprefix("no verdict: ").partition(";")[0] for model, text in profile.unsolved_joints.items()}
    notes = [f"–: no solution with {named[model]}: {reason}" for model, reason in reasons.items()]
    notes += ["free: no rotor, or each behind a soft spring; locked: gears and motors that do not yield during the impact"]
    if profile.landing.joint_model.springs.any():
        headed["locked, springs free [-]"] = "shock_springs_free"
        notes += [
            "joints with springs yield in the impact, whatever their motors do, so the last column counts, not that before it"
        ]
    names = {"shock at": [place.name for place in profile.bracketed]}
    return Sheet.of("effect of the joint model", names | _columns(profile, "point", headed, profile.bracketed), notes)


def loads_sheet(profile: ShockProfile, most: int | None) -> Sheet:
    """Impulse through every joint, or through those with the greatest force."""
    headed, notes = {"force [N s]": "joint_impulse", "moment [N m s]": "joint_moment", "along the axis [N m s, N s]": "along"}, []
    if profile.health.rank < profile.health.rows:
        notes.append("contact or closure rows are redundant: these are the joint loads of least norm")
    if profile.stiffness is None and not np.isnan(profile.value("joint_torque_share", "joint")).all():
        headed["of the torque limit [-]"] = "joint_torque_share"
        notes.append(_torque_note(profile))
    columns = {head: list(map(abs, values)) for head, values in _columns(profile, "joint", headed).items()}
    names = {"joint": [place.name for place in profile.places("joint")]}
    return Sheet.of("impulse through the joints", names | columns, notes).largest(most, "joint", columns["force [N s]"])


def friction_sheets(profile: ShockProfile) -> list[Sheet]:
    """What friction changes: contacts, and shock at the heaviest body and at points; nothing where all contacts stick anyway."""
    if (friction := profile.friction) is None or friction.impact is None:
        return []
    columns = _columns(profile, "contact", {"impulse {} [N s]": "impulse_friction", "velocity after {} [m/s]": "slip"})
    contacts = {"contact": [place.name for place in profile.places("contact")], "state": friction.state, **columns}
    name = f"friction {profile.scene.friction:g}"
    shocks = _shocks_at(profile, {"sticking [-]": "shock", f"{name} [-]": "shock_friction"})
    return [
        Sheet.of(f"contacts with {name} (world axes; double precision, not proven)", contacts),
        Sheet.of("effect of friction", shocks),
    ]


def stiffness_sheets(profile: ShockProfile, most: int | None) -> list[Sheet]:
    """Forces, accelerations and their times on contacts of finite stiffness, and the torques that drives carry."""
    if (compliant := profile.stiffness) is None:
        return []

    def columns(kind: PlaceKind, headed: Mapping[str, str]) -> dict[str, Iterable[Any]]:
        return {kind: [place.name for place in profile.places(kind)], **_columns(profile, kind, headed)}

    forces = {"99 % of the impulse in [ms]": "duration", "peak force [N]": "peak_force", "at [ms]": "peak_force_time"}
    title = f"contacts of {stiffness_text(profile)} (frozen geometry{_forces(profile)}; double precision, not proven)"
    sheets = [Sheet.of(title, columns("contact", forces))]
    if profile.places("point"):
        peaks = {"peak [g]": "peak_acceleration", "at [ms]": "peak_acceleration_time"}
        sheets.append(Sheet.of("peak accelerations on these contacts", columns("point", peaks)))
    if profile.places("joint"):
        torque, force = profile.value("peak_torque", "joint"), profile.value("peak_joint_force", "joint")
        headed = {
            "force [N]": "peak_joint_force",
            "moment [N m]": "peak_joint_moment",
            "along the axis [N m, N]": "peak_torque",
        }
        if not np.isnan(profile.value("joint_torque_share", "joint")).all():
            headed["of the torque limit [-]"] = "joint_torque_share"
        order = np.where(torque > 0.0, 1e6 * torque, force).tolist()
        sheets.append(Sheet.of("peaks through the joints", columns("joint", headed)).largest(most, "joint", order))
    ends = {"end of compression [-]": "shock_compressed", "end of contact [-]": "shock_separated", "impulse model [-]": "shock"}
    sheets.append(Sheet.of("velocity jumps on these contacts", _shocks_at(profile, ends)))
    frequency, energy, *_ = compliant.motion.modes
    carried: dict[str, Iterable[Any]] = {"frequency [Hz]": frequency, "kinetic energy before [J]": energy}
    for place, share in zip(profile.places("contact"), compliant.force_shares, strict=False):
        carried[f"of the force of {place.name} [%]"] = 100.0 * share
    modes = Sheet.of("modes, and the normal force that they carry", carried)
    return [*sheets, modes._replace(rows=modes.rows[:most])]


def _forces(profile: ShockProfile) -> str:
    """Which constant forces act, where they are not the usual ones."""
    if not profile.scene.gravity:
        return ", without gravity"
    motors = {"standing": ", motors hold the weight", "none": ", motors give no torque"}.get(profile.scene.joints.motors or "", "")
    return ", under gravity" + motors + ", given torques" * bool(profile.scene.joints.torque)


def stiffness_text(profile: ShockProfile) -> str:
    """The stiffness of contacts and end stops, and the damping, as the scene gives them."""
    scene = profile.scene
    along = "" if scene.tangential_stiffness is None else f" ({scene.tangential_stiffness:g} N/m along the ground)"
    stops = "" if scene.stop_stiffness is None else f", end stops of {scene.stop_stiffness:g} N m/rad or N/m"
    return f"{scene.contact_stiffness:g} N/m{along}{stops}" + (
        "" if scene.contact_damping is None else f", {scene.contact_damping:g} N s/m"
    )
