"""What accelerometers read behind their filters of a landing that lasts: simulations of scipy."""

import math
from dataclasses import replace

import numpy as np
import pytest
from test_low_pass import _read

from shockpc import Scene, shock_profile
from shockpc.core.low_pass import LowPass
from shockpc.landing.scenes.joint_options import Joints
from shockpc.landing.scenes.scene import Contact, Part
from shockpc.landing.scenes.strike import GRAVITY
from shockpc.quantities.of_points import DELTA_V
from shockpc.studies.analyze.report import document as shockpc_document
from shockpc.studies.analyze.report import landing_report
from shockpc.wings.compliant.motion.contacts import simulate_landing
from shockpc.wings.compliant.motion.elements import Elements
from shockpc.wings.compliant.motion.filtered import filtered
from shockpc.wings.compliant.over_time.spectra import spectrum
from shockpc.wings.compliant.show.figure import draw_time

LANDING = Scene(robot="go2", contact="FL_foot", contact_stiffness=1e6, joints=Joints(carried=False))
FILTERS = [LowPass(200.0, 1), LowPass(60.0, 2), LowPass(900.0, 2)]


@pytest.mark.parametrize(
    ("low_pass", "damping"), list(zip(FILTERS, (0.0, 60.0, 0.0), strict=True)), ids=str
)
def test_forces_behind_a_filter_are_those_that_scipy_simulates(low_pass, damping):
    """Two bodies with a spring between them that is deflected before one strikes the ground and
    separates again.
    """
    rows = np.array([[1.0, 0.0], [1.0, -1.0]])
    elements = Elements.alike(
        rows,
        np.array([1e5, 4e4]),
        np.ones(2),
        np.array([0, -1]),
        np.array([True, False]),
        np.array([damping, 0.0]),
        np.array([0.0, 30.0]),
    )
    motion = simulate_landing(np.diag([1.0, 3.0]), elements, np.array([-1.0, -1.0]), 0.04)
    assert len(motion.segments) > 1
    t = np.linspace(0.0, motion.duration, 2001)
    outputs = np.array([[[1.0, 0.0]], [[0.7, -2.0]]])
    behind, settled = filtered(motion, low_pass), outputs[:, 0] @ [0.0, 30.0]
    values = motion.at(t).force @ outputs[:, 0].T - settled
    wanted = [
        np.abs(_read(low_pass, one, t)[0] + before).max()
        for one, before in zip(values.T, settled, strict=True)
    ]
    peaks, when = behind.peak(outputs)
    np.testing.assert_allclose(peaks, wanted, rtol=1e-4)
    at_peaks = np.abs(
        [
            row[0] @ behind.at(np.array([time])).force[0]
            for row, time in zip(outputs, when, strict=True)
        ]
    )
    np.testing.assert_allclose(at_peaks, peaks, rtol=1e-9)


@pytest.mark.parametrize(
    ("low_pass", "slower"), [(LowPass(60.0, 2), None), (LowPass(60.0, 1), 3.0)], ids=str
)
def test_an_oscillation_at_the_rate_of_the_filter_is_read_as_scipy_simulates_it(low_pass, slower):
    """A mass on a spring and a damper whose rate λ is a pole of the filter: there the closed form
    is 0/0.
    """
    omega = 2.0 * math.pi * low_pass.frequency
    # λ² + c λ + k = 0 has the filter's poles: a pair, or −ω and another real rate.
    stiffness, damping = (
        (omega**2, math.sqrt(2.0) * omega)
        if slower is None
        else (slower * omega**2, (1.0 + slower) * omega)
    )
    one = np.ones(1)
    elements = Elements.alike(
        one[None], stiffness * one, one, np.array([0]), np.array([True]), damping * one, np.zeros(1)
    )
    motion = simulate_landing(one[None], elements, -one, 0.02)
    t = np.linspace(0.0, motion.duration, 4001)
    wanted = np.abs(_read(low_pass, motion.at(t).force[:, 0], t)[0]).max()
    behind = filtered(motion, low_pass)
    assert np.abs(behind.at(t).force[:, 0]).max() == pytest.approx(wanted, rel=2e-4)


@pytest.mark.parametrize(
    ("low_pass", "law", "stiffness"),
    [(LowPass(10.0, 1), "damper", 1e4), (LowPass(3.0, 2), None, 1e6)],
    ids=str,
)
def test_no_peak_is_missed_behind_a_slow_filter(low_pass, law, stiffness):
    """Links that bend oscillate fast and little beside what the filter passes: no dense sample is
    above the peak.
    """
    contact = Contact(
        frame="FL_foot", restitution=float(law is None), restitution_along="directions"
    )
    scene = replace(
        LANDING,
        contact=contact,
        contact_stiffness=stiffness,
        contact_law=law,
        flex={"*_calf": "EI:674"},
        gravity=False,
    )
    found = shock_profile(scene).stiffness
    places, motion = found.landing.places("point"), found.filtered(low_pass)
    t = np.concatenate(
        [part.start + np.linspace(0.0, part.length, 400) for part in motion.segments]
    )
    sampled = np.linalg.norm(found.history(DELTA_V.compute, places, t, low_pass), axis=2).max(
        axis=0
    )
    assert np.all(found.peaks(DELTA_V.compute, places, low_pass)[0] >= (1.0 - 2e-7) * sampled)


@pytest.fixture(scope="module")
def landed():
    return {
        text: shock_profile(replace(LANDING, imu_bandwidth=text))
        for text in ("100Hz", "100Hz:2", "400Hz", "400Hz:2")
    }


def test_readings_of_go2_are_those_of_an_independent_simulation(landed):
    """To 5e-3 at 100 Hz, where the values were sampled coarsely at the end of the contact."""
    known = {
        "100Hz": (2.4203, 2e-3),
        "100Hz:2": (1.6503, 5e-3),
        "400Hz": (4.6190, 1e-4),
        "400Hz:2": (4.3852, 1e-4),
    }
    for text, (value, within) in known.items():
        profile = landed[text]
        (k,) = [k for k, place in enumerate(profile.places("point")) if place.name == "imu"]
        read, axes = (
            profile.value("filtered_peak", "point")[k],
            profile.value("filtered_peak_axes", "point")[k],
        )
        assert read == pytest.approx(value, rel=within)
        assert axes.max() <= read <= np.linalg.norm(axes)
        assert read < profile.value("peak_acceleration", "point")[k]


def test_on_ever_harder_ground_a_reading_tends_to_that_of_the_impulse():
    hard = replace(LANDING, contact_stiffness=1e11, gravity=False, imu_bandwidth="200Hz:2")
    read = shock_profile(hard).value("filtered_peak", "point")
    bound = shock_profile(replace(hard, contact_stiffness=None, gravity=True)).value(
        "filtered_peak", "point"
    )
    np.testing.assert_allclose(read, bound, rtol=2e-3)


def test_a_part_has_a_bandwidth_of_its_own_and_without_one_nothing_is_read(landed):
    part = Part(name="logger", at="imu", rating="half-sine 1500 g 0.5 ms", imu_bandwidth="400Hz:2")
    own = shock_profile(replace(LANDING, imu_bandwidth="100Hz", part=(part,)))
    (k,) = [k for k, place in enumerate(own.places("point")) if place.name == "imu"]
    assert (
        own.value("filtered_peak", "point")[k] == landed["100Hz"].value("filtered_peak", "point")[k]
    )
    assert (
        own.value("filtered_peak", "part")[0]
        == landed["400Hz:2"].value("filtered_peak", "point")[k]
    )
    assert own.value("peak_g", "part")[0] == landed["100Hz"].value("peak_acceleration", "point")[k]
    assert np.isnan(shock_profile(LANDING).value("filtered_peak", "point")).all()


def test_a_range_is_that_of_what_is_read(landed):
    known = Joints(armature={"*": 0.01})
    for scene in (LANDING, Scene(robot="go2", contact="FL_foot")):
        profile = shock_profile(replace(scene, range_g=2.0, imu_bandwidth="100Hz", joints=known))
        share, axes = (profile.value(key, "point") for key in ("range_share", "filtered_peak_axes"))
        np.testing.assert_allclose(share, axes.max(axis=1) / 2.0, rtol=1e-12)
        saturated = [one for one in profile.health.warnings if one.kind == "sensor"]
        assert bool(saturated) == bool((share > 1.0).any())
        assert all("100 Hz" in str(one) for one in saturated)


def test_a_pulse_beside_a_stiffness_does_not_decide_on_the_range():
    """The range is compared with what sensors read on the contacts, as the tables show it, not with
    a pulse of another length.
    """
    scene = replace(LANDING, range_g=2.0, pulse="half-sine:0.1ms", imu_bandwidth="100Hz")
    with_pulse, without = (
        shock_profile(one).value("range_share", "point")
        for one in (scene, replace(scene, pulse=None))
    )
    np.testing.assert_array_equal(with_pulse, without)


def test_spectra_of_what_is_read_keep_the_jump_of_velocity_and_end_at_the_largest_reading(landed):
    """Slow oscillators see the jump alone, which a filter lets pass; fast ones follow what is read."""
    compliant = landed["400Hz:2"].stiffness
    (imu,) = [place for place in compliant.landing.points if place.name == "imu"]
    raw, read = (
        spectrum(compliant, DELTA_V.compute, [imu], 0.0, one)[:, 0]
        for one in (None, LowPass(400.0, 2))
    )
    assert read[0] == pytest.approx(raw[0], rel=0.01)
    (k,) = [k for k, place in enumerate(landed["400Hz:2"].places("point")) if place.name == "imu"]
    largest = landed["400Hz:2"].value("filtered_peak_axes", "point")[k].max()
    assert largest <= read[-1] / GRAVITY < 1.3 * largest
    assert read.max() < 0.9 * raw.max()


@pytest.mark.slow
def test_documents_and_figures_have_what_is_read(landed):
    profile = landed["400Hz:2"]
    document, report = shockpc_document(profile, spectrum=True), landing_report(profile)
    (spectrum,) = [
        one for one in document["stiffness"]["spectra"]["points"] if one["frame"] == "imu"
    ]
    assert np.shape(spectrum["filtered_response"]) == np.shape(spectrum["response"])
    assert any(name == "reading" for name, _ in report.brief()[0].lines)
    ((x, y),) = [
        line.get_data()
        for line in draw_time(profile).axes[1].get_lines()
        if line.get_linestyle() == "-."
    ]
    assert y.max() == pytest.approx(profile.value("filtered_peak", "point").max(), rel=1e-3)
    assert x[-1] == pytest.approx(1e3 * (profile.stiffness.motion.duration + 1.0 / 400.0))
