"""Values of a joint, or of what else varies, that keep a number below a bound: the shock at a
point, a torque, a friction.

It is a bound on the rows of a sweep over values and strike angles.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, Any

import numpy as np

from shockpc.core.spatial import Array
from shockpc.evaluation.column import Column, column, target_text
from shockpc.evaluation.declare import study
from shockpc.evaluation.drive_ends import MOVED, End, at_drive_ends
from shockpc.evaluation.kinds.joints import OfDrive
from shockpc.evaluation.kinds.posture import JOINT_POSITION, motion_range
from shockpc.evaluation.profiles import profiles
from shockpc.evaluation.table import Table
from shockpc.evaluation.variation import Variation
from shockpc.evaluation.vary import kind_of, variation
from shockpc.landing.landing import PosedLanding
from shockpc.landing.posture import settable_joints
from shockpc.landing.record import Option
from shockpc.landing.scene import Point, Scene
from shockpc.landing.scene_file import robot_of, scene_of
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.robot.elements import Joint
from shockpc.robot.robot import Robot
from shockpc.studies.limits.intervals import StrikeLimits, strike_limits
from shockpc.studies.limits.scan import Bound, Scan, Strikes, scanned
from shockpc.text.errors import ShockError, SolveError, StudyError
from shockpc.text.printed import UNITS, in_degrees
from shockpc.text.shown import brief, shown_by

STRIKES = (math.radians(-30.0), math.radians(75.0))
"""Strike angles that are looked at if none are given [rad]."""

STRIKE_ANGLE_STEP = math.radians(15.0)
"""Between the strike angles for which limits are given one by one [rad]."""

STEEPEST = 89.0
"""Largest strike angle; at 90° the contact moves along the ground [deg]."""

VALUE = "deg; m if prismatic"
"""Unit of a joint's values as they are typed."""

STEP = {"rad": math.radians(0.1), "m": 1e-4}
"""Largest step of the scan of a joint if none is given: 0.1°, 0.1 mm."""

STEPS = 200
"""Steps of the scan of another variation if none is given."""

COARSER = 20
"""Factor of the default step of a joint where each landing is computed by itself."""

LEAST_VALUES = 33
"""Smallest number of values of a scan."""

MOST_VALUES = 200_000
"""Largest number of values of a scan."""

NOT_LIMITED = {
    "strike-angle": "limits are found over strike angles; give their range with --strikes",
    "contact": (
        "contacts have names, which have no order; compute each landing, or compare them with "
        "shockpc sweep"
    ),
}
"""What a sweep varies without being limited, and why."""


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
        """Whether limits differ from these by more than 1 degree, 1 cm, or 1 % of the range."""
        low, high = self.range
        most = {"rad": math.radians(1.0), "m": 0.01}.get(self.unit, MOVED * (high - low))
        for mine, theirs in zip(self.limits, limits.limits, strict=True):
            ends, moved_ends = np.array(mine.usable), np.array(theirs.usable)
            if len(ends) != len(moved_ends) or np.any(np.abs(ends - moved_ends) > most):
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
        """At each strike angle, and over the range, a row for each interval of values that keep the
        bound; a row without ends if there is none.
        """
        unit = self.shown_unit
        strikes = "strike from [deg]", "strike to [deg]"
        ends = f"low [{unit}]", f"high [{unit}]", "low end", "high end", "feasible"
        rows: list[tuple[float | str | None, ...]] = []
        for each in self.limits:
            angles = tuple(map(in_degrees, each.strikes))
            for low, high, low_end, high_end, feasible in each.intervals:
                is_feasible = "yes" if feasible else "no"
                values = self.shown(low), self.shown(high)
                rows.append((*angles, *values, low_end, high_end, is_feasible))
            if not each.intervals:
                rows.append((*angles, *(None,) * len(ends)))
        return Table.of_rows((*strikes, *ends), rows)


def _typed(robot: Robot, given: dict[str, Any]) -> dict[str, Any]:
    """The values of a joint that turns in radians, which are typed in degrees."""
    if not _is_angle(robot, given["joint"]):
        return given
    in_radians = {
        name: np.radians(given[name]).tolist() for name in ("joint_range", "step") if name in given
    }
    return given | in_radians


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
    bound = _bound(max, min)
    scene = scene_of(scene)
    robot = robot or robot_of(scene)
    varied, joints, span = _varied(robot, joint, joint_range)
    scene = varied.kind.prepared(scene)
    (profile,) = profiles({"": (scene, robot)}).values()
    number = column(profile, target_text(target, [scene]))
    _refuse_senseless(profile.landing, number, bound, joints)
    alone = number.selection.quantity.per_landing(profile.landing.scene)
    strikes = _strike_range(profile.landing, strikes, alone)

    scale = 1.0
    if varied.unit == "deg":
        scale = math.degrees(1.0)
    unit = varied.unit.replace("deg", "rad")
    if step is None:
        step = _default_step(joints, span, alone)
    values = _values(span, step, scale)
    targets = _targets(profile.landing.strike_angle, strikes)
    scan = scanned(profile.landing, joint, number, bound, values, scale, targets)
    if scan.unreachable and np.isnan(scan.at_scene_strike).all():
        raise SolveError(f"no value of {joint} has a result: {scan.unreachable[0][2]}")
    modelled = JointLimits(
        profile=profile,
        target=number,
        joints=tuple(each.name for each in joints) or (joint,),
        of_joints=bool(joints),
        unit=unit,
        bound=bound,
        range=span,
        file_limits=_file_limits(joints),
        present=(varied.present(profile.landing) / scale, profile.landing.strike_angle),
        strikes=strikes,
        step=step,
        scan=scan,
        limits=strike_limits(scan, span, targets),
    )
    if isinstance(varied.kind, OfDrive):
        return modelled

    asked: dict[str, Any] = {"max": max, "min": min}
    asked |= {"joint_range": span, "strikes": strikes, "step": step, "robot": robot}

    def at_end(scenes: dict[str, Scene]) -> JointLimits:
        return limits(scenes[""], joint, target, **asked)

    return replace(modelled, ends=at_drive_ends(modelled, {"": (scene, robot)}, at_end))


def _bound(most: float | None, least: float | None) -> Bound:
    """The one bound that is given."""
    if most is not None and least is None:
        return Bound(most, below=False)
    if least is not None and most is None:
        return Bound(least, below=True)
    raise StudyError(
        "one bound is needed: max for the largest value that is allowed, or min for the smallest"
    )


def _refuse_senseless(
    landing: PosedLanding, number: Column, bound: Bound, joints: Sequence[Joint]
) -> None:
    """Refuse a bound on the better side, a loop whose joints move, and a velocity that no strike
    angle turns.
    """
    worse = number.selection.quantity.worse
    if worse == ("greater" if bound.below else "less"):
        side = "max" if bound.below else "min"
        raise StudyError(f"the {worse} value of {number.name} is the worse one; bound it by {side}")
    if joints and landing.loops and landing.before.joint_rates.any():
        raise StudyError(
            "how fast joints of a loop move depends on the posture; leave the joint velocities out"
        )
    if landing.plane.level:
        raise StudyError("no strike angle is defined in a horizontal plane; choose another plane")
    in_plane = landing.before.velocity @ np.stack([landing.plane.forward, [0.0, 0.0, 1.0]], axis=1)
    if not np.linalg.norm(in_plane) > 0.0:
        raise StudyError(
            "the robot's velocity lies across the plane, so a strike angle does not change it; "
            "give another plane or velocity"
        )


def _default_step(joints: Sequence[Joint], span: tuple[float, float], alone: bool) -> float:
    """Largest step of a scan if none is given [rad, m; unit of the variation].

    Args:
        joints: those that vary.
        span: smallest and largest value.
        alone: whether each landing is computed by itself, which takes much longer.
    """
    if not joints:
        return (span[1] - span[0]) / STEPS
    step = STEP[joints[0].unit]
    return COARSER * step if alone else step


def _values(span: tuple[float, float], step: float, scale: float) -> Array:
    """The values (n,) of a scan, ascending, at most a step apart.

    Args:
        span: smallest and largest value [rad, m; unit of the variation].
        step: largest step.
        scale: factor to the unit in which they are typed.
    """
    low, high = span
    if not step > 0.0 or (high - low) / step > MOST_VALUES:
        raise StudyError(
            f"a step of {scale * step:g} in a range of {scale * (high - low):g} is not possible; "
            f"give a step above zero that makes at most {MOST_VALUES} postures"
        )
    steps = math.ceil((high - low) / step - 1e-9)
    return np.linspace(low, high, max(LEAST_VALUES, steps + 1))


def _is_angle(robot: Robot, subject: str) -> bool:
    """Whether what varies is an angle, typed in degrees."""
    kind, pattern = kind_of(robot, subject)
    if kind == JOINT_POSITION:
        return robot.joint(robot.match_joints(pattern)[0]).unit == "rad"
    return kind.unit == "deg"


def _varied(
    robot: Robot, subject: str, given: tuple[float, float] | None
) -> tuple[Variation, tuple[Joint, ...], tuple[float, float]]:
    """What varies, its joints, and the range that is looked at [rad, m; unit of the variation]."""
    kind, pattern = kind_of(robot, subject)
    if kind.word in NOT_LIMITED:
        raise StudyError(f"{subject} has no limits here: {NOT_LIMITED[kind.word]}")
    joints: tuple[Joint, ...] = ()
    low, high = math.nan, math.nan
    missing = "not given"
    if kind == JOINT_POSITION:
        joints = settable_joints(robot, pattern, StudyError)
        low, high = motion_range(joints)
        missing = "without limits in the file"
    if given is not None:
        low, high = given
    scale = math.degrees(1.0) if _is_angle(robot, subject) else 1.0
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        if math.isfinite(low + high):
            missing = f"{scale * low:.5g}:{scale * high:.5g}"
        raise StudyError(
            f"the range of {subject} is {missing}; give its minimum and maximum with --range "
            f"LOW:HIGH"
        )
    return variation(robot, subject, (scale * low, scale * high)), joints, (low, high)


def _file_limits(joints: Sequence[Joint]) -> tuple[float, float]:
    """Smallest and largest value that all joints have within the limits of their file [rad, m]."""
    low = max((joint.limits[0] for joint in joints), default=-math.inf)
    high = min((joint.limits[1] for joint in joints), default=math.inf)
    return low, high


def _strike_range(landing: PosedLanding, given: Strikes | None, alone: bool) -> Strikes:
    """The range of strike angles [rad], all of which approach the ground.

    Args:
        landing: the landing of the scene.
        given: the range, if one is given.
        alone: whether each landing is computed by itself; the default is then that of the scene.
    """
    low, high = STRIKES if given is None else given
    if given is None and alone:
        low = high = landing.strike_angle
    most = math.radians(STEEPEST) * (1.0 + 1e-12)
    if not -most <= low <= high <= most:
        raise StudyError(
            f"{in_degrees(low):.4g}:{in_degrees(high):.4g} is not a range of strike angles; give "
            f"the lesser one first, both between -{STEEPEST:g} and {STEEPEST:g} deg"
        )
    return low, high


def _targets(angle: float, strikes: Strikes) -> tuple[Strikes, ...]:
    """The strikes for which limits are found: the scene's, others one by one, and last all of the
    range [rad].
    """
    low, high = strikes
    first, last = math.ceil(low / STRIKE_ANGLE_STEP), math.floor(high / STRIKE_ANGLE_STEP)
    inside = [STRIKE_ANGLE_STEP * k for k in range(first, last + 1)]
    # Angles that differ by the rounding of degrees are the same.
    single = {round(each, 9): each for each in (*inside, low, high, angle)}
    others = [(each, each) for each in sorted(single.values()) if each != angle]
    return tuple(dict.fromkeys([(angle, angle), *others, strikes]))
