"""Derivatives of quantities: against proven analyses of landings beside the given one, and laws
that they obey.
"""

import csv
import dataclasses
import json
import math

import numpy as np
import pinocchio as pin
import pytest
from commands import good, run, says
from random_landings import random_landing
from robot_texts import floating, mjcf
from test_closures import CASES
from trees import known_robot, robot_from

from shockpc.evaluation.column import column
from shockpc.evaluation.column_values import columns, proven_columns
from shockpc.evaluation.variations.vary import variation
from shockpc.landing.resolve import resolve
from shockpc.landing.scenes.joint_options import Joints
from shockpc.landing.scenes.scene import Contact, Part, Point, Posture, Scene
from shockpc.landing.scenes.scene_file import robot_of
from shockpc.landing.scenes.strike import Strike
from shockpc.profile import profile_of, shock_profile
from shockpc.robot.changes import Change, changed
from shockpc.studies.improve.study import improve
from shockpc.studies.limits.study import limits
from shockpc.studies.sensitivity.report import sensitivity_report
from shockpc.studies.sensitivity.study import sensitivity
from shockpc.studies.sweep.study import sweep
from shockpc.text.errors import StudyError, UnknownName


def hyq(**changes):
    return Scene(**{"robot": "hyq", "contact": (Contact(frame="lf_foot"),)} | changes), known_robot(
        "hyq"
    )


def solo(**changes):
    feet = tuple(Contact(frame=foot, kind="flat") for foot in ("FL_FOOT", "HR_FOOT"))
    return Scene(robot="solo12", contact=feet, **changes), known_robot("solo12")


def flat_feet():
    feet = tuple(Contact(frame=foot, kind="flat") for foot in ("hind_foot", "front_foot"))
    return Scene(robot="quadruped", contact=feet), known_robot("quadruped")


def leg(v_in):
    robot = known_robot("leg")
    strike = Strike(strike_angle_deg=20.0, angular_velocity=(0.0, 0.8, 0.0))
    return Scene(
        robot="leg", contact=(Contact(frame=robot.links[-1]),), strike=strike, v_in=v_in
    ), robot


def lowest():
    return Scene(robot="anymal_b", contact=(Contact(frame="LF_FOOT", at="lowest"),)), known_robot(
        "anymal_b"
    )


GEARED = Joints(armature={"*": 0.02}, locked=("lh_*",))
PART = (Part(name="IMU", at="trunk_imu:0.1,0,0", rating="half-sine 50 g 11 ms"),)
GEAR = (Part(name="gear", joint="lf_kfe_joint", momentary_torque=40.0, torque_duration=0.01),)
IMU = "shock@trunk_imu:0.1,-0.05,0.02"
LANDINGS = {
    IMU: lambda: hyq(strike=Strike(strike_angle_deg=30.0)),
    "delta_v.x@trunk_imu": lambda: hyq(joints=GEARED, base="planar"),
    "delta_v@trunk_imu": lambda: hyq(strike=Strike(drop_height=0.2, strike_angle_deg=30.0)),
    "shock@trunk_imu": lambda: hyq(strike=Strike(drop_height=0.2, forward_speed=0.7)),
    "shock@torso:0.1,0,0.02": flat_feet,
    "ropc@base_link": lambda: hyq(
        stance=("rh_foot",), contact=(Contact(frame="lf_foot", restitution=0.5),)
    ),
    "shock_com@lf_upperleg": lambda: hyq(joints=GEARED, v_in="com"),
    "delta_qd@lf_kfe_joint": lambda: hyq(joints=GEARED),
    "joint_impulse@lf_kfe_joint": lambda: hyq(joints=GEARED),
    "effective_mass@lf_foot": lambda: hyq(joints=GEARED),
    "mitigation@lf_foot": hyq,
    "energy_lost": lambda: hyq(
        strike=Strike(strike_angle_deg=-20.0, angular_velocity=(0.1, 0.3, 0.2))
    ),
    "energy_share": lambda: hyq(
        joints=GEARED, strike=Strike(joint_velocities={"lf_hfe_joint": 2.0})
    ),
    "friction_needed@lf_foot": lambda: hyq(strike=Strike(strike_angle_deg=10.0)),
    "total_moment": lambda: hyq(joints=GEARED),
    "shock@upper_leg": lambda: leg("contact"),
    "delta_omega@upper_leg": lambda: leg("com"),
    "shock@imu_link": lowest,
    "part_margin@IMU": lambda: hyq(pulse="half-sine:5ms", part=PART),
    "joint_torque_share@lf_kfe_joint": lambda: hyq(joints=GEARED, part=GEAR),
    "copc.x@lf_upperleg": lambda: hyq(strike=Strike(strike_angle_deg=30.0)),
}


def beside(scene, robot, effect, t):
    """The landing with one parameter changed by t: another robot or another scene, as a user would
    give it.
    """
    kind, _, name = effect.parameter.rpartition(":")
    if name == "strike-angle":
        strike = dataclasses.replace(
            scene.strike, strike_angle_deg=effect.value + t, forward_speed=None
        )
        return dataclasses.replace(scene, strike=strike), robot
    if not kind:
        posture = dataclasses.replace(scene.posture, joints_deg={name: effect.value + t})
        return dataclasses.replace(scene, posture=posture), robot
    if kind == "armature":
        names = [joint for joint in robot.joint_names if not joint.startswith("lh_")]
        armature = {joint: 0.02 + t * (joint == name) for joint in names}
        return dataclasses.replace(
            scene, joints=dataclasses.replace(scene.joints, armature=armature)
        ), robot
    model = robot.model.copy()
    frame = model.frames[model.getFrameId(name, pin.FrameType.BODY)]
    mass, lever, inertia = (
        frame.inertia.mass,
        frame.inertia.lever.copy(),
        frame.inertia.inertia.copy(),
    )
    match kind.split("-"):
        case ["point", "mass"]:
            mass += t
        case ["mass"]:
            mass, inertia = mass + t, inertia * (1.0 + t / mass)
        case ["com", axis]:
            lever["xyz".index(axis)] += t
        case ["inertia", axes]:
            i, j = map("xyz".index, axes)
            inertia[[i, j], [j, i]] += t
    # The ten numbers of a body are the sums of those of its links.
    old, new = (
        frame.placement.act(one).toDynamicParameters()
        for one in (frame.inertia, pin.Inertia(mass, lever, inertia))
    )
    body = model.inertias[frame.parentJoint].toDynamicParameters()
    model.inertias[frame.parentJoint] = pin.Inertia.FromDynamicParameters(body + new - old)
    return scene, dataclasses.replace(robot, model=model)


def kind_of(effect):
    """What is changed: a word, "joint" or "strike-angle"."""
    kind, colon, name = effect.parameter.partition(":")
    return (
        kind.partition("-")[0]
        if colon
        else "joint"
        if name
        else kind
        if kind == "strike-angle"
        else "joint"
    )


def slope(function, h):
    """The derivative at zero by central differences of the fourth order."""
    return (8.0 * (function(h) - function(-h)) - function(2.0 * h) + function(-2.0 * h)) / (
        12.0 * h
    )


def target_of(profile, study):
    """The target as proven."""
    (value,) = proven_columns(profile, [study.target]).values()
    return value


@pytest.mark.slow
@pytest.mark.parametrize("target", LANDINGS)
def test_derivatives_against_landings_beside_the_given_one(target):
    """An effect of each kind: differences of analyses of changed robots and scenes."""
    scene, robot = LANDINGS[target]()
    study = sensitivity(scene, target, robot)
    here = target_of(study.profiles[0], study)
    kinds = {kind_of(effect) for effect in study.ranked} - (
        {"armature"} if scene.joints is not GEARED else set()
    )
    for kind in kinds:
        effects = [effect for effect in study.ranked if kind_of(effect) == kind]
        effect = effects[len(effects) // 3]
        h = (
            1e-3
            if effect.unit == "deg"
            else 1e-3 * effect.step
            if kind == "inertia"
            else 1e-5 * max(abs(effect.value), effect.step)
        )
        up, down = (
            target_of(shock_profile(*beside(scene, robot, effect, t)), study) for t in (h, -h)
        )
        # Analyses are proven to 1e-16 of the value, of which the difference is a small part.
        assert effect.derivatives[0] * h == pytest.approx(
            (up - down) / 2.0, rel=1e-8, abs=1e-14 * abs(here)
        )


@pytest.mark.slow
@pytest.mark.parametrize("number", [10, 12, 17, 18, 23, 26, 63])
def test_joint_values_against_other_postures(number):
    """Joints of every kind, followers and joint velocities before the impact, in random landings."""
    robot, scene = random_landing(number)
    body = robot.bodies[int(np.flatnonzero(shock_profile(scene, robot).moved)[0])].name
    study = sensitivity(scene, Point(frame=body, offset=(0.1, 0.2, 0.3)), robot)
    landing = study.profiles[0].landing
    angles = [effect for effect in study.effects if kind_of(effect) in ("joint", "turn", "shift")]
    if landing.loops:
        assert all(effect.reason or np.isfinite(effect.derivatives[0]) for effect in angles)
        return
    followers = {mimic.joint for mimic in robot.mimics}
    joints = [joint for joint in robot.joints[robot.free_base :] if joint.name not in followers]
    columns = [v for joint in joints for v in range(joint.v.start, joint.v.stop)]
    for v, effect in zip(columns, angles, strict=True):
        rates = np.eye(robot.model.nv)[v]
        for mimic in robot.mimics:
            rates[robot.joint(mimic.joint).v] = sum(
                by * rates[robot.joint(name).v] for name, by in mimic.leaders.items()
            )

        def value(t, rates=rates):
            return target_of(
                profile_of(landing.at(pin.integrate(robot.model, landing.q, t * rates))), study
            )

        scale = math.radians(1.0) if effect.unit == "deg" else 1.0
        assert effect.derivatives[0] == pytest.approx(
            scale * slope(value, 1e-3), abs=1e-6 * study.value
        )


@pytest.mark.parametrize(
    ("name", "frame", "joint"),
    [("five-bar", "imu_link", "front_hip"), ("four-bar", "rod", "a"), ("followers", "c", "j1")],
)
def test_joint_values_where_loops_are_closed_again(name, frame, joint):
    """Analyses of the scene with the joint set beside its value."""
    scene, robot = CASES[name]()
    study = sensitivity(scene, Point(frame=frame), robot)
    effect = changes(study)[joint]

    def values(t):
        joints = {**scene.posture.joints_deg, joint: effect.value + t}
        posture = dataclasses.replace(scene.posture, joints={}, joints_deg=joints)
        return target_of(shock_profile(dataclasses.replace(scene, posture=posture), robot), study)

    assert effect.derivatives[0] == pytest.approx(
        slope(values, 0.05), rel=1e-7, abs=1e-8 * study.value
    )


@pytest.mark.slow
def test_a_ball_joint_in_a_loop_is_set_as_a_whole():
    """As `joint_quaternions` sets it: the other joints close the loop, where they move 60 times as
    far.

    If only the angle that turns were held, and the other two closed the loop too, it would be
    −0.0020 per degree.
    """
    robot, name = known_robot("cassie"), "achilles_rod_left"
    scene = Scene(robot="cassie", contact=(Contact(frame="left-foot"),))
    study = sensitivity(scene, "shock_com@cassie-pelvis", robot, vary=[(f"turn-y:{name}", "-5:5")])
    landing, ball = study.profiles[0].landing, robot.joint(name)
    closed = {
        joint.name: joint.coordinates(landing.q)
        for joint in robot.single_joints
        if joint.kind == "ball"
    }
    others = {
        joint.name: math.degrees(joint.value(landing.q)) for joint in robot.independent_joints
    }
    movable = tuple(other for other in robot.joint_names if other != name)

    def value(t):
        turned = pin.integrate(
            robot.model, landing.q, math.radians(t) * np.eye(robot.model.nv)[ball.v.start + 1]
        )
        quaternions = {**closed, name: ball.coordinates(turned)}
        posture = dataclasses.replace(
            scene.posture, joints_deg=others, joint_quaternions=quaternions
        )
        return target_of(
            shock_profile(dataclasses.replace(scene, posture=posture, assemble=movable), robot),
            study,
        )

    assert study.effects[0].derivatives[0] == pytest.approx(slope(value, 1e-3), rel=1e-6)


def test_joint_that_a_loop_holds():
    """Both hips are set and the other knee has to follow: a knee cannot be turned by itself."""
    scene, robot = CASES["five-bar"]()
    study = sensitivity(scene, Point(frame="imu_link"), robot)
    reasons = {effect.parameter: effect.reason for effect in study.effects if effect.reason}
    assert list(reasons) == ["front_knee", "rear_knee"]
    assert all(f'closing the loops moves "{knee}"' in reason for knee, reason in reasons.items())
    assert all(not effect.reason for effect in study.ranked)


@pytest.mark.parametrize(
    ("target", "degree"),
    [
        (IMU, 0),
        ("ropc@trunk", 0),
        ("joint_impulse@lf_kfe_joint", 1),
        ("energy_lost", 1),
        ("effective_mass@lf_foot", 1),
    ],
)
def test_one_factor_on_all_inertia(target, degree):
    """Masses, inertias and armatures times one factor: Δq̇ is the same and impulses have that
    factor (Euler's theorem).
    """
    scene, robot = hyq(joints=GEARED)
    study = sensitivity(scene, target, robot)
    total = sum(
        effect.derivatives[0] * effect.value
        for effect in study.effects
        if kind_of(effect) in ("mass", "armature")
    )
    assert total == pytest.approx(degree * study.value, abs=1e-9 * study.value)


def test_a_one_sided_derivative_is_off_by_no_more_than_its_error():
    """An armature at zero in a landing that rounds much: proven analyses with small armatures
    (Richardson).
    """
    robot, scene = random_landing(24)
    target = Point(frame="body0", offset=(0.1, 0.2, 0.3))
    study = sensitivity(
        scene, target, robot, vary=[("armature:joint13", "0:1"), ("com-x:body0", "-0.1:0.1")]
    )
    v = robot.joint("joint13").v.start
    steps = 2.0 ** -np.arange(7, 13) / np.linalg.inv(study.profiles[0].landing.state.H[0])[v, v]

    def value(armature):
        joints = dataclasses.replace(
            scene.joints, armature={**scene.joints.armature, "joint13": armature}
        )
        return target_of(shock_profile(dataclasses.replace(scene, joints=joints), robot), study)

    slopes = (np.array(list(map(value, steps))) - study.value) / steps
    for k in range(1, 6):
        slopes = (2.0**k * slopes[1:] - slopes[:-1]) / (2.0**k - 1.0)
    effect = study.effects[0]
    assert effect.derivatives[0] == pytest.approx(slopes[0], rel=1e-12, abs=effect.error)
    assert effect.error < 1e-5 * abs(effect.derivatives[0])


@pytest.mark.slow
@pytest.mark.parametrize("omega", [None, (0.3, 0.5, 0.2)])
def test_contacts_that_depend_on_one_another_in_one_posture_alone(omega):
    """Two flat feet have one more independent row beside this posture: where the robot turns the
    result jumps, else it does not.
    """
    scene, robot = solo(strike=Strike(angular_velocity=omega))
    mass, legs = (
        variation(robot, "mass:*_LOWER_LEG", "0.9x:1.1x"),
        [name for name in robot.joint_names if name[:2] in ("FL", "HR")],
    )
    vary = [(name, "-90:90") for name in legs] + [("mass:*_LOWER_LEG", "0.9x:1.1x")]
    study = sensitivity(scene, "shock@FL_UPPER_LEG:0.1,0,0.02", robot, vary=vary)
    *angles, masses = study.effects
    assert {effect.parameter for effect in angles if effect.reason} == (
        {"FL_HAA", "FL_HFE", "HR_HAA", "HR_HFE"} if omega else set()
    )
    less, more = (
        target_of(shock_profile(*mass.applied(scene, robot, value)), study)
        for value in (0.999, 1.001)
    )
    assert masses.derivatives[0] == pytest.approx((more - less) / 2e-3, rel=1e-4)

    def profile(joint, value):
        posture = dataclasses.replace(scene.posture, joints_deg={joint: value})
        return shock_profile(dataclasses.replace(scene, posture=posture), robot)

    for effect in angles:
        rank = profile(effect.parameter, effect.value + 0.05).health.rank
        if omega:
            assert bool(effect.reason) == (rank > study.profiles[0].health.rank)
        elif rank > study.profiles[0].health.rank:
            beside = [
                target_of(profile(effect.parameter, effect.value + t), study) for t in (0.05, -0.05)
            ]
            assert effect.derivatives[0] == pytest.approx(
                (beside[0] - beside[1]) / 0.1, rel=1e-3, abs=1e-10
            )


def test_a_number_that_is_zero():
    """A point that no strike moves has no derivative."""
    tip = (
        '<joint name="j" axis="0 1 0"/><inertial pos="0.1 0 0" mass="1" diaginertia=".1 .2 '
        '.25"/><site name="tip" pos="0.3 0 0"/>'
    )
    arm = robot_from(mjcf(f'<body name="a">{tip}</body>'), ".xml")
    scene = Scene(robot="m", contact=(Contact(frame="tip", directions=("z",)),))
    with pytest.raises(StudyError, match="shock at a is zero in this landing"):
        sensitivity(scene, Point(frame="a"), arm)


@pytest.mark.parametrize(
    ("target", "error", "text"),
    [
        ("shok@trunk_imu", UnknownName, 'no quantity "shok".*nearest: "shock"'),
        ("feasible", StudyError, "it is either 0 or 1"),
        ("rank", StudyError, "cannot be used here: it is computed in one posture at a time"),
        ("delta_qd", StudyError, "delta_qd needs a place; write delta_qd@JOINT"),
        (
            "peak_force@lf_foot",
            StudyError,
            "there is no peak force at lf_foot in this landing: the scene gives no contact "
            "stiffness",
        ),
        ("shock@world", UnknownName, 'no frame "world"'),
        ("peak_g@trunk_imu", StudyError, "peak_g needs the duration of the impact"),
        ("along@lf_kfe", UnknownName, 'no joint "lf_kfe".*nearest: "lf_kfe_joint"'),
    ],
)
def test_targets_that_have_no_derivative(target, error, text):
    scene, robot = hyq()
    with pytest.raises(error, match=text):
        sensitivity(scene, target, robot)


def test_peak_force_of_a_mass_on_a_spring():
    """With v sqrt(k m) the derivative by the mass is v sqrt(k / m) / 2; a contact above which the
    mass is turns nothing.
    """
    inertia = (
        '<inertial pos="0 0 0" mass="2" diaginertia=".1 .2 .25"/><site name="foot" pos="0 0 -0.3"/>'
    )
    robot = robot_from(mjcf(f'<body name="a"><freejoint/>{inertia}</body>'), ".xml")
    contact, strike = Contact(frame="foot", directions=("z",)), Strike(speed=3.0)
    scene = Scene(robot="m", contact=contact, strike=strike, contact_stiffness=5e4, gravity=False)
    study = sensitivity(scene, "peak_force@foot", robot)
    mass = changes(study)["mass:a"]
    assert study.value == pytest.approx(3.0 * math.sqrt(5e4 * 2.0), rel=1e-12)
    assert mass.derivatives[0] == pytest.approx(3.0 * math.sqrt(5e4 / 2.0) / 2.0, rel=1e-8)
    assert (
        abs(mass.derivatives[0] - 3.0 * math.sqrt(5e4 / 2.0) / 2.0)
        <= mass.error
        <= 1e-4 * mass.derivatives[0]
    )


def arm(tip, *links, freejoint=""):
    """A chain of links along x that turn about y, each (mass, centre of mass, inertia about y,
    length), with a site at its tip.
    """
    body = f'<site name="tip" pos="{tip} 0 0"/>'
    for k, (mass, centre, inertia, _) in reversed(list(enumerate(links))):
        joint = freejoint or f'<joint name="j{k}" axis="0 1 0"/>'
        inertial = (
            f'<inertial pos="{centre} 0 0" mass="{mass}" diaginertia="{inertia} {inertia} '
            f'{inertia}"/>'
        )
        body = (
            f'<body name="b{k}" pos="{links[k - 1][3] if k else 0} 0 '
            f'0">{joint}{inertial}{body}</body>'
        )
    return robot_from(mjcf(body), ".xml")


def exact_derivative(function, values, key):
    """The derivative of a closed form by one of its values, to rounding: complex-step
    differentiation (Squire and Trapp 1998).
    """
    return function(**(values | {key: values[key] + 1e-30j})).imag / 1e-30


def compare_with_closed_form(study, function, values, names):
    """The number and its derivatives agree with a closed form.

    Args: names, of the parameters in the closed form.
    """
    assert study.value == pytest.approx(function(**values), rel=1e-12)
    for parameter, key in names.items():
        effect, exact = changes(study)[parameter], exact_derivative(function, values, key)
        exact *= math.radians(1.0) if effect.unit == "deg" else 1.0
        assert effect.derivatives[0] == pytest.approx(exact, rel=1e-8)
        assert abs(effect.derivatives[0] - exact) <= effect.error <= 1e-4 * abs(exact)


def test_centre_of_percussion_of_a_free_rod():
    """Struck at x = a, the point x = b of a free body jumps by (I + m a b) / (I + m a²) of the
    strike.
    """

    def jump(m, moment, c):
        a, b = 0.4 - c, -0.3 - c
        return (moment + m * a * b) / (moment + m * a**2)

    robot, values = (
        arm(0.4, (2.0, 0.05, 0.03, 1.0), freejoint="<freejoint/>"),
        {"m": 2.0, "moment": 0.03, "c": 0.05},
    )
    scene = Scene(
        robot="m", contact=(Contact(frame="tip", directions=("z",)),), strike=Strike(speed=1.0)
    )
    study = sensitivity(scene, "delta_v.z@b0:-0.3,0,0", robot)
    names = {"point-mass:b0": "m", "inertia-yy:b0": "moment", "com-x:b0": "c"}
    compare_with_closed_form(study, jump, values, names)
    assert [
        changes(study)[key].derivatives[0] for key in ("com-y:b0", "inertia-zz:b0", "inertia-xz:b0")
    ] == [0] * 3


def test_effective_mass_of_a_pendulum():
    """(I + m c² + armature) / (l cos θ)² at its tip: a number that is computed with a proof alone."""

    def mass(m, c, moment, armature, theta):
        return (moment + m * c**2 + armature) / (0.5 * np.cos(theta)) ** 2

    values = {"m": 2.0, "c": 0.2, "moment": 0.03, "armature": 0.01, "theta": 0.3}
    scene = Scene(
        robot="m",
        contact=(Contact(frame="tip", directions=("z",)),),
        posture=Posture(joints={"j0": 0.3}),
        joints=Joints(armature={"*": 0.01}),
    )
    study = sensitivity(scene, "effective_mass@tip", arm(0.5, (2.0, 0.2, 0.03, 1.0)))
    names = {
        "point-mass:b0": "m",
        "com-x:b0": "c",
        "inertia-yy:b0": "moment",
        "armature:j0": "armature",
        "j0": "theta",
    }
    compare_with_closed_form(study, mass, values, names)


def rate_of_chain(m0, c0, i0, m1, c1, i1, a0, a1, theta0, theta1, strike):
    """Jump of the second joint of two links, Δq̇ = H⁻¹ Jᵀ v / (J H⁻¹ Jᵀ) (Siciliano et al. 2009,
    Section 7.3.2).
    """
    cross = m1 * 0.4 * c1 * np.cos(theta1)
    about_joint = i1 + m1 * c1**2
    H = np.array(
        [
            [i0 + m0 * c0**2 + about_joint + m1 * 0.4**2 + 2 * cross + a0, about_joint + cross],
            [about_joint + cross, about_joint + a1],
        ]
    )
    J = np.array(
        [0.4 * np.cos(theta0) + 0.35 * np.cos(theta0 + theta1), 0.35 * np.cos(theta0 + theta1)]
    )
    X = np.linalg.solve(H, J)
    return (X / (J @ X))[1] * np.cos(strike)


CHAIN = {
    "m0": 3.0,
    "c0": 0.15,
    "i0": 0.04,
    "m1": 1.0,
    "c1": 0.2,
    "i1": 0.02,
    "a0": 0.01,
    "a1": 0.01,
    "theta0": 0.4,
    "theta1": -1.1,
    "strike": math.radians(20.0),
}
CHAIN_SCENE = Scene(
    robot="m",
    contact=(Contact(frame="tip", directions=("z",)),),
    posture=Posture(joints={"j0": 0.4, "j1": -1.1}),
    strike=Strike(strike_angle_deg=20.0),
)


def test_jump_of_a_chain_of_two_links():
    values, scene, rate = (
        CHAIN,
        dataclasses.replace(CHAIN_SCENE, joints=Joints(armature={"*": 0.01})),
        rate_of_chain,
    )
    study = sensitivity(
        scene, "delta_qd@j1", arm(0.35, (3.0, 0.15, 0.04, 0.4), (1.0, 0.2, 0.02, 1.0))
    )
    kinds = {
        "m": "point-mass:b",
        "c": "com-x:b",
        "i": "inertia-yy:b",
        "a": "armature:j",
        "theta": "j",
    }
    names = {f"{kind}{k}": f"{key}{k}" for key, kind in kinds.items() for k in (0, 1)} | {
        "strike-angle": "strike"
    }
    sign = math.copysign(1.0, study.value)
    compare_with_closed_form(
        study, lambda **x: sign * abs(rate(**values)) / rate(**values) * rate(**x), values, names
    )


@pytest.mark.parametrize("light", [1.0, 1e-4])
@pytest.mark.parametrize("armature", [0.0, 1e-6])
@pytest.mark.parametrize("alone", [False, True])
def test_joints_without_a_rotor_or_with_a_tiny_one(light, armature, alone):
    """Nothing is below no armature, so that differences are one-sided; the error covers them, of a
    light second link too.
    """
    values = CHAIN | {"m1": light, "i1": 0.02 * light, "a0": armature, "a1": armature}
    scene = dataclasses.replace(
        CHAIN_SCENE, joints=Joints(armature={"*": armature} if armature else {})
    )
    only = {"vary": {f"armature:j{k}": "0:0.1" for k in (0, 1)}} if alone else {}
    study = sensitivity(
        scene,
        "delta_qd@j1",
        arm(0.35, (3.0, 0.15, 0.04, 0.4), (light, 0.2, 0.02 * light, 1.0)),
        **only,
    )
    sign = math.copysign(1.0, study.value * rate_of_chain(**values))
    for k in (0, 1):
        effect, exact = (
            changes(study)[f"armature:j{k}"],
            sign * exact_derivative(rate_of_chain, values, f"a{k}"),
        )
        assert abs(effect.derivatives[0] - exact) <= effect.error <= 1e-5 * abs(exact)


def test_a_lowest_point_that_jumps():
    """A box stands on its edges: as it turns one way or the other, another edge strikes."""
    box = '<geom name="foot" type="box" size="0.1 0.05 0.02" pos="0 0 -0.3" mass="0"/>'
    leg = (
        f'<body name="leg"><joint name="j" axis="0 1 0"/><inertial pos="0 0 -.1" mass="1" '
        f'diaginertia=".1 .2 .25"/>{box}</body>'
    )
    robot = robot_from(mjcf(floating(leg)), ".xml")
    study = sensitivity(
        Scene(robot="m", contact=(Contact(frame="leg", at="lowest", kind="point"),)),
        Point(frame="leg"),
        robot,
    )
    assert "lowest point jumps" in changes(study)["j"].reason
    assert not changes(study)["mass:leg"].reason


def test_a_kink_has_no_derivative():
    """A contact that is about to slip sticks on one side and slides on the other, so that both
    slopes have to be the same.
    """
    scene, robot = hyq()
    friction = shock_profile(scene, robot).contacts[0].friction_needed
    for mu, exists in ((0.9 * friction, True), (friction, False)):
        study = sensitivity(
            dataclasses.replace(scene, friction=mu),
            "shock_friction@trunk_imu",
            robot,
            vary=[("lf_kfe_joint", "-70:-60")],
        )
        assert bool(study.ranked) == exists
    assert "does not settle" in study.effects[0].reason
    assert np.isnan(study.effects[0].derivatives).all()


def test_joint_loads_of_redundant_contacts_are_refused():
    scene, robot = solo()
    with pytest.raises(StudyError, match="not determined, because contacts or loops are redundant"):
        sensitivity(scene, f"along@{robot.joint_names[2]}", robot)


def test_a_report_without_any_derivative(capfd, tmp_path):
    """Of the only parameter the number has a kink: the report says so, states no digits, and has no
    figure of effects.
    """
    scene, robot = hyq()
    mu = repr(shock_profile(scene, robot).contacts[0].friction_needed)
    words = ("hyq", "--contact", "lf_foot", "--friction", mu, "--vary", "lf_kfe_joint=-70:-60")
    text = good(
        capfd, "sensitivity", *words, "--quantity", "shock_friction@trunk_imu", "--out", tmp_path
    )
    assert "no derivative, because the difference does not settle" in text
    assert "digit" not in text
    assert not (tmp_path / "sensitivity.svg").exists()
    refused = run(capfd, "sensitivity", *words, "--quantity", "shock_com@trunk")
    assert refused.code == 2
    assert "name a quantity that depends on it, such as shock_friction" in refused.err


def test_command(capfd, tmp_path):
    """Table, document, spreadsheet and folder agree."""
    words = ("sensitivity", "hyq", "--contact", "lf_foot", "--at", "trunk_imu")
    table = good(capfd, *words, "--out", tmp_path)
    assert "lf_kfe_joint" in table
    assert says(table, "(212 parameters", "--out")
    document = json.loads(
        good(capfd, *words[:-2], "--quantity", "shock@trunk_imu", "--format", "json")
    )
    assert document == json.loads((tmp_path / "sensitivity.json").read_text())
    effects = document["tables"]["sensitivity"]
    assert (document["schema"], len(effects)) == ("shockpc.sensitivity/2", 228)
    text = good(capfd, *words, "--format", "csv")
    assert text == (tmp_path / "sensitivity.csv").read_text()
    assert next(csv.DictReader(text.splitlines()))["parameter"] == effects[0]["parameter"]
    derivative = next(
        row
        for row in document["tables"]["derivatives"]
        if row["parameter"] == effects[0]["parameter"]
    )
    assert derivative["derivative"] * effects[0]["step"] == effects[0]["shock"]
    steps = {row["parameter"]: (row["step"], row["unit"], row["change"]) for row in effects}
    assert steps["lf_kfe_joint"] == steps["strike-angle"] == (1.0, "deg", "1 deg")
    assert steps["com-x:trunk"] == (0.001, "m", "1 mm")
    assert steps["mass:trunk"][1:] == ("kg", "1 %")
    assert f"{effects[0]['value']:.4g}" in table
    assert {file.name for file in tmp_path.iterdir() if file.name[0] != "."} == {
        "sensitivity.json",
        "sensitivity.csv",
        "derivatives.csv",
        "drives.csv",
        "report.md",
        "report.html",
        "sensitivity.svg",
        "sensitivity.png",
    }
    assert "give a point with --at, or a quantity with --quantity" in run(capfd, *words[:-2]).err


FEET = {
    foot: dataclasses.replace(hyq()[0], contact=(Contact(frame=foot),))
    for foot in ("lf_foot", "rf_foot")
}


def changes(study):
    """The effects by what is changed."""
    return {effect.parameter: effect for effect in study.effects}


def test_worst_and_mean_of_several_landings():
    """With the values and derivatives of each landing: the change of the largest, and the mean of
    the changes.
    """
    robot = known_robot("hyq")
    single = [sensitivity(scene, IMU, robot) for scene in FEET.values()]
    worst, mean = (sensitivity(FEET, IMU, robot, mean=choice) for choice in (False, True))
    values = np.array([study.value for study in single])
    assert worst.value == values.max()
    assert mean.value == pytest.approx(values.mean(), rel=1e-15)
    assert worst.worst == list(FEET)[values.argmax()]
    for key, effect in changes(worst).items():
        slopes = np.array([changes(study)[key].derivatives[0] for study in single])
        np.testing.assert_array_equal(effect.derivatives, slopes)
        assert np.isnan(effect.down) == (kind_of(effect) == "armature")
        for step, change in (
            (effect.step, effect.up),
            *([] if np.isnan(effect.down) else [(-effect.step, effect.down)]),
        ):
            assert change == pytest.approx((values + step * slopes).max() - values.max(), abs=1e-15)
        assert changes(mean)[key].up == pytest.approx(effect.step * slopes.mean(), abs=1e-15)


def test_nothing_has_less_than_no_reflected_inertia():
    """The opposite of a step from zero has no effect in table, document and spreadsheet, and does
    not rank the parameter.
    """
    study = sensitivity(FEET, IMU, known_robot("hyq"), groups=("lf_*",))
    none = {effect.parameter for effect in study.effects if np.isnan(effect.down)}
    assert (
        none
        == {effect.parameter for effect in study.effects if kind_of(effect) == "armature"}
        > {"armature:lf_*"}
    )
    table, report = study.table.columns, sensitivity_report(study).json()["tables"]["sensitivity"]
    assert {one["parameter"] for one in report if one["opposite_shock"] is None} == none
    sizes = np.fmax(abs(table["shock [-]"]), abs(table["opposite shock [-]"]))
    assert (np.diff(sizes) <= 0.0).all()
    some = sensitivity(FEET, IMU, known_robot("hyq"), vary={"armature:lf_hfe_joint": "0.1:0.2"})
    assert np.isnan(some.effects[0].down)


def test_less_is_worse():
    """Of several radii of percussion the smallest counts, and a change that makes it greater is
    better.
    """
    study = sensitivity(FEET, "ropc@base_link", known_robot("hyq"))
    assert study.value == study.values.min()
    assert study.worse(-1.0)
    assert not study.worse(1.0)


def test_a_group_changes_by_one_factor():
    """The effect of a group is that of all its links and joints multiplied by one factor, as in a
    changed robot.
    """
    scene, robot = hyq(joints=GEARED)
    study = sensitivity(scene, IMU, robot, groups=("*_lowerleg", "*_kfe_joint"), percent=10.0)
    effects = changes(study)
    assert "mass:lf_lowerleg" not in effects
    masses, knees = effects["mass:*_lowerleg"], effects["armature:*_kfe_joint"]
    assert (masses.unit, masses.step, len(masses.parts), len(knees.parts)) == ("-", 0.1, 4, 3)

    def value(t):
        return target_of(
            shock_profile(scene, changed(robot, [Change("mass", "*_lowerleg", 1.0 + t, True)])),
            study,
        )

    assert masses.derivatives[0] == pytest.approx(slope(value, 1e-3), rel=1e-7)
    model = robot.model
    sides = {
        f"com-y:{name}": np.sign(model.frames[model.getFrameId(name)].inertia.lever[1])
        for name in ("lf_lowerleg", "rh_lowerleg")
    }
    assert {name: np.sign(effects["com-y:*_lowerleg"].parts[name]) for name in sides} == sides


RESISTANCES = (
    "effective_mass_sticking",
    "effective_mass_frictionless",
    "effective_mass",
    "mitigation",
    "mitigation_frictionless",
)


@pytest.mark.parametrize(
    ("robot", "contact", "more", "clear"),
    [
        ("anymal_b", Contact(frame="LF_FOOT"), {}, True),
        ("hyq", Contact(frame="lf_foot", directions=("z",)), {"joints": GEARED}, True),
        (
            "hyq",
            Contact(frame="lf_foot", normal=(0.3, 0.0, 1.0)),
            {"joints": Joints(armature={"*": 0.1})},
            True,
        ),
        ("solo", Contact(frame="FL_FOOT"), {}, True),
        ("anymal_b", Contact(frame="LF_FOOT"), {"base": "planar"}, False),
        ("anymal_b", Contact(frame="LF_FOOT"), {"joints": Joints(model="locked")}, False),
    ],
)
def test_resistances_in_double_precision_are_the_proven_ones_or_none(robot, contact, more, clear):
    """A foot that the robot, or its joints, cannot move in every direction is left to the proof."""
    profile = shock_profile(Scene(robot=robot, contact=(contact,), **more))
    wanted = [
        column(profile, f"{name}@{contact.frame}")
        for name in RESISTANCES
        if name.startswith("effective_mass") or "base" not in more
    ]
    known = wanted if clear else [one for one in wanted if one.selection.name == "mitigation"]
    values, _, prove, _ = columns(
        profile.landing, profile.landing.q[None], None, wanted, max_condition=1e10
    )
    for one in known:
        (exact,) = profile.numbers(one.selection, [one.place])
        assert (
            values[one.name][0, 0] == pytest.approx(exact, rel=1e-11)
            if clear
            else np.isnan(values[one.name]).all()
        )
    assert bool(prove[0, 0]) == (not clear)
    plain, _, proven, _ = columns(profile.landing, profile.landing.q[None], None, wanted)
    assert all(np.isnan(x).all() for x in plain.values())
    assert proven.all()


STRUCK = {"joints": GEARED, "strike": Strike(strike_angle_deg=20.0)}
SOFT = {"contact_stiffness": 5e4}


@pytest.mark.parametrize(
    ("subject", "values", "step", "target", "more", "delta"),
    [
        ("mass:l*_lowerleg", "0.8x:1.2x", 0.4, IMU, STRUCK, 1e-3),
        ("mass:lf_upperleg", "2:4", 2.0, IMU, STRUCK, 1e-3),
        ("inertia:*_upperleg", "0.5x:2x", 1.5, IMU, STRUCK, 1e-3),
        ("com-z:trunk", "-0.01:0.03", 0.04, IMU, STRUCK, 1e-3),
        ("inertia-xz:trunk", "-0.2:0.2", 0.4, IMU, STRUCK, 1e-2),
        ("armature:*_kfe_joint", "0.01:0.1", 0.09, IMU, STRUCK, 1e-4),
        ("lf_kfe_joint", "-100:-60", 40.0, IMU, STRUCK, 1e-2),
        ("strike-angle", "0,10,30", 30.0, IMU, STRUCK, 1e-2),
        ("speed", "1:2", 1.0, "delta_v@trunk_imu", {"strike": Strike(speed=1.5)}, 1e-3),
        (
            "base-pitch",
            "-10:10",
            20.0,
            IMU,
            {"posture": Posture(base_rpy_deg=(2.0, 5.0, 0.0))},
            1e-2,
        ),
        ("offset-z", "-0.01:0.01", 0.02, IMU, {}, 1e-5),
        (
            "friction",
            "0.2:0.6",
            0.4,
            "shock_friction@trunk_imu",
            {"friction": 0.3, "strike": Strike(strike_angle_deg=40.0)},
            1e-3,
        ),
        ("contact-stiffness", "1e4:1e5", 9e4, "peak_force@lf_foot", SOFT, 50.0),
        (
            "contact-damping",
            "10:90",
            80.0,
            "peak_force@lf_foot",
            SOFT | {"contact_damping": 40.0},
            0.2,
        ),
        ("place:lf_kfe_joint", "0.9x:1.1x", 0.2, IMU, {}, 1e-4),
        (
            "joint-stiffness:lf_*",
            "0.5x:2x",
            1.5,
            "peak_force@lf_foot",
            SOFT | {"joints": Joints(stiffness={"*": 300.0})},
            1e-3,
        ),
    ],
)
def test_whatever_a_sweep_varies_has_a_derivative(subject, values, step, target, more, delta):
    """It is the difference of two landings that are set as a sweep sets them, and the step is a
    share of the range.
    """
    scene, robot = hyq(**more)
    study = sensitivity(scene, target, robot, vary={subject: values}, percent=50.0)
    (effect,), one = study.effects, variation(robot, subject, values)
    assert (effect.step, effect.reason) == (pytest.approx(0.5 * step), "")
    less, more = (
        target_of(shock_profile(*one.applied(scene, robot, effect.value + t)), study)
        for t in (-delta, delta)
    )
    assert effect.derivatives[0] == pytest.approx((more - less) / (2.0 * delta), rel=1e-4)


@pytest.mark.parametrize(
    ("subject", "values"),
    [
        ("friction", "0.2:0.6"),
        ("contact-stiffness", "1e4:1e5"),
        ("joint-stiffness:lf_hfe_joint", "100:200"),
        ("armature:lh_*", "0.01:0.1"),
    ],
)
def test_what_the_landing_does_not_have_has_no_derivative(subject, values):
    scene, robot = hyq(joints=GEARED)
    (effect,) = sensitivity(scene, IMU, robot, vary={subject: values}).effects
    assert "the landing has no single value of it" in effect.reason


@pytest.mark.parametrize(
    ("subject", "values", "text"),
    [
        ("contact", "lf_foot,rf_foot", "contacts have names and no derivative"),
        ("lf_kfe_joint", "-60", "has no range; give it as lf_kfe_joint=LOW:HIGH"),
    ],
)
def test_subjects_without_a_derivative(subject, values, text):
    scene, robot = hyq(joints=GEARED)
    with pytest.raises(StudyError, match=text):
        sensitivity(scene, IMU, robot, vary=[(subject, values)])


@pytest.mark.parametrize(
    ("subject", "given", "text"),
    [
        (
            "speed",
            {"strike": Strike(velocity=(0.5, 0.0, -1.0))},
            "the velocity is given as a vector or a drop height",
        ),
        (
            "speed",
            {"strike": Strike(drop_height=0.1)},
            "the velocity is given as a vector or a drop height",
        ),
        (
            "base-pitch",
            {"posture": Posture(base_quaternion=(0.6, 0.0, 0.0, 0.8))},
            "the scene gives it as a quaternion",
        ),
    ],
)
def test_what_the_scene_gives_in_another_way_is_not_varied(subject, given, text):
    """By sensitivity, limits, improve and sweep alike."""
    scene, robot = hyq(**given)
    for study in (
        lambda: sensitivity(scene, IMU, robot, vary={subject: "1:2"}),
        lambda: limits(scene, subject, IMU, 0.1, joint_range=(1.0, 2.0), robot=robot),
        lambda: improve(scene, IMU, robot, vary={subject: "1:2"}),
        lambda: sweep(scene, {subject: "1:2:2"}, robot=robot),
    ):
        with pytest.raises(StudyError, match=f"is varied, but {text}"):
            study()


def test_ranges_as_a_mapping():
    """As a sweep takes them: values by subject, or pairs of both."""
    scene, robot = hyq(joints=GEARED)
    vary = {"mass:lf_upperleg": "2:4", "strike-angle": (0, 30)}
    mapped, paired = (
        sensitivity(scene, IMU, robot, vary=given) for given in (vary, list(vary.items()))
    )
    assert [effect.derivatives[0] for effect in mapped.effects] == [
        effect.derivatives[0] for effect in paired.effects
    ]
    assert len(mapped.effects) == 2


@pytest.mark.slow
def test_groups_and_feet_on_the_command_line(capfd, tmp_path):
    """A robot lands on all level feet, on edges and on each foot; the figure has the colours of
    better and worse.
    """
    words = ("sensitivity", "hyq", "--at", "trunk_imu", "--group", "*_lowerleg")
    text = good(capfd, *words, "--out", tmp_path)
    assert "the worst of 9 landings; the worst is" in text
    assert "opposite shock" in text
    document = json.loads((tmp_path / "sensitivity.json").read_text())
    assert [len(document["landings"]), document["over"], document["worse"]] == [
        9,
        "worst",
        "greater",
    ]
    svg = (tmp_path / "sensitivity.svg").read_text()
    assert all(word in svg for word in ("worse", "better", "the opposite change"))
    assert "no link or joint" in run(capfd, *words[:4], "--group", "calf").err


def test_a_point_means_the_shock_with_friction_where_a_scene_has_it():
    """The derivative by the friction of a contact that slides is that of two landings beside it."""
    scene = Scene(robot="go2", contact=(Contact(frame="FL_foot"),), friction=0.15)
    found = sensitivity(scene, Point(frame="imu"), vary={"friction": "0.1:0.2"})
    (effect,) = found.effects
    beside = [
        shock_profile(dataclasses.replace(scene, friction=mu, point=(Point(frame="imu"),))).value(
            "shock_friction", "point"
        )[0]
        for mu in (0.1499, 0.1501)
    ]
    assert found.target.name == "shock_friction@imu"
    with pytest.raises(StudyError, match="depends on it, such as shock_friction"):
        # a quantity means what its name says
        sensitivity(scene, "shock@imu", vary={"friction": "0.1:0.2"})
    assert effect.derivatives[0] == pytest.approx((beside[1] - beside[0]) / 2e-4, rel=1e-4)


def test_a_rotor_that_its_link_carries_has_a_derivative():
    """Go2's drives have gears, which a change of their inertia keeps: the derivative is that of
    landings beside the given one.
    """
    landing, robot = (
        Scene(robot="go2", contact=(Contact(frame="FL_foot"),), point=(Point(frame="imu"),)),
        robot_of(Scene(robot="go2")),
    )
    (effect,) = (
        one
        for one in sensitivity(landing, "shock@imu").effects
        if one.parameter == "armature:FL_calf_joint"
    )
    varied = variation(robot, "armature:FL_calf_joint", "0.9x:1.1x")
    beside = [
        profile_of(resolve(varied.applied(landing, robot, x)[0], robot)).points[0].shock
        for x in (0.999, 1.001)
    ]
    assert effect.derivatives[0] == pytest.approx((beside[1] - beside[0]) / 0.002, rel=1e-4)


def test_effects_are_given_at_both_ends_of_the_drives(capfd):
    """Nobody knows the drives of A1: the ends are free and locked joints, stated apart here."""
    landing, vary = (
        Scene(robot="a1", contact=(Contact(frame="FL_foot"),)),
        {"FL_thigh_joint": (40.0, 50.0), "mass:trunk": (5.0, 6.0)},
    )
    study = sensitivity(landing, "shock@imu_link", vary=vary)
    for end, model in (("smallest", "free"), ("largest", "locked")):
        stated = sensitivity(
            dataclasses.replace(landing, joints=Joints(model=model)), "shock@imu_link", vary=vary
        )
        assert not stated.ends
        assert study.ends[end].value == pytest.approx(stated.value, rel=1e-12)
        for one, other in zip(study.ends[end].effects, stated.effects, strict=True):
            np.testing.assert_allclose(one.derivatives, other.derivatives, rtol=1e-6)
    words = (
        "sensitivity",
        "a1",
        "--contact",
        "FL_foot",
        "--at",
        "imu_link",
        "--vary",
        "FL_thigh_joint=40:50",
    )
    text = good(capfd, *words)
    assert says(text, "as modelled: shock at imu_link 0.0009293")
    assert says(
        text,
        "largest inertias: shock at imu_link 0.712; the largest effect is that of FL_thigh_joint",
    )
    assert says(text, "change of shock", "smallest", "largest")
    assert "drives: " not in good(capfd, *words, "--joints", "free")
