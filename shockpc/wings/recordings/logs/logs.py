"""Logs: time series of a robot's motion from tables and bags.

A table has a column of times; bags are those of ROS 1, ROS 2 and MCAP files.

What was sampled at different times is brought to the times of one clock, by straight lines between
neighbouring samples. Nothing is made up over a gap: there the samples are missing, and the log is
in several segments.
"""

import re
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.robot.robot import Robot
from shockpc.text.arguments import LARGEST_NUMBER
from shockpc.text.errors import StudyError
from shockpc.text.paths import usable_path
from shockpc.text.printed import listed, visible
from shockpc.wings.recordings.logs.bags import BAGS, QUATERNION, continuous, read_bag
from shockpc.wings.recordings.logs.clock import clock_column, rising_times
from shockpc.wings.recordings.logs.repeats import without_repeats
from shockpc.wings.recordings.tables.column_meaning import column_name, state_columns
from shockpc.wings.recordings.tables.table_files import columns_of, read_table

GAP = 5.0
"""Time between neighbouring samples, in median ones, from which it is a gap."""

COMPLETE = 0.8
"""Smallest share of samples with a velocity of the base at which the others are left out.

With fewer, the velocity is left out.
"""

SENSOR = re.compile(r"[aw][xyz]@.+")
"""Columns of an accelerometer or a gyro at a frame."""

PARTS = dict.fromkeys((*QUATERNION, "roll", "pitch", "yaw"), "attitude") | dict.fromkeys(
    "xyz", "position"
)
"""Part of the base that a column of positions is of."""


class Log(NamedTuple):
    """A time series on one clock.

    Attributes:
        start: time of the first sample [s].
        time: (n,) since then, rising [s].
        positions: columns (n,) or (n, k) of the joints and the base by the names of recorded
            tables, finite.
        rates: the same of their rates.
        sensors: (n,) of accelerometers and gyros, [aw][xyz]@FRAME; NaN where there is no sample
            [m/s², rad/s].
        others: all other columns.
        period: median time between samples of each column of positions, rates and sensors, as they
            were recorded [s].
        segment: (n,) number of the segment of each sample; between two of them the clock has a gap.
        remarks: what was left out or assumed.
    """

    start: float
    time: Array
    positions: Mapping[str, np.ndarray]
    rates: Mapping[str, np.ndarray]
    sensors: Mapping[str, np.ndarray]
    others: Mapping[str, np.ndarray]
    period: Mapping[str, float]
    segment: np.ndarray
    remarks: tuple[str, ...]


def read_log(
    source: Path | Mapping[str, np.ndarray],
    robot: Robot,
    rename: Mapping[str, str],
    topics: Sequence[str] = (),
) -> Log:
    """The time series of a file or a table, with the state of a robot.

    Args:
        source: a table with a column of times (CSV, Parquet, NPZ), a bag (.bag, .mcap, .db3, or the
            folder of one of ROS 2), or the columns of a table by name.
        robot: whose state it is.
        rename: other names for columns, as in `rows_of`.
        topics: the only topics of a bag that are read, if any are given.

    Raises:
        StudyError: it cannot be read, has no times or none that rise, or no state of the robot.
    """
    remarks: list[str] = []
    columns, is_bag = _columns_of_source(source, topics, remarks)
    positions, rates, not_state = state_columns(columns, robot, rename)
    clock = clock_column(columns, not_state)
    _refuse_no_state(robot, columns, positions)
    _refuse_lengths((positions, rates, not_state))
    start, time, rows = rising_times(clock, not_state.pop(clock), remarks)
    sensors = {name: not_state.pop(name) for name in tuple(not_state) if SENSOR.fullmatch(name)}
    if is_bag:
        sensors = _of_known_frames(sensors, robot, remarks)

    # Numbers of the samples whose time rises, each sensor without the repeats of its last sample.
    state = _State(*(_numeric_columns(part, rows) for part in (positions, rates, sensors)))
    remarks += without_repeats(_measured_together(robot, *state), time)
    state.rates.update(_gyro_of_base(robot, state.sensors, state.rates))
    state, period = _filled_state(state, time, remarks)

    # Samples with all that is needed.
    complete = _complete_samples(state, robot, len(time), remarks)
    _refuse_few_samples(state, period, int(complete.sum()))
    time = time[complete]
    rows = rows[complete]
    state = _without_broken_rates(state.rows(complete), remarks)
    # The number of gaps before each sample tells the parts between them apart.
    gaps = np.diff(time, prepend=time[0]) > GAP * np.median(np.diff(time))
    return Log(
        start=start + time[0],
        time=time - time[0],
        positions=state.positions,
        rates=state.rates,
        sensors=state.sensors,
        others={name: values[rows] for name, values in not_state.items()},
        period={name: period[name] for name in state.columns},
        segment=np.cumsum(gaps),
        remarks=tuple(remarks),
    )


def _numeric_columns(columns: Mapping[str, np.ndarray], rows: np.ndarray) -> dict[str, np.ndarray]:
    """Some rows of columns as numbers."""
    return {name: _numeric_column(name, values)[rows] for name, values in columns.items()}


class _State(NamedTuple):
    """Columns of a log by name: positions, rates, and accelerometers and gyros."""

    positions: dict[str, np.ndarray]
    rates: dict[str, np.ndarray]
    sensors: dict[str, np.ndarray]

    @property
    def columns(self) -> dict[str, np.ndarray]:
        """All of them."""
        return self.positions | self.rates | self.sensors

    def without(self, names: Container[str]) -> "_State":
        """The others."""
        parts = []
        for part in self:
            parts.append({name: values for name, values in part.items() if name not in names})
        return _State(*parts)

    def rows(self, chosen: np.ndarray) -> "_State":
        """Some of the samples. Args: chosen (n,) of bool."""
        parts = []
        for part in self:
            parts.append({name: values[chosen] for name, values in part.items()})
        return _State(*parts)


def _columns_of_source(
    source: Path | Mapping[str, np.ndarray], topics: Sequence[str], remarks: list[str]
) -> tuple[dict[str, np.ndarray], bool]:
    """The columns of a log, and whether it is a bag."""
    if isinstance(source, Path):
        path = usable_path(str(source))
        if path.suffix.casefold() in BAGS or path.is_dir():
            return read_bag(path, topics, remarks), True
    if topics:
        raise StudyError(f"topics are those of a bag; leave out {listed(topics)}")
    columns = read_table(path) if isinstance(source, Path) else columns_of(source)
    return columns, False


def _refuse_no_state(
    robot: Robot, columns: Mapping[str, np.ndarray], positions: Mapping[str, np.ndarray]
) -> None:
    """Refuse a log without positions of the robot."""
    if not positions:
        raise StudyError(
            f'this log has no positions of robot "{robot.name}": its columns are '
            f"{listed(columns, 12)}, and the robot's joints {listed(robot.joint_names, 12)}; give "
            f"columns new names with --map"
        )


def _refuse_lengths(parts: Iterable[Mapping[str, np.ndarray]]) -> None:
    """Refuse columns of several lengths."""
    lengths: set[int] = set()
    for part in parts:
        lengths.update(map(len, part.values()))
    if len(lengths) > 1:
        raise StudyError(
            "the columns of this log differ in length; each has to have a cell for every sample"
        )


def _of_known_frames(
    sensors: dict[str, np.ndarray], robot: Robot, remarks: list[str]
) -> dict[str, np.ndarray]:
    """The sensors at frames of the robot."""
    unknown = sorted({name[3:] for name in sensors if name[3:] not in robot.frames})
    if unknown:
        remarks.append(
            f"gyro and accelerometer at {listed(unknown)} are left out, because the robot has no "
            f"such frame"
        )
    return {name: values for name, values in sensors.items() if name[3:] not in unknown}


def _measured_together(
    robot: Robot,
    positions: dict[str, np.ndarray],
    rates: dict[str, np.ndarray],
    sensors: dict[str, np.ndarray],
) -> Iterator[tuple[str, dict[str, np.ndarray], list[str]]]:
    """The columns (n,) that one sensor measures, with its name and what they are in."""
    alike: dict[tuple[bool, str], list[str]] = {}
    for name, values in (positions | rates).items():
        column = column_name(name, robot)
        if values.ndim == 1 and column is not None:
            alike.setdefault(
                (name in positions, PARTS.get(column.base, column.base[:1])), []
            ).append(name)
    yield "the encoders of the joints", positions, alike.get((True, ""), [])
    yield "the attitude of the base", positions, alike.get((True, "attitude"), [])
    yield "the position of the base", positions, alike.get((True, "position"), [])
    yield "the velocity of the base", rates, alike.get((False, "v"), [])
    yield "the gyro", rates, alike.get((False, "w"), [])
    for kind, sensor in (("a", "accelerometer"), ("w", "gyro")):
        by_frame: dict[str, list[str]] = {}
        for name in sensors:
            if name[0] == kind:
                by_frame.setdefault(name[3:], []).append(name)
        for frame, names in by_frame.items():
            yield f'the {sensor} at "{visible(frame)}"', sensors, names


def _gyro_of_base(
    robot: Robot, sensors: Mapping[str, np.ndarray], rates: Mapping[str, np.ndarray]
) -> dict[str, np.ndarray]:
    """Columns of the angular velocity of a free base in its axes, by a gyro at a frame of it.

    There are none where the log has a rate of rotation of the base already, and of a fixed base.
    """
    of_base = set()
    for name in rates:
        column = column_name(name, robot)
        if column is not None:
            of_base.add(column.base)
    if not robot.free_base or of_base & {"wx", "wy", "wz"}:
        return {}
    for frame in sorted({name[3:] for name in sensors if name[0] == "w"}):
        names = [f"w{axis}@{frame}" for axis in "xyz"]
        if robot.frame(frame).body == 0 and sensors.keys() >= set(names):
            measured = np.stack([sensors[name] for name in names], axis=1)
            omega = measured @ robot.frame(frame).rotation.T
            return dict(zip(("wx_body", "wy_body", "wz_body"), omega.T, strict=True))
    return {}


def _known(values: np.ndarray) -> np.ndarray:
    """Mask (n,) of the samples of a column that have all of their numbers."""
    return np.asarray(np.isfinite(values).reshape(len(values), -1).all(axis=1))


def _period(time: Array, values: Array) -> float:
    """Median time between the samples of a column [s]; infinite if there are fewer than 3."""
    known_times = time[_known(values)]
    return float(np.median(np.diff(known_times))) if len(known_times) > 2 else np.inf


def _fill(time: Array, columns: dict[str, np.ndarray], period: Mapping[str, float]) -> None:
    """Fill what is missing between neighbouring samples of slower columns (n,).

    It is along straight lines, except over gaps.

    A quaternion and its opposite are one rotation: their signs are made continuous first, and their
    length 1 afterwards.
    """
    has_quaternion = all(name in columns and columns[name].ndim == 1 for name in QUATERNION)
    if has_quaternion:
        q = np.stack([columns[name] for name in QUATERNION], axis=1)
        known = np.isfinite(q).all(axis=1)
        q[known] = continuous(q[known])
        columns |= dict(zip(QUATERNION, q.T.copy(), strict=True))
    slow = [name for name, values in columns.items() if values.ndim == 1 and np.isnan(values).any()]
    for name in slow:
        columns[name] = _filled(time, columns[name], GAP * period[name])
    if has_quaternion and not set(slow).isdisjoint(QUATERNION):
        q = np.stack([columns[name] for name in QUATERNION])
        length = np.sqrt(sum(q**2))
        # Of a straight line between two quaternions; another length is that of the file, and an
        # error.
        q = q / np.where(length > 0.9, length, 1.0)
        columns |= dict(zip(QUATERNION, q, strict=True))


def _filled_state(
    state: _State, time: Array, remarks: list[str]
) -> tuple[_State, dict[str, float]]:
    """The state with slower columns filled, without those of few samples; and their periods [s]."""
    period = {name: _period(time, values) for name, values in state.columns.items()}
    empty = [name for name, between in period.items() if np.isinf(between)]
    if empty:
        remarks.append(f"fewer than 3 samples, left out: {listed(empty, 8)}")
        state = state.without(empty)
    for part in state:
        _fill(time, part, period)
    return state, period


def _without_broken_rates(state: _State, remarks: list[str]) -> _State:
    """The state without rates that have gaps.

    Rates are not needed, so that gaps leave out the rate and not the samples.
    """
    broken = [name for name, x in state.rates.items() if not _known(x).all()]
    if not broken:
        return state
    remarks.append(f"rates with gaps, left out: {listed(broken, 8)}")
    return state._replace(rates=state.without(broken).rates)


def _refuse_few_samples(state: _State, period: Mapping[str, float], count: int) -> None:
    """Refuse fewer than 3 complete samples, or none with a position."""
    if count >= 3 and state.positions:
        return
    empty = [name for name, between in period.items() if np.isinf(between)]
    raise StudyError(
        f"this log has {count if state.positions else 0} samples with a number for each of "
        f"{listed(state.positions or empty, 12)}; at least 3 are needed"
    )


def _filled(time: Array, values: Array, longest: float) -> Array:
    """A column (n,) along straight lines between its samples; NaN over more than `longest` [s]."""
    rows = np.arange(len(time))
    known = np.flatnonzero(np.isfinite(values))
    # Places among the known samples of the one at or after each row, and of that at or before it.
    after = np.clip(np.searchsorted(known, rows), 0, len(known) - 1)
    before = np.maximum(after - (known[after] != rows), 0)
    apart = time[known[after]] - time[known[before]]
    lines = np.interp(time, time[known], values[known], left=np.nan, right=np.nan)
    return np.where(apart <= longest, lines, np.nan)


def _numeric_column(name: str, values: np.ndarray) -> Array:
    """A column as numbers, in which NaN means that there is no sample.

    Raises:
        StudyError: it has texts, or numbers beyond `LARGEST_NUMBER`.
    """
    if values.dtype.kind not in "fiub":
        first = next((text for text in values.ravel().tolist() if str(text).strip()), "")
        raise StudyError(
            f'column {name} has to hold numbers, and holds "{visible(str(first))[:40]}"'
        )
    numbers = values.astype(float)
    if (far := np.abs(numbers) > LARGEST_NUMBER).any():
        row = int(np.argmax(far.reshape(len(numbers), -1).any(axis=1)))
        number = np.abs(numbers[row]).max()
        raise StudyError(
            f"column {name} is {number:g} in row {row}, beyond {LARGEST_NUMBER:g}; leave the cell "
            f"empty where there is no sample"
        )
    return numbers


def _complete_samples(state: _State, robot: Robot, n: int, remarks: list[str]) -> np.ndarray:
    """Mask of n samples: they have all positions, and the rates of the base that most have."""
    needed = dict(state.positions)
    for name, x in state.rates.items():
        column = column_name(name, robot)
        if column is not None and column.base and _known(x).mean() >= COMPLETE:
            needed[name] = x
    complete = np.ones(n, dtype=bool)
    lacking = []
    for name, x in needed.items():
        known = _known(x)
        if not known.all():
            lacking.append(name)
            complete &= known
    if lacking:
        remarks.append(
            f"{np.sum(~complete)} of {n} samples are left out, with no number near them in "
            f"{listed(lacking, 6)}"
        )
    return complete
