"""Uncertainty of the unknowns of `identify`: intervals, correlation, errors of other landings.

Intervals are a bootstrap over landings: each draw gives landings other weights, and the values
follow from the derivatives at the solution. So do the values without the landings that are left
out, which are then predicted in full.
"""

from typing import Literal, NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.evaluation.variations.variation import Variation
from shockpc.wings.recordings.identify.fit import EDGE, SEED, Fit, FittedValues, value_at_share
from shockpc.wings.recordings.identify.predictor import SCALE
from shockpc.wings.recordings.tables.prediction import energy_roots

DRAWS, FOLDS = 1000, 5
"""Draws of the bootstrap, and parts in which landings are left out."""

ALIKE = 0.05
"""Largest relative scatter of landings that are all alike.

It is that of the predicted jumps over the speeds of the strikes.
"""

NO_INFLUENCE, UNSEEN = 1e-6, 1e-4
"""Shares of the jumps below which an unknown has no influence, and below which it is not seen.

The first is of a change over the unknown's range, the second of a change of several together.
"""

State = Literal[
    "identified", "at its bound", "not identifiable", "no influence", "error does not fall"
]

CONFIRMED = 1e-3
"""Share of the jumps by which two predictions may differ that count as the same."""


class IdentifiedValue(NamedTuple):
    """An unknown with its value and interval.

    Attributes:
        variation: the unknown, with its unit and range.
        value: with which the landings are predicted best.
        low: lower end of the 95 % interval; NaN without one.
        high: its upper end.
        state: "identified", or why there is no interval.
    """

    variation: Variation
    value: float
    low: float
    high: float
    state: State


class Uncertainty(NamedTuple):
    """Uncertainty of the unknowns.

    Attributes:
        unknowns: with their values and intervals.
        correlation: (p, p) of the values; NaN where one was not identified.
        singular: (p,) singular values of the derivatives by the shares of the ranges, relative to
            what is left unexplained.
        unseen: directions (p,) of the shares along which the data say nothing.
        scatter: relative scatter of the predicted jumps over the speeds of the strikes.
        seen: (p,) which unknowns have an influence that is seen.
    """

    unknowns: tuple[IdentifiedValue, ...]
    correlation: Array
    singular: Array
    unseen: tuple[Array, ...]
    scatter: float
    seen: np.ndarray


class Influence(NamedTuple):
    """Influence of the unknowns on the data.

    Attributes:
        singular: as of `Uncertainty`, not relative.
        unseen: directions (p,) along which the data say nothing.
        without: (p,) which unknowns have no influence.
        vague: (p,) which take part in a direction that is not seen.
        edge: (p,) which are at a bound.
    """

    singular: Array
    unseen: tuple[Array, ...]
    without: np.ndarray
    vague: np.ndarray
    edge: np.ndarray

    @property
    def free(self) -> np.ndarray:
        """Flags (p,) of the unknowns that the data determine."""
        return np.asarray(~(self.edge | self.without | self.vague))


def uncertainty(fit: Fit, solution: FittedValues) -> Uncertainty:
    """Uncertainty of the unknowns at the solution."""
    influence = _influence(fit, solution)
    free = influence.free
    n = int(fit.used.sum())
    scatter = _scatter(fit, solution.u)
    changes = _refitted(solution, free, drawn(n, DRAWS))
    unknowns = []
    for j, (variation, value) in enumerate(
        zip(fit.predictor.unknowns, solution.values, strict=True)
    ):
        state = _state(influence, j, scatter)
        low = high = np.nan
        if state == "identified":
            shares = np.clip(solution.u[j] + changes[:, j], 0.0, 1.0)
            first, last = np.quantile(shares, _tails(n, int(free.sum()))).tolist()
            low = value_at_share(variation, first)
            high = value_at_share(variation, last)
        unknowns.append(IdentifiedValue(variation, value, low, high, state))
    return Uncertainty(
        unknowns=tuple(unknowns),
        correlation=_correlation(changes, free),
        singular=influence.singular / max(solution.left, 1e-300),
        unseen=influence.unseen,
        scatter=scatter,
        seen=~(influence.without | influence.vague),
    )


def _influence(fit: Fit, solution: FittedValues) -> Influence:
    """Influence of the unknowns on the data at the solution.

    With the residuals' derivatives D and weights w of the landings, √w D = U S Vᵀ. A direction V_j
    is not seen if its 95 % interval is as wide as the range, or if it changes next to nothing.
    """
    u = solution.u
    D = solution.derivatives
    weighted = np.sqrt(solution.weights)[:, None, None] * D
    _, singular, V = np.linalg.svd(weighted.reshape(-1, fit.p))
    size = float(np.linalg.norm(fit.jumps(u)))
    least = max(4.0 * solution.left, UNSEEN * size)
    unseen = tuple(V[j] for j in range(fit.p) if not singular[j] > least)
    vague = np.zeros(fit.p, dtype=bool)
    for direction in unseen:
        vague |= np.abs(direction) > 0.3
    return Influence(
        singular=singular,
        unseen=unseen,
        without=np.linalg.norm(D, axis=(0, 1)) <= NO_INFLUENCE * size,
        vague=vague,
        edge=(u < EDGE) | (u > 1.0 - EDGE),
    )


def _state(influence: Influence, j: int, scatter: float) -> State:
    """State of an unknown.

    Args: j, its number; scatter, as of `Uncertainty`.
    """
    if influence.without[j]:
        return "no influence"
    if influence.vague[j] or scatter < ALIKE:
        return "not identifiable"
    return "at its bound" if influence.edge[j] else "identified"


def _correlation(changes: Array, free: np.ndarray) -> Array:
    """The correlation (p, p) of the values by their changes (m, p) in the draws.

    It is NaN for values that are not free.
    """
    p = len(free)
    correlation = np.full((p, p), np.nan)
    if free.any():
        covariance = np.cov(changes[:, free].T).reshape(free.sum(), free.sum())
        sizes = np.sqrt(np.maximum(np.diagonal(covariance), 1e-300))
        correlation[np.ix_(free, free)] = covariance / np.outer(sizes, sizes)
    return correlation


def confirmed(fit: Fit, solution: FittedValues) -> bool:
    """True if the scene as it is given predicts the same as the solution.

    No error can fall then.
    """
    before = np.nan_to_num(fit.before.jumps[fit.used])
    after = np.nan_to_num(solution.predicted.jumps[fit.used])
    return bool(np.linalg.norm(after - before) <= CONFIRMED * np.linalg.norm(after))


def unidentified(known: Uncertainty) -> Uncertainty:
    """The uncertainty with no unknown identified.

    It is that of values that predict no better than the scene as it is given.
    """
    unknowns = []
    for unknown in known.unknowns:
        if unknown.state == "identified":
            unknown = unknown._replace(low=np.nan, high=np.nan, state="error does not fall")
        unknowns.append(unknown)
    correlation = np.full_like(known.correlation, np.nan)
    return known._replace(unknowns=tuple(unknowns), correlation=correlation)


def _scatter(fit: Fit, u: Array) -> float:
    """Relative scatter of the predicted jumps, each by the energy or speed of its strike."""
    if fit.by_energy:
        jumps = fit.jumps(u)
    else:
        jumps = np.nan_to_num(fit.predictor(fit.values(u)).jumps)[fit.used]
        jumps = jumps / np.sqrt(fit.predictor.strike_energy[fit.used, None])
    deviation = np.sum((jumps - jumps.mean(axis=0)) ** 2)
    return float(np.sqrt(deviation / max(np.sum(jumps**2), 1e-300)))


def _refitted(solution: FittedValues, free: np.ndarray, counts: Array) -> Array:
    """Changes (m, p) of the shares where landings have other weights (m, n).

    The derivatives are held.

    Reweighted least squares for all m at once, in 12 steps:
    Σ_n w_n D_nᵀ D_n x = −Σ_n w_n D_nᵀ r_n,  w_n = count_n / √(1 + |r_n + D_n x|² / scale²).

    Args:
        solution: with the residuals r and their derivatives D.
        free: (p,) which shares change.
        counts: (m, n) how often each landing counts.
    """
    u = solution.u
    r = solution.residuals
    D = solution.derivatives
    unknowns = np.flatnonzero(free)
    changes = np.zeros((len(counts), len(u)))
    if not len(unknowns):
        return changes
    # Of each landing: D_nᵀ r_n, D_nᵀ D_n and |r_n|².
    Dr = np.einsum("nk,nkp->np", r, D)
    DD = np.einsum("nkp,nkq->npq", D, D)
    rr = np.sum(r**2, axis=1)
    identity = np.eye(len(unknowns))
    for _ in range(12):
        # |r_n + D_n x|² = |r_n|² + 2 x·D_nᵀ r_n + x·D_nᵀ D_n x
        square = rr + 2.0 * changes @ Dr.T + np.einsum("mp,npq,mq->mn", changes, DD, changes)
        weights = counts / np.sqrt(1.0 + np.maximum(square, 0.0) / solution.scale**2)
        A = np.einsum("mn,npq->mpq", weights, DD[:, unknowns][:, :, unknowns])
        b = -np.einsum("mn,np->mp", weights, Dr[:, unknowns])
        # A x = b, with a ridge for landings that say nothing of an unknown.
        trace = np.einsum("mpp->m", A)[:, None, None]
        ridge = 1e-12 * trace * identity + 1e-300 * identity
        x = np.linalg.solve(A + ridge, b[..., None])[..., 0]
        # Shares stay within [0, 1].
        within = np.clip(u[unknowns] + x, 0.0, 1.0)
        changes[:, unknowns] = within - u[unknowns]
    return changes


def errors_left_out(fit: Fit, solution: FittedValues, free: np.ndarray) -> Array:
    """The errors (n,) of landings that were left out when the values were found.

    Args: free, (p,) which of them change.
    """
    used = np.flatnonzero(fit.used)
    n = len(used)
    errors = np.full(len(fit.used), np.nan)
    parts = np.array_split(np.random.default_rng(SEED).permutation(n), min(FOLDS, n))
    counts = np.array([~np.isin(np.arange(n), part) for part in parts], dtype=float)
    for part, change in zip(parts, _refitted(solution, free, counts), strict=True):
        predicted = fit.predictor(fit.values(solution.u + change))
        rows = used[part]
        errors[rows] = fit.errors(solution.mobilities, predicted)[rows]
    return errors


def errors_of_free_impulse(fit: Fit, solution: FittedValues) -> Array:
    """The errors (n,) with the impulse at the contacts that fits each landing best.

    NaN where it would fit whatever jump.
    """
    predictor = fit.predictor
    values = solution.values
    measured = solution.predicted.measured
    errors = np.full(len(fit.used), np.nan)
    scale = predictor.by_subject(values).get(SCALE, 1.0)
    for rows, problem, to_measured in predictor.problems(values)[0]:
        # Measured jumps are moves p + stops, with the impulse p.
        moves = to_measured @ problem.by_impulse
        stops = (to_measured @ (scale * problem.halt)[..., None])[..., 0]
        for row, moved, stop in zip(rows.tolist(), moves, stops, strict=True):
            if not fit.used[row]:
                continue
            columns = np.flatnonzero(np.isfinite(measured[row]))
            W = solution.mobilities[row : row + 1]
            root = energy_roots(W, predictor.coordinates[columns])[0]
            change = root @ (measured[row] - stop)[columns]
            size = np.linalg.norm(root @ measured[row, columns])
            errors[row] = _unexplained(root @ moved[columns], change) / size
    return errors


def _unexplained(moves: Array, change: Array) -> float:
    """Norm of the part of a change (k,) that no impulse along moves (k, r) gives.

    NaN where the moves are more than half of its numbers.
    """
    U, s, _ = np.linalg.svd(moves, full_matrices=False)
    U = U[:, s > 1e-9 * s.max(initial=0.0)]
    if 2 * U.shape[1] > len(change):
        return np.nan
    return float(np.linalg.norm(change - U @ (U.T @ change)))


def drawn(n: int, draws: int) -> Array:
    """Counts (draws, n) of how often each of n landings is drawn, with replacement."""
    return np.random.default_rng(SEED).multinomial(n, np.full(n, 1.0 / n), size=draws).astype(float)


def _tails(n: int, p: int) -> tuple[float, float]:
    """Quantiles of a bootstrap that are the ends of a 95 % interval, of n landings and p unknowns.

    The usual quantiles are too narrow for few landings.

    The expanded percentiles of Hesterberg 2015, "What Teachers Should Know About the Bootstrap",
    The American Statistician 69:371.
    """
    from scipy.stats import norm, t

    tail = float(norm.cdf(np.sqrt(n / (n - p)) * t.ppf(0.025, n - p)))
    return tail, 1.0 - tail
