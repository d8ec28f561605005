"""Files: each written whole under another name first, then renamed, so that none is ever half there."""

import os
import tempfile
from collections.abc import Callable
from pathlib import Path

from shockpc.errors import OutputError

__all__ = ["check_folder", "make_folder", "write_text", "write_whole"]


def check_folder(folder: Path, option: str) -> None:
    """See that a folder can be written, or made, before anything is computed; nothing is left behind.

    Args:
        folder: where results are to go.
        option: the option that names it.

    Raises:
        OutputError: it is a file, it cannot be made, or nothing may be written in it.
    """
    _refuse_nul(folder)
    place = folder
    try:
        while not place.exists():
            place = place.parent
        if not place.is_dir():
            what = "is a file" if place == folder else f'would lie in "{place}", which is a file'
            raise OutputError(f'"{folder}" {what}; name a folder with {option}')
        with tempfile.TemporaryFile(dir=place):
            pass
    except OSError as refusal:
        raise OutputError(
            f'nothing can be written in folder "{folder}": {refusal.strerror}; '
            f"name another with {option}, or change its permissions"
        ) from None


def make_folder(folder: Path) -> None:
    """Make an output folder.

    Raises:
        OutputError: it cannot be made.
    """
    _refuse_nul(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as refusal:
        raise OutputError(f'folder "{folder}" cannot be made: {refusal.strerror}') from None


def write_whole(path: Path, fill: Callable[[Path], None]) -> None:
    """Let `fill` write a file beside its final place, then rename it; on any failure nothing is left.

    Raises:
        OutputError: it cannot be written.
    """
    _refuse_nul(path)
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


def _refuse_nul(path: Path) -> None:
    """Refuse a path that no file system accepts."""
    if "\0" in str(path):
        shown = str(path).replace("\0", "\\0")
        raise OutputError(f'"{shown}" cannot be the path of a file: it holds a NUL character')


def write_text(path: Path, text: str) -> None:
    """Write a text file whole, in UTF-8.

    Raises:
        OutputError: it cannot be written.
    """
    try:
        data = text.encode("utf-8")
    except UnicodeEncodeError:
        raise OutputError(f'"{path}" cannot be written: the name of a file or folder in it is not UTF-8; rename that') from None

    def fill(part: Path) -> None:
        part.write_bytes(data)

    write_whole(path, fill)
