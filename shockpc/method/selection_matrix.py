"""The joint velocities that are free: q̇ = G ẏ (shock paper, Eq. 7).

A base that cannot move, or moves only in the plane, a joint that holds, and a joint that follows
another are columns of G: fewer unknowns, the same equation.
"""

import numpy as np

from shockpc.core.spatial import Array, Plane
from shockpc.method.base import Base
from shockpc.robot.robot import Robot


def free_columns(
    robot: Robot, base: Base, plane: Plane, base_rotation: Array, locked: np.ndarray
) -> Array | None:
    """The columns G of the free joint velocities, or None where all are free.

    Args:
        robot: its mimic joints follow their leaders here.
        base: free; planar (moves and turns in the plane only); fixed. One that is not fixed needs
            a robot with a free base.
        plane: of the study.
        base_rotation: (..., 3, 3) orientation of the base, base to world.
        locked: (nv,) joint velocities that are held at zero.

    Returns: (..., nv, ny).
    """
    nv = robot.model.nv
    base_is_free = base == "free" or not robot.free_base
    if base_is_free and not robot.mimics and not locked.any():
        return None
    G = np.broadcast_to(np.eye(nv), (*base_rotation.shape[:-2], nv, nv)).copy()
    G[..., locked, :] = 0.0
    free = ~locked
    if robot.free_base and base == "fixed":
        free[:6] = False
    if base == "planar":
        # The base's joint velocity is written in base axes, linear part first; three columns span
        # the plane.
        to_base = np.swapaxes(base_rotation, -1, -2)
        G[..., :6, :6] = 0.0
        G[..., :3, 0] = to_base @ plane.e1
        G[..., :3, 1] = to_base @ plane.e2
        G[..., 3:6, 2] = to_base @ plane.normal
        free[3:6] = False
    index = {joint.name: joint.v.start for joint in robot.single_joints}
    for mimic in robot.mimics:
        # Substituting the leaders' rows, not their columns, serves chains of followers and
        # followers of a planar base alike.
        follower = index[mimic.joint]
        row = np.zeros_like(G[..., follower, :])
        for leader, multiplier in mimic.leaders.items():
            row += multiplier * G[..., index[leader], :]
        G[..., follower, :] = row
        free[follower] = False
    return np.ascontiguousarray(G[..., free])
