"""Inertia, Jacobians and placements of a robot in many postures at once: the one loop over
Pinocchio's calls.

World axes, with the origin at the base: a jump in velocity does not depend on where the robot
stands, and a base a kilometre away would cost digits. Whole matrices are copied out of Pinocchio,
whose buffers do not outlive the next call, and everything after this is array work.
"""

import threading
from typing import NamedTuple, Protocol

import numpy as np
import pinocchio as pin

from shockpc.core.inertia import CompositeInertia, Inertia, matrix_of
from shockpc.core.memo import memoized
from shockpc.core.spatial import Array, cross_matrix
from shockpc.robot.robot import Robot

PINOCCHIO: str = pin.__version__
"""Version of the library that evaluates robots."""

WHOLE_ARRAYS = 170_000
"""Postures times squared joint velocities from which the momenta take less time than H."""

# glibc returns freed memory beyond twice the largest block that was freed so far, and every page of
# it costs a fault when it is used again: a quarter to a half of the run time of many postures. The
# largest block that counts has 32 MiB.
np.empty(2**22 - 2**10)

LARGEST_DATA = 128
"""Joint velocities up to which Pinocchio's `Data` is used: its derivatives take 32 bytes times
their cube, 4 GB for 500.
"""


class Rotors(Protocol):
    """What the rotors of the drives add to the inertia of a robot.

    Attributes:
        armature: (nv,) reflected inertia of the joints [kg m², kg].
        coupling: (nv,) of the joints to the links that carry their rotors [kg m²].
    """

    @property
    def armature(self) -> Array:
        """Reflected inertia (nv,) of the joints [kg m², kg]."""

    @property
    def coupling(self) -> Array:
        """Coupling (nv,) to the links that carry the rotors [kg m²]."""


class NoRotors(NamedTuple):
    """Joints without reflected inertia; attributes as of `Rotors`."""

    armature: Array
    coupling: Array


class Inertias(NamedTuple):
    """The inertias of N robots that are otherwise one, each in another posture; or, with N = 1,
    those of one robot in all.

    Attributes:
        mass: (N, nb) of the bodies [kg].
        com: (N, nb, 3) their centres of mass, in their frames [m].
        inertia: (N, nb, 3, 3) about the centres of mass, axes of the frames [kg m²].
        armature: (N, nv) reflected inertia of the joints [kg m², kg].
        coupling: (N, nv) of the joints to the links that carry their rotors [kg m²].
    """

    mass: Array
    com: Array
    inertia: Array
    armature: Array
    coupling: Array

    @classmethod
    def of(cls, robot: Robot, joints: Rotors) -> "Inertias":
        """The robot as it is (N = 1), with what its joints do."""
        return cls(
            robot.masses[None],
            robot.coms[None],
            robot.inertias[None],
            joints.armature[None],
            joints.coupling[None],
        )

    @property
    def gyration(self) -> Array:
        """Radius of gyration (N, nb) of every body about its centre of mass, as `Robot.gyration`
        [m].
        """
        trace = np.trace(self.inertia, axis1=-2, axis2=-1)
        return np.asarray(
            np.sqrt(np.maximum(trace, 0.0) / 3.0 / np.where(self.mass > 0.0, self.mass, np.inf))
        )

    def rows(self, chosen: slice) -> "Inertias":
        """Some of the robots."""
        return Inertias(*(part[chosen] for part in self))


class Dynamics(NamedTuple):
    """A robot in N postures.

    Attributes:
        inertia: of the bodies, and of the joints' rotors if they were given; as momenta where that
            takes less time.
        J: (N, 6, nv) twist (ω, v at the common origin) that each unit joint velocity gives to the
            bodies behind it.
        rotation: (N, nb, 3, 3) of the body frames, body to world.
        position: (N, nb, 3) origins of the body frames, from the base [m].
        origin: (N, 3) position of the base in the world [m].
        ancestors: (nb, nv) which joint velocities move which bodies.
        Q: (N, nq) configurations, Pinocchio's layout; the position of a floating base is of no
            account.
    """

    inertia: Inertia
    J: Array
    rotation: Array
    position: Array
    origin: Array
    ancestors: np.ndarray
    Q: Array

    @property
    def H(self) -> Array:
        """(N, nv, nv) joint-space inertia [kg, kg m, kg m²]."""
        return matrix_of(self.inertia)


def dynamics(
    robot: Robot, Q: Array, joints: Rotors | None = None, inertias: Inertias | None = None
) -> Dynamics:
    """Evaluate a robot in N postures.

    Args:
        robot: the robot; of one whose bodies are not in the order of the tree, Pinocchio's
            algorithms give a wrong inertia.
        Q: (N, nq) configurations in Pinocchio's layout.
        joints: what they do, of which their reflected inertia and its coupling count here; none by
            default.
        inertias: the inertias in each posture, instead of the robot's and of the joints'.
    """
    n, nv = len(Q), robot.model.nv
    J, placed = np.empty((n, nv, 6)), np.empty((n, robot.model.njoints, 12))
    joints = joints or NoRotors(np.zeros(nv), np.zeros(nv))
    Q, origin = np.array(Q, dtype=float), np.zeros((n, 3))
    if robot.free_base:
        origin = Q[:, :3].copy()
        Q[:, :3] = 0.0
    inertia: Inertia
    if nv > LARGEST_DATA or not robot.depth_first:
        inertias = Inertias.of(robot, joints) if inertias is None else inertias
        before = _place_joints(robot.model, Q, J, placed)
    else:
        model, data, J_view, F_view, com_view, placements, symmetric = _workspace(
            robot, threading.get_ident()
        )
        model.armature, before = joints.armature, tuple(data.parents_fromRow)
        if inertias is not None:
            for k, q in enumerate(Q):
                pin.computeJointJacobians(model, data, q)
                J[k] = J_view
                placed[k] = placements
        elif n * nv**2 < WHOLE_ARRAYS:
            inertia, world, crba = np.empty((n, nv, nv)), pin.Convention.WORLD, pin.crba
            for k, q in enumerate(Q):
                inertia[k] = crba(model, data, q, world)
                J[k] = J_view
                placed[k] = placements
            if not symmetric:
                row, column = np.tril_indices(nv, -1)
                inertia[:, row, column] = inertia[:, column, row]
        else:
            F, com = np.empty((n, nv, 6)), np.empty((n, 3))
            for k, q in enumerate(Q):
                pin.computeCentroidalMap(model, data, q)
                J[k], F[k], com[k] = J_view, F_view, com_view
                placed[k] = placements
    # Pinocchio writes the linear part first.
    J = np.concatenate([J[:, :, 3:], J[:, :, :3]], axis=2).swapaxes(1, 2)
    if inertias is None and n * nv**2 >= WHOLE_ARRAYS:
        about_the_origin = F[:, :, 3:] + np.cross(com[:, None], F[:, :, :3])
        F = np.concatenate([about_the_origin, F[:, :, :3]], axis=2).swapaxes(1, 2)
        inertia = CompositeInertia(J, F, np.array(joints.armature), before).with_rotors(
            joints.coupling
        )
    elif inertias is None and joints.coupling.any():
        none = CompositeInertia(J, np.zeros_like(J), np.zeros(nv), before)
        inertia = matrix_of(inertia) + matrix_of(none.with_rotors(joints.coupling))
    rotation = placed[:, 1:, :9].reshape(n, -1, 3, 3).swapaxes(-1, -2)
    position = placed[:, 1:, 9:12]
    if robot.body_frames is not None:
        body_rotation, offset = robot.body_frames
        position = position + (rotation @ offset[..., None])[..., 0]
        rotation = rotation @ body_rotation
    if inertias is not None:
        F = _momenta(robot, J, rotation, position, inertias)
        momenta = CompositeInertia(J, F, inertias.armature, before).with_rotors(inertias.coupling)
        inertia = momenta if n * nv**2 >= WHOLE_ARRAYS else matrix_of(momenta)
    return Dynamics(inertia, J, rotation, position, origin, robot.ancestors, Q)


def _place_joints(model: pin.Model, Q: Array, J: Array, placed: Array) -> tuple[int, ...]:
    """Evaluate the joints of a robot that is too large for Pinocchio's `Data` in N postures.

    Args:
        model: of the robot.
        Q: (N, nq) configurations.
        J: (N, nv, 6) for the twists of unit joint velocities about the origin, linear part first.
        placed: (N, njoints, 12) for the columns of the rotation and the translation of each joint.

    Returns: the joint velocity before each one, of its joint or of that which carries it; −1 for
        the first.
    """
    joints = list(zip(model.joints, model.jointPlacements, model.parents, strict=True))[1:]
    computed, first = [joint.createData() for joint, *_ in joints], np.eye(4)[:, :3].ravel()
    for k, q in enumerate(Q):
        places = [pin.SE3.Identity()]
        placed[k, 0] = first
        for i, ((joint, place, parent), data) in enumerate(
            zip(joints, computed, strict=True), start=1
        ):
            joint.calc(data, q)
            places.append(places[parent] * (place * data.M))
            placed[k, i, :9], placed[k, i, 9:] = places[i].rotation.T.ravel(), places[i].translation
            columns = slice(joint.idx_v, joint.idx_v + joint.nv)
            J[k, columns] = (places[i].toActionMatrix() @ np.reshape(data.S, (6, -1))).T
    ends = [-1, *(joint.idx_v + joint.nv - 1 for joint, *_ in joints)]
    return tuple(
        v - 1 if v > joint.idx_v else ends[parent]
        for joint, _, parent in joints
        for v in range(joint.idx_v, joint.idx_v + joint.nv)
    )


def spatial_inertias(robot: Robot, state: Dynamics, inertias: Inertias) -> Array:
    """Inertias (N, nb, 6, 6) of the bodies about the base's origin, world axes (Featherstone 2008,
    Eq. 2.63).

    They contain the coupling of rotors, of which the angular velocities of a joint's two bodies, ω
    and ω_p, take all but a part of the joint's own inertia: c q̇ (a·ω_p) = ½ c (a·ω)² − ½ c
    (a·ω_p)² − ½ c q̇², as a·ω = a·ω_p + q̇.
    """
    R, mass = state.rotation, inertias.mass[..., None, None]
    C = cross_matrix(state.position + (R @ inertias.com[..., None])[..., 0])
    out = np.zeros((*C.shape[:2], 6, 6))
    out[..., :3, :3] = R @ inertias.inertia @ np.swapaxes(R, -1, -2) - mass * C @ C
    out[..., :3, 3:], out[..., 3:, :3], out[..., 3:, 3:] = mass * C, -mass * C, mass * np.eye(3)
    for v, body in geared_bodies(robot, inertias.coupling):
        a = state.J[:, :3, v]
        moments = inertias.coupling[:, v, None, None] * a[:, :, None] * a[:, None, :]
        out[:, body, :3, :3] += moments
        out[:, robot.parents[body], :3, :3] -= moments
    return out


def geared_bodies(robot: Robot, coupling: Array) -> list[tuple[int, int]]:
    """The velocities of joints that couple to the links that carry their rotors, and the bodies
    that the joints move.

    Args:
        robot: the robot.
        coupling: (..., nv), zero of all others.
    """
    return [
        (joint.v.start, body)
        for body, joint in enumerate(robot.joints)
        if coupling[..., joint.v].any()
    ]


def _momenta(robot: Robot, J: Array, rotation: Array, position: Array, inertias: Inertias) -> Array:
    """Momenta F (N, 6, nv) of unit joint velocities, as `CompositeInertia` holds them: composite
    inertias times J.

    About the common origin a body of mass m with its centre of mass at c has the momentum (Ī ω + m
    c × v, m v + ω × m c) with Ī = R I Rᵀ − m c× c×. All three of m, m c and Ī add along the tree
    (Featherstone 2008, section 6.2).
    """
    c = position + (rotation @ inertias.com[..., None])[..., 0]
    mass, first, C = (
        np.broadcast_to(inertias.mass, c.shape[:2]).copy(),
        inertias.mass[..., None] * c,
        cross_matrix(c),
    )
    second = rotation @ inertias.inertia @ np.swapaxes(rotation, -1, -2) - inertias.mass[
        ..., None, None
    ] * (C @ C)
    for i, parent in reversed(list(enumerate(robot.parents))):
        if parent >= 0:
            for part in (mass, first, second):
                part[:, parent] += part[:, i]
    carried = [
        i for i, joint in enumerate(robot.joints) for _ in range(joint.v.stop - joint.v.start)
    ]
    m, h, omega, v = (
        mass[:, carried, None],
        first[:, carried],
        *np.split(J.swapaxes(1, 2), 2, axis=-1),
    )
    angular = (second[:, carried] @ omega[..., None])[..., 0] + np.cross(h, v)
    return np.concatenate([angular, m * v + np.cross(omega, h)], axis=-1).swapaxes(1, 2)


@memoized(most=16)
def _workspace(
    robot: Robot, thread: int
) -> tuple[pin.Model, pin.Data, Array, Array, Array, Array, bool]:
    """A copy of a robot's model with its data for one thread; preparing it costs more than using
    it.

    Read one by one, J and the placements cost more than the algorithms. Both lie in one piece of
    memory each, the placements as columns of the rotation followed by the translation, at equal
    steps.

    Returns: the model, whose armature is that of the last call; the data; views of these: the
        Jacobian's columns (nv, 6), momenta of unit joint velocities (nv, 6) about the centre of
        mass, the centre of mass (3,) and the joints' placements (njoints, 12); and whether crba
        fills both triangles, which depends on the version.
    """
    del thread
    model = pin.Model(robot.model)
    data = model.createData()
    H = pin.crba(model, data, robot.start, pin.Convention.WORLD)
    first = data.oMi[0].rotation
    step = data.oMi[1].rotation.ctypes.data - first.ctypes.data
    if data.oMi[0].translation.ctypes.data - first.ctypes.data != 72 or first.strides != (8, 24):
        raise ImportError(
            f"Pinocchio {PINOCCHIO} stores placements in another way than versions 4.0 and 4.1; "
            f"install one of those"
        )
    flat = np.lib.stride_tricks.as_strided(first.T, (model.njoints, 12), (step, 8), writeable=False)
    return model, data, data.J.T, data.Ag.T, data.com[0], flat, np.array_equal(H, H.T)
