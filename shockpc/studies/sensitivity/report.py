"""What changes a number of a landing, in a designer's units: one row for every parameter, the largest effect first."""

import math
from collections.abc import Sequence
from typing import Any

from shockpc.show.document import record
from shockpc.show.report import Picture, Report
from shockpc.show.tables import Lines, Row, Sheet, sheet_of
from shockpc.show.wording import count, shared_lines, shared_warnings, shown_as
from shockpc.studies.sensitivity.study import Effect, Sensitivity
from shockpc.text.printed import listed

PARAMETERS = {
    "mass": "mass (at its CoM)",
    "proportion": "mass and inertia",
    "com": "CoM",
    "inertia": "inertia",
    "armature": "reflected inertia",
    "strike": "strike angle",
    "place": "placement",
}


ROWS = 16
"""Rows of the table on a terminal."""


def sensitivity_report(study: Sensitivity) -> Report:
    """The effects."""
    landings = dict(zip(study.landings, study.profiles, strict=True))
    now = f"{study.target.title}: {study.value:.4g} {study.target.unit}".removesuffix(" -")
    if len(landings) > 1:
        now += f", {_over(study)}; the worst is {study.worst}"
    picture = Picture(
        "sensitivity",
        f"the largest effects on the {study.target.title}",
        "studies.sensitivity.figure:draw_tornado",
        (study,),
    )
    return Report(
        name="sensitivity",
        title=f"What changes the {study.target.title}",
        body=lambda full: [
            Lines([*shared_lines(landings), ("target", now)]),
            *([picture] if study.ranked else []),
            _table(study, None if full else ROWS),
        ],
        warnings=shared_warnings(landings),
        sheets={"sensitivity": lambda: sheet_of(study.table)},
        document=lambda: _document(study),
    )


def _over(study: Sensitivity) -> str:
    return f"{'mean' if study.mean else 'the worst'} of {count(len(study.landings), 'landing')}"


def change_words(change: Effect) -> str:
    """What is changed."""
    joint = "joint position" if change.unit == "m" else "joint angle"
    return (
        f"{PARAMETERS.get(change.kind, joint if change.kind == 'angle' else change.kind.replace('-', ' '))} {change.axis}".strip()
    )


def step_words(change: Effect) -> str:
    """How far it is changed, in a designer's units."""
    if change.unit == "1":
        return f"+{100.0 * change.step:.3g} %"
    if change.unit == "kg":
        return f"+{1e3 * change.step:.3g} g"
    return f"+{shown_as(change.step, change.unit)}".removesuffix(" -")


def _document(study: Sensitivity) -> dict[str, Any]:
    """The document, schema `shockpc.sensitivity/1`: derivatives in SI units, and the step that tables and figure use."""
    return {
        "target": study.target.name,
        "unit": study.target.selection.quantity.unit,
        "worse": study.target.selection.quantity.worse,
        "over": "mean" if study.mean else "worst",
        **record(study, "value", "percent"),
        "exact": all(effect.formula for effect in study.effects),
        "landings": [
            {"landing": name or None, "value": float(value), "warnings": profile.health.warnings, "scene": profile.scene}
            for name, value, profile in zip(study.landings, study.values, study.profiles, strict=True)
        ],
        "effects": [
            {
                "parameter": effect.kind,
                "axis": effect.axis or None,
                "of": effect.name or None,
                **record(effect, "value", "unit", "step"),
                "parts": [{"of": name or None, "axis": axis or None, "weight": w} for (_, axis, name), w in effect.parts.items()],
                **record(effect, "derivatives", "error", "up"),
                "down": study.opposite(effect),
                "reason": effect.reason or None,
                "formula": effect.formula,
            }
            for effect in study.effects
        ],
    }


def _table(study: Sensitivity, most: int | None) -> Sheet:
    """The effects of one step. Args: most, number of rows; None for all."""
    rows: list[Row] = []
    single = len(study.landings) == 1
    for effect in study.ranked:
        now = None if effect.unit == "1" or math.isnan(effect.value) else shown_as(effect.value, effect.unit, 4).removesuffix(" -")
        changes = (effect.up, effect.up / study.value, *(() if single else (study.opposite(effect) / study.value,)))
        rows.append((change_words(effect), effect.name or None, now, step_words(effect), *changes))
    key, unit = study.target.selection.name, study.target.unit
    opposite_head = () if single else (f"{key}, opposite change [%]",)
    header = ("parameter", "of", "now", "change", f"{key} [{unit}]", f"change of {key} [%]", *opposite_head)
    title = f"effect on the {study.target.title}{'' if single else f', {_over(study)}'}"
    sheet = Sheet(title, header, rows).largest(most, "parameter", range(len(rows), 0, -1))
    without: dict[str, list[str]] = {}
    for effect in study.effects:
        if effect.reason:
            without.setdefault(effect.reason, []).append(f"{change_words(effect)} {effect.name}".strip())
    opposite = (
        "a change of the opposite sign has the opposite effect" if single or study.mean else "another landing may become the worst"
    )
    notes = [
        f"change: {study.percent:g} % of the range given, or else of the mass, mean moment of inertia, radius of gyration (CoM), "
        "reflected inertia (without one: the inertia that the joint moves), of a radian, or of the robot's length",
        f"to first order: {opposite}; of a larger one the effect is not in proportion",
        *sheet.notes,
        *([_accuracy(study, study.ranked[: len(sheet.rows)])] if rows else []),
        *(f"{listed(names, 4)}: no derivative, because {reason}" for reason, names in without.items()),
    ]
    return sheet._replace(notes=notes)


def _accuracy(study: Sensitivity, shown: Sequence[Effect]) -> str:
    formulas = [one for one in study.effects if one.formula]
    which = "derivatives by angles and the strike are those of formulas, the others" if formulas else "derivatives are"
    return f"{which} differences, with an error of at most {max(study.error(shown), 1e-15):.0e} of each"
