"""A scene: one landing of one robot, as it is asked for.

The scene holds everything that the result depends on: robot, posture, strike, contacts and plane. A field that is an option is
declared here once; the option of commands, the key of files, their schema and checks, and what a sweep varies follow. Importing
this module loads no library, so that commands print their help at once.
"""

import json
import math
import os
from collections.abc import Collection, Mapping, Sequence
from dataclasses import field, replace
from typing import TYPE_CHECKING, Any, Literal

from shockpc.core.frozen import frozen
from shockpc.landing.record import Record, documented, option
from shockpc.text.errors import SceneError

if TYPE_CHECKING:
    from shockpc.core.spatial import Array, Plane

GRAVITY = 9.80665
"""Standard acceleration of free fall [m/s²]: converts a drop height to a speed."""

SLOWEST, FASTEST = 1e-9, 1e9
"""Range of speeds [m/s]; outside it squares overflow or underflow."""

CONTACT, STRIKE, RESULTS, POSTURE = "Contact", "Velocity before the impact", "What is computed", "Posture"
JOINT_MODEL = "Joint model"
"""Headings of options."""

CONTACTS = "foam 1e4, a rubber foot 1e5, running surfaces 7.5e4 to 9.5e5 (Kerdok et al. 2002), hard ground 1e6 N/m or more"
"""What stiffness contacts have; the guide for designers gives all sources."""

Base = Literal["free", "planar", "fixed"]
JointModelName = Literal["free", "geared", "rigid", "locked"]
"""How the base may move."""


@documented
@frozen(kw_only=True)
class Contact(Record):
    """A contact as a scene states it.

    Attributes:
        frame: link or frame that strikes; "stop:JOINT" for a joint that runs into its end stop, whose rate the strike gives.
        directions: world axes or vectors along which the contact stops the point; the others slide.
        velocity: of the contact point before the impact, world axes, where it is not that of the robot's motion [m/s].
    """

    frame: str
    offset: tuple[float, float, float] = option(
        (0.0, 0.0, 0.0), "Contact point from the frame's origin, in its axes.", CONTACT, "X,Y,Z", unit="m"
    )
    at: Literal["auto", "frame", "lowest"] = option(
        "auto",
        "Contact point at the frame's origin, or at the lowest point of the link's collision geometry (visual, if the file has "
        "no other), or of the geom, in this posture (the middle of all that are equally low); the offset is added. By default the "
        "origin if an offset is given, the link has no geometry, or the origin is at most 2 cm and 1 % of the robot's size above "
        "that point; else the lowest point.",
        CONTACT,
        name="contact-point",
    )
    directions: tuple[Literal["x", "y", "z"] | tuple[float, float, float], ...] = ("x", "y", "z")
    kind: Literal["auto", "point", "flat"] = option(
        "auto",
        "A point leaves the link free to turn about the contact; a flat contact, a sole, also stops it from tilting, and from "
        "twisting if it sticks. By default flat where the link's geometry within the ground's tolerance of its lowest point has an "
        "area in which the centre of pressure of the flat landing lies, and no offset is given; else a point.",
        CONTACT,
        name="contact-kind",
    )
    restitution: float = option(
        0.0, "Coefficient of restitution, 0 (default) to 1.", CONTACT, "E", unit="1", least=0.0, greatest=1.0, varies=True
    )
    restitution_along: Literal["normal", "directions"] = option(
        "normal",
        "What restitution reverses: the velocity along the normal alone (default; Newton's law), or along every direction in which "
        "the contact stops (Eq. 4 of the paper), so that a sticking contact rebounds along the ground too.",
        CONTACT,
    )
    normal: tuple[float, float, float] | None = option(
        None, "Normal of the ground at the contact: a slope, or a wall; vertical by default.", CONTACT, "X,Y,Z"
    )
    velocity: tuple[float, float, float] | None = None

    @property
    def sticks(self) -> bool:
        """Whether its directions span space, so that nothing slides."""
        from shockpc.landing.contact import sticks

        return sticks(self)


@frozen(kw_only=True)
class LoopEnd(Record):
    """One end of a closure.

    Attributes:
        frame: link, joint or site; it may be fixed to the world.
        offset: from that frame's origin, in its axes [m].
    """

    frame: str
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)


@frozen(kw_only=True)
class Closure(Record):
    """A closed loop as a scene states it.

    Attributes:
        a: one end.
        b: the other end.
        kind: "point" holds two points together, "frame" holds their orientations too.
        directions: axes of frame a, or vectors in them, along which the points are held.
    """

    a: LoopEnd
    b: LoopEnd
    kind: Literal["point", "frame"] = "point"
    directions: tuple[Literal["x", "y", "z"] | tuple[float, float, float], ...] = ("x", "y", "z")


@documented
@frozen(kw_only=True)
class Posture(Record):
    """A posture as a scene states it; each part overrides the one before.

    Attributes:
        base_position: position of the base frame in the world [m]. The shock does not depend on it.
        base_quaternion: attitude of the base as a quaternion x, y, z, w.
        joints: joint values by name or glob [rad; m for a prismatic joint].
        joints_deg: joint values by name or glob [deg; m for a prismatic joint].
        joint_quaternions: coordinates of joints of several degrees of freedom by name: of a ball joint its rotation as a quaternion
            x, y, z, w, of a planar one x, y [m] and angle [rad], of a floating one its position [m] and quaternion.
    """

    reference: str | None = option(
        None, "A reference posture of the robot, or neutral; by default the standing one.", "Posture", "NAME", name="posture"
    )
    base_position: tuple[float, float, float] | None = None
    base_rpy_deg: tuple[float, float, float] | None = option(
        None,
        "Roll, pitch and yaw of the base about the world's fixed x, y and z; a positive pitch is nose down.",
        "Posture",
        "R,P,Y",
        unit="deg",
    )
    base_quaternion: tuple[float, float, float, float] | None = None
    joints: Mapping[str, float] = field(default_factory=dict)
    joints_deg: Mapping[str, float] = field(default_factory=dict)
    joint_quaternions: Mapping[str, tuple[float, ...]] = field(default_factory=dict)


@frozen(kw_only=True)
class Rotor(Record):
    """A motor behind a gearbox.

    Attributes:
        inertia: of the rotor about its axis [kg m²].
        gear_ratio: turns of the rotor for one of the joint [1]; by default that of the robot's file.
        stiffness: of a spring between gearbox and joint (series elastic) [N m/rad, N/m]; rigid by default.
    """

    inertia: float
    gear_ratio: float | None = None
    stiffness: float | None = None


@documented
@frozen(kw_only=True)
class Joints(Record):
    """The drives as a scene states them; patterns are joint names or globs, of which later ones go over earlier ones.

    Attributes:
        armature: reflected inertia by pattern [kg m²; kg for a prismatic joint].
        rotor: rotor and gearbox by pattern; their reflected inertia is gear_ratio² · inertia.
        stiffness: of springs of the joints themselves, such as in a compliant leg, by pattern [N m/rad, N/m].
        torque: constant torque of motors on contacts of finite stiffness, by pattern; it goes over `motors` [N m, N].
        locked: patterns of joints that hold the rate that they have before the impact: none, or that of the strike's joint
            velocities.
    """

    model: JointModelName | None = option(
        None,
        "All joints turn freely, resist by the reflected inertia of their drives, are as modelled with springs that do not yield, "
        "or are locked; by default each is as its drive makes it. Free joints have no reflected inertia, whatever the robot's "
        "file, --drives or the catalogue give; of rigid ones a joint with a spring is locked, and a rotor behind one is joined "
        "to its joint.",
        JOINT_MODEL,
        name="joints",
    )
    drives: str | None = option(
        None,
        "A file of drives, a robot of the catalogue that has such drives (go2), or none. Joints of the same names have the drives "
        "of that robot. By default a robot of the catalogue has those known of it; none leaves what the robot's file gives. "
        "The form of a file is that of robots/drives.toml.",
        JOINT_MODEL,
        "FILE|NAME|none",
    )
    motors: Literal["none", "flight", "standing"] | None = option(
        None,
        "Constant torques of the motors on contacts of finite stiffness: those that hold the load of springs before touchdown "
        "(flight, the default), those that also hold the robot's weight on its contacts (standing), or none.",
        JOINT_MODEL,
    )
    armature: Mapping[str, float] = field(default_factory=dict)
    rotor: Mapping[str, Rotor] = field(default_factory=dict)
    stiffness: Mapping[str, float] = field(default_factory=dict)
    torque: Mapping[str, float] = field(default_factory=dict)
    locked: tuple[str, ...] = ()


@documented
@frozen(kw_only=True)
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
        "Angle of the velocity from the vertical, positive moving forward; in the plane.",
        STRIKE,
        "DEG",
        unit="deg",
        varies=True,
    )
    velocity: tuple[float, float, float] | None = option(None, "Velocity of the robot, world axes.", STRIKE, "VX,VY,VZ", unit="m/s")
    drop_height: float | None = option(
        None,
        "Height of a free fall that ends in the impact. It gives the vertical velocity alone; with a --strike-angle or a "
        "--forward-speed the robot also moves forward.",
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

    def turned(self, angle: float, plane: "Plane") -> "Strike":
        """The same at another strike angle [deg].

        The part of the velocity that is in the plane turns, and the part out of the plane stays; after a fall from a drop height
        the vertical component stays, and the forward one changes.

        Raises:
            SceneError: as for `vector`.
        """
        if self.velocity is None:
            return replace(self, strike_angle_deg=angle, forward_speed=None)
        velocity, theta = self.vector(plane), math.radians(angle)
        within = velocity - (velocity @ plane.normal) * plane.normal
        turned = velocity - within + math.hypot(*within) * (math.sin(theta) * plane.forward - [0.0, 0.0, math.cos(theta)])
        return replace(self, velocity=tuple(turned.tolist()))

    def vector(self, plane: "Plane") -> "Array":
        """The velocity (3,) in world axes [m/s]: speed · (sin θ · forward − cos θ · z).

        Down is −z of the world for every plane. Forward is the horizontal direction in the plane with a positive x component, or a
        positive y component if the plane is perpendicular to x.

        Raises:
            SceneError: it is given in two ways at once, the speed is out of range, or an angle is given in a horizontal plane.
        """
        import numpy as np

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
                raise SceneError(f"a strike angle of {self.strike_angle_deg:g} deg is not valid; it must lie in [-180, 180] deg")
            if self.drop_height is not None:
                theta = math.atan2(self.forward_speed, speed) if self.forward_speed else theta
                if not abs(theta) < math.pi / 2.0 * (1.0 - 1e-9):
                    raise SceneError(
                        f"after a fall the strike angle has to lie between -90 and 90 deg, and it is {math.degrees(theta):g} deg"
                    )
                speed = speed / math.cos(theta)
            if theta and plane.level:
                raise SceneError("no strike angle is defined in a horizontal plane; give the strike's velocity")
        if not (speed == 0.0 or SLOWEST <= speed <= FASTEST):
            raise SceneError(
                f"a strike at {speed:g} m/s cannot be computed; its speed has to lie between {SLOWEST:g} and {FASTEST:g} m/s"
            )
        if self.velocity is not None:
            return np.array(self.velocity, dtype=float)
        return np.asarray(speed * (math.sin(theta) * plane.forward - math.cos(theta) * np.array([0.0, 0.0, 1.0])))


def replaced_ways(given: Collection[str]) -> tuple[str, ...]:
    """The fields of a strike that others replace: one way of giving the velocity takes the place of another.

    A vector or a drop height says all of it, a speed keeps the angle, and an angle keeps the speed or the drop height.

    Args:
        given: names of the fields that replace others.
    """
    if "velocity" in given or "drop_height" in given:
        return "speed", "strike_angle_deg", "velocity", "drop_height", "forward_speed"
    if "speed" in given:
        return "velocity", "drop_height", "forward_speed"
    if "strike_angle_deg" in given or "forward_speed" in given:
        return "velocity", "strike_angle_deg", "forward_speed"
    return ()


@frozen(kw_only=True)
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


@frozen(kw_only=True)
class Part(Record):
    """A part of the robot and what it withstands: a component at a point, or the gears of joints.

    Attributes:
        name: by which results refer to it.
        at: FRAME or FRAME:x,y,z, where it is mounted.
        rating: a pulse that it survives: shape, peak and length, such as "half-sine 1500 g 0.5 ms".
        critical_velocity_change: the boundary of damage: below it no short pulse damages it, whatever its acceleration, and above
            it one does [m/s].
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
@frozen(kw_only=True)
class Scene(Record):
    """One landing of one robot.

    Attributes:
        robot: a name that `shockpc robots` lists, or the path of a URDF, xacro, MJCF or SDFormat file.
        packages: folders of packages, for `package://` and `$(find …)`; in that of "*" files are found by their names alone.
        xacro: arguments of a xacro file.
        posture: posture of base and joints.
        strike: velocity relative to the ground.
        contact: the contacts that strike at the same time; from Python also one contact, or names of frames.
        stance: frames, or points FRAME:x,y,z, that are already on the ground and stay where they are.
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
        None,
        "Measuring range of the sensors, with which all peaks are compared: along each axis of a frame, and for a point with an "
        "offset that of the whole acceleration.",
        RESULTS,
        "G",
        unit="g",
        above=0.0,
    )
    friction: float | None = option(
        None,
        "Also solve with this coefficient of friction (quantities *_friction). Restitution is along the normal alone there; all "
        "other quantities are those of contacts that stick.",
        RESULTS,
        "MU",
        unit="1",
        least=0.0,
        varies=True,
    )
    stops: bool | None = option(
        None,
        "Joints at a limit that the impact would drive beyond it are held by end stops, which can only push; by default they move "
        "on, with a warning.",
        RESULTS,
    )
    stop_restitution: float | None = option(
        None,
        "Coefficient of restitution of end stops, 0 (default) to 1.",
        RESULTS,
        "E",
        least=0.0,
        greatest=1.0,
        unit="1",
        varies=True,
    )
    stop_stiffness: float | None = option(
        None,
        "Stiffness of end stops, of hinges and of slides, beside a --contact-stiffness.",
        RESULTS,
        "K",
        unit="N m/rad, N/m",
        above=0.0,
        varies=True,
    )
    contact_stiffness: float | None = option(
        None,
        "Also give forces, accelerations and their times on contacts of this stiffness; in every direction, or along the normal "
        f"and along the ground: {CONTACTS.removesuffix(' N/m or more')} or more (sources: shockpc guide designer).",
        RESULTS,
        "K or KN:KT",
        unit="N/m",
        above=0.0,
        varies=True,
    )
    tangential_stiffness: float | None = None
    contact_damping: float | None = option(
        None,
        "Damping of these contacts, in place of --restitution: a damper beside each of their springs, along the normal and the "
        "ground. The force starts at C times the speed of approach, and the contact separates where it would pull.",
        RESULTS,
        "C",
        unit="N s/m",
        above=0.0,
        varies=True,
    )
    gravity: bool = option(
        True,
        "Whether gravity acts while the robot is on contacts of finite stiffness: by default it does, and with --no-gravity, or "
        "gravity = false, it does not.",
        RESULTS,
        name="no-gravity",
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
            stops: bool | None = None,
            stop_restitution: float | None = None,
            stop_stiffness: float | None = None,
            contact_stiffness: float | None = None,
            tangential_stiffness: float | None = None,
            contact_damping: float | None = None,
            gravity: bool = True,
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
                raise SceneError(f"{json.dumps(path)} cannot be the path of a file: it holds a NUL character")
