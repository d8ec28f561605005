"""`shockpc batch`: many robots, each landing on each of its feet."""

import functools
from typing import TYPE_CHECKING, Annotated

import typer

from shockpc.cli.declare import argument, group, takes_options, without
from shockpc.cli.options import OutputOptions, SceneOptions, in_output
from shockpc.cli.parse import robot_name

if TYPE_CHECKING:
    from shockpc.result import ShockProfile
    from shockpc.robot.robot import Robot
    from shockpc.scene import Scene
    from shockpc.show.figure.view import View

__all__ = ["batch"]

_in_robots = group("Robots")

INCOMPLETE = 3
"""Exit code if some landings could not be computed."""


@takes_options
def batch(
    *,
    robots: Annotated[tuple[str, ...], argument("Robots by name, robot files and scenes.", "[ROBOT]...", robot_name)] = (),
    set_: Annotated[tuple[str, ...], _in_robots("A set of robots: quadrupeds, bipeds or all.", "SET")] = (),
    jobs: Annotated[int, _in_robots("Processes that compute at the same time; 1 by default.", "N", least=1)] = 1,
    options: Annotated[SceneOptions, without("set")],
    output: OutputOptions,
    figures: Annotated[bool, in_output("Also draw all landings on one contact sheet in that folder.")] = False,
) -> None:
    """Land many robots on each of their feet, and rank them.

    Each robot stands in its standing posture and falls straight down at 1 m/s, unless options say otherwise. With --contact, only
    matching feet strike; a scene lands as it says. Ends with exit code 3 if some landings cannot be computed.
    """
    from shockpc.cli.output import check_out, give
    from shockpc.cli.progress import progress
    from shockpc.errors import StudyError
    from shockpc.executor import executor
    from shockpc.robot.catalogue import robots_of_set
    from shockpc.show.reports.batch import batch_report
    from shockpc.studies import batch as study

    names = list(dict.fromkeys([*robots, *(name for one in set_ for name in robots_of_set(one))]))
    if not names:
        raise StudyError("no robot is named; give names or files, or a set: shockpc batch --set quadrupeds")
    if figures and output.out is None:
        raise StudyError("--figures needs a folder to write to; give one with --out")
    check_out(output.out)
    with executor(min(jobs, len(names))) as pool:
        read = functools.partial(_landings, options)
        found = study.batch(names, read, pool, _thumbnail if figures else None, progress("robots computed", len(names)))
    give(batch_report(found), output)
    if found.failures:
        raise typer.Exit(INCOMPLETE)


def _landings(options: SceneOptions, name: str) -> "tuple[Robot, list[Scene]]":
    """A robot and its landings, as the options say."""
    from shockpc.cli.scenes import scenes_from

    return scenes_from(name, options, on_each_foot=True)


def _thumbnail(profile: "ShockProfile") -> "View":
    """The small picture of a landing."""
    from shockpc.show.figure.view import view_of

    return view_of(profile)
