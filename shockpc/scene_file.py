"""Scenes as TOML files: read and checked, written so that the same scene comes back.

pydantic checks the very dataclasses of `scene`, so the files, their JSON Schema and the Python records cannot drift apart.
"""

import dataclasses
import os
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
        faults = [_fault(error) for error in refusal.errors(include_url=False)]
        raise SceneError(f"{path}: " + "; ".join(dict.fromkeys(faults))) from None
    return _with_paths(scene, lambda found: os.path.normpath(path.resolve().parent / found))


def scene_text(scene: Scene, folder: Path) -> str:
    """The TOML text of a scene for a file in `folder`, with paths relative to it."""
    import tomli_w

    here = folder.resolve()
    return tomli_w.dumps(scene_table(_with_paths(scene, lambda found: os.path.relpath(found, here))))


def scene_schema() -> dict[str, Any]:
    """The JSON Schema of a scene file, for editors."""
    schema: dict[str, Any] = _adapter().json_schema()
    return schema | {"title": "shockpc scene"}


def _adapter() -> Any:
    """pydantic's checker of `Scene`: unknown keys and numbers that are not finite are faults."""
    from pydantic import TypeAdapter

    return TypeAdapter(Scene)


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


def _fault(error: Mapping[str, Any]) -> str:
    """One of pydantic's findings in our words: the key, what is wrong, what would be valid."""
    where = [part for part in error["loc"] if isinstance(part, int) or not part[:1].isupper()]
    key = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in where).lstrip(".")
    if error["type"] in ("unexpected_keyword_argument", "extra_forbidden"):
        return f"{key}: no such key; valid here: {', '.join(_keys_at(where[:-1]))}"
    if error["type"] in ("missing", "missing_argument"):
        return f"{key}: is missing"
    return f"{key}: {error['msg'][0].lower()}{error['msg'][1:]}, not {error['input']!r}"


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
