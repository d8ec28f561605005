"""The smallest shock over one convex set: a second-order cone program, solved by Clarabel.

Its bound is checked here. For vectors y_l with Σ|y_l| = 1, the largest |c_l + A_l r| is nowhere
below Σ y_l · (c_l + A_l r). The minimum of this affine function over the set is a lower bound of
the optimum, whichever y are taken, so that the bound does not depend on the accuracy of the solver,
from whose dual solution y comes. For the mean of L shocks, each of which has a limit, the condition
is |y_l| ≤ 1/L + m_l with any m_l ≥ 0, and Σ m_l times the limit is subtracted.
"""

from typing import Any, NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.studies.place.field import Fields
from shockpc.text.errors import StudyError

ACCURACY = 1e-9
"""Gap between the value at a point and the bound of the set that makes it the optimum [1]."""

SOLVER_TOLERANCE = 1e-11
"""Gap and residual at which Clarabel ends [1]."""

LANDINGS_TOGETHER = 12
"""Number of landings up to which all are in one program.

Of more, only those that limit the result (at most a few) are added, in turns.
"""

ADDED = 4
"""Landings that are added in one turn, at most."""


class ConvexCell(NamedTuple):
    """A convex set: the Minkowski sum of the hull of points and an ellipsoid, within half-spaces.

    Attributes:
        points: (k, 3) [m].
        rounding: (3, 3) semi-axes of the ellipsoid in orthogonal columns [m].
        normals: (m, 3); the set holds points r with normals · r ≥ offsets only.
        offsets: (m,).
    """

    points: Array
    rounding: Array = np.zeros((3, 3))
    normals: Array = np.zeros((0, 3))
    offsets: Array = np.zeros(0)

    def within(self, normal: Array, offset: float) -> "ConvexCell | None":
        """The part where normal · r ≥ offset; None if the hull alone shows that there is none."""
        highest = (self.points @ normal).max() + np.linalg.norm(normal @ self.rounding)
        if highest < offset:
            return None
        return self._replace(
            normals=np.concatenate([self.normals, [normal]]),
            offsets=np.append(self.offsets, offset),
        )


class Optimum(NamedTuple):
    """The point of a convex set with the smallest shock.

    Attributes:
        point: (3,) [m].
        value: the number that points are compared by, at this point [1].
        bound: it is nowhere in the set below this [1].
    """

    point: Array
    value: float
    bound: float


def least_shock(fields: Fields, cell: ConvexCell) -> Optimum | None:
    """The optimum over a convex set; None if the set is empty.

    Raises:
        StudyError: Clarabel is not installed.
    """
    n = len(fields.c)
    if fields.limit is not None or n <= LANDINGS_TOGETHER:
        solution = _solve(fields, cell)
        if solution is None:
            return None
        point, bound = solution
        return Optimum(point, float(fields.combined(fields.shocks(point))), bound)
    # The bound of some landings holds for all of them: the largest of all is not smaller.
    decisive = [int(fields.shocks(cell.points.mean(axis=0)).argmax())]
    while True:
        solution = _solve(fields.of(decisive), cell)
        if solution is None:
            return None
        point, bound = solution
        shocks = fields.shocks(point)
        largest = np.argsort(-shocks)[:ADDED].tolist()
        above = [k for k in largest if shocks[k] > bound + ACCURACY / 2.0]
        missing = [k for k in above if k not in decisive]
        value = float(fields.combined(shocks))
        if not missing or value <= bound + ACCURACY:
            return Optimum(point, value, bound)
        decisive += missing


class _Rows(NamedTuple):
    """Rows of a program: its columns t, r, shares and ball, and the right side.

    Columns are None where they are zero.
    """

    t: Any
    r: Any
    shares: Any
    ball: Any
    right: Array


def _solve(fields: Fields, cell: ConvexCell) -> tuple[Array, float] | None:
    """The point (3,) of the optimum [m] and a lower bound [1]; None if the set is empty.

    The unknowns are t (one, or one for each landing), r, the shares of the points in r and, for a
    rounded set, the point of the unit ball that its ellipsoid is the image of. r is counted from
    the middle of the points, in units of their size.
    """
    n, k, m = len(fields.c), len(cell.points), len(cell.offsets)
    n_t = 1 if fields.limit is None else n
    n_limits = 0 if fields.limit is None else n
    rounded = bool(cell.rounding.any())
    rows = [*_linear_rows(fields, cell, n_t), *_cone_rows(fields, cell, n_t)]
    solution = _minimize_t(rows, n_t, nonnegative=k + m + n_limits, cones=n + rounded)
    if solution is None:
        return None
    x, z = solution
    shares = np.maximum(x[n_t + 3 : n_t + 3 + k], 0.0)
    point = cell.points.T @ (shares / shares.sum())
    if rounded:
        ball = x[-3:]
        point = point + cell.rounding @ ball / max(float(np.linalg.norm(ball)), 1.0)
    # Rows: 4 equations, k shares, m half-spaces, limits; cones of 4 rows are the last ones.
    half_spaces = 4 + k
    limits = half_spaces + m
    multipliers = np.maximum(z[half_spaces:limits], 0.0)
    of_limits = np.maximum(z[limits : limits + n_limits], 0.0)
    y = -z[-4 * n :].reshape(n, 4)[:, 1:]
    return point, _lower_bound(fields, cell, y, multipliers, of_limits)


def _minimize_t(
    rows: list[_Rows], n_t: int, nonnegative: int, cones: int
) -> tuple[Array, Array] | None:
    """The unknowns and the multipliers of the rows where t, or its mean, is smallest.

    None if there are no such unknowns.

    Args:
        rows: 4 equations, then inequalities, then cones of 4 rows.
        n_t: number of the unknowns t, which are the first ones.
        nonnegative: number of the inequalities.
        cones: number of the cones.
    """
    clarabel, sparse = _libraries()
    # Without a ball in any row there are no such columns.
    with_ball = any(row.ball is not None and np.any(row.ball) for row in rows)
    columns = 4 if with_ball else 3
    blocks: list[list[Any]] = []
    for row in rows:
        of_row: list[Any] = [None] * columns
        for k, part in enumerate(row[:columns]):
            if part is not None:
                of_row[k] = sparse.csc_matrix(part)
        blocks.append(of_row)
    matrix = sparse.bmat(blocks, format="csc")
    right = np.concatenate([row.right for row in rows])
    width = matrix.shape[1]
    cost = np.append(np.full(n_t, 1.0 / n_t), np.zeros(width - n_t))
    kinds = [clarabel.ZeroConeT(4), clarabel.NonnegativeConeT(nonnegative)]
    kinds += [clarabel.SecondOrderConeT(4)] * cones

    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = SOLVER_TOLERANCE
    quadratic = sparse.csc_matrix((width, width))
    solver = clarabel.DefaultSolver(quadratic, cost, matrix, right, kinds, settings)
    solution = solver.solve()
    status = clarabel.SolverStatus
    if solution.status in (status.PrimalInfeasible, status.AlmostPrimalInfeasible):
        return None
    return np.asarray(solution.x), np.asarray(solution.z)


def _scale(cell: ConvexCell) -> tuple[Array, float]:
    """The middle (3,) of a set's points, and its size [m]."""
    middle = cell.points.mean(axis=0)
    reach = np.abs(cell.points - middle).max() + np.abs(cell.rounding).max()
    return middle, max(float(reach), 1e-9)


def _linear_rows(fields: Fields, cell: ConvexCell, n_t: int) -> list[_Rows]:
    """That r lies in the set, and the limits of t."""
    _, sparse = _libraries()
    k = len(cell.points)
    middle, size = _scale(cell)
    p = (cell.points - middle) / size
    rows = [
        # pᵀ shares + rounding ball / size − r = 0,  Σ shares = 1
        _Rows(None, -np.eye(3), p.T, cell.rounding / size, np.zeros(3)),
        _Rows(None, None, np.ones((1, k)), None, np.ones(1)),
        # shares ≥ 0,  normals · (middle + size r) ≥ offsets
        _Rows(None, None, -sparse.identity(k), None, np.zeros(k)),
        _Rows(None, -cell.normals * size, None, None, cell.normals @ middle - cell.offsets),
    ]
    if fields.limit is not None:
        # t ≤ limit
        rows.append(_Rows(np.eye(n_t), None, None, None, np.full(n_t, fields.limit)))
    return rows


def _cone_rows(fields: Fields, cell: ConvexCell, n_t: int) -> list[_Rows]:
    """That the point of the ball lies in it, and that t bounds the shocks; four rows a cone."""
    n = len(fields.c)
    middle, size = _scale(cell)
    rows = []
    if cell.rounding.any():
        # |ball| ≤ 1
        unit = np.concatenate([np.zeros((1, 3)), -np.eye(3)])
        rows.append(_Rows(None, None, None, unit, np.array([1.0, 0.0, 0.0, 0.0])))
    # |c_l + A_l (middle + size r)| ≤ t_l, or t for all landings
    t = np.zeros((n, 4, n_t))
    t[np.arange(n), 0, np.arange(n) if n_t > 1 else 0] = -1.0
    r = np.zeros((n, 4, 3))
    r[:, 1:] = -(fields.A * size)
    right = np.zeros((n, 4))
    right[:, 1:] = fields.vectors(middle)
    rows.append(_Rows(t.reshape(4 * n, n_t), r.reshape(4 * n, 3), None, None, right.ravel()))
    return rows


def _lower_bound(
    fields: Fields, cell: ConvexCell, y: Array, multipliers: Array, of_limits: Array
) -> float:
    """The smallest value over the set of the affine function of a dual solution [1].

    Args:
        fields: shock over the body.
        cell: the set.
        y: (L, 3) of the shocks.
        multipliers: (m,) of the half-spaces.
        of_limits: (L,) of the limits; (0,) without them.
    """
    lengths = np.linalg.norm(y, axis=1)
    limited = 0.0
    if fields.limit is None:
        # Σ|y_l| = 1
        scale = 1.0 / max(float(lengths.sum()), 1e-300)
        y, multipliers = y * scale, multipliers * scale
    else:
        # |y_l| ≤ 1/L + m_l
        allowed = 1.0 / len(y) + of_limits
        y = y * np.minimum(1.0, allowed / np.maximum(lengths, 1e-300))[:, None]
        limited = float(of_limits.sum()) * fields.limit
    # Σ y_l · c_l + multipliers · offsets + slope · r, of which the last is the smallest over the
    # hull and the ellipsoid
    slope = np.einsum("li,lij->j", y, fields.A) - multipliers @ cell.normals
    lowest = (cell.points @ slope).min() - np.linalg.norm(slope @ cell.rounding)
    start = np.sum(y * fields.c) + multipliers @ cell.offsets
    return max(0.0, float(start) + float(lowest) - limited)


def _libraries() -> tuple[Any, Any]:
    """Clarabel, and sparse matrices. Imported here, because only this study needs them."""
    try:
        import clarabel
    except ModuleNotFoundError:
        raise StudyError(
            'the best place needs the package "clarabel"; install it with: pip install clarabel'
        ) from None
    from scipy import sparse

    return clarabel, sparse
