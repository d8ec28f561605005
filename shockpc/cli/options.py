"""The options that several commands share, declared once: the fields of a record, which a command takes by `takes_options`."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from shockpc.cli import parse
from shockpc.cli.declare import option
from shockpc.cli.parse import Definition, Setting, Vector

__all__ = ["RobotName", "RobotOptions", "SceneOptions"]

RobotName = Annotated[
    str,
    typer.Argument(
        metavar="ROBOT", help="A robot file (URDF, xacro, MJCF), a robot's name, or a scene (TOML).", parser=parse.robot_name
    ),
]
"""What is analysed."""

FILES, CONTACT, POSTURE = "Robot files", "Contact", "Posture"
IMPACT, JOINTS, RESULTS = "Velocity before the impact", "Joint model", "What is computed"


def _number(group: str, metavar: str, help_: str) -> Any:
    """An option that takes a number."""
    return option(help_, group=group, metavar=metavar, parser=parse.finite)


def _vector(group: str, metavar: str, example: str, help_: str) -> Any:
    """An option that takes three numbers."""
    return option(help_, group=group, metavar=metavar, parser=parse.vector(example))


def _settings(group: str, form: str, example: str, help_: str) -> Any:
    """An option that takes the number of a joint, or of several by a glob."""
    return option(help_, group=group, metavar=form, parser=parse.setting(form, example))


def _text(group: str, metavar: str, help_: str) -> Any:
    """An option that takes a name, or another text that the library interprets."""
    return option(help_, group=group, metavar=metavar)


@dataclass(frozen=True, kw_only=True)
class RobotOptions:
    """How a robot file is read."""

    xacro: Annotated[
        list[Definition],
        option(
            "Argument of a xacro file.", group=FILES, metavar="NAME:=VALUE", parser=parse.definition("NAME:=VALUE", "payload:=1.5")
        ),
    ] = field(default_factory=list)
    package: Annotated[
        list[Definition],
        option(
            "Folder of a package, besides those in ROS_PACKAGE_PATH.",
            group=FILES,
            metavar="NAME=DIR",
            parser=parse.folder_definition,
        ),
    ] = field(default_factory=list)


@dataclass(frozen=True, kw_only=True)
class SceneOptions(RobotOptions):
    """All that a scene consists of; None, False or empty where nothing was typed."""

    contact: Annotated[
        list[str],
        _text(
            CONTACT,
            "NAME",
            "What strikes the ground: a frame, a glob or part of a link's name. "
            "Several matches are one landing each; A+B is one landing on both.",
        ),
    ] = field(default_factory=list)
    together: Annotated[bool, option("One landing on all matching contacts at once.", "--together", group=CONTACT)] = False
    offset: Annotated[
        Vector | None, _vector(CONTACT, "X,Y,Z", "0,0,-0.02", "Contact point from the frame's origin, in its axes [m].")
    ] = None
    contact_point: Annotated[
        Literal["frame", "lowest"] | None,
        option("Contact point at the frame's origin, or at the lowest point of the link's collision geometry.", group=CONTACT),
    ] = None
    slide: Annotated[bool, option("No friction: the contact stops the normal direction only.", "--slide", group=CONTACT)] = False
    restitution: Annotated[float | None, _number(CONTACT, "E", "Coefficient of restitution, 0 (default) to 1.")] = None
    stance: Annotated[list[str], _text(CONTACT, "FRAME", "A foot that is on the ground already and stays where it is.")] = field(
        default_factory=list
    )
    posture: Annotated[
        str | None, _text(POSTURE, "NAME", "A reference posture of the robot, or neutral; by default the standing one.")
    ] = None
    srdf: Annotated[Path | None, option("File of reference postures.", group=POSTURE, metavar="FILE", parser=parse.path)] = None
    set: Annotated[
        list[Setting],
        _settings(POSTURE, "JOINT=VALUE", "'*_knee=-60'", "Position of joints, by name or glob [deg; m if prismatic]."),
    ] = field(default_factory=list)
    base_rpy: Annotated[
        Vector | None,
        _vector(POSTURE, "R,P,Y", "0,15,0", "Roll, pitch and yaw of the base [deg]; a positive pitch is nose down."),
    ] = None
    base: Annotated[
        Literal["free", "planar", "fixed"] | None,
        option(
            "How the base may move; by default free, or fixed where the file fixes it or its root link is called world.",
            group=POSTURE,
        ),
    ] = None
    assemble: Annotated[list[str], _text(POSTURE, "JOINT", "The only joints that may move to close loops, by name or glob.")] = (
        field(default_factory=list)
    )
    strike_angle: Annotated[
        float | None,
        _number(IMPACT, "DEG", "Angle of the velocity from the vertical in the plane, positive moving forward [deg]."),
    ] = None
    speed: Annotated[float | None, _number(IMPACT, "V", "Speed along the strike angle [m/s]; 1 by default.")] = None
    velocity: Annotated[Vector | None, _vector(IMPACT, "VX,VY,VZ", "0.5,0,-1", "Velocity of the robot, world axes [m/s].")] = None
    drop_height: Annotated[float | None, _number(IMPACT, "H", "Height of a free fall that ends in the impact [m].")] = None
    angular_velocity: Annotated[
        Vector | None, _vector(IMPACT, "WX,WY,WZ", "0,3,0", "Angular velocity of the base, world axes [rad/s].")
    ] = None
    joint_velocity: Annotated[
        list[Setting],
        _settings(IMPACT, "JOINT=RATE", "'*_knee=2.5'", "Velocity of joints, by name or glob [rad/s; m/s if prismatic]."),
    ] = field(default_factory=list)
    joints: Annotated[
        Literal["free", "geared", "locked"] | None,
        option("All joints turn freely, resist by their reflected inertia, or are locked.", group=JOINTS),
    ] = None
    armature: Annotated[
        list[Setting],
        _settings(JOINTS, "JOINT=INERTIA", "'*_KFE=0.05'", "Reflected inertia, by name or glob [kg m²; kg if prismatic]."),
    ] = field(default_factory=list)
    lock: Annotated[list[str], _text(JOINTS, "JOINT", "Locked joints, by name or glob.")] = field(default_factory=list)
    plane: Annotated[
        Any,
        option(
            "Plane of CoPc and RoPc: xz (sagittal, default), yz, xy, or a normal NX,NY,NZ.",
            group=RESULTS,
            metavar="PLANE",
            parser=parse.plane_or_normal,
        ),
    ] = None
    v_in: Annotated[
        Literal["contact", "com"] | None,
        option("The speed that shock is relative to: of the contact (default) or of the centre of mass.", group=RESULTS),
    ] = None
    point: Annotated[list[str], _text(RESULTS, "FRAME[:X,Y,Z]", "Also give the shock at this point, offset in the frame [m].")] = (
        field(default_factory=list)
    )
    pulse: Annotated[
        str | None,
        _text(
            RESULTS,
            "SHAPE:LENGTH",
            "Also give peak accelerations, for example half-sine:5ms; shapes are half-sine, saw-tooth, haversine and rectangle.",
        ),
    ] = None
    range_g: Annotated[float | None, _number(RESULTS, "G", "Measuring range of the sensors, compared with the peaks [g].")] = None
