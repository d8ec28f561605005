"""Loops: two bodies held together at a point or a frame, as rows, and the posture in which they meet.

The rows K Δq̇ = 0 are stacked under the contacts (shock paper, Section 3.1.1); restitution never applies to them. Redundant rows,
such as a planar loop closed by a point in space, are normal: the solver counts the rank.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array, Plane
from shockpc.errors import SceneError
from shockpc.model import Record
from shockpc.model.columns import free_columns
from shockpc.model.contact import unit_directions
from shockpc.model.dynamics import Dynamics, dynamics
from shockpc.model.rows import Block, point_at, row_jacobian
from shockpc.robot.record import Loop, Robot

__all__ = ["Assembly", "Closure", "Place", "all_loops", "assemble", "closure_block", "closure_gap", "loop_of"]

CLOSED = 1e-12
"""A loop is closed when its gap is below this share of the robot's size: what rounding leaves."""


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Place(Record):
    """One end of a closure.

    Attributes:
        frame: link, joint or site; it may be fixed to the world.
        offset: from that frame's origin, in its axes [m].
    """

    frame: str
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Closure(Record):
    """A closed loop as a scene states it.

    Attributes:
        a: one end.
        b: the other end.
        kind: "point" holds two points together, "frame" holds their orientations too.
        directions: axes of frame a, or vectors in them, along which the points are held.
    """

    a: Place
    b: Place
    kind: Literal["point", "frame"] = "point"
    directions: tuple[Literal["x", "y", "z"] | tuple[float, float, float], ...] = ("x", "y", "z")


def all_loops(robot: Robot, closures: Sequence[Closure]) -> tuple[Loop, ...]:
    """The loops of the robot's file, then those of a scene.

    Raises:
        UnknownName: the robot has no such frame.
        SceneError: one makes no sense, or two tie the same points: where those are only almost the same, rounding would determine
            what they hold.
    """
    loops = (*robot.loops, *(loop_of(robot, closure) for closure in closures))
    for k, loop in enumerate(loops):
        for other in loops[:k]:
            ends = [dict(zip(one.bodies, one.points, strict=True)) for one in (loop, other)]
            if ends[0].keys() == ends[1].keys() and all(np.linalg.norm(p - ends[1][body]) <= 1e-9 for body, p in ends[0].items()):
                raise SceneError(
                    f'closures "{other.name}" and "{loop.name}" tie the same points of the same bodies, so they are one closure; '
                    "leave one of them out, and let the other hold all that both should"
                )
    return loops


def loop_of(robot: Robot, closure: Closure) -> Loop:
    """The loop that a closure of a scene means.

    Raises:
        UnknownName: the robot has no such frame.
        SceneError: both ends are on one body, or a direction has no length.
    """
    a, b = robot.frame(closure.a.frame), robot.frame(closure.b.frame)
    name = f"{closure.a.frame}–{closure.b.frame}"
    if a.body == b.body:
        shared = f'body "{robot.bodies[a.body].name}"' if a.body >= 0 else "the world"
        raise SceneError(f'closure "{name}" holds {shared} to itself, which closes no loop; name frames on two bodies')
    return Loop(
        name=name,
        bodies=(a.body, b.body),
        points=(a.offset + a.rotation @ np.asarray(closure.a.offset), b.offset + b.rotation @ np.asarray(closure.b.offset)),
        rotations=(a.rotation, b.rotation),
        axes=unit_directions(f'closure "{name}"', closure.directions),
        holds_orientation=closure.kind == "frame",
    )


def closure_block(loop: Loop) -> Block:
    """The rows of a loop: the two ends may not separate along the loop's axes, which turn with its first body.

    Both impulses act at the second end: along an axis that is left free the first end may be elsewhere, and opposite impulses at
    two places would turn the robot. It is also what makes the rows the derivative of `closure_gap`.
    """
    (a, b), frame = loop.bodies, loop.rotations[0]
    return Block(
        kind="closure",
        frame=loop.name,
        body=b,
        point=loop.points[1],
        forces=loop.axes @ frame.T,
        moments=frame.T if loop.holds_orientation else np.zeros((0, 3)),
        other=a,
        axes_body=a,
    )


def closure_gap(state: Dynamics, loop: Loop) -> Array:
    """How far the second end of a loop is from the first (N, n): along its axes [m], then about them [rad] if it holds these."""
    (a, b), (p_a, p_b) = loop.bodies, loop.points
    frame = _orientation(state, a, loop.rotations[0])
    apart = point_at(state, b, p_b) - point_at(state, a, p_a)
    gap = np.einsum("nij,ki,nj->nk", np.swapaxes(frame, -1, -2), loop.axes, apart)
    if not loop.holds_orientation:
        return np.asarray(gap)
    other = _orientation(state, b, loop.rotations[1])
    turned = np.stack([pin.log3(R_a.T @ R_b) for R_a, R_b in zip(frame, other, strict=True)])
    return np.concatenate([gap, turned], axis=1)


def _orientation(state: Dynamics, body: int, rotation: Array) -> Array:
    """Orientation (N, 3, 3) of a frame on a body, or on the world."""
    n = len(state.J)
    return np.broadcast_to(rotation, (n, 3, 3)) if body < 0 else state.rotation[:, body] @ rotation


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
    first, turn = (max(_apart(before, loop)[k] for loop in loops) for k in (0, 1))
    size = max(float(np.ptp(before.position[0], axis=0).max()), 1e-3)
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
    left, turned = _apart(state, worst)
    angle = f" and {np.degrees(turned):.3g} deg turned" if worst.holds_orientation else ""
    listed = ", ".join(f'"{name}"' for name in _movable(robot, held)) or "none"
    raise SceneError(
        f'closure "{worst.name}" cannot be closed: its ends stay {1e3 * left:.3g} mm apart{angle}; '
        f"joints that may move: {listed}; let others move with --assemble, or start from joint values nearer to the closed loop"
    )


def _apart(state: Dynamics, loop: Loop) -> tuple[float, float]:
    """Distance [m] and angle [rad] between the ends of a loop."""
    apart, turned = np.split(closure_gap(state, loop)[0], [len(loop.axes)])
    return float(np.linalg.norm(apart)), float(np.linalg.norm(turned))


def _movable(robot: Robot, held: np.ndarray) -> list[str]:
    """The joints that may move by themselves: neither held nor following another."""
    followers = {mimic.joint for mimic in robot.mimics}
    return [n for n in robot.joint_names if n not in followers and not held[robot.joint(n).v].any()]


def _moved(robot: Robot, before: Array, after: Array) -> tuple[tuple[str, float, str], ...]:
    """The joints that moved by more than rounding, with sign and unit."""
    step = pin.difference(robot.model, before, after)
    parts = ((joint, step[joint.v]) for joint in map(robot.joint, robot.joint_names))
    moved = [(joint, float(part[0]) if len(part) == 1 else float(np.linalg.norm(part))) for joint, part in parts]
    return tuple((joint.name, by, joint.unit) for joint, by in moved if abs(by) > 1e-9)
