"""The results of landings: the lines of each with its tables, and their shocks side by side where
there are several.
"""

import math
import textwrap
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np

from shockpc.landing.end_stops import side_of
from shockpc.landing.ratings import Strength
from shockpc.method.constraints import ConstraintBlock
from shockpc.quantities.ranges import sensor_peaks
from shockpc.quantities.records import ContactImpulse
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.robot.robot import STOP
from shockpc.show.header import (
    common_lines,
    contacts_text,
    other_warnings,
    scene_lines,
    shared_warnings,
    unknown_lines,
    warning_lines,
)
from shockpc.show.report import Picture, Report, Section
from shockpc.show.tables import WIDTH, Column, Lines, Row, Sheet, rounded
from shockpc.show.wording import contact_name, count, proof_text, robot_name, shown_as
from shockpc.studies.analyze.first_lines import (
    friction_text,
    margin_line,
    mass_text,
    shock_line,
    sliding_friction,
)
from shockpc.studies.analyze.landing_document import content
from shockpc.studies.analyze.several import Reports, landings_sheet, landings_view, worst_text
from shockpc.studies.analyze.sheets import landing_tables
from shockpc.studies.analyze.views import readings_text, shown_tables, worst_bodies
from shockpc.text.diagnostic import alike
from shockpc.text.errors import ShockError
from shockpc.text.printed import cause_lines, causes, few
from shockpc.text.wings import doors

WORST, JOINTS = 6, 3
"""Bodies, the heaviest among them unless they are asked for by name, and joints in the tables of an
answer.
"""

USUAL = {"posture": "standing", "base": "falls freely", "plane": "xz"}
"""Beginnings of lines of the header that say what is so unless options say otherwise."""

MORE = "--all prints everything that was computed"
"""The last line of an answer."""

CLEAN = ("warnings", "no warnings")
"""The line of a summary without warnings; of several landings one line says it of all."""

WARNING = 160
"""Characters of the first warning in a summary; whole warnings follow it."""

NO_MITIGATION = (
    "no impact mitigation factor (it requires a free base, no stance, and no loop that ties the "
    "robot to the world)"
)


def landing_report(
    profile: ShockProfile,
    bodies: Sequence[int] | None = None,
    spectrum: bool = False,
    whole: bool = False,
    remarks: Sequence[tuple[str, str]] = (),
    live: Sequence[str] = (),
) -> Report:
    """Everything of one landing; of the bodies only those that are given by their indices, save in
    the document.

    The files are profile.json, a CSV file of each table, report.md, shock.svg and shock.png; with
    parts also damage_boundary.svg, with a contact stiffness time.svg, and on request spectrum.svg,
    the shock response spectrum, which then is in profile.json too. On a terminal only the answer is
    shown, or with `whole` all tables.
    """
    return Report(
        name="profile",
        title=f"Shock of {robot_name(profile.robot)} landing on {contact_name(profile)}",
        body=lambda full: [
            Lines([*_summary(profile), *remarks]),
            Lines(scene_lines(profile)),
            Picture(
                "shock",
                f"shock profile of {robot_name(profile.robot)}",
                "show.figure.plane:draw_landing",
                (profile,),
            ),
            *(make() for make in shown_tables(profile, bodies, None if full else 6).values()),
            *_damage_picture([profile]),
            *(picture for door in doors("report") for picture in door.pictures(profile, spectrum)),
        ],
        width=WIDTH,
        brief=None if whole else lambda: _answer(profile, bodies, remarks),
        closing=[
            *_balance_lines(profile),
            *_stop_lines(profile),
            *_friction_lines(profile),
            *_wing_lines(profile),
            f"contact rows: {profile.health.rank} of {profile.health.rows} independent",
            accuracy_line(profile),
        ],
        warnings=warning_lines(profile),
        sheets=landing_tables(profile, bodies),
        document=lambda: content(profile, spectrum),
        tables=True,
        landings={contact_name(profile): profile},
        live=live,
    )


def document(profile: ShockProfile, spectrum: bool = False) -> dict[str, Any]:
    """The JSON document of one landing.

    Args: profile; spectrum, whether it has the shock response spectra of the points.
    """
    found: dict[str, Any] = landing_report(profile, spectrum=spectrum).json()
    return found


def analyze_report(
    landings: Mapping[str, ShockProfile],
    bodies: Sequence[int] | None = None,
    spectrum: bool = False,
    whole: bool = False,
    failures: Mapping[str, ShockError] = MappingProxyType({}),
    remarks: Sequence[tuple[str, str]] = (),
    live: Sequence[str] = (),
) -> Report:
    """The report of one landing, or of several with their shocks side by side.

    Args:
        landings: by the names of their folders.
        bodies: indices of the only bodies that are shown.
        spectrum: whether to draw the shock response spectrum of the points.
        whole: whether a terminal shows all tables of each.
        failures: why others could not be computed, by name.
        remarks: what landings on whole feet and on all level feet give, each with its heading.
        live: names or globs of joints that have sliders in report.html; of one landing those that
            carry the contact always have.
    """
    parts = Reports(
        landings, lambda profile: landing_report(profile, bodies, spectrum, whole, remarks, live)
    )
    if len(parts) == 1 and not failures:
        return next(iter(parts.values()))
    profiles, reasons = (
        list(landings.values()),
        [(name, str(reason)) for name, reason in failures.items()],
    )
    sheets = {
        "summary": lambda: _side_by_side(profiles, bodies),
        "landings": lambda: landings_sheet(landings),
    }

    def answers() -> list[Section]:
        head = [*_several_lines(landings), *landing_lines(common_lines(landings))]
        head += [("contact", contacts_text(profiles)), *_warning_count(profiles)]
        asked = [sheets["summary"]()] if bodies else []
        head += remarks
        return [
            Lines(head),
            landings_view(landings),
            *asked,
            Lines([MORE]),
            Lines(shared_warnings(landings)),
        ]

    return Report(
        name="summary",
        width=WIDTH,
        brief=None if whole else answers,
        page="summary",
        body=lambda _: [
            Lines([*_several_lines(landings), *_warning_count(profiles)]),
            landings_view(landings),
            sheets["summary"](),
            *_damage_picture(profiles),
        ],
        sheets=sheets,
        warnings=[
            f"not computed: {line}"
            for line in cause_lines(causes(reasons), "landings", len(reasons))
        ],
        document=lambda: (
            {"failures": [{"landing": name, "reason": reason} for name, reason in reasons]}
            if reasons
            else {}
        ),
        landings=landings,
        live=live or None,
        parts=parts,
    )


def _several_lines(landings: Mapping[str, ShockProfile]) -> list[tuple[str, str]]:
    """The shock of several landings, the smallest margin of parts, and what is not known."""
    margin = margin_line(landings)
    return [
        ("shock", worst_text(landings)),
        *([("margin", margin)] if margin else []),
        *unknown_lines(landings.values()),
    ]


def _summary(profile: ShockProfile) -> list[tuple[str, str]]:
    """What matters most: the first shock with its range, what is not known, the largest impulse
    through a joint, and warnings.
    """
    loads, warnings, mu = profile.loads, other_warnings(profile), sliding_friction(profile)
    force = "none, because the robot has no joints"
    if loads:
        sizes, moments = (
            profile.value(key if mu is None else f"{key}_friction", "joint")
            for key in ("joint_impulse", "along")
        )
        load, moment = loads[int(np.argmax(sizes))], abs(float(moments[np.argmax(sizes)]))
        unit = "N s" if profile.robot.joint(load.joint).unit == "m" else "N m s"
        along = "" if math.isnan(moment) else f", {rounded(moment)} {unit} along its axis"
        force = f"{load.joint} {rounded(sizes.max())} N s{along}"
        if not profile.row_space.unique.all():
            force = "not determined, because rows are redundant"
        elif any(one.kind == "size" for one in warnings):
            force = "not determined, because the mechanism is singular or redundant here"
    with_friction = "" if mu is None else f" with friction {mu:g}"
    lines = [
        ("shock", shock_line(profile)),
        *unknown_lines([profile]),
        ("joint", f"largest impulse{with_friction}: {force}"),
    ]
    lines += _warning_count([profile])
    peaks = profile.value("peak_g" if mu is None else "peak_g_friction", "point").tolist()
    known = [
        f"{point.frame} {rounded(g)} g"
        for point, g in zip(profile.points, peaks, strict=True)
        if not math.isnan(g)
    ]
    if known:
        lines.insert(
            1, ("peak", f"{few(known, 4)} for a pulse {profile.scene.pulse}{with_friction}")
        )
    read = zip(
        profile.places("point"), profile.value("filtered_peak", "point").tolist(), strict=True
    )
    readings = [f"{place.name} {rounded(g)} g" for place, g in read if not math.isnan(g)]
    if readings:
        lines.insert(1 + bool(known), ("reading", f"{few(readings, 4)} {readings_text(profile)}"))
    if (limit := profile.scene.range_g) is not None:
        moving = [place for place in profile.places("point") if place.body >= 0]
        peaks_of = zip(moving, sensor_peaks(profile.landing, profile.proof, moving), strict=False)
        ranges = [
            f"{place.name} {rounded(peak.peak)} of {limit:g} g ({peak})" for place, peak in peaks_of
        ]
        lines[-1:-1] = [("range", few(ranges, 4, "; "))] * bool(ranges)
    if margin := margin_line({"": profile}):
        lines.insert(1, ("margin", margin))
    return lines


def _warning_count(profiles: Sequence[ShockProfile]) -> list[tuple[str, str]]:
    """How many warnings there are, and the first; that there are none only where nothing is
    unknown.
    """
    if found := alike(
        [(one, k) for k, profile in enumerate(profiles) for one in other_warnings(profile)]
    ):
        first = textwrap.shorten(str(found[0][0][0]), WARNING, placeholder=" …")
        return [("warnings", f"{count(len(found), 'warning')}: {first}")]
    return [CLEAN] if all(one.known for profile in profiles for one in profile.unknowns) else []


def _summary_with_ground(profile: ShockProfile) -> list[tuple[str, str]]:
    """The summary, and impulse, friction and effective mass at the contacts."""
    texts, mu = [], sliding_friction(profile)
    for k, (contact, block) in enumerate(
        zip(profile.contacts, profile.landing.contacts, strict=True)
    ):
        if block.kind == "stop":
            texts.append(_stop_text(contact, block))
            continue
        if mu is not None and profile.friction is not None:
            size = rounded(math.hypot(*profile.value("impulse_friction", "contact")[k]))
            texts.append(
                f"{contact.frame}: {profile.friction.state[k]} with friction {mu:g}, impulse "
                f"{size} N s"
            )
            continue
        if contact.impulse is None:
            texts.append(f"{contact.frame}: impulse not determined, because rows are redundant")
            continue
        size = (
            f"impulse {rounded(math.hypot(*contact.impulse))} N s, "
            f"{mass_text(profile, contact, block)}"
        )
        texts.append(f"{contact.frame}: {size}, {friction_text(contact, block)}")
    return [*_summary(profile), ("ground", few(texts, 4, "; "))]


def _stop_text(contact: ContactImpulse, stop: ConstraintBlock) -> str:
    """The impulse of an end stop that strikes, and what resists it."""
    slides = bool(len(stop.forces))
    impulse, unit, mass = (
        (contact.impulse, "N s", "kg") if slides else (contact.moment, "N m s", "kg m²")
    )
    size = "not determined" if impulse is None else f"{rounded(math.hypot(*impulse))} {unit}"
    what = "mass along its joint" if slides else "inertia about its joint"
    return (
        f"{contact.frame}: impulse {size}, effective {what} {rounded(contact.effective_mass)} "
        f"{mass}"
    )


def _answer(
    profile: ShockProfile, bodies: Sequence[int] | None, remarks: Sequence[tuple[str, str]]
) -> list[Section]:
    """The summary, the landing, shocks and joint impulses with the worst first, and what decides on
    them.
    """
    doubles = [
        name
        for name, given in (("friction", profile.friction), ("stiffness", profile.stiffness))
        if given
    ]
    numbers = f"error below {profile.health.error_bound:.0e}" + "".join(
        f"; those with {name} in double precision" for name in doubles
    )
    tables = shown_tables(profile, bodies, JOINTS, brief=True)
    if "joint_models" in tables:
        tables.pop("points", None)  # the table of joint models has the shock there too
    shown = [table() for table in tables.values()]
    return [
        Lines([*_summary_with_ground(profile), ("rounding", numbers), *remarks]),
        Lines(landing_lines(scene_lines(profile)[1:])),
        worst_bodies(profile, None if bodies else WORST, bodies),
        *shown,
        Lines([*_stop_lines(profile), *_friction_lines(profile), *_wing_lines(profile), MORE]),
    ]


def landing_lines(lines: Sequence[tuple[str, str]]) -> list[tuple[str, str]]:
    """The lines of the header that say something of this landing."""
    return [
        (name, text)
        for name, text in lines
        if name not in USUAL or not text.startswith(USUAL[name])
    ]


def accuracy_line(profile: ShockProfile) -> str:
    """The bound on rounding, and the effects of double precision and of the data's last digit."""
    health = profile.health
    rounding = f"{proof_text(health.error_bound)}, {health.bits} bits"
    double = (
        f"was off by {health.double_error:.0e}"
        if math.isfinite(health.double_error)
        else "finds no solution"
    )
    data = f"last-digit changes of the data move it by {health.data_sensitivity:.0e}"
    return f"accuracy: {rounding}; double precision {double}; {data}"


def _damage_picture(profiles: Sequence[ShockProfile]) -> list[Picture]:
    """The damage boundaries of the parts with the landings on them; nothing without parts."""
    if not any(isinstance(one.strength, Strength) for profile in profiles for one in profile.parts):
        return []
    return [
        Picture(
            "damage_boundary",
            f"damage boundary of parts of {robot_name(profiles[0].robot)}",
            "studies.analyze.damage:draw_damage",
            (profiles,),
        )
    ]


def _stop_lines(profile: ShockProfile) -> list[str]:
    """Which end stops act, and with what impulse; a line each."""
    striking = [block for block in profile.landing.contacts if block.kind == "stop"]
    if not profile.scene.stops and not striking:
        return []
    values = dict(
        zip(
            (p.name for p in profile.places("joint")),
            profile.value("stop_impulse", "joint").tolist(),
            strict=True,
        )
    )
    lines = []
    for stop in (*striking, *profile.landing.acting):
        side, name = (
            "minimum" if side_of(profile.robot, stop) > 0.0 else "maximum",
            stop.frame.removeprefix(STOP),
        )
        unit = "N m s" if len(stop.moments) else "N s"
        peak = (
            f", at most {profile.stiffness.stop_peaks.get(name, 0.0):.4g} {unit.removesuffix(' s')}"
            if profile.stiffness
            else ""
        )
        lines.append(
            f"the end stop of {name} at its {side} value acts with {abs(values[name]):.4g} "
            f"{unit}{peak}"
        )
    if profile.landing.acting:
        return [
            *lines,
            "numbers of other strikes, such as the most and least severe directions, are those "
            "with these stops held",
        ]
    return lines or ["no end stop acts"]


def _wing_lines(profile: ShockProfile) -> list[str]:
    """What wings say of the landing, a line each."""
    return [line for door in doors("report") for line in door.lines(profile)]


def _friction_lines(profile: ShockProfile) -> list[str]:
    """What friction says of the landing, and when that holds."""
    if (sliding := profile.friction) is None:
        return []
    name, n = f"friction {profile.scene.friction:g}", sliding.solutions
    others = f"; {count(n, 'solution')} found" if n > 1 else ""
    if sliding.impact is None:
        return [f"{name}: every contact sticks, so the results hold as they are{others}"]
    others += "; there may be more solutions" if len(sliding.state) > 1 else ""
    lost, rest = (
        f"energy lost {sliding.energy_lost:.4g} J",
        "all other tables are without it, for contacts that stick",
    )
    return [f"{name}: {lost}, residual {sliding.residual:.0e}{others}; {rest}"]


def _side_by_side(profiles: Sequence[ShockProfile], bodies: Sequence[int] | None) -> Sheet:
    """Several landings side by side: shock at bodies' centres of mass and at every point.

    Args: bodies; None for all.
    """
    first = profiles[0]
    shown = [
        i
        for i in range(len(first.bodies))
        if (bodies is None or i in bodies) and any(one.moved[i] for one in profiles)
    ]
    rows: list[Row] = [
        (first.bodies[i], *(profile.shock_com[i] for profile in profiles)) for i in shown
    ]
    points = zip(*(profile.points for profile in profiles), strict=True)
    rows += [(f"at {same[0].frame}", *(point.shock for point in same)) for same in points]
    header: list[str | Column] = [
        "shock at",
        *(Column(name, name, "-") for name in map(contact_name, profiles)),
    ]
    return Sheet("summary: shock at each body's CoM and at each point, by contact", header, rows)


def _balance_lines(profile: ShockProfile) -> list[str]:
    """Energy, effective masses, impact mitigation and the closing of loops; one line each."""
    share = (
        ""
        if profile.energy_share is None
        else f", {100.0 * profile.energy_share:.3g} % of the kinetic energy before impact"
    )
    lost = (
        f"{profile.energy_lost:.4g} J{share}"
        if math.isfinite(profile.energy_lost)
        else "not determined: a motor does work"
    )
    lines = [f"energy lost: {lost}"]
    for contact, block in zip(profile.contacts, profile.landing.contacts, strict=True):
        mitigation = NO_MITIGATION
        if contact.mitigation is not None:
            factors = (
                f"{contact.mitigation:.3f} sticking, {contact.mitigation_frictionless:.3f} "
                f"frictionless"
            )
            mitigation = f"impact mitigation factor {factors}"
        masses = (
            f"{contact.effective_mass_sticking:.4g} kg sticking, {contact.effective_mass_frictionless:.4g} kg "
            f"frictionless"
        )
        if block.kind == "stop":
            lines.append(_stop_text(contact, block))
            continue
        lines.append(f"{contact.frame}: effective mass {masses}, {mitigation}")
    if assembly := profile.assembly:
        turn = f" and {shown_as(assembly.turn, 'rad')}" if assembly.turn > 0.0 else ""
        how = (
            ", ".join(f"{name} by {shown_as(by, unit)}" for name, by, unit in assembly.moved)
            or "no joint had to move"
        )
        lines.append(f"loops closed from a gap of {shown_as(assembly.gap, 'm')}{turn}: {how}")
    return lines
