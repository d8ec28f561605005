"""Which joint velocities are free: bases, locked joints and joints that follow others, as columns
of G (Eq. 7).
"""

import math

import dense
import numpy as np
import pinocchio as pin
import pytest
import trees
from hypothesis import given
from hypothesis import strategies as st
from robot_texts import LIMIT, body, joint, link, mjcf, urdf
from trees import robot_from

from shockpc import Contact, Joints, Posture, Scene, SolveError, Strike, resolve, shock_profile
from shockpc.impact.landed import solved

V = np.array([0.3, 0.1, -1.0])
POINT = (0.05, 0.02, -0.1)
TURNED = (10.0, -20.0, 30.0)


INERTIAL = (
    '<origin xyz="0.02 0.03 0.1"/><inertia ixx="0.02" iyy="0.025" izz="0.03" ixy="0.001" ixz="0" '
    'iyz="0.002"/>'
)
PLACE = (
    '<origin xyz="0.1 -0.05 -0.3" rpy="0.1 0.2 0.3"/><limit lower="-3" upper="3" effort="1" '
    'velocity="1"/>'
)


def arm(second=""):
    """A base and three links in a row, with something inside the second joint."""
    joints = [
        joint(f"j{i + 1}", *"abcd"[i : i + 2], axis="0.2 1 0.1", more=PLACE + second * (i == 1))
        for i in range(3)
    ]
    return urdf(*(link(name, "1.5", INERTIAL) for name in "abcd"), *joints, name="arm")


def follows(leader, multiplier, offset=0.0):
    return f'<mimic joint="{leader}" multiplier="{multiplier}" offset="{offset}"/>'


def scene(base="free", frame="d", values=None, **changes):
    contact = (Contact(frame=frame, offset=POINT),)
    posture = Posture(base_rpy_deg=TURNED, joints=values or {})
    return Scene(
        robot="arm.urdf",
        base=base,
        contact=contact,
        strike=Strike(velocity=tuple(V)),
        posture=posture,
        **changes,
    )


def assert_close(found, expected, digits=1e-12):
    """Equal to a share of the largest number."""
    np.testing.assert_allclose(found, expected, rtol=0, atol=digits * np.abs(expected).max())


# The base


@given(trees.mechanisms(planar=True, most=8), st.integers(0, 2**32 - 1))
def test_a_planar_robot_on_a_fixed_base_does_not_move_across_its_plane(mechanism, seed):
    """However its links' frames are turned: what rounding of the file makes of that zero is no
    independent row.
    """
    file = trees.written(mechanism, seed=seed)
    contacts = [Contact(frame=f"body{k}", offset=POINT) for k in range(1, len(mechanism.mass))]
    robot = robot_from(file.text)
    for contact in contacts:
        landing = resolve(
            Scene(robot="tree.urdf", base="fixed", contact=(contact,), posture=file.posture), robot
        )
        equation, impact, _ = solved(landing, landing.state)
        assert impact.rank[0] <= 2
        assert 1 not in impact.row_spaces[0].rows
        assert np.abs(equation.J_c[0, 1]).max() < 1e-14


@given(
    st.floats(-180.0, 180.0).map(lambda angle: round(angle, 12)),
    st.sampled_from(["prismatic", "revolute"]),
)
def test_a_contact_that_nothing_lets_move_is_refused(angle, kind):
    """A level slide, or a point on the axis of a level hinge, strikes downwards: rounding of the
    rotations is no motion.
    """
    place = f'<origin xyz="0 0 0" rpy="{-math.radians(angle)} 0 0"/>' + LIMIT
    robot = robot_from(urdf(link("a"), link("b"), joint("j", "a", "b", kind, "0 1 0", place)))
    point = Contact(frame="b", offset=(0.0, 0.3, 0.0), directions=("z",))
    with pytest.raises(SolveError, match=r'"b" cannot be stopped .* 1 m/s .* \(0 0 1\)') as refusal:
        shock_profile(
            Scene(
                robot="r",
                base="fixed",
                contact=(point,),
                posture=Posture(base_rpy_deg=(angle, 0.0, 0.0)),
            ),
            robot,
        )
    assert (refusal.value.constraints, refusal.value.bodies) == (("b",), ())


def test_a_robot_fixed_by_its_file_stays_where_it_is():
    """ω about y: the tip at x = 1 falls at 1 m/s and stops."""
    robot = robot_from(
        mjcf(body("boom", '<inertial pos="0.5 0 0" mass="1" diaginertia="0.1 0.1 0.1"/>', at="")),
        ".xml",
    )
    contact = Contact(frame="boom", offset=(1.0, 0.0, 0.0), directions=("z",))
    profile = shock_profile(Scene(robot="crane.xml", contact=contact), robot)
    assert profile.scene.base == "fixed"
    np.testing.assert_allclose(profile.delta_qd, [-1.0], rtol=1e-14)


# Joints that follow others


@pytest.mark.parametrize("multiplier", [-0.5, 1.0, 3.0])
def test_a_follower_is_what_pinocchio_makes_of_it(multiplier):
    """Pinocchio's model with mimic=True has the reduced inertia and the reduced Jacobian."""
    robot = robot_from(arm(follows("j1", multiplier, 0.3)))
    profile = shock_profile(scene(values={"j1": 0.4, "j3": -0.7}), robot)
    model, q = (
        pin.buildModelFromXML(robot.source.xml, pin.JointModelFreeFlyer(), True),
        np.delete(profile.q, 8),
    )
    jump, _ = dense.solve(dense.inertia(model, q), dense.point_rows(model, q, "d", POINT), V)
    assert_close(np.delete(profile.delta_qd, 7), jump)


def test_a_joint_that_follows_a_fixed_one_does_not_move():
    """It stays where its offset puts it, so base and follower are one rigid body."""
    joints = (
        joint("j1", "a", "b", "fixed", more=PLACE),
        joint("j2", "b", "c", more=PLACE + follows("j1", 2.0, 0.3)),
    )
    profile = shock_profile(scene(frame="c"), robot_from(urdf(*map(link, "abc"), *joints)))
    assert profile.q[7] == pytest.approx(0.3, abs=1e-15)
    assert profile.delta_qd[6] == 0.0
    first, second = profile.rotation @ profile.delta_omega[..., None]
    np.testing.assert_allclose(first, second, atol=1e-13)


# Locked joints


def test_a_locked_joint_makes_two_bodies_one():
    """The same file with a fixed joint in the place of the locked one takes the same shock."""
    text = arm()
    locked = shock_profile(scene(joints=Joints(locked=("j2",))), robot_from(text))
    fixed = shock_profile(
        scene(), robot_from(text.replace('"j2" type="revolute"', '"j2" type="fixed"'))
    )
    assert_close(np.delete(locked.delta_qd, 7), fixed.delta_qd)
    assert locked.delta_qd[7] == 0.0
    assert_close(locked.contacts[0].impulse, fixed.contacts[0].impulse)
