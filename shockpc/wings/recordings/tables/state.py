"""The robot's state in the rows of a table: columns, configurations and motions."""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.landing.landing import PosedLanding
from shockpc.landing.posture import set_many, settable_joints
from shockpc.method.approach import Motion
from shockpc.robot.bodies_and_joints import Joint
from shockpc.robot.mjcf.reader import qpos_order, qvel_order
from shockpc.robot.robot import Robot
from shockpc.text.errors import StudyError
from shockpc.text.printed import listed
from shockpc.wings.recordings.tables.cells import (
    RowMessages,
    empty_cells,
    numeric_column,
    unit_quaternions,
)
from shockpc.wings.recordings.tables.column_meaning import (
    CONTACT_VELOCITY,
    REMARKS,
    ColumnName,
    column_name,
    twice,
)

DEG = np.pi / 180.0

ANGLES, TWIST = ("roll", "pitch", "yaw"), ("vx", "vy", "vz", "wx", "wy", "wz")
"""Angles and velocities of the base."""

UNKNOWN = (
    "; an unknown velocity of the base is not replaced by the scene's; to use the scene's, leave "
    "out the empty columns: --map vx= …"
)
"""Meaning of an empty cell of a velocity of the base."""

EXAMPLES = ("qw", "roll", "vx", "vx_body", "wx", "vx@FRAME", "contact", "friction")
"""An example of each kind of name, from which a message proposes the nearest."""

TURNS = {"roll": np.pi, "pitch": np.pi}
"""Largest angles of the base [rad]; its yaw may be counted over several turns."""


class MeasuredColumn(NamedTuple):
    """A column that was measured after the impact.

    It has its name, what that says, and its numbers (n,), NaN where it is empty.
    """

    name: str
    meaning: ColumnName
    values: Array


class RobotColumns(NamedTuple):
    """The columns of a table that are of its robot, in rad, m and s.

    Attributes:
        arrays: MuJoCo's "qpos" (n, nq) and "qvel" (n, nv), in the order of the robot.
        positions: (n,) of joints by name.
        rates: (n,) of joints by name.
        efforts: (n,) torques of motors by joint; NaN where they are the scene's [N m, N].
        base: (n,) of the base by the names of `ColumnName.base`, with those of qvel.
        in_body: which velocities of the base are in its axes.
        contact_velocities: (n,) by frame and world axis.
        after: what was measured.
        warnings: what is doubtful of columns.
    """

    arrays: dict[str, Array]
    positions: dict[str, Array]
    rates: dict[str, Array]
    efforts: dict[str, Array]
    base: dict[str, Array]
    in_body: set[str]
    contact_velocities: dict[tuple[str, int], Array]
    after: list[MeasuredColumn]
    warnings: list[str]

    def given(self, robot: Robot) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Names of the joints whose positions, and of those whose rates, the table gives."""
        every = tuple(joint.name for joint in robot.single_joints if joint.kind != "free")
        positions = every if "qpos" in self.arrays else tuple(self.positions)
        rates = every if "qvel" in self.arrays else tuple(self.rates)
        return positions, rates


def read_columns(
    columns: Mapping[str, np.ndarray], robot: Robot, messages: RowMessages
) -> RobotColumns:
    """Read the columns of a table that are of its robot.

    Args:
        columns: by the names that `column_meaning` describes.
        robot: the robot.
        messages: get the rows of which a cell is no number.

    Raises:
        UnknownName: a column of numbers names nothing in the robot.
        StudyError: a column has another shape or unit than its name says, or two columns mean the
            same.
    """
    read = RobotColumns({}, {}, {}, {}, {}, set(), {}, [], [])
    joints = robot.joint_names
    arrays = [name for name in ("qpos", "qvel") if name in columns and name not in joints]
    for name in arrays:
        _read_array(name, columns[name], robot, read, messages)
    for name, values in columns.items():
        if name in arrays:
            continue
        if values.ndim != 1:
            raise StudyError(
                f"column {name} has shape {values.shape}; it has to be one number a row"
            )
        # A joint may have the name of a remark, and then is meant.
        if name in REMARKS and name not in joints:
            continue
        meaning = column_name(name, robot)
        if meaning is None:
            raise StudyError("a column has no name; give it one in the header of the table")
        at_contact = None
        if not (meaning.after or meaning.degrees):
            at_contact = CONTACT_VELOCITY.fullmatch(meaning.target)
        if meaning.effort:
            _read_effort(name, meaning.target, values, robot, read, messages)
        elif at_contact is not None:
            key = robot.frame(at_contact[2]).name, "xyz".index(at_contact[1])
            if key in read.contact_velocities:
                raise twice(f'"{meaning.target}"')
            velocities = numeric_column(name, values, messages, missing=True)
            read.contact_velocities[key] = velocities
        elif meaning.target in joints or meaning.base or "@" in meaning.target:
            _read_state(name, meaning, values, robot, read, messages)
        elif values.dtype.kind in "fiub":  # else it is a remark
            raise robot.unknown(
                "joint",
                meaning.target,
                (*joints, *EXAMPLES),
                f'to leave the column out: --map "{name}="',
            )
    return read


def _read_state(
    name: str,
    meaning: ColumnName,
    values: np.ndarray,
    robot: Robot,
    read: RobotColumns,
    messages: RowMessages,
) -> None:
    """Read a column of a joint or of the base, before or after the impact."""
    key = meaning.base
    is_angular = not key or key in ANGLES or key.startswith("w")
    if meaning.degrees and not is_angular:
        raise StudyError(
            f"column {name} is neither an angle nor a rate of rotation, so it is not in degrees; "
            f"leave out _deg"
        )
    advice = UNKNOWN if key in TWIST else ""
    numbers = numeric_column(name, values, messages, missing=meaning.after, advice=advice)
    if meaning.degrees:
        numbers = numbers * DEG
    if meaning.after:
        read.after.append(MeasuredColumn(name, meaning, numbers))
    elif key:
        if key in read.base:
            raise twice(f'"{key}" of the base')
        read.base[key] = numbers
        if meaning.in_body:
            read.in_body.add(key)
        if key in TURNS and not meaning.degrees:
            read.warnings.extend(_looks_like_degrees(name, numbers, -TURNS[key], TURNS[key]))
    elif "@" in meaning.target:
        raise StudyError(
            f"column {name}: a quantity is measured after the impact; name the column "
            f"after_{meaning.target}"
        )
    else:
        _read_joint(name, meaning, numbers, robot, read)


def _read_joint(
    name: str, meaning: ColumnName, numbers: Array, robot: Robot, read: RobotColumns
) -> None:
    """Read the positions or the rates of a joint before the impact."""
    (joint,) = settable_joints(robot, meaning.target, StudyError)
    if meaning.degrees and joint.unit != "rad":
        raise StudyError(f"column {name}: the joint is prismatic, and its unit is m, not deg")
    by_joint = read.rates if meaning.rate else read.positions
    array = "qvel" if meaning.rate else "qpos"
    if joint.name in by_joint or array in read.arrays:
        raise twice(f'joint "{joint.name}"')
    by_joint[joint.name] = numbers
    if not (meaning.degrees or meaning.rate) and _limited_angle(joint):
        read.warnings.extend(_looks_like_degrees(name, numbers, *joint.limits))


def _limited_angle(joint: Joint) -> bool:
    """True if a joint has limits of its angle.

    A file without any may give zeros for both of them.
    """
    low, high = joint.limits
    if joint.unit != "rad" or joint.kind == "continuous":
        return False
    return bool(np.isfinite(high - low)) and low < high


def _looks_like_degrees(name: str, values: Array, low: float, high: float) -> Iterator[str]:
    """A warning of a column that is outside of limits in radians, and inside in degrees."""
    outside = (values < low - 0.5) | (values > high + 0.5)
    degrees = values * DEG
    rows = np.flatnonzero(outside & (degrees >= low - 0.1) & (degrees <= high + 0.1))
    if len(rows):
        i = int(rows[0])
        yield (
            f"column {name}: {values[i]:g} in row {i} looks like degrees (the limits are "
            f"{low:.4g} and {high:.4g} rad), and the column "
            f"is read in radians; name it {name}_deg if it holds degrees"
        )


def _read_effort(
    name: str,
    target: str,
    values: np.ndarray,
    robot: Robot,
    read: RobotColumns,
    messages: RowMessages,
) -> None:
    """Read a column of the torques of a joint's motor; an empty cell leaves that of the scene."""
    (joint,) = settable_joints(robot, target, StudyError)
    if joint.name in read.efforts:
        raise twice(f'the effort of joint "{joint.name}"')
    read.efforts[joint.name] = np.where(
        empty_cells(values), np.nan, numeric_column(name, values, messages, missing=True)
    )


def _read_array(
    name: str, values: np.ndarray, robot: Robot, read: RobotColumns, messages: RowMessages
) -> None:
    """Read all coordinates, or all velocities, in the layout of MuJoCo.

    A free base turns at a rate in body axes.
    """
    order, size = qpos_order(robot) if name == "qpos" else qvel_order(robot)
    if values.ndim != 2 or values.shape[1] != size:
        raise StudyError(
            f"{name} has shape {values.shape}, and a row of it has the {size} numbers of the "
            f"robot's file"
        )
    numbers = numeric_column(name, values, messages)[:, order]
    read.arrays[name] = numbers
    if name == "qpos":
        for joint in robot.single_joints:
            if joint.kind in ("free", "ball"):
                part = slice(joint.q.stop - 4, joint.q.stop)
                subject = f"qpos of joint {joint.name}"
                numbers[:, part] = unit_quaternions(subject, numbers[:, part], messages)
    elif robot.free_base:
        read.base.update(zip(TWIST, numbers[:, :6].T.copy(), strict=True))
        read.in_body.update(TWIST[3:])
        numbers[:, :6] = 0.0


def configurations(
    landing: PosedLanding, read: RobotColumns, n: int, messages: RowMessages
) -> Array:
    """The configurations (n, nq) of the rows; what the table does not give is the scene's.

    Raises:
        StudyError: the attitude of the base is given in two ways, or in a part of one.
    """
    from scipy.spatial.transform import Rotation

    robot, base = landing.robot, read.base
    Q = np.array(read.arrays.get("qpos", np.broadcast_to(landing.q, (n, len(landing.q)))))
    set_many(robot, ((robot.joint(name), values) for name, values in read.positions.items()), Q)
    if not robot.free_base:
        return Q
    quaternion = [base[key] for key in ("qx", "qy", "qz", "qw") if key in base]
    angles = [key for key in ANGLES if key in base]
    if quaternion and (len(quaternion) < 4 or angles):
        raise StudyError(
            "the base's attitude is given by qw, qx, qy and qz, or by roll, pitch and yaw: all of "
            "one kind"
        )
    if quaternion:
        Q[:, 3:7] = unit_quaternions(
            "the base's quaternion (qx, qy, qz, qw)", np.stack(quaternion, axis=1), messages
        )
    elif angles:
        rpy = Rotation.from_quat(Q[:, 3:7]).as_euler("xyz")
        for k, key in enumerate(ANGLES):
            rpy[:, k] = base.get(key, rpy[:, k])
        Q[:, 3:7] = Rotation.from_euler("xyz", rpy).as_quat()
    for k, axis in enumerate("xyz"):
        Q[:, k] = base.get(axis, Q[:, k])
    return Q


def motions(landing: PosedLanding, read: RobotColumns, Q: Array) -> Motion:
    """The motions (n, …) before the impact of the rows.

    The scene gives what the table does not.

    Args:
        landing: of the scene.
        read: the columns.
        Q: (n, nq) configurations.

    Raises:
        StudyError: velocities of the base are in part in its axes; or it is fixed, and the scene
            gives it a speed.
    """
    from scipy.spatial.transform import Rotation

    robot, n = landing.robot, len(Q)
    rates = np.array(
        read.arrays.get("qvel", np.broadcast_to(landing.before.joint_rates, (n, robot.model.nv)))
    )
    for name, values in read.rates.items():
        rates[:, robot.joint(name).v] = values[:, None]
    has_rates = bool(read.rates) or "qvel" in read.arrays
    for mimic in robot.mimics if has_rates else ():
        led = np.zeros(n)
        for leader, multiplier in mimic.leaders.items():
            led += multiplier * rates[:, robot.joint(leader).v.start]
        rates[:, robot.joint(mimic.joint).v] = led[:, None]
    if robot.free_base:
        rotation = Rotation.from_quat(Q[:, 3:7]).as_matrix() @ robot.bodies[0].rotation
    else:
        rotation = np.broadcast_to(landing.state.rotation[0, 0], (n, 3, 3))
    velocity = _of_base(
        "v",
        landing.before.velocity * (not has_rates or _moves_with_joints(landing)),
        read,
        rotation,
    )
    return Motion(velocity, _of_base("w", landing.before.omega, read, rotation), rates)


def _moves_with_joints(landing: PosedLanding) -> bool:
    """True if the base has the velocity of the scene where a table gives rates of joints.

    A fixed base has none by default.

    Raises:
        StudyError: the scene gives a fixed base a speed, which would be added to the motion of the
            joints.
    """
    strike = landing.scene.strike
    if landing.base != "fixed" or strike.velocity is not None or not landing.before.velocity.any():
        return True
    if strike.drop_height is None and strike.speed == 1.0 and not strike.strike_angle_deg:
        return False
    raise StudyError(
        "the table gives rates of joints on a fixed base, and the scene a speed or a drop height "
        "of the base, which would be "
        "added to them; leave that out, or give the velocity of the base against the ground with "
        "--velocity"
    )


def _of_base(kind: str, default: Array, read: RobotColumns, rotation: Array) -> Array:
    """A velocity of the base (n, 3), world axes.

    Args: kind, "v" or "w"; rotation, (n, 3, 3) of the base.
    """
    keys = [f"{kind}{axis}" for axis in "xyz"]
    in_body = [key for key in keys if key in read.in_body]
    if in_body and len(in_body) != 3:
        raise StudyError(
            f"{listed(in_body)} of the base in body axes, but not all of {listed(keys)}; give all "
            f"three"
        )
    vector = np.stack(
        [read.base.get(key, np.full(len(rotation), default[k])) for k, key in enumerate(keys)],
        axis=1,
    )
    return np.asarray((rotation @ vector[..., None])[..., 0] if in_body else vector)
