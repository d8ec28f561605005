"""Drives: what is known of robots by name, files of drives, readers, springs, and motors that hold
a speed.
"""

import json
import tomllib
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from commands import good, run
from robot_texts import LIMIT, body, floating, joint, link, mjcf, refused, urdf
from trees import known_robot, robot_from

from shockpc import (
    Contact,
    Joints,
    Posture,
    Rotor,
    Scene,
    SceneError,
    Strike,
    UnknownName,
    load_robot,
    read_scene,
    resolve,
    shock_profile,
)
from shockpc.evaluation.variations.vary import read_changes
from shockpc.impact.springs import spring_time, spring_times
from shockpc.landing.joint_model import joint_model
from shockpc.robot.bodies_and_joints import Drive
from shockpc.robot.catalogue import catalogue, find_robot, project_robots_folder
from shockpc.robot.changes import changed
from shockpc.robot.drives import drive_file as drives_module
from shockpc.robot.drives.drive_file import (
    catalogue_drives,
    drives_of,
    read_drive_file,
    robots_with_drives,
    similar_robots,
)
from shockpc.show.header import header_lines

GO2 = Contact(frame="FL_foot")


def land(robot, joints, **scene):
    return shock_profile(
        Scene(robot=robot, contact=GO2, joints=joints, **scene), known_robot(robot)
    )


# Robots of the catalogue


def test_every_drive_is_of_joints_of_its_robots_and_says_where_it_is_from():
    """Each drive of robots/drives.toml is valid, is read, and names robots and joints that exist,
    with its status.
    """
    names, read, all_drives = {entry.name for entry in catalogue()}, set(), set()
    for name in sorted(names):
        all_drives.update(tuple(vars(drive).values()) for drive in catalogue_drives(name))
        for drive in catalogue_drives(name):
            drives_of(known_robot(name), [drive], "drives")
            assert drive.status is not None
            assert drive.source
            assert set(drive.robot) <= names
            read.add(name)
    assert all_drives == {
        tuple(vars(drive).values())
        for drive in read_drive_file(project_robots_folder() / "drives.toml")
    }
    assert {"solo8", "solo12", "bolt", "go1", "go2", "g1", "icub", "hyq", "anymal_b", "a1"} <= read


@pytest.mark.parametrize(
    "joint", ['["*"]', "['*']", '["*"] # all of them', '[\n  "*",\n]', '\t["*"]']
)
def test_a_drive_of_the_catalogue_may_be_written_in_all_ways_of_toml(monkeypatch, tmp_path, joint):
    """Most values are read as JSON writes them; what TOML alone has gives the same drive."""
    (tmp_path / "drives.toml").write_text(
        f'[[drive]]\nrobot = ["a1"]\njoint = {joint}\narmature = 0.01 \nsource = "a = b"\n'
    )
    monkeypatch.setattr(drives_module, "project_robots_folder", lambda: tmp_path)
    for read in ("_tables", "_catalogue"):
        monkeypatch.setattr(drives_module, read, getattr(drives_module, read).__wrapped__)
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
        (
            "talos",
            {
                "leg_left_4_joint": 4.053,
                "leg_right_6_joint": 0.8777,
                "torso_2_joint": 2.073,
                "arm_left_7_joint": 0.1,
            },
        ),
        ("talos_left_arm", {"arm_left_2_joint": 1.405}),
        ("panda", {"panda_joint1": 0.6057, "panda_joint4": 0.4625, "panda_joint7": 0.2055}),
        ("tiago_pro", {"arm_left_2_joint": 0.253, "arm_right_7_joint": 0.1326}),
        ("cassie", {"hip_yaw_left": 0.038125, "knee_right": 0.09344, "toe_left": 0.01225}),
        ("hyq", {"*": 0.0}),
        ("anymal_b", {"*": 0.0}),
        ("a1", {"*": 0.0}),
    ],
)
def test_reflected_inertia_by_default(robot, reflected):
    """Rotor inertia times the squared ratio, from parts; nothing of simulation models, whose
    numbers in files they replace.
    """
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
    """Joints of which neither file, drives nor scene say anything: all of A1, HyQ's electric
    drives, none of Go2.
    """
    a1, hyq, go2 = map(known_robot, ("a1", "hyq", "go2"))
    assert joint_model(a1, Joints()).unknown.sum() == 12
    assert (
        joint_model(
            a1, Joints(armature={"*_calf_joint": 0.01}, locked=("*_hip_joint",))
        ).unknown.sum()
        == 4
    )
    unknown = joint_model(hyq, Joints()).unknown
    assert {name for name in hyq.joint_names if unknown[hyq.joint(name).v]} == set(
        hyq.match_joints("*_haa_joint")
    )
    assert not joint_model(go2, Joints()).unknown.any()


@pytest.mark.parametrize(
    ("robot", "joint", "share"),
    [
        ("go1", "FL_hip_joint", (0.5, 1.5)),  # derived
        ("g1", "left_knee_joint", (0.9, 1.1)),  # parts of the maker
        ("solo12", "FL_KFE", (0.8, 1.2)),  # rotor of the maker without its belts
        ("cassie", "toe_left", (0.8, 1.2)),
        ("talos", "leg_left_4_joint", (0.8, 1.5)),  # harmonic, from the rotor alone
        ("tiago_pro", "arm_left_3_joint", (0.9, 1.5)),
        ("hyq", "lf_hfe_joint", (1.0, 1.0)),  # hydraulic: none
    ],
)
def test_ranges_by_default(robot, joint, share):
    """By how a drive is known, as the head of robots/drives.toml has it."""
    model, v = joint_model(known_robot(robot), Joints()), known_robot(robot).joint(joint).v.start
    low, high = (part * model.armature[v] for part in share)
    assert (model.low[v], model.high[v]) == pytest.approx((low, high), rel=2e-2)


def test_published_drives_go_over_the_setting_of_a_simulator():
    """TALOS with its maker's rotors, values of another solution: its IMU and its mass; what the
    file gives stays without them.
    """
    scene = Scene(robot="talos", contact="left_sole_link", joints=Joints(carried=False))
    profile = shock_profile(scene, known_robot("talos"))
    assert profile.points[0].shock == pytest.approx(0.7357, abs=1e-4)
    assert float(profile.value("effective_mass", "contact")[0]) == pytest.approx(65.57, abs=0.01)
    assert (
        "published (the file's are a setting of a simulator)"
        in dict(header_lines(profile))["joint model"]
    )
    status = {
        name: source.status
        for source in profile.landing.joint_model.sources
        for name in source.joints
    }
    assert (status["leg_left_1_joint"], status["head_1_joint"], status["gripper_left_joint"]) == (
        "published",
        "simulation model",
        "unknown",
    )
    file = shock_profile(replace(scene, joints=Joints(drives="none")), known_robot("talos"))
    assert file.points[0].shock == pytest.approx(0.1049, abs=1e-4)
    assert np.isinf(
        file.landing.joint_model.high[known_robot("talos").joint("leg_left_1_joint").v]
    ).all()


def test_a_change_of_armature_changes_default_drives():
    """A factor multiplies them and their ranges; a number replaces them on its joints, and stays
    without default drives.
    """
    go2 = known_robot("go2")
    before = joint_model(go2, Joints()).armature
    twice = changed(go2, read_changes("armature:*=2x"))
    for part in ("low", "armature", "high"):
        expected = 2.0 * getattr(joint_model(go2, Joints()), part)
        np.testing.assert_allclose(getattr(joint_model(twice, Joints()), part), expected)
    calves = changed(go2, read_changes("armature:*_calf_joint=0.5"))
    of_calves = [go2.joint(name).v.start for name in go2.match_joints("*_calf_joint")]
    np.testing.assert_allclose(joint_model(calves, Joints()).armature[of_calves], 0.5)
    np.testing.assert_allclose(
        np.delete(joint_model(calves, Joints()).armature, of_calves), np.delete(before, of_calves)
    )
    none = joint_model(calves, Joints(drives="none")).armature
    assert (none > 0.0).sum() == 4
    talos = changed(known_robot("talos"), read_changes("armature:*=0.2"))
    # a number of the user is no setting of the file
    assert joint_model(talos, Joints()).high.max() == 0.2


@pytest.mark.parametrize(
    ("scale", "offered"), [(1.0, True), (1.4, True), (1.6, False), (0.6, False)]
)
def test_drives_are_offered_to_robots_of_about_the_same_mass(scale, offered):
    """By the names of joints and the mass: those of Go1 to its own file, and not to one of 1.6
    times its mass.
    """
    go1 = changed(known_robot("go1"), read_changes(f"mass:*={scale}x"))
    assert ("go1" in similar_robots(go1)) == offered


def test_masses_of_the_catalogue_are_those_of_its_robots():
    masses = tomllib.loads((project_robots_folder() / "drives.toml").read_text())["mass"]
    assert set(masses) == set(robots_with_drives())
    assert {name: known_robot(name).mass for name in masses} == pytest.approx(masses, rel=6e-3)


# Files of drives


def test_a_file_replaces_what_the_robot_says(tmp_path):
    """Later drives replace earlier ones; drives of other robots do not count; what the scene gives
    replaces both.
    """
    file = tmp_path / "drives.toml"
    file.write_text(
        '[[drive]]\njoint = ["*"]\narmature = 0.5\n[[drive]]\njoint = '
        '["*_calf_joint"]\nrotor_inertia = 1e-4\ngear_ratio = 10\n'
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
        ('[[drive]]\njoint = ["*"]\narmature = -1\n', SceneError, ("armature of -1",)),
        (
            '[[drive]]\njoint = ["*"]\narmature = 1\nstiffness = 0\n',
            SceneError,
            ("stiffness of 0", "above zero"),
        ),
        (
            '[[drive]]\njoint = ["*"]\narmature = [2, 1]\n',
            SceneError,
            ("armature", "2 to 1", "smaller number first"),
        ),
        (
            '[[drive]]\njoint = ["*"]\narmature = 1\nrange = [2, 3]\n',
            SceneError,
            ("inertia of 1", "range of 2 to 3"),
        ),
        (
            '[[drive]]\njoint = ["*"]\narmature = [1, 2]\nrange = [1, 2]\n',
            SceneError,
            ("range and an interval",),
        ),
        (
            '[[drive]]\njoint = ["*"]\nrotor_inertia = 1\ngear_ratio = [-9, 9]\n',
            SceneError,
            ("gear_ratio", "both signs"),
        ),
        (
            '[[drive]]\njoint = ["*"]\narmature = 1\nstatus = "unknown"\n',
            SceneError,
            ('unknown and "armature"',),
        ),
        ('[[drive]]\njoint = ["*"]\nrotor_inertia = 1\n', SceneError, ("gear_ratio",)),
        ('[[drive]]\njoint = ["*"]\ngear_ratio = 9\n', SceneError, ("neither",)),
        (
            '[[drive]]\njoint = ["*"]\narmature = 1\nstatus = "guess"\n',
            SceneError,
            ("published", "derived"),
        ),
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


@pytest.mark.parametrize(
    ("drive", "expected"),
    [
        ("armature = [0.005, 0.02]", (0.005, 0.0125, 0.02)),
        ("rotor_inertia = [1e-4, 3e-4]\ngear_ratio = [8, 10]", (64e-4, 2e-4 * 81.0, 3e-2)),
        ("rotor_inertia = 1e-4\ngear_ratio = [-10, -8]", (64e-4, 81e-4, 1e-2)),
        ("armature = 0.01\nrange = [0.005, 0.03]", (0.005, 0.01, 0.03)),
        ('armature = 0.01\nstatus = "identified"', (0.008, 0.01, 0.012)),
        ('armature = 0.01\nstatus = "simulation model"', (0.0, 0.01, np.inf)),
        ('gear_ratio = 9\nstatus = "unknown"', (0.0, 0.0, np.inf)),
        ("gear_ratio = 9\ndrive_stiffness = 100", (0.0, 0.0, np.inf)),
        ("armature = 0.01\ndrive_stiffness = 100", (0.0, 0.0, 0.0)),
        ("stiffness = 100", (0.0, 0.0, 0.0)),
    ],
)
def test_intervals_of_a_file(tmp_path, drive, expected):
    """Both ends, and the middle of their interval, of what counts in an instant: nothing behind a
    spring.
    """
    (tmp_path / "drives.toml").write_text(f'[[drive]]\njoint = ["*"]\n{drive}\n')
    model = joint_model(known_robot("go2"), Joints(drives=str(tmp_path / "drives.toml")))
    found = np.array([model.low[6:], model.armature[6:], model.high[6:]])
    np.testing.assert_allclose(
        found, np.repeat(np.array(expected)[:, None], 12, axis=1), rtol=1e-14
    )


def test_intervals_of_a_scene(capfd, tmp_path):
    """Typed, in a scene's file and in Python they are the same; the landing is that of their
    middle.
    """
    file, scene = tmp_path / "scene.toml", ("analyze", "go2", "--contact", "FL_foot")
    good(
        capfd,
        *scene,
        "--armature",
        "*_hip_joint=0.005:0.02",
        "--rotor",
        "*_calf_joint=[1e-4,3e-4]:[8,10]",
        "--save-scene",
        file,
    )
    rotor = Rotor(inertia=(1e-4, 3e-4), gear_ratio=(8.0, 10.0))
    joints = Joints(armature={"*_hip_joint": (0.005, 0.02)}, rotor={"*_calf_joint": rotor})
    assert read_scene(file).joints == joints
    middle = Joints(
        armature={"*_hip_joint": 0.0125},
        rotor={"*_calf_joint": Rotor(inertia=2e-4, gear_ratio=9.0)},
    )
    np.testing.assert_array_equal(land("go2", joints).delta_v, land("go2", middle).delta_v)
    model = joint_model(known_robot("go2"), joints)
    assert (model.low[6], model.high[6], model.low[8], model.high[8]) == pytest.approx(
        (0.005, 0.02, 64e-4, 3e-2), rel=1e-14
    )


@pytest.mark.parametrize(
    ("joints", "parts"),
    [
        (
            Joints(armature={"*": (0.02, 0.01)}),
            ("armature", "0.02 to 0.01", "smaller number first"),
        ),
        (Joints(armature={"*": (-0.01, 0.01)}), ("armature", "both signs")),
        (Joints(armature={"*": (-0.02, -0.01)}), ("-0.015", "above zero")),
        (Joints(rotor={"*": Rotor(inertia=1e-4, gear_ratio=(9.0, 6.0))}), ("gear ratio", "9 to 6")),
        (Joints(rotor={"*": Rotor(inertia=(1e-4, 1e9), gear_ratio=9e2)}), ("at most 1e+12",)),
    ],
)
def test_intervals_that_are_refused(joints, parts):
    refused(SceneError, parts, joint_model, known_robot("go2"), joints)


def test_robots_lists_drives_with_interval_status_and_source(capfd):
    """What is known; of what is not known also what the effort limits suggest: 1e-4 to 1e-3 kg m²
    for each of A1's 33.5 N m.
    """
    rows = json.loads(good(capfd, "robots", "go2", "--format", "json"))["tables"]["drives"]
    calves = next(row for row in rows if "FL_calf_joint" in row["joints"])
    assert (calves["low"], calves["armature"], calves["high"]) == pytest.approx(
        (0.0082, 1.11842e-4 * 12.13**2, 0.0247)
    )
    assert (calves["status"], "isaac-sim/IsaacLab" in calves["source"]) == ("derived", True)
    text = good(capfd, "robots", "a1")
    assert (
        "nothing is known; planetary drives of such effort limits have 0.0034 to 0.034 kg m²"
        in text
    )
    assert "*: 0.01 kg m² (0 to locked), simulation model, not used by default" in text


# Readers


def transmission(name, *parts):
    return (
        f'<transmission name="t_{name}"><joint name="{name}"/><actuator '
        f'name="a">{"".join(parts)}</actuator></transmission>'
    )


def test_drives_of_a_urdf():
    """RaiSim's inertia at the joint; Drake's and a transmission's at the rotor; a ratio alone is
    kept for --rotor.
    """
    robot = robot_from(
        urdf(
            *map(link, "abcdef"),
            joint(
                "raisim", "a", "b", more=f'<dynamics rotor_inertia="0.02" stiffness="300"/>{LIMIT}'
            ),
            *(
                joint(name, one, other)
                for name, one, other in (
                    ("drake", "b", "c"),
                    ("ros", "c", "d"),
                    ("ratio", "d", "e"),
                )
            ),
            joint("one", "e", "f"),
            transmission(
                "drake", '<drake:rotor_inertia value="1e-4"/>', '<drake:gear_ratio value="-30"/>'
            ),
            transmission(
                "ros",
                "<mechanicalReduction>20</mechanicalReduction>",
                "<motorInertia>1e-4</motorInertia>",
            ),
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
    refused(
        SceneError,
        ('"drake"', "gear ratio"),
        joint_model,
        robot,
        Joints(rotor={"drake": Rotor(inertia=1e-4)}),
    )


def test_springs_and_gears_of_an_mjcf():
    """A joint's stiffness is a spring of the joint; an actuator's gear without armature is a ratio
    without inertia.
    """
    hinges = (
        '<joint name="j" axis="0 1 0" stiffness="40" armature="0.1"/>',
        '<joint name="k" axis="0 1 0"/>',
    )
    text = mjcf(
        floating(body("b", joints=hinges[0]), body("c", joints=hinges[1])),
        after='<actuator><motor joint="k" gear="9"/></actuator>',
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
    return robot_from(
        urdf(
            link("trunk", ball),
            link("foot", foot),
            joint("leg", "trunk", "foot", "prismatic", "0 0 1"),
        )
    )


def hopping(joints):
    scene = Scene(robot="hopper", contact=Contact(frame="foot"), joints=joints, base="planar")
    return resolve(scene, hopper())


@pytest.mark.parametrize(
    ("joints", "mass"),
    [
        (Joints(stiffness={"leg": 5e3}), 20.0),
        (
            Joints(rotor={"leg": Rotor(inertia=0.03, gear_ratio=10.0, stiffness=5e3)}),
            20.0 * 3.0 / 23.0,
        ),
    ],
    ids=["spring of the joint", "spring behind the rotor"],
)
def test_springs_count_after_a_quarter_of_their_period(joints, mass):
    """T/4 = (π/2) √(m/k): the body on the spring, its foot on the ground; or body against rotor,
    with their reduced mass.
    """
    time = spring_times(hopping(joints))
    assert time[6] == pytest.approx(np.pi / 2.0 * np.sqrt(mass / 5e3), rel=1e-12)
    assert np.isinf(time[:6]).all()


@pytest.mark.parametrize(
    "joints",
    [
        Joints(stiffness={"*_calf_joint": 1e4}),
        Joints(rotor={"*": Rotor(inertia=1e-4, gear_ratio=9.0, stiffness=1e6)}),
    ],
)
def test_springs_give_no_impulse(joints):
    """A spring of a joint, and a rotor behind one, leave the impact as with free joints."""
    free, sprung = land("go2", Joints(drives="none")), land("go2", replace(joints, drives="none"))
    np.testing.assert_array_equal(free.delta_v, sprung.delta_v)
    assert spring_time(sprung.landing) < 0.05
    assert np.isinf(spring_time(free.landing))


@pytest.mark.parametrize(
    ("joints", "parts"),
    [
        (Joints(stiffness={"*": 0.0}), ("stiffness", '"*" is 0')),
        (
            Joints(rotor={"*": Rotor(inertia=1e-4, gear_ratio=9.0, stiffness=-1.0)}),
            ("stiffness", '"*" is -1'),
        ),
        (
            Joints(stiffness={"FL_hip_joint": 1.0}, locked=("FL_hip_joint",)),
            ('"FL_hip_joint" is locked', "spring"),
        ),
    ],
)
def test_springs_that_are_refused(joints, parts):
    refused(SceneError, parts, joint_model, known_robot("go2"), joints)


# Motors that hold a speed


def test_a_locked_joint_keeps_the_rate_that_it_has():
    """A motor that holds the speed of a joint is the limit of a rotor of great inertia that turns
    with it; it does work.
    """
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
    """By the names of joints: the same shocks; names that no joint has are said, and a robot like
    one of the catalogue says so.
    """
    file = tmp_path / "mine.urdf"
    file.write_bytes(find_robot("go1")[0].read_bytes())
    scene = Scene(
        robot=str(file),
        contact="FL_foot",
        posture=Posture(reference="neutral"),
        joints=Joints(drives="go1"),
    )
    mine = shock_profile(scene, load_robot(file))
    expected = shock_profile(replace(scene, robot="go1", joints=Joints()))
    np.testing.assert_allclose(mine.delta_v, expected.delta_v, rtol=0, atol=1e-12)
    assert "--drives go1" in good(capfd, "analyze", file, "--contact", "FL_foot")
    file.write_text(file.read_text().replace("calf_joint", "shin_joint"))
    part = shock_profile(scene, load_robot(file)).landing.joint_model
    assert 'none is named "*_calf_joint"' in part.drives
    assert {source.status for source in part.sources} == {"derived", "unknown"}
    assert part.sources[0].text.startswith("as go1's, by the names of joints: rotor: links *_rotor")
    assert part.unknown.sum() == 4
    for name, told in (
        ("foo", "no robot with known drives"),
        ("anymal_b", "has none of the joints of the drives of anymal_b"),
    ):
        outcome = run(capfd, "analyze", file, "--contact", "FL_foot", "--drives", name)
        assert (outcome.code, outcome.out) == (2, "")
        assert told in outcome.err
