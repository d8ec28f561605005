"""Where the parts of a study are computed: in this process, or in several on this machine. Studies know the interface alone."""

import multiprocessing
import signal
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from typing import Any, TypeVar

from shockpc.errors import StudyError

__all__ = ["InProcess", "executor"]

T = TypeVar("T")


class InProcess(Executor):
    """Computes in this process: with `submit` at once, with `map` one by one as the results are taken."""

    def submit(self, fn: Callable[..., T], /, *args: Any, **kwargs: Any) -> Future[T]:
        """Compute now. An error is raised here, not kept."""
        future: Future[T] = Future()
        future.set_result(fn(*args, **kwargs))
        return future

    def map(self, fn: Callable[..., T], *iterables: Any, timeout: float | None = None, chunksize: int = 1) -> Iterator[T]:
        """Compute each when it is taken."""
        del timeout, chunksize
        return map(fn, *iterables)


@contextmanager
def executor(jobs: int) -> Iterator[Executor]:
    """An executor of so many processes; of this one alone for 1. When it is left by an error, what still runs is ended.

    Raises:
        StudyError: a process died.
    """
    if jobs == 1:
        yield InProcess()
        return
    # Forked processes have the libraries loaded already, which saves each of them half a second.
    context = multiprocessing.get_context("fork") if sys.platform == "linux" else None
    with ProcessPoolExecutor(jobs, context, _prepare_worker) as pool:
        try:
            yield pool
        except BrokenProcessPool:
            raise StudyError(
                "a worker process died, perhaps because the memory was used up; try again with fewer processes: --jobs 1"
            ) from None
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            for child in multiprocessing.active_children():
                child.terminate()
            raise


def _prepare_worker() -> None:
    """Leave Ctrl-C to the first process, which ends this one."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
