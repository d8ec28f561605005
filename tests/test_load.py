"""Loading robots: one object for one robot, whatever reads it, until one of its files changes."""

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from robot_texts import (
    BODY,
    LIMIT,
    arm,
    body,
    floating,
    joint,
    link,
    mjcf,
    refused,
    urdf,
    written,
    xacro,
)

import shockpc
from shockpc import (
    Contact,
    Joints,
    RobotError,
    Scene,
    StudyError,
    UnknownName,
    load_robot,
    shock_profile,
)
from shockpc.evaluation.budgets import Budget, Budgets, Case
from shockpc.evaluation.variations.vary import read_changes
from shockpc.landing.resolve import resolve
from shockpc.landing.scenes.scene_file import robot_of
from shockpc.robot.catalogue import SETS, data_folder
from shockpc.robot.changes import changed
from shockpc.robot.shapes.geometry import outline
from shockpc.studies.check.study import check_budgets

SRDF = '<robot name="r"><group_state name="standing" group="all"/></robot>'
PAYLOAD = xacro('<xacro:arg name="payload" default="1"/>', link("base", mass="$(arg payload)"))
HINGES = {name: f'<joint name="{name}_hinge" axis="0 1 0"/>' for name in "ab"}
DOGS = mjcf(
    "".join(
        f'<body name="{n}"><freejoint/>{BODY}{body(n + "_foot", joints=HINGES[n])}</body>'
        for n in "ab"
    )
)


def test_scenes_of_one_robot_share_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """File, xacro arguments, packages and SRDF make a robot; the landing does not."""
    path = written(tmp_path, PAYLOAD, "dog.urdf.xacro")
    plain = robot_of(Scene(robot=path))
    assert robot_of(Scene(robot=path, contact="base", v_in="com")) is plain
    heavy = robot_of(Scene(robot=path, xacro={"payload": "2"}))
    assert (plain.mass, heavy.mass) == (1.0, 2.0)
    assert robot_of(Scene(robot=path, packages={"other": str(tmp_path)})) is not plain
    assert robot_of(Scene(robot=path, srdf=written(tmp_path, SRDF, "more.srdf"))).postures
    monkeypatch.chdir(tmp_path)
    here = robot_of(Scene(robot="dog.urdf.xacro"))
    (tmp_path / "other").mkdir()
    there = written(tmp_path / "other", PAYLOAD, "dog.urdf.xacro")
    monkeypatch.chdir(tmp_path / "other")
    assert robot_of(Scene(robot="dog.urdf.xacro")).label == there != here.label


@pytest.mark.parametrize(
    ("main", "name", "before", "after"),
    [
        (arm(), "dog.urdf", arm(), arm(tip=link("tip", mass="2"))),
        (arm(), "dog.srdf", "", SRDF),
        (arm(), "dog.srdf", SRDF, SRDF.replace("standing", "lying")),
        (
            xacro('<xacro:include filename="part.xacro"/>'),
            "part.xacro",
            urdf(link("base")),
            urdf(link("base", mass="2.5")),
        ),
        (
            '<mujoco><include file="part.xml"/></mujoco>',
            "part.xml",
            mjcf(floating()),
            mjcf(floating(body("b"))),
        ),
    ],
    ids=["robot", "new SRDF", "SRDF", "xacro include", "MJCF include"],
)
def test_a_robot_is_loaded_again_when_one_of_its_files_changes(
    tmp_path: Path, main: str, name: str, before: str, after: str
):
    def load() -> tuple[float, list[str]]:
        robot = robot_of(Scene(robot=path))
        assert robot_of(Scene(robot=path)) is robot
        return robot.mass, list(robot.postures)

    path = written(
        tmp_path,
        main,
        "dog.urdf" if "<link" in main else "dog.xml" if "mujoco" in main else "dog.xacro",
    )
    if before:
        written(tmp_path, before, name)
    first = load()
    written(tmp_path, after, name)
    assert load() != first


def test_place_refuses_one_file_with_two_arguments(tmp_path: Path):
    """The second landing was computed with the first one's robot."""
    path = written(tmp_path, PAYLOAD, "dog.urdf.xacro")
    scenes = {mass: Scene(robot=path, xacro={"payload": mass}, contact="base") for mass in "12"}
    with pytest.raises(StudyError, match='"1" and "2" are of different robots'):
        shockpc.place(scenes)


def test_check_computes_each_robot_of_an_mjcf(tmp_path: Path):
    """A second case on another robot of the file was refused, because it was looked for in the
    first one.
    """
    path = written(tmp_path, DOGS, "dogs.xml")
    cases = tuple(
        Case(name=name, robot=path, contact=(Contact(frame=f"{name}_foot"),)) for name in "ab"
    )
    check = check_budgets(
        Budgets(None, cases, (Budget(at="*_foot", metric="effective_mass", min=0.0),), ())
    )
    for case in cases:
        profile = shock_profile(case.landings[0][1], load_robot(path, frames=[f"{case.name}_foot"]))
        (value,) = [value for key, value in check.values.items() if key.case == case.name]
        assert value == profile.contacts[0].effective_mass_sticking
    with pytest.raises(StudyError, match='"a" and "b" are of different robots'):
        shockpc.place({case.name: case.landings[0][1] for case in cases})


def test_an_unknown_joint_is_refused_with_the_nearest():
    with pytest.raises(UnknownName, match=r'no joint "LF_HF".*nearest: "LF_HFE"'):
        load_robot("anymal_b").joint("LF_HF")


def test_a_second_landing_reads_no_file(monkeypatch: pytest.MonkeyPatch):
    """Sixteen scenes were searched for one that closes the robot's loop, at every landing."""
    scene = Scene(robot="skippy", contact="toe")
    first = resolve(scene, robot_of(scene))
    monkeypatch.setattr("pathlib.Path.open", lambda *_: pytest.fail("a file is read"))
    assert resolve(scene, first.robot).warnings[0].text == first.warnings[0].text


# Robots that other libraries loaded

ROBOTS = [
    name
    for name in (*SETS["quadrupeds"], *SETS["bipeds"], "panda", "pr2", "tiago_pro")
    if not name.startswith(("romeo", "icub", "alex"))
]
"""Without those that cannot be landed on their last body, and icub, whose condition of 1e19 shows
the last bit of an angle.
"""


@pytest.mark.slow
@pytest.mark.parametrize("name", [*ROBOTS, "romeo_small", "icub_reduced"])
def test_three_ways_to_load_a_robot_give_the_same_jumps(name: str):
    """By name, as a yourdfpy.URDF, and as a pinocchio.Model that Pinocchio's parser read."""
    import yourdfpy  # takes a second

    robot = load_robot(name)
    path, srdf = (
        str(robot.source.path),
        None if robot.source.srdf is None else str(robot.source.srdf),
    )
    # a model has no geometry
    contact = Contact(frame=robot.bodies[-1].name, at="frame", kind="point")
    scene = Scene(robot=name, contact=contact, joints=Joints(drives="none"))  # known by name alone
    expected = shock_profile(scene, robot)
    others = [
        load_robot(yourdfpy.URDF.load(path, load_meshes=False, build_scene_graph=False), srdf=srdf)
    ]
    if not robot.mimics:  # which Pinocchio reads as independent joints
        others.append(
            load_robot(pin.buildModelFromUrdf(path, pin.JointModelFreeFlyer()), srdf=srdf)
        )
    for other in others:
        profile = shock_profile(scene, other)
        assert profile.bodies == expected.bodies
        np.testing.assert_allclose(profile.maps, expected.maps, rtol=0.0, atol=1e-12)
        np.testing.assert_array_equal(
            [joint.limits for joint in other.joints],
            [joint.limits for joint in robot.joints],
            err_msg="limits",
        )


@pytest.mark.slow
def test_a_geometry_model_gives_the_shapes_of_the_file():
    """Boxes, cylinders and capsules of the collision model, and meshes by the names of their files."""
    expected, path = (
        outline(load_robot("anymal_b"), "collision"),
        str(load_robot("anymal_b").source.path),
    )
    model = pin.buildModelFromUrdf(path, pin.JointModelFreeFlyer())
    geometry = pin.buildGeomFromUrdf(
        model, path, pin.GeometryType.COLLISION, package_dirs=[str(data_folder().parent)]
    )
    shapes = outline(load_robot(model, geometry=geometry), "collision")
    assert shapes.warnings == ()
    for expected_shapes, other in zip(expected.shapes, shapes.shapes, strict=True):
        for ours, theirs in zip(expected_shapes, other, strict=True):
            np.testing.assert_allclose(theirs.points, ours.points, atol=1e-15)
            np.testing.assert_allclose(theirs.rounding, ours.rounding, atol=1e-15)
    geometry = pin.buildGeomFromUrdf(
        model, path, pin.GeometryType.VISUAL, package_dirs=[str(data_folder().parent)]
    )
    shapes = outline(load_robot(model, geometry=geometry), "collision")
    assert shapes.warnings == ()
    assert all(
        any(shape.mesh is not None for shape in expected_shapes)
        for expected_shapes in shapes.shapes
    )


def test_a_model_built_by_hand_needs_no_frames(tmp_path: Path):
    """Its bodies are called like their joints; rotors become armature, and changes of a link's mass
    change the body's.
    """
    text = urdf(
        link("base"),
        link("tip"),
        joint("elbow", "base", "tip", more='<origin xyz="0 0 1"/>' + LIMIT),
    )
    from_file = load_robot(written(tmp_path, text))
    model = pin.Model()
    base = model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "base")
    tip = model.addJoint(
        base, pin.JointModelRY(), pin.SE3(np.eye(3), np.array([0.0, 0.0, 1.0])), "tip"
    )
    for index in (base, tip):
        model.appendBodyToJoint(
            index, pin.Inertia(1.0, np.zeros(3), 0.1 * np.eye(3)), pin.SE3.Identity()
        )
    model.rotorInertia[6], model.rotorGearRatio[6] = 1e-4, 10.0
    robot = load_robot(model)
    assert (robot.free_base, robot.links, robot.model.armature[6]) == (
        True,
        ("base", "tip"),
        pytest.approx(1e-2, rel=1e-15),
    )
    assert model.armature[6] == 0.0
    scene = Scene(robot="arm", contact="tip", joints=Joints(armature={"*": 1e-2}))
    heavier = [changed(one, read_changes("mass:tip=2")) for one in (from_file, robot)]
    for first, other in ((from_file, robot), heavier):
        np.testing.assert_allclose(
            shock_profile(scene, other).maps, shock_profile(scene, first).maps, atol=1e-14
        )


def helical():
    model = pin.buildSampleModelHumanoid()
    model.addJoint(1, pin.JointModelHX(0.1), pin.SE3.Identity(), "screw")
    return model


def mimicking():
    path = str(load_robot("panda").source.path)
    return pin.buildModelFromUrdf(path, pin.JointModelFreeFlyer(), mimic=True)


def displaced():
    model = pin.Model()
    model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Random(), "base")
    return model


def composite():
    joint = pin.JointModelComposite(pin.JointModelRX())
    joint.addJoint(pin.JointModelRY())
    model = pin.Model()
    model.addJoint(0, joint, pin.SE3.Identity(), "roll+pitch")
    return model


@pytest.mark.parametrize(
    ("build", "options", "parts"),
    [
        (helical, {}, ['"screw"', "JointModelHX"]),
        (mimicking, {}, ['"panda_finger_joint2"', "JointModelMimic", "URDF"]),
        (displaced, {}, ['"base"', "identity"]),
        (composite, {}, ['"roll+pitch"', "rename it"]),
        (pin.Model, {}, ["no joint"]),
        (pin.buildSampleModelHumanoid, {"xacro": {"a": "1"}}, ["xacro", "no effect"]),
        (lambda: "anymal_b", {"geometry": pin.GeometryModel()}, ["pinocchio.Model"]),
        (lambda: 3, {}, ["builtins.int", "yourdfpy.URDF"]),
    ],
)
def test_what_is_not_computed_of_other_libraries_is_refused(build, options, parts):
    refused(RobotError, parts, lambda: load_robot(build(), **options))
