"""How options are declared by the fields of records, and how a command takes them.

The annotation of a field holds the description of its option. A command that has a parameter of the record's type, and the
decorator `takes_options`, has all of these options:

    @takes_options
    def analyze(robot: RobotName, options: SceneOptions) -> None: …

A command that uses the name of one of them for something else leaves that one out:

    options: Annotated[SceneOptions, without("set")]

Options that may be repeated are tuples.
"""

import copy
import functools
import inspect
import types
from collections.abc import Callable
from dataclasses import MISSING, fields, is_dataclass
from typing import Annotated, Any, NamedTuple, get_args, get_origin, get_type_hints

import typer
from typer.models import OptionInfo

__all__ = ["argument", "group", "takes_options", "without"]

Parser = Callable[[str, str], Any]
"""From what is typed, and the form that the help names, to a value."""


class _Without(NamedTuple):
    """Names of the fields of a record that a command leaves out; they keep their defaults."""

    names: tuple[str, ...]


def without(*names: str) -> _Without:
    """What a command writes beside the type of a record to leave some of its options out."""
    return _Without(names)


def group(heading: str) -> Callable[..., Any]:
    """A function that describes the options which stand under one heading of the help.

    Its arguments are a sentence for the help, the form of the value (what the help calls it), a parser (from the text and the form
    to the value), `name` (how it is typed, where that is not the field's name) and `least` (of whole numbers).
    """
    return functools.partial(_option, heading)


def argument(help_: str, form: str, parser: Parser | None = None) -> Any:
    """The description of what is typed without a name. Args: help_, form, parser: as of an option."""
    return typer.Argument(metavar=form, help=help_, parser=_with_form(parser, form), show_default=False)


def takes_options(command: Callable[..., None]) -> Callable[..., None]:
    """Replace each parameter of a command whose type is a record of options by the options that the record declares."""
    signature = inspect.signature(command, eval_str=True)
    records: dict[str, tuple[Any, list[str]]] = {}
    parameters: list[inspect.Parameter] = []
    for parameter in signature.parameters.values():
        record, *notes = get_args(parameter.annotation) if get_origin(parameter.annotation) is Annotated else [parameter.annotation]
        if not is_dataclass(record):
            parameters.append(_for_typer(parameter.name, parameter.annotation, parameter.default))
            continue
        left_out = {name for note in notes if isinstance(note, _Without) for name in note.names}
        hints, taken = get_type_hints(record, include_extras=True), [one for one in fields(record) if one.name not in left_out]
        records[parameter.name] = record, [one.name for one in taken]
        parameters += [
            _for_typer(one.name, hints[one.name], inspect.Parameter.empty if one.default is MISSING else one.default)
            for one in taken
        ]

    @functools.wraps(command)
    def run(**typed: Any) -> None:
        typed = {name: tuple(value) if isinstance(value, list) else value for name, value in typed.items()}
        for name, (record, taken) in records.items():
            typed[name] = record(**{one: typed.pop(one) for one in taken})
        command(**typed)

    # What Typer reads.
    vars(run)["__signature__"] = signature.replace(parameters=parameters)
    run.__annotations__ = {one.name: one.annotation for one in parameters}
    return run


def _option(
    heading: str, help_: str, form: str | None = None, parser: Parser | None = None, *, name: str = "", least: int | None = None
) -> Any:
    """What `group` describes."""
    names = [name] if name else []
    parse = _with_form(parser, form or "")
    return typer.Option(*names, help=help_, metavar=form, parser=parse, rich_help_panel=heading, show_default=False, min=least)


def _with_form(parser: Parser | None, form: str) -> Callable[[str], Any] | None:
    """A parser of the text alone, as Typer takes it."""
    if parser is None:
        return None

    def parse(text: str) -> Any:
        return parser(text, form)

    return parse


def _for_typer(name: str, annotation: Any, default: Any) -> inspect.Parameter:
    """A parameter as Typer takes it: an option with its name, lists for tuples, text for what a parser reads."""
    kind, note, *_ = get_args(annotation)
    info = copy.copy(note)
    info.default = ... if default is inspect.Parameter.empty else default
    if isinstance(info, OptionInfo) and not info.param_decls:
        info.param_decls = (f"--{name.rstrip('_').replace('_', '-')}",)
    inner, several = (get_args(kind)[0], True) if get_args(kind)[1:] == (...,) else (kind, False)
    if info.parser is not None:
        inner = str
    return inspect.Parameter(
        name, inspect.Parameter.KEYWORD_ONLY, annotation=types.GenericAlias(list, inner) if several else inner, default=info
    )
