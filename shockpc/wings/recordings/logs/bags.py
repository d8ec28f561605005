"""Bags of ROS 1 and ROS 2 and MCAP files: a robot's joints and base as columns.

They are read from messages of the usual types.
"""

from array import array
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from shockpc.text.errors import ShockError, StudyError, UnknownName
from shockpc.text.paths import open_file, read_file
from shockpc.text.printed import listed, visible

BAGS = {".bag": b"#ROSBAG V2.0\n", ".mcap": b"\x89MCAP0\r\n", ".db3": b"SQLite format 3\0"}
"""Endings of files of messages, and what such a file begins with; a folder is a bag of ROS 2."""

QUATERNION = ("qw", "qx", "qy", "qz")

POSE = ("x", "y", "z", *QUATERNION)

NamedNumbers = tuple[tuple[str, ...], Sequence[float]]
"""Names of columns, and their numbers."""


class _Kind(NamedTuple):
    """A type of message: its content, its usual topics, and how its numbers are read.

    The topics are names, best first.
    """

    gives: str
    usual: tuple[str, ...]
    read: Callable[[Any], NamedNumbers]


class _Series(NamedTuple):
    """Samples of one topic: names of columns, times [ns], and numbers, one after another."""

    names: tuple[str, ...]
    stamps: "array[int]"
    numbers: "array[float]"


def read_bag(path: Path, topics: Sequence[str], remarks: list[str]) -> dict[str, np.ndarray]:
    """The columns of a bag, as in recorded tables.

    They are time_ns of the headers of messages, q_JOINT, qd_JOINT, and those of the base.

    The clock is that of the joints. Of slower topics the samples stand at the nearest times of it,
    and between these is NaN.

    Args:
        path: of the file, or of the folder of ROS 2.
        topics: the only ones that are read; by default the usual ones of each type.
        remarks: what was chosen and what was left out is added to it.

    Raises:
        StudyError: it cannot be read, has no messages of these types, or several topics among which
            no name is usual.
    """
    try:
        from rosbags.highlevel import AnyReader  # an extra
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise StudyError(
            'bags need the package "rosbags"; install it with: pip install rosbags, or give a CSV '
            "file"
        ) from None
    _refuse_no_bag(path)
    series: dict[tuple[str, tuple[str, ...]], _Series] = {}
    try:
        # Bags of ROS 2 may be without the definitions of their types.
        with AnyReader([path], default_typestore=get_typestore(Stores.LATEST)) as reader:
            chosen = _chosen(reader.connections, topics, remarks)
            for connection, received, raw in reader.messages(chosen):
                message: Any = reader.deserialize(raw, connection.msgtype)
                stamp = message.header.stamp
                names, numbers = KINDS[connection.msgtype].read(message)
                if names and len(names) == len(numbers):
                    record = series.setdefault(
                        (connection.topic, names), _Series(names, array("q"), array("d"))
                    )
                    record.stamps.append(stamp.sec * 10**9 + stamp.nanosec or received)
                    record.numbers.extend(numbers)
    except ShockError:
        raise
    except Exception as refusal:  # of many kinds, because whatever is in a damaged file is read
        text = visible(str(refusal))[:200]
        raise StudyError(
            f'bag "{path}" cannot be read: {text or "it is damaged"} ({type(refusal).__name__})'
        ) from None
    if not series:
        raise StudyError(
            f'bag "{path}": topics {listed(topic.topic for topic in chosen)} have no messages with '
            f"numbers"
        )
    return _on_one_clock(list(series.values()), remarks)


def _refuse_no_bag(path: Path) -> None:
    """Refuse a file, or a folder with a file, that is no regular file or begins otherwise.

    What is no regular file would be waited for, or read without end; what is no bag, or its
    description, may be read as one line.
    """
    files = [path]
    if path.is_dir():
        files = [part for part in sorted(path.iterdir()) if part.exists() and not part.is_dir()]
    for file in files:
        if file.suffix == ".yaml":
            read_file(file, "description of a bag", StudyError)
        with open_file(file, "bag", StudyError) as bag:
            begin = BAGS.get(file.suffix.casefold(), b"")
            if bag.read(len(begin)) != begin:
                raise StudyError(
                    f'"{file}" cannot be read: it is no {file.suffix} file, or damaged, as it '
                    f"begins otherwise"
                )


def _chosen(connections: Sequence[Any], topics: Sequence[str], remarks: list[str]) -> list[Any]:
    """The connections that are read.

    They are those asked for, else for the content of each type the one of the most usual name.
    """
    known = [connection for connection in connections if connection.msgtype in KINDS]
    names = list(dict.fromkeys(connection.topic for connection in known))
    if not known:
        kinds = listed(sorted({connection.msgtype for connection in connections}), 8)
        raise StudyError(
            f"no topic is of a type that is read ({listed(KINDS)}); the bag has {kinds or 'none'}"
        )
    unknown = [topic for topic in topics if topic not in names]
    if unknown:
        raise UnknownName("topic", unknown[0], names, "this bag, of the types that are read", "")
    chosen = list(topics) or _usual_topics(known, remarks)
    return [connection for connection in known if connection.topic in chosen]


def _usual_topics(known: Sequence[Any], remarks: list[str]) -> list[str]:
    """For each kind of content the topic of the most usual name.

    Args: known, connections of types that are read.

    Raises:
        StudyError: several topics of one kind have names that are as usual.
    """
    contents = dict.fromkeys(kind.gives for kind in KINDS.values())
    has_pose = any(KINDS[connection.msgtype].gives == "pose" for connection in known)
    chosen: list[str] = []
    for gives in contents:
        # Usual names come first; topics of the same rank are ambiguous.
        ranks: dict[str, int] = {}
        for topic, msgtype in sorted({(c.topic, c.msgtype) for c in known}):
            if KINDS[msgtype].gives == gives:
                ranks[topic] = _usual(topic, KINDS[msgtype].usual)
        best = [topic for topic, rank in ranks.items() if rank == min(ranks.values())]
        if not best:
            continue
        # A pose holds the attitude already.
        if gives == "attitude" and has_pose:
            remarks.append(
                f"gyro and accelerometer of {listed(best)} are not read beside a pose; name "
                f"both topics with --topic"
            )
            continue
        if len(best) > 1:
            raise StudyError(
                f"several topics give the {gives}: {listed(best, 12)}; select with --topic"
            )
        chosen += best
        if len(ranks) > 1:
            not_chosen = listed(topic for topic in ranks if topic not in best)
            remarks.append(f"the {gives}: of {listed(best)}, not of {not_chosen}")
        if gives == "attitude":
            remarks.append(
                f"the attitude of the base is taken from {listed(best)}, with the same axes"
            )
    return chosen


def _usual(topic: str, usual: Sequence[str]) -> int:
    """The place of a topic among the usual names; their number if it has none of them."""
    return next(
        (place for place, name in enumerate(usual) if f"/{topic}".endswith(f"/{name}")), len(usual)
    )


def _on_one_clock(series: list[_Series], remarks: list[str]) -> dict[str, np.ndarray]:
    """The columns of several series at the times of one of them.

    It is the one that has the joints, or else most samples.
    """
    series.sort(key=_preference, reverse=True)
    start = series[0].stamps[0]
    clock = np.unique(np.array(series[0].stamps) - start)
    columns: dict[str, np.ndarray] = {}
    for record in series:
        # `np.unique` sorts, and keeps the first of the messages of one time.
        stamps, first = np.unique(np.array(record.stamps) - start, return_index=True)
        if series[0] is record and (np.diff(np.array(record.stamps)) < 0).any():
            remarks.append("messages are not in the order of their times, and are sorted")
        values = np.array(record.numbers).reshape(-1, len(record.names))[first]
        if len(stamps) < 2:
            continue
        # q and −q are one rotation, but the line between them is none.
        turned = [record.names.index(name) for name in QUATERNION if name in record.names]
        values[:, turned] = continuous(values[:, turned])
        # Each sample stands at the nearest time of the clock that lies between samples.
        middles = 0.5 * (clock[1:] + clock[:-1])
        nearest = clock[np.clip(np.searchsorted(middles, stamps), 0, len(clock) - 1)]
        between = (nearest >= stamps[0]) & (nearest <= stamps[-1])
        at = np.unique(nearest[between])
        rows = np.searchsorted(clock, at)
        for k, name in enumerate(record.names):
            if name in columns and np.isfinite(columns[name][rows]).any():
                remarks.append(
                    f"{name} is given by several series of messages; that with most samples is "
                    f"taken"
                )
                continue
            column = columns.setdefault(name, np.full(len(clock), np.nan))
            column[rows] = np.interp(at, stamps, values[:, k])
    return {"time_ns": start + clock, **columns}


def _preference(record: _Series) -> tuple[bool, int]:
    """Sorts series by whether they have joints, then by their number of samples."""
    has_joints = any(name.startswith("q_") for name in record.names)
    return has_joints, len(record.stamps)


def continuous(quaternions: np.ndarray) -> np.ndarray:
    """Quaternions (n, 4) with the sign of each such that it is nearest to the one before.

    A quaternion and its opposite are one rotation, and no straight line leads from one to the
    other.
    """
    flips = np.sum(quaternions[1:] * quaternions[:-1], axis=1) < 0.0
    odd = np.cumsum(np.concatenate([[False], flips])) % 2
    return quaternions * np.where(odd, -1.0, 1.0)[:, None]


def _joints(message: Any) -> NamedNumbers:
    if len(message.position) != len(message.name):
        return (), ()
    names = tuple(f"q_{name}" for name in message.name)
    if len(message.velocity) != len(names):
        return names, message.position.tolist()
    return (*names, *(f"qd_{name}" for name in message.name)), [
        *message.position.tolist(),
        *message.velocity.tolist(),
    ]


def _pose(pose: Any) -> NamedNumbers:
    r, q = pose.position, pose.orientation
    return POSE, (r.x, r.y, r.z, q.w, q.x, q.y, q.z)


def _odometry(message: Any) -> NamedNumbers:
    names, numbers = _twist(message.twist.twist, "_body")
    return (*POSE, *names), (*_pose(message.pose.pose)[1], *numbers)


def _twist(twist: Any, suffix: str = "") -> NamedNumbers:
    v, w = twist.linear, twist.angular
    names = tuple(f"{key}{suffix}" for key in ("vx", "vy", "vz", "wx", "wy", "wz"))
    return names, (v.x, v.y, v.z, w.x, w.y, w.z)


def _imu(message: Any) -> NamedNumbers:
    frame = message.header.frame_id
    names: list[str] = []
    numbers: list[float] = []
    q = message.orientation
    # By convention −1 says that there is no such measurement.
    has_attitude = message.orientation_covariance[0] != -1.0
    if has_attitude and (q.w or q.x or q.y or q.z):
        names += QUATERNION
        numbers += [q.w, q.x, q.y, q.z]
    for kind, vector, covariance in (
        ("w", message.angular_velocity, message.angular_velocity_covariance),
        ("a", message.linear_acceleration, message.linear_acceleration_covariance),
    ):
        if frame and covariance[0] != -1.0:
            names += [f"{kind}{axis}@{frame}" for axis in "xyz"]
            numbers += [vector.x, vector.y, vector.z]
    return tuple(names), numbers


KINDS = {
    "sensor_msgs/msg/JointState": _Kind("joints", ("joint_states", "joint_state"), _joints),
    "nav_msgs/msg/Odometry": _Kind("pose", ("odom", "odometry", "state_estimate"), _odometry),
    "geometry_msgs/msg/PoseStamped": _Kind(
        "pose", ("pose", "base_pose"), lambda message: _pose(message.pose)
    ),
    "geometry_msgs/msg/TwistStamped": _Kind(
        "twist", ("twist", "base_twist"), lambda message: _twist(message.twist)
    ),
    "sensor_msgs/msg/Imu": _Kind("attitude", ("imu", "imu/data", "data"), _imu),
}
"""The messages that are read.

The twist of Odometry is in the axes of the base, that of TwistStamped in those of the world.
"""
