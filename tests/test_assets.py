"""Meshes and included files: found wherever they may be, and never outside the folders that may be read."""

from pathlib import Path
from typing import Any

import pytest
from robot_texts import arm

from shockpc.errors import RobotError
from shockpc.robot.catalogue import data_folder
from shockpc.robot.source import RobotSource, read_source


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
    ],
)
def test_every_way_to_name_a_mesh(uri: str, dog: Path):
    """package://, file://, absolute and relative names lead to the same file."""
    assert read(dog).folders.asset(uri.format(package=dog)) == dog / "meshes" / "trunk one.stl"


def test_data_package_is_its_own_package_root():
    """Meshes of example-robot-data resolve through its share folder, with three slashes too."""
    source, share = read_source("talos"), data_folder()
    assert share is not None
    assert source.folders.allowed == (share.resolve(),)
    inside = "robots/talos_data/meshes/torso/torso_1.STL"
    for slashes in ("//", "///"):
        assert source.folders.asset(f"package:{slashes}example-robot-data/{inside}") == share.resolve() / inside


@pytest.mark.parametrize("name", ["urdf", "xacro", "mjcf"])
def test_package_without_package_xml(name: str, tmp_path: Path):
    """Without package.xml a folder called urdf, xacro or mjcf still lies inside its package."""
    robot, mesh = tmp_path / "dog" / name / "dog.urdf", tmp_path / "dog" / "meshes" / "a.stl"
    for path in (robot, mesh):
        path.parent.mkdir(parents=True)
        path.write_text(arm())
    source = read_source(str(robot))
    assert source.folders.allowed == (tmp_path / "dog",)
    assert source.folders.asset("../meshes/a.stl") == mesh
    assert source.folders.asset("package://dog/meshes/a.stl") == mesh


def test_given_package(dog: Path, tmp_path: Path):
    """A package given by name is found there first, and may be read."""
    other = tmp_path / "parts"
    other.mkdir()
    (other / "a.stl").write_text("solid")
    source = read(dog, packages={"parts": str(other), "dog_description": other})
    assert source.folders.packages == {"parts": other, "dog_description": other}
    assert source.folders.allowed == (dog, other)
    assert source.folders.asset("package://parts/a.stl") == other / "a.stl"
    assert source.folders.asset("package://dog_description/a.stl") == other / "a.stl"


@pytest.mark.parametrize("entry", ["ws2", "ws2/parts", "."])
def test_ros_package_path(entry: str, dog: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """ROS_PACKAGE_PATH lists packages, folders of packages, or workspaces; what it lists may be read."""
    parts = tmp_path / "ws2" / "parts"
    parts.mkdir(parents=True)
    (parts / "a.stl").write_text("solid")
    monkeypatch.setenv("ROS_PACKAGE_PATH", f"{tmp_path / 'nowhere'}:{tmp_path / entry}:")
    source = read(dog)
    assert source.folders.allowed == (dog, (tmp_path / entry).resolve())
    assert source.folders.asset("package://parts/a.stl") == parts / "a.stl"


def test_package_xml_names_the_package(dog: Path, monkeypatch: pytest.MonkeyPatch):
    """A package is called what its package.xml says, whatever its folder is called."""
    renamed = dog.rename(dog.parent / "dog-1.2")
    for path in ("", str(renamed)):
        monkeypatch.setenv("ROS_PACKAGE_PATH", path)
        assert read(renamed).folders.asset("package://dog_description/meshes/trunk one.stl").parent == renamed / "meshes"


@pytest.mark.parametrize(("home", "opened"), [("elsewhere", "ws"), ("ws/home", "ws/robot")])
def test_without_a_package_the_folder_above_is_open(
    home: str, opened: str, dog: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """Meshes often lie beside the folder of the file; a folder that holds the home folder is nobody's package."""
    monkeypatch.setenv("HOME", str(tmp_path / home))
    robot = tmp_path / "ws" / "robot" / "dog.urdf"
    robot.parent.mkdir()
    robot.write_text(arm())
    assert read_source(str(robot)).folders.allowed == (tmp_path / opened,)


OUTSIDE = ("../../../secret.stl", "{top}/secret.stl", "file://{top}/secret.stl", "link.stl", "folder/secret.stl")


@pytest.mark.parametrize("uri", [*OUTSIDE, "package://ws/../secret.stl"])
def test_nothing_outside_the_folders(uri: str, dog: Path, tmp_path: Path):
    """Neither `..`, nor an absolute path, a symbolic link or a folder above that is named as a package leads out."""
    (dog / "urdf" / "link.stl").symlink_to(tmp_path / "secret.stl")
    (dog / "urdf" / "folder").symlink_to(tmp_path)
    uri = uri.format(top=tmp_path)
    with pytest.raises(RobotError) as caught:
        read(dog).folders.asset(uri)
    assert str(caught.value) == (
        f'dog.urdf: "{uri}" leads to "{tmp_path / "secret.stl"}", outside the folders that may be read ("{dog}"). '
        "If it belongs to the robot, name the folder that holds it: --package NAME=DIR"
    )


def test_a_package_that_is_found_outside_the_folders_can_be_opened(tmp_path: Path):
    """The advice is the very option with which the file is read."""
    for folder in ("ws/meshes", "ws/robots/dog"):
        (tmp_path / folder).mkdir(parents=True)
    (tmp_path / "ws/meshes/a.stl").touch()
    (tmp_path / "ws/robots/dog/dog.urdf").write_text(arm())
    path, uri = str(tmp_path / "ws/robots/dog/dog.urdf"), "package://ws/meshes/a.stl"
    with pytest.raises(RobotError) as caught:
        read_source(path).folders.asset(uri)
    name, _, folder = str(caught.value).rpartition("--package ")[2].partition("=")
    assert read_source(path, packages={name: folder}).folders.asset(uri) == tmp_path / "ws/meshes/a.stl"


MISSING = {
    "none.stl": '"none.stl" is missing: no file "{dog}/urdf/none.stl"',
    "../meshes": '"../meshes" is missing: no file "{dog}/meshes"',
    "package://cat/a.stl": (
        '"package://cat/a.stl": no package "cat" among those given, in ROS_PACKAGE_PATH or above the file. '
        "Say where it is: --package cat=DIR"
    ),
    "https://a.b/c.stl": '"https://a.b/c.stl" is not on this machine; only package:// and file:// are followed',
}


@pytest.mark.parametrize("uri", MISSING)
def test_meshes_that_are_missing(uri: str, dog: Path):
    """A missing mesh, an unknown package and a web address each say so."""
    with pytest.raises(RobotError) as caught:
        read(dog).folders.asset(uri)
    assert str(caught.value) == f"dog.urdf: {MISSING[uri].format(dog=dog)}"


def test_given_package_has_to_exist(dog: Path):
    """A mistake in --package is reported at once, not when a mesh is missing."""
    with pytest.raises(RobotError) as caught:
        read(dog, packages={"parts": "no/such/folder"})
    assert str(caught.value) == 'package "parts": there is no folder "no/such/folder"; correct --package parts=DIR'


@pytest.mark.parametrize(
    "uri", ["x" * 5000, "loop.stl", "package://" + "x" * 5000 + "/a.stl", "package:////", "package://../a", ""]
)
def test_names_that_break_the_file_system(uri: str, dog: Path, monkeypatch: pytest.MonkeyPatch):
    """A name beyond the file system's limit, a link to itself, an empty package: refused, not a crash."""
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(dog.parent))
    (dog / "urdf" / "loop.stl").symlink_to(dog / "urdf" / "loop.stl")
    with pytest.raises(RobotError, match=r"^dog.urdf: "):
        read(dog).folders.asset(uri)
