"""The single body of the paper's Figure 1: closed forms, and the whole method compared with them."""

import functools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from trees import known_robot

from shockpc.core.beam import centre_of_percussion, radius_of_percussion, shock
from shockpc.model.contact import Contact
from shockpc.profile import shock_profile
from shockpc.scene import Scene, Strike

LENGTH = 1.0
GYRATION = LENGTH / math.sqrt(12.0)
SIZES = st.floats(1e-3, 1e3)
ANGLES = st.floats(-80.0, 80.0)


@functools.cache
def struck(offset, angle=0.0, directions=("x", "y", "z")):
    """Profile of the beam that lies along x, struck at `offset` from its pivot."""
    contact = Contact(frame="pivot", offset=(offset, 0.0, 0.0), directions=directions)
    return shock_profile(Scene(robot="beam", contact=(contact,), strike=Strike(strike_angle_deg=angle)), known_robot("beam"))


# Eqs. 1–3 by themselves


def test_closed_forms_of_a_slender_rod():
    """Eq. 1 with c = l/2 and r_g² = l²/12: p = 2l/3. Eq. 2 at r_p and at twice r_p. Eq. 3 at d = 0: a translation."""
    assert centre_of_percussion(0.5, GYRATION) == pytest.approx(2.0 / 3.0, rel=1e-15)
    assert (shock(0.3, 0.3), shock(0.6, 0.3), shock(1.0, math.inf)) == (1.0, 2.0, 0.0)
    assert radius_of_percussion(0.0, GYRATION) == math.inf


@given(SIZES, SIZES)
def test_pivot_and_centre_of_percussion_can_be_exchanged(c, r_g):
    """Eq. 1 is symmetric: counted from the centre of percussion, the pivot is the centre of percussion."""
    p = centre_of_percussion(c, r_g)
    assert c * (p - c) == pytest.approx(r_g**2, rel=1e-6, abs=1e-15 * c * c)  # p − c cancels when r_g is small against c
    assert centre_of_percussion(p - c, r_g) == pytest.approx(p, rel=1e-6, abs=1e-10) or p - c < 1e-6 * c


@given(SIZES, SIZES)
def test_the_radius_is_least_when_the_strike_passes_at_the_radius_of_gyration(d, r_g):
    """Eq. 3 is even in d and never below 2 r_g, its value at d = r_g."""
    assert radius_of_percussion(d, r_g) == radius_of_percussion(-d, r_g)
    assert radius_of_percussion(d, r_g) >= 2.0 * r_g * (1.0 - 1e-15)
    assert radius_of_percussion(r_g, r_g) == pytest.approx(2.0 * r_g, rel=1e-15)


# Figure 1, by the whole method


def test_beam_a_struck_at_the_centre_of_mass_only_translates():
    """Case A: no CoPc, infinite RoPc, and the shock is 1 at every point."""
    profile = struck(0.5)
    assert profile.translates.tolist() == [True]
    assert profile.ropc.tolist() == [math.inf]
    assert np.isnan([profile.copc, profile.copc_world]).all()
    np.testing.assert_allclose(profile.shock_at("beam", [[0.0, 0, 0], [LENGTH, 0, 0]]), 1.0, rtol=1e-12)


@pytest.mark.parametrize(
    ("offset", "centre"), [(0.9, 0.5 - 1.0 / 4.8), (2.0 / 3.0, 0.0), (0.0, 2.0 / 3.0), (1.0, 1.0 / 3.0)], ids=["B", "C", "D", "tip"]
)
def test_beams_b_to_d_match_the_closed_forms(offset, centre):
    """Struck perpendicularly: P lies where Eq. 1 puts it (C: on the pivot; D: at 2l/3), at r_p of Eq. 3 from the strike."""
    profile, d = struck(offset), abs(offset - 0.5)
    assert not profile.translates[0]
    np.testing.assert_allclose(profile.copc[0], [centre, 0.0, 0.0], atol=1e-13)
    assert abs(profile.copc[0, 0] - offset) == pytest.approx(centre_of_percussion(d, GYRATION), rel=1e-12)
    assert profile.ropc[0] == pytest.approx(radius_of_percussion(d, GYRATION), rel=1e-12)
    assert profile.shock_at("beam", [centre, 0.0, 0.0]) == pytest.approx(0.0, abs=1e-13)


@given(st.floats(-1.0, 2.0), st.floats(-1.0, 2.0))
def test_shock_along_the_beam_follows_eq_2(offset, place):
    """For any contact point, the shock at a point is its distance from P over r_p."""
    profile = struck(offset)
    expected = 1.0 if profile.translates[0] else shock(abs(place - profile.copc[0, 0]), profile.ropc[0])
    assert profile.shock_at("beam", [place, 0.0, 0.0]) == pytest.approx(expected, rel=1e-9, abs=1e-12)


@given(ANGLES, st.floats(0.0, 1.0))
def test_a_frictionless_slider_follows_eq_3(angle, offset):
    """The slider holds the beam perpendicularly and lets it slide along itself: only that part of an oblique strike counts."""
    profile, d = struck(offset, angle, ("z",)), abs(offset - 0.5)
    expected = radius_of_percussion(d, GYRATION) / math.cos(math.radians(angle)) if d > 1e-9 else math.inf
    assert profile.ropc[0] == pytest.approx(expected, rel=1e-9) or (profile.translates[0] and expected > 1e9)


@given(ANGLES)
def test_an_impulse_along_the_strike_follows_eq_3(angle):
    """Held along the strike alone, the impulse passes the centre of mass at d = l/2 cos θ, and Eq. 3 holds as printed."""
    theta = math.radians(angle)
    ropc = struck(0.0, angle, ((math.sin(theta), 0.0, -math.cos(theta)),)).ropc[0]
    assert ropc == pytest.approx(radius_of_percussion(0.5 * math.cos(theta), GYRATION), rel=1e-10)


@given(ANGLES)
def test_a_sticking_end_rotates_about_itself(angle):
    """A rod that sticks at its end rotates by 3/2 of the perpendicular part of the strike: r_p = 2l / (3 cos θ)."""
    assert struck(0.0, angle).ropc[0] == pytest.approx(2.0 / 3.0 / math.cos(math.radians(angle)), rel=1e-10)


def test_eq_3_does_not_hold_for_a_sticking_oblique_strike():
    """ERRATA, Eq. 3: printed for any impact, but sticking at the end at 45 degrees gives 0.943 l where it says 0.589 l."""
    assert radius_of_percussion(0.5 * math.cos(math.radians(45.0)), GYRATION) == pytest.approx(0.589, abs=5e-4)
    assert struck(0.0, 45.0).ropc[0] == pytest.approx(0.943, abs=5e-4)
