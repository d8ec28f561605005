"""What a robot file may read: its own package, the folders given with it, and nothing else."""

import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from shockpc.errors import RobotError

__all__ = ["Reach", "reach_of"]

_URDF_FOLDERS = ("urdf", "xacro", "mjcf")  # by ROS's custom, folders inside a package, beside its meshes/


@dataclass(frozen=True)
class Reach:
    """The folders open to a robot file, and the packages it can name.

    Attributes:
        file: the robot file, absolute.
        packages: folders given by name.
        folders: the only folders that may be read, absolute, symbolic links resolved.
    """

    file: Path
    packages: Mapping[str, Path]
    folders: tuple[Path, ...]

    def open_to(self, path: Path) -> bool:
        """Whether a path, after following `..` and symbolic links, lies inside the folders."""
        place = os.path.realpath(path)
        return any(Path(place).is_relative_to(folder) for folder in self.folders)

    def require(self, path: Path, called: str) -> Path:
        """Return the path with links resolved, if it lies inside the folders.

        Args:
            path: what is to be read.
            called: how the robot file names it, for the message.

        Raises:
            RobotError: it lies outside.
        """
        place = Path(os.path.realpath(path))
        if self.open_to(place):
            return place
        listed = ", ".join(f'"{folder}"' for folder in self.folders)
        raise RobotError(
            f'{self.file.name}: "{called}" leads to "{place}", outside the folders that may be read ({listed}). '
            "If it belongs to the robot, name the folder that holds it: --package NAME=DIR"
        )

    def package(self, name: str) -> Path | None:
        """Find the folder of a package: as given, then in ROS_PACKAGE_PATH, then among the folders above the file."""
        if name in self.packages:
            return self.packages[name]
        if len(name) > 255 or not re.fullmatch(r"[\w.-]*\w[\w.-]*", name):
            return None  # no package can be called that; as a path it might lead anywhere
        for entry in _ros_package_path():
            for folder in (entry, entry / name, *entry.glob(f"*/{name}")):
                if os.path.isdir(folder) and name in (folder.name, _package_name(folder)):
                    return folder
        for folder in self.file.parents:
            # Above the open folders a package.xml is not even looked into: the folder's own name has to do.
            if name == folder.name or (self.open_to(folder) and name == _package_name(folder)):
                return folder
        return None


def reach_of(file: Path, packages: Mapping[str, str | Path]) -> Reach:
    """Work out what a robot file may read.

    Its own folder is the nearest one above it with a `package.xml`; else the folder that holds it, or the parent of that
    if it is called urdf, xacro or mjcf. Then come the given packages and the entries of ROS_PACKAGE_PATH.

    Args:
        file: the robot file, absolute.
        packages: package folders by name.

    Raises:
        RobotError: a given package folder does not exist.
    """
    given: dict[str, Path] = {}
    for name, folder in packages.items():
        place = Path(os.path.expanduser(folder))
        if not os.path.isdir(place):
            raise RobotError(f'package "{name}": there is no folder "{folder}"; correct --package {name}=DIR')
        given[name] = place.resolve()
    own = next((folder for folder in file.parents if os.path.isfile(folder / "package.xml")), None)
    if own is None:
        inside = file.parent.name.casefold() in _URDF_FOLDERS
        own = file.parent.parent if inside else file.parent
    folders = (own.resolve(), *given.values(), *(entry.resolve() for entry in _ros_package_path()))
    return Reach(file, given, tuple(dict.fromkeys(folders)))


def _ros_package_path() -> list[Path]:
    """The folders that ROS_PACKAGE_PATH lists and that exist."""
    listed = (Path(entry) for entry in os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep) if entry.strip())
    return [entry for entry in listed if os.path.isdir(entry)]


def _package_name(folder: Path) -> str | None:
    """The name that a folder's package.xml gives to the package; None without one."""
    try:
        text = (folder / "package.xml").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return None
    found = re.search(r"<name>\s*([^<]*?)\s*</name>", text)
    return found.group(1) if found else None
