"""Step 1 in maximal coordinates: agrees where both are exact, and keeps its digits where the joint-space inertia loses them."""

import mpmath
import numpy as np
import pytest
import trees
from hypothesis import given
from hypothesis import strategies as st
from trees import STICKS, Hit, Landing

from shockpc.core.maximal import solve_maximal
from shockpc.model.dynamics import dynamics, tree

SEEDS = st.integers(0, 2**32 - 1)


def solved(landing, **how):
    """The landing's twists at the centres of mass, by `solve_maximal`, in the mechanism's order; contacts must be independent."""
    profile = trees.land(landing, **how)
    bodies = tree(profile.robot, dynamics(profile.robot, profile.q[None]), None)
    origin = profile.q[:3]
    rows, undone = trees.contact_system(landing)
    order = [int(name.removeprefix("body")) for name in profile.bodies]
    rows = rows.reshape(len(rows), -1, 6)[:, order]
    np.testing.assert_allclose(bodies.com + origin, landing.mechanism.com[order], atol=1e-12)
    jumps = solve_maximal(bodies, rows, undone[:, None])[..., 0]
    return jumps[np.argsort(order)], profile


def relative(mechanism, found, expected):
    """Largest error of a body, relative to its own motion."""
    return float((trees.motion(mechanism, found - expected) / trees.motion(mechanism, expected)).max())


@given(trees.landings(hits=1), SEEDS)
def test_it_agrees_with_least_energy_and_with_joint_space(landing, seed):
    """Three formulations that share no matrix give one answer."""
    jumps, profile = solved(landing, seed=seed)
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
def test_it_keeps_its_digits_at_any_ratio_of_masses(ratio, root, struck):
    """Bodies a hundred million times as heavy as their neighbours cost maximal coordinates nothing, wherever the tree is rooted."""
    landing = chain_of_masses(ratio, struck)
    exact = exact_jump(landing)
    found, profile = solved(landing, root=root)
    # The contact's and the joints' places are rounded to 1e-16; light bodies between feel that a thousandfold.
    assert relative(landing.mechanism, found, exact) < 1e-11
    # What the joint-space solution lost, if anything, the profile tells: its estimate is its error, within a factor of ten.
    error = relative(landing.mechanism, trees.twists(profile), exact)
    assert error <= 10.0 * profile.health.error_estimate + 1e-11
    assert bool([w for w in profile.health.warnings if "solutions differ" in w]) is (profile.health.error_estimate > 1e-9)


def test_the_joint_space_loses_what_it_says_it_loses():
    """Rooted at the light end of a 1e10 chain and struck at the heavy one, joint space keeps few digits, and warns."""
    landing = chain_of_masses(1e10, 2)
    health = solved(landing, root=0)[1].health
    assert health.error_estimate > 1e-9
    assert len([w for w in health.warnings if "solutions differ" in w]) == 1
    assert solved(landing, root=2)[1].health.error_estimate < 1e-9


def test_armature_is_energy_of_the_joint_rate():
    """Reflected inertia as large as the world holds the joint still: two bodies become one, and without it they are two."""
    m = trees.random_mechanism(np.random.default_rng(2), [0], ["revolute"], decades=0.0)
    landing = Landing(m, (Hit(1, m.com[1] + [0.1, 0.0, -0.3], STICKS),), np.array([0.0, 0.0, -1.0]))
    profile = trees.land(landing)
    bodies = tree(profile.robot, dynamics(profile.robot, profile.q[None]), None)
    rows, undone = trees.contact_system(landing)
    rows = rows.reshape(3, 2, 6)
    geared = bodies._replace(armature=bodies.armature + np.array([0.0] * 6 + [1e9]))
    locked = bodies._replace(G=np.eye(7)[:, :6])
    found, still, free = (solve_maximal(one, rows, undone[:, None])[..., 0] for one in (geared, locked, bodies))
    np.testing.assert_allclose(found, still, atol=1e-7)  # 1 / 1e9 of the bodies' own inertia remains
    np.testing.assert_allclose(still[0, :3], still[1, :3], atol=1e-12)
    assert np.abs(free[0, :3] - free[1, :3]).max() > 0.01
