"""The check of budgets for CI: JUnit, GitHub's workflow commands, and the summary of a job."""

import os
from collections.abc import Sequence
from xml.etree import ElementTree as ET

from shockpc.judgement.drive_range import DRIVES_REMEDY
from shockpc.studies.check.outcome import Check, Outcome
from shockpc.studies.check.study import MOST_CHANGES
from shockpc.studies.check.texts import case_angle_text, case_joints_text, order, place_text
from shockpc.text.printed import count, few, printable

LIMITS = ("max", "min", "baseline_tolerance", "percentile")
"""Keys of a budget that limit it."""

MOST_COMMANDS = 10
"""Errors of one step that GitHub shows."""

MESSAGE = str.maketrans({"%": "%25", "\r": "%0D", "\n": "%0A"})
PROPERTY = MESSAGE | str.maketrans({":": "%3A", ",": "%2C"})
"""Characters that would end the message or a property of a workflow command."""


def junit(check: Check) -> str:
    """A JUnit report: a suite for each case, a test for each outcome.

    An outcome of severity warning passes.
    """
    by_case: dict[str, list[Outcome]] = {}
    for outcome in check.outcomes:
        by_case.setdefault(outcome.case, []).append(outcome)
    every = _counts(check.outcomes, sum(check.seconds.values()))
    root = ET.Element("testsuites", {"name": "shockpc check", **every})
    for case, outcomes in by_case.items():
        seconds = check.seconds.get(case, 0.0)
        counts = _counts(outcomes, seconds)
        suite = ET.SubElement(root, "testsuite", {"name": printable(case), **counts})
        for outcome in outcomes:
            _add_test(suite, check, outcome, seconds / len(outcomes))
    ET.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(root, encoding="unicode") + "\n"


def _add_test(suite: ET.Element, check: Check, outcome: Outcome, seconds: float) -> None:
    """Add an outcome to its suite. Args: seconds, its share of the time of the case [s]."""
    budget = outcome.budget
    # The limits are not part of the name, which stays the same when they change.
    limits = ", ".join(key for key in LIMITS if getattr(budget, key) is not None)
    attributes = {
        "classname": outcome.case,
        "name": f"{budget.metric} at {outcome.at}{case_angle_text(outcome)}: {limits}",
        "time": _time(seconds),
        **_line(check, outcome),
    }
    printed = {key: printable(value) for key, value in attributes.items()}
    test = ET.SubElement(suite, "testcase", printed)
    if outcome.status == "skipped":
        ET.SubElement(test, "skipped")
    elif outcome.fails:
        kind = "error" if outcome.status == "not computed" else "failure"
        stated = {"type": outcome.status, "message": printable(outcome.reason)}
        ET.SubElement(test, kind, stated).text = _explained(check, outcome)
    elif outcome.status != "passed":
        ET.SubElement(test, "system-out").text = _explained(check, outcome)


def _counts(outcomes: Sequence[Outcome], seconds: float) -> dict[str, str]:
    """The attributes of a suite. Args: outcomes, its tests; seconds, that they took [s]."""
    errors = sum(outcome.fails and outcome.status == "not computed" for outcome in outcomes)
    failures = sum(outcome.fails for outcome in outcomes) - errors
    skipped = sum(outcome.status == "skipped" for outcome in outcomes)
    return {
        "tests": str(len(outcomes)),
        "failures": str(failures),
        "errors": str(errors),
        "skipped": str(skipped),
        "time": _time(seconds),
    }


def _time(seconds: float) -> str:
    return f"{seconds:.4f}"


def github_commands(check: Check) -> str:
    """Workflow commands that mark the lines of the budgets: at most ten, errors first.

    The last one counts those left out.
    """
    marked = sorted((outcome for outcome in check.outcomes if outcome.reason), key=order)
    shown = marked
    if len(marked) > MOST_COMMANDS:
        shown = marked[: MOST_COMMANDS - 1]
    lines = [_command(check, outcome) for outcome in shown]
    left = marked[len(shown) :]
    if left:
        more = count(len(left), "more budget")
        lines.append(
            f"::{_severity(left[0])} title=shockpc::{more} not met; the summary of the run lists "
            f"them\n"
        )
    return "".join(lines)


def _command(check: Check, outcome: Outcome) -> str:
    """The workflow command of an outcome."""
    title = f"{outcome.budget.metric} at {outcome.at}"
    if outcome.status == "undecided":
        title = f"undecided: {title}"
    properties = []
    for key, value in {**_line(check, outcome), "title": f"shockpc: {title}"}.items():
        properties.append(f"{key}={printable(value).translate(PROPERTY)}")
    text = _explained(check, outcome).translate(MESSAGE)
    return f"::{_severity(outcome)} {','.join(properties)}::{text}\n"


def _severity(outcome: Outcome) -> str:
    return "error" if outcome.fails else "warning"


def _explained(check: Check, outcome: Outcome) -> str:
    """An explanation, on one line, of a budget that is not met.

    It gives the reason, what to do where drives decide, the joint model, the changes, and how to
    compute the number anew.
    """
    parts = [f"{place_text(outcome)}: {outcome.reason}"]
    if outcome.status == "undecided":
        parts.append(DRIVES_REMEDY)
    model = case_joints_text(check, outcome.case)
    if model:
        parts.append(f"joint model {model}")
    changes = few(check.changes.get(outcome.case, ()), MOST_CHANGES, "; ", " changes")
    if changes:
        parts.append(f"since the baseline: {changes}")
    if outcome.command:
        parts.append(outcome.command)
    return printable("; ".join(parts))


def _line(check: Check, outcome: Outcome) -> dict[str, str]:
    """The file and line of a budget, as far as they are known.

    The file is relative to the repository or to the current folder.
    """
    place = {}
    if check.path is not None:
        root = os.path.realpath(os.environ.get("GITHUB_WORKSPACE") or ".")
        place["file"] = os.path.relpath(os.path.realpath(check.path), root)
    if outcome.line is not None:
        place["line"] = str(outcome.line)
    return place
