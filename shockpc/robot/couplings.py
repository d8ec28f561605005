"""What a robot's file ties together beside its tree: joints that follow others, and loops."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array, read_only
from shockpc.errors import RobotError
from shockpc.robot.markup import parse_markup
from shockpc.robot.source import RobotSource
from shockpc.robot.urdf_numbers import vector

__all__ = ["Loop", "Mimic", "as_drawn", "loops_of", "mimics_of"]


@dataclass(frozen=True)
class Mimic:
    """A joint that follows another: q_joint = multiplier · q_leader + offset.

    Attributes:
        joint: the follower's name.
        leader: the name of the joint that it follows.
        multiplier: [1]
        offset: [rad, m]
    """

    joint: str
    leader: str
    multiplier: float
    offset: float


class Loop(NamedTuple):
    """Two bodies that are held together.

    Attributes:
        name: of the two ends.
        bodies: index of each end's body; −1 for the world.
        points: (3,) each end in its body's frame [m].
        rotations: (3, 3) each end's frame in its body's frame.
        axes: (n, 3) unit vectors along which the points are held, in the first end's frame.
        turns: whether the orientations are held too.
    """

    name: str
    bodies: tuple[int, int]
    points: tuple[Array, Array]
    rotations: tuple[Array, Array]
    axes: Array
    turns: bool


def as_drawn(model: pin.Model) -> Array:
    """The configuration (nq,) in which an MJCF draws its bodies: a free base at its place, a joint at its ref."""
    return next((entry.data() for entry in model.referenceConfigurations if entry.key() == "qpos0"), pin.neutral(model))


def loops_of(source: RobotSource, model: pin.Model, places: Sequence[pin.SE3], names: Sequence[str]) -> tuple[Loop, ...]:
    """The loops that an MJCF's connect and weld close, as MuJoCo does: where the file does not say it, its drawing does.

    Pinocchio's own reading takes the joint's frame for the body's, and another pose for relpose.

    Args:
        source: the robot as read.
        model: its model.
        places: every body's frame in its joint's frame.
        names: of the bodies.

    Raises:
        RobotError: a body or site does not exist.
    """
    if source.kind == "urdf" or "<equality" not in source.xml:
        return ()
    data = model.createData()
    pin.framesForwardKinematics(model, data, as_drawn(model))
    loops = []
    for tie in parse_markup(source.xml, source.path.name).iterfind("equality/*"):
        if tie.tag not in ("connect", "weld"):
            continue
        first, second = (_end(model, tie, number, source.path.name) for number in "12")
        bodies = tuple(model.frames[frame].parentJoint - 1 for frame in (first, second))
        if bodies[0] == bodies[1]:  # fixed to one another already
            continue
        ends = []
        for frame, body, held in zip((first, second), bodies, _held(tie, data.oMf[first], data.oMf[second]), strict=True):
            place = model.frames[frame].placement * held
            place = place if body < 0 else places[body].inverse() * place
            ends.append((read_only(place.translation), read_only(place.rotation)))
        (p_a, R_a), (p_b, R_b) = ends
        called = "–".join("world" if body < 0 else names[body] for body in bodies)
        loops.append(Loop(called, (bodies[0], bodies[1]), (p_a, p_b), (R_a, R_b), np.eye(3), tie.tag == "weld"))
    return tuple(loops)


def _end(model: pin.Model, tie: Element, number: str, file: str) -> int:
    """The frame of a body or site that an equality ties; 0 for the world."""
    for kind, called in ((pin.FrameType.OP_FRAME, "site"), (pin.FrameType.BODY, "body")):
        name = tie.get(called + number)
        if name is not None and name != "world":
            if not model.existFrame(name, kind):
                raise RobotError(f'{file}: an equality {tie.tag} names {called} "{name}", which does not exist; correct the name')
            return int(model.getFrameId(name, kind))
    return 0


def _held(tie: Element, first: pin.SE3, second: pin.SE3) -> tuple[pin.SE3, pin.SE3]:
    """The frames that an equality holds together, each in that of its body or site. Args: where the file draws these."""
    if "site1" in tie.attrib:
        return pin.SE3.Identity(), pin.SE3.Identity()
    held = pin.SE3(np.eye(3), np.array(vector(tie.get("anchor"), 3) or (0.0, 0.0, 0.0)))
    if tie.tag == "connect":
        return held, second.inverse() * first * held
    x, y, z, *quaternion = vector(tie.get("relpose"), 7) or (0.0,) * 7
    if any(quaternion):  # the anchor of the second body, in the frame of the first
        return pin.SE3(pin.Quaternion(*quaternion).normalized().matrix(), np.array([x, y, z])), held
    return first.inverse() * second * held, held


def mimics_of(source: RobotSource, model: pin.Model) -> tuple[Mimic, ...]:
    """The joints that follow others, leaders before followers. Pinocchio reads them as free ones; `freedom` ties them.

    A fixed joint follows nothing, whatever its file says; one that follows a fixed joint stays where its offset puts it.

    Raises:
        RobotError: joints follow one another in a circle, or one that is to follow or lead has several degrees of freedom.
    """
    found = _proportional(source, model) if source.kind == "mjcf" else _mimicking(source, model)
    for mimic in found:
        for name in (mimic.joint, mimic.leader):
            freedom = model.joints[model.getJointId(name)].nv if model.existJointName(name) else 1
            if freedom != 1:
                raise RobotError(
                    f'{source.path.name}: joint "{mimic.joint}" is to follow "{mimic.leader}", but "{name}" has {freedom} degrees '
                    "of freedom, and only a joint with one can follow or lead; give it one axis, or take the coupling out"
                )
    return _leaders_first(found, source.path.name)


def _mimicking(source: RobotSource, model: pin.Model) -> list[Mimic]:
    """The joints of a URDF that mimic others."""
    found: list[Mimic] = []
    if "<mimic" not in source.xml:
        return found
    for joint in parse_markup(source.xml, source.path.name).iter("joint"):
        for mimic in joint.findall("mimic"):
            if not model.existJointName(joint.get("name", "")):
                continue
            multiplier, offset = float(mimic.get("multiplier", "1")), float(mimic.get("offset", "0"))
            found.append(Mimic(joint.get("name", ""), mimic.get("joint", ""), multiplier, offset))
    return found


def _proportional(source: RobotSource, model: pin.Model) -> list[Mimic]:
    """The joints that an MJCF's equalities couple: q1 − q1₀ = a0 + a1 (q2 − q2₀), or a constant without a second joint."""
    found: list[Mimic] = []
    if "<equality" not in source.xml:
        return found
    start = as_drawn(model)

    def rest(name: str) -> float:
        return float(start[model.joints[model.getJointId(name)].idx_q]) if model.existJointName(name) else 0.0

    for tie in parse_markup(source.xml, source.path.name).iterfind("equality/joint"):
        follower, leader = tie.get("joint1", ""), tie.get("joint2", "")
        for name in (follower, leader):
            if name and not model.existJointName(name):
                raise RobotError(
                    f'{source.path.name}: an equality couples joint "{name}", which is not a joint of its own here; '
                    "give each of a body's joints a body"
                )
        a0, a1 = ([float(word) for word in tie.get("polycoef", "0 1").split()] + [0.0, 0.0])[:2]
        slope = a1 if leader else 0.0
        found.append(Mimic(follower, leader, slope, rest(follower) + a0 - slope * rest(leader)))
    return found


def _leaders_first(found: list[Mimic], file: str) -> tuple[Mimic, ...]:
    """Mimic joints ordered so that each comes after the one that it follows."""
    ordered: list[Mimic] = []
    while found:
        waiting = {mimic.joint for mimic in found}
        ready = [mimic for mimic in found if mimic.leader not in waiting]
        if not ready:
            names = ", ".join(f'"{mimic.joint}"' for mimic in found)
            raise RobotError(f"{file}: mimic joints {names} follow one another in a circle; one of them has to lead")
        ordered += ready
        found = [mimic for mimic in found if mimic.leader in waiting]
    return tuple(ordered)
