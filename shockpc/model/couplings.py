"""What a robot's file ties together beside its tree: joints that follow others, and loops."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array, read_only
from shockpc.errors import RobotError
from shockpc.files.markup import parse_markup
from shockpc.files.source import RobotSource

__all__ = ["Loop", "Mimic", "loops_of", "mimics_of"]


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


def loops_of(constraints: list[Any], places: Sequence[pin.SE3], names: Sequence[str]) -> tuple[Loop, ...]:
    """The loops that Pinocchio read, written in body frames.

    Args:
        constraints: Pinocchio's models of them.
        places: every body's frame in its joint's frame.
        names: of the bodies.
    """
    loops = []
    for constraint in constraints:
        ends = []
        for joint, placement in (
            (constraint.joint1_id, constraint.joint1_placement),
            (constraint.joint2_id, constraint.joint2_placement),
        ):
            body = joint - 1
            place = placement if body < 0 else places[body].inverse() * placement
            ends.append((body, read_only(place.translation), read_only(place.rotation)))
        a, b = ends
        ends_named = ["world" if body < 0 else names[body] for body in (a[0], b[0])]
        turns = isinstance(constraint, pin.FrameAnchorConstraintModel)
        loops.append(Loop("–".join(ends_named), (a[0], b[0]), (a[1], b[1]), (a[2], b[2]), np.eye(3), turns))
    return tuple(loops)


def mimics_of(source: RobotSource, model: pin.Model) -> tuple[Mimic, ...]:
    """The joints that follow others, leaders before followers. Pinocchio reads them as free ones; `freedom` ties them.

    A fixed joint follows nothing, whatever its file says; one that follows a fixed joint stays where its offset puts it.
    """
    if source.kind == "mjcf":
        return _proportional(source, model)
    if "<mimic" not in source.xml:
        return ()
    found: list[Mimic] = []
    for joint in parse_markup(source.xml, source.path.name).iter("joint"):
        for mimic in joint.findall("mimic"):
            if not model.existJointName(joint.get("name", "")):
                continue
            multiplier, offset = float(mimic.get("multiplier", "1")), float(mimic.get("offset", "0"))
            found.append(Mimic(joint.get("name", ""), mimic.get("joint", ""), multiplier, offset))
    return _leaders_first(found, source.path.name)


def _proportional(source: RobotSource, model: pin.Model) -> tuple[Mimic, ...]:
    """The joints that an MJCF's equalities couple: q1 − q1₀ = a0 + a1 (q2 − q2₀), or a constant without a second joint."""
    if "<equality" not in source.xml:
        return ()
    start = next((entry.data() for entry in model.referenceConfigurations if entry.key() == "qpos0"), pin.neutral(model))

    def rest(name: str) -> float:
        return float(start[model.joints[model.getJointId(name)].idx_q]) if model.existJointName(name) else 0.0

    found = []
    for tie in parse_markup(source.xml, source.path.name).iterfind("equality/joint"):
        follower, leader = tie.get("joint1", ""), tie.get("joint2", "")
        for name in (follower, leader):
            if name and not model.existJointName(name):
                raise RobotError(
                    f'{source.path.name}: an equality couples joint "{name}", which is not a joint of its own here; '
                    "give each of a body's joints a body"
                )
        if tie.get("active", "true") == "false":
            continue
        a0, a1 = ([float(word) for word in tie.get("polycoef", "0 1").split()] + [0.0, 0.0])[:2]
        slope = a1 if leader else 0.0
        found.append(Mimic(follower, leader, slope, rest(follower) + a0 - slope * rest(leader)))
    return _leaders_first(found, source.path.name)


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
