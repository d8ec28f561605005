"""What a run of `shockpc analyze` leaves behind: standard output, files, scenes."""

import enum
import sys
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from shockpc.result import ShockProfile
    from shockpc.robot.robot import Robot

__all__ = ["Format", "check_pattern", "check_places", "save_scenes", "shown", "write_files"]


class Format(enum.StrEnum):
    """What standard output carries."""

    TABLE = "table"
    JSON = "json"
    CSV = "csv"
    MARKDOWN = "markdown"


def check_places(out: Path | None, save_scene: Path | None) -> None:
    """See that results can be written before anything is computed."""
    from shockpc.cli.build import ROBOT_SUFFIXES, is_scene_file
    from shockpc.errors import OutputError
    from shockpc.show.files import check_folder

    if out is not None:
        check_folder(out, "--out")
    if save_scene is not None:
        if save_scene.is_dir():
            raise OutputError(f'"{save_scene}" is a folder; name a file with --save-scene, such as landing.toml')
        if save_scene.suffix.casefold() in ROBOT_SUFFIXES:
            raise OutputError(f'"{save_scene}" would be read as a robot; name a scene with --save-scene, such as landing.toml')
        if save_scene.exists() and not is_scene_file(str(save_scene)):
            raise OutputError(f'"{save_scene}" is there already and holds no scene; name another file with --save-scene')
        if not save_scene.parent.exists():
            raise OutputError(f'there is no folder "{save_scene.parent}" for --save-scene; make it, or name another file')
        check_folder(save_scene.parent, "--save-scene")


def check_pattern(robot: "Robot", pattern: str) -> None:
    """A pattern that fits no body would leave nothing to show."""
    from shockpc.errors import UnknownName
    from shockpc.show.tables.sheets import fits

    names = [body.name for body in robot.bodies]
    if not any(fits(name, pattern) for name in names):
        raise UnknownName("body", pattern, names, f'robot "{robot.name}"', f"shockpc robots {robot.label}")


def shown(profiles: "list[ShockProfile]", format_: Format, bodies: str | None) -> str:
    """What goes to standard output. CSV has no place for warnings, so those go to standard error."""
    if format_ is Format.JSON:
        from shockpc.show.document import to_json

        return to_json(profiles)
    from shockpc.show.tables.text import csv_report, markdown_report, text_report

    if format_ is Format.MARKDOWN:
        return markdown_report(profiles, bodies)
    if format_ is Format.CSV:
        for warning in dict.fromkeys(warning for profile in profiles for warning in profile.health.warnings):
            sys.stderr.write(f"shockpc: warning: {warning}\n")
        return csv_report(profiles, bodies)
    return text_report(profiles, bodies)


def write_files(profiles: "list[ShockProfile]", out: Path, bodies: str | None) -> None:
    """One landing into the folder itself; several into a folder each, with a summary beside them."""
    from shockpc.show.files import write_text
    from shockpc.show.folder import write_profile
    from shockpc.show.tables.sheets import summary_sheet
    from shockpc.show.tables.text import as_csv, as_markdown

    if len(profiles) == 1:
        write_profile(profiles[0], out, bodies)
        return
    for profile, name in zip(profiles, _file_names(profiles), strict=True):
        write_profile(profile, out / name, bodies)
    summary = summary_sheet(profiles)
    write_text(out / "summary.csv", as_csv(summary))
    write_text(out / "summary.md", as_markdown(summary))


def save_scenes(profiles: "list[ShockProfile]", path: Path) -> None:
    """One landing into the file itself; several into a file each, named after the contact."""
    from shockpc.scene import scene_text
    from shockpc.show.files import write_text

    for profile, name in zip(profiles, _file_names(profiles), strict=True):
        target = path if len(profiles) == 1 else path.with_stem(f"{path.stem}.{name}")
        write_text(target, scene_text(profile.scene, target.parent))


def _file_names(profiles: "list[ShockProfile]") -> list[str]:
    """The landings' contacts as names of files, each its own; never one that leads out of its folder or hides in it."""
    from shockpc.show.tables.sheets import contact_name

    names: list[str] = []
    for profile in profiles:
        name = "".join(sign if sign.isalnum() or sign in "_-+." else "_" for sign in contact_name(profile))
        name = f"_{name[1:]}" if name.startswith(".") else name
        taken = {known.casefold() for known in names}
        names.append(next(n for n in (name, *(f"{name}-{k}" for k in range(2, len(profiles) + 2))) if n.casefold() not in taken))
    return names
