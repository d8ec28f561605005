"""Paths as users write them, checked before the operating system sees them."""

import os
from pathlib import Path

__all__ = ["usable_path"]

LONGEST_NAME, LONGEST_PATH = 255, 4095
"""Bytes that Linux and macOS allow for one name and for a whole path."""


def usable_path(text: str) -> Path:
    """A path with `~` expanded, if a file or folder can have it.

    Args:
        text: as written; relative paths stay relative.

    Raises:
        ValueError: it is empty, holds a NUL character, names an unknown user's home, is too long or is not UTF-8 (a JSON
            document could not hold it); the text says which.
    """
    if not text:
        raise ValueError("the path is empty; give a name")
    if "\0" in text:
        raise ValueError("the path holds a NUL character, which no file name can; remove it")
    expanded = os.path.expanduser(text)
    user = expanded.split(os.sep)[0]
    if user.startswith("~") and not os.path.lexists(user):
        raise ValueError(f'"{user}" is no user of this computer; give the folder itself')
    try:
        absolute = os.path.abspath(expanded)
    except FileNotFoundError:
        raise ValueError("the current folder no longer exists; change to another one") from None
    if len(os.fsencode(absolute)) > LONGEST_PATH:
        raise ValueError(f"the path is longer than {LONGEST_PATH} bytes; shorten it")
    if any(len(os.fsencode(name)) > LONGEST_NAME for name in absolute.split(os.sep)):
        raise ValueError(f'"{text[:40]}…" holds a name longer than {LONGEST_NAME} bytes, which no file can have; shorten it')
    try:
        absolute.encode("utf-8")
    except UnicodeEncodeError:
        shown = os.fsencode(absolute).decode("utf-8", "backslashreplace")
        raise ValueError(f'"{shown}" is not UTF-8; rename that file or folder') from None
    return Path(expanded)
