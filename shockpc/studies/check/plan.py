"""The landings that have budgets, checked before any of them is computed."""

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from shockpc.evaluation.budgets import Budgets, Case
from shockpc.evaluation.column import Column, places_at
from shockpc.evaluation.evaluate import Evaluation
from shockpc.evaluation.unused_ground import refuse_unused_ground
from shockpc.evaluation.variations.arguments import varied_landings
from shockpc.evaluation.variations.rows import VariedLandings
from shockpc.landing.landing import PosedLanding
from shockpc.landing.places import Place
from shockpc.landing.resolve import resolve
from shockpc.landing.scenes.scene import Scene
from shockpc.landing.scenes.scene_file import robot_of
from shockpc.quantities.quantity import Quantity
from shockpc.quantities.selection import Selection, select
from shockpc.robot.robot import Robot
from shockpc.studies.check.baseline import Baseline, OutcomeKey, case_record, refuse_other_scene
from shockpc.text.errors import ShockError, StudyError
from shockpc.text.names import match
from shockpc.text.printed import printable


class Planned(NamedTuple):
    """A landing that has budgets, ready to be computed.

    Attributes:
        case: it belongs to.
        angle: one of the case's strike angles; None if the scene gives the strike [deg].
        scene: the landing.
        robot: its robot.
        places: those of each budget, by its number.
        designs: random designs; None if no budget has a percentile.
    """

    case: Case
    angle: float | None
    scene: Scene
    robot: Robot
    places: dict[int, tuple[Place, ...]]
    designs: Evaluation[VariedLandings] | None


def plan(budgets: Budgets, baseline: Baseline | None, records: dict[str, Any]) -> Iterator[Planned]:
    """All landings that have budgets.

    Args:
        budgets: cases and their limits.
        baseline: numbers of an earlier design.
        records: filled with scene and design of each case that has budgets, by its name.

    Raises:
        StudyError: a scene, a robot or a name in a budget is not valid, or the baseline is of
            another scene.
    """
    names = [case.name for case in budgets.cases]
    cases_of = []
    for k, budget in enumerate(budgets.budgets):
        where = f"{budgets.path}, budget[{k}]"
        cases_of.append(match(budget.case, names, "case", where, ""))
    for case in budgets.cases:
        numbers = [k for k, cases in enumerate(cases_of) if case.name in cases]
        if not numbers:
            continue
        _refuse_percentiles(case, any(budgets.budgets[k].percentile is not None for k in numbers))
        for angle, scene in case.landings:
            try:
                planned = _planned(budgets, baseline, records, case, angle, scene, numbers)
            except ShockError as refusal:
                name = printable(case.name)
                raise StudyError(f'case "{name}": {refusal}', **refusal.data) from None
            yield planned


def _refuse_percentiles(case: Case, sampled: bool) -> None:
    """Refuse random designs without a percentile, and a percentile without random designs.

    Args: case, the case; sampled, whether one of its budgets has a percentile.
    """
    if bool(case.vary) == sampled:
        return
    state = "nothing that varies, so it has no percentiles"
    if case.vary:
        state = "designs that vary, but no budget of it has a percentile"
    raise StudyError(
        f'case "{printable(case.name)}" has {state}; a percentile of a budget is of the designs '
        f"that [[case.vary]] describes"
    )


def _planned(
    budgets: Budgets,
    baseline: Baseline | None,
    records: dict[str, Any],
    case: Case,
    angle: float | None,
    scene: Scene,
    numbers: Sequence[int],
) -> Planned:
    """One landing of a plan.

    Args: numbers, of its budgets.
    """
    robot = robot_of(scene)
    landing = resolve(scene, robot)
    selections = tuple(budgets.budgets[k].selection for k in numbers)
    refuse_unused_ground(scene, selections)
    records[case.name] = case_record(landing, angle is None)
    if baseline is not None:
        refuse_other_scene(baseline, case.name, records[case.name])
    places = {}
    columns = []
    for k in numbers:
        budget = budgets.budgets[k]
        places[k] = _places(landing, budget.selection.quantity, budget.at)
        if baseline is not None and budget.baseline_tolerance is not None:
            for place in places[k]:
                key = OutcomeKey(case.name, angle, place.name, budget.metric)
                _refuse_missing(baseline, key)
        if budget.percentile is not None:
            columns += [Column(budget.selection, place) for place in places[k]]
    designs = None
    if columns:
        designs = _designs(case, scene, robot, columns, selections)
    return Planned(case, angle, scene, robot, places, designs)


def _places(landing: PosedLanding, quantity: Quantity, at: str) -> tuple[Place, ...]:
    """The places that a budget means.

    Where a point is needed, a body is its centre of mass, and globs are those of sensors too.
    """
    frames = landing.robot.frames
    bodies = {place.name: place for place in landing.places("body")}
    if quantity.of == "body":
        places = places_at(landing, quantity, at)
        if at in frames and at not in bodies:
            return tuple(place._replace(name=f"{place.name} (carries {at})") for place in places)
        return places
    if quantity.of != "point":
        return places_at(landing, quantity, at)
    known = {
        name: place._replace(name=f"{name} (centre of mass)") for name, place in bodies.items()
    }
    for place in places_at(landing, quantity):
        known.setdefault(place.name, place)
    # FRAME and FRAME:x,y,z are points of a frame that is neither a body nor a sensor.
    of_frame = at in frames or at.rpartition(":")[0] in frames
    if at in known or not of_frame:
        names = landing.robot.match("point or body", at, known, frames)
        return tuple(known[name] for name in names)
    return places_at(landing, quantity, at)


def _designs(
    case: Case,
    scene: Scene,
    robot: Robot,
    columns: Sequence[Column],
    selections: tuple[Selection, ...],
) -> Evaluation[VariedLandings]:
    """The random designs of a landing.

    Args:
        case: says what varies.
        scene: the landing.
        robot: its robot.
        columns: the numbers whose percentile has a limit.
        selections: the quantities of all budgets of the landing.
    """
    together = [(unknown.quantity, unknown.values) for unknown in case.vary if unknown.quantity]
    one_by_one = [(unknown.each, unknown.values) for unknown in case.vary if unknown.each]
    source = varied_landings(
        scene,
        together,
        robot=robot,
        vary_each=one_by_one,
        sample=int(case.designs),
        lhs=True,
        keep_joints=True,
    )
    energy = Column(select("energy_gained"), source.first.places("robot")[0])
    computed = {column.name: column for column in (*columns, energy)}
    return Evaluation(source, tuple(computed.values()), prove=0, elsewhere=selections)


def _refuse_missing(baseline: Baseline, key: OutcomeKey) -> None:
    """Refuse a baseline without a number."""
    if key in baseline.values:
        return
    strike = "" if key.strike_angle_deg is None else f" at {key.strike_angle_deg:g} deg"
    raise StudyError(
        f'baseline "{baseline.path}" has no {key.metric} at "{printable(key.at)}"{strike}; write '
        f"it anew with --update-baseline"
    )
