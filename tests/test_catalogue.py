"""Names: every file of the data package has exactly one, and a person would guess it."""

import os
from pathlib import Path

import pytest
from commands import good
from robot_texts import refused

from shockpc import RobotError, UnknownName
from shockpc.robot.catalogue import (
    catalogue,
    data_folder,
    find_robot,
    find_srdf,
    project_robots_folder,
)


def test_every_robot_file_has_one_name():
    """Each URDF and xacro of the data package, and each own model, is listed exactly once."""
    share = data_folder()
    assert share is not None
    files = [
        *share.rglob("*.urdf"),
        *share.rglob("*.xacro"),
        *project_robots_folder().glob("*.urdf.xacro"),
    ]
    files.append(project_robots_folder() / "cassie.xml")
    assert len(files) > 70
    assert sorted(files) == sorted(entry.path for entry in catalogue())


def test_names_are_unique_and_normalised():
    """No name or alias means two robots; each is lower case without '-', and finds its entry."""
    names = [name for entry in catalogue() for name in (entry.name, *entry.aliases)]
    assert len(names) == len(set(names))
    assert names == [name.lower().replace("-", "_") for name in names]
    for entry in catalogue():
        for name in (entry.name, *entry.aliases):
            assert find_robot(name) == (entry.path, entry.name)


@pytest.mark.parametrize(
    ("typed", "file"),
    [
        ("ANYmal-C", "anymal_c_simple_description/urdf/anymal.urdf"),
        ("anymal-kinova", "anymal_b_simple_description/robots/anymal-kinova.urdf"),
        ("b1_z1", "b1_description/urdf/b1-z1.urdf"),
        ("hyq", "hyq_description/robots/hyq_no_sensors.urdf"),
        ("solo8", "solo_description/robots/solo.urdf"),
        ("talos_full", "talos_data/robots/talos_full_v2.urdf"),
        ("g1_hands", "g1_description/urdf/g1_29dof_with_hand_rev_1_0.urdf"),
        ("ur5", "ur_description/urdf/ur5_robot.urdf"),
    ],
)
def test_names_that_people_type(typed: str, file: str):
    """A short name in any case, with '-' or '_', is the robot that one means."""
    assert find_robot(typed)[0].as_posix().endswith(f"/robots/{file}")


def test_an_own_mjcf_has_a_name(capfd):
    """Cassie lands on a foot by name as by file, with its rotors."""
    file = find_robot("cassie")[0]
    words = ("--contact", "left-foot", "--format", "csv")
    assert good(capfd, "analyze", "cassie", *words) == good(capfd, "analyze", file, *words)


def test_own_quadruped_wins_its_name():
    """The name "quadruped" is the project's; the one of the data package goes by another name."""
    assert find_robot("quadruped") == (
        project_robots_folder() / "quadruped.urdf.xacro",
        "quadruped",
    )
    assert find_robot("quadroped")[1] == "quadruped_8dof"


def test_existing_file_wins_over_a_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """A path that exists is taken as it is; without separator and suffix it is a name."""
    monkeypatch.chdir(tmp_path)
    for name in ("hyq.urdf", "hyq"):
        (tmp_path / name).write_text("<robot/>")
    assert find_robot("hyq.urdf") == (Path("hyq.urdf"), None)
    assert find_robot("./hyq") == (Path("hyq"), None)
    assert find_robot("hyq")[1] == "hyq"


@pytest.mark.parametrize("typed", ["dog.urdf", "dog.urdf.xacro", "dog.toml", "some/dog"])
def test_what_is_not_there(typed: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """What looks like a path is a missing file; a slip in a name shows the nearest names and how to
    list all.
    """
    monkeypatch.chdir(tmp_path)
    refused(
        RobotError,
        [f'no file "{typed}" (looked in {tmp_path}). Give the path', "shockpc robots"],
        find_robot,
        typed,
    )
    near = (
        'no robot "anymal_d"; nearest: "anymal_c", "anymal_b", "anymal_kinova". To list them: '
        "shockpc robots"
    )
    refused(UnknownName, [near], find_robot, "anymal_d")


def test_every_robot_finds_its_srdf():
    """47 find one near their file, whose name begins with that of the SRDF, or that is alone in
    beginning with it; no other's.
    """
    found = {entry: srdf for entry in catalogue() if (srdf := find_srdf(entry.path, ""))}
    assert len(found) == 47
    for entry, srdf in found.items():
        near = {"baxter": "baxter_manipulation", "ur3_empty": "ur3_gripper"}
        assert entry.path.stem.startswith(srdf.stem) or srdf.stem == near.get(entry.name), (
            entry.name
        )
        assert {entry.path.parent.parent, entry.path.parent} & {*srdf.parents}


@pytest.mark.parametrize("place", [".", "srdf", "../srdf"])
def test_srdf_beside_the_robot(place: str, tmp_path: Path):
    """An SRDF is looked for beside the robot file, in ./srdf and in ../srdf; the longest beginning
    of the name wins.
    """
    robot = tmp_path / "urdf" / "dog_heavy.urdf.xacro"
    folder = Path(os.path.normpath(robot.parent / place))
    for folder_needed in (robot.parent, folder):
        folder_needed.mkdir(parents=True, exist_ok=True)
    for stem in ("d", "dog", "cat", "dog_heavy_duty"):
        (folder / f"{stem}.srdf").write_text("<robot/>")
    assert find_srdf(robot, "") == folder / "dog.srdf"
    (folder / "dog_heavy.srdf").write_text("<robot/>")
    assert find_srdf(robot, "") == folder / "dog_heavy.srdf"
    # Where the file's name fits no SRDF, the robot's name may.
    assert find_srdf(robot.with_name("model.urdf"), "dog") == folder / "dog.srdf"
    assert find_srdf(robot.with_name("model.urdf"), "horse") is None
