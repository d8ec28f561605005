"""Projecting a posture onto its closures: which joints have to move, and how far, for every loop to meet."""

from typing import NamedTuple

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array, Plane
from shockpc.errors import SceneError
from shockpc.model.closure import closure_block, closure_gap
from shockpc.model.couplings import Loop
from shockpc.model.dynamics import dynamics
from shockpc.model.freedom import freedom
from shockpc.model.robot import Robot
from shockpc.model.rows import row_jacobian

__all__ = ["Assembly", "assemble"]

CLOSED = 1e-12
"""A loop is closed when its gap is below this share of the robot's size: what rounding leaves."""


class Assembly(NamedTuple):
    """A posture in which every loop meets.

    Attributes:
        q: (nq,) configuration.
        gap: largest gap before [m, rad].
        moved: (joint, by how much) of each joint that had to move [rad, m].
    """

    q: Array
    gap: float
    moved: tuple[tuple[str, float], ...]


def assemble(robot: Robot, q: Array, loops: tuple[Loop, ...], plane: Plane, held: np.ndarray) -> Assembly:
    """Close every loop by Gauss–Newton with steps of least norm, K G Δy = −gap.

    Args:
        robot: its base stays where it is; joints that follow others keep following.
        q: (nq,) configuration to start from.
        loops: to be closed.
        plane: of the study.
        held: (nv,) joint velocities that may not move.

    Raises:
        SceneError: the loops cannot be closed; the text gives the gap that is left, in millimetres.
    """
    start = q
    size = max(float(np.ptp(dynamics(robot, q[None]).position[0], axis=0).max()), 1e-3)
    first = None
    for _ in range(50):
        state = dynamics(robot, q[None])
        gap = np.concatenate([closure_gap(state, loop)[0] for loop in loops])
        first = float(np.abs(gap).max()) if first is None else first
        if np.abs(gap).max() <= CLOSED * size:
            return Assembly(q, first, _moved(robot, start, q))
        if held.all():
            break
        G = freedom(robot, "fixed", plane, state.rotation[:, 0], held)
        K = np.concatenate([row_jacobian(state, closure_block(state, loop).W)[0] for loop in loops])
        columns = K if G is None else K @ G[0]
        dy = np.linalg.lstsq(columns, -gap, rcond=1e-10)[0]
        # A long step leaves the range in which a linear model of the linkage means anything.
        dy *= min(1.0, 0.5 / max(float(np.abs(dy).max()), 1e-300))
        q = pin.integrate(robot.model, q, dy if G is None else G[0] @ dy)
    worst = max(loops, key=lambda loop: float(np.abs(closure_gap(state, loop)).max()))
    left = 1e3 * float(np.linalg.norm(closure_gap(state, worst)[0, : len(worst.axes)]))
    free = [robot.model.names[b.joint] for b in robot.bodies if b.name and not held[robot.model.joints[b.joint].idx_v]]
    listed = ", ".join(f'"{name}"' for name in free if name in robot.joints) or "none"
    raise SceneError(
        f'closure "{worst.name}" cannot be closed: its ends stay {left:.3g} mm apart; joints that may move: {listed}; '
        "let others move with --assemble, or start from joint values nearer to the closed loop"
    )


def _moved(robot: Robot, before: Array, after: Array) -> tuple[tuple[str, float], ...]:
    """The joints that moved by more than rounding."""
    step = pin.difference(robot.model, before, after)
    moved = []
    for body in robot.bodies:
        joint = robot.model.joints[body.joint]
        by = float(np.linalg.norm(step[joint.idx_v : joint.idx_v + joint.nv]))
        if by > 1e-9:
            moved.append((robot.model.names[body.joint], by))
    return tuple(moved)
