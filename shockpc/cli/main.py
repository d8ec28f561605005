"""The command line: a thin door to the same verbs as the library. Here the root error is caught, once."""

import contextlib
import io
import os
import sys
from collections.abc import Callable
from typing import TextIO

import typer

from shockpc.cli.analyze import analyze
from shockpc.cli.bench import bench
from shockpc.cli.paper import paper
from shockpc.cli.robots import robots
from shockpc.cli.schema import schema
from shockpc.errors import OutputError, ShockError

__all__ = ["app", "main"]

FAULTY = 3
INTERRUPTED = 130

app = typer.Typer(
    help="Mechanical shock of a legged robot's landing, body by body, from the rigid-body model alone.",
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110},
)
COMMANDS: dict[str, Callable[..., None]] = {"analyze": analyze, "bench": bench, "paper": paper, "robots": robots, "schema": schema}
for command in COMMANDS.values():
    app.command()(command)


def main(arguments: list[str] | None = None) -> None:
    """Run a command and leave with its exit code: 0 done, 2 bad arguments or files, 3 no verdict, 130 interrupted.

    What a command prints is kept until it has ended, so that one which fails prints its message and nothing else.
    """
    words = sys.argv[1:] if arguments is None else arguments
    said = io.StringIO()
    try:
        with contextlib.redirect_stdout(said):
            code = app(words or ["--help"], standalone_mode=False, prog_name="shockpc") or 0
        if code == INTERRUPTED:  # typer turns Ctrl-C into this code, and says nothing
            raise KeyboardInterrupt
        _deliver(said.getvalue())
    except typer.TyperException as refusal:
        code = _complain(_usage(refusal, words), ShockError.exit_code)
    except ShockError as refusal:
        code = _complain(str(refusal), refusal.exit_code)
    except (KeyboardInterrupt, typer.Abort):
        code = _complain("interrupted; no file was left half-written", INTERRUPTED)
    except Exception:
        # Python would end with 1, which means that a gate is exceeded.
        import traceback

        traceback.print_exc()
        code = _complain("this is a fault in shockpc itself, not in what you gave it; please report the lines above", FAULTY)
    sys.exit(code)


def _deliver(text: str) -> None:
    """Write to standard output, in UTF-8 whatever the terminal says: a JSON document is the same bytes everywhere.

    Raises:
        OutputError: it takes nothing, on a full disk for example. A reader that has gone (… | head) is no error.
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


def _usage(refusal: Exception, words: list[str]) -> str:
    """A fault in how a command was typed, with the command that says what is valid."""
    text = refusal.format_message() if hasattr(refusal, "format_message") else str(refusal)
    stop = "" if text.endswith((".", "?")) else "."
    command = " ".join(["shockpc", *(word for word in words[:1] if word in COMMANDS)])
    return f"{text[:1].lower()}{text[1:]}{stop} To see what is valid: {command} --help"


def _complain(message: str, code: int) -> int:
    """One message on standard error."""
    sys.stderr.write(f"shockpc: {message}\n")
    return code
