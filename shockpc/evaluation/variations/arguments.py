"""The landings of a study from its arguments, checked."""

import math
from dataclasses import replace

from shockpc.evaluation.variations.kinds.posture import JOINT_POSITION, motion_range
from shockpc.evaluation.variations.rows import VariedLandings
from shockpc.evaluation.variations.variation import Variation
from shockpc.evaluation.variations.vary import Vary, each_of, pairs, refuse_repeated, variation
from shockpc.landing.scenes.scene import Scene
from shockpc.landing.scenes.scene_file import check_scene, robot_of
from shockpc.robot.robot import Robot
from shockpc.text.errors import StudyError

MOST_ROWS = 10**8
"""Rows of a sweep: so many take an hour, and a column of them 0.8 GB."""


def varied_landings(
    scene: Scene,
    vary: Vary = (),
    *,
    robot: Robot | None = None,
    vary_each: Vary = (),
    sample: int | None = None,
    lhs: bool = False,
    seed: int = 0,
    keep_joints: bool = False,
) -> VariedLandings:
    """Landings that differ from one, checked.

    Args:
        scene: the landing that is varied.
        vary: values by subject, as in `variation`: {"*_KFE": "-120:-10:200", "strike-angle": [0,
            15, 30]}.
        robot: the scene's robot, if it is loaded already.
        vary_each: the same, with a separate quantity for each joint or link that a pattern matches.
        sample: number of random rows instead of the full grid. If neither a joint nor what the
            robot and the ground are is varied, all joints are, within their limits.
        lhs: whether the sample is a Latin hypercube.
        seed: of the random numbers.
        keep_joints: whether joints that are not varied stay where the scene has them in any sample.

    Raises:
        ShockError: a name is not known, values do not fit, nothing varies, or the landing cannot be
            resolved.
    """
    robot = robot or robot_of(scene)
    variations = _read_variations(robot, vary, vary_each)
    if lhs and sample is None:
        raise StudyError("a Latin hypercube is a sample; give its number of rows with --sample")
    stated = any(
        varied.uncertain or varied.kind.settable(robot, varied.target) for varied in variations
    )
    if sample is not None and not keep_joints and not stated:
        variations += [
            JOINT_POSITION.read(robot, f"joint:{joint.name}", joint.name, None)
            for joint in robot.independent_joints
        ]
    if not variations:
        raise StudyError(
            "nothing varies; name a joint or another quantity with --vary, or draw random "
            "postures with --sample"
        )
    # Without values each joint has its own range.
    single: list[Variation] = []
    for varied in variations:
        has_values = varied.values or varied.span
        single += [varied] if has_values else each_of(robot, varied)
    variations = [_complete(robot, varied, sample is not None) for varied in single]
    refuse_repeated(robot, variations)
    scene = check_scene(scene)
    for varied in variations:
        varied.kind.refuse_scene(scene)
    source = VariedLandings(scene, robot, tuple(variations), sample, lhs, seed)
    if source.rows > MOST_ROWS:
        raise StudyError(
            f"{source.rows:.4g} landings are more than {MOST_ROWS:.0e}; give fewer values, or "
            "draw a sample with --sample"
        )
    for varied in source.axes:
        varied.kind.check_landing(varied, scene, robot)
    return source


def _read_variations(robot: Robot, vary: Vary, vary_each: Vary) -> list[Variation]:
    """The variations, those of `vary_each` one by one."""
    # Pairs may repeat a subject, which is refused later; a mapping cannot.
    together, separately = pairs(vary), pairs(vary_each)
    variations = [variation(robot, subject, values) for subject, values in together]
    for subject, values in separately:
        variations += each_of(robot, variation(robot, subject, values))
    return variations


def _complete(robot: Robot, varied: Variation, sample: bool) -> Variation:
    """A variation with the range of its joint, if it was given no values."""
    if not varied.values and varied.span is None:
        joint = robot.joint(varied.target)
        low, high = motion_range([joint])
        if varied.unit != "m":
            low, high = math.degrees(low), math.degrees(high)
        if not high > low or not math.isfinite(high - low):
            raise StudyError(
                f'joint "{joint.name}" has no range of motion in the robot file; give values, '
                f"such as {joint.name}=0:0.1:5"
            )
        varied = replace(varied, subject=joint.name, span=(low, high))
    if not sample and varied.span is not None:
        raise StudyError(
            f"{varied.subject}: a range is drawn from by --sample N; for a grid give the number "
            f"of values too, such as {varied.span[0]:g}:{varied.span[1]:g}:10"
        )
    return varied
