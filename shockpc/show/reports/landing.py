"""The results of landings: everything of each, and their shocks side by side where there are several."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from shockpc.result import ShockProfile
from shockpc.show.document import document
from shockpc.show.files import write_folder
from shockpc.show.header import contact_name, header_lines
from shockpc.show.reports.report import Report
from shockpc.show.tables.design import balance_lines, bracket_sheet, directions_sheet, loads_sheet
from shockpc.show.tables.sheets import Sheet, accuracy_line, bodies_sheet, contacts_sheet, points_sheet, summary_sheet
from shockpc.show.tables.text import as_csv, as_markdown, as_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["landing_report", "landings_text", "write_landings"]


def landing_report(profile: ShockProfile, pattern: str | None = None) -> Report:
    """Everything of one landing; of the bodies only those that match a pattern.

    The files are profile.json, bodies.csv, points.csv, contacts.csv, report.md, shock.svg and shock.png.
    """

    def draw() -> "Figure":
        from shockpc.show.figure.landing import draw_landing

        return draw_landing(profile)

    return Report(
        name="profile",
        title=f"Shock of {profile.robot.name} landing on {contact_name(profile)}",
        header=header_lines(profile),
        tables=lambda most: _tables(profile, pattern, most),
        short=6,
        closing=_closing(profile),
        sheets={
            "bodies": lambda: bodies_sheet(profile, pattern, fold=False),
            "points": lambda: points_sheet(profile),
            "contacts": lambda: contacts_sheet(profile),
        },
        document=lambda: document(profile),
        picture="shock",
        caption=f"shock profile of {profile.robot.name}",
        draw=draw,
    )


def landings_text(profiles: Sequence[ShockProfile], format_: str, pattern: str | None = None) -> str:
    """Some landings in a format, "table", "markdown" or "csv"; of the bodies only those that match a pattern."""
    if format_ == "csv":
        sheets = [(contact_name(profile), bodies_sheet(profile, pattern, fold=False)) for profile in profiles]
        rows = [(name, *row) for name, sheet in sheets for row in sheet.rows]
        return as_csv(Sheet("", ("contact", *sheets[0][1].header), rows))
    blocks = [landing_report(profile, pattern).text(format_) for profile in profiles]
    if len(profiles) > 1:
        blocks.append((as_markdown if format_ == "markdown" else as_text)(summary_sheet(profiles, pattern)))
    return "\n".join(blocks)


def write_landings(profiles: Sequence[ShockProfile], names: Sequence[str], folder: Path, pattern: str | None = None) -> None:
    """Write one landing into a folder; several into a subfolder each, with a summary beside them.

    Args:
        profiles: the landings.
        names: of the subfolders.
        folder: made if it does not exist; files of an earlier run that this one does not write are removed.
        pattern: only bodies that match it are in bodies.csv and report.md.

    Raises:
        OutputError: the folder cannot be written.
    """
    every = [landing_report(profile, pattern).files() for profile in profiles]
    if len(every) == 1:
        write_folder(folder, every[0])
        return
    files = {f"{name}/{file}": content for name, own in zip(names, every, strict=True) for file, content in own.items()}
    summary = summary_sheet(profiles)
    write_folder(folder, files | {"summary.csv": as_csv(summary), "summary.md": as_markdown(summary)})


def _tables(profile: ShockProfile, pattern: str | None, most: int | None) -> list[Sheet]:
    """Points, joint models and loads only where there are any, long tables cut to their largest rows."""
    points, loads = points_sheet(profile), loads_sheet(profile, most)
    return [
        bodies_sheet(profile, pattern),
        *([points] if points.rows else []),
        contacts_sheet(profile),
        *([bracket_sheet(profile)] if profile.robot.joint_names else []),
        directions_sheet(profile, most),
        *([loads] if loads.rows else []),
    ]


def _closing(profile: ShockProfile) -> list[str]:
    """Energy and effective masses, the rank of the contact rows, warnings, and the accuracy in the last line."""
    rows = f"contact rows: {profile.health.rank} of {profile.health.rows} independent"
    warnings = [f"warning: {warning}" for warning in profile.health.warnings]
    return [*balance_lines(profile), rows, *warnings, accuracy_line(profile)]
