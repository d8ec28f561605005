"""Impact with Coulomb friction: the impulses of contacts that stick, slide or separate.

With the Delassus matrix A = J H⁻¹ Jᵀ of the contact rows and their velocity v⁻, the impulse λ of
the ground gives v⁺ = v⁻ + A λ. At each contact, with restitution e along the normal (Newton) and
friction µ,

    w = v_n⁺ − e max(−v_n⁻, 0) ≥ 0,    λ_n ≥ 0,    w λ_n = 0
    |λ_t| ≤ µ λ_n,    and λ_t = −µ λ_n v_t⁺ / |v_t⁺| where it slides at the end

The direction of friction is that of the *final* slip; slip that stops or reverses during the impact
is not followed. Without restitution the result in a plane is that of Routh's method, which follows
it (Wang and Mason 1992, J. Appl. Mech. 59:635), unless slip reverses: then the normal impulse and
the loss of energy are larger here, and less slip or none is left. For one contact it is a root of a
quartic, and all roots are examined (Bonnefon and Daviet 2011, "Quartic formulation of Coulomb 3D
frictional contact", INRIA RT-0400). Several contacts are solved together, by Newton's method (Alart
and Curnier 1991, Comput. Methods Appl. Mech. Eng. 92:353) and block Gauss-Seidel sweeps, from
several starts; they may have solutions that were not found.

There may be more than one solution (Painlevé), and a solution may gain kinetic energy where e > 0
and slip stops or reverses (Kane and Levinson 1985, "Dynamics: Theory and Applications"). Each
solution comes with its change of energy.
"""

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array

CLOSE = 1e-9
"""Share of the velocities and impulses below which two of them are the same."""

CONVERGED = 1e-10
"""Residual, besides that of rounding, below which impulses count as a solution."""

GAIN = 1e-12
"""Change of energy, as a share of its terms, up to which it is rounding."""

RANK = 1e-12
"""Share of the largest eigenvalue of a Delassus matrix up to which one is zero."""


STARTS = 5
"""Number of starts of the search with several contacts."""


class FrictionImpact(NamedTuple):
    """A solution for m contacts.

    Attributes:
        impulse: (m, 3) impulse of the ground on the robot: two tangents, then the normal [N s].
        velocity: (m, 3) velocity of the contacts after impact along these [m/s].
        state: "sticks", "slides" or "separates" (takes no impulse) for each contact.
        energy: change of the kinetic energy, ½ λᵀ(v⁻ + v⁺) [J].
        gains_energy: whether that is above zero by more than rounding, so that the solution is not
            physical.
        residual: largest deviation from the laws above, as a velocity, relative to the largest
            velocity of the contacts [1].
    """

    impulse: Array
    velocity: Array
    state: tuple[str, ...]
    energy: float
    gains_energy: bool
    residual: float


def solve_friction(
    A: Array, velocity: Array, friction: Array, restitution: Array
) -> tuple[FrictionImpact, ...]:
    """Find the impulses of contacts with friction.

    Args:
        A: (3m, 3m) Delassus matrix of rows along two tangents and the normal of each contact
            [1/kg]; may be singular.
        velocity: (m, 3) before impact along these [m/s]; a contact approaches with a negative
            velocity along its normal.
        friction: (m,) µ.
        restitution: (m,) e along the normal.

    Returns: solutions that differ in the velocity after impact, those without a gain of energy
        first. For one contact these are all; for several, those found. Empty if none was found.

    Raises:
        ValueError: an argument is not finite, or µ or e is negative, or e is above 1.
    """
    velocity = np.asarray(velocity, dtype=float)
    mu = np.asarray(friction, dtype=float)
    e = np.asarray(restitution, dtype=float)
    if not all(np.all(np.isfinite(values)) for values in (A, velocity, mu, e)):
        raise ValueError("the Delassus matrix, velocities, friction and restitution must be finite")
    outside = (e < 0.0) | (e > 1.0)
    if np.any(mu < 0.0) or np.any(outside):
        raise ValueError(
            f"friction must not be negative, and restitution in [0, 1]: {mu.tolist()}, {e.tolist()}"
        )
    problem = _Problem(A, velocity, mu, _free_velocity(velocity, e))
    if len(mu) == 1:
        candidates: Iterable[Array] = _one_contact(A, problem.free[0], float(mu[0]))
    else:
        candidates = problem.search()

    solutions: list[FrictionImpact] = []
    for impulse in candidates:
        solution = problem.describe(np.reshape(impulse, (-1, 3)))
        if solution.residual > CONVERGED + problem.rounding(solution.impulse):
            continue
        if not any(problem.same(solution, known) for known in solutions):
            solutions.append(solution)
    return tuple(sorted(solutions, key=lambda solution: solution.gains_energy))


def solve_each(A: Array, velocity: Array, friction: Array, restitution: Array) -> Array:
    """The impulses of N landings on one contact each, as `solve_friction` finds them one by one.

    Args:
        A: (N, 3, 3) Delassus matrices [1/kg].
        velocity: (N, 3) before impact.
        friction: (N,) µ.
        restitution: (N,) e.

    Returns: (N, 3) impulses of the ground on the robot [N s]; of several solutions those that gain
        no energy go first, then those that stick. NaN where there is none, or each gains energy.
    """
    impulses, valid = _candidates(A, _free_velocity(velocity, restitution), friction)
    energy, size = _energy(impulses, velocity[:, None], impulses @ A, axis=-1)
    valid &= energy <= GAIN * size
    first = np.asarray(valid.argmax(axis=1))
    exists = np.asarray(valid.any(axis=1))
    impulse = impulses[np.arange(len(A)), first]
    return np.where(exists[:, None], impulse, np.nan)


def _free_velocity(velocity: Array, restitution: Array) -> Array:
    """The velocities before (m, 3), with v_n⁻ − e max(−v_n⁻, 0) along the normal: b of A λ + b."""
    b = velocity.copy()
    b[:, 2] -= restitution * np.maximum(-velocity[:, 2], 0.0)
    return b


def _energy(
    impulse: Array, velocity: Array, change: Array, axis: int | None = None
) -> tuple[Array, Array]:
    """The change of kinetic energy λᵀ (v⁻ + Δv / 2) [J], and the sum of the sizes of its terms."""
    energy = np.sum(impulse * (velocity + change / 2.0), axis=axis)
    size = np.sum(np.abs(impulse) * (np.abs(velocity) + np.abs(change)), axis=axis)
    return np.asarray(energy), np.asarray(size)


def _candidates(A: Array, b: Array, mu: Array) -> tuple[Array, np.ndarray]:
    """Impulses (N, 6, 3) of one contact with the velocity A λ + b, and which of them obey the laws.

    The first sticks, four slide and the last is none. b_n includes the velocity that restitution
    demands.
    """
    # A least-squares solution serves a contact that cannot move along a tangent.
    stick = -_smallest_solution(A, b)
    tangential = np.hypot(stick[:, 0], stick[:, 1])
    within_cone = tangential <= mu * stick[:, 2] * (1.0 + CLOSE)
    sticks = (stick[:, 2] > 0.0) & within_cone

    slide, slides = _sliding(A, b, mu)
    none = np.zeros((len(A), 1, 3))
    separates = b[:, 2] >= 0.0
    impulses = np.concatenate([stick[:, None], slide, none], axis=1)
    valid = np.concatenate([sticks[:, None], slides, separates[:, None]], axis=1)
    return impulses, valid


def _sliding(A: Array, b: Array, mu: Array) -> tuple[Array, np.ndarray]:
    """Impulses (N, 4, 3) with which a contact slides at the end, and which of them obey the laws.

    With A = [T a; aᵀ N], the final slip along the unit vector d and λ_t = −µ λ_n d,

        λ_n (N − µ a·d) = −b_n,    (b_t + λ_n (a − µ T d))·d > 0
    """
    angle, valid = _slip_angles(A, b, mu)
    d = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    T = A[:, :2, :2]
    a = A[:, :2, 2]
    N = A[:, 2, 2, None]
    q = -b[:, 2, None]
    mu = mu[:, None]

    pressing = N - mu * (d @ a[..., None])[..., 0]
    valid &= pressing * q > 0.0
    normal = q / np.where(valid, pressing, 1.0)

    slip_by_normal = a[:, None] - mu[..., None] * (d @ T)
    slip = b[:, None, :2] + normal[..., None] * slip_by_normal
    valid &= np.sum(slip * d, axis=-1) > 0.0
    tangential = -(mu * normal)[..., None] * d
    return np.concatenate([tangential, normal[..., None]], axis=-1), valid


def _slip_angles(A: Array, b: Array, mu: Array) -> tuple[Array, np.ndarray]:
    """Angles φ (N, 4) of the final slip, and a mask of those that solve its equation.

    Friction along −d, d = (cos φ, sin φ), leaves no slip across d. From λ_n (N − µ a·d) = q and
    d⊥·(b_t + λ_n (a − µ T d)) = 0 follows, without λ_n, k₀ + Re(k₁ w + k₂ w²) = 0 with w = exp(iφ).
    That is a quartic in w, whose roots of unit modulus are the angles.
    """
    k0, k1, k2 = _slip_harmonics(A, b, mu)
    size = np.abs(k0) + np.abs(k1) + np.abs(k2)
    quartic = np.abs(k2) > 1e-15 * size
    angle = _angles_of_cosine(k0, k1)
    angle[quartic] = _angles_of_quartic(k0[quartic], k1[quartic], k2[quartic])
    k2 = np.where(quartic, k2, 0.0)
    return _polished(angle, (k0[:, None], k1[:, None], k2[:, None]), size[:, None])


def _slip_harmonics(A: Array, b: Array, mu: Array) -> tuple[Array, Array, Array]:
    """k₀, k₁ and k₂ (N,) of the equation of the final slip.

    With A = [T a; aᵀ N], T = [txx txy; txy tyy], a = (ax, ay) and b = (x, y, −q),

        k₀ = µ (ay x − ax y) / 2
        k₁ = N y + q ay + i (N x + q ax)
        k₂ = µ (−(ax y + ay x) / 2 − q txy + i ((ay y − ax x) / 2 + q (tyy − txx) / 2))
    """
    (txx, txy, ax), (_, tyy, ay), (_, _, N) = np.moveaxis(A, 0, -1)
    x, y = b.T[:2]
    q = -b[:, 2]
    k0 = mu / 2.0 * (ay * x - ax * y)
    k1 = N * y + q * ay + 1j * (N * x + q * ax)
    k2_real = -(ax * y + ay * x) / 2.0 - q * txy
    k2_imaginary = (ay * y - ax * x) / 2.0 + q * (tyy - txx) / 2.0
    return k0, k1, mu * (k2_real + 1j * k2_imaginary)


def _angles_of_cosine(k0: Array, k1: Array) -> Array:
    """Angles φ (N, 4) without a second harmonic, each twice: cos(φ + arg k₁) = −k₀ / |k₁|."""
    k1_size = np.where(np.abs(k1) > 0.0, np.abs(k1), 1.0)
    half = np.arccos(np.clip(-k0 / k1_size, -1.0, 1.0))
    return np.asarray(half[:, None] * np.array([1, -1, 1, -1]) - np.angle(k1)[:, None])


def _angles_of_quartic(k0: Array, k1: Array, k2: Array) -> Array:
    """Angles φ (N, 4) of the roots of k₂ w⁴ + k₁ w³ + 2 k₀ w² + k₁* w + k₂* = 0.

    The roots are the eigenvalues of the companion matrix.
    """
    coefficients = np.stack([k1, 2.0 * k0, k1.conj(), k2.conj()], axis=1)
    companion = np.zeros((len(k0), 4, 4), dtype=complex)
    companion[:, [1, 2, 3], [0, 1, 2]] = 1.0
    companion[:, 0] = -(coefficients / k2[:, None])
    return np.asarray(np.angle(np.linalg.eigvals(companion)))


def _polished(
    angle: Array, harmonics: tuple[Array, Array, Array], size: Array
) -> tuple[Array, np.ndarray]:
    """Roots φ (N, 4) of k₀ + Re(k₁ w + k₂ w²), w = exp(iφ), and a mask of those that are.

    By Newton's method from angles near them.

    Args:
        angle: (N, 4) φ.
        harmonics: k₀, k₁ and k₂, (N, 1) each.
        size: (N, 1) sum of their absolute values.
    """
    k0, k1, k2 = harmonics
    for _ in range(4):
        w = np.exp(1j * angle)
        value = k0 + ((k1 + k2 * w) * w).real
        slope = -((k1 + 2.0 * k2 * w) * w).imag
        steep = np.abs(slope) > 1e-12 * size
        step = np.clip(value / np.where(steep, slope, 1.0), -0.1, 0.1)
        angle = angle - np.where(steep, step, 0.0)
    is_root = (np.abs(value) <= CLOSE * size) & (size > 0.0)
    return angle, np.asarray(is_root)


def _one_contact(A: Array, b: Array, mu: float) -> list[Array]:
    """All impulses (3,) of one contact, as `_candidates`, but none first."""
    impulses, valid = _candidates(A[None], b[None], np.array([mu]))
    order = [5, 0, 1, 2, 3, 4]
    return [impulses[0, k] for k in order if valid[0, k]]


def _smallest_solution(A: Array, b: Array) -> Array:
    """The smallest x (N, n) with A x = b, for positive semidefinite matrices A (N, n, n)."""
    s, Q = np.linalg.eigh(A)
    positive = s > RANK * s[:, -1:]
    inverse = np.where(positive, 1.0 / np.where(positive, s, 1.0), 0.0)
    along = Q.swapaxes(1, 2) @ b[..., None]
    return np.asarray((Q @ (inverse[..., None] * along))[..., 0])


class _Problem:
    """The laws of several contacts as one equation R(λ) = 0 (Alart and Curnier).

    With a mass ρ and y = λ − ρ v⁺ of each contact, v⁺ = A λ + b,

        R_n = λ_n − max(y_n, 0),    R_t = λ_t − y_t on or within a circle of radius µ max(λ_n, 0)

    Args:
        A: (3m, 3m) Delassus matrix [1/kg].
        velocity: (m, 3) before impact [m/s].
        mu: (m,) coefficients of friction.
        free: (m, 3) b, with the velocity that restitution demands along the normal.
    """

    def __init__(self, A: Array, velocity: Array, mu: Array, free: Array):
        self.A = A
        self.velocity = velocity
        self.mu = mu
        self.free = free
        self.speed = float(np.abs(free).max()) or 1.0
        mobility = np.diagonal(A).reshape(-1, 3).sum(axis=1)
        self.mass = 1.0 / np.where(mobility > 0.0, mobility, 1.0)

    def change(self, impulse: Array) -> Array:
        """A λ (m, 3) for impulses (m, 3) [m/s]."""
        return np.asarray((self.A @ impulse.ravel()).reshape(-1, 3))

    def residual(self, impulse: Array) -> tuple[Array, Array]:
        """R (3m,) at impulses (m, 3) [N s], and its derivative (3m, 3m)."""
        m = len(impulse)
        rho_v = self.mass[:, None] * (self.free + self.change(impulse))
        y = impulse - rho_v
        # Where y_n ≤ 0 its projection is zero: R = λ and ∂R/∂λ = 1.
        R = impulse.copy()
        D = np.eye(3 * m)
        for i in np.flatnonzero(y[:, 2] > 0.0).tolist():
            tangents = slice(3 * i, 3 * i + 2)
            normal = 3 * i + 2
            rows = slice(3 * i, 3 * i + 3)
            dy = D[rows] - self.mass[i] * self.A[rows]

            # Where y is its own projection, λ − y = ρ v⁺, without the rounding of λ.
            R[i, 2] = rho_v[i, 2]
            D[normal] -= dy[2]
            radius = self.mu[i] * max(impulse[i, 2], 0.0)
            length = float(np.hypot(y[i, 0], y[i, 1]))
            if length <= radius:
                R[i, :2] = rho_v[i, :2]
                D[tangents] -= dy[:2]
                continue
            # Onto the circle: radius d with d = y_t / |y_t| and ∂d/∂y_t = (1 − d dᵀ) / |y_t|.
            d = y[i, :2] / (length or 1.0)
            R[i, :2] -= radius * d
            D[tangents] -= (np.eye(2) - np.outer(d, d)) * (radius / length) @ dy[:2]
            if radius > 0.0:
                D[tangents, normal] -= self.mu[i] * d
        return R.ravel(), D

    def error(self, R: Array) -> float:
        """The size of a residual as a velocity, relative to those of the contacts."""
        velocities = R.reshape(-1, 3) / self.mass[:, None]
        return float(np.abs(velocities).max()) / self.speed

    def rounding(self, impulse: Array) -> float:
        """Largest contribution of the rounding of impulses (m, 3) to `error`."""
        largest = float((np.abs(impulse).max(axis=1) / self.mass).max())
        return 4.0 * float(np.finfo(float).eps) * largest / self.speed

    def newton(self, impulse: Array) -> Array:
        """Improve impulses (m, 3) by Newton's method, as far as the error decreases.

        Contacts that do not press take no impulse.
        """
        best = impulse
        smallest_error = np.inf
        for _ in range(20):
            R, D = self.residual(impulse)
            error = self.error(R)
            if error < smallest_error:
                best = impulse
                smallest_error = error
            if error < 1e-14 or not np.isfinite(error):
                break
            impulse = impulse - np.linalg.lstsq(D, R, rcond=1e-13)[0].reshape(-1, 3)
        after = self.free + self.change(best)
        pressing = best[:, 2] > self.mass * after[:, 2]
        return np.where(pressing[:, None], best, 0.0)

    def sweep(self, impulse: Array, order: list[int]) -> Array:
        """Solve each contact exactly, with the impulses of the others as they are."""
        impulse = impulse.copy()
        for i in order:
            rows = slice(3 * i, 3 * i + 3)
            local = self.A[rows, rows]
            by_all = self.A[rows] @ impulse.ravel()
            b = self.free[i] + by_all - local @ impulse[i]
            solutions = np.array(_one_contact(local, b, float(self.mu[i])))
            if len(solutions):
                steps = np.abs(solutions - impulse[i]).sum(axis=1)
                impulse[i] = solutions[steps.argmin()]
        return impulse

    def all_stick(self) -> Array:
        """The smallest impulses (m, 3) with which no contact moves, or moves least."""
        s, Q = np.linalg.eigh(self.A)
        # Directions without mobility are left out, not multiplied by zero: with dependent contacts,
        # last digits of the start decide which of several solutions the search finds.
        mobile = s > RANK * s[-1]
        Q = Q[:, mobile]
        velocity = self.free.ravel()
        return -np.asarray(Q @ ((Q.T @ velocity) / s[mobile])).reshape(-1, 3)

    def starts(self) -> Iterator[tuple[Array, list[int]]]:
        """Impulses (m, 3) to start from, and orders of the contacts.

        All contacts stick, none has an impulse, then random impulses.
        """
        m = len(self.mu)
        rng = np.random.default_rng(0)
        stick = self.all_stick()
        size = np.abs(stick).max()
        for k in range(STARTS):
            impulse = stick * (k == 0)
            if k > 1:
                impulse = size * np.column_stack([rng.normal(size=(m, 2)), np.ones(m)])
            order = list(range(m))
            if k > 0:
                order = rng.permutation(m).tolist()
            yield impulse, order

    def search(self) -> Iterator[Array]:
        """Impulses (m, 3) that solve the equation, or come nearest, from several starts."""
        for impulse, order in self.starts():
            for _ in range(30):
                polished = self.newton(impulse)
                if self.error(self.residual(polished)[0]) <= CONVERGED:
                    yield polished
                    break
                for _ in range(5):
                    impulse = self.sweep(impulse, order)

    def same(self, a: FrictionImpact, b: FrictionImpact) -> bool:
        """True if two solutions have the same velocities after impact."""
        apart = float(np.abs(a.velocity - b.velocity).max())
        return apart <= 1e3 * CLOSE * self.speed

    def describe(self, impulse: Array) -> FrictionImpact:
        """The solution that impulses (m, 3) are."""
        change = self.change(impulse)
        after = self.velocity + change
        energy, size = _energy(impulse, self.velocity, change)
        slips = np.hypot(after[:, 0], after[:, 1]) > CLOSE * self.speed
        state = np.where(slips, "slides", "sticks")
        state = np.where(impulse[:, 2] <= 0.0, "separates", state)
        return FrictionImpact(
            impulse=impulse,
            velocity=after,
            state=tuple(state.tolist()),
            energy=float(energy),
            gains_energy=bool(energy > GAIN * size),
            residual=self.error(self.residual(impulse)[0]),
        )
