"""`shockpc sensitivity`: what changes the shock at a point, and by how much."""

import sys
from pathlib import Path
from typing import Annotated, Literal

from shockpc.cli.declare import option, takes_options
from shockpc.cli.options import RobotName, SceneOptions
from shockpc.cli.parse import path

__all__ = ["sensitivity"]

OUTPUT = "Output"


@takes_options
def sensitivity(
    *,
    robot: RobotName,
    at: Annotated[str, option("The point, offset in the frame [m].", group="Question", metavar="FRAME[:X,Y,Z]")],
    options: SceneOptions,
    most: Annotated[int, option("Rows of the table; 16 by default.", "--rows", group=OUTPUT, metavar="N")] = 16,
    format_: Annotated[
        Literal["table", "json", "csv", "markdown"], option("What is printed; table by default.", "--format", group=OUTPUT)
    ] = "table",
    out: Annotated[
        Path | None, option("Write JSON, CSV, a report and the chart into this folder.", group=OUTPUT, metavar="DIR", parser=path)
    ] = None,
    explain: Annotated[
        bool,
        option("Report on standard error what ran, how long it took, and what was not needed.", "--explain", group=OUTPUT),
    ] = False,
) -> None:
    """Compute how masses, inertias, joint angles and the strike change the shock."""
    from shockpc.cli.output import check_places, give
    from shockpc.cli.scenes import one_scene, point_from
    from shockpc.show.reports.sensitivity import sensitivity_report
    from shockpc.studies.sensitivity import sensitivity as study
    from shockpc.trace import Trace

    trace = Trace()
    check_places(out, None)
    loaded, scene = one_scene(robot, options, trace)
    found = study(scene, point_from(loaded, at, "--at"), loaded, trace)
    with trace.stage("output"):
        give(sensitivity_report(found, max(most, 1)), format_, out)
    if explain:
        sys.stderr.write(trace.text())
