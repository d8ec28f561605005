"""What depends on which elements of a landing are loaded: held rows, springs and their modes."""

from typing import NamedTuple

import numpy as np

from shockpc.core.memo import memoized
from shockpc.core.spatial import Array
from shockpc.wings.compliant.motion.damped import Damped, damped_modes
from shockpc.wings.compliant.motion.system import ScaledSystem

DEPENDENT = 1e-13
"""Share of the largest frequency below which that of a mode is rounding.

Its rows are dependent, or it moves no spring.
"""


class Held(NamedTuple):
    """Rows that are held, and what is left with these.

    The scaled forces of all elements are to_all · z + from_u · u + balance.

    Attributes:
        rows: which are held.
        still: (d, d) part of u that they stop.
        to_all: (r, r) from z to the forces of all elements.
        from_u: (r, d) from u to the forces of held rows, by what dampers press on them.
        balance: (r,) forces of held rows by constant forces.
        F: (r, d) springs, without the part of u that held rows stop.
        G: (k, d) dampers, the same.
        pull: (d,) rate at which constant forces change u, the same.
    """

    rows: np.ndarray
    still: Array
    to_all: Array
    from_u: Array
    balance: Array
    F: Array
    G: Array
    pull: Array


class SpringModes(NamedTuple):
    """The m modes of the springs that are loaded: F = U diag(σ) Vᵀ.

    Attributes:
        U: (r, m) of the springs; with dampers in series, as many as there are elements.
        sigma: (m,) σ, the frequencies [rad/s].
        V: (d, m) of the coordinates.
        damped: the modes with the dampers that act; None without one.
        balanced: (m,) deflections with which springs balance constant forces.
        creep: (m,) velocities at which dampers in series with them then give way.
    """

    U: Array
    sigma: Array
    V: Array
    damped: Damped | None
    balanced: Array
    creep: Array


class Loaded(NamedTuple):
    """Quantities that depend on which elements are loaded.

    Attributes:
        sprung: (r,) rows with a spring that is loaded.
        held: rows that are held.
        damper: (r, d) from u to the forces of dampers beside springs.
        modes: of the springs.
    """

    sprung: np.ndarray
    held: Held
    damper: Array
    modes: SpringModes


@memoized(most=64)
def loaded_elements(
    system: ScaledSystem, held_rows: bytes, sprung_rows: bytes, slopes: bytes, dampers: bool
) -> Loaded:
    """Quantities that depend on which elements are loaded.

    Where contacts open and close, the same are loaded again and again.

    Args:
        system: what stays the same.
        held_rows: bytes of a bool array (r,), which rows are held.
        sprung_rows: the same, which have springs that are loaded.
        slopes: bytes of the slopes (r,), √κ.
        dampers: whether those act.
    """
    elements, W = system.elements, system.W
    rows = np.flatnonzero(np.frombuffer(held_rows, dtype=bool))
    sprung = np.frombuffer(sprung_rows, dtype=bool)
    slope = np.frombuffer(slopes)
    acting = sprung & (elements.damping > 0.0) & dampers
    relaxes = sprung & (elements.relaxation > 0.0) & dampers

    damper = np.where(acting, system.viscous, 0.0)[:, None] * W
    F = np.where(sprung, slope, 0.0)[:, None] * W
    G = np.sqrt(elements.damping[acting])[:, None] * W[acting]
    held = _held(system, rows, sprung, slope, F, G)
    series = np.where(relaxes, elements.relaxation, 0.0)
    return Loaded(sprung, held, damper, _modes(held, series))


def _held(
    system: ScaledSystem, rows: np.ndarray, sprung: np.ndarray, slope: Array, F: Array, G: Array
) -> Held:
    """Springs and dampers with some rows held.

    From H u̇ = 0 with u̇ = −Fᵀz − GᵀGu − Hᵀm + c follows m = (H Hᵀ)⁻¹ H (c − Fᵀz − GᵀGu); of
    dependent rows each takes the smallest share.

    Args:
        system: what stays the same.
        rows: rows that are held.
        sprung: (r,) rows with a spring that is loaded.
        slope: (r,) √κ.
        F: (r, d) springs, slope times W.
        G: (k, d) dampers, √c times W.
    """
    W, length, pull = system.W, system.length, system.pull
    (r, d) = W.shape
    to_all, from_u, balance = np.diag(sprung.astype(float)), np.zeros((r, d)), np.zeros(r)
    if not len(rows):
        return Held(rows, np.zeros((d, d)), to_all, from_u, balance, F, G, pull)
    H = W[rows] / length[rows, None]
    size = (slope * length)[rows]
    # (H Hᵀ)⁻¹ H
    least = np.linalg.pinv(H.T, rcond=1e-9)
    still = H.T @ least
    to_all[rows] = -(least @ F.T) / size[:, None]
    from_u[rows] = -(least @ G.T @ G) / size[:, None]
    balance[rows] = least @ pull / size
    moving = pull - still @ pull
    return Held(rows, still, to_all, from_u, balance, F - F @ still, G - G @ still, moving)


def _modes(held: Held, relaxation: Array) -> SpringModes:
    """The modes of springs and dampers with some rows held.

    Args:
        held: springs, dampers and constant forces.
        relaxation: (r,) rate at which dampers in series let forces decay; zero without one [1/s].
    """
    relaxes = relaxation > 0.0
    U, sigma, V = _singular_vectors(held.F, full=bool(relaxes.any()))
    moves = sigma > 0.0
    along = V.T @ held.pull
    balanced, creep = np.zeros((2, len(sigma)))
    # Constant forces balance springs at the deflection σ⁻¹ Vᵀ pull of each mode.
    balanced[moves] = 1.0 / sigma[moves] * along[moves]
    damped = None
    if len(held.G) or relaxes.any():
        in_series = np.sqrt(relaxation[relaxes])[:, None] * U[relaxes]
        damped = damped_modes(sigma, held.G @ V, in_series)
        if relaxes.any():
            # Where A (p, υ) and constant forces balance.
            constant = np.append(np.zeros(len(sigma)), along[moves])
            steady = np.linalg.lstsq(damped.A, -constant, rcond=1e-12)[0]
            balanced[:], creep[moves] = steady[: len(sigma)], steady[len(sigma) :]
    return SpringModes(U, sigma, V, damped, balanced, creep)


def _singular_vectors(F: Array, full: bool) -> tuple[Array, Array, Array]:
    """The singular vectors and values F = U diag(σ) Vᵀ: U (r, m), σ (m,) and V (d, m), m ≥ d.

    Args: F (r, d); full, whether m is at least r, by modes that move nothing.
    """
    d = F.shape[1]
    U, sigma, Vt = np.linalg.svd(F, full_matrices=full)
    more = U.shape[1] - d
    V, sigma = np.pad(Vt.T, ((0, 0), (0, more))), np.pad(sigma, (0, more))
    sigma[sigma < DEPENDENT * sigma.max(initial=0.0)] = 0.0
    return U, sigma, V
