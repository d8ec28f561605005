"""Agreement of measured and predicted jumps, with bootstrap intervals over the landings."""

import os
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.evaluation.declare import QuantityOption, study
from shockpc.evaluation.evaluate import Evaluation
from shockpc.evaluation.table import Table
from shockpc.evaluation.unused_ground import refuse_unused_ground
from shockpc.landing.scenes.scene import Scene
from shockpc.landing.scenes.scene_fields import Option
from shockpc.landing.scenes.scene_file import scene_of
from shockpc.quantities.selection import select
from shockpc.robot.robot import Robot
from shockpc.text.errors import StudyError
from shockpc.wings.recordings.tables.column_meaning import RenameOption
from shockpc.wings.recordings.tables.evaluation import recorded_landings
from shockpc.wings.recordings.tables.landings import RecordedLandings
from shockpc.wings.recordings.tables.prediction import (
    base_in_world,
    coordinate,
    energy_norms,
    mobilities,
    predicted_later,
    predicting,
)
from shockpc.wings.recordings.tables.reader import robot_of_table, rows_of_table
from shockpc.wings.recordings.tables.rows import Measured, RecordedRows
from shockpc.wings.recordings.tables.table_files import columns_of

DRAWS, SEED = 2000, 0
"""Number of draws and seed of the bootstrap."""

FEWEST = 10
"""Landings below which chance makes correlations, and draws repeat too few landings for intervals.
"""

DRAWN_TOGETHER = 10**6
"""Numbers of the samples that are drawn at once."""

EQUAL = 1e-12
"""Deviation from their mean, relative to their size, below which values are equal up to rounding.
"""

STATISTICS = ("r", "slope", "error", "error (energy)", "skill", "skill (mean)")
"""Names of the statistics."""

ALL = "all velocities"
"""The group of all velocities, which have different units: it has only an error in the energy norm.
"""

INTERVAL = (2.5, 97.5)
"""Percentiles of its intervals."""


UNKNOWN = (np.nan, np.nan, np.nan)
"""A statistic without value and interval."""


class Agreement(NamedTuple):
    """Agreement of the prediction of a joint model with what was measured.

    Attributes:
        model: name of the joint model; of the prediction on contacts of finite stiffness with that
            stiffness.
        time: after the touchdown [ms]; None where no time is given.
        name: of the quantity, or of the group of quantities of one unit, which are taken together.
        unit: of the values.
        group: whether it is a group, which may have only one quantity.
        measured: (n, k) jumps of k quantities in n landings; NaN where one was not measured.
        predicted: (n, k) the same, predicted.
        statistics: each with its bootstrap interval: (value, low, high) by name; of fewer than
            `FEWEST` landings there is neither an interval nor "r". "r" is the correlation, "slope"
            that of the regression of measured on predicted; "error" the median over the landings of
            ‖predicted − measured‖ / ‖measured‖, "error (energy)" that in the norm √(ΔᵀHΔ) of the
            landing's inertia H, which needs no choice of units (velocities that were not measured
            are those that minimise it); "skill" 1 − Σ(predicted − measured)² / Σ measured², against
            the prediction of no jump; "skill (mean)" the same against the mean of the other
            landings.
        n: number of landings that were measured and predicted, of which the statistics are.
    """

    model: str
    time: float | None
    name: str
    unit: str
    group: bool
    measured: Array
    predicted: Array
    statistics: Mapping[str, tuple[float, float, float]]
    n: int


class Validation(NamedTuple):
    """Measured jumps against predicted ones.

    Attributes:
        agreements: of every group and quantity, model by model.
        failures: why rows have no prediction: (model, row, reason).
    """

    agreements: tuple[Agreement, ...]
    failures: tuple[tuple[str, str, str], ...]


class Prediction(NamedTuple):
    """The measured quantities of a table as a joint model predicts them.

    Attributes:
        model: its name.
        measured: the quantities.
        jumps: (n,) of each of them, predicted.
        messages: why rows have no prediction, by number.
    """

    model: str
    measured: Sequence[Measured]
    jumps: Sequence[Array]
    messages: Mapping[int, str]


@study(
    "shockpc recorded log.csv anymal_b --contact LF_FOOT --rank delta_v@imu_link",
    "shockpc recorded log.csv anymal_b --contact LF_FOOT --pulse half-sine:5ms --rank "
    "peak_g@imu_link --out recorded/",
    more=(
        "A row is a touchdown (CSV, Parquet, NPZ). Columns: joint positions JOINT or "
        "q_JOINT and rates before_JOINT or qd_JOINT [rad, m]; the base's qw qx qy qz or roll pitch "
        "yaw, x y z, velocity vx vy vz "
        "and angular velocity wx wy wz in world axes, with _body in body axes; contact (A+B), "
        "stance (feet that stand, A+B), "
        "vx@FRAME vy@FRAME vz@FRAME of a contact whose velocity does not follow from the robot's "
        "motion (else empty), friction, "
        "name, time. _deg at the end of a name means degrees. Arrays qpos and qvel are MuJoCo's, "
        "name, position and velocity "
        "ROS's. What the table lacks is taken from the scene. "
        "Columns after_JOINT, after_vx and after_KEY@PLACE, or after6ms_… with a time, are "
        "compared with the prediction."
    ),
)
def recorded(
    table: str | os.PathLike[str] | Mapping[str, Any] | Table,
    scene: Scene | str,
    quantities: QuantityOption = (),
    *,
    robot: Robot | None = None,
    rename: RenameOption = None,
    rank: Annotated[
        str | None,
        Option(
            "Order the landings by a quantity, the worst first.",
            "Table",
            "KEY[@PLACE]",
            holds="quantity",
        ),
    ] = None,
    prove: Annotated[
        int,
        Option(
            "Number of landings that are also solved exactly, as a check, besides those that need "
            "it.",
            "How it is computed",
            "N",
            least=0.0,
            greatest=1e6,
        ),
    ] = 20,
) -> Evaluation[RecordedLandings]:
    """The landings of a recorded table, checked.

    They are computed part by part as the result is iterated over, or at once by `table`.

    Args:
        table: a CSV, Parquet or NPZ file, or its columns by name, such as the table of
            `touchdowns`; as `rows_of` takes them.
        scene: gives what the table does not; without contacts every row has to name its own.
        robot: the scene's robot, if it is loaded already.

    Raises:
        ShockError: the table cannot be read, a column names nothing in the robot, or the scene
            cannot be resolved.
    """
    columns, scene = columns_of(table), scene_of(scene)
    robot = robot or robot_of_table(columns, scene)
    rows = rows_of_table(columns, scene, robot, rename)
    evaluation = recorded_landings(rows, robot, quantities, prove=prove, rank=rank)
    refuse_unused(scene, rows, evaluation)
    return evaluation


def refuse_unused(
    scene: Scene, rows: RecordedRows, evaluation: Evaluation[RecordedLandings]
) -> None:
    """Refuse a friction or a contact stiffness of a scene that has no effect.

    Nothing that is computed, or compared with a table's, depends on it then.

    Args:
        scene: gives what the table does not.
        rows: of the table; what was measured is compared with the jumps with friction, and at times
            after contact with those on contacts of finite stiffness.
        evaluation: what is computed of them.

    Raises:
        StudyError: the scene gives one.
    """
    # On contacts of finite stiffness only what has a time is compared with those.
    compared = [column for column in rows.measured if not scene.yields or column.time is not None]
    if not compared:
        refuse_unused_ground(scene, (column.selection for column in evaluation.computed))


def compare_measured(
    columns: Mapping[str, Array],
    scenes: Mapping[str, Scene],
    robot: Robot,
    rename: Mapping[str, str] | None = None,
) -> Validation:
    """Compare what a table measured with the predictions of several joint models.

    These are the jumps of the impulse model, with friction where the scene or the rows have one;
    where the scene has a contact stiffness, also the changes of the velocities of the motion on
    contacts and springs of finite stiffness until the time after contact that the column names.

    Args:
        columns: of a table by name, with some that begin with after_.
        scenes: what the table does not give, by the name of the joint model.
        robot: the robot of all.
        rename: other names for columns, as for `rows_of`.

    Raises:
        ShockError: as for `rows_of`; the table measured nothing, or with friction a quantity that
            does not exist with it.
    """
    agreements: list[Agreement] = []
    failures: list[tuple[str, str, str]] = []
    for model, scene in scenes.items():
        rows = rows_of_table(columns, scene, robot, rename)
        if not rows.measured:
            raise StudyError(
                "the table has no column of velocities measured after the impact, such as "
                "after_JOINT or after_vz"
            )
        study = RecordedLandings(robot, rows, by_friction=True)
        by_key = predicting(study, friction=not np.isnan(rows.friction).all())
        computed = {column.name: column for column in by_key.values()}
        results = Evaluation(study, tuple(computed.values()), prove=0).table.without_defects()
        jumps = base_in_world(study, by_key, results.columns)
        predictions = [
            Prediction(
                model,
                rows.measured,
                [jumps[column.key] for column in rows.measured],
                results.messages,
            )
        ]
        timed = tuple(column for column in rows.measured if column.time)
        if scene.yields and timed:
            name = f"{model}, {scene.yielding}"
            predictions.append(Prediction(name, timed, *predicted_later(study, by_key, timed)))
        W = mobilities(study)
        for prediction in predictions:
            agreements += _agreements(prediction, robot, W)
            for i, text in prediction.messages.items():
                failures.append((prediction.model, str(rows.names[i]), text))
    return Validation(tuple(agreements), tuple(failures))


def _agreements(prediction: Prediction, robot: Robot, W: Array) -> list[Agreement]:
    """The agreement of every group, then of every quantity, at each time.

    Args:
        prediction: of all quantities.
        robot: the robot.
        W: as `mobilities` gives them.
    """
    measured = prediction.measured
    coordinates = np.array([coordinate(column, robot) for column in measured])
    groups: list[Agreement] = []
    quantities: list[Agreement] = []

    def add(to: list[Agreement], name: str, members: list[int], group: bool) -> None:
        to.append(_agreement(prediction, name, members, group, coordinates[members], W))

    by_group: dict[tuple[float | None, str], list[int]] = {}
    by_time: dict[float | None, list[int]] = {}
    for k, column in enumerate(measured):
        by_group.setdefault((column.time, column.group), []).append(k)
        by_time.setdefault(column.time, [])
        if coordinates[k] >= 0:
            by_time[column.time].append(k)
    for (_, name), members in by_group.items():
        first = measured[members[0]]
        if len(members) == 1:
            # A component of a vector has its own name then.
            add(groups, name if first.unit else first.name, members, True)
            continue
        add(groups, name, members, True)
        for k in members:
            add(quantities, measured[k].name, [k], False)
    for members in by_time.values():
        if len({measured[k].group for k in members}) > 1:
            add(groups, ALL, members, True)
    return groups + quantities


def _agreement(
    prediction: Prediction,
    name: str,
    members: list[int],
    group: bool,
    coordinates: np.ndarray,
    W: Array,
) -> Agreement:
    """The agreement of some quantities.

    Args:
        prediction: of all quantities.
        name: of the agreement.
        members: numbers of its quantities.
        group: whether it is a group.
        coordinates: of its quantities in the velocities of the robot; −1 of those that are none.
        W: as `mobilities` gives them.
    """
    jumps = np.stack([prediction.measured[k].jump for k in members], axis=1)
    predicted = np.stack([prediction.jumps[k] for k in members], axis=1)
    known = np.isfinite(predicted).all(axis=1) & np.isfinite(jumps).any(axis=1)
    y = jumps[known]
    x = predicted[known]
    errors = np.full(len(y), np.nan)
    if coordinates.min() >= 0:
        with np.errstate(invalid="ignore", divide="ignore"):
            sizes = energy_norms(W[known], coordinates, y)
            errors = energy_norms(W[known], coordinates, x - y) / sizes
    statistics = _statistics(y, x, errors)
    first = prediction.measured[members[0]]
    unit = first.unit or select(first.key.partition("@")[0]).quantity.unit
    if name == ALL:
        unit = "√J"
        error = statistics["error (energy)"]
        statistics = dict.fromkeys(statistics, UNKNOWN) | {"error (energy)": error}
    return Agreement(
        model=prediction.model,
        time=first.time,
        name=name,
        unit=unit,
        group=group,
        measured=jumps,
        predicted=predicted,
        statistics=statistics,
        n=len(y),
    )


def _statistics(
    measured: Array, predicted: Array, energy: Array
) -> dict[str, tuple[float, float, float]]:
    """The statistics of `Agreement`, with bootstrap intervals.

    Landings are drawn with replacement, each with all of its quantities.

    Args:
        measured: (n, k) jumps.
        predicted: (n, k) the same, predicted.
        energy: (n,) errors of the landings in the energy norm.
    """
    n = len(measured)
    if not n:
        return dict.fromkeys(STATISTICS, UNKNOWN)
    rng = np.random.default_rng(SEED)
    together = max(1, DRAWN_TOGETHER // measured.size)
    count = 0
    if n >= FEWEST:
        count = int(np.clip(DRAWN_TOGETHER * 20 // measured.size, 200, DRAWS))
    # First the landings as they are, then the draws.
    samples = [_of_samples(measured, predicted, energy, np.arange(n)[None])]
    for k in range(0, count, together):
        draws = rng.integers(n, size=(min(together, count - k), n))
        samples.append(_of_samples(measured, predicted, energy, draws))
    values = np.concatenate(samples, axis=1)
    statistics: dict[str, tuple[float, float, float]] = {}
    for name, (value, *drawn) in zip(STATISTICS, values.tolist(), strict=True):
        statistics[name] = (value, np.nan, np.nan)
        if drawn and np.isfinite(value):
            low, high = np.nanpercentile(drawn, INTERVAL).tolist()
            statistics[name] = (value, low, high)
    if n < FEWEST:
        statistics["r"] = UNKNOWN
    return statistics


def _of_samples(measured: Array, predicted: Array, energy: Array, draws: np.ndarray) -> Array:
    """The statistics (6, m), as `STATISTICS`, of draws (m, n) of landings by number.

    NaN where one has no meaning.

    With predicted jumps p, measured ones q and their deviations x and y from their means:
    r = Σ x y / √(Σ x² Σ y²), slope = Σ x y / Σ x², errors = median of ‖p − q‖ / ‖q‖ and of those in
    the energy norm, skill = 1 − Σ ‖p − q‖² / Σ ‖q‖², and the same with q from the mean of others.
    """
    drawn = measured[draws]
    known = np.isfinite(drawn)
    q = np.where(known, drawn, 0.0)
    p = np.where(known, predicted[draws], 0.0)
    with np.errstate(invalid="ignore", divide="ignore"):
        x = _from_mean(p, known)
        y = _from_mean(q, known)
        xx = _squares(x, p)
        yy = _squares(y, q)
        xy = np.sum(x * y, axis=(1, 2))
        off = np.linalg.norm(p - q, axis=2)
        size = np.linalg.norm(q, axis=2)
        squares = np.sum(off**2, axis=1)
        values = np.stack(
            [
                xy / np.sqrt(xx * yy),
                xy / xx,
                np.median(off / size, axis=1),
                np.median(energy[draws], axis=1),
                1.0 - squares / np.sum(size**2, axis=1),
                1.0 - squares / _squares(_from_others(q, known, draws), q),
            ]
        )
    return np.where(np.isfinite(values), values, np.nan)


def _from_mean(values: Array, known: np.ndarray) -> Array:
    """Deviations (m, n, k) of values, zero where they are not known, from the mean of each draw."""
    count = known.sum(axis=(1, 2), keepdims=True)
    mean = values.sum(axis=(1, 2), keepdims=True) / count
    return np.where(known, values - mean, 0.0)


def _from_others(values: Array, known: np.ndarray, draws: np.ndarray) -> Array:
    """Deviations (m, n, k) of each landing from the mean of the others in its draw (m, n).

    The others are those that are no copy of the landing: a copy foretells it.
    """
    n = draws.shape[1]
    copies = np.array([np.bincount(draw, minlength=n)[draw] for draw in draws])[..., None]
    number = known.sum(axis=1, keepdims=True) - copies
    others = values.sum(axis=1, keepdims=True) - copies * values
    mean = others / np.where(number > 0, number, np.nan)
    return np.where(known, values - mean, 0.0)


def _squares(deviations: Array, values: Array) -> Array:
    """The sums of squares (m,) of deviations (m, n, k) of values.

    NaN where the values are equal, and rounding alone deviates.
    """
    squares = np.sum(deviations**2, axis=(1, 2))
    return np.where(squares > EQUAL**2 * np.sum(values**2, axis=(1, 2)), squares, np.nan)
