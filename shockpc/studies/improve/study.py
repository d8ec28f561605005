"""The posture, strike or design with the smallest worst value of a number over some landings.

It is within ranges and constraints.
"""

import fnmatch
import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Annotated, NamedTuple

import numpy as np

from shockpc.core.spatial import Array, read_only
from shockpc.evaluation.column_values import proven_columns
from shockpc.evaluation.cost import ShockCost
from shockpc.evaluation.declare import study
from shockpc.evaluation.drive_ends import MOVED, End, at_drive_ends
from shockpc.evaluation.named_scenes import common_robot, named_scenes, with_default_landings
from shockpc.evaluation.profiles import profiles
from shockpc.evaluation.table import Table
from shockpc.evaluation.variations.kinds.posture import motion_range
from shockpc.evaluation.variations.scene_grid import scene_grid
from shockpc.evaluation.variations.vary import Vary, pairs
from shockpc.landing.resolve import landing_of, resolve
from shockpc.landing.scenes.scene import Scene
from shockpc.landing.scenes.scene_fields import Option
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
from shockpc.text.display import brief, shown_by
from shockpc.text.errors import ShockError, StudyError
from shockpc.text.printed import few
from shockpc.text.trace import Trace

USUAL_RANGE = 45.0
"""Default distance of the ranges of joints from the landing as given [deg]."""

AGREEING = 0.01
"""Share of the optimum by which a run may end worse and still count as one that agrees."""

FLAT = 0.05
"""Share of the optimum by which a value may be worse and still count as flat."""

SHARES = np.append(0.0, np.geomspace(1e-4, 1.0, 40))
"""Shares of the way to a bound at which a variable is evaluated.

Then it is evaluated at as many between two of them.
"""

ALONE = {"deg": 1.0, "m": 0.01}
"""By how much an angle or a length changes over the drives for both ends to be given [its unit]."""


class Flatness(NamedTuple):
    """The effect of a variable at the optimum.

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
        cost: what was improved.
        x: (n,) the variables at the optimum.
        before: proven profiles of the landings as they are given, by name.
        after: those at the optimum.
        values: the number in the worst of the landings as given, and at the optimum, proven [its
            unit].
        worst: name of the landing that is the worst at the optimum.
        active: the constraints that hold it there, and the landings that are as bad as the worst.
        variables: what each does.
        runs: target of each run, the best first, step by step, in double precision; NaN where the
            constraints do not hold.
        agreeing: how many runs end within 1 % of the optimum.
        seed: of the random points.
        chosen: what was asked for where nothing was said: a quantity, and what varies.
        ends: with all drives at the smallest inertias that what is known allows, and at the
            largest, or why there is none; empty where all are known exactly, or vary.
    """

    cost: ShockCost = field(repr=False)
    x: Array
    before: dict[str, ShockProfile] = field(repr=False)
    after: dict[str, ShockProfile] = field(repr=False)
    values: tuple[float, float]
    worst: str
    active: tuple[str, ...]
    variables: tuple[Flatness, ...]
    runs: tuple[Array, ...] = field(repr=False)
    agreeing: int
    seed: int
    chosen: tuple[str, ...]
    ends: Mapping[End, DriveEnd | ShockError] = field(default_factory=dict, repr=False)

    _repr_html_ = shown_by("studies.improve.report:improve_report")

    def __repr__(self) -> str:
        changed = []
        for variable in self.variables[:4]:
            changed.append(f"{variable.name} {variable.before:.4g} → {variable.after:.4g}")
        return brief(self, *changed)

    def moves(self, end: DriveEnd) -> bool:
        """True if the optimum with an end of the drives differs.

        The number there differs by more than 1 %, or a variable by 1 degree, 1 cm or 1 % of its
        range.
        """
        _, optimum = self.values
        for value in (end.there, end.best):
            if not math.isclose(optimum, value, rel_tol=MOVED):
                return True
        most = [
            ALONE.get(varied.unit, MOVED * np.ptp(varied.ends)) for varied in self.cost.variations
        ]
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
    improvement = _improvement(cost, runs, seed, tuple(chosen), trace)
    # Drives that vary have no ends.
    if any(varied.kind.of_drives for varied in cost.variations):
        return improvement
    x = improvement.x
    before, after = improvement.values
    cases = {name: (scene, robot) for name, scene in cost.scenes.items()}
    # Both ends of the drives judge this optimum, and find their own.
    as_modelled = DriveEnd(before, after, after, x)
    with trace.stage("ends of the drives"):
        ends = at_drive_ends(as_modelled, cases, lambda scenes: _at_end(cost_of(scenes), x))
    return replace(improvement, ends=ends)


def _improvement(
    cost: ShockCost, runs: Sequence[Run], seed: int, chosen: tuple[str, ...], trace: Trace
) -> Improvement:
    """The optimum of some runs, the best of which comes first, without the ends of the drives."""
    best = runs[0]
    # What makes no difference stays as given.
    x = _set_back(cost, best.x, best.value * (1.0 + OPTIMUM_TOLERANCE))
    # The runs are in double precision; the numbers that are reported have a proof.
    with trace.stage("proof"):
        before = profiles({name: (scene, cost.robot) for name, scene in cost.scenes.items()})
        after = profiles(cost.cases(x))
        value_before, _ = _proven(cost, before)
        value_after, worst = _proven(cost, after)
    return Improvement(
        cost=cost,
        x=read_only(x),
        before=before,
        after=after,
        values=(value_before, value_after),
        worst=worst,
        active=_holding(cost, x),
        variables=_variables(cost, x),
        runs=tuple(run.history for run in runs),
        agreeing=_agreeing(cost, runs),
        seed=seed,
        chosen=chosen,
    )


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


def _agreeing(cost: ShockCost, runs: Sequence[Run]) -> int:
    """The number of runs that end near the best one."""
    absolute = OPTIMUM_TOLERANCE * min(cost(cost.x0), 1.0)
    most = (1.0 + AGREEING) * runs[0].value + absolute
    return sum(run.value <= most for run in runs)


def _at_end(cost: ShockCost, x: Array) -> DriveEnd:
    """The improvement with other drives.

    Args:
        cost: with these drives.
        x: (n,) the optimum for the drives as modelled.
    """
    cases = {name: (scene, cost.robot) for name, scene in cost.scenes.items()}
    before, _ = _proven(cost, profiles(cases))
    there = math.nan
    if cost.feasible(x):
        there, _ = _proven(cost, profiles(cost.cases(x)))
    best = search(cost, [x, cost.x0])[0]
    if not np.isfinite(best.value):
        return DriveEnd(before, there, math.nan, np.full(len(x), np.nan))
    optimum = _set_back(cost, best.x, best.value * (1.0 + OPTIMUM_TOLERANCE))
    value, _ = _proven(cost, profiles(cost.cases(optimum)))
    return DriveEnd(before, there, value, read_only(optimum))


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


def _set_back(cost: ShockCost, x: Array, most: float) -> Array:
    """The optimum (n,), or the landing as given where that is as good.

    Otherwise, each variable that alone changes nothing is as given.

    Args:
        cost: of the points.
        x: (n,) the optimum.
        most: value of the cost up to which a point is as good.
    """
    every = np.ones((1, len(x)), dtype=bool)
    single = np.eye(len(x), dtype=bool) & (cost.given == cost.x0)
    for as_given in np.concatenate([every, single]):
        back = np.where(as_given, cost.x0, x)
        if cost.feasible(back) and cost(back) <= most:
            x = back
    return x


def _holding(cost: ShockCost, x: Array) -> tuple[str, ...]:
    """The constraints without slack at an optimum (n,), and the landings as bad as the worst.

    They hold it besides bounds.
    """
    (measures,) = cost.measured(x[None])
    texts = []
    for k in np.flatnonzero(cost.constraints & (measures < OPTIMUM_TOLERANCE)):
        texts.append(f"{cost.terms[k].text} ({cost.terms[k].landing})")
    bad = measures[~cost.constraints].max() * (1.0 - OPTIMUM_TOLERANCE)
    worst = np.flatnonzero(~cost.constraints & (measures >= bad))
    if len(worst) > 1:
        for k in worst:
            texts.append(f"{cost.terms[k].text} ({cost.terms[k].landing}) is as bad as the worst")
    return tuple(dict.fromkeys(text.replace(" ()", "") for text in texts))


def _variables(cost: ShockCost, x: Array) -> tuple[Flatness, ...]:
    """The effect of each variable at an optimum (n,)."""
    alone = np.eye(len(x), dtype=bool)
    as_given = cost.worst(np.where(alone, cost.given, x))
    set_back = np.where(np.isnan(cost.given), np.nan, as_given)
    flat_low, flat_high = _flat_range(cost, x)
    low, high = cost.bounds.T
    edge = OPTIMUM_TOLERANCE * (high - low)
    variables = []
    for k, name in enumerate(cost.names):
        bound = None
        if x[k] - low[k] <= edge[k]:
            bound = "minimum"
        elif high[k] - x[k] <= edge[k]:
            bound = "maximum"
        variables.append(
            Flatness(
                name=name,
                before=float(cost.given[k]),
                after=float(x[k]),
                bound=bound,
                set_back=float(set_back[k]),
                low=float(flat_low[k]),
                high=float(flat_high[k]),
            )
        )
    return tuple(variables)


def _flat_range(cost: ShockCost, x: Array) -> Array:
    """The smallest and largest value (2, n) of each variable alone that is nearly as good.

    With it the target is at most 5 % worse than at an optimum (n,).
    """
    n = len(x)
    alone = np.eye(n, dtype=bool)
    target, before = cost.worst(np.stack([x, cost.x0]))
    # Where the optimum is zero, or nearly, 5 % are those of the value before, if there was one.
    nearly_zero = target <= OPTIMUM_TOLERANCE * before < np.inf
    most = FLAT * (before if nearly_zero else target)
    way = cost.bounds.T - x
    shares = np.tile(SHARES, (2, n, 1))
    for _ in range(2):
        # A variable at some shares of its way to a bound, the others at the optimum: (2, n, k, n).
        steps = shares * way[..., None]
        X = x + steps[..., None] * alone[:, None]
        values = cost.worst(X.reshape(-1, n)).reshape(shares.shape)
        with np.errstate(invalid="ignore"):
            worse = ~(cost.power * (values - target) <= most)
        # The last share before the first that is worse, and that one.
        beyond = np.logical_or.accumulate(worse, axis=2)
        near = np.where(beyond, 0.0, shares).max(axis=2)
        far = np.where(beyond, shares, shares[..., -1:]).min(axis=2)
        shares = np.linspace(near, far, len(SHARES), axis=2)
    return np.asarray(x + near * way)


def _proven(cost: ShockCost, landed: Mapping[str, ShockProfile]) -> tuple[float, str]:
    """The worst proven value over landings, and the name of the landing."""
    terms = [term for term in cost.terms if term.limit is None]
    values = []
    for term in terms:
        values.append(proven_columns(landed[term.landing], [term.column])[term.column.name])
    k = int(cost.column.selection.worse(np.array(values)).argmax())
    return values[k], terms[k].landing
