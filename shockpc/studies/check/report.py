"""The check of budgets as a table, and as JSON, CSV and Markdown."""

from collections.abc import Sequence
from typing import get_args

from shockpc.evaluation.budgets import Budget
from shockpc.judgement.drive_range import deciding_text
from shockpc.show.document import record
from shockpc.show.report import Report, Section
from shockpc.show.tables import Heading, Lines, Row, Sheet, sheet_of
from shockpc.show.wording import proof_text
from shockpc.studies.check.ci_formats import github_commands, junit
from shockpc.studies.check.outcome import Check, Outcome, Status
from shockpc.studies.check.texts import case_angle_text, case_joints_text, order, place_text
from shockpc.text.printed import cause_lines, causes, count

MOST_CAUSES = 6
"""Different causes of numbers that could not be computed that are shown."""

HEADER = (
    *("result", "landing", "at", "metric", "unit", "value", "smallest", "largest"),
    *("limit", Heading("baseline", "baseline"), Heading("change", "change", "%"), "reason"),
)
"""Columns of the table of outcomes, of which those without any entry are left out."""

TOLERATED = {"greater": "≤ baseline +", "less": "≥ baseline −", "neither": "= baseline ±"}
"""Before a tolerance against the baseline, by what is worse."""


def check_report(check: Check) -> Report:
    """The report of the outcomes.

    Its CSV file is in the order of the file of budgets; its tables begin with what fails.
    """
    # The page opens on a landing of a budget that is not met.
    cases = dict.fromkeys(outcome.case for outcome in sorted(check.outcomes, key=order))
    landings = {case: check.profiles[case] for case in cases if case in check.profiles}
    return Report(
        name="check",
        title=f"Budgets: {_counts_text(check)}",
        body=lambda full: _body(check, full),
        lead=1,
        sheets={"check": lambda: sheet_of(check.table).headed({"change": "change [%]"})},
        document=lambda: _document(check),
        tables=True,
        formats={"junit": lambda: junit(check), "github": lambda: github_commands(check)},
        more=lambda _: {"junit.xml": junit(check)},
        landings=landings,
    )


def _body(check: Check, full: bool) -> list[Section]:
    """The table, and the commands that compute the numbers anew of which a budget is not met."""
    commands = dict.fromkeys(
        outcome.command for outcome in check.outcomes if outcome.reason and outcome.command
    )
    sections: list[Section] = [check_sheet(check, for_terminal=not full)]
    if commands:
        sections.append(Lines(list(commands), "to compute these numbers anew", whole=True))
    return sections


def _document(check: Check) -> dict[str, object]:
    """The entries of the document that are no tables."""
    counts = {status.replace(" ", "_"): check.count(status) for status in get_args(Status)}
    return {
        "file": check.path,
        "exit_code": check.exit_code,
        "counts": counts,
        **record(check, "landings", "error_bound"),
        "changes": check.changes,
        "notes": check.notes,
    }


def check_sheet(check: Check, for_terminal: bool = True, most: int | None = None) -> Sheet:
    """One row for each budget at each place of each landing.

    What fails comes first, then what is exceeded with a warning.

    Args:
        check: the outcomes.
        for_terminal: the limit of a budget that is not met says by how much, and notes say what was
            not computed, rather than a last column.
        most: largest number of rows; a note counts the others.
    """
    shown = sorted(check.outcomes, key=order)[:most]
    notes = []
    if for_terminal:
        notes += cause_notes(shown)
    cases = dict.fromkeys(outcome.case for outcome in shown if outcome.reason)
    for case in cases:
        model = case_joints_text(check, case)
        if model:
            notes.append(f"joint model of {case}: {model}")
    left = len(check.outcomes) - len(shown)
    if left:
        notes.append(f"{count(left, 'row')} not shown")
    rows = [_row(outcome, for_terminal) for outcome in shown]
    return Sheet(_summary_text(check), HEADER, rows, [*notes, *check.notes]).known()


def _row(outcome: Outcome, for_terminal: bool) -> Row:
    """An outcome, in the columns of `HEADER`."""
    budget = outcome.budget
    result: str = outcome.status
    if outcome.status == "exceeded" and not outcome.fails:
        result = "warning"
    limit, reason = _limit_text(budget), outcome.reason
    if for_terminal:
        if outcome.status == "exceeded":
            limit = reason
        reason = ""
    return (
        result,
        f"{outcome.case}{case_angle_text(outcome)}",
        outcome.at,
        budget.metric,
        budget.selection.quantity.unit_text,
        outcome.value,
        outcome.smallest,
        outcome.largest,
        limit,
        outcome.baseline,
        outcome.change,
        reason,
    )


def cause_notes(outcomes: Sequence[Outcome]) -> list[str]:
    """Reasons why numbers were not computed, and the joints whose drives decide, each once."""
    missing, undecided = [], []
    # Numbers that the same joints decide have one note, whichever of these decides most.
    texts = dict[frozenset[str], str]()
    for outcome in outcomes:
        if outcome.status == "not computed":
            missing.append((place_text(outcome), outcome.reason))
        if outcome.status == "undecided":
            joints = frozenset(outcome.deciding)
            text = texts.setdefault(joints, deciding_text(outcome.deciding))
            undecided.append((place_text(outcome), text))
    notes = []
    for name, named in (("not computed", missing), ("undecided", undecided)):
        for line in cause_lines(causes(named), "numbers", MOST_CAUSES):
            notes.append(f"{name}: {line}")
    return notes


def _counts_text(check: Check) -> str:
    """The numbers of budgets that are met and that are not, in words."""
    failed = sum(outcome.fails and outcome.status == "exceeded" for outcome in check.outcomes)
    rest = {
        "exceeded with a warning": check.count("exceeded") - failed,
        "undecided": check.count("undecided"),
        "not computed": check.count("not computed"),
        "skipped": check.count("skipped"),
    }
    counts = [f"{check.count('passed')} passed", f"{failed} exceeded"]
    counts += [f"{number} {status}" for status, number in rest.items() if number]
    return ", ".join(counts)


def _summary_text(check: Check) -> str:
    """The number of budgets that are met, and the bound on rounding, in a sentence."""
    parts = [f"budgets of {count(check.landings, 'landing')}: {_counts_text(check)}"]
    if check.error_bound:
        parts.append(proof_text(check.error_bound))
    unproven = []
    for outcome in check.outcomes:
        selection = outcome.budget.selection
        profile = check.profiles.get(outcome.case)
        if profile is not None and selection.quantity.of_ground(profile.scene):
            unproven.append(selection.name)
    if unproven:
        parts.append(f"in double precision: {', '.join(dict.fromkeys(unproven))}")
    return "; ".join(parts)


def _limit_text(budget: Budget) -> str:
    """The limits of a budget, such as "≤ 0.1, ≤ baseline + 5%"."""
    limits = []
    if budget.min is not None:
        limits.append(f"≥ {budget.min:.6g}")
    if budget.max is not None:
        limits.append(f"≤ {budget.max:.6g}")
    if budget.baseline_tolerance is not None:
        limits.append(f"{TOLERATED[budget.worse]} {budget.baseline_tolerance}")
    text = ", ".join(limits)
    return text if budget.percentile is None else f"{text} in {budget.percentile:g} %"
