"""`shockpc sensitivity`: what changes the shock at a point, and by how much."""

import sys

from shockpc.cli.declare import command, group
from shockpc.cli.options import EXPLAIN, FRAME, ROBOT, OutputOptions, SceneOptions, in_output

__all__ = ["sensitivity"]


@command(
    "Rank masses, inertias and angles by effect on the shock.",
    "shockpc sensitivity anymal_b --contact LF_FOOT --at imu_link",
)
def sensitivity(
    *,
    robot: str = ROBOT,
    at_: str = group("Question")("The point, offset in the frame [m].", FRAME),
    options: SceneOptions,
    rows: int = in_output("Rows of the table; 16 by default.", "N", least=1, default=16),
    output: OutputOptions,
    explain: bool = EXPLAIN,
) -> None:
    from shockpc.cli.output import give
    from shockpc.cli.progress import ShownTrace
    from shockpc.cli.scenes import one_scene
    from shockpc.scene import point_at
    from shockpc.show.reports.sensitivity import sensitivity_report
    from shockpc.studies.sensitivity import sensitivity as study

    trace = ShownTrace()
    loaded, scene = one_scene(robot, options, trace)
    found = study(scene, point_at(loaded, at_), loaded, trace)
    with trace.stage("output"):
        give(sensitivity_report(found, rows), output)
    if explain:
        sys.stderr.write(trace.text())
