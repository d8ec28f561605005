"""The report of a batch: a row for each landing, ranked by a quantity.

It has a sheet of pictures where the batch has them.
"""

from collections.abc import Iterator
from typing import Any

from shockpc.show.document import record
from shockpc.show.report import Picture, Report, Section
from shockpc.show.tables import Lines
from shockpc.studies.batch.notes import landing_notes, robot_notes, warning_lines
from shockpc.studies.batch.rows import Batch
from shockpc.studies.batch.tables import (
    landings_sheet,
    robots_sheet,
    sensors_sheet,
    short_landings_sheet,
    short_robots_sheet,
)
from shockpc.text.printed import not_computed

CAUSES = 20
"""Different causes of landings that could not be computed that are shown."""


def batch_report(batch: Batch, every: bool = False) -> Report:
    """The report of the worst landing of each robot, or of every landing.

    The Markdown document also has their warnings.
    """
    return Report(
        name="batch",
        title="Landings of robots",
        body=lambda full: list(_sections(batch, every, full)),
        closing=_failure_lines(batch),
        sheets={
            "batch": lambda: landings_sheet(batch),
            "robots": lambda: robots_sheet(batch),
            "sensors": lambda: sensors_sheet(batch),
        },
        document=lambda: _document(batch),
        tables=True,
    )


def _sections(batch: Batch, every: bool, full: bool) -> Iterator[Section]:
    """The pictures, the table, and in full the warnings."""
    if any(row.picture is not None for row in batch.rows):
        caption = f"the worst landing of each robot, ranked by {batch.rank}"
        yield Picture("sheet", caption, "studies.batch.figure:draw_contact_sheet", (batch,))
    if batch.rows and every:
        yield short_landings_sheet(batch)._replace(notes=list(landing_notes(batch)))
    elif batch.rows:
        yield short_robots_sheet(batch)._replace(notes=list(robot_notes(batch)))
    if full:
        yield Lines(warning_lines(batch))


def _failure_lines(batch: Batch) -> list[str]:
    """A line for each cause why landings were not computed."""
    failures = []
    for failure in batch.failures:
        name = f"{batch.name_of(failure)} {failure.contact}".rstrip()
        failures.append((name, failure.reason))
    return not_computed(failures, "landings", CAUSES)


def _document(batch: Batch) -> dict[str, Any]:
    keys = ("source", "robot", "contact", "scene", "warnings")
    return {"rank": batch.rank, "landings": [record(row, *keys) for row in batch.rows]}
