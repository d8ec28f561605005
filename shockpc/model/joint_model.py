"""What the joints do in an impact: move freely, resist by a reflected inertia, or hold (shock paper, Section 3.1.2).

free: series elasticity keeps the rotor out. geared: the reflected inertia n² I_rotor adds to H's diagonal. locked: the gearbox's
friction holds, two bodies are one, and the joint's column is left out. No choice moves the answer more than this one.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.errors import SceneError
from shockpc.model import Record
from shockpc.printed import listed
from shockpc.robot.record import Robot
from shockpc.toml import LARGEST

__all__ = ["JointModel", "Joints", "Rotor", "joint_model", "without_springs"]


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Rotor(Record):
    """A motor behind a gearbox.

    Attributes:
        inertia: of the rotor about its own axis [kg m²].
        gear_ratio: turns of the rotor for one of the joint [1].
    """

    inertia: float
    gear_ratio: float


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Joints(Record):
    """The drives as a scene states them; patterns are joint names or globs, later ones go over earlier ones, rotors over armature.

    Attributes:
        model: all joints free (whatever the file says), geared, or locked; by default as the file says.
        armature: reflected inertia by pattern [kg m²; kg for a prismatic joint].
        rotor: rotor and gearbox by pattern; their reflected inertia is gear_ratio² · inertia.
        locked: patterns of joints that hold.
    """

    model: Literal["free", "geared", "locked"] | None = None
    armature: Mapping[str, float] = field(default_factory=dict)
    rotor: Mapping[str, Rotor] = field(default_factory=dict)
    locked: tuple[str, ...] = ()


class JointModel(NamedTuple):
    """What every joint does, as arrays.

    Attributes:
        armature: (nv,) reflected inertia that counts in the impulse [kg m², kg]; zero on the base and behind springs.
        locked: (nv,) which joint velocities are held at zero.
        name: "free", "geared", "locked", or "mixed".
        stiffness: (nv,) of the spring of the joint itself, which is without force where the joint is at touchdown [N m/rad, N/m];
            zero without a spring.
        drive_stiffness: (nv,) of the spring between the joint and its rotor [N m/rad, N/m]; infinite where they are rigidly joined.
        rotor: (nv,) reflected inertia behind that spring [kg m², kg]; zero without one.
    """

    armature: Array
    locked: np.ndarray
    name: str
    stiffness: Array
    drive_stiffness: Array
    rotor: Array


def joint_model(robot: Robot, joints: Joints) -> JointModel:
    """What every joint does, as the scene asks.

    Raises:
        UnknownName: a pattern fits no joint.
        SceneError: an inertia that is not above zero, a drive on a floating joint, "geared" without any reflected inertia, or a
            joint locked apart from the one that it follows.
    """
    armature = np.array(robot.model.armature) if joints.model != "free" else np.zeros(robot.model.nv)
    armature[~robot.actuated_dofs] = 0.0
    locked = np.zeros(robot.model.nv, dtype=bool)
    given = dict(joints.armature)
    for pattern, rotor in joints.rotor.items():
        if pattern in given:
            raise SceneError(f'"{pattern}" is given an armature and a rotor, which are two ways to say one thing; keep one of them')
        given[pattern] = rotor.gear_ratio**2 * rotor.inertia
    for pattern, inertia in given.items():
        if not 0.0 < inertia <= LARGEST:
            raise SceneError(
                f'the reflected inertia of "{pattern}" is {inertia:g}; it has to be above zero and at most {LARGEST:g}; '
                'for none use model = "free" (--joints free), and for a joint that holds model = "locked"'
            )
        armature[_velocities(robot, pattern)] = inertia
    for pattern in joints.locked:
        locked[_velocities(robot, pattern)] = True
    if joints.model == "locked":
        locked |= robot.actuated_dofs
    for pattern in given:
        if locked[_velocities(robot, pattern)].all():
            raise SceneError(
                f'"{pattern}" is locked, so a reflected inertia changes nothing there; leave out the lock, or the armature or rotor'
            )
    _refuse_split_followers(robot, locked)
    if joints.model == "geared" and not armature[robot.actuated_dofs & ~locked].any():
        raise SceneError(
            "the joints are to be geared, but neither the file nor the scene gives any reflected inertia; "
            "give armature (reflected) or rotor (inertia and gear_ratio) for the joints that have a gearbox"
        )
    name = _named(armature[robot.actuated_dofs], locked[robot.actuated_dofs])
    return without_springs(armature, locked, name)


def without_springs(armature: Array, locked: np.ndarray, name: str) -> JointModel:
    """A joint model without springs. Args: armature (nv,), locked (nv,), and its name."""
    return JointModel(armature, locked, name, np.zeros(len(armature)), np.full(len(armature), np.inf), np.zeros(len(armature)))


def _velocities(robot: Robot, pattern: str) -> list[int]:
    """The velocities of the driven joints that a pattern means."""
    names = (pattern,) if pattern == robot.joints[0].name else robot.match_joints(pattern)
    driven = [k for name in names for k in range(robot.model.nv)[robot.joint(name).v] if robot.actuated_dofs[k]]
    if not driven:
        raise SceneError(f'joint "{pattern}" of robot "{robot.name}" floats, so it has no drive; name a joint that has one')
    return driven


def _refuse_split_followers(robot: Robot, locked: np.ndarray) -> None:
    """A joint and those that it follows are held together, or it and one of them not at all."""
    held: list[str] = []
    others: list[str] = []
    for mimic in robot.mimics:
        free = [name for name in mimic.leaders if not locked[robot.joint(name).v].all()]
        follower = bool(locked[robot.joint(mimic.joint).v].all())
        if mimic.leaders and follower != (not free):
            held += [mimic.joint] if follower else mimic.leaders
            others += free[:1] if follower else [mimic.joint]
    if held:
        raise SceneError(
            f"joint {listed(held[:1])} is locked, but geared by a mimic to {listed(dict.fromkeys(others))}; lock all or none"
        )


def _named(armature: Array, locked: np.ndarray) -> str:
    """What to call the drives as a whole; a robot without joints has free ones."""
    if locked.any():
        return "locked" if locked.all() else "mixed"
    if not armature.any():
        return "free"
    return "geared" if armature.all() else "mixed"
