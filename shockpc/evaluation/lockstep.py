"""Runs that ask for values at points, side by side: what all of them ask for is computed together.

A library's optimiser asks for one point at a time, and many rows cost an engine over arrays little more than one. So each run has a
thread, which waits for its answer until every other run waits too or has ended; what is computed together does not depend on which
thread is the first.
"""

import contextlib
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from typing import Any, TypeVar

import numpy as np

from shockpc.core.spatial import Array

T = TypeVar("T")

POLLED = 0.5
"""Time after which one that waits looks whether the runs have been stopped [s]."""


def in_lockstep(runs: Sequence[Callable[[Callable[[Array], Any]], T]], compute: Callable[[Array], Sequence[Any]]) -> list[T]:
    """What runs return.

    Args:
        runs: each takes a function that answers for one point (n,).
        compute: gives for points (m, n) as many answers.

    Raises:
        BaseException: what a run or the computation raised, or an interruption, after all runs have ended.
    """
    asked, ended, stopped = dict[int, tuple[Array, Future[Any]]](), list[int](), list[bool]()
    changed = threading.Event()

    def start(k: int) -> T:
        def ask(point: Array) -> Any:
            answer = Future[Any]()
            asked[k] = point, answer
            changed.set()
            while not stopped:
                with contextlib.suppress(TimeoutError):
                    return answer.result(POLLED)
            raise CancelledError

        try:
            return runs[k](ask)
        finally:
            ended.append(k)
            changed.set()

    with ThreadPoolExecutor(max(len(runs), 1)) as threads:
        try:
            results = [threads.submit(start, k) for k in range(len(runs))]
            while len(ended) < len(runs):
                changed.wait(POLLED)
                changed.clear()
                if 0 < len(asked) == len(runs) - len(ended):
                    points, answers = zip(*(asked[k] for k in sorted(asked)), strict=True)
                    asked.clear()
                    for answer, found in zip(answers, compute(np.array(points)), strict=True):
                        answer.set_result(found)
            return [result.result() for result in results]
        finally:
            stopped.append(True)  # after an error, or an interruption, no run waits any longer
