"""`shockpc compare`: designs side by side."""

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from shockpc.cli.declare import option, takes_options
from shockpc.cli.options import SceneOptions
from shockpc.cli.parse import path, robot_name

if TYPE_CHECKING:
    from shockpc.studies.compare import Design

__all__ = ["compare"]

DESIGNS, OUTPUT = "Designs", "Output"


@takes_options
def compare(
    *,
    designs: Annotated[
        list[str],
        typer.Argument(metavar="DESIGN...", help="Robot files, robots by name or scenes (TOML).", parser=robot_name),
    ],
    change: Annotated[
        list[str] | None,
        option(
            "A change of the one design, such as 'mass:*_shank=0.9x; armature:*=0.01', which makes another design; "
            "mass, inertia (a factor), com-x, com-y, com-z (moved by) of links, armature of joints.",
            group=DESIGNS,
            metavar="CHANGES",
        ),
    ] = None,
    options: SceneOptions,
    format_: Annotated[
        Literal["table", "json", "csv", "markdown"],
        option("What is printed; table by default.", "--format", group=OUTPUT),
    ] = "table",
    out: Annotated[
        Path | None, option("Write CSV, JSON, a report and the figure into this folder.", group=OUTPUT, metavar="DIR", parser=path)
    ] = None,
) -> None:
    """Compare the shock of designs, or of one design and its changes.

    The options of the landing hold for every design. One --contact is for all; with as many as there are designs, each has its own.
    """
    from shockpc.cli.output import give
    from shockpc.errors import StudyError
    from shockpc.robot.changes import read_changes
    from shockpc.show.files import check_folder
    from shockpc.show.reports.compare import compare_report
    from shockpc.studies.compare import compare as study
    from shockpc.studies.compare import design_with

    if out is not None:
        check_folder(out, "--out")
    if change and len(designs) > 1:
        raise StudyError("--change makes other designs of one, but several are given; give one design, or a file for each")
    changes = [read_changes(text) for text in change or ()]
    own = options.contact if len(options.contact) == len(designs) > 1 and not options.together else None
    every = [
        _design(name, options if own is None else dataclasses.replace(options, contact=[own[k]])) for k, name in enumerate(designs)
    ]
    every += [design_with(every[0], one) for one in changes]
    give(compare_report(study(every)), format_, out)


def _design(name: str, options: SceneOptions) -> "Design":
    """The design of a name, in its landing."""
    from shockpc.cli.scenes import scenes_from
    from shockpc.errors import StudyError
    from shockpc.studies.compare import Design
    from shockpc.trace import Trace

    robot, scenes = scenes_from(name, options, Trace())
    if len(scenes) > 1:
        listed = ", ".join("+".join(contact.frame for contact in scene.contact) for scene in scenes)
        raise StudyError(f'"{name}" is given {len(scenes)} landings ({listed}); compare one of each design: name one --contact')
    return Design(name, scenes[0], robot)
