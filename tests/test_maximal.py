"""Step 1 in maximal coordinates: agrees where both are exact, and keeps its digits where the joint-space inertia loses them."""

import mpmath
import numpy as np
import pytest
import trees
from hypothesis import given
from hypothesis import strategies as st
from shockpc.core.maximal import refine, solve_maximal
from shockpc.core.rounding import UNITS
from shockpc.health import SAMPLES
from trees import STICKS, Hit, Landing

from shockpc.model.dynamics import dynamics, tree

SEEDS = st.integers(0, 2**32 - 1)


def solved(landing, **how):
    """Twists at the centres of mass in the mechanism's order: plain, refined, and the spread of those; and the profile."""
    profile = trees.land(landing, **how)
    bodies = tree(profile.robot, dynamics(profile.robot, profile.q[None]), np.zeros(profile.robot.model.nv), None)
    origin = profile.q[:3]
    rows, undone = trees.contact_system(landing)
    order = [int(name.removeprefix("body")) for name in profile.bodies]
    rows = rows.reshape(len(rows), -1, 6)[:, order]
    np.testing.assert_allclose(bodies.com + origin, landing.mechanism.com[order], atol=1e-12)
    plain = solve_maximal(bodies, rows, undone[:, None])
    refined, spread = refine(bodies, rows, plain, SAMPLES, UNITS)
    back = np.argsort(order)
    return plain.twists[back, :, 0], refined.twists[back, :, 0], spread[back, :, 0], profile


def relative(mechanism, found, expected):
    """Largest error of a body, relative to its own motion."""
    return float((trees.motion(mechanism, found - expected) / trees.motion(mechanism, expected)).max())


@given(trees.landings(hits=1), SEEDS)
def test_it_agrees_with_least_energy_and_with_joint_space(landing, seed):
    """Three formulations that share no matrix give one answer."""
    jumps, _, _, profile = solved(landing, seed=seed)
    expected = trees.least_energy_jump(landing)
    size = trees.motion(landing.mechanism, expected)
    for other in (expected, trees.twists(profile)):
        # Trees of 15 bodies over three decades of mass.
        assert np.all(trees.motion(landing.mechanism, jumps - other) <= 1e-9 * np.maximum(size, 1e-6 * size.max()))


def exact_jump(landing):
    """The same problem with fifty digits: M V = Cᵀ λ, C V = −b, assembled from the mechanism's own numbers."""
    m = landing.mechanism
    n = len(m.mass)
    with mpmath.workdps(50):
        M = mpmath.zeros(6 * n)
        for i in range(n):
            for a in range(3):
                M[6 * i + 3 + a, 6 * i + 3 + a] = mpmath.mpf(m.mass[i])
                for b in range(3):
                    M[6 * i + a, 6 * i + b] = mpmath.mpf(m.inertia[i, a, b])
        contact, undone = trees.contact_system(landing)
        C = np.concatenate([trees.joint_rows(m), contact])
        K = mpmath.zeros(6 * n + len(C))
        K[: 6 * n, : 6 * n] = M
        for r, c in zip(*np.nonzero(C), strict=True):
            K[6 * n + int(r), int(c)] = K[int(c), 6 * n + int(r)] = mpmath.mpf(C[r, c])
        rhs = mpmath.zeros(6 * n + len(C), 1)
        for r, speed in enumerate(undone):
            rhs[6 * n + len(C) - len(undone) + r] = -mpmath.mpf(speed)
        solution = mpmath.lu_solve(K, rhs)
        return np.array([float(solution[i]) for i in range(6 * n)]).reshape(n, 6)


def chain_of_masses(ratio, struck):
    """Three hinged bodies whose masses span a ratio, struck at one of them."""
    m = trees.random_mechanism(np.random.default_rng(5), [0, 1], ["revolute", "revolute"], decades=0.0)
    scale = np.array([1.0, ratio**0.5, ratio])
    m = m._replace(mass=m.mass * scale, inertia=m.inertia * scale[:, None, None])
    return Landing(m, (Hit(struck, m.com[struck] + [0.1, 0.2, -0.3], STICKS),), np.array([0.3, 0.1, -1.0]))


@pytest.mark.parametrize("struck", [0, 2])
@pytest.mark.parametrize("root", [0, 2])
@pytest.mark.parametrize("ratio", [1e4, 1e8, 1e10])
def test_refined_it_keeps_its_digits_at_any_ratio_of_masses(ratio, root, struck):
    """Bodies ten thousand million times as heavy as their neighbours cost it nothing, wherever the tree is rooted and struck."""
    landing = chain_of_masses(ratio, struck)
    exact = exact_jump(landing)
    _, refined, spread, _ = solved(landing, root=root)
    assert relative(landing.mechanism, refined, exact) < 1e-12
    # What rounding in the data may do is no less than the error, and does not cry wolf.
    told = float((trees.motion(landing.mechanism, spread) / trees.motion(landing.mechanism, exact)).max())
    assert relative(landing.mechanism, refined, exact) <= told + 1e-13
    assert told < 1e-11


@pytest.mark.parametrize("struck", [0, 2])
@pytest.mark.parametrize("root", [0, 2])
@pytest.mark.parametrize("ratio", [1.0, 1e4, 1e8, 1e12])
def test_the_profile_is_as_good_as_it_says(ratio, root, struck):
    """Whatever joint space lost, the reported numbers are good to the reported estimate: the better of the two was taken."""
    landing = chain_of_masses(ratio, struck)
    profile = solved(landing, root=root)[-1]
    error = relative(landing.mechanism, trees.twists(profile), exact_jump(landing))
    # The estimate is a difference, or three samples, of what is bounded here; places in the file are rounded once more.
    assert error <= 10.0 * profile.health.error_estimate + 1e-12
    assert error < 1e-9


def test_joint_space_at_the_wrong_end_is_replaced_with_a_warning():
    """Rooted at the light end of a 1e10 chain and struck at the heavy one, joint space keeps few digits."""
    landing = chain_of_masses(1e10, 2)
    wrong, right = (solved(landing, root=root)[-1].health for root in (0, 2))
    assert wrong.method == "maximal coordinates, refined, the steadier of two solutions"
    assert wrong.warnings[0].startswith("two independent solutions part by ")
    assert wrong.error_estimate < 1e-11
    assert right.method == "joint space (Eq. 4), checked in maximal coordinates"
    assert right.warnings == ()


@pytest.mark.parametrize("bodies", [10, 30, 50])
def test_a_long_chain_is_right_to_its_last_body(bodies):
    """A chain of fifty passes on a millionth of a millionth of the strike, and that too is known to its estimate."""
    rng = np.random.default_rng(1)
    chain = trees.random_mechanism(rng, list(range(bodies - 1)), ["revolute"] * (bodies - 1), planar=True, decades=0.0)
    landing = Landing(chain, (Hit(0, chain.com[0] + [0.1, 0.0, -0.3], STICKS),), np.array([0.3, 0.0, -1.0]))
    profile = trees.land(landing)
    other = trees.land(landing, root=bodies - 1, seed=1)
    size = trees.motion(chain, trees.twists(profile))
    told = 10.0 * (
        trees.in_order(profile, np.array(profile.health.body_errors)) + trees.in_order(other, np.array(other.health.body_errors))
    )
    moves = size > 1e-13 * size.max()
    apart = trees.motion(chain, trees.twists(other) - trees.twists(profile)) / size
    assert np.all(apart[moves] <= told[moves] + 1e-9)
    # A body known to many digits is not called a translation because a far one is known to few.
    turning = trees.in_order(profile, np.abs(profile.delta_omega @ np.ones(3)))
    assert moves.sum() >= 10
    assert not trees.in_order(profile, profile.translates)[(size > 1e-6) & (turning > 1e-6)].any()


def test_armature_is_energy_of_the_joint_rate():
    """Reflected inertia as large as the world holds the joint still: two bodies become one, and without it they are two."""
    m = trees.random_mechanism(np.random.default_rng(2), [0], ["revolute"], decades=0.0)
    landing = Landing(m, (Hit(1, m.com[1] + [0.1, 0.0, -0.3], STICKS),), np.array([0.0, 0.0, -1.0]))
    profile = trees.land(landing)
    bodies = tree(profile.robot, dynamics(profile.robot, profile.q[None]), np.zeros(7), None)
    rows, undone = trees.contact_system(landing)
    rows = rows.reshape(3, 2, 6)
    geared = bodies._replace(armature=bodies.armature + np.array([0.0] * 6 + [1e9]))
    locked = bodies._replace(G=np.eye(7)[:, :6])
    found, still, free = (solve_maximal(one, rows, undone[:, None]).twists[..., 0] for one in (geared, locked, bodies))
    np.testing.assert_allclose(found, still, atol=1e-7)  # 1 / 1e9 of the bodies' own inertia remains
    np.testing.assert_allclose(still[0, :3], still[1, :3], atol=1e-12)
    assert np.abs(free[0, :3] - free[1, :3]).max() > 0.01
