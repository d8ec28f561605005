"""Families on robots of example-robot-data."""

import functools
import re
from typing import Any

from shockpc.bench.cases.family import OBLIQUE, SLANTED, Family, on
from shockpc.model.contact import Contact
from shockpc.model.joint_model import Joints
from shockpc.model.posture import Posture
from shockpc.robot.robot import Robot, load_robot
from shockpc.scene import Scene

__all__ = ["ARMATURE", "DOUBLED", "FAR", "FOOTED", "LOCKED_FEET", "ROBOTS", "feet_of", "known_robot"]

FOOTED = (
    "a1", "alexander", "anymal_b", "anymal_b_kinova", "anymal_c", "b1", "b1_z1", "bolt", "g1", "go1", "go2", "human", "hyq", "icub",
    "icub_reduced", "laikago", "romeo", "romeo_laas_small", "romeo_small", "simple_humanoid", "solo12", "solo8", "talos",
    "talos_full", "talos_reduced_corrected",
)  # fmt: skip
"""Robots of example-robot-data with a link that is a foot."""

FOOT = re.compile(r"(_foot|_FOOT|_sole|_sole_link|ankle_roll_link|^[lr]_ankle)$")
ANYMAL_FEET = ("LF_FOOT", "RF_FOOT", "LH_FOOT", "RH_FOOT")


@functools.cache
def known_robot(name: str) -> Robot:
    """A robot by its name, loaded once."""
    return load_robot(name)


def feet_of(robot: Robot) -> tuple[str, ...]:
    """The links that are feet or soles, by their names."""
    found = tuple(link for link in robot.links if FOOT.search(link) and "virtual" not in link)
    soles = tuple(link for link in found if "sole" in link)
    return soles or found


def _robots(variant: str, name: str) -> tuple[Robot, Scene]:
    robot = known_robot(name)
    feet = feet_of(robot)
    return robot, Scene(robot=name, strike=SLANTED, contact=on(*(feet if variant == "all feet" else feet[:1])))


ROBOTS = Family(
    "robots",
    "robots of example-robot-data, with links without mass (romeo, human) and condition numbers up to 9e18 (icub)",
    "robot",
    ("one foot", "all feet"),
    FOOTED,
    _robots,
)


def _anymal(feet: int, **parts: Any) -> tuple[Robot, Scene]:
    """ANYmal B on some of its feet."""
    return known_robot("anymal_b"), Scene(robot="anymal_b", strike=SLANTED, contact=on(*ANYMAL_FEET[:feet]), **parts)


def _armature(variant: str, inertia: float) -> tuple[Robot, Scene]:
    return _anymal(1 if variant == "one foot" else 4, joints=Joints(armature={"*": inertia}))


ARMATURE = Family(
    "armature",
    "ANYmal B with drives from free to almost locked: large reflected inertias dominate the diagonal of H",
    "reflected inertia [kg m²]",
    ("one foot", "four feet"),
    (1e-18, 1e-3, 1e12),
    _armature,
)


def _locked_feet(variant: str, feet: int) -> tuple[Robot, Scene]:
    return _anymal(feet, joints=Joints(model="locked") if variant == "locked" else Joints(locked=("*HFE", "*KFE")))


LOCKED_FEET = Family(
    "locked feet",
    "ANYmal B with locked joints on several feet: up to twelve rows on a mechanism with six to ten degrees of freedom",
    "feet [-]",
    ("locked", "hips free"),
    (1, 2, 4),
    _locked_feet,
)


def _far(_: str, away: float) -> tuple[Robot, Scene]:
    return _anymal(1, posture=Posture(base_position=(away, -0.3 * away, 0.5)))


FAR = Family(
    "far from the origin",
    "ANYmal B far from the origin of the world: velocities written there multiply every rotation by the distance",
    "distance [m]",
    ("one foot",),
    (1e6, 1e9),
    _far,
)


def _doubled(_: str, apart: float) -> tuple[Robot, Scene]:
    contact = (*on("LF_FOOT", "RH_FOOT"), Contact(frame="LF_FOOT", offset=(apart, 0.0, 0.0)))
    return known_robot("anymal_b"), Scene(robot="anymal_b", strike=OBLIQUE, contact=contact)


DOUBLED = Family(
    "doubled contact",
    "a foot of ANYmal B that strikes with two points: they stop a rotation by rows that differ only by their distance",
    "distance [m]",
    ("with another foot",),
    (1e-8, 1e-5, 1e-2),
    _doubled,
)
