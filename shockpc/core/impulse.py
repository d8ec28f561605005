"""Step 1: solve the impulsive equation of motion for the jump in joint velocity.

Shock paper, Eq. 4:

    [ H    J_cᵀ ] [ Δq̇ ]   [  0 ]
    [ J_c   0   ] [ −λ ] = [ −b ]         b = (1 + e) J_c q̇⁻

Works only on arrays; it neither loads robots nor chooses contacts. What closes a loop is a row with
b = 0; what cannot move is a column left out (Eq. 7, with H and J_c reduced before they come here).
All arrays have a leading posture axis.
"""

import functools
from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np

from shockpc.core.inertia import Inertia, diagonal_of, solve_inertia
from shockpc.core.spatial import Array

EPS = float(np.finfo(float).eps)

CLEARLY_INDEPENDENT = 1e-4
"""Smallest pivot of the scaled Delassus matrix from which its rows are certainly independent."""

INDISTINCT = 1e10
"""Condition of the inertia from which the Delassus matrix in double precision no longer tells
whether its rows are independent.
"""

TOLERANCE = 64.0 * EPS
"""Rows are dependent where what sets them apart is below this share of the terms that they are
computed from.
"""

DATA_TOLERANCE = 1e-8
"""`TOLERANCE` where loops are closed: bars that are parallel to the digits of a file, and to the
gap that closing leaves.
"""

SMALL = 1e-2
"""Minimum pivot, and minimum share of the largest mobility, below which a row may be one that
rounding of the robot's file left.
"""

UNCERTAIN = 1.0 / 32.0, 8.0
"""Multiples of the tolerance between which rounding can change whether rows are independent."""


class Solution(NamedTuple):
    """The solution of Eq. 4 in N postures, in double precision.

    Attributes:
        delta_qd: (N, nv, k) jump of the joint velocities [rad/s, m/s], one column for each column
            of b.
        impulse: (N, nc, k) impulse of the ground on the robot along each row [N s]: positive where
            the row is pushed forward.
        scale: (N, nc) by which each row is brought to unit mobility; zero for a row along which
            nothing can move.
        rank: (N,) number of independent rows.
        condition: (N,) estimated factor by which the inertia and the rows enlarge rounding in the
            jump that is known worst [1].
        row_spaces: the independent rows of each posture in which some depend on others, or nearly
            do, by its index.
        independent: (r, k) impulses along these rows only, which do the same to the robot, by the
            same index [N s].
    """

    delta_qd: Array
    impulse: Array
    scale: Array
    rank: np.ndarray
    condition: Array
    row_spaces: "dict[int, RowSpace]"
    independent: dict[int, Array]

    @property
    def independent_impulse(self) -> Array:
        """(N, nc, k) impulses along the independent rows only, zero along all others [N s]."""
        if not self.independent:
            return self.impulse
        impulse = self.impulse.copy()
        for k, part in self.independent.items():
            impulse[k] = 0.0
            impulse[k, self.row_spaces[k].rows] = part
        return impulse


class RowSpace(NamedTuple):
    """The independent rows of one posture.

    Attributes:
        rows: (r,) indices of independent rows from which all others follow.
        distribution: (nc, r) distributes impulses along these rows over all rows, with the same
            effect and the minimum norm at unit mobility; the identity where no row depends on
            others.
        unique: (nc,) whether the impulse along a row is determined. A row along which nothing can
            move takes none.
        uncertain: whether rounding can change how many rows are independent.
        discarded: largest singular value above rounding that counts as zero, relative to the terms
            of the rows; 0 if none is.
        infeasible: (m, nc) combinations of rows, of unit length, along which the mechanism moves
            only by what rounding of its file leaves.
        slack: share of their terms that rounding of the file may leave in rows that follow from
            others.
    """

    rows: np.ndarray
    distribution: Array
    unique: np.ndarray
    uncertain: bool
    discarded: float = 0.0
    infeasible: Array = np.zeros((0, 0))
    slack: float = 0.0

    @staticmethod
    def every(n: int) -> "RowSpace":
        """All of n independent rows."""
        return RowSpace(np.arange(n), np.eye(n), np.ones(n, dtype=bool), False)


class RowLimit(NamedTuple):
    """The number of rows of a posture that can be independent, whatever their singular values.

    Attributes:
        most: number of rows; the smallest singular values beyond that count as zero.
        rounding: what rounding of the robot's file makes of rows beyond that, relative to their
            terms.
    """

    most: int
    rounding: float = 0.0


RowLimits: TypeAlias = Callable[[int], RowLimit]
"""Posture → its limit."""


def solve_impact(
    H: Inertia,
    J_c: Array,
    b: Array,
    terms: Callable[[], Array],
    tolerance: float,
    limits: RowLimits | None = None,
) -> Solution:
    """The jump of minimum kinetic energy that meets the contact.

    Δq̇ = −H⁻¹ J_cᵀ Λ b and λ = −Λ b, with Λ = (J_c H⁻¹ J_cᵀ)⁻¹.

    The Delassus matrix J_c H⁻¹ J_cᵀ, scaled to a unit diagonal, is eliminated without pivoting.
    Where a pivot comes near zero, or the inertia has lost the digits to tell, `independent_rows`
    finds the independent rows of that posture.

    Args:
        H: joint-space inertia, matrices (N, nv, nv) or what they consist of [kg, kg m, kg m²].
        J_c: (N, nc, nv) contact and closure rows.
        b: (N, nc, k) speed to be undone along each row, (1 + e) times the approach [m/s].
        terms: the sizes (N, nc, nv) of the terms that the entries of J_c are sums of; asked only
            where they may matter.
        tolerance: as of `independent_rows`.
        limits: of the rows in each posture; asked only there, too.

    Returns: NaN in a posture whose inertia is singular in double precision.
    """
    size = np.sqrt(np.abs(diagonal_of(H)))
    known: dict[int, RowLimit] = {}
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        delassus = _delassus(H, J_c, size)
        if limits is not None:
            known = {k: limits(k) for k in delassus.doubtful()}
        full_rank = delassus.clear(size)
        full_rank[[k for k, limit in known.items() if limit.most < J_c.shape[1]]] = False
        solution = delassus.solution(b, full_rank)
    unclear = np.flatnonzero(~full_rank).tolist()
    if unclear:
        sizes = terms()
        for k in unclear:
            limit = known.get(k)
            columns = column_sizes(sizes[k])
            row_space = independent_rows(
                J_c[k], sizes[k], columns, delassus.scale[k], tolerance, limit
            )
            _set_dependent(solution, k, row_space, delassus, b[k])
    return solution._replace(condition=solution.condition * _light(size, solution.delta_qd))


def _set_dependent(
    solution: Solution, k: int, row_space: RowSpace, delassus: "_Delassus", b: Array
) -> None:
    """Set the solution of posture k, in which rows depend on others, or nearly do.

    Args:
        solution: changed.
        k: the posture.
        row_space: which of its rows are independent.
        delassus: the matrices of all postures.
        b: (nc, k) speeds to be undone along the rows.
    """
    rows = row_space.rows
    part, of_rows = _least_squares(delassus.A[k][np.ix_(rows, rows)], b[rows])
    solution.row_spaces[k] = row_space
    solution.independent[k] = part
    solution.rank[k] = len(rows)
    solution.condition[k] = of_rows * delassus.stiffness[k]
    solution.impulse[k] = row_space.distribution @ part
    solution.delta_qd[k] = delassus.X[k][:, rows] @ part


class _Delassus(NamedTuple):
    """The Delassus matrices A = J_c H⁻¹ J_cᵀ of N postures.

    Attributes:
        X: (N, nv, nc) H⁻¹ J_cᵀ.
        A: (N, nc, nc) them.
        mobility: (N, nc) their diagonals.
        scale: (N, nc) with which their diagonals are one; 0 of rows along which nothing moves.
        scaled: (N, nc, nc) the same with a unit diagonal.
        pivot: (N,) smallest pivot of these.
        stiffness: (N,) estimated norm of the inverse of the inertia, scaled to a unit diagonal.
    """

    X: Array
    A: Array
    mobility: Array
    scale: Array
    scaled: Array
    pivot: Array
    stiffness: Array

    def clear(self, size: Array) -> np.ndarray:
        """In which postures (N,) all rows are independent, clearly.

        Args: size (N, nv), square roots of the diagonal of the inertia.
        """
        # Unit velocities of single joints say what a mobility is: of a row along which nothing can
        # move, rounding leaves 1e-32.
        of_joints = 1.0 / np.min(size, axis=-1) ** 2
        natural = np.maximum(self.mobility.max(axis=-1), of_joints)
        moves = self.mobility.min(axis=-1) > 1e-20 * natural
        clear = (self.pivot > CLEARLY_INDEPENDENT) & (self.stiffness < INDISTINCT) & moves
        return np.asarray(clear)

    def solution(self, b: Array, full_rank: np.ndarray) -> Solution:
        """The solution where all rows are independent, full_rank (N,); elsewhere without meaning.

        With C the scale and S = C A C, λ = −C S⁻¹ C b and Δq̇ = H⁻¹ J_cᵀ λ.
        """
        n, nc = self.scale.shape
        S = np.where(full_rank[:, None, None], self.scaled, np.eye(nc))
        C = self.scale[:, :, None]
        impulse = np.asarray(-C * np.linalg.solve(S, C * b))
        return Solution(
            delta_qd=self.X @ impulse,
            impulse=impulse,
            scale=self.scale,
            rank=np.full(n, nc),
            condition=self.stiffness / np.where(full_rank, self.pivot, np.nan),
            row_spaces={},
            independent={},
        )

    def doubtful(self) -> list[int]:
        """The postures in which some rows may be what rounding of a file left."""
        # One or two rows may all be that, and then none is smaller than the others.
        few = self.A.shape[1] < 3
        alike = self.mobility.min(axis=-1) > SMALL * self.mobility.max(axis=-1)
        small = ~((self.pivot > SMALL) & alike) | few
        return [int(k) for k in np.flatnonzero(small)]


def _delassus(H: Inertia, J_c: Array, size: Array) -> _Delassus:
    """The Delassus matrices of N postures. Args: size as of `_Delassus.clear`."""
    nc = J_c.shape[1]
    # One more right-hand side of random signs estimates the norm of the inverse (Kenney and Laub
    # 1994).
    signs = (size * _signs(size.shape[1]))[..., None]
    X = solve_inertia(H, np.concatenate([np.swapaxes(J_c, -1, -2), signs], axis=-1))
    stiffness = np.sqrt(np.sum((X[..., nc] * size) ** 2, axis=-1))
    X = X[..., :nc]
    A = J_c @ X
    mobility = np.einsum("nii->ni", A)
    scale = np.where(mobility > 0.0, 1.0 / np.sqrt(np.abs(mobility)), 0.0)
    scaled = A * (scale[:, :, None] * scale[:, None, :])
    return _Delassus(X, A, mobility, scale, scaled, _minimum_pivot(scaled), stiffness)


def _light(size: Array, delta_qd: Array) -> Array:
    """The factor (N,) by which the jump of the lightest joint is known worse than that of all.

    ‖D Δq̇‖ / (min D · max |Δq̇|), D² = diag H.

    Rounding is a share of all that moves, measured with its inertia: a heavy body's may be much for
    a light one.
    """
    # The posture comes last, so that every operation runs over contiguous numbers.
    D = np.ascontiguousarray(size.T)
    jump = np.abs(delta_qd.transpose(1, 2, 0), order="C")
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        length = np.sqrt(np.einsum("ikn,in->kn", jump**2, D**2))
        share = np.fmax.reduce(length / jump.max(axis=0), axis=0)
        return np.asarray(np.fmax(share / D.min(axis=0), 1.0))


@functools.cache
def _signs(n: int) -> Array:
    """Signs (n,) without a pattern."""
    return np.where(np.arange(n) * 2654435761 % 7 < 4, 1.0, -1.0)


def _minimum_pivot(A: Array) -> Array:
    """The smallest pivot (N,) of symmetric matrices A (N, n, n), eliminated in their order.

    It is NaN after a pivot that is zero.
    """
    S = A.transpose(1, 2, 0).copy()
    for k in range(len(S) - 1):
        # S_ij −= S_ik S_kj / S_kk for i, j > k
        row = S[k, k + 1 :] / S[k, k]
        S[k + 1 :, k + 1 :] -= S[k + 1 :, k, None] * row[None]
    return np.asarray(np.einsum("iin->in", S).min(axis=0))


def _least_squares(A: Array, b: Array) -> tuple[Array, float]:
    """−A⁻¹ b for the Delassus matrix A of independent rows, and the condition of A.

    A is scaled to a unit diagonal.
    """
    nothing = np.full_like(b, np.nan), np.inf
    diagonal = np.diagonal(A)
    if not np.isfinite(A).all() or not np.all(diagonal > 0.0):
        return nothing
    c = 1.0 / np.sqrt(diagonal)
    scaled = A * np.outer(c, c)
    try:
        x = np.linalg.solve(scaled, c[:, None] * b)
        return -c[:, None] * x, float(np.linalg.cond(scaled))
    except np.linalg.LinAlgError:
        return nothing


def independent_rows(
    J_c: Array,
    terms: Array,
    size: Array,
    scale: Array,
    tolerance: float = TOLERANCE,
    limit: RowLimit | None = None,
) -> RowSpace:
    """The rows of one posture from which all others follow, and the distribution of impulses.

    Impulses along these rows are distributed over all.

    They are as many as singular values are above rounding, and are taken far from one another. The
    rank of J_c H⁻¹ J_cᵀ is that of J_c, because H is positive definite. It follows from the
    singular values of J_c with columns scaled by lengths and rows to the size of their terms, so
    that masses decide nothing: a singular value is zero where it is below what the error of these
    terms can make of a zero. Rows are chosen, not mixtures of them: a mixture of a row of small
    mobility with one that moves easily would lose digits.

    Args:
        J_c: (nc, nv) rows.
        terms: (nc, nv) sizes of the terms that its entries are sums of.
        size: (nv,) by which joint velocities are measured, as `column_sizes`.
        scale: (nc,) that brings each row to unit mobility.
        tolerance: relative error of the terms. Rounding alone may change which rows are independent
            only where it is `TOLERANCE`.
        limit: of the rows; none by default.
    """
    count = len(J_c)
    most, rounding = limit or RowLimit(count)
    term_size, scaled = in_terms(J_c, terms, size)
    rows_in_terms = _RowsInTerms.of(scaled, tolerance)
    rank = min(int(np.sum(rows_in_terms.s > rows_in_terms.bound)), most)
    discarded = rows_in_terms.largest_zero(rank)
    uncertain = tolerance == TOLERANCE and rows_in_terms.uncertain(most)
    infeasible = np.zeros((0, count))
    slack = 0.0
    if rank == most < count and rounding > 0.0:
        uncertain = _any_near(rows_in_terms.s[:rank], rows_in_terms.bound)
        slack = max(rounding, float(rows_in_terms.s[rank]))
        rows_in_terms, infeasible = rows_in_terms.without_rounding(rank, slack)

    moves = rows_in_terms.moves
    unique = rows_in_terms.unique(rank)
    rows = np.flatnonzero(moves)
    if rank != len(rows):
        rows = _farthest(rows_in_terms.rows.T, rank)
    distribution = np.eye(rank)
    if rank != count:
        # In units of its terms every row has the same rounding, so a row of small mobility does
        # not hide others.
        J = rows_in_terms.rows * term_size[:, None]
        distribution = _distribution(J, moves, size, scale, rows, unique)
    return RowSpace(rows, distribution, unique, uncertain, discarded, infeasible, slack)


class _RowsInTerms(NamedTuple):
    """Rows in units of their terms, as by `in_terms`, and their singular values.

    Attributes:
        rows: (nc, nv), zero where one moves nothing.
        length: (nc,) of the rows.
        moves: (nc,) which of them move anything: the others are smaller than rounding.
        s: (nc,) singular values, in descending order.
        Vt: (m, nc) orthonormal combinations of rows that belong to these.
        bound: singular value up to which one is rounding.
    """

    rows: Array
    length: Array
    moves: np.ndarray
    s: Array
    Vt: Array
    bound: float

    @staticmethod
    def of(rows: Array, tolerance: float) -> "_RowsInTerms":
        """Rows (nc, nv) whose terms have a relative error."""
        count = len(rows)
        length = np.linalg.norm(rows, axis=1)
        moves = length > tolerance
        rows = np.where(moves[:, None], rows, 0.0)
        _, s, Vt = np.linalg.svd(rows.T)
        s = np.pad(s, (0, count - len(s)))
        return _RowsInTerms(rows, length, moves, s, Vt, tolerance * np.sqrt(count))

    def largest_zero(self, rank: int) -> float:
        """The largest singular value, or length of a row, above rounding that counts as zero."""
        zeros = np.concatenate([self.s[rank:], self.length[~self.moves]])
        rounding = UNCERTAIN[1] * TOLERANCE * np.sqrt(len(self.rows))
        return float(zeros[zeros > rounding].max(initial=0.0))

    def uncertain(self, most: int) -> bool:
        """True if rounding can change how many rows are independent."""
        return _any_near(self.s[:most], self.bound) or _any_near(self.length, TOLERANCE)

    def without_rounding(self, rank: int, slack: float) -> tuple["_RowsInTerms", Array]:
        """The rows without the rounding that the file left in them.

        The second array (m, nc) holds the combinations of rows that are only this rounding.

        Args:
            rank: number of independent rows.
            slack: as of `RowSpace`.
        """
        rounding = self.Vt[rank:]
        left = self.moves & (self.length <= slack) & (np.sum(rounding**2, axis=0) > 0.5)
        of_left = np.any(rounding[:, left] ** 2 > 0.5, axis=1)
        infeasible = rounding[(self.s[rank:] > self.bound) | of_left]
        moves = self.moves & ~left
        feasible = self.rows - rounding.T @ (rounding @ self.rows)
        rows = np.where(moves[:, None], feasible, 0.0)
        Vt = np.linalg.svd(rows.T, full_matrices=False)[2]
        return self._replace(rows=rows, moves=moves, Vt=Vt), infeasible

    def unique(self, rank: int) -> np.ndarray:
        """Along which rows (nc,) the impulse is unique: their unit vectors lie in the row space."""
        within = np.sum(self.Vt[:rank] ** 2, axis=0)
        return np.asarray(~self.moves | (within > 1.0 - 1e-9))


def _distribution(
    J: Array, moves: np.ndarray, size: Array, scale: Array, rows: np.ndarray, unique: np.ndarray
) -> Array:
    """Impulses (nc, r) along all rows with the effect of unit impulses along r independent ones.

    They are `RowSpace.distribution`.

    With C the scale, they are C (J C)⁺ J_rᵀ, where (J C)⁺ has r singular values.

    Args:
        J: (nc, nv) rows, without what is rounding in them.
        moves: (nc,) which of them move anything.
        size: as of `independent_rows`.
        scale: likewise.
        rows: (r,) the independent ones.
        unique: (nc,) along which the impulse is determined.
    """
    length = np.where(moves, np.linalg.norm(J, axis=1), 1.0)
    C = np.where(scale > 0.0, scale, 1.0 / (size.min() * length))
    C = np.where(moves, C, 0.0)[:, None]
    U, s, Vt = np.linalg.svd((C * J).T, full_matrices=False)
    rank = len(rows)
    in_units = (U[:, :rank].T @ J[rows].T) / s[:rank, None]
    distribution = C * (Vt[:rank].T @ in_units)
    # Impulses that are determined have nothing to do with the others; rounding would say otherwise.
    distribution[unique] = 0.0
    distribution[:, unique[rows]] = 0.0
    unrepeated = np.flatnonzero(unique[rows])
    distribution[rows[unrepeated], unrepeated] = 1.0
    return np.asarray(distribution)


def column_sizes(terms: Array) -> Array:
    """The largest size (nv,) of a term in each column of terms (nc, nv).

    It is a length [m] for a rotation, and 1 for a translation.
    """
    maximum = terms.max(axis=0, initial=0.0)
    return np.where(maximum > 0.0, maximum, 1.0)


def in_terms(J_c: Array, terms: Array, size: Array) -> tuple[Array, Array]:
    """The size (nc,) of the terms of each row, and the rows (nc, nv) in units of that.

    Arguments are as of `independent_rows`.
    """
    # What is left of terms that cancel to within their rounding is a structural zero, such as the
    # speed of a point on the only axis that rotates; nothing later could tell it from a lever of
    # 1e-16 m.
    J = np.where(np.abs(J_c) > 8.0 * EPS * terms, J_c, 0.0) / size
    term_size = np.linalg.norm(terms / size, axis=1)
    term_size = np.where(term_size > 0.0, term_size, 1.0)
    return term_size, J / term_size[:, None]


def _any_near(values: Array, limit: float) -> bool:
    """True if a value is so near a limit that rounding could have taken it across."""
    low, high = UNCERTAIN
    is_near = (values > low * limit) & (values < high * limit)
    return bool(np.any(is_near))


def _farthest(X: Array, rank: int) -> np.ndarray:
    """Indices of `rank` columns of X, each the farthest from those before."""
    chosen: list[int] = []
    for _ in range(rank):
        lengths = np.linalg.norm(X, axis=0)
        farthest = int(np.argmax(lengths))
        chosen.append(farthest)
        e = X[:, farthest] / lengths[farthest]
        X = X - np.outer(e, e @ X)
        X[:, chosen] = 0.0
    return np.array(sorted(chosen), dtype=int)


def weakest_columns(H: Array) -> list[int]:
    """The columns of a singular inertia that have no inertia, or share one between them.

    Returns: indices, ascending.
    """
    d = np.sqrt(np.abs(np.diagonal(H)))
    empty = d <= 1e-13 * d.max(initial=0.0)
    if empty.any() or not d.size:
        return [int(i) for i in np.flatnonzero(empty)]
    _, vectors = np.linalg.eigh(H / d[:, None] / d[None, :])
    weight = np.abs(vectors[:, 0])
    return [int(i) for i in np.flatnonzero(weight > 0.3 * weight.max())]
