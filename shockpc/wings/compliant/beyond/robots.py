"""Robots whose legs bend: errors of rigid links.

They are over the duration of contact and the first bending frequency.
"""

import functools
import math
from dataclasses import replace
from typing import Literal, NamedTuple

import numpy as np

from shockpc import Contact, Joints, Point, Robot, Scene, load_robot
from shockpc.landing.landing import PosedLanding
from shockpc.landing.resolve import resolve
from shockpc.wings.compliant.beyond.peaks import LandingPeaks, landing_peaks
from shockpc.wings.compliant.links.bending import unit_frequency
from shockpc.wings.compliant.links.bent_landing import flexible_landing
from shockpc.wings.compliant.links.flexes import Flex
from shockpc.wings.compliant.over_time.compliant_landing import CompliantLanding

LANDINGS = (
    ("go2", "FL_foot", "go2"),
    ("g1", "left_ankle_roll_link", "g1"),
    ("talos", "left_sole_link", None),
)
"""Robots, their feet and their drives."""

LAWS: dict[str, tuple[Contact, Literal["hysteresis", "damper"] | None]] = {
    "elastic": (Contact(frame="", restitution=1.0, restitution_along="directions"), None),
    "damper, e = 0": (Contact(frame=""), "damper"),
    "hysteresis, e = 0": (Contact(frame=""), "hysteresis"),
}
"""Laws by which contacts lose energy."""

RATIOS = (0.5, 1.0, 2.0, 3.0, 5.0, 7.0, 10.0)
"""Tc f1: duration of contact with rigid links, times the first bending frequency.

The frequency is that of the free robot with its rotors.
"""

STIFFNESS = 1e5
"""Stiffness of the contacts [N/m].

With EI scaled to give Tc f1, it has no effect on what is compared.
"""


class Errors(NamedTuple):
    """Errors of rigid links, over what they give [1].

    Attributes:
        jump: change of the velocity of the base until the contact ends.
        acceleration: its maximum, of the base.
        force: maximum of the contact.
        torque: largest difference of the maximum along a joint, over the largest of all joints.
    """

    jump: float
    acceleration: float
    force: float
    torque: float


class RobotErrors(NamedTuple):
    """Errors of rigid links: robot, contact law, Tc f1, EI of the leg's links [N m²], errors."""

    robot: str
    law: str
    ratio: float
    EI: float
    errors: Errors


@functools.cache
def robot_study() -> tuple[RobotErrors, ...]:
    """The landings with each law, at each of `RATIOS`; the links from foot to base bend."""
    study = []
    for name, foot, drives in LANDINGS:
        for law in LAWS:
            study += _errors(name, foot, drives, law)
    return tuple(study)


def _errors(name: str, foot: str, drives: str | None, law: str) -> list[RobotErrors]:
    """Errors of rigid links of one landing, at each of `RATIOS`."""
    robot = load_robot(name)
    links, base = _leg(robot, foot)
    contact, contact_law = LAWS[law]
    scene = Scene(
        robot=name,
        contact=replace(contact, frame=foot),
        contact_law=contact_law,
        contact_stiffness=STIFFNESS,
        gravity=False,
        joints=Joints(drives=drives),
        point=(Point(frame=base),),
    )
    posed = resolve(scene, robot)
    # With one EI of all links f1 = unit √EI, and Tc = π/ω.
    bent = flexible_landing(posed, tuple((link, Flex(EI=1.0)) for link in links))
    unit = float(bent.elastic_frequencies()[0])
    duration = math.pi / (math.sqrt(STIFFNESS) * unit_frequency(posed))
    errors, rigid = [], _peaks(posed)
    for ratio in RATIOS:
        # Tc f1 = ratio
        EI = (ratio / (duration * unit)) ** 2
        bending = replace(scene, flex=dict.fromkeys(links, f"EI:{EI!r}"))
        difference = _relative_difference(_peaks(resolve(bending, robot)), rigid)
        errors.append(RobotErrors(name, law, ratio, EI, difference))
    return errors


def _leg(robot: Robot, foot: str) -> tuple[list[str], str]:
    """The links from a foot upwards, and the base, which bears them."""
    body, links = robot.frame(foot).body, list[str]()
    while robot.parents[body] >= 0:
        links.append(robot.bodies[body].name)
        body = robot.parents[body]
    return links, robot.bodies[body].name


def _peaks(posed: PosedLanding) -> LandingPeaks:
    """The results at the base, and at all joints."""
    return landing_peaks(CompliantLanding(posed), posed.places("point")[-1], posed.places("joint"))


def _relative_difference(peaks: LandingPeaks, rigid: LandingPeaks) -> Errors:
    """The differences from what rigid links give."""
    return Errors(
        jump=abs(peaks.jump - rigid.jump) / rigid.jump,
        acceleration=abs(peaks.acceleration - rigid.acceleration) / rigid.acceleration,
        force=abs(peaks.force - rigid.force) / rigid.force,
        torque=float(np.abs(peaks.along - rigid.along).max() / rigid.along.max()),
    )
