"""The process of a command: signals and standard streams.

The caller may have left the streams in any state.
"""

import contextlib
import io
import os
import signal
import sys
from typing import Any, TextIO

from shockpc.text.errors import OutputError
from shockpc.text.printed import message, visible

command: list[str] = []
"""The words of the command that runs."""

received: list[int] = []
"""The received signals."""


class _Lenient(io.FileIO):
    """A file whose failed writes are ignored."""

    def write(self, data: Any) -> int:
        """Write what can be written."""
        with contextlib.suppress(OSError):
            super().write(data)
        return len(data)


def prepare() -> None:
    """Let Ctrl-C and SIGTERM unwind a run, and make standard error safe to write to.

    Files that are half written are removed by the unwinding.

    Signals that the caller wants ignored (nohup, or a job in the background) are. A message that
    nobody can receive, because standard error is closed, full or a pipe without a reader, must not
    change how a command ends. The numbers of closed streams are kept from being given to other
    files.
    """
    for number in (signal.SIGINT, signal.SIGTERM):
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _stop)
    for stream in (0, 1, 2):
        try:
            os.fstat(stream)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # the lowest free number, which is this one
    sys.stderr = io.TextIOWrapper(
        io.BufferedWriter(_Lenient(2, "w", closefd=False)),
        encoding="utf-8",
        errors="backslashreplace",
        line_buffering=True,
    )


def _stop(number: int, _: Any) -> None:
    received.append(number)
    raise KeyboardInterrupt


def print_error(text: str) -> None:
    """One message on standard error, on one line whatever the names in it hold."""
    sys.stderr.write(f"shockpc: {message(text)}\n")


def write_stdout(text: str) -> None:
    """Write to standard output, in UTF-8 whatever the terminal's encoding.

    A JSON document is then the same bytes everywhere.

    Raises:
        OutputError: it cannot be written, because the disk is full for example. A pipe without a
            reader (… | head) is no error.
    """
    out: TextIO | None = sys.stdout
    if out is None:
        raise OutputError("standard output is closed; open it, or write files with --out")
    if isinstance(out, io.TextIOWrapper):
        out.reconfigure(encoding="utf-8", errors="backslashreplace")
    try:
        out.write(visible(text, "\n"))
        out.flush()
    except OSError as refusal:
        # Python must not try again at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), out.fileno())
        if not isinstance(refusal, BrokenPipeError):
            raise OutputError(f"standard output cannot be written: {refusal.strerror}") from None
