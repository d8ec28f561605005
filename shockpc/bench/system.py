"""What a method is given: a robot in a posture and what is held in it. What is timed begins at q and ends at the bodies' jumps."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array, cross_matrix, velocity_at
from shockpc.errors import SceneError
from shockpc.model.closure import closure_block, loop_of
from shockpc.model.contact import stance_block, touch_block
from shockpc.model.dynamics import Dynamics
from shockpc.model.freedom import freedom
from shockpc.model.robot import Robot
from shockpc.model.rows import Rows, stack
from shockpc.scene import Scene
from shockpc.setting import Setting, complete, setting_of

__all__ = [
    "System",
    "Unsuited",
    "assembler",
    "bodies_from",
    "columns_along",
    "columns_at",
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
        setting: the scene made arrays.
        model: the robot's Pinocchio model with the drives' reflected inertia in it.
        b: (nc,) speed to be undone along each row.
        G: (nv, ny) columns of the free velocities, or None where all are.
    """

    robot: Robot
    scene: Scene
    setting: Setting
    model: pin.Model
    b: Array
    G: Array | None


def system_of(robot: Robot, scene: Scene) -> System:
    """Prepare a scene.

    Raises:
        ShockError: the scene cannot be computed.
    """
    scene = complete(scene, robot)
    setting = setting_of(scene, robot)
    model = pin.Model(robot.model)
    model.armature = setting.drives.armature
    G = None if setting.G is None else setting.G[0]
    return System(robot, scene, setting, model, setting.rows.b[0, :, -1], G)


def rows_at(system: System, state: Dynamics) -> Rows:
    """The scene's rows in other postures, the product's way."""
    robot, scene, setting = system.robot, system.scene, system.setting
    loops = (*robot.loops, *(loop_of(robot, closure) for closure in scene.closure))
    return stack(
        [
            *(touch_block(state, touch, setting.before) for touch in setting.touches),
            *(stance_block(robot, state, frame) for frame in scene.stance),
            *(closure_block(state, loop) for loop in loops),
        ]
    )


def columns_at(system: System, state: Dynamics) -> Array | None:
    """The columns of the free velocities in other postures."""
    setting, scene = system.setting, system.scene
    return freedom(system.robot, scene.base or "free", setting.plane, state.rotation[:, 0], setting.drives.locked)


def assembler(system: System, data: pin.Data) -> Callable[[Array], tuple[Array, Array]]:
    """A function q → H (nv, nv), J_c (nc, nv) with as little around Pinocchio's own work as Python allows.

    For one posture the product's way costs more than the solution: it is made for many. The rivals get this one.
    """
    robot, model = system.robot, system.model
    state, W = system.setting.state, system.setting.rows.W[0]
    pushes: list[tuple[int, Array, Array, np.ndarray]] = []
    for i, body in enumerate(robot.bodies):
        rows = np.flatnonzero(np.abs(W[:, i]).max(axis=1) > 0.0)
        if len(rows):
            # A wrench fixed in the body: its moment is written at the joint, so that only the joint has to be placed anew.
            at_joint = W[rows, i].copy()
            at_joint[:, :3] -= np.cross(state.joint_position[0, i], at_joint[:, 3:])
            moves = np.zeros((len(rows), len(W)))
            moves[np.arange(len(rows)), rows] = 1.0
            pushes.append((body.joint, at_joint, moves, state.moves[i].astype(float)))

    def assemble(q: Array) -> tuple[Array, Array]:
        H = pin.crba(model, data, q, pin.Convention.WORLD)
        J = data.J
        J_c = np.zeros((len(W), model.nv))
        for joint, wrench, place, moves in pushes:
            at = cross_matrix(data.oMi[joint].translation)
            J_c += place.T @ (((wrench[:, :3] + wrench[:, 3:] @ at.T) @ J[3:] + wrench[:, 3:] @ J[:3]) * moves)
        return H, J_c

    return assemble


def bodies_from(system: System, twists: Any) -> Array:
    """Jumps (nb, 6) of the bodies, body axes at the body frames' origins, from Pinocchio's joint velocities `data.v`."""
    jumps = np.empty((len(system.robot.bodies), 6))
    for i, body in enumerate(system.robot.bodies):
        there = twists[body.joint]
        omega = body.rotation.T @ there.angular
        jumps[i] = np.concatenate([omega, body.rotation.T @ velocity_at(there.angular, there.linear, body.offset)])
    return jumps


def columns_along(system: System) -> Callable[[Array], Array | None]:
    """A function q → columns of the free velocities (nv, ny), or None where all are; only a planar base turns them with q."""
    if system.scene.base != "planar":
        return lambda q: system.G

    def columns(q: Array) -> Array | None:
        setting = system.setting
        R = pin.Quaternion(q[3:7] / np.linalg.norm(q[3:7])).matrix() @ system.robot.bodies[0].rotation
        G = freedom(system.robot, "planar", setting.plane, R[None], setting.drives.locked)
        return None if G is None else G[0]

    return columns


def velocity_at_impact(system: System) -> Array:
    """The motion before the impact as a joint velocity (nv,), as Pinocchio writes it.

    A base that is held at rest among its joints has none: its part is zero where the robot's file has no free base.
    """
    before = system.setting.before
    v = before.joint_rates.copy()
    if system.robot.free_base:
        R = system.setting.state.rotation[0, 0] @ system.robot.bodies[0].rotation.T
        v[:3] = R.T @ before.velocity
        v[3:6] = R.T @ before.omega
    return np.asarray(v)
