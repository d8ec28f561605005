"""Impulses through the joints, and the energy that an impact takes: balances of momentum and of power."""

import numpy as np

from shockpc.core.spatial import Array
from shockpc.core.tree import Tree

__all__ = ["energy_lost", "joint_impulses", "kinetic_energy"]


def joint_impulses(tree: Tree, jump: Array, wrench: Array) -> Array:
    """Impulse that each body receives through its joint, leaf to root: F_i = I_i ΔV_i − f_i + Σ_children F_child.

    The one of a free base is what is left over, and has to be zero.

    Args:
        tree: bodies and joints of one posture.
        jump: (nb, 6) jump of every body (Δω, Δv at its centre of mass), world axes.
        wrench: (nb, 6) impulse of contacts and closures on every body (moment about the common origin, force).

    Returns: (nb, 6) moment about the body's joint [N m s] and force [N s] on the body from its parent, world axes.
    """
    force = tree.mass[:, None] * jump[:, 3:]
    moment = np.einsum("bij,bj->bi", tree.inertia, jump[:, :3]) + np.cross(tree.com, force)
    through = np.concatenate([moment, force], axis=1) - wrench
    for i in range(len(tree.parent) - 1, -1, -1):
        if tree.parent[i] >= 0:
            through[tree.parent[i]] += through[i]
    through[:, :3] -= np.cross(tree.joint, through[:, 3:])
    return through


def energy_lost(impulse: Array, b: Array, restitution: Array) -> float:
    """Kinetic energy that the impulses take, −½ λᵀ (v⁻ + v⁺) [J]: with v⁺ = −e v⁻ = v⁻ − b that is −½ λᵀ b (1 − e) / (1 + e).

    Args:
        impulse: (nc,) along each row [N s].
        b: (nc,) speed undone along each row [m/s].
        restitution: (nc,) e of each row [1].
    """
    return float(-0.5 * impulse @ (b * (1.0 - restitution) / (1.0 + restitution)))


def kinetic_energy(tree: Tree, twist: Array, joint_rates: Array) -> float:
    """½ Σ (m |v|² + ωᵀ I ω) + ½ q̇ᵀ diag(a) q̇ [J], for twists (nb, 6) written at the centres of mass."""
    turning = np.einsum("bi,bij,bj->", twist[:, :3], tree.inertia, twist[:, :3])
    drives = float(joint_rates @ (tree.armature * joint_rates))
    return float(0.5 * (turning + tree.mass @ np.sum(twist[:, 3:] ** 2, axis=1) + drives))
