"""How options are declared by the fields of a record, and how a command takes them.

The annotation of a field holds Typer's description, the parser of the option's text and its group in the help. A command that has
a parameter of the record's type, and the decorator `takes_options`, has all of these options:

    @takes_options
    def analyze(robot: RobotName, options: SceneOptions) -> None: …

A command that uses the name of one of them for something else leaves that one out:

    options: Annotated[SceneOptions, without("set")]
"""

import functools
import inspect
from collections.abc import Callable
from dataclasses import MISSING, fields, is_dataclass
from typing import Annotated, Any, NamedTuple, get_args, get_origin, get_type_hints

import typer

__all__ = ["option", "takes_options", "without"]


class _Without(NamedTuple):
    """Names of the fields of a record that a command leaves out; they keep their defaults."""

    names: tuple[str, ...]


def without(*names: str) -> _Without:
    """What a command writes beside the type of a record to leave some of its options out."""
    return _Without(names)


def option(help_: str, *names: str, group: str, metavar: str | None = None, parser: Callable[[str], Any] | None = None) -> Any:
    """The description of an option.

    Args:
        help_: one sentence for the help.
        *names: how it is typed, where that is not its field's name.
        group: the heading that it stands under in the help.
        metavar: what its value is called in the help.
        parser: from the text of the value to the value.
    """
    return typer.Option(*names, help=help_, metavar=metavar, parser=parser, rich_help_panel=group, show_default=False)


def takes_options(command: Callable[..., None]) -> Callable[..., None]:
    """Replace each parameter of a command whose type is a record of options by the options that the record declares."""
    signature = inspect.signature(command, eval_str=True)
    records: dict[str, tuple[Any, list[str]]] = {}
    parameters: list[inspect.Parameter] = []
    for parameter in signature.parameters.values():
        record, *notes = get_args(parameter.annotation) if get_origin(parameter.annotation) is Annotated else [parameter.annotation]
        if not is_dataclass(record):
            parameters.append(parameter.replace(kind=inspect.Parameter.KEYWORD_ONLY))
            continue
        left_out = {name for note in notes if isinstance(note, _Without) for name in note.names}
        taken = [one for one in fields(record) if one.name not in left_out]
        records[parameter.name] = record, [one.name for one in taken]
        hints = get_type_hints(record, include_extras=True)
        parameters += [
            inspect.Parameter(
                one.name,
                inspect.Parameter.KEYWORD_ONLY,
                annotation=hints[one.name],
                default=[] if one.default is MISSING else one.default,
            )
            for one in taken
        ]

    @functools.wraps(command)
    def run(**typed: Any) -> None:
        for name, (record, taken) in records.items():
            typed[name] = record(**{one: typed.pop(one) for one in taken})
        command(**typed)

    # What Typer reads.
    vars(run)["__signature__"] = signature.replace(parameters=parameters)
    run.__annotations__ = {one.name: one.annotation for one in parameters}
    return run
