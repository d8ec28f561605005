"""A sweep: the range of every quantity, and the landings with the most severe values as options of `shockpc analyze`."""

import itertools
import shlex
from collections.abc import Iterator
from typing import Any

from shockpc.show.document import record
from shockpc.show.reports.report import Picture, Report
from shockpc.show.tables import Lines, Row, Sheet
from shockpc.studies.sweep.rows import Sweep
from shockpc.studies.sweep.summary import Extent, SweepSummary

__all__ = ["sweep_report"]

MESSAGES = 5
"""Messages of rows that could not be computed that are shown."""


def sweep_report(summary: SweepSummary) -> Report:
    """The summary of a sweep, whose rows have files of their own."""
    return Report(
        name="summary",
        page="summary",
        body=lambda _: [
            _sheet(summary),
            Picture("sweep", "results over the sweep", "sweep:draw_sweep", (summary,)),
            Lines(list(_lines(summary)), whole=True),
        ],
        sheets={"summary": lambda: _sheet(summary)},
        document=lambda: {
            "robot": summary.sweep.robot.name,
            "scene": summary.sweep.scene,
            "rows": summary.sweep.rows,
            **record(summary, "failed", "proven", "compared", "largest_error"),
            "not_feasible": summary.refused._asdict(),
            "messages": [{"text": text, "rows": count} for text, count in summary.messages],
            "quantities": [_record(summary.sweep, extent) for extent in summary.extents],
        },
    )


def _record(sweep: Sweep, extent: Extent) -> dict[str, Any]:
    """The range of a quantity, and its most severe landing as options of `shockpc analyze`."""
    row = _most_severe(extent)
    return {
        "quantity": extent.column.name,
        "unit": extent.column.selection.quantity.unit,
        **record(extent, "least", "median", "greatest"),
        **{key: getattr(extent, key) if row >= 0 else None for key in ("least_row", "greatest_row")},
        "most_severe": _options(sweep, row)[0] if row >= 0 else None,
    }


def _most_severe(extent: Extent) -> int:
    """The row of the most severe value; that of the greatest one where neither direction is worse."""
    return extent.least_row if extent.column.selection.quantity.worse == "less" else extent.greatest_row


def _sheet(summary: SweepSummary) -> Sheet:
    """One row for each quantity at each place: least, median and greatest value, and where they are."""
    rows: list[Row] = []
    for one in summary.extents:
        places = (str(one.least_row), str(one.greatest_row)) if one.greatest_row >= 0 else (None, None)
        rows.append((one.column.heading, one.least, one.median, one.greatest, *places))
    header = ("quantity", "least", "median", "greatest", "row of least", "row of greatest")
    return Sheet(f"sweep of {summary.sweep.robot.name}: {summary.sweep.rows} landings", header, rows)


def _lines(summary: SweepSummary) -> Iterator[str]:
    """The most severe landings, warnings of what is varied, what was not computed, and the accuracy."""
    for one in summary.extents:
        if one.greatest_row >= 0:
            options, others = _options(summary.sweep, _most_severe(one))
            rest = f"   (and {others})" if others else ""
            what = "greatest value" if one.column.selection.quantity.worse == "neither" else "most severe"
            yield f"{what} for {one.column.name}: {options}{rest}"
        if one.best_row >= 0 and one.column.selection.quantity.worse != "neither":
            options, others = _options(summary.sweep, one.best_row)
            yield f"least severe that level ground allows: {options}" + (f"   (and {others})" if others else "")
    refused, *counts = summary.refused
    if refused:
        causes = ("a contact would have to be pulled", "a contact needs more friction", "another link is below the ground")
        listed = ", ".join(f"{number} because {cause}" for number, cause in zip(counts, causes, strict=True) if number)
        left = "they are left out" if summary.sweep.feasible else "--feasible leaves them out"
        yield f"warning: level ground does not allow {refused} of {summary.sweep.rows} landings: {listed}; {left}"
    yield from (f"warning: {warning}" for warning in summary.sweep.case(0)[1].change_warnings)
    if summary.failed:
        yield f"not computed: {summary.failed} of {summary.sweep.rows} landings"
        yield from (f"  {count} x {text}" for text, count in summary.messages[:MESSAGES])
        if len(summary.messages) > MESSAGES:
            yield f"  and {len(summary.messages) - MESSAGES} other messages, in the column message"
    if summary.proven:
        yield f"proven (ill-conditioned, redundant, or with a quantity that needs it): {summary.proven} landings"
    if summary.compared:
        yield (
            f"double precision, compared with a proof in {summary.compared} other landings: off by at most "
            f"{summary.largest_error:.0e} of the point's most severe shock"
        )


def _options(made: Sweep, row: int) -> tuple[str, str]:
    """What was varied in a row as options of `shockpc analyze`, and what has no option."""
    scene, _ = made.case(row)
    options: list[tuple[str, str]] = []
    others: list[str] = []
    for one, value in made.values_of(row).items():
        if one.kind == "joint":
            options.append(("--set", f"{one.target}={float(value)!r}"))
        elif one.kind == "armature" and value > 0.0:
            options.append(("--armature", f"{one.target}={float(value)!r}"))
        elif one.kind in ("strike-angle", "speed"):
            options.append((f"--{one.kind}", repr(float(value))))
        elif one.kind == "contact":
            options.append(("--contact", str(value)))
        elif one.kind.startswith("base-"):
            options.append(("--base-rpy", ",".join(map(repr, scene.posture.base_rpy_deg or ()))))
        elif one.kind.startswith("offset-"):
            options.append(("--offset", ",".join(map(repr, scene.contact[0].offset))))
        else:
            others.append(f"{one.subject} = {value:g}{' x' if one.factor else f' {one.unit}'}")
    if made.alone:  # where the joints are that close the loops, as they were followed
        options += [("--set", f"{name}={x!r}") for name in scene.assemble if (x := scene.posture.joints_deg.get(name)) is not None]
        options += [("--assemble", name) for name in scene.assemble if name not in made.scene.assemble]
    return shlex.join(itertools.chain.from_iterable(dict.fromkeys(options))), ", ".join(others)
