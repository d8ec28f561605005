"""What changes a number of a landing, in a designer's units: one row for every parameter, the largest effect first."""

import math
from typing import Any

from shockpc.show.document import record
from shockpc.show.header import header_lines, shown_as, vector_text, warning_lines
from shockpc.show.reports.report import Picture, Report
from shockpc.show.tables import Lines, Row, Sheet, largest
from shockpc.studies.sensitivity import Effect, Sensitivity

PARAMETERS = {
    "mass": "mass (at its CoM)",
    "proportion": "mass and inertia",
    "com": "CoM",
    "inertia": "inertia",
    "armature": "reflected inertia",
    "strike": "strike angle",
}


def sensitivity_report(study: Sensitivity, most: int) -> Report:
    """The effects. Args: most, rows of the table on a terminal."""
    now = f"{study.target.title}: {study.value:.4g} {study.target.unit}".removesuffix(" -")
    if math.isfinite(study.ropc):
        now += f"; CoPc of {study.body} at ({vector_text(study.copc)}) m, RoPc {study.ropc:.4g} m"
    return Report(
        name="sensitivity",
        title=f"What changes the {study.target.title}",
        body=lambda full: [
            Lines([*header_lines(study.profile), ("target", now)]),
            Picture("sensitivity", f"the largest effects on the {study.target.title}", "tornado:draw_tornado", (study,)),
            _table(study, None if full else most),
        ],
        warnings=warning_lines(study.profile),
        sheets={"sensitivity": lambda: _spreadsheet(study)},
        document=lambda: _document(study),
    )


def effect_words(effect: Effect) -> str:
    """What is changed."""
    joint = "joint angle" if effect.unit == "rad" else "joint position"
    return f"{PARAMETERS.get(effect.kind, joint)} {effect.axis}".strip()


def step_words(effect: Effect) -> str:
    """The change in a designer's units."""
    if effect.unit == "1":
        return f"+{100.0 * effect.step:g} %"
    return f"+{1e3 * effect.step:g} g" if effect.unit == "kg" else f"+{shown_as(effect.step, effect.unit, 4)}"


def _document(study: Sensitivity) -> dict[str, Any]:
    """The document, schema `shockpc.sensitivity/1`: derivatives in SI units, and the step that tables and figure use."""
    return {
        "scene": study.profile.scene,
        "target": study.target.name,
        "unit": study.target.selection.quantity.unit,
        **record(study, "value", "body", "copc", "ropc"),
        "warnings": study.profile.health.warnings,
        "effects": [
            {
                "parameter": effect.kind,
                "axis": effect.axis or None,
                "of": effect.name or None,
                **record(effect, "value", "unit", "step", "derivative"),
                "d_copc": effect.copc,
                "d_ropc": effect.ropc,
                "reason": effect.reason or None,
            }
            for effect in study.effects
        ],
    }


def _table(study: Sensitivity, most: int | None) -> Sheet:
    """The effects of one step. Args: most, number of rows; None for all."""
    rows: list[Row] = []
    for effect in study.ranked:
        change, ropc, *copc = _changes(effect)
        now = "–" if effect.unit == "1" else shown_as(effect.value, effect.unit, 4)
        changes = (change, 100.0 * change / study.value, 100.0 * ropc / study.ropc, *(1e3 * x for x in copc))
        rows.append((effect_words(effect), effect.name or "–", now, step_words(effect), *changes))
    rows, left = largest(rows, most, "parameter")
    key, percussion = study.target.selection.name, ("RoPc [%]", "CoPc x [mm]", "CoPc y [mm]", "CoPc z [mm]")
    header = ("parameter", "of", "now", "change", f"{key} [{study.target.unit}]", f"{key} [%]", *percussion)
    notes = [
        "to first order: a change of the opposite sign has the opposite effect; of a larger one the effect is not in proportion",
        *left,
        *(f'joint "{effect.name}" has no effect of its own: {effect.reason}' for effect in study.effects if effect.reason),
    ]
    where = "" if study.body is None else f", and on RoPc and CoPc of {study.body}"
    return Sheet(f"effect on the {study.target.title}{where}", header, rows, notes)


def _spreadsheet(study: Sensitivity) -> Sheet:
    rows: list[Row] = [
        (f"{effect.kind} {effect.axis}".strip(), effect.name or None, effect.value, effect.unit, effect.step, *_changes(effect))
        for effect in study.ranked
    ]
    target = f"{study.target.selection.name} [{study.target.unit}]"
    changes = (target, "RoPc [m]", "CoPc x [m]", "CoPc y [m]", "CoPc z [m]")
    return Sheet("", ("parameter", "of", "value", "unit", "step", *changes), rows)


def _changes(effect: Effect) -> list[float]:
    """What one step changes: the target, RoPc, and CoPc along x, y and z, in SI units."""
    return [float(x) * effect.step for x in (effect.derivative, effect.ropc, *effect.copc)]
