"""The relations that the page of the notation states, between the paper, Pinocchio, MuJoCo and this
package.
"""

import re
from pathlib import Path

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from trees import known_robot

import shockpc
from shockpc import Contact, Scene, Strike, shock_profile

PAGE = Path(shockpc.__file__).parent / "guide" / "notation.md"

HOPPER = """<mujoco><worldbody><body name="base" pos="0 0 1"><freejoint/>
  <inertial pos="0.1 0.02 0.03" mass="3" fullinertia="0.1 0.2 0.25 0.01 0.02 0.03"/>
  <body name="leg" pos="0.1 0.2 -0.1"><joint name="hip" axis="0 1 0" armature="0.05"/>
    <inertial pos="0 0.01 -0.2" mass="1" diaginertia="0.02 0.02 0.001"/>
    <site name="foot" pos="0.02 0 -0.4"/></body></body></worldbody></mujoco>"""

QPOS = np.array([0.3, -0.2, 0.7, 0.5, 0.1, -0.7, 0.5, 0.6])
QVEL = np.array([0.3, -0.4, -1.0, 0.2, 0.7, -0.5, 1.5])


@pytest.fixture(scope="module")
def slanted():
    """A landing in which nothing is symmetric by accident."""
    return shock_profile(
        Scene(
            robot="anymal_b",
            contact=Contact(frame="LF_FOOT", at="frame", kind="point"),
            strike=Strike(velocity=(0.3, -0.1, -1.0), angular_velocity=(0.2, 0.1, -0.3)),
        ),
        known_robot("anymal_b"),
    )


@pytest.fixture
def hopper(tmp_path):
    """A robot of this package, and MuJoCo's model with its data, in the same posture."""
    file = tmp_path / "hopper.xml"
    file.write_text(HOPPER)
    robot = shockpc.load_robot(str(file))
    model = mujoco.MjModel.from_xml_string(HOPPER)
    data = mujoco.MjData(model)
    data.qpos[:] = QPOS
    mujoco.mj_normalizeQuat(model, data.qpos)
    mujoco.mj_forward(model, data)
    return robot, model, data


def rotation_of_velocities(q, nv):
    """T with v_pinocchio = T v_mujoco."""
    T = np.eye(nv)
    T[:3, :3] = pin.Quaternion(q[3:7]).toRotationMatrix().T
    return T


def test_the_page_names_tests_that_exist():
    """And it names every one of these."""
    named = set(re.findall(r"\| `(test_\w+)` \|$", PAGE.read_text(encoding="utf-8"), re.MULTILINE))
    defined = {name for name in globals() if name.startswith("test_")}
    assert named == defined - {"test_the_page_names_tests_that_exist"}


def test_eq_4_of_the_paper_has_the_same_jump(slanted):
    """[H J; Jᵀ 0] [q̇⁺; ρ] = [H q̇⁻; 0] with J = J_cᵀ: Δq̇ = q̇⁺ − q̇⁻ and λ = −ρ."""
    landing = slanted.landing
    model, q = slanted.robot.model, slanted.q
    H = pin.crba(model, model.createData(), q)
    H = np.triu(H) + np.triu(H, 1).T
    H += np.diag(landing.joint_model.armature - model.armature)
    frame = model.getFrameId("LF_FOOT")
    J_c = pin.computeFrameJacobian(model, model.createData(), q, frame, pin.LOCAL_WORLD_ALIGNED)[:3]
    R = pin.Quaternion(q[3:7]).toRotationMatrix()
    before = np.zeros(model.nv)
    before[:3] = R.T @ (0.3, -0.1, -1.0)
    before[3:6] = R.T @ (0.2, 0.1, -0.3)

    whole = np.block([[H, J_c.T], [J_c, np.zeros((3, 3))]])
    after, rho = np.split(np.linalg.solve(whole, np.r_[H @ before, np.zeros(3)]), [model.nv])
    np.testing.assert_allclose(after - before, slanted.delta_qd, rtol=0, atol=1e-10)
    np.testing.assert_allclose(-rho, slanted.contacts[0].impulse, rtol=0, atol=1e-10)
    np.testing.assert_allclose(J_c @ after, 0.0, atol=1e-12)
    assert slanted.contacts[0].impulse[2] > 0.0


def test_eq_9_holds_in_the_axes_of_the_bodies_too(slanted):
    """Δv̂_i = ⁱX_λ(i) Δv̂_λ(i) + S_i Δq̇_i by Pinocchio, whose vectors begin with the linear part, is
    what the sum about one origin in world axes gave.
    """
    model = slanted.robot.model
    data = model.createData()
    pin.forwardKinematics(model, data, slanted.q)
    jumps = [pin.Motion.Zero()]
    for i in range(1, model.njoints):
        joint = model.joints[i]
        columns = slice(joint.idx_v, joint.idx_v + joint.nv)
        X = data.liMi[i].inverse()
        S = np.reshape(data.joints[i].S, (6, joint.nv))
        jumps.append(X.act(jumps[model.parents[i]]) + pin.Motion(S @ slanted.delta_qd[columns]))
    linear = [jump.linear for jump in jumps[1:]]
    angular = [jump.angular for jump in jumps[1:]]
    np.testing.assert_allclose(linear, slanted.delta_v, rtol=0, atol=1e-12)
    np.testing.assert_allclose(angular, slanted.delta_omega, rtol=0, atol=1e-12)


def test_eqs_11_and_12_are_those_of_the_paper():
    """The centre is p = (−Δv_y, Δv_x) / Δω_z, the radius the absolute value of r_p = v_in / Δω_z,
    and the shock at a point r / r_p.
    """
    profile = shock_profile(
        Scene(
            robot="quadruped",
            contact="hind_foot",
            plane="xz",
            strike=Strike(strike_angle_deg=20.0),
        )
    )
    # The axes x and z of the page, and the normal of the pair, which points to the right: −y.
    for i in range(len(profile.bodies)):
        v_x, _, v_z = profile.rotation[i] @ profile.delta_v[i]
        spin = -(profile.rotation[i] @ profile.delta_omega[i])[1]
        p = np.array([-v_z, v_x]) / spin
        copc = (profile.rotation[i] @ profile.copc[i])[[0, 2]]
        np.testing.assert_allclose(copc, p, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(profile.ropc[i], abs(profile.v_in / spin), rtol=1e-9)
        shock = profile.shock_at(profile.bodies[i], np.zeros(3))
        np.testing.assert_allclose(shock, np.linalg.norm(p) / profile.ropc[i], rtol=1e-9)


def test_quaternions_of_mujoco_begin_with_w(hopper):
    robot, _, data = hopper
    q = shockpc.configuration_from_mujoco(robot, data.qpos)
    w, x, y, z = data.qpos[3:7]
    np.testing.assert_allclose(q[:7], [*QPOS[:3], x, y, z, w], atol=1e-15)
    base = {"base": data.qpos[:7], "joints": {"hip": QPOS[7]}}
    np.testing.assert_allclose(
        shockpc.configuration(robot, **base, quaternion="wxyz"), q, atol=1e-15
    )
    placed = robot.model.createData()
    pin.forwardKinematics(robot.model, placed, q)
    np.testing.assert_allclose(
        placed.oMi[1].rotation, data.body("base").xmat.reshape(3, 3), atol=1e-14
    )


def test_the_velocity_of_a_floating_base_in_three_libraries(hopper):
    """A foot has the same velocity in world axes."""
    robot, model, data = hopper
    q = shockpc.configuration_from_mujoco(robot, data.qpos)
    T = rotation_of_velocities(q, model.nv)
    J_mujoco = np.zeros((3, model.nv))
    mujoco.mj_jacSite(model, data, J_mujoco, None, model.site("foot").id)
    frame = robot.model.getFrameId("foot")
    J_pinocchio = pin.computeFrameJacobian(
        robot.model, robot.model.createData(), q, frame, pin.LOCAL_WORLD_ALIGNED
    )[:3]
    np.testing.assert_allclose(J_mujoco, J_pinocchio @ T, atol=1e-14)

    turned = pin.Quaternion(q[3:7]).toRotationMatrix()
    strike = Strike(
        velocity=tuple(QVEL[:3]),
        angular_velocity=tuple(turned @ QVEL[3:6]),
        joint_velocities={"hip": QVEL[6]},
    )
    posture = shockpc.Posture(
        base_position=tuple(q[:3]), base_quaternion=tuple(q[3:7]), joints={"hip": q[7]}
    )
    contact = Contact(frame="foot", at="frame", kind="point")
    scene = Scene(robot=str(robot.source.path), posture=posture, strike=strike, contact=contact)
    profile = shock_profile(scene, robot)
    np.testing.assert_allclose(profile.approach[0], J_mujoco @ QVEL, rtol=0, atol=1e-13)


def test_all_three_add_the_armature_to_the_inertia(hopper):
    robot, model, data = hopper
    q = shockpc.configuration_from_mujoco(robot, data.qpos)
    T = rotation_of_velocities(q, model.nv)
    H_mujoco = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, H_mujoco)
    H = pin.crba(robot.model, robot.model.createData(), q)
    H = np.triu(H) + np.triu(H, 1).T
    np.testing.assert_allclose(H_mujoco, T.T @ H @ T, atol=1e-13)
    assert model.dof_armature[6] == robot.model.armature[6] == 0.05
