"""Read a robot file: URDF, xacro or MJCF, by its contents; checked before Pinocchio or MuJoCo sees it. No mesh is opened."""

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Literal
from xml.etree import ElementTree

from shockpc.errors import RobotError
from shockpc.robot.catalogue import find_robot, find_srdf
from shockpc.robot.files import Markup, OpenFolders, open_folders, parse_xml, read_xml
from shockpc.robot.urdf import check_urdf, normalise_urdf

__all__ = ["RobotSource", "read_source", "resolve_asset"]

# What people give by mistake, and what to give instead.
_NOT_ROBOTS = {
    "sdf": "an SDF file, which Pinocchio's wheel cannot read; convert it to URDF",
    "html": "a web page; download the file itself (on GitHub: the raw file)",
    "package": "a ROS package's description; give the robot file in that package",
    "launch": "a ROS launch file; give the robot file that it loads",
    "COLLADA": "a mesh; give the robot file that uses it",
    "svg": "a picture",
    "mujocoinclude": "a part of an MJCF file; give the file that includes it",
}


@dataclass(frozen=True, eq=False)
class RobotSource:
    """What was read of a robot: its text, where it came from, and what may be read along with it.

    Attributes:
        path: the robot file, absolute.
        name: its catalogue name, if it was asked for by name.
        kind: "urdf" (xacro included) or "mjcf".
        xml: the robot's text. URDF: after xacro, mesh paths as found. MJCF: with its includes inserted and mesh paths relative to
            the file.
        robot_name: as the file says, else the file's stem.
        srdf: the file of reference postures, given or found beside the robot.
        packages: package folders given by name.
        folders: the only folders that may be read.
        warnings: what was met on the way, each with its consequence.
    """

    path: Path
    name: str | None
    kind: Literal["urdf", "mjcf"]
    xml: str
    robot_name: str
    srdf: Path | None
    packages: Mapping[str, Path]
    folders: tuple[Path, ...]
    warnings: tuple[str, ...]

    @property
    def open_folders(self) -> OpenFolders:
        """What may be read along with it."""
        return OpenFolders(self.path, self.packages, self.folders)


def read_source(
    robot: str,
    *,
    xacro: Mapping[str, str] = MappingProxyType({}),
    packages: Mapping[str, str | Path] = MappingProxyType({}),
    srdf: str | Path | None = None,
) -> RobotSource:
    """Read a robot's file and check that it holds one robot that can be computed.

    Args:
        robot: a path, or a name that `shockpc robots` lists.
        xacro: values for the arguments of a xacro file.
        packages: package folders by name, for `package://` and `$(find …)`; they may be read as well.
        srdf: a file of reference postures; by default the one that goes with the robot file.

    Raises:
        UnknownName: no robot has that name.
        RobotError: the file is missing, not a robot, not valid, or names a file outside the folders that may be read.
    """
    found, name = find_robot(robot)
    path = Path(os.path.realpath(found))
    markup = read_xml(path)
    folders = open_folders(path, packages)
    warnings: tuple[str, ...] = ()
    if markup.root.tag == "robot" and (path.suffix == ".xacro" or _uses_xacro(markup.root)):
        from shockpc.robot.xacro import expand_xacro

        text, warnings = expand_xacro(markup, folders, xacro)
        markup = Markup(text, parse_xml(text, path.name))
    elif xacro:
        raise RobotError(f"{path.name} is not a xacro file, so --xacro {next(iter(xacro))}=… has no effect; leave it out")
    text, root = markup
    stem = path.name.split(".")[0]
    robot_name = root.get("name" if root.tag == "robot" else "model") or stem
    kind: Literal["urdf", "mjcf"] = "urdf"
    postures: Path | None = None
    if root.tag == "mujoco":
        from shockpc.robot.mjcf_text import insert_includes

        if srdf is not None:
            raise RobotError(
                f"{path.name} is an MJCF, whose postures are its keyframes, so the SRDF {Path(srdf).name} has no effect; "
                "leave it out, or write its postures as <key> elements of a <keyframe>"
            )
        kind = "mjcf"
        text = insert_includes(root, folders)
    elif root.tag == "robot":
        _refuse_srdf(root, path)
        changed, more = normalise_urdf(root, path.name, stem)
        check_urdf(root, path.name)
        text = ElementTree.tostring(root, encoding="unicode") if changed else text
        warnings += more
        postures = _given_srdf(srdf) if srdf is not None else find_srdf(path, robot_name)
        if postures is not None and srdf is None and not folders.contain(postures):
            postures = None  # a link that leads out of the folders
    else:
        what = _NOT_ROBOTS.get(root.tag, "no kind of robot known here")
        raise RobotError(
            f"{path.name} begins with <{root.tag}>: {what}. Robots begin with <robot> (URDF, xacro) or <mujoco> (MJCF)"
        )
    return RobotSource(path, name, kind, text, robot_name, postures, folders.packages, folders.folders, warnings)


def _uses_xacro(root: ElementTree.Element) -> bool:
    """Whether a file has to be expanded: one whose links carry no mass, or numbers that are expressions, without xacro.

    Expanded files often keep a <xacro:…> element or two that mean nothing any more; their links are complete.
    """
    elements = list(root.iter())
    if not any(key.startswith("xacro:") for element in elements for key in (element.tag, *element.attrib)):
        return False
    plain = [element for link in root.findall("link") + root.findall("joint") for element in link.iter()]
    written = [value for element in plain for value in (element.tag, *element.attrib, *element.attrib.values())]
    whole = root.find("link/inertial/mass") is not None
    return not whole or any(value.startswith("xacro:") or "${" in value or "$(" in value for value in written)


def resolve_asset(source: RobotSource, uri: str) -> Path:
    """Find a mesh or another file that a robot file names.

    Args:
        source: the robot.
        uri: `package://name/rest`, `file:///path`, an absolute path, or one relative to the robot file.

    Returns:
        An existing file inside `source.folders`, symbolic links resolved.

    Raises:
        RobotError: it is missing, its package is unknown, or it lies outside those folders. No number needs it.
    """
    return source.open_folders.asset(uri)


def _refuse_srdf(root: ElementTree.Element, path: Path) -> None:
    """An SRDF begins with <robot> too, and holds no links."""
    if root.find("link") is None and any(root.find(tag) is not None for tag in ("group", "group_state", "disable_collisions")):
        raise RobotError(
            f"{path.name} is an SRDF: it names postures of a robot and holds none itself. Give the URDF, and this file with "
            f"--srdf {path.name}"
        )


def _given_srdf(srdf: str | Path) -> Path:
    """An SRDF that was asked for: it has to be one."""
    path = Path(os.path.realpath(os.path.expanduser(srdf)))
    root = read_xml(path).root
    if root.tag != "robot" or root.find("link") is not None:
        raise RobotError(f"{path.name} is not an SRDF: an SRDF begins with <robot> and holds <group_state> postures, no links")
    return path
