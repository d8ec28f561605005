"""The shock of many states from what a simulator has of each: its inertia and Jacobians, in whatever library holds its arrays."""

from typing import Any, NamedTuple


class BatchedShock(NamedTuple):
    """The impact of B states; arrays of the library that the inputs are of.

    Attributes:
        shock: (B, p) of the points, |Δv| over the speed of the fastest contact [1].
        impulse: (B, c, d) of the ground along the rows of the contacts [N s].
        pivot: (B,) minimum eigenvalue of the Delassus matrix, scaled to a unit diagonal: 1 for rows that do not affect one another,
            0 for rows that depend on one another. Where it is below the square root of the type's precision (1e-8 for 64 bits,
            3e-4 for 32), the numbers are not to be trusted.
    """

    shock: Any
    impulse: Any
    pivot: Any


def batched_shock(
    xp: Any,
    M: Any,
    J_c: Any,
    J_p: Any,
    v: Any,
    restitution: Any = 0.0,
    locked: Any = None,
    contacts: Any = None,
    v_in: Any = None,
) -> BatchedShock:
    """The impact of B states (Eq. 4).

    Args:
        xp: the library, numpy or torch.
        M: (B, nv, nv) joint-space inertia [kg, kg m, kg m²].
        J_c: (B, c, d, nv) Jacobians of c contact points along the d directions that the ground holds.
        J_p: (B, p, 3, nv) Jacobians of p points.
        v: (B, nv) velocity before the impact [rad/s, m/s].
        restitution: e, a number or (B, c, 1) [1].
        locked: (nv,) bool, velocities that the impact does not change.
        contacts: (B, c) bool, which of them strike; all by default. Where none does, the shock is NaN without `v_in`, else 0.
        v_in: (B,) speed that normalises shock [m/s]; by default that of the fastest contact, along its d directions.
    """
    B, c, d, nv = J_c.shape
    before = (J_c @ v[:, None, :, None])[..., 0]
    strikes = xp.ones_like(before) * (1.0 if contacts is None else contacts[..., None])
    free = xp.ones_like(v[0]) * (1.0 if locked is None else ~locked)
    on, eye = strikes.reshape(B, -1), xp.eye(max(nv, c * d), dtype=M.dtype, device=M.device)
    J, n = J_c.reshape(B, c * d, nv) * on[..., None] * free, c * d
    response = xp.linalg.solve(M * (free[:, None] * free) + eye[:nv, :nv] * (1.0 - free), J.mT)
    delassus = J @ response
    diagonal = xp.linalg.diagonal(delassus)
    scale = xp.where(diagonal > 0.0, diagonal, 1.0) ** -0.5
    scaled = delassus * scale[..., None] * scale[:, None] + eye[:n, :n] * (1.0 - on)[..., None]
    undone = ((1.0 + restitution) * strikes * before).reshape(B, n, 1)
    # The last digit on the diagonal keeps rows that depend on one another from a division by zero.
    step = xp.linalg.solve(scaled + xp.finfo(M.dtype).eps * eye[:n, :n], scale[..., None] * undone)
    impulse = -scale[..., None] * step
    jump = (J_p @ (response @ impulse)[:, None])[..., 0]
    speed = xp.amax(_length(xp, strikes * before), -1) if v_in is None else v_in
    return BatchedShock(_length(xp, jump) / speed[:, None], impulse.reshape(B, c, d), xp.linalg.eigvalsh(scaled)[:, 0])


def _length(xp: Any, vectors: Any) -> Any:
    """Lengths of vectors (..., n), whose gradient is zero where they are."""
    square = (vectors * vectors).sum(-1)
    return xp.where(square > 0.0, xp.where(square > 0.0, square, 1.0) ** 0.5, 0.0)
