"""Shock at sensors and at points that were asked for."""

from typing import NamedTuple

import numpy as np

from shockpc.core.directions import extreme_directions
from shockpc.core.pulse import Pulse, peak_acceleration
from shockpc.core.spatial import Array, cross_matrix, velocity_at
from shockpc.result import PointShock
from shockpc.robot.landmarks import sensors
from shockpc.robot.robot import Frame, Robot
from shockpc.scene import GRAVITY, Point

__all__ = ["Spot", "point_maps", "point_shocks", "spots"]


class Spot(NamedTuple):
    """A named point on a robot.

    Attributes:
        label: as it is typed, FRAME or FRAME:x,y,z.
        frame: on which it lies.
        r: (3,) in the body's frame [m].
    """

    label: str
    frame: Frame
    r: Array


def spots(robot: Robot, asked: tuple[Point, ...]) -> tuple[Spot, ...]:
    """The robot's sensors, then the points asked for; each once.

    Raises:
        UnknownName: the robot has no frame of that name.
    """
    found = {name: Spot(name, robot.frames[name], robot.frames[name].offset) for name in sensors(robot)}
    for point in asked:
        frame, offset = robot.frame(point.frame), np.asarray(point.offset, dtype=float)
        label = point.frame + (":" + ",".join(f"{x:g}" for x in point.offset) if offset.any() else "")
        found[label] = Spot(label, frame, frame.offset + frame.rotation @ offset)
    return tuple(found.values())


def point_maps(maps: Array, r: Array) -> Array:
    """Jump of a point's velocity for unit strikes, from its body's map.

    Args:
        maps: (..., 6, 3) of the body, at its frame's origin.
        r: (..., 3) the point in the body's frame [m].

    Returns: (..., 3, 3).
    """
    return np.asarray(maps[..., 3:, :] - cross_matrix(r) @ maps[..., :3, :])


def point_shocks(
    robot: Robot,
    found: tuple[Spot, ...],
    rotation: Array,
    position: Array,
    jump: Array,
    maps: Array,
    v_in: float,
    up: Array,
    pulse: Pulse | None,
) -> tuple[PointShock, ...]:
    """Shock at every spot.

    Args:
        robot: the robot.
        found: the spots.
        rotation: (nb, 3, 3) body to world.
        position: (nb, 3) world [m].
        jump: (nb, 6) of every body, body axes at its frame's origin.
        maps: (nb, 6, 3) the same for unit strikes.
        v_in: speed that shock is normalised by [m/s].
        up: (3,) unit normal of the ground.
        pulse: for peak accelerations.
    """
    shocks = []
    for label, frame, r in found:
        i = frame.body
        if i < 0:
            shocks.append(PointShock(label, "world", r, np.zeros(3), 0.0, extreme_directions(np.zeros((3, 3)), up), None))
            continue
        delta_v = velocity_at(jump[i, :3], jump[i, 3:], r)
        size = float(np.linalg.norm(delta_v))
        shocks.append(
            PointShock(
                frame=label,
                body=robot.bodies[i].name,
                position=position[i] + rotation[i] @ r,
                delta_v=frame.rotation.T @ delta_v,
                shock=size / v_in,
                directions=extreme_directions(point_maps(maps[i], r), up),
                peak_g=None if pulse is None else peak_acceleration(size, pulse) / GRAVITY,
            )
        )
    return tuple(shocks)
