"""The numbers of landings that a cost has: the values that count, and constraints."""

import math
import re
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from shockpc.core.number import NUMBER
from shockpc.core.spatial import Array
from shockpc.evaluation.column import Column, selected
from shockpc.evaluation.unused_ground import refuse_ground
from shockpc.evaluation.variations.rows import VariedLandings
from shockpc.landing.feet.soles import most_inside
from shockpc.landing.landing import PosedLanding
from shockpc.landing.places import Place
from shockpc.quantities.ground.heights import (
    CLEARANCE,
    HEIGHTS,
    REACH,
    SPREAD,
)
from shockpc.quantities.ground.levels import on_ground, without_shapes
from shockpc.quantities.ground.support import OVERHANG, standing_feet, stands
from shockpc.quantities.of_contacts import IMPULSE, REDUNDANT
from shockpc.quantities.of_robot import ENERGY_LOST, ROUNDING
from shockpc.quantities.quantity import Quantity, Relations, Scope
from shockpc.quantities.selection import Selection
from shockpc.robot.feet_and_sensors import each_foot
from shockpc.robot.robot import Robot
from shockpc.text.errors import StudyError


def _normal_impulses(impact: Any, places: Sequence[Place]) -> Array:
    normals = np.array([impact.constraints[place.number].normal for place in places])
    return np.asarray(np.sum(IMPULSE.compute(impact, places) * normals, axis=-1))


PUSH = Quantity(
    "push",
    "contact",
    "push of the ground",
    "N s",
    "neither",
    _normal_impulses,
    scope=Scope(f"{REDUNDANT}; --any-ground leaves it out"),
    relations=Relations(linear=True),
)
"""The push of the ground, as a number that a constraint can follow: it has either sign.

`feasible` decides by it and `HEIGHTS`.
"""

LOSS = ENERGY_LOST._replace(scope=Scope(f"{ENERGY_LOST.scope.missing}; --any-ground leaves it out"))
"""The energy lost, which no impact has below zero; without restitution none can have."""


class Term(NamedTuple):
    """A number of a landing that counts.

    Attributes:
        column: the number.
        landing: name of the landing.
        group: index of the landings that it is computed with.
        strike: its index among these.
        limit: of a constraint; None of a value.
        scale: of a constraint [its unit]; below zero where the limit is a lower one.
    """

    column: Column
    landing: str
    group: int
    strike: int
    limit: float | None = None
    scale: float = 1.0

    @property
    def text(self) -> str:
        """The constraint, or the name of the value."""
        if self.limit is None:
            return self.column.name
        relation = "<=" if self.scale > 0.0 else ">="
        unit = "" if self.column.unit == "-" else f" {self.column.unit}"
        return f"{self.column.title} {relation} {self.limit:g}{unit}"


class _Bounded(NamedTuple):
    """Columns with their limit and scale, as in `Term`."""

    columns: Sequence[Column]
    limit: float | None = None
    scale: float = 1.0


def terms_of(
    group: VariedLandings, index: int, quantity: str, keep: Iterable[str], ground: bool
) -> list[Term]:
    """The terms of landings that differ only in the strike.

    Args:
        group: these landings.
        index: of the group.
        quantity: KEY@PLACES, the value that counts.
        keep: constraints, KEY@PLACES<=LIMIT or >=LIMIT.
        ground: whether flat ground has to allow the landings.

    Raises:
        ShockError: a quantity or place is not known, or a constraint is not of this form.
    """
    landing = group.first
    bounded = [_Bounded(_columns(landing, quantity))]
    bounded += [_kept(landing, text) for text in keep]
    if ground:
        bounded += _ground_constraints(landing, group.robot)
    terms = []
    for columns, limit, scale in bounded:
        for column in columns:
            # Heights do not depend on the strike.
            once = column.selection.quantity in (*HEIGHTS, OVERHANG)
            names = list(group.struck)[:1] if once else list(group.struck)
            terms += [
                Term(column, name, index, strike, limit, scale) for strike, name in enumerate(names)
            ]
    return terms


def _columns(landing: PosedLanding, text: str) -> list[Column]:
    """The numbers that a text means, one for each place.

    Raises:
        ShockError: as for `selected`; or it is none of an impact, or takes contacts as sticking
            where the scene does not.
    """
    selection, places = selected(landing, text)
    entry = selection.quantity
    if entry.computation.on == "health" or entry.relations.role:
        raise StudyError(
            f"{selection.name} ({entry.title}) cannot be followed here; choose another quantity"
        )
    if not entry.of_ground(landing.scene):
        refuse_ground(landing.scene)
    return [Column(selection, place) for place in places]


def _kept(landing: PosedLanding, text: str) -> _Bounded:
    """A constraint KEY@PLACES<=LIMIT or >=LIMIT.

    Raises:
        ShockError: it is not of this form, or as for `_columns`.
    """
    parts = re.fullmatch(rf"(.+?)\s*([<>])=?\s*({NUMBER})", text.strip())
    limit = float(parts[3]) if parts else math.nan
    if not parts or not math.isfinite(limit):
        raise StudyError(
            f'"{text}" is not KEY@PLACES<=LIMIT or >=LIMIT, such as joint_impulse@*_KFE<=2'
        )
    columns = _columns(landing, parts[1])
    if limit < 0.0 and columns and columns[0].selection.signed:
        raise StudyError(
            f'"{text}": {parts[1]} may have either sign, so its magnitude is bounded, '
            f"which is never below zero"
        )
    size = abs(limit) or 1.0
    return _Bounded(columns, limit, size if parts[2] == "<" else -size)


def _ground_constraints(landing: PosedLanding, robot: Robot) -> list[_Bounded]:
    """The constraints with which flat ground allows a landing.

    Impulses are scaled by m v, energies by m v², with the fastest approach v of a contact, heights
    by the robot's length.
    """
    speed = landing.fastest_approach
    momentum = robot.mass * speed
    energy = momentum * speed
    tolerance = landing.scene.ground_tolerance
    bounded: list[_Bounded] = []

    if landing.scene.friction is None:
        bounded.append(_Bounded(_everywhere(landing, PUSH), 0.0, -momentum))
        if any(contact.restitution for contact in landing.contacts):
            bounded.append(_Bounded(_everywhere(landing, LOSS), -ROUNDING * energy, -energy))

    level = len(on_ground(landing))
    falls = level > 0 and landing.base != "fixed"
    feet = _feet(landing)
    if falls:
        # A link with a foot may be level with the contacts: all feet of a robot that stands are.
        clearances = _everywhere(landing, CLEARANCE)
        of_feet = [column for column in clearances if column.place.body in feet]
        of_others = [column for column in clearances if column.place.body not in feet]
        bounded.append(_Bounded(of_others, tolerance, -landing.length))
        bounded.append(_Bounded(of_feet, -tolerance, -landing.length))

        inside = max(most_inside(robot), tolerance)
        reaches = [
            column
            for column in _everywhere(landing, REACH)
            if without_shapes(landing, column.place.number)
        ]
        bounded.append(_Bounded(reaches, -inside, -landing.length))
    if level > 1:
        bounded.append(_Bounded(_everywhere(landing, SPREAD), tolerance, landing.length))
    if falls and _stands_on_feet(landing):
        bounded.append(_Bounded(_everywhere(landing, OVERHANG), 0.0, landing.length))
    return bounded


def _everywhere(landing: PosedLanding, quantity: Quantity) -> list[Column]:
    """The columns of a quantity at all places of its kind."""
    selection = Selection(quantity.key, quantity)
    return [Column(selection, place) for place in landing.places(quantity.of)]


def _footed(landing: PosedLanding) -> set[int]:
    """The bodies that have a foot."""
    return {landing.robot.frame(name).body for name in each_foot(landing.robot)}


def _struck(landing: PosedLanding) -> set[int]:
    """The bodies with a contact."""
    return {constraint.body for constraint in (*landing.contacts, *landing.stance)}


def _feet(landing: PosedLanding) -> set[int]:
    """The bodies that may be level with the contacts."""
    return _footed(landing) | _struck(landing)


def _stands_on_feet(landing: PosedLanding) -> bool:
    """True if only feet touch the ground, so that these have to carry the centre of mass."""
    if not _struck(landing) <= _footed(landing):
        return False
    return stands(landing) and len(standing_feet(landing.robot)) > 1
