"""From a body's jump to its centre and radius of percussion, on arrays alone."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from shockpc.core.percussion import off_plane_share, percussion, shock_at
from shockpc.core.spatial import plane_from, velocity_at

VECTORS = arrays(float, 3, elements=st.floats(-10.0, 10.0, allow_subnormal=False))
NORMALS = VECTORS.filter(lambda n: np.linalg.norm(n) > 0.1).map(lambda n: n / np.linalg.norm(n))
SAGITTAL = np.array([0.0, -1.0, 0.0])
EPS = 1e-12


@given(NORMALS, st.floats(0.01, 10.0), VECTORS, VECTORS, st.floats(0.1, 10.0))
def test_the_centre_feels_nothing_and_shock_grows_with_distance(normal, turn, v, r, v_in):
    """In the plane Δv + Δω × p = 0, and the shock at r is |r − p| / r_p (Eqs. 2, 11, 12)."""
    omega = turn * normal
    v, r = v - normal * (normal @ v), r - normal * (normal @ r)
    found = percussion(omega, v, normal, v_in, 1.0, EPS)
    assert not found.translates
    np.testing.assert_allclose(velocity_at(omega, v, found.copc), 0.0, atol=1e-12)
    assert found.copc @ normal == pytest.approx(0.0, abs=1e-11)  # |v| / turn reaches 1e3
    assert found.ropc == pytest.approx(v_in / turn, rel=1e-12)
    assert shock_at(omega, v, r, v_in) == pytest.approx(np.linalg.norm(r - found.copc) / found.ropc, rel=1e-9, abs=1e-12)


@given(st.floats(0.1, 10.0), st.floats(0.0, 2 * math.pi), st.floats(0.1, 5.0))
def test_shock_is_one_at_the_radius_of_percussion(turn, angle, v_in):
    """r_p is the distance from the centre at which the body feels the strike itself."""
    omega, v = turn * SAGITTAL, np.array([0.7, 0.0, -0.4])
    found = percussion(omega, v, SAGITTAL, v_in, 1.0, EPS)
    rim = found.copc + found.ropc * np.array([math.cos(angle), 0.0, math.sin(angle)])
    assert shock_at(omega, v, rim, v_in) == pytest.approx(1.0, rel=1e-12)


def test_a_positive_turn_about_the_sagittal_normal_carries_x_towards_z():
    """In x–z the normal is −y: a body that turns about +n moves its forward end up."""
    omega = 2.0 * SAGITTAL
    np.testing.assert_allclose(velocity_at(omega, np.zeros(3), np.array([1.0, 0.0, 0.0])), [0.0, 0.0, 2.0], atol=0)
    # Eq. 11 in the plane's own axes: (p1, p2) = (−v2, v1) / ω_n.
    found = percussion(omega, np.array([0.3, 0.0, -0.8]), SAGITTAL, 1.0, 1.0, EPS)
    np.testing.assert_allclose(found.copc, [0.4, 0.0, 0.15], rtol=1e-15)


@given(VECTORS.filter(lambda w: np.linalg.norm(w) > 0.1), VECTORS)
def test_pitch_is_that_of_the_screw(omega, v):
    """At the point ω × v / ω² nearest the axis the velocity is along ω, pitch times ω: no point is slower than |ω·v| / |ω|."""
    pitch = float(percussion(omega, v, SAGITTAL, 1.0, 1.0, EPS).pitch)
    nearest = np.cross(omega, v) / (omega @ omega)
    np.testing.assert_allclose(velocity_at(omega, v, nearest), pitch * omega, atol=1e-9)
    least = float(shock_at(omega, v, nearest, 1.0))
    assert least == pytest.approx(abs(omega @ v) / np.linalg.norm(omega), abs=1e-9)
    for r in np.random.default_rng(0).normal(0.0, 3.0, (20, 3)):
        assert shock_at(omega, v, r, 1.0) >= least - 1e-9


@pytest.mark.parametrize(("share", "translates"), [(0.5, True), (2.0, False)])
@pytest.mark.parametrize("tolerance", [1e-12, 1e-6])
@pytest.mark.parametrize("v_in", [1e-6, 1.0, 1e6])
def test_a_rotation_within_rounding_is_a_translation(share, translates, tolerance, v_in):
    """What moves no point of the robot by more than rounding is no rotation, whatever the speed; twice that is one."""
    length = 0.7
    omega = share * tolerance * v_in / length * SAGITTAL
    found = percussion(omega, np.array([0.0, 0.0, v_in]), SAGITTAL, v_in, length, tolerance)
    assert bool(found.translates) is translates
    assert bool(np.isinf(found.ropc)) is translates
    assert bool(np.isnan(found.copc).all()) is translates
    assert bool(np.isnan(found.pitch)) is translates
    if not translates:
        assert found.ropc == pytest.approx(length / (share * tolerance), rel=1e-12)


def test_an_exact_translation_makes_no_noise():
    """ω = 0 exactly, and a body that does not move at all: no centre, infinite radius, uniform shock, and no warning on the way."""
    for v in ([0.0, 0.0, 1.0], [0.0, 0.0, 0.0]):
        found = percussion(np.zeros(3), np.array(v), SAGITTAL, 1.0, 1.0, EPS)
        assert bool(found.translates)
        assert found.ropc == math.inf
        assert np.isnan(found.copc).all()
    np.testing.assert_array_equal(shock_at(np.zeros(3), np.array([0.0, 0.0, 1.0]), np.eye(3), 2.0), 0.5)


def test_a_turn_across_the_plane_is_no_centre_in_it():
    """A body that turns only about an axis in the plane translates as far as the plane can tell, yet its screw has a pitch."""
    found = percussion(np.array([0.0, 0.0, 2.0]), np.array([0.0, 1.0, 1.0]), SAGITTAL, 1.0, 1.0, EPS)
    assert bool(found.translates)
    assert found.pitch == pytest.approx(0.5, rel=1e-15)


@given(NORMALS, VECTORS, VECTORS, st.floats(0.01, 1.0))
def test_off_plane_share_lies_between_none_and_all(normal, omega, v, gyration):
    """0 for a jump in the plane, 1 for one across it; a part that vanishes has no share of its own."""
    share = float(off_plane_share(omega, v, normal, np.float64(gyration)))
    assert 0.0 <= share <= 1.0 + 1e-12
    inside = off_plane_share(normal * 2.0, v - normal * (normal @ v), normal, np.float64(gyration))
    assert inside == pytest.approx(0.0, abs=1e-12)
    plane = plane_from(normal)
    assert off_plane_share(plane.e1, normal, normal, np.float64(gyration)) == pytest.approx(1.0, rel=1e-12)
    assert off_plane_share(np.zeros(3), normal, normal, np.float64(gyration)) == pytest.approx(1.0, rel=1e-12)
    assert off_plane_share(np.zeros(3), np.zeros(3), normal, np.float64(gyration)) == 0.0
    # A turn that is rounding beside the translation does not count as an off-plane jump of its own.
    assert off_plane_share(1e-14 * plane.e1, plane.e2, normal, np.float64(gyration)) < 1e-13


@given(st.integers(1, 4), st.integers(1, 4))
def test_a_stack_of_bodies_is_every_body_by_itself(n, k):
    """Leading axes are carried through every function."""
    rng = np.random.default_rng(n * 10 + k)
    omega, v, r = rng.normal(size=(3, n, k, 3))
    omega[0, 0] = 0.0
    stacked = percussion(omega, v, SAGITTAL, 1.0, 1.0, EPS)
    for i in np.ndindex(n, k):
        for together, alone in zip(stacked, percussion(omega[i], v[i], SAGITTAL, 1.0, 1.0, EPS), strict=True):
            np.testing.assert_array_equal(together[i], alone)
        assert shock_at(omega, v, r, 1.0)[i] == shock_at(omega[i], v[i], r[i], 1.0)


@pytest.mark.parametrize("tolerance", [np.array([1e-12, 1e-3])])
def test_every_body_has_its_own_tolerance(tolerance):
    """A body known to few digits does not hide the rotation of one that is known to many."""
    omega = np.array([[0.0, -1e-6, 0.0], [0.0, -1e-6, 0.0]])
    v = np.array([[0.0, 0.0, 1e-6], [0.0, 0.0, 1e-6]])
    assert percussion(omega, v, SAGITTAL, 1.0, 1.0, tolerance).translates.tolist() == [False, True]
