"""Columns of a sweep: of points and bodies, of what the ground allows, and of other quantities."""

from collections.abc import Sequence

from shockpc.evaluation.column import Column, ground_columns, selected
from shockpc.evaluation.variations.rows import VariedLandings
from shockpc.landing.places import Place, body_places, moving_point
from shockpc.landing.scenes.scene import Point
from shockpc.quantities.selection import select
from shockpc.robot.robot import Robot
from shockpc.text.errors import StudyError

SEVERE = (
    "most_severe",
    "most_severe_direction.x",
    "most_severe_direction.y",
    "most_severe_direction.z",
)
"""The most severe strike, of points; of bodies with "body." before it."""

OF_POINT = ("shock", *SEVERE)
"""Quantities of each point."""

OF_BODY = ("shock_com", "copc.x", "copc.y", "copc.z", "ropc", *(f"body.{key}" for key in SEVERE))
"""Quantities of each body."""

FEASIBILITY = (
    "friction_needed",
    "tensile_impulse",
    "energy_gained",
    "depth_below_contacts",
    "feasible",
)
"""Quantities of every row that tell whether flat ground allows the landing."""


def sweep_columns(
    study: VariedLandings,
    points: Sequence[Point],
    names: Sequence[str],
    quantities: Sequence[str],
) -> tuple[Column, ...]:
    """The columns of a sweep; a quantity that is named replaces a column of the same name.

    Args:
        study: the landings.
        points: whose shock is computed.
        names: of bodies, or globs; without points and names the trunk.
        quantities: KEY or KEY@PLACES.

    Raises:
        UnknownName: there is no such body, quantity or place.
        StudyError: a quantity has no place, or names a contact while the contact varies.
    """
    robot, landing = study.robot, study.first
    columns = []
    places = {}
    for point in points:
        place = moving_point(robot, point)
        places[place.name] = place
    for place in places.values():
        columns += [Column(select(key), place) for key in OF_POINT]
    bodies = _bodies(robot, names)
    if not (places or bodies):
        bodies = [landing.trunk]
    for body in bodies:
        columns += [Column(select(key), body_places(robot)[body]) for key in OF_BODY]

    most_contacts = _varied_contacts(study)
    for text in (*FEASIBILITY, *quantities):
        selection, chosen = selected(landing, text)
        if selection.quantity.of == "contact":
            if most_contacts:
                chosen = _numbered_contacts(text, most_contacts)
            elif text in FEASIBILITY:
                chosen = chosen[: len(landing.contacts)]
        if not chosen:
            raise StudyError(
                f'"{text}": the robot has no sensor, and no point is given; name a frame: '
                f"{text}@{robot.links[0]}"
            )
        columns += [Column(selection, place, requested=text in quantities) for place in chosen]
    columns += ground_columns(landing)[1:]
    return tuple({column.name: column for column in columns}.values())


def _bodies(robot: Robot, names: Sequence[str]) -> list[int]:
    """The bodies that names or globs mean, each once."""
    bodies: dict[int, None] = {}
    for name in names:
        bodies |= dict.fromkeys(robot.match_bodies(name))
    return list(bodies)


def _varied_contacts(study: VariedLandings) -> int:
    """The largest number of contacts of a row where the contacts vary; 0 where they do not."""
    most = 0
    for varied in study.variations:
        if varied.kind.names_contacts:
            most = max(most, *(str(value).count("+") + 1 for value in varied.values))
    return most


def _numbered_contacts(text: str, most: int) -> tuple[Place, ...]:
    """The contacts of rows by their numbers, where they differ from row to row.

    Raises:
        StudyError: the quantity names one.
    """
    if "@" in text:
        raise StudyError(
            f'the contact varies, so "{text}" cannot name one; leave out the @ and the name'
        )
    return tuple(Place(f"contact {k + 1}", number=k) for k in range(most))
