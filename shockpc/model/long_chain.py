"""Inertia and Jacobian of mechanisms with hundreds of joints, joint by joint.

Pinocchio's own workspace takes time and memory with the cube of the depth of a tree (20 s for 500 joints in a row), so beyond some
size the recursion over composite bodies (Featherstone 2008, Section 6.2) is written out here, with Pinocchio's joints.
"""

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array

__all__ = ["LONG", "evaluate"]

LONG = 150
"""Joints from which this is quicker than preparing Pinocchio's workspace."""


def evaluate(model: pin.Model, q: Array) -> tuple[Array, Array, Array]:
    """Joint-space inertia without armature, Jacobian and placements in one posture.

    Args:
        model: of any joints.
        q: (nq,) configuration.

    Returns: H (nv, nv); J (6, nv) twists at the world's origin, linear part first as Pinocchio has it; placements (njoints, 4, 4)
    of the joint frames.
    """
    placed = [pin.SE3.Identity()]
    J = np.zeros((6, model.nv))
    composite = np.zeros((model.njoints, 6, 6))
    for i in range(1, model.njoints):
        joint = model.joints[i]
        data = joint.createData()
        joint.calc(data, q)
        placed.append(placed[model.parents[i]] * model.jointPlacements[i] * data.M)
        J[:, joint.idx_v : joint.idx_v + joint.nv] = placed[i].action @ data.S.reshape(6, joint.nv)
        composite[i] = placed[i].act(model.inertias[i]).matrix()
    moves = np.zeros((model.njoints, model.nv), dtype=bool)
    for i in range(1, model.njoints):
        joint = model.joints[i]
        moves[i] = moves[model.parents[i]]
        moves[i, joint.idx_v : joint.idx_v + joint.nv] = True
    H = np.zeros((model.nv, model.nv))
    for i in range(model.njoints - 1, 0, -1):
        joint = model.joints[i]
        own = slice(joint.idx_v, joint.idx_v + joint.nv)
        # The joints behind have given their part already; what moves this body is before it and itself.
        H[moves[i], own] = J[:, moves[i]].T @ (composite[i] @ J[:, own])
        H[own, moves[i]] = H[moves[i], own].T
        composite[model.parents[i]] += composite[i]
    return H, J, np.stack([placement.homogeneous for placement in placed])
