"""Scenes read from and written to TOML files, checked, and what follows from them.

Robot, points and plane follow from a scene.

Scenes from files and scenes built in Python are checked against the same field types. Only the JSON
Schema is made by pydantic, whose import would lengthen the start of every command by a third.
"""

import dataclasses
import functools
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from shockpc.core.number import number_from
from shockpc.core.spatial import Array, Plane, freeze, plane_from
from shockpc.landing.scenes.joint_options import Joints
from shockpc.landing.scenes.scene import Point, Scene
from shockpc.landing.scenes.strike import Strike
from shockpc.robot.load import shared_robot
from shockpc.robot.robot import Robot
from shockpc.text.arguments import checked
from shockpc.text.errors import SceneError
from shockpc.text.paths import is_path, usable_path
from shockpc.text.printed import printable
from shockpc.text.toml import converted, reading, toml_lines
from shockpc.text.wings import is_here

PLANES = {"xz": (0.0, -1.0, 0.0), "yz": (1.0, 0.0, 0.0), "xy": (0.0, 0.0, 1.0)}
"""The named planes by their normals."""


@functools.cache
def _named_plane(name: str) -> Plane:
    plane = plane_from(PLANES[name])
    freeze(plane)
    return plane


def points_at(robot: Robot, text: str) -> tuple[Point, ...]:
    """The points that FRAME or FRAME:x,y,z means.

    The frame's name may hold a colon; a glob means a point on each frame.

    Raises:
        UnknownName: the robot has no such frame.
        SceneError: the offset is not three finite numbers.
    """
    frame, colon, offset = text.rpartition(":")
    if not colon or text in robot.frames:
        return tuple(Point(frame=name) for name in robot.match_frames(text))
    try:
        x, y, z = map(number_from, offset.split(","))
    except ValueError:
        raise SceneError(
            f'"{text}" is not a point; give FRAME or FRAME:x,y,z, such as {frame}:0,0,0.1'
        ) from None
    return tuple(Point(frame=name, offset=(x, y, z)) for name in robot.match_frames(frame))


def point_at(robot: Robot, text: str) -> Point:
    """The one point that a text means, as in `points_at`.

    Raises:
        ShockError: as for `points_at`, or a glob means several points.
    """
    points = points_at(robot, text)
    if len(points) > 1:
        raise robot.unknown("single point", text, (point.label for point in points))
    return points[0]


ARM = 0.5
"""Distance from the base at which a rotation counts as a velocity where the plane is chosen [m]."""

S = TypeVar("S", bound=Scene)


def with_plane(scene: Scene) -> Scene:
    """The scene with its plane, or that in which its motion before the impact happens.

    That is the frontal plane where more than half of the motion is sideways. The jumps do not
    decide: they turn with the foot that is struck, the posture and the masses, so that two designs
    would be compared in different planes.

    Raises:
        SceneError: as for `Strike.vector`.
    """
    if scene.plane != "auto":
        return scene
    return replace(scene, plane="yz" if sideways(scene.strike) > 0.5 else "xz")


def sideways(strike: Strike) -> float:
    """Share of a motion before the impact that is in the frontal plane only [1].

    It is along y, and about x as in a fall to the side.

    A rotation counts as the velocity at `ARM` from the base; a strike angle is in the sagittal
    plane.

    Raises:
        SceneError: as for `Strike.vector`.
    """
    turning = ARM * np.array(strike.angular_velocity or (0.0, 0.0, 0.0))
    motion = np.concatenate([strike.vector(_named_plane("xz")), turning])
    length = np.linalg.norm(motion) or 1.0
    return float(np.hypot(motion[1], motion[3]) / length)


def plane_of(scene: Scene) -> Plane:
    """The plane of a scene as unit vectors.

    Raises:
        SceneError: the normal has length zero.
    """
    plane = with_plane(scene).plane
    try:
        return _named_plane(plane) if isinstance(plane, str) else plane_from(plane)
    except ValueError as refusal:
        raise SceneError(
            f"plane: {refusal}; valid are auto, xz, yz, xy or a normal such as 0,-1,0"
        ) from None


def ground_normal(plane: Plane, velocity: Array | Sequence[float]) -> Array:
    """The ground's normal (3,) where no contact gives one: up.

    It is a wall's where the plane is seen from above and struck within it.
    """
    return plane.e2 if plane.level and velocity[2] == 0.0 else np.array([0.0, 0.0, 1.0])


def check_scene(scene: Scene) -> Scene:
    """Check a scene built in Python as a file is checked.

    Returns: the scene with every list and array as a tuple of floats.

    Raises:
        SceneError: a field has a wrong type, length or word, or a number is not finite or out of
            range.
    """
    if not isinstance(scene, Scene):
        raise SceneError(
            f"{printable(repr(scene), 60)} is not a Scene; make one with Scene(robot=..., "
            f"contact=...), or by read_scene"
        )
    faults: list[str] = []
    checked_scene: Scene | None = converted(scene, Scene, "", faults)
    if checked_scene is None:
        raise SceneError("; ".join(faults))
    return checked_scene


def robot_of(scene: Scene, frames: Sequence[str] = ()) -> Robot:
    """The robot of a scene, with its xacro arguments, packages and postures.

    It is one object for all scenes of the same robot.

    It is loaded again when one of its files has changed.

    Args:
        scene: the scene.
        frames: names or globs of the contacts, where they are not in the scene yet.

    Raises:
        ShockError: a field of the scene is not valid, or the robot cannot be read.
    """
    scene = check_scene(scene)
    frames = frames or [contact.frame for contact in scene.contact]
    return shared_robot(
        scene.robot,
        scene.xacro,
        scene.packages,
        scene.srdf,
        frames,
        scene.base in ("free", "planar"),
    )


@checked
def read_scene(path: Path | str) -> Scene:
    """Read a scene file.

    Paths in it are relative to the file's folder and are returned as absolute paths.

    Raises:
        SceneError: the file cannot be read or is not a scene; the text names the file, the key and
            what would be valid.
    """
    path = Path(path)
    with reading(path, "scene", SceneError) as table:
        return scene_from(Scene, table, path.resolve().parent)


def scene_of(source: Scene | str | os.PathLike[str]) -> Scene:
    """A scene as it is, or the scene of a text or path.

    A path that ends in .toml is read; else the scene is of the robot of that name, without
    contacts.

    Raises:
        SceneError: as for `read_scene`.
    """
    if isinstance(source, Scene):
        return source
    path = Path(source)
    return read_scene(path) if path.suffix.casefold() == ".toml" else Scene(robot=source)


def scene_from(kind: type[S], table: Mapping[str, Any], folder: Path, key: str = "") -> S:
    """A scene from its table. Paths in it are relative to a folder and become absolute.

    Args:
        kind: `Scene`, or one with more fields.
        table: as TOML gives it.
        folder: where the file lies.
        key: position of the table in the file, for messages.

    Raises:
        SceneError: a key or its value does not fit; the text says what would be valid.
    """
    faults: list[str] = []
    contact = table.get("contact")
    named = [contact] if isinstance(contact, str) else contact
    if isinstance(named, list):
        contacts: list[Any] = []
        for stated in named:
            contacts.append({"frame": stated} if isinstance(stated, str) else stated)
        table = {**table, "contact": contacts}
    scene: S | None = converted(table, kind, key, faults)
    if scene is None or faults:
        raise SceneError("; ".join(faults))
    try:
        return with_paths(scene, lambda path: os.path.normpath(folder / usable_path(path)))
    except ValueError as refusal:
        raise SceneError(str(refusal)) from None


def scene_text(scene: Scene, folder: Path) -> str:
    """The TOML text of a scene for a file in `folder`, with paths relative to the folder."""
    here = folder.resolve()

    def relative(name: str) -> str:
        path = os.path.relpath(name, here)
        # Without a separator or a suffix, a path would be read as a robot's name.
        clear = path in (os.curdir, os.pardir) or os.sep in path or Path(path).suffix
        return path if clear else os.path.join(os.curdir, path)

    return "\n".join(toml_lines(scene_table(with_paths(scene, relative)))) + "\n"


def scene_schema() -> dict[str, Any]:
    """The JSON Schema of a scene file, for editors."""
    return record_schema(Scene) | {"title": "shockpc scene"}


def record_schema(record: type) -> dict[str, Any]:
    """The JSON Schema of a table that becomes a record."""
    from pydantic import TypeAdapter

    schema = TypeAdapter(record).json_schema()
    for kind, table in ((record, schema), (Joints, schema.get("$defs", {}).get("Joints", {}))):
        for part in dataclasses.fields(kind):
            if not is_here(part.metadata.get("wing", "")):
                table.get("properties", {}).pop(part.name, None)
    # names stand for contacts at the frames of these names
    if contacts := schema.get("properties", {}).get("contact"):
        contacts["items"] = {"anyOf": [contacts["items"], {"type": "string"}]}
        schema["properties"]["contact"] = {"anyOf": [contacts, {"type": "string"}]}
    return schema


def scene_table(record: Any) -> dict[str, Any]:
    """A scene, or a part of one, as nested tables for TOML and JSON.

    Fields that are not set are left out.
    """

    def plain(value: Any) -> Any:
        if dataclasses.is_dataclass(value):
            table = {}
            for item in dataclasses.fields(value):
                if not is_here(item.metadata.get("wing", "")):
                    continue
                part = plain(getattr(value, item.name))
                # An empty list says something where it is not the default.
                is_default = part == [] and item.default == ()
                if part not in (None, {}) and not is_default:
                    table[item.name] = part
            return table
        if isinstance(value, Mapping):
            return {key: plain(part) for key, part in value.items()}
        return [plain(part) for part in value] if isinstance(value, tuple) else value

    table: dict[str, Any] = plain(record)
    return table


def with_paths(scene: S, change: Callable[[str], str]) -> S:
    """The scene with every path in it changed; a robot's name is not a path."""
    robot = scene.robot
    if is_path(robot):
        robot = change(robot)
    joints = scene.joints
    if joints.drives is not None and is_path(joints.drives):
        joints = replace(joints, drives=change(joints.drives))
    return replace(
        scene,
        robot=robot,
        srdf=None if scene.srdf is None else change(scene.srdf),
        packages={name: change(folder) for name, folder in scene.packages.items()},
        joints=joints,
    )
