"""The package's own answers: the proven one, from which every error is measured, and those in double precision."""

import numpy as np

from shockpc.core.percussion import percussion, translation
from shockpc.core.spatial import Array
from shockpc.landing import Landing
from shockpc.profile import impact_jumps, shock_profile
from shockpc.robot.robot import Robot
from shockpc.scene import Scene

__all__ = ["double_jumps", "double_percussion", "reference"]


def reference(scene: Scene, robot: Robot) -> Array:
    """The proven jumps (nb, 6, 4) of all bodies (Δω, Δv), body coordinates at the body frames' origins, as the nearest doubles.

    Columns: unit strikes along world x, y and z, then the strike of the scene.

    Raises:
        ShockError: the landing has no answer.
    """
    return shock_profile(scene, robot).proof.jumps


def double_jumps(landing: Landing) -> Array:
    """Steps 1 and 2 in double precision for the scene's strike: jumps (nb, 6) in body coordinates at the body frames' origins."""
    _, _, jumps = impact_jumps(landing, landing.q[None])
    return np.asarray((jumps[0, ..., 3].reshape(-1, 2, 3) @ landing.state.rotation[0]).reshape(-1, 6))


def double_percussion(landing: Landing) -> Array:
    """Steps 1 to 3 in double precision: radii of percussion (nb,) [m]."""
    jumps = double_jumps(landing)
    omega, v, normal = jumps[:, :3], jumps[:, 3:], landing.plane.normal @ landing.state.rotation[0]
    return np.asarray(percussion(omega, v, normal, 1.0, *translation(omega, v, normal, 1.0, 1.0, 1e-9)).ropc)
