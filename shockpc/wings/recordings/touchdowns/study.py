"""From a log to a table of landings: when the feet touch down, how the robot moves just before, and
what is measured after.

A foot lands where its contacts say so, a column of flags or forces, or else where its height over
time has a kink. Velocities are slopes of straight lines through positions: before, in a window that
ends with the last sample before the first foot touches; after, in one around each time that is
asked for, counted from the touchdown of the last foot of the landing.
"""

import bisect
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.evaluation.declare import RenameOption, study
from shockpc.evaluation.table import Table
from shockpc.landing.record import JOINT_MODEL, RESULTS, STRIKE, Option
from shockpc.landing.scene import Scene
from shockpc.landing.scene_file import robot_of, scene_of
from shockpc.landing.strike import GRAVITY
from shockpc.quantities.selection import select
from shockpc.robot.robot import Robot
from shockpc.text.errors import StudyError
from shockpc.text.printed import count, few, listed
from shockpc.text.shown import brief, shown_by
from shockpc.wings.recordings.logs.detection import FEWEST, foot_landings
from shockpc.wings.recordings.logs.logged_motion import (
    PARTS,
    TWIST,
    LoggedMotion,
    StatePart,
    watched_motion,
)
from shockpc.wings.recordings.logs.logs import Log, read_log
from shockpc.wings.recordings.logs.sensors import Sensors
from shockpc.wings.recordings.touchdowns.flags import OFF, flags_of
from shockpc.wings.recordings.touchdowns.row import RowReader, Touch

WINDOW = 3e-3
"""Default of the windows for velocities; each has at least `FEWEST` samples, after a touchdown the
nearest ones [s].
"""

GOOD, TIMES_ONLY = 500.0, 300.0
"""Rates below which velocities around a touchdown are doubtful (Cassie's jumps, thinned: 2 % off at
1 kHz, 7 % at 500 Hz, 27 % at
200 Hz), and below which none is given [Hz]."""

NOISY = 0.1
"""Share of the speed of a fall above which the noise of velocities of the base is said."""

STILL, LEVEL = 0.15, 10e-3
"""Speed up to which a foot stands [m/s], if it is at most so much higher than where it lands [m].
"""

UNITS = {
    "time": "s",
    **dict.fromkeys("xyz", "m"),
    **dict.fromkeys(TWIST[:3], "m/s"),
    **dict.fromkeys(TWIST[3:], "rad/s"),
}
"""Units of times, and of the base's position and velocities."""


class Touchdown(NamedTuple):
    """A landing in a log.

    Attributes:
        name: of its row.
        first, last: samples before the first and the last of its feet touch.
        contacts: frames that touch.
        stance: frames that stand already.
        speeds: with which the contacts fell [m/s]; NaN where a flag or a force says that they land.
        table: whether it is a row of the table.
        message: what is missing, or why it is no row.
    """

    name: str
    first: int
    last: int
    contacts: tuple[str, ...]
    stance: tuple[str, ...]
    speeds: tuple[float, ...]
    table: bool
    message: str


@dataclass(frozen=True, eq=False)
class Touchdowns:
    """The landings of a log.

    Attributes:
        robot: the robot.
        table: a row for each landing, as `landings` takes them; numbers that were not measured are
            NaN.
        landings: all that were found.
        log: the time series.
        frames: contacts that were looked at.
        heights: (n, c) of these above level ground, wherever that is [m]; None where the log lacks
            what they follow from.
        flagged: those of which a column says when they touch, by frame.
        window: length of the windows for velocities of "joints" and "base" [s]; infinite where none
            are given.
        after: times after the touchdown [s].
        warnings: what is missing, assumed or doubtful.
    """

    robot: Robot = field(repr=False)
    table: Table = field(repr=False)
    landings: tuple[Touchdown, ...]
    log: Log = field(repr=False)
    frames: tuple[str, ...]
    heights: Array | None = field(repr=False)
    flagged: Mapping[str, str]
    window: Mapping[StatePart, float]
    after: tuple[float, ...]
    warnings: tuple[str, ...]

    _repr_html_ = shown_by("wings.recordings.touchdowns.report:touchdowns_report", Path("a log"))

    def __repr__(self) -> str:
        return brief(self, self.robot.name, count(len(self.landings), "touchdown"))


@study(
    "shockpc touchdowns walk.csv anymal_b --contact LF_FOOT --out touchdowns/",
    "shockpc touchdowns walk.csv anymal_b --contact LF_FOOT --flag LF_FOOT=force --after 6,12",
    more=(
        "A log is a time series: CSV, Parquet or NPZ with a column time [s] (or time_ms, time_us, "
        "time_ns) and columns of joints "
        "and base as in shockpc recorded; or a bag of ROS 1, ROS 2 or MCAP (pip install rosbags) "
        "with JointState, and Odometry, "
        "PoseStamped, TwistStamped or Imu. All feet are looked at, or those of --contact. A "
        "touchdown is where a "
        "falling foot stops, or where its column of flags or forces begins. Velocities are slopes "
        "of straight lines through "
        "positions. If the log lacks the velocity of the base, it follows from the standing feet "
        "and a gyro (wx_body wy_body "
        "wz_body, or wx@FRAME …). Jumps follow from accelerometers, ax@FRAME ay@FRAME az@FRAME, "
        "and gyros. shockpc recorded "
        "takes the table touchdowns.csv."
    ),
    # Of the robot, where it touches and what the log lacks of its posture is all that is used of a
    # landing.
    without=(
        STRIKE,
        RESULTS,
        JOINT_MODEL,
        "together",
        "slide",
        "directions",
        "flat",
        "contact_kind",
        "stance",
        "restitution",
        "restitution_along",
    ),
    reads="log",
)
def touchdowns(
    log: str | os.PathLike[str] | Mapping[str, Any],
    scene: Scene | str,
    *,
    robot: Robot | None = None,
    contacts: Sequence[str] | None = None,
    rename: RenameOption = None,
    topics: Annotated[
        Sequence[str],
        Option(
            "Read only these topics of a bag.", "Log", "TOPIC", "topic", default="the usual ones"
        ),
    ] = (),
    flags: Annotated[
        Mapping[str, str] | None,
        Option(
            "The column with the flags or the forces of a contact.",
            "Touchdowns",
            "FRAME=COLUMN",
            "flag",
            default="one named like it, such as FRAME_contact",
        ),
    ] = None,
    contact_force: Annotated[
        float | None,
        Option(
            "Force above which a contact touches.",
            "Touchdowns",
            "F",
            unit="N",
            default="5 % of the robot's weight, at least 1 N",
        ),
    ] = None,
    within_time: Annotated[
        float,
        Option(
            "Feet that touch within this time are one landing.",
            "Touchdowns",
            "T",
            unit="ms",
            least=0.0,
            greatest=1e4,
        ),
    ] = 5.0,
    after: Annotated[
        tuple[float, ...],
        Option(
            "Times after the touchdown at which velocities are measured.",
            "Touchdowns",
            "T[,T]",
            unit="ms",
            least=1e-3,
            greatest=1e4,
            most=100,
            default="6,12,30",
        ),
    ] = (6.0, 12.0, 30.0),
    window: Annotated[
        float | None,
        Option(
            "Length of the windows for velocities.",
            "Touchdowns",
            "T",
            unit="ms",
            above=0.0,
            greatest=1e4,
            default="3, and at least the 3 nearest samples",
        ),
    ] = None,
) -> Touchdowns:
    """Find the touchdowns of a log, and the motion before and after them.

    Args:
        log: a table with a column of times, a bag, or the columns of such a table by name.
        scene: the robot; gives the joints that the log does not, and contacts that are looked at
            besides the feet. Its strike, joint model, friction and so on are not used: they are
            what `landings` takes of the same scene.
        robot: the scene's robot, if it is loaded already.
        contacts: frames that are looked at; by default all feet, and the contacts of the scene.

    Raises:
        ShockError: the log cannot be read, or lacks what touchdowns follow from.
    """
    if len(set(after)) < len(after):
        raise StudyError("a time after touchdowns is given twice; give each once")
    scene = scene_of(scene)
    robot = robot or robot_of(scene)
    source = Path(log) if isinstance(log, str | os.PathLike) else log
    series = read_log(source, robot, rename or {}, topics)
    finder = _Finder(
        watched_motion(series, scene, robot, contacts), series, flags or {}, contact_force
    )
    return finder.found(
        within_time / 1e3,
        tuple(time / 1e3 for time in after),
        None if window is None else window / 1e3,
    )


class _Finder:
    """Finds the touchdowns of one log."""

    def __init__(
        self, motion: LoggedMotion, log: Log, flags: Mapping[str, str], force: float | None
    ) -> None:
        self.motion, self.log, self.time = motion, log, motion.time
        self.frames = tuple(contact.frame for contact in motion.landing.contacts)
        self.warnings = [*log.remarks, *motion.warnings]
        self.flags = flags_of(log.others, self.frames, flags, force, GRAVITY * motion.robot.mass)
        used = {flag.column for flag in self.flags.values()}
        if unused := [
            name
            for name, values in log.others.items()
            if values.dtype.kind in "fiub" and name not in used
        ]:
            self.warnings.append(f"columns that are not used: {listed(unused, 6)}")
        self.warnings += [
            f'"{self.frames[c]}" is taken to touch where {flag.column} exceeds {flag.force:.3g} N'
            for c, flag in self.flags.items()
            if flag.force is not None
        ]
        unseen = [frame for c, frame in enumerate(self.frames) if c not in self.flags]
        if motion.unknown and unseen:
            lacking = (
                f"base motion is not in this log: it lacks {', '.join(motion.unknown)}, so the "
                f"heights of the feet do not follow"
            )
            if not self.flags:
                raise StudyError(
                    f"{lacking}; add that motion (--set for a joint that stays where it is), or "
                    f"name a column of contact flags or "
                    "forces: --flag FRAME=COLUMN"
                )
            self.warnings.append(f"{lacking}; no touchdowns of {listed(unseen, 8)} are looked for")
        self.sensors = Sensors(log, motion)
        self.warnings += self.sensors.warnings
        self.points = None if motion.unknown else motion.points()
        self.heights = None if self.points is None else np.asarray(self.points @ motion.landing.up)
        self.landed: dict[int, list[int]] = {}

    def found(self, together: float, after: tuple[float, ...], window: float | None) -> Touchdowns:
        """The touchdowns. Args: times [s]."""
        windows = {part: self._window(part, window) for part in PARTS}
        if np.isfinite(windows["joints"]):
            self.warnings += list(self.motion.lags())
        read = RowReader(self.motion, self.sensors, self.flags, windows)
        absent = [key for key in TWIST if self.motion.free and key not in read.known]
        if absent and read.odometry:
            self.warnings.append(
                f"not in this log: {', '.join(absent)} of the base; they follow from standing "
                f"feet, if these stay where they are"
            )
        elif absent:
            self.warnings.append(
                f"base motion is not in this log: the table has no {', '.join(absent)} of the "
                f"base, and shockpc recorded takes its "
                "scene's"
            )
        groups: list[list[tuple[int, int, float]]] = []
        for touch in sorted(self._touches(together)):
            self.landed.setdefault(touch[1], []).append(touch[0])
            if groups and self.time[touch[0]] - self.time[groups[-1][0][0]] <= together + 1e-9:
                groups[-1].append(touch)
            else:
                groups.append([touch])
        landings, rows, unknown = list[Touchdown](), list[dict[str, Any]](), 0
        for k, group in enumerate(groups):
            speeds, first, last = (
                {c: speed for _, c, speed in sorted(group, key=lambda touch: touch[1])},
                group[0][0],
                group[-1][0],
            )
            standing = [
                c for c in range(len(self.frames)) if c not in speeds and self._stands(c, first)
            ]
            since = max(self.motion.run(first)[0], groups[k - 1][-1][0] + 1 if k else 0)
            row, message = read(Touch(since, first, last, tuple(speeds), standing), after)
            contacts, stance = (
                tuple(self.frames[c] for c in numbers) for numbers in (speeds, standing)
            )
            landings.append(
                Touchdown(
                    str(k + 1),
                    first,
                    last,
                    contacts,
                    stance,
                    tuple(speeds.values()),
                    row is not None,
                    message,
                )
            )
            unknown += row is not None and any(np.isnan(row.get(key, 0.0)) for key in TWIST)
            labels = {
                "name": str(k + 1),
                "time": self.log.start + self.time[first],
                "contact": "+".join(contacts),
                "stance": "+".join(stance),
            }
            rows += [] if row is None else [labels | row]
        if unknown:
            self.warnings.append(
                f"no base velocity before {unknown} of {len(rows)} touchdowns, as the messages "
                "say, so shockpc recorded leaves them out. To use the scene's velocity: "
                + " ".join(f"--map {key}=" for key in absent)
            )
        robot = self.motion.robot
        columns = {
            name: np.array([row[name] for row in rows])
            for name in (rows[0] if rows else ("name", "time", "contact"))
        }
        if not any(landing.stance for landing in landings):
            columns.pop("stance", None)
        table = Table((), columns, {}, label_units={name: _unit(robot, name) for name in columns})
        self._warn_of_noise(landings, windows["base"])
        flagged = {self.frames[c]: flag.column for c, flag in self.flags.items()}
        return Touchdowns(
            robot,
            table,
            tuple(landings),
            self.log,
            self.frames,
            self.heights,
            flagged,
            windows,
            after,
            tuple(self.warnings),
        )

    def _window(self, part: StatePart, wanted: float | None) -> float:
        """Length of the windows for velocities of the joints or the base [s]; infinite where
        samples are too far apart for one.

        Raises:
            StudyError: the one that is wanted has too few samples.
        """
        period, least = self.motion.period[part], (FEWEST - 1) * self.motion.period[part]
        if np.isinf(period):
            return period
        if wanted is not None and wanted < least * (1.0 - 1e-6):
            raise StudyError(
                f"a window of {1e3 * wanted:.3g} ms has fewer than {FEWEST} samples of the "
                f"{part}, which are {1e3 * period:.3g} ms apart; give at least {1e3 * least:.3g} "
                "ms"
            )
        rate = (1.0 + 1e-3) / period
        if rate < TIMES_ONLY:
            text = "too few for velocities around a touchdown, and none is given"
        else:
            text = (
                "few for velocities around a touchdown: jumps of Cassie were off by 7 % at 500 Hz, "
                "and by 27 % at 200 Hz"
            )
        if rate < GOOD:
            self.warnings.append(
                f"the {part} {'has' if part == 'base' else 'have'} {rate:.0f} samples a second, "
                f"{text}"
            )
        return np.inf if rate < TIMES_ONLY else wanted or max(WINDOW, least)

    def _warn_of_noise(self, landings: list[Touchdown], window: float) -> None:
        """Warn of velocities of the base that are noisy compared with the falls."""
        falls = [speed for landing in landings for speed in landing.speeds if np.isfinite(speed)]
        if (
            falls
            and np.isfinite(window)
            and (sigma := self.motion.uncertainty("base", window)) > NOISY * np.median(falls)
        ):
            self.warnings.append(
                f"velocities of the base are uncertain by {sigma:.2g} m/s (one standard "
                "deviation) because of noise in positions, and the feet fall at "
                f"{np.median(falls):.2g} m/s; give a longer window with --window"
            )

    def _touches(self, together: float) -> Iterator[tuple[int, int, float]]:
        """Last sample before each touchdown of a contact, which contact, and the speed with which
        it fell [m/s].
        """
        feet: dict[int, list[int]] = {}
        for c, contact in enumerate(self.motion.landing.contacts):
            if c not in self.flags and self.heights is not None:
                feet.setdefault(contact.body, []).append(c)
        for first, last in self.motion.runs:
            t = self.time[first : last + 1]
            for points in feet.values():
                assert self.heights is not None
                landings, rebounds = foot_landings(
                    t, self.heights[first : last + 1, points], together
                )
                for landing in landings:
                    yield from (
                        (first + landing.sample, points[p], landing.speed) for p in landing.points
                    )
                self._warn_of_others(
                    t[rebounds],
                    points[0],
                    "is stopped and rises again",
                    "; if it bounces, name a column of contact flags or forces: --flag "
                    "FRAME=COLUMN",
                )
            for c, flag in self.flags.items():
                touched, short = flag.touches(t, first)
                yield from ((first + k, c, np.nan) for k in touched)
                self._warn_of_others(
                    t[short], c, f"touches for less than {500.0 * OFF:g} ms by its column"
                )

    def _warn_of_others(self, times: Array, c: int, how: str, advice: str = "") -> None:
        """Warn of what is no touchdown of a contact."""
        if len(times):
            at = few([f"{self.log.start + time:.4f}" for time in times], 4)
            self.warnings.append(
                f'"{self.frames[c]}" {how} (at {at} s), which is no touchdown here{advice}'
            )

    def _stands(self, c: int, sample: int) -> bool:
        """Whether a contact stands at a sample: by its flag, or as it is still, and no higher than
        where it lands.
        """
        if c in self.flags:
            return bool(self.flags[c].signal[sample] > 1.0)
        if self.heights is None or self.points is None:
            return False
        first, last = self.motion.run(sample)
        landed = self.landed.get(c, [])
        k = bisect.bisect_left(landed, sample)
        level = self.heights[landed[k - 1], c] if k else self.heights[first : last + 1, c].min()
        start = max(
            int(np.searchsorted(self.time, self.time[sample] - OFF)),
            landed[k - 1] + 1 if k else 0,
            first,
        )
        moved = np.linalg.norm(self.points[sample, c] - self.points[start, c])
        still = moved <= STILL * (self.time[sample] - self.time[start])
        return bool(start < sample and still and self.heights[sample, c] <= level + LEVEL)


def _unit(robot: Robot, name: str) -> str:
    """The unit of a column: of q_JOINT, before_JOINT, after6ms_JOINT, after6ms_vx,
    after6ms_KEY@PLACE, or as in `UNITS`.
    """
    kind, _, subject = name.partition("_")
    if "@" in subject:
        return select(subject.partition("@")[0]).quantity.unit
    if (subject or name) in UNITS:
        return UNITS[subject or name]
    if subject not in robot.joint_names:
        return ""
    return ("m" if robot.joint(subject).kind == "prismatic" else "rad") + (
        "" if kind == "q" else "/s"
    )
