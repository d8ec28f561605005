"""The results of landings: the tables and lines of each, and their shocks side by side where there are several."""

import functools
import math
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from shockpc.core.directions import ExtremeDirections
from shockpc.landing.places import Place, PlaceKind
from shockpc.landing.ratings import Strength, TorqueStrength
from shockpc.landing.rows import Block
from shockpc.landing.scene import CONTACTS
from shockpc.landing.stops import side_of
from shockpc.quantities.parts import SOFTEST, STIFFEST
from shockpc.quantities.profile import ShockProfile
from shockpc.quantities.records import ContactImpulse
from shockpc.quantities.table import Selection, quantities_of, quantity
from shockpc.robot.robot import STOP
from shockpc.show.document import content
from shockpc.show.reports.answer import WORST, in_plane, landing_lines, moving_bodies, shocks_sheet, without_geometry, worst_first
from shockpc.show.reports.report import Picture, Report, Section, picture_files
from shockpc.show.tables import Lines, Row, Sheet, rounded
from shockpc.show.wording import (
    contact_name,
    count,
    header_lines,
    proof_text,
    robot_name,
    shared_lines,
    shared_warnings,
    shown_as,
    vector_text,
    warning_lines,
)
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

DETAILS = ("velocity jumps on these contacts", "modes, and the normal force that they carry")
"""Tables of a landing on contacts of finite stiffness that the answer leaves out."""

JOINTS = 3
"""Joints in the tables of an answer."""

COMPARED = 8
"""Bodies in the table of several landings, unless they are asked for by name."""

MORE = "--all prints everything that was computed"
"""The last line of an answer."""

CLEAN = ("warnings", "no warnings")
"""The line of a summary without warnings; of several landings one line says it of all."""

WARNING = 160
"""Characters of the first warning in a summary; whole warnings follow it."""

OUT_OF_PLANE = 25.0
"""Share of a body's motion out of the plane above which a note says what its CoPc and RoPc describe [%]."""

PARALLEL = math.radians(1.0)
"""Largest angle to the ground of an impact direction that is called parallel to it."""

NO_MITIGATION = "no impact mitigation factor (it requires a free base, no stance, and no loop that ties the robot to the world)"


def landing_report(
    profile: ShockProfile, bodies: Sequence[int] | None = None, spectrum: bool = False, whole: bool = False
) -> Report:
    """Everything of one landing; of the bodies only those that are given by their indices, save in the document.

    The files are profile.json, bodies.csv, points.csv, contacts.csv, joints.csv, report.md, shock.svg and shock.png; with parts
    also parts.csv and damage.svg, with a contact stiffness time.svg, and on request spectrum.svg, the shock response spectrum,
    which then is in profile.json too. On a terminal the answer alone is shown, or with `whole` all tables.
    """
    return Report(
        name="profile",
        title=f"Shock of {robot_name(profile.robot)} landing on {contact_name(profile)}",
        body=lambda full: [
            Lines(_summary(profile)),
            Lines(header_lines(profile)),
            Picture("shock", f"shock profile of {robot_name(profile.robot)}", "landing:draw_landing", (profile,)),
            *_tables(profile, bodies, None if full else 6),
            *_damage_picture([profile]),
            *_time_pictures(profile, spectrum),
        ],
        brief=None if whole else lambda: _answer(profile, bodies),
        closing=[
            *_balance_lines(profile),
            *_stop_lines(profile),
            *_ground_lines(profile),
            *_margin_lines(profile),
            f"contact rows: {profile.health.rank} of {profile.health.rows} independent",
            accuracy_line(profile),
        ],
        warnings=warning_lines(profile),
        sheets={
            "bodies": lambda: _every_body(profile, bodies),
            "points": lambda: _points_sheet(profile),
            "contacts": lambda: contacts_sheet(profile),
            **({"joints": lambda: _joints_sheet(profile)} if profile.loads else {}),
            **({"parts": lambda: _parts_sheet(profile)} if profile.parts else {}),
        },
        document=lambda: content(profile, spectrum),
        others=("joints.csv", "parts.csv", *picture_files("damage", "time", "spectrum")),
        landings={contact_name(profile): profile},
    )


def analyze_report(
    profiles: Sequence[ShockProfile],
    names: Sequence[str],
    bodies: Sequence[int] | None = None,
    spectrum: bool = False,
    whole: bool = False,
) -> Report:
    """The report of one landing, or of several with their shocks side by side.

    Args:
        profiles: the landings.
        names: of their folders.
        bodies: indices of the only bodies that are shown.
        spectrum: whether to draw the shock response spectrum of the points.
        whole: whether a terminal shows all tables of each.
    """
    parts = {name: landing_report(profile, bodies, spectrum, whole) for name, profile in zip(names, profiles, strict=True)}
    if len(parts) == 1:
        return next(iter(parts.values()))
    sheet = functools.partial(_side_by_side, profiles, bodies, None)
    landings = dict(zip(names, profiles, strict=True))

    def answers() -> list[Section]:
        each = [Lines([one for one in _summary_with_ground(profile) if one != CLEAN], name) for name, profile in landings.items()]
        head = landing_lines(shared_lines(landings)) + [CLEAN] * (not any(profile.health.warnings for profile in profiles))
        table, warnings = _side_by_side(profiles, bodies, None if bodies else COMPARED), Lines(shared_warnings(landings))
        return [Lines(head), *each, table, Lines([MORE]), warnings]

    return Report(
        name="summary",
        brief=None if whole else answers,
        page="summary",
        body=lambda _: [sheet(), *_damage_picture(profiles)],
        sheets={"summary": sheet},
        document=dict,
        others=picture_files("damage"),
        landings=landings,
        parts=parts,
    )


def _summary(profile: ShockProfile) -> list[tuple[str, str]]:
    """What matters most: the shock at the sensors, the largest impulse through a joint, and the warnings."""
    sensors = [row for row in profile.bracket if row.place in {place.name for place in profile.landing.points}]
    shown = [(row.place, row) for row in sensors] or [(f"CoM of {row.place}", row) for row in profile.bracket]
    ends = [(_or_none(row.free), _or_none(row.locked)) for _, row in shown]
    texts = [
        f"{name} {rounded(row.as_modelled)} (joints free {free} … locked {locked})"
        for (name, row), (free, locked) in zip(shown, ends, strict=True)
    ]
    loads, warnings = profile.loads, profile.health.warnings
    force = "none, because the robot has no joints"
    if loads:
        sizes = profile.value("joint_impulse", "joint")
        load, joint = loads[int(np.argmax(sizes))], profile.robot.joint(loads[int(np.argmax(sizes))].joint)
        along = (
            "" if load.along is None else f", {rounded(abs(load.along))} {'N s' if joint.unit == 'm' else 'N m s'} along its axis"
        )
        force = f"{load.joint} {rounded(sizes.max())} N s{along}"
        if not profile.choice.unique.all():
            force = "not determined, because rows are redundant"
        elif any(one.kind == "size" for one in warnings):
            force = "not determined, because the mechanism is singular or redundant here"
    first = CLEAN
    if warnings:
        first = "warnings", f"{count(len(warnings), 'warning')}: {textwrap.shorten(str(warnings[0]), WARNING, placeholder=' …')}"
    lines = [("shock", few(texts, 4, "; ")), ("joint", f"largest impulse: {force}"), first]
    if peaks := [f"{point.frame} {rounded(point.peak_g)} g" for point in profile.points if point.peak_g is not None]:
        lines.insert(1, ("peak", f"{few(peaks, 4)} for a pulse {profile.scene.pulse}"))
    return lines


def _or_none(shock: float | None) -> str:
    """A shock with other joints; the table of the joint model says why there is none."""
    return "without a solution" if shock is None else rounded(shock)


def _summary_with_ground(profile: ShockProfile) -> list[tuple[str, str]]:
    """The summary, and impulse, friction and effective mass at the contacts."""
    texts = []
    for contact, block in zip(profile.contacts, profile.landing.contacts, strict=True):
        if block.kind == "stop":
            texts.append(_stop_text(contact, block))
            continue
        if contact.impulse is None:
            texts.append(f"{contact.frame}: impulse not determined, because rows are redundant")
            continue
        needed = contact.friction_needed
        friction = "has to be pulled" if needed is None else f"sticks with friction {rounded(needed)} or more"
        size = f"impulse {rounded(math.hypot(*contact.impulse))} N s, effective mass {rounded(contact.mass_sticking)} kg"
        texts.append(f"{contact.frame}: {size}, {friction}")
    return [*_summary(profile), ("ground", few(texts, 4, "; "))]


def _stop_text(contact: ContactImpulse, stop: Block) -> str:
    """The impulse of an end stop that strikes, and what resists it."""
    slides = bool(len(stop.forces))
    impulse, unit, mass = (contact.impulse, "N s", "kg") if slides else (contact.moment, "N m s", "kg m²")
    size = "not determined" if impulse is None else f"{rounded(math.hypot(*impulse))} {unit}"
    what = "mass along its joint" if slides else "inertia about its joint"
    return f"{contact.frame}: impulse {size}, effective {what} {rounded(contact.effective_mass)} {mass}"


def _answer(profile: ShockProfile, bodies: Sequence[int] | None) -> list[Section]:
    """The summary, the landing, shocks and joint impulses with the worst first, and what decides on them."""
    doubles = [name for name, given in (("friction", profile.friction), ("stiffness", profile.stiffness)) if given]
    numbers = "proven" + "".join(f"; those with {name} in double precision" for name in doubles)
    ground = [sheet for sheet in (*_friction_sheets(profile), *_stiffness_sheets(profile, JOINTS)) if sheet.title not in DETAILS]
    loads = worst_first(_loads_sheet(profile, None))
    left = {"body": 0 if bodies else len(moving_bodies(profile, None)) - WORST, "joint": len(loads.rows) - JOINTS}
    others = " and ".join(count(n, noun) for noun, n in left.items() if n > 0)
    more = MORE + f", also of {others} with smaller values" * bool(others)
    return [
        Lines([*_summary_with_ground(profile), ("numbers", numbers)]),
        Lines(landing_lines(header_lines(profile))),
        shocks_sheet(profile, bodies),
        *([_parts_sheet(profile)] if profile.parts else []),
        *([_bracket_sheet(profile)] if profile.robot.joint_names else []),
        *([loads._replace(rows=loads.rows[:JOINTS])] if loads.rows else []),
        *ground,
        Lines([*_stop_lines(profile), *_ground_lines(profile), *_margin_lines(profile), more]),
    ]


def accuracy_line(profile: ShockProfile) -> str:
    """The proven error bound, and what double precision and the last digit of the data contribute."""
    health = profile.health
    proven = f"{proof_text(health.error_bound)} ({health.bits} bits)"
    double = f"was off by {health.double_error:.0e}" if math.isfinite(health.double_error) else "finds no solution"
    data = f"last-digit changes of the data move it by {health.data_sensitivity:.0e}"
    return f"accuracy: {proven}; double precision alone {double}; {data}"


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


def _every_body(profile: ShockProfile, bodies: Sequence[int] | None) -> Sheet:
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


def _tables(profile: ShockProfile, bodies: Sequence[int] | None, most: int | None) -> list[Sheet]:
    """Points, joint models and loads only where there are any, long tables cut to their largest rows."""
    return [
        bodies_sheet(profile, bodies),
        *([_points_sheet(profile)] if profile.points else []),
        *([_parts_sheet(profile)] if profile.parts else []),
        contacts_sheet(profile),
        *([_bracket_sheet(profile)] if profile.robot.joint_names else []),
        *([directions_sheet(profile, most)] if any(block.kind != "stop" for block in profile.landing.contacts) else []),
        *([_loads_sheet(profile, most)] if profile.loads else []),
        *_friction_sheets(profile),
        *_stiffness_sheets(profile, most),
    ]


def _points_sheet(profile: ShockProfile) -> Sheet:
    """One row for each sensor and each requested point; peak accelerations where the scene gives a pulse."""
    pulse, range_g = profile.scene.pulse, profile.scene.range_g
    named = {"point": [point.frame for point in profile.points], "on body": [point.body for point in profile.points]}
    headed = {"Δv {} [m/s]": "delta_v", "shock [-]": "shock"} | ({"peak [g]": "peak_g"} if pulse else {})
    columns = {**named, **_columns(profile, "point", headed)}
    if pulse and range_g is not None:
        columns[f"of {range_g:g} g [%]"] = 100.0 * profile.value("peak_g", "point") / range_g
    of_pulse = "" if pulse is None else f"; peak acceleration for a pulse {pulse}"
    of_pulse += ", of the impulse model" if pulse and profile.stiffness is not None else ""
    return Sheet.of(f"sensors and points (Δv in the frame's own axes{of_pulse})", columns)


def _parts_sheet(profile: ShockProfile) -> Sheet:
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


def _damage_picture(profiles: Sequence[ShockProfile]) -> list[Picture]:
    """The damage boundaries of the parts with the landings on them; nothing without parts."""
    if not any(isinstance(one.strength, Strength) for profile in profiles for one in profile.parts):
        return []
    return [Picture("damage", f"damage boundary of parts of {robot_name(profiles[0].robot)}", "damage:draw_damage", (profiles,))]


def _torque_note(profile: ShockProfile) -> str:
    """What the torque of a joint is, of which its share is."""
    if profile.landing.pulse is not None:
        return f"of the torque limit: peak of a torque that has the pulse {profile.scene.pulse} and the impulse along the axis"
    return "of the torque limit: impulse along the axis over the duration for which the joint withstands its torque, a mean"


def _joints_sheet(profile: ShockProfile) -> Sheet:
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


def _bracket_sheet(profile: ShockProfile) -> Sheet:
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


def _loads_sheet(profile: ShockProfile, most: int | None) -> Sheet:
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


def _friction_sheets(profile: ShockProfile) -> list[Sheet]:
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


def _stiffness_sheets(profile: ShockProfile, most: int | None) -> list[Sheet]:
    """Forces, accelerations and their times on contacts of finite stiffness, and the torques that drives carry."""
    if (compliant := profile.stiffness) is None:
        return []

    def columns(kind: PlaceKind, headed: Mapping[str, str]) -> dict[str, Iterable[Any]]:
        return {kind: [place.name for place in profile.places(kind)], **_columns(profile, kind, headed)}

    forces = {"99 % of the impulse in [ms]": "duration", "peak force [N]": "peak_force", "at [ms]": "peak_force_time"}
    title = f"contacts of {_stiffness(profile)} (frozen geometry{_forces(profile)}; double precision, not proven)"
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


def _time_pictures(profile: ShockProfile, spectrum: bool) -> list[Picture]:
    """The landing over time on contacts of finite stiffness, and on request the shock response spectrum of the points."""
    if profile.stiffness is None:
        return []
    name = robot_name(profile.robot)
    pictures = [Picture("time", f"forces, accelerations and torques of {name} over time", "history:draw_time", (profile,))]
    if spectrum and any(place.body >= 0 for place in profile.places("point")):
        pictures.append(Picture("spectrum", f"shock response spectrum of points of {name}", "history:draw_spectrum", (profile,)))
    return pictures


def _forces(profile: ShockProfile) -> str:
    """Which constant forces act, where they are not the usual ones."""
    if not profile.scene.gravity:
        return ", without gravity"
    motors = {"standing": ", motors hold the weight", "none": ", motors give no torque"}.get(profile.scene.joints.motors or "", "")
    return ", under gravity" + motors + ", given torques" * bool(profile.scene.joints.torque)


def _stiffness(profile: ShockProfile) -> str:
    scene = profile.scene
    along = "" if scene.tangential_stiffness is None else f" ({scene.tangential_stiffness:g} N/m along the ground)"
    stops = "" if scene.stop_stiffness is None else f", end stops of {scene.stop_stiffness:g} N m/rad or N/m"
    return f"{scene.contact_stiffness:g} N/m{along}{stops}" + (
        "" if scene.contact_damping is None else f", {scene.contact_damping:g} N s/m"
    )


def _stop_lines(profile: ShockProfile) -> list[str]:
    """Which end stops act, and with what impulse; a line each."""
    striking = [block for block in profile.landing.contacts if block.kind == "stop"]
    if not profile.scene.stops and not striking:
        return []
    values = dict(zip((p.name for p in profile.places("joint")), profile.value("stop_impulse", "joint").tolist(), strict=True))
    lines = []
    for stop in (*striking, *profile.landing.acting):
        side, name = "least" if side_of(profile.robot, stop) > 0.0 else "greatest", stop.frame.removeprefix(STOP)
        unit = "N m s" if len(stop.moments) else "N s"
        peak = f", at most {profile.stiffness.stop_peaks.get(name, 0.0):.4g} {unit.removesuffix(' s')}" if profile.stiffness else ""
        lines.append(f"the end stop of {name} at its {side} value acts with {abs(values[name]):.4g} {unit}{peak}")
    if profile.landing.acting:
        return [*lines, "numbers of other strikes, such as the most and least severe directions, are those with these stops held"]
    return lines or ["no end stop acts"]


def _margin_lines(profile: ShockProfile) -> list[str]:
    """From which contact stiffness on a margin of a part or a joint is lost."""
    if (lost := profile.margin_lost) is None:
        return []
    if lost.refused:
        return [f"contact stiffness from which on a margin is lost: not known, because {lost.refused}"]
    if not lost.place:
        return [f"no margin of a part or a joint is lost on contacts of up to {STIFFEST:g} N/m"]
    if not lost.contact_stiffness:
        return [f"the margin of {lost.place} is lost on contacts of any stiffness from {SOFTEST:g} N/m on"]
    return [f"the margin of {lost.place} is lost on contacts of {lost.contact_stiffness:.3g} N/m or more; {CONTACTS}"]


def _ground_lines(profile: ShockProfile) -> list[str]:
    """What friction, or a finite stiffness of the contacts, says of the landing; a line each."""
    if stiffness := profile.stiffness:
        percent = max(100.0 * stiffness.difference, 0.1)
        within = f"within {percent:.{0 if percent >= 10.0 else 1}f} % of the finite-stiffness result"
        how = f"jumps of the bodies at the end of contact, {_stiffness(profile)}, relative to the largest"
        if stiffness.agrees_by_construction and percent < 1.0:
            how += "; with restitution 0 they agree by construction, which is no evidence for the impulse model"
        elif percent >= 1.0 and np.any(stiffness.restitution > 0.0):
            how += "; part of the difference is between two laws of restitution, and remains on stiffer contacts"
        if profile.scene.contact_damping is not None:
            made = ", ".join(f"{e:.3g} at {c.frame}" for e, c in zip(stiffness.restitution, profile.contacts, strict=True))
            how += f"; the damping makes a restitution of {made}, which the impulse model has with --restitution alone"
        return [f"impulse model: {within} ({how})"]
    if (sliding := profile.friction) is None:
        return []
    name, n = f"friction {profile.scene.friction:g}", sliding.solutions
    others = f"; {count(n, 'solution')} found" if n > 1 else ""
    if sliding.impact is None:
        return [f"{name}: every contact sticks, so the results hold as they are{others}"]
    others += "; there may be more solutions" if len(sliding.state) > 1 else ""
    lost, rest = f"energy lost {sliding.energy_lost:.4g} J", "all other tables are without it, for contacts that stick"
    return [f"{name}: {lost}, residual {sliding.residual:.0e}, not proven{others}; {rest}"]


def _side_by_side(profiles: Sequence[ShockProfile], bodies: Sequence[int] | None, most: int | None) -> Sheet:
    """Several landings side by side: shock at bodies' centres of mass and at every point. Args: most, bodies; None for all."""
    first = profiles[0]
    shown = [
        i for i in range(len(first.bodies)) if (bodies is None or i in bodies) and any(profile.moved[i] for profile in profiles)
    ]
    shocks = [tuple(profile.shock_com[i] for profile in profiles) for i in shown]
    trunk = int(first.robot.masses.argmax())
    sizes = [math.inf if i == trunk else max(own) for i, own in zip(shown, shocks, strict=True)]
    rows = [(first.bodies[i], *own) for i, own in zip(shown, shocks, strict=True)]
    header = ("shock at", *map(contact_name, profiles))
    sheet = Sheet("summary: shock at each body's CoM and at each point [-], by contact", header, rows).largest(most, "body", sizes)
    points = zip(*(profile.points for profile in profiles), strict=True)
    return sheet._replace(rows=[*sheet.rows, *((f"at {same[0].frame}", *(point.shock for point in same)) for same in points)])


def _balance_lines(profile: ShockProfile) -> list[str]:
    """Energy, effective masses, impact mitigation and the closing of loops; one line each."""
    share = "" if profile.energy_share is None else f", {100.0 * profile.energy_share:.3g} % of the kinetic energy before impact"
    lost = f"{profile.energy_lost:.4g} J{share}" if math.isfinite(profile.energy_lost) else "not determined: a motor does work"
    lines = [f"energy lost: {lost}"]
    for contact, block in zip(profile.contacts, profile.landing.contacts, strict=True):
        mitigation = NO_MITIGATION
        if contact.mitigation is not None:
            factors = f"{contact.mitigation:.3f} sticking, {contact.mitigation_frictionless:.3f} frictionless"
            mitigation = f"impact mitigation factor {factors}"
        masses = f"{contact.mass_sticking:.4g} kg sticking, {contact.mass_frictionless:.4g} kg frictionless"
        if block.kind == "stop":
            lines.append(_stop_text(contact, block))
            continue
        lines.append(f"{contact.frame}: effective mass {masses}, {mitigation}")
    if assembly := profile.assembly:
        turn = f" and {shown_as(assembly.turn, 'rad')}" if assembly.turn > 0.0 else ""
        how = ", ".join(f"{name} by {shown_as(by, unit)}" for name, by, unit in assembly.moved) or "no joint had to move"
        lines.append(f"loops closed from a gap of {shown_as(assembly.gap, 'm')}{turn}: {how}")
    return lines
