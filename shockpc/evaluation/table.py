"""The result of a study as columns: its worst rows, distribution, and what the ground allows."""

import itertools
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from shockpc.core.spatial import Array
from shockpc.evaluation.column import Column
from shockpc.quantities.renamed import current_name
from shockpc.quantities.selection import Selection, selections
from shockpc.text.arguments import checked
from shockpc.text.display import brief, shown_by
from shockpc.text.errors import DefectError, StudyError
from shockpc.text.printed import count, listed


@dataclass(frozen=True, eq=False)
class Table:
    """Landings, or what was derived from them, as rows, in columns by heading.

    Attributes:
        computed: the quantities that were computed, each a column of its name.
        columns: (n,) by heading: what tells the rows apart, then what was computed; NaN where a
            thing does not exist, None where a text does not. "proven" tells which rows hold proven
            numbers; "double_error" is how far double precision was off where it was compared with a
            proof, relative to the most severe shock of the same point; "row" is the number of the
            row, if some are left out.
        messages: why a row could not be computed, by its index.
        refused: numbers of rows that flat ground does not allow, left out or not: those in which it
            would pull a contact, the others in which the impact would make energy, and the others,
            in which another link is below it.
        defects: descriptions of unexpected exceptions, which are errors in shockpc itself.
        first: number of the first row.
        label_units: units of columns by heading, where neither the heading nor a quantity tells it.
        common: what all rows have in common, as "robot" and "contact", if that is known.
    """

    computed: tuple[Column, ...] = field(repr=False)
    columns: Mapping[str, np.ndarray] = field(repr=False)
    messages: Mapping[int, str] = field(repr=False)
    refused: tuple[int, int, int] = (0, 0, 0)
    defects: tuple[str, ...] = field(default=(), repr=False)
    first: int = 0
    label_units: Mapping[str, str] = field(default_factory=dict, repr=False)
    common: Mapping[str, str] = field(default_factory=dict, repr=False)

    _repr_html_ = shown_by("show.report:table_report")

    def __repr__(self) -> str:
        names = [*self.columns]
        left = len(names) - 8
        more = f" and {left} more" if left > 0 else ""
        return brief(self, count(len(self), "row"), f"{', '.join(names[:8])}{more}")

    def __call__(self) -> "Table":
        """Itself: `.table()` of a study is the same as `.table`."""
        return self

    def __len__(self) -> int:
        return len(next(iter(self.columns.values())))

    @classmethod
    def of_rows(
        cls,
        header: Sequence[str],
        rows: Iterable[Sequence[str | float | bool | None]],
        messages: Mapping[int, str] = {},
    ) -> "Table":
        """A table of rows of texts, numbers, True or False, with None where there is nothing.

        Args: header, names with units in brackets.
        """
        columns: dict[str, np.ndarray] = {}
        by_column = list(zip(*rows, strict=True)) or [()] * len(header)
        for name, cells in zip(header, by_column, strict=True):
            is_number = not any(isinstance(cell, str | bool) for cell in cells)
            columns[name] = np.array(cells, dtype=float if is_number else object)
        return cls((), columns, messages)

    @property
    def units(self) -> dict[str, str]:
        """The unit of every column by its heading, "-" for 1.

        It is empty for texts, True and False, for counts, and for numbers whose rows name theirs.
        """
        known = dict(self.label_units)
        known |= {column.name: column.unit for column in self.computed}
        columns = self.columns.items()
        return {name: known.get(name, _unit(name, values)) for name, values in columns}

    @classmethod
    def joined(cls, tables: Iterable["Table"]) -> "Table":
        """One table of consecutive ones."""
        parts = list(tables)
        first = parts[0]
        columns: dict[str, np.ndarray] = {}
        for name in first.columns:
            columns[name] = np.concatenate([part.columns[name] for part in parts])
        messages: dict[int, str] = {}
        defects: list[str] = []
        start = 0
        for part in parts:
            messages |= {start + i: text for i, text in part.messages.items()}
            defects += part.defects
            start += len(part)
        pulled, gained, below = np.sum([part.refused for part in parts], axis=0).tolist()
        return replace(
            first,
            columns=columns,
            messages=messages,
            refused=(pulled, gained, below),
            defects=tuple(defects),
        )

    def first_rows(self, count: int) -> "Table":
        """The first rows, at most so many."""
        columns = {name: values[:count] for name, values in self.columns.items()}
        messages = {i: text for i, text in self.messages.items() if i < count}
        return replace(self, columns=columns, messages=messages)

    def without_defects(self) -> "Table":
        """The table itself, for a study that does not give its rows on.

        Raises:
            DefectError: in a row an unexpected exception arose.
        """
        if self.defects:
            last_line = self.defects[0].splitlines()[-1]
            raise DefectError(
                f"an error in shockpc itself, please report it: {last_line}", self.defects[0]
            )
        return self

    @checked
    def column(self, text: str) -> Column:
        """The computed column that a text names, KEY or KEY@PLACE.

        Raises:
            StudyError: it names none, or several.
        """
        key, _, place = current_name(text).partition("@")
        named = [
            column
            for column in self.computed
            if column.selection.name == key and place in ("", column.place.name)
        ]
        if len(named) == 1:
            return named[0]
        listed_names = listed((column.name for column in named or self.computed), 6)
        valid = listed_names or "no columns that can be ranked"
        if named:
            raise StudyError(f'"{text}" means {valid}; name one of them')
        raise StudyError(f'no column is "{text}"; there are {valid}')

    @checked
    def values(self, column: Column | str) -> Array:
        """The values (n,) of a column, of a computed one also by what `column` takes."""
        if isinstance(column, Column):
            return self.columns[column.name]
        if column in self.columns:
            return self.columns[column]
        return self.columns[self.column(column).name]

    @property
    def main(self) -> tuple[Column, ...]:
        """The computed columns, without feasibility unless it was asked for."""
        return tuple(
            column
            for column in self.computed
            if column.requested or not column.selection.quantity.relations.role
        )

    @property
    def numbers(self) -> np.ndarray:
        """Numbers (n,) of the rows, of which some may be left out."""
        rows = self.columns.get("row")
        if rows is None or rows.dtype.kind in "UO":
            return np.arange(self.first, self.first + len(self))
        return rows.astype(int)

    @property
    def feasible(self) -> np.ndarray:
        """True (n,) if flat ground allows a landing, tilted a little or not, or it is not known."""
        names = [
            column.name for column in self.computed if column.selection.quantity.decided_by_ground
        ]
        if not names:
            return np.ones(len(self), dtype=bool)
        return np.asarray(np.any([self.columns[name] == 1.0 for name in names], axis=0))

    @property
    def tilted(self) -> np.ndarray:
        """True (n,) if flat ground allows a landing only if the robot is tilted a little."""
        for column in self.computed:
            if column.selection.quantity.relations.role == "tilt":
                return np.asarray(self.columns[column.name] == 1.0)
        return np.zeros(len(self), dtype=bool)

    @checked
    def ranked(self, column: Column | str) -> np.ndarray:
        """The rows (n,), the worst value of a column first, as `worse`; those without one last.

        Args:
            column: a computed one, what `column` takes, or a heading that is a quantity, with its
                place or without.

        Raises:
            StudyError: there is no such column.
        """
        selection = self._selection(column)
        return np.argsort(-selection.worse(self.values(column)), kind="stable")

    def _selection(self, column: Column | str) -> Selection:
        """The quantity of a column, as `ranked` takes it."""
        if isinstance(column, Column):
            return column.selection
        if column in self.columns:
            selection = selections().get(column.partition("@")[0])
            if selection is not None:
                return selection
        return self.column(column).selection

    @checked
    def worst(self, count: int, column: Column | str | None = None) -> list[int]:
        """The rows with the worst values of a column, at most so many.

        Without a column they are the worst of every computed one in turn.

        What tells whether flat ground allows a landing counts only where it was asked for.

        Args:
            count: number of rows.
            column: as in `ranked`.

        Raises:
            StudyError: there is no such column.
        """
        count = max(count, 0)
        columns: Sequence[Column | str] = self.main if column is None else (column,)
        orders = [self._worst_of(column_name, count) for column_name in columns]
        # The worst row of each column, then the next of each, every row once.
        rows: dict[int, None] = {}
        for of_rank in itertools.zip_longest(*orders):
            rows |= dict.fromkeys(row for row in of_rank if row is not None)
        return list(rows)[:count]

    def _worst_of(self, column: Column | str, count: int) -> list[int]:
        """The rows with the worst values of a column, at most so many, if these are finite."""
        rows = self.ranked(column)[:count]
        worst: list[int] = rows[np.isfinite(self.values(column)[rows])].tolist()
        return worst

    @checked
    def percentile(self, column: Column | str, share: float) -> float:
        """The smallest value that at least a share of a column's values [%] do not exceed.

        It is NaN if the column has no value.

        Raises:
            StudyError: there is no such column, it holds texts, or the share is not one of 0 to
                100.
        """
        values = self.values(column)
        if values.dtype.kind in "UO":
            raise StudyError(f'column "{column}" holds texts, which have no percentiles')
        if not 0.0 <= share <= 100.0:
            raise StudyError(f"a share of {share:g} is not valid; give one from 0 to 100 [%]")
        known = values[~np.isnan(values)]
        return float(percentile(known, share)) if known.size else np.nan

    def to_arrow(self) -> Any:
        """The table for pyarrow, with the messages as a column and null for NaN."""
        import pyarrow

        messages = pyarrow.nulls(len(self), pyarrow.string())
        if self.messages:
            texts = [self.messages.get(i) for i in range(len(self))]
            messages = pyarrow.array(texts, pyarrow.string())
        arrays = {name: _to_arrow(values) for name, values in self.columns.items()}
        return pyarrow.table({**arrays, "message": messages})

    def to_pandas(self) -> Any:
        """The table for pandas, with the messages as a column.

        Its `attrs` hold what the rows have in common (robot, contact), and the `units` and `titles`
        of its columns.
        """
        import pandas

        frame = pandas.DataFrame(self._with_messages())
        frame.attrs = {
            **self.common,
            "units": self.units,
            "titles": {column.name: column.title for column in self.computed},
        }
        return frame

    def to_polars(self) -> Any:
        """The table for polars, with the messages as a column."""
        import polars

        return polars.DataFrame(self._with_messages(), schema_overrides={"message": polars.String})

    def _with_messages(self) -> dict[str, Any]:
        """The columns, objects of NumPy as lists, whose types other libraries find out."""
        columns: dict[str, Any] = {}
        for name, values in self.columns.items():
            columns[name] = values.tolist() if values.dtype == object else values
        return {**columns, "message": [self.messages.get(i) for i in range(len(self))]}

    def __arrow_c_stream__(self, requested_schema: Any = None) -> Any:
        """The table for libraries that read Arrow's PyCapsule interface; it needs pyarrow.

        Polars, pandas and DuckDB are such.
        """
        return self.to_arrow().__arrow_c_stream__(requested_schema)

    def __dataframe__(self, *args: Any, **options: Any) -> Any:
        """The table for libraries that read the older dataframe protocol; it needs pyarrow."""
        return self.to_arrow().__dataframe__(*args, **options)


def percentile(values: Array, share: Any) -> Any:
    """The smallest value that at least a share of some values [%] do not exceed.

    The values are sorted in place.
    """
    return np.percentile(values, share, method="inverted_cdf", overwrite_input=True)


def _to_arrow(values: np.ndarray) -> Any:
    """A column (n,) for pyarrow.

    Its conversion imports pandas where that is installed, which costs more than many a sweep.
    """
    import pyarrow

    kind = values.dtype.kind
    if kind not in "bif":
        return pyarrow.array(values, from_pandas=True)
    data = np.ascontiguousarray(values)
    # Arrow has booleans and the mask of known values as bits.
    known = None
    if kind == "f" and np.isnan(data).any():
        known = pyarrow.py_buffer(np.packbits(~np.isnan(data), bitorder="little"))
    if kind == "b":
        data = np.packbits(data, bitorder="little")
    buffers = [known, pyarrow.py_buffer(data)]
    return pyarrow.Array.from_buffers(pyarrow.from_numpy_dtype(values.dtype), len(values), buffers)


def _unit(heading: str, values: np.ndarray) -> str:
    """The unit that a heading of numbers has in brackets, or that of the quantity that it names."""
    if values.dtype.kind not in "fi":
        return ""
    _, bracket, unit = heading.rpartition(" [")
    if bracket:
        return unit.removesuffix("]")
    selection = selections().get(heading.partition("@")[0])
    if selection is not None:
        return selection.quantity.unit_text
    return "deg" if heading.endswith("_deg") else ""
