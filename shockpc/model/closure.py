"""Loops: two bodies held together at a point or a frame, as rows, and the posture in which they meet.

The rows K Δq̇ = 0 are stacked under the contacts (shock paper, Section 3.1.1); restitution never applies to them. Redundant rows,
such as a planar loop closed by a point in space, are normal: the solver counts the rank.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array
from shockpc.errors import SceneError
from shockpc.model import CHECKED
from shockpc.model.contact import unit_directions
from shockpc.model.dynamics import Dynamics
from shockpc.model.rows import Block
from shockpc.robot.robot import Loop, Robot

__all__ = ["Closure", "Place", "all_loops", "closure_block", "closure_gap", "loop_of"]


@dataclass(frozen=True, kw_only=True)
class Place:
    """One end of a closure.

    Attributes:
        frame: link, joint or site; it may be fixed to the world.
        offset: from that frame's origin, in its axes [m].
    """

    __pydantic_config__ = CHECKED

    frame: str
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True, kw_only=True)
class Closure:
    """A closed loop as a scene states it.

    Attributes:
        a: one end.
        b: the other end.
        kind: "point" holds two points together, "frame" holds their orientations too.
        directions: axes of frame a, or vectors in them, along which the points are held.
    """

    __pydantic_config__ = CHECKED

    a: Place
    b: Place
    kind: Literal["point", "frame"] = "point"
    directions: tuple[Literal["x", "y", "z"] | tuple[float, float, float], ...] = ("x", "y", "z")


def all_loops(robot: Robot, closures: Sequence[Closure]) -> tuple[Loop, ...]:
    """The loops of the robot's file, then those of a scene.

    Raises:
        UnknownName: the robot has no such frame.
        SceneError: one makes no sense, or two tie the same points: where those are only almost the same, rounding would decide
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
        turns=closure.kind == "frame",
    )


def closure_block(loop: Loop) -> Block:
    """The rows of a loop: the two ends may not separate along the loop's axes, which turn with its first body.

    Both impulses act at the second end: along an axis that is left free the first end may be elsewhere, and opposite impulses at
    two places would turn the robot. It is also what makes the rows the derivative of `closure_gap`.
    """
    (a, b), frame = loop.bodies, loop.rotations[0]
    return Block(
        name=f'closure "{loop.name}"',
        kind="closure",
        body=a,
        carrier=b,
        point=loop.points[1],
        forces=loop.axes @ frame.T,
        moments=frame.T if loop.turns else np.zeros((0, 3)),
        other=b,
        axes_body=a,
    )


def closure_gap(state: Dynamics, loop: Loop) -> Array:
    """How far the ends of a loop are apart (N, n): along its axes [m], then about them [rad] if it holds orientations."""
    (a, b), (p_a, p_b) = loop.bodies, loop.points
    frame = _orientation(state, a, loop.rotations[0])
    apart = _position(state, a, p_a) - _position(state, b, p_b)
    gap = np.einsum("nij,ki,nj->nk", np.swapaxes(frame, -1, -2), loop.axes, apart)
    if not loop.turns:
        return np.asarray(gap)
    other = _orientation(state, b, loop.rotations[1])
    turned = np.stack([pin.log3(R_b.T @ R_a) for R_a, R_b in zip(frame, other, strict=True)])
    return np.concatenate([gap, turned], axis=1)


def _orientation(state: Dynamics, body: int, rotation: Array) -> Array:
    """Orientation (N, 3, 3) of a frame on a body, or on the world."""
    n = len(state.J)
    return np.broadcast_to(rotation, (n, 3, 3)) if body < 0 else state.rotation[:, body] @ rotation


def _position(state: Dynamics, body: int, point: Array) -> Array:
    """Position (N, 3) of a point on a body, or on the world, from the base [m]."""
    if body < 0:
        return point - state.origin
    return np.asarray(state.position[:, body] + state.rotation[:, body] @ point)
