"""How well the unknowns of `identify` are known: intervals, what the data do not tell apart, and
errors of other landings.

Intervals are a bootstrap over landings: each draw gives landings other weights, and the values
follow from the derivatives at the solution. So do the values without the landings that are left
out, which are then predicted in full.
"""

from typing import Literal, NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.evaluation.variation import Variation
from shockpc.wings.recordings.identify.fit import EDGE, SEED, Fit, Solution, value_of
from shockpc.wings.recordings.logs.prediction import SCALE, energy_roots

DRAWS, FOLDS = 1000, 5
"""Of the bootstrap; and parts in which landings are left out."""

ALIKE = 0.05
"""Relative scatter of the predicted jumps over the speeds of the strikes up to which landings are
all alike.
"""

NO_INFLUENCE, UNSEEN = 1e-6, 1e-4
"""Shares of the jumps: what changes so little over its range has no influence, and what several
change together is not seen.
"""

State = Literal[
    "identified", "at its bound", "not identifiable", "no influence", "error does not fall"
]

CONFIRMED = 1e-3
"""Share of the jumps by which two predictions may differ that count as the same."""


class Unknown(NamedTuple):
    """What was found of an unknown.

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
    """How well the unknowns are known.

    Attributes:
        unknowns: with their values and intervals.
        correlation: (p, p) of the values; NaN where one was not identified.
        singular: (p,) singular values of the derivatives by the shares of the ranges, relative to
            what is left unexplained.
        unseen: directions (p,) of the shares along which the data say nothing.
        scatter: relative scatter of the predicted jumps over the speeds of the strikes.
        seen: (p,) which unknowns have an influence that is seen.
    """

    unknowns: tuple[Unknown, ...]
    correlation: Array
    singular: Array
    unseen: tuple[Array, ...]
    scatter: float
    seen: np.ndarray


def uncertainty(fit: Fit, found: Solution) -> Uncertainty:
    """How well the unknowns are known at the solution."""
    p, n, u, D = fit.p, int(fit.used.sum()), found.u, found.derivatives
    singular, V = np.linalg.svd((np.sqrt(found.weights)[:, None, None] * D).reshape(-1, p))[1:]
    size = float(np.linalg.norm(fit.jumps(u)))
    without = np.linalg.norm(D, axis=(0, 1)) <= NO_INFLUENCE * size
    # A direction is not seen if its 95 % interval is as wide as the range, or if it changes next to
    # nothing.
    unseen = tuple(V[j] for j in range(p) if not singular[j] > max(4.0 * found.left, UNSEEN * size))
    vague = np.any([np.abs(v) > 0.3 for v in unseen], axis=0) if unseen else np.zeros(p, dtype=bool)
    edge, scatter = (u < EDGE) | (u > 1.0 - EDGE), _scatter(fit, u)
    free = ~(edge | without | vague)
    steps = _refitted(found, free, drawn(n, DRAWS))
    states: list[State] = [
        "no influence"
        if without[j]
        else "not identifiable"
        if vague[j] or scatter < ALIKE
        else "at its bound"
        if edge[j]
        else "identified"
        for j in range(p)
    ]
    unknowns = []
    for j, (one, value, state) in enumerate(
        zip(fit.predictor.unknowns, found.values, states, strict=True)
    ):
        low = high = np.nan
        if state == "identified":
            ends = np.quantile(np.clip(u[j] + steps[:, j], 0.0, 1.0), _tails(n, int(free.sum())))
            low, high = (value_of(one, end) for end in ends.tolist())
        unknowns.append(Unknown(one, value, low, high, state))
    correlation = np.full((p, p), np.nan)
    if free.any():
        covariance = np.cov(steps[:, free].T).reshape(free.sum(), free.sum())
        sizes = np.sqrt(np.maximum(np.diagonal(covariance), 1e-300))
        correlation[np.ix_(free, free)] = covariance / np.outer(sizes, sizes)
    return Uncertainty(
        tuple(unknowns),
        correlation,
        singular / max(found.left, 1e-300),
        unseen,
        scatter,
        ~(without | vague),
    )


def confirmed(fit: Fit, found: Solution) -> bool:
    """Whether the scene as it is given predicts the same as the values found, so that no error can
    fall.
    """
    given, after = (np.nan_to_num(part.jumps[fit.used]) for part in (fit.before, found.predicted))
    return bool(np.linalg.norm(after - given) <= CONFIRMED * np.linalg.norm(after))


def unidentified(known: Uncertainty) -> Uncertainty:
    """The same where the values found predict no better than the scene as it is given: nothing is
    identified.
    """
    unknowns = tuple(
        one._replace(low=np.nan, high=np.nan, state="error does not fall")
        if one.state == "identified"
        else one
        for one in known.unknowns
    )
    return known._replace(unknowns=unknowns, correlation=np.full_like(known.correlation, np.nan))


def _scatter(fit: Fit, u: Array) -> float:
    """Relative scatter of the predicted jumps, each by the energy or speed of its strike."""
    if fit.by_energy:
        jumps = fit.jumps(u)
    else:
        jumps = np.nan_to_num(fit.predictor(fit.values(u)).jumps)[fit.used]
        jumps = jumps / np.sqrt(fit.predictor.strike_energy[fit.used, None])
    return float(np.sqrt(np.sum((jumps - jumps.mean(axis=0)) ** 2) / max(np.sum(jumps**2), 1e-300)))


def _refitted(found: Solution, free: np.ndarray, counts: Array) -> Array:
    """By how much (m, p) the shares differ where landings have other weights (m, n), with the
    derivatives held.

    Args:
        found: the solution.
        free: (p,) which shares change.
        counts: (m, n) how often each landing counts.
    """
    u, r, D, unknowns = found.u, found.residuals, found.derivatives, np.flatnonzero(free)
    b, M = np.einsum("nk,nkp->np", r, D), np.einsum("nkp,nkq->npq", D, D)
    square, step = np.sum(r**2, axis=1), np.zeros((len(counts), len(u)))
    if not len(unknowns):
        return step
    for _ in range(12):
        size = square + 2.0 * step @ b.T + np.einsum("mp,npq,mq->mn", step, M, step)
        weights = counts / np.sqrt(1.0 + np.maximum(size, 0.0) / found.scale**2)
        A = np.einsum("mn,npq->mpq", weights, M[:, unknowns][:, :, unknowns])
        right = -np.einsum("mn,np->mp", weights, b[:, unknowns])
        ridge = 1e-12 * np.einsum("mpp->m", A)[:, None, None] * np.eye(
            len(unknowns)
        ) + 1e-300 * np.eye(len(unknowns))
        step[:, unknowns] = (
            np.clip(u[unknowns] + np.linalg.solve(A + ridge, right[..., None])[..., 0], 0.0, 1.0)
            - u[unknowns]
        )
    return step


def errors_left_out(fit: Fit, found: Solution, free: np.ndarray) -> Array:
    """The errors (n,) of landings that were left out when the values were found.

    Args: free, (p,) which of them change.
    """
    used, errors = np.flatnonzero(fit.used), np.full(len(fit.used), np.nan)
    parts = np.array_split(
        np.random.default_rng(SEED).permutation(len(used)), min(FOLDS, len(used))
    )
    counts = np.array([~np.isin(np.arange(len(used)), part) for part in parts], dtype=float)
    for part, step in zip(parts, _refitted(found, free, counts), strict=True):
        errors[used[part]] = fit.errors(
            found.mobilities, fit.predictor(fit.values(found.u + step))
        )[used[part]]
    return errors


def errors_of_free_impulse(fit: Fit, found: Solution) -> Array:
    """The errors (n,) with the impulse at the contacts that fits each landing best; NaN where it
    would fit whatever jump.
    """
    predictor, values, errors = fit.predictor, found.values, np.full(len(fit.used), np.nan)
    measured, scale = found.predicted.measured, predictor.by_subject(values).get(SCALE, 1.0)
    for rows, problem, to_measured in predictor.problems(values)[0]:
        moves, stops = (
            to_measured @ problem.by_impulse,
            (to_measured @ (scale * problem.halt)[..., None])[..., 0],
        )
        for row, moved, stop in zip(rows.tolist(), moves, stops, strict=True):
            columns = np.flatnonzero(np.isfinite(measured[row]))
            if not fit.used[row]:
                continue
            root = energy_roots(found.mobilities[row : row + 1], predictor.coordinates[columns])[0]
            U, s, _ = np.linalg.svd(root @ moved[columns], full_matrices=False)
            U, jump = U[:, s > 1e-9 * s.max(initial=0.0)], root @ (measured[row] - stop)[columns]
            if 2 * U.shape[1] <= len(columns):
                errors[row] = np.linalg.norm(jump - U @ (U.T @ jump)) / np.linalg.norm(
                    root @ measured[row, columns]
                )
    return errors


def drawn(n: int, draws: int) -> Array:
    """How often (draws, n) each of n landings is drawn, with replacement."""
    return np.random.default_rng(SEED).multinomial(n, np.full(n, 1.0 / n), size=draws).astype(float)


def _tails(n: int, p: int) -> tuple[float, float]:
    """Quantiles of a bootstrap that are the ends of a 95 % interval: those of n landings and p
    unknowns are too narrow otherwise.

    The expanded percentiles of Hesterberg 2015, "What Teachers Should Know About the Bootstrap",
    The American Statistician 69:371.
    """
    from scipy.stats import norm, t

    tail = float(norm.cdf(np.sqrt(n / (n - p)) * t.ppf(0.025, n - p)))
    return tail, 1.0 - tail
