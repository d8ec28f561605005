"""The results of landings as a folder of files. Nothing here is imported before a folder is requested."""

from collections.abc import Sequence
from pathlib import Path

from shockpc.result import ShockProfile
from shockpc.show.document import to_json
from shockpc.show.figure.landing import landing_figure
from shockpc.show.files import write_folder
from shockpc.show.tables.sheets import bodies_sheet, contacts_sheet, points_sheet, summary_sheet
from shockpc.show.tables.text import as_csv, as_markdown, markdown_report

__all__ = ["write_landings"]


def write_landings(profiles: Sequence[ShockProfile], names: Sequence[str], folder: Path, pattern: str | None = None) -> None:
    """Write one landing into a folder; several into a subfolder each, with a summary beside them.

    The files of a landing are profile.json, bodies.csv, points.csv, contacts.csv, report.md, shock.svg and shock.png.

    Args:
        profiles: the landings.
        names: of the subfolders.
        folder: made if it does not exist; files of an earlier run that this one does not write are removed.
        pattern: only bodies that match it are in bodies.csv and report.md.

    Raises:
        OutputError: the folder cannot be written.
    """
    if len(profiles) == 1:
        write_folder(folder, _files(profiles[0], pattern))
        return
    files: dict[str, str | bytes] = {}
    for profile, name in zip(profiles, names, strict=True):
        files |= {f"{name}/{file}": content for file, content in _files(profile, pattern).items()}
    summary = summary_sheet(list(profiles))
    write_folder(folder, files | {"summary.csv": as_csv(summary), "summary.md": as_markdown(summary)})


def _files(profile: ShockProfile, pattern: str | None) -> dict[str, str | bytes]:
    """The files of one landing by name."""
    return {
        **landing_figure(profile),
        "bodies.csv": as_csv(bodies_sheet(profile, pattern, fold=False)),
        "points.csv": as_csv(points_sheet(profile)),
        "contacts.csv": as_csv(contacts_sheet(profile)),
        "report.md": markdown_report([profile], pattern, figure="shock.svg"),
        "profile.json": to_json([profile]),
    }
