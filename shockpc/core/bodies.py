"""Step 2: from the jump of the joint velocities to the jump of every body (shock paper, Eqs. 8 and 9).

The recursion Δv̂_i = Δv̂_parent(i) + S_i Δq̇_i from the base to the leaves, for all postures at once. Works only on arrays.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from shockpc.core.spatial import Array


def body_jumps(
    J: Array, dofs: Sequence[slice], parent: Sequence[int], position: Array, delta_qd: Array, bodies: Sequence[int] | None = None
) -> Array:
    """Jump of every body's spatial velocity, world axes, at the body frame's origin.

    Args:
        J: (N, 6, nv) twist (ω, v at the common origin) that each joint velocity gives to the bodies behind it.
        dofs: joint velocities of each body's joint.
        parent: index of the body that carries each body's joint; −1 for the world.
        position: (N, nb, 3) origins of the body frames, from the common origin [m].
        delta_qd: (N, nv, k) jumps of the joint velocities [rad/s, m/s].
        bodies: indices of those that are wanted, in that order; all by default.

    Returns: (N, nb, 6, k), angular part first [rad/s, m/s].
    """
    if bodies is not None:
        carried = sorted({i for body in bodies for i in _path(parent, body)})
        index = {body: i for i, body in enumerate(carried)}
        inner = [index.get(parent[body], -1) for body in carried]
        part = body_jumps(J, [dofs[body] for body in carried], inner, position[:, carried], delta_qd)
        return part[:, [index[body] for body in bodies]]
    # The posture comes last, so that every operation runs over contiguous numbers.
    twists, rates, places = (
        part.copy() for part in (J.transpose(2, 1, 0), delta_qd.transpose(1, 2, 0), position.transpose(1, 2, 0))
    )
    jumps = np.empty((len(parent), 6, *rates.shape[1:]), dtype=rates.dtype)
    for jump, columns, before in zip(jumps, dofs, parent, strict=True):
        if columns.stop - columns.start == 1:
            np.multiply(twists[columns.start, :, None], rates[columns.start], out=jump)
        else:
            np.einsum("cin,ckn->ikn", twists[columns], rates[columns], out=jump)
        if before >= 0:
            jump += jumps[before]
    x, y, z = (places[:, i, None] for i in range(3))
    a, b, c = (jumps[:, i] for i in range(3))
    # v_i = v_O + ω × p_i
    jumps[:, 3] += b * z - c * y
    jumps[:, 4] += c * x - a * z
    jumps[:, 5] += a * y - b * x
    return jumps.transpose(3, 0, 1, 2)


def in_body_axes(jumps: Array, rotation: Array) -> Array:
    """Jumps (N, nb, 6, k) in the axes of the bodies' frames. Args: jumps, in world axes; rotation (N, nb, 3, 3), body to world."""
    return np.asarray(np.swapaxes(rotation, -1, -2)[..., None, :, :] @ jumps.reshape(*jumps.shape[:2], 2, 3, -1)).reshape(
        jumps.shape
    )


def _path(parent: Sequence[int], body: int) -> Iterator[int]:
    """A body and all that carry it."""
    while body >= 0:
        yield body
        body = parent[body]
