"""`shockpc analyze`: from a robot file to a table and a figure."""

import enum
import gc
import sys
from pathlib import Path
from typing import Annotated

import typer

from shockpc.cli.output import Format, check_pattern, check_places, save_scenes, shown, write_files

__all__ = ["BaseKind", "ContactPoint", "JointModel", "SpeedOf", "analyze"]


class BaseKind(enum.StrEnum):
    """How the base may move."""

    FREE = "free"
    PLANAR = "planar"
    FIXED = "fixed"


class JointModel(enum.StrEnum):
    """What the drives do."""

    FREE = "free"
    GEARED = "geared"
    LOCKED = "locked"


class SpeedOf(enum.StrEnum):
    """Whose speed normalises shock."""

    CONTACT = "contact"
    COM = "com"


class ContactPoint(enum.StrEnum):
    """Which point of the link strikes."""

    FRAME = "frame"
    LOWEST = "lowest"


def analyze(
    robot: Annotated[str, typer.Argument(help="A robot file (URDF, xacro, MJCF), a robot's name, or a scene (TOML).")],
    contact: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="What strikes: a frame, a glob or part of a link's name; A+B for one landing on both."),
    ] = None,
    together: Annotated[bool, typer.Option("--together", help="One landing on all matching contacts at once.")] = False,
    offset: Annotated[str | None, typer.Option(metavar="X,Y,Z", help="Contact point from the frame's origin [m].")] = None,
    contact_point: Annotated[
        ContactPoint | None, typer.Option(help="Strike at the frame's origin, or at the link's lowest point.")
    ] = None,
    slide: Annotated[bool, typer.Option("--slide", help="No friction: the contact stops the normal direction only.")] = False,
    restitution: Annotated[str | None, typer.Option(metavar="E", help="Speed after impact over speed before it, 0 to 1.")] = None,
    posture: Annotated[str | None, typer.Option(metavar="NAME", help="A reference posture of the robot, or neutral.")] = None,
    srdf: Annotated[Path | None, typer.Option(metavar="FILE", help="Read reference postures from this file.")] = None,
    set_: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="JOINT=VALUE", help="Set joints, by name or glob [deg; m if prismatic]."),
    ] = None,
    base_rpy: Annotated[str | None, typer.Option(metavar="R,P,Y", help="Roll, pitch and yaw of the base [deg].")] = None,
    base: Annotated[BaseKind | None, typer.Option(help="How the base may move.")] = None,
    strike_angle: Annotated[
        str | None,
        typer.Option(metavar="DEG", help="Velocity from the vertical in the plane, positive moving forward [deg]."),
    ] = None,
    speed: Annotated[str | None, typer.Option(metavar="V", help="Speed along the strike angle [m/s]; 1 by default.")] = None,
    velocity: Annotated[str | None, typer.Option(metavar="VX,VY,VZ", help="Velocity of the strike, world axes [m/s].")] = None,
    drop_height: Annotated[str | None, typer.Option(metavar="H", help="Strike after a free fall from this height [m].")] = None,
    angular_velocity: Annotated[
        str | None, typer.Option(metavar="WX,WY,WZ", help="Rotation of the robot before the strike, world axes [rad/s].")
    ] = None,
    joint_velocity: Annotated[
        list[str] | None,
        typer.Option(metavar="JOINT=RATE", help="Joint rates before the strike, by name or glob [rad/s; m/s if prismatic]."),
    ] = None,
    stance: Annotated[
        list[str] | None, typer.Option(metavar="FRAME", help="A foot that is down already and stays where it is.")
    ] = None,
    joints: Annotated[
        JointModel | None, typer.Option(help="What all drives do: turn freely, resist by their reflected inertia, or hold.")
    ] = None,
    armature: Annotated[
        list[str] | None, typer.Option(metavar="JOINT=INERTIA", help="Reflected inertia, by name or glob [kg m²; kg if prismatic].")
    ] = None,
    lock: Annotated[list[str] | None, typer.Option(metavar="JOINT", help="Joints whose gearbox holds, by name or glob.")] = None,
    assemble: Annotated[
        list[str] | None, typer.Option(metavar="JOINT", help="The only joints that may move to close loops, by name or glob.")
    ] = None,
    v_in: Annotated[SpeedOf | None, typer.Option(help="Whose speed normalises shock.")] = None,
    pulse: Annotated[
        str | None, typer.Option(metavar="SHAPE:LENGTH", help="Also give peak accelerations, such as half-sine:5ms.")
    ] = None,
    range_g: Annotated[str | None, typer.Option(metavar="G", help="Range of the sensors, to hold peaks against [g].")] = None,
    plane: Annotated[str | None, typer.Option(metavar="PLANE", help="xz (sagittal), yz, xy, or a normal NX,NY,NZ.")] = None,
    point: Annotated[
        list[str] | None,
        typer.Option(metavar="FRAME[:X,Y,Z]", help="Also give the shock at this point, offset in the frame [m]."),
    ] = None,
    xacro: Annotated[list[str] | None, typer.Option(metavar="NAME:=VALUE", help="Argument of a xacro file.")] = None,
    package: Annotated[list[str] | None, typer.Option(metavar="NAME=DIR", help="Folder of a package.")] = None,
    bodies: Annotated[str | None, typer.Option(metavar="PATTERN", help="Show only bodies that fit (tables and CSV).")] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Write JSON, CSV, a report and the figure into this folder.")
    ] = None,
    format_: Annotated[Format, typer.Option("--format", help="What standard output carries.")] = Format.TABLE,
    save_scene: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Write the scene that this command line means, one for each landing."),
    ] = None,
    explain: Annotated[
        bool, typer.Option("--explain", help="Tell on standard error what each stage cost and what was left out.")
    ] = False,
) -> None:
    """Compute the shock of a landing on every body of a robot."""
    from shockpc.trace import Trace

    trace = Trace()
    with trace.stage("imports"):
        from shockpc.cli.build import Options, build
        from shockpc.profile import shock_profile

        gc.freeze()
        gc.enable()
    check_places(out, save_scene)
    options = Options(
        contact=tuple(contact or ()),
        together=together,
        offset=offset,
        contact_point=None if contact_point is None else contact_point.value,
        slide=slide,
        restitution=restitution,
        posture=posture,
        srdf=None if srdf is None else str(srdf),
        set=tuple(set_ or ()),
        base_rpy=base_rpy,
        base=None if base is None else base.value,
        strike_angle=strike_angle,
        speed=speed,
        velocity=velocity,
        drop_height=drop_height,
        angular_velocity=angular_velocity,
        joint_velocity=tuple(joint_velocity or ()),
        stance=tuple(stance or ()),
        joints=None if joints is None else joints.value,
        armature=tuple(armature or ()),
        lock=tuple(lock or ()),
        assemble=tuple(assemble or ()),
        v_in=None if v_in is None else v_in.value,
        pulse=pulse,
        range_g=range_g,
        plane=plane,
        point=tuple(point or ()),
        xacro=tuple(xacro or ()),
        package=tuple(package or ()),
    )
    loaded, scenes = build(robot, options, trace)
    if bodies is not None:
        check_pattern(loaded, bodies)
    profiles = [shock_profile(scene, loaded, trace) for scene in scenes]
    with trace.stage("output"):
        text = shown(profiles, format_, bodies)
        if save_scene is not None:
            save_scenes(profiles, save_scene)
        if out is not None:
            write_files(profiles, out, bodies)
        else:
            trace.skip("figure, and matplotlib with it", "no --out")
        sys.stdout.write(text)
    if explain:
        sys.stderr.write(trace.text())
