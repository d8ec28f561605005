"""What the drives do (Section 3.1.2): free, geared, locked, and everything in between."""

import dataclasses
import itertools

import numpy as np
import pinocchio as pin
import pytest
from robot_texts import LIMIT, body, floating, joint, link, mjcf, urdf
from trees import known_robot, robot_from

from shockpc.errors import RobotError, SceneError, ShockError
from shockpc.model.contact import Contact
from shockpc.model.dynamics import dynamics
from shockpc.model.joint_model import Joints, Rotor, transmission
from shockpc.model.posture import Posture
from shockpc.profile import shock_profile
from shockpc.scene import Scene, Strike

FRONT = tuple(Contact(frame=foot) for foot in ("FL_foot", "FR_foot"))


def go2(joints=Joints(), **changes):  # noqa: B008 - frozen
    scene = Scene(robot="go2", contact=FRONT, strike=Strike(speed=1.0, strike_angle_deg=0.0), joints=joints)
    return shock_profile(dataclasses.replace(scene, **changes), known_robot("go2"))


def base_of(profile):
    """Jump of the trunk's origin along world z [m/s], and the trunk's RoPc [m]."""
    return float((profile.rotation[0] @ profile.delta_v[0])[2]), float(profile.ropc[0])


# From free to locked


INERTIAS = 10.0 ** np.arange(-6.0, 6.5, 0.5)


def distance(one, other):
    """Greatest difference of any body's jump, in m/s and rad/s."""
    return float(
        np.abs(np.concatenate([(one.delta_v - other.delta_v).ravel(), (one.delta_omega - other.delta_omega).ravel()])).max()
    )


@pytest.mark.parametrize("name", ["go2", "quadruped"])
def test_geared_goes_from_free_to_locked_over_12_decades(name):
    """Free as the reflected inertia vanishes, locked as it grows; near both ends in proportion, without a leap between."""
    contact = {"go2": FRONT, "quadruped": (Contact(frame="hind_foot"),)}[name]

    def at(joints):
        scene = Scene(robot=name, contact=contact, strike=Strike(strike_angle_deg=10.0), joints=joints)
        return shock_profile(scene, known_robot(name))

    free, locked = at(Joints(model="free")), at(Joints(model="locked"))
    geared = [at(Joints(armature={"*": float(inertia)})) for inertia in INERTIAS]
    whole = distance(free, locked)
    from_free, from_locked = ([distance(one, end) / whole for one in geared] for end in (free, locked))
    assert from_free[0] < 1e-2
    assert from_locked[-1] < 1e-4
    # A tenth of the inertia is a tenth of the way, at either end.
    assert from_free[2] / from_free[0] == pytest.approx(10.0, rel=0.1)
    assert from_locked[-3] / from_locked[-1] == pytest.approx(10.0, rel=0.1)
    # Half a decade never makes a leap: the whole way is twelve decades long.
    steps = [distance(one, other) / whole for one, other in itertools.pairwise(geared)]
    assert max(steps) < 0.5
    assert all(one.health.error_estimate < 1e-9 for one in geared)


@pytest.mark.parametrize(
    ("joints", "jump", "ropc"),
    [
        (Joints(), 0.003, 37.5),
        (Joints(armature={"*": 0.01}), 0.07, 3.2),
        (Joints(armature={"*": 0.05}), 0.25, 1.01),
        (Joints(armature={"*": 0.2}), 0.48, 0.66),
        (Joints(model="locked"), 0.80, 0.85),
    ],
    ids=["free", "0.01", "0.05", "0.2", "locked"],
)
def test_the_trunk_of_a_go2(joints, jump, ropc):
    """Two front feet, 1 m/s down: what its trunk feels is decided by the drives, and its RoPc does not even move one way."""
    found, radius = base_of(go2(joints))
    assert abs(found) == pytest.approx(jump, abs=0.006)
    assert radius == pytest.approx(ropc, rel=0.01)


def test_the_ropc_of_the_trunk_is_not_monotone():
    free, geared, locked = (base_of(go2(j))[1] for j in (Joints(), Joints(armature={"*": 0.2}), Joints(model="locked")))
    assert free > locked > geared


def test_the_bracket_is_what_the_other_scenes_give():
    """Free and locked in the bracket are the profiles of the same landing with free and with locked drives."""
    bracket = {row.place: row for row in go2(Joints(armature={"*": 0.05})).bracket}
    heaviest = bracket["base"]
    for joints, value in (
        (Joints(model="free"), heaviest.free),
        (Joints(armature={"*": 0.05}), heaviest.as_modelled),
        (Joints(model="locked"), heaviest.locked),
    ):
        assert value == pytest.approx(float(go2(joints).shock_com[0]), rel=1e-10)
    assert "imu" in bracket


# Joint by joint


def armatures(name, joints):
    robot = known_robot(name)
    found = transmission(robot, joints)
    return {
        joint: float(found.armature[robot.model.joints[robot.model.getJointId(joint)].idx_v]) for joint in robot.joint_names
    }, found


def test_a_pattern_means_the_joints_that_fit_it():
    given, found = armatures("go2", Joints(armature={"*_calf_joint": 0.05, "FL_*": 0.02}))
    assert {joint: value for joint, value in given.items() if value} == {
        **{f"{leg}_calf_joint": 0.05 for leg in ("FR", "RL", "RR")},
        **{f"FL_{part}_joint": 0.02 for part in ("hip", "thigh", "calf")},
    }
    assert found.model == "mixed"


def test_a_rotor_counts_by_the_square_of_its_gear_once():
    """9² · 1e-4 = 0.0081 kg m²."""
    given, _ = armatures("go2", Joints(rotor={"*_calf_joint": Rotor(inertia=1e-4, gear_ratio=9.0)}))
    assert given["FL_calf_joint"] == pytest.approx(0.0081, rel=1e-15)
    one, other = go2(Joints(rotor={"*": Rotor(inertia=1e-4, gear_ratio=9.0)})), go2(Joints(armature={"*": 81e-4}))
    assert distance(one, other) < 1e-12


def test_reflected_inertia_is_on_the_diagonal_and_not_on_the_base():
    """An MJCF's armature: the inertia of the bodies comes without it, and the floating base has none."""
    text = mjcf(
        floating(body("b", joints='<joint name="j" axis="0 1 0" armature="0.3"/>')), '<default><joint armature="0.2"/></default>'
    )
    robot = robot_from(text, ".xml")
    found = transmission(robot, Joints())
    np.testing.assert_array_equal(found.armature, [0.0] * 6 + [0.3])
    assert not transmission(robot, Joints(model="free")).armature.any()
    bare = robot_from(text.replace(' armature="0.3"', "").replace('<default><joint armature="0.2"/></default>', ""), ".xml")
    q = np.array([0, 0, 0, 0, 0, 0, 1.0, 0.3])
    np.testing.assert_allclose(dynamics(robot, q[None]).H, dynamics(bare, q[None]).H, atol=1e-15)


def test_an_armature_acts_between_two_bodies():
    """What a drive with reflected inertia a carries is a · Δq̇ of its joint."""
    profile = go2(Joints(armature={"*": 0.05}))
    robot = profile.robot
    for load in profile.loads:
        rate = profile.delta_qd[robot.model.joints[robot.model.getJointId(load.joint)].idx_v]
        assert load.along == pytest.approx(-0.05 * rate, abs=1e-9)


def test_locked_joints_carry_and_free_ones_do_not():
    profile = go2(Joints(locked=("*_calf_joint",)))
    for load in profile.loads:
        carries = abs(load.along) > 1e-9
        assert carries == ("calf" in load.joint)
    assert profile.joint_model == "mixed"


def test_what_is_locked_is_one_body():
    """All joints of the legs locked, the landing of Go2 is that of one rigid body: one rotation everywhere."""
    profile = go2(Joints(model="locked"))
    omega = (profile.rotation @ profile.delta_omega[..., None])[..., 0]
    np.testing.assert_allclose(omega, np.broadcast_to(omega[0], omega.shape), atol=1e-12)
    assert profile.joint_model == "locked"


@pytest.mark.parametrize(
    ("joints", "model"),
    [
        (Joints(), "free"),
        (Joints(armature={"*": 0.1}), "geared"),
        (Joints(model="locked"), "locked"),
        (Joints(locked=("FL_*",)), "mixed"),
    ],
)
def test_no_number_goes_without_its_joint_model(joints, model):
    assert go2(joints).joint_model == model


# Rotors beside the robot: an SRDF's <rotor_params>

BELOW = f'<origin xyz="0.05 0.02 -0.3" rpy="0 0.3 0"/>{LIMIT}'
GEARED_ARM = urdf(
    link("base"), link("upper"), link("lower"), link("hand"),
    joint("shoulder", "base", "upper", more=BELOW), joint("elbow", "upper", "lower", more=BELOW),
    joint("wrist", "lower", "hand", more=BELOW),
    name="arm",
)  # fmt: skip


def rotor_file(*rotors):
    """An SRDF with a rotor for every (joint, mass, gear_ratio)."""
    lines = "".join(f'<joint name="{joint}" mass="{mass}" gear_ratio="{ratio}"/>' for joint, mass, ratio in rotors)
    return f'<robot name="arm"><rotor_params>{lines}</rotor_params></robot>'


ROTORS = rotor_file(("shoulder", "1.5e-4", "9"), ("elbow", "2e-4", "-36.5"), ("of_another_robot", "1", "1"))


def test_a_rotor_beside_the_robot_counts_by_the_square_of_its_gear():
    """gear_ratio² · inertia, on the joints that the SRDF names and on no other; a joint that the robot has not is passed over."""
    found = transmission(robot_from(GEARED_ARM, srdf=ROTORS), Joints())
    np.testing.assert_allclose(found.armature, [0.0] * 6 + [81.0 * 1.5e-4, 36.5**2 * 2e-4, 0.0], rtol=1e-15)
    # The wrist has no rotor.
    assert found.model == "mixed"


def test_rotors_beside_the_robot_are_those_pinocchio_loads(tmp_path):
    """Pinocchio keeps inertia and ratio apart; its own joint-space inertia holds their reflected inertia as ours does."""
    text = ROTORS.replace('<joint name="of_another_robot" mass="1" gear_ratio="1"/>', "")
    (tmp_path / "arm.srdf").write_text(text)
    model = pin.buildModelFromXML(GEARED_ARM, pin.JointModelFreeFlyer())
    pin.loadRotorParameters(model, str(tmp_path / "arm.srdf"), False)
    robot = robot_from(GEARED_ARM, srdf=text)
    np.testing.assert_allclose(robot.model.armature, model.rotorGearRatio**2 * model.rotorInertia, rtol=1e-15)
    assert np.count_nonzero(robot.model.armature) == 2


def test_rotors_beside_the_robot_reach_the_landing():
    """What the SRDF gives is what the scene could have given joint by joint, and free drives know nothing of it."""
    contact = (Contact(frame="hand", offset=(0.1, 0.0, -0.2)),)
    with_rotors, bare = robot_from(GEARED_ARM, srdf=ROTORS), robot_from(GEARED_ARM)
    given = Joints(rotor={"shoulder": Rotor(inertia=1.5e-4, gear_ratio=9.0), "elbow": Rotor(inertia=2e-4, gear_ratio=-36.5)})
    landed = shock_profile(Scene(robot="arm", contact=contact), with_rotors)
    assert landed.joint_model == "mixed"
    assert distance(landed, shock_profile(Scene(robot="arm", contact=contact, joints=given), bare)) < 1e-12
    free = shock_profile(Scene(robot="arm", contact=contact, joints=Joints(model="free")), with_rotors)
    without = shock_profile(Scene(robot="arm", contact=contact), bare)
    assert (free.joint_model, without.joint_model) == ("free", "free")
    assert distance(free, without) == 0.0
    assert distance(landed, without) > 1e-2


@pytest.mark.parametrize(
    ("mass", "ratio"),
    [("-1e-4", "9"), ("1e-4 2e-4", "9"), ("", "9"), ("1e-4", ""), ("1e-4", "9 9"), ("light", "9"), ("1e-4", "inf"), ("nan", "9")],
)
def test_a_rotor_that_is_none_is_refused(mass, ratio):
    with pytest.raises(RobotError) as refusal:
        robot_from(GEARED_ARM, srdf=rotor_file(("elbow", mass, ratio)))
    assert str(refusal.value) == (
        f'robot.srdf: the rotor of joint "elbow" has mass "{mass}" and gear_ratio "{ratio}"; '
        "it takes one number each, the inertia of the rotor [kg m²] not below zero"
    )


def test_a_rotor_without_a_number_is_refused():
    with pytest.raises(RobotError) as refusal:
        robot_from(GEARED_ARM, srdf=rotor_file(("elbow", "1e-4", "9")).replace(' gear_ratio="9"', ""))
    assert str(refusal.value) == (
        'robot.srdf: the rotor of joint "elbow" has mass "1e-4" and gear_ratio ""; '
        "it takes one number each, the inertia of the rotor [kg m²] not below zero"
    )


# Refused, with one clear message each


FOLLOWS = '<mimic joint="j" multiplier="2"/><limit lower="-3" upper="3" effort="1" velocity="1"/>'
PAIR = urdf(
    link("a"), link("b"), link("c"),
    joint("j", "a", "b"), joint("k", "b", "c", more=FOLLOWS),
    name="pair",
)  # fmt: skip
WELDED = mjcf(body("only", joints='<joint name="j" axis="0 1 0"/>'))
POSITIVE = 'a reflected inertia has to be above zero; for none use model = "free"'
ROTOR = 'the inertia has to be above zero and the ratio not zero; for no rotor use model = "free"'


@pytest.mark.parametrize(
    ("text", "joints", "message"),
    [
        (PAIR, Joints(locked=("j",)), 'joint "j" is locked but "k" is geared to it by a mimic; lock both or neither'),
        (PAIR, Joints(locked=("k",)), 'joint "k" is locked but "j" is geared to it by a mimic; lock both or neither'),
        (PAIR, Joints(armature={"j": 0.0}), f'armature of "j" is 0; {POSITIVE}'),
        (PAIR, Joints(armature={"j": -0.5}), f'armature of "j" is -0.5; {POSITIVE}'),
        (
            PAIR,
            Joints(rotor={"j": Rotor(inertia=-1e-4, gear_ratio=9.0)}),
            f'rotor of "j" has inertia -0.0001 kg m² and gear ratio 9; {ROTOR}',
        ),
        (
            PAIR,
            Joints(rotor={"j": Rotor(inertia=1e-4, gear_ratio=0.0)}),
            f'rotor of "j" has inertia 0.0001 kg m² and gear ratio 0; {ROTOR}',
        ),
        (
            PAIR,
            Joints(armature={"root_joint": 0.1}),
            '"root_joint" is the floating base of robot "pair", which has no drive; name a joint',
        ),
        (
            PAIR,
            Joints(locked=("root_joint",)),
            '"root_joint" is the floating base of robot "pair", which has no drive; name a joint',
        ),
        (
            PAIR,
            Joints(model="geared"),
            "the joints are to be geared, but neither the file nor the scene gives any reflected inertia; "
            "give armature (reflected) or rotor (inertia and gear_ratio) for the joints that have a gearbox",
        ),
        (
            WELDED,
            Joints(model="locked"),
            'nothing of robot "m" can move: its base is fixed and no joint is free; free one of them',
        ),
    ],
    ids=[
        "leader alone",
        "follower alone",
        "zero",
        "negative",
        "negative rotor",
        "no gear",
        "base geared",
        "base locked",
        "no inertia",
        "all held",
    ],
)
def test_drives_that_make_no_sense_are_refused(text, joints, message):
    robot = robot_from(text, ".xml" if text.startswith("<mujoco") else ".urdf")
    frame = robot.links[-1]
    with pytest.raises(SceneError) as refusal:
        shock_profile(Scene(robot="r", contact=(Contact(frame=frame, offset=(0.0, 0.0, -0.1)),), joints=joints), robot)
    assert str(refusal.value) == message


def test_locking_leader_and_follower_together_is_fine():
    robot = robot_from(PAIR)
    profile = shock_profile(
        Scene(robot="r", contact=(Contact(frame="c", offset=(0.0, 0.0, -0.1)),), joints=Joints(locked=("j", "k"))), robot
    )
    assert profile.joint_model == "locked"
    assert not profile.delta_qd[6:].any()


def test_everything_locked_on_a_fixed_base_is_refused_as_such():
    """Also where a URDF's base is held by the scene."""
    scene = Scene(
        robot="leg",
        base="fixed",
        contact=(Contact(frame="heel"),),
        joints=Joints(model="locked"),
        posture=Posture(reference="straight"),
    )
    with pytest.raises(ShockError) as refusal:
        shock_profile(scene, known_robot("leg"))
    assert str(refusal.value) == 'nothing of robot "leg" can move: its base is fixed and no joint is free; free one of them'
