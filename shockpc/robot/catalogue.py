"""A name becomes a file: the project's robots, and every robot of example-robot-data.

A robot is called by its file's stem, in lower case, with "-" read as "_". Where that gives a poor
name, `_RENAMED` says a better one. Nothing is opened here: names and paths only.
"""

import functools
import itertools
import os
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from shockpc.text.errors import RobotError, UnknownName
from shockpc.text.paths import read_file

HUMANOIDS = (
    "g1",
    "g1_hands",
    "icub",
    "icub_reduced",
    "romeo",
    "romeo_laas_small",
    "romeo_small",
    "simple_humanoid",
    "simple_humanoid_classical",
    "talos",
    "talos_full",
    "talos_full_box",
    "talos_reduced_box",
    "talos_reduced_corrected",
)
"""Bipeds with arms and a trunk."""

SETS: dict[str, tuple[str, ...]] = {
    "quadrupeds": (
        "a1",
        "anymal_b",
        "anymal_b_kinova",
        "anymal_c",
        "b1",
        "b1_z1",
        "centauro",
        "go1",
        "go2",
        "hyq",
        "laikago",
        "quadruped_8dof",
        "solo8",
        "solo12",
    ),
    "bipeds": ("alexander", "bolt", *HUMANOIDS),
    "humanoids": HUMANOIDS,
}
"""Robots of example-robot-data by their number of legs, with and without arms."""

# The file under robots/ → the name to type, then its other names. Only where the stem alone would
# mislead.
_RENAMED: dict[str, tuple[str, ...]] = {
    "alexander_description/urdf/alexander_v1.lowerBodyOnly.urdf": ("alexander",),
    "anymal_b_simple_description/robots/anymal.urdf": ("anymal_b",),
    "anymal_b_simple_description/robots/anymal-kinova.urdf": ("anymal_b_kinova", "anymal_kinova"),
    "anymal_c_simple_description/urdf/anymal.urdf": ("anymal_c",),
    "asr_twodof_description/urdf/TwoDofs.urdf": ("asr_twodof", "twodofs"),
    "borinot_description/urdf/borinot_flying_arm_2.urdf": ("borinot", "borinot_flying_arm_2"),
    "g1_description/urdf/g1_29dof_rev_1_0.urdf": ("g1", "g1_29dof"),
    "g1_description/urdf/g1_29dof_with_hand_rev_1_0.urdf": ("g1_hands",),
    "hector_description/robots/quadrotor_base.urdf": ("hector",),
    "hector_description/robots/quadrotor_base.xacro": ("hector_xacro",),
    # defines a macro, holds no robot
    "hector_description/robots/quadrotor_base.urdf.xacro": ("hector_macro",),
    "hextilt_description/urdf/hextilt_flying_arm_5.urdf": ("hextilt", "hextilt_flying_arm_5"),
    "hyq_description/robots/hyq_no_sensors.urdf": ("hyq", "hyq_no_sensors"),
    # "quadruped" is a robot of the project
    "quadruped_description/urdf/quadruped.urdf": ("quadruped_8dof", "quadroped"),
    "solo_description/robots/solo.urdf": ("solo8", "solo"),
    "talos_data/robots/talos_full_v2.urdf": ("talos_full", "talos_full_v2"),
    "talos_data/robots/talos_full_v2_box.urdf": ("talos_full_box", "talos_full_v2_box"),
    "talos_data/robots/talos_reduced.urdf": ("talos", "talos_reduced"),
    "ur_description/urdf/ur3.urdf": ("ur3_empty",),  # holds no link
    "ur_description/urdf/ur3_robot.urdf": ("ur3", "ur3_robot"),
    "ur_description/urdf/ur3_joint_limited_robot.urdf": ("ur3_limited", "ur3_joint_limited_robot"),
    "ur_description/urdf/ur5_robot.urdf": ("ur5", "ur5_robot"),
    "ur_description/urdf/ur5_joint_limited_robot.urdf": ("ur5_limited", "ur5_joint_limited_robot"),
    "ur_description/urdf/ur10_robot.urdf": ("ur10", "ur10_robot"),
    "ur_description/urdf/ur10_joint_limited_robot.urdf": (
        "ur10_limited",
        "ur10_joint_limited_robot",
    ),
}
ROBOT_SUFFIXES = (".urdf", ".xacro", ".xml", ".mjcf", ".sdf", ".toml")
"""The endings of names of files of robots, and of scenes."""

_SHARE = "share/example-robot-data"


class CatalogueEntry(NamedTuple):
    """A robot that can be called by name.

    It has the name to type, in lower case, the robot file, and other names it answers to.
    """

    name: str
    file: str
    aliases: tuple[str, ...] = ()

    @property
    def path(self) -> Path:
        """The robot file."""
        return Path(self.file)


def catalogue() -> tuple[CatalogueEntry, ...]:
    """List every robot known by name.

    The project's come first, then those of example-robot-data, each in alphabetical order.
    """
    project = str(project_robots_folder())
    return tuple(
        sorted(_entries(), key=lambda entry: (os.path.dirname(entry.file) != project, entry.name))
    )


def _entries() -> Iterator[CatalogueEntry]:
    """Every robot known by name, folder by folder, the project's first.

    A folder is listed when what precedes it was taken.
    """
    folder, taken = project_robots_folder(), set[str]()
    for file in _files(folder):
        if file.endswith((".urdf.xacro", ".xml")):
            taken.add(_name_of(file))
            yield CatalogueEntry(_name_of(file), f"{folder}/{file}")
    share = data_folder()
    robots = share / "robots" if share else None
    for package, subfolder in itertools.product(
        _files(robots) if robots else (), ("robots", "urdf")
    ):
        for file in _files(f"{robots}/{package}/{subfolder}"):
            if file.endswith((".urdf", ".xacro")):
                name, *aliases = _RENAMED.get(f"{package}/{subfolder}/{file}", (_name_of(file),))
                # two packages with a file of one name: the package tells them apart
                if name in taken:
                    name = f"{_normalised(package.removesuffix('_description'))}_{_name_of(file)}"
                taken |= {name, *aliases}
                yield CatalogueEntry(name, f"{robots}/{package}/{subfolder}/{file}", tuple(aliases))


def _files(folder: Path | str) -> list[str]:
    """The files of a folder, in alphabetical order; nothing where there is none."""
    try:
        return sorted(os.listdir(folder))
    except OSError:
        return []


def robots_of_set(name: str) -> tuple[str, ...]:
    """The names of a set of robots: one of `SETS`, or all that are known by name.

    Raises:
        UnknownName: there is no such set.
    """
    if name == "all":
        return tuple(entry.name for entry in catalogue())
    if name not in SETS:
        raise UnknownName(
            "set of robots",
            name,
            (*SETS, "all"),
            "",
            "shockpc batch --help; robots stand without --robots",
        )
    return SETS[name]


def find_robot(name_or_path: str) -> tuple[Path, str | None]:
    """Find the file that a name or a path means, and its name in the catalogue.

    The name is None when the file was given as a path.

    It is a path when it holds a path separator or a suffix and exists; else a robot's name or
    alias, in any case, with "-" and "_" alike.

    Raises:
        RobotError: it looks like a path, and nothing is there.
        UnknownName: no robot is called that.
    """
    path = Path(os.path.expanduser(name_or_path))
    has_separator = len(path.parts) > 1 or "/" in name_or_path or name_or_path in (".", "..")
    if (has_separator or path.suffix) and os.path.exists(path):
        return path, None
    if has_separator or path.suffix.casefold() in ROBOT_SUFFIXES:
        remedy = "Give the path of a robot file, or the name of a known robot: shockpc robots"
        raise RobotError(f'no file "{name_or_path}" (looked in {Path.cwd()}). {remedy}')
    wanted = _normalised(name_or_path)
    for entry in _entries():
        if wanted in (entry.name, *entry.aliases):
            return entry.path, entry.name
    known: list[str] = []
    for robot in catalogue():
        known += [robot.name, *robot.aliases]
    raise UnknownName("robot", name_or_path, known, "", "shockpc robots")


def find_srdf(robot_path: Path, robot_name_in_file: str) -> Path | None:
    """Find the SRDF that goes with a robot file.

    It is the one beside it, in ./srdf or in ../srdf that is named like it.

    The stem of the robot file counts first, then the longest SRDF stem that begins it (`hyq.srdf`
    for `hyq_no_sensors.urdf`), then the same with the robot's name in the file, which may be empty,
    then the only one that continues the robot file's stem (`baxter_manipulation.srdf`).

    Returns: the SRDF file, or None where no name fits.
    """
    stem = _stem(robot_path.name).casefold()
    folder = robot_path.parent
    for searched in (folder, folder / "srdf", folder.parent / "srdf"):
        files = {
            file.removesuffix(".srdf").casefold(): searched / file
            for file in _files(searched)
            if file.endswith(".srdf")
        }
        for name in (stem, robot_name_in_file.casefold()):
            prefixes = [s for s in files if s and name.startswith(s)]
            if prefixes:
                return files[max(prefixes, key=len)]
        longer = [s for s in files if s.startswith(stem + "_")]
        if len(longer) == 1:
            return files[longer[0]]
    return None


@functools.cache
def project_robots_folder() -> Path:
    """Return the folder of the project's robots.

    It is inside an installed package, or beside it in a checkout.
    """
    package = Path(__file__).resolve().parent.parent
    packaged = package / "robots"
    return packaged if packaged.is_dir() else package.parent / "robots"


def closing_scene(robot: Path) -> Path | None:
    """The first scene that closes a loop of one of the project's robots.

    The robot's file, a tree, ends at the loop's two ends.
    """
    return _closing_scenes().get(robot) if robot.is_relative_to(project_robots_folder()) else None


@functools.cache
def _closing_scenes() -> dict[Path, Path]:
    """By the project's robots, the first scene that closes a loop."""
    closing: dict[Path, Path] = {}
    for scene in sorted((project_robots_folder() / "scenes").glob("*.toml")):
        text = read_file(scene, "scene file", RobotError).decode()
        robot = re.search(r'^robot = "\.\./(.+)"', text, re.MULTILINE)
        if "[[closure]]" in text and robot is not None:
            closing.setdefault(project_robots_folder() / robot[1], scene)
    return closing


def data_folder() -> Path | None:
    """Return the share folder of example-robot-data; None if not installed.

    It is also the package root of the meshes.
    """
    # Where the wheel puts it, and where a system package does; asking importlib.metadata costs tens
    # of milliseconds.
    prefixes = [os.path.join(entry, "cmeel.prefix") for entry in sys.path]
    for prefix in (*prefixes, sys.prefix):
        if os.path.isdir(os.path.join(prefix, _SHARE, "robots")):
            return Path(prefix, _SHARE)
    return None


def _stem(file: str) -> str:
    return (
        file.removesuffix(".xacro").removesuffix(".urdf").removesuffix(".xml").removesuffix(".mjcf")
    )


def _name_of(file: str) -> str:
    return _normalised(_stem(file))


def _normalised(name: str) -> str:
    return name.strip().casefold().replace("-", "_")
