"""The declaration of commands and options.

A command takes the options that a record's fields or a study's parameters declare.

    @command(examples=("shockpc batch anymal_c go2 solo12",))
    def batch(*, names: tuple[str, ...] = argument("Robots.", "ROBOT...", default=...), options:
    SceneOptions) -> None: …

A parameter that is called like an option of the record, with an underscore after it, takes its
place; the record's is then empty. An option whose type is a tuple of any length may be repeated.
What is not given is the default, else None, False or empty; where the type allows none of these, or
the default is `...`, it has to be given.
"""

import copy
import functools
import inspect
import re
from collections.abc import Callable, Collection
from typing import Any, NamedTuple, TypeAlias, get_args

import typer
from typer.models import OptionInfo

WIDTH = 74
"""Characters of an example on a line of the help."""

Parser: TypeAlias = Callable[[str], Any]
Command: TypeAlias = Callable[..., int | None]

EXIT_CODES = """\b
Exit codes: 0 done, 1 a budget is exceeded (check), 2 bad arguments or files,
3 no verdict (the posture is singular, the model has no unique solution, or
a budget depends on drives that are not known),
70 an error in shockpc itself, 130 interrupted by Ctrl-C, 143 terminated by
SIGTERM.
"""


class Declared(dict[str, tuple[Any, Any]]):
    """Options that a field of a record, or a parameter of a command, collects.

    Values are type and declaration, by name.
    """


class Help(NamedTuple):
    """The help of a command besides its summary and options.

    Attributes:
        examples: command lines.
        more: a paragraph, or nothing.
        after: what stands under the options.
    """

    examples: tuple[str, ...]
    more: str
    after: str

    def text(self, summary: str) -> str:
        """The text above the options, as Typer takes it.

        Args: summary, what the command does.
        """
        return "\n\n".join(
            filter(
                None,
                [summary, self.more, "\n  ".join(["\b\nExamples:", *map(_folded, self.examples)])],
            )
        )


def _folded(line: str) -> str:
    """A command line on several lines of a terminal of 80 columns, as it may be copied."""
    first, *options = re.split(r" (?=--\w)", line)
    lines = [first]
    for option in options:
        if len(lines[-1]) + len(option) < WIDTH:
            lines[-1] += f" {option}"
        else:
            lines.append(f"    {option}")
    return " \\\n  ".join(lines)


def group(heading: str) -> Callable[..., Any]:
    """A function that declares an option which stands under this heading of the help.

    Its arguments are a sentence for the help, the form of the value, a parser, the default, and its
    name if that is not the parameter's.
    """

    def option(
        help_: str,
        form: str | None = None,
        parser: Parser | None = None,
        *,
        default: Any = None,
        name: str | None = None,
    ) -> Any:
        names = () if name is None else (f"--{name}",)
        return typer.Option(
            default,
            *names,
            help=help_,
            metavar=form,
            parser=parser,
            rich_help_panel=heading,
            show_default=False,
        )

    return option


def argument(help_: str, form: str, parser: Parser | None = None, *, default: Any = None) -> Any:
    """Declare what is typed without a name. The arguments are those of an option."""
    return typer.Argument(default, help=help_, metavar=form, parser=parser, show_default=False)


def command(
    *,
    examples: tuple[str, ...],
    more: str = "",
    after: str = "Exit codes: shockpc --help lists them.",
    without: Collection[str] = (),
) -> Callable[[Command], Command]:
    """Make a function a command, which takes the options of records among its parameters.

    They come after the others.

    The text is no docstring, because Python can be told to leave those out.

    Args:
        examples: as in `Help`.
        more: as in `Help`.
        after: as in `Help`.
        without: options of records that it does not take, by their names with underscores, or by
            their headings.
    """

    def declare(function: Command) -> Command:
        run = _taking_options(function, without)
        vars(run)["help"] = Help(examples, more, after)
        return run

    return declare


def _taking_options(command: Command, without: Collection[str]) -> Command:
    """Replace each parameter of a command that is a record of options by the options.

    So is one that is `Declared`.

    Args: as for `command`.
    """
    # The parameters that are records of options, and those that are groups of declared ones.
    records: dict[str, Any] = {}
    grouped: dict[str, Declared] = {}
    for name, parameter in inspect.signature(command).parameters.items():
        if hasattr(parameter.annotation, "_fields"):
            records[name] = parameter.annotation
        elif isinstance(parameter.default, Declared):
            grouped[name] = parameter.default
    declared = _options_of(command, without)

    @functools.wraps(command)
    def run(**typed: Any) -> int | None:
        # Typer gives lists, and the commands take tuples.
        for name, value in typed.items():
            if isinstance(value, list):
                typed[name] = tuple(value)
        # The command has one parameter for each group and each record of options.
        for name, options in grouped.items():
            typed[name] = {option: typed.pop(option, None) for option in options}
        for name, record in records.items():
            kinds = record.__annotations__
            fields: dict[str, Any] = {}
            for field, option in record._field_defaults.items():
                fields[field] = _collected(option, field, kinds[field], typed)
            typed[name] = record(**fields)
        return command(**typed)

    # What Typer reads.
    vars(run)["__signature__"] = inspect.Signature(
        [_for_typer(name, *declaration) for name, declaration in declared.items()]
    )
    # `wraps` copied the annotations of the command, which name records and not their options.
    run.__annotations__ = {}
    return run


def _options_of(command: Command, without: Collection[str]) -> dict[str, tuple[Any, Any]]:
    """Type and declaration of all options of a command, by name.

    Those of a record are left out where a parameter or an earlier record has them. Args: as for
    `command`.
    """
    parameters = inspect.signature(command).parameters
    declared: dict[str, tuple[Any, Any]] = {}
    for name, parameter in parameters.items():
        if isinstance(parameter.default, Declared):
            declared |= parameter.default
        elif not hasattr(parameter.annotation, "_fields"):
            declared[name] = (parameter.annotation, parameter.default)
        else:
            for key, declaration in _options_in(parameter.annotation).items():
                taken = key in declared or f"{key}_" in parameters
                refused = key in without or declaration[1].rich_help_panel in without
                if not taken and not refused:
                    declared[key] = declaration
    return declared


def without_none(kind: Any) -> Any:
    """The type beside None of a union of two; any other type as it is."""
    kinds = get_args(kind)
    others = [part for part in kinds if part is not type(None)]
    return others[0] if len(kinds) == 2 and len(others) == 1 else kind


def _options_in(record: Any) -> dict[str, tuple[Any, Any]]:
    """Type and declaration of the options of a record, by name."""
    options: dict[str, tuple[Any, Any]] = {}
    for field, option in record._field_defaults.items():
        if isinstance(option, Declared):
            options |= option
        else:
            options[field] = (record.__annotations__[field], option)
    return options


def _collected(option: Any, field: str, kind: Any, typed: dict[str, Any]) -> Any:
    """The value typed for a field of a record, which is taken out.

    It is as if nothing was typed where the command does not take it.
    """
    if isinstance(option, Declared):
        return {name: typed.pop(name, None) for name in option}
    return typed.pop(field, () if get_args(kind)[1:] == (...,) else None)


def _for_typer(name: str, kind: Any, declared: Any) -> inspect.Parameter:
    """A parameter as Typer takes it.

    It is an option with its name, with lists for tuples and text for what a parser reads.
    """
    info = copy.copy(declared)
    repeated = get_args(kind)[1:] == (...,)
    if info.default is None and type(None) not in get_args(kind):
        if repeated:
            info.default = ()
        else:
            info.default = False if kind is bool else ...
    if isinstance(info, OptionInfo) and not info.param_decls:
        info.param_decls = (f"--{name.rstrip('_').replace('_', '-')}",)
    annotation = str if info.parser else kind
    if repeated:
        annotation = list[str]
    return inspect.Parameter(
        name, inspect.Parameter.KEYWORD_ONLY, annotation=annotation, default=info
    )
