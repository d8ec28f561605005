"""An SDFormat file, written as a URDF with the same meaning.

The frame of a link is moved to the joint that carries it.

Poses may be relative to links, joints and frames of the model. What is not read is refused by name.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, tostring

import pinocchio as pin

from shockpc.core.spatial import Array
from shockpc.robot.bodies_and_joints import WORLD
from shockpc.robot.files.reading import parse_xml
from shockpc.robot.files.tags import unread
from shockpc.robot.robot import RobotSource
from shockpc.robot.tolerances import refuse_count
from shockpc.robot.urdf.reader import build, choose, with_postures
from shockpc.text.errors import RobotError
from shockpc.text.printed import listed
from shockpc.wings.sdf.elements import boolean, numbers_of, text_of
from shockpc.wings.sdf.poses import POSE_FRAME, Poses

__all__ = ["build", "choose", "read"]

SDF = Path(__file__).with_name("tags.csv")
"""The table of tags of a <model>."""

SDF_UNTIL_1_6 = Path(__file__).with_name("tags_until_1_6.csv")
"""Tags that only the versions until 1.6 have."""

_JOINTS = ("revolute", "continuous", "prismatic", "fixed")
_SIZES = {
    "box": ("size",),
    "sphere": ("radius",),
    "cylinder": ("radius", "length"),
    "capsule": ("radius", "length"),
}
_MOMENTS = {"ixx": "1", "iyy": "1", "izz": "1", "ixy": "0", "ixz": "0", "iyz": "0"}
_REFUSED = ("model", "include", "joint/axis2", "link/collision/geometry/mesh/submesh")
_DEFAULTS = {
    "inertial": "1 kg and 1 kg m²",
    "inertial/mass": "1 kg",
    **{f"inertial/inertia/{key}": "1 kg m²" for key in ("ixx", "iyy", "izz")},
}
"""SDFormat's defaults for numbers that a link does not give."""

_UNLIMITED = 1e16  # a limit from which on SDFormat means none [rad, m]


def read(source: RobotSource, xacro: Mapping[str, str]) -> RobotSource:
    """Write the one model of a file that may move as a URDF.

    Raises:
        RobotError: it has several models or none, is of an unknown version, or something in it is
            not read.
    """
    file = source.path.name
    root = parse_xml(source.xml, file)
    version = _version(file, root)
    model = _moving_model(file, root)
    refuse_count(sum(len(model.findall(path)) for path in ("link", "frame", "link/sensor")))
    _refuse_parts(file, root, model)
    poses = Poses(model, version)
    name = model.get("name") or source.robot_name
    tables = (SDF, SDF_UNTIL_1_6) if version <= POSE_FRAME else (SDF,)
    notes = [*_moved_frames(poses), *_notes(model)]
    notes += [remark.text for remark in unread(model, *tables)]
    text = tostring(_urdf(model, name, poses), encoding="unicode")
    warnings = tuple(f"{file}: {note}" for note in notes)
    as_urdf = replace(source, xml=text, robot_name=name, warnings=warnings, all_driven=True)
    return with_postures(as_urdf)


def _version(file: str, root: Element) -> int:
    """N of the version 1.N of a file.

    Raises:
        RobotError: it is unknown.
    """
    text = root.get("version", "")
    version = re.fullmatch(r"1\.([2-9]|\d\d)", text)
    if version is None:
        described = f'version "{text}"' if text else "no version"
        raise RobotError(
            f"{file} has {described}, which decides what its poses and axes mean; read are "
            f"versions from 1.2 on"
        )
    return int(version[1])


def _moving_model(file: str, root: Element) -> Element:
    """The one model of a file that may move.

    Raises:
        RobotError: it has several or none.
    """
    models = []
    for model in (*root.findall("model"), *root.findall("world/model")):
        if not boolean(text_of(model, "static"), "static"):
            models.append(model)
    if len(models) != 1:
        raise RobotError(f"{file} has {len(models)} models that may move; give a file with one")
    return models[0]


def _refuse_parts(file: str, root: Element, model: Element) -> None:
    """Refuse parts of a file that are not read and have numbers."""
    refused = [(model, path) for path in _REFUSED]
    # A visual shape gives a number only where there is no collision shape.
    if model.find("link/collision") is None:
        refused.append((model, "link/visual/geometry/mesh/submesh"))
    refused.append((root, "world/joint"))
    for owner, path in refused:
        part = owner.find(path)
        if part is not None:
            raise RobotError(
                f"{file}: <{part.tag}> ({path}) is not read; write out what it stands for"
            )


def _moved_frames(poses: "Poses") -> Iterator[str]:
    """A note on links whose frame is not that of the joint that carries them."""
    moved = []
    for link in poses.above:
        if link in poses.named and not poses.of(link).isApprox(poses.carried(link), 1e-12):
            moved.append(link)
    if moved:
        yield (
            f"the frames of links {listed(moved)} are moved to the joints that carry them, as in "
            "a URDF"
        )


def _notes(model: Element) -> Iterator[str]:
    """Remarks about numbers that links do not give."""
    bare: dict[str, list[str]] = {}
    for link in model.findall("link"):
        absent = (
            path
            for path in _DEFAULTS
            if link.find(path) is None or (path != "inertial" and not text_of(link, path))
        )
        bare.setdefault(next(absent, ""), []).append(link.get("name", ""))
    for path in filter(None, bare):
        taken = f"no <{path.rpartition('/')[2]}>, for which SDFormat takes {_DEFAULTS[path]}"
        yield f"links {listed(bare[path])} have {taken}; write it if they have less"


def _urdf(model: Element, name: str, poses: Poses) -> Element:
    """The URDF of a model, with a link for each of its sensors and frames."""
    robot = Element("robot", name=name)
    joints = model.findall("joint")
    if any(poses.end(joint, "parent") == WORLD for joint in joints):
        SubElement(robot, "link", name=WORLD)
    for link in model.findall("link"):
        _write_link(robot, link, poses)
    for frame in model.findall("frame"):
        frame_name = frame.get("name", "")
        in_model = poses.of(frame_name)
        carrier = poses.link(frame_name)
        placement = poses.carried(carrier).inverse() * in_model
        _write_fixed_link(robot, frame_name, carrier, placement)
    for joint in joints:
        _write_joint(robot, joint, poses)
    return robot


def _write_link(robot: Element, link: Element, poses: Poses) -> None:
    """Write a link with its inertia, shapes and sensors."""
    name = link.get("name", "")
    to_carried = poses.carried(name).inverse()
    out = SubElement(robot, "link", name=name)
    _write_inertial(out, link, name, poses, to_carried)
    for part in (*link.findall("collision"), *link.findall("visual")):
        placement = to_carried * poses.placed(part, name)
        for shape in part.findall("geometry/*"):
            geometry = SubElement(_at(SubElement(out, part.tag), placement), "geometry")
            SubElement(geometry, shape.tag, _dimensions(shape))
    for sensor in link.findall("sensor"):
        placement = to_carried * poses.placed(sensor, name)
        _write_fixed_link(robot, sensor.get("name", ""), name, placement)


def _write_inertial(
    out: Element, link: Element, name: str, poses: Poses, to_carried: pin.SE3
) -> None:
    """Write mass and inertia of a link.

    Raises:
        RobotError: they are left to the program that reads the file.
    """
    inertial = next(link.iterfind("inertial"), Element("inertial"))
    if boolean(inertial.get("auto", ""), "auto"):
        raise RobotError(
            f'link "{name}": <inertial auto> is not read; write out its mass, pose and inertia'
        )
    body = _at(SubElement(out, "inertial"), to_carried * poses.inertial(inertial, name))
    SubElement(body, "mass", value=text_of(inertial, "mass", "1"))
    moments = {}
    for key, default in _MOMENTS.items():
        moments[key] = text_of(inertial, f"inertia/{key}", default)
    SubElement(body, "inertia", moments)


def _dimensions(shape: Element) -> dict[str, str]:
    """File and scale of a mesh, or the sizes of another shape."""
    if shape.tag == "mesh":
        return {"filename": text_of(shape, "uri"), "scale": text_of(shape, "scale", "1 1 1")}
    return {key: text_of(shape, key) for key in _SIZES.get(shape.tag, ())}


def _write_fixed_link(robot: Element, name: str, carrier: str, placement: pin.SE3) -> None:
    """Write a link without mass, fixed on the frame of another."""
    SubElement(robot, "link", name=name)
    _joint(robot, f"{name}_fixed", "fixed", carrier, name, placement)


def _write_joint(robot: Element, joint: Element, poses: Poses) -> None:
    """Write a joint with its axis, limits, coupling and drive.

    Raises:
        RobotError: of a type that is not read, without an axis, or with a spring.
    """
    name = joint.get("name", "")
    kind = joint.get("type", "").lower()
    parent = poses.end(joint, "parent")
    child = poses.end(joint, "child")
    if kind not in _JOINTS:
        raise RobotError(
            f'joint "{name}" is of type "{kind}", which is not read; read are {listed(_JOINTS)}'
        )
    # A URDF places a joint in the frame of the link that carries it.
    placement = poses.carried(parent).inverse() * poses.joint(name)
    out = _joint(robot, name, kind, parent, child, placement)
    if kind == "fixed":
        return
    axis = joint.find("axis")
    if axis is None:
        raise RobotError(
            f'joint "{name}" is {kind} and has no <axis>, which SDFormat requires; add one'
        )
    subject = f'joint "{name}": '
    if numbers_of(axis, "dynamics/spring_stiffness", 1, "0", subject).any():
        raise RobotError(
            f'joint "{name}" has a spring, which is not read; leave it out, or give it with --rotor'
        )
    SubElement(out, "axis", xyz=_joined(poses.axis(name, axis)))
    SubElement(out, "dynamics", damping=text_of(axis, "dynamics/damping", "0"))
    low = _limit(axis, "lower", subject)
    high = _limit(axis, "upper", subject)
    effort = _limit(axis, "effort", subject)
    limit: dict[str, str] = {}
    # A revolute joint without limits is a continuous one in a URDF.
    if low > -_UNLIMITED or high < _UNLIMITED:
        limit = {"lower": repr(low), "upper": repr(high)}
    elif kind == "revolute":
        out.set("type", "continuous")
    # A URDF without a limit of the effort says zero.
    limited_effort = effort if 0.0 < effort < _UNLIMITED else 0.0
    SubElement(out, "limit", limit | {"effort": repr(limited_effort)})
    _coupled(out, joint, axis)
    _driven(robot, joint)


def _coupled(out: Element, joint: Element, axis: Element) -> None:
    """Write the <mimic> of a joint.

    That of SDFormat 1.11 has a reference, the position at which the leader has no effect.
    """
    for rule in joint.findall("drake:mimic"):
        keys = [key for key in ("joint", "multiplier", "offset") if key in rule.attrib]
        SubElement(out, "mimic", {key: rule.get(key, "") for key in keys})
    name = joint.get("name")
    subject = f'joint "{name}": '
    for rule in axis.findall("mimic"):
        leading = rule.get("axis", "axis")
        if leading != "axis":
            raise RobotError(f'joint "{name}" follows "{leading}" of another, which is not read')
        multiplier = float(numbers_of(rule, "multiplier", 1, "1", subject)[0])
        offset = float(numbers_of(rule, "offset", 1, "0", subject)[0])
        reference = float(numbers_of(rule, "reference", 1, "0", subject)[0])
        # q = multiplier (q_leader − reference) + offset
        numbers = {"multiplier": repr(multiplier), "offset": repr(offset - multiplier * reference)}
        SubElement(out, "mimic", {"joint": rule.get("joint", "")} | numbers)


def _driven(robot: Element, joint: Element) -> None:
    """Write the drive of a joint as a transmission.

    Drake has it in the joint in SDFormat, and in the transmission in a URDF.
    """
    keys = ("drake:rotor_inertia", "drake:gear_ratio")
    drive = {key: text_of(joint, key) for key in keys if joint.find(key) is not None}
    if drive:
        transmission = SubElement(robot, "transmission")
        SubElement(transmission, "joint", name=joint.get("name", ""))
        actuator = SubElement(transmission, "actuator")
        for key, value in drive.items():
            SubElement(actuator, key, value=value)


def _joint(
    robot: Element, name: str, kind: str, parent: str, child: str, placement: pin.SE3
) -> Element:
    """A joint of a URDF, of which only its ends and its placement are known yet."""
    joint = _at(SubElement(robot, "joint", name=name, type=kind), placement)
    SubElement(joint, "parent", link=parent)
    SubElement(joint, "child", link=child)
    return joint


def _at(element: Element, placement: pin.SE3) -> Element:
    """An element with its <origin>."""
    SubElement(
        element,
        "origin",
        xyz=_joined(placement.translation),
        rpy=_joined(pin.rpy.matrixToRpy(placement.rotation)),
    )
    return element


def _joined(values: Array) -> str:
    return " ".join(map(repr, values.tolist()))


def _limit(axis: Element, key: str, subject: str) -> float:
    """A limit of a joint, or `_UNLIMITED` with its sign where a file has inf, 1e16 or nothing."""
    text = text_of(axis, f"limit/{key}", "-inf" if key == "lower" else "inf")
    if text in ("inf", "+inf", "-inf"):
        value = float(text)
    else:
        value = float(numbers_of(axis, f"limit/{key}", 1, subject=subject)[0])
    return min(max(value, -_UNLIMITED), _UNLIMITED)
