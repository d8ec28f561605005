"""Tables as text: aligned for a terminal, Markdown for a report, CSV for a spreadsheet."""

import csv
import io
import math

from shockpc.result import ShockProfile
from shockpc.show.tables.design import balance_lines, bracket_sheet, directions_sheet, loads_sheet
from shockpc.show.tables.sheets import (
    Cell,
    Sheet,
    bodies_sheet,
    contact_name,
    contacts_sheet,
    header_lines,
    health_lines,
    points_sheet,
    summary_sheet,
)

__all__ = ["as_csv", "as_markdown", "as_text", "csv_report", "markdown_report", "text_report"]

SHORT = 6
"""Rows of the longer tables that a terminal shows; a report has them all."""


def as_text(sheet: Sheet) -> str:
    """A table for a terminal: names to the left, numbers to the right, each column as wide as it must be."""
    cells = [[_shown(cell) for cell in row] for row in sheet.rows]
    heads = [_split(head) for head in sheet.header]
    widths = [max([len(part) for part in head] + [len(row[k]) for row in cells]) for k, head in enumerate(heads)]
    numbers = [any(isinstance(row[k], float) for row in sheet.rows) for k in range(len(heads))]

    def line(parts: list[str]) -> str:
        placed = [part.rjust(w) if right else part.ljust(w) for part, w, right in zip(parts, widths, numbers, strict=True)]
        return "  ".join(placed).rstrip()

    lines = [sheet.title, *(line([head[k] for head in heads]) for k in (0, 1) if any(head[k] for head in heads))]
    lines.append("  ".join("─" * width for width in widths))
    lines += [line(row) for row in cells]
    return "\n".join([*lines, *(f"({note})" for note in sheet.notes)]) + "\n"


def as_markdown(sheet: Sheet) -> str:
    """A table for a report."""
    lines = [
        f"### {sheet.title[0].upper()}{sheet.title[1:]}",
        "",
        "| " + " | ".join(_safe(h) for h in sheet.header) + " |",
    ]
    numeric = [any(isinstance(row[k], float) for row in sheet.rows) for k in range(len(sheet.header))]
    lines.append("|" + "|".join("---:" if right else "---" for right in numeric) + "|")
    lines += ["| " + " | ".join(_safe(_shown(cell)) for cell in row) + " |" for row in sheet.rows]
    return "\n".join([*lines, *(f"\n*{note[0].upper()}{note[1:]}.*" for note in sheet.notes)]) + "\n"


def as_csv(sheet: Sheet) -> str:
    """A table for a spreadsheet: full precision, `inf` for an infinite radius, no -0.0, empty where there is nothing."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(sheet.header)
    for row in sheet.rows:
        writer.writerow(["" if cell is None else repr(cell + 0.0) if isinstance(cell, float) else cell for cell in row])
    return out.getvalue()


def text_report(profiles: list[ShockProfile], pattern: str | None = None) -> str:
    """Everything about some landings, for a terminal."""
    blocks = []
    for profile in profiles:
        blocks.append("\n".join(f"{name:<12} {text}" for name, text in header_lines(profile)) + "\n")
        blocks += [as_text(sheet) for sheet in _sheets(profile, pattern, SHORT)]
        blocks.append("\n".join([*balance_lines(profile), *health_lines(profile)]) + "\n")
    if len(profiles) > 1:
        blocks.append(as_text(summary_sheet(profiles, pattern)))
    return "\n".join(blocks)


def markdown_report(profiles: list[ShockProfile], pattern: str | None = None, figure: str | None = None) -> str:
    """Everything about some landings, as a Markdown document.

    Args:
        profiles: the results.
        pattern: only bodies that fit it are shown.
        figure: path of a picture, relative to the document.
    """
    blocks = []
    for profile in profiles:
        blocks.append(f"## Shock of {profile.robot.name} landing on {contact_name(profile)}\n")
        blocks.append("\n".join(f"- **{name}**: {text}" for name, text in header_lines(profile)) + "\n")
        if figure:
            blocks.append(f"![shock profile of {profile.robot.name}]({figure})\n")
        blocks += [as_markdown(sheet) for sheet in _sheets(profile, pattern, None)]
        blocks.append("\n".join(f"- {line}" for line in [*balance_lines(profile), *health_lines(profile)]) + "\n")
    if len(profiles) > 1:
        blocks.append(as_markdown(summary_sheet(profiles, pattern)))
    return "\n".join(blocks)


def csv_report(profiles: list[ShockProfile], pattern: str | None = None) -> str:
    """The bodies of some landings as one table, with the contact in a column of its own."""
    sheets = [(contact_name(profile), bodies_sheet(profile, pattern, fold=False)) for profile in profiles]
    rows = [(name, *row) for name, sheet in sheets for row in sheet.rows]
    return as_csv(Sheet("", ("contact", *sheets[0][1].header), rows))


def _sheets(profile: ShockProfile, pattern: str | None, most: int | None) -> list[Sheet]:
    """The tables of one landing; points, drives and loads only where there are any, long ones cut to their largest rows."""
    points, loads = points_sheet(profile), loads_sheet(profile, most)
    return [
        bodies_sheet(profile, pattern),
        *([points] if points.rows else []),
        contacts_sheet(profile),
        *([bracket_sheet(profile)] if profile.robot.joint_names else []),
        directions_sheet(profile, most),
        *([loads] if loads.rows else []),
    ]


def _shown(cell: Cell) -> str:
    """A cell as people read it: four decimals, so that a column lines up; powers of ten where those would hide a number."""
    if cell is None:
        return "–"
    if isinstance(cell, str):
        return cell
    if math.isinf(cell):
        return "inf"
    if abs(cell) < 1e-12:
        return "0"
    return f"{cell:.4f}" if 1e-3 <= abs(cell) < 1e5 else f"{cell:.2e}"


def _split(head: str) -> tuple[str, str]:
    """A header in two lines: the name, then the unit."""
    name, bracket, unit = head.partition(" [")
    return name, bracket.strip() + unit


def _safe(text: str) -> str:
    """Markdown splits cells at bars."""
    return text.replace("|", "\\|")
