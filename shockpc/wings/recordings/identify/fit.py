"""Search for the values of unknowns with which predicted and measured jumps differ least."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.evaluation.variations.variation import Variation
from shockpc.text.errors import StudyError
from shockpc.wings.recordings.identify.predictor import Predicted, Predictor
from shockpc.wings.recordings.tables.prediction import energy_norms, energy_roots, mobilities

SEED = 0
"""Seed of the Sobol sequence, of the bootstrap and of the parts that are left out."""

SOBOL_BITS, STARTS = 8, 2
"""Binary logarithm of the most points of the Sobol sequence, and number of starts of the search.

The sequence is searched first; the search goes on from the starts.
"""

STEP = 5e-3
"""With which derivatives are differences, as a share of an unknown's range."""

EDGE = 2e-3
"""Share of the range within which a value is at its bound."""


@dataclass(frozen=True, eq=False)
class Fit:
    """The fit of predicted to measured jumps.

    Unknowns are shares u (p,) of their ranges, in logarithms where these are so.

    Attributes:
        predictor: of the jumps.
        before: jumps with the scene as it is given.
        used: (n,) which landings are used.
        whitening: (n, k, k) factors of jumps, by energies relative to that of the strike, or by
            noise; zero where nothing was measured.
        by_energy: whether they are by energies.
    """

    predictor: Predictor
    before: Predicted
    used: np.ndarray
    whitening: Array
    by_energy: bool

    @property
    def p(self) -> int:
        """Number of unknowns."""
        return len(self.predictor.unknowns)

    @property
    def freedoms(self) -> int:
        """Number of measured values less that of unknowns; at least 1."""
        return max(int(np.count_nonzero(self.whitening[self.used].any(axis=2))) - self.p, 1)

    def values(self, u: Array) -> tuple[float, ...]:
        """The values of the unknowns."""
        return tuple(map(value_at_share, self.predictor.unknowns, u.tolist()))

    def jumps(self, u: Array) -> Array:
        """Predicted jumps (n, k) of the landings that are used, by their energies or noise.

        A landing without prediction has no jump.
        """
        jumps = np.nan_to_num(self.predictor(self.values(u)).jumps)
        return np.asarray((self.whitening @ jumps[..., None])[self.used, :, 0])

    def residuals(self, u: Array) -> Array:
        """Predicted less measured jumps (n, k), as `jumps`."""
        predicted = self.predictor(self.values(u))
        difference = np.nan_to_num(predicted.jumps) - np.nan_to_num(predicted.measured)
        return np.asarray((self.whitening @ difference[..., None])[self.used, :, 0])

    def derivatives(self, u: Array, step: Array | float = STEP) -> Array:
        """Derivatives (n, k, p) of the residuals, by differences to both sides.

        At a bound of the range the difference is to one side.
        """
        columns = []
        for j, h in enumerate(np.broadcast_to(step, self.p)):
            low, high = u.copy(), u.copy()
            low[j], high[j] = max(u[j] - h, 0.0), min(u[j] + h, 1.0)
            columns.append((self.residuals(high) - self.residuals(low)) / (high[j] - low[j]))
        return np.stack(columns, axis=-1)

    def errors(self, W: Array, predicted: Predicted) -> Array:
        """The errors (n,) of the landings that are used, as in `Identification`.

        Args: W, their mobilities.
        """
        coordinates, measured = (
            self.predictor.coordinates,
            np.where(self.used[:, None], predicted.measured, np.nan),
        )
        difference = np.where(np.isnan(measured), np.nan, np.nan_to_num(predicted.jumps) - measured)
        with np.errstate(invalid="ignore", divide="ignore"):
            return energy_norms(W, coordinates, difference) / energy_norms(W, coordinates, measured)


class FittedValues(NamedTuple):
    """The values with which the landings are predicted best.

    Attributes:
        u: (p,) shares of the ranges.
        values: of the unknowns.
        scale: size of an ordinary residual.
        residuals: (n, k) of the landings that are used.
        derivatives: (n, k, p) of them by the shares.
        weights: (n,) by which the squares of landings count.
        left: standard deviation of a residual.
        predicted: the jumps.
        mobilities: (n, nv, nv) of all landings.
    """

    u: Array
    values: tuple[float, ...]
    scale: float
    residuals: Array
    derivatives: Array
    weights: Array
    left: float
    predicted: Predicted
    mobilities: Array


def fit_of(predictor: Predictor, noise: Array | None) -> Fit:
    """The fit of a predictor to what was measured.

    Args: noise, (k,) standard deviations of measured velocities, if they are given.

    Raises:
        StudyError: a range is not valid, or there are too few landings.
    """
    for share in (0.0, 1.0):
        # What is wrong with a range is said at once.
        _ = predictor.study(_values_at(predictor, share)).first
    before = predictor(None)
    W = mobilities(predictor.study(_values_at(predictor, 0.5)))
    moved = np.nan_to_num(before.measured).any(axis=1)
    used = moved & (predictor.strike_energy > 0.0) & np.isfinite(W).all(axis=(1, 2))
    if used.sum() <= len(predictor.unknowns):
        raise _too_few(predictor, before, int(used.sum()))
    whitening = _whitening(predictor, np.isfinite(before.measured), used, noise, W)
    return Fit(predictor, before, used, whitening, noise is None)


def _values_at(predictor: Predictor, share: float) -> tuple[float, ...]:
    """The values of the unknowns at a share of their ranges."""
    return tuple(value_at_share(unknown, share) for unknown in predictor.unknowns)


def _too_few(predictor: Predictor, before: Predicted, used: int) -> StudyError:
    """The error of too few landings that are used, with the first reason."""
    messages = [*predictor.rows.messages.values(), *before.messages.values()]
    known = np.isfinite(before.measured).any(axis=1)
    moved = np.nan_to_num(before.measured).any(axis=1)
    still = np.count_nonzero(known & ~moved)
    if still:
        messages.append(f"in {still} of the table all measured velocities are those before")
    why = f" ({messages[0]})" if messages else ""
    return StudyError(
        f"{used} landings that can be computed do not identify {len(predictor.unknowns)} unknowns; "
        f"give more{why}"
    )


def _whitening(
    predictor: Predictor, known: np.ndarray, used: np.ndarray, noise: Array | None, W: Array
) -> Array:
    """Matrices (n, k, k) that make residuals of differences.

    They are by the noise, or √(H / 2E) by the inertia H of what was measured and the energy E of
    the strike.

    Args:
        predictor: of the landings.
        known: (n, k) what was measured.
        used: (n,) which landings are used.
        noise: as for `fit_of`.
        W: (n, nv, nv) mobilities.
    """
    n, k = known.shape
    energy = predictor.strike_energy
    whitening = np.zeros((n, k, k))
    for pattern in np.unique(known[used], axis=0):
        rows = np.flatnonzero((known == pattern).all(axis=1) & used)
        columns = np.flatnonzero(pattern)
        if noise is None:
            roots = energy_roots(W[rows], predictor.coordinates[columns])
            roots = roots / np.sqrt(2.0 * energy[rows, None, None])
        else:
            shape = (len(rows), len(columns), len(columns))
            roots = np.broadcast_to(np.diag(1.0 / noise[columns]), shape)
        whitening[np.ix_(rows, columns, columns)] = roots
    return whitening


def fitted_values(fit: Fit) -> FittedValues:
    """The values of the unknowns with the minimum cost."""
    u, scale = _minimum(fit)
    values = fit.values(u)
    r = fit.residuals(u)
    square = np.sum(r**2, axis=1)
    weights = 1.0 / np.sqrt(1.0 + square / scale**2)
    left = float(np.sqrt(np.sum(weights * square) / fit.freedoms))
    # Differences over what is not known anyway: one landing that begins to slip counts for a part
    # of it.
    gains = np.sqrt(np.einsum("n,nkp->p", weights, fit.derivatives(u) ** 2))
    spread = left / np.maximum(gains, 1e-12)
    return FittedValues(
        u=u,
        values=values,
        scale=scale,
        residuals=r,
        derivatives=fit.derivatives(u, np.clip(spread, STEP, 0.1)),
        weights=weights,
        left=left,
        predicted=fit.predictor(values),
        mobilities=mobilities(fit.predictor.study(values)),
    )


def _minimum(fit: Fit) -> tuple[Array, float]:
    """The shares u with the minimum cost, and the size of an ordinary residual."""
    from scipy.stats import qmc

    points = qmc.Sobol(fit.p, rng=SEED).random_base2(min(3 + 2 * fit.p, SOBOL_BITS))
    sizes = np.array([np.linalg.norm(fit.residuals(u), axis=1) for u in points])
    scale = max(float(np.median(sizes, axis=1).min()), 1e-9)
    costs = [np.sum(np.sqrt(1.0 + size**2 / scale**2)) for size in sizes]
    starts = _apart(points[np.argsort(costs)], len(points) ** (-1.0 / fit.p))
    best = _best(fit, starts, scale)
    # The size of an ordinary residual is known better now.
    scale = max(float(np.median(np.linalg.norm(fit.residuals(best), axis=1))), 1e-9)
    best = _best(fit, [best], scale)
    return np.asarray(_at_bounds(fit, best, scale)), scale


def _apart(points: Array, distance: float) -> list[Array]:
    """The first points, at most `STARTS`, that are a distance apart along some axis."""
    starts: list[Array] = []
    for u in points:
        far = all(np.abs(u - start).max() > distance for start in starts)
        if far and len(starts) < STARTS:
            starts.append(u)
    return starts


def _best(fit: Fit, starts: Sequence[Array], scale: float) -> Array:
    """The shares of the least cost of the minima that some starts lead to."""
    from scipy.optimize import least_squares

    minima = []
    for start in starts:
        minimum = least_squares(
            lambda u: fit.residuals(u).ravel(),
            start,
            lambda u: fit.derivatives(u).reshape(-1, fit.p),
            (0.0, 1.0),
            loss=partial(_soft_l1, k=len(fit.predictor.measured)),
            f_scale=scale,
            xtol=1e-7,
            ftol=1e-9,
            gtol=1e-12,
            max_nfev=40,
        )
        minima.append(minimum.x)
    return np.asarray(min(minima, key=partial(_cost, fit, scale)))


def _at_bounds(fit: Fit, best: Array, scale: float) -> Array:
    """The shares with those at a bound that are near it, where the cost is not larger there."""
    for j in range(fit.p):
        for edge in (0.0, 1.0):
            if abs(best[j] - edge) >= 10.0 * EDGE:
                continue
            moved = np.where(np.arange(fit.p) == j, edge, best)
            if _cost(fit, scale, moved) <= _cost(fit, scale, best) * (1.0 + 1e-6):
                best = moved
    return best


def _cost(fit: Fit, scale: float, u: Array) -> float:
    """The sum that is minimised, at shares u."""
    return float(np.sum(np.sqrt(1.0 + np.sum(fit.residuals(u) ** 2, axis=1) / scale**2) - 1.0))


def value_at_share(variation: Variation, u: float) -> float:
    """The value of an unknown for a share of its range."""
    assert variation.span is not None
    low, high = variation.span
    if variation.law == "log-uniform":
        return float(np.clip(low * (high / low) ** u, low, high))
    return float(np.clip(low + u * (high - low), low, high))


def _soft_l1(z: Array, k: int) -> Array:
    """SciPy's loss of squares z (n k,): 2 (√(1 + Σz) − 1) of each landing.

    Σz is of the k residuals of the landing together, along whatever axes.
    """
    root = np.sqrt(1.0 + z.reshape(-1, k).sum(axis=1))
    share = np.where(np.arange(len(z)) % k == 0, np.repeat(2.0 * (root - 1.0), k), 0.0)
    return np.stack([share, np.repeat(1.0 / root, k), np.zeros(len(z))])
