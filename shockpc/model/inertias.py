"""Which inertias no body can have: the tensors that a robot file writes down, read one by one."""

from collections.abc import Iterator
from typing import NamedTuple
from xml.etree.ElementTree import Element

from shockpc.files.urdf_numbers import INERTIA, ROUNDING, vector

__all__ = ["Written", "inertia_fault", "written_inertias"]

_FLAT = 0.99  # two principal moments against the third: what is left for numbers that were rounded to two digits
_NOTHING = 1e-9  # relative to the largest principal moment


class Written(NamedTuple):
    """An inertia as written.

    Attributes:
        link: the link, or the MJCF body.
        mass: [kg]
        entries: ixx, ixy, ixz, iyy, iyz, izz about the centre of mass [kg m²].
    """

    link: str
    mass: float
    entries: tuple[float, ...]


def written_inertias(root: Element) -> Iterator[Written]:
    """Yield the inertia of every link or body that has one and weighs something.

    Args:
        root: a checked <robot> or <mujoco> element.
    """
    for link in (*root.iter("link"), *root.iter("body")):
        inertial = link.find("inertial")
        if inertial is None:
            continue
        name, mass, inertia = link.get("name", ""), inertial.find("mass"), inertial.find("inertia")
        if mass is not None and inertia is not None:
            found = Written(name, float(mass.get("value", "0")), tuple(float(inertia.get(key, "0")) for key in INERTIA))
        else:
            xx, yy, zz, xy, xz, yz = vector(inertial.get("fullinertia"), 6) or (
                *(vector(inertial.get("diaginertia"), 3) or (0.0, 0.0, 0.0)),
                *(0.0, 0.0, 0.0),
            )
            found = Written(name, float(inertial.get("mass", "0")), (xx, xy, xz, yy, yz, zz))
        if found.mass > 0:
            yield found


def inertia_fault(entries: tuple[float, ...]) -> str | None:
    """Say why no body of positive mass has this inertia about its centre of mass; None if one can.

    A body's principal moments are all positive, and none exceeds the sum of the other two.

    Args:
        entries: ixx, ixy, ixz, iyy, iyz, izz [kg m²].
    """
    import numpy as np

    xx, xy, xz, yy, yz, zz = entries
    if max(map(abs, entries)) < ROUNDING:
        return "the inertia is zero, that of a point"
    if len(set(entries)) == 1:
        return f"all six entries of the inertia are {xx:g} kg m², which no body has; they look like a stand-in"
    least, middle, most = (float(moment) for moment in np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))
    moments = f"the principal moments are {least:.3g}, {middle:.3g} and {most:.3g} kg m²"
    if least < -_NOTHING * abs(most):
        return f"{moments}, and no body has a negative one"
    if least + middle < _FLAT * most:
        return f"{moments}, and no body has one above the sum of the other two"
    return None
