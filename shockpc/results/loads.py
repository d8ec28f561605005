"""Impulses through the joints: what their bearings and gearboxes have to carry."""

from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.exact.balls import nearest
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
    chosen, bodies = of.robot.joints[of.robot.free_base :], slice(int(of.robot.free_base), None)

    def read(impact: ExactImpact) -> Array:
        own = impact.joint_loads[bodies]
        moment = own[:, :3] - np.cross(impact.joint_origins[bodies], own[:, 3:])
        # The power of the wrench in a unit velocity of the joint; in the first one where it has several.
        along = np.sum(impact.state.J[0][:, [joint.v.start for joint in chosen]].T * own, axis=1)
        size = np.abs(np.concatenate([own[:, 3:], moment]).astype(float)).max(initial=0.0)
        return nearest(np.concatenate([own[:, 3:], moment, along[:, None]], axis=1), size)

    return tuple(
        JointLoad(joint.name, load[:3], load[3:6], None if joint.axis is None else load[6].item())
        for joint, load in zip(chosen, of.read(read), strict=True)
    )
