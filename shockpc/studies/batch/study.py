"""Landings of many robots in their standing postures: on all level feet, on some of them, and on
each foot.
"""

import functools
import math
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import numpy as np

from shockpc.evaluation.column import selected
from shockpc.evaluation.declare import QuantityOption, study
from shockpc.evaluation.evaluate import proven
from shockpc.evaluation.executor import in_order
from shockpc.evaluation.table import Table
from shockpc.judgement.drive_range import Range, range_of
from shockpc.judgement.first_number import imu_places
from shockpc.judgement.standing import posture_marks
from shockpc.judgement.unknowns import NOT_KNOWN
from shockpc.landing.contact import contact_name
from shockpc.landing.level_feet import with_contacts
from shockpc.landing.places import Place
from shockpc.landing.record import Option
from shockpc.landing.scene import Scene
from shockpc.quantities.of_robot import FEASIBLE_IF_TILTED
from shockpc.quantities.renamed import renamed_attribute
from shockpc.quantities.selection import Selection, select
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.robot.feet_and_sensors import each_foot
from shockpc.robot.load import load_robot
from shockpc.robot.robot import Robot
from shockpc.text.diagnostic import Diagnostic
from shockpc.text.errors import ShockError, StudyError, attempt, traces
from shockpc.text.shown import brief, counted, shown_by

STANDARD = (
    "mass",
    "shock",
    "ropc",
    "shock_max",
    "shock_com",
    "effective_mass_sticking",
    "mitigation",
    "friction_needed",
    "feasible",
    "robot.error_bound",
)
"""Quantities of every row."""

Read = Callable[[str], tuple[Robot, Iterable[Scene]]]
"""From a name, such as that of a robot or its file, to the robot and its landings."""


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
        feasible_if_tilted: whether flat ground allows it only if the robot is tilted a little, as other
            feet are level.
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


class Batch(NamedTuple):
    """The landings of many robots.

    Attributes:
        columns: names of the quantities.
        rank: name of the quantity by which rows are ranked.
        rows: what was computed, the worst first; rows without the quantity follow, by the shock at
            the trunk's centre of mass.
        failures: what could not be computed, in the order of the robots.
        table: robot and contact of every landing in the order of the robots, with its quantities
            and messages.
    """

    columns: tuple[str, ...]
    rank: str
    rows: tuple[BatchRow, ...]
    failures: tuple[Failure, ...]
    table: Table

    def __repr__(self) -> str:
        return brief(self, counted(len(self.rows), "landing"), f"ranked by {self.rank}")

    def _repr_html_(self) -> str:
        return shown_by("studies.batch.report:batch_report")(self)

    @property
    def robots(self) -> tuple[BatchRow, ...]:
        """The worst landing of each robot or scene: those whose drives are known first, the worst
        first, then the others.
        """
        worst = {row.source: row for row in reversed(self.rows)}
        first = [row for row in self.rows if worst[row.source] is row]
        return tuple(sorted(first, key=lambda row: not row.drives_known))

    @property
    def short_names(self) -> dict[str, str]:
        """The robots that are paths by the names of their files, where these differ."""
        labels = dict.fromkeys(
            [*(row.robot for row in self.rows), *(failure.robot for failure in self.failures)]
        )
        names = {label: Path(label).name or label for label in labels}
        return {
            label: name
            for label, name in names.items()
            if name != label and list(names.values()).count(name) == 1
        }


def landings_without_contacts(name: str) -> tuple[Robot, list[Scene]]:
    """A robot, and its landings as of a scene without contacts, 1 m/s straight down in its standing
    posture.

    Raises:
        ShockError: the robot cannot be loaded.
    """
    robot = load_robot(name)
    return robot, with_contacts(Scene(robot=name), robot)


@study(
    "shockpc batch anymal_c go2 solo12",
    more=(
        "Each robot stands in its standing posture and falls straight down at 1 m/s, on all level "
        "feet together, on each edge of"
        " their support and on each foot, unless options say otherwise. With --contact, only "
        "matching frames strike; a scene"
        " keeps its landing. A line is the worst landing of a robot; --landings prints them all. "
        "Robots whose drives nobody"
        " knows have no rank, and come last with the range of their number. Ends with exit code 3 "
        "if none of the landings"
        " can be computed. Quantities of points are taken at the robot's IMU, without an IMU at "
        "the trunk (the heaviest"
        " body). Quantities of bodies are taken at the trunk. If a name matches several places, "
        "the worst counts."
    ),
)
def batch(
    robots: Iterable[str],
    read: Read = landings_without_contacts,
    executor: Executor | None = None,
    look: Callable[[ShockProfile], Any] | None = None,
    progress: Callable[[int], Callable[[str], None]] = lambda robots: lambda name: None,
    quantities: QuantityOption = (),
    rank: Annotated[
        str,
        Option(
            "Quantity by which landings are ranked, the worst first; the largest first where "
            "neither direction is worse.",
            "What is computed",
            "KEY[@PLACE]",
            holds="quantity",
        ),
    ] = "shock",
) -> Batch:
    """Compute the landings of many robots, one robot after the other or several at once.

    Args:
        robots: names and files.
        read: finds the landings of each.
        executor: computes each robot; in this process by default. Others need `read` and `look` to
            be picklable.
        look: makes something of each profile, such as a picture, where the profile is computed.
        progress: is called with the number of robots; what it returns with the name of each when
            it is computed, in the order of `robots`.

    Raises:
        UnknownName: there is no such quantity.
        StudyError: no robot is given.
    """
    names = list(robots)
    if not names:
        raise StudyError("no robot is given; give at least one name or file")
    texts = {text.removeprefix("robot."): text for text in (*STANDARD, *quantities, rank)}
    wanted = tuple(select(text.partition("@")[0]) for text in texts.values())
    name = rank.removeprefix("robot.")
    found, defects = list[BatchRow | Failure](), list[str]()
    advance = progress(len(names))
    for source, part in zip(
        names,
        in_order(executor, functools.partial(_landed, read, wanted, look, texts, name), names),
        strict=True,
    ):
        found += part[0]
        defects += part[1]
        advance(source)
    rows = [one for one in found if isinstance(one, BatchRow)]
    failures = [one for one in found if isinstance(one, Failure)]
    selection = select(rank.partition("@")[0])
    rows.sort(
        key=lambda row: (
            selection.worse(_number(row, name)),
            select("shock_com").worse(_number(row, "shock_com")),
        ),
        reverse=True,
    )
    names = [one.source if isinstance(one, BatchRow) else one.robot for one in found]
    columns = {
        "robot": np.array(names, dtype=str),
        "contact": np.array([one.contact for one in found], dtype=str),
    }
    columns |= {text: np.array([_number(one, text) for one in found]) for text in texts}
    columns["proven"] = np.array([isinstance(one, BatchRow) for one in found], dtype=bool)
    messages = {i: one.reason for i, one in enumerate(found) if isinstance(one, Failure)}
    table = Table((), columns, messages, defects=tuple(defects))
    return Batch(tuple(texts), name, tuple(rows), tuple(failures), table)


def _landed(
    read: Read,
    wanted: tuple[Selection, ...],
    look: Callable[[ShockProfile], Any] | None,
    texts: Mapping[str, str],
    rank: str,
    name: str,
) -> tuple[list[BatchRow | Failure], list[str]]:
    """The landings of a robot, and descriptions of unexpected exceptions.

    There is one failure if it cannot be read, or gives a friction or a stiffness on which no number
    depends.
    """

    def landed() -> tuple[list[Scene], dict[str, ShockProfile | ShockError]]:
        robot, read_scenes = read(name)
        scenes = list(read_scenes)
        return scenes, proven({str(k): (scene, robot) for k, scene in enumerate(scenes)}, wanted)

    found = attempt(landed)
    if isinstance(found, ShockError):
        return [Failure(name, "", str(found))], traces([found])
    rows = [
        one if isinstance(one, ShockError) else attempt(_row, look, texts, rank, name, one)
        for one in found[1].values()
    ]
    pairs = zip(found[0], rows, strict=True)
    named = [
        Failure(name, contact_name(scene), str(row)) if isinstance(row, ShockError) else row
        for scene, row in pairs
    ]
    return named, traces(rows)


def _number(row: BatchRow | Failure, text: str) -> float:
    value = row.values[text] if isinstance(row, BatchRow) else None
    return math.nan if value is None else value


def _row(
    look: Callable[[ShockProfile], Any] | None,
    texts: Mapping[str, str],
    rank: str,
    source: str,
    profile: ShockProfile,
) -> BatchRow:
    trunk = profile.places("body")[profile.main_body]
    status = [one.status for one in profile.unknowns if one.kind == "drives"]
    selection, place = _worst_place(profile, texts[rank])
    return BatchRow(
        source=source,
        robot=profile.robot.label,
        contact=contact_name(profile.scene),
        trunk=trunk.name,
        joint_model=profile.joint_model,
        drives=profile.landing.joint_model.drives,
        status=", ".join(dict.fromkeys(status)) or "as given",
        drives_known=not any(one in NOT_KNOWN for one in status),
        at=_sensed(profile).title,
        values={
            name: _value(profile, *_worst_place(profile, text)) for name, text in texts.items()
        },
        range=None if place is None else range_of(profile, selection, place),
        effective_mass=profile.effective_mass,
        feet=each_foot(profile.robot),
        marks=posture_marks(profile.scene, profile.health.warnings),
        sensors={point.frame: point.shock for point in profile.points},
        warnings=profile.health.warnings,
        feasible_if_tilted=bool(profile.values(FEASIBLE_IF_TILTED)[0] == 1.0),
        scene=profile.scene,
        picture=None if look is None else look(profile),
    )


def _sensed(profile: ShockProfile) -> Place:
    """The IMU of a robot, of several that with the largest shock; without one the centre of mass of
    the trunk.
    """
    imus = imu_places(profile)
    if not imus:
        return profile.bracketed[0]
    return imus[int(np.argmax(profile.values(select("point.shock").quantity, imus)))]


def _worst_place(profile: ShockProfile, text: str) -> tuple[Selection, Place | None]:
    """What a text selects, and of the places that it means the one with the worst value; None where
    one has no value.
    """
    selection, places = selected(profile.landing, text)
    if "@" not in text and selection.quantity.of in ("body", "point"):
        places = (
            profile.places("body")[profile.main_body]
            if selection.quantity.of == "body"
            else _sensed(profile),
        )
    numbers = profile.numbers(selection, places)
    if not len(numbers) or np.isnan(numbers).any():
        return selection, None
    return selection, places[int(np.argmax(selection.worse(numbers)))]


def _value(profile: ShockProfile, selection: Selection, place: Place | None) -> float | None:
    return None if place is None else float(profile.numbers(selection, [place])[0])
