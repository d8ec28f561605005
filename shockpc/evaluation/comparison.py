"""Designs side by side: the changes from the first to each other one, by partners, ranked."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from string import ascii_uppercase
from typing import NamedTuple

from shockpc.evaluation.column import selected
from shockpc.evaluation.designs import Design
from shockpc.evaluation.drive_ends import End, at_drive_ends
from shockpc.evaluation.partners import KINDS, Partners, matching, partners
from shockpc.evaluation.profiles import proven_profiles
from shockpc.evaluation.table import Table
from shockpc.landing.places import Place, PlaceKind
from shockpc.landing.scenes.scene import Scene
from shockpc.quantities.selection import Selection, select
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.text.display import brief, shown_by
from shockpc.text.errors import SceneError, ShockError, SolveError, StudyError
from shockpc.text.printed import listed, plural

STANDARD = (
    "shock",
    "shock_com",
    "shock_max",
    "ropc",
    "effective_mass_sticking",
    "effective_mass_frictionless",
    "joint_impulse",
    "joint_moment",
)
WITH_FRICTION = (
    "shock_friction",
    "shock_com_friction",
    "ropc_friction",
    "joint_impulse_friction",
    "joint_moment_friction",
)
"""Quantities with friction that are always compared where all designs land with friction.

Elsewhere those of contacts that stick are compared.
"""


def _change(first: float | None, value: float | None) -> float | None:
    """The change of a number; None if one of the two does not exist."""
    if first is None or value is None:
        return None
    # Also of two infinite ones.
    return 0.0 if value == first else value - first


def _share(first: float | None, change: float | None) -> float | None:
    """A change relative to the first number [%]; None if it is not finite."""
    if not first or change is None:
        return None
    share = 100.0 * change / abs(first)
    return share if math.isfinite(share) else None


class Difference(NamedTuple):
    """One number of every design.

    Attributes:
        place: name of the body, point, contact or joint.
        values: one for each design; None where it does not exist. An infinite radius is inf.
        body: of the first design that it belongs to; −1 for the robot and contacts.
        always: whether it is of the base, of the limb that is struck, or of a point, which short
            tables have too.
    """

    place: str
    values: tuple[float | None, ...]
    body: int
    always: bool

    @property
    def changes(self) -> tuple[float | None, ...]:
        """From the first design to each of the others; None where one of the two does not exist."""
        first, *others = self.values
        return tuple(_change(first, value) for value in others)

    @property
    def shares(self) -> tuple[float | None, ...]:
        """The changes relative to the first design [%].

        They are None where a value does not exist or is not finite, or the first is zero.
        """
        first = self.values[0]
        return tuple(_share(first, change) for change in self.changes)


class Differences(NamedTuple):
    """A quantity at all places that the designs have in common.

    Attributes:
        selection: the quantity.
        rows: the limb that is struck first, from the contact up, then the largest change first; of
            radii of percussion that of their reciprocals, the shock per metre.
    """

    selection: Selection
    rows: tuple[Difference, ...]


class Unmatched(NamedTuple):
    """A body, point, joint or part that some designs lack.

    Attributes:
        kind: "body", "point", "joint" or "part".
        name: its name.
        designs: indices of those that have it.
    """

    kind: PlaceKind
    name: str
    designs: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Comparison:
    """Designs side by side.

    Attributes:
        designs: the first is the one that the others are compared with.
        profiles: of their landings.
        quantities: what was compared, of what all designs have.
        unmatched: what has no partner in every other design.
        partners: of the first design's bodies, points, joints and parts, in each of the others.
        ends: the comparison with all drives of all designs at the smallest inertias that what is
            known allows, and at the largest, or why there is none; empty where all drives are known
            exactly.
    """

    designs: tuple[Design, ...]
    profiles: tuple[ShockProfile, ...] = field(repr=False)
    quantities: tuple[Differences, ...]
    unmatched: tuple[Unmatched, ...]
    partners: tuple[Partners, ...] = field(repr=False)
    ends: Mapping[End, "Comparison | ShockError"] = field(default_factory=dict, repr=False)

    _repr_html_ = shown_by("show.comparison:compare_report")

    def __repr__(self) -> str:
        return brief(
            self,
            " against ".join(design.label for design in self.designs),
            f"{len(self.quantities)} quantities",
        )

    @property
    def letters(self) -> list[str]:
        """The names of the designs in tables."""
        count = len(self.designs)
        return [*ascii_uppercase, *(f"design {k}" for k in range(27, count + 1))][:count]

    @property
    def table(self) -> Table:
        """A row for each quantity at each place that the designs have in common.

        It has the values, and their changes from the first.
        """
        first, *others = self.letters
        rows = []
        for differences in self.quantities:
            unit = differences.selection.quantity.unit_text
            for row in differences.rows:
                head = (differences.selection.name, unit, row.place)
                rows.append((*head, *row.values, *row.changes, *row.shares))
        changes = [f"{name} - {first}" for name in others]
        shares = [f"change of {name} [%]" for name in others]
        header = ("quantity", "unit", "place", first, *others, *changes, *shares)
        return Table.of_rows(header, rows)


def compared(
    designs: Sequence[Design],
    quantities: Sequence[str] = (),
    pairs: Sequence[tuple[str, str]] = (),
) -> Comparison:
    """The comparison of at least two designs.

    Args:
        designs: the first is the one that the others are compared with.
        quantities: QUANTITY[@PLACES], besides those that are always compared.
        pairs: names of the first design with those of the others, as in `partners`.

    Raises:
        ShockError: a design cannot be computed, or lacks a place that is named; or a quantity has
            no value at any place that all of them have.
    """
    slides = all(design.scene.friction is not None for design in designs)
    usual = WITH_FRICTION if slides else STANDARD
    texts = tuple(dict.fromkeys((*quantities, *usual)))
    profiles = _profiles(designs, [select(text.partition("@")[0]) for text in texts])
    for pair in pairs:
        _refuse_unknown(pair, designs, profiles)
    matched = tuple(partners(profiles[0], profile, pairs) for profile in profiles[1:])
    differences = {text: _differences(profiles, matched, text) for text in texts}
    for text in quantities:
        if not differences[text].rows:
            raise StudyError(_nothing(designs, profiles, matched, text))
    modelled = Comparison(
        designs=tuple(designs),
        profiles=profiles,
        quantities=tuple(table for table in differences.values() if table.rows),
        unmatched=_unmatched(profiles, matched),
        partners=matched,
    )

    def at_end(scenes: dict[str, Scene]) -> Comparison:
        with_scenes = zip(designs, scenes.values(), strict=True)
        return compared(
            [replace(design, scene=scene) for design, scene in with_scenes], quantities, pairs
        )

    cases = {str(k): (design.scene, design.robot) for k, design in enumerate(designs)}
    return replace(modelled, ends=at_drive_ends(modelled, cases, at_end))


def _refuse_unknown(
    pair: tuple[str, str], designs: Sequence[Design], profiles: Sequence[ShockProfile]
) -> None:
    """Refuse a pair of names that no other design has.

    Raises:
        StudyError: the text lists the bodies.
    """
    first, *others = profiles
    if any(any(matching(first, profile, *pair).values()) for profile in others):
        return
    bodies = [
        f"bodies of {design.label}: {', '.join(profile.bodies)}"
        for design, profile in zip(designs, profiles, strict=True)
    ]
    raise StudyError(
        f'--pair "{"=".join(pair)}" names no body, joint or point of both designs; '
        f"{'; '.join(bodies)}"
    )


def _nothing(
    designs: Sequence[Design],
    profiles: Sequence[ShockProfile],
    matched: Sequence[Partners],
    text: str,
) -> str:
    """The reason why a quantity cannot be compared: no place in common, or no values."""
    names = []
    for profile in profiles:
        selection, places = selected(profile.landing, text.partition("@")[0])
        names.append([place.name for place in places])
    quantity = selection.quantity
    if quantity.of in ("robot", "contact"):
        in_common = len(set(map(len, names))) == 1
        rule = "their number has to be the same"
    else:
        in_common = all(partners_of[quantity.of] for partners_of in matched)
        rule = "partners have the same name, or are given by --pair"
    if in_common:
        why = quantity.scope.missing or "it is not defined there"
        return (
            f'"{text}" has no value at any {quantity.of} that the designs have in common: {why}; '
            f"leave it out"
        )
    of_designs = [
        f"of {design.label} {listed(of_design, 4) or 'none'}"
        for design, of_design in zip(designs, names, strict=True)
    ]
    return (
        f'"{text}" cannot be compared, because the designs have no '
        f"{plural(quantity.of)} in common: {', '.join(of_designs)}; {rule}"
    )


def _profiles(
    designs: Sequence[Design], selections: Sequence[Selection]
) -> tuple[ShockProfile, ...]:
    """The profiles of designs.

    Raises:
        ShockError: of the first design that cannot be computed, which it names.
    """
    cases = {str(k): (design.scene, design.robot) for k, design in enumerate(designs)}
    profiles = []
    for design, result in zip(designs, proven_profiles(cases, selections).values(), strict=True):
        if isinstance(result, (SceneError, SolveError)):
            raise type(result)(f"{design.label}: {result}", **result.data)
        if isinstance(result, ShockError):
            raise result
        profiles.append(result)
    return tuple(profiles)


def _differences(
    profiles: Sequence[ShockProfile], matched: Sequence[Partners], text: str
) -> Differences:
    """The numbers of what all designs have."""
    selection, rows = _common_places(profiles, matched, text)
    of_points = selection.quantity.of == "point"
    limb = _limb(profiles[0])
    numbers = []
    if rows:
        for profile, places in zip(profiles, zip(*rows, strict=True), strict=True):
            numbers.append(profile.numbers(selection, places).tolist())
    differences = []
    for places, values in zip(rows, zip(*numbers, strict=True), strict=True):
        if all(map(math.isnan, values)):
            continue
        existing = tuple(map(_existing, values))
        body = places[0].body
        always = body in (0, *limb) or of_points
        name = " / ".join(dict.fromkeys(place.name for place in places))
        differences.append(Difference(name, existing, body, always))
    reciprocal = bool(selection.quantity.relations.reciprocal)

    def rank(row: Difference) -> tuple[int, float]:
        above = len(limb)
        if row.body in limb and not of_points:
            above = limb.index(row.body)
        return above, -_size(row, reciprocal)

    return Differences(selection, tuple(sorted(differences, key=rank)))


def _existing(value: float) -> float | None:
    """A number; None in place of NaN."""
    return None if math.isnan(value) else value


def _limb(profile: ShockProfile) -> list[int]:
    """The bodies of the limb that is struck, from the contacts up."""
    robot = profile.robot
    bodies: dict[int, None] = {}
    for contact in profile.scene.contact:
        bodies |= dict.fromkeys(robot.limb(robot.frame(contact.frame).body))
    return list(bodies)


def _common_places(
    profiles: Sequence[ShockProfile], matched: Sequence[Partners], text: str
) -> tuple[Selection, list[tuple[Place, ...]]]:
    """A quantity, and the places that all designs have, a tuple of partners each."""
    selection, first = selected(profiles[0].landing, text)
    columns: list[Sequence[Place | None]] = [first]
    for profile, of_design in zip(profiles[1:], matched, strict=True):
        columns.append(_partners_of(first, profile, of_design, text))
    rows: list[tuple[Place, ...]] = []
    if len({len(column) for column in columns}) == 1:
        for row in zip(*columns, strict=True):
            places = tuple(place for place in row if place is not None)
            if len(places) == len(row):
                rows.append(places)
    return selection, rows


def _partners_of(
    first: Sequence[Place], profile: ShockProfile, matched: Partners, text: str
) -> list[Place | None]:
    """The places of another design that are partners of those of the first.

    Robots and contacts are partners in their order.
    """
    key, at, _ = text.partition("@")
    kind = select(key).quantity.of
    if kind in ("robot", "contact"):
        return list(selected(profile.landing, text)[1])
    by_name = {place.name: place for place in profile.places(kind)}
    places = [by_name.get(matched[kind].get(place.name, "")) for place in first]
    if at and places == [None]:
        # A point that is not one of the scene's.
        return list(selected(profile.landing, f"{key}@{first[0].name}")[1])
    return places


def _size(row: Difference, reciprocal: bool) -> float:
    """The largest change of the values, or of their reciprocals; −1 if there is none.

    The shock per metre of an infinite radius of percussion is finite.
    """
    values = row.values
    if reciprocal:
        values = tuple(map(_reciprocal, values))
    first, *others = values
    changes = [_change(first, value) for value in others]
    return max((abs(change) for change in changes if change is not None), default=-1.0)


def _reciprocal(value: float | None) -> float | None:
    """1/value; None if it does not exist."""
    return None if value is None else 1.0 / value


def _unmatched(
    profiles: Sequence[ShockProfile], matched: Sequence[Partners]
) -> tuple[Unmatched, ...]:
    """Bodies, points, joints and parts without a partner in every other design."""
    first, *others = profiles
    unmatched = []
    for kind in KINDS:
        owners: dict[str, list[int]] = {}
        for place in first.places(kind):
            shared = [
                k for k, of_design in enumerate(matched, start=1) if place.name in of_design[kind]
            ]
            if len(shared) < len(matched):
                owners[place.name] = [0, *shared]
        for k, (profile, of_design) in enumerate(zip(others, matched, strict=True), start=1):
            for place in profile.places(kind):
                if place.name not in of_design[kind].values():
                    owners.setdefault(place.name, []).append(k)
        unmatched += [Unmatched(kind, name, tuple(having)) for name, having in owners.items()]
    return tuple(unmatched)
