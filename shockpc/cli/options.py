"""The options that several commands share, declared once: the fields of records, which a command takes by `takes_options`."""

from pathlib import Path
from typing import Annotated, Literal, NamedTuple, TypeAlias

from shockpc.cli.declare import argument, group
from shockpc.cli.parse import (
    Setting,
    Vector,
    definition,
    finite,
    folder,
    out_folder,
    path,
    plane_or_normal,
    robot_name,
    setting,
    vector,
)

__all__ = ["Explain", "Out", "OutputOptions", "Packages", "RobotName", "SceneOptions", "Xacro", "in_output"]

_in_files, _in_contact, _in_posture = group("Robot files"), group("Contact"), group("Posture")
_in_impact, _in_joints, _in_results = group("Velocity before the impact"), group("Joint model"), group("What is computed")
in_output = group("Output")

RobotName: TypeAlias = Annotated[
    str, argument("A robot file (URDF, xacro, MJCF), a robot's name, or a scene (.toml).", "ROBOT", robot_name)
]
"""What is analysed."""

Xacro: TypeAlias = Annotated[tuple[tuple[str, str], ...], _in_files("Argument of a xacro file.", "NAME:=VALUE", definition)]
"""Arguments of a xacro file."""

Packages: TypeAlias = Annotated[
    tuple[tuple[str, str], ...], _in_files("Folder of a package, besides those in ROS_PACKAGE_PATH.", "NAME=DIR", folder)
]
"""Folders of packages."""

Out: TypeAlias = Annotated[Path | None, in_output("Write JSON, CSV, a report and figures into this folder.", "DIR", out_folder)]
"""The folder of results."""

Explain: TypeAlias = Annotated[bool, in_output("Report on standard error what ran, how long it took, and what was not needed.")]
"""Whether the trace is printed."""


class SceneOptions(NamedTuple):
    """All that a scene consists of; None, False or empty where nothing was typed."""

    xacro: Xacro = ()
    package: Packages = ()
    contact: Annotated[
        tuple[str, ...],
        _in_contact(
            "What strikes the ground: a frame, a glob or part of a link's name. "
            "Several matches are one landing each; A+B is one landing on both.",
            "NAME",
        ),
    ] = ()
    together: Annotated[bool, _in_contact("One landing on all matching contacts at once.")] = False
    offset: Annotated[Vector | None, _in_contact("Contact point from the frame's origin, in its axes [m].", "X,Y,Z", vector)] = None
    contact_point: Annotated[
        Literal["frame", "lowest"] | None,
        _in_contact("Contact point at the frame's origin, or at the lowest point of the link's collision geometry."),
    ] = None
    slide: Annotated[bool, _in_contact("No friction: the contact stops the normal direction only.")] = False
    restitution: Annotated[float | None, _in_contact("Coefficient of restitution, 0 (default) to 1.", "E", finite)] = None
    stance: Annotated[tuple[str, ...], _in_contact("A foot that is on the ground already and stays where it is.", "FRAME")] = ()
    posture: Annotated[
        str | None, _in_posture("A reference posture of the robot, or neutral; by default the standing one.", "NAME")
    ] = None
    srdf: Annotated[Path | None, _in_posture("File of reference postures.", "FILE", path)] = None
    set: Annotated[
        tuple[Setting, ...], _in_posture("Position of joints, by name or glob [deg; m if prismatic].", "JOINT=VALUE", setting)
    ] = ()
    base_rpy: Annotated[
        Vector | None, _in_posture("Roll, pitch and yaw of the base [deg]; a positive pitch is nose down.", "R,P,Y", vector)
    ] = None
    base: Annotated[
        Literal["free", "planar", "fixed"] | None,
        _in_posture("How the base may move; by default free, or fixed where the file fixes it or its root link is called world."),
    ] = None
    assemble: Annotated[
        tuple[str, ...], _in_posture("The only joints that may move to close loops, by name or glob.", "JOINT")
    ] = ()
    strike_angle: Annotated[
        float | None,
        _in_impact("Angle of the velocity from the vertical in the plane, positive moving forward [deg].", "DEG", finite),
    ] = None
    speed: Annotated[float | None, _in_impact("Speed along the strike angle [m/s]; 1 by default.", "V", finite)] = None
    velocity: Annotated[Vector | None, _in_impact("Velocity of the robot, world axes [m/s].", "VX,VY,VZ", vector)] = None
    drop_height: Annotated[float | None, _in_impact("Height of a free fall that ends in the impact [m].", "H", finite)] = None
    angular_velocity: Annotated[
        Vector | None, _in_impact("Angular velocity of the base, world axes [rad/s].", "WX,WY,WZ", vector)
    ] = None
    joint_velocity: Annotated[
        tuple[Setting, ...], _in_impact("Velocity of joints, by name or glob [rad/s; m/s if prismatic].", "JOINT=RATE", setting)
    ] = ()
    joints: Annotated[
        Literal["free", "geared", "locked"] | None,
        _in_joints("All joints turn freely, resist by their reflected inertia, or are locked."),
    ] = None
    armature: Annotated[
        tuple[Setting, ...], _in_joints("Reflected inertia, by name or glob [kg m²; kg if prismatic].", "JOINT=INERTIA", setting)
    ] = ()
    lock: Annotated[tuple[str, ...], _in_joints("Locked joints, by name or glob.", "JOINT")] = ()
    plane: Annotated[
        str | Vector | None,
        _in_results("Plane of CoPc and RoPc: xz (sagittal, default), yz, xy, or a normal NX,NY,NZ.", "PLANE", plane_or_normal),
    ] = None
    v_in: Annotated[
        Literal["contact", "com"] | None,
        _in_results("The speed that shock is relative to: of the contact (default) or of the centre of mass."),
    ] = None
    point: Annotated[
        tuple[str, ...], _in_results("Also give the shock at this point, offset in the frame [m].", "FRAME[:X,Y,Z]")
    ] = ()
    pulse: Annotated[
        str | None,
        _in_results(
            "Also give peak accelerations, for example half-sine:5ms; shapes are half-sine, saw-tooth, haversine and rectangle.",
            "SHAPE:LENGTH",
        ),
    ] = None
    range_g: Annotated[float | None, _in_results("Measuring range of the sensors, compared with the peaks [g].", "G", finite)] = (
        None
    )


class OutputOptions(NamedTuple):
    """How the results of a study are given."""

    format: Annotated[Literal["table", "json", "csv", "markdown"], in_output("What is printed; table by default.")] = "table"
    out: Out = None
