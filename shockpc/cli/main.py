"""The command line: parses, calls the library, and catches its root error, once."""

import contextlib
import io
import os
import sys
from collections.abc import Callable
from typing import Annotated

import typer

from shockpc import __version__
from shockpc.cli.analyze import analyze
from shockpc.cli.bench import bench
from shockpc.cli.help import GroupedCommand
from shockpc.cli.paper import paper
from shockpc.cli.robots import robots
from shockpc.cli.schema import schema
from shockpc.cli.signals import interrupted_code, was_interrupted
from shockpc.cli.streams import deliver
from shockpc.errors import ShockError

__all__ = ["main"]

FAULTY = 3

COMMANDS: dict[str, Callable[..., None]] = {"analyze": analyze, "bench": bench, "paper": paper, "robots": robots, "schema": schema}

EXAMPLES = """\b
Examples of analyze:
  shockpc analyze anymal_b --contact LF_FOOT --out out/
  shockpc analyze robot.urdf --contact "*_foot" --set "*_knee=-60" --strike-angle 30
  shockpc analyze go2 --contact FL_foot+FR_foot --drop-height 0.3 --armature "*=0.05" --pulse half-sine:5ms

\b
Exit codes: 0 done, 2 bad arguments or files, 3 no result (the model has no unique solution), 130 interrupted by Ctrl-C,
143 terminated by SIGTERM; 1 is kept for limits that a result exceeds.
"""


def main(arguments: list[str] | None = None) -> None:
    """Run a command and leave with its exit code.

    What a command prints is kept until it has ended, so that one which fails prints its message and nothing else.
    """
    words = sys.argv[1:] if arguments is None else arguments
    printed = io.StringIO()
    try:
        with contextlib.redirect_stdout(printed):
            code = _app(words)(words or ["--help"], standalone_mode=False, prog_name="shockpc") or 0
        if code == interrupted_code():  # Typer turns KeyboardInterrupt into 130 without a message
            raise KeyboardInterrupt
        deliver(printed.getvalue())
    except (KeyboardInterrupt, typer.Abort):
        code = _stopped()
    except Exception as error:
        code = _stopped() if was_interrupted() else _failed(error, words)
    sys.exit(code)


def _app(words: list[str]) -> typer.Typer:
    """The command line; of all commands only the one that was typed, because each costs time to set up."""
    app = typer.Typer(
        help="Mechanical shock of a legged robot's landing, body by body, from the rigid-body model alone.",
        epilog=EXAMPLES,
        add_completion=False,
        rich_markup_mode=None,
        pretty_exceptions_enable=False,
        context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110},
        callback=_options,
    )
    for name in words[:1] if words[:1] and words[0] in COMMANDS else COMMANDS:
        epilog = EXAMPLES if name == "analyze" and words[:1] == [name] else None
        app.command(name, cls=GroupedCommand, epilog=epilog)(COMMANDS[name])
    return app


def _show_version(wanted: bool) -> None:
    """Print the version and end."""
    if wanted:
        sys.stdout.write(f"shockpc {__version__}\n")
        raise typer.Exit


def _options(
    version: Annotated[bool, typer.Option("--version", help="Print the version.", callback=_show_version, is_eager=True)] = False,
) -> None:
    """Options that stand before the command."""


def _failed(error: Exception, words: list[str]) -> int:
    """Report an error; the exit code."""
    if isinstance(error, typer.TyperException):
        return _complain(_usage(error, words), ShockError.exit_code)
    if isinstance(error, ShockError):
        return _complain(str(error), error.exit_code)
    if isinstance(error, OSError) and error.filename is not None:
        return _complain(f'"{error.filename}" cannot be used: {error.strerror}', ShockError.exit_code)
    import traceback

    traceback.print_exception(error)
    # Python's own exit code would be 1, which means that a result exceeds a limit.
    return _complain("this is an error in shockpc itself, not in your input; please report the lines above", FAULTY)


def _stopped() -> int:
    """Report that the run was interrupted; the exit code."""
    return _complain("interrupted; no incomplete file was left", interrupted_code())


def _usage(refusal: Exception, words: list[str]) -> str:
    """An error in how a command was typed, with the command that lists what is valid."""
    text = refusal.format_message() if hasattr(refusal, "format_message") else str(refusal)
    if text.startswith("No such command") and _is_robot(words[0]):
        return f'"{words[0]}" is no command. To analyze it: shockpc analyze {words[0]} --contact NAME'
    stop = "" if text.endswith((".", "?")) else "."
    command = " ".join(["shockpc", *(word for word in words[:1] if word in COMMANDS)])
    return f"{text[:1].lower()}{text[1:]}{stop} To see what is valid: {command} --help"


def _is_robot(word: str) -> bool:
    """Whether a word is a robot or a scene, or looks like one."""
    from shockpc.robot.catalogue import find_robot

    if os.sep in word or "." in word:
        return True
    try:
        find_robot(word)
    except ShockError:
        return False
    return True


def _complain(message: str, code: int) -> int:
    """One message on standard error."""
    sys.stderr.write(f"shockpc: {message}\n")
    return code
