"""The table of a check in the summary of a GitHub job."""

import os
from pathlib import Path

from shockpc.show.files import destination
from shockpc.show.tables import as_markdown
from shockpc.studies.check.outcome import Check
from shockpc.studies.check.report import check_sheet
from shockpc.text.errors import OutputError

MOST_ROWS = 500
"""Rows of a summary, whose size GitHub limits to 1 MiB."""


def append_summary(check: Check) -> None:
    """Append the table to the summary of a GitHub job, if the environment names its file.

    Raises:
        OutputError: it cannot be written.
    """
    name = os.environ.get("GITHUB_STEP_SUMMARY")
    if not name:
        return
    text = as_markdown(check_sheet(check, for_terminal=False, most=MOST_ROWS))
    try:
        with destination(Path(name)).open("a", encoding="utf-8") as summary:
            summary.write(f"{text}\n")
    except OSError as refusal:
        raise OutputError(
            f'"{name}", which GITHUB_STEP_SUMMARY names, cannot be written: {refusal.strerror}'
        ) from None
