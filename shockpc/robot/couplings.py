"""What a robot's file holds beside its links, whatever its format: joints that follow others, loops, postures."""

from collections.abc import Mapping, Sequence
from graphlib import CycleError, TopologicalSorter
from typing import NamedTuple

import pinocchio as pin

from shockpc.core.spatial import Array
from shockpc.errors import RobotError
from shockpc.printed import listed

__all__ = ["Built", "Loop", "Mimic", "leaders_first"]


class Mimic(NamedTuple):
    """A joint that follows others: q_joint = Σ multiplier · q_leader + offset.

    Attributes:
        joint: the follower's name.
        leaders: multiplier [1] by the name of each joint that it follows; none if it stands still.
        offset: [rad, m]
    """

    joint: str
    leaders: Mapping[str, float]
    offset: float

    @property
    def led(self) -> str:
        """What it follows, for messages."""
        return f"joint{'s' * (len(self.leaders) > 1)} {listed(self.leaders)}" if self.leaders else "a constant"


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
    """What the reader of a format makes of a file: the fields of `Robot` of the same names; joints that follow are independent."""

    model: pin.Model
    start: Array
    postures: Mapping[str, Array]
    mimics: tuple[Mimic, ...]
    loops: tuple[Loop, ...] = ()
    notes: tuple[str, ...] = ()


def leaders_first(found: Sequence[Mimic], freedom: Mapping[str, int], file: str) -> tuple[Mimic, ...]:
    """Order mimic joints so that each comes after those that it follows, and leave out leaders that are fixed.

    Args:
        found: in any order.
        freedom: number of degrees of freedom of every joint that is not fixed.
        file: for messages.

    Raises:
        RobotError: joints follow one another in a circle, or one that is to follow or lead has several degrees of freedom.
    """
    for mimic in found:
        for name in (mimic.joint, *mimic.leaders):
            if freedom.get(name, 1) != 1:
                raise RobotError(
                    f'{file}: joint "{mimic.joint}" is to follow {mimic.led}, but "{name}" has {freedom[name]} degrees '
                    "of freedom, and only a joint with one can follow or lead; give it one axis, or take the coupling out"
                )
    followers = {
        mimic.joint: mimic._replace(leaders={name: by for name, by in mimic.leaders.items() if name in freedom}) for mimic in found
    }
    try:
        order = tuple(TopologicalSorter({name: mimic.leaders for name, mimic in followers.items()}).static_order())
    except CycleError as circle:
        names = listed(name for name in followers if name in circle.args[1])
        raise RobotError(f"{file}: mimic joints {names} follow one another in a circle; one of them has to lead") from None
    return tuple(followers[name] for name in order if name in followers)
