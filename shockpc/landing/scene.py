"""A scene: one landing of one robot. Read from and written to TOML files.

The scene holds everything that the result depends on: robot, posture, strike, contacts and plane. Scenes from files and scenes
built in Python are checked against the same field types. Only the JSON Schema is made by pydantic, whose import would lengthen the
start of every command by a third.
"""

import dataclasses
import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeVar

import numpy as np

from shockpc.core.spatial import Array, Plane, plane_from
from shockpc.landing.closure import Closure
from shockpc.landing.contact import Contact
from shockpc.landing.freedom import Base
from shockpc.landing.joint_model import Joints
from shockpc.landing.posture import Posture
from shockpc.landing.record import Record, documented, option
from shockpc.robot.load import shared_robot
from shockpc.robot.robot import Robot
from shockpc.text.errors import SceneError
from shockpc.text.paths import usable_path
from shockpc.text.printed import printable
from shockpc.text.toml import checked, inline, reading, toml_lines

GRAVITY = 9.80665
"""Standard acceleration of free fall [m/s²]: converts a drop height to a speed."""

PLANES = {"xz": (0.0, -1.0, 0.0), "yz": (1.0, 0.0, 0.0), "xy": (0.0, 0.0, 1.0)}
"""The named planes by their normals."""

SLOWEST, FASTEST = 1e-9, 1e9
"""Range of speeds [m/s]; outside it squares overflow or underflow."""


STRIKE, RESULTS, POSTURE = "Velocity before the impact", "What is computed", "Posture"
"""Headings of options."""


@documented
@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Strike(Record):
    """Velocity of the robot relative to the ground before the impact; 1 m/s straight down by default.

    The velocity of the base frame's origin is given as speed and angle, as a vector or by a drop height. The rotation of the base
    and the joint velocities are superposed.

    Attributes:
        joint_velocities: joint velocities by name or glob [rad/s; m/s for a prismatic joint].
    """

    speed: float | None = option(
        None, "Speed along the strike angle; 1 by default.", STRIKE, "V", unit="m/s", above=0.0, varies=True
    )
    strike_angle_deg: float | None = option(
        None,
        "Angle of the velocity from the vertical in the plane, positive moving forward.",
        STRIKE,
        "DEG",
        unit="deg",
        varies=True,
    )
    velocity: tuple[float, float, float] | None = option(None, "Velocity of the robot, world axes.", STRIKE, "VX,VY,VZ", unit="m/s")
    drop_height: float | None = option(
        None,
        "Height of a free fall that ends in the impact and gives the vertical velocity alone, with a --strike-angle or a "
        "--forward-speed while moving forward.",
        STRIKE,
        "H",
        unit="m",
        above=0.0,
    )
    forward_speed: float | None = option(
        None, "Horizontal speed in the plane after the fall from --drop-height.", STRIKE, "V", unit="m/s"
    )
    angular_velocity: tuple[float, float, float] | None = option(
        None, "Angular velocity of the base, world axes.", STRIKE, "WX,WY,WZ", unit="rad/s"
    )
    joint_velocities: Mapping[str, float] = field(default_factory=dict)

    def vector(self, plane: Plane) -> Array:
        """The velocity (3,) in world axes [m/s]: speed · (sin θ · forward − cos θ · z).

        Down is −z of the world for every plane. Forward is the horizontal direction in the plane with a positive x component, or a
        positive y component if the plane is perpendicular to x.

        Raises:
            SceneError: it is given in two ways at once, the speed is out of range, or an angle is given in a horizontal plane.
        """
        ways = [self.speed is not None, self.velocity is not None, self.drop_height is not None]
        angles = self.strike_angle_deg is not None, self.forward_speed is not None
        if sum(ways) > 1 or all(angles) or (self.velocity is not None and any(angles)):
            raise SceneError(
                "the strike is given in two ways; keep one of: speed with strike angle, velocity, drop height with strike angle or "
                "forward speed"
            )
        if self.forward_speed is not None and self.drop_height is None:
            raise SceneError("a forward speed is given without a drop height; give both, or the velocity")
        theta = math.radians(self.strike_angle_deg or 0.0)
        if self.velocity is not None:
            speed = max(map(abs, self.velocity))
        else:
            what, unit, size = "strike speed", "m/s", 1.0 if self.speed is None else self.speed
            if self.drop_height is not None:
                what, unit, size = "drop height", "m", self.drop_height
            if not size > 0.0:
                raise SceneError(f"a {what} of {size:g} {unit} gives no impact; it has to be above zero")
            speed = size if self.drop_height is None else math.sqrt(2.0 * GRAVITY * size)
            if not abs(theta) <= math.pi:
                raise SceneError(f"a strike angle of {self.strike_angle_deg:g} deg is no angle; it lies between -180 and 180 deg")
            if self.drop_height is not None:
                theta = math.atan2(self.forward_speed, speed) if self.forward_speed else theta
                if not abs(theta) < math.pi / 2.0 * (1.0 - 1e-9):
                    raise SceneError(
                        f"after a fall the strike angle has to lie between -90 and 90 deg, and it is {math.degrees(theta):g} deg"
                    )
                speed = speed / math.cos(theta)
            if theta and plane.level:
                raise SceneError(
                    "a plane seen from above holds no vertical to measure a strike angle from; give the strike's velocity"
                )
        if not (speed == 0.0 or SLOWEST <= speed <= FASTEST):
            raise SceneError(
                f"a strike at {speed:g} m/s cannot be computed; its speed has to lie between {SLOWEST:g} and {FASTEST:g} m/s"
            )
        if self.velocity is not None:
            return np.array(self.velocity, dtype=float)
        return np.asarray(speed * (math.sin(theta) * plane.forward - math.cos(theta) * np.array([0.0, 0.0, 1.0])))


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Point(Record):
    """A point at which the shock is computed.

    Attributes:
        frame: link, joint or site.
        offset: from the origin of the frame, in its axes [m].
    """

    frame: str
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)

    @property
    def label(self) -> str:
        """The point as it is typed, FRAME or FRAME:x,y,z."""
        return self.frame + (":" + ",".join(f"{x:g}" for x in self.offset) if any(self.offset) else "")


def points_at(robot: Robot, text: str) -> tuple[Point, ...]:
    """The points that FRAME or FRAME:x,y,z means. The frame's own name may hold a colon; a glob means a point on each frame.

    Raises:
        UnknownName: the robot has no such frame.
        SceneError: the offset is not three finite numbers.
    """
    frame, colon, offset = text.rpartition(":")
    if not colon or text in robot.frames:
        return tuple(Point(frame=name) for name in robot.match_frames(text))
    try:
        x, y, z = map(float, offset.split(","))
        valid = math.isfinite(x + y + z)
    except ValueError:
        valid = False
    if not valid:
        raise SceneError(f'"{text}" is not a point; give FRAME or FRAME:x,y,z, such as {frame}:0,0,0.1')
    return tuple(Point(frame=name, offset=(x, y, z)) for name in robot.match_frames(frame))


def point_at(robot: Robot, text: str) -> Point:
    """The one point that a text means, as in `points_at`.

    Raises:
        ShockError: as for `points_at`, or a glob means several points.
    """
    first, *others = points_at(robot, text)
    if others:
        raise robot.unknown("single point", text, (point.label for point in (first, *others)))
    return first


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Part(Record):
    """A part of the robot and what it withstands: a component at a point, or the gears of joints.

    Attributes:
        name: by which results refer to it.
        at: FRAME or FRAME:x,y,z, where it is mounted.
        rating: a pulse that it survives: shape, peak and length, such as "half-sine 1500 g 0.5 ms".
        critical_velocity_change: below which no short pulse damages it, whatever its acceleration [m/s].
        natural_frequency: of the part on its mounting [Hz].
        joint: name or glob of joints, in place of `at`.
        momentary_torque: that the gears of these joints withstand; by default the effort limit of the robot's file [N m, N].
        torque_duration: for which they do [s].
    """

    name: str
    at: str | None = None
    rating: str | None = None
    critical_velocity_change: float | None = None
    natural_frequency: float | None = None
    joint: str | None = None
    momentary_torque: float | None = None
    torque_duration: float | None = None


@documented
@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Scene(Record):
    """One landing of one robot.

    Attributes:
        robot: a name that `shockpc robots` lists, or the path of a URDF, xacro or MJCF file.
        packages: folders of packages, for `package://` and `$(find …)`.
        xacro: arguments of a xacro file.
        posture: posture of base and joints.
        strike: velocity relative to the ground.
        contact: the contacts that strike at the same time; from Python also one contact, or names of frames.
        stance: frames that are already on the ground and stay where they are.
        closure: loops, in addition to those of the robot's file.
        joints: joint model (free, geared or locked).
        point: points at which the shock is computed, in addition to the robot's sensors.
        part: parts and what they withstand.
        tangential_stiffness: of every contact along the ground; by default that along the normal [N/m].

    Raises:
        SceneError: a path holds a NUL character.
    """

    robot: str
    base: Base | None = option(
        None,
        "How the base may move: free, in the plane only (planar), or not (fixed). By default free, or fixed where the file fixes "
        "it or its root link is called world; free and planar give the base of such an MJCF file a free joint.",
        POSTURE,
    )
    plane: Literal["auto", "xz", "yz", "xy"] | tuple[float, float, float] = option(
        "auto",
        "Plane of CoPc, RoPc, figures and the strike angle: xz (sagittal), yz (frontal), xy, or a normal NX,NY,NZ; by default "
        "auto: xz, or yz where more than half of the motion before the impact is sideways (velocity along y, rotation about x).",
        RESULTS,
        "PLANE",
    )
    srdf: str | None = option(None, "File of reference postures; by default the one beside the robot.", POSTURE, "FILE")
    packages: Mapping[str, str] = field(default_factory=dict)
    xacro: Mapping[str, str] = field(default_factory=dict)
    posture: Posture = field(default_factory=Posture)
    strike: Strike = field(default_factory=Strike)
    contact: tuple[Contact, ...] = ()
    stance: tuple[str, ...] = ()
    closure: tuple[Closure, ...] = ()
    assemble: tuple[str, ...] = option(
        (), "The only joints that may move to close loops; by default all that the posture does not set.", POSTURE, "JOINT"
    )
    joints: Joints = field(default_factory=Joints)
    point: tuple[Point, ...] = ()
    part: tuple[Part, ...] = ()
    v_in: Literal["contact", "com"] = option(
        "contact", "The speed that shock is relative to: of the contact (default) or of the centre of mass.", RESULTS
    )
    pulse: str | None = option(
        None,
        "Also give peak accelerations, for example half-sine:5ms; shapes are half-sine, saw-tooth, haversine and rectangle.",
        RESULTS,
        "SHAPE:LENGTH",
    )
    range_g: float | None = option(
        None, "Measuring range of the sensors, compared with the peaks.", RESULTS, "G", unit="g", above=0.0
    )
    friction: float | None = option(
        None,
        "Also solve with this coefficient of friction, and restitution along the normal alone (quantities *_friction); all others "
        "are those of contacts that stick.",
        RESULTS,
        "MU",
        unit="1",
        least=0.0,
        varies=True,
    )
    contact_stiffness: float | None = option(
        None,
        "Also give forces, accelerations and their times on contacts of this stiffness, in every direction or along the normal and "
        "along the ground.",
        RESULTS,
        "K or KN:KT",
        unit="N/m",
        above=0.0,
        varies=True,
    )
    tangential_stiffness: float | None = None
    contact_damping: float | None = option(
        None,
        "Damping of these contacts along the normal, in place of --restitution: taken as the restitution of the mode that carries "
        "the contact's force.",
        RESULTS,
        "C",
        unit="N s/m",
        above=0.0,
    )
    ground_tolerance: float = option(
        0.005,
        "By how much the lowest points of contacts and other links may differ in height that flat ground is taken to touch "
        "together, in warnings and in what is feasible; 0.005 by default.",
        RESULTS,
        "H",
        unit="m",
        least=0.0,
    )

    if TYPE_CHECKING:  # what is accepted; the fields above are what is held

        def __init__(
            self,
            *,
            robot: str | os.PathLike[str],
            base: Base | None = None,
            plane: Literal["auto", "xz", "yz", "xy"] | Sequence[float] = "auto",
            srdf: str | os.PathLike[str] | None = None,
            packages: Mapping[str, str] = ...,
            xacro: Mapping[str, str] = ...,
            posture: Posture = ...,
            strike: Strike = ...,
            contact: Contact | str | Sequence[Contact | str] = (),
            stance: Sequence[str] = (),
            closure: Sequence[Closure] = (),
            assemble: Sequence[str] = (),
            joints: Joints = ...,
            point: Sequence[Point] = (),
            part: Sequence[Part] = (),
            v_in: Literal["contact", "com"] = "contact",
            pulse: str | None = None,
            range_g: float | None = None,
            friction: float | None = None,
            contact_stiffness: float | None = None,
            tangential_stiffness: float | None = None,
            contact_damping: float | None = None,
            ground_tolerance: float = 0.005,
        ) -> None: ...

    def __post_init__(self) -> None:
        """Make the contacts a tuple of `Contact` and paths text, and refuse paths that no file can have."""
        contact: Any = self.contact
        contacts = contact if isinstance(contact, tuple | list) else (contact,)
        contacts = tuple(Contact(frame=given) if isinstance(given, str) else given for given in contacts)
        object.__setattr__(self, "contact", contacts)
        for name in ("robot", "srdf"):
            if isinstance(path := getattr(self, name), os.PathLike):
                object.__setattr__(self, name, os.fspath(path))
        for path in (
            self.robot,
            self.srdf,
            getattr(self.joints, "drives", None),
            *(self.packages.values() if isinstance(self.packages, Mapping) else ()),
        ):
            if isinstance(path, str) and "\0" in path:
                raise SceneError(f"{inline(path)} cannot be the path of a file: it holds a NUL character")


ARM = 0.5
"""Distance from the base at which a rotation counts as a velocity where the plane is chosen [m]."""

S = TypeVar("S", bound=Scene)


def with_plane(scene: Scene) -> Scene:
    """The scene with its own plane, or that in which its motion before the impact happens.

    That is the frontal plane where more than half of the motion is sideways. The jumps do not decide: they turn with the foot that
    is struck, the posture and the masses, so that two designs would be compared in different planes.

    Raises:
        SceneError: as for `Strike.vector`.
    """
    return scene if scene.plane != "auto" else replace(scene, plane="yz" if sideways(scene.strike) > 0.5 else "xz")


def sideways(strike: Strike) -> float:
    """Share of a motion before the impact that is in the frontal plane alone: along y, and about x as in a fall to the side [1].

    A rotation counts as the velocity at `ARM` from the base; a strike angle is in the sagittal plane.

    Raises:
        SceneError: as for `Strike.vector`.
    """
    turning = ARM * np.array(strike.angular_velocity or (0.0, 0.0, 0.0))
    motion = np.concatenate([strike.vector(plane_from(PLANES["xz"])), turning])
    return float(np.hypot(motion[1], motion[3]) / (np.linalg.norm(motion) or 1.0))


def plane_of(scene: Scene) -> Plane:
    """The plane of a scene as unit vectors.

    Raises:
        SceneError: the normal has length zero.
    """
    plane = with_plane(scene).plane
    try:
        return plane_from(PLANES[plane] if isinstance(plane, str) else plane)
    except ValueError as refusal:
        raise SceneError(f"plane: {refusal}; valid are auto, xz, yz, xy or a normal such as 0,-1,0") from None


def check_scene(scene: Scene) -> Scene:
    """Check a scene built in Python as a file is checked.

    Returns: the scene with every list and array as a tuple of floats.

    Raises:
        SceneError: a field has a wrong type, length or word, or a number is not finite or out of range.
    """
    if not isinstance(scene, Scene):
        raise SceneError(
            f"{printable(repr(scene), 60)} is not a Scene; make one with Scene(robot=..., contact=...), or by read_scene"
        )
    faults: list[str] = []
    found: Scene | None = checked(scene, Scene, "", faults)
    if found is None:
        raise SceneError("; ".join(faults))
    return found


def robot_of(scene: Scene, frames: Sequence[str] = ()) -> Robot:
    """The robot of a scene, with its xacro arguments, packages and postures: one object for all scenes of the same robot.

    It is loaded again when one of its files has changed.

    Args:
        scene: the scene.
        frames: names or globs of the contacts, where they are not in the scene yet.

    Raises:
        ShockError: a field of the scene is not valid, or the robot cannot be read.
    """
    scene = check_scene(scene)
    frames = frames or [contact.frame for contact in scene.contact]
    return shared_robot(scene.robot, scene.xacro, scene.packages, scene.srdf, frames, scene.base in ("free", "planar"))


def read_scene(path: Path | str) -> Scene:
    """Read a scene file. Paths in it are relative to the file's folder and are returned as absolute paths.

    Raises:
        SceneError: the file cannot be read or is not a scene; the text names the file, the key and what would be valid.
    """
    path = Path(path)
    with reading(path, "scene", SceneError) as table:
        return scene_from(Scene, table, path.resolve().parent)


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
    scene: S | None = checked(table, kind, key, faults)
    if scene is None or faults:
        raise SceneError("; ".join(faults))
    try:
        return with_paths(scene, lambda found: os.path.normpath(folder / usable_path(found)))
    except ValueError as refusal:
        raise SceneError(str(refusal)) from None


def scene_text(scene: Scene, folder: Path) -> str:
    """The TOML text of a scene for a file in `folder`, with paths relative to the folder."""
    here = folder.resolve()

    def relative(found: str) -> str:
        path = os.path.relpath(found, here)
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

    return TypeAdapter(record).json_schema()


def scene_table(record: Any) -> dict[str, Any]:
    """A scene, or a part of one, as nested tables for TOML and JSON; fields that are not set are left out."""

    def plain(value: Any) -> Any:
        if isinstance(value, Mapping):
            parts = {key: plain(part) for key, part in value.items()}
            return {key: part for key, part in parts.items() if part is not None and part not in ({}, [])}
        return [plain(part) for part in value] if isinstance(value, tuple) else value

    table: dict[str, Any] = plain(dataclasses.asdict(record))
    return table


def with_paths(scene: S, change: Callable[[str], str]) -> S:
    """The scene with every path in it changed; a robot's name is not a path."""
    robot, joints = scene.robot, scene.joints
    if os.sep in robot or Path(robot).suffix:
        robot = change(robot)
    return dataclasses.replace(
        scene,
        robot=robot,
        srdf=None if scene.srdf is None else change(scene.srdf),
        packages={name: change(folder) for name, folder in scene.packages.items()},
        joints=dataclasses.replace(joints, drives=change(joints.drives)) if joints.drives not in (None, "none") else joints,
    )
