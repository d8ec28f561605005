"""Impulses through the joints, and the energy that the impact takes."""

import numpy as np

from shockpc.core.loads import energy_lost, joint_impulses, kinetic_energy
from shockpc.core.spatial import velocity_at
from shockpc.core.tree import Tree
from shockpc.model.dynamics import Dynamics
from shockpc.model.equation import Solution
from shockpc.model.motion import Motion, twists_before
from shockpc.model.rows import Rows
from shockpc.result import JointLoad
from shockpc.robot.robot import Robot

__all__ = ["energy", "joint_loads"]


def joint_loads(robot: Robot, state: Dynamics, bodies: Tree, rows: Rows, solution: Solution) -> tuple[JointLoad, ...]:
    """Impulse through every joint between bodies, for the scene's strike.

    Where rows repeat one another (redundant contacts, a planar loop closed in space) the loads are those of the contact impulses
    of least norm.

    Args:
        robot: the robot.
        state: first posture.
        bodies: the same as free bodies and joints.
        rows: what is held.
        solution: the strike's in the last column.
    """
    rotation = state.rotation[0]
    com = np.stack([body.com for body in robot.bodies])
    jump = solution.jumps[0, :, :, -1]
    v_com = velocity_at(jump[:, :3], jump[:, 3:], com)
    world = np.concatenate([(rotation @ jump[:, :3, None])[..., 0], (rotation @ v_com[..., None])[..., 0]], axis=1)
    wrench = np.einsum("c,cbk->bk", solution.impact.impulse[0, :, -1], rows.W[0])
    through = joint_impulses(bodies, world, wrench)
    loads = []
    for i, body in enumerate(robot.bodies):
        name = robot.model.names[body.joint]
        if name not in robot.joint_names:
            continue
        joint = robot.model.joints[body.joint]
        along = float(bodies.S[i, :, joint.idx_v] @ through[i]) if joint.nv == 1 else None
        loads.append(JointLoad(name, through[i, 3:], through[i, :3], along))
    return tuple(loads)


def energy(
    robot: Robot, state: Dynamics, bodies: Tree, rows: Rows, solution: Solution, before: Motion, floating: bool
) -> tuple[float, float | None]:
    """Kinetic energy that the impact takes [J], and its share of what there was.

    Args:
        robot: the robot.
        state: first posture.
        bodies: the same as free bodies and joints.
        rows: what is held.
        solution: the strike's in the last column.
        before: how the robot moved.
        floating: whether `before` says how every body moved; not so on a fixed base, or with feet that stand.
    """
    lost = energy_lost(solution.impact.impulse[0, :, -1], rows.b[0, :, -1], rows.restitution)
    if not floating:
        return lost, None
    twist = twists_before(state, before)[0]
    v_com = velocity_at(twist[:, :3], twist[:, 3:], bodies.com)
    had = kinetic_energy(bodies, np.concatenate([twist[:, :3], v_com], axis=1), before.joint_rates)
    return lost, lost / had if had > 0.0 else None
