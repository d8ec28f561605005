"""`shockpc place`: where on a body a sensor sees least shock."""

from typing import TYPE_CHECKING, Literal

from shockpc.cli.declare import argument, command, group
from shockpc.cli.options import STRICT, OutputOptions, SceneOptions
from shockpc.cli.parse import Setting, Variable, Vector, box, finite, robot_name, setting, variable

if TYPE_CHECKING:
    from shockpc.landing.scene import Scene


_in_landings, _in_region, _in_sensors = group("Landings"), group("Where a sensor may be"), group("Sensors")


@command(
    "Find where on a body a sensor sees least shock.",
    "shockpc place anymal_b --vary strike-angle=-30:75:4",
    more=(
        "A robot without --contact lands on each of its feet alone. What counts is the greatest shock over all "
        "landings. The optimum over the body is exact, with its gap stated; the shock at the places is proven. With "
        "--pulse and --range-g, also how much of a sensor's range is left along each axis, and how to turn it."
    ),
)
def place(
    *,
    scenes: tuple[str, ...] = argument(
        "Scenes (TOML), or a robot, which lands on each foot alone.", "SCENE...", robot_name, default=...
    ),
    options: SceneOptions,
    vary: tuple[Variable, ...] = _in_landings(
        "Each landing with all of these values, a:b:n or a,b,c: of strike-angle [deg], speed [m/s], base-pitch [deg], joints "
        "by name or glob [deg; m if prismatic], and what else of a landing a sweep varies.",
        "NAME=VALUES",
        variable,
    ),
    weight: tuple[Setting, ...] = _in_landings(
        "Compare places by the weighted mean over the landings, not by the greatest shock: the weight of landings by name or "
        "glob; others weigh 1.",
        "LANDING=WEIGHT",
        setting,
    ),
    body: str | None = _in_region("The body; the base by default.", "BODY"),
    within: tuple[Vector, Vector] | None = _in_region(
        "Only in this box of the body's frame, whatever the geometry [m].", "X0:X1,Y0:Y1,Z0:Z1", box
    ),
    surface: bool = _in_region("Only on the surface of the geometry (within the box, if one is given)."),
    geometry: Literal["collision", "visual"] | None = _in_region(
        "Which geometry; visual by default for its surface, else collision."
    ),
    count: int = _in_sensors(
        "Number of sensors that belong together: in each landing the one with the least shock counts.", "N", default=1
    ),
    alternatives: int = _in_sensors("Number of further places, each the best at a distance; 2 by default.", "N", default=2),
    apart: float | None = _in_sensors(
        "This distance, along x, y or z of the body; a tenth of the body by default [m].", "D", finite
    ),
    strict: bool = _in_landings(STRICT),
    output: OutputOptions,
) -> int:
    from shockpc.cli.output import emit, exit_code
    from shockpc.cli.progress import progress
    from shockpc.cli.scenes import landings_from
    from shockpc.evaluation.varied_scene import scene_grid
    from shockpc.show.reports.place import place_report
    from shockpc.studies.place.study import place as study
    from shockpc.text.errors import DefectError

    landings: dict[str, Scene] = {}
    for name, (robot, scene) in landings_from(scenes, options).items():
        landings |= scene_grid(name, scene, robot, vary)
    result = study(
        landings,
        body=body,
        within=within,
        surface=surface,
        geometry=geometry,
        weights=dict(weight) or None,
        count=count,
        alternatives=alternatives,
        apart=apart,
        progress=progress("landings computed", len(landings)),
    )
    emit(place_report(result), output)
    defects = [failure.trace for _, failure in result.failures if isinstance(failure, DefectError)]
    return exit_code(len(result.failures), len(landings), strict, defects)
