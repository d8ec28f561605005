"""Which values of a joint, under which strikes, keep the shock at a point below a bound.

A dense scan finds where the shock crosses the bound. Between two samples an extremum that could reach the bound is located, and
every crossing is found as a root of the shock itself.
"""

import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Literal, NamedTuple

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from shockpc.core.spatial import Array, Plane
from shockpc.errors import SolveError, StudyError
from shockpc.model.posture import settable_joints
from shockpc.printed import listed
from shockpc.profile import shock_profile
from shockpc.result import ShockProfile
from shockpc.robot.record import Robot
from shockpc.scene import Point, Scene
from shockpc.solve import UNPHYSICAL
from shockpc.studies.joint_scan import JointScan, greatest_shock, wave
from shockpc.studies.question import moving_point, strike_angle
from shockpc.toml import LARGEST
from shockpc.trace import Trace

__all__ = ["Interval", "ShockLimits", "StrikeLimits", "limits"]

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
        allowed: values of the joint for which the shock of each of these strikes is at most the bound, ascending.
        least: least shock over the joint's values, of the most severe of these strikes [1].
        least_at: where that is [rad, m].
    """

    strikes: tuple[float, float]
    allowed: tuple[Interval, ...]
    least: float
    least_at: float


@dataclass(frozen=True, eq=False)
class ShockLimits:
    """The joint limits that a bound on the shock at a point sets.

    Attributes:
        profile: the landing in the scene's own posture.
        point: label of the point.
        joints: the joints that are moved, all to the same value.
        unit: of that value, "rad" or "m".
        max_shock: the bound [1].
        range: least and greatest value looked at [rad, m].
        file_limits: those of the robot's file; infinite where it gives none [rad, m].
        own: the value and the strike angle of the scene [rad, m; rad].
        strikes: least and greatest strike angle looked at [rad].
        step: largest distance between the values of the scan [rad, m].
        scan: the postures and their shock.
        limits: at the scene's own strike angle, at others one by one, and last at all strike angles of the range.
    """

    profile: ShockProfile = field(repr=False)
    point: str
    joints: tuple[str, ...]
    unit: str
    max_shock: float
    range: tuple[float, float]
    file_limits: tuple[float, float]
    own: tuple[float, float]
    strikes: tuple[float, float]
    step: float
    scan: JointScan = field(repr=False)
    limits: tuple[StrikeLimits, ...]

    def shock(self, strikes: Array) -> Array:
        """The shock (n, k) of every posture of the scan. Args: strikes (k,) strike angles [rad]."""
        return np.stack([greatest_shock(self.scan.gram, (angle, angle))[0] for angle in np.asarray(strikes).tolist()], axis=1)

    @property
    def most_severe(self) -> tuple[Array, Array]:
        """The greatest shock (n,) of every posture over the range of strike angles [1], and the strike angle (n,) of it [rad]."""
        return greatest_shock(self.scan.gram, self.strikes)

    def allowed_strikes(self, k: int) -> tuple[tuple[float, float], ...]:
        """The strike angles of the range that keep the bound in posture k of the scan, as intervals [rad]."""
        m, r, phi = (float(part[0]) for part in wave(self.scan.gram[k : k + 1]))
        low, high = self.strikes
        if math.isnan(m):
            return ()
        height = (self.max_shock**2 - m) / r if r > 0.0 else math.copysign(math.inf, self.max_shock**2 - m)
        if height >= 1.0:
            return ((low, high),)
        # Above the bound nearer than this to the angles φ/2 + kπ, so that it is kept from each of them to the next one.
        half, middles = math.acos(max(height, -1.0)) / 2.0, [phi / 2.0 + turn * math.pi for turn in (-2, -1, 0, 1, 2)]
        kept = [(max(a + half, low), min(b - half, high)) for a, b in itertools.pairwise(middles)]
        return tuple((a, b) for a, b in kept if a < b)


def limits(
    scene: Scene,
    joint: str,
    at: Point,
    max_shock: float,
    *,
    joint_range: tuple[float, float] | None = None,
    strikes: tuple[float, float] | None = None,
    step: float | None = None,
    robot: Robot | None = None,
    trace: Trace | None = None,
) -> ShockLimits:
    """Find the values of a joint that keep the shock at a point below a bound.

    Args:
        scene: the landing; the joint's own value is not used, except that loops are followed from it.
        joint: name or glob; joints that it matches all have the same value.
        at: the point.
        max_shock: the bound, |Δv| / v_in [1].
        joint_range: least and greatest value [rad, m]; by default the limits in the file, or a whole turn.
        strikes: least and greatest strike angle [rad]; by default −30° to 75°.
        step: largest distance between two postures of the scan [rad, m]; by default 0.1° or 0.1 mm.
        robot: the scene's robot, if it is loaded already.
        trace: collects what each stage cost.

    Raises:
        StudyError: the question makes no sense, or no value of the joint keeps the bound at any strike.
        SolveError: no posture of the range has a result.
        ShockError: the landing cannot be computed.
    """
    trace = trace or Trace()
    if not 0.0 < max_shock <= LARGEST:
        raise StudyError(
            f"a bound of {max_shock:g} on the shock is not valid; give one above zero, such as 0.1, and at most {LARGEST:g}"
        )
    profile = shock_profile(scene, robot, trace)
    landing, robot = profile.landing, profile.robot
    if landing.before.omega.any() or landing.before.joint_rates.any():
        raise StudyError(
            "limits compare strikes of a robot that moves without rotating; leave the angular velocity and the joint velocities out"
        )
    place, joints = moving_point(robot, at), settable_joints(robot, joint, StudyError)
    names, unit = tuple(one.name for one in joints), joints[0].unit
    if any(one.unit != unit for one in joints):
        raise StudyError(f"joints {listed(names)} turn and slide, so they cannot have the same value; name joints of one kind")
    file_limits = max(one.limits[0] for one in joints), min(one.limits[1] for one in joints)
    low, high = _range(joint, file_limits, joint_range, unit)
    angles = _strike_range(landing.plane, strikes)
    step = STEP[unit] if step is None else step
    if not step > 0.0 or (high - low) / step > MOST:
        raise StudyError(
            f"a step of {_value(step, unit)} from {_value(low, unit)} to {_value(high, unit)} is not possible; "
            f"give one above zero that makes at most {MOST} postures"
        )
    with trace.stage("scan of the joint"):
        values = np.linspace(low, high, math.ceil((high - low) / step - 1e-9) + 1)
        scan = JointScan(landing, place, joints, values, 0.1 * STEP[unit])
        if np.isnan(scan.gram).all():
            raise SolveError(f"no posture in {_span(low, high, unit)} has a result: {scan.unreachable[0][2]}")
    own = strike_angle(landing)
    ends: tuple[End, End] = ("range" if scan.values[0] <= low else "loop", "range" if scan.values[-1] >= high else "loop")
    with trace.stage("roots"):
        found = [_limits(scan, strike, max_shock, ends, FINE[unit]) for strike in _targets(own, angles)]
    if not any(one.allowed for one in found):
        best = min(found, key=lambda one: one.least)
        what = "angle" if unit == "rad" else "position"
        several = f" at any of {len(found) - 1} strike angles in {_span(*angles, 'rad')}" if len(found) > 1 else ""
        where = f", strike angle {_value(best.strikes[0], 'rad')}" if several else ""
        raise StudyError(
            f"no {what} in {_span(low, high, unit)} meets {max_shock:g}{several}; "
            f"the least is {best.least:.3g} at {_value(best.least_at, unit)}{where}; "
            "allow a greater shock, or give another range with --range"
        )
    here = (joints[0].value(landing.q), own)
    return ShockLimits(
        profile, place.name, names, unit, max_shock, (low, high), file_limits, here, angles, step, scan, tuple(found)
    )


def _limits(scan: JointScan, strikes: tuple[float, float], bound: float, ends: tuple[End, End], fine: float) -> StrikeLimits:
    """The intervals of the joint that keep the bound at some strikes."""

    def excess(value: float) -> float:
        return scan.greatest(value, strikes) - bound

    x, g = scan.values.tolist(), (np.nan_to_num(greatest_shock(scan.gram, strikes)[0], nan=UNPHYSICAL) - bound).tolist()
    k = int(np.argmin(g))
    least_at, shock = _extremum(excess, x[k - 1], x[k + 1], 1.0, fine) if 0 < k < len(x) - 1 else (x[k], g[k])
    points = sorted({**dict(zip(x, g, strict=True)), **dict(_between(excess, x, g, fine))}.items())
    edges: list[tuple[float, End]] = [(points[0][0], ends[0])] if points[0][1] <= 0.0 else []
    for (a, g_a), (b, g_b) in itertools.pairwise(points):
        if (g_a <= 0.0) != (g_b <= 0.0):
            edges.append((a if g_a == 0.0 else b if g_b == 0.0 else float(brentq(excess, a, b, xtol=fine)), "bound"))
    edges += [(points[-1][0], ends[1])] if points[-1][1] <= 0.0 else []
    allowed = [Interval(a, b, low, high) for (a, low), (b, high) in zip(edges[::2], edges[1::2], strict=True)]
    return StrikeLimits(strikes, tuple(allowed), shock + bound, least_at)


def _between(excess: Callable[[float], float], x: list[float], g: list[float], fine: float) -> Iterator[tuple[float, float]]:
    """Extrema between samples at which the shock crosses the bound and returns, although the samples on both sides do not tell."""
    for i in range(1, len(x) - 1):
        sign = 1.0 if g[i] > 0.0 else -1.0
        here, before, after = sign * g[i], sign * g[i - 1], sign * g[i + 1]
        # A step changes the shock by about as much on one side of an extremum as on the other.
        if here <= min(before, after) and here < max(before - here, after - here):
            value, found = _extremum(excess, x[i - 1], x[i + 1], sign, fine)
            if sign * found <= 0.0:
                yield value, found


def _extremum(excess: Callable[[float], float], low: float, high: float, sign: float, fine: float) -> tuple[float, float]:
    """The least value of sign · excess between two values: where, and the excess there."""
    found = minimize_scalar(
        lambda value: sign * excess(float(value)), bounds=(low, high), method="bounded", options={"xatol": fine}
    )
    return float(found.x), sign * float(found.fun)


def _range(pattern: str, file: tuple[float, float], given: tuple[float, float] | None, unit: str) -> tuple[float, float]:
    """The range of the scan [rad, m]."""
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
        raise StudyError("a plane seen from above holds no vertical to measure strike angles from; choose another plane")
    low, high = given or (math.radians(STRIKES[0]), math.radians(STRIKES[1]))
    most = math.radians(STEEPEST) * (1.0 + 1e-12)
    if not -most <= low <= high <= most:
        raise StudyError(
            f"strike angles from {_value(low, 'rad')} to {_value(high, 'rad')} are no range of landings; "
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
    """A value with its unit as messages show it."""
    degrees = round(math.degrees(value), 12) + 0.0
    text = f"{round(degrees, 2) or degrees:g}°" if unit == "rad" else f"{1e3 * value:.4g} mm"
    return text.replace("-", "−")


def _span(low: float, high: float, unit: str) -> str:
    """A range with its unit as messages show it."""
    return f"{_value(low, unit)}…{_value(high, unit)}"
