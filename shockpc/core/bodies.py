"""Step 2: from the jump of the joint velocities to the jump of every body (shock paper, Eqs. 8 and 9).

The recursion Δv̂_i = Δv̂_parent(i) + S_i Δq̇_i from the base to the leaves, for all postures at once. Works on arrays alone.
"""

from collections.abc import Sequence

import numpy as np

from shockpc.core.spatial import Array

__all__ = ["body_jumps"]


def body_jumps(J: Array, own: Sequence[slice], parent: Sequence[int], position: Array, delta_qd: Array) -> Array:
    """Jump of every body's spatial velocity, world axes, at the body frame's origin.

    Args:
        J: (N, 6, nv) twist (ω, v at the common origin) that each joint velocity gives to the bodies behind it.
        own: joint velocities of each body's joint.
        parent: index of the body that carries each body's joint; −1 for the world.
        position: (N, nb, 3) origins of the body frames, from the common origin [m].
        delta_qd: (N, nv, k) jumps of the joint velocities [rad/s, m/s].

    Returns: (N, nb, 6, k), angular part first [rad/s, m/s].
    """
    n, _, k = delta_qd.shape
    jumps = np.empty((n, len(parent), 6, k))
    for i, (columns, before) in enumerate(zip(own, parent, strict=True)):
        # A product of a column and a row costs less than a matrix product of the same.
        product = np.multiply if columns.stop - columns.start == 1 else np.matmul
        product(J[:, :, columns], delta_qd[:, columns], out=jumps[:, i])
        if before >= 0:
            jumps[:, i] += jumps[:, before]
    x, y, z = (position[:, :, i, None] for i in range(3))
    a, b, c = (jumps[:, :, i] for i in range(3))
    # v_i = v_O + ω × p_i
    jumps[:, :, 3] += b * z - c * y
    jumps[:, :, 4] += c * x - a * z
    jumps[:, :, 5] += a * y - b * x
    return jumps
