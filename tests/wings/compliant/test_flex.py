"""Links that bend: beams of the textbooks, frame elements, the inertia of the rigid robot, and what
must not change.
"""

import json
from dataclasses import replace

import frame_leg
import numpy as np
import pytest
from commands import STICK, good, python
from robot_texts import LIMIT, joint, link, urdf

from shockpc.landing.joint_model import without_springs
from shockpc.landing.resolve import resolve
from shockpc.landing.scenes.scene import Contact, Joints, Point, Posture, Scene
from shockpc.landing.scenes.scene_file import read_scene, scene_text
from shockpc.landing.scenes.strike import GRAVITY, Strike
from shockpc.method.dynamics import Inertias, dynamics, spatial_inertias
from shockpc.profile import shock_profile
from shockpc.quantities.of_contacts import IMPULSE
from shockpc.quantities.of_points import point_velocity
from shockpc.quantities.parts.peaks import ALONG
from shockpc.quantities.selection import QUANTITIES, select
from shockpc.robot.load import load_robot
from shockpc.studies.analyze.report import document
from shockpc.studies.sweep.study import sweep
from shockpc.text.errors import RobotError, SceneError, StudyError, UnknownName
from shockpc.wings.compliant.beyond.frame_leg import urdf as tubes_urdf
from shockpc.wings.compliant.beyond.leg import leg_scene
from shockpc.wings.compliant.links.bent_landing import flexible_landing
from shockpc.wings.compliant.links.bent_robot import flexible_robot
from shockpc.wings.compliant.links.flexes import Flex, flex_from
from shockpc.wings.compliant.links.segments import (
    FINE,
    bending_frequency,
    bending_stiffness,
    chain_inertia,
    divide,
)
from shockpc.wings.compliant.over_time.compliant_landing import CompliantLanding
from shockpc.wings.compliant.show.bent_links import bent_links

FREE, CLAMPED = 4.730040744862704**2 / (2.0 * np.pi), 1.875104068711961**2 / (2.0 * np.pi)
"""First frequencies of a uniform Euler–Bernoulli beam with EI = m = L = 1 [Hz]."""


def beam(hinges, mass=1.0, length=1.0, tip=0.0):
    """A slender beam with a lump at its far end."""
    whole = mass + tip
    centre = (mass / 2.0 + tip) * length / whole
    moment = mass * length**2 / 3.0 + tip * length**2 - whole * centre**2
    return divide(
        whole,
        np.array([0.0, 0.0, -centre]),
        np.diag([moment, moment, 0.0]),
        np.zeros(3),
        np.array([0, 0, -length]),
        hinges,
    )


@pytest.mark.parametrize(("hinges", "share"), [(1, 0.6193), (2, 1.1079), (3, 1.0022), (4, 0.9998)])
def test_first_frequency_of_a_beam(hinges, share):
    """Few hinges come near the first frequency of a free beam, and many to that of a clamped one
    too.
    """
    assert bending_frequency(beam(hinges), 1.0, clamped=False) == pytest.approx(
        share * FREE, rel=1e-4
    )
    assert bending_frequency(beam(40), 1.0, clamped=True) == pytest.approx(CLAMPED, rel=5e-4)


@pytest.mark.parametrize(
    ("tip", "frequency", "clamped", "EI"),
    [
        (0.0, 3699.8, False, 674.0),
        (0.0, 581.4, True, 671.8),
        (0.05, 2770.4, False, 674.0),
        (0.05, 305.6, True, 672.6),
    ],
)
def test_a_frequency_gives_the_stiffness(tip, frequency, clamped, EI):
    """Exact frequencies of an aluminium tube 25/21 mm give its EI, 674, with a lump at its end too."""
    found = bending_stiffness(
        frequency, clamped, beam(FINE, 2700.0 * np.pi / 4.0 * (0.025**2 - 0.021**2) * 0.2, 0.2, tip)
    )
    assert found == pytest.approx(EI, abs=0.3)
    assert pytest.approx(674.0, abs=0.1) == flex_from("tube:70e9,0.025,0.021").EI


@pytest.mark.parametrize("seed", range(8))
def test_segments_keep_the_body(seed):
    """Mass, centre of mass and inertia are those of the body, whatever these are, and each segment
    is a body.
    """
    rng = np.random.default_rng(seed)
    points, mass = (
        rng.normal(size=(6, 3)) * rng.uniform(0.05, 1.0, 3) + rng.normal(size=3),
        rng.dirichlet(np.ones(6)),
    )
    com = mass @ points
    arms = points - com
    inertia = sum(m * (r @ r * np.eye(3) - np.outer(r, r)) for m, r in zip(mass, arms, strict=True))
    parts = divide(1.0, com, inertia, np.zeros(3), rng.normal(size=3), int(rng.integers(1, 6)))
    arms = parts.com - com
    shifts = (
        m * (r @ r * np.eye(3) - np.outer(r, r)) for m, r in zip(parts.mass, arms, strict=True)
    )
    whole = parts.inertia.sum(axis=0) + sum(shifts)
    np.testing.assert_allclose(parts.mass @ parts.com, com, atol=1e-14)
    np.testing.assert_allclose(whole, inertia, atol=1e-13 * np.abs(inertia).max())
    assert parts.mass.min() > 0.0
    assert np.linalg.eigvalsh(chain_inertia(parts))[0] > 0.0


@pytest.mark.parametrize("name", ["go2", "g1", "anymal_b", "solo12"])
def test_inertia_of_the_joints(name):
    """All links bend, the base and those whose mass is beside their axis too: the block of the old
    joints is that of the robot.
    """
    robot = load_robot(name)
    found = flexible_robot(robot, (("*", Flex(EI=674.0)),))
    q = found.configuration(robot.start)[None]
    state, rigid = dynamics(found.robot, q), dynamics(robot, robot.start[None]).H[0]
    np.testing.assert_allclose(
        state.H[0][np.ix_(found.v, found.v)], rigid, atol=1e-15 * np.abs(rigid).max()
    )
    # Kinetic energy, body by body: Pinocchio's algorithm needs the order of the joints that the
    # segments have.
    moving = np.where(state.ancestors[:, None], state.J[0], 0.0)
    free = without_springs(np.zeros(len(found.stiffness)), found.stiffness > 0.0, "free")
    bodies = spatial_inertias(found.robot, state, Inertias.of(found.robot, free))[0]
    energy = (np.swapaxes(moving, 1, 2) @ bodies @ moving).sum(axis=0)
    np.testing.assert_allclose(state.H[0], energy, atol=1e-13 * np.abs(rigid).max())
    assert np.linalg.eigvalsh(energy)[0] > 0.0


def test_first_frequency_of_go2():
    """With rotors of its drives, free and with its foot held, as of a second implementation; it
    grows with √EI.
    """
    landing = resolve(
        Scene(robot="go2", contact="FL_foot", joints=Joints(drives="go2", carried=False)),
        load_robot("go2"),
    )
    links = ("FL_calf", Flex(EI=674.0)), ("FL_thigh", Flex(EI=674.0))
    found = flexible_landing(landing, links)
    assert found.elastic_frequencies()[0] == pytest.approx(164.18, abs=0.01)
    assert found.elastic_frequencies(held=True)[0] == pytest.approx(84.19, abs=0.01)
    softer = flexible_landing(landing, tuple((link, flex.scaled(0.25)) for link, flex in links))
    assert softer.elastic_frequencies()[0] == pytest.approx(164.18 / 2.0, abs=0.01)
    assert [place.name for place in found.places("joint")] == [
        place.name for place in landing.places("joint")
    ]


@pytest.mark.parametrize(
    "text", ["EI:674,EA:1e7,GJ:500,hinges:4", "180.0Hz:clamped", "95.5Hz:free,hinges:3"]
)
def test_forms(text):
    """What is read is written as it was typed, but for the form of numbers."""
    assert flex_from(str(flex_from(text))) == flex_from(text)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "674",
        "EI",
        "EI:0",
        "EI:nan",
        "EI:1,EI:2",
        "EI:1,180Hz:free",
        "180Hz",
        "180Hz:held",
        "tube:70e9,0.02",
        "EA:1e7",
        "EI:1,hinges:0",
        "tube:70e9,0.021,0.025",
        "EI:1,hinges:2.5",
        "EI:1,hinges:99",
        "EI:1e13",
        "tube:70e9",
        "tube:70e9,25,21",
        "EI:6 74",
        "18 0Hz:free",
        "EI:1_0",
        "EI:1,hinges:\u0663",
    ],
)
def test_refused_forms(text):
    """Texts that say nothing of a link, or contradict themselves."""
    with pytest.raises(ValueError, match=r"EI|tube"):
        flex_from(text)


def test_refused_links(tmp_path):
    """No link of that name, and one without inertia."""
    robot = load_robot("go2")
    with pytest.raises(UnknownName, match="FL_claf"):
        flexible_robot(robot, (("FL_claf", Flex(EI=1.0)),))
    point = tmp_path / "point.urdf"
    inertial = (
        '<inertial><mass value="1"/><inertia ixx="{0}" iyy="{0}" izz="{0}" ixy="0" ixz="0" '
        'iyz="0"/></inertial>'
    )
    point.write_text(
        f'<robot name="point"><link name="trunk">{inertial.format(1)}</link><link '
        f'name="leg">{inertial.format(0)}</link>'
        '<joint name="hip" type="continuous"><parent link="trunk"/><child '
        'link="leg"/></joint></robot>'
    )
    with pytest.raises(RobotError, match="leg"):
        flexible_robot(load_robot(str(point)), (("leg", Flex(EI=1.0)),))


# Landings


def peaks(scene, until=None):
    """Peaks of the forces of contacts [N], of the accelerations of points [g], and of torques [N
    m], by name.
    """
    found = CompliantLanding(resolve(scene, load_robot(scene.robot)), until)
    read = (
        (IMPULSE.compute, "contact", 1.0),
        (point_velocity, "point", GRAVITY),
        (ALONG.compute, "joint", 1.0),
    )
    named = ((found.landing.places(kind), compute, scale) for compute, kind, scale in read)
    return {
        place.name: float(value) / scale
        for places, compute, scale in named
        if places
        for place, value in zip(places, found.peaks(compute, places)[0], strict=True)
    }


def tube_leg(folder, stiffness, hinges):
    """The leg of frame elements, of rigid segments."""
    file = folder / "leg.urdf"
    file.write_text(tubes_urdf())
    return leg_scene(str(file), stiffness, hinges)


@pytest.mark.parametrize(
    ("stiffness", "few"),
    [pytest.param(1e4, 0.02, marks=pytest.mark.slow), (1e5, 0.01), (1e6, 0.05)],
)
def test_a_leg_of_tubes(tmp_path, stiffness, few):
    """Force and torque of the knee's rotor are those of frame elements with many hinges, and nearly
    so with two.
    """
    lifts, force, torque = frame_leg.strike(stiffness)
    for hinges, share in ((2, few), (12, 2e-3)):
        found = peaks(tube_leg(tmp_path, stiffness, hinges), lifts)
        assert found["foot"] == pytest.approx(force, rel=share)
        assert found["knee"] == pytest.approx(torque, rel=share)
    free = flexible_landing(
        resolve(tube_leg(tmp_path, stiffness, 12), load_robot(str(tmp_path / "leg.urdf")))
    ).elastic_frequencies()
    assert np.abs(free - frame_leg.first_frequency()).min() < 2e-3 * frame_leg.first_frequency()


TUBES = {"FL_calf": "EI:674", "FL_thigh": "EI:674"}
GO2 = Scene(
    robot="go2",
    contact=Contact(frame="FL_foot", restitution=1.0),
    joints=Joints(drives="go2"),
    contact_stiffness=1e6,
    gravity=False,
)


@pytest.mark.parametrize(
    ("flex", "force", "imu", "thigh", "calf", "share"),
    [
        ({}, 991.3, 6.07, 19.5, 89.3, 2e-3),
        (6, 512.9, 3.16, 33.3, 47.1, 2e-3),
        (2, 512.9, 3.16, 33.3, 47.1, 0.05),
    ],
)
def test_peaks_of_go2(flex, force, imu, thigh, calf, share):
    """Rigid and with the tubes of Go2, as of a second implementation: half the force, and more
    torque at the thigh.
    """
    links = {link: f"{tube},hinges:{flex}" for link, tube in TUBES.items()} if flex else {}
    found = peaks(replace(GO2, flex=links, joints=Joints(drives="go2", carried=False)), 0.012)
    names = "FL_foot", "imu", "FL_thigh_joint", "FL_calf_joint"
    np.testing.assert_allclose(
        [found[name] for name in names], [force, imu, thigh, calf], rtol=share
    )


@pytest.mark.slow
@pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("stiffness", [1e4, 1e7])
def test_four_feet_on_eight_links(stiffness, restitution):
    """96 springs, from those of stretch to those of bending: the motion is followed to its end, in
    few events.
    """
    links = dict.fromkeys(("*_calf", "*_thigh"), "tube:70e9,0.025,0.021,hinges:4")
    feet = tuple(
        Contact(frame=f"{leg}_foot", restitution=restitution) for leg in ("FL", "FR", "RL", "RR")
    )
    found = CompliantLanding(
        resolve(
            replace(GO2, contact=feet, contact_stiffness=stiffness, flex=links), load_robot("go2")
        )
    )
    assert len(found.moving.hinges) == 96
    assert found.motion.separated
    assert len(found.motion.events) <= 400


def test_stiff_links_are_rigid():
    """The stiffer the links, the nearer are all peaks to those of rigid ones while the foot is
    pressed: base, IMU and all legs.
    """
    scene = replace(GO2, contact_stiffness=2e3)
    rigid, stiff = (
        peaks(scene, 0.03),
        peaks(replace(scene, flex={"*": "EI:3e6,EA:1e10,GJ:3e6"}), 0.03),
    )
    assert rigid.keys() == stiff.keys()
    np.testing.assert_allclose(list(stiff.values()), list(rigid.values()), rtol=2e-3, atol=2e-3)


STRUCK = replace(
    GO2,
    contact=Contact(frame="FL_foot", restitution=0.5),
    contact_stiffness=1e5,
    contact_law="damper",
    gravity=True,
)
LOADED = {
    "standing": {"joints": Joints(drives="go2", motors="standing")},
    "standing feet": {"stance": ("RR_foot",)},
    "fixed base": {"base": "fixed", "strike": Strike(joint_velocities={"FL_calf_joint": 4.0})},
    "motor": {"joints": Joints(drives="go2", torque={"FL_calf_joint": 20.0})},
}
"""Landings in which gravity or motors load joints before touchdown."""


@pytest.mark.parametrize("case", LOADED)
def test_stiff_links_carry_what_rigid_ones_carry(case):
    """Peaks, and jumps beyond the fall, are those of rigid links: hinges carry from the start what
    they carried before.
    """
    scene = replace(STRUCK, **LOADED[case])
    stiff = replace(scene, flex={"*_calf": "EI:1e9", "*_thigh": "EI:1e9"})
    found = peaks(stiff)
    for name, value in peaks(scene).items():
        assert found[name] == pytest.approx(value, rel=0.01, abs=0.02), name
    rigid, bent = (shock_profile(one).value("shock_separated", "point") for one in (scene, stiff))
    np.testing.assert_allclose(bent, rigid, rtol=0.01)


def test_an_arm_that_bends_under_its_weight(tmp_path):
    """Force, acceleration, torques and the jump of an arm on a fixed base, as of an independent
    simulation in steps of time.
    """
    rod = link(
        "LINK",
        "1",
        '<origin xyz="0.25 0 0"/><inertia ixx="1e-4" iyy="{0}" izz="{0}" ixy="0" ixz="0" iyz="0"/>',
    )
    rod = rod.format(1.0 / 48.0 + 5e-5)
    file = tmp_path / "arm.urdf"
    file.write_text(
        urdf(
            '<link name="world"/><link name="tip"/><link name="imu"/>',
            *(rod.replace("LINK", name) for name in ("up", "fore")),
            joint("j1", "world", "up", more=LIMIT + '<origin xyz="0 0 1"/>'),
            joint("j2", "up", "fore", more=LIMIT + '<origin xyz="0.5 0 0"/>'),
            joint("at_tip", "fore", "tip", "fixed", more='<origin xyz="0.5 0 0"/>'),
            joint("at_imu", "up", "imu", "fixed", more='<origin xyz="0.4 0 0"/>'),
        )
    )
    scene = Scene(
        robot=str(file),
        base="fixed",
        contact=Contact(frame="tip", restitution=0.5),
        posture=Posture(joints_deg={"j1": 20.0, "j2": 30.0}),
        strike=Strike(joint_velocities={"j1": 1.0}),
        joints=Joints(armature={"*": 0.05}),
        point=(Point(frame="imu"),),
        contact_stiffness=1e4,
        contact_law="damper",
        flex={"up": "EI:300", "fore": "EI:300"},
    )
    found = peaks(scene)
    wanted = [49.566, 4.8607, 9.7318, 6.5048]
    np.testing.assert_allclose(
        [found[name] for name in ("tip", "imu", "j1", "j2")], wanted, rtol=1e-4
    )
    profile = shock_profile(scene)
    (imu,) = (k for k, place in enumerate(profile.places("point")) if place.name == "imu")
    assert profile.value("shock_separated", "point")[imu] == pytest.approx(0.5447, rel=2e-3)


def test_what_stays():
    """The impulse, names and rows are those of rigid links; a hinge is nobody's joint, whatever
    patterns mean.
    """
    scene = replace(
        GO2,
        joints=Joints(armature={"*": 0.01}),
        posture=Posture(joints={"*_calf_joint": -1.9}),
        gravity=True,
    )
    rigid, bent = (
        shock_profile(scene),
        shock_profile(
            replace(scene, flex={"*_calf": "EI:674", "FL_thigh": "tube:70e9,0.025,0.021"})
        ),
    )
    for entry in QUANTITIES:
        one, other = (profile.value(entry.key, entry.of) for profile in (rigid, bent))
        assert one.shape == other.shape, entry.key
        if entry.computation.exact == "always":
            np.testing.assert_array_equal(one, other, entry.key)
    moving = flexible_landing(bent.landing)
    hinges = moving.flexible.hinges
    assert len(hinges) == 4 * 2 * 2 + 2 * 3
    assert not moving.joint_model.armature[hinges].any()
    assert not moving.joint_model.locked[hinges].any()
    np.testing.assert_array_equal(moving.q, moving.flexible.configuration(bent.landing.q))
    assert np.count_nonzero(moving.q) == np.count_nonzero(bent.landing.q)
    text = json.dumps(document(bent), default=str)
    assert "*_calf" in text
    assert "~" not in text


def test_without_effect():
    """On rigid contacts links cannot bend; of links without flex there is nothing to multiply."""
    with pytest.raises(SceneError, match="contact_stiffness"):
        shock_profile(replace(GO2, contact_stiffness=None, gravity=True, flex=TUBES))
    with pytest.raises(SceneError, match=r"calf.*EI"):
        resolve(replace(GO2, flex={"FL_calf": "674"}), load_robot("go2"))
    with pytest.raises(RobotError, match=r"springs .* up to 240 are computed"):
        shock_profile(replace(GO2, flex={"*": "EI:674,hinges:30"}))
    with pytest.raises(RobotError, match=r"base.*no joint"):
        shock_profile(replace(GO2, flex={"base": "180Hz:clamped"}))
    with pytest.raises(SceneError, match=r"base.*fixed"):
        shock_profile(replace(GO2, base="fixed", flex={"base": "EI:5000"}))
    with pytest.raises(StudyError, match="flex:FL_calf"):
        sweep(GO2, {"flex:FL_calf": "0.5x:2x:3"}, quantities=["peak_force"])


def test_the_bent_links_that_are_drawn():
    """They are straight at first, from joint to joint and to the foot, and deflected across their
    axes, the more the farther on.
    """
    found = CompliantLanding(resolve(replace(GO2, flex=TUBES), load_robot("go2")))
    (calf, of_calf), (thigh, of_thigh) = bent_links(found)
    np.testing.assert_allclose(calf[0], thigh[-1], atol=1e-12)
    for points, off in ((calf, of_calf), (thigh, of_thigh)):
        axis = (points[-1] - points[0]) / np.linalg.norm(points[-1] - points[0])
        np.testing.assert_allclose(
            points, points[0] + np.outer((points - points[0]) @ axis, axis), atol=1e-12
        )
        np.testing.assert_allclose(off @ axis, 0.0, atol=1e-15)
        size = np.linalg.norm(off, axis=1)
        assert size[1] == 0.0 < size[2] < size[3] < 2e-3


def test_files(tmp_path):
    """A scene file has what Python has; an EA that is given goes over that of a tube, wherever it
    stands.
    """
    scene = replace(GO2, flex={"*_calf": "tube:70e9,0.025,0.021,EA:1e6", "FL_thigh": "EI:674"})
    file = tmp_path / "scene.toml"
    file.write_text(scene_text(scene, tmp_path))
    assert read_scene(file).flex == scene.flex
    assert flex_from("EA:1e6,tube:70e9,0.025,0.021") == flex_from("tube:70e9,0.025,0.021,EA:1e6")
    assert flex_from("tube:70e9,0.025,0.021,EA:1e6").EA == 1e6
    np.testing.assert_allclose(flex_from("tube:70e9,0.025,0").EI, 70e9 * np.pi * 0.025**4 / 64.0)


def test_variations():
    """A sweep sets EI of links, or multiplies all stiffnesses of those that bend; a row is the
    landing with that scene.
    """
    vary = {"flex:FL_calf": (300.0,), "flex:*_thigh": "0.5x,1x"}
    table = sweep(replace(GO2, flex=TUBES), vary, quantities=["peak_force"], prove=0).table
    for found, thigh in zip(table.columns["peak_force@FL_foot"], (337.0, 674.0), strict=True):
        scene = replace(GO2, flex={"FL_calf": "EI:300", "FL_thigh": f"EI:{thigh}"})
        assert found == pytest.approx(peaks(scene)["FL_foot"], rel=1e-9)


def test_varied_links_keep_other_stiffnesses_that_are_typed(capfd, tmp_path):
    """The option for links that bend is refused neither where it is given nor where it is not."""
    (tmp_path / "stick.urdf").write_text(STICK)
    words = f"sweep {tmp_path}/stick.urdf --contact foot --contact-stiffness 1e5 --prove 0"
    words += " --quantity peak_force@foot --vary flex:shin=50,100 --format csv"
    bent = good(capfd, *words.split())
    assert good(capfd, *words.split(), "--flex", "shin=EI:60,EA:1e4") != bent


@pytest.mark.slow
def test_measured_rates_identify_the_stiffness(capfd, tmp_path):
    """Rates after 2 ms, integrated from simulated accelerations with EI = 674, give that back, from
    a scene with 300.
    """
    table, t = (
        ["q_FL_thigh_joint,q_FL_calf_joint,vz,before_FL_calf_joint,after2ms_FL_calf_joint"],
        np.linspace(0.0, 2e-3, 4001),
    )
    scene = Scene(
        robot="go2",
        contact="FL_foot",
        contact_stiffness=1e6,
        contact_law="damper",
        flex={"FL_calf": "EI:674"},
    )
    for thigh, calf in ((45.0, -80.0), (40.0, -95.0), (57.0, -100.0)):
        posed = replace(
            scene, posture=Posture(joints_deg={"FL_thigh_joint": thigh, "FL_calf_joint": calf})
        )
        profile = shock_profile(posed)
        (joint,) = (place for place in profile.places("joint") if place.name == "FL_calf_joint")
        accelerations = profile.stiffness.history(select("delta_qd").quantity.compute, [joint], t)[
            :, 0, 0
        ]
        table.append(
            f"{np.radians(thigh)},{np.radians(calf)},-1,0,{np.trapezoid(accelerations, t)}"
        )
    (tmp_path / "landings.csv").write_text("\n".join(table))
    options = (
        "--contact FL_foot --contact-stiffness 1e6 --contact-law damper --flex FL_calf=EI:300 "
        "--unknown flex:FL_calf=100:3000"
    )
    found = good(
        capfd, "identify", tmp_path / "landings.csv", "go2", *options.split(), "--format", "json"
    )
    (unknown,) = json.loads(found)["tables"]["identify"]
    assert unknown["value"] == pytest.approx(674.0, rel=1e-4)


def test_a_landing_on_rigid_contacts_imports_no_motion(tmp_path):
    """What follows a landing over time would lengthen each command that needs none of it."""
    (tmp_path / "robot.urdf").write_text(STICK)
    code = (
        "import sys; from shockpc.cli.entry import main; main(sys.argv[1:]); "
        "sys.exit('shockpc.wings.compliant.over_time.compliant_landing' in sys.modules)"
    )
    words = ("analyze", str(tmp_path / "robot.urdf"), "--contact", "foot", "--format", "json")
    done = python(code, *words)
    assert (done.returncode, done.stderr) == (0, "")
