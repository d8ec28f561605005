"""The check of budgets as a table: the same rows for the terminal, Markdown, CSV and the message of a failed assertion."""

from shockpc.show.header import count
from shockpc.show.tables.sheets import Cell, Sheet
from shockpc.studies.check.budgets import Budget
from shockpc.studies.check.gate import Check, Outcome
from shockpc.studies.check.metrics import METRICS

__all__ = ["check_sheet", "landing_text", "limit_text", "outcomes_sheet", "place_text", "summary_text"]


def check_sheet(check: Check, fold: bool = True, most: int | None = None, only_failures: bool = False) -> Sheet:
    """One row for each budget at each place of each landing; what fails comes first, then what is exceeded with a warning.

    Args:
        check: the outcomes.
        fold: for a terminal: the reasons why budgets are not met are notes under the table, rather than its last column.
        most: largest number of rows; a note counts the others.
        only_failures: leave out budgets that are met.
    """
    ordered = sorted(check.outcomes, key=lambda outcome: (not outcome.fails, outcome.status == "passed"))
    every = [outcome for outcome in ordered if outcome.status != "passed" or not only_failures]
    shown = every[:most]
    rows: list[tuple[Cell, ...]] = [
        (
            _status(outcome),
            landing_text(outcome),
            outcome.at,
            f"{outcome.budget.metric} [{METRICS[outcome.budget.metric].unit.replace('1', '-')}]",
            outcome.value,
            limit_text(outcome.budget),
            outcome.baseline,
            None if outcome.change is None else 100.0 * outcome.change,
            None if fold else outcome.reason or None,
        )
        for outcome in shown
    ]
    header = ("result", "landing", "at", "metric", "value", "limit", "baseline", "change [%]", "reason")
    # A column without any entry tells nothing.
    kept = [k for k, head in enumerate(header) if head == "value" or any(row[k] is not None for row in rows)]
    notes = [f"{_status(one)}: {place_text(one)}: {one.reason}" for one in shown if one.reason and fold]
    if len(every) > len(shown):
        notes.append(f"{count(len(every) - len(shown), 'row')} not shown")
    table = [tuple(row[k] for k in kept) for row in rows]
    return Sheet(summary_text(check), tuple(header[k] for k in kept), table, (*notes, *check.notes))


def outcomes_sheet(check: Check) -> Sheet:
    """The same for a spreadsheet: in the order of the file, with a column for each number."""
    header = (
        "case", "strike angle [deg]", "at", "metric", "unit", "value", "max", "min",
        "baseline", "baseline tolerance", "change [%]", "severity", "result", "reason",
    )  # fmt: skip
    rows: list[tuple[Cell, ...]] = [
        (
            outcome.case,
            outcome.strike_angle_deg,
            outcome.at,
            outcome.budget.metric,
            METRICS[outcome.budget.metric].unit,
            outcome.value,
            outcome.budget.max,
            outcome.budget.min,
            outcome.baseline,
            outcome.budget.baseline_tolerance,
            None if outcome.change is None else 100.0 * outcome.change,
            outcome.budget.severity,
            outcome.status,
            outcome.reason,
        )
        for outcome in check.outcomes
    ]
    return Sheet(summary_text(check), header, rows)


def summary_text(check: Check) -> str:
    """How many budgets are met, in a sentence."""
    failed = sum(outcome.fails and outcome.status == "exceeded" for outcome in check.outcomes)
    warned, missing = check.count("exceeded") - failed, check.count("not computed")
    parts = [
        f"{check.count('passed')} passed",
        f"{failed} exceeded",
        *([f"{warned} exceeded with a warning"] if warned else []),
        *([f"{missing} not computed"] if missing else []),
    ]
    proven = f"; jumps proven to {check.error_bound:.0e} of each body's motion" if check.error_bound else ""
    return f"budgets of {count(check.landings, 'landing')}: {', '.join(parts)}{proven}"


def limit_text(budget: Budget) -> str:
    """The limits of a budget."""
    parts = []
    if budget.min is not None:
        parts.append(f"≥ {budget.min:.6g}")
    if budget.max is not None:
        parts.append(f"≤ {budget.max:.6g}")
    if budget.baseline_tolerance is not None:
        sign = "≤ baseline +" if budget.worse == "greater" else "≥ baseline −"
        parts.append(f"{sign} {budget.baseline_tolerance}")
    return ", ".join(parts)


def landing_text(outcome: Outcome) -> str:
    """The case, and the strike angle if it is one of the case's."""
    return outcome.case + ("" if outcome.strike_angle_deg is None else f", {outcome.strike_angle_deg:g} deg")


def place_text(outcome: Outcome) -> str:
    """What a value belongs to, in words."""
    return f"{landing_text(outcome)}: {outcome.budget.metric} at {outcome.at}"


def _status(outcome: Outcome) -> str:
    """How the value compares, in a word."""
    return "warning" if outcome.status == "exceeded" and not outcome.fails else outcome.status
