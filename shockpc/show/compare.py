"""The output of a comparison: tables, Markdown, CSV, JSON (schema `shockpc.compare/1`), and the files of a folder."""

import json
from typing import Any

import shockpc
from shockpc.model.dynamics import PINOCCHIO
from shockpc.printed import printable
from shockpc.scene import scene_table
from shockpc.show.document import plain
from shockpc.show.tables.compare import design_lines, difference_sheets, letters, unmatched_lines
from shockpc.show.tables.sheets import Cell, Sheet
from shockpc.show.tables.text import as_csv, as_markdown, as_text, markdown_list
from shockpc.studies.compare import Comparison

__all__ = ["SCHEMA", "compare_document", "compare_files", "compare_text"]

SCHEMA = "shockpc.compare/1"

SHORT = 8
"""Rows of a table on a terminal."""


def compare_text(comparison: Comparison, format_: str) -> str:
    """What goes to standard output. Args: format_, "table", "markdown", "csv" or "json"."""
    if format_ == "json":
        return json.dumps(compare_document(comparison), indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    if format_ == "csv":
        return _csv(comparison)
    if format_ == "markdown":
        return _report(comparison)
    blocks = ["\n".join(map(printable, design_lines(comparison))) + "\n"]
    blocks += [as_text(sheet) for sheet in difference_sheets(comparison, SHORT)]
    unmatched = unmatched_lines(comparison)
    return "\n".join([*blocks, *([f"{printable(line)}" for line in unmatched])]) + ("\n" if unmatched else "")


def compare_document(comparison: Comparison) -> dict[str, Any]:
    """The comparison as JSON; `null` where a number does not exist or is infinite."""
    return {
        "schema": SCHEMA,
        "shockpc": shockpc.__version__,
        "pinocchio": PINOCCHIO,
        "designs": [
            {
                "label": design.label,
                "robot": profile.robot.label,
                "changes": [str(change) for change in design.changes],
                "joint_model": profile.joint_model,
                "error_bound": plain(profile.health.error_bound),
                "scene": scene_table(profile.scene),
                "warnings": [str(warning) for warning in profile.health.warnings],
            }
            for design, profile in zip(comparison.designs, comparison.profiles, strict=True)
        ],
        "quantities": [
            {
                "name": quantity.name,
                "unit": quantity.unit,
                "rows": [
                    {quantity.of: row.place, "values": [plain(v) for v in row.values], "changes": [plain(v) for v in row.changes]}
                    for row in quantity.rows
                ],
            }
            for quantity in comparison.quantities
        ],
        "unmatched": [
            {"kind": one.kind, "name": one.name, "designs": [comparison.designs[k].label for k in one.designs]}
            for one in comparison.unmatched
        ],
    }


def compare_files(comparison: Comparison) -> dict[str, str | bytes]:
    """The files of a comparison by name."""
    from shockpc.show.figure.compare import compare_figure

    return {
        **compare_figure(comparison),
        "compare.csv": _csv(comparison),
        "compare.json": compare_text(comparison, "json"),
        "report.md": _report(comparison, "compare.svg"),
    }


def _csv(comparison: Comparison) -> str:
    """All quantities as one table, with the name and unit of each in columns of their own."""
    names = letters(comparison)
    rows: list[tuple[Cell, ...]] = [
        (quantity.name, quantity.unit, row.place, *row.values, *row.changes)
        for quantity in comparison.quantities
        for row in quantity.rows
    ]
    header = ("quantity", "unit", "place", *names, *(f"{name} - {names[0]}" for name in names[1:]))
    return as_csv(Sheet("", header, rows))


def _report(comparison: Comparison, figure: str | None = None) -> str:
    """The comparison as Markdown."""
    blocks = ["## Comparison\n", markdown_list(design_lines(comparison))]
    if figure is not None:
        blocks.append(f"![the designs side by side]({figure})\n")
    blocks += [as_markdown(sheet) for sheet in difference_sheets(comparison)]
    unmatched = unmatched_lines(comparison)
    if unmatched:
        blocks.append("### Without a partner\n\n" + markdown_list(unmatched))
    return "\n".join(blocks)
