"""Planes and velocities: orientation, rigid motion, and what is refused."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from shockpc import Scene, SceneError
from shockpc.core.spatial import cross_matrix, plane_from, velocity_at
from shockpc.landing.scenes.scene_file import plane_of

pytestmark = pytest.mark.smoke

VECTORS = arrays(float, 3, elements=st.floats(-10.0, 10.0, allow_subnormal=False))
X, Y, Z = np.eye(3)


@pytest.mark.parametrize(("name", "e1", "e2"), [("xz", X, Z), ("yz", Y, Z), ("xy", X, Y)])
def test_named_planes_have_their_letters_for_axes(name, e1, e2):
    """Plane "xz" has e1 = x and e2 = z, so its normal x × z is −y; and so for the others."""
    plane = plane_of(Scene(robot="any", plane=name))
    np.testing.assert_array_equal(plane, [np.cross(e1, e2), e1, e2])
    # "-0" would reach printed files
    assert not np.signbit(np.concatenate(plane))[np.concatenate(plane) == 0.0].any()


# nearly level: the normal leaves "up" almost no component in the plane
@example(np.array([1e-7, -2e-7, 1.0]))
@given(VECTORS.filter(lambda n: np.linalg.norm(n) > 1e-3))
def test_a_plane_is_a_right_handed_frame_with_e2_up(normal):
    """Its axes are orthonormal with e1 × e2 = n, n is parallel to the given normal, and no
    direction in it is higher than e2.
    """
    n, e1, e2 = plane = plane_from(normal)
    # cancellation in a nearly level plane
    np.testing.assert_allclose(np.stack(plane) @ np.stack(plane).T, np.eye(3), atol=1e-7)
    np.testing.assert_allclose(np.cross(e1, e2), n, atol=1e-14)
    np.testing.assert_allclose(n * np.linalg.norm(normal), normal, rtol=1e-12, atol=1e-12)
    if np.hypot(n[0], n[1]) > 1e-6:
        assert e1[2] == pytest.approx(0.0, abs=1e-9)
        assert e2[2] > 0.0


@pytest.mark.parametrize(
    ("normal", "forward"),
    [((0, -1, 0), X), ((0, 1, 0), X), ((1, 0, 0), Y), ((-1, 0, 0), Y), ((0, 0, 1), X)],
)
def test_forward_does_not_depend_on_the_sign_of_the_normal(normal, forward):
    """It points to world x, or to world y in a plane across x, where e1 reverses with the normal."""
    np.testing.assert_allclose(plane_from(normal).forward, forward, atol=1e-15)


@pytest.mark.parametrize("normal", [(0.0, 0.0, 0.0), (np.nan, 0.0, 1.0), (np.inf, 0.0, 0.0)])
def test_a_normal_without_a_finite_length_is_refused(normal):
    """The message repeats the given normal, and a scene's says which planes are valid."""
    for given_to, error, also in (
        (plane_from, ValueError, ()),
        (lambda n: plane_of(Scene(robot="any", plane=n)), SceneError, ("xz", "yz")),
    ):
        with pytest.raises(error, match="finite length") as refusal:
            given_to(normal)
        assert all(part in str(refusal.value) for part in (str(list(normal)), *also))


@given(VECTORS, VECTORS)
def test_the_cross_matrix_is_the_cross_product(r, u):
    """[r]× u = r × u, and [r]× is skew."""
    np.testing.assert_array_equal(cross_matrix(r), -cross_matrix(r).T)
    np.testing.assert_allclose(cross_matrix(r) @ u, np.cross(r, u), atol=1e-13)


@given(VECTORS, VECTORS, VECTORS, VECTORS)
def test_points_of_a_rigid_body_keep_their_distances(omega, v, r, s):
    """Velocities of two points differ only across the line between them (Eq. 10)."""
    difference = velocity_at(omega, v, r) - velocity_at(omega, v, s)
    # products of three numbers up to 10
    assert difference @ (r - s) == pytest.approx(0.0, abs=1e-11)
    np.testing.assert_allclose(difference, np.cross(omega, r - s), atol=1e-12)
