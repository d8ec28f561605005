"""The speed by which shock is normalised, v_in: of the fastest contact, or of the centre of mass (shock paper, Section 3.3)."""

from typing import NamedTuple

import numpy as np

from shockpc.core.percussion import norm
from shockpc.core.spatial import Array
from shockpc.errors import SceneError
from shockpc.exact.balls import Balls, balls, nearest
from shockpc.exact.proof import Enclosure
from shockpc.exact.solution import ExactImpact
from shockpc.landing import Landing

__all__ = ["Speed", "approach_in", "normalising_speed", "speed_in"]


class Speed(NamedTuple):
    """Speeds before the impact.

    Attributes:
        v_in: by which shock is normalised [m/s].
        approach: (n, 3) velocity of every contact point, world axes [m/s].
        strike: (3,) that of the fastest one.
    """

    v_in: float
    approach: Array
    strike: Array


def normalising_speed(landing: Landing, enclosure: Enclosure) -> Speed:
    """The speeds of a landing.

    Raises:
        SceneError: the speed of the centre of mass is asked for, and it is at rest.
    """
    fastest = float(np.abs(np.concatenate([landing.before.velocity, landing.before.omega, landing.before.joint_rates])).max())
    approach = enclosure.read(lambda impact: nearest(approach_in(impact, landing), fastest))
    v_in = enclosure.read(lambda impact: nearest(speed_in(impact, landing), 1e-12 * fastest)).item()
    if not v_in > 0.0:
        raise SceneError(
            'the robot\'s centre of mass is at rest before the impact, so it cannot normalise shock; use v_in = "contact"'
        )
    return Speed(v_in, approach, approach[np.argmax(np.linalg.norm(approach, axis=1))])


def speed_in(impact: ExactImpact, landing: Landing) -> Balls:
    """The speed v_in (1,)."""
    if landing.scene.v_in == "com":
        robot = landing.robot
        velocities, mass = impact.velocities_before(range(len(robot.bodies)), robot.coms), balls(robot.masses)
        return np.asarray(norm(np.sum(velocities * mass[:, None], axis=0) / np.sum(mass))[None])
    speeds = norm(approach_in(impact, landing))
    return np.array([max(speeds.tolist(), key=float)], dtype=object)


def approach_in(impact: ExactImpact, landing: Landing) -> Balls:
    """Velocity (n, 3) of every contact point before the impact, world axes."""
    blocks = impact.inputs.blocks[: len(landing.contacts)]
    return impact.velocities_before([block.body for block in blocks], np.array([block.point for block in blocks]))
