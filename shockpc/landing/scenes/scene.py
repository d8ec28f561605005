"""A scene: one landing of one robot, as it is asked for.

The scene holds everything that the result depends on: robot, posture, strike, contacts and plane. A
field that is an option is declared here once; the option of commands, the key of files, their
schema and checks, and what a sweep varies follow. Importing this module loads no library, so that
commands print their help at once.
"""

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import field, replace
from typing import TYPE_CHECKING, Any, Literal

from shockpc.core.frozen import frozen
from shockpc.landing.scenes.joint_options import Joints
from shockpc.landing.scenes.scene_fields import (
    CONTACT,
    POSTURE,
    RESULTS,
    SOFT,
    Record,
    documented,
    of_the_core,
    option,
    with_wing_options,
)
from shockpc.landing.scenes.strike import Strike
from shockpc.method.base import Base
from shockpc.text.errors import SceneError

CONTACTS = (
    "foam 1e4, a rubber foot 1e5, running surfaces 7.5e4 to 9.5e5 (Kerdok et al. 2002), hard "
    "ground 1e6 N/m or more"
)
"""The stiffness of usual contacts; the guide's page on stiffness gives all sources."""

ORIGIN = (0.0, 0.0, 0.0)
"""The value of an offset that is not given."""


@documented
@frozen(kw_only=True)
class Contact(Record):
    """A contact as a scene states it.

    Attributes:
        frame: link or frame that strikes; "stop:JOINT" for a joint that runs into its end stop,
            whose rate the strike gives.
        directions: world axes or vectors along which the contact stops the point; the others slide.
        edge: direction of the edge of a sole that carries, where the contact is one, world axes.
        velocity: of the contact point before the impact, world axes, where it is not that of the
            robot's motion [m/s].
    """

    frame: str
    offset: tuple[float, float, float] | None = option(
        None,
        "Contact point from the frame's origin, in its axes; zeros are an offset too.",
        CONTACT,
        "X,Y,Z",
        unit="m",
    )
    at: Literal["auto", "frame", "lowest"] = option(
        "auto",
        "Contact point at the frame's origin, or at the lowest point of the link's collision "
        "geometry (visual, if the file has "
        "no other), or of the geom, in this posture (the middle of all that are equally low); the "
        "offset is added. By default the "
        "origin if an offset is given, the link has no geometry, or the origin is at most 2 cm and "
        "1 % of the robot's size above "
        "that point; else the lowest point.",
        CONTACT,
        name="contact-point",
    )
    directions: tuple[Literal["x", "y", "z"] | tuple[float, float, float], ...] = ("x", "y", "z")
    kind: Literal["auto", "point", "corner", "edge", "flat"] = option(
        "auto",
        "A point leaves the link free to turn about the contact; a flat contact, a sole, also "
        "stops it from tilting, and from "
        "twisting if it sticks. An edge of a sole leaves it free to turn about that edge, whose "
        "direction a file gives (edge); a "
        "corner is a point that does not twist. By default the part of the link's sole that "
        "carries the load (the whole sole, "
        "an edge or a corner); a point if there is no sole or an offset is given.",
        CONTACT,
        name="contact-kind",
    )
    restitution: float = option(
        0.0,
        "Coefficient of restitution, 0 to 1.",
        CONTACT,
        "E",
        unit="1",
        least=0.0,
        greatest=1.0,
        varies=True,
    )
    restitution_along: Literal["normal", "directions"] = option(
        "normal",
        "Velocity that restitution reverses: only along the normal (Newton's law), or along every "
        "direction in which the contact stops the point (a sticking contact then rebounds along "
        "the ground too).",
        CONTACT,
    )
    normal: tuple[float, float, float] | None = option(
        None,
        "Normal of the ground at the contact: a slope, or a wall.",
        CONTACT,
        "X,Y,Z",
        default="vertical",
    )
    edge: tuple[float, float, float] | None = None
    velocity: tuple[float, float, float] | None = None

    def __post_init__(self) -> None:
        """Write out the offset where nothing is left that depends on whether it is given."""
        if self.offset is None and "auto" not in (self.at, self.kind):
            object.__setattr__(self, "offset", ORIGIN)

    @property
    def sticks(self) -> bool:
        """True if its directions span space, so that nothing slides."""
        from shockpc.landing.scenes.directions import span_space

        return span_space(self.frame, self.directions)


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
        joint_quaternions: coordinates of joints of several degrees of freedom by name: of a ball
            joint its rotation as a quaternion x, y, z, w, of a planar one x, y [m] and angle [rad],
            of a floating one its position [m] and quaternion.
    """

    reference: str | None = option(
        None,
        "A reference posture of the robot, or neutral.",
        POSTURE,
        "NAME",
        name="posture",
        default="the standing one",
    )
    base_position: tuple[float, float, float] | None = None
    base_rpy_deg: tuple[float, float, float] | None = option(
        None,
        "Roll, pitch and yaw of the base about the world's fixed x, y and z; a positive pitch is "
        "nose down.",
        POSTURE,
        "R,P,Y",
        unit="deg",
    )
    base_quaternion: tuple[float, float, float, float] | None = None
    joints: Mapping[str, float] = field(default_factory=dict)
    joints_deg: Mapping[str, float] = field(default_factory=dict)
    joint_quaternions: Mapping[str, tuple[float, ...]] = field(default_factory=dict)


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
        if not any(self.offset):
            return self.frame
        return f"{self.frame}:{','.join(f'{x:g}' for x in self.offset)}"


@frozen(kw_only=True)
class Part(Record):
    """A part of the robot and what it withstands: a component at a point, or the gears of joints.

    Attributes:
        name: by which results refer to it.
        at: FRAME or FRAME:x,y,z, where it is mounted.
        rating: a pulse that it survives: shape, peak and length, such as "half-sine 1500 g 0.5 ms".
        critical_velocity_change: the boundary of damage: below it no short pulse damages it,
            whatever its acceleration, and above it one does [m/s].
        natural_frequency: of the part on its mounting [Hz].
        joint: name or glob of joints, in place of `at`.
        momentary_torque: that the gears of these joints withstand; by default the effort limit of
            the robot's file [N m, N].
        torque_duration: for which they do [s].
        imu_bandwidth: of a part that is an accelerometer, as that of a scene.
    """

    name: str
    at: str | None = None
    rating: str | None = None
    critical_velocity_change: float | None = None
    natural_frequency: float | None = None
    joint: str | None = None
    momentary_torque: float | None = None
    torque_duration: float | None = None
    imu_bandwidth: str | None = None


@documented
@frozen(kw_only=True)
@with_wing_options
class Scene(Record):
    """One landing of one robot.

    Attributes:
        robot: a name that `shockpc robots` lists, or the path of a URDF, xacro, MJCF or SDFormat
            file.
        packages: folders of packages, for `package://` and `$(find …)`; in that of "*" files are
            found by their names only.
        xacro: arguments of a xacro file.
        posture: posture of base and joints.
        strike: velocity relative to the ground.
        contact: the contacts that strike at the same time; from Python also one contact, or names
            of frames.
        stance: frames, or points FRAME:x,y,z, that are already on the ground and stay where they
            are.
        closure: loops, in addition to those of the robot's file.
        joints: joint model (free, geared or locked).
        point: points at which the shock is computed, in addition to the robot's sensors.
        part: parts and what they withstand.
        tangential_stiffness: of every contact along the ground; by default that along the normal
            [N/m].

    Raises:
        SceneError: a path holds a NUL character.
    """

    robot: str
    base: Base | None = option(
        None,
        "How the base may move: free, in the plane only (planar), or not (fixed). By default fixed "
        "if "
        "the file fixes it, if the root link is called world and has no legs, or if the robot is "
        "an arm (no feet, one "
        "chain from the root); otherwise free. If an MJCF file fixes the base, free and planar "
        "give it a free joint.",
        POSTURE,
    )
    plane: Literal["auto", "xz", "yz", "xy"] | tuple[float, float, float] = option(
        "auto",
        "Plane of CoPc, RoPc, figures and the strike angle: xz (sagittal), yz (frontal), xy, or a "
        "normal NX,NY,NZ; auto is "
        "xz, or yz where more than half of the motion before the impact is sideways (velocity "
        "along y, rotation about x).",
        RESULTS,
        "PLANE",
    )
    srdf: str | None = option(
        None,
        "File of reference postures.",
        POSTURE,
        default="the one beside the robot",
        on_command_line=False,
    )
    packages: Mapping[str, str] = field(default_factory=dict)
    xacro: Mapping[str, str] = field(default_factory=dict)
    posture: Posture = field(default_factory=Posture)
    strike: Strike = field(default_factory=Strike)
    contact: tuple[Contact, ...] = ()
    stance: tuple[str, ...] = ()
    closure: tuple[Closure, ...] = ()
    assemble: tuple[str, ...] = option(
        (),
        "The only joints that may move to close loops; by default all that the posture does not "
        "set.",
        POSTURE,
        "JOINT",
    )
    joints: Joints = field(default_factory=Joints)
    flex: Mapping[str, str] = option(
        dict,
        "Links that bend on contacts of finite stiffness: EI:674 [N m²], tube:70e9,0.025,0.021 (E "
        "[Pa], outer and inner diameter [m]), or the link's first bending frequency, 180Hz:clamped "
        "or 180Hz:free. Behind it, as in EI:674,hinges:4, may stand the number of hinges, and the "
        "stiffness against stretch, EA:1e7 [N], and torsion, GJ:500 [N m²].",
        SOFT,
        "LINK=FLEX",
        wing="compliant",
    )
    point: tuple[Point, ...] = ()
    part: tuple[Part, ...] = ()
    v_in: Literal["contact", "com"] = option(
        "contact",
        "The speed that shock is relative to: of the contact or of the centre of mass.",
        RESULTS,
    )
    pulse: str | None = option(
        None,
        "Also give peak accelerations, as half-sine:5ms; shapes are half-sine, saw-tooth, "
        "haversine and rectangle.",
        RESULTS,
        "SHAPE:LENGTH",
    )
    range_g: float | None = option(
        None,
        "Measuring range of the sensors. Peaks are compared with it along each axis of a frame; at "
        "a point with an "
        "offset, the magnitude is compared. Peaks follow from the contact stiffness, else from the "
        "pulse.",
        RESULTS,
        "G",
        unit="g",
        above=0.0,
    )
    imu_bandwidth: str | None = option(
        None,
        "Bandwidth of the accelerometers, such as 200Hz. The low-pass filter is of first order, or "
        "with :2 of second order "
        "(Butterworth). Peaks behind the filter are given too, and compared with the range.",
        RESULTS,
        "F[:1|:2]",
    )
    friction: float | None = option(
        None,
        "Also solve with this coefficient of friction. Quantities *_friction are for this "
        "friction, with restitution only along "
        "the normal. All other quantities are for contacts that stick.",
        RESULTS,
        "MU",
        unit="1",
        least=0.0,
        varies=True,
    )
    stops: bool | None = option(
        None,
        "Joints at a limit that the impact would drive beyond it are held by end stops, which can "
        "only push; by default they move "
        "on, with a warning.",
        RESULTS,
    )
    stop_restitution: float | None = option(
        None,
        "Coefficient of restitution of end stops, 0 to 1.",
        RESULTS,
        "E",
        least=0.0,
        greatest=1.0,
        unit="1",
        varies=True,
    )
    stop_stiffness: float | None = option(
        None,
        "Stiffness of the end stops of hinges and of slides, beside a --contact-stiffness.",
        SOFT,
        "K",
        unit="N m/rad, N/m",
        above=0.0,
        varies=True,
        wing="compliant",
    )
    contact_stiffness: float | None = option(
        None,
        "Also solve on contacts of this stiffness. The stiffness is that of every direction, or "
        "of the normal and the ground. It gives forces, accelerations and their times. Examples: "
        f"{CONTACTS.removesuffix(' N/m or more')} or more (sources: shockpc guide stiffness).",
        SOFT,
        "KN[:KT]",
        unit="N/m",
        above=0.0,
        varies=True,
        wing="compliant",
    )
    tangential_stiffness: float | None = field(default=None, metadata={"wing": "compliant"})
    contact_damping: float | None = option(
        None,
        "Damping of these contacts, in place of --restitution: a damper beside each of their "
        "springs, along the normal and the "
        "ground. The force starts at C times the speed of approach, and the contact separates "
        "where it would pull.",
        SOFT,
        "C",
        unit="N s/m",
        above=0.0,
        varies=True,
        wing="compliant",
    )
    contact_law: Literal["hysteresis", "damper"] | None = option(
        None,
        "Loss of these contacts at a given --restitution. hysteresis (default) unloads them with "
        "a larger stiffness; at restitution 0 the force ends in a step, so links and springs "
        "ring. damper: a viscous damper in series with each spring; the force has no step and is "
        "smaller.",
        SOFT,
        "LAW",
        wing="compliant",
    )
    gravity: bool = option(
        True,
        "Gravity acts while the robot is on contacts of finite stiffness; --no-gravity, or gravity "
        "= false, leaves it out.",
        SOFT,
        name="no-gravity",
        wing="compliant",
    )
    ground_tolerance: float = option(
        0.005,
        "Largest difference in height between lowest points that flat ground can touch together "
        "(warnings, feasible).",
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
            flex: Mapping[str, str] = ...,
            point: Sequence[Point] = (),
            part: Sequence[Part] = (),
            v_in: Literal["contact", "com"] = "contact",
            pulse: str | None = None,
            range_g: float | None = None,
            imu_bandwidth: str | None = None,
            friction: float | None = None,
            stops: bool | None = None,
            stop_restitution: float | None = None,
            stop_stiffness: float | None = None,
            contact_stiffness: float | None = None,
            tangential_stiffness: float | None = None,
            contact_damping: float | None = None,
            contact_law: Literal["hysteresis", "damper"] | None = None,
            gravity: bool = True,
            ground_tolerance: float = 0.005,
        ) -> None: ...

    @property
    def yields(self) -> bool:
        """True if something gives way under the impact, so that the landing lasts."""
        return self.contact_stiffness is not None

    @property
    def yielding(self) -> str:
        """The parts that give way, such as "contacts of 100000 N/m"; empty if there are none."""
        return (
            "" if self.contact_stiffness is None else f"contacts of {self.contact_stiffness:g} N/m"
        )

    @property
    def rigid(self) -> "Scene":
        """The scene with contacts and links that do not give way."""
        scene: Scene = of_the_core(self)
        return replace(scene, joints=of_the_core(self.joints))

    def __post_init__(self) -> None:
        """Make the contacts a tuple of `Contact` and paths text, and check the paths.

        Paths that no file can have are refused.
        """
        contact: Any = self.contact
        contacts = contact if isinstance(contact, tuple | list) else (contact,)
        stated_contacts: list[Any] = []
        for stated in contacts:
            stated_contacts.append(Contact(frame=stated) if isinstance(stated, str) else stated)
        object.__setattr__(self, "contact", tuple(stated_contacts))
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
                raise SceneError(
                    f"{json.dumps(path)} cannot be the path of a file: it holds a NUL character"
                )
