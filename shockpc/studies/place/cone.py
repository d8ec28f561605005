"""The smallest shock over one convex set: a second-order cone program, solved by Clarabel, with a
bound that is checked here.

With a unit of weight shared among vectors y_l (Σ|y_l| = 1), the largest |c_l + A_l r| is nowhere
below Σ y_l · (c_l + A_l r). The minimum of this affine function over the set is a lower bound of
the optimum, whichever y are taken, so that the bound does not depend on the accuracy of the solver,
from whose dual solution y comes. For the weighted mean the condition is |y_l| ≤ w_l; where shocks
have a limit, it is |y_l| ≤ w_l + m_l with any m_l ≥ 0, and Σ m_l times the limit is subtracted.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.studies.place.field import Fields
from shockpc.text.errors import StudyError

ACCURACY = 1e-9
"""Gap between the value at a place and the bound of the set, below which the place counts as the
optimum [1].
"""

LANDINGS_TOGETHER = 12
"""Landings up to which all are in one program; of more, only those that limit the result (at most a
few) are added, in turns.
"""


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
        if (
            float((self.points @ normal).max()) + float(np.linalg.norm(normal @ self.rounding))
            < offset
        ):
            return None
        return ConvexCell(
            self.points,
            self.rounding,
            np.concatenate([self.normals, [normal]]),
            np.append(self.offsets, offset),
        )


class Optimum(NamedTuple):
    """The point of a convex set with the smallest shock.

    Attributes:
        place: (3,) [m].
        value: the number that places are compared by, at this place [1].
        bound: it is nowhere in the set below this [1].
    """

    place: Array
    value: float
    bound: float


def least_shock(fields: Fields, cell: ConvexCell) -> Optimum | None:
    """The optimum over a convex set; None if the set is empty.

    Raises:
        StudyError: Clarabel is not installed.
    """
    many = fields.weights is None and len(fields.c) > LANDINGS_TOGETHER
    decisive = (
        [int(fields.shocks(cell.points.mean(axis=0)).argmax())]
        if many
        else list(range(len(fields.c)))
    )
    while True:
        solved = _solved(fields.of(decisive), cell)
        if solved is None:
            return None
        place, bound = solved
        shocks = fields.shocks(place)
        value = float(fields.combined(shocks))
        missing = [
            int(k)
            for k in np.argsort(-shocks)[:4]
            if shocks[k] > bound + ACCURACY / 2.0 and k not in decisive
        ]
        if not many or not missing or value <= bound + ACCURACY:
            return Optimum(place, value, bound)
        decisive += missing


def _solved(fields: Fields, cell: ConvexCell) -> tuple[Array, float] | None:
    """The place of the optimum and a lower bound; None if the set is empty.

    The unknowns are t (one, or one for each landing), r, the shares of the points in r and, for a
    rounded set, the point of the unit ball that its ellipsoid is the image of. r is counted from
    the middle of the points, in units of their size.
    """
    clarabel, sparse = _libraries()
    n, k, m, limit = len(fields.c), len(cell.points), len(cell.offsets), fields.limit
    middle = cell.points.mean(axis=0)
    size = max(float(np.abs(cell.points - middle).max() + np.abs(cell.rounding).max()), 1e-9)
    p = (cell.points - middle) / size
    c, A = fields.vectors(middle), fields.A * size
    weights = np.ones(1) if fields.weights is None else fields.weights
    nt = len(weights)
    t = np.zeros((n, 4, nt))
    t[np.arange(n), 0, np.arange(n) if nt > 1 else 0] = -1.0
    turned = np.zeros((n, 4, 3))
    turned[:, 1:] = -A
    # Columns are t, r, the shares and the point of the ball; rows are r in the hull, its shares,
    # half-spaces, and the cones.
    rounded, ball = bool(cell.rounding.any()), np.concatenate([np.zeros((1, 3)), -np.eye(3)])
    rows: list[tuple[Any, Any, Any, Any, Any]] = [
        (None, -np.eye(3), p.T, cell.rounding / size, np.zeros(3)),
        (None, None, np.ones((1, k)), None, np.ones(1)),
        (None, None, -sparse.identity(k), None, np.zeros(k)),
        (None, -cell.normals * size, None, None, cell.normals @ middle - cell.offsets),
        (np.eye(nt), None, None, None, np.full(nt, limit)),
        (None, None, None, ball, np.array([1.0, 0.0, 0.0, 0.0])),
        (
            t.reshape(4 * n, nt),
            turned.reshape(4 * n, 3),
            None,
            None,
            np.concatenate([np.zeros((n, 1)), c], axis=1).ravel(),
        ),
    ]
    limits = nt if math.isfinite(limit) else 0
    cones = [
        clarabel.ZeroConeT(4),
        clarabel.NonnegativeConeT(k + m + limits),
        *[clarabel.SecondOrderConeT(4)] * (n + 1),
    ]
    if not rounded:
        del rows[5], cones[-1]
    if not limits:
        del rows[4]
    blocks = [
        [None if x is None else sparse.csc_matrix(x) for x in row[: 4 if rounded else 3]]
        for row in rows
    ]
    matrix, right = sparse.bmat(blocks, format="csc"), np.concatenate([row[4] for row in rows])
    width = matrix.shape[1]
    cost = np.concatenate([weights, np.zeros(width - nt)])

    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = 1e-11
    solution = clarabel.DefaultSolver(
        sparse.csc_matrix((width, width)), cost, matrix, right, cones, settings
    ).solve()
    if solution.status in (
        clarabel.SolverStatus.PrimalInfeasible,
        clarabel.SolverStatus.AlmostPrimalInfeasible,
    ):
        return None
    x, z = np.asarray(solution.x), np.asarray(solution.z)
    share = np.maximum(x[nt + 3 : nt + 3 + k], 0.0)
    place = cell.points.T @ (share / share.sum())
    if rounded:
        place = place + cell.rounding @ x[-3:] / max(float(np.linalg.norm(x[-3:])), 1.0)
    y, multipliers = -z[-4 * n :].reshape(n, 4)[:, 1:], np.maximum(z[4 + k : 4 + k + m], 0.0)
    return place, _lower_bound(
        fields, cell, y, multipliers, np.maximum(z[4 + k + m : 4 + k + m + limits], 0.0)
    )


def _lower_bound(
    fields: Fields, cell: ConvexCell, y: Array, multipliers: Array, of_limits: Array
) -> float:
    """The smallest value over the set of the affine function that y and the multipliers of
    half-spaces and limits give.
    """
    lengths = np.linalg.norm(y, axis=1)
    if fields.weights is None:
        scale = 1.0 / max(float(lengths.sum()), 1e-300)
        y, multipliers = y * scale, multipliers * scale
    else:
        allowed = fields.weights + of_limits if len(of_limits) else fields.weights
        y = y * np.minimum(1.0, allowed / np.maximum(lengths, 1e-300))[:, None]
    slope = np.einsum("li,lij->j", y, fields.A) - multipliers @ cell.normals
    least = float((cell.points @ slope).min()) - float(np.linalg.norm(slope @ cell.rounding))
    limited = float(of_limits.sum()) * fields.limit if len(of_limits) else 0.0
    return max(
        0.0, float(np.sum(y * fields.c)) + float(multipliers @ cell.offsets) + least - limited
    )


def _libraries() -> tuple[Any, Any]:
    """Clarabel, and sparse matrices. Imported here, because only this study needs them."""
    try:
        import clarabel
    except ModuleNotFoundError:
        raise StudyError(
            "the best place is computed by Clarabel. Install it: pip install clarabel"
        ) from None
    from scipy import sparse

    return clarabel, sparse
