"""How options are declared, and how a command takes those that a record declares by the annotations of its fields.

    @takes_options
    def analyze(robot: RobotName, options: SceneOptions) -> None: …

A parameter of the command's own takes the place of the record's option of that name. Options that may be repeated are tuples.
"""

import copy
import functools
import inspect
from collections.abc import Callable
from typing import Any, get_args

import typer
from typer.models import OptionInfo

__all__ = ["argument", "group", "takes_options"]

Parser = Callable[[str], Any]


def group(heading: str) -> Callable[..., Any]:
    """A function that describes an option which stands under this heading of the help.

    Its arguments are a sentence for the help, the form of the value, a parser, and the least of whole numbers.
    """

    def option(help_: str, form: str | None = None, parser: Parser | None = None, *, least: int | None = None) -> Any:
        return typer.Option(help=help_, metavar=form, parser=parser, min=least, rich_help_panel=heading, show_default=False)

    return option


def argument(help_: str, form: str, parser: Parser | None = None) -> Any:
    """The description of what is typed without a name: a sentence for the help, the form of the value, a parser."""
    return typer.Argument(help=help_, metavar=form, parser=parser, show_default=False)


def takes_options(command: Callable[..., int | None]) -> Callable[..., int | None]:
    """Replace each parameter of a command whose type is a record of options by the options that the record declares."""
    own = inspect.signature(command).parameters
    records = {name: one.annotation for name, one in own.items() if hasattr(one.annotation, "_fields")}
    taken = {
        name: [field for field in record._fields if field not in {one.rstrip("_") for one in own}]
        for name, record in records.items()
    }
    parameters: list[inspect.Parameter] = []
    for name, one in own.items():
        if name in records:
            record = records[name]
            parameters += [_for_typer(field, record.__annotations__[field], record._field_defaults[field]) for field in taken[name]]
        else:
            parameters.append(_for_typer(name, one.annotation, one.default))

    @functools.wraps(command)
    def run(**typed: Any) -> int | None:
        typed = {name: tuple(value) if isinstance(value, list) else value for name, value in typed.items()}
        for name, record in records.items():
            typed[name] = record(**{field: typed.pop(field) for field in taken[name]})
        return command(**typed)

    # What Typer reads.
    vars(run)["__signature__"] = inspect.Signature(parameters)
    run.__annotations__ = {}
    return run


def _for_typer(name: str, annotation: Any, default: Any) -> inspect.Parameter:
    """A parameter as Typer takes it: an option with its name, lists for tuples, text for what a parser reads."""
    kind, note = get_args(annotation)
    info = copy.copy(note)
    info.default = ... if default is inspect.Parameter.empty else default
    if isinstance(info, OptionInfo):
        info.param_decls = (f"--{name.rstrip('_').replace('_', '-')}",)
    if get_args(kind)[1:] == (...,):
        kind = list[str]
    elif info.parser is not None:
        kind = str
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, annotation=kind, default=info)
