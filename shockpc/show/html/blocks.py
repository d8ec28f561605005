"""Lines and tables as HTML.

All text is escaped here; none is read as markup.
"""

import html
import math
from collections.abc import Sequence

from shockpc.show.tables import Cell, Heading, Lines, Sheet, numeric
from shockpc.text.printed import printable

VERDICTS = ("exceeded", "not computed", "undecided", "warning", "passed")
"""Results of a budget, which have colours."""


def html_text(text: str) -> str:
    """A text of any origin."""
    return html.escape(printable(text))


def lines_html(block: Lines) -> str:
    """Lines under their title; neighbouring lines with names are one list."""
    parts = [f"<h3>{html_text(block.title)}</h3>"] if block.title else []
    in_list = False
    for line in block.lines:
        named = not isinstance(line, str)
        if named != in_list:
            parts.append("<dl>" if named else "</dl>")
            in_list = named
        if isinstance(line, str):
            parts.append(f"<p>{html_text(line)}</p>")
        else:
            name, text = line
            parts.append(f"<dt>{html_text(name)}</dt><dd>{html_text(text)}</dd>")
    if in_list:
        parts.append("</dl>")
    return "".join(parts)


def table_html(sheet: Sheet) -> str:
    """A table that a click on a heading sorts, with its notes; empty without rows and notes.

    Numbers with all digits are in an attribute.
    """
    if not sheet.rows and not sheet.notes:
        return ""
    headings = sheet.headings
    right = numeric(sheet)
    rows = []
    for row in sheet.rows:
        cells = map(_cell, headings, row, right)
        rows.append(f"<tr>{''.join(cells)}</tr>")
    notes = [f'<p class="note">{html_text(note)}</p>' for note in sheet.notes]
    return (
        f'<div class="scroll"><table><caption>{html_text(sheet.title)}</caption>'
        f"{head_html(headings, right)}<tbody>{''.join(rows)}</tbody></table></div>{''.join(notes)}"
    )


def head_html(headings: Sequence[Heading], to_the_right: Sequence[bool]) -> str:
    """The headings of a table. Args: headings; to_the_right, whether each has numbers."""
    cells = []
    for heading, right in zip(headings, to_the_right, strict=True):
        kind = "" if right else " class=name"
        unit = f"[{html_text(heading.unit)}]" if heading.unit else ""
        cells.append(f"<th{kind}>{_breakable(heading.title)}<small>{unit}</small></th>")
    return f"<thead><tr>{''.join(cells)}</tr></thead>"


def _cell(heading: Heading, cell: Cell, right: bool) -> str:
    """A cell; a verdict has a colour, as its words have a class in `report.css`."""
    value = ""
    if isinstance(cell, float | int) and math.isfinite(cell):
        # The representation of a number of NumPy has the name of its type, which no script reads.
        value = f' data-v="{float(cell)!r}"'
    kind = "" if right else " class=name"
    if heading.key == "result" and cell in VERDICTS:
        kind = f' class="name {str(cell).replace(" ", "-")}"'
    return f"<td{value}{kind}>{_breakable(heading.shown(cell))}</td>"


def _breakable(text: str) -> str:
    """A text whose long names may be broken after an underscore."""
    return html_text(text).replace("_", "_<wbr>")
