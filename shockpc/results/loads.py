"""Impulses through the joints: what their bearings and gearboxes have to carry."""

from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.exact.balls import entries, nearest
from shockpc.exact.proof import Proof
from shockpc.exact.solution import ExactImpact
from shockpc.landing import Landing

__all__ = ["JointLoad", "joint_loads"]


class JointLoad(NamedTuple):
    """Impulse that a body receives through its joint.

    Attributes:
        joint: its name.
        force: (3,) on the body from its parent, world axes [N s].
        moment: (3,) about the joint's origin, world axes [N m s].
        along: part of the moment (of the force, if prismatic) along the joint's axis: what the drive carries [N m s, N s]; None
            for a joint of more than one axis.
    """

    joint: str
    force: Array
    moment: Array
    along: float | None


def joint_loads(landing: Landing, proof: Proof) -> tuple[JointLoad, ...]:
    """Impulse through every joint between bodies, for the scene's own strike.

    Where rows depend on one another (redundant contacts, a planar loop closed in space) the loads are those of the contact impulses
    of least norm.
    """
    robot = landing.robot
    chosen = [(i, joint) for i, joint in enumerate(robot.joints) if not (robot.free_base and i == 0)]

    def loads(impact: ExactImpact) -> tuple[Array, Array, Array]:
        forces, moments, along = [], [], []
        for i, joint in chosen:
            node = impact.mechanism.tree.carrier[i]
            own = impact.joint_loads[node]
            R = impact.mechanism.poses[node].rotation
            wrench = entries(own)[:, 0]
            turned = entries(R)
            moments.append(turned @ wrench[:3])
            forces.append(turned @ wrench[3:])
            S = impact.mechanism.tree.nodes[node].S
            along.append((S.transpose() * own)[0, 0] if joint.axis is not None else own[0, 0])
        force, moment = (np.array(part, dtype=object).reshape(-1, 3) for part in (forces, moments))
        size = float(np.abs(np.concatenate([force, moment]).astype(float)).max(initial=0.0))
        return nearest(force, size), nearest(moment, size), nearest(np.array(along, dtype=object), size)

    forces, moments, along = proof.enclosure.read(loads)
    return tuple(
        JointLoad(joint.name, force, moment, float(part) if joint.axis is not None else None)
        for (_, joint), force, moment, part in zip(chosen, forces, moments, along, strict=True)
    )
