"""Laws of mechanics that hold for every landing of every mechanism: no reference values, only the drawn numbers."""

import math

import numpy as np
import pinocchio as pin
import pytest
import trees
from hypothesis import assume, given
from hypothesis import strategies as st
from shockpc.model.bodies import body_jumps
from trees import MJCF_KINDS, SLIDES, Hit, Joint, Landing, Mechanism

from shockpc.core.beam import centre_of_percussion
from shockpc.model.contact import Contact
from shockpc.model.dynamics import dynamics
from shockpc.model.rows import point_block, row_jacobian
from shockpc.profile import shock_profile
from shockpc.scene import Scene, Strike

CLOSE = 1e-9  # masses over three decades in trees of 15 bodies: the joint-space inertia loses up to four digits of 2e-16
SEEDS = st.integers(0, 2**32 - 1)
ANY = trees.landings() | trees.landings(kinds=MJCF_KINDS)


def dialect(landing):
    return "mjcf" if any(joint.kind == "spherical" for joint in landing.mechanism.joints) else "urdf"


def land(landing, **how):
    return trees.land(landing, dialect=dialect(landing), **how)


def assert_same_jump(mechanism, found, expected):
    """Every body's twist agrees, relative to what the body itself does, or to 1e-6 of the fastest one."""
    size = trees.motion(mechanism, expected)
    assert np.all(trees.motion(mechanism, found - expected) <= CLOSE * np.maximum(size, 1e-6 * size.max()))


# Step 1 against a second formulation


@given(ANY, SEEDS)
def test_the_jump_is_the_one_of_least_kinetic_energy(landing, seed):
    """Of all jumps that joints and contacts allow, nature takes the one of least kinetic energy."""
    assert_same_jump(landing.mechanism, trees.twists(land(landing, seed=seed)), trees.least_energy_jump(landing))


@given(ANY, SEEDS, st.data())
def test_the_root_of_the_tree_does_not_matter(landing, seed, data):
    """Hung on another body, with other link frames and joint values, the mechanism takes the same shock at the same places."""
    root = data.draw(st.integers(0, len(landing.mechanism.mass) - 1))
    one, other = land(landing), land(landing, root=root, seed=seed)
    assert_same_jump(landing.mechanism, trees.twists(other), trees.twists(one))
    ropc = trees.in_order(one, one.ropc)
    turning = ropc < 1e3  # a larger radius is a difference of nearly equal velocities
    np.testing.assert_allclose(trees.in_order(other, other.ropc)[turning], ropc[turning], rtol=1e3 * CLOSE)


@given(ANY)
def test_the_check_in_maximal_coordinates_agrees(landing):
    """The profile's own estimate of its error is that of rounding, and it says so without a warning."""
    health = land(landing).health
    assert health.error_estimate <= CLOSE
    assert health.residual <= CLOSE
    assert not [warning for warning in health.warnings if "solutions differ" in warning]


# Step 2


@given(ANY)
def test_body_jumps_are_forward_kinematics_of_the_jump(landing):
    """Eqs. 8–9: the recursion from base to leaf, fed with Δq̇ for a velocity, gives every body's jump."""
    profile = land(landing)
    model, data = profile.robot.model, profile.robot.model.createData()
    pin.forwardKinematics(model, data, profile.q, profile.delta_qd)
    size = np.abs(profile.delta_v).max() + np.abs(profile.delta_omega).max()
    for body, omega, v in zip(profile.robot.bodies, profile.delta_omega, profile.delta_v, strict=True):
        there = pin.SE3(body.rotation, body.offset).actInv(data.v[body.joint])
        # Sums of up to 20 terms of the size of the fastest body.
        np.testing.assert_allclose(omega, there.angular, atol=1e-13 * size, rtol=1e-12)
        np.testing.assert_allclose(v, there.linear, atol=1e-13 * size, rtol=1e-12)


@given(trees.landings())
def test_many_postures_are_one_posture_many_times(landing):
    """A batch gives every posture what it gets alone."""
    profile = land(landing)
    model = profile.robot.model
    turned = pin.integrate(model, profile.q, 0.3 * np.ones(model.nv))
    one, other = (dynamics(profile.robot, q[None]) for q in (profile.q, turned))
    both = dynamics(profile.robot, np.stack([profile.q, turned]))
    qd = np.ones((2, model.nv, 1))
    for together, apart in zip(both[:6], zip(one[:6], other[:6], strict=True), strict=True):
        np.testing.assert_array_equal(together, np.concatenate(apart))
    apart = np.concatenate([body_jumps(one, qd[:1]), body_jumps(other, qd[1:])])
    np.testing.assert_allclose(body_jumps(both, qd), apart, rtol=1e-12, atol=1e-12 * np.abs(apart).max())  # order of a sum


# Scaling, moving and turning


@given(ANY, st.integers(-20, 20))
def test_copc_and_ropc_ignore_the_speed(landing, power):
    """A strike 2^k times as fast moves no centre of percussion and changes no radius (powers of two scale without rounding)."""
    one, other = land(landing), land(landing._replace(strike=landing.strike * 2.0**power))
    np.testing.assert_array_equal(other.copc, one.copc)
    np.testing.assert_array_equal(other.ropc, one.ropc)
    np.testing.assert_array_equal(other.shock_com, one.shock_com)
    np.testing.assert_array_equal(other.delta_v, one.delta_v * 2.0**power)


@pytest.mark.parametrize("speed", [1e-6, 0.3, 7.0, 1e6])
def test_copc_and_ropc_ignore_the_speed_of_a_real_robot(speed):
    """Between a micrometre and a thousand kilometres a second nothing but the impulses changes."""
    robot = trees.known_robot("anymal_b")
    scenes = [
        Scene(robot="anymal_b", contact=(Contact(frame="LF_FOOT"),), strike=Strike(speed=v, strike_angle_deg=20.0))
        for v in (1.0, speed)
    ]
    one, other = (shock_profile(scene, robot) for scene in scenes)
    np.testing.assert_allclose(other.copc, one.copc, rtol=1e-9)  # the smallest n·Δω is 1e-4 of its terms
    np.testing.assert_allclose(other.ropc, one.ropc, rtol=1e-9)
    np.testing.assert_allclose(other.contacts[0].impulse, speed * one.contacts[0].impulse, rtol=1e-12)


@given(ANY, SEEDS)
def test_the_jump_is_linear_in_the_strike(landing, seed):
    """The jump under a sum of strikes is the sum of the jumps, and the maps give it for every strike at once."""
    other = np.array([0.3, -0.2, -0.5]) + np.random.default_rng(seed).uniform(-0.1, 0.1, 3)
    profiles = [land(landing._replace(strike=strike)) for strike in (landing.strike, other, landing.strike + other)]
    first, second, both = (trees.twists(profile) for profile in profiles)
    assert_same_jump(landing.mechanism, first + second, both)
    jumps = profiles[0].maps @ other
    scale = np.abs(jumps).max()
    np.testing.assert_allclose(jumps[:, :3], profiles[1].delta_omega, rtol=0, atol=1e-13 * scale)
    np.testing.assert_allclose(jumps[:, 3:], profiles[1].delta_v, rtol=0, atol=1e-13 * scale)


@pytest.mark.parametrize("away", [(1.0, -2.0, 0.5), (1000.0, 0.0, 0.0), (0.0, -3e8, 0.0)])
@given(trees.landings())
def test_where_the_robot_stands_does_not_matter(away, landing):
    """A base a metre, a kilometre or a light second away moves every place and changes no shock, not in the last digit."""
    file = trees.written(landing.mechanism)
    robot = trees.robot_from(file.text)
    scene = trees.scene_of(landing, file)
    moved = tuple(x + a for x, a in zip(file.posture.base_position, away, strict=True))
    posture = type(file.posture)(base_position=moved, base_quaternion=file.posture.base_quaternion, joints=file.posture.joints)
    here, there = shock_profile(scene, robot), shock_profile(trees.scene_of(landing, file, posture=posture), robot)
    for name in ("delta_qd", "delta_omega", "delta_v", "copc", "ropc", "pitch", "shock_com", "off_plane"):
        np.testing.assert_array_equal(getattr(there, name), getattr(here, name))
    assert there.health == here.health
    np.testing.assert_allclose(
        there.position - here.position, np.tile(away, (len(here.bodies), 1)), atol=1e-15 * max(np.abs(away)) + 1e-14
    )


@given(trees.landings(), SEEDS)
def test_turning_everything_turns_the_answer(landing, seed):
    """Robot, strike, directions and plane turned together: every body feels the same in its own axes."""
    R = trees.random_rotations(np.random.default_rng(seed), 1)[0]
    R = R if (R @ landing.strike)[2] < 0.0 else -R  # an improper turn mirrors; two mirrored axes make it proper again
    R = R if np.linalg.det(R) > 0.0 else R @ (np.eye(3) - 2.0 * np.outer(u := _across(landing.strike), u))
    turned = tuple(hit._replace(directions=tuple(map(tuple, (np.asarray(hit.directions) @ R.T).tolist()))) for hit in landing.hits)
    assume((R @ landing.strike)[2] < -0.05)
    assume(all(np.abs(np.asarray(hit.directions)[:, 2]).max() > 0.05 for hit in turned))
    file = trees.written(landing.mechanism)
    robot = trees.robot_from(file.text)
    base = R @ file.rotations[0]
    posture = type(file.posture)(
        base_position=tuple((R @ file.posture.base_position).tolist()),
        base_quaternion=tuple(pin.Quaternion(base).coeffs().tolist()),
        joints=file.posture.joints,
    )
    here = shock_profile(trees.scene_of(landing, file), robot)
    scene = trees.scene_of(landing._replace(hits=turned, strike=R @ landing.strike), file, posture=posture)
    offsets = tuple(contact.offset for contact in trees.scene_of(landing, file).contact)
    contacts = tuple(type(c)(frame=c.frame, offset=o, directions=c.directions, restitution=c.restitution)
                     for c, o in zip(scene.contact, offsets, strict=True))  # fmt: skip
    normal = tuple((R @ [0.0, -1.0, 0.0]).tolist())
    there = shock_profile(type(scene)(**(vars(scene) | {"contact": contacts, "plane": normal})), robot)
    size = max(np.abs(here.delta_v).max(), np.abs(here.delta_omega).max())
    np.testing.assert_allclose(there.delta_omega, here.delta_omega, rtol=0, atol=CLOSE * size)
    np.testing.assert_allclose(there.delta_v, here.delta_v, rtol=0, atol=CLOSE * size)
    turning = here.ropc < 1e3  # a larger radius is a difference of nearly equal velocities
    np.testing.assert_allclose(there.ropc[turning], here.ropc[turning], rtol=1e3 * CLOSE)
    np.testing.assert_allclose(there.copc_world[turning], (here.copc_world @ R.T)[turning], rtol=0, atol=1e6 * CLOSE)


def _across(v):
    u = np.cross(v, [0.3, 0.5, 0.8])
    return u / np.linalg.norm(u)


# The contact


@given(ANY)
def test_restitution_is_met_along_every_kept_direction(landing):
    """J_c q̇⁺ = −e J_c q̇⁻."""
    jumps = trees.twists(land(landing)).ravel()
    rows, undone = trees.contact_system(landing)
    size = np.abs(rows) @ np.abs(jumps)
    np.testing.assert_array_less(np.abs(rows @ jumps + undone), CLOSE * size + 1e-12)


@given(ANY)
def test_energy_never_grows(landing):
    """A robot that falls without turning loses kinetic energy, all of ½ (1 − e²) of what its contacts could carry."""
    jumps = trees.twists(land(landing))
    before = np.zeros_like(jumps)
    before[:, 3:] = landing.strike
    lost = trees.kinetic_energy(landing.mechanism, before) - trees.kinetic_energy(landing.mechanism, before + jumps)
    e = landing.hits[0].restitution
    # Gauss: the jump is orthogonal in energy to what is left, so the loss is (1 − e)/(1 + e) of the jump's own energy.
    expected = (1.0 - e) / (1.0 + e) * trees.kinetic_energy(landing.mechanism, jumps)
    rounding = CLOSE * trees.kinetic_energy(landing.mechanism, before)
    assert lost == pytest.approx(expected, rel=CLOSE, abs=rounding)
    assert lost >= -rounding


@given(trees.landings(hits=1, sticking=True, restitution=False))
def test_the_energy_lost_is_that_of_the_effective_mass(landing):
    """One sticking point, e = 0: ½ vᵀ Λ v with Λ = (J_c H⁻¹ J_cᵀ)⁻¹, here built by Pinocchio, is the drop in kinetic energy."""
    profile = land(landing)
    robot, hit = profile.robot, landing.hits[0]
    state = dynamics(robot, profile.q[None])
    data = robot.model.createData()
    H = pin.crba(robot.model, data, profile.q)
    H = np.triu(H) + np.triu(H, 1).T
    body = next(body for body in robot.bodies if body.name == f"body{hit.body}")
    pin.computeJointJacobians(robot.model, data, profile.q)
    J = pin.getJointJacobian(robot.model, data, body.joint, pin.LOCAL_WORLD_ALIGNED)
    arm = profile.contacts[0].point - data.oMi[body.joint].translation
    J_c = J[:3] - pin.skew(arm) @ J[3:]
    i = robot.bodies.index(body)
    point = profile.rotation[i].T @ (hit.point - profile.position[i])
    np.testing.assert_allclose(row_jacobian(state, point_block(state, i, point, np.eye(3)))[0], J_c, atol=1e-12, rtol=1e-12)
    Lambda = np.linalg.inv(J_c @ np.linalg.solve(H, J_c.T))
    before = np.zeros((len(robot.bodies), 6))
    before[:, 3:] = landing.strike
    after = before + trees.twists(profile)
    lost = trees.kinetic_energy(landing.mechanism, before) - trees.kinetic_energy(landing.mechanism, after)
    whole = trees.kinetic_energy(landing.mechanism, before)
    assert lost == pytest.approx(0.5 * landing.strike @ Lambda @ landing.strike, rel=1e-6, abs=CLOSE * whole)
    np.testing.assert_allclose(profile.contacts[0].impulse, -Lambda @ landing.strike, rtol=1e-6, atol=CLOSE * np.abs(Lambda).max())


@given(ANY)
def test_momentum_changes_by_the_impulses_of_the_ground(landing):
    """Σ m Δv = Σ λ and, about the origin, Σ (c × m Δv + I Δω) = Σ p × λ: nothing but the contacts acts on a free robot."""
    profile = land(landing)
    assume(all(contact.impulse is not None for contact in profile.contacts))
    m = landing.mechanism
    jumps = trees.twists(profile)
    linear = m.mass[:, None] * jumps[:, 3:]
    angular = np.cross(m.com, linear) + (m.inertia @ jumps[:, :3, None])[..., 0]
    impulses = np.stack([contact.impulse for contact in profile.contacts])
    moments = np.stack([np.cross(contact.point, contact.impulse) for contact in profile.contacts])
    # Impulses of contacts that nearly repeat each other are large and opposite.
    size = np.abs(linear).sum() + np.abs(impulses).max()
    np.testing.assert_allclose(linear.sum(axis=0), impulses.sum(axis=0), rtol=0, atol=CLOSE * size)
    reach = np.abs(m.com).max() + np.abs([contact.point for contact in profile.contacts]).max() + 1.0
    np.testing.assert_allclose(angular.sum(axis=0), moments.sum(axis=0), rtol=0, atol=CLOSE * size * reach)


@given(trees.landings(planar=True, hits=1, sticking=True))
def test_the_struck_body_turns_about_a_point_at_ropc_from_the_contact(landing):
    """In the plane the contact feels (1 + e) v_in, so the struck body's CoPc lies (1 + e) RoPc from it, square to the strike."""
    profile = land(landing)
    hit = landing.hits[0]
    i = profile.bodies.index(f"body{hit.body}")
    assume(profile.ropc[i] < 1e3)  # a body that all but translates has its centre in the next town
    arm = (hit.point - profile.copc_world[i]) * [1.0, 0.0, 1.0]
    reach = (1.0 + hit.restitution) * profile.ropc[i]
    assert np.linalg.norm(arm) == pytest.approx(reach, rel=1e-8)
    assert arm @ landing.strike == pytest.approx(0.0, abs=1e-8 * reach * profile.v_in)


@given(trees.landings(planar=True, hits=2))
def test_a_planar_landing_stays_in_its_plane(landing):
    """A mechanism that lies in x–z and is struck there never leaves it: no share of any jump is off the plane."""
    profile = land(landing)
    moved = trees.motion(landing.mechanism, trees.twists(profile)) > 1e-6 * profile.v_in
    np.testing.assert_array_less(trees.in_order(profile, profile.off_plane)[moved], 1e-8)


@given(trees.landings(planar=True))
def test_a_planar_robot_takes_no_notice_of_a_planar_base(landing):
    """What is symmetric about its plane moves in it by itself: holding the base there changes nothing."""
    free, planar = land(landing), land(landing, base="planar")
    assert_same_jump(landing.mechanism, trees.twists(planar), trees.twists(free))
    assert planar.delta_qd.shape == free.delta_qd.shape


# Chains of the paper (Section 3.4)


def slender_chain(rng, bodies, last=None):
    """Uniform rods hinged end to end in x–z; `last` is the direction of the final one."""
    length, mass = rng.uniform(0.1, 1.0, bodies), 10.0 ** rng.uniform(-1.0, 1.0, bodies)
    angle = rng.uniform(-math.pi, math.pi, bodies)
    if last is not None:
        angle[-1] = last
    along = np.stack([np.cos(angle), np.zeros(bodies), np.sin(angle)], axis=1)
    ends = np.concatenate([np.zeros((1, 3)), np.cumsum(length[:, None] * along, axis=0)])
    across = np.eye(3) - along[:, :, None] * along[:, None, :]
    inertia = (mass * length**2 / 12.0)[:, None, None] * (across + 1e-4 * np.eye(3))
    inertia[:, 1, 1] = mass * length**2 / 12.0
    joints = tuple(Joint(i, i + 1, "revolute", ends[i + 1], np.array([0.0, 1.0, 0.0])) for i in range(bodies - 1))
    return Mechanism(mass, ends[:-1] + 0.5 * length[:, None] * along, inertia, joints), ends, along, length


@given(st.integers(2, 6), SEEDS)
def test_the_last_rod_of_a_chain_has_its_copc_at_two_thirds(bodies, seed):
    """Whatever strikes a chain, its last body is struck through its hinge, so Eq. 1 holds along it: ⅔ of a slender rod."""
    rng = np.random.default_rng(seed)
    mechanism, ends, along, length = slender_chain(rng, bodies)
    strike = np.array([rng.uniform(-1.0, 1.0), 0.0, -rng.uniform(0.1, 1.0)])
    profile = land(Landing(mechanism, (Hit(0, ends[0]),), strike))
    i = profile.bodies.index(f"body{bodies - 1}")
    assume(profile.ropc[i] < 1e3)
    assert (profile.copc_world[i] - ends[-2]) @ along[-1] == pytest.approx(length[-1] * 2.0 / 3.0, rel=1e-8)


@given(trees.landings(planar=True, kinds=("revolute",), hits=1, sticking=True))
def test_a_leaf_has_its_copc_where_eq_1_puts_it(landing):
    """Any leaf that is not struck: from its hinge, along the line to its centre of mass, c (p − c) = r_g²."""
    m = landing.mechanism
    profile = land(landing)
    ends = [body for joint in m.joints for body in (joint.a, joint.b)]
    for joint in m.joints:
        if ends.count(joint.b) == 1 and joint.b != landing.hits[0].body:
            i = profile.bodies.index(f"body{joint.b}")
            arm = m.com[joint.b] - joint.point
            c = np.linalg.norm(arm)
            p = centre_of_percussion(c, math.sqrt(m.inertia[joint.b, 1, 1] / m.mass[joint.b]))
            if profile.ropc[i] < 1e3:
                assert (profile.copc_world[i] - joint.point) @ arm / c == pytest.approx(p, rel=1e-7)


@given(st.integers(2, 6), SEEDS)
def test_a_foot_struck_squarely_scales_everything_above_by_one_factor(bodies, seed):
    """A strike square to the line from ball to ankle reaches the ankle so too: above, only the size of the shock changes."""
    rng = np.random.default_rng(seed)
    chain, ends, _, _ = slender_chain(rng, bodies)
    strike = np.array([rng.uniform(-1.0, 1.0), 0.0, -rng.uniform(0.1, 1.0)])
    above = trees.twists(land(Landing(chain, (Hit(0, ends[0]),), strike)))

    forward = np.array([-strike[2], 0.0, strike[0]]) / np.linalg.norm(strike)
    length, mass = rng.uniform(0.05, 0.3), 10.0 ** rng.uniform(-1.0, 1.0)
    ball = ends[0] + length * forward
    foot = Joint(0, bodies, "revolute", ends[0], np.array([0.0, 1.0, 0.0]))
    shod = Mechanism(
        np.append(chain.mass, mass),
        np.vstack([chain.com, ends[0] + rng.uniform(0.1, 0.9) * length * forward]),
        np.concatenate([chain.inertia, mass * length**2 / 12.0 * np.eye(3)[None]]),
        (*chain.joints, foot),
    )
    with_foot = trees.twists(land(Landing(shod, (Hit(bodies, ball),), strike)))[:-1]
    factor = np.sum(with_foot * above) / np.sum(above**2)
    np.testing.assert_allclose(with_foot, factor * above, rtol=0, atol=1e-9 * np.abs(above).max())  # chains of up to six rods


@given(trees.landings(hits=1, sticking=True, restitution=False))
def test_sliding_costs_less_energy_than_sticking(landing):
    """A contact that holds fewer directions takes less: the frictionless loss never exceeds the sticking one."""
    sliding = landing._replace(hits=(landing.hits[0]._replace(directions=SLIDES),))
    stuck, slid = (trees.kinetic_energy(one.mechanism, trees.twists(land(one))) for one in (landing, sliding))
    assert slid <= stuck * (1.0 + CLOSE)


def test_unequal_restitution_may_not_make_energy_in_silence():
    """Newton's rule with unequal e on one body can make energy from nothing; whoever computes that is told."""
    rod = Mechanism(np.ones(1), np.zeros((1, 3)), np.diag([1 / 12, 1 / 12, 1e-3])[None], ())
    hits = (Hit(0, np.array([0.30, 0.0, 0.0]), SLIDES, 1.0), Hit(0, np.array([0.35, 0.0, 0.0]), SLIDES, 0.0))
    profile = land(Landing(rod, hits, np.array([0.0, 0.0, -1.0])))
    before = np.array([[0.0, 0.0, 0.0, 0.0, 0.0, -1.0]])
    gained = trees.kinetic_energy(rod, before + trees.twists(profile)) - trees.kinetic_energy(rod, before)
    assert gained > 0.0
    assert any("energy" in warning for warning in profile.health.warnings)
