"""An SDFormat file, written as the URDF that means the same: the frame of a link is moved to the joint that carries it.

Poses may be relative to links, joints and frames of the model. What is not read is refused by name.
"""

from collections.abc import Mapping
from dataclasses import replace
from xml.etree.ElementTree import Element, SubElement, tostring

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array
from shockpc.robot.files import parse_xml
from shockpc.robot.robot import WORLD, RobotSource
from shockpc.robot.urdf import build, choose, with_postures
from shockpc.robot.urdf_numbers import vector
from shockpc.text.errors import RobotError
from shockpc.text.printed import listed

__all__ = ["build", "choose", "read"]

_JOINTS = ("revolute", "continuous", "prismatic", "fixed")
_SIZES = {"box": ("size",), "sphere": ("radius",), "cylinder": ("radius", "length"), "capsule": ("radius", "length")}
_MOMENTS = {"ixx": "1", "iyy": "1", "izz": "1", "ixy": "0", "ixz": "0", "iyz": "0"}
_NOT_READ = (
    "model", "include", "joint/axis2", "joint/axis/mimic", ".//pose[@rotation_format='quat_xyzw']", "link/inertial[@auto='true']",
    "link/collision/geometry/mesh/submesh",
)  # fmt: skip
_UNLIMITED = 1e16  # a limit from which on SDFormat means none [rad, m]


def read(source: RobotSource, xacro: Mapping[str, str]) -> RobotSource:
    """Write the one model of a file that may move as a URDF.

    Raises:
        RobotError: it has several models or none, or something in it is not read.
    """
    root = parse_xml(source.xml, source.path.name)
    models = [model for model in (*root.findall("model"), *root.findall("world/model")) if not _yes(model, "static")]
    if len(models) != 1:
        raise RobotError(f"{source.path.name} has {len(models)} models that may move; give a file with one")
    for path in _NOT_READ:
        if (part := models[0].find(path)) is not None:
            raise RobotError(f"{source.path.name}: <{part.tag}> ({path}) is not read; write out what it stands for")
    poses, name = _Poses(models[0], root.get("version", "")), models[0].get("name") or source.robot_name
    moved = listed(link for link in poses.above if link in poses.named and not poses.of(link).isApprox(poses.carried(link), 1e-12))
    bare = listed(link.get("name", "") for link in models[0].findall("link") if link.find("inertial") is None)
    notes = (
        f"the frames of links {moved} are moved to the joints that carry them, as in a URDF" if moved else "",
        f"links {bare} have no <inertial>, for which SDFormat takes 1 kg and 1 kg m²; write it if they have less" if bare else "",
    )
    text = tostring(_urdf(models[0], name, poses), encoding="unicode")
    return with_postures(
        replace(source, xml=text, robot_name=name, warnings=tuple(f"{source.path.name}: {note}" for note in notes if note))
    )


class _Poses:
    """Where links, joints and frames of a model stand, in its frame."""

    def __init__(self, model: Element, version: str) -> None:
        self._joints = {joint.get("name", ""): joint for joint in model.findall("joint")}
        # Until version 1.6 a joint may be called like a link, and poses are not relative to joints.
        self.named = self._joints | {part.get("name", ""): part for part in model if part.tag in ("link", "frame")}
        self.above = {_text(joint, "child"): joint.get("name", "") for joint in model.findall("joint")}
        self._world, self._old = _pose(model.find("pose")).inverse(), version in ("1.0", "1.2", "1.3", "1.4")

    def of(self, name: str, within: tuple[str, ...] = ()) -> pin.SE3:
        """Where what has a name stands. Args: within, names of what stands relative to it."""
        if name in ("", "__model__"):
            return pin.SE3.Identity()
        if name == WORLD:
            return self._world
        if (part := self.named.get(name)) is None or name in within:
            raise RobotError(f'a pose is relative to "{name}", which {"does not exist" if part is None else "is relative to it"}')
        near = {"link": "", "joint": _text(part, "child"), "frame": part.get("attached_to", "")}[part.tag]
        return self.placed(part, near, (*within, name))

    def placed(self, part: Element, near: str, within: tuple[str, ...] = ()) -> pin.SE3:
        """Where an element stands by its <pose>, which is relative to what is `near` if it does not say."""
        pose = part.find("pose")
        return self.of((pose is not None and pose.get("relative_to")) or near, within) * _pose(pose)

    def carried(self, link: str) -> pin.SE3:
        """The frame of a link of the URDF: that of the joint that carries it, or the link's frame."""
        return self.joint(self.above[link]) if link in self.above else self.of(link)

    def link(self, name: str, within: tuple[str, ...] = ()) -> str:
        """The link that a frame is attached to; of the model itself its first one. Args: within, as for `of`."""
        if name in ("", "__model__"):
            return next((link for link, part in self.named.items() if part.tag == "link"), WORLD)
        if name == WORLD:
            return WORLD
        if (part := self.named.get(name)) is None or name in within:
            what = "does not exist" if part is None else "is attached to it"
            raise RobotError(f'a frame is attached to "{name}", which {what}')
        if part.tag == "link":
            return name
        return self.link(_text(part, "child") if part.tag == "joint" else part.get("attached_to", ""), (*within, name))

    def joint(self, name: str) -> pin.SE3:
        """Where a joint stands."""
        return self.placed(self._joints[name], _text(self._joints[name], "child"))

    def axis(self, joint: str, axis: Element) -> Array:
        """The axis (3,) of a joint in its frame."""
        xyz, of_model = axis.find("xyz"), self._old or _yes(axis, "use_parent_model_frame")
        frame, here = (xyz is not None and xyz.get("expressed_in")) or "", self.joint(joint)
        there = self.of(frame) if frame or of_model else here
        return np.asarray((here.inverse() * there).rotation @ _numbers(axis, "xyz", 3, "0 0 1"))


def _urdf(model: Element, name: str, poses: _Poses) -> Element:
    """The URDF of a model, with a link for each of its sensors and frames."""
    robot, joints = Element("robot", name=name), model.findall("joint")
    if any(_text(joint, "parent") == WORLD for joint in joints):
        SubElement(robot, "link", name=WORLD)
    for link in model.findall("link"):
        link_name = link.get("name", "")
        frame, out = poses.carried(link_name).inverse(), SubElement(robot, "link", name=link_name)
        inertial = next(link.iterfind("inertial"), Element("inertial"))
        body = _at(SubElement(out, "inertial"), frame * poses.placed(inertial, link_name))
        SubElement(body, "mass", value=_text(inertial, "mass", "1"))
        SubElement(body, "inertia", {key: _text(inertial, f"inertia/{key}", default) for key, default in _MOMENTS.items()})
        for part in (*link.findall("collision"), *link.findall("visual")):
            for shape in part.findall("geometry/*"):
                geometry = SubElement(_at(SubElement(out, part.tag), frame * poses.placed(part, link_name)), "geometry")
                mesh = {"filename": _text(shape, "uri"), "scale": _text(shape, "scale", "1 1 1")}
                sizes = {key: _text(shape, key) for key in _SIZES.get(shape.tag, ())}
                SubElement(geometry, shape.tag, mesh if shape.tag == "mesh" else sizes)
        for sensor in link.findall("sensor"):
            mounted = sensor.get("name", "")
            SubElement(robot, "link", name=mounted)
            _joint(robot, f"{mounted}_fixed", "fixed", link_name, mounted, frame * poses.placed(sensor, link_name))
    for marked in model.findall("frame"):
        frame_name = marked.get("name", "")
        place, carrier = poses.of(frame_name), poses.link(frame_name)
        SubElement(robot, "link", name=frame_name)
        _joint(robot, f"{frame_name}_fixed", "fixed", carrier, frame_name, poses.carried(carrier).inverse() * place)
    for joint in joints:
        joint_name, kind, (parent, child) = (
            joint.get("name", ""),
            joint.get("type", ""),
            (_text(joint, end) for end in ("parent", "child")),
        )
        if kind not in _JOINTS:
            raise RobotError(f'joint "{joint_name}" is of type "{kind}", which is not read; read are {listed(_JOINTS)}')
        out = _joint(robot, joint_name, kind, parent, child, poses.carried(parent).inverse() * poses.joint(joint_name))
        axis = joint.find("axis")
        if kind == "fixed" or axis is None:
            continue
        if _numbers(axis, "dynamics/spring_stiffness", 1, "0").any():
            raise RobotError(f'joint "{joint_name}" has a spring, which is not read; leave it out, or give it with --rotor')
        SubElement(out, "axis", xyz=_joined(poses.axis(joint_name, axis)))
        SubElement(out, "dynamics", damping=_text(axis, "dynamics/damping", "0"))
        low, high, effort = (_limit(axis, key) for key in ("lower", "upper", "effort"))
        limited = low > -_UNLIMITED or high < _UNLIMITED
        limit = {"lower": repr(low), "upper": repr(high)} if limited else {}
        SubElement(out, "limit", limit | {"effort": repr(effort if 0.0 < effort < _UNLIMITED else 0.0)})
        if kind == "revolute" and not limited:
            out.set("type", "continuous")
    return robot


def _joint(robot: Element, name: str, kind: str, parent: str, child: str, place: pin.SE3) -> Element:
    """A joint of a URDF, of which only its ends and its place are known yet."""
    joint = _at(SubElement(robot, "joint", name=name, type=kind), place)
    SubElement(joint, "parent", link=parent)
    SubElement(joint, "child", link=child)
    return joint


def _at(element: Element, place: pin.SE3) -> Element:
    """An element with its <origin>."""
    SubElement(element, "origin", xyz=_joined(place.translation), rpy=_joined(pin.rpy.matrixToRpy(place.rotation)))
    return element


def _joined(values: Array) -> str:
    return " ".join(map(repr, values.tolist()))


def _text(element: Element, path: str, default: str = "") -> str:
    return element.findtext(path, default).strip() or default


def _yes(element: Element, path: str) -> bool:
    return _text(element, path) in ("1", "true")


def _numbers(element: Element, path: str, size: int, default: str = "") -> Array:
    """The numbers (size,) in an element below one, or in itself."""
    text = _text(element, path, default) if path else element.text
    if (values := vector(text, size)) is None:
        raise RobotError(f'<{path.rpartition("/")[2] or element.tag}> is "{text}"; it has to be {size} finite numbers')
    return values


def _limit(axis: Element, key: str) -> float:
    """A limit of a joint, or `_UNLIMITED` with its sign; files write inf or 1e16 for that, or nothing."""
    text = _text(axis, f"limit/{key}", "-inf" if key == "lower" else "inf")
    value = float(text) if text.lstrip("+-") == "inf" else float(_numbers(axis, f"limit/{key}", 1)[0])
    return min(max(value, -_UNLIMITED), _UNLIMITED)


def _pose(pose: Element | None) -> pin.SE3:
    """What a <pose> says: a place [m], and angles about x, y and z [rad]."""
    if pose is None or not (pose.text or "").strip():
        return pin.SE3.Identity()
    values = _numbers(pose, "", 6)
    angles = np.radians(values[3:]) if pose.get("degrees") == "true" else values[3:]
    return pin.SE3(pin.rpy.rpyToMatrix(angles), values[:3])
