"""The arguments of a sweep, checked: what varies, over a full grid or in a sample, and its
computation in parts.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Annotated

from shockpc.evaluation.column import Column, ground_columns, selected
from shockpc.evaluation.declare import QuantityOption, study
from shockpc.evaluation.evaluate import Evaluation
from shockpc.evaluation.kinds.contacts import CONTACT
from shockpc.evaluation.varied_landings import MOST_ROWS, VariedLandings, varied_landings
from shockpc.evaluation.vary import Vary
from shockpc.landing.places import Place, body_places, moving_point
from shockpc.landing.record import Option
from shockpc.landing.scene import Point, Scene
from shockpc.landing.scene_file import scene_of
from shockpc.quantities.selection import select
from shockpc.robot.robot import Robot
from shockpc.text.errors import StudyError

FEASIBILITY = (
    "friction_needed",
    "tensile_impulse",
    "energy_gained",
    "depth_below_contacts",
    "feasible",
)
"""Quantities of every row that tell whether flat ground allows the landing."""


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
            "The same for a glob of joints or links, each of which varies by itself.",
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
    """Many landings that differ from one, checked; computed part by part as the result is iterated
    over, or at once by `table`.

    Args:
        scene: the landing that is varied.
        robot: the scene's robot, if it is loaded already.
        at: points, as `Point` or names of frames.

    Raises:
        ShockError: a name is not known, values do not fit, nothing varies, or the landing cannot be
            resolved. A row that cannot be computed is no error: its message is in the table.
    """
    points = tuple(Point(frame=point) if isinstance(point, str) else point for point in at)
    source = varied_landings(
        replace(scene_of(scene), point=points),
        vary,
        robot=robot,
        vary_each=vary_each,
        sample=sample,
        lhs=lhs,
        seed=seed,
    )
    columns = _columns(source, points, bodies, quantities)
    return Evaluation(source, columns, prove, feasible)


def _columns(
    study: VariedLandings,
    points: tuple[Point, ...],
    names: Sequence[str],
    quantities: Sequence[str],
) -> tuple[Column, ...]:
    """The columns of the points and bodies, or of the trunk, what the ground allows, and of the
    further quantities.
    """
    robot, landing = study.robot, study.first
    places = {place.name: place for place in (moving_point(robot, point) for point in points)}
    bodies = [i for name in names for i in robot.match_bodies(name)] or (
        [] if places else [landing.trunk]
    )
    severe = ["most_severe", *(f"most_severe_direction.{axis}" for axis in "xyz")]
    of_body = ["shock_com", *(f"copc.{axis}" for axis in "xyz"), "ropc"]
    columns = [
        Column(select(key), place) for place in places.values() for key in ("shock", *severe)
    ]
    for body in dict.fromkeys(bodies):
        place = body_places(robot)[body]
        columns += [
            Column(select(key), place) for key in (*of_body, *(f"body.{key}" for key in severe))
        ]
    varied = [
        str(value).split("+")
        for varied in study.variations
        if varied.kind == CONTACT
        for value in varied.values
    ]
    for text in (*FEASIBILITY, *quantities):
        selection, chosen = selected(landing, text)
        if text in FEASIBILITY and selection.quantity.of == "contact":
            chosen = chosen[: len(landing.contacts)]
        if varied and selection.quantity.of == "contact":
            if "@" in text:
                raise StudyError(
                    f'the contact varies, so "{text}" cannot name one; leave out the @ and the name'
                )
            chosen = tuple(
                Place(f"contact {k + 1}", number=k) for k in range(max(map(len, varied)))
            )
        if not chosen:
            raise StudyError(
                f'"{text}": the robot has no sensor, and no point is given; name a frame: '
                f"{text}@{robot.links[0]}"
            )
        columns += [Column(selection, place, requested=text in quantities) for place in chosen]
    columns += ground_columns(landing)[1:]
    # A further quantity replaces a column of the same name.
    return tuple({column.name: column for column in columns}.values())
