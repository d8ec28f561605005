"""What changes the shock at a point, as a table in a designer's units, a document and a folder of files."""

import json
import math
from pathlib import Path
from typing import Any

import shockpc
from shockpc.printed import printable
from shockpc.scene import scene_table
from shockpc.show.document import plain
from shockpc.show.files import write_folder
from shockpc.show.header import count, header_lines
from shockpc.show.tables.sheets import Cell, Sheet
from shockpc.show.tables.text import as_csv, as_markdown, as_text, markdown_list
from shockpc.studies.sensitivity import Effect, ShockSensitivity

__all__ = [
    "effect_words",
    "effects_sheet",
    "sensitivity_document",
    "sensitivity_report",
    "sensitivity_sheet",
    "sensitivity_text",
    "step_words",
    "write_sensitivity",
]

SCHEMA = "shockpc.sensitivity/1"

QUANTITIES = {
    "mass": "mass (at its CoM)",
    "proportion": "mass and inertia",
    "com": "CoM",
    "inertia": "inertia",
    "armature": "reflected inertia",
    "angle": "joint",
    "strike": "strike angle",
}

UNITS = {"rad": (math.degrees(1.0), "deg"), "m": (1e3, "mm")}
"""Units of tables by SI unit, and their number in it."""


def sensitivity_sheet(found: ShockSensitivity, most: int | None = None) -> Sheet:
    """One row for every quantity, those with the largest effect on the shock first. Args: most, number of rows."""
    ranked = found.ranked
    shown = ranked if most is None else ranked[:most]
    rows: list[tuple[Cell, ...]] = [
        (
            effect_words(effect),
            effect.name or "–",
            _present(effect),
            step_words(effect),
            effect.shock * effect.step,
            100.0 * effect.shock * effect.step / found.shock,
            _number(100.0 * effect.ropc * effect.step / found.ropc),
            *(_number(1e3 * float(x) * effect.step) for x in effect.copc),
        )
        for effect in shown
    ]
    header = ("quantity", "of", "now", "change", "shock [-]", "shock [%]", "RoPc [%]", "CoPc x [mm]", "CoPc y [mm]", "CoPc z [mm]")
    notes = [
        "to first order: a change of the opposite sign has the opposite effect; of a larger one the effect is not in proportion"
    ]
    if len(shown) < len(ranked):
        notes.append(
            f"{count(len(ranked) - len(shown), 'quantity', 'quantities')} with smaller effects not shown; --out writes all"
        )
    notes += [f'joint "{effect.name}" has no effect of its own: {effect.reason}' for effect in found.effects if effect.reason]
    return Sheet(f"effect on the shock at {found.point}, and on RoPc and CoPc of {found.body}", header, rows, tuple(notes))


def effects_sheet(found: ShockSensitivity) -> Sheet:
    """The same with numbers in SI units, for a spreadsheet."""
    rows: list[tuple[Cell, ...]] = [
        (
            f"{effect.kind} {effect.axis}".strip(),
            effect.name or None,
            effect.value,
            effect.unit,
            effect.step,
            *(_number(x * effect.step) for x in (effect.shock, effect.ropc, *effect.copc.tolist())),
        )
        for effect in found.ranked
    ]
    changes = ("shock [-]", "RoPc [m]", "CoPc x [m]", "CoPc y [m]", "CoPc z [m]")
    return Sheet("", ("quantity", "of", "value", "unit", "step", *changes), rows)


def sensitivity_text(found: ShockSensitivity, most: int) -> str:
    """The result for a terminal. Args: most, number of rows."""
    lines = "\n".join(f"{name:<12} {text}" for name, text in [*header_lines(found.profile), _present_line(found)]) + "\n"
    return f"{lines}\n{as_text(sensitivity_sheet(found, most))}"


def sensitivity_report(found: ShockSensitivity, figure: str | None = None) -> str:
    """The result as a Markdown document. Args: figure, path of the chart relative to the document."""
    blocks = [
        f"## What changes the shock at {printable(found.point)}\n",
        markdown_list(f"{name}: {text}" for name, text in [*header_lines(found.profile), _present_line(found)]),
        f"![the largest effects on the shock]({figure})\n" if figure else "",
        as_markdown(sensitivity_sheet(found)),
    ]
    return "\n".join(filter(None, blocks))


def sensitivity_document(found: ShockSensitivity) -> dict[str, Any]:
    """The document: derivatives in SI units, and the step that tables and figure use."""
    return {
        "schema": SCHEMA,
        "shockpc": shockpc.__version__,
        "scene": scene_table(found.profile.scene),
        "point": found.point,
        "body": found.body,
        "shock": plain(found.shock),
        "copc": plain(found.copc),
        "ropc": plain(found.ropc),
        "effects": [
            {
                "quantity": effect.kind,
                "axis": effect.axis or None,
                "of": effect.name or None,
                "value": plain(effect.value),
                "unit": effect.unit,
                "step": effect.step,
                "d_shock": plain(effect.shock),
                "d_copc": plain(effect.copc),
                "d_ropc": plain(effect.ropc),
                "reason": effect.reason or None,
            }
            for effect in found.effects
        ],
    }


def write_sensitivity(found: ShockSensitivity, folder: Path) -> None:
    """Write sensitivity.json, sensitivity.csv, report.md, sensitivity.svg and sensitivity.png.

    Raises:
        OutputError: the folder cannot be written.
    """
    from shockpc.show.figure.tornado import tornado_figure

    write_folder(
        folder,
        {
            **tornado_figure(found),
            "sensitivity.csv": as_csv(effects_sheet(found)),
            "report.md": sensitivity_report(found, "sensitivity.svg"),
            "sensitivity.json": json.dumps(sensitivity_document(found), indent=1, ensure_ascii=False, allow_nan=False) + "\n",
        },
    )


def effect_words(effect: Effect) -> str:
    """What is changed."""
    words = QUANTITIES[effect.kind]
    if effect.kind == "angle":
        words = "joint angle" if effect.unit == "rad" else "joint position"
    return f"{words} {effect.axis}".strip()


def step_words(effect: Effect) -> str:
    """The change in a designer's units."""
    if effect.unit == "1":
        return f"+{100.0 * effect.step:g} %"
    if effect.unit == "kg":
        return f"+{1e3 * effect.step:g} g"
    factor, unit = UNITS.get(effect.unit, (1.0, effect.unit))
    return f"+{factor * effect.step:.4g} {unit}"


def _present(effect: Effect) -> str:
    """The present value."""
    if effect.unit == "1":
        return "–"
    factor, unit = UNITS.get(effect.unit, (1.0, effect.unit))
    return f"{round(factor * effect.value, 12) + 0.0:.4g} {unit}"


def _present_line(found: ShockSensitivity) -> tuple[str, str]:
    """Shock, CoPc and RoPc as they are."""
    text = f"{found.point} on {found.body}: shock {found.shock:.4g}"
    if math.isfinite(found.ropc):
        x, y, z = (f"{x + 0.0:.4g}" for x in found.copc)
        text += f", CoPc of the body at ({x}, {y}, {z}) m, RoPc {found.ropc:.4g} m"
    return "point", printable(text)


def _number(value: float) -> Cell:
    """A cell; nothing for what does not exist."""
    return value if math.isfinite(value) else None
