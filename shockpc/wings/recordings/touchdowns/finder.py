"""Finds the touchdowns of a log, by flags, forces or heights of contacts, and the row of each."""

import bisect
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.evaluation.table import Table
from shockpc.landing.scenes.strike import GRAVITY
from shockpc.quantities.selection import select
from shockpc.robot.robot import Robot
from shockpc.text.errors import StudyError
from shockpc.text.printed import few, listed
from shockpc.wings.recordings.logs.detection import FEWEST, foot_landings
from shockpc.wings.recordings.logs.logged_motion import (
    PARTS,
    TWIST,
    LoggedMotion,
    StatePart,
)
from shockpc.wings.recordings.logs.logs import Log
from shockpc.wings.recordings.logs.sensors import Sensors
from shockpc.wings.recordings.touchdowns.flags import OFF, Flag, flags_of
from shockpc.wings.recordings.touchdowns.row import RowReader, TouchSamples
from shockpc.wings.recordings.touchdowns.touchdowns import Touchdown, Touchdowns

WINDOW = 3e-3
"""Default of the windows for velocities [s].

Each window has at least `FEWEST` samples, after a touchdown the nearest ones.
"""

GOOD, TIMES_ONLY = 500.0, 300.0
"""Rates [Hz] below which velocities around a touchdown are doubtful, and below which none is given.

Cassie's jumps, thinned, are 2 % off at 1 kHz, 7 % at 500 Hz and 27 % at 200 Hz.
"""

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


class Touch(NamedTuple):
    """A contact touches.

    Attributes:
        sample: the last one before.
        contact: its number.
        speed: with which it fell [m/s]; NaN where a flag or a force says that it touches.
    """

    sample: int
    contact: int
    speed: float


class TouchdownFinder:
    """Finds the touchdowns of one log.

    Attributes:
        motion: of the log.
        time: (n,) of its samples [s].
        frames: contacts that are looked at.
        flags: columns that say when a contact touches, by its number.
        points: (n, c, 3) of the contacts in the world; None where the log lacks base motion.
        heights: (n, c) of these; None without points.
        landed: samples of the touchdowns of each contact so far, by its number.
        warnings: what is missing, assumed or doubtful.
    """

    def __init__(
        self, motion: LoggedMotion, log: Log, flags: Mapping[str, str], force: float | None
    ) -> None:
        self.motion = motion
        self.log = log
        self.time = motion.time
        self.frames = tuple(contact.frame for contact in motion.landing.contacts)
        self.warnings = [*log.remarks, *motion.warnings]
        self.flags = flags_of(log.others, self.frames, flags, force, GRAVITY * motion.robot.mass)
        self._warn_of_columns()
        self._warn_of_unknown_motion()
        self.sensors = Sensors(log, motion)
        self.warnings += self.sensors.warnings
        self.points: Array | None = None
        self.heights: Array | None = None
        if not motion.unknown:
            self.points = motion.points()
            self.heights = np.asarray(self.points @ motion.landing.up)
        self.landed: dict[int, list[int]] = {}

    def _warn_of_columns(self) -> None:
        """Warn of columns that are not used, and say what is taken for a force."""
        used = {flag.column for flag in self.flags.values()}
        unused = []
        for name, values in self.log.others.items():
            if values.dtype.kind in "fiub" and name not in used:
                unused.append(name)
        if unused:
            self.warnings.append(f"columns that are not used: {listed(unused, 6)}")
        for c, flag in self.flags.items():
            if flag.force is not None:
                self.warnings.append(
                    f'"{self.frames[c]}" is taken to touch where {flag.column} exceeds '
                    f"{flag.force:.3g} N"
                )

    def _warn_of_unknown_motion(self) -> None:
        """Warn of contacts that have neither a flag nor heights.

        Raises:
            StudyError: no contact has a flag, and there are no heights.
        """
        unseen = [frame for c, frame in enumerate(self.frames) if c not in self.flags]
        if not (self.motion.unknown and unseen):
            return
        lacking = (
            f"base motion is not in this log: it lacks {', '.join(self.motion.unknown)}, so the "
            f"heights of the feet do not follow"
        )
        if not self.flags:
            raise StudyError(
                f"{lacking}; add that motion (--set for a joint that stays where it is), or "
                f"name a column of contact flags or "
                "forces: --flag FRAME=COLUMN"
            )
        self.warnings.append(f"{lacking}; no touchdowns of {listed(unseen, 8)} are looked for")

    def touchdowns(
        self, together: float, after: tuple[float, ...], window: float | None
    ) -> Touchdowns:
        """The touchdowns of the log, and the motion before and after them.

        Args:
            together: time within which contacts that touch are one landing [s].
            after: times after the touchdown [s].
            window: length of the windows for velocities [s]; by default of a few samples.
        """
        windows = {part: self._window(part, window) for part in PARTS}
        if np.isfinite(windows["joints"]):
            self.warnings += list(self.motion.lags())
        read = RowReader(self.motion, self.sensors, self.flags, windows)
        absent = [key for key in TWIST if self.motion.free and key not in read.known]
        if absent:
            self._warn_of_absent(absent, read.odometry)
        landings: list[Touchdown] = []
        rows: list[dict[str, Any]] = []
        begin = 0
        for group in self._groups(together):
            landing, row = self._landing(str(len(landings) + 1), group, begin, read, after)
            landings.append(landing)
            if row is not None:
                rows.append(row)
            begin = landing.last + 1
        self._warn_of_rows(rows, absent)
        self._warn_of_noise(landings, windows["base"])
        return Touchdowns(
            robot=self.motion.robot,
            table=self._table(landings, rows),
            landings=tuple(landings),
            log=self.log,
            frames=self.frames,
            heights=self.heights,
            flagged={self.frames[c]: flag.column for c, flag in self.flags.items()},
            window=windows,
            after=after,
            warnings=tuple(self.warnings),
        )

    def _groups(self, together: float) -> Iterator[list[Touch]]:
        """The touches of each landing: those within a time [s] of the first one."""
        group: list[Touch] = []
        for touch in sorted(self._touches(together)):
            self.landed.setdefault(touch.contact, []).append(touch.sample)
            if group and self.time[touch.sample] - self.time[group[0].sample] > together + 1e-9:
                yield group
                group = []
            group.append(touch)
        if group:
            yield group

    def _landing(
        self, name: str, group: list[Touch], begin: int, read: RowReader, after: tuple[float, ...]
    ) -> tuple[Touchdown, dict[str, Any] | None]:
        """The landing of some touches, and its row of the table; None where it has none.

        Args:
            name: of its row.
            group: its touches.
            begin: first sample that belongs to no earlier landing.
            read: reads rows.
            after: times after the touchdown [s].
        """
        first = group[0].sample
        last = group[-1].sample
        speeds: dict[int, float] = {}
        for touch in sorted(group, key=lambda touch: touch.contact):
            speeds[touch.contact] = touch.speed
        not_struck = [c for c in range(len(self.frames)) if c not in speeds]
        standing = [c for c in not_struck if self._stands(c, first)]
        since = max(self.motion.run(first)[0], begin)
        row, message = read(TouchSamples(since, first, last, tuple(speeds), standing), after)
        landing = Touchdown(
            name=name,
            first=first,
            last=last,
            contacts=tuple(self.frames[c] for c in speeds),
            stance=tuple(self.frames[c] for c in standing),
            speeds=tuple(speeds.values()),
            table=row is not None,
            message=message,
        )
        if row is None:
            return landing, None
        labels = {
            "name": name,
            "time": self.log.start + self.time[first],
            "contact": "+".join(landing.contacts),
            "stance": "+".join(landing.stance),
        }
        return landing, labels | row

    def _table(self, landings: list[Touchdown], rows: list[dict[str, Any]]) -> Table:
        """The table of landings, without a stance where no contact ever stands."""
        headings = list(rows[0]) if rows else ["name", "time", "contact"]
        if not any(landing.stance for landing in landings) and "stance" in headings:
            headings.remove("stance")
        columns: dict[str, np.ndarray] = {}
        units: dict[str, str] = {}
        for heading in headings:
            columns[heading] = np.array([row[heading] for row in rows])
            units[heading] = _unit(self.motion.robot, heading)
        return Table((), columns, {}, label_units=units)

    def _warn_of_absent(self, absent: list[str], odometry: bool) -> None:
        """Warn of velocities of the base that the log lacks. Args: odometry, of `RowReader`."""
        lacking = ", ".join(absent)
        if odometry:
            self.warnings.append(
                f"not in this log: {lacking} of the base; they follow from standing "
                f"feet, if these stay where they are"
            )
        else:
            self.warnings.append(
                f"base motion is not in this log: the table has no {lacking} of the base, and "
                "shockpc recorded takes its scene's"
            )

    def _warn_of_rows(self, rows: list[dict[str, Any]], absent: list[str]) -> None:
        """Warn of rows in which a velocity of the base is not known."""
        unknown = 0
        for row in rows:
            if any(np.isnan(row.get(key, 0.0)) for key in TWIST):
                unknown += 1
        if unknown:
            options = " ".join(f"--map {key}=" for key in absent)
            self.warnings.append(
                f"no base velocity before {unknown} of {len(rows)} touchdowns, as the messages "
                f"say, so shockpc recorded leaves them out. To use the scene's velocity: {options}"
            )

    def _window(self, part: StatePart, length: float | None) -> float:
        """Length of the windows for velocities of the joints or the base [s].

        It is infinite where samples are too far apart for a window.

        Raises:
            StudyError: in windows of the length given are too few samples.
        """
        period = self.motion.period[part]
        least = (FEWEST - 1) * period
        if np.isinf(period):
            return period
        if length is not None and length < least * (1.0 - 1e-6):
            raise StudyError(
                f"a window of {1e3 * length:.3g} ms has fewer than {FEWEST} samples of the "
                f"{part}, which are {1e3 * period:.3g} ms apart; give at least {1e3 * least:.3g} "
                "ms"
            )
        rate = (1.0 + 1e-3) / period
        verb = "has" if part == "base" else "have"
        samples = f"the {part} {verb} {rate:.0f} samples a second"
        if rate < TIMES_ONLY:
            self.warnings.append(
                f"{samples}, too few for velocities around a touchdown, and none is given"
            )
            return np.inf
        if rate < GOOD:
            self.warnings.append(
                f"{samples}, few for velocities around a touchdown: jumps of Cassie were off by "
                "7 % at 500 Hz, and by 27 % at 200 Hz"
            )
        return length or max(WINDOW, least)

    def _warn_of_noise(self, landings: list[Touchdown], window: float) -> None:
        """Warn of velocities of the base that are noisy compared with the falls."""
        speeds = np.array([speed for landing in landings for speed in landing.speeds])
        speeds = speeds[np.isfinite(speeds)]
        if not len(speeds) or not np.isfinite(window):
            return
        fall = np.median(speeds)
        sigma = self.motion.uncertainty("base", window)
        if sigma > NOISY * fall:
            self.warnings.append(
                f"velocities of the base are uncertain by {sigma:.2g} m/s (one standard "
                f"deviation) because of noise in positions, and the feet fall at {fall:.2g} m/s; "
                "give a longer window with --window"
            )

    def _touches(self, together: float) -> Iterator[Touch]:
        """The touches of all contacts, foot by foot in each part of the log without gaps."""
        feet: dict[int, list[int]] = {}
        for c, contact in enumerate(self.motion.landing.contacts):
            if c not in self.flags:
                feet.setdefault(contact.body, []).append(c)
        for first, last in self.motion.runs:
            if self.heights is not None:
                for points in feet.values():
                    heights = self.heights[first : last + 1, points]
                    yield from self._touches_by_heights(first, heights, points, together)
            for c, flag in self.flags.items():
                yield from self._touches_by_flag(first, last, c, flag)

    def _touches_by_heights(
        self, first: int, heights: Array, points: list[int], together: float
    ) -> Iterator[Touch]:
        """The touches of the points (p,) of a foot, whose heights (m, p) have a kink.

        Args:
            first: sample of the first height.
            heights: in a part of the log without gaps [m].
            points: contacts by number.
            together: time within which touches are one landing [s].
        """
        t = self.time[first : first + len(heights)]
        landings, rebounds = foot_landings(t, heights, together)
        for landing in landings:
            for p in landing.points:
                yield Touch(first + landing.sample, points[p], landing.speed)
        self._warn_of_others(
            t[rebounds],
            points[0],
            "is stopped and rises again",
            "; if it bounces, name a column of contact flags or forces: --flag FRAME=COLUMN",
        )

    def _touches_by_flag(self, first: int, last: int, c: int, flag: Flag) -> Iterator[Touch]:
        """The touches of a contact between two samples by its flag."""
        t = self.time[first : last + 1]
        touched, short = flag.touches(t, first)
        for k in touched:
            yield Touch(first + k, c, np.nan)
        self._warn_of_others(t[short], c, f"touches for less than {500.0 * OFF:g} ms by its column")

    def _warn_of_others(self, times: Array, c: int, how: str, advice: str = "") -> None:
        """Warn of what is no touchdown of a contact."""
        if len(times):
            at = few([f"{self.log.start + time:.4f}" for time in times], 4)
            self.warnings.append(
                f'"{self.frames[c]}" {how} (at {at} s), which is no touchdown here{advice}'
            )

    def _stands(self, c: int, sample: int) -> bool:
        """True if a contact stands at a sample.

        Its flag says so, or it is still, and no higher than where it lands.
        """
        if c in self.flags:
            return bool(self.flags[c].signal[sample] > 1.0)
        if self.heights is None or self.points is None:
            return False
        first, last = self.motion.run(sample)
        start = max(int(np.searchsorted(self.time, self.time[sample] - OFF)), first)
        landed = self.landed.get(c, [])
        earlier = landed[: bisect.bisect_left(landed, sample)]
        if earlier:
            start = max(start, earlier[-1] + 1)
            level = self.heights[earlier[-1], c]
        else:
            level = self.heights[first : last + 1, c].min()
        moved = np.linalg.norm(self.points[sample, c] - self.points[start, c])
        still = moved <= STILL * (self.time[sample] - self.time[start])
        return bool(start < sample and still and self.heights[sample, c] <= level + LEVEL)


def _unit(robot: Robot, name: str) -> str:
    """The unit of a column.

    Its name is q_JOINT, before_JOINT, after6ms_JOINT, after6ms_vx, after6ms_KEY@PLACE, or one of
    `UNITS`.
    """
    kind, _, subject = name.partition("_")
    if "@" in subject:
        return select(subject.partition("@")[0]).quantity.unit
    if (subject or name) in UNITS:
        return UNITS[subject or name]
    if subject not in robot.joint_names:
        return ""
    unit = "m" if robot.joint(subject).kind == "prismatic" else "rad"
    return unit if kind == "q" else f"{unit}/s"
