"""An SDFormat file, written as the URDF that means the same: the frame of a link is moved to the
joint that carries it.

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
"""What only its versions until 1.6 have besides."""

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
"""What SDFormat takes for what a link does not give."""

_UNLIMITED = 1e16  # a limit from which on SDFormat means none [rad, m]
# the last versions 1.N whose axes are the model's, and whose <pose> has `frame`
_AXES_OF_MODEL, _POSE_FRAME = 4, 6


def read(source: RobotSource, xacro: Mapping[str, str]) -> RobotSource:
    """Write the one model of a file that may move as a URDF.

    Raises:
        RobotError: it has several models or none, is of an unknown version, or something in it is
            not read.
    """
    file, root = source.path.name, parse_xml(source.xml, source.path.name)
    if not (version := re.fullmatch(r"1\.([2-9]|\d\d)", root.get("version", ""))):
        given = f'version "{root.get("version")}"' if root.get("version") else "no version"
        raise RobotError(
            f"{file} has {given}, which decides what its poses and axes mean; read are versions "
            f"from 1.2 on"
        )
    models = [
        model
        for path in ("model", "world/model")
        for model in root.findall(path)
        if not _yes(_text(model, "static"), "static")
    ]
    if len(models) != 1:
        raise RobotError(f"{file} has {len(models)} models that may move; give a file with one")
    (model,) = models
    refuse_count(sum(len(model.findall(path)) for path in ("link", "frame", "link/sensor")))
    # A visual shape gives a number only where there is no collision shape.
    refused = (
        _REFUSED
        if model.find("link/collision") is not None
        else (*_REFUSED, "link/visual/geometry/mesh/submesh")
    )
    for owner, path in (*((model, path) for path in refused), (root, "world/joint")):
        if (part := owner.find(path)) is not None:
            raise RobotError(
                f"{file}: <{part.tag}> ({path}) is not read; write out what it stands for"
            )
    poses, name = _Poses(model, int(version[1])), model.get("name") or source.robot_name
    moved = listed(
        link
        for link in poses.above
        if link in poses.named and not poses.of(link).isApprox(poses.carried(link), 1e-12)
    )
    notes = (
        [f"the frames of links {moved} are moved to the joints that carry them, as in a URDF"]
        if moved
        else []
    )
    tables = (SDF, SDF_UNTIL_1_6) if int(version[1]) <= _POSE_FRAME else (SDF,)
    notes += [*_notes(model), *(one.text for one in unread(model, *tables))]
    text = tostring(_urdf(model, name, poses), encoding="unicode")
    warnings = tuple(f"{file}: {note}" for note in notes)
    as_urdf = replace(source, xml=text, robot_name=name, warnings=warnings, all_driven=True)
    return with_postures(as_urdf)


def _notes(model: Element) -> Iterator[str]:
    """What is said of numbers that links do not give."""
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
    """Where links, joints and frames of a model stand, in its frame.

    Args: model, the element; version, N of its version 1.N.
    """

    def __init__(self, model: Element, version: int) -> None:
        self._joints, self._version = (
            {joint.get("name", ""): joint for joint in model.findall("joint")},
            version,
        )
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
        self._links = {"": canonical, "__model__": canonical, WORLD: WORLD} | {
            link: link for link in links
        }
        self._places = dict.fromkeys(("", "__model__"), pin.SE3.Identity())
        self._model = model
        self.above = {self.end(joint, "child"): name for name, joint in self._joints.items()}

    def of(self, name: str) -> pin.SE3:
        """Where what has a name stands."""
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
        """The link that a frame, or what is called so, is attached to; of the model itself its
        canonical one.
        """
        return self._followed(
            name, self._links, _attached, lambda part, link: link, "a frame", "is attached to"
        )

    def end(self, joint: Element, end: str) -> str:
        """The link that is the parent or the child of a joint, which may name a frame of it; empty
        if it names none.
        """
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
        """What is known of a name, which follows from what is known of another.

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
        """What the place of a link, a joint or a frame is relative to."""
        return self._reference(part, "" if part.tag == "link" else _attached(part))

    def _reference(self, part: Element, near: str) -> str:
        """What the <pose> of an element is relative to: what is `near` if it does not say."""
        if (pose := part.find("pose")) is None:
            return near
        return (
            pose.get("relative_to") or (self._version <= _POSE_FRAME and pose.get("frame")) or near
        )

    def placed(self, part: Element, near: str) -> pin.SE3:
        """Where an element stands by its <pose>, which is relative to what is `near` if it does not
        say.
        """
        return self.of(self._reference(part, near)) * _pose(part.find("pose"))

    def inertial(self, inertial: Element, link: str) -> pin.SE3:
        """Where the <inertial> of a link stands, which SDFormat has relative to the link only."""
        if (near := self._reference(inertial, link)) != link:
            raise RobotError(
                f'link "{link}": the pose of its <inertial> is relative to "{near}"; it has to be '
                f"relative to the link"
            )
        return self.placed(inertial, link)

    def carried(self, link: str) -> pin.SE3:
        """The frame of a link of the URDF: that of the joint that carries it, or the link's frame."""
        return self.joint(self.above[link]) if link in self.above else self.of(link)

    def joint(self, name: str) -> pin.SE3:
        """Where a joint stands."""
        return self.placed(self._joints[name], _text(self._joints[name], "child"))

    def axis(self, joint: str, axis: Element) -> Array:
        """The axis (3,) of a joint in its frame."""
        written, of_model = axis.find("xyz"), self._version <= _AXES_OF_MODEL
        if self._version <= _POSE_FRAME:
            of_model = of_model or _yes(
                _text(axis, "use_parent_model_frame"), "use_parent_model_frame"
            )
        frame, here = (
            "__model__"
            if of_model
            else (written is not None and written.get("expressed_in")) or "",
            self.joint(joint),
        )
        there = self.of(frame) if frame else here
        xyz = _numbers(axis, "xyz", 3, "0 0 1", f'joint "{joint}": ')
        return np.asarray((here.inverse() * there).rotation @ xyz)


def _urdf(model: Element, name: str, poses: _Poses) -> Element:
    """The URDF of a model, with a link for each of its sensors and frames."""
    robot, joints = Element("robot", name=name), model.findall("joint")
    if any(poses.end(joint, "parent") == WORLD for joint in joints):
        SubElement(robot, "link", name=WORLD)
    for link in model.findall("link"):
        link_name = link.get("name", "")
        frame, out = poses.carried(link_name).inverse(), SubElement(robot, "link", name=link_name)
        inertial = next(link.iterfind("inertial"), Element("inertial"))
        if _yes(inertial.get("auto", ""), "auto"):
            raise RobotError(
                f'link "{link_name}": <inertial auto> is not read; write out its mass, pose and '
                f"inertia"
            )
        body = _at(SubElement(out, "inertial"), frame * poses.inertial(inertial, link_name))
        SubElement(body, "mass", value=_text(inertial, "mass", "1"))
        SubElement(
            body,
            "inertia",
            {key: _text(inertial, f"inertia/{key}", default) for key, default in _MOMENTS.items()},
        )
        for part in (*link.findall("collision"), *link.findall("visual")):
            for shape in part.findall("geometry/*"):
                geometry = SubElement(
                    _at(SubElement(out, part.tag), frame * poses.placed(part, link_name)),
                    "geometry",
                )
                mesh = {"filename": _text(shape, "uri"), "scale": _text(shape, "scale", "1 1 1")}
                sizes = {key: _text(shape, key) for key in _SIZES.get(shape.tag, ())}
                SubElement(geometry, shape.tag, mesh if shape.tag == "mesh" else sizes)
        for sensor in link.findall("sensor"):
            mounted = sensor.get("name", "")
            SubElement(robot, "link", name=mounted)
            _joint(
                robot,
                f"{mounted}_fixed",
                "fixed",
                link_name,
                mounted,
                frame * poses.placed(sensor, link_name),
            )
    for marked in model.findall("frame"):
        frame_name = marked.get("name", "")
        place, carrier = poses.of(frame_name), poses.link(frame_name)
        SubElement(robot, "link", name=frame_name)
        _joint(
            robot,
            f"{frame_name}_fixed",
            "fixed",
            carrier,
            frame_name,
            poses.carried(carrier).inverse() * place,
        )
    for joint in joints:
        joint_name, kind, (parent, child) = (
            joint.get("name", ""),
            joint.get("type", "").lower(),
            (poses.end(joint, end) for end in ("parent", "child")),
        )
        if kind not in _JOINTS:
            raise RobotError(
                f'joint "{joint_name}" is of type "{kind}", which is not read; read are '
                f"{listed(_JOINTS)}"
            )
        out = _joint(
            robot,
            joint_name,
            kind,
            parent,
            child,
            poses.carried(parent).inverse() * poses.joint(joint_name),
        )
        axis = joint.find("axis")
        if kind == "fixed":
            continue
        if axis is None:
            raise RobotError(
                f'joint "{joint_name}" is {kind} and has no <axis>, which SDFormat requires; add '
                f"one"
            )
        subject = f'joint "{joint_name}": '
        if _numbers(axis, "dynamics/spring_stiffness", 1, "0", subject).any():
            raise RobotError(
                f'joint "{joint_name}" has a spring, which is not read; leave it out, or give it '
                f"with --rotor"
            )
        SubElement(out, "axis", xyz=_joined(poses.axis(joint_name, axis)))
        SubElement(out, "dynamics", damping=_text(axis, "dynamics/damping", "0"))
        low, high, effort = (_limit(axis, key, subject) for key in ("lower", "upper", "effort"))
        limited = low > -_UNLIMITED or high < _UNLIMITED
        limit = {"lower": repr(low), "upper": repr(high)} if limited else {}
        SubElement(
            out, "limit", limit | {"effort": repr(effort if 0.0 < effort < _UNLIMITED else 0.0)}
        )
        if kind == "revolute" and not limited:
            out.set("type", "continuous")
        _coupled(out, joint, axis)
        _driven(robot, joint)
    return robot


def _coupled(out: Element, joint: Element, axis: Element) -> None:
    """Write the <mimic> of a joint; that of SDFormat 1.11 has a reference, where the leader has no
    effect.
    """
    for rule in joint.findall("drake:mimic"):
        SubElement(
            out,
            "mimic",
            {
                key: rule.get(key, "")
                for key in ("joint", "multiplier", "offset")
                if key in rule.attrib
            },
        )
    for rule in axis.findall("mimic"):
        if (leading := rule.get("axis", "axis")) != "axis":
            raise RobotError(
                f'joint "{joint.get("name")}" follows "{leading}" of another, which is not read'
            )
        multiplier, offset, reference = (
            float(_numbers(rule, key, 1, default, f'joint "{joint.get("name")}": ')[0])
            for key, default in {"multiplier": "1", "offset": "0", "reference": "0"}.items()
        )
        numbers = {"multiplier": repr(multiplier), "offset": repr(offset - multiplier * reference)}
        SubElement(out, "mimic", {"joint": rule.get("joint", "")} | numbers)


def _driven(robot: Element, joint: Element) -> None:
    """Write the drive of a joint, which Drake has in the joint, as a transmission, where Drake has
    it in a URDF.
    """
    drive = {
        key: _text(joint, key)
        for key in ("drake:rotor_inertia", "drake:gear_ratio")
        if joint.find(key) is not None
    }
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
    """What a joint or a frame is attached to."""
    return _text(part, "child") if part.tag == "joint" else part.get("attached_to", "")


def _joined(values: Array) -> str:
    return " ".join(map(repr, values.tolist()))


def _text(element: Element, path: str, default: str = "") -> str:
    return element.findtext(path, default).strip() or default


def _yes(text: str, what: str) -> bool:
    """A boolean of SDFormat, false where none is written; `what` names it in messages."""
    if (
        value := {"1": True, "true": True, "0": False, "false": False, "": False}.get(text.lower())
    ) is None:
        raise RobotError(f'{what} is "{text}"; it has to be true, false, 1 or 0')
    return value


def _numbers(element: Element, path: str, size: int, default: str = "", subject: str = "") -> Array:
    """The numbers (size,) in an element below one, or in itself; `subject` begins the message about
    others.
    """
    text = _text(element, path, default) if path else element.text
    if (values := vector(text, size)) is None:
        tag, wanted = (
            path.rpartition("/")[2] or element.tag,
            "one finite number" if size == 1 else f"{size} finite numbers",
        )
        raise RobotError(f'{subject}<{tag}> is "{text}"; it has to be {wanted}')
    return values


def _limit(axis: Element, key: str, subject: str) -> float:
    """A limit of a joint, or `_UNLIMITED` with its sign; files write inf or 1e16 for that, or
    nothing.
    """
    text = _text(axis, f"limit/{key}", "-inf" if key == "lower" else "inf")
    value = (
        float(text)
        if text in ("inf", "+inf", "-inf")
        else float(_numbers(axis, f"limit/{key}", 1, subject=subject)[0])
    )
    return min(max(value, -_UNLIMITED), _UNLIMITED)


def _pose(pose: Element | None) -> pin.SE3:
    """What a <pose> says: a place [m], and angles about x, y and z [rad] or a quaternion."""
    if pose is None or not (pose.text or "").strip():
        return pin.SE3.Identity()
    degrees, form = (
        _yes(pose.get("degrees", ""), "degrees of <pose>"),
        pose.get("rotation_format") or "euler_rpy",
    )
    if form not in ("euler_rpy", "quat_xyzw") or (degrees and form == "quat_xyzw"):
        raise RobotError(
            f'<pose> has rotation_format "{form}"{" in degrees" * degrees}; read are euler_rpy and '
            f"quat_xyzw"
        )
    values = _numbers(pose, "", 6 if form == "euler_rpy" else 7)
    if form == "euler_rpy":
        return pin.SE3(
            pin.rpy.rpyToMatrix(np.radians(values[3:]) if degrees else values[3:]), values[:3]
        )
    if not (length := np.linalg.norm(values[3:])) > 0.0:
        raise RobotError(f'<pose> is "{pose.text}", whose quaternion has no length')
    return pin.SE3(pin.Quaternion(values[3:] / length).matrix(), values[:3])
