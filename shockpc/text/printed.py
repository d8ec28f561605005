"""Names and documents as they are printed: not too long, and without control characters.

Nothing in them controls a terminal, the direction of text or a CI runner.
"""

import json
import math
import re
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple

UNITS = {"rad": (math.degrees(1.0), "deg"), "m": (1e3, "mm")}
"""Units of small tables and figures by SI unit: what a number is multiplied by, and the name."""

_COMMANDS = (("^( *):(?=:)", r"\1\\x3a"), (r"(?i)##(?=\[|vso\[)", r"#\\x23"))
"""Patterns of lines that CI runners take for commands, and what is printed instead."""


def shown_as(value: float, unit: str) -> str:
    """A value of three digits with its unit; radians in degrees, metres in millimetres."""
    factor, name = UNITS.get(unit, (1.0, unit))
    return f"{round(factor * value, 12) + 0.0:.3g} {name}"


class Cause(NamedTuple):
    """A reason why rows were not computed: its message, their number, and the name of the first."""

    text: str
    rows: int
    first: object


def visible(text: str, allowed: str = "") -> str:
    r"""A text with control characters and invisible marks as escapes such as `\x1b`.

    Line breaks are escaped too. The characters of `allowed` are kept.
    """
    if text.isprintable():
        return text
    return re.sub(
        f"[^ -~{re.escape(allowed)}]",
        lambda sign: sign[0] if sign[0].isprintable() else _escape(sign[0]),
        text,
    )


def _escape(sign: str) -> str:
    return sign.encode("unicode_escape").decode("ascii")


def printable(text: str, most: int | None = None) -> str:
    r"""A name or a line as it is printed: visible, and not a command for a CI runner.

    Such a command has `::error` at its beginning, or `##[`.

    Args:
        text: any text.
        most: largest number of characters; a longer text is shortened in the middle.
    """
    text = visible(text)
    if "::" in text or "##" in text:
        for command, instead in _COMMANDS:
            text = re.sub(command, instead, text)
    if most is None or len(text) <= most:
        return text
    return f"{text[: most // 2]}…{text[len(text) - (most - 1 - most // 2) :]}"


def message(text: str) -> str:
    """A message on one line of at most 2000 characters.

    Quoted names of more than 160 characters are shortened to 80.
    """
    # All quoted names are matched, so that what stands between two of them is not taken for one.
    quoted = re.sub(
        '"([^"]*)"',
        lambda name: f'"{printable(name[1], 80)}"' if len(name[1]) > 160 else name[0],
        text,
    )
    return printable(quoted, 2000)


def json_text(document: Any) -> str:
    """A document, or a list of them, as JSON with each entry on a separate line.

    So is each object of an entry that has several. JSON's escapes stand for what a terminal or a CI
    runner would interpret.
    """
    encode = json.JSONEncoder(ensure_ascii=False, allow_nan=False).encode

    def written(value: Any, depth: int, start: str) -> str:
        if depth and value and isinstance(value, dict):
            brackets, parts = (
                "{}",
                [
                    f"{encode(key)}: {written(part, depth - 1, f'{start} ')}"
                    for key, part in value.items()
                ],
            )
        elif depth and isinstance(value, list) and isinstance(next(iter(value), None), dict):
            brackets, parts = "[]", [written(part, depth - 1, f"{start} ") for part in value]
        else:
            return encode(value)
        return f",{start} ".join(parts).join((f"{brackets[0]}{start} ", f"{start}{brackets[1]}"))

    text = written(document, 2 if isinstance(document, dict) else 3, "\n").replace("##", "#\\u0023")
    return (
        re.sub(
            "[^ -~\n]",
            lambda sign: sign[0] if sign[0].isprintable() else json.dumps(sign[0])[1:-1],
            text,
        )
        + "\n"
    )


def causes(messages: Iterable[tuple[object, str]]) -> list[Cause]:
    """The causes of what was not computed, the most frequent first.

    Those that differ only in the gap of an open loop are one.

    Args: messages, of what was not computed by its name.
    """
    named: dict[str, list[object]] = {}
    for name, text in messages:
        named.setdefault(
            re.sub(r"(?<![\d.e+-])[\d.e+-]++(?= (mm apart|deg turned))", "some", text), []
        ).append(name)
    return sorted(
        (Cause(text, len(names), names[0]) for text, names in named.items()),
        key=lambda cause: -cause.rows,
    )


def cause_lines(groups: Sequence[Cause], noun: str, most: int) -> Iterator[str]:
    """A line for each of the most frequent causes, as "12 rows: cause (first: NAME)".

    Args: noun, of the rows in the plural.
    """
    for text, number, first in groups[:most]:
        yield f"{first}: {text}" if number == 1 else f"{number} {noun}: {text} (first: {first})"
    if left := groups[most:]:
        yield f"and {len(left)} other cause{'s' * (len(left) > 1)}"


def not_computed(failures: Iterable[tuple[object, object]], noun: str, most: int) -> list[str]:
    """A line for each of the most frequent causes of failures, by the names of these."""
    groups = causes((name, str(reason)) for name, reason in failures)
    return [f"not computed: {line}" for line in cause_lines(groups, noun, most)]


def in_degrees(angle: float) -> float:
    """An angle [rad] in degrees without the rounding of its conversion.

    For example, 30 and not 29.999999999999996.
    """
    return round(math.degrees(angle), 9) + 0.0


def plural(noun: str) -> str:
    """The plural of a noun, such as "rows" or "bodies"."""
    return f"{noun[:-1]}ies" if noun.endswith("y") else f"{noun}s"


def count(number: int, noun: str) -> str:
    """A number with its noun, such as "1 body" or "2 bodies"."""
    return f"{number} {noun if number == 1 else plural(noun)}"


def unit_text(unit: str) -> str:
    """A unit as tables and texts have it, with "-" for that of a ratio, 1."""
    return "-" if unit == "1" else unit


def few(names: Sequence[str], most: int, separator: str = ", ", noun: str = "") -> str:
    """The first names, and how many more there are."""
    return separator.join(names[:most]) + (
        f" and {len(names) - most} more{noun}" if len(names) > most else ""
    )


def listed(names: Iterable[object], most: int = 10**6) -> str:
    """The first names in quotation marks, with commas, and how many more there are."""
    return few([f'"{name}"' for name in names], most)
