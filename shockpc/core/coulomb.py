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

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array

CLOSE = 1e-9
"""Share of the velocities and impulses below which two of them are the same."""

CONVERGED = 1e-10
"""Residual, besides that of rounding, below which impulses count as a solution."""


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
    A: Array, velocity: Array, friction: Array, restitution: Array, starts: int = 5
) -> tuple[FrictionImpact, ...]:
    """Find the impulses of contacts with friction.

    Args:
        A: (3m, 3m) Delassus matrix of rows along two tangents and the normal of each contact
            [1/kg]; may be singular.
        velocity: (m, 3) before impact along these [m/s]; a contact approaches with a negative
            velocity along its normal.
        friction: (m,) µ.
        restitution: (m,) e along the normal.
        starts: number of starts of the search with several contacts.

    Returns: solutions that differ in the velocity after impact, those without a gain of energy
        first. For one contact these are all; for several, those found. Empty if none was found.

    Raises:
        ValueError: an argument is not finite, or µ or e is negative, or e is above 1.
    """
    velocity, mu, e = (
        np.asarray(values, dtype=float) for values in (velocity, friction, restitution)
    )
    if not all(np.all(np.isfinite(values)) for values in (A, velocity, mu, e)):
        raise ValueError("the Delassus matrix, velocities, friction and restitution must be finite")
    if np.any(mu < 0.0) or np.any((e < 0.0) | (e > 1.0)):
        raise ValueError(
            f"friction must not be negative, and restitution in [0, 1]: {mu.tolist()}, {e.tolist()}"
        )
    problem = _Problem(A, velocity, mu, velocity[:, 2] - e * np.maximum(-velocity[:, 2], 0.0))
    impulses = (
        _one_contact(A, problem.free[0], float(mu[0])) if len(mu) == 1 else problem.search(starts)
    )
    solutions: list[FrictionImpact] = []
    for impulse in impulses:
        solution = problem.describe(np.reshape(impulse, (-1, 3)))
        near = [
            np.abs(solution.velocity - other.velocity).max() <= 1e3 * CLOSE * problem.speed
            for other in solutions
        ]
        if solution.residual <= CONVERGED + problem.rounding(solution.impulse) and not any(near):
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
    b = velocity.copy()
    b[:, 2] -= restitution * np.maximum(-velocity[:, 2], 0.0)
    impulses, valid = _candidates(A, b, friction)
    change = impulses @ A
    energy = np.sum(impulses * (velocity[:, None] + change / 2.0), axis=-1)
    valid &= energy <= 1e-12 * np.sum(
        np.abs(impulses) * (np.abs(velocity[:, None]) + np.abs(change)), axis=-1
    )
    first, exists = np.asarray(valid.argmax(axis=1)), np.asarray(valid.any(axis=1))
    return np.where(exists[:, None], impulses[np.arange(len(A)), first], np.nan)


def _candidates(A: Array, b: Array, friction: Array) -> tuple[Array, np.ndarray]:
    """Impulses (N, 6, 3) of one contact with the velocity A λ + b, and which of them obey the laws.

    The first sticks, four slide and the last is none. b_n includes the velocity that restitution
    demands.
    """
    mu = friction[:, None]
    # A least-squares solution serves a contact that cannot move along a tangent.
    s, Q = np.linalg.eigh(A)
    kept = s > 1e-12 * s[:, -1:]
    stick = -(
        Q
        @ (
            np.where(kept, 1.0 / np.where(kept, s, 1.0), 0.0)[..., None]
            * (Q.swapaxes(1, 2) @ b[..., None])
        )
    )[..., 0]
    sticks = (stick[:, 2] > 0.0) & (
        np.hypot(stick[:, 0], stick[:, 1]) <= friction * stick[:, 2] * (1.0 + CLOSE)
    )
    angle, valid = _slip_angles(A, b, friction)
    d = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    pressing = A[:, 2, 2, None] - mu * (d @ A[:, :2, 2, None])[..., 0]
    valid &= pressing * -b[:, 2, None] > 0.0
    normal = -b[:, 2, None] / np.where(valid, pressing, 1.0)
    slip = b[:, None, :2] + normal[..., None] * (
        A[:, None, :2, 2] - mu[..., None] * (d @ A[:, :2, :2])
    )
    valid &= np.sum(slip * d, axis=-1) > 0.0
    slides = np.concatenate([-(mu * normal)[..., None] * d, normal[..., None]], axis=-1)
    impulses = np.concatenate([stick[:, None], slides, np.zeros((len(A), 1, 3))], axis=1)
    valid = np.concatenate([sticks[:, None], valid, b[:, 2, None] >= 0.0], axis=1)
    return impulses, valid


def _slip_angles(A: Array, b: Array, friction: Array) -> tuple[Array, np.ndarray]:
    """Angles φ (N, 4) of the final slip, and which of them are such.

    Friction along −d, d = (cos φ, sin φ), leaves no slip across d. From λ_n (N − µ a·d) = q and
    d⊥·(b_t + λ_n (a − µ T d)) = 0 follows, without λ_n, k₀ + Re(k₁ w + k₂ w²) = 0 with w = exp(iφ).
    That is a quartic in w, of which the roots of unit modulus count.
    """
    (txx, txy, ax), (_, tyy, ay), (_, _, N) = np.moveaxis(A, 0, -1)
    (x, y), q, mu = b.T[:2], -b[:, 2], friction
    k0 = mu / 2.0 * (ay * x - ax * y)
    k1 = N * y + q * ay + 1j * (N * x + q * ax)
    k2 = mu * (
        -(ax * y + ay * x) / 2.0 - q * txy + 1j * ((ay * y - ax * x) / 2.0 + q * (tyy - txx) / 2.0)
    )
    size = np.abs(k0) + np.abs(k1) + np.abs(k2)
    quartic = np.abs(k2) > 1e-15 * size
    companion = np.zeros((len(A), 4, 4), dtype=complex)
    companion[:, [1, 2, 3], [0, 1, 2]] = 1.0
    companion[quartic, 0] = -(
        np.stack([k1, 2.0 * k0, k1.conj(), k2.conj()], axis=1)[quartic] / k2[quartic, None]
    )
    angle = np.angle(np.linalg.eigvals(companion))
    # Without the term of the second order: cos(φ + arg k₁) = −k₀ / |k₁|.
    half = np.arccos(np.clip(-k0 / np.where(np.abs(k1) > 0.0, np.abs(k1), 1.0), -1.0, 1.0))[
        :, None
    ] * np.array([1, -1, 1, -1])
    angle = np.where(quartic[:, None], angle, half - np.angle(k1)[:, None])
    k0, k1, k2, size = (part[:, None] for part in (k0, k1, np.where(quartic, k2, 0.0), size))
    for _ in range(4):
        w = np.exp(1j * angle)
        value, slope = k0 + ((k1 + k2 * w) * w).real, -((k1 + 2.0 * k2 * w) * w).imag
        near = np.abs(slope) > 1e-12 * size
        angle = angle - np.where(near, np.clip(value / np.where(near, slope, 1.0), -0.1, 0.1), 0.0)
    return angle, np.asarray((np.abs(value) <= CLOSE * size) & (size > 0.0))


def _one_contact(A: Array, b: Array, mu: float) -> list[Array]:
    """All impulses (3,) of one contact, as `_candidates`, but none first."""
    impulses, valid = _candidates(A[None], b[None], np.array([mu]))
    order = [5, 0, 1, 2, 3, 4]
    return [impulses[0, k] for k in order if valid[0, k]]


def _solve(A: Array, b: Array) -> Array:
    """The smallest x with A x = b for a matrix that is positive semidefinite."""
    s, Q = np.linalg.eigh(A)
    kept = s > 1e-12 * s[-1]
    return np.asarray(Q[:, kept] @ ((Q[:, kept].T @ b) / s[kept]))


class _Problem:
    """The laws of several contacts as one equation R(λ) = 0 (Alart and Curnier)."""

    def __init__(self, A: Array, velocity: Array, mu: Array, b_n: Array):
        self.A, self.velocity, self.mu = A, velocity, mu
        self.free = np.column_stack([velocity[:, :2], b_n])
        self.speed = float(np.abs(self.free).max()) or 1.0
        mobility = np.array([np.trace(A[i : i + 3, i : i + 3]) for i in range(0, len(A), 3)])
        self.mass = 1.0 / np.where(mobility > 0.0, mobility, 1.0)

    def residual(self, impulse: Array) -> tuple[Array, Array]:
        """R (3m,) at impulses (m, 3) [N s], and its derivative (3m, 3m)."""
        m = len(impulse)
        v = self.free + (self.A @ impulse.ravel()).reshape(m, 3)
        R, D = impulse.copy(), np.eye(3 * m)
        for i in range(m):
            rho, rows = self.mass[i], slice(3 * i, 3 * i + 3)
            step = impulse[i] - rho * v[i]
            if step[2] <= 0.0:
                continue
            moved = D[rows] - rho * self.A[rows]
            R[i, 2], D[3 * i + 2] = rho * v[i, 2], D[3 * i + 2] - moved[2]
            radius, length = self.mu[i] * max(impulse[i, 2], 0.0), float(np.hypot(step[0], step[1]))
            along = step[:2] / (length or 1.0)
            if length <= radius:
                R[i, :2] = rho * v[i, :2]
                D[3 * i : 3 * i + 2] -= moved[:2]
            else:
                R[i, :2] -= radius * along
                across = (np.eye(2) - np.outer(along, along)) * (radius / length)
                D[3 * i : 3 * i + 2] -= across @ moved[:2]
                if radius > 0.0:
                    D[3 * i : 3 * i + 2, 3 * i + 2] -= self.mu[i] * along
        return R.ravel(), D

    def error(self, R: Array) -> float:
        """The size of a residual as a velocity, relative to those of the contacts."""
        return float(np.abs(R.reshape(-1, 3) / self.mass[:, None]).max()) / self.speed

    def rounding(self, impulse: Array) -> float:
        """What the rounding of impulses (m, 3) alone may contribute to `error`."""
        return (
            4.0
            * float(np.finfo(float).eps * (np.abs(impulse).max(axis=1) / self.mass).max())
            / self.speed
        )

    def newton(self, impulse: Array) -> Array:
        """Newton's method from impulses (m, 3), as far as it gets nearer; contacts that do not
        press take no impulse.
        """
        best, minimum = impulse, np.inf
        for _ in range(20):
            R, D = self.residual(impulse)
            error = self.error(R)
            if error < minimum:
                best, minimum = impulse, error
            if error < 1e-14 or not np.isfinite(error):
                break
            impulse = impulse - np.linalg.lstsq(D, R, rcond=1e-13)[0].reshape(-1, 3)
        pressing = (
            best[:, 2] > self.mass * (self.free + (self.A @ best.ravel()).reshape(-1, 3))[:, 2]
        )
        return np.where(pressing[:, None], best, 0.0)

    def sweep(self, impulse: Array, order: list[int]) -> Array:
        """Solve each contact exactly, the impulses of the others given."""
        impulse = impulse.copy()
        for i in order:
            rows = slice(3 * i, 3 * i + 3)
            local = self.A[rows, rows]
            b = self.free[i] + self.A[rows] @ impulse.ravel() - local @ impulse[i]
            solutions = list(_one_contact(local, b, float(self.mu[i])))
            if solutions:
                impulse[i] = min(solutions, key=lambda one: float(np.abs(one - impulse[i]).sum()))
        return impulse

    def search(self, starts: int) -> Iterator[Array]:
        """Impulses (m, 3) that solve the equation, or come nearest, from several starts."""
        m = len(self.mu)
        rng = np.random.default_rng(0)
        stick = -_solve(self.A, self.free.ravel()).reshape(m, 3)
        size = np.abs(stick).max()
        for k in range(starts):
            impulse = (
                size * np.column_stack([rng.normal(size=(m, 2)), np.ones(m)])
                if k > 1
                else stick * (k == 0)
            )
            order = rng.permutation(m).tolist() if k else list(range(m))
            for _ in range(30):
                polished = self.newton(impulse)
                if self.error(self.residual(polished)[0]) <= CONVERGED:
                    yield polished
                    break
                for _ in range(5):
                    impulse = self.sweep(impulse, order)

    def describe(self, impulse: Array) -> FrictionImpact:
        """The solution that impulses (m, 3) are."""
        change = (self.A @ impulse.ravel()).reshape(-1, 3)
        after = self.velocity + change
        energy = float(np.sum(impulse * (self.velocity + change / 2.0)))
        scale = float(np.sum(np.abs(impulse) * (np.abs(self.velocity) + np.abs(change))))
        slipping = np.hypot(after[:, 0], after[:, 1]) > CLOSE * self.speed
        state = tuple(
            "separates" if p[2] <= 0.0 else "slides" if slips else "sticks"
            for p, slips in zip(impulse, slipping, strict=True)
        )
        return FrictionImpact(
            impulse,
            after,
            state,
            energy,
            bool(energy > 1e-12 * scale),
            self.error(self.residual(impulse)[0]),
        )
