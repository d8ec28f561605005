"""The speed that shock is normalised by, v_in: of the fastest contact, or of the centre of mass (the paper's alternative)."""

import numpy as np

from shockpc.core.rounding import units_of
from shockpc.core.spatial import Array
from shockpc.errors import SceneError
from shockpc.health import ONE_DRAW, TRUSTED
from shockpc.landing import Landing
from shockpc.model.motion import terms_before, velocity_before
from shockpc.robot.robot import Robot
from shockpc.scene import Scene

__all__ = ["normalising_speed"]


def normalising_speed(scene: Scene, robot: Robot, landing: Landing) -> tuple[float, Array, tuple[str, ...]]:
    """The speed v_in [m/s], the velocity of the fastest contact (3,) [m/s], and a warning if v_in is known to few digits.

    Args:
        scene: complete.
        robot: its robot.
        landing: the same as arrays.

    Raises:
        SceneError: the centre of mass is asked for, and is at rest.
    """
    state, before = landing.state, landing.before
    fastest = int(np.argmax(np.linalg.norm(landing.approach, axis=1)))
    strike, touch = landing.approach[fastest], landing.touches[fastest]
    places, whose = [(touch.body, touch.point, 1.0)], f'contact "{touch.frame}"'
    if scene.v_in == "com":
        places, whose = [(i, body.com, body.mass / robot.mass) for i, body in enumerate(robot.bodies)], "the centre of mass"
    v_in = float(np.linalg.norm(sum(share * velocity_before(state, before, i, point)[0] for i, point, share in places)))
    if not v_in > 0.0:
        raise SceneError(
            'the robot\'s centre of mass is at rest before the impact, so it cannot normalise shock; use v_in = "contact"'
        )
    # A small difference of large velocities keeps their rounding.
    terms = float(np.linalg.norm(sum(share * terms_before(state, before, i, point)[1][0] for i, point, share in places)))
    error = ONE_DRAW * units_of(state.rotation[0]) * terms / v_in
    if error <= TRUSTED:
        return v_in, strike, ()
    return v_in, strike, (f"speed of {whose}, by which all shock is divided: good to about {min(error, 1.0):.0e} of itself only",)
