"""Paths as users write them, checked first, and the one function that opens a file."""

import os
import stat
from pathlib import Path
from typing import BinaryIO, TypeAlias

LARGEST_FILE = 64 * 2**20
"""Bytes of the largest file that is read."""

Inputs: TypeAlias = dict[tuple[int, int], str]

inputs: Inputs = {}
"""The files that the command has read, by device and inode; no output may replace one."""


def usable_path(text: str) -> Path:
    """A path with `~` expanded, if a file or folder can have it.

    Args:
        text: as written; relative paths stay relative.

    Raises:
        ValueError: it is empty, begins with the home of an unknown user, is relative to a folder
            that no longer exists, or is not UTF-8 (a JSON document could not hold it).
    """
    if not text:
        raise ValueError("the path is empty; give a name")
    expanded = os.path.expanduser(text)
    if expanded.startswith("~"):
        raise ValueError(
            f'"{text}" begins with the home of a user whom this computer does not have; give the '
            f"folder itself"
        )
    try:
        absolute = os.path.abspath(expanded)
    except FileNotFoundError:
        raise ValueError("the current folder no longer exists; change to another one") from None
    try:
        absolute.encode("utf-8")
    except UnicodeEncodeError:
        shown = os.fsencode(absolute).decode("utf-8", "backslashreplace")
        raise ValueError(f'"{shown}" is not UTF-8; rename that file or folder') from None
    return Path(expanded)


def read_file(path: Path, kind: str, error: type[Exception], *, output: bool = False) -> bytes:
    """Read a whole file.

    What users name, or what such a file names, is read here or opened by `open_file`.

    Args:
        path: of the file.
        kind: of file, such as "scene file", for messages.
        error: the kind of error that is raised.
        output: whether it is an output of an earlier run, which this one may replace.

    Raises:
        error: as `open_file`; or it is larger than 64 MB, or reading fails.
    """
    with open_file(path, kind, error, output=output) as file:
        size = os.fstat(file.fileno()).st_size
        if size <= LARGEST_FILE:
            try:
                return file.read(LARGEST_FILE + 1)
            except OSError as refusal:  # a damaged disk, or a file of /proc
                raise error(f'"{path}" cannot be read: {refusal.strerror}') from None
    raise error(
        f'"{path}" has {size / 2**20:.0f} MB; files of up to {LARGEST_FILE // 2**20} MB are read'
    )


def open_file(path: Path, kind: str, error: type[Exception], *, output: bool = False) -> BinaryIO:
    """Open a file to read it, and remember that no output may replace it.

    The arguments are those of `read_file`.

    Raises:
        error: it is missing, a folder, not readable or not a regular file.
    """
    try:
        # Without O_NONBLOCK a pipe that nobody writes to would be waited for.
        number = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
    except FileNotFoundError:
        where = "" if path.is_absolute() else f" (looked in {Path.cwd()})"
        raise error(f'no {kind} "{path}"{where}') from None
    except OSError as refusal:
        raise error(f'"{path}" cannot be read: {refusal.strerror}; check its permissions') from None
    except ValueError:
        raise error(
            f'"{path}" is not a valid path: it holds a NUL character'.replace("\0", "\\0")
        ) from None
    status = os.fstat(number)
    if not stat.S_ISREG(status.st_mode):
        os.close(number)
        if stat.S_ISDIR(status.st_mode):
            raise error(f'"{path}" is a folder; give the {kind} in it')
        raise error(f'"{path}" is a pipe or a device; save what it gives in a file')
    if not output:
        inputs.setdefault((status.st_dev, status.st_ino), kind)
    return os.fdopen(number, "rb")


def is_path(text: str) -> bool:
    """True if what may be a file or a name is a file: it has a separator or a suffix."""
    return os.sep in text or bool(Path(text).suffix)
