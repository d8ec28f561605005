"""Scenes as TOML files: read and checked, written so that the same scene comes back.

pydantic checks the very dataclasses of `scene`, so the files, their JSON Schema and the Python records cannot drift apart.
"""

import dataclasses
import json
import os
import re
import tomllib
import typing
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from shockpc.errors import SceneError
from shockpc.paths import usable_path
from shockpc.scene import Scene, scene_table

__all__ = ["read_scene", "scene_schema", "scene_text"]


def read_scene(path: Path) -> Scene:
    """Read a scene file. Paths in it are relative to the file's folder and come back absolute.

    Raises:
        SceneError: the file cannot be read or is not a scene; the text names the file, the key and what would be valid.
    """
    from pydantic import ValidationError

    try:
        table = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except FileNotFoundError:
        raise SceneError(f'no scene file "{path}" (looked in {Path.cwd()})') from None
    except IsADirectoryError:
        raise SceneError(f'"{path}" is a folder; give the scene file in it') from None
    except OSError as refusal:
        raise SceneError(f'"{path}" cannot be read: {refusal.strerror}; check its permissions') from None
    except UnicodeDecodeError:
        raise SceneError(f"{path} is not UTF-8 text; a scene is TOML, a robot is URDF, xacro or MJCF, and both are text") from None
    except ValueError as refusal:
        raise SceneError(f"{path} is not TOML, as a scene has to be: {refusal}") from None
    except RecursionError:
        raise SceneError(f"{path} nests its tables or lists too deeply for a scene, which needs three levels") from None
    try:
        # As JSON, because pydantic is strict about kinds there and still takes lists for tuples and 1 for 1.0.
        scene: Scene = _adapter().validate_json(json.dumps(table, default=str), strict=True)
    except ValidationError as refusal:
        faults = dict.fromkeys(_fault(error["loc"], table) for error in refusal.errors(include_url=False))
        raise SceneError(f"{path}: {'; '.join(faults)}") from None
    here = path.resolve().parent
    try:
        return _with_paths(scene, lambda found: os.path.normpath(here / usable_path(found)))
    except ValueError as refusal:
        raise SceneError(f"{path}: {refusal}") from None


def scene_text(scene: Scene, folder: Path) -> str:
    """The TOML text of a scene for a file in `folder`, with paths relative to it."""
    here = folder.resolve()

    def beside(found: str) -> str:
        path = os.path.relpath(found, here)
        # Without a slash or a suffix, a path would be read as a robot's name.
        clear = path in (os.curdir, os.pardir) or os.sep in path or Path(path).suffix
        return path if clear else os.path.join(os.curdir, path)

    return "\n".join(_toml_lines(scene_table(_with_paths(scene, beside)))) + "\n"


def scene_schema() -> dict[str, Any]:
    """The JSON Schema of a scene file, for editors."""
    schema: dict[str, Any] = _adapter().json_schema()
    return schema | {"title": "shockpc scene"}


def _adapter() -> Any:
    """The checker of `Scene`, by pydantic: unknown keys and numbers that are not finite are faults."""
    from pydantic import TypeAdapter

    return TypeAdapter(Scene)


def _toml_lines(table: Mapping[str, Any], name: str = "") -> list[str]:
    """A table of a scene as TOML, a vector to a line."""
    lines, parts = [], []
    for key, value in table.items():
        path = f"{name}.{_toml_key(key)}" if name else _toml_key(key)
        if isinstance(value, Mapping):
            parts += ["", f"[{path}]", *_toml_lines(value, path)]
        elif isinstance(value, list) and value and isinstance(value[0], Mapping):
            for item in value:
                parts += ["", f"[[{path}]]", *_toml_lines(item, path)]
        else:
            lines.append(f"{_toml_key(key)} = {_inline(value)}")
    return lines + parts


def _toml_key(key: str) -> str:
    """A key, in quotes where TOML wants them."""
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else _inline(key)


def _inline(value: Any) -> str:
    """A value on one line: JSON's texts, numbers and lists are TOML's too, but for one control character."""
    return json.dumps(value, ensure_ascii=False, default=str).replace("\x7f", "\\u007f")


def _with_paths(scene: Scene, change: typing.Callable[[str], str]) -> Scene:
    """The scene with every path in it changed; a robot's name is not a path."""
    robot = scene.robot
    if os.sep in robot or Path(robot).suffix:
        robot = change(robot)
    return dataclasses.replace(
        scene,
        robot=robot,
        srdf=None if scene.srdf is None else change(scene.srdf),
        packages={name: change(folder) for name, folder in scene.packages.items()},
    )


def _fault(place: tuple[int | str, ...], table: Any) -> str:
    """What is wrong at a place where pydantic found a fault: the key, what stands there, and what would be valid."""
    key, kind, value = "", Scene, table
    for part in place:
        if dataclasses.is_dataclass(kind):
            kinds = {name: _kind(hint) for name, hint in typing.get_type_hints(kind).items()}
            if part not in kinds:
                return f"{key}{part}: no such key; valid here: {', '.join(kinds)}"
            if part not in value:
                return f"{key}{part} is missing; every {getattr(kind, '__name__', 'table').lower()} needs it"
            kind = kinds[str(part)]
        elif typing.get_origin(kind) is Mapping:
            kind = typing.get_args(kind)[1]
        elif typing.get_args(kind)[1:] == (...,):
            kind = typing.get_args(kind)[0]
        else:
            break  # a vector or a choice is one value: what is inside it is pydantic's business
        value = value[part]
        key = f"{key.rstrip('.')}[{part}]." if isinstance(part, int) else f"{key}{_toml_key(part)}."
    found = _inline(value)
    return f"{key.rstrip('.')} has to be {_wanted(kind)}, not {found if len(found) <= 60 else found[:59] + '…'}"


def _kind(hint: Any) -> Any:
    """What a key holds, if it is there at all."""
    options = [option for option in typing.get_args(hint) if option is not type(None)]
    return options[0] if type(None) in typing.get_args(hint) and len(options) == 1 else hint


def _wanted(kind: Any) -> str:
    """What would be valid, in words."""
    origin, parts = typing.get_origin(kind), typing.get_args(kind)
    if origin is typing.Literal:
        return " or ".join(filter(None, [", ".join(_inline(part) for part in parts[:-1]), _inline(parts[-1])]))
    if dataclasses.is_dataclass(kind):
        return "a table"
    if origin is Mapping:
        return f"a table, each of its values {_wanted(parts[1])}"
    if origin is tuple and parts[1:] == (...,):
        if isinstance(parts[0], type) and dataclasses.is_dataclass(parts[0]):
            return f"a list of tables, each begun with [[{parts[0].__name__.lower()}]]"
        return f"a list, each of its entries {_wanted(parts[0])}"
    if origin is tuple:
        return f"a list of {len(parts)} finite numbers"
    if parts:
        return " or ".join(_wanted(part) for part in parts)
    return "a finite number" if kind is float else "text in quotes"
