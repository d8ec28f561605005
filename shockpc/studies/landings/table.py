"""A table of recorded landings: what its columns mean, and its rows as configurations and motions before the impact.

A row is a touchdown. Columns are named: joint positions (JOINT or q_JOINT) and rates (before_JOINT or qd_JOINT), base attitude
(qw … qz, or roll, pitch, yaw) and position (x, y, z), its velocity (vx …) and angular velocity (wx …) in world axes or, with _body,
in those of the base; after_… holds what was measured after the impact. Arrays qpos and qvel are those of MuJoCo, the arrays name,
position and velocity those of ROS's JointState.
"""

import csv
import itertools
import re
import zipfile
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.errors import StudyError
from shockpc.landing import PosedLanding
from shockpc.model.motion import Motion
from shockpc.model.posture import set_many, settable_joints
from shockpc.paths import usable_path
from shockpc.printed import listed
from shockpc.robot.mjcf import qpos_order, qvel_order
from shockpc.robot.record import Joint, Robot

DEG = np.pi / 180.0

UNIT_LENGTH = 1e-3
"""Largest deviation of a quaternion's length from 1."""

TURN = 2.0 * np.pi + 0.5
"""Angle of a joint without limits, or of the base, above which it is taken for degrees [rad]."""

FASTEST = 200.0
"""Rate of a joint above which it is taken for degrees per second [rad/s]."""

NAMES, NOTES = ("name", "landing", "event", "id"), ("time", "stamp", "timestamp", "t")
"""Columns that name a row, and others that are not used."""

BASE = re.compile(
    r"(?:base_)?(?:(?P<quaternion>q[wxyz])|(?P<angle>roll|pitch|yaw)|(?P<place>[xyz])|(?P<twist>[vw][xyz])(?P<body>_body)?)"
)
AFTER = re.compile(r"after(?:(\d+(?:\.\d+)?)ms)?_(.+)")
ROS = (
    (re.compile(r"(?:.*/)?joint_states?/(.+)/position"), "q_{}"),
    (re.compile(r"(?:.*/)?joint_states?/(.+)/velocity"), "before_{}"),
    (re.compile(r".*pose/orientation/([wxyz])"), "base_q{}"),
    (re.compile(r".*pose/position/([xyz])"), "base_{}"),
    (re.compile(r".*twist/linear/([xyz])"), "base_v{}_body"),
    (re.compile(r".*twist/angular/([xyz])"), "base_w{}_body"),
)
"""Columns of recorded ROS messages JointState and Odometry, whose twist is in the axes of the base."""


class Measured(NamedTuple):
    """A jump that was measured.

    Attributes:
        name: of its column, without its beginning.
        time: after the touchdown [ms]; None where no time is said.
        group: quantities that are compared together: "joint rates", "base velocity", "base angular velocity", or its own name.
        key: quantity of the table that predicts it, KEY@PLACE; of the base its component, "vx" … "wz".
        unit: of the values.
        jump: (n,) after the impact less before it.
    """

    name: str
    time: float | None
    group: str
    key: str
    unit: str
    jump: Array


class Rows(NamedTuple):
    """The rows of a table.

    Attributes:
        names: (n,) of the rows: as the table names them, else their numbers.
        Q: (n, nq) configurations; what the table does not give is the scene's.
        before: motions before the impact, one for each row.
        joints: names of the joints whose positions the table gives.
        rates: names of those whose rates it gives.
        contact: (n,) contacts of each row, A+B; None where all rows have those of the scene.
        friction: (n,) coefficients of friction; None where they are the scene's.
        measured: jumps that were measured.
        given: what the table gives, in words.
        missing: what is the scene's, in words.
    """

    names: np.ndarray
    Q: Array
    before: Motion
    joints: tuple[str, ...]
    rates: tuple[str, ...]
    contact: np.ndarray | None
    friction: Array | None
    measured: tuple[Measured, ...]
    given: tuple[str, ...]
    missing: tuple[str, ...]


def read_table(path: Path) -> dict[str, np.ndarray]:
    """The columns of a CSV, Parquet or NPZ file by name: numbers or texts, (n,); arrays of NPZ may be (n, k).

    Raises:
        StudyError: the file cannot be read, has no rows, a name twice, a cell that is no number among numbers, or a column that
            holds neither real numbers nor texts.
    """
    path = usable_path(str(path))
    try:
        match path.suffix.casefold():
            case ".csv":
                columns = _read_csv(path)
            case ".parquet":
                columns = _read_parquet(path)
            case ".npz":
                with path.open("rb") as stream, np.load(stream, allow_pickle=False) as file:
                    columns = {name: file[name] for name in file.files}
            case _:
                raise StudyError(f'"{path}" is not a table of landings; valid are .csv, .parquet and .npz files')
    except (OSError, ValueError, EOFError, RuntimeError, zipfile.BadZipFile, zlib.error) as refusal:
        raise StudyError(f'table "{path}" cannot be read: {refusal}') from None
    for name, values in columns.items():
        if values.ndim == 0 or values.dtype.kind not in "fiubOUSM":
            raise StudyError(
                f'table "{path}": {name} is {values.dtype} of shape {values.shape}; columns hold real numbers or texts'
            )
    if not columns or min(map(np.size, columns.values())) == 0:
        raise StudyError(f'table "{path}" has no rows')
    return columns


def _read_csv(path: Path) -> dict[str, np.ndarray]:
    with path.open(encoding="utf-8-sig", newline="") as file:
        lines = csv.reader(file)
        header = [name.strip() for name in next(lines, [])]
        first = next((line for line in lines if line), None)
    if first is None:
        return {}
    if twice := [name for k, name in enumerate(header) if name in header[:k]]:
        raise ValueError(f'it has two columns "{twice[0]}"')
    texts = [k for k, cell in enumerate(first) if _number(cell) is None and cell.strip()]
    numbers = [k for k in range(len(header)) if k not in texts]
    try:
        chosen = numbers if texts else None
        values = np.loadtxt(path, delimiter=",", skiprows=1, usecols=chosen, ndmin=2, quotechar='"', encoding="utf-8-sig")
        rows: list[list[str]] = []
        if texts:
            with path.open(encoding="utf-8-sig", newline="") as file:
                rows = [row for row in itertools.islice(csv.reader(file), 1, None) if row]
        if values.shape[1] != len(numbers) or any(len(row) != len(header) for row in rows):
            raise ValueError("its rows and its header differ in length")
        columns: dict[str, np.ndarray] = {header[k]: values[:, place] for place, k in enumerate(numbers)}
        columns |= {header[k]: np.array([row[k].strip() for row in rows]) for k in texts}
    except (ValueError, IndexError):
        _refuse_cell(path, header, numbers)
        raise
    return {name: columns[name] for name in header}


def _refuse_cell(path: Path, header: Sequence[str], numbers: Sequence[int]) -> None:
    """Raise ValueError for the first row of a CSV file that is no row of numbers."""
    with path.open(encoding="utf-8-sig", newline="") as file:
        for i, row in enumerate(itertools.islice(csv.reader(file), 1, None)):
            if row and len(row) != len(header):
                raise ValueError(f"row {i} has {len(row)} cells, and the header {len(header)}")
            for k in numbers if row else ():
                if _number(row[k]) is None:
                    raise ValueError(f'row {i}, column {header[k]}: "{row[k]}" is not a number')


def _number(cell: str) -> float | None:
    try:
        return float(cell)
    except ValueError:
        return None


def _read_parquet(path: Path) -> dict[str, np.ndarray]:
    try:
        import pyarrow.parquet  # an extra
    except ImportError:
        raise StudyError(
            'Parquet files need the package "pyarrow"; install it with: pip install pyarrow, or give a CSV or NPZ file'
        ) from None
    table = pyarrow.parquet.read_table(path)
    return {name: np.asarray(table[name].to_numpy()) for name in table.column_names}


def rows_of(columns: Mapping[str, np.ndarray], landing: PosedLanding, rename: Mapping[str, str] | None = None) -> Rows:
    """The rows of a table for a robot.

    Args:
        columns: by name, as `read_table` gives them.
        landing: gives what the table does not.
        rename: other names for columns or joints of the table; those that become empty are left out. Names may be globs with one *,
            which stands for the same text in the new name.

    Raises:
        UnknownName: a column names no joint of the robot; the text names the nearest.
        StudyError: a number is not finite, a quaternion's length is not 1, angles look like degrees; with the row.
    """
    return _Reader(landing, _renamed(_expanded(columns, landing.robot), rename or {})).rows()


def _renamed(columns: dict[str, np.ndarray], rename: Mapping[str, str]) -> dict[str, np.ndarray]:
    """The columns by their new names. A name of a joint is found in those of its position, rate and measurements too."""
    found: dict[str, np.ndarray] = {}
    used = set()
    for name, values in columns.items():
        new = name
        for old, wanted in rename.items():
            pattern = "(.*)".join(map(re.escape, old.split("*", 1)))
            match = re.fullmatch(rf"((?:q_|qd_|before_|after(?:[\d.]+ms)?_)?){pattern}(_deg)?", name)
            if match is not None:
                used.add(old)
                prefix, *star, suffix = match.groups()
                new = prefix + wanted.replace("*", star[0] if star else "*") + (suffix or "") if wanted else ""
                break
        if new in found:
            raise StudyError(f'two columns of the table mean "{new}"; leave one of them out with --map COLUMN=')
        if new:
            found[new] = values
    if unused := [old for old in rename if old not in used]:
        raise StudyError(f'--map: the table has no column for "{unused[0]}"; its columns: {listed(columns, 12)}')
    return found


def _expanded(columns: Mapping[str, np.ndarray], robot: Robot) -> dict[str, np.ndarray]:
    """The columns with those of ROS by our names, and numbered ones of qpos and qvel as arrays."""
    columns = dict(columns)
    if {"name", "position"} <= columns.keys() and columns["position"].ndim == 2:
        names = [str(name) for name in columns.pop("name").ravel()]
        for key, prefix in (("position", "q_"), ("velocity", "before_")):
            values = columns.pop(key, np.zeros((0, len(names))))
            if values.ndim != 2 or values.shape[1] != len(names):
                raise StudyError(
                    f"{key} has shape {values.shape}, and name has {len(names)} joints; they have to be rows of as many"
                )
            columns |= {prefix + name: values[:, k] for k, name in enumerate(names) if values.size}
        columns.pop("effort", None)
    found: dict[str, Any] = {}
    numbered: dict[str, dict[int, np.ndarray]] = {}
    for name, values in columns.items():
        if match := re.fullmatch(r"(qpos|qvel)(?:_|\.|\[)?(\d+)\]?", name):
            numbered.setdefault(match[1], {})[int(match[2])] = values
            continue
        form = next((form.format(m[1]) for pattern, form in ROS if (m := pattern.fullmatch(name))), name)
        if not name.endswith("/effort"):
            found[form] = values
    for name, parts in numbered.items():
        if sorted(parts) != list(range(len(parts))):
            raise StudyError(f"the columns of {name} have to be numbered from 0 without gaps")
        found[name] = np.stack([parts[k] for k in range(len(parts))], axis=1)
    for name in ("qpos", "qvel"):
        if name in found and np.ndim(found[name]) == 2:
            qpos_order(robot)  # refuses a robot whose order is not known
    return found


class _Reader:
    """Reads named columns into arrays."""

    def __init__(self, landing: PosedLanding, columns: dict[str, np.ndarray]) -> None:
        self.landing, self.robot, self.columns = landing, landing.robot, columns
        lengths = {name: len(values) for name, values in columns.items()}
        if len(set(lengths.values())) > 1:
            raise StudyError(f"the columns differ in length: {', '.join(f'{name} {n}' for name, n in lengths.items())}")
        self.n = next(iter(lengths.values()), 0)
        self.Q = np.repeat(landing.q[None], self.n, axis=0)
        self.rates = np.repeat(landing.before.joint_rates[None], self.n, axis=0)
        self.positions: dict[str, Joint] = {}
        self.moving: dict[str, Joint] = {}
        self.base: dict[str, Array] = {}
        self.in_body: set[str] = set()
        self.after: list[tuple[str, float | None, str, Array]] = []
        self.texts: dict[str, np.ndarray] = {}

    def rows(self) -> Rows:
        """Read all columns."""
        for name, values in self.columns.items():
            self._read(name, values)
        robot, Q = self.robot, self.Q
        if not robot.free_base and self.base:
            raise StudyError(f'the base of robot "{robot.name}" is fixed in its file; leave out {listed(self.base)}')
        set_many(robot, (), Q)
        rotation = self._attitude()
        before = self.landing.before
        velocity, omega = (self._vector(kind, default, rotation) for kind, default in (("v", before.velocity), ("w", before.omega)))
        if self.moving:
            for mimic in robot.mimics:
                leaders = [robot.joint(name) for name in mimic.leaders]
                led = [by * self.rates[:, j.v.start] for j, by in zip(leaders, mimic.leaders.values(), strict=True)]
                self.rates[:, robot.joint(mimic.joint).v] = np.sum(led, axis=0)[:, None] if led else 0.0
        motion = Motion(velocity, omega, self.rates)
        names = next((self.texts[key] for key in NAMES if key in self.texts), np.arange(self.n))
        friction = self.texts.get("friction", self.texts.get("mu"))
        measured = tuple(self._measured(*one, motion, rotation) for one in self.after)
        given, missing = self._origins()
        return Rows(
            np.array([f"{name:g}" if isinstance(name, float) else str(name) for name in names.tolist()]),
            Q, motion, tuple(self.positions), tuple(self.moving),
            self.texts.get("contact"), None if friction is None else self._finite("friction", friction), measured, given, missing,
        )  # fmt: skip

    def _read(self, name: str, values: np.ndarray) -> None:
        if name in ("qpos", "qvel") and values.ndim == 2:
            self._mujoco(name, values)
            return
        if values.ndim != 1:
            raise StudyError(f"column {name} has shape {values.shape}; it has to be one number a row")
        if name in (*NAMES, *NOTES, "contact", "friction", "mu"):
            self.texts[name] = values
            return
        after, target = AFTER.fullmatch(name), name
        if after is not None:
            target = after[2]
        role = "q"
        for prefix, own in (("before_", "v"), ("qd_", "v"), ("q_", "q")):
            if after is None and name.startswith(prefix) and name not in self.robot.joint_names:
                target, role = name.removeprefix(prefix), own
                break
        plain, degrees = target, 1.0
        if target.endswith("_deg") and target not in self.robot.joint_names:
            plain, degrees = target.removesuffix("_deg"), DEG
        base = BASE.fullmatch(plain) if plain not in self.robot.joint_names else None
        if plain not in self.robot.joint_names and base is None and "@" not in plain:
            if values.dtype.kind not in "fiub":
                return  # a remark
            known = (*self.robot.joint_names, "qw", "roll", "vx", "vx_body", "wx", "contact", "friction")
            raise self.robot.unknown("joint", plain, known, f'to leave the column out: --map "{name}="')
        numbers = self._finite(name, values) * degrees
        if after is not None:
            self.after.append((plain, None if after[1] is None else float(after[1]), name, numbers))
        elif base is not None:
            self._base(name, base, numbers, degrees)
        elif "@" in plain:
            raise StudyError(f"column {name}: a quantity is measured after the impact; name the column after_{plain}")
        else:
            self._joint(name, plain, role, numbers, degrees)

    def _finite(self, name: str, values: np.ndarray) -> Array:
        try:
            if values.dtype.kind == "M":
                raise ValueError
            numbers = values.astype(float)
        except (ValueError, TypeError):
            raise StudyError(f"column {name} has to hold numbers") from None
        if (wrong := np.flatnonzero(~np.isfinite(numbers))).size:
            raise StudyError(
                f"row {wrong[0]}, column {name}: {numbers[wrong[0]]} is not a finite number; leave the row out", rows=wrong.tolist()
            )
        return numbers

    def _base(self, name: str, base: re.Match[str], numbers: Array, degrees: float) -> None:
        key = base["quaternion"] or base["angle"] or base["place"] or base["twist"]
        if key in self.base:
            raise StudyError(f'two columns of the table mean "{key}" of the base; leave one of them out with --map COLUMN=')
        if base["angle"] and degrees == 1.0:
            self._refuse_degrees(name, numbers, np.abs(numbers) > TURN)
        self.base[key] = numbers
        if base["body"]:
            self.in_body.add(key)

    def _joint(self, name: str, joint_name: str, role: str, numbers: Array, degrees: float) -> None:
        """A column of a joint's positions or rates."""
        (joint,) = settable_joints(self.robot, joint_name, StudyError)
        turns = joint.unit == "rad"
        if degrees != 1.0 and not turns:
            raise StudyError(f"column {name}: the joint is prismatic, and its unit is m, not deg")
        known = self.positions if role == "q" else self.moving
        if joint.name in known:
            raise StudyError(f'two columns of the table mean joint "{joint.name}"; leave one of them out with --map COLUMN=')
        known[joint.name] = joint
        if role == "v":
            if turns and degrees == 1.0:
                self._refuse_degrees(name, numbers, np.abs(numbers) > FASTEST)
            self.rates[:, joint.v] = numbers[:, None]
            return
        if turns and degrees == 1.0:
            low, high = joint.limits
            outside = (numbers < low - 0.5) | (numbers > high + 0.5)
            as_degrees = (numbers * DEG >= low - 0.1) & (numbers * DEG <= high + 0.1)
            wide = np.abs(numbers) > TURN if joint.kind == "continuous" or not np.isfinite(high - low) else outside & as_degrees
            self._refuse_degrees(name, numbers, wide)
        set_many(self.robot, ((joint, numbers),), self.Q)

    def _refuse_degrees(self, name: str, numbers: Array, wrong: np.ndarray) -> None:
        if (rows := np.flatnonzero(wrong)).size:
            raise StudyError(
                f"row {rows[0]}, column {name}: {numbers[rows[0]]:g} looks like degrees, and the column is read in radians; "
                f"name it {name}_deg, correct it, or leave the column out (--map)",
                rows=rows.tolist(),
            )

    def _mujoco(self, name: str, values: Array) -> None:
        """All coordinates, or all velocities, in the layout of MuJoCo: a free base turns at a rate in its own axes."""
        order, size = qpos_order(self.robot) if name == "qpos" else qvel_order(self.robot)
        if values.shape[1] != size:
            raise StudyError(f"{name} has {values.shape[1]} columns, and those of the robot's file are {size}")
        found = self._finite(name, values.ravel()).reshape(values.shape)[:, order]
        joints = {joint.name: joint for joint in self.robot.single_joints if joint.kind != "free"}
        if name == "qpos":
            self.Q[:] = found
            self.positions |= joints
            for joint in self.robot.single_joints:
                if joint.kind in ("free", "ball"):
                    own = slice(joint.q.stop - 4, joint.q.stop)
                    self.Q[:, own] = self._unit(f"qpos of joint {joint.name}", self.Q[:, own])
            return
        self.rates = found
        self.moving |= joints
        if self.robot.free_base:
            self.base |= dict(zip(("vx", "vy", "vz", "wx", "wy", "wz"), found[:, :6].T.copy(), strict=True))
            self.rates[:, :6] = 0.0
            self.in_body |= {"wx", "wy", "wz"}

    def _unit(self, what: str, quaternions: Array) -> Array:
        """Quaternions (n, 4) of length 1."""
        length = np.linalg.norm(quaternions, axis=1)
        if (wrong := np.flatnonzero(np.abs(length - 1.0) > UNIT_LENGTH)).size:
            raise StudyError(
                f"row {wrong[0]}: {what} has length {length[wrong[0]]:.6g}; a rotation's quaternion has length 1",
                rows=wrong.tolist(),
            )
        return np.asarray(quaternions / length[:, None])

    def _attitude(self) -> Array:
        """Set the base, and return its rotations (n, 3, 3)."""
        from scipy.spatial.transform import Rotation

        if not self.robot.free_base:
            return np.broadcast_to(self.landing.state.rotation[0, 0], (self.n, 3, 3))
        quaternion = [self.base[key] for key in ("qx", "qy", "qz", "qw") if key in self.base]
        angles = [key for key in ("roll", "pitch", "yaw") if key in self.base]
        if quaternion and (len(quaternion) < 4 or angles):
            raise StudyError("the base's attitude is given by qw, qx, qy and qz, or by roll, pitch and yaw: all of one kind")
        if quaternion:
            self.Q[:, 3:7] = self._unit("the base's quaternion (qx, qy, qz, qw)", np.stack(quaternion, axis=1))
        elif angles:
            own = Rotation.from_quat(self.Q[:, 3:7]).as_euler("xyz")
            for k, key in enumerate(("roll", "pitch", "yaw")):
                own[:, k] = self.base.get(key, own[:, k])
            self.Q[:, 3:7] = Rotation.from_euler("xyz", own).as_quat()
        for k, axis in enumerate("xyz"):
            self.Q[:, k] = self.base.get(axis, self.Q[:, k])
        rotation = Rotation.from_quat(self.Q[:, 3:7]).as_matrix()
        body_rotation = self.robot.bodies[0].rotation
        return np.asarray(rotation @ body_rotation)

    def _vector(self, kind: str, default: Array, rotation: Array) -> Array:
        """A velocity of the base (n, 3), world axes."""
        keys = [f"{kind}{axis}" for axis in "xyz"]
        known = [key for key in keys if key in self.base]
        in_body = [key for key in known if key in self.in_body]
        if in_body and len(in_body) != 3:
            raise StudyError(f"{listed(in_body)} of the base in its own axes, but not all of {listed(keys)}; give all three")
        vector = np.stack([self.base.get(key, np.full(self.n, default[k])) for k, key in enumerate(keys)], axis=1)
        return np.asarray((rotation @ vector[..., None])[..., 0] if in_body else vector)

    def _measured(self, name: str, time: float | None, column: str, values: Array, before: Motion, rotation: Array) -> Measured:
        """What a column after the impact says of a jump."""
        base = BASE.fullmatch(name) if name not in self.robot.joint_names else None
        if base is not None and base["twist"]:
            if base["body"]:
                raise StudyError(f"column {column}: velocities after the impact are compared in world axes; convert them")
            group, whole = (
                ("base velocity", before.velocity) if base["twist"][0] == "v" else ("base angular velocity", before.omega)
            )
            if base["twist"] not in self.base:
                raise StudyError(f"column {column}: the table has no {base['twist']} before the impact, so its jump is not known")
            unit = "m/s" if base["twist"][0] == "v" else "rad/s"
            return Measured(name, time, group, base["twist"], unit, values - whole[:, "xyz".index(base["twist"][1])])
        if "@" in name:
            return Measured(name, time, name, name, "", values)
        if base is not None:
            raise StudyError(f"column {column}: only velocities change in an impact; leave it out with --map COLUMN=")
        joint = self.robot.joint(name)
        if name not in self.moving:
            raise StudyError(f"column {column}: the table has no rate of this joint before the impact, so its jump is not known")
        return Measured(name, time, "joint rates", f"delta_qd@{name}", f"{joint.unit}/s", values - self.rates[:, joint.v.start])

    def _origins(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        followers = {mimic.joint for mimic in self.robot.mimics}
        joints = [name for name in self.robot.joint_names if name not in followers]
        parts = {"contacts": "contact" in self.texts}
        if self.robot.free_base:
            parts |= {
                "base attitude": bool({"qw", "roll", "pitch", "yaw"} & self.base.keys()) or "qpos" in self.columns,
                **{f"base {key}": key in self.base for key in ("vx", "vy", "vz", "wx", "wy", "wz")},
            }
        given, missing = [what for what, known in parts.items() if known], [what for what, known in parts.items() if not known]
        for what, known in (("position", self.positions), ("rate", self.moving)):
            absent = [name for name in joints if name not in known]
            if known:
                given.append(f"{what}s of {len(known)} joint{'s' * (len(known) > 1)}")
            if absent:
                missing.append(f"{what} of {'all joints' if len(absent) == len(joints) else listed(absent, 8)}")
        return tuple(given), tuple(missing)
