"""Designs side by side: what changes from the first one to each of the others, ranked, matched by name."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from shockpc.core.spatial import Array
from shockpc.errors import SceneError, SolveError, StudyError
from shockpc.profile import shock_profile
from shockpc.result import ShockProfile
from shockpc.robot.changes import Change, changed
from shockpc.robot.record import Robot
from shockpc.scene import Scene

__all__ = ["Comparison", "Design", "Difference", "Quantity", "Unmatched", "compare", "design_with"]

FORCE, MOMENT = "impulse", "impulsive moment"
LOADS = ((FORCE, "N s"), (MOMENT, "N m s"))
"""What a joint transmits."""


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


@dataclass(frozen=True)
class Difference:
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


@dataclass(frozen=True)
class Quantity:
    """What is compared.

    Attributes:
        name: such as "shock at the centre of mass".
        of: what has it: "body", "point", "contact" or "joint".
        unit: of its values.
        rows: the largest change first; of radii of percussion that of their reciprocals.
    """

    name: str
    of: str
    unit: str
    rows: tuple[Difference, ...]


@dataclass(frozen=True)
class Unmatched:
    """What some designs lack.

    Attributes:
        kind: "body", "point" or "joint".
        name: its name.
        designs: indices of those that have it.
    """

    kind: str
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
    quantities: tuple[Quantity, ...]
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
        if covered or joints.model == "free":
            why = f'sets that of joint "{covered[0]}"' if covered else "makes all joints free"
            raise StudyError(f"change {change} has no effect, because the scene {why}; leave one of the two out")
    label = "; ".join([design.label, *map(str, changes)])
    return Design(label, design.scene, changed(design.robot, changes), (*design.changes, *changes))


def compare(designs: Iterable[Design]) -> Comparison:
    """Compute the landings of some designs, and what differs.

    Raises:
        ShockError: there are fewer than two designs, or one of them cannot be computed.
    """
    every = tuple(designs)
    if len(every) < 2:
        raise StudyError("one design cannot be compared; give another one, or a change of it with --change")
    profiles = tuple(map(_profile, every))
    quantities = (
        _quantity("shock at the centre of mass", "body", "-", _by_body(profiles, lambda one: one.shock_com)),
        _quantity("greatest shock over the body", "body", "-", _by_body(profiles, lambda one: one.shock_max)),
        _quantity("shock at sensors and points", "point", "-", [_points(one) for one in profiles]),
        _quantity("radius of percussion", "body", "m", _by_body(profiles, lambda one: one.ropc), _reciprocal),
        _quantity("effective mass of the contact", "contact", "kg", _effective_masses(profiles)),
        *(_quantity(f"{what} through the joint", "joint", unit, [_loads(one, what) for one in profiles]) for what, unit in LOADS),
    )
    return Comparison(every, profiles, tuple(one for one in quantities if one.rows), _unmatched(profiles))


def _profile(design: Design) -> ShockProfile:
    """The profile of a design; a refusal names it."""
    try:
        return shock_profile(design.scene, design.robot)
    except (SceneError, SolveError) as refusal:
        raise type(refusal)(f"{design.label}: {refusal}") from None


def _quantity(
    name: str, of: str, unit: str, found: Sequence[Mapping[str, float]], scale: Callable[[float], float] = float
) -> Quantity:
    """The numbers of what all designs have, by the size of the largest change.

    Args:
        name: of the quantity.
        of: what has it.
        unit: of the numbers.
        found: the numbers of each design by place; NaN where it has none.
        scale: of what the change is ranked by.
    """
    rows = []
    for place in found[0]:
        if all(place in numbers for numbers in found):
            values = tuple(None if math.isnan(numbers[place]) else numbers[place] for numbers in found)
            if any(value is not None for value in values):
                rows.append(Difference(place, values))

    def size(row: Difference) -> float:
        first, *others = (None if value is None else scale(value) for value in row.values)
        return max((abs(value - first) for value in others if value is not None and first is not None), default=-1.0)

    return Quantity(name, of, unit, tuple(sorted(rows, key=size, reverse=True)))


def _reciprocal(radius: float) -> float:
    """Shock per metre, which is finite for an infinite radius of percussion."""
    return 1.0 / radius


def _trunks(profiles: Sequence[ShockProfile]) -> list[str]:
    """The heaviest body of each design: the bodies that are partners whatever their names."""
    return [profile.bodies[int(np.argmax(profile.robot.masses))] for profile in profiles]


def _by_body(profiles: Sequence[ShockProfile], read: Callable[[ShockProfile], Array]) -> list[dict[str, float]]:
    """Numbers (nb,) of each design by the body's name; those of the heaviest bodies also under all their names together."""
    trunks = _trunks(profiles)
    found = [dict(zip(profile.bodies, map(float, read(profile)), strict=True)) for profile in profiles]
    return [numbers | {_paired(trunks): numbers[trunk]} for numbers, trunk in zip(found, trunks, strict=True)]


def _paired(names: Iterable[str]) -> str:
    """The names of partners as one."""
    return " / ".join(dict.fromkeys(names))


def _points(profile: ShockProfile) -> dict[str, float]:
    """Shock by the name of the sensor or point."""
    return {point.frame: point.shock for point in profile.points}


def _effective_masses(profiles: Sequence[ShockProfile]) -> list[dict[str, float]]:
    """Effective masses of the contacts, which are paired in their order where all designs have as many of them."""
    if len({len(profile.contacts) for profile in profiles}) > 1:
        return [{}]
    pairs = zip(*(profile.contacts for profile in profiles), strict=True)
    names = [_paired(contact.frame for contact in pair) for pair in pairs]
    return [
        {
            f"{name}, {how}": mass
            for name, contact in zip(names, profile.contacts, strict=True)
            for how, mass in (("sticking", contact.mass_sticking), ("frictionless", contact.mass_frictionless))
        }
        for profile in profiles
    ]


def _loads(profile: ShockProfile, what: str) -> dict[str, float]:
    """Magnitude of the force impulse or of the moment impulse by joint."""
    return {load.joint: math.hypot(*(load.force if what == FORCE else load.moment)) for load in profile.loads}


def _unmatched(profiles: Sequence[ShockProfile]) -> tuple[Unmatched, ...]:
    """Bodies, points and joints that not all designs have. The heaviest bodies are partners whatever their names."""
    trunks = _trunks(profiles)
    found = []
    for kind, names in (
        ("body", [profile.bodies for profile in profiles]),
        ("point", [tuple(_points(profile)) for profile in profiles]),
        ("joint", [profile.robot.joint_names for profile in profiles]),
    ):
        for name in dict.fromkeys(name for own in names for name in own):
            having = tuple(k for k, own in enumerate(names) if name in own)
            if len(having) < len(profiles) and not (kind == "body" and name in trunks):
                found.append(Unmatched(kind, name, having))
    return tuple(found)
