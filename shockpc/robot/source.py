"""Read a robot file: URDF, xacro or MJCF, by its contents. No mesh is opened."""

import os
from collections.abc import Mapping
from pathlib import Path
from xml.etree.ElementTree import Element

from shockpc.errors import RobotError
from shockpc.robot.catalogue import find_robot, find_srdf
from shockpc.robot.files import open_folders, parse_xml, read_text, shared_xml
from shockpc.robot.mjcf_compiled import insert_includes
from shockpc.robot.record import RobotSource
from shockpc.robot.xacro import expand_xacro

__all__ = ["read_source"]

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


def read_source(
    robot: str,
    *,
    xacro: Mapping[str, str] | None = None,
    packages: Mapping[str, str] | None = None,
    srdf: str | None = None,
) -> RobotSource:
    """Read a robot's file. The arguments are those of `load_robot`.

    Raises:
        UnknownName: no robot has that name.
        RobotError: the file is missing, not a robot, or names a file outside the folders that may be read.
    """
    written, name = find_robot(robot)
    path = Path(os.path.realpath(written))
    folders = open_folders(path, packages or {})
    folders.note(written, whole=True)  # by its bytes: programs write a file, load it and write it again within a millisecond
    text = read_text(path)
    root = shared_xml(text, path.name)
    warnings: tuple[str, ...] = ()
    prefixed = dict.fromkeys(f"<{part.tag}>" for part in root if part.tag.startswith("xacro:"))
    if root.tag == "robot" and (path.suffix == ".xacro" or ("xacro:" in text and _needs_xacro(root))):
        text, warnings = expand_xacro(text, folders, xacro or {})
        root = shared_xml(text, path.name)
    elif xacro:
        raise RobotError(f"{path.name} is not a xacro file, so --xacro {next(iter(xacro))}=… has no effect; leave it out")
    elif prefixed:
        said = f"{', '.join(prefixed)} ignored, because the links are complete without xacro; if not, name the file .xacro"
        warnings = (f"{path.name}: {said}",)
    robot_name = root.get("name" if root.tag == "robot" else "model") or path.name.split(".")[0]
    if root.tag == "mujoco":
        if srdf is not None:
            instead = "leave it out, or write its postures as <key> elements of a <keyframe>"
            raise RobotError(f"{path.name} is an MJCF, so the SRDF {Path(srdf).name} has no effect; {instead}")
        return RobotSource(name, "mjcf", insert_includes(parse_xml(text, path.name), folders), robot_name, None, folders, warnings)
    if root.tag != "robot":
        what = _NOT_ROBOTS.get(root.tag, "no kind of robot known here")
        raise RobotError(
            f"{path.name} begins with <{root.tag}>: {what}. Robots begin with <robot> (URDF, xacro) or <mujoco> (MJCF)"
        )
    postures = find_srdf(path, robot_name) if srdf is None else Path(os.path.expanduser(srdf))
    if postures is not None and srdf is None and not folders.contain(postures):
        postures = None  # a link that leads out of the folders
    for place in (path.parent, postures):  # an SRDF may be added later
        if place is not None:
            folders.note(place)
    postures = postures and Path(os.path.realpath(postures))
    return RobotSource(name, "urdf", text, robot_name, postures, folders, warnings)


def _needs_xacro(root: Element) -> bool:
    """Whether a file has to be expanded: one whose links carry no mass, or numbers that are expressions, without xacro."""
    # Expanded files often keep a <xacro:…> element or two that mean nothing any more; their links are complete.
    if not any(key.startswith("xacro:") for part in root.iter() for key in (part.tag, *part.attrib)):
        return False
    plain = [element for link in root.findall("link") + root.findall("joint") for element in link.iter()]
    written = [value for element in plain for value in (element.tag, *element.attrib, *element.attrib.values())]
    whole = root.find("link/inertial/mass") is not None
    return not whole or any(value.startswith("xacro:") or "${" in value or "$(" in value for value in written)
