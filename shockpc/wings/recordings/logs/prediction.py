"""Predicted jumps of what recorded landings measured, and the norm of their errors.

They are for values of what is unknown.
"""

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple, TypeAlias

import numpy as np

from shockpc.core.inertia import solve_inertia
from shockpc.core.memo import memoized
from shockpc.core.spatial import Array
from shockpc.evaluation.column import Column, selected
from shockpc.evaluation.column_values import postures
from shockpc.evaluation.evaluate import MAX_CONDITION, Evaluation
from shockpc.evaluation.landings import Refusal
from shockpc.evaluation.variations.variation import Variation
from shockpc.impact.friction import FrictionProblem, friction_problem, friction_problems, joined
from shockpc.landing.movable import movable_columns
from shockpc.landing.places import Place, body_places
from shockpc.landing.scenes.scene import Scene
from shockpc.method.approach import Motion
from shockpc.method.dynamics import Dynamics, dynamics
from shockpc.method.equation import Equation
from shockpc.quantities.selection import select, selections
from shockpc.robot.robot import Robot
from shockpc.text.errors import DefectError, ShockError, StudyError
from shockpc.wings.recordings.logs.landings import RecordedLandings
from shockpc.wings.recordings.logs.rows import Measured, RecordedRows

COMPONENTS = ("vx", "vy", "vz", "wx", "wy", "wz")
"""Those of the base's velocity, as coordinates."""


def predicting(study: RecordedLandings, friction: bool) -> dict[str, Column]:
    """The columns that predict what was measured, by its key.

    All components of the base's jump are among them.

    Args:
        study: the landings.
        friction: whether they have friction, and the jumps are those with it.
    """
    base, kinds = body_places(study.robot)[0], {"v": "delta_v", "w": "delta_omega"}
    columns = {
        kind + axis: Column(select(f"body.{key}.{axis}"), base)
        for kind, key in kinds.items()
        for axis in "xyz"
    }
    for key in dict.fromkeys(
        measured.key for measured in study.table.measured if "@" in measured.key
    ):
        selection, places = selected(study.first, key)
        if len(places) != 1:
            raise StudyError(
                f"after_{key} is one column, and means {len(places)} places; name one of them"
            )
        columns[key] = Column(selection, places[0])
    return (
        {key: _with_friction(key, column) for key, column in columns.items()}
        if friction
        else columns
    )


def _with_friction(key: str, column: Column) -> Column:
    """The quantity of a column in the impact with friction.

    Args: key, of what was measured.
    """
    selection = column.selection
    if selection.quantity.computation.exact == "never":
        return column  # of the impact with friction already
    name = selection.name.replace(selection.quantity.key, f"{selection.quantity.key}_friction")
    if name not in selections():
        raise StudyError(
            f"after_{key} cannot be predicted with friction, because {selection.name} does not "
            f"exist with it; leave the column out "
            f"with --map after_{key}=, or the friction"
        )
    return column._replace(selection=select(name))


def base_in_world(
    study: RecordedLandings, predicting: Mapping[str, Column], columns: Mapping[str, Array]
) -> dict[str, Array]:
    """The jumps (n,) by key, those of the base in world axes.

    Args: columns (n,) by name, those of the base in body axes.
    """
    jumps = {key: columns[column.name] for key, column in predicting.items()}
    for kind in "vw":
        in_body = np.stack([jumps[kind + axis] for axis in "xyz"], axis=-1)
        world = (_rotations(study) @ in_body[..., None])[..., 0]
        jumps |= {kind + axis: world[:, k] for k, axis in enumerate("xyz")}
    return jumps


def _rotations(study: RecordedLandings) -> Array:
    """Rotations (n, 3, 3) of the base's frame, body to world."""
    from scipy.spatial.transform import Rotation

    if not study.robot.free_base:
        return np.broadcast_to(study.first.state.rotation[0, 0], (study.rows, 3, 3))
    return np.asarray(
        Rotation.from_quat(study.table.Q[:, 3:7]).as_matrix() @ study.robot.bodies[0].rotation
    )


def predicted_later(
    study: RecordedLandings, by_key: Mapping[str, Column], timed: Sequence[Measured]
) -> tuple[list[Array], dict[int, str]]:
    """The changes (n,) until the time of each measured quantity, and failures by row.

    They are on contacts of finite stiffness.

    Args:
        study: the landings.
        by_key: columns by key.
        timed: what was measured, each with a time.
    """
    at_times = {
        time: {key: column._replace(time=time) for key, column in by_key.items()}
        for time in sorted({measured.time for measured in timed if measured.time})
    }
    wanted = {column.name: column for columns in at_times.values() for column in columns.values()}
    results = Evaluation(study, tuple(wanted.values()), prove=0).table.without_defects()
    messages, jumps = (
        dict(results.messages),
        {time: base_in_world(study, one, results.columns) for time, one in at_times.items()},
    )
    later = [jumps[measured.time][measured.key] for measured in timed if measured.time]
    for measured, values in zip(timed, later, strict=True):
        for i in set(np.flatnonzero(np.isnan(values)).tolist()) - messages.keys():
            messages[i] = (
                f"{measured.key} at a time after contact does not follow from velocities, or has "
                f"no value"
            )
    return later, dict(sorted(messages.items()))


def mobilities(study: RecordedLandings) -> Array:
    """W = H⁻¹ (n, nv, nv) of the landings.

    That of a free base is in the world's components of its velocity and angular velocity.

    Joints are free, and followers follow; along what the base cannot move, and of rows without a
    landing, W is zero or NaN.
    """
    robot = study.robot
    W, locked = (
        np.full((study.rows, robot.model.nv, robot.model.nv), np.nan),
        np.zeros(robot.model.nv, dtype=bool),
    )
    for k, (first, _) in enumerate(study.chunks):
        for group in study.chunk(k, study.data(k)).groups:
            if isinstance(group, Refusal):
                continue
            landing = group.landing
            state = dynamics(robot, group.Q, landing.joint_model)
            moved, G = (
                _velocities(robot, state),
                movable_columns(robot, landing.base, landing.plane, state.rotation[:, 0], locked),
            )
            moved, H = (
                (moved, state.H) if G is None else (moved @ G, G.swapaxes(1, 2) @ state.H @ G)
            )
            W[first + group.postures] = moved @ solve_inertia(H, moved.swapaxes(1, 2))
    return W


def _velocities(robot: Robot, state: Dynamics) -> Array:
    """The velocities (N, nv, nv) of `mobilities` for unit joint velocities in N postures."""
    velocities = np.broadcast_to(np.eye(robot.model.nv), state.H.shape).copy()
    if robot.free_base:
        velocities[:, :6, :6] = state.J[:, [3, 4, 5, 0, 1, 2], :6]
    return velocities


def coordinate(measured: Measured, robot: Robot) -> int:
    """Row of `mobilities` that a measured velocity has; −1 for another quantity."""
    if measured.key in COMPONENTS:
        return COMPONENTS.index(measured.key)
    return (
        robot.joint(measured.name).v.start
        if measured.group in ("joint rates", "sliding rates")
        else -1
    )


def energy_roots(W: Array, chosen: np.ndarray) -> Array:
    """Matrices R (n, k, k) of the least energy of jumps δ: ‖R δ‖².

    That is the smallest ΔᵀHΔ of all motions Δ in which some velocities jump by δ.

    Args:
        W: (n, nv, nv) mobilities.
        chosen: (k,) which velocities. A jump of one that cannot be does not count.
    """
    s, Q = np.linalg.eigh(W[:, chosen][:, :, chosen])
    root = np.where(s > 1e-12 * s[:, -1:], 1.0 / np.sqrt(np.where(s > 0.0, s, 1.0)), 0.0)
    return np.asarray(root[..., None] * Q.swapaxes(1, 2))


def energy_norms(W: Array, coordinates: Array, jumps: Array) -> Array:
    """√(ΔᵀHΔ) (n,), the smallest for whatever Δ there is where none was measured [√J].

    Args:
        W: (n, nv, nv) mobilities.
        coordinates: (k,) of the jumps.
        jumps: (n, k) measured parts of Δ; NaN where there is none.
    """
    norms, measured = np.full(len(jumps), np.nan), np.isfinite(jumps)
    for pattern in np.unique(measured[measured.any(axis=1)], axis=0):
        rows = np.flatnonzero((measured == pattern).all(axis=1) & np.isfinite(W).all(axis=(1, 2)))
        root = energy_roots(W[rows], coordinates[pattern])
        norms[rows] = np.linalg.norm((root @ jumps[rows][:, pattern, None])[..., 0], axis=1)
    return norms


SCALE = "scale:before"
"""An unknown: the factor by which the velocities before the impact were measured too small."""

MOST_PROBLEMS = 16
"""Values of all but friction, restitution and scale of which what does not depend on these is kept.
"""

MOST_KNOWN = 500
"""Values of which the predictions are kept."""

STICKS = 1e9
"""Friction of rows without one, beside rows with friction."""

Problems: TypeAlias = tuple[list[tuple[np.ndarray, FrictionProblem, Array]], dict[int, str]]


class Predicted(NamedTuple):
    """Jumps of velocities that were measured.

    Attributes:
        jumps: (n, k) predicted; NaN where there is no prediction.
        measured: (n, k) measured; NaN where one was not.
        messages: why rows have no prediction, by their number.
    """

    jumps: Array
    measured: Array
    messages: Mapping[int, str]


@dataclass(frozen=True, eq=False)
class Predictor:
    """Jumps of measured velocities, for values of unknown quantities.

    What does not depend on friction and restitution is kept.

    Attributes:
        rows: the landings.
        robot: their robot.
        unknowns: the quantities.
        measured: what was measured, only velocities.
    """

    rows: RecordedRows = field(repr=False)
    robot: Robot = field(repr=False)
    unknowns: tuple[Variation, ...]
    measured: tuple[Measured, ...] = field(repr=False)

    @functools.cached_property
    def coordinates(self) -> np.ndarray:
        """Rows of `mobilities` (k,) that the measured velocities have."""
        return np.array([coordinate(column, self.robot) for column in self.measured])

    def study(self, values: tuple[float, ...] | None) -> RecordedLandings:
        """The landings with values of the unknowns.

        Args: values (p,) in their units; None for the landings as they are given.

        Raises:
            ShockError: a value is not possible.
        """
        rows, robot, scenes = self.rows, self.robot, list(self.rows.scenes)
        for one, value in zip(
            self.unknowns, values if values is not None else (), strict=values is not None
        ):
            if one.subject == SCALE:
                before = Motion(*(value * part for part in rows.before))
                rows = rows._replace(before=before, contact_velocity=value * rows.contact_velocity)
                continue
            if one.kind.word == "friction":
                rows = rows._replace(friction=np.full(len(rows.Q), value))
            changes = [one.applied(scene, robot, value) for scene in scenes]
            scenes, robot = [scene for scene, _ in changes], changes[0][1]
        return RecordedLandings(robot, rows._replace(scenes=tuple(scenes)))

    @memoized(MOST_KNOWN)
    def __call__(self, values: tuple[float, ...] | None) -> Predicted:
        """The jumps for values (p,) of the unknowns; None for the landings as they are given."""
        scale = self.by_subject(values).get(SCALE, 1.0)
        measured = (
            np.stack([column.jump for column in self.measured], axis=1)
            + (1.0 - scale) * self._before
        )
        try:
            jumps, messages = self._jumps(self.study(values), values)
        except DefectError:
            raise
        except ShockError as error:
            jumps, messages = (
                np.full(measured.shape, np.nan),
                dict.fromkeys(range(len(measured)), str(error)),
            )
        jumps[list(messages)] = np.nan
        return Predicted(jumps, measured, messages)

    def by_subject(self, values: tuple[float, ...] | None) -> dict[str, float]:
        """The values of the unknowns by their subjects."""
        return (
            {}
            if values is None
            else {one.subject: value for one, value in zip(self.unknowns, values, strict=True)}
        )

    def _jumps(
        self, study: RecordedLandings, values: tuple[float, ...] | None
    ) -> tuple[Array, dict[int, str]]:
        stiff = study.scene.yields and self.measured[0].time is not None
        if not stiff and not np.isnan(study.table.friction).all():
            return self._with_friction(study, values)
        keys = predicting(study, friction=False)
        if stiff:
            jumps, messages = predicted_later(study, keys, self.measured)
            return np.stack(jumps, axis=1), messages
        computed = tuple({column.name: column for column in keys.values()}.values())
        table = Evaluation(
            study, computed, prove=0, max_condition=MAX_CONDITION
        ).table.without_defects()
        by_key = base_in_world(study, keys, table.columns)
        return np.stack([by_key[column.key] for column in self.measured], axis=1), dict(
            table.messages
        )

    def _with_friction(
        self, study: RecordedLandings, values: tuple[float, ...] | None
    ) -> tuple[Array, dict[int, str]]:
        """The jumps with friction.

        Only the impulses of the contacts depend on friction, restitution and scale.
        """
        by_subject, others = self.by_subject(values), {"friction": 0.0, SCALE: 1.0}
        if all(contact.kind != "flat" for scene in study.table.scenes for contact in scene.contact):
            others["restitution"] = 0.0
        problems, refused = self.problems(
            None if values is None else tuple(others.get(name, x) for name, x in by_subject.items())
        )
        jumps, messages = np.full((study.rows, len(self.measured)), np.nan), dict(refused)
        friction = np.nan_to_num(study.table.friction, nan=STICKS)
        for rows, problem, to_measured in problems:
            scaled = problem.scaled(by_subject.get(SCALE, 1.0))
            impulses, failures = scaled.impulses(friction[rows], by_subject.get("restitution"))
            jumps[rows] = (to_measured @ scaled.delta(impulses)[:, 0, :, None])[..., 0]
            messages |= {int(rows[i]): str(error) for i, error in failures.items()}
        return jumps, messages

    @memoized(MOST_PROBLEMS)
    def problems(self, values: tuple[float, ...] | None) -> Problems:
        """The landings with friction for values of the unknowns.

        They have rows (m,), their problem, and the measured velocities (m, k, ny).

        These are for unit free velocities. And why others have none.
        """
        study, problems, messages = (
            self.study(values),
            list[tuple[np.ndarray, FrictionProblem, Array]](),
            dict[int, str](),
        )
        for k, (first, _) in enumerate(study.chunks):
            for group in study.chunk(k, study.data(k)).groups:
                rows = first + group.postures
                if isinstance(group, Refusal):
                    messages |= dict.fromkeys(rows.tolist(), str(group.error))
                    continue
                block = postures(group.landing.without_stops, group.Q, ())
                equation, unclear = block.equation, list(block.solution.row_spaces)
                # Postures share a problem where no row is held rigidly; each of the others has its
                # own.
                if shared := friction_problems(block.landing, equation, equation.b[:, None, :, 3]):
                    clear = np.delete(np.arange(len(rows)), unclear)
                    problems.append(
                        (rows[clear], shared[0].part(clear), self.to_measured(equation)[clear])
                    )
                for row in rows[unclear].tolist() if shared else rows.tolist():
                    try:
                        landing = study.landing(row)
                        measured = self.to_measured(landing.equation(landing.state))
                        problems.append((np.array([row]), friction_problem(landing), measured))
                    except ShockError as error:
                        messages[row] = str(error)
        # Those of the same number of contacts are solved together.
        alike: dict[tuple[int, ...], list[tuple[np.ndarray, FrictionProblem, Array]]] = {}
        for one in problems:
            alike.setdefault((one[1].stops, *one[1].by_impulse.shape[1:]), []).append(one)
        whole = [tuple(zip(*ones, strict=True)) for ones in alike.values()]
        return [
            (np.concatenate(rows), joined(parts), np.concatenate(measured))
            for rows, parts, measured in whole
        ], messages

    def to_measured(self, equation: Equation) -> Array:
        """The measured velocities (N, k, ny) for unit free velocities in N postures."""
        rates = _velocities(self.robot, equation.state)[:, self.coordinates]
        return rates if equation.G is None else np.asarray(rates @ equation.G)

    @functools.cached_property
    def _before(self) -> Array:
        """The measured velocities (n, k) before the impact."""
        velocity, omega, rates = self.rows.before
        whole = rates.copy()
        if self.robot.free_base:
            whole[:, :6] = np.hstack([velocity, omega])
        return np.asarray(whole[:, self.coordinates])

    @functools.cached_property
    def strike_energy(self) -> Array:
        """Kinetic energy (n,) that each impact takes if it sticks: ½ v_inᵀ Λ v_in [J].

        Its contacts stick without restitution.

        It does not depend on what was measured after the impact. NaN where there is no such
        landing.
        """
        scenes = tuple(_sticking(scene) for scene in self.rows.scenes)
        rows = self.rows._replace(scenes=scenes, friction=np.full(len(self.rows.Q), np.nan))
        lost = Column(select("energy_lost"), Place(self.robot.name))
        table = Evaluation(
            RecordedLandings(self.robot, rows), (lost,), prove=0
        ).table.without_defects()
        return np.asarray(table.columns[lost.name])


def _sticking(scene: Scene) -> Scene:
    """The scene on rigid contacts that stick without restitution."""
    contact = tuple(replace(contact, restitution=0.0) for contact in scene.contact)
    return replace(scene.rigid, contact=contact, friction=None)
