"""The worst of a number over some landings as a function of what may vary, with its gradient and
with constraints.

The rows are what an optimiser asks for; the engine computes them as those of any other study.
"""

import functools
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from shockpc.core.number import NUMBER, numbers_from
from shockpc.core.spatial import Array, freeze
from shockpc.evaluation.column import Column, selected
from shockpc.evaluation.evaluate import TRUSTED, Evaluation
from shockpc.evaluation.gradients import has_gradient, slopes
from shockpc.evaluation.kinds.registry import KINDS
from shockpc.evaluation.kinds.strike import StrikeAngle
from shockpc.evaluation.named_scenes import common_robot, named_scenes
from shockpc.evaluation.unused_ground import refuse_ground
from shockpc.evaluation.varied_landings import VariedLandings, varied_landings
from shockpc.evaluation.vary import Vary, pairs
from shockpc.landing.landing import PosedLanding
from shockpc.landing.places import Place
from shockpc.landing.posture import difference
from shockpc.landing.resolve import resolve
from shockpc.landing.scene import Scene
from shockpc.landing.soles import most_inside
from shockpc.landing.strike import Strike
from shockpc.quantities.heights import CLEARANCE, HEIGHTS, REACH, SPREAD, on_ground, without_shapes
from shockpc.quantities.of_contacts import IMPULSE, REDUNDANT
from shockpc.quantities.of_robot import ENERGY_LOST, ROUNDING
from shockpc.quantities.quantity import Quantity, Relations, Scope
from shockpc.quantities.selection import Selection
from shockpc.quantities.support import OVERHANG, standing_feet, stands
from shockpc.robot.feet_and_sensors import each_foot
from shockpc.robot.robot import Robot
from shockpc.text.arguments import checked
from shockpc.text.errors import StudyError
from shockpc.text.printed import few

STEP = 1e-5
"""Step of a difference, as a share of the range of what varies."""

SLACK = 2e-7
"""By how much a constraint is narrowed for an optimiser, which may miss it by as much, as a share
of its scale.
"""


def _pushed(impact: Any, places: Sequence[Place]) -> Array:
    normals = np.array([impact.blocks[place.number].normal for place in places])
    return np.asarray(np.sum(IMPULSE.compute(impact, places) * normals, axis=-1))


PUSH = Quantity(
    "push",
    "contact",
    "push of the ground",
    "N s",
    "neither",
    _pushed,
    scope=Scope(f"{REDUNDANT}; --any-ground leaves it out"),
    relations=Relations(linear=True),
)
"""With `HEIGHTS` what `feasible` decides by, as numbers that a constraint can follow: they have
either sign.
"""

LOSS = ENERGY_LOST._replace(scope=Scope(f"{ENERGY_LOST.scope.missing}; --any-ground leaves it out"))
"""What no impact has below zero; without restitution it is not."""


class Term(NamedTuple):
    """A number of a landing that counts.

    Attributes:
        column: the number.
        landing: name of the landing.
        group: index of the landings that it is computed with.
        strike: its index among these.
        limit: of a constraint; None of a value.
        scale: of a constraint [its unit]; below zero where the limit is a lower one.
    """

    column: Column
    landing: str
    group: int
    strike: int
    limit: float | None = None
    scale: float = 1.0

    @property
    def text(self) -> str:
        """Of a constraint what it says; of a value what it is."""
        if self.limit is None:
            return self.column.name
        return f"{self.column.title} {'<=' if self.scale > 0.0 else '>='} {self.limit:g} {self.column.unit}".removesuffix(
            " -"
        )


class ShockCost:
    """The worst of a number over some landings as a function of what may vary, for any optimiser.

        cost = shockpc.ShockCost(scene, "shock@imu_link", [("*_KFE", "-120:-10"), ("base-pitch",
        "-20:20")]) scipy.optimize.minimize(cost, cost.x0, jac=cost.gradient, bounds=cost.bounds)

    Args:
        scenes: one landing, or landings of one robot by name.
        quantity: KEY@PLACES; of several places the worst is taken.
        variables: ranges by subject, as in `variation`: {"*_KFE": "-120:-10", "mass:base":
            "0.8x:1.2x"}, or pairs of both.
        robot: the scenes' robot, if it is loaded already.
        keep: constraints, KEY@PLACES<=LIMIT or >=LIMIT; of a number that may be negative its
            magnitude counts.
        ground: whether flat ground has to allow the landings, as `feasible` says, or `feasible_if_tilted`
            where other feet are level. Links without a foot then keep clear of it by its tolerance,
            and of a robot on its feet these carry the centre of mass.

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
        self.scenes = named_scenes(scenes)
        for subject, _ in variables:
            if subject in KINDS:
                prepared = KINDS[subject].prepared
                self.scenes = {name: prepared(scene) for name, scene in self.scenes.items()}
        self.quantity = quantity
        self.robot = robot or common_robot(self.scenes)
        landings = {name: resolve(scene, self.robot) for name, scene in self.scenes.items()}
        first = next(iter(landings.values()))
        varied = varied_landings(
            first.scene, variables, robot=self.robot, sample=1, keep_joints=True
        )
        self.variations = varied.variations
        self.names = tuple(one.column for one in self.variations)
        self.bounds = np.array([one.ends for one in self.variations])
        values = [[varied.present(one) for varied in self.variations] for one in landings.values()]
        self.given = np.where(np.ptp(values, axis=0) == 0.0, values[0], np.nan)
        self.x0 = np.clip(
            np.where(np.isnan(values[0]), self.bounds.mean(axis=1), values[0]), *self.bounds.T
        )
        freeze(self.bounds, self.given, self.x0)
        self.groups = _groups(varied, landings)
        self.terms = tuple(
            term
            for g, group in enumerate(self.groups)
            for term in self._terms(g, group, (keep,) if isinstance(keep, str) else keep, ground)
        )
        self._columns = [
            tuple({one.column.name: one.column for one in self.terms if one.group == g}.values())
            for g in range(len(self.groups))
        ]
        # Formulas are of a strike at constant speed, which that of a drop at another angle is not.
        dropped = any(scene.strike.drop_height is not None for scene in self.scenes.values())
        moved = all(
            one.moves or (isinstance(one.kind, StrikeAngle) and not dropped)
            for one in self.variations
        )
        self.exact = (
            moved
            and not first.loops
            and all(has_gradient(landings[term.landing], term.column) for term in self.terms)
        )
        self.constraints = np.array([term.limit is not None for term in self.terms])
        if self.constraints.all():
            raise StudyError(f'"{quantity}" has no place in these landings; name one')
        self.column = self.terms[0].column
        self.power = -1.0 if self.column.selection.quantity.worse == "less" else 1.0
        self._how = np.array(
            [(one.limit or 0.0, one.scale, one.column.selection.signed) for one in self.terms]
        ).T
        separate = bool(first.loops) or not all(one.stage for one in self.variations)
        entries = {term.column.selection.quantity for term in self.terms}
        self.slow = separate or any(
            entry.per_landing(first.scene) and entry.evaluation.postures != "clear"
            for entry in entries
        )

    def __reduce__(self) -> tuple[Any, ...]:  # for optimisers with several processes
        return self._again, ()

    def __call__(self, x: Array) -> float:
        """The worst value over the landings at (n,) values; of what is better the greater it is,
        the reciprocal.
        """
        return float(self.measured(self._point(x))[0, ~self.constraints].max())

    def gradient(self, x: Array) -> Array:
        """The derivatives (n,) of the worst value: where two landings are the worst, those of one;
        NaN where there is no value.
        """
        (measures,), (slopes,) = (
            part[:, ~self.constraints] for part in self.linearized(self._point(x))
        )
        k = int(measures.argmax())
        return np.where(np.isfinite(measures[k]), slopes[k], np.nan)

    def feasible(self, x: Array) -> bool:
        """Whether the landings at (n,) values exist, flat ground allows them, and all constraints
        hold.
        """
        (measures,) = self.measured(self._point(x))
        return bool(np.isfinite(measures).all() and (measures[self.constraints] >= -SLACK).all())

    def cases(self, x: Array) -> dict[str, tuple[Scene, Robot]]:
        """Scene and robot of each landing at (n,) values, by name."""
        rows = [group.at(self._point(x)) for group in self.groups]
        found = {name: group.case(s) for group in rows for s, name in enumerate(group.struck)}
        return {name: found[name] for name in self.scenes}

    def scene(self, x: Array) -> Scene:
        """The scene at (n,) values, of several landings the first.

        What changes the robot itself is not in it: see `cases`.
        """
        return next(iter(self.cases(x).values()))[0]

    def measured(self, X: Array) -> Array:
        """What an optimiser takes for all terms (m, K), at (m, n) values.

        Of a value its size, or the reciprocal where more of it is better; inf without one. A
        constraint is at least zero where it holds, as a share of its scale; -inf of a number that
        does not exist.
        """
        return self._measured(self._numbers(X))[0]

    def worst(self, X: Array) -> Array:
        """The worst of the number itself (m,), at (m, n) values; of one that may be negative its
        size.
        """
        with np.errstate(divide="ignore"):
            return np.asarray(self.measured(X)[:, ~self.constraints].max(axis=1) ** self.power)

    def linearized(self, X: Array) -> tuple[Array, Array]:
        """The same (m, K) and its derivatives (m, K, n), of all terms by formulas, or differences;
        0 where there are none.
        """
        if self.exact:
            (m, n), (h, beside) = X.shape, self._beside(X)
            found, unclear = [], np.zeros(m, dtype=bool)
            for group, columns in zip(self.groups, self._columns, strict=True):
                # How posture and strike change is a difference, of angles an exact one.
                (up, down), turned = (
                    part.reshape(2, m * n, *part.shape[1:]) for part in group.at(beside).resolved()
                )
                rates = difference(self.robot, down, up).reshape(m, n, -1) / h[:, None]
                turns = (turned[0] - turned[1]).reshape(m, n, -1, 3) / h[:, None, None]
                numbers, prove = slopes(
                    group.first, *group.at(X).resolved(), rates, turns, columns, TRUSTED
                )
                found.append(numbers)
                unclear |= prove
            values, change = (
                self._of_terms([{name: pair[k] for name, pair in of.items()} for of in found])
                for k in (0, 1)
            )
            if unclear.any():
                values[unclear] = self._numbers(X[unclear])
            # A posture that is singular has no derivatives by formulas.
            if (rough := np.isnan(change).any(axis=(1, 2))).any():
                change[rough] = self._differences(X[rough])[1]
        else:
            values, change = self._differences(X)
        measures, factors = self._measured(_of_points(X, values))
        with np.errstate(invalid="ignore"):
            return measures, np.nan_to_num(
                factors[..., None] * change, nan=0.0, posinf=0.0, neginf=0.0
            )

    def _beside(self, X: Array) -> tuple[Array, Array]:
        """The widths (n,) of central differences, and the points (2 m n, n) between which they are:
        above, then below.
        """
        h = 2.0 * STEP * np.ptp(self.bounds, axis=1)
        return h, np.stack([X[:, None] + np.diag(h / 2.0), X[:, None] - np.diag(h / 2.0)]).reshape(
            -1, X.shape[1]
        )

    def _differences(self, X: Array) -> tuple[Array, Array]:
        """The values (m, K) of all terms and their derivatives (m, K, n) by differences; NaN where
        there are none.
        """
        (m, n), (h, beside) = X.shape, self._beside(X)
        # at once: a call costs more than some rows
        found = self._numbers(np.concatenate([X, beside]))
        up, down = found[m:].reshape(2, m, n, -1)
        with np.errstate(invalid="ignore"):
            return found[:m], ((up - down) / h[:, None]).swapaxes(1, 2)

    def _measured(self, v: Array) -> tuple[Array, Array]:
        """What an optimiser takes for the values (m, K), and its derivatives by them."""
        constraint, power, (limit, scale, signed) = self.constraints, self.power, self._how
        with np.errstate(divide="ignore", invalid="ignore"):
            turn = np.where(signed, np.sign(v), 1.0)
            # so that it holds for sure
            slack = np.clip((limit - turn * v) / scale - SLACK, -1e3, 1e3)
            measures = np.where(
                np.isnan(v),
                np.where(constraint, -np.inf, np.inf),
                np.where(constraint, slack, np.abs(v) ** power),
            )
            return measures, np.where(constraint, -turn / scale, power * measures / v)

    def _numbers(self, X: Array) -> Array:
        """The values (m, K) of all terms, at (m, n) values; NaN where there is none."""
        tables = [
            Evaluation(group.at(X), columns, prove=0, trusted=TRUSTED)
            .table.without_defects()
            .columns
            for group, columns in zip(self.groups, self._columns, strict=True)
        ]
        return _of_points(
            X,
            self._of_terms(
                [{name: x.reshape(len(X), -1) for name, x in of.items()} for of in tables]
            ),
        )

    def _of_terms(self, found: Sequence[Mapping[str, Array]]) -> Array:
        """What terms have (m, K, ...) of that of the columns (m, S, ...) of each group."""
        return np.stack(
            [found[one.group][one.column.name][:, one.strike] for one in self.terms], axis=1
        )

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

    def _terms(
        self, g: int, group: VariedLandings, keep: Sequence[str], ground: bool
    ) -> Iterable[Term]:
        landing = group.first
        wanted: list[tuple[Any, ...]] = [(_columns(landing, self.quantity),)]
        for text in keep:
            parts = re.fullmatch(rf"(.+?)\s*([<>])=?\s*({NUMBER})", text.strip())
            if not parts or not math.isfinite(limit := float(parts[3])):
                raise StudyError(
                    f'"{text}" is not KEY@PLACES<=LIMIT or >=LIMIT, such as joint_impulse@*_KFE<=2'
                )
            columns = _columns(landing, parts[1])
            if limit < 0.0 and columns and columns[0].selection.signed:
                raise StudyError(
                    f'"{text}": {parts[1]} may have either sign, so its magnitude is bounded, '
                    f"which is never below zero"
                )
            wanted.append(
                (columns, limit, (abs(limit) or 1.0) * (1.0 if parts[2] == "<" else -1.0))
            )
        tolerance, level = landing.scene.ground_tolerance, len(on_ground(landing))
        falls, inside = level and landing.base != "fixed", max(most_inside(self.robot), tolerance)
        sticks, push = landing.scene.friction is None, self.robot.mass * landing.fastest_approach
        rebounds, work = (
            any(block.restitution for block in landing.contacts),
            push * landing.fastest_approach,
        )
        footed = {landing.robot.frame(name).body for name in each_foot(landing.robot)}
        struck = {block.body for block in (*landing.contacts, *landing.stance)}
        upright = struck <= footed and stands(landing) and len(standing_feet(landing.robot)) > 1
        for entry, applies, *how in (
            (PUSH, sticks, 0.0, -push),
            (LOSS, sticks and rebounds, -ROUNDING * work, -work),
            (CLEARANCE, falls, tolerance, -landing.length),
            (REACH, falls, -inside, -landing.length),
            (SPREAD, level > 1, tolerance, landing.length),
            (OVERHANG, falls and upright, 0.0, landing.length),
        ):
            if ground and applies:
                places = [
                    p
                    for p in landing.places(entry.of)
                    if entry is not REACH or without_shapes(landing, p.number)
                ]
                # A link with a foot may be level with the contacts: all feet of a robot that stands
                # are.
                feet = [p for p in places if entry is CLEARANCE and p.body in footed | struck]
                selection = Selection(entry.key, entry)
                wanted.append(
                    ([Column(selection, place) for place in places if place not in feet], *how)
                )
                wanted.append(
                    ([Column(selection, place) for place in feet], -tolerance, -landing.length)
                )
        # Heights do not depend on the strike.
        return [
            Term(column, name, g, s, *how)
            for columns, *how in wanted
            for column in columns
            for s, name in enumerate(group.struck)
            if s == 0 or column.selection.quantity not in (*HEIGHTS, OVERHANG)
        ]


def _of_points(X: Array, values: Array) -> Array:
    """Values (m, K) at (m, n) points; NaN at what is no point: in a sweep NaN leaves a thing as it
    is.
    """
    return np.where(np.isnan(X).any(axis=1, keepdims=True), np.nan, values)


def _groups(
    varied: VariedLandings, landings: Mapping[str, PosedLanding]
) -> tuple[VariedLandings, ...]:
    """The landings, those together that differ only in the velocity of the strike, unless that
    varies.
    """
    together, strikes_vary = (
        dict[Any, dict[str, Strike]](),
        any(one.stage == 2 for one in varied.variations),
    )
    for name, landing in landings.items():
        apart = name if strikes_vary or not landing.translates else ""
        together.setdefault((apart, repr(replace(landing.scene, strike=Strike()))), {})[name] = (
            landing.scene.strike
        )
    return tuple(
        replace(varied, scene=landings[next(iter(strikes))].scene, struck=strikes)
        for strikes in together.values()
    )


def _columns(landing: PosedLanding, text: str) -> list[Column]:
    """The numbers that a text means, one for each place.

    Raises:
        ShockError: as for `selected`; or it is none of an impact, or takes contacts as sticking
            where the scene does not.
    """
    selection, places = selected(landing, text)
    entry = selection.quantity
    if entry.evaluation.on == "health" or entry.relations.role:
        raise StudyError(
            f"{selection.name} ({entry.title}) cannot be followed here; choose another quantity"
        )
    if not entry.of_ground(landing.scene):
        refuse_ground(
            landing.scene,
            others="name a quantity that depends on it, such as shock_friction or peak_force",
        )
    return [Column(selection, place) for place in places]
