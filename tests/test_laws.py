"""Laws of mechanics that hold for every landing of every mechanism: no reference values, only the
drawn numbers.
"""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
import trees
from hypothesis import assume, given
from hypothesis import strategies as st
from trees import MJCF_KINDS, SLIDES, Hit, Joint, Landing, Mechanism

from shockpc import Strike, shock_profile

pytestmark = pytest.mark.smoke

# masses over three decades in trees of 15 bodies: the reference loses up to four digits of 2e-16
CLOSE = 1e-9
SEEDS = st.integers(0, 2**32 - 1)
ANY = trees.landings() | trees.landings(kinds=MJCF_KINDS)


def land(landing, **how):
    ball_joints = any(joint.kind in ("spherical", "planar") for joint in landing.mechanism.joints)
    return trees.land(landing, dialect="mjcf" if ball_joints else "urdf", **how)


def assert_same_jump(mechanism, found, expected):
    """Every body's twist agrees, relative to what the body itself does, or to 1e-6 of the fastest
    one.
    """
    size = trees.motion(mechanism, expected)
    assert np.all(
        trees.motion(mechanism, found - expected) <= CLOSE * np.maximum(size, 1e-6 * size.max())
    )


# Step 1 against a second formulation


@pytest.mark.slow
@given(ANY, SEEDS)
def test_the_jump_is_the_one_of_least_kinetic_energy(landing, seed):
    """Of all jumps that joints and contacts allow (Gauss; Kelvin); and double precision gives the
    same to the error reported.
    """
    profile = land(landing, seed=seed)
    assert_same_jump(landing.mechanism, trees.twists(profile), trees.least_energy_jump(landing))
    assert profile.health.error_bound <= 2.3e-16
    assert profile.health.double_error <= CLOSE


@pytest.mark.slow
@given(ANY, SEEDS, st.data())
def test_the_root_of_the_tree_does_not_matter(landing, seed, data):
    """With another body as base, other link frames and other joint values, the shock is the same at
    the same places.
    """
    root = data.draw(st.integers(0, len(landing.mechanism.mass) - 1))
    one, other = land(landing), land(landing, root=root, seed=seed)
    assert_same_jump(landing.mechanism, trees.twists(other), trees.twists(one))
    ropc = trees.in_order(one, one.ropc)
    turning = ropc < 1e3  # a larger radius is a difference of nearly equal velocities
    np.testing.assert_allclose(
        trees.in_order(other, other.ropc)[turning], ropc[turning], rtol=1e3 * CLOSE
    )


# Scaling, moving and turning


@pytest.mark.slow
@given(ANY, st.integers(-20, 20))
def test_copc_and_ropc_ignore_the_speed(landing, power):
    """A strike 2^k times as fast moves no centre of percussion and changes no radius (powers of two
    scale without rounding).
    """
    one, other = land(landing), land(landing._replace(strike=landing.strike * 2.0**power))
    np.testing.assert_array_equal(other.copc, one.copc)
    np.testing.assert_array_equal(other.ropc, one.ropc)
    np.testing.assert_array_equal(other.shock_com, one.shock_com)
    np.testing.assert_array_equal(other.delta_v, one.delta_v * 2.0**power)


@pytest.mark.slow
@given(ANY, SEEDS)
def test_the_jump_is_linear_in_the_strike(landing, seed):
    """The jump under a sum of strikes is the sum of the jumps, and the maps give it for every
    strike at once.
    """
    other = np.array([0.3, -0.2, -0.5]) + np.random.default_rng(seed).uniform(-0.1, 0.1, 3)
    profiles = [
        land(landing._replace(strike=strike))
        for strike in (landing.strike, other, landing.strike + other)
    ]
    first, second, both = (trees.twists(profile) for profile in profiles)
    assert_same_jump(landing.mechanism, first + second, both)
    jumps = profiles[0].maps @ other
    scale = np.abs(jumps).max()
    np.testing.assert_allclose(jumps[:, :3], profiles[1].delta_omega, rtol=0, atol=1e-13 * scale)
    np.testing.assert_allclose(jumps[:, 3:], profiles[1].delta_v, rtol=0, atol=1e-13 * scale)


@pytest.mark.slow
@given(st.sampled_from([(1.0, -2.0, 0.5), (1000.0, 0.0, 0.0), (0.0, -3e8, 0.0)]), trees.landings())
def test_where_the_robot_stands_does_not_matter(away, landing):
    """A base a metre, a kilometre or a light second away moves every place and changes no shock,
    not in the last digit.
    """
    file = trees.written(landing.mechanism)
    robot, scene = trees.robot_from(file.text), trees.scene_of(landing, file)
    posture = replace(
        file.posture,
        base_position=tuple(x + a for x, a in zip(file.posture.base_position, away, strict=True)),
    )
    here, there = shock_profile(scene, robot), shock_profile(replace(scene, posture=posture), robot)
    for name in (
        "delta_qd",
        "delta_omega",
        "delta_v",
        "copc",
        "ropc",
        "screw_pitch",
        "shock_com",
        "out_of_plane_share",
    ):
        np.testing.assert_array_equal(getattr(there, name), getattr(here, name))
    # places need more digits near the origin
    assert there.health._replace(bits=here.health.bits) == here.health
    moved = np.tile(away, (len(here.bodies), 1))
    np.testing.assert_allclose(
        there.position - here.position, moved, atol=1e-15 * max(np.abs(away)) + 1e-14
    )


@given(trees.landings(), SEEDS)
@pytest.mark.slow
def test_turning_everything_turns_the_answer(landing, seed):
    """Robot, strike, directions and plane turned together: every body has the same jump in its
    axes.
    """
    R = trees.random_rotations(np.random.default_rng(seed), 1)[0]
    turned = [
        hit._replace(directions=tuple(map(tuple, (np.asarray(hit.directions) @ R.T).tolist())))
        for hit in landing.hits
    ]
    assume((R @ landing.strike)[2] < -0.05)
    assume(all(np.abs(np.asarray(hit.directions)[:, 2]).max() > 0.05 for hit in turned))
    file = trees.written(landing.mechanism)
    robot, scene = trees.robot_from(file.text), replace(trees.scene_of(landing, file), plane="xz")
    posture = replace(
        file.posture,
        base_position=tuple((R @ file.posture.base_position).tolist()),
        base_quaternion=tuple(pin.Quaternion(R @ file.rotations[0]).coeffs().tolist()),
    )
    changed = replace(
        scene,
        posture=posture,
        strike=Strike(velocity=tuple((R @ landing.strike).tolist())),
        contact=tuple(
            replace(c, directions=hit.directions)
            for c, hit in zip(scene.contact, turned, strict=True)
        ),
        plane=tuple((R @ [0.0, -1.0, 0.0]).tolist()),
    )
    here, there = shock_profile(scene, robot), shock_profile(changed, robot)
    size = max(np.abs(here.delta_v).max(), np.abs(here.delta_omega).max())
    np.testing.assert_allclose(there.delta_omega, here.delta_omega, rtol=0, atol=CLOSE * size)
    np.testing.assert_allclose(there.delta_v, here.delta_v, rtol=0, atol=CLOSE * size)
    turning = here.ropc < 1e3  # a larger radius is a difference of nearly equal velocities
    np.testing.assert_allclose(there.ropc[turning], here.ropc[turning], rtol=1e3 * CLOSE)
    np.testing.assert_allclose(
        there.copc_world[turning], (here.copc_world @ R.T)[turning], rtol=0, atol=1e6 * CLOSE
    )


# The contact


@given(trees.landings(planar=True, hits=1, sticking=True))
def test_the_struck_body_has_its_centre_at_ropc_from_the_contact(landing):
    """In the plane the contact jumps by (1 + e) v_in, so the CoPc lies (1 + e) RoPc from it,
    perpendicular to the strike.
    """
    profile = land(landing)
    hit = landing.hits[0]
    i = profile.bodies.index(f"body{hit.body}")
    assume(profile.ropc[i] < 1e3)  # otherwise it nearly translates
    arm = (hit.point - profile.copc_world[i]) * [1.0, 0.0, 1.0]
    reach = (1.0 + hit.restitution) * profile.ropc[i]
    assert np.linalg.norm(arm) == pytest.approx(reach, rel=1e-8)
    assert arm @ landing.strike == pytest.approx(0.0, abs=1e-8 * reach * profile.v_in)


@given(trees.landings(planar=True))
def test_a_planar_landing_stays_in_its_plane(landing):
    """A mechanism that lies in x–z and is struck there does not leave it, so that holding its base
    in the plane changes nothing.
    """
    free, planar = land(landing), land(landing, base="planar")
    moved = trees.motion(landing.mechanism, trees.twists(free)) > 1e-6 * free.v_in
    np.testing.assert_array_less(trees.in_order(free, free.out_of_plane_share)[moved], 1e-8)
    assert_same_jump(landing.mechanism, trees.twists(planar), trees.twists(free))


# Chains of the paper (Section 3.4)


@given(trees.landings(planar=True, kinds=("revolute",), hits=1, sticking=True))
def test_a_leaf_has_its_copc_where_eq_1_puts_it(landing):
    """Any leaf that is not struck: from its hinge, along the line to its centre of mass, c (p − c)
    = r_g²; ⅔ of a slender rod.
    """
    m = landing.mechanism
    profile = land(landing)
    ends = [body for joint in m.joints for body in (joint.a, joint.b)]
    for joint in m.joints:
        if ends.count(joint.b) == 1 and joint.b != landing.hits[0].body:
            i = profile.bodies.index(f"body{joint.b}")
            arm = m.com[joint.b] - joint.point
            c = np.linalg.norm(arm)
            p = c + m.inertia[joint.b, 1, 1] / m.mass[joint.b] / c
            if profile.ropc[i] < 1e3:
                assert (profile.copc_world[i] - joint.point) @ arm / c == pytest.approx(p, rel=1e-7)


@given(
    trees.landings(planar=True, kinds=("revolute",), hits=1, sticking=True, restitution=False),
    SEEDS,
)
def test_a_foot_struck_perpendicularly_scales_everything_above_by_one_factor(landing, seed):
    """A strike perpendicular to the line from ball to ankle arrives at the ankle in the same
    direction: only its size changes.
    """
    rng, m, (hit,) = np.random.default_rng(seed), landing.mechanism, landing.hits
    above = trees.twists(land(landing))
    forward = np.array([-landing.strike[2], 0.0, landing.strike[0]]) / np.linalg.norm(
        landing.strike
    )
    length, mass, foot = rng.uniform(0.05, 0.3), 10.0 ** rng.uniform(-1.0, 1.0), len(m.mass)
    longer = Mechanism(
        np.append(m.mass, mass),
        np.vstack([m.com, hit.point + rng.uniform(0.1, 0.9) * length * forward]),
        np.concatenate([m.inertia, mass * length**2 / 12.0 * np.eye(3)[None]]),
        (*m.joints, Joint(hit.body, foot, "revolute", hit.point, np.array([0.0, 1.0, 0.0]))),
    )
    with_foot = trees.twists(
        land(Landing(longer, (Hit(foot, hit.point + length * forward),), landing.strike))
    )[:-1]
    np.testing.assert_allclose(
        with_foot,
        np.sum(with_foot * above) / np.sum(above**2) * above,
        rtol=0,
        atol=1e-8 * np.abs(above).max(),
    )


@given(trees.landings(hits=1, sticking=True, restitution=False))
def test_sliding_costs_less_energy_than_sticking(landing):
    """A contact that holds fewer directions takes less: the frictionless loss never exceeds the
    sticking one.
    """
    sliding = landing._replace(hits=(landing.hits[0]._replace(directions=SLIDES),))
    assert land(sliding).energy_lost <= land(landing).energy_lost * (1.0 + CLOSE)


def test_energy_made_by_unequal_restitution_has_a_warning():
    """Newton's rule with unequal e on one body can create energy."""
    rod = Mechanism(np.ones(1), np.zeros((1, 3)), np.diag([1 / 12, 1 / 12, 1e-3])[None], ())
    hits = (
        Hit(0, np.array([0.30, 0.0, 0.0]), SLIDES, 1.0),
        Hit(0, np.array([0.35, 0.0, 0.0]), SLIDES, 0.0),
    )
    profile = land(Landing(rod, hits, np.array([0.0, 0.0, -1.0])))
    omega, v = np.split(trees.twists(profile)[0], 2)
    gained = 0.5 * (np.sum((v - [0.0, 0.0, 1.0]) ** 2) + omega @ rod.inertia[0] @ omega - 1.0)
    assert profile.energy_lost == pytest.approx(-gained, rel=1e-9)
    assert [warning.value for warning in profile.health.warnings if warning.kind == "energy"] == [
        profile.energy_lost
    ]
    assert gained > 0.0
