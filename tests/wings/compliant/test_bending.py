"""When links may be taken as rigid: against exact beams, and against what was measured on legs."""

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from commands import good

import shockpc
from shockpc import Scene, shock_profile
from shockpc.landing.resolve import landing_of
from shockpc.landing.scenes.joint_options import Joints
from shockpc.landing.scenes.scene import Contact
from shockpc.quantities.of_points import point_velocity
from shockpc.wings.compliant.links.bending import RINGS, bending, bends
from shockpc.wings.compliant.links.leg_modes import SPECIFIC_STIFFNESS, leg_modes
from shockpc.wings.compliant.of_profile import rigid_links_of
from shockpc.wings.compliant.over_time.compliant_landing import CompliantLanding

TWO_HINGES = 1.1079
"""First frequency of a uniform beam, free at both ends, on two hinges, over the exact one."""

FREE_BEAM = 4.730041**2 / (2.0 * math.pi)
"""The exact one for EI = m = L = 1 [Hz]."""

GO2 = Scene(robot="go2", contact="FL_foot", contact_stiffness=1e6)
KEYS = (
    "lowest_bending_for_jumps",
    "lowest_bending_for_torques",
    "bending_stiffness_for_jumps",
    "bending_stiffness_for_torques",
    "bending_of_metal",
)
ROD = """<robot name="rod"><link name="rod"><inertial><mass value="{m}"/><inertia ixx="{across}" iyy="{across}" izz="{along}"
ixy="0" ixz="0" iyz="0"/></inertial></link><link name="tip"/><joint name="end" type="fixed"><parent link="rod"/><child link="tip"/>
<origin xyz="0 0 {half}"/></joint></robot>"""


@pytest.fixture(scope="module")
def go2():
    return shock_profile(GO2)


def _numbers(profile):
    return np.array([profile.value(key, "robot")[0] for key in KEYS])


def test_a_rod_of_metal_has_the_frequency_of_a_beam(tmp_path):
    """A solid rod of steel, E = 26e6 m²/s² times its density, 0.8 m long and 3 cm thick."""
    density, radius, length = 7850.0, 0.015, 0.8
    m = density * math.pi * radius**2 * length
    across, along = m * (radius**2 / 4.0 + length**2 / 12.0), m * radius**2 / 2.0
    (path := tmp_path / "rod.urdf").write_text(
        ROD.format(m=m, across=across, along=along, half=length / 2.0)
    )
    modes = leg_modes(shock_profile(Scene(robot=str(path), contact="tip")).landing, 0)
    unit = TWO_HINGES * FREE_BEAM / math.sqrt(m * length**3)
    # the rod's sections have inertia against turning
    assert modes.alpha == pytest.approx(unit, rel=5e-3)
    EI = SPECIFIC_STIFFNESS * density * math.pi * radius**4 / 4.0
    assert modes.metal == pytest.approx(modes.alpha * math.sqrt(EI), rel=2e-3)
    assert modes.stiffness(modes.alpha * 5.0) == pytest.approx(25.0)


def test_what_a_contact_asks_for_follows_from_its_duration(go2):
    """Tc = π √(m/k), or the length of a pulse where that is shorter; f1 = α √EI."""
    (contact,) = go2.contacts
    Tc, modes = (
        math.pi * math.sqrt(contact.effective_mass_sticking / 1e6),
        leg_modes(go2.landing, 0),
    )
    wanted = [
        3.0 / Tc,
        7.0 / Tc,
        (3.0 / Tc / modes.alpha) ** 2,
        (7.0 / Tc / modes.alpha) ** 2,
        modes.metal,
    ]
    np.testing.assert_allclose(_numbers(go2), wanted, rtol=1e-9)
    for scene in (
        replace(GO2, pulse="half-sine:1ms"),
        replace(GO2, contact_stiffness=None, pulse="half-sine:1ms"),
    ):
        np.testing.assert_allclose(_numbers(shock_profile(scene))[:2], [3e3, 7e3], rtol=1e-9)
    for scene in (replace(GO2, contact_stiffness=None), replace(GO2, flex={"FL_calf": "EI:674"})):
        profile = shock_profile(scene)
        assert rigid_links_of(profile) is None
        assert np.isnan(_numbers(profile)).all()


@pytest.mark.parametrize(
    ("robot", "contact", "words"),
    [
        ("go2", "FL_foot", "Go2 from 3.2e5 N/m"),
        ("solo12", "FL_FOOT", "Solo 12 from 3.5e4"),
        pytest.param("g1", "left_ankle_roll_link", "G1 from 3.3e6", marks=pytest.mark.slow),
    ],
)
def test_from_where_not_even_metal_is_stiff_enough(robot, contact, words):
    """The numbers of the guide; beyond them there is a warning."""
    page = Path(shockpc.__file__).parent / "wings/compliant/bending.md"
    assert words in " ".join(page.read_text(encoding="utf-8").split())
    stiffest = float(re.search(r" from (\S+)", words)[1])
    profile = shock_profile(Scene(robot=robot, contact=contact))
    masses = profile.value("effective_mass_sticking", "contact")
    assert bending(profile.landing, masses, 1e5).stiffest(3.0) == pytest.approx(stiffest, rel=0.02)
    warned = [
        list(bends(bending(profile.landing, masses, factor * stiffest))) for factor in (0.7, 1.4)
    ]
    assert list(map(len, warned)) == [0, 1]


def test_a_landing_warns_where_not_even_metal_is_stiff_enough(go2):
    assert [one.subject for one in go2.health.warnings] == ["bending"]
    assert not shock_profile(replace(GO2, contact_stiffness=1e5)).health.warnings


def test_rotors_lower_the_first_bending_mode(go2):
    free = shock_profile(replace(GO2, joints=Joints(model="free")))
    assert leg_modes(free.landing, 0).alpha > 1.2 * leg_modes(go2.landing, 0).alpha


def test_the_modes_are_those_of_the_links_that_bend(go2):
    """The same frequency as of the landing whose scene lets these links bend."""
    from shockpc.wings.compliant.links.bent_landing import flexible_landing

    modes = leg_modes(go2.landing, 0)
    bends = landing_of(replace(GO2, flex=dict.fromkeys(modes.links, "EI:674")), go2.robot)
    assert modes.stiffness(flexible_landing(bends).elastic_frequencies()[0]) == pytest.approx(
        674.0, rel=1e-9
    )


def test_an_answer_never_says_how_near_rigid_links_are_without_saying_when_they_hold(go2):
    from shockpc.studies.analyze.report import landing_report

    closing = landing_report(go2).closing
    (k,) = [k for k, line in enumerate(closing) if "of the finite-stiffness result" in line]
    assert list(closing[k + 1 : k + 3]) == list(rigid_links_of(go2).lines)


@pytest.mark.parametrize(
    ("given", "steps"),
    [
        ({}, True),
        ({"contact": Contact(frame="FL_foot", restitution=1.0)}, True),  # along the ground it is 0
        (
            {"contact": Contact(frame="FL_foot", restitution=0.5, restitution_along="directions")},
            False,
        ),
        ({"contact_law": "damper"}, False),
        ({"contact_damping": 50.0}, True),
        ({"pulse": "rectangle:1ms"}, True),
        ({"pulse": "half-sine:1ms"}, False),
    ],
)
def test_forces_with_a_step_ring(given, steps):
    """The line of rigid links names the remedy, and so does a warning where links bend."""
    scene = replace(GO2, contact_stiffness=1e4, **given)
    assert (RINGS in rigid_links_of(shock_profile(scene)).lines[0]) == steps
    if scene.pulse is None:
        warned = [
            str(one)
            for one in shock_profile(replace(scene, flex={"FL_calf": "EI:674"})).health.warnings
        ]
        assert any("--contact-law damper" in text for text in warned) == steps


def test_dampers_in_series_raise_the_force_sooner(go2):
    """Of restitution 0, in the time 1/ω and not π/2ω, so that links have to be stiffer."""
    damped = shock_profile(replace(GO2, contact_law="damper"))
    np.testing.assert_allclose(_numbers(damped)[:2], math.pi / 2.0 * _numbers(go2)[:2], rtol=1e-9)
    assert rigid_links_of(damped).stiffest(3.0) == pytest.approx(
        (2.0 / math.pi) ** 2 * rigid_links_of(go2).stiffest(3.0)
    )


def test_a_step_of_force_opens_a_contact_early(go2):
    """On very stiff links the base has the jump of rigid ones by a damper; by a step, that when the
    normal is fully compressed.
    """

    def jumps(law, flex):
        found = CompliantLanding(
            landing_of(replace(GO2, gravity=False, contact_law=law, flex=flex), go2.robot)
        )
        return found.ends(point_velocity, found.landing.places("body")[:1])[0, :, 0]

    stiff = dict.fromkeys(("FL_calf", "FL_thigh", "FL_hip"), "EI:1e8")
    compressed, end, impulse = jumps("hysteresis", {})
    size = np.linalg.norm(impulse)
    assert np.linalg.norm(compressed - end) > 0.2 * size
    np.testing.assert_allclose(jumps("hysteresis", stiff)[1], compressed, atol=0.02 * size)
    np.testing.assert_allclose(jumps("damper", stiff)[1], end, atol=0.02 * size)


@pytest.mark.parametrize(
    ("contact", "model"),
    [
        (tuple(Contact(frame=f"{leg}_foot") for leg in ("FL", "FR", "RL", "RR")), "locked"),
        (Contact(frame="FL_foot", directions=("z",)), "geared"),
    ],
)
def test_contacts_stop_the_mass_of_the_landing(contact, model):
    """All feet of a robot with locked joints share its mass, less than each alone stops; one that
    slides stops less too.
    """
    profile = shock_profile(replace(GO2, contact=contact, joints=Joints(model=model)))
    mass = (
        profile.robot.mass / 4.0
        if model == "locked"
        else profile.contacts[0].effective_mass_frictionless
    )
    assert rigid_links_of(profile).mass == pytest.approx(mass, rel=1e-9)
    assert mass < 0.9 * profile.value("effective_mass_sticking", "contact").min()


def test_contacts_of_equal_masses_share_the_mass_too():
    """Two contacts whose masses are the same to the last digit are two."""
    contacts = tuple(Contact(frame=f"{leg}_foot") for leg in ("FL", "FR"))
    landing = shock_profile(replace(GO2, contact=contacts)).landing
    equal, other = np.array([50.0, 50.0]), np.array([50.0, 51.0])
    shared = bending(landing, other, 1e5).mass
    assert shared < 50.0
    assert bending(landing, equal, 1e5).mass == shared


@pytest.mark.parametrize(("stiffness", "bent"), [("1e4,1e5", False), ("1e5,1e7", True)])
def test_many_landings_say_that_links_bend(capfd, stiffness, bent):
    """A sweep warns of the row in which rigid links are the least right, and batch of the robots,
    on the terminal too.
    """
    landing = "go2", "--contact", "FL_foot", "--quantity", "peak_force"
    swept = good(capfd, "sweep", *landing, "--vary", f"contact-stiffness={stiffness}")
    listed = good(capfd, "batch", *landing, "--contact-stiffness", stiffness.rpartition(",")[2])
    assert ("links bend" in swept, "links bend" in listed) == (bent, bent)
    assert ("row 1 (--contact-stiffness 10000000.0)" in swept) == bent
