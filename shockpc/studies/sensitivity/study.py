"""What would change a number of some landings most: its derivatives by every mass, inertia, joint value and the strike.

Each parameter is varied by a step and by half of it to both sides of its value, and the landings are computed as those of any other
study. Two central differences give the derivative, and how far they are apart its error: where they differ there is none. Over
several landings the number is the worst of them or their mean, and its change is that of the values to first order.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, NamedTuple, cast

import numpy as np

from shockpc.core.spatial import Array, read_only
from shockpc.evaluation.columns import Column, column, target_text
from shockpc.evaluation.declare import study
from shockpc.evaluation.evaluate import TRUSTED, Evaluation, profiles
from shockpc.evaluation.gradients import has_gradient
from shockpc.evaluation.gradients import slopes as exact_slopes
from shockpc.evaluation.source import common_robot, named_scenes, with_default_landings
from shockpc.evaluation.table import Table
from shockpc.evaluation.variation import OF_A_LINK, Variation, Vary, pairs, refuse_repeated, variation
from shockpc.landing.record import Option
from shockpc.landing.scene import Point, Scene
from shockpc.quantities.profile import ShockProfile
from shockpc.robot.changes import Property
from shockpc.robot.robot import Robot
from shockpc.studies.sensitivity.rows import (
    STEPS,
    Parameter,
    ParameterKind,
    VariedOneByOne,
    link_parameters,
    parameters,
    swept_parameter,
)
from shockpc.text.errors import StudyError
from shockpc.text.printed import UNITS
from shockpc.text.trace import Trace

ZERO = 1e-12
"""Share of its natural size below which a number is zero but for rounding."""

SETTLED, SMALL = 1e-3, 1e-4
"""Largest error of a difference with which it is a derivative, as a share of it, or of the number for a change by the size."""

ROUNDING = 4.0
"""Rounding of a derivative, at most, relative to the median of what rounding leaves of second differences."""

FORMULA = 1e-10
"""Rounding of a derivative that a formula gives, at most, as a share of the largest one."""

UNSETTLED = (
    "the difference does not settle: the number has a kink or a jump near this value, such as where a contact opens, its lowest "
    "point jumps, or contacts or loops depend on one another at this value alone"
)

ParameterKey = tuple[ParameterKind, str, str]
"""What a parameter is called: kind, axis and name."""


@dataclass(frozen=True, eq=False)
class ParameterChange:
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

    kind: ParameterKind
    axis: str
    name: str
    value: float
    unit: str
    step: float
    parts: Mapping[ParameterKey, float]


@dataclass(frozen=True, eq=False)
class Effect(ParameterChange):
    """What a change does; derivatives that do not exist are NaN.

    Attributes:
        derivatives: (L,) of the number in each landing [its unit/unit].
        error: largest error of these [its unit/unit].
        reason: why there are no derivatives; empty if there are.
        formula: whether they are those of a formula, and not differences.
        up: change of the target by the step [its unit].
        down: change by the opposite step [its unit].
    """

    derivatives: Array
    error: float
    reason: str
    formula: bool
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
        effects: of every change: bodies first, then joints, then the strike.
    """

    landings: tuple[str, ...]
    profiles: tuple[ShockProfile, ...] = field(repr=False)
    target: Column
    values: Array
    mean: bool
    percent: float
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
        return tuple(sorted(known, key=lambda effect: -max(abs(effect.up), np.nan_to_num(abs(self.opposite(effect))))))

    def opposite(self, effect: Effect) -> float:
        """Change of the target by the opposite step [its unit]; NaN where less than none would be left of a mass or an armature."""
        landing, step = self.profiles[0].landing, abs(effect.step)
        armatures = {name: abs(weight) for (kind, _, name), weight in effect.parts.items() if kind == "armature"}
        less = (landing.joint_model.armature[landing.robot.joint(name).v].min() < step * w for name, w in armatures.items())
        return math.nan if (effect.kind == "mass" and effect.value < step) or any(less) else effect.down

    @property
    def table(self) -> Table:
        """A row for each effect as `ranked`, then those without a derivative, whose messages say why; angles in degrees."""
        name = self.target.selection.name
        target = f"{name} [{self.target.unit}]"
        header = (
            "parameter",
            "of",
            "value",
            "unit",
            "step",
            target,
            f"change of {name} [%]",
            f"opposite {target}",
            f"error {target}",
        )
        effects = (*self.ranked, *(effect for effect in self.effects if effect.reason))
        rows = []
        for x in effects:
            size, unit = UNITS.get(x.unit, (1.0, x.unit))
            value, step = (round(size * number, 12) + 0.0 if size != 1.0 else number for number in (x.value, x.step))
            changes = (x.up, 100.0 * x.up / self.value, self.opposite(x), x.step * x.error)
            rows.append((f"{x.kind} {x.axis}".strip(), x.name or None, value, unit, step, *changes))
        return Table.of_rows(header, rows, {i: effect.reason for i, effect in enumerate(effects) if effect.reason})

    def error(self, effects: Iterable[Effect]) -> float:
        """The largest error of the derivatives of some effects, each as a share of its largest [1]."""
        shares = [effect.error / largest for effect in effects if (largest := float(np.abs(effect.derivatives).max())) > 0.0]
        return max(shares, default=0.0)

    def worse(self, change: float) -> bool | None:
        """Whether a change of the target makes it worse; None if neither direction is worse."""
        entry = self.target.selection.quantity
        sign = math.copysign(1.0, self.value) if self.target.selection.signed else 1.0
        return None if entry.worse == "neither" else (change * sign > 0.0) == (entry.worse == "greater")


@study(
    "shockpc sensitivity anymal_b --contact LF_FOOT --at imu_link",
    "shockpc sensitivity go2 --at imu --group '*_thigh' --group '*_calf'",
    "shockpc sensitivity anymal_b --quantity joint_impulse@LF_KFE --vary 'mass:*_SHANK=0.8x:1.2x' --vary LF_KFE=-80:-40",
    more=(
        "Without --contact the landings are those on all level feet together, on each edge of their support, and on each "
        "foot. What counts is the worst landing, or with --mean the mean of"
        " all. Every parameter is changed by the same share of its size; with --vary only those that are named, each by that"
        " share of its range."
    ),
    reads="landings",
    passed=("target", "trace"),
)
def sensitivity(
    landings: Scene | Mapping[str, Scene],
    target: str | Point,
    robot: Robot | None = None,
    *,
    mean: Annotated[bool, Option("The mean over the landings, not the worst of them.", "Question")] = False,
    groups: Annotated[
        Sequence[str],
        Option(
            "Bodies and joints, such as the left and right legs, whose values change together by one factor, each away from zero.",
            "Changes",
            "NAME",
            "group",
        ),
    ] = (),
    vary: Annotated[
        Vary,
        Option(
            "Change only these, over these ranges (a:b, factors ax:bx, m±s), each by a share of its range: joints [deg; m if "
            "prismatic], mass:LINK, armature:JOINT, strike-angle, friction, or what else sweep varies.",
            "Changes",
            "NAME=RANGE",
        ),
    ] = (),
    percent: Annotated[
        float, Option("How far, in per cent of the range or of the size.", "Changes", "P", least=1e-3, greatest=100.0)
    ] = 1.0,
    trace: Trace | None = None,
) -> Sensitivity:
    """The derivatives of a number of some landings, each a difference with an error.

    Contact points stay where they are on their links; one that is the lowest point of a link moves as the link turns. Joints that
    follow others follow, and loops stay closed.

    Args:
        landings: one landing, or landings of one robot by name.
        target: KEY@PLACE, or KEY of the robot as a whole; a point means the shock there, with friction if a
            scene has it.
        robot: the scenes' robot, if it is loaded already.
        trace: collects what each stage cost.

    Raises:
        UnknownName: there is no such quantity, place, body or joint.
        StudyError: the number does not exist in a landing, or is zero, where a length has no derivative.
        ShockError: a landing cannot be computed.
    """
    trace = trace or Trace()
    scenes = named_scenes(landings)
    robot = robot or common_robot(scenes)
    scenes = with_default_landings(scenes, robot)
    chosen = [variation(robot, subject, values) for subject, values in pairs(vary)]
    if chosen and groups:
        raise StudyError(
            "groups are of all parameters, and vary names those that change, of which a glob is one; leave one of the two out"
        )
    refuse_repeated(robot, chosen)
    solved = tuple(profiles({name: (scene, robot) for name, scene in scenes.items()}, trace).values())
    text = target_text(target, scenes.values())
    numbers = [column(profile, text) for profile in solved]
    number = numbers[0]
    values = np.array([_value(*pair) for pair in zip(solved, numbers, strict=True)])
    by_landing = [{parameter[:3]: parameter for parameter in parameters(profile.landing)} for profile in solved]
    share = percent / 100.0
    changes = [_varied(robot, solved, by_landing, varied, share) for varied in chosen] or _changes(robot, by_landing, groups, share)
    slopes = []
    for profile, known, its_number in zip(solved, by_landing, numbers, strict=True):
        with trace.stage("derivatives"):
            wanted = {key: known[key] for key in known if any(key in change.parts for change in changes)}
            slopes.append(_slopes(profile, wanted, its_number))
    signs = np.sign(values) if len(values) > 1 and number.selection.signed else np.ones(len(values))
    effects = tuple(_effect(change, slopes, number, mean, signs, signs * values) for change in changes)
    existing = [effect.derivatives for effect in effects if not effect.reason]
    if existing and not chosen and not np.any(existing):
        raise StudyError(f"{number.title} does not change to first order with any parameter here; choose another quantity")
    return Sensitivity(tuple(scenes), solved, number, signs * values, mean, percent, effects)


def _in_any(by_landing: Sequence[Mapping[ParameterKey, Parameter]]) -> dict[ParameterKey, Parameter]:
    """The parameters of all landings, each as the first one that has it does."""
    first: dict[ParameterKey, Parameter] = {}
    for known in by_landing:
        first |= {key: parameter for key, parameter in known.items() if key not in first}
    return first


def _worst(target: Column, values: Array) -> int:
    """The landing with the worst value; of a quantity that is not worse in either direction that with the greatest."""
    return int(target.selection.worse(values).argmax())


def _changes(
    robot: Robot, by_landing: Sequence[Mapping[ParameterKey, Parameter]], groups: Sequence[str], share: float
) -> list[ParameterChange]:
    """Every parameter by a share of its size; those of a group together, each away from zero."""
    pattern_of: dict[str, str] = {}
    for pattern in groups:
        for name in robot.match("body or joint", pattern, dict.fromkeys([*robot.links, *robot.joint_names])):
            frame = robot.frames.get(name)
            pattern_of.setdefault(name if name in robot.joint_names or frame is None else robot.bodies[frame.body].name, pattern)
    changes: dict[ParameterKey, ParameterChange] = {}
    for key, parameter in _in_any(by_landing).items():
        kind, axis, name = key
        if name not in pattern_of:
            changes[key] = ParameterChange(*key, parameter.value, parameter.unit, share * parameter.size, {key: 1.0})
            continue
        together: ParameterKey = (kind, axis, pattern_of[name])
        parts = dict(changes[together].parts) if together in changes else {}
        parts[key] = math.copysign(parameter.size, parameter.value or 1.0)
        changes[together] = ParameterChange(*together, math.nan, "1", share, parts)
    return list(changes.values())


def _varied(
    robot: Robot,
    solved: Sequence[ShockProfile],
    by_landing: Sequence[dict[ParameterKey, Parameter]],
    varied: Variation,
    share: float,
) -> ParameterChange:
    """A subject as `sweep` varies it, by a share of its range; what is no parameter yet becomes one of each landing.

    Raises:
        StudyError: it has no derivative, or no range.
    """
    if varied.kind == "contact":
        raise StudyError("contacts have names, by which nothing has a derivative; compute each landing with shockpc sweep")
    low, high = varied.ends
    step = share * (high - low) * (math.radians(1.0) if varied.unit == "deg" else 1.0)
    kinds = {"joint": "angle", "armature": "armature", "strike-angle": "strike"}
    if varied.kind in kinds:
        kind = kinds[varied.kind]
        names = ("",) if kind == "strike" else robot.match_joints(varied.target)
        of_joints = {key: parameter for key, parameter in _in_any(by_landing).items() if key[0] == kind and key[2] in names}
        weights = {key: parameter.value if varied.factor else 1.0 for key, parameter in of_joints.items()}
        if not any(weights.values()):
            raise StudyError(
                f"{varied.subject} changes nothing here: these joints are locked, follow others, or have no value to multiply"
            )
        first = next(iter(of_joints.values()))
        value, unit = first.value if len(of_joints) == 1 else math.nan, "1" if varied.factor else first.unit
        return ParameterChange(kind, "", varied.target, value, unit, step, weights)
    if varied.kind in OF_A_LINK:
        parts = list(link_parameters(robot, cast(Property, varied.kind), varied.target, varied.factor))
        new = [parts] * len(by_landing)
    else:
        new = [[swept_parameter(profile.landing, varied)] for profile in solved]
    for known, added in zip(by_landing, new, strict=True):
        known |= {parameter[:3]: parameter for parameter in added}
    (kind, axis, _), unit, present = new[0][0][:3], new[0][0].unit, {parameter.value for added in new for parameter in added}
    value = present.pop() if len(present) == 1 else math.nan
    return ParameterChange(kind, axis, varied.target, value, unit, step, {parameter[:3]: 1.0 for parameter in new[0]})


def _effect(
    change: ParameterChange,
    slopes: Sequence[Mapping[ParameterKey, "_Slope"]],
    target: Column,
    mean: bool,
    signs: Array,
    values: Array,
) -> Effect:
    """What a change does to the number in each landing, of which magnitudes count where the signs are not 1, and to the target."""
    parts = [[(weight, known[key]) for key, weight in change.parts.items() if key in known] for known in slopes]
    reason = next((slope.reason for of_landing in parts for _, slope in of_landing if slope.reason), "")
    derivatives = signs * [sum(weight * slope.value for weight, slope in of_landing) for of_landing in parts]
    derivatives = np.full_like(derivatives, np.nan) if reason else derivatives
    error = max(sum(abs(weight) * slope.error for weight, slope in of_landing) for of_landing in parts)
    formula = all(slope.formula for of_landing in parts for _, slope in of_landing)
    now = values[_worst(target, values)]

    def effect(step: float) -> float:
        k = _worst(target, values + step * derivatives)
        return float(step * derivatives.mean() if mean else values[k] - now + step * derivatives[k])

    up, down = effect(change.step), effect(-change.step)
    return Effect(**vars(change), derivatives=read_only(derivatives), error=error, reason=reason, formula=formula, up=up, down=down)


class _Slope(NamedTuple):
    """A derivative of the number in a landing, its error, why there is none, and whether it is that of a formula."""

    value: float
    error: float = 0.0
    reason: str = ""
    formula: bool = False


def _slopes(profile: ShockProfile, wanted: Mapping[ParameterKey, Parameter], number: Column) -> dict[ParameterKey, _Slope]:
    """The derivatives of the number by the parameters that are wanted: differences of landings beside the given one.

    Of two steps h and h/2 the central differences D(h) and D(h/2) give (4 D(h/2) − D(h)) / 3, off by h⁴ (Richardson). The error is
    stated as |D(h) − D(h/2)|, or as the part of the second differences that does not vanish with h, which is that of a kink or a
    jump, if that is larger. Of most parameters this part is rounding, which is added, and a smaller derivative is zero. By the
    posture and the strike some numbers have a derivative without differences.

    Args:
        profile: the given landing.
        wanted: the parameters.
        number: the number.
    """
    varied = {key: parameter for key, parameter in wanted.items() if not parameter.reason}
    # Before the formulas, so that a ground on which the number does not depend is refused with them too.
    evaluation = Evaluation(VariedOneByOne(profile.landing, tuple(varied.values())), (number,), prove=0, trusted=TRUSTED)
    slopes = {key: _Slope(np.nan, reason=parameter.reason) for key, parameter in wanted.items()} | _formulas(
        profile, varied, number
    )
    varied = {key: parameter for key, parameter in varied.items() if not slopes[key].formula}
    if not varied:
        return slopes
    source = VariedOneByOne(profile.landing, tuple(varied.values()))
    table = replace(evaluation, landings=source).table().without_defects()
    here = _number(profile, number)
    after, before = np.moveaxis(table.values(number).reshape(-1, 2, len(STEPS) // 2), 1, 0)
    steps = source.steps[:, None] * STEPS[: len(STEPS) // 2]
    (whole, half), (bend, kink) = ((after - before) / (2.0 * steps)).T, ((after - 2.0 * here + before) / steps).T
    left = np.abs(2.0 * kink - bend)
    rounding = ROUNDING * np.median(np.nan_to_num(left * source.steps)) / source.steps
    for k, (key, parameter) in enumerate(varied.items()):
        value, error = (4.0 * half[k] - whole[k]) / 3.0, max(abs(whole[k] - half[k]), left[k]) + rounding[k]
        message = next((table.messages[i] for i in range(len(STEPS) * k, len(STEPS) * (k + 1)) if i in table.messages), "")
        if message:
            slopes[key] = _Slope(np.nan, reason=f"beside this value there is no such number: {message}")
        elif not error <= max(SETTLED * abs(value), SMALL * abs(here) / (parameter.size or 1.0)):
            slopes[key] = _Slope(np.nan, float(error), UNSETTLED)
        else:
            slopes[key] = _Slope(float(value) if abs(value) > rounding[k] else 0.0, float(error))
    return slopes


def _formulas(profile: ShockProfile, varied: Mapping[ParameterKey, Parameter], number: Column) -> dict[ParameterKey, _Slope]:
    """The derivatives by angles and by the strike, where double precision has formulas for them: by a strike at constant speed."""
    landing = profile.landing
    kinds = ("angle", "strike") if landing.scene.strike.drop_height is None else ("angle",)
    linear = {key: one for key, one in varied.items() if one.kind in kinds and one.rates.keys() <= {"joints", "velocity"}}
    if not linear or profile.redundant or not has_gradient(landing, number):
        return {}
    rates = np.array([[one.rates.get("joints", np.zeros(landing.robot.model.nv)) for one in linear.values()]])
    turns = np.array([[[one.rates.get("velocity", np.zeros(3))] for one in linear.values()]])
    numbers, unclear = exact_slopes(landing, landing.q[None], landing.before.velocity[None, None], rates, turns, [number])
    if unclear[0]:
        return {}
    derivatives = numbers[number.name][1][0, 0]
    error = FORMULA * float(np.abs(derivatives).max(initial=0.0))
    values = np.where(np.abs(derivatives) > error, derivatives, 0.0)
    return {key: _Slope(float(value), error, formula=True) for key, value in zip(linear, values, strict=True) if np.isfinite(value)}


def _number(profile: ShockProfile, number: Column) -> float:
    return float(number.selection.scalar(profile.values(number.selection.quantity, [number.place]))[0])


def _value(profile: ShockProfile, number: Column) -> float:
    """The number.

    Raises:
        StudyError: there is none, or it is zero.
    """
    entry, value = number.selection.quantity, _number(profile, number)
    if not math.isfinite(value):
        raise StudyError(f"there is no {number.title} in this landing: {entry.missing or 'it is infinite'}")
    where = [number.place]
    size = profile.proof.read(lambda impact: float(np.max(entry.size(impact, entry.compute(impact, where).astype(float)))))
    if abs(value) <= ZERO * max(size, abs(value)):
        raise StudyError(
            f"{number.title} is zero in this landing: a length has no derivative where it is zero, and changes cannot be relative "
            "to it; name another place, or change the strike"
        )
    return value
