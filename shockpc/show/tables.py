"""Tables, and how they are written: aligned for a terminal, Markdown for a report, CSV for a
spreadsheet.
"""

import io
import itertools
import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from shockpc.quantities.renamed import former_key
from shockpc.text.printed import count, message, printable

if TYPE_CHECKING:
    from shockpc.evaluation.table import Table

Cell = str | float | bool | None
"""Content of a table: a text, a number, yes or no, or nothing, for which NaN stands as well."""

Row = tuple[Cell, ...]

T = TypeVar("T")


_MARKUP = (
    r"[\\`*|~$]|\](?=[(\[:])|(?<![^\W_])_|_(?![^\W_])|^[#+=]|^-(?=[ "
    r"-])|(?i:(?<=http)|(?<=https)|(?<=ftp)):(?=//)|(?i:(?<=www))\."
)
_FORMULA = tuple("=+-@＝＋－＠")
_NUMBER = re.compile(r"[+-]?\d+(\.\d+)?(e[+-]?\d+)?", re.ASCII | re.IGNORECASE)

SHOWN = {"%": ("-", 0.01), "ms": ("s", 1e-3), "µs": ("s", 1e-6)}
"""Units that people read, each with that of cells, CSV and JSON, and its size in that.

All others are the same for both.
"""


WIDTH, NARROW, GAP = 100, 12, "  "
"""Characters of a line of a table on a terminal; of a column of names at least; and between
columns.
"""

NAMES = 0.7
"""Share of the width that the first columns, which name the rows, may have to be repeated where a
table continues.
"""


class Column(NamedTuple):
    """What a column of a table holds.

    Attributes:
        key: its name in JSON, which no other column of the table has.
        title: over it.
        unit: as people read it, "-" for 1; empty of texts, counts, and numbers whose rows name
            theirs.
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
        """A column by its heading, a title with the unit in brackets; the key follows, with the
        unit of an angle in degrees.
        """
        if isinstance(head, Column):
            return head
        title, bracket, unit = head.partition(" [")
        unit = unit.removesuffix("]") if bracket else ""
        key = re.sub(r"[^\w@.:/+-]+", "_", title.replace(" - ", " minus ")).strip("_")
        return cls(
            key.removesuffix("_deg") + "_deg" * (unit == "deg"), title.removesuffix("_deg"), unit
        )

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
        return rounded(
            cell / SHOWN[self.unit][1] if self.unit in SHOWN and isinstance(cell, float) else cell,
            self.zero,
        )


class Sheet(NamedTuple):
    """A table: a title, columns, rows, and notes under it.

    Numbers are in SI units, or degrees, as `Column.exact_unit` says.
    """

    title: str
    header: Sequence[str | Column]
    rows: Sequence[Sequence[Cell]]
    notes: Sequence[str] = ()

    @classmethod
    def of(
        cls, title: str, columns: Mapping[Any, Iterable[Any]], notes: Sequence[str] = ()
    ) -> "Sheet":
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
        return self._replace(
            header=[self.header[k] for k in kept],
            rows=[[row[k] for k in kept] for row in self.rows],
        )

    def without(self, *keys: str) -> "Sheet":
        """All columns but some."""
        return self.only(*(column.key for column in self.columns if column.key not in keys))

    def known(self) -> "Sheet":
        """The columns in which some row has a cell; all columns of a table without rows, of which
        nothing is known.
        """
        if not self.rows:
            return self
        return self.only(
            *(
                column.key
                for k, column in enumerate(self.columns)
                if not all(_empty(row[k]) for row in self.rows)
            )
        )

    def where(self, kept: Callable[[dict[str, Cell]], bool]) -> "Sheet":
        """The rows of which a condition holds. Args: kept, of the cells of a row by key."""
        keys = [column.key for column in self.columns]
        return self._replace(
            rows=[row for row in self.rows if kept(dict(zip(keys, row, strict=True)))]
        )

    def ranked(self, key: str) -> "Sheet":
        """The rows with the largest numbers of a column first."""
        k = [column.key for column in self.columns].index(key)
        return self._replace(rows=sorted(self.rows, key=lambda row: -float(row[k] or 0.0)))

    def largest(self, most: int | None, noun: str, sizes: Sequence[float] = ()) -> "Sheet":
        """The rows of the largest sizes in the order of the table, with a note before the others
        that says how many are left out.

        Args:
            most: largest number of rows; None for all.
            noun: what a row is.
            sizes: of the rows; without, the first rows are shown.
        """
        if most is None or len(self.rows) <= most:
            return self
        kept = sorted(range(len(self.rows)), key=lambda k: -sizes[k] if len(sizes) else k)[:most]
        left = (
            count(len(self.rows) - most, noun)
            + " with smaller values" * bool(len(sizes))
            + " not shown; --out writes all"
        )
        return self._replace(rows=[self.rows[k] for k in sorted(kept)], notes=(left, *self.notes))


def joined(sheets: Sequence[Sheet]) -> Sheet:
    """The rows of several tables below one another, with the columns that some of them have."""
    columns = {column.key: column for sheet in sheets for column in sheet.columns}
    cells = [
        dict(zip((column.key for column in sheet.columns), row, strict=True))
        for sheet in sheets
        for row in sheet.rows
    ]
    return sheets[0]._replace(
        header=list(columns.values()), rows=[[row.get(key) for key in columns] for row in cells]
    )


def sheet_of(table: "Table", title: str = "", notes: Sequence[str] = ()) -> Sheet:
    """The columns of a study's table, of the rows without a message; in the units of sheets."""
    heads = [
        Column.of(name if " [" in name or not unit else f"{name} [{unit}]")
        for name, unit in table.units.items()
    ]
    columns = (
        x * SHOWN[head.unit][1] if head.unit in SHOWN else x
        for head, x in zip(heads, table.columns.values(), strict=True)
    )
    rows = list(zip(*(x.tolist() for x in columns), strict=True))
    return Sheet(
        title, heads, [row for i, row in enumerate(rows) if i not in table.messages], notes
    )


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


def as_text(block: Sheet | Lines, width: int | None = None) -> str:
    """Lines, or a table for a terminal: names to the left, numbers below one another at their
    points, columns as wide as needed.

    Args:
        block: lines or a table.
        width: most characters of a line of a table; None for any number. Names are shortened, and
            what is still too wide continues below with the columns that name the rows.
    """
    if isinstance(block, Lines):
        show = printable if block.whole else message
        lines = [
            f"{show(line)}" if isinstance(line, str) else f"{line[0]:<12} {show(line[1])}"
            for line in block.lines
        ]
        return "".join(f"{line}\n" for line in ([block.title] if block.title else []) + lines)
    columns = _as_wide(_columns_of(block), width)
    parts = [_lines_of(group) for group in _side_by_side(columns, width)]
    text = "\n\n".join("\n".join(lines) for lines in parts)
    return (
        "\n".join([printable(block.title), text, *(f"({message(note)})" for note in block.notes)])
        + "\n"
    )


class _TextColumn(NamedTuple):
    """A column on a terminal: its two lines of heading, its cells, and whether these are to the
    right.
    """

    title: str
    unit: str
    cells: list[str]
    right: bool

    @property
    def width(self) -> int:
        return max(map(len, (self.title, self.unit, *self.cells)))

    @property
    def counts(self) -> bool:
        """Whether its cells are whole numbers, as ranks are."""
        return all(cell.strip().isdigit() or cell.strip() == "–" for cell in self.cells)

    def shortened(self, width: int) -> "_TextColumn":
        """The column with names of at most so many characters; numbers and sentences stay whole."""
        title, *cells = (
            text if " " in text.replace(", ", "") else printable(text, width)
            for text in (self.title, *self.cells)
        )
        return self._replace(title=title, cells=self.cells if self.right else cells)


def _columns_of(sheet: Sheet) -> list[_TextColumn]:
    columns = []
    for k, (column, right) in enumerate(zip(sheet.columns, numeric(sheet), strict=True)):
        cells = _at_the_point([printable(column.shown(row[k]), column.width) for row in sheet.rows])
        unit = f"[{printable(column.unit)}]" if column.unit else ""
        columns.append(_TextColumn(printable(column.title), unit, cells, right))
    return columns


def _as_wide(columns: list[_TextColumn], width: int | None) -> list[_TextColumn]:
    """Columns with the longest names shortened until all have room, as far as `NARROW`; as they are
    where they have none.
    """
    short, left = list(columns), set(range(len(columns)))
    while (
        width is not None
        and (over := sum(c.width + len(GAP) for c in short) - len(GAP) - width) > 0
    ):
        if not left:
            alone = max(column.width for column in columns[1:]) + len(GAP) + columns[0].width
            return columns if alone <= width else short
        widest = max(left, key=lambda k: short[k].width)
        wide = short[widest].width
        short[widest] = short[widest].shortened(max(NARROW, wide - over))
        if short[widest].width in (wide, NARROW):
            left.remove(widest)
    return short


def _side_by_side(columns: list[_TextColumn], width: int | None) -> list[list[_TextColumn]]:
    """Groups of columns that have room beside one another, each with the columns that name the
    rows.
    """
    texts = list(itertools.takewhile(lambda column: not column.right or column.counts, columns))
    named = (
        texts
        if texts and width is not None and sum(c.width + len(GAP) for c in texts) <= NAMES * width
        else columns[:1]
    )
    groups = [list(named)]
    for column in columns[len(named) :]:
        used = sum(one.width + len(GAP) for one in groups[-1]) + column.width
        if width is not None and used > width and len(groups[-1]) > len(named):
            groups.append(list(named))
        groups[-1].append(column)
    return groups


def _lines_of(columns: list[_TextColumn]) -> list[str]:
    """The heading, a line, and the rows of columns beside one another."""

    def line(parts: Sequence[str]) -> str:
        placed = [
            part.rjust(c.width) if c.right else part.ljust(c.width)
            for part, c in zip(parts, columns, strict=True)
        ]
        return GAP.join(placed).rstrip()

    heading = [
        line(parts)
        for parts in ([c.title for c in columns], [c.unit for c in columns])
        if any(parts)
    ]
    rows = zip(*(column.cells for column in columns), strict=True)
    return [*heading, GAP.join("─" * column.width for column in columns), *map(line, rows)]


def as_markdown(block: Sheet | Lines) -> str:
    """Lines as a list, or a table, for a report."""
    if isinstance(block, Lines):
        texts = [
            escaped(line) if isinstance(line, str) else f"**{line[0]}**: {escaped(line[1])}"
            for line in block.lines
        ]
        return _heading(block.title) + "".join(f"- {text}\n" for text in texts)
    sheet = block
    rows = [
        [column.heading() for column in sheet.columns],
        *(
            [column.shown(cell) for column, cell in zip(sheet.columns, row, strict=True)]
            for row in sheet.rows
        ),
    ]
    lines = ["| " + " | ".join(map(escaped, row)) + " |" for row in rows]
    lines.insert(1, "|" + "|".join("---:" if right else "---" for right in numeric(sheet)) + "|")
    notes = [f"\n*{note[0].upper()}{note[1:]}.*" for note in map(escaped, sheet.notes)]
    return _heading(sheet.title) + "\n".join([*lines, *notes]) + "\n"


def _heading(title: str) -> str:
    text = escaped(title)
    return f"### {text[0].upper()}{text[1:]}\n\n" if text else ""


def as_csv(sheet: Sheet) -> str:
    """A table for a spreadsheet: full precision, `inf` for an infinite radius, no -0.0, empty where
    there is nothing.

    An apostrophe in front keeps a spreadsheet from computing a text that begins like a formula.
    Characters that are not printable are escapes.
    """
    return csv_text(
        [exact(cell) for cell in row]
        for row in ([column.heading(True) for column in sheet.columns], *sheet.rows)
    )


def as_records(sheet: Sheet) -> list[dict[str, Cell]]:
    """The rows for JSON, with the cells of `as_csv` by key; nothing where a cell is empty.

    A renamed quantity has its former key too.
    """
    keys = [column.key for column in sheet.columns]
    records = [dict(zip(keys, map(_plain, row), strict=True)) for row in sheet.rows]
    return [_with_former_keys(record) for record in records]


def units_of(sheet: Sheet) -> dict[str, str]:
    """The units of the keys of `as_records` that have one."""
    units = {column.key: column.exact_unit for column in sheet.columns if column.unit}
    return _with_former_keys(units)


def _with_former_keys(values: Mapping[str, T]) -> dict[str, T]:
    """Values by key, those of renamed quantities also by the former key."""
    return dict(values) | {former_key(key): value for key, value in values.items()}


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
    """A text that Markdown shows as it is: neither HTML nor markup, links, references, formulas or
    new cells.
    """
    import html  # a table of all entities, which no other format needs

    return re.sub(_MARKUP, r"\\\g<0>", html.escape(printable(text), quote=False))


def rounded(cell: Cell, zero: float = 1e-12) -> str:
    """A cell as people read it: at most four digits and four decimals; powers of ten where those
    would hide a number.

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
    decimals = [
        len(cell.partition(".")[2]) if re.fullmatch(r"-?\d+\.\d+", cell) else None for cell in cells
    ]
    most = max((n for n in decimals if n is not None), default=0)
    return [
        cell if n is None else cell + " " * (most - n)
        for cell, n in zip(cells, decimals, strict=True)
    ]


def exact(cell: Cell) -> str:
    """A cell with all digits, empty where there is nothing; a text is printable and no formula, as
    a number is none.
    """
    if isinstance(cell, str):
        text = printable(cell)
        return (
            f"'{text}"
            if text.lstrip(" ").startswith(_FORMULA) and not _NUMBER.fullmatch(text) and text != "-"
            else text
        )
    if isinstance(cell, int):
        return exact_text(cell)
    return "" if cell is None or math.isnan(cell) else repr(float(cell) + 0.0)


def exact_text(cell: str | int) -> str:
    """A text, a count, or yes or no, which are the same in every format."""
    return ("no", "yes")[cell] if isinstance(cell, bool) else str(cell)


def numeric(sheet: Sheet) -> list[bool]:
    """Which columns hold numbers."""
    kinds = (float, int)
    return [
        any(isinstance(row[k], kinds) and not isinstance(row[k], bool) for row in sheet.rows)
        for k in range(len(sheet.header))
    ]
