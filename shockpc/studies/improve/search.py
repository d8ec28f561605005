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
"""Default numbers of runs.

The second is for derivatives that are differences, the third where each point needs a separate
landing.
"""

TRIED = 20
"""Random points of which a run begins at the best."""

STEPS, CHANGE = 100, 1e-10
"""Largest number of steps of a run, and the change of the objective by a step at which it ends.

The change is relative to the start.
"""

SHORTENED, STUCK = 10, 5
"""Points of a step that was shortened as often as SLSQP does, and such steps that end a run.

The steps are in succession: the constraints of the run, as they are linearised, contradict one
another, and it would go on like this for all its steps.
"""

LOWEST_SLACK = -1e6
"""Lowest slack of a constraint of SLSQP, which does not converge with infinite ones [1]."""

OPTIMUM_TOLERANCE = 1e-6
"""Share of a range, or of a scale, within which a bound or a constraint holds an optimum.

Landings within it are as bad as the worst.
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

    def answers(X: Array) -> list[tuple[Array, Array]]:
        measures, slopes = cost.linearized(X)
        return list(zip(measures, slopes, strict=True))

    with one_thread(len(cost.terms) * len(cost.x0)):
        results = in_lockstep(runs, answers)
    return sorted(results, key=lambda run: run.value)


Ask = Callable[[Array], tuple[Array, Array]]
"""Gives the measures (K,) of a point (n,) and their derivatives (K, n)."""


def _run(cost: ShockCost, start: Array, minimize: Callable[..., Any], ask: Ask) -> Run:
    """The run from a point (n,). Args: minimize, that of SciPy."""
    measures, _ = ask(start)
    # What has no value has no slopes either, which a run would look for in vain.
    if not np.isfinite(measures).all():
        return Run(start, np.inf, np.array([np.nan]))
    program = _Program(cost, ask, worst=float(measures[~cost.constraints].max()))
    n = len(start)
    of_t = np.append(np.zeros(n), 1.0)
    first = np.append((start - program.low) / program.width, 1.0)
    program.note(first)
    with contextlib.suppress(_StuckError):
        minimize(
            lambda z: z[n],
            first,
            jac=lambda z: of_t,
            method="SLSQP",
            bounds=[(0.0, 1.0)] * n + [(None, None)],
            constraints={"type": "ineq", "fun": program.slack, "jac": program.slopes},
            callback=program.note,
            options={"maxiter": STEPS, "ftol": CHANGE},
        )
    # The last one of equal steps.
    value, x = min(reversed(program.steps), key=lambda step: step[0])
    values = np.array([value for value, _ in program.steps])
    values[~np.isfinite(values)] = np.nan
    with np.errstate(divide="ignore"):
        return Run(x, value, values**cost.power)


class _Point(NamedTuple):
    """The values that SLSQP takes at a point.

    Attributes:
        value: the measure; infinite where constraints do not hold.
        slack: (K,) what is at least zero, for t = 0.
        slopes: (K, n + 1) its derivatives by the unknowns.
    """

    value: float
    slack: Array
    slopes: Array


class _Program:
    """The smooth program of one run: the least t ≥ f_j(x), with constraints g_k(x) ≥ 0.

    The unknowns z = (shares, t) are the shares (n,) of the ranges, and the target t as a share of
    the worst measure at the start.

    Attributes:
        low: (n,) lower bounds.
        width: (n,) of the ranges.
        steps: value and point of each step.
    """

    def __init__(self, cost: ShockCost, ask: Ask, worst: float):
        self.low = cost.bounds[:, 0]
        self.width = np.ptp(cost.bounds, axis=1)
        self.steps: list[tuple[float, Array]] = []
        self._constraint = cost.constraints
        # t − f_j / worst ≥ 0,  g_k ≥ 0
        self._scale = np.where(cost.constraints, 1.0, -1.0 / (worst or 1.0))
        self._ask = ask
        self._at = functools.lru_cache(2)(self._compute)
        self._asked = 0
        self._shortened = 0

    def _compute(self, shares: bytes) -> _Point:
        """A point by its shares (n,), as bytes."""
        measures, slopes = self._ask(self.low + self.width * np.frombuffer(shares))
        value = np.inf
        if (measures[self._constraint] >= -SLACK).all():
            value = float(measures[~self._constraint].max())
        slack = np.maximum(self._scale * measures, LOWEST_SLACK)
        by_shares = self._scale[:, None] * slopes * self.width
        return _Point(value, slack, np.column_stack([by_shares, ~self._constraint]))

    def _point(self, z: Array) -> _Point:
        return self._at(z[:-1].tobytes())

    def slack(self, z: Array) -> Array:
        """The slack (K,) of the constraints, at least zero, at the unknowns (n + 1,)."""
        return np.asarray(self._point(z).slack + ~self._constraint * z[-1])

    def slopes(self, z: Array) -> Array:
        """The derivatives (K, n + 1) of that."""
        return self._point(z).slopes

    def note(self, z: Array) -> None:
        """Keep a step.

        Raises:
            _StuckError: the last steps were shortened as often as SLSQP does.
        """
        self.steps.append((self._point(z).value, self.low + self.width * z[:-1]))
        asked = self._at.cache_info().misses
        if asked - self._asked >= SHORTENED:
            self._shortened += 1
        else:
            self._shortened = 0
        self._asked = asked
        if self._shortened == STUCK:
            raise _StuckError


def starting_points(cost: ShockCost, count: int | None, seed: int) -> list[Array]:
    """The landing as given, and random points, each the best of some.

    The best one is the least bad of those nearest to all constraints.
    """
    if count is None:
        count = _usual_count(cost)
    low, width = cost.bounds[:, 0], np.ptp(cost.bounds, axis=1)
    shares = np.random.default_rng(seed).random((max(count, 1), TRIED, len(low)))
    tried = low + width * shares
    of_points = cost.measured(tried.reshape(-1, len(low)))
    measures = of_points.reshape(*tried.shape[:2], -1)
    worst = measures[..., ~cost.constraints].max(axis=-1)
    missed = -measures[..., cost.constraints].min(axis=-1, initial=0.0)
    # By what misses the constraints, then by the worst.
    best = np.lexsort((worst, np.maximum(missed, OPTIMUM_TOLERANCE)))[:, 0]
    return [cost.x0, *tried[np.arange(count), best[:count]]]


def _usual_count(cost: ShockCost) -> int:
    """The number of random points by default."""
    if cost.slow:
        return SLOW
    return RUNS if cost.exact else ROUGH
