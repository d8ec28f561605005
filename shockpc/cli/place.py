"""`shockpc place`: where on a body a sensor sees least shock."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from shockpc.cli.declare import option, takes_options
from shockpc.cli.options import SceneOptions
from shockpc.cli.parse import Setting, finite, limits, path, robot_name, setting
from shockpc.cli.vary import Varied, varied

if TYPE_CHECKING:
    from shockpc.robot.robot import Robot
    from shockpc.scene import Scene

__all__ = ["place"]

LANDINGS, REGION, SENSORS, OUTPUT = "Landings", "Where a sensor may be", "Sensors", "Output"

INCOMPLETE = 3
"""Exit code if some landings could not be computed."""


@takes_options
def place(
    scenes: Annotated[
        list[str],
        typer.Argument(metavar="SCENE...", help="Scenes (TOML), or a robot, which lands on each foot alone.", parser=robot_name),
    ],
    options: SceneOptions,
    vary: Annotated[
        list[Varied] | None,
        option(
            "Each landing with all of these values: of strike-angle [deg], speed [m/s], or joints by name or glob [deg; m]. "
            "FIRST:LAST:NUMBER, or values with commas between them.",
            group=LANDINGS,
            metavar="SUBJECT=VALUES",
            parser=varied,
        ),
    ] = None,
    weight: Annotated[
        list[Setting] | None,
        option(
            "Compare places by the weighted mean over the landings, not by the greatest shock: the weight of landings by glob or "
            "part of their name; others weigh 1.",
            group=LANDINGS,
            metavar="LANDING=WEIGHT",
            parser=setting("LANDING=WEIGHT", "'LF_*=3'"),
        ),
    ] = None,
    body: Annotated[
        str | None, option("The body, or a link that is fixed to it; the base by default.", group=REGION, metavar="NAME")
    ] = None,
    within: Annotated[
        Any,
        option("Only in this box of the body's frame, whatever the geometry [m].", group=REGION, metavar="BOX", parser=limits),
    ] = None,
    surface: Annotated[
        bool, option("Only on the surface of the geometry (within the box, if one is given).", "--surface", group=REGION)
    ] = False,
    geometry: Annotated[
        Literal["collision", "visual"], option("Which geometry; collision by default.", group=REGION)
    ] = "collision",
    count: Annotated[
        int,
        option(
            "Number of sensors that belong together: in each landing the one with the least shock counts.",
            group=SENSORS,
            metavar="N",
        ),
    ] = 1,
    alternatives: Annotated[
        int,
        option("Number of further places, each the best at a distance; 2 by default.", group=SENSORS, metavar="N"),
    ] = 2,
    apart: Annotated[
        float | None,
        option(
            "This distance, along x, y or z of the body; a tenth of the body by default [m].",
            group=SENSORS,
            metavar="D",
            parser=finite,
        ),
    ] = None,
    format_: Annotated[
        Literal["table", "json", "csv", "markdown"], option("What is printed; table by default.", "--format", group=OUTPUT)
    ] = "table",
    out: Annotated[
        Path | None, option("Write JSON, CSV, a report and the figure into this folder.", group=OUTPUT, metavar="DIR", parser=path)
    ] = None,
) -> None:
    """Find where on a body a sensor sees least shock.

    A robot without --contact lands on each of its feet alone. What counts is the greatest shock over all landings. The optimum over
    the body is exact, with its gap stated; the shock at the places is proven. With --pulse and --range-g, also how much of a
    sensor's range is left along each axis, and how to turn it.
    """
    from shockpc.cli.output import give
    from shockpc.cli.progress import progress
    from shockpc.show.files import check_folder
    from shockpc.show.reports.place import place_report
    from shockpc.studies.place.study import place as study

    if out is not None:
        check_folder(out, "--out")
    robot, landings = _landings(scenes, options, vary or [])
    found = study(
        landings,
        robot,
        body=body,
        within=within,
        surface=surface,
        geometry=geometry,
        weights=_weights(list(landings), weight or []),
        count=count,
        alternatives=alternatives,
        apart=apart,
        progress=progress("landings computed", len(landings)),
    )
    give(place_report(found), format_, out)
    if found.failures:
        raise typer.Exit(INCOMPLETE)


def _landings(names: list[str], options: SceneOptions, vary: list[Varied]) -> "tuple[Robot, dict[str, Scene]]":
    """The robot, and all landings by name."""
    from shockpc.cli.output import file_names
    from shockpc.cli.scenes import is_scene_file, scenes_from
    from shockpc.cli.vary import varied_scenes
    from shockpc.trace import Trace

    landings: dict[str, Scene] = {}
    robots: list[Robot] = []
    for name in dict.fromkeys(names):
        robot, scenes = scenes_from(name, options, Trace(), on_each_foot=True)
        robots.append(robot)
        prefix = f"{Path(name).stem} " if is_scene_file(name) and len(names) > 1 else ""
        for scene, contact in zip(scenes, file_names(scenes), strict=True):
            landings |= varied_scenes(prefix + contact, scene, vary)
    return robots[0], landings


def _weights(landings: list[str], given: list[Setting]) -> dict[str, float] | None:
    """The weights of landings by name; a later one replaces an earlier one. None if there are none."""
    from shockpc.errors import UnknownName
    from shockpc.show.tables.sheets import fits

    weights: dict[str, float] = {}
    for pattern, value in given:
        matches = [name for name in landings if fits(name, pattern)]
        if not matches:
            raise UnknownName("landing", pattern, landings, "", "leave out --weight; the table names them")
        weights |= dict.fromkeys(matches, value)
    return weights if given else None
