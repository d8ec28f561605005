"""What several studies ask for: a point that moves, and the strike angle."""

import numpy as np

from shockpc.errors import StudyError
from shockpc.landing import Landing
from shockpc.results.points import Spot, spot_of
from shockpc.robot.record import Robot
from shockpc.scene import Point

__all__ = ["moving_spot", "strike_angle"]


def moving_spot(robot: Robot, point: Point) -> Spot:
    """A point on a body.

    Raises:
        UnknownName: the robot has no frame of that name.
        StudyError: the frame is fixed to the world.
    """
    spot = spot_of(robot, point)
    if spot.frame.body < 0:
        raise StudyError(f'point "{spot.label}" is fixed to the world, so no strike moves it; name a frame on a moving link')
    return spot


def strike_angle(landing: Landing) -> float:
    """Angle of the base's velocity in the plane, from straight down towards forward [rad]."""
    velocity = landing.before.velocity
    return float(np.arctan2(velocity @ landing.plane.forward, -velocity[2]))
