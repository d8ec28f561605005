"""Derivatives of the shock: against differences in ball arithmetic, against other postures, and laws that they obey."""

import csv
import dataclasses
import json
import math

import numpy as np
import pinocchio as pin
import pytest
from commands import good, run
from flint import arb, ctx
from random_landings import random_landing
from robot_texts import floating, mjcf
from test_closures import CASES
from trees import known_robot, robot_from

from shockpc.errors import StudyError
from shockpc.exact.balls import balls
from shockpc.exact.derivative import displaced
from shockpc.exact.kinematics import data_of
from shockpc.exact.solution import BallImpact
from shockpc.landing import contact_velocity
from shockpc.model.contact import Contact
from shockpc.model.joint_model import Joints
from shockpc.model.posture import Posture
from shockpc.model.regressor import INERTIA_ENTRIES
from shockpc.profile import impact_jumps, shock_profile
from shockpc.scene import Point, Scene, Strike
from shockpc.studies.sensitivity import sensitivity

H = 2.0**-100


def hyq(**changes):
    return Scene(**{"robot": "hyq", "contact": (Contact(frame="lf_foot"),)} | changes)


LANDINGS = {
    "hyq": (hyq(strike=Strike(strike_angle_deg=30.0)), "hyq", "trunk_imu"),
    "geared": (hyq(joints=Joints(armature={"*": 0.02}, locked=("lh_*",)), base="planar"), "hyq", "trunk_imu"),
    "redundant": (
        Scene(robot="solo12", contact=tuple(Contact(frame=foot, kind="flat") for foot in ("FL_FOOT", "HR_FOOT"))),
        "solo12",
        "FL_UPPER_LEG",
    ),
    "stance": (hyq(stance=("rh_foot",), contact=(Contact(frame="lf_foot", restitution=0.5),)), "hyq", "trunk_imu"),
}


def landing(name):
    scene, robot, frame = LANDINGS[name]
    return sensitivity(scene, Point(frame=frame, offset=(0.1, -0.05, 0.02)), known_robot(robot))


def loop(name, frame):
    scene, robot = CASES[name]()
    return sensitivity(scene, Point(frame=frame), robot)


def random(number):
    """A random landing, at a point of the first body that moves."""
    robot, scene = random_landing(number)
    profile = shock_profile(scene, robot)
    body = robot.bodies[int(np.flatnonzero(profile.moved)[0])].name
    return sensitivity(scene, Point(frame=body, offset=(0.1, 0.2, 0.3)), robot)


CASES_OF_INERTIA = {
    **{name: lambda name=name: landing(name) for name in LANDINGS},
    "five-bar": lambda: loop("five-bar", "imu_link"),
    "followers": lambda: loop("followers", "c"),
    **{f"random {number}": lambda number=number: random(number) for number in (40, 41, 42, 43, 44, 45)},
}


def in_balls(found, impact):
    """Shock, CoPc and RoPc in ball arithmetic."""
    profile = found.profile
    frame = profile.robot.frame(found.point.partition(":")[0])
    offset = np.array([float(x) for x in found.point.partition(":")[2].split(",")]) if ":" in found.point else np.zeros(3)
    r = balls(frame.offset + frame.rotation @ offset)
    jump, v_in = impact.own_jumps[0, 0, frame.body], impact.v_in[0, 0]
    omega, v = jump[:3], jump[3:]
    normal = np.sum(impact.state.rotation[0, frame.body] * balls(profile.plane.normal)[:, None], axis=0)
    moved = v + np.cross(omega, r)
    turn = np.sum(normal * omega)
    return np.array([np.sum(moved * moved).sqrt() / v_in, *(np.cross(normal, v) / turn), v_in / abs(turn)])


def altered(data, effect, robot, t):
    """The numbers of a robot with one of them changed by t."""
    body = next(i for i, one in enumerate(robot.bodies) if one.name == effect.name)
    rotation = robot.bodies[body].rotation
    step = arb(t)
    if effect.kind == "com":
        lever = balls(data.lever)
        lever[body] += balls(rotation[:, "xyz".index(effect.axis)]) * step
        return data._replace(lever=lever)
    mass, inertia = balls(data.mass), balls(data.inertia)
    if effect.kind == "mass":
        mass[body] += step
    elif effect.kind == "proportion":
        mass[body] *= 1 + step
        inertia[body] *= 1 + step
    else:
        i, j = ("xyz".index(axis) for axis in effect.axis)
        entry = np.outer(balls(rotation[:, i]), balls(rotation[:, j]))
        inertia[body] += (entry if i == j else entry + entry.T) * step
    return data._replace(mass=mass, inertia=inertia)


@pytest.mark.parametrize("name", CASES_OF_INERTIA)
def test_regressor_against_differences_in_ball_arithmetic(name):
    """Masses, centres of mass, inertias and armature: central differences with a step of 2^-100."""
    found = CASES_OF_INERTIA[name]()
    robot, landing, choice = found.profile.robot, found.profile.landing, found.profile.choice
    data = data_of(robot)
    column = {joint.name: joint.v.start for joint in robot.single_joints}
    off = []
    size = {
        "mass": np.median(data.mass),
        "proportion": 1.0,
        "com": 0.1,
        "inertia": np.median(np.trace(data.inertia, axis1=1, axis2=2)),
    }
    size["armature"] = size["inertia"]
    effects = [one for one in found.effects if one.kind in size and not (one.kind == "armature" and one.axis)]
    with ctx.workprec(512):
        for effect in effects[:: max(len(effects) // 40, 1)]:
            ends = []
            for t in (H, -H):
                if effect.kind == "armature":
                    armature = balls(landing.joint_model.armature)
                    armature[column[effect.name]] += arb(t)
                    changed = dataclasses.replace(landing, joint_model=landing.joint_model._replace(armature=armature))
                    impact = BallImpact(changed, choice)
                else:
                    impact = BallImpact(landing, choice, altered(data, effect, robot, t))
                ends.append(in_balls(found, impact))
            exact = np.array([float(x) for x in (ends[0] - ends[1]) / (2.0 * H)])
            computed = np.array([effect.shock, *effect.copc, effect.ropc])
            known = ~np.isnan(computed)
            off.append((np.abs(computed - exact)[known] * size[effect.kind], np.abs(exact)[known] * size[effect.kind]))
    wrong, scale = (np.max([pair[k] for pair in off], axis=0) for k in (0, 1))
    # The jumps are exact; the regressor is of double precision: 1e-14 on a robot, less where masses span decades.
    assert np.all(wrong <= 1e-9 * scale + 1e-300)


def by_posture(found, column, h):
    """Shock at the point in a posture beside the scene's, in double precision."""
    landing = found.profile.landing
    robot = landing.robot
    step = np.zeros(robot.model.nv)
    step[column] = h
    for mimic in robot.mimics:
        step[robot.joint(mimic.joint).v] = sum(by * step[robot.joint(name).v] for name, by in mimic.leaders.items())
    q = pin.integrate(robot.model, landing.q, step)
    equation, _, jumps = impact_jumps(landing, landing.at(q).state)
    frame = robot.frame(found.point.partition(":")[0])
    offset = np.array([float(x) for x in found.point.partition(":")[2].split(",")])
    r = equation.state.rotation[0, frame.body] @ (frame.offset + frame.rotation @ offset)
    jump = jumps[0, frame.body, :, 3]
    speeds = [contact_velocity(landing, equation.state, block)[0] for block in equation.blocks[: len(landing.contacts)]]
    return np.linalg.norm(jump[3:] + np.cross(jump[:3], r)) / max(np.linalg.norm(speed) for speed in speeds)


@pytest.mark.parametrize("number", [8, 10, 11, 12, 13, 14, 15, 17, 18, 60, 62, 63])
def test_joint_angles_against_other_postures(number):
    """Joints of every kind, followers and joint velocities before the impact: differences of the double-precision method."""
    found = random(number)
    if found.profile.landing.loops:
        assert all(effect.kind != "angle" or effect.reason or np.isfinite(effect.shock) for effect in found.effects)
        return
    robot = found.profile.robot
    followers = {mimic.joint for mimic in robot.mimics}
    columns = [
        v for joint in robot.joints[robot.free_base :] if joint.name not in followers for v in range(joint.v.start, joint.v.stop)
    ]
    angles = [effect.shock for effect in found.effects if effect.kind == "angle"]
    assert len(angles) == len(columns)
    for column, computed in zip(columns, angles, strict=True):
        slopes = [(by_posture(found, column, h) - by_posture(found, column, -h)) / (2.0 * h) for h in (2e-3, 1e-3)]
        # Richardson: what is left is of the fourth order in the step.
        assert computed == pytest.approx((4.0 * slopes[1] - slopes[0]) / 3.0, abs=1e-5 * max(found.shock, np.abs(angles).max()))


@pytest.mark.parametrize(
    ("name", "frame", "joint"), [("five-bar", "imu_link", "front_hip"), ("four-bar", "rod", "a"), ("followers", "c", "j1")]
)
def test_joint_angles_against_other_scenes(name, frame, joint):
    """Loops that are closed again, and joints that follow: analyses of the scene with the joint set beside its value."""
    scene, robot = CASES[name]()
    found = sensitivity(scene, Point(frame=frame), robot)
    effect = next(one for one in found.effects if one.kind == "angle" and one.name == joint)
    h = 1e-4

    def profile(by):
        joints = {joint: math.degrees(effect.value + by)}
        posture = dataclasses.replace(scene.posture, joints={}, joints_deg={**scene.posture.joints_deg, **joints})
        return shock_profile(dataclasses.replace(scene, posture=posture, point=(Point(frame=frame),)), robot)

    after, before = profile(h), profile(-h)
    body = after.bodies.index(found.body)
    shock = [next(point.shock for point in one.points if point.frame == frame) for one in (after, before)]
    assert effect.shock == pytest.approx((shock[0] - shock[1]) / (2.0 * h), rel=1e-6)
    np.testing.assert_allclose(effect.copc, (after.copc[body] - before.copc[body]) / (2.0 * h), rtol=1e-5, atol=1e-6 * found.ropc)
    assert effect.ropc == pytest.approx((after.ropc[body] - before.ropc[body]) / (2.0 * h), rel=1e-5)


def test_joint_that_a_loop_holds():
    """Both hips are set and the other knee has to follow: a knee cannot be turned by itself."""
    found = loop("five-bar", "imu_link")
    held = [effect.name for effect in found.effects if effect.reason]
    assert held == ["front_knee", "rear_knee"]
    assert all(not effect.reason for effect in found.ranked)


def test_lowest_point_moves_as_the_foot_turns():
    """A contact at the lowest point of a spherical foot rolls over it."""
    robot = known_robot("anymal_b")
    scene = Scene(robot="anymal_b", contact=(Contact(frame="LF_FOOT", at="lowest"),))
    found = sensitivity(scene, Point(frame="imu_link"), robot)
    for joint in ("LF_KFE", "LF_HFE"):
        effect = next(one for one in found.effects if one.kind == "angle" and one.name == joint)
        h = 1e-4
        shocks = []
        for by in (h, -h):
            posture = Posture(joints={joint: effect.value + by})
            profile = shock_profile(dataclasses.replace(scene, posture=posture), robot)
            shocks.append(next(point.shock for point in profile.points if point.frame == "imu_link"))
        assert effect.shock == pytest.approx((shocks[0] - shocks[1]) / (2.0 * h), rel=1e-6)


@pytest.mark.parametrize("v_in", ["contact", "com"])
def test_strike_angle_and_masses_when_the_robot_rotates(v_in):
    """The speed that normalises shock changes with the strike, and that of the centre of mass with the masses."""
    robot = known_robot("leg")
    strike = Strike(strike_angle_deg=20.0, angular_velocity=(0.0, 0.8, 0.0))
    scene = Scene(robot="leg", contact=(Contact(frame=robot.links[-1]),), strike=strike, v_in=v_in)
    point = Point(frame=robot.links[0])
    found = sensitivity(scene, point, robot)

    def shock(scene, robot):
        profile = shock_profile(dataclasses.replace(scene, point=(point,)), robot)
        return next(one.shock for one in profile.points if one.frame == point.frame)

    h = 1e-4
    effect = found.effects[-1]
    turned = [
        shock(dataclasses.replace(scene, strike=dataclasses.replace(strike, strike_angle_deg=20.0 + math.degrees(by))), robot)
        for by in (h, -h)
    ]
    assert effect.kind == "strike"
    assert effect.value == pytest.approx(math.radians(20.0))
    assert effect.shock == pytest.approx((turned[0] - turned[1]) / (2.0 * h), rel=1e-6)

    for body in robot.bodies:
        shocks = []
        for by in (1e-5, -1e-5):
            model = robot.model.copy()
            own = model.inertias[body.joint]
            model.inertias[body.joint] = pin.Inertia(own.mass * (1.0 + by), own.lever, own.inertia * (1.0 + by))
            shocks.append(shock(scene, dataclasses.replace(robot, model=model)))
        effect = next(one for one in found.effects if one.kind == "proportion" and one.name == body.name)
        assert effect.shock == pytest.approx((shocks[0] - shocks[1]) / 2e-5, rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("name", LANDINGS)
def test_one_factor_on_all_inertia_changes_nothing(name):
    """Masses, inertias and armatures multiplied by one factor: Δq̇ is the same, so these derivatives add up to zero."""
    found = landing(name)
    parts = [
        np.array([one.shock, *one.copc, one.ropc]) * one.value for one in found.effects if one.kind in ("proportion", "armature")
    ]
    total, size = np.sum(parts, axis=0), np.sum(np.abs(parts), axis=0)
    known = ~np.isnan(total)
    assert np.all(np.abs(total[known]) <= 1e-10 * size[known])


def test_ten_percent_less_mass_in_a_shank():
    """The first order predicts the change, with an error that falls with the square of the change."""
    robot, scene = known_robot("anymal_b"), Scene(robot="anymal_b", contact=(Contact(frame="LF_FOOT"),))
    found = sensitivity(scene, Point(frame="imu_link"), robot)
    effect = next(one for one in found.effects if one.kind == "proportion" and one.name == "LF_SHANK")
    body = next(one for one in robot.bodies if one.name == "LF_SHANK")
    errors = []
    for by in (-0.1, -0.05):
        model = robot.model.copy()
        own = model.inertias[body.joint]
        model.inertias[body.joint] = pin.Inertia(own.mass * (1.0 + by), own.lever, own.inertia * (1.0 + by))
        profile = shock_profile(scene, dataclasses.replace(robot, model=model))
        shock = next(point.shock for point in profile.points if point.frame == "imu_link")
        errors.append(shock - found.shock - effect.shock * by)
        assert abs(errors[-1]) < 0.2 * abs(effect.shock * by)
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)


def test_displacement_of_joints_of_every_kind():
    """To first order a displacement is that of Pinocchio, whatever the joint."""
    joints = '<joint name="s" type="slide" axis="0 0 1"/><joint name="h" axis="1 0 0"/>'
    inertia = '<inertial pos="0 0 -.1" mass="1" diaginertia=".1 .2 .25"/>'
    free = f'<body name="object" pos="1 0 0"><freejoint name="f"/>{inertia}</body>'
    inner = f'<body name="a" pos="0 0 .1">{joints}{inertia}<body name="b"><joint name="ball" type="ball"/>{inertia}</body></body>'
    for robot in (robot_from(mjcf(floating(inner) + free), ".xml"), random_landing(3)[0], random_landing(12)[0]):
        rng = np.random.default_rng(0)
        rates = rng.uniform(-1.0, 1.0, robot.model.nv)
        rates[: 6 * robot.free_base] = 0.0
        q = pin.integrate(robot.model, pin.neutral(robot.model), 2.0 * rates)
        h = 1e-4
        ends = [pin.normalize(robot.model, displaced(robot, q, rates, t).astype(float)) for t in (h, -h)]
        np.testing.assert_allclose(pin.difference(robot.model, ends[1], ends[0]) / (2.0 * h), rates, atol=1e-7)


def test_refusals():
    """A point that no strike moves has no derivative."""
    tip = '<joint name="j" axis="0 1 0"/><inertial pos="0.1 0 0" mass="1" diaginertia=".1 .2 .25"/><site name="tip" pos="0.3 0 0"/>'
    arm = robot_from(mjcf(f'<body name="a">{tip}</body>'), ".xml")
    scene = Scene(robot="m", contact=(Contact(frame="tip", directions=("z",)),))
    with pytest.raises(StudyError, match=r'"a" sees no shock in this landing'):
        sensitivity(scene, Point(frame="a"), arm)


def test_command(capfd, tmp_path):
    """Table, document, spreadsheet and folder agree."""
    words = ("sensitivity", "hyq", "--contact", "lf_foot", "--at", "trunk_imu")
    table = good(capfd, *words, "--rows", 3, "--out", tmp_path)
    assert "mass and inertia   lf_upperleg" in table
    assert "(165 quantities with smaller values not shown; --out writes all)" in table
    found = json.loads(good(capfd, *words, "--format", "json"))
    assert found == json.loads((tmp_path / "sensitivity.json").read_text())
    assert (found["schema"], len(found["effects"])) == ("shockpc.sensitivity/1", 168)
    text = good(capfd, *words, "--format", "csv")
    assert text == (tmp_path / "sensitivity.csv").read_text()
    first = next(csv.DictReader(text.splitlines()))
    one = next(e for e in found["effects"] if e["quantity"] == first["quantity"] and e["of"] == first["of"])
    assert float(first["shock [-]"]) == one["d_shock"] * one["step"]
    assert {file.name for file in tmp_path.iterdir() if file.name[0] != "."} == {
        "sensitivity.json", "sensitivity.csv", "report.md", "sensitivity.svg", "sensitivity.png",
    }  # fmt: skip
    outcome = run(capfd, "sensitivity", "hyq", "--contact", "*_foot", "--at", "trunk_imu")
    assert (outcome.code, outcome.out) == (2, "")
    assert "is given 4 landings" in outcome.err


def test_entries_of_an_inertia():
    """Six different entries, each once."""
    assert len({frozenset(entry) if entry[0] != entry[1] else entry for entry in INERTIA_ENTRIES}) == 6
