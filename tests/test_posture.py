"""Postures: references, joint values, the base's placement, limits, and what is refused."""

import math

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st
from robot_texts import BODY, INERTIA, LIMIT, body, floating, joint, link, mjcf, refused, urdf
from scipy.spatial.transform import Rotation
from trees import known_robot, random_rotations, robot_from

from shockpc import (
    Closure,
    Contact,
    LoopEnd,
    Posture,
    Scene,
    SceneError,
    ShockError,
    StudyError,
    UnknownName,
    load_robot,
    read_scene,
    shock_profile,
)
from shockpc.evaluation.variations.vary import variation
from shockpc.landing.posture import configuration, outside_limits, reference_name
from shockpc.landing.scenes.scene_file import scene_text
from shockpc.method.dynamics import dynamics
from shockpc.robot.feet_and_sensors import BENT, STANDING
from shockpc.show.header import posture_text
from shockpc.studies.analyze.report import document

ANGLES = st.floats(-180.0, 180.0)


def mixed(**parts):
    """A base with a revolute, a continuous and a prismatic joint in a row; texts go inside those
    joints.
    """
    inner = {"hinge": "", "wheel": "", "slide": ""} | parts
    return urdf(
        link("base"),
        link("arm"),
        link("hand"),
        link("finger"),
        joint("hinge", "base", "arm", "revolute", "0 1 0", LIMIT + inner["hinge"]),
        joint("wheel", "arm", "hand", "continuous", "1 0 0", inner["wheel"]),
        joint("slide", "hand", "finger", "prismatic", "0 0 1", LIMIT + inner["slide"]),
    )


def state(name, **values):
    """A posture of an SRDF."""
    joints = "".join(f'<joint name="{joint}" value="{value}"/>' for joint, value in values.items())
    return f'<group_state name="{name}" group="all">{joints}</group_state>'


def posed(*states):
    """That robot with the postures of an SRDF."""
    return robot_from(mixed(), srdf=f'<robot name="r"><group name="all"/>{"".join(states)}</robot>')


FREE = mjcf(floating(body("leg", joints='<joint name="hip" type="ball"/>')))
HELD = mjcf(body("leg"))


MIXED = robot_from(mixed())
CHAIN = robot_from(
    mixed(
        wheel='<mimic joint="hinge" multiplier="-2" offset="0.3"/>',
        slide='<mimic joint="wheel" multiplier="0.1"/>',
    ),
    srdf=f'<robot name="r"><group name="all"/>{state("standing", hinge=0.1, slide=0.9)}</robot>',
)


# References


@pytest.mark.parametrize(
    "name",
    ["a1", "anymal_b", "anymal_c", "go2", "hyq", "kinova", "laikago", "pr2", "solo12", "talos"],
)
def test_references_are_those_pinocchio_loads(name):
    """Every posture of the SRDF beside a robot, in Pinocchio's layout."""
    robot = known_robot(name)
    model = pin.buildModelFromXML(robot.source.xml, pin.JointModelFreeFlyer())
    if robot.source.srdf is not None:
        pin.loadReferenceConfigurations(model, str(robot.source.srdf), False)
    expected = {entry.key(): entry.data() for entry in model.referenceConfigurations}
    assert set(robot.postures) - {BENT} == set(expected)
    for posture, q in ((name, robot.postures[name]) for name in expected):
        whole = pin.normalize(model, expected[posture])
        np.testing.assert_allclose(
            configuration(robot, Posture(reference=posture)), whole, atol=1e-15
        )
        np.testing.assert_array_equal(q, expected[posture])


@pytest.mark.parametrize(
    ("name", "wanted", "found"),
    [
        ("hyq", None, "standing"),
        ("hyq", "straight_standing", "straight_standing"),
        ("hyq", "neutral", "neutral"),
        ("talos", None, "half_sitting"),
        ("laikago", "neutral", "neutral"),
    ],
)
def test_the_posture_is_the_one_asked_for_else_standing_else_neutral(name, wanted, found):
    """The neutral one has all joints at zero or the limit nearest to it, and the base upright at
    the origin.
    """
    robot = known_robot(name)
    assert reference_name(robot, wanted) == found
    if found == "neutral":
        q = pin.neutral(robot.model)
        q[7:] = np.clip(
            q[7:], robot.model.lowerPositionLimit[7:], robot.model.upperPositionLimit[7:]
        )
        np.testing.assert_array_equal(configuration(robot, Posture(reference=wanted)), q)


@pytest.mark.parametrize("first", range(len(STANDING)))
def test_the_standing_posture_does_not_depend_on_the_order_of_the_file(first):
    """A robot with several standing postures takes the first of them in the order of STANDING."""
    assert (
        reference_name(
            posed(*(state(name, hinge=0.1) for name in reversed(STANDING[first:]))), None
        )
        == STANDING[first]
    )


def test_a_reference_gives_a_continuous_joint_by_its_angle():
    """In q its cosine and sine stand."""
    q = configuration(posed(state("standing", hinge=0.2, wheel=0.7, slide=0.1)), Posture())
    np.testing.assert_allclose(q[7:], [0.2, math.cos(0.7), math.sin(0.7), 0.1], atol=1e-15)


def test_a_rounded_rotation_is_normalised():
    """A quaternion rounded to 0.707, as files are written, is a rotation by 90 degrees, and changes
    no shock by its length.
    """
    contact = (Contact(frame="finger", offset=(0.1, 0.0, -0.2)),)
    one, other = (
        shock_profile(
            Scene(robot="r.urdf", contact=contact),
            posed(state("standing", root_joint=f"0 0 1 0 0 {root} {root}")),
        )
        for root in ("0.707", repr(0.5**0.5))
    )
    np.testing.assert_allclose(one.ropc, other.ropc, rtol=1e-12)
    assert [warning.kind for profile in (one, other) for warning in profile.health.warnings] == [
        "drives",
        "drives",
    ]


# Joints


def test_a_glob_sets_every_joint_it_matches():
    """The four knees of hyq go to −60 degrees, and nothing else moves."""
    robot = known_robot("hyq")
    before, after = (
        configuration(robot, posture)
        for posture in (Posture(), Posture(joints_deg={"*_kfe_joint": -60.0}))
    )
    knees = [joint.q.start for joint in robot.joints if joint.name.endswith("_kfe_joint")]
    assert len(knees) == 4
    np.testing.assert_allclose(after[knees], -math.pi / 3.0, rtol=1e-15)
    np.testing.assert_array_equal(np.delete(after, knees), np.delete(before, knees))


def test_later_patterns_replace_earlier_ones_and_degrees_replace_radians():
    """The order in which they are written counts."""
    robot = known_robot("hyq")
    first = robot.joint_names[0]
    for posture, values in (
        (Posture(joints={"*": 0.1, first: 0.2}), (0.2, 0.1)),
        (Posture(joints={first: 0.2, "*": 0.1}), (0.1, 0.1)),
        (Posture(joints={"*": 0.2}, joints_deg={first: 90.0}), (math.pi / 2.0, 0.2)),
    ):
        assert configuration(robot, posture)[7:9] == pytest.approx(values)


@pytest.mark.parametrize("value", [9999.0, -361.0])
def test_an_angle_beyond_limits_and_a_whole_turn_is_refused_wherever_it_is_given(value):
    """In radians or degrees, in a scene, a configuration or a sweep; a wheel turns as far as it
    likes, and a slide has no turn.
    """
    robot = robot_from(mixed())
    for act in (
        lambda: configuration(robot, Posture(joints={"hinge": math.radians(value)})),
        lambda: configuration(robot, Posture(joints_deg={"hin*": value})),
        lambda: configuration(robot, joints={"hinge": math.radians(value)}),
        lambda: configuration(robot, joints={"hinge": [math.radians(value)]}),
        lambda: variation(robot, "hinge", [0.0, value]),
    ):
        with pytest.raises(
            ShockError,
            match=f'{value:g} deg is outside the limits of joint "hinge".* more than a whole turn',
        ):
            act()
    wheel = robot.joint("wheel")
    assert wheel.value(configuration(robot, joints={"wheel": 50.0})) == pytest.approx(
        math.remainder(50.0, 2.0 * math.pi)
    )
    assert configuration(robot, Posture(joints_deg={"slide": value}))[-1] == value


@given(st.floats(-6.0, 6.0))
def test_a_slide_is_set_in_metres_and_a_wheel_by_cosine_and_sine(value):
    """Degrees are for rotations; a prismatic joint takes metres under either key."""
    for key, angle in (("joints", value), ("joints_deg", math.radians(value))):
        q = configuration(MIXED, Posture(**{key: {"*": value}}))
        np.testing.assert_allclose(
            q[7:], [angle, math.cos(angle), math.sin(angle), value], atol=1e-15
        )


def test_an_exact_name_is_not_a_pattern():
    """A joint may be named like a glob; its name means it alone."""
    robot = robot_from(mixed().replace('"hinge"', '"[h]inge*"').replace('"slide"', '"hinge2"'))
    q = configuration(robot, Posture(joints={"[h]inge*": 0.3}))
    assert (q[7], q[10]) == (0.3, 0.0)


@given(st.floats(-3.0, 3.0))
def test_followers_are_placed_by_their_leaders(value):
    """Each is at multiplier · q_leader + offset, also along a chain, through cosine and sine,
    whatever the reference says.
    """
    q = configuration(CHAIN, Posture(joints={"*": value}))
    angle = -2.0 * value + 0.3
    np.testing.assert_allclose(q[7:10], [value, math.cos(angle), math.sin(angle)], atol=1e-12)
    assert q[10] == pytest.approx(0.1 * math.remainder(angle, 2.0 * math.pi), abs=1e-12)


# The base


@given(ANGLES, ANGLES, ANGLES)
def test_base_rpy_rotates_about_fixed_axes_in_their_order(roll, pitch, yaw):
    """Roll about the world's x, then pitch about its y, then yaw about its z: R = Rz Ry Rx."""
    robot = known_robot("anymal_b")
    q = configuration(robot, Posture(base_rpy_deg=(roll, pitch, yaw)))
    Rx, Ry, Rz = (
        pin.exp3(np.radians(angle) * axis)
        for angle, axis in zip((roll, pitch, yaw), np.eye(3), strict=True)
    )
    np.testing.assert_allclose(dynamics(robot, q[None]).rotation[0, 0], Rz @ Ry @ Rx, atol=1e-14)


@given(st.integers(0, 2**32 - 1), st.floats(0.96, 1.04))
def test_a_base_quaternion_is_x_y_z_w(seed, length):
    """The scalar comes last; a rounded one is normalised."""
    robot = known_robot("anymal_b")
    R = random_rotations(np.random.default_rng(seed), 1)[0]
    quaternion = tuple((length * pin.Quaternion(R).coeffs()).tolist())
    q = configuration(robot, Posture(base_quaternion=quaternion, base_position=(1.0, 2.0, 3.0)))
    found = dynamics(robot, q[None])
    np.testing.assert_allclose(found.rotation[0, 0], R, atol=1e-14)
    np.testing.assert_array_equal(found.origin[0], [1.0, 2.0, 3.0])


def test_position_and_rotation_of_the_base_are_set_apart():
    """A new position keeps the reference's rotation, and the other way round."""
    robot = known_robot("quadruped")
    reference = configuration(robot, Posture())
    moved = configuration(robot, Posture(base_position=(1.0, 2.0, 3.0)))
    np.testing.assert_array_equal(moved[3:], reference[3:])
    turned = configuration(robot, Posture(base_rpy_deg=(0.0, 0.0, 0.0)))
    np.testing.assert_array_equal(turned[:7], [*reference[:3], 0.0, 0.0, 0.0, 1.0])


# Coordinates by name


@pytest.mark.parametrize("order", ["xyzw", "wxyz"])
def test_coordinates_by_name_are_where_pinocchio_has_them(order):
    """Every joint at its index in the model; a quaternion in either order is the rotation that
    SciPy makes of it.
    """
    rng = np.random.default_rng(0)
    robot, turn = known_robot("anymal_b"), Rotation.random(random_state=1)
    values = {name: float(rng.uniform(-1.0, 1.0)) for name in rng.permutation(robot.joint_names)}
    q = configuration(
        robot,
        joints=values,
        base=(1, 2, 3, *turn.as_quat(scalar_first=order == "wxyz")),
        quaternion=order,
    )
    for name, value in values.items():
        assert q[robot.model.joints[robot.model.getJointId(name)].idx_q] == value
    placement = pin.XYZQUATToSE3(q[:7])
    np.testing.assert_allclose(placement.rotation, turn.as_matrix(), atol=1e-15)
    np.testing.assert_array_equal(placement.translation, (1.0, 2.0, 3.0))


def test_joints_of_several_coordinates_are_set_by_name():
    """A ball joint by its quaternion, a continuous one by its angle, and followers with those that
    they follow.
    """
    ball = robot_from(FREE, ".xml")
    q = configuration(
        ball, joints={"hip": (0.8, 0.0, 0.6, 0.0)}, base=(0.0, 0.0, 1.0), quaternion="wxyz"
    )
    np.testing.assert_allclose(q, [0, 0, 1, 0, 0, 0, 1, 0, 0.6, 0, 0.8], atol=1e-15)
    angle = 0.3 - 2 * 0.2
    np.testing.assert_allclose(
        configuration(CHAIN, joints={"hinge": 0.2})[7:],
        [0.2, math.cos(angle), math.sin(angle), 0.1 * angle],
    )


@pytest.mark.parametrize(
    ("given", "kind", "parts"),
    [
        ({"joints": {"hinj": 0.1}}, UnknownName, ['"hinj"', '"hinge"']),
        ({"joints": {"hinge": "fast"}}, StudyError, ["joints", "hinge", "fast"]),
        ({"joints": {"hinge": (0.1, 0.2)}}, SceneError, ['"hinge" (revolute)', "1 finite number"]),
        ({"joints": {"hinge": math.nan}}, SceneError, ['"hinge"', "finite"]),
        ({"base": (0, 0, 0, 0, 0, 0, 1)}, SceneError, ["base", 'quaternion="xyzw"', "wxyz"]),
        ({"base": (0, 0, 0, 0, 0, 0, 3), "quaternion": "xyzw"}, SceneError, ["base", "length 3"]),
        ({"base": (0, 0, 0, 1)}, SceneError, ["base", "3 or 7"]),
    ],
)
def test_coordinates_that_cannot_be_set_are_refused(given, kind, parts):
    refused(kind, parts, lambda: configuration(MIXED, **given))


def test_a_follower_is_not_set_by_a_list_either():
    """One number in a list is refused as the number alone is, and not silently overwritten."""
    for value in (0.1, [0.1]):
        refused(
            SceneError,
            ['"slide" follows', '"wheel"'],
            lambda given=value: configuration(CHAIN, joints={"slide": given}),
        )


# Limits


def test_a_joint_outside_its_limits_is_reported():
    """The profile is computed there all the same, and says so; on a limit, to the rounding of
    files, a joint is not outside.
    """
    posture = Posture(joints={"hinge": 1.25, "slide": -3.0, "wheel": 50.0})
    warnings = outside_limits(MIXED, configuration(MIXED, posture))
    assert [(one.kind, one.subject, one.value) for one in warnings] == [
        ("limits", "hinge", 0.25),
        ("limits", "slide", 2.0),
    ]
    for warning, numbers in zip(warnings, (("14.3 deg", "57.3"), ("2 m", "1")), strict=True):
        assert all(number in str(warning) for number in numbers)
    profile = shock_profile(Scene(robot="r.urdf", contact="finger", posture=posture), MIXED)
    assert {*warnings} <= {*profile.health.warnings}
    for value in (1.0, -1.0, 1.0 + 5e-5):
        assert (
            outside_limits(
                MIXED, configuration(MIXED, Posture(joints={"hinge": value, "slide": value}))
            )
            == ()
        )


def test_joints_outside_for_one_reason_are_reported_together():
    """Four straight knees are one fact; so are the limits 0 and 0 of an export, whatever the
    angles, apart from true limits.
    """
    laikago = known_robot("laikago")
    (warning,) = outside_limits(laikago, configuration(laikago, Posture(joints={"*": 0.0})))
    assert all(
        part in str(warning)
        for part in ("35 deg outside", "4 alike", "FL_calf_joint", "RR_calf_joint")
    )
    chain = [
        joint(
            f"j{k}",
            f"l{k}",
            f"l{k + 1}",
            more=LIMIT if k == 8 else LIMIT.replace("1", "0", 2).replace("-", ""),
        )
        for k in range(9)
    ]
    robot = robot_from(urdf(*(link(f"l{k}") for k in range(10)), *chain))
    angles = {f"j{k}": 0.1 + 0.01 * k for k in range(8)} | {"j8": 1.5}
    profile = shock_profile(
        Scene(robot="r.urdf", contact="l9", base="free", posture=Posture(joints=angles)), robot
    )
    without, true = (one for one in profile.health.warnings if one.kind == "limits")
    assert (without.value, without.subject, true.value, true.subject) == (
        pytest.approx(0.17),
        "+".join(f"j{k}" for k in range(7, -1, -1)),
        pytest.approx(0.5),
        "j8",
    )
    assert "8 alike" in str(without)
    assert [one.rank for one in profile.health.warnings] == sorted(
        one.rank for one in profile.health.warnings
    )


def quadruped(turned=(0, 0, 0), feet=0.3):
    """A box and four feet below it [m]; the file's axes are turned (about one of them) [deg] from
    those in which it stands.
    """
    R = Rotation.from_euler("xyz", turned, degrees=True).inv()
    origin = (
        '<origin xyz="{} {} {}" rpy="'
        + " ".join(str(-math.radians(angle)) for angle in turned)
        + '"/>'
    )
    box = (
        f"<collision>{origin.format(0, 0, 0)}<geometry><box size='0.5 0.2 "
        f"0.1'/></geometry></collision>"
    )
    corners = {f"{name}_foot": (x, y, -feet) for name, x, y in ("a++", "b+-", "c-+", "d--")}
    places = {
        foot: R.apply([float(f"{x}0.2"), float(f"{y}0.15"), z])
        for foot, (x, y, z) in corners.items()
    }
    joints = [
        joint(f"j_{foot}", "base", foot, more=origin.format(*place) + LIMIT)
        for foot, place in places.items()
    ]
    return robot_from(
        urdf(link("base").replace("</link>", f"{box}</link>"), *map(link, corners), *joints)
    )


def standing(robot, **posture):
    """What a landing on one foot says of how the robot stands; it is said first."""
    warnings = shock_profile(
        Scene(robot="r.urdf", contact="a_foot", posture=Posture(**posture)), robot
    ).health.warnings
    assert not [one for one in warnings[1:] if one.kind == "standing"]
    return [str(one) for one in warnings[:1] if one.kind == "standing"]


@pytest.mark.parametrize("turned", [(90, 0, 0), (-90, 0, 0), (0, 90, 0), (0, -90, 0), (180, 0, 0)])
def test_a_robot_that_lies_as_its_file_has_it_is_told_how_to_turn_it(turned):
    """Turned so it stands, and nothing is said."""
    robot = quadruped(turned)
    (text,) = standing(robot)
    assert f"--base-rpy {','.join(map(str, turned))}" in text
    assert not standing(robot, base_rpy_deg=turned)


def test_legs_that_sprawl_do_not_stand():
    """Their feet are as high as the belly, or above it."""
    for feet, stands in ((0.3, True), (0.07, True), (0.05, False), (-0.02, False)):
        assert ["--base-rpy" in text for text in standing(quadruped(feet=feet))] == [True] * (
            not stands
        )


# Refused


REFUSED = {
    "unknown posture": (
        "hyq",
        Posture(reference="standng"),
        UnknownName,
        ('"standng"', '"hyq"', '"standing"', "robots hyq"),
    ),
    "unknown pattern": (
        MIXED,
        Posture(joints={"zz*": 0.1}),
        UnknownName,
        ('"zz*"', '"hinge"', '"wheel"', '"slide"'),
    ),
    "a ball joint": (
        robot_from(FREE, ".xml"),
        Posture(joints={"hip": 0.1}),
        SceneError,
        ('"hip"', "3 degrees of freedom"),
    ),
    "a follower": (CHAIN, Posture(joints={"slide": 0.1}), SceneError, ('"slide"', '"wheel"')),
    "a quaternion of zeros": (
        "hyq",
        Posture(base_quaternion=(0.0,) * 4),
        SceneError,
        ("base_quaternion", "length 0"),
    ),
    "position of a fixed base": (
        robot_from(HELD, ".xml"),
        Posture(base_position=(0.0,) * 3),
        SceneError,
        ('"m"', 'base = "free"'),
    ),
    "no rotation in a file": (
        posed(state("standing", root_joint="0 0 1 0 0 0.7 2")),
        Posture(),
        SceneError,
        ('"standing"', '"r"'),
    ),
    "zeros in a file": (
        posed(state("standing", root_joint="0 0 1 0 0 0 0")),
        Posture(),
        SceneError,
        ('"standing"', '"r"'),
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_a_posture_that_cannot_be_taken_is_refused(case):
    """The message names the posture, joint or key, and what would be valid."""
    robot, posture, kind, names = REFUSED[case]
    refused(
        kind, names, configuration, known_robot(robot) if isinstance(robot, str) else robot, posture
    )


KEYS = "<keyframe>{}</keyframe>"


@pytest.mark.parametrize(
    ("names", "found"),
    [
        (("odd",), "odd"),
        (("odd", "other"), "neutral"),
        (("crouch", "home_default"), "home_default"),
        (("default", "walk_pose", "stand_pose", "home_pose"), "stand_pose"),
        (("odd", "init"), "init"),
        (("walk_pose", "home"), "home"),
    ],
)
def test_the_keyframe_in_which_a_robot_stands(names, found):
    """Keyframes hold a whole robot, so a name that may be a standing posture is taken for one, and
    so is a file's only keyframe.
    """
    keys = "".join(f'<key name="{name}" qpos="0 0 0 1 0 0 0 {k}"/>' for k, name in enumerate(names))
    robot = robot_from(mjcf(floating(body("leg")), after=KEYS.format(keys)), ".xml")
    assert reference_name(robot, None) == found


def test_the_neutral_posture_keeps_to_the_limits():
    """A joint that cannot be at zero stands at the limit nearest to it, with those that follow it;
    zero within rounding stays.
    """
    limits = {
        "knee": (-2.7, -0.6),
        "ankle": (0.3, 1.0),
        "hip": (-1.0, 1.0),
        "toe": (1e-5, 1.0),
        "odd": (1.0, -1.0),
    }
    joints = [
        joint(
            name,
            "base",
            name,
            more=f'<limit lower="{low}" upper="{high}" effort="1" velocity="1"/>',
        )
        for name, (low, high) in limits.items()
    ]
    follower = joint(
        "rod", "base", "rod", more='<mimic joint="knee" multiplier="-2" offset="0.1"/>' + LIMIT
    )
    robot = robot_from(urdf(*map(link, ("base", *limits, "rod")), *joints, follower))
    q = configuration(robot)
    expected = {"knee": -0.6, "ankle": 0.3, "hip": 0.0, "toe": 0.0, "odd": 0.0, "rod": 1.3}
    assert {name: robot.joint(name).value(q) for name in expected} == pytest.approx(
        expected, abs=1e-15
    )
    assert not robot.start.flags.writeable


def limits(text):
    """The limits of a joint, "LOW HIGH"."""
    low, high = text.split()
    return f'<limit lower="{low}" upper="{high}" effort="1" velocity="1"/>'


def leg(knee="0 2.5", axis="0 1 0", foot="foot", bend="0 0 0", hip="-9 9", ankle="-9 9"):
    """A leg of three parallel joints under a body, its shank turned by `bend` [rad]."""
    below = '<origin xyz="0 0 {}" rpy="{}"/>'
    return urdf(
        *map(link, ("base", "thigh", "shank", foot)),
        joint("hip", "base", "thigh", axis="0 -1 0", more=limits(hip)),
        joint("knee", "thigh", "shank", axis=axis, more=below.format(-0.3, bend) + limits(knee)),
        joint(
            "ankle", "shank", foot, axis="0 1 0", more=below.format(-0.25, "0 0 0") + limits(ankle)
        ),
    )


@pytest.mark.parametrize(
    ("knee", "axis", "angle"),
    [
        ("0 2.5", "0 1 0", 30.0),
        ("-2 0", "0 1 0", -30.0),
        ("-3 0.3", "0 -1 0", -30.0),
        ("0 0.2", "0 1 0", math.degrees(0.2)),
        ("-2 2", "0 1 0", 30.0),
        ("-2 2", "0 -1 0", -30.0),
    ],
)
def test_straight_legs_are_bent_where_no_posture_is_known(knee, axis, angle):
    """The knee by 30°, or to its limit, to the side with more room, else forward; the foot stays
    below the hip, and level.
    """
    robot = robot_from(leg(knee, axis))
    assert reference_name(robot, None) == "neutral_bent"
    q, straight = configuration(robot), configuration(robot, Posture(reference="neutral"))
    assert math.degrees(robot.joint("knee").value(q)) == pytest.approx(angle)
    state = dynamics(robot, np.stack([q, straight]))
    _, hip, shank, foot = state.position[0]
    np.testing.assert_allclose(foot[:2], hip[:2], atol=1e-12)
    assert foot[2] > state.position[1, 3, 2]
    np.testing.assert_allclose(*state.rotation[:, 3], atol=1e-12)
    assert np.sign(shank[0]) == np.sign(angle if axis == "0 1 0" else -angle)
    profile = shock_profile(Scene(robot="r.urdf", contact=robot.bodies[3].name), robot)
    assert "30 deg at the knees" in posture_text(profile)
    nearly_straight = abs(angle) < 15.0
    assert [warning.kind for warning in profile.health.warnings if warning.kind == "straight"] == [
        "straight"
    ] * nearly_straight


@pytest.mark.parametrize(
    ("given", "knee", "under_hip"),
    [
        ({"knee": "0.2 2.3"}, 0.2 + math.pi / 6, True),
        ({"knee": "0.35 2.3"}, 0.35, True),
        ({"knee": "-2.7 -0.8"}, -0.8, True),
        ({"hip": "-1.6 0"}, math.pi / 6, False),
        ({"hip": "-1.6 0", "knee": "-2 2"}, -math.pi / 6, True),
        ({"ankle": "-0.1 0.1"}, math.pi / 6, False),
        ({"ankle": "-0.1 0.1", "hip": "-0.2 0.2"}, 0.3, False),
        ({"bend": "0 0.5 0"}, 0.0, True),
        ({"bend": "0 0.5 0", "knee": "0.1 2"}, 0.1, True),
    ],
    ids=str,
)
def test_limits_of_joints_leave_feet_level_and_below_the_hips_where_they_can(
    given, knee, under_hip
):
    """As level as with all joints at zero, and on the same line from the hip unless a limit of hip
    or ankle forbids that.
    """
    robot = robot_from(leg(**given))
    q = configuration(robot)
    zero = configuration(robot, Posture(joints={"*": 0.0}))
    state = dynamics(robot, np.stack([q, zero]))
    np.testing.assert_allclose(*state.rotation[:, 3], atol=1e-12)
    assert outside_limits(robot, q) == ()
    assert robot.joint("knee").value(q) == pytest.approx(knee, abs=1e-12)
    ankle, ankle_at_zero = state.position[:, 3] - state.position[:, 1]
    turned = math.atan2(ankle[0], -ankle[2]) - math.atan2(ankle_at_zero[0], -ankle_at_zero[2])
    assert (abs(turned) < 1e-9) is under_hip


def dog(knee="-2 2", foot=""):
    """Four legs of thigh and calf under a trunk; a calf ends in a ball, or in a link that is called
    as `foot` says.
    """
    parts = [link("trunk", "8")]
    ball = (
        '<collision><origin xyz="0 0 -0.2"/><geometry><sphere '
        'radius="0.02"/></geometry></collision>'
    )
    for name, x, y in (("FL", 0.2, 0.1), ("FR", 0.2, -0.1), ("RL", -0.2, 0.1), ("RR", -0.2, -0.1)):
        halfway = f'<origin xyz="0 0 -0.1"/>{INERTIA}'
        parts += [
            link(f"{name}_thigh", "0.6"),
            link(f"{name}_calf", "0.2", halfway, "" if foot else ball),
        ]
        hip, below = f'<origin xyz="{x} {y} 0"/>{limits("-2 2")}', '<origin xyz="0 0 -0.2"/>'
        parts += [joint(f"{name}_hip", "trunk", f"{name}_thigh", more=hip)]
        parts += [joint(f"{name}_knee", f"{name}_thigh", f"{name}_calf", more=below + limits(knee))]
        if foot:
            parts += [
                link(f"{name}_{foot}", "0.01"),
                joint(f"{name}_end", f"{name}_calf", f"{name}_{foot}", "fixed", more=below),
            ]
    return urdf(*parts)


def test_a_leg_whose_calf_is_the_foot_is_bent_as_one_with_a_foot_at_its_end():
    """The calf's origin is at the knee; it ends at the lowest point of its shapes, or twice as far
    as its centre of mass.
    """
    for text, shank in (
        (dog(foot="foot"), 0.2),
        (dog(), 0.22),
        (dog().replace("sphere radius", "sphere size"), 0.2),
    ):
        robot = robot_from(text)
        q = configuration(robot)
        hip = -math.atan2(shank * math.sin(math.pi / 6), 0.2 + shank * math.cos(math.pi / 6))
        assert [robot.joint(f"FL_{name}").value(q) for name in ("hip", "knee")] == pytest.approx(
            [hip, math.pi / 6]
        )


def test_legs_of_femur_and_tibia_are_bent():
    """No joint or link is named otherwise like a part of a leg."""
    text = dog(foot="pad").replace("thigh", "femur").replace("calf", "tibia").replace("knee", "2")
    assert configuration(robot_from(text)) == pytest.approx(
        configuration(robot_from(dog(foot="foot")))
    )


@pytest.mark.parametrize("knee", [f"{-k} {k}" for k in (0.06, 0.1, 0.14, 0.2, 0.3)])
def test_a_leg_is_nearly_straight_where_its_foot_hardly_moves_in_one_direction(knee):
    """Below 5 % of the largest speed for joint rates of one length, by finite differences of the
    place of the foot.
    """
    robot = robot_from(dog(knee, foot="foot"))
    q = configuration(robot)
    names = ("FL_hip", "FL_knee")

    def place(rates):
        moved = configuration(
            robot,
            joints={
                name: robot.joint(name).value(q) + rate
                for name, rate in zip(names, rates, strict=True)
            },
        )
        return robot.body_placements(moved)[robot.frame("FL_foot").body].act(
            robot.frame("FL_foot").offset
        )[[0, 2]]

    h = 1e-6
    jacobian = np.stack(
        [(place(rates) - place(-rates)) / (2.0 * h) for rates in h * np.eye(2)], axis=1
    )
    most, least = np.linalg.svd(jacobian, compute_uv=False)
    warned = [
        one
        for one in shock_profile(Scene(robot="r.urdf", contact="FL_foot"), robot).health.warnings
        if one.kind == "straight"
    ]
    assert bool(warned) is bool(least < 0.05 * most)


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {
            "posture": Posture(
                joints={"ankle": 0.2}, joints_deg={"k*": 50.0}, base_rpy_deg=(0.0, 10.0, 0.0)
            )
        },
        {
            "closure": (
                Closure(
                    a=LoopEnd(frame="foot"),
                    b=LoopEnd(frame="base", offset=(0.1, 0.0, -0.4)),
                    directions=("x", "z"),
                ),
            )
        },
    ],
)
def test_the_scene_of_a_computed_posture_gives_the_same_landing_where_none_is_computed(
    tmp_path, monkeypatch, changes
):
    """It names the joints and their values, and what is set besides; the document has the position
    of every joint.
    """
    (tmp_path / "leg.urdf").write_text(leg())
    scene = Scene(robot=str(tmp_path / "leg.urdf"), contact="foot", **changes)
    profile = shock_profile(scene)
    assert profile.landing.scene.posture.reference == "neutral_bent"
    (tmp_path / "landing.toml").write_text(scene_text(profile.scene, tmp_path))
    monkeypatch.setattr("shockpc.robot.load.bent_legs", lambda robot: None)
    read = read_scene(tmp_path / "landing.toml")
    again = shock_profile(read, load_robot(read.robot))
    assert "neutral_bent" not in again.robot.postures
    np.testing.assert_allclose(again.q, profile.q, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(again.delta_v, profile.delta_v, rtol=0.0, atol=1e-12)
    positions = {one["joint"]: one["position_deg"] for one in document(profile)["tables"]["joints"]}
    assert positions == {
        joint.name: math.degrees(joint.value(profile.q))
        for joint in profile.robot.single_joints[1:]
    }


ARM = (
    leg(foot="hand")
    .replace("thigh", "upper")
    .replace("shank", "forearm")
    .replace("knee", "elbow")
    .replace("ankle", "wrist")
)


@pytest.mark.parametrize(
    "text", [leg(bend="0 0.3 0"), leg("0 0"), leg(axis="1 0 0"), ARM, "solo12", "five_bar"]
)
def test_other_limbs_are_left_as_they_are(text):
    """Bent already, without room or a parallel axis, not named like a leg; of a robot with a
    standing posture, or joined limbs.
    """
    robot = robot_from(text) if "<" in text else known_robot(text)
    assert "neutral_bent" not in robot.postures


LEGS = """<body name="thigh" pos="0 0 0"><joint name="hip" axis="0 -1 0"/>{0}<body name="shank" pos="0 0 -0.3">
<joint name="knee" axis="0 1 0" range="0 2.5"/>{0}
<body name="{1}" pos="0 0 -0.25"><joint name="ankle" axis="0 1 0"/>{0}</body></body></body>"""
DIFFER = {
    "the foot has a name of its own": ("leg_end", ""),
    "a keyframe that only places the base": (
        "foot",
        '<key name="home" qpos="0.1 0.2 0.9 1 0 0 0 0 0 0"/>',
    ),
    "both": ("end", '<key name="home" qpos="0 0 0.9 1 0 0 0 0 0 0"/>'),
}


@pytest.mark.parametrize("case", DIFFER)
def test_a_robot_stands_the_same_way_as_a_urdf_and_as_an_mjcf(case):
    """Although links that are named like a foot, and a keyframe of the base, are in one of the two
    files alone.
    """
    foot, key = DIFFER[case]
    text = mjcf(
        f'<body name="base"><freejoint/>{BODY}{LEGS.format(BODY, foot)}</body>',
        '<compiler angle="radian"/>',
        KEYS.format(key),
    )
    robots = robot_from(leg()), robot_from(text, ".xml")
    angles = [
        {name: robot.joint(name).value(configuration(robot)) for name in ("hip", "knee", "ankle")}
        for robot in robots
    ]
    assert angles[0]["knee"] == pytest.approx(math.pi / 6)
    assert angles[0] == pytest.approx(angles[1], abs=1e-12)


def test_a_keyframe_that_bends_a_joint_is_how_the_robot_stands():
    """And so is one of a robot whose legs are not straight where every joint is at zero."""
    straight = f'<body name="base"><freejoint/>{BODY}{LEGS.format(BODY, "foot")}</body>'
    crooked = straight.replace('name="shank" pos="0 0 -0.3"', 'name="shank" pos="0.2 0 -0.3"')
    for bodies, knee in ((straight, 0.1), (crooked, 0.0)):
        key = KEYS.format(f'<key name="home" qpos="0 0 0.9 1 0 0 0 0 {knee} 0"/>')
        assert (
            reference_name(
                robot_from(mjcf(bodies, '<compiler angle="radian"/>', key), ".xml"), None
            )
            == "home"
        )


@pytest.mark.parametrize("name", ["g1", "alexander", "human"])
def test_humanoids_without_a_posture_stand_with_bent_knees(name):
    """Both knees by 30°, all joints within their limits, both feet turned and placed alike."""
    robot = known_robot(name)
    q = configuration(robot)
    knees = [
        joint.value(q)
        for joint in robot.single_joints
        if "knee" in joint.name.casefold() and joint.axis is not None
    ]
    assert sorted(map(abs, knees))[-2:] == pytest.approx([math.pi / 6] * 2)
    assert outside_limits(robot, q) == ()
