"""MuJoCo on the same landing: simulated with its compliant contact, or the impulsive equation solved with its own matrices."""

from typing import Any

import numpy as np
import pinocchio as pin

from shockpc.bench.methods import Method, Prepared
from shockpc.bench.system import System, UnsuitedError
from shockpc.core.spatial import Array, velocity_at
from shockpc.robot.robot import Robot

try:
    import mujoco
except ImportError:
    mujoco = None

__all__ = ["MUJOCO", "batch_in_mujoco", "mujoco_model", "to_mujoco"]

FRICTION = 100.0
"""Coefficient at which every contact sticks."""

RADIUS = 0.01
"""Of the balls under the contact points [m]."""

KINDS = {"free": "FREE", "ball": "BALL", "prismatic": "SLIDE", "revolute": "HINGE", "continuous": "HINGE"}
"""MuJoCo's joint for a kind of ours."""


def mujoco_model(system: System, feet: bool, tau: float = 1.0, step: float = 1.0) -> Any:
    """A robot as MuJoCo's model, without gravity.

    Args:
        system: a robot with joints of one degree of freedom, ball joints and a free base; numbered depth first, as every reader
            does, so that a body has the same number in both.
        feet: whether to put a small ball under each contact point, and a piece of ground under each ball that it just touches.
        tau: time constant of the contact [s].
        step: of the integration [s].

    Raises:
        UnsuitedError: MuJoCo is not installed, has no such joint, or refuses the model.
    """
    if mujoco is None:
        raise UnsuitedError('MuJoCo is not installed; pip install "shockpc[bench]"')
    model, spec = system.model, mujoco.MjSpec()
    option = spec.option
    option.timestep, option.gravity, option.cone = step, np.zeros(3), mujoco.mjtCone.mjCONE_ELLIPTIC
    option.solver, option.tolerance, option.iterations = mujoco.mjtSolver.mjSOL_NEWTON, 1e-12, 200
    bodies = [spec.worldbody]
    for i, joint in enumerate(system.landing.robot.joints, start=1):
        if joint.kind not in KINDS:
            raise UnsuitedError(f"{joint.kind} joints are not written for MuJoCo here")
        own, place = model.inertias[i], model.jointPlacements[i]
        body = bodies[model.parents[i]].add_body(
            pos=place.translation, quat=np.roll(pin.Quaternion(place.rotation).coeffs(), 1), mass=own.mass, ipos=own.lever,
            fullinertia=own.inertia[(0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)], explicitinertial=True,
        )  # fmt: skip
        written = body.add_joint(type=getattr(mujoco.mjtJoint, f"mjJNT_{KINDS[joint.kind]}"))
        if joint.axis is not None:
            written.axis, written.armature = joint.axis, model.armature[joint.v.start]
        bodies.append(body)
    if feet:
        _put_feet(system, spec, bodies, tau)
    try:
        return spec.compile()
    except ValueError as refusal:
        raise UnsuitedError(f"MuJoCo refuses the model: {str(refusal).strip().splitlines()[0]}") from None


def _put_feet(system: System, spec: Any, bodies: list[Any], tau: float) -> None:
    """A ball under each contact point, and a piece of ground under it."""
    data = system.model.createData()
    pin.forwardKinematics(system.model, data, system.landing.q)
    ghost = {"contype": 0, "conaffinity": 0}
    for k, (joint, point) in enumerate(system.contact_points()):
        place = data.oMi[joint]
        bodies[joint].add_geom(
            name=f"foot{k}", pos=point + place.rotation.T @ [0.0, 0.0, RADIUS], size=[RADIUS, 0, 0], mass=0.0, **ghost
        )
        ground, height = mujoco.mjtGeom.mjGEOM_PLANE, place.act(point)[2]
        bodies[0].add_geom(name=f"ground{k}", type=ground, size=[0, 0, 1], pos=[0, 0, height], **ghost)
        spec.add_pair(
            geomname1=f"ground{k}", geomname2=f"foot{k}", condim=3, friction=[FRICTION, FRICTION, 0, 0, 0],
            solref=[tau, 100], solimp=[0.9999, 0.9999, 0.001, 0.5, 2],
        )  # fmt: skip


def to_mujoco(robot: Robot, q: Array) -> Array:
    """Pinocchio's q in MuJoCo's layout: quaternions begin with w (as `np.roll` makes them), and every hinge has one number."""
    out: list[Array] = []
    for joint in robot.joints:
        at = q[joint.q]
        if joint.kind in ("free", "ball"):
            at = np.concatenate([at[:-4], np.roll(at[-4:], 1)])
        out.append(np.arctan2(at[1:], at[:1]) if joint.kind == "continuous" else at)
    return np.concatenate(out)


def _compliant(tau: float) -> Method:
    """MuJoCo's contact with a time constant, at two steps in it, the fewest that MuJoCo allows."""
    return Method(f"simulated in MuJoCo, τ = {tau:.0e} s", lambda system: _simulation(system, tau, tau / 2.0), approximates=True)


def _simulation(system: System, tau: float, step: float) -> Prepared:
    """A landing in MuJoCo, until the speed of the contact has decayed: 20 τ."""
    landing = system.landing
    robot, q = landing.robot, landing.q
    if system.G is not None or not landing.floating or landing.loops:
        raise UnsuitedError("MuJoCo is used here for contacts of free robots without loops")
    if any(c.restitution or len(c.directions) != 3 or len(c.moments) for c in landing.contacts):
        raise UnsuitedError("MuJoCo is used here for sticking points without restitution")
    peer = mujoco_model(system, True, tau, step)
    data = mujoco.MjData(peer)
    start, before = to_mujoco(robot, q), system.v.copy()
    before[:3] = pin.Quaternion(q[3:7]).matrix() @ system.v[:3]

    def world_velocities() -> Array:
        """Angular velocity, and velocity of the centre of mass, of every body (nb, 2, 3), world axes."""
        _place(peer, data, data.qpos)
        mujoco.mj_comVel(peer, data)
        return _velocities(peer, data, data.cvel[1:], data.xipos)

    def run() -> Array:
        mujoco.mj_resetData(peer, data)
        data.qpos[:], data.qvel[:] = start, before
        mujoco.mj_step(peer, data, round(20 * tau / step))
        return world_velocities()

    data.qpos[:], data.qvel[:] = start, before
    touching, R = world_velocities(), data.xmat[1:].reshape(-1, 3, 3).copy()

    def read(end: Array) -> Array:
        # In the body axes of the moment of contact: a soft contact lasts until the body has rotated.
        omega, v_com = np.moveaxis((end - touching) @ R, 1, 0)
        return np.hstack([omega, velocity_at(omega, v_com, -robot.coms)])

    return Prepared(run, read)


def _place(peer: Any, data: Any, q: Array) -> None:
    """Put the robot in a posture."""
    data.qpos[:] = q
    mujoco.mj_kinematics(peer, data)
    mujoco.mj_comPos(peer, data)


def _velocities(peer: Any, data: Any, cvel: Array, points: Array) -> Array:
    """Angular velocities, and velocities of a point of every body, (…, nb, 2, 3) in world axes.

    Args:
        peer: the model.
        data: in which the robot is placed.
        cvel: (…, nb, 6) MuJoCo's velocities, at the robot's centre of mass.
        points: (nb + 1, 3) in the world [m]; the first is that of the world's own body.
    """
    omega, v = cvel[..., :3], cvel[..., 3:]
    return np.stack([omega, velocity_at(omega, v, points[1:] - data.subtree_com[peer.body_rootid[1:]])], axis=-2)


def batch_in_mujoco(system: System, Q: Array) -> Prepared:
    """The impulsive equation with MuJoCo's matrices for three strike directions, one posture after another.

    M, the Jacobian of a point and M⁻¹ by MuJoCo's sparse factor; one pass for each direction gives the velocities of all bodies.

    Args:
        system: one sticking point on a free robot.
        Q: (N, nq) postures in Pinocchio's layout.

    Returns: run gives MuJoCo's velocities (N, 3, nb, 6), world axes at the robot's centre of mass; read converts them to maps
    (N, nb, 6, 3).
    """
    ((body, foot),) = system.contact_points()
    peer = mujoco_model(system, False)
    data, nv = mujoco.MjData(peer), peer.nv
    postures = [to_mujoco(system.landing.robot, q) for q in Q]
    J, H_J = np.zeros((3, nv)), np.zeros((3, nv))
    out = np.empty((len(Q), 3, peer.nbody - 1, 6))

    def run() -> Array:
        for k, q in enumerate(postures):
            _place(peer, data, q)
            mujoco.mj_crb(peer, data)
            mujoco.mj_factorM(peer, data)
            point = data.xpos[body] + data.xmat[body].reshape(3, 3) @ foot
            mujoco.mj_jac(peer, data, J, None, point, body)
            mujoco.mj_solveM(peer, data, H_J, J)
            for axis, jump in enumerate(-np.linalg.solve(J @ H_J.T, H_J)):
                data.qvel[:] = jump
                mujoco.mj_comVel(peer, data)
                out[k, axis] = data.cvel[1:]
        return out

    def read(raw: Array) -> Array:
        maps = np.empty((len(Q), peer.nbody - 1, 6, 3))
        for k, q in enumerate(postures):
            _place(peer, data, q)
            turned = _velocities(peer, data, raw[k], data.xpos) @ data.xmat[1:].reshape(-1, 3, 3)
            maps[k] = np.moveaxis(turned.reshape(3, -1, 6), 0, -1)
        return maps

    return Prepared(run, read)


MUJOCO = tuple(_compliant(tau) for tau in (1e-2, 1e-3, 1e-4, 1e-5))
