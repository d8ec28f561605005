"""Families on chains: mass ratios, a knee that straightens, very many links, and units."""

import functools
import math

import numpy as np

from shockpc.bench.build import Link, box, robot_of, rod
from shockpc.bench.cases.family import OBLIQUE, Family, on
from shockpc.core.spatial import Array
from shockpc.model.contact import Contact
from shockpc.model.posture import Posture
from shockpc.robot.robot import Robot
from shockpc.scene import Scene, Strike

__all__ = ["KNEE", "LINKS", "MASS_RATIO", "OBLIQUE", "UNITS", "bent", "chain", "chain_end"]

X, Y, Z = np.eye(3)
ORIGIN = np.zeros(3)
BEND = (0.7, -0.9, 0.5, -0.3, 0.8, -0.6)


def chain(masses: Array, lengths: Array) -> Robot:
    """A chain of rods, each hinged to the end of the last; hinges turn about y, and every third about x."""
    origins = [ORIGIN, *(length * Z for length in lengths[:-1])]
    links = [
        Link(i - 1, "revolute", origin, X if i % 3 == 2 else Y, mass, *rod(mass, length * Z))
        for i, (mass, length, origin) in enumerate(zip(masses, lengths, origins, strict=True))
    ]
    return robot_of(links, "chain")


def chain_end(robot: Robot, length: float) -> tuple[str, tuple[float, float, float]]:
    """The far end of a chain: the last link and the point from its origin."""
    return robot.bodies[-1].name, (0.0, 0.0, float(length))


def bent(robot: Robot, scale: float = 1.0) -> Posture:
    """A chain that is bent at every joint, by angles that repeat."""
    joints = {name: scale * BEND[i % len(BEND)] for i, name in enumerate(robot.joint_names)}
    return Posture(base_rpy_deg=(0.0, 25.0, 0.0), joints=joints)


@functools.cache
def _ratio_chain(ratio: float, rooted_light: bool) -> Robot:
    masses = np.geomspace(ratio**-0.5, ratio**0.5, 6)
    return chain(masses if rooted_light else masses[::-1], np.full(6, 0.4))


def _mass_ratio(variant: str, ratio: float) -> tuple[Robot, Scene]:
    rooted_light = "rooted light" in variant
    robot = _ratio_chain(ratio, rooted_light)
    at_root = ("struck light" in variant) == rooted_light
    frame, offset = ("link0", (0.0, 0.0, 0.0)) if at_root else chain_end(robot, 0.4)
    return robot, Scene(robot="chain", posture=bent(robot), strike=OBLIQUE, contact=(Contact(frame=frame, offset=offset),))


MASS_RATIO = Family(
    "mass ratio",
    "six links with a large ratio of masses: the inertia of the light links is lost in sums with that of the heavy ones, and small "
    "motions are differences of large ones",
    "mass ratio [-]",
    ("struck heavy, rooted light", "struck heavy, rooted heavy", "struck light, rooted light", "struck light, rooted heavy"),
    (1e10, 1e20),
    _mass_ratio,
)


@functools.cache
def _leg() -> Robot:
    trunk = Link(-1, "", ORIGIN, Y, 20.0, np.array([0.05, 0.0, 0.2]), box(20.0, (0.3, 0.3, 0.5)))
    thigh = Link(0, "revolute", ORIGIN, Y, 4.0, *rod(4.0, -0.5 * Z))
    shank = Link(1, "revolute", -0.5 * Z, Y, 2.0, *rod(2.0, -0.5 * Z))
    return robot_of([trunk, thigh, shank], "leg")


def _knee(variant: str, angle: float) -> tuple[Robot, Scene]:
    posture = Posture(joints={"joint1": -0.5 * angle, "joint2": angle})
    contact = Contact(frame="link2", offset=(0.0, 0.0, -0.5), directions=("z",) if "slides" in variant else ("x", "y", "z"))
    return _leg(), Scene(robot="leg", base="fixed" if "fixed" in variant else "free", posture=posture, contact=(contact,))


KNEE = Family(
    "knee",
    "a knee that straightens, struck along the leg, which then does not yield; on a fixed base the landing has no solution",
    "knee angle [rad]",
    ("free base", "fixed base", "fixed base, foot slides"),
    (0.0, 1e-9),
    _knee,
)


@functools.cache
def _equal_chain(n: int) -> Robot:
    return chain(np.full(n, 1.0), np.full(n, 0.2))


def _links(variant: str, n: int) -> tuple[Robot, Scene]:
    robot = _equal_chain(n)
    # Angles that shrink with the number of links keep a long chain from winding into itself.
    posture = bent(robot, 1.0 / math.sqrt(n))
    return robot, Scene(robot="chain", posture=posture, strike=OBLIQUE, contact=on(f"link{0 if 'end' in variant else n // 2}"))


LINKS = Family(
    "links",
    "chains of equal links: the motion of a distant link is a small difference of long sums",
    "number of links [-]",
    ("struck at the end", "struck in the middle"),
    (10, 50, 200),
    _links,
)


@functools.cache
def _scaled(length: float, mass: float) -> Robot:
    return chain(mass * np.array([8.0, 2.0, 1.0, 3.0, 0.5]), length * np.array([0.5, 0.3, 0.2, 0.4, 0.1]))


def _units(variant: str, length: float) -> tuple[Robot, Scene]:
    robot = _scaled(length, {"kg": 1.0, "g": 1e3}[variant])
    posture = Posture(joints={"joint1": 0.7, "joint2": -0.9, "joint3": 0.5, "joint4": 1.1})
    contact = Contact(frame="link4", offset=(0.0, 0.0, 0.1 * length))
    strike = Strike(velocity=(0.4 * length, 0.1 * length, -0.9 * length))
    return robot, Scene(robot="chain", posture=posture, strike=strike, contact=(contact,))


UNITS = Family(
    "units",
    "one robot in other units of length and mass: masses and moments of inertia are entries of one matrix, so the units set its "
    "condition number",
    "units of length in one metre [-]",
    ("kg", "g"),
    (1e-3, 1e3, 1e6),
    _units,
)
