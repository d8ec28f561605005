"""Landings with friction, from the command line: closed forms, consistency and refusals."""

from dataclasses import replace

import numpy as np
import pytest
from commands import document, good, run, vector
from panels import scene as paper_scene
from robot_texts import BOX

from shockpc import (
    Contact,
    Joints,
    Point,
    Scene,
    Strike,
    shock_profile,
)

FOOT = (Contact(frame="LF_FOOT"),)
ANYMAL = Scene(robot="anymal_b", contact=FOOT, strike=Strike(strike_angle_deg=10.0))


@pytest.mark.parametrize("mu", [0.0, 0.3])
def test_a_body_that_slides(capfd, here, mu):
    """v_n = −1 is stopped by λ = 1 / (1/m + (x² + µ x z) / I), with friction −µ λ against the slip,
    which stays forward.
    """
    (here / "box.urdf").write_text(BOX)
    words = (
        "box.urdf",
        "--contact",
        "box",
        "--offset",
        "0.3,0,-0.1",
        "--velocity",
        "5,0,-1",
        "--friction",
        mu,
    )
    whole = document(capfd, *words)
    found, tables = whole["friction"], whole["tables"]
    normal = 1.0 / (1.0 / 2.0 + (0.3**2 - 0.3 * 0.1 * mu) / 0.1)
    (contact,) = tables["contacts"]
    assert (contact["contact"], contact["state"], found["solutions"], found["unchanged"]) == (
        "box",
        "slides",
        1,
        False,
    )
    np.testing.assert_allclose(
        vector(contact, "impulse_friction"), [-mu * normal, 0.0, normal], atol=1e-13
    )
    turn = (-0.1 * -mu * normal - 0.3 * normal) / 0.1
    np.testing.assert_allclose(
        vector(contact, "slip"), [5.0 - mu * normal / 2.0 - 0.1 * turn, 0.0, 0.0], atol=1e-12
    )
    np.testing.assert_allclose(
        vector(tables["bodies"][0], "delta_omega_friction"), [0.0, turn, 0.0], atol=1e-12
    )
    before, after = 26.0, (5.0 - mu * normal / 2.0) ** 2 + (normal / 2.0 - 1.0) ** 2
    assert tables["landing"][0]["energy_lost_friction"] == pytest.approx(
        before - after - 0.05 * turn**2, abs=1e-12
    )
    text = good(capfd, "analyze", *words)
    assert f"contacts with friction {mu:g} (world axes; double precision)" in text
    assert "all other tables are without friction, for contacts that stick" in text


def test_a_contact_sticks_from_the_friction_that_it_needs():
    """Then each result is that of Eq. 4, as proven."""
    needed = shock_profile(ANYMAL).contacts[0].friction_needed
    for factor, state in ((1.001, "sticks"), (0.999, "slides")):
        profile = shock_profile(replace(ANYMAL, friction=factor * needed))
        assert profile.friction.state == (state,)
        assert (profile.friction.impact is None) == (state == "sticks")
        assert (
            profile.value("shock_friction", "point") == profile.value("shock", "point")
        ).all() == (state == "sticks")


@pytest.mark.parametrize("base", ["free", "planar", "fixed"])
def test_the_jump_of_the_contact_point_is_its_change_of_velocity(base):
    """The bodies' jumps by Eqs. 8 and 9 against the Delassus matrix; joints that are free carry
    nothing.
    """
    contacts = (*FOOT, Contact(frame="RH_FOOT", restitution=0.4))
    feet = tuple(Point(frame=contact.frame) for contact in contacts)
    armature = Joints(armature={"*_KFE": 0.02})
    profile = shock_profile(
        replace(ANYMAL, contact=contacts, point=feet, friction=0.2, base=base, joints=armature)
    )
    assert "slides" in profile.friction.state
    for k, place in list(enumerate(profile.places("point")))[-2:]:
        jump = (
            profile.rotation[place.body]
            @ place.axes
            @ profile.value("delta_v_friction", "point")[k]
        )
        index = [contact.frame for contact in contacts].index(place.name)
        np.testing.assert_allclose(
            jump, profile.value("slip", "contact")[index] - profile.approach[index], atol=1e-12
        )
    rate, along = (
        profile.value("delta_qd_friction", "joint"),
        profile.value("along_friction", "joint"),
    )
    knee = np.array(
        [name.endswith("KFE") for name in (place.name for place in profile.places("joint"))]
    )
    np.testing.assert_allclose(along, -0.02 * knee * rate, atol=1e-13)


@pytest.mark.parametrize("name", ["fig3", "five_bar"])
def test_loops_stay_closed_while_a_contact_slides(name):
    """Free joints carry nothing, which needs the impulses of the loop; both of its ends move alike."""
    scene = paper_scene(name)
    ends = scene.closure[0]
    scene = replace(
        scene,
        friction=0.01,
        point=(Point(frame=ends.a.frame), Point(frame=ends.b.frame)),
        joints=Joints(),
    )
    profile = shock_profile(replace(scene, strike=Strike(strike_angle_deg=40.0)))
    assert profile.friction.state == ("slides",)
    moved = [
        profile.rotation[place.body] @ place.axes @ jump
        for place, jump in zip(
            profile.places("point"), profile.value("delta_v_friction", "point"), strict=True
        )
    ][-2:]
    np.testing.assert_allclose(moved[0], moved[1], atol=1e-12)
    assert np.linalg.norm(moved[0]) > 0.01
    np.testing.assert_allclose(profile.value("along_friction", "joint"), 0.0, atol=1e-12)


@pytest.mark.parametrize("along", ["normal", "directions"])
def test_restitution_acts_along_the_normal_alone(along):
    """Eq. 4 reverses the velocity along the ground too; with friction a contact that sticks stays
    where it is.
    """
    contact = Contact(frame="LF_FOOT", restitution=0.5, restitution_along=along)
    profile = shock_profile(replace(ANYMAL, contact=(contact,), friction=5.0))
    assert profile.friction.state == ("sticks",)
    np.testing.assert_allclose(
        profile.value("slip", "contact")[0], [0.0, 0.0, -0.5 * profile.approach[0, 2]], atol=1e-12
    )
    assert (profile.friction.impact is None) == (along == "normal")
    assert profile.value("friction_solutions", "robot").tolist() == [1.0]


def test_an_answer_that_gains_energy_is_refused(capfd, here):
    """Slip that reverses with a high restitution (Kane and Levinson 1985)."""
    (here / "box.urdf").write_text(BOX)
    words = (
        "--contact",
        "box",
        "--offset",
        "-0.4,0,-0.6",
        "--velocity",
        "0.5,0,-1",
        "--friction",
        0.6,
    )
    outcome = run(capfd, "analyze", "box.urdf", *words, "--restitution", 0.9)
    assert (outcome.code, outcome.out) == (3, "")
    assert "would gain 0.192 J of kinetic energy" in outcome.err
    good(capfd, "analyze", "box.urdf", *words)


def test_redundant_contacts_with_friction():
    """Two points of a foot obey the laws of friction together, and the impulse of each is not told
    where it is not determined.
    """
    profile = shock_profile(
        replace(
            ANYMAL, friction=0.3, contact=(*FOOT, Contact(frame="LF_FOOT", offset=(0.0, 0.0, 0.01)))
        )
    )
    assert profile.friction.residual < 1e-9
    assert np.isnan(profile.value("impulse_friction", "contact")).all()


def test_a_sweep_takes_them_as_columns(capfd, here):
    words = (
        "--vary",
        "strike-angle=0:20:3",
        "--friction",
        0.3,
        "--quantity",
        "shock_friction@imu_link",
        "--out",
        "out",
    )
    out = good(capfd, "sweep", "anymal_b", "--contact", "LF_FOOT", *words)
    row = next(line for line in out.splitlines() if line.startswith("shock_friction@imu_link"))
    landings = [
        replace(ANYMAL, friction=0.3, strike=Strike(strike_angle_deg=angle))
        for angle in (0.0, 10.0, 20.0)
    ]
    shocks = [shock_profile(scene).value("shock_friction", "point")[0] for scene in landings]
    assert [float(word) for word in row.split()[2:5]] == pytest.approx(sorted(shocks), abs=5e-5)
