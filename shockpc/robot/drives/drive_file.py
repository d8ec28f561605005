"""Drives of robots, read from TOML: rotors behind gearboxes, and springs.

The drives of the robots that are known by name stand in robots/drives.toml, with their sources; a
file of a user has the same form.
"""

import fnmatch
import functools
import json
import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import field, replace
from pathlib import Path

from shockpc.core.frozen import frozen
from shockpc.core.interval import ends, interval_fault, interval_text, middle
from shockpc.core.memo import memoized
from shockpc.robot.bodies_and_joints import Drive, Drives
from shockpc.robot.catalogue import project_robots_folder
from shockpc.robot.robot import Robot
from shockpc.text.arguments import LARGEST_NUMBER
from shockpc.text.errors import SceneError, UnknownName
from shockpc.text.paths import read_file
from shockpc.text.printed import listed
from shockpc.text.toml import converted, reading

PUBLIC = ("published", "derived", "identified")
"""Status of drives that are taken unless the scene says otherwise."""


ALIKE = 1.5
"""Ratio of two masses up to which robots are about as heavy, so that drives of one may be those of
the other.
"""

_INERTIAS = ("armature", "rotor_inertia", "range")
"""Keys of a drive that say something of its inertia."""


@frozen(kw_only=True)
class _DrivesFile:
    """A file of drives.

    Attributes:
        drive: as they stand in the file.
        mass: of the robots of the catalogue whose drives are offered to others, by name [kg].
    """

    drive: tuple[Drive, ...]
    mass: Mapping[str, float] = field(default_factory=dict)


def read_drive_file(path: Path) -> tuple[Drive, ...]:
    """The drives of a file.

    Raises:
        SceneError: as for `_read`.
    """
    return _read(path).drive


def _read(path: Path) -> _DrivesFile:
    """A file of drives.

    Raises:
        SceneError: it cannot be read, or a drive has a value that no drive has.
    """
    faults: list[str] = []
    with reading(path, "drives", SceneError) as table:
        file: _DrivesFile | None = converted(table, _DrivesFile, "", faults)
        for number, drive in enumerate(file.drive if file else (), start=1):
            faults += [
                f"drive {number} ({', '.join(drive.joint)}) {fault}" for fault in _faults(drive)
            ]
        if file is None or faults:
            raise SceneError("; ".join(faults))
    return file


def _faults(drive: Drive) -> Iterator[str]:
    """The faults of a drive: data that no drive has, or that contradict each other."""
    values = {
        key: getattr(drive, key)
        for key in (*_INERTIAS, "gear_ratio", "drive_stiffness", "stiffness")
    }
    for key, value in ((key, value) for key, value in values.items() if value is not None):
        low, high = ends(value)
        least, valid = "above zero", low > 0.0 or key == "gear_ratio"
        if key in _INERTIAS:
            least, valid = "zero or above", low >= 0.0
        if fault := interval_fault(value):
            yield f"has a {key} that {fault}"
        elif not valid or high > LARGEST_NUMBER:
            yield (
                f"has a {key} of {interval_text(value)}; it has to be {least}, and at most "
                f"{LARGEST_NUMBER:g}"
            )
    yield from _contradictions(drive)


def _contradictions(drive: Drive) -> Iterator[str]:
    """The first of its keys that do not go together."""
    inertia = drive.reflected or 0.0
    inertias = [key for key in _INERTIAS if getattr(drive, key) is not None]
    if drive.rotor_inertia is not None and (drive.gear_ratio is None or drive.armature is not None):
        yield "needs rotor_inertia and gear_ratio, or only armature"
    elif drive.gear is not None and not middle(drive.gear_ratio or 0.0):
        yield "has a gear, which needs its gear_ratio"
    elif drive.status == "unknown" and inertias:
        yield f"has the status unknown and {listed(inertias)}; leave out one of the two"
    elif inertia > LARGEST_NUMBER:
        yield f"has a reflected inertia of {inertia:g}; at most {LARGEST_NUMBER:g} is computed"
    elif drive.range is not None and not drive.range[0] <= inertia <= drive.range[1]:
        yield (
            f"has a reflected inertia of {inertia:g}, which is not within its range of "
            f"{interval_text(drive.range)}"
        )
    elif drive.range is not None and replace(drive, range=None, status=None).interval not in (
        (inertia, inertia),
        (0.0, math.inf),
    ):
        yield "has a range and an interval; leave out one of the two"
    elif (
        drive.status != "unknown"
        and drive.reflected is drive.drive_stiffness is drive.stiffness is None
    ):
        yield "gives neither an inertia nor a stiffness"


@functools.lru_cache(maxsize=16)
def catalogue_drives(name: str | None) -> tuple[Drive, ...]:
    """The drives of robots/drives.toml that are known of a robot of the catalogue.

    Those of simulation models are among them.
    """
    # Those of other robots are not parsed: together they would take as long as a robot's file.
    mentioning = [table for table in _tables()[1:] if f'"{name}"' in table]
    try:
        drives = [converted(_values(table), Drive, "", []) for table in mentioning]
    except ValueError:
        drives = list(_catalogue().drive)  # a value that only TOML has, or several lines
    return tuple(drive for drive in drives if name in drive.robot)


@functools.cache
def _catalogue_masses() -> Mapping[str, float]:
    """The masses of the robots whose drives are known, by name [kg]."""
    heading = "[mass]"
    try:
        values = _values(_tables()[0].partition(heading)[2])
    except ValueError:
        return _catalogue().mass
    masses: Mapping[str, float] = converted(values, Mapping[str, float], heading, [])
    return masses


@functools.cache
def _tables() -> tuple[str, ...]:
    """The text of robots/drives.toml: up to the first drive, and that of each drive."""
    file = project_robots_folder() / "drives.toml"
    return tuple(read_file(file, "drives file", SceneError).decode().split("[[drive]]"))


def _values(table: str) -> dict[str, object]:
    """The values of a table that are written as JSON writes them.

    They are read in a tenth of the time that TOML takes.

    Raises:
        ValueError: one is written in another way.
    """
    lines = [line.split(" = ", 1) for line in table.splitlines() if line[:1] not in ("", "#")]
    return {key: json.loads(value) for key, value in lines}


def drives_like(robot: Robot, name: str) -> Drives:
    """The published and derived drives of a robot of the catalogue, for another robot.

    They are for joints of the same names.

    The label names the joints of the catalogue's robot that this one does not have.

    Raises:
        UnknownName: no drives are known of a robot of that name.
        SceneError: no joint has a name that a drive has.
    """
    known = [drive for drive in catalogue_drives(name) if drive.status in PUBLIC]
    if not known:
        raise UnknownName(
            "robot with known drives", name, sorted(robots_with_drives()), "robots/drives.toml", ""
        )
    matched: list[tuple[Drive, str]] = []
    missing: list[str] = []
    for drive in known:
        for pattern in drive.joint:
            if fnmatch.filter(robot.joint_names, pattern):
                matched.append((drive, pattern))
            else:
                missing.append(pattern)
    if not matched:
        raise SceneError(
            f'robot "{robot.name}" has none of the joints of the drives of {name} '
            f"({listed(missing, 6)}), but {listed(robot.joint_names, 6)}; give a file of drives, "
            "or --rotor"
        )
    without = f" (none is named {listed(missing, 4)})" if missing else ""
    label = f"drives of {name}, {_status(known)}, by the names of joints{without}"
    drives = [
        replace(
            drive,
            joint=(pattern,),
            robot=(),
            source=f"as {name}'s, by the names of joints: {drive.source}",
        )
        for drive, pattern in matched
    ]
    return drives_of(robot, drives, label)


@memoized()
def similar_robots(robot: Robot) -> tuple[str, ...]:
    """Robots of the catalogue whose drives are known and would fit every joint of this robot.

    Joints fit by their names.

    Their masses are about the same. If it has the name of one of them, that one; drives of all
    joints of a robot, whatever their names, say nothing here.
    """
    driven = {joint.name for joint in robot.single_joints if joint.kind != "free"}
    alike = []
    for name, mass in _catalogue_masses().items():
        of_like_mass = 1.0 / ALIKE <= robot.mass / mass <= ALIKE
        if driven and of_like_mass and driven == _joints_with_drives(driven, name):
            alike.append(name)
    namesakes = [name for name in alike if name in robot.name.casefold()]
    return tuple(namesakes or alike)


def _joints_with_drives(joints: Collection[str], name: str) -> set[str]:
    """Those of some joints that known drives of a robot of the catalogue fit by name."""
    fitting: set[str] = set()
    for drive in catalogue_drives(name):
        if drive.status in PUBLIC:
            for pattern in drive.joint:
                if pattern != "*":
                    fitting.update(fnmatch.filter(joints, pattern))
    return fitting


@functools.cache
def _catalogue() -> _DrivesFile:
    """The file robots/drives.toml."""
    return _read(project_robots_folder() / "drives.toml")


@functools.cache
def robots_with_drives() -> dict[str, tuple[Drive, ...]]:
    """The robots of robots/drives.toml whose drives are known, with these."""
    by_robot: dict[str, tuple[Drive, ...]] = {}
    for drive in _catalogue().drive:
        if drive.status in PUBLIC:
            by_robot |= {name: (*by_robot.get(name, ()), drive) for name in drive.robot}
    return by_robot


def _status(drives: Sequence[Drive]) -> str:
    return " and ".join(dict.fromkeys(str(drive.status) for drive in drives))


def drives_of(robot: Robot, drives: Sequence[Drive], label: str) -> Drives:
    """The drives of a robot's joints; later ones replace earlier ones of the same joint.

    Raises:
        UnknownName: a pattern fits no joint of the robot.
        SceneError: none of the drives is of this robot.
    """
    chosen = [
        drive
        for drive in drives
        if not drive.robot or {robot.source.name, robot.name} & set(drive.robot)
    ]
    if not chosen:
        raise SceneError(
            f'{label} has no drive of robot "{robot.name}"; name it under robot, or leave that key '
            f"out"
        )
    # of several drives that match a joint the last counts
    by_joint: dict[str, Drive] = {}
    for drive in chosen:
        for pattern in drive.joint:
            by_joint.update(dict.fromkeys(robot.match_joints(pattern), drive))
    driven = {name: drive for name, drive in by_joint.items() if robot.joint(name).kind != "free"}
    return Drives(label, driven)


def default_drives(robot: Robot) -> Drives | None:
    """The known drives of a robot of the catalogue; None where there are none.

    They go over what its file gives.
    """
    known = [drive for drive in catalogue_drives(robot.source.name) if drive.status in PUBLIC]
    if not known:
        return None
    over = " (the file's are a setting of a simulator)" if robot.settings else ""
    return drives_of(robot, known, f"drives of {robot.source.name}, {_status(known)}{over}")
