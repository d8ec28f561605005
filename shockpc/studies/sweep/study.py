"""The checked arguments of a sweep, and its computation in parts.

They say what varies, over a full grid or in a sample.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Annotated

from shockpc.evaluation.declare import QuantityOption, study
from shockpc.evaluation.evaluate import Evaluation
from shockpc.evaluation.variations.arguments import MOST_ROWS, varied_landings
from shockpc.evaluation.variations.rows import VariedLandings
from shockpc.evaluation.variations.vary import Vary
from shockpc.landing.scenes.scene import Point, Scene
from shockpc.landing.scenes.scene_fields import Option
from shockpc.landing.scenes.scene_file import scene_of
from shockpc.robot.robot import Robot
from shockpc.studies.sweep.columns import sweep_columns


@study(
    'shockpc sweep anymal_b --contact LF_FOOT --vary "*_KFE=-120:-10:50" --at imu_link --out '
    "sweep/",
    'shockpc sweep anymal_b --contact LF_FOOT --sample 100 --quantity "joint_impulse@*_KFE" --out '
    "random/",
    'shockpc sweep go2 --contact FL_foot --sample 10000 --vary-each "mass:*_calf=±5%" --out '
    "masses/",
)
def sweep(
    scene: Scene | str,
    vary: Annotated[
        Vary,
        Option(
            "A name and its values: a:b:n, a list a,b,c or, with --sample, a range a:b, a:b:log or "
            "m±s (normal). Names are "
            "joints or globs [deg; m if prismatic], strike-angle, speed, friction, mass:LINKS and "
            "others; shockpc guide vary "
            "lists them.",
            "What varies",
            "NAME=VALUES",
            holds="varied",
        ),
    ] = (),
    *,
    robot: Robot | None = None,
    vary_each: Annotated[
        Vary,
        Option(
            "Like --vary, but each joint or link that matches the glob varies separately.",
            "What varies",
            "GLOB=VALUES",
        ),
    ] = (),
    sample: Annotated[
        int | None,
        Option(
            "Random landings instead of the grid. If no joint, robot or ground property is varied, "
            "all joints are, within limits.",
            "What varies",
            "N",
            least=1.0,
            greatest=MOST_ROWS,
        ),
    ] = None,
    lhs: Annotated[bool, Option("Draw the sample as a Latin hypercube.", "What varies")] = False,
    seed: Annotated[
        int, Option("Seed of the random numbers.", "What varies", "N", least=0.0, greatest=1e15)
    ] = 0,
    at: Sequence[Point | str] = (),
    bodies: Annotated[
        Sequence[str],
        Option(
            "Bodies whose CoPc, RoPc and shock at the CoM are computed; the base, if there is no "
            "--at either.",
            "What is computed",
            "BODY",
            "body",
        ),
    ] = (),
    quantities: QuantityOption = (),
    feasible: Annotated[
        bool,
        Option(
            "Keep only landings that are possible on flat ground: the ground never pulls, no other "
            "link touches first, and no "
            "energy is gained (with --friction contacts slide and open instead). Landings on some "
            "of the level feet are kept.",
            "What is computed",
        ),
    ] = False,
    prove: Annotated[
        int,
        Option(
            "Random landings that are checked in exact arithmetic.",
            "What is computed",
            "N",
            least=0.0,
            greatest=1e6,
        ),
    ] = 100,
) -> Evaluation[VariedLandings]:
    """Many landings that differ from one, checked.

    They are computed part by part as the result is iterated over, or at once by `table`.

    Args:
        scene: the landing that is varied.
        robot: the scene's robot, if it is loaded already.
        at: points, as `Point` or names of frames.

    Raises:
        ShockError: a name is not known, values do not fit, nothing varies, or the landing cannot be
            resolved. A row that cannot be computed is no error: its message is in the table.
    """
    points = []
    for point in at:
        if isinstance(point, str):
            point = Point(frame=point)
        points.append(point)
    source = varied_landings(
        replace(scene_of(scene), point=tuple(points)),
        vary,
        robot=robot,
        vary_each=vary_each,
        sample=sample,
        lhs=lhs,
        seed=seed,
    )
    columns = sweep_columns(source, points, bodies, quantities)
    return Evaluation(source, columns, prove, feasible)
