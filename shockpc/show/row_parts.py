"""A part of a table in files: some of its rows in Parquet or CSV, complete before it has its name, and a checksum beside it."""

import csv
import hashlib
import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np

from shockpc.evaluation.table import Table
from shockpc.show.files import write_file
from shockpc.show.tables import csv_text, exact
from shockpc.text.errors import OutputError

Format = Literal["parquet", "csv"]

LARGEST_PART = 2**30
"""Bytes above which a file is no part that was written here."""


class Part(NamedTuple):
    """A part of a table; what its file or its checksum lacks makes it none.

    Attributes:
        path: of its file, whose name ends with its format, "parquet" or "csv".
    """

    path: Path

    @staticmethod
    def of(rows: Path, k: int, format_: Format) -> "Part":
        """Part k of a table. Args: rows: the folder of all parts."""
        return Part(rows / f"part-{k:05d}.{format_}")

    @property
    def checksum(self) -> Path:
        """The file with the checksum and the counts, in a separate folder beside that of the parts."""
        return self.path.parent.parent / "checksums" / f"{self.path.stem}.sha256"

    @property
    def noted(self) -> tuple[str, str]:
        """The checksum with the counts, and the descriptions of unexpected exceptions."""
        line, _, defects = self.checksum.read_bytes().decode().partition("\n")
        return line, defects

    @property
    def counts(self) -> tuple[int, ...]:
        """Numbers of its rows, and of those that flat ground does not allow, for three reasons.

        Raises:
            OutputError: it is not as it was written.
        """
        try:
            return tuple(map(int, self.noted[0].split()[1:]))
        except (OSError, ValueError):
            raise self._damaged from None

    @property
    def _damaged(self) -> OutputError:
        return OutputError(f'"{self.path}" is damaged; delete it, and run the same command with --resume')

    def complete(self, mark: bytes) -> bool:
        """Whether it is there with its columns, its rows and every byte. Args: mark, of the sweep for which it was written."""
        try:
            if max(self.path.stat().st_size, self.checksum.stat().st_size) > LARGEST_PART:
                return False
            noted, defects = self.noted
            return noted == _digest(self.path.read_bytes(), mark, noted.partition(" ")[2], defects)
        except (OSError, ValueError):
            return False

    def write(self, table: Table, description: str, mark: bytes) -> None:
        """Write it.

        Args:
            table: its rows.
            description: of the sweep, which Parquet holds.
            mark: of the sweep, by which `complete` knows it.

        Raises:
            OutputError: it cannot be written.
        """
        is_csv = self.path.suffix == ".csv"
        content = _csv(table).encode("utf-8", "backslashreplace") if is_csv else _parquet(table, description)
        counts = " ".join(map(str, (len(table), *table.refused)))
        defects = "".join(table.defects).encode(errors="backslashreplace").decode()  # may hold names that are not UTF-8
        # A part that has its name has its checksum, whenever the process is killed.
        write_file(self.checksum, f"{_digest(content, mark, counts, defects)}\n{defects}", flush=True)
        write_file(self.path, content, flush=True)

    def read(self, names: Sequence[str], headings: Sequence[str], varied: Sequence[str]) -> list[np.ndarray]:
        """Some columns (n,): floats with NaN where there is nothing, or texts with nothing there.

        Args:
            names: of these columns.
            headings: of all.
            varied: those of what varies, in which there may be texts.

        Raises:
            OutputError: it is not as it was written.
        """
        try:
            columns = self._columns(names, headings, varied)
        except (OSError, ValueError, LookupError, TypeError, NotImplementedError):
            columns = []
        if {len(values) for values in columns} != {self.counts[0]}:
            raise self._damaged
        return columns

    def _columns(self, names: Sequence[str], headings: Sequence[str], varied: Sequence[str]) -> list[np.ndarray]:
        if self.path.suffix == ".parquet":
            with self.path.open("rb") as content:  # a path with a colon would be read as an address
                # What reads whole data sets imports pandas where that is installed.
                table = arrow().parquet.ParquetFile(content).read(columns=list(names))
            return [_from_arrow(table[name]) for name in names]
        with self.path.open(encoding="utf-8", newline="") as file:
            lines = list(csv.reader(file))[1:]  # after the header, which may hold headings escaped
        numbers = {name: headings.index(name) for name in names}
        return [_from_csv([line[k] for line in lines], name, (*varied, "message")) for name, k in numbers.items()]


def _digest(content: bytes, mark: bytes, counts: str, defects: str) -> str:
    """SHA-256 of a part, its counts, the descriptions of its unexpected exceptions and what its sweep is; then the counts.

    A part of another sweep, or one whose descriptions were changed, does not pass.
    """
    return f"{hashlib.sha256(mark + counts.encode() + defects.encode() + content).hexdigest()} {counts}"


def _parquet(table: Table, description: str) -> bytes:
    """A table as a Parquet file; where there is no number there is a null."""
    out = io.BytesIO()
    content = table.to_arrow().replace_schema_metadata({"shockpc": description})
    arrow().parquet.write_table(content, out, compression="zstd", use_dictionary=["message"])
    return out.getvalue()


def _from_arrow(column: Any) -> np.ndarray:
    """A column of a Parquet file as an array, as pyarrow converts it, which imports pandas for that where it is installed."""
    kind, parts = {"double": float, "int64": np.int64, "bool": bool}.get(str(column.type)), []
    if kind is None or (column.null_count and kind is not float):
        return np.asarray(column.to_numpy()) if column.null_count < len(column) else np.full(len(column), None)
    for chunk in column.chunks:
        known, data = chunk.buffers()
        block = slice(chunk.offset, chunk.offset + len(chunk))
        values = (_bits(data) if kind is bool else np.frombuffer(data, kind))[block]
        parts.append(np.where(_bits(known)[block], values, np.nan) if chunk.null_count else values)
    return np.concatenate([np.zeros(0, kind), *parts])


def _bits(data: Any) -> np.ndarray:
    return np.unpackbits(np.frombuffer(data, np.uint8), bitorder="little").astype(bool)


def _csv(table: Table) -> str:
    """A table as CSV; where there is no number the cell is empty."""
    columns = [_cells(x) for x in table.columns.values()]
    messages = [exact(table.messages.get(i)) for i in range(len(table))]
    return csv_text([[exact(name) for name in (*table.columns, "message")], *zip(*columns, messages, strict=True)])


def _cells(values: np.ndarray) -> list[Any]:
    """A column as `exact` writes its cells, but for floats, which a CSV file has with the same digits."""
    if values.dtype.kind == "f":
        cells: list[Any] = np.where(np.isnan(values), np.array(None), values + 0.0).tolist()
        return cells
    return [exact(x) for x in (np.where(values, "yes", "no") if values.dtype.kind == "b" else values).tolist()]


def _from_csv(cells: Sequence[str], name: str, texts: Sequence[str]) -> np.ndarray:
    """A column of a CSV file as an array. Args: texts: names of columns in which there may be texts, such as names of contacts."""
    if name == "proven":
        return np.array([cell == "yes" for cell in cells])
    try:
        return np.array(list(map(float, cells)) if name in texts or all(cells) else [float(cell or "nan") for cell in cells])
    except ValueError:
        if name in texts:
            return np.array(cells, dtype=object)
        raise


def arrow() -> Any:
    """The library that writes Parquet."""
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError:
        raise OutputError(
            'Parquet files need the package "pyarrow"; install it with: pip install pyarrow, or write CSV files: --rows csv'
        ) from None
    return pyarrow
