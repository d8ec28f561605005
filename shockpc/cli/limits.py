"""`shockpc limits`: joint limits that keep the shock at a point below a bound."""

import math
from pathlib import Path
from typing import Annotated, Literal

from shockpc.cli.declare import option, takes_options
from shockpc.cli.options import RobotName, SceneOptions
from shockpc.cli.parse import Span, finite, path, span

__all__ = ["limits"]

QUESTION, OUTPUT = "Question", "Output"


@takes_options
def limits(
    *,
    robot: RobotName,
    joint: Annotated[
        str, option("The joint, by name; joints that a glob matches all have the same value.", group=QUESTION, metavar="JOINT")
    ],
    at: Annotated[str, option("Where the shock is limited, offset in the frame [m].", group=QUESTION, metavar="FRAME[:X,Y,Z]")],
    max_shock: Annotated[float, option("The bound: |Δv| relative to the strike.", group=QUESTION, metavar="SHOCK", parser=finite)],
    joint_range: Annotated[
        Span | None,
        option(
            "Values of the joint to look at; the file's limits by default [deg; m if prismatic].",
            "--range",
            group=QUESTION,
            metavar="LOW:HIGH",
            parser=span("-150:0"),
        ),
    ] = None,
    strikes: Annotated[
        Span | None,
        option("Strike angles to look at; -30:75 by default [deg].", group=QUESTION, metavar="LOW:HIGH", parser=span("-30:75")),
    ] = None,
    step: Annotated[
        float | None,
        option(
            "Largest step of the scan; 0.1 deg or 0.0001 m by default [deg; m if prismatic].",
            group=QUESTION,
            metavar="STEP",
            parser=finite,
        ),
    ] = None,
    options: SceneOptions,
    format_: Annotated[
        Literal["table", "json", "csv", "markdown"], option("What is printed; table by default.", "--format", group=OUTPUT)
    ] = "table",
    out: Annotated[
        Path | None, option("Write JSON, CSV, a report and the map into this folder.", group=OUTPUT, metavar="DIR", parser=path)
    ] = None,
) -> None:
    """Find the values of a joint that keep the shock at a point below a bound."""
    from shockpc.cli.output import check_places, give
    from shockpc.cli.scenes import one_scene, point_from
    from shockpc.show.reports.limits import limits_report
    from shockpc.studies.limits import limits as study
    from shockpc.trace import Trace

    check_places(out, None)
    loaded, scene = one_scene(robot, options, Trace())
    joints = [loaded.joint(name) for name in loaded.match_joints(joint)]
    unit = 1.0 if joints[0].kind == "prismatic" else math.radians(1.0)
    found = study(
        scene,
        joint,
        point_from(loaded, at, "--at"),
        max_shock,
        joint_range=None if joint_range is None else (unit * joint_range.low, unit * joint_range.high),
        strikes=None if strikes is None else (math.radians(strikes.low), math.radians(strikes.high)),
        step=None if step is None else unit * step,
        robot=loaded,
    )
    give(limits_report(found), format_, out)
