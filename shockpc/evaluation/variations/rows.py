"""Landings that differ from one, on a grid, in a random sample, or as given.

A row has a value of everything that varies: of a grid, of a draw, or one that is given, in which
NaN leaves a thing as it is. Rows are grouped by what needs a landing of its own: contacts, ground
and places, and the posture where loops have to be closed. The rows of a group are arrays:
configurations, inertias and strikes.
"""

import functools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np

from shockpc.core.spatial import Array
from shockpc.evaluation.landings import GROUP, ROWS, Chunk, Group, Refusal
from shockpc.evaluation.variations.row_arrays import RowInertias, RowPostures, RowStrikes
from shockpc.evaluation.variations.row_scenes import RowScenes, definite_scene
from shockpc.evaluation.variations.row_values import (
    RowValues,
    equal_rows,
    grid_values,
    of_row,
    sample_values,
)
from shockpc.evaluation.variations.variation import Variation, prepared
from shockpc.landing.landing import PosedLanding
from shockpc.landing.scenes.scene import Scene
from shockpc.landing.scenes.strike import Strike
from shockpc.method.dynamics import Inertias
from shockpc.profile import profile_of_scene
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.robot.robot import Robot
from shockpc.text.errors import ShockError, attempt

FEWEST_ROWS = 1024
"""Largest number of rows of a chunk whose rows take long."""


@dataclass(frozen=True, eq=False)
class VariedLandings:
    """Landings that differ from one, on a grid or in a sample.

    Attributes:
        scene: the landing that is varied.
        robot: its robot.
        variations: what differs between rows.
        sample: number of random rows; None for the full grid.
        lhs: whether they are a Latin hypercube.
        seed: of the random numbers.
        rows_given: (sample, v) values of the rows, in the order of the variations, in place of
            random ones; NaN where a row has what the scene has.
        struck: strikes of each posture of a sample by name; by default the scene's, or one that
            varies.
    """

    scene: Scene
    robot: Robot = field(repr=False)
    variations: tuple[Variation, ...]
    sample: int | None = None
    lhs: bool = False
    seed: int = 0
    rows_given: Array | None = field(default=None, repr=False)
    struck: Mapping[str, Strike] = field(default_factory=dict, repr=False)

    noun = "sweep"
    extra_headings = ()

    def __post_init__(self) -> None:
        """Resolve where the contacts strike, in the posture of the scene, unless they vary."""
        scene = prepared(self.scene, self.variations)
        if not any(varied.kind.names_contacts for varied in self.variations):
            scene = definite_scene(scene, self.robot)
        object.__setattr__(self, "scene", scene)

    def __getstate__(self) -> dict[str, Any]:
        return {part.name: getattr(self, part.name) for part in fields(self)}

    @functools.cached_property
    def axes(self) -> tuple[Variation, ...]:
        """The variations from the slowest to the fastest, by `Kind.stage`."""
        return tuple(sorted(self.variations, key=lambda variation: variation.stage))

    @functools.cached_property
    def scenes(self) -> RowScenes:
        """Scene and robot of each row."""
        return RowScenes(self.scene, self.robot, self.axes, tuple(self.struck.values()))

    @property
    def first(self) -> PosedLanding:
        """The first of all landings."""
        return self.scenes.first

    @property
    def separate(self) -> bool:
        """True if loops have to be closed, so that each posture needs a landing of its own."""
        return self.scenes.separate

    @property
    def strikes(self) -> int:
        """Number of strikes for each posture; one that a sample varies differs from row to row."""
        if self.sample is not None:
            return len(self.struck) or 1
        return math.prod(len(varied.values) for varied in self.axes if varied.stage == 2)

    @property
    def solves(self) -> int:
        """Number of postures of all landings."""
        if self.sample is not None:
            return self.sample
        return math.prod(len(varied.values) for varied in self.axes if varied.stage < 2)

    @property
    def rows(self) -> int:
        """Number of rows."""
        return self.solves * self.strikes

    @functools.cached_property
    def chunks(self) -> tuple[tuple[int, int], ...]:
        """First and last posture of every chunk, the last one excluded.

        They do not depend on who computes them.
        """
        n = self.solves
        postures = max(1, self._rows_of_a_chunk // self.strikes)
        count = -(-n // postures)
        chunks = []
        for k in range(count):
            begin, end = n * k // count, n * (k + 1) // count
            chunks.append((begin, end))
        return tuple(chunks)

    @property
    def _rows_of_a_chunk(self) -> int:
        """Largest number of rows of a chunk: fewer of large robots, and of separate landings."""
        numeric = [varied for varied in self.axes if not varied.kind.names_contacts]
        of_landings = any(varied.stage == 0 for varied in numeric)
        if self.separate or (self.sample is not None and of_landings):
            return FEWEST_ROWS
        nv: int = self.robot.model.nv
        return min(ROWS, max(FEWEST_ROWS, 2**25 // nv**2))

    @property
    def description(self) -> dict[str, Any]:
        """The variations and the numbers of a sample, on which rows depend."""
        keys = ("subject", "values", "span", "law", "factor")
        vary = []
        for varied in self.variations:
            vary.append({key: getattr(varied, key) for key in keys})
        return {
            "vary": vary,
            "sample": self.sample,
            "lhs": self.lhs,
            "seed": self.seed,
        }

    @property
    def headings(self) -> tuple[str, ...]:
        """The headings of what varies."""
        return tuple(variation.column for variation in self.variations)

    @property
    def opens(self) -> bool:
        """True if a contact that would be pulled opens, because there is friction."""
        return self.base_scene.friction is not None

    @property
    def base_scene(self) -> Scene:
        """The first landing, which also has a friction or a contact stiffness that varies."""
        return self.first.scene

    def compared(self, count: int) -> np.ndarray:
        """Random rows (n,), at most so many."""
        generator = np.random.default_rng([self.seed, 2])
        size = min(count, self.rows)
        return generator.choice(self.rows, size, replace=False, shuffle=False)

    def data(self, k: int) -> None:
        """Nothing: the rows of a chunk follow from its number."""

    def at(self, values: Array) -> "VariedLandings":
        """Landings with these values (n, v), the rest as in these."""
        landings = replace(self, rows_given=values, sample=len(values))
        # Neither the first landing nor how loops are closed depends on the values.
        vars(landings)["scenes"] = self.scenes
        return landings

    def resolved(self) -> tuple[Array, Array]:
        """Configurations (n, nq) and strikes (n, S, 3) of all postures, if of one landing."""
        Q: list[Array] = []
        strikes: list[Array] = []
        for k, (begin, end) in enumerate(self.chunks):
            values = self._values(k)
            rows = np.arange(end - begin)
            Q.append(self._postures(self.first, values, rows))
            strikes.append(self._strikes(self.first, values, rows))
        return np.concatenate(Q), np.concatenate(strikes)

    def case(self, row: int) -> tuple[Scene, Robot]:
        """The landing of one row, as `profile_of_scene` takes it.

        Raises:
            ShockError: there is no such landing.
        """
        return self.scenes.case(self.values_of(row), row % self.strikes)

    def values_of(self, row: int) -> dict[Variation, Any]:
        """The values of one row, by what varies."""
        posture, strike = divmod(row, self.strikes)
        chunk = next(k for k, (_, end) in enumerate(self.chunks) if posture < end)
        begin, _ = self.chunks[chunk]
        return of_row(self._values(chunk), posture - begin, strike)

    def chunk(self, k: int, data: None) -> Chunk:
        """The postures of a chunk, grouped by what needs a separate landing."""
        begin, end = self.chunks[k]
        strikes = self.strikes
        values = self._values(k)
        labels = {}
        for varied in self.variations:
            of_rows = np.broadcast_to(values[varied], (end - begin, strikes))
            labels[varied.column] = of_rows.ravel()

        def profile(i: int) -> ShockProfile:
            posture, strike = divmod(i, strikes)
            case = self.scenes.case(of_row(values, posture, strike), strike)
            return profile_of_scene(*case)

        return Chunk(labels, self._groups(values, end - begin), profile)

    def _groups(self, values: RowValues, m: int) -> "Iterator[Group | Refusal]":
        for chosen, landing in self._landings(values, m):
            if isinstance(landing, ShockError):
                yield Refusal(chosen, landing)
                continue
            for begin in range(0, len(chosen), GROUP):
                rows = chosen[begin : begin + GROUP]
                of_rows, refused = self._inertias(landing, values, rows)
                for i, error in refused.items():
                    yield Refusal(rows[i : i + 1], error)
                Q = self._postures(landing, values, rows)
                strikes = self._strikes(landing, values, rows)
                yield Group(rows, landing, Q, strikes, of_rows)

    def _values(self, k: int) -> RowValues:
        """The values of a chunk."""
        begin, end = self.chunks[k]
        if self.sample is None:
            return grid_values(self.axes, np.arange(begin, end), self.strikes)
        if self.rows_given is not None:
            columns = self.rows_given[begin:end].T
            return {
                varied: column[:, None]
                for varied, column in zip(self.variations, columns, strict=True)
            }
        rows = np.arange(begin, end)
        return sample_values(self.axes, k, rows, self.sample, self.seed, self.lhs)

    def _landings(
        self, values: RowValues, m: int
    ) -> "Iterator[tuple[np.ndarray, PosedLanding | ShockError]]":
        """The postures (m,) of a chunk in groups, each with their landing, or the error."""
        separate: dict[Variation, np.ndarray] = {}
        for varied, x in values.items():
            # `separate` is asked only where a posture varies: the first landing may not exist.
            if varied.stage == 0 or (varied.moves and self.separate):
                separate[varied] = x[:, 0]
        if not separate:
            yield np.arange(m), self.first
            return
        for group in equal_rows(list(separate.values())):
            of_group = {varied: x[group[0]] for varied, x in separate.items()}
            yield group, attempt(self.scenes.landing, of_group)

    def _postures(self, landing: PosedLanding, values: RowValues, rows: np.ndarray) -> Array:
        """Configurations (n, nq) of rows of a chunk; the landing's if loops have to be closed."""
        postures = RowPostures(landing, len(rows))
        for varied, x in values.items():
            if varied.moves and not self.separate:
                of_rows = x[rows, 0].astype(float)
                varied.kind.set_posture(varied, postures, varied.in_radians(of_rows))
        return postures.configurations()

    def _inertias(
        self, landing: PosedLanding, values: RowValues, rows: np.ndarray
    ) -> tuple[Inertias | None, dict[int, ShockError]]:
        """The inertias of some rows of a chunk, None if all have the landing's.

        And by row the error if no robot has its inertias.
        """
        varying: dict[Variation, Array] = {}
        for varied, x in values.items():
            if not varied.kind.inertial:
                continue
            of_rows = x[rows, 0].astype(float)
            # Derivatives by hundreds of masses change few of them in the group of a posture.
            if not np.isnan(of_rows).all():
                varying[varied] = of_rows
        if not varying:
            return None, {}
        of_landing = RowInertias(landing, len(rows))
        for varied, of_rows in varying.items():
            varied.kind.set_inertia(varied, of_landing, of_rows)
        of_robots, possible = of_landing.inertias()
        refused: dict[int, ShockError] = {}
        for i in np.flatnonzero(~possible).tolist():
            try:
                self.scenes.case({varied: x[i] for varied, x in varying.items()})
            except ShockError as error:
                refused[i] = error
        return of_robots, refused

    def _strikes(self, landing: PosedLanding, values: RowValues, rows: np.ndarray) -> Array:
        """Velocities (n, S, 3) of the base before the impact in some rows of a chunk [m/s]."""
        varying = {varied: x for varied, x in values.items() if varied.stage == 2}
        velocity = landing.before.velocity
        if varying:
            strikes = RowStrikes(landing)
            for varied, x in varying.items():
                # On a grid all postures have the same strikes.
                of_rows = x if self.sample is None else x[rows]
                varied.kind.set_strike(strikes, varied.in_radians(of_rows))
            velocity = strikes.velocities()
        elif len(self.struck) > 1:
            velocity = np.array([strike.vector(landing.plane) for strike in self.struck.values()])
        return np.broadcast_to(velocity, (len(rows), self.strikes, 3))
