"""One robot in one landing, with a label."""

from dataclasses import dataclass, field

from shockpc.landing.scenes.scene import Scene
from shockpc.landing.scenes.scene_file import robot_of, scene_of
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

    @classmethod
    def of(cls, design: "Design | Scene | str") -> "Design":
        """A design as it is, or that of a scene, or of the name of a scene file or a robot."""
        if isinstance(design, Design):
            return design
        scene = scene_of(design)
        return cls(design if isinstance(design, str) else scene.robot, scene, robot_of(scene))
