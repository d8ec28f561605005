"""An optimum: what it gains, what holds it there, what each variable does, and how the worst
landing changes.
"""

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from shockpc.evaluation.designs import Design
from shockpc.evaluation.drive_ends import AT_BOTH, BETWEEN, BEYOND
from shockpc.evaluation.variation import OF_A_LINK
from shockpc.landing.scene_file import scene_text
from shockpc.show.document import record
from shockpc.show.header import shared_lines, shared_warnings
from shockpc.show.report import Picture, Report, Section
from shockpc.show.tables import Lines, Row, Sheet, sheet_of
from shockpc.show.wording import at_place, count, proof_text, size_at_place
from shockpc.studies.compare.report import compare_report
from shockpc.studies.compare.study import STANDARD, WITH_FRICTION, compare
from shockpc.studies.improve.study import DriveEnd, Improvement
from shockpc.text.errors import ShockError
from shockpc.text.printed import few


def improve_report(study: Improvement) -> Report:
    """The optimum."""
    worst = {"as given": study.before[study.worst], "optimum": study.after[study.worst]}
    quantities = [cost.quantity for cost in study.costs]
    further = [
        text
        for text in quantities
        if "," not in text and text.partition("@")[0] not in (*STANDARD, *WITH_FRICTION)
    ]
    compared = compare_report(
        compare([Design(label, one.scene, one.robot) for label, one in worst.items()], further)
    )
    sheets: dict[str, Callable[[], Sheet]] = {"variables": lambda: _variables(study)}
    figures = [
        Picture(
            "runs",
            "the target over the steps of the runs",
            "studies.improve.figure:draw_runs",
            (study,),
        )
    ]
    if study.front:
        sheets["front"] = lambda: _front(study)
        figures.append(
            Picture(
                "front", "the front of two numbers", "studies.improve.figure:draw_front", (study,)
            )
        )

    def body(full: bool) -> Iterator[Section]:
        yield Lines([*shared_lines(study.after), *_lines(study)])
        yield from (make() for make in sheets.values())
        if _moves(study):
            yield _drives(study)
        yield from figures
        yield from itertools.islice(compared.body(full), None if full else 4)
        if not full:
            yield Lines(["--out writes how the other numbers change"])

    return Report(
        name="improve",
        title=f"Optimum of {few(list(map(at_place, quantities)), 2)}",
        body=body,
        lead=1 + 2 * len(figures) + _moves(study),
        closing=compared.closing,
        warnings=shared_warnings(study.after),
        sheets={
            **sheets,
            "quantities": lambda: _quantities(study),
            "compare": compared.sheets["compare"],
        }
        | ({"compare_drives": compared.sheets["drives"]} if "drives" in compared.sheets else {})
        | ({"drives": lambda: _drives(study)} if study.ends else {}),
        tables=True,
        document=lambda: _document(study),
        more=lambda folder: {
            f"optimum-{k}.toml": scene_text(profile.scene, folder)
            for k, profile in enumerate(study.after.values(), start=1)
        },
        landings={f"{label}: {study.worst}": one for label, one in worst.items()},
    )


def _lines(study: Improvement) -> list[tuple[str, str]]:
    """Before and after, what holds the optimum, and how far it can be trusted."""
    lines, over = (
        list[tuple[str, str]](),
        f", the worst of {len(study.after)} landings" if len(study.after) > 1 else "",
    )
    for cost, (before, after) in zip(study.costs, study.values, strict=True):
        gain = (
            f" ({100.0 * (after / before - 1.0):+.3g} %)"
            if before and math.isfinite(after / before)
            else ""
        )
        unit = f" {cost.column.unit}".removesuffix(" -")
        lines.append(
            (at_place(cost.quantity), f"{before:.4g}{unit} → {after:.4g}{unit}{gain}{over}")
        )
    lines += _over_drives(study)
    cost = study.costs[0]
    before, after = cost.column.selection.worse(np.array(study.values[0]))
    if math.isnan(study.values[0][0]):
        lines.append(("as given", "the number has no value"))
    elif math.isclose(before, after, rel_tol=1e-6):
        lines.append(("as given", "no point is better, by more than a millionth"))
    elif after > before:
        differing = [one.name for one in study.variables if math.isnan(one.before)]
        outside = [
            one.name
            for one, (low, high) in zip(study.variables, cost.bounds, strict=True)
            if not low <= one.before <= high
        ]
        reason = (
            f"it lies outside the range of {few(outside, 4)}"
            if outside
            else "it misses constraints"
        )
        if differing:
            reason = f"there the joints of {few(differing, 4)} differ, which have one value here"
        lines.append(("as given", f"better than the optimum: {reason}"))
    bounds = [f"{one.name} at its {one.bound} value" for one in study.variables if one.bound]
    lines += [("by default", "; ".join(study.chosen))] if study.chosen else []
    lines.append(
        (
            "held by",
            few([*bounds, *study.active], 6)
            or "nothing: it lies inside all ranges and constraints",
        )
    )
    slopes = "exact derivatives" if cost.exact else "differences"
    runs = (
        f"{count(len(study.runs), 'run')} by {slopes}, {study.agreeing} of them to within 1 % of "
        f"the optimum; seed {study.seed}"
    )
    lines.append(("runs", f"{runs}; a better optimum may exist"))
    profiles = (*study.before.values(), *study.after.values())
    unproven = any(
        cost.column.selection.quantity.of_ground(profile.scene)
        for cost in study.costs
        for profile in profiles
    )
    proof = proof_text(max(profile.health.error_bound for profile in profiles))
    lines.append(
        (
            "accuracy",
            "both values in double precision" if unproven else f"both values: {proof}",
        )
    )
    return lines


def _moves(study: Improvement) -> bool:
    """Whether the optimum depends on the drives."""
    return any(isinstance(one, ShockError) or study.moves(one) for one in study.ends.values())


def _drives(study: Improvement) -> Sheet:
    """The number and the optimum as modelled, and with the smallest and the largest inertias of the
    drives.
    """
    cost, (given, after) = study.costs[0], study.values[0]
    number = size_at_place(cost.quantity, cost.column)
    unit = number.partition(" [")[2]
    names = [
        f"{what} [{unit}"
        for what in ("as given", "at the optimum as modelled", "at the best found")
    ]
    modelled = [given, after, after, *study.x.tolist()]
    found: dict[str, Sequence[str | float | None]] = {
        end: _column(one, len(modelled)) for end, one in study.ends.items()
    }
    notes = [
        "best found: by runs from the optimum as modelled and from the landing as given",
        BEYOND,
    ]
    columns: dict[str, Sequence[str | float | None]] = {
        "number or variable": [*names, *cost.names],
        "as modelled": modelled,
    }
    return Sheet.of(AT_BOTH, columns | found, notes)


def _column(found: DriveEnd | ShockError, size: int) -> list[float | None]:
    """The numbers and variables of an end. Args: size, how many there are."""
    if isinstance(found, ShockError):
        return [None] * size
    return [found.given, found.there, found.best, *found.x.tolist()]


def _over_drives(study: Improvement) -> list[tuple[str, str]]:
    """How the optimum depends on the drives."""
    if not study.ends:
        return []
    if not _moves(study):
        least = (
            "neither the number at the optimum nor a variable changes by more than 1 % (1 degree, "
            "1 cm)"
        )
        return [("drives", f"from {BETWEEN}, {least}")]
    lines, unit = list[tuple[str, str]](), f" {study.costs[0].column.unit}".removesuffix(" -")
    for end, found in study.ends.items():
        if isinstance(found, ShockError):
            lines.append((f"{end} drives", f"no answer: {found}"))
            continue
        there = (
            "misses a constraint at this optimum"
            if math.isnan(found.there)
            else f"→ {found.there:.4g}{unit} at this optimum"
        )
        best = (
            "none is found"
            if math.isnan(found.best)
            else f"{found.best:.4g}{unit} at the best that is found"
        )
        lines.append((f"{end} drives", f"{found.given:.4g}{unit} {there}; {best}"))
    return lines


def _variables(study: Improvement) -> Sheet:
    notes = [
        "5 %: the range of this variable, up to its bounds and with the others unchanged, in which "
        "the target is at most 5 % worse "
        "than at the optimum; 5 % of the value as given where that at the optimum is nearly zero",
        "set back, and 5 %: the constraints may not hold there",
    ]
    if changed := [
        one.subject for one in study.costs[0].variations if one.kind in (*OF_A_LINK, "place")
    ]:
        notes.append(
            f"{few(changed, 4)}: of the robot itself, and so not in the scene; change it in its "
            f"file"
        )
    return sheet_of(study.table, "what each variable does", notes)


def _quantities(study: Improvement) -> Sheet:
    rows: list[Row] = [
        (cost.quantity, cost.column.unit, *values)
        for cost, values in zip(study.costs, study.values, strict=True)
    ]
    return Sheet("numbers", ("quantity", "unit", "as given", "optimum"), rows)


def _front(study: Improvement) -> Sheet:
    numbers = [size_at_place(cost.quantity, cost.column) for cost in study.costs]
    rows = [(*point.values.tolist(), *point.x.tolist()) for point in study.front]
    return Sheet("front, in double precision", (*numbers, *study.costs[0].names), rows)


def _document(study: Improvement) -> dict[str, Any]:
    """The document, schema `shockpc.improve/2`."""
    return {
        "worst": study.worst or None,
        **record(study, "active", "runs", "agreeing", "seed"),
        "landings": [
            {"landing": name or None, "before": study.before[name].scene, "after": profile.scene}
            for name, profile in study.after.items()
        ],
    }
