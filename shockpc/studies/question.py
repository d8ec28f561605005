"""What several studies ask for: a point that moves, and the strike angle."""

import numpy as np

from shockpc.errors import StudyError
from shockpc.landing import Landing
from shockpc.places import Place, point_place
from shockpc.robot.record import Robot
from shockpc.scene import Point

__all__ = ["moving_point", "strike_angle"]


def moving_point(robot: Robot, point: Point) -> Place:
    """A point on a body.

    Raises:
        UnknownName: the robot has no frame of that name.
        StudyError: the frame is fixed to the world.
    """
    place = point_place(robot, point)
    if place.body < 0:
        raise StudyError(f'point "{place.name}" is fixed to the world, so no strike moves it; name a frame on a moving link')
    return place


def strike_angle(landing: Landing) -> float:
    """Angle of the base's velocity in the plane, from straight down towards forward [rad]."""
    velocity = landing.before.velocity
    return float(np.arctan2(velocity @ landing.plane.forward, -velocity[2]))
