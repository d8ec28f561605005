"""A table as files: parts in Parquet, which a later run continues, or one CSV file."""

import contextlib
import csv
import functools
import hashlib
import io
import itertools
import json
import platform
from collections.abc import Generator, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np

import shockpc
from shockpc.evaluation.evaluate import Evaluation
from shockpc.evaluation.table import Table
from shockpc.landing.scenes.scene_file import scene_table
from shockpc.method.dynamics import PINOCCHIO
from shockpc.show.files import destination, new_file, write_file
from shockpc.show.tables import csv_text, exact
from shockpc.text.errors import OutputError
from shockpc.text.paths import read_file
from shockpc.text.printed import json_text

Format = Literal["parquet", "csv"]

BYTES_READ_TOGETHER = 2**27
"""Bytes of columns, at most but for one column, that are read together.

A file is opened, or parsed, for any of them.
"""

LINES_PARSED_TOGETHER = 10_000


class _Notes(NamedTuple):
    """The properties of a chunk besides its rows.

    Attributes:
        refused: as in `Table`.
        defects: as in `Table`.
        kinds: of the columns and the message, by numpy's letters; empty of a part in Parquet.
    """

    refused: tuple[int, ...]
    defects: tuple[str, ...]
    kinds: tuple[str, ...] = ()


@dataclass(frozen=True)
class RowFiles:
    """The rows of a table in a folder, which is made if it does not exist.

    A file has its name when it is complete. Parquet has parts in the folder `rows`, so that other
    programs read all of it as one table; CSV is the file `rows.csv`.

    Attributes:
        evaluation: what is computed.
        folder: has the files.
        format: of the rows.
    """

    evaluation: Evaluation[Any]
    folder: Path
    format: Format
    _notes: list[_Notes] = field(default_factory=list, init=False, repr=False)
    """Notes of the chunks in a CSV file, which does not hold them."""

    def prepare(self, resume: bool) -> None:
        """Make the folder and describe the study in it.

        Args: resume, whether it may hold parts of the same study, which are kept.

        Raises:
            OutputError: the folder holds a study and is not to be continued, or another study; it
                cannot be written; CSV is to be continued; `pyarrow` is not installed.
        """
        if self.format == "parquet":
            arrow()
        elif resume:
            raise OutputError(
                "--resume continues the parts of a Parquet table, and a CSV file has none; "
                "leave --resume out, or write --rows parquet"
            )
        noun = self.evaluation.landings.noun
        path, description = self._described, self._description()
        if path.exists() or self._present:
            if not resume:
                remedy = "continue it with --resume, or " if self.format == "parquet" else ""
                raise OutputError(
                    f'"{self.folder}" holds a {noun} already; {remedy}name another folder with '
                    f"--out"
                )
            different = _different(path, description)
            if different:
                raise OutputError(
                    f'"{self.folder}" holds another {noun}, which differs in '
                    f"{', '.join(different)}, so it cannot be continued; name another folder with "
                    "--out"
                )
        if self.format == "parquet":  # else when the rows are complete
            write_file(path, json_text(description))

    def refuse_present(self) -> None:
        """Refuse a folder with rows of another run, for one that writes none.

        Its other files would be beside those.

        Raises:
            OutputError: the folder holds rows.
        """
        if self._present:
            raise OutputError(
                f'"{self.folder}" holds the rows of another run; name another folder with --out, '
                "or continue them with --rows and --resume"
            )

    def write(self, executor: Executor | None) -> Generator[int, None, None]:
        """Compute what is missing; yield the number of rows that were there, then of each chunk.

        Args: executor, computes the chunks.

        Raises:
            OutputError: a file cannot be written; parts that are complete remain.
        """
        return self._write_csv(executor) if self.format == "csv" else self._write_parts(executor)

    def table(self) -> Table:
        """All rows, of which columns are read from the files when they are asked for.

        Raises:
            OutputError: a file cannot be read; also when a column is read later.
        """
        notes = self._notes if self.format == "csv" else [_notes_of(part) for part in self._parts]
        columns = _Columns(self)
        texts = columns["message"]
        messages = {int(i): str(texts[i]) for i in np.flatnonzero(texts.astype(bool))}
        pulled, gained, below = np.sum([chunk.refused for chunk in notes], axis=0).tolist()
        defects = tuple(itertools.chain.from_iterable(chunk.defects for chunk in notes))
        refused = (pulled, gained, below)
        return Table(self.evaluation.computed, columns, messages, refused, defects)

    def read(self, names: Sequence[str]) -> Iterator[list[np.ndarray]]:
        """Some columns, part by part: (n,) numbers with NaN, or texts with None, for nothing.

        Raises:
            OutputError: a file cannot be read.
        """
        if self.format == "csv":
            yield from self._read_csv(names)
            return
        for path in self._parts:
            with _opened(path) as part:
                table = part.read(columns=list(names))
                columns = [_from_arrow(table[name]) for name in names]
            yield columns

    def _write_parts(self, executor: Executor | None) -> Generator[int, None, None]:
        """The missing parts in Parquet, each written where it is computed."""
        landings, parts = self.evaluation.landings, self._parts
        missing = [k for k, part in enumerate(parts) if not part.is_file()]
        yield landings.rows - sum(_count(self.evaluation, k) for k in missing)
        for k in missing:
            destination(parts[k])  # other processes do not know what this one has read
        # The values of a grid may be as long as all parts; they are in the columns.
        notes = {key: value for key, value in self._description().items() if key != "vary"}
        save = functools.partial(_save, self._rows.resolve(), json.dumps(notes, ensure_ascii=False))
        try:
            yield from self.evaluation.each(missing, save, executor)
        finally:
            for unfinished in self._rows.glob(".part-*"):
                unfinished.unlink(missing_ok=True)

    def _write_csv(self, executor: Executor | None) -> Generator[int, None, None]:
        """The one file in CSV, which has its name after the last chunk; then its description."""
        chunks = range(len(self.evaluation.landings.chunks))
        self._notes.clear()
        yield 0
        with new_file(self._csv, flush=True) as append:
            append(csv_text([[exact(name) for name in self.headings]]))
            for k, (lines, notes) in enumerate(
                self.evaluation.each(list(chunks), _lines, executor)
            ):
                append(lines)
                self._notes.append(notes)
                yield _count(self.evaluation, k)
        write_file(self._described, json_text(self._description()))

    def _read_csv(self, names: Sequence[str]) -> Iterator[list[np.ndarray]]:
        """The rows as `read` gives them, some lines at a time."""
        numbers = [self.headings.index(name) for name in names]
        kinds = []
        for k in numbers:
            kinds.append({notes.kinds[k] for notes in self._notes})
        try:
            with self._csv.open(encoding="utf-8", newline="") as file:
                lines = csv.reader(file)
                next(lines, None)  # the headings
                while block := list(itertools.islice(lines, LINES_PARSED_TOGETHER)):
                    columns: list[np.ndarray] = []
                    for k, of_column in zip(numbers, kinds, strict=True):
                        columns.append(_from_csv([line[k] for line in block], of_column))
                    yield columns
        except OSError as refusal:
            raise OutputError(f'"{self._csv}" cannot be read: {refusal}') from None

    @property
    def headings(self) -> tuple[str, ...]:
        """The headings of all columns, the message last."""
        return (*self.evaluation.headings, "message")

    @property
    def _described(self) -> Path:
        return self.folder / f"{self.evaluation.landings.noun}.json"

    @property
    def _rows(self) -> Path:
        return self.folder / "rows"

    @property
    def _csv(self) -> Path:
        return self.folder / "rows.csv"

    @property
    def _present(self) -> bool:
        return self._rows.exists() or self._csv.exists()

    @property
    def _parts(self) -> list[Path]:
        return [_part(self._rows, k) for k in range(len(self.evaluation.landings.chunks))]

    def _description(self) -> dict[str, Any]:
        """All that the rows depend on, for their files and to recognise the same study again."""
        made = self.evaluation.landings
        libraries = {"pinocchio": PINOCCHIO, "numpy": np.__version__}
        digest = hashlib.sha256(made.robot.source.xml.encode()).hexdigest()
        content = {
            "schema": f"shockpc.{made.noun}/1",
            "scene": scene_table(made.scene),
            "robot": {"name": made.robot.name, "sha256": digest},
            **self.evaluation.description,
            "columns": self.headings,
            "rows": made.rows,
            "parts": len(made.chunks),
            "format": self.format,
            "versions": {
                "shockpc": shockpc.__version__,
                **libraries,
                "python": platform.python_version(),
            },
        }
        description: dict[str, Any] = json.loads(json.dumps(content))  # as a file gives it back
        return description


class _Columns(Mapping[str, np.ndarray]):
    """The columns of files, read when one is asked for, together with those that follow it.

    The columns read last are kept.
    """

    def __init__(self, files: RowFiles) -> None:
        self._files, self._kept = files, dict[str, np.ndarray]()

    def __getitem__(self, name: str) -> np.ndarray:
        headings = self._files.headings
        if name not in headings:
            raise KeyError(name)
        if name not in self._kept:
            most = max(1, BYTES_READ_TOGETHER // (8 * self._files.evaluation.landings.rows))
            first = headings.index(name)
            names = (headings[first:] + headings)[: min(most, len(headings))]
            self._kept = {}
            parts = zip(*self._files.read(names), strict=True)
            self._kept = dict(zip(names, map(np.concatenate, parts), strict=True))
        return self._kept[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._files.evaluation.headings)

    def __len__(self) -> int:
        return len(self._files.evaluation.headings)


def _different(path: Path, description: Mapping[str, Any]) -> list[str]:
    """Keys of a description that have another value in a file, or none."""
    try:
        recorded = json.loads(read_file(path, "file", OutputError, output=True))
    except (OutputError, ValueError, RecursionError):
        recorded = None
    if not isinstance(recorded, dict):
        recorded = {}
    return [key for key, value in description.items() if recorded.get(key) != value]


def _count(evaluation: Evaluation[Any], k: int) -> int:
    """Number of rows of a chunk, of those left out too."""
    a, b = evaluation.landings.chunks[k]
    count: int = (b - a) * evaluation.landings.strikes
    return count


def _part(rows: Path, k: int) -> Path:
    return rows / f"part-{k:05d}.parquet"


def _save(rows: Path, description: str, evaluation: Evaluation[Any], table: Table, k: int) -> int:
    """Write a chunk in Parquet; the number of its rows."""
    # A traceback may hold names that are not UTF-8, which JSON escapes.
    notes = json.dumps({"refused": table.refused, "defects": table.defects})
    content = table.to_arrow().replace_schema_metadata({"shockpc": description, "chunk": notes})
    out = io.BytesIO()
    arrow().parquet.write_table(content, out, compression="zstd", use_dictionary=["message"])
    write_file(_part(rows, k), out.getvalue(), flush=True)
    return _count(evaluation, k)


def _notes_of(path: Path) -> _Notes:
    """The notes that a part in Parquet has of its chunk."""
    with _opened(path) as part:
        metadata = part.schema_arrow.metadata or {}
        notes = json.loads(metadata[b"chunk"])
        pulled, gained, below = map(int, notes["refused"])
        return _Notes((pulled, gained, below), tuple(map(str, notes["defects"])))


@contextlib.contextmanager
def _opened(path: Path) -> Iterator[Any]:
    """A part in Parquet.

    Raises:
        OutputError: it cannot be read, there or in the block.
    """
    try:
        with path.open("rb") as content:  # a path with a colon would be read as an address
            # What reads whole data sets imports pandas where that is installed.
            yield arrow().parquet.ParquetFile(content)
    except (OSError, KeyError, arrow().ArrowException):
        raise OutputError(
            f'"{path}" is damaged; delete it, and run the same command with --resume'
        ) from None


def _from_arrow(column: Any) -> np.ndarray:
    """A column of a part as an array.

    pyarrow's own conversion imports pandas where that is installed, which takes longer.
    """
    kind = {"double": float, "int64": np.int64, "bool": bool}.get(str(column.type))
    if kind is None or (column.null_count and kind is not float):
        if column.null_count == len(column):
            return np.full(len(column), None)
        return np.asarray(column.to_numpy())
    parts = [np.zeros(0, kind)]
    for chunk in column.chunks:
        known, data = chunk.buffers()
        block = slice(chunk.offset, chunk.offset + len(chunk))
        values = (_bits(data) if kind is bool else np.frombuffer(data, kind))[block]
        if chunk.null_count:
            values = np.where(_bits(known)[block], values, np.nan)
        parts.append(values)
    return np.concatenate(parts)


def _bits(data: Any) -> np.ndarray:
    return np.unpackbits(np.frombuffer(data, np.uint8), bitorder="little").astype(bool)


def arrow() -> Any:
    """The library that writes Parquet."""
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError:
        raise OutputError(
            'Parquet files need the package "pyarrow"; install it with: pip install pyarrow, or '
            "write a CSV file: --rows csv"
        ) from None
    return pyarrow


def _lines(_: Evaluation[Any], table: Table, __: int) -> tuple[str, _Notes]:
    """A chunk as lines of CSV, whose cells are empty where there is nothing; and its notes."""
    columns = [_cells(values) for values in table.columns.values()]
    messages = [exact(table.messages.get(i)) for i in range(len(table))]
    kinds = [values.dtype.kind for values in table.columns.values()]
    lines = csv_text(zip(*columns, messages, strict=True))
    return lines, _Notes(table.refused, table.defects, (*kinds, "O"))


def _cells(values: np.ndarray) -> list[Any]:
    """A column as `exact` writes it, but for floats, which CSV has with the same digits."""
    if values.dtype.kind == "f":
        cells: list[Any] = np.where(np.isnan(values), np.array(None), values + 0.0).tolist()
        return cells
    if values.dtype.kind == "b":
        values = np.where(values, "yes", "no")
    return [exact(x) for x in values.tolist()]


def _from_csv(cells: list[str], kinds: set[str]) -> np.ndarray:
    """A column of a CSV file as an array. Args: kinds, that it has in the chunks."""
    if kinds & {"O", "U"}:
        return np.array([cell or None for cell in cells], dtype=object)
    if kinds == {"b"}:
        return np.array([cell == "yes" for cell in cells])
    return np.array([float(cell or "nan") for cell in cells])
