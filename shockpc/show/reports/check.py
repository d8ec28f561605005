"""The check of budgets as a table, and for other programs: JSON, CSV, JUnit, GitHub's workflow commands, and Markdown."""

import math
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

from shockpc.errors import OutputError
from shockpc.printed import printable
from shockpc.show.document import head, json_text, record
from shockpc.show.header import count
from shockpc.show.tables.sheets import Cell, Sheet
from shockpc.show.tables.text import as_csv, as_markdown, as_text
from shockpc.studies.check.budgets import Budget
from shockpc.studies.check.gate import Check, Outcome
from shockpc.studies.check.metrics import METRICS

__all__ = ["append_summary", "check_files", "check_sheet", "check_text", "place_text"]

MOST_COMMANDS = 10
"""Errors of one step that GitHub shows."""

MOST_ROWS = 500
"""Rows of a summary, whose size GitHub limits to 1 MiB."""


def check_text(check: Check, format_: str) -> str:
    """The outcomes in a format: text, markdown, json, csv, junit or github."""
    match format_:
        case "json":
            return json_text(_document(check))
        case "csv":
            return as_csv(_outcomes(check))
        case "junit":
            return _junit(check)
        case "github":
            return _github_commands(check)
        case "markdown":
            return as_markdown(check_sheet(check, fold=False))
        case _:
            return as_text(check_sheet(check))


def check_files(check: Check) -> dict[str, str | bytes]:
    """The files of a check by name."""
    files = {"check.json": "json", "check.csv": "csv", "check.md": "markdown", "junit.xml": "junit"}
    return {name: check_text(check, format_) for name, format_ in files.items()}


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
            _landing_text(outcome),
            outcome.at,
            f"{outcome.budget.metric} [{METRICS[outcome.budget.metric].unit.replace('1', '-')}]",
            outcome.value,
            _limit_text(outcome.budget),
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
    return Sheet(_summary_text(check), tuple(header[k] for k in kept), table, (*notes, *check.notes))


def _outcomes(check: Check) -> Sheet:
    """The same for a spreadsheet: in the order of the file, a column for each value of a record but the line."""
    header = (
        "case", "strike angle [deg]", "at", "metric", "unit", "value", "max", "min",
        "baseline", "baseline tolerance", "change [%]", "severity", "result", "reason",
    )  # fmt: skip
    rows = []
    for outcome in check.outcomes:
        found = _record(outcome)
        change = None if outcome.change is None else 100.0 * outcome.change
        rows.append(tuple((found | {"change": change}).values())[: len(header)])
    return Sheet(_summary_text(check), header, rows)


def _record(outcome: Outcome) -> dict[str, Any]:
    """One outcome; "inf" for an infinite number."""
    budget = outcome.budget
    return {
        **record(outcome, "case", "strike_angle_deg", "at"),
        "metric": budget.metric,
        "unit": METRICS[budget.metric].unit,
        "value": _number(outcome.value),
        **record(budget, "max", "min"),
        "baseline": _number(outcome.baseline),
        "baseline_tolerance": budget.baseline_tolerance,
        "change": outcome.change,
        "severity": budget.severity,
        **record(outcome, "status", "reason", "line"),
    }


def _summary_text(check: Check) -> str:
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


def _limit_text(budget: Budget) -> str:
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


def _landing_text(outcome: Outcome) -> str:
    """The case, and the strike angle if it is one of the case's."""
    return outcome.case + ("" if outcome.strike_angle_deg is None else f", {outcome.strike_angle_deg:g} deg")


def place_text(outcome: Outcome) -> str:
    """What a value belongs to, in words."""
    return f"{_landing_text(outcome)}: {outcome.budget.metric} at {outcome.at}"


def _status(outcome: Outcome) -> str:
    """How the value compares, in a word."""
    return "warning" if outcome.status == "exceeded" and not outcome.fails else outcome.status


def append_summary(check: Check) -> None:
    """Append the table to the summary of a GitHub job, if the environment names its file.

    Raises:
        OutputError: it cannot be written.
    """
    name = os.environ.get("GITHUB_STEP_SUMMARY")
    if not name:
        return
    try:
        with open(name, "a", encoding="utf-8") as summary:
            summary.write(as_markdown(check_sheet(check, fold=False, most=MOST_ROWS)) + "\n")
    except OSError as refusal:
        raise OutputError(f'"{name}", which GITHUB_STEP_SUMMARY names, cannot be written: {refusal.strerror}') from None


def _document(check: Check) -> dict[str, Any]:
    """The document, schema `shockpc.check/1`; null where there is no number, "inf" for an infinite one."""
    return {
        **head("check"),
        "file": None if check.path is None else str(check.path),
        "exit_code": check.exit_code,
        "counts": {status.replace(" ", "_"): check.count(status) for status in ("passed", "exceeded", "not computed")},
        **record(check, "landings", "error_bound"),
        "outcomes": [_record(outcome) for outcome in check.outcomes],
        "notes": list(check.notes),
    }


def _junit(check: Check) -> str:
    """A JUnit report: a suite for each case, a test for each budget at each place of each landing.

    A budget that is exceeded is a failure, one that could not be computed is an error, and one of severity warning is a test that
    passed with the message as its output.
    """
    root = ET.Element("testsuites", name="shockpc check")
    for case in dict.fromkeys(outcome.case for outcome in check.outcomes):
        own = [outcome for outcome in check.outcomes if outcome.case == case]
        suite = ET.SubElement(root, "testsuite", {"name": printable(case), **_counts(own)})
        for outcome in own:
            angle = "" if outcome.strike_angle_deg is None else f", {outcome.strike_angle_deg:g} deg"
            name = f"{outcome.budget.metric} at {outcome.at}{angle}: {_limit_text(outcome.budget)}"
            test = ET.SubElement(suite, "testcase", classname=printable(case), name=printable(name), time="0")
            if check.path is not None:
                test.set("file", printable(_in_repository(check.path)))
            if outcome.line is not None:
                test.set("line", str(outcome.line))
            if outcome.status == "passed":
                continue
            kind = "error" if outcome.status == "not computed" else "failure" if outcome.fails else "system-out"
            details = ET.SubElement(test, kind)
            details.text = printable(f"{place_text(outcome)}: {outcome.reason}")
            if outcome.fails:
                details.set("type", outcome.status)
                details.set("message", printable(outcome.reason))
    for key, value in _counts(check.outcomes).items():
        root.set(key, value)
    ET.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(root, encoding="unicode") + "\n"


def _github_commands(check: Check) -> str:
    """Workflow commands that mark the lines of the budgets: at most ten, errors first; the last one counts those left out."""
    marked = sorted((outcome for outcome in check.outcomes if outcome.status != "passed"), key=lambda outcome: not outcome.fails)
    shown = marked if len(marked) <= MOST_COMMANDS else marked[: MOST_COMMANDS - 1]
    lines = [_command(check, outcome) for outcome in shown]
    if len(marked) > len(shown):
        kind = "error" if marked[len(shown)].fails else "warning"
        left = count(len(marked) - len(shown), "more budget is", "more budgets are")
        lines.append(f"::{kind} title=shockpc::{left} not met; the summary of the run lists them")
    return "".join(f"{line}\n" for line in lines)


def _number(value: float | None) -> float | str | None:
    """A number as JSON holds it."""
    return "inf" if value is not None and math.isinf(value) else value


def _counts(outcomes: Sequence[Outcome]) -> dict[str, str]:
    """The attributes of a suite."""
    errors = sum(outcome.status == "not computed" for outcome in outcomes)
    failures = sum(outcome.fails for outcome in outcomes) - errors
    return {"tests": str(len(outcomes)), "failures": str(failures), "errors": str(errors), "skipped": "0", "time": "0"}


def _command(check: Check, outcome: Outcome) -> str:
    """One workflow command. The path is relative to the repository, as GitHub wants it."""
    properties = {}
    if check.path is not None:
        properties["file"] = _in_repository(check.path)
    if outcome.line is not None:
        properties["line"] = str(outcome.line)
    properties["title"] = f"shockpc: {outcome.budget.metric} at {outcome.at}"
    listed = ",".join(f"{key}={_property(value)}" for key, value in properties.items())
    return f"::{'error' if outcome.fails else 'warning'} {listed}::{_data(f'{place_text(outcome)}: {outcome.reason}')}"


def _in_repository(path: Path) -> str:
    """A path relative to the folder of the repository, or to the current folder; as it is outside both."""
    for root in (os.environ.get("GITHUB_WORKSPACE"), os.getcwd()):
        if root and path.resolve().is_relative_to(Path(root).resolve()):
            return path.resolve().relative_to(Path(root).resolve()).as_posix()
    return str(path)


def _data(text: str) -> str:
    """A message with the characters escaped that would end it."""
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _property(text: str) -> str:
    """A property with the characters escaped that would end it."""
    return _data(text).replace(":", "%3A").replace(",", "%2C")
