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
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from shockpc.core.coulomb import solve_friction
from shockpc.core.spatial import Array
from shockpc.landing.scenes.strike import GRAVITY
from shockpc.text.errors import StudyError
from shockpc.wings.fall.cross_section import CrossSection, SectionMotion

Kind = Literal["pivots", "slides", "is in the air"]
"""Kind of motion of the body between two strikes."""

STEP = math.radians(0.5)
"""Rotation within which a sign change of the forces is found [rad]."""

STICKS = 1e3
"""Coefficient of friction that stands for contacts that stick, which may open all the same [1]."""

REST = 1e-9
"""Share of the speeds before a strike below which a speed after it is zero."""

SETTLED = 1e-4
"""Kinetic energy of a rocking body below which it rests [1].

It is a share of its weight times the height of its centre of mass.
"""

MOST_CHANGES, MOST_TURNS, LONGEST = 5000, 40, 10.0
"""Changes of the motion that are followed; how often it may reverse; how long a slide may take [s].
"""


class Phase(NamedTuple):
    """A part of the fall between two changes.

    Attributes:
        kind: how the body moves.
        corner: on which, counted on from turn to turn; −1 in the air.
        start, end: motion at both ends.
        striking: the corner that meets the ground at the end; None if none does.
    """

    kind: Kind
    corner: int
    start: SectionMotion
    end: SectionMotion
    striking: int | None


class CornerImpact(NamedTuple):
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
        impacts: in their order; each ends a phase.
        rests: whether the body lies at the end, still or sliding; otherwise it was still rocking
            when it was no longer followed.
    """

    phases: tuple[Phase, ...]
    impacts: tuple[CornerImpact, ...]
    rests: bool


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
    impacts: list[CornerImpact] = []
    motion = start
    turns = 0
    on = corner
    for _ in range(MOST_CHANGES):
        if hinged is None:
            phase = _phase(section, on, motion, mu)
        else:
            phase = _pivot(section, on, motion, None)
        phases.append(phase)
        motion = phase.end
        on = phase.corner
        if phase.striking is None:
            turns += motion.omega == 0.0
            if turns > MOST_TURNS:
                break
            continue
        after, on_ground = _strike(section, on, phase.striking, motion, mu)
        a, _ = section.at(phase.striking, motion.theta)
        impact = CornerImpact(phase.striking, on, motion, after, motion.omega * a - motion.vz)
        impacts.append(impact)
        if hinged is not None and impact.speed >= hinged:
            break
        if hinged is None and (len(on_ground) > 1 or on >= 0):
            rests, on_ground = _on_side(section, impact, on_ground, mu)
            if rests:
                return Fall(tuple(phases), tuple(impacts), True)
        on = on_ground[0] if on_ground else -1
        motion = after
    return Fall(tuple(phases), tuple(impacts), False)


def _on_side(
    section: CrossSection, impact: CornerImpact, on_ground: list[int], mu: float
) -> tuple[bool, list[int]]:
    """True if a body stays on a side after its impact, and the corners on the ground.

    On the side it rests or slides. It stays if its pressure is between the corners; else it goes on
    about the nearer one.

    Args:
        section: the body.
        impact: of the side.
        on_ground: corners that stay on the ground.
        mu: friction.
    """
    before = impact.before
    after = impact.after
    corners = {*on_ground, impact.corner, impact.on} - {-1}
    places = {k: section.at(k, after.theta)[0] for k in corners}
    slip = after.vx + after.omega * section.at(impact.corner, after.theta)[1]
    # A body that slides is pressed µ z ahead of its centre of mass.
    pressure = 0.0
    if abs(slip) > 1e-6 * abs(before.vx) + 1e-9:
        pressure = mu * after.z * math.copysign(1.0, slip)
    inside = min(places.values()) < pressure < max(places.values())
    if len(on_ground) > 1:
        nearest = min(places, key=lambda k: abs(places[k] - pressure))
        return inside, [nearest]

    # Its kinetic energy lifts the centre of mass by (I / m + c²) ω² / 2g about a corner. To tip
    # over the corner this takes c − z; a body that is lifted by less than SETTLED rests as well.
    squared_gyration = section.inertia / section.mass
    lifts = []
    needed = [SETTLED * after.z]
    for k in places:
        c = section.arm(k)[0]
        lifts.append((squared_gyration + c**2) * after.omega**2 / (2.0 * GRAVITY))
        needed.append(c - after.z)
    return inside and max(lifts) < min(needed), on_ground


def _phase(section: CrossSection, on: int, start: SectionMotion, friction: float) -> Phase:
    """The next part of the fall."""
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
    return _slide(SlidingCorner(section, on, friction, sense), start)


def _pivot(section: CrossSection, on: int, start: SectionMotion, friction: float | None) -> Phase:
    """The part of a fall about a corner that sticks; a hinge without a friction.

    It ends at the next corner, where the body turns back, or where the corner slips or is pulled.
    """
    phi = math.remainder(section.arm(on)[1] + start.theta, 2.0 * math.pi)
    sense = math.copysign(1.0, start.omega or phi)
    # Without a change it turns to the next side, on which the next corner strikes.
    following = on + 1 if sense > 0.0 else on - 1
    striking: int | None = following
    end = section.side(min(on, following))

    def squared(theta: float) -> float:
        return float(section.squared_rate(on, theta, start))

    # It turns back where ω² would be negative. ω² is smallest where the arm is vertical, if that is
    # on the way, else at the end.
    vertical = start.theta - phi
    on_the_way = sense * phi < 0.0 and sense * (end - vertical) > 0.0
    slowest = vertical if on_the_way else end
    turns_back = bool(start.omega) and squared(slowest) < 0.0
    if turns_back:
        end = float(brentq(squared, start.theta, slowest, xtol=1e-13))
        striking = None
    slips_at = None if friction is None else _first_slip(section, on, start, end, friction)
    if slips_at is not None:
        end = slips_at
        striking = None
        turns_back = False
    rate = 0.0 if turns_back else sense * math.sqrt(max(squared(end), 0.0))
    a, _ = section.at(on, start.theta)
    return Phase("pivots", on, start, section.pivoting(on, end, rate, start.x + a), striking)


def _first_slip(
    section: CrossSection, on: int, start: SectionMotion, end: float, friction: float
) -> float | None:
    """The first rotation up to an end at which a pivot slips or would be pulled; None without one.

    It is where µ N − |T| becomes negative.
    """

    def margin(theta: Array | float) -> Array:
        # µ N − |T|, by mass
        rate_squared = np.maximum(section.squared_rate(on, theta, start), 0.0)
        along, up = section.forces(on, theta, rate_squared)
        return np.asarray(friction * up - np.abs(along))

    theta = np.linspace(start.theta, end, 2 + int(abs(end - start.theta) / STEP))
    below = np.flatnonzero(margin(theta[1:]) < 0.0)
    if not below.size:
        return None
    k = int(below[0])
    # It slips after sample k, or at the start already.
    if margin(theta[k]) > 0.0:
        return float(brentq(margin, theta[k], theta[k + 1], xtol=1e-13))
    return float(theta[k])


@dataclass(frozen=True, eq=False)
class SlidingCorner:
    """The motion of a body on a corner that slides, y = (θ, ω, x, v_x).

    With the corner at (a, b) from the centre of mass and s the sense,
    n = N / m = (g + ω² b) / (1 + m a (a + µ s b) / I),  ω' = −m n (a + µ s b) / I,  v_x' = −µ s n.

    Attributes:
        section: the body.
        corner: that slides.
        friction: µ.
        sense: s, 1 forward or −1 back.
    """

    section: CrossSection
    corner: int
    friction: float
    sense: float

    def rates(self, _: float, y: Array) -> list[float]:
        """The rates of y.

        Raises:
            StudyError: no force of the ground is possible (Painlevé).
        """
        a, b = self.section.at(self.corner, y[0])
        ratio = self.section.mass / self.section.inertia
        lever = a + self.friction * self.sense * b
        share = 1.0 + ratio * a * lever
        sinking = GRAVITY + y[1] ** 2 * b
        if share <= 0.0 < sinking:
            raise StudyError(
                f"at {math.degrees(y[0]):.3g} deg a sliding contact with a friction of "
                f"{self.friction:g} jams (Painlevé): rigid bodies "
                "have no motion there; give a smaller --friction, or none, so that contacts stick"
            )
        n = float(sinking / share)
        return [y[1], -ratio * n * lever, y[3], -self.friction * self.sense * n]

    def ends(self) -> list[Callable[[float, Array], float]]:
        """Functions of t and y that become negative where the slide ends.

        In this order: the next corner strikes, the last one strikes, it sticks, it is pulled.
        """
        section = self.section
        # What is zero at the start counts as above it, so that its next zero is found.
        above = 1e-12

        def slip(y: Array) -> float:
            return float(y[3] + y[1] * section.at(self.corner, y[0])[1])

        ends: list[Callable[[float, Array], float]] = [
            lambda _, y: section.side(self.corner) - y[0] + above,
            lambda _, y: y[0] - section.side(self.corner - 1) + above,
            lambda _, y: self.sense * slip(y) + above,
            lambda _, y: GRAVITY + y[1] ** 2 * section.at(self.corner, y[0])[1],
        ]
        for end in ends:
            vars(end).update(terminal=True, direction=-1.0)
        return ends


def _slide(sliding: SlidingCorner, start: SectionMotion) -> Phase:
    """The part of a fall on a corner that slides.

    It ends where the corner sticks or is pulled, or another corner strikes.
    """
    section = sliding.section
    on = sliding.corner
    solution = solve_ivp(
        sliding.rates,
        (0.0, LONGEST),
        [start.theta, start.omega, start.x, start.vx],
        "DOP853",
        events=sliding.ends(),
        rtol=1e-10,
        atol=1e-12,
    )
    if solution.status != 1:
        raise StudyError(
            f"a contact slides for more than {LONGEST:g} s, which is not followed; give a larger "
            f"--friction"
        )
    theta, omega, x, vx = solution.y[:, -1].tolist()
    event = next(k for k, times in enumerate(solution.t_events) if len(times))
    striking = (on + 1, on - 1, None, None)[event]
    # At a strike the angle is that of the side, and where the corner sticks v_x = −ω b: both
    # without the error of the integration.
    if striking is not None:
        theta = section.side(min(on, striking))
    a, b = section.at(on, theta)
    if event == 2:
        vx = -omega * b
    end = SectionMotion(theta, x, -b, vx, omega * a, omega)
    return Phase("slides", on, start, end, striking)


def _flight(section: CrossSection, start: SectionMotion) -> Phase:
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
    return Phase("is in the air", -1, start, end, section.lowest(end.theta))


def _strike(
    section: CrossSection, on: int, striking: int, before: SectionMotion, mu: float
) -> tuple[SectionMotion, list[int]]:
    """The motion after the impulse of a strike, and the corners that stay on the ground.

    The striking corner comes first.

    Raises:
        StudyError: none was found that obeys the laws of friction.
    """
    corners = [striking]
    if on >= 0:
        corners.append(on)
    elif before.omega:
        # A side that is level strikes with both of its corners.
        sides = {striking + 1: section.side(striking), striking - 1: section.side(striking - 1)}
        corners += [k for k, side in sides.items() if abs(side - before.theta) < REST]
    J = np.concatenate([_rows(*section.at(k, before.theta)) for k in corners])
    weight = 1.0 / np.array([section.mass, section.mass, section.inertia])
    velocity = np.array([before.vx, before.vz, before.omega])
    speeds = J @ velocity
    scale = float(np.abs(speeds).max())
    change = _sticking_change(J, weight, speeds, mu)
    # The other corners must not sink.
    if change is None or (speeds + J @ change)[3::2].min(initial=0.0) < -REST * scale:
        change = _friction_change(J, weight, speeds, mu)
    after = speeds + J @ change
    vx, vz, omega = (change + velocity).tolist()
    # Corners that leave the ground do not carry the next part of the fall.
    on_ground = [k for k, up in zip(corners, after[1::2], strict=True) if up <= 10.0 * REST * scale]
    return before._replace(vx=vx, vz=vz, omega=omega), on_ground


def _sticking_change(J: Array, weight: Array, speeds: Array, mu: float) -> Array | None:
    """The change (3,) of vx, vz and ω by a first corner that sticks; None if it would slide.

    The arguments are those of `_friction_change`.
    """
    # J₁ M⁻¹ J₁ᵀ p = −J₁ v
    p = np.linalg.solve(J[:2] * weight @ J[:2].T, -speeds[:2])
    if p[1] > 0.0 and abs(p[0]) <= mu * p[1]:
        return np.asarray(weight * (J[:2].T @ p))
    return None


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
    between = np.arange(1, len(J), 2)
    across = np.insert(J, between, 0.0, axis=0)
    approach = np.insert(speeds, between, 0.0).reshape(-1, 3)
    k = len(approach)
    solution = solve_friction(across * weight @ across.T, approach, np.full(k, mu), np.zeros(k))
    if not solution:
        raise StudyError(
            "no impulse was found that obeys the laws of friction at a strike of the fall; "
            "take another --friction"
        )
    return np.asarray(weight * (across.T @ solution[0].impulse.ravel()))


def _rows(a: float, b: float) -> Array:
    """Velocity of a corner forward and up, by vx, vz and ω."""
    return np.array([[1.0, 0.0, b], [0.0, 1.0, -a]])
