"""A scene: which robot stands how, what strikes where and how fast, and in which plane the answer is read.

Everything that the numbers depend on is in here, so a scene can be written down, compared and computed again.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields, is_dataclass
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

__all__ = ["GRAVITY", "PLANES", "Point", "Scene", "Strike", "plane_of", "refuse_nonsense", "scene_table"]

GRAVITY = 9.80665
"""Standard acceleration of free fall [m/s²]: turns a drop height into a speed."""

PLANES = {"xz": (0.0, -1.0, 0.0), "yz": (1.0, 0.0, 0.0), "xy": (0.0, 0.0, 1.0)}
"""The planes that have a name, by their normals."""

SLOWEST, FASTEST = 1e-9, 1e9
"""Speeds of a strike that can be computed with [m/s]: beyond them squares run out of range."""


@dataclass(frozen=True, kw_only=True)
class Strike:
    """How the robot moves against the ground when it strikes; 1 m/s straight down by default.

    The velocity is given in one of three ways. Rotation and joint rates come on top, and each contact approaches as they make it.

    Attributes:
        speed: along the strike angle [m/s].
        strike_angle_deg: angle of the velocity from the vertical in the plane, positive moving forward [deg].
        velocity: of the base frame's origin, and of every point if nothing turns, world axes [m/s].
        drop_height: height of a free fall that ends in the strike [m].
        angular_velocity: of the base, world axes [rad/s].
        joint_velocities: rates of the joints by name or glob [rad/s; m/s for a prismatic joint].
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

        Down is against world z, and a fall goes there, whatever the plane. Forward is the level direction in the plane that points
        to world x, or to world y in a plane across x.

        Raises:
            SceneError: it is given in two ways at once, its speed is beyond bounds, or an angle is given in a level plane.
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
    """Refuse a speed that cannot be computed with."""
    if not SLOWEST <= speed <= FASTEST:
        raise SceneError(
            f"a strike at {speed:g} m/s cannot be computed; its speed has to lie between {SLOWEST:g} and {FASTEST:g} m/s"
        )


@dataclass(frozen=True, kw_only=True)
class Point:
    """A point at which shock is asked for.

    Attributes:
        frame: link, joint or site.
        offset: from that frame's origin, in its axes [m].
    """

    __pydantic_config__ = CHECKED

    frame: str
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True, kw_only=True)
class Scene:
    """One landing of one robot.

    Attributes:
        robot: a name that `shockpc robots` lists, or the path of a URDF, xacro or MJCF file.
        base: free; planar (moves and turns in the plane only); fixed. By default free, or fixed where an MJCF fixes it
            or the root link is called world.
        plane: xz (sagittal), yz (frontal), xy (from above), or the normal of another one.
        srdf: file of reference postures; by default the one beside the robot.
        packages: folders of packages, for `package://` and `$(find …)`.
        xacro: arguments of a xacro file.
        posture: of base and joints.
        strike: velocity against the ground.
        contact: what strikes, all at once.
        stance: frames that are down already and stay where they are.
        closure: loops, besides those in the robot's file.
        assemble: patterns of the joints that may move to close the loops; by default all that the posture does not set.
        joints: what the drives do.
        point: where shock is asked for, besides the robot's own sensors.
        v_in: the speed by which shock is normalised: of the contact, or of the robot's centre of mass.
        pulse: shape and length of the pulse for peak accelerations, such as "half-sine:5ms".
        range_g: range of the sensors, which peak accelerations are held against [g].
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


def plane_of(scene: Scene) -> Plane:
    """The plane of a scene as unit vectors.

    Raises:
        SceneError: its normal has no length.
    """
    try:
        return plane_from(PLANES[scene.plane] if isinstance(scene.plane, str) else scene.plane)
    except ValueError as refusal:
        raise SceneError(f"plane: {refusal}; valid are xz, yz, xy or a normal such as 0,-1,0") from None


def refuse_nonsense(scene: Scene) -> None:
    """See that a scene built in Python holds what a scene file could: finite numbers, and words that are known.

    Raises:
        SceneError: it does not; the text names the key and what would be valid.
    """
    _check(scene, "")


def _check(record: Any, where: str) -> None:
    """Check one record of a scene; `where` is its key."""
    hints = get_type_hints(type(record))
    for item in fields(record):
        key, value = f"{where}{item.name}", getattr(record, item.name)
        words = dict.fromkeys(word for option in (hints[item.name], *get_args(hints[item.name])) for word in _words(option))
        for name, part in _parts(key, value):
            if is_dataclass(part):
                _check(part, f"{name}.")
            elif isinstance(part, float | int) and not math.isfinite(part):
                raise SceneError(f"{name} is {part}, which is not finite; give a finite number")
            elif isinstance(part, float | int) and abs(part) > FASTEST and item.name in ("angular_velocity", "joint_velocities"):
                raise SceneError(f"{name} is {part:g}, a rate that cannot be computed with; give one up to {FASTEST:g}")
            elif isinstance(part, float | int) and abs(part) > LARGEST and not isinstance(record, Strike):
                raise SceneError(f"{name} is {part:g}, which cannot be computed with; give a number up to {LARGEST:g}")
            elif isinstance(part, str) and words and part not in words and str not in get_args(hints[item.name]):
                raise SceneError(f'{name} is "{part}"; valid are {", ".join(words)}')


def _words(option: Any) -> tuple[str, ...]:
    """The words of a Literal, also inside a tuple."""
    if get_origin(option) is Literal:
        return get_args(option)
    return tuple(word for part in get_args(option) if get_origin(part) is Literal for word in get_args(part))


def _parts(key: str, value: Any) -> Iterator[tuple[str, Any]]:
    """A value, or what it holds, each with its key."""
    if isinstance(value, Mapping):
        for name, part in value.items():
            yield f"{key}.{name}", part
    elif isinstance(value, tuple):
        for k, part in enumerate(value):
            yield from _parts(f"{key}[{k}]", part)
    else:
        yield key, value


def scene_table(record: Any) -> dict[str, Any]:
    """A scene, or a part of one, as plain tables, the way TOML and JSON hold it: what is not set is left out."""
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
