"""The check of budgets as a table, and for other programs: JSON, CSV, JUnit, GitHub's workflow
commands, and Markdown.
"""

import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import get_args
from xml.etree import ElementTree as ET

from shockpc.evaluation.budgets import Budget
from shockpc.show.document import record
from shockpc.show.files import destination
from shockpc.show.report import Report
from shockpc.show.tables import Cell, Column, Lines, Sheet, as_markdown, sheet_of
from shockpc.show.wording import count, proof_text
from shockpc.studies.check.study import MOST_CHANGES, Check, Outcome, Status
from shockpc.text.errors import OutputError
from shockpc.text.printed import cause_lines, causes, few, printable

LIMITS = ("max", "min", "baseline_tolerance", "percentile")
"""Keys of a budget that limit it."""

MOST_COMMANDS = 10
"""Errors of one step that GitHub shows."""

MOST_CAUSES = 6
"""Different causes of numbers that could not be computed that are shown."""

MOST_ROWS = 500
"""Rows of a summary, whose size GitHub limits to 1 MiB."""

MESSAGE = str.maketrans({"%": "%25", "\r": "%0D", "\n": "%0A"})
PROPERTY = MESSAGE | str.maketrans({":": "%3A", ",": "%2C"})
"""Characters that would end the message or a property of a workflow command."""


def check_report(check: Check) -> Report:
    """The outcomes; the CSV file is in the order of the file of budgets, the tables begin with what
    fails.
    """
    # The page opens on a landing of a budget that is not met.
    cases = dict.fromkeys(
        one.case for one in sorted(check.outcomes, key=_order) if one.case in check.profiles
    )
    return Report(
        name="check",
        title=f"Budgets: {_verdicts(check)}",
        body=lambda full: [check_sheet(check, for_terminal=not full), *_commands(check)],
        lead=1,
        sheets={"check": lambda: _sheet(check, check.outcomes)},
        document=lambda: {
            "file": check.path,
            "exit_code": check.exit_code,
            "counts": {
                status.replace(" ", "_"): check.count(status) for status in get_args(Status)
            },
            **record(check, "landings", "error_bound"),
            "changes": check.changes,
            "notes": check.notes,
        },
        tables=True,
        formats={"junit": lambda: _junit(check), "github": lambda: _github_commands(check)},
        more=lambda _: {"junit.xml": _junit(check)},
        landings={case: check.profiles[case] for case in cases},
    )


def _sheet(check: Check, outcomes: Sequence[Outcome]) -> Sheet:
    """All that is known of some outcomes."""
    sheet = sheet_of(replace(check, outcomes=tuple(outcomes)).table)
    columns = {
        column.key: list(cells)
        for column, cells in zip(sheet.columns, zip(*sheet.rows, strict=True), strict=True)
    }
    heads = {column.key: column for column in sheet.columns} | {
        "change": Column("change", "change", "%")
    }
    limits = [_limit_text(outcome.budget) for outcome in outcomes]
    words: dict[str, list[Cell]] = {
        "result": [
            "warning" if outcome.status == "exceeded" and not outcome.fails else outcome.status
            for outcome in outcomes
        ],
        "landing": [_landing_text(outcome) for outcome in outcomes],
        "limit": list(limits),
        "verdict": [
            one.reason if one.status == "exceeded" else limit
            for one, limit in zip(outcomes, limits, strict=True)
        ],
    }
    return Sheet.of("", {**{heads[key]: cells for key, cells in columns.items()}, **words})


def check_sheet(check: Check, for_terminal: bool = True, most: int | None = None) -> Sheet:
    """One row for each budget at each place of each landing; what fails comes first, then what is
    exceeded with a warning.

    Args:
        check: the outcomes.
        for_terminal: the limit of a budget that is not met says by how much, and notes say what was
            not computed, rather than a last column.
        most: largest number of rows; a note counts the others.
    """
    shown = sorted(check.outcomes, key=_order)[:most]
    words = ("verdict",) if for_terminal else ("limit", "reason")
    # A column without any entry tells nothing.
    kept = _sheet(check, shown).only(
        "result",
        "landing",
        "at",
        "metric",
        "unit",
        "value",
        "smallest",
        "largest",
        words[0],
        "baseline",
        "change",
        *words[1:],
    )
    kept = kept.known()
    header = [
        column._replace(title="limit") if column.key == "verdict" else column
        for column in kept.columns
    ]
    missing = causes(
        (place_text(outcome), outcome.reason)
        for outcome in shown
        if outcome.status == "not computed" and for_terminal
    )
    notes = [f"not computed: {line}" for line in cause_lines(missing, "numbers", MOST_CAUSES)]
    undecided = causes(
        (place_text(outcome), outcome.advice)
        for outcome in shown
        if outcome.advice and for_terminal
    )
    notes += [f"undecided: {line}" for line in cause_lines(undecided, "numbers", MOST_CAUSES)]
    cases = dict.fromkeys(outcome.case for outcome in shown if outcome.reason)
    notes += [
        f"joint model of {case}: {model}" for case in cases if (model := _joint_model(check, case))
    ]
    if left := len(check.outcomes) - len(shown):
        notes.append(f"{count(left, 'row')} not shown")
    return kept._replace(title=_summary_text(check), header=header, notes=[*notes, *check.notes])


def _order(outcome: Outcome) -> tuple[bool, bool, bool]:
    """What fails comes first, then what is not met with a warning; of both what the drives decide
    comes last.
    """
    return not outcome.fails, not outcome.reason, outcome.status == "undecided"


def _commands(check: Check) -> list[Lines]:
    """The commands that compute the numbers anew of which a budget is not met."""
    commands = dict.fromkeys(
        outcome.command for outcome in check.outcomes if outcome.reason and outcome.command
    )
    return [Lines(list(commands), "to compute these numbers anew", whole=True)] if commands else []


def _joint_model(check: Check, case: str) -> str:
    """What the joints of a case do, and where their drives are from; empty if it could not be
    computed.
    """
    return check.profiles[case].landing.joint_model.summary if case in check.profiles else ""


def _explained(check: Check, outcome: Outcome) -> str:
    """Why a budget is not met, the joint model, what changed, and how to compute the number anew,
    on one line.
    """
    changes = few(check.changes.get(outcome.case, ()), MOST_CHANGES, "; ", " changes")
    since, again = (
        f"; since the baseline: {changes}" if changes else "",
        f"; {outcome.command}" if outcome.command else "",
    )
    joints = f"; joint model {model}" if (model := _joint_model(check, outcome.case)) else ""
    return printable(f"{place_text(outcome)}: {outcome.reason}{joints}{since}{again}")


def _verdicts(check: Check) -> str:
    """How many budgets are met, and how many are not."""
    failed = sum(outcome.fails and outcome.status == "exceeded" for outcome in check.outcomes)
    warned, undecided = check.count("exceeded") - failed, check.count("undecided")
    missing = check.count("not computed")
    text = f"{check.count('passed')} passed, {failed} exceeded"
    text += f", {warned} exceeded with a warning" if warned else ""
    text += f", {undecided} undecided" if undecided else ""
    text += f", {missing} not computed" if missing else ""
    return text + (f", {skipped} skipped" if (skipped := check.count("skipped")) else "")


def _summary_text(check: Check) -> str:
    """How many budgets are met, and the bound on rounding, in a sentence."""
    text = f"budgets of {count(check.landings, 'landing')}: {_verdicts(check)}"
    text += f"; {proof_text(check.error_bound)}" if check.error_bound else ""
    scenes = {case: profile.scene for case, profile in check.profiles.items()}
    computed = (
        (one.budget.selection, scenes[one.case]) for one in check.outcomes if one.case in scenes
    )
    unproven = dict.fromkeys(
        selection.name for selection, scene in computed if selection.quantity.of_ground(scene)
    )
    return text + (f"; in double precision: {', '.join(unproven)}" if unproven else "")


def _limit_text(budget: Budget) -> str:
    parts = []
    if budget.min is not None:
        parts.append(f"≥ {budget.min:.6g}")
    if budget.max is not None:
        parts.append(f"≤ {budget.max:.6g}")
    if budget.baseline_tolerance is not None:
        sign = {"greater": "≤ baseline +", "less": "≥ baseline −", "neither": "= baseline ±"}[
            budget.worse
        ]
        parts.append(f"{sign} {budget.baseline_tolerance}")
    return ", ".join(parts) + ("" if budget.percentile is None else f" in {budget.percentile:g} %")


def _landing_text(outcome: Outcome) -> str:
    """The case, and the strike angle if it is one of the case's."""
    return outcome.case + (
        "" if outcome.strike_angle_deg is None else f", {outcome.strike_angle_deg:g} deg"
    )


def place_text(outcome: Outcome) -> str:
    """What a value belongs to, in words."""
    return f"{_landing_text(outcome)}: {outcome.budget.metric} at {outcome.at}"


def append_summary(check: Check) -> None:
    """Append the table to the summary of a GitHub job, if the environment names its file.

    Raises:
        OutputError: it cannot be written.
    """
    name = os.environ.get("GITHUB_STEP_SUMMARY")
    if not name:
        return
    try:
        with destination(Path(name)).open("a", encoding="utf-8") as summary:
            summary.write(
                as_markdown(check_sheet(check, for_terminal=False, most=MOST_ROWS)) + "\n"
            )
    except OSError as refusal:
        raise OutputError(
            f'"{name}", which GITHUB_STEP_SUMMARY names, cannot be written: {refusal.strerror}'
        ) from None


def _junit(check: Check) -> str:
    """A JUnit report: a suite for each case, a test for each outcome; one of severity warning
    passes.
    """
    root = ET.Element("testsuites", {"name": "shockpc check", **_counts(check.outcomes)})
    for case in dict.fromkeys(outcome.case for outcome in check.outcomes):
        outcomes = [outcome for outcome in check.outcomes if outcome.case == case]
        suite = ET.SubElement(root, "testsuite", {"name": printable(case), **_counts(outcomes)})
        for outcome in outcomes:
            angle = (
                "" if outcome.strike_angle_deg is None else f", {outcome.strike_angle_deg:g} deg"
            )
            # The limits are not part of the name, which stays the same when they change.
            limits = [key for key in LIMITS if getattr(outcome.budget, key) is not None]
            name = f"{outcome.budget.metric} at {outcome.at}{angle}: {', '.join(limits)}"
            share = check.seconds.get(case, 0.0) / len(outcomes)
            time = f"{share:.4f}"
            named = {"classname": case, "name": name, "time": time, **_line(check, outcome)}
            test = ET.SubElement(
                suite, "testcase", {key: printable(value) for key, value in named.items()}
            )
            if outcome.status == "skipped":
                ET.SubElement(test, "skipped")
            elif outcome.status != "passed":
                kind = "error" if outcome.status == "not computed" else "failure"
                kind = kind if outcome.fails else "system-out"
                stated = (
                    {"type": outcome.status, "message": printable(outcome.reason)}
                    if outcome.fails
                    else {}
                )
                ET.SubElement(test, kind, stated).text = _explained(check, outcome)
    ET.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(root, encoding="unicode") + "\n"


def _counts(outcomes: Sequence[Outcome]) -> dict[str, str]:
    """The attributes of a suite."""
    errors = sum(outcome.fails and outcome.status == "not computed" for outcome in outcomes)
    failures = sum(outcome.fails for outcome in outcomes) - errors
    skipped = sum(outcome.status == "skipped" for outcome in outcomes)
    counts = {
        "tests": len(outcomes),
        "failures": failures,
        "errors": errors,
        "skipped": skipped,
        "time": 0,
    }
    return {name: str(number) for name, number in counts.items()}


def _github_commands(check: Check) -> str:
    """Workflow commands that mark the lines of the budgets: at most ten, errors first; the last one
    counts those left out.
    """
    marked = sorted((outcome for outcome in check.outcomes if outcome.reason), key=_order)
    shown = marked if len(marked) <= MOST_COMMANDS else marked[: MOST_COMMANDS - 1]
    lines = []
    for outcome in shown:
        undecided = "undecided: " * (outcome.status == "undecided")
        title = f"shockpc: {undecided}{outcome.budget.metric} at {outcome.at}"
        properties = {**_line(check, outcome), "title": title}
        listed = ",".join(
            f"{key}={printable(value).translate(PROPERTY)}" for key, value in properties.items()
        )
        text = _explained(check, outcome).translate(MESSAGE)
        lines.append(f"::{'error' if outcome.fails else 'warning'} {listed}::{text}\n")
    if left := marked[len(shown) :]:
        kind = "error" if left[0].fails else "warning"
        lines.append(
            f"::{kind} title=shockpc::{count(len(left), 'more budget')} not met; the summary of "
            f"the run lists them\n"
        )
    return "".join(lines)


def _line(check: Check, outcome: Outcome) -> dict[str, str]:
    """The file and line of a budget, as far as they are known, the file relative to the repository
    or to the current folder.
    """
    root = os.path.realpath(os.environ.get("GITHUB_WORKSPACE") or ".")
    place = (
        {} if check.path is None else {"file": os.path.relpath(os.path.realpath(check.path), root)}
    )
    return place if outcome.line is None else {**place, "line": str(outcome.line)}
