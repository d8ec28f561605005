"""Least and greatest shock over rounded convex hulls, compared with dense sampling and a general-purpose minimiser."""

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize

from shockpc.core.extremes import Pieces, shock_extremes
from shockpc.core.percussion import shock_at

SEEDS = st.integers(0, 2**32 - 1)


def one_piece(omega, v, points, radius, v_in):
    """Extremes over a body of one piece."""
    least, greatest = shock_extremes(omega[None], v[None], Pieces.of([[(points, radius)]]), v_in)
    return float(least[0]), float(greatest[0])


def least_over_hull(omega, v, points):
    """Least |v + ω × r| over the hull of the points, by minimising over the weights of a convex combination."""
    values = v + np.cross(omega, points)

    def squared(weights):
        at = weights @ values
        return at @ at, 2.0 * values @ at

    k = len(points)
    start = np.full(k, 1.0 / k)
    found = minimize(
        squared, start, jac=True, bounds=[(0.0, 1.0)] * k, method="SLSQP", options={"ftol": 1e-15, "maxiter": 500},
        constraints={"type": "eq", "fun": lambda w: w.sum() - 1.0, "jac": lambda w: np.ones(k)},
    )  # fmt: skip
    return float(np.sqrt(found.fun))


def draw(seed, k, centre=2.0):
    rng = np.random.default_rng(seed)
    omega, v = rng.normal(size=(2, 3))
    return rng, omega, v, rng.normal(0.0, centre, 3) + rng.normal(size=(k, 3))


@given(SEEDS, st.integers(1, 12))
def test_extremes_of_a_hull_match_a_minimiser(seed, k):
    """The greatest shock is that of a corner, the least that of the nearest convex combination of corners."""
    _, omega, v, points = draw(seed, k)
    least, greatest = one_piece(omega, v, points, 0.0, 2.0)
    assert greatest == pytest.approx(shock_at(omega, v, points, 2.0).max(), rel=1e-12)
    assert least == pytest.approx(least_over_hull(omega, v, points) / 2.0, abs=1e-5)  # the minimiser's own accuracy


@given(SEEDS, st.integers(2, 8), st.floats(0.0, 1.0))
def test_no_point_of_a_rounded_hull_is_outside_the_extremes(seed, k, radius):
    """The shock at every point of the piece lies between the least and the greatest."""
    rng, omega, v, points = draw(seed, k)
    least, greatest = one_piece(omega, v, points, radius, 1.0)
    weights = np.concatenate([rng.dirichlet(np.full(k, 0.3), 400), np.eye(k)])
    inside = rng.normal(size=(len(weights), 3))
    inside /= np.linalg.norm(inside, axis=1, keepdims=True)
    sampled = shock_at(omega, v, weights @ points + radius * inside * rng.uniform(0.0, 1.0, (len(weights), 1)), 1.0)
    assert sampled.min() >= least - 1e-12
    assert sampled.max() <= greatest + 1e-12


@given(SEEDS, st.floats(0.01, 2.0))
def test_extremes_of_a_sphere_are_those_of_its_screw(seed, radius):
    """Over a sphere the distance from the screw axis runs from d − R (or 0) to d + R."""
    _, omega, v, centre = draw(seed, 1)
    spin = np.linalg.norm(omega)
    axis = omega / spin
    along = axis @ v
    foot = np.cross(omega, v) / spin**2
    d = np.linalg.norm(np.cross(axis, centre[0] - foot))
    expected = [np.hypot(along, spin * reach) for reach in (max(0.0, d - radius), d + radius)]
    np.testing.assert_allclose(one_piece(omega, v, centre, radius, 1.0), expected, rtol=1e-10, atol=1e-12)


@pytest.mark.parametrize(
    ("points", "least"),
    [
        ([[1.0, 0.0, 0.0]], 1.0),
        ([[0.0, 0.0, 0.0]], 0.0),
        ([[1.0, 1.0, 0.0], [1.0, -1.0, 5.0]], 1.0),
        ([[-1.0, 0.0, 0.0], [2.0, 0.0, 0.0]], 0.0),
        ([[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, -1.0, 0.0]], 0.0),
        ([[1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [1.0, 0.0, 3.0]], 1.0),
        ([[1.0, 0.0, 0.0], [3.0, 1.0, 0.0], [3.0, -1.0, 0.0], [2.0, 0.0, 0.0]], 1.0),
        ([[1.0, 1e-17, 0.0], [-1.0, 1e-17, 0.0], [0.0, 1.0, 0.0]], 0.0),
    ],
)
def test_degenerate_pieces(points, least):
    """A point, a segment through the axis or parallel to it, a triangle with a corner on the axis; Δω is 1 rad/s about z."""
    found = one_piece(np.array([0.0, 0.0, 1.0]), np.zeros(3), np.array(points), 0.0, 1.0)
    assert found[0] == pytest.approx(least, abs=1e-15)
    assert found[1] == pytest.approx(np.linalg.norm(np.array(points)[:, :2], axis=1).max(), rel=1e-15)


@pytest.mark.parametrize("spin", [0.0, 1e-300, 1e-17])
def test_a_translation_is_uniform(spin):
    """Without rotation, or with a negligible one, shock is |Δv| / v_in everywhere."""
    found = one_piece(np.array([0.0, spin, 0.0]), np.array([3.0, 0.0, 4.0]), np.eye(3), 0.5, 2.0)
    np.testing.assert_allclose(found, (2.5, 2.5), rtol=1e-15)


@given(SEEDS, st.floats(1e-6, 1e6))
def test_extremes_scale_with_the_jump_and_not_with_the_speed(seed, speed):
    """Scaling jump and strike by the same factor leaves the normalised shock unchanged."""
    _, omega, v, points = draw(seed, 6)
    np.testing.assert_allclose(
        one_piece(speed * omega, speed * v, points, 0.2, speed), one_piece(omega, v, points, 0.2, 1.0), rtol=1e-9, atol=1e-12
    )


@pytest.mark.parametrize("flaw", ["omega", "v", "points"])
def test_nan_in_gives_nan_out(flaw):
    """NaN in any input gives NaN, and the search ends."""
    given_ = {"omega": np.ones(3), "v": np.ones(3), "points": np.eye(3) + 5.0}
    given_[flaw] = given_[flaw] * np.nan
    assert np.isnan(one_piece(given_["omega"], given_["v"], given_["points"], 0.0, 1.0)).any()


@given(SEEDS)
def test_all_bodies_at_once_equal_the_bodies_one_by_one(seed):
    """The extremes of a body are those over its pieces, whatever the other bodies are; NaN for one without pieces."""
    rng = np.random.default_rng(seed)
    counts = [2, 0, 1, 4]
    bodies = [
        [(rng.normal(rng.normal(0.0, 1.0, 3), 1.0, (int(rng.integers(1, 9)), 3)), float(rng.choice((0.0, 0.2)))) for _ in range(n)]
        for n in counts
    ]
    omega, v = rng.normal(size=(2, 4, 3))
    omega[2] *= rng.integers(2)
    least, greatest = shock_extremes(omega, v, Pieces.of(bodies), 0.7)
    for i, own in enumerate(bodies):
        alone = [one_piece(omega[i], v[i], points, radius, 0.7) for points, radius in own]
        assert least[i] == pytest.approx(min((low for low, _ in alone), default=np.nan), rel=1e-14, nan_ok=True)
        assert greatest[i] == pytest.approx(max((high for _, high in alone), default=np.nan), rel=1e-14, nan_ok=True)


def test_extremes_are_right_to_1e_15_of_the_terms_they_are_made_of():
    rng = np.random.default_rng(0)
    for k in range(400):
        omega, v = rng.normal(size=3) * 10 ** rng.uniform(-3, 3), rng.normal(size=3)
        screw = np.cross(omega, v) / (omega @ omega) + rng.normal() * omega / np.linalg.norm(omega)
        points = screw * (k % 2) + rng.normal(size=(2, 3)) * 10 ** rng.uniform(-6, 2)
        found = one_piece(omega, v, points, 0.0, 1.0)
        with mpmath.workdps(50):
            (p, q, r), (a, b) = mpmath.matrix(omega), (mpmath.matrix(point) for point in points)
            a, b = (mpmath.matrix(v) + mpmath.matrix([q * z - r * y, r * x - p * z, p * y - q * x]) for x, y, z in (a, b))
            along = min(1, max(0, -mpmath.fdot(b - a, a) / mpmath.fdot(b - a, b - a)))
            exact = [mpmath.norm(a + along * (b - a)), max(mpmath.norm(a), mpmath.norm(b))]
            size = np.linalg.norm(v) + np.linalg.norm(omega) * np.linalg.norm(points, axis=1).max()
            assert max(abs(x - y) for x, y in zip(exact, found, strict=True)) <= 1e-15 * size
