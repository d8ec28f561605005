"""The rows of a study of many landings, computed with progress.

With a folder and a format they are written there.
"""

from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

from shockpc.cli.options import RunOptions
from shockpc.cli.process import print_error
from shockpc.cli.progress import progress
from shockpc.evaluation.evaluate import Evaluation
from shockpc.evaluation.executor import executor
from shockpc.evaluation.table import Table
from shockpc.show.row_files import Format, RowFiles
from shockpc.text.errors import ShockError, StudyError


@contextmanager
def computed(
    evaluation: Evaluation[Any],
    noun: str,
    folder: Path | None,
    format_: Format | None,
    run: RunOptions,
) -> Iterator[Table]:
    """Compute the rows, before the block that uses them.

    If that fails, it says how to continue what was written.

    Args:
        evaluation: what is computed.
        noun: what is counted, such as "rows".
        folder: where the rows are written.
        format_: of the rows; without it, or without a folder, nothing is written.
        run: where the rows are computed, and whether the folder may hold parts of the same study.

    Raises:
        StudyError: an option of files without a folder, or of a cluster without one.
        OutputError: the folder holds rows of another run; as `RowFiles`.
    """
    if format_ is not None and folder is None:
        raise StudyError(f"--rows {format_} is the format of files, and needs a folder: --out DIR")
    if run.wait and run.cluster is None:
        raise StudyError(
            "--wait waits for the workers of a cluster; give its address with --cluster, or leave "
            "--wait out"
        )
    if run.jobs > 1 and run.cluster is not None:
        raise StudyError(
            f"--jobs {run.jobs} is for this machine, but a cluster computes; leave one of the two "
            "out"
        )
    rows_done, rows = 0, evaluation.landings.rows
    workers = executor(run.jobs, run.cluster, print_error if run.wait else None)
    if folder is None or format_ is None:
        if run.resume:
            raise StudyError("rows in parts need a folder and a format: --out DIR --rows parquet")
        if folder is not None:
            RowFiles(evaluation, folder, "parquet").refuse_present()
        with workers as pool:
            table = evaluation.computed_table(pool, progress(f"{noun} computed", rows))
        yield table
        return
    try:
        files = RowFiles(evaluation, folder, format_)
        with workers as pool:
            files.prepare(run.resume)
            with closing(files.write(pool)) as written:
                rows_done = next(written)
                advance = progress(f"{noun} computed", rows, rows_done)
                for count in written:
                    rows_done += count
                    advance(parts=count)
        yield files.table()
    except (ShockError, KeyboardInterrupt):
        if rows_done and format_ == "parquet":
            print_error(
                f"{rows_done} of {rows} rows are complete in {folder}; the same command with "
                f"--resume continues"
            )
        raise
