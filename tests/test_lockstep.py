"""Runs in lockstep: each gets its own answers, what they ask for is computed together, and errors
end all of them.
"""

import subprocess
import sys

import numpy as np
import pytest

from shockpc.studies.improve.lockstep import in_lockstep


def halving(start, steps):
    """A run that asks for its point, takes the answer for the next one, and returns the last."""

    def run(ask):
        x = np.array([start])
        for _ in range(steps):
            x = ask(x)
        return float(x[0])

    return run


def test_runs_get_their_own_answers_together():
    sizes = []

    def half(X):
        sizes.append(len(X))
        return X / 2.0

    lengths = [3, 0, 7, 5, 7]
    found = in_lockstep([halving(2.0**k, n) for k, n in enumerate(lengths)], half)
    assert found == [2.0 ** (k - n) for k, n in enumerate(lengths)]
    assert sizes == [sum(n > step for n in lengths) for step in range(max(lengths))]
    assert in_lockstep([], half) == []


def test_points_are_in_the_order_of_the_runs():
    seen = []

    def same(X):
        seen.append(X[:, 0].tolist())
        return X

    in_lockstep([halving(float(k), 4) for k in range(9)], same)
    assert seen == [[float(k) for k in range(9)]] * 4


@pytest.mark.parametrize("error", [ValueError("no"), KeyboardInterrupt()])
def test_errors_end_all_runs(error):
    def fails(X):
        if X[0, 0] < 1.0:
            raise error
        return X / 2.0

    with pytest.raises(type(error)):
        in_lockstep([halving(4.0, 10), halving(64.0, 3)], fails)

    def broken(ask):
        ask(np.array([1.0]))
        raise error

    with pytest.raises(type(error)):
        in_lockstep([broken, halving(64.0, 3)], lambda X: X)


INTERRUPTED = """
import random, signal
import numpy as np
from shockpc.studies.improve.lockstep import in_lockstep

def run(ask):
    x = np.array([1.0])
    for _ in range(10_000):
        x = ask(x)

def stop(number, frame):
    raise KeyboardInterrupt

signal.signal(signal.SIGALRM, stop)
interrupted = 0
for k in range(400):
    try:
        signal.setitimer(signal.ITIMER_REAL, random.Random(k).uniform(2e-5, 4e-3))  # while threads start, and later
        in_lockstep([run] * 8, lambda X: X)
    except KeyboardInterrupt:
        interrupted += 1
print(interrupted)
"""


def test_an_interruption_ends_all_runs_whenever_it_comes():
    done = subprocess.run(
        [sys.executable, "-c", INTERRUPTED], capture_output=True, text=True, timeout=60, check=False
    )
    assert done.stdout == "400\n", done.stderr
