"""A number on the rows of a sweep over one quantity and the strike angle, and where it crosses a
bound.
"""

import itertools
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.evaluation.column import Column, ground_columns
from shockpc.evaluation.evaluate import Evaluation
from shockpc.evaluation.table import Table
from shockpc.evaluation.varied_landings import VariedLandings, varied_landings
from shockpc.landing.landing import PosedLanding
from shockpc.profile import ILL_CONDITIONED
from shockpc.quantities.selection import select

ANGLES = 43
"""Strike angles of a range that are computed."""

LEAST = 33
"""Values of a scan, at least."""

HALVINGS = 8
"""How often the step in which a number crosses the bound is halved; the crossing is then
interpolated.
"""

UNDETERMINED = (
    "the number does not exist in this posture, or is not determined, because contacts or loops "
    "are redundant"
)

Strikes = tuple[float, float]
"""Smallest and largest strike angle, equal for a single one [rad]."""


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
        """1 where greater numbers are worse, −1 where smaller ones are."""
        return -1.0 if self.below else 1.0

    def violation(self, numbers: Array) -> Array:
        """How far numbers N are beyond the bound B, ±(N² − B²) / (N² + B²), from −1 to 1.

        It is smooth where N is zero and where N has a pole; 1 where there is no number.
        """
        with np.errstate(over="ignore"):
            beyond = self.sign * (1.0 - 2.0 / (1.0 + (numbers / self.value) ** 2))
        return np.nan_to_num(beyond, nan=1.0)


class Scan(NamedTuple):
    """A number on a grid of values and strike angles.

    Attributes:
        sweep: the landings.
        target: the number; of one that may be negative the magnitude.
        bound: of the number.
        scale: what a value is multiplied by for the unit of the sweep.
        values: (n,) ascending [rad, m; unit of the variation]; they end where loops cannot be
            closed.
        angles: (S,) strike angles, ascending [rad].
        numbers: (n, S); NaN without a result.
        allowed_by_ground: (n, S) whether flat ground allows the landing.
        scene_strike: index of the strike angle of the scene.
        unreachable: (smallest value, largest value, reason) of ranges without a result for the
            strike of the scene.
        inaccurate: number of values in whose rows rounding may show above 1e-9.
    """

    sweep: VariedLandings
    target: Column
    bound: Bound
    scale: float
    values: Array
    angles: Array
    numbers: Array
    allowed_by_ground: np.ndarray
    scene_strike: int
    unreachable: tuple[tuple[float, float, str], ...]
    inaccurate: int

    @property
    def at_scene_strike(self) -> Array:
        """The number (n,) for the strike of the scene; NaN without a result."""
        return self.numbers[:, self.scene_strike]

    def inside(self, strikes: Strikes) -> np.ndarray:
        """Which strike angles (S,) of the grid are in a range."""
        return np.asarray((self.angles >= strikes[0]) & (self.angles <= strikes[1]))

    def worst(self, strikes: Strikes) -> tuple[Array, Array]:
        """The worst number (n,) over the strike angles of a range, and the angle (n,) of it [rad].

        It is NaN where one of these landings has no result.
        """
        angles, numbers = self.angles[self.inside(strikes)], self.numbers[:, self.inside(strikes)]
        k = np.argmax(self.bound.violation(numbers), axis=1)
        worst = numbers[np.arange(len(numbers)), k]
        return np.where(np.isnan(numbers).any(axis=1), np.nan, worst), angles[k]

    def feasible(self, strikes: Strikes) -> np.ndarray:
        """Whether (n,) flat ground allows the landings at all strike angles of a range."""
        return np.asarray(self.allowed_by_ground[:, self.inside(strikes)].all(axis=1))

    def feasible_runs(self, strikes: Strikes) -> tuple[tuple[float, float], ...]:
        """The first and last value of each run of feasible ones."""
        feasible = np.concatenate([[False], self.feasible(strikes), [False]])
        change = np.flatnonzero(np.diff(feasible))
        firsts, lasts = self.values[change[::2]], self.values[change[1::2] - 1]
        return tuple(zip(firsts.tolist(), lasts.tolist(), strict=True))

    def crossings(self, targets: Sequence[Strikes]) -> list[Array]:
        """Where the worst number over each of some ranges of strikes crosses the bound, ascending.

        An interval that lies between two values of the grid is not seen.
        """
        beyond = [self.bound.violation(self.worst(strikes)[0]) for strikes in targets]
        steps = [np.flatnonzero((y[1:] <= 0.0) != (y[:-1] <= 0.0)) for y in beyond]
        # One row for each crossing: its target, the ends of its step, and the violation there.
        which = np.repeat(np.arange(len(targets)), [len(k) for k in steps])
        if not len(which):
            return [np.zeros(0) for _ in targets]
        first = np.concatenate(steps)
        low, high = self.values[first], self.values[first + 1]
        under = np.concatenate([y[k] for y, k in zip(beyond, steps, strict=True)])
        over = np.concatenate([y[k + 1] for y, k in zip(beyond, steps, strict=True)])
        angles = [self.angles[self.inside(targets[t])] for t in which.tolist()]
        for _ in range(HALVINGS):
            middle = (low + high) / 2.0
            there = self._violation_at(middle, angles)
            same_side = (there <= 0.0) == (under <= 0.0)
            low, under = np.where(same_side, middle, low), np.where(same_side, there, under)
            high, over = np.where(same_side, high, middle), np.where(same_side, over, there)
        roots = low - under * (high - low) / (over - under)
        return [roots[which == t] for t in range(len(targets))]

    def _violation_at(self, values: Array, angles: Sequence[Array]) -> Array:
        """How far the worst number is beyond the bound (m,). Args: values (m,); angles, of each."""
        counts = [len(each) for each in angles]
        degrees = np.degrees(np.concatenate(angles))
        rows = np.stack([self.scale * np.repeat(values, counts), degrees], axis=1)
        numbers = read(_computed(self.sweep.at(rows), (self.target,)), self.target)
        starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
        return np.asarray(np.maximum.reduceat(self.bound.violation(numbers), starts))


def scanned(
    landing: PosedLanding,
    subject: str,
    target: Column,
    bound: Bound,
    values: Array,
    scale: float,
    targets: Sequence[Strikes],
) -> Scan:
    """The scan of a number over values and strike angles.

    Args:
        landing: that varies.
        subject: what varies, as of a sweep.
        target: the number.
        bound: of the number.
        values: (n,) ascending [rad, m; unit of the variation].
        scale: what a value is multiplied by for the unit of the variation.
        targets: the ranges of strike angles that are asked of, the last the widest [rad].

    Raises:
        ShockError: a value is not possible.
    """
    single = np.unique([*(low for low, high in targets if low == high), *targets[-1]])
    spread = np.linspace(*targets[-1], ANGLES)
    angles = np.sort([*single, *spread[np.abs(spread[:, None] - single).min(axis=1) > 1e-3]])
    scene_strike = int(np.searchsorted(angles, landing.strike_angle))
    vary = [(subject, scale * values), ("strike-angle", np.degrees(angles))]
    sweep = varied_landings(landing.scene, vary, robot=landing.robot)
    table = _computed(sweep, (target, *ground_columns(landing)))
    shape = len(values), len(angles)
    numbers, feasible = read(table, target).reshape(shape), table.feasible.reshape(shape)
    rows = np.ravel_multi_index((np.arange(len(values)), scene_strike), shape)
    missing = np.isnan(numbers[:, scene_strike])
    uncertain = (table.columns["condition"] > ILL_CONDITIONED) & ~table.columns["proven"]
    refused = {
        k: table.messages.get(int(rows[k]), UNDETERMINED) for k in np.flatnonzero(missing).tolist()
    }
    kept = slice(None)
    if landing.loops and not missing.all():
        first, last = np.flatnonzero(~missing)[[0, -1]].tolist()
        kept = slice(first, last + 1)
    return Scan(
        sweep=sweep,
        target=target,
        bound=bound,
        scale=scale,
        values=values[kept],
        angles=angles,
        numbers=numbers[kept],
        allowed_by_ground=feasible[kept],
        scene_strike=scene_strike,
        unreachable=tuple(_ranges(values, refused)),
        inaccurate=int((uncertain[rows] & ~missing).sum()),
    )


def read(table: Table, target: Column) -> Array:
    """A number (n,) of the rows of a table; of one that may be negative the magnitude."""
    numbers = table.values(target)
    return np.abs(numbers) if target.selection.signed else numbers


def within(x: Array, runs: Sequence[tuple[float, float]]) -> np.ndarray:
    """Which values (n,) are within one of some runs."""
    inside = np.zeros(len(x), dtype=bool)
    for low, high in runs:
        inside |= (x >= low) & (x <= high)
    return inside


def _computed(sweep: VariedLandings, columns: tuple[Column, ...]) -> Table:
    elsewhere = (select("feasible"),)  # which depends on the friction
    rows = Evaluation(sweep, columns, prove=0, trusted=ILL_CONDITIONED, elsewhere=elsewhere)
    return rows.table.without_defects()


def _ranges(values: Array, refused: dict[int, str]) -> Iterator[tuple[float, float, str]]:
    """The ranges of consecutive values without a result, with the first one's reason."""
    for first in sorted(refused.keys() - {k + 1 for k in refused}):
        last = next(k for k in itertools.count(first) if k + 1 not in refused)
        yield float(values[first]), float(values[last]), refused[first]
