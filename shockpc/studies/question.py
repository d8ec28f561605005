"""What several studies ask for: a point that moves, a strike angle, the value of a joint."""

import numpy as np

from shockpc.core.spatial import Array
from shockpc.errors import StudyError
from shockpc.landing import Landing
from shockpc.results.points import Spot, spot_of
from shockpc.robot.robot import Joint, Robot
from shockpc.scene import Point

__all__ = ["joint_value", "moving_spot", "strike_angle"]


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


def joint_value(joint: Joint, q: Array) -> float:
    """The value of a joint of one coordinate, or of its cosine and sine, in a configuration (nq,) [rad, m]; 0 for any other."""
    at = q[joint.q]
    return float(at[0]) if len(at) == 1 else float(np.arctan2(at[1], at[0])) if len(at) == 2 else 0.0
