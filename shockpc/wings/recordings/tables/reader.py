"""Read a table of recorded landings, in which a row is a touchdown.

`column_meaning` says what its columns are called.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from shockpc.core.spatial import Array
from shockpc.landing.contact import first_contact, landing_frames
from shockpc.landing.landing import PosedLanding
from shockpc.landing.resolve import landing_of
from shockpc.landing.scenes.scene import Contact, Scene
from shockpc.landing.scenes.scene_file import robot_of
from shockpc.method.approach import Motion
from shockpc.robot.robot import Robot
from shockpc.text.errors import StudyError
from shockpc.text.printed import listed
from shockpc.wings.recordings.tables.cells import RowMessages, empty_cells
from shockpc.wings.recordings.tables.column_meaning import FRICTION, LABELS, named_columns
from shockpc.wings.recordings.tables.row_scenes import recorded_scenes, row_friction
from shockpc.wings.recordings.tables.rows import Measured, RecordedRows, contacts_of
from shockpc.wings.recordings.tables.state import (
    ANGLES,
    TWIST,
    MeasuredColumn,
    RobotColumns,
    configurations,
    motions,
    read_columns,
)

SERIES_ROWS, SERIES_RATIO = 100, 0.1
"""Fewest rows of a time series, and its largest ratio of von Neumann (1941).

A table with times and no names is taken for a series by these. The ratio is the mean squared
difference of successive values over twice their variance, of the median column. It is 1 where rows
are independent, and 2 sin²(π f / f_s) for a motion at a frequency f that is sampled at f_s.
"""


SAMPLES, SAMPLE_STEP = 3, 20e-3
"""Fewest rows without names and contacts that are samples, and their largest time step [s].

The step is the median one of rising times: a foot does not land again so soon.
"""


def rows_of(
    columns: Mapping[str, np.ndarray],
    landing: PosedLanding,
    rename: Mapping[str, str] | None = None,
) -> RecordedRows:
    """The rows of a table for a robot.

    Args:
        columns: by name, as `read_table` gives them.
        landing: gives what the table does not.
        rename: other names for columns or joints of the table; those that become empty are left
            out. Names may be globs with one *, which stands for the same text in the new name.

    Raises:
        UnknownName: a column names no joint of the robot; the text names the nearest.
        StudyError: the rows are samples of a time series; or no row is a landing: the text has the
            reason of the first one, with its number, from 0, and its name. Of a row beside others
            the reason is its message: a cell is empty or no finite number, a quaternion's length is
            not 1.
    """
    columns = named_columns(columns, rename or {})
    if _is_series(columns, landing.robot):
        rows = max(map(len, columns.values()))
        raise StudyError(
            f"the {rows} rows look like samples of a time series, but a table of landings has one "
            "row for each touchdown. Write that table with shockpc touchdowns LOG ROBOT --out "
            'DIR, or give the rows names in a column "name" if each sample is a landing'
        )
    try:
        return _rows(landing, columns)
    except StudyError as refusal:
        if not refusal.rows or "name" not in columns:
            raise
        name = _names(columns, landing.robot, len(columns["name"]))[refusal.rows[0]]
        raise StudyError(f'landing "{name}", {refusal}', **refusal.data) from None


def robot_of_table(columns: Mapping[str, np.ndarray], scene: Scene) -> Robot:
    """The robot of a scene, with the geoms that strike in rows of a table.

    These count where the scene has no contact.

    Raises:
        ShockError: as for `robot_of`.
    """
    if scene.contact:
        return robot_of(scene, [])
    cells = dict.fromkeys(map(str, np.ravel(columns.get("contact", ())).tolist()))
    names: list[str] = []
    for text in cells:
        for name in (text, *text.split("+")):
            if name.strip():
                names.append(name.strip())
    return robot_of(scene, names)


def rows_of_table(
    columns: Mapping[str, np.ndarray],
    scene: Scene,
    robot: Robot,
    rename: Mapping[str, str] | None = None,
) -> RecordedRows:
    """The rows of a table, as `rows_of` gives them.

    The scene gives what the table does not.

    Where the scene has no contact, every row has to have its own: one without any is refused, and
    has not those of another.
    """
    columns = named_columns(columns, rename or {})
    if not scene.contact and "contact" in columns:
        texts = np.where(empty_cells(columns["contact"]), " ", columns["contact"].astype(str))
        text, columns = first_contact(robot, texts.ravel().tolist()), {**columns, "contact": texts}
        frames = landing_frames(robot, text)[0] if text else ()
        scene = replace(scene, contact=tuple(Contact(frame=frame) for frame in frames))
    return rows_of(columns, landing_of(scene, robot))


def _is_series(columns: Mapping[str, np.ndarray], robot: Robot) -> bool:
    """True if rows are samples of one motion, most of which are no touchdowns.

    Their times are those of samples, or they change little from one to the next.
    """
    times = _label(columns, robot, "time")
    if times is None or _label(columns, robot, "row") is not None:
        return False
    is_landing = "contact" in columns or any(name.startswith("after") for name in columns)
    if not is_landing and _sampled(times):
        return True
    ratios: list[float] = []
    for name, values in columns.items():
        if name not in LABELS["time"] and values.dtype.kind in "fiu":
            ratios += _neumann_ratios(values.reshape(len(values), -1).astype(float))
    return bool(ratios) and bool(np.median(ratios) < SERIES_RATIO)


def _sampled(times: np.ndarray) -> bool:
    """True if times (n,) [s] rise by steps in which no foot lands again."""
    if times.dtype.kind not in "fiu" or times.ndim != 1 or len(times) < SAMPLES:
        return False
    steps = np.diff(times.astype(float))
    return bool((steps > 0.0).all()) and bool(np.median(steps) <= SAMPLE_STEP)


def _neumann_ratios(values: Array) -> list[float]:
    """The ratios of `SERIES_RATIO` of columns (n, k) that vary, by the rows that are known."""
    known = values[np.isfinite(values).all(axis=1)]
    if len(known) < SERIES_ROWS:
        return []
    known = known[:, np.ptp(known, axis=0) > 1e-9]
    differences = np.mean(np.diff(known, axis=0) ** 2, axis=0)
    ratios: list[float] = (differences / (2.0 * np.var(known, axis=0))).tolist()
    return ratios


def _rows(landing: PosedLanding, columns: Mapping[str, np.ndarray]) -> RecordedRows:
    """The rows of named columns. The arguments and errors are those of `rows_of`."""
    robot = landing.robot
    n = _length(columns)
    messages = RowMessages()
    read = read_columns(columns, robot, messages)
    if read.base and not robot.free_base:
        raise StudyError(
            f'the base of robot "{robot.name}" is fixed in its file; leave out {listed(read.base)}'
        )
    Q = configurations(landing, read, n, messages)
    friction = row_friction(landing, columns, n, messages)
    before = motions(landing, read, Q)
    of_rows = recorded_scenes(landing, columns, read.contact_velocities, friction, messages)
    # A table of which every row is refused is an error.
    if len(messages) == n:
        mark = "," if messages[0].startswith("column") else ":"
        raise StudyError(f"row 0{mark} {messages[0]}", rows=list(range(n)))
    joints, rates = read.given(robot)
    origins = dict(_origins(landing, columns, read))
    labels = {
        "name": _names(columns, robot, n),
        "contact": contacts_of(of_rows.scenes, of_rows.scene),
    }
    return RecordedRows(
        labels=labels | _times(columns, robot),
        Q=Q,
        before=before,
        scenes=of_rows.scenes,
        scene=of_rows.scene,
        contact_velocity=of_rows.velocities,
        friction=friction,
        effort=_efforts(read, robot, n),
        joints=joints,
        rates=rates,
        given=tuple(part for part, in_table in origins.items() if in_table),
        missing=tuple(part for part, in_table in origins.items() if not in_table),
        measured=tuple(_measured(column, robot, read, before) for column in read.after),
        messages=dict(sorted(messages.items())),
        warnings=tuple(read.warnings),
    )


def _efforts(read: RobotColumns, robot: Robot, n: int) -> Array:
    """The torques (n, nv) of the rows; NaN where the table gives none, because zero is a torque."""
    efforts = np.full((n, robot.model.nv), np.nan)
    for name, values in read.efforts.items():
        efforts[:, robot.joint(name).v] = values[:, None]
    return efforts


def _length(columns: Mapping[str, np.ndarray]) -> int:
    """The number of rows."""
    lengths = {name: len(values) for name, values in columns.items()}
    if len(set(lengths.values())) > 1:
        texts = ", ".join(f"{name} {n}" for name, n in lengths.items())
        raise StudyError(f"the columns differ in length: {texts}")
    if not any(lengths.values()):
        raise StudyError("the table has no rows")
    return next(iter(lengths.values()))


def _label(columns: Mapping[str, np.ndarray], robot: Robot, key: str) -> np.ndarray | None:
    """The first column that labels rows in one way. Args: key, of `LABELS`."""
    for name in LABELS[key]:
        if name in columns and name not in robot.joint_names:
            return columns[name]
    return None


def _names(columns: Mapping[str, np.ndarray], robot: Robot, n: int) -> np.ndarray:
    """The names (n,) of the rows, by default their numbers."""
    labels = _label(columns, robot, "row")
    cells = range(n) if labels is None else labels.tolist()
    names = []
    for cell in cells:
        names.append(f"{cell:.15g}" if isinstance(cell, float) else str(cell))
    return np.array(names)


def _times(columns: Mapping[str, np.ndarray], robot: Robot) -> dict[str, np.ndarray]:
    """The times (n,) of the rows, if the table has them: numbers or texts."""
    times = _label(columns, robot, "time")
    if times is None:
        return {}
    return {"time": times if times.dtype.kind in "fiu" else times.astype(str)}


def _measured(column: MeasuredColumn, robot: Robot, read: RobotColumns, before: Motion) -> Measured:
    """The jump that a column after the impact means.

    Args:
        column: the column.
        robot: the robot.
        read: the columns before the impact.
        before: motions before the impact.
    """
    name, key, time = column.meaning.target, column.meaning.base, column.meaning.time
    if "@" in name:
        # Components of a vector at all places are compared together, with their signs.
        quantity = name.partition("@")[0]
        group = quantity[:-2] if quantity[-2:] in (".x", ".y", ".z") else name
        return Measured(name, time, group, name, "", column.values)
    if key and key not in TWIST:
        raise StudyError(
            f"column {column.name}: only velocities change in an impact; leave it out with --map "
            f"COLUMN="
        )
    if column.meaning.in_body:
        raise StudyError(
            f"column {column.name}: velocities after the impact are compared in world axes; "
            f"convert them"
        )
    known = key in read.base if key else name in read.given(robot)[1]
    if not known:
        quantity = key or "rate of this joint"
        raise StudyError(
            f"column {column.name}: the table has no {quantity} before the impact, so its jump is "
            f"not known"
        )
    if not key:
        joint = robot.joint(name)
        group = "sliding rates" if joint.kind == "prismatic" else "joint rates"
        jump = column.values - before.joint_rates[:, joint.v.start]
        return Measured(name, time, group, f"delta_qd@{name}", f"{joint.unit}/s", jump)
    twist = np.concatenate([before.velocity, before.omega], axis=1)
    jump = column.values - twist[:, TWIST.index(key)]
    group, unit = ("base velocity", "m/s") if key[0] == "v" else ("base angular velocity", "rad/s")
    return Measured(name, time, group, key, unit, jump)


def _origins(
    landing: PosedLanding, columns: Mapping[str, np.ndarray], read: RobotColumns
) -> Iterator[tuple[str, bool]]:
    """The parts of a landing, in words, each with a flag: the table gives it."""
    robot = landing.robot
    yield "contacts", "contact" in columns
    if "stance" in columns:
        yield "standing feet", True
    if robot.free_base:
        yield "base attitude", bool({"qw", *ANGLES} & read.base.keys()) or "qpos" in read.arrays
        if landing.base != "fixed":
            yield from ((f"base {key}", key in read.base) for key in TWIST)
    yield from ((f'velocity of contact "{frame}"', True) for frame, _ in read.contact_velocities)
    if any(name in columns for name in FRICTION):
        yield "friction", True
    if any(np.isfinite(values).any() for values in read.efforts.values()):
        yield "efforts", True
    joints = [name for name in robot.joint_names if name not in robot.followers]
    for quantity, known in zip(("position", "rate"), read.given(robot), strict=True):
        if known:
            plural = "s" if len(known) > 1 else ""
            yield f"{quantity}s of {len(known)} joint{plural}", True
        absent = [name for name in joints if name not in known]
        if absent:
            which = "all joints" if len(absent) == len(joints) else listed(absent, 8)
            yield f"{quantity} of {which}", False
