"""Tables, and how they are written: aligned for a terminal, Markdown for a report, CSV for a spreadsheet."""

import io
import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from shockpc.show.wording import count
from shockpc.text.printed import message, printable

if TYPE_CHECKING:
    from shockpc.evaluation.table import Table

Cell = str | float | bool | None
"""Content of a table: a text, a number, yes or no, or nothing, for which NaN stands as well."""

Row = tuple[Cell, ...]


_MARKUP = (
    r"[\\`*|~$]|\](?=[(\[:])|(?<![^\W_])_|_(?![^\W_])|^[#+=]|^-(?=[ -])|(?i:(?<=http)|(?<=https)|(?<=ftp)):(?=//)|(?i:(?<=www))\."
)
_FORMULA = tuple("=+-@＝＋－＠")
_NUMBER = re.compile(r"[+-]?\d+(\.\d+)?(e[+-]?\d+)?", re.ASCII | re.IGNORECASE)

SHOWN = {"%": ("-", 0.01), "ms": ("s", 1e-3), "µs": ("s", 1e-6)}
"""Units that people read, each with that of cells, CSV and JSON, and its size in that. All others are the same for both."""


class Column(NamedTuple):
    """What a column of a table holds.

    Attributes:
        key: its name in JSON, which no other column of the table has.
        title: over it.
        unit: as people read it, "-" for 1; empty of texts, counts, and numbers whose rows name theirs.
        width: largest number of characters of a cell on a terminal.
        zero: size below which people read a number as zero, which rounding leaves.
    """

    key: str
    title: str
    unit: str = ""
    width: int = 80
    zero: float = 1e-12

    @classmethod
    def of(cls, head: "str | Column") -> "Column":
        """A column by its heading, a title with the unit in brackets; the key follows, with the unit of an angle in degrees."""
        if isinstance(head, Column):
            return head
        title, bracket, unit = head.partition(" [")
        unit = unit.removesuffix("]") if bracket else ""
        key = re.sub(r"[^\w@.:/+-]+", "_", title.replace(" - ", " minus ")).strip("_")
        return cls(key.removesuffix("_deg") + "_deg" * (unit == "deg"), title.removesuffix("_deg"), unit)

    @property
    def exact_unit(self) -> str:
        """The unit of the cells, and of CSV and JSON: of SI, or degrees."""
        return SHOWN.get(self.unit, (self.unit,))[0]

    def heading(self, exact: bool = False) -> str:
        """The title with the unit. Args: exact, that of the cells, else that for people."""
        unit = self.exact_unit if exact else self.unit
        return f"{self.title} [{unit}]" if unit else self.title

    def shown(self, cell: Cell) -> str:
        """A cell as people read it."""
        return rounded(cell / SHOWN[self.unit][1] if self.unit in SHOWN and isinstance(cell, float) else cell, self.zero)


class Sheet(NamedTuple):
    """A table: a title, columns, rows, and notes under it. Numbers are in SI units, or degrees, as `Column.exact_unit` says."""

    title: str
    header: Sequence[str | Column]
    rows: Sequence[Sequence[Cell]]
    notes: Sequence[str] = ()

    @classmethod
    def of(cls, title: str, columns: Mapping[Any, Iterable[Any]], notes: Sequence[str] = ()) -> "Sheet":
        """A table of columns by heading, or by `Column`."""
        values = (x.tolist() if hasattr(x, "tolist") else x for x in columns.values())
        return cls(title, tuple(columns), list(zip(*values, strict=True)), notes)

    @property
    def columns(self) -> list[Column]:
        """The columns, also of those that the header has only as headings."""
        return [Column.of(head) for head in self.header]

    def only(self, *keys: str) -> "Sheet":
        """Those of some columns that it has."""
        names = [column.key for column in self.columns]
        kept = [names.index(key) for key in keys if key in names]
        return self._replace(header=[self.header[k] for k in kept], rows=[[row[k] for k in kept] for row in self.rows])

    def without(self, *keys: str) -> "Sheet":
        """All columns but some."""
        return self.only(*(column.key for column in self.columns if column.key not in keys))

    def known(self) -> "Sheet":
        """The columns in which some row has a cell; all columns of a table without rows, of which nothing is known."""
        if not self.rows:
            return self
        return self.only(*(column.key for k, column in enumerate(self.columns) if not all(_empty(row[k]) for row in self.rows)))

    def where(self, kept: Callable[[dict[str, Cell]], bool]) -> "Sheet":
        """The rows of which a condition holds. Args: kept, of the cells of a row by key."""
        keys = [column.key for column in self.columns]
        return self._replace(rows=[row for row in self.rows if kept(dict(zip(keys, row, strict=True)))])

    def ranked(self, key: str) -> "Sheet":
        """The rows with the largest numbers of a column first."""
        k = [column.key for column in self.columns].index(key)
        return self._replace(rows=sorted(self.rows, key=lambda row: -float(row[k] or 0.0)))

    def largest(self, most: int | None, noun: str, sizes: Sequence[float] = ()) -> "Sheet":
        """The rows of the largest sizes in the order of the table, with a note before the others that says how many are left out.

        Args:
            most: largest number of rows; None for all.
            noun: what a row is.
            sizes: of the rows; without, the first rows are shown.
        """
        if most is None or len(self.rows) <= most:
            return self
        kept = sorted(range(len(self.rows)), key=lambda k: -sizes[k] if len(sizes) else k)[:most]
        left = count(len(self.rows) - most, noun) + " with smaller values" * bool(len(sizes)) + " not shown; --out writes all"
        return self._replace(rows=[self.rows[k] for k in sorted(kept)], notes=(left, *self.notes))


def joined(sheets: Sequence[Sheet]) -> Sheet:
    """The rows of several tables below one another, with the columns that some of them have."""
    columns = {column.key: column for sheet in sheets for column in sheet.columns}
    cells = [dict(zip((column.key for column in sheet.columns), row, strict=True)) for sheet in sheets for row in sheet.rows]
    return sheets[0]._replace(header=list(columns.values()), rows=[[row.get(key) for key in columns] for row in cells])


def sheet_of(table: "Table", title: str = "", notes: Sequence[str] = ()) -> Sheet:
    """The columns of a study's table, of the rows without a message; in the units of sheets."""
    heads = [Column.of(name if " [" in name or not unit else f"{name} [{unit}]") for name, unit in table.units.items()]
    columns = (x * SHOWN[head.unit][1] if head.unit in SHOWN else x for head, x in zip(heads, table.columns.values(), strict=True))
    rows = list(zip(*(x.tolist() for x in columns), strict=True))
    return Sheet(title, heads, [row for i, row in enumerate(rows) if i not in table.messages], notes)


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
    names, units = zip(*((printable(c.title), f"[{printable(c.unit)}]" if c.unit else "") for c in sheet.columns), strict=True)
    columns = [_at_the_point([printable(c.shown(row[k]), c.width) for row in sheet.rows]) for k, c in enumerate(sheet.columns)]
    cells = list(zip(*columns, strict=True))
    widths = [max(map(len, column)) for column in zip(names, units, *cells, strict=True)]
    to_the_right = numeric(sheet)

    def line(parts: Sequence[str]) -> str:
        placed = [part.rjust(w) if right else part.ljust(w) for part, w, right in zip(parts, widths, to_the_right, strict=True)]
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
    rows = [
        [column.heading() for column in sheet.columns],
        *([column.shown(cell) for column, cell in zip(sheet.columns, row, strict=True)] for row in sheet.rows),
    ]
    lines = ["| " + " | ".join(map(escaped, row)) + " |" for row in rows]
    lines.insert(1, "|" + "|".join("---:" if right else "---" for right in numeric(sheet)) + "|")
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
    return csv_text([exact(cell) for cell in row] for row in ([column.heading(True) for column in sheet.columns], *sheet.rows))


def as_records(sheet: Sheet) -> list[dict[str, Cell]]:
    """The rows for JSON, with the cells of `as_csv` by key; nothing where a cell is empty."""
    keys = [column.key for column in sheet.columns]
    return [dict(zip(keys, map(_plain, row), strict=True)) for row in sheet.rows]


def _plain(cell: Cell) -> Cell:
    """A cell as JSON holds it; a number that is infinite as text, for which JSON has no other."""
    if cell is None or isinstance(cell, str | int):
        return cell
    return None if math.isnan(cell) else str(float(cell)) if math.isinf(cell) else float(cell) + 0.0


def _empty(cell: Cell) -> bool:
    return cell in (None, "") or (isinstance(cell, float) and math.isnan(cell))


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


def rounded(cell: Cell, zero: float = 1e-12) -> str:
    """A cell as people read it: at most four digits and four decimals; powers of ten where those would hide a number.

    Args: cell; zero, size below which a number is 0.
    """
    if isinstance(cell, str | int):
        return exact_text(cell)
    if cell is None or math.isnan(cell):
        return "–"
    if math.isinf(cell):
        return "inf"
    if abs(cell) < zero or cell == 0.0:
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
        return f"'{text}" if text.lstrip(" ").startswith(_FORMULA) and not _NUMBER.fullmatch(text) and text != "-" else text
    if isinstance(cell, int):
        return exact_text(cell)
    return "" if cell is None or math.isnan(cell) else repr(float(cell) + 0.0)


def exact_text(cell: str | int) -> str:
    """A text, a count, or yes or no, which are the same in every format."""
    return ("no", "yes")[cell] if isinstance(cell, bool) else str(cell)


def numeric(sheet: Sheet) -> list[bool]:
    """Which columns hold numbers."""
    kinds = (float, int)
    return [any(isinstance(row[k], kinds) and not isinstance(row[k], bool) for row in sheet.rows) for k in range(len(sheet.header))]
