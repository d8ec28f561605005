"""The worst of a number over some landings as a function, with its gradient and with constraints.

The rows are what an optimiser asks for; the engine computes them as those of any other study.
"""

import functools
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from shockpc.core.number import numbers_from
from shockpc.core.spatial import Array, freeze
from shockpc.evaluation.column import Column
from shockpc.evaluation.evaluate import MAX_CONDITION, Evaluation
from shockpc.evaluation.gradients import has_gradient, slopes
from shockpc.evaluation.named_scenes import common_robot, named_scenes
from shockpc.evaluation.terms import Term, terms_of
from shockpc.evaluation.variations.arguments import varied_landings
from shockpc.evaluation.variations.kinds.registry import kind_and_target
from shockpc.evaluation.variations.rows import VariedLandings
from shockpc.evaluation.variations.variation import Variation
from shockpc.evaluation.variations.vary import Vary, pairs
from shockpc.landing.landing import PosedLanding
from shockpc.landing.posture import difference
from shockpc.landing.resolve import resolve
from shockpc.landing.scenes.scene import Scene
from shockpc.landing.scenes.strike import Strike
from shockpc.robot.robot import Robot
from shockpc.text.arguments import checked
from shockpc.text.errors import StudyError
from shockpc.text.printed import few

STEP = 1e-5
"""Step of a difference, as a share of the range of what varies."""

SLACK = 2e-7
"""Share of its scale by which a constraint is narrowed for an optimiser.

The optimiser may miss it by as much.
"""


class ShockCost:
    """The worst of a number over some landings as a function of its variables, for any optimiser.

    For example, with SciPy::

        cost = shockpc.ShockCost(
            scene, "shock@imu_link", [("*_KFE", "-120:-10"), ("base-pitch", "-20:20")]
        )
        scipy.optimize.minimize(cost, cost.x0, jac=cost.gradient, bounds=cost.bounds)

    Args:
        scenes: one landing, or landings of one robot by name.
        quantity: KEY@PLACES; of several places the worst is taken.
        variables: ranges by subject, as in `variation`: {"*_KFE": "-120:-10", "mass:base":
            "0.8x:1.2x"}, or pairs of both.
        robot: the scenes' robot, if it is loaded already.
        keep: constraints, KEY@PLACES<=LIMIT or >=LIMIT; of a number that may be negative its
            magnitude counts.
        ground: whether flat ground has to allow the landings, as `feasible` says, or
            `feasible_if_tilted` where other feet are level. Links without a foot then keep clear of
            it by its tolerance, and of a robot on its feet these carry the centre of mass.

    Attributes:
        column: the number at the first of its places.
        names: headings of the variables, with their units.
        bounds: (n, 2) smallest and largest value of each, in these units.
        given: (n,) present values; NaN of what has none, or not a single one in all landings.
        x0: (n,) those of the first landing, within the bounds; the middle of the bounds of what has
            none.
        slow: whether each point needs separate landings.
        exact: whether there are formulas for all derivatives; else they are differences.
        terms: the K numbers that count, of all landings.
        constraints: (K,) which of them are constraints.
        power: 1; −1 where more of the number is better, so that its reciprocal counts.

    Raises:
        ShockError: a name is not known, a range does not fit or is missing, or a landing cannot be
            resolved.
    """

    @checked
    def __init__(
        self,
        scenes: Scene | str | Mapping[str, Scene | str],
        quantity: str,
        variables: Vary,
        robot: Robot | None = None,
        *,
        keep: str | Sequence[str] = (),
        ground: bool = True,
    ) -> None:
        variables = pairs(variables)
        self._again = functools.partial(
            ShockCost, scenes, quantity, variables, robot, keep=keep, ground=ground
        )
        self.quantity = quantity
        self.scenes = _prepared(named_scenes(scenes), variables)
        self.robot = robot or common_robot(self.scenes)
        landings = {name: resolve(scene, self.robot) for name, scene in self.scenes.items()}
        first = next(iter(landings.values()))
        rows = varied_landings(first.scene, variables, robot=self.robot, sample=1, keep_joints=True)
        self._set_variables(rows.variations, list(landings.values()))
        self.groups = _groups(rows, landings)
        self._set_terms((keep,) if isinstance(keep, str) else keep, ground)
        if self.constraints.all():
            raise StudyError(f'"{quantity}" has no place in these landings; name one')
        self.column = self.terms[0].column
        self.power = -1.0 if self.column.selection.quantity.worse == "less" else 1.0
        self.exact = self._has_formulas(landings)
        self.slow = self._needs_landings(first)

    def _set_variables(
        self, variations: tuple[Variation, ...], landings: Sequence[PosedLanding]
    ) -> None:
        """Set what varies, between which bounds, and from where."""
        self.variations = variations
        self.names = tuple(varied.column for varied in variations)
        self.bounds = np.array([varied.ends for varied in variations])
        present = []
        for landing in landings:
            present.append([varied.present(landing) for varied in variations])
        values = np.array(present)
        same = np.ptp(values, axis=0) == 0.0
        self.given = np.where(same, values[0], np.nan)
        start = np.where(np.isnan(values[0]), self.bounds.mean(axis=1), values[0])
        self.x0 = np.clip(start, *self.bounds.T)
        freeze(self.bounds, self.given, self.x0)

    def _set_terms(self, keep: Sequence[str], ground: bool) -> None:
        """Set the terms, with their limits as arrays (K,), and the columns of each group."""
        terms: list[Term] = []
        self._columns: list[tuple[Column, ...]] = []
        for index, group in enumerate(self.groups):
            of_group = terms_of(group, index, self.quantity, keep, ground)
            by_name = {term.column.name: term.column for term in of_group}
            self._columns.append(tuple(by_name.values()))
            terms += of_group
        self.terms = tuple(terms)
        self.constraints = np.array([term.limit is not None for term in terms])
        self._limits = np.array([term.limit or 0.0 for term in terms])
        self._scales = np.array([term.scale for term in terms])
        self._signed = np.array([term.column.selection.signed for term in terms])

    def _has_formulas(self, landings: Mapping[str, PosedLanding]) -> bool:
        """True if there are formulas for all derivatives."""
        for varied in self.variations:
            if not all(map(varied.kind.has_derivatives, self.scenes.values())):
                return False
        if next(iter(landings.values())).loops:
            return False
        return all(has_gradient(landings[term.landing], term.column) for term in self.terms)

    def _needs_landings(self, first: PosedLanding) -> bool:
        """True if each point needs separate landings."""
        if first.loops or any(varied.stage == 0 for varied in self.variations):
            return True
        entries = {term.column.selection.quantity for term in self.terms}
        return any(
            entry.per_landing(first.scene) and entry.computation.postures != "clear"
            for entry in entries
        )

    def __reduce__(self) -> tuple[Any, ...]:
        """Made anew in another process, for optimisers that have several."""
        return self._again, ()

    def __call__(self, x: Array) -> float:
        """The worst value over the landings at (n,) values; its reciprocal if more is better."""
        return float(self.measured(self._point(x))[0, ~self.constraints].max())

    def gradient(self, x: Array) -> Array:
        """The derivatives (n,) of the worst value; NaN if there is no value.

        If two landings are the worst, they are those of one.
        """
        measures, slopes = self.linearized(self._point(x))
        values = measures[0, ~self.constraints]
        k = int(values.argmax())
        if not np.isfinite(values[k]):
            return np.full(len(x), np.nan)
        gradient: Array = slopes[0, ~self.constraints][k]
        return gradient

    def feasible(self, x: Array) -> bool:
        """True if the landings at (n,) values exist, and all constraints hold."""
        (measures,) = self.measured(self._point(x))
        holds = measures[self.constraints] >= -SLACK
        return bool(np.isfinite(measures).all() and holds.all())

    def cases(self, x: Array) -> dict[str, tuple[Scene, Robot]]:
        """Scene and robot of each landing at (n,) values, by name."""
        point = self._point(x)
        cases: dict[str, tuple[Scene, Robot]] = {}
        for group in self.groups:
            row = group.at(point)
            for strike, name in enumerate(group.struck):
                cases[name] = row.case(strike)
        return {name: cases[name] for name in self.scenes}

    def scene(self, x: Array) -> Scene:
        """The scene at (n,) values, of several landings the first.

        What changes the robot itself is not in it: see `cases`.
        """
        return next(iter(self.cases(x).values()))[0]

    def measured(self, X: Array) -> Array:
        """The measures (m, K) of all terms that an optimiser takes, at (m, n) values.

        Of a value its size, or the reciprocal where more of it is better; inf without one. A
        constraint is at least zero where it holds, as a share of its scale; -inf of a number that
        does not exist.
        """
        return self._measured(self._numbers(X))[0]

    def worst(self, X: Array) -> Array:
        """The worst of the number itself (m,), or of its size, at (m, n) values."""
        with np.errstate(divide="ignore"):
            return np.asarray(self.measured(X)[:, ~self.constraints].max(axis=1) ** self.power)

    def linearized(self, X: Array) -> tuple[Array, Array]:
        """The measures (m, K) and their derivatives (m, K, n); 0 if there are none.

        Derivatives of all terms are by formulas, or of all differences.
        """
        values, change = self._by_formulas(X) if self.exact else self._differences(X)
        measures, factors = self._measured(_of_points(X, values))
        with np.errstate(invalid="ignore"):
            slopes = factors[..., None] * change
        return measures, np.nan_to_num(slopes, nan=0.0, posinf=0.0, neginf=0.0)

    def _by_formulas(self, X: Array) -> tuple[Array, Array]:
        """The values (m, K) and derivatives (m, K, n) of all terms by formulas; NaN for none."""
        m, n = X.shape
        h, beside = self._beside(X)
        values: list[dict[str, Array]] = []
        changes: list[dict[str, Array]] = []
        unclear = np.zeros(m, dtype=bool)
        for group, columns in zip(self.groups, self._columns, strict=True):
            # Rates of posture and strike are central differences, exact for angles.
            Q_beside, strikes_beside = group.at(beside).resolved()
            up, down = np.split(Q_beside, 2)
            rates = difference(self.robot, down, up).reshape(m, n, -1) / h[:, None]
            strikes_up, strikes_down = np.split(strikes_beside, 2)
            turns = (strikes_up - strikes_down).reshape(m, n, -1, 3) / h[:, None, None]
            Q, strikes = group.at(X).resolved()
            numbers, unclear_in_group = slopes(
                group.first, Q, strikes, rates, turns, columns, MAX_CONDITION
            )
            values.append({name: value for name, (value, _) in numbers.items()})
            changes.append({name: change for name, (_, change) in numbers.items()})
            unclear |= unclear_in_group
        of_terms, change_of_terms = self._of_terms(values), self._of_terms(changes)
        # Where double precision is not enough, the values are those of the evaluation.
        if unclear.any():
            of_terms[unclear] = self._numbers(X[unclear])
        # A posture that is singular has no derivatives by formulas.
        singular = np.isnan(change_of_terms).any(axis=(1, 2))
        if singular.any():
            _, change_of_terms[singular] = self._differences(X[singular])
        return of_terms, change_of_terms

    def _beside(self, X: Array) -> tuple[Array, Array]:
        """Widths (n,) of central differences, and their points (2 m n, n): above, then below."""
        h = 2.0 * STEP * np.ptp(self.bounds, axis=1)
        steps = np.diag(h / 2.0)
        beside = np.stack([X[:, None] + steps, X[:, None] - steps])
        return h, beside.reshape(-1, X.shape[1])

    def _differences(self, X: Array) -> tuple[Array, Array]:
        """The values (m, K) and derivatives (m, K, n) of all terms by differences; NaN for none."""
        m, n = X.shape
        h, beside = self._beside(X)
        # All at once, because a call costs more than some rows.
        numbers = self._numbers(np.concatenate([X, beside]))
        up, down = numbers[m:].reshape(2, m, n, -1)
        with np.errstate(invalid="ignore"):
            change = (up - down) / h[:, None]
        return numbers[:m], change.swapaxes(1, 2)

    def _measured(self, v: Array) -> tuple[Array, Array]:
        """The measures (m, K) for the values (m, K) of terms, and their derivatives by these.

        A constraint is (limit − |v|) / scale, a value |v| or 1 / |v|. Of a number that has one sign
        v stands for |v| in constraints.
        """
        constraint = self.constraints
        with np.errstate(divide="ignore", invalid="ignore"):
            sign = np.where(self._signed, np.sign(v), 1.0)
            # Narrowed by SLACK, so that the constraint itself holds.
            slack = (self._limits - sign * v) / self._scales - SLACK
            size = np.abs(v) ** self.power
            measures = np.where(constraint, np.clip(slack, -1e3, 1e3), size)
            missing = np.where(constraint, -np.inf, np.inf)
            measures = np.where(np.isnan(v), missing, measures)
            # d|v|ᵖ / dv = p |v|ᵖ / v
            derivatives = np.where(constraint, -sign / self._scales, self.power * measures / v)
            return measures, derivatives

    def _numbers(self, X: Array) -> Array:
        """The values (m, K) of all terms, at (m, n) values; NaN where there is none."""
        values: list[dict[str, Array]] = []
        for group, columns in zip(self.groups, self._columns, strict=True):
            evaluation = Evaluation(group.at(X), columns, prove=0, max_condition=MAX_CONDITION)
            table = evaluation.table.without_defects()
            m = len(X)
            values.append({name: x.reshape(m, -1) for name, x in table.columns.items()})
        return _of_points(X, self._of_terms(values))

    def _of_terms(self, numbers: Sequence[Mapping[str, Array]]) -> Array:
        """The numbers (m, K, ...) of terms, from those of the columns (m, S, ...) of each group."""
        of_terms = [numbers[term.group][term.column.name][:, term.strike] for term in self.terms]
        return np.stack(of_terms, axis=1)

    def _point(self, x: Array) -> Array:
        """A point as a row (1, n).

        Raises:
            StudyError: it has another shape, or holds no numbers.
        """
        try:
            x = numbers_from(x)
        except (TypeError, ValueError):
            x = np.array(np.nan)
        if x.shape != self.x0.shape:
            names = few(list(self.names), 6)
            raise StudyError(
                f"x has shape {x.shape} or no numbers; give {len(self.x0)} values, of {names}"
            )
        return x[None]


def _of_points(X: Array, values: Array) -> Array:
    """Values (m, K) at (m, n) points; NaN at points with NaN, which a sweep takes as unchanged."""
    return np.where(np.isnan(X).any(axis=1, keepdims=True), np.nan, values)


def _prepared(
    scenes: Mapping[str, Scene], variables: Sequence[tuple[str, Any]]
) -> dict[str, Scene]:
    """The scenes in which some subjects vary."""
    prepared = dict(scenes)
    for subject, _ in variables:
        kind, _ = kind_and_target(subject)
        prepared = {name: kind.prepared(scene) for name, scene in prepared.items()}
    return prepared


def _groups(
    rows: VariedLandings, landings: Mapping[str, PosedLanding]
) -> tuple[VariedLandings, ...]:
    """The landings in groups that differ only in the strike, unless that varies."""
    strikes_vary = any(variation.stage == 2 for variation in rows.variations)
    strikes_by_key: dict[tuple[str, str], dict[str, Strike]] = {}
    for name, landing in landings.items():
        separate = strikes_vary or not landing.translates
        without_strike = replace(landing.scene, strike=Strike())
        key = (name if separate else "", repr(without_strike))
        strikes_by_key.setdefault(key, {})[name] = landing.scene.strike
    groups = []
    for strikes in strikes_by_key.values():
        first = landings[next(iter(strikes))]
        groups.append(replace(rows, scene=first.scene, struck=strikes))
    return tuple(groups)
