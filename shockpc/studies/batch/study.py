"""Landings of many robots in their standing postures.

They are on all level feet, on some of them, and on each foot.
"""

import functools
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Executor
from typing import Annotated, Any, NamedTuple

import numpy as np

from shockpc.evaluation.column import selected
from shockpc.evaluation.declare import QuantityOption, study
from shockpc.evaluation.executor import in_order
from shockpc.evaluation.profiles import proven_profiles
from shockpc.judgement.drive_range import range_of
from shockpc.judgement.first_number import imu_places
from shockpc.judgement.standing import posture_marks
from shockpc.judgement.unknowns import NOT_KNOWN
from shockpc.landing.contact import contact_name
from shockpc.landing.feet.level_feet import with_contacts
from shockpc.landing.places import Place
from shockpc.landing.scenes.scene import Scene
from shockpc.landing.scenes.scene_fields import Option
from shockpc.quantities.selection import Selection, select
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.robot.feet_and_sensors import each_foot
from shockpc.robot.load import load_robot
from shockpc.robot.robot import Robot
from shockpc.studies.batch.rows import Batch, BatchRow, Failure
from shockpc.text.errors import ShockError, StudyError, attempt, traces

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


def landings_without_contacts(name: str) -> tuple[Robot, list[Scene]]:
    """A robot, and its landings as of a scene without contacts.

    They are at 1 m/s straight down in its standing posture.

    Raises:
        ShockError: the robot cannot be loaded.
    """
    robot = load_robot(name)
    return robot, with_contacts(Scene(robot=name), robot)


@study(
    "shockpc batch anymal_c go2 solo12",
    more=(
        "Each robot falls straight down at 1 m/s in its standing posture, on all level feet "
        "together, on each edge of their support and on each foot. With --contact, only matching "
        "frames are contacts; a scene keeps its landing. A line is the worst landing of a robot; "
        "--landings prints all landings. Robots with unknown drives have no rank, and come last. "
        "Ends with exit code 3 if none of the landings can be computed. Quantities of points are "
        "taken at the robot's IMU, without an IMU at the trunk (the heaviest body). Quantities of "
        "bodies are taken at the trunk. If a name matches several places, the worst counts."
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
            "Quantity by which landings are ranked, the worst first (the largest first if neither "
            "direction is worse).",
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
    selections = tuple(select(text.partition("@")[0]) for text in texts.values())
    wanted = _Wanted(texts, selections, rank.removeprefix("robot."), look)
    work = functools.partial(_landings_of, read, wanted)
    landings: list[BatchRow | Failure] = []
    defects: list[str] = []
    advance = progress(len(names))
    for name, (of_robot, unexpected) in zip(names, in_order(executor, work, names), strict=True):
        landings += of_robot
        defects += unexpected
        advance(name)
    return Batch(tuple(texts), wanted.rank, tuple(landings), tuple(defects))


class _Wanted(NamedTuple):
    """What is computed of each landing.

    Attributes:
        texts: KEY[@PLACE] of each quantity, by its name.
        selections: what these select.
        rank: name of the quantity by which landings are ranked.
        look: as of `batch`.
    """

    texts: Mapping[str, str]
    selections: tuple[Selection, ...]
    rank: str
    look: Callable[[ShockProfile], Any] | None


def _landings_of(
    read: Read, wanted: _Wanted, name: str
) -> tuple[list[BatchRow | Failure], list[str]]:
    """The landings of a robot, and descriptions of unexpected exceptions.

    There is one failure if it cannot be read, or gives a friction or a stiffness on which no number
    depends.
    """
    solved = attempt(_solved, read, wanted.selections, name)
    if isinstance(solved, ShockError):
        return [Failure(name, "", str(solved))], traces([solved])
    landings: list[BatchRow | Failure] = []
    errors: list[ShockError] = []
    for scene, profile in solved:
        row: BatchRow | ShockError
        if isinstance(profile, ShockError):
            row = profile
        else:
            row = attempt(_row, wanted, name, profile)
        if isinstance(row, ShockError):
            errors.append(row)
            landings.append(Failure(name, contact_name(scene), str(row)))
        else:
            landings.append(row)
    return landings, traces(errors)


def _solved(
    read: Read, selections: tuple[Selection, ...], name: str
) -> list[tuple[Scene, ShockProfile | ShockError]]:
    """The scenes of a robot, each with its profile or why there is none."""
    robot, scenes = read(name)
    cases = {str(k): (scene, robot) for k, scene in enumerate(scenes)}
    results = proven_profiles(cases, selections)
    return [(scene, results[key]) for key, (scene, _) in cases.items()]


def _row(wanted: _Wanted, source: str, profile: ShockProfile) -> BatchRow:
    """The row of a landing."""
    trunk = profile.places("body")[profile.main_body]
    status = [unknown.status for unknown in profile.unknowns if unknown.kind == "drives"]
    values = {}
    for name, text in wanted.texts.items():
        values[name] = _value(profile, *_worst_place(profile, text))
    selection, place = _worst_place(profile, wanted.texts[wanted.rank])
    return BatchRow(
        source=source,
        robot=profile.robot.label,
        contact=contact_name(profile.scene),
        trunk=trunk.name,
        joint_model=profile.joint_model,
        drives=profile.landing.joint_model.drives,
        status=", ".join(dict.fromkeys(status)) or "as given",
        drives_known=set(NOT_KNOWN).isdisjoint(status),
        at=_sensed(profile).title,
        values=values,
        range=None if place is None else range_of(profile, selection, place),
        effective_mass=profile.effective_mass,
        feet=each_foot(profile.robot),
        marks=posture_marks(profile.scene, profile.health.warnings),
        sensors={point.frame: point.shock for point in profile.points},
        warnings=profile.health.warnings,
        feasible_if_tilted=bool(profile.value("feasible_if_tilted", "robot")[0] == 1.0),
        scene=profile.scene,
        picture=None if wanted.look is None else wanted.look(profile),
    )


def _sensed(profile: ShockProfile) -> Place:
    """The IMU of a robot, of several that with the largest shock.

    Without an IMU it is the centre of mass of the trunk.
    """
    imus = imu_places(profile)
    if not imus:
        return profile.bracketed[0]
    return imus[int(np.argmax(profile.value("shock", "point", imus)))]


def _worst_place(profile: ShockProfile, text: str) -> tuple[Selection, Place | None]:
    """The selection of a text, and of the places that it means the one with the worst value.

    The place is None where one of them has no value.
    """
    selection, places = selected(profile.landing, text)
    if "@" not in text and selection.quantity.of == "body":
        places = (profile.places("body")[profile.main_body],)
    if "@" not in text and selection.quantity.of == "point":
        places = (_sensed(profile),)
    numbers = profile.numbers(selection, places)
    if not len(numbers) or np.isnan(numbers).any():
        return selection, None
    return selection, places[int(np.argmax(selection.worse(numbers)))]


def _value(profile: ShockProfile, selection: Selection, place: Place | None) -> float | None:
    return None if place is None else float(profile.numbers(selection, [place])[0])
