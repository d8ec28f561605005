"""A question about limits: the bound, what varies over which values, and the strikes."""

import math
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.evaluation.column import Column
from shockpc.evaluation.variations.kinds.posture import motion_range
from shockpc.evaluation.variations.kinds.strike import STRIKE_ANGLE
from shockpc.evaluation.variations.variation import Variation
from shockpc.evaluation.variations.vary import kind_of, variation
from shockpc.landing.landing import PosedLanding
from shockpc.robot.bodies_and_joints import Joint
from shockpc.robot.robot import Robot
from shockpc.text.errors import StudyError
from shockpc.text.printed import in_degrees

STRIKES = (math.radians(-30.0), math.radians(75.0))
"""Strike angles that are looked at if none are given [rad]."""

STRIKE_ANGLE_STEP = math.radians(15.0)
"""Between the strike angles for which limits are given one by one [rad]."""

STEEPEST = 89.0
"""Largest strike angle; at 90° the contact moves along the ground [deg]."""

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


Strikes = tuple[float, float]
"""Smallest and largest strike angle, equal for a single one [rad]."""


class Bound(NamedTuple):
    """A bound on a number; on the magnitude of a number that may be negative.

    Attributes:
        value: the bound, above zero.
        below: whether it is the smallest value allowed, and not the largest.
    """

    value: float
    below: bool

    @property
    def sign(self) -> float:
        """1 where greater numbers are worse, −1 where smaller ones are."""
        return -1.0 if self.below else 1.0

    def violation(self, numbers: Array) -> Array:
        """Distance of numbers N beyond the bound B, ±(N² − B²) / (N² + B²), from −1 to 1.

        It is smooth where N is zero and where N has a pole; 1 where N is NaN.
        """
        # (N² − B²) / (N² + B²) = 1 − 2 / (1 + (N/B)²), where (N/B)² may overflow.
        with np.errstate(over="ignore"):
            squared = (numbers / self.value) ** 2
        return np.nan_to_num(self.sign * (1.0 - 2.0 / (1.0 + squared)), nan=1.0)


class Varied(NamedTuple):
    """A quantity that varies, with its range.

    Attributes:
        variation: as of a sweep, with the range.
        joints: those that are moved, all to the same value; none of another variation.
        span: smallest and largest value [rad, m; unit of the variation].
    """

    variation: Variation
    joints: tuple[Joint, ...]
    span: tuple[float, float]

    @property
    def names(self) -> tuple[str, ...]:
        """The joints, or the subject of another variation."""
        return tuple(joint.name for joint in self.joints) or (self.variation.subject,)

    @property
    def unit(self) -> str:
        """Unit of the values: "rad" or "m", or that of another variation."""
        return self.variation.unit.replace("deg", "rad")

    @property
    def file_limits(self) -> tuple[float, float]:
        """The robot file's limits that all joints have in common [rad, m]; infinite without any."""
        low = max((joint.limits[0] for joint in self.joints), default=-math.inf)
        high = min((joint.limits[1] for joint in self.joints), default=math.inf)
        return low, high


def bound_from(most: float | None, least: float | None) -> Bound:
    """The one bound that is given.

    Raises:
        StudyError: none or two are.
    """
    if most is not None and least is None:
        return Bound(most, below=False)
    if least is not None and most is None:
        return Bound(least, below=True)
    raise StudyError(
        "one bound is needed: max for the largest value that is allowed, or min for the smallest"
    )


def refuse_senseless(landing: PosedLanding, number: Column, bound: Bound, varied: Varied) -> None:
    """Refuse a question that has no meaning.

    It has a bound on the better side, a loop whose joints move, or a velocity that no strike angle
    turns.

    Raises:
        StudyError: the question is one of these.
    """
    worse = number.selection.quantity.worse
    if worse == ("greater" if bound.below else "less"):
        side = "max" if bound.below else "min"
        raise StudyError(f"the {worse} value of {number.name} is the worse one; bound it by {side}")
    if varied.joints and landing.loops and landing.before.joint_rates.any():
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


def default_step(varied: Varied, per_landing: bool) -> float:
    """Largest step of a scan if none is given [rad, m; unit of the variation].

    Args: varied, what varies; per_landing, whether each landing is computed by itself.
    """
    if not varied.joints:
        low, high = varied.span
        return (high - low) / STEPS
    step = STEP[varied.unit]
    return COARSER * step if per_landing else step


def scan_values(varied: Varied, step: float) -> Array:
    """The values (n,) of a scan, ascending, at most a step apart [rad, m; unit of the variation].

    Raises:
        StudyError: the step is not possible.
    """
    low, high = varied.span
    scale = varied.variation.per_unit
    if not step > 0.0 or (high - low) / step > MOST_VALUES:
        raise StudyError(
            f"a step of {scale * step:g} in a range of {scale * (high - low):g} is "
            f"not possible; give a step above zero that makes at most {MOST_VALUES} postures"
        )
    steps = math.ceil((high - low) / step - 1e-9)
    return np.linspace(low, high, max(LEAST_VALUES, steps + 1))


def varied_by(robot: Robot, subject: str, span: tuple[float, float] | None) -> Varied:
    """The quantity that varies, its joints and its range.

    Args:
        robot: the robot.
        subject: as a sweep names it.
        span: the range, if one is given [rad, m; unit of the variation].

    Raises:
        UnknownName: there is no such joint.
        StudyError: it has no limits, or no range.
    """
    kind, target = kind_of(robot, subject)
    if kind == STRIKE_ANGLE:
        raise StudyError(
            f"{subject} has no limits here: limits are found over strike angles; give their range "
            f"with --strikes"
        )
    if kind.names_contacts:
        raise StudyError(
            f"{subject} has no limits here: contacts have names, which have no order; compute each "
            f"landing, or compare them with shockpc sweep"
        )
    low, high = math.nan, math.nan
    missing = "not given"
    joints = kind.settable(robot, target)
    if joints:
        low, high = motion_range(joints)
        missing = "without limits in the file"
    if span is not None:
        low, high = span
    is_angle = kind.unit_of(robot, subject, target) == "deg"
    scale = math.degrees(1.0) if is_angle else 1.0
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        if math.isfinite(low + high):
            missing = f"{scale * low:.5g}:{scale * high:.5g}"
        raise StudyError(
            f"the range of {subject} is {missing}; give its minimum and maximum with --range "
            f"LOW:HIGH"
        )
    typed = variation(robot, subject, (scale * low, scale * high))
    return Varied(typed, joints, (low, high))


def strike_range(landing: PosedLanding, strikes: Strikes | None, per_landing: bool) -> Strikes:
    """The range of strike angles [rad], all of which approach the ground.

    Args:
        landing: the landing of the scene.
        strikes: the range, if one is given.
        per_landing: whether each landing is computed by itself; the scene's angle is then the
            default.
    """
    if strikes is not None:
        low, high = strikes
    elif per_landing:
        low = high = landing.strike_angle
    else:
        low, high = STRIKES
    most = math.radians(STEEPEST) * (1.0 + 1e-12)
    if not -most <= low <= high <= most:
        raise StudyError(
            f"{in_degrees(low):.4g}:{in_degrees(high):.4g} is not a range of strike angles; give "
            f"the smaller angle first, both between -{STEEPEST:g} and {STEEPEST:g} deg"
        )
    return low, high


def strike_targets(angle: float, strikes: Strikes) -> tuple[Strikes, ...]:
    """The strikes for which limits are found [rad].

    They are the scene's, others one by one, and last all of the range.
    """
    low, high = strikes
    first, last = math.ceil(low / STRIKE_ANGLE_STEP), math.floor(high / STRIKE_ANGLE_STEP)
    inside = [STRIKE_ANGLE_STEP * k for k in range(first, last + 1)]
    # Angles that differ by the rounding of degrees are the same.
    single = {round(strike, 9): strike for strike in (*inside, low, high, angle)}
    one_by_one = [(strike, strike) for strike in sorted(single.values()) if strike != angle]
    return tuple(dict.fromkeys([(angle, angle), *one_by_one, strikes]))
