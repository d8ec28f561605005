"""The numbers of a URDF: each one finite, each one there, or the file is refused by name.

The parser behind Pinocchio drops a whole <inertial> when one of its numbers is bad, and goes on: a robot with a typing slip
in a mass would be computed without that body's mass.
"""

import math
import re
from xml.etree.ElementTree import Element

from shockpc.errors import RobotError

__all__ = ["INERTIA", "ROUNDING", "SHAPES", "check_numbers", "vector"]

# Shapes of a <geometry>: attribute and how many numbers it holds.
SHAPES: dict[str, tuple[tuple[str, int], ...]] = {
    "box": (("size", 3),),
    "cylinder": (("radius", 1), ("length", 1)),
    "capsule": (("radius", 1), ("length", 1)),
    "sphere": (("radius", 1),),
    "mesh": (),
}
INERTIA = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
# Elements of a joint: every number they may hold, and those that they must.
_JOINT_NUMBERS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "limit": (("lower", "upper", "effort", "velocity"), ("effort", "velocity")),
    "dynamics": (("damping", "friction"), ()),
    "mimic": (("multiplier", "offset"), ()),
    "calibration": (("rising", "falling"), ()),
    "safety_controller": (("soft_lower_limit", "soft_upper_limit", "k_position", "k_velocity"), ("k_velocity",)),
}
ROUNDING = 1e-12  # kg m²; iCub's file has moments of −5e-20, left over by its exporter
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")


def vector(text: str | None, size: int) -> tuple[float, ...] | None:
    """Read numbers as the parser would: plain decimals, parted by blanks, finite.

    Args:
        text: an attribute's value.
        size: how many there have to be.

    Returns:
        The numbers, or None if the text is anything else.
    """
    words = (text or "").split()
    if len(words) != size or not all(_NUMBER.fullmatch(word) for word in words):
        return None
    values = tuple(float(word) for word in words)
    return values if all(math.isfinite(value) for value in values) else None


def check_numbers(links: list[Element], joints: list[Element], file: str) -> None:
    """Refuse a link or joint with a number that is missing, not finite, or impossible.

    Args:
        links: the <link> elements.
        joints: the <joint> elements.
        file: the file's name, for messages.

    Raises:
        RobotError: naming the link or joint, the attribute and its value.
    """
    for link in links:
        for inertial in link.findall("inertial"):
            _check_inertial(inertial, f'{file}: link "{link.get("name")}"')
    for joint in joints:
        _check_joint(joint, f'{file}: joint "{joint.get("name")}"')


def _check_inertial(inertial: Element, whose: str) -> None:
    """Mass and the six entries of the inertia: all there, all finite, none negative that cannot be."""
    mass, inertia = inertial.find("mass"), inertial.find("inertia")
    if mass is None or inertia is None:
        missing = "mass" if mass is None else "inertia"
        raise RobotError(f"{whose}: its <inertial> has no <{missing}>; add it, or drop the <inertial> of a link without mass")
    _check_origin(inertial, whose)
    if _number(mass.get("value"), f"{whose}: mass") < 0:
        raise RobotError(f"{whose}: mass {mass.get('value')} kg is negative; no body has that")
    for entry in INERTIA:
        value = _number(inertia.get(entry), f"{whose}: {entry}")
        if value < -ROUNDING and entry[1] == entry[2]:
            raise RobotError(f"{whose}: {entry} = {inertia.get(entry)} kg m² is negative; no body has that moment of inertia")


def _check_joint(joint: Element, whose: str) -> None:
    """Origin, axis, limits and all that a joint may hold beside them."""
    kind = joint.get("type")
    _check_origin(joint, whose)
    axis = joint.find("axis")
    direction = _numbers(axis.get("xyz"), 3, f"{whose}: axis") if axis is not None else (1.0, 0.0, 0.0)
    if kind in ("revolute", "continuous", "prismatic", "planar") and not any(direction):
        raise RobotError(f"{whose}: its axis is 0 0 0, so it has no direction to move in; give it one")
    if kind == "planar" and (direction[:2] != (0.0, 0.0) or direction[2] < 0):
        shown = " ".join(f"{value:g}" for value in direction)
        raise RobotError(
            f"{whose}: planar with the normal {shown} (1 0 0 where none is written); Pinocchio moves every planar joint in "
            'x and y. Turn the joint\'s <origin> so that <axis xyz="0 0 1"/> is the normal'
        )
    if kind in ("revolute", "prismatic") and joint.find("limit") is None:
        instead = ", or make it continuous" if kind == "revolute" else ""
        raise RobotError(f"{whose} is {kind} and has no <limit>, which URDF requires; add one{instead}")
    for tag, (numbers, required) in _JOINT_NUMBERS.items():
        for element in joint.findall(tag):
            for key in numbers:
                if key in element.attrib or key in required:
                    _number(element.get(key), f"{whose}: <{tag}> {key}")


def _check_origin(element: Element, whose: str) -> None:
    """Position and orientation: three numbers each."""
    for origin in element.findall("origin"):
        for key in ("xyz", "rpy"):
            if key in origin.attrib:
                _numbers(origin.get(key), 3, f"{whose}: <{element.tag}> origin {key}")


def _number(text: str | None, what: str) -> float:
    """One finite number, or an error that shows what stands in its place."""
    return _numbers(text, 1, what)[0]


def _numbers(text: str | None, size: int, what: str) -> tuple[float, ...]:
    """So many finite numbers, or an error that shows what stands in their place."""
    values = vector(text, size)
    if values is None:
        found = "is missing" if text is None else f'is "{text}"'
        wanted = "one finite number" if size == 1 else f"{size} finite numbers"
        raise RobotError(f"{what} {found}; it has to be {wanted}, such as {'0.5' if size == 1 else '0 0 0.5'}")
    return values
