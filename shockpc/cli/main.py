"""The command line: a thin door to the same verbs as the library. Here the root error is caught, once."""

import os
import sys

import typer

from shockpc.cli.analyze import analyze
from shockpc.cli.robots import robots
from shockpc.cli.schema import schema
from shockpc.errors import ShockError

__all__ = ["app", "main"]

INTERRUPTED = 130

app = typer.Typer(
    help="Mechanical shock of a legged robot's landing, body by body, from the rigid-body model alone.",
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110},
)
app.command()(analyze)
app.command()(robots)
app.command()(schema)


def main(arguments: list[str] | None = None) -> None:
    """Run a command and leave with its exit code: 0 done, 2 bad arguments or files, 3 no verdict, 130 interrupted."""
    try:
        words = sys.argv[1:] if arguments is None else arguments
        code = app(words or ["--help"], standalone_mode=False, prog_name="shockpc")
        sys.stdout.flush()
    except typer.TyperException as refusal:
        code = _complain(refusal.format_message() if hasattr(refusal, "format_message") else str(refusal), 2)
    except ShockError as refusal:
        code = _complain(str(refusal), refusal.exit_code)
    except (KeyboardInterrupt, typer.Abort):
        code = _complain("interrupted; no file was left half-written", INTERRUPTED)
    except BrokenPipeError:
        # The reader of our output has gone (… | head): nobody is left to tell, and Python must not try again at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        code = 0
    sys.exit(code or 0)


def _complain(message: str, code: int) -> int:
    """One message on standard error."""
    sys.stderr.write(f"shockpc: {message}\n")
    return code
