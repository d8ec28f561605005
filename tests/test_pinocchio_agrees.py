"""Real robots against Pinocchio's own impact dynamics and, for one's spherical joints, against MuJoCo's inertia."""

import mujoco
import numpy as np
import pinocchio as pin
import pytest
import trees
from hypothesis import given
from trees import MJCF_KINDS, known_robot

from shockpc.model.contact import Contact
from shockpc.profile import shock_profile
from shockpc.scene import Scene, Strike

FEET = {
    "a1": ("FL_foot", "RR_foot"),
    "anymal_b": ("LF_FOOT", "RH_FOOT"),
    "anymal_c": ("LF_FOOT", "RH_FOOT"),
    "b1": ("FL_foot", "RR_foot"),
    "bolt": ("FL_FOOT",),
    "go2": ("FL_foot", "RR_foot"),
    "hyq": ("lf_foot", "rh_foot"),
    "laikago": ("FL_foot", "RR_foot"),
    "solo12": ("FL_FOOT", "HR_FOOT"),
    "talos": ("left_sole_link",),
}


def profile_of(name, *feet, **changes):
    """One landing of a known robot, slanted so that nothing is symmetric by accident."""
    contacts = tuple(Contact(frame=foot, restitution=changes.get("restitution", 0.0)) for foot in feet)
    strike = Strike(velocity=(0.3, -0.1, -1.0))
    return shock_profile(Scene(robot=name, contact=contacts, strike=strike), known_robot(name))


def rigid_impulse(profile, feet, restitution):
    """Pinocchio's impact with rigid point contacts; q̇⁻ is the base's velocity, since only J q̇⁻ matters."""
    model = profile.robot.model
    data = model.createData()
    frames = [model.getFrameId(foot) for foot in feet]
    contacts = [
        pin.RigidConstraintModel(
            pin.ContactType.CONTACT_3D, model, model.frames[f].parentJoint, model.frames[f].placement, pin.LOCAL_WORLD_ALIGNED
        )
        for f in frames
    ]
    datas = [contact.createData() for contact in contacts]
    pin.initConstraintDynamics(model, data, contacts, datas)
    before = np.zeros(model.nv)
    pin.forwardKinematics(model, data, profile.q)
    before[:3] = data.oMi[1].rotation.T @ profile.strike
    return pin.impulseDynamics(model, data, profile.q, before, contacts, datas, restitution) - before


def jacobian_impulse(profile, feet, restitution):
    """Pinocchio's impact with a Jacobian given."""
    model = profile.robot.model
    data = model.createData()
    pin.computeJointJacobians(model, data, profile.q)
    pin.updateFramePlacements(model, data)
    J = np.concatenate([pin.getFrameJacobian(model, data, model.getFrameId(foot), pin.LOCAL_WORLD_ALIGNED)[:3] for foot in feet])
    before = np.zeros(model.nv)
    before[:3] = data.oMi[1].rotation.T @ profile.strike
    return pin.impulseDynamics(model, data, profile.q, before, J, restitution) - before


@pytest.mark.parametrize("impulse", [rigid_impulse, jacobian_impulse])
@pytest.mark.parametrize("restitution", [0.0, 0.5])
@pytest.mark.parametrize("name", FEET)
def test_the_jump_equals_pinocchio_s(name, restitution, impulse):
    """One sticking foot, or two on different legs: Δq̇ is that of pin.impulseDynamics."""
    for feet in {FEET[name][:1], FEET[name]}:
        profile = profile_of(name, *feet, restitution=restitution)
        expected = impulse(profile, feet, restitution)
        error = np.abs(profile.delta_qd - expected).max() / np.abs(expected).max()
        # 1e-12, unless the profile itself says that the model loses more: hands a thousandth as heavy as the arms that carry them.
        assert error <= max(1e-12, 10.0 * profile.health.error_estimate)
        assert profile.health.rank == 3 * len(feet)


@pytest.mark.parametrize("name", FEET)
def test_the_two_formulations_agree_on_real_robots(name):
    """Joint space and maximal coordinates differ by rounding: no warning on any robot that people land."""
    health = profile_of(name, *FEET[name]).health
    assert health.error_estimate < 1e-10
    assert health.residual < 1e-12
    assert not [warning for warning in health.warnings if "solutions differ" in warning]


@pytest.mark.parametrize(("name", "friction"), [("go2", 0.44), ("anymal_c", 0.57), ("solo12", 0.63), ("hyq", 0.72)])
def test_sticking_needs_the_friction_that_was_found_before(name, friction):
    """One foot straight down in the standing posture: the worst of the four needs this coefficient of friction."""
    robot = known_robot(name)
    pattern = FEET[name][0][2:]
    feet = [link for link in robot.links if link.endswith(pattern)]
    needed = [shock_profile(Scene(robot=name, contact=(Contact(frame=foot),)), robot).contacts[0].friction_needed for foot in feet]
    assert len(feet) == 4
    assert max(needed) == pytest.approx(friction, abs=0.006)  # two digits were written down


@given(trees.landings(kinds=MJCF_KINDS, most=8, hits=1))
def test_mujoco_s_inertia_gives_the_same_jump(landing):
    """A library with its own parser, kinematics and inertia: Δq̇ from MuJoCo's M and J moves every body the same way."""
    file = trees.written(landing.mechanism, dialect="mjcf")
    model = mujoco.MjModel.from_xml_string(file.text)
    data = mujoco.MjData(model)
    x, y, z, w = file.posture.base_quaternion
    data.qpos[:7] = (*file.posture.base_position, w, x, y, z)
    for joint, value in file.posture.joints.items():
        data.joint(joint).qpos[0] = value
    mujoco.mj_forward(model, data)
    M = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, M)
    hit = landing.hits[0]
    J = np.zeros((3, model.nv))
    mujoco.mj_jac(model, data, J, None, hit.point, model.body(f"body{hit.body}").id)
    D = np.asarray(hit.directions) / np.linalg.norm(hit.directions, axis=1, keepdims=True)
    b = (1.0 + hit.restitution) * D @ landing.strike
    A = D @ J @ np.linalg.solve(M, J.T @ D.T)
    qd = -np.linalg.solve(M, J.T @ D.T @ np.linalg.solve(A, b))
    expected = np.empty((len(landing.mechanism.mass), 6))
    for i in range(len(expected)):
        linear, angular = np.zeros((2, 3, model.nv))
        mujoco.mj_jac(model, data, linear, angular, landing.mechanism.com[i], model.body(f"body{i}").id)
        expected[i] = np.concatenate([angular @ qd, linear @ qd])
    found = trees.twists(trees.land(landing, dialect="mjcf"))
    size = trees.motion(landing.mechanism, expected)
    # Two joint-space inertias, each good to 1e-9 over three decades of mass; MuJoCo keeps 1e-15 as its least inertia.
    assert np.all(trees.motion(landing.mechanism, found - expected) <= 1e-8 * np.maximum(size, 1e-6 * size.max()))
