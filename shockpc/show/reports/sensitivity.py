"""What changes the shock at a point, in a designer's units: one row for every quantity, the largest effect first."""

import math
from typing import Any

from shockpc.show.document import record
from shockpc.show.header import header_lines, shown_as, vector_text, warning_lines
from shockpc.show.reports.report import Picture, Report
from shockpc.show.tables import Row, Sheet, largest
from shockpc.studies.sensitivity import Effect, ShockSensitivity

__all__ = ["effect_words", "sensitivity_report", "step_words"]

QUANTITIES = {
    "mass": "mass (at its CoM)",
    "proportion": "mass and inertia",
    "com": "CoM",
    "inertia": "inertia",
    "armature": "reflected inertia",
    "strike": "strike angle",
}


def sensitivity_report(found: ShockSensitivity, most: int) -> Report:
    """The effects. Args: most, rows of the table on a terminal."""
    now = f"{found.point} on {found.body}: shock {found.shock:.4g}"
    if math.isfinite(found.ropc):
        now += f", CoPc of the body at ({vector_text(found.copc)}) m, RoPc {found.ropc:.4g} m"
    return Report(
        name="sensitivity",
        title=f"What changes the shock at {found.point}",
        header=[*header_lines(found.profile), ("point", now)],
        tables=lambda most: [_sheet(found, most)],
        short=most,
        warnings=warning_lines(found.profile),
        sheets={"sensitivity": lambda: _effects(found)},
        document=lambda: _document(found),
        picture=Picture("sensitivity", "the largest effects on the shock", "tornado:draw_tornado", (found,)),
    )


def effect_words(effect: Effect) -> str:
    """What is changed."""
    joint = "joint angle" if effect.unit == "rad" else "joint position"
    return f"{QUANTITIES.get(effect.kind, joint)} {effect.axis}".strip()


def step_words(effect: Effect) -> str:
    """The change in a designer's units."""
    if effect.unit == "1":
        return f"+{100.0 * effect.step:g} %"
    return f"+{1e3 * effect.step:g} g" if effect.unit == "kg" else f"+{shown_as(effect.step, effect.unit, 4)}"


def _document(found: ShockSensitivity) -> dict[str, Any]:
    """The document, schema `shockpc.sensitivity/1`: derivatives in SI units, and the step that tables and figure use."""
    return {
        "scene": found.profile.scene,
        **record(found, "point", "body", "shock", "copc", "ropc"),
        "warnings": found.profile.health.warnings,
        "effects": [
            {
                "quantity": effect.kind,
                "axis": effect.axis or None,
                "of": effect.name or None,
                **record(effect, "value", "unit", "step"),
                "d_shock": effect.shock,
                "d_copc": effect.copc,
                "d_ropc": effect.ropc,
                "reason": effect.reason or None,
            }
            for effect in found.effects
        ],
    }


def _sheet(found: ShockSensitivity, most: int | None) -> Sheet:
    """The effects of one step. Args: most, number of rows; None for all."""
    rows: list[Row] = []
    for effect in found.ranked:
        shock, ropc, *copc = (x * effect.step for x in (effect.shock, effect.ropc, *effect.copc))
        now = "–" if effect.unit == "1" else shown_as(effect.value, effect.unit, 4)
        changes = (shock, 100.0 * shock / found.shock, 100.0 * ropc / found.ropc, *(1e3 * x for x in copc))
        rows.append((effect_words(effect), effect.name or "–", now, step_words(effect), *changes))
    rows, left = largest(rows, most, "quantity")
    header = ("quantity", "of", "now", "change", "shock [-]", "shock [%]", "RoPc [%]", "CoPc x [mm]", "CoPc y [mm]", "CoPc z [mm]")
    notes = [
        "to first order: a change of the opposite sign has the opposite effect; of a larger one the effect is not in proportion",
        *left,
        *(f'joint "{effect.name}" has no effect of its own: {effect.reason}' for effect in found.effects if effect.reason),
    ]
    return Sheet(f"effect on the shock at {found.point}, and on RoPc and CoPc of {found.body}", header, rows, notes)


def _effects(found: ShockSensitivity) -> Sheet:
    """The same with numbers in SI units, for a spreadsheet."""
    rows: list[Row] = []
    for effect in found.ranked:
        shock, ropc, *copc = (x * effect.step for x in (effect.shock, effect.ropc, *effect.copc))
        what = f"{effect.kind} {effect.axis}".strip()
        rows.append((what, effect.name or None, effect.value, effect.unit, effect.step, shock, ropc, *copc))
    changes = ("shock [-]", "RoPc [m]", "CoPc x [m]", "CoPc y [m]", "CoPc z [m]")
    return Sheet("", ("quantity", "of", "value", "unit", "step", *changes), rows)
