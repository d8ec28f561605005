"""Where the joints and the base stand when the foot strikes: names, angles and limits → q."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Literal, TypeAlias

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array
from shockpc.landing.scenes.scene import Posture, Scene
from shockpc.robot.bodies_and_joints import Joint
from shockpc.robot.feet_and_sensors import BENT, standing_posture
from shockpc.robot.robot import Robot
from shockpc.robot.tolerances import LIMIT_SLACK
from shockpc.text.arguments import checked
from shockpc.text.diagnostic import Diagnostic, by_cause
from shockpc.text.errors import SceneError, ShockError
from shockpc.text.printed import printable

TURN = 2.0 * math.pi
"""A whole turn [rad]."""

ROUNDED = math.radians(1e-2)
"""By how much an angle may miss a limit, which files state in rounded decimals [rad]."""

Quaternion: TypeAlias = Literal["xyzw", "wxyz"]
"""Where the scalar part of a quaternion stands."""


def reference_name(robot: Robot, wanted: str | None) -> str:
    """The reference posture that a scene means.

    It is the one asked for, else the robot's standing one, else "neutral".

    Raises:
        UnknownName: the robot has no posture of that name.
    """
    if wanted is None:
        return standing_posture(robot)
    if wanted != "neutral" and wanted not in robot.postures:
        known = dict.fromkeys([*robot.postures, "neutral"])
        raise robot.unknown("posture", wanted, known)
    return wanted


def spelled_out(scene: Scene, robot: Robot) -> Scene:
    """A scene with the values of joints in place of a posture that is computed for the robot.

    No file has such a posture.

    The landing is the same where that posture is not known or has other values: a robot with
    reference postures has none.
    """
    posture = scene.posture
    if posture.reference != BENT or "neutral" in robot.postures:
        return scene
    bent = robot.postures[BENT]
    set_by_scene = _named_joints(robot, (*posture.joints, *posture.joints_deg))
    joints: dict[str, float] = {}
    for joint in robot.independent_joints:
        value = joint.value(bent)
        if value != joint.value(robot.start) and joint.name not in set_by_scene:
            joints[joint.name] = value
    movable = scene.assemble
    if scene.closure and not movable:  # joints that the posture sets do not move to close loops
        held = set_by_scene | {*posture.joint_quaternions}
        movable = tuple(name for name in robot.joint_names if name not in held)
    posture = replace(posture, reference="neutral", joints=joints | {**posture.joints})
    return replace(scene, posture=posture, assemble=movable)


def _named_joints(robot: Robot, patterns: Iterable[str]) -> set[str]:
    """The joints that names and globs mean."""
    names: set[str] = set()
    for pattern in patterns:
        names.update(robot.match_joints(pattern))
    return names


@checked
def configuration(
    robot: Robot,
    posture: Posture | None = None,
    *,
    joints: Mapping[str, float | Sequence[float]] | None = None,
    base: Sequence[float] | None = None,
    quaternion: Quaternion | None = None,
) -> Array:
    """Set every joint of a robot by name: its configuration (nq,) in Pinocchio's layout.

    Args:
        robot: the robot.
        posture: what is not given otherwise, as in a scene; by default the robot's standing
            posture, else the neutral one.
        joints: values by name or glob [rad; m for a prismatic joint]; of a ball joint its
            quaternion, of a planar one x, y [m] and angle [rad], of a floating one position [m] and
            quaternion.
        base: position (3,) in the world [m], or position and quaternion (7,).
        quaternion: the order of every quaternion in `joints` and `base`, which has to be said:
            "xyzw" as in Pinocchio, ROS and SciPy, or "wxyz" as in MuJoCo.

    Raises:
        UnknownName: no such posture or joint.
        SceneError: a joint or a base that cannot be set that way, or an angle beyond its limits and
            a whole turn.
        StudyError: an argument is of another type.
    """
    posture = posture or Posture()
    # An attitude in the arguments replaces both kinds of attitude of the posture.
    if base is not None:
        numbers = _numbers(base, (3, 7), "base")
        rotation = None
        if len(numbers) == 7:
            rotation = tuple(_xyzw(numbers[3:], quaternion, "base"))
        posture = replace(
            posture, base_position=tuple(numbers[:3]), base_rpy_deg=None, base_quaternion=rotation
        )
    name = reference_name(robot, posture.reference)
    # A robot may have a posture that it calls neutral itself; that one is meant then.
    start = robot.postures.get(name, robot.start)
    # Files round quaternions and cosines, and another length than 1 would scale the shock.
    q = np.array(pin.normalize(robot.model, np.array(start)))
    change = np.abs(q - start).max(initial=0.0)
    if not (pin.isNormalized(robot.model, q, 1e-9) and change < 0.05):
        raise SceneError(
            f'posture "{name}" of robot "{robot.name}" holds a quaternion (x, y, z, w) whose '
            "length is not 1, or such a cosine and sine; correct it in the file of postures"
        )
    _set_base(robot, posture, q)
    # The posture first, then the arguments, which go over it.
    for values, unit in ((posture.joints, 1.0), (posture.joints_deg, math.pi / 180.0)):
        for pattern, value in values.items():
            for joint in settable_joints(robot, pattern):
                number = value if joint.kind == "prismatic" else value * unit
                refuse_beyond_turn(joint, number, pattern)
                joint.set(number, q)
    for ball, turned in posture.joint_quaternions.items():
        _set_several(robot, robot.joint(ball), turned, "xyzw", q)
    for pattern, coordinates in (joints or {}).items():
        if np.ndim(coordinates):
            _set_several(robot, robot.joint(pattern), coordinates, quaternion, q)
        else:
            (number,) = _numbers([coordinates], (1,), f'joint "{pattern}"')
            for joint in settable_joints(robot, pattern):
                refuse_beyond_turn(joint, float(number), pattern)
                joint.set(float(number), q)
    # Without values: only the joints that follow others get theirs.
    set_joints(robot, (), q)
    return q


@checked
def configuration_from_mujoco(robot: Robot, qpos: Sequence[float]) -> Array:
    """The configuration (nq,) of a robot of an MJCF in Pinocchio's layout.

    Args:
        robot: of an MJCF file.
        qpos: as in `mujoco.MjData`: of every joint of the file, in its order; a free joint has x,
            y, z and then the quaternion w, x, y, z [m, rad]. Joints that follow others stay as
            given.

    Raises:
        RobotError: the robot is not of an MJCF.
        SceneError: another number of coordinates, one that is not finite, or a quaternion of length
            zero.
        StudyError: an argument is of another type.
    """
    from shockpc.robot.mjcf.reader import qpos_order

    order, size = qpos_order(robot)
    q = np.asarray(pin.normalize(robot.model, _numbers(qpos, (size,), "qpos")[order]))
    if not pin.isNormalized(robot.model, q, 1e-9):
        raise SceneError(
            "qpos holds a quaternion of length 0; a rotation (w, x, y, z) has length 1"
        )
    return q


def set_joints(robot: Robot, values: Iterable[tuple[Joint, float]], q: Array) -> None:
    """Set joints of one coordinate in a configuration q (nq,), and those that follow others.

    Args: values of joints [rad, m].
    """
    for joint, value in values:
        joint.set(value, q)
    robot.set_followers(q)


def set_many(robot: Robot, values: Iterable[tuple[Joint, Array]], Q: Array) -> None:
    """Set joints of one coordinate in N configurations Q (N, nq), and those that follow others.

    Args: values (N,) [rad, m].
    """
    for joint, x in values:
        _set_column(joint, x, Q)
    for mimic in robot.mimics:
        led = np.full(len(Q), mimic.offset)
        for name, multiplier in mimic.leaders.items():
            led += multiplier * _column(robot.joint(name), Q)
        _set_column(robot.joint(mimic.joint), led, Q)


def _set_column(joint: Joint, x: Array, Q: Array) -> None:
    """Set a joint of one coordinate to values (N,) in N configurations."""
    if joint.kind == "continuous":
        Q[:, joint.q] = np.stack([np.cos(x), np.sin(x)], axis=1)
    else:
        Q[:, joint.q] = x[:, None]


def _column(joint: Joint, Q: Array) -> Array:
    """The values (N,) of a joint of one coordinate in N configurations."""
    coordinates = Q[:, joint.q]
    if coordinates.shape[1] == 1:
        return coordinates[:, 0]
    return np.arctan2(coordinates[:, 1], coordinates[:, 0])


def check_rotations(robot: Robot, Q: Array) -> None:
    """Refuse configurations (N, nq) that are none.

    Raises:
        SceneError: a number is not finite, or the numbers of a rotation have another length than 1.
    """
    wrong = ~np.isfinite(Q).all(axis=1)
    for joint in robot.single_joints:
        size = {"free": 4, "ball": 4, "planar": 2, "continuous": 2}.get(joint.kind, 0)
        if size:
            length = np.linalg.norm(Q[:, joint.q.stop - size : joint.q.stop], axis=1)
            wrong |= ~(np.abs(length - 1.0) < 1e-6)
    if wrong.any():
        raise SceneError(
            f"row {np.flatnonzero(wrong)[0]} of Q holds a number that is not finite, or a "
            f"rotation, a quaternion (x, y, z, w) or a "
            "cosine and sine, whose length is not 1; start from the configuration of a profile, "
            "profile.q"
        )


def _set_base(robot: Robot, posture: Posture, q: Array) -> None:
    """Put the base where the scene says; the rest of q is left alone."""
    if (posture.base_position, posture.base_rpy_deg, posture.base_quaternion) == (None, None, None):
        return
    if posture.base_rpy_deg is not None and posture.base_quaternion is not None:
        raise SceneError(
            "the base is turned twice, by base_rpy_deg and by base_quaternion; keep one of them"
        )
    if not robot.free_base:
        raise SceneError(
            f'the base of robot "{robot.name}" is fixed in its file, so it cannot be moved or '
            f"turned; "
            'free it with base = "free", or leave out where the base is'
        )
    if posture.base_position is not None:
        q[:3] = posture.base_position
    if posture.base_rpy_deg is not None:
        roll, pitch, yaw = np.radians(posture.base_rpy_deg)
        q[3:7] = pin.Quaternion(pin.rpy.rpyToMatrix(roll, pitch, yaw)).coeffs()
    if posture.base_quaternion is not None:
        q[3:7] = _xyzw(np.asarray(posture.base_quaternion), "xyzw", "base_quaternion")


def _numbers(sequence: Any, sizes: tuple[int, ...], subject: str) -> Array:
    """So many finite numbers."""
    try:
        values = np.asarray(sequence, dtype=float)
    except (TypeError, ValueError):
        values = np.array(np.nan)
    if values.ndim != 1 or len(values) not in sizes or not np.isfinite(values).all():
        wanted = " or ".join(map(str, sizes))
        raise SceneError(
            f"{subject} has to be {wanted} finite number{'s' * (sizes != (1,))}, not "
            f"{printable(repr(sequence), 80)}"
        )
    return values


def _xyzw(values: Array, order: Quaternion | None, subject: str) -> Array:
    """A quaternion as x, y, z, w, with length 1."""
    if order not in ("xyzw", "wxyz"):
        raise SceneError(
            f'{subject} holds a quaternion of unknown order; say quaternion="xyzw", or "wxyz" as '
            f"in MuJoCo"
        )
    length = float(np.linalg.norm(values))
    if not 0.95 < length < 1.05:
        raise SceneError(
            f"{subject} has length {length:.3g}; a rotation ({', '.join(order)}) has length 1"
        )
    return np.roll(values, -1 if order == "wxyz" else 0) / length


def _set_several(
    robot: Robot, joint: Joint, setting: Any, order: Quaternion | None, q: Array
) -> None:
    """Set a joint by a list of numbers: one of several degrees of freedom, or by a single one."""
    subject = f'joint "{joint.name}" ({joint.kind})'
    values = _numbers(setting, ({"ball": 4, "planar": 3, "free": 7}.get(joint.kind, 1),), subject)
    if joint.kind == "planar":
        q[joint.q] = (*values[:2], math.cos(values[2]), math.sin(values[2]))
    elif joint.axis is None:
        q[joint.q] = (*values[:-4], *_xyzw(values[-4:], order, subject))
    else:
        # One number in a list says what the number says alone.
        settable_joints(robot, joint.name)
        refuse_beyond_turn(joint, float(values[0]), joint.name)
        joint.set(float(values[0]), q)


def settable_joints(
    robot: Robot, pattern: str, error: type[ShockError] = SceneError
) -> tuple[Joint, ...]:
    """The joints that a name or a glob means, without those that follow others.

    Args:
        robot: the robot.
        pattern: the name or glob.
        error: raised where one number cannot set them: a joint follows another, or has several
            degrees of freedom.

    Raises:
        UnknownName: no joint fits.
    """
    names = robot.match_joints(pattern)
    followers = {mimic.joint: mimic.led for mimic in robot.mimics}
    joints = tuple(robot.joint(name) for name in names if name not in followers)
    if not joints:
        raise error(
            f'joint "{names[0]}" follows {followers[names[0]]}, so it cannot be set by itself; '
            f"name that instead",
            joints=names,
        )
    for joint in joints:
        if joint.axis is None:
            degrees = joint.v.stop - joint.v.start
            raise error(
                f'joint "{joint.name}" has {degrees} degrees of freedom, so one number cannot set '
                f"it; leave it out",
                joints=[joint.name],
            )
    return joints


def refuse_beyond_turn(
    joint: Joint, value: float, subject: str, error: type[ShockError] = SceneError
) -> None:
    """Refuse an angle outside the limits of its joint and beyond a whole turn.

    It is a mistake, such as one in the unit.

    Other values outside the limits are computed: what the limits should be may be the question.

    Args:
        joint: the joint.
        value: of it [rad, m].
        subject: what sets it, as it is typed.
        error: raised where the value is refused.
    """
    low, high = joint.limits
    least = min(low, -TURN) - ROUNDED
    greatest = max(high, TURN) + ROUNDED
    if joint.unit == "rad" and not least <= value <= greatest:
        low, high, value, turn = map(math.degrees, (low, high, value, TURN))
        raise error(
            f'{subject}: {value:g} deg is outside the limits of joint "{joint.name}", {low:.6g} to '
            f"{high:.6g} deg, "
            f"and more than a whole turn; give values from {min(low, -turn):.6g} to "
            f"{max(high, turn):.6g} deg",
            joints=[joint.name],
        )


def fixed_joints(robot: Robot, posture: Posture, movable: tuple[str, ...]) -> np.ndarray:
    """Mask (nv,) of the joint velocities that may not move while loops are closed.

    They are the base's, and those of joints that the posture sets.

    Args:
        robot: the robot.
        posture: what it sets stays where it is.
        movable: patterns of the only joints that may move, if any are given.
    """
    fixed = np.zeros(robot.model.nv, dtype=bool)
    if robot.free_base:
        fixed[:6] = True
    if movable:
        held = {*robot.joint_names} - _named_joints(robot, movable)
    else:
        held = _named_joints(
            robot, (*posture.joints, *posture.joints_deg, *posture.joint_quaternions)
        )
    return np.asarray(fixed | robot.velocities(held))


def difference(robot: Robot, Q: Array, Q_to: Array) -> Array:
    """The displacements (n, nv), tangent of q, from configurations Q (n, nq) to Q_to."""
    return np.array([pin.difference(robot.model, *pair) for pair in zip(Q, Q_to, strict=True)])


COMPONENTS = {
    "ball": ("turn-x", "turn-y", "turn-z"),
    "planar": ("shift-x", "shift-y", "turn-z"),
    "free": ("shift-x", "shift-y", "shift-z", "turn-x", "turn-y", "turn-z"),
}
"""The motions of a joint of several degrees of freedom, in the order of its velocities: along and
about the axes of what it moves.
"""


def component(joint: Joint, kind: str) -> int:
    """The velocity of a joint of several degrees of freedom that is one of `COMPONENTS`.

    It is -1 where the joint has none.

    Args:
        joint: the joint.
        kind: "turn-x", "shift-y" and so on.
    """
    known = COMPONENTS.get(joint.kind, ())
    return joint.v.start + known.index(kind) if kind in known else -1


def displaced(robot: Robot, Q: Array, steps: Array) -> Array:
    """The configurations (n, nq) reached from others by joint velocities over a time of one.

    Args:
        robot: the robot.
        Q: (n, nq) configurations.
        steps: (n, nv) velocities times the time, Pinocchio's layout [rad, m].
    """
    reached = np.array(Q)
    for k in np.flatnonzero(steps.any(axis=1)).tolist():
        reached[k] = pin.integrate(robot.model, Q[k], steps[k])
    return reached


def outside_limits(robot: Robot, q: Array) -> tuple[Diagnostic, ...]:
    """Warnings of the joints outside their limits, with the consequence."""
    warnings = []
    for joint in robot.single_joints:
        if joint.kind not in ("revolute", "prismatic"):
            continue
        value, (low, high) = float(q[joint.q.start]), joint.limits
        excess = max(low - value, value - high)
        if excess > LIMIT_SLACK:
            unit, size = ("m", 1.0) if joint.kind == "prismatic" else ("deg", math.degrees(1.0))
            limits = f"the limits [{low * size:.3g}, {high * size:.3g}]"
            if low == high == 0.0:
                limits = "limits that are both 0 in the file, as exports without limits write them"
            text = (
                f'joint "{joint.name}": {excess * size:.3g} {unit} outside {limits}; the landing '
                "is computed all the same"
            )
            warnings.append(Diagnostic("limits", joint.name, excess, text))
    return by_cause(warnings)
