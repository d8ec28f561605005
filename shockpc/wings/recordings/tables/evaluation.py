"""The landings of a table with the columns that are computed of them."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from shockpc.evaluation.column import Column, selected
from shockpc.evaluation.evaluate import Evaluation
from shockpc.landing.places import Place, point_places
from shockpc.quantities.selection import Selection, select
from shockpc.robot.robot import Robot
from shockpc.text.errors import StudyError, UnknownName
from shockpc.text.printed import listed
from shockpc.wings.recordings.tables.landings import RecordedLandings
from shockpc.wings.recordings.tables.rows import RecordedRows


def recorded_landings(
    table: RecordedRows,
    robot: Robot,
    quantities: Sequence[str] = (),
    *,
    prove: int = 20,
    rank: str | None = None,
) -> Evaluation[RecordedLandings]:
    """The landings of a table, and what is computed of them.

    Args:
        table: the rows.
        robot: their robot.
        quantities: columns, KEY or KEY@PLACES; by default jump and shock at the sensors and points,
            or of the base, with friction if rows have one. The energy that an impact would make is
            a column of all tables.
        prove: number of rows that are compared with a proof, besides those that need one.
        rank: a further column.

    Raises:
        ShockError: a name is not known, or a scene cannot be resolved.
    """
    source = RecordedLandings(robot, table)
    texts = list(quantities) or _usual_columns(source)
    if rank:
        texts.append(rank)
    computed: list[Column] = []
    for text in dict.fromkeys(texts):
        computed += _columns(source, text)
    by_friction = False
    for column in computed:
        entry = column.selection.quantity
        if entry.decided_by_ground or entry.computation.exact == "never":
            by_friction = True
    flag = Column(select("energy_gained"), source.first.places("robot")[0])
    by_name = {column.name: column for column in computed}
    by_name.setdefault(flag.name, flag)
    # The last, even if it was asked for.
    by_name[flag.name] = by_name.pop(flag.name)
    return Evaluation(replace(source, by_friction=by_friction), tuple(by_name.values()), prove)


def _usual_columns(source: RecordedLandings) -> list[str]:
    """Jump and shock at the sensors and points, or of the base; with friction if rows have one."""
    table = source.table
    sticks = np.isnan(table.friction)
    suffixes = []
    if sticks.any():
        suffixes.append("")
    if not sticks.all():
        suffixes.append("_friction")
    points: dict[str, None] = {}
    for scene in table.scenes:
        for place in point_places(source.robot, scene.point):
            if place.body >= 0:
                points[place.name] = None
    texts = []
    for name in points:
        for suffix in suffixes:
            texts += [f"delta_v{suffix}@{name}", f"shock{suffix}@{name}"]
    if texts:
        return texts
    of_base = {"": ("delta_v_com", "shock_com"), "_friction": ("shock_com_friction",)}
    base = source.robot.bodies[source.first.trunk].name
    for suffix in suffixes:
        texts += [f"{key}@{base}" for key in of_base[suffix]]
    return texts


def _columns(source: RecordedLandings, text: str) -> list[Column]:
    """The columns of QUANTITY[@PLACES].

    Raises:
        ShockError: it names nothing, or one of contacts that vary.
    """
    selection, places = _places(source, text)
    contacts = set()
    for scene in source.table.scenes:
        contacts.add(tuple(contact.frame for contact in scene.contact))
    if len(contacts) > 1 and selection.quantity.of == "contact":
        if "@" in text:
            raise StudyError(
                f'the contact varies, so "{text}" cannot name one; leave out the @ and the name'
            )
        most = max(map(len, contacts))
        places = tuple(Place(f"contact {k + 1}", number=k) for k in range(most))
    if not places:
        links = listed(source.robot.links, 6)
        raise StudyError(f'"{text}": there is no such place; links of the robot: {links}')
    return [Column(selection, place, requested=True) for place in places]


def _places(source: RecordedLandings, text: str) -> tuple[Selection, tuple[Place, ...]]:
    """The quantity and the places of QUANTITY[@PLACES] in all landings of a table.

    Only some of these may have friction, or a contact.

    Raises:
        ShockError: it means nothing in any of them.
    """
    places: dict[str, Place] = {}
    refusals = []
    for landing in source.resolved:
        try:
            places |= {
                place.name: place
                for place in selected(landing, text)[1]
                if place.name not in places
            }
        except (StudyError, UnknownName) as refusal:
            refusals.append(refusal)
    if refusals and not places:
        raise refusals[0]
    return select(text.partition("@")[0]), tuple(places.values())
