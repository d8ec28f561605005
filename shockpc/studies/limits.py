"""Which values of a joint, under which strikes, keep a number below a bound: the shock at a point, a torque, a friction.

A dense scan finds where the number crosses the bound. Between two samples an extremum that could reach the bound is located, and
every crossing is found as a root of the number itself.
"""

import functools
import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Literal, NamedTuple

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from shockpc.core.spatial import Array, Plane
from shockpc.evaluation.columns import Column, column
from shockpc.landing.posture import settable_joints
from shockpc.landing.scene import Point, Scene
from shockpc.profile import shock_profile
from shockpc.quantities.profile import ShockProfile
from shockpc.quantities.table import select
from shockpc.robot.robot import Joint, Robot
from shockpc.studies.joint_scan import Bound, JointScan
from shockpc.studies.question import refuse_ground
from shockpc.text.errors import SolveError, StudyError
from shockpc.text.printed import listed
from shockpc.text.toml import LARGEST
from shockpc.text.trace import Trace

STRIKES = (-30.0, 75.0)
"""Strike angles of landings that are looked at if none are given [deg]."""

EVERY = 15.0
"""Between the strike angles for which limits are given one by one [deg]."""

STEEPEST = 89.0
"""Largest strike angle; at 90° the contact moves along the ground [deg]."""

STEP = {"rad": math.radians(0.1), "m": 1e-4}
"""Largest step of the scan if none is given: 0.1°, 0.1 mm."""

FINE = {"rad": 1e-6, "m": 1e-9}
"""To which a limit is found: far below 0.01° and 0.01 mm."""

MOST = 200_000
"""Largest number of postures of a scan."""

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


@dataclass(frozen=True, eq=False)
class JointLimits:
    """The limits of a joint that a bound on a number sets.

    Attributes:
        profile: the landing in the scene's own posture.
        target: the number.
        joints: the joints that are moved, all to the same value.
        unit: of that value, "rad" or "m".
        bound: of the number, in its unit.
        range: least and greatest value looked at [rad, m].
        file_limits: those of the robot's file; infinite where it gives none [rad, m].
        own: the value and the strike angle of the scene [rad, m; rad].
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
    scan: JointScan = field(repr=False)
    limits: tuple[StrikeLimits, ...]

    @functools.cached_property
    def worst(self) -> tuple[Array, Array]:
        """The worst number (n,) of every posture over the range of strike angles, and the strike angle (n,) of it [rad]."""
        return self.scan.worst(*self.strikes)

    @functools.cached_property
    def allowed_strikes(self) -> list[list[tuple[float, float]]]:
        """The strike angles of the range that keep the bound in each posture of the scan, as intervals [rad]."""
        return self.scan.kept(*self.strikes)


def limits(
    scene: Scene,
    joint: str,
    target: str | Point,
    max: float | None = None,
    *,
    min: float | None = None,
    joint_range: tuple[float, float] | None = None,
    strikes: tuple[float, float] | None = None,
    step: float | None = None,
    robot: Robot | None = None,
    trace: Trace | None = None,
) -> JointLimits:
    """Find the values of a joint that keep a number at or below a bound, or at or above one.

    The strike angle turns the part of the velocity that is in the plane; the part out of it, and what else moves before the impact,
    stays as it is.

    Args:
        scene: the landing; the joint's own value is not used, except that loops are followed from it.
        joint: name or glob; joints that it matches all have the same value.
        target: QUANTITY@PLACE, or QUANTITY of the robot as a whole; a point means the shock there.
        max: the greatest value allowed, in the unit of the number; of one that may be negative of its magnitude.
        min: the least value allowed, instead: of a number of which less is worse.
        joint_range: least and greatest value [rad, m]; by default the limits in the file, or a whole turn.
        strikes: least and greatest strike angle [rad]; by default −30° to 75°, or that of the scene alone if the
            number is computed in one posture at a time, with a proof of each.
        step: largest distance between two postures of the scan [rad, m]; by default 0.1° or 0.1 mm, or 20 times that then.
        robot: the scene's robot, if it is loaded already.
        trace: collects what each stage cost.

    Raises:
        UnknownName: there is no such joint, quantity or place.
        StudyError: the question makes no sense.
        SolveError: no posture of the range has a result.
        ShockError: the landing cannot be computed.
    """
    trace = trace or Trace()
    given = [Bound(value, below) for value, below in ((max, False), (min, True)) if value is not None]
    if len(given) != 1:
        raise StudyError("one bound is needed: max for the greatest value that is allowed, or min for the least")
    bound = given[0]
    if not 0.0 < bound.value <= LARGEST:
        raise StudyError(f"a bound of {bound.value:g} is not valid; give one above zero, such as 0.1, and at most {LARGEST:g}")
    profile = shock_profile(scene, robot, trace)
    landing, robot = profile.landing, profile.robot
    text = f"shock@{target.label}" if isinstance(target, Point) else target
    asked = column(profile, text, lambda entry: entry.compute is not None and entry.key != "feasible")
    entry = asked.selection.quantity
    if entry.worse == ("greater" if bound.below else "less"):
        raise StudyError(f"the {entry.worse} value of {asked.name} is the worse one; bound it by {'max' if bound.below else 'min'}")
    if not (alone := entry.alone(profile.scene)):
        refuse_ground(scene, friction=False)  # what is feasible depends on the friction
    joints = settable_joints(robot, joint, StudyError)
    names, unit = tuple(one.name for one in joints), joints[0].unit
    if any(one.unit != unit for one in joints):
        raise StudyError(f"joints {listed(names)} turn and slide, so they cannot have the same value; name joints of one kind")
    if landing.loops and landing.before.joint_rates.any():
        raise StudyError("how fast joints of a loop move depends on the posture; leave the joint velocities out")
    file_limits = _file_limits(joints)
    low, high = _range(joint, file_limits, joint_range, unit)
    own = landing.strike_angle
    angles = _strike_range(landing.plane, (own, own) if alone and strikes is None else strikes)
    if not np.linalg.norm(landing.before.velocity @ np.stack([landing.plane.forward, [0.0, 0.0, 1.0]], axis=1)) > 0.0:
        raise StudyError(
            "the robot's velocity has no part in the plane that a strike angle could turn; give another plane or velocity"
        )
    step = STEP[unit] * (20 if alone else 1) if step is None else step
    if not step > 0.0 or (high - low) / step > MOST:
        raise StudyError(
            f"a step of {_value(step, unit)} from {_value(low, unit)} to {_value(high, unit)} is not possible; "
            f"give one above zero that makes at most {MOST} postures"
        )
    with trace.stage("scan of the joint"):
        values = np.linspace(low, high, math.ceil((high - low) / step - 1e-9) + 1)
        feasible = Column(select("feasible"), profile.places("robot")[0])
        scan = JointScan(landing, asked, bound, feasible, joints, values, 0.1 * STEP[unit])
        if scan.unreachable and np.isnan(scan.own).all():
            raise SolveError(f"no posture from {_value(low, unit)} to {_value(high, unit)} has a result: {scan.unreachable[0][2]}")
    ends: tuple[End, End] = ("range" if scan.values[0] <= low else "loop", "range" if scan.values[-1] >= high else "loop")
    with trace.stage("roots"):
        rows = tuple(_limits(scan, strike, bound, ends, FINE[unit]) for strike in _targets(scan.own_angle, angles))
    here = (joints[0].value(landing.q), scan.own_angle)
    return JointLimits(profile, asked, names, unit, bound, (low, high), file_limits, here, angles, step, scan, rows)


def _file_limits(joints: Sequence[Joint]) -> tuple[float, float]:
    return max(joint.limits[0] for joint in joints), min(joint.limits[1] for joint in joints)


def _limits(scan: JointScan, strikes: tuple[float, float], bound: Bound, ends: tuple[End, End], fine: float) -> StrikeLimits:
    """The intervals of the joint that keep the bound at some strikes."""

    def over(value: float) -> float:
        return float(bound.excess(scan.worst(*strikes, value)[0])[0])

    x, numbers = scan.values.tolist(), scan.worst(*strikes)[0]
    g = bound.excess(numbers).tolist()
    feasible = scan.feasible(*strikes)
    k = int(np.argmin(np.where(feasible, g, np.inf)))
    best_at, best = _extremum(over, x[k - 1], x[k + 1], 1.0, fine) if feasible[k - 1 : k + 2].sum() == 3 else (x[k], g[k])
    if np.isnan(numbers[k]) or not feasible[k]:
        best_at = best = math.nan
    points = sorted({**dict(zip(x, g, strict=True)), **dict(_between(over, x, g, fine))}.items())
    edges: list[tuple[float, End]] = [(points[0][0], ends[0])] if points[0][1] <= 0.0 else []
    for (a, g_a), (b, g_b) in itertools.pairwise(points):
        if (g_a <= 0.0) != (g_b <= 0.0):
            edges.append((a if g_a == 0.0 else b if g_b == 0.0 else float(brentq(over, a, b, xtol=fine)), "bound"))
    edges += [(points[-1][0], ends[1])] if points[-1][1] <= 0.0 else []
    allowed = [Interval(a, b, low, high) for (a, low), (b, high) in zip(edges[::2], edges[1::2], strict=True)]
    runs = itertools.groupby(zip(feasible.tolist(), x, strict=True), key=lambda one: one[0])
    lengths = [[value for _, value in run] for holds, run in runs if holds]
    return StrikeLimits(strikes, tuple(allowed), tuple((run[0], run[-1]) for run in lengths), bound.number(best), best_at)


def _between(over: Callable[[float], float], x: list[float], g: list[float], fine: float) -> Iterator[tuple[float, float]]:
    """Extrema between samples at which the number crosses the bound and returns, although the samples on both sides do not tell."""
    for i in range(1, len(x) - 1):
        sign = 1.0 if g[i] > 0.0 else -1.0
        here, before, after = sign * g[i], sign * g[i - 1], sign * g[i + 1]
        # A step changes the number by about as much on one side of an extremum as on the other.
        if here <= min(before, after) and here < max(before - here, after - here):
            value, extremum = _extremum(over, x[i - 1], x[i + 1], sign, fine)
            if sign * extremum <= 0.0:
                yield value, extremum


def _extremum(over: Callable[[float], float], low: float, high: float, sign: float, fine: float) -> tuple[float, float]:
    """The least value of sign · over between two values: where, and the number there."""
    solution = minimize_scalar(
        lambda value: sign * over(float(value)), bounds=(low, high), method="bounded", options={"xatol": fine}
    )
    return float(solution.x), sign * float(solution.fun)


def _range(pattern: str, file: tuple[float, float], given: tuple[float, float] | None, unit: str) -> tuple[float, float]:
    turn = math.pi
    # Files write "no limit" in many ways; a whole turn holds every posture of a joint that turns.
    whole = (max(file[0], -turn), min(file[1], turn)) if unit == "rad" else file
    low, high = given or whole
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        what = f"from {_value(low, unit)} to {_value(high, unit)}" if math.isfinite(low + high) else "without limits in the file"
        raise StudyError(f'the range of joint "{pattern}" is {what}; give its least and greatest value with --range LOW:HIGH')
    return low, high


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


def _targets(own: float, strikes: tuple[float, float]) -> list[tuple[float, float]]:
    """The strikes for which limits are found: the scene's own, others one by one, and all of the range."""
    low, high = (math.degrees(angle) for angle in strikes)
    inside = [EVERY * k for k in range(math.ceil(low / EVERY), math.floor(high / EVERY) + 1)]
    single = sorted({round(float(angle), 9) for angle in (low, *inside, high)})
    own_deg = round(math.degrees(own), 9)
    others = [math.radians(angle) for angle in single if angle != own_deg]
    return list(dict.fromkeys([(own, own), *((angle, angle) for angle in others), strikes]))


def _value(value: float, unit: str) -> str:
    degrees = round(math.degrees(value), 12) + 0.0
    text = f"{round(degrees, 2) or degrees:g}°" if unit == "rad" else f"{1e3 * value:.4g} mm"
    return text.replace("-", "−")
