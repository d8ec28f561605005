"""The clock of a log: which column has the times, in what unit, and which samples have a time."""

import re
from collections.abc import Mapping

import numpy as np

from shockpc.core.spatial import Array
from shockpc.text.errors import StudyError
from shockpc.text.printed import listed
from shockpc.wings.recordings.tables.column_meaning import LABELS

SLOWEST, FASTEST = 20.0, 1e6
"""Rates below and above which times are taken for those of another unit [Hz]."""

SAME_TIME = 1e-9
"""Time between samples up to which they have the same time, and only the first is kept [s]."""

CLOCK = re.compile(rf"({'|'.join(LABELS['time'])})(?:_(s|ms|us|ns))?")
UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
EPOCH = 1e8
"""Seconds since 1970 above which a time without a unit is a date.

It is in s, or a thousand, a million or a milliard times that.
"""


def clock_column(columns: Mapping[str, np.ndarray], not_state: Mapping[str, np.ndarray]) -> str:
    """The name of the column of times."""
    clocks = [name for name in not_state if CLOCK.fullmatch(name)]
    if not clocks:
        raise StudyError(
            f"a log has a column of times, called {listed(LABELS['time'])}, with the unit after it "
            f"if it is not s, such as time_ms; this one has {listed(columns, 12)}; give it a new "
            f"name with --map NAME=time"
        )
    return min(clocks, key=_preference)


def _preference(name: str) -> int:
    match = CLOCK.fullmatch(name)
    assert match is not None
    return LABELS["time"].index(match[1])


def rising_times(
    name: str, values: np.ndarray, remarks: list[str]
) -> tuple[float, Array, np.ndarray]:
    """The first time, the times since then of the samples that are kept [s], and their rows.

    Raises:
        StudyError: they are no times, run back, are too few, or too far apart for the motion of a
            leg.
    """
    clock = CLOCK.fullmatch(name)
    unit = clock[2] if clock else None
    if values.ndim != 1 or values.dtype.kind not in "fiuM":
        raise StudyError(
            f"column {name} has to hold times, and is {values.dtype} of shape {values.shape}"
        )
    missing = np.isnat(values) if values.dtype.kind == "M" else ~np.isfinite(values.astype(float))
    known = np.flatnonzero(~missing)
    if len(known) < 2:
        raise StudyError(f"column {name} has {len(known)} times; a log has many")
    times = values[known]
    if times.dtype.kind == "M":
        times, unit = times.astype("datetime64[ns]").astype(np.int64), "ns"
    first = times[0]
    # Without a unit in the column's name the size of the first time tells it.
    if unit is None:
        unit = _likely_unit(float(first))
    start = float(first) * UNITS[unit]
    # The difference first: nanoseconds since 1970 have more digits than a double.
    time = (times - first).astype(float) * UNITS[unit]
    steps = np.diff(time)
    if (steps < 0.0).any():
        row = int(np.argmax(steps < 0.0)) + 1
        raise StudyError(
            f"the time runs back in row {known[row]}, by {-steps[row - 1]:.3g} s; a log has one "
            "clock, so sort its rows, or give the recordings separately"
        )
    distinct = np.concatenate([[True], steps > SAME_TIME])
    for count, cause in (
        (int(missing.sum()), "no time"),
        (int((~distinct).sum()), "the time of the sample before them"),
    ):
        if count:
            remarks.append(f"{count} of {len(values)} samples have {cause}, and are left out")
    if not (steps > 0.0).any():
        raise StudyError(f"all samples of column {name} have one time; a log has many")
    # In a wrong unit all steps may be so short that they count as one time.
    rises = distinct[1:] if distinct[1:].any() else steps > 0.0
    _refuse_period(name, float(np.median(steps[rises])))
    return start, time[distinct], known[distinct]


def _likely_unit(first: float) -> str:
    """The largest unit in which a first time is below 1e11 s; nanoseconds if there is none."""
    for unit, size in zip(UNITS, (1.0, 1e3, 1e6, 1e9), strict=True):
        if first < 1e3 * EPOCH * size:
            return unit
    return "ns"


def _refuse_period(name: str, period: float) -> None:
    """Refuse a median time between samples [s] in which the motion of a leg is not seen."""
    if 1.0 / FASTEST <= period <= 1.0 / SLOWEST:
        return
    distance = "near" if period < 1.0 / FASTEST else "far"
    raise StudyError(
        f"the samples are {period:.3g} s apart, too {distance} for the motion of a leg; if "
        f"column {name} is not in seconds, name it {name}_ms, {name}_us or {name}_ns"
    )
