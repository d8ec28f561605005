"""The folder of a report: its files, with the page report.html where it can be made."""

from pathlib import Path

from shockpc.show.files import write_folder
from shockpc.show.html import plotly
from shockpc.show.html.page import page
from shockpc.show.reports.report import Report

PAGE = "report.html"


def report_files(report: Report, command: str = "") -> dict[str, str | bytes]:
    """The files of a report by name. One of landings has no page where Plotly is not installed.

    Args:
        report: the result.
        command: the command line that made it.
    """
    files, library = report.files(), plotly() if report.landings else None
    return files if report.landings and library is None else {**files, PAGE: page(report, files, library, command)}


def write_report_folder(folder: Path, report: Report, command: str = "") -> None:
    """Write the files of a report into a folder, and remove those of an earlier run of the command that this one does not have.

    Args:
        folder: is made if it does not exist.
        report: the result.
        command: the command line that made it.

    Raises:
        OutputError: as `write_folder`.
    """
    write_folder(folder, report_files(report, command), (*report.owned, PAGE))
