"""A sweep: the range of every quantity, what it depends on, and the extreme landings as options of
`shockpc analyze`.
"""

import itertools
import shlex
from collections.abc import Iterator

import numpy as np

from shockpc.evaluation.column import Column as Computed
from shockpc.evaluation.kinds.posture import beyond_limits
from shockpc.evaluation.kinds.strike import SPEED
from shockpc.evaluation.varied_landings import VariedLandings
from shockpc.judgement.unknowns import CARRIES
from shockpc.profile import profile_of_scene
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.show.document import record
from shockpc.show.header import unknown_lines
from shockpc.show.report import Picture, Report
from shockpc.show.tables import Column, Lines, Row, Sheet
from shockpc.show.wording import LEFT_OUT, STICKING, proof_lines, robot_name, without_value
from shockpc.studies.sweep.summary import PERCENTILES, Extent, Summary
from shockpc.text.printed import cause_lines, printable
from shockpc.text.wings import from_wings

MESSAGES = 5
"""Messages of rows that could not be computed that are shown."""


STRONGEST = 16
"""Varied quantities whose rank correlations a terminal shows."""


def sweep_report(summary: Summary[VariedLandings]) -> Report:
    """The summary of a sweep, whose rows have separate files."""
    return Report(
        name="summary",
        title=f"Sweep of {robot_name(summary.evaluation.landings.robot)}",
        page="summary",
        body=lambda whole: [
            *_unknowns(summary),
            _sheet(summary).without("most_severe", "least_severe"),
            *([_correlations(summary, None if whole else STRONGEST)] if summary.varied else []),
            Picture(
                "sweep", "results over the sweep", "studies.sweep.figure:draw_sweep", (summary,)
            ),
            Lines(list(_lines(summary)), whole=True),
        ],
        sheets={
            "summary": lambda: _sheet(summary),
            **({"correlations": lambda: _correlations(summary, None)} if summary.varied else {}),
        },
        document=lambda: {
            "robot": summary.evaluation.landings.robot.name,
            "scene": summary.evaluation.landings.scene,
            "unknowns": [] if (worst := _most_severe_landing(summary)) is None else worst.unknowns,
            "rows": summary.rows,
            **record(summary, "failed", "proven", "compared", "largest_error"),
            "not_feasible": summary.refused._asdict(),
            "messages": [
                {"text": one.text, "rows": one.rows, "first": one.first} for one in summary.messages
            ],
        },
        tables=True,
    )


def _most_severe(extent: Extent) -> int:
    """The row of the most severe value; that of the largest one where neither direction is worse."""
    return (
        extent.least_row
        if extent.column.selection.quantity.worse == "less"
        else extent.greatest_row
    )


def _sheet(summary: Summary[VariedLandings]) -> Sheet:
    """One row for each quantity at each place: its range, of a sample with percentiles, where the
    ends are, and their options.
    """
    sweep, rows = summary.evaluation.landings, list[Row]()
    shares = [Column(f"percentile_{share:g}", f"{share:g} %") for share in PERCENTILES]
    for one in summary.extents:
        ends = (one.least_row, one.greatest_row) if one.greatest_row >= 0 else (None, None)
        low, *high = one.percentiles if sweep.sample is not None else [None] * len(shares)
        worst, best = _most_severe(one), one.best_row
        options = _options(sweep, worst)[0] if worst >= 0 else None
        least = (
            _options(sweep, best)[0]
            if best >= 0 and one.column.selection.quantity.worse != "neither"
            else None
        )
        named = one.column.name, one.column.unit
        rows.append(
            (*named, one.least, low, one.median, *high, one.greatest, *ends, options, least)
        )
    header: tuple[str | Column, ...] = (
        "quantity",
        "unit",
        "minimum",
        shares[0],
        "median",
        *shares[1:],
        "maximum",
        "row of minimum",
        "row of maximum",
        "most severe",
        "least severe",
    )
    sheet = Sheet(f"sweep of {robot_name(sweep.robot)}: {summary.rows} landings", header, rows)
    return sheet if sweep.sample is not None else sheet.without(*(share.key for share in shares))


def _correlations(summary: Summary[VariedLandings], most: int | None) -> Sheet:
    """One row for each quantity that was varied: its rank correlation with each result.

    Args: most, rows of the strongest.
    """
    rows: list[Row] = [
        (one.column, *map(float, row))
        for one, row in zip(summary.varied, summary.correlations, strict=True)
    ]
    strongest = np.abs(np.nan_to_num(summary.correlations)).max(axis=1, initial=0.0).tolist()
    chance = (
        f"of {summary.ranked} landings; independent columns reach up to {summary.chance:.2g} by "
        "chance"
    )
    header: list[str | Column] = [
        "rank correlation of",
        *(Column(one.column.name, f"with {one.column.name}") for one in summary.extents),
    ]
    sheet = Sheet("what the results depend on", header, rows).largest(
        most, "varied quantity", strongest
    )
    return sheet._replace(notes=(chance, *sheet.notes))


def _lines(summary: Summary[VariedLandings]) -> Iterator[str]:
    """The most severe landings, warnings of what is varied, what was not computed, and the
    accuracy.
    """
    for one in summary.extents:
        if one.greatest_row >= 0:
            what = (
                "largest value"
                if one.column.selection.quantity.worse == "neither"
                else "most severe"
            )
            yield f"{what} for {one.column.name}: {_varied(summary.evaluation.landings, _most_severe(one))}"
        if one.best_row >= 0 and one.column.selection.quantity.worse != "neither":
            yield f"least severe that flat ground allows: {_varied(summary.evaluation.landings, one.best_row)}"
    if summary.failed < summary.rows:
        yield from without_value(
            (one.column.name, one.column.selection.quantity)
            for one in summary.extents
            if one.greatest_row < 0
        )
    relative = [one.column.place.name for one in summary.extents if one.column.shock]
    if relative and any(varied.kind == SPEED for varied in summary.evaluation.landings.variations):
        asked = (
            f"--quantity delta_v@{relative[0]} gives m/s, and peak_g@{relative[0]} with --pulse g"
        )
        yield f"shock is relative to the contact velocity, and the same at every speed; {asked}"
    refused, *counts = summary.refused
    if refused:
        causes = (
            "a contact would have to be pulled",
            "the impact would gain energy",
            "another link is below the contacts, or they differ in height",
        )
        listed = ", ".join(
            f"{number} because {cause}"
            for number, cause in zip(counts, causes, strict=True)
            if number
        )
        left = "they are left out" if summary.evaluation.feasible else "--feasible leaves them out"
        yield f"warning: flat ground does not allow {refused} of {summary.rows} landings: {listed}; {left}"
    if summary.tilted:
        left = f"{summary.tilted} of {summary.rows} landings leave out feet that are level"
        yield f"{left}, which only a small tilt does (column feasible_if_tilted)"
    yield from (
        f"warning: {warning}" for warning in summary.evaluation.landings.case(0)[1].change_warnings
    )
    sweep = summary.evaluation.landings
    # else rows have landings of which others may say less or more
    if all(varied.stage for varied in sweep.variations):
        yield from (
            f"warning: {warning}" for warning in sweep.first.warnings if warning.kind == "scene"
        )
    yield from (
        f"warning: {text}"
        for varied in sweep.variations
        if (text := beyond_limits(sweep.robot, varied))
    )
    stiff = sweep.scene.yields or any(
        varied.kind.word == "contact-stiffness" for varied in sweep.variations
    )
    if not stiff or not any(map(_on_stiffness, summary.evaluation.computed)):
        asked = "--quantity peak_acceleration or peak_force"
        if not stiff:
            asked += ", with --contact-stiffness,"
        for varied in filter(lambda varied: varied.kind.lasting, sweep.variations):
            yield f"warning: nothing computed here depends on {varied.subject}; {asked} does"
    slides = sweep.scene.friction is not None or any(
        varied.kind.word == "friction" for varied in sweep.variations
    )
    if slides and not any(
        one.column.selection.quantity.of_ground(sweep.scene) for one in summary.extents
    ):
        yield f"warning: {STICKING}"
    if stiff:
        yield LEFT_OUT
        yield from _worst_warning(summary)
    if summary.failed:
        yield f"not computed: {summary.failed} of {summary.rows} landings"
        named = [cause._replace(first=f"row {cause.first}") for cause in summary.messages]
        yield from (f"  {line}" for line in cause_lines(named, "rows", MESSAGES))
    columns = [one.column for one in summary.extents]
    yield from proof_lines(summary.proven, summary.compared, summary.largest_error, columns)


def _unknowns(summary: Summary[VariedLandings]) -> list[Lines]:
    """What the landings take for granted, as the most severe of them does; nothing where none was
    computed.
    """
    worst = _most_severe_landing(summary)
    if worst is None:
        return []
    lines = unknown_lines([worst])
    soles = [
        contact
        for contact in summary.evaluation.landings.first.scene.contact
        if contact.kind in CARRIES
    ]
    if soles:
        parts = "; ".join(f"{contact.frame}: {CARRIES[contact.kind]}" for contact in soles)
        lines.append(
            (
                "soles",
                printable(
                    f"{parts}, which carries in the landing of the scene, and is taken for all rows"
                ),
            )
        )
    return [Lines(lines)]


def _most_severe_landing(summary: Summary[VariedLandings]) -> ShockProfile | None:
    """The landing with the most severe value of the first quantity that has one; None without a
    value.
    """
    rows = [_most_severe(one) for one in summary.extents if one.greatest_row >= 0]
    return profile_of_scene(*summary.evaluation.landings.case(rows[0])) if rows else None


def _on_stiffness(column: Computed) -> bool:
    """Whether a column may depend on the stiffness of the contacts."""
    quantity = column.selection.quantity
    return quantity.evaluation.exact != "always"


def _worst_warning(summary: Summary[VariedLandings]) -> Iterator[str]:
    """The worst warning of the shared checks of wings, of the rows with the most severe values of
    what depends on the stiffness of the contacts.
    """
    sweep, worst = summary.evaluation.landings, list[tuple[float, int, str]]()
    extents = [one for one in summary.extents if one.greatest_row >= 0]
    checks = [check for shared in from_wings("checks", "SHARED") for check in shared.values()]
    for row in sorted({_most_severe(one) for one in extents if _on_stiffness(one.column)}):
        profile = profile_of_scene(*sweep.case(row))
        for check in checks:
            worst += [(warning.size, -row, str(warning)) for warning in check(profile)]
    if worst:
        _, row, text = max(worst)
        yield f"warning: row {-row} ({_varied(sweep, -row)}): {text}"


def _varied(made: VariedLandings, row: int) -> str:
    """What was varied in a row: options of `shockpc analyze`, and what has none."""
    options, others = _options(made, row)
    return f"{options}   (and {others})" if options and others else options or others


def _options(made: VariedLandings, row: int) -> tuple[str, str]:
    """What was varied in a row as options of `shockpc analyze`, and what has no option."""
    scene, _ = made.case(row)
    options: list[tuple[str, str]] = []
    others: list[str] = []
    for one, value in made.values_of(row).items():
        of_value = one.kind.options(one, value, scene, made.scene)
        if of_value is not None:
            options += of_value
            continue
        unit = "x" if one.factor else one.unit
        others.append(f"{one.subject} = {value:g} {unit}")
    if made.separate:  # where the joints are that close the loops, as they were followed
        options += [
            ("--set", f"{name}={x!r}")
            for name in scene.assemble
            if (x := scene.posture.joints_deg.get(name)) is not None
        ]
        # No option takes the rotation of a ball joint, which follows from the other joints.
        turned = [name for name in scene.assemble if name in scene.posture.joint_quaternions]
        options += [
            ("--assemble", name)
            for name in turned or (() if made.scene.assemble else scene.assemble)
        ]
    return shlex.join(itertools.chain.from_iterable(dict.fromkeys(options))), ", ".join(others)
