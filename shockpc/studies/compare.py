"""Designs side by side: what changes from the first one to each of the others, ranked, matched by name."""

import itertools
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from shockpc.errors import SceneError, SolveError, StudyError
from shockpc.places import Kind
from shockpc.printed import listed
from shockpc.profile import shock_profile
from shockpc.quantities.table import Selection
from shockpc.result import ShockProfile
from shockpc.robot.changes import Change, changed
from shockpc.robot.record import Robot
from shockpc.scene import Scene
from shockpc.studies.columns import selected

STANDARD = ("shock_com", "shock_max", "shock", "ropc", "mass_sticking", "mass_frictionless", "joint_impulse", "joint_moment")
"""Quantities that are always compared."""

KINDS: tuple[Kind, ...] = ("body", "point", "joint")
"""Places that are matched by name."""


@dataclass(frozen=True, eq=False)
class Design:
    """One robot in one landing.

    Attributes:
        label: what tells it from the others.
        scene: the landing.
        robot: the robot.
        changes: what was changed of the robot after it was loaded.
    """

    label: str
    scene: Scene = field(repr=False)
    robot: Robot = field(repr=False)
    changes: tuple[Change, ...] = ()


class Difference(NamedTuple):
    """One number of every design.

    Attributes:
        place: name of the body, point, contact or joint.
        values: one for each design; None where it does not exist. An infinite radius is inf.
    """

    place: str
    values: tuple[float | None, ...]

    @property
    def changes(self) -> tuple[float | None, ...]:
        """From the first design to each of the others; None where one of the two does not exist."""
        first = self.values[0]
        return tuple(
            None if first is None or value is None else 0.0 if value == first else value - first for value in self.values[1:]
        )


class Differences(NamedTuple):
    """A quantity at all places that the designs have in common.

    Attributes:
        selection: the quantity.
        rows: the largest change first; of radii of percussion that of their reciprocals, the shock per metre.
    """

    selection: Selection
    rows: tuple[Difference, ...]


class Unmatched(NamedTuple):
    """What some designs lack.

    Attributes:
        kind: "body", "point" or "joint".
        name: its name.
        designs: indices of those that have it.
    """

    kind: Kind
    name: str
    designs: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Comparison:
    """Designs side by side.

    Attributes:
        designs: the first is the one that the others are compared with.
        profiles: of their landings.
        quantities: what was compared, of what all designs have.
        unmatched: what has no partner of its name in every other design.
    """

    designs: tuple[Design, ...]
    profiles: tuple[ShockProfile, ...] = field(repr=False)
    quantities: tuple[Differences, ...]
    unmatched: tuple[Unmatched, ...]


def design_with(design: Design, changes: Sequence[Change]) -> Design:
    """A design with its robot changed.

    Raises:
        UnknownName: a pattern matches no link, or no joint.
        StudyError: a changed armature has no effect, because the scene sets that of the same joint.
    """
    joints = design.scene.joints
    for change in changes:
        if change.what != "armature":
            continue
        given = [name for pattern in (*joints.armature, *joints.rotor) for name in design.robot.match_joints(pattern)]
        covered = [name for name in design.robot.match_joints(change.pattern) if name in given]
        file = joints.drives if joints.drives != "none" else None
        if covered or joints.model == "free" or file:
            why = (
                f'sets that of joint "{covered[0]}"'
                if covered
                else f"takes the drives from {file}"
                if file
                else "makes all joints free"
            )
            raise StudyError(f"change {change} has no effect, because the scene {why}; leave one of the two out")
    robot = replace(design.robot, default_drives=None) if joints.drives == "none" else design.robot
    label = "; ".join([design.label, *map(str, changes)])
    return Design(label, design.scene, changed(robot, changes), (*design.changes, *changes))


def compare(designs: Iterable[Design], quantities: Sequence[str] = ()) -> Comparison:
    """Compute the landings of some designs, and what differs.

    Args:
        designs: the first is the one that the others are compared with.
        quantities: what is compared besides the standard ones: QUANTITY or QUANTITY@PLACES, as `selected` takes it.

    Raises:
        ShockError: there are fewer than two designs, one of them cannot be computed, or lacks a place that is named; or a quantity
            has no value at any place that all of them have.
    """
    every = tuple(designs)
    if len(every) < 2:
        raise StudyError("one design cannot be compared; give another one, or a change of it with --change")
    profiles = tuple(map(_profile, every))
    differences = {text: _differences(profiles, text) for text in dict.fromkeys((*quantities, *STANDARD))}
    for text in quantities:
        if not differences[text].rows:
            raise StudyError(_nothing(every, profiles, text))
    return Comparison(every, profiles, tuple(one for one in differences.values() if one.rows), _unmatched(profiles))


def _nothing(designs: Sequence[Design], profiles: Sequence[ShockProfile], text: str) -> str:
    """Why a quantity cannot be compared: designs without a place in common, or values that are missing."""
    found = [selected(profile.landing, text) for profile in profiles]
    quantity, names = found[0][0].quantity, [[place.name for place in places] for _, places in found]
    if quantity.of in ("robot", "contact"):
        apart, rule = len(set(map(len, names))) > 1, "their number has to be the same"
    else:
        apart, rule = not set(names[0]).intersection(*names[1:]), "they are matched by name"
    if not apart:
        why = quantity.missing or "it is not defined there"
        return f'"{text}" has no value at any {quantity.of} that the designs have in common: {why}; leave it out'
    owned = ", ".join(f"of {design.label} {listed(own, 4) or 'none'}" for design, own in zip(designs, names, strict=True))
    return f'"{text}" cannot be compared, because the designs have no {quantity.of}s in common: {owned}; {rule}'


def _profile(design: Design) -> ShockProfile:
    """The profile of a design; a refusal names it."""
    try:
        return shock_profile(design.scene, design.robot)
    except (SceneError, SolveError) as refusal:
        raise type(refusal)(f"{design.label}: {refusal}", **refusal.data) from None


def _differences(profiles: Sequence[ShockProfile], text: str) -> Differences:
    values = []
    for profile in profiles:
        selection, places = selected(profile.landing, text)
        numbers = selection.scalar(profile.values(selection.quantity, places)).tolist()
        values.append({place.name: None if math.isnan(x) else x for place, x in zip(places, numbers, strict=True)})
    if selection.quantity.of in ("robot", "contact"):
        # Partners in their order, whatever their names, where all designs have as many of them.
        names = list(map(_paired, zip(*values, strict=True))) if len(set(map(len, values))) == 1 else []
        values = [dict(zip(names, own.values(), strict=False)) for own in values]
    if selection.quantity.of == "body":
        trunks = _trunks(profiles)
        values = [own | ({_paired(trunks): own[trunk]} if trunk in own else {}) for own, trunk in zip(values, trunks, strict=True)]
    shared = [place for place in values[0] if all(place in own for own in values)]
    rows = [Difference(place, tuple(own[place] for own in values)) for place in shared]
    rows = [row for row in rows if any(value is not None for value in row.values)]
    return Differences(selection, tuple(sorted(rows, key=lambda row: _size(row, selection.quantity.key == "ropc"), reverse=True)))


def _size(row: Difference, reciprocal: bool) -> float:
    """The largest change, or that of the reciprocals: of an infinite radius of percussion the shock per metre is finite."""
    first, *others = (None if value is None else 1.0 / value if reciprocal else value for value in row.values)
    return max((abs(value - first) for value in others if value is not None and first is not None), default=-1.0)


def _trunks(profiles: Sequence[ShockProfile]) -> list[str]:
    """The heaviest body of each design: the bodies that are partners whatever their names."""
    return [profile.bodies[int(np.argmax(profile.robot.masses))] for profile in profiles]


def _paired(names: Iterable[str]) -> str:
    """The names of partners as one."""
    return " / ".join(dict.fromkeys(names))


def _unmatched(profiles: Sequence[ShockProfile]) -> tuple[Unmatched, ...]:
    """Bodies, points and joints that not all designs have. The heaviest bodies are partners whatever their names."""
    trunks, unmatched = _trunks(profiles), []
    for kind in KINDS:
        names = [[place.name for place in profile.places(kind)] for profile in profiles]
        for name in dict.fromkeys(itertools.chain(*names)):
            having = tuple(k for k, own in enumerate(names) if name in own)
            if len(having) < len(profiles) and not (kind == "body" and name in trunks):
                unmatched.append(Unmatched(kind, name, having))
    return tuple(unmatched)
