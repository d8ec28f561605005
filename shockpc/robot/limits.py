"""How large a robot may be. Beyond it a file is broken, in the wrong units, or made to exhaust the computer."""

from collections.abc import Mapping

from shockpc.errors import RobotError

__all__ = ["LINKS", "refuse_drives", "refuse_number", "refuse_tree"]

LINKS = 2000  # URDF's parser recurses over links, and far beyond this it overruns its stack
_LEVELS = 600
_LIGHTEST = 1e-15  # kg; below 2e-16 Pinocchio moves the centre of mass towards the link's origin
_LARGEST = 1e24  # kg, m, kg m²; a robot in grams and micrometres stays below


def refuse_number(whose: str, what: str, value: float, unit: str) -> None:
    """Refuse a number whose magnitude is above 1e24, or a mass other than 0 below 1e-15 kg.

    Args:
        whose: the file and the element, for the message.
        what: the number's name.
        value: the number.
        unit: its unit; "kg" for a mass.

    Raises:
        RobotError: with the element and the number.
    """
    if not abs(value) <= _LARGEST or (unit == "kg" and 0.0 < value < _LIGHTEST):
        raise RobotError(
            f"{whose}: {what} is {value:g} {unit}, which cannot be computed with; give numbers up to {_LARGEST:g}, and masses "
            f"of at least {_LIGHTEST:g} kg, or 0"
        )


def refuse_drives(file: str, velocities: int, armature: float) -> None:
    """Refuse a robot with more than 606 velocities (a chain of 600 joints on a free base), or with a drive out of range.

    Args:
        file: the file's name, for messages.
        velocities: their number.
        armature: the greatest reflected inertia [kg m²].

    Raises:
        RobotError: with their number, or the greatest reflected inertia.
    """
    if velocities > _LEVELS + 6:  # Pinocchio's memory grows with the cube of their number: 14 GB for 606
        raise RobotError(
            f"{file} moves with {velocities} velocities, and up to {_LEVELS + 6} are computed; fix joints that do not matter"
        )
    refuse_number(file, "the greatest reflected inertia", armature, "kg m²")


def refuse_tree(file: str, carriers: Mapping[str, str]) -> None:
    """Refuse more than 2000 links, or more than 600 that hang on one another.

    Args:
        file: the file's name, for messages.
        carriers: the link that carries each link, in an order in which carriers come first; "" for none.

    Raises:
        RobotError: with the number of links, or the first link of level 601.
    """
    if len(carriers) > LINKS:
        raise RobotError(
            f"{file} has {len(carriers)} links, and up to {LINKS} are read; leave out those that neither move nor weigh"
        )
    level = {"": 0}
    for link, carrier in carriers.items():
        level[link] = level[carrier] + 1
        if level[link] > _LEVELS:
            raise RobotError(f'{file}: link "{link}" is the end of a chain of more than {_LEVELS} links, which is not computed')
