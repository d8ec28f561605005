"""Which values of a joint, or of what else varies, keep a number below a bound: the shock at a point, a torque, a friction.

The number is computed on a grid of values and strike angles, of which rows that need a proof are proven. Where a cubic spline of it
meets the bound the landing is computed too, until a limit is known to `FINE` of the range.
"""

import functools
import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from shockpc.core.spatial import Array, Plane
from shockpc.evaluation.columns import Column, column
from shockpc.evaluation.evaluate import Evaluation, profiles
from shockpc.evaluation.strike_grid import StrikeGrid
from shockpc.evaluation.table import Table
from shockpc.evaluation.variation import ATTITUDE, Variation, kind_of, motion_range, variation
from shockpc.evaluation.varied_scene import present_value
from shockpc.landing.closure import follow
from shockpc.landing.landing import PosedLanding
from shockpc.landing.posture import held_joints, set_many, settable_joints
from shockpc.landing.record import Option
from shockpc.landing.scene import Point, Scene
from shockpc.landing.scene_file import robot_of
from shockpc.profile import ILL_CONDITIONED
from shockpc.quantities.profile import ShockProfile
from shockpc.quantities.table import select
from shockpc.robot.robot import Joint, Robot
from shockpc.studies.declare import study
from shockpc.studies.question import refuse_ground
from shockpc.text.errors import SceneError, SolveError, StudyError
from shockpc.text.toml import LARGEST

STRIKES = (-30.0, 75.0)
"""Strike angles of landings that are looked at if none are given [deg]."""

STRIKE_ANGLE_STEP = 15.0
"""Between the strike angles for which limits are given one by one [deg]."""

STEEPEST = 89.0
"""Largest strike angle; at 90° the contact moves along the ground [deg]."""

VALUE = "deg; m if prismatic"
"""Unit of a joint's values as they are typed."""

STEP = {"rad": math.radians(0.1), "m": 1e-4}
"""Largest step of the scan of a joint if none is given: 0.1°, 0.1 mm. Of other variations it is a 200th of the range."""

FINE = {"rad": 1e-6, "m": 1e-9}
"""To which a limit is found: far below 0.01° and 0.01 mm. Of other variations it is 1e-8 of the range."""

CLOSABLE = 0.1
"""Share of `STEP` to which the value is found beyond which a loop cannot be closed."""

MOST_POSTURES = 200_000
"""Largest number of postures of a scan."""

ANGLES = 43
"""Strike angles of a range among which the worst number is sought."""

BESIDE = 0.002
"""How far beside the vertex of a first parabola the strike angles of a second one are [rad]: its own is then off by 1e-9."""

STEPS = 3
"""Of regula falsi, which leave less than 1e-6 rad of the 0.04 rad between two strike angles."""

BISECTIONS = 50
"""Of a piece of a spline."""

UNDETERMINED = "the number does not exist in this posture, or is not determined, because contacts or loops are redundant"

UNCHANGED = 1e-9
"""Share of a number by which rounding may change it."""

ROUNDS = 12
"""How often landings are added to a scan where its spline meets the bound, at most; two or three times are usual."""

NOT_LIMITED = {
    "strike-angle": "strike angles are what limits are found for; give their range with --strikes",
    "contact": "contacts have names, which have no order; compute each landing, or compare them with shockpc sweep",
}
"""What a sweep varies without being limited, and why."""

End = Literal["bound", "range", "loop"]


class Interval(NamedTuple):
    """Values of the joint that keep the bound.

    Attributes:
        low: least value [rad, m].
        high: greatest value [rad, m].
        low_end: what ends it there: the bound, the range of the study, or a loop that cannot be closed beyond.
        high_end: the same at the greatest value.
    """

    low: float
    high: float
    low_end: End
    high_end: End


class StrikeLimits(NamedTuple):
    """What keeps the bound at one strike angle, or at all of a range.

    Attributes:
        strikes: least and greatest strike angle, equal for a single one [rad].
        allowed: values of the joint for which the number keeps the bound for each of these strikes, ascending.
        feasible: values of the scan, from the first to the last of each run, for which flat ground allows all of these landings.
        best: best number over the feasible values, of the worst of these strikes [its unit]; NaN if there is none at any of them.
        best_at: where that is [rad, m].
    """

    strikes: tuple[float, float]
    allowed: tuple[Interval, ...]
    feasible: tuple[tuple[float, float], ...]
    best: float
    best_at: float

    @property
    def usable(self) -> tuple[tuple[float, float], ...]:
        """Values of the joint that are both allowed and feasible, ascending [rad, m]."""
        pairs = itertools.product(self.allowed, self.feasible)
        both = ((max(one.low, low), min(one.high, high)) for one, (low, high) in pairs)
        return tuple(sorted(part for part in both if part[0] <= part[1]))


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


class LimitScan:
    """A number on a grid of values and strike angles.

    Args:
        landing: in the scene's posture.
        target: the number; of one that may be negative the magnitude.
        bound: of the number.
        varied: what varies, without values.
        joints: that are moved, all to the same value; none where something else varies.
        values: ascending [rad, m; unit of the variation].
        scale: what a value is multiplied by for the unit of the variation.
        strikes: least and greatest strike angle [rad].
        fine: to which the value is found beyond which a loop cannot be closed.

    Attributes:
        values: (n,) those that can be reached [rad, m].
        angles: (S,) strike angles of the grid, ascending: the scene's own and those of the range [rad].
        numbers: (n, S); NaN without a result.
        unreachable: (least value, greatest value, reason) of the ranges in which a loop cannot be closed, or there is no result for
            the scene's own strike.
        of_joints: whether joints are moved.
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
        strikes: tuple[float, float],
        fine: float,
    ) -> None:
        self._landing, self._target, self._bound, self._varied, self._joints, self._scale = (
            landing,
            target,
            bound,
            varied,
            joints,
            scale,
        )
        self.own_angle, self.strikes, self.of_joints = landing.strike_angle, strikes, bool(joints)
        robot, moved = landing.robot, {joint.name for joint in joints}
        led = [mimic.joint for mimic in robot.mimics if not moved.isdisjoint(mimic.leaders)]
        self._held = held_joints(robot, landing.scene.posture, landing.scene.assemble) | robot.velocities([*moved, *led])
        self.values, self._Q, unreachable = values, None, list[tuple[float, float, str]]()
        if joints and landing.loops:
            found, unreachable = self._followed(values, fine)
            self.values, self._Q = np.array(list(found)), np.stack(list(found.values()))
        elif joints:
            self._Q = self._moved(np.repeat(landing.q[None], len(values), axis=0), values)
        single, spread = np.unique([low for low, high in self.targets if low == high] + [*strikes]), _angles(*strikes)
        apart = np.abs(spread[:, None] - single).min(axis=1)
        self.angles = np.sort([*single, *spread[apart > BESIDE]])
        feasible = Column(select("feasible"), landing.places("robot")[0])
        table = self._table(
            self.values, np.broadcast_to(self.angles, (len(self.values), len(self.angles))), (target, feasible), self._Q
        )
        shape = len(self.values), len(self.angles)
        self.numbers, self._feasible = self._read(table, shape), (table.columns[feasible.name] == 1.0).reshape(shape)
        own = int(np.searchsorted(self.angles, self.own_angle))
        rows = np.arange(len(self.values)) * shape[1] + own
        uncertain = (table.columns["condition"] > ILL_CONDITIONED) & ~table.columns["proven"]
        self.inaccurate = int((uncertain[rows] & np.isfinite(self.own)).sum())
        refused = {k: table.messages.get(i, UNDETERMINED) for k, i in enumerate(rows.tolist()) if np.isnan(self.own[k])}
        self.unreachable = tuple(sorted({*unreachable, *_ranges(self.values, refused)}))

    @functools.cached_property
    def targets(self) -> list[tuple[float, float]]:
        """The strikes for which limits are found: the scene's own, others one by one, and all of the range [rad]."""
        low, high = (math.degrees(angle) for angle in self.strikes)
        inside = [
            STRIKE_ANGLE_STEP * k for k in range(math.ceil(low / STRIKE_ANGLE_STEP), math.floor(high / STRIKE_ANGLE_STEP) + 1)
        ]
        own = self.own_angle
        others = {round(float(angle), 9) for angle in (low, *inside, high)} - {round(math.degrees(own), 9)}
        # The ends are as given, without the rounding of degrees.
        ends = {round(end, 9): exact for end, exact in zip((low, high), self.strikes, strict=True)}
        single = [ends.get(angle, math.radians(angle)) for angle in sorted(others)]
        return list(dict.fromkeys([(own, own), *((angle, angle) for angle in single), self.strikes]))

    @property
    def own(self) -> Array:
        """The number (n,) for the scene's own strike; NaN without a result."""
        return self.numbers[:, int(np.searchsorted(self.angles, self.own_angle))]

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
        """Strike angles (S,) of the range and the number (n, S) there; a single one is shown as a narrow range [rad]."""
        inside = self._inside(*self.strikes)
        if inside.sum() > 1:
            return self.angles[inside], self.numbers[:, inside]
        angles = self.strikes[0] + np.array([-BESIDE, BESIDE]) * 10.0
        return angles, self.over(angles)

    def kept(self) -> list[list[tuple[float, float]]]:
        """For every posture the intervals of strike angles of the range at which the number keeps the bound [rad].

        An interval that lies between two strike angles of the grid is not seen.
        """
        inside = self._inside(*self.strikes)
        angles, beyond = self.angles[inside], self._bound.excess(self.numbers[:, inside])
        row, roots = self._strike_ends(angles, beyond)
        found = []
        for flags, inner in zip(beyond <= 0.0, np.split(roots, np.searchsorted(row, np.arange(1, len(beyond)))), strict=True):
            at = [*angles[:1][flags[:1]].tolist(), *inner.tolist(), *angles[-1:][flags[-1:]].tolist()]
            found.append(list(zip(at[::2], at[1::2], strict=True)))
        return found

    def _strike_ends(self, angles: Array, beyond: Array) -> tuple[np.ndarray, Array]:
        """Postures (k,) and strike angles (k,) at which the number meets the bound, by two steps of regula falsi from a spline.

        Args:
            angles: (S,) of the grid.
            beyond: (n, S) excess over the bound.
        """
        row, roots = crossings(angles, beyond) if len(angles) > 1 else (np.zeros(0, dtype=int), np.zeros(0))
        if not len(row):
            return row, roots
        chosen, where = np.unique(row, return_inverse=True)
        number = np.arange(len(row)) - np.searchsorted(row, row)
        j = np.searchsorted(angles, roots, side="left").clip(1) - 1
        ends, sides = [angles[j], angles[j + 1]], [beyond[row, j], beyond[row, j + 1]]
        for _ in range(STEPS):
            asked = np.full((len(chosen), number.max() + 1), self.own_angle)
            asked[where, number] = roots
            Q = None if self._Q is None else self._Q[chosen]
            there = self._bound.excess(self._numbers(self.values[chosen], asked, Q)[where, number])
            first = (there <= 0.0) == (sides[0] <= 0.0)
            for side, replaced in enumerate((first, ~first)):
                ends[side], sides[side] = np.where(replaced, roots, ends[side]), np.where(replaced, there, sides[side])
            roots = ends[0] - sides[0] * (ends[1] - ends[0]) / (sides[1] - sides[0])
        return row, roots

    def _inside(self, low: float, high: float) -> np.ndarray:
        return np.asarray((self.angles >= low) & (self.angles <= high))

    def _worst(self, values: Array, angles: Array, numbers: Array, Q: Array | None) -> tuple[Array, Array]:
        """As `worst`, from numbers (m, S) at ascending strike angles (m, S): the vertex of a parabola, twice."""
        row, missing = np.arange(len(values)), np.isnan(numbers).any(axis=1)
        low, high = angles[:, :1], angles[:, -1:]
        for beside in (BESIDE, 0.0) if angles.shape[1] > 2 else ():
            best = np.clip(self._most(numbers), 1, angles.shape[1] - 2)[:, None] + np.arange(-1, 2)
            middle = _vertex(np.take_along_axis(angles, best, 1), np.take_along_axis(numbers, best, 1))
            nearby = np.clip(middle[:, None] + beside * np.arange(-1, 2 if beside else 0), low, high)
            angles, numbers = np.hstack([angles, nearby]), np.hstack([numbers, self._numbers(values, nearby, Q)])
            order = np.argsort(angles, axis=1, kind="stable")
            angles, numbers = np.take_along_axis(angles, order, 1), np.take_along_axis(numbers, order, 1)
        best = self._most(numbers)
        return np.where(missing, np.nan, numbers[row, best]), angles[row, best]

    def _most(self, numbers: Array) -> np.ndarray:
        """Indices (m,) of the worst among numbers (m, S)."""
        return np.asarray(np.argmax(np.nan_to_num(self._bound.sign * numbers, nan=-np.inf), axis=1))

    def at(self, asked: list[Array]) -> list[Array]:
        """The worst number over each of the targets' strikes, at values of its own. Args: asked, the values (m,) of each target."""
        single = [k for k, (low, high) in enumerate(self.targets) if low == high]
        values = np.concatenate([asked[k] for k in single])
        angles = np.concatenate([np.full(len(asked[k]), self.targets[k][0]) for k in single])
        numbers = self._numbers(values, angles[:, None], self._configurations(values))[:, 0]
        known = dict(zip(single, np.split(numbers, np.cumsum([len(asked[k]) for k in single[:-1]])), strict=True))
        return [known[k] if k in known else self.worst_at(asked[k], *strikes) for k, strikes in enumerate(self.targets)]

    def _numbers(self, values: Array, angles: Array, Q: Array | None) -> Array:
        """The number (m, S) at values (m,) and strike angles (m, S) [rad]; NaN without a result."""
        return self._read(self._table(values, angles, (self._target,), Q), angles.shape) if len(values) else np.zeros(angles.shape)

    def _read(self, table: Table, shape: tuple[int, ...]) -> Array:
        numbers = np.reshape(table.values(self._target), shape)
        return np.abs(numbers) if self._target.selection.signed else numbers

    def _table(self, values: Array, angles: Array, computed: tuple[Column, ...], Q: Array | None) -> Table:
        varied = replace(self._varied, values=tuple((self._scale * values).tolist()))
        return Evaluation(StrikeGrid(self._landing, varied, angles, Q), computed, prove=0, trusted=ILL_CONDITIONED).table()

    def _configurations(self, values: Array) -> Array | None:
        """The configurations (m, nq) with the joint at values (m,); loops are followed from the nearest of the grid."""
        if self._Q is None:
            return None
        near = self._Q[np.argmin(np.abs(self.values - values[:, None]), axis=1)]
        if not self._landing.loops:
            return self._moved(near, values)
        return np.reshape([self._closed(value, q) for value, q in zip(values.tolist(), near, strict=True)], near.shape)

    def _moved(self, Q: Array, values: Array) -> Array:
        """Configurations (m, nq) with the joint at values (m,), and with what follows it."""
        set_many(self._landing.robot, [(joint, values) for joint in self._joints], Q)
        return Q

    def _closed(self, value: float, near: Array) -> Array:
        """The configuration (nq,) with the joint at a value [rad, m], whose loops are followed from a closed one."""
        landing = self._landing
        q = self._moved(near[None].copy(), np.array([value]))[0]
        return follow(landing.robot, near, q, landing.loops, landing.plane, self._held)

    def _followed(self, values: Array, fine: float) -> tuple[dict[float, Array], list[tuple[float, float, str]]]:
        """The configurations (nq,) by the values that can be reached, ascending, and the ranges that cannot be, with the reason.

        Loops are followed from the scene's own posture in both directions, each from the one before, so that they stay assembled in
        the same way; where they can no longer be closed, the walk ends.
        """
        start = int(np.argmin(np.abs(values - self._joints[0].value(self._landing.q))))
        found: dict[float, Array] = {}
        refused: list[tuple[float, float, str]] = []
        for walk in (values[start:].tolist(), values[start::-1].tolist()):
            near, last = self._landing.q, None
            for value in walk:
                try:
                    near = self._closed(value, near)
                except SceneError as refusal:
                    if last is not None:
                        last, near = self._farthest(last, value, near, fine)
                        found[last] = near
                    beyond = value if last is None else last
                    refused.append((min(beyond, walk[-1]), max(beyond, walk[-1]), str(refusal)))
                    break
                found[value], last = near, value
        if not found:
            raise StudyError(f"no value in the range can be assembled: {refused[0][2]}")
        return dict(sorted(found.items())), refused

    def _farthest(self, good: float, bad: float, near: Array, fine: float) -> tuple[float, Array]:
        """The last value that loops can reach between one that they can and one that they cannot, and its configuration."""
        while abs(bad - good) > fine:
            middle = (good + bad) / 2.0
            try:
                near, good = self._closed(middle, near), middle
            except SceneError:
                bad = middle
        return good, near


@dataclass(frozen=True, eq=False)
class JointLimits:
    """The limits of a joint, or of what else varies, that a bound on a number sets.

    Attributes:
        profile: the landing in the scene's own posture.
        target: the number.
        joints: the joints that are moved, all to the same value; or the subject of another variation.
        unit: of that value, "rad" or "m", or that of the variation.
        bound: of the number, in its unit.
        range: least and greatest value looked at [rad, m].
        file_limits: those of the robot's file; infinite where it gives none [rad, m].
        own: the value, NaN where there is none, and the strike angle of the scene [rad, m; rad].
        strikes: least and greatest strike angle looked at [rad].
        step: largest distance between the values of the scan [rad, m].
        scan: the postures and their numbers.
        limits: at the scene's own strike angle, at others one by one, and last at all strike angles of the range.
    """

    profile: ShockProfile = field(repr=False)
    target: Column
    joints: tuple[str, ...]
    unit: str
    bound: Bound
    range: tuple[float, float]
    file_limits: tuple[float, float]
    own: tuple[float, float]
    strikes: tuple[float, float]
    step: float
    scan: LimitScan = field(repr=False)
    limits: tuple[StrikeLimits, ...]

    @property
    def worst(self) -> tuple[Array, Array]:
        """The worst number (n,) of every posture over the range of strike angles, and the strike angle (n,) of it [rad]."""
        return self.scan.worst

    @property
    def subject(self) -> str:
        """The joints, or what else varies."""
        return "+".join(self.joints)

    @property
    def of_joints(self) -> bool:
        """Whether joints vary, and nothing else."""
        return self.scan.of_joints

    @functools.cached_property
    def unchanged(self) -> bool:
        """Whether the number does not depend on the value at any of the strike angles, but for rounding."""
        numbers = self.scan.numbers[~np.isnan(self.scan.numbers).any(axis=1)]
        if len(numbers) < 2 or np.isinf(numbers).any():
            return False
        return bool((np.ptp(numbers, axis=0) <= UNCHANGED * np.abs(numbers).max(axis=0)).all())

    @functools.cached_property
    def allowed_strikes(self) -> list[list[tuple[float, float]]]:
        """The strike angles of the range that keep the bound in each posture of the scan, as intervals [rad]."""
        return self.scan.kept()


def _typed(robot: Robot, given: dict[str, Any]) -> dict[str, Any]:
    """The values of a joint that turns in radians, which are typed in degrees."""
    kind, pattern = kind_of(robot, given["joint"])
    turns = kind in ATTITUDE or (kind == "joint" and robot.joint(robot.match_joints(pattern)[0]).kind != "prismatic")
    return given | {name: np.radians(given[name]).tolist() for name in ("joint_range", "step") if turns and name in given}


@study(
    "shockpc limits hyq --contact lf_foot --joint lf_kfe_joint --at trunk_imu --max 0.1",
    "shockpc limits hyq --contact lf_foot --joint lf_kfe_joint --quantity friction_needed@lf_foot --max 0.6",
    typed=_typed,
)
def limits(
    scene: Scene,
    joint: Annotated[
        str,
        Option(
            "The joint, by name; joints that a glob matches all have the same value. Or what else sweep varies, with --range.",
            "Question",
            "JOINT",
        ),
    ],
    target: str | Point,
    max: Annotated[
        float | None,
        Option("The bound, in the unit of the number, or of its magnitude: the greatest value allowed.", "Question", "VALUE"),
    ] = None,
    *,
    min: Annotated[
        float | None, Option("The least value allowed, of a number of which less is worse: a margin.", "Question", "VALUE")
    ] = None,
    joint_range: Annotated[
        tuple[float, float] | None,
        Option(
            "Values to look at; of a joint the file's limits by default, at most a turn.", "Question", "LOW:HIGH", "range", VALUE
        ),
    ] = None,
    strikes: Annotated[
        tuple[float, float] | None,
        Option(
            "Strike angles to look at; -30:75 by default, the scene's for a quantity of one posture at a time.",
            "Question",
            "LOW:HIGH",
            unit="deg",
        ),
    ] = None,
    step: Annotated[
        float | None,
        Option(
            "Largest step of the scan; 0.1 deg or 0.0001 m by default, 20 times that for a quantity of one posture at a time; of "
            "what is no joint a 200th of the range.",
            "Question",
            "STEP",
            unit=VALUE,
        ),
    ] = None,
    robot: Robot | None = None,
) -> JointLimits:
    """Find the values of a joint that keep a number at or below a bound, or at or above one.

    The strike angle turns the part of the velocity that is in the plane; the part out of it, and what else moves before the impact,
    stays as it is.

    Args:
        scene: the landing; the joint's own value is not used, except that loops are followed from it.
        target: QUANTITY@PLACE, or QUANTITY of the robot as a whole; a point means the shock there.
        robot: the scene's robot, if it is loaded already.

    Raises:
        UnknownName: there is no such joint, quantity or place.
        StudyError: the question makes no sense.
        SolveError: no posture of the range has a result.
        ShockError: the landing cannot be computed.
    """
    given = [Bound(value, below) for value, below in ((max, False), (min, True)) if value is not None]
    if len(given) != 1:
        raise StudyError("one bound is needed: max for the greatest value that is allowed, or min for the least")
    bound = given[0]
    if not 0.0 < bound.value <= LARGEST:
        raise StudyError(f"a bound of {bound.value:g} is not valid; give one above zero, such as 0.1, and at most {LARGEST:g}")
    robot = robot or robot_of(scene)
    (profile,) = profiles({"": (scene, robot)})
    landing = profile.landing
    text = f"shock@{target.label}" if isinstance(target, Point) else target
    asked = column(profile, text)
    entry = asked.selection.quantity
    if entry.worse == ("greater" if bound.below else "less"):
        raise StudyError(f"the {entry.worse} value of {asked.name} is the worse one; bound it by {'max' if bound.below else 'min'}")
    if not (alone := entry.per_landing(profile.scene)):
        refuse_ground(scene, friction=False)  # what is feasible depends on the friction
    varied, joints, (low, high) = _varied(robot, joint, joint_range)
    names, unit = (tuple(one.name for one in joints), joints[0].unit) if joints else ((joint,), varied.unit.replace("deg", "rad"))
    if joints and landing.loops and landing.before.joint_rates.any():
        raise StudyError("how fast joints of a loop move depends on the posture; leave the joint velocities out")
    own = landing.strike_angle
    angles = _strike_range(landing.plane, (own, own) if alone and strikes is None else strikes)
    if not np.linalg.norm(landing.before.velocity @ np.stack([landing.plane.forward, [0.0, 0.0, 1.0]], axis=1)) > 0.0:
        raise StudyError(
            "the robot's velocity has no part in the plane that a strike angle could turn; give another plane or velocity"
        )
    step = (STEP[unit] * (20 if alone else 1) if joints else (high - low) / 200.0) if step is None else step
    if not step > 0.0 or (high - low) / step > MOST_POSTURES:
        raise StudyError(
            f"a step of {_value(step, unit)} from {_value(low, unit)} to {_value(high, unit)} is not possible; "
            f"give one above zero that makes at most {MOST_POSTURES} postures"
        )
    values = np.linspace(low, high, math.ceil((high - low) / step - 1e-9) + 1)
    scale = math.degrees(1.0) if unit == "rad" else 1.0
    scan = LimitScan(landing, asked, bound, varied, joints, values, scale, angles, CLOSABLE * STEP.get(unit, 0.0))
    if scan.unreachable and np.isnan(scan.own).all():
        raise SolveError(f"no posture from {_value(low, unit)} to {_value(high, unit)} has a result: {scan.unreachable[0][2]}")
    ends: tuple[End, End] = ("range" if scan.values[0] <= low else "loop", "range" if scan.values[-1] >= high else "loop")
    rows = tuple(_limits(scan, bound, ends, FINE.get(unit, 1e-8 * (high - low))))
    file_limits = _file_limits(joints) if joints else (-math.inf, math.inf)
    here = (present_value(landing, varied) / scale, own)
    return JointLimits(profile, asked, names, unit, bound, (low, high), file_limits, here, angles, step, scan, rows)


def _varied(
    robot: Robot, subject: str, given: tuple[float, float] | None
) -> tuple[Variation, tuple[Joint, ...], tuple[float, float]]:
    """What varies, its joints, and the range that is looked at [rad, m; the unit of another variation]."""
    kind, pattern = kind_of(robot, subject)
    if kind in NOT_LIMITED:
        raise StudyError(f"{subject} has no limits here: {NOT_LIMITED[kind]}")
    joints = settable_joints(robot, pattern, StudyError) if kind == "joint" else ()
    low, high = given or (motion_range(joints) if joints else (math.nan, math.nan))
    unit = joints[0].unit if joints else ""
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        what = f"from {_value(low, unit)} to {_value(high, unit)}" if math.isfinite(low + high) else "without limits in the file"
        what = what if given or joints else "not given"
        whose = f'joint "{subject}"' if joints else subject
        raise StudyError(f"the range of {whose} is {what}; give its least and greatest value with --range LOW:HIGH")
    scale = math.degrees(1.0) if unit == "rad" or kind in ATTITUDE else 1.0
    return variation(robot, subject, (scale * low, scale * high)), joints, (low, high)


def _file_limits(joints: Sequence[Joint]) -> tuple[float, float]:
    return max(joint.limits[0] for joint in joints), min(joint.limits[1] for joint in joints)


def _limits(scan: LimitScan, bound: Bound, ends: tuple[End, End], fine: float) -> Iterator[StrikeLimits]:
    """The intervals of the joint that keep the bound at each of the scan's targets.

    Landings are added where the spline of the number meets the bound, and at extrema that could reach it, until all are known.
    """
    at = np.searchsorted(scan.angles, [low for low, _ in scan.targets])
    numbers = [scan.numbers[:, k] if low == high else scan.worst[0] for k, (low, high) in zip(at, scan.targets, strict=True)]
    points = [(scan.values, own) for own in numbers]
    for _ in range(ROUNDS):
        asked = [_asked(x, bound.excess(own), fine) for x, own in points]
        if not any(map(len, asked)):
            break
        added = zip(points, asked, scan.at(asked), strict=True)
        points = [_merged(np.append(x, more), np.append(own, known)) for (x, own), more, known in added]
    for strikes, (x, own) in zip(scan.targets, points, strict=True):
        beyond = bound.excess(own)
        inside = beyond <= 0.0
        i = np.flatnonzero(inside[1:] != inside[:-1])
        roots = x[i] - beyond[i] * (x[i + 1] - x[i]) / (beyond[i + 1] - beyond[i])
        edges: list[tuple[float, End]] = [(float(root), "bound") for root in roots]
        edges = [(float(x[0]), ends[0])] * bool(inside[0]) + edges + [(float(x[-1]), ends[1])] * bool(inside[-1])
        allowed = [Interval(a, b, low, high) for (a, low), (b, high) in zip(edges[::2], edges[1::2], strict=True)]
        runs = itertools.groupby(zip(scan.feasible(*strikes).tolist(), scan.values.tolist(), strict=True), key=lambda one: one[0])
        lengths = [[value for _, value in run] for holds, run in runs if holds]
        feasible = tuple((run[0], run[-1]) for run in lengths)
        k = int(np.argmin(np.where([any(low <= value <= high for low, high in feasible) for value in x], beyond, np.inf)))
        known = bool(feasible) and np.isfinite(own[k])
        best, best_at = (float(own[k]), float(x[k])) if known else (math.nan, math.nan)
        yield StrikeLimits(strikes, tuple(allowed), feasible, best, best_at)


def _merged(x: Array, own: Array) -> tuple[Array, Array]:
    order = np.argsort(x)
    return x[order], own[order]


def _asked(x: Array, beyond: Array, fine: float) -> Array:
    """Where landings are still to be computed: at roots of the spline, and at extrema that may reach the bound, or are the best."""
    if len(x) < 3:
        return np.zeros(0)
    # A step changes the number by about as much on one side of an extremum as on the other.
    before, here, after = np.where(beyond[1:-1] > 0.0, 1.0, -1.0) * np.stack([beyond[:-2], beyond[1:-1], beyond[2:]])
    turning = (here <= np.minimum(before, after)) & (here < np.maximum(before, after) - here)
    turning[np.clip(np.argmin(beyond) - 1, 0, len(turning) - 1)] = True
    three = np.flatnonzero(turning)[:, None] + np.arange(3)
    extrema = np.concatenate([_vertex(x[three], beyond[three]), _kinks(x, beyond)])
    wanted = np.unique([*crossings(x, beyond[None])[1], *extrema])
    return np.asarray(wanted[np.abs(wanted[:, None] - x).min(axis=1) > fine])


def _kinks(x: Array, y: Array) -> Array:
    """Where the least value may lie between samples if two branches meet there: where lines through two samples each meet."""
    k = np.argmin(y) + np.array([[-2, -1, 0, 1], [-1, 0, 1, 2]])
    a, b, c, d = k[(k >= 0).all(axis=1) & (k < len(x)).all(axis=1)].T
    with np.errstate(all="ignore"):
        left, right = (y[b] - y[a]) / (x[b] - x[a]), (y[d] - y[c]) / (x[d] - x[c])
        at = (y[c] - y[b] + left * x[b] - right * x[c]) / (left - right)
    return np.asarray(at[(at >= x[b]) & (at <= x[c])])


def crossings(x: Array, y: Array) -> tuple[np.ndarray, Array]:
    """Where rows of samples y (m, n) at x (n,) change sign: rows (k,) and places (k,), on cubic splines, ascending."""
    inside = y <= 0.0
    row, j = np.nonzero(inside[:, 1:] != inside[:, :-1])
    pieces = CubicSpline(x, y, axis=1).c[:, j, row]
    low, high = np.zeros(len(j)), x[j + 1] - x[j]
    for _ in range(BISECTIONS):
        middle = (low + high) / 2.0
        first = (np.polyval(pieces, middle) <= 0.0) == inside[row, j]
        low, high = np.where(first, middle, low), np.where(first, high, middle)
    return row, x[j] + (low + high) / 2.0


def _vertex(x: Array, y: Array) -> Array:
    """The vertex (m,) of parabolas through three points (m, 3), kept between the outer ones; the middle one where there is none."""
    with np.errstate(all="ignore"):
        slopes = np.diff(y) / np.diff(x)
        vertex = (x[:, 0] + x[:, 1] - slopes[:, 0] * (x[:, 2] - x[:, 0]) / (slopes[:, 1] - slopes[:, 0])) / 2.0
    return np.clip(np.where(np.isfinite(vertex), vertex, x[:, 1]), x[:, 0], x[:, 2])


def _angles(low: float, high: float) -> Array:
    """The strike angles of a range that are computed [rad]."""
    return np.linspace(low, high, ANGLES) if high > low else np.array([low])


def _ranges(values: Array, refused: dict[int, str]) -> Iterator[tuple[float, float, str]]:
    """The ranges of consecutive postures without a result, with the first one's reason."""
    for first in sorted(refused.keys() - {k + 1 for k in refused}):
        last = next(k for k in itertools.count(first) if k + 1 not in refused)
        yield float(values[first]), float(values[last]), refused[first]


def _strike_range(plane: Plane, given: tuple[float, float] | None) -> tuple[float, float]:
    """The range of strike angles [rad], all of which approach the ground."""
    if plane.level:
        raise StudyError("no strike angle is defined in a horizontal plane; choose another plane")
    low, high = given or (math.radians(STRIKES[0]), math.radians(STRIKES[1]))
    most = math.radians(STEEPEST) * (1.0 + 1e-12)
    if not -most <= low <= high <= most:
        raise StudyError(
            f"strike angles from {_value(low, 'rad')} to {_value(high, 'rad')} are not a range of landings; "
            f"give the lesser one first, both between -{STEEPEST:g} and {STEEPEST:g} deg"
        )
    return low, high


def _value(value: float, unit: str) -> str:
    degrees = round(math.degrees(value), 12) + 0.0
    text = {"rad": f"{round(degrees, 2) or degrees:g}°", "m": f"{1e3 * value:.4g} mm"}.get(unit, f"{value:g} {unit}".rstrip(" -"))
    return text.replace("-", "−")
