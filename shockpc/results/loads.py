"""Impulses through the joints: what their bearings and gearboxes have to carry."""

from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.exact.balls import entries, nearest
from shockpc.exact.solution import ExactImpact
from shockpc.results.solved import Solved

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


def joint_loads(of: Solved) -> tuple[JointLoad, ...]:
    """Impulses through the joints between bodies.

    They are those of the scene's own strike. Where rows depend on one another (redundant contacts, a planar loop closed in space)
    they are those of the contact impulses of least norm.
    """
    chosen = list(enumerate(of.robot.joints))[of.robot.free_base :]

    def read(impact: ExactImpact) -> Array:
        loads = []
        for i, joint in chosen:
            node = impact.mechanism.tree.carrier[i]
            own = impact.joint_loads[node]
            moment, force = entries(impact.mechanism.poses[node].rotation) @ entries(own).reshape(2, 3, 1)
            drive = impact.mechanism.tree.nodes[node].S.transpose() * own
            loads.append([*force[:, 0], *moment[:, 0], drive[0, 0] if joint.axis is not None else own[0, 0]])
        found = np.array(loads, dtype=object).reshape(-1, 7)
        return nearest(found, np.abs(found[:, :6].astype(float)).max(initial=0.0))

    return tuple(
        JointLoad(joint.name, load[:3], load[3:6], None if joint.axis is None else load[6].item())
        for (_, joint), load in zip(chosen, of.read(read), strict=True)
    )
