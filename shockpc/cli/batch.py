"""`shockpc batch`: many robots, each landing on each of its feet."""

import functools
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from shockpc.cli.declare import option, takes_options, without
from shockpc.cli.options import SceneOptions
from shockpc.cli.parse import path, positive_count, robot_name

if TYPE_CHECKING:
    from shockpc.result import ShockProfile
    from shockpc.robot.robot import Robot
    from shockpc.scene import Scene
    from shockpc.show.figure.contact_sheet import Thumbnail

__all__ = ["batch"]

ROBOTS, OUTPUT = "Robots", "Output"

INCOMPLETE = 3
"""Exit code if some landings could not be computed."""


@takes_options
def batch(
    *,
    robots: Annotated[
        list[str] | None,
        typer.Argument(metavar="[ROBOT]...", help="Robots by name, robot files and scenes.", show_default=False, parser=robot_name),
    ] = None,
    set_: Annotated[
        list[str] | None,
        option("A set of robots: quadrupeds, bipeds or all.", "--set", group=ROBOTS, metavar="SET"),
    ] = None,
    jobs: Annotated[
        int | None,
        option("Processes that compute at the same time; 1 by default.", group=ROBOTS, metavar="N", parser=positive_count),
    ] = None,
    options: Annotated[SceneOptions, without("set")],
    format_: Annotated[
        Literal["table", "json", "csv", "markdown"],
        option("What is printed; table by default.", "--format", group=OUTPUT),
    ] = "table",
    out: Annotated[
        Path | None, option("Write CSV, JSON and a report into this folder.", group=OUTPUT, metavar="DIR", parser=path)
    ] = None,
    figures: Annotated[
        bool, option("Also draw all landings on one contact sheet in that folder.", "--figures", group=OUTPUT)
    ] = False,
) -> None:
    """Land many robots on each of their feet, and rank the landings.

    Each robot stands in its standing posture and falls straight down at 1 m/s, unless options say otherwise. With --contact, only
    matching feet strike; a scene lands as it says. Ends with exit code 3 if some landings cannot be computed.
    """
    from shockpc.cli.output import give
    from shockpc.cli.progress import progress
    from shockpc.errors import StudyError
    from shockpc.executor import executor
    from shockpc.robot.catalogue import robots_of_set
    from shockpc.show.files import check_folder
    from shockpc.show.reports.batch import batch_report
    from shockpc.studies import batch as study

    names = list(dict.fromkeys([*(robots or ()), *(name for one in set_ or () for name in robots_of_set(one))]))
    if not names:
        raise StudyError("no robot is named; give names or files, or a set: shockpc batch --set quadrupeds")
    if figures and out is None:
        raise StudyError("--figures needs a folder to write to; give one with --out")
    if out is not None:
        check_folder(out, "--out")
    with executor(min(jobs or 1, len(names))) as pool:
        read = functools.partial(_landings, options)
        found = study.batch(names, read, pool, _thumbnail if figures else None, progress("robots computed", len(names)))
    give(batch_report(found), format_, out)
    if found.failures:
        raise typer.Exit(INCOMPLETE)


def _landings(options: SceneOptions, name: str) -> "tuple[Robot, list[Scene]]":
    """A robot and its landings, as the options say."""
    from shockpc.cli.scenes import scenes_from
    from shockpc.trace import Trace

    return scenes_from(name, options, Trace(), on_each_foot=True)


def _thumbnail(profile: "ShockProfile") -> "Thumbnail":
    """The small picture of a landing."""
    from shockpc.show.figure.contact_sheet import thumbnail

    return thumbnail(profile)
