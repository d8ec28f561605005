"""Views of the tables of a landing: rows and columns that decide, under headings of their own."""

import math
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from shockpc.judgement.unknowns import NOT_KNOWN
from shockpc.landing.bandwidths import scene_low_pass
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.show.tables import Sheet
from shockpc.show.wording import BRACKETED, vector_text
from shockpc.studies.analyze.first_lines import shown_places, sliding_friction
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
from shockpc.studies.analyze.view import Keys, View, kept
from shockpc.text.printed import count, few
from shockpc.text.wings import from_wings

READINGS = {"filtered_peak": "", "filtered_peak_axes": ""}
"""Columns of what accelerometers read."""

OUT_OF_PLANE = 0.25
"""Share of a body's motion out of the plane above which a note explains its CoPc and RoPc."""


def shown_tables(
    profile: ShockProfile,
    bodies: Sequence[int] | None = None,
    most: int | None = None,
    brief: bool = False,
) -> dict[str, Callable[[], Sheet]]:
    """The tables that people read of a landing, by name.

    Args:
        profile: the landing.
        bodies: indices of the only bodies that are shown; None for all.
        most: rows of long tables; None for all.
        brief: whether only those of the answer are wanted.
    """
    tables: dict[str, Callable[[], Sheet]] = {}
    if not brief:
        tables["bodies"] = partial(moved_bodies, profile, bodies)
    views = dict(VIEWS)
    for views_of in from_wings("report", "views"):
        views |= views_of(profile)
    views["posture"] = POSTURE
    for name, view in views.items():
        if view.condition(profile) and (view.brief or not brief):
            tables[name] = partial(view.of, profile, most)
    return tables


def moved_bodies(profile: ShockProfile, bodies: Sequence[int] | None = None) -> Sheet:
    """The bodies that the impact moves, with what is to be known of them."""
    matching = range(len(profile.bodies)) if bodies is None else bodies
    shown = [i for i in matching if profile.moved[i]]
    still = [profile.bodies[i] for i in matching if not profile.moved[i]]
    shapeless = [profile.bodies[i] for i in shown if math.isnan(profile.shock_max[i])]
    hidden = len(profile.bodies) - len(matching)
    notes = []
    if any(profile.out_of_plane_share[i] > OUT_OF_PLANE for i in shown):
        notes.append(
            f"out of plane above {100.0 * OUT_OF_PLANE:.0f} %: CoPc and RoPc describe only the "
            f"body's motion in the plane, "
            f"the shock its whole motion; mostly: above {100.0 * BRACKETED:.0f} %"
        )
    if shapeless:
        notes.append(
            f"no geometry over which to take the minimum and maximum shock: {few(shapeless, 4)}"
        )
    if still:
        notes.append(
            f"{count(len(still), 'body')} not shown, not moved by the impact: {few(still, 6)}"
        )
    if hidden:
        notes.append(f"{count(hidden, 'body')} not shown, no match for --body")
    sheet = bodies_sheet(profile, shown).only(
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
        "motion",
    )
    sheet = sheet._replace(notes=notes)
    moves = any(row[-1] for row in sheet.rows)
    return sheet if moves else sheet.without("motion")


def worst_bodies(
    profile: ShockProfile, most: int | None, bodies: Sequence[int] | None = None
) -> Sheet:
    """The bodies of the largest shocks, those first, and the heaviest.

    Args: most, their number; None for all.
    """
    moved = moved_bodies(profile, bodies)
    heaviest = profile.bodies[profile.main_body]
    # as the column `motion` says
    notes = [note for note in moved.notes if not note.startswith("out of plane")]
    sheet = moved._replace(notes=notes).only(
        "body", "shock_com", "shock_max", "ropc", "copc_x", "copc_y", "copc_z", "motion"
    )
    sizes = _sizes(sheet, {heaviest})
    return sheet.largest(most, "body", sizes).ranked("shock_com")


def _sizes(sheet: Sheet, always: set[str]) -> list[float]:
    """The number in the second column of each row; infinity of rows that are always shown."""
    sizes = []
    for name, number, *_ in sheet.rows:
        sizes.append(math.inf if name in always else float(number or 0.0))
    return sizes


def has_joints(profile: ShockProfile) -> bool:
    """True if the robot has joints."""
    return bool(profile.robot.joint_names)


def has_points(profile: ShockProfile) -> bool:
    """True if the landing has sensors or points."""
    return bool(profile.points)


def _slides(profile: ShockProfile) -> bool:
    return sliding_friction(profile) is not None


def _yields(profile: ShockProfile) -> bool:
    return profile.stiffness is not None


def _point_keys(profile: ShockProfile) -> Keys:
    """Jumps and shocks; peak accelerations where the scene gives a pulse."""
    keys = {"point": "", "body": "", "delta_v": "Δv {} [m/s]", "shock": "", "peak_g": ""}
    range_g = profile.scene.range_g
    if range_g is not None:
        keys["range_share"] = f"largest peak along an axis of {range_g:g} g [%]"
    return keys if _yields(profile) else keys | READINGS


def _points_title(profile: ShockProfile) -> str:
    pulse = profile.scene.pulse
    peak = "" if pulse is None else f"; peak acceleration for a pulse {pulse}"
    if pulse is not None and _yields(profile):
        peak += ", of the impulse model"
    return f"sensors and points (Δv in the frame's axes{peak})"


def _point_notes(profile: ShockProfile) -> list[str]:
    return [] if _yields(profile) else readings_notes(profile)


def readings_text(profile: ShockProfile) -> str:
    """The readings of accelerometers behind their filters, in words; empty without one."""
    low_pass = scene_low_pass(profile.scene)
    if low_pass is None:
        return ""
    text = f"behind a low-pass filter of {low_pass}"
    if _yields(profile) or profile.landing.pulse:
        return text
    return f"{text}, at most, however stiff the contacts are, while the acceleration keeps its sign"


def readings_notes(profile: ShockProfile) -> list[str]:
    """Notes that explain the readings of accelerometers."""
    text = readings_text(profile)
    return [f"reading: the largest acceleration {text}"] if text else []


def _part_notes(profile: ShockProfile) -> list[str]:
    """Notes on the source of critical values, and on the peaks and torques the margins are by."""
    parts = profile.parts
    bases: dict[str, list[str]] = {}
    for part in parts:
        basis = basis_of(part)
        if basis:
            bases.setdefault(basis, []).append(part.part)
    notes = [f"critical values of {few(names, 6)}: {basis}" for basis, names in bases.items()]
    if _yields(profile) and profile.scene.pulse is not None:
        notes.append("peaks and torques are those on the contact stiffness, whatever the pulse")
    if profile.impact_length is None and not all(part.joint for part in parts):
        notes.append(
            "margins by velocity change only, because a peak needs a pulse or a contact stiffness"
        )
    if not _yields(profile) and any(part.torque is not None for part in parts):
        notes.append(_torque_note(profile).replace("of the torque limit", "torque"))
    return notes


def _torque_note(profile: ShockProfile) -> str:
    """A note that explains the torque of a joint, of which its share is."""
    if profile.landing.pulse is not None:
        return (
            f"of the torque limit: peak of a torque that has the pulse {profile.scene.pulse} and "
            f"the impulse along the axis"
        )
    return (
        "of the torque limit: impulse along the axis over the duration for which the joint "
        "withstands its torque, a mean"
    )


def _contact_notes(profile: ShockProfile) -> list[str]:
    """Notes on whether impulses are unique, and on their total moment."""
    notes = []
    impulses = [contact.impulse for contact in profile.contacts]
    impulses += [foot.impulse for foot in profile.stance]
    if any(impulse is None for impulse in impulses):
        notes.append("the contact rows are redundant, so only the sum of the impulses is unique")
    if len(profile.places("contact")) > 1:
        notes.append(
            f"total moment ({vector_text(profile.total_moment)}) N m s about the centre of mass of "
            f"the robot"
        )
    return notes


def each_contact(profile: ShockProfile) -> Sheet:
    """The table of contacts without their total."""
    sheet = contacts_sheet(profile)
    return sheet._replace(rows=sheet.rows[: len(profile.places("contact"))])


def _joint_model_keys(profile: ShockProfile) -> Keys:
    """Free joints, those of the scene, locked ones and springs, and the range over the drives."""
    model = profile.landing.joint_model
    keys = {"shock_at": "", "shock_free": "joints free [-]"}
    if model.name != "free":
        known = any(source.status not in NOT_KNOWN for source in model.sources)
        keys["shock"] = "with drives [-]" if known else "as modelled [-]"
    keys["shock_locked"] = "joints locked [-]"
    if model.springs.any():
        keys["shock_springs_free"] = "locked, springs free [-]"
    return keys | {"smallest_found": "smallest found [-]", "largest_found": "largest [-]"}


def _joint_model_notes(profile: ShockProfile) -> list[str]:
    names = {
        "free": "joints free",
        "locked": "joints locked",
        "springs_free": "locked, springs free",
    }
    notes = []
    for model, text in profile.unsolved_joints.items():
        # Without the remedy, which would be that of a scene with such joints.
        reason = text.removeprefix("no verdict: ").partition(";")[0]
        notes.append(f"–: no solution with {names[model]}: {reason}")
    notes.append(
        "free: no rotor, or each behind a soft spring; locked: no joint moves. Neither is a bound"
    )
    if profile.landing.joint_model.springs.any():
        notes.append(
            "joints with springs yield in the impact, whatever their motors do, so the last "
            "column applies, not the one before"
        )
    return notes


def _joint_model_sizes(profile: ShockProfile, _: Sheet) -> list[float]:
    """Shocks, of which those of the first lines and of the heaviest body are always shown."""
    always = {place.name for place in shown_places(profile)}
    shocks = profile.value("shock", "point", profile.bracketed).tolist()
    sizes = [math.inf]
    for place, shock in zip(profile.bracketed[1:], shocks[1:], strict=True):
        sizes.append(math.inf if place.name in always else shock)
    return sizes


def _has_directions(profile: ShockProfile) -> bool:
    return any(contact.kind != "stop" for contact in profile.landing.contacts)


def _directions_of_moved(profile: ShockProfile) -> Sheet:
    """The table of directions without bodies that the impact does not move."""
    still = set()
    for name, moved in zip(profile.bodies, profile.moved, strict=True):
        if not moved:
            still.add(f"CoM of {name}")
    return directions_sheet(profile).where(lambda row: row["place"] not in still)


def _direction_sizes(profile: ShockProfile, sheet: Sheet) -> list[float]:
    """Shocks, of which those of the heaviest body and of points are always shown."""
    heaviest = profile.bodies[profile.main_body]
    return _sizes(sheet, {f"CoM of {heaviest}", *(point.frame for point in profile.points)})


def _load_keys(profile: ShockProfile) -> Keys:
    keys = kept("joint", "joint_impulse", "joint_moment", "along")
    return keys if _yields(profile) else keys | kept("joint_torque_share")


def _load_notes(profile: ShockProfile) -> list[str]:
    known = np.isfinite(profile.value("joint_torque_share", "joint")).any()
    return [_torque_note(profile)] if known and not _yields(profile) else []


def _load_sizes(_: ShockProfile, sheet: Sheet) -> list[float]:
    return _sizes(sheet, set())


def each_joint(profile: ShockProfile) -> Sheet:
    """The table of joints without notes, which are on the impulses."""
    return joints_sheet(profile)._replace(notes=())


def _joints_with_position(profile: ShockProfile) -> Sheet:
    """The table of joints without those of several coordinates."""
    return each_joint(profile).where(
        lambda row: (row["position_deg"], row["position"]) != (None, None)
    )


def _friction_title(profile: ShockProfile) -> str:
    return f"contacts with friction {profile.scene.friction:g} (world axes; double precision)"


def _friction_shock_keys(profile: ShockProfile) -> Keys:
    friction = profile.scene.friction or 0.0
    return {
        "shock_at": "",
        "shock": "sticking [-]",
        "shock_friction": f"friction {friction:g} [-]",
    }


VIEWS: dict[str, View] = {
    "points": View(points_sheet, has_points, _point_keys, _points_title, _point_notes, brief=True),
    "parts": View(
        parts_sheet,
        lambda profile: profile.parts,
        {
            **kept("part", "speed_change", "critical_velocity_change", "velocity_margin"),
            **kept("peak_g", "filtered_peak", "critical_acceleration"),
            "acceleration_margin": "by peak [-]",
            **kept("along", "torque", "momentary_torque", "part_margin", "governed_by", "missing"),
        },
        notes=_part_notes,
        brief=True,
    ),
    "contacts": View(
        contacts_sheet,
        lambda _: True,
        {"contact": "", "impulse": "impulse {} [N s]", "friction_needed": "", "what": ""},
        "contacts (impulse of the ground on the robot, world axes)",
        _contact_notes,
    ),
    "joint_models": View(
        shocks_sheet,
        has_joints,
        _joint_model_keys,
        "effect of the joint model",
        _joint_model_notes,
        _joint_model_sizes,
        "point",
        brief=True,
    ),
    "directions": View(
        _directions_of_moved, _has_directions, None, sizes=_direction_sizes, row="body"
    ),
    "joints": View(
        joints_sheet,
        has_joints,
        _load_keys,
        notes=_load_notes,
        sizes=_load_sizes,
        row="joint",
        ranked="joint_impulse",
        brief=True,
    ),
    "friction_contacts": View(
        each_contact,
        _slides,
        {"contact": "", "impulse_friction": "impulse {} [N s]", "slip": "", "state": ""},
        _friction_title,
        brief=True,
    ),
    "friction_shocks": View(
        shocks_sheet, _slides, _friction_shock_keys, "effect of friction", brief=True
    ),
}
"""The views of a landing by name, in the order of reading.

Before them is that of the bodies, after them those of wings and that of the posture.
"""

POSTURE = View(
    _joints_with_position, has_joints, kept("joint", "position_deg", "position"), "posture"
)
"""The position of every joint of one coordinate."""
