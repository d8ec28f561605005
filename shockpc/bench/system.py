"""What a method is given: a robot in a posture and what is held there. Run times are from q to the velocities of all bodies."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array, velocity_at
from shockpc.errors import SceneError
from shockpc.landing import Landing, resolve
from shockpc.robot.robot import Robot
from shockpc.scene import Scene

__all__ = ["System", "UnsuitedError", "system_of"]


class UnsuitedError(SceneError):
    """A method cannot take a scene; the text says why."""


class System(NamedTuple):
    """A landing ready for every method.

    Attributes:
        landing: the scene resolved on the robot.
        model: the robot's Pinocchio model with the scene's reflected inertia in it.
        v: (nv,) joint velocities before the impact in Pinocchio's layout; a base without joint is at rest.
        b: (nc,) speed to be undone along every row.
        G: (nv, ny) columns of the free velocities, or None where all are free.
    """

    landing: Landing
    model: pin.Model
    v: Array
    b: Array
    G: Array | None

    def assembler(self, data: pin.Data) -> Callable[[Array], tuple[Array, Array]]:
        """A function q → H (nv, nv), J_c (nc, nv): contact points stay where they are on their bodies, in any posture."""
        robot, pieces = self.landing.robot, []

        def in_joint(i: int) -> tuple[int, pin.SE3]:
            """Pinocchio's joint of a body, and the body's placement in it; joint 0 is the world."""
            if i < 0:
                return 0, pin.SE3.Identity()
            body = robot.bodies[i]
            return body.joint, pin.SE3(body.rotation, body.offset)

        for block in self.landing.rows(self.landing.state):
            (at, carrier), (along, frame) = in_joint(block.carrier), in_joint(block.axes_body)
            axes = (block.forces @ frame.rotation.T, block.moments @ frame.rotation.T)
            ends = [sign * robot.moves[body] for body, sign in ((block.body, 1.0), (block.other, -1.0)) if body >= 0]
            pieces.append((np.sum(ends, axis=0), at, carrier.act(np.reshape(block.point, 3)), along, *axes))

        def assemble(q: Array) -> tuple[Array, Array]:
            H = pin.crba(self.model, data, q, pin.Convention.WORLD)
            J, rows = data.J, []
            for moves, at, point, along, forces, moments in pieces:
                if along:
                    R = data.oMi[along].rotation.T
                    forces, moments = forces @ R, moments @ R
                rows.append(moves * (forces @ J[:3] + _cross(data.oMi[at].act(point), forces) @ J[3:]))
                if len(moments):
                    rows.append(moves * (moments @ J[3:]))
            return H, np.concatenate(rows)

        return assemble

    def jumps(self, twists: Any) -> Array:
        """Jumps (nb, 6) of the bodies, body axes at the body frames' origins, from Pinocchio's joint velocities `data.v`."""
        bodies = self.landing.robot.bodies
        jumps = np.empty((len(bodies), 6))
        for i, body in enumerate(bodies):
            twist, to_body = twists[body.joint], body.rotation.T
            jumps[i] = [*(to_body @ twist.angular), *(to_body @ velocity_at(twist.angular, twist.linear, body.offset))]
        return jumps

    def contact_points(self) -> list[tuple[int, Array]]:
        """Pinocchio's joint, and point in its frame [m], of every contact."""
        bodies = self.landing.robot.bodies
        found = [(bodies[block.body], block.point) for block in self.landing.rows(self.landing.state) if block.kind == "contact"]
        return [(body.joint, body.offset + body.rotation @ np.reshape(point, 3)) for body, point in found]


def system_of(robot: Robot, scene: Scene) -> System:
    """Prepare a scene.

    Raises:
        ShockError: the scene cannot be computed.
    """
    landing = resolve(scene, robot)
    state, before, model = landing.state, landing.before, pin.Model(robot.model)
    model.armature = landing.joint_model.armature
    v = np.array(before.joint_rates)
    if robot.free_base:
        to_base = robot.bodies[0].rotation @ state.rotation[0, 0].T
        v[:3], v[3:6] = to_base @ before.velocity, to_base @ before.omega
    b, G = landing.approach(state, landing.rows(state)), landing.columns(state)
    return System(landing, model, v, b[0, :, 3], None if G is None else G[0])


def _cross(a: Array, b: Array) -> Array:
    """Cross product of a vector (3,) with rows (n, 3), in a fraction of the time that numpy's own takes for a few rows."""
    one, two = (1, 2, 0), (2, 0, 1)
    return a.take(one) * b.take(two, 1) - a.take(two) * b.take(one, 1)
