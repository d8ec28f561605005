"""Families on mechanisms other than chains: a box on its corners, a leg with a light link, a four-bar linkage."""

import functools
from typing import Literal, TypeAlias

import numpy as np

from shockpc.bench.build import Link, box, robot_of, rod
from shockpc.bench.cases.family import OBLIQUE, Family
from shockpc.model.closure import Closure, Place
from shockpc.model.contact import Contact
from shockpc.model.posture import Posture
from shockpc.robot.robot import Robot
from shockpc.scene import Scene

__all__ = ["CORNERS", "LIGHT", "LOOPS"]

Axes: TypeAlias = tuple[Literal["x", "y", "z"], ...]

X, Y, Z = np.eye(3)
ORIGIN = np.zeros(3)


@functools.cache
def _brick() -> Robot:
    body = Link(-1, "", ORIGIN, Y, 7.0, np.array([0.02, 0.01, 0.03]), box(7.0, (0.6, 0.4, 0.2)))
    mast = Link(0, "revolute", np.array([0.1, 0.05, 0.1]), 0.6 * X + 0.8 * Y, 1.0, *rod(1.0, 0.4 * Z))
    return robot_of([body, mast], "brick")


def _corners(variant: str, n: int) -> tuple[Robot, Scene]:
    corners = [(x, y, z) for z in (-0.1, 0.1) for x in (-0.3, 0.3) for y in (-0.2, 0.2)]
    kept: Axes = ("x", "y", "z") if variant == "sticking" else ("z",)
    contact = tuple(Contact(frame="link0", offset=corner, directions=kept) for corner in corners[:n])
    return _brick(), Scene(robot="brick", strike=OBLIQUE, contact=contact)


CORNERS = Family(
    "corners",
    "a box with a mast that lands on several corners at once: it has six degrees of freedom, so from the third corner on rows are "
    "dependent and the KKT matrix is singular",
    "corners [-]",
    ("sticking", "sliding"),
    (1, 4),
    _corners,
)


@functools.cache
def _leg(light: str, mass: float) -> Robot:
    masses = {"ankle": (3.0, mass, 0.5), "toe": (3.0, 1.0, mass), "arm": (3.0, 1.0, 0.5, mass)}[light]
    axes = (Y, 0.6 * Y + 0.8 * Z, Y, X)
    links = [Link(-1, "", ORIGIN, Y, 10.0, 0.1 * Z, box(10.0, (0.4, 0.3, 0.2)))]
    for i, (m, axis) in enumerate(zip(masses, axes, strict=False)):
        arm = i == 3
        parent, origin = (0, 0.1 * X + 0.1 * Z) if arm else (i, ORIGIN if i == 0 else -0.3 * Z)
        links.append(Link(parent, "revolute", origin, axis, m, *rod(m, 0.3 * Z if arm else -0.3 * Z)))
    return robot_of(links, "light")


def _light(variant: str, mass: float) -> tuple[Robot, Scene]:
    posture = Posture(joints={"joint1": 0.4, "joint2": -0.9, "joint3": 0.6})
    contact = Contact(frame="link3", offset=(0.0, 0.0, -0.3))
    return _leg(variant, mass), Scene(robot="light", posture=posture, strike=OBLIQUE, contact=(contact,))


LIGHT = Family(
    "light link",
    "a leg with a link of very small mass: without mass its motion is not determined, with almost none it is a quotient of "
    "rounding errors",
    "mass of the link [kg]",
    ("ankle", "toe", "arm"),
    (0.0, 1e-15, 1e-10),
    _light,
)

CRANK, COUPLER, ROCKER = (0.5, 1.0), (1.1, -0.7), (1.6, 0.0)
"""Ends of crank and coupler, and the rocker's hinge, from the crank's hinge: along x, and along z in units of the height."""


@functools.cache
def _four_bar(height: float) -> Robot:
    """A four-bar under a body, all of it within so small a height of one line; drawn closed, so that every angle is zero."""
    crank, coupler, rocker = (x * X + z * height * Z for x, z in (CRANK, COUPLER, ROCKER))
    hinge = -0.8 * X - 0.1 * Z
    body = Link(-1, "", ORIGIN, Y, 9.0, 0.03 * X + 0.1 * Z, box(9.0, (1.6, 0.3, 0.3)))
    bars = [
        Link(0, "revolute", hinge, Y, 0.8, *rod(0.8, crank)),
        Link(1, "revolute", crank, Y, 0.6, *rod(0.6, coupler - crank)),
        Link(0, "revolute", hinge + rocker, Y, 0.7, *rod(0.7, coupler - rocker)),
    ]
    return robot_of([body, *bars], "four_bar")


def _loops(variant: str, height: float) -> tuple[Robot, Scene]:
    def coupler_from(start: tuple[float, float]) -> tuple[float, float, float]:
        return (COUPLER[0] - start[0], 0.0, (COUPLER[1] - start[1]) * height)

    kept: Axes = ("x", "y", "z") if variant == "closed in space" else ("x", "z")
    a, b = (Place(frame=frame, offset=coupler_from(start)) for frame, start in (("link2", CRANK), ("link3", ROCKER)))
    return _four_bar(height), Scene(
        robot="four_bar",
        posture=Posture(joints={"joint1": 0.0, "joint2": 0.0, "joint3": 0.0}),
        strike=OBLIQUE,
        contact=(Contact(frame="link1", offset=(0.2, 0.0, -0.1)),),
        closure=(Closure(a=a, b=b, directions=kept),),
    )


LOOPS = Family(
    "flat four-bar",
    "a four-bar linkage almost folded into one line, where a closure row vanishes; closed by a point in space, another row is "
    "dependent as well",
    "height over length [-]",
    ("closed in the plane", "closed in space"),
    (0.0, 1e-10, 1.0),
    _loops,
)
