"""`shockpc robots`: what is known by name, and what is in one robot."""

import sys
from typing import Annotated

import typer

__all__ = ["robots"]


def robots(
    robot: Annotated[str | None, typer.Argument(help="A name from the list, or a robot file.", show_default=False)] = None,
    xacro: Annotated[list[str] | None, typer.Option(metavar="NAME:=VALUE", help="Argument of a xacro file.")] = None,
    package: Annotated[list[str] | None, typer.Option(metavar="NAME=DIR", help="Folder of a package.")] = None,
) -> None:
    """List the robots known by name, or check and show one."""
    from shockpc.cli.parse import package_folders, xacro_arguments

    arguments, packages = xacro_arguments(xacro or ()), package_folders(package or ())
    sys.stdout.write(_all() if robot is None else _one(robot, arguments, packages))


def _all() -> str:
    """The list. A robot that cannot be loaded is a row with the reason."""
    from shockpc.errors import ShockError
    from shockpc.robot.catalogue import catalogue
    from shockpc.robot.robot import load_robot
    from shockpc.show.tables.robots import catalogue_row, catalogue_sheet
    from shockpc.show.tables.text import as_text

    rows, unloaded = [], []
    entries = catalogue()
    for k, entry in enumerate(entries):
        if sys.stderr.isatty():
            sys.stderr.write(f"\r\033[Kreading robot {k + 1} of {len(entries)}: {entry.name}")
            sys.stderr.flush()
        try:
            rows.append(catalogue_row(entry.name, entry.source, load_robot(entry.name)))
        except ShockError as refusal:
            rows.append((entry.name, entry.source, "–", None, "cannot be loaded", ""))
            unloaded.append(f"{entry.name}: {refusal}")
    if sys.stderr.isatty():
        sys.stderr.write("\r\033[K")
    return as_text(catalogue_sheet(rows, unloaded))


def _one(name: str, xacro: dict[str, str], packages: dict[str, str]) -> str:
    """One robot, with the check-up of its file."""
    from shockpc.robot.checkup import check_robot
    from shockpc.robot.robot import load_robot
    from shockpc.show.tables.robots import joints_sheet, links_sheet, robot_lines
    from shockpc.show.tables.text import as_text

    robot = load_robot(name, xacro=xacro, packages=packages)
    lines = [f"{label:<12} {text}" for label, text in robot_lines(robot)]
    findings = [f"{finding.level}: {finding.where}: {finding.text}" for finding in check_robot(robot)]
    blocks = ["\n".join(lines) + "\n", as_text(links_sheet(robot)), as_text(joints_sheet(robot))]
    checkup = "\n".join(findings) if findings else "nothing to find fault with"
    return "\n".join([*blocks, f"check-up\n{checkup}\n"])
