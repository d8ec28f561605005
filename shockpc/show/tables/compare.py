"""A comparison as tables: one for each quantity, the largest change first, and what has no partner."""

import math

from shockpc.show.header import contact_name, count, strike_text
from shockpc.show.tables.sheets import Cell, Sheet
from shockpc.studies.compare import Comparison, Quantity

__all__ = ["design_lines", "difference_sheets", "letters", "unmatched_lines"]


def letters(comparison: Comparison) -> list[str]:
    """A, B, C and so on, one for each design."""
    return [chr(ord("A") + k) if k < 26 else f"design {k + 1}" for k in range(len(comparison.designs))]


def design_lines(comparison: Comparison) -> list[str]:
    """What each letter stands for."""
    return [
        f"{letter}  {design.label}: on {contact_name(profile)}, {strike_text(profile)}, joints {profile.joint_model}, "
        f"{profile.robot.mass:.4g} kg"
        for letter, design, profile in zip(letters(comparison), comparison.designs, comparison.profiles, strict=True)
    ]


def difference_sheets(comparison: Comparison, most: int | None = None) -> list[Sheet]:
    """A table for each quantity.

    Args:
        comparison: the designs.
        most: rows to show of each, those of the largest changes.
    """
    return [_sheet(quantity, letters(comparison), most) for quantity in comparison.quantities]


def unmatched_lines(comparison: Comparison) -> list[str]:
    """What has no partner of its name in every design, by kind and by the designs that have it."""
    letter = letters(comparison)
    groups: dict[tuple[str, tuple[int, ...]], list[str]] = {}
    for one in comparison.unmatched:
        groups.setdefault((one.kind, one.designs), []).append(one.name)
    plural = {"body": "bodies", "point": "points", "joint": "joints"}
    return [
        f"only in {' and '.join(letter[k] for k in designs)}: {count(len(names), kind, plural[kind])}: {', '.join(names)}"
        for (kind, designs), names in groups.items()
    ]


def _sheet(quantity: Quantity, names: list[str], most: int | None) -> Sheet:
    """One quantity."""
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
