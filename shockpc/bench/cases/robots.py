"""Real robots: every one of example-robot-data that has a foot, and one that stands far from the origin."""

import functools
import re

from shockpc.bench.cases.family import Family
from shockpc.model.contact import Contact
from shockpc.model.joint_model import Joints
from shockpc.model.posture import Posture
from shockpc.robot.robot import Robot, load_robot
from shockpc.scene import Scene, Strike

__all__ = ["FAR", "FOOTED", "ROBOTS", "feet_of"]

FOOTED = (
    "a1", "alexander", "anymal_b", "anymal_b_kinova", "anymal_c", "b1", "b1_z1", "bolt", "g1", "go1", "go2", "human", "hyq", "icub",
    "icub_reduced", "laikago", "romeo", "romeo_laas_small", "romeo_small", "simple_humanoid", "solo12", "solo8", "talos",
    "talos_full", "talos_reduced_corrected",
)  # fmt: skip
"""Robots of example-robot-data with a link that is a foot."""

FOOT = re.compile(r"(_foot|_FOOT|_sole|_sole_link|ankle_roll_link|^[lr]_ankle)$")


@functools.cache
def _known(name: str) -> Robot:
    return load_robot(name)


def feet_of(robot: Robot) -> tuple[str, ...]:
    """The links that are feet or soles, by their names."""
    found = tuple(link for link in robot.links if FOOT.search(link) and "virtual" not in link)
    soles = tuple(link for link in found if "sole" in link)
    return soles or found


def _robots(variant: str, number: float) -> tuple[Robot, Scene]:
    name = FOOTED[int(number)]
    robot = _known(name)
    feet = feet_of(robot)
    struck = feet if variant.startswith("all feet") else feet[:1]
    joints = Joints(model="locked") if variant.endswith("locked") else Joints()
    strike = Strike(speed=1.0, strike_angle_deg=20.0)
    return robot, Scene(robot=name, strike=strike, contact=tuple(Contact(frame=foot) for foot in struck), joints=joints)


ROBOTS = Family(
    name="robots",
    title="Every robot of example-robot-data that has a foot",
    hard="real files: links without mass (romeo, human), inertias that are not physical, cond(H) up to 9e18 (icub)",
    parameter="robot",
    variants=("one foot", "all feet", "all feet, joints locked"),
    values=tuple(range(len(FOOTED))),
    quick=tuple(FOOTED.index(name) for name in ("anymal_b", "icub", "romeo", "solo12", "talos")),
    build=_robots,
    labels=FOOTED,
)


def _far(variant: str, away: float) -> tuple[Robot, Scene]:
    posture = Posture(base_position=(away, -0.3 * away, 0.5))
    contact = tuple(Contact(frame=foot) for foot in (("LF_FOOT",) if variant == "one foot" else ("LF_FOOT", "RH_FOOT")))
    return _known("anymal_b"), Scene(
        robot="anymal_b", posture=posture, strike=Strike(speed=1.0, strike_angle_deg=20.0), contact=contact
    )


FAR = Family(
    name="far from the origin",
    title="ANYmal B standing so far from the world's origin",
    hard="a method that writes its velocities at the world's origin multiplies every rotation by the distance",
    parameter="distance [m]",
    variants=("one foot", "two feet"),
    values=(0.0, 1.0, 1e3, 1e6, 1e9),
    quick=(0.0, 1e3, 1e9),
    build=_far,
)
