"""How a robot moves before it strikes: a velocity of its base, a somersault, a swinging leg."""

from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.model.dynamics import Dynamics

__all__ = ["Motion", "spin_before", "terms_before", "twists_before", "velocity_before"]


class Motion(NamedTuple):
    """A motion before an impact.

    Attributes:
        velocity: (3,) of the base frame's origin, world axes [m/s].
        omega: (3,) angular velocity of the base, world axes [rad/s].
        joint_rates: (nv,) rates of the joints [rad/s, m/s]; the base's entries are not used.
    """

    velocity: Array
    omega: Array
    joint_rates: Array


def twists_before(state: Dynamics, before: Motion) -> Array:
    """Twist (N, nb, 6) of every body before the impact: (ω, v of the point at the common origin), world axes."""
    rates = np.where(state.moves, before.joint_rates, 0.0)
    twist = rates @ np.swapaxes(state.J, -1, -2)
    twist[..., :3] += before.omega
    twist[..., 3:] += before.velocity
    return np.asarray(twist)


def velocity_before(state: Dynamics, before: Motion, body: int, point: Array) -> Array:
    """Velocity (N, 3) of a point of a body before the impact, world axes [m/s]. Args: point (3,) in the body's frame [m]."""
    twist = _twist_before(state, before, body)
    p = state.position[:, body] + state.rotation[:, body] @ point
    return np.asarray(twist[:, 3:] + np.cross(twist[:, :3], p))


def terms_before(state: Dynamics, before: Motion, body: int, point: Array) -> tuple[Array, Array]:
    """Sizes (N, 3) of the terms that the angular velocity of a body and the velocity of a point of it are sums of [rad/s, m/s]."""
    rates = np.abs(np.where(state.moves[body], before.joint_rates, 0.0))
    twist = np.abs(np.concatenate([before.omega, before.velocity])) + np.abs(state.J) @ rates
    reach = np.abs(state.position[:, body]) + np.abs(state.rotation[:, body]) @ np.abs(point)
    turned = twist[:, [1, 2, 0]] * reach[:, [2, 0, 1]] + twist[:, [2, 0, 1]] * reach[:, [1, 2, 0]]
    return twist[:, :3], twist[:, 3:] + turned


def spin_before(state: Dynamics, before: Motion, body: int) -> Array:
    """Angular velocity (N, 3) of a body before the impact, world axes [rad/s]."""
    return np.asarray(_twist_before(state, before, body)[:, :3])


def _twist_before(state: Dynamics, before: Motion, body: int) -> Array:
    """The twist (N, 6) of one body."""
    whole = np.concatenate([before.omega, before.velocity])
    return np.asarray(whole + state.J @ np.where(state.moves[body], before.joint_rates, 0.0))
