"""Loops near a singular posture."""

import functools

import numpy as np

from shockpc.bench.build import Link, box, robot_of, rod
from shockpc.bench.cases.chains import OBLIQUE
from shockpc.bench.cases.family import Axis, Family
from shockpc.model.closure import Closure, Place
from shockpc.model.contact import Contact
from shockpc.model.posture import Posture
from shockpc.robot.robot import Robot
from shockpc.scene import Scene

__all__ = ["LOOPS"]

CRANK, COUPLER, ROCKER = (0.5, 1.0), (1.1, -0.7), (1.6, 0.0)
"""Ends of crank and coupler, and the rocker's hinge, from the crank's hinge: along x, and along z in units of the height."""


@functools.cache
def _four_bar(height: float) -> Robot:
    """A four-bar under a body, all of it within so small a height of one line; drawn closed, so that every angle is zero."""
    y = np.eye(3)[1]
    corner = np.array([[0.0, 0.0, 0.0]] + [[x, 0.0, z * height] for x, z in (CRANK, COUPLER, ROCKER)])
    hinge = np.array([-0.8, 0.0, -0.1])
    body = Link(-1, "", np.zeros(3), y, 9.0, np.array([0.03, 0.0, 0.1]), box(9.0, (1.6, 0.3, 0.3)))
    bars = [
        Link(0, "revolute", hinge, y, 0.8, *rod(0.8, corner[1] - corner[0])),
        Link(1, "revolute", corner[1] - corner[0], y, 0.6, *rod(0.6, corner[2] - corner[1])),
        Link(0, "revolute", hinge + corner[3], y, 0.7, *rod(0.7, corner[2] - corner[3])),
    ]
    return robot_of([body, *bars], "four_bar")


def _loops(variant: str, height: float) -> tuple[Robot, Scene]:
    robot = _four_bar(height)
    coupler = np.array([COUPLER[0] - CRANK[0], 0.0, (COUPLER[1] - CRANK[1]) * height])
    rocker = np.array([COUPLER[0] - ROCKER[0], 0.0, (COUPLER[1] - ROCKER[1]) * height])
    kept: tuple[Axis, ...] = ("x", "y", "z") if variant == "closed in space" else ("x", "z")
    closure = Closure(
        a=Place(frame="link2", offset=tuple(coupler.tolist())),
        b=Place(frame="link3", offset=tuple(rocker.tolist())),
        directions=kept,
    )
    struck = (
        Contact(frame="link1", offset=(0.2, 0.0, -0.1))
        if variant != "rocker struck"
        else Contact(frame="link3", offset=(-0.1, 0.0, -0.1))
    )
    posture = Posture(joints={"joint1": 0.0, "joint2": 0.0, "joint3": 0.0})
    return robot, Scene(robot="four_bar", posture=posture, strike=OBLIQUE, contact=(struck,), closure=(closure,))


LOOPS = Family(
    name="flat four-bar",
    title="A four-bar linkage almost folded into one line",
    hard="with all bars in line one closure row vanishes; closed by a point in space, another row is dependent as well",
    parameter="height over length [-]",
    variants=("crank struck", "rocker struck", "closed in space"),
    values=(0.0, 1e-10, 1e-6, 1e-2, 1.0),
    build=_loops,
)
