"""Impulses through the joints: what their bearings and gearboxes have to carry."""

from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.exact.balls import nearest
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
    chosen = robot.joints[robot.free_base :]
    bodies, first = slice(int(robot.free_base), None), [joint.v.start for joint in chosen]

    def loads(impact: ExactImpact) -> tuple[Array, Array, Array]:
        own = impact.joint_loads[bodies]
        force = own[:, 3:]
        moment = own[:, :3] - np.cross(impact.joint_origins[bodies], force)
        # The power of the wrench in a unit velocity of the joint; in the first one where it has several.
        along = np.sum(impact.state.J[0, :, first].T * own.T, axis=0)
        size = float(np.abs(np.concatenate([force, moment]).astype(float)).max(initial=0.0))
        return nearest(force, size), nearest(moment, size), nearest(along, size)

    forces, moments, along = proof.enclosure.read(loads)
    return tuple(
        JointLoad(joint.name, force, moment, float(part) if joint.axis is not None else None)
        for joint, force, moment, part in zip(chosen, forces, moments, along, strict=True)
    )
