"""The joint-space inertia H in N postures and H⁻¹ B, from matrices or from momenta.

The momenta are those that H consists of.
"""

from typing import NamedTuple, TypeAlias

import numpy as np

from shockpc.core.spatial import Array


class CompositeInertia(NamedTuple):
    """The momenta that H consists of: H_ij = J_iᵀ F_j where velocity i also moves what j moves.

    On the diagonal the armature is added.

    With them the work for one posture grows with nv, and with its cube in the matrix, but each
    velocity costs a dozen calls.

    Attributes:
        J: (N, 6, nv) twist (ω, v at the common origin) that each unit joint velocity gives to the
            bodies behind it.
        F: (N, 6, nv) momentum of these bodies then, angular about the common origin first [kg m²,
            kg m; kg m, kg].
        armature: (nv,) reflected inertia of the joints [kg m², kg]; (N, nv) where it differs
            between postures.
        before: for each joint velocity the next one towards the base, −1 for none.
    """

    J: Array
    F: Array
    armature: Array
    before: tuple[int, ...]

    def with_rotors(self, coupling: Array) -> "CompositeInertia":
        """These inertias with the momenta c a of rotors about axes a of their joints.

        The links that carry the joints carry the rotors.

        H_ij gains c_j J_iᵀ (a_j, 0); on the diagonal that is c_j, which is no part of the joint's
        own inertia and is taken away.

        Args:
            coupling: (nv,) or (N, nv) c of each joint, zero of one that does not turn [kg m²].
        """
        if not coupling.any():
            return self
        F = self.F.copy()
        F[:, :3] += coupling[..., None, :] * self.J[:, :3]
        return self._replace(F=F, armature=self.armature - coupling)


Inertia: TypeAlias = Array | CompositeInertia
"""Matrices H (N, nv, nv), symmetric positive definite [kg, kg m, kg m²], or what they consist of.
"""


DEFINITE = 1e-14
"""Smallest eigenvalue of H, scaled to a diagonal of ±1, from which H is positive definite for sure
[1].
"""


def diagonal_of(inertia: Inertia) -> Array:
    """The diagonal (N, nv) of H."""
    if isinstance(inertia, CompositeInertia):
        return np.asarray(np.einsum("nij,nij->nj", inertia.J, inertia.F) + inertia.armature)
    return np.asarray(np.einsum("nii->ni", inertia))


def matrix_of(inertia: Inertia) -> Array:
    """H (N, nv, nv)."""
    if not isinstance(inertia, CompositeInertia):
        return inertia
    nv = len(inertia.before)
    carries = np.eye(nv, dtype=bool)
    for k, before in enumerate(inertia.before):
        if before >= 0:
            carries[:, k] |= carries[:, before]
    # H_ij = J_iᵀ F_j where i carries j, so i ≤ j; below the diagonal H_ji = H_ij.
    upper = np.where(carries, np.swapaxes(inertia.J, -1, -2) @ inertia.F, 0.0)
    lower = np.swapaxes(np.triu(upper, 1), -1, -2)
    armature = inertia.armature[..., None] * np.eye(nv)
    return np.asarray(upper + lower + armature)


def definite(inertia: Inertia) -> Array:
    """H (N, nv, nv), NaN in a posture in which it is not positive definite.

    Negative moments of inertia can make it indefinite.

    A velocity that moves nothing with inertia is left out of this: its diagonal entry is zero.
    """
    H = np.array(matrix_of(inertia))
    size = np.sqrt(np.abs(diagonal_of(inertia)))
    idle = size <= 1e-15 * size.max(axis=1, keepdims=True)
    scale = np.where(idle, 0.0, 1.0 / np.where(idle, 1.0, size))
    scaled = H * scale[:, :, None] * scale[:, None, :]
    scaled += idle[:, :, None] * np.eye(H.shape[1])
    smallest = np.linalg.eigvalsh(scaled)[:, 0]
    H[smallest < DEFINITE] = np.nan
    return H


def solve_inertia(inertia: Inertia, B: Array) -> Array:
    """H⁻¹ B (N, nv, k). Args: B (N, nv, k).

    Returns: NaN, or numbers without meaning, in a posture whose H is singular.
    """
    if isinstance(inertia, CompositeInertia):
        return _along_the_tree(inertia, B)
    try:
        return np.asarray(np.linalg.solve(inertia, B), dtype=float)
    except np.linalg.LinAlgError:
        if len(B) == 1:
            return np.full_like(B, np.nan)
        solutions = []
        for k in range(len(B)):
            posture = slice(k, k + 1)
            solutions.append(solve_inertia(inertia[posture], B[posture]))
        return np.concatenate(solutions)


def _along_the_tree(inertia: CompositeInertia, B: Array) -> Array:
    """H⁻¹ B by Gaussian elimination from the leaves to the base, and back.

    To eliminate velocity k takes H_ik H_kj / H_kk from H_ij. As H_ik = J_iᵀ F_k, this takes (F_k
    F_kᵀ / H_kk) J_j from F_j, and one matrix (6, 6) serves all velocities before k: what it takes
    from their inertia leaves the articulated one (Featherstone 2008, section 7.3).
    """
    # The posture comes last, so that every operation runs over contiguous numbers.
    n, nv, _ = B.shape
    J = inertia.J.transpose(2, 1, 0).copy()
    # Columns F_k, and those of B, which are eliminated with them.
    columns = np.empty((nv, 6 + B.shape[2], n))
    columns[:, :6] = inertia.F.transpose(2, 1, 0)
    columns[:, 6:] = B.transpose(1, 2, 0)
    pivot = np.einsum("kin,kin->kn", J, columns[:, :6]) + inertia.armature.reshape(-1, nv).T
    share = _eliminate(J, columns, pivot, inertia.before)

    # From the base: x_k = b_k / H_kk − (F_k / H_kk) · twist of what carries k
    X = columns[:, 6:]
    twists: list[Array] = []
    for k, before in enumerate(inertia.before):
        if before >= 0:
            X[k] -= np.einsum("ikn,in->kn", twists[before], share[k])
        twists.append(J[k][:, None] * X[k])
        if before >= 0:
            twists[k] += twists[before]
    return X.transpose(2, 0, 1).copy()


def _eliminate(J: Array, columns: Array, pivot: Array, all_before: tuple[int, ...]) -> Array:
    """F_k / H_kk (nv, 6, N) after the elimination of the velocities behind k, from the leaves.

    Args:
        J: (nv, 6, N) twists.
        columns: (nv, 6 + m, N) F_k and b_k; the latter become b_k / H_kk.
        pivot: (nv, N) the diagonal of H, which becomes H_kk.
        all_before: as `CompositeInertia.before`.
    """
    share = np.empty_like(J)
    behind: dict[int, Array] = {}  # of each velocity, what those behind it have taken
    for k, before in reversed(list(enumerate(all_before))):
        taken = behind.pop(k, None)
        if taken is not None:
            change = np.einsum("ijn,jn->in", taken, J[k])
            columns[k] -= change
            pivot[k] -= np.einsum("in,in->n", J[k], change[:6])
        np.divide(columns[k, :6], pivot[k], out=share[k])
        if before >= 0:
            passed = columns[k][:, None] * share[k]
            if taken is not None:
                passed += taken
            if before in behind:
                passed += behind[before]
            behind[before] = passed
        columns[k, 6:] /= pivot[k]
    return share
