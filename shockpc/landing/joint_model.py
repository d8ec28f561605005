"""What the joints do in an impact: move freely, resist by a reflected inertia, or hold (shock paper, Section 3.1.2).

free: no rotor, or one behind a spring (series elasticity), which yields. geared: the reflected inertia n² I_rotor adds to H's
diagonal. locked: the gearbox's friction or the motor holds the joint at the rate that it has, two bodies are one, and the joint's
column is left out. A spring, of the joint itself or behind the rotor, gives no impulse in an instant. No choice moves the answer
more than this one.
"""

import functools
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.landing.joint_options import Joints
from shockpc.robot.drives import drives_like, drives_of, read_drives
from shockpc.robot.elements import Drive, Drives
from shockpc.robot.robot import Robot
from shockpc.text.arguments import LARGEST_NUMBER
from shockpc.text.errors import SceneError
from shockpc.text.paths import inputs, is_path
from shockpc.text.printed import listed


class JointModel(NamedTuple):
    """What every joint does, as arrays.

    Attributes:
        armature: (nv,) reflected inertia that counts in the impulse [kg m², kg]; zero on the base and behind springs.
        locked: (nv,) which joint velocities stay as they are.
        name: "free", "geared", "locked", or "mixed".
        stiffness: (nv,) of the spring of the joint itself [N m/rad, N/m]; zero without a spring.
        drive_stiffness: (nv,) of the spring between the joint and its rotor [N m/rad, N/m]; infinite where they are rigidly joined.
        rotor: (nv,) reflected inertia behind that spring [kg m², kg]; zero where there is none or it is not known.
        drives: where the drives are from, such as "drives of go2, derived"; empty if no joint has them.
        unknown: (nv,) of which joints nothing is known: neither file, drives nor scene give a drive, a spring or a lock.
        torque: (nv,) of the motors on contacts of finite stiffness [N m, N]; NaN where the scene gives none.
    """

    armature: Array
    locked: np.ndarray
    name: str
    stiffness: Array
    drive_stiffness: Array
    rotor: Array
    drives: str
    unknown: np.ndarray
    torque: Array

    @property
    def springs(self) -> np.ndarray:
        """Which joint velocities (nv,) have a spring, at the joint or before their rotor."""
        return np.asarray((self.stiffness > 0.0) | np.isfinite(self.drive_stiffness))

    @property
    def rotor_unknown(self) -> np.ndarray:
        """Which joint velocities (nv,) have a spring before a rotor of unknown inertia."""
        return np.asarray(np.isfinite(self.drive_stiffness) & (self.rotor == 0.0))

    @property
    def summary(self) -> str:
        """Its name, and where its drives are from."""
        if self.drives and self.name == "free":
            return f"free, because every drive acts through a spring ({self.drives})"
        return ": ".join(filter(None, (self.name, self.drives)))

    def deflection(self, robot: Robot, q: Array) -> Array:
        """By how much (nv,) springs of joints are deflected in a configuration (nq,), as far as the robot's file says [rad, m]."""
        return np.where(self.stiffness > 0.0, robot.deflection(q), 0.0)


def joint_model(robot: Robot, joints: Joints) -> JointModel:
    """What every joint does, as the scene asks: what its drives say goes over the robot's file, and what the scene gives over both.

    Raises:
        UnknownName: a pattern fits no joint.
        SceneError: an inertia or a stiffness that is not above zero, a rotor without a gear ratio, a drive on a floating joint,
            "geared" without any reflected inertia, "free" with one, or a joint locked apart from the one that it follows.
    """
    nv, driven, free = robot.model.nv, robot.actuated_dofs, joints.model == "free"
    if free and (inertias := [*joints.armature, *joints.rotor]):
        raise SceneError(
            f"the joints are to be free, but a reflected inertia of {listed(inertias, 4)} is given; "
            'leave out model = "free" (--joints free), or the armature and rotor',
            joints=inertias,
        )
    armature = np.where(driven & (not free), robot.model.armature, 0.0)
    rotor, stiffness, drive_stiffness, torque = np.zeros(nv), np.zeros(nv), np.full(nv, np.inf), np.full(nv, np.nan)
    known = np.full(nv, free or joints.drives == "none" or robot.model.armature.any())
    for name, k in robot.springs.items():
        v = _velocities(robot, name)
        stiffness[v], known[v] = k, True
    drives, given = _drives(robot, joints), _given(robot, joints)
    for name, drive in (*drives.by_joint.items(), *given):
        v, inertia, spring = _velocities(robot, name), drive.reflected or 0.0, drive.drive_stiffness
        armature[v], rotor[v], drive_stiffness[v] = (inertia, 0.0, np.inf) if spring is None else (0.0, inertia, spring)
        if drive.stiffness is not None:
            stiffness[v] = drive.stiffness
        known[v] = True
    of_drives = robot.velocities(drives.by_joint)
    for name, _ in given:
        of_drives[_velocities(robot, name)] = False
    for pattern, k in joints.stiffness.items():
        v = _velocities(robot, pattern)
        stiffness[v], known[v] = _positive("the stiffness of joint", pattern, k), True
    for pattern, value in joints.torque.items():
        torque[_velocities(robot, pattern)] = value
    model = JointModel(
        armature=armature,
        locked=_locked(robot, joints, [pattern for pattern, _ in given]),
        name="",
        stiffness=stiffness,
        drive_stiffness=drive_stiffness,
        rotor=rotor,
        drives="",
        unknown=driven & ~known & ~robot.velocities(robot.followers),
        torque=torque,
    )
    model = _with_rigid_springs(robot, model) if joints.model == "rigid" else model
    locked = model.locked
    _refuse_split_followers(robot, locked)
    if joints.model == "geared" and not (model.armature + model.rotor)[driven & ~locked].any():
        raise SceneError(
            "the joints are to be geared, but neither the file nor the scene gives any reflected inertia; "
            "give armature (reflected) or rotor (inertia and gear_ratio) for the joints that have a gearbox"
        )
    return model._replace(
        name=_named(model.armature[driven], locked[driven]),
        stiffness=np.where(locked, 0.0, model.stiffness),
        drive_stiffness=np.where(locked, np.inf, model.drive_stiffness),
        rotor=np.where(locked, 0.0, model.rotor),
        drives=drives.label if (of_drives & ~locked).any() else "",
        unknown=model.unknown & ~locked,
    )


def _given(robot: Robot, joints: Joints) -> list[tuple[str, Drive]]:
    """The drives of a scene's armatures and rotors, with the joints that they are of as a name or a glob.

    Raises:
        UnknownName: a pattern fits no joint.
        SceneError: as for `joint_model`.
    """
    given = [(pattern, Drive(joint=(pattern,), armature=inertia)) for pattern, inertia in joints.armature.items()]
    with_armature = [set(_driven(robot, pattern)) for pattern in joints.armature]
    for pattern, motor in joints.rotor.items():
        names = set(_driven(robot, pattern))
        # A rotor of one joint is an exception to an armature of several; else it is not clear which is meant.
        if unclear := next((both for others in with_armature if (both := names & others) and not names < others), None):
            name = next(name for name in robot.joint_names if name in unclear)
            raise SceneError(
                f'"{name}" is given an armature and a rotor, which cannot be combined; keep one of them', joints=[name]
            )
        k = None if motor.stiffness is None else _positive("the stiffness of the drive", pattern, motor.stiffness)
        for name in (pattern,) if motor.gear_ratio is not None else robot.match_joints(pattern):
            ratio = robot.gear_ratios.get(name) if motor.gear_ratio is None else motor.gear_ratio
            if ratio is None:
                inertial = robot.model.armature[robot.joint(name).v].any()
                read = "a reflected inertia and not its ratio" if inertial else "none"
                message = (
                    f'the rotor of "{name}" has no gear ratio, and {read} is read of this joint from the file; '
                    f"add it: --rotor {name}=INERTIA:RATIO"
                )
                raise SceneError(message, joints=[name])
            drive = Drive(joint=(name,), rotor_inertia=motor.inertia, gear_ratio=ratio, drive_stiffness=k)
            given.append((name, drive))
    for pattern, drive in given:
        if not 0.0 < (inertia := drive.reflected or 0.0) <= LARGEST_NUMBER:
            raise SceneError(
                f'the reflected inertia of "{pattern}" is {inertia:g}; it has to be above zero and at most {LARGEST_NUMBER:g}; '
                'for none use model = "free" (--joints free), and for a joint that holds model = "locked"',
                joints=[pattern],
            )
    return given


def _with_rigid_springs(robot: Robot, model: JointModel) -> JointModel:
    """The model where no spring yields: joints with one are locked, and rotors behind one count.

    Raises:
        SceneError: the rotor behind a spring is not known.
    """
    sprung, behind = (model.stiffness > 0.0) & ~model.locked, np.isfinite(model.drive_stiffness) & ~model.locked
    if (lacking := behind & ~sprung & (model.rotor == 0.0)).any():
        names = listed(joint.name for joint in robot.single_joints if lacking[joint.v].any())
        raise SceneError(
            f"the springs are to be rigid, but the rotors behind those of {names} are not known; give them as rotor (--rotor)"
        )
    return model._replace(
        armature=model.armature + np.where(behind, model.rotor, 0.0),
        locked=model.locked | sprung,
        rotor=np.zeros_like(model.rotor),
        drive_stiffness=np.full_like(model.drive_stiffness, np.inf),
    )


def without_springs(armature: Array, locked: np.ndarray, name: str) -> JointModel:
    """A joint model without springs. Args: armature (nv,), locked (nv,), and its name."""
    zero = np.zeros(len(armature))
    return JointModel(armature, locked, name, zero, zero + np.inf, zero, "", zero > 0.0, zero + np.nan)


def _drives(robot: Robot, joints: Joints) -> Drives:
    """The drives that count for the scene beside those of the robot's file: none of free joints."""
    if joints.model == "free" or joints.drives == "none":
        return Drives("", {})
    if joints.drives is not None:
        if not is_path(joints.drives):
            return drives_like(robot, joints.drives)
        path = Path(joints.drives).expanduser()
        stamp = 0
        if path.is_file():
            status = path.stat()
            stamp = status.st_mtime_ns
            inputs.setdefault((status.st_dev, status.st_ino), "drives file")
        return drives_of(robot, _drives_file(path, stamp), f"drives of {path.name}")
    return robot.default_drives or Drives("", {})


@functools.lru_cache(maxsize=4)
def _drives_file(path: Path, stamp: int) -> tuple[Drive, ...]:
    """The drives of a file, read again when it changes. Args: path of the file; stamp: when it was last changed."""
    del stamp
    return read_drives(path)


def _positive(what: str, pattern: str, value: float) -> float:
    if not 0.0 < value <= LARGEST_NUMBER:
        raise SceneError(
            f'{what} "{pattern}" is {value:g}; it has to be above zero and at most {LARGEST_NUMBER:g}', joints=[pattern]
        )
    return value


def _velocities(robot: Robot, pattern: str) -> np.ndarray:
    """Which velocities (nv,) are of the driven joints that a pattern means."""
    return robot.velocities(_driven(robot, pattern))


def _driven(robot: Robot, pattern: str) -> list[str]:
    """The driven joints that a pattern means."""
    names = (pattern,) if pattern == robot.joints[0].name else robot.match_joints(pattern)
    driven = [name for name in names if robot.joint(name).kind != "free"]
    if not driven:
        raise SceneError(
            f'joint "{pattern}" of robot "{robot.name}" floats, so it has no drive; name a joint that has one', joints=[pattern]
        )
    return driven


def _locked(robot: Robot, joints: Joints, patterns: Sequence[str]) -> np.ndarray:
    """Which joint velocities (nv,) the scene locks. Args: patterns of the joints with a reflected inertia from the scene."""
    locked = robot.actuated_dofs & (joints.model == "locked")
    for pattern in joints.locked:
        locked |= _velocities(robot, pattern)
    for pattern in (*patterns, *joints.stiffness):
        if locked[_velocities(robot, pattern)].all():
            raise SceneError(
                f'"{pattern}" is locked, so a reflected inertia or a spring changes nothing there; leave out the lock, or the '
                "armature, rotor or stiffness",
                joints=[pattern],
            )
    return locked


def _refuse_split_followers(robot: Robot, locked: np.ndarray) -> None:
    """A joint and those that it follows are held together, or it and one of them not at all."""
    coupled: list[str] = []
    others: list[str] = []
    for mimic in robot.mimics:
        free = [name for name in mimic.leaders if not locked[robot.joint(name).v].all()]
        follower = bool(locked[robot.joint(mimic.joint).v].all())
        if mimic.leaders and follower != (not free):
            coupled += [mimic.joint] if follower else mimic.leaders
            others += free[:1] if follower else [mimic.joint]
    if coupled:
        raise SceneError(
            f"joint {listed(coupled[:1])} is locked, but geared by a mimic to {listed(dict.fromkeys(others))}; lock all or none",
            joints=[coupled[0], *dict.fromkeys(others)],
        )


def _named(armature: Array, locked: np.ndarray) -> str:
    """What to call the drives as a whole; a robot without joints has free ones."""
    if locked.any():
        return "locked" if locked.all() else "mixed"
    if not armature.any():
        return "free"
    return "geared" if armature.all() else "mixed"
