"""Landings on contacts of finite stiffness, from the command line: closed forms, consistency and
refusals.
"""

import gc
import json
import math
import weakref
from dataclasses import replace

import numpy as np
import pytest
from commands import document, good, run, says, vector
from panels import scene as paper_scene
from robot_texts import BOX, COLUMN, body, floating, mjcf
from test_lifetime import STIFF, solved_once

from shockpc import (
    Contact,
    Joints,
    Part,
    Point,
    Rotor,
    Scene,
    SceneError,
    SolveError,
    Strike,
    load_robot,
    resolve,
    shock_profile,
)
from shockpc.landing.scenes.strike import GRAVITY
from shockpc.quantities.selection import quantity
from shockpc.wings.compliant.over_time import compliant_landing
from shockpc.wings.compliant.over_time.compliant_landing import CompliantLanding
from shockpc.wings.compliant.show.figure import draw_time

K = 1e5
FOOT = (Contact(frame="LF_FOOT"),)
SLIDING = (Contact(frame="LF_FOOT", directions=("z",), restitution=1.0),)
ANYMAL = Scene(robot="anymal_b", contact=FOOT, strike=Strike(strike_angle_deg=10.0))
LOCKED = Joints(locked=("*_HFE",), armature={"*_KFE": 0.1})
RATES = Strike(
    strike_angle_deg=10.0, joint_velocities={"LF_HFE": 2.0, "RH_HFE": -1.0, "LF_KFE": 3.0}
)
ROD = """<robot name="rod"><link name="world"/><link name="arm"><inertial><origin xyz="0.5 0 0"/><mass value="1"/>
<inertia ixx="1e-5" iyy="0.08333333333333333" izz="0.08333333333333333" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="pivot" type="continuous"><parent link="world"/><child link="arm"/><axis xyz="0 1 0"/></joint></robot>"""


def loaded(e):
    """ω T of a mass on a spring, T the time of 99 % of its impulse: (1 − cos ωt) of it while
    loaded, then e sin (ωt/e).
    """
    rest = 0.99 * (1.0 + e) - 1.0
    return math.pi / 2.0 + e * math.asin(rest / e) if rest > 0.0 else math.acos(-rest)


def box_on_a_spring(folder, speed, e):
    """Words of a point mass that lands with a speed [m/s] and a restitution; its file is written."""
    (folder / "box.urdf").write_text(BOX)
    landing = ("--contact", "box", "--speed", speed, "--restitution", e)
    return ("box.urdf", *landing, "--contact-stiffness", K, "--at", "box")


@pytest.mark.parametrize("e", [1.0, 0.5, 0.005, 0.0])
def test_a_point_mass_on_a_spring(capfd, here, e):
    """Force v √(k m) after a quarter of a period; unloaded in e quarters of it, and not at all with
    e = 0.
    """
    words = (*box_on_a_spring(here, 3, e), "--no-gravity")
    found = document(capfd, *words)["tables"]
    omega = math.sqrt(K / 2.0)
    assert found["landing"][0]["stiffness_difference"] < 1e-9
    (contact,), (point,) = found["contacts"], found["points"]
    values = [contact[key] for key in ("duration", "peak_force", "peak_force_time")]
    np.testing.assert_allclose(
        values, [loaded(e) / omega, 6.0 * omega, math.pi / 2.0 / omega], rtol=1e-9
    )
    values = [point["peak_acceleration"], point["peak_acceleration_time"]]
    np.testing.assert_allclose(values, [3.0 * omega / GRAVITY, math.pi / 2.0 / omega], rtol=1e-9)
    text = good(capfd, "analyze", *words)
    assert "impulse model: within 0.1 % of the finite-stiffness result" in text
    assert ("by construction" in text) == (e == 0.0)


def test_two_laws_of_restitution_differ_at_every_stiffness(capfd):
    """The difference from the impulse model does not shrink on stiffer contacts, and the line says
    why.
    """
    words = (
        "go2",
        "--contact",
        "FL_foot",
        "--restitution",
        0.5,
        "--no-gravity",
        "--contact-stiffness",
    )
    soft, stiff = (
        document(capfd, *words, k)["tables"]["landing"][0]["stiffness_difference"]
        for k in (1e6, 1e10)
    )
    assert soft == pytest.approx(stiff, rel=1e-3)
    assert stiff > 0.01
    assert "part of the difference is between two laws of restitution" in good(
        capfd, "analyze", *words, 1e8
    )


@pytest.mark.parametrize("speed", [0.3, 0.01])
@pytest.mark.parametrize("e", [1.0, 0.5, 0.0])
def test_a_point_mass_falls_on_a_spring(capfd, here, e, speed):
    """Under gravity: F = √(k m v² + (m g)²) + m g, first at (π − atan(ω v / g)) / ω; it leaves at e
    v, or stands with m g.
    """
    words = box_on_a_spring(here, speed, e)
    found = document(capfd, *words)["tables"]
    omega, weight = math.sqrt(K / 2.0), 2.0 * GRAVITY
    (contact,), (point,) = found["contacts"], found["points"]
    force, when = (
        math.hypot(2.0 * speed * omega, weight) + weight,
        (math.pi - math.atan(omega * speed / GRAVITY)) / omega,
    )
    np.testing.assert_allclose(
        [contact["peak_force"], contact["peak_force_time"]], [force, when], rtol=1e-7
    )
    assert point["peak_acceleration"] == pytest.approx(force / 2.0 / GRAVITY, rel=1e-9)
    scene = Scene(
        robot="box.urdf",
        contact=Contact(frame="box", restitution=e),
        strike=Strike(speed=speed),
        contact_stiffness=K,
    )
    motion = shock_profile(scene).stiffness.motion
    last = motion.at([motion.duration])
    assert last.jump[0, 2] == pytest.approx(speed * (1.0 + e), rel=1e-7)
    assert motion.separated == (e > 0.0)
    # Without restitution it stands from where it is compressed most.
    assert last.force[0, 2] == pytest.approx(0.0 if motion.separated else force, abs=1e-6)
    later = CompliantLanding(shock_profile(scene).landing, 2.0 * motion.duration).motion
    assert e > 0.0 or later.at([later.duration]).force[0, 2] == pytest.approx(weight, rel=1e-9)


def test_motors_that_hold_the_weight_bring_a_robot_to_rest():
    """On four feet without restitution, with standing torques, nothing moves any more, and joint
    rates are the impulse's.

    Without torques the robot collapses, and its feet carry little. A torque that is given goes over
    the standing one.
    """
    feet = tuple(Contact(frame=f"{foot}_foot") for foot in ("FL", "FR", "RL", "RR"))
    scene = Scene(robot="go2", contact=feet, contact_stiffness=K, joints=Joints(motors="standing"))
    profile = shock_profile(scene)
    weight = profile.robot.mass * GRAVITY
    rates = profile.value("delta_qd", "joint")

    def end(profile):
        found = CompliantLanding(profile.landing, until=0.02)
        return found.motion.at([0.02]).force[0][
            found.motion.elements.normal
        ].sum(), found.impact_at(0.02).delta_qd[0, :, 0]

    force, jump = end(profile)
    assert force == pytest.approx(weight, rel=1e-6)
    np.testing.assert_allclose(jump[6:], rates, atol=1e-6)
    force, jump = end(shock_profile(replace(scene, joints=Joints())))
    assert force < 0.5 * weight
    assert np.abs(jump[6:] - rates).max() > 0.1
    given = shock_profile(
        replace(scene, joints=Joints(motors="standing", torque={"FL_calf_joint": 2.0}))
    )
    loads = [one.stiffness.motion.elements.load[12:] for one in (profile, given)]
    assert loads[1][2] == 2.0
    np.testing.assert_array_equal(np.delete(loads[0], 2), np.delete(loads[1], 2))


@pytest.mark.parametrize("kind", ["none", "standing"])
def test_constant_forces_do_not_change_the_impulse(kind):
    """Their share falls with 1/√k, as the duration does."""
    joints, differences = Joints(motors=kind), []
    for k in (1e6, 1e8, 1e10):
        profile = shock_profile(
            Scene(robot="go2", contact="FL_foot", contact_stiffness=k, joints=joints)
        )
        differences.append(profile.stiffness.difference)
    np.testing.assert_allclose(np.array(differences[:2]) / differences[1:], 10.0, rtol=0.05)


def test_a_motor_behind_a_spring_turns_its_joint():
    """Behind a stiff spring as rigidly joined: the same velocities after 10 ms, to the share of a
    vibration of that spring.
    """
    torque = {"*_calf_joint": 5.0, "*_thigh_joint": -1.0}
    rotors, rates = [Rotor(inertia=1e-4, gear_ratio=6.33, stiffness=k) for k in (1e6, None)], []
    for rotor, torques in ((rotors[0], torque), (rotors[1], torque), (rotors[1], {})):
        joints = Joints(rotor={"*": rotor}, torque=torques)
        profile = shock_profile(
            Scene(robot="go2", contact="FL_foot", contact_stiffness=1e4, joints=joints)
        )
        rates.append(profile.stiffness.impact_at(0.01).delta_qd[0, 6:, 0])
    sprung, rigid, without = rates
    assert np.abs(sprung - rigid).max() < 0.03 * np.abs(rigid - without).max()


def test_a_loaded_spring_of_a_file_pushes(here):
    """MJCF springref: a leg of 3 kg on a spring of 4000 N/m, deflected by 1 cm, is pushed with 40 N
    from the start.
    """
    slide = '<joint name="leg" type="slide" axis="0 0 1" stiffness="4000" springref="0.01"/>'
    (here / "hopper.xml").write_text(mjcf(floating(body("b", joints=slide))))
    contact = Contact(frame="base", directions=("z",))
    forces = [
        shock_profile(
            Scene(robot="hopper.xml", contact=contact, contact_stiffness=K, gravity=gravity)
        ).stiffness.motion.at([0.0])
        for gravity in (True, False)
    ]
    np.testing.assert_allclose(
        [one.force[0] for one in forces], [[0.0, 40.0], [0.0, 0.0]], atol=1e-9
    )


def test_a_damper_beside_the_spring(capfd, here):
    """ζ = c / (2 √(k m)): the force k x + c ẋ starts at c v, and turns at ω_d t = 3 acos ζ mod π;
    the mass returns at e v.
    """
    (here / "box.urdf").write_text(BOX)
    words = ("box.urdf", "--contact", "box", "--contact-stiffness", K, "--no-gravity")
    zeta = 300.0 / (2.0 * math.sqrt(K * 2.0))
    e = math.exp(-2.0 * zeta * math.acos(zeta) / math.sqrt(1.0 - zeta**2))
    found = document(capfd, *words, "--contact-damping", 300)["tables"]
    (contact,) = found["contacts"]
    assert contact["restitution"] == pytest.approx(e, rel=1e-12)
    omega, angle = math.sqrt(K / 2.0), math.acos(zeta)
    damped = omega * math.sqrt(1.0 - zeta**2)
    turn = (3.0 * angle) % math.pi / damped
    force = (
        2.0
        * omega**2
        / damped
        * math.exp(-zeta * omega * turn)
        * abs(math.sin(damped * turn - 2.0 * angle))
    )
    assert contact["peak_force"] == pytest.approx(force, rel=1e-9)
    assert contact["peak_force_time"] == pytest.approx(turn, rel=1e-6)
    (strong,) = document(capfd, *words, "--contact-damping", 3000)["tables"]["contacts"]
    assert (strong["peak_force"], strong["peak_force_time"]) == (
        pytest.approx(3000.0, rel=1e-9),
        0.0,
    )
    text = good(capfd, "analyze", *words, "--contact-damping", 300)
    assert f"the damping causes a restitution of {e:.3g} at box" in text
    assert "contacts of 100000 N/m, 300 N s/m" in text


def test_a_spring_that_is_loaded_at_touchdown(capfd, here):
    """MJCF springref, without gravity: what balances k (springref − q) still does, so the motion is
    that of a relaxed spring.

    A deflection that is rounding of a keyframe is no load.
    """
    slide = '<joint name="leg" type="slide" axis="0 0 1" stiffness="4000" springref="{}"/>'
    motions, loads = [], []
    for x in (0.01, 1e-7):
        (here / "hopper.xml").write_text(mjcf(floating(body("b", joints=slide.format(x)))))
        profile = shock_profile(
            Scene(
                robot="hopper.xml",
                contact=(Contact(frame="base", directions=("z",)),),
                contact_stiffness=K,
                gravity=False,
            )
        )
        motions.append(
            profile.stiffness.motion.at(
                np.linspace(0.0, profile.stiffness.motion.duration, 9)
            ).force
        )
        text = good(capfd, "analyze", "hopper.xml", "--contact", "base", "--slide")
        loads.append(
            [
                note in text
                for note in (
                    "leg is loaded by its spring with 40 N at touchdown",
                    "is loaded by its spring",
                )
            ]
        )
    np.testing.assert_array_equal(*motions)
    assert loads == [[True, True], [False, False]]


@pytest.mark.parametrize(
    ("words", "mass", "share"),
    [
        ((), 0.5, 0.0),
        (("--armature", "slide=1"), 0.5 + 3.0 / 4.0, 3.0 / 4.0),
        (("--joints", "locked"), 3.5, 3.0),
    ],
    ids=["free", "geared", "locked"],
)
def test_a_column_of_two_masses(capfd, here, words, mass, share):
    """With a reflected inertia a between them the foot feels m₁ + a m₂ / (a + m₂); the joint
    carries what moves the upper mass.
    """
    (here / "column.urdf").write_text(COLUMN)
    words = (
        "column.urdf",
        "--contact",
        "foot",
        "--slide",
        "--restitution",
        1,
        "--contact-stiffness",
        K,
        "--no-gravity",
        *words,
    )
    found = document(capfd, *words)["tables"]
    force = math.sqrt(K * mass)
    assert found["contacts"][0]["duration"] == pytest.approx(
        loaded(1.0) * math.sqrt(mass / K), rel=1e-9
    )
    assert found["contacts"][0]["peak_force"] == pytest.approx(force, rel=1e-9)
    (joint,) = found["joints"]
    assert joint["peak_torque"] == pytest.approx(force / mass * share, rel=1e-9)
    assert joint["peak_joint_force"] == pytest.approx(force / mass * share, rel=1e-9)
    assert joint["joint_torque_share"] == pytest.approx(force / mass * share / 50.0, rel=1e-9)


@pytest.mark.parametrize("damping", [1.0, 20.0])
@pytest.mark.parametrize("kind", ["urdf", "xml"])
def test_the_damping_of_joints_is_left_out_with_a_warning(here, damping, kind):
    """The foot stops in a quarter period in which the body moves on: −d Δq is an impulse on both,
    of d v √(m/k) (π/2 − 1).
    """
    foot, upper = (
        f'<inertial pos="0 0 0" mass="{mass}" diaginertia=".1 .1 .1"/>' for mass in (0.5, 3)
    )
    slide = f'<joint name="slide" type="slide" axis="0 0 1" damping="{damping}"/>'
    text = mjcf(f'<body name="foot"><freejoint/>{foot}{body("body", upper, slide, "")}</body>')
    if kind == "urdf":
        text = COLUMN.replace("<limit", f'<dynamics damping="{damping}"/><limit')
    (here / f"column.{kind}").write_text(text)
    profile = shock_profile(
        Scene(robot=f"column.{kind}", contact="foot", contact_stiffness=K, gravity=False)
    )
    impulse = damping * math.sqrt(0.5 / K) * (math.pi / 2.0 - 1.0)
    share = impulse * math.sqrt(1.0 / 0.5 + 1.0 / 3.0) / math.sqrt(0.5)
    warned = [one for one in profile.health.warnings if one.subject == "damping"]
    assert [one.value for one in warned] == (
        [pytest.approx(share, rel=1e-6)] if share > 0.01 else []
    )
    assert all("the damping of slide in the robot's file is left out" in one.text for one in warned)


@pytest.mark.parametrize("kind", ["ball", "planar"])
def test_a_joint_of_several_axes_has_a_peak_force_but_no_torque_along_an_axis(here, kind):
    """It carries what moves the upper mass, (m₂ / (m₁ + m₂)) √(K (m₁ + m₂)); a ball joint has no
    moment.
    """
    foot, upper = (
        '<inertial pos="0 0 {}" mass="{}" diaginertia=".1 .1 .1"/>'.format(*one)
        for one in ((0, 0.5), (0.2, 3))
    )
    carried = body("body", upper, '<joint name="slide" type="ball"/>', 'pos="0 0 .1"')
    ball = f'<body name="foot"><freejoint/>{foot}{carried}</body>'
    text = mjcf(ball) if kind == "ball" else COLUMN.replace("prismatic", "planar")
    (here / "column.xml").write_text(text)
    (here / "column.urdf").write_text(text)
    contact = Contact(frame="foot", directions=("z",), restitution=1.0)
    profile = shock_profile(
        Scene(
            robot=f"column.{'xml' if kind == 'ball' else 'urdf'}",
            contact=(contact,),
            contact_stiffness=K,
            gravity=False,
        )
    )
    for key in ("peak_torque", "joint_torque_share", "along"):
        np.testing.assert_array_equal(profile.value(key, "joint"), [np.nan])
    assert profile.value("peak_joint_force", "joint") == pytest.approx(
        math.sqrt(K * 3.5) * 3.0 / 3.5, rel=1e-9
    )
    assert profile.value("peak_joint_moment", "joint") == pytest.approx(0.0, abs=1e-8)


@pytest.mark.parametrize(
    "changes",
    [
        {"joints": Joints(drives="none")},
        {"joints": Joints(armature={"*": 0.02})},
        {"joints": LOCKED},
        {"joints": LOCKED, "strike": RATES},
        {"joints": Joints(model="locked"), "strike": RATES},
        {"contact": (replace(SLIDING[0], velocity=(0.3, 0.1, -0.7)),)},
    ],
)
def test_one_direction_is_the_impulse_times_a_half_sine(changes):
    """ANYmal B: T = π √(m_eff / k), and π / (2T) of each impulse and jump; whatever the stiffness.

    Also where motors hold the rates of joints, and where the contact has a velocity.
    """
    profile = shock_profile(
        replace(ANYMAL, **{"contact": SLIDING, "contact_stiffness": K, "gravity": False} | changes)
    )
    found, (contact,), (sensor,) = profile.stiffness, profile.contacts, profile.points
    length = math.pi * math.sqrt(contact.effective_mass_frictionless / K)
    assert found.difference < 1e-9
    assert profile.value("duration", "contact")[0] == pytest.approx(
        loaded(1.0) / math.pi * length, rel=1e-9
    )
    half_sine = math.pi / 2.0 / length
    assert profile.value("peak_force", "contact")[0] == pytest.approx(
        half_sine * contact.impulse[2], rel=1e-9
    )
    # Of springs before rotors of unknown inertia no torque is known.
    torque = np.where(
        profile.landing.joint_model.rotor_unknown[6:],
        np.nan,
        half_sine * np.abs(profile.value("along", "joint")),
    )
    np.testing.assert_allclose(profile.value("peak_torque", "joint"), torque, rtol=1e-8, atol=1e-9)
    peak = half_sine * float(np.linalg.norm(sensor.delta_v)) / GRAVITY
    assert profile.value("peak_acceleration", "point")[0] == pytest.approx(peak, rel=1e-8)


@pytest.mark.parametrize("name", ["fig3", "five_bar"])
def test_without_restitution_the_jumps_are_those_of_the_impulse_model(name):
    """For whatever stiffness; loops stay closed, but what their joints carry is not computed."""
    profile = shock_profile(replace(paper_scene(name), contact_stiffness=K, gravity=False))
    assert profile.stiffness.difference < 1e-8


@pytest.mark.parametrize("name", ["fig3", "five_bar"])
def test_torques_in_a_loop(name):
    """A drive carries what accelerates its rotor, and a free joint nothing, which needs the forces
    that close the loop.
    """
    scene = paper_scene(name)
    profile = shock_profile(replace(scene, contact_stiffness=K, gravity=False, joints=Joints()))
    np.testing.assert_array_equal(profile.value("peak_torque", "joint"), 0.0)
    names = [place.name for place in profile.places("joint")]
    profile = shock_profile(
        replace(scene, contact_stiffness=K, gravity=False, joints=Joints(armature={names[0]: 0.01}))
    )
    rate = quantity("joint", "delta_qd").compute
    expected = np.where(
        np.arange(len(names)) == 0,
        0.01 * profile.stiffness.peaks(rate, profile.places("joint"))[0],
        0.0,
    )
    np.testing.assert_allclose(profile.value("peak_torque", "joint"), expected, rtol=1e-8)


def test_peaks_of_every_segment_are_refined():
    """A sample where one segment ends exceeds the samples of the next, but not its maximum: no time
    has more than the peak.
    """
    feet = tuple(
        Contact(frame=frame, restitution=1.0, restitution_along="directions")
        for frame in ("FL_foot", "RR_foot")
    )
    scene = Scene(
        robot="go2",
        contact=feet,
        strike=Strike(strike_angle_deg=20.0),
        contact_stiffness=K,
        gravity=False,
        tangential_stiffness=5e4,
    )
    profile = shock_profile(scene)
    found = profile.stiffness
    force = found.motion.at(np.linspace(0.0, found.motion.duration, 20001)).force
    dense = [np.linalg.norm(force[:, found.number == c], axis=1).max() for c in range(2)]
    assert np.all(profile.value("peak_force", "contact") >= np.array(dense) * (1.0 - 1e-12))


def with_drives(profile, **drives):
    """The landing of a profile with springs and rotors in its joints (nv,)."""
    return CompliantLanding(
        replace(profile.landing, joint_model=profile.landing.joint_model._replace(**drives))
    )


@pytest.mark.parametrize("spring", [1e-2, 1.0, 1e3, 1e6, 1e12])
@pytest.mark.parametrize("rotor", [1e-9, 1e-3, 1e3])
def test_springs_and_rotors_in_the_joints_of_a_robot(spring, rotor):
    """Energy is kept while the contact is loaded, momentum is what the ground gives, and a spring
    gives what moves its rotor.
    """
    lossless = Contact(frame="LF_FOOT", restitution=1.0, restitution_along="directions")
    profile = shock_profile(
        replace(ANYMAL, contact=(lossless,), contact_stiffness=K, gravity=False)
    )
    moving = np.arange(18) >= 6
    stiffness, springs = np.where(moving, 50.0, 0.0), np.where(moving, spring, np.inf)
    found = with_drives(
        profile, stiffness=stiffness, drive_stiffness=springs, rotor=np.where(moving, rotor, 0.0)
    )
    motion, H = found.motion, profile.landing.state.H[0]
    first = min(event.time for event in motion.events)
    t = np.linspace(0.0, 0.999 * first, 50)
    history = motion.at(t)
    before = np.zeros(18)
    before[:3] = profile.landing.state.rotation[0, 0].T @ profile.landing.before.velocity
    start = np.append(before, np.zeros(12))
    M = np.zeros((30, 30))
    M[:18, :18], M[18:, 18:] = H, rotor * np.eye(12)
    rates = start + history.jump
    energy = np.einsum("ti,ij,tj->t", rates, M, rates) / 2.0 + history.force**2 @ (
        0.5 / motion.elements.stiffness
    )
    np.testing.assert_allclose(energy, energy[0], rtol=1e-9)
    np.testing.assert_allclose(
        history.force @ motion.response.T @ M,
        history.force @ motion.elements.rows,
        atol=1e-8 * np.abs(history.force).max(),
    )


def test_a_rotor_behind_a_spring_is_free_or_rigid_at_the_ends():
    """A soft spring gives the peaks of free joints, a stiff one those of the reflected inertia."""
    slides = replace(ANYMAL, contact=SLIDING, contact_stiffness=K, gravity=False)
    free, moving = shock_profile(slides), np.arange(18) >= 6
    geared = shock_profile(replace(slides, joints=Joints(armature={"*": 0.01})))
    rotor = np.where(moving, 0.01, 0.0)
    for spring, same, tolerance in ((1e-9, free, 1e-9), (1e12, geared, 1e-6)):
        found = with_drives(free, drive_stiffness=np.where(moving, spring, np.inf), rotor=rotor)
        force = found.peaks(quantity("contact", "impulse").compute, found.landing.contact_places)[0]
        np.testing.assert_allclose(force, same.value("peak_force", "contact"), rtol=tolerance)
        np.testing.assert_allclose(
            found.duration, same.value("duration", "contact"), rtol=tolerance
        )


def contact_warnings(**changes):
    """Texts about contacts, of Go2 on one foot."""
    profile = shock_profile(
        replace(Scene(robot="go2", contact=(Contact(frame="FL_foot"),)), **changes)
    )
    return [text.text for text in profile.health.warnings if text.kind == "contact"]


@pytest.mark.parametrize(
    ("stiffness", "gravity", "deep"),
    [(1e-12, True, True), (1e2, True, True), (1e4, True, False), (1e6, False, False)],
)
def test_gravity_and_the_compression_are_left_out_with_a_warning(stiffness, gravity, deep):
    warnings = contact_warnings(contact_stiffness=stiffness, gravity=False)
    assert any("gravity is left out" in text for text in warnings) == gravity
    assert any("is compressed by" in text for text in warnings) == deep


@pytest.mark.parametrize(("speed", "share"), [(1.0, 6.0), (3.0, 2.0), (0.1, 58.0)])
def test_the_share_of_gravity(capfd, here, speed, share):
    """The share g T / v of a mass on a spring, whose time T does not depend on the speed."""
    (here / "box.urdf").write_text(BOX)
    k = 2.0 * (loaded(0.0) / (share / 100.0 * speed / GRAVITY)) ** 2
    words = (
        "box.urdf",
        "--contact",
        "box",
        "--speed",
        speed,
        "--contact-stiffness",
        k,
        "--no-gravity",
    )
    text = good(capfd, "analyze", *words)
    assert (f"({share:.2g} %): real peak forces are larger" in text) == (share > 5.0)


def test_a_headline_that_finite_stiffness_contradicts():
    """Rotors behind springs count within the contact; behind a very stiff spring they are rigid,
    not free.
    """
    soft, stiff = (
        Joints(rotor={"*": Rotor(inertia=1.11842e-4, gear_ratio=6.33, stiffness=spring)})
        for spring in (100.0, 1e12)
    )
    warnings = contact_warnings(joints=soft, contact_stiffness=K, gravity=False)
    assert any(says(text, "imu", "0.0425", "100000 N/m", "0.0024") for text in warnings)
    assert any(says(text, "6.6 ms", "20.5 ms") for text in warnings)
    assert contact_warnings(joints=soft) == []
    assert any("acts as rigid" in text for text in contact_warnings(joints=stiff))
    assert not any(
        "shock at" in text for text in contact_warnings(contact_stiffness=1e6, gravity=False)
    )


def test_the_rebound_hardly_depends_on_a_small_restitution():
    """Rotors behind springs press the foot on the ground for 20 ms after its compression; it opens
    between for an instant.
    """
    soft = Joints(rotor={"*": Rotor(inertia=1.11842e-4, gear_ratio=6.33, stiffness=100.0)})
    shocks = []
    for e in (0.0, 1e-3, 0.01, 0.1, 0.2, 0.5):
        profile = shock_profile(
            Scene(
                robot="go2",
                contact=(Contact(frame="FL_foot", restitution=e),),
                joints=soft,
                contact_stiffness=K,
                gravity=False,
            )
        )
        shocks.append(profile.value("shock_com_separated", "body")[0])
        assert 0.019 < profile.value("duration", "contact")[0] < 0.024
    np.testing.assert_allclose(shocks, shocks[0], rtol=0.13)


def test_a_foot_that_stays_on_the_ground_without_force_brings_no_warning(capfd):
    """Of 19.5 ms in which a foot is closed, the last 15.8 ms carry 1 % of the impulse: gravity and
    springs count for less.
    """
    words = (
        "go2",
        "--contact",
        "FL_foot",
        "--contact-stiffness",
        K,
        "--no-gravity",
        "--drives",
        "none",
        "--joint-stiffness",
        "RR_calf_joint=100",
    )
    found = document(capfd, *words)
    assert found["tables"]["contacts"][0]["duration"] == pytest.approx(3.6e-3, rel=1e-3)
    assert found["health"]["warnings"] == []


def test_springs_before_unknown_rotors_are_left_out_with_a_warning(capfd):
    """With a rotor of 0.25 kg m² at the joint, ANYmal's foot stays on the ground nine times as
    long.
    """
    words = (
        "analyze",
        "anymal_b",
        "--contact",
        "LF_FOOT",
        "--contact-stiffness",
        K,
        "--no-gravity",
    )
    left_out = (
        "springs at LF_HAA, LF_HFE and 10 more joints are left out on contacts of finite stiffness"
    )
    assert left_out in (out := good(capfd, *words))
    assert "see the jumps at the end of contact" not in out
    assert left_out not in good(capfd, *words, "--rotor", "*=1e-4:50:180.9")
    assert left_out not in good(capfd, *words, "--drives", "none")


def test_many_changes_of_the_contacts_are_a_warning():
    """Joint springs of 2e9 N m/rad open and close the contact hundreds of times; without them it
    opens once.
    """
    many = contact_warnings(contact_stiffness=K, gravity=False, joints=Joints(stiffness={"*": 2e9}))
    assert any("durations are not reliable" in text for text in many)
    assert not any(
        "durations" in text for text in contact_warnings(contact_stiffness=K, gravity=False)
    )


def test_the_force_over_time_ends_at_zero():
    """A contact without restitution opens at its largest force."""
    profile = shock_profile(
        Scene(robot="go2", contact=(Contact(frame="FL_foot"),), contact_stiffness=K, gravity=False)
    )
    force = draw_time(profile).axes[0].lines[0].get_ydata()
    assert force[-1] == 0.0
    assert force[-2] > 10.0


@pytest.mark.slow
def test_files_over_time(capfd, here):
    """With a contact stiffness a folder has a figure over time; the spectrum of a point below the
    pulse's frequency is 2π f Δv.
    """
    words = (
        "anymal_b",
        "--contact",
        "LF_FOOT",
        "--slide",
        "--restitution",
        1,
        "--contact-stiffness",
        "4e6:1e6",
        "--no-gravity",
    )
    good(capfd, "analyze", *words, "--spectrum", "--out", "out")
    assert {"time.svg", "spectrum.svg"} <= {path.name for path in (here / "out").iterdir()}
    read = json.loads((here / "out/profile.json").read_text())
    spectra, (point,) = read["stiffness"]["spectra"], read["tables"]["points"]
    expected = (
        2.0
        * math.pi
        * spectra["frequencies"][0]
        * max(map(abs, vector(point, "delta_v")))
        / GRAVITY
    )
    assert spectra["points"][0]["response"][0][0] == pytest.approx(expected, rel=1e-3)
    assert document(capfd, *words)["stiffness"]["spectra"] is None
    assert document(capfd, *words, "--spectrum")["stiffness"]["spectra"] == spectra


@pytest.mark.parametrize("stiffness", ["1e-3", "1e-30"])
def test_the_spectrum_of_a_contact_that_lasts_long_is_refused(capfd, here, stiffness):
    """Its samples grow with the duration, 69 s to 2e15 s of contact; the other results do not need
    it.
    """
    words = (
        "anymal_b",
        "--contact",
        "LF_FOOT",
        "--contact-stiffness",
        stiffness,
        "--no-gravity",
        "--format",
        "json",
    )
    assert json.loads(good(capfd, "analyze", *words))["tables"]["contacts"][0]["duration"] > 60.0
    outcome = run(capfd, "analyze", *words, "--spectrum")
    assert (outcome.code, outcome.out) == (3, "")
    assert says(outcome.err, "up to 2 s", "--spectrum")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("changes", "error", "text"),
    [
        ({"friction": -0.1}, SceneError, "friction must be ≥ 0, got -0.1"),
        ({"contact_stiffness": 0.0}, SceneError, "contact_stiffness must be > 0 N/m, got 0"),
        ({"friction": 0.3, "contact_stiffness": K}, SceneError, "leave one of them out"),
        ({"contact_damping": 1.0}, SceneError, "give contact_stiffness too"),
        (
            {"contact_stiffness": K, "contact_damping": 0.0},
            SceneError,
            "contact_damping must be > 0 N s/m, got 0",
        ),
        (
            {"contact_stiffness": K, "contact_damping": 1.0, "contact": SLIDING},
            SceneError,
            "cannot be combined",
        ),
        (
            {"friction": 0.3, "contact": SLIDING},
            SceneError,
            "slides without friction, and a friction is given",
        ),
        (
            {
                "contact_stiffness": K,
                "contact": (Contact(frame="LF_FOOT", directions=((1.0, 0.0, 1.0), "y")),),
            },
            SceneError,
            "have to span the ground's normal",
        ),
        (
            {
                "contact_stiffness": K,
                "contact": (
                    Contact(frame="LF_FOOT", restitution=1e-5, restitution_along="directions"),
                ),
            },
            SolveError,
            "no verdict for contacts",
        ),
    ],
)
def test_refusals(changes, error, text):
    with pytest.raises(error, match=text):
        shock_profile(replace(ANYMAL, **changes))


def test_a_pulse_beside_a_contact_stiffness():
    """The pulse gives the peaks of the impulse model, the stiffness the forces and what parts are
    judged by, each as alone.
    """
    parts = (
        Part(name="imu", at="imu_link", rating="half-sine 1500 g 0.5 ms"),
        Part(name="knee", joint="LF_KFE", momentary_torque=50.0),
    )
    pulse, stiff = {"pulse": "half-sine:5ms"}, {"contact_stiffness": K}
    both, of_pulse, of_stiffness = (
        shock_profile(replace(ANYMAL, part=parts, **given))
        for given in (pulse | stiff, pulse, stiff)
    )
    assert both.value("peak_g", "point").tolist() == of_pulse.value("peak_g", "point").tolist()
    for kind, key in (
        ("contact", "peak_force"),
        ("point", "peak_acceleration"),
        ("part", "peak_g"),
        ("part", "part_margin"),
    ):
        np.testing.assert_array_equal(both.value(key, kind), of_stiffness.value(key, kind))
    assert not np.isclose(
        of_pulse.value("peak_g", "part")[0], of_stiffness.value("peak_g", "part")[0], rtol=0.01
    )


def test_velocities_that_no_motion_has_are_refused():
    """Two points of a foot do not come together at 1 m/s."""
    second = replace(FOOT[0], offset=(0.0, 0.0, 0.01), velocity=(0.0, 0.0, -2.0))
    scene = replace(
        ANYMAL,
        contact=(replace(FOOT[0], velocity=(0.0, 0.0, -1.0)), second),
        contact_stiffness=K,
        gravity=False,
    )
    with pytest.raises(SolveError, match="no motion of the robot has the velocities"):
        CompliantLanding(resolve(scene, load_robot("anymal_b")))


def test_without_them_there_is_no_value():
    profile = shock_profile(ANYMAL)
    assert profile.friction is profile.stiffness is None
    for key, kind in (
        ("shock_friction", "point"),
        ("slip", "contact"),
        ("peak_torque", "joint"),
        ("stiffness_difference", "robot"),
    ):
        assert np.isnan(profile.value(key, kind)).all()


def test_a_landing_on_springs_is_not_kept_in_memory():
    """Its impacts at several times are its own: a sweep of many such landings needs the memory of
    one.
    """
    compliant = CompliantLanding(
        resolve(
            Scene(robot="anymal_b", contact="LF_FOOT", contact_stiffness=1e5, gravity=False),
            load_robot("anymal_b"),
        )
    )
    assert compliant.impact_at(1e-3) is compliant.impact_at(1e-3)
    kept = weakref.ref(compliant)
    del compliant
    gc.collect()
    assert kept() is None


def test_a_column_without_values_says_why(capfd, here):
    """A force needs a stiffness, in a sweep and in a table of recorded landings."""
    (here / "log.csv").write_text("vz\n-1\n-2\n")
    robot = ("go2", "--contact", "FL_foot", "--quantity", "peak_force")
    for words in (
        ("sweep", *robot, "--vary", "strike-angle=0,5", "--out", "swept"),
        ("recorded", "log.csv", *robot),
    ):
        assert says(good(capfd, *words), "peak_force@FL_foot", "contact stiffness")
    assert "has no value" not in good(
        capfd, "recorded", "log.csv", *robot, "--contact-stiffness", 1e5, "--no-gravity"
    )


def test_a_fixed_base_holds_a_robot_against_gravity(here):
    """A level rod that turns about its end and lands on its tip, f = A (1 − cos ωt) + B sin ωt of
    its weight and its speed.

    Held, it falls with 3/2 g x at x, so a sensor near the pivot measures nearly 1 g, and the pivot
    carries a quarter of the weight.
    """
    (here / "rod.urdf").write_text(ROD)
    rod, near = load_robot(here / "rod.urdf"), 0.02
    contact = Contact(frame="arm", offset=(1.0, 0.0, 0.0), kind="point")
    point, strike = (
        Point(frame="arm", offset=(near, 0.0, 0.0)),
        Strike(joint_velocities={"pivot": 0.01}),
    )
    scene = Scene(
        robot="rod",
        contact=(contact,),
        point=(point,),
        strike=strike,
        base="fixed",
        contact_stiffness=K,
        range_g=1.0,
    )
    profile = shock_profile(scene, rod)
    # The equation of the tip's deflection: I = 1/3 kg m², so m_eff = 1/3 kg and half of the weight
    # is on the tip at rest.
    rest, speed = 0.5 * GRAVITY, 0.01 * math.sqrt(K / 3.0)
    force = rest + math.hypot(rest, speed)
    acceleration = GRAVITY - 1.5 * near * GRAVITY + 3.0 * near * force
    assert profile.value("peak_force", "contact")[0] == pytest.approx(force, rel=1e-9)
    assert profile.value("peak_acceleration", "point")[0] == pytest.approx(
        acceleration / GRAVITY, rel=1e-9
    )
    assert profile.value("peak_joint_force", "joint")[0] == pytest.approx(
        GRAVITY / 4.0 + force / 2.0, rel=1e-9
    )
    (warned,) = [warning for warning in profile.health.warnings if warning.kind == "sensor"]
    assert warned.value == pytest.approx(acceleration / GRAVITY, rel=1e-9)
    assert profile.value("range_share", "point")[0] == pytest.approx(
        acceleration / GRAVITY, rel=1e-9
    )


def test_every_landing_is_solved_once(monkeypatch):
    solved_once(STIFF, compliant_landing, "simulate_landing", monkeypatch)
