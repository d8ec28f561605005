"""Samples that a log repeats, because a sensor has new ones more rarely."""

from collections.abc import Iterable, Iterator, MutableMapping, Sequence
from typing import TypeAlias

import numpy as np

from shockpc.core.spatial import Array

FEWEST_NEW, REGULAR = 20, 0.8
"""Fewest new values of a pattern, and the share of them that have to be repeated alike.

A coarse encoder, or a robot at rest, repeats values irregularly.
"""

Columns: TypeAlias = MutableMapping[str, Array]


def repetitions(values: Array) -> int:
    """Number of times that every sample is there, 1 if samples are not repeated regularly.

    Args: values (n, k), finite.
    """
    new = np.flatnonzero((np.diff(values, axis=0) != 0.0).any(axis=1))
    lengths = np.diff(new)
    if len(lengths) < FEWEST_NEW:
        return 1
    usual = int(np.median(lengths))
    return usual if usual > 1 and np.mean(lengths == usual) >= REGULAR else 1


def without_repeats(
    groups: Iterable[tuple[str, Columns, Sequence[str]]], time: Array
) -> Iterator[str]:
    """Replace repeated samples by NaN, and say so.

    Args:
        groups: what a sensor measures: its name for the remark, the columns, and which of them (n,)
            have its numbers.
        time: (n,) of the samples [s].
    """
    for sensor, columns, names in groups:
        if not names:
            continue
        values = np.stack([columns[name] for name in names], axis=1)
        known = np.flatnonzero(np.isfinite(values).all(axis=1))
        times = repetitions(values[known]) if len(known) else 1
        if times == 1:
            continue
        repeated = known[1:][(np.diff(values[known], axis=0) == 0.0).all(axis=1)]
        repeated = repeated[repeated < known[-1]]  # nothing is made up behind the last sample
        for name in names:
            columns[name] = columns[name].copy()
            columns[name][repeated] = np.nan
        rate = 1.0 / float(np.median(np.diff(time[known])))
        yield (
            f"each sample of {sensor} is there {times} times: a new one comes {rate / times:.0f} "
            f"times a second in {rate:.0f} "
            "samples, and the others are left out"
        )
