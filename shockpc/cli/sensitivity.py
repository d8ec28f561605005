"""`shockpc sensitivity`: what changes a number of a landing, and by how much."""

import sys

from shockpc.cli.declare import command, group
from shockpc.cli.options import EXPLAIN, FRAME, ROBOT, TARGET, OutputOptions, SceneOptions, in_output, target_of

_in_question = group("Question")


@command(
    "Rank masses, inertias and angles by their effect on a number.",
    "shockpc sensitivity anymal_b --contact LF_FOOT --at imu_link",
    "shockpc sensitivity anymal_b --contact LF_FOOT --quantity joint_impulse@LF_KFE",
)
def sensitivity(
    *,
    robot: str = ROBOT,
    at_: str | None = _in_question("The shock at this point, offset in the frame [m].", FRAME),
    quantity: str | None = TARGET,
    options: SceneOptions,
    rows: int = in_output("Rows of the table; 16 by default.", "N", least=1, default=16),
    output: OutputOptions,
    explain: bool = EXPLAIN,
) -> None:
    from shockpc.cli.output import emit
    from shockpc.cli.progress import ShownTrace
    from shockpc.cli.scenes import one_scene
    from shockpc.show.reports.sensitivity import sensitivity_report
    from shockpc.studies.sensitivity import sensitivity as study

    trace = ShownTrace()
    loaded, scene = one_scene(robot, options, trace)
    result = study(scene, target_of(at_, quantity), loaded, trace)
    with trace.stage("output"):
        emit(sensitivity_report(result, rows), output)
    if explain:
        sys.stderr.write(trace.text())
