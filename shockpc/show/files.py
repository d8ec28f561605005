"""Files of results: each is complete before it gets its name, and those of an earlier run do not remain beside the new ones."""

import contextlib
import os
from collections.abc import Mapping
from pathlib import Path

from shockpc.errors import OutputError
from shockpc.paths import read_file

__all__ = ["MANIFEST", "check_folder", "write_folder", "write_text"]

MANIFEST = ".shockpc-files"
"""In a folder of results: the paths of the files that the last run wrote there, one a line."""


def check_folder(folder: Path, option: str) -> None:
    """Check that the folder of an option can be written, or made, before anything is computed; nothing is left behind.

    Raises:
        OutputError: it is a file, it cannot be made, or nothing may be written in it.
    """
    import tempfile

    try:
        with tempfile.TemporaryFile(dir=next(place for place in (folder, *folder.parents) if place.exists())):
            pass
    except OSError as refusal:
        raise OutputError(
            f'nothing can be written in folder "{folder}": {refusal.strerror}; '
            f"name another with {option}, or change its permissions"
        ) from None


def write_folder(folder: Path, files: Mapping[str, str | bytes]) -> None:
    """Write the files of a run into a folder, and remove those that an earlier run wrote there and this one does not.

    The contents are given by path relative to the folder, with slashes.

    Raises:
        OutputError: the folder cannot be written; if a folder has the name of a file, nothing is.
    """
    if present := [folder / name for name in files if (folder / name).is_dir()]:
        raise OutputError(f'"{present[0]}" is a folder, but a file has to be written there; move it, or name another with --out')
    try:
        earlier = set(read_file(folder / MANIFEST, "file", OutputError).decode().splitlines())
    except (OutputError, UnicodeDecodeError):
        earlier = set()
    for name, content in files.items():
        write_text(folder / name, content)
    for path in (folder / name for name in earlier - files.keys()):
        # Whatever the list says, nothing outside the folder is removed, and no folder with other files in it.
        if path.parent.resolve().is_relative_to(folder.resolve()):
            for remove in (path.unlink, path.parent.rmdir):
                with contextlib.suppress(OSError):
                    remove()
    write_text(folder / MANIFEST, "".join(f"{name}\n" for name in files))


def write_text(path: Path, content: str | bytes) -> None:
    """Write a file under a temporary name beside its place and rename it; text is encoded in UTF-8. On failure no file is left.

    Raises:
        OutputError: it cannot be written, or a folder above it cannot be made.
    """
    part = path.with_name(f".{path.stem}.{os.urandom(4).hex()}{path.suffix}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            part.write_bytes(content if isinstance(content, bytes) else content.encode("utf-8", "backslashreplace"))
            part.replace(path)
        finally:
            part.unlink(missing_ok=True)
    except OSError as refusal:
        raise OutputError(f'"{path}" cannot be written: {refusal.strerror}') from None
