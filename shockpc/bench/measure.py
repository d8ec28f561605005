"""One landing by every method: true error and run time."""

import time
from collections.abc import Callable, Mapping
from functools import partial
from statistics import median
from typing import Any, NamedTuple

import numpy as np

from shockpc import ShockError, ShockProfile, shock_profile
from shockpc.bench.cases import Trial
from shockpc.bench.methods import PROVEN, Method, PinocchioSystem, UnsuitedError, system_of
from shockpc.impact.landed import LandingProof
from shockpc.judgement.accuracy import double_error

ACCURATE = 1e-9
"""Largest error of a result that counts as accurate, relative to the motion of each body."""

LONG = 0.2
"""A run of this many seconds is not repeated to warm up [s]."""

OUTCOMES = {
    "accurate": f"error of every body at most {ACCURATE:g}",
    "inaccurate": "a larger error, without a warning",
    "approximate": "its contact is soft or damped, and the error depends on how much",
    "not finite": "NaN or infinity",
    "exception": "an exception of a library",
    "refused": (
        "an error message: the landing has no unique solution, or the posture is singular or "
        "nearly so"
    ),
    "unfounded": "numbers for such a landing",
    "unsuited": "the method cannot take such a landing",
}
"""Outcomes of a method on a case."""


class Result(NamedTuple):
    """Result of a method on a case.

    Attributes:
        case: what was landed.
        method: its name.
        outcome: a key of `OUTCOMES`.
        error: largest over the bodies, relative to the body's motion [1]; for the package's printed
            numbers the bound on rounding; None without numbers or without a reference.
        seconds: run time of each run [s]; none if it failed.
        message: why it failed.
    """

    case: Trial
    method: str
    outcome: str
    error: float | None = None
    seconds: tuple[float, ...] = ()
    message: str = ""

    @property
    def quartiles(self) -> list[float | None]:
        """First quartile, median and third quartile of the run times [s]."""
        return np.quantile(self.seconds, (0.25, 0.5, 0.75)).tolist() if self.seconds else [None] * 3


def timed(run: Callable[[], Any], budget: float) -> tuple[Any, tuple[float, ...]]:
    """Run until the budget is spent, three to a thousand times unless one run is long.

    Args: budget [s]; at zero it runs once.

    The first run loads and fills caches; it counts only if it is not repeated.

    Returns: the last result, and the time of each run [s].
    """
    seconds: list[float] = []
    while len(seconds) < 4 or (sum(seconds[1:]) < budget and len(seconds) <= 1000):
        start = time.perf_counter()
        result = run()
        seconds.append(time.perf_counter() - start)
        if budget <= 0.0 or seconds[0] > max(LONG, budget):
            return result, tuple(seconds)
    return result, tuple(seconds[1:])


def cost(run: Callable[[], Any], budget: float, count: int = 1) -> float:
    """Median time of work that is done so often in one run [s]."""
    return median(timed(run, budget)[1]) / count


def measure(case: Trial, methods: Mapping[str, Method], budget: float) -> list[Result]:
    """Solve a case by every method; one that the package cannot prepare has a single result.

    Args: budget for each clock [s].
    """
    robot, scene = case.build()
    try:
        system = system_of(robot, scene)
    except ShockError as refusal:
        return [Result(case, PROVEN, "refused", message=str(refusal))]
    try:
        proof = shock_profile(scene, robot).proof
    except ShockError:
        proof = None
    results = []
    for name, method in methods.items():
        result = partial(Result, case, name)
        results.append(_result(result, system, proof, method, budget))
    return results


def _result(
    result: Callable[..., Result],
    system: PinocchioSystem,
    proof: LandingProof | None,
    method: Method,
    budget: float,
) -> Result:
    """The result of one method on one system.

    Args:
        result: makes it of an outcome, an error, run times and a message.
        system: the landing.
        proof: the package's; None where there is no answer.
        method: the method.
        budget: for the clock [s].
    """
    try:
        with np.errstate(all="ignore"):
            prepared = method(system)
            raw, seconds = timed(prepared.run, budget)
            jumps = prepared.read(raw)
    except (ShockError, np.linalg.LinAlgError) as failure:
        kinds = {UnsuitedError: "unsuited", np.linalg.LinAlgError: "exception"}
        return result(kinds.get(type(failure), "refused"), message=str(failure))
    if not np.all(np.isfinite(jumps)):
        return result("not finite", None, seconds)
    if proof is None:
        return result("unfounded", None, seconds)
    if isinstance(raw, ShockProfile):
        error = float(proof.bounds.max())
    else:
        error = double_error(system.landing, proof, jumps)
    outcome = "approximate" if prepared.approximates else "inaccurate"
    if error <= ACCURATE:
        outcome = "accurate"
    return result(outcome, error, seconds)
