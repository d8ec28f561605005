"""Impact with friction: the law itself, all solutions of one contact, the known cases, and several
contacts at once.
"""

import numpy as np
import pytest

from shockpc.core.coulomb import solve_each, solve_friction

SEEDS = range(8)


def one(A, velocity, mu, e=0.0):
    """Solutions of one contact."""
    return solve_friction(
        np.asarray(A, dtype=float), np.array([velocity]), np.array([mu]), np.array([e])
    )


def random_contacts(seed, m, n=12):
    """Delassus matrix, velocities that approach, friction and restitution."""
    rng = np.random.default_rng(seed)
    X, velocity = rng.normal(size=(3 * m, n)), rng.normal(size=(m, 3))
    velocity[:, 2] = -np.abs(velocity[:, 2])
    return X @ X.T, velocity, 10.0 ** rng.uniform(-1.5, 0.5, m), rng.uniform(0.0, 0.8, m)


def assert_obeys_the_laws(solution, A, velocity, mu, e):
    """Newton along the normal, Coulomb along the tangents, momentum, and the energy that it says."""
    impulse, after = solution.impulse, solution.velocity
    np.testing.assert_allclose(after, velocity + (A @ impulse.ravel()).reshape(-1, 3), atol=1e-12)
    rebound = after[:, 2] - e * np.maximum(-velocity[:, 2], 0.0)
    assert np.all(rebound >= -1e-9)
    assert np.all(impulse[:, 2] >= 0.0)
    np.testing.assert_allclose(rebound * impulse[:, 2], 0.0, atol=1e-9)
    limit, slip = mu * impulse[:, 2], np.linalg.norm(after[:, :2], axis=1)
    assert np.all(np.linalg.norm(impulse[:, :2], axis=1) <= limit + 1e-9)
    np.testing.assert_allclose(
        slip[:, None] * impulse[:, :2], -limit[:, None] * after[:, :2], atol=1e-8
    )
    pseudo = np.linalg.pinv(A, rcond=1e-10)
    energies = [v.ravel() @ pseudo @ v.ravel() / 2.0 for v in (velocity, after)]
    assert solution.energy == pytest.approx(energies[1] - energies[0], abs=1e-7)
    assert solution.gains_energy == (solution.energy > 1e-9)
    for state, p, s in zip(solution.state, impulse, slip, strict=True):
        assert state == ("separates" if p[2] == 0.0 else "slides" if s > 1e-7 else "sticks")


# One contact


@pytest.mark.parametrize("seed", range(40))
def test_all_solutions_of_one_contact_obey_the_laws(seed):
    """And there are as many as a fine search over the directions of slip finds."""
    A, velocity, mu, e = random_contacts(seed, 1, n=3 + seed % 3)
    solutions = solve_friction(A, velocity, mu, e)
    for solution in solutions:
        assert_obeys_the_laws(solution, A, velocity, mu, e)
    q = -(1.0 + e[0]) * velocity[0, 2]
    stick = np.linalg.solve(A, [-velocity[0, 0], -velocity[0, 1], q])
    sticks = stick[2] > 0.0 and np.hypot(*stick[:2]) <= mu[0] * stick[2]
    angle = np.linspace(0.0, 2.0 * np.pi, 400001)
    d = np.stack([np.cos(angle), np.sin(angle)])
    with np.errstate(divide="ignore", invalid="ignore"):
        normal = q / (A[2, 2] - mu[0] * A[2, :2] @ d)
        slip = velocity[0, :2, None] + normal * (A[:2, 2, None] - mu[0] * A[:2, :2] @ d)
    across = d[0] * slip[1] - d[1] * slip[0]
    crossing = (
        (across[:-1] * across[1:] <= 0.0)
        & (np.sum(d * slip, axis=0)[:-1] > 0.0)
        & (normal[:-1] > 0.0)
        & (normal[1:] > 0.0)
    )
    assert len(solutions) == sticks + np.count_nonzero(crossing)
    assert len(solutions) >= 1


def test_a_contact_that_needs_less_friction_sticks():
    """At the friction needed ‖λ_t‖/λ_n sticking turns into sliding, without a jump of the impulse."""
    A, velocity, _, e = random_contacts(3, 1)
    stick = np.linalg.solve(A, -velocity[0] * [1.0, 1.0, 1.0 + e[0]])
    needed = np.hypot(*stick[:2]) / stick[2]
    assert needed > 0.0
    (more,), (less,) = (
        solve_friction(A, velocity, np.array([needed * factor]), e)
        for factor in (1.0 + 1e-6, 1.0 - 1e-6)
    )
    assert (more.state, less.state) == (("sticks",), ("slides",))
    np.testing.assert_allclose(more.impulse[0], stick, atol=1e-12)
    np.testing.assert_allclose(less.impulse, more.impulse, atol=1e-4)


def test_many_landings_are_each_alone():
    """With any friction, and with a little more or less than sticking needs; of several solutions
    one that gains no energy.
    """
    cases = [
        tuple(
            part[0] if k else part for k, part in enumerate(random_contacts(seed, 1, 3 + seed % 3))
        )
        for seed in range(60)
    ]
    for A, velocity, _, e in cases[:20]:
        stick = np.linalg.solve(A, -velocity * [1.0, 1.0, 1.0 + e])
        cases += [
            (A, velocity, np.hypot(*stick[:2]) / stick[2] * factor, e)
            for factor in (0.999, 1.001)
            if stick[2] > 0.0
        ]
    for (A, velocity, mu, e), found in zip(
        cases, solve_each(*map(np.array, zip(*cases, strict=True))), strict=True
    ):
        alone = [solution for solution in one(A, velocity, mu, e) if not solution.gains_energy]
        alone.sort(key=lambda solution: solution.state != ("sticks",))
        expected = [solution.impulse[0] for solution in alone] or [np.full(3, np.nan)]
        assert any(
            np.allclose(found, impulse, rtol=1e-9, atol=1e-12, equal_nan=True)
            for impulse in expected
        )
        assert (
            not alone or alone[0].state != ("sticks",) or np.allclose(found, expected[0], rtol=1e-9)
        )


def test_without_friction_the_impulse_is_normal():
    A, velocity, _, e = random_contacts(1, 1)
    (solution,) = solve_friction(A, velocity, np.zeros(1), e)
    np.testing.assert_allclose(
        solution.impulse[0], [0.0, 0.0, -(1.0 + e[0]) * velocity[0, 2] / A[2, 2]], atol=1e-15
    )


def test_a_planar_mechanism_has_a_tangent_that_cannot_move():
    A = np.array([[2.0, 0.0, 0.5], [0.0, 0.0, 0.0], [0.5, 0.0, 1.0]])
    (stick,), (slide,) = one(A, [0.1, 0.0, -1.0], 5.0), one(A, [2.0, 0.0, -1.0], 0.2)
    assert (stick.state, slide.state) == (("sticks",), ("slides",))
    np.testing.assert_allclose(slide.impulse[0], [-0.2 / 0.9, 0.0, 1.0 / 0.9], atol=1e-15)


def rod(tangent, direction=1.0):
    """A uniform rod of mass 1 that slides on its end at the angle θ to the ground, tan θ given."""
    c = 1.0 / np.hypot(1.0, tangent)
    s = tangent * c
    return np.array(
        [
            [1.0 + 3.0 * s * s, 0.0, direction * 3.0 * s * c],
            [0.0, 1.0, 0.0],
            [direction * 3.0 * s * c, 0.0, 1.0 + 3.0 * c * c],
        ]
    )


@pytest.mark.parametrize(
    ("tangent", "critical"), [(2.0, 4.0 / 3.0), (1.0, 5.0 / 3.0), (4.0, 5.0 / 3.0)]
)
def test_painleve_rod_jams_above_the_critical_friction(tangent, critical):
    """µ = (4 + tan²θ)/(3 tan θ), smallest 4/3 at tan θ = 2 (Génot and Brogliato 1999; Hogan and
    Kristiansen 2017).

    Below it the rod slides on if it is fast; above, it stops at every speed. An undisturbed slide
    (v_n = 0) is a solution too, and above the critical friction so is jamming, an impact without
    collision.
    """
    for speed in (1.0, 1e3, 1e6):
        (solution,) = one(rod(tangent), [speed, 0.0, -1.0], critical + 1e-3)
        assert solution.state == ("sticks",)
    (solution,) = one(rod(tangent), [1e6, 0.0, -1.0], critical - 1e-3)
    assert solution.state == ("slides",)
    assert solution.velocity[0, 0] > 0.0
    (solution,) = one(rod(tangent, -1.0), [1e6, 0.0, -1.0], critical + 1e-3)
    assert solution.state == ("slides",)
    states = [
        [solution.state[0] for solution in one(rod(tangent), [1.0, 0.0, 0.0], critical + d)]
        for d in (-1e-3, 1e-3)
    ]
    assert states == [["separates"], ["separates", "sticks"]]


def double_pendulum():
    """Delassus matrix, velocity and energy of two equal rods, at 20° and 30° from the vertical,
    whose end hits the ground.
    """
    (first, second), rates = np.radians([20.0, 30.0]), np.array([-0.1, -0.2])
    H = np.array(
        [[4.0 / 3.0, np.cos(first - second) / 2.0], [np.cos(first - second) / 2.0, 1.0 / 3.0]]
    )
    J = np.array([[np.cos(first), np.cos(second)], [0.0, 0.0], [np.sin(first), np.sin(second)]])
    return J @ np.linalg.solve(H, J.T), J @ rates, rates @ H @ rates / 2.0


def test_kane_double_pendulum_gains_energy_and_reverses_slip():
    """Newton's restitution and friction can gain energy where slip reverses (Kane and Levinson
    1985): such a solution says so.
    """
    A, velocity, before = double_pendulum()
    (solution,) = one(A, velocity, 0.5, 0.7)
    assert solution.state == ("slides",)
    assert velocity[0] < 0.0 < solution.velocity[0, 0]
    assert solution.gains_energy
    assert solution.energy > before
    for mu, e in ((0.5, 0.0), (0.0, 0.7), (0.25, 0.5)):
        (solution,) = one(A, velocity, mu, e)
        assert not solution.gains_energy


def routh(A, velocity, mu):
    """What the slip does in a plane without restitution when friction acts against the slip of each
    instant, and the impulse.
    """
    B, v = A[np.ix_([0, 2], [0, 2])], velocity[[0, 2]]
    path = np.array([-mu * np.sign(v[0]), 1.0])
    rate = B @ path
    stops = -v[0] / rate[0] if rate[0] * v[0] < 0.0 else np.inf
    if 0.0 < -v[1] / rate[1] <= stops:
        return "slides on", -v[1] / rate[1] * path
    needed, slide = -B[0, 1] / B[0, 0], stops * path
    path = np.array([np.clip(needed, -mu, mu), 1.0])
    return "sticks" if abs(needed) <= mu else "reverses", slide - (v + stops * rate)[1] / (
        B @ path
    )[1] * path


def test_slip_that_stops_or_reverses_during_the_impact():
    """Routh's method in closed form (Wang and Mason 1992): the same where slip goes on or stops.

    Where it reverses, the final slip has the same direction or none, is slower, and more energy is
    lost.
    """
    rng, kinds = np.random.default_rng(0), []
    for _ in range(300):
        X, mu = rng.normal(size=(3, 4)), rng.uniform()
        X[1] = 0.0
        A, velocity = X @ X.T, np.array([rng.normal(), 0.0, -abs(rng.normal())])
        (solution,) = one(A, velocity, mu)
        kind, impulse = routh(A, velocity, mu)
        kinds.append(kind)
        followed = np.array([impulse[0], 0.0, impulse[1]])
        if kind != "reverses":
            np.testing.assert_allclose(solution.impulse[0], followed, atol=1e-9 * impulse[1])
            continue
        after, ours = (velocity + A @ followed)[0], solution.velocity[0, 0]
        assert solution.state == ("sticks",) or ours * after > 0.0
        assert abs(ours) < abs(after)
        assert velocity[0] * after < 0.0
        assert solution.energy < followed @ (velocity + A @ followed / 2.0) < 0.0
        assert solution.impulse[0, 2] > impulse[1]
    assert min(kinds.count(kind) for kind in ("slides on", "sticks", "reverses")) >= 10


@pytest.mark.parametrize("seed", range(30))
def test_without_restitution_no_energy_is_gained(seed):
    A, velocity, mu, _ = random_contacts(seed, 1, n=3)
    assert (
        max(solution.energy for solution in solve_friction(A, velocity, mu, np.zeros(1))) <= 1e-12
    )


# Several contacts


@pytest.mark.parametrize("m", [2, 4])
@pytest.mark.parametrize("seed", SEEDS)
def test_several_contacts_obey_the_laws_along_every_axes(seed, m):
    """And tangents rotated about the normals give the same impact."""
    A, velocity, mu, e = random_contacts(seed, m, n=14)
    solutions = solve_friction(A, velocity, mu, e)
    assert len(solutions) >= 1
    for solution in solutions:
        assert_obeys_the_laws(solution, A, velocity, mu, e)
    R = np.eye(3 * m)
    for i, angle in enumerate(np.random.default_rng(seed).uniform(0.0, 6.0, m)):
        R[3 * i : 3 * i + 2, 3 * i : 3 * i + 2] = [
            [np.cos(angle), np.sin(angle)],
            [-np.sin(angle), np.cos(angle)],
        ]
    rotated = solve_friction(R @ A @ R.T, (R @ velocity.ravel()).reshape(m, 3), mu, e)
    assert len(rotated) == len(solutions) == 1
    np.testing.assert_allclose(
        R @ solutions[0].velocity.ravel(), rotated[0].velocity.ravel(), atol=1e-8
    )


def box(height):
    """The Delassus matrix of a box of mass 1 on its four corners, 2 m apart, with the centre of
    mass at a height.
    """
    corners = np.array([[x, y, -height] for x in (-1.0, 1.0) for y in (-1.0, 1.0)])
    J = np.concatenate([np.hstack([np.cross(r, np.eye(3)), np.eye(3)]) for r in corners])
    return J @ np.diag([2.0, 2.0, 2.0, 1.0, 1.0, 1.0]) @ J.T


def test_a_box_slides_on_four_corners_or_sticks():
    """Its corners share the impulse in many ways, the velocity is one: m Δv_n, and µ m Δv_n against
    the slip.
    """
    velocity = np.tile([3.0, 0.0, -1.0], (4, 1))
    (slides,) = solve_friction(box(0.5), velocity, np.full(4, 0.4), np.zeros(4))
    np.testing.assert_allclose(slides.velocity, np.tile([2.6, 0.0, 0.0], (4, 1)), atol=1e-9)
    np.testing.assert_allclose(slides.impulse.sum(axis=0), [-0.4, 0.0, 1.0], atol=1e-9)
    assert set(slides.state) == {"slides"}
    (sticks,) = solve_friction(box(0.1), velocity, np.full(4, 4.0), np.zeros(4))
    np.testing.assert_allclose(sticks.velocity, 0.0, atol=1e-9)


def test_a_contact_that_the_ground_would_have_to_pull_opens():
    """A tall box with much friction tips over its front corners: the rear ones separate."""
    (tips,) = solve_friction(
        box(3.0), np.tile([3.0, 0.0, -1.0], (4, 1)), np.full(4, 5.0), np.zeros(4)
    )
    assert tips.state == ("separates", "separates", "sticks", "sticks")
    assert np.all(tips.velocity[:2, 2] > 0.1)
    assert tips.energy < 0.0


@pytest.mark.parametrize(
    ("mu", "e", "speed"),
    [(-0.1, 0.0, 1.0), (0.5, 1.1, 1.0), (0.5, -0.1, 1.0), (np.nan, 0.0, 1.0), (0.5, 0.0, np.inf)],
)
def test_what_has_no_meaning_is_refused(mu, e, speed):
    with pytest.raises(ValueError, match="friction"):
        one(np.eye(3), [speed, 0.0, -1.0], mu, e)


def test_a_residual_of_rounding_is_a_solution():
    """Mobilities of 1e-5 and 1e4 1/kg: the rounding of the impulses alone is above the bound of the
    residual.
    """
    A = np.array(
        [
            [10179.971761, 18.672221, 13.519989],
            [18.672221, 0.05610025, 0.03253520],
            [13.519989, 0.03253520, 0.02070861],
        ]
    )
    mu, velocity = 0.320460279780903, np.array([0.69667286, 0.5975474, -1.92595067])
    (found,) = solve_friction(A, velocity[None], np.array([mu]), np.zeros(1))
    slip = velocity + A @ found.impulse[0]
    assert found.state == ("slides",)
    assert slip[2] == pytest.approx(0.0, abs=1e-12)
    normal = found.impulse[0, 2]
    np.testing.assert_allclose(
        found.impulse[0, :2], -mu * normal * slip[:2] / np.linalg.norm(slip[:2]), atol=1e-9 * normal
    )
