"""One landing by every method: true error and run time."""

import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any, NamedTuple

import numpy as np

from shockpc.bench.cases.family import Case
from shockpc.bench.methods import PROVEN, Method
from shockpc.bench.system import System, UnsuitedError, system_of
from shockpc.core.spatial import Array
from shockpc.errors import ShockError
from shockpc.exact.proof import motion
from shockpc.landing import Landing
from shockpc.profile import shock_profile
from shockpc.results.accuracy import rotation_lengths

__all__ = ["ACCURATE", "OUTCOMES", "CaseResult", "MethodResult", "Timing", "body_errors", "measure", "timed"]

ACCURATE = 1e-9
"""Largest error of a result that counts as accurate, relative to the motion of each body."""

AT_REST = 1e-13
"""A body that moves by less than this share of the fastest one is compared with the fastest one."""

LONG = 0.2
"""A run of this many seconds is not repeated to warm up [s]."""

OUTCOMES = {
    "accurate": f"error of every body at most {ACCURATE:g}",
    "inaccurate": "a larger error, without a warning",
    "approximate": "its contact is soft or damped, and the error depends on how much",
    "not finite": "NaN or infinity",
    "exception": "an exception of a library",
    "refused": "an error message: the landing has no unique solution",
    "unfounded": "numbers for a landing that has no unique solution",
    "unsuited": "the method cannot take such a landing",
}
"""Outcomes of a method on a case."""


class Timing(NamedTuple):
    """Run time.

    Attributes:
        median: of all runs [s].
        low: first quartile [s].
        high: third quartile [s].
        runs: how many.
    """

    median: float
    low: float
    high: float
    runs: int


class MethodResult(NamedTuple):
    """Result of a method on a case.

    Attributes:
        method: its name.
        outcome: a key of `OUTCOMES`.
        error: largest over the bodies, relative to the body's own motion [1]; the proven bound for the package's printed numbers;
            None without numbers or without a reference.
        timing: None if it failed.
        message: why it failed.
    """

    method: str
    outcome: str
    error: float | None = None
    timing: Timing | None = None
    message: str = ""


class CaseResult(NamedTuple):
    """Results of all methods on a case.

    Attributes:
        family: of the case.
        variant: of the case.
        label: value of the case's parameter.
        results: one for each method.
    """

    family: str
    variant: str
    label: str
    results: tuple[MethodResult, ...]


def timed(run: Callable[[], Any], budget: float) -> tuple[Any, Timing]:
    """Run until the budget is spent, three to a thousand times unless one run is long, and give the last result.

    The first run loads and fills caches; it counts only if it is not repeated.

    Args:
        run: the work.
        budget: time to spend [s]; at zero it runs once.
    """
    start = time.perf_counter()
    result = run()
    first = time.perf_counter() - start
    if first > max(LONG, budget) or budget <= 0.0:
        return result, Timing(first, first, first, 1)
    seconds: list[float] = []
    while len(seconds) < 3 or (sum(seconds) < budget and len(seconds) < 1000):
        start = time.perf_counter()
        result = run()
        seconds.append(time.perf_counter() - start)
    low, median, high = (float(value) for value in np.quantile(seconds, (0.25, 0.5, 0.75)))
    return result, Timing(median, low, high, len(seconds))


def body_errors(landing: Landing, exact: Array, jumps: Array) -> Array:
    """Error (nb,) of the jump of every body, |Δ - Δ*| / |Δ*| with |Δ|² = |v|² + (r |ω|)² and r the radius of gyration.

    A body slower than `AT_REST` of the fastest one is compared with the fastest one.

    Args:
        landing: of which robot.
        exact: (nb, 6) proven jumps, body coordinates at the body frames' origins.
        jumps: (nb, 6) jumps of a method.
    """
    length = rotation_lengths(landing)
    size, off = (motion(jump[..., None], length)[:, 0] for jump in (exact, jumps - exact))
    return np.asarray(off / np.where(size > AT_REST * size.max(), size, size.max() or 1.0))


def measure(case: Case, methods: tuple[Method, ...], budget: float) -> CaseResult:
    """Solve a case by every method.

    Args:
        case: the case.
        methods: the methods.
        budget: time to spend on each method's clock [s].
    """
    robot, scene = case.build()
    exact = None
    try:
        system = system_of(robot, scene)
    except ShockError as refusal:
        return CaseResult(*case[:3], (MethodResult(PROVEN, "refused", message=str(refusal)),))
    with suppress(ShockError):
        exact = shock_profile(scene, robot).proof.jumps[..., 3]
    return CaseResult(*case[:3], tuple(_try(system, exact, method, budget) for method in methods))


def _try(system: System, exact: Array | None, method: Method, budget: float) -> MethodResult:
    """One method on one system."""
    try:
        with np.errstate(all="ignore"):
            prepared = method.prepare(system)
            raw, timing = timed(prepared.run, budget)
            jumps = prepared.read(raw)
    except UnsuitedError as reason:
        return MethodResult(method.name, "unsuited", message=str(reason))
    except ShockError as refusal:
        return MethodResult(method.name, "refused", message=str(refusal))
    except np.linalg.LinAlgError as failure:
        return MethodResult(method.name, "exception", message=str(failure))
    if not np.all(np.isfinite(jumps)):
        return MethodResult(method.name, "not finite", timing=timing)
    if exact is None:
        return MethodResult(method.name, "unfounded", timing=timing)
    error = float((raw.proof.bounds if method.name == PROVEN else body_errors(system.landing, exact, jumps)).max())
    outcome = "accurate" if error <= ACCURATE else "approximate" if method.approximates else "inaccurate"
    return MethodResult(method.name, outcome, error, timing)
