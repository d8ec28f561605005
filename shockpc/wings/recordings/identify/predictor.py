"""Predicted jumps of measured velocities for values of the unknowns."""

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from shockpc.core.memo import memoized
from shockpc.core.spatial import Array
from shockpc.evaluation.column import Column
from shockpc.evaluation.column_values import postures
from shockpc.evaluation.evaluate import MAX_CONDITION, Evaluation
from shockpc.evaluation.landings import Group, Refusal
from shockpc.evaluation.variations.variation import Variation
from shockpc.impact.friction import (
    FrictionProblem,
    friction_problem,
    friction_problems,
    joined_problems,
)
from shockpc.landing.places import Place
from shockpc.landing.scenes.scene import Scene
from shockpc.method.approach import Motion
from shockpc.method.equation import Equation
from shockpc.quantities.selection import select
from shockpc.robot.robot import Robot
from shockpc.text.errors import DefectError, ShockError
from shockpc.wings.recordings.tables.landings import RecordedLandings
from shockpc.wings.recordings.tables.prediction import (
    base_in_world,
    coordinate,
    predicted_later,
    predicting,
    velocities_of_rates,
)
from shockpc.wings.recordings.tables.rows import Measured, RecordedRows

SCALE = "scale:before"
"""An unknown: the factor by which the velocities before the impact were measured too small."""

MOST_PROBLEMS = 16
"""Values of all but friction, restitution and scale of which what does not depend on these is kept.
"""

MOST_KNOWN = 500
"""Values of which the predictions are kept."""

STICKS = 1e9
"""Friction of rows without one, beside rows with friction."""


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


class FrictionRows(NamedTuple):
    """Landings of a table that are one problem of friction.

    Attributes:
        rows: (m,) their numbers.
        problem: of their impulses.
        to_measured: (m, k, ny) measured velocities for unit free velocities.
    """

    rows: np.ndarray
    problem: FrictionProblem
    to_measured: Array


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
        rows = self.rows
        if values is None:
            return RecordedLandings(self.robot, rows)
        robot = self.robot
        scenes = list(rows.scenes)
        for unknown, value in zip(self.unknowns, values, strict=True):
            if unknown.subject == SCALE:
                before = Motion(*(value * part for part in rows.before))
                rows = rows._replace(before=before, contact_velocity=value * rows.contact_velocity)
                continue
            if unknown.kind.word == "friction":
                rows = rows._replace(friction=np.full(len(rows.Q), value))
            changes = [unknown.applied(scene, robot, value) for scene in scenes]
            scenes = [scene for scene, _ in changes]
            robot = changes[0][1]
        return RecordedLandings(robot, rows._replace(scenes=tuple(scenes)))

    @memoized(MOST_KNOWN)
    def __call__(self, values: tuple[float, ...] | None) -> Predicted:
        """The jumps for values (p,) of the unknowns; None for the landings as they are given."""
        scale = self.by_subject(values).get(SCALE, 1.0)
        jumps_in_table = np.stack([column.jump for column in self.measured], axis=1)
        measured = jumps_in_table + (1.0 - scale) * self._before
        try:
            jumps, messages = self._jumps(self.study(values), values)
        except DefectError:
            raise
        except ShockError as error:
            jumps = np.full(measured.shape, np.nan)
            messages = dict.fromkeys(range(len(measured)), str(error))
        jumps[list(messages)] = np.nan
        return Predicted(jumps, measured, messages)

    def by_subject(self, values: tuple[float, ...] | None) -> dict[str, float]:
        """The values of the unknowns by their subjects."""
        if values is None:
            return {}
        subjects = [unknown.subject for unknown in self.unknowns]
        return dict(zip(subjects, values, strict=True))

    def _jumps(
        self, study: RecordedLandings, values: tuple[float, ...] | None
    ) -> tuple[Array, dict[int, str]]:
        """The jumps (n, k), and why rows have none."""
        stiff = study.scene.yields and self.measured[0].time is not None
        if not stiff and not np.isnan(study.table.friction).all():
            return self._with_friction(study, values)
        keys = predicting(study, friction=False)
        if stiff:
            jumps, messages = predicted_later(study, keys, self.measured)
            return np.stack(jumps, axis=1), messages
        columns = {column.name: column for column in keys.values()}
        evaluation = Evaluation(
            study, tuple(columns.values()), prove=0, max_condition=MAX_CONDITION
        )
        table = evaluation.table.without_defects()
        by_key = base_in_world(study, keys, table.columns)
        stacked = np.stack([by_key[column.key] for column in self.measured], axis=1)
        return stacked, dict(table.messages)

    def _with_friction(
        self, study: RecordedLandings, values: tuple[float, ...] | None
    ) -> tuple[Array, dict[int, str]]:
        """The jumps with friction.

        Only the impulses of the contacts depend on friction, restitution and scale.
        """
        by_subject = self.by_subject(values)
        problems, refused = self.problems(self._without_impulses(study, values))
        jumps = np.full((study.rows, len(self.measured)), np.nan)
        messages = dict(refused)
        friction = np.nan_to_num(study.table.friction, nan=STICKS)
        for rows, problem, to_measured in problems:
            scaled = problem.scaled(by_subject.get(SCALE, 1.0))
            impulses, failures = scaled.impulses(friction[rows], by_subject.get("restitution"))
            delta = scaled.delta(impulses)[:, 0, :, None]
            jumps[rows] = (to_measured @ delta)[..., 0]
            for i, error in failures.items():
                messages[int(rows[i])] = str(error)
        return jumps, messages

    def _without_impulses(
        self, study: RecordedLandings, values: tuple[float, ...] | None
    ) -> tuple[float, ...] | None:
        """The values, with one number for those on which only impulses depend."""
        if values is None:
            return None
        same = {"friction": 0.0, SCALE: 1.0}
        kinds = {contact.kind for scene in study.table.scenes for contact in scene.contact}
        if "flat" not in kinds:
            same["restitution"] = 0.0
        by_subject = self.by_subject(values)
        return tuple(same.get(subject, value) for subject, value in by_subject.items())

    @memoized(MOST_PROBLEMS)
    def problems(
        self, values: tuple[float, ...] | None
    ) -> tuple[list[FrictionRows], dict[int, str]]:
        """The problems of the landings with friction for values of the unknowns.

        And why other landings have none, by row.
        """
        study = self.study(values)
        problems: list[FrictionRows] = []
        messages: dict[int, str] = {}
        for k, (first, _) in enumerate(study.chunks):
            for group in study.chunk(k, study.data(k)).groups:
                rows = first + group.postures
                if isinstance(group, Refusal):
                    messages |= dict.fromkeys(rows.tolist(), str(group.error))
                    continue
                shared, unclear = self._shared_problem(group, rows)
                problems += shared
                for row in unclear:
                    try:
                        problems.append(self._single_problem(study, row))
                    except ShockError as error:
                        messages[row] = str(error)
        # Those of the same number of contacts are solved together.
        alike: dict[tuple[int, ...], list[FrictionRows]] = {}
        for single in problems:
            shape = single.problem.by_impulse.shape[1:]
            alike.setdefault((single.problem.stops, *shape), []).append(single)
        return [_joined(parts) for parts in alike.values()], messages

    def _shared_problem(
        self, group: Group, rows: np.ndarray
    ) -> tuple[list[FrictionRows], list[int]]:
        """The one problem of a group's rows, if there is one; and the rows that are not in it.

        Postures share a problem where no row is held rigidly; each of the others has its own.
        """
        results = postures(group.landing.without_stops, group.Q, ())
        equation = results.equation
        shared = friction_problems(results.landing, equation, equation.b[:, None, :, 3])
        if not shared:
            return [], rows.tolist()
        unclear = list(results.solution.row_spaces)
        clear = np.delete(np.arange(len(rows)), unclear)
        to_measured = self.to_measured(equation)[clear]
        problem = FrictionRows(rows[clear], shared[0].part(clear), to_measured)
        return [problem], rows[unclear].tolist()

    def _single_problem(self, study: RecordedLandings, row: int) -> FrictionRows:
        """The problem of one row."""
        landing = study.landing(row)
        to_measured = self.to_measured(landing.equation(landing.state))
        return FrictionRows(np.array([row]), friction_problem(landing), to_measured)

    def to_measured(self, equation: Equation) -> Array:
        """The measured velocities (N, k, ny) for unit free velocities in N postures."""
        rates = velocities_of_rates(self.robot, equation.state)[:, self.coordinates]
        return rates if equation.G is None else np.asarray(rates @ equation.G)

    @functools.cached_property
    def _before(self) -> Array:
        """The measured velocities (n, k) before the impact."""
        velocity, omega, rates = self.rows.before
        velocities = rates.copy()
        if self.robot.free_base:
            velocities[:, :6] = np.hstack([velocity, omega])
        return np.asarray(velocities[:, self.coordinates])

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


def _joined(parts: Sequence[FrictionRows]) -> FrictionRows:
    """Problems of the same number of contacts as one."""
    return FrictionRows(
        np.concatenate([part.rows for part in parts]),
        joined_problems([part.problem for part in parts]),
        np.concatenate([part.to_measured for part in parts]),
    )
