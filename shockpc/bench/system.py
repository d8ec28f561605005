"""What a method is given: a robot in a posture and what is held there. Run times are from q to the velocities of all bodies."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array
from shockpc.errors import SceneError
from shockpc.landing import Landing, resolve
from shockpc.model.motion import approach_speeds
from shockpc.model.rows import block_axes, block_point
from shockpc.robot.robot import Robot
from shockpc.scene import Scene

__all__ = ["System", "UnsuitedError", "system_of"]

WORLD_AXES = pin.LOCAL_WORLD_ALIGNED


class UnsuitedError(SceneError):
    """A method cannot take a scene; the text says why."""


class System(NamedTuple):
    """A landing ready for every method.

    Attributes:
        landing: the scene resolved on the robot.
        model: the robot's Pinocchio model with the scene's reflected inertia in it, and a frame at every point that is held.
        held: the rows of each contact, standing foot and loop: world axes (n, 6) of forces and moments; and the frames, one on
            each body that it holds, with 1, or −1 for the opposite impulse.
        v: (nv,) joint velocities before the impact in Pinocchio's layout; a base without joint is at rest.
        b: (nc,) speed to be undone along every row.
        G: (nv, ny) columns of the free velocities, or None where all are free.
    """

    landing: Landing
    model: pin.Model
    held: list[tuple[Array, list[tuple[int, float]]]]
    v: Array
    b: Array
    G: Array | None

    def assemble(self, data: pin.Data) -> tuple[Array, Array]:
        """H (nv, nv) and J_c (nc, nv) in the posture of the landing, computed from q."""
        H = pin.crba(self.model, data, self.landing.q, pin.Convention.WORLD)
        J_c = [
            axes @ sum(sign * pin.getFrameJacobian(self.model, data, frame, WORLD_AXES) for frame, sign in ends)
            for axes, ends in self.held
        ]
        return H, np.concatenate(J_c)

    def jumps(self, motions: Sequence[pin.Motion]) -> Array:
        """Jumps (nb, 6) of the bodies, body axes at their frames' origins. Args: motions of the world and of Pinocchio's joints."""
        own = (pin.SE3(body.rotation, body.offset).actInv(motions[body.joint]) for body in self.landing.robot.bodies)
        return np.array([[*motion.angular, *motion.linear] for motion in own])

    def contact_points(self) -> list[tuple[int, Array]]:
        """Pinocchio's joint, and point in its frame [m], of every contact."""
        frames = (self.model.frames[ends[0][0]] for _, ends in self.held[: len(self.landing.contacts)])
        return [(frame.parentJoint, frame.placement.translation) for frame in frames]


def system_of(robot: Robot, scene: Scene) -> System:
    """Prepare a scene.

    Raises:
        ShockError: the scene cannot be computed.
    """
    landing = resolve(scene, robot)
    state, before, model = landing.state, landing.before, pin.Model(robot.model)
    model.armature = landing.joint_model.armature
    blocks, held = landing.rows(state), []
    for block in blocks:
        point, axes, n = block_point(state, block)[0], np.zeros((block.size, 6)), len(block.forces)
        axes[:n, :3], axes[n:, 3:] = np.split(block_axes(state, block)[0], [n])
        ends = []
        for i, sign in ((block.body, 1.0), (block.other, -1.0)):
            if i >= 0:
                body, own = robot.bodies[i], state.rotation[0, i].T @ (point - state.position[0, i])
                place = pin.SE3(np.eye(3), body.offset + body.rotation @ own)
                frame = pin.Frame(f"end {len(model.frames)}", body.joint, 0, place, pin.FrameType.OP_FRAME)
                ends.append((model.addFrame(frame), sign))
        held.append((axes, ends))
    v = np.array(before.joint_rates)
    if robot.free_base:
        to_base = robot.bodies[0].rotation @ state.rotation[0, 0].T
        v[:3], v[3:6] = to_base @ before.velocity, to_base @ before.omega
    b, G = approach_speeds(state, blocks, before), landing.columns(state)
    return System(landing, model, held, v, b[0, :, 3], None if G is None else G[0])
