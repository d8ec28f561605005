"""Proven numbers and what is reported of them: bounds, errors of double precision, sensitivity to
the data, dependent rows.
"""

import functools
import itertools
from contextlib import nullcontext
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from unittest import mock

import numpy as np
import pytest
from commands import run
from flint import arb
from hypothesis import given
from hypothesis import strategies as st
from maximal import maximal_jumps
from proof_check import MET, assert_maps_are_those_of_the_proof, body_errors, excess
from robot_texts import joint, link, urdf
from trees import known_robot, robot_from

from shockpc import (
    Contact,
    Joints,
    Posture,
    Rotor,
    Scene,
    ShockError,
    ShockWarning,
    SolveError,
    Strike,
    resolve,
    shock_maps,
    shock_profile,
)
from shockpc.bench.cases import FAMILIES, bent, chain
from shockpc.core.impulse import RowSpace
from shockpc.judgement.accuracy import (
    clearly_insensitive,
    data_sensitivity,
    double_error,
    impulse_bound,
    impulse_sizes,
    sensitive,
)
from shockpc.landing.contact import contact_constraint
from shockpc.landing.joint_model import joint_model
from shockpc.landing.posture import configuration
from shockpc.landing.scenes.scene_file import plane_of
from shockpc.method.approach import Motion
from shockpc.method.dynamics import dynamics
from shockpc.method.equation import Posed, System
from shockpc.method.exact.balls import BallSolution, to_double
from shockpc.method.exact.proof import Proof
from shockpc.robot.feet_and_sensors import each_foot

ROUNDING = 2.3e-16
X, Y, Z = np.eye(3)
FEET = ("LF_FOOT", "RF_FOOT", "LH_FOOT", "RH_FOOT")


def kinds(profile):
    """Kinds of the warnings that concern arithmetic."""
    return {warning.kind for warning in profile.health.warnings} & {"data"}


def test_warnings_take_one_impact_in_balls(monkeypatch):
    """Two more of them, for changes of the last digits, took longer than all numbers; where doubles
    are clear none is needed.
    """
    made = []

    class Counted(BallSolution):
        def __init__(self, *arguments):
            made.append(arguments)
            super().__init__(*arguments)

    monkeypatch.setattr("shockpc.method.exact.proof.BallSolution", Counted)
    profile = shock_profile(Scene(robot="anymal_b", contact="LF_FOOT"), known_robot("anymal_b"))
    assert not sensitive(profile)
    assert len(made) == 1
    assert profile.health.data_sensitivity < 1e-13
    assert len(made) == 3


@pytest.mark.parametrize("name", ["go2", "solo12", "leg"])
def test_what_doubles_call_clearly_insensitive_is(name):
    """In random postures; the two patterns of changed digits are ten times below the threshold at
    least.
    """
    robot, rng, clear = known_robot(name), np.random.default_rng(5), 0
    feet = each_foot(robot) or (robot.bodies[-1].name,)
    for k in range(5):
        joints = {
            joint.name: rng.uniform(*np.clip(joint.limits, -3.0, 3.0))
            for joint in robot.independent_joints
        }
        contacts = tuple(
            Contact(frame=foot, at="frame", kind="point") for foot in feet[: 1 + k % len(feet)]
        )
        profile = shock_profile(
            Scene(robot=name, base="free", contact=contacts, posture=Posture(joints=joints)), robot
        )
        with mock.patch("shockpc.judgement.accuracy.SENSITIVE", 1e-10):
            warned = data_sensitivity(profile)[1]
        clear += clearly_insensitive(profile)
        assert not (clearly_insensitive(profile) and warned)
    assert clear == 5


# Hard landings


def nearly_straight(bend, pitch, strike=0.0):
    """A leg on a fixed base, so many radians from straight, struck along itself or beside."""
    posture = Posture(
        reference="neutral", base_rpy_deg=(0.0, pitch, 0.0), joints={"hind_knee": bend}
    )
    return known_robot("quadruped"), Scene(
        robot="quadruped",
        base="fixed",
        posture=posture,
        contact=Contact(frame="hind_foot", directions=("x", "z")),
        strike=Strike(strike_angle_deg=strike),
    )


@functools.cache
def solved(family, variant, value):
    """A case of the benchmark with its independent solution; None if it is refused."""
    (case,) = (case for case in FAMILIES[family].cases() if case[1:3] == (variant, value))
    try:
        profile = shock_profile(*reversed(case.build()))
    except ShockError:
        return None
    return profile, maximal_jumps(profile.landing, profile.row_space.rows)


@pytest.mark.slow
@pytest.mark.parametrize("name", FAMILIES)
def test_hard_cases_get_proven_numbers(name):
    """Those of the benchmark that have an answer: no error is above the bound, and that is
    rounding; maps agree, or are flagged.

    Chains of 200 links, which take longer than all others, are left to the two tests after this
    one.
    """
    cases = [case for case in FAMILIES[name].cases() if case.value != "200" and solved(*case[:3])]
    assert cases
    for case in cases:
        profile, exact = solved(*case[:3])
        assert excess(profile, exact) <= 1.0, case[:3]
        assert exact.missed.max(initial=0.0) <= MET, case[:3]
        if name != "robots":  # whose warnings read meshes
            assert profile.health.error_bound == max(profile.health.body_error_bounds)
        assert profile.proof.bounds.max() <= ROUNDING
        assert_maps_are_those_of_the_proof(profile)


@pytest.mark.slow
def test_the_impact_of_500_links_is_proven():
    """The struck point stops, and the impulse is the change of the whole chain's momentum.

    Only the proof: Pinocchio's memory grows with the cube of the number of joints.
    """
    robot = chain(np.full(500, 1.0), np.full(500, 0.2))
    rest, velocity, q = (
        np.zeros(robot.model.nv),
        np.array([1.0, 0.5, -2.0]),
        configuration(robot, bent(robot, 0.05)),
    )
    block, before = (
        contact_constraint(robot, Contact(frame="link499", offset=(0.1, 0.0, 0.2)), Z),
        Motion(velocity, np.zeros(3), rest),
    )
    plane = plane_of(Scene(robot="chain"))
    system = System(robot, "free", plane, rest > 0.0, rest, rest, before)
    proof = Proof(Posed(system, q, (block,)), RowSpace.every(3))
    rotation = proof.read(lambda impact: impact.state.rotation[0].astype(float))
    omega, v = proof.jumps[:, :3, 3], proof.jumps[:, 3:, 3]
    centres = (rotation @ (v + np.cross(omega, robot.coms))[..., None])[..., 0]
    struck = rotation[block.body] @ (v[block.body] + np.cross(omega[block.body], block.point))
    assert proof.bounds.max() <= ROUNDING
    np.testing.assert_allclose(struck, -velocity, atol=1e-12)
    np.testing.assert_allclose(robot.masses @ centres, proof.impulse[:, 3], atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize(
    "case",
    [("mass ratio", "struck heavy, rooted light", "1e+10"), ("links", "struck at the end", "200")],
)
def test_the_error_of_double_precision_is_the_true_one(case):
    """Reported error of the solution in double precision; and that of a solution with a known
    error.
    """
    profile, exact = solved(*case)
    assert excess(profile, exact) <= 1.0
    true = body_errors(profile.landing, exact, profile.double_jumps[..., 3])[profile.moved]
    assert 1e-10 < profile.health.double_error == pytest.approx(true.max(), rel=1e-6)
    for share in (1e-3, 1e-9):
        off = profile.proof.jumps[..., 3] * (1.0 + share)
        assert double_error(profile.landing, profile.proof, off) == pytest.approx(share, rel=1e-6)


@given(
    st.floats(1e-3, 1e3),
    st.floats(1e-3, 1e3),
    st.floats(-1e3, 1e3).filter(lambda d: abs(d) > 1e-3),
    st.floats(0.0, 1.0),
)
def test_a_body_has_the_doubles_nearest_to_its_closed_form(mass, inertia, d, e):
    """Struck without friction at a distance d from its centre: Δω = −(1 + e) v m d / (I + m d²), Δv
    = (1 + e) v I / (I + m d²).
    """
    moments = (
        f'<inertia ixx="{inertia!r}" ixy="0" ixz="0" iyy="{inertia!r}" iyz="0" izz="{inertia!r}"/>'
    )
    robot = robot_from(urdf(link("body", mass=repr(mass), inertia=moments)))
    contact = Contact(frame="body", offset=(d, 0.0, 0.0), directions=("z",), restitution=e)
    profile = shock_profile(Scene(robot="body", contact=(contact,)), robot)
    m, distance, moment = (
        Fraction(robot.bodies[0].mass),
        Fraction(d),
        Fraction(robot.bodies[0].inertia[1, 1]),
    )
    whole = (1 + Fraction(e)) / (moment + m * distance**2)
    assert profile.delta_omega[0].tolist() == [0.0, float(-whole * m * distance), 0.0]
    assert profile.delta_v[0].tolist() == [0.0, 0.0, float(whole * moment)]


# Joints without load


def test_a_body_on_a_floating_joint_feels_nothing():
    """Six free velocities carry no impulse."""
    robot = robot_from(
        urdf(link("base"), link("loose"), joint("six", "base", "loose", "floating", more=""))
    )
    profile = shock_profile(
        Scene(robot="r", contact=Contact(frame="base", offset=(0.1, 0.2, -0.3))), robot
    )
    assert not profile.delta_v[1].any()
    assert not profile.delta_omega[1].any()
    assert profile.delta_v[0].any()


def test_a_foot_that_receives_no_impulse_needs_no_hold():
    """Another leg of a robot on a fixed base stands: the impulse along its rows is zero, beside
    rows that depend on others.
    """
    scene = Scene(robot="quadruped", base="fixed", contact="hind_foot", stance=("front_foot",))
    profile = shock_profile(scene, known_robot("quadruped"))
    assert profile.stance[0].impulse.tolist() == [0.0, 0.0, 0.0]
    assert kinds(profile) == set()


# Many postures


def test_inertia_along_the_tree_keeps_its_armature():
    """It was a view of the cached model, which the next call changes."""
    robot = known_robot("anymal_b")
    with mock.patch("shockpc.method.dynamics.WHOLE_ARRAYS", 0):
        joints = joint_model(robot, Joints(armature={"*": 0.1}))
        geared = dynamics(robot, robot.start[None], joints).inertia
        dynamics(robot, robot.start[None])
    np.testing.assert_array_equal(geared.armature, joints.armature)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("base", "joints"),
    [
        ("free", Joints(model="locked")),
        *itertools.product(("free", "planar", "fixed"), (Joints(), Joints(armature={"*": 0.05}))),
    ],
)
@pytest.mark.parametrize(
    ("name", "feet"),
    [
        ("anymal_b", FEET[:1]),
        ("anymal_b", FEET),
        ("talos", ("left_sole_link",)),
        ("solo12", ("FL_FOOT",)),
    ],
)
def test_ordinary_robots_have_no_warning_of_arithmetic(name, feet, base, joints):
    scene = Scene(
        robot=name, contact=tuple(Contact(frame=foot) for foot in feet), joints=joints, base=base
    )
    profile = shock_profile(scene, known_robot(name))
    assert kinds(profile) == set()
    assert profile.health.data_sensitivity < 1e-11
    assert assert_maps_are_those_of_the_proof(profile) < 1e-10


@pytest.mark.parametrize("model", ["free", "geared", "locked"])
@pytest.mark.parametrize(("name", "foot"), [("anymal_b", "LF_FOOT"), ("talos", "left_sole_link")])
def test_many_postures_are_each_posture_alone(name, foot, model):
    robot = known_robot(name)
    joints = {
        "free": Joints(),
        "geared": Joints(armature={"*": 0.05}),
        "locked": Joints(locked=robot.joint_names[::3]),
    }[model]
    landing = resolve(Scene(robot=name, contact=foot, joints=joints), robot)
    Q = np.repeat(landing.q[None], 300, axis=0)
    Q[:, 7:] += np.random.default_rng(0).uniform(-0.3, 0.3, Q[:, 7:].shape)
    whole = shock_maps(landing, Q)
    for k in (0, 255, 256, 299):
        np.testing.assert_allclose(
            whole.maps[k], shock_maps(landing, Q[k : k + 1]).maps[0], rtol=1e-12, atol=1e-13
        )
    assert not whole.prove.any()


# What arithmetic cannot decide


def at_a_hinge(distance, seed):
    """A chain that lands with both links of one hinge, on points that far from it, and on its end."""
    rng = np.random.default_rng(seed)
    robot = chain(np.full(4, 1.0), np.full(4, 0.4))
    a, b = distance * rng.normal(size=(2, 3))
    contacts = (
        Contact(frame="link2", offset=tuple(a.tolist())),
        Contact(frame="link1", offset=(float(b[0]), float(b[1]), 0.4 + float(b[2]))),
        Contact(frame="link3"),
    )
    posture = Posture(
        base_rpy_deg=tuple(rng.uniform(-90, 90, 3).tolist()),
        joints={name: float(rng.uniform(-1, 1)) for name in robot.joint_names},
    )
    return robot, Scene(robot="chain", base="free", contact=contacts, posture=posture)


@pytest.mark.parametrize("seed", [0, 1, 5])
@pytest.mark.parametrize(
    ("distance", "uncertain"),
    [(0.0, False), (1e-13, True), (1e-12, True), (1e-9, False), (1e-6, False), (1e-3, False)],
)
def test_rows_whose_independence_is_rounding_get_no_verdict(distance, uncertain, seed):
    """Two contacts at one hinge: the same point, points that rounding may take for one, and two
    points.
    """
    robot, scene = at_a_hinge(distance, seed)
    with (
        pytest.raises(SolveError, match=r'no verdict: .* contact "link2", contact "link1"')
        if uncertain
        else nullcontext()
    ):
        assert shock_profile(scene, robot).health.error_bound <= ROUNDING


def test_a_body_that_stays_at_rest_has_no_large_bound():
    """Its motion is zero, which cannot be told from one that is smaller than every enclosure."""
    profile = shock_profile(
        Scene(robot="ur5", contact=(Contact(frame="tool0"),), strike=Strike(velocity=(0.1, 0, -1)))
    )
    assert not profile.delta_v[1].any()
    assert profile.health.error_bound <= ROUNDING


@pytest.mark.parametrize("bend", [1e-8, 1e-12])
def test_a_singular_posture_gets_no_verdict(bend):
    """A shock above 1e6 is refused, with the joint that has to be bent, and the posture is flagged
    in maps.
    """
    robot, scene = nearly_straight(bend, 0.0)
    with pytest.raises(
        SolveError, match=r'"hind_knee".*almost no motion.*\(0 0 1\).*--set hind_knee='
    ):
        shock_profile(scene, robot)
    bent = replace(scene, posture=replace(scene.posture, joints_deg={"hind_knee": 10.0}))
    assert shock_profile(bent, robot).shock_com.max() < 10.0
    landing = resolve(scene, robot)
    assert shock_maps(landing, np.stack([landing.q, resolve(bent, robot).q])).prove.tolist() == [
        True,
        False,
    ]


BUDGETS = """[[case]]
name = "straight"
robot = "quadruped"
base = "fixed"
posture = {reference = "neutral", joints_deg = {hind_knee = 1e-7}}
[[case.contact]]
frame = "hind_foot"
[[budget]]
case = "*"
at = "torso"
metric = "shock"
max = 1.0
"""


@pytest.mark.parametrize(
    "command",
    [
        "analyze",
        "limits --joint hind_knee --at imu_link --max 0.5",
        "sweep --vary hind_knee=1e-8,1e-7 --out sweep",
        "check",
    ],
)
def test_commands_end_without_a_verdict(command, capfd, tmp_path, monkeypatch):
    """Exit code 3 and the posture, in a gate and in the rows of a sweep too."""
    monkeypatch.chdir(tmp_path)
    Path("budgets.toml").write_text(BUDGETS)
    name, *more = command.split()
    landing = ["quadruped", "--contact", "hind_foot", "--base", "fixed", "--posture", "neutral"]
    landing += [] if name == "sweep" else ["--set", "hind_knee=1e-7"]
    code, out, err = run(capfd, name, *(landing if name != "check" else []), *more)
    assert code == 3
    assert 'no verdict: body "hind_' in out + err
    assert '"hind_knee" at 1e-0' in out + err


def test_a_singular_posture_is_a_warning_where_only_other_strikes_have_no_verdict():
    robot, scene = nearly_straight(1e-9, 10.0, 80.0001)
    assert any(
        warning.kind == "posture" and warning.value > 1e6
        for warning in shock_profile(scene, robot).health.warnings
    )


@pytest.mark.parametrize(("bend", "warned"), [(1e-5, True), (1e-3, True), (0.3, False)])
def test_a_body_that_moves_as_no_robot_moves_is_a_warning(bend, warned):
    robot, scene = nearly_straight(bend, 0.0)
    assert (
        any(
            one.kind == "posture" and one.value > 100.0
            for one in shock_profile(scene, robot).health.warnings
        )
        == warned
    )


def test_a_body_without_inertia_that_turns_as_no_robot_turns_is_refused():
    """The neck of iCub carries a mass at a point: nothing resists rotation about the line to it but
    what rounding leaves.
    """
    with pytest.raises(SolveError, match=r'"neck_2", "head".*"iCub".*no mass'):
        shock_profile(Scene(robot="icub", contact="l_sole"), known_robot("icub"))


def slab(*offsets):
    robot = robot_from(urdf(link("slab", mass="2")))
    return robot, Scene(
        robot="slab", contact=tuple(Contact(frame="slab", offset=offset) for offset in offsets)
    )


def nearly_on_the_centre(beside):
    moments = '<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/>'
    robot = robot_from(
        urdf(
            f'<link name="body"><inertial><origin xyz="0.3 0 0"/><mass '
            f'value="2"/>{moments}</inertial></link>'
        )
    )
    return robot, Scene(
        robot="body", contact=Contact(frame="body", offset=(0.3 + beside, 0.0, -0.1))
    )


def drawn_in(approach):
    """A robot falls at 3 m/s and draws its foot in so fast that the foot approaches the ground at
    `approach`.
    """
    robot = known_robot("anymal_b")
    contact = (Contact(frame="LF_FOOT", directions=("z",)),)

    def falling(rate):
        return Scene(
            robot="anymal_b",
            contact=contact,
            strike=Strike(velocity=(0.0, 0.0, -3.0), joint_velocities={"LF_KFE": rate}),
        )

    one, two = (
        float(shock_profile(falling(rate), robot).contacts[0].approach[2]) for rate in (0.0, 1.0)
    )
    return robot, falling((-approach - one) / (two - one))


def hardly_moving(speed):
    """Two rods, one up and one down: their centre of mass, by whose speed shock is divided, moves
    at `speed`.
    """
    robot = chain(np.full(2, 1.0), np.full(2, 0.4))
    posture = Posture(base_rpy_deg=(10.0, 20.0, 30.0), joints={"joint1": 0.8})

    def moving(velocity):
        strike = Strike(velocity=tuple(velocity), joint_velocities={"joint1": -2.0})
        return Scene(robot="chain", contact="link0", strike=strike, v_in="com", posture=posture)

    profile = shock_profile(moving((0.0, 0.0, -9.0)), robot)
    found = profile.proof.read(
        lambda impact: impact.velocities_before((0, 1), impact.points((0, 1), robot.coms)).astype(
            float
        )[0, 0]
    )
    x, y, z = found.mean(axis=0)
    return robot, moving((-x, -y, -9.0 - z - speed))


@pytest.mark.parametrize(
    ("case", "small", "large", "words"),
    [
        (lambda d: slab((0.3, 0.1, -0.1), (0.3 + d, 0.1 + d, -0.1)), 3e-9, 1e-3, ('body "slab"',)),
        (nearly_on_the_centre, 3e-9, 1e-3, ("radius of percussion", 'body "body"')),
        (drawn_in, 1e-8, 1e-1, ("result of body",)),
        (hardly_moving, 1e-8, 1.0, ("speed that shock is relative to",)),
    ],
    ids=[
        "contacts close together",
        "strike near the centre of mass",
        "slow approach",
        "slow centre of mass",
    ],
)
def test_results_that_hang_on_the_last_digits_of_the_data_are_reported(case, small, large, words):
    """A small difference of large data: the numbers are those of the file, proven, and a warning
    names what they depend on.
    """
    robot, scene = case(small)
    profile = shock_profile(scene, robot)
    assert profile.health.error_bound <= ROUNDING
    told = [warning for warning in profile.health.warnings if warning.kind == "data"]
    assert any(all(word in str(warning) for word in words) for warning in told)
    assert all(warning.value > 1e-9 for warning in told)
    assert kinds(shock_profile(*reversed(case(large)))) == set()


def test_the_sensitivity_is_what_a_change_of_the_data_does():
    """A change of one datum in its last digit moves no body by much more than reported."""
    robot, scene = slab((0.3, 0.1, -0.1), (0.3 + 1e-7, 0.1 + 1e-7, -0.1))
    profile = shock_profile(scene, robot)
    second = replace(
        scene.contact[1], offset=(float(np.nextafter(0.3 + 1e-7, 1.0)), 0.1 + 1e-7, -0.1)
    )
    moved = shock_profile(replace(scene, contact=(scene.contact[0], second)), robot)
    exact = maximal_jumps(profile.landing, profile.row_space.rows)
    change = body_errors(profile.landing, exact, moved.proof.jumps[..., 3]).max()
    assert 1e-11 < change <= 10.0 * profile.health.data_sensitivity


@pytest.mark.parametrize("yaw", [0.0, 20.0, 33.3, 47.0])
def test_a_foot_at_the_centre_of_percussion_needs_no_friction(yaw):
    """Its impulse is zero, which arithmetic only narrows down: there is none, and no friction."""
    moments = '<inertia ixx="0.75" ixy="0" ixz="0" iyy="0.75" iyz="0" izz="0.75"/>'
    body = (
        f'<link name="rod"><inertial><origin xyz="0.5 0 0"/><mass '
        f'value="3"/>{moments}</inertial></link>'
    )
    robot = robot_from(urdf(body))
    contact = Contact(frame="rod", offset=(1.0, 0.0, 0.0), directions=("z",))
    posture = Posture(base_rpy_deg=(0.0, 0.0, yaw))
    foot = shock_profile(
        Scene(robot="r", contact=(contact,), stance=("rod",), posture=posture), robot
    ).stance[0]
    assert (foot.impulse.tolist(), foot.friction_needed) == ([0.0, 0.0, 0.0], None)


def test_a_number_that_no_precision_encloses_gets_no_verdict():
    """The reading of a quantity of the proof, too, refuses what stays wide at the highest
    precision.
    """
    profile = shock_profile(Scene(robot="anymal_b", contact="LF_FOOT"), known_robot("anymal_b"))

    def wide(impact):
        return to_double(impact.exact(np.ones(1)) + arb(0, 1), 1.0)

    with pytest.raises(SolveError, match='8192 bits do not give a number of robot "anymal"'):
        profile.proof.read(wide)


@pytest.mark.parametrize("joints", ["free", "locked"])
@pytest.mark.parametrize("name", ["anymal_b", "cassie", "iris", "quadruped", "talos"])
def test_no_impulse_is_above_the_bound_that_excludes_a_warning(name, joints):
    """With loops, soles and arms; and what a floating robot's contact stops is at most its mass."""
    robot = known_robot(name)
    (*_, frame) = each_foot(robot) or robot.frames
    contact = Contact(frame=frame, restitution=0.4)
    scene = Scene(
        robot=name,
        contact=contact,
        strike=Strike(strike_angle_deg=30.0),
        joints=Joints(model=joints),
    )
    profile = shock_profile(scene, robot)
    largest = [*profile.value("joint_impulse", "joint"), *impulse_sizes(profile)]
    assert max(largest) <= impulse_bound(profile) * (1.0 + 1e-12)
    assert profile.landing.floating
    assert np.nanmax(profile.value("effective_mass", "contact")) <= robot.mass * (1.0 + 1e-12)


def test_a_large_effective_mass_is_warned_of_where_the_inertia_is_indefinite():
    """A rotor of more inertia than the link that carries it; the impulses are small, because the
    contact hardly moves along its normal.
    """

    def moments(value):
        return f'<inertia ixx="{value}" iyy="{value}" izz="{value}" ixy="0" ixz="0" iyz="0"/>'

    base = link("base", "1", moments(0.02))
    arm = link("arm", "0.1", moments(0.0001))
    robot = robot_from(urdf(base, arm, joint("hinge", "base", "arm", "continuous", more="")))
    rotor = Rotor(inertia=0.11901, gear_ratio=1.0, gear="planetary")
    scene = Scene(
        robot="r",
        contact=Contact(frame="base", offset=(0.3, 0.0, 0.0), directions=("z",)),
        joints=Joints(rotor={"hinge": rotor}),
        strike=Strike(velocity=(1.0, 0.0, -0.001)),
    )
    with pytest.warns(ShockWarning, match='effective mass of contact "base" 1.09e\\+04 kg is'):
        profile = shock_profile(scene, robot)
    assert profile.landing.floating
