"""The report of a sweep: the range of every quantity, what it depends on, and extreme landings.

These are given as options of `shockpc analyze`.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np

from shockpc.evaluation.variations.rows import VariedLandings
from shockpc.judgement.unknowns import CARRIES
from shockpc.profile import profile_of_scene
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.show.document import record
from shockpc.show.header import unknown_lines
from shockpc.show.report import Picture, Report, Section
from shockpc.show.tables import Heading, Lines, Row, Sheet
from shockpc.show.wording import proof_lines, robot_name
from shockpc.studies.sweep.remarks import sweep_warnings
from shockpc.studies.sweep.row_options import row_options, row_text
from shockpc.studies.sweep.summary import PERCENTILES, Summary
from shockpc.text.printed import cause_lines, printable

MESSAGES = 5
"""Messages of rows that could not be computed that are shown."""


STRONGEST = 16
"""Varied quantities whose rank correlations a terminal shows."""


def sweep_report(summary: Summary[VariedLandings]) -> Report:
    """The summary of a sweep, whose rows have separate files."""
    sheets = {"summary": lambda: _sheet(summary)}
    if summary.varied:
        sheets["correlations"] = lambda: _correlations(summary, None)
    return Report(
        name="summary",
        title=f"Sweep of {robot_name(summary.evaluation.landings.robot)}",
        page="summary",
        body=lambda full: _body(summary, None if full else STRONGEST),
        sheets=sheets,
        document=lambda: _document(summary),
        tables=True,
    )


def _body(summary: Summary[VariedLandings], strongest: int | None) -> list[Section]:
    """The sections. Args: strongest, rows of correlations; None for all."""
    sections: list[Section] = [*_unknowns(summary)]
    sections.append(_sheet(summary).without("most_severe", "least_severe"))
    if summary.varied:
        sections.append(_correlations(summary, strongest))
    figure = "studies.sweep.figure:draw_sweep"
    sections.append(Picture("sweep", "results over the sweep", figure, (summary,)))
    lines = [*_extreme_lines(summary), *sweep_warnings(summary), *_computed_lines(summary)]
    return [*sections, Lines(lines, whole=True)]


def _document(summary: Summary[VariedLandings]) -> dict[str, Any]:
    """The entries of the document that are no tables."""
    landings = summary.evaluation.landings
    worst = _most_severe_landing(summary)
    messages = []
    for cause in summary.messages:
        messages.append({"text": cause.text, "rows": cause.rows, "first": cause.first})
    return {
        "robot": landings.robot.name,
        "scene": landings.scene,
        "unknowns": [] if worst is None else worst.unknowns,
        "rows": summary.rows,
        **record(summary, "failed", "proven", "compared", "largest_error"),
        "not_feasible": summary.refused._asdict(),
        "messages": messages,
    }


def _sheet(summary: Summary[VariedLandings]) -> Sheet:
    """One row for each quantity at each place: its range, where the ends are, and their options.

    The range of a sample has percentiles.
    """
    landings = summary.evaluation.landings
    rows: list[Row] = []
    for extent in summary.extents:
        low, *high = extent.percentiles
        row_of_least = row_of_greatest = most_severe = least_severe = None
        if extent.greatest_row >= 0:
            row_of_least, row_of_greatest = extent.least_row, extent.greatest_row
            most_severe, _ = row_options(landings, extent.most_severe_row)
        if extent.has_best:
            least_severe, _ = row_options(landings, extent.best_row)
        numbers = extent.least, low, extent.median, *high, extent.greatest
        ends = row_of_least, row_of_greatest, most_severe, least_severe
        rows.append((extent.column.name, extent.column.unit, *numbers, *ends))
    shares = [Heading(f"percentile_{share:g}", f"{share:g} %") for share in PERCENTILES]
    header: list[str | Heading] = ["quantity", "unit", "minimum", shares[0], "median", *shares[1:]]
    header += ["maximum", "row of minimum", "row of maximum", "most severe", "least severe"]
    title = f"sweep of {robot_name(landings.robot)}: {summary.rows} landings"
    sheet = Sheet(title, header, rows)
    if landings.sample is None:
        return sheet.without(*(share.key for share in shares))
    return sheet


def _correlations(summary: Summary[VariedLandings], most: int | None) -> Sheet:
    """One row for each quantity that was varied: its rank correlation with each result.

    Args: most, rows of the strongest.
    """
    rows: list[Row] = []
    for varied, correlations in zip(summary.varied, summary.correlations, strict=True):
        rows.append((varied.column, *map(float, correlations)))
    header: list[str | Heading] = ["rank correlation of"]
    for extent in summary.extents:
        header.append(Heading(extent.column.name, f"with {extent.column.name}"))
    strongest = np.abs(np.nan_to_num(summary.correlations)).max(axis=1, initial=0.0)
    sheet = Sheet("what the results depend on", header, rows)
    sheet = sheet.largest(most, "varied quantity", strongest.tolist())
    chance = (
        f"of {summary.ranked} landings; independent columns reach up to {summary.chance:.2g} by "
        "chance"
    )
    return sheet._replace(notes=(chance, *sheet.notes))


def _extreme_lines(summary: Summary[VariedLandings]) -> Iterator[str]:
    """The most and the least severe landings as options of `shockpc analyze`."""
    landings = summary.evaluation.landings
    for extent in summary.extents:
        name = extent.column.name
        if extent.greatest_row >= 0:
            severity = "most severe"
            if extent.column.selection.quantity.worse == "neither":
                severity = "largest value"
            yield f"{severity} for {name}: {row_text(landings, extent.most_severe_row)}"
        if extent.has_best:
            options = row_text(landings, extent.best_row)
            yield f"least severe that flat ground allows: {options}"


def _computed_lines(summary: Summary[VariedLandings]) -> Iterator[str]:
    """Lines on what was not computed, and on the accuracy."""
    if summary.failed:
        yield f"not computed: {summary.failed} of {summary.rows} landings"
        named = [cause._replace(first=f"row {cause.first}") for cause in summary.messages]
        for line in cause_lines(named, "rows", MESSAGES):
            yield f"  {line}"
    columns = [extent.column for extent in summary.extents]
    yield from proof_lines(summary.proven, summary.compared, summary.largest_error, columns)


def _unknowns(summary: Summary[VariedLandings]) -> list[Lines]:
    """The assumptions of the landings, as of the most severe; none where none was computed."""
    worst = _most_severe_landing(summary)
    if worst is None:
        return []
    lines = unknown_lines([worst])
    soles = []
    for contact in summary.evaluation.landings.first.scene.contact:
        if contact.kind in CARRIES:
            soles.append(f"{contact.frame}: {CARRIES[contact.kind]}")
    if soles:
        taken = "which carries in the landing of the scene, and is taken for all rows"
        lines.append(("soles", printable(f"{'; '.join(soles)}, {taken}")))
    return [Lines(lines)]


def _most_severe_landing(summary: Summary[VariedLandings]) -> ShockProfile | None:
    """The landing with the most severe value of the first quantity that has one; else None."""
    for extent in summary.extents:
        if extent.greatest_row >= 0:
            return profile_of_scene(*summary.evaluation.landings.case(extent.most_severe_row))
    return None
