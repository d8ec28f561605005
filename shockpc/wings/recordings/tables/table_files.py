"""Files of recorded landings: columns by name from CSV, Parquet and NPZ."""

import collections
import csv
import functools
import io
import itertools
import lzma
import math
import os
import zipfile
import zlib
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import IO, Any

import numpy as np

from shockpc.evaluation.table import Table
from shockpc.robot.files.limited_process import in_child
from shockpc.text.errors import StudyError
from shockpc.text.paths import open_file, usable_path

BLOCK = 2**20
"""Cells of a CSV file that are read together."""

LARGEST_TABLE = 2**30
"""Bytes of the largest table that is read, as a file and as arrays of numbers with 8 bytes each."""

MOST_ROWS = 2**24
"""Rows of the longest table that is read."""


def columns_of(table: str | os.PathLike[str] | Mapping[str, Any] | Table) -> dict[str, np.ndarray]:
    """The columns of recorded landings by name.

    They are from a file as `read_table` reads it, or as they are.

    Raises:
        StudyError: the file cannot be read, there are no rows, or a column holds neither real
            numbers nor texts.
    """
    if isinstance(table, str | os.PathLike):
        return read_table(Path(table))
    columns = table.columns if isinstance(table, Table) else table
    return _checked(
        {str(name): np.asarray(values) for name, values in columns.items()}, "this table"
    )


def read_table(path: Path) -> dict[str, np.ndarray]:
    """The columns of a CSV, Parquet or NPZ file by name.

    They hold numbers or texts (n,); arrays of NPZ may be (n, k).

    A column of a CSV file with a cell that is no number holds texts. Of a row that has not a cell
    for each column, only the text at its beginning is kept, because of the others it is not known
    where they belong.

    Raises:
        StudyError: the file cannot be read, is no regular file, takes more than 1 GB, has no rows,
            a name twice, no row with a cell for each column, or a column that holds neither real
            numbers nor texts.
    """
    path = usable_path(str(path))
    readers = {".csv": _read_csv, ".parquet": _read_parquet, ".npz": _read_npz}
    if (reader := readers.get(path.suffix.casefold())) is None:
        raise StudyError(
            f'"{path}" is not a table of landings; valid are .csv, .parquet and .npz files'
        )
    try:
        with open_file(path, "table", StudyError) as file:
            _refuse_size(os.fstat(file.fileno()).st_size)
            columns = reader(file)
    except (
        OSError,
        ValueError,
        EOFError,
        RuntimeError,
        zipfile.BadZipFile,
        zlib.error,
        lzma.LZMAError,
    ) as refusal:
        raise StudyError(f'table "{path}" cannot be read: {refusal}') from None
    return _checked(columns, f'table "{path}"')


def _checked(columns: dict[str, np.ndarray], table_name: str) -> dict[str, np.ndarray]:
    """The columns of a table, refused without rows or with neither numbers nor texts.

    Messages call the table by a name.
    """
    for name, values in columns.items():
        if values.ndim == 0 or values.dtype.kind not in "fiubOUM":
            raise StudyError(
                f"{table_name}: {name} is {values.dtype} of shape {values.shape}; columns hold "
                f"real numbers or texts"
            )
    if not columns or min(map(np.size, columns.values())) == 0:
        raise StudyError(f"{table_name} has no rows")
    return columns


def _refuse_size(size: int) -> None:
    """Refuse more than `LARGEST_TABLE` bytes."""
    if size > LARGEST_TABLE:
        limit = f"up to {LARGEST_TABLE // 2**20} MB are read"
        raise ValueError(
            f"it takes {size / 2**20:.0f} MB, and {limit}; leave columns out, shorten texts, or "
            f"split the table"
        )


def _refuse_rows(count: int) -> None:
    """Refuse more than `MOST_ROWS` rows."""
    if count > MOST_ROWS:
        raise ValueError(
            f"it has {count:.3g} rows, and up to {MOST_ROWS} are read; split the table"
        )


def _refuse_twice(names: Iterable[str]) -> None:
    """Refuse two columns of one name."""
    if twice := [name for name, count in collections.Counter(names).items() if count > 1]:
        raise ValueError(f'it has two columns "{twice[0]}"')


def _text_size(cells: Sequence[object]) -> int:
    """Bytes of texts as an array, in which each takes as much as the longest."""
    return 4 * len(cells) * max((len(cell) for cell in cells if isinstance(cell, str)), default=0)


def _read_csv(stream: IO[bytes]) -> dict[str, np.ndarray]:
    """The columns of a CSV file, in which groups of rows are read one after another."""
    groups: list[list[np.ndarray]] = []
    wrong: list[str] = []
    count = size = 0
    with io.TextIOWrapper(stream, "utf-8-sig", newline="") as text:
        # Not strict, a quotation mark that is not closed would take the rest of the file into one
        # cell.
        lines = csv.reader(text, strict=True)
        try:
            header = [name.strip() for name in next(lines, [])]
            _refuse_twice(header)
            filled = (row for row in lines if row)
            length = max(1, BLOCK // max(len(header), 1))
            while rows := list(itertools.islice(filled, length)):
                wrong += _without_wrong_lengths(rows, len(header), count)
                columns = list(zip(*rows, strict=True))
                # The first group decides, so that a column is of one kind.
                if groups:
                    texts = [column.dtype.kind == "U" for column in groups[0]]
                else:
                    texts = [_begins_with_text(column) for column in columns]
                # Before the arrays exist: texts may take any memory.
                size += _size_as_arrays(columns, texts)
                _refuse_size(size)
                groups.append(_arrays(columns, texts))
                count += len(rows)
                _refuse_rows(count)
        except csv.Error as refusal:
            raise ValueError(
                f"line {lines.line_num}: {refusal}; is a quotation mark not closed?"
            ) from None
    if wrong and len(wrong) == count:
        raise ValueError(wrong[0])
    return _joined(header, groups, count)


def _without_wrong_lengths(rows: list[list[str]], length: int, start: int) -> list[str]:
    """Empty the rows that do not have a cell for each column; the messages about them.

    A text at their beginning is kept.

    Args: rows; length, number of columns; start, number of the first row in the file.
    """
    messages: list[str] = []
    for i, row in enumerate(rows):
        if len(row) != length:
            messages.append(f"row {start + i} has {len(row)} cells, and the header {length}")
            begin = row[0] if _is_text(row[0]) else ""
            rows[i] = [begin, *[""] * (length - 1)]
    return messages


def _begins_with_text(cells: Sequence[str]) -> bool:
    """True if the first cell that is not empty is no number."""
    return _is_text(next(filter(str.strip, cells), ""))


def _size_as_arrays(columns: Sequence[Sequence[str]], texts: Sequence[bool]) -> int:
    """Bytes of columns as arrays, of texts or of numbers."""
    size = 0
    for column, is_text in zip(columns, texts, strict=True):
        size += _text_size(column) if is_text else 8 * len(column)
    return size


def _arrays(columns: Sequence[Sequence[str]], texts: Sequence[bool]) -> list[np.ndarray]:
    """Columns as arrays, of texts or of numbers."""
    arrays: list[np.ndarray] = []
    for column, is_text in zip(columns, texts, strict=True):
        arrays.append(np.char.strip(column) if is_text else _numeric_cells(column))
    return arrays


def _joined(
    header: Sequence[str], groups: Sequence[Sequence[np.ndarray]], count: int
) -> dict[str, np.ndarray]:
    """The columns by name, of groups of their rows; count is the number of all rows."""
    if not groups:
        return {}
    by_column = list(zip(*groups, strict=True))
    # Every row of a joined column takes as much as the longest text of any group.
    row_size = 0
    for parts in by_column:
        row_size += max(part.dtype.itemsize for part in parts)
    _refuse_size(row_size * count)
    return {name: np.concatenate(parts) for name, parts in zip(header, by_column, strict=True)}


def _is_text(cell: str) -> bool:
    try:
        parsed_number(cell)
    except ValueError:
        return bool(cell.strip())
    return False


def parsed_number(cell: str) -> float:
    """A number as every program writes it.

    What Python alone reads as a number is a ValueError: 1_0, and digits of other scripts.
    """
    _refuse_other_digits(cell)
    return float(cell)


def _refuse_other_digits(text: str) -> None:
    if "_" in text or not text.isascii():
        raise ValueError(f'"{text}" is not a number')


def _numeric_cells(cells: Sequence[str]) -> np.ndarray:
    """Cells as numbers, NaN where they are empty; as texts, if one of them is no number."""
    try:
        _refuse_other_digits("".join(cells))
        return np.array(cells, dtype=float)
    except ValueError:
        if any(map(_is_text, cells)):
            return np.char.strip(cells)
        numbers = np.full(len(cells), np.nan)
        for i, cell in enumerate(cells):
            if cell.strip():
                numbers[i] = float(cell)
        return numbers


def _read_npz(stream: IO[bytes]) -> dict[str, np.ndarray]:
    with zipfile.ZipFile(stream) as archive:
        members = archive.infolist()
        _refuse_twice(member.filename.removesuffix(".npy") for member in members)
        _refuse_size(sum(member.file_size for member in members))  # of which no more is read
    stream.seek(0)
    columns = dict[str, np.ndarray]()
    with np.load(stream) as arrays:
        for name in arrays.files:
            try:
                values = arrays[name]
            except Exception as refusal:  # of many kinds, because a literal of Python is read
                raise ValueError(f'its member "{name}" is no array: {refusal}') from None
            if not isinstance(values, np.ndarray):
                raise ValueError(f'its member "{name}" is no array')
            _refuse_rows(math.prod(values.shape[:1]))
            columns[name] = values
    size = 0
    for values in columns.values():
        # Bytes become characters of four bytes each.
        characters = 4 if values.dtype.kind == "S" else 1
        size += max(8 * values.size, characters * values.nbytes)
    _refuse_size(size)
    for name, values in columns.items():
        if values.dtype.kind == "S":
            columns[name] = np.char.decode(values)
    return columns


def _read_parquet(stream: IO[bytes]) -> dict[str, np.ndarray]:
    try:
        import pyarrow.parquet  # an extra
    except ImportError:
        raise StudyError(
            'Parquet files need the package "pyarrow"; install it with: pip install pyarrow, or '
            "give a CSV or NPZ file"
        ) from None
    try:
        file = pyarrow.parquet.ParquetFile(stream)
        _refuse_rows(file.metadata.num_rows)
        leaves = [file.schema.column(k) for k in range(file.metadata.num_columns)]
        groups = [file.metadata.row_group(k) for k in range(file.metadata.num_row_groups)]
        values = file.metadata.num_rows * len(leaves)
        if any(leaf.max_repetition_level for leaf in leaves):
            stream.seek(0)
            length = in_child(
                functools.partial(_values_of_lists, stream.read()), ("pyarrow.parquet",)
            )
            if length is None:
                raise ValueError("its header is corrupt")
            values += length
        _refuse_size(max(sum(group.total_byte_size for group in groups), 8 * values))
        _refuse_twice(file.schema_arrow.names)
        # A text that many rows share is kept once: a small file could take any memory if each row
        # had a copy.
        coded = [leaf.path for leaf in leaves if leaf.physical_type == "BYTE_ARRAY"]
        file, batches, count = pyarrow.parquet.ParquetFile(stream, read_dictionary=coded), [], 0
        for batch in file.iter_batches():
            count += len(batch)
            _refuse_rows(count)  # whatever the header says
            batches.append(batch)
        table = pyarrow.Table.from_batches(batches, file.schema_arrow)
        columns = {name: _parquet_column(table[name]) for name in table.column_names}
    except pyarrow.ArrowException as refusal:
        raise ValueError(str(refusal)) from None
    size = 0
    for name, values in columns.items():
        if values.dtype.kind == "O":
            texts = list(map(_text_of, values.tolist()))
            columns[name] = np.array(texts, dtype=object)
            size += _text_size(texts)
        else:
            size += values.nbytes
    _refuse_size(size)
    return columns


def _text_of(cell: object) -> object:
    """A cell of Parquet whose bytes are text, and that is empty where it is missing."""
    if isinstance(cell, bytes):
        return cell.decode()
    return "" if cell is None else cell


def _values_of_lists(data: bytes) -> int:
    """Number of values of the lists of a Parquet file by its header.

    Where that is corrupt, pyarrow ends the process.
    """
    import pyarrow.parquet

    header = pyarrow.parquet.ParquetFile(io.BytesIO(data)).metadata
    count = 0
    for g in range(header.num_row_groups):
        group = header.row_group(g)
        count += sum(group.column(k).num_values for k in range(group.num_columns))
    return count


def _parquet_column(column: Any) -> np.ndarray:
    """A column of pyarrow as an array; rows whose text is the same share it."""
    import pyarrow

    if not pyarrow.types.is_dictionary(column.type):
        return np.asarray(column.to_numpy())
    # pyarrow's conversion takes a missing value for the first of the dictionary.
    parts = [np.zeros(0, dtype=object)]
    for chunk in column.chunks:
        chunk.validate(full=True)  # an index beyond the end of its dictionary
        values = np.array([*chunk.dictionary.to_pylist(), None], dtype=object)
        parts.append(values[chunk.indices.fill_null(len(values) - 1).to_numpy()])
    return np.concatenate(parts)
