"""A number over one quantity and the strike angle, and where it crosses a bound.

It is computed on the rows of a sweep.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.evaluation.column import Column, ground_columns
from shockpc.evaluation.evaluate import Evaluation
from shockpc.evaluation.table import Table
from shockpc.evaluation.variations.arguments import varied_landings
from shockpc.evaluation.variations.rows import VariedLandings
from shockpc.evaluation.variations.variation import Variation
from shockpc.landing.landing import PosedLanding
from shockpc.profile import ILL_CONDITIONED
from shockpc.quantities.selection import select
from shockpc.studies.limits.question import Bound, Strikes

ANGLES = 43
"""Strike angles of a range that are computed."""

SAME_ANGLE = 1e-3
"""Strike angles that differ by less are computed once [rad]."""

HALVINGS = 8
"""Number of times the step in which a number crosses the bound is halved, before interpolation."""

UNDETERMINED = (
    "the number does not exist in this posture, or is not determined, because contacts or loops "
    "are redundant"
)

Run = tuple[float, float]
"""First and last of consecutive values of a scan [rad, m; unit of the variation]."""


class Scan(NamedTuple):
    """A number on a grid of values and strike angles.

    Attributes:
        sweep: the landings.
        varied: what varies.
        target: the number; of one that may be negative the magnitude.
        bound: of the number.
        values: (n,) ascending [rad, m; unit of the variation]; they end where loops cannot be
            closed.
        angles: (S,) strike angles, ascending [rad].
        numbers: (n, S); NaN without a result.
        allowed_by_ground: (n, S) whether flat ground allows the landing.
        scene_strike: index of the strike angle of the scene.
        unreachable: (first value, last value, reason) of ranges without a result for the strike of
            the scene.
        inaccurate: number of values whose equations are ill-conditioned at the strike of the scene,
            so that rounding may show above 1e-9.
    """

    sweep: VariedLandings
    varied: Variation
    target: Column
    bound: Bound
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
        """Flags (S,) of the strike angles of the grid that are in a range."""
        return np.asarray((self.angles >= strikes[0]) & (self.angles <= strikes[1]))

    def worst(self, strikes: Strikes) -> tuple[Array, Array]:
        """The worst number (n,) over the strike angles of a range, and its strike angle (n,) [rad].

        The number is NaN where one of these landings has no result.
        """
        inside = self.inside(strikes)
        numbers = self.numbers[:, inside]
        k = np.argmax(self.bound.violation(numbers), axis=1)
        worst = numbers[np.arange(len(numbers)), k]
        worst = np.where(np.isnan(numbers).any(axis=1), np.nan, worst)
        return worst, self.angles[inside][k]

    def feasible(self, strikes: Strikes) -> np.ndarray:
        """True (n,) where flat ground allows the landings at all strike angles of a range."""
        return np.asarray(self.allowed_by_ground[:, self.inside(strikes)].all(axis=1))

    def feasible_runs(self, strikes: Strikes) -> list[Run]:
        """The runs of values for which flat ground allows these landings, ascending."""
        values = self.values.tolist()
        return [(values[first], values[last]) for first, last in _runs(self.feasible(strikes))]

    def crossings(self, targets: Sequence[Strikes]) -> list[Array]:
        """Values at which the worst number over each of some ranges of strikes crosses the bound.

        The steps in which it does are halved on rows of their own; then the violation is
        interpolated linearly. Two crossings within one step of the scan are not seen.

        Returns: for each range of strikes, ascending [rad, m; unit of the variation].
        """
        values, numbers = self.values, self.numbers
        for _ in range(HALVINGS):
            crossed = [_crossed(self._violation(numbers, strikes)) for strikes in targets]
            steps = np.unique(np.concatenate(crossed))
            middle = (values[steps] + values[steps + 1]) / 2.0
            values = np.concatenate([values, middle])
            numbers = np.concatenate([numbers, self._numbers_at(middle)])
            order = np.argsort(values)
            values, numbers = values[order], numbers[order]
        return [_roots(values, self._violation(numbers, strikes)) for strikes in targets]

    def _violation(self, numbers: Array, strikes: Strikes) -> Array:
        """Distance (n,) of the worst of numbers (n, S) over a range of strikes beyond the bound."""
        return np.asarray(self.bound.violation(numbers[:, self.inside(strikes)]).max(axis=1))

    def _numbers_at(self, values: Array) -> Array:
        """The number (m, S) at values (m,) and all strike angles of the grid."""
        grid = np.meshgrid(self.varied.per_unit * values, np.degrees(self.angles), indexing="ij")
        rows = np.stack(grid, axis=-1).reshape(-1, 2)
        if not len(rows):
            return np.zeros((0, len(self.angles)))
        table = _table(self.sweep.at(rows), (self.target,))
        return _numbers(table, self.target).reshape(len(values), -1)


def scanned(
    landing: PosedLanding,
    varied: Variation,
    target: Column,
    bound: Bound,
    values: Array,
    targets: Sequence[Strikes],
) -> Scan:
    """Compute the scan of a number over values and strike angles, in double precision.

    Args:
        landing: the landing of the scene.
        varied: what varies.
        target: the number.
        bound: of the number.
        values: (n,) ascending [rad, m; unit of the variation].
        targets: the ranges of strike angles that are asked for, the widest last [rad].

    Raises:
        ShockError: a value is not possible.
    """
    angles = _strike_angles(targets)
    vary = [(varied.subject, varied.per_unit * values), ("strike-angle", np.degrees(angles))]
    sweep = varied_landings(landing.scene, vary, robot=landing.robot)
    table = _table(sweep, (target, *ground_columns(landing)))

    # Rows are values × strike angles.
    shape = len(values), len(angles)
    numbers = _numbers(table, target).reshape(shape)
    scene_strike = int(np.searchsorted(angles, landing.strike_angle))
    missing = np.isnan(numbers[:, scene_strike])
    uncertain = (table.columns["condition"] > ILL_CONDITIONED) & ~table.columns["proven"]
    uncertain = uncertain.reshape(shape)[:, scene_strike] & ~missing
    reasons = [
        table.messages.get(k * len(angles) + scene_strike, UNDETERMINED) for k in range(len(values))
    ]
    kept = _closable(missing) if landing.loops else slice(None)
    return Scan(
        sweep=sweep,
        varied=varied,
        target=target,
        bound=bound,
        values=values[kept],
        angles=angles,
        numbers=numbers[kept],
        allowed_by_ground=table.feasible.reshape(shape)[kept],
        scene_strike=scene_strike,
        unreachable=_unreachable(values, missing, reasons),
        inaccurate=int(uncertain.sum()),
    )


def _unreachable(
    values: Array, missing: np.ndarray, reasons: Sequence[str]
) -> tuple[tuple[float, float, str], ...]:
    """Ends of each run of values without a number, and why the first of them has none."""
    runs = _runs(missing)
    return tuple((float(values[k]), float(values[last]), reasons[k]) for k, last in runs)


def _closable(missing: np.ndarray) -> slice:
    """The values of a scan up to those beyond which a loop cannot be closed, by flags (n,)."""
    if missing.all():
        return slice(None)
    reached = np.flatnonzero(~missing)
    return slice(reached[0], reached[-1] + 1)


def _strike_angles(targets: Sequence[Strikes]) -> Array:
    """Strike angles (S,) of a scan, ascending: single ones, and those of the widest range [rad].

    Args: targets, the ranges that are asked for, the widest last.
    """
    low, high = targets[-1]
    single = np.unique([low, high, *(first for first, last in targets if first == last)])
    between = np.linspace(low, high, ANGLES)
    apart = np.abs(between[:, None] - single).min(axis=1) > SAME_ANGLE
    return np.sort(np.concatenate([single, between[apart]]))


def _table(sweep: VariedLandings, columns: tuple[Column, ...]) -> Table:
    """The rows of a sweep, without proofs of ill-conditioned ones, which would take hours."""
    elsewhere = (select("feasible"),)  # which depends on the friction
    rows = Evaluation(sweep, columns, prove=0, max_condition=math.inf, elsewhere=elsewhere)
    return rows.table.without_defects()


def _numbers(table: Table, target: Column) -> Array:
    """A number (n,) of the rows of a table; of one that may be negative the magnitude."""
    numbers = table.values(target)
    return np.abs(numbers) if target.selection.signed else numbers


def _runs(flags: np.ndarray) -> list[tuple[int, int]]:
    """First and last index of each run of flags (n,) that are set."""
    # A run begins where a flag is set after one that is not, and ends before the reverse.
    bounded = np.concatenate([[False], flags, [False]])
    changes = np.flatnonzero(np.diff(bounded)).tolist()
    return [(begin, end - 1) for begin, end in zip(changes[::2], changes[1::2], strict=True)]


def _crossed(violation: Array) -> np.ndarray:
    """Indices of the steps in which a violation (n,) crosses zero: step k is from k to k + 1."""
    allowed = violation <= 0.0
    return np.flatnonzero(allowed[1:] != allowed[:-1])


def _roots(x: Array, violation: Array) -> Array:
    """Values at which a violation (n,), linear between values x (n,), crosses zero, ascending."""
    k = _crossed(violation)
    # 0 = y_k + (y_{k+1} − y_k) (x − x_k) / (x_{k+1} − x_k)
    rise, step = np.diff(violation)[k], np.diff(x)[k]
    return np.asarray(x[k] - violation[k] * step / rise)
