"""What changes the shock at a point, in a designer's units: one row for every quantity, the largest effect first."""

import math
from typing import TYPE_CHECKING, Any

from shockpc.show.document import head, plain, record
from shockpc.show.header import count, header_lines
from shockpc.show.reports.report import Report
from shockpc.show.tables.sheets import Cell, Sheet
from shockpc.studies.sensitivity import Effect, ShockSensitivity

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["effect_words", "sensitivity_report", "step_words"]

QUANTITIES = {
    "mass": "mass (at its CoM)",
    "proportion": "mass and inertia",
    "com": "CoM",
    "inertia": "inertia",
    "armature": "reflected inertia",
    "strike": "strike angle",
}

UNITS = {"rad": (math.degrees(1.0), "deg"), "m": (1e3, "mm")}
"""Units of tables by SI unit, and their number in it."""


def sensitivity_report(found: ShockSensitivity, most: int) -> Report:
    """The effects. Args: most, rows of the table on a terminal."""

    def draw() -> "Figure":
        from shockpc.show.figure.tornado import draw_tornado

        return draw_tornado(found)

    return Report(
        name="sensitivity",
        title=f"What changes the shock at {found.point}",
        header=[*header_lines(found.profile), ("point", _present_values(found))],
        tables=lambda most: [_sheet(found, most)],
        closing=[f"warning: {warning}" for warning in found.profile.health.warnings],
        short=most,
        sheets={"sensitivity": lambda: _effects(found)},
        document=lambda: _document(found),
        picture="sensitivity",
        caption="the largest effects on the shock",
        draw=draw,
    )


def effect_words(effect: Effect) -> str:
    """What is changed."""
    joint = "joint angle" if effect.unit == "rad" else "joint position"
    return f"{QUANTITIES.get(effect.kind, joint)} {effect.axis}".strip()


def step_words(effect: Effect) -> str:
    """The change in a designer's units."""
    if effect.unit == "1":
        return f"+{100.0 * effect.step:g} %"
    if effect.unit == "kg":
        return f"+{1e3 * effect.step:g} g"
    factor, unit = UNITS.get(effect.unit, (1.0, effect.unit))
    return f"+{factor * effect.step:.4g} {unit}"


def _document(found: ShockSensitivity) -> dict[str, Any]:
    """The document, schema `shockpc.sensitivity/1`: derivatives in SI units, and the step that tables and figure use."""
    return {
        **head("sensitivity"),
        "scene": plain(found.profile.scene),
        **record(found, "point", "body", "shock", "copc", "ropc"),
        "warnings": plain(found.profile.health.warnings),
        "effects": [
            {
                "quantity": effect.kind,
                "axis": effect.axis or None,
                "of": effect.name or None,
                **record(effect, "value", "unit", "step"),
                "d_shock": plain(effect.shock),
                "d_copc": plain(effect.copc),
                "d_ropc": plain(effect.ropc),
                "reason": effect.reason or None,
            }
            for effect in found.effects
        ],
    }


def _sheet(found: ShockSensitivity, most: int | None) -> Sheet:
    """The effects of one step. Args: most, number of rows; None for all."""
    ranked = found.ranked
    rows: list[tuple[Cell, ...]] = [
        (
            effect_words(effect),
            effect.name or "–",
            _present(effect),
            step_words(effect),
            effect.shock * effect.step,
            100.0 * effect.shock * effect.step / found.shock,
            _finite(100.0 * effect.ropc * effect.step / found.ropc),
            *(_finite(1e3 * float(x) * effect.step) for x in effect.copc),
        )
        for effect in ranked[:most]
    ]
    header = ("quantity", "of", "now", "change", "shock [-]", "shock [%]", "RoPc [%]", "CoPc x [mm]", "CoPc y [mm]", "CoPc z [mm]")
    notes = [
        "to first order: a change of the opposite sign has the opposite effect; of a larger one the effect is not in proportion"
    ]
    if left := len(ranked) - len(rows):
        notes.append(f"{count(left, 'quantity', 'quantities')} with smaller effects not shown; --out writes all")
    notes += [f'joint "{effect.name}" has no effect of its own: {effect.reason}' for effect in found.effects if effect.reason]
    return Sheet(f"effect on the shock at {found.point}, and on RoPc and CoPc of {found.body}", header, rows, tuple(notes))


def _effects(found: ShockSensitivity) -> Sheet:
    """The same with numbers in SI units, for a spreadsheet."""
    rows: list[tuple[Cell, ...]] = [
        (
            f"{effect.kind} {effect.axis}".strip(),
            effect.name or None,
            effect.value,
            effect.unit,
            effect.step,
            *(_finite(x * effect.step) for x in (effect.shock, effect.ropc, *effect.copc.tolist())),
        )
        for effect in found.ranked
    ]
    changes = ("shock [-]", "RoPc [m]", "CoPc x [m]", "CoPc y [m]", "CoPc z [m]")
    return Sheet("", ("quantity", "of", "value", "unit", "step", *changes), rows)


def _present(effect: Effect) -> str:
    """The present value."""
    if effect.unit == "1":
        return "–"
    factor, unit = UNITS.get(effect.unit, (1.0, effect.unit))
    return f"{round(factor * effect.value, 12) + 0.0:.4g} {unit}"


def _present_values(found: ShockSensitivity) -> str:
    """Shock, CoPc and RoPc as they are."""
    text = f"{found.point} on {found.body}: shock {found.shock:.4g}"
    if math.isfinite(found.ropc):
        x, y, z = (f"{x + 0.0:.4g}" for x in found.copc)
        text += f", CoPc of the body at ({x}, {y}, {z}) m, RoPc {found.ropc:.4g} m"
    return text


def _finite(value: float) -> Cell:
    """A cell; nothing for what does not exist."""
    return value if math.isfinite(value) else None
