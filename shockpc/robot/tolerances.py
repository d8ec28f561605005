"""Limits of the numbers of a robot: their size, and inertias that no body has."""

from collections.abc import Mapping

import numpy as np

from shockpc.core.spatial import Array
from shockpc.text.errors import RobotError

LINKS = 2000
LEVELS = 600
LIMIT_SLACK = 1e-4  # rad, m; lets a posture rest on a limit that a file states in rounded decimals
_LIGHTEST = 1e-15  # kg; below 2e-16 Pinocchio moves the centre of mass towards the link's origin
_LARGEST = 1e24  # kg, m, kg m²; a robot in grams and micrometres stays below
# two principal moments against the third: what is left for numbers that were rounded to two digits
_FLAT = 0.99
_NOTHING = 1e-9  # relative to the largest principal moment
# m²; a radius of gyration of a micrometre, beyond which moments are left over by an exporter
POINT = 1e-12


def refuse_number(subject: str, quantity: str, value: float, unit: str) -> None:
    """Refuse a number whose magnitude is above 1e24, or a mass [kg] other than 0 below 1e-15 kg.

    `subject` and `quantity` name it.

    Raises:
        RobotError: with the element and the number.
    """
    if not abs(value) <= _LARGEST or (unit == "kg" and 0.0 < value < _LIGHTEST):
        raise RobotError(
            f"{subject}: {quantity} is {value:g} {unit}, which cannot be computed with; give "
            f"numbers up to {_LARGEST:g}, and masses of at least {_LIGHTEST:g} kg, or 0"
        )


def refuse_count(links: int) -> None:
    """Refuse more than 2000 links.

    Raises:
        RobotError: with their number.
    """
    if links > LINKS:
        raise RobotError(
            f"it has {links} links, and up to {LINKS} are read; leave out those that neither move "
            f"nor weigh"
        )


def refuse_tree(carriers: Mapping[str, str]) -> None:
    """Refuse more than 2000 links, or more than 600 that hang on one another.

    Args: carriers: of each link, "" for none, in order.

    Raises:
        RobotError: with the number of links, or the first link of level 601.
    """
    refuse_count(len(carriers))
    level = {"": 0}
    for link, carrier in carriers.items():
        level[link] = level[carrier] + 1
        if level[link] > LEVELS:
            raise RobotError(
                f'link "{link}" is the end of a chain of more than {LEVELS} links, which is not '
                f"computed"
            )


def negative_moment(mass: float, inertia: Array) -> bool:
    """True if a principal moment of an inertia (3, 3) [kg m²] is negative.

    It is so by more than the rounding of a mass [kg] leaves.
    """
    least, _, most = np.linalg.eigvalsh(inertia).tolist()
    return _below_zero(mass, least, most)


def _below_zero(mass: float, least: float, most: float) -> bool:
    return least < -max(_NOTHING * abs(most), POINT * mass)


def inertia_fault(mass: float, inertia: Array) -> str | None:
    """Say why no body has this inertia (3, 3) about its centre of mass [kg m²]; None if one can.

    The body's mass is above zero [kg].
    """
    least, middle, most = np.linalg.eigvalsh(inertia).tolist()
    if max(abs(least), abs(most)) < POINT * mass:
        return "the inertia is zero, that of a point"
    if (inertia == inertia[0, 0]).all():
        return (
            f"all six entries of the inertia are {inertia[0, 0]:g} kg m², which no body has; they "
            f"look like a placeholder"
        )
    moments = f"the principal moments are {least:.3g}, {middle:.3g} and {most:.3g} kg m²"
    if _below_zero(mass, least, most):
        return f"{moments}, and no body has a negative one"
    if least + middle < _FLAT * most:
        return f"{moments}, and no body has one above the sum of the other two"
    return None
