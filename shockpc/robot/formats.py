"""Read a robot file, by its contents; no mesh is opened.

A format is a module, and a line in `FORMATS`.
"""

import copy
import importlib
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Protocol
from xml.etree.ElementTree import SubElement, tostring

from shockpc.robot.catalogue import find_robot
from shockpc.robot.files.reading import (
    FORMATS,
    ROOTS,
    open_folders,
    parse_xml,
    read_text,
    shared_xml,
)
from shockpc.robot.robot import RobotSource
from shockpc.text.errors import RobotError

# What people give by mistake, and what to give instead.
_NOT_ROBOTS = {
    "html": "a web page; download the file itself (on GitHub: the raw file)",
    "package": "a ROS package's description; give the robot file in that package",
    "launch": "a ROS launch file; give the robot file that it loads",
    "COLLADA": "a mesh; give the robot file that uses it",
    "svg": "a picture",
    "mujocoinclude": "a part of an MJCF file; give the file that includes it",
}


def format_of(source: RobotSource) -> Any:
    """The module of `FORMATS` that knows the format of a source."""
    (module,) = [module for kind, _, module in FORMATS.values() if kind == source.kind]
    return importlib.import_module(module)


def read_source(
    robot: str,
    *,
    xacro: Mapping[str, str] | None = None,
    packages: Mapping[str, str] | None = None,
    srdf: str | os.PathLike[str] | None = None,
    freed: bool = False,
) -> RobotSource:
    """Read a robot's file. The arguments are those of `load_robot`, where `freed` is called `free`.

    Raises:
        UnknownName: no robot has that name.
        RobotError: the file is missing, not a robot, or names a file outside the folders that may
            be read.
    """
    written, name = find_robot(robot)
    path = Path(os.path.realpath(written))
    folders = open_folders(path, packages or {})
    # by its bytes: programs write a file, load it and write it again within a millisecond
    folders.note(written, with_bytes=True)
    text = read_text(path)
    root = shared_xml(text, path.name)
    if root.tag not in FORMATS:
        kind = _NOT_ROBOTS.get(root.tag, "no kind of robot known here")
        raise RobotError(f"{path.name} begins with <{root.tag}>: {kind}. Robots begin with {ROOTS}")
    robot_name = root.get("name") or root.get("model") or path.name.split(".")[0]
    srdf_path = None if srdf is None else Path(os.path.expanduser(srdf))
    source = RobotSource(
        name, FORMATS[root.tag][0], text, robot_name, srdf_path, folders, (), freed
    )
    read: RobotSource = format_of(source).read(source, xacro or {})
    if xacro and not read.expanded:
        raise RobotError(
            f"{path.name} is not a xacro file, so --xacro {next(iter(xacro))}=… has no effect; "
            f"leave it out"
        )
    return read


class YourdfpyRobot(Protocol):
    """The part of a `yourdfpy.URDF` that is used; its import takes a second."""

    robot: Any

    def write_xml_string(self) -> bytes:
        """The URDF as it was read."""


def source_of_yourdfpy(
    robot: YourdfpyRobot, packages: Mapping[str, str], srdf: str | os.PathLike[str] | None
) -> RobotSource:
    """The text of a `yourdfpy.URDF`, as if it had been read from the folder of its meshes.

    By default that is the folder of its file.

    The name of the file is not known, so no SRDF is searched for beside it.

    Raises:
        RobotError: it cannot be written, or a package folder does not exist.
    """
    handler = getattr(robot, "_filename_handler", None)
    record = copy.deepcopy(robot.robot)
    record.materials = []  # yourdfpy 0.0.60 cannot write a material whose texture has no file
    for link in record.links:
        for visual in link.visuals:
            visual.material = None
    try:
        copied = type(robot)(
            robot=record, build_scene_graph=False, load_meshes=False, filename_handler=handler
        )  # type: ignore[call-arg]
        root = parse_xml(copied.write_xml_string().decode(), "yourdfpy.URDF")
    except (TypeError, ValueError, AttributeError) as refusal:
        raise RobotError(
            f"this yourdfpy.URDF cannot be written as XML, so it is not read ({refusal}); load its "
            f"file"
        ) from None
    mimics = {joint.name: joint.mimic for joint in record.joints if joint.mimic is not None}
    for joint in root.findall("joint"):
        mimic = mimics.get(joint.get("name"))
        if mimic is not None and joint.find("mimic") is None:  # yourdfpy 0.0.60 does not write them
            rule = {
                "joint": mimic.joint,
                "multiplier": str(mimic.multiplier),
                "offset": str(mimic.offset),
            }
            SubElement(joint, "mimic", rule)
    name = root.get("name") or "robot"
    folder = getattr(handler, "keywords", {}).get("dir", "")
    folders = open_folders(Path(os.path.realpath(folder)) / f"{name}.urdf", packages)
    postures = None if srdf is None else Path(os.path.realpath(os.path.expanduser(srdf)))
    return RobotSource(
        f"{name} (yourdfpy.URDF)",
        "urdf",
        tostring(root, encoding="unicode"),
        name,
        postures,
        folders,
        (),
    )
