"""The `shockpc` command: runs the command line and ends with its exit code.

The library's root error is caught here, once.
"""

import contextlib
import errno
import gc
import io
import os
import re
import sys
import warnings
from collections.abc import Sequence
from typing import TextIO

from shockpc.cli.completion import ASKED, words_typed
from shockpc.cli.process import command, prepare, print_error, received, write_stdout
from shockpc.quantities.renamed import RenamedQuantity
from shockpc.text.arguments import typed
from shockpc.text.diagnostic import ShockWarning
from shockpc.text.errors import DefectError, ShockError, SolveError
from shockpc.text.paths import inputs
from shockpc.text.printed import visible

DEFECT = 70
"""An error in shockpc itself, as EX_SOFTWARE of sysexits.h: Python's code would be 1, which means
that a budget is exceeded.
"""
INTERRUPTED = 130
"""Also what Typer returns, without a message, when a command raises KeyboardInterrupt."""
NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.ENOENT)
"""Errors without a file's name: no folder takes temporary files, or the disk is full."""


def entry() -> None:
    """Run the command line and end the process with its exit code."""
    prepare()
    # Threads of the linear algebra library take a third of a short run, and small matrices gain
    # nothing from them.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # Most functions of a library are never called; to look up the addresses of all takes a fortieth
    # of a short run.
    sys.setdlopenflags(os.RTLD_LAZY)
    # Figures need no backend, and matplotlib refuses to be imported where the environment names an
    # unknown one.
    os.environ.pop("MPLBACKEND", None)
    # Libraries make many objects while they are imported, none of them garbage; searching them
    # takes a twentieth of a short run.
    gc.set_threshold(100_000)
    # A result that is not finite is refused or reported where it arises; NumPy's warnings about it
    # are misleading here.
    warnings.simplefilter("ignore")
    # CPython maps memory for frames in pieces of 16 kB, and unmaps a piece that is left: a loop at
    # its end does both in each round. A frame that is larger gets a larger piece, in which those of
    # all that is called from it lie.
    main.__code__ = main.__code__.replace(co_stacksize=16_000)
    code = main(sys.argv[1:])
    for stream in filter(None, (sys.stdout, sys.stderr)):
        stream.flush()
    # All output is written. Finalising the libraries would take a seventh of a short run, and can
    # change the exit code.
    os._exit(code)


def main(words: Sequence[str]) -> int:
    """Run a command and return its exit code.

    What a command prints is kept until it has ended, so that one which fails prints its message and
    nothing else.
    """
    if ASKED in os.environ:
        return _complete()
    printed = io.StringIO()
    inputs.clear()
    command[:] = ["shockpc", *words]
    try:
        from shockpc.cli.app import app_for

        if words and words[0] == "help":
            named = [word for word in words[1:] if word != "help"]
            words = command[1:] = [*named, "--help"]
        # What a command reports holds the warnings of its landings.
        with contextlib.redirect_stdout(printed), warnings.catch_warnings():
            warnings.simplefilter("ignore", ShockWarning)
            _report_renamed()
            try:
                code: int = (
                    app_for(words)(
                        list(words) or ["--help"], standalone_mode=False, prog_name="shockpc"
                    )
                    or 0
                )
            except SystemExit as done:  # of Typer's options for the completion of shells
                code = int(done.code or 0)
        if code != INTERRUPTED:
            write_stdout(printed.getvalue())
            return code
    except KeyboardInterrupt:
        pass
    except Exception as error:
        # An import that is interrupted may raise another error than KeyboardInterrupt.
        if not received:
            message, code = _failure(error, words)
            print_error(message)
            return code
    finally:
        typed.clear()
    print_error("interrupted; no incomplete file was left")
    # As shells count: 130 after Ctrl-C and 143 after SIGTERM.
    return 128 + received[0] if received else INTERRUPTED


def _report_renamed() -> None:
    """Print each former name of a quantity once on standard error.

    It does so until Python's warnings are restored.
    """
    reported: set[str] = set()
    show_other = warnings.showwarning

    def show(
        message: Warning | str,
        category: type[Warning],
        filename: str,
        lineno: int,
        file: TextIO | None = None,
        line: str | None = None,
    ) -> None:
        if not issubclass(category, RenamedQuantity):
            show_other(message, category, filename, lineno, file, line)
        elif str(message) not in reported:
            reported.add(str(message))
            print_error(f"warning: {message}")

    warnings.simplefilter("always", RenamedQuantity)
    warnings.showwarning = show


def _complete() -> int:
    """Print the completions of what is typed so far, for a shell, and return the exit code."""
    from shockpc.cli.app import app_for

    # bash breaks --option=value into three words, which are one to what reads them
    broken = os.environ.get("COMP_WORDS")
    if broken:
        words = re.sub(r"\s+=\s*", "=", broken)
        fewer = len(broken.split()) - len(words.split())
        os.environ["COMP_WORDS"] = words
        os.environ["COMP_CWORD"] = str(int(os.environ["COMP_CWORD"]) - fewer)
    # Rich breaks the help of an option into lines, each of which fish takes for a completion
    os.environ["COLUMNS"] = "10000"
    try:
        app_for(words_typed()[:1])([], standalone_mode=False, prog_name="shockpc")
    except SystemExit as done:
        return int(done.code or 0)
    return 0


def _failure(error: Exception, words: Sequence[str]) -> tuple[str, int]:
    """The message about an error, and the exit code."""
    if hasattr(error, "format_message"):  # Typer's errors in how a command was typed
        from shockpc.cli.options import instead_of

        option = getattr(error, "option_name", "")
        instead = instead_of(option)
        if instead:
            return f"{option} is not an option; {instead}", ShockError.exit_code
        form = getattr(getattr(error, "param", None), "metavar", None) or ""
        hint = f" (it takes {form})" if any(sign in form for sign in "=,:") else ""
        return _usage(error.format_message() + hint, words), ShockError.exit_code
    if isinstance(error, DefectError):
        sys.stderr.write(visible(error.trace, "\n"))
    if isinstance(error, ShockError):
        return str(error), error.exit_code
    if isinstance(error, OSError) and error.filename is not None:
        return f'"{error.filename}" cannot be used: {error.strerror}', ShockError.exit_code
    if isinstance(error, OSError) and error.errno in NO_ROOM:
        return (
            f"a temporary file cannot be written: {error.strerror}; free space, or set TMPDIR",
            ShockError.exit_code,
        )
    if isinstance(error, MemoryError):
        return (
            "the memory of this computer does not suffice; give fewer values or joints",
            SolveError.exit_code,
        )
    import traceback

    sys.stderr.write(visible("".join(traceback.format_exception(error)), "\n"))
    return (
        "this is an error in shockpc itself, not in your input; please report the lines above",
        DEFECT,
    )


def _usage(text: str, words: Sequence[str]) -> str:
    """An error in how a command was typed, with the command that lists what is valid."""
    from shockpc.cli.app import COMMANDS

    stop = "" if text.endswith((".", "?")) else "."
    robot = (
        " To analyze a robot: shockpc analyze ROBOT --contact NAME."
        if text.startswith("No such command")
        else ""
    )
    command = " ".join(["shockpc", *(word for word in words[:1] if word in COMMANDS)])
    return f"{text[:1].lower()}{text[1:]}{stop}{robot} To see what is valid: {command} --help"
