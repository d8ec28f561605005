"""Robots whose legs bend: errors of rigid links.

They are over the duration of contact and the first bending frequency.
"""

import functools
import math
from dataclasses import replace
from typing import Literal, NamedTuple

import numpy as np

from shockpc import Contact, Joints, Point, Scene, load_robot
from shockpc.impact.contact_rows import contact_rows
from shockpc.landing.resolve import resolve
from shockpc.quantities.of_contacts import IMPULSE
from shockpc.quantities.of_joints import JOINTS
from shockpc.quantities.of_points import point_velocity
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


class Compared(NamedTuple):
    """Errors of rigid links: robot, contact law, Tc f1, EI of the leg's links [N m²], errors."""

    robot: str
    law: str
    ratio: float
    EI: float
    errors: Errors


@functools.cache
def robot_study() -> tuple[Compared, ...]:
    """The landings with each law, at each of `RATIOS`; the links from foot to base bend."""
    compared = []
    for landing in LANDINGS:
        for law in LAWS:
            compared += _compared(landing, law)
    return tuple(compared)


def _compared(landing: tuple[str, str, str | None], law: str) -> list[Compared]:
    """A landing with one law, at each of `RATIOS`. Args: landing, robot, foot and drives."""
    name, foot, drives = landing
    robot, (contact, contact_law) = load_robot(name), LAWS[law]
    body, links = robot.frame(foot).body, list[str]()
    # All links from the foot upwards bend, and the base does not.
    while robot.parents[body] >= 0:
        links.append(robot.bodies[body].name)
        body = robot.parents[body]
    scene = Scene(
        robot=name,
        contact=replace(contact, frame=foot),
        contact_law=contact_law,
        contact_stiffness=STIFFNESS,
        gravity=False,
        joints=Joints(drives=drives),
        point=(Point(frame=robot.bodies[body].name),),
    )
    posed = resolve(scene, robot)
    # With one EI of all links, f1 = unit √EI and Tc = π/ω.
    bent = flexible_landing(posed, tuple((link, Flex(EI=1.0)) for link in links))
    unit = float(bent.elastic_frequencies()[0])
    rows = contact_rows(posed, stands=True)
    omega = rows.frequency(np.full(len(rows.J), STIFFNESS), np.zeros((0, len(rows.M))))
    duration = math.pi / omega
    compared, rigid = [], _read(CompliantLanding(posed))
    for ratio in RATIOS:
        # Tc f1 = ratio with f1 = unit √EI.
        EI = (ratio / (duration * unit)) ** 2
        bending = replace(scene, flex=dict.fromkeys(links, f"EI:{EI!r}"))
        off = np.abs(_read(CompliantLanding(resolve(bending, robot))) - rigid)
        torque = float(off[3:].max() / rigid[3:].max())
        jump, acceleration, force = (off[:3] / rigid[:3]).tolist()
        errors = Errors(jump, acceleration, force, torque)
        compared.append(Compared(name, law, ratio, EI, errors))
    return compared


def _read(landing: CompliantLanding) -> np.ndarray:
    """Jump and largest acceleration of the base, largest contact force, and joint loads.

    These are the largest torques or forces along joints.
    """
    posed = landing.landing
    points = posed.places("point")[-1:]
    jump = np.linalg.norm(landing.ends(point_velocity, points)[0, 1], axis=-1)
    peaks = [
        landing.peaks(point_velocity, points),
        landing.peaks(IMPULSE.compute, posed.places("contact")),
    ]
    along = landing.peaks(JOINTS[2].compute, posed.places("joint"))
    return np.concatenate([jump, *(values for values, _ in (*peaks, along))])
