"""Whole profiles: redundant and contradicting contacts, strikes and planes, joint models, and
bodies without inertia.
"""

import math
from dataclasses import replace

import numpy as np
import pytest
from commands import says
from hypothesis import given
from hypothesis import strategies as st
from robot_texts import LIMIT, joint, link, urdf
from trees import known_robot, robot_from

from shockpc import (
    Contact,
    Joints,
    Point,
    Posture,
    Scene,
    SceneError,
    SolveError,
    Strike,
    shock_maps,
    shock_profile,
)
from shockpc.landing.scenes.strike import GRAVITY

pytestmark = pytest.mark.smoke


def box():
    """A body of 2 kg with its origin in the middle and no joints."""
    return robot_from(urdf(link("box", mass="2"), name="box"))


def land(robot, contacts, velocity=(0.0, 0.0, -1.0), **changes):
    return shock_profile(
        Scene(
            robot=robot.label, contact=tuple(contacts), strike=Strike(velocity=velocity), **changes
        ),
        robot,
    )


def test_bodies_that_nothing_moves_are_at_rest():
    """Two feet of a robot on a fixed base: the other legs and the base have jumps of zero."""
    profile = land(
        known_robot("anymal_b"), [Contact(frame="LF_FOOT"), Contact(frame="RH_FOOT")], base="fixed"
    )
    still = [i for i, name in enumerate(profile.bodies) if name[:2] in ("LH", "RF", "ba")]
    assert len(still) == 7
    assert not profile.delta_v[still].any()
    assert not profile.delta_omega[still].any()
    assert not profile.moved[still].any()
    assert profile.translates[still].all()


# Contacts that cannot be met


STRAIGHT = Posture(reference="neutral")


@pytest.mark.parametrize(
    ("feet", "posture", "velocity", "speed", "along"),
    [
        (("hind_foot",), None, (0.0, 0.3, -1.0), "0.3", "(0 1 0)"),
        (("hind_foot",), STRAIGHT, (0.0, 0.0, -1.0), "1", "(0 0 1)"),
        *(
            (
                ("hind_foot", "front_foot"),
                replace(STRAIGHT, joints={"hind_knee": bend}),
                (0.0, 0.0, -1.0),
                "1",
                "(0 0 1)",
            )
            for bend in (1e-4, 1e-7, 1e-9)
        ),
    ],
    ids=[
        "across its plane",
        "straight",
        *(f"beside a leg that is bent by {bend}" for bend in ("1e-4", "1e-7", "1e-9")),
    ],
)
def test_a_contact_that_the_mechanism_cannot_follow_is_refused(
    feet, posture, velocity, speed, along
):
    """Legs that move in x–z on a fixed base; a huge rate in a leg that is nearly straight hides no
    contradiction in another.
    """
    with pytest.raises(SolveError) as refusal:
        land(known_robot("quadruped"), feet, velocity, base="fixed", posture=posture or Posture())
    found = (
        f'no verdict: contact "{feet[-1]}" cannot be stopped in posture '
        f'"{"neutral" if posture else "standing"}": '
    )
    assert str(refusal.value).startswith(f"{found}{speed} m/s are left along {along}, because ")


def test_a_leg_that_is_bent_by_a_millionth_gives_way_at_a_huge_rate():
    """Two segments l, hip rate α and knee rate β about −y: ẋ = l (α + (α+β) cos b) = 0, ż = l (α +
    β) sin b = 1.
    """
    robot, bend = known_robot("quadruped"), 1e-6
    profile = land(
        robot, ["hind_foot"], base="fixed", posture=replace(STRAIGHT, joints={"hind_knee": bend})
    )
    both = 1.0 / (0.4 * math.sin(bend))
    hip, knee = (robot.joint(name).v.start for name in ("hind_hip", "hind_knee"))
    np.testing.assert_allclose(
        profile.delta_qd[[hip, knee]],
        [-both * math.cos(bend), both * (1 + math.cos(bend))],
        rtol=1e-9,
    )


@pytest.mark.parametrize("e", [1e-8, 1e-5, 1.0])
def test_contacts_that_contradict_one_another_are_refused(e):
    """Two points of one body, one to rebound along the line through both and one not: which is met
    would decide the result.
    """
    contacts = [
        Contact(frame="box", offset=(x, 0.0, -0.1), restitution=r, restitution_along="directions")
        for x, r in ((-0.3, 0.0), (0.3, e))
    ]
    with pytest.raises(
        SolveError, match=rf'"box" cannot be stopped.*"neutral".* {0.5 * e:.3g} m/s.*\(1 0 0\)'
    ):
        land(box(), contacts, (0.5, 0.0, -1.0))
    land(box(), contacts)  # straight down nothing contradicts


# A column: pure translation


@pytest.mark.parametrize("base", ["free", "planar"])
def test_a_straight_column_struck_along_its_axis_only_translates(base):
    """No CoPc, infinite RoPc, uniform shock of 1 in every body, and no pitch."""
    profile = land(
        known_robot("leg"),
        [Contact(frame="heel")],
        base=base,
        posture=Posture(reference="straight"),
    )
    assert profile.translates.all()
    assert np.isinf(profile.ropc).all()
    assert np.isnan(profile.copc).all()
    assert np.isnan(profile.copc_world).all()
    np.testing.assert_allclose(profile.shock_com, 1.0, rtol=1e-12)
    np.testing.assert_allclose(profile.shock_min, 1.0, rtol=1e-12)
    np.testing.assert_allclose(profile.shock_max, 1.0, rtol=1e-12)
    np.testing.assert_allclose(profile.out_of_plane_share, 0.0, atol=1e-12)


@pytest.mark.parametrize("knee", [1e-9, 1e-6, 1e-3])
def test_a_bent_column_rotates_however_little_it_is_bent(knee):
    """RoPc is proportional to one over the bend, down to a billionth of a radian."""
    posture = Posture(reference="straight", joints={"knee": knee})
    profile = land(known_robot("leg"), [Contact(frame="heel")], posture=posture)
    assert not profile.translates.any()
    reference = land(
        known_robot("leg"),
        [Contact(frame="heel")],
        posture=Posture(reference="straight", joints={"knee": 1e-4}),
    )
    # the square of the bend
    np.testing.assert_allclose(profile.ropc * knee, reference.ropc * 1e-4, rtol=1e-5)


# NaN where nothing exists, and only there


@given(
    st.sampled_from(["go2", "talos", "quadruped"]),
    st.sampled_from(["free", "planar"]),
    st.floats(-80.0, 80.0),
    st.floats(0.0, 1.0),
    st.sampled_from(["xz", "yz", "xy", (1.0, 1.0, 0.2)]),
)
def test_only_what_does_not_exist_is_nan(name, base, angle, e, plane):
    """Every number of a profile is finite, but centre, radius and pitch of a body that only
    translates or does not turn.
    """
    robot = known_robot(name)
    foot = {"go2": "FL_foot", "talos": "left_sole_link", "quadruped": "hind_foot"}[name]
    x = math.sin(math.radians(angle))
    velocity = (x, 0.0, -math.cos(math.radians(angle)))
    profile = land(robot, [Contact(frame=foot, restitution=e)], velocity, base=base, plane=plane)
    for part in (
        "delta_qd",
        "maps",
        "position",
        "rotation",
        "delta_omega",
        "delta_v",
        "out_of_plane_share",
        "shock_com",
    ):
        assert np.isfinite(getattr(profile, part)).all(), part
    np.testing.assert_array_equal(np.isnan(profile.copc).any(axis=1), profile.translates)
    np.testing.assert_array_equal(np.isnan(profile.copc_world).any(axis=1), profile.translates)
    np.testing.assert_array_equal(np.isinf(profile.ropc), profile.translates)
    assert np.isfinite(profile.screw_pitch[~profile.translates]).all()
    assert np.all((profile.out_of_plane_share >= 0.0) & (profile.out_of_plane_share <= 1.0 + 1e-12))
    assert profile.health.error_bound <= 2.3e-16


def test_the_shock_of_a_point_follows_from_its_body():
    """A sensor's jump is v + ω × r in its axes, and its shock the length of that over the strike's
    speed.
    """
    robot = known_robot("anymal_b")
    profile = land(
        robot,
        [Contact(frame="LF_FOOT")],
        (0.3, 0.1, -2.0),
        point=(Point(frame="RH_FOOT", offset=(0.1, 0.2, 0.3)),),
    )
    found = {point.frame: point for point in profile.points}
    assert list(found) == ["imu_link", "RH_FOOT:0.1,0.2,0.3"]
    for name, offset in (("imu_link", (0.0, 0.0, 0.0)), ("RH_FOOT", (0.1, 0.2, 0.3))):
        frame = robot.frames[name]
        r = frame.offset + frame.rotation @ offset
        point = found[name if name == "imu_link" else "RH_FOOT:0.1,0.2,0.3"]
        jump = profile.delta_v[frame.body] + np.cross(profile.delta_omega[frame.body], r)
        np.testing.assert_allclose(frame.rotation @ point.delta_v, jump, atol=1e-14)
        assert point.shock == pytest.approx(np.linalg.norm(jump) / profile.v_in, rel=1e-13)
        assert point.shock == pytest.approx(profile.shock_at(point.body, r), rel=1e-13)
        np.testing.assert_allclose(
            point.position,
            profile.position[frame.body] + profile.rotation[frame.body] @ r,
            atol=1e-14,
        )


# Strikes


@pytest.mark.parametrize(
    ("strike", "vector"),
    [
        (Strike(), (0.0, 0.0, -1.0)),
        (Strike(speed=2.0), (0.0, 0.0, -2.0)),
        (Strike(speed=2.0, strike_angle_deg=30.0), (1.0, 0.0, -math.sqrt(3.0))),
        (Strike(strike_angle_deg=-30.0), (-0.5, 0.0, -math.sqrt(3.0) / 2.0)),
        (Strike(velocity=(0.1, 0.2, -0.3)), (0.1, 0.2, -0.3)),
        (Strike(drop_height=0.5), (0.0, 0.0, -math.sqrt(GRAVITY))),
        (
            Strike(drop_height=0.5, strike_angle_deg=45.0),
            (math.sqrt(GRAVITY), 0.0, -math.sqrt(GRAVITY)),
        ),
        (Strike(drop_height=0.5, forward_speed=-2.0), (-2.0, 0.0, -math.sqrt(GRAVITY))),
    ],
)
def test_a_strike_is_the_velocity_it_says(strike, vector):
    """The angle is counted from the vertical, positive moving forward; a fall of h ends at sqrt(2 g
    h) downwards.
    """
    profile = shock_profile(Scene(robot="leg", contact="heel", strike=strike), known_robot("leg"))
    np.testing.assert_allclose(profile.strike, vector, rtol=1e-15, atol=1e-15)
    assert profile.v_in == pytest.approx(np.linalg.norm(vector), rel=1e-15)


def test_a_scene_without_a_contact_is_refused():
    with pytest.raises(SceneError, match=r'contact.*"leg".*"heel"'):
        land(known_robot("leg"), [])


# Bodies without inertia


def pendulum(mass, inertia, com, carry=""):
    """A box that carries a bob on a hinge, and a foot on the bob."""
    moments = f'<inertia ixx="{inertia}" ixy="0" ixz="0" iyy="{inertia}" iyz="0" izz="{inertia}"/>'
    bob = (
        f'<link name="bob"><inertial><origin xyz="{com}"/><mass '
        f'value="{mass}"/>{moments}</inertial></link>'
    )
    hinge = joint(
        "hinge",
        "box",
        "bob",
        "continuous",
        "0.1 1 0.2",
        more='<origin xyz="0.3 0.1 -0.2" rpy="0.3 0.4 0.5"/>',
    )
    tip = '<link name="tip"/>' + joint(
        "tip_fixed", "bob", "tip", "fixed", more='<origin xyz="0.2 0.1 -0.3"/>'
    )
    return robot_from(urdf(link("box"), bob, hinge, tip, carry))


TILTED = Posture(base_rpy_deg=(10.0, 20.0, 30.0), joints={"hinge": 0.7})


@pytest.mark.parametrize(("mass", "com"), [("0", "0 0 0"), ("1", "0 0 0"), ("1", "0.01 0.1 0.02")])
def test_a_body_that_nothing_resists_is_named(mass, com):
    """A bob without mass, or with all of it on its axis: the message names the body and its joint,
    not the contact.
    """
    with pytest.raises(SolveError) as refusal:
        land(pendulum(mass, "0", com), [Contact(frame="tip")], posture=TILTED)
    assert says(
        str(refusal.value),
        'body "bob" of robot "r"',
        "no mass or inertia",
        'lock "hinge" with --lock',
    )


CHAIN = (
    link("base"),
    *(f'<link name="{name}"/>' for name in ("upper", "lower", "finger", "thumb")),
    joint("j1", "base", "upper"),
    joint("j2", "upper", "lower", axis="1 0 0"),
    joint("j3", "base", "finger"),
    joint("j4", "base", "thumb", more=LIMIT + '<mimic joint="j3"/>'),
    link("foot"),
    joint("leg", "base", "foot", more=LIMIT + '<origin xyz="0.1 0 -0.5"/>'),
)


def test_the_joints_of_massless_chains_are_those_to_be_locked():
    """Locking what the error names, and nothing else, is enough: two joints in series, and one with
    its follower.
    """
    scene = Scene(robot="r", contact=(Contact(frame="foot", offset=(0.0, 0.0, -0.1)),))
    robot = robot_from(urdf(*CHAIN))
    with pytest.raises(SolveError) as refusal:
        shock_profile(scene, robot)
    assert refusal.value.joints == ("j1", "j2", "j3", "j4")
    assert 'lock "j1", "j2", "j3", "j4" with --lock' in str(refusal.value)
    free = {"leg"}
    profile = shock_profile(replace(scene, joints=Joints(locked=refusal.value.joints)), robot)
    moving = {load.joint for load in profile.loads if abs(load.delta_qd) > 0.0}
    assert moving == free


# What a profile says of itself


def test_a_profile_is_read_only():
    """No array of it can be written to."""
    profile = shock_profile(Scene(robot="anymal_b", contact="LF_FOOT"), known_robot("anymal_b"))
    for name in (
        "q",
        "delta_qd",
        "maps",
        "position",
        "rotation",
        "delta_omega",
        "delta_v",
        "copc",
        "ropc",
        "total_impulse",
    ):
        with pytest.raises(ValueError, match="read-only"):
            getattr(profile, name)[...] = 0


def test_wrong_calls_are_refused_in_words(tmp_path):
    """A robot's name is a scene without contacts, a path may be a Path, and a configuration holds
    rotations.
    """
    with pytest.raises(SceneError, match=r"no contact is defined; .*LF_FOOT"):
        shock_profile("anymal_b")
    file = tmp_path / "r.urdf"
    file.write_text(urdf(link("box")))
    profile = shock_profile(
        Scene(robot=file, contact=Contact(frame="box", offset=(0.1, 0.0, -0.1)))
    )
    for wrong, text in ((0.0, "row 1 of Q"), (np.nan, "Q holds a number that is not finite")):
        with pytest.raises(SceneError, match=text):
            shock_maps(profile.landing, np.stack([profile.q, profile.q * wrong]))
    for shape in ((0, 7), (7,), (2, 6), (1, 2, 7)):
        with pytest.raises(SceneError, match=r"rows of 7 numbers, shape \(N, 7\)"):
            shock_maps(profile.landing, np.zeros(shape))
