"""What people read of the tables of a landing: the rows and columns that decide, under headings of
their own.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from shockpc.judgement.unknowns import NOT_KNOWN
from shockpc.quantities.of_points import low_passes
from shockpc.quantities.selection import quantity
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.show.tables import Column, Sheet
from shockpc.show.wording import BRACKETED, count, vector_text
from shockpc.studies.analyze.first_lines import shown_places
from shockpc.studies.analyze.sheets import (
    basis_of,
    bodies_sheet,
    contacts_sheet,
    directions_sheet,
    joints_sheet,
    parts_sheet,
    points_sheet,
    shocks_sheet,
)
from shockpc.text.printed import few
from shockpc.text.wings import doors

READINGS = {"filtered_peak": "", **{f"filtered_peak_axes_{axis}": "" for axis in "xyz"}}
"""Columns of what accelerometers read."""

OUT_OF_PLANE = 0.25
"""Share of a body's motion out of the plane above which a note says what its CoPc and RoPc
describe.
"""


def shown_tables(
    profile: ShockProfile, bodies: Sequence[int] | None, most: int | None
) -> dict[str, Callable[[], Sheet]]:
    """The views of the tables that people read.

    Args: bodies, as above; most, rows of long tables, None for all.
    """
    jointed, friction = bool(profile.robot.joint_names), profile.friction
    slides = friction is not None and friction.impact is not None
    views: dict[str, tuple[Any, Callable[[], Sheet]]] = {
        "bodies": (True, lambda: moved_bodies(profile, bodies)),
        "points": (profile.points, lambda: pointsview(profile)),
        "parts": (profile.parts, lambda: partsview(profile)),
        "contacts": (True, lambda: contactsview(profile)),
        "joint_models": (jointed, lambda: joint_models(profile, most)),
        "directions": (
            any(block.kind != "stop" for block in profile.landing.contacts),
            lambda: extreme_directions(profile, most),
        ),
        "joints": (jointed, lambda: loads_sheet(profile, most)),
        "friction_contacts": (slides, lambda: friction_contacts(profile)),
        "friction_shocks": (slides, lambda: friction_shocks(profile)),
    }
    shown = {name: make for name, (there, make) in views.items() if there}
    for door in doors("report"):
        shown |= door.views(profile, most)
    if jointed:
        shown["posture"] = lambda: posture(profile)
    return shown


def view(sheet: Sheet, title: str, headings: Mapping[str, str], notes: Sequence[str] = ()) -> Sheet:
    """Some columns of a table under other headings. Args: headings, by key; empty to keep it."""
    shown = sheet.only(*headings)
    heads = [
        Column.of(headings[one.key])._replace(key=one.key) if headings[one.key] else one
        for one in shown.columns
    ]
    return Sheet(title, heads, shown.rows, notes).known()


def _vector(key: str, heading: str) -> dict[str, str]:
    """Headings of the components of a vector."""
    return {f"{key}_{axis}": heading.format(axis) for axis in "xyz"}


def moved_bodies(profile: ShockProfile, bodies: Sequence[int] | None = None) -> Sheet:
    """The bodies that the impact moves, with what is to be known of them."""
    matching = range(len(profile.bodies)) if bodies is None else bodies
    shown = [i for i in matching if profile.moved[i]]
    notes = []
    if any(profile.out_of_plane_share[i] > OUT_OF_PLANE for i in shown):
        notes.append(
            f"out of plane above {100.0 * OUT_OF_PLANE:.0f} %: CoPc and RoPc describe only the "
            f"body's motion in the plane, "
            f"the shock its whole motion; mostly: above {100.0 * BRACKETED:.0f} %"
        )
    if names := [profile.bodies[i] for i in shown if math.isnan(profile.shock_max[i])]:
        notes.append(
            f"no geometry over which to take the minimum and maximum shock: {few(names, 4)}"
        )
    if still := [profile.bodies[i] for i in matching if i not in shown]:
        notes.append(
            f"{count(len(still), 'body')} not shown, not moved by the impact: {few(still, 6)}"
        )
    if hidden := len(profile.bodies) - len(matching):
        notes.append(f"{count(hidden, 'body')} not shown, no match for --body")
    columns = (
        "body",
        "delta_omega",
        "copc_x",
        "copc_y",
        "copc_z",
        "ropc",
        "shock_com",
        "shock_min",
        "shock_max",
        "out_of_plane_share",
    )
    sheet = bodies_sheet(profile, shown).only(*columns, "motion")._replace(notes=notes)
    return sheet if any(row[-1] for row in sheet.rows) else sheet.without("motion")


def worst_bodies(
    profile: ShockProfile, most: int | None, bodies: Sequence[int] | None = None
) -> Sheet:
    """The bodies of the largest shocks, those first, and the heaviest.

    Args: most, their number; None for all.
    """
    whole, heaviest = moved_bodies(profile, bodies), profile.bodies[profile.main_body]
    # as the column `motion` says
    notes = [note for note in whole.notes if not note.startswith("out of plane")]
    sheet = whole.only(
        "body", "shock_com", "shock_max", "ropc", "copc_x", "copc_y", "copc_z", "motion"
    )._replace(notes=notes)
    sizes = [math.inf if row[0] == heaviest else float(row[1] or 0.0) for row in sheet.rows]
    return sheet.largest(most, "body", sizes).ranked("shock_com")


def contactsview(profile: ShockProfile) -> Sheet:
    """The impulses, and whether they need friction or a pull."""
    notes = []
    if any(foot.impulse is None for foot in profile.contacts) or any(
        foot.impulse is None for foot in profile.stance
    ):
        notes.append("the contact rows are redundant, so only the sum of the impulses is unique")
    sheet = contacts_sheet(profile)
    if len(sheet.rows) > 1:
        notes.append(
            f"total moment ({vector_text(profile.total_moment)}) N m s about the centre of mass of "
            f"the robot"
        )
    headings = {
        "contact": "",
        **_vector("impulse", "impulse {} [N s]"),
        "friction_needed": "",
        "what": "",
    }
    return view(sheet, "contacts (impulse of the ground on the robot, world axes)", headings, notes)


def extreme_directions(profile: ShockProfile, most: int | None) -> Sheet:
    """The same at the places of the largest shocks, at points and at the heaviest body.

    Args: most, number; None for all.
    """
    heaviest = profile.bodies[profile.main_body]
    still = {
        f"CoM of {name}"
        for name, moved in zip(profile.bodies, profile.moved, strict=True)
        if not moved
    }
    sheet = directions_sheet(profile).where(lambda row: row["place"] not in still)
    always = {f"CoM of {heaviest}", *(point.frame for point in profile.points)}
    return sheet.largest(
        most, "body", [math.inf if row[0] in always else float(row[1] or 0.0) for row in sheet.rows]
    )


def pointsview(profile: ShockProfile) -> Sheet:
    """The jumps and shocks; peak accelerations where the scene gives a pulse."""
    pulse, range_g = profile.scene.pulse, profile.scene.range_g
    of_pulse = "" if pulse is None else f"; peak acceleration for a pulse {pulse}"
    of_pulse += ", of the impulse model" if pulse and profile.stiffness is not None else ""
    headings = {
        "point": "",
        "body": "",
        **_vector("delta_v", "Δv {} [m/s]"),
        "shock": "",
        "peak_g": "",
    }
    headings |= (
        {"range_share": f"largest peak along an axis of {range_g:g} g [%]"}
        if range_g is not None
        else {}
    )
    notes = []
    if profile.stiffness is None:
        headings, notes = headings | READINGS, readings_notes(profile)
    return view(
        points_sheet(profile),
        f"sensors and points (Δv in the frame's axes{of_pulse})",
        headings,
        notes,
    )


def readings_text(profile: ShockProfile) -> str:
    """What the readings of accelerometers are, behind their filters; empty without one."""
    places, of_filter = profile.places("point"), dict[str, list[str]]()
    for place, one in zip(places, low_passes(profile.landing, places), strict=True):
        if one is not None:
            of_filter.setdefault(str(one), []).append(place.name)
    if not of_filter:
        return ""
    bound = ", at most, however stiff the contacts are, while the acceleration keeps its sign"
    at_most = "" if profile.stiffness is not None or profile.landing.pulse else bound
    each = "; ".join(f"{few(names, 4)}: {one}" for one, names in of_filter.items())
    return (
        f"behind a low-pass filter of {next(iter(of_filter))}"
        if len(of_filter) == 1
        else f"behind low-pass filters ({each})"
    ) + at_most


def readings_notes(profile: ShockProfile) -> list[str]:
    """The note of a table with readings of accelerometers, if it has any."""
    return [f"reading: the largest acceleration {text}"] if (text := readings_text(profile)) else []


def partsview(profile: ShockProfile) -> Sheet:
    """The margins, with where the critical values are from."""
    parts, bases = profile.parts, dict[str, list[str]]()
    for one in parts:
        bases.setdefault(basis_of(one) or "", []).append(one.part)
    notes = [
        f"critical values of {few(names, 6)}: {basis}" for basis, names in bases.items() if basis
    ]
    if profile.stiffness is not None and profile.scene.pulse is not None:
        notes.append("peaks and torques are those on the contact stiffness, whatever the pulse")
    if profile.impact_length is None and not all(one.joint for one in parts):
        notes.append(
            "margins by velocity change only, because a peak needs a pulse or a contact stiffness"
        )
    if profile.stiffness is None and any(one.torque is not None for one in parts):
        notes.append(_torque_note(profile).replace("of the torque limit", "torque"))
    keys = (
        "part",
        "speed_change",
        "critical_velocity_change",
        "velocity_margin",
        "peak_g",
        "filtered_peak",
        "critical_acceleration",
        "acceleration_margin",
        "along",
        "torque",
        "momentary_torque",
        "part_margin",
        "governed_by",
        "missing",
    )
    sheet = parts_sheet(profile)
    return view(
        sheet, sheet.title, dict.fromkeys(keys, "") | {"acceleration_margin": "by peak [-]"}, notes
    )


def _torque_note(profile: ShockProfile) -> str:
    """What the torque of a joint is, of which its share is."""
    if profile.landing.pulse is not None:
        return (
            f"of the torque limit: peak of a torque that has the pulse {profile.scene.pulse} and "
            f"the impulse along the axis"
        )
    return (
        "of the torque limit: impulse along the axis over the duration for which the joint "
        "withstands its torque, a mean"
    )


def posture(profile: ShockProfile) -> Sheet:
    """Where every joint of one coordinate stands."""
    sheet = joints_sheet(profile).where(
        lambda row: (row["position_deg"], row["position"]) != (None, None)
    )
    return view(sheet, "posture", {"joint": "", "position_deg": "", "position": ""})


def loads_sheet(profile: ShockProfile, most: int | None) -> Sheet:
    """Impulse through every joint, or through those with the largest force."""
    share = ["joint_torque_share"] * (profile.stiffness is None)
    sheet = joints_sheet(profile).only("joint", "joint_impulse", "joint_moment", "along", *share)
    if share and "joint_torque_share" in (column.key for column in sheet.columns):
        sheet = sheet._replace(notes=(*sheet.notes, _torque_note(profile)))
    return (
        sheet.largest(most, "joint", [float(row[1] or 0.0) for row in sheet.rows])
        .ranked("joint_impulse")
        .known()
    )


def joint_models(profile: ShockProfile, most: int | None = None) -> Sheet:
    """The same landing with free joints, as modelled and with locked joints, and its range over the
    drives.

    Args:
        profile: the landing.
        most: rows, of the first place, the trunk and the largest shocks; None for all.
    """
    model, headings = profile.landing.joint_model, {"shock_at": "", "shock_free": "joints free [-]"}
    if model.name != "free":
        known = any(source.status not in NOT_KNOWN for source in model.sources)
        headings["shock"] = "with drives [-]" if known else "as modelled [-]"
    headings |= {"shock_locked": "joints locked [-]"}
    named = {
        "free": "joints free",
        "locked": "joints locked",
        "springs_free": "locked, springs free",
    }
    # Without the remedy, which would be that of a scene with such joints.
    reasons = {
        model: text.removeprefix("no verdict: ").partition(";")[0]
        for model, text in profile.unsolved_joints.items()
    }
    notes = [f"–: no solution with {named[model]}: {reason}" for model, reason in reasons.items()]
    notes += [
        "free: no rotor, or each behind a soft spring; locked: gears and motors that do not yield; "
        "neither is a bound"
    ]
    if model.springs.any():
        headings["shock_springs_free"] = "locked, springs free [-]"
        notes += [
            "joints with springs yield in the impact, whatever their motors do, so the last column "
            "applies, not that before it"
        ]
    headings |= {"smallest_found": "smallest found [-]", "largest_found": "largest [-]"}
    sheet = view(shocks_sheet(profile), "effect of the joint model", headings, notes)
    always = {0, *(place.name for place in shown_places(profile))}
    shocks = profile.values(quantity("point", "shock"), profile.bracketed).tolist()
    sizes = [
        math.inf if k in always or place.name in always else shock
        for k, (place, shock) in enumerate(zip(profile.bracketed, shocks, strict=True))
    ]
    return sheet.largest(most, "point", sizes)


def each_contact(profile: ShockProfile) -> Sheet:
    """The table of contacts without their total."""
    sheet = contacts_sheet(profile)
    return sheet._replace(rows=sheet.rows[: len(profile.places("contact"))])


def friction_contacts(profile: ShockProfile) -> Sheet:
    """What friction changes at the contacts."""
    title = (
        f"contacts with friction {profile.scene.friction:g} (world axes; double precision, not "
        f"proven)"
    )
    headings = {
        "contact": "",
        **_vector("impulse_friction", "impulse {} [N s]"),
        **_vector("slip", ""),
        "state": "",
    }
    return view(each_contact(profile), title, headings)


def friction_shocks(profile: ShockProfile) -> Sheet:
    """What friction changes at the points."""
    headings = {
        "shock_at": "",
        "shock": "sticking [-]",
        "shock_friction": f"friction {profile.scene.friction or 0.0:g} [-]",
    }
    return view(shocks_sheet(profile), "effect of friction", headings)
