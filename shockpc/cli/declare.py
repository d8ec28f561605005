"""How options are declared, and how a command takes those that the fields of a record declare.

    @takes_options
    def limits(*, robot: str = ROBOT, joint: str = in_question("The joint.", "JOINT"), options: SceneOptions) -> None: …

A parameter that is called like an option of the record, with an underscore after it, takes its place; the record's is then empty.
An option whose type is a tuple of any length may be repeated. What is not given is the default, else None, False or empty; where
the type allows none of these, or the default is `...`, it has to be given.
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
    """A function that declares an option which stands under this heading of the help.

    Its arguments are a sentence for the help, the form of the value, a parser, the default, and the least of whole numbers.
    """

    def option(
        help_: str, form: str | None = None, parser: Parser | None = None, *, default: Any = None, least: int | None = None
    ) -> Any:
        return typer.Option(
            default, help=help_, metavar=form, parser=parser, min=least, rich_help_panel=heading, show_default=False
        )

    return option


def argument(help_: str, form: str, parser: Parser | None = None, *, default: Any = None) -> Any:
    """Declare what is typed without a name. The arguments are those of an option."""
    return typer.Argument(default, help=help_, metavar=form, parser=parser, show_default=False)


def takes_options(command: Callable[..., int | None]) -> Callable[..., int | None]:
    """Replace each parameter of a command whose type is a record of options by the options that the record declares."""
    own = inspect.signature(command).parameters
    records = {name: one.annotation for name, one in own.items() if hasattr(one.annotation, "_fields")}
    declared: dict[str, tuple[Any, Any]] = {}
    for name, one in own.items():
        fields = getattr(one.annotation, "_field_defaults", None)
        if fields is None:
            declared[name] = one.annotation, one.default
        else:
            kinds = one.annotation.__annotations__
            declared |= {field: (kinds[field], option) for field, option in fields.items() if f"{field}_" not in own}

    @functools.wraps(command)
    def run(**typed: Any) -> int | None:
        typed = {name: tuple(value) if isinstance(value, list) else value for name, value in typed.items()}
        for name, record in records.items():
            typed[name] = record(**{field: typed.pop(field, ()) for field in record._fields})
        return command(**typed)

    # What Typer reads.
    vars(run)["__signature__"] = inspect.Signature([_for_typer(name, *of) for name, of in declared.items()])
    run.__annotations__ = {}
    return run


def _for_typer(name: str, kind: Any, declared: Any) -> inspect.Parameter:
    """A parameter as Typer takes it: an option with its name, lists for tuples, text for what a parser reads."""
    info, several = copy.copy(declared), get_args(kind)[1:] == (...,)
    if info.default is None and type(None) not in get_args(kind):
        info.default = () if several else False if kind is bool else ...
    if isinstance(info, OptionInfo):
        info.param_decls = (f"--{name.rstrip('_').replace('_', '-')}",)
    annotation = list[str] if several else str if info.parser else kind
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, annotation=annotation, default=info)
