"""The search for the unknowns of `identify`: those values with which predicted and measured jumps
differ least.
"""

from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.evaluation.variation import Variation
from shockpc.text.errors import StudyError
from shockpc.wings.recordings.logs.prediction import (
    Predicted,
    Predictor,
    energy_norms,
    energy_roots,
    mobilities,
)

SEED = 0
"""Of the Sobol sequence, of the bootstrap and of the parts that are left out."""

SOBOL_BITS, STARTS = 8, 2
"""Binary logarithm of the most points of the Sobol sequence that is searched first; and those from
which the search goes on.
"""

STEP = 5e-3
"""With which derivatives are differences, as a share of an unknown's range."""

EDGE = 2e-3
"""Share of the range within which a value is at its bound."""


@dataclass(frozen=True, eq=False)
class Fit:
    """What is minimised.

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
        return tuple(map(value_of, self.predictor.unknowns, u.tolist()))

    def jumps(self, u: Array) -> Array:
        """Predicted jumps (n, k) of the landings that are used, by their energies or noise; without
        prediction no jump.
        """
        jumps = np.nan_to_num(self.predictor(self.values(u)).jumps)
        return np.asarray((self.whitening @ jumps[..., None])[self.used, :, 0])

    def residuals(self, u: Array) -> Array:
        """Predicted less measured jumps (n, k), as `jumps`."""
        predicted = self.predictor(self.values(u))
        difference = np.nan_to_num(predicted.jumps) - np.nan_to_num(predicted.measured)
        return np.asarray((self.whitening @ difference[..., None])[self.used, :, 0])

    def derivatives(self, u: Array, step: Array | float = STEP) -> Array:
        """Derivatives (n, k, p) of the residuals: differences to both sides, as far as the range
        allows.
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


class Solution(NamedTuple):
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
    """What is minimised for a predictor.

    Args: noise, (k,) standard deviations of measured velocities, if they are given.

    Raises:
        StudyError: a range is not valid, or there are too few landings.
    """
    p = len(predictor.unknowns)
    corners = [
        tuple(value_of(one, share) for one in predictor.unknowns) for share in (0.0, 0.5, 1.0)
    ]
    for values in corners[::2]:
        _ = predictor.study(values).first  # what is wrong with a range is said at once
    before, energy, W = (
        predictor(None),
        predictor.strike_energy,
        mobilities(predictor.study(corners[1])),
    )
    known = np.isfinite(before.measured)
    moved = np.nan_to_num(before.measured).any(axis=1)
    used = moved & (energy > 0.0) & np.isfinite(W).all(axis=(1, 2))
    if used.sum() <= p:
        reasons = list(
            dict.fromkeys([*predictor.rows.messages.values(), *before.messages.values()])
        )
        if still := np.count_nonzero(known.any(axis=1) & ~moved):
            reasons.append(f"in {still} of the table all measured velocities are those before")
        raise StudyError(
            f"{used.sum()} landings that can be computed do not identify {p} unknowns; give more"
            + (f" ({reasons[0]})" if reasons else "")
        )
    whitening = np.zeros((len(known), known.shape[1], known.shape[1]))
    for pattern in np.unique(known[used], axis=0):
        rows, columns = (
            np.flatnonzero((known == pattern).all(axis=1) & used),
            np.flatnonzero(pattern),
        )
        if noise is not None:
            root = np.broadcast_to(
                np.diag(1.0 / noise[columns]), (len(rows), len(columns), len(columns))
            )
        else:
            root = energy_roots(W[rows], predictor.coordinates[columns]) / np.sqrt(
                2.0 * energy[rows, None, None]
            )
        whitening[np.ix_(rows, columns, columns)] = root
    return Fit(predictor, before, used, whitening, noise is None)


def solve(fit: Fit) -> Solution:
    """The values of the unknowns with the minimum cost."""
    predictor, (u, scale) = fit.predictor, _minimum(fit)
    r, values = fit.residuals(u), fit.values(u)
    weights = 1.0 / np.sqrt(1.0 + np.sum(r**2, axis=1) / scale**2)
    left = float(np.sqrt(np.sum(weights * np.sum(r**2, axis=1)) / fit.freedoms))
    # Differences over what is not known anyway: one landing that begins to slip counts for a part
    # of it.
    spread = left / np.maximum(
        np.sqrt(np.einsum("n,nkp->p", weights, fit.derivatives(u) ** 2)), 1e-12
    )
    derivatives = fit.derivatives(u, np.clip(spread, STEP, 0.1))
    return Solution(
        u,
        values,
        scale,
        r,
        derivatives,
        weights,
        left,
        predictor(values),
        mobilities(predictor.study(values)),
    )


def _minimum(fit: Fit) -> tuple[Array, float]:
    """The shares u with the minimum cost, and the size of an ordinary residual."""
    from scipy.optimize import least_squares
    from scipy.stats import qmc

    points = qmc.Sobol(fit.p, rng=SEED).random_base2(min(3 + 2 * fit.p, SOBOL_BITS))
    sizes = np.array([np.linalg.norm(fit.residuals(u), axis=1) for u in points])
    scale = max(float(np.median(sizes, axis=1).min()), 1e-9)
    order = np.argsort([np.sum(np.sqrt(1.0 + size**2 / scale**2)) for size in sizes])
    starts: list[Array] = []
    for u in points[order]:
        if len(starts) < STARTS and all(
            np.abs(u - other).max() > len(points) ** (-1.0 / fit.p) for other in starts
        ):
            starts.append(u)
    loss = partial(_soft_l1, k=len(fit.predictor.measured))
    for final in (False, True):
        fits = [
            least_squares(
                lambda u: fit.residuals(u).ravel(),
                u,
                lambda u: fit.derivatives(u).reshape(-1, fit.p),
                (0.0, 1.0),
                loss=loss,
                f_scale=scale,
                xtol=1e-7,
                ftol=1e-9,
                gtol=1e-12,
                max_nfev=40,
            ).x
            for u in starts
        ]
        best = min(fits, key=partial(_cost, fit, scale))
        if not final:
            # The size of an ordinary residual is known better now.
            scale, starts = (
                max(float(np.median(np.linalg.norm(fit.residuals(best), axis=1))), 1e-9),
                [best],
            )
    for j in range(fit.p):
        for edge in (0.0, 1.0):
            moved = np.where(np.arange(fit.p) == j, edge, best)
            if abs(best[j] - edge) < 10.0 * EDGE and _cost(fit, scale, moved) <= _cost(
                fit, scale, best
            ) * (1.0 + 1e-6):
                best = moved
    return np.asarray(best), scale


def _cost(fit: Fit, scale: float, u: Array) -> float:
    """What is minimised."""
    return float(np.sum(np.sqrt(1.0 + np.sum(fit.residuals(u) ** 2, axis=1) / scale**2) - 1.0))


def value_of(one: Variation, u: float) -> float:
    """The value of an unknown for a share of its range."""
    assert one.span is not None
    low, high = one.span
    if one.law == "log-uniform":
        return float(np.clip(low * (high / low) ** u, low, high))
    return float(np.clip(low + u * (high - low), low, high))


def _soft_l1(z: Array, k: int) -> Array:
    """SciPy's loss of squares z (n k,): 2 (√(1 + Σz) − 1) of the k residuals of a landing together,
    along whatever axes.
    """
    root = np.sqrt(1.0 + z.reshape(-1, k).sum(axis=1))
    share = np.where(np.arange(len(z)) % k == 0, np.repeat(2.0 * (root - 1.0), k), 0.0)
    return np.stack([share, np.repeat(1.0 / root, k), np.zeros(len(z))])
