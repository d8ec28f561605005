"""A table as files: parts in Parquet or CSV, each complete before it has its name, and what they belong to."""

import functools
import hashlib
import json
import os
import platform
import stat
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import shockpc
from shockpc.evaluation.evaluate import Evaluation
from shockpc.evaluation.table import Table
from shockpc.landing.dynamics import PINOCCHIO
from shockpc.landing.scene_file import scene_table
from shockpc.show.files import destination, write_file
from shockpc.show.row_parts import Format, Part, arrow
from shockpc.text.errors import OutputError
from shockpc.text.paths import read_file
from shockpc.text.printed import json_text

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
            arrow()
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
        folders = self._folders
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
        landings = self.evaluation.landings
        description = self._description()
        mark = json.dumps(description).encode()
        missing = [k for k in range(len(landings.chunks)) if not self._part(k).complete(mark)]
        yield landings.rows - sum((b - a) * landings.strikes for a, b in (landings.chunks[k] for k in missing))
        for path in (path for k in missing for path in (self._part(k).path, self._part(k).checksum)):
            destination(path)  # other processes do not know what this one has read
        # The values of a grid may be as long as all parts; they are in the columns.
        notes = {key: value for key, value in description.items() if key != "vary"}
        save = functools.partial(_save, self._rows.resolve(), self.format, json.dumps(notes, ensure_ascii=False), mark)
        try:
            yield from self.evaluation.each(missing, save, executor)
        finally:
            for unfinished in (path for folder in self._folders for path in folder.glob(".part-*")):
                unfinished.unlink(missing_ok=True)

    def table(self) -> Table:
        """All rows, of which columns are read from the files when they are asked for.

        Raises:
            OutputError: a part is not as it was written; also when a column is read later.
        """
        parts = [self._part(k) for k in range(len(self.evaluation.landings.chunks))]
        _, pulled, gained, below = (sum(of_all) for of_all in zip(*(part.counts for part in parts), strict=True))
        columns = _Columns(self)
        texts = columns["message"]
        messages = {int(i): str(texts[i]) for i in np.flatnonzero(texts.astype(bool))}
        defects = tuple(filter(None, (part.noted[1] for part in parts)))
        return Table(self.evaluation.computed, columns, messages, (pulled, gained, below), defects)

    def read(self, names: Sequence[str]) -> Iterator[list[Any]]:
        """Some columns, part by part: (n,) floats with NaN where there is nothing, or texts with nothing there.

        Raises:
            OutputError: a part is not as it was written.
        """
        for k in range(len(self.evaluation.landings.chunks)):
            yield self._part(k).read(names, (*self.evaluation.headings, "message"), self.evaluation.landings.headings)

    @property
    def _rows(self) -> Path:
        return self.folder / "rows"

    @property
    def _folders(self) -> tuple[Path, Path]:
        """Of the parts, and of their checksums."""
        return self._rows, self._part(0).checksum.parent

    def _part(self, k: int) -> Part:
        return Part.of(self._rows, k, self.format)

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


def _save(rows: Path, format_: Format, description: str, mark: bytes, evaluation: Evaluation[Any], table: Table, k: int) -> int:
    """Write one part where it was computed; the number of its rows, of those left out too."""
    Part.of(rows, k, format_).write(table, description, mark)
    a, b = evaluation.landings.chunks[k]
    count: int = (b - a) * evaluation.landings.strikes
    return count


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
