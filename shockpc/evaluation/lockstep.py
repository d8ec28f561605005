"""Runs that ask for values at points, side by side: what all of them ask for is computed together.

A library's optimiser asks for one point at a time, and many rows cost an engine over arrays little more than one. So each run has a
thread, which waits for its answer until every other run waits too or has ended; what is computed together does not depend on which
thread is the first.
"""

import queue
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any, TypeVar

import numpy as np

from shockpc.core.spatial import Array

T = TypeVar("T")


def in_lockstep(runs: Sequence[Callable[[Callable[[Array], Any]], T]], compute: Callable[[Array], Sequence[Any]]) -> list[T]:
    """What runs return.

    Args:
        runs: each takes a function that answers for one point (n,).
        compute: gives for points (m, n) as many answers.

    Raises:
        BaseException: what a run or the computation raised, after all runs have ended.
    """
    asked: queue.SimpleQueue[tuple[int, Array, Future[Any]] | None] = queue.SimpleQueue()
    waiting, error = dict[int, tuple[Array, Future[Any]]](), None

    def asking(run: int) -> Callable[[Array], Any]:
        def ask(point: Array) -> Any:
            answer = Future[Any]()
            asked.put((run, point, answer))
            return answer.result()

        return ask

    with ThreadPoolExecutor(max(len(runs), 1)) as threads:
        results = [threads.submit(run, asking(k)) for k, run in enumerate(runs)]
        for result in results:
            result.add_done_callback(lambda _: asked.put(None))
        active = len(runs)
        while active:
            try:
                if (one := asked.get()) is None:
                    active -= 1
                else:
                    waiting[one[0]] = one[1:]
                if error is None and 0 < len(waiting) == active:
                    points, answers = zip(*(waiting[k] for k in sorted(waiting)), strict=True)
                    for answer, found in zip(answers, compute(np.array(points)), strict=True):
                        answer.set_result(found)
                    waiting.clear()
            except BaseException as raised:  # an interruption too: no thread may wait for ever
                error = raised
            if error is not None:
                for _, answer in waiting.values():
                    answer.set_exception(error)
                waiting.clear()
    if error is not None:
        raise error
    return [result.result() for result in results]
