"""Executors: the same results wherever they are computed, and one message when a process dies."""

import os
import time

import pytest

from shockpc.errors import StudyError
from shockpc.executor import executor, in_order


def square(x):
    return x * x


def die(_):
    os._exit(1)


@pytest.mark.parametrize("jobs", [1, 2])
def test_results_are_the_same_wherever_they_are_computed(jobs):
    with executor(jobs) as pool:
        assert list(in_order(pool, square, range(9), ahead=3)) == [k * k for k in range(9)]


def test_one_process_computes_what_is_taken_and_no_more():
    seen = []
    results = in_order(None, seen.append, range(5))
    next(results)
    assert seen == [0]


def test_death_of_a_process_is_one_message():
    with pytest.raises(StudyError, match="--jobs 1"), executor(2) as pool:
        list(pool.map(die, range(2)))


def interrupted():
    """What a Ctrl-C does to a study whose processes have a minute's work each."""
    with executor(2) as pool:
        for _ in range(4):
            pool.submit(time.sleep, 60.0)
        raise KeyboardInterrupt


def test_interrupt_ends_what_still_runs():
    start = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert time.monotonic() - start < 30.0
