"""The results of a landing as a folder of files. Nothing here is imported before a folder is asked for."""

from pathlib import Path

from shockpc.errors import OutputError
from shockpc.result import ShockProfile
from shockpc.show.document import to_json
from shockpc.show.figure.landing import save_figure
from shockpc.show.files import make_folder, write_text
from shockpc.show.tables.sheets import bodies_sheet, contacts_sheet, points_sheet
from shockpc.show.tables.text import as_csv, markdown_report

__all__ = ["write_profile"]

FILES = ("profile.json", "bodies.csv", "points.csv", "contacts.csv", "report.md", "shock.svg", "shock.png")


def write_profile(profile: ShockProfile, folder: Path, pattern: str | None = None) -> None:
    """Write one landing: profile.json, bodies.csv, points.csv, contacts.csv, report.md, shock.svg and shock.png.

    Raises:
        OutputError: the folder cannot be written; if a folder has the name of a file, nothing is.
    """
    make_folder(folder)
    for name in FILES:
        if (folder / name).is_dir():
            raise OutputError(f'"{folder / name}" is a folder, where a file has to go; move it, or name another with --out')
    save_figure(profile, folder)
    write_text(folder / "bodies.csv", as_csv(bodies_sheet(profile, pattern, fold=False)))
    write_text(folder / "points.csv", as_csv(points_sheet(profile)))
    write_text(folder / "contacts.csv", as_csv(contacts_sheet(profile)))
    write_text(folder / "report.md", markdown_report([profile], pattern, figure="shock.svg"))
    write_text(folder / "profile.json", to_json([profile]))
