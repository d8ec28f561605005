"""The robot of a URDF. What cannot be computed is refused by the name of link or joint.

It is read here and not by Pinocchio, whose parser drops a body whose joint is part of a circle, or
whose <inertial> holds one bad number, and goes on.
"""

import copy
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TypeAlias
from xml.etree.ElementTree import Element, tostring

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import read_only
from shockpc.robot.bodies_and_joints import WORLD, Mimic
from shockpc.robot.catalogue import find_srdf
from shockpc.robot.files.reading import shared_xml
from shockpc.robot.files.tags import URDF, unread
from shockpc.robot.pinocchio_joints import add_joint, axis_joint
from shockpc.robot.robot import Robot, RobotSource
from shockpc.robot.tolerances import refuse_tree
from shockpc.robot.urdf.drives import read_drives, with_rest
from shockpc.robot.urdf.numbers import finite_numbers, grouped, numbers, place_of
from shockpc.robot.urdf.places import add_places, ball_joints, read_loops
from shockpc.text.errors import RobotError
from shockpc.text.printed import listed

_JOINT_TYPES = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
_PLACED = ("link", "joint", "loop_joint", "frame", "drake:frame", "fixed_frame", "sensor")
"""Elements of <robot> that hold places which are read."""
_Order: TypeAlias = dict[str, tuple[str, str]]


def read(source: RobotSource, xacro: Mapping[str, str]) -> RobotSource:
    """Expand a URDF that needs xacro, and find the file of its reference postures."""
    path, text = source.path, source.xml
    root = shared_xml(text, path.name)
    marked = "xacro:" in text
    expanded = path.suffix == ".xacro" or (marked and _needs_xacro(root))
    warnings: tuple[str, ...] = ()
    if expanded:
        from shockpc.robot.xacro.expand import expand_xacro

        text, warnings = expand_xacro(text, source.folders, xacro)
    elif marked:
        warnings = _ignored_xacro(root, path.name)
    text = _without_quaternions(text, path.name)
    root = shared_xml(text, path.name)
    unread_parts = unread(root, URDF)
    refused = [part.text for part in unread_parts if part.treatment == "refuse"]
    if refused:
        raise RobotError(f"{path.name}: {'; '.join(refused)}")
    for part in unread_parts:
        if part.treatment == "warn":
            warnings += (f"{path.name}: {part.text}",)
    name = root.get("name") or source.robot_name
    return with_postures(
        replace(source, xml=text, robot_name=name, warnings=warnings, expanded=expanded)
    )


def _ignored_xacro(root: Element, name: str) -> tuple[str, ...]:
    """A warning if elements of xacro are ignored."""
    tags = [f"<{part.tag}>" for part in root.iter() if part.tag.startswith("xacro:")]
    if not tags:
        return ()
    ignored = ", ".join(dict.fromkeys(tags))
    return (
        f"{name}: {ignored} ignored, because the links are complete without xacro; if not, name "
        f"the file .xacro",
    )


def _without_quaternions(text: str, name: str) -> str:
    """A URDF with the angles of rpy in place of each quat_xyzw.

    Only some readers and some versions of URDF have quat_xyzw.

    Raises:
        RobotError: a quaternion stands beside angles, or in a file whose version does not have it,
            or is none.
    """
    if "quat_xyzw" not in text:
        return text
    root = copy.deepcopy(shared_xml(text, name))
    version = root.get("version", "")
    for owner in root:
        if owner.tag not in _PLACED:
            continue
        subject = f'{name}: {owner.tag} "{owner.get("name", "")}"'
        for part in owner.iter():
            written = part.attrib.pop("quat_xyzw", None)
            if written is not None:
                angles = _angles(part, written, version, subject)
                part.set("rpy", " ".join(map(repr, angles)))
    return tostring(root, encoding="unicode")


def _angles(part: Element, quaternion: str, version: str, subject: str) -> list[float]:
    """Roll, pitch and yaw [rad] of the quat_xyzw of an element.

    It is refused as in `_without_quaternions`.
    """
    quat = f'quat_xyzw="{quaternion}"'
    if "rpy" in part.attrib:
        raise RobotError(
            f'{subject}: its <{part.tag}> has rpy="{part.get("rpy")}" and {quat}; keep one of them'
        )
    quat += f" of its <{part.tag}>"
    if version not in ("1.1", "1.2"):
        stated = f'version="{version}"' if version else "no version"
        raise RobotError(
            f"{subject}: {quat} is read from version 1.1 of URDF on, and the file has {stated}, "
            f'for which readers leave it out; write <robot version="1.1"> if it is meant, or rpy '
            f"in place of it"
        )
    values = finite_numbers(quaternion, 4)
    if values is None or not 1e-100 < float(np.linalg.norm(values)) < 1e100:
        raise RobotError(
            f"{subject}: {quat} is no rotation; it has to be four finite numbers x, y, z, w, not "
            f"all zero"
        )
    R = pin.Quaternion(values / np.linalg.norm(values)).matrix()
    return [float(angle) for angle in pin.rpy.matrixToRpy(R)]


def with_postures(source: RobotSource) -> RobotSource:
    """A source with the file of its reference postures: as given, or the one beside the robot."""
    path, folders = source.path, source.folders
    folders.note(path.parent)  # an SRDF may be added later
    srdf = source.srdf or find_srdf(path, source.robot_name)
    if srdf is None or not (source.srdf or folders.contain(srdf)):
        return source  # without one, or with a link that leads out of the folders
    folders.note(srdf)
    return replace(source, srdf=Path(os.path.realpath(srdf)))


def choose(source: RobotSource, frames: Sequence[str]) -> None:
    """A URDF holds one robot."""


def build(source: RobotSource, chosen: None = None) -> Robot:
    """Build the robot of a URDF, with the joints in the order of Pinocchio's reader.

    A root link that is called "world", or has no mass, and carries nothing but a floating or planar
    joint is the world, and that joint is the floating base. It stands where its configuration says;
    its origin in the file is only where it starts.

    Raises:
        RobotError: it is not one connected tree of bodies with finite numbers and some mass.
    """
    root = shared_xml(source.xml, source.path.name)
    links = _named(root.findall("link"), "link")
    joints = _named(root.findall("joint"), "joint")
    if not links:
        raise RobotError(
            "it has no <link>, so there is no robot in it; give the file that uses its macros or, "
            "for an SRDF, a scene with the URDF as robot and this file as srdf"
        )
    order = _carriers_first(links, joints)
    inertias = _inertias(links)

    # The tree: joints that are computed as ball joints of a loop are fixed in it.
    masses = {name: inertia.mass for name, inertia in inertias.items()}
    balls = ball_joints(root, order, joints, masses)
    joints |= {name: _fixed(joints[name]) for name in balls}
    mimics, notes = _mimics(joints)
    if balls:
        notes.append(
            f"joints {listed(balls, 4)} move nothing with mass and end in a loop: with it they are "
            f"computed as a ball joint, which holds its point"
        )
    model = _model(order, joints, inertias)
    # Only the tree shows whether a joint carries the whole robot; such a joint becomes the free
    # base.
    base = _base_joint(model, order, joints)
    if base:
        model = _model(order, joints, inertias, base)
        if joints[base].get("type") == "planar":
            notes.append(
                f'joint "{base}" is planar and carries the whole robot, so it is computed as a '
                f"floating base; --base planar keeps it in the plane of the study"
            )
    notes += _unread_limits(root, joints)

    # What stands beside the tree: drives, places, loops.
    drives = read_drives(root, joints, model)
    imus, unplaced = add_places(root, model)
    model.name = source.robot_name
    # The placement of the first joint is where the base starts, so that q alone says where it
    # stands.
    start = pin.neutral(model)
    start[:7] = pin.SE3ToXYZQUAT(model.jointPlacements[1])
    model.jointPlacements[1] = pin.SE3.Identity()
    robot = Robot(
        source,
        model,
        read_only(start),
        {},
        mimics,
        (),
        (*notes, *drives.warnings, *unplaced),
        springs=drives.springs,
        relaxed=with_rest(drives.rest, model, start),
        gear_ratios=drives.gear_ratios,
        imus=imus,
    )
    loops, left_open = read_loops(root, robot, set(balls.values()))
    if loops or left_open:
        robot = replace(robot, loops=loops, notes=(*robot.notes, *left_open))
    return robot


def _base_joint(model: pin.Model, order: _Order, joints: dict[str, Element]) -> str:
    """The floating or planar joint that carries the whole robot on the world; empty if none does.

    Args:
        model: whose root link is a free base.
        order: of the links.
        joints: by name.
    """
    carried = [joint for joint, parent in enumerate(model.parents) if parent == 1]
    if len(carried) != 1:
        return ""
    name: str = model.names[carried[0]]
    carries_all = joints[name].get("type") in ("floating", "planar")
    on_world = next(iter(order)) == WORLD or not model.inertias[1].mass
    return name if carries_all and on_world else ""


def _unread_limits(root: Element, joints: dict[str, Element]) -> list[str]:
    """A warning about the limits of continuous joints, which version 1.2 of URDF allows."""
    if root.get("version") != "1.2":
        return []
    limited: list[str] = []
    for name, joint in joints.items():
        if joint.get("type") == "continuous" and _limits(joint):
            limited.append(name)
    if not limited:
        return []
    return [
        f"joints {listed(limited, 4)} are continuous and have limits, as version 1.2 of URDF "
        f"allows; they are not read"
    ]


def _named(elements: list[Element], kind: str) -> dict[str, Element]:
    """Links or joints by name; each needs a separate one, which is none of Pinocchio's."""
    reserved = {"universe": "the world"}
    if kind == "joint":
        reserved["root_joint"] = "the free base"
    named: dict[str, Element] = {}
    for number, element in enumerate(elements, start=1):
        name = element.get("name")
        if not name:
            raise RobotError(f"<{kind}> number {number} has no name; give it one")
        if name in named:
            raise RobotError(
                f'two {kind}s are called "{name}"; names have to be unique, so rename one'
            )
        if name in reserved and element.get("type") != "fixed":
            raise RobotError(
                f'{kind} "{name}" has the name that Pinocchio gives to {reserved[name]}; rename it'
            )
        named[name] = element
    return named


def _carriers_first(links: dict[str, Element], joints: dict[str, Element]) -> _Order:
    """The joint above each link and the link that carries it, branch by branch from the root.

    The root has neither.
    """
    above: _Order = {}
    below: dict[str, list[str]] = {link: [] for link in links}
    for name, joint in sorted(joints.items(), reverse=True):
        parent, child = _ends(name, joint, links)
        if child in above:
            raise RobotError(
                f'link "{child}" is the child of two joints, "{name}" and "{above[child][0]}"; '
                "a URDF is a tree, so cut the loop at one of them",
                joints=[name, above[child][0]],
            )
        above[child] = name, parent
        below[parent].append(child)
    roots = [link for link in links if link not in above]
    if len(roots) > 1:
        raise RobotError(
            f"{len(roots)} links have no parent: {listed(roots, 5)}; a robot has one root, so join "
            f"the others to it"
        )
    order: _Order = {}
    waiting = roots
    while waiting:
        link = waiting.pop()
        order[link] = above.get(link, ("", ""))
        waiting += below[link]
    _refuse_circle(above, order)
    refuse_tree({link: carrier for link, (_, carrier) in order.items()})
    return order


def _ends(name: str, joint: Element, links: dict[str, Element]) -> tuple[str, str]:
    """The parent and the child link of a joint; refused if its type or one of them is unknown."""
    subject, kind = f'joint "{name}"', joint.get("type", "")
    if kind not in _JOINT_TYPES:
        raise RobotError(
            f'{subject} is of type "{kind}", which URDF does not have; it has '
            f"{listed(_JOINT_TYPES)}"
        )
    ends = []
    for end in ("parent", "child"):
        element = joint.find(end)
        link = "" if element is None else element.get("link", "")
        if link not in links:
            fault = f"it names no {end} link"
            if link:
                fault = f'its {end} is link "{link}", which does not exist'
            raise RobotError(f"{subject}: {fault}; every joint has to join two links of the file")
        ends.append(link)
    return ends[0], ends[1]


def _refuse_circle(above: _Order, order: _Order) -> None:
    """Refuse joints in a circle that no root link carries."""
    outside = [link for link in above if link not in order]
    if not outside:
        return
    link = outside[0]
    for _ in above:  # from what hangs on the circle to a link of it
        link = above[link][1]
    circle: list[str] = []
    while above[link][0] not in circle[:1]:
        circle.append(above[link][0])
        link = above[link][1]
    circle.sort()
    raise RobotError(
        f"a circle that no root link carries holds {listed(circle, 5)}; a URDF is a tree, so "
        f"remove one of these joints",
        joints=circle,
    )


def _fixed(joint: Element) -> Element:
    """A copy of the joint without its freedom."""
    fixed = copy.copy(joint)
    fixed.attrib = joint.attrib | {"type": "fixed"}
    return fixed


def _model(
    order: _Order, joints: dict[str, Element], inertias: dict[str, pin.Inertia], base: str = ""
) -> pin.Model:
    """The model, whose floating base is the joint of this name, or else the root link's."""
    model = pin.Model()
    placements, frames = {"": (0, pin.SE3.Identity())}, {"": 0}
    for link, (name, parent) in order.items():
        carrier, placement = placements[parent]
        if name:
            carrier, placement = _add_joint(
                model, joints[name], carrier, placement, frames[parent], name == base
            )
        elif not base:
            carrier = add_joint(model, 0, pin.JointModelFreeFlyer(), placement, "root_joint")
        placements[link] = carrier, placement
        above = model.nframes - 1
        frame = pin.Frame(link, carrier, above, placement, pin.FrameType.BODY, inertias[link])
        frames[link] = model.addFrame(frame)
    return model


def _add_joint(
    model: pin.Model, joint: Element, carrier: int, placement: pin.SE3, above: int, is_base: bool
) -> tuple[int, pin.SE3]:
    """Add a joint to a model; return the joint that carries its child, and the child's place in it.

    Args:
        model: which gets the joint.
        joint: its element.
        carrier: joint that carries the parent link.
        placement: of the parent link in it.
        above: frame of the parent link.
        is_base: whether it is the floating base.
    """
    name = joint.get("name", "")
    subject, kind = f'joint "{name}"', joint.get("type")
    placement = placement * place_of(joint, subject)
    if kind == "fixed":
        frame = pin.Frame(name, carrier, above, placement, pin.FrameType.FIXED_JOINT)
        model.addFrame(frame, False)
        return carrier, placement
    moving = pin.JointModelFreeFlyer() if is_base else _moving(joint, subject)
    index = add_joint(model, carrier, moving, placement, name, above)
    if kind in ("revolute", "prismatic"):
        lower, upper = _range(joint, subject)
        model.lowerPositionLimit[model.idx_qs[index]] = lower
        model.upperPositionLimit[model.idx_qs[index]] = upper
    if joint.find("limit") is not None:
        (effort,) = numbers(subject, joint, "limit", "effort", "0")
        model.upperEffortLimit[model.idx_vs[index]] = effort
    return index, pin.SE3.Identity()


def _range(joint: Element, subject: str) -> tuple[float, float]:
    """The limits of a hinge or slide joint [rad, m]; infinite if the file gives neither.

    URDF reads limits that are not written as zero. A joint that cannot move is never meant.
    """
    if not _limits(joint):
        return -np.inf, np.inf
    (lower,) = numbers(subject, joint, "limit", "lower", "0")
    (upper,) = numbers(subject, joint, "limit", "upper", "0")
    return lower, upper


def _limits(joint: Element) -> set[str]:
    """The names of the limits that a joint has."""
    limit = joint.find("limit")
    return set() if limit is None else {"lower", "upper"} & limit.attrib.keys()


def _inertias(links: dict[str, Element]) -> dict[str, pin.Inertia]:
    """The inertias of all links.

    Raises:
        RobotError: none has mass, or one has numbers that no link has.
    """
    inertias = {name: _inertia(link, f'link "{name}"') for name, link in links.items()}
    if not any(inertia.mass > 0 for inertia in inertias.values()):
        raise RobotError(
            "no link has mass, so the robot has no mass; give at least one link an <inertial>"
        )
    return inertias


def _inertia(link: Element, subject: str) -> pin.Inertia:
    """The mass of a link with its centre and its moments, in the link's frame.

    They are zero without <inertial>.
    """
    inertial = link.find("inertial")
    if inertial is None:
        return pin.Inertia.Zero()
    (mass,) = numbers(subject, inertial, "mass", "value", unit="kg")
    if mass < 0:
        raise RobotError(
            f"{subject}: mass {mass:g} kg is negative; give the mass that the body has, or 0"
        )
    keys = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    moments = [numbers(subject, inertial, "inertia", key, unit="kg m²")[0] for key in keys]
    placement = place_of(inertial, subject)
    R = placement.rotation
    tensor = R @ np.array(moments)[[[0, 1, 2], [1, 3, 4], [2, 4, 5]]] @ R.T
    # Not by its constructor, which refuses negative moments; the landing refuses them where they
    # matter.
    inertia = pin.Inertia.Zero()
    inertia.mass = float(mass)
    inertia.lever = placement.translation
    inertia.inertia = (tensor + tensor.T) / 2.0
    return inertia


def _moving(joint: Element, subject: str) -> pin.JointModel:
    """A joint for Pinocchio."""
    kind = joint.get("type", "")
    if kind == "floating":
        return pin.JointModelFreeFlyer()
    unwritten = "1 0 0" if joint.find("axis") is None else ""
    axis = numbers(subject, joint, "axis", "xyz", unwritten, size=3)
    direction = " ".join(f"{value:g}" for value in axis)
    if not 1e-100 < np.abs(axis).max() < 1e100:
        raise RobotError(
            f"{subject}: its axis is {direction}, so it has no direction; give a unit vector"
        )
    if kind == "planar":
        if axis[:2].any() or axis[2] < 0:
            raise RobotError(
                f"{subject}: planar with the normal {direction} (1 0 0 where none is written), "
                "but Pinocchio moves it in x and y; turn the joint's <origin> so that <axis "
                'xyz="0 0 1"/> is the normal'
            )
        return pin.JointModelPlanar()
    if kind != "continuous" and joint.find("limit") is None:
        remedy = ", or make it continuous" if kind == "revolute" else ""
        raise RobotError(
            f"{subject} is {kind} and has no <limit>, which URDF requires; add one{remedy}"
        )
    return axis_joint(kind, *axis.tolist())


def _mimics(joints: dict[str, Element]) -> tuple[tuple[Mimic, ...], list[str]]:
    """The joints that follow others, and a warning for each that follows no joint of the file."""
    mimics: list[Mimic] = []
    faults: list[tuple[str, str, str]] = []
    for name, joint in joints.items():
        rules, subject = joint.findall("mimic"), f'joint "{name}"'
        if len(rules) > 1:
            raise RobotError(
                f"{subject} has several <mimic>, and a joint can follow only one; keep one"
            )
        for rule in rules:
            leader = rule.get("joint", "")
            if leader == name or leader not in joints:
                fault = "itself" if leader == name else f'"{leader}", which does not exist'
                faults.append(("joint", name, f"mimics {fault}, so it moves freely"))
            elif joint.get("type") != "fixed":
                (multiplier,) = numbers(subject, joint, "mimic", "multiplier", "1", "rad/rad")
                (offset,) = numbers(subject, joint, "mimic", "offset", "0", "rad")
                mimics.append(Mimic(name, {leader: float(multiplier)}, float(offset)))
    return tuple(mimics), list(grouped(faults))


def _needs_xacro(root: Element) -> bool:
    """True if a file has to be expanded.

    Its links carry no mass without xacro, or its numbers are expressions.
    """
    # Expanded files often keep <xacro:…> elements that mean nothing any more; their links are
    # complete.
    every_name: set[str] = set()
    for part in root.iter():
        every_name.update((part.tag, *part.attrib))
    if not any(name.startswith("xacro:") for name in every_name):
        return False
    if root.find("link/inertial/mass") is None:
        return True
    for owner in root.findall("link") + root.findall("joint"):
        for element in owner.iter():
            names = list(element.attrib)
            if element.tag in ("link", "joint", "inertial"):
                names += [part.tag for part in element]
            if any(name.startswith("xacro:") for name in names):
                return True
            for value in element.attrib.values():
                if "${" in value or "$(" in value:
                    return True
    return False
