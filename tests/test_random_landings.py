"""The reported bounds against an independent solution in maximal coordinates."""

import dense
import flint
import mpmath
import numpy as np
import pytest
from maximal import BALLS, DIGITS, MPMATH, maximal_jumps
from proof_check import assert_maps_are_those_of_the_proof, body_errors, check, checked, excess
from random_landings import random_landing
from trees import known_robot

from shockpc import Contact, Scene, Strike, shock_profile
from shockpc.landing.landing import contact_velocity

BLOCKS, SLOW, EACH = 4, 8, 20


@pytest.fixture(
    scope="module",
    params=[
        *range(BLOCKS),
        *(pytest.param(block, marks=pytest.mark.slow) for block in range(BLOCKS, BLOCKS + SLOW)),
    ],
)
def landings(request):
    """Some of 240 random landings, a part of which is refused."""
    return [checked(number) for number in range(EACH * request.param, EACH * (request.param + 1))]


@pytest.fixture
def profiles(landings):
    return [profile for _, profile in landings if profile is not None]


def test_no_error_is_above_the_reported_bound(landings, profiles):
    """And no row is wrongly left out as dependent."""
    assert [found for found, _ in landings if found.violated] == []
    assert len(profiles) >= EACH // 2


def test_maps_are_those_of_the_proof_unless_flagged(profiles):
    """Trees with every kind of joint, mimic joints, loops, armature, locked joints, stance, every
    base.
    """
    for profile in profiles:
        assert_maps_are_those_of_the_proof(profile)


@pytest.mark.slow
def test_energy_momentum_and_loads(profiles):
    """Contacts approach as the whole motion makes them; what is lost is the drop of ½ q̇ᵀ (H +
    armature) q̇.

    What the ground gives is the jump of the momentum, of all bodies and of those behind each joint.
    """
    free = [profile for profile in profiles if profile.scene.base == "free"]
    assert len(free) > 3
    for k, profile in enumerate(free):
        assert_balances(profile, warnings=k % 4 == 0 or profile.energy_lost < 0.0)
    for profile in profiles:
        if len(profile.row_space.rows) == len(profile.proof.impulse) and not profile.scene.closure:
            assert_loads(profile)


def assert_balances(profile, warnings):
    before, R = profile.landing.before, profile.rotation[0]
    qd = np.array(before.joint_rates)
    qd[:6] = [*(R.T @ before.velocity), *(R.T @ before.omega)]
    for contact, given, block in zip(
        profile.contacts, profile.scene.contact, profile.landing.constraints, strict=False
    ):
        J = dense.point_rows(profile.robot.model, profile.q, given.frame, given.offset)
        for approach in (
            contact.approach,
            contact_velocity(profile.landing, profile.landing.state, block)[0],
        ):
            np.testing.assert_allclose(
                approach, J @ qd, rtol=0, atol=1e-12 * (1.0 + np.abs(J) @ np.abs(qd)).max()
            )
    H = dense.inertia(profile.robot.model, profile.q) + np.diag(
        profile.landing.joint_model.armature
    )
    start, end = (0.5 * v @ H @ v for v in (qd, qd + profile.delta_qd))
    if not profile.stance:  # which the motion before the impact would move
        assert profile.energy_lost == pytest.approx(start - end, abs=1e-9 * max(start, end))
        gains = warnings and any(warning.kind == "energy" for warning in profile.health.warnings)
        assert (
            profile.energy_lost < 0.0 if gains else profile.energy_lost >= -1e-12 * max(start, end)
        )
        # Along all rows, one coefficient of restitution never makes energy.
        assert not gains or any(
            contact.restitution_along == "normal" for contact in profile.scene.contact
        )
        assert profile.energy_share == pytest.approx(profile.energy_lost / start, rel=1e-9)
    linear, angular = dense.momentum(profile, about=dense.centre_of_mass(profile))
    size = sum(body.mass for body in profile.robot.bodies) * (
        1.0 + np.abs(profile.delta_v).max() + np.abs(profile.delta_omega).max()
    )
    np.testing.assert_allclose(profile.total_impulse, linear, rtol=0, atol=1e-11 * size)
    np.testing.assert_allclose(profile.total_moment, angular, rtol=0, atol=1e-10 * size)


def assert_loads(profile):
    robot, none = profile.robot, np.zeros(3)
    ground = [
        (robot.frame(foot.frame).body, foot.point, foot.impulse, none) for foot in profile.stance
    ]
    for placed, one in zip(profile.landing.contacts, profile.contacts, strict=True):
        ground.append(
            (placed.body, one.point, one.impulse, none if one.moment is None else one.moment)
        )
    size = sum(np.linalg.norm(impulse) + np.linalg.norm(moment) for _, _, impulse, moment in ground)
    for load in profile.loads:
        k, joint = next(
            (k, joint)
            for k, joint in enumerate(robot.joints)
            if load.joint in joint.name.split("+")
        )
        behind, about = robot.ancestors[:, joint.v].any(axis=1), profile.position[k]
        force, moment = dense.momentum(profile, np.flatnonzero(behind), about)
        for body, point, impulse, stop_joint in ground:
            force = force - behind[body] * impulse
            moment = moment - behind[body] * (np.cross(point - about, impulse) + stop_joint)
        np.testing.assert_allclose(load.force, force, rtol=0, atol=1e-9 * size)
        np.testing.assert_allclose(load.moment, moment, rtol=0, atol=1e-9 * size)
        if joint.kind in ("revolute", "continuous"):
            assert load.along == pytest.approx(
                load.moment @ profile.rotation[k] @ joint.axis, abs=1e-9 * size
            )
        if load.along is not None and not any(
            joint.name in (mimic.joint, *mimic.leaders) for mimic in robot.mimics
        ):
            # A free joint carries nothing along its axis, a geared one −a Δq̇, and a locked one
            # does not move.
            model, rate = profile.landing.joint_model, load.delta_qd
            stop_joint = robot.joint(load.joint).v
            carried = load.along == pytest.approx(
                -model.armature[stop_joint].item() * rate, abs=1e-9 * size
            )
            assert rate == 0.0 if model.locked[stop_joint] else carried


@pytest.mark.parametrize("number", sorted({*range(0, 60, 12)} - {48}))  # which are refused
def test_two_libraries_of_long_numbers_agree(number):
    """The independent solution is the same with Arb's balls and with mpmath's numbers."""
    robot, scene = random_landing(number)
    profile = shock_profile(scene, robot)
    balls, numbers = (
        maximal_jumps(profile.landing, profile.row_space.rows, kind) for kind in (BALLS, MPMATH)
    )
    with flint.ctx.workdps(DIGITS), mpmath.workdps(DIGITS):
        size = max(abs(value.mid()) for value in balls.jumps.ravel())
        for ball, value in zip(balls.jumps.ravel(), numbers.jumps.ravel(), strict=True):
            assert abs(ball - flint.arb(mpmath.nstr(value, DIGITS))) < size * flint.arb("1e-50")


def test_contacts_that_contradict_one_another_are_refused_beside_a_loop():
    """Two points of one body at different heights that rebound: the digits of the loop are no
    excuse for what is left, 1.6e-5.
    """
    found = check(4011753)
    assert "cannot be stopped" in found.message


def solved(robot, scene):
    """The independent solution of a scene, and its profile."""
    profile = shock_profile(scene, robot)
    return maximal_jumps(profile.landing, profile.row_space.rows), profile


OBLIQUE = Strike(velocity=(0.3, 0.2, -1.0))


@pytest.mark.parametrize("name", ["panda", "talos_full"])
def test_mimic_joints_agree(name):
    """Followers tied by rows (here) and left out as columns (package, Eq. 7) give the same answer."""
    robot = known_robot(name)
    exact, profile = solved(
        robot,
        Scene(robot=name, contact=Contact(frame=robot.links[-1], kind="point"), strike=OBLIQUE),
    )
    assert len(exact.impulse) == 3 + len(robot.mimics)
    assert excess(profile, exact) <= 1.0


def test_an_error_is_seen():
    """The exact answer rounded to doubles has an error of rounding; one digit that is changed shows
    in its body alone.
    """
    exact, profile = solved(
        known_robot("anymal_b"), Scene(robot="anymal_b", contact="LF_FOOT", strike=OBLIQUE)
    )
    rounded = np.vectorize(float)(exact.jumps[..., 3])
    assert body_errors(profile.landing, exact, rounded).max() < 1e-15
    rounded[3] *= 1.0 + 1e-6
    errors = body_errors(profile.landing, exact, rounded)
    assert errors[3] == pytest.approx(1e-6, rel=1e-6)
    assert np.delete(errors, 3).max() < 1e-15


def test_a_landing_is_the_same_wherever_it_is_drawn():
    (robot, scene), (again, same) = random_landing(5), random_landing(5)
    assert scene == same
    assert [body.mass for body in robot.bodies] == [body.mass for body in again.bodies]
