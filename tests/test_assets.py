"""Meshes and included files: found wherever they may be, and never outside the folders that may be
read.
"""

from pathlib import Path
from typing import Any

import pytest
from robot_texts import arm, refused

from shockpc import RobotError
from shockpc.robot.catalogue import data_folder
from shockpc.robot.files import reading
from shockpc.robot.files.reading import open_folders
from shockpc.robot.formats import read_source
from shockpc.robot.robot import RobotSource


@pytest.fixture
def dog(tmp_path: Path) -> Path:
    """A package as ROS lays it out: dog_description/{urdf,meshes,package.xml}; returns its folder."""
    package = tmp_path / "ws" / "dog_description"
    for folder in ("urdf", "meshes"):
        (package / folder).mkdir(parents=True)
    (package / "package.xml").write_text("<package><name>dog_description</name></package>")
    (package / "urdf" / "dog.urdf").write_text(arm())
    (package / "meshes" / "trunk one.stl").write_text("solid")
    (tmp_path / "secret.stl").write_text("solid")
    return package


def read(package: Path, **given: Any) -> RobotSource:
    """Read the dog."""
    return read_source(str(package / "urdf" / "dog.urdf"), **given)


@pytest.mark.parametrize(
    "uri",
    [
        "package://dog_description/meshes/trunk one.stl",
        "package:///dog_description/meshes/trunk one.stl",
        "model://dog_description/meshes/trunk one.stl",
        "file://{package}/meshes/trunk one.stl",
        "file://{package}/meshes/trunk%20one.stl",
        "file://localhost{package}/meshes/trunk one.stl",
        "{package}/meshes/trunk one.stl",
        "../meshes/trunk one.stl",
        "../urdf/../meshes/trunk one.stl",
        "package:///../meshes/trunk one.stl",
    ],
)
def test_every_way_to_name_a_mesh(uri: str, dog: Path):
    """package://, file://, absolute and relative names lead to the same file."""
    assert read(dog).folders.asset(uri.format(package=dog)) == dog / "meshes" / "trunk one.stl"


@pytest.mark.parametrize("uri", ["package:///paw.stl", "package:///parts/paw.stl"])
def test_an_empty_package_is_the_folder_of_the_file(uri: str, dog: Path):
    """A file there, or where there is none, a message that names it and not a package."""
    place = dog / "urdf" / uri.removeprefix("package:///")
    refused(
        RobotError,
        ["--package parts=DIR" if "parts" in uri else "is missing"],
        read(dog).folders.asset,
        uri,
    )
    place.parent.mkdir(exist_ok=True)
    place.touch()
    assert read(dog).folders.asset(uri) == place


def test_data_package_is_its_own_package_root():
    """Meshes of example-robot-data resolve through its share folder, with three slashes too."""
    source, share = read_source("talos"), data_folder()
    assert share is not None
    assert source.folders.allowed == (share.resolve(),)
    inside = "robots/talos_data/meshes/torso/torso_1.STL"
    for slashes in ("//", "///"):
        assert (
            source.folders.asset(f"package:{slashes}example-robot-data/{inside}")
            == share.resolve() / inside
        )


@pytest.mark.parametrize("name", ["urdf", "xacro", "mjcf"])
def test_package_without_package_xml(name: str, tmp_path: Path):
    """Without package.xml a folder called urdf, xacro or mjcf still lies inside its package."""
    robot, mesh = tmp_path / "dog" / name / "dog.urdf", tmp_path / "dog" / "meshes" / "a.stl"
    for path in (robot, mesh):
        path.parent.mkdir(parents=True)
        path.write_text(arm())
    folders = read_source(str(robot)).folders
    assert folders.allowed == (tmp_path / "dog",)
    assert [folders.asset(uri) for uri in ("../meshes/a.stl", "package://dog/meshes/a.stl")] == [
        mesh
    ] * 2


def test_meshes_are_found_by_their_names(tmp_path: Path):
    """What is not where it is named, in the folder of meshes or below: the path that ends alike,
    and no guess between two.
    """
    (tmp_path / "robot").mkdir()
    (tmp_path / "robot" / "dog.urdf").write_text(arm())
    for place in ("visual", "collision", "a/legs", "b/legs"):
        (tmp_path / "own" / place).mkdir(parents=True)
        (tmp_path / "own" / place / ("paw.stl" if "legs" in place else "trunk.stl")).write_text(
            "solid"
        )
    given = {"*": str(tmp_path / "own")}
    folders = read_source(str(tmp_path / "robot" / "dog.urdf"), packages=given).folders
    assert (
        folders.asset("package://dog/meshes/visual/trunk.stl")
        == tmp_path / "own" / "visual" / "trunk.stl"
    )
    assert (
        folders.asset("file:///gone/collision/trunk.stl")
        == tmp_path / "own" / "collision" / "trunk.stl"
    )
    refused(
        RobotError,
        ["a/legs/paw.stl", "b/legs/paw.stl"],
        folders.asset,
        "package://dog/legs/paw.stl",
    )
    refused(
        RobotError,
        ['no package "dog"', "nor is a file of this name", str(tmp_path / "own")],
        folders.asset,
        "package://dog/tail.stl",
    )
    refused(
        RobotError,
        ["--meshes DIR", "nowhere"],
        open_folders,
        tmp_path / "robot" / "dog.urdf",
        {"*": "nowhere"},
    )


def test_files_are_read_while_another_thread_asks_whether_they_changed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """Quantities read the meshes of a robot late, which many threads may share."""
    folders = open_folders(tmp_path / "robot" / "dog.urdf", {})
    for name in "ab":
        folders.note(tmp_path / name)
    state = reading._state

    def read_more(path: Path, whole: bool):
        folders.seen[path / "more"] = None
        return state(path, whole)

    monkeypatch.setattr(reading, "_state", read_more)
    assert folders.unchanged()
    assert len(folders.seen) == 4


@pytest.mark.parametrize("entry", ["ws2", "ws2/parts", ".", None])
def test_packages_of_ros_package_path_or_given_by_name(
    entry: str | None, dog: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """The path lists packages, folders of packages, or workspaces; what it lists may be read; one
    given by name comes first.
    """
    parts = tmp_path / "ws2" / "parts"
    parts.mkdir(parents=True)
    (parts / "a.stl").write_text("solid")
    given = {"parts": str(parts), "dog_description": parts} if entry is None else {}
    monkeypatch.setenv(
        "ROS_PACKAGE_PATH", f"{tmp_path / 'nowhere'}:{tmp_path / entry if entry else ''}:"
    )
    folders = read(dog, packages=given).folders
    assert folders.allowed == (dog, parts if entry is None else (tmp_path / entry).resolve())
    for name in given or ("parts",):
        assert folders.asset(f"package://{name}/a.stl") == parts / "a.stl"


def test_package_xml_names_the_package(dog: Path, monkeypatch: pytest.MonkeyPatch):
    """A package is called what its package.xml says, whatever its folder is called."""
    renamed = dog.rename(dog.parent / "dog-1.2")
    for path in ("", str(renamed)):
        monkeypatch.setenv("ROS_PACKAGE_PATH", path)
        assert (
            read(renamed).folders.asset("package://dog_description/meshes/trunk one.stl").parent
            == renamed / "meshes"
        )


@pytest.mark.parametrize(("home", "opened"), [("elsewhere", "ws"), ("ws/home", "ws/robot")])
def test_without_a_package_the_folder_above_is_open(
    home: str, opened: str, dog: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """Meshes often lie beside the folder of the file; a folder that holds the home folder is
    nobody's package.
    """
    monkeypatch.setenv("HOME", str(tmp_path / home))
    robot = tmp_path / "ws" / "robot" / "dog.urdf"
    robot.parent.mkdir()
    robot.write_text(arm())
    assert read_source(str(robot)).folders.allowed == (tmp_path / opened,)


OUTSIDE = (
    'leads to "{top}/secret.stl", outside the folders that may be read ("{dog}"). If it belongs to '
    "the robot, name the folder"
)
REFUSED = {
    # Neither `..`, nor an absolute path, a symbolic link or a folder above that is named as a
    # package leads out.
    "../../../secret.stl": OUTSIDE,
    "{top}/secret.stl": OUTSIDE,
    "file://{top}/secret.stl": OUTSIDE,
    "folder/secret.stl": OUTSIDE,
    "package://ws/../secret.stl": OUTSIDE,
    "none.stl": '"none.stl" is missing: no file "{dog}/urdf/none.stl"',
    "../meshes": '"../meshes" is missing: no file "{dog}/meshes"',
    "package://cat/a.stl": 'no package "cat" among those given, in ROS_PACKAGE_PATH or above the file',
    "https://a.b/c.stl": '"https://a.b/c.stl" is not on this machine',
    # Beyond the file system's limit, an empty package: no crash.
    **dict.fromkeys(
        ["x" * 5000, f"package://{'x' * 5000}/a.stl", "package:////", "package://../a", ""], ""
    ),
}


@pytest.mark.parametrize("uri", REFUSED, ids=lambda uri: uri[:30])
def test_what_is_not_read(uri: str, dog: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """What lies outside the folders, is missing, or is no file: each says so, in the name of the
    robot's file.
    """
    monkeypatch.setenv("ROS_PACKAGE_PATH", "" if REFUSED[uri] else str(dog.parent))
    (dog / "urdf" / "folder").symlink_to(tmp_path)
    said = refused(RobotError, (), read(dog).folders.asset, uri.format(top=tmp_path))
    assert said.startswith("dog.urdf: ")
    assert REFUSED[uri].format(top=tmp_path, dog=dog) in said


def test_a_package_that_is_found_outside_the_folders_can_be_opened(tmp_path: Path):
    """The advice is the very option with which the file is read."""
    for folder in ("ws/meshes", "ws/robots/dog"):
        (tmp_path / folder).mkdir(parents=True)
    (tmp_path / "ws/meshes/a.stl").touch()
    (tmp_path / "ws/robots/dog/dog.urdf").write_text(arm())
    path, uri = str(tmp_path / "ws/robots/dog/dog.urdf"), "package://ws/meshes/a.stl"
    name, _, folder = (
        refused(RobotError, (), read_source(path).folders.asset, uri)
        .rpartition("--package ")[2]
        .partition("=")
    )
    assert (
        read_source(path, packages={name: folder}).folders.asset(uri)
        == tmp_path / "ws/meshes/a.stl"
    )
    parts = 'package "parts": there is no folder "no/such/folder"; correct --package parts=DIR'
    refused(RobotError, [parts], lambda: read_source(path, packages={"parts": "no/such/folder"}))
