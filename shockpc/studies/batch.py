"""Landings of many robots in their standing postures: on all level feet, on some of them, and on each foot."""

import functools
import math
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np

from shockpc.evaluation.columns import selected
from shockpc.evaluation.evaluate import Evaluation
from shockpc.evaluation.landings import HEADINGS, ListedLandings, Read, refuse_unused_ground
from shockpc.evaluation.table import Table
from shockpc.landing.contact import contact_name
from shockpc.landing.level_feet import with_contacts
from shockpc.landing.places import Place
from shockpc.landing.record import Option
from shockpc.landing.scene import Scene
from shockpc.quantities.profile import ShockProfile
from shockpc.quantities.robot import NEEDS_TILT
from shockpc.quantities.table import Selection, select
from shockpc.robot.load import load_robot
from shockpc.robot.robot import Robot
from shockpc.studies.declare import QuantityOption, study
from shockpc.text.diagnostic import Diagnostic
from shockpc.text.errors import StudyError

STANDARD = (
    "mass", "ropc", "shock_max", "shock_com", "shock_free", "shock_locked", "mass_sticking", "friction_needed", "feasible",
    "robot.error_bound",
)  # fmt: skip
"""Quantities of every row."""


@dataclass(frozen=True, eq=False)
class BatchRow:
    """One landing of one robot. The trunk is the robot's heaviest body.

    Attributes:
        source: the name, robot file or scene that was given.
        robot: its name in the catalogue, or its file.
        contact: what strikes; frames with + between them.
        trunk: name of the trunk.
        joint_model: free, geared, locked or mixed.
        drives: where the drives are from, such as "drives of go2, derived"; empty if they are the file's or the scene's.
        drives_known: whether catalogue, file or scene say what drives the joints.
        values: the quantities by name, those of bodies and points at the trunk (its centre of mass) unless places are named, of
            several places the worst; None where there is none.
        sensors: shock at each of the robot's sensors, and at each point of the scene [1].
        warnings: of the landing.
        needs_tilt: whether flat ground allows it only if the robot is tilted a little, as other feet are level.
        scene: what was computed, with every default filled in.
        picture: what the caller's `look` made of the profile; None without it.
    """

    source: str
    robot: str
    contact: str
    trunk: str
    joint_model: str
    drives: str
    drives_known: bool
    values: Mapping[str, float | None]
    sensors: Mapping[str, float]
    warnings: tuple[Diagnostic, ...]
    needs_tilt: bool
    scene: Scene = field(repr=False)
    picture: Any = field(default=None, repr=False)


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
        rows: what was computed, the worst first; rows without the quantity follow, by the shock at the trunk's centre of mass.
        failures: what could not be computed, in the order of the robots.
        table: robot and contact of every landing in the order of the robots, with its quantities and messages.
    """

    columns: tuple[str, ...]
    rank: str
    rows: tuple[BatchRow, ...]
    failures: tuple[Failure, ...]
    table: Table

    @property
    def ranks(self) -> tuple[str, ...]:
        """The rank of each row among those of the same joint model, as "2 of 8"."""
        models = [row.joint_model for row in self.rows]
        return tuple(f"{models[: k + 1].count(model)} of {models.count(model)}" for k, model in enumerate(models))

    @property
    def short_names(self) -> dict[str, str]:
        """The robots that are paths by the names of their files, where these differ."""
        labels = dict.fromkeys([*(row.robot for row in self.rows), *(failure.robot for failure in self.failures)])
        names = {label: Path(label).name or label for label in labels}
        return {label: name for label, name in names.items() if name != label and list(names.values()).count(name) == 1}


def landings_without_contacts(name: str) -> tuple[Robot, list[Scene]]:
    """A robot, and its landings as of a scene without contacts, 1 m/s straight down in its standing posture.

    Raises:
        ShockError: the robot cannot be loaded.
    """
    robot = load_robot(name)
    return robot, with_contacts(Scene(robot=name), robot)


@study(
    "shockpc batch anymal_c go2 solo12",
    more=(
        "Each robot stands in its standing posture and falls straight down at 1 m/s, on all level feet together, on each edge of"
        " their support and on each foot, unless options say otherwise. With --contact, only matching frames strike; a scene"
        " lands as it says. Ends with exit code 3 if none of the landings can be computed. A quantity of bodies or"
        " points is that of the trunk, the heaviest body, unless a place is named; of"
        " several places it is the worst."
    ),
)
def batch(
    robots: Iterable[str],
    read: Read = landings_without_contacts,
    executor: Executor | None = None,
    look: Callable[[ShockProfile], Any] | None = None,
    done: Callable[[str], None] | None = None,
    quantities: QuantityOption = (),
    rank: Annotated[
        str,
        Option(
            "Quantity by which landings are ranked, the worst first; the greatest first where neither direction is worse.",
            "What is computed",
            "KEY[@PLACE]",
        ),
    ] = "shock_max",
) -> Batch:
    """Compute the landings of many robots, one robot after the other or several at once.

    Args:
        robots: names and files.
        read: finds the landings of each.
        executor: computes each robot; in this process by default. Others need `read` and `look` to be picklable.
        look: makes something of each profile, such as a picture, where the profile is computed.
        done: is called with the name of each robot that is computed, in the order of `robots`.

    Raises:
        UnknownName: there is no such quantity.
        StudyError: no robot is given.
    """
    names = list(robots)
    if not names:
        raise StudyError("no robot is given; give at least one name or file")
    texts = {text.removeprefix("robot."): text for text in (*STANDARD, *quantities, rank)}
    wanted = tuple(select(text.partition("@")[0]) for text in texts.values())
    evaluation = Evaluation(
        ListedLandings(tuple(names), functools.partial(_read, read, wanted)), prove=None, look=functools.partial(_row, look, texts)
    )
    tables = []
    for source, part in zip(names, evaluation.tables(executor), strict=True):
        tables.append(replace(part, looks={i: replace(row, source=source) for i, row in part.looks.items()}))
        if done is not None:
            done(source)
    table = Table.joined(tables)
    rows = list(table.looks.values())
    labels = [table.columns[name].tolist() for name in HEADINGS]
    failures = [Failure(labels[0][i], labels[1][i], text) for i, text in table.messages.items()]
    name = rank.removeprefix("robot.")
    selection = select(rank.partition("@")[0])

    rows.sort(
        key=lambda row: (selection.worse(_number(row, name)), select("shock_com").worse(_number(row, "shock_com"))), reverse=True
    )
    values = {text: np.array([_number(table.looks.get(i), text) for i in range(len(table))]) for text in texts}
    columns = {**{name: table.columns[name] for name in HEADINGS}, **values, "proven": table.columns["proven"]}
    return Batch(tuple(texts), name, tuple(rows), tuple(failures), replace(table, columns=columns, looks={}))


def _read(read: Read, wanted: tuple[Selection, ...], name: str) -> tuple[Robot, list[Scene]]:
    """The landings of a robot, none of which gives a friction or a stiffness on which no number depends."""
    robot, scenes = read(name)
    scenes = list(scenes)
    for scene in scenes:
        refuse_unused_ground(scene, (selection.quantity for selection in wanted))
    return robot, scenes


def _number(row: BatchRow | None, text: str) -> float:
    value = None if row is None else row.values[text]
    return math.nan if value is None else value


def _row(look: Callable[[ShockProfile], Any] | None, texts: Mapping[str, str], profile: ShockProfile) -> BatchRow:
    trunk = profile.places("body")[int(np.argmax(profile.robot.masses))]
    model = profile.landing.joint_model
    return BatchRow(
        source="",
        robot=profile.robot.label,
        contact=contact_name(profile.scene),
        trunk=trunk.name,
        joint_model=profile.joint_model,
        drives=model.drives,
        drives_known=bool(model.drives) or (model.name in ("geared", "mixed") and not model.unknown.any()),
        values={name: _worst(profile, trunk, text) for name, text in texts.items()},
        sensors={point.frame: point.shock for point in profile.points},
        warnings=profile.health.warnings,
        needs_tilt=bool(profile.values(NEEDS_TILT)[0] == 1.0),
        scene=profile.scene,
        picture=None if look is None else look(profile),
    )


def _worst(profile: ShockProfile, trunk: Place, text: str) -> float | None:
    """The worst value of a quantity at the places that a text means; None where there is none at one of them."""
    selection, places = selected(profile.landing, text)
    quantity = selection.quantity
    if "@" not in text and quantity.of in ("body", "point"):
        places = (trunk,)
    numbers = profile.numbers(selection, places)
    if not len(numbers) or np.isnan(numbers).any():
        return None
    return float(numbers[np.argmax(selection.worse(numbers))])
