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
from shockpc.evaluation.variation import Variation, pairs
from shockpc.evaluation.varied import VariedLandings, varied_landings
from shockpc.evaluation.varied_scene import present_value
from shockpc.landing.landing import PosedLanding
from shockpc.landing.places import Place
from shockpc.landing.posture import difference
from shockpc.landing.resolve import resolve
from shockpc.landing.rows import block_point
from shockpc.landing.scene import Scene, Strike
from shockpc.profile import shock_profile
from shockpc.quantities.contacts import IMPULSE
from shockpc.quantities.heights import levels, on_ground
from shockpc.quantities.quantity import Quantity
from shockpc.quantities.table import Selection
from shockpc.robot.geometry import body_outline
from shockpc.robot.robot import Robot
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


def _heights(impact: Any) -> Any:
    points = np.stack([block_point(impact.state, impact.blocks[k]) for k in on_ground(impact.landing)], axis=1)
    return levels(impact.landing, impact.state.rotation, impact.state.position, points, np.inf)


def _pushed(impact: Any, places: Sequence[Place]) -> Array:
    normals = np.array([impact.blocks[place.number].normal for place in places])
    return np.asarray(np.sum(IMPULSE.compute(impact, places) * normals, axis=-1))


def _clearance(impact: Any, places: Sequence[Place]) -> Array:
    """Heights (N, 1, n) of bodies above the lowest contact, without what strikes."""
    here, body = _heights(impact), np.array([i for i, own in enumerate(body_outline(impact.landing.robot).shapes) for _ in own])
    lowest = [here.surface[:, here.others & (body == place.body)].min(axis=1, initial=np.inf) for place in places]
    return np.asarray((np.stack(lowest, axis=1) - here.contacts.min(axis=1, keepdims=True))[:, None])


PUSH = Quantity("push", "contact", "impulse with which the ground pushes", "N s", "neither", _pushed, linear=True)
CLEARANCE = Quantity("clearance", "body", "height above the lowest contact", "m", "neither", _clearance)
SPREAD = Quantity("spread", "robot", "difference in height", "m", "neither", lambda i, _: _heights(i).spread[:, None, None])
"""What `feasible` decides by, as numbers that a constraint can follow: they have either sign."""


@dataclass(frozen=True, eq=False)
class ChosenLandings(VariedLandings):
    """Landings with given values of what varies, each struck as in several scenes that differ in this alone.

    Attributes:
        X: (m, n) values, in the order of the variations.
        scenes: the S scenes.
        names: of these landings.
        velocities: (S, 3) of the robot before the impact in each, world axes [m/s].
    """

    X: Array = field(default_factory=lambda: np.zeros((0, 0)), repr=False)
    scenes: tuple[Scene, ...] = ()
    names: tuple[str, ...] = ()
    velocities: Array = field(default_factory=lambda: np.zeros((0, 3)), repr=False)

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
        one = self.strikes == 1
        return super()._strikes(landing, values, own) if one else np.broadcast_to(self.velocities, (len(own), self.strikes, 3))

    def chunk(self, k: int, data: None) -> Chunk:
        """As of any varied landings, with the proof of a row that needs one in the scene of its strike."""
        return super().chunk(k, data)._replace(profile=lambda i: shock_profile(*self.struck(k, i)))

    def resolved(self) -> tuple[Array, Array]:
        """Configurations (m, nq) and strikes (m, S, 3) of all rows, which are of one landing."""
        values, own = self._values(0), np.arange(len(self.X))
        strikes = self._strikes(self.first, values, own)
        return self._postures(self.first, values, own), np.broadcast_to(strikes, (len(own), self.strikes, 3))

    def struck(self, k: int, i: int) -> "tuple[Scene, Robot]":
        """Scene and robot of a row of a chunk."""
        scene, robot = self._case(dict(zip(self.variations, self.X[self.chunks[k][0] + i // self.strikes].tolist(), strict=True)))
        return (scene if self.strikes == 1 else replace(scene, strike=self.scenes[i % self.strikes].strike)), robot


class Term(NamedTuple):
    """A number of a landing that counts.

    Attributes:
        column: the number.
        landing: name of the landing.
        group: index of the landings that it is computed with.
        strike: its index among these.
        role: index of the quantity of which it is a value; −1 of a constraint.
        limit: of a constraint; None of others.
        sign: 1 of an upper limit, −1 of a lower one.
        scale: of a constraint [its unit].
        unknown: slack of a constraint whose number does not exist.
    """

    column: Column
    landing: str
    group: int
    strike: int
    role: int
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
            `values` gives too.
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

    def __init__(
        self,
        scenes: Scene | Mapping[str, Scene],
        quantity: str | Sequence[str],
        variables: Mapping[str, Any] | Iterable[tuple[str, Any]],
        robot: Robot | None = None,
        *,
        keep: str | Sequence[str] = (),
        ground: bool = True,
    ) -> None:
        self.scenes = named_scenes(scenes)
        self.quantities, kept = _texts(quantity), _texts(keep)
        if not self.quantities:
            raise StudyError("no quantity is given; name one, such as shock@imu_link, or a point with --at")
        self.robot = robot or common_robot(self.scenes)
        landings = {name: resolve(scene, self.robot) for name, scene in self.scenes.items()}
        first = next(iter(landings.values()))
        varied = varied_landings(first.scene, pairs(variables), robot=self.robot, sample=1, keep_joints=True)
        self.variations = varied.variations
        self.names = tuple(one.column for one in self.variations)
        self.bounds = np.array([_bounds(one) for one in self.variations])
        present = [0.0 if one.kind.startswith("com-") else present_value(first, one) for one in self.variations]
        self.given = np.array(present)
        self.x0 = np.clip(np.where(np.isnan(self.given), self.bounds.mean(axis=1), self.given), *self.bounds.T)
        freeze(self.bounds, self.given, self.x0)
        self.groups = _groups(varied, landings)
        self.terms = tuple(
            term for g, group in enumerate(self.groups) for term in self._terms(g, group.first, group.names, kept, ground)
        )
        self.roles, powers = np.array([term.role for term in self.terms]), np.array([term.power for term in self.terms])
        for role, text in enumerate(self.quantities):
            if role not in self.roles:
                raise StudyError(f'"{text}" has no place in these landings; name one')
        slow = [group.separate for group in self.groups] + [not one.stage for one in self.variations]
        entries = dict.fromkeys(term.column.selection.quantity for term in self.terms)
        slow += [entry.per_landing(first.scene) and not entry.in_doubles for entry in entries]
        self.slow = any(slow)
        # Formulas are of a strike at constant speed, which that of a drop at another angle is not.
        dropped = any(scene.strike.drop_height is not None for scene in self.scenes.values())
        by_formula = (one.moves or (one.kind == "strike-angle" and not dropped) for one in self.variations)
        self._exact = not first.loops and all(by_formula)
        how = np.array([term[5:] for term in self.terms], dtype=float).T
        self._how = self.roles < 0, np.array([term.column.selection.signed for term in self.terms]), powers, *how
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
        return np.asarray(self.slopes(x)[self.roles == 0][k] / (2.0 * math.sqrt(measures[k])))

    def feasible(self, x: Array) -> bool:
        """Whether the landings at (n,) values exist, flat ground allows them, and all constraints hold."""
        x = self._point(x)[None]
        return bool(np.isfinite(self.measures(x)).all() and self.held(x).all())

    def cases(self, x: Array) -> dict[str, tuple[Scene, Robot]]:
        """Scene and robot of each landing at (n,) values, by name."""
        rows = [group.at(self._point(x)[None]) for group in self.groups]
        found = {name: own.struck(0, s) for own in rows for s, name in enumerate(own.names)}
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
        held, signed, power, limit, sign, scale, unknown = self._how
        with np.errstate(divide="ignore", invalid="ignore"):
            turn = np.where(signed, np.sign(v), 1.0)
            slack = np.clip((limit - turn * v) * sign / scale - 2.0 * SLACK, -1e3, 1e3)  # so that it holds for sure
            measures = np.where(held, np.where(np.isnan(v), unknown, slack), np.abs(v) ** power)
            return measures, np.where(held, -turn * sign / scale, power * measures / v)

    def held(self, X: Array) -> np.ndarray:
        """Whether (m, C) constraints hold."""
        return np.asarray(self.slack(X) >= -SLACK)

    def numbers(self, X: Array) -> Array:
        """The values (m, K) of all terms, at (m, n) values; NaN where there is none."""
        X = np.asarray(X, dtype=float)
        # Of a single point the slopes are wanted too, as a rule, and more rows cost little unless each is a landing of its own.
        return np.asarray(self._computed(X if self.slow or len(X) > 1 else self._beside(X[0]))[: len(X)])

    def slopes(self, x: Array, formulas: bool = True) -> Array:
        """The derivatives (K, n) of the measures of all terms at (n,) values.

        Args:
            x: the values.
            formulas: whether those are exact that have a formula; differences cost less where the values are wanted too.
        """
        n, numbers = len(x), self._computed(self._beside(x))
        # Of the measures, not of the numbers: a length has a kink where it is zero, its square has none.
        beside, (_, factors) = self.measured(numbers[1:])[0], self.measured(numbers[:1])
        out = ((beside[:n] - beside[n:]) / (2.0 * self._steps[:, None])).T
        for g, group in enumerate(self.groups if formulas else ()):
            exact = [term.group == g and self._exact and has_gradient(group.first, term.column) for term in self.terms]
            own = {k: self.terms[k] for k in np.flatnonzero(exact).tolist()}
            found = self._exact_slopes(group, x, list({term.column.name: term.column for term in own.values()}.values()))
            for k, term in own.items():
                out[k] = factors[0, k] * found[term.column.name][term.strike]
        return np.asarray(np.nan_to_num(out, nan=0.0, posinf=0.0, neginf=0.0))

    @property
    def _steps(self) -> Array:
        return np.asarray(STEP * np.ptp(self.bounds, axis=1))

    def _beside(self, x: Array) -> Array:
        """A point and those (1 + 2n, n) a step beside it in each variable."""
        return np.concatenate([x[None], x + np.diag(self._steps), x - np.diag(self._steps)])

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

    def _exact_slopes(self, group: ChosenLandings, x: Array, wanted: list[Column]) -> dict[str, Array]:
        """Derivatives of numbers (S, n) by name; how posture and strike change is a difference, of angles an exact one."""
        if not wanted:
            return {}
        n, (Q, strikes) = len(x), group.at(self._beside(x)).resolved()
        h = 2.0 * self._steps[:, None]
        turns = (strikes[1 : n + 1] - strikes[n + 1 :]) / h[..., None]
        return slopes(group.first, Q[0], strikes[0], difference(self.robot, Q[n + 1 :], Q[1 : n + 1]) / h, turns, wanted)

    def _computed(self, X: Array) -> Array:
        """The values (m, K) of all terms at (m, n) values; the last ones are kept."""
        if X.tobytes() != self._known[0]:
            out = np.full((len(X), len(self.terms)), np.nan)
            for g, group in enumerate(self.groups):
                own = {k: term for k, term in enumerate(self.terms) if term.group == g}
                columns = tuple({term.column.name: term.column for term in own.values()}.values())
                table = Evaluation(group.at(X), columns, prove=0, trusted=TRUSTED).table()
                for k, term in own.items():
                    out[:, k] = table.columns[term.column.name].reshape(len(X), -1)[:, term.strike]
            self._known = X.tobytes(), out
        return self._known[1]

    def _terms(self, g: int, landing: PosedLanding, names: Sequence[str], keep: Sequence[str], ground: bool) -> Iterable[Term]:
        wanted: list[tuple[Column, dict[str, Any]]] = []
        for role, text in enumerate(self.quantities):
            wanted += [(column, {"role": role}) for column in _columns(landing, text)]
        for text in keep:
            parts = re.fullmatch(rf"(.+?)\s*([<>])=?\s*({NUMBER})", text.strip())
            if not parts or not math.isfinite(number := float(parts[3])):
                raise StudyError(f'"{text}" is not QUANTITY@PLACES<=LIMIT or >=LIMIT, such as joint_impulse@*_KFE<=2')
            how = {"role": -1, "limit": number, "sign": 1.0 if parts[2] == "<" else -1.0, "scale": abs(number) or 1.0}
            wanted += [(column, how) for column in _columns(landing, parts[1])]
        tolerance, level = landing.scene.ground_tolerance, len(on_ground(landing))
        for entry, places, applies, limit, sign, scale in (
            (PUSH, landing.contact_places, landing.scene.friction is None, 0.0, -1.0, self.robot.mass * landing.fastest_approach),
            (CLEARANCE, landing.places("body"), level and landing.base != "fixed", -tolerance, -1.0, landing.length),
            (SPREAD, landing.places("robot"), level > 1, tolerance, 1.0, landing.length),
        ):
            how = {"role": -1, "limit": limit, "sign": sign, "scale": scale, "unknown": 1.0}
            wanted += [(Column(Selection(entry.key, entry), place), how) for place in places if ground and applies]
        # Heights do not depend on the strike.
        return [
            Term(column, name, g, s, **how)
            for column, how in wanted
            for s, name in enumerate(names)
            if s == 0 or column.selection.quantity not in (CLEARANCE, SPREAD)
        ]


def _groups(varied: VariedLandings, landings: Mapping[str, PosedLanding]) -> tuple[ChosenLandings, ...]:
    """The landings, those together that differ in the velocity of the strike alone, unless that varies."""
    apart = any(one.stage == 2 for one in varied.variations)
    together = list[dict[str, PosedLanding]]()
    for name, landing in landings.items():
        others = (own for own in together if not apart and _unstruck(next(iter(own.values()))) == _unstruck(landing))
        own = next(others, None)
        if own is None:
            together.append(own := {})
        own[name] = landing
    made = []
    for own in together:
        scenes = tuple(landing.scene for landing in own.values())
        velocities = np.array([landing.before.velocity for landing in own.values()])
        made.append(
            ChosenLandings(
                scenes[0], varied.robot, varied.variations, 1, scenes=scenes, names=tuple(own), velocities=velocities
            ).at(np.zeros((1, len(varied.variations))))
        )
    return tuple(made)


def _unstruck(landing: PosedLanding) -> Scene:
    strike = landing.scene.strike
    return replace(landing.scene, strike=Strike(angular_velocity=strike.angular_velocity, joint_velocities=strike.joint_velocities))


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


def _texts(given: str | Sequence[str]) -> tuple[str, ...]:
    """One text or several.

    Raises:
        StudyError: it is something else.
    """
    texts = (given,) if isinstance(given, str) else given
    if not isinstance(texts, Sequence) or not all(isinstance(text, str) for text in texts):
        raise StudyError(f"{given!r} is no QUANTITY@PLACES, and no list of these")
    return tuple(texts)


def _bounds(varied: Variation) -> tuple[float, float]:
    """Least and greatest value of what varies.

    Raises:
        StudyError: there is no range between them.
    """
    values = varied.span or tuple(value for value in varied.values if isinstance(value, float))
    if not values or not min(values) < max(values):
        raise StudyError(f"{varied.subject} has no range; give one, such as {varied.subject}=LOW:HIGH")
    return min(values), max(values)
