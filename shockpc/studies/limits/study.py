"""Values of a joint, or of what else varies, that keep a number below a bound.

The number is the shock at a point, a torque, a friction or another one. It is bounded on the rows
of a sweep over values and strike angles.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Annotated, Any

import numpy as np

from shockpc.evaluation.column import Column, column, target_text
from shockpc.evaluation.declare import study
from shockpc.evaluation.drive_ends import MOVED, End, at_drive_ends
from shockpc.evaluation.profiles import profiles
from shockpc.evaluation.table import Table
from shockpc.evaluation.variations.vary import kind_of
from shockpc.landing.scenes.scene import Point, Scene
from shockpc.landing.scenes.scene_fields import Option
from shockpc.landing.scenes.scene_file import robot_of, scene_of
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.robot.robot import Robot
from shockpc.studies.limits.intervals import StrikeLimits, strike_limits
from shockpc.studies.limits.question import (
    Bound,
    Strikes,
    Varied,
    bound_from,
    default_step,
    refuse_senseless,
    scan_values,
    strike_range,
    strike_targets,
    varied_by,
)
from shockpc.studies.limits.scan import Scan, scanned
from shockpc.text.display import brief, shown_by
from shockpc.text.errors import ShockError, SolveError
from shockpc.text.printed import UNITS, in_degrees

VALUE = "deg; m if prismatic"
"""Unit of a joint's values as they are typed."""


@dataclass(frozen=True, eq=False)
class JointLimits:
    """The limits of a joint, or of what else varies, that a bound on a number sets.

    Attributes:
        profile: the landing in the scene's posture.
        target: the number.
        joints: the joints that are moved, all to the same value; or the subject of another
            variation.
        of_joints: whether joints vary, and nothing else.
        unit: of that value, "rad" or "m", or that of the variation.
        bound: of the number, in its unit.
        range: smallest and largest value looked at [rad, m].
        file_limits: those of the robot's file; infinite where it gives none [rad, m].
        present: the value, NaN where there is none, and the strike angle of the scene [rad, m;
            rad].
        strikes: smallest and largest strike angle looked at [rad].
        step: largest distance between the values of the scan [rad, m].
        scan: the postures and their numbers.
        limits: at the scene's strike angle, at others one by one, and last at all strike angles of
            the range.
        ends: the limits with all drives at the smallest inertias that what is known allows, and at
            the largest, or why there are none; empty where all are known exactly, or vary.
    """

    profile: ShockProfile = field(repr=False)
    target: Column
    joints: tuple[str, ...]
    of_joints: bool
    unit: str
    bound: Bound
    range: tuple[float, float]
    file_limits: tuple[float, float]
    present: tuple[float, float]
    strikes: Strikes
    step: float
    scan: Scan = field(repr=False)
    limits: tuple[StrikeLimits, ...]
    ends: Mapping[End, "JointLimits | ShockError"] = field(default_factory=dict, repr=False)

    _repr_html_ = shown_by("studies.limits.report:limits_report")

    def __repr__(self) -> str:
        bound = f"{self.target.name} {'≥' if self.bound.below else '≤'} {self.bound.value:g}"
        return brief(self, bound, f"varied: {', '.join(self.joints)}")

    def moves(self, limits: "JointLimits") -> bool:
        """True if limits differ from these by more than 1 degree, 1 cm, or 1 % of the range."""
        low, high = self.range
        most = {"rad": math.radians(1.0), "m": 0.01}.get(self.unit, MOVED * (high - low))
        for mine, theirs in zip(self.limits, limits.limits, strict=True):
            ends, moved_ends = np.array(mine.usable), np.array(theirs.usable)
            if ends.shape != moved_ends.shape:
                return True
            if np.any(np.abs(ends - moved_ends) > most):
                return True
        return False

    @property
    def subject(self) -> str:
        """The joints, or what else varies."""
        return "+".join(self.joints)

    @property
    def shown_unit(self) -> str:
        """Unit of values in tables."""
        return UNITS.get(self.unit, (1.0, self.unit))[1]

    def shown(self, value: float) -> float:
        """A value in the unit of tables."""
        factor, _ = UNITS.get(self.unit, (1.0, self.unit))
        return round(factor * value, 9) + 0.0

    @property
    def table(self) -> Table:
        """A row for each interval of values that keep the bound, at each strike angle and over all.

        Where there is none, a row without ends.
        """
        unit = self.shown_unit
        strikes = "strike from [deg]", "strike to [deg]"
        ends = f"low [{unit}]", f"high [{unit}]", "low end", "high end", "feasible"
        rows: list[tuple[float | str | None, ...]] = []
        for of_strikes in self.limits:
            angles = tuple(map(in_degrees, of_strikes.strikes))
            for low, high, low_end, high_end, feasible in of_strikes.intervals:
                values = self.shown(low), self.shown(high)
                rows.append((*angles, *values, low_end, high_end, feasible))
            if not of_strikes.intervals:
                rows.append((*angles, *(None,) * len(ends)))
        table = Table.of_rows((*strikes, *ends), rows)
        # True or False, also where there is no interval: it is not the quantity of that name.
        return replace(table, label_units={"feasible": ""})


def _typed(robot: Robot, arguments: dict[str, Any]) -> dict[str, Any]:
    """The values of a joint that turns in radians, which are typed in degrees."""
    subject = arguments["joint"]
    kind, target = kind_of(robot, subject)
    if kind.unit_of(robot, subject, target) != "deg":
        return arguments
    in_radians = dict(arguments)
    for name in ("joint_range", "step"):
        if name in arguments:
            in_radians[name] = np.radians(arguments[name]).tolist()
    return in_radians


@study(
    "shockpc limits hyq --contact lf_foot --joint lf_kfe_joint --at trunk_imu --max 0.1",
    "shockpc limits hyq --contact lf_foot --joint lf_kfe_joint --quantity friction_needed@lf_foot "
    "--max 0.6",
    typed=_typed,
    reads="scene",
    passed=("target",),
)
def limits(
    scene: Scene | str,
    joint: Annotated[
        str,
        Option(
            "The joint, or a glob of joints with the same value. With --range also another name "
            "that sweep varies.",
            "Question",
            "JOINT",
        ),
    ],
    target: str | Point,
    max: Annotated[
        float | None,
        Option(
            "The largest value allowed, of the number or of its magnitude, in its unit.",
            "Question",
            "VALUE",
            above=0.0,
        ),
    ] = None,
    *,
    min: Annotated[
        float | None,
        Option(
            "The smallest value allowed, of a number that is worse when smaller: a margin.",
            "Question",
            "VALUE",
            above=0.0,
        ),
    ] = None,
    joint_range: Annotated[
        tuple[float, float] | None,
        Option(
            "Values to look at.",
            "Question",
            "LOW:HIGH",
            "range",
            VALUE,
            default="the joint's limits, at most a turn",
        ),
    ] = None,
    strikes: Annotated[
        tuple[float, float] | None,
        Option(
            "Range of strike angles.",
            "Question",
            "LOW:HIGH",
            unit="deg",
            default="-30:75; the scene's for quantities of one posture at a time",
        ),
    ] = None,
    step: Annotated[
        float | None,
        Option(
            "Largest step of the scan.",
            "Question",
            "STEP",
            unit=VALUE,
            default=(
                "0.1 deg or 0.0001 m, 20 times that for quantities of one posture at a time; a "
                "200th of the range for other subjects"
            ),
        ),
    ] = None,
    robot: Robot | None = None,
) -> JointLimits:
    """Find the values of a joint that keep a number at or below a bound, or at or above one.

    The strike angle turns the part of the velocity that is in the plane; after a fall from a drop
    height its vertical component stays. The part out of the plane, and what else moves before the
    impact, stays as it is.

    Args:
        scene: the landing; the joint's value is not used, except that loops are followed from it.
        target: KEY@PLACE, or KEY of the robot as a whole; a point means the shock there, with
            friction if the scene has it.
        robot: the scene's robot, if it is loaded already.

    Raises:
        UnknownName: there is no such joint, quantity or place.
        StudyError: the question makes no sense.
        SolveError: no posture of the range has a result.
        ShockError: the landing cannot be computed.
    """
    bound = bound_from(max, min)
    scene = scene_of(scene)
    robot = robot or robot_of(scene)
    varied = varied_by(robot, joint, joint_range)
    scene = varied.variation.kind.prepared(scene)
    (profile,) = profiles({"": (scene, robot)}).values()
    number = column(profile, target_text(target, [scene]))
    refuse_senseless(profile.landing, number, bound, varied)

    # Some numbers are computed one landing at a time, which takes much longer.
    per_landing = number.selection.quantity.per_landing(profile.landing.scene)
    strikes = strike_range(profile.landing, strikes, per_landing)
    if step is None:
        step = default_step(varied, per_landing)
    modelled = _as_modelled(profile, number, bound, varied, strikes, step)
    if varied.variation.kind.of_drives:
        return modelled

    # The same question with the drives at both ends of what is known.
    again = partial(
        limits,
        joint=joint,
        target=target,
        max=max,
        min=min,
        joint_range=varied.span,
        strikes=strikes,
        step=step,
        robot=robot,
    )

    def at_end(scenes: dict[str, Scene]) -> JointLimits:
        return again(scenes[""])

    return replace(modelled, ends=at_drive_ends(modelled, {"": (scene, robot)}, at_end))


def _as_modelled(
    profile: ShockProfile,
    number: Column,
    bound: Bound,
    varied: Varied,
    strikes: Strikes,
    step: float,
) -> JointLimits:
    """The limits with the drives as modelled; the arguments are attributes of the result."""
    landing = profile.landing
    values = scan_values(varied, step)
    present = varied.variation.present(landing) / varied.variation.per_unit
    targets = strike_targets(landing.strike_angle, strikes)
    scan = scanned(landing, varied.variation, number, bound, values, targets)
    if scan.unreachable and np.isnan(scan.at_scene_strike).all():
        reason = scan.unreachable[0][2]
        raise SolveError(f"no value of {varied.variation.subject} has a result: {reason}")
    return JointLimits(
        profile=profile,
        target=number,
        joints=varied.names,
        of_joints=bool(varied.joints),
        unit=varied.unit,
        bound=bound,
        range=varied.span,
        file_limits=varied.file_limits,
        present=(present, landing.strike_angle),
        strikes=strikes,
        step=step,
        scan=scan,
        limits=strike_limits(scan, varied.span, targets),
    )
