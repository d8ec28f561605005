"""Which values of a joint, under which strikes, keep the shock at a point below a bound.

A dense scan finds where the shock crosses the bound. Between two samples an extremum that could reach the bound is located, and
every crossing is found as a root of the shock itself. The shock of one posture over all strike angles is known in closed form: with
E the map from the strike's components to the velocity of the point, |E (sin θ, cos θ)|² = m + r cos(2θ − φ).
"""

import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import Literal, NamedTuple

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from shockpc.core.spatial import Array, Plane, cross_matrix
from shockpc.errors import SceneError, ShockError, SolveError, StudyError
from shockpc.landing import Landing
from shockpc.model.closure import assemble
from shockpc.model.dynamics import dynamics
from shockpc.model.posture import configuration, held_joints
from shockpc.profile import ILL_CONDITIONED, SWIFT, proof_of, shock_maps, shock_profile
from shockpc.result import ShockProfile
from shockpc.results.points import Spot
from shockpc.results.proof import UNPHYSICAL
from shockpc.robot.robot import Joint, Robot
from shockpc.scene import Point, Scene
from shockpc.studies.question import moving_spot, strike_angle
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
        values: (n,) values of the scan; less than the range where a loop cannot be closed [rad, m].
        gram: (n, 2, 2) EᵀE of every posture: with u = (sin θ, cos θ), uᵀ gram u is the square of the shock.
        limits: at the scene's own strike angle, at others one by one, and last at all strike angles of the range.
        unreachable: (least value, greatest value, reason) of the ranges in which a loop cannot be closed or the landing has no
            result; there `gram` is NaN.
        inaccurate: number of postures in which rounding may show above 1e-9.
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
    values: Array = field(repr=False)
    gram: Array = field(repr=False)
    limits: tuple[StrikeLimits, ...]
    unreachable: tuple[tuple[float, float, str], ...]
    inaccurate: int

    def shock(self, strikes: Array) -> Array:
        """The shock (n, k) of every posture of the scan. Args: strikes (k,) strike angles [rad]."""
        return np.stack([_greatest(self.gram, (angle, angle))[0] for angle in np.asarray(strikes).tolist()], axis=1)

    @property
    def most_severe(self) -> tuple[Array, Array]:
        """The greatest shock (n,) of every posture over the range of strike angles [1], and the strike angle (n,) of it [rad]."""
        return _greatest(self.gram, self.strikes)

    def allowed_strikes(self, k: int) -> tuple[tuple[float, float], ...]:
        """The strike angles of the range that keep the bound in posture k of the scan, as intervals [rad]."""
        m, r, phi = (float(part[0]) for part in _wave(self.gram[k : k + 1]))
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
    if not (math.isfinite(max_shock) and max_shock > 0.0):
        raise StudyError(f"a bound of {max_shock:g} on the shock is kept by nothing; it has to be above zero, such as 0.1")
    profile = shock_profile(scene, robot, trace)
    landing, robot = profile.landing, profile.robot
    if landing.before.omega.any() or landing.before.joint_rates.any():
        raise StudyError(
            "limits compare strikes of a robot that moves without rotating; leave the angular velocity and the joint velocities out"
        )
    spot = moving_spot(robot, at)
    joints = _joints(robot, joint)
    unit, file_limits = joints[0].unit, (max(one.limits[0] for one in joints), min(one.limits[1] for one in joints))
    low, high = _range(joint, file_limits, joint_range, unit)
    angles = _strike_range(landing.plane, strikes)
    step = STEP[unit] if step is None else step
    if not step > 0.0 or (high - low) / step > MOST:
        raise StudyError(
            f"a step of {_value(step, unit)} from {_value(low, unit)} to {_value(high, unit)} is not possible; "
            f"give one above zero that makes at most {MOST} postures"
        )
    sweep = _Sweep(landing, spot, joint, joints)
    with trace.stage("scan of the joint"):
        values, Q, unreachable = sweep.postures(np.linspace(low, high, math.ceil((high - low) / step - 1e-9) + 1))
        gram, refused, inaccurate = sweep.grams(Q)
        if len(refused) == len(values):
            raise SolveError(f"no posture in {_span(low, high, unit)} has a result: {refused[0]}")
    unreachable = tuple(sorted((*unreachable, *_ranges(values, refused))))
    own = strike_angle(landing)
    ends: tuple[End, End] = ("range" if values[0] <= low else "loop", "range" if values[-1] >= high else "loop")
    with trace.stage("roots"):
        found = [_limits(sweep, values, Q, gram, strike, max_shock, ends, FINE[unit]) for strike in _targets(own, angles)]
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
    names = tuple(one.name for one in joints)
    here = (joints[0].value(landing.q), own)
    return ShockLimits(
        profile, spot.label, names, unit, max_shock, (low, high), file_limits, here, angles, step, values, gram, tuple(found),
        unreachable, inaccurate,
    )  # fmt: skip


class _Sweep:
    """The landing with the joint at other values.

    Args:
        landing: in the scene's posture.
        spot: where the shock is computed.
        pattern: name or glob of the joints.
        joints: what it means.
    """

    def __init__(self, landing: Landing, spot: Spot, pattern: str, joints: tuple[Joint, ...]) -> None:
        self._landing, self._spot, self._pattern, self._joints = landing, spot, pattern, joints
        forward, up = landing.plane.forward, np.array([0.0, 0.0, 1.0])
        self._axes = np.stack([forward, -up], axis=1)
        self._rank: int | None = None

    def posture(self, value: float, near: Array) -> Array:
        """The configuration (nq,) with the joint at a value [rad, m]; loops are closed from a configuration near it.

        Raises:
            SceneError: a loop cannot be closed.
        """
        landing = self._landing
        robot, posture = landing.robot, landing.scene.posture
        typed = value if self._joints[0].unit == "m" else math.degrees(value)
        others = {name: given for name, given in posture.joints_deg.items() if name != self._pattern}
        posture = replace(posture, joints_deg=others | {self._pattern: typed})
        q = configuration(robot, posture)
        if not landing.loops:
            return q
        held = held_joints(robot, posture, landing.scene.assemble)
        moved = {joint.name for joint in self._joints}
        moved |= {mimic.joint for mimic in robot.mimics if not moved.isdisjoint(mimic.leaders)}
        for other in robot.single_joints:
            if other.name in moved:
                held[other.v] = True
            elif not held[other.v].any():
                q[other.q] = near[other.q]
        return assemble(robot, q, landing.loops, landing.plane, held).q

    def postures(self, values: Array) -> tuple[Array, Array, tuple[tuple[float, float, str], ...]]:
        """The values (n,) that can be reached, their configurations (n, nq), and the ranges that cannot be, with the reason.

        A loop is followed from the scene's own posture in both directions, each from the one before, so that it stays assembled in
        the same way; where it can no longer be closed, the walk ends.
        """
        landing = self._landing
        if not landing.loops:
            return values, np.stack([self.posture(value, landing.q) for value in values.tolist()]), ()
        start = int(np.argmin(np.abs(values - self._joints[0].value(landing.q))))
        found: dict[float, Array] = {}
        refused: list[tuple[float, float, str]] = []
        for walk in (values[start:].tolist(), values[start::-1].tolist()):
            near, last = landing.q, None
            for value in walk:
                try:
                    near = self.posture(value, near)
                except SceneError as refusal:
                    if last is not None:
                        last, near = self._farthest(last, value, near)
                        found[last] = near
                    beyond = value if last is None else last
                    refused.append((min(beyond, walk[-1]), max(beyond, walk[-1]), str(refusal)))
                    break
                found[value], last = near, value
        if not found:
            raise StudyError(f"no value in the range can be assembled: {refused[0][2]}")
        ordered = sorted(found)
        return np.array(ordered), np.stack([found[value] for value in ordered]), tuple(sorted(set(refused)))

    def _farthest(self, good: float, bad: float, near: Array) -> tuple[float, Array]:
        """The last value that a loop can reach between one that it can and one that it cannot, and its configuration."""
        while abs(bad - good) > 0.1 * STEP[self._joints[0].unit]:
            middle = (good + bad) / 2.0
            try:
                near, good = self.posture(middle, near), middle
            except SceneError:
                bad = middle
        return good, near

    def grams(self, Q: Array) -> tuple[Array, dict[int, str], int]:
        """EᵀE (n, 2, 2) in some configurations (n, nq), the reason where there is none, and in how many rounding may show.

        Where other rows are independent than in most postures of the scan, or the motion is very fast, the posture is singular or
        nearly so, and a proof decides; NaN where it refuses.
        """
        landing, body = self._landing, self._spot.frame.body
        maps = shock_maps(landing, Q)
        if self._rank is None:
            ranks, counts = np.unique(maps.rank, return_counts=True)
            self._rank = int(ranks[np.argmax(counts)])
        E, refused = maps.at(body, self._spot.r), dict[int, str]()
        singular = (maps.rank != self._rank) | ~(np.abs(maps.maps).max(axis=(1, 2, 3)) < SWIFT)
        for k in np.flatnonzero(singular).tolist():
            there = replace(landing, q=Q[k], state=dynamics(landing.robot, Q[k][None], landing.joint_model.armature))
            try:
                jumps = proof_of(there).jumps[body, :, :3]
            except ShockError as refusal:
                E[k], refused[k] = np.nan, str(refusal)
                continue
            E[k] = there.state.rotation[0, body] @ (jumps[3:] - cross_matrix(self._spot.r) @ jumps[:3])
        E = E @ self._axes
        return np.swapaxes(E, -1, -2) @ E, refused, int((~singular & (maps.condition > ILL_CONDITIONED)).sum())

    def greatest(self, value: float, near: Array, strikes: tuple[float, float]) -> float:
        """The greatest shock over some strikes with the joint at a value, as `posture` takes it; as for `_shocks`."""
        return float(_shocks(self.grams(self.posture(value, near)[None])[0], strikes)[0])


def _ranges(values: Array, refused: dict[int, str]) -> Iterator[tuple[float, float, str]]:
    """The ranges of consecutive postures without a result, with the first one's reason."""
    for first in sorted(refused.keys() - {k + 1 for k in refused}):
        last = next(k for k in itertools.count(first) if k + 1 not in refused)
        yield float(values[first]), float(values[last]), refused[first]


def _shocks(gram: Array, strikes: tuple[float, float]) -> Array:
    """The greatest shock (n,) over a range of strike angles; beyond any bound where there is no result."""
    return np.nan_to_num(_greatest(gram, strikes)[0], nan=UNPHYSICAL)


def _wave(gram: Array) -> tuple[Array, Array, Array]:
    """m, r and φ (n,) of the squared shock m + r cos(2θ − φ)."""
    a, b, c = gram[:, 0, 0], gram[:, 0, 1], gram[:, 1, 1]
    return (a + c) / 2.0, np.hypot((c - a) / 2.0, b), np.arctan2(b, (c - a) / 2.0)


def _greatest(gram: Array, strikes: tuple[float, float]) -> tuple[Array, Array]:
    """The greatest shock (n,) over a range of strike angles, and the strike angle (n,) that has it [rad]."""
    low, high = strikes
    angles = [np.full(len(gram), low), np.full(len(gram), high)]
    if high > low:
        inner = _wave(gram)[2] / 2.0
        angles += [
            np.where((shifted > low) & (shifted < high), shifted, low) for shifted in (inner, inner - math.pi, inner + math.pi)
        ]
    candidates = np.stack(angles)
    u = np.stack([np.sin(candidates), np.cos(candidates)], axis=-1)
    squares = np.einsum("kni,nij,knj->kn", u, gram, u)
    best = np.argmax(squares, axis=0)[None]
    shock = np.sqrt(np.maximum(np.take_along_axis(squares, best, axis=0)[0], 0.0))
    return shock, np.take_along_axis(candidates, best, axis=0)[0]


def _limits(
    sweep: _Sweep,
    values: Array,
    Q: Array,
    gram: Array,
    strikes: tuple[float, float],
    bound: float,
    ends: tuple[End, End],
    fine: float,
) -> StrikeLimits:
    """The intervals of the joint that keep the bound at some strikes."""

    def excess(value: float) -> float:
        k = int(np.argmin(np.abs(values - value)))
        return sweep.greatest(value, Q[k], strikes) - bound

    x, g = values.tolist(), (_shocks(gram, strikes) - bound).tolist()
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


def _joints(robot: Robot, pattern: str) -> tuple[Joint, ...]:
    """The joints that are moved.

    Raises:
        StudyError: one follows another, or has no single value, or some turn and others slide.
    """
    joints = tuple(robot.joint(name) for name in robot.match_joints(pattern))
    leaders = {mimic.joint: mimic.led for mimic in robot.mimics}
    for joint in joints:
        if joint.name in leaders:
            raise StudyError(f'joint "{joint.name}" follows {leaders[joint.name]}; ask for the limits of that')
        if joint.axis is None:
            raise StudyError(
                f'joint "{joint.name}" has several degrees of freedom, so it has no limits of one number; name another'
            )
    if len({joint.unit for joint in joints}) > 1:
        listed = ", ".join(f'"{joint.name}"' for joint in joints)
        raise StudyError(f"joints {listed} turn and slide, so they cannot have the same value; name joints of one kind")
    return joints


def _range(pattern: str, file: tuple[float, float], given: tuple[float, float] | None, unit: str) -> tuple[float, float]:
    """The range of the scan.

    Raises:
        StudyError: it is empty, or the file gives a prismatic joint no limits.
    """
    turn = math.pi
    # Files write "no limit" in many ways; a whole turn holds every posture of a joint that turns.
    whole = (max(file[0], -turn), min(file[1], turn)) if unit == "rad" else file
    low, high = given or whole
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        what = f"from {_value(low, unit)} to {_value(high, unit)}" if math.isfinite(low + high) else "without limits in the file"
        raise StudyError(f'the range of joint "{pattern}" is {what}; give its least and greatest value with --range LOW:HIGH')
    return low, high


def _strike_range(plane: Plane, given: tuple[float, float] | None) -> tuple[float, float]:
    """The range of strike angles [rad].

    Raises:
        StudyError: it is empty, or holds strikes that do not approach the ground.
    """
    if abs(plane.normal[2]) > 1.0 - 1e-9:
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
    text = f"{round(math.degrees(value), 2) + 0.0:g}°" if unit == "rad" else f"{1e3 * value:.4g} mm"
    return text.replace("-", "−")


def _span(low: float, high: float, unit: str) -> str:
    """A range with its unit as messages show it."""
    return f"{_value(low, unit)}…{_value(high, unit)}"
