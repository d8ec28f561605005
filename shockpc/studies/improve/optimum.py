"""What is said of the best point that runs have found: proven numbers, and what holds it there."""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from shockpc.core.spatial import Array, read_only
from shockpc.evaluation.column_values import proven_columns
from shockpc.evaluation.cost import ShockCost
from shockpc.evaluation.profiles import profiles
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.studies.improve.improvement import DriveEnd, Flatness, Improvement
from shockpc.studies.improve.search import OPTIMUM_TOLERANCE, Run, search
from shockpc.text.trace import Trace

AGREEING = 0.01
"""Share of the optimum by which a run may end worse and still count as one that agrees."""

FLAT = 0.05
"""Share of the optimum by which a value may be worse and still count as flat."""

SHARES = np.append(0.0, np.geomspace(1e-4, 1.0, 40))
"""Shares of the way to a bound at which a variable is evaluated.

Then it is evaluated at as many between two of them.
"""


def improvement_of(
    cost: ShockCost, runs: Sequence[Run], seed: int, chosen: tuple[str, ...], trace: Trace
) -> Improvement:
    """The result of some runs, without the ends of the drives.

    Args:
        cost: what was improved.
        runs: the best first.
        seed: of their random points.
        chosen: what was asked for where nothing was said.
        trace: collects what the proof cost.
    """
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


def drive_end(cost: ShockCost, x: Array) -> DriveEnd:
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


def _agreeing(cost: ShockCost, runs: Sequence[Run]) -> int:
    """The number of runs that end near the best one."""
    absolute = OPTIMUM_TOLERANCE * min(cost(cost.x0), 1.0)
    most = (1.0 + AGREEING) * runs[0].value + absolute
    return sum(run.value <= most for run in runs)


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
