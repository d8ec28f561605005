"""A number on a grid of values of one quantity and of strike angles: its worst strike, and where it meets a bound."""

import functools
import itertools
from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from shockpc.core.spatial import Array
from shockpc.evaluation.columns import Column
from shockpc.evaluation.crossings import crossings, vertices
from shockpc.evaluation.evaluate import Evaluation
from shockpc.evaluation.strike_grid import StrikeGrid
from shockpc.evaluation.table import Table
from shockpc.evaluation.variation import Variation
from shockpc.landing.joint_path import JointPath
from shockpc.landing.landing import PosedLanding
from shockpc.profile import ILL_CONDITIONED
from shockpc.quantities.table import select
from shockpc.robot.robot import Joint

ANGLES = 43
"""Strike angles of a range among which the worst number is sought."""

FINER = 5
"""Strike angles of a map for each of the grid."""

BESIDE = 0.002
"""How far beside the vertex of a first parabola the strike angles of a second one are [rad], whose vertex is then off by 1e-9."""

STEPS = 3
"""Of regula falsi, which leave less than 1e-6 rad of the 0.04 rad between two strike angles."""

UNDETERMINED = "the number does not exist in this posture, or is not determined, because contacts or loops are redundant"


class Bound(NamedTuple):
    """A bound on a number; of one that may be negative on its magnitude.

    Attributes:
        value: the bound, above zero.
        below: whether it is the least value allowed, and not the greatest.
    """

    value: float
    below: bool

    @property
    def sign(self) -> float:
        """1 where greater numbers are worse, −1 where less are."""
        return -1.0 if self.below else 1.0

    def excess(self, numbers: Array) -> Array:
        """How far numbers N are beyond the bound B, ±(N − B) / (N + B) from −1 to 1: smooth where N grows without limit.

        Where there is no number it is 1.
        """
        return np.nan_to_num(self.sign * (1.0 - 2.0 * self.value / (numbers + self.value)), nan=1.0)


class StrikeScan:
    """A number on a grid of values and strike angles.

    Args:
        landing: in the scene's posture.
        target: the number; of one that may be negative the magnitude.
        bound: of the number.
        varied: what varies, without values.
        joints: that are moved, all to the same value; none where something else varies.
        values: ascending [rad, m; unit of the variation].
        scale: what a value is multiplied by for the unit of the variation.
        targets: least and greatest strike angle of the ranges that are asked of, equal for a single one, the last the widest [rad].
        fine: to which the value is found beyond which a loop cannot be closed.

    Attributes:
        values: (n,) those that can be reached [rad, m].
        angles: (S,) strike angles of the grid, ascending: the landing's and those of the targets [rad].
        numbers: (n, S); NaN without a result.
        unreachable: (least value, greatest value, reason) of the ranges in which a loop cannot be closed, or there is no result for
            the landing's strike.
        inaccurate: number of postures that are not proven, in which rounding may show above 1e-9.

    Raises:
        StudyError: no loop can be closed at any value.
    """

    def __init__(
        self,
        landing: PosedLanding,
        target: Column,
        bound: Bound,
        varied: Variation,
        joints: tuple[Joint, ...],
        values: Array,
        scale: float,
        targets: tuple[tuple[float, float], ...],
        fine: float,
    ) -> None:
        self._landing, self._target, self._bound, self._varied, self._scale = landing, target, bound, varied, scale
        self.targets, self.strikes, self.values = targets, targets[-1], values
        self._path, self._Q, unreachable = JointPath(landing, joints) if joints else None, None, list[tuple[float, float, str]]()
        if self._path is not None:
            self.values, self._Q, unreachable = self._path.along(values, fine)
        single, spread = np.unique([*(low for low, high in targets if low == high), *self.strikes]), _angles(*self.strikes)
        self.angles = np.sort([*single, *spread[np.abs(spread[:, None] - single).min(axis=1) > BESIDE]])
        feasible = Column(select("feasible"), landing.places("robot")[0])
        shape = len(self.values), len(self.angles)
        table = self._table(self.values, np.broadcast_to(self.angles, shape), (target, feasible), self._Q)
        self.numbers, self._feasible = self._read(table, shape), (table.columns[feasible.name] == 1.0).reshape(shape)
        rows = np.ravel_multi_index((np.arange(len(self.values)), self._scene_strike), shape)
        uncertain = (table.columns["condition"] > ILL_CONDITIONED) & ~table.columns["proven"]
        self.inaccurate = int((uncertain[rows] & np.isfinite(self.at_scene_strike)).sum())
        refused = {k: table.messages.get(i, UNDETERMINED) for k, i in enumerate(rows.tolist()) if np.isnan(self.at_scene_strike[k])}
        self.unreachable = tuple(sorted({*unreachable, *_ranges(self.values, refused)}))

    @property
    def _scene_strike(self) -> int:
        """Where the strike angle of the scene is among those of the grid."""
        return int(np.searchsorted(self.angles, self._landing.strike_angle))

    @property
    def at_scene_strike(self) -> Array:
        """The number (n,) for the strike of the scene; NaN without a result."""
        return self.numbers[:, self._scene_strike]

    def over(self, angles: Array) -> Array:
        """The number (n, S) in every posture at strike angles (S,) or (n, S) [rad]; NaN without a result."""
        return self._numbers(self.values, np.broadcast_to(angles, (len(self.values), np.shape(angles)[-1])), self._Q)

    def feasible(self, low: float, high: float) -> np.ndarray:
        """Whether (n,) flat ground allows the landing of every posture at all strike angles of a range of the grid [rad]."""
        return np.asarray(self._feasible[:, self._inside(low, high)].all(axis=1))

    @functools.cached_property
    def worst(self) -> tuple[Array, Array]:
        """The worst number (n,) over the range of strike angles, NaN without a result, and the strike angle (n,) of it [rad]."""
        inside = self._inside(*self.strikes)
        angles = np.broadcast_to(self.angles[inside], (len(self.values), int(inside.sum())))
        return self._worst(self.values, angles, self.numbers[:, inside], self._Q)

    def worst_at(self, values: Array, low: float, high: float) -> Array:
        """The worst number (m,) over a range of strike angles, at other values (m,) than those of the grid."""
        angles = np.tile(_angles(low, high), (len(values), 1))
        Q = self._configurations(values)
        return self._worst(values, angles, self._numbers(values, angles, Q), Q)[0]

    def map(self) -> tuple[Array, Array]:
        """Strike angles (T,) of the range and the number (n, T) there; a single one is shown as a narrow range [rad].

        Between those of the grid the square of the number is interpolated: that of a length has no kink where the length is zero.
        """
        inside = self._inside(*self.strikes)
        if inside.sum() > 1:
            angles, numbers = self.angles[inside], self.numbers[:, inside]
            finer = np.linspace(angles[0], angles[-1], FINER * len(angles))
            between = numbers[:, np.abs(angles - finer[:, None]).argmin(axis=1)]
            known = np.isfinite(numbers).all(axis=1)
            between[known] = np.sqrt(np.maximum(CubicSpline(angles, numbers[known] ** 2, axis=1)(finer), 0.0))
            return finer, between
        angles = self.strikes[0] + np.array([-BESIDE, BESIDE]) * 10.0
        return angles, self.over(angles)

    def kept(self) -> list[list[tuple[float, float]]]:
        """For every posture the intervals of strike angles of the range at which the number keeps the bound [rad].

        An interval that lies between two strike angles of the grid is not seen.
        """
        inside = self._inside(*self.strikes)
        angles, beyond = self.angles[inside], self._bound.excess(self.numbers[:, inside])
        row, roots = crossings(angles, beyond) if len(angles) > 1 else (np.zeros(0, dtype=int), np.zeros(0))
        roots = self._refined(row, roots, angles, beyond) if len(row) else roots
        intervals = []
        for flags, inner in zip(beyond <= 0.0, np.split(roots, np.searchsorted(row, np.arange(1, len(beyond)))), strict=True):
            ends = [*angles[:1][flags[:1]].tolist(), *inner.tolist(), *angles[-1:][flags[-1:]].tolist()]
            intervals.append(list(zip(ends[::2], ends[1::2], strict=True)))
        return intervals

    def _refined(self, row: np.ndarray, roots: Array, angles: Array, beyond: Array) -> Array:
        """Strike angles (k,) at which postures (k,) meet the bound, by regula falsi from a spline.

        Args:
            row: (k,) the postures.
            roots: (k,) of the spline [rad].
            angles: (S,) of the grid [rad].
            beyond: (n, S) excess over the bound there.
        """
        j = np.searchsorted(angles, roots, side="left").clip(1) - 1
        (low, high), (under, over) = (angles[j], angles[j + 1]), (beyond[row, j], beyond[row, j + 1])
        for _ in range(STEPS):
            numbers = self._numbers(self.values[row], roots[:, None], None if self._Q is None else self._Q[row])
            there = self._bound.excess(numbers[:, 0])
            first = (there <= 0.0) == (under <= 0.0)
            low, under = np.where(first, roots, low), np.where(first, there, under)
            high, over = np.where(first, high, roots), np.where(first, over, there)
            roots = low - under * (high - low) / (over - under)
        return np.asarray(roots)

    def _inside(self, low: float, high: float) -> np.ndarray:
        return np.asarray((self.angles >= low) & (self.angles <= high))

    def _worst(self, values: Array, angles: Array, numbers: Array, Q: Array | None) -> tuple[Array, Array]:
        """As `worst`, from numbers (m, S) at ascending strike angles (m, S): the vertex of a parabola, twice."""
        row, missing = np.arange(len(values)), np.isnan(numbers).any(axis=1)
        low, high = angles[:, :1], angles[:, -1:]
        for beside in (BESIDE, 0.0) if angles.shape[1] > 2 else ():
            best = np.clip(self._most(numbers), 1, angles.shape[1] - 2)[:, None] + np.arange(-1, 2)
            middle = vertices(np.take_along_axis(angles, best, 1), np.take_along_axis(numbers, best, 1))
            nearby = np.clip(middle[:, None] + beside * np.arange(-1, 2 if beside else 0), low, high)
            angles, numbers = np.hstack([angles, nearby]), np.hstack([numbers, self._numbers(values, nearby, Q)])
            order = np.argsort(angles, axis=1, kind="stable")
            angles, numbers = np.take_along_axis(angles, order, 1), np.take_along_axis(numbers, order, 1)
        best = self._most(numbers)
        return np.where(missing, np.nan, numbers[row, best]), angles[row, best]

    def _most(self, numbers: Array) -> np.ndarray:
        """Indices (m,) of the worst among numbers (m, S)."""
        return np.asarray(np.argmax(np.nan_to_num(self._bound.sign * numbers, nan=-np.inf), axis=1))

    def at(self, wanted: list[Array]) -> list[Array]:
        """The worst number over each of the targets' strikes, at values (m,) of that quantity, as wanted."""
        single = [k for k, (low, high) in enumerate(self.targets) if low == high]
        values = np.concatenate([wanted[k] for k in single])
        angles = np.concatenate([np.full(len(wanted[k]), self.targets[k][0]) for k in single])
        numbers = self._numbers(values, angles[:, None], self._configurations(values))[:, 0]
        known = dict(zip(single, np.split(numbers, np.cumsum([len(wanted[k]) for k in single[:-1]])), strict=True))
        return [known[k] if k in known else self.worst_at(wanted[k], *strikes) for k, strikes in enumerate(self.targets)]

    def _numbers(self, values: Array, angles: Array, Q: Array | None) -> Array:
        """The number (m, S) at values (m,) and strike angles (m, S) [rad]; NaN without a result."""
        return self._read(self._table(values, angles, (self._target,), Q), angles.shape) if len(values) else np.zeros(angles.shape)

    def _read(self, table: Table, shape: tuple[int, ...]) -> Array:
        numbers = np.reshape(table.values(self._target), shape)
        return np.abs(numbers) if self._target.selection.signed else numbers

    def _table(self, values: Array, angles: Array, computed: tuple[Column, ...], Q: Array | None) -> Table:
        varied = replace(self._varied, values=tuple((self._scale * values).tolist()))
        grid = StrikeGrid(self._landing, varied, angles, Q)
        feasible = (select("feasible"),)
        return Evaluation(grid, computed, prove=0, trusted=ILL_CONDITIONED, elsewhere=feasible).table().without_defects()

    def _configurations(self, values: Array) -> Array | None:
        """The configurations (m, nq) with the joint at values (m,), followed from the nearest of the grid."""
        if self._path is None or self._Q is None:
            return None
        return self._path.at(values, self._Q[np.argmin(np.abs(self.values - values[:, None]), axis=1)])


def _angles(low: float, high: float) -> Array:
    """The strike angles of a range that are computed [rad]."""
    return np.linspace(low, high, ANGLES) if high > low else np.array([low])


def _ranges(values: Array, refused: dict[int, str]) -> Iterator[tuple[float, float, str]]:
    """The ranges of consecutive postures without a result, with the first one's reason."""
    for first in sorted(refused.keys() - {k + 1 for k in refused}):
        last = next(k for k in itertools.count(first) if k + 1 not in refused)
        yield float(values[first]), float(values[last]), refused[first]
