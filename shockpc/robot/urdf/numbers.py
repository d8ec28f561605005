"""Numbers and places in the elements of a URDF."""

from collections.abc import Iterable
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin

from shockpc.core.number import number_from
from shockpc.core.spatial import Array
from shockpc.robot.tolerances import refuse_number
from shockpc.text.errors import RobotError
from shockpc.text.printed import listed


def finite_numbers(text: str | None, size: int) -> Array | None:
    """So many finite numbers (size,), separated by blanks; None if the text is anything else."""
    try:
        values = [number_from(word) for word in (text or "").split()]
    except ValueError:
        return None
    return np.array(values) if len(values) == size else None


def numbers(
    subject: str,
    owner: Element,
    tag: str,
    key: str,
    default: str = "",
    unit: str = "",
    size: int = 1,
) -> Array:
    """The numbers (size,) of an attribute.

    They are refused if missing without a default, not finite, or too large for their unit.
    """
    element = owner.find(tag)
    text = default if element is None else element.get(key, default)
    attribute, values = f"<{tag}> {key}", finite_numbers(text, size)
    if values is None:
        fault = f'is "{text}"' if text else "is missing"
        wanted = (
            "one finite number, such as 0.5"
            if size == 1
            else f"{size} finite numbers, such as 0 0 0.5"
        )
        raise RobotError(f"{subject}: {attribute} {fault}; it has to be {wanted}")
    for value in values.tolist() if unit else ():
        refuse_number(subject, attribute, value, unit)
    return values


def place_of(owner: Element, subject: str) -> pin.SE3:
    """Where an element stands, as its <origin> says."""
    xyz, rpy = (
        numbers(subject, owner, "origin", key, "0 0 0", unit, 3)
        for key, unit in (("xyz", "m"), ("rpy", "rad"))
    )
    if not rpy.any():
        return pin.SE3(np.eye(3), xyz)
    roll, pitch, yaw = (
        pin.Quaternion(pin.AngleAxis(angle, axis))
        for angle, axis in zip(rpy, np.eye(3), strict=True)
    )
    return pin.SE3((yaw * pitch * roll).normalized().matrix(), xyz)


def grouped(faults: Iterable[tuple[str, str, str]]) -> tuple[str, ...]:
    """One warning for all elements with the same fault.

    Args: faults: tag and name of an element, and what is wrong with it.
    """
    names: dict[tuple[str, str], list[str]] = {}
    for tag, name, fault in faults:
        names.setdefault((tag, fault), []).append(name)
    warnings: list[str] = []
    for (tag, fault), these in names.items():
        plural = "s" if len(these) > 1 else ""
        warnings.append(f"{tag}{plural} {listed(these, 3)}: {fault}")
    return tuple(warnings)
