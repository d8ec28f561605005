"""The rows of a batch: a landing of a robot, or why it could not be computed, and all of them."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from shockpc.evaluation.table import Table
from shockpc.judgement.drive_range import Range
from shockpc.landing.scenes.scene import Scene
from shockpc.quantities.renamed import renamed_attribute
from shockpc.quantities.selection import select
from shockpc.text.diagnostic import Diagnostic
from shockpc.text.display import brief, shown_by
from shockpc.text.printed import count


@dataclass(frozen=True, eq=False)
class BatchRow:
    """One landing of one robot. The trunk is the robot's heaviest body.

    Attributes:
        source: the name, robot file or scene that was given.
        robot: its name in the catalogue, or its file.
        contact: what strikes; frames with + between them.
        trunk: name of the trunk.
        joint_model: free, geared, locked or mixed.
        drives: where the drives are from, such as "drives of go2, derived"; empty if they are the
            file's or the scene's.
        status: how well the drives are known: "unknown", "simulation model", "published",
            "derived", "identified", several of these with commas, or "as given".
        drives_known: whether catalogue, file or scene say what drives the joints, and no
            simulation.
        at: where quantities of points are, if no place is named: the robot's IMU, else the trunk's
            centre of mass.
        values: the quantities by name, those of bodies at the trunk unless places are named, of
            several places the worst; None where there is none.
        range: of the quantity by which landings are ranked, over the drives; None where all are
            known exactly.
        effective_mass: of all contacts together [kg]; NaN if they differ in normal or restitution.
        feet: names of the robot's feet.
        marks: why the robot does not stand on bent legs, in a few words each; empty if it does.
        sensors: shock at each of the robot's sensors, and at each point of the scene [1].
        warnings: of the landing.
        feasible_if_tilted: whether flat ground allows it only if the robot is tilted a little, as
            other feet are level.
        scene: what was computed, with every default filled in.
        picture: what the caller's `look` made of the profile; None without it.
    """

    source: str
    robot: str
    contact: str
    trunk: str
    joint_model: str
    drives: str
    status: str
    drives_known: bool
    at: str
    values: Mapping[str, float | None]
    range: Range | None
    effective_mass: float
    feet: tuple[str, ...]
    marks: tuple[str, ...]
    sensors: Mapping[str, float]
    warnings: tuple[Diagnostic, ...]
    feasible_if_tilted: bool
    scene: Scene = field(repr=False)
    picture: Any = field(default=None, repr=False)

    @property
    def of_scene(self) -> bool:
        """True if the source is a scene, by whose name the row is known, and no robot."""
        return self.source.endswith(".toml")

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            """A quantity by its former key."""
            return renamed_attribute(self, name)


@dataclass(frozen=True)
class Failure:
    """A landing that could not be computed, and why.

    Attributes:
        robot: its name, or its file.
        contact: what strikes; empty if the robot or all of its landings are concerned.
        reason: what was found and what to change.
    """

    robot: str
    contact: str
    reason: str


@dataclass(frozen=True, eq=False)
class Batch:
    """The landings of many robots.

    Attributes:
        columns: names of the quantities.
        rank: name of the quantity by which rows are ranked.
        landings: what was computed, and what could not be, in the order of the robots.
        defects: descriptions of unexpected exceptions, which are errors in shockpc itself.
    """

    columns: tuple[str, ...]
    rank: str
    landings: tuple[BatchRow | Failure, ...]
    defects: tuple[str, ...]

    _repr_html_ = shown_by("studies.batch.report:batch_report")

    def __repr__(self) -> str:
        return brief(self, count(len(self.rows), "landing"), f"ranked by {self.rank}")

    @cached_property
    def rows(self) -> tuple[BatchRow, ...]:
        """The landings that were computed, the worst first.

        Rows without the quantity follow, by the shock at the trunk's centre of mass.
        """
        worse = select(self.rank.partition("@")[0]).worse
        worse_shock = select("shock_com").worse

        def badness(row: BatchRow) -> tuple[float, float]:
            return worse(value_of(row, self.rank)), worse_shock(value_of(row, "shock_com"))

        rows = [landing for landing in self.landings if isinstance(landing, BatchRow)]
        return tuple(sorted(rows, key=badness, reverse=True))

    @cached_property
    def failures(self) -> tuple[Failure, ...]:
        """The landings that could not be computed, in the order of the robots."""
        return tuple(landing for landing in self.landings if isinstance(landing, Failure))

    @cached_property
    def table(self) -> Table:
        """Robot, contact, quantities and message of every landing, in the order of the robots."""
        robots = []
        messages = {}
        for i, landing in enumerate(self.landings):
            if isinstance(landing, BatchRow):
                robots.append(landing.source)
            else:
                robots.append(landing.robot)
                messages[i] = landing.reason
        columns = {
            "robot": np.array(robots, dtype=str),
            "contact": np.array([landing.contact for landing in self.landings], dtype=str),
        }
        for name in self.columns:
            columns[name] = np.array([value_of(landing, name) for landing in self.landings])
        proven = [isinstance(landing, BatchRow) for landing in self.landings]
        columns["proven"] = np.array(proven, dtype=bool)
        return Table((), columns, messages, defects=self.defects)

    @cached_property
    def robots(self) -> tuple[BatchRow, ...]:
        """The worst landing of each robot or scene, the worst first.

        Those whose drives are known come before the others.
        """
        worst: dict[str, BatchRow] = {}
        for row in self.rows:
            worst.setdefault(row.source, row)
        return tuple(sorted(worst.values(), key=lambda row: not row.drives_known))

    @cached_property
    def short_names(self) -> dict[str, str]:
        """The robots that are paths by the names of their files, where these differ."""
        labels = [row.robot for row in self.rows]
        labels += [failure.robot for failure in self.failures]
        names = {label: Path(label).name or label for label in labels}
        all_names = list(names.values())
        short = {}
        for label, name in names.items():
            if name != label and all_names.count(name) == 1:
                short[label] = name
        return short

    def name_of(self, landing: BatchRow | Failure) -> str:
        """The robot of a landing, short where that tells it from all others."""
        return self.short_names.get(landing.robot, landing.robot)


def value_of(landing: BatchRow | Failure, name: str) -> float:
    """A quantity of a landing by name; NaN where there is none."""
    value = landing.values[name] if isinstance(landing, BatchRow) else None
    return math.nan if value is None else value
