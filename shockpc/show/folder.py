"""The folder of a report: its files, with the page report.html where it can be made."""

from collections.abc import Callable
from pathlib import Path

from shockpc.show.files import write_folder
from shockpc.show.html import plotly
from shockpc.show.html.page import page
from shockpc.show.report import Report

PAGE = "report.html"


def report_files(
    report: Report,
    command: str = "",
    warn: Callable[[str], None] | None = None,
    folder: Path = Path(),
    pdf: bool = False,
) -> dict[str, str | bytes]:
    """The files of a report by name. One of landings has no page where Plotly is not installed.

    Args:
        report: the result.
        command: the command line that made it.
        warn: is called with the reason why the page cannot be made, and the other files are still
            made; without it the error is raised.
        folder: in which they are written.
        pdf: whether figures are written as PDF too.
    """
    files, library = report.files(folder, pdf), plotly() if report.landings else None
    if report.landings and library is None:
        return files
    try:
        return {**files, PAGE: page(report, files, library, command)}
    except (MemoryError, ArithmeticError, ValueError) as failure:
        if warn is None:
            raise
        reason = (
            "the memory of this computer does not suffice"
            if isinstance(failure, MemoryError)
            else str(failure)
        )
        warn(f"{PAGE} cannot be made: {reason}; the other files are complete")
        return files


def write_report_folder(
    folder: Path,
    report: Report,
    command: str = "",
    warn: Callable[[str], None] | None = None,
    pdf: bool = False,
) -> None:
    """Write the files of a report into a folder.

    Those of the command's last run that this one lacks are removed.

    Args:
        folder: is made if it does not exist.
        report: the result.
        command: the command line that made it.
        warn: is called with the reason why the page cannot be made.
        pdf: whether figures are written as PDF too.

    Raises:
        OutputError: as `write_folder`.
    """
    write_folder(folder, report_files(report, command, warn, folder, pdf), report.name)
