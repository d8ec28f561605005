"""Effects on a number of a landing: one row for every parameter, the largest effect first."""

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from shockpc.evaluation.drive_ends import BETWEEN, BEYOND, MOVED, answer_lines, any_moves
from shockpc.show.document import record
from shockpc.show.header import shared_lines, shared_warnings
from shockpc.show.report import Picture, Report, Section
from shockpc.show.tables import Lines, Row, Sheet, sheet_of
from shockpc.studies.sensitivity.study import Sensitivity
from shockpc.text.printed import count, listed

ROWS = 16
"""Rows of the table on a terminal."""

DRIVES = "smallest, largest: the change with the smallest and the largest possible inertias"
"""The note under columns of the ends of the drives."""


def sensitivity_report(sensitivity: Sensitivity) -> Report:
    """The effects."""
    landings = dict(zip(sensitivity.landings, sensitivity.profiles, strict=True))
    title = sensitivity.target.title
    now = f"{title}: {_with_unit(sensitivity)}"
    if len(landings) > 1:
        now += f", {_over(sensitivity)}; the worst is {sensitivity.worst}"
    picture = Picture(
        "sensitivity",
        f"the largest effects on the {title}",
        "studies.sensitivity.figure:draw_tornado",
        (sensitivity,),
    )

    def body(full: bool) -> list[Section]:
        sections: list[Section] = [Lines([*shared_lines(landings), ("target", now)])]
        if sensitivity.ranked:
            sections.append(picture)
        sections.append(_table(sensitivity, None if full else ROWS))
        return sections

    sheets: dict[str, Callable[[], Sheet]] = {
        "sensitivity": lambda: _effects(sensitivity),
        "derivatives": lambda: _derivatives(sensitivity),
    }
    if sensitivity.ends:
        sheets["drives"] = lambda: _drives(sensitivity)
    return Report(
        name="sensitivity",
        title=f"What changes the {title}",
        body=body,
        closing=_over_drives(sensitivity),
        warnings=shared_warnings(landings),
        sheets=sheets,
        document=lambda: _document(sensitivity),
        tables=True,
    )


def _with_unit(sensitivity: Sensitivity) -> str:
    """The number with its unit."""
    return f"{sensitivity.value:.4g} {sensitivity.target.unit}".removesuffix(" -")


def _moves(sensitivity: Sensitivity) -> bool:
    """True if the number, or one of its largest effects, differs between the ends of the drives."""
    return any_moves(sensitivity.ends, partial(_differs, sensitivity))


def _differs(sensitivity: Sensitivity, at_end: Sensitivity) -> bool:
    """True if the number, or one of its largest effects, differs by more than 1 % at an end."""
    if not math.isclose(sensitivity.value, at_end.value, rel_tol=MOVED):
        return True
    changes = {effect.parameter: effect.up for effect in at_end.ranked}
    for effect in sensitivity.ranked[:ROWS]:
        change = changes.get(effect.parameter)
        if change is None or not math.isclose(effect.up, change, rel_tol=MOVED):
            return True
    return False


def _over_drives(sensitivity: Sensitivity) -> list[str]:
    """Lines on how the answer depends on the drives."""
    if not sensitivity.ends:
        return []
    if not _moves(sensitivity):
        return [
            f"drives: from {BETWEEN}, neither the number nor any of the largest effects changes by "
            f"more than 1 %"
        ]
    head = f"drives: the effects change from {BETWEEN}; {BEYOND}"
    return [head, *answer_lines(sensitivity, sensitivity.ends, _answer)]


def _answer(sensitivity: Sensitivity) -> str:
    """The number, and the parameter with the largest effect, in words."""
    text = f"{sensitivity.target.title} {_with_unit(sensitivity)}"
    if sensitivity.ranked:
        text += f"; the largest effect is that of {sensitivity.ranked[0].parameter}"
    return text


def _drives(sensitivity: Sensitivity) -> Sheet:
    """The change by each step as a share of the number, as modelled and at the drives' ends."""
    change = f"change_of_{sensitivity.target.selection.name}"
    sheet = sheet_of(
        sensitivity.table, f"effect on the {sensitivity.target.title}, by the drives", [DRIVES]
    )
    return sheet.only("parameter", change, *sensitivity.ends)


def _over(sensitivity: Sensitivity) -> str:
    landings = count(len(sensitivity.landings), "landing")
    return f"{'mean' if sensitivity.mean else 'the worst'} of {landings}"


def _document(sensitivity: Sensitivity) -> dict[str, Any]:
    """The entries of the document that are no tables."""
    return {
        "target": sensitivity.target.name,
        "unit": sensitivity.target.selection.quantity.unit,
        "worse": sensitivity.target.selection.quantity.worse,
        "over": "mean" if sensitivity.mean else "worst",
        **record(sensitivity, "value", "percent"),
        "landings": [
            {
                "landing": name or None,
                "value": float(value),
                "warnings": profile.health.warnings,
                "scene": profile.scene,
            }
            for name, value, profile in zip(
                sensitivity.landings, sensitivity.values, sensitivity.profiles, strict=True
            )
        ],
    }


def _effects(sensitivity: Sensitivity) -> Sheet:
    """A row for each effect, the largest first, then those without a derivative, with the reason.

    It also has the effects by the drives.
    """
    return sheet_of(sensitivity.table, messages="reason")


def _derivatives(sensitivity: Sensitivity) -> Sheet:
    """The derivative of the number in each landing by each parameter [its unit/unit]."""
    of_number = sensitivity.target.selection.quantity.unit
    rows: list[Row] = []
    for effect in sensitivity.effects:
        unit = f"{of_number}/{effect.unit}".replace("-/-", "-").replace("-/", "1/")
        values = np.asarray(effect.derivatives).tolist()
        for name, value in zip(sensitivity.landings, values, strict=True):
            rows.append((effect.parameter, name or None, value, unit.removesuffix("/-")))
    return Sheet("derivatives", ("parameter", "landing", "derivative", "unit"), rows)


def _table(sensitivity: Sensitivity, most: int | None) -> Sheet:
    """The effects of one step.

    Args:
        sensitivity: the result.
        most: number of rows; None for all.
    """
    single = len(sensitivity.landings) == 1
    moves = _moves(sensitivity)
    every = _effects(sensitivity)
    hidden = ["step", "reason"]
    for key in every.keys:
        if key.startswith("error_") or (single and key.startswith("opposite_")):
            hidden.append(key)
    if not moves:
        hidden += sensitivity.ends
    known = every.where(lambda row: row["reason"] is None).without(*hidden)
    if moves:
        known = known._replace(notes=[DRIVES])
    sheet = known.largest(most, "parameter", range(len(known.rows), 0, -1))
    opposite = "another landing may become the worst"
    if single or sensitivity.mean:
        opposite = "a change of the opposite sign has the opposite effect"
    notes = [
        "as in sweep: point-mass, com and inertia are added to a link; with its mass the inertia "
        "changes in proportion",
        "1 % of an inertia: of the mean moment of the link, or of an armature, without one of the "
        "inertia that the joint moves",
        f"to first order: {opposite}; the effect of a larger change is not in proportion",
    ]
    notes += sheet.notes
    shown = sensitivity.ranked[: len(sheet.rows)]
    if shown:
        error = max(sensitivity.error(shown), 1e-15)
        notes.append(f"derivatives are differences, with an error of at most {error:.0e} of each")
    notes += _without_derivative(sensitivity)
    title = f"effect on the {sensitivity.target.title}"
    if not single:
        title += f", {_over(sensitivity)}"
    return sheet._replace(title=title, notes=notes)


def _without_derivative(sensitivity: Sensitivity) -> list[str]:
    """The parameters without a derivative, by the reason."""
    names: dict[str, list[str]] = {}
    for effect in sensitivity.refused:
        names.setdefault(effect.reason, []).append(effect.parameter)
    return [f"{listed(some, 4)}: no derivative, because {reason}" for reason, some in names.items()]
