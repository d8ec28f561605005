"""Where a mesh lies: `package://`, `file://`, absolute and relative names become paths inside the open folders."""

import os
from pathlib import Path
from urllib.parse import unquote

from shockpc.errors import RobotError
from shockpc.robot.reach import Reach

__all__ = ["locate_asset"]


def locate_asset(reach: Reach, uri: str) -> Path:
    """Find the file that a robot file names.

    Args:
        reach: what the robot file may read.
        uri: as written: `package://name/rest` (more slashes are forgiven, `model://` is read alike), `file:///path`, an
            absolute path, or one relative to the robot file.

    Returns:
        An existing file inside the open folders, symbolic links resolved.

    Raises:
        RobotError: it is missing, its package is unknown, or it lies outside the open folders.
    """
    scheme, separator, rest = uri.partition("://")
    if not separator:
        path = reach.file.parent / uri
    elif scheme == "file":
        path = reach.file.parent / unquote(rest.removeprefix("localhost"))
    elif scheme in ("package", "model"):
        name, _, inside = rest.lstrip("/").partition("/")
        folder = reach.package(name)
        if folder is None:
            raise RobotError(
                f'{reach.file.name}: "{uri}": no package "{name}" among those given, in ROS_PACKAGE_PATH or above the '
                f"file. Say where it is: --package {name}=DIR"
            )
        path = folder / inside
    else:
        raise RobotError(f'{reach.file.name}: "{uri}" is not on this machine; only package:// and file:// are followed')
    place = reach.require(path, uri)
    if not os.path.isfile(place):
        raise RobotError(f'{reach.file.name}: "{uri}" is missing: no file "{place}"')
    return place
