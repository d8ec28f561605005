"""One case by every method: how wrong, how long, and what came of it."""

from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from shockpc.bench.accuracy import body_errors
from shockpc.bench.cases import Case
from shockpc.bench.methods import Method
from shockpc.bench.reference import Reference, reference
from shockpc.bench.system import System, Unsuited, system_of
from shockpc.bench.timing import Timing, timed
from shockpc.core.spatial import Array
from shockpc.errors import ShockError, SolveError
from shockpc.health import PROMISED, TRUSTED

__all__ = ["OUTCOMES", "CaseResult", "MethodResult", "measure"]

OUTCOMES = {
    "right": "every body within 1e-9 of the truth",
    "told": "worse, and it said so",
    "wrong": "worse, and it said nothing",
    "near": "a simulation, as near as its ground is hard",
    "nan": "not a number",
    "failed": "an exception of a library",
    "refused": "a message in words",
    "invented": "an answer where there is none",
    "unsuited": "cannot take such a scene",
}
"""What can come of a method on a case."""

UNANSWERABLE = 1e-6
"""A case whose exact solution leaves more than this of a row's speed has no answer: its rows contradict one another."""


@dataclass(frozen=True)
class MethodResult:
    """What a method made of a case.

    Attributes:
        method: its name.
        kind: "product", "direct" or "simulation".
        outcome: a key of `OUTCOMES`.
        error: largest over the bodies, relative to the body's own motion [1]; None without numbers.
        whole: largest over the bodies, relative to the fastest body's motion [1].
        estimate: what the method itself expects at worst [1]; None if it does not say.
        margin: largest over the bodies of error / (10 estimate + 1e-14): above 1 the estimate's promise is broken.
        timing: of the run; None if it failed.
        message: what it said when it failed.
    """

    method: str
    kind: str
    outcome: str
    error: float | None = None
    whole: float | None = None
    estimate: float | None = None
    margin: float | None = None
    timing: Timing | None = None
    message: str = ""


@dataclass(frozen=True)
class CaseResult:
    """What came of a case.

    Attributes:
        name: of the case.
        family: of the case.
        variant: of the case.
        value: of the parameter.
        label: the value as it is shown.
        answer: whether the case has one.
        rank: independent rows of the reference, exactly; 0 if it has no answer.
        rows: all its rows, those that tie followers to their leaders too; 0 if it has no answer.
        results: one for each method.
    """

    name: str
    family: str
    variant: str
    value: float
    label: str
    answer: bool
    rank: int
    rows: int
    results: tuple[MethodResult, ...] = field(default=())

    def table(self) -> dict[str, Any]:
        """As plain tables, for JSON."""
        return asdict(self) | {"results": [asdict(r) | {"timing": r.timing and r.timing._asdict()} for r in self.results]}

    @staticmethod
    def from_table(table: dict[str, Any]) -> "CaseResult":
        """Back from JSON."""
        results = [
            MethodResult(**(row | {"timing": None if row["timing"] is None else Timing(**row["timing"])}))
            for row in table["results"]
        ]
        return CaseResult(**(table | {"results": tuple(results)}))


def measure(case: Case, methods: tuple[Method, ...], budget: float) -> CaseResult:
    """Solve a case exactly and by every method.

    Args:
        case: the case.
        methods: the rivals.
        budget: time to spend on each method's clock [s].
    """
    robot, scene = case.build()
    head = (case.name, case.family, case.variant, case.value, case.label)
    try:
        system = system_of(robot, scene)
    except ShockError as refusal:
        return CaseResult(*head, False, 0, 0, (MethodResult(methods[0].name, methods[0].kind, "refused", message=str(refusal)),))
    try:
        truth = reference(robot, system.scene, system.landing)
    except SolveError:
        truth = None
    answer = truth is not None and truth.violation < UNANSWERABLE
    results = tuple(_try(system, truth if answer else None, method, budget) for method in methods)
    rank, rows = (truth.rank, len(truth.impulse)) if truth is not None and answer else (0, 0)
    return CaseResult(*head, answer, rank, rows, results)


def _try(system: System, truth: Reference | None, method: Method, budget: float) -> MethodResult:
    """One method on one system."""
    try:
        prepared = method.prepare(system)
        raw, timing = timed(prepared.run, budget)
        jumps = prepared.read(raw)
    except Unsuited as reason:
        return MethodResult(method.name, method.kind, "unsuited", message=str(reason))
    except ShockError as refusal:
        return MethodResult(method.name, method.kind, "refused", message=str(refusal))
    except np.linalg.LinAlgError as failure:
        return MethodResult(method.name, method.kind, "failed", message=str(failure))
    told = prepared.warned(raw)
    if not np.all(np.isfinite(jumps)):
        return MethodResult(method.name, method.kind, "nan", timing=timing)
    if truth is None:
        return MethodResult(method.name, method.kind, "told" if told else "invented", timing=timing)
    found = body_errors(system.robot, truth, jumps)
    error, whole = float(found.own.max()), float(found.whole.max())
    estimate = prepared.estimate(raw)
    worse = "near" if method.kind == "simulation" else "told" if told else "wrong"
    outcome = "right" if error <= TRUSTED else worse
    expected, margin = (None, None) if estimate is None else _held_against(found.own, estimate)
    return MethodResult(method.name, method.kind, outcome, error, whole, expected, margin, timing)


def _held_against(errors: Array, estimate: Array) -> tuple[float, float]:
    """The worst estimate, and how near the promise came to being broken at any body."""
    return float(estimate.max()), float(np.max(errors / (PROMISED * estimate + 1e-14)))
