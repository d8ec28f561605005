"""Poses of the links, joints and frames of an SDFormat model, and the links that carry them."""

from collections.abc import Callable
from typing import TypeVar
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array
from shockpc.robot.bodies_and_joints import WORLD
from shockpc.text.errors import RobotError
from shockpc.wings.sdf.elements import boolean, numbers_of, text_of

T = TypeVar("T")

AXES_OF_MODEL, POSE_FRAME = 4, 6
"""The last versions 1.N whose axes are the model's, and whose <pose> has `frame`."""


class Poses:
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
        self._poses = dict.fromkeys(("", "__model__"), pin.SE3.Identity())
        self._model = model
        self.above = {self.end(joint, "child"): name for name, joint in self._joints.items()}

    def of(self, name: str) -> pin.SE3:
        """Pose of the element with a name."""
        if name == WORLD and WORLD not in self._poses:
            if (near := self._reference(self._model, WORLD)) != WORLD:
                raise RobotError(
                    f'the pose of the model is relative to "{near}", which is not read; write it '
                    f"in the world"
                )
            self._poses[WORLD] = (
                self.of(self._model.get("placement_frame", ""))
                * pose_of(self._model.find("pose")).inverse()
            )
        return self._followed(
            name,
            self._poses,
            self._carrier,
            lambda part, pose: pose * pose_of(part.find("pose")),
            "a pose",
            "is relative to",
        )

    def link(self, name: str) -> str:
        """The link that a name is attached to; of the model itself its canonical link."""
        return self._followed(
            name, self._links, attached_to, lambda part, link: link, "a frame", "is attached to"
        )

    def end(self, joint: Element, end: str) -> str:
        """The parent or child link of a joint, which may name a frame; empty without one."""
        return self.link(name) if (name := text_of(joint, end)) else ""

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
        return self._reference(part, "" if part.tag == "link" else attached_to(part))

    def _reference(self, part: Element, near: str) -> str:
        """Name of the element that a <pose> is relative to: `near` if it does not say."""
        if (pose := part.find("pose")) is None:
            return near
        return (
            pose.get("relative_to") or (self._version <= POSE_FRAME and pose.get("frame")) or near
        )

    def placed(self, part: Element, near: str) -> pin.SE3:
        """Pose of an element by its <pose>, which is relative to `near` if it does not say."""
        return self.of(self._reference(part, near)) * pose_of(part.find("pose"))

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
        return self.placed(self._joints[name], text_of(self._joints[name], "child"))

    def axis(self, joint: str, axis: Element) -> Array:
        """The axis (3,) of a joint in its frame."""
        written = axis.find("xyz")
        of_model = self._version <= AXES_OF_MODEL
        if self._version <= POSE_FRAME:
            key = "use_parent_model_frame"
            of_model = of_model or boolean(text_of(axis, key), key)
        if of_model:
            frame = "__model__"
        else:
            frame = (written is not None and written.get("expressed_in")) or ""
        here = self.joint(joint)
        there = self.of(frame) if frame else here
        xyz = numbers_of(axis, "xyz", 3, "0 0 1", f'joint "{joint}": ')
        return np.asarray((here.inverse() * there).rotation @ xyz)


def attached_to(part: Element) -> str:
    """Name of the element that a joint or a frame is attached to."""
    return text_of(part, "child") if part.tag == "joint" else part.get("attached_to", "")


def pose_of(pose: Element | None) -> pin.SE3:
    """The transform of a <pose>: position [m], and angles about x, y, z [rad] or a quaternion."""
    if pose is None or not (pose.text or "").strip():
        return pin.SE3.Identity()
    degrees = boolean(pose.get("degrees", ""), "degrees of <pose>")
    form = pose.get("rotation_format") or "euler_rpy"
    if form not in ("euler_rpy", "quat_xyzw") or (degrees and form == "quat_xyzw"):
        unit = " in degrees" if degrees else ""
        raise RobotError(
            f'<pose> has rotation_format "{form}"{unit}; read are euler_rpy and quat_xyzw'
        )
    values = numbers_of(pose, "", 6 if form == "euler_rpy" else 7)
    if form == "euler_rpy":
        angles = np.radians(values[3:]) if degrees else values[3:]
        return pin.SE3(pin.rpy.rpyToMatrix(angles), values[:3])
    length = np.linalg.norm(values[3:])
    if not length > 0.0:
        raise RobotError(f'<pose> is "{pose.text}", whose quaternion has no length')
    return pin.SE3(pin.Quaternion(values[3:] / length).matrix(), values[:3])
