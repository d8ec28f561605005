"""Outcomes: how the numbers of landings compare with their budgets."""

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from shockpc.evaluation.budgets import Budget
from shockpc.evaluation.table import Table
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.studies.check.baseline import OutcomeKey
from shockpc.studies.check.design_record import six_digits
from shockpc.text.display import brief, shown_by

EXCEEDED, NO_VERDICT = 1, 3
"""Exit codes of a command."""

Status = Literal["passed", "exceeded", "undecided", "not computed", "skipped"]
"""The comparison of a number with its limits; undecided where that depends on the drives."""

FAILING = ("exceeded", "undecided", "not computed")
"""Statuses with which a budget of severity error does not pass."""


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """One budget at one place of one landing.

    Attributes:
        case: its name.
        strike_angle_deg: one of the case's angles; None if the scene gives the strike [deg].
        at: the place.
        budget: the limit.
        line: at which the budget begins in its file; None if that is not known.
        value: the number, in the unit of the metric; None if it could not be computed.
        baseline: the number in the baseline; None without one.
        status: how they compare; skipped if there is only a baseline to compare with, and none is
            given.
        reason: which limit is exceeded and by how much, what decides, or why there is no number;
            empty if the budget is met.
        command: that computes the number anew; empty for landings from Python.
        smallest: of the number over the drives, as far as found; None where they are exact, or
            nothing but a baseline limits it.
        largest: likewise.
        range_kind: how these are found, as in `Range`: "corners", "exact" or "samples"; empty
            without them.
        deciding: the joints whose drives decide, of the largest effect first; empty if they do not.
    """

    case: str
    strike_angle_deg: float | None
    at: str
    budget: Budget
    line: int | None
    value: float | None
    baseline: float | None
    status: Status
    reason: str
    command: str = ""
    smallest: float | None = None
    largest: float | None = None
    range_kind: str = ""
    deciding: tuple[str, ...] = ()

    @property
    def record(self) -> dict[str, Any]:
        """A row of the table, by key."""
        budget = self.budget
        return {
            "case": self.case,
            "strike_angle_deg": self.strike_angle_deg,
            "at": self.at,
            "metric": budget.metric,
            "unit": budget.selection.quantity.unit_text,
            "value": self.value,
            "smallest": self.smallest,
            "largest": self.largest,
            "range_kind": self.range_kind or None,
            "max": budget.max,
            "min": budget.min,
            "percentile": budget.percentile,
            "baseline": self.baseline,
            "baseline_tolerance": budget.baseline_tolerance,
            "change": self.change,
            "severity": budget.severity,
            "status": self.status,
            "reason": self.reason,
            "line": self.line,
            "command": self.command,
        }

    @property
    def key(self) -> OutcomeKey:
        """Case, strike angle, place and metric of the value."""
        return OutcomeKey(self.case, self.strike_angle_deg, self.at, self.budget.metric)

    @property
    def change(self) -> float | None:
        """Change relative to the baseline [1]; None where that is not defined."""
        if self.value is None or self.baseline is None:
            return None
        if not (math.isfinite(self.value) and math.isfinite(self.baseline)):
            return None
        difference = six_digits(self.value) - self.baseline
        if difference == 0.0:
            return 0.0
        return difference / abs(self.baseline) if self.baseline else None

    @property
    def fails(self) -> bool:
        """True if the check does not pass because of it."""
        return self.status in FAILING and self.budget.severity == "error"


@dataclass(frozen=True, kw_only=True)
class Check:
    """All budgets of some landings.

    Attributes:
        path: file of the budgets; None if they are from Python.
        outcomes: by case, strike angle and budget.
        cases: scene and design of each case, for a baseline.
        changes: what changed of the design of each case since the baseline; empty without one.
        landings: number of landings computed.
        error_bound: proven error of the jumps of velocity, relative to each body's motion, the
            largest of all [1].
        notes: warnings of the landings, and what was not compared.
        profiles: the first landing of each case that was computed; its other strike angles are
            products with its maps.
        defects: descriptions of unexpected exceptions, which are errors in shockpc itself.
        seconds: that the landings of each case took, by name [s].
    """

    path: Path | None
    outcomes: tuple[Outcome, ...]
    cases: dict[str, Any]
    changes: dict[str, tuple[str, ...]]
    landings: int
    error_bound: float
    notes: tuple[str, ...]
    profiles: dict[str, ShockProfile] = field(default_factory=dict, repr=False)
    defects: tuple[str, ...] = field(default=(), repr=False)
    seconds: dict[str, float] = field(default_factory=dict, repr=False)

    _repr_html_ = shown_by("studies.check.report:check_report")

    def __repr__(self) -> str:
        statuses = [outcome.status for outcome in self.outcomes]
        return brief(
            self, *(f"{statuses.count(status)} {status}" for status in dict.fromkeys(statuses))
        )

    @property
    def table(self) -> Table:
        """A row for each outcome, in the order of the file of budgets."""
        records = [outcome.record for outcome in self.outcomes]
        rows = [tuple(row.values()) for row in records]
        return Table.of_rows(list(records[0]), rows)

    def count(self, status: str) -> int:
        """Number of outcomes of a status."""
        return sum(outcome.status == status for outcome in self.outcomes)

    @property
    def exit_code(self) -> int:
        """The exit code of the command.

        0: passed; 1: a budget of severity error is exceeded; 3: none is, but one is undecided, or
        its number not computed.
        """
        failed = {outcome.status for outcome in self.outcomes if outcome.fails}
        if "exceeded" in failed:
            return EXCEEDED
        return NO_VERDICT if failed else 0

    @property
    def values(self) -> dict[OutcomeKey, float]:
        """The numbers of the designs as they are that were computed."""
        values = {}
        for outcome in self.outcomes:
            if outcome.value is not None and outcome.budget.percentile is None:
                values[outcome.key] = outcome.value
        return values
