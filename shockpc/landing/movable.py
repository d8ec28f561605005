"""The parts of a landing that can move; a robot without any is refused."""

import numpy as np

from shockpc.core.spatial import Array, Plane
from shockpc.method.base import Base
from shockpc.method.selection_matrix import free_columns
from shockpc.robot.robot import Robot
from shockpc.text.errors import SceneError


def refuse_immovable(robot: Robot, base: Base, locked: np.ndarray) -> None:
    """Refuse a base that its file fixes, and a robot of which nothing can move.

    Args:
        robot: the robot.
        base: how its base is to move.
        locked: (nv,) joint velocities that are held at zero.

    Raises:
        SceneError: a base that its file fixes is asked to move, or nothing is left that can move.
    """
    if base != "fixed" and not robot.free_base:
        raise SceneError(
            f'robot "{robot.name}" has a fixed base in its file, so base = "{base}" is not '
            f"possible; load it with free=True, give its root body a <freejoint/>, or use "
            f'base = "fixed"'
        )
    free = ~locked
    if robot.free_base:
        free[:6] = base != "fixed"
    for mimic in robot.mimics:
        free[robot.joint(mimic.joint).v] = False
    if not free.any():
        raise SceneError(
            f'nothing of robot "{robot.name}" can move: its base is fixed and no joint is free; '
            f"free one of them"
        )


def movable_columns(
    robot: Robot, base: Base, plane: Plane, base_rotation: Array, locked: np.ndarray
) -> Array | None:
    """The columns G (..., nv, ny) of the free joint velocities, as of `method.selection_matrix`.

    Raises:
        SceneError: as of `refuse_immovable`.
    """
    refuse_immovable(robot, base, locked)
    return free_columns(robot, base, plane, base_rotation, locked)
