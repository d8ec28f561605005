"""Inertias: drives from free to locked, links with next to no mass, and the units they are written in."""

import functools

import numpy as np

from shockpc.bench.build import Link, box, robot_of, rod
from shockpc.bench.cases.chains import OBLIQUE, chain
from shockpc.bench.cases.family import Family
from shockpc.model.contact import Contact
from shockpc.model.joint_model import Joints
from shockpc.model.posture import Posture
from shockpc.robot.robot import Robot, load_robot
from shockpc.scene import Scene, Strike

__all__ = ["ARMATURE", "LIGHT", "UNITS"]

DECADES = tuple(10.0**k for k in range(-8, 9))


@functools.cache
def _known(name: str) -> Robot:
    return load_robot(name)


def _armature(variant: str, inertia: float) -> tuple[Robot, Scene]:
    robot = _known("anymal_b")
    feet = ("LF_FOOT",) if variant == "one foot" else ("LF_FOOT", "RF_FOOT", "LH_FOOT", "RH_FOOT")
    contact = tuple(Contact(frame=foot) for foot in feet)
    strike = Strike(speed=1.0, strike_angle_deg=20.0)
    return robot, Scene(robot="anymal_b", strike=strike, contact=contact, joints=Joints(armature={"*": inertia}))


ARMATURE = Family(
    name="armature",
    title="ANYmal B, its drives from free towards locked",
    hard="large reflected inertias drown the links in H's diagonal; on four feet the rows then all but repeat one another",
    parameter="reflected inertia [kg m²]",
    variants=("one foot", "four feet"),
    values=DECADES,
    quick=(1e-8, 1e-2, 1e4, 1e8),
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
    title="A leg with a link of next to no mass",
    hard="a body without mass can do anything: nearly without, its motion is the quotient of two roundings",
    parameter="mass of the link [kg]",
    variants=("ankle", "toe", "arm"),
    values=(0.0, 1e-15, *(10.0**k for k in range(-14, 1, 2))),
    quick=(0.0, 1e-15, 1e-8, 1e-2),
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
    title="One robot written in metres, millimetres and micrometres, in kilograms, grams and tonnes",
    hard="masses and moments of inertia stand in one matrix, so their units set its scaling and its condition number",
    parameter="units of length in a metre [-]",
    variants=("kg", "g", "t"),
    values=(1e-3, 1.0, 1e3, 1e6),
    quick=(1.0, 1e3),
    build=_units,
)
