"""MuJoCo on the same landing: simulated with its compliant contact, or the impulsive equation solved with its own matrices."""

from typing import Any

import numpy as np
import pinocchio as pin

from shockpc.bench.methods import Method, Prepared
from shockpc.bench.system import System, UnsuitedError
from shockpc.core.spatial import Array, velocity_at
from shockpc.errors import RobotError

__all__ = ["MUJOCO", "batch_in_mujoco", "mujoco_model", "to_mujoco"]

FRICTION = 100.0
"""Coefficient at which every contact sticks."""


def mujoco_model(model: pin.Model, feet: list[tuple[int, Array]], q: Array, tau: float, step: float) -> Any:
    """Write a Pinocchio model as MuJoCo's, with a small ball under each foot and a piece of ground under each ball; no gravity.

    Args:
        model: joints of one degree of freedom, ball joints, and a free base; numbered depth first, as every reader does, so that
            a body has the same number in both.
        feet: joint and point in its frame of each contact.
        q: posture in which every ball just touches its ground.
        tau: time constant of the contact [s].
        step: of the integration [s].

    Raises:
        UnsuitedError: MuJoCo is not installed, or has no such joint.
        RobotError: MuJoCo refuses the model.
    """
    try:
        import mujoco
    except ImportError:
        raise UnsuitedError('MuJoCo is not installed; pip install "shockpc[bench]"') from None
    data = model.createData()
    pin.forwardKinematics(model, data, q)
    grounds, pairs = [], []
    for k, (joint, point) in enumerate(feet):
        height = float(data.oMi[joint].act(point)[2])
        grounds.append(f'<geom name="ground{k}" type="plane" size="0 0 1" pos="0 0 {height!r}" contype="0" conaffinity="0"/>')
        pairs.append(
            f'<pair geom1="ground{k}" geom2="foot{k}" condim="3" friction="{FRICTION} {FRICTION} 0 0 0" '
            f'solref="{tau!r} 100" solimp="0.9999 0.9999 0.001 0.5 2"/>'
        )
    bodies = _body(model, data, 1, feet)
    text = (
        '<mujoco><compiler angle="radian" autolimits="false" boundmass="0" boundinertia="0" balanceinertia="false"/>'
        f'<option timestep="{step!r}" gravity="0 0 0" cone="elliptic" solver="Newton" tolerance="1e-12" iterations="200"/>'
        f"<worldbody>{''.join(grounds)}{bodies}</worldbody><contact>{''.join(pairs)}</contact></mujoco>"
    )
    try:
        return mujoco.MjModel.from_xml_string(text)
    except ValueError as refusal:
        raise RobotError(f"MuJoCo refuses the model: {str(refusal).strip().splitlines()[0]}") from None


def _numbers(values: Any) -> str:
    return " ".join(repr(float(value)) for value in values)


def _body(model: pin.Model, data: pin.Data, joint: int, feet: list[tuple[int, Array]]) -> str:
    """A body and all that hang on it."""
    place, own = model.jointPlacements[joint], model.inertias[joint]
    x, y, z, w = pin.Quaternion(place.rotation).coeffs()
    I = own.inertia  # noqa: E741 - the field's own symbol
    full = _numbers((I[0, 0], I[1, 1], I[2, 2], I[0, 1], I[0, 2], I[1, 2]))
    parts = [
        f'<body pos="{_numbers(place.translation)}" quat="{_numbers((w, x, y, z))}">',
        _joint(model, joint),
        f'<inertial pos="{_numbers(own.lever)}" mass="{float(own.mass)!r}" fullinertia="{full}"/>',
    ]
    for k, (at, point) in enumerate(feet):
        if at == joint:
            radius = 0.01
            centre = point + data.oMi[joint].rotation.T @ np.array([0.0, 0.0, radius])
            shape = f'type="sphere" size="{radius}" mass="0" contype="0" conaffinity="0"'
            parts.append(f'<geom name="foot{k}" pos="{_numbers(centre)}" {shape}/>')
    parts += [_body(model, data, child, feet) for child in range(1, model.njoints) if model.parents[child] == joint]
    return "".join([*parts, "</body>"])


def _joint(model: pin.Model, joint: int) -> str:
    """A joint in MuJoCo's words."""
    found = model.joints[joint]
    kind = found.shortname()
    if kind == "JointModelFreeFlyer":
        return "<freejoint/>"
    if kind == "JointModelSpherical":
        return '<joint type="ball"/>'
    if found.nv != 1:
        raise UnsuitedError(f"{kind} is not written for MuJoCo here")
    data = found.createData()
    found.calc(data, np.zeros(found.idx_q + found.nq), np.zeros(found.idx_v + 1))
    twist = np.asarray(data.S).ravel()
    turns = bool(twist[3:].any())
    armature = float(model.armature[found.idx_v])
    axis = _numbers(twist[3:] if turns else twist[:3])
    return f'<joint type="{"hinge" if turns else "slide"}" axis="{axis}" armature="{armature!r}"/>'


def to_mujoco(model: pin.Model, q: Array) -> Array:
    """Pinocchio's q in MuJoCo's layout: quaternions begin with w, and every hinge has one number."""
    out: list[float] = []
    for joint in list(model.joints)[1:]:
        at = q[joint.idx_q : joint.idx_q + joint.nq]
        if joint.nq == 7:
            out += [*at[:3], at[6], *at[3:6]]
        elif joint.nq == 4:
            out += [at[3], *at[:3]]
        elif joint.nq == 2:
            out.append(float(np.arctan2(at[1], at[0])))
        else:
            out += [*at]
    return np.array(out)


def _compliant(tau: float) -> Method:
    """MuJoCo's contact with a time constant, at two steps in it, the fewest that MuJoCo allows."""
    return Method(f"simulated in MuJoCo, τ = {tau:.0e} s", lambda system: _simulation(system, tau, tau / 2.0), simulates=True)


def _simulation(system: System, tau: float, step: float) -> Prepared:
    """A landing in MuJoCo, until the speed of the contact has decayed: 20 τ."""
    scene, robot, touches = system.scene, system.robot, system.landing.contacts
    if system.G is not None or not robot.free_base or robot.loops or scene.closure or scene.stance:
        raise UnsuitedError("MuJoCo is used here for contacts of free robots without loops")
    if any(t.restitution or len(t.directions) != 3 or len(t.moments) for t in touches):
        raise UnsuitedError("MuJoCo is used here for sticking points without restitution")
    bodies = [robot.bodies[touch.body] for touch in touches]
    feet = [(body.joint, body.offset + body.rotation @ t.point) for body, t in zip(bodies, touches, strict=True)]
    q = system.landing.q
    peer = mujoco_model(system.model, feet, q, tau, step)
    import mujoco

    data, com = mujoco.MjData(peer), robot.coms
    start, before = to_mujoco(system.model, q), system.v.copy()
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
    touch = system.landing.contacts[0]
    peer = mujoco_model(system.model, [], system.landing.q, 1.0, 1.0)
    import mujoco

    data, nv = mujoco.MjData(peer), peer.nv
    postures = [to_mujoco(system.model, q) for q in Q]
    J, H_J = np.zeros((3, nv)), np.zeros((3, nv))
    out = np.empty((len(Q), 3, peer.nbody - 1, 6))
    body = system.robot.bodies[touch.body].joint

    def place(q: Array) -> None:
        data.qpos[:] = q
        mujoco.mj_kinematics(peer, data)
        mujoco.mj_comPos(peer, data)

    def run() -> Array:
        for k, q in enumerate(postures):
            place(q)
            mujoco.mj_crb(peer, data)
            mujoco.mj_factorM(peer, data)
            point = data.xpos[body] + data.xmat[body].reshape(3, 3) @ touch.point
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
