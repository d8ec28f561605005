"""Step 1 once more, in maximal coordinates: the independent check.

Every body has six unknown velocities of its own and every joint is a constraint, so neither the joint-space inertia nor its
factorisation is used:

    minimise  ½ Σ V_iᵀ M_i V_i + ½ q̇ᵀ diag(a) q̇     with   V_i = V_parent(i) + S_i q̇_i,   q̇ = G ẏ,   J V = −b

where q̇ are the jumps of the joint rates and a their armature. Larger and slower than Eq. 4, but it keeps its digits
where the joint-space inertia has lost them (light bodies under heavy ones, long chains).
"""

from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array, cross_matrix

__all__ = ["Tree", "solve_maximal"]


class Tree(NamedTuple):
    """Free bodies and the joints between them, in one posture; world axes, every point from one common origin.

    Attributes:
        parent: (nb,) index of the body that each body's joint hangs on; −1 for the world.
        mass: (nb,) [kg].
        com: (nb, 3) centres of mass [m].
        inertia: (nb, 3, 3) rotational inertias about the centres of mass [kg m²].
        joint: (nb, 3) a point at which each body's joint is written [m].
        S: (nb, 6, nv) twist (ω, v at that point) of each body against its parent, for unit joint rates.
        armature: (nv,) reflected inertia of each joint rate [kg m², kg].
        G: (nv, ny) which joint rates are free, q̇ = G ẏ.
    """

    parent: np.ndarray
    mass: Array
    com: Array
    inertia: Array
    joint: Array
    S: Array
    armature: Array
    G: Array


def solve_maximal(tree: Tree, rows: Array, b: Array) -> Array:
    """Jump of every body's twist, written at its own centre of mass.

    Args:
        tree: bodies and joints.
        rows: (nc, nb, 6) contact rows over the bodies' twists (ω, v at the centre of mass), independent of one another.
        b: (nc, k) speed to be undone along each row.

    Returns: (nb, 6, k) jumps (Δω, Δv at the centre of mass) [rad/s, m/s].
    """
    nb, ny, nc = len(tree.mass), tree.G.shape[1], len(rows)
    nx = 6 * nb + ny
    size = nx + 6 * nb + nc
    K = np.zeros((size, size))
    for i in range(nb):
        K[6 * i : 6 * i + 3, 6 * i : 6 * i + 3] = tree.inertia[i]
        K[6 * i + 3 : 6 * i + 6, 6 * i + 3 : 6 * i + 6] = tree.mass[i] * np.eye(3)
    K[6 * nb : nx, 6 * nb : nx] = tree.G.T @ (tree.armature[:, None] * tree.G)

    C = K[nx:, :nx]
    for i, p in enumerate(tree.parent):
        row = slice(6 * i, 6 * i + 6)
        C[row, row] = _twist_shift(tree.joint[i] - tree.com[i])
        if p >= 0:
            C[row, 6 * p : 6 * p + 6] = -_twist_shift(tree.joint[i] - tree.com[p])
    C[: 6 * nb, 6 * nb :] = -(tree.S.reshape(6 * nb, -1) @ tree.G)
    C[6 * nb :, : 6 * nb] = rows.reshape(nc, 6 * nb)
    K[:nx, nx:] = C.T

    rhs = np.zeros((size, b.shape[1]))
    rhs[nx + 6 * nb :] = -b
    scale = _equilibrate(K)
    solution = np.linalg.solve(K * scale[:, None] * scale[None, :], scale[:, None] * rhs)
    return np.asarray((scale[:, None] * solution)[: 6 * nb].reshape(nb, 6, -1))


def _twist_shift(r: Array) -> Array:
    """The 6×6 that writes a twist (ω, v) at a point r away from where it was written: v + ω × r."""
    X = np.eye(6)
    X[3:, :3] = -cross_matrix(r)
    return X


def _equilibrate(K: Array) -> Array:
    """Symmetric scaling that brings the largest entry of every row near one (Ruiz), so that pivoting sees the structure, not units."""
    scale = np.ones(len(K))
    A = np.abs(K)
    for _ in range(4):
        largest = (A * scale[:, None] * scale[None, :]).max(axis=1)
        scale /= np.sqrt(np.where(largest > 0.0, largest, 1.0))
    return scale
