"""Runs that ask for values at points, side by side: what all of them ask for is computed together.

A library's optimiser asks for one point at a time, and many rows cost an engine over arrays little more than one. So each run has a
thread, which waits for its answer until every other run waits too or has ended; what is computed together does not depend on which
thread is the first.

Threads and what asks for them exchange messages through `queue.SimpleQueue` alone, and are started by `_thread`. An interruption
(Ctrl-C) may come after any call of Python code: inside `threading.Event`, `Future` or `Thread.start`, which are written in Python,
it can leave a lock acquired, for which the threads then wait for ever.
"""

import _thread
import contextlib
from collections.abc import Callable, Sequence
from concurrent.futures import CancelledError
from queue import Empty, SimpleQueue
from typing import Any, TypeVar

import numpy as np

from shockpc.core.spatial import Array

T = TypeVar("T")

POLLED = 0.5
"""Time after which the state of the runs is looked at again, should an interruption have taken a message [s]."""

STOPPED = object()
"""The answer that ends a run."""


def in_lockstep(runs: Sequence[Callable[[Callable[[Array], Any]], T]], compute: Callable[[Array], Sequence[Any]]) -> list[T]:
    """What runs return.

    Args:
        runs: each takes a function that answers for one point (n,).
        compute: gives for points (m, n) as many answers.

    Raises:
        BaseException: what a run or the computation raised, or an interruption, after all runs have ended.
    """
    asked, results, errors = dict[int, Array](), dict[int, T](), dict[int, BaseException]()
    started, ended = list[int](), list[int]()
    answers = [SimpleQueue[Any]() for _ in runs]
    changed = SimpleQueue[None]()

    def start(k: int) -> None:
        def ask(point: Array) -> Any:
            asked[k] = point
            changed.put(None)
            if (answer := answers[k].get()) is STOPPED:
                raise CancelledError
            return answer

        try:
            results[k] = runs[k](ask)
        except CancelledError:
            pass
        except BaseException as error:
            errors[k] = error
        ended.append(k)
        changed.put(None)

    def wait() -> None:
        with contextlib.suppress(Empty):
            changed.get(timeout=POLLED)

    try:
        for k in range(len(runs)):
            _thread.start_new_thread(start, (k,))
            started.append(k)
        while len(ended) < len(runs) and not errors:
            wait()
            if 0 < len(asked) == len(runs) - len(ended):
                points = dict(sorted(asked.items()))
                asked.clear()
                for k, answer in zip(points, compute(np.array(list(points.values()))), strict=True):
                    answers[k].put(answer)
    finally:
        for queue in answers:
            queue.put(STOPPED)
        while len(ended) < len(started):
            wait()
    for k in sorted(errors):
        raise errors[k]
    return [results[k] for k in range(len(runs))]
