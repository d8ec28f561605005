"""A table as files: parts in Parquet or CSV, each complete before it has its name, and what they belong to."""

import csv
import functools
import hashlib
import io
import json
import os
import platform
import stat
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

import shockpc
from shockpc.evaluation.evaluate import Evaluation
from shockpc.evaluation.table import Table
from shockpc.landing.dynamics import PINOCCHIO
from shockpc.landing.scene_file import scene_table
from shockpc.show.files import destination, write_file
from shockpc.show.tables import csv_text, exact
from shockpc.text.errors import OutputError
from shockpc.text.paths import read_file
from shockpc.text.printed import json_text

Format = Literal["parquet", "csv"]

LARGEST_PART = 2**30
"""Bytes above which a file is no part that was written here."""

BYTES_READ_TOGETHER = 2**27
"""Bytes of columns, at most but for one column, that are read together: each file is opened, or parsed, for any of them."""


@dataclass(frozen=True)
class RowFiles:
    """The rows of a table in a folder, which is made if it does not exist.

    Attributes:
        evaluation: what is computed.
        folder: has the parts in a separate folder, so that other programs read all of it as one table.
        format: of the parts.
    """

    evaluation: Evaluation[Any]
    folder: Path
    format: Format

    def prepare(self, resume: bool) -> None:
        """Make the folder and describe the study in it. Args: resume, whether it may hold parts of the same study, which are kept.

        Raises:
            OutputError: the folder holds a sweep and is not to be continued, or another sweep, or a link, a pipe or a device where
                a file of it has to be; it cannot be written; `pyarrow` is not installed.
        """
        if self.format == "parquet":
            _arrow()
        noun = self.evaluation.landings.noun
        path, description = self.folder / f"{noun}.json", self._description()
        self._refuse_links(path)
        if path.exists() or self._rows.exists():
            if not resume:
                raise OutputError(
                    f'"{self.folder}" holds a {noun} already; continue it with --resume, or name another folder with --out'
                )
            try:
                recorded = json.loads(read_file(path, "file", OutputError, output=True))
            except (OutputError, ValueError, RecursionError):
                recorded = {}
            different = [key for key, value in description.items() if not isinstance(recorded, dict) or recorded.get(key) != value]
            if different:
                raise OutputError(
                    f'"{self.folder}" holds another {noun}, which differs in: {", ".join(different)}; it cannot be continued with '
                    "this one; name another folder with --out"
                )
        write_file(path, json_text(description))

    def refuse_present(self) -> None:
        """Refuse a folder that holds rows of another run, for one that writes none: its other files would be beside those.

        Raises:
            OutputError: the folder holds rows.
        """
        if self._rows.exists():
            raise OutputError(
                f'"{self.folder}" holds the rows of another run; name another folder with --out, or continue them with --rows and '
                "--resume"
            )

    def _refuse_links(self, described: Path) -> None:
        """Refuse what is no file or folder of a study: links, which would be followed, and pipes, which would be waited for."""
        folders = self._rows, _checksum(self._rows / "part").parent
        of_rows = (path for folder in folders if not folder.is_symlink() for path in sorted(folder.glob("*part-*")))
        for path in (*folders, described, *of_rows):
            if os.path.lexists(path) and stat.S_IFMT(os.lstat(path).st_mode) != (stat.S_IFDIR if path in folders else stat.S_IFREG):
                kind = "folder" if path in folders else "regular file"
                raise OutputError(f'"{path}" is no {kind}, which it has to be; remove it, or name another folder with --out')

    def write(self, executor: Executor | None) -> Iterator[int]:
        """Compute the parts that are missing or damaged; yield the number of rows that were there, then of each part.

        Args: executor, computes and writes them.

        Raises:
            OutputError: a part cannot be written; those that are complete remain.
        """
        landings, rows = self.evaluation.landings, self._rows.resolve()
        description = self._description()
        mark = json.dumps(description).encode()
        missing = [k for k in range(len(landings.chunks)) if not _complete(_part(rows, self.format, k), mark)]
        yield landings.rows - sum((b - a) * landings.strikes for a, b in (landings.chunks[k] for k in missing))
        for path in (path for k in missing for part in [_part(rows, self.format, k)] for path in (part, _checksum(part))):
            destination(path)  # other processes do not know what this one has read
        # The values of a grid may be as long as all parts; they are in the columns.
        notes = {key: value for key, value in description.items() if key != "vary"}
        save = functools.partial(_save, rows, self.format, json.dumps(notes, ensure_ascii=False), mark)
        try:
            yield from self.evaluation.each(missing, save, executor)
        finally:
            for unfinished in (*self._rows.glob(".part-*"), *_checksum(self._rows / "part").parent.glob(".part-*")):
                unfinished.unlink(missing_ok=True)

    def table(self) -> Table:
        """All rows, of which columns are read from the files when they are asked for.

        Raises:
            OutputError: a part is not as it was written; also when a column is read later.
        """
        counts = [self._counts(_part(self._rows, self.format, k)) for k in range(len(self.evaluation.landings.chunks))]
        _, pulled, gained, below = (sum(of_all) for of_all in zip(*counts, strict=True))
        columns = _Columns(self)
        texts = columns["message"]
        messages = {int(i): str(texts[i]) for i in np.flatnonzero(texts.astype(bool))}
        noted = [_noted(_part(self._rows, self.format, k))[1] for k in range(len(counts))]
        return Table(self.evaluation.computed, columns, messages, (pulled, gained, below), tuple(filter(None, noted)))

    def read(self, names: Sequence[str]) -> Iterator[list[Any]]:
        """Some columns, part by part: (n,) floats with NaN where there is nothing, or texts with nothing there.

        Raises:
            OutputError: a part is not as it was written.
        """
        for k in range(len(self.evaluation.landings.chunks)):
            path = _part(self._rows, self.format, k)
            try:
                columns = self._read(path, names)
            except (OSError, ValueError, LookupError, TypeError, NotImplementedError):
                columns = []
            if {len(values) for values in columns} != {self._counts(path)[0]}:
                raise _damaged(path)
            yield columns

    def _counts(self, part: Path) -> tuple[int, ...]:
        """Numbers of a part: of its rows, and of those that flat ground does not allow, for three reasons."""
        try:
            return tuple(map(int, _noted(part)[0].split()[1:]))
        except (OSError, ValueError):
            raise _damaged(part) from None

    def _read(self, path: Path, names: Sequence[str]) -> list[Any]:
        if self.format == "parquet":
            with path.open("rb") as content:  # a path with a colon would be read as an address
                # What reads whole data sets imports pandas where that is installed.
                table = _arrow().parquet.ParquetFile(content).read(columns=list(names))
            return [_from_arrow(table[name]) for name in names]
        headings = (*self.evaluation.headings, "message")
        with path.open(encoding="utf-8", newline="") as file:
            lines = list(csv.reader(file))[1:]  # after the header, which may hold headings escaped
        return [self._column(name, [line[k] for line in lines]) for name, k in ((name, headings.index(name)) for name in names)]

    def _column(self, name: str, cells: Sequence[str]) -> np.ndarray:
        """A column of a CSV file as an array."""
        if name == "proven":
            return np.array([cell == "yes" for cell in cells])
        if name in (*self.evaluation.landings.headings, "message"):
            return _texts_or_numbers(cells)
        return np.array(list(map(float, cells)) if all(cells) else [float(cell or "nan") for cell in cells])

    @property
    def _rows(self) -> Path:
        return self.folder / "rows"

    def _description(self) -> dict[str, Any]:
        """All that the rows depend on, for their files and to recognise the same sweep again; as JSON holds it."""
        made = self.evaluation.landings
        versions = {"pinocchio": PINOCCHIO, "numpy": np.__version__, "python": platform.python_version()}
        content = {
            "schema": f"shockpc.{made.noun}/1",
            "scene": scene_table(made.scene),
            "robot": {"name": made.robot.name, "sha256": hashlib.sha256(made.robot.source.xml.encode()).hexdigest()},
            **self.evaluation.description,
            "columns": [*self.evaluation.headings, "message"],
            "rows": made.rows,
            "parts": len(made.chunks),
            "format": self.format,
            "versions": {"shockpc": shockpc.__version__, **versions},
        }
        description: dict[str, Any] = json.loads(json.dumps(content))
        return description


def _texts_or_numbers(cells: Sequence[str]) -> np.ndarray:
    """What tells rows apart: numbers, or texts such as the names of contacts and messages."""
    try:
        return np.array([float(cell) for cell in cells])
    except ValueError:
        return np.array(cells, dtype=object)


def _part(rows: Path, format_: Format, k: int) -> Path:
    return rows / f"part-{k:05d}.{format_}"


def _checksum(part: Path) -> Path:
    """The file with the checksum and the counts of a part, in a separate folder beside that of the parts."""
    return part.parent.parent / "checksums" / f"{part.stem}.sha256"


def _noted(part: Path) -> tuple[str, str]:
    """The checksum with the counts of a part, and the descriptions of its unexpected exceptions."""
    line, _, defects = _checksum(part).read_bytes().decode().partition("\n")
    return line, defects


def _damaged(part: Path) -> OutputError:
    return OutputError(f'"{part}" is damaged; delete it, and run the same command with --resume')


def _digest(content: bytes, mark: bytes, counts: str, defects: str) -> str:
    """SHA-256 of a part, its counts, the descriptions of its unexpected exceptions and what its sweep is; then the counts.

    A part of another sweep, or one whose descriptions were changed, does not pass.
    """
    return f"{hashlib.sha256(mark + counts.encode() + defects.encode() + content).hexdigest()} {counts}"


def _complete(part: Path, mark: bytes) -> bool:
    """Whether a part is there, as it was written for this sweep: its columns, its rows and every byte."""
    try:
        if max(part.stat().st_size, _checksum(part).stat().st_size) > LARGEST_PART:
            return False
        noted, defects = _noted(part)
        return noted == _digest(part.read_bytes(), mark, noted.partition(" ")[2], defects)
    except (OSError, ValueError):
        return False


def _save(rows: Path, format_: Format, description: str, mark: bytes, evaluation: Evaluation[Any], table: Table, k: int) -> int:
    """Write one part where it was computed; the number of its rows, of those left out too."""
    content = _csv(table).encode("utf-8", "backslashreplace") if format_ == "csv" else _parquet(table, description)
    part, landings = _part(rows, format_, k), evaluation.landings
    # A part that has its name has its checksum, whenever the process is killed.
    counts = " ".join(map(str, (len(table), *table.refused)))
    defects = "".join(table.defects).encode(errors="backslashreplace").decode()  # may hold names that are not UTF-8
    write_file(_checksum(part), f"{_digest(content, mark, counts, defects)}\n{defects}", flush=True)
    write_file(part, content, flush=True)
    a, b = landings.chunks[k]
    count: int = (b - a) * landings.strikes
    return count


def _parquet(table: Table, description: str) -> bytes:
    """A table as a Parquet file; where there is no number there is a null."""
    out = io.BytesIO()
    content = table.to_arrow().replace_schema_metadata({"shockpc": description})
    _arrow().parquet.write_table(content, out, compression="zstd", use_dictionary=["message"])
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


class _Columns(Mapping[str, np.ndarray]):
    """The columns of parts, read when one is asked for, together with those that follow it; the columns read last are kept."""

    def __init__(self, files: RowFiles) -> None:
        self._files, self._kept = files, dict[str, np.ndarray]()

    def __getitem__(self, name: str) -> np.ndarray:
        files, headings = self._files, (*self._files.evaluation.headings, "message")
        if name not in headings:
            raise KeyError(name)
        if name not in self._kept:
            count = max(1, BYTES_READ_TOGETHER // (8 * files.evaluation.landings.rows))
            names = (headings[headings.index(name) :] + headings)[: min(count, len(headings))]
            self._kept = {}
            self._kept = {key: np.concatenate(x) for key, x in zip(names, zip(*files.read(names), strict=True), strict=True)}
        return self._kept[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._files.evaluation.headings)

    def __len__(self) -> int:
        return len(self._files.evaluation.headings)


def _arrow() -> Any:
    """The library that writes Parquet."""
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError:
        raise OutputError(
            'Parquet files need the package "pyarrow"; install it with: pip install pyarrow, or write CSV files: --rows csv'
        ) from None
    return pyarrow
