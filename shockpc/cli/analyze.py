"""`shockpc analyze`: from a robot file to a table and a figure."""

import enum
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from shockpc.model.robot import Robot
    from shockpc.record import ShockProfile

__all__ = ["BaseKind", "ContactPoint", "Format", "analyze"]


class Format(enum.StrEnum):
    """What standard output carries."""

    TABLE = "table"
    JSON = "json"
    CSV = "csv"
    MARKDOWN = "markdown"


class BaseKind(enum.StrEnum):
    """How the base may move."""

    FREE = "free"
    PLANAR = "planar"
    FIXED = "fixed"


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
    save_scene: Annotated[Path | None, typer.Option(metavar="FILE", help="Write the scene that this command line means.")] = None,
    explain: Annotated[
        bool, typer.Option("--explain", help="Tell on standard error what each stage cost and what was left out.")
    ] = False,
) -> None:
    """Compute the shock of a landing on every body of a robot."""
    from shockpc.ledger import Ledger

    ledger = Ledger()
    with ledger.stage("imports"):
        from shockpc.cli.build import Wishes, build
        from shockpc.profile import shock_profile
    _check_places(out, save_scene)
    wishes = Wishes(
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
        plane=plane,
        point=tuple(point or ()),
        xacro=tuple(xacro or ()),
        package=tuple(package or ()),
    )
    loaded, scenes = build(robot, wishes, ledger)
    if bodies is not None:
        _check_pattern(loaded, bodies)
    profiles = [shock_profile(scene, loaded, ledger) for scene in scenes]
    with ledger.stage("output"):
        text = _shown(profiles, format_, bodies)
        if save_scene is not None:
            _save_scenes(profiles, save_scene)
        if out is not None:
            _write_files(profiles, out, bodies)
        else:
            ledger.skip("figure, and matplotlib with it", "no --out")
        sys.stdout.write(text)
    if explain:
        sys.stderr.write(ledger.text())


def _check_places(out: Path | None, save_scene: Path | None) -> None:
    """See that results can be written before anything is computed."""
    from shockpc.cli.build import is_scene_file
    from shockpc.errors import OutputError
    from shockpc.show.files import check_folder

    if out is not None:
        check_folder(out, "--out")
    if save_scene is not None:
        if save_scene.is_dir():
            raise OutputError(f'"{save_scene}" is a folder; name a file with --save-scene, such as landing.toml')
        if save_scene.exists() and not is_scene_file(str(save_scene)):
            raise OutputError(f'"{save_scene}" is there already and holds no scene; name another file with --save-scene')
        if not save_scene.parent.exists():
            raise OutputError(f'there is no folder "{save_scene.parent}" for --save-scene; make it, or name another file')
        check_folder(save_scene.parent, "--save-scene")


def _check_pattern(robot: "Robot", pattern: str) -> None:
    """A pattern that fits no body would leave nothing to show."""
    from shockpc.errors import UnknownName
    from shockpc.show.sheets import fits

    names = [body.name for body in robot.bodies]
    if not any(fits(name, pattern) for name in names):
        raise UnknownName("body", pattern, names, f'robot "{robot.name}"', f"shockpc robots {robot.label}")


def _shown(profiles: "list[ShockProfile]", format_: Format, bodies: str | None) -> str:
    """What goes to standard output. CSV has no place for warnings, so those go to standard error."""
    from shockpc.show.document import to_json
    from shockpc.show.text import csv_report, markdown_report, text_report

    if format_ is Format.JSON:
        return to_json(profiles)
    if format_ is Format.MARKDOWN:
        return markdown_report(profiles, bodies)
    if format_ is Format.CSV:
        for warning in dict.fromkeys(warning for profile in profiles for warning in profile.health.warnings):
            sys.stderr.write(f"shockpc: warning: {warning}\n")
        return csv_report(profiles, bodies)
    return text_report(profiles, bodies)


def _write_files(profiles: "list[ShockProfile]", out: Path, bodies: str | None) -> None:
    """One landing into the folder itself; several into a folder each, with a summary beside them."""
    from shockpc.show.files import write_text
    from shockpc.show.folder import write_profile
    from shockpc.show.sheets import contact_name, summary_sheet
    from shockpc.show.text import as_csv, as_markdown

    if len(profiles) == 1:
        write_profile(profiles[0], out, bodies)
        return
    for profile in profiles:
        write_profile(profile, out / _file_name(contact_name(profile)), bodies)
    summary = summary_sheet(profiles)
    write_text(out / "summary.csv", as_csv(summary))
    write_text(out / "summary.md", as_markdown(summary))


def _save_scenes(profiles: "list[ShockProfile]", path: Path) -> None:
    """One landing into the file itself; several into a file each, named after the contact."""
    from shockpc.scene_file import scene_text
    from shockpc.show.files import write_text
    from shockpc.show.sheets import contact_name

    for profile in profiles:
        target = path if len(profiles) == 1 else path.with_stem(f"{path.stem}.{_file_name(contact_name(profile))}")
        write_text(target, scene_text(profile.scene, target.parent))


def _file_name(contact: str) -> str:
    """A contact's name as a file's name; never one that leads out of its folder or hides in it."""
    name = "".join(sign if sign.isalnum() or sign in "_-+." else "_" for sign in contact)
    return f"_{name[1:]}" if name.startswith(".") else name
