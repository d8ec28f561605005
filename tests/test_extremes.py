"""Smallest and largest shock over convex pieces, compared with 50 digits, prisms, samples and a
general-purpose minimiser.
"""

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import null_space
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from shockpc.core.extremes import Pieces, maximum_shock, shock_extremes
from shockpc.core.percussion import shock_at

SEEDS = st.integers(0, 2**32 - 1)


def one_piece(omega, v, points, rounding, v_in):
    """Extremes over a body of one piece; a number for the rounding is the radius of a ball."""
    axes = rounding if np.ndim(rounding) else rounding * np.eye(3)
    least, greatest = shock_extremes(omega[None], v[None], Pieces.of([[(points, axes)]]), v_in)
    return float(least[0]), float(greatest[0])


def least_over_hull(omega, v, points):
    """Smallest |v + ω × r| over the hull of the points, by minimising over the weights of a convex
    combination.
    """
    values = v + np.cross(omega, points)

    def squared(weights):
        at = weights @ values
        return at @ at, 2.0 * values @ at

    k = len(points)
    start = np.full(k, 1.0 / k)
    found = minimize(
        squared,
        start,
        jac=True,
        bounds=[(0.0, 1.0)] * k,
        method="SLSQP",
        options={"ftol": 1e-15, "maxiter": 500},
        constraints={"type": "eq", "fun": lambda w: w.sum() - 1.0, "jac": lambda w: np.ones(k)},
    )
    return float(np.sqrt(found.fun))


def draw(seed, k, centre=2.0):
    rng = np.random.default_rng(seed)
    omega, v = rng.normal(size=(2, 3))
    return rng, omega, v, rng.normal(0.0, centre, 3) + rng.normal(size=(k, 3))


@given(SEEDS, st.integers(1, 12))
def test_extremes_of_a_hull_match_a_minimiser(seed, k):
    """The largest shock is that of a corner, the smallest that of the nearest convex combination of
    corners.
    """
    _, omega, v, points = draw(seed, k)
    least, greatest = one_piece(omega, v, points, 0.0, 2.0)
    assert greatest == pytest.approx(shock_at(omega, v, points, 2.0).max(), rel=1e-12)
    # the minimiser's accuracy
    assert least == pytest.approx(least_over_hull(omega, v, points) / 2.0, abs=1e-5)


def semi_axes(rng, flat):
    """Random semi-axes in columns; flat: (1, 1, 0) is a disc, (0, 0, 0) a point, None any
    ellipsoid.
    """
    lengths = (
        10 ** rng.uniform(-1.5, 0.3, 3)
        if flat is None
        else 10 ** rng.uniform(-1.0, 0.3) * np.array(flat, dtype=float)
    )
    return Rotation.random(random_state=rng.integers(2**31)).as_matrix() * lengths


@given(SEEDS, st.integers(1, 2), st.sampled_from([None, (1, 1, 1), (1, 1, 0), (1, 1e-3, 0)]))
def test_no_point_of_a_swept_ellipsoid_is_outside_the_extremes(seed, k, flat):
    """The shock at every point of the piece lies between the smallest and the largest."""
    rng, omega, v, points = draw(seed, k)
    axes = semi_axes(rng, flat)
    least, greatest = one_piece(omega, v, points, axes, 1.0)
    share, ball = rng.uniform(-0.5, 1.5, (1000, 1)).clip(0.0, 1.0), rng.normal(size=(1000, 3))
    ball /= np.maximum(np.linalg.norm(ball, axis=1), rng.choice([0.0, 3.0], 1000))[:, None]
    sampled = shock_at(
        omega, v, (1.0 - share) * points[0] + share * points[-1] + ball @ axes.T, 1.0
    )
    assert sampled.min() >= least - 1e-12
    assert sampled.max() <= greatest + 1e-12


@given(SEEDS, st.integers(0, 3))
def test_extremes_of_a_cylinder_lie_between_those_of_prisms(seed, case):
    """A prism of 512 sides inside the cylinder and one around it differ by 2e-5; in the plane of Δω
    and the axis both are a box.

    Cases: any rotation; about the axis; across it; through a point of the surface.
    """
    rng, omega, v, points = draw(seed, 2, 1.0)
    axis, radius = (
        (points[1] - points[0]) / np.linalg.norm(points[1] - points[0]),
        rng.uniform(0.1, 2.0),
    )
    sides = null_space(axis[None])
    omega = [omega, rng.normal() * axis, sides @ rng.normal(size=2), omega][case]
    if case == 3:
        v = -np.cross(omega, points[0] + radius * sides[:, 0])
    angle = 2.0 * np.pi * np.arange(512) / 512
    rim = radius * np.column_stack([np.cos(angle), np.sin(angle)]) @ sides.T
    disc = radius * np.column_stack([sides, np.zeros(3)])
    least, greatest = one_piece(omega, v, points, disc, 1.0)
    inner, outer = (
        one_piece(omega, v, (points[:, None] + scale * rim).reshape(-1, 3), 0.0, 1.0)
        for scale in (1.0, 1.0 / np.cos(np.pi / 512))
    )
    slack = 1e-14 * (np.linalg.norm(v) + np.linalg.norm(omega) * (np.linalg.norm(points) + radius))
    assert outer[0] - slack <= least <= inner[0] + slack
    assert inner[1] - slack <= greatest <= outer[1] + slack
    assert maximum_shock(omega, v, Pieces.of([[(points, disc)]])) == pytest.approx(
        greatest, rel=1e-14
    )


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
    """A point, a segment through the axis or parallel to it, a triangle with a corner on the axis;
    Δω is 1 rad/s about z.
    """
    found = one_piece(np.array([0.0, 0.0, 1.0]), np.zeros(3), np.array(points), 0.0, 1.0)
    assert found[0] == pytest.approx(least, abs=1e-15)
    assert found[1] == pytest.approx(
        np.linalg.norm(np.array(points)[:, :2], axis=1).max(), rel=1e-15
    )


@pytest.mark.parametrize("spin", [0.0, 1e-300, 1e-17])
def test_a_translation_is_uniform(spin):
    """Without rotation, or with a negligible one, shock is |Δv| / v_in everywhere."""
    found = one_piece(
        np.array([0.0, spin, 0.0]), np.array([3.0, 0.0, 4.0]), np.eye(3)[:2], 0.5, 2.0
    )
    np.testing.assert_allclose(found, (2.5, 2.5), rtol=1e-15)


@given(SEEDS, st.floats(1e-6, 1e6))
def test_extremes_scale_with_the_jump_and_not_with_the_speed(seed, speed):
    """Scaling jump and strike by the same factor leaves the normalised shock unchanged."""
    _, omega, v, points = draw(seed, 2)
    np.testing.assert_allclose(
        one_piece(speed * omega, speed * v, points, 0.2, speed),
        one_piece(omega, v, points, 0.2, 1.0),
        rtol=1e-9,
        atol=1e-12,
    )


@pytest.mark.parametrize("flaw", ["omega", "v", "points"])
def test_nan_in_gives_nan_out(flaw):
    """NaN in any input gives NaN, and the search ends."""
    given_ = {"omega": np.ones(3), "v": np.ones(3), "points": np.eye(3) + 5.0}
    given_[flaw] = given_[flaw] * np.nan
    assert np.isnan(one_piece(given_["omega"], given_["v"], given_["points"], 0.0, 1.0)).any()


@given(SEEDS)
def test_all_bodies_at_once_equal_the_bodies_one_by_one(seed):
    """The extremes of a body are those over its pieces, whatever the other bodies are; NaN for one
    without pieces.
    """
    rng = np.random.default_rng(seed)
    counts = [2, 0, 1, 4]
    hulls = [
        [rng.normal(rng.normal(size=3), 1.0, (int(rng.integers(1, 9)), 3)) for _ in range(n)]
        for n in counts
    ]
    bodies = [
        [
            (p[:2], semi_axes(rng, (1, 1, 0))) if rng.integers(2) else (p, np.zeros((3, 3)))
            for p in of_body
        ]
        for of_body in hulls
    ]
    omega, v = rng.normal(size=(2, 4, 3))
    omega[2] *= rng.integers(2)
    least, greatest = shock_extremes(omega, v, Pieces.of(bodies), 0.7)
    for i, of_body in enumerate(bodies):
        alone = [one_piece(omega[i], v[i], points, axes, 0.7) for points, axes in of_body]
        assert least[i] == pytest.approx(
            min((low for low, _ in alone), default=np.nan), rel=1e-14, nan_ok=True
        )
        assert greatest[i] == pytest.approx(
            max((high for _, high in alone), default=np.nan), rel=1e-14, nan_ok=True
        )


def test_extremes_are_right_to_1e_15_of_the_terms_they_are_made_of():
    rng = np.random.default_rng(0)
    for k in range(400):
        omega, v = rng.normal(size=3) * 10 ** rng.uniform(-3, 3), rng.normal(size=3)
        screw = np.cross(omega, v) / (omega @ omega) + rng.normal() * omega / np.linalg.norm(omega)
        points = screw * (k % 2) + rng.normal(size=(2, 3)) * 10 ** rng.uniform(-6, 2)
        found = one_piece(omega, v, points, 0.0, 1.0)
        with mpmath.workdps(50):
            (p, q, r), (a, b) = mpmath.matrix(omega), (mpmath.matrix(point) for point in points)
            a, b = (
                mpmath.matrix(v) + mpmath.matrix([q * z - r * y, r * x - p * z, p * y - q * x])
                for x, y, z in (a, b)
            )
            along = min(1, max(0, -mpmath.fdot(b - a, a) / mpmath.fdot(b - a, b - a)))
            exact = [mpmath.norm(a + along * (b - a)), max(mpmath.norm(a), mpmath.norm(b))]
            size = np.linalg.norm(v) + np.linalg.norm(omega) * np.linalg.norm(points, axis=1).max()
            assert max(abs(x - y) for x, y in zip(exact, found, strict=True)) <= 1e-15 * size


def exact_extremes(omega, v, centre, axes):
    """Smallest and largest |v + ω × (centre + axes b)|, |b| ≤ 1, with the working precision of
    mpmath.

    Of the ellipse in the plane across ω, q + s (cos φ, sin φ) in its principal axes, all stationary
    distances are compared: with t = tan(φ / 2), those of the roots of a quartic, and that at φ = π.
    """
    zero, *vectors = (mpmath.matrix(x) for x in (np.zeros(3), omega, v, centre, *axes.T))

    def cross(a, b):
        return mpmath.matrix(
            [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        )

    omega, v, centre, *axes = vectors
    centre, columns = v + cross(omega, centre), [cross(omega, axis) for axis in axes]
    length, gram = mpmath.norm(omega), zero * zero.T
    for column in columns:
        gram += column * column.T
    # ω itself belongs to the eigenvalue 0 and is moved to −1, so that the first of the ascending
    # eigenvalues is its own.
    lengths, vectors = mpmath.eigsy(gram - omega * omega.T / length**2)
    (q0, q1), (s0, s1) = (
        (mpmath.fdot(centre, vectors[:, k]) for k in (1, 2)),
        (mpmath.sqrt(max(lengths[k], 0)) for k in (1, 2)),
    )
    a, b, d = q0 * s0, q1 * s1, s1**2 - s0**2
    terms = [-b, -2 * (a + d), 0, 2 * (d - a), b]
    terms = [term / (max(map(abs, terms)) or 1) for term in terms]
    while terms and abs(terms[0]) < mpmath.mpf(10) ** -45:
        terms.pop(0)
    roots = (
        mpmath.polyroots(terms[::-1], maxsteps=500, extraprec=500, asc=True)
        if len(terms) > 1
        else []
    )
    angles = [2 * mpmath.atan(mpmath.re(root)) for root in roots] + [
        mpmath.pi * k / 2 for k in range(4)
    ]
    distances = [mpmath.hypot(q0 + s0 * mpmath.cos(x), q1 + s1 * mpmath.sin(x)) for x in angles]
    inside = s0 > 0 and (q0 / s0) ** 2 + (q1 / s1) ** 2 <= 1
    along = mpmath.fdot(omega, v) / length
    return mpmath.hypot(0 if inside else min(distances), along), mpmath.hypot(max(distances), along)


@pytest.mark.slow
@pytest.mark.parametrize(
    "flat",
    [None, (1, 1, 1), (1, 1, 0), (1, 1e-5, 1e-9)],
    ids=["ellipsoid", "sphere", "disc", "needle"],
)
@pytest.mark.parametrize("case", range(6))
def test_extremes_of_an_ellipsoid_are_right_to_1e_15(flat, case):
    """Cases: any jump, about a principal axis, and the screw axis through several points.

    They are the centre, a point of a principal axis, the centre of curvature there, where three of
    the roots are one, and a point of the surface or next to it.
    """
    rng = np.random.default_rng(case)
    for _ in range(25):
        axes, centre = semi_axes(rng, flat), rng.normal(size=3) * 10 ** rng.uniform(-2, 1)
        lengths, direction = np.linalg.norm(axes, axis=0), rng.normal(size=3)
        spin = 10 ** rng.uniform(-3, 3)
        omega = spin * (axes[:, 0] / lengths[0] if case in (1, 4) else direction)
        curvature = axes[:, 1] * (1.0 - (lengths[2] / lengths[1]) ** 2)
        near = (
            axes
            @ direction
            / np.linalg.norm(direction)
            * (1.0 + rng.choice([-1.0, 0.0, 1.0]) * 10 ** rng.uniform(-16, -2))
        )
        screw = (
            centre + [0.0, 0.0, 0.0 * near, axes[:, 1] * rng.uniform(-2, 2), curvature, near][case]
        )
        v = rng.normal(size=3) if case < 2 else -np.cross(omega, screw)
        size = np.linalg.norm(v) + np.linalg.norm(omega) * (np.linalg.norm(centre) + lengths.max())
        with mpmath.workdps(50):
            exact = exact_extremes(omega, v, centre, axes)
            found = one_piece(omega, v, centre[None], axes, 1.0)
            assert max(abs(x - y) for x, y in zip(exact, found, strict=True)) <= 1e-15 * size
        assert maximum_shock(omega, v, Pieces.of([[(centre[None], axes)]])) == pytest.approx(
            found[1], rel=1e-14
        )


def test_an_ellipsoid_is_swept_along_a_segment_only():
    with pytest.raises(ValueError, match="one point or two"):
        Pieces.of([[(np.eye(3), np.eye(3))]])
