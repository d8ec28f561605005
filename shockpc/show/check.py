"""The check of budgets for other programs: JSON, JUnit, GitHub's workflow commands, and Markdown."""

import json
import math
import os
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import shockpc
from shockpc.errors import OutputError
from shockpc.model.dynamics import PINOCCHIO
from shockpc.printed import printable
from shockpc.show.header import count
from shockpc.show.tables.check import check_sheet, limit_text, outcomes_sheet, place_text
from shockpc.show.tables.text import as_csv, as_markdown, as_text
from shockpc.studies.check.gate import Check, Outcome
from shockpc.studies.check.metrics import METRICS

__all__ = ["SCHEMA", "append_summary", "check_files", "github_commands", "report_text", "to_json", "to_junit"]

SCHEMA = "shockpc.check/1"

MOST_COMMANDS = 10
"""Errors of one step that GitHub shows."""

MOST_ROWS = 500
"""Rows of a summary, whose size GitHub limits to 1 MiB."""


def report_text(check: Check, format_: str) -> str:
    """The outcomes in a format: text, markdown, json, junit or github."""
    match format_:
        case "json":
            return to_json(check)
        case "junit":
            return to_junit(check)
        case "github":
            return github_commands(check)
        case "markdown":
            return as_markdown(check_sheet(check, fold=False))
        case _:
            return as_text(check_sheet(check))


def check_files(check: Check) -> dict[str, str | bytes]:
    """The files of a check by name."""
    return {
        "check.json": to_json(check),
        "check.csv": as_csv(outcomes_sheet(check)),
        "check.md": report_text(check, "markdown"),
        "junit.xml": to_junit(check),
    }


def to_json(check: Check) -> str:
    """The document, schema `shockpc.check/1`; null where there is no number, "inf" for an infinite one."""
    document = {
        "schema": SCHEMA,
        "shockpc": shockpc.__version__,
        "pinocchio": PINOCCHIO,
        "file": None if check.path is None else str(check.path),
        "exit_code": check.exit_code,
        "counts": {status.replace(" ", "_"): check.count(status) for status in ("passed", "exceeded", "not computed")},
        "landings": check.landings,
        "error_bound": check.error_bound,
        "outcomes": [_record(outcome) for outcome in check.outcomes],
        "notes": list(check.notes),
    }
    return json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def to_junit(check: Check) -> str:
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
            name = f"{outcome.budget.metric} at {outcome.at}{angle}: {limit_text(outcome.budget)}"
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


def github_commands(check: Check) -> str:
    """Workflow commands that mark the lines of the budgets: at most ten, errors first; the last one counts those left out."""
    marked = sorted((outcome for outcome in check.outcomes if outcome.status != "passed"), key=lambda outcome: not outcome.fails)
    shown = marked if len(marked) <= MOST_COMMANDS else marked[: MOST_COMMANDS - 1]
    lines = [_command(check, outcome) for outcome in shown]
    if len(marked) > len(shown):
        kind = "error" if marked[len(shown)].fails else "warning"
        left = count(len(marked) - len(shown), "more budget is", "more budgets are")
        lines.append(f"::{kind} title=shockpc::{left} not met; the summary of the run lists them")
    return "".join(f"{line}\n" for line in lines)


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


def _record(outcome: Outcome) -> dict[str, Any]:
    """One outcome."""
    budget = outcome.budget
    return {
        "case": outcome.case,
        "strike_angle_deg": outcome.strike_angle_deg,
        "at": outcome.at,
        "metric": budget.metric,
        "unit": METRICS[budget.metric].unit,
        "value": _number(outcome.value),
        "max": budget.max,
        "min": budget.min,
        "baseline": _number(outcome.baseline),
        "baseline_tolerance": budget.baseline_tolerance,
        "change": outcome.change,
        "severity": budget.severity,
        "status": outcome.status,
        "reason": outcome.reason,
        "line": outcome.line,
    }


def _number(value: float | None) -> float | str | None:
    """A number as JSON holds it."""
    return "inf" if value is not None and math.isinf(value) else value


def _counts(outcomes: tuple[Outcome, ...] | list[Outcome]) -> dict[str, str]:
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
