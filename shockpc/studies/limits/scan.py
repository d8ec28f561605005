"""A number on the rows of a sweep over one quantity and the strike angle: its worst strike, and where it meets a bound.

What lies between the strike angles and the values of the rows is computed too: where parabolas have a vertex, and where lines or
splines meet the bound.
"""

import functools
import itertools
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from shockpc.core.spatial import Array
from shockpc.evaluation.columns import Column, ground_columns
from shockpc.evaluation.evaluate import Evaluation
from shockpc.evaluation.table import Table
from shockpc.evaluation.varied import VariedLandings, varied_landings
from shockpc.landing.landing import PosedLanding
from shockpc.profile import ILL_CONDITIONED
from shockpc.quantities.selection import select

ANGLES = 43
"""Strike angles of a range that are computed."""

FINER = 5
"""Strike angles of a map for each of those that are computed."""

LEAST = 33
"""Values of a scan, at least."""

ROUNDS = 6
"""How often values are added to a scan where its spline meets the bound, at most; two or three times are usual, and where
branches meet in an extremum it would go on for long."""

NEAR = 0.002
"""How far beside the vertex of a first parabola the strike angles of a second one are [rad], whose vertex is then off by 1e-9."""

STEPS = 7
"""Of regula falsi, in which an end that stays counts half: they leave less than 1e-8 rad between two strike angles (Illinois)."""

HALVINGS = 10
"""Of the step beyond whose last value a loop cannot be closed."""

BESIDE = 0.02
"""How far a map goes beside a single strike angle, which has no width [rad]."""

UNDETERMINED = "the number does not exist in this posture, or is not determined, because contacts or loops are redundant"


class Bound(NamedTuple):
    """A bound on a number; of one that may be negative on its magnitude.

    Attributes:
        value: the bound, above zero.
        below: whether it is the smallest value allowed, and not the largest.
    """

    value: float
    below: bool

    @property
    def sign(self) -> float:
        """1 where greater numbers are worse, −1 where less are."""
        return -1.0 if self.below else 1.0

    def violation(self, numbers: Array) -> Array:
        """How far numbers N are beyond the bound B, ±(N² − B²) / (N² + B²) from −1 to 1: smooth at zero and where N has a pole.

        Where there is no number it is 1.
        """
        with np.errstate(over="ignore"):
            return np.nan_to_num(self.sign * (1.0 - 2.0 / (1.0 + (numbers / self.value) ** 2)), nan=1.0)


class LimitScan:
    """A number on the rows of a sweep over values of one quantity and strike angles.

    Args:
        landing: that varies.
        subject: what varies, as of a sweep.
        target: the number; of one that may be negative the magnitude.
        bound: of the number.
        values: ascending [rad, m; unit of the variation].
        scale: what a value is multiplied by for the unit of the variation.
        targets: minimum and maximum strike angle of the ranges asked of, equal for a single one, the last the widest [rad].

    Attributes:
        values: (n,) of the scan; of loops they end where these can no longer be closed [rad, m].
        angles: (S,) strike angles, ascending: the landing's and those of the targets [rad].
        numbers: (n, S); NaN without a result.
        unreachable: (smallest value, largest value, reason) of the ranges in which there is no result for the landing's strike.
        inaccurate: number of postures that are not proven, in which rounding may show above 1e-9.

    Raises:
        ShockError: a value is not possible.
    """

    def __init__(
        self,
        landing: PosedLanding,
        subject: str,
        target: Column,
        bound: Bound,
        values: Array,
        scale: float,
        targets: tuple[tuple[float, float], ...],
    ) -> None:
        self._target, self._bound, self._scale = target, bound, scale
        self.targets, self.strikes, self.values = targets, targets[-1], values
        single = np.unique([*(low for low, high in targets if low == high), *self.strikes])
        spread = np.linspace(*self.strikes, ANGLES)
        self.angles = np.sort([*single, *spread[np.abs(spread[:, None] - single).min(axis=1) > 1e-3]])
        self._scene_strike = int(np.searchsorted(self.angles, landing.strike_angle))
        vary = [(subject, scale * values), ("strike-angle", np.degrees(self.angles))]
        self._sweep = varied_landings(landing.scene, vary, robot=landing.robot)
        shape = len(values), len(self.angles)
        table = self._table(self._sweep, (target, *ground_columns(landing)))
        self.numbers, self._feasible = self._read(table).reshape(shape), table.feasible.reshape(shape)
        rows = np.ravel_multi_index((np.arange(len(values)), self._scene_strike), shape)
        missing = np.isnan(self.at_scene_strike)
        uncertain = (table.columns["condition"] > ILL_CONDITIONED) & ~table.columns["proven"]
        self.inaccurate = int((uncertain[rows] & np.isfinite(self.at_scene_strike)).sum())
        refused = {k: table.messages.get(int(rows[k]), UNDETERMINED) for k in np.flatnonzero(missing).tolist()}
        self.unreachable = tuple(_ranges(values, refused))
        if landing.loops and not missing.all():
            self._end(missing)

    def _end(self, missing: np.ndarray) -> None:
        """Let the scan end with the last values at which loops can be closed. Args: missing (n,), where they cannot."""
        first, last = np.flatnonzero(~missing)[[0, -1]].tolist()
        ends = [(k, beyond) for k, beyond in ((first, first - 1), (last, last + 1)) if 0 <= beyond < len(missing)]
        added, like = list[float](), list[int]()
        for k, beyond in ends:
            good, bad = float(self.values[k]), float(self.values[beyond])
            for _ in range(HALVINGS):
                middle = (good + bad) / 2.0
                closed = np.isfinite(self._at(np.array([middle]), self.angles[[self._scene_strike]]))[0]
                good, bad = (middle, bad) if closed else (good, middle)
            if good != self.values[k]:
                added.append(good)
                like.append(k)
        values = np.concatenate([self.values[first : last + 1], added])
        order, inside = np.argsort(values), np.arange(first, last + 1)
        self.numbers = np.concatenate([self.numbers[inside], *([self._over(np.array(added))] if added else [])])[order]
        self._feasible = self._feasible[[*inside, *like]][order]
        self.values = values[order]

    @property
    def at_scene_strike(self) -> Array:
        """The number (n,) for the strike of the scene; NaN without a result."""
        return self.numbers[:, self._scene_strike]

    def over(self, angles: Array) -> Array:
        """The number (n, S) in every posture at other strike angles (S,) [rad]; NaN without a result."""
        return self._over(self.values, angles)

    def feasible(self, low: float, high: float) -> np.ndarray:
        """Whether (n,) flat ground allows the landing of every posture at all strike angles of a range of the scan [rad]."""
        return np.asarray(self._feasible[:, self._inside(low, high)].all(axis=1))

    def feasible_runs(self, low: float, high: float) -> tuple[tuple[float, float], ...]:
        """The first and last value of each run of feasible ones. Args: as for `feasible`."""
        change = np.flatnonzero(np.diff(np.concatenate([[False], self.feasible(low, high), [False]])))
        return tuple(zip(self.values[change[::2]].tolist(), self.values[change[1::2] - 1].tolist(), strict=True))

    @functools.cached_property
    def worst(self) -> tuple[Array, Array]:
        """The worst number (n,) over the range of strike angles, NaN without a result, and the strike angle (n,) of it [rad]."""
        return self._worst(self.values, self.numbers)

    def map(self) -> tuple[Array, Array]:
        """Strike angles (T,) of the range and the number (n, T) there; a single one is shown as a narrow range [rad].

        Between those of the scan the square of the number is interpolated: that of a length has no kink where the length is zero.
        """
        inside = self._inside(*self.strikes)
        if inside.sum() > 1:
            angles, numbers = self.angles[inside], self.numbers[:, inside]
            finer = np.linspace(angles[0], angles[-1], FINER * len(angles))
            between = numbers[:, np.abs(angles - finer[:, None]).argmin(axis=1)]
            known = np.isfinite(numbers).all(axis=1)
            between[known] = np.sqrt(np.maximum(CubicSpline(angles, numbers[known] ** 2, axis=1)(finer), 0.0))
            return finer, between
        angles = self.strikes[0] + np.array([-BESIDE, BESIDE])
        return angles, self.over(angles)

    def kept(self) -> list[list[tuple[float, float]]]:
        """For every posture the intervals of strike angles of the range at which the number keeps the bound [rad].

        An interval that lies between two strike angles of the scan is not seen.
        """
        inside = self._inside(*self.strikes)
        angles, beyond = self.angles[inside], self._bound.violation(self.numbers[:, inside])
        row, k = np.nonzero((beyond[:, 1:] <= 0.0) != (beyond[:, :-1] <= 0.0))
        (low, high), (under, over) = (angles[k], angles[k + 1]), (beyond[row, k], beyond[row, k + 1])
        stayed = roots = np.zeros(len(row))
        for _ in range(STEPS if len(row) else 0):
            roots = low - under * (high - low) / (over - under)
            there = self._bound.violation(self._at(self.values[row], roots))
            first = (there <= 0.0) == (under <= 0.0)
            under, over = under / np.where(stayed < 0.0, 2.0, 1.0), over / np.where(stayed > 0.0, 2.0, 1.0)
            low, under = np.where(first, roots, low), np.where(first, there, under)
            high, over = np.where(first, high, roots), np.where(first, over, there)
            stayed = np.where(first, 1.0, -1.0)
        intervals = []
        for flags, inner in zip(beyond <= 0.0, np.split(roots, np.searchsorted(row, np.arange(1, len(beyond)))), strict=True):
            ends = [*angles[:1][flags[:1]].tolist(), *inner.tolist(), *angles[-1:][flags[-1:]].tolist()]
            intervals.append(list(zip(ends[::2], ends[1::2], strict=True)))
        return intervals

    def _inside(self, low: float, high: float) -> np.ndarray:
        return np.asarray((self.angles >= low) & (self.angles <= high))

    def _worst(self, values: Array, numbers: Array) -> tuple[Array, Array]:
        """As `worst`, at values (m,) with numbers (m, S): at the vertex of a parabola, twice."""
        inside = self._inside(*self.strikes)
        known = np.flatnonzero(~np.isnan(numbers[:, inside]).any(axis=1))
        worst, at = np.full(len(values), np.nan), np.full(len(values), self.strikes[0])
        angles, numbers, row = np.tile(self.angles[inside], (len(known), 1)), numbers[np.ix_(known, inside)], np.arange(len(known))
        for beside in (NEAR * np.arange(-1, 2), np.zeros(1)) if inside.sum() > 2 and len(known) else ():
            beyond = self._bound.violation(numbers)
            three = np.clip(np.argmax(beyond, axis=1), 1, angles.shape[1] - 2)[:, None] + np.arange(-1, 2)
            vertex = _vertices(np.take_along_axis(angles, three, 1), np.take_along_axis(beyond, three, 1))
            nearby = np.clip(vertex[:, None] + beside, *self.strikes)
            there = self._at(np.repeat(values[known], len(beside)), nearby.ravel()).reshape(nearby.shape)
            angles, numbers = np.hstack([angles, nearby]), np.hstack([numbers, there])
            order = np.argsort(angles, axis=1, kind="stable")
            angles, numbers = np.take_along_axis(angles, order, 1), np.take_along_axis(numbers, order, 1)
        best = np.argmax(self._bound.violation(numbers), axis=1)
        worst[known], at[known] = numbers[row, best], angles[row, best]
        return worst, at

    def limited(self, fine: float) -> tuple[Array, list[Array]]:
        """Values (m,) and the worst number (m,) over each of the targets, close enough for limits to `fine`.

        Values are added where the spline of the excess meets the bound, at extrema that could reach it, and at the best of all
        values and of those that are feasible, until all are known.
        """
        x, numbers = self.values, self._by_target(self.numbers, self.worst[0])
        runs = [self.feasible_runs(*strikes) for strikes in self.targets]
        for _ in range(ROUNDS):
            beyond = map(self._bound.violation, numbers)
            places = (still_to_compute(x, y, within(x, of_target), fine) for y, of_target in zip(beyond, runs, strict=True))
            wanted = np.unique(np.concatenate(list(places)))
            wanted = wanted[np.diff(wanted, prepend=-np.inf) > fine]
            if not len(wanted):
                break
            more = self._over(wanted)
            added = self._by_target(more, self._worst(wanted, more)[0])
            x = np.append(x, wanted)
            order = np.argsort(x)
            x, numbers = x[order], [np.append(y, z)[order] for y, z in zip(numbers, added, strict=True)]
        return x, numbers

    def _by_target(self, numbers: Array, worst: Array) -> list[Array]:
        """Of numbers (m, S), and the worst of them (m,) over the whole range, those (m,) of each of the targets."""
        return [numbers[:, np.searchsorted(self.angles, low)] if low == high else worst for low, high in self.targets]

    def _over(self, values: Array, angles: Array | None = None) -> Array:
        """The number (m, S) at other values (m,) and strike angles (S,), those of the scan by default [rad]."""
        angles = self.angles if angles is None else angles
        sweep = self._sweep.with_values(self._scale * values, np.degrees(angles))
        return self._read(self._table(sweep, (self._target,))).reshape(len(values), len(angles))

    def _at(self, values: Array, angles: Array) -> Array:
        """The number (m,) at values (m,), each at a strike angle (m,) [rad]; NaN without a result."""
        sweep = self._sweep.at(np.stack([self._scale * values, np.degrees(angles)], axis=1))
        return self._read(self._table(sweep, (self._target,)))

    def _read(self, table: Table) -> Array:
        numbers = table.values(self._target)
        return np.abs(numbers) if self._target.selection.signed else numbers

    def _table(self, sweep: VariedLandings, computed: tuple[Column, ...]) -> Table:
        feasible = (select("feasible"),)  # which depends on the friction
        return Evaluation(sweep, computed, prove=0, trusted=ILL_CONDITIONED, elsewhere=feasible).table().without_defects()


def _vertices(x: Array, y: Array) -> Array:
    """The vertex (m,) of parabolas through three points (m, 3), kept between the outer ones; the middle one where there is none."""
    with np.errstate(all="ignore"):
        slopes = np.diff(y) / np.diff(x)
        vertex = (x[:, 0] + x[:, 1] - slopes[:, 0] * (x[:, 2] - x[:, 0]) / (slopes[:, 1] - slopes[:, 0])) / 2.0
    return np.clip(np.where(np.isfinite(vertex), vertex, x[:, 1]), x[:, 0], x[:, 2])


def _kinks(x: Array, y: Array, k: int) -> Array:
    """Where the minimum beside sample k of y (n,) at x (n,) may lie if branches meet there: where lines through two each meet."""
    four = k + np.array([[-2, -1, 0, 1], [-1, 0, 1, 2]])
    a, b, c, d = four[(four >= 0).all(axis=1) & (four < len(x)).all(axis=1)].T
    with np.errstate(all="ignore"):
        left, right = (y[b] - y[a]) / (x[b] - x[a]), (y[d] - y[c]) / (x[d] - x[c])
        at = (y[c] - y[b] + left * x[b] - right * x[c]) / (left - right)
    return np.asarray(at[(at >= x[b]) & (at <= x[c])])


def within(x: Array, runs: Sequence[tuple[float, float]]) -> np.ndarray:
    """Which values (n,) are within one of some runs."""
    return np.any([(x >= low) & (x <= high) for low, high in runs], axis=0) if runs else np.zeros(len(x), dtype=bool)


def still_to_compute(x: Array, beyond: Array, feasible: np.ndarray, fine: float) -> Array:
    """Where values are still to be computed: at roots of the spline, at extrema that may reach the bound, and at the best ones.

    Args:
        x: (n,) values that are known, ascending.
        beyond: (n,) how far the number is beyond the bound there.
        feasible: (n,) which of them are feasible, of which the best is sought too.
        fine: how near to a known value nothing is computed.
    """
    # A step changes the number by about as much on one side of an extremum as on the other.
    before, here, after = np.where(beyond[1:-1] > 0.0, 1.0, -1.0) * np.stack([beyond[:-2], beyond[1:-1], beyond[2:]])
    turning = (here <= np.minimum(before, after)) & (here < np.maximum(before, after) - here)
    best = [int(np.argmin(beyond)), int(np.argmin(np.where(feasible, beyond, np.inf)))][: 1 + feasible.any()]
    turning[np.clip(np.array(best) - 1, 0, len(turning) - 1)] = True
    three = np.flatnonzero(turning)[:, None] + np.arange(3)
    roots = CubicSpline(x, beyond).solve(0.0, extrapolate=False)
    kinks = (_kinks(x, beyond, k) for k in best)
    places = np.unique(np.concatenate([roots[np.isfinite(roots)], _vertices(x[three], beyond[three]), *kinks]))
    return np.asarray(places[np.abs(places[:, None] - x).min(axis=1) > fine])


def _ranges(values: Array, refused: dict[int, str]) -> Iterator[tuple[float, float, str]]:
    """The ranges of consecutive postures without a result, with the first one's reason."""
    for first in sorted(refused.keys() - {k + 1 for k in refused}):
        last = next(k for k in itertools.count(first) if k + 1 not in refused)
        yield float(values[first]), float(values[last]), refused[first]
