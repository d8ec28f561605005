"""Runs that ask for values at points, side by side: what all of them ask for is computed together.

A library's optimiser asks for one point at a time, and many rows cost an engine over arrays little
more than one. So each run has a thread, which waits for its answer until every other run waits too
or has ended; what is computed together does not depend on which thread is the first.

Threads and what asks for them exchange messages only through `queue.SimpleQueue`, and are started
by `_thread`. An interruption (Ctrl-C) may come after any call of Python code: inside
`threading.Event`, `Future` or `Thread.start`, which are written in Python, it can leave a lock
acquired, for which the threads then wait for ever.
"""

import _thread
from collections.abc import Callable, Sequence
from concurrent.futures import CancelledError
from queue import SimpleQueue
from typing import Any, TypeVar

import numpy as np

from shockpc.core.spatial import Array

T = TypeVar("T")


def in_lockstep(
    runs: Sequence[Callable[[Callable[[Array], Any]], T]], compute: Callable[[Array], Sequence[Any]]
) -> list[T]:
    """The results of the runs, in their order.

    Args:
        runs: each takes a function that answers for one point (n,).
        compute: gives for points (m, n) as many answers.

    Raises:
        BaseException: what a run or the computation raised, or an interruption; the other runs end
            when they ask next.
    """
    results = dict[int, T]()
    errors = dict[int, BaseException]()
    # Runs send (number, point), or (number, None) when they end.
    messages = SimpleQueue[tuple[int, Array | None]]()
    answers = [SimpleQueue[Any]() for _ in runs]

    def start(k: int) -> None:
        def ask(point: Array) -> Any:
            messages.put((k, point))
            answer = answers[k].get()
            if isinstance(answer, CancelledError):
                raise answer
            return answer

        try:
            results[k] = runs[k](ask)
        except BaseException as error:
            errors[k] = error
        messages.put((k, None))

    try:
        for k in range(len(runs)):
            _thread.start_new_thread(start, (k,))
        asking = len(runs)
        while asking:
            # Every run that has not ended asks once, or ends.
            points = dict[int, Array]()
            for _ in range(asking):
                k, point = messages.get()
                if point is not None:
                    points[k] = point
            if errors:
                raise errors[min(errors)]
            asking = len(points)
            if asking:
                numbers = sorted(points)
                computed = compute(np.array([points[k] for k in numbers]))
                for k, answer in zip(numbers, computed, strict=True):
                    answers[k].put(answer)
    finally:
        for queue in answers:
            queue.put(CancelledError())
    return [results[k] for k in range(len(runs))]
