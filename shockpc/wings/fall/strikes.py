"""The strikes of falls: a robot tips or is dropped, and each strike is a landing.

The robot tips over an edge of its support.

Of the points that meet the ground together, the landing has those that press.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from shockpc.core.coulomb import solve_friction
from shockpc.core.spatial import Array
from shockpc.impact.contact_rows import contact_rows
from shockpc.impact.friction import friction_of
from shockpc.landing.landing import PosedLanding
from shockpc.landing.resolve import landing_of
from shockpc.landing.scenes.scene import Scene
from shockpc.landing.scenes.strike import GRAVITY
from shockpc.text.errors import SceneError, SolveError, StudyError
from shockpc.text.printed import listed
from shockpc.wings.fall.body import UP, Rigid, Spot
from shockpc.wings.fall.tipping import (
    STICKS,
    CrossSection,
    Fall,
    Kind,
    Phase,
    SectionMotion,
    Touch,
    follow_fall,
)

SIDES = (("back", "", "front"), ("right", "", "left"), ("bottom", "", "top"))
"""Names of the sides of the box around the robot, along x, y and z."""

NUDGE = 1e-6
"""Rotation beyond the balance at which a robot begins to fall [rad]."""

LEVEL = math.radians(1.0)
"""Largest rotation [rad] that brings a side to the ground on which a robot already stands.

The corner at the end of this side is at most `together` above the ground.
"""

SINKS = 1e-6
"""Speed into the ground, as a share of the strike's, above which a point takes part in it [1]."""

NEAR_GROUND = 5e-3
"""Height up to which a part nearly strikes together with others [m]."""

ASIDE = 0.3
"""Share of the change of rotation at the first strike above which there is a warning [1].

The share is that of the rotation out of the plane of the fall.
"""

EARLY = math.radians(3.0)
"""Rotation by which the centre of pressure may leave the edge early without a warning [rad].

Early is before the edge would be pulled or slips.
"""


@dataclass(frozen=True, eq=False, kw_only=True)
class FallStrike:
    """A strike, and its landing.

    Attributes:
        fall: name of the fall: posture, then heading or attitude.
        number: of the strike in its fall, from 1.
        struck: links that meet the ground together, the fastest first, with the speed of each
            towards the ground [m/s].
        near: links less than `NEAR_GROUND` above the ground then.
        pressing: those of the struck links that press on it; the others separate.
        stands: links that are on the ground already, on the edge about which the robot turns, and
            press on it.
        motion: how the robot moved before.
        rotation: since the posture in which the fall began [rad].
        rate: angular velocity before [rad/s].
        energy: kinetic energy before [J].
        scene: of the landing.
        forward: (3,) level unit vector in which the robot tips; None of a drop.
        remark: what of the strike the landing does not describe, and why; empty if all.
    """

    fall: str
    number: int
    struck: Mapping[str, float]
    near: tuple[str, ...]
    pressing: tuple[str, ...]
    stands: tuple[str, ...]
    motion: Kind
    rotation: float
    rate: float
    energy: float
    scene: Scene = field(repr=False)
    forward: Array | None = None
    remark: str = ""

    @property
    def name(self) -> str:
        """Name of the landing."""
        return f"{self.fall} {self.number}" if self.forward is not None else self.fall

    @property
    def speed(self) -> float:
        """Speed of the fastest of the struck points towards the ground [m/s]."""
        return max(self.struck.values())


@dataclass(frozen=True, eq=False, kw_only=True)
class Tip:
    """A robot that tips over.

    Attributes:
        name: posture, then heading.
        forward: (3,) level unit vector across the edge over which it tips.
        balance: rotation at which it balances on the edge [rad]; zero or less if it does not stand
            by itself.
        least_push: smallest speed of the centre of mass that a level push has to give for the robot
            to tip [m/s].
        hinged: rate at the first strike of `least` or more, if the edge were a hinge [rad/s].
        fall: what it does until it rests.
        section: the robot in the plane of the fall.
        warnings: what limits the result.
    """

    name: str
    forward: Array
    balance: float
    least_push: float
    hinged: float
    fall: Fall
    section: CrossSection = field(repr=False)
    warnings: tuple[str, ...]


class Beginning(NamedTuple):
    """The beginning of a fall.

    Attributes:
        corner: about which the robot turns.
        motion: with which it does.
        balance: rotation at which it balances [rad].
        least_push: as of `Tip`.
    """

    corner: int
    motion: SectionMotion
    balance: float
    least_push: float


def tip_over(
    rigid: Rigid, name: str, heading: float, push: float | None, together: float, least: float
) -> Tip:
    """The fall of a robot that tips over along a heading.

    Args:
        rigid: the robot.
        name: posture, then heading.
        heading: from forward to the left [rad].
        push: speed that a level push gives to the centre of mass [m/s]; None at rest.
        together: height within which parts strike together [m].
        least: smallest speed of strikes that are listed [m/s].

    Raises:
        StudyError: it does not tip, or nothing of it strikes.
    """
    forward, ends = rigid.edge(heading, together)
    section = rigid.section(forward)
    begin = _beginning(section, push, together)
    sliding = follow_fall(section, begin.corner, begin.motion, rigid.landing.scene.friction)
    hinged = follow_fall(section, begin.corner, begin.motion, hinged=least)
    warnings = list(_turned_edge(forward, heading))
    warnings += _below(rigid, forward, section, _first_strike(sliding, least))
    warnings += _pressure(rigid, forward, ends, section, sliding, least)
    if not sliding.rests:
        warnings.append("it is still rocking when it is no longer followed")
    return Tip(
        name=name,
        forward=forward,
        balance=begin.balance,
        least_push=begin.least_push,
        hinged=hinged.touches[-1].before.omega,
        fall=sliding,
        section=section,
        warnings=tuple(warnings),
    )


def _beginning(section: CrossSection, push: float | None, together: float) -> Beginning:
    """The beginning of the fall of a robot that is pushed, or from its balance without a push.

    Raises:
        StudyError: the push does not tip it.
    """
    first, theta = _support(section, together)
    corner, balance = section.balance(first)
    height = -section.at(first, theta)[1]
    if balance <= theta:
        # It tips by itself.
        rate = 0.0 if push is None else push / height
        return Beginning(first, section.pivoting(first, theta, rate), balance, 0.0)
    least_rate = section.least_rate(first, theta)
    least_push = least_rate * height
    if push is None:
        # ω = √(κ g / c) φ at φ beyond the balance: it never was at rest there
        length, _, kappa = section.arm(corner)
        rate = math.sqrt(kappa * GRAVITY / length) * NUDGE
        motion = section.pivoting(corner, balance + NUDGE, rate)
        return Beginning(corner, motion, balance, least_push)
    if push <= least_push:
        raise StudyError(
            f"a push to {push:g} m/s does not tip the robot: it balances at "
            f"{math.degrees(balance):.3g} deg, which takes at least "
            f"{least_push:.3g} m/s"
        )
    return Beginning(first, section.pivoting(first, theta, push / height), balance, least_push)


def _turned_edge(forward: Array, heading: float) -> Iterator[str]:
    """A warning of an edge that is turned from the heading [rad]."""
    wanted = [math.cos(heading), math.sin(heading), 0.0]
    turned = math.degrees(math.acos(min(1.0, float(forward @ wanted))))
    if turned > 3.0:
        yield (
            f"the edge is turned by {turned:.2g} deg from the heading; the robot tips across the "
            "edge"
        )


def _first_strike(fall: Fall, least: float) -> Touch:
    """The first touch of at least a speed [m/s]; the first of all if none is so fast."""
    return next((touch for touch in fall.touches if touch.speed >= least), fall.touches[0])


def _tilt(forward: Array, angle: float) -> Array:
    """The rotation (3, 3) of a robot that tips by an angle [rad] along a level unit vector."""
    return np.asarray(Rotation.from_rotvec(angle * np.cross(UP, forward)).as_matrix())


def _below(rigid: Rigid, forward: Array, section: CrossSection, touch: Touch) -> Iterator[str]:
    """A warning of bodies without geometry whose centres of mass are below the ground at a strike.

    Raises:
        StudyError: they are most of the mass.
    """
    robot = rigid.landing.robot
    theta = touch.before.theta
    heights = (rigid.coms - rigid.com) @ _tilt(forward, theta)[2]
    under = np.flatnonzero(heights < section.at(touch.corner, theta)[1])
    if not len(under):
        return
    share = float(robot.masses[under].sum()) / rigid.mass
    names = listed((robot.bodies[i].name for i in under), 4)
    text = (
        f"{names} ({100.0 * share:.3g} % of the mass) would be below the ground at the strike at "
        f"{math.degrees(theta):.3g} deg, because they have no geometry there"
    )
    if share > 0.5:
        raise StudyError(f"{text}; give the robot's file collision or visual geometry")
    yield text


def _support(section: CrossSection, together: float) -> tuple[int, float]:
    """The forward corner of a robot's support, and the rotation at which it touches down [rad]."""
    lowest = section.lowest(0.0)
    ground = section.at(lowest, 0.0)[1]
    # A corner ahead belongs to the support if it is near the ground and the side to it is level.
    corner = lowest
    while section.side(corner) <= LEVEL and section.at(corner + 1, 0.0)[1] - ground <= together:
        corner += 1
    return corner, max(section.side(corner - 1), 0.0)


def _pressure(
    rigid: Rigid, forward: Array, ends: Array, section: CrossSection, fall: Fall, least: float
) -> Iterator[str]:
    """A warning where the centre of pressure leaves the edge before the first strike."""
    if np.ptp(ends) == 0.0:
        yield (
            "the support is a corner in this direction, not an edge: the robot may turn about it, "
            "and another part may strike"
        )
        return
    fast = [touch for touch in fall.touches if touch.speed >= least]
    strike = fast[0] if fast else fall.touches[-1]
    theta_strike = strike.before.theta
    pivoting: list[Phase] = []
    for phase in fall.phases:
        if phase.kind != "pivots" or phase.start.theta >= theta_strike:
            break
        pivoting.append(phase)
    theta = _leaves_edge(rigid, forward, ends, section, pivoting)
    if theta is not None and pivoting[-1].end.theta - theta > EARLY:
        yield (
            f"the centre of pressure leaves the edge at {math.degrees(theta):.3g} deg, before the "
            f"strike at {math.degrees(theta_strike):.3g} deg: the robot then turns about a corner, "
            "and another part may strike"
        )


def _leaves_edge(
    rigid: Rigid, forward: Array, ends: Array, section: CrossSection, pivoting: Sequence[Phase]
) -> float | None:
    """The first rotation [rad] at which the centre of pressure is off the edge; None without one.

    From the centre of mass it is at (I_xy ω' + I_zy ω²) / N along the edge, with x forward, y along
    the edge and z up, ω' = κ g sin(θ + φ) / c and the force N of the ground.
    """
    left = np.cross(UP, forward)
    for phase in pivoting:
        c, angle, kappa = section.arm(phase.corner)
        steps = 2 + int((phase.end.theta - phase.start.theta) / EARLY)
        for theta in np.linspace(phase.start.theta, phase.end.theta, steps).tolist():
            turn = _tilt(forward, theta)
            inertia_y = turn @ rigid.inertia @ turn.T @ left
            squared = section.squared_rate(phase.corner, theta, phase.start)
            acceleration = kappa * GRAVITY / c * math.sin(theta + angle)
            moment = forward @ inertia_y * acceleration + UP @ inertia_y * squared
            force = rigid.mass * max(float(section.forces(phase.corner, theta, squared)[1]), 1e-9)
            if not ends[0] <= float(moment) / force <= ends[1]:
                return float(theta)
    return None


def strikes_of(rigid: Rigid, tip: Tip, together: float, least: float) -> Iterator[FallStrike]:
    """The strikes of a fall that are fast enough, each with its landing.

    Args:
        rigid: the robot.
        tip: its fall.
        together: height within which parts strike together [m].
        least: smallest speed of strikes that are listed [m/s].
    """
    section = tip.section
    kinds = {phase.end: phase.kind for phase in tip.fall.phases}
    number = 0
    last = tip.fall.touches[0]
    for touch in tip.fall.touches:
        if touch.speed < least or (number and _struck_before(section, last, touch, together)):
            continue
        number += 1
        last = touch
        yield _strike(rigid, tip, touch, number, kinds[touch.before], together)


def _struck_before(section: CrossSection, last: Touch, touch: Touch, together: float) -> bool:
    """True if what touches was near the ground at the last strike, and did not stand there.

    Near is within the height `together`: it was part of that strike.
    """
    ahead, height = section.at(touch.corner, last.before.theta)
    ground = section.at(last.corner, last.before.theta)[1]
    return height - ground <= together and not _stood(section, last, ahead)


def _strike(
    rigid: Rigid, tip: Tip, touch: Touch, number: int, kind: Kind, together: float
) -> FallStrike:
    """The strike of a touch.

    Args:
        rigid: the robot.
        tip: its fall.
        touch: of the fall.
        number: of the strike.
        kind: how the robot moved before.
        together: height within which parts strike together [m].
    """
    section = tip.section
    theta = touch.before.theta
    omega = touch.before.omega
    turn = _tilt(tip.forward, theta)
    points, links = rigid.struck(turn, together)
    stood = np.array([_stood(section, touch, x) for x in (points @ tip.forward).tolist()])
    # A disc that lands flat is one point, as far from the edge on which it stood as from the
    # other.
    if stood.all():
        stood[:] = False
    struck = rigid.spots(turn, points[~stood], links[~stood])
    stands = rigid.spots(turn, points[stood], links[stood])

    down = _speeds_down(rigid, tip.forward @ turn, touch, struck)
    struck = tuple(spot for spot in struck if spot.link in down)
    struck = tuple(sorted(struck, key=lambda spot: -down[spot.link]))

    velocity = touch.before.vx * tip.forward + touch.before.vz * UP
    rotation_rate = omega * np.cross(UP, tip.forward)
    scene = rigid.scene(turn, velocity, rotation_rate, struck, stands, kind == "slides")
    # By default landings are looked at in the plane of the fall.
    if scene.plane == "auto":
        scene = replace(scene, plane=tuple(np.cross(tip.forward, UP).tolist()))
    # On finite stiffness only what strikes is a contact.
    if scene.yields:
        scene = replace(scene, contact=scene.contact[: len(struck)], stance=())
    strike = _landing(
        rigid,
        scene,
        fall=tip.name,
        number=number,
        struck=down,
        near=_near(rigid, turn, links, together),
        motion=kind,
        rotation=theta,
        rate=omega,
        forward=tip.forward,
        energy=section.energy(touch.before) - rigid.mass * GRAVITY * touch.before.z,
    )
    # Later strikes are computed as if the fall stayed in its plane, so that the first is checked.
    if number > 1:
        return strike
    aside = _turns_aside(rigid, turn, (*struck, *stands), velocity, omega, tip.forward)
    if aside <= ASIDE:
        return strike
    text = (
        f"{100.0 * aside:.0f} % of its change of rotation is out of the plane of the fall, in "
        "which later strikes are computed"
    )
    return replace(strike, remark="; ".join(filter(None, [strike.remark, text])))


def _speeds_down(
    rigid: Rigid, forward: Array, touch: Touch, spots: Sequence[Spot]
) -> dict[str, float]:
    """Speeds towards the ground [m/s] of links that go on into it, or of the fastest; by name.

    They are ω x − v_z at x forward of the centre of mass; the fastest is the first.

    Args:
        rigid: the robot.
        forward: (3,) level unit vector in the axes of the posture.
        touch: of the fall.
        spots: on the ground.
    """
    down: dict[str, float] = {}
    for spot in spots:
        x = float(forward @ (spot.point - rigid.com))
        down[spot.link] = touch.before.omega * x - touch.before.vz
    fastest = sorted(down, key=lambda link: -down[link])
    sinking = [link for link in fastest if down[link] > SINKS * touch.speed]
    return {link: down[link] for link in sinking or fastest[:1]}


def _near(rigid: Rigid, turn: Array, links: np.ndarray, together: float) -> tuple[str, ...]:
    """Names of links that nearly strike. Args: links, those that strike or stand."""
    near = set(rigid.struck(turn, max(NEAR_GROUND, together))[1].tolist())
    return tuple(sorted(near - set(links.tolist())))


def _turns_aside(
    rigid: Rigid, turn: Array, spots: Sequence[Spot], velocity: Array, omega: float, forward: Array
) -> float:
    """Share of the change of rotation at a strike that is not about the edge [1].

    The robot is rigid.
    """
    left = np.cross(UP, forward)
    axes = np.array([forward, left, UP])
    arms = (np.array([spot.point for spot in spots]) - rigid.com) @ turn.T
    # Rows of the velocity of each spot by (v, ω), J, and M⁻¹ Jᵀ.
    J = np.concatenate([np.hstack([axes, np.cross(arm, axes)]) for arm in arms])
    inertia = turn @ rigid.inertia @ turn.T
    response = np.vstack([J[:, :3].T / rigid.mass, np.linalg.solve(inertia, J[:, 3:].T)])
    speeds = (J @ np.concatenate([velocity, omega * left])).reshape(-1, 3)
    impulses, _ = _impulses(J @ response, speeds, rigid.landing.scene.friction)
    # Δω, and its part that is not about the edge.
    change = response[3:] @ impulses.ravel()
    across = change - (change @ left) * left
    return float(np.linalg.norm(across) / (np.linalg.norm(change) or 1.0))


def _stood(section: CrossSection, touch: Touch, x: float) -> bool:
    """True if what is on the ground x [m] ahead is nearer to the old corner than to the new one.

    The old corner is the one that was there before a touch.
    """
    new = section.at(touch.corner, touch.before.theta)[0]
    old = section.at(touch.on, touch.before.theta)[0]
    return touch.on >= 0 and abs(x - old) < abs(x - new)


def _landing(rigid: Rigid, scene: Scene, **strike: Any) -> FallStrike:
    """A strike with those contacts that press.

    Friction is left out where it has no solution. Args: scene, with all contacts; strike, all else
    that is known of it.
    """
    robot = rigid.landing.robot
    n = len(scene.contact)
    m = len(strike["struck"])
    kept, remark = [0], ""
    if n + len(scene.stance) > 1:
        kept, remark = _pressing(landing_of(scene, robot), m)
    # Of the contacts the first m strike, and the others slide; then come those that stand.
    pressing = [k for k in kept if k < m] or [0]
    sliding = [k for k in kept if m <= k < n]
    contacts = tuple(scene.contact[k] for k in [*pressing, *sliding])
    stance = tuple(scene.stance[k - n] for k in kept if k >= n)
    scene = replace(scene, contact=contacts, stance=stance)
    if scene.friction is not None:
        try:
            friction_of(landing_of(scene, robot))
        except (SceneError, SolveError) as refusal:
            remark = f"{refusal}; the numbers are those of contacts that stick"
            scene = replace(scene, friction=None)
    frames = [contact.frame for contact in scene.contact]
    frames += [foot.rpartition(":")[0] for foot in scene.stance]
    return FallStrike(
        scene=scene,
        pressing=tuple(frames[: len(pressing)]),
        stands=tuple(frames[len(pressing) :]),
        remark=remark,
        **strike,
    )


def _pressing(landing: PosedLanding, n: int) -> tuple[list[int], str]:
    """The contacts and standing points of a landing that press, and what is wrong with that.

    The first n contacts strike. What stands or slides takes part if it would sink otherwise. Where
    contacts stick, those that would be pulled are taken out.
    """
    friction = landing.scene.friction
    kept = list(range(n))
    frames = [place.name for place in landing.contact_places]
    try:
        rows = contact_rows(landing)
        A = rows.J @ np.linalg.solve(rows.M, rows.J.T)
        v = rows.speeds.reshape(-1, 3)
    except (np.linalg.LinAlgError, SceneError, SolveError):
        return kept, ""  # the landing says why
    # The impulses of what strikes; of all, if those drive what stands or slides into the ground.
    for m in dict.fromkeys((n, len(frames))):
        of_first = slice(3 * m)
        impulse, kept = _impulses(A[of_first, of_first], v[:m], friction)
        # Speeds into the ground after it, −(v_n + A_n p), as shares of the largest speed before.
        after = v[:, 2] + (A[:, of_first] @ impulse.ravel())[2::3]
        sinking = -after / np.abs(v).max()
        if sinking.max() <= SINKS:
            break
    worst = int(np.argmax(sinking))
    if sinking[worst] <= 0.01:
        return kept, ""
    laws = "no impulse was found that obeys the laws of friction"
    if friction is None:
        laws = (
            "no set of contacts that stick or open obeys the laws of contact; with --friction they "
            "may slide"
        )
    return kept, (
        f"{frames[worst]} would go on into the ground at {100.0 * sinking[worst]:.0f} % of the "
        f"strike's speed: {laws}"
    )


def _impulses(A: Array, velocity: Array, friction: float | None) -> tuple[Array, list[int]]:
    """The impulses (m, 3) of contacts that may open, and which of them press.

    Without a friction, or if none was found with it, contacts stick; those that would be pulled are
    taken out one by one.

    Args:
        A: (3m, 3m) Delassus matrix of rows along two tangents and the normal of each [1/kg].
        velocity: (m, 3) before the impact [m/s].
        friction: µ.
    """
    m = len(velocity)
    mu = STICKS if friction is None else friction
    solution = solve_friction(A, velocity, np.full(m, mu), np.zeros(m))
    kept = list(range(m))
    if solution:
        kept = [k for k in kept if solution[0].state[k] != "separates"]
    if solution and friction is not None:
        return solution[0].impulse, kept
    while True:
        # A p = −v along the rows of those that stick
        rows = (3 * np.array(kept)[:, None] + np.arange(3)).ravel()
        sticking = np.linalg.lstsq(A[np.ix_(rows, rows)], -velocity.ravel()[rows], rcond=1e-12)[0]
        impulse = np.zeros((m, 3))
        impulse[kept] = sticking.reshape(-1, 3)
        pulled = min(kept, key=lambda k: float(impulse[k, 2]))
        if impulse[pulled, 2] >= -SINKS * np.abs(impulse).max() or len(kept) == 1:
            return impulse, kept
        kept.remove(pulled)


def drops(
    rigid: Rigid, posture: str, height: float, count: int | None, together: float
) -> Iterator[FallStrike]:
    """The strikes of drops in all attitudes.

    Args:
        rigid: the robot.
        posture: its name.
        height: of the drop [m].
        count: of attitudes spread over all orientations; None for those of the box around it.
        together: height within which parts strike together [m].
    """
    speed = math.sqrt(2.0 * GRAVITY * height)
    attitudes = _box_attitudes(rigid) if count is None else _spread(count)
    for name, down in attitudes.items():
        turn = _turned_down(down)
        points, links = rigid.struck(turn, together)
        spots = rigid.spots(turn, points, links)
        scene = rigid.scene(turn, -speed * UP, np.zeros(3), spots, ())
        yield _landing(
            rigid,
            scene,
            fall=f"{posture} {name}".strip(),
            number=1,
            struck={spot.link: speed for spot in spots},
            near=_near(rigid, turn, links, together),
            motion="is in the air",
            rotation=0.0,
            rate=0.0,
            energy=0.5 * rigid.mass * speed**2,
        )


def _turned_down(direction: Array) -> Array:
    """The rotation (3, 3), about a level axis, after which a unit vector points down."""
    level = np.linalg.norm(direction[:2])
    forward = np.array([0.0, -1.0, 0.0])
    if level > 1e-12:
        forward = np.append(direction[:2], 0.0) / level
    return _tilt(forward, math.atan2(level, -direction[2]))


def _box_attitudes(rigid: Rigid) -> dict[str, Array]:
    """Unit vectors (3,) from the centre of mass to the box around the posture, by name.

    They point to its faces, edges and corners.
    """
    points, _ = rigid.points(np.vstack([np.eye(3), -np.eye(3)]))
    low = points.min(axis=0) - rigid.com
    high = points.max(axis=0) - rigid.com
    sides = np.array([low, np.zeros(3), high])
    kinds = {1: "face", 2: "edge", 3: "corner"}
    by_kind: dict[str, dict[str, Array]] = {kind: {} for kind in kinds.values()}
    # Along each axis a point is on the low side, in the middle or on the high side.
    for signs in np.ndindex(3, 3, 3):
        on_sides = sum(sign != 1 for sign in signs)
        if not on_sides:
            continue
        point = sides[signs, range(3)]
        names = [SIDES[axis][sign] for axis, sign in enumerate(signs) if sign != 1]
        name = f"{kinds[on_sides]} {'-'.join(names)}"
        by_kind[kinds[on_sides]][name] = point / np.linalg.norm(point)
    return by_kind["face"] | by_kind["edge"] | by_kind["corner"]


def _spread(count: int) -> dict[str, Array]:
    """Unit vectors (3,) spread evenly over the sphere along a spiral.

    Rotation about the vertical does not matter.
    """
    k = np.arange(count) + 0.5
    z = 1.0 - 2.0 * k / count
    angle = math.pi * (1.0 + math.sqrt(5.0)) * k
    r = np.sqrt(1.0 - z * z)
    attitudes: dict[str, Array] = {}
    for i in range(count):
        direction = [r[i] * math.cos(angle[i]), r[i] * math.sin(angle[i]), z[i]]
        attitudes[f"attitude {i + 1}"] = np.array(direction)
    return attitudes
