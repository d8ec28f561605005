"""What accelerometers read behind their filters, of a pulse and at most: simulations of scipy and bounds."""

import math

import numpy as np
import pytest
from scipy import signal

from shockpc import Scene, load_robot, shock_profile
from shockpc.core.low_pass import LowPass, low_pass_from, pulse_reading
from shockpc.core.pulse import SHAPES, Pulse
from shockpc.landing.ratings import part_from
from shockpc.landing.scenes.strike import GRAVITY
from shockpc.text.errors import SceneError

FILTERS = [LowPass(200.0, 1), LowPass(60.0, 2), LowPass(900.0, 2)]


def _read(low_pass, values, times, start=0.0):
    """The filter's response (n,) to sampled values, and its state at the end.

    Args: start, its state.
    """
    omega = 2.0 * math.pi * low_pass.frequency
    above, below = (
        ([omega], [1.0, omega])
        if low_pass.order == 1
        else ([omega**2], [1.0, math.sqrt(2.0) * omega, omega**2])
    )
    _, read, state = signal.lsim(
        signal.TransferFunction(above, below).to_ss(), values, times, start
    )
    return read, state[-1]


@pytest.mark.parametrize("low_pass", FILTERS[:2], ids=str)
@pytest.mark.parametrize("shape", SHAPES)
def test_a_pulse_behind_a_filter_is_as_scipy_simulates_it_and_below_the_bound(shape, low_pass):
    length, x = 3e-3, np.linspace(0.0, 1.0, 1001)
    waves = {
        "half-sine": np.sin(math.pi * x),
        "haversine": np.sin(math.pi * x) ** 2,
        "saw-tooth": x,
        "rectangle": 0.0 * x + 1.0,
    }
    during, state = _read(low_pass, waves[shape], length * x)
    after, _ = _read(low_pass, 0.0 * x, length * x, state)
    read = max(during.max(), after.max()) / (length * float(np.trapezoid(waves[shape], x)))
    assert pulse_reading(Pulse(shape, length), low_pass) == pytest.approx(read, rel=1e-4)
    for T in (1e-7, 1e-3, 1e-1):
        assert pulse_reading(Pulse(shape, T), low_pass) <= low_pass.bound * (1.0 + 1e-8)
    assert pulse_reading(Pulse(shape, 1e-7), low_pass) == pytest.approx(low_pass.bound, rel=1e-3)


@pytest.mark.parametrize("frequency", [20.0, 100.0, 500.0])
@pytest.mark.parametrize("milliseconds", [0.2, 0.5, 1.0, 5.0])
def test_a_haversine_behind_a_slow_filter_is_the_largest_value_of_its_response(
    milliseconds, frequency
):
    """ẏ + ω y = ω sin²(πt/T): y = ½ − ½ Re[ω/(ω + iν) exp(iνt)] + C exp(−ωt), ν = 2π/T, y(0) = 0;
    it falls after the pulse.
    """
    T, omega = 1e-3 * milliseconds, 2.0 * math.pi * frequency
    t, nu = np.linspace(0.0, T, 20001), 2.0 * math.pi / T
    passed = omega / (omega + 1j * nu)
    y = (
        0.5
        - 0.5 * (passed * np.exp(1j * nu * t)).real
        + (0.5 * passed.real - 0.5) * np.exp(-omega * t)
    )
    assert pulse_reading(Pulse("haversine", T), LowPass(frequency, 1)) == pytest.approx(
        2.0 * y.max() / T, rel=1e-7
    )


def test_bounds_are_those_of_a_unit_impulse():
    assert LowPass(100.0, 1).bound == pytest.approx(2.0 * math.pi * 100.0)
    assert LowPass(100.0, 2).bound == pytest.approx(0.456 * 2.0 * math.pi * 100.0, rel=1e-3)


def test_a_part_is_typed_with_its_bandwidth():
    for text in ("200Hz:2", "200 Hz:2", "0.2kHz:2"):
        part = part_from(load_robot("go2"), "imu", f"half-sine 1500 g 0.5 ms {text}")
        assert (part.rating, low_pass_from(part.imu_bandwidth)) == (
            "half-sine 1500 g 0.5 ms",
            LowPass(200.0, 2),
        )


def test_a_bound_is_linear_in_the_jump_of_velocity():
    profile = shock_profile(Scene(robot="go2", contact="FL_foot", imu_bandwidth="200Hz"))
    jumps = profile.value("delta_v", "point")
    np.testing.assert_allclose(
        profile.value("filtered_peak_axes", "point"),
        np.abs(jumps) * 400.0 * math.pi / GRAVITY,
        rtol=1e-12,
    )


@pytest.mark.parametrize(
    "text",
    [
        "200",
        "200Hz:3",
        "200Hz:",
        "200hz",
        "-1Hz",
        "nanHz",
        "Hz",
        "200 Hz:x",
        "2 00Hz",
        "1e300Hz",
        "1e-4Hz",
    ],
)
def test_what_is_no_bandwidth_is_refused(text):
    with pytest.raises(ValueError, match="bandwidth"):
        low_pass_from(text)
    with pytest.raises(SceneError, match="imu_bandwidth"):
        shock_profile(Scene(robot="go2", contact="FL_foot", imu_bandwidth=text))
