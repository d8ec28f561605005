"""Legs on rails and booms: what a fixed base means for the strike, and contacts that are held in
some directions.
"""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from commands import good, run, vector
from robot_texts import joint, link, urdf

from shockpc import Contact, Posture, Scene, SceneError, SolveError, Strike, recorded, shock_profile
from shockpc.landing.resolve import resolve
from shockpc.landing.scenes.scene_file import robot_of
from shockpc.landing.scenes.strike import GRAVITY

K = 1e5
POSTURE = Posture(joints_deg={"hip": 40.0, "knee": -80.0})
FREE = '<limit effort="1" velocity="1" lower="-3" upper="3"/>'


def leg(rail="0 0 1"):
    """A planar leg of two links whose hip slides along a rail."""
    below = '<origin xyz="0 0 -0.2"/>'
    return urdf(
        '<link name="world"/>',
        link("hub", "2"),
        link("thigh", "0.5"),
        link("shank", "0.2"),
        link("foot", "0.1"),
        joint("rail", "world", "hub", "prismatic", rail, FREE + '<origin xyz="0 0 0.5"/>'),
        joint("hip", "hub", "thigh", more=FREE),
        joint("knee", "thigh", "shank", more=FREE + below),
        joint("ankle", "shank", "foot", more=FREE + below),
        name="leg",
    )


@pytest.fixture
def rig(here):
    (here / "leg.urdf").write_text(leg())
    (here / "inclined.urdf").write_text(leg("0.6 0 0.8"))
    return Scene(robot="leg.urdf", contact="foot", posture=POSTURE)


def falling(scene, rate=-1.0, **changes):
    """The scene with the rate of its rail."""
    return shock_profile(
        scene.__class__(
            **vars(scene) | {"strike": Strike(joint_velocities={"rail": rate})} | changes
        )
    )


def test_a_fixed_base_has_no_velocity_of_its_own(rig):
    """The rail's rate is the strike, in a scene and in a table; without one the ground strikes at 1
    m/s, as always.
    """
    expected = falling(rig, -1.4).delta_qd
    np.testing.assert_allclose(expected, 1.4 * shock_profile(rig).delta_qd, rtol=1e-12)
    table = {"before_rail": [-1.4, -2.8], "before_knee": [0.0, 0.0]}
    for strike in (Strike(), Strike(joint_velocities={"rail": -3.0})):
        scene = Scene(**vars(rig) | {"strike": strike})
        found = recorded(table, scene, ["delta_qd@knee"]).table.columns["delta_qd@knee"]
        knee = robot_of(rig).joint("knee").v.start
        np.testing.assert_allclose(found, [expected[knee], 2.0 * expected[knee]], rtol=1e-12)
    with pytest.raises(SceneError.__base__, match="would be added"):
        recorded(table, Scene(**vars(rig) | {"strike": Strike(speed=2.0)}))


@pytest.mark.parametrize("robot", ["leg.urdf", "inclined.urdf"])
def test_a_drop_along_the_rail(rig, robot):
    """All that the rail carries falls by that height: its speed along the rail is √(2 g h),
    whatever the inclination.
    """
    profile = shock_profile(
        Scene(robot=robot, contact="foot", posture=POSTURE, strike=Strike(drop_height=0.2))
    )
    axis = {"leg.urdf": (0.0, 0.0, 1.0), "inclined.urdf": (0.6, 0.0, 0.8)}[robot]
    assert profile.v_in == pytest.approx(math.sqrt(2.0 * GRAVITY * 0.2), rel=1e-12)
    np.testing.assert_allclose(profile.landing.before.velocity, 0.0)
    rate = profile.landing.before.joint_rates[robot_of(rig).joint("rail").v]
    np.testing.assert_allclose(
        rate * np.array(axis), -math.sqrt(2.0 * GRAVITY * 0.2) * np.array(axis), rtol=1e-12
    )


def test_a_drop_and_a_rate_of_the_rail_are_refused(rig):
    for strike in (
        Strike(drop_height=0.2, joint_velocities={"rail": -1.0}),
        Strike(drop_height=0.2, forward_speed=1.0),
    ):
        with pytest.raises(SceneError, match='falls along its rail "rail"'):
            resolve(Scene(**vars(rig) | {"strike": strike}), robot_of(rig))


def test_a_mass_on_a_rail_on_a_stiff_contact(here):
    """Half an oscillation: the peak force is v √(k m) after ¼ of the period, whether the rail moves
    or the ground.
    """
    (here / "mass.urdf").write_text(
        urdf(
            '<link name="world"/>',
            link("mass", "3"),
            joint("rail", "world", "mass", "prismatic", "0 0 1", FREE),
            name="mass",
        )
    )
    for strike in (Strike(joint_velocities={"rail": -2.0}), Strike(speed=2.0)):
        contact = Contact(frame="mass", directions=("z",), restitution=1.0)
        profile = shock_profile(
            Scene(
                robot="mass.urdf",
                contact=contact,
                strike=strike,
                contact_stiffness=K,
                gravity=False,
            )
        )
        assert profile.value("peak_force", "contact")[0] == pytest.approx(
            2.0 * math.sqrt(3.0 * K), rel=1e-9
        )
        assert profile.value("compression", "robot")[0] == pytest.approx(
            math.pi / 2.0 * math.sqrt(3.0 / K), rel=1e-9
        )
        assert profile.stiffness.motion.duration == pytest.approx(
            math.pi * math.sqrt(3.0 / K), rel=1e-9
        )
        heavy, weight = shock_profile(replace(profile.scene, gravity=True)), 3.0 * GRAVITY
        assert heavy.value("peak_force", "contact")[0] == pytest.approx(
            weight + math.hypot(weight, 2.0 * math.sqrt(3.0 * K)), rel=1e-9
        )


@pytest.mark.parametrize(
    "given", [{}, {"directions": ("x", "z")}, {"kind": "flat"}], ids=["point", "boom", "sole"]
)
def test_a_rig_on_stiff_contacts_ends_as_the_impulse_model(rig, given):
    """Rows without restitution end at rest for every stiffness; soles do not tilt, but one that
    turns before has no such motion.
    """
    contact = Contact(frame="foot", **given)
    profile = falling(rig, contact=contact, contact_stiffness=K, gravity=False)
    assert profile.stiffness.motion.separated
    assert profile.stiffness.difference < 1e-9
    if contact.kind == "flat":
        with pytest.raises(SolveError, match="turns before the impact"):
            _ = falling(
                rig,
                contact=contact,
                contact_stiffness=K,
                strike=Strike(joint_velocities={"rail": -1.0, "knee": 0.5}),
            )


def test_a_standing_foot_stays_on_stiff_contacts():
    """As in the impulse model, with which the end agrees; it has a force, and no duration of its
    own.
    """
    scene = Scene(
        robot="quadruped",
        contact="hind_foot",
        stance=("front_foot",),
        contact_stiffness=K,
        gravity=False,
    )
    profile = shock_profile(scene)
    assert profile.stiffness.difference < 1e-9
    assert np.isnan(profile.value("duration", "contact")[1])
    assert (profile.value("peak_force", "contact") > 0.0).all()


@pytest.mark.parametrize("kind", ["point", "flat"])
def test_friction_of_a_rig_obeys_its_laws(rig, kind):
    """A planar leg slides alike whether or not its contact holds across the plane; a sole stops
    turning, and loses that energy.
    """
    both = []
    for directions in (("x", "y", "z"), ("x", "z")):
        contact = Contact(frame="foot", directions=directions, kind=kind)
        changes = {
            "contact": contact,
            "strike": Strike(joint_velocities={"rail": -1.0, "knee": 0.5}),
        }
        mu = 0.5 * falling(rig, **changes).contacts[0].friction_needed
        profile = falling(rig, friction=mu, **changes)
        landing, found = profile.landing, profile.friction
        assert found.state == ("slides",)
        after = landing.before.joint_rates + found.impact.delta_qd[0, :, 3]
        H = landing.state.H[0]
        lost = landing.before.joint_rates @ H @ landing.before.joint_rates - after @ H @ after
        assert found.energy_lost == pytest.approx(0.5 * lost, rel=1e-9)
        impulse = profile.value("impulse_friction", "contact")[0]
        assert abs(impulse[0]) == pytest.approx(mu * impulse[2], rel=1e-9)
        turning = after[
            [robot_of(rig).joint(name).v.start for name in ("hip", "knee", "ankle")]
        ].sum()
        assert (abs(turning) < 1e-12) == (kind == "flat")
        both.append(found.impact.delta_qd[0, :, 3])
    np.testing.assert_allclose(both[0], both[1], atol=1e-12)


def test_a_contact_slides_freely_along_a_boom(capfd, here):
    """A ball: −µ λ along x, nothing along y; --directions says so on the command line."""
    (here / "ball.urdf").write_text(urdf(link("ball", "2"), name="ball"))
    words = (
        "ball.urdf",
        "--contact",
        "ball",
        "--velocity",
        "1,2,-1",
        "--friction",
        "0.3",
        "--directions",
        "xz",
        "--format",
        "json",
    )
    found = json.loads(good(capfd, "analyze", *words))["tables"]
    np.testing.assert_allclose(
        vector(found["contacts"][0], "impulse_friction"), [-0.6, 0.0, 2.0], atol=1e-12
    )
    np.testing.assert_allclose(vector(found["contacts"][0], "slip"), [0.7, 2.0, 0.0], atol=1e-12)
    for typed, text in (("w", "is neither axes"), ("x", "keeps only directions along the ground")):
        assert text in run(capfd, "analyze", *words[:3], "--directions", typed).err
    assert (
        "leave one of them out"
        in run(capfd, "analyze", *words[:3], "--directions", "xz", "--slide").err
    )
