"""The posture, strike or design with the least worst value of a number over some landings, within ranges and constraints.

The least of the greatest of many smooth functions f_j(x) is the least t with f_j(x) <= t, a smooth program that SLSQP (Kraft 1988)
solves from the best of many random points; the best of its runs go on to their ends. Where two numbers are to be
small, one is made small for each of several bounds of the other.
"""

import functools
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

import numpy as np

from shockpc.core.spatial import Array, read_only
from shockpc.evaluation.columns import proven_columns
from shockpc.evaluation.cost import SLACK, ShockCost
from shockpc.evaluation.evaluate import profiles
from shockpc.evaluation.landings import common_robot, named_scenes
from shockpc.evaluation.lockstep import in_lockstep
from shockpc.evaluation.table import Table
from shockpc.evaluation.variation import Vary, pairs
from shockpc.evaluation.varied_scene import scene_grid
from shockpc.landing.record import Option
from shockpc.landing.scene import Scene
from shockpc.quantities.profile import ShockProfile
from shockpc.robot.landmarks import is_imu, sensors
from shockpc.robot.robot import Robot
from shockpc.studies.declare import study
from shockpc.text.errors import StudyError
from shockpc.text.printed import few
from shockpc.text.trace import Trace

SAMPLE, FEW = 1024, 128
"""Points that are looked at before the best of them are improved; and how many where each needs a landing of its own."""

APART = 0.1
"""Least distance of starts, as a share of the ranges, in the variable in which they differ most."""

PER_VARIABLE, ROUGH, SLOW = 15, 3, 4
"""Runs by default for each variable; where derivatives are differences; and in all where each point needs a landing of its own."""

COARSE, FINE, BEST = (40, 1e-6), (60, 1e-9), 4
"""Steps of a run at most, and the change of the objective relative to its value at the start at which it ends: of all, then of the
best ones, which go on from where they are; and how many these are."""

STALLED = 5
"""Steps without a change of the objective after which a run ends: where heights have a kink, nothing else ends it."""

HELD = 1e-6
"""Share of a range, or of a scale, within which a bound or a constraint holds an optimum, and within which landings are as bad."""

AGREEING = 0.01
"""How much worse than the optimum, as a share of it, a run may end that counts as one that agrees."""

FLAT = 0.05
"""How much worse than the optimum, as a share of it, a value may be that counts as flat."""

SHARES = np.append(0.0, np.geomspace(1e-4, 1.0, 40))
"""Shares of the way to a bound at which a variable is looked at."""

FRONT, NEAR = 9, 1e-5
"""Points between the ends of a front; and how far from the second number's optimum its end is, as a share of the front."""


class Flatness(NamedTuple):
    """What a variable does at the optimum.

    Attributes:
        name: heading, with its unit.
        before: its value before; NaN if it has none, or not a single one.
        after: its value at the optimum.
        bound: which bound it is held by, "least" or "greatest"; None if by none.
        alone: the target if it alone is set back; NaN if there is no such landing.
        low: least value of it alone with which the target is at most 5 % worse.
        high: greatest.
    """

    name: str
    before: float
    after: float
    bound: str | None
    alone: float
    low: float
    high: float


class FrontPoint(NamedTuple):
    """A point of the front of two numbers: their worst values (2,), in double precision, and the variables (n,)."""

    values: Array
    x: Array


@dataclass(frozen=True, eq=False)
class Improvement:
    """An optimum.

    Attributes:
        costs: what was improved, of each quantity.
        x: (n,) the variables at the optimum.
        before: proven profiles of the landings as they are given, by name.
        after: those at the optimum.
        values: the numbers, each the worst of the landings as given and at the optimum, proven [their units].
        worst: name of the landing that is the worst at the optimum.
        held: the constraints that hold it there, and the landings that are as bad as the worst.
        variables: what each does.
        runs: target of each run, the best first, step by step, in double precision; NaN where the constraints do not hold.
        agreeing: how many runs end within 1 % of the optimum.
        front: of two numbers, the first one least first; empty for one.
        seed: of the random points.
        chosen: what was asked for where nothing was said: a quantity, and what varies.
    """

    costs: tuple[ShockCost, ...] = field(repr=False)
    x: Array
    before: dict[str, ShockProfile] = field(repr=False)
    after: dict[str, ShockProfile] = field(repr=False)
    values: tuple[tuple[float, ...], ...]
    worst: str
    held: tuple[str, ...]
    variables: tuple[Flatness, ...]
    runs: tuple[Array, ...] = field(repr=False)
    agreeing: int
    front: tuple[FrontPoint, ...]
    seed: int
    chosen: tuple[str, ...]

    @property
    def table(self) -> Table:
        """A row for each variable."""
        header = ("variable", "as given", "optimum", "at bound", "target if set back", "5 % from", "5 % to")
        return Table.of_rows(header, self.variables)


@study(
    "shockpc improve anymal_b --contact LF_FOOT --at imu_link --vary LF_HFE=0:70 --vary LF_KFE=-110:-20 --over strike-angle=0:20:3",
    "shockpc improve go2 --contact FL_foot --at imu --vary FL_calf_joint=-130:-60 --keep 'joint_impulse@FL_calf_joint<=2'",
    more=(
        "A robot without --contact lands on each of its feet alone. What counts is the worst landing. The numbers as given and at "
        "the optimum are proven, unless friction or a contact stiffness counts; that no better point exists is not. --out writes "
        "the scenes of the optimum."
    ),
)
def improve(
    landings: Scene | Mapping[str, Scene],
    quantities: Annotated[
        str | Sequence[str],
        Option(
            "A number: a quantity (shockpc quantities lists them) at a place, of several places the worst; by default the shock at "
            "the points of --at, at the IMU, or at the trunk's centre of mass. Twice for the front between two.",
            "Question",
            "QUANTITY@PLACES",
            "quantity",
        ),
    ] = (),
    robot: Robot | None = None,
    *,
    vary: Annotated[
        Vary,
        Option(
            "What may change, and its range a:b, of masses and places factors ax:bx: joints [deg; m if prismatic], base-pitch, "
            "strike-angle, mass:LINK, place:JOINT and what else a sweep varies. A glob with a range is one value for all of its "
            "joints; without one, each joint has its limits. By default the joints that carry what strikes.",
            "Search",
            "NAME=LOW:HIGH",
        ),
    ] = (),
    over: Annotated[
        Vary,
        Option("Each landing with all of these values, a:b:n or a,b,c, such as strike-angle=-20:20:5.", "Search", "NAME=VALUES"),
    ] = (),
    keep: Annotated[
        Sequence[str], Option("A constraint, such as 'joint_impulse@*_KFE<=2', or >=.", "Search", "QUANTITY@PLACES<=LIMIT")
    ] = (),
    any_ground: Annotated[
        bool, Option("Allow landings that flat ground does not: it would pull a contact, or meet another link first.", "Search")
    ] = False,
    starts: Annotated[
        int | None,
        Option(
            f"Runs from points of a sample, besides that from the landing as given; by default {PER_VARIABLE} for each variable, "
            f"{ROUGH} where derivatives are differences, and {SLOW} in all where each point needs a landing of its own.",
            "Search",
            "N",
            least=0.0,
        ),
    ] = None,
    seed: Annotated[int, Option("Seed of the sample.", "Search", "N", least=0.0)] = 0,
    trace: Trace | None = None,
) -> Improvement:
    """Find where a number is the least bad in the worst of some landings.

    Of two quantities the optimum is that of the first.

    Args:
        landings: one landing, or landings of one robot by name.
        robot: the scenes' robot, if it is loaded already.
        trace: collects what each stage cost.

    Raises:
        StudyError: no point meets the constraints, a quantity is not to be less or greater, or there are more than two.
        ShockError: as for `ShockCost`.
    """
    trace = trace or Trace()
    scenes = named_scenes(landings)
    robot = robot or common_robot(scenes)
    chosen = list[str]()
    if not quantities:
        quantities = _usual_quantities(robot, scenes.values())
        if not any(scene.point for scene in scenes.values()):
            chosen.append(f"quantity {', '.join(quantities)}")
    if not vary and robot.loops:
        raise StudyError(
            f"loops of {robot.label} move its joints together; name what may change with --vary, such as a motor's joint"
        )
    if not vary:
        vary = dict.fromkeys(_carrying(robot, scenes.values()))
        chosen.append(f"variables {few(list(vary), 12)}, the joints that carry what strikes, within their limits")
    scenes = {
        label.strip(): one for name, scene in scenes.items() for label, one in scene_grid(name, scene, robot, pairs(over)).items()
    }
    make = functools.partial(ShockCost, scenes, variables=vary, robot=robot, ground=not any_ground)
    with trace.stage("landings"):
        costs = tuple(make(text, keep=keep) for text in ([quantities] if isinstance(quantities, str) else quantities))
    if len(costs) > 2:
        raise StudyError(f"improve takes one quantity or two, got {len(costs)}; --keep bounds others")
    for cost in costs:
        if cost.column.selection.quantity.worse == "neither":
            raise StudyError(
                f"{cost.column.title} is neither better nor worse if it is less; choose another quantity, or --keep it"
            )
    cost, *others = costs
    with trace.stage("sample"):
        begun = _starts(cost, starts, seed)
    with trace.stage("runs"):
        runs = sorted(_runs(cost, begun, COARSE), key=lambda run: run.value)
        further = _runs(cost, [run.x for run in runs[:BEST]])
        runs[:BEST] = [b._replace(history=np.append(a.history, b.history)) for a, b in zip(runs, further, strict=False)]
        runs.sort(key=lambda run: run.value)
    best = runs[0]
    if not np.isfinite(best.value):
        raise StudyError(_refusal(cost, runs))
    agreeing = sum(math.sqrt(run.value) <= (1.0 + AGREEING) * math.sqrt(best.value) + HELD for run in runs)
    with trace.stage("front"):
        front = _front(costs, best.x, begun, lambda limit: make(cost.quantity, keep=[*keep, limit])) if others else ()
    with trace.stage("proof"):
        cases = cost.cases(best.x)
        before = dict(zip(cost.scenes, profiles({name: (scene, robot) for name, scene in cost.scenes.items()}), strict=True))
        after = dict(zip(cases, profiles(cases), strict=True))
        values = tuple(tuple(_proven(one, found)[0] for found in (before, after)) for one in costs)
    return Improvement(
        costs, read_only(best.x), before, after, values, _proven(cost, after)[1], _holding(cost, best.x),
        _variables(cost, best.x), tuple(run.history for run in runs), agreeing, front, seed, tuple(chosen),
    )  # fmt: skip


def _usual_quantities(robot: Robot, scenes: Iterable[Scene]) -> tuple[str, ...]:
    """The shock at the points of the scenes; without any at the robot's IMU, or at the trunk's centre of mass."""
    friction = "_friction" if any(scene.friction is not None for scene in scenes) else ""
    points = [point.label for scene in scenes for point in scene.point] or list(filter(is_imu, sensors(robot)))[:1]
    usual = [f"shock{friction}@{name}" for name in dict.fromkeys(points)]
    return tuple(usual or [f"shock_com{friction}@{robot.bodies[0].name}"])


def _carrying(robot: Robot, scenes: Iterable[Scene]) -> list[str]:
    """The joints between the trunk and what strikes."""
    struck = [robot.frame(contact.frame).body for scene in scenes for contact in scene.contact]
    carrying: np.ndarray = np.any(robot.supports[struck], axis=0)
    return [joint.name for joint in robot.independent_joints if carrying[joint.v].all()]


class _Run(NamedTuple):
    """One run of SLSQP.

    Attributes:
        x: (n,) the best point; the last one where the constraints hold nowhere.
        value: the measure there; infinite where the constraints do not hold.
        history: (k,) the target at each step.
    """

    x: Array
    value: float
    history: Array


def _runs(cost: ShockCost, starts: Sequence[Array], how: tuple[int, float] = FINE) -> list[_Run]:
    """Runs of SLSQP from points (n,), in shares of the ranges. Args: how, `COARSE` or `FINE`."""
    return in_lockstep(
        [functools.partial(_run, cost, start, *how) for start in starts], lambda X: list(zip(*cost.linearized(X), strict=True))
    )


def _run(cost: ShockCost, start: Array, most: int, change: float, ask: Callable[[Array], tuple[Array, Array]]) -> _Run:
    from scipy.optimize import Bounds, minimize

    low, width, n, held = cost.bounds[:, 0], np.ptp(cost.bounds, axis=1), len(start), cost.held
    steps = list[tuple[float, float, Array]]()

    @functools.lru_cache(2)
    def at(shares: bytes) -> tuple[Array, Array]:
        return ask(low + width * np.frombuffer(shares))

    def constraints(z: Array) -> Array:
        measures = np.minimum(at(z[:n].tobytes())[0], 1e6 * size)
        return np.where(held, measures, z[n] - measures / size)

    def jacobian(z: Array) -> Array:
        slopes = at(z[:n].tobytes())[1] * width
        return np.column_stack([np.where(held[:, None], slopes, -slopes / size), ~held])

    def note(z: Array) -> None:
        measures, _ = at(z[:n].tobytes())
        value = float(measures[~held].max()) if (measures[held] >= -SLACK).all() else np.inf
        steps.append((value, float(z[n]), low + width * z[:n]))
        if len(steps) > STALLED and np.ptp([level for _, level, _ in steps[-STALLED:]]) <= change:
            raise StopIteration

    first, unit = np.append((start - low) / width, 1.0), np.append(np.zeros(n), 1.0)
    worst = float(at(first[:n].tobytes())[0][~held].max())
    size = worst if 0.0 < worst < np.inf else 1.0
    note(first)
    minimize(
        lambda z: z[n],
        first,
        jac=lambda z: unit,
        method="SLSQP",
        bounds=Bounds(np.append(np.zeros(n), -np.inf), np.append(np.ones(n), np.inf)),
        constraints={"type": "ineq", "fun": constraints, "jac": jacobian},
        callback=note,
        options={"maxiter": most, "ftol": change},
    )
    value, _, x = min(reversed(steps), key=lambda step: step[0])
    values = np.array([value for value, _, _ in steps])
    return _Run(x, value, np.where(np.isfinite(values), _target(cost, values), np.nan))


def _worst(cost: ShockCost, X: Array) -> Array:
    """The worst measure (m,) at points (m, n)."""
    return np.asarray(cost.measured(X)[:, ~cost.held].max(axis=1))


def _target(cost: ShockCost, measures: Array) -> Array:
    """The quantity itself from its measures."""
    with np.errstate(divide="ignore"):
        return np.asarray(measures ** (1.0 / cost.power))


def _starts(cost: ShockCost, count: int | None, seed: int) -> list[Array]:
    """The landing as given, and the best of random points that are apart, those first that meet the constraints."""
    low, width = cost.bounds[:, 0], np.ptp(cost.bounds, axis=1)
    usual = SLOW if cost.slow else len(low) * (PER_VARIABLE if cost.exact else ROUGH)
    count = usual if count is None else count
    share = np.random.default_rng(seed).random((FEW if cost.slow else SAMPLE, len(low)))
    measures = cost.measured(low + width * share)
    worst, slack = measures[:, ~cost.held].max(axis=1), measures[:, cost.held].min(axis=1, initial=0.0)
    order = np.argsort(worst, kind="stable")[: max(len(share) // 8, 2 * count)]
    order = order[np.argsort(np.maximum(-slack[order], HELD), kind="stable")]
    chosen, candidates = ((cost.x0 - low) / width)[None], share[order[np.isfinite(worst[order])]]
    while len(chosen) <= count and len(candidates := candidates[np.abs(candidates - chosen[-1]).max(axis=1) > APART]):
        chosen = np.concatenate([chosen, candidates[:1]])
    return list(low + width * chosen)


def _refusal(cost: ShockCost, runs: Sequence[_Run]) -> str:
    """Why no run reached a point that counts."""
    measures = cost.measured(np.array([run.x for run in runs]))
    nearest = measures[measures[:, cost.held].min(axis=1, initial=0.0).argmax()]
    if without := dict.fromkeys(cost.terms[k].column.name for k in np.flatnonzero(np.isinf(nearest))):
        return f"{few(list(without), 4)} has no value at the best point that was found; name other places, or change the ranges"
    missed = dict.fromkeys(cost.terms[k].text for k in np.flatnonzero(cost.held & (nearest < 0.0)))
    return (
        f"no point meets the constraints; the one that comes nearest misses: {few(list(missed), 4)}. Widen a range, or leave a "
        "constraint out"
    )


def _holding(cost: ShockCost, x: Array) -> tuple[str, ...]:
    """What holds an optimum besides bounds: constraints without slack, and landings that are as bad as the worst."""
    (measures,) = cost.measured(x[None])
    held = [cost.terms[k] for k in np.flatnonzero(cost.held & (measures < HELD))]
    worst = [cost.terms[k] for k in np.flatnonzero(~cost.held & (measures >= measures[~cost.held].max() * (1.0 - HELD)))]
    texts = [(term, "") for term in held] + [(term, " is as bad") for term in worst if len(worst) > 1]
    return tuple(dict.fromkeys(f"{term.text} ({term.landing}){end}".replace(" ()", "") for term, end in texts))


def _variables(cost: ShockCost, x: Array) -> tuple[Flatness, ...]:
    """What each variable does at an optimum."""
    best, start = _worst(cost, np.stack([x, cost.x0]))
    target, given = _target(cost, np.array([best, start]))
    # Where the optimum is zero, or nearly, 5 % are those of the value before.
    most, sign, found = FLAT * float(target if best > HELD * start else given), np.sign(cost.power), list[Flatness]()
    for k, (low, high) in enumerate(cost.bounds):
        X = np.repeat(x[None], 2 * len(SHARES) + 1, axis=0)
        X[:-1, k] = x[k] + np.outer((low - x[k], high - x[k]), SHARES).ravel()
        X[-1, k] = cost.x0[k]
        values = _target(cost, _worst(cost, X))
        worse = np.clip(sign * (values[:-1] - target) / most, None, 1e6).reshape(2, -1)
        ends, edge = list[float](), HELD * (high - low)
        for side, bound in zip(worse, (low, high), strict=True):
            beyond = int(np.argmax(side > 1.0))  # 0 if it is nowhere that much worse
            near = slice(beyond - 1, beyond + 1)
            ends.append(float(x[k] + (bound - x[k]) * (np.interp(1.0, side[near], SHARES[near]) if beyond else 1.0)))
        bound = "least" if x[k] - low <= edge else "greatest" if high - x[k] <= edge else None
        found.append(Flatness(cost.names[k], float(cost.given[k]), float(x[k]), bound, float(values[-1]), *ends))
    return tuple(found)


def _proven(cost: ShockCost, found: Mapping[str, ShockProfile]) -> tuple[float, str]:
    """The worst proven value over landings, and the name of the landing."""
    terms = [term for term in cost.terms if term.limit is None]
    values = [proven_columns(found[term.landing], [term.column])[term.column.name] for term in terms]
    k = int(cost.column.selection.worse(np.array(values)).argmax())
    return values[k], terms[k].landing


def _front(
    costs: Sequence[ShockCost], first: Array, points: Sequence[Array], bounded: Callable[[str], ShockCost]
) -> tuple[FrontPoint, ...]:
    """Points between the optimum of the first quantity and that of the second: the first least for bounds of the second.

    Args:
        costs: of both.
        first: (n,) the optimum of the first.
        points: where the runs for the second begin.
        bounded: gives the cost of the first with one constraint more.
    """
    (_, other), sense = costs, "<=" if costs[1].power > 0.0 else ">="
    last = min(_runs(other, [*points, first]), key=lambda run: run.value).x
    found = [first]
    most, least = _target(other, _worst(other, np.stack([first, last])))
    # No constraint holds exactly at the optimum of its own number.
    for bound in (most + np.linspace(0.0, 1.0 - NEAR, FRONT + 2)[1:] * (least - most)).tolist():
        best = min(
            _runs(bounded(f"{other.quantity}{sense}{bound!r}"), [found[-1], last, (first + last) / 2.0]), key=lambda run: run.value
        )
        found += [best.x] if np.isfinite(best.value) else []
    values = np.stack([_target(one, _worst(one, np.array(found))) for one in costs], axis=1)
    return tuple(FrontPoint(*point) for point in zip(values, map(read_only, found), strict=True))
