"""Results as files: each written whole under another name first, then renamed, so that none is ever half there."""

import os
import tempfile
from collections.abc import Callable
from pathlib import Path

from shockpc.errors import OutputError
from shockpc.record import ShockProfile
from shockpc.show.document import to_json
from shockpc.show.sheets import bodies_sheet, contacts_sheet, points_sheet
from shockpc.show.text import as_csv, markdown_report

__all__ = ["make_folder", "write_profile", "write_text", "write_whole"]


def make_folder(folder: Path) -> None:
    """Make an output folder, and see that it can be written before anything is computed.

    Raises:
        OutputError: it cannot be made, or nothing may be written in it.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as refusal:
        raise OutputError(
            f'nothing can be written in folder "{folder}": {refusal.strerror}; name another with --out, or change its permissions'
        ) from None


def write_whole(path: Path, fill: Callable[[Path], None]) -> None:
    """Let `fill` write a file beside its final place, then rename it; on any failure nothing is left.

    Raises:
        OutputError: it cannot be written.
    """
    try:
        handle, name = tempfile.mkstemp(prefix=f".{path.stem}.", suffix=path.suffix, dir=path.parent)
    except OSError as refusal:
        raise OutputError(f'"{path}" cannot be written: {refusal.strerror}') from None
    os.close(handle)
    part = Path(name)
    try:
        fill(part)
        # mkstemp gives 0600; a result is as readable as any file that its user makes.
        umask = os.umask(0)
        os.umask(umask)
        part.chmod(0o666 & ~umask)
        part.replace(path)
    except OSError as refusal:
        raise OutputError(f'"{path}" cannot be written: {refusal.strerror}') from None
    finally:
        part.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Write a text file whole."""
    write_whole(path, lambda part: part.write_bytes(text.encode("utf-8")) and None)


def write_profile(profile: ShockProfile, folder: Path, pattern: str | None = None) -> None:
    """Write one landing: profile.json, bodies.csv, points.csv, contacts.csv, report.md, shock.svg and shock.png.

    Raises:
        OutputError: the folder cannot be written.
    """
    from shockpc.show.figure import save_figure

    make_folder(folder)
    save_figure(profile, folder)
    write_text(folder / "bodies.csv", as_csv(bodies_sheet(profile, fold=False)))
    write_text(folder / "points.csv", as_csv(points_sheet(profile)))
    write_text(folder / "contacts.csv", as_csv(contacts_sheet(profile)))
    write_text(folder / "report.md", markdown_report([profile], pattern, figure="shock.svg"))
    write_text(folder / "profile.json", to_json([profile]))
