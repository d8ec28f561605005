"""Compare the numbers of landings with their budgets, and with a baseline.

A change of only the strike angle changes the landing by a product with the map from strike to jump;
every landing is nevertheless computed by `shock_profile`, so that each compared number is the
midpoint of a proven enclosure. That takes milliseconds.
"""

import itertools
import math
import os
import shlex
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np

from shockpc.evaluation.budgets import Budget, Budgets, Case, DesignVariation, read_budgets
from shockpc.evaluation.column import Column, places_at
from shockpc.evaluation.evaluate import Evaluation
from shockpc.evaluation.profiles import proven
from shockpc.evaluation.table import Table
from shockpc.evaluation.unused_ground import refuse_unused_ground
from shockpc.evaluation.varied_landings import VariedLandings, varied_landings
from shockpc.judgement.drive_range import Range, deciding_joints, drives_advice, range_of
from shockpc.landing.landing import PosedLanding
from shockpc.landing.places import Place
from shockpc.landing.resolve import resolve
from shockpc.landing.scene import Scene
from shockpc.landing.scene_file import robot_of
from shockpc.quantities.quantity import Quantity
from shockpc.quantities.selection import Selection, select
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.robot.robot import Robot
from shockpc.studies.check.baseline import (
    Baseline,
    OutcomeKey,
    case_record,
    read_baseline,
    refuse_other_scene,
)
from shockpc.studies.check.design_record import design_changes, six_digits
from shockpc.text.arguments import checked
from shockpc.text.errors import ShockError, StudyError, traces
from shockpc.text.names import match
from shockpc.text.printed import few, printable
from shockpc.text.shown import brief, shown_by

EXCEEDED, NO_VERDICT = 1, 3
"""Exit codes of a command."""

MOST_CHANGES = 12
"""Changes of a design that a note lists."""


Status = Literal["passed", "exceeded", "undecided", "not computed", "skipped"]
"""How a number compares with its limits; undecided where that depends on the drives."""


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
        advice: what to give where the drives decide; empty if they do not.
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
    advice: str = ""

    @property
    def record(self) -> dict[str, Any]:
        """All that a table says of it, by heading."""
        budget = self.budget
        return {
            "case": self.case,
            "strike_angle_deg": self.strike_angle_deg,
            "at": self.at,
            "metric": budget.metric,
            "unit": budget.selection.quantity.unit.replace("1", "-"),
            "value": self.value,
            "smallest": self.smallest,
            "largest": self.largest,
            "range_kind": self.range_kind or None,
            **{key: getattr(budget, key) for key in ("max", "min", "percentile")},
            "baseline": self.baseline,
            "baseline_tolerance": budget.baseline_tolerance,
            "change": self.change,
            "severity": budget.severity,
            **{key: getattr(self, key) for key in ("status", "reason", "line", "command")},
        }

    @property
    def key(self) -> OutcomeKey:
        """What the value belongs to."""
        return OutcomeKey(self.case, self.strike_angle_deg, self.at, self.budget.metric)

    @property
    def change(self) -> float | None:
        """Change relative to the baseline [1]; None where that is not defined."""
        if (
            self.value is None
            or self.baseline is None
            or not (math.isfinite(self.value) and math.isfinite(self.baseline))
        ):
            return None
        difference = six_digits(self.value) - self.baseline
        return (
            0.0 if difference == 0.0 else difference / abs(self.baseline) if self.baseline else None
        )

    @property
    def fails(self) -> bool:
        """Whether the check does not pass because of it."""
        return (
            self.status in ("exceeded", "undecided", "not computed")
            and self.budget.severity == "error"
        )


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
        return brief(self, *(f"{statuses.count(one)} {one}" for one in dict.fromkeys(statuses)))

    @property
    def table(self) -> Table:
        """A row for each outcome, in the order of the file of budgets."""
        records = [outcome.record for outcome in self.outcomes]
        return Table.of_rows(list(records[0]), (tuple(row.values()) for row in records))

    def count(self, status: str) -> int:
        """Number of outcomes of a status."""
        return sum(outcome.status == status for outcome in self.outcomes)

    @property
    def exit_code(self) -> int:
        """0 passed; 1 a budget of severity error is exceeded; 3 none is, but one is undecided, or
        its number not computed.
        """
        failed = {outcome.status for outcome in self.outcomes if outcome.fails}
        return EXCEEDED if "exceeded" in failed else NO_VERDICT if failed else 0

    @property
    def values(self) -> dict[OutcomeKey, float]:
        """The numbers of the designs as they are that were computed."""
        return {
            outcome.key: outcome.value
            for outcome in self.outcomes
            if outcome.value is not None and outcome.budget.percentile is None
        }


class _Planned(NamedTuple):
    """A landing that has budgets, checked and ready to be computed: places by the number of each
    budget, and random designs.
    """

    case: Case
    angle: float | None
    scene: Scene
    robot: Robot
    places: dict[int, tuple[Place, ...]]
    designs: Evaluation[VariedLandings] | None


class _Compared(NamedTuple):
    """A number with its budget.

    Attributes:
        budget: its limits.
        place: where it is.
        value: the number, as modelled.
        before: the number in the baseline; None without one.
    """

    budget: Budget
    place: Place
    value: float
    before: float | None


class _Verdict(NamedTuple):
    """How a number compares with its limits; the fields are those of an `Outcome`."""

    status: Status
    reason: str
    smallest: float | None = None
    largest: float | None = None
    range_kind: str = ""
    advice: str = ""


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
    given = given if isinstance(given, Budgets) else read_budgets(Path(given))
    if baseline is None and not renewing:
        baseline = given.baseline
    baseline = (
        baseline
        if baseline is None or isinstance(baseline, Baseline)
        else read_baseline(Path(baseline))
    )
    limited = any(budget.max is not None or budget.min is not None for budget in given.budgets)
    if baseline is None and not renewing and not limited:
        raise StudyError(
            "all budgets have only a baseline_tolerance, and there is no baseline to compare with; "
            "name it with "
            '--baseline, or by baseline = "base.json" at the top of the budgets\' file'
        )
    cases: dict[str, Any] = {}
    planned = list(_plan(given, baseline, renewing, cases))
    notes = [
        f'case "{printable(case.name)}" has no budget'
        for case in given.cases
        if case.name not in cases
    ]
    if any(budget.percentile is not None for budget in given.budgets):
        notes.append("percentiles are of random designs in double precision")
    if (
        baseline is None
        and not renewing
        and any(budget.baseline_tolerance for budget in given.budgets)
    ):
        notes.append(
            "without a baseline no baseline_tolerance was checked; name it with --baseline, or in "
            "the budgets' file"
        )
    done = progress(len(planned))
    outcomes: list[Outcome] = []
    profiles: dict[str, ShockProfile] = {}
    bound = 0.0
    seconds: dict[str, float] = {}
    start = time.perf_counter()

    def landed(k: str) -> None:
        nonlocal start
        now, name = time.perf_counter(), planned[int(k)].case.name
        seconds[name] = seconds.get(name, 0.0) + now - start
        start = now
        done(name)

    landings = {str(k): (plan.scene, plan.robot) for k, plan in enumerate(planned)}
    results = proven(landings, None, done=landed)
    defects = traces(results.values())
    for plan, result in zip(planned, results.values(), strict=True):
        designs = (
            plan.designs.table
            if plan.designs is not None and isinstance(result, ShockProfile)
            else None
        )
        outcomes += _outcomes(given, baseline, plan, result, designs)
        defects += designs.defects if designs is not None else ()
        if isinstance(result, ShockProfile):
            bound = max(bound, float(result.proof.bounds.max()))
            profiles.setdefault(plan.case.name, result)
            notes += [
                f"warning of {printable(plan.case.name)}: {warning}"
                for warning in result.health.warnings
            ]
        if designs is not None and (gaining := int((designs.values("energy_gained") > 0.0).sum())):
            many = f"{gaining} of {len(designs)} designs"
            notes.append(
                f"warning of {printable(plan.case.name)}: the impact would gain energy in {many}, "
                "which is not feasible"
            )
    changes = {}
    if baseline is not None:
        changes = {
            name: tuple(design_changes(baseline.designs[name], record["design"]))
            for name, record in cases.items()
        }
        notes = [*_change_notes(changes, outcomes), *notes]
    return Check(
        path=given.path,
        outcomes=tuple(outcomes),
        cases=cases,
        changes=changes,
        landings=len(planned),
        error_bound=bound,
        notes=tuple(dict.fromkeys(notes)),
        profiles=profiles,
        defects=tuple(defects),
        seconds=seconds,
    )


def _plan(
    given: Budgets, baseline: Baseline | None, renewing: bool, cases: dict[str, Any]
) -> Iterator[_Planned]:
    """All landings that have budgets, so that whatever is wrong in a file is reported before
    anything is computed.
    """
    names = [case.name for case in given.cases]
    belongs = [
        match(budget.case, names, "case", f"{given.path}, budget[{k}]", "")
        for k, budget in enumerate(given.budgets)
    ]
    for case in given.cases:
        belonging = [
            (k, budget) for k, budget in enumerate(given.budgets) if case.name in belongs[k]
        ]
        sampled = [k for k, budget in belonging if budget.percentile is not None]
        if belonging and bool(case.vary) != bool(sampled):
            missing = (
                "but no budget of it has a percentile" if case.vary else "so it has no percentiles"
            )
            raise StudyError(
                f'case "{printable(case.name)}" has '
                f"{'designs that vary' if case.vary else 'nothing that varies'}, {missing}; "
                "a percentile of a budget is of the designs that [[case.vary]] describes"
            )
        for angle, scene in case.landings if belonging else ():
            wanted = {}
            try:
                robot = robot_of(scene)
                landing = resolve(scene, robot)
                refuse_unused_ground(scene, (budget.selection for _, budget in belonging))
                cases[case.name] = case_record(landing, angle is None)
                if baseline is not None:
                    refuse_other_scene(baseline, case.name, cases[case.name])
                for k, budget in belonging:
                    wanted[k] = _places(landing, budget.selection.quantity, budget.at)
                    if baseline is not None and budget.baseline_tolerance is not None:
                        _refuse_missing(
                            baseline,
                            [
                                OutcomeKey(case.name, angle, place.name, budget.metric)
                                for place in wanted[k]
                            ],
                        )
                asked = tuple(budget.selection for _, budget in belonging)
                designs = _designs(
                    case,
                    scene,
                    robot,
                    [(given.budgets[k].selection, wanted[k]) for k in sampled],
                    asked,
                )
            except ShockError as refusal:
                raise StudyError(
                    f'case "{printable(case.name)}": {refusal}', **refusal.data
                ) from None
            yield _Planned(case, angle, scene, robot, wanted, designs)


def _places(landing: PosedLanding, quantity: Quantity, at: str) -> tuple[Place, ...]:
    """The places that a budget means.

    Where a point is needed, a body is its centre of mass, and globs are those of sensors too.
    """
    robot, bodies = landing.robot, {place.name: place for place in landing.places("body")}
    if quantity.of == "body":
        carried = f" (carries {at})" if at in robot.frames and at not in bodies else ""
        return tuple(
            place._replace(name=place.name + carried) for place in places_at(landing, quantity, at)
        )
    centres = {
        name: place._replace(name=f"{name} (centre of mass)") for name, place in bodies.items()
    }
    known = centres | {
        place.name: place for place in places_at(landing, quantity) if place.name not in centres
    }
    if quantity.of == "point" and (
        at in known or not {at, at.rpartition(":")[0]} & robot.frames.keys()
    ):
        return tuple(known[name] for name in robot.match("point or body", at, known, robot.frames))
    return places_at(landing, quantity, at)


def _designs(
    case: Case,
    scene: Scene,
    robot: Robot,
    chosen: Sequence[tuple[Selection, tuple[Place, ...]]],
    asked: tuple[Selection, ...],
) -> Evaluation[VariedLandings] | None:
    """The random designs of a landing, with a column for each number whose percentile has a limit;
    None without any.

    Args:
        case: says what varies.
        scene: the landing.
        robot: its robot.
        chosen: those numbers, each with its places.
        asked: the quantities of all budgets of the landing.
    """
    if not chosen:
        return None
    vary, each = (
        [(unknown.quantity, unknown.values) for unknown in case.vary if unknown.quantity],
        [(unknown.each, unknown.values) for unknown in case.vary if unknown.each],
    )
    source = varied_landings(
        scene,
        vary,
        robot=robot,
        vary_each=each,
        sample=int(case.designs),
        lhs=True,
        keep_joints=True,
    )
    wanted = [Column(selection, place) for selection, places in chosen for place in places]
    wanted.append(Column(select("energy_gained"), source.first.places("robot")[0]))
    return Evaluation(
        source, tuple({column.name: column for column in wanted}.values()), prove=0, elsewhere=asked
    )


def _percentiles(
    planned: _Planned, budgets: Sequence[Budget], table: Table
) -> tuple[dict[int, list[float]], str]:
    """The numbers of budgets with a percentile by the number of the budget, and why they are
    missing where designs are.
    """
    messages = list(table.messages.values())
    numbers = {}
    for k, places in planned.places.items():
        if budgets[k].percentile is not None:
            names = [Column(budgets[k].selection, place).name for place in places]
            columns = [table.columns[name] for name in names]
            numbers[k] = [
                math.nan if np.isnan(x).any() else budgets[k].representative(x) for x in columns
            ]
    return numbers, f"{len(messages)} of {len(table)} designs: {messages[0]}" if messages else ""


def _outcomes(
    given: Budgets,
    baseline: Baseline | None,
    planned: _Planned,
    result: ShockProfile | ShockError,
    designs: Table | None,
) -> list[Outcome]:
    """The outcomes of one landing.

    Args: result, its profile, or why there is none; designs, the landings of random designs.
    """
    numbers: dict[int, Any] = {k: [math.nan] * len(places) for k, places in planned.places.items()}
    refused, undone = "", ""
    if isinstance(result, ShockProfile):
        percentiles, undone = (
            ({}, "") if designs is None else _percentiles(planned, given.budgets, designs)
        )
        numbers = {
            k: percentiles[k]
            if k in percentiles
            else result.numbers(given.budgets[k].selection, places)
            for k, places in planned.places.items()
        }
    else:
        refused = str(result)
    outcomes = []
    wanted = [(k, place) for k, places in planned.places.items() for place in places]
    for (k, place), number in zip(wanted, itertools.chain(*numbers.values()), strict=True):
        budget, value = given.budgets[k], None if math.isnan(number) else float(number)
        key = OutcomeKey(planned.case.name, planned.angle, place.name, budget.metric)
        sampled = budget.percentile is not None
        before = None if baseline is None or sampled else baseline.values.get(key)
        missing = refused or (sampled and undone) or budget.selection.quantity.scope.missing
        verdict = _Verdict("not computed", missing)
        if value is not None and isinstance(result, ShockProfile):
            verdict = _verdict(planned, result, baseline, _Compared(budget, place, value, before))
        outcomes.append(
            Outcome(
                case=planned.case.name,
                strike_angle_deg=planned.angle,
                at=place.name,
                budget=budget,
                line=given.lines[k] if given.lines else None,
                value=value,
                baseline=before,
                command=""
                if given.path is None
                else shlex.join(_command(given.path, planned, budget, place)),
                **verdict._asdict(),
            )
        )
    return outcomes


def _verdict(
    planned: _Planned, profile: ShockProfile, baseline: Baseline | None, compared: _Compared
) -> _Verdict:
    """How a number compares with its limits for all drives, and as modelled with what a baseline
    allows.
    """
    budget, place, value, before = compared
    limits = _beyond_limits(budget, value)
    reasons = [*limits, *_beyond_baseline(budget, value, before, baseline)]
    limited = budget.max is not None or budget.min is not None
    found = _range(planned, profile, budget, place, value) if limited else None
    smallest, largest, kind = (None, None, "") if found is None else found
    # A change against the baseline for the worse is one whatever the drives.
    if found is not None and reasons == limits and found.meets(budget.min, budget.max) is None:
        joints = deciding_joints(profile, budget.selection, place)
        advice = drives_advice(joints)
        return _Verdict(
            "undecided", f"{_undecided(budget, found)}; {advice}", smallest, largest, kind, advice
        )
    status: Status = (
        "exceeded" if reasons else "passed" if limited or baseline is not None else "skipped"
    )
    return _Verdict(status, "; ".join(reasons), smallest, largest, kind)


def _range(
    planned: _Planned, profile: ShockProfile, budget: Budget, place: Place, value: float
) -> Range | None:
    """The range of a number over the drives; of a percentile that of the design as it is, in
    proportion.

    Random designs whose drives vary have them, so that their percentile has no range besides.
    """
    found = range_of(profile, budget.selection, place)
    if found is None or budget.percentile is None:
        return found
    if any(_of_drives(unknown) for unknown in planned.case.vary):
        return None
    as_modelled = float(profile.numbers(budget.selection, [place])[0])
    if as_modelled == 0.0:
        return found._replace(
            kind="samples", smallest=min(value, found.smallest), largest=max(value, found.largest)
        )
    ends = sorted([value, *(value * end / as_modelled for end in found[:2])])
    return found._replace(kind="samples", smallest=ends[0], largest=ends[-1])


def _of_drives(unknown: DesignVariation) -> bool:
    """Whether designs vary in a drive."""
    return (unknown.quantity or unknown.each or "").partition(":")[0] in ("armature", "rotor")


def _undecided(budget: Budget, found: Range) -> str:
    """Between which values the drives decide, and about which limits."""
    unit = _unit(budget)
    limits = {"min": budget.min, "max": budget.max}
    listed = " and ".join(
        f"{name} {limit:.6g}{unit}" for name, limit in limits.items() if limit is not None
    )
    return (
        f"from {found.smallest:.3g} to {found.largest:.3g}{unit} over the drives, so {listed} may "
        f"be met or not"
    )


def _command(path: Path, planned: _Planned, budget: Budget, place: Place) -> list[str]:
    """The command that computes a number anew: an analysis of the case, or a sweep over its random
    designs.
    """
    case, angle, at, here = planned.case, planned.angle, place.name, Path.cwd()
    words = [
        "shockpc",
        "analyze",
        f"{path.relative_to(here) if path.is_relative_to(here) else path}:{case.name}",
    ]
    words += [] if angle is None else [f"--strike-angle={str(angle).removesuffix('.0')}"]
    if budget.selection.quantity.of == "point" and place.centre:
        body = planned.robot.bodies[place.body]
        at = f"{body.name}:{','.join(map(str, body.com.tolist()))}"
    if budget.percentile is not None:
        vary = [
            f"--vary={unknown.quantity}={unknown.values}"
            if unknown.quantity
            else f"--vary-each={unknown.each}={unknown.values}"
            for unknown in case.vary
        ]
        words[1] = "sweep"
        return [
            *words,
            *vary,
            f"--sample={case.designs:.0f}",
            "--lhs",
            f"--quantity={budget.metric}@{at}",
            "--out=designs",
        ]
    return [*words, f"--at={at}"] if budget.selection.quantity.of == "point" else words


def _change_notes(
    changes: dict[str, tuple[str, ...]], outcomes: Sequence[Outcome]
) -> Iterator[str]:
    """What changed since the baseline, once for all cases in which it is the same."""
    moved = {outcome.case for outcome in outcomes if outcome.change or outcome.fails}
    known = "no change of the bodies, joints and points that the baseline holds"
    texts = {
        name: few(lines, MOST_CHANGES, "; ", " changes") or known * (name in moved)
        for name, lines in changes.items()
    }
    for text in dict.fromkeys(filter(None, texts.values())):
        cases = few([printable(name) for name in texts if texts[name] == text], 4)
        yield f"since the baseline: {cases}: {text}"


def _beyond_limits(budget: Budget, value: float) -> list[str]:
    """Which limits of a budget a value exceeds."""
    unit = _unit(budget)
    excesses, share = (
        [],
        "" if budget.percentile is None else f" ({budget.percentile:g} % of the designs)",
    )
    if budget.max is not None and value > budget.max:
        excesses.append(
            f"{_digits(value, budget.max)}{unit}{share} is above max {budget.max:.6g}{unit}"
        )
    if budget.min is not None and value < budget.min:
        excesses.append(
            f"{_digits(value, budget.min)}{unit}{share} is below min {budget.min:.6g}{unit}"
        )
    return excesses


def _beyond_baseline(
    budget: Budget, value: float, before: float | None, baseline: Baseline | None
) -> list[str]:
    """Which changes against a baseline a budget does not allow.

    Args: before, the value in the baseline.
    """
    unit, excesses = _unit(budget), []
    if budget.baseline_tolerance is not None and baseline is not None and before is not None:
        value, margin = six_digits(value), budget.margin(before, baseline.largest(budget.metric))
        for sign, word, plus, better in (
            (1.0, "above", "+", "less"),
            (-1.0, "below", "−", "greater"),
        ):
            limit = before + sign * margin
            if budget.worse != better and sign * value > sign * limit:
                allowed = f"the baseline {before:.6g} {plus} {budget.baseline_tolerance}"
                excesses.append(
                    f"{_digits(value, limit)}{unit} is {word} {limit:.6g}{unit}, which is {allowed}"
                )
    return excesses


def _unit(budget: Budget) -> str:
    """The unit of a budget's metric behind a number."""
    unit = budget.selection.quantity.unit
    return "" if unit == "1" else f" {unit}"


def _digits(value: float, limit: float) -> str:
    """A value with as many digits as tell it from its limit."""
    return f"{value:.6g}" if f"{value:.6g}" != f"{limit:.6g}" else repr(value)


def _refuse_missing(baseline: Baseline, keys: list[OutcomeKey]) -> None:
    for case, angle, at, metric in keys:
        if OutcomeKey(case, angle, at, metric) not in baseline.values:
            strike = "" if angle is None else f" at {angle:g} deg"
            raise StudyError(
                f'baseline "{baseline.path}" has no {metric} at "{printable(at)}"{strike}; write '
                f"it anew with --update-baseline"
            )
