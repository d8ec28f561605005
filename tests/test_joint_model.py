"""What the joints do in an impact (Section 3.1.2): free, geared, locked, and everything in between."""

import itertools
import json
from dataclasses import replace

import dense
import numpy as np
import pinocchio as pin
import pytest
from commands import run, says
from robot_texts import LIMIT, body, floating, joint, link, mjcf, refused, urdf
from trees import known_robot, robot_from

from shockpc import Contact, Joints, RobotError, Rotor, Scene, SceneError, Strike, shock_profile
from shockpc.landing.joint_model import joint_model
from shockpc.method.dynamics import dynamics
from shockpc.show.header import header_lines

FRONT = tuple(Contact(frame=foot) for foot in ("FL_foot", "FR_foot"))
FREE, LOCKED = Joints(model="free"), Joints(model="locked")


def geared(inertia, pattern="*"):
    return Joints(armature={pattern: inertia})


def go2(joints):
    return shock_profile(Scene(robot="go2", contact=FRONT, joints=joints), known_robot("go2"))


def joint_lines(profile):
    """What the header says of the joints."""
    return dict(header_lines(profile))["joint model"]


# From free to locked


def distance(one, other):
    """Largest difference of any body's jump, in m/s and rad/s."""
    return float(
        np.abs(np.stack([one.delta_v - other.delta_v, one.delta_omega - other.delta_omega])).max()
    )


@pytest.mark.parametrize(
    ("name", "contact"), [("go2", FRONT), ("quadruped", (Contact(frame="hind_foot"),))]
)
def test_geared_goes_from_free_to_locked_over_12_decades(name, contact):
    """Free as the reflected inertia vanishes, locked as it grows; proportional to it near both
    ends, and continuous between.
    """

    def at(joints):
        scene = Scene(
            robot=name, contact=contact, strike=Strike(strike_angle_deg=10.0), joints=joints
        )
        return shock_profile(scene, known_robot(name))

    free, locked = at(FREE), at(LOCKED)
    found = [at(geared(float(inertia))) for inertia in 10.0 ** np.arange(-6.0, 6.5, 0.5)]
    whole = distance(free, locked)
    from_free, from_locked = (
        [distance(one, end) / whole for one in found] for end in (free, locked)
    )
    assert from_free[0] < 1e-2
    assert from_locked[-1] < 1e-4
    # Ten times the inertia changes the result by ten times as much at the free end, and by a tenth
    # at the locked end.
    assert from_free[2] / from_free[0] == pytest.approx(10.0, rel=0.1)
    assert from_locked[-3] / from_locked[-1] == pytest.approx(10.0, rel=0.1)
    assert max(distance(one, other) / whole for one, other in itertools.pairwise(found)) < 0.5
    assert all(one.health.error_bound < 1e-15 and one.health.double_error < 1e-9 for one in found)


@pytest.mark.parametrize(
    ("joints", "name", "jump", "ropc"),
    [
        (Joints(drives="none"), "free", 0.003, 37.5),
        (geared(0.01), "geared", 0.07, 3.2),
        (geared(0.05), "geared", 0.25, 1.01),
        (geared(0.2), "geared", 0.48, 0.66),
        (LOCKED, "locked", 0.80, 0.85),
    ],
    ids=["free", "0.01", "0.05", "0.2", "locked"],
)
def test_the_trunk_of_a_go2(joints, name, jump, ropc):
    """Two front feet, 1 m/s down: the joint model decides the jump of the trunk [m/s], and its RoPc
    is not even monotone.
    """
    profile = go2(joints)
    assert profile.joint_model == name
    assert abs(profile.rotation[0] @ profile.delta_v[0])[2] == pytest.approx(jump, abs=0.006)
    assert profile.ropc[0] == pytest.approx(ropc, rel=0.01)


def test_the_bracket_is_what_the_other_scenes_give():
    """Free and locked in the bracket are the profiles of the same landing with free and with locked
    joints.
    """
    bracket = {row.place: row for row in go2(geared(0.05)).bracket}
    found = bracket["base"].free, bracket["base"].as_modelled, bracket["base"].locked
    assert found == pytest.approx(
        [float(go2(joints).shock_com[0]) for joints in (FREE, geared(0.05), LOCKED)], rel=1e-10
    )
    assert "imu" in bracket
    assert bracket["base"].springs_free is None


def test_compliant_legs_with_locked_motors():
    """Every other joint is locked; with a spring in every joint that is the landing with free
    joints.
    """
    sprung = Joints(drives="none", stiffness={"*_calf_joint": 1e3})
    trunk = go2(sprung).bracket[0]
    expected = float(
        go2(Joints(drives="none", locked=("*_hip_joint", "*_thigh_joint"))).shock_com[0]
    )
    assert trunk.springs_free == pytest.approx(expected, rel=1e-10)
    assert abs(trunk.springs_free - trunk.locked) > 1e-4
    everywhere = go2(Joints(drives="none", stiffness={"*": 1e3})).bracket[0]
    assert everywhere.springs_free == everywhere.free


def test_drives_that_no_joint_has_are_not_named():
    """Of locked joints, and of those whose drives the scene gives, the catalogue's drives say
    nothing.
    """
    robot = known_robot("go2")
    assert joint_model(robot, Joints(locked=("FL_*",))).drives == "drives of go2, derived"
    assert [joint_model(robot, joints).drives for joints in (LOCKED, geared(0.01))] == ["", ""]


# Joint by joint


def test_a_pattern_means_the_joints_that_match_it():
    """Later patterns replace earlier ones; the base has no armature."""
    robot = known_robot("go2")
    found = joint_model(robot, Joints(drives="none", armature={"*_calf_joint": 0.05, "FL_*": 0.02}))
    assert {
        joint.name: inertia
        for joint in robot.joints[1:]
        if (inertia := found.armature[joint.v].item())
    } == {
        **{f"{leg}_calf_joint": 0.05 for leg in ("FR", "RL", "RR")},
        **{f"FL_{part}_joint": 0.02 for part in ("hip", "thigh", "calf")},
    }
    assert not found.armature[:6].any()
    assert found.name == "mixed"


def test_a_rotor_reflects_its_inertia_by_the_square_of_its_gear_ratio():
    """9² · 1e-4 = 0.0081 kg m²: the landing is that with the reflected inertia given."""
    rotor = Joints(rotor={"*": Rotor(inertia=1e-4, gear_ratio=9.0)})
    np.testing.assert_allclose(
        joint_model(known_robot("go2"), rotor).armature[6:], 0.0081, rtol=1e-15
    )
    assert distance(go2(rotor), go2(geared(81e-4))) < 1e-12


def test_reflected_inertia_is_on_the_diagonal_and_not_on_the_base():
    """An MJCF's armature is part of the joint model: the inertia of the bodies is without it, and
    the floating base has none.
    """
    text = mjcf(
        floating(body("b", joints='<joint name="j" axis="0 1 0" armature="0.3"/>')),
        '<default><joint armature="0.2"/></default>',
    )
    robot = robot_from(text, ".xml")
    np.testing.assert_array_equal(joint_model(robot, Joints()).armature, [0.0] * 6 + [0.3])
    assert not joint_model(robot, FREE).armature.any()
    q = np.array([0, 0, 0, 0, 0, 0, 1.0, 0.3])
    np.testing.assert_allclose(
        dynamics(robot, q[None]).H[0], dense.inertia(robot.model, q), atol=1e-15
    )


# Rotors beside the robot: an SRDF's <rotor_params>

BELOW = f'<origin xyz="0.05 0.02 -0.3" rpy="0 0.3 0"/>{LIMIT}'
ARM = urdf(
    *map(link, ("base", "upper", "lower", "hand")),
    joint("shoulder", "base", "upper", more=BELOW),
    joint("elbow", "upper", "lower", more=BELOW),
    joint("wrist", "lower", "hand", more=BELOW),
    name="arm",
)


def rotor_file(*rotors):
    """An SRDF with a rotor for every (joint, mass, gear_ratio)."""
    lines = "".join(
        f'<joint name="{joint}" mass="{mass}" gear_ratio="{ratio}"/>'
        for joint, mass, ratio in rotors
    )
    return f'<robot name="arm"><rotor_params>{lines}</rotor_params></robot>'


ROTORS = rotor_file(("shoulder", "1.5e-4", "9"), ("elbow", "2e-4", "-36.5"))


def test_rotors_of_an_srdf_are_those_pinocchio_loads(tmp_path):
    """Armature gear_ratio² · inertia, on the joints that the SRDF names; one that the robot does
    not have is ignored.
    """
    (tmp_path / "arm.srdf").write_text(ROTORS)
    model = pin.buildModelFromXML(ARM, pin.JointModelFreeFlyer())
    pin.loadRotorParameters(model, str(tmp_path / "arm.srdf"), False)
    found = joint_model(
        robot_from(
            ARM, srdf=ROTORS.replace("</r", '<joint name="other" mass="1" gear_ratio="1"/></r', 1)
        ),
        Joints(),
    )
    np.testing.assert_allclose(
        found.armature, model.rotorGearRatio**2 * model.rotorInertia, rtol=1e-15
    )
    np.testing.assert_allclose(found.armature[6:], [81.0 * 1.5e-4, 36.5**2 * 2e-4, 0.0], rtol=1e-15)
    assert found.name == "mixed"  # the wrist has no rotor


def test_rotors_of_an_srdf_are_those_that_a_scene_could_give():
    """Joint by joint; a scene with free joints ignores them."""
    contact = (Contact(frame="hand", offset=(0.1, 0.0, -0.2)),)
    given = Joints(
        rotor={
            "shoulder": Rotor(inertia=1.5e-4, gear_ratio=9.0),
            "elbow": Rotor(inertia=2e-4, gear_ratio=-36.5),
        }
    )
    with_rotors, without = robot_from(ARM, srdf=ROTORS), robot_from(ARM)
    landed, same, free, bare = (
        shock_profile(Scene(robot="arm", contact=contact, joints=joints), robot)
        for robot, joints in (
            (with_rotors, Joints()),
            (without, given),
            (with_rotors, FREE),
            (without, Joints()),
        )
    )
    assert [one.joint_model for one in (landed, same, free, bare)] == [
        "mixed",
        "mixed",
        "free",
        "free",
    ]
    assert distance(landed, same) < 1e-12
    assert distance(free, bare) == 0.0
    assert distance(landed, bare) > 1e-2


@pytest.mark.parametrize(
    ("mass", "ratio"),
    [
        ("-1e-4", "9"),
        ("1e-4 2e-4", "9"),
        ("", "9"),
        ("1e-4", ""),
        ("1e-4", "9 9"),
        ("light", "9"),
        ("1e-4", "inf"),
        ("nan", "9"),
    ],
)
def test_a_rotor_without_one_finite_number_each_is_refused(mass, ratio):
    """An attribute that is missing counts as an empty one."""
    text = rotor_file(("elbow", mass, ratio))
    for written in {text, text.replace(' gear_ratio=""', "")}:
        refused(
            RobotError,
            ("robot.srdf", '"elbow"', f'mass "{mass}"', f'gear_ratio "{ratio}"'),
            lambda srdf: robot_from(ARM, srdf=srdf),
            written,
        )


# What is known of the drives


def intervals(robot, joints):
    """Of each joint: low, armature, high, and the status of its source."""
    model = joint_model(robot, joints)
    status = {name: source.status for source in model.sources for name in source.joints}
    return {
        joint.name: (
            *(float(a[joint.v.start]) for a in (model.low, model.armature, model.high)),
            status.get(joint.name),
        )
        for joint in robot.single_joints
        if joint.kind != "free"
    }


INF = float("inf")
ROD = '<joint name="rod" axis="0 1 0"/>'
MOTORS = """<actuator><motor joint="hip" gear="10" ctrllimited="true" ctrlrange="-2 2"/>
<position joint="knee" forcelimited="true" forcerange="-{} {}"/></actuator>"""


def limb(*efforts, armatures=()):
    """A chain of joints j0, j1, … with effort limits, and reflected inertias of the first of them."""
    parts = [link("l0")]
    for k, effort in enumerate(efforts):
        dynamics = "".join(f'<dynamics armature="{number}"/>' for number in armatures[k : k + 1])
        more = BELOW.replace(
            LIMIT, f'<limit lower="-1" upper="1" effort="{effort}" velocity="1"/>{dynamics}'
        )
        parts += [link(f"l{k + 1}"), joint(f"j{k}", f"l{k}", f"l{k + 1}", more=more)]
    return robot_from(urdf(*parts))


@pytest.mark.parametrize(
    ("efforts", "armatures", "expected"),
    [
        # One number for joints of different effort is a setting; for equal joints, or of each joint
        # its own, it is a drive.
        ((20, 50), (0.1, 0.1), [(0.0, 0.1, INF, "simulation model")] * 2),
        ((20, 20), (0.1, 0.1), [(0.1, 0.1, 0.1, "file")] * 2),
        ((20, 50), (0.1, 0.3), [(0.1, 0.1, 0.1, "file"), (0.3, 0.3, 0.3, "file")]),
        ((0, 0), (0.1, 0.1), [(0.1, 0.1, 0.1, "file")] * 2),
        # Nor does anything say that many joints without efforts have the same drive.
        ((0, 0, 0), (0.1, 0.1, 0.1), [(0.0, 0.1, INF, "simulation model")] * 3),
        # An armature says nothing of another joint; a joint without effort limit among others with
        # one has no motor.
        ((20, 50), (0.1,), [(0.1, 0.1, 0.1, "file"), (0.0, 0.0, INF, "unknown")]),
        ((20, 0), (), [(0.0, 0.0, INF, "unknown"), (0.0, 0.0, 0.0, None)]),
        ((20, 0), (0.1, 0.1), [(0.1, 0.1, 0.1, "file")] * 2),
        ((0, 0), (), [(0.0, 0.0, INF, "unknown")] * 2),
    ],
)
def test_what_a_file_says_of_its_drives(efforts, armatures, expected):
    assert list(intervals(limb(*efforts, armatures=armatures), Joints()).values()) == expected


def test_effort_limits_of_an_mjcf_are_those_of_its_actuators():
    """A motor's control is its force, a force range limits every actuator, and gears multiply both;
    rods have no motor.
    """
    driven = '<joint name="{}" axis="0 1 0" armature="0.01"/>'
    bodies = [
        body("b", joints=driven.format("hip")),
        body("c", joints=driven.format("knee")),
        body("d", joints=ROD),
    ]
    motors = MOTORS.format(20, 20), MOTORS.format(50, 50)
    alike, apart = (robot_from(mjcf(floating(*bodies), after=text), ".xml") for text in motors)
    assert [dict(robot.motors) for robot in (alike, apart)] == [
        {"hip": 20.0, "knee": 20.0},
        {"hip": 20.0, "knee": 50.0},
    ]
    assert list(intervals(alike, Joints()).values()) == [(0.01, 0.01, 0.01, "file")] * 2 + [
        (0.0, 0.0, 0.0, None)
    ]
    assert (
        list(intervals(apart, Joints()).values())[:2] == [(0.0, 0.01, INF, "simulation model")] * 2
    )


def test_what_a_scene_states_is_exact():
    """Free, locked, or given joints; a rotor of known inertia behind a spring is free for an
    instant.
    """
    robot = limb(20, 50, armatures=(0.1, 0.1))
    assert set(intervals(robot, FREE).values()) == {(0.0, 0.0, 0.0, None)}
    assert set(intervals(robot, LOCKED).values()) == {(0.1, 0.1, 0.1, None)}
    assert set(intervals(robot, geared(0.2)).values()) == {(0.2, 0.2, 0.2, "given")}
    soft = Joints(rotor={"*": Rotor(inertia=1e-3, gear_ratio=10.0, stiffness=200.0)})
    assert set(intervals(robot, soft).values()) == {(0.0, 0.0, 0.0, "given")}
    assert set(intervals(robot, replace(soft, model="rigid")).values()) == {
        (0.1, 0.1, 0.1, "given")
    }


@pytest.mark.parametrize(
    "name", ["a1", "go2", "talos", "anymal_b", "cassie", "icub", "hyq", "g1", "romeo"]
)
def test_the_interval_of_every_joint_holds_its_armature(name):
    robot = known_robot(name)
    for low, armature, high, _ in intervals(robot, Joints()).values():
        assert 0.0 <= low <= armature <= high


# Refused

PAIR = urdf(
    *map(link, "abc"),
    joint("j", "a", "b"),
    joint("k", "b", "c", more=f'<mimic joint="j" multiplier="2"/>{LIMIT}'),
    name="pair",
)


@pytest.mark.parametrize(
    ("joints", "error", "names"),
    [
        (Joints(locked=("j",)), SceneError, ('"j" is locked', '"k"')),
        (Joints(locked=("k",)), SceneError, ('"k" is locked', '"j"')),
        (geared(0.0, "j"), SceneError, ('"j" is 0', '"free"')),
        (
            Joints(rotor={"j": Rotor(inertia=-1e-4, gear_ratio=9.0)}),
            SceneError,
            ('"j" is -0.0081', '"free"'),
        ),
        (
            Joints(rotor={"j": Rotor(inertia=1e-4, gear_ratio=0.0)}),
            SceneError,
            ('"j" is 0', '"free"'),
        ),
        (Joints(model="free", armature={"j": 0.1}), SceneError, ('"free"', '"j"')),
        (Joints(model="geared"), SceneError, ("armature", "rotor", "gear_ratio")),
        (
            Joints(armature={"j": 0.1}, rotor={"*": Rotor(inertia=1e-4, gear_ratio=9.0)}),
            SceneError,
            ('"j" is given an armature and',),
        ),
    ],
)
def test_a_joint_model_that_cannot_be_is_refused(joints, error, names):
    """The message names the joints and what would be valid."""
    refused(error, names, joint_model, robot_from(PAIR), joints)


def test_rigid_springs_hold_their_joints_and_join_their_rotors():
    """A joint with its spring is locked, a rotor behind one counts; without springs nothing
    changes, as a warning says.
    """
    soft = Rotor(inertia=1e-4, gear_ratio=9.0, stiffness=300.0)
    joints = Joints(rotor={"*_hip_joint": soft}, stiffness={"*_calf_joint": 200.0}, drives="none")
    plain = Joints(
        rotor={"*_hip_joint": replace(soft, stiffness=None)},
        locked=("*_calf_joint",),
        drives="none",
    )
    assert distance(go2(replace(joints, model="rigid")), go2(plain)) == 0.0
    assert distance(go2(joints), go2(plain)) > 1e-3
    without = go2(Joints(model="rigid"))
    assert distance(without, go2(Joints())) == 0.0
    assert "no joint has a spring, so nothing changes" in " ".join(
        map(str, without.health.warnings)
    )
    scene = Scene(robot="anymal_b", contact="LF_FOOT", joints=Joints(model="rigid"))
    with pytest.raises(SceneError, match=r'the rotors behind those of ".*HAA".* are not known'):
        shock_profile(scene, known_robot("anymal_b"))


def test_leader_and_follower_may_be_locked_together():
    scene = Scene(
        robot="r",
        contact=Contact(frame="c", offset=(0.1, 0.0, -0.1)),
        joints=Joints(locked=("j", "k")),
    )
    profile = shock_profile(scene, robot_from(PAIR))
    assert profile.joint_model == "locked"
    assert not profile.delta_qd[6:].any()


@pytest.mark.parametrize(("name", "armature"), [("go2", 0.0), ("anymal_b", 0.0), ("talos", 0.1)])
def test_free_joints_are_those_of_the_model_free(name, armature):
    """Without other drives the inertia of the robot's file remains, Talos' 0.1 kg m² of its SRDF;
    free joints have none.
    """
    robot = known_robot(name)
    without, free = (
        joint_model(robot, joints) for joints in (Joints(drives="none"), Joints(model="free"))
    )
    assert without.armature.max() == armature
    assert not without.drives
    assert (free.name, free.armature.any(), free.drives) == ("free", False, "")


def test_the_header_says_how_joints_become_free():
    """The option that it names does so; drives behind springs are called free with their reason; a
    factor of 1 is none.
    """
    geared = go2(Joints())
    assert "--joints free for free joints" in joint_lines(geared)
    assert "drives none" not in joint_lines(geared)
    sprung = shock_profile(
        Scene(robot="anymal_b", contact=(Contact(frame="LF_FOOT"),)), known_robot("anymal_b")
    )
    assert says(joint_lines(sprung), "free", "spring", "anymal_b, derived")


def test_locked_ball_joints_have_no_jump(capfd):
    """A locked joint has no jump, also where its rate is the length of a vector."""
    outcome = run(
        capfd,
        "analyze",
        "cassie",
        "--contact",
        "toe_left",
        "--joints",
        "locked",
        "--format",
        "json",
    )
    rods = {
        joint["joint"]: joint["delta_qd"]
        for joint in json.loads(outcome.out)["tables"]["joints"]
        if "rod" in joint["joint"]
    }
    assert list(rods.values()) == [0.0] * 4


def test_joints_without_a_solution_have_a_reason(capfd):
    """A rigid robot that stands on one foot cannot stop another that strikes."""
    outcome = run(
        capfd,
        "analyze",
        "talos",
        "--contact",
        "left_sole_link",
        "--stance",
        "right_sole_link",
        "--contact-kind",
        "flat",
    )
    assert outcome.code == 0
    assert says(outcome.out, "(–: ", "locked", '"right_sole_link"')
