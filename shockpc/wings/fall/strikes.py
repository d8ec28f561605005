"""The strikes of falls: how a robot tips over an edge of its support or is dropped, and the landing
that each strike is.

Of the points that meet the ground together those are in the landing that press.
"""

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from shockpc.core.coulomb import solve_friction
from shockpc.core.spatial import Array
from shockpc.impact.contact_rows import contact_rows
from shockpc.impact.friction import friction_of
from shockpc.landing.landing import PosedLanding
from shockpc.landing.resolve import landing_of
from shockpc.landing.scene import Scene
from shockpc.landing.strike import GRAVITY
from shockpc.text.errors import SceneError, SolveError, StudyError
from shockpc.text.printed import listed
from shockpc.wings.fall.body import UP, Rigid, Spot
from shockpc.wings.fall.tipping import STICKS, CrossSection, Fall, Kind, Touch, follow_fall

SIDES = (("back", "", "front"), ("right", "", "left"), ("bottom", "", "top"))
"""Names of the sides of the box around the robot, along x, y and z."""

NUDGE = 1e-6
"""Rotation beyond the balance at which a robot begins to fall [rad]."""

LEVEL = math.radians(1.0)
"""Rotation within which points within `together` of the ground meet it as the robot is pushed
[rad].
"""

SINKS = 1e-6
"""Speed into the ground, of that of the strike, with which a point that stands takes part [1]."""

NEAR_GROUND = 5e-3
"""Height up to which a part nearly strikes together with others [m]."""

ASIDE = 0.3
"""Share of the change of rotation at the first strike that is out of the plane of the fall, above
which there is a warning [1].
"""

EARLY = math.radians(3.0)
"""How long before the edge would be pulled or slips the centre of pressure may leave it without a
warning [rad].
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
        remark: what meets the ground and is not part of the landing as it should be, and why.
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
        """Of the landing."""
        return f"{self.fall} {self.number}" if self.forward is not None else self.fall

    @property
    def speed(self) -> float:
        """Of the fastest of them towards the ground [m/s]."""
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


def tip_over(
    rigid: Rigid, name: str, heading: float, push: float | None, together: float, least: float
) -> Tip:
    """How a robot tips over along a heading.

    Raises:
        StudyError: it does not tip, or nothing of it strikes.
    """
    forward, ends = rigid.edge(heading, together)
    section, friction = rigid.section(forward), rigid.landing.scene.friction
    first, theta = _support(section, together)
    corner, balanced = section.balance(first)
    rate = section.least_rate(first, theta) if balanced > theta else 0.0
    height = -section.at(first, theta)[1]
    if balanced <= theta:
        start, corner = (
            section.pivoting(first, theta, 0.0 if push is None else push / height),
            first,
        )
    elif push is None:
        length, _, kappa = section.arm(corner)
        start = section.pivoting(
            corner, balanced + NUDGE, math.sqrt(kappa * GRAVITY / length) * NUDGE
        )
    elif push <= rate * height:
        raise StudyError(
            f"a push to {push:g} m/s does not tip the robot: it balances at "
            f"{math.degrees(balanced):.3g} deg, which takes at least "
            f"{rate * height:.3g} m/s"
        )
    else:
        start, corner = section.pivoting(first, theta, push / height), first
    sliding, hinge = (
        follow_fall(section, corner, start, friction),
        follow_fall(section, corner, start, hinged=least),
    )
    turned = math.degrees(
        math.acos(min(1.0, float(forward @ [math.cos(heading), math.sin(heading), 0.0])))
    )
    warnings = [
        f"the edge is turned by {turned:.2g} deg from the heading; the robot tips across the edge"
    ] * (turned > 3.0)
    strike = next((touch for touch in sliding.touches if touch.speed >= least), sliding.touches[0])
    warnings += _below(rigid, forward, section, strike)
    warnings += _pressure(rigid, forward, ends, section, sliding, least)
    warnings += ["it is still rocking when it is no longer followed"] * (not sliding.rests)
    return Tip(
        name=name,
        forward=forward,
        balance=balanced,
        least_push=rate * height,
        hinged=hinge.touches[-1].before.omega,
        fall=sliding,
        section=section,
        warnings=tuple(warnings),
    )


def _tilt(forward: Array, angle: float) -> Array:
    """The rotation (3, 3) of a robot that tips by an angle [rad] along a level unit vector."""
    return np.asarray(Rotation.from_rotvec(angle * np.cross(UP, forward)).as_matrix())


def _below(rigid: Rigid, forward: Array, section: CrossSection, touch: Touch) -> Iterator[str]:
    """A warning of bodies without geometry whose centres of mass are below the ground at a strike.

    Raises:
        StudyError: they are most of the mass.
    """
    robot, theta = rigid.landing.robot, touch.before.theta
    under = np.flatnonzero(
        (rigid.coms - rigid.com) @ _tilt(forward, theta)[2] < section.at(touch.corner, theta)[1]
    )
    share, names = (
        float(robot.masses[under].sum()) / rigid.mass,
        listed((robot.bodies[i].name for i in under), 4),
    )
    text = (
        f"{names} ({100.0 * share:.3g} % of the mass) would be below the ground at the strike at "
        f"{math.degrees(theta):.3g} deg, "
    )
    text += "because they have no geometry there"
    if share > 0.5:
        raise StudyError(f"{text}; give the robot's file collision or visual geometry")
    yield from [text] * bool(names)


def _support(section: CrossSection, together: float) -> tuple[int, float]:
    """The forward corner of a robot's support, and the rotation at which it is on the ground [rad]."""
    low = best = section.lowest(0.0)
    while (
        section.side(best) <= LEVEL
        and section.at(best + 1, 0.0)[1] - section.at(low, 0.0)[1] <= together
    ):
        best += 1
    return best, max(section.side(best - 1), 0.0)


def _pressure(
    rigid: Rigid, forward: Array, ends: Array, section: CrossSection, fall: Fall, least: float
) -> Iterator[str]:
    """A warning where the centre of pressure leaves the edge: at (I_xy ω' + I_zy ω²) / N along it,
    from the centre of mass.
    """
    if np.ptp(ends) == 0.0:
        yield "the support is a corner in this direction, not an edge: the robot may turn about it, and another part may strike"
        return
    last = next(
        (touch for touch in fall.touches if touch.speed >= least), fall.touches[-1]
    ).before.theta
    pivoting = list(
        itertools.takewhile(
            lambda phase: phase.kind == "pivots" and phase.start.theta < last, fall.phases
        )
    )
    for phase in pivoting:
        length, angle, kappa = section.arm(phase.corner)
        steps = 2 + int((phase.end.theta - phase.start.theta) / EARLY)
        for theta in np.linspace(phase.start.theta, phase.end.theta, steps).tolist():
            turn = _tilt(forward, theta)
            moments, squared = (
                turn @ rigid.inertia @ turn.T @ np.cross(UP, forward),
                section.squared_rate(phase.corner, theta, phase.start),
            )
            rate = (
                forward @ moments * kappa * GRAVITY / length * math.sin(theta + angle)
                + UP @ moments * squared
            )
            place = float(rate) / (
                rigid.mass * max(float(section.forces(phase.corner, theta, squared)[1]), 1e-9)
            )
            if not ends[0] <= place <= ends[1]:
                if pivoting[-1].end.theta - theta > EARLY:
                    yield (
                        f"the centre of pressure leaves the edge at {math.degrees(theta):.3g} deg, "
                        f"before the strike at "
                        f"{math.degrees(last):.3g} deg: the robot then turns about a corner, and "
                        f"another part may strike"
                    )
                return


def strikes_of(rigid: Rigid, tip: Tip, together: float, least: float) -> Iterator[FallStrike]:
    """The strikes of a fall that are fast enough, each with its landing."""
    left, number, last, section = np.cross(UP, tip.forward), 0, tip.fall.touches[0], tip.section
    kinds = {phase.end: phase.kind for phase in tip.fall.phases}
    for touch in tip.fall.touches:
        theta, omega = touch.before.theta, touch.before.omega
        ahead, height = section.at(touch.corner, last.before.theta)
        # What was within `together` of the ground at the last strike has been part of it, unless it
        # stood there.
        known = height - section.at(last.corner, last.before.theta)[1] <= together and not _stood(
            section, last, ahead
        )
        if touch.speed < least or (number and known):
            continue
        number, last, turn = number + 1, touch, _tilt(tip.forward, theta)
        points, links = rigid.struck(turn, together)
        old = np.array([_stood(section, touch, place) for place in (points @ tip.forward).tolist()])
        # a disc that lands flat is one point, as far from the edge on which it stood as from the
        # other
        old[:] &= not old.all()
        struck, stands = (rigid.spots(turn, points[rows], links[rows]) for rows in (~old, old))
        velocity = touch.before.vx * tip.forward + touch.before.vz * UP
        down = {
            spot.link: omega * float(tip.forward @ turn @ (spot.point - rigid.com))
            - touch.before.vz
            for spot in struck
        }
        fastest = sorted(struck, key=lambda spot: -down[spot.link])
        struck = tuple(spot for spot in fastest if down[spot.link] > SINKS * touch.speed) or tuple(
            fastest[:1]
        )
        near = set(rigid.struck(turn, max(NEAR_GROUND, together))[1].tolist()) - set(links.tolist())
        scene = rigid.scene(
            turn, velocity, omega * left, struck, stands, kinds[touch.before] == "slides"
        )
        if scene.plane == "auto":
            scene = replace(scene, plane=tuple(np.cross(tip.forward, UP).tolist()))
        if scene.yields:
            scene = replace(scene, contact=scene.contact[: len(struck)], stance=())
        strike = _landing(
            rigid,
            scene,
            turn,
            fall=tip.name,
            number=number,
            struck={spot.link: down[spot.link] for spot in struck},
            near=tuple(sorted(near)),
            motion=kinds[touch.before],
            rotation=theta,
            rate=omega,
            forward=tip.forward,
            energy=section.energy(touch.before) - rigid.mass * GRAVITY * touch.before.z,
        )
        aside = (
            _turns_aside(rigid, turn, (*struck, *stands), velocity, omega, tip.forward)
            if number == 1
            else 0.0
        )
        if aside > ASIDE:
            text = (
                f"{100.0 * aside:.0f} % of its change of rotation is out of the plane of the "
                "fall, in which later strikes are computed"
            )
            strike = replace(strike, remark="; ".join(filter(None, [strike.remark, text])))
        yield strike


def _turns_aside(
    rigid: Rigid, turn: Array, spots: Sequence[Spot], velocity: Array, omega: float, forward: Array
) -> float:
    """Share of the change of rotation at a strike of the rigid robot that is not about the edge
    [1].
    """
    axes, mu = np.array([forward, np.cross(UP, forward), UP]), rigid.landing.scene.friction
    arms = (np.array([spot.point for spot in spots]) - rigid.com) @ turn.T
    rows = np.concatenate([np.hstack([axes, np.cross(arm, axes)]) for arm in arms])
    response = np.vstack(
        [rows[:, :3].T / rigid.mass, np.linalg.solve(turn @ rigid.inertia @ turn.T, rows[:, 3:].T)]
    )
    speeds = (rows @ np.concatenate([velocity, omega * axes[1]])).reshape(-1, 3)
    change = response[3:] @ _impulses(rows @ response, speeds, mu)[0].ravel()
    return float(
        np.linalg.norm(change - (change @ axes[1]) * axes[1]) / (np.linalg.norm(change) or 1.0)
    )


def _stood(section: CrossSection, touch: Touch, place: float) -> bool:
    """Whether what is on the ground at a place [m] is nearer to the corner that was there before a
    touch than to the new one.
    """
    new, old = (section.at(corner, touch.before.theta)[0] for corner in (touch.corner, touch.on))
    return touch.on >= 0 and abs(place - old) < abs(place - new)


def _landing(rigid: Rigid, scene: Scene, turn: Array, **strike: Any) -> FallStrike:
    """A strike with those contacts that press.

    Friction is left out where it has no solution. Args: turn, (3, 3) from the posture to the
    attitude.
    """
    landing, n, m = (
        landing_of(scene, rigid.landing.robot),
        len(scene.contact),
        len(strike["struck"]),
    )
    kept, remark = _pressing(landing, m) if n + len(scene.stance) > 1 else ([0], "")
    pressing = [k for k in kept if k < m] or [0]
    scene = replace(
        scene,
        contact=tuple(scene.contact[k] for k in [*pressing, *(k for k in kept if m <= k < n)]),
        stance=tuple(scene.stance[k - n] for k in kept if k >= n),
    )
    try:
        friction_of(landing_of(scene, rigid.landing.robot)) if scene.friction is not None else None
    except (SceneError, SolveError) as refusal:
        remark, scene = (
            f"{refusal}; the numbers are those of contacts that stick",
            replace(scene, friction=None),
        )
    frames = [
        *(one.frame for one in scene.contact),
        *(foot.rpartition(":")[0] for foot in scene.stance),
    ]
    m = len(pressing)
    return FallStrike(
        scene=scene, pressing=tuple(frames[:m]), stands=tuple(frames[m:]), remark=remark, **strike
    )


def _pressing(landing: PosedLanding, n: int) -> tuple[list[int], str]:
    """Which of the contacts and standing points of a landing press, and what is wrong with that.

    The first n contacts strike. What stands or slides takes part if it would sink otherwise. Where
    contacts stick, those that would be pulled are taken out.
    """
    friction, kept, frames = (
        landing.scene.friction,
        list(range(n)),
        [place.name for place in landing.contact_places],
    )
    try:
        rows = contact_rows(landing)
        A, v = rows.J @ np.linalg.solve(rows.M, rows.J.T), rows.speeds.reshape(-1, 3)
    except (np.linalg.LinAlgError, SceneError, SolveError):
        return kept, ""  # the landing says why
    for count in dict.fromkeys((n, len(frames))):
        impulse, kept = _impulses(A[: 3 * count, : 3 * count], v[:count], friction)
        sinking = -(v[:, 2] + (A[:, : 3 * count] @ impulse.ravel())[2::3]) / np.abs(v).max()
        if sinking.max() <= SINKS:
            break
    worst, laws = int(np.argmax(sinking)), "no impulse was found that obeys the laws of friction"
    if friction is None:
        laws = (
            "no set of contacts that stick or open obeys the laws of contact; with --friction they "
            "may slide"
        )
    text = (
        f"{frames[worst]} would go on into the ground at {100.0 * sinking[worst]:.0f} % of the "
        f"strike's speed: {laws}"
    )
    return kept, text if sinking[worst] > 0.01 else ""


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
    solution = solve_friction(
        A, velocity, np.full(m, STICKS if friction is None else friction), np.zeros(m)
    )
    kept = [k for k in range(m) if not solution or solution[0].state[k] != "separates"]
    if solution and friction is not None:
        return solution[0].impulse, kept
    while True:
        rows, impulse = (3 * np.array(kept)[:, None] + np.arange(3)).ravel(), np.zeros((m, 3))
        impulse[kept] = np.linalg.lstsq(
            A[np.ix_(rows, rows)], -velocity.ravel()[rows], rcond=1e-12
        )[0].reshape(-1, 3)
        pulled = min(kept, key=lambda k: float(impulse[k, 2]))
        if impulse[pulled, 2] >= -SINKS * np.abs(impulse).max() or len(kept) == 1:
            return impulse, kept
        kept.remove(pulled)


def drops(
    rigid: Rigid, posture: str, height: float, count: int | None, together: float
) -> Iterator[FallStrike]:
    """The strikes of drops in all attitudes."""
    speed = math.sqrt(2.0 * GRAVITY * height)
    for name, down in (_box_attitudes(rigid) if count is None else _spread(count)).items():
        level = np.linalg.norm(down[:2])
        turn = _tilt(
            np.append(down[:2], 0.0) / level if level > 1e-12 else np.array([0.0, -1.0, 0.0]),
            math.atan2(level, -down[2]),
        )
        points, links = rigid.struck(turn, together)
        spots, near = (
            rigid.spots(turn, points, links),
            set(rigid.struck(turn, max(NEAR_GROUND, together))[1].tolist()),
        )
        scene = rigid.scene(turn, -speed * UP, np.zeros(3), spots, ())
        yield _landing(
            rigid,
            scene,
            turn,
            fall=f"{posture} {name}".strip(),
            number=1,
            struck={spot.link: speed for spot in spots},
            near=tuple(sorted(near - set(links.tolist()))),
            motion="is in the air",
            rotation=0.0,
            rate=0.0,
            energy=0.5 * rigid.mass * speed**2,
        )


def _box_attitudes(rigid: Rigid) -> dict[str, Array]:
    """Unit vectors (3,) from the centre of mass to the faces, edges and corners of the box around
    the posture, by name.
    """
    points, _ = rigid.points(np.vstack([np.eye(3), -np.eye(3)]))
    low, high = points.min(axis=0) - rigid.com, points.max(axis=0) - rigid.com
    attitudes: dict[str, Array] = {}
    for kind, count in (("face", 1), ("edge", 2), ("corner", 3)):
        for signs in np.ndindex(3, 3, 3):
            if sum(sign != 1 for sign in signs) == count:
                place = np.array([(low[k], 0.0, high[k])[sign] for k, sign in enumerate(signs)])
                name = "-".join(filter(None, (SIDES[k][sign] for k, sign in enumerate(signs))))
                attitudes[f"{kind} {name}"] = place / np.linalg.norm(place)
    return attitudes


def _spread(count: int) -> dict[str, Array]:
    """Unit vectors (3,) spread evenly over the sphere along a spiral; rotation about the vertical
    does not matter.
    """
    k = np.arange(count) + 0.5
    z, angle = 1.0 - 2.0 * k / count, math.pi * (1.0 + math.sqrt(5.0)) * k
    r = np.sqrt(1.0 - z * z)
    return {
        f"attitude {i + 1}": np.array([r[i] * math.cos(angle[i]), r[i] * math.sin(angle[i]), z[i]])
        for i in range(count)
    }
