"""Step 2: from the jump of the joint velocities to the jump of every body (shock paper, Eqs. 8 and 9).

The recursion Δv̂_i = Δv̂_parent(i) + S_i Δq̇_i from the base to the leaves, for all postures at once.
"""

import numpy as np

from shockpc.core.spatial import Array, cross_matrix
from shockpc.model.dynamics import Dynamics

__all__ = ["body_jumps"]


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
