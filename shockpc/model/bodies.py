"""Step 2: from the jump of the joint velocities to the jump of every body (shock paper, Eqs. 8 and 9).

The recursion Δv̂_i = Δv̂_parent(i) + S_i Δq̇_i, written out: a body's twist is the sum over the joints that move it.
"""

import numpy as np

from shockpc.core.spatial import Array
from shockpc.model.dynamics import Dynamics

__all__ = ["body_jumps"]


def body_jumps(state: Dynamics, delta_qd: Array) -> Array:
    """Jump of every body's spatial velocity, in body coordinates at the body frame's origin.

    Args:
        state: the robot in N postures.
        delta_qd: (N, nv, k) jumps of the joint velocities.

    Returns: (N, nb, 6, k), angular part first [rad/s, m/s].
    """
    twist = np.einsum("nav,bv,nvk->nbak", state.J, state.moves.astype(float), delta_qd, optimize=True)
    omega, v_origin = twist[:, :, :3], twist[:, :, 3:]
    v = v_origin + np.cross(omega, state.position[..., None], axis=2)
    to_body = np.swapaxes(state.rotation, -1, -2)
    return np.concatenate([to_body @ omega, to_body @ v], axis=2)
