"""Loading robots: one object for one robot, whatever reads it, until one of its files changes."""

from pathlib import Path

import pytest
from robot_texts import BODY, arm, body, floating, link, mjcf, urdf, written, xacro

import shockpc
from shockpc import Scene, StudyError, UnknownName, load_robot, shock_profile
from shockpc.landing import resolve
from shockpc.scene import robot_of
from shockpc.studies.check.budgets import Budget, Budgets, Case
from shockpc.studies.check.gate import check_budgets

SRDF = '<robot name="r"><group_state name="standing" group="all"/></robot>'
PAYLOAD = xacro('<xacro:arg name="payload" default="1"/>', link("base", mass="$(arg payload)"))
HINGES = {name: f'<joint name="{name}_hinge" axis="0 1 0"/>' for name in "ab"}
DOGS = mjcf("".join(f'<body name="{n}"><freejoint/>{BODY}{body(n + "_foot", joints=HINGES[n])}</body>' for n in "ab"))


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
    written(tmp_path / "other", PAYLOAD.replace('default="1"', 'default="3"'), "dog.urdf.xacro")
    monkeypatch.chdir(tmp_path / "other")
    assert (here.mass, robot_of(Scene(robot="dog.urdf.xacro")).mass) == (1.0, 3.0)


@pytest.mark.parametrize(
    ("main", "name", "before", "after"),
    [
        (arm(), "dog.urdf", arm(), arm(tip=link("tip", mass="2"))),
        (arm(), "dog.srdf", "", SRDF),
        (arm(), "dog.srdf", SRDF, SRDF.replace("standing", "lying")),
        (xacro('<xacro:include filename="part.xacro"/>'), "part.xacro", urdf(link("base")), urdf(link("base", mass="2.5"))),
        ('<mujoco><include file="part.xml"/></mujoco>', "part.xml", mjcf(floating()), mjcf(floating(body("b")))),
    ],
    ids=["robot", "new SRDF", "SRDF", "xacro include", "MJCF include"],
)
def test_a_robot_is_loaded_again_when_one_of_its_files_changes(tmp_path: Path, main: str, name: str, before: str, after: str):
    def load() -> tuple[float, list[str]]:
        robot = robot_of(Scene(robot=path))
        assert robot_of(Scene(robot=path)) is robot
        return robot.mass, list(robot.postures)

    path = written(tmp_path, main, "dog.urdf" if "<link" in main else "dog.xml" if "mujoco" in main else "dog.xacro")
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
    """A second case on another robot of the file was refused, because it was looked for in the first one."""
    path = written(tmp_path, DOGS, "dogs.xml")
    cases = tuple(Case(name=name, scene=Scene(robot=path, contact=f"{name}_foot")) for name in "ab")
    check = check_budgets(Budgets(None, cases, (Budget(at="*_foot", metric="effective_mass", min=0.0),), ()))
    for case in cases:
        profile = shock_profile(case.scene, load_robot(path, frames=[f"{case.name}_foot"]))
        (value,) = [value for key, value in check.values.items() if key.case == case.name]
        assert value == profile.contacts[0].mass_sticking
    with pytest.raises(StudyError, match='"a" and "b" are of different robots'):
        shockpc.place({case.name: case.scene for case in cases})


def test_an_unknown_joint_is_refused_with_the_nearest():
    with pytest.raises(UnknownName, match=r'no joint "LF_HF".*nearest: "LF_HFE"'):
        load_robot("anymal_b").joint("LF_HF")


def test_a_second_landing_reads_no_file(monkeypatch: pytest.MonkeyPatch):
    """Sixteen scenes were searched for one that closes the robot's loop, at every landing."""
    scene = Scene(robot="skippy", contact="toe")
    first = resolve(scene, robot_of(scene))
    monkeypatch.setattr("pathlib.Path.open", lambda *_: pytest.fail("a file is read"))
    assert resolve(scene, first.robot).warnings[0].text == first.warnings[0].text
