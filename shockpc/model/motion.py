"""How a robot moves before it strikes: the velocity and rotation of its base, and the rates of its joints."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array, velocity_at
from shockpc.model.dynamics import Dynamics
from shockpc.model.rows import Block, block_wrenches
from shockpc.robot.record import Robot

__all__ = ["Motion", "approach_speeds", "com_velocity", "twist_before"]


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


def twist_before(state: Dynamics, before: Motion, body: int) -> Array:
    """Twist (N, 6) of a body before the impact: ω, and v of its point at the base's origin, world axes [rad/s, m/s]."""
    whole = np.concatenate([before.omega, before.velocity])
    if not before.joint_rates.any():
        return np.broadcast_to(whole, (len(state.J), 6))
    return np.asarray(whole + state.J @ np.where(state.supports[body], before.joint_rates, 0.0))


def approach_speeds(state: Dynamics, blocks: Sequence[Block], before: Motion | None) -> Array:
    """The speeds b (N, nc, 4 or 3) that an impact undoes along each row, (1 + e) J_c q̇⁻ [m/s, rad/s].

    The first three columns are strikes of 1 m/s along world x, y and z, the last is that of a motion, if one is given. Rows of
    standing feet and of loops have none.
    """
    b = []
    for block in blocks:
        wrenches = block_wrenches(state, block)
        speeds = np.zeros((*wrenches.shape[:2], 3 if before is None else 4), dtype=wrenches.dtype)
        if block.kind == "contact":
            wrenches = wrenches + block.restitution * wrenches if block.restitution else wrenches
            speeds[..., :3] = wrenches[..., 3:]
            if before is not None:
                speeds[..., 3:] = wrenches @ twist_before(state, before, block.body)[..., None]
        b.append(speeds)
    return np.concatenate(b, axis=1)


def com_velocity(robot: Robot, state: Dynamics, before: Motion) -> Array:
    """Velocity (N, 3) of the robot's centre of mass before the impact, world axes [m/s]."""
    total = np.zeros((len(state.J), 3))
    for i, (mass, com) in enumerate(zip(robot.masses, robot.coms, strict=True)):
        twist = twist_before(state, before, i)
        total += mass * velocity_at(twist[:, :3], twist[:, 3:], state.position[:, i] + state.rotation[:, i] @ com)
    return np.asarray(total / robot.mass)
