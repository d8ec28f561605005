"""The reports of landings: the lines of each with its tables, and the shocks of several."""

from collections.abc import Mapping, Sequence
from functools import partial
from types import MappingProxyType
from typing import Any

from shockpc.landing.contact import contact_name
from shockpc.landing.ratings import Strength
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.show.header import (
    common_lines,
    contacts_text,
    other_warning_lines,
    scene_lines,
    shared_warnings,
)
from shockpc.show.report import Picture, Report, Section
from shockpc.show.tables import WIDTH, Heading, Lines, Row, Sheet
from shockpc.show.wording import robot_name
from shockpc.studies.analyze.closing import closing_lines, ground_lines
from shockpc.studies.analyze.landing_document import content
from shockpc.studies.analyze.opening import (
    Line,
    landing_lines,
    rounding_text,
    several_lines,
    summary_lines,
    warning_count,
)
from shockpc.studies.analyze.several import Reports, landings_sheet, landings_view
from shockpc.studies.analyze.sheets import landing_tables
from shockpc.studies.analyze.views import shown_tables, worst_bodies
from shockpc.text.errors import ShockError
from shockpc.text.printed import not_computed
from shockpc.text.wings import from_wings

WORST, JOINTS = 6, 3
"""Numbers of bodies and of joints in the tables of an answer.

The heaviest body is among them unless bodies are asked for by name.
"""

LIVE = ("bodies", "points", "contacts", "joints")
"""Tables that report.html has for every contact velocity."""

MORE = "--all prints everything that was computed"
"""The last line of an answer."""


def landing_report(
    profile: ShockProfile,
    bodies: Sequence[int] | None = None,
    spectrum: bool = False,
    all_tables: bool = False,
    remarks: Sequence[Line] = (),
    live: Sequence[str] = (),
) -> Report:
    """The report of a landing.

    Of the bodies it has only those that are given by their indices, save in the document. The files
    are profile.json, a CSV file of each table, report.md, shock.svg and shock.png; with parts also
    damage_boundary.svg, with a contact stiffness time.svg, and on request spectrum.svg, the shock
    response spectrum, which then is in profile.json too. On a terminal only the answer is shown, or
    all tables with `all_tables`.
    """
    return Report(
        name="profile",
        title=f"Shock of {robot_name(profile.robot)} landing on {contact_name(profile.scene)}",
        body=lambda full: _sections(profile, bodies, spectrum, remarks, None if full else 6),
        page_body=lambda: _sections(profile, bodies, spectrum, remarks, None, LIVE),
        width=WIDTH,
        brief=None if all_tables else lambda: _answer(profile, bodies, remarks),
        closing=closing_lines(profile),
        warnings=other_warning_lines(profile),
        sheets=landing_tables(profile, bodies),
        document=lambda: content(profile, spectrum),
        tables=True,
        landings={contact_name(profile.scene): profile},
        live=live,
    )


def document(profile: ShockProfile, spectrum: bool = False) -> dict[str, Any]:
    """The JSON document of one landing.

    Args: profile; spectrum, whether it has the shock response spectra of the points.
    """
    entries: dict[str, Any] = landing_report(profile, spectrum=spectrum).json()
    return entries


def analyze_report(
    landings: Mapping[str, ShockProfile],
    bodies: Sequence[int] | None = None,
    spectrum: bool = False,
    all_tables: bool = False,
    failures: Mapping[str, ShockError] = MappingProxyType({}),
    remarks: Sequence[Line] = (),
    live: Sequence[str] = (),
) -> Report:
    """The report of one landing, or of several with their shocks side by side.

    Args:
        landings: by the names of their folders.
        bodies: indices of the only bodies that are shown.
        spectrum: whether to draw the shock response spectrum of the points.
        all_tables: whether a terminal shows all tables of each.
        failures: why others could not be computed, by name.
        remarks: what landings on whole feet and on all level feet give, each with its heading.
        live: names or globs of joints that have sliders in report.html; of one landing those that
            carry the contact always have.
    """
    parts = Reports(
        landings,
        lambda profile: landing_report(profile, bodies, spectrum, all_tables, remarks, live),
    )
    if len(parts) == 1 and not failures:
        return next(iter(parts.values()))
    profiles = list(landings.values())
    brief = None
    if not all_tables:
        brief = partial(_answer_of_several, landings, bodies, remarks)
    return Report(
        name="summary",
        width=WIDTH,
        brief=brief,
        page="summary",
        body=lambda _: [
            Lines([*several_lines(landings), *warning_count(profiles)]),
            landings_view(landings),
            _side_by_side(profiles, bodies),
            *_damage_picture(profiles),
        ],
        sheets={
            "summary": lambda: _side_by_side(profiles, bodies),
            "landings": lambda: landings_sheet(landings),
        },
        warnings=not_computed(failures.items(), "landings", len(failures)),
        document=lambda: _failures(failures),
        landings=landings,
        live=live or None,
        parts=parts,
    )


def _answer_of_several(
    landings: Mapping[str, ShockProfile], bodies: Sequence[int] | None, remarks: Sequence[Line]
) -> list[Section]:
    """The shocks of several landings side by side, what is common to them, and their warnings."""
    profiles = list(landings.values())
    lines = [*several_lines(landings), *landing_lines(common_lines(landings))]
    lines += [("contact", contacts_text(profiles)), *warning_count(profiles), *remarks]
    sections: list[Section] = [Lines(lines), landings_view(landings)]
    if bodies:
        sections.append(_side_by_side(profiles, bodies))
    return [*sections, Lines([MORE]), Lines(shared_warnings(landings))]


def _failures(failures: Mapping[str, ShockError]) -> dict[str, Any]:
    """The entry of the document for landings that could not be computed; none without any."""
    if not failures:
        return {}
    entries = []
    for name, reason in failures.items():
        entries.append({"landing": name, "reason": str(reason)})
    return {"failures": entries}


def _sections(
    profile: ShockProfile,
    bodies: Sequence[int] | None,
    spectrum: bool,
    remarks: Sequence[Line],
    most: int | None,
    without: Sequence[str] = (),
) -> list[Section]:
    """All lines, tables and figures of a landing.

    Args:
        profile: the landing.
        bodies: indices of the only bodies that are shown.
        spectrum: whether there is a shock response spectrum of the points.
        remarks: what other landings give.
        most: rows of long tables; None for all.
        without: names of tables that are left out.
    """
    tables = shown_tables(profile, bodies, most)
    pictures = _damage_picture([profile])
    for pictures_of in from_wings("report", "pictures"):
        pictures += pictures_of(profile, spectrum)
    return [
        Lines([*summary_lines(profile), *remarks]),
        Lines(_scene_lines(profile)),
        Picture(
            "shock",
            f"shock profile of {robot_name(profile.robot)}",
            "show.figure.plane:draw_landing",
            (profile,),
        ),
        *(table() for name, table in tables.items() if name not in without),
        *pictures,
    ]


def _answer(
    profile: ShockProfile, bodies: Sequence[int] | None, remarks: Sequence[Line]
) -> list[Section]:
    """The summary, the landing, shocks and joint impulses with the worst first.

    What decides on them follows.
    """
    tables = shown_tables(profile, bodies, JOINTS, brief=True)
    if "joint_models" in tables:
        tables.pop("points", None)  # the table of joint models has the shock there too
    rounding = ("rounding", rounding_text(profile))
    return [
        Lines([*summary_lines(profile), rounding, *remarks]),
        Lines(landing_lines(_scene_lines(profile))),
        worst_bodies(profile, None if bodies else WORST, bodies),
        *(table() for table in tables.values()),
        Lines([*ground_lines(profile), MORE]),
    ]


def _scene_lines(profile: ShockProfile) -> list[Line]:
    """The lines of the scene but for the landing's name, with which the shock's line begins."""
    return scene_lines(profile)[1:]


def _damage_picture(profiles: Sequence[ShockProfile]) -> list[Picture]:
    """The damage boundaries of the parts with the landings on them; nothing without parts."""
    strengths = []
    for profile in profiles:
        strengths += [part.strength for part in profile.parts]
    if not any(isinstance(strength, Strength) for strength in strengths):
        return []
    return [
        Picture(
            "damage_boundary",
            f"damage boundary of parts of {robot_name(profiles[0].robot)}",
            "studies.analyze.damage:draw_damage",
            (profiles,),
        )
    ]


def _side_by_side(profiles: Sequence[ShockProfile], bodies: Sequence[int] | None) -> Sheet:
    """Several landings side by side: shock at bodies' centres of mass and at every point.

    Args: bodies; None for all.
    """
    rows: list[Row] = []
    for i, name in enumerate(profiles[0].bodies):
        moved = any(profile.moved[i] for profile in profiles)
        if moved and (bodies is None or i in bodies):
            rows.append((name, *(profile.shock_com[i] for profile in profiles)))
    for same in zip(*(profile.points for profile in profiles), strict=True):
        rows.append((f"at {same[0].frame}", *(point.shock for point in same)))
    header: list[str | Heading] = ["shock at"]
    for profile in profiles:
        name = contact_name(profile.scene)
        header.append(Heading(name, name, "-"))
    return Sheet("summary: shock at each body's CoM and at each point, by contact", header, rows)
