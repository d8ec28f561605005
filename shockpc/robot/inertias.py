"""Which inertias no body can have: positive principal moments, none above the sum of the other two."""

from collections.abc import Iterable
from typing import TypeAlias

import numpy as np

from shockpc.core.spatial import Array
from shockpc.errors import RobotError
from shockpc.robot.source import RobotSource

__all__ = ["LARGEST", "Weighed", "inertia_fault", "inertia_warning", "refuse_extremes"]

Weighed: TypeAlias = tuple[str, float, Array]
"""A body's name, its mass [kg] and its inertia (3, 3) about its centre of mass [kg m²]."""

_FLAT = 0.99  # two principal moments against the third: what is left for numbers that were rounded to two digits
_NOTHING = 1e-9  # relative to the largest principal moment
_POINT = 1e-12  # m²; a radius of gyration of a micrometre, beyond which moments are left over by an exporter
_LIGHTEST = float(np.finfo(float).eps)  # kg; below it Pinocchio loses where the centre of mass is
LARGEST = 1e24  # kg, kg m², in whatever unit: a robot in grams and micrometres stays below; squares have numbers


def inertia_fault(mass: float, inertia: Array) -> str | None:
    """Say why no body has this inertia about its centre of mass; None if one can.

    Args:
        mass: above zero [kg].
        inertia: (3, 3) [kg m²].
    """
    least, middle, most = (float(moment) for moment in np.linalg.eigvalsh(inertia))
    if max(abs(least), abs(most)) < _POINT * mass:
        return "the inertia is zero, that of a point"
    if (inertia == inertia[0, 0]).all():
        return f"all six entries of the inertia are {inertia[0, 0]:g} kg m², which no body has; they look like a placeholder"
    shown = f"the principal moments are {least:.3g}, {middle:.3g} and {most:.3g} kg m²"
    if least < -_NOTHING * abs(most):
        return f"{shown}, and no body has a negative one"
    if least + middle < _FLAT * most:
        return f"{shown}, and no body has one above the sum of the other two"
    return None


def inertia_warning(source: RobotSource, bodies: Iterable[Weighed]) -> tuple[str, ...]:
    """One line for all bodies whose inertia no body has; none if all are sound.

    Args:
        source: the robot as read.
        bodies: each with all that is fixed to it.
    """
    odd = []
    for name, mass, inertia in bodies:
        if mass > 0 and inertia_fault(mass, inertia):
            moments = np.linalg.eigvalsh(inertia)
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


def refuse_extremes(file: str, bodies: Iterable[Weighed]) -> None:
    """Refuse masses and inertias that cannot be computed with.

    Args:
        file: the file's name, for messages.
        bodies: each with all that is fixed to it.

    Raises:
        RobotError: a body is too heavy, or so light that its centre of mass would be lost.
    """
    for name, mass, inertia in bodies:
        if 0.0 < mass < _LIGHTEST:
            raise RobotError(
                f'{file}: body "{name}" weighs {mass:.3g} kg, and below {_LIGHTEST:.2g} kg its centre of mass is lost '
                "in reading; give it the mass that it has, or 0"
            )
        if not max(mass, float(np.abs(inertia).max())) <= LARGEST:
            raise RobotError(
                f'{file}: body "{name}" weighs {mass:.3g} kg and has moments of inertia up to '
                f"{float(np.abs(inertia).max()):.3g} kg m², which cannot be computed with; give numbers up to {LARGEST:g}"
            )
