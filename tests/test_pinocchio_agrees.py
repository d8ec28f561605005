"""Real robots against the impact dynamics of Pinocchio, and random trees with ball joints against
the inertia of MuJoCo.
"""

import mujoco
import numpy as np
import pinocchio as pin
import pytest
import trees
from hypothesis import given
from trees import MJCF_KINDS, known_robot

from shockpc import Contact, Joints, Scene, Strike, load_robot, shock_profile
from shockpc.landing.joint_model import without_springs
from shockpc.landing.scenes.scene_file import plane_of
from shockpc.method.approach import Motion
from shockpc.method.constraints import Constraint
from shockpc.method.dynamics import Inertias, dynamics, spatial_inertias
from shockpc.method.equation import System
from shockpc.method.shock import shock

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


def rigid_contacts(model, data, q, before, frames, restitution):
    """Pinocchio's impact with rigid point contacts."""
    contacts = [
        pin.RigidConstraintModel(
            pin.ContactType.CONTACT_3D,
            model,
            model.frames[f].parentJoint,
            model.frames[f].placement,
            pin.LOCAL_WORLD_ALIGNED,
        )
        for f in frames
    ]
    datas = [contact.createData() for contact in contacts]
    pin.initConstraintDynamics(model, data, contacts, datas)
    return pin.impulseDynamics(model, data, q, before, contacts, datas, restitution)


def test_the_method_needs_no_landing():
    """Steps 1 and 2 of a robot, a posture and a held point, with restitution, are Pinocchio's."""
    robot = known_robot("go2")
    model, none = robot.model.copy(), np.zeros(robot.model.nv)
    model.armature = none
    q = pin.integrate(model, robot.start, np.full(model.nv, 0.2))
    velocity = np.array([0.4, 0.1, -1.0])
    foot = robot.frame("FL_foot")
    held = Constraint("contact", "FL_foot", foot.body, foot.offset, np.eye(3), restitution=0.3)
    before = Motion(velocity, np.zeros(3), none)
    plane = plane_of(Scene(robot="go2"))
    system = System(robot, "free", plane, none > 0.0, none, none, before)
    found = shock(system, dynamics(robot, q[None]), (held,))
    # A floating base has its velocity in its own axes there.
    qd = none.copy()
    qd[:3] = pin.Quaternion(q[3:7]).toRotationMatrix().T @ velocity
    data = model.createData()
    delta = rigid_contacts(model, data, q, qd, [model.getFrameId("FL_foot")], 0.3) - qd
    pin.forwardKinematics(model, data, q, delta)
    expected = []
    for body in robot.bodies:
        R, twist = data.oMi[body.joint].rotation, data.v[body.joint]
        at_origin = twist.linear + np.cross(twist.angular, body.offset)
        expected.append(np.concatenate([R @ twist.angular, R @ at_origin]))
    np.testing.assert_allclose(found.solution.delta_qd[0, :, 3], delta, atol=1e-9)
    np.testing.assert_allclose(found.jumps[0, :, :, 3], expected, atol=1e-9)


def test_large_robots_are_evaluated_without_data_that_grow_with_the_cube(
    monkeypatch: pytest.MonkeyPatch,
):
    """Inertia, Jacobian and placements of the joints one by one are those of Pinocchio; 500 joints
    would take 4 GB there.
    """
    for robot in (known_robot("go2"), known_robot("cassie")):
        Q = np.stack(
            [
                pin.integrate(robot.model, robot.start, np.full(robot.model.nv, x))
                for x in (0.1, -0.4)
            ]
        )
        joints = without_springs(
            np.linspace(0.0, 1.0, robot.model.nv), np.zeros(robot.model.nv, dtype=bool), "geared"
        )
        expected = dynamics(robot, Q, joints)
        with monkeypatch.context() as patch:
            patch.setattr("shockpc.method.dynamics.LARGEST_DATA", robot.model.nv - 1)
            patch.delattr("shockpc.method.dynamics._workspace")
            found = dynamics(robot, Q, joints)
        for part in ("H", "J", "rotation", "position"):
            np.testing.assert_allclose(
                getattr(found, part),
                getattr(expected, part),
                rtol=0,
                atol=1e-13 * np.abs(expected.H).max(),
            )


def test_order_of_the_joints():
    """A model that is built in another order than that of its tree has the kinetic energy of its
    bodies, unlike in Pinocchio.
    """
    model, inertia = pin.Model(), pin.Inertia(1.0, np.array([0.1, 0.2, 0.3]), np.eye(3))
    for parent, name in ((0, "base"), (1, "left"), (1, "right"), (2, "left_foot")):
        joint = pin.JointModelRX() if parent else pin.JointModelFreeFlyer()
        place = pin.SE3(np.eye(3), np.array([0.0, 0.1, 0.2]) * bool(parent))
        model.appendBodyToJoint(
            model.addJoint(parent, joint, place, name), inertia, pin.SE3.Identity()
        )
    robot = load_robot(model)
    assert not robot.depth_first
    assert known_robot("cassie").depth_first
    state = dynamics(robot, robot.start[None])
    moving = np.where(state.ancestors[:, None], state.J[0], 0.0)
    bodies = spatial_inertias(
        robot,
        state,
        Inertias.of(
            robot, without_springs(np.zeros(model.nv), np.zeros(model.nv, dtype=bool), "free")
        ),
    )[0]
    np.testing.assert_allclose(
        state.H[0], (np.swapaxes(moving, 1, 2) @ bodies @ moving).sum(axis=0), atol=1e-14
    )


@pytest.mark.slow
@pytest.mark.parametrize("restitution", [0.0, 0.5])
@pytest.mark.parametrize("name", FEET)
def test_the_jump_is_that_of_pinocchio(name, restitution):
    """One sticking foot, or two on different legs: Δq̇ is that of pin.impulseDynamics; of q̇⁻ only
    J q̇⁻ matters.
    """
    for feet in {FEET[name][:1], FEET[name]}:
        given = {
            "at": "frame",
            "kind": "point",
            "restitution": restitution,
            "restitution_along": "directions",
        }
        contacts = tuple(Contact(frame=foot, **given) for foot in feet)
        # Slanted, so that nothing is symmetric by accident.
        scene = Scene(
            robot=name,
            contact=contacts,
            strike=Strike(velocity=(0.3, -0.1, -1.0)),
            joints=Joints(drives="none"),
        )
        profile = shock_profile(scene, known_robot(name))
        model, data = profile.robot.model, profile.robot.model.createData()
        pin.forwardKinematics(model, data, profile.q)
        before = np.zeros(model.nv)
        before[:3] = data.oMi[1].rotation.T @ profile.strike
        after = rigid_contacts(
            model, data, profile.q, before, [model.getFrameId(foot) for foot in feet], restitution
        )
        # Hands a thousandth as heavy as the arms that carry them cost Pinocchio's double precision
        # some digits.
        tolerance = max(1e-12, 10.0 * profile.health.double_error) * np.abs(profile.delta_qd).max()
        np.testing.assert_allclose(profile.delta_qd, after - before, rtol=0, atol=tolerance)
        assert profile.health.rank == 3 * len(feet)
        assert profile.health.double_error < 1e-10


@given(trees.landings(kinds=MJCF_KINDS, most=8, hits=1))
def test_the_inertia_of_mujoco_gives_the_same_jump(landing):
    """A library with its parser, kinematics and inertia: Δq̇ from MuJoCo's M and J moves every body
    the same way.
    """
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
        mujoco.mj_jac(
            model, data, linear, angular, landing.mechanism.com[i], model.body(f"body{i}").id
        )
        expected[i] = np.concatenate([angular @ qd, linear @ qd])
    found = trees.twists(trees.land(landing, dialect="mjcf"))
    size = trees.motion(landing.mechanism, expected)
    # Two joint-space inertias, each good to 1e-9 over three decades of mass; MuJoCo keeps 1e-15 as
    # its smallest inertia.
    assert np.all(
        trees.motion(landing.mechanism, found - expected)
        <= 1e-8 * np.maximum(size, 1e-6 * size.max())
    )
