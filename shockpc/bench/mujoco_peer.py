"""MuJoCo on the same landing: in a simulation with compliant contacts, or by its matrices.

With these the impulsive equation is solved.
"""

import functools
from typing import Any

import numpy as np
import pinocchio as pin

from shockpc.bench.methods import Method, PinocchioSystem, Prepared, UnsuitedError
from shockpc.core.spatial import Array

try:
    import mujoco

    # by default it writes to standard error and into a file
    mujoco.set_mju_user_warning(lambda text: None)
except ImportError:
    mujoco = None


KINDS = {
    "free": "FREE",
    "ball": "BALL",
    "prismatic": "SLIDE",
    "revolute": "HINGE",
    "continuous": "HINGE",
}
"""MuJoCo's joint for a kind of ours."""


def _model(system: PinocchioSystem, tau: float | None = None) -> Any:
    """A robot as MuJoCo's model, without gravity, which begins in the posture of the landing.

    Body and joint have one number. With a time constant τ [s], a spring and damper act between
    every contact point and the place that it strikes.

    Raises:
        UnsuitedError: MuJoCo is not installed, has no such joint, or refuses the model.
    """
    if mujoco is None:
        raise UnsuitedError("MuJoCo is not installed; install it with: pip install mujoco")
    data = system.model.createData()
    pin.forwardKinematics(system.model, data, system.landing.q)
    spec = mujoco.MjSpec()
    spec.option.gravity = np.zeros(3)
    spec.option.solver = mujoco.mjtSolver.mjSOL_NEWTON
    spec.option.tolerance = 1e-12
    # an unstable simulation ends in NaN
    spec.option.disableflags = mujoco.mjtDisableBit.mjDSBL_AUTORESET
    bodies = _add_bodies(spec, system, data)
    if tau:
        _add_contacts(spec, system, data, bodies, tau)
    try:
        return spec.compile()
    except ValueError as refusal:
        raise UnsuitedError(
            f"MuJoCo refuses the model: {str(refusal).strip().splitlines()[0]}"
        ) from None


def _add_bodies(spec: Any, system: PinocchioSystem, data: pin.Data) -> list[Any]:
    """Add the bodies of a robot with their joints; the world and them, by Pinocchio's joints.

    Args: data, Pinocchio's, with the kinematics of the landing's posture.

    Raises:
        UnsuitedError: MuJoCo has no such joint.
    """
    model = system.model
    bodies = [spec.worldbody]
    for i, joint in enumerate(system.landing.robot.joints, start=1):
        if joint.kind not in KINDS:
            raise UnsuitedError(f"{joint.kind} joints are not written for MuJoCo here")
        inertia, in_parent = model.inertias[i], data.liMi[i]
        # Bodies are numbered depth first in MuJoCo, as joints of a file are in Pinocchio.
        body = bodies[model.parents[i]].add_body(
            pos=in_parent.translation,
            # Quaternions are (x, y, z, w) in Pinocchio, and (w, x, y, z) in MuJoCo.
            quat=np.roll(pin.Quaternion(in_parent.rotation).coeffs(), 1),
            mass=inertia.mass,
            ipos=inertia.lever,
            # In MuJoCo's order: xx, yy, zz, xy, xz, yz.
            fullinertia=inertia.inertia[(0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)],
            explicitinertial=True,
        )
        written = body.add_joint(type=getattr(mujoco.mjtJoint, f"mjJNT_{KINDS[joint.kind]}"))
        if joint.axis is not None:
            written.axis = joint.axis
            written.armature = model.armature[joint.v.start]
        bodies.append(body)
    return bodies


def _add_contacts(
    spec: Any, system: PinocchioSystem, data: pin.Data, bodies: list[Any], tau: float
) -> None:
    """Add each contact as an equality of two sites, which holds the foot where it strikes.

    Args: as of `_add_bodies` and `_model`.
    """
    for k, (carrier, point) in enumerate(system.contact_points()):
        bodies[carrier].add_site(name=f"foot{k}", pos=point)
        bodies[0].add_site(name=f"ground{k}", pos=data.oMi[carrier].act(point))
        spec.add_equality(
            type=mujoco.mjtEq.mjEQ_CONNECT,
            objtype=mujoco.mjtObj.mjOBJ_SITE,
            name1=f"foot{k}",
            name2=f"ground{k}",
            solref=[tau, 100],
            solimp=[0.9999, 0.9999, 0.001, 0.5, 2],
        )


def _jumps(system: PinocchioSystem, peer: Any, data: Any) -> Array:
    """Jumps (nb, 6) of the bodies from `data.cvel`."""
    motions, velocity = [pin.Motion.Zero()], np.empty(6)
    for i in range(1, peer.nbody):
        mujoco.mj_objectVelocity(peer, data, mujoco.mjtObj.mjOBJ_XBODY, i, velocity, 1)
        motions.append(pin.Motion(velocity[3:], velocity[:3]))
    return system.jumps(motions)


def _set_posture(peer: Any, data: Any, q: Array) -> None:
    data.qpos[:] = q
    mujoco.mj_kinematics(peer, data)
    mujoco.mj_comPos(peer, data)


def _simulation(tau: float, system: PinocchioSystem) -> Prepared:
    """A landing in MuJoCo until the speed of the contact has decayed: 20 τ.

    It takes two steps in τ, the fewest that MuJoCo allows.
    """
    landing = system.landing
    if system.G is not None or not landing.floating or landing.loops:
        raise UnsuitedError("MuJoCo is used here for contacts of free robots without loops")
    if not system.sticking or any(contact.restitution for contact in landing.contacts):
        raise UnsuitedError("MuJoCo is used here for sticking points without restitution")
    peer = _model(system, tau)
    peer.opt.timestep = tau / 2.0
    data, before = mujoco.MjData(peer), system.v.copy()
    before[:3] = pin.Quaternion(landing.q[3:7]).matrix() @ system.v[:3]

    def run() -> None:
        mujoco.mj_resetData(peer, data)
        data.qvel[:] = before
        mujoco.mj_step(peer, data, 40)
        # In the posture of the contact, because a soft contact lasts until the bodies have rotated.
        data.qvel -= before
        _set_posture(peer, data, peer.qpos0)
        mujoco.mj_comVel(peer, data)

    return Prepared(run, lambda _: _jumps(system, peer, data), approximates=True)


class _Postures:
    """Landings of a free robot on one sticking point in MuJoCo's layout, a posture at a time.

    Attributes:
        peer: MuJoCo's model.
        data: its data.
        qpos: (N, nq) postures, in which the base is where it is in the landing.
    """

    def __init__(self, system: PinocchioSystem, Q: Array) -> None:
        ((self._body, self._foot),) = system.contact_points()
        self._system = system
        self.peer = _model(system)
        self.data = mujoco.MjData(self.peer)
        # Configurations of the two libraries differ in layout, joint velocities do not: qpos =
        # qpos0 ⊕ (q ⊖ landing.q), in which the base does not move.
        self.qpos = np.tile(self.peer.qpos0, (len(Q), 1))
        for qpos, q in zip(self.qpos, Q, strict=True):
            step = pin.difference(system.model, system.landing.q, q)
            mujoco.mj_integratePos(self.peer, qpos, step, 1.0)
        self._J, self._H_J = np.zeros((2, 3, self.peer.nv))
        self._out = np.empty((len(Q), 3, self.peer.nbody - 1, 6))

    def velocities(self) -> Array:
        """MuJoCo's velocities (N, 3, nb, 6) of the bodies for three unit velocities of the foot."""
        peer, data, J, H_J = self.peer, self.data, self._J, self._H_J
        for k, qpos in enumerate(self.qpos):
            _set_posture(peer, data, qpos)
            mujoco.mj_crb(peer, data)
            mujoco.mj_factorM(peer, data)
            point = data.xpos[self._body] + data.xmat[self._body].reshape(3, 3) @ self._foot
            mujoco.mj_jac(peer, data, J, None, point, self._body)
            mujoco.mj_solveM(peer, data, H_J, J)
            # Δq̇ = −H⁻¹ Jᵀ (J H⁻¹ Jᵀ)⁻¹ v (Eq. 4), for unit velocities v of the foot along each
            # axis.
            for axis, jump in enumerate(-np.linalg.solve(J @ H_J.T, H_J)):
                data.qvel[:] = jump
                mujoco.mj_comVel(peer, data)
                self._out[k, axis] = data.cvel[1:]
        return self._out

    def jumps(self, velocities: Array) -> Array:
        """Jumps (N, nb, 6, 3) of the bodies by those velocities, which `velocities` leaves raw."""
        maps = []
        for qpos, of_axes in zip(self.qpos, velocities, strict=True):
            _set_posture(self.peer, self.data, qpos)
            for velocity in of_axes:
                self.data.cvel[1:] = velocity
                maps.append(_jumps(self._system, self.peer, self.data))
        return np.moveaxis(np.reshape(maps, (len(self.qpos), 3, -1, 6)), 1, -1)


def batch_in_mujoco(system: PinocchioSystem, Q: Array) -> Prepared:
    """The impulsive equation of one sticking point of a free robot, for three directions.

    It is solved with MuJoCo's matrices and sparse factor. The base is where it is in the landing in
    all postures Q (N, nq), which are in Pinocchio's layout.
    """
    postures = _Postures(system, Q)
    return Prepared(postures.velocities, postures.jumps)


MUJOCO: dict[str, Method] = {
    f"simulated in MuJoCo, τ = {tau:.0e} s": functools.partial(_simulation, tau)
    for tau in (1e-2, 1e-3, 1e-4, 1e-5)
}
