"""A study whose rows are written in parts, with progress; what was interrupted says how it continues."""

from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import AbstractContextManager, contextmanager

from shockpc.cli.process import print_error
from shockpc.cli.progress import progress
from shockpc.show.parts import Parts


@contextmanager
def written_parts(parts: Parts, executor: AbstractContextManager[Executor | None], resume: bool, noun: str) -> Iterator[None]:
    """Compute and write the parts that are missing, before the block that reads them; after a failure, say how to continue.

    Args:
        parts: of the study.
        executor: computes them.
        resume: whether the folder may hold parts of the same study.
        noun: what is counted, such as "rows".
    """
    done, rows = 0, parts.evaluation.landings.rows
    try:
        with executor as workers:
            parts.prepare(resume)
            written = parts.write(workers)
            done = next(written)
            advance = progress(f"{noun} computed", rows, done)
            for count in written:
                done += count
                advance(parts=count)
        yield
    except BaseException:
        if done:
            print_error(f"{done} of {rows} rows are complete in {parts.folder}; the same command with --resume continues")
        raise
