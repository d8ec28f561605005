"""Errors of the rigid answer for bodies that bend, over the duration of contact.

The report has tables and charts.
"""

from collections.abc import Callable, Sequence
from typing import TypeAlias

import numpy as np

from shockpc.show.report import Picture, Report
from shockpc.show.tables import Heading, Lines, Sheet
from shockpc.wings.compliant.beyond.beam import (
    HINGES,
    LIMIT,
    STRIKES,
    Struck,
    beam_study,
    holds_from,
)
from shockpc.wings.compliant.beyond.leg import LINKS, Peaks, leg_frequencies, leg_study
from shockpc.wings.compliant.beyond.robots import LAWS, Errors, robot_study

Curves: TypeAlias = dict[str, tuple[list[float], list[float]]]

WORDS = ("impulse", "other end", "CoPc")
"""Compared quantities of the beam."""

OF_ROBOTS = (
    "jump of the base",
    "peak acceleration of the base",
    "peak force of the contact",
    "largest peak of a joint",
)
"""Compared quantities of robots."""

OF_LEG = (
    "jump of the trunk",
    "peak acceleration of the trunk",
    "peak force of the contact",
    "peak torque of the knee",
)
"""Compared quantities of the leg of tubes."""

SHOWN_RATIOS, OF_OTHER_RATIOS = (1.0, 3.0, 10.0), "further Tc f1, and what the words mean: --out"
"""Tc f1 of robots that a terminal shows, and its note of the others."""

NOT_MODELLED = (
    "not modelled: compliance of bearings and gears, and damping of the material; real links bend "
    "more, and ring for less long"
)


def bending_report() -> Report:
    """The report of bodies that bend: a beam, a leg of tubes, and robots.

    The beam of Figure 1 is compared with Eqs. 1 to 3, the leg with frame elements; of the robots
    the legs bend.
    """
    limits = []
    for k in range(len(WORDS)):
        errors = [row.exact[k] for row in beam_study()]
        limits.append(holds_from(np.array(errors)))
    answer = []
    for name, limit in zip(WORDS, limits, strict=True):
        answer.append(f"{name} within {100 * LIMIT:g} % from Tc/T1 = {limit:g}")
    legs = " and ".join(f"{leg.frames:.0f} Hz {leg.rotors}" for leg in leg_frequencies())
    lines = [
        f"the beam of Figure 1, with bending: {'; '.join(answer)}",
        f"a leg of two tubes bends first at {legs} rotors",
        NOT_MODELLED,
    ]
    sheets: dict[str, Callable[[], Sheet]] = {
        "beam": _beam_sheet,
        "leg": _leg_sheet,
        "robots": _robots_sheet,
    }
    return Report(
        name="beyond",
        title="Where the rigid answer holds",
        page="beyond",
        body=lambda full: [
            Lines(lines),
            _beam_sheet(),
            _beam_picture(),
            _shown(_leg_sheet(), full),
            _leg_picture(),
            _shown(_robots_sheet(), full),
            _robots_picture(),
        ],
        sheets=sheets,
        document=lambda: {"holds_from": dict(zip(Struck._fields, limits, strict=True))},
        tables=True,
    )


def _shown(sheet: Sheet, full: bool) -> Sheet:
    """The rows that a terminal shows, or all."""
    if full:
        return sheet
    return sheet.where(lambda row: row["ratio"] in SHOWN_RATIOS)._replace(notes=(OF_OTHER_RATIOS,))


def _beam_sheet() -> Sheet:
    """Errors of the rigid answer of the beam, by exact modes and by segments."""
    columns = []
    for how in ("modes", "segments"):
        for key, name in zip(Struck._fields, WORDS, strict=True):
            columns.append(Heading(f"{how}_{key}", f"{name}, {how}", "-"))
    notes = (
        f"largest of {len(STRIKES)} points of contact, {', '.join(f'{x:.3g}' for x in STRIKES)} of "
        f"the length from the "
        "centre of mass; an elastic contact without loss",
        "Tc: duration of contact of the rigid beam; T1: period of its first bending mode, free at "
        "both ends",
        "relative errors of the impulse, of the other end's velocity when the contact ends, and "
        "of the CoPc's velocity at any time (zero by Eq. 2), the last two in shares of v_in",
        f"modes: those of Euler and Bernoulli; segments: {HINGES} hinges, as of --flex "
        f"LINK=...,hinges:{HINGES}",
    )
    rows = [(row.ratio, *row.exact, *row.segments) for row in beam_study()]
    title = "the beam of Figure 1 with bending: errors of the rigid answer, Eqs. 1 to 3"
    return Sheet(title, (Heading("ratio", "Tc/T1", "-"), *columns), rows, notes)


def _beam_picture() -> Picture:
    """The errors of the beam over Tc/T1."""
    ratios = [row.ratio for row in beam_study()]
    lines: Curves = {}
    dots: Curves = {}
    for k, name in enumerate(WORDS):
        lines[f"{name}, modes"] = ratios, [row.exact[k] for row in beam_study()]
        dots[f"{name}, segments"] = ratios, [row.segments[k] for row in beam_study()]
    return _errors("beam", "A beam that bends: error of the rigid answer", [("", lines, dots)])


def _errors(name: str, title: str, panels: Sequence[tuple[str, Curves, Curves]]) -> Picture:
    """Errors over the duration of contact, in panels."""
    drawn_by = "wings.compliant.beyond.figure:draw_errors"
    return Picture(name, title, drawn_by, (title, panels, LIMIT))


def _leg_sheet() -> Sheet:
    """Errors of rigid tubes of a leg, and of tubes of few hinges, against frame elements."""
    columns = [Heading(key, name, "-") for key, name in zip(Peaks._fields, OF_LEG, strict=True)]
    modes = "; ".join(
        f"{leg.rotors} {leg.frames:.0f} Hz of frame elements, {leg.two:.0f} on 2 and "
        f"{leg.twelve:.0f} on 12 hinges"
        for leg in leg_frequencies()
    )
    notes = (
        "a trunk on two aluminium tubes of 25 and 21 mm, 0.2 m long, lands on an elastic contact "
        "at 1 m/s; errors relative to frame elements",
        f"first bending mode in its plane: {modes}",
        "Tc: duration of contact with rigid tubes; f1: frequency of that mode, of frame elements; "
        "hinges as of --flex",
    )
    rows = [(row.rotors, row.links, row.ratio, row.stiffness, *row.errors) for row in leg_study()]
    title = (
        "a leg of two tubes: errors of rigid tubes and of tubes with hinges against frame elements"
    )
    of_contact = Heading("ratio", "Tc f1", "-"), Heading("stiffness", "contact stiffness", "N/m")
    return Sheet(title, ("rotors", "tubes", *of_contact, *columns), rows, notes)


def _leg_picture() -> Picture:
    """The errors of the leg over Tc f1, with rotors as lines and without as dots."""
    with_rotors, without = (leg.rotors for leg in leg_frequencies())
    panels = []
    for k, name in enumerate(OF_LEG):
        panels.append((name, _leg_curves(with_rotors, k), _leg_curves(without, k)))
    return _errors("leg", "A leg of two tubes: error against frame elements", panels)


def _leg_curves(rotors: str, index: int) -> Curves:
    """Errors of a number of the leg over Tc f1, of each kind of its links."""
    curves: Curves = {}
    for name in LINKS:
        rows = [row for row in leg_study() if (row.rotors, row.links) == (rotors, name)]
        errors = [row.errors[index] for row in rows]
        curves[f"{name}, {rotors} rotors"] = [row.ratio for row in rows], errors
    return curves


def _robots_sheet() -> Sheet:
    """Errors of rigid links of robots."""
    columns = [Heading(key, name, "-") for key, name in zip(Errors._fields, OF_ROBOTS, strict=True)]
    notes = (
        "landing on one foot, the links from it to the base bend alike; Tc: duration of contact "
        "with rigid links; f1: first bending frequency of the free robot, with rotors where their "
        "drives are known (go2, g1)",
        "elastic: without loss; damper: in series, its force is largest at Tc/π, not at Tc/2, so "
        "errors fall from a longer Tc on. Hysteresis of restitution 0 ends forces in a step: "
        "joints ring and contacts open too early, however stiff links are, so errors do not fall",
        "joints: over the largest peak along any",
    )
    rows = [(row.robot, row.law, row.ratio, row.EI, *row.errors) for row in robot_study()]
    title = "robots whose legs bend: what rigid links are off by"
    return Sheet(
        title,
        ("robot", "law of the contact", Heading("ratio", "Tc f1", "-"), "EI [N m²]", *columns),
        rows,
        notes,
    )


def _robots_picture() -> Picture:
    """The errors of robots over Tc f1, for each law of the contact."""
    panels = []
    for key in ("jump", "torque"):
        k = Errors._fields.index(key)
        for law in LAWS:
            no_dots: Curves = {}
            panels.append((f"{OF_ROBOTS[k]}, {law}", _robot_curves(law, k), no_dots))
    return _errors("robots", "Robots whose legs bend: error of rigid links", panels)


def _robot_curves(law: str, index: int) -> Curves:
    """Errors of a number over Tc f1, of each robot."""
    curves: Curves = {}
    of_law = [row for row in robot_study() if row.law == law]
    for name in dict.fromkeys(row.robot for row in of_law):
        rows = [row for row in of_law if row.robot == name]
        curves[name] = [row.ratio for row in rows], [row.errors[index] for row in rows]
    return curves
