"""Read a table of recorded landings: a row is a touchdown; `column_names` says what its columns are called."""

import contextlib
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from shockpc.core.spatial import Array
from shockpc.landing.contact import contacts_like, landing_frames
from shockpc.landing.landing import PosedLanding
from shockpc.landing.motion import Motion
from shockpc.landing.posture import set_many, settable_joints
from shockpc.landing.resolve import with_definite_contacts
from shockpc.landing.scene import Contact, Scene
from shockpc.recorded.column_names import (
    CONTACT_VELOCITY,
    FRICTION,
    LABELS,
    REMARKS,
    ColumnName,
    column_name,
    named_columns,
    twice,
)
from shockpc.recorded.files import number
from shockpc.recorded.rows import Measured, RecordedRows, contacts_of
from shockpc.robot.mjcf import qpos_order, qvel_order
from shockpc.text.arguments import LARGEST_NUMBER
from shockpc.text.errors import ShockError, StudyError
from shockpc.text.printed import listed

DEG = np.pi / 180.0

UNIT_LENGTH = 1e-3
"""Largest deviation of a quaternion's length from 1."""

ANGLES = ("roll", "pitch", "yaw")

TURNS = {"roll": np.pi, "pitch": np.pi}
"""Greatest angles of the base [rad]; its yaw may be counted over several turns."""

SERIES_ROWS, SERIES_RATIO = 100, 0.1
"""Rows of a table with times and no names, and the ratio of von Neumann (1941), mean squared difference of successive values over
twice their variance, of the median column, from and up to which it is taken for a time series. The ratio is 1 where rows are
independent, and 2 sin²(π f / f_s) for a motion at a frequency f that is sampled at f_s."""

EMPTY = " (as an empty cell, or a row with too few or too many, is read)"


def rows_of(columns: Mapping[str, np.ndarray], landing: PosedLanding, rename: Mapping[str, str] | None = None) -> RecordedRows:
    """The rows of a table for a robot.

    Args:
        columns: by name, as `read_table` gives them.
        landing: gives what the table does not.
        rename: other names for columns or joints of the table; those that become empty are left out. Names may be globs with one *,
            which stands for the same text in the new name.

    Raises:
        UnknownName: a column names no joint of the robot; the text names the nearest.
        StudyError: the rows are samples of a time series; or no row is a landing: the text has the reason of the first one, with
            its number, from 0, and its name. Of a row beside others the reason is its message: a cell is empty or no finite number,
            a quaternion's length is not 1.
    """
    columns = named_columns(columns, landing.robot, rename or {})
    if _is_series(columns):
        rows = max(map(len, columns.values()))
        raise StudyError(
            f"the {rows} rows look like samples of a time series, because each follows the one before it; a table of landings has "
            "a row for each touchdown: the motion just before it, and velocities just after it in columns after_…. To find the "
            "touchdowns of a log and write that table: shockpc touchdowns LOG ROBOT --out DIR. If each sample is to be a landing, "
            'give the rows names in a column "name"'
        )
    try:
        return _Reader(landing, columns).rows()
    except StudyError as refusal:
        if not refusal.rows or "name" not in columns:
            raise
        raise StudyError(f'landing "{columns["name"][refusal.rows[0]]}", {refusal}', **refusal.data) from None


def _is_series(columns: Mapping[str, np.ndarray]) -> bool:
    """Whether rows are samples of one motion, most of which are no touchdowns."""
    labelled = {label: any(name in columns for name in names) for label, names in LABELS.items()}
    if labelled["row"] or not labelled["time"]:
        return False
    ratios: list[float] = []
    for name, values in columns.items():
        if name not in LABELS["time"] and values.dtype.kind in "fiu" and len(values) >= SERIES_ROWS:
            known = values.reshape(len(values), -1).astype(float)
            known = known[np.isfinite(known).all(axis=1)]
            known = known[:, np.ptp(known, axis=0) > 1e-9] if len(known) >= SERIES_ROWS else known[:, :0]
            ratios += (np.mean(np.diff(known, axis=0) ** 2, axis=0) / (2.0 * np.var(known, axis=0))).tolist()
    return bool(ratios) and bool(np.median(ratios) < SERIES_RATIO)


def _number(cell: Any) -> float:
    """The number in a cell; NaN where there is none."""
    try:
        return number(cell) if isinstance(cell, str) else float(cell)
    except (ValueError, TypeError):
        return np.nan


def empty_cells(cells: np.ndarray) -> np.ndarray:
    """Which cells hold nothing, or say that they hold no number."""
    if cells.dtype.kind not in "UO":
        return np.asarray(np.isnan(cells.astype(float)))
    texts = np.array([cell.strip().casefold() if isinstance(cell, str) else "" for cell in cells.ravel().tolist()])
    return np.isin(texts, ("", "nan", "none", "null", "na", "n/a")).reshape(cells.shape)


def _in_rows(rows: np.ndarray, text: str) -> StudyError:
    """The error for some rows, of which the text names the first."""
    return StudyError(f"row {rows[0]}{',' if text.startswith('column') else ':'} {text}", rows=rows.tolist())


class _Reader:
    """Reads named columns into arrays."""

    def __init__(self, landing: PosedLanding, columns: dict[str, np.ndarray]) -> None:
        self.landing, self.robot, self.columns = landing, landing.robot, columns
        lengths = {name: len(values) for name, values in columns.items()}
        if len(set(lengths.values())) > 1:
            raise StudyError(f"the columns differ in length: {', '.join(f'{name} {n}' for name, n in lengths.items())}")
        self.n = next(iter(lengths.values()), 0)
        if not self.n:
            raise StudyError("the table has no rows")
        self.Q = np.repeat(landing.q[None], self.n, axis=0)
        self.rates = np.repeat(landing.before.joint_rates[None], self.n, axis=0)
        self.effort = np.full(self.rates.shape, np.nan)
        self.positions: set[str] = set()
        self.moving: set[str] = set()
        self.base: dict[str, Array] = {}
        self.in_body: set[str] = set()
        self.at_contact: dict[tuple[str, int], Array] = {}
        self.after: list[tuple[str, ColumnName, Array]] = []
        self.messages: dict[int, str] = {}
        self.warnings: list[str] = []

    def rows(self) -> RecordedRows:
        """Read all columns."""
        for name, values in self.columns.items():
            self._read(name, values)
        robot, n = self.robot, self.n
        if not robot.free_base and self.base:
            raise StudyError(f'the base of robot "{robot.name}" is fixed in its file; leave out {listed(self.base)}')
        set_many(robot, (), self.Q)
        rotation, before, friction = self._attitude(), self.landing.before, self._friction()
        defaults = ("v", self._base_velocity()), ("w", before.omega)
        velocity, omega = (self._vector(kind, default, rotation) for kind, default in defaults)
        for mimic in robot.mimics if self.moving else ():
            led = np.zeros(n)
            for leader, multiplier in mimic.leaders.items():
                led += multiplier * self.rates[:, robot.joint(leader).v.start]
            self.rates[:, robot.joint(mimic.joint).v] = led[:, None]
        before = Motion(velocity, omega, self.rates)
        scenes, index, velocities = self._scenes(friction)
        if len(self.messages) == n:
            raise _in_rows(np.arange(n), self.messages[0])
        labels = self._labels(contacts_of(scenes, index))
        return RecordedRows(
            labels, self.Q, before, scenes, index, velocities, friction, self.effort, tuple(self.positions),
            tuple(self.moving), *self._origins(), tuple(self._measured(*column, before) for column in self.after),
            messages=dict(sorted(self.messages.items())), warnings=tuple(self.warnings),
        )  # fmt: skip

    def _refuse(self, wrong: np.ndarray, text: Callable[[int], str]) -> None:
        """Note of some rows why they are no landings; the first reason of a row counts.

        Args:
            wrong: (n,) which rows.
            text: the reason, of a row by its number.
        """
        for i in np.flatnonzero(wrong).tolist():
            self.messages.setdefault(i, text(i))

    def _numbers(self, name: str, values: np.ndarray, missing: bool = False) -> Array:
        """A column of numbers, (n,) or (n, k); zero where there is none, and a row therefore refused.

        Args:
            name: of the column.
            values: its cells.
            missing: whether a cell may be empty or NaN, and then is NaN.
        """
        if values.dtype.kind == "M":
            raise StudyError(f"column {name} has to hold numbers")
        numbers = (
            np.array([_number(cell) for cell in values.ravel().tolist()]) if values.dtype.kind in "UO" else values.astype(float)
        )
        numbers, cells = numbers.reshape(self.n, -1), values.reshape(self.n, -1)
        known = np.isfinite(numbers) | (np.isnan(numbers) & empty_cells(cells) if missing else False)

        def reason(i: int) -> str:
            cell = cells[i, int(np.argmin(known[i]))]
            if isinstance(cell, str):
                return f'column {name}: "{cell}" is not a number' if cell else f"column {name} is empty"
            if cell is None:
                return f"column {name} is empty"
            no_number = (cells.dtype.kind != "O" or isinstance(cell, float)) and bool(np.isnan(cell))
            return f"column {name}: {cell} is not a finite number{EMPTY * no_number}"

        self._refuse(~known.all(axis=1), reason)
        far = np.abs(numbers) > LARGEST_NUMBER
        self._refuse(
            (known & far).any(axis=1),
            lambda i: f"column {name}: {np.abs(numbers[i]).max():g} is beyond {LARGEST_NUMBER:g}, whatever the unit",
        )
        return np.asarray(np.where(known & ~far, numbers, 0.0).reshape(values.shape))

    def _warn_of_degrees(self, name: str, numbers: Array, low: float, high: float) -> None:
        """Warn where a column in radians is outside of limits, and in degrees would be inside."""
        outside = (numbers < low - 0.5) | (numbers > high + 0.5)
        if (rows := np.flatnonzero(outside & (numbers * DEG >= low - 0.1) & (numbers * DEG <= high + 0.1))).size:
            self.warnings.append(
                f"column {name}: {numbers[rows[0]]:g} in row {rows[0]} looks like degrees (the limits are {low:.4g} and {high:.4g} "
                f"rad), and the column is read in radians; name it {name}_deg if it holds degrees"
            )

    def _unit(self, what: str, quaternions: Array) -> Array:
        """Quaternions (n, 4) of length 1; where one is none, the row is refused."""
        length = np.linalg.norm(quaternions, axis=1)
        wrong = np.abs(length - 1.0) > UNIT_LENGTH
        self._refuse(wrong, lambda i: f"{what} has length {length[i]:.6g}; a rotation's quaternion has length 1")
        return np.where(wrong[:, None], np.array([0.0, 0.0, 0.0, 1.0]), quaternions / np.where(wrong, 1.0, length)[:, None])

    def _read(self, name: str, values: np.ndarray) -> None:
        joints = self.robot.joint_names
        if name in ("qpos", "qvel") and name not in joints:
            self._mujoco(name, values)
            return
        if values.ndim != 1:
            raise StudyError(f"column {name} has shape {values.shape}; it has to be one number a row")
        if name in REMARKS and name not in joints:
            return
        named = column_name(name, self.robot)
        if named is None:
            raise StudyError("a column has no name; give it one in the header of the table")
        target, after, degrees = named.target, named.after, named.degrees
        if named.effort:
            self._effort(name, target, values)
            return
        at_contact = CONTACT_VELOCITY.fullmatch(target) if not (after or degrees) else None
        if at_contact is not None:
            key = self.robot.frame(at_contact[2]).name, "xyz".index(at_contact[1])
            if key in self.at_contact:
                raise twice(f'"{target}"')
            self.at_contact[key] = self._numbers(name, values, missing=True)
            return
        if target not in joints and not named.base and "@" not in target:
            if values.dtype.kind not in "fiub":
                return  # a remark
            known = (*joints, "qw", "roll", "vx", "vx_body", "wx", "vx@FRAME", "contact", "friction")
            raise self.robot.unknown("joint", target, known, f'to leave the column out: --map "{name}="')
        if degrees and named.base and not (named.base in ANGLES or named.base.startswith("w")):
            raise StudyError(f"column {name} is neither an angle nor a rate of rotation, so it is not in degrees; leave out _deg")
        numbers = self._numbers(name, values, missing=after) * (DEG if degrees else 1.0)
        if after:
            self.after.append((name, named, numbers))
        elif named.base:
            self._base(name, named, numbers)
        elif "@" in target:
            raise StudyError(f"column {name}: a quantity is measured after the impact; name the column after_{target}")
        else:
            self._joint(name, target, named.rate, numbers, degrees)

    def _base(self, name: str, named: ColumnName, numbers: Array) -> None:
        """Read a column of the base."""
        key = named.base
        if key in self.base:
            raise twice(f'"{key}" of the base')
        if key in TURNS and not named.degrees:
            self._warn_of_degrees(name, numbers, -TURNS[key], TURNS[key])
        self.base[key] = numbers
        if named.in_body:
            self.in_body.add(key)

    def _joint(self, name: str, joint_name: str, rate: bool, numbers: Array, degrees: bool) -> None:
        """Read a column of a joint's positions or rates."""
        (joint,) = settable_joints(self.robot, joint_name, StudyError)
        if degrees and joint.unit != "rad":
            raise StudyError(f"column {name}: the joint is prismatic, and its unit is m, not deg")
        known = self.moving if rate else self.positions
        if joint.name in known:
            raise twice(f'joint "{joint.name}"')
        known.add(joint.name)
        low, high = joint.limits
        # A file without limits may give zeros for both of them.
        if joint.unit == "rad" and not (degrees or rate or joint.kind == "continuous") and np.isfinite(high - low) and low < high:
            self._warn_of_degrees(name, numbers, low, high)
        if rate:
            self.rates[:, joint.v] = numbers[:, None]
        else:
            set_many(self.robot, ((joint, numbers),), self.Q)

    def _effort(self, name: str, joint_name: str, values: np.ndarray) -> None:
        """Read a column of the torques of a joint's motor; an empty cell leaves that of the scene."""
        (joint,) = settable_joints(self.robot, joint_name, StudyError)
        if not np.isnan(self.effort[:, joint.v]).all():
            raise twice(f'the effort of joint "{joint.name}"')
        self.effort[:, joint.v] = np.where(empty_cells(values), np.nan, self._numbers(name, values, missing=True))[:, None]

    def _mujoco(self, name: str, values: Array) -> None:
        """Read all coordinates, or all velocities, in the layout of MuJoCo: a free base turns at a rate in body axes."""
        order, size = qpos_order(self.robot) if name == "qpos" else qvel_order(self.robot)
        if values.ndim != 2 or values.shape[1] != size:
            raise StudyError(f"{name} has shape {values.shape}, and a row of it has the {size} numbers of the robot's file")
        numbers = self._numbers(name, values)[:, order]
        joints = {joint.name for joint in self.robot.single_joints if joint.kind != "free"}
        if name == "qpos":
            self.Q[:] = numbers
            self.positions |= joints
            for joint in self.robot.single_joints:
                if joint.kind in ("free", "ball"):
                    quaternion = slice(joint.q.stop - 4, joint.q.stop)
                    self.Q[:, quaternion] = self._unit(f"qpos of joint {joint.name}", self.Q[:, quaternion])
            return
        self.rates = numbers
        self.moving |= joints
        if self.robot.free_base:
            self.base |= dict(zip(("vx", "vy", "vz", "wx", "wy", "wz"), numbers[:, :6].T.copy(), strict=True))
            self.rates[:, :6] = 0.0
            self.in_body |= {"wx", "wy", "wz"}

    def _labels(self, contacts: np.ndarray) -> dict[str, np.ndarray]:
        labels = {"row": np.arange(self.n)}
        for key, names in LABELS.items():
            for name in reversed([name for name in names if name in self.columns and name not in self.robot.joint_names]):
                labels[key] = self.columns[name]
        rows = [f"{name:g}" if isinstance(name, float) else str(name) for name in labels.pop("row").tolist()]
        labels = {key: x if x.dtype.kind in "fiu" else x.astype(str) for key, x in labels.items()}
        return {"name": np.array(rows), "contact": contacts, **labels}

    def _scenes(self, friction: Array) -> tuple[tuple[Scene, ...], np.ndarray, Array]:
        """The scenes that differ in their contacts, in which of them have a velocity, or in the standing feet.

        Returns: the scenes, which of them each row (n,) is of, and the velocities (n, c, 3) of contacts.
        """
        scene, index, texts = self.landing.scene, np.zeros(self.n, dtype=int), [""]
        if "contact" in self.columns:
            distinct, index = np.unique(self.columns["contact"].astype(str), return_inverse=True)
            texts = distinct.tolist()
        landings = [self._landing(text, index == k) if text else scene.contact for k, text in enumerate(texts)]
        # The same contacts in another order are the same landing.
        first: dict[tuple[str, ...], int] = {}
        index = np.array([first.setdefault(tuple(sorted(map(repr, contacts))), k) for k, contacts in enumerate(landings)])[index]
        velocities = np.full((self.n, max(map(len, landings)), 3), np.nan)
        for k in first.values():
            landing_rows = np.flatnonzero(index == k)
            for c, contact in enumerate(landings[k]):
                velocities[landing_rows, c] = np.nan if contact.velocity is None else contact.velocity
                given = [self.at_contact[contact.frame, axis] for axis in range(3) if (contact.frame, axis) in self.at_contact]
                if given and len(given) < 3:
                    raise StudyError(f'the velocity of contact "{contact.frame}" needs all of vx@, vy@ and vz@{contact.frame}')
                if given:
                    of_rows = np.stack(given, axis=1)[landing_rows]
                    known = ~np.isnan(of_rows)
                    velocities[landing_rows, c] = np.where(known, of_rows, velocities[landing_rows, c])
                    text = f'the velocity of contact "{contact.frame}" is not given in full: vx@, vy@ and vz@ are needed, or none'
                    for i in landing_rows[known.any(axis=1) & ~known.all(axis=1)].tolist():
                        self.messages.setdefault(i, text)
        if unused := {frame for frame, _ in self.at_contact} - {contact.frame for contacts in landings for contact in contacts}:
            raise StudyError(
                f'the table gives the velocity of "{min(unused)}", which is no contact of any row; leave it out (--map)'
            )
        moving = ~np.isnan(velocities).any(axis=2)
        stances, stance = self._stances()
        code = index * len(stances) + stance
        for moves in moving.T[moving.any(axis=0)]:
            code = np.unique(2 * code + moves, return_inverse=True)[1]
        _, rows, group = np.unique(code, return_index=True, return_inverse=True)
        scenes = []
        for i in rows.tolist():
            contacts = tuple(
                replace(contact, velocity=tuple(velocities[i, c].tolist()) if moving[i, c] else None)
                for c, contact in enumerate(landings[index[i]])
            )
            mu = None if np.isnan(friction[i]) else float(friction[i])
            scenes.append(replace(scene, contact=contacts, stance=stances[stance[i]], friction=mu))
        return tuple(scenes), group, velocities

    def _frames(self, text: str, rows: np.ndarray) -> tuple[str, ...]:
        """The frames A+B of rows (n,); none where the text means none, and the rows are therefore refused."""
        try:
            landings = landing_frames(self.robot, text)
            if len(landings) > 1:
                raise StudyError(f'contact "{text}" of a row means {len(landings)} landings; name the frames, with + between them')
        except ShockError as error:
            reason = str(error)
            self._refuse(rows, lambda i: reason)
            return ()
        return landings[0]

    def _landing(self, text: str, rows: np.ndarray) -> tuple[Contact, ...]:
        """The contacts A+B of rows (n,), each as the scene has it or, if it has not, with all that the first of the scene is given.

        They are resolved in the posture of the scene. Rows whose text means no contacts are refused, and have those of the scene.
        """
        scene = self.landing.scene
        if not (frames := self._frames(text, rows)):
            return scene.contact
        contacts = contacts_like(self.landing.asked, frames)
        with contextlib.suppress(ShockError):  # which is the message of the rows
            contacts = with_definite_contacts(replace(scene, contact=contacts), self.robot).contact
        return contacts

    def _stances(self) -> tuple[list[tuple[str, ...]], np.ndarray]:
        """The different sets of standing feet, and which of them (n,) is that of each row; where a cell is empty, the scene's."""
        if "stance" not in self.columns:
            return [self.landing.scene.stance], np.zeros(self.n, dtype=int)
        cells = self.columns["stance"]
        texts, index = np.unique(np.where(empty_cells(cells), "", cells.astype(str)), return_inverse=True)
        stances = [self._frames(text, index == k) if text else self.landing.scene.stance for k, text in enumerate(texts.tolist())]
        return stances, index

    def _friction(self) -> Array:
        """Coefficients (n,) of friction; NaN where there are none."""
        name = next((name for name in FRICTION if name in self.columns), "")
        if not name:
            mu = self.landing.scene.friction
            return np.full(self.n, np.nan if mu is None else mu)
        friction = self._numbers(name, self.columns[name])
        self._refuse(friction < 0.0, lambda i: f"column {name}: {friction[i]:g} is not a valid friction; it must be ≥ 0")
        return np.maximum(friction, 0.0)

    def _attitude(self) -> Array:
        """Set the base, and return its rotations (n, 3, 3)."""
        from scipy.spatial.transform import Rotation

        if not self.robot.free_base:
            return np.broadcast_to(self.landing.state.rotation[0, 0], (self.n, 3, 3))
        quaternion = [self.base[key] for key in ("qx", "qy", "qz", "qw") if key in self.base]
        angles = [key for key in ANGLES if key in self.base]
        if quaternion and (len(quaternion) < 4 or angles):
            raise StudyError("the base's attitude is given by qw, qx, qy and qz, or by roll, pitch and yaw: all of one kind")
        if quaternion:
            self.Q[:, 3:7] = self._unit("the base's quaternion (qx, qy, qz, qw)", np.stack(quaternion, axis=1))
        elif angles:
            rpy = Rotation.from_quat(self.Q[:, 3:7]).as_euler("xyz")
            for k, key in enumerate(ANGLES):
                rpy[:, k] = self.base.get(key, rpy[:, k])
            self.Q[:, 3:7] = Rotation.from_euler("xyz", rpy).as_quat()
        for k, axis in enumerate("xyz"):
            self.Q[:, k] = self.base.get(axis, self.Q[:, k])
        return np.asarray(Rotation.from_quat(self.Q[:, 3:7]).as_matrix() @ self.robot.bodies[0].rotation)

    def _base_velocity(self) -> Array:
        """The base's velocity (3,) where the table does not give it; of a fixed base whose joints move there is none.

        Raises:
            StudyError: the scene gives it as a speed, which would be added to the motion of the joints.
        """
        strike, velocity = self.landing.scene.strike, self.landing.before.velocity
        if self.landing.base != "fixed" or not self.moving or strike.velocity is not None or not velocity.any():
            return velocity
        if strike.drop_height is None and strike.speed == 1.0 and not strike.strike_angle_deg:
            return 0.0 * velocity
        raise StudyError(
            "the table gives rates of joints on a fixed base, and the scene a speed or a drop height of the base, which would be "
            "added to them; leave that out, or give the velocity of the base against the ground with --velocity"
        )

    def _vector(self, kind: str, default: Array, rotation: Array) -> Array:
        """A velocity of the base (n, 3), world axes."""
        keys = [f"{kind}{axis}" for axis in "xyz"]
        in_body = [key for key in keys if key in self.in_body]
        if in_body and len(in_body) != 3:
            raise StudyError(f"{listed(in_body)} of the base in body axes, but not all of {listed(keys)}; give all three")
        vector = np.stack([self.base.get(key, np.full(self.n, default[k])) for k, key in enumerate(keys)], axis=1)
        return np.asarray((rotation @ vector[..., None])[..., 0] if in_body else vector)

    def _measured(self, column: str, named: ColumnName, values: Array, before: Motion) -> Measured:
        """The jump that a column after the impact means."""
        name, key = named.target, named.base
        if "@" in name:
            return Measured(name, named.time, name, name, "", values)
        if not key:
            joint = self.robot.joint(name)
            known, label, unit, key = name in self.moving, "rate of this joint", f"{joint.unit}/s", f"delta_qd@{name}"
            group = "sliding rates" if joint.kind == "prismatic" else "joint rates"
            start = before.joint_rates[:, joint.v.start]
        elif key[0] not in "vw":
            raise StudyError(f"column {column}: only velocities change in an impact; leave it out with --map COLUMN=")
        elif named.in_body:
            raise StudyError(f"column {column}: velocities after the impact are compared in world axes; convert them")
        else:
            whole, known, label = before.velocity if key[0] == "v" else before.omega, key in self.base, key
            group, unit = ("base velocity", "m/s") if key[0] == "v" else ("base angular velocity", "rad/s")
            start = whole[:, "xyz".index(key[1])]
        if not known:
            raise StudyError(f"column {column}: the table has no {label} before the impact, so its jump is not known")
        return Measured(name, named.time, group, key, unit, values - start)

    def _origins(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        joints = [name for name in self.robot.joint_names if name not in self.robot.followers]
        parts = {"contacts": "contact" in self.columns}
        parts |= {"standing feet": True} if "stance" in self.columns else {}
        if self.robot.free_base:
            parts |= {
                "base attitude": bool({"qw", "roll", "pitch", "yaw"} & self.base.keys()) or "qpos" in self.columns,
            }
            if self.landing.base != "fixed":
                parts |= {f"base {key}": key in self.base for key in ("vx", "vy", "vz", "wx", "wy", "wz")}
        given, missing = [what for what, known in parts.items() if known], [what for what, known in parts.items() if not known]
        given += [f'velocity of contact "{frame}"' for frame in dict.fromkeys(frame for frame, _ in self.at_contact)]
        given += ["friction"] * any(name in self.columns for name in FRICTION)
        given += ["efforts"] * bool(np.isfinite(self.effort).any())
        for what, known in (("position", self.positions), ("rate", self.moving)):
            absent = [name for name in joints if name not in known]
            if known:
                given.append(f"{what}s of {len(known)} joint{'s' * (len(known) > 1)}")
            if absent:
                missing.append(f"{what} of {'all joints' if len(absent) == len(joints) else listed(absent, 8)}")
        return tuple(given), tuple(missing)
