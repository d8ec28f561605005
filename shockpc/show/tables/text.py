"""Tables as text: aligned for a terminal, Markdown for a report, CSV for a spreadsheet."""

import csv
import html
import io
import math
import re
from collections.abc import Iterable

from shockpc.printed import message, printable
from shockpc.result import ShockProfile
from shockpc.show.header import contact_name, header_lines
from shockpc.show.tables.design import balance_lines, bracket_sheet, directions_sheet, loads_sheet
from shockpc.show.tables.sheets import Cell, Sheet, accuracy_line, bodies_sheet, contacts_sheet, points_sheet, summary_sheet

__all__ = ["as_csv", "as_markdown", "as_text", "csv_report", "markdown_list", "markdown_report", "text_report"]

SHORT = 6
"""Rows of the longer tables that a terminal shows; a report has them all."""


def as_text(sheet: Sheet) -> str:
    """A table for a terminal: names to the left, numbers to the right, each column as wide as it must be."""
    heads = [printable(head).partition(" [") for head in sheet.header]
    names, units = [name for name, _, _ in heads], [bracket.strip() + unit for _, bracket, unit in heads]
    cells = [[printable(_shown(cell), 80) for cell in row] for row in sheet.rows]
    widths = [max(map(len, column)) for column in zip(names, units, *cells, strict=True)]
    numeric = _numeric(sheet)

    def line(parts: list[str]) -> str:
        placed = [part.rjust(w) if right else part.ljust(w) for part, w, right in zip(parts, widths, numeric, strict=True)]
        return "  ".join(placed).rstrip()

    lines = [printable(sheet.title), *(line(parts) for parts in (names, units) if any(parts))]
    lines.append("  ".join("─" * width for width in widths))
    return "\n".join([*lines, *map(line, cells), *(f"({message(note)})" for note in sheet.notes)]) + "\n"


def as_markdown(sheet: Sheet) -> str:
    """A table for a report."""
    rows = [sheet.header, *(map(_shown, row) for row in sheet.rows)]
    lines = ["| " + " | ".join(map(_escaped, row)) + " |" for row in rows]
    lines.insert(1, "|" + "|".join("---:" if right else "---" for right in _numeric(sheet)) + "|")
    notes = [f"\n*{note[0].upper()}{note[1:]}.*" for note in map(_escaped, sheet.notes)]
    title = _escaped(sheet.title)
    return "\n".join([f"### {title[0].upper()}{title[1:]}", "", *lines, *notes]) + "\n"


def markdown_list(lines: Iterable[str]) -> str:
    """Texts as a list of a report."""
    return "".join(f"- {_escaped(line)}\n" for line in lines)


def as_csv(sheet: Sheet) -> str:
    """A table for a spreadsheet: full precision, `inf` for an infinite radius, no -0.0, empty where there is nothing.

    An apostrophe in front keeps a spreadsheet from computing a text that begins like a formula.
    """
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerows([_exact(cell) for cell in row] for row in (sheet.header, *sheet.rows))
    return out.getvalue()


def text_report(profiles: list[ShockProfile], pattern: str | None = None) -> str:
    """All results of some landings, for a terminal; of the bodies only those that match a pattern."""
    blocks = []
    for profile in profiles:
        blocks.append("\n".join(f"{name:<12} {text}" for name, text in header_lines(profile)) + "\n")
        blocks += [as_text(sheet) for sheet in _sheets(profile, pattern, SHORT)]
        blocks.append("\n".join(map(message, _closing_lines(profile))) + "\n")
    if len(profiles) > 1:
        blocks.append(as_text(summary_sheet(profiles, pattern)))
    return "\n".join(blocks)


def markdown_report(profiles: list[ShockProfile], pattern: str | None = None, figure: str | None = None) -> str:
    """All results of some landings, as a Markdown document.

    Args:
        profiles: the results.
        pattern: only bodies that match it are shown.
        figure: path of a picture, relative to the document.
    """
    blocks = []
    for profile in profiles:
        robot = _escaped(profile.robot.name)
        blocks.append(f"## Shock of {robot} landing on {_escaped(contact_name(profile))}\n")
        blocks.append("\n".join(f"- **{name}**: {_escaped(text)}" for name, text in header_lines(profile)) + "\n")
        if figure:
            blocks.append(f"![shock profile of {robot}]({figure})\n")
        blocks += [as_markdown(sheet) for sheet in _sheets(profile, pattern, None)]
        blocks.append(markdown_list(_closing_lines(profile)))
    if len(profiles) > 1:
        blocks.append(as_markdown(summary_sheet(profiles, pattern)))
    return "\n".join(blocks)


def csv_report(profiles: list[ShockProfile], pattern: str | None = None) -> str:
    """The bodies of some landings as one table, with the contact in a column of its own."""
    sheets = [(contact_name(profile), bodies_sheet(profile, pattern, fold=False)) for profile in profiles]
    rows = [(name, *row) for name, sheet in sheets for row in sheet.rows]
    return as_csv(Sheet("", ("contact", *sheets[0][1].header), rows))


def _sheets(profile: ShockProfile, pattern: str | None, most: int | None) -> list[Sheet]:
    """The tables of one landing; points, joint models and loads only where there are any, long ones cut to their largest rows."""
    points, loads = points_sheet(profile), loads_sheet(profile, most)
    return [
        bodies_sheet(profile, pattern),
        *([points] if points.rows else []),
        contacts_sheet(profile),
        *([bracket_sheet(profile)] if profile.robot.joint_names else []),
        directions_sheet(profile, most),
        *([loads] if loads.rows else []),
    ]


def _closing_lines(profile: ShockProfile) -> list[str]:
    """Energy and effective masses, the rank of the contact rows, warnings, and the accuracy in the last line."""
    rows = f"contact rows: {profile.health.rank} of {profile.health.rows} independent"
    warnings = [f"warning: {warning}" for warning in profile.health.warnings]
    return [*balance_lines(profile), rows, *warnings, accuracy_line(profile)]


def _shown(cell: Cell) -> str:
    """A cell as people read it: four decimals, so that a column is aligned; powers of ten where those would hide a number."""
    if isinstance(cell, str):
        return cell
    if cell is None or math.isnan(cell):
        return "–"
    if math.isinf(cell):
        return "inf"
    if abs(cell) < 1e-12:
        return "0"
    return f"{cell:.4f}" if 1e-3 <= abs(cell) < 1e5 else f"{cell:.2e}"


def _exact(cell: Cell) -> str:
    """A cell of a CSV file."""
    if isinstance(cell, str):
        return f"'{cell}" if cell.startswith(("=", "+", "-", "@", "\t", "\r")) else cell
    return "" if cell is None or math.isnan(cell) else repr(float(cell) + 0.0)


def _numeric(sheet: Sheet) -> list[bool]:
    """Which columns hold numbers."""
    return [any(isinstance(row[k], float) for row in sheet.rows) for k in range(len(sheet.header))]


def _escaped(text: str) -> str:
    """A text that Markdown shows as it is: neither HTML nor markup, links or new cells."""
    return re.sub(r"([\\`*|]|\](?=\())", r"\\\1", html.escape(printable(text), quote=False))
