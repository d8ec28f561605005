"""The rounding of a robot file's angles and lengths.

By it the robot's mechanism may differ from the one that is meant.

CAD programs write a quarter turn as 1.5708 or 1.57, so joint axes that are meant to be parallel are
so to these digits only. A number near a multiple of 15 degrees within its last digit is taken as
that multiple; what is left of it is the rounding. Of other numbers with four decimals or more it is
half a unit in the last one; with fewer they are taken as meant.
"""

import math
from collections.abc import Iterator
from xml.etree.ElementTree import Element

import numpy as np

from shockpc.core.memo import memoized
from shockpc.core.spatial import Array
from shockpc.robot.bodies_and_joints import Joint
from shockpc.robot.files.reading import shared_xml
from shockpc.robot.robot import Robot

RESIDUE = 1e-5
"""Angles [rad], components of unit vectors [1] and lengths [m] below this are what rounding left of
zero: nobody means them.
"""

COARSE = 1e-4
"""`RESIDUE` for the entries of rotations of which the file's numbers are not read: a digit less, as
they add up.
"""

MEANT = 4
"""Decimals from which a number is rounded; one with fewer, and near no multiple of 15 degrees, is
meant as it is written.
"""

LEAST_DIFFERENCE = 1e-12
"""Difference of the length of a unit vector from 1 that is no rounding of double precision [1]."""

COSINES, HALF_COSINES = (np.cos(np.arange(n) * np.pi / (n - 1)) for n in (13, 25))
"""Cosines of multiples of 15 degrees, and of half of that, of which quaternions consist."""


@memoized()
def rounding_of(robot: Robot) -> Array:
    """Rounding (nb, 2) of every body's place against the one that carries it.

    By it the body may be turned [rad] and shifted [m].
    """
    above = _carriers(robot)
    moving = {body.name for body in robot.bodies}
    total = np.zeros((len(robot.bodies), 2))
    for k, (body, joint) in enumerate(zip(robot.bodies, robot.joints, strict=True)):
        link = body.name
        # What is fixed on the way to the body that carries it counts with its joint.
        while link in above and (link == body.name or link not in moving):
            link, size = above[link]
            total[k] += size
        if body.name not in above and robot.source.kind != "urdf":
            for part in joint.parts or (joint,):
                total[k] += _of_part(part)
    return total


def _carriers(robot: Robot) -> dict[str, tuple[str, Array]]:
    """The carrier of each link of a file, by name, and the rounding (2,) of its place there."""
    if robot.source.kind == "pinocchio":
        return {}
    root = shared_xml(robot.source.xml, robot.source.path.name)
    if robot.source.kind == "urdf":
        return {
            _end(joint, "child"): (_end(joint, "parent"), _of_joint(joint))
            for joint in root.findall("joint")
        }
    units = [part.get("angle") for part in root.iter("compiler") if part.get("angle")]
    return dict(_bodies(root, "", units[-1:] != ["radian"]))


def _of_part(joint: Joint) -> Array:
    """Rounding (2,) of a joint without a file, by its numbers."""
    turned = 0.0
    for values in (joint.rotation, joint.axis):
        near = 0.0 if values is None else _apart(values)
        turned += near if near < COARSE else 0.0
    offset = np.abs(joint.offset)
    return np.array([turned, offset[offset < RESIDUE].max(initial=0.0)])


def _bodies(
    element: Element, carrier: str, degrees: bool
) -> Iterator[tuple[str, tuple[str, Array]]]:
    """The carrier of each named body of an MJCF, and a rounding (2,).

    It is that of the body's placement and of its joints.
    """
    for part in element:
        name = part.get("name", "") if part.tag == "body" else ""
        if name:
            turned = length = 0.0
            for holder in (part, *part.findall("joint")):
                turned += _of_placement(holder, degrees)
                for text in holder.get("pos", "").split():
                    length = max(length, _of_length(text))
            yield name, (carrier, np.array([turned, length]))
        yield from _bodies(part, name or carrier, degrees)


def _of_placement(element: Element, degrees: bool) -> float:
    """Rounding of the orientation of a body, or of the axis of a joint, of an MJCF [rad]."""
    quat, euler, angled, axes, axis, zaxis = (
        element.get(key, "").split()
        for key in ("quat", "euler", "axisangle", "xyaxes", "axis", "zaxis")
    )
    turned = sum(_of_angle(text, degrees) for text in (*euler, *angled[3:]))
    turned += sum(map(_of_direction, (axis, zaxis, angled[:3], axes[:3], axes[3:])))
    # The angle is twice that of which a quaternion has the cosine and the sine; nobody means its
    # third decimal.
    return turned + 2.0 * _of_direction(quat, HALF_COSINES, MEANT - 1)


def _apart(values: Array, cosines: Array = COSINES) -> float:
    """Largest distance of cosines from those of multiples of 15 degrees."""
    distances = np.abs(values[..., None] - cosines)
    return float(distances.min(axis=-1).max())


def _end(joint: Element, tag: str) -> str:
    return next((part.get("link", "") for part in joint.findall(tag)), "")


def _of_joint(joint: Element) -> Array:
    """Rounding (2,) of the placement and the axis of one joint of a URDF [rad, m]."""
    origin, axis = joint.find("origin"), joint.find("axis")
    rpy, xyz = ("", "") if origin is None else (origin.get("rpy", ""), origin.get("xyz", ""))
    turned = sum(_of_angle(text) for text in rpy.split())
    turned += 0.0 if axis is None else _of_direction(axis.get("xyz", "").split())
    return np.array([turned, max(map(_of_length, xyz.split()), default=0.0)])


def _decimals(text: str) -> int:
    """The number of decimals of a number, without zeros at its end."""
    from decimal import Decimal  # which few mechanisms need

    exponent = Decimal(text).normalize().as_tuple().exponent
    return max(-exponent, 0) if isinstance(exponent, int) else 0


def _of_angle(text: str, degrees: bool = False) -> float:
    """Rounding of an angle [rad]."""
    decimals = _decimals(text)
    value, unit, meant = float(text), 10.0**-decimals, MEANT
    step = math.pi / 12.0
    if degrees:
        value, unit, meant = math.radians(value), unit * math.radians(1.0), MEANT - 2
    elif decimals == 1:
        # Of numbers with one decimal every fourth is near a multiple of 15 degrees, so only
        # quarter turns count.
        step, unit = math.pi / 2.0, 0.05
    near = abs(math.remainder(value, step))
    if decimals and near < max(unit, RESIDUE):
        return near
    return unit / 2.0 if decimals >= meant else 0.0


def _of_direction(texts: list[str], cosines: Array = COSINES, meant: int = MEANT) -> float:
    """Rounding of an axis [rad]."""
    decimals = max(map(_decimals, texts), default=0)
    values = np.array([float(text) for text in texts])
    length = float(np.linalg.norm(values))
    if not decimals or not length:
        return 0.0
    near = _apart(values / length, cosines)
    unit = 10.0**-decimals / length
    if decimals > 1 and near < max(unit, RESIDUE):
        return near
    # Of a unit vector with few decimals the length tells whether they are all of it: (0.6, 0.8, 0)
    # is, (0.433, 0.75, 0.5) is not.
    nearly_unit = LEAST_DIFFERENCE < abs(length - 1.0) < 2.0 * 10.0**-decimals
    rounded = decimals >= meant or (decimals > 1 and nearly_unit)
    return unit / 2.0 if rounded else 0.0


def _of_length(text: str) -> float:
    """Rounding of a length [m]."""
    decimals, value = _decimals(text), abs(float(text))
    if value < RESIDUE:
        return value
    return 0.5 * 10.0**-decimals if decimals >= MEANT else 0.0
