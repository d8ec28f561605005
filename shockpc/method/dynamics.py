"""Inertia, Jacobians and placements of a robot in many postures at once.

The one loop over Pinocchio's calls.

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

# glibc returns freed memory beyond twice the largest block that was freed so far, and every page
# of it costs a fault when it is used again: a quarter to a half of the run time of many postures.
# The largest block that counts has 32 MiB.
np.empty(2**22 - 2**10)

NOT_ASKED = np.zeros(0)
"""In place of numbers that are not computed."""

LARGEST_DATA = 128
"""Joint velocities up to which Pinocchio's `Data` is used: its derivatives take 32 bytes times
their cube, 4 GB for 500.
"""


class Rotors(Protocol):
    """Inertia that the rotors of the drives add to a robot.

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
    """The inertias of N robots that are otherwise one, each in another posture.

    With N = 1 they are those of one robot in all postures.

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
        """Radius of gyration (N, nb) of every body about its centre of mass [m].

        It is that for the mean axis, as `Robot.gyration`.
        """
        trace = np.trace(self.inertia, axis1=-2, axis2=-1)
        mass = np.where(self.mass > 0.0, self.mass, np.inf)
        return np.asarray(np.sqrt(np.maximum(trace, 0.0) / 3.0 / mass))

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
    """The inertia, Jacobians and placements of a robot in N postures.

    Args:
        robot: the robot; of one whose bodies are not in the order of the tree, Pinocchio's
            algorithms give a wrong inertia.
        Q: (N, nq) configurations in Pinocchio's layout.
        joints: what they do, of which their reflected inertia and its coupling count here; none by
            default.
        inertias: the inertias in each posture, instead of the robot's and of the joints'.
    """
    nv = robot.model.nv
    joints = joints or NoRotors(np.zeros(nv), np.zeros(nv))
    # Above this size the momenta F of H = Jᵀ F take less time than H.
    as_momenta = len(Q) * nv**2 >= WHOLE_ARRAYS
    too_large = nv > LARGEST_DATA or not robot.depth_first
    # Pinocchio's `Data` of a large model takes too much memory, and its composite inertias need
    # bodies in the order of the tree.
    if too_large and inertias is None:
        inertias = Inertias.of(robot, joints)

    # The base stands at the origin.
    Q = np.array(Q, dtype=float)
    origin = np.zeros((len(Q), 3))
    if robot.free_base:
        origin = Q[:, :3].copy()
        Q[:, :3] = 0.0

    if too_large:
        evaluated = _by_joints(robot.model, Q)
    else:
        workspace = _workspace(robot, threading.get_ident())
        workspace.model.armature = joints.armature
        if inertias is not None:
            evaluated = workspace.jacobians(Q)
        elif as_momenta:
            evaluated = workspace.momenta(Q)
        else:
            evaluated = workspace.inertia(Q)

    J = _angular_first(evaluated.J)
    rotation, position = _body_frames(robot, evaluated.placed)
    if inertias is None:
        inertia = _inertia_of(evaluated, J, joints)
    else:
        F = _momenta(robot, J, rotation, position, inertias)
        momenta = CompositeInertia(J, F, inertias.armature, evaluated.before)
        momenta = momenta.with_rotors(inertias.coupling)
        inertia = momenta if as_momenta else matrix_of(momenta)
    return Dynamics(inertia, J, rotation, position, origin, robot.ancestors, Q)


def _inertia_of(evaluated: "_Evaluated", J: Array, joints: Rotors) -> Inertia:
    """The inertia that Pinocchio has, with the coupling of rotors: momenta, or else matrices."""
    if evaluated.F is not NOT_ASKED:
        F = _about_origin(evaluated.F, evaluated.com)
        momenta = CompositeInertia(J, F, np.array(joints.armature), evaluated.before)
        return momenta.with_rotors(joints.coupling)
    if not joints.coupling.any():
        return evaluated.H
    # The coupling of the rotors alone, because H has all else already.
    none = CompositeInertia(J, np.zeros_like(J), np.zeros(J.shape[2]), evaluated.before)
    return evaluated.H + matrix_of(none.with_rotors(joints.coupling))


def _angular_first(rows: Array) -> Array:
    """Columns (N, 6, nv) with the angular part first, of rows (N, nv, 6) as Pinocchio has them."""
    return np.concatenate([rows[:, :, 3:], rows[:, :, :3]], axis=2).swapaxes(1, 2)


def _about_origin(F: Array, com: Array) -> Array:
    """Momenta (N, 6, nv) about the base, of rows (N, nv, 6) about the centre of mass (N, 3)."""
    linear, angular = F[:, :, :3], F[:, :, 3:]
    about_origin = angular + np.cross(com[:, None], linear)
    return np.concatenate([about_origin, linear], axis=2).swapaxes(1, 2)


def _body_frames(robot: Robot, placements: Array) -> tuple[Array, Array]:
    """Rotations (N, nb, 3, 3) and origins (N, nb, 3) of the bodies' frames.

    They follow from the placements of the joints' frames (N, njoints, 12).
    """
    rotation = placements[:, 1:, :9].reshape(len(placements), -1, 3, 3).swapaxes(-1, -2)
    position = placements[:, 1:, 9:12]
    if robot.body_frames is not None:
        body_rotation, offset = robot.body_frames
        position = position + (rotation @ offset[..., None])[..., 0]
        rotation = rotation @ body_rotation
    return rotation, position


class _Evaluated(NamedTuple):
    """Quantities that Pinocchio computes of a robot in N postures, linear parts first.

    Attributes:
        J: (N, nv, 6) twists of unit joint velocities about the origin.
        placed: (N, njoints, 12) columns of the rotation, then the translation, of each joint.
        before: the joint velocity before each one, of its joint or of that which carries it; −1 for
            the first.
        H: (N, nv, nv) joint-space inertia; empty if it is not asked for.
        F: (N, nv, 6) momenta of unit joint velocities about the centre of mass; empty likewise.
        com: (N, 3) centre of mass; empty likewise.
    """

    J: Array
    placed: Array
    before: tuple[int, ...]
    H: Array = NOT_ASKED
    F: Array = NOT_ASKED
    com: Array = NOT_ASKED


def _by_joints(model: pin.Model, Q: Array) -> _Evaluated:
    """A robot that is too large for Pinocchio's `Data`, evaluated joint by joint."""
    n = len(Q)
    J = np.empty((n, model.nv, 6))
    placed = np.empty((n, model.njoints, 12))
    placed[:, 0] = np.eye(4)[:, :3].ravel()
    joints = list(zip(model.joints, model.jointPlacements, model.parents, strict=True))[1:]
    computed = [joint.createData() for joint, *_ in joints]
    for k, q in enumerate(Q):
        placements = [pin.SE3.Identity()]
        for i, data in enumerate(computed):
            joint, at_rest, parent = joints[i]
            joint.calc(data, q)
            placement = placements[parent] * (at_rest * data.M)
            placements.append(placement)
            placed[k, i + 1, :9] = placement.rotation.T.ravel()
            placed[k, i + 1, 9:] = placement.translation
            S = np.reshape(data.S, (6, -1))
            columns = slice(joint.idx_v, joint.idx_v + joint.nv)
            J[k, columns] = (placement.toActionMatrix() @ S).T
    return _Evaluated(J, placed, _before(joints))


def _before(joints: list[tuple[pin.JointModel, pin.SE3, int]]) -> tuple[int, ...]:
    """The joint velocity before each one, as `_Evaluated.before`. Args: joints, with parents."""
    last = [-1]
    before: list[int] = []
    for joint, _, parent in joints:
        end = joint.idx_v + joint.nv - 1
        before += [last[parent], *range(joint.idx_v, end)]
        last.append(end)
    return tuple(before)


def spatial_inertias(robot: Robot, state: Dynamics, inertias: Inertias) -> Array:
    """Inertias (N, nb, 6, 6) of the bodies about the base's origin, world axes.

    Source: Featherstone 2008, Eq. 2.63.

    They contain the coupling of rotors, of which the angular velocities of a joint's two bodies, ω
    and ω_p, take all but a part of the joint's own inertia: c q̇ (a·ω_p) = ½ c (a·ω)² − ½ c
    (a·ω_p)² − ½ c q̇², as a·ω = a·ω_p + q̇.
    """
    # [ R I Rᵀ − m C C,  m C ]
    # [ −m C,            m 1 ]
    R = state.rotation
    m = inertias.mass[..., None, None]
    C = cross_matrix(state.position + (R @ inertias.com[..., None])[..., 0])
    out = np.zeros((*C.shape[:2], 6, 6))
    out[..., :3, :3] = R @ inertias.inertia @ np.swapaxes(R, -1, -2) - m * C @ C
    out[..., :3, 3:] = m * C
    out[..., 3:, :3] = -m * C
    out[..., 3:, 3:] = m * np.eye(3)
    for v, body in geared_bodies(robot, inertias.coupling):
        a = state.J[:, :3, v]
        moments = inertias.coupling[:, v, None, None] * a[:, :, None] * a[:, None, :]
        out[:, body, :3, :3] += moments
        out[:, robot.parents[body], :3, :3] -= moments
    return out


def geared_bodies(robot: Robot, coupling: Array) -> list[tuple[int, int]]:
    """Joint velocities coupled to the links that carry their rotors, and the bodies they move.

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
    """Momenta F (N, 6, nv) of unit joint velocities: composite inertias times J.

    `CompositeInertia` holds them.

    About the common origin a body of mass m with its centre of mass at c has the momentum (Ī ω + m
    c × v, m v + ω × m c) with Ī = R I Rᵀ − m c× c×. All three of m, m c and Ī add along the tree
    (Featherstone 2008, section 6.2).
    """
    c = position + (rotation @ inertias.com[..., None])[..., 0]
    C = cross_matrix(c)
    about_com = rotation @ inertias.inertia @ np.swapaxes(rotation, -1, -2)
    m = np.broadcast_to(inertias.mass, c.shape[:2]).copy()
    mc = inertias.mass[..., None] * c
    moments = about_com - inertias.mass[..., None, None] * (C @ C)
    for i, parent in reversed(list(enumerate(robot.parents))):
        if parent >= 0:
            for part in (m, mc, moments):
                part[:, parent] += part[:, i]

    # Of each joint velocity, all that its joint moves.
    moved: list[int] = []
    for i, joint in enumerate(robot.joints):
        moved += [i] * (joint.v.stop - joint.v.start)
    m, mc, moments = m[:, moved, None], mc[:, moved], moments[:, moved]
    omega, v = np.split(J.swapaxes(1, 2), 2, axis=-1)
    angular = (moments @ omega[..., None])[..., 0] + np.cross(mc, v)
    linear = m * v + np.cross(omega, mc)
    return np.concatenate([angular, linear], axis=-1).swapaxes(1, 2)


class _Workspace(NamedTuple):
    """A copy of a robot's model with its data, and views of these.

    Attributes:
        model: whose armature is that of the last call.
        data: of the last posture.
        J: (nv, 6) twists of unit joint velocities.
        F: (nv, 6) momenta of these about the centre of mass.
        com: (3,) centre of mass.
        placements: (njoints, 12) columns of the rotation, then the translation, of each joint.
        symmetric: whether crba fills both triangles, which depends on the version.
    """

    model: pin.Model
    data: pin.Data
    J: Array
    F: Array
    com: Array
    placements: Array
    symmetric: bool

    def _empty(self, n: int) -> _Evaluated:
        """Room for n postures, without inertias."""
        J = np.empty((n, self.model.nv, 6))
        placed = np.empty((n, self.model.njoints, 12))
        return _Evaluated(J, placed, tuple(self.data.parents_fromRow))

    def jacobians(self, Q: Array) -> _Evaluated:
        """Twists and placements in N postures."""
        out = self._empty(len(Q))
        for k, q in enumerate(Q):
            pin.computeJointJacobians(self.model, self.data, q)
            out.J[k] = self.J
            out.placed[k] = self.placements
        return out

    def inertia(self, Q: Array) -> _Evaluated:
        """Twists, placements and the joint-space inertia in N postures."""
        model, data, world, crba = self.model, self.data, pin.Convention.WORLD, pin.crba
        out = self._empty(len(Q))._replace(H=np.empty((len(Q), model.nv, model.nv)))
        for k, q in enumerate(Q):
            out.H[k] = crba(model, data, q, world)
            out.J[k] = self.J
            out.placed[k] = self.placements
        if not self.symmetric:
            row, column = np.tril_indices(model.nv, -1)
            out.H[:, row, column] = out.H[:, column, row]
        return out

    def momenta(self, Q: Array) -> _Evaluated:
        """Twists, placements and momenta in N postures."""
        n = len(Q)
        out = self._empty(n)._replace(F=np.empty((n, self.model.nv, 6)), com=np.empty((n, 3)))
        for k, q in enumerate(Q):
            pin.computeCentroidalMap(self.model, self.data, q)
            out.J[k] = self.J
            out.F[k] = self.F
            out.com[k] = self.com
            out.placed[k] = self.placements
        return out


@memoized(most=16)
def _workspace(robot: Robot, thread: int) -> _Workspace:
    """The workspace of a robot for one thread; preparing it costs more than using it.

    Read one by one, J and the placements cost more than the algorithms. Both lie in one piece of
    memory each, the placements at equal steps.
    """
    del thread
    model = pin.Model(robot.model)
    data = model.createData()
    H = pin.crba(model, data, robot.start, pin.Convention.WORLD)
    first = data.oMi[0].rotation
    step = data.oMi[1].rotation.ctypes.data - first.ctypes.data
    apart = data.oMi[0].translation.ctypes.data - first.ctypes.data
    if apart != 72 or first.strides != (8, 24):
        raise ImportError(
            f"Pinocchio {PINOCCHIO} stores placements in another way than versions 4.0 and 4.1; "
            f"install one of those"
        )
    flat = np.lib.stride_tricks.as_strided(first.T, (model.njoints, 12), (step, 8), writeable=False)
    symmetric = np.array_equal(H, H.T)
    return _Workspace(model, data, data.J.T, data.Ag.T, data.com[0], flat, symmetric)
