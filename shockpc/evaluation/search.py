"""The point with the least worst value of a cost: many runs of SLSQP in lockstep, the best of which go on to their ends.

The least of the greatest of many smooth functions f_j(x) is the least t with f_j(x) <= t, a smooth program that SLSQP solves (Kraft
1988). Its runs end in local optima, which is why they begin at many random points.
"""

import functools
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.evaluation.cost import SLACK, ShockCost
from shockpc.evaluation.lockstep import in_lockstep

SAMPLE, FEW = 1024, 128
"""Points that are looked at before the best of them are improved; and how many where each needs a landing of its own."""

APART = 0.02
"""Least distance of starts, as a share of the ranges, in the variable in which they differ most."""

PER_VARIABLE, ROUGH, SLOW = 15, 3, 4
"""Runs by default for each variable; where derivatives are differences; and in all where each point needs a landing of its own."""

COARSE, FINE, BEST, AGAIN = (40, 1e-6), (60, 1e-9), 4, 5
"""Steps of a run at most, and the change of the objective relative to its value at the start at which it ends: of all, then of the
best ones, which go on from where they are; how many these are; and how often they go on at most, as long as the best one gains."""

STALLED = 5
"""Steps without a change of the objective after which a run ends: where heights have a kink, nothing else ends it."""

HELD = 1e-6
"""Share of a range, or of a scale, within which a bound or a constraint holds an optimum, and within which landings are as bad."""


class Run(NamedTuple):
    """One run of SLSQP.

    Attributes:
        x: (n,) the best point; the last one where the constraints hold nowhere.
        value: the measure there; infinite where the constraints do not hold.
        history: (k,) the target at each step.
    """

    x: Array
    value: float
    history: Array


def by_value(run: Run) -> float:
    """What runs are ordered by."""
    return run.value


def runs_from(cost: ShockCost, starts: Sequence[Array], how: tuple[int, float] = FINE) -> list[Run]:
    """Runs of SLSQP from points (n,), in shares of the ranges. Args: how, `COARSE` or `FINE`."""
    return in_lockstep(
        [functools.partial(_run, cost, start, *how) for start in starts], lambda X: list(zip(*cost.linearized(X), strict=True))
    )


def _run(cost: ShockCost, start: Array, most: int, change: float, ask: Callable[[Array], tuple[Array, Array]]) -> Run:
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
    return Run(x, value, np.where(np.isfinite(values), quantity_of(cost, values), np.nan))


def worst_measure(cost: ShockCost, X: Array) -> Array:
    """The worst measure (m,) at points (m, n)."""
    return np.asarray(cost.measured(X)[:, ~cost.held].max(axis=1))


def quantity_of(cost: ShockCost, measures: Array) -> Array:
    """The quantity itself from its measures."""
    with np.errstate(divide="ignore"):
        return np.asarray(measures ** (1.0 / cost.power))


def starting_points(cost: ShockCost, count: int | None, seed: int) -> list[Array]:
    """The landing as given, and the best of random points that are apart, those first that meet the constraints."""
    low, width = cost.bounds[:, 0], np.ptp(cost.bounds, axis=1)
    usual = SLOW if cost.slow else len(low) * (PER_VARIABLE if cost.exact else ROUGH)
    count = usual if count is None else count
    share = np.random.default_rng(seed).random((FEW if cost.slow else SAMPLE, len(low)))
    measures = cost.measured(low + width * share)
    worst, slack = measures[:, ~cost.held].max(axis=1), measures[:, cost.held].min(axis=1, initial=0.0)
    first = np.lexsort((worst, np.maximum(-slack, HELD)))[:1]  # the best one that meets the constraints
    order = np.argsort(worst, kind="stable")[: max(len(share) // 8, 2 * count)]
    order = np.concatenate([first, order[np.argsort(np.maximum(-slack[order], HELD), kind="stable")]])
    chosen, candidates = list[Array](), share[order[np.isfinite(worst[order])]]
    while len(chosen) < count and len(candidates):
        chosen.append(candidates[0])
        candidates = candidates[np.abs(candidates - candidates[0]).max(axis=1) > APART]
    return [cost.x0, *(low + width * point for point in chosen)]


def search(cost: ShockCost, begun: Sequence[Array]) -> list[Run]:
    """Runs from some points, the best one first; the best ones go on as long as the first of them gains."""
    found = sorted(runs_from(cost, begun, COARSE), key=by_value)
    for _ in range(AGAIN):
        before = found[0].value
        further = runs_from(cost, [run.x for run in found[:BEST]])
        found[:BEST] = [
            min(b, a, key=by_value)._replace(history=np.append(a.history, b.history)) for a, b in zip(found, further, strict=False)
        ]
        found.sort(key=by_value)
        if not found[0].value < before * (1.0 - HELD):
            break
    return found
