"""`shockpc robots`: the robots known by name, and the contents of one robot."""

import sys
from typing import TYPE_CHECKING

from shockpc.cli.declare import argument, command
from shockpc.cli.options import PACKAGE, XACRO
from shockpc.cli.parse import robot_name

if TYPE_CHECKING:
    from shockpc.robot.record import Robot

__all__ = ["robots"]


@command(
    "List the robots known by name, or check and show one.",
    "shockpc robots hyq",
)
def robots(
    *,
    robot: str | None = argument("A name from the list, or a robot file.", "ROBOT", robot_name),
    xacro: tuple[tuple[str, str], ...] = XACRO,
    package: tuple[tuple[str, str], ...] = PACKAGE,
) -> None:
    from shockpc.robot.load import load_robot

    sys.stdout.write(_all() if robot is None else _one(load_robot(robot, xacro=dict(xacro), packages=dict(package))))


def _all() -> str:
    """The list; a robot that cannot be loaded is a row without numbers."""
    from shockpc.cli.progress import progress
    from shockpc.errors import ShockError
    from shockpc.robot.catalogue import catalogue, own_robots_folder
    from shockpc.robot.load import load_robot
    from shockpc.show.reports.robots import catalogue_row, catalogue_sheet
    from shockpc.show.tables import as_text

    rows = []
    entries = catalogue()
    show = progress("robots read", len(entries))
    for entry in entries:
        try:
            rows.append(catalogue_row(entry.name, load_robot(entry.name)))
        except ShockError:
            rows.append((entry.name, "–", None, "cannot be loaded", f"why: shockpc robots {entry.name}"))
        show(entry.name)
    own = sum(entry.path.parent == own_robots_folder() for entry in entries)
    return as_text(catalogue_sheet(rows, own))


def _one(robot: "Robot") -> str:
    """A robot, with the check-up of its file."""
    from shockpc.printed import printable
    from shockpc.robot.checkup import check_robot
    from shockpc.show.reports.robots import joints_sheet, links_sheet, robot_lines
    from shockpc.show.tables import as_text

    lines = [f"{label:<12} {text}" for label, text in robot_lines(robot)]
    findings = [printable(f"{finding.level}: {finding.where}: {finding.text}") for finding in check_robot(robot)]
    blocks = ["\n".join(lines) + "\n", as_text(links_sheet(robot)), as_text(joints_sheet(robot))]
    checkup = "\n".join(findings) if findings else "nothing found"
    blocks.append(f"check-up\n{checkup}\n")
    if robot.source.kind == "urdf":
        blocks.append(f"second reader\n{_second_reading(robot)}\n")
    return "\n".join(blocks)


def _second_reading(robot: "Robot") -> str:
    """Whether a second reader of URDFs reads the same robot."""
    from shockpc.errors import RobotError
    from shockpc.printed import printable
    from shockpc.robot.second_reader import second_reading

    try:
        reading = second_reading(robot)
    except RobotError as refusal:
        return printable(f"warning: {refusal}")
    what = f"{reading.links} links, {reading.joints} joints, limits, mimics, inertias and placements at random configurations"
    lines = [f"warning: yourdfpy: {difference}" for difference in reading.differences] or [f"yourdfpy reads the same {what}"]
    return "\n".join(map(printable, (*lines, *(f"note: yourdfpy's check: {fault}" for fault in reading.faults))))
