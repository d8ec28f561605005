"""MuJoCo on the same landing: simulated with its compliant contact, or the impulsive equation solved with its own matrices."""

from collections import defaultdict
from typing import Any

import numpy as np
import pinocchio as pin

from shockpc.bench.methods import Method, Prepared
from shockpc.bench.system import System, UnsuitedError
from shockpc.core.spatial import Array, velocity_at
from shockpc.robot.robot import Robot

__all__ = ["MUJOCO", "batch_in_mujoco", "mujoco_model", "to_mujoco"]

FRICTION = 100.0
"""Coefficient at which every contact sticks."""

RADIUS = 0.01
"""Of the balls under the contact points [m]."""


def mujoco_model(system: System, feet: bool, tau: float = 1.0, step: float = 1.0) -> Any:
    """Write a robot as MuJoCo's model, without gravity.

    Args:
        system: a robot with joints of one degree of freedom, ball joints and a free base; numbered depth first, as every reader
            does, so that a body has the same number in both.
        feet: whether to put a small ball under each contact point, and a piece of ground under each ball that it just touches.
        tau: time constant of the contact [s].
        step: of the integration [s].

    Raises:
        UnsuitedError: MuJoCo is not installed, has no such joint, or refuses the model.
    """
    try:
        import mujoco
    except ImportError:
        raise UnsuitedError('MuJoCo is not installed; pip install "shockpc[bench]"') from None
    model, data, soles, grounds, pairs = system.model, system.model.createData(), defaultdict(list), "", ""
    pin.forwardKinematics(model, data, system.landing.q)
    for k, (joint, point) in enumerate(system.contact_points() if feet else ()):
        place, ghost = data.oMi[joint], 'contype="0" conaffinity="0"'
        centre = _numbers(point + place.rotation.T @ [0.0, 0.0, RADIUS])
        soles[joint].append(f'<geom name="foot{k}" pos="{centre}" type="sphere" size="{RADIUS}" mass="0" {ghost}/>')
        height = f"0 0 {float(place.act(point)[2])!r}"
        grounds += f'<geom name="ground{k}" type="plane" size="0 0 1" pos="{height}" {ghost}/>'
        pairs += (
            f'<pair geom1="ground{k}" geom2="foot{k}" condim="3" friction="{FRICTION} {FRICTION} 0 0 0" '
            f'solref="{tau!r} 100" solimp="0.9999 0.9999 0.001 0.5 2"/>'
        )

    def body(i: int) -> str:
        own, place = model.inertias[i], model.jointPlacements[i]
        x, y, z, w = pin.Quaternion(place.rotation).coeffs()
        moments = own.inertia[(0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)]
        return (
            f'<body pos="{_numbers(place.translation)}" quat="{_numbers((w, x, y, z))}">{_joint(system, i - 1)}'
            f'<inertial pos="{_numbers(own.lever)}" mass="{float(own.mass)!r}" fullinertia="{_numbers(moments)}"/>'
            f"{''.join(soles[i])}{''.join(body(k) for k in range(i + 1, model.njoints) if model.parents[k] == i)}</body>"
        )

    text = (
        '<mujoco><compiler angle="radian" autolimits="false" boundmass="0" boundinertia="0" balanceinertia="false"/>'
        f'<option timestep="{step!r}" gravity="0 0 0" cone="elliptic" solver="Newton" tolerance="1e-12" iterations="200"/>'
        f"<worldbody>{grounds}{body(1)}</worldbody><contact>{pairs}</contact></mujoco>"
    )
    try:
        return mujoco.MjModel.from_xml_string(text)
    except ValueError as refusal:
        raise UnsuitedError(f"MuJoCo refuses the model: {str(refusal).strip().splitlines()[0]}") from None


def _numbers(values: Any) -> str:
    """Numbers with all digits."""
    return " ".join(repr(float(value)) for value in values)


def _joint(system: System, body: int) -> str:
    """The joint of a body as MJCF."""
    joint = system.landing.robot.joints[body]
    if joint.axis is None:
        if joint.kind not in ("free", "ball"):
            raise UnsuitedError(f"{joint.kind} joints are not written for MuJoCo here")
        return "<freejoint/>" if joint.kind == "free" else '<joint type="ball"/>'
    kind, armature = "slide" if joint.kind == "prismatic" else "hinge", float(system.model.armature[joint.v.start])
    return f'<joint type="{kind}" axis="{_numbers(joint.axis)}" armature="{armature!r}"/>'


def to_mujoco(robot: Robot, q: Array) -> Array:
    """Pinocchio's q in MuJoCo's layout: quaternions begin with w, and every hinge has one number."""
    out: list[float] = []
    for joint in robot.joints:
        at = q[joint.q].tolist()
        if joint.kind in ("free", "ball"):
            at = [*at[:-4], at[-1], *at[-4:-1]]
        out += [float(np.arctan2(at[1], at[0]))] if joint.kind == "continuous" else [*at]
    return np.array(out)


def _compliant(tau: float) -> Method:
    """MuJoCo's contact with a time constant, at two steps in it, the fewest that MuJoCo allows."""
    return Method(f"simulated in MuJoCo, τ = {tau:.0e} s", lambda system: _simulation(system, tau, tau / 2.0), simulates=True)


def _simulation(system: System, tau: float, step: float) -> Prepared:
    """A landing in MuJoCo, until the speed of the contact has decayed: 20 τ."""
    landing = system.landing
    robot, q = landing.robot, landing.q
    if system.G is not None or not landing.floating or landing.loops:
        raise UnsuitedError("MuJoCo is used here for contacts of free robots without loops")
    if any(c.restitution or len(c.directions) != 3 or len(c.moments) for c in landing.contacts):
        raise UnsuitedError("MuJoCo is used here for sticking points without restitution")
    peer = mujoco_model(system, True, tau, step)
    import mujoco

    data, com = mujoco.MjData(peer), robot.coms
    start, before = to_mujoco(robot, q), system.v.copy()
    before[:3] = pin.Quaternion(q[3:7]).matrix() @ system.v[:3]

    def world_velocities() -> Array:
        """Angular velocity, and velocity of the centre of mass, of every body (nb, 2, 3), world axes."""
        mujoco.mj_kinematics(peer, data)
        mujoco.mj_comPos(peer, data)
        mujoco.mj_comVel(peer, data)
        omega, v = data.cvel[1:, :3], data.cvel[1:, 3:]
        return np.stack([omega, velocity_at(omega, v, data.xipos[1:] - data.subtree_com[peer.body_rootid[1:]])], axis=1)

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
        return np.hstack([omega, velocity_at(omega, v_com, -com)])

    return Prepared(run, read)


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
    import mujoco

    data, nv = mujoco.MjData(peer), peer.nv
    postures = [to_mujoco(system.landing.robot, q) for q in Q]
    J, H_J = np.zeros((3, nv)), np.zeros((3, nv))
    out = np.empty((len(Q), 3, peer.nbody - 1, 6))

    def place(q: Array) -> None:
        data.qpos[:] = q
        mujoco.mj_kinematics(peer, data)
        mujoco.mj_comPos(peer, data)

    def run() -> Array:
        for k, q in enumerate(postures):
            place(q)
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
            place(q)
            R = data.xmat[1:].reshape(-1, 3, 3)
            omega, v = raw[k, ..., :3], raw[k, ..., 3:]
            v = v + np.cross(omega, data.xpos[1:] - data.subtree_com[peer.body_rootid[1:]])
            maps[k] = np.concatenate([np.einsum("bji,abj->bia", R, omega), np.einsum("bji,abj->bia", R, v)], axis=1)
        return maps

    return Prepared(run, read)


MUJOCO = tuple(_compliant(tau) for tau in (1e-2, 1e-3, 1e-4, 1e-5))
