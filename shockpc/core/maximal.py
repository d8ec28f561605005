"""Step 1 once more, in maximal coordinates: the independent check.

Every body has six unknown velocities of its own and every joint is a constraint, so neither the joint-space inertia nor its
factorisation is used:

    minimise  ½ Σ V_iᵀ M_i V_i + ½ q̇ᵀ diag(a) q̇     with   V_i = V_parent(i) + S_i q̇_i,   q̇ = G ẏ,   W V = −b

where q̇ are the jumps of the joint rates and a their armature. Larger and slower than Eq. 4, but it keeps its digits where the
joint-space inertia has lost them (light bodies under heavy ones, long chains).
"""

from typing import NamedTuple

import numpy as np

from shockpc.core.rounding import shaken_rows, shaken_tree
from shockpc.core.spatial import Array, cross_matrix
from shockpc.core.tree import Tree

__all__ = ["MaximalSolution", "mobility", "refine", "solve_maximal"]

DENSE = 120
"""Bodies up to which a dense factorisation is quicker than loading and running a sparse one."""


class MaximalSolution(NamedTuple):
    """A solution for k right-hand sides, with what is needed to refine it.

    Attributes:
        twists: (nb, 6, k) jumps (Δω, Δv at the centre of mass) of every body, world axes [rad/s, m/s].
        delta_y: (ny, k) jumps of the free joint velocities.
        impulse: (nc, k) impulse along each row [N s].
        through: (nb, 6, k) moment about each body's joint [N m s] and force [N s] on the body from its parent, world axes.
        x: (n, k) all unknowns of the equilibrated system.
        entries: (rows, columns, values) of the equilibrated matrix.
        scale: (n,) its equilibration.
        rhs: (n, k) its right-hand sides.
    """

    twists: Array
    delta_y: Array
    impulse: Array
    through: Array
    x: Array
    entries: tuple[np.ndarray, np.ndarray, Array]
    scale: Array
    rhs: Array


def solve_maximal(tree: Tree, W: Array, b: Array) -> MaximalSolution:
    """Solve for the jump of every body.

    Args:
        tree: bodies and joints.
        W: (nc, nb, 6) rows over the bodies' twists (ω, v at the centre of mass), independent of one another.
        b: (nc, k) speed to be undone along each row.

    Raises:
        numpy.linalg.LinAlgError: the system is singular.
    """
    entries, scale = _equilibrated(tree, W)
    rhs = np.zeros((len(scale), b.shape[1]))
    held = slice(len(scale) - len(b), None)
    rhs[held] = -scale[held, None] * b
    return _unpack(tree, _solve(entries, rhs, len(tree.mass)), entries, scale, rhs)


def mobility(tree: Tree, W: Array, at: Array) -> Array:
    """How a mechanism gives way: the speed (n, n) along each of n unit wrenches for a unit impulse along each [1/kg].

    Args:
        tree: bodies and joints.
        W: (nc, nb, 6) rows that stay held, independent of one another.
        at: (n, nb, 6) the wrenches, in duality with the bodies' twists (ω, v at the centre of mass).

    Raises:
        numpy.linalg.LinAlgError: the system is singular.
    """
    nb = len(tree.mass)
    entries, scale = _equilibrated(tree, W)
    push = at.reshape(len(at), 6 * nb)
    rhs = np.zeros((len(scale), len(at)))
    rhs[: 6 * nb] = scale[: 6 * nb, None] * push.T
    return np.asarray(push @ (scale[:, None] * _solve(entries, rhs, nb))[: 6 * nb])


def refine(tree: Tree, W: Array, solution: MaximalSolution, samples: int, units: float) -> tuple[MaximalSolution, Array]:
    """One step of iterative refinement with the residual in extended precision, and what rounding in the data can still do.

    The refined unknowns solve the system as it stands in double precision; the numbers in it carry rounding themselves, so the
    effect of that is sampled: K⁻¹ (rhs − K' x) for the K' of slightly different mechanisms.

    Args:
        tree: bodies and joints.
        W: (nc, nb, 6) rows, as they were solved with.
        solution: of `solve_maximal`.
        samples: how many different mechanisms.
        units: size of the rounding in them [1].

    Returns: the refined solution, and the spread (nb, 6, k) that rounding makes of its twists.
    """
    x, rhs, scale, nb = solution.x, solution.rhs, solution.scale, len(tree.mass)
    rows, columns, values = solution.entries
    left = rhs.astype(np.longdouble)
    np.subtract.at(left, rows, values.astype(np.longdouble)[:, None] * x.astype(np.longdouble)[columns])
    sides = [left.astype(float)]
    draw = np.random.default_rng(0)
    size = max(float(np.abs(tree.com).max()), float(np.abs(tree.joint).max()))
    for _ in range(samples):
        rows, columns, values = _entries(shaken_tree(draw, units, tree, size), shaken_rows(draw, units, W, size))
        side = rhs.copy()
        np.subtract.at(side, rows, (values * scale[rows] * scale[columns])[:, None] * x[columns])
        sides.append(side)
    steps = _solve(solution.entries, np.concatenate(sides, axis=1), nb)
    k = rhs.shape[1]
    refined = _unpack(tree, x + steps[:, :k], solution.entries, scale, rhs)
    moved = (scale[:, None] * steps)[: 6 * nb].reshape(nb, 6, samples + 1, k)
    spread = np.abs(moved[:, :, 1:] - moved[:, :, :1]).max(axis=2, initial=0.0)
    # What one step leaves is the square of what it changed, relative to the whole.
    slow = np.linalg.norm(steps[:, :k]) / max(float(np.linalg.norm(x)), float(np.finfo(float).tiny))
    return refined, spread + slow * np.abs(moved[:, :, 0])


def _unpack(tree: Tree, x: Array, entries: tuple[np.ndarray, np.ndarray, Array], scale: Array, rhs: Array) -> MaximalSolution:
    """Undo the scaling and take the unknowns apart."""
    nb, ny = len(tree.mass), tree.free
    found = scale[:, None] * x
    twists, delta_y, through, impulse = np.split(found, np.cumsum([6 * nb, ny, 6 * nb]))
    # Multipliers push against the motion; the impulses are those of the ground on the robot, of the parent on the body.
    return MaximalSolution(twists.reshape(nb, 6, -1), delta_y, -impulse, -through.reshape(nb, 6, -1), x, entries, scale, rhs)


def _equilibrated(tree: Tree, W: Array) -> tuple[tuple[np.ndarray, np.ndarray, Array], Array]:
    """The entries of the equilibrated system, and its scaling."""
    rows, columns, values = _entries(tree, W)
    scale = _equilibrate(rows, columns, np.abs(values), 12 * len(tree.mass) + tree.free + len(W))
    return (rows, columns, values * scale[rows] * scale[columns]), scale


def _entries(tree: Tree, W: Array) -> tuple[np.ndarray, np.ndarray, Array]:
    """The nonzero entries (row, column, value) of the symmetric system in (V, ẏ, joint impulses, row impulses)."""
    nb, ny, nc = len(tree.mass), tree.free, len(W)
    nx = 6 * nb + ny
    found: list[tuple[np.ndarray, np.ndarray, Array]] = []

    def put(row: int, column: int, block: Array, mirrored: bool) -> None:
        i, j = np.nonzero(block)
        found.append((row + i, column + j, block[i, j]))
        if mirrored:
            found.append((column + j, row + i, block[i, j]))

    for i in range(nb):
        put(6 * i, 6 * i, tree.inertia[i], False)
        put(6 * i + 3, 6 * i + 3, tree.mass[i] * np.eye(3), False)
    G = tree.G
    put(6 * nb, 6 * nb, np.diag(tree.armature) if G is None else G.T @ (tree.armature[:, None] * G), False)
    for i, p in enumerate(tree.parent):
        put(nx + 6 * i, 6 * i, _twist_shift(tree.joint[i] - tree.com[i]), True)
        if p >= 0:
            put(nx + 6 * i, 6 * p, -_twist_shift(tree.joint[i] - tree.com[p]), True)
        put(nx + 6 * i, 6 * nb, -tree.S[i] if G is None else -(tree.S[i] @ G), True)
    put(nx + 6 * nb, 0, W.reshape(nc, 6 * nb), True)
    return (
        np.concatenate([rows for rows, _, _ in found]),
        np.concatenate([columns for _, columns, _ in found]),
        np.concatenate([values for _, _, values in found]),
    )


def _twist_shift(r: Array) -> Array:
    """The 6×6 that writes a twist (ω, v) at a point r away from where it was written: v + ω × r."""
    X = np.eye(6)
    X[3:, :3] = -cross_matrix(r)
    return X


def _equilibrate(rows: np.ndarray, columns: np.ndarray, size: Array, n: int) -> Array:
    """Symmetric scaling that brings every row's largest entry near one (Ruiz): pivoting then sees structure, not units."""
    scale = np.ones(n)
    for _ in range(4):
        largest = np.zeros(n)
        np.maximum.at(largest, rows, size * scale[rows] * scale[columns])
        scale /= np.sqrt(np.where(largest > 0.0, largest, 1.0))
    return scale


def _solve(entries: tuple[np.ndarray, np.ndarray, Array], rhs: Array, nb: int) -> Array:
    """Solve a system given by its entries: dense while that is quicker, sparse for long chains."""
    rows, columns, values = entries
    n = len(rhs)
    if nb <= DENSE:
        K = np.zeros((n, n))
        np.add.at(K, (rows, columns), values)
        return np.asarray(np.linalg.solve(K, rhs))
    from scipy.sparse import csc_array
    from scipy.sparse.linalg import splu

    try:
        return np.asarray(splu(csc_array((values, (rows, columns)), shape=(n, n))).solve(rhs))
    except RuntimeError as refusal:
        raise np.linalg.LinAlgError(str(refusal)) from None
