"""Inertias: drives from free to locked, links of very small mass, and units."""

import functools

import numpy as np

from shockpc.bench.build import Link, box, robot_of, rod
from shockpc.bench.cases.chains import OBLIQUE, chain
from shockpc.bench.cases.family import Family, known_robot
from shockpc.model.contact import Contact
from shockpc.model.joint_model import Joints
from shockpc.model.posture import Posture
from shockpc.robot.robot import Robot
from shockpc.scene import Scene, Strike

__all__ = ["ARMATURE", "LIGHT", "UNITS"]


def _armature(variant: str, inertia: float) -> tuple[Robot, Scene]:
    robot = known_robot("anymal_b")
    feet = ("LF_FOOT",) if variant == "one foot" else ("LF_FOOT", "RF_FOOT", "LH_FOOT", "RH_FOOT")
    contact = tuple(Contact(frame=foot) for foot in feet)
    strike = Strike(speed=1.0, strike_angle_deg=20.0)
    return robot, Scene(robot="anymal_b", strike=strike, contact=contact, joints=Joints(armature={"*": inertia}))


ARMATURE = Family(
    name="armature",
    title="ANYmal B with drives from free to almost locked",
    hard="large reflected inertias dominate the diagonal of H; on four feet the rows then are almost dependent",
    parameter="reflected inertia [kg m²]",
    variants=("one foot", "four feet"),
    values=(1e-18, 1e-9, 1e-3, 1e3, 1e12),
    build=_armature,
)


@functools.cache
def _light(variant: str, mass: float) -> Robot:
    along = np.array([0.0, 0.0, -0.3])
    masses = {"ankle": (3.0, mass, 0.5), "toe": (3.0, 1.0, mass), "arm": (3.0, 1.0, 0.5)}[variant]
    links = [Link(-1, "", np.zeros(3), np.eye(3)[1], 10.0, np.array([0.0, 0.0, 0.1]), box(10.0, (0.4, 0.3, 0.2)))]
    for i, m in enumerate(masses):
        axis = np.array([0.0, 0.6, 0.8]) if i == 1 else np.eye(3)[1]
        com, inertia = rod(m, along) if m > 0.0 else (0.5 * along, np.zeros((3, 3)))
        links.append(Link(i, "revolute", along if i else np.zeros(3), axis, m, com, inertia))
    if variant == "arm":
        com, inertia = rod(mass, -along) if mass > 0.0 else (-0.5 * along, np.zeros((3, 3)))
        links.append(Link(0, "revolute", np.array([0.1, 0.0, 0.1]), np.eye(3)[0], mass, com, inertia))
    return robot_of(links, "light")


def _light_case(variant: str, mass: float) -> tuple[Robot, Scene]:
    robot = _light(variant, mass)
    posture = Posture(joints={"joint1": 0.4, "joint2": -0.9, "joint3": 0.6})
    contact = Contact(frame="link3", offset=(0.0, 0.0, -0.3))
    return robot, Scene(robot="light", posture=posture, strike=OBLIQUE, contact=(contact,))


LIGHT = Family(
    name="light link",
    title="A leg with a link of very small mass",
    hard="the motion of a body without mass is not determined; with almost none it is a quotient of rounding errors",
    parameter="mass of the link [kg]",
    variants=("ankle", "toe", "arm"),
    values=(0.0, 1e-12, 1e-8, 1e-4, 1.0),
    build=_light_case,
)


@functools.cache
def _scaled(length: float, mass: float) -> Robot:
    return chain(mass * np.array([8.0, 2.0, 1.0, 3.0, 0.5]), length * np.array([0.5, 0.3, 0.2, 0.4, 0.1]))


def _units(variant: str, length: float) -> tuple[Robot, Scene]:
    robot = _scaled(length, {"kg": 1.0, "g": 1e3, "t": 1e-3}[variant])
    joints = {f"joint{i}": angle for i, angle in enumerate((0.7, -0.9, 0.5, 1.1), start=1)}
    contact = Contact(frame="link4", offset=(0.0, 0.0, 0.1 * length))
    x, y, z = OBLIQUE.velocity or (0.0, 0.0, -1.0)
    strike = Strike(velocity=(x * length, y * length, z * length))
    return robot, Scene(robot="chain", posture=Posture(joints=joints), strike=strike, contact=(contact,))


UNITS = Family(
    name="units",
    title="One robot in other units of length and mass",
    hard="masses and moments of inertia are entries of one matrix, so the units set its condition number",
    parameter="units of length in one metre [-]",
    variants=("kg", "g", "t"),
    values=(1e-3, 1.0, 1e3, 1e4),
    build=_units,
)
