"""Step 2: from the jump of the joint velocities to the jump of every body (shock paper, Eqs. 8 and 9).

The recursion Δv̂_i = Δv̂_parent(i) + S_i Δq̇_i from the base to the leaves, for all postures at once.
"""

import numpy as np

from shockpc.core.spatial import Array, cross_matrix, velocity_at
from shockpc.model.dynamics import Dynamics
from shockpc.robot.robot import Robot

__all__ = ["at_com", "body_jumps", "gyration_radii", "speed_of", "turning_lengths"]


def body_jumps(state: Dynamics, delta_qd: Array) -> Array:
    """Jump of every body's spatial velocity, in body coordinates at the body frame's origin.

    Args:
        state: the robot in N postures.
        delta_qd: (N, nv, k) jumps of the joint velocities.

    Returns: (N, nb, 6, k), angular part first [rad/s, m/s].
    """
    n, _, k = delta_qd.shape
    twists = np.empty((len(state.parent), n, 6, k))
    for i, parent in enumerate(state.parent):
        twists[i] = state.J[:, :, state.own[i]] @ delta_qd[:, state.own[i]]
        if parent >= 0:
            twists[i] += twists[parent]
    twist = np.moveaxis(twists, 0, 1)
    omega, v_origin = twist[:, :, :3], twist[:, :, 3:]
    v = v_origin - cross_matrix(state.position) @ omega
    to_body = np.swapaxes(state.rotation, -1, -2)
    return np.concatenate([to_body @ omega, to_body @ v], axis=2)


def gyration_radii(robot: Robot) -> Array:
    """Radius of gyration of every body about its centre of mass, for the mean axis (nb,) [m]; 0 for a body without mass."""
    mass = np.array([body.mass for body in robot.bodies])
    trace = np.array([np.trace(body.inertia) for body in robot.bodies])
    return np.asarray(np.sqrt(np.maximum(trace, 0.0) / 3.0 / np.where(mass > 0.0, mass, np.inf)))


def turning_lengths(robot: Robot) -> Array:
    """Length (nb,) by which a body's turning counts as a speed [m]: its radius of gyration, or the others' smallest if none."""
    radius = gyration_radii(robot)
    return np.asarray(np.where(radius > 0.0, radius, radius[radius > 0.0].min(initial=1.0)))


def at_com(robot: Robot, state: Dynamics, jump: Array) -> Array:
    """Jumps (nb, 6) from body axes at the body frames to world axes at the centres of mass. Args: state, first posture."""
    com = np.stack([body.com for body in robot.bodies])
    v_com = velocity_at(jump[:, :3], jump[:, 3:], com)
    rotation = state.rotation[0]
    return np.concatenate([(rotation @ jump[:, :3, None])[..., 0], (rotation @ v_com[..., None])[..., 0]], axis=1)


def speed_of(robot: Robot, twist: Array) -> Array:
    """Size (nb,) of a twist (nb, 6) at the centre of mass as a speed: translation, and rotation times radius of gyration."""
    turning = turning_lengths(robot) * np.linalg.norm(twist[:, :3], axis=-1)
    return np.asarray(np.hypot(np.linalg.norm(twist[:, 3:], axis=-1), turning))
