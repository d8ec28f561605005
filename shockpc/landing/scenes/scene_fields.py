"""The parts of a scene: their base class, and the declaration of a field as an option.

An option is declared once for Python, TOML and the command line.
"""

import dataclasses
import functools
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import MISSING
from typing import Any, Literal, NamedTuple, TypeVar

from shockpc.text.arguments import LARGEST_NUMBER, default_of, typed
from shockpc.text.wings import from_wings, is_here

CHECKED = {"extra": "forbid", "allow_inf_nan": False}
"""The check of scene files against the records they become: no unknown keys, no numbers that are
not finite.
"""

CONTACT, STRIKE, RESULTS, POSTURE = (
    "Contact",
    "Velocity before the impact",
    "What is computed",
    "Posture",
)
JOINT_MODEL, SOFT = "Joint model", "Contacts and links that give way"
"""Headings of options."""


class Record:
    """A part of a scene, compared and printed by its fields."""

    __pydantic_config__ = CHECKED

    # Made by dataclass for each class, these methods would lengthen the start of every command.
    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and vars(self) == vars(other)

    def __hash__(self) -> int:
        return hash(tuple(vars(self).values()))

    def __repr__(self) -> str:
        """The fields that differ from their defaults."""
        fields: dict[str, Any] = vars(type(self))["__dataclass_fields__"]
        shown = []
        for name, value in vars(self).items():
            default = default_of(fields[name])
            if default is MISSING or type(value) is not type(default) or value != default:
                shown.append(f"{name}={value!r}")
        return f"{type(self).__name__}({', '.join(shown)})"


class Option(NamedTuple):
    """The description of a field besides its type.

    The command-line option, checks and what a sweep varies follow from it.

    Attributes:
        help: a sentence; the unit follows it.
        heading: under which the help of a command lists it.
        form: of the value on the command line, such as "X,Y,Z".
        name: on the command line; by default the field's.
        unit: of a number; empty without one.
        least: the minimum of its numbers; of those without one the negative `LARGEST_NUMBER`.
        above: what its numbers have to be above.
        greatest: the maximum of its numbers; of those without one `LARGEST_NUMBER`.
        varies: whether a sweep can vary it, by its name on the command line.
        most: the maximum number of values in a list.
        default: what holds without it, as the help states it.
        wing: which serves it: without that it is no option of a command, and refused in files and
            Python where it is not the default; empty for the core.
        on_command_line: whether commands have it as an option; else it is a key of a scene's file
            and a field in Python alone.
        holds: what its texts are, if the command looks into them: names of what each landing of a
            study has a value of ("varied"), or of quantities that are computed ("quantity").
    """

    help: str
    heading: str
    form: str | None = None
    name: str = ""
    unit: str = ""
    least: float | None = None
    above: float | None = None
    greatest: float | None = None
    varies: bool = False
    most: int | None = None
    default: str = ""
    wing: str = ""
    on_command_line: bool = True
    holds: Literal["", "varied", "quantity"] = ""

    @property
    def text(self) -> str:
        """The help with the unit, with the maximum unless it states that, and with the default."""
        stated = self.greatest is None or re.search(rf"\b{self.greatest:g}\b", self.help)
        unit = self.unit if self.unit != "1" else ""
        inside = ", ".join(filter(None, [unit, "" if stated else f"at most {self.greatest:g}"]))
        default = f" [default: {self.default}]" if self.default else ""
        return (f"{self.help[:-1]} [{inside}]." if inside else self.help) + default

    def stating(self, default: Any) -> "Option":
        """The option whose help states the default, if that is a number or a word."""
        if isinstance(default, bool) or default == "":
            return self
        if not isinstance(default, int | float | str):
            return self
        stated = f"{default:g}" if isinstance(default, float) else str(default)
        return self._replace(default=stated)

    def fault(self, value: Any) -> str:
        """Why a number is not valid, or one of a collection of numbers; empty if all are."""
        value = value.tolist() if hasattr(value, "tolist") else value  # of NumPy
        if isinstance(value, Mapping | tuple | list):
            return self._fault_of_several(value)
        if not isinstance(value, int | float) or isinstance(value, bool):
            return ""
        if isinstance(value, int):
            value = _as_float(value)
        if not math.isfinite(value):
            return f"must be finite, got {value:g}"
        # Bounds that are stated are named whichever of them is missed.
        missed = False
        wanted: list[str] = []
        for sign, bound, holds, stated in self._bounds(value):
            missed |= not holds
            if stated or not holds:
                wanted.append(f"{sign} {bound:g}")
        if not missed:
            return ""
        unit = "" if self.unit in ("", "1") or ";" in self.unit else f" {self.unit}"
        return f"must be {' and '.join(wanted)}{unit}, got {value:g}"

    def _fault_of_several(self, values: Mapping[Any, Any] | Sequence[Any]) -> str:
        """Why a collection is too long, or the first of its numbers not valid."""
        if self.most is not None and len(values) > self.most:
            return f"must have at most {self.most} values, got {len(values)}"
        for value in values.values() if isinstance(values, Mapping) else values:
            fault = self.fault(value)
            if fault:
                return fault
        return ""

    def _bounds(self, value: float) -> Iterator[tuple[str, float, bool, bool]]:
        """The bounds of a number: sign, bound, and two flags.

        The first flag tells whether the number is within, the second whether the field states the
        bound.
        """
        if self.least is not None:
            yield "≥", self.least, value >= self.least, True
        elif self.above is None:
            yield "≥", -LARGEST_NUMBER, value >= -LARGEST_NUMBER, False
        if self.above is not None:
            yield ">", self.above, value > self.above, True
        high = LARGEST_NUMBER if self.greatest is None else self.greatest
        yield "≤", high, value <= high, self.greatest is not None


def _as_float(value: int) -> float:
    """An integer as a double, infinite where it is too large for one."""
    if abs(value) < LARGEST_NUMBER**2:
        return float(value)
    return math.inf if value > 0 else -math.inf


def option(
    default: Any, /, help_: str, heading: str, form: str | None = None, **settings: Any
) -> Any:
    """A field of a record that is an option; the arguments are those of `Option`.

    Args: default, `dict` for a mapping, which is typed as NAME=VALUE.
    """
    declared = Option(help_, heading, form, **settings).stating(default)
    metadata = {"option": declared, "description": declared.text, "wing": declared.wing}
    if default is dict:
        return dataclasses.field(default_factory=dict, metadata=metadata)
    return dataclasses.field(default=default, metadata=metadata)


@functools.cache
def options_of(record: type) -> dict[str, Option]:
    """The options among the fields of a record, by field."""
    options: dict[str, Option] = {}
    for part in dataclasses.fields(record):
        declared = part.metadata.get("option")
        if declared and is_here(declared.wing):
            name = declared.name or part.name.removesuffix("_deg").replace("_", "-")
            options[part.name] = declared._replace(name=name)
    return options


def spelled(record: type, field: str, value: str) -> str:
    """The text that gives a field of a record a value.

    It is the option on the command line, else the key, as in a file and in Python.
    """
    return (
        f"--{options_of(record)[field].name} {value}"
        if record.__name__ in typed
        else f'{field} = "{value}"'
    )


def of_the_core(record: Any) -> Any:
    """A record in which all that wings serve has its default."""
    parts = [part for part in dataclasses.fields(record) if part.metadata.get("wing")]
    return dataclasses.replace(record, **{part.name: default_of(part) for part in parts})


R = TypeVar("R", bound=type)


def with_wing_options(record: R) -> R:
    """A record, not frozen yet, with the options of wings as fields behind its own."""
    for options in from_wings("options", "OPTIONS"):
        for name, (kind, declared) in options.items():
            record.__annotations__[name] = kind
            setattr(record, name, declared)
    return record


def documented(record: R) -> R:
    """A record whose docstring lists its options besides the attributes it describes itself."""
    describe(record, options_of(record))
    return record


def describe(declared: Any, options: Mapping[str, Option]) -> None:
    """List options in the docstring of the record or function that declares them.

    They follow what it describes itself.
    """
    if text := declared.__doc__:
        lines = [f"        {name}: {option.text}" for name, option in options.items()]
        described, mark, rest = text.partition("    Raises:")
        declared.__doc__ = "\n".join(
            [described.rstrip(), *lines, "", f"    {mark.strip()}{rest}" if mark else "    "]
        )
