"""What would change a number of some landings most: its derivatives by every mass, inertia, joint value and the strike.

Each parameter is changed by 2^-100 in ball arithmetic, and the quantity is computed anew (`exact.derivative`): one way for every
quantity of the table and every parameter, exact to the last digit of a double. What is computed in double precision (extremes over
geometry, friction, contacts of finite stiffness) has central differences of the same landing with the parameter varied, and their
error. Over several landings the number is the worst of them or their mean, and its change is that of the values to first order.
"""

import functools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, cast

import numpy as np

from shockpc.core.spatial import Array, read_only
from shockpc.evaluation.columns import Column, column
from shockpc.evaluation.variation import OF_A_LINK, variation
from shockpc.impact.exact.derivative import central_difference, derivatives
from shockpc.impact.exact.solution import BallImpact
from shockpc.landing.scene import Point, Scene
from shockpc.profile import shock_profile
from shockpc.quantities.profile import ShockProfile
from shockpc.robot.changes import Property
from shockpc.robot.robot import Robot
from shockpc.studies.parameters import Kind, Parameter, in_doubles, link_parameters, parameters
from shockpc.studies.question import common_robot, refuse_ground
from shockpc.text.errors import ShockError, StudyError
from shockpc.text.trace import Trace

ZERO = 1e-12
"""Share of its natural size below which a number is zero but for rounding."""

STEP = 2.0**-8
"""Step of differences in double precision, as a share of the size of the parameter."""

SETTLED, SMALL = 1e-3, 1e-4
"""Largest error of such a difference with which it is a derivative, as a share of it, or of the number for a change by the size."""

Key = tuple[Kind, str, str]
"""What a parameter is called: kind, axis and name."""


@dataclass(frozen=True, eq=False)
class Change:
    """A change of one parameter, or of several together.

    Attributes:
        kind: of the parameters.
        axis: which component of them, such as "x" or "xy"; empty if there is one.
        name: body or joint, or the pattern of several; empty for the strike.
        value: present value [unit]; NaN where it is not one value.
        unit: SI unit; "1" for a share of the present values, or of their sizes.
        step: how large the change is [unit].
        parts: how much each parameter changes by a unit.
    """

    kind: Kind
    axis: str
    name: str
    value: float
    unit: str
    step: float
    parts: Mapping[Key, float]


@dataclass(frozen=True, eq=False)
class Effect(Change):
    """What a change does; derivatives that do not exist are NaN.

    Attributes:
        derivatives: (L,) of the number in each landing [its unit/unit].
        error: largest error of these, if they are differences; 0 of exact ones [its unit/unit].
        reason: why there are no derivatives; empty if there are.
        up: change of the target by the step [its unit].
        down: change by the opposite step [its unit].
    """

    derivatives: Array
    error: float
    reason: str
    up: float
    down: float


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """What changes a number of some landings.

    Attributes:
        landings: names of the landings.
        profiles: their results.
        target: the number.
        values: (L,) of it in each landing; of several landings the magnitudes [its unit].
        mean: whether the mean over the landings is the target, and not the worst of them.
        percent: steps as a share of the parameters' sizes, or of the ranges that are given [%].
        exact: whether the derivatives are exact, and not differences.
        effects: of every change: bodies first, then joints, then the strike.
    """

    landings: tuple[str, ...]
    profiles: tuple[ShockProfile, ...] = field(repr=False)
    target: Column
    values: Array
    mean: bool
    percent: float
    exact: bool
    effects: tuple[Effect, ...]

    @property
    def value(self) -> float:
        """The target: the number, the worst of several, or their mean [its unit]."""
        return float(self.values.mean() if self.mean else self.values[_worst(self.target, self.values)])

    @property
    def worst(self) -> str:
        """The landing in which the number is the worst."""
        return self.landings[_worst(self.target, self.values)]

    @property
    def ranked(self) -> tuple[Effect, ...]:
        """The effects that exist, the step with the largest change of the target first."""
        known = (effect for effect in self.effects if not effect.reason)
        return tuple(sorted(known, key=lambda effect: -max(abs(effect.up), abs(effect.down))))

    def digits(self, effects: Iterable[Effect]) -> int:
        """Number of digits to which some derivatives are known at least, where they are differences."""
        shares = [effect.error / largest for effect in effects if (largest := float(np.abs(effect.derivatives).max())) > 0.0]
        return max(0, math.floor(-math.log10(max([*shares, 1e-15]))))

    def worse(self, change: float) -> bool | None:
        """Whether a change of the target makes it worse; None if neither direction is worse."""
        entry = self.target.selection.quantity
        sign = math.copysign(1.0, self.value) if self.target.selection.signed else 1.0
        return None if entry.worse == "neither" else (change * sign > 0.0) == (entry.worse == "greater")


def sensitivity(
    landings: Scene | Mapping[str, Scene],
    target: str | Point,
    robot: Robot | None = None,
    *,
    mean: bool = False,
    groups: Sequence[str] = (),
    vary: Iterable[tuple[str, Any]] = (),
    percent: float = 1.0,
    trace: Trace | None = None,
) -> Sensitivity:
    """The derivatives of a number of some landings: exact, or differences where the number is computed in double precision.

    Contact points stay where they are on their links; one that is the lowest point of a link moves as the link turns. Joints that
    follow others follow, and loops stay closed.

    Args:
        landings: one landing, or landings of one robot by name.
        target: QUANTITY@PLACE, or QUANTITY of the robot as a whole; a point means the shock there.
        robot: the scenes' robot, if it is loaded already.
        mean: whether the mean over several landings is the target, and not the worst of them.
        groups: names or globs of bodies and joints whose values change by one factor, each away from zero.
        vary: subjects with their ranges, as in `variation`; then only these are changed, each by a share of its range.
        percent: this share, or that of the parameters' own sizes [%].
        trace: collects what each stage cost.

    Raises:
        UnknownName: there is no such quantity, place, body or joint.
        StudyError: the number does not exist in a landing, or is zero, where a length has no derivative.
        ShockError: a landing cannot be computed.
    """
    trace = trace or Trace()
    scenes = {"": landings} if isinstance(landings, Scene) else landings
    if not 0.0 < percent <= 100.0:
        raise StudyError(f"a step of {percent:g} % is not valid; give one above zero and at most 100")
    robot = robot or common_robot(scenes)
    profiles = tuple(shock_profile(scene, robot, trace) for scene in scenes.values())
    text = f"shock@{target.label}" if isinstance(target, Point) else target
    asked = [column(profile, text, lambda entry: entry.compute is not None and entry.key != "feasible") for profile in profiles]
    entry = asked[0].selection.quantity
    for scene in scenes.values():
        if not entry.of_ground(scene):
            refuse_ground(scene, others="name a quantity that depends on it, such as shock_friction or peak_force")
    values, sizes, exact = np.array([_value(*pair) for pair in zip(profiles, asked, strict=True)]).T
    known = [{one[:3]: one for one in parameters(profile)} for profile in profiles]
    every: dict[Key, Parameter] = {key: one for of_landing in reversed(known) for key, one in of_landing.items()}
    every = {key: every[key] for of_landing in known for key in of_landing}
    chosen = list(vary)
    share = percent / 100.0
    changes = [_varied(robot, every, known, *one, share) for one in chosen] or _changes(robot, every, groups, share)
    rows = []
    for profile, of_landing, own, size in zip(profiles, known, asked, sizes, strict=True):
        with trace.stage("derivatives"):
            wanted = {key: one for key, one in of_landing.items() if any(key in change.parts for change in changes)}
            rows.append(_derivatives(profile, wanted, own, size) if exact.all() else _differences(profile, wanted, own))
    signs = np.sign(values) if len(values) > 1 and asked[0].selection.signed else np.ones(len(values))
    effects = tuple(_effect(change, rows, asked[0], mean, signs, signs * values) for change in changes)
    existing = [effect.derivatives for effect in effects if not effect.reason]
    if existing and not chosen and not np.any(existing):
        raise StudyError(f"{asked[0].title} does not change to first order with any parameter here; choose another quantity")
    return Sensitivity(tuple(scenes), profiles, asked[0], signs * values, mean, percent, bool(exact.all()), effects)


def _worst(target: Column, values: Array) -> int:
    """The landing with the worst value; of a quantity that is not worse in either direction that with the greatest."""
    return int(values.argmin() if target.selection.quantity.worse == "less" else values.argmax())


def _changes(robot: Robot, every: Mapping[Key, Parameter], groups: Sequence[str], share: float) -> list[Change]:
    """Every parameter by a share of its size; those of a group together, each away from zero."""
    owner: dict[str, str] = {}
    for pattern in groups:
        for name in robot.match("body or joint", pattern, dict.fromkeys([*robot.links, *robot.joint_names])):
            frame = robot.frames.get(name)
            owner.setdefault(name if name in robot.joint_names or frame is None else robot.bodies[frame.body].name, pattern)
    changes: dict[Key, Change] = {}
    for (kind, axis, name), one in every.items():
        if name not in owner:
            changes[one[:3]] = Change(*one[:3], one.value, one.unit, share * one.size, {one[:3]: 1.0})
            continue
        key: Key = (kind, axis, owner[name])
        parts = {**(changes[key].parts if key in changes else {}), one[:3]: math.copysign(one.size, one.value or 1.0)}
        changes[key] = Change(*key, math.nan, "1", share, parts)
    return list(changes.values())


def _varied(
    robot: Robot, every: Mapping[Key, Parameter], known: Sequence[dict[Key, Parameter]], subject: str, values: Any, share: float
) -> Change:
    """A subject as `sweep` varies it, by a share of its range.

    Raises:
        StudyError: it has no derivative, or no range.
    """
    one = variation(robot, subject, values)
    span = one.span or tuple(value for value in one.values if isinstance(value, float))
    width = max(span, default=0.0) - min(span, default=0.0)
    if not width > 0.0:
        raise StudyError(f"{subject} has no range; give one, such as {subject}=LOW:HIGH")
    if one.kind in OF_A_LINK:
        parts = {own[:3]: own for own in link_parameters(robot, cast(Property, one.kind), one.target, one.factor)}
        for of_landing in known:
            of_landing |= parts
        (kind, axis, _), own = next(iter(parts.items()))
        return Change(kind, axis, one.target, math.nan, own.unit, share * width, dict.fromkeys(parts, 1.0))
    kinds: dict[str, Kind] = {"joint": "angle", "armature": "armature", "strike-angle": "strike"}
    if one.kind not in kinds:
        raise StudyError(
            f"{subject} cannot be changed here; valid are strike-angle, joints, armature:JOINT, "
            + ", ".join(f"{kind}:LINK" for kind in OF_A_LINK)
        )
    kind = kinds[one.kind]
    names = ("",) if kind == "strike" else robot.match_joints(one.target)
    weights = {key: own.value if one.factor else 1.0 for key, own in every.items() if key[0] == kind and key[2] in names}
    if not any(weights.values()):
        raise StudyError(f"{subject} changes nothing here: these joints are locked, follow others, or have no value to multiply")
    (first, *others) = (every[key] for key in weights)
    size = math.radians(1.0) if one.unit == "deg" else 1.0
    unit = "1" if one.factor else first.unit
    return Change(kind, "", one.target, math.nan if others else first.value, unit, share * width * size, weights)


def _effect(
    change: Change, rows: Sequence[Mapping[Key, "_Slope"]], target: Column, mean: bool, signs: Array, values: Array
) -> Effect:
    """What a change does to the number in each landing, of which magnitudes count where the signs are not 1, and to the target."""
    parts = [[(weight, row[key]) for key, weight in change.parts.items() if key in row] for row in rows]
    reason = next((slope.reason for of_landing in parts for _, slope in of_landing if slope.reason), "")
    own = signs * [sum(weight * slope.value for weight, slope in of_landing) for of_landing in parts]
    own = np.full_like(own, np.nan) if reason else own
    error = max(sum(abs(weight) * slope.error for weight, slope in of_landing) for of_landing in parts)
    now = values[_worst(target, values)]

    def effect(step: float) -> float:
        k = _worst(target, values + step * own)
        return float(step * own.mean() if mean else values[k] - now + step * own[k])

    up, down = effect(change.step), effect(-change.step)
    return Effect(**vars(change), derivatives=read_only(own), error=error, reason=reason, up=up, down=down)


class _Slope(NamedTuple):
    """A derivative of the number in a landing, its error, and why there is none."""

    value: float
    error: float = 0.0
    reason: str = ""


def _derivatives(profile: ShockProfile, wanted: Mapping[Key, Parameter], asked: Column, size: float) -> dict[Key, _Slope]:
    """The exact derivatives of the number by the parameters that are wanted."""
    paths = {key: one.path for key, one in wanted.items() if one.path is not None}
    slopes = derivatives(profile.proof, list(paths.values()), functools.partial(_number, asked), size)
    known = dict(zip(paths, map(_Slope, slopes.tolist()), strict=True))
    return {key: known.get(key, _Slope(np.nan, reason=one.reason)) for key, one in wanted.items()}


def _differences(profile: ShockProfile, wanted: Mapping[Key, Parameter], asked: Column) -> dict[Key, _Slope]:
    """Differences of the number of the same landing with each parameter varied, in double precision."""
    proof = profile.proof
    here = float(proof.read(functools.partial(_number, asked)))

    def slope(one: Parameter) -> _Slope:
        if (path := one.path) is None:
            return _Slope(np.nan, reason=one.reason)

        def number(t: float) -> float:
            return float(proof.read(lambda impact: _number(asked, BallImpact(in_doubles(path(impact, t)), impact.choice))))

        step = one.size or 1.0
        try:
            value, error = central_difference(number, here, STEP * step)
        except ShockError as refusal:
            return _Slope(np.nan, reason=f"beside this value there is no such number: {refusal}")
        if not error <= max(SETTLED * abs(value), SMALL * abs(here) / step):
            reason = (
                "the difference does not settle: the number has a kink or a jump near this value, such as where a contact opens"
            )
            return _Slope(np.nan, error, reason)
        return _Slope(value, error)

    return {key: slope(one) for key, one in wanted.items()}


def _value(profile: ShockProfile, asked: Column) -> tuple[float, float, bool]:
    """The number, its natural size, and whether it is computed in ball arithmetic.

    Raises:
        StudyError: there is none, or it is zero.
    """
    entry = asked.selection.quantity
    value = float(asked.selection.scalar(profile.values(entry, [asked.place]))[0])
    if not math.isfinite(value):
        raise StudyError(f"there is no {asked.title} in this landing: {entry.missing or 'it is infinite'}")

    def natural_size(impact: BallImpact) -> tuple[float, bool]:
        values = entry.formula(impact, [asked.place])
        exact = values.dtype == object and not entry.of_ground(profile.scene)
        return float(np.max(entry.size(impact, values.astype(float)))), exact

    size, exact = profile.proof.read(natural_size)
    if abs(value) <= ZERO * max(size, abs(value)):
        raise StudyError(
            f"{asked.title} is zero in this landing: a length has no derivative where it is zero, and changes cannot be relative "
            "to it; name another place, or change the strike"
        )
    return value, max(size, abs(value)), exact


def _number(asked: Column, impact: BallImpact) -> Any:
    """The number of an impact."""
    return asked.selection.scalar(np.asarray(asked.selection.quantity.formula(impact, [asked.place])[0, 0]))[0]
