"""The constant part of a landing on elements of finite stiffness, and that of its loaded ones.

The second depends on which elements are loaded.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from shockpc.core.memo import memoized
from shockpc.core.spatial import Array
from shockpc.wings.compliant.motion.damped import Damped, damped_modes
from shockpc.wings.compliant.motion.motion import Elements

NEGLIGIBLE = 1e-11
"""Share of the exciting motion below which what moves or presses counts as rounding.

It is the motion that excites the elements.
"""

DEPENDENT = 1e-13
"""Share of the largest frequency below which that of a mode is rounding.

Its rows are dependent, or it moves no spring.
"""

EASED = 0.01
"""Share of the largest force, compression or impact speed below which nothing is noticeable.

Force and compression are those of a contact.
"""


class Loaded(NamedTuple):
    """Quantities that depend on which elements are loaded.

    Attributes:
        fixed: rows that are held.
        sprung: (r,) rows with a spring that is loaded.
        still: (d, d) part of u that the held rows stop.
        to_all, held: (r, r) and (r, d) from z and u to the forces of all elements, of a held row
            with what dampers press on it.
        balance: (r,) the same of constant forces.
        damper: (r, d) from u to the forces of dampers.
        damped: the modes with the dampers that act; None without one.
        pull: (d,) rate at which constant forces change u.
        U, sigma, V: the modes, of the frequencies sigma (m,); with dampers in series, as many as
            there are elements.
        balanced, creep: (m,) the deflections with which springs balance constant forces, and the
            velocities at which dampers in series with them then give way.
    """

    fixed: np.ndarray
    sprung: np.ndarray
    still: Array
    to_all: Array
    held: Array
    balance: Array
    damper: Array
    damped: Damped | None
    pull: Array
    U: Array
    sigma: Array
    V: Array
    balanced: Array
    creep: Array


@dataclass(frozen=True, eq=False)
class System:
    """The elements, and the velocity before the impact, in the d coordinates of u.

    These are along the rows of the elements.

    All forces are scaled: they are those of the elements divided by −slope, √κ.

    Attributes:
        elements: the springs and dampers.
        W: (r, d) velocity along each element for unit u.
        to_velocity, constant, gravity, falling: as in `StiffMotion`.
        u: (d,) at the impact.
        pull: (d,) rate at which constant forces change u.
        length: (r,) of the rows of W.
        rigid_length: (r,) the same of a robot whose links stay straight.
        sprung: (r,) which elements have a spring.
        rigid: (r,) which are held once they are unloaded.
        grounded: (r,) which are of contacts.
        lossy: (r,) which are unloaded in another way than they are loaded, or are normals.
        damping: (r,) of the dampers; zero without one.
        relaxation: (r,) rate at which dampers in series let forces decay; zero without one [1/s].
        viscous: (r,) force of each damper for a unit rate, scaled.
        steady: (r,) constant forces [N, N m].
        noise: size of z and u that counts as rounding.
        fastest: largest natural frequency of a single element [rad/s].
        approaches: (r,) normals of contacts that approach the ground.
        slowly: (r,) rate up to which an element is slow.
    """

    elements: Elements
    W: Array
    to_velocity: Array
    constant: Array
    gravity: Array
    falling: Array
    u: Array
    pull: Array
    length: Array
    rigid_length: Array
    sprung: np.ndarray
    rigid: np.ndarray
    grounded: np.ndarray
    lossy: np.ndarray
    damping: Array
    relaxation: Array
    viscous: Array
    steady: Array
    noise: float
    fastest: float
    approaches: np.ndarray
    slowly: Array

    @property
    def push_noise(self) -> Array:
        """Scaled forces (r,) of spring and damper that count as rounding."""
        return np.asarray(self.noise * (1.0 + self.viscous * self.length))

    @memoized(most=64)
    def loaded(self, held_rows: bytes, sprung_rows: bytes, slopes: bytes, dampers: bool) -> Loaded:
        """Quantities that depend on which elements are loaded.

        Where contacts open and close, the same are loaded again and again.

        Args:
            held_rows: bytes of a bool array (r,), which rows are held.
            sprung_rows: the same, which have springs that are loaded.
            slopes: bytes of the slopes (r,).
            dampers: whether those act.
        """
        sprung, slope = np.frombuffer(sprung_rows, dtype=bool), np.frombuffer(slopes)
        fixed = np.flatnonzero(np.frombuffer(held_rows, dtype=bool))
        acting = sprung & (self.damping > 0.0) & dampers
        relaxes = sprung & (self.relaxation > 0.0) & dampers
        damper = np.where(acting, self.viscous, 0.0)[:, None] * self.W
        F = np.where(sprung, slope, 0.0)[:, None] * self.W
        G = np.sqrt(self.damping[acting])[:, None] * self.W[acting]
        # Springs, dampers and constant forces without the part of u that held rows stop.
        free = self._held(fixed, sprung, slope, F, G)

        U, sigma, V = _modes(free.F, bool(relaxes.any()))
        moves, along = sigma > 0.0, V.T @ free.pull
        balanced, creep = np.zeros((2, len(sigma)))
        # Constant forces balance springs at the deflection σ⁻¹ Vᵀ pull of each mode.
        balanced[moves] = 1.0 / sigma[moves] * along[moves]
        of_dampers = None
        if acting.any() or relaxes.any():
            in_series = np.sqrt(self.relaxation[relaxes])[:, None] * U[relaxes]
            of_dampers = damped_modes(sigma, free.G @ V, in_series)
        if of_dampers is not None and relaxes.any():
            # Where A (p, υ) and constant forces balance.
            constant = np.append(np.zeros(len(sigma)), along[moves])
            steady = np.linalg.lstsq(of_dampers.A, -constant, rcond=1e-12)[0]
            balanced[:], creep[moves] = steady[: len(sigma)], steady[len(sigma) :]
        return Loaded(
            fixed=fixed,
            sprung=sprung,
            still=free.still,
            to_all=free.to_all,
            held=free.held,
            balance=free.balance,
            damper=damper,
            damped=of_dampers,
            pull=free.pull,
            U=U,
            sigma=sigma,
            V=V,
            balanced=balanced,
            creep=creep,
        )

    def _held(
        self, fixed: np.ndarray, sprung: np.ndarray, slope: Array, F: Array, G: Array
    ) -> "_Held":
        """Springs and dampers with some rows held.

        From H u̇ = 0 with u̇ = −Fᵀz − GᵀGu − Hᵀm + c follows m = (H Hᵀ)⁻¹ H (c − Fᵀz − GᵀGu); of
        dependent rows each takes the smallest share.

        Args:
            fixed: rows that are held.
            sprung: (r,) rows with a spring that is loaded.
            slope: (r,) √κ.
            F: (r, d) springs, slope times W.
            G: (k, d) dampers, √c times W.
        """
        (r, d), pull = self.W.shape, self.pull
        to_all, held, balance = np.diag(sprung.astype(float)), np.zeros((r, d)), np.zeros(r)
        if not len(fixed):
            return _Held(np.zeros((d, d)), to_all, held, balance, F, G, pull)
        H, size = self.W[fixed] / self.length[fixed, None], (slope * self.length)[fixed]
        least = np.linalg.pinv(H.T, rcond=1e-9)
        still = H.T @ least
        to_all[fixed] = -(least @ F.T) / size[:, None]
        held[fixed] = -(least @ G.T @ G) / size[:, None]
        balance[fixed] = least @ pull / size
        return _Held(
            still, to_all, held, balance, F - F @ still, G - G @ still, pull - still @ pull
        )


class _Held(NamedTuple):
    """Springs and dampers with some rows held.

    Attributes:
        still, to_all, held, balance, pull: as in `Loaded`; the scaled forces of all elements are
            to_all · z + held · u + balance.
        F: (r, d) springs, without the part of u that held rows stop.
        G: (k, d) dampers, the same.
    """

    still: Array
    to_all: Array
    held: Array
    balance: Array
    F: Array
    G: Array
    pull: Array


def _modes(F: Array, full: bool) -> tuple[Array, Array, Array]:
    """The singular vectors and values F = U diag(σ) Vᵀ: U (r, m), σ (m,) and V (d, m), m ≥ d.

    Args: F (r, d); full, whether m is at least r, by modes that move nothing.
    """
    d = F.shape[1]
    U, sigma, Vt = np.linalg.svd(F, full_matrices=full)
    more = U.shape[1] - d
    V, sigma = np.pad(Vt.T, ((0, 0), (0, more))), np.pad(sigma, (0, more))
    sigma[sigma < DEPENDENT * sigma.max(initial=0.0)] = 0.0
    return U, sigma, V


def system_of(
    elements: Elements,
    W: Array,
    to_velocity: Array,
    from_velocity: Array,
    velocity: Array,
    gravity: Array,
) -> System:
    """The system of a landing.

    Args:
        elements: the springs and dampers.
        W: (r, d) velocity along each element for unit u.
        to_velocity: (n, d) from u to velocities.
        from_velocity: (d, n) back.
        velocity: (n,) before the impact [rad/s, m/s].
        gravity: (n,) accelerations of free fall [rad/s², m/s²].
    """
    u, falling = from_velocity @ velocity, from_velocity @ gravity
    length, slope = np.linalg.norm(W, axis=1), np.sqrt(elements.stiffness)
    sprung = elements.stiffness > 0.0
    damping = np.broadcast_to(np.asarray(elements.damping, dtype=float), len(W))
    steady = np.where(sprung, 0.0, np.asarray(elements.load))
    # √κ |W_i| is the frequency of element i alone.
    pull, speed, single = falling + W.T @ steady, float(np.linalg.norm(u)), slope * length
    rate, rigid_length = W @ u, length
    bends = np.broadcast_to(elements.straight, len(W))
    if bends.any():
        # Without the velocities of hinges: W (1 − S⁺ S), of the rows S of hinges.
        of_hinges = np.linalg.pinv(W[bends], rcond=1e-9) @ W[bends]
        rigid_length = np.linalg.norm(W - W @ of_hinges, axis=1)
    # A contact at rest approaches by no more than rounding.
    approaches = elements.normal & (rate < -1e-13 * length * speed)
    strike = np.max(-rate[approaches] / rigid_length[approaches], initial=0.0)
    # What single contacts come to rest at counts like the speed.
    at_rest = float(np.linalg.norm(pull)) / float(single[elements.normal].min())
    return System(
        elements=elements,
        W=W,
        to_velocity=to_velocity,
        constant=velocity - to_velocity @ u,
        gravity=gravity,
        falling=gravity - to_velocity @ falling,
        u=u,
        pull=pull,
        length=length,
        rigid_length=rigid_length,
        sprung=sprung,
        rigid=elements.restitution == 0.0,
        grounded=elements.contact >= 0,
        lossy=elements.normal | (elements.restitution < 1.0),
        damping=damping,
        relaxation=np.broadcast_to(np.asarray(elements.relaxation, dtype=float), len(W)),
        viscous=damping / np.where(sprung, slope, 1.0),
        steady=steady,
        noise=NEGLIGIBLE * (speed + at_rest),
        fastest=float(single.max()),
        approaches=approaches,
        slowly=EASED * float(strike) * rigid_length,
    )
