"""The arguments of a sweep, checked: what varies, over a full grid or in a sample, and its computation in parts."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from shockpc.evaluation.columns import Column, selected
from shockpc.evaluation.evaluate import Evaluation
from shockpc.evaluation.variation import Variation, each_of, motion_range, pairs, variation
from shockpc.evaluation.varied import VariedLandings
from shockpc.evaluation.varied_scene import applied, armature_set
from shockpc.landing.places import Place, body_places, moving_point
from shockpc.landing.scene import Point, Scene, check_scene, plane_of, robot_of
from shockpc.quantities.table import select
from shockpc.robot.robot import Robot
from shockpc.text.errors import StudyError

GROUND = ("friction_needed", "pull", "depth", "feasible")
"""Quantities of every row that tell whether flat ground allows the landing."""

MOST_ROWS = 10**8
"""Rows of a sweep: so many take an hour, and a column of them 0.8 GB."""


def sweep(
    scene: Scene,
    vary: Mapping[str, Any] | Iterable[tuple[str, Any]] = (),
    *,
    robot: Robot | None = None,
    vary_each: Mapping[str, Any] | Iterable[tuple[str, Any]] = (),
    at: Sequence[Point | str] = (),
    bodies: Sequence[str] = (),
    greatest: bool = False,
    quantities: Sequence[str] = (),
    feasible: bool = False,
    sample: int | None = None,
    lhs: bool = False,
    seed: int = 0,
    prove: int = 100,
    held: bool = False,
) -> Evaluation[VariedLandings]:
    """Many landings that differ from one, checked; computed part by part as the result is iterated over, or at once by `table`.

    Args:
        scene: the landing that is varied.
        vary: values by subject, as in `variation`: {"*_KFE": "-120:-10:200", "strike-angle": [0, 15, 30]}.
        robot: the scene's robot, if it is loaded already.
        vary_each: the same, with a quantity of its own for each joint or link that a pattern matches.
        at: points, as `Point` or names of frames.
        bodies: names or globs of bodies; the base by default, if there are no points either.
        greatest: whether to add the greatest shock over the geometry of the bodies.
        quantities: further columns, QUANTITY or QUANTITY@PLACES, as `selected` takes it.
        feasible: whether rows that flat ground does not allow are left out. Rows that could not be computed are not.
        sample: number of random rows instead of the full grid. If neither a joint nor what the robot and the ground are is varied,
            all joints are, within their limits.
        lhs: whether the sample is a Latin hypercube.
        seed: of the random numbers.
        prove: number of random rows that are compared with a proof, besides those that need one.
        held: whether joints that are not varied stay where the scene has them in any sample.

    Raises:
        ShockError: a name is not known, values do not fit, nothing varies, or the landing cannot be resolved. A row that cannot be
            computed is no error: its message is in the table.
    """
    robot = robot or robot_of(scene)
    # A mapping holds each subject once; pairs may repeat one, which is refused below.
    vary, vary_each = pairs(vary), pairs(vary_each)
    for name, number in {"seed": seed, "prove": prove}.items():
        if number < 0:
            raise StudyError(f"{name} is {number}, and it has to be a whole number from 0")
    variations = [variation(robot, subject, values) for subject, values in vary]
    variations += [varied for subject, values in vary_each for varied in each_of(robot, variation(robot, subject, values))]
    if sample is not None:
        if sample < 1:
            raise StudyError(f"a sample of {sample} rows is empty; give a number above zero")
        if not held and not any(varied.kind == "joint" or varied.uncertain for varied in variations):
            variations += [variation(robot, f"joint:{joint.name}") for joint in robot.independent_joints]
    elif lhs:
        raise StudyError("a Latin hypercube is a sample; give its number of rows with --sample")
    if not variations:
        raise StudyError("nothing varies; name a joint or another quantity with --vary, or draw random postures with --sample")
    variations = [part for varied in variations for part in ((varied,) if varied.values or varied.span else each_of(robot, varied))]
    variations = [_complete(robot, varied, sample is not None) for varied in variations]
    _refuse_twice(robot, variations)
    if scene.posture.base_quaternion is not None and any(varied.kind.startswith("base-") for varied in variations):
        raise StudyError("the base's attitude is varied, but the scene gives it as a quaternion; give base_rpy_deg instead")
    points = tuple(Point(frame=point) if isinstance(point, str) else point for point in at)
    scene = check_scene(replace(scene, point=points))
    study = VariedLandings(scene, robot, tuple(variations), sample, lhs, seed)
    if study.rows > MOST_ROWS:
        raise StudyError(
            f"{study.rows:.4g} landings are more than {MOST_ROWS:.0e}; give fewer values, or draw a sample with --sample"
        )
    plane = plane_of(scene)
    for varied in study.axes:
        for value in (varied.values or varied.span or ()) if varied.stage == 2 else ():
            applied(scene, robot, varied, value)[0].strike.vector(plane)
        if varied.kind == "armature":
            armature_set(scene, robot, varied)
        if varied.kind == "joint-stiffness":
            applied(scene, robot, varied, 1.0)
    return Evaluation(study, _columns(study, points, bodies, greatest, quantities), prove, feasible)


def _columns(
    study: VariedLandings, points: tuple[Point, ...], names: Sequence[str], greatest: bool, quantities: Sequence[str]
) -> tuple[Column, ...]:
    """The columns of the points and bodies, or of the base, what the ground allows, and of the further quantities."""
    robot, landing = study.robot, study.first
    places = {place.name: place for place in (moving_point(robot, point) for point in points)}
    bodies = [i for name in names for i in robot.match_bodies(name)] or ([] if places else [0])
    severe = ["most_severe", *(f"most_severe_direction.{axis}" for axis in "xyz")]
    of_body = ["shock_com", *(["shock_max"] if greatest else []), *(f"copc.{axis}" for axis in "xyz"), "ropc"]
    columns = [Column(select(key), place) for place in places.values() for key in ("shock", *severe)]
    for body in dict.fromkeys(bodies):
        place = body_places(robot)[body]
        columns += [Column(select(key), place) for key in (*of_body, *(f"body.{key}" for key in severe))]
    varied = [str(value).split("+") for varied in study.variations if varied.kind == "contact" for value in varied.values]
    for text in (*GROUND, *quantities):
        selection, chosen = selected(landing, text)
        if text in GROUND and selection.quantity.of == "contact":
            chosen = chosen[: len(landing.contacts)]
        if varied and selection.quantity.of == "contact":
            if "@" in text:
                raise StudyError(f'the contact varies, so "{text}" cannot name one; leave the @ and what follows out')
            chosen = tuple(Place(f"contact {k + 1}", number=k) for k in range(max(map(len, varied))))
        if not chosen:
            raise StudyError(f'"{text}": the robot has no sensor, and no point is given; name a frame: {text}@{robot.links[0]}')
        columns += [Column(selection, place, asked=text in quantities) for place in chosen]
    # A further quantity replaces a column of the same name.
    return tuple({column.name: column for column in columns}.values())


def _complete(robot: Robot, varied: Variation, sample: bool) -> Variation:
    """A variation with the range of its joint, if it was given no values."""
    if not varied.values and varied.span is None:
        joint = robot.joint(varied.target)
        low, high = (limit if varied.unit == "m" else math.degrees(limit) for limit in motion_range([joint]))
        if not high > low or not math.isfinite(high - low):
            raise StudyError(
                f'joint "{joint.name}" has no range of motion in the robot file; give values, such as {joint.name}=0:0.1:5'
            )
        varied = replace(varied, subject=joint.name, span=(low, high))
    if not sample and varied.span is not None:
        raise StudyError(
            f"{varied.subject}: a range is drawn from by --sample N; for a grid give the number of values too, such as "
            f"{varied.span[0]:g}:{varied.span[1]:g}:10"
        )
    return varied


def _refuse_twice(robot: Robot, variations: list[Variation]) -> None:
    seen: dict[str, str] = {}
    for varied in variations:
        own = [joint.name for joint in varied.joints(robot)] if varied.kind == "joint" else [varied.subject]
        for name in own:
            if name in seen:
                raise StudyError(f'"{name}" is varied twice, by "{seen[name]}" and by "{varied.subject}"; keep one of them')
            seen[name] = varied.subject
