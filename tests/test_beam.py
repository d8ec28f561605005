"""The single body of the paper's Figure 1: closed forms, and the whole method compared with them."""

import functools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from trees import known_robot

from shockpc.landing.scenes.scene import Contact, Scene
from shockpc.landing.scenes.strike import Strike
from shockpc.profile import shock_profile

pytestmark = pytest.mark.smoke

GYRATION_2 = 1.0 / 12.0
"""Square of the radius of gyration of a rod that is 1 m long [m²]."""

ANGLES = st.floats(-80.0, 80.0)


@functools.cache
def struck(offset, angle=0.0, directions=("x", "y", "z")):
    """Profile of the beam that lies along x, struck at `offset` from its pivot."""
    contact = Contact(frame="pivot", offset=(offset, 0.0, 0.0), directions=directions)
    return shock_profile(
        Scene(robot="beam", contact=(contact,), strike=Strike(strike_angle_deg=angle)),
        known_robot("beam"),
    )


def centre_of_percussion(c):
    """Eq. 1: distance p of the centre of percussion from the pivot, c (p − c) = r_g²; c is that of
    the centre of mass.
    """
    return c + GYRATION_2 / c


def radius_of_percussion(d):
    """Eq. 3: r_p = |d + r_g² / d| for a strike whose line has the distance d from the centre of
    mass.
    """
    return abs(d + GYRATION_2 / d) if d else math.inf


def test_beam_a_struck_at_the_centre_of_mass_only_translates():
    """Case A: no CoPc, infinite RoPc, and the shock is 1 at every point."""
    profile = struck(0.5)
    assert profile.translates.tolist() == [True]
    assert profile.ropc.tolist() == [math.inf]
    assert np.isnan([profile.copc, profile.copc_world]).all()
    np.testing.assert_allclose(
        profile.shock_at("beam", [[0.0, 0, 0], [1.0, 0, 0]]), 1.0, rtol=1e-12
    )


@pytest.mark.parametrize(
    ("offset", "centre"),
    [(0.9, 0.5 - 1.0 / 4.8), (2.0 / 3.0, 0.0), (0.0, 2.0 / 3.0), (1.0, 1.0 / 3.0)],
    ids=["B", "C", "D", "tip"],
)
def test_beams_b_to_d_match_the_closed_forms(offset, centre):
    """Struck perpendicularly: P lies where Eq. 1 puts it (C: on the pivot; D: at 2l/3), at r_p of
    Eq. 3 from the strike.
    """
    profile, d = struck(offset), abs(offset - 0.5)
    assert not profile.translates[0]
    np.testing.assert_allclose(profile.copc[0], [centre, 0.0, 0.0], atol=1e-13)
    assert abs(profile.copc[0, 0] - offset) == pytest.approx(centre_of_percussion(d), rel=1e-12)
    assert profile.ropc[0] == pytest.approx(radius_of_percussion(d), rel=1e-12)
    assert profile.shock_at("beam", [centre, 0.0, 0.0]) == pytest.approx(0.0, abs=1e-13)


@given(st.floats(-1.0, 2.0), st.floats(-1.0, 2.0))
def test_shock_along_the_beam_follows_eq_2(offset, place):
    """For any contact point, the shock at a point is its distance from P over r_p."""
    profile = struck(offset)
    expected = 1.0 if profile.translates[0] else abs(place - profile.copc[0, 0]) / profile.ropc[0]
    assert profile.shock_at("beam", [place, 0.0, 0.0]) == pytest.approx(
        expected, rel=1e-9, abs=1e-12
    )


@given(ANGLES, st.floats(0.0, 1.0))
def test_a_frictionless_slider_follows_eq_3(angle, offset):
    """The slider holds the beam perpendicularly and lets it slide along itself: only that part of
    an oblique strike counts.
    """
    profile, d = struck(offset, angle, ("z",)), abs(offset - 0.5)
    expected = radius_of_percussion(d) / math.cos(math.radians(angle)) if d > 1e-9 else math.inf
    assert profile.ropc[0] == pytest.approx(expected, rel=1e-9) or (
        profile.translates[0] and expected > 1e9
    )


@given(ANGLES)
def test_an_impulse_along_the_strike_follows_eq_3(angle):
    """Held along the strike alone, the impulse passes the centre of mass at d = l/2 cos θ, and Eq.
    3 holds as printed.
    """
    theta = math.radians(angle)
    ropc = struck(0.0, angle, ((math.sin(theta), 0.0, -math.cos(theta)),)).ropc[0]
    assert ropc == pytest.approx(radius_of_percussion(0.5 * math.cos(theta)), rel=1e-10)


@given(ANGLES)
def test_a_sticking_end_rotates_about_itself(angle):
    """A rod that sticks at its end rotates by 3/2 of the perpendicular part of the strike: r_p = 2l
    / (3 cos θ).
    """
    assert struck(0.0, angle).ropc[0] == pytest.approx(
        2.0 / 3.0 / math.cos(math.radians(angle)), rel=1e-10
    )


def test_eq_3_does_not_hold_for_a_sticking_oblique_strike():
    """ERRATA, Eq. 3: printed for any impact, but sticking at the end at 45 degrees gives 0.943 l
    where it says 0.589 l.
    """
    assert radius_of_percussion(0.5 * math.cos(math.radians(45.0))) == pytest.approx(
        0.589, abs=5e-4
    )
    assert struck(0.0, 45.0).ropc[0] == pytest.approx(0.943, abs=5e-4)
