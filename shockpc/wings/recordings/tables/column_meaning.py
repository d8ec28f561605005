"""Meaning of the columns of recorded landings and of logs, by their names.

Joint positions (JOINT or q_JOINT) and rates (before_JOINT or qd_JOINT), base attitude (qw … qz, or
roll, pitch, yaw) and position (x, y, z), its velocity (vx …) and angular velocity (wx …) in world
axes or, with _body, in those of the base; vx@FRAME … is the velocity of a contact, where it is not
empty; effort_JOINT the torque of a motor, for contacts of finite stiffness; after_… is measured
after the impact. Arrays qpos and qvel are MuJoCo's, the arrays name, position, velocity and effort
those of ROS's JointState.
"""

import re
from collections.abc import Container, Mapping
from typing import Annotated, Any, NamedTuple, TypeAlias

import numpy as np

from shockpc.landing.scenes.scene_fields import Option
from shockpc.robot.robot import Robot
from shockpc.text.errors import StudyError
from shockpc.text.printed import listed

RenameOption: TypeAlias = Annotated[
    Mapping[str, str] | None,
    Option(
        "Another name for a column, or for a joint in all of its columns. A * stands for the same "
        "text in both; an empty new name leaves a column out.",
        "Table",
        "NAME=[NAME]",
        "map",
    ),
]
"""New names of the columns of a table or a log, by their old ones."""

LABELS = {
    "row": ("name", "landing", "event", "id"),
    "time": ("time", "stamp", "timestamp", "t", "__time"),
}
"""Columns that name a row; the first of each kind that the table has.

They are carried through to the results.
"""

FRICTION = ("friction", "mu")

REMARKS = (*LABELS["row"], *LABELS["time"], *FRICTION, "contact", "stance")
"""Columns that are neither of the robot's state nor measured."""

COLUMN = re.compile(
    r"(?:(?P<after>after(?:(?P<ms>[0-9]{1,9}(?:\.[0-9]{1,9})?)ms)?_)|(?P<rate>before_|qd_)|(?P<effort>effort_)|q_)?(?P<name>.+?)(?P<deg>_deg)?"
)
BASE = re.compile(
    r"(?:base_)?(?:(?P<quaternion>q[wxyz])|(?P<angle>roll|pitch|yaw)|(?P<place>[xyz])|(?P<twist>[vw][xyz])(?P<body>_body)?)"
)
CONTACT_VELOCITY = re.compile(r"v([xyz])@(.+)")
ROS = (
    (re.compile(r"(?=.*/position\Z)(?:.*/)?joint_states?/(.+)/position"), "q_{}"),
    (re.compile(r"(?=.*/velocity\Z)(?:.*/)?joint_states?/(.+)/velocity"), "before_{}"),
    (re.compile(r"(?=.*/effort\Z)(?:.*/)?joint_states?/(.+)/effort"), "effort_{}"),
    (re.compile(r".*pose/orientation/([wxyz])"), "base_q{}"),
    (re.compile(r".*pose/position/([xyz])"), "base_{}"),
    (re.compile(r".*twist/linear/([xyz])"), "base_v{}_body"),
    (re.compile(r".*twist/angular/([xyz])"), "base_w{}_body"),
)
"""Columns of recorded ROS messages JointState and Odometry.

The twist of Odometry is in the axes of the base. A name that ends otherwise is left at once, so
that the time is linear in its length.
"""


class ColumnName(NamedTuple):
    """Meaning of the name of a column.

    Attributes:
        target: the joint, what is known of the base, KEY@PLACE, or a name that means neither.
        after: whether it was measured after the impact.
        time: after the touchdown [ms]; None where none is given.
        rate: whether it is a rate.
        effort: whether it is the torque of a motor.
        degrees: whether it is in degrees.
        base: "qw" … "qz", "roll", "pitch", "yaw", "x", "y", "z", "vx" … "vz" or "wx" … "wz" of the
            base; empty if it is not of it.
        in_body: whether that velocity is in axes of the base.
    """

    target: str
    after: bool = False
    time: float | None = None
    rate: bool = False
    effort: bool = False
    degrees: bool = False
    base: str = ""
    in_body: bool = False


def column_name(name: str, robot: Robot) -> ColumnName | None:
    """Meaning of the name of a column; None if it is empty.

    A name of a joint means that joint before anything else.
    """
    joints = robot.joint_names
    if name in joints:
        return ColumnName(name)
    form = COLUMN.fullmatch(name)
    if form is None:
        return None
    target = form["name"]
    degrees = form["deg"] or ""
    if form["effort"] or target + degrees in joints:
        target += degrees
        degrees = ""
    of_joint = form["effort"] or form["rate"] == "qd_" or target in joints
    base = None if of_joint else BASE.fullmatch(target)
    key = ""
    if base is not None:
        key = base["quaternion"] or base["angle"] or base["place"] or base["twist"]
    return ColumnName(
        target,
        after=bool(form["after"]),
        time=None if form["ms"] is None else float(form["ms"]),
        rate=bool(form["rate"]),
        effort=bool(form["effort"]),
        degrees=bool(degrees),
        base=key,
        in_body=bool(base and base["body"]),
    )


def named_columns(
    columns: Mapping[str, np.ndarray], rename: Mapping[str, str]
) -> dict[str, np.ndarray]:
    """Columns by the names that are used here.

    Those of ROS and numbered ones are expanded, then renamed as for `rows_of`.
    """
    return _renamed(_expanded(columns), rename)


class StateColumns(NamedTuple):
    """Columns of a table by the names that `rows_of` knows.

    They are positions, rates, and those that are not of the robot's state.
    """

    positions: dict[str, np.ndarray]
    rates: dict[str, np.ndarray]
    others: dict[str, np.ndarray]


def state_columns(
    columns: Mapping[str, np.ndarray], robot: Robot, rename: Mapping[str, str]
) -> StateColumns:
    """Tell the columns that hold the state of a robot from the other ones.

    The arguments and errors are those of `rows_of`, but that a column may name nothing in the
    robot.
    """
    state = StateColumns({}, {}, {})
    joints = set(robot.joint_names)
    for name, values in named_columns(columns, rename).items():
        column = column_name(name, robot)
        part = state.others
        if name in ("qpos", "qvel") and name not in joints:
            part = state.positions if name == "qpos" else state.rates
        elif column is not None and _is_state(column, joints):
            is_rate = column.rate or column.base[:1] in ("v", "w")
            part = state.rates if is_rate else state.positions
        part[name] = values
    return state


def _is_state(column: ColumnName, joints: Container[str]) -> bool:
    """True if a column is a position or a rate of a joint or the base before the impact."""
    if column.after or column.effort:
        return False
    return bool(column.base) or column.target in joints


def _renamed(columns: dict[str, np.ndarray], rename: Mapping[str, str]) -> dict[str, np.ndarray]:
    """The columns by their new names.

    A name of a joint also renames its position, its rate and its measurements.
    """
    renamed: dict[str, np.ndarray] = {}
    used = set()
    for name, values in columns.items():
        new = name
        for old, wanted in rename.items():
            pattern = "(.*)".join(map(re.escape, old.split("*", 1)))
            match = re.fullmatch(
                rf"((?:q_|qd_|before_|effort_|after(?:[\d.]+ms)?_)?){pattern}(_deg)?", name
            )
            if match is not None:
                used.add(old)
                prefix, *star, suffix = match.groups()
                new = (
                    prefix + wanted.replace("*", star[0] if star else "*") + (suffix or "")
                    if wanted
                    else ""
                )
                break
        if new in renamed:
            raise twice(f'"{new}"')
        if new:
            renamed[new] = values
    if unused := [old for old in rename if old not in used]:
        raise StudyError(
            f'--map: the table has no column for "{unused[0]}"; its columns: {listed(columns, 12)}'
        )
    return renamed


def _expanded(columns: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The columns with those of ROS by our names, and numbered ones of qpos and qvel as arrays."""
    columns = dict(columns)
    # As in ROS's JointState: names of the joints, and arrays with a column for each.
    if {"name", "position"} <= columns.keys() and columns["position"].ndim == 2:
        names = [str(name) for name in columns.pop("name").ravel()]
        for key, prefix in (("position", "q_"), ("velocity", "before_"), ("effort", "effort_")):
            values = columns.pop(key, np.zeros((0, len(names))))
            if values.ndim != 2 or values.shape[1] != len(names):
                raise StudyError(
                    f"{key} has shape {values.shape}, and name has {len(names)} joints; they have "
                    f"to be rows of as many"
                )
            if values.size:
                columns |= {prefix + name: values[:, k] for k, name in enumerate(names)}
    expanded: dict[str, Any] = {}
    numbered: dict[str, dict[int, np.ndarray]] = {}
    # qpos0, qpos_0, qpos.0 and qpos[0] all are the first number of qpos.
    for name, values in columns.items():
        if match := re.fullmatch(r"(qpos|qvel)(?:_|\.|\[)?([0-9]{1,9})\]?", name):
            numbered.setdefault(match[1], {})[int(match[2])] = values
        else:
            expanded[_by_our_name(name)] = values
    # A missing number would shift all that follow.
    for name, parts in numbered.items():
        without_gaps = sorted(parts) == list(range(len(parts)))
        shapes = {part.shape for part in parts.values()}
        if not without_gaps or len(shapes) > 1:
            raise StudyError(
                f"the columns of {name} have to be numbered from 0 without gaps, and of one length"
            )
        expanded[name] = np.stack([parts[k] for k in range(len(parts))], axis=1)
    return expanded


def _by_our_name(name: str) -> str:
    """Our name of a column of ROS; any other name as it is."""
    for pattern, form in ROS:
        if match := pattern.fullmatch(name):
            return form.format(match[1])
    return name


def twice(quantity: str) -> StudyError:
    """The error for two columns that mean the same."""
    return StudyError(
        f"two columns of the table mean {quantity}; leave one of them out with --map COLUMN="
    )
