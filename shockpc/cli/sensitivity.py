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
    import json

    from shockpc.cli.output import check_places
    from shockpc.cli.progress import ShownTrace
    from shockpc.cli.scenes import one_scene, point_from
    from shockpc.show.sensitivity import (
        effects_sheet,
        sensitivity_document,
        sensitivity_report,
        sensitivity_text,
        write_sensitivity,
    )
    from shockpc.show.tables.text import as_csv
    from shockpc.studies.sensitivity import sensitivity as study

    trace = ShownTrace()
    check_places(out, None)
    loaded, scene = one_scene(robot, options, trace)
    found = study(scene, point_from(loaded, at, "--at"), loaded, trace)
    if out is not None:
        with trace.stage("files and figure"):
            write_sensitivity(found, out)
    if format_ == "json":
        text = json.dumps(sensitivity_document(found), indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    elif format_ == "csv":
        text = as_csv(effects_sheet(found))
    else:
        text = sensitivity_report(found) if format_ == "markdown" else sensitivity_text(found, max(most, 1))
    sys.stdout.write(text)
    if explain:
        sys.stderr.write(trace.text())
