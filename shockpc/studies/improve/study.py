"""The posture, strike or design with the smallest worst value of a number over some landings,
within ranges and constraints.

Where two numbers are to be small, one is made small for each of several bounds of the other.
"""

import fnmatch
import functools
import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

import numpy as np

from shockpc.core.spatial import Array, read_only
from shockpc.evaluation.column_values import proven_columns
from shockpc.evaluation.cost import ShockCost
from shockpc.evaluation.declare import study
from shockpc.evaluation.drive_ends import MOVED, End, at_drive_ends
from shockpc.evaluation.evaluate import profiles
from shockpc.evaluation.named_scenes import common_robot, named_scenes, with_default_landings
from shockpc.evaluation.table import Table
from shockpc.evaluation.variation import DRIVEN, Vary, motion_range, pairs
from shockpc.evaluation.varied_scene import scene_grid
from shockpc.landing.record import Option
from shockpc.landing.resolve import landing_of, resolve
from shockpc.landing.scene import Scene
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.robot.feet_and_sensors import is_imu, sensors
from shockpc.robot.robot import Robot
from shockpc.studies.improve.search import (
    OPTIMUM_TOLERANCE,
    ROUGH,
    RUNS,
    SLOW,
    Run,
    search,
    starting_points,
)
from shockpc.text.errors import ShockError, StudyError
from shockpc.text.printed import few
from shockpc.text.shown import brief, shown_by
from shockpc.text.trace import Trace

USUAL_RANGE = 45.0
"""How far from the landing as given joints are looked at where nothing is said [deg]."""

AGREEING = 0.01
"""How much worse than the optimum, as a share of it, a run may end that counts as one that agrees.
"""

FLAT = 0.05
"""How much worse than the optimum, as a share of it, a value may be that counts as flat."""

SHARES = np.append(0.0, np.geomspace(1e-4, 1.0, 40))
"""Shares of the way to a bound at which a variable is looked at, and then as many between two of
them.
"""

FRONT, END_GAP, BEGUN = 9, 1e-5, 8
"""Points between the ends of a front; how far from the second number's optimum its end is, as a
share of the front; and how many
runs of each point begin at other places than points beside it."""


class Flatness(NamedTuple):
    """What a variable does at the optimum.

    Attributes:
        name: heading, with its unit.
        before: its value before; NaN if it has none, or not a single one.
        after: its value at the optimum.
        bound: which bound it is held by, "minimum" or "maximum"; None if by none.
        set_back: the target if it alone is set back; NaN if there is no such landing.
        low: smallest value of it alone with which the target is at most 5 % worse.
        high: largest.
    """

    name: str
    before: float
    after: float
    bound: str | None
    set_back: float
    low: float
    high: float


class FrontPoint(NamedTuple):
    """A point of the front of two numbers: their worst values (2,), in double precision, and the
    variables (n,).
    """

    values: Array
    x: Array


class DriveEnd(NamedTuple):
    """An improvement with other drives.

    Attributes:
        given: the number in the landings as given, of the worst [its unit].
        there: at the optimum of the drives as modelled; NaN where a constraint does not hold there.
        best: at the best point that runs from that optimum and from the landing as given find; NaN
            where there is none.
        x: (n,) the variables at that point.
    """

    given: float
    there: float
    best: float
    x: Array


@dataclass(frozen=True, eq=False)
class Improvement:
    """An optimum.

    Attributes:
        costs: what was improved, of each quantity.
        x: (n,) the variables at the optimum.
        before: proven profiles of the landings as they are given, by name.
        after: those at the optimum.
        values: the numbers, each the worst of the landings as given and at the optimum, proven
            [their units].
        worst: name of the landing that is the worst at the optimum.
        active: the constraints that hold it there, and the landings that are as bad as the worst.
        variables: what each does.
        runs: target of each run, the best first, step by step, in double precision; NaN where the
            constraints do not hold.
        agreeing: how many runs end within 1 % of the optimum.
        front: of two numbers, in increasing order of the first; empty for one.
        seed: of the random points.
        chosen: what was asked for where nothing was said: a quantity, and what varies.
        ends: of the first number, with all drives at the smallest inertias that what is known
            allows, and at the largest, or why there is none; empty where all are known exactly, or
            vary.
    """

    costs: tuple[ShockCost, ...] = field(repr=False)
    x: Array
    before: dict[str, ShockProfile] = field(repr=False)
    after: dict[str, ShockProfile] = field(repr=False)
    values: tuple[tuple[float, ...], ...]
    worst: str
    active: tuple[str, ...]
    variables: tuple[Flatness, ...]
    runs: tuple[Array, ...] = field(repr=False)
    agreeing: int
    front: tuple[FrontPoint, ...]
    seed: int
    chosen: tuple[str, ...]
    ends: Mapping[End, DriveEnd | ShockError] = field(default_factory=dict, repr=False)

    _repr_html_ = shown_by("studies.improve.report:improve_report")

    def __repr__(self) -> str:
        changed = [f"{one.name} {one.before:.4g} → {one.after:.4g}" for one in self.variables[:4]]
        return brief(self, *changed)

    def moves(self, end: DriveEnd) -> bool:
        """Whether the number at the optimum differs by more than 1 %, or a variable by 1 degree, 1
        cm or 1 % of its range.
        """
        (_, after), cost = self.values[0], self.costs[0]
        if not all(math.isclose(after, value, rel_tol=MOVED) for value in (end.there, end.best)):
            return True
        alone = {"deg": 1.0, "m": 0.01}
        most = [alone.get(one.unit, MOVED * np.ptp(one.ends)) for one in cost.variations]
        return bool(np.any(np.abs(end.x - self.x) > most))

    @property
    def table(self) -> Table:
        """A row for each variable."""
        header = (
            "variable",
            "as given",
            "optimum",
            "at bound",
            "target if set back",
            "5 % from",
            "5 % to",
        )
        return Table.of_rows(header, self.variables)


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
    quantities: Annotated[
        str | Sequence[str],
        Option(
            "A quantity (see shockpc quantities) at a place, or at the worst of several. Two give "
            "a Pareto front.",
            "Question",
            "KEY@PLACES",
            "quantity",
            holds="quantity",
            default="shock at the points of --at, at the IMU, or at the trunk's centre of mass",
        ),
    ] = (),
    robot: Robot | None = None,
    *,
    vary: Annotated[
        Vary,
        Option(
            "A variable and its range: joints [deg; m if prismatic], base-pitch, strike-angle, "
            "mass:LINK or place:JOINT with "
            "factors such as 0.8x:1.2x, and other names that sweep varies. All joints that match a "
            "glob with a range have the "
            "same value; without a range each has its limits. Default: the joints between the "
            "trunk and the contact.",
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
            "Also allow landings in which flat ground would pull a contact, or meet another link "
            "first.",
            "Search",
        ),
    ] = False,
    starts: Annotated[
        int | None,
        Option(
            "Runs from random points, besides that from the landing as given.",
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

    Of two quantities the optimum is that of the first.

    Args:
        landings: one landing, or landings of one robot by name.
        robot: the scenes' robot, if it is loaded already.
        trace: collects what each stage cost.

    Raises:
        StudyError: no point meets the constraints, a quantity is not to be less or greater, or
            there are more than two.
        ShockError: as for `ShockCost`.
    """
    trace = trace or Trace()
    scenes = named_scenes(landings)
    robot = robot or common_robot(scenes)
    scenes = with_default_landings(scenes, robot)
    chosen = list[str]()
    if not quantities:
        quantities = _usual_quantities(robot, scenes.values())
        if not any(scene.point for scene in scenes.values()):
            chosen.append(f"quantity {', '.join(quantities)}")
    texts = (quantities,) if isinstance(quantities, str) else tuple(quantities)
    if len(texts) > 2 or len(set(texts)) < len(texts):
        raise StudyError(
            f"improve takes one quantity or two different ones, got {', '.join(texts)}; --keep "
            f"bounds others"
        )
    scenes = {
        label.strip(): one
        for name, scene in scenes.items()
        for label, one in scene_grid(name, scene, robot, pairs(over)).items()
    }
    taken = _subjects(robot, over)
    if not vary:
        vary = {
            name: values
            for name, values in _near_joints(robot, scenes).items()
            if name not in taken
        }
        if robot.loops or not vary:
            why = (
                "loops move its joints together"
                if robot.loops
                else "no joint that carries what strikes is free to move"
            )
            raise StudyError(
                f"{robot.label}: {why}; name what may change with --vary, such as the joint of a "
                f"motor"
            )
        within = (
            f"the joints that carry what strikes, within {USUAL_RANGE:g} deg of the landing as "
            f"given and their limits"
        )
        chosen.append(f"variables {few(list(vary), 12)}, {within}")
    if both := taken & _subjects(robot, vary):
        raise StudyError(
            f"{few(sorted(both), 4)} is in both --over and --vary; leave it out of one"
        )
    keep = (keep,) if isinstance(keep, str) else tuple(keep)
    make = functools.partial(ShockCost, scenes, variables=vary, robot=robot, ground=not any_ground)
    with trace.stage("landings"):
        costs = tuple(make(text, keep=keep) for text in texts)
    for cost in costs:
        if cost.column.selection.quantity.worse == "neither":
            raise StudyError(
                f"{cost.column.title} is neither better nor worse if it is less; choose another "
                f"quantity, or --keep it"
            )
    cost, *others = costs
    with trace.stage("runs"):
        if not np.isfinite(cost.worst(np.stack(starting_points(cost, 1, seed)))).any():
            # which says why, of a robot that has no landing in any posture
            profiles(cost.cases(cost.x0))
        begun = [starting_points(one, starts, seed) for one in costs]
        runs = search(cost, begun[0])
    if not np.isfinite(runs[0].value):
        raise StudyError(_refusal(cost, runs))
    start, best = cost(cost.x0), runs[0].value
    agreeing = sum(
        run.value <= (1.0 + AGREEING) * best + OPTIMUM_TOLERANCE * min(start, 1.0) for run in runs
    )
    x = _set_back(cost, runs[0].x, best * (1.0 + OPTIMUM_TOLERANCE))
    with trace.stage("front"):
        front = (
            _front(
                costs, x, begun[-1], seed, lambda limit: make(cost.quantity, keep=[*keep, limit])
            )
            if others
            else ()
        )
    with trace.stage("proof"):
        landed = ({name: (scene, robot) for name, scene in cost.scenes.items()}, cost.cases(x))
        given, after = (profiles(cases) for cases in landed)
        values = tuple(tuple(_proven(one, found)[0] for found in (given, after)) for one in costs)
    ends: dict[End, DriveEnd | ShockError] = {}
    if not any(one.kind in DRIVEN for one in cost.variations):
        modelled = DriveEnd(values[0][0], values[0][1], values[0][1], x)

        def at_end(others: dict[str, Scene]) -> DriveEnd:
            return _at_end(
                ShockCost(others, cost.quantity, vary, robot, keep=keep, ground=not any_ground), x
            )

        with trace.stage("ends of the drives"):
            ends = at_drive_ends(modelled, landed[0], at_end)
    return Improvement(
        costs,
        read_only(x),
        given,
        after,
        values,
        _proven(cost, after)[1],
        _holding(cost, x),
        _variables(cost, x),
        tuple(run.history for run in runs),
        agreeing,
        front,
        seed,
        tuple(chosen),
        ends,
    )


def _at_end(cost: ShockCost, x: Array) -> DriveEnd:
    """The improvement with other drives, whose cost this is.

    Args: x, the optimum for the drives as modelled.
    """
    landed = {name: (scene, cost.robot) for name, scene in cost.scenes.items()}
    given = _proven(cost, profiles(landed))[0]
    there = _proven(cost, profiles(cost.cases(x)))[0] if cost.feasible(x) else math.nan
    best = search(cost, [x, cost.x0])[0]
    if not np.isfinite(best.value):
        return DriveEnd(given, there, math.nan, np.full(len(x), np.nan))
    found = _set_back(cost, best.x, best.value * (1.0 + OPTIMUM_TOLERANCE))
    return DriveEnd(given, there, _proven(cost, profiles(cost.cases(found)))[0], read_only(found))


def _usual_quantities(robot: Robot, scenes: Collection[Scene]) -> tuple[str, ...]:
    """The shock at the points of the scenes; without any at the robot's IMU, or at the trunk's
    centre of mass.
    """
    friction = "_friction" if any(scene.friction is not None for scene in scenes) else ""
    points = [point.label for scene in scenes for point in scene.point] or list(
        filter(is_imu, sensors(robot))
    )[:1]
    usual = [f"shock{friction}@{name}" for name in dict.fromkeys(points)]
    return tuple(
        usual
        or [f"shock_com{friction}@{robot.bodies[landing_of(next(iter(scenes)), robot).trunk].name}"]
    )


def _subjects(robot: Robot, varied: Vary) -> set[str]:
    """What is varied; of a pattern the joints that it means."""
    return {
        name
        for subject, _ in pairs(varied)
        for name in fnmatch.filter(robot.joint_names, subject) or [subject]
    }


def _near_joints(robot: Robot, scenes: Mapping[str, Scene]) -> dict[str, tuple[float, float]]:
    """Ranges of the joints between the trunk and what strikes, near the first landing as given and
    within their limits.
    """
    struck = [
        robot.frame(contact.frame).body for scene in scenes.values() for contact in scene.contact
    ]
    carrying, q = (
        np.any(robot.ancestors[struck], axis=0),
        resolve(next(iter(scenes.values())), robot).q,
    )
    ranges = dict[str, tuple[float, float]]()
    for joint in robot.independent_joints:
        low, high = motion_range([joint])
        if carrying[joint.v].all() and 0.0 < high - low < math.inf:
            reach, unit = (
                (math.inf, 1.0)
                if joint.unit == "m"
                else (math.radians(USUAL_RANGE), math.degrees(1.0))
            )
            value = min(max(joint.value(q), low), high)
            ranges[joint.name] = unit * max(low, value - reach), unit * min(high, value + reach)
    return ranges


def _refusal(cost: ShockCost, runs: Sequence[Run]) -> str:
    """Why no run reached a point that counts."""
    measures = cost.measured(np.array([run.x for run in runs]))
    missed = np.isinf(measures) | (cost.constraints & (measures < 0.0))
    k = int(missed.sum(axis=1).argmin())
    if lacking := [cost.terms[j].column for j in np.flatnonzero(np.isinf(measures[k]))]:
        profiles(cost.cases(runs[k].x))  # which says why there is none, where there is no landing
        names, why = (
            few(list(dict.fromkeys(one.title for one in lacking)), 4),
            lacking[0].selection.quantity.scope.missing,
        )
        found = f"{names} has no value at the best point that was found" + (
            f" ({why})" if why else ""
        )
        return f"{found}; choose another quantity or other places, or change the ranges"
    names = few(list(dict.fromkeys(cost.terms[j].text for j in np.flatnonzero(missed[k]))), 4)
    return (
        f"no point meets the constraints; the one that comes nearest misses: {names}. Widen a "
        f"range, or leave a constraint out"
    )


def _set_back(cost: ShockCost, x: Array, most: float) -> Array:
    """The optimum, or the landing as given where that is as good; else each variable as given that
    alone changes nothing.
    """
    for given in (
        np.ones(len(x), dtype=bool),
        *(np.eye(len(x), dtype=bool) & (cost.given == cost.x0)),
    ):
        back = np.where(given, cost.x0, x)
        if cost.feasible(back) and cost(back) <= most:
            x = back
    return x


def _holding(cost: ShockCost, x: Array) -> tuple[str, ...]:
    """What holds an optimum besides bounds: constraints without slack, and landings that are as bad
    as the worst.
    """
    (measures,) = cost.measured(x[None])
    worst = ~cost.constraints & (
        measures >= measures[~cost.constraints].max() * (1.0 - OPTIMUM_TOLERANCE)
    )
    active = np.append(
        np.flatnonzero(cost.constraints & (measures < OPTIMUM_TOLERANCE)),
        np.flatnonzero(worst & (worst.sum() > 1)),
    )
    texts = (
        f"{cost.terms[k].text} "
        f"({cost.terms[k].landing}){' is as bad as the worst' * bool(worst[k])}"
        for k in active
    )
    return tuple(dict.fromkeys(text.replace(" ()", "") for text in texts))


def _variables(cost: ShockCost, x: Array) -> tuple[Flatness, ...]:
    """What each variable does at an optimum."""
    n, (low, high), each = len(x), cost.bounds.T, np.eye(len(x), dtype=bool)
    set_back = np.where(np.isnan(cost.given), np.nan, cost.worst(np.where(each, cost.given, x)))
    target, before = cost.worst(np.stack([x, cost.x0]))
    # Where the optimum is zero, or nearly, 5 % are those of the value before, if there was one.
    most = FLAT * (before if target <= OPTIMUM_TOLERANCE * before < np.inf else target)
    way, shares = cost.bounds.T - x, np.tile(SHARES, (2, n, 1))
    for _ in range(2):
        X = x + (shares * way[..., None])[..., None] * each[:, None]
        with np.errstate(invalid="ignore"):
            worse = ~(
                cost.power * (cost.worst(X.reshape(-1, n)).reshape(shares.shape) - target) <= most
            )
        beyond = np.logical_or.accumulate(worse, axis=2)
        near, far = (
            np.where(beyond, 0.0, shares).max(axis=2),
            np.where(beyond, shares, shares[..., -1:]).min(axis=2),
        )
        shares = np.linspace(near, far, len(SHARES), axis=2)
    edge = OPTIMUM_TOLERANCE * (high - low)
    active = np.select([x - low <= edge, high - x <= edge], ["minimum", "maximum"], "").tolist()
    given, after, *others = (part.tolist() for part in (cost.given, x, set_back, *(x + near * way)))
    return tuple(
        map(Flatness, cost.names, given, after, [bound or None for bound in active], *others)
    )


def _proven(cost: ShockCost, found: Mapping[str, ShockProfile]) -> tuple[float, str]:
    """The worst proven value over landings, and the name of the landing."""
    terms = [term for term in cost.terms if term.limit is None]
    values = [
        proven_columns(found[term.landing], [term.column])[term.column.name] for term in terms
    ]
    k = int(cost.column.selection.worse(np.array(values)).argmax())
    return values[k], terms[k].landing


def _front(
    costs: Sequence[ShockCost],
    x: Array,
    begun: Sequence[Array],
    seed: int,
    bounded: Callable[[str], ShockCost],
) -> tuple[FrontPoint, ...]:
    """Points between the optimum of the first quantity and that of the second: the first at its
    minimum for bounds of the second.

    Args:
        costs: of both.
        x: the optimum of the first.
        begun: where runs for the second begin.
        seed: of the random points at which runs for both begin.
        bounded: gives the cost of the first with one constraint more.

    Raises:
        StudyError: the second quantity has no value at an end.
    """
    (_, other), sense = costs, "<=" if costs[1].power > 0.0 else ">="
    last = search(other, [*begun, x])[0].x
    found = [x]
    most, least = other.worst(np.stack([x, last]))
    if not np.isfinite([most, least]).all():
        raise StudyError(
            f"{other.quantity} has no finite value at an end of the front; choose another "
            f"quantity, or bound it with --keep"
        )
    # No constraint holds exactly at the optimum of the number that it bounds.
    for bound in (most + np.linspace(0.0, 1.0 - END_GAP, FRONT + 2)[1:] * (least - most)).tolist():
        both = bounded(f"{other.quantity}{sense}{bound!r}")
        best = search(
            both, [found[-1], last, *starting_points(both, min(BEGUN, len(begun)) - 1, seed)]
        )[0]
        found.append(best.x if np.isfinite(best.value) else last)  # which meets every bound
    values = np.stack([one.worst(np.array(found)) for one in costs], axis=1)
    measures = values ** [one.power for one in costs]
    # Steps of this size make values alike: comparing with a tolerance, three points could each be
    # beaten by another.
    steps = np.round(
        measures / (OPTIMUM_TOLERANCE * np.where(np.isfinite(measures), measures, 0.0).max(axis=0))
    )
    as_good = (steps[:, None] <= steps).all(axis=2)
    # Where one is as good in both, the other is no point of the front; of two alike the first one
    # is.
    beaten = (as_good & ~(as_good.T & np.tri(len(found), dtype=bool))).any(axis=0)
    return tuple(FrontPoint(values[k], read_only(found[k])) for k in np.flatnonzero(~beaten))
