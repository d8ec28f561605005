"""The report of an optimum.

It says what is gained, what holds it there, what each variable does, and how the worst landing
changes.
"""

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from shockpc.evaluation.comparison import STANDARD, WITH_FRICTION, Comparison, compared
from shockpc.evaluation.designs import Design
from shockpc.evaluation.drive_ends import AT_BOTH, BETWEEN, BEYOND, any_moves
from shockpc.landing.scenes.scene_file import scene_text
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.show.comparison import compare_report
from shockpc.show.document import record
from shockpc.show.header import shared_lines, shared_warnings
from shockpc.show.report import Picture, Report, Section
from shockpc.show.tables import Lines, Sheet, sheet_of
from shockpc.show.wording import at_place, proof_text
from shockpc.studies.improve.improvement import Improvement
from shockpc.text.errors import ShockError
from shockpc.text.printed import count, few

SECTIONS = 4
"""Sections of the comparison that the short report shows."""


def improve_report(improvement: Improvement) -> Report:
    """The optimum."""
    quantity = improvement.cost.quantity
    worst = {
        "as given": improvement.before[improvement.worst],
        "optimum": improvement.after[improvement.worst],
    }
    # The worst landing before and after, as `shockpc compare` shows two designs.
    comparison = compare_report(_comparison(quantity, worst))
    picture = Picture(
        "runs",
        "the target over the steps of the runs",
        "studies.improve.figure:draw_runs",
        (improvement,),
    )
    moves = any_moves(improvement.ends, improvement.moves)

    def body(full: bool) -> Iterator[Section]:
        yield Lines([*shared_lines(improvement.after), *_lines(improvement)])
        yield _variables(improvement)
        if moves:
            yield _drives(improvement)
        yield picture
        yield from itertools.islice(comparison.body(full), None if full else SECTIONS)
        if not full:
            yield Lines(["--out writes how the other numbers change"])

    # Functions, because the printed report needs few of the sheets.
    sheets: dict[str, Callable[[], Sheet]] = {
        "variables": lambda: _variables(improvement),
        "quantities": lambda: _quantities(improvement),
        "compare": comparison.sheets["compare"],
    }
    # Both results may have ends of the drives, in files of different names.
    if "drives" in comparison.sheets:
        sheets["compare_drives"] = comparison.sheets["drives"]
    if improvement.ends:
        sheets["drives"] = lambda: _drives(improvement)

    # The landings at the optimum as files that other commands take.
    def scenes(folder: Path) -> dict[str, str]:
        profiles = enumerate(improvement.after.values(), start=1)
        return {f"optimum-{k}.toml": scene_text(profile.scene, folder) for k, profile in profiles}

    return Report(
        name="improve",
        title=f"Optimum of {at_place(quantity)}",
        body=body,
        lead=3 + moves,
        closing=comparison.closing,
        warnings=shared_warnings(improvement.after),
        sheets=sheets,
        tables=True,
        document=lambda: _document(improvement),
        more=scenes,
        landings={f"{label}: {improvement.worst}": profile for label, profile in worst.items()},
    )


def _comparison(quantity: str, landings: Mapping[str, ShockProfile]) -> Comparison:
    """The comparison of the worst landing as given and at the optimum.

    It is in the standard quantities, and in the quantity if it is another one.
    """
    key, _, places = quantity.partition("@")
    is_standard = key in (*STANDARD, *WITH_FRICTION)
    # A place with an offset is one of the scene's points.
    more = [] if is_standard or "," in places else [quantity]
    designs = [Design(label, profile.scene, profile.robot) for label, profile in landings.items()]
    return compared(designs, more)


def _with_unit(improvement: Improvement, value: float) -> str:
    """A value of the number, with its unit."""
    return f"{value:.4g} {improvement.cost.column.unit}".removesuffix(" -")


def _lines(improvement: Improvement) -> list[tuple[str, str]]:
    """Before and after, what holds the optimum, and how far it can be trusted."""
    before, after = improvement.values
    number = f"{_with_unit(improvement, before)} → {_with_unit(improvement, after)}"
    if before and math.isfinite(after / before):
        number += f" ({100.0 * (after / before - 1.0):+.3g} %)"
    if len(improvement.after) > 1:
        number += f", the worst of {len(improvement.after)} landings"
    lines = [(at_place(improvement.cost.quantity), number), *_over_drives(improvement)]
    as_given = _as_given(improvement)
    if as_given:
        lines.append(("as given", as_given))
    if improvement.chosen:
        lines.append(("by default", "; ".join(improvement.chosen)))
    bounds = [
        f"{variable.name} at its {variable.bound} value"
        for variable in improvement.variables
        if variable.bound
    ]
    holding = few([*bounds, *improvement.active], 6)
    lines.append(("held by", holding or "nothing: it lies inside all ranges and constraints"))
    slopes = "exact derivatives" if improvement.cost.exact else "differences"
    lines.append(
        (
            "runs",
            f"{count(len(improvement.runs), 'run')} by {slopes}, {improvement.agreeing} of them to "
            f"within 1 % of the optimum; seed {improvement.seed}; a better optimum may exist",
        )
    )
    lines.append(("accuracy", _accuracy(improvement)))
    return lines


def _as_given(improvement: Improvement) -> str:
    """The comparison of the landing as given with an optimum that is no better; else empty."""
    if math.isnan(improvement.values[0]):
        return "the number has no value"
    before, after = improvement.cost.column.selection.worse(np.array(improvement.values))
    if math.isclose(before, after, rel_tol=1e-6):
        return "no point is better, by more than a millionth"
    if not after > before:
        return ""
    differing = [variable.name for variable in improvement.variables if math.isnan(variable.before)]
    outside = []
    for variable, (low, high) in zip(improvement.variables, improvement.cost.bounds, strict=True):
        if not low <= variable.before <= high:
            outside.append(variable.name)
    reason = "it misses constraints"
    if differing:
        reason = f"the joints of {few(differing, 4)} have one value here, but differ there"
    elif outside:
        reason = f"it lies outside the range of {few(outside, 4)}"
    return f"better than the optimum: {reason}"


def _accuracy(improvement: Improvement) -> str:
    """The accuracy of both values."""
    profiles = (*improvement.before.values(), *improvement.after.values())
    quantity = improvement.cost.column.selection.quantity
    if any(quantity.of_ground(profile.scene) for profile in profiles):
        return "both values in double precision"
    return f"both values: {proof_text(max(profile.health.error_bound for profile in profiles))}"


def _drives(improvement: Improvement) -> Sheet:
    """The number and the optimum, as modelled and at both ends of the drives."""
    cost, (before, after) = improvement.cost, improvement.values
    labels = ("as given", "at the optimum as modelled", "at the best found")
    names = [f"{label} [{cost.column.unit}]" for label in labels]
    columns: dict[str, Sequence[str | float | None]] = {
        "number or variable": [*names, *cost.names],
        "as modelled": [before, after, after, *improvement.x.tolist()],
    }
    for end, result in improvement.ends.items():
        if isinstance(result, ShockError):
            columns[end] = [None] * (len(names) + len(improvement.x))
        else:
            columns[end] = [result.given, result.there, result.best, *result.x.tolist()]
    notes = [
        "best found: by runs from the optimum as modelled and from the landing as given",
        BEYOND,
    ]
    return Sheet.of(AT_BOTH, columns, notes)


def _over_drives(improvement: Improvement) -> list[tuple[str, str]]:
    """Lines on how the optimum depends on the drives."""
    if not improvement.ends:
        return []
    if not any_moves(improvement.ends, improvement.moves):
        least = (
            "neither the number at the optimum nor a variable changes by more than 1 % (1 degree, "
            "1 cm)"
        )
        return [("drives", f"from {BETWEEN}, {least}")]
    lines = []
    for end, result in improvement.ends.items():
        if isinstance(result, ShockError):
            lines.append((f"{end} drives", f"no answer: {result}"))
            continue
        there = f"→ {_with_unit(improvement, result.there)} at this optimum"
        if math.isnan(result.there):
            there = "misses a constraint at this optimum"
        best = f"{_with_unit(improvement, result.best)} at the best that is found"
        if math.isnan(result.best):
            best = "none is found"
        before = _with_unit(improvement, result.given)
        lines.append((f"{end} drives", f"{before} {there}; {best}"))
    return lines


def _variables(improvement: Improvement) -> Sheet:
    """A row for each variable: its effect at the optimum."""
    notes = [
        "5 %: the range of this variable, with the others unchanged, in which the target is at "
        "most 5 % worse than at the optimum (5 % of the value as given, if the optimum is nearly "
        "zero)",
        "set back, and 5 %: the constraints may not hold there",
    ]
    changed = [varied.subject for varied in improvement.cost.variations if varied.kind.of_robot]
    if changed:
        notes.append(
            f"{few(changed, 4)}: of the robot itself, and so not in the scene; change it in its "
            f"file"
        )
    return sheet_of(improvement.table, "what each variable does", notes)


def _quantities(improvement: Improvement) -> Sheet:
    """The number as given and at the optimum."""
    row = (improvement.cost.quantity, improvement.cost.column.unit, *improvement.values)
    return Sheet("numbers", ("quantity", "unit", "as given", "optimum"), [row])


def _document(improvement: Improvement) -> dict[str, Any]:
    """The entries of the document that are no tables, schema `shockpc.improve/2`."""
    return {
        "worst": improvement.worst or None,
        **record(improvement, "active", "runs", "agreeing", "seed"),
        "landings": [
            {
                "landing": name or None,
                "before": improvement.before[name].scene,
                "after": profile.scene,
            }
            for name, profile in improvement.after.items()
        ],
    }
