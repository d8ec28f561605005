"""Compare the numbers of landings with their budgets, and with a baseline.

A change of only the strike angle changes the landing by a product with the map from strike to jump;
every landing is nevertheless computed by `shock_profile`, so that each compared number is the
midpoint of a proven enclosure. That takes milliseconds.
"""

import math
import os
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from shockpc.evaluation.budgets import Budget, Budgets, read_budgets
from shockpc.evaluation.column import Column
from shockpc.evaluation.profiles import proven_profiles
from shockpc.evaluation.table import Table
from shockpc.judgement.drive_range import DRIVES_REMEDY
from shockpc.landing.places import Place
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.studies.check.baseline import Baseline, OutcomeKey, read_baseline
from shockpc.studies.check.design_record import design_changes
from shockpc.studies.check.outcome import Check, Outcome
from shockpc.studies.check.plan import Planned, plan
from shockpc.studies.check.rerun import rerun_command
from shockpc.studies.check.verdict import BudgetedNumber, Verdict, verdict_of
from shockpc.text.arguments import checked
from shockpc.text.errors import ShockError, StudyError, traces
from shockpc.text.printed import few, printable

MOST_CHANGES = 12
"""Changes of a design that a note lists."""

UNCHANGED = "no change of the bodies, joints and points that the baseline holds"
"""The text of a note where numbers changed and the design did not."""


@checked
def check_budgets(
    given: Budgets | str | os.PathLike[str],
    baseline: Baseline | str | os.PathLike[str] | None = None,
    renewing: bool = False,
    progress: Callable[[int], Callable[[str], None]] = lambda landings: lambda name: None,
) -> Check:
    """Compute the landings of a file of budgets, and compare them with their limits.

    Args:
        given: the landings and their limits, or the path of a file of budgets.
        baseline: numbers to compare with, or the path of their file; in place of the file that the
            budgets name.
        renewing: whether the numbers become the new baseline, so that it is no omission that there
            is none.
        progress: called with the number of landings; what it gives is called with the name of a
            case after each landing.

    Raises:
        StudyError: a file cannot be read, a scene, a robot or a name in a budget is not valid, the
            baseline is of another scene, or every budget needs a baseline and there is none. A
            landing that has no solution is no error: its outcomes say why.
    """
    budgets = given if isinstance(given, Budgets) else read_budgets(Path(given))
    if baseline is None and not renewing:
        baseline = budgets.baseline
    if baseline is not None and not isinstance(baseline, Baseline):
        baseline = read_baseline(Path(baseline))
    if baseline is None and not renewing:
        _refuse_without_limits(budgets)
    # Filled by `plan`: the cases, with which those of the baseline are compared.
    records: dict[str, Any] = {}
    planned = list(plan(budgets, baseline, records))
    seconds: dict[str, float] = {}
    results = _results(planned, progress(len(planned)), seconds)

    of_landings = []
    for landing, result in zip(planned, results, strict=True):
        of_landings.append(_of_landing(budgets, baseline, landing, result))
    outcomes = tuple(chain.from_iterable(landing.outcomes for landing in of_landings))
    # What changed since the baseline explains numbers that moved.
    changes = _changes(baseline, records)
    notes = [
        *_change_notes(changes, outcomes),
        *_remedies(outcomes),
        *_omissions(budgets, records, compared=baseline is not None or renewing),
        *chain.from_iterable(landing.warnings for landing in of_landings),
    ]
    return Check(
        path=budgets.path,
        outcomes=outcomes,
        cases=records,
        changes=changes,
        landings=len(planned),
        error_bound=_error_bound(results),
        notes=tuple(dict.fromkeys(notes)),
        profiles=_first_profiles(planned, results),
        defects=(
            *traces(results),
            *chain.from_iterable(landing.defects for landing in of_landings),
        ),
        seconds=seconds,
    )


class _OfLanding(NamedTuple):
    """What a landing contributes to a check.

    Attributes:
        outcomes: of its budgets.
        warnings: of it.
        defects: descriptions of unexpected exceptions in landings of random designs.
    """

    outcomes: tuple[Outcome, ...]
    warnings: tuple[str, ...]
    defects: tuple[str, ...]


def _of_landing(
    budgets: Budgets, baseline: Baseline | None, planned: Planned, result: ShockProfile | ShockError
) -> _OfLanding:
    """The outcomes and warnings of a landing from its profile, or from why there is none."""
    name = planned.case.name
    designs = None
    defects: tuple[str, ...] = ()
    warnings: list[str] = []
    if isinstance(result, ShockProfile):
        warnings += [_warning(name, str(warning)) for warning in result.health.warnings]
        if planned.designs is not None:
            designs = planned.designs.table
            defects = tuple(designs.defects)
            warnings += _gaining(name, designs)
    outcomes = tuple(_outcomes(budgets, baseline, planned, result, designs))
    return _OfLanding(outcomes, tuple(warnings), defects)


def _error_bound(results: Iterable[ShockProfile | ShockError]) -> float:
    """The largest bound on rounding of some landings; 0 without any result."""
    bounds = [result.proof.bounds.max() for result in results if isinstance(result, ShockProfile)]
    return float(max(bounds, default=0.0))


def _first_profiles(
    planned: Sequence[Planned], results: Sequence[ShockProfile | ShockError]
) -> dict[str, ShockProfile]:
    """The first profile of each case, by its name."""
    profiles: dict[str, ShockProfile] = {}
    for landing, result in zip(planned, results, strict=True):
        if isinstance(result, ShockProfile):
            profiles.setdefault(landing.case.name, result)
    return profiles


def _changes(baseline: Baseline | None, records: Mapping[str, Any]) -> dict[str, tuple[str, ...]]:
    """The changes of the design of each case since a baseline; empty without one."""
    changes = {}
    if baseline is not None:
        for name, record in records.items():
            changes[name] = tuple(design_changes(baseline.designs[name], record["design"]))
    return changes


def _refuse_without_limits(budgets: Budgets) -> None:
    """Refuse budgets of which each needs a baseline."""
    if all(budget.max is None and budget.min is None for budget in budgets.budgets):
        raise StudyError(
            "all budgets have only a baseline_tolerance, and there is no baseline to compare with; "
            "name it with "
            '--baseline, or by baseline = "base.json" at the top of the budgets\' file'
        )


def _results(
    planned: Sequence[Planned], advance: Callable[[str], None], seconds: dict[str, float]
) -> list[ShockProfile | ShockError]:
    """The profile of each landing, or why there is none.

    Args:
        planned: the landings.
        advance: called with the name of the case after each landing.
        seconds: filled with the time that the landings of each case took, by its name [s].
    """
    start = time.perf_counter()

    def landed(k: str) -> None:
        nonlocal start
        name, now = planned[int(k)].case.name, time.perf_counter()
        seconds[name] = seconds.get(name, 0.0) + now - start
        start = now
        advance(name)

    cases = {str(k): (landing.scene, landing.robot) for k, landing in enumerate(planned)}
    return list(proven_profiles(cases, None, done=landed).values())


def _outcomes(
    budgets: Budgets,
    baseline: Baseline | None,
    planned: Planned,
    result: ShockProfile | ShockError,
    designs: Table | None,
) -> Iterator[Outcome]:
    """The outcomes of one landing.

    Args:
        budgets: all of them.
        baseline: numbers of an earlier design.
        planned: the landing.
        result: its profile, or why there is none.
        designs: the landings of random designs, if a budget has a percentile.
    """
    for k, places in planned.places.items():
        budget = budgets.budgets[k]
        sampled = budget.percentile is not None
        numbers, missing = _numbers(budget, places, result, designs)
        for place, value in zip(places, numbers, strict=True):
            key = OutcomeKey(planned.case.name, planned.angle, place.name, budget.metric)
            before = None
            if baseline is not None and not sampled:
                before = baseline.values.get(key)
            verdict = Verdict("not computed", missing)
            if isinstance(result, ShockProfile) and not math.isnan(value):
                number = BudgetedNumber(budget, place, value, before)
                verdict = verdict_of(number, result, planned.case.vary, baseline)
            command = ""
            if budgets.path is not None:
                command = rerun_command(budgets.path, planned, budget, place)
            yield Outcome(
                case=planned.case.name,
                strike_angle_deg=planned.angle,
                at=place.name,
                budget=budget,
                line=budgets.lines[k] if budgets.lines else None,
                value=None if math.isnan(value) else value,
                baseline=before,
                command=command,
                **verdict._asdict(),
            )


def _numbers(
    budget: Budget,
    places: Sequence[Place],
    result: ShockProfile | ShockError,
    designs: Table | None,
) -> tuple[list[float], str]:
    """The number of a budget at each place, NaN where there is none, and why there is none."""
    missing = budget.selection.quantity.scope.missing
    if isinstance(result, ShockError):
        return [math.nan] * len(places), str(result)
    if designs is None or budget.percentile is None:
        return list(map(float, result.numbers(budget.selection, places))), missing
    numbers = []
    for place in places:
        values = designs.columns[Column(budget.selection, place).name]
        number = math.nan
        if not np.isnan(values).any():
            number = budget.representative(values)
        numbers.append(number)
    messages = list(designs.messages.values())
    if messages:
        missing = f"{len(messages)} of {len(designs)} designs: {messages[0]}"
    return numbers, missing


def _omissions(budgets: Budgets, records: Mapping[str, Any], compared: bool) -> Iterator[str]:
    """Notes on what was not checked.

    Args:
        budgets: with their cases.
        records: the cases that have a budget, by name.
        compared: whether there is a baseline, or the numbers become one.
    """
    for case in budgets.cases:
        if case.name not in records:
            yield f'case "{printable(case.name)}" has no budget'
    if any(budget.percentile is not None for budget in budgets.budgets):
        yield "percentiles are of random designs in double precision"
    if not compared and any(budget.baseline_tolerance for budget in budgets.budgets):
        yield (
            "without a baseline no baseline_tolerance was checked; name it with --baseline, or in "
            "the budgets' file"
        )


def _remedies(outcomes: Sequence[Outcome]) -> Iterator[str]:
    """What to do where drives decide, which is the same for all outcomes."""
    if any(outcome.status == "undecided" for outcome in outcomes):
        yield f"where drives decide, {DRIVES_REMEDY}"


def _warning(case: str, text: str) -> str:
    return f"warning of {printable(case)}: {text}"


def _gaining(case: str, designs: Table) -> Iterator[str]:
    """A warning where the impact of some designs would gain energy."""
    gaining = int((designs.values("energy_gained") > 0.0).sum())
    if gaining:
        many = f"{gaining} of {len(designs)} designs"
        yield _warning(case, f"the impact would gain energy in {many}, which is not feasible")


def _change_notes(
    changes: Mapping[str, tuple[str, ...]], outcomes: Sequence[Outcome]
) -> Iterator[str]:
    """The changes since the baseline, once for all cases in which they are the same."""
    moved = {outcome.case for outcome in outcomes if outcome.change or outcome.fails}
    cases_by_text: dict[str, list[str]] = {}
    for name, lines in changes.items():
        text = few(lines, MOST_CHANGES, "; ", " changes")
        if not text and name in moved:
            text = UNCHANGED
        if text:
            cases_by_text.setdefault(text, []).append(printable(name))
    for text, names in cases_by_text.items():
        yield f"since the baseline: {few(names, 4)}: {text}"
