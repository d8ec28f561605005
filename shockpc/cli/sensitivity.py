"""`shockpc sensitivity`: what changes the shock at a point, and by how much."""

import sys
from typing import Annotated

from shockpc.cli.declare import group, takes_options
from shockpc.cli.options import OutputOptions, RobotName, SceneOptions, in_output

__all__ = ["sensitivity"]


@takes_options
def sensitivity(
    *,
    robot: RobotName,
    at: Annotated[str, group("Question")("The point, offset in the frame [m].", "FRAME[:X,Y,Z]")],
    options: SceneOptions,
    rows: Annotated[int, in_output("Rows of the table; 16 by default.", "N", least=1)] = 16,
    output: OutputOptions,
    explain: Annotated[bool, in_output("Report on standard error what ran, how long it took, and what was not needed.")] = False,
) -> None:
    """Rank masses, inertias and angles by effect on the shock."""
    import json

    from shockpc.cli.output import check_out
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
    from shockpc.trace import Trace

    trace = Trace()
    check_out(output.out)
    loaded, scene = one_scene(robot, options, trace)
    found = study(scene, point_from(loaded, at, "--at"), loaded, trace)
    if output.out is not None:
        with trace.stage("files and figure"):
            write_sensitivity(found, output.out)
    if output.format == "json":
        text = json.dumps(sensitivity_document(found), indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    elif output.format == "csv":
        text = as_csv(effects_sheet(found))
    else:
        text = sensitivity_report(found) if output.format == "markdown" else sensitivity_text(found, rows)
    sys.stdout.write(text)
    if explain:
        sys.stderr.write(trace.text())
