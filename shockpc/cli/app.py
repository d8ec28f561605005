"""The command line's grammar: its commands, their options and their help."""

import importlib
import re
import sys
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NoReturn

from shockpc import __version__
from shockpc.cli.declare import ARGUMENTS, Command, Help, Parameter
from shockpc.cli.options import EVERYBODY, PANELS, RARE, RARE_OF_RUN
from shockpc.text.errors import StudyError

GROUPS = {
    "Begin": {"guide": "Read how to use shockpc, by topic."},
    "Look at a robot": {"robots": "List the robots known by name, or check and show one."},
    "One landing": {"analyze": "Compute the shock of a landing on every body of a robot."},
    "Many landings": {
        "batch": "Land many robots on each of their feet, and rank them.",
        "sweep": "Compute landings over many postures, strikes and models.",
        "fall": "Let a robot tip over, or drop it, and rank what strikes.",
    },
    "Decide": {
        "compare": "Compare the shock of designs, or of a design's changes.",
        "improve": "Find the posture, strike or design with the least shock.",
        "limits": "Find joint angles that keep a number below or above a bound.",
        "place": "Find where on a body a sensor sees least shock.",
        "sensitivity": "Rank masses, inertias and angles by their effect on a number.",
        "check": "Compare landings with budgets, as a gate in CI.",
    },
    "Data": {
        "touchdowns": "Find the touchdowns of a log: the table of its landings.",
        "landings": "Compute recorded landings, and compare what was measured.",
        "identify": "Find drives, friction and masses from measured landings.",
    },
    "For developers": {
        "quantities": "List the numbers that a landing has.",
        "schema": "Print the JSON Schema of scenes, or of budgets, for editors.",
        "bench": "Measure the error and the run time of several methods.",
        "paper": "Recompute the figures of the paper and check its claims.",
    },
}
"""What each command does. It is the function of its name in the module of that name, else a study's as `study_command` makes it."""

COMMANDS = {name: summary for commands in GROUPS.values() for name, summary in commands.items()}

ABOUT = """Mechanical shock of a legged robot's landing, body by body, from the rigid-body model alone.

\b
A first landing, and what its results mean in report.html:
  shockpc analyze anymal_b --contact LF_FOOT --out out/"""

EXIT_CODES = """\b
Exit codes: 0 done, 1 a budget is exceeded (check), 2 bad arguments or files,
3 no verdict (the posture is singular, or the model has no unique solution),
70 an error in shockpc itself, 130 interrupted by Ctrl-C, 143 terminated by
SIGTERM."""

HELP, HELP_ALL = {"-h", "--help"}, "--help-all"
GENERAL = {"-h, --help": "Show this message and exit."}

WIDEST, LONGEST = 110, 30
"""Columns of the help on a wide terminal; letters of an option beyond which its text begins below it."""


def run_command(words: Sequence[str]) -> int:
    """Run what was typed, or print help. A command is imported alone, because each takes time.

    Returns: the exit code.

    Raises:
        StudyError: there is no such command, or its options do not allow what was typed.
        ShockError: the command fails.
    """
    name, *typed = words or ["--help"]
    if name == "--version":
        sys.stdout.write(f"shockpc {__version__}\n")
    elif name in HELP:
        sys.stdout.write(_overview())
    elif name not in COMMANDS:
        if name.startswith("-"):
            _refuse(f"no such option: {name}")
        robot = "To analyze a robot: shockpc analyze ROBOT --contact NAME"
        _refuse(f'no such command "{name}"{_nearest(name, COMMANDS)}. {robot}')
    else:
        command = _command(name)
        if HELP.isdisjoint(typed) and HELP_ALL not in typed:
            return command(**_read(name, vars(command)["parameters"], typed)) or 0
        sys.stdout.write(_help(name, command, HELP_ALL in typed))
    return 0


def _command(name: str) -> Command:
    """The function that runs a command."""
    if not (Path(__file__).parent / f"{name}.py").exists():
        from shockpc.cli.study import study_command  # which imports the studies

        return study_command(name)
    function: Command = getattr(importlib.import_module(f"shockpc.cli.{name}"), name)
    return function


def _refuse(text: str, *command: str) -> NoReturn:
    raise StudyError(f"{text}. To see what is valid: {' '.join(['shockpc', *command])} --help")


def _nearest(name: str, known: Iterable[str]) -> str:
    """Names that are spelt alike, to end a message."""
    from difflib import get_close_matches

    near = get_close_matches(name, known)
    return f"; nearest: {', '.join(near)}" if near else ""


def _read(command: str, parameters: Sequence[Parameter], words: Sequence[str]) -> dict[str, Any]:
    """What was typed for a command, by parameter: --option VALUE or --option=VALUE, --switch, and words without a name.

    The word after an option is its value whatever it begins with, as in --range -150:0, which argparse does not allow.
    """
    options = {one.flag: one for one in parameters if one.flag}
    typed: dict[str, list[str]] = {one.key: [] for one in parameters}
    unnamed, rest = list[str](), iter(words)
    for word in rest:
        flag, equals, value = word.partition("=")
        if word == "--":
            unnamed += rest
        elif not word.startswith("-"):
            unnamed.append(word)
        elif (one := options.get(flag)) is None:
            _refuse(f"no such option: {flag}{_nearest(flag, options)}", command)
        elif one.is_switch and equals:
            _refuse(f"{flag} takes no value", command)
        elif (text := value if one.is_switch or equals else next(rest, None)) is None:
            _refuse(f"{flag} needs a value", command)
        else:
            typed[one.key].append(text)
    for one in parameters:
        if not one.flag:
            count = len(unnamed) if one.repeats else 1
            typed[one.key], unnamed = unnamed[:count], unnamed[count:]
    if unnamed:
        _refuse(f'unexpected argument "{unnamed[0]}"', command)
    return {one.key: _value(command, one, typed[one.key]) for one in parameters}


def _value(command: str, one: Parameter, texts: Sequence[str]) -> Any:
    """The value of a parameter of a command, by the texts that were typed for it."""
    name, form = one.flag or one.form, one.form or ""
    if not texts:
        if one.needed:
            _refuse(f"{name} is missing", command)
        return () if one.repeats else False if one.kind is bool else one.default
    if one.is_switch:
        return True
    if one.words and not one.parser and texts[-1] not in one.words:
        _refuse(f'{name}: "{texts[-1]}" is not one of {", ".join(one.words)}', command)
    try:
        values = tuple(map(one.parser or str, texts))
    except StudyError as refusal:
        _refuse(f"{name}: {refusal}" + f" (it takes {form})" * any(sign in form for sign in "=,:"), command)
    return values if one.repeats else values[-1]


def _help(name: str, command: Command, whole: bool) -> str:
    """The help of a command, with its options in their groups and which of them repeat.

    Of a scene's options it lists those that everybody uses, with the first sentence of each, unless the whole is asked for.
    """
    parameters: Sequence[Parameter] = vars(command)["parameters"]
    shown: Help = vars(command)["help"]
    keys = {one.key for one in parameters}
    rare = keys & {*RARE, *RARE_OF_RUN} if keys >= RARE else set()
    usage, sections = ["shockpc", name, "[OPTIONS]"], {ARGUMENTS: dict[str, str]()}
    for one in parameters:
        heading, text, key = one.heading, one.help, one.key
        form = one.form or (f"<{'|'.join(one.words)}>" if one.words else "")
        if not one.flag:
            usage.append(form if one.needed or form.startswith("[") else f"[{form}]")
        elif one.repeats:
            text += " May be repeated."
        if rare and not whole and (key in RARE_OF_RUN or (key in RARE and heading in PANELS)):
            continue
        if rare and not whole and heading in PANELS and key.rstrip("_") in EVERYBODY:
            heading, text = "Landing (more with --help-all)", _shortened(one.help)
        sections.setdefault(heading, {})[f"{one.flag} {form}".strip()] = text
    more = {HELP_ALL: f"Show these options and {len(rare)} others, each with all of its text, and exit."}
    sections["Other options"] = GENERAL | (more if rare else {})
    return _page(" ".join(usage), shown.text(COMMANDS[name]), sections, shown.after)


def _overview() -> str:
    """The help without a command: all commands in their groups."""
    sections = {"Options": {"--version": "Print the version.", **GENERAL}, **GROUPS}
    return _page("shockpc COMMAND [OPTIONS] ...", ABOUT, sections, EXIT_CODES)


def _page(usage: str, above: str, sections: Mapping[str, Mapping[str, str]], below: str) -> str:
    """A help: sections of names with a text each, between paragraphs; those that begin with a backspace keep their lines."""
    import shutil

    width = min(shutil.get_terminal_size().columns, WIDEST)

    def paragraphs(text: str) -> str:
        parts = [part[2:] if part.startswith("\b") else textwrap.fill(part, width - 2) for part in text.split("\n\n")]
        return textwrap.indent("\n\n".join(parts), "  ")

    blocks = [f"Usage: {usage}", paragraphs(above)]
    for heading, rows in ((heading, rows) for heading, rows in sections.items() if rows):
        column, lines = min(max(map(len, rows)), LONGEST) + 4, [f"{heading}:"]
        for name, text in rows.items():
            first, *others = textwrap.wrap(text, width - column)
            lines += [f"  {name}", " " * column + first] if len(name) > LONGEST else [f"{f'  {name}':{column}}{first}"]
            lines += [" " * column + line for line in others]
        blocks.append("\n".join(lines))
    return "\n\n".join([*blocks, paragraphs(below)]) + "\n"


def _shortened(text: str) -> str:
    """The first sentence of a help, or what is before its semicolon, with the unit that the help ends with."""
    first = re.split(r"[.;] (?![^\[]*\])", text)[0].removesuffix(".")
    unit = re.search(r" \[[^\]]+\]\.$", text)
    return f"{first}{'' if unit is None or '[' in first else unit[0][:-1]}."
