"""Inertia, Jacobians and placements of a robot in many postures at once: the one loop over Pinocchio's calls.

World axes, with the origin at the base: a jump in velocity does not depend on where the robot stands, and a base a kilometre away
would cost digits. Whole matrices are copied out of Pinocchio (its buffers do not outlive the next call) and everything after this
is array work.
"""

from typing import NamedTuple

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array
from shockpc.core.tree import Tree
from shockpc.model.long_chain import LONG, evaluate
from shockpc.robot.robot import Robot

__all__ = ["PINOCCHIO", "Dynamics", "dynamics", "tree"]

PINOCCHIO: str = pin.__version__
"""Version of the library that computes all this."""


class Dynamics(NamedTuple):
    """A robot in N postures.

    Attributes:
        H: (N, nv, nv) joint-space inertia of the bodies alone, without armature [kg, kg m, kg m²].
        J: (N, 6, nv) unit-rate twist (ω, v at the common origin) that each joint velocity gives to the bodies behind it.
        rotation: (N, nb, 3, 3) of the body frames, body to world.
        position: (N, nb, 3) origins of the body frames, from the base [m].
        joint_position: (N, nb, 3) origins of the joint frames, from the base [m].
        origin: (N, 3) where the base stands in the world [m].
        moves: (nb, nv) which joint velocities move which bodies.
        parent: (nb,) index of the body that each body's joint hangs on; −1 for the world.
        own: the joint velocities of each body's joint.
    """

    H: Array
    J: Array
    rotation: Array
    position: Array
    joint_position: Array
    origin: Array
    moves: np.ndarray
    parent: np.ndarray
    own: tuple[slice, ...]


def dynamics(robot: Robot, Q: Array) -> Dynamics:
    """Evaluate a robot in N postures.

    Args:
        robot: the robot.
        Q: (N, nq) configurations in Pinocchio's layout.
    """
    model = robot.model
    if model.armature.any():
        # crba would add the file's armature; which one counts is the transmission's to say.
        model = pin.Model(model)
        model.armature = np.zeros(model.nv)
    data = model.createData() if model.njoints < LONG else None
    n, nv = len(Q), model.nv
    H, J = np.empty((n, nv, nv)), np.empty((n, 6, nv))
    placed_rotation, placed_position = np.empty((n, model.njoints, 3, 3)), np.empty((n, model.njoints, 3))
    Q = np.array(Q, dtype=float)
    origin = np.zeros((n, 3))
    if robot.free_base:
        origin = Q[:, :3].copy()
        Q[:, :3] = 0.0
    views = None if data is None else _placements(data, model.njoints)
    for k, q in enumerate(Q):
        if data is None or views is None:
            H[k], J[k], placed = evaluate(model, q)
            placed_rotation[k], placed_position[k] = placed[:, :3, :3], placed[:, :3, 3]
            continue
        H[k] = pin.crba(model, data, q, pin.Convention.WORLD)
        J[k].T[:] = data.J.T  # one column alone comes back as a vector
        placed_rotation[k], placed_position[k] = views
    row, column = np.tril_indices(nv, -1)
    if n and not np.array_equal(H[0], H[0].T):
        # crba fills the upper triangle; some versions leave the lower one empty.
        H[:, row, column] = H[:, column, row]
    J = np.concatenate([J[:, 3:], J[:, :3]], axis=1)

    joints = [body.joint for body in robot.bodies]
    joint_rotation, joint_position = placed_rotation[:, joints], placed_position[:, joints]
    rotation = joint_rotation @ np.stack([body.rotation for body in robot.bodies])
    offset = np.stack([body.offset for body in robot.bodies])
    position = joint_position + (joint_rotation @ offset[..., None])[..., 0]
    parent = np.array([model.parents[joint] - 1 for joint in joints])
    own = tuple(slice(model.joints[joint].idx_v, model.joints[joint].idx_v + model.joints[joint].nv) for joint in joints)
    return Dynamics(H, J, rotation, position, joint_position, origin, robot.moves, parent, own)


def _placements(data: pin.Data, njoints: int) -> tuple[Array, Array]:
    """Rotations (njoints, 3, 3) and positions (njoints, 3) of all joint frames, in Pinocchio's own memory.

    Read one by one the placements cost more than the algorithms. They lie side by side, at equal steps, so one view shows them all;
    it is good for as long as the data are.
    """
    parts = []
    for part in ("rotation", "translation"):
        first, last = (getattr(data.oMi[i], part) for i in (0, njoints - 1))
        step = (last.ctypes.data - first.ctypes.data) // (njoints - 1)
        parts.append(np.lib.stride_tricks.as_strided(first, (njoints, *first.shape), (step, *first.strides), writeable=False))
    rotation, position = parts
    return rotation, position


def tree(robot: Robot, state: Dynamics, armature: Array, G: Array | None) -> Tree:
    """The first posture of a state as free bodies and joints, for the check in maximal coordinates.

    It takes masses and placements from the model and the joints' axes from J, and nothing from H.
    """
    nv = robot.model.nv
    rotation = state.rotation[0]
    com = np.stack([body.com for body in robot.bodies])
    inertia = np.stack([body.inertia for body in robot.bodies])
    S = np.zeros((len(robot.bodies), 6, nv))
    for i, columns in enumerate(state.own):
        S[i, :3, columns] = state.J[0, :3, columns]
        S[i, 3:, columns] = state.J[0, 3:, columns] + np.cross(state.J[0, :3, columns].T, state.joint_position[0, i]).T
    return Tree(
        parent=state.parent,
        mass=np.array([body.mass for body in robot.bodies]),
        com=state.position[0] + (rotation @ com[..., None])[..., 0],
        inertia=rotation @ inertia @ np.swapaxes(rotation, -1, -2),
        joint=state.joint_position[0],
        S=S,
        armature=armature,
        G=None if G is None else G[0],
    )
