"""What of the rigid answer holds for a body that bends: a table and a chart of the errors over the duration of contact."""

import numpy as np

from shockpc.paper.beyond import HINGES, LIMIT, STRIKES, Struck, beam_study, holds_from
from shockpc.show.report import Picture, Report, picture_files
from shockpc.show.tables import Column, Lines, Sheet

WORDS = Struck("impulse", "other end", "CoPc")
"""What is compared."""

NOT_MODELLED = (
    "not modelled: compliance of bearings and gears, and damping of the material; a real link bends more, and rings less long"
)


def beyond_report() -> Report:
    """The beam of Figure 1 with bending against Eqs. 1 to 3."""
    study = beam_study()
    kept = {
        name: holds_from(np.array([getattr(one.exact, key) for one in study]))
        for key, name in zip(Struck._fields, WORDS, strict=True)
    }
    columns = [
        Column(f"{how}_{key}", f"{name}, {words}", "-")
        for how, words in (("exact", "modes"), ("segments", "segments"))
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
    rows = [(one.ratio, *one.exact, *one.segments) for one in study]
    sheet = Sheet(
        "the beam of Figure 1 with bending: what the rigid answer, Eqs. 1 to 3, is off by",
        (Column("ratio", "Tc/T1", "-"), *columns),
        rows,
        notes,
    )
    answer = [f"{name} within {100 * LIMIT:g} % from Tc/T1 = {ratio:g}" for name, ratio in kept.items()]
    return Report(
        name="beyond",
        title="Where the rigid answer holds",
        page="beyond",
        body=lambda _: [Lines(["; ".join(answer), NOT_MODELLED]), sheet, beam_picture()],
        lead=3,
        sheets={"beam": lambda: sheet},
        document=lambda: {"holds_from": dict(zip(Struck._fields, kept.values(), strict=True))},
        tables=True,
        others=picture_files("beam"),
    )


def beam_picture() -> Picture:
    """The errors of the rigid answer over Tc/T1."""
    title = "A beam that bends: error of the rigid answer"
    return Picture("beam", title, "paper.beyond_figure:draw_errors", (title, beam_study(), tuple(WORDS)))
