"""What a robot's file holds beside its links, whatever its format: joints that follow others, loops, postures."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import pinocchio as pin

from shockpc.core.spatial import Array
from shockpc.errors import RobotError

__all__ = ["Built", "Loop", "Mimic", "leaders_first"]


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


class Built(NamedTuple):
    """What the reader of a format makes of a file.

    Attributes:
        model: the Pinocchio model, in which joints that follow others are independent.
        postures: reference configurations by name, each (nq,).
        mimics: joints that follow others, each after the one that it follows.
        loops: what the file holds together beside the tree.
        start: (nq,) configuration in which the file draws the robot; None if that is the neutral one.
        warnings: each with its consequence.
    """

    model: pin.Model
    postures: Mapping[str, Array]
    mimics: tuple[Mimic, ...]
    loops: tuple[Loop, ...]
    start: Array | None
    warnings: tuple[str, ...]


def leaders_first(found: list[Mimic], model: pin.Model, file: str) -> tuple[Mimic, ...]:
    """Order mimic joints so that each comes after the one that it follows.

    Args:
        found: the mimic joints in any order.
        model: the robot's model.
        file: the file's name, for messages.

    Raises:
        RobotError: joints follow one another in a circle, or one that is to follow or lead has several degrees of freedom.
    """
    for mimic in found:
        for name in (mimic.joint, mimic.leader):
            freedom = model.joints[model.getJointId(name)].nv if model.existJointName(name) else 1
            if freedom != 1:
                raise RobotError(
                    f'{file}: joint "{mimic.joint}" is to follow "{mimic.leader}", but "{name}" has {freedom} degrees '
                    "of freedom, and only a joint with one can follow or lead; give it one axis, or take the coupling out"
                )
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
