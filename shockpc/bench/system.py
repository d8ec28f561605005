"""What a method is given: a robot in a posture and what is held there. Run times are from q to the velocities of all bodies."""

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array, velocity_at
from shockpc.errors import SceneError
from shockpc.landing import Landing, resolve
from shockpc.robot.robot import Robot
from shockpc.scene import Scene

__all__ = ["System", "UnsuitedError", "bodies_from", "system_of"]

NONE = np.zeros((0, 3))


class UnsuitedError(SceneError):
    """A method cannot take a scene; the text says why."""


class System(NamedTuple):
    """A landing ready for every method.

    Attributes:
        robot: the robot.
        scene: complete.
        landing: the scene resolved on the robot.
        model: the robot's Pinocchio model with the scene's reflected inertia in it.
        v: (nv,) joint velocities before the impact in Pinocchio's layout; a base without joint is at rest.
        b: (nc,) speed to be undone along every row.
        G: (nv, ny) columns of the free velocities, or None where all are free.
    """

    robot: Robot
    scene: Scene
    landing: Landing
    model: pin.Model
    v: Array
    b: Array
    G: Array | None

    def assembler(self, data: pin.Data) -> Callable[[Array], tuple[Array, Array]]:
        """A function q → H (nv, nv), J_c (nc, nv): contact points stay where they are on their bodies, in any posture."""
        pieces = list(self.pieces())

        def assemble(q: Array) -> tuple[Array, Array]:
            H = pin.crba(self.model, data, q, pin.Convention.WORLD)
            J, rows = data.J, []
            for ends, at, point, along, axes, about in pieces:
                if along:
                    R = data.oMi[along].rotation.T
                    axes, about = axes @ R, about @ R
                p = data.oMi[at].act(point)
                n = len(axes)
                block = np.zeros((n + len(about), self.model.nv))
                for moves, sign in ends:
                    block[:n] += (sign * moves) * (axes @ J[:3] + _cross(p, axes) @ J[3:])
                    if len(about):
                        block[n:] += (sign * moves) * (about @ J[3:])
                rows.append(block)
            return H, np.concatenate(rows)

        return assemble

    def pieces(self) -> Iterator[tuple[list[tuple[Array, float]], int, Array, int, Array, Array]]:
        """What holds, in the order of the rows: contacts, standing feet, loops.

        Yields: the joint velocities that move each end, with its sign; joint and point in its frame where it acts; joint with which
        its axes turn, and axes in that frame along which and about which it holds. Joint 0 is the world.
        """
        robot = self.robot

        def place(body: int, point: Array) -> tuple[int, Array]:
            if body < 0:
                return 0, point
            found = robot.bodies[body]
            return found.joint, found.offset + found.rotation @ point

        moves = robot.moves.astype(float)
        for block in self.landing.rows(self.landing.state)[: len(self.landing.contacts)]:
            yield [(moves[block.body], 1.0)], *place(block.body, np.reshape(block.point, 3)), 0, block.forces, block.moments
        for frame in map(robot.frame, self.scene.stance):
            yield [(moves[frame.body], 1.0)], *place(frame.body, frame.offset), 0, np.eye(3), NONE
        for loop in self.landing.loops:
            (a, b), in_body = loop.bodies, loop.rotations[0]
            along = 0 if a < 0 else robot.bodies[a].joint
            R = in_body if a < 0 else robot.bodies[a].rotation @ in_body
            ends = [(moves[body], sign) for body, sign in ((a, 1.0), (b, -1.0)) if body >= 0]
            yield ends, *place(b, loop.points[1]), along, loop.axes @ R.T, R.T if loop.turns else NONE


def system_of(robot: Robot, scene: Scene) -> System:
    """Prepare a scene.

    Raises:
        ShockError: the scene cannot be computed.
    """
    landing = resolve(scene, robot)
    model = pin.Model(robot.model)
    model.armature = landing.joint_model.armature
    before = landing.before
    v = np.array(before.joint_rates)
    G = landing.columns(landing.state)
    system = System(robot, landing.scene, landing, model, v, NONE[:, 0], None if G is None else G[0])
    data = model.createData()
    pin.forwardKinematics(model, data, landing.q)
    if robot.free_base:
        to_base = data.oMi[1].rotation.T
        v[:3], v[3:6] = to_base @ before.velocity, to_base @ before.omega
    _, J_c = system.assembler(data)(landing.q)
    restitution = np.concatenate([np.full(len(c.directions) + len(c.moments), c.restitution) for c in landing.contacts])
    speed = J_c[: len(restitution)] @ v
    if not robot.free_base:
        speed += np.concatenate([np.concatenate([c.directions @ before.velocity, 0.0 * c.moments[:, 0]]) for c in landing.contacts])
    b = np.zeros(len(J_c))
    b[: len(speed)] = (1.0 + restitution) * speed
    return system._replace(b=b)


def bodies_from(system: System, twists: Any) -> Array:
    """Jumps (nb, 6) of the bodies, body axes at the body frames' origins, from Pinocchio's joint velocities `data.v`."""
    jumps = np.empty((len(system.robot.bodies), 6))
    for i, body in enumerate(system.robot.bodies):
        twist = twists[body.joint]
        to_body = body.rotation.T
        jumps[i] = [*(to_body @ twist.angular), *(to_body @ velocity_at(twist.angular, twist.linear, body.offset))]
    return jumps


def _cross(a: Array, b: Array) -> Array:
    """Cross product of a vector (3,) with rows (n, 3), in a fraction of the time that numpy's own takes for a few rows."""
    one, two = (1, 2, 0), (2, 0, 1)
    return a.take(one) * b.take(two, 1) - a.take(two) * b.take(one, 1)
