"""Records as TOML: a file is read into dataclasses, and written from them.

The types of the fields say what is valid. A key that is not known is refused with the nearest one,
and all that does not fit is reported at once. Values from Python are checked in the same way.
"""

import dataclasses
import difflib
import json
import os
import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields, is_dataclass
from numbers import Real
from pathlib import Path
from typing import Any, Literal, Union, get_args, get_origin

import numpy as np

from shockpc.text.arguments import LARGEST_NUMBER, default_of
from shockpc.text.errors import ShockError
from shockpc.text.paths import read_file
from shockpc.text.wings import is_here

MOST_KEYS = 10
"""Valid keys that a message lists."""

_DEEP_KEY = r"""(?<![\w-])(?:(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')[ \t]*+\.[ \t]*+){20}"""


@contextmanager
def reading(path: Path, kind: str, error: type[ShockError]) -> Iterator[dict[str, Any]]:
    """Read a TOML file.

    Whatever is wrong with the file, or what the caller finds in it, is raised as one kind of error.

    Args:
        path: of the file.
        kind: of file, in one word, for messages.
        error: raised with a message that names the file; when the caller raises it, the file is
            named in front of its message.

    Yields: the file's table.
    """
    import tomllib

    data = read_file(path, f"{kind} file", error)
    text = ""
    try:
        text = data.decode("utf-8-sig")
        if re.search(_DEEP_KEY, text):
            raise ValueError(
                "a key of many parts, for which the time grows with the square of their number"
            )
        yield tomllib.loads(text)
    except error as refusal:
        raise error(_located(str(refusal), path, text), **refusal.data) from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as refusal:
        at = re.search(r"\(at line (\d+)", str(refusal))
        where = f"{path}:{at[1]}" if at else f"{path}"
        raise error(f"{where} is not TOML, as a {kind} file has to be: {refusal}") from None
    except (ValueError, RecursionError):
        raise error(
            f"{path} holds an integer of thousands of digits, or tables or keys nested too deep; "
            f"shorten it"
        ) from None


def _located(message: str, path: Path, text: str) -> str:
    """A message about keys of a file, each with its line: "scene.toml:3: …; line 7: …"."""
    lines = _lines_of_keys(text)
    parts = re.split(r"; (?=\S+(?: has to be|: no such key| is missing))", message)
    located = []
    for number, part in enumerate(parts):
        key = re.match(r"\S+?(?= has to be|: no such key| is missing)", part)
        line = _line(key[0], lines) if key else 0
        if number == 0:
            located.append(f"{path}:{line}: {part}" if line else f"{path}: {part}")
        else:
            located.append(f"line {line}: {part}" if line else part)
    return "; ".join(located)


def _line(key: str, lines: Mapping[str, int]) -> int:
    """The line of a key, or of the table that should have it; 0 if neither is in the file."""
    while key and key not in lines:
        key = re.sub(r"(\.[^.\[\]]*|\[\d+\]|^[^.\[\]]*)$", "", key)
    return lines.get(key, 0)


_PART = r"""(?:[\w-]+|"[^"\n]*"|'[^'\n]*')"""
_HEADER = re.compile(rf"\s*(\[\[?)\s*({_PART}(?:\s*\.\s*{_PART})*)\s*\]")
_KEY = re.compile(rf"\s*({_PART}(?:\s*\.\s*{_PART})*)\s*=")


def _lines_of_keys(text: str) -> dict[str, int]:
    """The line of each key and table of a TOML file, by position, such as "contact[0].frame"."""
    lines: dict[str, int] = {}
    last: dict[str, int] = {}  # of each array of tables, the number of the present one
    table = ""
    for number, line in enumerate(text.splitlines(), start=1):
        header, key = _HEADER.match(line), _KEY.match(line)
        if header:
            table = ""
            parts = re.findall(_PART, header[2])
            for index, part in enumerate(parts):
                table = f"{table}.{part}" if table else part
                if header[1] == "[[" and index == len(parts) - 1:
                    last[table] = last.get(table, -1) + 1
                if table in last:
                    table = f"{table}[{last[table]}]"
            lines.setdefault(table, number)
            lines.setdefault(re.sub(r"\[\d+\]$", "", table), number)
        elif key:
            name = ".".join(re.findall(_PART, key[1]))
            lines.setdefault(f"{table}.{name}" if table else name, number)
    return lines


def converted(value: Any, kind: Any, key: str, faults: list[str]) -> Any:
    """A value from TOML or from Python, converted to the type of its field.

    Args:
        value: a table or a record, a list or a tuple, text or a number.
        kind: the type.
        key: position of the value in the file.
        faults: receives a message for everything that does not fit.
    """
    origin, parts = get_origin(kind), get_args(kind)
    if type(None) in parts:
        return None if value is None else converted(value, Union[parts[:-1]], key, faults)  # noqa: UP007
    if isinstance(kind, type) and is_dataclass(kind):
        if isinstance(value, kind | Mapping):
            table = vars(value) if is_dataclass(value) else value
            return _record(table, kind, f"{key}." if key else "", faults)
    elif origin is Mapping:
        if isinstance(value, Mapping):
            return _mapping(value, parts[1], key, faults)
    elif parts[1:] == (...,):
        if isinstance(value, tuple | list):
            entries = enumerate(value)
            return tuple(converted(part, parts[0], f"{key}[{k}]", faults) for k, part in entries)
    else:
        for option in (kind,) if origin in (None, Literal, tuple) else parts:
            leaf = _leaf(value, option)
            if leaf is not None:
                return leaf
    faults.append(f"{key} has to be {_wanted(kind)}, not {_shown(value)}")
    return value


def _mapping(table: Mapping[Any, Any], kind: Any, key: str, faults: list[str]) -> dict[Any, Any]:
    """A table of values of one type, as `converted`."""
    values = {}
    for name, part in table.items():
        values[name] = converted(part, kind, f"{key}.{_toml_key(str(name))}", faults)
    return values


def _record(table: Mapping[str, Any], kind: type, key: str, faults: list[str]) -> Any:
    """A record from its fields; None if something does not fit."""
    values: dict[str, Any] = {}
    for item in fields(kind):
        if item.name in table:
            _convert_field(table[item.name], item, key, faults, values)
        elif item.default is item.default_factory is dataclasses.MISSING:
            faults.append(f"{key}{item.name} is missing; every {_words(kind)} needs it")
    known = [item.name for item in fields(kind)]
    for name in table:
        if name not in known:
            faults.append(_misplaced(key, name, kind) or unknown_key(f"{key}{name}", name, known))
    return None if faults else kind(**values)


def _convert_field(
    value: Any,
    item: dataclasses.Field[Any],
    key: str,
    faults: list[str],
    values: dict[str, Any],
) -> None:
    """Convert the value of a field into `values`, and check it by its option."""
    # The default is valid, and most of the fields of a scene have it.
    if value is item.default:
        values[item.name] = value
        return
    wing = item.metadata.get("wing", "")
    if not is_here(wing) and value != default_of(item):
        faults.append(f"{key}{item.name}: no such key without the wing {wing}; leave it out")
        return
    before = len(faults)
    values[item.name] = converted(value, item.type, f"{key}{item.name}", faults)
    if "option" in item.metadata and len(faults) == before:
        fault = item.metadata["option"].fault(values[item.name])
        if fault:
            faults.append(f"{key}{item.name} {fault}")


def _misplaced(key: str, name: str, kind: type) -> str:
    """The message for a key that belongs to a table in this one, such as a drive outside [joints].

    It is empty for any other key.
    """
    for item in fields(kind):
        inner = [part for part in (item.type, *get_args(item.type)) if is_dataclass(part)]
        if inner and name in [part.name for part in fields(inner[0])]:
            table = re.sub(r"\[\d+\]", "", f"{key}{item.name}")
            return f"{key}{name}: no such key; it belongs in [{table}]"
    return ""


def _words(kind: type) -> str:
    """The name of a record in words, such as "loop end"."""
    return re.sub(r"(?<=[a-z])(?=[A-Z])", " ", kind.__name__).lstrip("_").lower()


def unknown_key(key: str, name: str, known: Iterable[str]) -> str:
    """The message for a key that no record has: its position, and the nearest valid key or all."""
    known = list(known)
    near = difflib.get_close_matches(name, known, n=1, cutoff=0.7)
    if near:
        return f"{key}: no such key; nearest: {near[0]}"
    hint = f"valid here: {', '.join(known[:MOST_KEYS])}"
    if len(known) > MOST_KEYS:
        hint += f" and {len(known) - MOST_KEYS} more, which shockpc schema lists"
    return f"{key}: no such key; {hint}"


def _leaf(value: Any, kind: Any) -> Any:
    """A text, a number, a word or a vector; None if it does not fit."""
    if kind is float:
        fits = isinstance(value, Real) and not isinstance(value, bool)
        return float(value) if fits and abs(value) <= LARGEST_NUMBER else None
    if kind is bool:
        return value if isinstance(value, bool) else None
    if kind is str:
        return os.fspath(value) if isinstance(value, str | Path) else None
    if get_origin(kind) is Literal:
        return value if isinstance(value, str) and value in get_args(kind) else None
    if not isinstance(value, tuple | list | np.ndarray) or len(value) != len(get_args(kind)):
        return None
    vector = tuple(_leaf(part, float) for part in value)
    return None if None in vector else vector


def _wanted(kind: Any) -> str:
    """The values that a field accepts, in words."""
    origin, parts = get_origin(kind), get_args(kind)
    if origin is Literal:
        return " or ".join(
            filter(None, [", ".join(inline(part) for part in parts[:-1]), inline(parts[-1])])
        )
    if is_dataclass(kind):
        return "a table"
    if origin is Mapping:
        return f"a table, each of its values {_wanted(parts[1])}"
    if origin is tuple and parts[1:] == (...,):
        if isinstance(parts[0], type) and is_dataclass(parts[0]):
            return f"a list of tables, each begun with [[{parts[0].__name__.lower()}]]"
        return f"a list, each of its entries {_wanted(parts[0])}"
    if origin is tuple:
        return f"a list of {len(parts)} numbers up to {LARGEST_NUMBER:g}"
    if parts:
        return " or ".join(_wanted(part) for part in parts)
    return {float: f"a number up to {LARGEST_NUMBER:g}", bool: "true or false"}.get(
        kind, "text in quotes"
    )


def _shown(value: Any) -> str:
    text = inline(value)
    return text if len(text) <= 60 else text[:59] + "…"


def toml_lines(table: Mapping[str, Any], name: str = "") -> list[str]:
    """A table as TOML, with one line for each vector."""
    lines, parts = [], []
    for key, value in table.items():
        path = f"{name}.{_toml_key(key)}" if name else _toml_key(key)
        if isinstance(value, Mapping):
            parts += ["", f"[{path}]", *toml_lines(value, path)]
        elif isinstance(value, list) and value and isinstance(value[0], Mapping):
            for item in value:
                parts += ["", f"[[{path}]]", *toml_lines(item, path)]
        else:
            lines.append(f"{_toml_key(key)} = {inline(value)}")
    return lines + parts


def _toml_key(key: str) -> str:
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else inline(key)


def inline(value: Any) -> str:
    """A value as TOML on one line.

    JSON's strings, numbers and lists are valid TOML, except for one control character.
    """
    return json.dumps(value, ensure_ascii=False, default=str).replace("\x7f", "\\u007f")
