"""The arguments of a sweep, checked: what varies, over a full grid or in a sample, and its computation in parts."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from shockpc.evaluation.columns import Column, selected
from shockpc.evaluation.evaluate import Evaluation
from shockpc.evaluation.varied import VariedLandings, varied_landings
from shockpc.landing.places import Place, body_places, moving_point
from shockpc.landing.scene import Point, Scene
from shockpc.quantities.table import select
from shockpc.robot.robot import Robot
from shockpc.text.errors import StudyError

GROUND = ("friction_needed", "pull", "depth", "feasible")
"""Quantities of every row that tell whether flat ground allows the landing."""


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

    Raises:
        ShockError: a name is not known, values do not fit, nothing varies, or the landing cannot be resolved. A row that cannot be
            computed is no error: its message is in the table.
    """
    if prove < 0:
        raise StudyError(f"prove is {prove}, and it has to be a whole number from 0")
    points = tuple(Point(frame=point) if isinstance(point, str) else point for point in at)
    source = varied_landings(
        replace(scene, point=points), vary, robot=robot, vary_each=vary_each, sample=sample, lhs=lhs, seed=seed
    )
    return Evaluation(source, _columns(source, points, bodies, greatest, quantities), prove, feasible)


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
