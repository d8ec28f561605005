"""An SDFormat file, written as a URDF with the same meaning.

The frame of a link is moved to the joint that carries it.

Poses may be relative to links, joints and frames of the model. What is not read is refused by name.
"""

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TypeVar
from xml.etree.ElementTree import Element, SubElement, tostring

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array
from shockpc.robot.bodies_and_joints import WORLD
from shockpc.robot.files.reading import parse_xml
from shockpc.robot.files.tags import unread
from shockpc.robot.robot import RobotSource
from shockpc.robot.tolerances import refuse_count
from shockpc.robot.urdf.numbers import vector
from shockpc.robot.urdf.reader import build, choose, with_postures
from shockpc.text.errors import RobotError
from shockpc.text.printed import listed

__all__ = ["build", "choose", "read"]

SDF = Path(__file__).with_name("tags.csv")
"""The table of tags of a <model>."""

SDF_UNTIL_1_6 = Path(__file__).with_name("tags_until_1_6.csv")
"""Tags that only the versions until 1.6 have."""

T = TypeVar("T")

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
# the last versions 1.N whose axes are the model's, and whose <pose> has `frame`
_AXES_OF_MODEL, _POSE_FRAME = 4, 6


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
    poses = _Poses(model, version)
    name = model.get("name") or source.robot_name
    tables = (SDF, SDF_UNTIL_1_6) if version <= _POSE_FRAME else (SDF,)
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
        if not _yes(_text(model, "static"), "static"):
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


def _moved_frames(poses: "_Poses") -> Iterator[str]:
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
            if link.find(path) is None or (path != "inertial" and not _text(link, path))
        )
        bare.setdefault(next(absent, ""), []).append(link.get("name", ""))
    for path in filter(None, bare):
        taken = f"no <{path.rpartition('/')[2]}>, for which SDFormat takes {_DEFAULTS[path]}"
        yield f"links {listed(bare[path])} have {taken}; write it if they have less"


class _Poses:
    """Poses of the links, joints and frames of a model, in its frame.

    Args: model, the element; version, N of its version 1.N.
    """

    def __init__(self, model: Element, version: int) -> None:
        self._joints = {joint.get("name", ""): joint for joint in model.findall("joint")}
        self._version = version
        # Until version 1.6 a joint may be called like a link, and poses are not relative to joints.
        self.named = self._joints | {
            part.get("name", ""): part for part in model if part.tag in ("link", "frame")
        }
        links = [link.get("name", "") for link in model.findall("link")]
        canonical = model.get("canonical_link") or next(iter(links), WORLD)
        if canonical not in (*links, WORLD):
            raise RobotError(
                f'the canonical_link of the model is "{canonical}", which does not exist'
            )
        self._links = {"": canonical, "__model__": canonical, WORLD: WORLD}
        self._links |= {link: link for link in links}
        self._places = dict.fromkeys(("", "__model__"), pin.SE3.Identity())
        self._model = model
        self.above = {self.end(joint, "child"): name for name, joint in self._joints.items()}

    def of(self, name: str) -> pin.SE3:
        """Pose of the element with a name."""
        if name == WORLD and WORLD not in self._places:
            if (near := self._reference(self._model, WORLD)) != WORLD:
                raise RobotError(
                    f'the pose of the model is relative to "{near}", which is not read; write it '
                    f"in the world"
                )
            self._places[WORLD] = (
                self.of(self._model.get("placement_frame", ""))
                * _pose(self._model.find("pose")).inverse()
            )
        return self._followed(
            name,
            self._places,
            self._carrier,
            lambda part, place: place * _pose(part.find("pose")),
            "a pose",
            "is relative to",
        )

    def link(self, name: str) -> str:
        """The link that a name is attached to; of the model itself its canonical link."""
        return self._followed(
            name, self._links, _attached, lambda part, link: link, "a frame", "is attached to"
        )

    def end(self, joint: Element, end: str) -> str:
        """The parent or child link of a joint, which may name a frame; empty without one."""
        return self.link(name) if (name := _text(joint, end)) else ""

    def _followed(
        self,
        name: str,
        known: dict[str, T],
        following: Callable[[Element], str],
        value: Callable[[Element, T], T],
        subject: str,
        relation: str,
    ) -> T:
        """The value of a name, which follows from that of another name.

        It and all between are known from then on.

        Args:
            name: the name.
            known: what is known already, by name.
            following: the name from which that of an element follows.
            value: what is known of an element, from what is known of that name.
            subject: with the relation, what the names say of one another, for messages.
            relation: as the subject.
        """
        passed: dict[str, Element] = {}
        while name not in known:
            part = self.named.get(name)
            if part is None or name in passed:
                raise RobotError(
                    f'{subject} {relation} "{name}", which '
                    f"{'does not exist' if part is None else f'{relation} it'}"
                )
            passed[name] = part
            name = following(part)
        result = known[name]
        for name, part in reversed(passed.items()):
            result = known[name] = value(part, result)
        return result

    def _carrier(self, part: Element) -> str:
        """Name of the element that the pose of a link, a joint or a frame is relative to."""
        return self._reference(part, "" if part.tag == "link" else _attached(part))

    def _reference(self, part: Element, near: str) -> str:
        """Name of the element that a <pose> is relative to: `near` if it does not say."""
        if (pose := part.find("pose")) is None:
            return near
        return (
            pose.get("relative_to") or (self._version <= _POSE_FRAME and pose.get("frame")) or near
        )

    def placed(self, part: Element, near: str) -> pin.SE3:
        """Pose of an element by its <pose>, which is relative to `near` if it does not say."""
        return self.of(self._reference(part, near)) * _pose(part.find("pose"))

    def inertial(self, inertial: Element, link: str) -> pin.SE3:
        """Pose of the <inertial> of a link, which SDFormat has relative to the link only."""
        if (near := self._reference(inertial, link)) != link:
            raise RobotError(
                f'link "{link}": the pose of its <inertial> is relative to "{near}"; it has to be '
                f"relative to the link"
            )
        return self.placed(inertial, link)

    def carried(self, link: str) -> pin.SE3:
        """The frame of a link of the URDF: that of the joint that carries it, or the link's own."""
        return self.joint(self.above[link]) if link in self.above else self.of(link)

    def joint(self, name: str) -> pin.SE3:
        """Pose of a joint."""
        return self.placed(self._joints[name], _text(self._joints[name], "child"))

    def axis(self, joint: str, axis: Element) -> Array:
        """The axis (3,) of a joint in its frame."""
        written = axis.find("xyz")
        of_model = self._version <= _AXES_OF_MODEL
        if self._version <= _POSE_FRAME:
            key = "use_parent_model_frame"
            of_model = of_model or _yes(_text(axis, key), key)
        if of_model:
            frame = "__model__"
        else:
            frame = (written is not None and written.get("expressed_in")) or ""
        here = self.joint(joint)
        there = self.of(frame) if frame else here
        xyz = _numbers(axis, "xyz", 3, "0 0 1", f'joint "{joint}": ')
        return np.asarray((here.inverse() * there).rotation @ xyz)


def _urdf(model: Element, name: str, poses: _Poses) -> Element:
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


def _write_link(robot: Element, link: Element, poses: _Poses) -> None:
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
    out: Element, link: Element, name: str, poses: _Poses, to_carried: pin.SE3
) -> None:
    """Write mass and inertia of a link.

    Raises:
        RobotError: they are left to the program that reads the file.
    """
    inertial = next(link.iterfind("inertial"), Element("inertial"))
    if _yes(inertial.get("auto", ""), "auto"):
        raise RobotError(
            f'link "{name}": <inertial auto> is not read; write out its mass, pose and inertia'
        )
    body = _at(SubElement(out, "inertial"), to_carried * poses.inertial(inertial, name))
    SubElement(body, "mass", value=_text(inertial, "mass", "1"))
    moments = {}
    for key, default in _MOMENTS.items():
        moments[key] = _text(inertial, f"inertia/{key}", default)
    SubElement(body, "inertia", moments)


def _dimensions(shape: Element) -> dict[str, str]:
    """File and scale of a mesh, or the sizes of another shape."""
    if shape.tag == "mesh":
        return {"filename": _text(shape, "uri"), "scale": _text(shape, "scale", "1 1 1")}
    return {key: _text(shape, key) for key in _SIZES.get(shape.tag, ())}


def _write_fixed_link(robot: Element, name: str, carrier: str, placement: pin.SE3) -> None:
    """Write a link without mass, fixed on the frame of another."""
    SubElement(robot, "link", name=name)
    _joint(robot, f"{name}_fixed", "fixed", carrier, name, placement)


def _write_joint(robot: Element, joint: Element, poses: _Poses) -> None:
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
    if _numbers(axis, "dynamics/spring_stiffness", 1, "0", subject).any():
        raise RobotError(
            f'joint "{name}" has a spring, which is not read; leave it out, or give it with --rotor'
        )
    SubElement(out, "axis", xyz=_joined(poses.axis(name, axis)))
    SubElement(out, "dynamics", damping=_text(axis, "dynamics/damping", "0"))
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
        multiplier = float(_numbers(rule, "multiplier", 1, "1", subject)[0])
        offset = float(_numbers(rule, "offset", 1, "0", subject)[0])
        reference = float(_numbers(rule, "reference", 1, "0", subject)[0])
        # q = multiplier (q_leader − reference) + offset
        numbers = {"multiplier": repr(multiplier), "offset": repr(offset - multiplier * reference)}
        SubElement(out, "mimic", {"joint": rule.get("joint", "")} | numbers)


def _driven(robot: Element, joint: Element) -> None:
    """Write the drive of a joint as a transmission.

    Drake has it in the joint in SDFormat, and in the transmission in a URDF.
    """
    keys = ("drake:rotor_inertia", "drake:gear_ratio")
    drive = {key: _text(joint, key) for key in keys if joint.find(key) is not None}
    if drive:
        transmission = SubElement(robot, "transmission")
        SubElement(transmission, "joint", name=joint.get("name", ""))
        actuator = SubElement(transmission, "actuator")
        for key, value in drive.items():
            SubElement(actuator, key, value=value)


def _joint(
    robot: Element, name: str, kind: str, parent: str, child: str, place: pin.SE3
) -> Element:
    """A joint of a URDF, of which only its ends and its place are known yet."""
    joint = _at(SubElement(robot, "joint", name=name, type=kind), place)
    SubElement(joint, "parent", link=parent)
    SubElement(joint, "child", link=child)
    return joint


def _at(element: Element, place: pin.SE3) -> Element:
    """An element with its <origin>."""
    SubElement(
        element,
        "origin",
        xyz=_joined(place.translation),
        rpy=_joined(pin.rpy.matrixToRpy(place.rotation)),
    )
    return element


def _attached(part: Element) -> str:
    """Name of the element that a joint or a frame is attached to."""
    return _text(part, "child") if part.tag == "joint" else part.get("attached_to", "")


def _joined(values: Array) -> str:
    return " ".join(map(repr, values.tolist()))


def _text(element: Element, path: str, default: str = "") -> str:
    return element.findtext(path, default).strip() or default


def _yes(text: str, what: str) -> bool:
    """A boolean of SDFormat, false where none is written; `what` names it in messages."""
    words = {"1": True, "true": True, "0": False, "false": False, "": False}
    value = words.get(text.lower())
    if value is None:
        raise RobotError(f'{what} is "{text}"; it has to be true, false, 1 or 0')
    return value


def _numbers(element: Element, path: str, size: int, default: str = "", subject: str = "") -> Array:
    """The numbers (size,) in an element below another, or in itself.

    `subject` begins the message about other content.
    """
    text = _text(element, path, default) if path else element.text
    values = vector(text, size)
    if values is None:
        tag = path.rpartition("/")[2] or element.tag
        wanted = "one finite number" if size == 1 else f"{size} finite numbers"
        raise RobotError(f'{subject}<{tag}> is "{text}"; it has to be {wanted}')
    return values


def _limit(axis: Element, key: str, subject: str) -> float:
    """A limit of a joint, or `_UNLIMITED` with its sign where a file has inf, 1e16 or nothing."""
    text = _text(axis, f"limit/{key}", "-inf" if key == "lower" else "inf")
    if text in ("inf", "+inf", "-inf"):
        value = float(text)
    else:
        value = float(_numbers(axis, f"limit/{key}", 1, subject=subject)[0])
    return min(max(value, -_UNLIMITED), _UNLIMITED)


def _pose(pose: Element | None) -> pin.SE3:
    """The transform of a <pose>: position [m], and angles about x, y, z [rad] or a quaternion."""
    if pose is None or not (pose.text or "").strip():
        return pin.SE3.Identity()
    degrees = _yes(pose.get("degrees", ""), "degrees of <pose>")
    form = pose.get("rotation_format") or "euler_rpy"
    if form not in ("euler_rpy", "quat_xyzw") or (degrees and form == "quat_xyzw"):
        unit = " in degrees" if degrees else ""
        raise RobotError(
            f'<pose> has rotation_format "{form}"{unit}; read are euler_rpy and quat_xyzw'
        )
    values = _numbers(pose, "", 6 if form == "euler_rpy" else 7)
    if form == "euler_rpy":
        angles = np.radians(values[3:]) if degrees else values[3:]
        return pin.SE3(pin.rpy.rpyToMatrix(angles), values[:3])
    length = np.linalg.norm(values[3:])
    if not length > 0.0:
        raise RobotError(f'<pose> is "{pose.text}", whose quaternion has no length')
    return pin.SE3(pin.Quaternion(values[3:] / length).matrix(), values[:3])
