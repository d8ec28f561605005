"""The worst of a number over some landings as a function of what may vary, with its gradient and with constraints.

The rows are what an optimiser asks for; the engine computes them as those of any other study.
"""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from shockpc.core.spatial import Array, freeze
from shockpc.evaluation.columns import Column, selected
from shockpc.evaluation.evaluate import Evaluation
from shockpc.evaluation.gradients import has_gradient, slopes
from shockpc.evaluation.landings import Chunk, common_robot, named_scenes, refuse_ground
from shockpc.evaluation.variation import Variation, Vary, pairs
from shockpc.evaluation.varied import VariedLandings, varied_landings
from shockpc.evaluation.varied_scene import present_value
from shockpc.landing.landing import PosedLanding
from shockpc.landing.places import Place
from shockpc.landing.posture import difference
from shockpc.landing.resolve import resolve
from shockpc.landing.scene import Scene, Strike
from shockpc.profile import shock_profile
from shockpc.quantities.contacts import IMPULSE
from shockpc.quantities.heights import CLEARANCE, SPREAD, on_ground
from shockpc.quantities.quantity import Quantity
from shockpc.quantities.table import Selection
from shockpc.robot.robot import Robot
from shockpc.text.arguments import checked
from shockpc.text.errors import StudyError
from shockpc.text.printed import few

TRUSTED = 1e10
"""Condition up to which rows are left in double precision; what is found is proven afterwards."""

STEP = 1e-5
"""Step of a difference, as a share of the range of what varies."""

NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
"""A number, as a constraint states it."""

SLACK = 1e-7
"""By how much an optimiser may miss a constraint, as a share of its scale; it is given one that is narrower by twice as much."""


def _pushed(impact: Any, places: Sequence[Place]) -> Array:
    normals = np.array([impact.blocks[place.number].normal for place in places])
    return np.asarray(np.sum(IMPULSE.compute(impact, places) * normals, axis=-1))


PUSH = Quantity("push", "contact", "impulse with which the ground pushes", "N s", "neither", _pushed, linear=True)
"""With `CLEARANCE` and `SPREAD` what `feasible` decides by, as numbers that a constraint can follow: they have either sign."""


@dataclass(frozen=True, eq=False)
class ChosenLandings(VariedLandings):
    """Landings with given values of what varies, each struck as in several scenes that differ in this alone.

    Attributes:
        X: (m, n) values, in the order of the variations.
        scenes: the S scenes, by name.
    """

    X: Array = field(default_factory=lambda: np.zeros((0, 0)), repr=False)
    scenes: Mapping[str, Scene] = field(default_factory=dict)

    def at(self, X: Array) -> "ChosenLandings":
        """The same landings with other values, what they share resolved already."""
        other = replace(self, X=X, sample=len(X))
        vars(other)["first"] = self.first
        return other

    @property
    def strikes(self) -> int:
        """Number of scenes."""
        return len(self.scenes)

    def _values(self, k: int) -> dict[Variation, np.ndarray]:
        a, b = self.chunks[k]
        return {varied: self.X[a:b, j, None] for j, varied in enumerate(self.variations)}

    def _strikes(self, landing: PosedLanding, values: Any, own: np.ndarray) -> Array:
        if self.strikes == 1:
            return super()._strikes(landing, values, own)
        velocities = np.array([scene.strike.vector(landing.plane) for scene in self.scenes.values()])
        return np.broadcast_to(velocities, (len(own), *velocities.shape))

    def case(self, row: int) -> tuple[Scene, Robot]:
        """The landing of one row, as of any varied landings, with the strike of its scene."""
        scene, robot = super().case(row)
        strike = list(self.scenes.values())[row % self.strikes].strike
        return (scene if self.strikes == 1 else replace(scene, strike=strike)), robot

    def chunk(self, k: int, data: None) -> Chunk:
        """The postures of a chunk, as of any varied landings."""
        first = self.chunks[k][0] * self.strikes
        return super().chunk(k, data)._replace(profile=lambda i: shock_profile(*self.case(first + i)))

    def resolved(self) -> tuple[Array, Array]:
        """Configurations (m, nq) and strikes (m, S, 3) of all rows, which are of one landing."""
        values, own = self._values(0), np.arange(len(self.X))
        return self._postures(self.first, values, own), self._strikes(self.first, values, own)


class Term(NamedTuple):
    """A number of a landing that counts.

    Attributes:
        column: the number.
        landing: name of the landing.
        group: index of the landings that it is computed with.
        strike: its index among these.
        role: index of the quantity of which it is a value; −1 of a constraint.
        exact: whether its derivatives have a formula.
        limit: of a constraint.
        sign: 1 of an upper limit, −1 of a lower one.
        scale: of a constraint [its unit].
        unknown: slack of a constraint whose number does not exist.
    """

    column: Column
    landing: str
    group: int
    strike: int
    role: int
    exact: bool
    limit: float = 0.0
    sign: float = 1.0
    scale: float = 1.0
    unknown: float = -1.0

    @property
    def text(self) -> str:
        """Of a constraint, as it is typed, or what the ground does."""
        ground = {
            "push": f"the ground does not pull {self.column.place.name}",
            "clearance": f"{self.column.place.name} is not below the contact",
            "spread": "flat ground touches all contacts",
        }
        key = self.column.selection.name
        return ground.get(key, f"{self.column.name} {'<=' if self.sign > 0.0 else '>='} {self.limit:g}")

    @property
    def power(self) -> float:
        """What an optimiser takes for a value, as a power of it: of a length the square is smooth at zero; less is better."""
        return -2.0 if self.column.selection.quantity.worse == "less" else 2.0


class ShockCost:
    """The worst of a number over some landings as a function of what may vary, for any optimiser.

        cost = shockpc.ShockCost(scene, "shock@imu_link", [("*_KFE", "-120:-10"), ("base-pitch", "-20:20")])
        scipy.optimize.minimize(cost, cost.x0, jac=cost.gradient, bounds=cost.bounds)

    Args:
        scenes: one landing, or landings of one robot by name.
        quantity: QUANTITY@PLACES; of several places the worst counts. Or several quantities: then those after the first are what
            `measures` gives too.
        variables: ranges by subject, as in `variation`: {"*_KFE": "-120:-10", "mass:base": "0.8x:1.2x"}, or pairs of both.
        robot: the scenes' robot, if it is loaded already.
        keep: constraints, QUANTITY@PLACES<=LIMIT or >=LIMIT; of a number that may be negative its magnitude counts.
        ground: whether flat ground has to allow the landings, as `feasible` says.

    Attributes:
        names: headings of the variables, with their units.
        bounds: (n, 2) least and greatest value of each, in these units.
        given: (n,) present values; NaN of what has none, or not a single one.
        x0: (n,) the same within the bounds, or the middle of them.
        slow: whether each point needs landings of its own.

    Raises:
        ShockError: a name is not known, a range does not fit or is missing, or a landing cannot be resolved.
    """

    @checked
    def __init__(
        self,
        scenes: Scene | Mapping[str, Scene],
        quantity: str | Sequence[str],
        variables: Vary,
        robot: Robot | None = None,
        *,
        keep: str | Sequence[str] = (),
        ground: bool = True,
    ) -> None:
        self.scenes = named_scenes(scenes)
        self.quantities, kept = ((one,) if isinstance(one, str) else tuple(one) for one in (quantity, keep))
        if not self.quantities:
            raise StudyError("no quantity is given; name one, such as shock@imu_link")
        self.robot = robot or common_robot(self.scenes)
        landings = {name: resolve(scene, self.robot) for name, scene in self.scenes.items()}
        first = next(iter(landings.values()))
        varied = varied_landings(first.scene, pairs(variables), robot=self.robot, sample=1, keep_joints=True)
        self.variations = varied.variations
        self.names = tuple(one.column for one in self.variations)
        self.bounds = np.array([_bounds(one) for one in self.variations])
        self.given = np.array([0.0 if one.kind.startswith("com-") else present_value(first, one) for one in self.variations])
        self.x0 = np.clip(np.where(np.isnan(self.given), self.bounds.mean(axis=1), self.given), *self.bounds.T)
        freeze(self.bounds, self.given, self.x0)
        self.groups = _groups(varied, landings)
        # Formulas are of a strike at constant speed, which that of a drop at another angle is not.
        dropped = any(scene.strike.drop_height is not None for scene in self.scenes.values())
        moved = all(one.moves or (one.kind == "strike-angle" and not dropped) for one in self.variations)
        self.terms = tuple(
            term for g, group in enumerate(self.groups) for term in self._terms(g, group, kept, ground, moved and not first.loops)
        )
        self.roles = np.array([term.role for term in self.terms])
        self._how = np.array(
            [(one.limit, one.sign, one.scale, one.unknown, one.power, one.column.selection.signed) for one in self.terms]
        ).T
        for role, text in enumerate(self.quantities):
            if role not in self.roles:
                raise StudyError(f'"{text}" has no place in these landings; name one')
        entries = {term.column.selection.quantity for term in self.terms}
        separate = any(group.separate for group in self.groups) or not all(one.stage for one in self.variations)
        self.slow = separate or any(entry.per_landing(first.scene) and not entry.in_doubles for entry in entries)
        self._known: tuple[bytes, Array] = b"", np.zeros(0)

    def __call__(self, x: Array) -> float:
        """The worst value over the landings at (n,) values; of what is better the greater it is, the reciprocal."""
        return math.sqrt(float(self.measures(self._point(x)[None])[0].max()))

    def gradient(self, x: Array) -> Array:
        """The derivatives (n,) of the worst value: where two landings are the worst, those of one; NaN where there is no value."""
        x = self._point(x)
        measures = self.measures(x[None])[0]
        k = int(measures.argmax())
        if not 0.0 < measures[k] < np.inf:
            return np.full(len(x), np.nan if measures[k] else 0.0)
        return np.asarray(self.slopes(x[None])[0, self.roles == 0][k] / (2.0 * math.sqrt(measures[k])))

    def feasible(self, x: Array) -> bool:
        """Whether the landings at (n,) values exist, flat ground allows them, and all constraints hold."""
        x = self._point(x)[None]
        return bool(np.isfinite(self.measures(x)).all() and (self.slack(x) >= -SLACK).all())

    def cases(self, x: Array) -> dict[str, tuple[Scene, Robot]]:
        """Scene and robot of each landing at (n,) values, by name."""
        rows = [group.at(self._point(x)[None]) for group in self.groups]
        found = {name: own.case(s) for own in rows for s, name in enumerate(own.scenes)}
        return {name: found[name] for name in self.scenes}

    def scene(self, x: Array) -> Scene:
        """The scene at (n,) values, of several landings the first. What changes the robot itself is not in it: see `cases`."""
        return next(iter(self.cases(x).values()))[0]

    def measures(self, X: Array, role: int = 0) -> Array:
        """What an optimiser takes for a quantity (m, J), smooth and less where it is better, at (m, n) values; inf without one."""
        return np.nan_to_num(self.measured(self.numbers(X))[0][:, self.roles == role], nan=np.inf)

    def slack(self, X: Array) -> Array:
        """How far (m, C) the constraints are from being missed, as shares of their scales."""
        return np.asarray(self.measured(self.numbers(X))[0][:, self.roles < 0])

    def measured(self, v: Array) -> tuple[Array, Array]:
        """What an optimiser takes for the values (m, K) of all terms, and its derivatives by them.

        A constraint is at least zero where it holds. One of the ground that is not determined holds, another does not.
        """
        held, (limit, sign, scale, unknown, power, signed) = self.roles < 0, self._how
        with np.errstate(divide="ignore", invalid="ignore"):
            turn = np.where(signed, np.sign(v), 1.0)
            slack = np.clip((limit - turn * v) * sign / scale - 2.0 * SLACK, -1e3, 1e3)  # so that it holds for sure
            measures = np.where(held, np.where(np.isnan(v), unknown, slack), np.abs(v) ** power)
            return measures, np.where(held, -turn * sign / scale, power * measures / v)

    def numbers(self, X: Array) -> Array:
        """The values (m, K) of all terms, at (m, n) values; NaN where there is none. The last ones are kept."""
        X = np.asarray(X, dtype=float)
        if X.tobytes() != self._known[0]:
            self._known = X.tobytes(), self._computed(X, range(len(self.terms)))
        return self._known[1]

    def slopes(self, X: Array) -> Array:
        """The derivatives (m, K, n) of the measures of all terms at (m, n) values: by formulas where these exist, else differences.

        Of the measures, not of the numbers: a length has a kink where it is zero, its square has none.
        """
        X = np.asarray(X, dtype=float)
        (m, n), h = X.shape, 2.0 * STEP * np.ptp(self.bounds, axis=1)
        out, factors = np.empty((m, len(self.terms), n)), self.measured(self.numbers(X))[1]
        beside = (X[:, None] + np.concatenate([np.diag(h / 2.0), np.diag(-h / 2.0)])).reshape(-1, n)
        if rough := [k for k, term in enumerate(self.terms) if not term.exact]:
            numbers = np.zeros((len(beside), len(self.terms)))
            numbers[:, rough] = self._computed(beside, rough)
            up, down = self.measured(numbers)[0].reshape(m, 2, n, -1).swapaxes(0, 1)
            out[:] = np.swapaxes((up - down) / h[:, None], 1, 2)
        # How posture and strike change is a difference, of angles an exact one; that of joints is the same everywhere.
        near = beside[: 2 * n] if all(one.kind == "joint" for one in self.variations) else beside
        for g, group in enumerate(self.groups):
            if own := {k: term for k, term in enumerate(self.terms) if term.exact and term.group == g}:
                (Q, strikes), (moved, turned) = group.at(X).resolved(), group.at(near).resolved()
                sides = moved.reshape(-1, 2, n, moved.shape[1]).swapaxes(0, 1).reshape(2, -1, moved.shape[1])
                rates = difference(self.robot, sides[1], sides[0]).reshape(-1, n, self.robot.model.nv) / h[:, None]
                turns = -np.diff(turned.reshape(-1, 2, n, *turned.shape[1:]), axis=1)[:, 0] / h[:, None, None]
                rates, turns = (np.broadcast_to(way, (m, *way.shape[1:])) for way in (rates, turns))
                columns = list({term.column.name: term.column for term in own.values()}.values())
                found = slopes(group.first, Q, strikes, rates, turns, columns)
                for k, term in own.items():
                    out[:, k] = factors[:, k, None] * found[term.column.name][:, term.strike]
        return np.asarray(np.nan_to_num(out, nan=0.0, posinf=0.0, neginf=0.0))

    def _computed(self, X: Array, chosen: Sequence[int]) -> Array:
        """The values (m, k) of some terms, at (m, n) values."""
        out = np.full((len(X), len(chosen)), np.nan)
        for g, group in enumerate(self.groups):
            if own := {j: self.terms[k] for j, k in enumerate(chosen) if self.terms[k].group == g}:
                columns = tuple({term.column.name: term.column for term in own.values()}.values())
                table = Evaluation(group.at(X), columns, prove=0, trusted=TRUSTED).table()
                for j, term in own.items():
                    out[:, j] = table.columns[term.column.name].reshape(len(X), -1)[:, term.strike]
        return out

    def _point(self, x: Array) -> Array:
        """A point (n,).

        Raises:
            StudyError: it has another shape, or holds no numbers.
        """
        try:
            x = np.asarray(x, dtype=float)
        except (TypeError, ValueError):
            x = np.array(np.nan)
        if x.shape != self.x0.shape:
            raise StudyError(
                f"x has shape {x.shape} or no numbers; give {len(self.x0)} values, those of {few(list(self.names), 6)}"
            )
        return x

    def _terms(self, g: int, group: ChosenLandings, keep: Sequence[str], ground: bool, moved: bool) -> Iterable[Term]:
        """The terms of a group. Args: moved, whether formulas know what varies."""
        landing, wanted = group.first, list[tuple[Column, dict[str, Any]]]()
        for role, text in enumerate(self.quantities):
            wanted += [(column, {"role": role}) for column in _columns(landing, text)]
        for text in keep:
            parts = re.fullmatch(rf"(.+?)\s*([<>])=?\s*({NUMBER})", text.strip())
            if not parts or not math.isfinite(limit := float(parts[3])):
                raise StudyError(f'"{text}" is not QUANTITY@PLACES<=LIMIT or >=LIMIT, such as joint_impulse@*_KFE<=2')
            how = {"limit": limit, "sign": 1.0 if parts[2] == "<" else -1.0, "scale": abs(limit) or 1.0}
            wanted += [(column, how) for column in _columns(landing, parts[1])]
        tolerance, level = landing.scene.ground_tolerance, len(on_ground(landing))
        for entry, applies, limit, sign, scale in (
            (PUSH, landing.scene.friction is None, 0.0, -1.0, self.robot.mass * landing.fastest_approach),
            (CLEARANCE, level and landing.base != "fixed", -tolerance, -1.0, landing.length),
            (SPREAD, level > 1, tolerance, 1.0, landing.length),
        ):
            how = {"limit": limit, "sign": sign, "scale": scale, "unknown": 1.0}
            wanted += [(Column(Selection(entry.key, entry), p), how) for p in landing.places(entry.of) if ground and applies]
        # Heights do not depend on the strike.
        return [
            Term(column, name, g, s, exact=moved and has_gradient(landing, column), **{"role": -1, **how})
            for column, how in wanted
            for s, name in enumerate(group.scenes)
            if s == 0 or column.selection.quantity not in (CLEARANCE, SPREAD)
        ]


def _groups(varied: VariedLandings, landings: Mapping[str, PosedLanding]) -> tuple[ChosenLandings, ...]:
    """The landings, those together that differ in the velocity of the strike alone, unless that varies."""
    together, strikes_vary = dict[Any, dict[str, Scene]](), any(one.stage == 2 for one in varied.variations)
    for name, landing in landings.items():
        apart = name if strikes_vary or not landing.translates else ""
        together.setdefault((apart, repr(replace(landing.scene, strike=Strike()))), {})[name] = landing.scene
    none = np.zeros((1, len(varied.variations)))
    return tuple(
        ChosenLandings(next(iter(own.values())), varied.robot, varied.variations, 1, X=none, scenes=own)
        for own in together.values()
    )


def _columns(landing: PosedLanding, text: str) -> list[Column]:
    """The numbers that a text means, one for each place.

    Raises:
        ShockError: as for `selected`; or it is none of an impact, or takes contacts as sticking where the scene does not.
    """
    selection, places = selected(landing, text)
    entry = selection.quantity
    if entry.on == "health" or entry.role:
        raise StudyError(f"{selection.name} ({entry.title}) cannot be followed here; choose another quantity")
    if not entry.of_ground(landing.scene):
        refuse_ground(landing.scene, others="name a quantity that depends on it, such as shock_friction or peak_force")
    return [Column(selection, place) for place in places]


def _bounds(varied: Variation) -> tuple[float, float]:
    """Least and greatest value of what varies.

    Raises:
        StudyError: there is no range between them.
    """
    values = varied.span or tuple(value for value in varied.values if isinstance(value, float))
    if not values or not min(values) < max(values):
        raise StudyError(f"{varied.subject} has no range; give one, such as {varied.subject}=LOW:HIGH")
    return min(values), max(values)
