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
from shockpc.robot.catalogue import find_srdf
from shockpc.robot.elements import WORLD, Mimic
from shockpc.robot.reading import shared_xml
from shockpc.robot.robot import Robot, RobotSource
from shockpc.robot.tags import URDF, unread
from shockpc.robot.tolerances import refuse_tree
from shockpc.robot.tree import add_joint, axis_joint
from shockpc.robot.urdf_drives import read_drives, with_rest
from shockpc.robot.urdf_numbers import grouped, numbers, place_of, vector
from shockpc.robot.urdf_places import add_places, ball_joints, read_loops
from shockpc.text.errors import RobotError
from shockpc.text.printed import listed

_JOINT_TYPES = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
_PLACED = ("link", "joint", "loop_joint", "frame", "drake:frame", "fixed_frame", "sensor")
"""Elements of <robot> that hold places which are read."""
_Order: TypeAlias = dict[str, tuple[str, str]]


def read(source: RobotSource, xacro: Mapping[str, str]) -> RobotSource:
    """Expand a URDF that needs xacro, and find the file of its reference postures."""
    path, folders, text, root = (
        source.path,
        source.folders,
        source.xml,
        shared_xml(source.xml, source.path.name),
    )
    warnings: tuple[str, ...] = ()
    marked = "xacro:" in text
    if expanded := path.suffix == ".xacro" or (marked and _needs_xacro(root)):
        from shockpc.robot.xacro import expand_xacro

        text, warnings = expand_xacro(text, folders, xacro)
    elif marked and (
        prefixed := dict.fromkeys(
            f"<{part.tag}>" for part in root.iter() if part.tag.startswith("xacro:")
        )
    ):
        reason = (
            f"{', '.join(prefixed)} ignored, because the links are complete without xacro; if not, "
            f"name the file .xacro"
        )
        warnings = (f"{path.name}: {reason}",)
    text = _without_quaternions(text, path.name)
    root = shared_xml(text, path.name)
    found = unread(root, URDF)
    if refused := [one.text for one in found if one.treatment == "refuse"]:
        raise RobotError(f"{path.name}: {'; '.join(refused)}")
    warnings += tuple(f"{path.name}: {one.text}" for one in found if one.treatment == "warn")
    name = root.get("name") or source.robot_name
    return with_postures(
        replace(source, xml=text, robot_name=name, warnings=warnings, expanded=expanded)
    )


def _without_quaternions(text: str, name: str) -> str:
    """A URDF with the angles of rpy in place of each quat_xyzw, which only some readers and some
    versions of URDF have.

    Raises:
        RobotError: a quaternion stands beside angles, or in a file whose version does not have it,
            or is none.
    """
    if "quat_xyzw" not in text:
        return text
    root = copy.deepcopy(shared_xml(text, name))
    version = root.get("version", "")
    for owner in root:
        for part in owner.iter() if owner.tag in _PLACED else ():
            if (written := part.attrib.pop("quat_xyzw", None)) is None:
                continue
            subject, what = (
                f'{name}: {owner.tag} "{owner.get("name", "")}"',
                f'quat_xyzw="{written}" of its <{part.tag}>',
            )
            if "rpy" in part.attrib:
                raise RobotError(
                    f'{subject}: its <{part.tag}> has rpy="{part.get("rpy")}" and '
                    f"{what.split(' of ')[0]}; keep one of them"
                )
            if version not in ("1.1", "1.2"):
                given = f'version="{version}"' if version else "no version"
                raise RobotError(
                    f"{subject}: {what} is read from version 1.1 of URDF on, and the file has "
                    f"{given}, for which readers leave it "
                    'out; write <robot version="1.1"> if it is meant, or rpy in place of it'
                )
            quaternion = vector(written, 4)
            if quaternion is None or not 1e-100 < float(np.linalg.norm(quaternion)) < 1e100:
                raise RobotError(
                    f"{subject}: {what} is no rotation; it has to be four finite numbers x, y, z, "
                    f"w, not all zero"
                )
            rotation = pin.Quaternion(quaternion / np.linalg.norm(quaternion)).matrix()
            part.set("rpy", " ".join(map(repr, pin.rpy.matrixToRpy(rotation).tolist())))
    return tostring(root, encoding="unicode")


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
    links, joints = (_named(root.findall(kind), kind) for kind in ("link", "joint"))
    if not links:
        remedy = (
            "if it defines macros, give the file that uses them; if it is an SRDF, give the URDF, "
            "and this file with --srdf"
        )
        raise RobotError(f"it has no <link>, so there is no robot in it; {remedy}")
    order = _carriers_first(links, joints)
    inertias = {name: _inertia(link, f'link "{name}"') for name, link in links.items()}
    if not any(inertia.mass > 0 for inertia in inertias.values()):
        raise RobotError(
            "no link has mass, so the robot has no mass; give at least one link an <inertial>"
        )
    balls = ball_joints(
        root, order, joints, {name: inertia.mass for name, inertia in inertias.items()}
    )
    joints |= {name: _fixed(joints[name]) for name in balls}
    model = _model(order, joints, inertias)
    mimics, notes = _mimics(joints)
    if balls:
        notes.append(
            f"joints {listed(balls, 4)} move nothing with mass and end in a loop: with it they are "
            f"computed as a ball joint, which "
            "holds its point"
        )
    carried = [joint for joint, parent in enumerate(model.parents) if parent == 1]
    kind = joints[model.names[carried[0]]].get("type") if len(carried) == 1 else ""
    if kind in ("floating", "planar") and (
        next(iter(order)) == WORLD or not model.inertias[1].mass
    ):
        base = model.names[carried[0]]
        model = _model(order, joints, inertias, base)
        if kind == "planar":
            notes.append(
                f'joint "{base}" is planar and carries the whole robot, so it is computed as a '
                f"floating base; "
                "--base planar keeps it in the plane of the study"
            )
    limited = [
        name
        for name, joint in joints.items()
        if joint.get("type") == "continuous" and _limits(joint)
    ]
    if limited and root.get("version") == "1.2":
        notes.append(
            f"joints {listed(limited, 4)} are continuous and have limits, as version 1.2 of URDF "
            f"allows; they are not read"
        )
    drives = read_drives(root, joints, model)
    imus, unplaced = add_places(root, model)
    model.name, start = source.robot_name, pin.neutral(model)
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
    return (
        replace(robot, loops=loops, notes=(*robot.notes, *left_open))
        if loops or left_open
        else robot
    )


def _named(elements: list[Element], kind: str) -> dict[str, Element]:
    """Links or joints by name; each needs a separate one, which is none of Pinocchio's."""
    reserved = {"universe": "the world"} | (
        {"root_joint": "the free base"} if kind == "joint" else {}
    )
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
    """The joint above each link and the link that carries it, branch by branch from the root, which
    has neither.
    """
    above: _Order = {}
    below: dict[str, list[str]] = {link: [] for link in links}
    for name, joint in sorted(joints.items(), reverse=True):
        kind, subject = joint.get("type", ""), f'joint "{name}"'
        if kind not in _JOINT_TYPES:
            raise RobotError(
                f'{subject} is of type "{kind}", which URDF does not have; it has '
                f"{listed(_JOINT_TYPES)}"
            )
        parent, child = (
            next((part.get("link", "") for part in joint.findall(end)), "")
            for end in ("parent", "child")
        )
        for end, link in (("parent", parent), ("child", child)):
            if link not in links:
                fault = (
                    f'its {end} is link "{link}", which does not exist'
                    if link
                    else f"it names no {end} link"
                )
                raise RobotError(
                    f"{subject}: {fault}; every joint has to join two links of the file"
                )
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
    if link := next((link for link in above if link not in order), ""):
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
    refuse_tree({link: carrier for link, (_, carrier) in order.items()})
    return order


def _fixed(joint: Element) -> Element:
    """The same joint without its freedom."""
    fixed = copy.copy(joint)
    fixed.attrib = joint.attrib | {"type": "fixed"}
    return fixed


def _model(
    order: _Order, joints: dict[str, Element], inertias: dict[str, pin.Inertia], base: str = ""
) -> pin.Model:
    """The model, whose floating base is the joint of this name, or else the root link's."""
    model = pin.Model()
    places, frames = {"": (0, pin.SE3.Identity())}, {"": 0}
    for link, (name, parent) in order.items():
        carrier, place = places[parent]
        if not name:
            places[link] = (
                carrier
                if base
                else add_joint(model, 0, pin.JointModelFreeFlyer(), place, "root_joint"),
                place,
            )
        else:
            joint, subject = joints[name], f'joint "{name}"'
            place = place * place_of(joint, subject)
            if joint.get("type") == "fixed":
                model.addFrame(
                    pin.Frame(name, carrier, frames[parent], place, pin.FrameType.FIXED_JOINT),
                    False,
                )
                places[link] = carrier, place
            else:
                moving = pin.JointModelFreeFlyer() if name == base else _moving(joint, subject)
                index = add_joint(model, carrier, moving, place, name, frames[parent])
                limit = joint.find("limit")
                if joint.get("type") in ("revolute", "prismatic"):
                    # A file without either, which URDF reads as zero, says nothing of limits: no
                    # joint is meant that cannot move.
                    known = _limits(joint)
                    for bounds, key, least in (
                        (model.lowerPositionLimit, "lower", -np.inf),
                        (model.upperPositionLimit, "upper", np.inf),
                    ):
                        bounds[model.idx_qs[index]] = (
                            numbers(subject, joint, "limit", key, "0")[0] if known else least
                        )
                if limit is not None:
                    (model.upperEffortLimit[model.idx_vs[index]],) = numbers(
                        subject, joint, "limit", "effort", "0"
                    )
                places[link] = index, pin.SE3.Identity()
        frame = pin.Frame(
            link,
            places[link][0],
            model.nframes - 1,
            places[link][1],
            pin.FrameType.BODY,
            inertias[link],
        )
        frames[link] = model.addFrame(frame)
    return model


def _limits(joint: Element) -> set[str]:
    """Which of its limits a joint has."""
    return {"lower", "upper"} & {
        key for limit in joint.findall("limit")[:1] for key in limit.attrib
    }


def _inertia(link: Element, subject: str) -> pin.Inertia:
    """The mass of a link with its centre and its moments, in the link's frame; none without
    <inertial>.
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
    moments = {key: numbers(subject, inertial, "inertia", key, unit="kg m²")[0] for key in keys}
    place = place_of(inertial, subject)
    tensor = (
        place.rotation
        @ np.array(list(moments.values()))[[[0, 1, 2], [1, 3, 4], [2, 4, 5]]]
        @ place.rotation.T
    )
    # whose constructor refuses negative moments, which the landing refuses where they matter
    inertia = pin.Inertia.Zero()
    inertia.mass, inertia.lever, inertia.inertia = (
        float(mass),
        place.translation,
        (tensor + tensor.T) / 2.0,
    )
    return inertia


def _moving(joint: Element, subject: str) -> pin.JointModel:
    """A joint for Pinocchio."""
    kind = joint.get("type", "")
    if kind == "floating":
        return pin.JointModelFreeFlyer()
    axis = numbers(
        subject, joint, "axis", "xyz", "1 0 0" if joint.find("axis") is None else "", size=3
    )
    direction = " ".join(f"{value:g}" for value in axis)
    if not 1e-100 < np.abs(axis).max() < 1e100:
        raise RobotError(
            f"{subject}: its axis is {direction}, so it has no direction; give it one, of length 1"
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
    """Whether a file has to be expanded: one whose links carry no mass, or numbers that are
    expressions, without xacro.
    """
    # Expanded files often keep <xacro:…> elements that mean nothing any more; their links are
    # complete.
    if not any(
        key.startswith("xacro:") for part in root.iter() for key in (part.tag, *part.attrib)
    ):
        return False
    plain = [
        element for link in root.findall("link") + root.findall("joint") for element in link.iter()
    ]
    parts = [
        part.tag
        for element in plain
        if element.tag in ("link", "joint", "inertial")
        for part in element
    ]
    names = [*parts, *(key for element in plain for key in element.attrib)]
    whole = root.find("link/inertial/mass") is not None and not any(
        name.startswith("xacro:") for name in names
    )
    return not whole or any(
        "${" in value or "$(" in value for element in plain for value in element.attrib.values()
    )
