"""Tables, aligned for a terminal, as Markdown for a report, or as CSV for a spreadsheet."""

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
"""Characters of a line of a table on a terminal, of a column of names at least, and the gap.

The gap is between columns.
"""

NAMES = 0.7
"""Share of the width up to which the first columns are repeated where a table continues.

They name the rows.
"""


class Heading(NamedTuple):
    """The heading of a column of a table, and how its cells are shown.

    Attributes:
        key: name of the column in JSON, which no other column of the table has.
        title: over the column.
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
    def of(cls, head: "str | Heading") -> "Heading":
        """The heading that a text means, a title with the unit in brackets.

        The key follows from it, with the unit of an angle in degrees.
        """
        if isinstance(head, Heading):
            return head
        title, _, unit = head.partition(" [")
        unit = unit.removesuffix("]")
        key = re.sub(r"[^\w@.:/+-]+", "_", title.replace(" - ", " minus "))
        key = key.strip("_").removesuffix("_deg")
        if unit == "deg":
            key += "_deg"
        return cls(key, title.removesuffix("_deg"), unit)

    @property
    def exact_unit(self) -> str:
        """The unit of the cells, and of CSV and JSON: of SI, or degrees."""
        return SHOWN.get(self.unit, (self.unit,))[0]

    def with_unit(self, exact: bool = False) -> str:
        """The title with the unit. Args: exact, that of the cells, else that for people."""
        unit = self.exact_unit if exact else self.unit
        return f"{self.title} [{unit}]" if unit else self.title

    def shown(self, cell: Cell) -> str:
        """A cell as people read it."""
        if self.unit in SHOWN and isinstance(cell, float):
            _, size = SHOWN[self.unit]
            cell = cell / size
        return rounded(cell, self.zero)


class Sheet(NamedTuple):
    """A table: a title, columns, rows, and notes under it.

    Numbers are in SI units, or degrees, as `Heading.exact_unit` says.
    """

    title: str
    header: Sequence[str | Heading]
    rows: Sequence[Sequence[Cell]]
    notes: Sequence[str] = ()

    @classmethod
    def of(
        cls, title: str, columns: Mapping[Any, Iterable[Any]], notes: Sequence[str] = ()
    ) -> "Sheet":
        """A table of columns by heading, or by `Heading`."""
        values: list[Iterable[Any]] = []
        for column in columns.values():
            values.append(column.tolist() if hasattr(column, "tolist") else column)
        return cls(title, tuple(columns), list(zip(*values, strict=True)), notes)

    @property
    def headings(self) -> list[Heading]:
        """The headings, also those that the header has as texts."""
        return [Heading.of(head) for head in self.header]

    @property
    def keys(self) -> list[str]:
        """The keys of the columns."""
        return [heading.key for heading in self.headings]

    def only(self, *keys: str) -> "Sheet":
        """Those of some columns that it has."""
        all_keys = self.keys
        kept = [all_keys.index(key) for key in keys if key in all_keys]
        header = [self.header[k] for k in kept]
        rows = [[row[k] for k in kept] for row in self.rows]
        return self._replace(header=header, rows=rows)

    def without(self, *keys: str) -> "Sheet":
        """All columns but some."""
        return self.only(*(key for key in self.keys if key not in keys))

    def headed(self, headings: Mapping[str, str]) -> "Sheet":
        """The table with other headings, by key; an empty one changes nothing."""
        header = []
        for heading in self.headings:
            text = headings.get(heading.key)
            header.append(Heading.of(text)._replace(key=heading.key) if text else heading)
        return self._replace(header=header)

    def known(self) -> "Sheet":
        """The table of the columns in which some row has a cell.

        All columns of a table without rows are kept, as nothing is known of them.
        """
        if not self.rows:
            return self
        known = []
        for k, key in enumerate(self.keys):
            if not all(_empty(row[k]) for row in self.rows):
                known.append(key)
        return self.only(*known)

    def where(self, kept: Callable[[dict[str, Cell]], bool]) -> "Sheet":
        """The rows of which a condition holds. Args: kept, of the cells of a row by key."""
        keys = self.keys
        rows = [row for row in self.rows if kept(dict(zip(keys, row, strict=True)))]
        return self._replace(rows=rows)

    def ranked(self, key: str) -> "Sheet":
        """The rows with the largest numbers of a column first."""
        k = self.keys.index(key)
        rows = sorted(self.rows, key=lambda row: -float(row[k] or 0.0))
        return self._replace(rows=rows)

    def largest(self, most: int | None, noun: str, sizes: Sequence[float] = ()) -> "Sheet":
        """The rows of the largest sizes in the order of the table.

        A note before the others says how many are left out.

        Args:
            most: largest number of rows; None for all.
            noun: what a row is.
            sizes: of the rows; without, the first rows are shown.
        """
        if most is None or len(self.rows) <= most:
            return self
        kept = list(range(len(self.rows)))
        note = count(len(self.rows) - most, noun)
        if len(sizes):
            kept.sort(key=lambda k: -sizes[k])
            note += " with smaller values"
        note += " not shown; --out writes all"
        rows = [self.rows[k] for k in sorted(kept[:most])]
        return self._replace(rows=rows, notes=(note, *self.notes))


def joined(sheets: Sequence[Sheet]) -> Sheet:
    """The rows of several tables below one another, with the columns that some of them have."""
    headings: dict[str, Heading] = {}
    for sheet in sheets:
        headings |= dict(zip(sheet.keys, sheet.headings, strict=True))
    rows = []
    for sheet in sheets:
        keys = sheet.keys
        for row in sheet.rows:
            cells = dict(zip(keys, row, strict=True))
            rows.append([cells.get(key) for key in headings])
    return sheets[0]._replace(header=list(headings.values()), rows=rows)


def sheet_of(
    table: "Table", title: str = "", notes: Sequence[str] = (), messages: str = ""
) -> Sheet:
    """The columns of a study's table, in the units of sheets.

    Args:
        table: of the study.
        title: over it.
        notes: under it.
        messages: heading of a last column that has the messages; without, rows with a message are
            left out.
    """
    header = []
    columns = []
    for (name, unit), values in zip(table.units.items(), table.columns.values(), strict=True):
        has_unit = " [" in name or not unit
        head = Heading.of(name if has_unit else f"{name} [{unit}]")
        if head.unit in SHOWN:
            _, size = SHOWN[head.unit]
            values = values * size
        header.append(head)
        columns.append(values.tolist())
    rows = list(zip(*columns, strict=True))
    if messages:
        header.append(Heading.of(messages))
        rows = [(*row, table.messages.get(i)) for i, row in enumerate(rows)]
    else:
        rows = [row for i, row in enumerate(rows) if i not in table.messages]
    return Sheet(title, header, rows, notes)


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
    """Lines, or a table, for a terminal.

    Names are to the left, numbers below one another at their points, columns as wide as needed.

    Args:
        block: lines or a table.
        width: most characters of a line of a table; None for any number. Names are shortened, and
            what is still too wide continues below with the columns that name the rows.
    """
    if isinstance(block, Lines):
        return _lines_as_text(block)
    columns = _as_wide(_columns_of(block), width)
    groups = ["\n".join(_lines_of(group)) for group in _side_by_side(columns, width)]
    notes = [f"({message(note)})" for note in block.notes]
    return "\n".join([printable(block.title), "\n\n".join(groups), *notes]) + "\n"


def _lines_as_text(block: Lines) -> str:
    show = printable if block.whole else message
    lines = [block.title] if block.title else []
    for line in block.lines:
        if isinstance(line, str):
            lines.append(show(line))
        else:
            name, text = line
            lines.append(f"{name:<12} {show(text)}")
    return "".join(f"{line}\n" for line in lines)


class _TextColumn(NamedTuple):
    """A column on a terminal: two lines of heading, cells, and whether these are to the right."""

    title: str
    unit: str
    cells: list[str]
    right: bool

    @property
    def width(self) -> int:
        return max(map(len, (self.title, self.unit, *self.cells)))

    @property
    def counts(self) -> bool:
        """True if its cells are whole numbers, as ranks are."""
        cells = map(str.strip, self.cells)
        return all(cell.isdigit() or cell == "–" for cell in cells)

    def shortened(self, width: int) -> "_TextColumn":
        """The column with names of at most so many characters; numbers and sentences stay whole."""
        cells = self.cells
        if not self.right:
            cells = [_shortened(cell, width) for cell in cells]
        return self._replace(title=_shortened(self.title, width), cells=cells)


def _shortened(text: str, width: int) -> str:
    """A name of at most so many characters; a sentence as it is."""
    is_sentence = " " in text.replace(", ", "")
    return text if is_sentence else printable(text, width)


def _columns_of(sheet: Sheet) -> list[_TextColumn]:
    columns = []
    for k, (heading, right) in enumerate(zip(sheet.headings, numeric(sheet), strict=True)):
        texts = [printable(heading.shown(row[k]), heading.width) for row in sheet.rows]
        unit = f"[{printable(heading.unit)}]" if heading.unit else ""
        title = printable(heading.title)
        columns.append(_TextColumn(title, unit, _at_the_point(texts), right))
    return columns


def _as_wide(columns: list[_TextColumn], width: int | None) -> list[_TextColumn]:
    """Columns with the longest names shortened until all have room, as far as `NARROW`.

    They stay as they are where they have none.
    """
    short = list(columns)
    if width is None:
        return short
    left = set(range(len(columns)))
    over = _width_of(short) - len(GAP) - width
    while over > 0:
        if not left:
            # The widest column may have room beside the first, which names the rows.
            widest_column = max(column.width for column in columns[1:])
            fits = columns[0].width + len(GAP) + widest_column <= width
            return columns if fits else short
        widest = max(left, key=lambda k: short[k].width)
        before = short[widest].width
        short[widest] = short[widest].shortened(max(NARROW, before - over))
        if short[widest].width in (before, NARROW):
            left.remove(widest)
        over = _width_of(short) - len(GAP) - width
    return short


def _width_of(columns: Iterable[_TextColumn]) -> int:
    """Characters of columns beside one another, each with the gap behind it."""
    return sum(column.width + len(GAP) for column in columns)


def _side_by_side(columns: list[_TextColumn], width: int | None) -> list[list[_TextColumn]]:
    """Groups of columns with room beside one another, each with the columns that name the rows."""
    if width is None:
        return [columns]
    naming = list(itertools.takewhile(lambda column: not column.right or column.counts, columns))
    if not naming or _width_of(naming) > NAMES * width:
        naming = columns[:1]
    groups = [list(naming)]
    for column in columns[len(naming) :]:
        used = _width_of(groups[-1]) + column.width
        if used > width and len(groups[-1]) > len(naming):
            groups.append(list(naming))
        groups[-1].append(column)
    return groups


def _lines_of(columns: list[_TextColumn]) -> list[str]:
    """The heading, a line, and the rows of columns beside one another."""
    lines = []
    for heading in ([c.title for c in columns], [c.unit for c in columns]):
        if any(heading):
            lines.append(_line(columns, heading))
    lines.append(GAP.join("─" * column.width for column in columns))
    for row in zip(*(column.cells for column in columns), strict=True):
        lines.append(_line(columns, row))
    return lines


def _line(columns: Sequence[_TextColumn], cells: Sequence[str]) -> str:
    """Cells beside one another, as wide as their columns."""
    placed = []
    for column, cell in zip(columns, cells, strict=True):
        placed.append(cell.rjust(column.width) if column.right else cell.ljust(column.width))
    return GAP.join(placed).rstrip()


def as_markdown(block: Sheet | Lines) -> str:
    """Lines as a list, or a table, for a report."""
    if isinstance(block, Lines):
        return _lines_as_markdown(block)
    headings = block.headings
    rows = [[heading.with_unit() for heading in headings]]
    for row in block.rows:
        cells = zip(headings, row, strict=True)
        rows.append([heading.shown(cell) for heading, cell in cells])
    lines = ["| " + " | ".join(map(escaped, row)) + " |" for row in rows]
    sides: list[str] = []
    for right in numeric(block):
        sides.append("---:" if right else "---")
    lines.insert(1, "|" + "|".join(sides) + "|")
    for note in map(escaped, block.notes):
        lines.append(f"\n*{note[0].upper()}{note[1:]}.*")
    return _markdown_title(block.title) + "\n".join(lines) + "\n"


def _lines_as_markdown(block: Lines) -> str:
    text = _markdown_title(block.title)
    for line in block.lines:
        if isinstance(line, str):
            text += f"- {escaped(line)}\n"
        else:
            name, value = line
            text += f"- **{name}**: {escaped(value)}\n"
    return text


def _markdown_title(title: str) -> str:
    text = escaped(title)
    return f"### {text[0].upper()}{text[1:]}\n\n" if text else ""


def as_csv(sheet: Sheet) -> str:
    """A table as CSV for a spreadsheet, in full precision.

    It has `inf` for an infinite radius and no -0.0, and is empty where there is nothing. An
    apostrophe in front keeps a spreadsheet from computing a text that begins like a formula.
    Characters that are not printable are escapes.
    """
    rows: list[Sequence[Cell]] = [[heading.with_unit(exact=True) for heading in sheet.headings]]
    rows += sheet.rows
    return csv_text([exact(cell) for cell in row] for row in rows)


def as_records(sheet: Sheet) -> list[dict[str, Cell]]:
    """The rows for JSON, with the cells of `as_csv` by key; nothing where a cell is empty.

    A renamed quantity has its former key too.
    """
    keys = sheet.keys
    records = [dict(zip(keys, map(_plain, row), strict=True)) for row in sheet.rows]
    return [_with_former_keys(record) for record in records]


def units_of(sheet: Sheet) -> dict[str, str]:
    """The units of the keys of `as_records` that have one."""
    units = {heading.key: heading.exact_unit for heading in sheet.headings if heading.unit}
    return _with_former_keys(units)


def _with_former_keys(values: Mapping[str, T]) -> dict[str, T]:
    """Values by key, those of renamed quantities also by the former key."""
    return dict(values) | {former_key(key): value for key, value in values.items()}


def _plain(cell: Cell) -> Cell:
    """A cell as JSON holds it; a number that is infinite as text, for which JSON has no other."""
    if cell is None or isinstance(cell, str | int):
        return cell
    if math.isnan(cell):
        return None
    number = float(cell) + 0.0  # no -0.0
    return str(number) if math.isinf(number) else number


def _empty(cell: Cell) -> bool:
    return cell in (None, "") or (isinstance(cell, float) and math.isnan(cell))


def csv_text(rows: Iterable[Sequence[Cell]]) -> str:
    """Rows of cells, as `exact` gives them, as CSV."""
    out = io.StringIO()
    import csv

    csv.writer(out, lineterminator="\n").writerows(rows)
    return out.getvalue()


def escaped(text: str) -> str:
    """A text that Markdown shows as it is.

    It makes no HTML, markup, links, references, formulas or new cells.
    """
    import html  # a table of all entities, which no other format needs

    return re.sub(_MARKUP, r"\\\g<0>", html.escape(printable(text), quote=False))


def rounded(cell: Cell, zero: float = 1e-12) -> str:
    """A cell as people read it: at most four digits and four decimals.

    It has a power of ten where those would hide a number.

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
    if abs(exponent) > 3:
        return f"{cell:.2e}"
    decimals = min(4, 3 - exponent)
    return f"{cell:.{decimals}f}"


def _at_the_point(cells: list[str]) -> list[str]:
    """The cells of a column with blanks after the decimals that some numbers have fewer of."""
    decimals: list[int | None] = []
    for cell in cells:
        number = re.fullmatch(r"-?\d+\.(\d+)", cell)
        decimals.append(None if number is None else len(number[1]))
    most = max((n for n in decimals if n is not None), default=0)
    aligned = []
    for cell, n in zip(cells, decimals, strict=True):
        blanks = 0 if n is None else most - n
        aligned.append(cell + " " * blanks)
    return aligned


def exact(cell: Cell) -> str:
    """A cell with all digits, empty where there is nothing.

    A text is printable and no formula, as a number is none.
    """
    if isinstance(cell, str):
        text = printable(cell)
        return f"'{text}" if _is_formula(text) else text
    if isinstance(cell, int):
        return exact_text(cell)
    if cell is None or math.isnan(cell):
        return ""
    return repr(float(cell) + 0.0)


def _is_formula(text: str) -> bool:
    """True if a spreadsheet would compute a text."""
    begins = text.lstrip(" ").startswith(_FORMULA)
    return begins and text != "-" and not _NUMBER.fullmatch(text)


def exact_text(cell: str | int) -> str:
    """A text, a count, or yes or no, which are the same in every format."""
    return ("no", "yes")[cell] if isinstance(cell, bool) else str(cell)


def numeric(sheet: Sheet) -> list[bool]:
    """True for each column that holds numbers."""
    columns = []
    for k in range(len(sheet.header)):
        columns.append(any(_is_number(row[k]) for row in sheet.rows))
    return columns


def _is_number(cell: Cell) -> bool:
    return isinstance(cell, float | int) and not isinstance(cell, bool)
