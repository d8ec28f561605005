"""A robot that tips over an edge of its support: its fall, and what limits the result."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.landing.scenes.strike import GRAVITY
from shockpc.text.errors import StudyError
from shockpc.text.printed import listed
from shockpc.wings.fall.body import UP, Rigid, tilt
from shockpc.wings.fall.cross_section import CrossSection, SectionMotion
from shockpc.wings.fall.planar_fall import CornerImpact, Fall, Phase, follow_fall

NUDGE = 1e-6
"""Rotation beyond the balance at which a robot begins to fall [rad]."""

LEVEL = math.radians(1.0)
"""Largest rotation [rad] that brings a side to the ground on which a robot already stands.

The corner at the end of this side is at most `together` above the ground.
"""

EARLY = math.radians(3.0)
"""Rotation by which the centre of pressure may leave the edge early without a warning [rad].

Early is before the edge would be pulled or slips.
"""


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
        StudyError: it does not tip, its motion has no solution, or most of its mass would be below
            the ground.
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
        hinged=hinged.impacts[-1].before.omega,
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


def _first_strike(fall: Fall, least: float) -> CornerImpact:
    """The first impact of at least a speed [m/s]; the first of all if none is so fast."""
    return next((impact for impact in fall.impacts if impact.speed >= least), fall.impacts[0])


def _below(
    rigid: Rigid, forward: Array, section: CrossSection, impact: CornerImpact
) -> Iterator[str]:
    """A warning of bodies without geometry whose centres of mass are below the ground at a strike.

    Raises:
        StudyError: they are most of the mass.
    """
    robot = rigid.landing.robot
    theta = impact.before.theta
    heights = (rigid.coms - rigid.com) @ tilt(forward, theta)[2]
    under = np.flatnonzero(heights < section.at(impact.corner, theta)[1])
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
    """The forward corner of a robot's support, and the rotation at which that is on the ground.

    The rotation [rad] is zero if it is there already.
    """
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
    fast = [impact for impact in fall.impacts if impact.speed >= least]
    strike = fast[0] if fast else fall.impacts[-1]
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
            attitude = tilt(forward, theta)
            inertia_y = attitude @ rigid.inertia @ attitude.T @ left
            squared = section.squared_rate(phase.corner, theta, phase.start)
            acceleration = kappa * GRAVITY / c * math.sin(theta + angle)
            moment = forward @ inertia_y * acceleration + UP @ inertia_y * squared
            force = rigid.mass * max(float(section.forces(phase.corner, theta, squared)[1]), 1e-9)
            if not ends[0] <= float(moment) / force <= ends[1]:
                return float(theta)
    return None
