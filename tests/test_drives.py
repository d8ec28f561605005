"""Drives: what is known of robots by name, files of drives, readers, springs, and motors that hold a speed."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from commands import good, run
from robot_texts import LIMIT, body, floating, joint, link, mjcf, refused, urdf
from trees import known_robot, robot_from

from shockpc import Contact, Joints, Posture, Rotor, Scene, SceneError, Strike, UnknownName, load_robot, resolve, shock_profile
from shockpc.impact.springs import spring_times
from shockpc.landing.joint_model import joint_model
from shockpc.robot.catalogue import catalogue, find_robot, project_robots_folder
from shockpc.robot.changes import changed, read_changes
from shockpc.robot.drives import catalogue_drives, drives_of, read_drives
from shockpc.robot.elements import Drive

GO2 = Contact(frame="FL_foot")


def land(robot, joints, **scene):
    return shock_profile(Scene(robot=robot, contact=GO2, joints=joints, **scene), known_robot(robot))


# Robots of the catalogue


def test_every_drive_is_of_joints_of_its_robots_and_says_where_it_is_from():
    """Each drive of robots/drives.toml is valid, is read, and names robots and joints that exist, with its status."""
    names, read, all_drives = {entry.name for entry in catalogue()}, set(), set()
    for name in sorted(names):
        all_drives.update(tuple(vars(drive).values()) for drive in catalogue_drives(name))
        for drive in catalogue_drives(name):
            drives_of(known_robot(name), [drive], "drives")
            assert drive.status is not None
            assert drive.source
            assert set(drive.robot) <= names
            read.add(name)
    assert all_drives == {tuple(vars(drive).values()) for drive in read_drives(project_robots_folder() / "drives.toml")}
    assert {"solo8", "solo12", "bolt", "go1", "go2", "g1", "icub", "hyq", "anymal_b", "a1"} <= read


@pytest.mark.parametrize("joint", ['["*"]', "['*']", '["*"] # all of them', '[\n  "*",\n]', '\t["*"]'])
def test_a_drive_of_the_catalogue_may_be_written_in_all_ways_of_toml(monkeypatch, tmp_path, joint):
    """Most values are read as JSON writes them; what TOML alone has gives the same drive."""
    (tmp_path / "drives.toml").write_text(f'[[drive]]\nrobot = ["a1"]\njoint = {joint}\narmature = 0.01 \nsource = "a = b"\n')
    monkeypatch.setattr("shockpc.robot.drives.project_robots_folder", lambda: tmp_path)
    (drive,) = catalogue_drives.__wrapped__("a1")
    assert vars(drive) == vars(Drive(joint=("*",), robot=("a1",), armature=0.01, source="a = b"))


@pytest.mark.parametrize(
    ("robot", "reflected"),
    [
        ("solo12", {"*": 4.5e-6 * 81}),
        ("bolt", {"*": 4.5e-6 * 81}),
        ("go2", {"*_hip_joint": 0.00448, "*_thigh_joint": 0.00448, "*_calf_joint": 0.01646}),
        ("go1", {"*_hip_joint": 0.00403, "*_thigh_joint": 0.00403, "*_calf_joint": 0.00906}),
        ("g1", {"*_knee_joint": 0.0251, "*_ankle_*": 0.00722, "waist_yaw_joint": 0.01018}),
        ("icub", {"[lr]_knee": 0.1367, "[lr]_hip_pitch": 0.3045}),
        ("talos", {"leg_left_4_joint": 0.1}),
        ("hyq", {"*": 0.0}),
        ("anymal_b", {"*": 0.0}),
        ("a1", {"*": 0.0}),
    ],
)
def test_reflected_inertia_by_default(robot, reflected):
    """Rotor inertia times the squared ratio, from parts; nothing of simulation models."""
    loaded = known_robot(robot)
    model = joint_model(loaded, Joints())
    for pattern, inertia in reflected.items():
        for name in loaded.match_joints(pattern):
            np.testing.assert_allclose(model.armature[loaded.joint(name).v], inertia, rtol=3e-3)


def test_default_drives_are_left_out_on_request():
    """A landing with `drives="none"` is the one with free joints; a file's armature stays."""
    free, none = land("go2", Joints(model="free")), land("go2", Joints(drives="none"))
    np.testing.assert_array_equal(free.delta_v, none.delta_v)
    assert land("go2", Joints()).shock_com[0] > 20.0 * free.shock_com[0]
    assert joint_model(known_robot("talos"), Joints(drives="none")).armature.max() == 0.1


def test_what_is_unknown():
    """Joints of which neither file, drives nor scene say anything: all of A1, HyQ's electric drives, none of Go2."""
    a1, hyq, go2 = map(known_robot, ("a1", "hyq", "go2"))
    assert joint_model(a1, Joints()).unknown.sum() == 12
    assert joint_model(a1, Joints(armature={"*_calf_joint": 0.01}, locked=("*_hip_joint",))).unknown.sum() == 4
    unknown = joint_model(hyq, Joints()).unknown
    assert {name for name in hyq.joint_names if unknown[hyq.joint(name).v]} == set(hyq.match_joints("*_haa_joint"))
    assert not joint_model(go2, Joints()).unknown.any()


def test_a_change_of_armature_changes_default_drives():
    """A factor multiplies them; a number replaces them on its joints, and stays without default drives."""
    go2 = known_robot("go2")
    before = joint_model(go2, Joints()).armature
    twice = changed(go2, read_changes("armature:*=2x"))
    np.testing.assert_allclose(joint_model(twice, Joints()).armature, 2.0 * before)
    calves = changed(go2, read_changes("armature:*_calf_joint=0.5"))
    of_calves = [go2.joint(name).v.start for name in go2.match_joints("*_calf_joint")]
    np.testing.assert_allclose(joint_model(calves, Joints()).armature[of_calves], 0.5)
    np.testing.assert_allclose(np.delete(joint_model(calves, Joints()).armature, of_calves), np.delete(before, of_calves))
    none = joint_model(calves, Joints(drives="none")).armature
    assert (none > 0.0).sum() == 4


# Files of drives


def test_a_file_replaces_what_the_robot_says(tmp_path):
    """Later drives replace earlier ones; drives of other robots do not count; what the scene gives replaces both."""
    file = tmp_path / "drives.toml"
    file.write_text(
        '[[drive]]\njoint = ["*"]\narmature = 0.5\n[[drive]]\njoint = ["*_calf_joint"]\nrotor_inertia = 1e-4\ngear_ratio = 10\n'
        '[[drive]]\nrobot = ["go1"]\njoint = ["*"]\narmature = 7\n'
    )
    go2 = known_robot("go2")
    model = joint_model(go2, Joints(drives=str(file), armature={"FL_hip_joint": 0.25}))
    values = {name: float(model.armature[go2.joint(name).v.start]) for name in go2.joint_names}
    assert values["FL_hip_joint"] == 0.25
    assert values["FR_hip_joint"] == 0.5
    assert values["FL_calf_joint"] == pytest.approx(0.01, rel=1e-15)
    assert model.drives == "drives of drives.toml"


@pytest.mark.parametrize(
    ("text", "error", "parts"),
    [
        ('[[drive]]\njoint = ["knee"]\narmature = 1\n', UnknownName, ('"knee"',)),
        ('[[drive]]\njoint = ["*"]\narmature = -1\n', SceneError, ("armature is -1",)),
        ('[[drive]]\njoint = ["*"]\narmature = 1\nstiffness = 0\n', SceneError, ("stiffness is 0", "above zero")),
        ('[[drive]]\njoint = ["*"]\nrotor_inertia = 1\n', SceneError, ("gear_ratio",)),
        ('[[drive]]\njoint = ["*"]\ngear_ratio = 9\n', SceneError, ("neither",)),
        ('[[drive]]\njoint = ["*"]\narmature = 1\nstatus = "guess"\n', SceneError, ("published", "derived")),
        ('[[drive]]\njoint = "*"\narmature = 1\n', SceneError, ("drive[0].joint", "list")),
        ('[[drive]]\nrobot = ["go1"]\njoint = ["*"]\narmature = 1\n', SceneError, ("go2",)),
        ("[[drives]]\n", SceneError, ("drive is missing",)),
        (None, SceneError, ("drives.toml",)),
    ],
)
def test_files_that_are_refused(tmp_path, text, error, parts):
    """The message names the file or the drive, and what would be valid."""
    file = tmp_path / "drives.toml"
    if text is not None:
        file.write_text(text)
    refused(error, parts, joint_model, known_robot("go2"), Joints(drives=str(file)))


# Readers


def transmission(name, *parts):
    return f'<transmission name="t_{name}"><joint name="{name}"/><actuator name="a">{"".join(parts)}</actuator></transmission>'


def test_drives_of_a_urdf():
    """RaiSim's inertia at the joint; Drake's and a transmission's at the rotor; a ratio alone is kept for --rotor."""
    robot = robot_from(
        urdf(
            *map(link, "abcdef"),
            joint("raisim", "a", "b", more=f'<dynamics rotor_inertia="0.02" stiffness="300"/>{LIMIT}'),
            *(joint(name, one, other) for name, one, other in (("drake", "b", "c"), ("ros", "c", "d"), ("ratio", "d", "e"))),
            joint("one", "e", "f"),
            transmission("drake", '<drake:rotor_inertia value="1e-4"/>', '<drake:gear_ratio value="-30"/>'),
            transmission("ros", "<mechanicalReduction>20</mechanicalReduction>", "<motorInertia>1e-4</motorInertia>"),
            transmission("ratio", "<mechanicalReduction> 50 </mechanicalReduction>"),
            transmission("one", "<mechanicalReduction>1</mechanicalReduction>"),
        )
    )
    model = joint_model(robot, Joints())
    np.testing.assert_allclose(model.armature[6:], [0.02, 0.09, 0.04, 0.0, 0.0], rtol=1e-14)
    assert robot.gear_ratios == {"ratio": 50.0, "one": 1.0}
    np.testing.assert_array_equal(model.stiffness[6:], [300.0, 0.0, 0.0, 0.0, 0.0])
    given = joint_model(robot, Joints(rotor={"ratio": Rotor(inertia=1e-4)}))
    assert given.armature[9] == pytest.approx(0.25, rel=1e-14)
    refused(SceneError, ('"drake"', "gear ratio"), joint_model, robot, Joints(rotor={"drake": Rotor(inertia=1e-4)}))


def test_springs_and_gears_of_an_mjcf():
    """A joint's stiffness is a spring of the joint; an actuator's gear without armature is a ratio without inertia."""
    hinges = '<joint name="j" axis="0 1 0" stiffness="40" armature="0.1"/>', '<joint name="k" axis="0 1 0"/>'
    text = mjcf(
        floating(body("b", joints=hinges[0]), body("c", joints=hinges[1])), after='<actuator><motor joint="k" gear="9"/></actuator>'
    )
    robot = robot_from(text, ".xml")
    model = joint_model(robot, Joints())
    assert (robot.springs, robot.gear_ratios) == ({"j": 40.0}, {"k": 9.0})
    np.testing.assert_array_equal(model.stiffness[6:], [40.0, 0.0])
    np.testing.assert_array_equal(model.armature[6:], [0.1, 0.0])


def test_ratios_of_a_pinocchio_model():
    """A ratio without rotorInertia is a ratio for `Rotor`."""
    model = pin.Model(known_robot("solo12").model)
    model.rotorGearRatio = np.full(model.nv, 9.0)
    rotor = np.zeros(model.nv)
    rotor[model.idx_vs[model.getJointId("FL_KFE")]] = 1e-5
    model.rotorInertia = rotor
    robot = load_robot(model)
    assert "FL_KFE" not in robot.gear_ratios
    assert robot.gear_ratios["FL_HFE"] == 9.0
    assert joint_model(robot, Joints()).armature.max() == pytest.approx(81e-5)


# Springs


def hopper(ball="20", foot="2"):
    """A body on a vertical prismatic leg."""
    return robot_from(urdf(link("trunk", ball), link("foot", foot), joint("leg", "trunk", "foot", "prismatic", "0 0 1")))


def hopping(joints):
    scene = Scene(robot="hopper", contact=Contact(frame="foot"), joints=joints, base="planar")
    return resolve(scene, hopper())


@pytest.mark.parametrize(
    ("joints", "mass"),
    [
        (Joints(stiffness={"leg": 5e3}), 20.0),
        (Joints(rotor={"leg": Rotor(inertia=0.03, gear_ratio=10.0, stiffness=5e3)}), 20.0 * 3.0 / 23.0),
    ],
    ids=["spring of the joint", "spring behind the rotor"],
)
def test_springs_count_after_a_quarter_of_their_period(joints, mass):
    """T/4 = (π/2) √(m/k): the body on the spring, its foot on the ground; or body against rotor, with their reduced mass."""
    time = spring_times(hopping(joints))
    assert time[6] == pytest.approx(np.pi / 2.0 * np.sqrt(mass / 5e3), rel=1e-12)
    assert np.isinf(time[:6]).all()


@pytest.mark.parametrize(
    "joints", [Joints(stiffness={"*_calf_joint": 1e4}), Joints(rotor={"*": Rotor(inertia=1e-4, gear_ratio=9.0, stiffness=1e6)})]
)
def test_springs_give_no_impulse(joints):
    """A spring of a joint, and a rotor behind one, leave the impact as with free joints."""
    free, sprung = land("go2", Joints(drives="none")), land("go2", replace(joints, drives="none"))
    np.testing.assert_array_equal(free.delta_v, sprung.delta_v)
    assert sprung.spring_time < 0.05
    assert np.isinf(free.spring_time)


@pytest.mark.parametrize(
    ("joints", "parts"),
    [
        (Joints(stiffness={"*": 0.0}), ("stiffness", '"*" is 0')),
        (Joints(rotor={"*": Rotor(inertia=1e-4, gear_ratio=9.0, stiffness=-1.0)}), ("stiffness", '"*" is -1')),
        (Joints(stiffness={"FL_hip_joint": 1.0}, locked=("FL_hip_joint",)), ('"FL_hip_joint" is locked', "spring")),
    ],
)
def test_springs_that_are_refused(joints, parts):
    refused(SceneError, parts, joint_model, known_robot("go2"), joints)


# Motors that hold a speed


def test_a_locked_joint_keeps_the_rate_that_it_has():
    """A motor that holds the speed of a joint is the limit of a rotor of great inertia that turns with it; it does work."""
    strike = Strike(joint_velocities={"*_thigh_joint": 3.0})
    locked = land("go2", Joints(drives="none", locked=("*_thigh_joint",)), strike=strike)
    heavy = land("go2", Joints(drives="none", armature={"*_thigh_joint": 1e7}), strike=strike)
    at_rest = land("go2", Joints(drives="none", locked=("*_thigh_joint",)))
    np.testing.assert_allclose(locked.delta_v, heavy.delta_v, atol=1e-6)
    assert np.abs(locked.delta_v - at_rest.delta_v).max() > 0.1
    assert np.isnan(locked.energy_lost)
    assert locked.energy_share is None
    assert np.isfinite(at_rest.energy_lost)


def test_drives_of_a_robot_of_the_catalogue_for_a_copy_of_it(capfd, tmp_path):
    """By the names of joints: the same shocks; names that no joint has are said, and a robot like one of the catalogue says so."""
    file = tmp_path / "mine.urdf"
    file.write_bytes(find_robot("go1")[0].read_bytes())
    scene = Scene(robot=str(file), contact="FL_foot", joints=Joints(drives="go1"))
    mine = shock_profile(scene, load_robot(file))
    expected = shock_profile(Scene(robot="go1", contact="FL_foot", posture=Posture(reference="neutral")))
    np.testing.assert_allclose(mine.delta_v, expected.delta_v, rtol=0, atol=1e-12)
    assert "--drives go1" in good(capfd, "analyze", file, "--contact", "FL_foot")
    file.write_text(file.read_text().replace("calf_joint", "shin_joint"))
    part = shock_profile(scene, load_robot(file)).landing.joint_model
    assert 'none is named "*_calf_joint"' in part.drives
    assert part.unknown.sum() == 4
    for name, told in (
        ("foo", "no robot with known drives"),
        ("anymal_b", "has no joint with a name that the drives of anymal_b have"),
    ):
        outcome = run(capfd, "analyze", file, "--contact", "FL_foot", "--drives", name)
        assert (outcome.code, outcome.out) == (2, "")
        assert told in outcome.err
