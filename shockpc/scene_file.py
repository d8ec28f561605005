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
from shockpc.scene import Scene, scene_table

__all__ = ["read_scene", "scene_schema", "scene_text"]


def read_scene(path: Path) -> Scene:
    """Read a scene file. Paths in it are relative to the file's folder and come back absolute.

    Raises:
        SceneError: the file cannot be read or is not a scene; the text names the file, the key and what would be valid.
    """
    from pydantic import ValidationError

    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as refusal:
        raise SceneError(f"{path}: cannot be read: {refusal.strerror}") from None
    except UnicodeDecodeError:
        raise SceneError(f"{path}: is not UTF-8 text; a scene is a TOML file") from None
    except tomllib.TOMLDecodeError as refusal:
        raise SceneError(f"{path}: is not TOML: {refusal}") from None
    try:
        scene: Scene = _adapter().validate_python(table)
    except ValidationError as refusal:
        faults: dict[str, list[str]] = {}
        for error in refusal.errors(include_url=False):
            key, text = _fault(error)
            faults.setdefault(key, []).append(text)
        listed = "; ".join(f"{key}: {' or '.join(dict.fromkeys(texts))}" for key, texts in faults.items())
        raise SceneError(f"{path}: {listed}") from None
    return _with_paths(scene, lambda found: os.path.normpath(path.resolve().parent / found))


def scene_text(scene: Scene, folder: Path) -> str:
    """The TOML text of a scene for a file in `folder`, with paths relative to it."""
    here = folder.resolve()
    return "\n".join(_toml_lines(scene_table(_with_paths(scene, lambda found: os.path.relpath(found, here))))) + "\n"


def scene_schema() -> dict[str, Any]:
    """The JSON Schema of a scene file, for editors."""
    schema: dict[str, Any] = _adapter().json_schema()
    return schema | {"title": "shockpc scene"}


def _adapter() -> Any:
    """pydantic's checker of `Scene`: unknown keys and numbers that are not finite are faults."""
    from pydantic import TypeAdapter

    return TypeAdapter(Scene)


def _toml_lines(table: Mapping[str, Any], name: str = "") -> list[str]:
    """A table of a scene as TOML, a vector to a line; JSON's strings, numbers and lists are TOML's too."""

    def inline(value: Any) -> str:
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")

    lines, parts = [], []
    for key, value in table.items():
        path = f"{name}.{_toml_key(key)}" if name else _toml_key(key)
        if isinstance(value, Mapping):
            parts += ["", f"[{path}]", *_toml_lines(value, path)]
        elif isinstance(value, list) and value and isinstance(value[0], Mapping):
            for item in value:
                parts += ["", f"[[{path}]]", *_toml_lines(item, path)]
        else:
            lines.append(f"{_toml_key(key)} = {inline(value)}")
    return lines + parts


def _toml_key(key: str) -> str:
    """A key, in quotes where TOML wants them."""
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else json.dumps(key, ensure_ascii=False)


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


def _fault(error: Mapping[str, Any]) -> tuple[str, str]:
    """One of pydantic's findings in our words: the key; what is wrong with it and what would be valid."""
    # Behind a key, pydantic names the kinds that it tried in turn ("literal[…]", "tuple[…]"); those are not in the file.
    where = [part for part in error["loc"] if isinstance(part, int) or "[" not in part]
    key = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in where).lstrip(".")
    if error["type"] in ("unexpected_keyword_argument", "extra_forbidden"):
        return key, f"no such key; valid here: {', '.join(_keys_at(where[:-1]))}"
    if error["type"] in ("missing", "missing_argument", "missing_keyword_only_argument"):
        return key, "is missing"
    return key, f"{error['msg'][0].lower()}{error['msg'][1:]}, not {error['input']!r}"


def _keys_at(where: list[Any]) -> list[str]:
    """The keys that a table of the scene may have."""
    record: Any = Scene
    for part in where:
        if isinstance(part, int):
            continue
        found = typing.get_type_hints(record)[part]
        options = [found, *typing.get_args(found)]
        record = next(option for option in options if dataclasses.is_dataclass(option))
    return [item.name for item in dataclasses.fields(record)]
