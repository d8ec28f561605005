"""Postures: references, joint values, the base's place, limits, and every message about them."""

import math

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st
from robot_texts import joint, link, urdf
from trees import known_robot, random_rotations, robot_from

from shockpc.errors import SceneError, UnknownName
from shockpc.model.contact import Contact
from shockpc.model.dynamics import dynamics
from shockpc.model.posture import STANDING, Posture, configuration, outside_limits, reference_name
from shockpc.profile import shock_profile
from shockpc.scene import Scene

ANGLES = st.floats(-180.0, 180.0)


def mixed(**parts):
    """A base with a hinge, a wheel and a slide in a row; texts go inside those joints."""
    inner = {"hinge": "", "wheel": "", "slide": ""} | parts
    limit = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'
    return urdf(
        link("base"), link("arm"), link("hand"), link("finger"),
        joint("hinge", "base", "arm", "revolute", "0 1 0", limit + inner["hinge"]),
        joint("wheel", "arm", "hand", "continuous", "1 0 0", inner["wheel"]),
        joint("slide", "hand", "finger", "prismatic", "0 0 1", limit + inner["slide"]),
    )  # fmt: skip


def srdf(states):
    return f'<robot name="r"><group name="all"/>{states}</robot>'


def state(name, **values):
    joints = "".join(f'<joint name="{joint}" value="{value}"/>' for joint, value in values.items())
    return f'<group_state name="{name}" group="all">{joints}</group_state>'


def refusal(robot, posture, kind=SceneError):
    with pytest.raises(kind) as raised:
        configuration(robot, posture)
    return str(raised.value)


# References


@pytest.mark.parametrize("name", ["a1", "anymal_b", "anymal_c", "go2", "hyq", "kinova", "laikago", "pr2", "solo12", "talos"])
def test_references_are_those_pinocchio_loads(name):
    """Every posture of the SRDF beside a robot, in Pinocchio's layout."""
    robot = known_robot(name)
    model = pin.buildModelFromXML(robot.source.xml, pin.JointModelFreeFlyer())
    if robot.source.srdf is not None:
        pin.loadReferenceConfigurations(model, str(robot.source.srdf), False)
    expected = {entry.key(): entry.data() for entry in model.referenceConfigurations}
    assert set(robot.postures) == set(expected)
    for posture, q in robot.postures.items():
        whole = pin.normalize(model, expected[posture])
        np.testing.assert_allclose(configuration(robot, Posture(reference=posture)), whole, atol=1e-15)
        np.testing.assert_array_equal(q, expected[posture])


@pytest.mark.parametrize(
    ("name", "wanted", "found"),
    [
        ("hyq", None, "standing"),
        ("hyq", "straight_standing", "straight_standing"),
        ("hyq", "neutral", "neutral"),
        ("talos", None, "half_sitting"),
        ("laikago", None, "neutral"),
    ],
)
def test_the_posture_is_the_one_asked_for_else_standing_else_neutral(name, wanted, found):
    """Which posture a scene means never depends on the order of a file."""
    assert reference_name(known_robot(name), wanted) == found


def test_standing_goes_by_the_first_of_its_names():
    """A robot with several standing postures takes them in the order of STANDING, not of its file."""
    for first in range(len(STANDING)):
        states = "".join(state(name, hinge=0.1) for name in reversed(STANDING[first:]))
        assert reference_name(robot_from(mixed(), srdf=srdf(states)), None) == STANDING[first]


def test_neutral_is_neutral():
    """All joints at zero, the base upright at the origin."""
    robot = known_robot("hyq")
    np.testing.assert_array_equal(configuration(robot, Posture(reference="neutral")), pin.neutral(robot.model))


def test_a_reference_turns_a_wheel_by_its_angle():
    """An SRDF gives a continuous joint by its angle; q holds cosine and sine."""
    robot = robot_from(mixed(), srdf=srdf(state("standing", hinge=0.2, wheel=0.7, slide=0.1)))
    q = configuration(robot, Posture())
    np.testing.assert_allclose(q[7:], [0.2, math.cos(0.7), math.sin(0.7), 0.1], atol=1e-15)


def test_a_rounded_rotation_is_made_whole():
    """A quaternion of 0.707s, as files are written, turns the robot by 90 degrees and changes no shock by its missing length."""
    rounded, exact = (
        robot_from(mixed(), srdf=srdf(state("standing", root_joint=f"0 0 1 0 0 {root} {root}")))
        for root in ("0.707", repr(0.5**0.5))
    )
    contact = (Contact(frame="finger", offset=(0.1, 0.0, -0.2)),)
    one, other = (shock_profile(Scene(robot="r.urdf", contact=contact), robot) for robot in (rounded, exact))
    np.testing.assert_allclose(one.ropc, other.ropc, rtol=1e-12)
    assert one.health.warnings == other.health.warnings == ()


@pytest.mark.parametrize("value", ["0 0 1 0 0 0.7071 2", "0 0 1 0 0 0 0"])
def test_a_rotation_that_is_none_is_refused(value):
    """A quaternion of another length is a slip of the file, not a rotation."""
    robot = robot_from(mixed(), srdf=srdf(state("standing", root_joint=value)))
    assert refusal(robot, Posture()) == (
        'posture "standing" of robot "r" holds a rotation that is none: a quaternion (x, y, z, w), or a cosine and '
        "sine, has length 1; correct it in the file of postures"
    )


def test_an_unknown_posture_is_named_with_the_nearest():
    """The message holds the name, the robot, the nearest and the command that lists all."""
    robot = known_robot("hyq")
    assert refusal(robot, Posture(reference="standng"), UnknownName) == (
        'no posture "standng" in robot "hyq"; nearest: "standing", "straight_standing". To list them: shockpc robots hyq'
    )


def test_keyframes_of_an_mjcf_are_postures():
    """A keyframe's quaternion is w x y z in MuJoCo and x y z w here."""
    text = (
        '<mujoco model="m"><worldbody><body name="b"><freejoint/><inertial pos="0 0 0.1" mass="1" diaginertia="1 1 1"/>'
        '<body name="leg"><joint name="hip" axis="0 1 0"/><inertial pos="0 0 0.1" mass="1" diaginertia="1 1 1"/></body>'
        '</body></worldbody><keyframe><key name="home" qpos="1 2 3 0.8 0.6 0 0 0.25"/></keyframe></mujoco>'
    )
    robot = robot_from(text, ".xml")
    assert reference_name(robot, None) == "home"
    np.testing.assert_allclose(configuration(robot, Posture()), [1.0, 2.0, 3.0, 0.6, 0.0, 0.0, 0.8, 0.25], atol=1e-15)


# Joints


def test_a_glob_sets_every_joint_it_means_in_degrees():
    """The four knees of hyq go to −60 degrees, and nothing else moves."""
    robot = known_robot("hyq")
    before, after = (configuration(robot, posture) for posture in (Posture(), Posture(joints_deg={"*_kfe_joint": -60.0})))
    knees = [robot.model.joints[robot.model.getJointId(name)].idx_q for name in robot.joint_names if name.endswith("_kfe_joint")]
    assert len(knees) == 4
    np.testing.assert_allclose(after[knees], -math.pi / 3.0, rtol=1e-15)
    np.testing.assert_array_equal(np.delete(after, knees), np.delete(before, knees))


def test_later_patterns_go_over_earlier_ones_and_degrees_over_radians():
    """A value for all, then one for one: the order in which they are written counts."""
    robot = known_robot("hyq")
    first = robot.joint_names[0]
    q = configuration(robot, Posture(joints={"*": 0.1, first: 0.2}))
    assert (q[7], q[8]) == (0.2, 0.1)
    assert configuration(robot, Posture(joints={first: 0.2, "*": 0.1}))[7] == 0.1
    assert configuration(robot, Posture(joints={first: 0.2}, joints_deg={first: 90.0}))[7] == pytest.approx(math.pi / 2.0)


@given(st.floats(-10.0, 10.0))
def test_a_slide_is_set_in_metres_and_a_wheel_by_cosine_and_sine(value):
    """Degrees are for what turns; a prismatic joint takes metres under either key."""
    robot = robot_from(mixed())
    turned = configuration(robot, Posture(joints={"*": value}))
    np.testing.assert_allclose(turned[7:], [value, math.cos(value), math.sin(value), value], atol=1e-15)
    in_degrees = configuration(robot, Posture(joints_deg={"*": value}))
    angle = math.radians(value)
    np.testing.assert_allclose(in_degrees[7:], [angle, math.cos(angle), math.sin(angle), value], atol=1e-15)


def test_an_exact_name_is_no_pattern():
    """A joint may be called like a glob; its own name means it alone."""
    robot = robot_from(mixed().replace('"hinge"', '"[h]inge*"').replace('"slide"', '"hinge2"'))
    q = configuration(robot, Posture(joints={"[h]inge*": 0.3}))
    assert (q[7], q[10]) == (0.3, 0.0)


def test_an_unknown_joint_is_named_with_the_nearest():
    """The message holds the name, the robot, the nearest and the command that lists all; the base is no joint to set."""
    robot = known_robot("anymal_b")
    assert refusal(robot, Posture(joints={"LF_KNEE": 0.1}), UnknownName) == (
        'no joint "LF_KNEE" in robot "anymal"; nearest: "LF_KFE", "RF_KFE", "LH_KFE". To list them: shockpc robots anymal_b'
    )
    assert refusal(robot, Posture(joints_deg={"root_joint": 0.1}), UnknownName).startswith(
        'no joint "root_joint" in robot "anymal"; '
    )
    assert refusal(robot_from(mixed()), Posture(joints={"zz*": 0.1}), UnknownName).startswith(
        'no joint "zz*" in robot "r"; there are: "hinge", "wheel", "slide". To list them: shockpc robots '
    )


def test_a_ball_joint_cannot_be_set_by_a_number():
    """Three degrees of freedom take more than one number."""
    text = (
        '<mujoco model="m"><worldbody><body name="b"><freejoint/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
        '<body name="leg"><joint name="hip" type="ball"/><inertial pos="0 0 0.1" mass="1" diaginertia="1 1 1"/></body>'
        "</body></worldbody></mujoco>"
    )
    assert refusal(robot_from(text, ".xml"), Posture(joints={"hip": 0.1})) == (
        'joint "hip" has 3 degrees of freedom, so one number cannot set it; use a reference posture instead'
    )


# Joints that follow others


@given(st.floats(-3.0, 3.0))
def test_followers_stand_where_their_leaders_put_them(value):
    """Each at multiplier · q_leader + offset, along a chain of followers, over cosine and sine, whatever the reference says."""
    text = mixed(wheel='<mimic joint="hinge" multiplier="-2" offset="0.3"/>', slide='<mimic joint="wheel" multiplier="0.1"/>')
    robot = robot_from(text, srdf=srdf(state("standing", hinge=0.1, slide=0.9)))
    q = configuration(robot, Posture(joints={"*": value}))
    angle = -2.0 * value + 0.3
    np.testing.assert_allclose(q[7:10], [value, math.cos(angle), math.sin(angle)], atol=1e-12)
    assert q[10] == pytest.approx(0.1 * math.remainder(angle, 2.0 * math.pi), abs=1e-12)


def test_a_follower_cannot_be_set_by_itself():
    """By its own name it is refused, by a glob passed over."""
    robot = robot_from(mixed(slide='<mimic joint="hinge" multiplier="0.1"/>'))
    assert (
        refusal(robot, Posture(joints={"slide": 0.1}))
        == 'joint "slide" follows joint "hinge", so it cannot be set by itself; set that one'
    )
    assert configuration(robot, Posture(joints={"*": 0.5}))[10] == pytest.approx(0.05)


# The base


@given(ANGLES, ANGLES, ANGLES)
def test_base_rpy_turns_about_fixed_axes_in_their_order(roll, pitch, yaw):
    """Roll about the world's x, then pitch about its y, then yaw about its z: R = Rz Ry Rx."""
    robot = known_robot("anymal_b")
    q = configuration(robot, Posture(base_rpy_deg=(roll, pitch, yaw)))
    Rx, Ry, Rz = (pin.exp3(np.radians(angle) * axis) for angle, axis in zip((roll, pitch, yaw), np.eye(3), strict=True))
    np.testing.assert_allclose(dynamics(robot, q[None]).rotation[0, 0], Rz @ Ry @ Rx, atol=1e-14)


@given(st.integers(0, 2**32 - 1))
def test_a_base_quaternion_is_x_y_z_w(seed):
    """The scalar comes last, and what the base is given is how the base stands."""
    robot = known_robot("anymal_b")
    R = random_rotations(np.random.default_rng(seed), 1)[0]
    quaternion = tuple(pin.Quaternion(R).coeffs().tolist())
    q = configuration(robot, Posture(base_quaternion=quaternion, base_position=(1.0, 2.0, 3.0)))
    state_ = dynamics(robot, q[None])
    np.testing.assert_allclose(state_.rotation[0, 0], R, atol=1e-14)
    np.testing.assert_array_equal(state_.origin[0], [1.0, 2.0, 3.0])


def test_quarter_turn_by_either_way_is_the_same():
    """90 degrees of yaw is the quaternion (0, 0, √½, √½); a rounded one is made whole."""
    robot = known_robot("anymal_b")
    by_angle = configuration(robot, Posture(base_rpy_deg=(0.0, 0.0, 90.0)))
    np.testing.assert_allclose(by_angle[3:7], [0.0, 0.0, 0.5**0.5, 0.5**0.5], atol=1e-15)
    np.testing.assert_allclose(configuration(robot, Posture(base_quaternion=(0.0, 0.0, 0.71, 0.71))), by_angle, atol=1e-15)


def test_parts_of_the_base_leave_the_others_alone():
    """A new position keeps the reference's rotation, and the other way round."""
    robot = known_robot("quadruped")
    reference = configuration(robot, Posture())
    moved = configuration(robot, Posture(base_position=(1.0, 2.0, 3.0)))
    np.testing.assert_array_equal(moved[3:], reference[3:])
    turned = configuration(robot, Posture(base_rpy_deg=(0.0, 0.0, 0.0)))
    np.testing.assert_array_equal(turned[:3], reference[:3])
    np.testing.assert_array_equal(turned[3:7], [0.0, 0.0, 0.0, 1.0])


def test_the_base_is_turned_once():
    """Angles and quaternion together leave open which is meant."""
    posture = Posture(base_rpy_deg=(0.0, 0.0, 90.0), base_quaternion=(0.0, 0.0, 0.0, 1.0))
    assert (
        refusal(known_robot("hyq"), posture) == "the base is turned twice, by base_rpy_deg and by base_quaternion; keep one of them"
    )


@pytest.mark.parametrize(("quaternion", "length"), [((0.0, 0.0, 0.0, 2.0), "2"), ((0.0, 0.0, 0.0, 0.0), "0")])
def test_a_base_quaternion_has_length_one(quaternion, length):
    """Rounded decimals pass; anything else is no rotation."""
    assert refusal(known_robot("hyq"), Posture(base_quaternion=quaternion)) == (
        f"base_quaternion has length {length}; a rotation (x, y, z, w) has length 1"
    )


@pytest.mark.parametrize("part", [{"base_position": (0.0, 0.0, 0.0)}, {"base_rpy_deg": (0.0, 0.0, 0.0)}])
def test_a_base_bolted_down_cannot_be_placed(part):
    """An MJCF without a free joint has its base where its file puts it, even for a position of zeros."""
    text = (
        '<mujoco model="m"><worldbody><body name="leg"><joint name="hip" axis="0 1 0"/>'
        '<inertial pos="0 0 0.1" mass="1" diaginertia="1 1 1"/></body></worldbody></mujoco>'
    )
    assert refusal(robot_from(text, ".xml"), Posture(**part)) == (
        'the base of robot "m" is fixed in its file, so it cannot be moved or turned; '
        "give the root body a <freejoint/>, or leave the base's place out"
    )


# Limits


def test_limits_are_warned_of_with_the_consequence():
    """Outside its limits a joint is computed there all the same, and the profile says so; on a limit it is not outside."""
    robot = robot_from(mixed())
    q = configuration(robot, Posture(joints={"hinge": 1.25, "slide": -3.0, "wheel": 50.0}))
    warnings = (
        'joint "hinge" stands 14.3 deg outside its limits [-57.3, 57.3]; the profile is computed there all the same',
        'joint "slide" stands 2 m outside its limits [-1, 1]; the profile is computed there all the same',
    )
    assert outside_limits(robot, q) == warnings
    contact = (Contact(frame="finger"),)
    posture = Posture(joints={"hinge": 1.25, "slide": -3.0, "wheel": 50.0})
    assert shock_profile(Scene(robot="r.urdf", contact=contact, posture=posture), robot).health.warnings[:2] == warnings
    for on_the_limit in (1.0, -1.0, 1.0 + 5e-5):
        assert outside_limits(robot, configuration(robot, Posture(joints={"hinge": on_the_limit, "slide": on_the_limit}))) == ()
