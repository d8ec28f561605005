"""Contacts: dependent rows, and a strike near the centre of mass."""

import functools

import numpy as np

from shockpc.bench.build import Link, box, robot_of, rod
from shockpc.bench.cases.chains import OBLIQUE
from shockpc.bench.cases.family import Axis, Family, known_robot
from shockpc.model.contact import Contact
from shockpc.model.joint_model import Joints
from shockpc.robot.robot import Robot
from shockpc.scene import Scene, Strike

__all__ = ["CORNERS", "DOUBLED", "LOCKED_FEET", "THROUGH_COM"]

FEET = ("LF_FOOT", "RF_FOOT", "LH_FOOT", "RH_FOOT")


@functools.cache
def _brick() -> Robot:
    body = Link(-1, "", np.zeros(3), np.eye(3)[1], 7.0, np.array([0.02, 0.01, 0.03]), box(7.0, (0.6, 0.4, 0.2)))
    com, inertia = rod(1.0, np.array([0.0, 0.0, 0.4]))
    mast = Link(0, "revolute", np.array([0.1, 0.05, 0.1]), np.array([0.6, 0.8, 0.0]), 1.0, com, inertia)
    return robot_of([body, mast], "brick")


def _corners(variant: str, n: float) -> tuple[Robot, Scene]:
    corners = [(x, y, z) for z in (-0.1, 0.1) for x in (-0.3, 0.3) for y in (-0.2, 0.2)]
    kept: tuple[Axis, ...] = ("x", "y", "z") if variant == "sticking" else ("z",)
    contact = tuple(Contact(frame="link0", offset=corner, directions=kept) for corner in corners[: int(n)])
    return _brick(), Scene(robot="brick", strike=OBLIQUE, contact=contact)


CORNERS = Family(
    name="corners",
    title="A box with a mast that lands on several corners at once",
    hard="a rigid body has six degrees of freedom: from the third corner on rows are dependent and the KKT matrix is singular",
    parameter="corners [-]",
    variants=("sticking", "sliding"),
    values=(1, 3, 4, 8),
    build=_corners,
)


def _locked_feet(variant: str, n: float) -> tuple[Robot, Scene]:
    contact = tuple(Contact(frame=foot) for foot in FEET[: int(n)])
    joints = Joints(model="locked") if variant == "locked" else Joints(locked=("*HFE", "*KFE"))
    strike = Strike(speed=1.0, strike_angle_deg=10.0)
    return known_robot("anymal_b"), Scene(robot="anymal_b", strike=strike, contact=contact, joints=joints)


LOCKED_FEET = Family(
    name="locked feet",
    title="ANYmal B with locked joints on several feet",
    hard="twelve rows on a mechanism with six to ten degrees of freedom",
    parameter="feet [-]",
    variants=("locked", "hips free"),
    values=(1, 2, 4),
    build=_locked_feet,
)


def _doubled(variant: str, apart: float) -> tuple[Robot, Scene]:
    robot = known_robot("anymal_b")
    contact = [Contact(frame="LF_FOOT"), Contact(frame="LF_FOOT", offset=(apart, 0.0, 0.0))]
    if variant == "with another foot":
        contact.append(Contact(frame="RH_FOOT"))
    return robot, Scene(robot="anymal_b", strike=OBLIQUE, contact=tuple(contact))


DOUBLED = Family(
    name="doubled contact",
    title="One foot that strikes with two points at a small distance",
    hard="two close points stop a rotation by rows that differ only by their distance",
    parameter="distance [m]",
    variants=("alone", "with another foot"),
    values=(1e-8, 1e-5, 1e-2),
    build=_doubled,
)


@functools.cache
def _rods(n: int) -> Robot:
    along = np.array([0.0, 0.0, 1.0])
    return robot_of([Link(i - 1, "revolute", along if i else np.zeros(3), np.eye(3)[1], 1.0, *rod(1.0, along)) for i in range(n)])


def _through_com(variant: str, distance: float) -> tuple[Robot, Scene]:
    robot = _rods({"one rod": 1, "two rods in line": 2}[variant])
    # The rods stand upright and are struck from below; the contact lies beside their axis by the distance.
    contact = Contact(frame="link0", offset=(distance, 0.0, 0.0))
    return robot, Scene(robot="rods", contact=(contact,))


THROUGH_COM = Family(
    name="through the centre",
    title="A strike that passes the centre of mass at a small distance",
    hard="the body almost only translates: centre and radius of percussion tend to infinity",
    parameter="distance over length [-]",
    variants=("one rod", "two rods in line"),
    values=(0.0, 1e-16, 1e-12, 1e-9, 1e-6, 1.0),
    build=_through_com,
)
