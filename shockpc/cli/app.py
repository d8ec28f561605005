"""The command line's grammar: its commands, their options and their help."""

import importlib
import sys
from collections.abc import Sequence
from typing import Annotated, Any

import typer
from typer.core import TyperCommand

from shockpc import __version__
from shockpc.cli.declare import EXIT_CODES, Help

COMMANDS = (
    "analyze", "batch", "bench", "check", "compare", "landings", "limits", "paper", "place", "quantities", "robots", "schema",
    "sensitivity", "sweep",
)  # fmt: skip
"""Each is a function of that name in the module of that name."""


class GroupedCommand(TyperCommand):
    """A command whose help groups its options by their `rich_help_panel`, without a rich-text library, and says which repeat."""

    def collect_usage_pieces(self, ctx: Any) -> list[str]:
        """The parts of the usage line; Typer writes {ROBOT} for an argument that is required."""
        return [piece.strip("{}") for piece in super().collect_usage_pieces(ctx)]

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write the arguments, then one section for each group in order."""
        sections: dict[str, list[tuple[str, str]]] = {"Arguments": []}
        for parameter in self.get_params(ctx):
            heading = (
                "Arguments"
                if parameter.param_type_name == "argument"
                else getattr(parameter, "rich_help_panel", None) or "Other options"
            )
            name, text = parameter.get_help_record(ctx) or ("", "")
            sections.setdefault(heading, []).append((name, text + " May be repeated." * getattr(parameter, "multiple", False)))
        for heading, records in sections.items():
            if records:
                with formatter.section(heading):
                    formatter.write_dl(records)


def app_for(words: Sequence[str]) -> typer.Typer:
    """The command line for these words: if they name a command, it alone is imported and set up, because each takes time."""
    app = typer.Typer(
        help="Mechanical shock of a legged robot's landing, body by body, from the rigid-body model alone.",
        epilog=EXIT_CODES,
        add_completion=False,
        rich_markup_mode=None,
        pretty_exceptions_enable=False,
        context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110},
        callback=_before_the_command,
    )
    named = [word for word in words[:1] if word in COMMANDS]
    for name in named or COMMANDS:
        function = getattr(importlib.import_module(f"shockpc.cli.{name}"), name)
        shown: Help = function.help
        app.command(name, cls=GroupedCommand, help=shown.text, short_help=shown.summary, epilog=shown.after)(function)
    return app


def _show_version(wanted: bool) -> None:
    if wanted:
        sys.stdout.write(f"shockpc {__version__}\n")
        raise typer.Exit


def _before_the_command(
    version: Annotated[bool, typer.Option("--version", help="Print the version.", callback=_show_version, is_eager=True)] = False,
) -> None:
    """Options that stand before the command."""
