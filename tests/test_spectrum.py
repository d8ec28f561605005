"""The shock response spectrum against what is known of standard pulses."""

import numpy as np
import pytest

from shockpc.core.spectrum import amplification, shock_response

T = 0.011
t = np.linspace(0.0, T, 5001)
HALF_SINE, RECTANGLE = np.sin(np.pi * t / T)[:, None], np.ones((len(t), 1))


def test_a_soft_oscillator_sees_the_velocity_jump_alone():
    """2π f Δv, whatever the shape of the pulse."""
    f = np.array([1e-3, 0.01, 0.1]) / T
    for pulse, jump in ((HALF_SINE, 2.0 * T / np.pi), (RECTANGLE, T)):
        np.testing.assert_allclose(
            shock_response(pulse, t[1], f, 0.0)[:, 0], 2.0 * np.pi * f * jump, rtol=0.05
        )


def test_the_largest_responses_of_pulses():
    """2 A for a rectangle, 1.77 A near f T = 0.8 for a half-sine, and A for a stiff oscillator."""
    f = np.linspace(0.3, 3.0, 271) / T
    response = shock_response(HALF_SINE, t[1], f, 0.0)[:, 0]
    assert response.max() == pytest.approx(1.768, abs=2e-3)
    assert f[np.argmax(response)] * T == pytest.approx(0.81, abs=0.02)
    np.testing.assert_allclose(shock_response(RECTANGLE, t[1], f[f * T > 0.5], 0.0), 2.0, rtol=1e-3)
    assert shock_response(HALF_SINE, t[1], np.array([100.0 / T]), 0.05)[0, 0] == pytest.approx(
        1.0, abs=0.01
    )


@pytest.mark.parametrize("damping", [0.0, 0.02, 0.05, 0.5])
def test_the_response_to_a_rectangle_in_closed_form(damping):
    """s(t) − s(t − T) with the step response s = 1 − exp(−ζωt) (cos ω_d t − ζ/√(1−ζ²) sin ω_d t);
    two histories at once.
    """
    f = np.array([0.6, 2.0, 7.0]) / T
    response = shock_response(np.hstack([RECTANGLE, 3.0 * RECTANGLE]), t[1], f, damping)
    root = np.sqrt(1.0 - damping**2)

    def step(time):
        phase = 2.0 * np.pi * np.outer(np.maximum(time, 0.0), f)
        return 1.0 - np.exp(-damping * phase) * (
            np.cos(root * phase) - damping / root * np.sin(root * phase)
        )

    time = np.linspace(0.0, 3.0 * T, 60001)
    np.testing.assert_allclose(
        response[:, 0], np.abs(step(time) - step(time - T)).max(axis=0), rtol=1e-3
    )
    np.testing.assert_allclose(response[:, 1], 3.0 * response[:, 0])


@pytest.mark.parametrize("damping", [0.0, 0.05])
def test_a_maximum_between_samples_is_found(damping):
    """The same history, linear between samples, with forty times as many of them has the same
    maxima; so has a half-sine.
    """
    history = np.random.default_rng(0).normal(size=(200, 3)).cumsum(axis=0)
    f, fine = np.geomspace(10.0, 2000.0, 21), np.arange(199 * 40 + 1) / 40.0
    dense = np.column_stack([np.interp(fine, np.arange(200), column) for column in history.T])
    np.testing.assert_allclose(
        shock_response(history, 1.0 / 4e4, f, damping),
        shock_response(dense, 1.0 / 1.6e6, f, damping),
        rtol=1e-9,
    )
    w, s = 2.0 * np.pi * 2.3, np.linspace(0.0, 1.0, 1000001)
    exact = np.abs(w**2 / (w**2 - np.pi**2) * (np.sin(np.pi * s) - np.pi / w * np.sin(w * s))).max()
    assert amplification("half-sine", 2.3) == pytest.approx(exact, rel=1e-5)


@pytest.mark.parametrize(
    ("frequency", "damping"), [(0.0, 0.0), (1e9, 0.0), (10.0, 1.0), (10.0, -0.1)]
)
def test_what_has_no_meaning_is_refused(frequency, damping):
    with pytest.raises(ValueError, match="must lie"):
        shock_response(HALF_SINE, t[1], np.array([frequency]), damping)
