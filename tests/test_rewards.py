"""The examples of the guide's page on rewards, each with its library's interface, against Pinocchio's
and MuJoCo's numbers.
"""

import importlib.util
import re
from pathlib import Path
from types import SimpleNamespace

import mujoco
import numpy as np
import pytest

import shockpc
from shockpc.core.batched import batched_shock, effective_mass, mitigation

PAGE = Path(shockpc.__file__).parent / "guide" / "rewards.md"
TORCH = importlib.util.find_spec("torch") is not None
MJX = importlib.util.find_spec("jax") is not None and importlib.util.find_spec("mujoco.mjx")
ROBOT = """
<mujoco><option jacobian="dense"/><worldbody><body name="trunk" pos="0 0 1"><freejoint/>
<inertial pos="0.02 0 0.01" mass="8" diaginertia="0.05 0.2 0.22"/>
<body name="imu" pos="0.1 0.05 0.1"><inertial pos="0 0 0" mass="0.01" diaginertia="1e-6 1e-6 1e-6"/></body>
<body name="left" pos="0.2 0.1 0"><joint axis="0 1 0" armature="0.01"/>
<inertial pos="0 0 -0.2" mass="1" diaginertia="0.01 0.01 0.001"/>
<body name="left_foot" pos="0 0 -0.4"><joint axis="1 0 0"/>
<inertial pos="0 0.01 -0.02" mass="0.2" diaginertia="1e-3 1e-3 1e-4"/></body></body>
<body name="right" pos="0.2 -0.1 0"><joint axis="0 1 0" armature="0.01"/>
<inertial pos="0 0 -0.2" mass="1" diaginertia="0.01 0.01 0.001"/>
<body name="right_foot" pos="0 0 -0.4"><joint axis="1 0 0"/>
<inertial pos="0 0.01 -0.02" mass="0.2" diaginertia="1e-3 1e-3 1e-4"/></body></body>
</body></worldbody></mujoco>
"""
FEET, IMU = ("left_foot", "right_foot"), "imu"


def states(n=4):
    """MuJoCo's model, and its data in several states."""
    model, rng = mujoco.MjModel.from_xml_string(ROBOT), np.random.default_rng(3)
    every = []
    for _ in range(n):
        data = mujoco.MjData(model)
        data.qpos[:] = model.qpos0
        data.qpos[7:] += rng.uniform(-0.4, 0.4, 4)
        data.qpos[3:7] += rng.uniform(-0.2, 0.2, 4)
        data.qvel[:] = rng.normal(size=model.nv)
        data.qvel[2] = -2.0
        mujoco.mj_forward(model, data)
        every.append(data)
    return model, every


def arrays(model, every, jacobian=mujoco.mj_jacBody):
    """Inertias, Jacobians of feet and IMU, and velocities, in MuJoCo's coordinates."""
    M, J = [], []
    for data in every:
        columns = np.zeros((model.nv, model.nv))
        for unit, column in zip(np.eye(model.nv), columns, strict=True):
            mujoco.mj_mulM(model, data, column, unit)
        M.append(columns)
        rows = []
        for name in (*FEET, IMU):
            linear, angular = np.zeros((3, model.nv)), np.zeros((3, model.nv))
            jacobian(model, data, linear, angular, model.body(name).id)
            rows.append(np.concatenate([linear, angular]))
        J.append(rows)
    return np.array(M), np.array(J), np.array([data.qvel for data in every])


def penalties(M, J, v, touched):
    """The penalty of the page, by NumPy."""
    speed = np.maximum(np.linalg.norm(J[:, :2] @ v[:, None, :, None], axis=2).max(axis=(1, 2)), 0.1)
    found = batched_shock(np, M, J[:, :2], J[:, 2:], v, contacts=touched, v_in=speed)
    counts = touched.any(-1) & (found.pivot > 3e-4)
    return np.where(counts, -0.05 * np.maximum(found.shock[:, 0] - 0.3, 0.0), 0.0)


TOUCHED = np.array([[True, True], [True, False], [False, True], [False, False]])


def examples(*titles):
    """The functions of some parts of the page."""
    names = {}
    for part in re.split(r"^## ", PAGE.read_text(encoding="utf-8"), flags=re.MULTILINE):
        if part.lstrip("# ").startswith(titles):
            for code in re.findall(r"```python\n(.*?)```", part, re.DOTALL):
                exec(compile(code, "rewards.md", "exec"), names)
    return names


def test_mitigation_and_effective_mass_are_those_of_a_profile():
    """Of each foot alone; the robot of the catalogue with reflected inertia."""
    scene = shockpc.Scene(
        robot="anymal_b",
        contact=shockpc.Contact(frame="LF_FOOT", offset=(0.0, 0.0, 0.0), kind="point"),
        joints=shockpc.Joints(armature={"*": 0.02}),
    )
    profile = shockpc.shock_profile(scene)
    landing = profile.landing
    equation = landing.equation(landing.state)
    M, J = equation.H, equation.J_c[:, None]
    (contact,) = profile.contacts
    assert mitigation(np, M, J)[0, 0] == pytest.approx(contact.mitigation, rel=1e-12)
    sticking = profile.value("effective_mass_sticking", "contact")[0]
    assert effective_mass(np, M, J)[0, 0] == pytest.approx(sticking, rel=1e-12)
    sliding = profile.value("effective_mass_frictionless", "contact")[0]
    assert effective_mass(np, M, J[:, :, 2:])[0, 0] == pytest.approx(sliding, rel=1e-12)


def test_numbers_of_16_bits_are_computed_with_in_32():
    M, J, v = arrays(*states())
    exact = batched_shock(np, M, J[:, :2, :3], J[:, 2:, :3], v)
    short = (part.astype(np.float16) for part in (M, J[:, :2, :3], J[:, 2:, :3], v))
    found = batched_shock(np, *short)
    assert found.shock.dtype == np.float32
    np.testing.assert_allclose(found.shock, exact.shock, rtol=0.05)


@pytest.mark.parametrize("step", [1e-4, 1e-3, 1e-2])
def test_the_impulse_does_not_depend_on_the_time_step(step):
    """A simulator's contact force, summed over its time steps until the feet rest, is the impulse.

    The contact is a damper f = -c J v, integrated by the implicit Euler method, for which
    (M + step c J^T J) v_next = M v.
    """
    M, J, v = arrays(*states())
    impulse = batched_shock(np, M, J[:, :2, :3], J[:, 2:, :3], v).impulse
    c = 1e7
    J_c = J[:, :2, :3].reshape(len(M), 6, -1)
    summed = np.zeros((len(M), 6))
    for _ in range(50):
        v = np.linalg.solve(M + step * c * J_c.mT @ J_c, M @ v[..., None])[..., 0]
        force = -c * (J_c @ v[..., None])[..., 0]
        summed += step * force
    np.testing.assert_allclose(summed, impulse.reshape(len(M), 6), rtol=1e-6)


@pytest.mark.skipif(not TORCH, reason="PyTorch is not installed")
@pytest.mark.parametrize("kind", ["float16", "bfloat16"])
def test_tensors_of_16_bits_are_computed_with_in_32(kind):
    import torch

    import shockpc.torch

    M, J, v = arrays(*states())
    exact = batched_shock(np, M, J[:, :2, :3], J[:, 2:, :3], v)
    short = (
        torch.tensor(part).to(getattr(torch, kind)) for part in (M, J[:, :2, :3], J[:, 2:, :3], v)
    )
    found = shockpc.torch.shock(*short)
    assert found.shock.dtype == torch.float32
    np.testing.assert_allclose(found.shock.numpy(), exact.shock, rtol=0.05)


@pytest.mark.skipif(not TORCH, reason="PyTorch is not installed")
def test_the_reward_of_isaac_lab():
    """Jacobians of centres of mass and velocities in world axes, as PhysX has them."""
    import torch

    names = examples("Rewards", "Isaac Lab")
    model, every = states()
    M, J, v = arrays(model, every)
    # PhysX: the velocity of the base is that of its centre of mass, and its rotation in world axes.
    to_physx = []
    for data in every:
        R = data.body("trunk").xmat.reshape(3, 3)
        c = data.body("trunk").xipos - data.body("trunk").xpos
        cross = np.array([[0, -c[2], c[1]], [c[2], 0, -c[0]], [-c[1], c[0], 0]])
        T = np.eye(model.nv)
        T[:3, 3:6] = -cross @ R
        T[3:6, 3:6] = R
        to_physx.append(T)
    T = np.array(to_physx)
    of_coms = arrays(model, every, mujoco.mj_jacBodyCom)[1] @ np.linalg.inv(T)[:, None]
    inertia = np.linalg.inv(T).transpose(0, 2, 1) @ M @ np.linalg.inv(T)
    velocity = (T @ v[..., None])[..., 0]
    # The penalty is the same in all coordinates, so the stub's velocity is compared by itself.
    trunk = model.body("trunk").id
    for data, moved in zip(every, velocity, strict=True):
        J_com = np.zeros((3, model.nv))
        mujoco.mj_jacBodyCom(model, data, J_com, None, trunk)
        np.testing.assert_allclose(moved[:3], J_com @ data.qvel, rtol=1e-12, atol=1e-12)
    bodies = [model.body(name).id for name in (*FEET, IMU)]
    jacobians = np.zeros((len(every), model.nbody, 6, model.nv))
    jacobians[:, bodies] = of_coms
    view = SimpleNamespace(
        get_jacobians=lambda: torch.tensor(jacobians),
        get_generalized_mass_matrices=lambda: torch.tensor(inertia),
    )
    data = SimpleNamespace(
        body_link_pos_w=torch.tensor(np.array([one.xpos for one in every])),
        body_com_pos_w=torch.tensor(np.array([one.xipos for one in every])),
        root_com_lin_vel_w=torch.tensor(velocity[:, :3]),
        root_com_ang_vel_w=torch.tensor(velocity[:, 3:6]),
        joint_vel=torch.tensor(velocity[:, 6:]),
    )
    env = SimpleNamespace(scene={"robot": SimpleNamespace(data=data, root_physx_view=view)})
    found = names["isaac_lab_shock"](
        env, SimpleNamespace(name="robot"), bodies[:2], bodies[2], torch.tensor(TOUCHED)
    )
    np.testing.assert_allclose(found.numpy(), penalties(M, J[..., :3, :], v, TOUCHED), rtol=1e-9)


@pytest.mark.skipif(not TORCH, reason="PyTorch is not installed")
def test_the_reward_of_mjlab():
    """Twists about the centre of mass of the tree, as MuJoCo Warp has them."""
    import torch

    names = examples("Rewards", "mjlab")
    model, every = states()
    M, J, v = arrays(model, every)
    bodies = [model.body(name).id for name in (*FEET, IMU)]
    moves = np.zeros((3, model.nv), dtype=bool)
    for row, body in enumerate(bodies):
        while body:
            first = model.body_dofadr[body]
            moves[row, first : first + model.body_dofnum[body]] |= model.body_dofnum[body] > 0
            body = model.body_parentid[body]
    data = SimpleNamespace(
        xpos=torch.tensor(np.array([one.xpos for one in every])),
        subtree_com=torch.tensor(np.array([one.subtree_com for one in every])),
        cdof=torch.tensor(np.array([one.cdof for one in every])),
        qM=torch.tensor(M),
        qvel=torch.tensor(v),
    )
    env = SimpleNamespace(sim=SimpleNamespace(data=data))
    found = names["mjlab_shock"](
        env, None, bodies[:2], bodies[2], torch.tensor(moves), torch.tensor(TOUCHED)
    )
    np.testing.assert_allclose(found.numpy(), penalties(M, J[..., :3, :], v, TOUCHED), rtol=1e-9)


@pytest.mark.skipif(not MJX, reason="MJX is not installed")
def test_the_reward_of_mjx_under_jit():
    import jax
    from mujoco import mjx

    jax.config.update("jax_enable_x64", True)
    penalty = examples("MJX")["mjx_shock"]
    model, every = states()
    M, J, v = arrays(model, every)
    bodies = [model.body(name).id for name in (*FEET, IMU)]
    compiled = mjx.put_model(model)

    @jax.jit
    def computed(data, touched):
        return penalty(compiled, data, bodies[:2], bodies[2], touched)

    expected = penalties(M, J[..., :3, :], v, TOUCHED)
    for one, touched, value in zip(every, TOUCHED, expected, strict=True):
        assert float(computed(mjx.put_data(model, one), touched)) == pytest.approx(value, rel=1e-9)
