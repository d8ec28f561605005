"""The numbers of the guide on contacts of finite stiffness, by the landings that it names."""

import re
from dataclasses import replace

import numpy as np
import pytest

import shockpc
from shockpc.studies.guide.command import files_of
from shockpc.wings.compliant.beyond.leg import leg_frequencies
from shockpc.wings.compliant.beyond.robots import robot_study

FOOT = shockpc.Contact(frame="FL_foot")
GO2 = shockpc.Scene(robot="go2", contact=(FOOT,), contact_stiffness=1e6)


def page(name):
    """The text of a page of the guide in one line."""
    return " ".join(files_of("md")[name].read_text(encoding="utf-8").split())


def tubes(flex):
    """A flexibility of all calves and thighs."""
    return {"*_calf": flex, "*_thigh": flex}


def peaks(scene):
    """Force at the foot, acceleration of the IMU, torques of calf and thigh."""
    profile = shockpc.shock_profile(scene)
    torques = dict(
        zip(profile.landing.robot.joint_names, profile.value("peak_torque", "joint"), strict=True)
    )
    return [
        profile.value("peak_force", "contact")[0],
        profile.value("peak_acceleration", "point")[0],
        torques["FL_calf_joint"],
        torques["FL_thigh_joint"],
    ]


def test_peaks_with_links_that_bend():
    """The table of links that bend; the page on bending rounds its numbers."""
    rows = re.findall(
        r"\| [a-z' A-Z]+\[(?:N|g|N m)\] \|([^|]+)\|([^|]+)\|([^|]+)\|", page("stiffness")
    )
    columns = np.array(rows, dtype=float).T
    elastic = replace(GO2, contact=(replace(FOOT, restitution=1.0),))
    flexes = ({}, tubes("EI:674"), tubes("EI:674,hinges:6"))
    computed = np.array([peaks(replace(elastic, flex=flex)) for flex in flexes])
    np.testing.assert_allclose(columns, computed, rtol=2e-3)
    (bent, rigid), (g_bent, g_rigid), (calf, calf_rigid), (thigh, thigh_rigid) = computed[1::-1].T
    sentence = (
        f"{bent:.0f} N at the foot (rigid links: {rigid:.0f} N), {g_bent:.1f} g at the IMU "
        f"({g_rigid:.1f}), {calf:.0f} N m at the calf ({calf_rigid:.0f}), and {thigh:.0f} N m at "
        f"the thigh ({thigh_rigid:.0f})"
    )
    assert sentence in page("bending")


def test_a_filter_reads_less_than_the_peak():
    profile = shockpc.shock_profile(replace(GO2, imu_bandwidth="200Hz:2"))
    reading = profile.value("filtered_peak", "point")[0]
    peak = profile.value("peak_acceleration", "point")[0]
    assert f"it reads {reading:.2f} g; the raw peak is {peak:.2f} g" in page("designer")


def test_when_a_contact_without_restitution_opens():
    """With rigid links it lasts as long as the ground slows the foot; with stiff links it ends with
    the step of its force, and a part of the jump is missing.
    """
    base = shockpc.Point(frame="base")
    scene = replace(GO2, contact_stiffness=1e5, gravity=False, point=(base,))
    rigid = shockpc.shock_profile(scene)
    stiff = shockpc.shock_profile(replace(scene, flex=tubes("EI:5e6")))
    (compressed,), (ends,) = (
        1e3 * rigid.value(key, "contact") for key in ("peak_force_time", "duration")
    )
    sentence = (
        f"compressed after {compressed:.1f} ms, while the ground slows the foot along its tangents "
        f"until {ends:.1f} ms"
    )
    assert sentence in page("bending")
    assert f"opens soon after {compressed:.1f} ms" in page("bending")
    assert 1e3 * stiff.value("duration", "contact")[0] == pytest.approx(compressed, abs=0.05)

    assert rigid.points[1].frame == "base"
    whole = rigid.value("delta_v", "point")[1]
    missing = whole - stiff.value("delta_v_separated", "point")[1]
    assert np.linalg.norm(missing) == pytest.approx(0.2 * np.linalg.norm(whole), rel=0.1)
    assert "a fifth of the base's jump" in page("bending")


def test_rotors_lower_the_first_mode_of_the_leg():
    rotors, free = leg_frequencies()
    sentence = f"{free.frames:.0f} Hz with free joints and at {rotors.frames:.0f} Hz with rotors"
    assert sentence in page("bending")


@pytest.mark.slow
def test_joints_ring_after_a_step_of_force():
    """The smallest and the largest error over the robots at Tc f1 = 10."""
    ringing = [
        100.0 * row.errors.torque
        for row in robot_study()
        if row.law == "hysteresis, e = 0" and row.ratio == 10.0
    ]
    sentence = f"off by {min(ringing):.0f} to {max(ringing):.0f} % at `Tc · f1 = 10`"
    assert len(ringing) == 3
    assert sentence in page("bending")
