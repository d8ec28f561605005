"""A rigid convex body that falls over in a plane, until it rests.

It pivots about a corner, slides on it or is in the air.

Coordinates are forward and up [m], relative to the centre of mass where a corner is meant; a
rotation tips forward [rad]. On a corner that sticks, with the arm c from it to the centre of mass
at an angle φ from the vertical and κ = m c² / (I + m c²),

    ω² = ω₀² + 2 κ g / c (cos φ₀ − cos φ)    (energy),      ω' = κ g / c sin φ,
    N / m = g − ω' c sin φ − ω² c cos φ,      T / m = ω' c cos φ − ω² c sin φ,

which from rest at φ = 0 is N / (m g) = 1 − κ (1 + 2 cos φ − 3 cos² φ). Where the ground would have
to pull (N < 0) the corner leaves it; where |T| > µ N it slides, which is integrated. Each corner
that meets the ground strikes it: an impulse of contacts that may stick, slide or open, without
restitution. The surface is the convex hull, since flat ground touches nothing else; rolling over it
from corner to corner, a sticking body keeps (I + m c·c′) / (I + m c′²) of its rotation at each
change.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.spatial import ConvexHull, QhullError

from shockpc.core.coulomb import solve_friction
from shockpc.core.spatial import Array
from shockpc.landing.scenes.strike import GRAVITY
from shockpc.text.errors import StudyError

Kind = Literal["pivots", "slides", "is in the air"]
"""Kind of motion of the body between two strikes."""

STEP = math.radians(0.5)
"""Rotation within which a sign change of the forces is found [rad]."""

STICKS = 1e3
"""Coefficient of friction that stands for contacts that stick, which may open all the same [1]."""

REST = 1e-9
"""Share of the speeds before a strike below which a speed after it is zero."""

SETTLES = math.radians(5.0)
"""Rotation up to which a body that comes to rest on another side still stands [rad]."""

SETTLED = 1e-4
"""Kinetic energy of a rocking body below which it rests [1].

It is a share of its weight times the height of its centre of mass.
"""

MOST_CHANGES, MOST_TURNS, LONGEST = 5000, 40, 10.0
"""Changes of the motion that are followed; how often it may reverse; how long a slide may take [s].
"""


class SectionMotion(NamedTuple):
    """Rotation [rad], place of the centre of mass forward and up [m], and their rates."""

    theta: float
    x: float
    z: float
    vx: float
    vz: float
    omega: float


class Phase(NamedTuple):
    """A part of the fall between two changes.

    Attributes:
        kind: how the body moves.
        corner: on which, counted on from turn to turn; −1 in the air.
        start, end: motion at both ends.
    """

    kind: Kind
    corner: int
    start: SectionMotion
    end: SectionMotion


class Touch(NamedTuple):
    """A corner meets the ground.

    Attributes:
        corner: that strikes, counted on from turn to turn.
        on: the corner that is on the ground already; −1 after a flight.
        before, after: motion.
        speed: of the corner towards the ground [m/s].
    """

    corner: int
    on: int
    before: SectionMotion
    after: SectionMotion
    speed: float


class Fall(NamedTuple):
    """A fall until it rests.

    Attributes:
        phases: in their order.
        touches: in their order; each ends a phase.
        rests: whether the body lies at the end, still or sliding; otherwise it was still rocking
            when it was no longer followed.
    """

    phases: tuple[Phase, ...]
    touches: tuple[Touch, ...]
    rests: bool


@dataclass(frozen=True, eq=False)
class CrossSection:
    """A rigid body in the plane of its fall.

    Attributes:
        mass: [kg]
        inertia: about the centre of mass [kg m²].
        corners: (n, 2) of its convex hull at rotation zero, in the order in which they meet the
            ground as it tips forward.
        level: (n,) rotation at which the side from each corner to the next one is on the ground,
            increasing within a turn [rad].
    """

    mass: float
    inertia: float
    corners: Array
    level: Array

    @classmethod
    def of(cls, mass: float, inertia: float, points: Array) -> "CrossSection":
        """The section of a body with points (k, 2) on its surface.

        The points are forward and up from the centre of mass [m].

        Raises:
            StudyError: the points are on a line.
        """
        try:
            corners = points[ConvexHull(points).vertices]  # anticlockwise
        except QhullError:
            raise StudyError(
                "the geometry is a point or a line in the plane of the fall, over which nothing "
                "can tip"
            ) from None
        sides = np.roll(corners, -1, axis=0) - corners
        level = np.arctan2(sides[:, 1], sides[:, 0])
        first = int(np.argmin(level))
        return cls(mass, inertia, np.roll(corners, -first, axis=0), np.roll(level, -first))

    def side(self, corner: int) -> float:
        """Rotation at which the side from a corner to the next one is on the ground [rad].

        Corners are counted on from turn to turn.
        """
        turn, k = divmod(corner, len(self.level))
        return float(self.level[k]) + 2.0 * math.pi * turn

    def lowest(self, theta: float) -> int:
        """The lowest corner at a rotation [rad]; of two on the ground the forward one.

        Corners are counted on from turn to turn.
        """
        turn = int((theta - float(self.level[0])) // (2.0 * math.pi))
        within = np.searchsorted(self.level, theta - 2.0 * math.pi * turn, side="right")
        return int(within) + turn * len(self.level)

    def at(self, corner: int, theta: float) -> tuple[float, float]:
        """A corner from the centre of mass, forward and up [m]."""
        a, b = self.corners[corner % len(self.corners)]
        c = math.cos(theta)
        s = math.sin(theta)
        return float(a * c + b * s), float(b * c - a * s)

    def arm(self, corner: int) -> tuple[float, float, float]:
        """The arm of a corner: distance to the centre of mass c [m], angle φ [rad] and κ [1].

        φ is from the vertical at rotation zero.
        """
        a, b = self.corners[corner % len(self.corners)].tolist()
        c = math.hypot(a, b)
        return c, math.atan2(-a, -b), self.mass * c * c / (self.inertia + self.mass * c * c)

    def energy(self, motion: SectionMotion) -> float:
        """Kinetic and potential energy [J]."""
        speed = motion.vx**2 + motion.vz**2
        kinetic = 0.5 * (self.mass * speed + self.inertia * motion.omega**2)
        return kinetic + self.mass * GRAVITY * motion.z

    def pivoting(self, corner: int, theta: float, omega: float, x: float = 0.0) -> SectionMotion:
        """The motion about a corner at rest at a place [m]."""
        a, b = self.at(corner, theta)
        return SectionMotion(theta, x - a, -b, -omega * b, omega * a, omega)

    def forces(
        self, corner: int, theta: Array | float, squared: Array | float
    ) -> tuple[Array, Array]:
        """Forces T and N of the ground on a corner that sticks, by mass [m/s²].

        They are along the ground and upward. Args: squared, ω².
        """
        c, angle, kappa = self.arm(corner)
        sine, cosine = np.sin(theta + angle), np.cos(theta + angle)
        turning = kappa * GRAVITY * sine
        return (
            turning * cosine - squared * c * sine,
            GRAVITY - turning * sine - squared * c * cosine,
        )

    def squared_rate(self, corner: int, theta: Array | float, start: SectionMotion) -> Array:
        """ω² of a body that pivots about a corner from a motion [rad²/s²]."""
        c, angle, kappa = self.arm(corner)
        gain = 2.0 * kappa * GRAVITY / c * (math.cos(start.theta + angle) - np.cos(theta + angle))
        return np.asarray(start.omega**2 + gain)

    def balance(self, corner: int) -> tuple[int, float]:
        """Corner and rotation in which the body balances, tipping on from a corner.

        It falls forward from there by itself.

        The rotation is that of the first contact with the corner where the centre of mass is in
        front of it then. The body stands on a side on which it comes to rest before it has tipped
        by `SETTLES`.
        """
        k = corner
        while self.side(k) <= SETTLES:
            k += 1
            if self.arm(k)[1] + self.side(k - 1) < 0.0:
                corner = k
        while self.arm(corner)[1] + self.side(corner) < 0.0:
            corner += 1
        return corner, max(-self.arm(corner)[1], self.side(corner - 1))

    def least_rate(self, corner: int, theta: float) -> float:
        """The rate on a corner at a rotation with which the body just reaches the balance [rad/s].

        It rolls there without slip.
        """
        last, top = self.balance(corner)
        squared = 0.0
        for k in range(last, corner - 1, -1):
            low = theta if k == corner else self.side(k - 1)
            at_rest = SectionMotion(low, 0.0, 0.0, 0.0, 0.0, 0.0)
            squared = max(squared - float(self.squared_rate(k, top, at_rest)), 0.0)
            if k > corner:
                squared /= self._kept(k - 1, k, low) ** 2
                top = low
        return math.sqrt(squared)

    def _kept(self, old: int, new: int, theta: float) -> float:
        """Share of the rate that is left as a sticking body rolls from a corner to another one.

        Both corners are on the ground.
        """
        (a, b), (c, d) = self.at(old, theta), self.at(new, theta)
        about_old = self.inertia + self.mass * (a * c + b * d)
        return about_old / (self.inertia + self.mass * (c * c + d * d))


def follow_fall(
    section: CrossSection,
    corner: int,
    start: SectionMotion,
    friction: float | None = None,
    hinged: float | None = None,
) -> Fall:
    """Follow a body that begins to fall about a corner until it rests.

    Args:
        section: the body.
        corner: on the ground.
        start: its motion, about that corner.
        friction: µ of the ground. Without one contacts stick as long as they press; what would be
            pulled then slides, which is the limit of a large friction.
        hinged: speed; corners on the ground are hinges then, which can pull, up to the first strike
            of this speed [m/s].

    Raises:
        StudyError: the laws of rigid contact with friction have no solution (Painlevé), or none was
            found for a strike.
    """
    mu = STICKS if friction is None else friction
    phases: list[Phase] = []
    touches: list[Touch] = []
    motion = start
    turns = 0
    on = corner
    for _ in range(MOST_CHANGES):
        if hinged is None:
            kind, end, touched = _phase(section, on, motion, mu)
        else:
            kind, end, touched = _pivot(section, on, motion, None)
        if kind == "is in the air":
            on = -1
        phases.append(Phase(kind, on, motion, end))
        motion = end
        if touched is None:
            turns += end.omega == 0.0
            if turns > MOST_TURNS:
                break
            continue
        hinge = -1 if hinged is not None else on
        after, left = _strike(section, hinge, touched, motion, mu)
        a, _ = section.at(touched, motion.theta)
        touch = Touch(touched, on, motion, after, motion.omega * a - motion.vz)
        touches.append(touch)
        if hinged is not None and touch.speed >= hinged:
            break
        if hinged is None and (len(left) > 1 or on >= 0):
            rests, left = _on_side(section, touch, left, mu)
            if rests:
                return Fall(tuple(phases), tuple(touches), True)
        on = left[0] if left else -1
        motion = after
    return Fall(tuple(phases), tuple(touches), False)


def _on_side(
    section: CrossSection, touch: Touch, left: list[int], mu: float
) -> tuple[bool, list[int]]:
    """True if a body stays on a side after a touch, and the corners on the ground.

    On the side it rests or slides.

    It stays if its pressure is between the corners; else it goes on about the nearer one.

    Args:
        section: the body.
        touch: of the side.
        left: corners that stay on the ground.
        mu: friction.
    """
    before, after = touch.before, touch.after
    feet = {k: section.at(k, after.theta)[0] for k in {*left, touch.corner, touch.on} - {-1}}
    slip = after.vx + after.omega * section.at(touch.corner, after.theta)[1]
    # A body that slides is pressed µ z ahead of its centre of mass.
    pressure = 0.0
    if abs(slip) > 1e-6 * abs(before.vx) + 1e-9:
        pressure = mu * after.z * math.copysign(1.0, slip)
    inside = min(feet.values()) < pressure < max(feet.values())
    if len(left) > 1:
        nearest = min(feet, key=lambda k: abs(feet[k] - pressure))
        return inside, [nearest]

    # By how much its kinetic energy lifts it, (I / m + c²) ω² / 2g; by how much a corner can.
    heights = []
    room = [SETTLED * after.z]
    for k in feet:
        c = section.arm(k)[0]
        heights.append((section.inertia / section.mass + c**2) * after.omega**2 / (2.0 * GRAVITY))
        room.append(c - after.z)
    return inside and max(heights) < min(room), left


def _phase(
    section: CrossSection, on: int, start: SectionMotion, friction: float
) -> tuple[Kind, SectionMotion, int | None]:
    """The next part of the fall: its kind, the motion at its end, and the corner that strikes.

    The corner is None if none strikes then.
    """
    if on < 0:
        return _flight(section, start)
    _, b = section.at(on, start.theta)
    slip = start.vx + start.omega * b
    speed = abs(start.vx) + abs(start.omega * b)
    along, up = section.forces(on, start.theta, start.omega**2)
    sticks = abs(slip) <= 10.0 * REST * speed + 1e-12
    if sticks and abs(along) < friction * up - REST * GRAVITY:
        return _pivot(section, on, start, friction)
    if GRAVITY + start.omega**2 * b <= REST * GRAVITY:  # rises if it is free
        return _flight(section, start)
    sense = -math.copysign(1.0, along) if sticks else math.copysign(1.0, slip)
    return _slide(section, on, start, friction, sense)


def _pivot(
    section: CrossSection, on: int, start: SectionMotion, friction: float | None
) -> tuple[Kind, SectionMotion, int | None]:
    """The part of a fall about a corner that sticks.

    It ends at the next corner, where the body turns back, or where the corner slips or is pulled.
    """
    phi = math.remainder(section.arm(on)[1] + start.theta, 2.0 * math.pi)
    sense = math.copysign(1.0, start.omega or phi)
    # Without a change it turns to the next side, on which the next corner strikes.
    struck: int | None = on + 1 if sense > 0.0 else on - 1
    end = section.side(on) if sense > 0.0 else section.side(on - 1)

    def squared(theta: float) -> float:
        return float(section.squared_rate(on, theta, start))

    # It turns back where ω² would be negative, at most where it is highest.
    highest = start.theta - phi
    uphill = highest if sense * (end - highest) > 0.0 > sense * phi else end
    if start.omega and squared(uphill) < 0.0:
        end = float(brentq(squared, start.theta, uphill, xtol=1e-13))
        struck = None
    turned = struck is None

    def margin(theta: Array | float) -> Array:
        # µ N − |T|, by mass; it is negative where the corner slips or is pulled.
        rate_squared = np.maximum(section.squared_rate(on, theta, start), 0.0)
        along, up = section.forces(on, theta, rate_squared)
        return np.ones_like(up) if friction is None else friction * up - np.abs(along)

    theta = np.linspace(start.theta, end, 2 + int(abs(end - start.theta) / STEP))
    below = np.flatnonzero(margin(theta[1:]) < 0.0)
    if below.size:
        k = int(below[0])
        end = float(theta[k])
        # It slips after sample k, or at the start already.
        if margin(theta[k]) > 0.0:
            end = float(brentq(margin, theta[k], theta[k + 1], xtol=1e-13))
        struck = None
        turned = False
    rate = 0.0 if turned else sense * math.sqrt(max(squared(end), 0.0))
    a, _ = section.at(on, start.theta)
    return "pivots", section.pivoting(on, end, rate, start.x + a), struck


def _slide(
    section: CrossSection, on: int, start: SectionMotion, friction: float, sense: float
) -> tuple[Kind, SectionMotion, int | None]:
    """The part of a fall on a corner that slides forward (sense 1) or back (−1).

    It ends where the corner sticks or is pulled, or another corner strikes.
    """
    ratio = section.mass / section.inertia

    def normal(y: Array) -> float:
        # N / m = (g + ω² b) / (1 + m a (a + µ s b) / I)
        a, b = section.at(on, y[0])
        share = 1.0 + ratio * a * (a + friction * sense * b)
        sinking = GRAVITY + y[1] ** 2 * b
        if share <= 0.0 < sinking:
            raise StudyError(
                f"at {math.degrees(y[0]):.3g} deg a sliding contact with a friction of "
                f"{friction:g} jams (Painlevé): rigid bodies "
                "have no motion there; give a smaller --friction, or none, so that contacts stick"
            )
        return float(sinking / share)

    def rates(_: float, y: Array) -> list[float]:
        # y = (θ, ω, x, v_x);  ω' = −m n (a + µ s b) / I,  v_x' = −µ s n
        a, b = section.at(on, y[0])
        n = normal(y)
        return [y[1], -ratio * n * (a + friction * sense * b), y[3], -friction * sense * n]

    # What is zero at the start counts as above it, so that its next zero is found.
    above = 1e-12
    # In this order: the next corner strikes, the last one strikes, it sticks, it is pulled.
    ends: list[Callable[[float, Array], float]] = [
        lambda _, y: section.side(on) - y[0] + above,
        lambda _, y: y[0] - section.side(on - 1) + above,
        lambda _, y: sense * (y[3] + y[1] * section.at(on, y[0])[1]) + above,
        lambda _, y: GRAVITY + y[1] ** 2 * section.at(on, y[0])[1],
    ]
    for end in ends:
        vars(end).update(terminal=True, direction=-1.0)
    y = [start.theta, start.omega, start.x, start.vx]
    solution = solve_ivp(rates, (0.0, LONGEST), y, "DOP853", events=ends, rtol=1e-10, atol=1e-12)
    if solution.status != 1:
        raise StudyError(
            f"a contact slides for more than {LONGEST:g} s, which is not followed; give a larger "
            f"--friction"
        )
    theta, omega, x, vx = solution.y[:, -1].tolist()
    event = next(k for k, times in enumerate(solution.t_events) if len(times))
    # At a strike the angle is that of the side, and where the corner sticks v_x = −ω b: both
    # without the error of the integration.
    theta = (section.side(on), section.side(on - 1), theta, theta)[event]
    a, b = section.at(on, theta)
    if event == 2:
        vx = -omega * b
    motion = SectionMotion(theta, x, -b, vx, omega * a, omega)
    return "slides", motion, (on + 1, on - 1, None, None)[event]


def _flight(section: CrossSection, start: SectionMotion) -> tuple[Kind, SectionMotion, int | None]:
    """The part of a fall in the air, until a corner strikes."""

    def at(t: float) -> SectionMotion:
        return SectionMotion(
            theta=start.theta + start.omega * t,
            x=start.x + start.vx * t,
            z=start.z + start.vz * t - 0.5 * GRAVITY * t * t,
            vx=start.vx,
            vz=start.vz - GRAVITY * t,
            omega=start.omega,
        )

    def gap(t: float) -> float:
        motion = at(t)
        return motion.z + section.at(section.lowest(motion.theta), motion.theta)[1]

    step = min(STEP / max(abs(start.omega), 1e-9), 2e-3)
    t = step
    while gap(t) > 0.0:
        t += step
    # What leaves the ground is above it by less than rounding at first.
    for before in (t - step, t - 0.5 * step, t - 0.1 * step):
        if before > 0.0 and gap(before) > 0.0:
            t = float(brentq(gap, before, t, xtol=1e-13))
            break
    end = at(t)
    return "is in the air", end, section.lowest(end.theta)


def _strike(
    section: CrossSection, on: int, touched: int, before: SectionMotion, mu: float
) -> tuple[SectionMotion, list[int]]:
    """The motion after the impulse of a strike, and the corners that stay on the ground.

    The struck corner comes first.

    Raises:
        StudyError: none was found that obeys the laws of friction.
    """
    corners = [touched]
    if on >= 0:
        corners.append(on)
    elif before.omega:
        # A side that is level strikes with both of its corners.
        sides = {touched + 1: section.side(touched), touched - 1: section.side(touched - 1)}
        corners += [k for k, side in sides.items() if abs(side - before.theta) < REST]
    J = np.array([row for k in corners for row in _rows(*section.at(k, before.theta))])
    weight = 1.0 / np.array([section.mass, section.mass, section.inertia])
    speeds = J @ [before.vx, before.vz, before.omega]
    scale = float(np.abs(speeds).max())
    # The struck corner alone, which sticks: J₁ M⁻¹ J₁ᵀ p = −J₁ v
    push = np.linalg.solve(J[:2] * weight @ J[:2].T, -speeds[:2])
    change = weight * (J[:2].T @ push)
    in_cone = push[1] > 0.0 and abs(push[0]) <= mu * push[1]
    if not (in_cone and (speeds + J @ change)[3::2].min(initial=0.0) >= -REST * scale):
        change = _friction_change(J, weight, speeds, mu)
    after = speeds + J @ change
    vx, vz, omega = change + np.array([before.vx, before.vz, before.omega])
    # Corners that leave the ground do not carry the next part of the fall.
    left = [k for k, up in zip(corners, after[1::2], strict=True) if up <= 10.0 * REST * scale]
    return before._replace(vx=float(vx), vz=float(vz), omega=float(omega)), left


def _friction_change(J: Array, weight: Array, speeds: Array, mu: float) -> Array:
    """The change (3,) of vx, vz and ω by the impulses of corners with friction that may open.

    Args:
        J: (2k, 3) rows of the corners.
        weight: (3,) inverse inertias.
        speeds: (2k,) of the corners before [m/s].
        mu: friction.

    Raises:
        StudyError: no impulses were found that obey the laws of friction.
    """
    # There is no motion across the plane.
    at = np.arange(1, len(J), 2)
    across = np.insert(J, at, 0.0, axis=0)
    approach = np.insert(speeds, at, 0.0).reshape(-1, 3)
    k = len(approach)
    solution = solve_friction(across * weight @ across.T, approach, np.full(k, mu), np.zeros(k))
    if not solution:
        raise StudyError(
            "no impulse was found that obeys the laws of friction at a strike of the fall; "
            "take another --friction"
        )
    return np.asarray(weight * (across.T @ solution[0].impulse.ravel()))


def _rows(a: float, b: float) -> Sequence[tuple[float, float, float]]:
    """Velocity of a corner forward and up, by vx, vz and ω."""
    return (1.0, 0.0, b), (0.0, 1.0, -a)
