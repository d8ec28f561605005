"""Inertia and rows in any posture, with as little around Pinocchio's own work as Python allows.

For one posture the product's way costs more than the solution: it is made for many. The rivals get this one.
"""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from shockpc.bench.system import System, loops_in
from shockpc.core.spatial import Array
from shockpc.robot.robot import Robot

__all__ = ["assembler"]

NONE = np.zeros((0, 3))


class _Push(NamedTuple):
    """Rows that act on one body, each written where it stays the same as the robot moves.

    Attributes:
        rows: which they are (n,).
        at: joint that carries their points; 0 is the world.
        along: joint that their axes turn with; 0 is the world.
        points: (n, 3) where they act, in the joint's frame [m].
        forces: (n, 3) unit impulses along those axes.
        moments: (n, 3) unit moments about those axes.
        moves: (nv,) 1 for the joint velocities that move the body, else 0.
    """

    rows: np.ndarray
    at: int
    along: int
    points: Array
    forces: Array
    moments: Array
    moves: Array


def assembler(system: System, data: pin.Data) -> Callable[[Array], tuple[Array, Array]]:
    """A function q → H (nv, nv), J_c (nc, nv), in whatever posture.

    A point of contact stays where it is on its body, and the ground's directions stay where they are in the world.
    """
    model, pushes = system.model, _pushes(system)

    def assemble(q: Array) -> tuple[Array, Array]:
        H = pin.crba(model, data, q, pin.Convention.WORLD)
        J = data.J
        J_c = np.zeros((len(system.b), model.nv))
        for rows, at, along, points, forces, moments, moves in pushes:
            place = data.oMi[at]
            if along:
                to_world = data.oMi[along].rotation.T
                forces, moments = forces @ to_world, moments @ to_world
            moments = moments + _cross(points @ place.rotation.T + place.translation, forces)
            J_c[rows] += (forces @ J[:3] + moments @ J[3:]) * moves
        return H, J_c

    return assemble


def _pushes(system: System) -> list[_Push]:
    """The scene's rows; those on one body, at one joint and along the axes of one, together."""
    robot = system.robot
    groups: dict[tuple[int, int, int], list[tuple[np.ndarray, Array, Array, Array]]] = {}
    first = 0
    for ends, at, point, along, forces, moments in _pieces(system):
        at_joint, along_joint = _joint(robot, at), _joint(robot, along)
        if at >= 0:
            point = robot.bodies[at].offset + robot.bodies[at].rotation @ point
        if along >= 0:
            forces, moments = (axes @ robot.bodies[along].rotation.T for axes in (forces, moments))
        n = len(forces) + len(moments)
        rows, points = np.arange(first, first + n), np.broadcast_to(point, (n, 3))
        push, turn = np.vstack([forces, np.zeros_like(moments)]), np.vstack([np.zeros_like(forces), moments])
        for body, sign in ends:
            if body >= 0:
                groups.setdefault((body, at_joint, along_joint), []).append((rows, points, sign * push, sign * turn))
        first += n
    pushes = []
    for (body, at, along), parts in groups.items():
        rows, points, forces, moments = (np.concatenate(part) for part in zip(*parts, strict=True))
        pushes.append(_Push(rows, at, along, points, forces, moments, robot.moves[body].astype(float)))
    return pushes


def _pieces(system: System) -> Iterator[tuple[tuple[tuple[int, float], ...], int, Array, int, Array, Array]]:
    """What holds, in the order of the rows: contacts, standing feet, loops.

    Yields: the bodies that feel it and with which sign; body and point in its frame where it acts; body with which its axes turn,
    and axes in its frame along which (n, 3) and about which (m, 3) it holds. Body −1 is the world.
    """
    for touch in system.landing.touches:
        yield ((touch.body, 1.0),), touch.body, touch.point, -1, touch.directions, touch.turns
    for frame in map(system.robot.frame, system.scene.stance):
        yield ((frame.body, 1.0),), frame.body, frame.offset, -1, np.eye(3), NONE
    for loop in loops_in(system):
        (a, b), to_body = loop.bodies, loop.rotations[0].T
        yield ((a, 1.0), (b, -1.0)), b, loop.points[1], a, loop.axes @ to_body, to_body if loop.turns else NONE


def _joint(robot: Robot, body: int) -> int:
    """The joint of a body; 0 for the world (body −1)."""
    return robot.bodies[body].joint if body >= 0 else 0


def _cross(a: Array, b: Array) -> Array:
    """Cross products of rows (n, 3), in a sixth of the time that numpy's own takes for a few."""
    one, two = (1, 2, 0), (2, 0, 1)
    return a.take(one, 1) * b.take(two, 1) - a.take(two, 1) * b.take(one, 1)
