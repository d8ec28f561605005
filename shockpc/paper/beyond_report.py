"""What of the rigid answer holds for bodies that bend: tables and charts of the errors over the duration of contact."""

from collections.abc import Callable
from functools import partial
from typing import TypeAlias

import numpy as np

from shockpc.paper.beyond import HINGES, LIMIT, STRIKES, Struck, beam_study, holds_from
from shockpc.paper.beyond_robots import LAWS, Errors, robot_study
from shockpc.show.report import Picture, Report, picture_files
from shockpc.show.tables import Column, Lines, Sheet

Curves: TypeAlias = dict[str, tuple[list[float], list[float]]]

WORDS = ("impulse", "other end", "CoPc")
"""What is compared of the beam."""

OF_ROBOTS = ("jump of the base", "peak acceleration of the base", "peak force of the contact", "largest peak of a joint")
"""What is compared of robots."""

SHOWN, REST = (1.0, 3.0, 10.0), "further Tc f1, and what the words mean: --out"
"""Tc f1 of robots that a terminal shows, and what it says of the others."""

NOT_MODELLED = (
    "not modelled: compliance of bearings and gears, and damping of the material; real links bend more, and ring for less long"
)


def beyond_report() -> Report:
    """The beam of Figure 1 with bending against Eqs. 1 to 3, and robots whose legs bend."""
    kept = [(name, holds_from(np.array([one.exact[k] for one in beam_study()]))) for k, name in enumerate(WORDS)]
    answer = [f"{name} within {100 * LIMIT:g} % from Tc/T1 = {ratio:g}" for name, ratio in kept]
    sheets: dict[str, Callable[[], Sheet]] = {"beam": _beam_sheet, "robots": _robots_sheet}
    return Report(
        name="beyond",
        title="Where the rigid answer holds",
        page="beyond",
        body=lambda full: [
            Lines([f"the beam of Figure 1, with bending: {'; '.join(answer)}", NOT_MODELLED]),
            _beam_sheet(),
            _beam_picture(),
            _robots_sheet() if full else _robots_sheet().where(lambda row: row["ratio"] in SHOWN)._replace(notes=(REST,)),
            _robots_picture(),
        ],
        sheets=sheets,
        document=lambda: {"holds_from": dict(zip(Struck._fields, (ratio for _, ratio in kept), strict=True))},
        tables=True,
        others=picture_files("beam", "robots"),
    )


def _beam_sheet() -> Sheet:
    """What the rigid answer of the beam is off by, by exact modes and by segments."""
    columns = [
        Column(f"{how}_{key}", f"{name}, {how}", "-")
        for how in ("modes", "segments")
        for key, name in zip(Struck._fields, WORDS, strict=True)
    ]
    notes = (
        f"largest of {len(STRIKES)} points of contact, {', '.join(f'{x:.3g}' for x in STRIKES)} of the length from the "
        "centre of mass; an elastic contact without loss",
        "Tc: duration of contact of the rigid beam; T1: period of its first bending mode, free at both ends",
        "impulse: off by this share; other end: its velocity when the contact ends, and CoPc: its velocity at any time, which "
        "Eq. 2 says to be zero, off by this share of the speed of the impact",
        f"modes: those of Euler and Bernoulli; segments: {HINGES} hinges, as of --flex LINK=...,hinges:{HINGES}",
    )
    rows = [(one.ratio, *one.exact, *one.segments) for one in beam_study()]
    title = "the beam of Figure 1 with bending: what the rigid answer, Eqs. 1 to 3, is off by"
    return Sheet(title, (Column("ratio", "Tc/T1", "-"), *columns), rows, notes)


def _beam_picture() -> Picture:
    ratios = [one.ratio for one in beam_study()]
    lines = {f"{name}, modes": (ratios, [one.exact[k] for one in beam_study()]) for k, name in enumerate(WORDS)}
    dots = {f"{name}, segments": (ratios, [one.segments[k] for one in beam_study()]) for k, name in enumerate(WORDS)}
    title = "A beam that bends: error of the rigid answer"
    return Picture("beam", title, "paper.figure:draw_errors", (title, [("", lines, dots)], LIMIT))


def _robots_sheet() -> Sheet:
    """What rigid links of robots are off by."""
    columns = [Column(key, name, "-") for key, name in zip(Errors._fields, OF_ROBOTS, strict=True)]
    notes = (
        "one foot strikes, the links from it to the base bend alike; Tc: duration of contact with rigid links; f1: first bending "
        "frequency of the free robot, with rotors where their drives are known (go2, g1)",
        "elastic: without loss; by hysteresis of e = 0 forces end in a step, which rings however stiff the links are, so that "
        "errors do not fall; joints: over the largest peak along any",
    )
    rows = [(one.robot, one.law, one.ratio, one.EI, *one.errors) for one in robot_study()]
    title = "robots whose legs bend: what rigid links are off by"
    return Sheet(title, ("robot", "law of the contact", Column("ratio", "Tc f1", "-"), "EI [N m²]", *columns), rows, notes)


def _robots_picture() -> Picture:
    def curves(law: str, index: int) -> Curves:
        found = [one for one in robot_study() if one.law == law]
        robots = dict.fromkeys(one.robot for one in found)
        return {
            name: ([one.ratio for one in found if one.robot == name], [one.errors[index] for one in found if one.robot == name])
            for name in robots
        }

    title = "Robots whose legs bend: error of rigid links"
    no_dots: Curves = {}
    shown = partial(curves, index=Errors._fields.index("torque"))
    panels = [(f"{OF_ROBOTS[-1]}, {law}", shown(law), no_dots) for law in LAWS]
    return Picture("robots", title, "paper.figure:draw_errors", (title, panels, LIMIT))
