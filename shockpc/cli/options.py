"""The options that several commands share, declared once, and how a command takes them.

A record such as `SceneOptions` declares options by its fields: the annotation of a field holds Typer's description, the parser of
its text and its group in the help. A command that has a parameter of that type, and the decorator `takes_options`, has them all:

    @takes_options
    def analyze(robot: RobotName, options: SceneOptions) -> None: …
"""

import functools
import inspect
from collections.abc import Callable
from dataclasses import MISSING, dataclass, field, fields, is_dataclass
from pathlib import Path
from typing import Annotated, Any, Literal, get_type_hints

import typer

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

__all__ = ["RobotName", "RobotOptions", "SceneOptions", "option", "takes_options"]


def option(help_: str, *names: str, group: str, metavar: str | None = None, parser: Callable[[str], Any] | None = None) -> Any:
    """The description of an option.

    Args:
        help_: one sentence for the help.
        *names: how it is typed, where that is not its field's name.
        group: the heading that it stands under in the help.
        metavar: what its value is called in the help.
        parser: from the text of the value to the value.
    """
    return typer.Option(*names, help=help_, metavar=metavar, parser=parser, rich_help_panel=group, show_default=False)


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


def takes_options(command: Callable[..., None]) -> Callable[..., None]:
    """Replace each parameter of a command whose type is a record of options by the options that the record declares."""
    signature = inspect.signature(command, eval_str=True)
    records: dict[str, Any] = {}
    parameters: list[inspect.Parameter] = []
    for parameter in signature.parameters.values():
        record = parameter.annotation
        if not is_dataclass(record):
            parameters.append(parameter.replace(kind=inspect.Parameter.KEYWORD_ONLY))
            continue
        records[parameter.name] = record
        hints = get_type_hints(record, include_extras=True)
        parameters += [
            inspect.Parameter(
                one.name,
                inspect.Parameter.KEYWORD_ONLY,
                annotation=hints[one.name],
                default=[] if one.default is MISSING else one.default,
            )
            for one in fields(record)
        ]

    @functools.wraps(command)
    def run(**typed: Any) -> None:
        for name, record in records.items():
            typed[name] = record(**{one.name: typed.pop(one.name) for one in fields(record)})
        command(**typed)

    # What Typer reads.
    vars(run)["__signature__"] = signature.replace(parameters=parameters)
    run.__annotations__ = {one.name: one.annotation for one in parameters}
    return run
