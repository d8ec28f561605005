"""Robots of example-robot-data that have feet, and one far from the origin of the world."""

import re

from shockpc.bench.cases.family import Family, known_robot
from shockpc.model.contact import Contact
from shockpc.model.posture import Posture
from shockpc.robot.robot import Robot
from shockpc.scene import Scene, Strike

__all__ = ["FAR", "FOOTED", "ROBOTS", "feet_of"]

FOOTED = (
    "a1", "alexander", "anymal_b", "anymal_b_kinova", "anymal_c", "b1", "b1_z1", "bolt", "g1", "go1", "go2", "human", "hyq", "icub",
    "icub_reduced", "laikago", "romeo", "romeo_laas_small", "romeo_small", "simple_humanoid", "solo12", "solo8", "talos",
    "talos_full", "talos_reduced_corrected",
)  # fmt: skip
"""Robots of example-robot-data with a link that is a foot."""

FOOT = re.compile(r"(_foot|_FOOT|_sole|_sole_link|ankle_roll_link|^[lr]_ankle)$")


def feet_of(robot: Robot) -> tuple[str, ...]:
    """The links that are feet or soles, by their names."""
    found = tuple(link for link in robot.links if FOOT.search(link) and "virtual" not in link)
    soles = tuple(link for link in found if "sole" in link)
    return soles or found


def _robots(variant: str, number: float) -> tuple[Robot, Scene]:
    name = FOOTED[int(number)]
    robot = known_robot(name)
    feet = feet_of(robot)
    struck = feet if variant == "all feet" else feet[:1]
    strike = Strike(speed=1.0, strike_angle_deg=20.0)
    return robot, Scene(robot=name, strike=strike, contact=tuple(Contact(frame=foot) for foot in struck))


ROBOTS = Family(
    name="robots",
    title="Robots of example-robot-data",
    hard="links without mass (romeo, human), inertias that are not physical, condition numbers up to 9e18 (icub)",
    parameter="robot",
    variants=("one foot", "all feet"),
    values=tuple(range(len(FOOTED))),
    build=_robots,
    labels=FOOTED,
)


def _far(variant: str, away: float) -> tuple[Robot, Scene]:
    posture = Posture(base_position=(away, -0.3 * away, 0.5))
    contact = tuple(Contact(frame=foot) for foot in (("LF_FOOT",) if variant == "one foot" else ("LF_FOOT", "RH_FOOT")))
    return known_robot("anymal_b"), Scene(
        robot="anymal_b", posture=posture, strike=Strike(speed=1.0, strike_angle_deg=20.0), contact=contact
    )


FAR = Family(
    name="far from the origin",
    title="ANYmal B far from the origin of the world",
    hard="a method that writes its velocities at the world's origin multiplies every rotation by the distance",
    parameter="distance [m]",
    variants=("one foot", "two feet"),
    values=(0.0, 1e3, 1e6, 1e9),
    build=_far,
)
