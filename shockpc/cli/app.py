"""The command line's grammar: its commands, their options and their help."""

import sys
from collections.abc import Callable
from typing import Annotated

import typer

from shockpc import __version__
from shockpc.cli.analyze import analyze
from shockpc.cli.batch import batch
from shockpc.cli.bench import bench
from shockpc.cli.check import BUDGETS_HELP, check
from shockpc.cli.compare import compare
from shockpc.cli.help import GroupedCommand
from shockpc.cli.limits import limits
from shockpc.cli.paper import paper
from shockpc.cli.place import place
from shockpc.cli.robots import robots
from shockpc.cli.schema import schema
from shockpc.cli.sensitivity import sensitivity
from shockpc.cli.sweep import sweep

__all__ = ["COMMANDS", "app_for"]

COMMANDS: dict[str, Callable[..., None]] = {
    "analyze": analyze,
    "batch": batch,
    "bench": bench,
    "check": check,
    "compare": compare,
    "limits": limits,
    "paper": paper,
    "place": place,
    "robots": robots,
    "schema": schema,
    "sensitivity": sensitivity,
    "sweep": sweep,
}

EXAMPLES = """\b
Examples:
  shockpc analyze anymal_b --contact LF_FOOT --out out/
  shockpc analyze robot.urdf --contact "*_foot" --set "*_knee=-60" --strike-angle 30
  shockpc analyze go2 --contact FL_foot+FR_foot --drop-height 0.3 --armature "*=0.05" --pulse half-sine:5ms

\b
Exit codes: 0 done, 1 a budget is exceeded (check), 2 bad arguments or files, 3 no result (the model has no unique solution),
130 interrupted by Ctrl-C, 143 terminated by SIGTERM.
"""

EPILOGS = {"analyze": EXAMPLES, "check": BUDGETS_HELP}
"""What stands under the help of a command."""


def app_for(words: list[str]) -> typer.Typer:
    """The command line for these words: if they name a command, it alone is set up, because each takes time."""
    app = typer.Typer(
        help="Mechanical shock of a legged robot's landing, body by body, from the rigid-body model alone.",
        epilog=EXAMPLES,
        add_completion=False,
        rich_markup_mode=None,
        pretty_exceptions_enable=False,
        context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110},
        callback=_before_the_command,
    )
    typed = words[:1]
    for name in typed if typed and typed[0] in COMMANDS else COMMANDS:
        app.command(name, cls=GroupedCommand, epilog=EPILOGS.get(name) if typed == [name] else None)(COMMANDS[name])
    return app


def _show_version(wanted: bool) -> None:
    """Print the version and end."""
    if wanted:
        sys.stdout.write(f"shockpc {__version__}\n")
        raise typer.Exit


def _before_the_command(
    version: Annotated[bool, typer.Option("--version", help="Print the version.", callback=_show_version, is_eager=True)] = False,
) -> None:
    """Options that stand before the command."""
