"""Projecting a posture onto its closures: which joints have to move, and how far, for every loop to meet."""

from typing import NamedTuple

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array, Plane
from shockpc.errors import SceneError
from shockpc.model.closure import closure_block, closure_gap
from shockpc.model.columns import free_columns
from shockpc.model.dynamics import dynamics
from shockpc.model.rows import row_jacobian
from shockpc.robot.robot import Loop, Robot

__all__ = ["Assembly", "assemble"]

CLOSED = 1e-12
"""A loop is closed when its gap is below this share of the robot's size: what rounding leaves."""


class Assembly(NamedTuple):
    """A posture in which every loop meets.

    Attributes:
        q: (nq,) configuration.
        gap: largest distance between two ends before [m].
        turn: largest angle between two ends before, of closures that hold orientations [rad].
        moved: (joint, by how much, unit) of each joint that had to move; a ball joint by its angle.
    """

    q: Array
    gap: float
    turn: float
    moved: tuple[tuple[str, float, str], ...]


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
    start, before = q, dynamics(robot, q[None])
    gaps = [(closure_gap(before, loop)[0, : len(loop.axes)], closure_gap(before, loop)[0, len(loop.axes) :]) for loop in loops]
    first = max(float(np.linalg.norm(apart)) for apart, _ in gaps)
    turn = max(float(np.linalg.norm(turned)) for _, turned in gaps)
    size = max(float(np.ptp(dynamics(robot, q[None]).position[0], axis=0).max()), 1e-3)
    for _ in range(50):
        state = dynamics(robot, q[None])
        gap = np.concatenate([closure_gap(state, loop)[0] for loop in loops])
        if np.abs(gap).max() <= CLOSED * size:
            return Assembly(q, first, turn, _moved(robot, start, q))
        if not _movable(robot, held):
            break
        G = free_columns(robot, "fixed", plane, state.rotation[:, 0], held)
        K = row_jacobian(state, [closure_block(loop) for loop in loops])[0]
        columns = K if G is None else K @ G[0]
        dy = np.linalg.lstsq(columns, -gap, rcond=1e-10)[0]
        # A long step leaves the range in which a linear model of the linkage means anything.
        dy *= min(1.0, 0.5 / max(float(np.abs(dy).max()), 1e-300))
        q = pin.integrate(robot.model, q, dy if G is None else G[0] @ dy)
    state = dynamics(robot, q[None])
    worst = max(loops, key=lambda loop: float(np.abs(closure_gap(state, loop)).max()))
    left, turned = np.split(closure_gap(state, worst)[0], [len(worst.axes)])
    angle = f" and {np.degrees(np.linalg.norm(turned)):.3g} deg turned" if turned.size else ""
    listed = ", ".join(f'"{name}"' for name in _movable(robot, held)) or "none"
    raise SceneError(
        f'closure "{worst.name}" cannot be closed: its ends stay {1e3 * float(np.linalg.norm(left)):.3g} mm apart{angle}; '
        f"joints that may move: {listed}; let others move with --assemble, or start from joint values nearer to the closed loop"
    )


def _movable(robot: Robot, held: np.ndarray) -> list[str]:
    """The joints that may move by themselves: neither held nor following another."""
    followers = {mimic.joint for mimic in robot.mimics}
    return [n for n in robot.joint_names if n not in followers and not held[robot.joint(n).v].any()]


def _moved(robot: Robot, before: Array, after: Array) -> tuple[tuple[str, float, str], ...]:
    """The joints that moved by more than rounding, with sign and unit."""
    step = pin.difference(robot.model, before, after)
    moved = []
    for name in robot.joint_names:
        joint = robot.joint(name)
        part = step[joint.v]
        by = float(part[0]) if len(part) == 1 else float(np.linalg.norm(part))
        if abs(by) > 1e-9:
            moved.append((name, by, joint.unit))
    return tuple(moved)
