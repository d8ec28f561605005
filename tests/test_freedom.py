"""What is free to move: bases, and joints that follow others, as columns of G (Eq. 7) and as rows of a closure."""

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st
from trees import known_robot, robot_from

from shockpc.core.impulse import solve_impact
from shockpc.errors import SceneError
from shockpc.landing import complete, resolve
from shockpc.model.contact import Contact
from shockpc.model.equation import impulsive_equation, solve
from shockpc.model.joint_model import Joints
from shockpc.model.posture import Posture
from shockpc.profile import shock_profile
from shockpc.scene import Scene, Strike

TURNED = Posture(base_rpy_deg=(10.0, -20.0, 30.0))


def link(name):
    return (
        f'<link name="{name}"><inertial><origin xyz="0.02 0.03 0.1"/><mass value="1.5"/>'
        '<inertia ixx="0.02" iyy="0.025" izz="0.03" ixy="0.001" ixz="0" iyz="0.002"/></inertial></link>'
    )


def joint(name, parent, child, inner="", kind="revolute", axis="0.2 1 0.1"):
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="0.1 -0.05 -0.3" rpy="0.1 0.2 0.3"/><axis xyz="{axis}"/>'
        f'<limit lower="-3" upper="3" effort="1" velocity="1"/>{inner}</joint>'
    )


def arm(second="", third="", kinds=("revolute", "revolute", "revolute")):
    """A base and three links in a row, with something inside the second and third joint."""
    names = "abcd"
    inner = ("", second, third)
    joints = "".join(joint(f"j{i + 1}", names[i], names[i + 1], inner[i], kinds[i]) for i in range(3))
    return f'<robot name="arm">{"".join(map(link, names))}{joints}</robot>'


def follows(leader, multiplier, offset=0.0):
    return f'<mimic joint="{leader}" multiplier="{multiplier}" offset="{offset}"/>'


def land(robot, base="free", frame="d", posture=TURNED, velocity=(0.3, 0.1, -1.0), **changes):
    contact = (Contact(frame=frame, offset=(0.05, 0.02, -0.1)),)
    strike = Strike(velocity=velocity)
    return shock_profile(Scene(robot="arm.urdf", base=base, contact=contact, strike=strike, posture=posture, **changes), robot)


# The base


@pytest.mark.parametrize("kinds", [("revolute",) * 3, ("continuous", "prismatic", "revolute")])
def test_a_fixed_base_is_the_model_without_a_free_flyer(kinds):
    """Columns of the base dropped: Δq̇ is that of Pinocchio's model of the same file bolted to the world."""
    robot = robot_from(arm(kinds=kinds))
    posture = Posture(joints={"j1": 0.4, "j2": -0.3, "j3": 0.8})
    fixed = land(robot, "fixed", posture=posture)
    model = pin.buildModelFromXML(robot.source.xml)
    data = model.createData()
    q = fixed.q[7:]
    pin.computeJointJacobians(model, data, q)
    pin.updateFramePlacements(model, data)
    frame = model.getFrameId("d")
    J = pin.getFrameJacobian(model, data, frame, pin.LOCAL_WORLD_ALIGNED)
    arm_ = data.oMf[frame].rotation @ np.array([0.05, 0.02, -0.1])
    J_c = J[:3] - pin.skew(arm_) @ J[3:]
    H = pin.crba(model, data, q)
    H = np.triu(H) + np.triu(H, 1).T
    expected = -np.linalg.solve(J_c, [0.3, 0.1, -1.0])  # three rates, three rows: the arm stops as the contact says
    np.testing.assert_allclose(fixed.delta_qd[6:], expected, rtol=0, atol=1e-12 * np.linalg.cond(J_c) * np.abs(expected).max())
    np.testing.assert_array_equal(fixed.delta_qd[:6], 0.0)
    lam = -np.linalg.solve(J_c @ np.linalg.solve(H, J_c.T), [0.3, 0.1, -1.0])
    np.testing.assert_allclose(fixed.contacts[0].impulse, lam, rtol=1e-9)


@pytest.mark.parametrize("name", ["leg", "quadruped"])
@pytest.mark.parametrize("angle", [-40.0, 0.0, 20.0])
def test_a_planar_base_is_a_free_one_for_a_robot_that_lies_in_the_plane(name, angle):
    """The project's own robots are symmetric about x–z: held in that plane or free, they do the same."""
    robot = known_robot(name)
    contact = (Contact(frame=robot.links[-1]),)
    scenes = [Scene(robot=name, base=base, contact=contact, strike=Strike(strike_angle_deg=angle)) for base in ("free", "planar")]
    free, planar = (shock_profile(scene, robot) for scene in scenes)
    np.testing.assert_allclose(planar.delta_qd, free.delta_qd, rtol=0, atol=1e-12 * np.abs(free.delta_qd).max())
    np.testing.assert_allclose(planar.ropc, free.ropc, rtol=1e-10)


@pytest.mark.parametrize("plane", ["xz", "yz", "xy", (1.0, 2.0, 0.5)])
def test_a_planar_base_moves_in_its_plane_alone(plane):
    """The base neither leaves the plane nor turns about an axis in it, however it stands."""
    profile = land(robot_from(arm()), "planar", plane=plane)
    R, n = profile.rotation[0], profile.plane.normal
    v, omega = R @ profile.delta_v[0], R @ profile.delta_omega[0]
    assert v @ n == pytest.approx(0.0, abs=1e-14)
    np.testing.assert_allclose(omega - n * (n @ omega), 0.0, atol=1e-14)
    assert abs(n @ omega) > 1e-3
    assert np.linalg.norm(v) > 1e-3


def equations(robot, scene):
    """The landing of a scene, its own reduced solution, and the system without any reduction."""
    landing = resolve(complete(scene, robot), robot)
    solution = solve(robot, landing.state, landing.rows, landing.drives.armature, landing.G)
    return landing, solution, impulsive_equation(landing.state, landing.rows, landing.drives.armature, None)


@given(st.integers(0, 2**32 - 1), st.sampled_from(["xz", "yz", "xy", (1.0, 2.0, 0.5)]))
def test_holding_the_base_by_rows_is_holding_it_by_columns(seed, plane):
    """Both ways of Section 3.1.1: K Δq̇ = 0 stacked under the contact gives the Δq̇ of the reduced system."""
    rng = np.random.default_rng(seed)
    robot = known_robot("anymal_b")
    joints = dict(zip(robot.joint_names, rng.uniform(-1.0, 1.0, len(robot.joint_names)).tolist(), strict=True))
    posture = Posture(base_rpy_deg=tuple(rng.uniform(-180.0, 180.0, 3).tolist()), joints=joints)
    contact = (Contact(frame="LF_FOOT"),)
    strike = Strike(velocity=(0.1, 0.2, -1.0))
    scene = Scene(robot="anymal_b", base="planar", plane=plane, posture=posture, contact=contact, strike=strike)
    landing, reduced, whole = equations(robot, scene)
    R = landing.state.rotation[0, 0]
    K = np.zeros((3, robot.model.nv))
    K[0, :3] = landing.plane.normal @ R
    K[1, 3:6], K[2, 3:6] = landing.plane.e1 @ R, landing.plane.e2 @ R
    stacked = solve_impact(whole.H[0], np.vstack([whole.J_c[0], K]), np.vstack([whole.b[0], np.zeros((3, 4))])).delta_qd
    np.testing.assert_allclose(reduced.delta_qd[0], stacked, rtol=0, atol=1e-11 * np.abs(stacked).max())  # legs nearly straight


def test_a_robot_bolted_down_by_its_file_cannot_be_freed():
    """An MJCF without a free joint stays where it is; the message says how to free it."""
    text = (
        '<mujoco model="crane"><worldbody><body name="boom"><joint name="turn" axis="0 1 0"/>'
        '<inertial pos="0.5 0 0" mass="1" diaginertia="0.1 0.1 0.1"/></body></worldbody></mujoco>'
    )
    robot = robot_from(text, ".xml")
    contact = (Contact(frame="boom", offset=(1.0, 0.0, 0.0), directions=("z",)),)
    for base in ("free", "planar"):
        with pytest.raises(SceneError) as refusal:
            shock_profile(Scene(robot="crane.xml", base=base, contact=contact), robot)
        assert str(refusal.value) == (
            f'robot "crane" has a fixed base in its file, so base = "{base}" cannot be had; '
            'give its root body a <freejoint/>, or use base = "fixed"'
        )
    profile = shock_profile(Scene(robot="crane.xml", contact=contact), robot)
    assert profile.scene.base == "fixed"
    np.testing.assert_allclose(profile.delta_qd, [-1.0], rtol=1e-14)  # ω about y: the tip at x = 1 falls at 1 m/s and stops


def test_a_robot_with_nothing_left_to_move_is_refused():
    """One body on a fixed base is a stone."""
    robot = robot_from(f'<robot name="stone">{link("a")}</robot>')
    with pytest.raises(SceneError) as refusal:
        land(robot, "fixed", frame="a")
    assert str(refusal.value) == ('nothing of robot "stone" can move: its base is fixed and no joint is free; free one of them')


# Joints that follow others


@pytest.mark.parametrize("base", ["free", "planar", "fixed"])
@pytest.mark.parametrize(
    "kinds", [("revolute",) * 3, ("prismatic", "revolute", "prismatic"), ("continuous", "continuous", "revolute")]
)
def test_mimic_joints_as_columns_equal_mimic_joints_as_rows(kinds, base):
    """A chain of followers reduced by G is the free arm with Δq̇_follower − multiplier · Δq̇_leader = 0 stacked under the contact."""
    tied = robot_from(arm(follows("j1", -0.5, 0.3), follows("j2", 2.0, 0.1), kinds))
    free = robot_from(arm(kinds=kinds))
    j2 = -0.5 * 0.4 + 0.3
    values = {"j1": 0.4, "j2": j2, "j3": 2.0 * j2 + 0.1}

    def scene(joints):
        # One direction alone: even the single rate of a fixed base can meet it.
        contact = Contact(frame="d", offset=(0.05, 0.02, -0.1), directions=("z",))
        posture = Posture(base_rpy_deg=(10.0, -20.0, 30.0), joints=joints)
        return Scene(robot="arm.urdf", base=base, contact=(contact,), strike=Strike(velocity=(0.3, 0.1, -1.0)), posture=posture)

    landing, _, whole = equations(free, scene(values))
    found = shock_profile(scene({"j1": 0.4}), tied)
    np.testing.assert_allclose(found.q, landing.q, atol=1e-15)
    G = np.eye(9) if landing.G is None else landing.G[0]
    K = np.zeros((2, 9))
    K[0, 6:8] = 0.5, 1.0
    K[1, 7:9] = -2.0, 1.0
    J, b = np.vstack([whole.J_c[0] @ G, K @ G]), np.vstack([whole.b[0][:, 3:], np.zeros((2, 1))])
    stacked = (G @ solve_impact(G.T @ whole.H[0] @ G, J, b).delta_qd)[:, 0]
    np.testing.assert_allclose(found.delta_qd, stacked, rtol=0, atol=1e-12 * np.abs(stacked).max())
    assert found.delta_qd[7] == pytest.approx(-0.5 * found.delta_qd[6], rel=1e-13)
    assert found.delta_qd[8] == pytest.approx(2.0 * found.delta_qd[7], rel=1e-13)


@pytest.mark.parametrize("multiplier", [-0.5, 1.0, 3.0])
def test_a_mimic_joint_is_what_pinocchio_makes_of_it(multiplier):
    """Pinocchio's own model with mimic=True has the reduced inertia and the reduced Jacobian."""
    text = arm(follows("j1", multiplier, 0.3))
    robot = robot_from(text)
    posture = Posture(base_rpy_deg=(10.0, -20.0, 30.0), joints={"j1": 0.4, "j3": -0.7})
    profile = land(robot, posture=posture)
    model = pin.buildModelFromXML(text, pin.JointModelFreeFlyer(), True)
    data = model.createData()
    q = np.delete(profile.q, 8)
    H = pin.crba(model, data, q)
    H = np.triu(H) + np.triu(H, 1).T
    pin.computeJointJacobians(model, data, q)
    pin.updateFramePlacements(model, data)
    frame = model.getFrameId("d")
    J = pin.getFrameJacobian(model, data, frame, pin.LOCAL_WORLD_ALIGNED)
    J_c = J[:3] - pin.skew(data.oMf[frame].rotation @ np.array([0.05, 0.02, -0.1])) @ J[3:]
    A = J_c @ np.linalg.solve(H, J_c.T)
    expected = -np.linalg.solve(H, J_c.T @ np.linalg.solve(A, [0.3, 0.1, -1.0]))
    np.testing.assert_allclose(np.delete(profile.delta_qd, 7), expected, rtol=0, atol=1e-12 * np.abs(expected).max())
    assert profile.health.error_estimate < 1e-11


def test_a_joint_that_follows_a_fixed_one_does_not_move():
    """What follows the immovable stays where its offset puts it."""
    joints = joint("j1", "a", "b", kind="fixed") + joint("j2", "b", "c", follows("j1", 2.0, 0.3))
    text = f'<robot name="arm">{"".join(map(link, "abc"))}{joints}</robot>'
    profile = land(robot_from(text), frame="c")
    assert profile.q[7] == pytest.approx(0.3, abs=1e-15)
    assert profile.delta_qd[6] == 0.0
    # One rigid body, then: base and follower share one twist.
    jump = profile.rotation @ profile.delta_omega[..., None]
    np.testing.assert_allclose(jump[0], jump[1], atol=1e-13)


def test_a_locked_joint_makes_two_bodies_one():
    """A joint that holds is a joint that is fixed: the same file with a fixed joint in its place takes the same shock."""
    text = arm()
    posture = Posture(base_rpy_deg=(10.0, -20.0, 30.0))
    locked = land(robot_from(text), posture=posture, joints=Joints(locked=("j2",)))
    fixed = land(robot_from(text.replace('"j2" type="revolute"', '"j2" type="fixed"')), posture=posture)
    np.testing.assert_allclose(np.delete(locked.delta_qd, 7), fixed.delta_qd, rtol=0, atol=1e-12 * np.abs(fixed.delta_qd).max())
    assert locked.delta_qd[7] == 0.0
    np.testing.assert_allclose(locked.contacts[0].impulse, fixed.contacts[0].impulse, rtol=1e-11)


def test_everything_free_needs_no_reduction():
    """A free base without followers leaves the equation as it is: no G, no product."""
    robot = known_robot("anymal_b")
    scene = Scene(robot="anymal_b", contact=(Contact(frame="LF_FOOT"),))
    assert resolve(complete(scene, robot), robot).G is None
