"""What a method is given: a robot in a posture and what is held in it. What is timed begins at q and ends at the bodies' jumps."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array, velocity_at
from shockpc.errors import SceneError
from shockpc.landing import Landing, complete, resolve
from shockpc.model.closure import closure_block, loop_of
from shockpc.model.columns import freedom
from shockpc.model.contact import stance_block, touch_block
from shockpc.model.dynamics import Dynamics
from shockpc.model.rows import Rows, stack
from shockpc.robot.couplings import Loop
from shockpc.robot.robot import Robot
from shockpc.scene import Scene

__all__ = [
    "System",
    "Unsuited",
    "bodies_from",
    "columns_along",
    "columns_at",
    "jumps_between",
    "loops_in",
    "moving",
    "rows_at",
    "system_of",
    "velocity_at_impact",
]


class Unsuited(SceneError):  # noqa: N818 - the name says what it is
    """A method that cannot take a scene; the text says why."""


class System(NamedTuple):
    """A scene ready for every method.

    Attributes:
        robot: the robot.
        scene: complete.
        landing: the scene made arrays.
        model: the robot's Pinocchio model with the drives' reflected inertia in it.
        b: (nc,) speed to be undone along each row.
        G: (nv, ny) columns of the free velocities, or None where all are.
    """

    robot: Robot
    scene: Scene
    landing: Landing
    model: pin.Model
    b: Array
    G: Array | None


def system_of(robot: Robot, scene: Scene) -> System:
    """Prepare a scene.

    Raises:
        ShockError: the scene cannot be computed.
    """
    scene = complete(scene, robot)
    landing = resolve(scene, robot)
    model = pin.Model(robot.model)
    model.armature = landing.drives.armature
    G = None if landing.G is None else landing.G[0]
    return System(robot, scene, landing, model, landing.rows.b[0, :, -1], G)


def loops_in(system: System) -> tuple[Loop, ...]:
    """The loops that the robot's file and the scene close."""
    return (*system.robot.loops, *(loop_of(system.robot, closure) for closure in system.scene.closure))


def rows_at(system: System, state: Dynamics) -> Rows:
    """The scene's rows in other postures, the product's way."""
    robot, scene, landing = system.robot, system.scene, system.landing
    return stack(
        [
            *(touch_block(state, touch, landing.before) for touch in landing.touches),
            *(stance_block(robot, state, frame) for frame in scene.stance),
            *(closure_block(state, loop) for loop in loops_in(system)),
        ]
    )


def columns_at(system: System, state: Dynamics) -> Array | None:
    """The columns of the free velocities in other postures."""
    landing, scene = system.landing, system.scene
    return freedom(system.robot, scene.base or "free", landing.plane, state.rotation[:, 0], landing.drives.locked)


def bodies_from(system: System, twists: Any) -> Array:
    """Jumps (nb, 6) of the bodies, body axes at the body frames' origins, from Pinocchio's joint velocities `data.v`."""
    jumps = np.empty((len(system.robot.bodies), 6))
    for i, body in enumerate(system.robot.bodies):
        there = twists[body.joint]
        omega = body.rotation.T @ there.angular
        jumps[i] = np.concatenate([omega, body.rotation.T @ velocity_at(there.angular, there.linear, body.offset)])
    return jumps


def moving(system: System, q: Array, v: Array) -> pin.Data:
    """The robot in a posture at joint velocities, as Pinocchio has it: places and velocities of its joints."""
    data = system.model.createData()
    pin.forwardKinematics(system.model, data, q, v)
    return data


def jumps_between(system: System, before: pin.Data, after: pin.Data) -> Array:
    """Jumps (nb, 6) of the bodies between two moments, in body axes at the body frames' origins, as they were at the first.

    Each body's velocity is taken in world axes, of its centre of mass, in the posture of its own moment: a body that turned on the
    way has other axes after it, and parts of a velocity in two sets of axes do not subtract.
    """
    com = np.stack([body.com for body in system.robot.bodies])
    start, change = _orientations(system, before), np.zeros((len(com), 2, 3))
    for data, R, sign in ((before, start, -1.0), (after, _orientations(system, after), 1.0)):
        twists = bodies_from(system, data.v)
        parts = np.stack([twists[:, :3], velocity_at(twists[:, :3], twists[:, 3:], com)], axis=1)
        change += sign * parts @ np.swapaxes(R, -1, -2)
    omega, v = np.moveaxis(change @ start, 1, 0)
    return np.hstack([omega, velocity_at(omega, v, -com)])


def _orientations(system: System, data: pin.Data) -> Array:
    """Of the body frames (nb, 3, 3), body to world."""
    return np.stack([data.oMi[body.joint].rotation @ body.rotation for body in system.robot.bodies])


def columns_along(system: System) -> Callable[[Array], Array | None]:
    """A function q → columns of the free velocities (nv, ny), or None where all are; only a planar base turns them with q."""
    if system.scene.base != "planar":
        return lambda q: system.G

    def columns(q: Array) -> Array | None:
        landing = system.landing
        R = pin.Quaternion(q[3:7] / np.linalg.norm(q[3:7])).matrix() @ system.robot.bodies[0].rotation
        G = freedom(system.robot, "planar", landing.plane, R[None], landing.drives.locked)
        return None if G is None else G[0]

    return columns


def velocity_at_impact(system: System) -> Array:
    """The motion before the impact as a joint velocity (nv,), as Pinocchio writes it.

    A base that is held at rest among its joints has none: its part is zero where the robot's file has no free base.
    """
    before = system.landing.before
    v = before.joint_rates.copy()
    if system.robot.free_base:
        R = system.landing.state.rotation[0, 0] @ system.robot.bodies[0].rotation.T
        v[:3] = R.T @ before.velocity
        v[3:6] = R.T @ before.omega
    return np.asarray(v)
