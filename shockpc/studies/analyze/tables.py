"""The tables of a landing: bodies, points, parts, contacts, directions and joints; friction and contacts of finite stiffness.

Every format has these, and a terminal those rows and columns of them that decide.
"""

import functools
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from shockpc.landing.places import Place, PlaceKind
from shockpc.landing.ratings import TorqueStrength
from shockpc.quantities.profile import ShockProfile
from shockpc.quantities.table import Selection, quantities_of, quantity
from shockpc.robot.robot import STOP
from shockpc.show.tables import Column, Row, Sheet
from shockpc.show.wording import BRACKETED, contact_name, count, mostly_off_plane, vector_text
from shockpc.text.printed import few

BODIES = {
    "delta_omega": "|Δω| [rad/s]",
    "copc": "CoPc {} [m]",
    "ropc": "RoPc [m]",
    "shock_com": "shock at CoM [-]",
    "shock_min": "least [-]",
    "shock_max": "greatest [-]",
    "off_plane": "out of plane [%]",
}
"""Headings of quantities of the table of bodies, as `_columns` takes them."""

JOINTS = {
    "joint_impulse": "force [N s]",
    "joint_moment": "moment [N m s]",
    "along": "along the axis [N m s, N s]",
    "joint_torque_share": "of the torque limit [-]",
    "peak_joint_force": "peak force [N]",
    "peak_joint_moment": "peak moment [N m]",
    "peak_torque": "peak along the axis [N m, N]",
}
"""Headings of those of joints that people read; the others are headed by their keys."""

PEAKS = {"peak_acceleration": "peak [g]", "peak_acceleration_time": "at [ms]"}
JUMPS = {"shock_compressed": "end of compression [-]", "shock_separated": "end of contact [-]", "shock": "impulse model [-]"}
"""Those of the tables of contacts of finite stiffness."""

OPTIONAL = (
    "joints", "parts", "joint_models", "directions", "friction_contacts", "friction_shocks", "stiffness_contacts",
    "stiffness_points", "stiffness_shocks", "modes", "posture",
)  # fmt: skip
"""Tables that not every landing has."""

OUT_OF_PLANE = 0.25
"""Share of a body's motion out of the plane above which a note says what its CoPc and RoPc describe."""

PARALLEL = math.radians(1.0)
"""Largest angle to the ground of an impact direction that is called parallel to it."""


def landing_tables(profile: ShockProfile, bodies: Sequence[int] | None = None) -> dict[str, Callable[[], Sheet]]:
    """All tables of a landing by name, each made when it is read.

    Args:
        profile: the result.
        bodies: indices of the only bodies that are shown.
    """
    friction, moving = profile.friction, any(block.kind != "stop" for block in profile.landing.contacts)
    rubbed = {"shock": "sticking [-]", "shock_friction": f"friction {profile.scene.friction or 0.0:g} [-]"}
    jointed, slides = bool(profile.robot.joint_names), friction is not None and friction.impact is not None
    makers: dict[str, tuple[Any, Callable[[ShockProfile], Sheet]]] = {
        "bodies": (True, functools.partial(bodies_sheet, bodies=bodies)),
        "points": (True, points_sheet),
        "parts": (profile.parts, parts_sheet),
        "contacts": (True, contacts_sheet),
        "joint_models": (jointed, joint_models_sheet),
        "directions": (moving, directions_sheet),
        "joints": (jointed, joints_sheet),
        "friction_contacts": (slides, friction_contacts_sheet),
        "friction_shocks": (slides, lambda profile: Sheet.of("effect of friction", _shocks_at(profile, rubbed))),
        "stiffness_contacts": (profile.stiffness, stiffness_contacts_sheet),
        "stiffness_points": (
            profile.stiffness and profile.points,
            lambda profile: Sheet.of("peak accelerations on these contacts", _at(profile, "point", PEAKS)),
        ),
        "stiffness_shocks": (
            profile.stiffness,
            lambda profile: Sheet.of("velocity jumps on these contacts", _shocks_at(profile, JUMPS)),
        ),
        "modes": (profile.stiffness, modes_sheet),
        "posture": (jointed, posture_sheet),
    }
    return {name: functools.partial(make, profile) for name, (there, make) in makers.items() if there}


def shown_tables(profile: ShockProfile, bodies: Sequence[int] | None, most: int | None) -> dict[str, Callable[[], Sheet]]:
    """The tables with the columns and rows that people read. Args: bodies, as above; most, rows of long tables, None for all."""
    tables = landing_tables(profile, bodies)
    views: dict[str, Callable[[], Sheet]] = {}
    views |= {name: functools.partial(lambda make: make().known(), make) for name, make in tables.items()}
    views["bodies"] = functools.partial(moved_bodies, profile, bodies)
    for name, view in (("directions", extreme_directions), ("joints", loads_sheet)):
        if name in tables:
            views[name] = functools.partial(view, profile, most)
    if "modes" in tables:
        views["modes"] = lambda: modes_sheet(profile).largest(most, "mode")
    if not profile.points:
        del views["points"]
    if profile.stiffness is not None and "joints" in tables:
        views["peaks"] = functools.partial(peaks_sheet, profile, most)
        views["posture"] = views.pop("posture")
    return views


def _columns(
    profile: ShockProfile, kind: PlaceKind, headed: Mapping[str, str], places: Sequence[Place] | None = None
) -> dict[Any, Any]:
    """Columns of quantities by their headings; of a vector three where the heading has {} for x, y and z, else the length."""
    columns: dict[Any, Any] = {}
    for key, head in headed.items():
        entry = quantity(kind, key)
        values = profile.values(entry, places)
        parts = dict(zip("xyz", values.T, strict=True)) if "{}" in head else {"": Selection(key, entry).scalar(values)}
        for axis, part in parts.items():
            _, title, unit = Column.of(head.format(axis))
            columns[Column(f"{key}_{axis}".removesuffix("_"), title, unit)] = part
    return columns


def bodies_sheet(profile: ShockProfile, bodies: Sequence[int] | None = None) -> Sheet:
    """One row for each body; a word says why a CoPc is missing, or describes little of the motion.

    Args:
        profile: the result.
        bodies: indices of the only bodies that are shown.
    """
    named = {"contact": [contact_name(profile)] * len(profile.bodies), "body": profile.bodies}
    motion = [_motion(profile, i) for i in range(len(profile.bodies))]
    title = "bodies (CoPc in body coordinates; shock relative to the strike)"
    sheet = Sheet.of(title, {**named, **_columns(profile, "body", BODIES), "motion": motion})
    return sheet if bodies is None else sheet._replace(rows=[sheet.rows[i] for i in bodies])


def _motion(profile: ShockProfile, i: int) -> str | None:
    """What is to be known of the motion of a body before its CoPc and RoPc are read; None if it rotates in the plane."""
    if profile.translates[i]:
        return "translates" if math.isnan(profile.pitch[i]) else "out of plane"
    return "mostly out of plane" if mostly_off_plane(profile)[i] else None


def moved_bodies(profile: ShockProfile, bodies: Sequence[int] | None = None) -> Sheet:
    """The bodies that the impact moves, with what is to be known of them."""
    matching = range(len(profile.bodies)) if bodies is None else bodies
    shown = [i for i in matching if profile.moved[i]]
    notes = []
    if any(profile.off_plane[i] > OUT_OF_PLANE for i in shown):
        notes.append(
            f"out of plane above {100.0 * OUT_OF_PLANE:.0f} %: CoPc and RoPc describe only the part of that body's motion that "
            f"lies in the plane; mostly: above {100.0 * BRACKETED:.0f} %; the shock is that of the whole motion"
        )
    if names := [profile.bodies[i] for i in shown if math.isnan(profile.shock_max[i])]:
        notes.append(f"–: no geometry over which to take the shock: {few(names, 4)}")
    if still := [profile.bodies[i] for i in matching if i not in shown]:
        notes.append(f"{count(len(still), 'body')} not shown, not moved by the impact: {few(still, 6)}")
    if hidden := len(profile.bodies) - len(matching):
        notes.append(f"{count(hidden, 'body')} not shown, no match for --body")
    sheet = bodies_sheet(profile, shown).without("contact")
    return sheet._replace(notes=notes) if any(row[-1] for row in sheet.rows) else sheet.without("motion")._replace(notes=notes)


def worst_bodies(profile: ShockProfile, most: int | None, bodies: Sequence[int] | None = None) -> Sheet:
    """The bodies of the largest shocks, those first, and the heaviest. Args: most, their number; None for all."""
    whole, heaviest = moved_bodies(profile, bodies), profile.bodies[int(profile.robot.masses.argmax())]
    notes = [note for note in whole.notes if not note.startswith("out of plane")]  # as the column `motion` says
    sheet = whole.only("body", "shock_com", "shock_max", "ropc", "copc_x", "copc_y", "copc_z", "motion")._replace(notes=notes)
    sizes = [math.inf if row[0] == heaviest else float(row[1] or 0.0) for row in sheet.rows]
    return sheet.largest(most, "body", sizes).ranked("shock_com")


def contacts_sheet(profile: ShockProfile) -> Sheet:
    """One row for each contact and each stance foot, and their sum where there are several."""
    rows: list[Row] = []
    notes = []
    named = [(contact.frame, contact) for contact in profile.contacts]
    for name, contact in named + [(f"{foot.frame} (stance)", foot) for foot in profile.stance]:
        if contact.impulse is None:
            rows.append((name, None, None, None, None, "not unique"))
            notes = ["the contact rows are redundant, so only the sum of the impulses is unique"]
        else:
            stop, needed = name.startswith(STOP) and name not in profile.robot.frames, contact.friction_needed
            rows.append((name, *contact.impulse, needed, "end stop" if stop else "tensile" if needed is None else None))
    if len(rows) > 1:
        rows.append(("total", *profile.total_impulse, None, None))
        notes.append(f"total moment ({vector_text(profile.total_moment)}) N m s about the centre of mass of the robot")
    header = ("contact", "impulse x [N s]", "impulse y [N s]", "impulse z [N s]", "friction to stick [-]", "what")
    return Sheet("contacts (impulse of the ground on the robot, world axes)", header, rows, notes)


def directions_sheet(profile: ShockProfile) -> Sheet:
    """The impact directions with the greatest and the least shock at each place that moves, at the same speed."""
    found = profile.directions
    rows = [(f"CoM of {profile.bodies[i]}", *(part[i] for part in found)) for i in np.flatnonzero(profile.moved).tolist()]
    rows += [(point.frame, *point.directions) for point in profile.points]
    header = (
        "place", "most severe [-]", "most x [-]", "most y [-]", "most z [-]",
        "least severe [-]", "least x [-]", "least y [-]", "least z [-]", "to the ground",
    )  # fmt: skip
    cells: list[Row] = []
    for place, most, most_shock, least, least_shock in rows:
        way = "parallel" if abs(least @ profile.landing.up) < PARALLEL else "towards"
        cells.append((place, most_shock, *most, least_shock, *least, way))
    title = "most and least severe impact direction (unit vector of the velocity, world axes)"
    note = "over all directions towards the ground or parallel to it; an impact parallel to the ground is no landing"
    return Sheet(title, header, cells, [note])


def extreme_directions(profile: ShockProfile, most: int | None) -> Sheet:
    """The same at the places of the largest shocks, at points and at the heaviest body. Args: most, number; None for all."""
    sheet, heaviest = directions_sheet(profile), profile.bodies[int(profile.robot.masses.argmax())]
    always = {f"CoM of {heaviest}", *(point.frame for point in profile.points)}
    return sheet.largest(most, "body", [math.inf if row[0] in always else float(row[1] or 0.0) for row in sheet.rows])


def points_sheet(profile: ShockProfile) -> Sheet:
    """One row for each sensor and each requested point; peak accelerations where the scene gives a pulse."""
    pulse, range_g = profile.scene.pulse, profile.scene.range_g
    named = {"point": [point.frame for point in profile.points], "on body": [point.body for point in profile.points]}
    headed = {"delta_v": "Δv {} [m/s]", "shock": "shock [-]"} | ({"peak_g": "peak [g]"} if pulse else {})
    headed |= {"range_share": f"largest peak along an axis of {range_g:g} g [%]"} if range_g is not None else {}
    of_pulse = "" if pulse is None else f"; peak acceleration for a pulse {pulse}"
    of_pulse += ", of the impulse model" if pulse and profile.stiffness is not None else ""
    return Sheet.of(f"sensors and points (Δv in the frame's axes{of_pulse})", {**named, **_columns(profile, "point", headed)})


def parts_sheet(profile: ShockProfile) -> Sheet:
    """One row for each part: margins by velocity change and acceleration, or by torque, and which counts or what is missing."""
    rows: list[Row] = []
    bases: dict[str, list[str]] = {}
    for one in profile.parts:
        bound: Row
        if isinstance(one.strength, TorqueStrength):
            bound = (None,) * 6 + (None if one.along is None else abs(one.along), one.torque, one.strength.momentary_torque)
            basis = "the torque given" if one.strength.given else "the effort limit of the robot's file"
            bases.setdefault("" if math.isnan(one.strength.momentary_torque) else basis, []).append(one.part)
        else:
            bound = (one.speed_change, one.strength.velocity_change, one.velocity_margin)
            bound += (one.peak_g, one.strength.acceleration, one.acceleration_margin, None, None, None)
            bases.setdefault(one.strength.basis, []).append(one.part)
        rows.append((one.part, *bound, one.part_margin, one.governed_by or one.missing or None))
    of_joints = [isinstance(one.strength, TorqueStrength) for one in profile.parts]
    notes = [f"critical values of {few(names, 6)}: {basis}" for basis, names in bases.items() if basis]
    if profile.stiffness is not None and profile.scene.pulse is not None:
        notes.append("peaks and torques are those on the contact stiffness, whatever the pulse")
    if profile.impact_length is None and not all(of_joints):
        notes.append("margins by velocity change alone, because a peak needs a pulse or a contact stiffness")
    if profile.stiffness is None and any(one.torque is not None for one in profile.parts):
        notes.append(_torque_note(profile).replace("of the torque limit", "torque"))
    header = (
        "part", "|Δv| [m/s]", "critical [m/s]", "margin [-]", "peak [g]", "critical peak [g]", "margin by peak [-]",
        "impulse along the axis [N m s, N s]", "torque [N m, N]", "withstands [N m, N]", "governing [-]", "by",
    )  # fmt: skip
    return Sheet("parts (margin: factor on the speed of the strike below which the part survives)", header, rows, notes)


def _torque_note(profile: ShockProfile) -> str:
    """What the torque of a joint is, of which its share is."""
    if profile.landing.pulse is not None:
        return f"of the torque limit: peak of a torque that has the pulse {profile.scene.pulse} and the impulse along the axis"
    return "of the torque limit: impulse along the axis over the duration for which the joint withstands its torque, a mean"


def posture_sheet(profile: ShockProfile) -> Sheet:
    """Where every joint of one coordinate stands, as `--set` takes it."""
    joints = [joint for joint in profile.robot.single_joints if joint.axis is not None]
    values = [(joint.value(profile.q), joint.kind == "prismatic") for joint in joints]
    angles, distances = (
        [None if slides else math.degrees(x) for x, slides in values],
        [x if slides else None for x, slides in values],
    )
    return Sheet.of("posture", {"joint": [joint.name for joint in joints], "position [deg]": angles, "position [m]": distances})


def joints_sheet(profile: ShockProfile) -> Sheet:
    """Every quantity of the joints that this landing has, a row for each joint."""
    places, notes = profile.places("joint"), list[str]()
    columns: dict[Any, Iterable[Any]] = {"contact": [contact_name(profile)] * len(places), "joint": [one.name for one in places]}
    for key in dict.fromkeys([*JOINTS, *(entry.key for entry in quantities_of("joint"))]):
        entry = quantity("joint", key)
        values = profile.values(entry, places)
        if values.ndim == 1 and not np.isnan(values).all():  # the sizes of vectors are quantities too
            title, _, unit = JOINTS.get(key, f"{key} [{entry.unit.replace('1', '-')}]").partition(" [")
            columns[Column(key, title, unit.removesuffix("]"))] = values
    if profile.health.rank < profile.health.rows:
        notes.append("contact or closure rows are redundant: these are the joint loads of least norm")
    if profile.stiffness is None and not np.isnan(profile.value("joint_torque_share", "joint")).all():
        notes.append(_torque_note(profile))
    return Sheet.of("impulse through the joints", columns, notes)


def loads_sheet(profile: ShockProfile, most: int | None) -> Sheet:
    """Impulse through every joint, or through those with the greatest force."""
    share = ["joint_torque_share"] * (profile.stiffness is None)
    sheet = joints_sheet(profile).only("joint", "joint_impulse", "joint_moment", "along", *share)
    return sheet.largest(most, "joint", [float(row[1] or 0.0) for row in sheet.rows]).ranked("joint_impulse")


def peaks_sheet(profile: ShockProfile, most: int | None) -> Sheet:
    """Peaks through every joint on contacts of finite stiffness, or through those with the greatest torque, or else force."""
    keys = ("peak_joint_force", "peak_joint_moment", "peak_torque")
    sheet = joints_sheet(profile).only("joint", *keys, "joint_torque_share")._replace(title="peaks through the joints", notes=())
    force, torque = profile.value("peak_joint_force", "joint"), profile.value("peak_torque", "joint")
    return sheet.largest(most, "joint", np.where(torque > 0.0, 1e6 * torque, force).tolist())


def _shocks_at(profile: ShockProfile, headed: Mapping[str, str]) -> dict[Any, Iterable[Any]]:
    """Columns of shocks at the heaviest body's centre of mass, sensors and points. Args: headed, as in `_columns`."""
    places = profile.bracketed
    names = [f"CoM of {place.name}" if place.centre else place.name for place in places]
    return {"shock at": names, **_columns(profile, "point", headed, places)}


def joint_models_sheet(profile: ShockProfile) -> Sheet:
    """The same landing with free joints, with the joints as modelled, and with locked joints."""
    headed = {"shock_free": "joints free [-]", "shock": "as modelled [-]", "shock_locked": "joints locked [-]"}
    named = {"free": "joints free", "locked": "joints locked", "springs_free": "locked, springs free"}
    # Without the remedy, which would be that of a scene with such joints.
    reasons = {model: text.removeprefix("no verdict: ").partition(";")[0] for model, text in profile.unsolved_joints.items()}
    notes = [f"–: no solution with {named[model]}: {reason}" for model, reason in reasons.items()]
    notes += ["free: no rotor, or each behind a soft spring; locked: gears and motors that do not yield during the impact"]
    if profile.landing.joint_model.springs.any():
        headed["shock_springs_free"] = "locked, springs free [-]"
        notes += [
            "joints with springs yield in the impact, whatever their motors do, so the last column counts, not that before it"
        ]
    return Sheet.of("effect of the joint model", _shocks_at(profile, headed), notes)


def _at(profile: ShockProfile, kind: PlaceKind, headed: Mapping[str, str]) -> dict[Any, Iterable[Any]]:
    """Columns of quantities at all places of a kind. Args: headed, as in `_columns`."""
    return {kind: [place.name for place in profile.places(kind)], **_columns(profile, kind, headed)}


def friction_contacts_sheet(profile: ShockProfile) -> Sheet:
    """What friction changes at the contacts."""
    assert profile.friction is not None
    columns = _at(profile, "contact", {"impulse_friction": "impulse {} [N s]", "slip": "velocity after {} [m/s]"})
    title = f"contacts with friction {profile.scene.friction:g} (world axes; double precision, not proven)"
    return Sheet.of(title, {**columns, "state": profile.friction.state})


def stiffness_contacts_sheet(profile: ShockProfile) -> Sheet:
    """Forces on contacts of finite stiffness, and their times."""
    forces = {"duration": "99 % of the impulse in [ms]", "peak_force": "peak force [N]", "peak_force_time": "at [ms]"}
    title = f"contacts of {stiffness_text(profile)} (frozen geometry{_forces(profile)}; double precision, not proven)"
    return Sheet.of(title, _at(profile, "contact", forces))


def modes_sheet(profile: ShockProfile) -> Sheet:
    """The modes of a landing on contacts of finite stiffness."""
    assert profile.stiffness is not None
    frequency, energy, *_ = profile.stiffness.motion.modes
    carried: dict[Any, Iterable[Any]] = {"frequency [Hz]": frequency, "kinetic energy before [J]": energy}
    for place, share in zip(profile.places("contact"), profile.stiffness.force_shares, strict=False):
        carried[f"of the force of {place.name} [%]"] = share
    return Sheet.of("modes, and the normal force that they carry", carried)


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
