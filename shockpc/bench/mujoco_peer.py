"""MuJoCo beside us: the same robot written as its own model, landing on its compliant contact, or solved with its own matrices."""

from typing import Any

import numpy as np
import pinocchio as pin

from shockpc.bench.methods import Method, Prepared
from shockpc.bench.system import System, Unsuited, jumps_between, moving, velocity_at_impact
from shockpc.core.spatial import Array
from shockpc.errors import RobotError

__all__ = ["MUJOCO", "batch_in_mujoco", "mujoco_model", "to_mujoco", "to_pinocchio"]

FRICTION = 100.0
"""So much that a contact sticks."""


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
        Unsuited: MuJoCo is not installed, or has no such joint.
        RobotError: MuJoCo refuses the model.
    """
    try:
        import mujoco
    except ImportError:
        raise Unsuited('MuJoCo is not installed; pip install "shockpc[bench]"') from None
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
        raise Unsuited(f"{kind} is not written for MuJoCo here")
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


def to_pinocchio(model: pin.Model, qpos: Array, qvel: Array) -> tuple[Array, Array]:
    """MuJoCo's posture and velocity in Pinocchio's layout, where a free base's linear velocity has the base's axes of now."""
    q: list[float] = []
    v, at = np.array(qvel), 0
    for joint in list(model.joints)[1:]:
        n = {4: 4, 7: 7}.get(joint.nq, 1)
        own, at = qpos[at : at + n], at + n
        if n > 1:
            q += [*own[:-4], *own[-3:], own[-4]]
        elif joint.nq == 2:
            q += [np.cos(own[0]), np.sin(own[0])]
        else:
            q += [*own]
        if n == 7:
            linear = slice(joint.idx_v, joint.idx_v + 3)
            v[linear] = pin.Quaternion(np.array(q[-4:])).matrix().T @ v[linear]
    return np.array(q), v


def _compliant(tau: float, per_tau: int) -> Method:
    """MuJoCo's contact of one time constant, integrated with so many steps in each."""

    def prepare(system: System) -> Prepared:
        return _land_with(system, tau, tau / per_tau)

    name = f"simulated in MuJoCo, τ = {tau:.0e} s, {per_tau} steps in τ"
    return Method(name, "MuJoCo's compliant contact, viscous, friction that sticks", prepare, "simulation")


def _land_with(system: System, tau: float, step: float) -> Prepared:
    """A landing in MuJoCo: from the touch until the contact's speed has died away, 20 τ."""
    scene, robot = system.scene, system.robot
    blocks = system.landing.rows.blocks
    if system.G is not None or not robot.free_base or robot.loops or scene.closure or scene.stance:
        raise Unsuited("MuJoCo is used here for feet of free robots without loops")
    if any(block.restitution for block in blocks) or any(len(t.directions) != 3 or len(t.turns) for t in system.landing.touches):
        raise Unsuited("MuJoCo is used here for sticking points without restitution")
    feet = [
        (robot.bodies[t.body].joint, robot.bodies[t.body].offset + robot.bodies[t.body].rotation @ t.point)
        for t in system.landing.touches
    ]
    q, before = system.landing.q, velocity_at_impact(system)
    peer = mujoco_model(system.model, feet, q, tau, step)
    import mujoco

    data = mujoco.MjData(peer)
    start, touching = to_mujoco(system.model, q), moving(system, q, before)
    v0 = before.copy()
    v0[:3] = pin.Quaternion(q[3:7]).matrix() @ before[:3]
    steps = round(20 * tau / step)

    def run() -> Any:
        mujoco.mj_resetData(peer, data)
        data.qpos[:], data.qvel[:] = start, v0
        for _ in range(steps):
            mujoco.mj_step(peer, data)
        return moving(system, *to_pinocchio(system.model, data.qpos, data.qvel))

    def read(end: Any) -> Array:
        return jumps_between(system, touching, end)

    return Prepared(run, read)


def batch_in_mujoco(system: System, Q: Array) -> Prepared:
    """The impulsive equation with MuJoCo's matrices: M, a point's Jacobian, M⁻¹ by its sparse factor, one posture after another.

    Args:
        system: one sticking point on a free robot.
        Q: (N, nq) postures in Pinocchio's layout.

    Returns: run gives MuJoCo's own velocities (N, nb, 6), world axes at the robot's centre of mass; read turns them into body axes
    at the joints' frames.
    """
    touch = system.landing.touches[0]
    peer = mujoco_model(system.model, [], system.landing.q, 1.0, 1.0)
    import mujoco

    data, v_in, nv = mujoco.MjData(peer), system.landing.before.velocity, peer.nv
    postures = [to_mujoco(system.model, q) for q in Q]
    J, H_J = np.zeros((3, nv)), np.zeros((3, nv))
    out = np.empty((len(Q), peer.nbody - 1, 6))
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
            data.qvel[:] = H_J.T @ np.linalg.solve(J @ H_J.T, -v_in)
            mujoco.mj_comVel(peer, data)
            out[k] = data.cvel[1:]
        return out

    def read(raw: Array) -> Array:
        jumps = np.empty_like(raw)
        for k, q in enumerate(postures):
            place(q)
            R = data.xmat[1:].reshape(-1, 3, 3)
            omega, v = raw[k, :, :3], raw[k, :, 3:]
            v = v + np.cross(omega, data.xpos[1:] - data.subtree_com[peer.body_rootid[1:]])
            jumps[k] = np.concatenate([np.einsum("bji,bj->bi", R, omega), np.einsum("bji,bj->bi", R, v)], axis=1)
        return jumps

    return Prepared(run, read)


MUJOCO = tuple(_compliant(tau, per_tau) for per_tau in (2, 10) for tau in (1e-2, 1e-3, 1e-4, 1e-5))
"""Two steps in τ is the least that MuJoCo allows."""
