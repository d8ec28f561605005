"""Standard output and standard error, whatever state the caller left them in."""

import contextlib
import io
import os
import sys
from typing import Any, TextIO

from shockpc.errors import OutputError
from shockpc.printed import message

__all__ = ["complain", "deliver", "prepare_streams"]


class _Lenient(io.FileIO):
    """A file whose failed writes are ignored."""

    def write(self, data: Any) -> int:
        """Write what can be written."""
        with contextlib.suppress(OSError):
            super().write(data)
        return len(data)


def prepare_streams() -> None:
    """Make standard error safe to write to, and keep the numbers of closed streams from being given to other files.

    A message that nobody can receive, because standard error is closed, full or a pipe without a reader, must not change how a
    command ends.
    """
    for number in (0, 1, 2):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # the lowest free number, which is this one
    sys.stderr = io.TextIOWrapper(
        io.BufferedWriter(_Lenient(2, "w", closefd=False)), encoding="utf-8", errors="backslashreplace", line_buffering=True
    )


def complain(text: str) -> None:
    """One message on standard error, on one line whatever the names in it hold."""
    sys.stderr.write(f"shockpc: {message(text)}\n")


def deliver(text: str) -> None:
    """Write to standard output, in UTF-8 whatever the terminal's encoding: a JSON document is the same bytes everywhere.

    Raises:
        OutputError: it cannot be written, because the disk is full for example. A pipe without a reader (… | head) is no error.
    """
    out: TextIO | None = sys.stdout
    if out is None:
        raise OutputError("standard output is closed; open it, or write files with --out")
    if isinstance(out, io.TextIOWrapper):
        out.reconfigure(encoding="utf-8", errors="backslashreplace")
    try:
        out.write(text)
        out.flush()
    except OSError as refusal:
        # Python must not try again at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), out.fileno())
        if not isinstance(refusal, BrokenPipeError):
            raise OutputError(f"standard output cannot be written: {refusal.strerror}") from None
