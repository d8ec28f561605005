"""The posture, strike or design with the smallest worst value of a number over some landings.

It is within ranges and constraints.
"""

import fnmatch
import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Annotated

import numpy as np

from shockpc.evaluation.cost import ShockCost
from shockpc.evaluation.declare import study
from shockpc.evaluation.drive_ends import at_drive_ends
from shockpc.evaluation.named_scenes import common_robot, named_scenes, with_default_landings
from shockpc.evaluation.profiles import profiles
from shockpc.evaluation.variations.kinds.posture import motion_range
from shockpc.evaluation.variations.scene_grid import scene_grid
from shockpc.evaluation.variations.vary import Vary, pairs
from shockpc.landing.resolve import landing_of, resolve
from shockpc.landing.scenes.scene import Scene
from shockpc.landing.scenes.scene_fields import Option
from shockpc.robot.feet_and_sensors import is_imu, sensors
from shockpc.robot.robot import Robot
from shockpc.studies.improve.improvement import DriveEnd, Improvement
from shockpc.studies.improve.optimum import drive_end, improvement_of
from shockpc.studies.improve.search import (
    ROUGH,
    RUNS,
    SLOW,
    Run,
    search,
    starting_points,
)
from shockpc.text.errors import StudyError
from shockpc.text.printed import few
from shockpc.text.trace import Trace

USUAL_RANGE = 45.0
"""Default distance of the ranges of joints from the landing as given [deg]."""


@study(
    "shockpc improve anymal_b --contact LF_FOOT --at imu_link --vary LF_HFE=0:70 --vary "
    "LF_KFE=-110:-20 --over strike-angle=0:20:3",
    "shockpc improve go2 --contact FL_foot --at imu --vary FL_calf_joint=-130:-60 --keep "
    "'joint_impulse@FL_calf_joint<=2'",
    more=(
        "Without --contact the robot lands on all level feet together, on each edge of their "
        "support, and on each foot. The worst landing is improved; a better optimum may exist. "
        "The numbers before and after are exact, unless friction or a contact stiffness applies. "
        "The landings must be possible on flat ground, but collisions between links are not "
        "checked. --out writes the scenes of the optimum."
    ),
    reads="landings",
    passed=("trace",),
)
def improve(
    landings: Scene | str | Mapping[str, Scene | str],
    quantity: Annotated[
        str | None,
        Option(
            "A quantity (see shockpc quantities) at a place, or at the worst of several.",
            "Question",
            "KEY@PLACES",
            holds="quantity",
            default="shock at the point of --at, at the IMU, or at the trunk's centre of mass",
        ),
    ] = None,
    robot: Robot | None = None,
    *,
    vary: Annotated[
        Vary,
        Option(
            "A variable and its range: joints [deg; m if prismatic], base-pitch, strike-angle, "
            "mass:LINK or place:JOINT with factors such as 0.8x:1.2x, and other names that sweep "
            "varies. All joints that match a glob with a range have the same value; without a "
            "range each has its limits. Default: the joints between the trunk and the contact.",
            "Search",
            "NAME=LOW:HIGH",
        ),
    ] = (),
    over: Annotated[
        Vary,
        Option(
            "Repeat each landing with these values, a:b:n or a,b,c, such as strike-angle=-20:20:5.",
            "Search",
            "NAME=VALUES",
            holds="varied",
        ),
    ] = (),
    keep: Annotated[
        str | Sequence[str],
        Option(
            "A constraint, such as 'joint_impulse@*_KFE<=2', or >=.",
            "Search",
            "KEY@PLACES<=LIMIT",
            holds="quantity",
        ),
    ] = (),
    any_ground: Annotated[
        bool,
        Option(
            "Also allow landings that flat ground does not allow: a contact would be pulled, or "
            "another link touches first.",
            "Search",
        ),
    ] = False,
    starts: Annotated[
        int | None,
        Option(
            "Runs from random points, besides the run from the landing as given.",
            "Search",
            "N",
            least=0.0,
            greatest=1000.0,
            default=(
                f"{RUNS}, {ROUGH} where derivatives are differences, {SLOW} where each point needs "
                f"a separate landing"
            ),
        ),
    ] = None,
    seed: Annotated[
        int, Option("Seed of the random numbers.", "Search", "N", least=0.0, greatest=1e15)
    ] = 0,
    trace: Trace | None = None,
) -> Improvement:
    """Find where a number is the least bad in the worst of some landings.

    Args:
        landings: one landing, or landings of one robot by name.
        robot: the scenes' robot, if it is loaded already.
        trace: collects what each stage cost.

    Raises:
        StudyError: no point meets the constraints, or a quantity is not to be less or greater.
        ShockError: as for `ShockCost`.
    """
    trace = trace or Trace()
    scenes = named_scenes(landings)
    robot = robot or common_robot(scenes)
    scenes = with_default_landings(scenes, robot)
    # What is chosen where nothing was said.
    chosen: list[str] = []
    if quantity is None:
        quantity = _usual_quantity(robot, scenes.values())
        if not any(scene.point for scene in scenes.values()):
            chosen.append(f"quantity {quantity}")
    # Every landing counts at all values of what varies from strike to strike.
    scenes = _repeated(scenes, robot, over)
    if not vary:
        vary = _usual_variables(robot, scenes, _subjects(robot, over))
        chosen.append(
            f"variables {few(list(vary), 12)}, the joints that carry the contact, within "
            f"{USUAL_RANGE:g} deg of the landing as given and their limits"
        )
    _refuse_repeated(robot, over, vary)
    cost_of = partial(
        ShockCost,
        quantity=quantity,
        variables=vary,
        robot=robot,
        keep=keep,
        ground=not any_ground,
    )
    with trace.stage("landings"):
        cost = cost_of(scenes)
    # Without a worse value there is no worst landing to improve.
    if cost.column.selection.quantity.worse == "neither":
        raise StudyError(
            f"{cost.column.title} is neither better nor worse if it is smaller; choose another "
            "quantity, or bound it with --keep"
        )
    with trace.stage("runs"):
        runs = _runs(cost, starts, seed)
    improvement = improvement_of(cost, runs, seed, tuple(chosen), trace)
    # Drives that vary have no ends.
    if any(varied.kind.of_drives for varied in cost.variations):
        return improvement
    x = improvement.x
    before, after = improvement.values
    cases = {name: (scene, robot) for name, scene in cost.scenes.items()}
    # Both ends of the drives judge this optimum, and find their own.
    as_modelled = DriveEnd(before, after, after, x)
    with trace.stage("ends of the drives"):
        ends = at_drive_ends(as_modelled, cases, lambda scenes: drive_end(cost_of(scenes), x))
    return replace(improvement, ends=ends)


def _refuse_repeated(robot: Robot, over: Vary, vary: Vary) -> None:
    """Refuse what is both repeated and a variable.

    Raises:
        StudyError: there is something.
    """
    both = _subjects(robot, over) & _subjects(robot, vary)
    if both:
        raise StudyError(
            f"{few(sorted(both), 4)} is in both --over and --vary; leave it out of one"
        )


def _repeated(scenes: Mapping[str, Scene], robot: Robot, over: Vary) -> dict[str, Scene]:
    """The landings by name, each repeated with the values of `over`."""
    every: dict[str, Scene] = {}
    for name, scene in scenes.items():
        for label, varied in scene_grid(name, scene, robot, pairs(over)).items():
            every[label.strip()] = varied
    return every


def _usual_quantity(robot: Robot, scenes: Collection[Scene]) -> str:
    """The shock at the point of the scenes, by default at the robot's IMU.

    Without an IMU it is that at the trunk's centre of mass.

    Raises:
        StudyError: the scenes have several points.
    """
    friction = "_friction" if any(scene.friction is not None for scene in scenes) else ""
    points: dict[str, None] = {}
    for scene in scenes:
        points |= dict.fromkeys(point.label for point in scene.point)
    if len(points) > 1:
        raise StudyError(
            f"improve takes one quantity, but there are several points: {few(list(points), 4)}; "
            "name one with --quantity"
        )
    sensor = next(iter([*points, *filter(is_imu, sensors(robot))]), None)
    if sensor is not None:
        return f"shock{friction}@{sensor}"
    trunk = landing_of(next(iter(scenes)), robot).trunk
    return f"shock_com{friction}@{robot.bodies[trunk].name}"


def _subjects(robot: Robot, varied: Vary) -> set[str]:
    """The subjects that are varied; of a pattern the joints that it means."""
    subjects: set[str] = set()
    for subject, _ in pairs(varied):
        subjects.update(fnmatch.filter(robot.joint_names, subject) or [subject])
    return subjects


def _usual_variables(
    robot: Robot, scenes: Mapping[str, Scene], repeated: Collection[str]
) -> dict[str, tuple[float, float]]:
    """Ranges of the joints between the trunk and what strikes [deg, m].

    They are near the first landing as given, and within the joints' limits.

    Args:
        robot: the robot.
        scenes: the landings by name.
        repeated: joints whose values are given.

    Raises:
        StudyError: there is no such joint, or the robot has loops.
    """
    if robot.loops:
        raise _unnamed(robot, "loops move its joints together")
    struck = []
    for scene in scenes.values():
        struck += [robot.frame(contact.frame).body for contact in scene.contact]
    carrying = np.any(robot.ancestors[struck], axis=0)
    q = resolve(next(iter(scenes.values())), robot).q
    ranges = dict[str, tuple[float, float]]()
    for joint in robot.independent_joints:
        low, high = motion_range([joint])
        if joint.name in repeated or not carrying[joint.v].all():
            continue
        if not 0.0 < high - low < math.inf:
            continue
        if joint.unit == "m":
            ranges[joint.name] = low, high
            continue
        reach = math.radians(USUAL_RANGE)
        value = min(max(joint.value(q), low), high)
        ends = max(low, value - reach), min(high, value + reach)
        ranges[joint.name] = math.degrees(ends[0]), math.degrees(ends[1])
    if not ranges:
        raise _unnamed(robot, "no joint that carries the contact is free to move")
    return ranges


def _unnamed(robot: Robot, why: str) -> StudyError:
    """That there are no variables by default."""
    return StudyError(
        f"{robot.label}: {why}; name a variable with --vary, such as the joint of a motor"
    )


def _runs(cost: ShockCost, starts: int | None, seed: int) -> list[Run]:
    """Runs from the landing as given and from random points, the best one first.

    Raises:
        StudyError: none meets the constraints, or has a value.
        ShockError: there is no landing.
    """
    some = np.stack(starting_points(cost, 1, seed))
    if not np.isfinite(cost.worst(some)).any():
        # This says why, of a robot that has no landing in any posture.
        profiles(cost.cases(cost.x0))
    runs = search(cost, starting_points(cost, starts, seed))
    if not np.isfinite(runs[0].value):
        raise StudyError(_refusal(cost, runs))
    return runs


def _refusal(cost: ShockCost, runs: Sequence[Run]) -> str:
    """The reason why no run reached a point that counts."""
    measures = cost.measured(np.array([run.x for run in runs]))
    missed = np.isinf(measures) | (cost.constraints & (measures < 0.0))
    k = int(missed.sum(axis=1).argmin())
    lacking = [cost.terms[j].column for j in np.flatnonzero(np.isinf(measures[k]))]
    if lacking:
        # This says why, where there is no landing.
        profiles(cost.cases(runs[k].x))
        names = few(list(dict.fromkeys(column.title for column in lacking)), 4)
        missing = lacking[0].selection.quantity.scope.missing
        why = f" ({missing})" if missing else ""
        return (
            f"{names} has no value at the best point{why}; choose another quantity or other "
            "places, or change the ranges"
        )
    texts = dict.fromkeys(cost.terms[j].text for j in np.flatnonzero(missed[k]))
    return (
        f"no point meets the constraints; the nearest one misses {few(list(texts), 4)}. Widen a "
        "range, or leave a constraint out"
    )
