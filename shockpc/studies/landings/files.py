"""Files of recorded landings: columns by name from CSV, Parquet and NPZ."""

import csv
import itertools
import zipfile
import zlib
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from shockpc.errors import StudyError
from shockpc.paths import usable_path


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
                with path.open("rb") as stream, np.load(stream, allow_pickle=False) as file:
                    columns = {name: file[name] for name in file.files}
            case _:
                raise StudyError(f'"{path}" is not a table of landings; valid are .csv, .parquet and .npz files')
    except (OSError, ValueError, EOFError, RuntimeError, zipfile.BadZipFile, zlib.error) as refusal:
        raise StudyError(f'table "{path}" cannot be read: {refusal}') from None
    for name, values in columns.items():
        if values.ndim == 0 or values.dtype.kind not in "fiubOUSM":
            raise StudyError(
                f'table "{path}": {name} is {values.dtype} of shape {values.shape}; columns hold real numbers or texts'
            )
    if not columns or min(map(np.size, columns.values())) == 0:
        raise StudyError(f'table "{path}" has no rows')
    return columns


def _read_csv(path: Path) -> dict[str, np.ndarray]:
    with path.open(encoding="utf-8-sig", newline="") as file:
        lines = csv.reader(file)
        header = [name.strip() for name in next(lines, [])]
        first = next((line for line in lines if line), None)
    if first is None:
        return {}
    if twice := [name for k, name in enumerate(header) if name in header[:k]]:
        raise ValueError(f'it has two columns "{twice[0]}"')
    texts = [k for k, cell in enumerate(first) if _number(cell) is None and cell.strip()]
    numbers = [k for k in range(len(header)) if k not in texts]
    try:
        chosen = numbers if texts else None
        values = np.loadtxt(path, delimiter=",", skiprows=1, usecols=chosen, ndmin=2, quotechar='"', encoding="utf-8-sig")
        rows: list[list[str]] = []
        if texts:
            with path.open(encoding="utf-8-sig", newline="") as file:
                rows = [row for row in itertools.islice(csv.reader(file), 1, None) if row]
        if values.shape[1] != len(numbers) or any(len(row) != len(header) for row in rows):
            raise ValueError("its rows and its header differ in length")
        columns: dict[str, np.ndarray] = {header[k]: values[:, place] for place, k in enumerate(numbers)}
        columns |= {header[k]: np.array([row[k].strip() for row in rows]) for k in texts}
    except (ValueError, IndexError):
        _refuse_cell(path, header, numbers)
        raise
    return {name: columns[name] for name in header}


def _refuse_cell(path: Path, header: Sequence[str], numbers: Sequence[int]) -> None:
    """Raise ValueError for the first row of a CSV file that is no row of numbers."""
    with path.open(encoding="utf-8-sig", newline="") as file:
        for i, row in enumerate(itertools.islice(csv.reader(file), 1, None)):
            if row and len(row) != len(header):
                raise ValueError(f"row {i} has {len(row)} cells, and the header {len(header)}")
            for k in numbers if row else ():
                if _number(row[k]) is None:
                    raise ValueError(f'row {i}, column {header[k]}: "{row[k]}" is not a number')


def _number(cell: str) -> float | None:
    try:
        return float(cell)
    except ValueError:
        return None


def _read_parquet(path: Path) -> dict[str, np.ndarray]:
    try:
        import pyarrow.parquet  # an extra
    except ImportError:
        raise StudyError(
            'Parquet files need the package "pyarrow"; install it with: pip install pyarrow, or give a CSV or NPZ file'
        ) from None
    table = pyarrow.parquet.read_table(path)
    return {name: np.asarray(table[name].to_numpy()) for name in table.column_names}
