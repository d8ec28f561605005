"""Paths as users write them, checked before the operating system sees them, and the one function that reads a file."""

import os
import stat
from pathlib import Path

LARGEST_FILE = 64 * 2**20
"""Bytes of the largest file that is read."""

inputs: set[tuple[int, int]] = set()
"""Device and inode of every file that the command has read, which none of its outputs may replace."""


def usable_path(text: str) -> Path:
    """A path with `~` expanded, if a file or folder can have it.

    Args:
        text: as written; relative paths stay relative.

    Raises:
        ValueError: it is empty, begins with the home of an unknown user, is relative to a folder that no longer exists, or is not
            UTF-8 (a JSON document could not hold it).
    """
    if not text:
        raise ValueError("the path is empty; give a name")
    expanded = os.path.expanduser(text)
    if expanded.startswith("~"):
        raise ValueError(f'"{text}" begins with the home of a user whom this computer does not have; give the folder itself')
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


def read_file(path: Path, what: str, error: type[Exception], *, output: bool = False) -> bytes:
    """Read a whole file; every file that users name, or that such a file names, is read here.

    Args:
        path: of the file.
        what: it is, such as "scene file", for messages.
        error: the kind of error that is raised.
        output: whether it is an output of an earlier run, which this one may replace.

    Raises:
        error: it is missing, a folder, not readable, not a regular file, or larger than 64 MB.
    """
    try:
        # Without O_NONBLOCK a pipe that nobody writes to would be waited for.
        with open(os.open(path, os.O_RDONLY | os.O_NONBLOCK), "rb") as file:
            status = os.fstat(file.fileno())
            if stat.S_ISREG(status.st_mode) and status.st_size <= LARGEST_FILE:
                if not output:
                    inputs.add((status.st_dev, status.st_ino))
                return file.read(LARGEST_FILE + 1)
    except FileNotFoundError:
        where = "" if path.is_absolute() else f" (looked in {Path.cwd()})"
        raise error(f'no {what} "{path}"{where}') from None
    except IsADirectoryError:
        raise error(f'"{path}" is a folder; give the {what} in it') from None
    except OSError as refusal:
        raise error(f'"{path}" cannot be read: {refusal.strerror}; check its permissions') from None
    except ValueError:
        raise error(f'"{path}" is no path of a file: it holds a NUL character'.replace("\0", "\\0")) from None
    if stat.S_ISREG(status.st_mode):
        raise error(f'"{path}" has {status.st_size / 2**20:.0f} MB; files of up to {LARGEST_FILE // 2**20} MB are read')
    raise error(f'"{path}" is a pipe or a device; save what it gives in a file')
