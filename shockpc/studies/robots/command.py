"""`shockpc robots`: the robots known by name, and the contents of one robot."""

from typing import TYPE_CHECKING

from shockpc.cli.declared import argument, command
from shockpc.cli.options import MESHES, PACKAGE, XACRO, OutputOptions, packages_of
from shockpc.cli.parse import typed_robot

if TYPE_CHECKING:
    from shockpc.robot.robot import Robot


@command(
    examples=("shockpc robots hyq",),
)
def robots(
    *,
    robot: str | None = argument("A name from the list, or a robot file.", "ROBOT", typed_robot),
    xacro: tuple[tuple[str, str], ...] = XACRO,
    package: tuple[tuple[str, str], ...] = PACKAGE,
    meshes: str | None = MESHES,
    output: OutputOptions,
) -> None:
    from shockpc.cli.output import emit
    from shockpc.robot.load import load_robot
    from shockpc.studies.robots.report import robot_report, robots_report
    from shockpc.text.errors import StudyError

    if robot is None:
        if xacro or package or meshes:
            raise StudyError(
                "--xacro, --package and --meshes are for the files of one robot; name it, or leave "
                "them out"
            )
        report = robots_report(*_catalogue())
    else:
        report = robot_report(
            load_robot(robot, xacro=dict(xacro), packages=packages_of(package, meshes))
        )
    emit(report, output)


def _catalogue() -> "tuple[dict[str, Robot | None], int]":
    """Every robot by its name, None if it cannot be loaded; and the number of the project's own.

    These are the first ones.
    """
    from shockpc.cli.progress import progress
    from shockpc.robot.catalogue import catalogue, project_robots_folder
    from shockpc.robot.load import load_robot
    from shockpc.text.errors import ShockError

    robots: dict[str, Robot | None] = {}
    entries = catalogue()
    show = progress("robots read", len(entries))
    for entry in entries:
        try:
            robots[entry.name] = load_robot(entry.name)
        except ShockError:
            robots[entry.name] = None
        show(entry.name)
    return robots, sum(entry.path.parent == project_robots_folder() for entry in entries)
