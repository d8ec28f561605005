"""The shock of a batch of a simulator's states in PyTorch.

It is computed on any device, in any floating type, with gradients.
"""

try:
    import torch
except ModuleNotFoundError:
    raise ImportError(
        'shockpc.torch needs the package "torch"; install it with: pip install torch'
    ) from None

from shockpc.core import batched
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
    device is never waited for. Tensors of 16 bits are computed with in 32. The impulse,
    λ = −(J_c M⁻¹ J_cᵀ)⁻¹ (1 + e) J_c v, does not depend on the time step of the simulation.

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
        contacts: (B, c) bool, which of them are held: feet that strike, and feet that stand
            already, whose velocity is zero; all by default. Where none is, the shock is NaN without
            `v_in`, else 0.
        v_in: (B,) speed that normalises shock [m/s]; by default that of the fastest contact, along
            its d directions.

    Raises:
        ValueError: a tensor has another shape or type than stated. Tensors of numbers have the type
            of M.
    """
    return batched_shock(torch, M, J_c, J_p, v, restitution, locked, contacts, v_in)


def effective_mass(
    M: torch.Tensor, J_c: torch.Tensor, locked: torch.Tensor | None = None
) -> torch.Tensor:
    """Effective mass (B, c) of each contact point alone along the last of its directions [kg].

    It is the mass that the ground meets there: m = 1 / (J M⁻¹ Jᵀ) for the normal alone, which
    slides; the entry of the normal in (J M⁻¹ Jᵀ)⁻¹ for three directions, which stick (Khatib 1995).

    Args: as of `shock`; of the d directions the normal comes last.
    """
    masses: torch.Tensor = batched.effective_mass(torch, M, J_c, locked)
    return masses


def mitigation(
    M: torch.Tensor, J_c: torch.Tensor, base: int = 6, locked: torch.Tensor | None = None
) -> torch.Tensor:
    """Impact mitigation factor (B, c) of each contact point alone [1].

    It is the share of the mobility of the point that is due to the joints: 0 for a rigid robot, 1
    where the joints take all of the impact (Wensing et al., T-RO 2017, Eq. 8).

    Args:
        M: (B, nv, nv) joint-space inertia.
        J_c: (B, c, 3, nv) Jacobians of the contact points.
        base: how many of the velocities are those of the free base, which come first.
        locked: (nv,) bool, velocities that the impact does not change.
    """
    factors: torch.Tensor = batched.mitigation(torch, M, J_c, base, locked)
    return factors
