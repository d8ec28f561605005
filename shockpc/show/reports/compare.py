"""A comparison: what each letter stands for, one table for each quantity with the largest change first, and what has no partner."""

import math
import textwrap
from typing import TYPE_CHECKING, Any

from shockpc.printed import printable
from shockpc.show.document import head, plain, record
from shockpc.show.header import contact_name, count, strike_text
from shockpc.show.reports.report import Report
from shockpc.show.tables.sheets import Cell, Sheet
from shockpc.studies.compare import Comparison, Quantity

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["compare_report"]

WIDE = 34
"""Letters in a line under a panel."""


def compare_report(comparison: Comparison) -> Report:
    """Designs side by side."""
    designs, profiles = comparison.designs, comparison.profiles
    letters = [chr(ord("A") + k) if k < 26 else f"design {k + 1}" for k in range(len(designs))]

    def draw() -> "Figure":
        from shockpc.show.figure.landing import draw_panels

        robots = " and ".join(dict.fromkeys(printable(profile.robot.label, 40) for profile in profiles))
        captions = [
            [*textwrap.wrap(printable(design.label, 4 * WIDE), WIDE), f"on {printable(contact_name(profile), WIDE)}"]
            for design, profile in zip(designs, profiles, strict=True)
        ]
        return draw_panels(profiles, f"Shock of {robots}: designs side by side", letters, captions)

    return Report(
        name="compare",
        title="Comparison",
        header=[
            (
                letter,
                f"{design.label}: on {contact_name(profile)}, {strike_text(profile)}, joints {profile.joint_model}, "
                f"{profile.robot.mass:.4g} kg",
            )
            for letter, design, profile in zip(letters, designs, profiles, strict=True)
        ],
        tables=lambda most: [_sheet(quantity, letters, most) for quantity in comparison.quantities],
        short=8,
        closing=[*_unmatched(comparison, letters), *_warnings(comparison, letters)],
        sheets={"compare": lambda: _all(comparison, letters)},
        document=lambda: _document(comparison),
        picture="compare",
        caption="the designs side by side",
        draw=draw,
    )


def _document(comparison: Comparison) -> dict[str, Any]:
    """The document, schema `shockpc.compare/1`."""
    labels = [design.label for design in comparison.designs]
    return {
        **head("compare"),
        "designs": [
            {
                "label": design.label,
                "robot": profile.robot.label,
                "changes": plain(design.changes),
                "joint_model": profile.joint_model,
                "error_bound": plain(profile.health.error_bound),
                "scene": plain(profile.scene),
                "warnings": plain(profile.health.warnings),
            }
            for design, profile in zip(comparison.designs, comparison.profiles, strict=True)
        ],
        "quantities": [
            {
                **record(quantity, "name", "unit"),
                "rows": [
                    {quantity.of: row.place, "values": [plain(v) for v in row.values], "changes": [plain(v) for v in row.changes]}
                    for row in quantity.rows
                ],
            }
            for quantity in comparison.quantities
        ],
        "unmatched": [{**record(one, "kind", "name"), "designs": [labels[k] for k in one.designs]} for one in comparison.unmatched],
    }


def _all(comparison: Comparison, letters: list[str]) -> Sheet:
    """All quantities as one table, with the name and unit of each in columns of their own."""
    rows: list[tuple[Cell, ...]] = [
        (quantity.name, quantity.unit, row.place, *row.values, *row.changes)
        for quantity in comparison.quantities
        for row in quantity.rows
    ]
    return Sheet("", ("quantity", "unit", "place", *letters, *(f"{name} - {letters[0]}" for name in letters[1:])), rows)


def _unmatched(comparison: Comparison, letters: list[str]) -> list[str]:
    """What has no partner of its name in every design, by kind and by the designs that have it."""
    groups: dict[tuple[str, tuple[int, ...]], list[str]] = {}
    for one in comparison.unmatched:
        groups.setdefault((one.kind, one.designs), []).append(one.name)
    plural = {"body": "bodies", "point": "points", "joint": "joints"}
    return [
        f"only in {' and '.join(letters[k] for k in designs)}: {count(len(names), kind, plural[kind])}: {', '.join(names)}"
        for (kind, designs), names in groups.items()
    ]


def _warnings(comparison: Comparison, letters: list[str]) -> list[str]:
    """One line for each warning, with the designs that have it."""
    found: dict[str, list[str]] = {}
    for letter, profile in zip(letters, comparison.profiles, strict=True):
        for warning in profile.health.warnings:
            found.setdefault(str(warning), []).append(letter)
    return [f"warning of {' and '.join(owners)}: {text}" for text, owners in found.items()]


def _sheet(quantity: Quantity, names: list[str], most: int | None) -> Sheet:
    """One quantity. Args: most, rows to show, those of the largest changes; None for all."""
    header = (quantity.of, *(f"{name} [{quantity.unit}]" for name in names))
    for name in names[1:]:
        header += (f"{name} − {names[0]} [{quantity.unit}]", f"of {names[0]} [%]")
    rows: list[tuple[Cell, ...]] = []
    for row in quantity.rows[:most]:
        cells: tuple[Cell, ...] = (row.place, *row.values)
        for change in row.changes:
            cells += (change, _percent(change, row.values[0]))
        rows.append(cells)
    notes: tuple[str, ...] = ("ranked by the change of 1 / RoPc, the shock per metre",) if quantity.unit == "m" else ()
    left = len(quantity.rows) - len(rows)
    if left:
        notes += (f"{left} with smaller changes not shown; --out writes all",)
    return Sheet(quantity.name, header, rows, notes)


def _percent(change: float | None, first: float | None) -> float | None:
    """A change in percent of the first value; None where that is no number or zero."""
    if change is None or first is None or not math.isfinite(change) or not math.isfinite(first) or first == 0.0:
        return None
    return 100.0 * change / abs(first)
