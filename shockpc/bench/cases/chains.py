"""Chains: mass ratios, a knee that straightens, and very many links."""

import functools
import math

import numpy as np

from shockpc.bench.build import Link, box, robot_of, rod
from shockpc.bench.cases.family import Family
from shockpc.core.spatial import Array
from shockpc.model.columns import Base
from shockpc.model.contact import Contact
from shockpc.model.posture import Posture
from shockpc.robot.robot import Robot
from shockpc.scene import Scene, Strike

__all__ = ["KNEE", "LINKS", "MASS_RATIO", "OBLIQUE", "bent", "chain", "chain_end"]

Y = np.array([0.0, 1.0, 0.0])
BEND = (0.7, -0.9, 0.5, -0.3, 0.8, -0.6)


def chain(masses: Array, lengths: Array, out_of_plane: bool = True) -> Robot:
    """A chain of rods, each hinged to the end of the last; hinges turn about y, and with `out_of_plane` every third about x."""
    links = []
    for i, (mass, length) in enumerate(zip(masses, lengths, strict=True)):
        along = np.array([0.0, 0.0, length])
        com, inertia = rod(float(mass), along)
        axis = np.array([1.0, 0.0, 0.0]) if out_of_plane and i % 3 == 2 else Y
        origin = np.array([0.0, 0.0, lengths[i - 1]]) if i else np.zeros(3)
        links.append(Link(i - 1, "revolute", origin, axis, float(mass), com, inertia))
    return robot_of(links, "chain")


def chain_end(robot: Robot, length: float) -> tuple[str, tuple[float, float, float]]:
    """The far end of a chain: the last link and the point from its origin."""
    return robot.bodies[-1].name, (0.0, 0.0, float(length))


def bent(robot: Robot, scale: float = 1.0) -> Posture:
    """A chain that is bent at every joint, by angles that repeat."""
    joints = {name: scale * BEND[i % len(BEND)] for i, name in enumerate(robot.joint_names)}
    return Posture(base_rpy_deg=(0.0, 25.0, 0.0), joints=joints)


OBLIQUE = Strike(velocity=(0.4, 0.1, -0.9))


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
    name="mass ratio",
    title="Six links with a large ratio of masses",
    hard="the inertia of the light links is lost in sums with that of the heavy ones; small motions are differences of large ones",
    parameter="mass ratio [-]",
    variants=(
        "struck heavy, rooted light",
        "struck heavy, rooted heavy",
        "struck light, rooted light",
        "struck light, rooted heavy",
    ),
    values=(1.0, 1e5, 1e10, 1e20),
    build=_mass_ratio,
)


@functools.cache
def _leg() -> Robot:
    thigh, shank = rod(4.0, np.array([0.0, 0.0, -0.5])), rod(2.0, np.array([0.0, 0.0, -0.5]))
    return robot_of(
        [
            Link(-1, "", np.zeros(3), Y, 20.0, np.array([0.05, 0.0, 0.2]), box(20.0, (0.3, 0.3, 0.5))),
            Link(0, "revolute", np.zeros(3), Y, 4.0, *thigh),
            Link(1, "revolute", np.array([0.0, 0.0, -0.5]), Y, 2.0, *shank),
        ],
        "leg",
    )


def _knee(variant: str, angle: float) -> tuple[Robot, Scene]:
    robot = _leg()
    posture = Posture(joints={"joint1": -0.5 * angle, "joint2": angle})
    contact = Contact(frame="link2", offset=(0.0, 0.0, -0.5), directions=("z",) if "slides" in variant else ("x", "y", "z"))
    base: Base = "fixed" if "fixed" in variant else "free"
    return robot, Scene(robot="leg", base=base, posture=posture, contact=(contact,))


KNEE = Family(
    name="knee",
    title="A knee that straightens, struck along the leg",
    hard="a straight leg does not yield along its axis; on a fixed base the landing then has no solution",
    parameter="knee angle [rad]",
    variants=("free base", "fixed base", "fixed base, foot slides"),
    values=(0.0, 1e-12, 1e-9, 1e-6, 1e-3, 1.0),
    build=_knee,
)


@functools.cache
def _equal_chain(n: int) -> Robot:
    return chain(np.full(n, 1.0), np.full(n, 0.2))


def _links(variant: str, n: float) -> tuple[Robot, Scene]:
    robot = _equal_chain(int(n))
    # Angles that shrink with the number of links keep a long chain from winding into itself.
    posture = bent(robot, 1.0 / math.sqrt(n))
    i = 0 if "end" in variant else int(n) // 2
    return robot, Scene(robot="chain", posture=posture, strike=OBLIQUE, contact=(Contact(frame=f"link{i}"),))


LINKS = Family(
    name="links",
    title="Chains of equal links",
    hard="the motion of a distant link is a small difference of long sums",
    parameter="number of links [-]",
    variants=("struck at the end", "struck in the middle"),
    values=(10, 50, 100, 200),
    build=_links,
)
