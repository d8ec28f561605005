"""The motion of joints in an impact (shock paper, Section 3.1.2).

Joints move freely, resist by a reflected inertia, or hold.

free: no rotor, or one behind a spring (series elasticity), which yields. geared: the reflected
inertia n² I_rotor adds to H's diagonal, and beside it, where the gear is known, ±n I_rotor couples
the joint to the link that carries the rotor. locked: the gearbox's friction or the motor holds the
joint at the rate that it has, two bodies are one, and the joint's column is left out. A spring, of
the joint itself or behind the rotor, gives no impulse in an instant. No choice moves the answer
more than this one.
"""

import functools
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np

from shockpc.core.interval import interval_fault
from shockpc.core.spatial import Array
from shockpc.landing.scenes.joint_options import Joints, Rotor
from shockpc.robot.bodies_and_joints import Drive, Drives
from shockpc.robot.drives.drive_file import drives_like, drives_of, read_drive_file
from shockpc.robot.drives.motors import effort_hint, passive
from shockpc.robot.robot import Robot
from shockpc.text.arguments import LARGEST_NUMBER
from shockpc.text.errors import SceneError
from shockpc.text.paths import inputs, is_path
from shockpc.text.printed import listed

Status = Literal[
    "given", "file", "published", "derived", "identified", "simulation model", "unknown"
]
"""The quality of the data on a joint's drive: as its source says, or given by the scene, or a
number of the robot's file.
"""

NOTHING = "nothing is known"
"""The source named for a joint with a motor of which neither file, drives nor scene give a drive, a
spring or a lock.
"""


SETTING = (
    "the robot's file, one number for joints of different or unknown effort: a setting of a "
    "simulator"
)
"""The source named for joints as in `simulator_settings`."""


class DriveSource(NamedTuple):
    """The quality and the source of the data on the drives of some joints.

    Attributes:
        joints: their names.
        status: how well they are known.
        text: the source, in words.
    """

    joints: tuple[str, ...]
    status: Status
    text: str


class JointModel(NamedTuple):
    """The model of every joint, as arrays.

    Where `low` and `high` are the same, `armature` is exact. So it is of joints that are free or
    locked because the scene says so, of joints without a motor, and of rotors of known inertia
    behind springs, which are free for an instant.

    Attributes:
        armature: (nv,) reflected inertia that counts in the impulse [kg m², kg]; zero on the base
            and behind springs.
        locked: (nv,) which joint velocities stay as they are.
        name: "free", "geared", "locked", or "mixed".
        stiffness: (nv,) of the spring of the joint itself [N m/rad, N/m]; zero without a spring.
        drive_stiffness: (nv,) of the spring between the joint and its rotor [N m/rad, N/m];
            infinite where they are rigidly joined.
        rotor: (nv,) reflected inertia behind that spring [kg m², kg]; zero where there is none or
            it is not known.
        drives: where the drives are from, such as "drives of go2, derived"; empty if no joint has
            them.
        unknown: (nv,) of which joints nothing is known: neither file, drives nor scene give a
            drive, a spring or a lock.
        torque: (nv,) of the motors in a landing that lasts [N m, N]; NaN where the scene gives
            none.
        low: (nv,) smallest reflected inertia that what is known allows [kg m², kg]; at most
            `armature`.
        high: (nv,) largest one, at least `armature`; infinite, which is a joint that is held, where
            nothing is known. Both are `armature` where `locked` is.
        sources: how well the drives of all joints with a motor are known that are neither locked
            nor free by the scene.
        per_turn: (nv,) turns of each joint for one of its rotor, below zero where it turns against
            it [1]; zero where no body of the robot carries the rotor, or the sense is not known.
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
    low: Array
    high: Array
    sources: tuple[DriveSource, ...]
    per_turn: Array

    @property
    def coupling(self) -> Array:
        """Coupling c (nv,) of each joint to the link that carries its rotor, ±n I_rotor [kg m²].

        Where ω is the angular velocity of that link, a rotor turns with ±n q̇ + a·ω about its axis
        a, which is the joint's. Its kinetic energy, ½ I_rotor (±n q̇ + a·ω)², has the term c q̇
        (a·ω) beside ½ n² I_rotor q̇², the reflected inertia, and ½ I_rotor (a·ω)², which the link's
        inertia contains.
        """
        return self.armature * self.per_turn

    @property
    def springs(self) -> np.ndarray:
        """Mask (nv,) of the joint velocities with a spring, at the joint or before their rotor."""
        return np.asarray((self.stiffness > 0.0) | np.isfinite(self.drive_stiffness))

    @property
    def rotor_unknown(self) -> np.ndarray:
        """Mask (nv,) of the joint velocities with a spring before a rotor of unknown inertia."""
        return np.asarray(np.isfinite(self.drive_stiffness) & (self.rotor == 0.0))

    @property
    def summary(self) -> str:
        """Its name, and where its drives are from."""
        if self.drives and self.name == "free":
            return f"free, because every drive acts through a spring ({self.drives})"
        if self.drives and self.name == "geared":
            return f"with reflected inertia: {self.drives}"
        return ": ".join(filter(None, (self.name, self.drives)))

    def deflection(self, robot: Robot, q: Array) -> Array:
        """Deflection (nv,) of the joints' springs in a configuration (nq,) [rad, m].

        It is as far as the robot's file says.
        """
        return np.where(self.stiffness > 0.0, robot.deflection(q), 0.0)


def joint_model(robot: Robot, joints: Joints) -> JointModel:
    """The model of every joint, as the scene asks.

    Data of its drives go over the robot's file, and those of the scene over both.

    Raises:
        UnknownName: a pattern fits no joint.
        SceneError: an inertia or a stiffness that is not above zero, a rotor without a gear ratio,
            a drive on a floating joint, "geared" without any reflected inertia, "free" with one, or
            a joint locked apart from the one that it follows.
    """
    _refuse_free_with_inertias(joints)
    drives = _drives(robot, joints)
    of_scene = _given(robot, joints)
    known = _Known(robot, joints.model == "free", joints.drives == "none")
    # In this order, because each step replaces what earlier ones gave.
    for name, drive in drives.by_joint.items():
        known.take(name, drive, drive.status or "given", drive.source or drives.label)
    for pattern, drive in of_scene:
        known.take(pattern, drive, "given", "the scene")
    if joints.carried:
        known.carry_rotors()
    for pattern, k in joints.stiffness.items():
        known.spring(pattern, _positive("the stiffness of joint", pattern, k))
    torque = np.full(robot.model.nv, np.nan)
    for pattern, value in joints.torque.items():
        torque[_velocities(robot, pattern)] = value
    locked = _locked(robot, joints, [pattern for pattern, _ in of_scene])
    model = known.model(locked, torque, joints.model == "rigid")
    _refuse_split_followers(robot, model.locked)

    # Geared joints without an inertia would be free joints under another name.
    driven = robot.actuated_dofs
    inertia = model.armature + model.rotor
    has_inertia = inertia[driven & ~model.locked].any()
    if joints.model == "geared" and not has_inertia:
        raise SceneError(
            "geared joints need reflected inertias, but neither the file nor the scene gives any; "
            "give the armature (reflected), or the rotor (inertia and gear_ratio), of the joints "
            "that have a gear"
        )

    # A joint whose values the scene gives has none of the drives' values.
    of_drives = robot.velocities(drives.by_joint)
    for pattern, _ in of_scene:
        of_drives[_velocities(robot, pattern)] = False
    name = _named(model.armature[driven], model.locked[driven])
    label = ""
    if (of_drives & ~model.locked).any():
        label = drives.label
    return model._replace(name=name, drives=label)


def _refuse_free_with_inertias(joints: Joints) -> None:
    """Refuse reflected inertias of joints that are to be free."""
    inertias = [*joints.armature, *joints.rotor]
    if joints.model == "free" and inertias:
        raise SceneError(
            f"the joints are to be free, but a reflected inertia of {listed(inertias, 4)} is "
            f"given; "
            'leave out model = "free" (--joints free), or the armature and rotor',
            joints=inertias,
        )


class _Known:
    """The data known of the joints while their sources are read.

    Data that are read later go over those that were read before.

    Attributes:
        inertia: (nv,) reflected inertia, behind a spring or not [kg m², kg]; zero where it is not
            known.
        low, high: (nv,) its ends [kg m², kg].
        stiffness, drive_stiffness: (nv,) as in `JointModel`.
        per_turn: (nv,) turns of the joint for one of its rotor, as of `Drive`.
        carried: (nv,) the same of rotors that a body of the robot carries.
        origin: status and text of what gives a joint its drive, by name.
    """

    def __init__(self, robot: Robot, free: bool, alone: bool) -> None:
        """The data of the robot's file.

        Args: free: whether no joint has a drive; alone: whether there are none but the file's.
        """
        nv = robot.model.nv
        self.robot = robot
        self.inertia = np.zeros(nv)
        if not free:
            self.inertia = np.where(robot.actuated_dofs, robot.model.armature, 0.0)
        self.low = np.array(self.inertia)
        self.high = np.array(self.inertia)
        self.stiffness = np.zeros(nv)
        self.drive_stiffness = np.full(nv, np.inf)
        self.per_turn = np.zeros(nv)
        self.carried = np.zeros(nv)
        self.origin: dict[str, tuple[Status, str]] = {}
        if not free:
            self._read_file(alone)
        for name, k in robot.springs.items():
            self.spring(name, k)

    def _read_file(self, alone: bool) -> None:
        """Where the drives of the robot's file are from, and of which joints nothing is known."""
        robot = self.robot
        has_motor = robot.actuated_dofs & ~passive(robot)
        for joint in robot.single_joints:
            first = joint.v.start
            if self.inertia[first] and joint.name in robot.settings:
                self.low[joint.v] = 0.0
                self.high[joint.v] = np.inf
                self.origin[joint.name] = ("simulation model", SETTING)
            elif self.inertia[first]:
                self.origin[joint.name] = ("file", "the robot's file")
            elif has_motor[first] and not alone and joint.name not in robot.followers:
                self.high[joint.v] = np.inf
                self.origin[joint.name] = ("unknown", NOTHING)

    def take(self, pattern: str, drive: Drive, status: Status, text: str) -> None:
        """Take a drive of some joints."""
        v = _velocities(self.robot, pattern)
        self.inertia[v] = drive.reflected or 0.0
        self.low[v], self.high[v] = drive.interval
        self.drive_stiffness[v] = np.inf if drive.drive_stiffness is None else drive.drive_stiffness
        self.per_turn[v] = drive.per_turn
        if drive.stiffness is not None:
            self.stiffness[v] = drive.stiffness
        for name in _driven(self.robot, pattern):
            self.origin[name] = (status, text)

    def carry_rotors(self) -> None:
        """Let rotors turn with the bodies that carry them.

        The world, which carries some, does not turn.

        Raises:
            SceneError: a joint with a gear slides, or is one of several that move its body, so that
                it is not known about which axis of which body the rotor turns.
        """
        for joint in self.robot.joints:
            if not self.per_turn[joint.v].any():
                continue
            if joint.kind not in ("revolute", "continuous"):
                raise SceneError(
                    f'joint "{joint.name}" has a gear, but only joints that turn about one axis '
                    "have such a coupling; leave the gear out",
                    joints=[joint.name],
                )
            if joint.parent >= 0:
                self.carried[joint.v] = self.per_turn[joint.v]

    def spring(self, pattern: str, k: float) -> None:
        """Take a spring of some joints.

        A joint of which nothing else is known has its spring in the place of a motor.
        """
        self.stiffness[_velocities(self.robot, pattern)] = k
        for name in _driven(self.robot, pattern):
            if self.origin.get(name) == ("unknown", NOTHING):
                self.high[self.robot.joint(name).v] = 0.0
                del self.origin[name]

    def model(self, locked: np.ndarray, torque: Array, rigid: bool) -> JointModel:
        """The joint model without its name.

        Args: locked (nv,), torque (nv,), and whether springs do not yield.

        Raises:
            SceneError: springs are rigid, and the rotor behind one is not known.
        """
        sprung = (self.stiffness > 0.0) & ~locked
        behind = np.isfinite(self.drive_stiffness) & ~locked
        if rigid:
            self._refuse_unknown_rotors(behind & ~sprung & (self.inertia == 0.0))
            locked = locked | sprung
            behind = np.zeros_like(behind)
        armature = np.where(behind, 0.0, self.inertia)
        # A rotor of known inertia gives no impulse through its spring; of one that is not known,
        # its source has the interval.
        exact = locked | (behind & (self.inertia > 0.0))
        sources = self._sources(locked)
        unknown: list[str] = []
        for source in sources:
            if source.status == "unknown":
                unknown += source.joints
        return JointModel(
            armature=armature,
            locked=locked,
            name="",
            stiffness=np.where(locked, 0.0, self.stiffness),
            drive_stiffness=np.where(behind, self.drive_stiffness, np.inf),
            rotor=np.where(behind, self.inertia, 0.0),
            drives="",
            unknown=self.robot.velocities(unknown),
            torque=torque,
            low=np.where(exact, armature, self.low),
            high=np.where(exact, armature, self.high),
            sources=sources,
            per_turn=self.carried,
        )

    def _refuse_unknown_rotors(self, lacking: np.ndarray) -> None:
        """Refuse rigid springs before rotors that are not known. Args: lacking (nv,)."""
        if lacking.any():
            joints = [joint for joint in self.robot.single_joints if lacking[joint.v].any()]
            names = listed(joint.name for joint in joints)
            raise SceneError(
                f"the springs are to be rigid, but the rotors behind those of {names} are not "
                f"known; give them as rotor (--rotor)"
            )

    def _sources(self, locked: np.ndarray) -> tuple[DriveSource, ...]:
        """One record for all joints that have their drives from the same.

        Args: locked (nv,), of which none is told.
        """
        names_by_origin: dict[tuple[Status, str], list[str]] = {}
        for joint in self.robot.single_joints:
            if joint.name in self.origin and not locked[joint.v.start]:
                names_by_origin.setdefault(self.origin[joint.name], []).append(joint.name)
        sources: list[DriveSource] = []
        for (status, text), names in names_by_origin.items():
            if status in ("unknown", "simulation model"):
                hint = effort_hint(self.robot, names)
                text = "; ".join(filter(None, (text, hint)))
            sources.append(DriveSource(tuple(names), status, text))
        return tuple(sources)


def _given(robot: Robot, joints: Joints) -> list[tuple[str, Drive]]:
    """The drives of a scene's armatures and rotors, with their joints as a name or a glob.

    Raises:
        UnknownName: a pattern fits no joint.
        SceneError: as for `joint_model`.
    """
    drives: list[tuple[str, Drive]] = []
    with_armature: list[set[str]] = []
    for pattern, inertia in joints.armature.items():
        drives.append((pattern, Drive(joint=(pattern,), armature=inertia)))
        with_armature.append(set(_driven(robot, pattern)))
    for pattern, rotor in joints.rotor.items():
        _refuse_armature_and_rotor(robot, set(_driven(robot, pattern)), with_armature)
        drives += _rotor_drives(robot, pattern, rotor)
    for pattern, drive in drives:
        _refuse_inertia(pattern, drive)
    return drives


def _refuse_armature_and_rotor(
    robot: Robot, names: set[str], with_armature: list[set[str]]
) -> None:
    """Refuse a rotor of joints that have an armature too.

    A rotor of one joint is an exception to an armature of several; else it is not clear which is
    meant.
    """
    for joints_with_armature in with_armature:
        both = names & joints_with_armature
        if both and not names < joints_with_armature:
            name = next(name for name in robot.joint_names if name in both)
            raise SceneError(
                f'"{name}" is given an armature and a rotor, which cannot be combined; keep one of '
                f"them",
                joints=[name],
            )


def _rotor_drives(robot: Robot, pattern: str, rotor: Rotor) -> Iterator[tuple[str, Drive]]:
    """The drives of a scene's rotor: of all joints of a pattern, or of each with its own ratio.

    Raises:
        SceneError: a joint has no gear ratio, or the stiffness is not above zero.
    """
    k = rotor.stiffness
    if k is not None:
        k = _positive("the stiffness of the drive", pattern, k)
    names = (pattern,) if rotor.gear_ratio is not None else robot.match_joints(pattern)
    for name in names:
        ratio = rotor.gear_ratio
        if ratio is None:
            ratio = robot.gear_ratios.get(name)
        if ratio is None:
            inertial = robot.model.armature[robot.joint(name).v].any()
            read = "a reflected inertia and not its ratio" if inertial else "none"
            raise SceneError(
                f'the rotor of "{name}" has no gear ratio, and {read} is read of this joint '
                f"from the file; "
                f"add it: --rotor {name}=INERTIA:RATIO",
                joints=[name],
            )
        drive = Drive(
            joint=(name,),
            rotor_inertia=rotor.inertia,
            gear_ratio=ratio,
            drive_stiffness=k,
            gear=rotor.gear,
        )
        yield name, drive


def _refuse_inertia(pattern: str, drive: Drive) -> None:
    """Refuse numbers of a drive that are no intervals, and an inertia that is not above zero."""
    numbers = {
        "armature": drive.armature,
        "rotor inertia": drive.rotor_inertia,
        "gear ratio": drive.gear_ratio,
    }
    for quantity, number in numbers.items():
        fault = "" if number is None else interval_fault(number)
        if fault:
            raise SceneError(f'the {quantity} of "{pattern}" {fault}', joints=[pattern])
    inertia = drive.reflected or 0.0
    low, high = drive.interval
    if not (inertia > 0.0 and 0.0 <= low <= high <= LARGEST_NUMBER):
        raise SceneError(
            f'the reflected inertia of "{pattern}" is {inertia:g}; it has to be above zero and '
            f"at most {LARGEST_NUMBER:g}; "
            'for none use model = "free" (--joints free), and for a joint that holds model = '
            '"locked"',
            joints=[pattern],
        )


def without_springs(armature: Array, locked: np.ndarray, name: str) -> JointModel:
    """A joint model without springs. Args: armature (nv,), locked (nv,), and its name."""
    zero = np.zeros(len(armature))
    return JointModel(
        armature=armature,
        locked=locked,
        name=name,
        stiffness=zero,
        drive_stiffness=np.full(len(zero), np.inf),
        rotor=zero,
        drives="",
        unknown=np.zeros(len(zero), dtype=bool),
        torque=np.full(len(zero), np.nan),
        low=armature,
        high=armature,
        sources=(),
        per_turn=zero,
    )


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
    """The drives of a file, read again when it changes.

    Args: path of the file; stamp: when it was last changed.
    """
    del stamp
    return read_drive_file(path)


def _positive(subject: str, pattern: str, value: float) -> float:
    if not 0.0 < value <= LARGEST_NUMBER:
        raise SceneError(
            f'{subject} "{pattern}" is {value:g}; it has to be above zero and at most '
            f"{LARGEST_NUMBER:g}",
            joints=[pattern],
        )
    return value


def _velocities(robot: Robot, pattern: str) -> np.ndarray:
    """Mask (nv,) of the velocities of the driven joints that a pattern means."""
    return robot.velocities(_driven(robot, pattern))


def _driven(robot: Robot, pattern: str) -> list[str]:
    """The driven joints that a pattern means."""
    names = (pattern,) if pattern == robot.joints[0].name else robot.match_joints(pattern)
    driven = [name for name in names if robot.joint(name).kind != "free"]
    if not driven:
        raise SceneError(
            f'joint "{pattern}" of robot "{robot.name}" floats, so it has no drive; name a joint '
            f"that has one",
            joints=[pattern],
        )
    return driven


def _locked(robot: Robot, joints: Joints, patterns: Sequence[str]) -> np.ndarray:
    """Mask (nv,) of the joint velocities that the scene locks.

    Args: patterns of the joints with a reflected inertia from the scene.
    """
    locked = robot.actuated_dofs & (joints.model == "locked")
    for pattern in joints.locked:
        locked |= _velocities(robot, pattern)
    for pattern in (*patterns, *joints.stiffness):
        if locked[_velocities(robot, pattern)].all():
            raise SceneError(
                f'"{pattern}" is locked, so a reflected inertia or a spring changes nothing there; '
                f"leave out the lock, or the "
                "armature, rotor or stiffness",
                joints=[pattern],
            )
    return locked


def _refuse_split_followers(robot: Robot, locked: np.ndarray) -> None:
    """A joint and those that it follows are held together, or it and one of them not at all."""
    coupled: list[str] = []
    partners: list[str] = []
    for mimic in robot.mimics:
        free = [name for name in mimic.leaders if not locked[robot.joint(name).v].all()]
        follower = bool(locked[robot.joint(mimic.joint).v].all())
        if mimic.leaders and follower != (not free):
            coupled += [mimic.joint] if follower else mimic.leaders
            partners += free[:1] if follower else [mimic.joint]
    if coupled:
        raise SceneError(
            f"joint {listed(coupled[:1])} is locked, but coupled by a mimic to "
            f"{listed(dict.fromkeys(partners))}; lock all or none",
            joints=[coupled[0], *dict.fromkeys(partners)],
        )


def _named(armature: Array, locked: np.ndarray) -> str:
    """The name of the drives as a whole; a robot without joints has free ones."""
    if locked.any():
        return "locked" if locked.all() else "mixed"
    if not armature.any():
        return "free"
    return "geared" if armature.all() else "mixed"
