"""Read a robot file: URDF, xacro or MJCF, by its contents; checked before Pinocchio or MuJoCo sees it. No mesh is opened."""

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal
from xml.etree import ElementTree

from shockpc.errors import RobotError
from shockpc.robot.catalogue import find_robot, find_srdf
from shockpc.robot.files import Markup, OpenFolders, open_folders, parse_xml, read_xml
from shockpc.robot.urdf import check_urdf, normalise_urdf

__all__ = ["RobotSource", "read_source"]

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
        name: its catalogue name, if it was asked for by name.
        kind: "urdf" (xacro included) or "mjcf".
        xml: the robot's text. URDF: after xacro, mesh paths as found. MJCF: with its includes inserted and mesh paths relative to
            the file.
        robot_name: as the file says, else the file's stem.
        srdf: the file of reference postures, given or found beside the robot.
        folders: the robot file, and what may be read along with it.
        warnings: what was met on the way, each with its consequence.
    """

    name: str | None
    kind: Literal["urdf", "mjcf"]
    xml: str
    robot_name: str
    srdf: Path | None
    folders: OpenFolders
    warnings: tuple[str, ...]

    @property
    def path(self) -> Path:
        """The robot file, absolute."""
        return self.folders.file

    @property
    def label(self) -> str:
        """How a command names this robot: its catalogue name, else the path of its file."""
        return self.name or str(self.path)


def read_source(
    robot: str,
    *,
    xacro: Mapping[str, str] | None = None,
    packages: Mapping[str, str] | None = None,
    srdf: str | None = None,
) -> RobotSource:
    """Read a robot's file and check that it holds one robot that can be computed. The arguments are those of `load_robot`.

    Raises:
        UnknownName: no robot has that name.
        RobotError: the file is missing, not a robot, not valid, or names a file outside the folders that may be read.
    """
    found, name = find_robot(robot)
    path = Path(os.path.realpath(found))
    markup = read_xml(path)
    folders = open_folders(path, packages or {})
    warnings: tuple[str, ...] = ()
    if markup.root.tag == "robot" and (path.suffix == ".xacro" or _uses_xacro(markup)):
        from shockpc.robot.xacro import expand_xacro

        text, warnings = expand_xacro(markup, folders, xacro or {})
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
        postures = find_srdf(path, robot_name) if srdf is None else Path(os.path.realpath(os.path.expanduser(srdf)))
        if postures is not None and srdf is None and not folders.contain(postures):
            postures = None  # a link that leads out of the folders
    else:
        what = _NOT_ROBOTS.get(root.tag, "no kind of robot known here")
        raise RobotError(
            f"{path.name} begins with <{root.tag}>: {what}. Robots begin with <robot> (URDF, xacro) or <mujoco> (MJCF)"
        )
    return RobotSource(name, kind, text, robot_name, postures, folders, warnings)


def _uses_xacro(markup: Markup) -> bool:
    """Whether a file has to be expanded: one whose links carry no mass, or numbers that are expressions, without xacro.

    Expanded files often keep a <xacro:…> element or two that mean nothing any more; their links are complete.
    """
    root = markup.root
    if "xacro:" not in markup.text or not any(key.startswith("xacro:") for part in root.iter() for key in (part.tag, *part.attrib)):
        return False
    plain = [element for link in root.findall("link") + root.findall("joint") for element in link.iter()]
    written = [value for element in plain for value in (element.tag, *element.attrib, *element.attrib.values())]
    whole = root.find("link/inertial/mass") is not None
    return not whole or any(value.startswith("xacro:") or "${" in value or "$(" in value for value in written)


def _refuse_srdf(root: ElementTree.Element, path: Path) -> None:
    """An SRDF begins with <robot> too, and holds no links."""
    if root.find("link") is None and any(root.find(tag) is not None for tag in ("group", "group_state", "disable_collisions")):
        raise RobotError(
            f"{path.name} is an SRDF: it names postures of a robot and holds none itself. Give the URDF, and this file with "
            f"--srdf {path.name}"
        )
