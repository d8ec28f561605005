"""How commands and options are declared, and how a command takes those that a record's fields or a study's parameters declare.

    @command(examples=("shockpc batch anymal_c go2 solo12",))
    def batch(*, names: tuple[str, ...] = argument("Robots.", "ROBOT...", default=...), options: SceneOptions) -> None: …

A parameter that is called like an option of the record, with an underscore after it, takes its place; the record's is then empty.
An option whose type is a tuple of any length may be repeated. What is not given is the default, else None, False or empty; where
the type allows none of these, or the default is `...`, it has to be given.
"""

import functools
import inspect
from collections.abc import Callable
from typing import Any, Literal, NamedTuple, TypeAlias, get_args, get_origin

Parser: TypeAlias = Callable[[str], Any]
Command: TypeAlias = Callable[..., int | None]

ARGUMENTS = "Arguments"
"""Heading of what is typed without a name."""


class Parameter(NamedTuple):
    """What is typed for a command: an option, or without a name.

    Attributes:
        heading: under which it stands in the help.
        help: a sentence.
        form: of the value, such as "X,Y,Z".
        parser: reads the text of the value; by default its type does.
        default: where nothing is typed; `...` where something has to be.
        name: of the option, if it is not that of the parameter.
        key: the parameter of the command; it and its type are those of the function that is declared to be one.
        kind: its type.
    """

    heading: str
    help: str
    form: str | None = None
    parser: Parser | None = None
    default: Any = None
    name: str | None = None
    key: str = ""
    kind: Any = str

    @property
    def flag(self) -> str:
        """The option as it is typed; empty for what is typed without a name."""
        return "" if self.heading == ARGUMENTS else f"--{self.name or self.key.rstrip('_').replace('_', '-')}"

    @property
    def is_switch(self) -> bool:
        """Whether it has no value."""
        return bool in (self.kind, *get_args(self.kind))

    @property
    def repeats(self) -> bool:
        """Whether it may be repeated."""
        return get_args(self.kind)[1:] == (...,)

    @property
    def words(self) -> tuple[str, ...]:
        """The only values that it may have; none if it may have others."""
        return next((get_args(part) for part in (self.kind, *get_args(self.kind)) if get_origin(part) is Literal), ())

    @property
    def needed(self) -> bool:
        """Whether something has to be typed."""
        may_lack = self.kind is bool or self.repeats or type(None) in get_args(self.kind) or self.default is not None
        return self.default is ... or not may_lack


class Declared(dict[str, tuple[Any, Any]]):
    """Options that a field of a record, or a parameter of a command, collects: type and declaration by name."""


class Help(NamedTuple):
    """What the help of a command says besides its summary and options.

    Attributes:
        examples: command lines.
        more: a paragraph, or nothing.
        after: what stands under the options.
    """

    examples: tuple[str, ...]
    more: str
    after: str

    def text(self, summary: str) -> str:
        """What stands above the options, in paragraphs. Args: summary: what the command does."""
        return "\n\n".join(filter(None, [summary, self.more, "\n  ".join(["\b\nExamples:", *self.examples])]))


def group(heading: str) -> Callable[..., Any]:
    """A function that declares an option which stands under this heading of the help. Its arguments are those of `Parameter`."""

    def option(help_: str, form: str | None = None, parser: Parser | None = None, **further: Any) -> Any:
        return Parameter(heading, help_, form, parser, **further)

    return option


argument = group(ARGUMENTS)
"""Declares what is typed without a name. Its arguments are those of `Parameter`."""


def command(
    *, examples: tuple[str, ...], more: str = "", after: str = "Exit codes: shockpc --help lists them."
) -> Callable[[Command], Command]:
    """Make a function a command, which takes the options of records among its parameters after its own; arguments as in `Help`.

    The text is no docstring, because Python can be told to leave those out.
    """

    def declare(function: Command) -> Command:
        run = _taking_options(function)
        vars(run)["help"] = Help(examples, more, after)
        return run

    return declare


def _taking_options(command: Command) -> Command:
    """Replace each parameter of a command that is a record of options, or `Declared`, by the options."""
    parameters = inspect.signature(command).parameters
    records = {name: parameter.annotation for name, parameter in parameters.items() if hasattr(parameter.annotation, "_fields")}
    grouped = {name: parameter.default for name, parameter in parameters.items() if isinstance(parameter.default, Declared)}
    declared: dict[str, tuple[Any, Parameter]] = {}
    for name, parameter in parameters.items():
        if name in records:
            kinds = records[name].__annotations__
            for field, option in records[name]._field_defaults.items():
                collected = option if isinstance(option, Declared) else {field: (kinds[field], option)}
                declared |= {key: one for key, one in collected.items() if f"{key}_" not in parameters and key not in declared}
        else:
            declared |= grouped.get(name, {name: (parameter.annotation, parameter.default)})

    @functools.wraps(command)
    def run(**typed: Any) -> int | None:
        typed |= {name: {option: typed.pop(option, None) for option in options} for name, options in grouped.items()}
        for name, record in records.items():
            fields = record._field_defaults
            typed[name] = record(**{field: _collected(option, field, typed) for field, option in fields.items()})
        return command(**typed)

    vars(run)["parameters"] = [one._replace(key=key, kind=kind) for key, (kind, one) in declared.items()]
    return run


def _collected(option: Any, field: str, typed: dict[str, Any]) -> Any:
    """What was typed for a field of a record, which is taken out."""
    return {name: typed.pop(name, None) for name in option} if isinstance(option, Declared) else typed.pop(field, ())
