"""What would change a number of some landings most: its derivatives by every mass, inertia, joint
value and the strike.

Each parameter is what a sweep varies, and is set on both sides of its value, all others left as
they are. Two central differences give the derivative, and how far they are apart its error: where
they differ there is none. Over several landings the number is the worst of them or their mean, and
its change is that of the values to first order.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated

import numpy as np

from shockpc.core.spatial import Array, read_only
from shockpc.evaluation.column import Column, column, target_text
from shockpc.evaluation.declare import study
from shockpc.evaluation.drive_ends import End, at_drive_ends
from shockpc.evaluation.kinds.contacts import ContactNames
from shockpc.evaluation.kinds.posture import JOINT_POSITION
from shockpc.evaluation.named_scenes import common_robot, named_scenes, with_default_landings
from shockpc.evaluation.profiles import profiles
from shockpc.evaluation.table import Table
from shockpc.evaluation.variation import Variation
from shockpc.evaluation.vary import Vary, each_of, pairs, prepared, refuse_repeated, variation
from shockpc.landing.record import Option
from shockpc.landing.scene import Point, Scene
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.robot.robot import Robot
from shockpc.studies.sensitivity.slopes import (
    Parameter,
    Slope,
    number_of,
    parameters,
    slopes_beside,
)
from shockpc.text.errors import ShockError, StudyError
from shockpc.text.shown import brief, shown_by
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


@dataclass(frozen=True, eq=False)
class Effect(ParameterChange):
    """What a change does; derivatives that do not exist are NaN.

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


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """What changes a number of some landings.

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
        return float(
            self.values.mean() if self.mean else self.values[_worst(self.target, self.values)]
        )

    @property
    def worst(self) -> str:
        """The landing in which the number is the worst."""
        return self.landings[_worst(self.target, self.values)]

    @property
    def ranked(self) -> tuple[Effect, ...]:
        """The effects that exist, the step with the largest change of the target first."""
        known = (effect for effect in self.effects if not effect.reason)
        return tuple(
            sorted(known, key=lambda effect: -max(abs(effect.up), np.nan_to_num(abs(effect.down))))
        )

    @property
    def table(self) -> Table:
        """A row for each effect as `ranked`, then those without a derivative, whose messages say
        why.
        """
        name, unit = self.target.selection.name, self.target.unit
        numbers = (
            f"{name} [{unit}]",
            f"change of {name} [%]",
            f"opposite {name} [{unit}]",
            f"error {name} [{unit}]",
        )
        effects = (*self.ranked, *(effect for effect in self.effects if effect.reason))
        rows = [
            (
                x.parameter,
                x.value,
                x.unit,
                x.step,
                x.up,
                100.0 * x.up / self.value,
                x.down,
                x.step * x.error,
            )
            for x in effects
        ]
        reasons = {i: effect.reason for i, effect in enumerate(effects) if effect.reason}
        return Table.of_rows(("parameter", "value", "unit", "step", *numbers), rows, reasons)

    def error(self, effects: Iterable[Effect]) -> float:
        """The largest error of the derivatives of some effects, each as a share of its largest [1]."""
        shares = [
            effect.error / largest
            for effect in effects
            if (largest := float(np.abs(effect.derivatives).max())) > 0.0
        ]
        return max(shares, default=0.0)

    def worse(self, change: float) -> bool | None:
        """Whether a change of the target makes it worse; None if neither direction is worse."""
        entry = self.target.selection.quantity
        sign = math.copysign(1.0, self.value) if self.target.selection.signed else 1.0
        return (
            None
            if entry.worse == "neither"
            else (change * sign > 0.0) == (entry.worse == "greater")
        )


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
    trace = trace or Trace()
    scenes = named_scenes(landings)
    robot = robot or common_robot(scenes)
    scenes = with_default_landings(scenes, robot)
    chosen = [variation(robot, subject, values) for subject, values in pairs(vary)]
    if chosen and groups:
        raise StudyError(
            "groups and vary cannot be combined, because a glob in vary is already a group; leave "
            "one of the two out"
        )
    refuse_repeated(robot, chosen)
    scenes = {name: prepared(scene, chosen) for name, scene in scenes.items()}
    solved = tuple(
        profiles({name: (scene, robot) for name, scene in scenes.items()}, trace).values()
    )
    text = target_text(target, scenes.values())
    numbers = [column(profile, text) for profile in solved]
    number = numbers[0]
    values = np.array([_value(*pair) for pair in zip(solved, numbers, strict=True)])
    single = [(varied, _single(robot, varied)) for varied in chosen]
    by_landing = [
        parameters(profile.landing, [part for _, parts in single for part in parts])
        for profile in solved
    ]
    known = {
        name: parameter
        for of_landing in reversed(by_landing)
        for name, parameter in of_landing.items()
    }
    changes = [_of_range(*pair, known, percent / 100.0) for pair in single] or _changes(
        robot, known, groups, percent
    )
    slopes = []
    for profile, of_landing, its_number in zip(solved, by_landing, numbers, strict=True):
        with trace.stage("derivatives"):
            slopes.append(slopes_beside(profile, of_landing, its_number))
    signs = np.sign(values) if len(values) > 1 and number.selection.signed else np.ones(len(values))
    effects = tuple(
        _effect(change, known, slopes, number, mean, signs, signs * values) for change in changes
    )
    if not chosen and not any(effect.reason or effect.derivatives.any() for effect in effects):
        raise StudyError(
            f"{number.title} does not change to first order with any parameter here; choose "
            f"another quantity"
        )
    modelled = Sensitivity(tuple(scenes), solved, number, signs * values, mean, percent, effects)

    def at_end(others: dict[str, Scene]) -> Sensitivity:
        return sensitivity(
            others, target, robot, mean=mean, groups=groups, vary=vary, percent=percent
        )

    cases = {name: (scene, robot) for name, scene in scenes.items()}
    return replace(modelled, ends=at_drive_ends(modelled, cases, at_end))


def _worst(target: Column, values: Array) -> int:
    """The landing with the worst value; of a quantity that is not worse in either direction that
    with the maximum.
    """
    return int(target.selection.worse(values).argmax())


def _single(robot: Robot, varied: Variation) -> tuple[Variation, ...]:
    """What is varied by a name or a pattern, a link or joint at a time.

    Raises:
        StudyError: it has no derivative, or no range.
    """
    if isinstance(varied.kind, ContactNames):
        raise StudyError(
            "contacts have names and no derivative; compute each landing with shockpc sweep"
        )
    _ = varied.ends
    return each_of(robot, varied)


def _of_range(
    varied: Variation, parts: Sequence[Variation], known: Mapping[str, Parameter], share: float
) -> ParameterChange:
    """A change of what is varied by a share of its range, of all links or joints of a pattern
    together.
    """
    low, high = varied.ends
    present = {part.subject: known[part.subject].value for part in parts}
    # Of a pattern those that have a value; none where no joint has.
    present = {name: value for name, value in present.items() if math.isfinite(value)} or present
    step, values = share * (high - low), set(present.values())
    value = values.pop() if len(values) == 1 else math.nan
    changed = dict.fromkeys(present, 1.0)
    return ParameterChange(
        varied.subject, value, varied.unit, step, step if varied.factor else math.nan, changed
    )


def _changes(
    robot: Robot, known: Mapping[str, Parameter], groups: Sequence[str], percent: float
) -> list[ParameterChange]:
    """Every parameter by its step; those of a group together, each away from zero."""
    pattern_of: dict[str, str] = {}
    for pattern in groups:
        for name in robot.match(
            "link or joint", pattern, dict.fromkeys([*robot.links, *robot.joint_names])
        ):
            pattern_of.setdefault(name, pattern)
    changes: dict[str, ParameterChange] = {}
    for name, one in known.items():
        varied, share, pattern = (
            one.varied,
            0.01 * percent if one.relative else math.nan,
            pattern_of.get(one.varied.target, ""),
        )
        if not pattern:
            changes[name] = ParameterChange(
                name, one.value, varied.unit, percent * one.step, share, {name: 1.0}
            )
            continue
        together = pattern if varied.kind == JOINT_POSITION else f"{varied.kind.word}:{pattern}"
        parts = dict(changes[together].parts) if together in changes else {}
        parts[name] = one.away * (100.0 * one.step if one.relative else 1.0)
        unit, step = ("-", share) if one.relative else (varied.unit, percent * one.step)
        changes[together] = ParameterChange(together, math.nan, unit, step, share, parts)
    return list(changes.values())


def _effect(
    change: ParameterChange,
    known: Mapping[str, Parameter],
    slopes: Sequence[Mapping[str, Slope]],
    target: Column,
    mean: bool,
    signs: Array,
    values: Array,
) -> Effect:
    """What a change does to the number in each landing, of which magnitudes count where the signs
    are not 1, and to the target.
    """
    parts = [
        [(weight, slopes[key]) for key, weight in change.parts.items() if key in slopes]
        for slopes in slopes
    ]
    reason = next(
        (slope.reason for of_landing in parts for _, slope in of_landing if slope.reason), ""
    )
    derivatives = signs * [
        sum(weight * slope.value for weight, slope in of_landing) for of_landing in parts
    ]
    derivatives = np.full_like(derivatives, np.nan) if reason else derivatives
    error = max(
        sum(abs(weight) * slope.error for weight, slope in of_landing) for of_landing in parts
    )
    now = values[_worst(target, values)]

    def effect(step: float) -> float:
        k = _worst(target, values + step * derivatives)
        return float(step * derivatives.mean() if mean else values[k] - now + step * derivatives[k])

    possible = all(
        known[key].value - abs(change.step * weight) >= known[key].lowest
        for key, weight in change.parts.items()
    )
    down = effect(-change.step) if possible else math.nan
    return Effect(
        **vars(change),
        derivatives=read_only(derivatives),
        error=error,
        reason=reason,
        up=effect(change.step),
        down=down,
    )


def _value(profile: ShockProfile, number: Column) -> float:
    """The number.

    Raises:
        StudyError: there is none, or it is zero.
    """
    entry, value = number.selection.quantity, number_of(profile, number)
    if not math.isfinite(value):
        raise StudyError(
            f"there is no {number.title} in this landing: {entry.scope.missing or 'it is infinite'}"
        )
    where = [number.place]
    size = profile.proof.read(
        lambda impact: float(np.max(entry.size(impact, entry.compute(impact, where).astype(float))))
    )
    if abs(value) <= ZERO * max(size, abs(value)):
        raise StudyError(
            f"{number.title} is zero in this landing: a length has no derivative where it is zero, "
            f"and changes cannot be relative "
            "to it; name another place, or change the strike"
        )
    return value
