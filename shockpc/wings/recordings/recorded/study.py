"""Measured jumps against predicted ones: how well they agree, with bootstrap intervals over the
landings.
"""

import os
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.evaluation.declare import QuantityOption, RenameOption, study
from shockpc.evaluation.evaluate import Evaluation
from shockpc.evaluation.table import Table
from shockpc.evaluation.unused_ground import refuse_unused_ground
from shockpc.landing.record import Option
from shockpc.landing.scene import Scene
from shockpc.landing.scene_file import scene_of
from shockpc.quantities.selection import select
from shockpc.robot.robot import Robot
from shockpc.text.errors import StudyError
from shockpc.wings.recordings.logs.landings import (
    RecordedLandings,
    recorded_landings,
    robot_of_table,
    rows_of_table,
)
from shockpc.wings.recordings.logs.prediction import (
    base_in_world,
    coordinate,
    energy_norms,
    mobilities,
    predicted_later,
    predicting,
)
from shockpc.wings.recordings.logs.rows import Measured, RecordedRows
from shockpc.wings.recordings.logs.table_files import columns_of

DRAWS, SEED = 2000, 0
"""Of the bootstrap."""

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


class Agreement(NamedTuple):
    """How well the prediction of a joint model agrees with what was measured.

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
    """The landings of a recorded table, checked; computed part by part as the result is iterated
    over, or at once by `table`.

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
    """Refuse a friction or a contact stiffness of a scene on which nothing depends that is
    computed, or compared with a table's.

    Args:
        scene: gives what the table does not.
        rows: of the table; what was measured is compared with the jumps with friction, and at times
            after contact with those on contacts of finite stiffness.
        evaluation: what is computed of them.

    Raises:
        StudyError: the scene gives one.
    """
    compared = (
        rows.measured
        if not scene.yields
        else [one for one in rows.measured if one.time is not None]
    )
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
        results = Evaluation(
            study, tuple({column.name: column for column in by_key.values()}.values()), prove=0
        ).table.without_defects()
        jumps = base_in_world(study, by_key, results.columns)
        predictions = [
            (
                model,
                rows.measured,
                [jumps[column.key] for column in rows.measured],
                results.messages,
            )
        ]
        timed = tuple(column for column in rows.measured if column.time)
        if scene.yields and timed:
            name = f"{model}, {scene.yielding}"
            predictions.append((name, timed, *predicted_later(study, by_key, timed)))
        W = mobilities(study)
        for name, measured, predicted, messages in predictions:
            agreements += _agreements(name, measured, predicted, robot, W)
            failures += [(name, str(rows.names[i]), text) for i, text in messages.items()]
    return Validation(tuple(agreements), tuple(failures))


def _agreements(
    model: str, measured: Sequence[Measured], predicted: Sequence[Array], robot: Robot, W: Array
) -> list[Agreement]:
    """Of every group, then of every quantity, at each time.

    Args:
        model: its name.
        measured: the quantities.
        predicted: (n,) for each of them.
        robot: the robot.
        W: as `mobilities` gives them.
    """
    groups: list[Agreement] = []
    quantities: list[Agreement] = []
    coordinates = np.array([coordinate(column, robot) for column in measured])

    def agreement(name: str, columns: Sequence[int], group: bool) -> Agreement:
        truth, guess = (
            np.stack([values[k] for k in columns], axis=1)
            for values in ([m.jump for m in measured], predicted)
        )
        first, members = measured[columns[0]], coordinates[columns]
        unit = (
            "√J" if name == ALL else first.unit or select(first.key.partition("@")[0]).quantity.unit
        )
        known = np.isfinite(guess).all(axis=1) & np.isfinite(truth).any(axis=1)
        mobile, y, x, ratio = (
            W[known],
            truth[known],
            guess[known],
            np.full(int(known.sum()), np.nan),
        )
        if members.min() >= 0:
            with np.errstate(invalid="ignore", divide="ignore"):
                ratio = energy_norms(mobile, members, x - y) / energy_norms(mobile, members, y)
        statistics = _statistics(y, x, ratio)
        if name == ALL:
            statistics = {
                key: x if key == "error (energy)" else (np.nan,) * 3
                for key, x in statistics.items()
            }
        return Agreement(
            model, first.time, name, unit, group, truth, guess, statistics, int(known.sum())
        )

    for time, group in dict.fromkeys((column.time, column.group) for column in measured):
        members = [
            k for k, column in enumerate(measured) if (column.time, column.group) == (time, group)
        ]
        # a component of a vector has its own name then
        alone = len(members) == 1 and not measured[members[0]].unit
        groups.append(agreement(measured[members[0]].name if alone else group, members, True))
        quantities += [agreement(measured[k].name, [k], False) for k in members if len(members) > 1]
    for time in dict.fromkeys(column.time for column in measured):
        members = [
            k for k, column in enumerate(measured) if column.time == time and coordinates[k] >= 0
        ]
        if len({measured[k].group for k in members}) > 1:
            groups.append(agreement(ALL, members, True))
    return groups + quantities


def _statistics(
    measured: Array, predicted: Array, energy: Array
) -> dict[str, tuple[float, float, float]]:
    """The statistics of `Agreement`, with intervals: landings are drawn with replacement, each with
    all of its quantities.

    Args:
        measured: (n, k) jumps.
        predicted: (n, k) the same, predicted.
        energy: (n,) errors of the landings in the energy norm.
    """
    n = len(measured)
    if not n:
        return dict.fromkeys(STATISTICS, (np.nan, np.nan, np.nan))
    rng, together = np.random.default_rng(SEED), max(1, DRAWN_TOGETHER // measured.size)
    count = int(np.clip(DRAWN_TOGETHER * 20 // measured.size, 200, DRAWS)) if n >= FEWEST else 0
    samples = [_of_samples(measured, predicted, energy, np.arange(n)[None])]
    for k in range(0, count, together):
        draws = rng.integers(n, size=(min(together, count - k), n))
        samples.append(_of_samples(measured, predicted, energy, draws))
    values = np.concatenate(samples, axis=1)
    statistics = {}
    for name, (value, *drawn) in zip(STATISTICS, values.tolist(), strict=True):
        interval = (
            np.nanpercentile(drawn, INTERVAL).tolist()
            if drawn and np.isfinite(value)
            else (np.nan, np.nan)
        )
        statistics[name] = (value, *interval)
    if n < FEWEST:
        statistics["r"] = (np.nan,) * 3
    return statistics


def _of_samples(measured: Array, predicted: Array, energy: Array, draws: np.ndarray) -> Array:
    """The statistics (6, m), as `STATISTICS`, of draws (m, n) of landings by number; NaN where one
    has no meaning.

    The mean of the other landings is over those of the draw that are no copy of the landing: a copy
    foretells it.
    """
    copies = np.array([np.bincount(draw, minlength=len(measured))[draw] for draw in draws])[
        ..., None
    ]
    measured, predicted = measured[draws], predicted[draws]
    known = np.isfinite(measured)
    measured, predicted = np.where(known, measured, 0.0), np.where(known, predicted, 0.0)
    with np.errstate(invalid="ignore", divide="ignore"):
        count = known.sum(axis=(1, 2), keepdims=True)
        x, y = (
            np.where(known, values - values.sum(axis=(1, 2), keepdims=True) / count, 0.0)
            for values in (predicted, measured)
        )
        xx, yy, xy = _squares(x, predicted), _squares(y, measured), np.sum(x * y, axis=(1, 2))
        off, size = np.linalg.norm(predicted - measured, axis=2), np.linalg.norm(measured, axis=2)
        number = known.sum(axis=1, keepdims=True) - copies
        others = (measured.sum(axis=1, keepdims=True) - copies * measured) / np.where(
            number > 0, number, np.nan
        )
        apart = np.where(known, measured - others, 0.0)
        squares = np.sum(off**2, axis=1)
        skill, skill_mean = (
            1.0 - squares / total for total in (np.sum(size**2, axis=1), _squares(apart, measured))
        )
        errors = (np.median(ratio, axis=1) for ratio in (off / size, energy[draws]))
        values = np.stack([xy / np.sqrt(xx * yy), xy / xx, *errors, skill, skill_mean])
    return np.where(np.isfinite(values), values, np.nan)


def _squares(deviations: Array, values: Array) -> Array:
    """The sums of squares (m,) of deviations (m, n, k) of values; NaN where these are equal, and
    rounding alone deviates.
    """
    squares = np.sum(deviations**2, axis=(1, 2))
    return np.where(squares > EQUAL**2 * np.sum(values**2, axis=(1, 2)), squares, np.nan)
