"""Changes with the largest effects on a number of some landings, from its derivatives.

The derivatives are by every mass, inertia, joint value and the strike. Each parameter is what a
sweep varies, and is set on both sides of its value, all others left as they are. Two central
differences give the derivative, and how far they are apart its error: where they differ there is
none. Over several landings the number is the worst of them or their mean, and its change is that of
the values to first order.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import chain
from typing import Annotated, NamedTuple

import numpy as np

from shockpc.core.spatial import Array, read_only
from shockpc.evaluation.column import Column, column, target_text
from shockpc.evaluation.declare import study
from shockpc.evaluation.drive_ends import End, at_drive_ends
from shockpc.evaluation.named_scenes import common_robot, named_scenes, with_default_landings
from shockpc.evaluation.profiles import profiles
from shockpc.evaluation.table import Table
from shockpc.evaluation.variations.variation import Variation, prepared
from shockpc.evaluation.variations.vary import (
    Vary,
    each_of,
    pairs,
    refuse_repeated,
    variation,
)
from shockpc.impact.impact import Impact
from shockpc.landing.scenes.scene import Point, Scene
from shockpc.landing.scenes.scene_fields import Option
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.robot.robot import Robot
from shockpc.studies.sensitivity.slopes import (
    Parameter,
    Slope,
    number_of,
    parameters,
    slopes_beside,
)
from shockpc.text.display import brief, shown_by
from shockpc.text.errors import ShockError, StudyError
from shockpc.text.printed import shown_as
from shockpc.text.trace import Trace

ZERO = 1e-12
"""Share of its natural size below which a number is zero but for rounding."""


@dataclass(frozen=True, eq=False)
class ParameterChange:
    """A change of one parameter, or of several together.

    Attributes:
        parameter: the name by which a sweep varies it, such as "mass:LINK" or a joint; a pattern of
            several.
        value: present value [unit]; NaN where it is not one value.
        unit: of it; "-" for a share of the present values, or of their sizes.
        step: how large the change is [unit].
        share: the same as a share of what there is; NaN where it is an angle, a length, or part of
            a range.
        parts: how much each parameter changes by a unit.
    """

    parameter: str
    value: float
    unit: str
    step: float
    share: float
    parts: Mapping[str, float]

    @property
    def step_text(self) -> str:
        """The step in words: a share, an angle or a length."""
        if not math.isnan(self.share):
            return f"{100.0 * self.share:.3g} %"
        return shown_as(self.step, self.unit).removesuffix(" -")


@dataclass(frozen=True, eq=False)
class Effect(ParameterChange):
    """The effect of a change; derivatives that do not exist are NaN.

    Attributes:
        derivatives: (L,) of the number in each landing [its unit/unit].
        error: largest error of these [its unit/unit].
        reason: why there are no derivatives; empty if there are.
        up: change of the target by the step [its unit].
        down: change by the opposite step [its unit]; NaN where less than none would be left of a
            mass or an armature.
    """

    derivatives: Array
    error: float
    reason: str
    up: float
    down: float

    @property
    def largest(self) -> float:
        """The larger one of both changes of the target [its unit]."""
        return max(abs(self.up), float(np.nan_to_num(abs(self.down))))


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """The changes of a number of some landings, with their effects.

    Attributes:
        landings: names of the landings.
        profiles: their results.
        target: the number.
        values: (L,) of it in each landing; of several landings the magnitudes [its unit].
        mean: whether the mean over the landings is the target, and not the worst of them.
        percent: how far: per cent of masses, inertias and ranges, degrees and millimetres.
        effects: of every change: links first, then joints, then the strike.
        ends: the same with all drives at the smallest inertias that what is known allows, and at
            the largest, or why there is none; empty where all drives are known exactly.
    """

    landings: tuple[str, ...]
    profiles: tuple[ShockProfile, ...] = field(repr=False)
    target: Column
    values: Array
    mean: bool
    percent: float
    effects: tuple[Effect, ...]
    ends: Mapping[End, "Sensitivity | ShockError"] = field(default_factory=dict, repr=False)

    _repr_html_ = shown_by("studies.sensitivity.report:sensitivity_report")

    def __repr__(self) -> str:
        first = [effect.parameter for effect in self.effects[:3]]
        return brief(self, self.target.name, f"largest effects: {', '.join(first)}")

    @property
    def value(self) -> float:
        """The target: the number, the worst of several, or their mean [its unit]."""
        if self.mean:
            return float(self.values.mean())
        return float(self.values[_worst(self.target, self.values)])

    @property
    def worst(self) -> str:
        """The landing in which the number is the worst."""
        return self.landings[_worst(self.target, self.values)]

    @property
    def ranked(self) -> tuple[Effect, ...]:
        """The effects that exist, the step with the largest change of the target first."""
        known = [effect for effect in self.effects if not effect.reason]
        return tuple(sorted(known, key=lambda effect: effect.largest, reverse=True))

    @property
    def refused(self) -> tuple[Effect, ...]:
        """The effects that do not exist."""
        return tuple(effect for effect in self.effects if effect.reason)

    @property
    def percents(self) -> dict[str, float]:
        """The changes of `ranked` as shares of the target [%], by parameter; none if it is zero."""
        if not self.value:
            return {}
        return {effect.parameter: 100.0 * effect.up / self.value for effect in self.ranked}

    @property
    def table(self) -> Table:
        """A row for each effect as `ranked`, then those without a derivative.

        The messages of these say why. The last columns have the changes by the drives.
        """
        name, unit = self.target.selection.name, self.target.unit
        header = (
            "parameter",
            "value",
            "unit",
            "step",
            "change",
            f"{name} [{unit}]",
            f"change of {name} [%]",
            f"opposite {name} [{unit}]",
            f"error {name} [{unit}]",
            *(f"{end} [%]" for end in self.ends),
        )
        by_drives = [self.percents]
        for end in self.ends.values():
            by_drives.append({} if isinstance(end, ShockError) else end.percents)
        rows = []
        for effect in (*self.ranked, *self.refused):
            change, *at_ends = [percents.get(effect.parameter) for percents in by_drives]
            head = (effect.parameter, effect.value, effect.unit, effect.step, effect.step_text)
            numbers = (effect.up, change, effect.down, effect.step * effect.error)
            rows.append((*head, *numbers, *at_ends))
        first = len(self.ranked)
        reasons = {first + i: effect.reason for i, effect in enumerate(self.refused)}
        return Table.of_rows(header, rows, reasons)

    def error(self, effects: Iterable[Effect]) -> float:
        """The largest error of some effects' derivatives, each as a share of its largest [1]."""
        shares = [0.0]
        for effect in effects:
            largest = float(np.abs(effect.derivatives).max())
            if largest > 0.0:
                shares.append(effect.error / largest)
        return max(shares)

    def worse(self, change: float) -> bool | None:
        """True if a change of the target makes it worse; None if neither direction is worse."""
        worse = self.target.selection.quantity.worse
        if worse == "neither":
            return None
        size = change
        if self.target.selection.signed:
            size *= math.copysign(1.0, self.value)
        return (size > 0.0) == (worse == "greater")


@study(
    "shockpc sensitivity anymal_b --contact LF_FOOT --at imu_link",
    "shockpc sensitivity go2 --at imu --group '*_thigh' --group '*_calf'",
    "shockpc sensitivity anymal_b --quantity joint_impulse@LF_KFE --vary 'mass:*_SHANK=0.8x:1.2x' "
    "--vary LF_KFE=-80:-40",
    more=(
        "Without --contact the robot lands on all level feet together, on each edge of their "
        "support, and on each foot. The number is the value in the worst landing, or the mean "
        "over all landings with --mean. Every mass, inertia and armature is changed by 1 %, every "
        "angle by 1 deg, every length by 1 mm. With --vary only the named parameters are changed, "
        "by 1 % of their ranges."
    ),
    reads="landings",
    passed=("target", "trace"),
)
def sensitivity(
    landings: Scene | str | Mapping[str, Scene | str],
    target: str | Point,
    robot: Robot | None = None,
    *,
    mean: Annotated[
        bool, Option("The mean over the landings, not the worst of them.", "Question")
    ] = False,
    groups: Annotated[
        Sequence[str],
        Option(
            "Bodies and joints that change together by the same factor, such as left and right "
            "legs.",
            "Changes",
            "NAME",
            "group",
        ),
    ] = (),
    vary: Annotated[
        Vary,
        Option(
            "Change only these, each by a share of its range (a:b, factors ax:bx, m±s): joints "
            "[deg; m if prismatic], "
            "mass:LINK, armature:JOINT, strike-angle, friction, and other names that sweep varies.",
            "Changes",
            "NAME=RANGE",
        ),
    ] = (),
    percent: Annotated[
        float,
        Option(
            "Size of the changes: this many per cent, degrees and millimetres.",
            "Changes",
            "P",
            least=1e-3,
            greatest=100.0,
        ),
    ] = 1.0,
    trace: Trace | None = None,
) -> Sensitivity:
    """The derivatives of a number of some landings, each a difference with an error.

    The parameters have the names and units by which `sweep` varies them: of a link `mass:LINK`
    (with its inertia in proportion), `point-mass:LINK`, `com-x:LINK` and `inertia-xx:LINK` (what is
    added), `armature:JOINT`, the joints, and `strike-angle`. Contact points stay where they are on
    their links; one that is the lowest point of a link moves as the link turns. Joints that follow
    others follow, and loops stay closed.

    Args:
        landings: one landing, or landings of one robot by name.
        target: KEY@PLACE, or KEY of the robot as a whole; a point means the shock there, with
            friction if a scene has it.
        robot: the scenes' robot, if it is loaded already.
        trace: collects what each stage cost.

    Raises:
        UnknownName: there is no such quantity, place, body or joint.
        StudyError: the number does not exist in a landing, or is zero, where a length has no
            derivative.
        ShockError: a landing cannot be computed.
    """
    scenes = named_scenes(landings)
    robot = robot or common_robot(scenes)
    scenes = with_default_landings(scenes, robot)
    varied = [variation(robot, subject, values) for subject, values in pairs(vary)]
    if varied and groups:
        raise StudyError(
            "groups and vary cannot be combined, because a glob in vary is already a group; leave "
            "one of the two out"
        )
    refuse_repeated(robot, varied)
    cases = {name: (prepared(scene, varied), robot) for name, scene in scenes.items()}
    as_modelled = _as_modelled(
        cases, robot, target, mean, varied, groups, percent, trace or Trace()
    )
    # The same study, with the drives of its scenes at an end of what they may be.
    at_end = partial(
        sensitivity,
        target=target,
        robot=robot,
        mean=mean,
        groups=groups,
        vary=vary,
        percent=percent,
    )
    return replace(as_modelled, ends=at_drive_ends(as_modelled, cases, at_end))


def _as_modelled(
    cases: Mapping[str, tuple[Scene, Robot]],
    robot: Robot,
    wanted: str | Point,
    mean: bool,
    varied: Sequence[Variation],
    groups: Sequence[str],
    percent: float,
    trace: Trace,
) -> Sensitivity:
    """The study with the drives as modelled. Args: as of the study; varied, all or none."""
    solved = tuple(profiles(cases, trace).values())
    text = target_text(wanted, [scene for scene, _ in cases.values()])
    target = _target(solved, text, mean)
    # The links and joints of each pattern.
    of_patterns = [_single(robot, pattern) for pattern in varied]
    derivatives = _derivatives(solved, target, list(chain.from_iterable(of_patterns)), trace)
    # A change moves one parameter, or those of a pattern or group together.
    known = derivatives.parameters
    if varied:
        changes = []
        for pattern, parts in zip(varied, of_patterns, strict=True):
            changes.append(_of_range(pattern, parts, known, percent / 100.0))
    else:
        changes = _changes(robot, known, groups, percent)
    effects = tuple(_effect(change, derivatives, target) for change in changes)
    # Without any derivative there is nothing to rank.
    if not varied and not any(effect.reason or effect.derivatives.any() for effect in effects):
        raise StudyError(
            f"{target.number.title} does not change to first order with any parameter here; "
            f"choose another quantity"
        )
    return Sensitivity(tuple(cases), solved, target.number, target.values, mean, percent, effects)


def _worst(target: Column, values: Array) -> int:
    """The index of the landing with the worst value.

    Of a quantity that is worse in neither direction it is the one with the maximum.
    """
    return int(target.selection.worse(values).argmax())


def _single(robot: Robot, varied: Variation) -> tuple[Variation, ...]:
    """The quantities varied by a name or a pattern, a link or joint at a time.

    Raises:
        StudyError: it has no derivative, or no range.
    """
    if varied.kind.names_contacts:
        raise StudyError(
            "contacts have names and no derivative; compute each landing with shockpc sweep"
        )
    _ = varied.ends
    return each_of(robot, varied)


def _of_range(
    varied: Variation, parts: Sequence[Variation], known: Mapping[str, Parameter], share: float
) -> ParameterChange:
    """A change by a share of a quantity's range, of all links or joints of a pattern together."""
    low, high = varied.ends
    step = share * (high - low)
    present = {part.subject: known[part.subject].value for part in parts}
    # Of a pattern those that have a value; none where no joint has.
    finite = {name: value for name, value in present.items() if math.isfinite(value)}
    present = finite or present
    values = set(present.values())
    return ParameterChange(
        parameter=varied.subject,
        value=values.pop() if len(values) == 1 else math.nan,
        unit=varied.unit,
        step=step,
        share=step if varied.factor else math.nan,
        parts=dict.fromkeys(present, 1.0),
    )


def _changes(
    robot: Robot, known: Mapping[str, Parameter], groups: Sequence[str], percent: float
) -> list[ParameterChange]:
    """Every parameter by its step; those of a group together, each away from zero."""
    pattern_of: dict[str, str] = {}
    names = dict.fromkeys([*robot.links, *robot.joint_names])
    for pattern in groups:
        for name in robot.match("link or joint", pattern, names):
            pattern_of.setdefault(name, pattern)
    changes: dict[str, ParameterChange] = {}
    for name, parameter in known.items():
        varied = parameter.varied
        step, unit, share = percent * parameter.step, varied.unit, math.nan
        if parameter.relative:
            share = 0.01 * percent
        pattern = pattern_of.get(varied.target, "")
        if not pattern:
            parts = {name: 1.0}
            changes[name] = ParameterChange(name, parameter.value, unit, step, share, parts)
            continue
        together = varied.kind.subject(pattern)
        weight = parameter.away
        if parameter.relative:
            # Of a share of its amount.
            weight *= 100.0 * parameter.step
            step, unit = share, "-"
        parts = {}
        if together in changes:
            parts = dict(changes[together].parts)
        parts[name] = weight
        changes[together] = ParameterChange(together, math.nan, unit, step, share, parts)
    return list(changes.values())


class _Target(NamedTuple):
    """The number in L landings, and what of it is the target.

    Attributes:
        numbers: the number in each of them.
        values: (L,) of it; of several landings the magnitudes [its unit].
        signs: (L,) by which numbers are multiplied for that.
        mean: whether the mean is the target, and not the worst.
    """

    numbers: Sequence[Column]
    values: Array
    signs: Array
    mean: bool

    @property
    def number(self) -> Column:
        """The number in the first landing."""
        return self.numbers[0]

    def change(self, step: float, derivatives: Array) -> float:
        """The change of the target by a step, to first order [its unit].

        Args:
            step: of a parameter.
            derivatives: (L,) of the values.
        """
        if self.mean:
            return float(step * derivatives.mean())
        now = self.values[_worst(self.number, self.values)]
        k = _worst(self.number, self.values + step * derivatives)
        return float(self.values[k] - now + step * derivatives[k])


def _target(solved: Sequence[ShockProfile], text: str, mean: bool) -> _Target:
    """The target: the number that a text means, in each landing.

    Raises:
        StudyError: there is none in a landing, or it is zero.
    """
    numbers = [column(profile, text) for profile in solved]
    values = np.array(list(map(_value, solved, numbers)))
    # Several numbers that may have either sign are compared by magnitude.
    signs = np.ones(len(values))
    if len(values) > 1 and numbers[0].selection.signed:
        signs = np.sign(values)
    return _Target(numbers, signs * values, signs, mean)


class _Derivatives(NamedTuple):
    """The derivatives of the number in each landing.

    Attributes:
        parameters: by name; of several landings the first one has a parameter's value.
        slopes: of each landing, the derivatives by its parameters.
    """

    parameters: Mapping[str, Parameter]
    slopes: Sequence[Mapping[str, Slope]]


def _derivatives(
    solved: Sequence[ShockProfile], target: _Target, varied: Sequence[Variation], trace: Trace
) -> _Derivatives:
    """The derivatives of the target's number by what varies, or else by every parameter."""
    of_landings = [parameters(profile.landing, varied) for profile in solved]
    known: dict[str, Parameter] = {}
    for of_landing in reversed(of_landings):
        known |= of_landing
    slopes = []
    for profile, of_landing, number in zip(solved, of_landings, target.numbers, strict=True):
        with trace.stage("derivatives"):
            slopes.append(slopes_beside(profile, of_landing, number))
    return _Derivatives(known, slopes)


def _effect(change: ParameterChange, derivatives: _Derivatives, target: _Target) -> Effect:
    """The effect of a change on the number in each landing, and on the target."""
    slopes = [_slope(change, of_landing) for of_landing in derivatives.slopes]
    of_number = target.signs * [slope.value for slope in slopes]
    reason = next((slope.reason for slope in slopes if slope.reason), "")
    if reason:
        of_number = np.full(len(slopes), np.nan)
    down = math.nan
    if _is_possible(change, derivatives.parameters):
        down = target.change(-change.step, of_number)
    return Effect(
        **vars(change),
        derivatives=read_only(of_number),
        error=max(slope.error for slope in slopes),
        reason=reason,
        up=target.change(change.step, of_number),
        down=down,
    )


def _slope(change: ParameterChange, slopes: Mapping[str, Slope]) -> Slope:
    """The derivative by a change in one landing: Σ weight · slope of its parts."""
    value, error, reason = 0.0, 0.0, ""
    for name, weight in change.parts.items():
        if name in slopes:
            value += weight * slopes[name].value
            error += abs(weight) * slopes[name].error
            reason = reason or slopes[name].reason
    return Slope(value, error, reason)


def _is_possible(change: ParameterChange, known: Mapping[str, Parameter]) -> bool:
    """True if the opposite change leaves no parameter below its lowest value."""
    for name, weight in change.parts.items():
        parameter = known[name]
        if not parameter.value - abs(change.step * weight) >= parameter.lowest:
            return False
    return True


def _value(profile: ShockProfile, number: Column) -> float:
    """The number.

    Raises:
        StudyError: there is none, or it is zero.
    """
    entry = number.selection.quantity
    value = number_of(profile, number)
    if not math.isfinite(value):
        raise StudyError(
            f"there is no {number.title} in this landing: {entry.scope.missing or 'it is infinite'}"
        )
    size = profile.proof.read(lambda impact: _natural_size(impact, number))
    if abs(value) <= ZERO * max(size, abs(value)):
        raise StudyError(
            f"{number.title} is zero in this landing: a length has no derivative where it is zero, "
            f"and changes cannot be relative "
            "to it; name another place, or change the strike"
        )
    return value


def _natural_size(impact: Impact, number: Column) -> float:
    """The largest size of the terms of a number [its unit]."""
    entry = number.selection.quantity
    values = entry.compute(impact, [number.place]).astype(float)
    return float(np.max(entry.size(impact, values)))
