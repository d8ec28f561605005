"""Work in parts through `concurrent.futures.Executor`: in this process, in local processes, or on a cluster."""

import multiprocessing
import signal
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import CancelledError, Executor, Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from typing import Any, TypeVar

from shockpc.errors import StudyError

__all__ = ["InProcess", "executor_for", "in_order"]

T = TypeVar("T")

PATIENCE = "10s"
"""How long to wait for a cluster's scheduler."""


class InProcess(Executor):
    """An executor that computes where and when a part is submitted."""

    def submit(self, fn: Callable[..., T], /, *args: Any, **kwargs: Any) -> "Future[T]":
        """Compute now; errors are kept for whoever asks for the result."""
        future: Future[T] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future


@contextmanager
def executor_for(jobs: int = 1, cluster: str | None = None) -> Iterator[Executor]:
    """The executor that a command asks for.

    Args:
        jobs: number of local processes; with 1 everything is computed in this one.
        cluster: address of the scheduler of a Dask cluster, such as tcp://host:8786.

    Raises:
        StudyError: the cluster cannot be reached or `distributed` is not installed; or, from inside, workers died.
    """
    if cluster is not None:
        with _dask(cluster) as executor:
            yield executor
    elif jobs == 1:
        yield InProcess()
    else:
        pool = ProcessPoolExecutor(
            jobs, mp_context=multiprocessing.get_context("spawn"), initializer=_leave_interrupts_to_the_parent
        )
        try:
            yield pool
        except BrokenProcessPool:
            text = "a worker process ended before its part was computed, perhaps for lack of memory; use fewer --jobs"
            raise StudyError(text) from None
        except BaseException:
            # What they compute would be thrown away.
            for process in multiprocessing.active_children():
                process.terminate()
            raise
        finally:
            pool.shutdown(cancel_futures=True)


@contextmanager
def _dask(address: str) -> Iterator[Executor]:
    """The executor of a running Dask cluster."""
    try:
        from distributed import Client, KilledWorker
    except ImportError:
        raise StudyError('a cluster needs the package "distributed"; install it with: pip install "shockpc[cluster]"') from None
    try:
        client = Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError) as refusal:
        text = f'no cluster answers at "{address}" ({" ".join(str(refusal).split())}); start one with: dask scheduler'
        raise StudyError(text) from None
    try:
        yield client.get_executor(pure=False)
    except KilledWorker as death:
        raise StudyError(f"several workers of the cluster died over one part: {death}; give them more memory") from None
    except CancelledError:
        raise StudyError(f'the cluster at "{address}" went away; start it again') from None
    finally:
        client.close(timeout=1)


def _leave_interrupts_to_the_parent() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def in_order(executor: Executor, function: Callable[[int], T], parts: Iterable[int], ahead: int) -> Iterator[T]:
    """Yield the results of parts in their order, while later ones are computed.

    Args:
        executor: does the work.
        function: of the part's number; it can be pickled.
        parts: numbers.
        ahead: number of parts that are submitted before the first one has been read; it limits the memory for results.
    """
    waiting: deque[Future[T]] = deque()
    try:
        for part in parts:
            waiting.append(executor.submit(function, part))
            if len(waiting) > ahead:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()
    except BrokenProcessPool:
        raise StudyError(
            "a worker process ended before its part was computed, perhaps for lack of memory; use fewer --jobs"
        ) from None
    finally:
        for future in waiting:
            future.cancel()
