"""The point with the smallest worst value of a cost: many runs of SLSQP in lockstep.

The minimum of the maximum of many smooth functions f_j(x) is the minimum t with f_j(x) <= t: a
smooth program, for SLSQP (Kraft 1988). Its runs end in local optima, which is why they begin at
many random points.
"""

import contextlib
import functools
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.core.threads import one_thread
from shockpc.evaluation.cost import SLACK, ShockCost
from shockpc.studies.improve.lockstep import in_lockstep

RUNS, ROUGH, SLOW = 80, 36, 4
"""Runs by default; where derivatives are differences; and where each point needs a separate
landing.
"""

TRIED = 20
"""Random points of which a run begins at the best."""

STEPS, CHANGE = 100, 1e-10
"""Steps of a run at most, and the change of the objective by a step, relative to the start, at
which it ends.
"""

SHORTENED, STUCK = 10, 5
"""Points of a step that was shortened as often as SLSQP does, and such steps in succession at which
a run ends: its constraints, as
they are linearised, contradict one another, and it would go on like this for all its steps.
"""

OPTIMUM_TOLERANCE = 1e-6
"""Share of a range, or of a scale, within which a bound or a constraint holds an optimum, and
within which landings are as bad.
"""


class _StuckError(Exception):
    """Ends a run that no longer gets on."""


class Run(NamedTuple):
    """One run of SLSQP.

    Attributes:
        x: (n,) the best point; the last one where the constraints hold nowhere.
        value: the measure there; infinite where the constraints do not hold.
        history: (k,) the target at each step; NaN where the constraints do not hold.
    """

    x: Array
    value: float
    history: Array


def search(cost: ShockCost, starts: Sequence[Array]) -> list[Run]:
    """Runs from points (n,), the best one first."""
    # here, as threads are limited of those libraries alone that are loaded
    from scipy.optimize import minimize

    runs = [functools.partial(_run, cost, start, minimize) for start in starts]
    with one_thread(len(cost.terms) * len(cost.x0)):
        found = in_lockstep(runs, lambda X: list(zip(*cost.linearized(X), strict=True)))
    return sorted(found, key=lambda run: run.value)


def _run(
    cost: ShockCost,
    start: Array,
    minimize: Callable[..., Any],
    ask: Callable[[Array], tuple[Array, Array]],
) -> Run:
    low, width, n, constraint = (
        cost.bounds[:, 0],
        np.ptp(cost.bounds, axis=1),
        len(start),
        cost.constraints,
    )
    measured = ask(start)[0]
    # what has no value has no slopes either, which a run would look for in vain
    if not np.isfinite(measured).all():
        return Run(start, np.inf, np.array([np.nan]))
    worst, steps = float(measured[~constraint].max()), list[tuple[float, Array]]()
    scale = np.where(constraint, 1.0, -1.0 / (worst or 1.0))

    @functools.lru_cache(2)
    def at(shares: bytes) -> tuple[float, Array, Array]:
        """The measure, inf where constraints do not hold; and what is at least zero for a target of
        zero, with its derivatives.
        """
        measures, slopes = ask(low + width * np.frombuffer(shares))
        value = (
            float(measures[~constraint].max()) if (measures[constraint] >= -SLACK).all() else np.inf
        )
        return (
            value,
            np.maximum(scale * measures, -1e6),
            np.column_stack([scale[:, None] * slopes * width, ~constraint]),
        )

    passed, shortened = 0, 0

    def note(z: Array) -> None:
        nonlocal passed, shortened
        steps.append((at(z[:n].tobytes())[0], low + width * z[:n]))
        asked = at.cache_info().misses
        shortened = shortened + 1 if asked - passed >= SHORTENED else 0
        passed = asked
        if shortened == STUCK:
            raise _StuckError

    def slack(z: Array) -> Array:
        return np.asarray(at(z[:n].tobytes())[1] + ~constraint * z[n])

    first, unit = np.append((start - low) / width, 1.0), np.append(np.zeros(n), 1.0)
    note(first)
    with contextlib.suppress(_StuckError):
        minimize(
            lambda z: z[n],
            first,
            jac=lambda z: unit,
            method="SLSQP",
            bounds=[(0.0, 1.0)] * n + [(None, None)],
            constraints={"type": "ineq", "fun": slack, "jac": lambda z: at(z[:n].tobytes())[2]},
            callback=note,
            options={"maxiter": STEPS, "ftol": CHANGE},
        )
    value, x = min(reversed(steps), key=lambda step: step[0])
    values = np.array([value for value, _ in steps])
    with np.errstate(divide="ignore"):
        return Run(x, value, np.where(np.isfinite(values), values, np.nan) ** cost.power)


def starting_points(cost: ShockCost, count: int | None, seed: int) -> list[Array]:
    """The landing as given, and random points, each the best of some: the least bad one of those
    nearest to all constraints.
    """
    low, width = cost.bounds[:, 0], np.ptp(cost.bounds, axis=1)
    if count is None:
        count = SLOW if cost.slow else RUNS if cost.exact else ROUGH
    tried = low + width * np.random.default_rng(seed).random((max(count, 1), TRIED, len(low)))
    measures = cost.measured(tried.reshape(-1, len(low))).reshape(*tried.shape[:2], -1)
    worst, missed = (
        measures[..., ~cost.constraints].max(axis=-1),
        -measures[..., cost.constraints].min(axis=-1, initial=0.0),
    )
    return [
        cost.x0,
        *tried[
            np.arange(count), np.lexsort((worst, np.maximum(missed, OPTIMUM_TOLERANCE)))[:count, 0]
        ],
    ]
