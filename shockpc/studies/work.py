"""Work in parts through `concurrent.futures.Executor`: in this process, in local processes, or on a cluster."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor, Future
from concurrent.futures.process import BrokenProcessPool
from typing import Any, TypeVar

from shockpc.errors import StudyError

__all__ = ["InProcess", "in_order"]

T = TypeVar("T")


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


def in_order(executor: Executor, function: Callable[[int], T], parts: Iterable[int], ahead: int) -> Iterator[T]:
    """Yield the results of parts in their order, while later ones are computed.

    Args:
        executor: does the work.
        function: of the part's number; it can be pickled.
        parts: numbers.
        ahead: number of parts that are submitted before the first one has been read; it limits the memory for results.

    Raises:
        StudyError: a worker process died.
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
