"""A URDF made fit to hand on: the tree must hold together, and what the parser would choke on harmlessly is put right.

The parser behind Pinocchio drops a body whose joint is part of a circle, and prints to the terminal, without raising; so
the tree is checked here, by name. The numbers in it are the business of `urdf_numbers`.
"""

from collections.abc import Iterable
from xml.etree.ElementTree import Element

from shockpc.errors import RobotError
from shockpc.robot.urdf_numbers import SHAPES, check_numbers, vector

__all__ = ["check_urdf", "normalise_urdf"]

_JOINT_TYPES = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")


def check_urdf(robot: Element, file: str) -> None:
    """Refuse a URDF that is not one connected tree of bodies with finite numbers and some mass.

    Args:
        robot: its root element.
        file: the file's name, for messages.

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
    _check_reserved(links, joints, file)
    _check_tree([link.get("name", "") for link in links], joints, file)
    check_numbers(links, joints, file)
    if not any(float(mass.get("value", "0")) > 0 for link in links for mass in link.findall("inertial/mass")):
        raise RobotError(f"{file}: no link has mass, so nothing in it can be struck; give at least one link an <inertial>")


def normalise_urdf(robot: Element, file: str, name: str) -> tuple[bool, tuple[str, ...]]:
    """Correct, in place, what carries no meaning but would make the parser fail or print.

    Blanks around attribute values are removed; a robot without a name gets one. With a warning are removed: xacro elements that
    are left over, a visual or collision without a valid shape, and a <mimic> that follows no joint of the file.

    Args:
        robot: the root element, changed in place.
        file: the file's name, for messages.
        name: the name for a robot that has none.

    Returns:
        Whether anything changed, and the warnings.

    Raises:
        RobotError: a joint mimics twice.
    """
    changed = False
    warnings = []
    if not robot.get("name"):
        robot.set("name", name)
        changed = True
    for element in robot.iter():
        for key, value in element.attrib.items():
            if value != value.strip():
                element.set(key, value.strip())
                changed = True
    left = [element for element in robot if element.tag.startswith("xacro:")]
    for element in left:
        robot.remove(element)
        changed = True
    if left:
        tags = ", ".join(dict.fromkeys(f"<{element.tag}>" for element in left))
        warnings.append(f"{file}: {tags} ignored, because the links are complete without xacro; if not, name the file .xacro")
    for link in robot.findall("link"):
        for part in (*link.findall("visual"), *link.findall("collision")):
            if not _has_shape(part):
                link.remove(part)
                changed = True
                warnings.append(
                    f'{file}: link "{link.get("name")}": a <{part.tag}> without a valid shape is left out; '
                    "figures and extremes do without it, the numbers are the same"
                )
    names = {joint.get("name") for joint in robot.findall("joint")}
    for joint in robot.findall("joint"):
        if len(joint.findall("mimic")) > 1:
            raise RobotError(f'{file}: joint "{joint.get("name")}" has several <mimic>, and a joint can follow only one; keep one')
        for mimic in joint.findall("mimic"):
            leader = mimic.get("joint", "")
            if leader not in names or leader == joint.get("name"):
                joint.remove(mimic)
                changed = True
                said = "itself" if leader == joint.get("name") else f'"{leader}", which does not exist'
                warnings.append(f'{file}: joint "{joint.get("name")}" mimics {said}; it is computed as a joint that moves freely')
    return changed, tuple(warnings)


def _has_shape(part: Element) -> bool:
    """Whether a visual or collision holds one shape whose numbers can be read, at a place that can be read."""
    origin, geometry = part.find("origin"), part.find("geometry")
    shapes = [shape for shape in geometry if shape.tag in SHAPES] if geometry is not None else []
    if len(shapes) != 1 or len(list(geometry if geometry is not None else ())) != 1:
        return False
    wanted = [(shapes[0].get(key), size) for key, size in SHAPES[shapes[0].tag]]
    wanted += [(origin.get(key, "0 0 0"), 3) for key in ("xyz", "rpy")] if origin is not None else []
    if shapes[0].tag == "mesh":
        wanted.append((shapes[0].get("scale", "1 1 1"), 3))
        return bool(shapes[0].get("filename")) and all(vector(text, size) is not None for text, size in wanted)
    return all(vector(text, size) is not None for text, size in wanted)


def _check_names(elements: list[Element], kind: str, file: str) -> None:
    """Every link and every joint needs a name of its own."""
    seen: set[str] = set()
    for number, element in enumerate(elements, start=1):
        name = element.get("name")
        if not name:
            raise RobotError(f"{file}: <{kind}> number {number} has no name; give it one")
        if name in seen:
            raise RobotError(f'{file}: two {kind}s are called "{name}"; names are how bodies are told apart, so rename one')
        seen.add(name)


def _check_reserved(links: list[Element], joints: list[Element], file: str) -> None:
    """Pinocchio's own names, taken by a link or a moving joint, would silently mean something else."""
    for kind, name in (("link", "universe"), ("joint", "universe"), ("joint", "root_joint")):
        for element in links if kind == "link" else joints:
            if element.get("name") == name and element.get("type") != "fixed":
                owner = "the world" if name == "universe" else "the free base"
                raise RobotError(f'{file}: {kind} "{name}" has the name that {owner} goes by; rename it')


def _check_tree(links: list[str], joints: list[Element], file: str) -> None:
    """Every joint joins two links that exist; every link but one, the root, hangs on exactly one joint; none in a circle."""
    above: dict[str, tuple[str, str]] = {}
    known = set(links)
    for joint in joints:
        name = joint.get("name", "")
        if joint.get("type") not in _JOINT_TYPES:
            raise RobotError(
                f'{file}: joint "{name}" is of type "{joint.get("type", "")}", which URDF does not have; '
                f"it has {_listed(_JOINT_TYPES)}"
            )
        ends = {}
        for end in ("parent", "child"):
            element = joint.find(end)
            link = element.get("link", "") if element is not None else ""
            if link not in known:
                said = f'its {end} is link "{link}", which does not exist' if link else f"it names no {end} link"
                raise RobotError(f'{file}: joint "{name}": {said}; every joint has to join two links of the file')
            ends[end] = link
        if ends["child"] in above:
            other = above[ends["child"]][1]
            raise RobotError(
                f'{file}: link "{ends["child"]}" is the child of two joints, "{other}" and "{name}"; '
                "a URDF is a tree, so cut the loop at one of them"
            )
        above[ends["child"]] = (ends["parent"], name)
    rooted: set[str] = set()
    for link in above:
        trail, met = [link], {link}
        while trail[-1] in above and trail[-1] not in rooted and above[trail[-1]][0] not in met:
            trail.append(above[trail[-1]][0])
            met.add(trail[-1])
        if trail[-1] not in above or trail[-1] in rooted:
            rooted |= met
        else:
            circle = trail[trail.index(above[trail[-1]][0]) :]
            through = _listed(sorted(above[member][1] for member in circle))
            said = f"joints {through} form" if len(circle) > 1 else f"joint {through} forms"
            raise RobotError(f"{file}: {said} a circle that hangs on no root link; a URDF is a tree, so cut it open")
    roots = [link for link in links if link not in above]
    if len(roots) > 1:
        raise RobotError(
            f"{file}: {len(roots)} links have no parent: {_listed(roots[:5])}{', …' * (len(roots) > 5)}; "
            "a robot has one root, so join the others to it"
        )


def _listed(names: Iterable[str]) -> str:
    """Quoted names, with commas."""
    return ", ".join(f'"{name}"' for name in names)
