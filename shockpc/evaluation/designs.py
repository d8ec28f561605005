"""One robot in one landing, and what tells it from others."""

from dataclasses import dataclass, field

from shockpc.landing.scene import Scene
from shockpc.robot.changes import Change
from shockpc.robot.robot import Robot


@dataclass(frozen=True, eq=False)
class Design:
    """One robot in one landing.

    Attributes:
        label: what tells it from the others.
        scene: the landing.
        robot: the robot.
        changes: what was changed of the robot after it was loaded.
    """

    label: str
    scene: Scene = field(repr=False)
    robot: Robot = field(repr=False)
    changes: tuple[Change, ...] = ()
