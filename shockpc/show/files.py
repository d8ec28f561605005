"""Files of results: each is complete before it gets its name, and those of an earlier run do not remain beside the new ones."""

import contextlib
import os
from collections.abc import Mapping
from pathlib import Path, PurePosixPath

from shockpc.errors import OutputError
from shockpc.paths import read_file
from shockpc.printed import printable

__all__ = ["MANIFEST", "check_folder", "make_folder", "write_folder", "write_text"]

MANIFEST = ".shockpc-files"
"""In a folder of results: the paths of the files that the last run wrote there, one a line."""


def check_folder(folder: Path, option: str) -> None:
    """Check that the folder of an option can be written, or made, before anything is computed; nothing is left behind.

    Raises:
        OutputError: it is a file, it cannot be made, or nothing may be written in it.
    """
    import tempfile

    _refuse_nul(folder)
    place = folder
    try:
        while not place.exists():
            place = place.parent
        if not place.is_dir():
            what = "is a file" if place == folder else f'would be inside "{place}", which is a file'
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


def write_folder(folder: Path, files: Mapping[str, str | bytes]) -> None:
    """Write the files of a run into a folder, and remove those that an earlier run wrote there and this one does not.

    The folder is made if it does not exist; the contents are given by path relative to it, with slashes.

    Raises:
        OutputError: the folder cannot be written; if a folder has the name of a file, nothing is.
    """
    make_folder(folder)
    for name in files:
        if (folder / name).is_dir():
            raise OutputError(
                f'"{folder / name}" is a folder, but a file has to be written there; move it, or name another with --out'
            )
    earlier = _earlier(folder)
    for name, content in files.items():
        make_folder((folder / name).parent)
        write_text(folder / name, content)
    for path in (folder / name for name in earlier - files.keys()):
        # A folder with other files in it is not removed.
        for remove in (path.unlink, path.parent.rmdir):
            with contextlib.suppress(OSError):
                remove()
    write_text(folder / MANIFEST, "".join(f"{name}\n" for name in files))


def write_text(path: Path, content: str | bytes) -> None:
    """Write a file under a temporary name beside its place and rename it; text is encoded in UTF-8. On failure nothing is left.

    Raises:
        OutputError: it cannot be written.
    """
    import tempfile

    _refuse_nul(path)
    try:
        data = content.encode("utf-8") if isinstance(content, str) else content
    except UnicodeEncodeError:
        raise OutputError(f'"{path}" cannot be written: the name of a file or folder in it is not UTF-8; rename that') from None
    try:
        handle, name = tempfile.mkstemp(prefix=f".{path.stem}.", suffix=path.suffix, dir=path.parent)
        os.close(handle)
        part = Path(name)
        try:
            part.write_bytes(data)
            # mkstemp gives 0600; a result is as readable as any file that its user makes.
            umask = os.umask(0)
            os.umask(umask)
            part.chmod(0o666 & ~umask)
            part.replace(path)
        finally:
            part.unlink(missing_ok=True)
    except OSError as refusal:
        raise OutputError(f'"{path}" cannot be written: {refusal.strerror}') from None


def _earlier(folder: Path) -> set[str]:
    """The files that an earlier run wrote into a folder; none outside it, whatever the list says."""
    try:
        names = read_file(folder / MANIFEST, "file", OutputError).decode().splitlines()
    except (OutputError, UnicodeDecodeError):
        return set()
    inside = {name for name in names if name and not PurePosixPath(name).is_absolute() and ".." not in PurePosixPath(name).parts}
    return {name for name in inside if (folder / name).parent.resolve().is_relative_to(folder.resolve())}


def _refuse_nul(path: Path) -> None:
    """Refuse a path that no file system accepts."""
    if "\0" in str(path):
        raise OutputError(f'"{printable(str(path))}" cannot be the path of a file: it holds a NUL character')
