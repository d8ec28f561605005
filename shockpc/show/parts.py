"""The rows of a sweep as files: parts in Parquet or CSV, each complete before it has its name, and what they belong to."""

import csv
import functools
import hashlib
import io
import json
import pickle
import platform
from collections.abc import Iterator
from concurrent.futures import Executor
from pathlib import Path
from typing import Any, Literal

import numpy as np

import shockpc
from shockpc.errors import OutputError
from shockpc.executor import in_order
from shockpc.model.dynamics import PINOCCHIO
from shockpc.paths import read_file
from shockpc.scene import scene_table
from shockpc.show.files import make_folder, write_text
from shockpc.show.tables.sheets import Sheet
from shockpc.show.tables.text import as_csv
from shockpc.studies.sweep.rows import Chunk, Sweep
from shockpc.studies.sweep.study import with_sweep

__all__ = ["DESCRIPTION", "Format", "describe", "open_sweep", "read_column", "write_parts"]

Format = Literal["parquet", "csv"]

DESCRIPTION = "sweep.json"
"""In the folder of a sweep: what its rows are, so that only the same sweep is continued there."""

ROWS = "rows"
"""Folder of the parts; nothing else is in it, so that other programs read all of it as one table."""


def describe(made: Sweep, format_: Format) -> dict[str, Any]:
    """All that the rows depend on, for their files and to recognise the same sweep again."""
    return {
        "schema": "shockpc.sweep/1",
        "scene": scene_table(made.scene),
        "robot": {"name": made.robot.name, "sha256": hashlib.sha256(made.robot.source.xml.encode()).hexdigest()},
        "vary": [
            {"subject": one.subject, "values": list(one.values), "span": one.span, "factor": one.factor} for one in made.variations
        ],
        "sample": made.sample,
        "latin hypercube": made.lhs,
        "seed": made.seed,
        "rows proven for comparison": made.prove,
        "columns": [*made.headings, "message"],
        "rows": made.rows,
        "parts": len(made.parts),
        "format": format_,
        "versions": {
            "shockpc": shockpc.__version__, "pinocchio": PINOCCHIO, "numpy": np.__version__, "python": platform.python_version(),
        },
    }  # fmt: skip


def open_sweep(made: Sweep, folder: Path, format_: Format, resume: bool) -> None:
    """Prepare the folder of a sweep.

    Args:
        made: the sweep.
        folder: made if it does not exist.
        format_: of the parts.
        resume: whether the folder may hold parts of the same sweep, which are kept.

    Raises:
        OutputError: the folder holds a sweep and is not to be continued, or another sweep; or it cannot be written, or `pyarrow` is
            not installed.
    """
    if format_ == "parquet":
        _arrow()
    description = json.loads(json.dumps(describe(made, format_)))
    path = folder / DESCRIPTION
    if path.exists():
        if not resume:
            raise OutputError(f'"{folder}" holds a sweep already; continue it with --resume, or name another folder with --out')
        try:
            found = json.loads(read_file(path, "file", OutputError))
        except (OutputError, ValueError):
            found = {}
        different = [key for key in description if not isinstance(found, dict) or found.get(key) != description[key]]
        if different:
            raise OutputError(
                f'"{folder}" holds another sweep, which differs in: {", ".join(different)}; it cannot be continued with this one; '
                "name another folder with --out"
            )
    elif resume and (folder / ROWS).exists():
        raise OutputError(
            f'"{folder}" has rows but no {DESCRIPTION}, so they may be of another sweep; name another folder with --out'
        )
    make_folder(folder / ROWS)
    write_text(path, json.dumps(description, indent=1, ensure_ascii=False) + "\n")


def write_parts(made: Sweep, folder: Path, format_: Format, executor: Executor, ahead: int) -> Iterator[int]:
    """Compute the parts that are missing in the folder of a sweep; yield the number of rows that were there, then of each part.

    Args:
        made: the sweep.
        folder: prepared by `open_sweep`.
        format_: of the parts.
        executor: computes and writes them.
        ahead: number of parts to submit before the first one is done.

    Raises:
        OutputError: a part cannot be written; those that are complete remain.
    """
    rows = folder.resolve() / ROWS
    for unfinished in rows.glob(".part-*"):
        unfinished.unlink(missing_ok=True)
    sizes = [(b - a) * made.strikes for a, b in made.parts]
    missing = [k for k in range(len(sizes)) if not (rows / _name(k, format_)).exists()]
    yield made.rows - sum(sizes[k] for k in missing)
    save = functools.partial(_save, str(rows), format_, json.dumps(describe(made, format_), ensure_ascii=False))
    try:
        yield from in_order(executor, functools.partial(with_sweep, pickle.dumps(made), save), missing, ahead)
    finally:
        for unfinished in rows.glob(".part-*"):
            unfinished.unlink(missing_ok=True)


def read_column(made: Sweep, folder: Path, format_: Format, name: str) -> Iterator[Any]:
    """A column of a sweep, part by part: (n,) floats with NaN where there is nothing, or texts with None there."""
    for k in range(len(made.parts)):
        path = folder / ROWS / _name(k, format_)
        if format_ == "parquet":
            column = _arrow().parquet.read_table(path, columns=[name])[name]
            yield np.array(column.to_pylist(), dtype=object) if name == "message" else column.to_numpy()
            continue
        with path.open(encoding="utf-8", newline="") as file:
            lines = csv.reader(file)
            place = next(lines).index(name)
            cells = [line[place] for line in lines]
        if name == "message":
            yield np.array(cells, dtype=object)
        elif name == "proven":
            yield np.array([cell == "yes" for cell in cells])
        else:
            yield np.array([float(cell) if cell else np.nan for cell in cells])


def _name(k: int, format_: Format) -> str:
    return f"part-{k:05d}.{format_}"


def _save(rows: str, format_: Format, description: str, made: Sweep, k: int) -> int:
    """Compute one part and write it, in whatever process this is; the number of its rows."""
    chunk = made.chunk(k)
    content: str | bytes = _parquet(chunk, description) if format_ == "parquet" else _csv(chunk)
    write_text(Path(rows) / _name(k, format_), content)
    return len(chunk.columns["proven"])


def _parquet(chunk: Chunk, description: str) -> bytes:
    """A chunk as a Parquet file; where there is no number there is a null."""
    pa = _arrow()
    n = len(chunk.columns["proven"])
    arrays = {name: pa.array(x, from_pandas=True) for name, x in chunk.columns.items()}
    texts = [chunk.messages.get(i) for i in range(n)] if chunk.messages else None
    arrays["message"] = pa.nulls(n, pa.string()) if texts is None else pa.array(texts, pa.string())
    table = pa.table(arrays).replace_schema_metadata({"shockpc": description})
    out = io.BytesIO()
    pa.parquet.write_table(table, out, compression="zstd", use_dictionary=["message"])
    return out.getvalue()


def _csv(chunk: Chunk) -> str:
    """A chunk as CSV; where there is no number the cell is empty."""
    n = len(chunk.columns["proven"])
    columns: list[list[Any]] = []
    for x in chunk.columns.values():
        if x.dtype.kind == "b":
            columns.append(["yes" if one else "no" for one in x.tolist()])
        else:
            columns.append(x.tolist() if x.dtype.kind == "U" else [None if one != one else one for one in x.tolist()])
    columns.append([chunk.messages.get(i) for i in range(n)])
    return as_csv(Sheet("", (*chunk.columns, "message"), list(zip(*columns, strict=True))))


def _arrow() -> Any:
    """The library that writes Parquet."""
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError:
        raise OutputError(
            'Parquet files need the package "pyarrow"; install it with: pip install "shockpc[sweep]", or use --format csv'
        ) from None
    return pyarrow
