"""The touchdowns of a log as a record."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from shockpc.core.spatial import Array
from shockpc.evaluation.table import Table
from shockpc.robot.robot import Robot
from shockpc.text.display import brief, shown_by
from shockpc.text.printed import count
from shockpc.wings.recordings.logs.logged_motion import StatePart
from shockpc.wings.recordings.logs.logs import Log


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
        landings: all touchdowns.
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
