"""The command line's grammar: its commands, their options and their help."""

import importlib
import importlib.util
import inspect
import os
import re
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup, TyperOption

from shockpc import __version__
from shockpc.cli.completion import ASKED, completer
from shockpc.cli.declared import EXIT_CODES, Command, Help, command
from shockpc.cli.options import EVERYBODY, PANELS, RARE, RARE_OF_RUN

PACKAGE = Path(__file__).resolve().parent.parent
GUIDE = PACKAGE / "guide"


def _packages(pattern: str) -> dict[str, str]:
    """Folders with a command or a study, by name, as packages."""
    packages = {}
    for folder in sorted(PACKAGE.glob(pattern)):
        if (folder / "command.py").is_file() or (folder / "study.py").is_file():
            packages[folder.name] = ".".join(("shockpc", *folder.relative_to(PACKAGE).parts))
    return packages


COMMANDS = {
    **_packages("studies/*"),
    **_packages("wings/*"),
    **_packages("wings/*/*"),
    **_packages("bench"),
}
"""The package of each command, which says what it does (`SUMMARY`) and where it is listed
(`HEADING`).

Its command is the function of its name in the module `command`, else that of a study as
`study_command` makes it.
"""

HEADINGS = (
    "Begin",
    "Look at a robot",
    "One landing",
    "Many landings",
    "Decide",
    "Data",
    "For developers",
)


NARROW = 27
"""Characters for the names of options in a short help."""


SHELL_NAMED = "_TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION"
"""The variable with which Typer takes the name of a shell, instead of detecting the shell."""

COMPLETION = {
    "--install-completion": "Install completion for the current shell, or for SHELL.",
    "--show-completion": "Print the script of completion for the current shell, or for SHELL.",
}
"""Typer's options for the completion of shells, with their help here. SHELL may follow them."""


class Commands(TyperGroup):
    """The commands in their groups."""

    def get_params(self, ctx: Any) -> list[Any]:
        """The options, of which those of the completion say that a shell may follow."""
        every: list[Any] = super().get_params(ctx)
        for option in every:
            option.help = COMPLETION.get(option.opts[0], option.help)
        return every

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write a section for each group."""
        packages = {name: importlib.import_module(package) for name, package in COMMANDS.items()}
        for heading in HEADINGS:
            listed = [
                (name, module.SUMMARY)
                for name, module in packages.items()
                if heading == module.HEADING
            ]
            if listed:
                with formatter.section(heading):
                    formatter.write_dl(listed)


class GroupedCommand(TyperCommand):
    """A command whose help groups its options by their `rich_help_panel`, and says which repeat.

    It needs no rich-text library.

    Of a scene's options it lists those that everybody uses, with the first sentence of each, unless
    all are asked for.
    """

    def get_params(self, ctx: Any) -> list[Any]:
        """The parameters, with --help-all where a scene has options."""
        every: list[Any] = super().get_params(ctx)
        names = {parameter.name for parameter in every}
        if "posture" in names and "help_all" not in names:
            number = len(names.intersection(RARE) | names.intersection(RARE_OF_RUN))
            text = f"Show these and {number} other options in full, and exit."
            every.append(
                TyperOption(
                    param_decls=["--help-all"],
                    is_flag=True,
                    is_eager=True,
                    expose_value=False,
                    callback=_show_all,
                    help=text,
                )
            )
        return every

    def collect_usage_pieces(self, ctx: Any) -> list[str]:
        """The parts of the usage line; Typer writes {ROBOT} for an argument that is required."""
        return [piece.strip("{}") for piece in super().collect_usage_pieces(ctx)]

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write the arguments, then one section for each group in order."""
        sections: dict[str, list[tuple[str, str]]] = {"Arguments": []}
        parameters = self.get_params(ctx)
        has_long_help = any(parameter.name == "help_all" for parameter in parameters)
        short = has_long_help and not ctx.meta.get("all")
        if short:
            parameters = _common_first(parameters)
        for parameter in parameters:
            if short and (
                parameter.name in RARE_OF_RUN
                or (parameter.name in RARE and parameter.rich_help_panel in PANELS)
            ):
                continue
            heading = getattr(parameter, "rich_help_panel", None) or "Other options"
            if parameter.param_type_name == "argument":
                heading = "Arguments"
            name, text = parameter.get_help_record(ctx) or ("", "")
            if short and _is_of_everybody(parameter):
                heading, text = "Landing (more with --help-all)", _shortened(text)
            if getattr(parameter, "multiple", False):
                text += " May be repeated."
            sections.setdefault(heading, []).append((name, text))
        for heading, records in sections.items():
            if records:
                with formatter.section(heading):
                    formatter.write_dl(records, col_max=NARROW if short else 30)


def app_for(words: Sequence[str]) -> typer.Typer:
    """The command line for these words.

    If they name a command, it alone is imported and set up, because each takes time.
    """
    named = [word for word in words[:1] if word in COMMANDS]
    if words[1:] and words[0] in COMPLETION:
        os.environ[SHELL_NAMED] = "1"
    app = typer.Typer(
        cls=Commands,
        help="Mechanical shock of a legged robot's landing, body by body, from its rigid-body "
        "model.\n\n\b\nFirst example; out/report.html explains the results:\n"
        "  shockpc analyze anymal_b --contact LF_FOOT --out out/",
        epilog=EXIT_CODES,
        add_completion=not named or ASKED in os.environ,
        rich_markup_mode=None,
        pretty_exceptions_enable=False,
        context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110},
        callback=_before_the_command,
    )
    for name in named or COMMANDS:
        # Without a command, names alone are wanted: for help, and to suggest one that is spelt
        # alike.
        function = _command(name) if named else command(examples=())(lambda: None)
        if ASKED in os.environ:
            for parameter in inspect.signature(function).parameters.values():
                parameter.default.autocompletion = completer(
                    parameter.name, parameter.default.metavar
                )
        shown: Help = vars(function)["help"]
        summary = importlib.import_module(COMMANDS[name]).SUMMARY
        app.command(name, cls=GroupedCommand, help=shown.text(summary), epilog=shown.after)(
            function
        )
    return app


def _command(name: str) -> Command:
    """The function that runs a command."""
    if importlib.util.find_spec(f"{COMMANDS[name]}.command") is None:
        from shockpc.cli.study_command import study_command  # which imports the studies

        return study_command(name, COMMANDS[name])
    function: Command = getattr(importlib.import_module(f"{COMMANDS[name]}.command"), name)
    return function


def _is_of_everybody(parameter: Any) -> bool:
    """True if a parameter is an option of a landing that --help lists."""
    panel = getattr(parameter, "rich_help_panel", None)
    return panel in PANELS and parameter.name.rstrip("_") in EVERYBODY


def _common_first(parameters: Sequence[Any]) -> list[Any]:
    """The parameters, in which the options of a landing have the order of `EVERYBODY`."""
    of_landing = filter(_is_of_everybody, parameters)
    ordered = iter(sorted(of_landing, key=lambda option: EVERYBODY.index(option.name.rstrip("_"))))
    arranged: list[Any] = []
    for parameter in parameters:
        arranged.append(next(ordered) if _is_of_everybody(parameter) else parameter)
    return arranged


def _shortened(text: str) -> str:
    """The first sentence of a help, or what is before its semicolon.

    The unit and the default that the help ends with are kept.
    """
    text, bracket, default = text.partition(" [default: ")
    first = re.split(r"[.;] (?![^\[]*\])", text)[0].removesuffix(".")
    unit = re.search(r" \[[^\]]+\]\.$", text)
    if unit is not None and "[" not in first:
        first += unit[0][:-1]
    return f"{first}.{bracket}{default}"


def _show_all(ctx: Any, option: Any, wanted: bool) -> None:
    if wanted:
        ctx.meta["all"] = True
        sys.stdout.write(ctx.get_help() + "\n")
        ctx.exit()


def _show_version(wanted: bool) -> None:
    if wanted:
        sys.stdout.write(f"shockpc {__version__}\n")
        raise typer.Exit


def _show_citation(wanted: bool) -> None:
    """Print the entries of the guide's page for BibTeX."""
    if wanted:
        page = (GUIDE / "citation.md").read_text(encoding="utf-8")
        _, entries, _ = re.split(r"```(?:bibtex\n)?", page)
        sys.stdout.write(entries)
        raise typer.Exit


def _before_the_command(
    version: Annotated[
        bool,
        typer.Option(
            "--version", "-V", help="Print the version.", callback=_show_version, is_eager=True
        ),
    ] = False,
    cite: Annotated[
        bool,
        typer.Option(
            "--cite",
            help="Print BibTeX entries of the method and of shockpc.",
            callback=_show_citation,
            is_eager=True,
        ),
    ] = False,
) -> None:
    """Options that stand before the command."""
