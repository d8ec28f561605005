"""Tables, and how they are written: aligned for a terminal, Markdown for a report, CSV for a spreadsheet."""

import io
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from shockpc.show.wording import count
from shockpc.text.printed import message, printable

if TYPE_CHECKING:
    from shockpc.evaluation.table import Table

Cell = str | float | None
"""Content of a table: a text, a number, or nothing, for which NaN stands as well."""

Row = tuple[Cell, ...]


_MARKUP = (
    r"[\\`*|~$]|\](?=[(\[:])|(?<![^\W_])_|_(?![^\W_])|^[#+=]|^-(?=[ -])|(?i:(?<=http)|(?<=https)|(?<=ftp)):(?=//)|(?i:(?<=www))\."
)
_FORMULA = tuple("=+-@＝＋－＠")
_NUMBER = re.compile(r"[+-]?\d+(\.\d+)?(e[+-]?\d+)?", re.ASCII | re.IGNORECASE)


class Sheet(NamedTuple):
    """A table: a title, a header with units, rows, and notes under it."""

    title: str
    header: Sequence[str]
    rows: Sequence[Sequence[Cell]]
    notes: Sequence[str] = ()

    @classmethod
    def of(cls, title: str, columns: Mapping[str, Iterable[Any]], notes: Sequence[str] = ()) -> "Sheet":
        """A table of columns by heading."""
        return cls(title, tuple(columns), list(zip(*columns.values(), strict=True)), notes)

    def largest(self, most: int | None, noun: str, sizes: Sequence[float] = ()) -> "Sheet":
        """The rows of the largest sizes in the order of the table, with a note before the others that says how many are left out.

        Args:
            most: largest number of rows; None for all.
            noun: what a row is.
            sizes: of the rows; without, the first rows are the largest.
        """
        if most is None or len(self.rows) <= most:
            return self
        kept = sorted(range(len(self.rows)), key=lambda k: -sizes[k] if len(sizes) else k)[:most]
        left = f"{count(len(self.rows) - most, noun)} with smaller values not shown; --out writes all"
        return self._replace(rows=[self.rows[k] for k in sorted(kept)], notes=(left, *self.notes))


def sheet_of(table: "Table", title: str = "", notes: Sequence[str] = ()) -> Sheet:
    """The columns of a study's table, of the rows without a message."""
    rows = list(zip(*(x.tolist() for x in table.columns.values()), strict=True))
    return Sheet(title, tuple(table.columns), [row for i, row in enumerate(rows) if i not in table.messages], notes)


class Lines(NamedTuple):
    """Lines of text, or names with a text each.

    Attributes:
        lines: a text, or name and text, of each.
        title: over them, if there is one.
        whole: whether lines of any length are printed in full, because they are to be copied.
    """

    lines: Sequence[str | tuple[str, str]]
    title: str = ""
    whole: bool = False


def as_text(block: Sheet | Lines) -> str:
    """Lines, or a table for a terminal: names to the left, numbers below one another at their points, columns as wide as needed."""
    if isinstance(block, Lines):
        show = printable if block.whole else message
        lines = [f"{show(line)}" if isinstance(line, str) else f"{line[0]:<12} {show(line[1])}" for line in block.lines]
        return "".join(f"{line}\n" for line in ([block.title] if block.title else []) + lines)
    sheet = block
    heads = [printable(head).partition(" [") for head in sheet.header]
    names, units = [name for name, _, _ in heads], [bracket.strip() + unit for _, bracket, unit in heads]
    columns = [_at_the_point([printable(rounded(row[k]), 80) for row in sheet.rows]) for k in range(len(names))]
    cells = list(zip(*columns, strict=True))
    widths = [max(map(len, column)) for column in zip(names, units, *cells, strict=True)]
    numeric = _numeric(sheet)

    def line(parts: Sequence[str]) -> str:
        placed = [part.rjust(w) if right else part.ljust(w) for part, w, right in zip(parts, widths, numeric, strict=True)]
        return "  ".join(placed).rstrip()

    lines = [printable(sheet.title), *(line(parts) for parts in (names, units) if any(parts))]
    lines.append("  ".join("─" * width for width in widths))
    return "\n".join([*lines, *map(line, cells), *(f"({message(note)})" for note in sheet.notes)]) + "\n"


def as_markdown(block: Sheet | Lines) -> str:
    """Lines as a list, or a table, for a report."""
    if isinstance(block, Lines):
        texts = [escaped(line) if isinstance(line, str) else f"**{line[0]}**: {escaped(line[1])}" for line in block.lines]
        return _heading(block.title) + "".join(f"- {text}\n" for text in texts)
    sheet = block
    rows = [sheet.header, *(map(rounded, row) for row in sheet.rows)]
    lines = ["| " + " | ".join(map(escaped, row)) + " |" for row in rows]
    lines.insert(1, "|" + "|".join("---:" if right else "---" for right in _numeric(sheet)) + "|")
    notes = [f"\n*{note[0].upper()}{note[1:]}.*" for note in map(escaped, sheet.notes)]
    return _heading(sheet.title) + "\n".join([*lines, *notes]) + "\n"


def _heading(title: str) -> str:
    text = escaped(title)
    return f"### {text[0].upper()}{text[1:]}\n\n" if text else ""


def as_csv(sheet: Sheet) -> str:
    """A table for a spreadsheet: full precision, `inf` for an infinite radius, no -0.0, empty where there is nothing.

    An apostrophe in front keeps a spreadsheet from computing a text that begins like a formula. Characters that are not printable
    are escapes.
    """
    return csv_text([exact(cell) for cell in row] for row in (sheet.header, *sheet.rows))


def csv_text(rows: Iterable[Sequence[Cell]]) -> str:
    """Rows of cells, as `exact` gives them, as CSV."""
    out = io.StringIO()
    import csv

    csv.writer(out, lineterminator="\n").writerows(rows)
    return out.getvalue()


def escaped(text: str) -> str:
    """A text that Markdown shows as it is: neither HTML nor markup, links, references, formulas or new cells."""
    import html  # a table of all entities, which no other format needs

    return re.sub(_MARKUP, r"\\\g<0>", html.escape(printable(text), quote=False))


def rounded(cell: Cell) -> str:
    """A cell as people read it: at most four digits and four decimals; powers of ten where those would hide a number."""
    if isinstance(cell, str):
        return cell
    if cell is None or math.isnan(cell):
        return "–"
    if math.isinf(cell):
        return "inf"
    if abs(cell) < 1e-12:
        return "0"
    exponent = int(f"{cell:.3e}".partition("e")[2])
    return f"{cell:.{min(4, 3 - exponent)}f}" if -3 <= exponent <= 3 else f"{cell:.2e}"


def _at_the_point(cells: list[str]) -> list[str]:
    """The cells of a column with blanks after the decimals that some numbers have fewer of."""
    decimals = [len(cell.partition(".")[2]) if re.fullmatch(r"-?\d+\.\d+", cell) else None for cell in cells]
    most = max((n for n in decimals if n is not None), default=0)
    return [cell if n is None else cell + " " * (most - n) for cell, n in zip(cells, decimals, strict=True)]


def exact(cell: Cell) -> str:
    """A cell with all digits, empty where there is nothing; a text is printable and no formula, as a number is none."""
    if isinstance(cell, str):
        text = printable(cell)
        return f"'{text}" if text.lstrip(" ").startswith(_FORMULA) and not _NUMBER.fullmatch(text) else text
    return "" if cell is None or math.isnan(cell) else repr(float(cell) + 0.0)


def _numeric(sheet: Sheet) -> list[bool]:
    return [any(isinstance(row[k], float) for row in sheet.rows) for k in range(len(sheet.header))]
