"""`shockpc sensitivity`: what changes a number of some landings, and by how much."""

import sys

from shockpc.cli.declare import argument, command, group
from shockpc.cli.options import EXPLAIN, FRAME, TARGET, OutputOptions, SceneOptions, in_output, target_of
from shockpc.cli.parse import Variable, finite, robot_name, variable

_in_question, _in_changes = group("Question"), group("Changes")


@command(
    "Rank masses, inertias and angles by their effect on a number.",
    "shockpc sensitivity anymal_b --contact LF_FOOT --at imu_link",
    "shockpc sensitivity go2 --at imu --group '*_thigh' --group '*_calf'",
    "shockpc sensitivity anymal_b --quantity joint_impulse@LF_KFE --vary 'mass:*_SHANK=0.8x:1.2x' --vary LF_KFE=-80:-40",
    more=(
        "A robot without --contact lands on each of its feet alone. What counts is the worst landing, or with --mean the mean of"
        " all. Every parameter is changed by the same share of its size; with --vary only those that are named, each by that"
        " share of its range."
    ),
)
def sensitivity(
    *,
    scenes: tuple[str, ...] = argument(
        "Scenes (TOML), or a robot, which lands on each foot alone.", "SCENE...", robot_name, default=...
    ),
    at_: str | None = _in_question("The shock at this point, offset in the frame [m].", FRAME),
    quantity: str | None = TARGET,
    mean: bool = _in_question("The mean over the landings, not the worst of them."),
    group_: tuple[str, ...] = _in_changes(
        "Bodies and joints, such as the left and right legs, whose values change together by one factor.", "NAME"
    ),
    vary: tuple[Variable, ...] = _in_changes(
        "Change only these, over these ranges (a:b, factors ax:bx, m±s): mass:LINK, com-z:LINK, inertia:LINK, armature:JOINT, "
        "strike-angle, or joints [deg; m if prismatic].",
        "NAME=RANGE",
        variable,
    ),
    percent: float = _in_changes("How far, in per cent of the range or of the size; 1 by default.", "P", finite, default=1.0),
    options: SceneOptions,
    rows: int = in_output("Rows of the table; 16 by default.", "N", least=1, default=16),
    output: OutputOptions,
    explain: bool = EXPLAIN,
) -> None:
    from shockpc.cli.output import emit
    from shockpc.cli.progress import ShownTrace
    from shockpc.cli.scenes import landings_from
    from shockpc.show.reports.sensitivity import sensitivity_report
    from shockpc.studies.sensitivity import sensitivity as study

    trace = ShownTrace()
    target = target_of(at_, quantity)
    landings = {name: scene for name, (_, scene) in landings_from(scenes, options, trace).items()}
    result = study(landings, target, mean=mean, groups=group_, vary=vary, percent=percent, trace=trace)
    with trace.stage("output"):
        emit(sensitivity_report(result, rows), output)
    if explain:
        sys.stderr.write(trace.text())
