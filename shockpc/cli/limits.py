"""`shockpc limits`: joint limits that keep a number below a bound."""

import math

from shockpc.cli.declare import command, group
from shockpc.cli.options import FRAME, ROBOT, TARGET, OutputOptions, SceneOptions, target_of
from shockpc.cli.parse import Span, finite, span

_in_question = group("Question")


@command(
    "Find the joint angles that keep the shock, or another number, below or above a bound.",
    "shockpc limits hyq --contact lf_foot --joint lf_kfe_joint --at trunk_imu --max 0.1",
    "shockpc limits hyq --contact lf_foot --joint lf_kfe_joint --quantity friction_needed@lf_foot --max 0.6",
)
def limits(
    *,
    robot: str = ROBOT,
    joint: str = _in_question(
        "The joint, by name; joints that a glob matches all have the same value. Or what else sweep varies, with --range.", "JOINT"
    ),
    at_: str | None = _in_question("The shock at this point, offset in the frame [m].", FRAME),
    quantity: str | None = TARGET,
    max_: float | None = _in_question("The bound, in the unit of the number: the greatest value allowed.", "VALUE", finite),
    min_: float | None = _in_question("The least value allowed, of a number of which less is worse: a margin.", "VALUE", finite),
    range_: Span | None = _in_question(
        "Values of the joint to look at; the file's limits by default, at most a turn [deg; m if prismatic].", "LOW:HIGH", span
    ),
    strikes: Span | None = _in_question(
        "Strike angles to look at; -30:75 by default, the scene's for a quantity of one posture at a time [deg].", "LOW:HIGH", span
    ),
    step: float | None = _in_question(
        "Largest step of the scan; 0.1 deg or 0.0001 m by default, 20 times that for a quantity of one posture at a time "
        "[deg; m if prismatic].",
        "STEP",
        finite,
    ),
    options: SceneOptions,
    output: OutputOptions,
) -> None:
    from shockpc.cli.output import emit
    from shockpc.cli.scenes import one_scene
    from shockpc.evaluation.variation import ATTITUDE, kind_of
    from shockpc.show.reports.limits import limits_report
    from shockpc.studies.limits import limits as study

    loaded, scene = one_scene(robot, options)
    kind, pattern = kind_of(loaded, joint)
    turns = kind in ATTITUDE or (kind == "joint" and loaded.joint(loaded.match_joints(pattern)[0]).kind != "prismatic")
    unit = math.radians(1.0) if turns else 1.0
    result = study(
        scene,
        joint,
        target_of(at_, quantity),
        max_,
        min=min_,
        joint_range=None if range_ is None else (unit * range_[0], unit * range_[1]),
        strikes=None if strikes is None else (math.radians(strikes[0]), math.radians(strikes[1])),
        step=None if step is None else unit * step,
        robot=loaded,
    )
    emit(limits_report(result), output)
