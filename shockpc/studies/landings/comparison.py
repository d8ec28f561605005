"""Measured jumps against predicted ones: how well they agree, with bootstrap intervals over the landings."""

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from shockpc.compliance import CompliantLanding
from shockpc.core.spatial import Array
from shockpc.errors import ShockError, StudyError
from shockpc.places import body_places
from shockpc.quantities.table import select
from shockpc.robot.record import Robot
from shockpc.scene import Scene
from shockpc.studies.columns import Column, selected, values_of
from shockpc.studies.landings.study import Landings, compute, landings
from shockpc.studies.landings.table import Measured

DRAWS, SEED = 2000, 0
"""Of the bootstrap."""

LARGEST = 10**6
"""Numbers of the samples that are drawn at once."""

STATISTICS = ("r", "slope", "error", "skill", "skill (mean)")
"""Names of the statistics."""

INTERVAL = (2.5, 97.5)
"""Percentiles of its intervals."""


class Agreement(NamedTuple):
    """How well the prediction of a joint model agrees with what was measured.

    Attributes:
        model: name of the joint model; of the prediction on contacts of finite stiffness with that stiffness.
        time: after the touchdown [ms]; None where no time is said.
        name: of the quantity, or of the group of quantities of one unit, which are taken together.
        unit: of the values.
        group: whether it is a group.
        measured: (n, k) jumps of k quantities in n landings.
        predicted: (n, k) the same, predicted.
        statistics: each with its bootstrap interval: (value, low, high) by name. "r" is the correlation, "slope" that of the
            regression of measured on predicted; "error" the median over the landings of ‖predicted − measured‖ / ‖measured‖;
            "skill" 1 − Σ(predicted − measured)² / Σ measured², against the prediction of no jump; "skill (mean)" the same against
            the mean of the other landings.
    """

    model: str
    time: float | None
    name: str
    unit: str
    group: bool
    measured: Array
    predicted: Array
    statistics: Mapping[str, tuple[float, float, float]]


class Comparison(NamedTuple):
    """Measured jumps against predicted ones.

    Attributes:
        made: the landings of each joint model by its name.
        agreements: of every quantity and group, model by model.
        failures: why rows have no prediction: (model, row, reason).
    """

    made: Mapping[str, Landings]
    agreements: tuple[Agreement, ...]
    failures: tuple[tuple[str, str, str], ...]


def compare_measured(
    table: Mapping[str, Array],
    scenes: Mapping[str, Scene],
    robot: Robot,
    rename: Mapping[str, str] | None = None,
    progress: Callable[[str], None] = lambda model: None,
) -> Comparison:
    """Compare what a table measured with the predictions of several joint models.

    These are the jumps of the impulse model; where the scene has a contact stiffness, also the changes of the velocities of the
    motion on contacts and springs of finite stiffness (`compliance`) until the time after contact that the column names.

    Args:
        table: columns by name, with some that begin with after_.
        scenes: what the table does not give, by the name of the joint model.
        robot: the robot of all.
        rename: other names for columns, as for `rows_of`.
        progress: is called with the name of each model that is computed.

    Raises:
        ShockError: as for `landings`; the table measured nothing.
    """
    agreements: list[Agreement] = []
    failures: list[tuple[str, str, str]] = []
    made: dict[str, Landings] = {}
    for model, scene in scenes.items():
        own = landings(table, scene, ("shock_com@" + robot.bodies[0].name,), robot=robot, rename=rename, prove=0)
        if not own.table.measured:
            raise StudyError("the table has no column of what was measured after the impact, such as after_JOINT or after_vz")
        made[model], wanted, predicted, messages = _predicted(own)
        agreements += _agreements(model, own.table.measured, [predicted[one.key] for one in own.table.measured])
        failures += [(model, str(own.table.names[i]), text) for i, text in messages.items()]
        timed = [one for one in own.table.measured if one.time]
        if scene.contact_stiffness is not None and timed:
            stiff = f"{model}, contacts of {scene.contact_stiffness:g} N/m"
            later, messages = _predicted_later(made[model], wanted, timed, messages)
            agreements += _agreements(stiff, timed, later)
            failures += [(stiff, str(own.table.names[i]), text) for i, text in messages.items()]
        progress(model)
    return Comparison(made, tuple(agreements), tuple(failures))


def _predicted(own: Landings) -> tuple[Landings, dict[str, Column], dict[str, Array], Mapping[int, str]]:
    """The landings, the columns that predict by key, the jumps (n,) by the key of what was measured, and failures by row."""
    keys = list(dict.fromkeys(one.key for one in own.table.measured))
    base = body_places(own.robot)[0]
    wanted = {
        f"{kind}{axis}": Column(select(f"body.{key}.{axis}"), base)
        for kind, key in (("v", "delta_v"), ("w", "delta_omega"))
        for axis in "xyz"
    }
    for key in keys:
        if "@" in key:
            selection, places = selected(own.first, key)
            if len(places) != 1:
                raise StudyError(f"after_{key} is one column, and means {len(places)} places; name one of them")
            wanted[key] = Column(selection, places[0])
    own = Landings(own.scene, own.robot, own.table, tuple({column.name: column for column in wanted.values()}.values()), own.prove)
    own, columns, messages = compute(own)
    return own, wanted, _jumps(own, wanted, columns), messages


def _jumps(own: Landings, wanted: Mapping[str, Column], columns: Mapping[str, Array]) -> dict[str, Array]:
    """The jumps (n,) by key, those of the base in world axes, of the columns (n,) by name."""
    jumps = {key: columns[column.name] for key, column in wanted.items()}
    for kind in "vw":
        in_body = np.stack([jumps[kind + axis] for axis in "xyz"], axis=-1)
        world = (_rotations(own) @ in_body[..., None])[..., 0]
        jumps |= {kind + axis: world[:, k] for k, axis in enumerate("xyz")}
    return jumps


def _predicted_later(
    own: Landings, wanted: Mapping[str, Column], timed: Sequence[Measured], messages: Mapping[int, str]
) -> tuple[list[Array], dict[int, str]]:
    """The changes (n,) until the time of each measured quantity, on contacts of finite stiffness, and failures by row.

    Args:
        own: the landings.
        wanted: columns by key.
        timed: what was measured, each with a time.
        messages: the rows that have no landing.
    """
    times, messages = sorted({one.time for one in timed if one.time}), dict(messages)
    columns = {time: {column.name: np.full(own.rows, np.nan) for column in wanted.values()} for time in times}
    for i in sorted(set(range(own.rows)) - messages.keys()):
        try:
            motion = CompliantLanding(own.landing(i), times[-1] / 1e3)
        except ShockError as error:
            messages[i] = str(error)
            continue
        for time in times:
            for name, value in values_of(motion.impact_at(time / 1e3), tuple(wanted.values()), (1, 1)).items():
                columns[time][name][i] = value[0, 0]
    jumps = {time: _jumps(own, wanted, columns[time]) for time in times}
    later = [jumps[one.time][one.key] for one in timed if one.time]
    for one, values in zip(timed, later, strict=True):
        for i in sorted(set(np.flatnonzero(np.isnan(values)).tolist()) - messages.keys()):
            messages[i] = f"{one.key} at a time after contact does not follow from velocities, or has no value"
    return later, messages


def _rotations(own: Landings) -> Array:
    """Rotations (n, 3, 3) of the base's frame, body to world."""
    from scipy.spatial.transform import Rotation

    if not own.robot.free_base:
        return np.broadcast_to(own.first.state.rotation[0, 0], (own.rows, 3, 3))
    return np.asarray(Rotation.from_quat(own.table.Q[:, 3:7]).as_matrix() @ own.robot.bodies[0].rotation)


def _agreements(model: str, measured: Sequence[Measured], predicted: Sequence[Array]) -> list[Agreement]:
    """Of every group, then of every quantity, at each time. Args: predicted, (n,) for each that is measured."""
    found = []
    groups = dict.fromkeys((one.time, one.group) for one in measured)
    for time, group in groups:
        own = [k for k, one in enumerate(measured) if (one.time, one.group) == (time, group)]
        parts = [(group, own)] + ([(measured[k].name, [k]) for k in own] if len(own) > 1 else [])
        for name, ones in parts:
            truth, guess = np.stack([measured[k].jump for k in ones], axis=1), np.stack([predicted[k] for k in ones], axis=1)
            unit = measured[ones[0]].unit or _unit_of(measured[ones[0]].key)
            kept = np.isfinite(guess).all(axis=1)
            statistics = _statistics(truth[kept], guess[kept])
            found.append(Agreement(model, time, name, unit, len(own) > 1 and name == group, truth, guess, statistics))
    return sorted(found, key=lambda one: not one.group)


def _unit_of(key: str) -> str:
    """The unit of KEY@PLACE."""
    return select(key.partition("@")[0]).quantity.unit


def _statistics(measured: Array, predicted: Array) -> dict[str, tuple[float, float, float]]:
    """The statistics of `Agreement`, with intervals: landings are drawn with replacement, each with all of its quantities."""
    n = len(measured)
    if not n:
        return dict.fromkeys(STATISTICS, (np.nan, np.nan, np.nan))
    values = {name: float(value[0]) for name, value in _of_samples(measured[None], predicted[None]).items()}
    if n < 3:
        return {name: (value, np.nan, np.nan) for name, value in values.items()}
    rng, size = np.random.default_rng(SEED), max(1, LARGEST // measured.size)
    count = int(np.clip(LARGEST * 20 // measured.size, 200, DRAWS))
    samples: list[dict[str, Array]] = []
    for k in range(0, count, size):
        draws = rng.integers(n, size=(min(size, count - k), n))
        samples.append(_of_samples(measured[draws], predicted[draws]))
    found = {}
    for name, value in values.items():
        drawn = np.concatenate([sample[name] for sample in samples])
        low, high = np.nanpercentile(drawn, INTERVAL) if np.isfinite(value) else (np.nan, np.nan)
        found[name] = (value, float(low), float(high))
    return found


def _of_samples(measured: Array, predicted: Array) -> dict[str, Array]:
    """The statistics of samples (m, n, k) of landings; NaN where one has no meaning."""
    m, n, _ = measured.shape
    with np.errstate(invalid="ignore", divide="ignore"):
        x, y = (values.reshape(m, -1) for values in (predicted, measured))
        x, y = x - x.mean(axis=1, keepdims=True), y - y.mean(axis=1, keepdims=True)
        xx, yy, xy = (np.sum(one * other, axis=1) for one, other in ((x, x), (y, y), (x, y)))
        off, size = np.linalg.norm(predicted - measured, axis=2), np.linalg.norm(measured, axis=2)
        others = (measured.sum(axis=1, keepdims=True) - measured) / (n - 1)
        squares = np.sum(off**2, axis=1)
        values = {
            "r": xy / np.sqrt(xx * yy),
            "slope": xy / xx,
            "error": np.median(off / size, axis=1),
            "skill": 1.0 - squares / np.sum(size**2, axis=1),
            "skill (mean)": 1.0 - squares / np.sum((measured - others) ** 2, axis=(1, 2)),
        }
    return {name: np.where(np.isfinite(value), value, np.nan) for name, value in values.items()}
