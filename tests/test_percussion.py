"""From a body's jump to its centre and radius of percussion, on arrays alone, in doubles and in
balls.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from shockpc.core.percussion import off_plane_share, shock_at, translation
from shockpc.core.spatial import plane_from, velocity_at
from shockpc.method.exact.balls import BALLS
from shockpc.quantities.of_bodies import percussion

pytestmark = pytest.mark.smoke

VECTORS = arrays(float, 3, elements=st.floats(-10.0, 10.0, allow_subnormal=False))
NORMALS = VECTORS.filter(lambda n: np.linalg.norm(n) > 0.1).map(lambda n: n / np.linalg.norm(n))
SAGITTAL = np.array([0.0, -1.0, 0.0])


def reduced(omega, v, normal=SAGITTAL, v_in=1.0):
    """Centre, radius and pitch of a body that rotates in the plane."""
    return percussion(omega, v, normal, v_in, False, False)


@given(NORMALS, st.floats(0.01, 10.0), VECTORS, VECTORS, st.floats(0.1, 10.0))
def test_shock_is_zero_at_the_centre_and_grows_with_distance(normal, turn, v, r, v_in):
    """In the plane Δv + Δω × p = 0, and the shock at r is |r − p| / r_p (Eqs. 2, 11, 12)."""
    omega = turn * normal
    v, r = v - normal * (normal @ v), r - normal * (normal @ r)
    found = reduced(omega, v, normal, v_in)
    np.testing.assert_allclose(velocity_at(omega, v, found.copc), 0.0, atol=1e-12)
    assert found.copc @ normal == pytest.approx(0.0, abs=1e-11)  # |v| / turn reaches 1e3
    assert found.ropc == pytest.approx(v_in / turn, rel=1e-12)
    assert shock_at(omega, v, r, v_in) == pytest.approx(
        np.linalg.norm(r - found.copc) / found.ropc, rel=1e-9, abs=1e-12
    )


def test_a_positive_rotation_about_the_sagittal_normal_moves_the_forward_end_up():
    """In x–z the normal is −y. Eq. 11 in the plane's axes: (p₁, p₂) = (−v₂, v₁) / ω_n."""
    omega = 2.0 * SAGITTAL
    np.testing.assert_allclose(
        velocity_at(omega, np.zeros(3), np.array([1.0, 0.0, 0.0])), [0.0, 0.0, 2.0], atol=0
    )
    np.testing.assert_allclose(
        reduced(omega, np.array([0.3, 0.0, -0.8])).copc, [0.4, 0.0, 0.15], rtol=1e-15
    )


@given(VECTORS.filter(lambda w: np.linalg.norm(w) > 0.1), VECTORS)
def test_pitch_is_that_of_the_screw(omega, v):
    """At the point ω × v / ω² of the axis the velocity is pitch times ω: no point is slower than
    |ω·v| / |ω|.
    """
    pitch = (
        float(reduced(omega, v).pitch)
        if omega[1]
        else float(percussion(omega, v, SAGITTAL, 1.0, True, False).pitch)
    )
    nearest = np.cross(omega, v) / (omega @ omega)
    np.testing.assert_allclose(velocity_at(omega, v, nearest), pitch * omega, atol=1e-9)
    least = float(shock_at(omega, v, nearest, 1.0))
    assert least == pytest.approx(abs(omega @ v) / np.linalg.norm(omega), abs=1e-9)
    assert np.all(
        shock_at(omega, v, np.random.default_rng(0).normal(0.0, 3.0, (20, 3)), 1.0) >= least - 1e-9
    )


@pytest.mark.parametrize(("share", "translates"), [(0.5, True), (2.0, False)])
@pytest.mark.parametrize("tolerance", [1e-12, 1e-6])
@pytest.mark.parametrize("v_in", [1e-6, 1.0, 1e6])
def test_a_rotation_within_rounding_is_a_translation(share, translates, tolerance, v_in):
    """What moves no point of the robot by more than rounding is no rotation, at every speed."""
    omega = share * tolerance * v_in / 0.7 * SAGITTAL
    in_plane, still = translation(omega, np.array([0.0, 0.0, v_in]), SAGITTAL, v_in, 0.7, tolerance)
    assert in_plane == still == translates


def test_a_rotation_out_of_the_plane_is_a_translation_in_it():
    """Its screw has a pitch all the same."""
    omega, v = np.array([0.0, 0.0, 2.0]), np.array([0.0, 1.0, 1.0])
    in_plane, still = translation(omega, v, SAGITTAL, 1.0, 1.0, 1e-9)
    assert in_plane
    assert not still
    assert percussion(omega, v, SAGITTAL, 1.0, in_plane, still).pitch == pytest.approx(
        0.5, rel=1e-15
    )


@pytest.mark.parametrize("v", [(0.0, 0.0, 1.0), (0.0, 0.0, 0.0)])
def test_no_rotation_is_a_translation_without_division_by_zero(v):
    """Neither a body that translates nor one at rest gives a warning on the way."""
    nothing = np.zeros((1, 3))
    found = translation(nothing, np.array([v]), SAGITTAL[None], 1.0, 1.0, 1e-9)
    assert [part.tolist() for part in found] == [[True], [True]]
    percussion(nothing, np.array([v]), SAGITTAL[None], 1.0, *found)
    np.testing.assert_array_equal(shock_at(np.zeros(3), np.array(v), np.eye(3), 2.0), 0.5 * v[2])


@given(NORMALS, VECTORS, VECTORS, st.floats(0.01, 1.0))
def test_off_plane_share_lies_between_none_and_all(normal, omega, v, gyration):
    """0 for a jump in the plane, 1 for one across it; a part that vanishes has no share of their
    own size.
    """
    g, plane, nothing = np.float64(gyration), plane_from(normal), np.zeros(3)
    assert 0.0 <= float(off_plane_share(omega, v, normal, g)) <= 1.0 + 1e-12
    assert off_plane_share(normal * 2.0, v - normal * (normal @ v), normal, g) == pytest.approx(
        0.0, abs=1e-12
    )
    assert off_plane_share(plane.e1, normal, normal, g) == pytest.approx(1.0, rel=1e-12)
    assert off_plane_share(nothing, normal, normal, g) == pytest.approx(1.0, rel=1e-12)
    assert off_plane_share(nothing, nothing, normal, g) == 0.0
    # Of a body at rest rounding is left, of any direction.
    assert off_plane_share(nothing, 1e-17 * normal, normal, g, 1e-12) == 0.0
    # A rotation that is rounding beside the translation does not count as an off-plane jump of its
    # own.
    assert off_plane_share(1e-14 * plane.e1, plane.e2, normal, g) < 1e-13


@given(st.integers(1, 4), st.integers(1, 4))
def test_many_bodies_are_each_body_alone_and_balls_enclose_doubles(n, k):
    rng = np.random.default_rng(n * 10 + k)
    omega, v, r = rng.normal(size=(3, n, k, 3))
    no = np.zeros((n, k), dtype=bool)
    together = percussion(omega, v, SAGITTAL, 1.0, no, no)
    enclosed = percussion(
        BALLS.numbers(omega), BALLS.numbers(v), BALLS.numbers(SAGITTAL), 1.0, no, no
    )
    shares = off_plane_share(
        BALLS.numbers(omega),
        BALLS.numbers(v),
        BALLS.numbers(SAGITTAL),
        BALLS.numbers(np.full((n, k), 0.3)),
    )
    for i in np.ndindex(n, k):
        for whole, single, ball in zip(together, reduced(omega[i], v[i]), enclosed, strict=True):
            np.testing.assert_array_equal(whole[i], single)
            np.testing.assert_allclose(np.asarray(ball[i]).astype(float), single, rtol=1e-12)
        assert shock_at(omega, v, r, 1.0)[i] == shock_at(omega[i], v[i], r[i], 1.0)
        assert float(shares[i]) == pytest.approx(
            float(off_plane_share(omega[i], v[i], SAGITTAL, np.float64(0.3))), rel=1e-12
        )
