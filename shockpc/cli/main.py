"""Run a command; the library's root error is caught here, once, and every run ends with its exit code."""

import contextlib
import io
import os
import sys

from shockpc.cli.signals import interrupted_code, was_interrupted
from shockpc.cli.streams import complain, deliver
from shockpc.errors import ShockError

__all__ = ["main"]

FAULTY = 3
TYPER_INTERRUPTED = 130
"""What Typer returns, without a message, when a command raises KeyboardInterrupt."""


def main(arguments: list[str] | None = None) -> None:
    """Run a command and leave with its exit code.

    What a command prints is kept until it has ended, so that one which fails prints its message and nothing else.
    """
    words = sys.argv[1:] if arguments is None else arguments
    printed = io.StringIO()
    try:
        from shockpc.cli.app import app_for

        with contextlib.redirect_stdout(printed):
            code = app_for(words)(words or ["--help"], standalone_mode=False, prog_name="shockpc") or 0
        if code == TYPER_INTERRUPTED:
            raise KeyboardInterrupt
        deliver(printed.getvalue())
    except KeyboardInterrupt:
        code = _stopped()
    except Exception as error:
        code = _stopped() if was_interrupted() else _failed(error, words)
    sys.exit(code)


def _stopped() -> int:
    """Report that the run was interrupted; the exit code."""
    return _complain("interrupted; no incomplete file was left", interrupted_code())


def _failed(error: Exception, words: list[str]) -> int:
    """Report an error; the exit code."""
    if hasattr(error, "format_message"):  # Typer's errors in how a command was typed
        return _complain(_usage(error.format_message(), words), ShockError.exit_code)
    if isinstance(error, ShockError):
        return _complain(str(error), error.exit_code)
    if isinstance(error, OSError) and error.filename is not None:
        return _complain(f'"{error.filename}" cannot be used: {error.strerror}', ShockError.exit_code)
    if isinstance(error, MemoryError):
        return _complain("the memory of this computer does not suffice; give a robot with fewer joints", FAULTY)
    import traceback

    traceback.print_exception(error)
    # Python's own exit code would be 1, which means that a result exceeds a limit.
    return _complain("this is an error in shockpc itself, not in your input; please report the lines above", FAULTY)


def _usage(text: str, words: list[str]) -> str:
    """An error in how a command was typed, with the command that lists what is valid."""
    from shockpc.cli.app import COMMANDS

    if text.startswith("No such command") and _is_robot(words[0]):
        return f'"{words[0]}" is not a command. To analyze it: shockpc analyze {words[0]} --contact NAME'
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
    """Print a message; the exit code."""
    complain(message)
    return code
