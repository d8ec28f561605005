"""Which inertias no body can have: of the tensors that a robot file writes down, and of the bodies that they add up to."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple
from xml.etree.ElementTree import Element

import numpy as np

from shockpc.core.spatial import Array
from shockpc.errors import RobotError
from shockpc.robot.source import RobotSource
from shockpc.robot.urdf_numbers import INERTIA

__all__ = ["Written", "inertia_fault", "inertia_warning", "refuse_extremes", "written_inertias"]

_FLAT = 0.99  # two principal moments against the third: what is left for numbers that were rounded to two digits
_NOTHING = 1e-9  # relative to the largest principal moment
_POINT = 1e-12  # m²; a radius of gyration of a micrometre, beyond which moments are left over by an exporter
_LIGHTEST = float(np.finfo(float).eps)  # kg; below it Pinocchio loses where the centre of mass is
_LARGEST = 1e24  # kg, kg m², in whatever unit: a robot in grams and micrometres stays below; squares have numbers
_ZERO = "the inertia is zero, that of a point"


class Written(NamedTuple):
    """An inertia as written.

    Attributes:
        link: the link.
        mass: [kg]
        entries: ixx, ixy, ixz, iyy, iyz, izz about the centre of mass [kg m²].
    """

    link: str
    mass: float
    entries: tuple[float, ...]


def written_inertias(root: Element) -> Iterator[Written]:
    """Yield the inertia of every link that has one and weighs something.

    Args:
        root: a checked <robot> element.
    """
    for link in root.iter("link"):
        mass, inertia = link.find("inertial/mass"), link.find("inertial/inertia")
        if mass is not None and inertia is not None and float(mass.get("value", "0")) > 0:
            entries = tuple(float(inertia.get(key, "0")) for key in INERTIA)
            yield Written(link.get("name", ""), float(mass.get("value", "0")), entries)


def inertia_fault(mass: float, entries: tuple[float, ...]) -> str | None:
    """Say why no body has this inertia about its centre of mass; None if one can.

    Args:
        mass: above zero [kg].
        entries: ixx, ixy, ixz, iyy, iyz, izz [kg m²].
    """
    xx, xy, xz, yy, yz, zz = entries
    fault = _fault(mass, np.linalg.eigvalsh(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])))
    if len(set(entries)) == 1 and fault != _ZERO:
        return f"all six entries of the inertia are {xx:g} kg m², which no body has; they look like a stand-in"
    return fault


def inertia_warning(
    source: RobotSource, names: Sequence[str], masses: Sequence[float], inertias: Sequence[Array]
) -> tuple[str, ...]:
    """One line for all bodies whose inertia no body has; none if all are sound.

    Args:
        source: the robot as read.
        names: of the bodies, each with all that is fixed to it.
        masses: [kg]
        inertias: (3, 3) about the centres of mass [kg m²].
    """
    odd = []
    for name, mass, moments in zip(names, masses, np.linalg.eigvalsh(np.stack(inertias)), strict=True):
        if mass > 0 and _fault(mass, moments):
            shown = ", ".join(f"{moment if abs(moment) > _POINT * mass else 0.0:.3g}" for moment in moments)
            odd.append(f'"{name}" ({shown} kg m²)')
    if not odd:
        return ()
    listed = ", ".join(odd[:4]) + (f" and {len(odd) - 4} more" if len(odd) > 4 else "")
    return (
        f"{source.path.name}: no body has such principal moments: {listed}. None can be negative or above the sum of the other "
        "two, and not all can be zero; shock is computed from them all the same. Correct the file; the links at fault: "
        f"shockpc robots {source.name or source.path}",
    )


def refuse_extremes(source: RobotSource, names: Sequence[str], masses: Sequence[float], inertias: Sequence[Array]) -> None:
    """Refuse masses and inertias that cannot be computed with. Arguments as for `inertia_warning`.

    Raises:
        RobotError: a body is too heavy, or so light that its centre of mass would be lost.
    """
    for name, mass, inertia in zip(names, masses, inertias, strict=True):
        if 0.0 < mass < _LIGHTEST:
            raise RobotError(
                f'{source.path.name}: body "{name}" weighs {mass:.3g} kg, and below {_LIGHTEST:.2g} kg its centre of mass is lost '
                "in reading; give it the mass that it has, or 0"
            )
        if max(mass, float(np.abs(inertia).max())) > _LARGEST:
            raise RobotError(
                f'{source.path.name}: body "{name}" weighs {mass:.3g} kg and has moments of inertia up to '
                f"{float(np.abs(inertia).max()):.3g} kg m², which cannot be computed with; give numbers up to {_LARGEST:g}"
            )


def _fault(mass: float, moments: Array) -> str | None:
    """Why no body of this mass has these principal moments, in rising order: all are positive, none above the sum of the others."""
    least, middle, most = (float(moment) for moment in moments)
    if max(abs(least), abs(most)) < _POINT * mass:
        return _ZERO
    shown = f"the principal moments are {least:.3g}, {middle:.3g} and {most:.3g} kg m²"
    if least < -_NOTHING * abs(most):
        return f"{shown}, and no body has a negative one"
    if least + middle < _FLAT * most:
        return f"{shown}, and no body has one above the sum of the other two"
    return None
