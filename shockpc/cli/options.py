"""The options that several commands share, declared once: the fields of a record, which a command takes by `takes_options`."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from shockpc.cli.declare import option
from shockpc.cli.parse import (
    Definition,
    Setting,
    Vector,
    definition,
    finite,
    folder_definition,
    path,
    plane_or_normal,
    robot_name,
    setting,
    vector,
)

__all__ = ["RobotName", "RobotOptions", "SceneOptions"]

RobotName = Annotated[
    str,
    typer.Argument(metavar="ROBOT", help="A robot file (URDF, xacro, MJCF), a robot's name, or a scene (TOML).", parser=robot_name),
]
"""What is analysed."""

FILES, CONTACT, POSTURE, IMPACT, JOINTS, RESULTS = (
    "Robot files",
    "Contact",
    "Posture",
    "Velocity before the impact",
    "Joint model",
    "What is computed",
)


@dataclass(frozen=True, kw_only=True)
class RobotOptions:
    """How a robot file is read."""

    xacro: Annotated[
        list[Definition],
        option(
            "Argument of a xacro file.",
            group=FILES,
            metavar="NAME:=VALUE",
            parser=definition("NAME:=VALUE", "payload:=1.5"),
        ),
    ] = field(default_factory=list)
    package: Annotated[
        list[Definition],
        option(
            "Folder of a package, besides those in ROS_PACKAGE_PATH.", group=FILES, metavar="NAME=DIR", parser=folder_definition
        ),
    ] = field(default_factory=list)


@dataclass(frozen=True, kw_only=True)
class SceneOptions(RobotOptions):
    """All that a scene consists of; None, False or empty where nothing was typed."""

    contact: Annotated[
        list[str],
        option(
            "What strikes the ground: a frame, a glob or part of a link's name. "
            "Several matches are one landing each; A+B is one landing on both.",
            group=CONTACT,
            metavar="NAME",
        ),
    ] = field(default_factory=list)
    together: Annotated[bool, option("One landing on all matching contacts at once.", "--together", group=CONTACT)] = False
    offset: Annotated[
        Vector | None,
        option(
            "Contact point from the frame's origin, in its axes [m].", group=CONTACT, metavar="X,Y,Z", parser=vector("0,0,-0.02")
        ),
    ] = None
    contact_point: Annotated[
        Literal["frame", "lowest"] | None,
        option("Contact point at the frame's origin, or at the lowest point of the link's collision geometry.", group=CONTACT),
    ] = None
    slide: Annotated[bool, option("No friction: the contact stops the normal direction only.", "--slide", group=CONTACT)] = False
    restitution: Annotated[
        float | None,
        option("Coefficient of restitution, 0 (default) to 1.", group=CONTACT, metavar="E", parser=finite),
    ] = None
    stance: Annotated[
        list[str], option("A foot that is on the ground already and stays where it is.", group=CONTACT, metavar="FRAME")
    ] = field(default_factory=list)
    posture: Annotated[
        str | None,
        option("A reference posture of the robot, or neutral; by default the standing one.", group=POSTURE, metavar="NAME"),
    ] = None
    srdf: Annotated[Path | None, option("File of reference postures.", group=POSTURE, metavar="FILE", parser=path)] = None
    set: Annotated[
        list[Setting],
        option(
            "Position of joints, by name or glob [deg; m if prismatic].",
            group=POSTURE,
            metavar="JOINT=VALUE",
            parser=setting("JOINT=VALUE", "'*_knee=-60'"),
        ),
    ] = field(default_factory=list)
    base_rpy: Annotated[
        Vector | None,
        option(
            "Roll, pitch and yaw of the base [deg]; a positive pitch is nose down.",
            group=POSTURE,
            metavar="R,P,Y",
            parser=vector("0,15,0"),
        ),
    ] = None
    base: Annotated[
        Literal["free", "planar", "fixed"] | None,
        option("How the base may move; by default free, or fixed where the robot file fixes it.", group=POSTURE),
    ] = None
    assemble: Annotated[
        list[str],
        option("The only joints that may move to close loops, by name or glob.", group=POSTURE, metavar="JOINT"),
    ] = field(default_factory=list)
    strike_angle: Annotated[
        float | None,
        option(
            "Angle of the velocity from the vertical in the plane, positive moving forward [deg].",
            group=IMPACT,
            metavar="DEG",
            parser=finite,
        ),
    ] = None
    speed: Annotated[
        float | None, option("Speed along the strike angle [m/s]; 1 by default.", group=IMPACT, metavar="V", parser=finite)
    ] = None
    velocity: Annotated[
        Vector | None,
        option("Velocity of the robot, world axes [m/s].", group=IMPACT, metavar="VX,VY,VZ", parser=vector("0.5,0,-1")),
    ] = None
    drop_height: Annotated[
        float | None, option("Height of a free fall that ends in the impact [m].", group=IMPACT, metavar="H", parser=finite)
    ] = None
    angular_velocity: Annotated[
        Vector | None,
        option("Angular velocity of the base, world axes [rad/s].", group=IMPACT, metavar="WX,WY,WZ", parser=vector("0,3,0")),
    ] = None
    joint_velocity: Annotated[
        list[Setting],
        option(
            "Velocity of joints, by name or glob [rad/s; m/s if prismatic].",
            group=IMPACT,
            metavar="JOINT=RATE",
            parser=setting("JOINT=RATE", "'*_knee=2.5'"),
        ),
    ] = field(default_factory=list)
    joints: Annotated[
        Literal["free", "geared", "locked"] | None,
        option("All joints turn freely, resist by their reflected inertia, or are locked.", group=JOINTS),
    ] = None
    armature: Annotated[
        list[Setting],
        option(
            "Reflected inertia, by name or glob [kg m²; kg if prismatic].",
            group=JOINTS,
            metavar="JOINT=INERTIA",
            parser=setting("JOINT=INERTIA", "'*_KFE=0.05'"),
        ),
    ] = field(default_factory=list)
    lock: Annotated[list[str], option("Locked joints, by name or glob.", group=JOINTS, metavar="JOINT")] = field(
        default_factory=list
    )
    plane: Annotated[
        Any,
        option(
            "Plane of CoPc and RoPc: xz (sagittal, default), yz, xy, or a normal NX,NY,NZ.",
            group=RESULTS,
            metavar="PLANE",
            parser=plane_or_normal,
        ),
    ] = None
    v_in: Annotated[
        Literal["contact", "com"] | None,
        option("The speed that shock is relative to: of the contact (default) or of the centre of mass.", group=RESULTS),
    ] = None
    point: Annotated[
        list[str],
        option("Also give the shock at this point, offset in the frame [m].", group=RESULTS, metavar="FRAME[:X,Y,Z]"),
    ] = field(default_factory=list)
    pulse: Annotated[
        str | None,
        option(
            "Also give peak accelerations, for example half-sine:5ms; shapes are half-sine, saw-tooth, haversine and rectangle.",
            group=RESULTS,
            metavar="SHAPE:LENGTH",
        ),
    ] = None
    range_g: Annotated[
        float | None,
        option("Measuring range of the sensors, compared with the peaks [g].", group=RESULTS, metavar="G", parser=finite),
    ] = None
