"""A scene: one landing of one robot. Read from and written to TOML files.

The scene holds everything that the result depends on: robot, posture, strike, contacts and plane. Scenes from files and scenes
built in Python are checked against the same field types. Only the JSON Schema is made by pydantic, whose import would lengthen the
start of every command by a third.
"""

import dataclasses
import difflib
import functools
import json
import math
import os
import re
import tomllib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, fields, is_dataclass
from numbers import Real
from pathlib import Path
from typing import Any, Literal, get_args, get_origin, get_type_hints

import numpy as np

from shockpc.core.spatial import Array, Plane, plane_from
from shockpc.errors import SceneError
from shockpc.model import CHECKED
from shockpc.model.closure import Closure
from shockpc.model.columns import Base
from shockpc.model.contact import Contact
from shockpc.model.joint_model import LARGEST, Joints
from shockpc.model.posture import Posture
from shockpc.paths import usable_path

__all__ = [
    "GRAVITY",
    "PLANES",
    "Point",
    "Scene",
    "Strike",
    "check_scene",
    "plane_of",
    "read_scene",
    "scene_schema",
    "scene_table",
    "scene_text",
]

GRAVITY = 9.80665
"""Standard acceleration of free fall [m/s²]: converts a drop height to a speed."""

PLANES = {"xz": (0.0, -1.0, 0.0), "yz": (1.0, 0.0, 0.0), "xy": (0.0, 0.0, 1.0)}
"""The named planes by their normals."""

SLOWEST, FASTEST = 1e-9, 1e9
"""Range of speeds [m/s]; outside it squares overflow or underflow."""


@dataclass(frozen=True, kw_only=True)
class Strike:
    """Velocity of the robot relative to the ground before the impact; 1 m/s straight down by default.

    The velocity of the base frame's origin is given as speed and angle, as a vector or by a drop height. The rotation of the base
    and the joint velocities are superposed.

    Attributes:
        speed: magnitude of the velocity [m/s].
        strike_angle_deg: angle of the velocity from the vertical in the plane, positive for forward motion [deg].
        velocity: the velocity as a vector, world axes [m/s].
        drop_height: height of the free fall before the impact [m].
        angular_velocity: angular velocity of the base, world axes [rad/s].
        joint_velocities: joint velocities by name or glob [rad/s; m/s for a prismatic joint].
    """

    __pydantic_config__ = CHECKED

    speed: float | None = None
    strike_angle_deg: float | None = None
    velocity: tuple[float, float, float] | None = None
    drop_height: float | None = None
    angular_velocity: tuple[float, float, float] | None = None
    joint_velocities: Mapping[str, float] = field(default_factory=dict)

    def vector(self, plane: Plane) -> Array:
        """The velocity (3,) in world axes [m/s]: speed · (sin θ · forward − cos θ · z).

        Down is −z of the world for every plane. Forward is the horizontal direction in the plane with a positive x component, or a
        positive y component if the plane is perpendicular to x.

        Raises:
            SceneError: it is given in two ways at once, the speed is out of range, or an angle is given in a horizontal plane.
        """
        ways = [
            self.speed is not None or self.strike_angle_deg is not None,
            self.velocity is not None,
            self.drop_height is not None,
        ]
        if sum(ways) > 1:
            raise SceneError("the strike is given in two ways; keep one of: speed with strike angle, velocity, drop height")
        if self.velocity is not None:
            velocity = np.array(self.velocity, dtype=float)
            if velocity.any():
                _check_speed(float(np.abs(velocity).max()))
            return velocity
        up = np.array([0.0, 0.0, 1.0])
        if self.drop_height is not None:
            if not self.drop_height > 0.0:
                raise SceneError(f"a drop height of {self.drop_height:g} m gives no impact; it has to be above zero")
            fall = math.sqrt(2.0 * GRAVITY * self.drop_height)
            _check_speed(fall)
            return -fall * up
        speed = 1.0 if self.speed is None else self.speed
        if not speed > 0.0:
            raise SceneError(f"a strike speed of {speed:g} m/s gives no impact; it has to be above zero")
        _check_speed(speed)
        degrees = self.strike_angle_deg or 0.0
        if not abs(degrees) <= 180.0:
            raise SceneError(f"a strike angle of {degrees:g} deg is no angle; it lies between -180 and 180 deg")
        if degrees == 0.0:
            return -speed * up
        if abs(plane.normal[2]) > 1.0 - 1e-9:
            raise SceneError("a plane seen from above holds no vertical to measure a strike angle from; give the strike's velocity")
        theta = math.radians(degrees)
        return np.asarray(speed * (math.sin(theta) * plane.forward - math.cos(theta) * up))


def _check_speed(speed: float) -> None:
    """Refuse a speed out of range."""
    if not SLOWEST <= speed <= FASTEST:
        raise SceneError(
            f"a strike at {speed:g} m/s cannot be computed; its speed has to lie between {SLOWEST:g} and {FASTEST:g} m/s"
        )


@dataclass(frozen=True, kw_only=True)
class Point:
    """A point at which the shock is computed.

    Attributes:
        frame: link, joint or site.
        offset: from the origin of the frame, in its axes [m].
    """

    __pydantic_config__ = CHECKED

    frame: str
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True, kw_only=True)
class Scene:
    """One landing of one robot.

    Attributes:
        robot: a name that `shockpc robots` lists, or the path of a URDF, xacro or MJCF file.
        base: free; planar (moves and rotates in the plane only); fixed. By default free, or fixed where an MJCF file fixes it
            or the root link is called world.
        plane: xz (sagittal), yz (frontal), xy (horizontal), or the normal of another plane.
        srdf: file of reference postures; by default the one beside the robot.
        packages: folders of packages, for `package://` and `$(find …)`.
        xacro: arguments of a xacro file.
        posture: posture of base and joints.
        strike: velocity relative to the ground.
        contact: the contacts that strike at the same time; from Python also one contact, or names of frames.
        stance: frames that are already on the ground and stay where they are.
        closure: loops, in addition to those of the robot's file.
        assemble: patterns of the joints that may move to close the loops; by default all joints that the posture does not set.
        joints: joint model (free, geared or locked).
        point: points at which the shock is computed, in addition to the robot's sensors.
        v_in: speed that normalises shock: of the contact, or of the robot's centre of mass.
        pulse: shape and duration of the pulse for peak accelerations, such as "half-sine:5ms".
        range_g: measuring range of the sensors, with which peak accelerations are compared [g].

    Raises:
        SceneError: a path holds a NUL character.
    """

    __pydantic_config__ = CHECKED

    robot: str
    base: Base | None = None
    plane: Literal["xz", "yz", "xy"] | tuple[float, float, float] = "xz"
    srdf: str | None = None
    packages: Mapping[str, str] = field(default_factory=dict)
    xacro: Mapping[str, str] = field(default_factory=dict)
    posture: Posture = field(default_factory=Posture)
    strike: Strike = field(default_factory=Strike)
    contact: tuple[Contact, ...] = ()
    stance: tuple[str, ...] = ()
    closure: tuple[Closure, ...] = ()
    assemble: tuple[str, ...] = ()
    joints: Joints = field(default_factory=Joints)
    point: tuple[Point, ...] = ()
    v_in: Literal["contact", "com"] = "contact"
    pulse: str | None = None
    range_g: float | None = None

    def __post_init__(self) -> None:
        """Make the contacts a tuple of `Contact`, and refuse paths that no file can have."""
        contact: Any = self.contact
        contacts = contact if isinstance(contact, tuple | list) else (contact,)
        object.__setattr__(self, "contact", tuple(Contact(frame=one) if isinstance(one, str) else one for one in contacts))
        for path in (self.robot, self.srdf, *(self.packages.values() if isinstance(self.packages, Mapping) else ())):
            if isinstance(path, str) and "\0" in path:
                raise SceneError(f"{_inline(path)} cannot be the path of a file: it holds a NUL character")


def plane_of(scene: Scene) -> Plane:
    """The plane of a scene as unit vectors.

    Raises:
        SceneError: the normal has length zero.
    """
    try:
        return plane_from(PLANES[scene.plane] if isinstance(scene.plane, str) else scene.plane)
    except ValueError as refusal:
        raise SceneError(f"plane: {refusal}; valid are xz, yz, xy or a normal such as 0,-1,0") from None


def check_scene(scene: Scene) -> Scene:
    """Check a scene built in Python as a file is checked, and the range of its numbers.

    Returns: the scene with every list and array as a tuple of floats.

    Raises:
        SceneError: a field has a wrong type, length or word, or a number is not finite or out of range.
    """
    faults: list[str] = []
    checked: Scene | None = _checked(scene, Scene, "", faults)
    if checked is None:
        raise SceneError("; ".join(faults))
    for key, number in _numbers(checked, ""):
        rate = key.startswith(("strike.angular_velocity", "strike.joint_velocities"))
        if abs(number) > FASTEST if rate else abs(number) > LARGEST and not key.startswith("strike."):
            raise SceneError(f"{key} is {number:g}, which is out of range; give a number up to {FASTEST if rate else LARGEST:g}")
    return checked


def read_scene(path: Path) -> Scene:
    """Read a scene file. Paths in it are relative to the file's folder and are returned as absolute paths.

    Raises:
        SceneError: the file cannot be read or is not a scene; the text names the file, the key and what would be valid.
    """
    faults: list[str] = []
    if path.is_fifo() or path.is_char_device() or path.is_block_device():
        raise SceneError(f'"{path}" is a pipe or a device; save what it gives in a file')
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8-sig"))
        scene = _checked(table, Scene, "", faults)
    except FileNotFoundError:
        raise SceneError(f'no scene file "{path}" (looked in {Path.cwd()})') from None
    except IsADirectoryError:
        raise SceneError(f'"{path}" is a folder; give the scene file in it') from None
    except OSError as refusal:
        raise SceneError(f'"{path}" cannot be read: {refusal.strerror}; check its permissions') from None
    except UnicodeDecodeError:
        raise SceneError(f"{path} is not UTF-8 text; a scene is TOML, a robot is URDF, xacro or MJCF, and both are text") from None
    except tomllib.TOMLDecodeError as refusal:
        raise SceneError(f"{path} is not TOML, as a scene has to be: {refusal}") from None
    except SceneError as refusal:
        raise SceneError(f"{path}: {refusal}") from None
    except RecursionError:
        raise SceneError(f"{path} is nested hundreds of levels deep; a scene needs four") from None
    except ValueError:
        found = "is no path of a file: it holds a NUL character" if "\0" in str(path) else "holds an integer of thousands of digits"
        raise SceneError(f'"{path}" {found}'.replace("\0", "\\0")) from None
    if faults:
        raise SceneError(f"{path}: {'; '.join(faults)}")
    here = path.resolve().parent
    try:
        return _with_paths(scene, lambda found: os.path.normpath(here / usable_path(found)))
    except ValueError as refusal:
        raise SceneError(f"{path}: {refusal}") from None


def scene_text(scene: Scene, folder: Path) -> str:
    """The TOML text of a scene for a file in `folder`, with paths relative to the folder."""
    here = folder.resolve()

    def relative(found: str) -> str:
        path = os.path.relpath(found, here)
        # Without a separator or a suffix, a path would be read as a robot's name.
        clear = path in (os.curdir, os.pardir) or os.sep in path or Path(path).suffix
        return path if clear else os.path.join(os.curdir, path)

    return "\n".join(_toml_lines(scene_table(_with_paths(scene, relative)))) + "\n"


def scene_schema() -> dict[str, Any]:
    """The JSON Schema of a scene file, for editors."""
    from pydantic import TypeAdapter

    schema: dict[str, Any] = TypeAdapter(Scene).json_schema()
    return schema | {"title": "shockpc scene"}


def scene_table(record: Any) -> dict[str, Any]:
    """A scene, or a part of one, as nested tables for TOML and JSON; fields that are not set are left out."""
    table: dict[str, Any] = {}
    for item in fields(record):
        value = getattr(record, item.name)
        if is_dataclass(value):
            value = scene_table(value)
        elif isinstance(value, tuple):
            value = [scene_table(part) if is_dataclass(part) else list(part) if isinstance(part, tuple) else part for part in value]
        elif isinstance(value, Mapping):
            value = {key: scene_table(part) if is_dataclass(part) else part for key, part in value.items()}
        if value is None or value in ({}, []):
            continue
        table[item.name] = value
    return table


def _with_paths(scene: Scene, change: Callable[[str], str]) -> Scene:
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


@functools.cache
def _kinds(record: type) -> dict[str, Any]:
    """The types of a record's fields by name."""
    return get_type_hints(record)


def _checked(value: Any, kind: Any, key: str, faults: list[str]) -> Any:
    """A value from TOML or from Python, converted to the type of its field.

    Args:
        value: a table or a record, a list or a tuple, text or a number.
        kind: the type.
        key: position of the value in the scene.
        faults: receives a message for everything that does not fit.
    """
    origin, parts = get_origin(kind), get_args(kind)
    if type(None) in parts:
        return None if value is None else _checked(value, parts[0], key, faults)
    if isinstance(kind, type) and is_dataclass(kind):
        if isinstance(value, kind | Mapping):
            return _record(vars(value) if is_dataclass(value) else value, kind, f"{key}." if key else "", faults)
    elif origin is Mapping:
        if isinstance(value, Mapping):
            return {name: _checked(part, parts[1], f"{key}.{_toml_key(str(name))}", faults) for name, part in value.items()}
    elif parts[1:] == (...,):
        if isinstance(value, tuple | list):
            return tuple(_checked(part, parts[0], f"{key}[{k}]", faults) for k, part in enumerate(value))
    else:
        options = (kind,) if origin in (None, Literal, tuple) else parts
        found = next((leaf for option in options if (leaf := _leaf(value, option)) is not None), None)
        if found is not None:
            return found
    faults.append(f"{key} has to be {_wanted(kind)}, not {_shown(value)}")
    return value


def _record(table: Mapping[str, Any], kind: type, key: str, faults: list[str]) -> Any:
    """A record of the scene from its fields; None if something does not fit."""
    kinds, values = _kinds(kind), {}
    for item in fields(kind):
        if item.name in table:
            values[item.name] = _checked(table[item.name], kinds[item.name], f"{key}{item.name}", faults)
        elif item.default is item.default_factory is dataclasses.MISSING:
            faults.append(f"{key}{item.name} is missing; every {kind.__name__.lower()} needs it")
    for name in table:
        if name not in kinds:
            near = difflib.get_close_matches(name, kinds, n=1, cutoff=0.7)
            hint = f"nearest: {near[0]}" if near else f"valid here: {', '.join(kinds)}"
            faults.append(f"{key}{name}: no such key; {hint}")
    return None if faults else kind(**values)


def _leaf(value: Any, kind: Any) -> Any:
    """A text, a number, a word or a vector; None if it does not fit."""
    if kind is float:
        try:
            return float(value) if isinstance(value, Real) and not isinstance(value, bool) and math.isfinite(value) else None
        except OverflowError:
            return None
    if kind is str:
        return value if isinstance(value, str) else None
    if get_origin(kind) is Literal:
        return value if isinstance(value, str) and value in get_args(kind) else None
    if not isinstance(value, tuple | list | np.ndarray) or len(value) != len(get_args(kind)):
        return None
    vector = tuple(_leaf(part, float) for part in value)
    return None if None in vector else vector


def _wanted(kind: Any) -> str:
    """What a field accepts, in words."""
    origin, parts = get_origin(kind), get_args(kind)
    if origin is Literal:
        return " or ".join(filter(None, [", ".join(_inline(part) for part in parts[:-1]), _inline(parts[-1])]))
    if is_dataclass(kind):
        return "a table"
    if origin is Mapping:
        return f"a table, each of its values {_wanted(parts[1])}"
    if origin is tuple and parts[1:] == (...,):
        if isinstance(parts[0], type) and is_dataclass(parts[0]):
            return f"a list of tables, each begun with [[{parts[0].__name__.lower()}]]"
        return f"a list, each of its entries {_wanted(parts[0])}"
    if origin is tuple:
        return f"a list of {len(parts)} finite numbers"
    if parts:
        return " or ".join(_wanted(part) for part in parts)
    return "a finite number" if kind is float else "text in quotes"


def _shown(value: Any) -> str:
    """A value in a message, shortened."""
    try:
        text = _inline(value)
    except ValueError:
        return "an integer of thousands of digits"
    return text if len(text) <= 60 else text[:59] + "…"


def _numbers(value: Any, key: str) -> Iterator[tuple[str, float]]:
    """All numbers of a checked scene with their keys."""
    if isinstance(value, float):
        yield key, value
    elif isinstance(value, tuple):
        for k, part in enumerate(value):
            yield from _numbers(part, f"{key}[{k}]")
    elif isinstance(value, Mapping) or is_dataclass(value):
        for name, part in (value if isinstance(value, Mapping) else vars(value)).items():
            yield from _numbers(part, f"{key}.{name}" if key else name)


def _toml_lines(table: Mapping[str, Any], name: str = "") -> list[str]:
    """A table of a scene as TOML, with one line for each vector."""
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
    """A key, quoted where TOML requires it."""
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else _inline(key)


def _inline(value: Any) -> str:
    """A value on one line: JSON's strings, numbers and lists are valid TOML, except for one control character."""
    return json.dumps(value, ensure_ascii=False, default=str).replace("\x7f", "\\u007f")
