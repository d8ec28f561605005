"""Predicted jumps of measured velocities for values of the unknowns."""

import functools
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple, TypeAlias

import numpy as np

from shockpc.core.memo import memoized
from shockpc.core.spatial import Array
from shockpc.evaluation.column import Column
from shockpc.evaluation.column_values import postures
from shockpc.evaluation.evaluate import MAX_CONDITION, Evaluation
from shockpc.evaluation.landings import Refusal
from shockpc.evaluation.variations.variation import Variation
from shockpc.impact.friction import FrictionProblem, friction_problem, friction_problems, joined
from shockpc.landing.places import Place
from shockpc.landing.scenes.scene import Scene
from shockpc.method.approach import Motion
from shockpc.method.equation import Equation
from shockpc.quantities.selection import select
from shockpc.robot.robot import Robot
from shockpc.text.errors import DefectError, ShockError
from shockpc.wings.recordings.logs.landings import RecordedLandings
from shockpc.wings.recordings.logs.prediction import (
    _velocities,
    base_in_world,
    coordinate,
    predicted_later,
    predicting,
)
from shockpc.wings.recordings.logs.rows import Measured, RecordedRows

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
