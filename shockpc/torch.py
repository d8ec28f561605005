"""The shock of a batch of a simulator's states in PyTorch: on any device, in any floating type,
with gradients.
"""

try:
    import torch
except ModuleNotFoundError:
    raise ImportError(
        'shockpc.torch needs PyTorch, its extra "torch"; install it with: pip install torch'
    ) from None

from shockpc.core.batched import BatchedShock, batched_shock


def shock(
    M: torch.Tensor,
    J_c: torch.Tensor,
    J_p: torch.Tensor,
    v: torch.Tensor,
    restitution: float | torch.Tensor = 0.0,
    locked: torch.Tensor | None = None,
    contacts: torch.Tensor | None = None,
    v_in: torch.Tensor | None = None,
) -> BatchedShock:
    """The shock of p points of a robot in B states, each of which strikes the ground with c points.

    A state with NaN, or whose matrices are singular, has NaN, and does not change the others. A
    device is never waited for.

    Args:
        M: (B, nv, nv) joint-space inertia [kg, kg m, kg m²]. The simulator's armature is a part of
            it.
        J_c: (B, c, d, nv) Jacobians of the contact points along the d directions that the ground
            holds: 3 where they stick, 1, the normal, where they slide.
        J_p: (B, p, 3, nv) Jacobians of the points.
        v: (B, nv) velocity before the impact, in the coordinates of the inertia and the Jacobians
            [rad/s, m/s].
        restitution: e, a number or (B, c, 1) [1].
        locked: (nv,) bool, velocities that the impact does not change.
        contacts: (B, c) bool, which of them strike; all by default. Where none does, the shock is
            NaN without `v_in`, else 0.
        v_in: (B,) speed that normalises shock [m/s]; by default that of the fastest contact, along
            its d directions.

    Raises:
        ValueError: a tensor has another shape or type than stated. Tensors of numbers have the type
            of M.
    """
    return batched_shock(torch, M, J_c, J_p, v, restitution, locked, contacts, v_in)
