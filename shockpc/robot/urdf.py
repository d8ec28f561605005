"""A URDF corrected where it carries no meaning, and refused where its parser would drop something without an error.

The parser behind Pinocchio drops a body whose joint is part of a circle, or whose <inertial> holds one bad number, and goes on;
so the tree and the numbers are checked here, by name.
"""

import math
import re
import sys
from collections.abc import Iterable
from graphlib import CycleError, TopologicalSorter
from xml.etree.ElementTree import Element, SubElement, tostring

from shockpc.errors import RobotError
from shockpc.printed import listed
from shockpc.robot.limits import refuse_number, refuse_tree

__all__ = ["check_urdf", "moving_parts", "normalise_urdf", "vector"]

_ROUNDING = 1e-12  # kg m²; iCub's file has moments of −5e-20, left over by its exporter
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_ZERO = re.compile(r"[+-]?[0.]+([eE].*)?")
_JOINT_TYPES = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
# Shapes of a <geometry>: attribute and how many numbers it holds.
_SHAPES = {
    "box": {"size": 3},
    "cylinder": {"radius": 1, "length": 1},
    "capsule": {"radius": 1, "length": 1},
    "sphere": {"radius": 1},
    "mesh": {"scale": 3},
}


# Numbers of a link and of a joint: element, attributes, how many each holds, whether they must be there, and the unit of those
# whose size is limited.
_LINK_NUMBERS = (
    ("inertial/origin", "xyz", 3, False, "m"),
    ("inertial/origin", "rpy", 3, False, "rad"),
    ("inertial/mass", "value", 1, True, "kg"),
    ("inertial/inertia", "ixx ixy ixz iyy iyz izz", 1, True, "kg m²"),
)
_JOINT_NUMBERS = (
    ("origin", "xyz", 3, False, "m"),
    ("origin", "rpy", 3, False, "rad"),
    ("axis", "xyz", 3, True, ""),
    ("limit", "lower upper", 1, False, ""),
    ("limit", "effort velocity", 1, True, ""),
    ("dynamics", "damping friction", 1, False, ""),
    ("mimic", "multiplier", 1, False, "rad/rad"),
    ("mimic", "offset", 1, False, "rad"),
    ("calibration", "rising falling", 1, False, ""),
    ("safety_controller", "soft_lower_limit soft_upper_limit k_position", 1, False, ""),
    ("safety_controller", "k_velocity", 1, True, ""),
)


def vector(text: str | None, size: int) -> tuple[float, ...] | None:
    """Read so many numbers as the parser would: plain decimals, separated by blanks; None if the text is anything else.

    A number that is too large or too small for a double is none, because the parser would drop the element that holds it.
    """
    words = (text or "").split()
    if len(words) != size or not all(map(_NUMBER.fullmatch, words)):
        return None
    values = tuple(map(float, words))
    small = (word for value, word in zip(values, words, strict=True) if abs(value) < sys.float_info.min)
    return values if all(map(math.isfinite, values)) and all(map(_ZERO.fullmatch, small)) else None


def moving_parts(robot: Element) -> str:
    """The text of a URDF without shapes, materials, comments and all else that does not change how it moves."""
    parts = Element("robot", name=robot.get("name", ""))
    for element in robot:
        if element.tag in ("link", "joint"):
            part = SubElement(parts, element.tag, element.attrib)
            part.extend(child for child in element if child.tag not in ("visual", "collision"))
    return tostring(parts, encoding="unicode")


def normalise_urdf(robot: Element, file: str, name: str) -> tuple[bool, tuple[str, ...]]:
    """Correct, in place, what carries no meaning but would make the parser fail or print.

    Blanks around attribute values are removed; a robot without a name gets this one. With a warning are removed: xacro elements
    that are left over, a visual or collision without a valid shape, and a <mimic> that follows no joint of the file.

    Returns:
        Whether anything changed, and the warnings.

    Raises:
        RobotError: a joint mimics twice.
    """
    warnings, changed = [], not robot.get("name")
    if changed:
        robot.set("name", name)
    for element in robot.iter():
        for key, value in element.attrib.items():
            if value != value.strip():
                element.set(key, value.strip())
                changed = True
    left = [element for element in robot if element.tag.startswith("xacro:")]
    if left:
        tags = ", ".join(dict.fromkeys(f"<{element.tag}>" for element in left))
        warnings.append(f"{file}: {tags} ignored, because the links are complete without xacro; if not, name the file .xacro")
    for element in left:
        robot.remove(element)
    for link in robot.findall("link"):
        for part in (*link.findall("visual"), *link.findall("collision")):
            if not _has_shape(part):
                link.remove(part)
                warnings.append(
                    f'{file}: link "{link.get("name")}": a <{part.tag}> without a valid shape is left out; '
                    "it is missing in figures and extremes; no other number changes"
                )
    names = {joint.get("name") for joint in robot.findall("joint")}
    for joint in robot.findall("joint"):
        mimics = joint.findall("mimic")
        if len(mimics) > 1:
            raise RobotError(f'{file}: joint "{joint.get("name")}" has several <mimic>, and a joint can follow only one; keep one')
        for mimic in mimics:
            leader = mimic.get("joint", "")
            if leader not in names or leader == joint.get("name"):
                joint.remove(mimic)
                said = "itself" if leader == joint.get("name") else f'"{leader}", which does not exist'
                warnings.append(f'{file}: joint "{joint.get("name")}" mimics {said}; it is computed as a joint that moves freely')
    return changed or bool(warnings), tuple(warnings)


def _has_shape(part: Element) -> bool:
    """Whether a visual or collision holds one shape whose numbers can be read, at a place that can be read."""
    shapes = part.findall("geometry/*")
    if len(shapes) != 1 or shapes[0].tag not in _SHAPES or (shapes[0].tag == "mesh" and not shapes[0].get("filename")):
        return False
    wanted = [(shapes[0].get(key, "1 1 1" if key == "scale" else None), size) for key, size in _SHAPES[shapes[0].tag].items()]
    wanted += [(origin.get(key, "0 0 0"), 3) for origin in part.findall("origin")[:1] for key in ("xyz", "rpy")]
    return all(vector(text, size) is not None for text, size in wanted)


def check_urdf(robot: Element, file: str) -> None:
    """Refuse a URDF that is not one connected tree of bodies with finite numbers and some mass.

    Raises:
        RobotError: naming the link or joint at fault.
    """
    links, joints = robot.findall("link"), robot.findall("joint")
    if not links:
        raise RobotError(
            f"{file} has no <link>, so there is no robot in it; if it only defines macros, give the file that uses them"
        )
    _check_names(links, "link", file)
    _check_names(joints, "joint", file)
    _check_tree([link.get("name", "") for link in links], joints, file)
    for link in links:
        _check_link(link, f'{file}: link "{link.get("name")}"')
    for joint in joints:
        _check_joint(joint, f'{file}: joint "{joint.get("name")}"')
    if not any(float(mass.get("value", "0")) > 0 for link in links for mass in link.findall("inertial/mass")):
        raise RobotError(f"{file}: no link has mass, so nothing in it can be struck; give at least one link an <inertial>")


def _check_names(elements: list[Element], kind: str, file: str) -> None:
    """Every link and every joint needs a name of its own, which is none of Pinocchio's."""
    reserved = {"universe": "the world"} | ({"root_joint": "the free base"} if kind == "joint" else {})
    seen: set[str] = set()
    for number, element in enumerate(elements, start=1):
        name = element.get("name")
        if not name:
            raise RobotError(f"{file}: <{kind}> number {number} has no name; give it one")
        if name in seen:
            raise RobotError(f'{file}: two {kind}s are called "{name}"; names have to be unique, so rename one')
        if name in reserved and element.get("type") != "fixed":
            raise RobotError(f'{file}: {kind} "{name}" has the name that Pinocchio gives to {reserved[name]}; rename it')
        seen.add(name)


def _check_tree(links: list[str], joints: list[Element], file: str) -> None:
    """Every joint joins two links that exist; every link but one, the root, hangs on exactly one joint; none in a circle."""
    carriers = dict.fromkeys(links, "")
    above: dict[str, str] = {}
    for joint in joints:
        name = joint.get("name", "")
        if joint.get("type") not in _JOINT_TYPES:
            raise RobotError(
                f'{file}: joint "{name}" is of type "{joint.get("type", "")}", which URDF does not have; it has '
                f"{listed(_JOINT_TYPES)}"
            )
        ends = []
        for end in ("parent", "child"):
            element = joint.find(end)
            ends.append(link := element.get("link", "") if element is not None else "")
            if link not in carriers:
                said = f'its {end} is link "{link}", which does not exist' if link else f"it names no {end} link"
                raise RobotError(f'{file}: joint "{name}": {said}; every joint has to join two links of the file')
        parent, child = ends
        if child in above:
            raise RobotError(
                f'{file}: link "{child}" is the child of two joints, "{above[child]}" and "{name}"; '
                "a URDF is a tree, so cut the loop at one of them"
            )
        carriers[child], above[child] = parent, name
    try:
        order = tuple(TopologicalSorter({link: [carrier] for link, carrier in carriers.items()}).static_order())
    except CycleError as found:
        circle = sorted({above[link] for link in found.args[1]})
        said = f"joints {listed(circle)} form" if len(circle) > 1 else f"joint {listed(circle)} forms"
        raise RobotError(
            f"{file}: {said} a circle that no root link carries; a URDF is a tree, so remove one of its joints"
        ) from None
    roots = [link for link in links if link not in above]
    if len(roots) > 1:
        raise RobotError(
            f"{file}: {len(roots)} links have no parent: {listed(roots, 5)}; a robot has one root, so join the others to it"
        )
    refuse_tree(file, {link: carriers[link] for link in order if link})


def _check_link(link: Element, whose: str) -> None:
    """Mass and the six entries of the inertia: all there, all finite, none negative that cannot be."""
    for inertial in link.findall("inertial"):
        for tag in ("mass", "inertia"):
            if inertial.find(tag) is None:
                raise RobotError(f"{whose}: its <inertial> has no <{tag}>; add it, or drop the <inertial> of a link without mass")
    _check_numbers(link, _LINK_NUMBERS, whose)
    for mass in link.findall("inertial/mass"):
        if float(mass.get("value", "")) < 0:
            raise RobotError(f"{whose}: mass {mass.get('value')} kg is negative; give the mass that the body has, or 0")
    for inertia in link.findall("inertial/inertia"):
        for entry in ("ixx", "iyy", "izz"):
            if float(inertia.get(entry, "")) < -_ROUNDING:
                raise RobotError(
                    f"{whose}: {entry} = {inertia.get(entry)} kg m² is negative; give the moment of inertia that the body has"
                )


def _check_joint(joint: Element, whose: str) -> None:
    """Origin, axis, limits and all that a joint may hold beside them."""
    _check_numbers(joint, _JOINT_NUMBERS, whose)
    kind, axis = joint.get("type"), joint.find("axis")
    direction = (vector(axis.get("xyz"), 3) if axis is not None else None) or (1.0, 0.0, 0.0)
    if kind in ("revolute", "continuous", "prismatic", "planar") and not any(direction):
        raise RobotError(f"{whose}: its axis is 0 0 0, so it has no direction; give it one")
    if kind == "planar" and (direction[:2] != (0.0, 0.0) or direction[2] < 0):
        shown = " ".join(f"{value:g}" for value in direction)
        raise RobotError(
            f"{whose}: planar with the normal {shown} (1 0 0 where none is written); Pinocchio moves every planar joint in "
            'x and y. Turn the joint\'s <origin> so that <axis xyz="0 0 1"/> is the normal'
        )
    if kind in ("revolute", "prismatic") and joint.find("limit") is None:
        instead = ", or make it continuous" if kind == "revolute" else ""
        raise RobotError(f"{whose} is {kind} and has no <limit>, which URDF requires; add one{instead}")


def _check_numbers(owner: Element, table: Iterable[tuple[str, str, int, bool, str]], whose: str) -> None:
    """Refuse what is not a finite number of a size that can be computed with, or not there though it must be."""
    for path, keys, size, required, unit in table:
        for element in owner.findall(path):
            for key in keys.split():
                text = element.get(key)
                if text is None and not required:
                    continue
                what = {"mass": "mass", "inertia": key, "axis": "axis"}.get(element.tag, f"<{element.tag}> {key}")
                if element.tag == "origin":
                    what = f"<{'inertial' if owner.tag == 'link' else 'joint'}> origin {key}"
                values = vector(text, size)
                if values is None:
                    found = "is missing" if text is None else f'is "{text}"'
                    wanted = "one finite number, such as 0.5" if size == 1 else f"{size} finite numbers, such as 0 0 0.5"
                    raise RobotError(f"{whose}: {what} {found}; it has to be {wanted}")
                for value in values if unit else ():
                    refuse_number(whose, what, value, unit)
