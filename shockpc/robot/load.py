"""From a name, a file, or what another library loaded to a Robot.

What cannot be computed is refused by name.
"""

import contextlib
import os
from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import freeze, read_only
from shockpc.robot.bent_legs import bent_legs
from shockpc.robot.bodies_and_joints import Mimic
from shockpc.robot.drives.drive_file import default_drives
from shockpc.robot.drives.motors import simulator_settings
from shockpc.robot.feet_and_sensors import BENT, standing_posture
from shockpc.robot.formats import YourdfpyRobot, format_of, read_source, source_of_yourdfpy
from shockpc.robot.robot import Robot, RobotSource
from shockpc.robot.tolerances import LIMIT_SLACK, refuse_number
from shockpc.robot.urdf.srdf import read_srdf
from shockpc.text.arguments import checked
from shockpc.text.errors import RobotError
from shockpc.text.printed import listed

_MOST_VELOCITIES = 1000  # one landing of so many takes some 20 s and 0.2 GB
_KEPT = 16
_SHARED: dict[Hashable, tuple[RobotSource, dict[Hashable, Robot]]] = {}
"""The sources that were read last for `shared_robot`, the latest at the end, and the robots that
were built of each.
"""


@checked
def load_robot(
    robot: "str | os.PathLike[str] | pin.Model | pin.RobotWrapper | YourdfpyRobot",
    *,
    geometry: pin.GeometryModel | None = None,
    xacro: Mapping[str, str] | None = None,
    packages: Mapping[str, str | os.PathLike[str]] | None = None,
    srdf: str | os.PathLike[str] | None = None,
    frames: Sequence[str] = (),
    free: bool = False,
) -> Robot:
    """Load a robot from a file, by name, or from what another library loaded.

    A file is URDF, xacro, MJCF or SDFormat, by its content.

    Args:
        robot: a path, or a name that `shockpc robots` lists; or a `pinocchio.Model` (or
            `RobotWrapper`) or a `yourdfpy.URDF`, as robot_descriptions gives them. A scene file
            cannot name those, so pass the robot on with the scene.
        geometry: the shapes of a `pinocchio.Model`; of a `RobotWrapper` its collision model by
            default.
        xacro: arguments of a xacro file.
        packages: folders of packages, for `package://` and `$(find …)`; in that of "*" files are
            found by their names only.
        srdf: a file of reference postures; by default the one found beside the robot.
        frames: names or globs of frames that are asked for. Of several robots in an MJCF file the
            one that has the first of them is loaded, or else the one with the most joints.
        free: whether the base of an MJCF file that fixes it gets a free joint.

    Raises:
        UnknownName: no robot has that name.
        RobotError: the file is missing, not a robot, not physical, or reads outside its folders; an
            argument has no effect.
        StudyError: an argument is of another type.
    """
    if isinstance(robot, pin.RobotWrapper):
        robot, geometry = robot.model, robot.collision_model if geometry is None else geometry
    if isinstance(robot, pin.Model):
        if xacro or packages or frames:
            raise RobotError(
                "xacro, packages and frames have no effect on a pinocchio.Model; leave them out"
            )
        from shockpc.robot.pinocchio_model import build_pinocchio

        label = f"{robot.name} (pinocchio.Model)"
        with _naming(label):
            return _finished(
                build_pinocchio(robot, label, geometry),
                None if srdf is None else Path(srdf).expanduser(),
            )
    if geometry is not None:
        raise RobotError(
            "geometry belongs to a pinocchio.Model; files name their shapes themselves, so leave "
            "it out"
        )
    folders = {name: os.fspath(folder) for name, folder in (packages or {}).items()}
    if isinstance(robot, str | os.PathLike):
        return _robot_of(
            read_source(os.fspath(robot), xacro=xacro, packages=folders, srdf=srdf, freed=free),
            frames,
            {},
        )
    if type(robot).__module__.partition(".")[0] != "yourdfpy":
        type_name = f"{type(robot).__module__}.{type(robot).__qualname__}"
        raise RobotError(
            f"a {type_name} is not a robot; give a name, a path, a pinocchio.Model or a "
            f"yourdfpy.URDF"
        )
    if xacro or frames:
        raise RobotError("xacro and frames have no effect on a yourdfpy.URDF; leave them out")
    return _robot_of(source_of_yourdfpy(robot, folders, srdf), (), {})


def shared_robot(
    robot: str,
    xacro: Mapping[str, str],
    packages: Mapping[str, str],
    srdf: str | None,
    frames: Sequence[str],
    free: bool = False,
) -> Robot:
    """As `load_robot`, but the same object for all who ask for the same robot.

    It is so until a file that the robot was read from changes.

    Robots are the same if the file, the xacro arguments, the packages, the SRDF and, of several
    robots in one MJCF, the bodies are, and whether its base is freed. The last 16 are kept, so that
    a command reads a file once. Nobody may change the object.

    Raises:
        ShockError: as for `load_robot`.
    """
    arguments = tuple(sorted(xacro.items()))
    folders = tuple(sorted(packages.items()))
    key = (robot, arguments, folders, srdf, free, os.environ.get("ROS_PACKAGE_PATH"))
    shared = _SHARED.pop(key, None)
    if shared is None or not shared[0].folders.unchanged():
        shared = read_source(robot, xacro=xacro, packages=packages, srdf=srdf, freed=free), {}
    shared[0].folders.remember()
    _SHARED[key] = shared
    for oldest in list(_SHARED)[:-_KEPT]:
        _SHARED.pop(oldest, None)
    return _robot_of(shared[0], frames, shared[1])


def _robot_of(source: RobotSource, frames: Sequence[str], built: dict[Hashable, Robot]) -> Robot:
    """A robot of a source.

    Args: built, those that there are already, to which this one is added.
    """
    with _naming(source.path.name, source.warnings):
        format_ = format_of(source)
        chosen = format_.choose(source, frames)
        if chosen not in built:
            built[chosen] = _finished(format_.build(source, chosen), source.srdf)
        return built[chosen]


@contextlib.contextmanager
def _naming(file: str, unread: Sequence[str] = ()) -> Iterator[None]:
    """Begin the messages of refusals with the name of the file.

    What of it is not read is added, as that is often the cause.
    """
    try:
        yield
    except RobotError as refusal:
        text = "; ".join((str(refusal), *unread[:2])).replace(f"{file}: ", "")
        raise RobotError(
            text if text.startswith(file) else f"{file}: {text}", **refusal.data
        ) from None


def _finished(robot: Robot, srdf: Path | None) -> Robot:
    """The robot with the postures and rotors of its SRDF, checked.

    Its rotations are exact and its mimic joints in order.
    """
    model = robot.model
    postures = dict(robot.postures)
    if srdf is not None:
        postures |= read_srdf(srdf, model, robot.start)
    if model.nv > _MOST_VELOCITIES:
        limit = f"and up to {_MOST_VELOCITIES} are computed"
        raise RobotError(
            f"it moves with {model.nv} velocities, {limit}; fix joints that do not matter"
        )
    refuse_number(
        "drives", "the largest reflected inertia", float(model.armature.max(initial=0.0)), "kg m²"
    )
    _make_rotations_exact(model)
    mimics = _leaders_first(robot)
    robot = replace(robot, postures=postures, mimics=mimics, start=np.array(robot.start))
    _move_within_limits(robot)
    robot.set_followers(robot.start)
    freeze(robot.start)
    if not _has_posture_of_legs(robot):
        bent = bent_legs(robot)
        if bent is not None:
            postures[BENT] = read_only(bent)
    # A second copy of the robot would have to find what it is made of again.
    vars(robot)["settings"] = simulator_settings(robot)
    vars(robot)["default_drives"] = default_drives(robot)
    return robot


def _make_rotations_exact(model: pin.Model) -> None:
    """Make the rotations of joint placements as good as doubles allow.

    A chain of bodies multiplies what is missing.
    """
    for placement in model.jointPlacements:
        # One step of Newton's iteration R ← R (3 − RᵀR) / 2, by einsum, whose rounding is the same
        # on every processor.
        R = placement.rotation
        missing = 3.0 * np.eye(3) - np.einsum("ji,jk->ik", R, R)
        placement.rotation = 0.5 * np.einsum("ij,jk->ik", R, missing)


def _move_within_limits(robot: Robot) -> None:
    """Move joints that start outside their limits to the nearest limit."""
    for joint in robot.single_joints:
        if joint.axis is None or joint.kind == "continuous":
            continue
        low, high = joint.limits
        value = joint.value(robot.start)
        nearest = min(max(value, low), high)
        if abs(nearest - value) > LIMIT_SLACK and low <= high:
            joint.set(nearest, robot.start)


def _has_posture_of_legs(robot: Robot) -> bool:
    """Whether the standing posture says something of the legs.

    A keyframe that only places the base says nothing of them: the same robot as a URDF has none.
    """
    name = standing_posture(robot)
    if name == "neutral":
        return False
    if robot.source.kind != "mjcf" or name not in robot.postures:
        return True
    joints = slice(7 * robot.free_base, None)
    return not np.array_equal(robot.postures[name][joints], robot.start[joints])


def _leaders_first(robot: Robot) -> tuple[Mimic, ...]:
    """The mimic joints, each after those that it follows, without leaders that are fixed."""
    if not robot.mimics:
        return ()
    from graphlib import CycleError, TopologicalSorter

    freedom = {joint.name: joint.v.stop - joint.v.start for joint in robot.single_joints}
    for mimic in robot.mimics:
        for name in (mimic.joint, *mimic.leaders):
            if freedom.get(name, 1) != 1:
                raise RobotError(
                    f'joint "{mimic.joint}" is to follow {mimic.led}, but "{name}" has '
                    f"{freedom[name]} degrees of freedom, and "
                    "only a joint with one can follow or lead; give it one axis, or take the "
                    "coupling out",
                    joints=[mimic.joint, name],
                )
    followers = {}
    for mimic in robot.mimics:
        leaders = {
            name: multiplier for name, multiplier in mimic.leaders.items() if name in freedom
        }
        followers[mimic.joint] = mimic._replace(leaders=leaders)
    try:
        order = tuple(
            TopologicalSorter(
                {name: mimic.leaders for name, mimic in followers.items()}
            ).static_order()
        )
    except CycleError as circle:
        names = listed(name for name in followers if name in circle.args[1])
        raise RobotError(
            f"mimic joints {names} follow one another in a circle; one of them has to lead",
            joints=circle.args[1],
        ) from None
    return tuple(followers[name] for name in order if name in followers)
