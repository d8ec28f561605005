"""Files of recorded landings: columns by name from CSV, Parquet and NPZ."""

import csv
import io
import itertools
import zipfile
import zlib
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from shockpc.text.errors import StudyError
from shockpc.text.paths import open_file, usable_path

BLOCK = 8192
"""Rows of a CSV file that are read together."""


def read_table(path: Path) -> dict[str, np.ndarray]:
    """The columns of a CSV, Parquet or NPZ file by name: numbers or texts, (n,); arrays of NPZ may be (n, k).

    Raises:
        StudyError: the file cannot be read, has no rows, a name twice, a cell that is no number among numbers, or a column that
            holds neither real numbers nor texts.
    """
    path = usable_path(str(path))
    try:
        match path.suffix.casefold():
            case ".csv":
                columns = _read_csv(path)
            case ".parquet":
                columns = _read_parquet(path)
            case ".npz":
                with open_file(path, "table", StudyError) as stream, np.load(stream, allow_pickle=False) as file:
                    columns = {name: file[name] for name in file.files}
                columns |= {name: np.char.decode(values) for name, values in columns.items() if values.dtype.kind == "S"}
            case _:
                raise StudyError(f'"{path}" is not a table of landings; valid are .csv, .parquet and .npz files')
    except (OSError, ValueError, EOFError, RuntimeError, zipfile.BadZipFile, zlib.error) as refusal:
        raise StudyError(f'table "{path}" cannot be read: {refusal}') from None
    for name, values in columns.items():
        if values.ndim == 0 or values.dtype.kind not in "fiubOUM":
            raise StudyError(
                f'table "{path}": {name} is {values.dtype} of shape {values.shape}; columns hold real numbers or texts'
            )
    if not columns or min(map(np.size, columns.values())) == 0:
        raise StudyError(f'table "{path}" has no rows')
    return columns


def _read_csv(path: Path) -> dict[str, np.ndarray]:
    blocks: list[list[np.ndarray]] = []
    with open_file(path, "table", StudyError) as content, io.TextIOWrapper(content, "utf-8-sig", newline="") as file:
        lines = csv.reader(file)
        header = [name.strip() for name in next(lines, [])]
        if twice := [name for k, name in enumerate(header) if name in header[:k]]:
            raise ValueError(f'it has two columns "{twice[0]}"')
        rows, count = (row for row in lines if row), 0
        while block := list(itertools.islice(rows, BLOCK)):
            for i, row in enumerate(block):
                if len(row) != len(header):
                    raise ValueError(f"row {count + i} has {len(row)} cells, and the header {len(header)}")
            cells = list(zip(*block, strict=True))
            # The first cell that is not empty decides whether a column holds texts.
            first = (next(filter(str.strip, column), "") for column in cells)
            texts = [column.dtype.kind == "U" for column in blocks[0]] if blocks else list(map(_is_text, first))
            columns = zip(header, texts, cells, strict=True)
            blocks.append([np.char.strip(cells) if text else _numbers(name, cells, count) for name, text, cells in columns])
            count += len(block)
    return {name: np.concatenate([columns[k] for columns in blocks]) for k, name in enumerate(header if blocks else ())}


def _is_text(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return bool(cell.strip())
    return False


def _numbers(name: str, cells: Sequence[str], first: int) -> np.ndarray:
    """Cells as numbers, NaN where they are empty. Args: first, number of their first row."""
    try:
        return np.array(cells, dtype=float)
    except ValueError:
        if wrong := [i for i, cell in enumerate(cells) if _is_text(cell)]:
            raise ValueError(f'row {first + wrong[0]}, column {name}: "{cells[wrong[0]]}" is not a number') from None
        return np.array([cell if cell.strip() else "nan" for cell in cells], dtype=float)


def _read_parquet(path: Path) -> dict[str, np.ndarray]:
    try:
        import pyarrow.parquet  # an extra
    except ImportError:
        raise StudyError(
            'Parquet files need the package "pyarrow"; install it with: pip install pyarrow, or give a CSV or NPZ file'
        ) from None
    with open_file(path, "table", StudyError) as content:  # a path with a colon would be read as an address
        table = pyarrow.parquet.read_table(content)
    columns = {name: np.asarray(table[name].to_numpy()) for name in table.column_names}
    for name, values in columns.items():
        if values.dtype.kind == "O":
            texts = (cell.decode() if isinstance(cell, bytes) else cell for cell in values.tolist())
            columns[name] = np.array(["" if cell is None else cell for cell in texts], dtype=object)
    return columns
