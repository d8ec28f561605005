"""Records of a profile, one for each place of a kind; their fields are quantities of that kind."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, TypeVar

import numpy as np

from shockpc.core.most_severe import ExtremeDirections
from shockpc.core.spatial import Array
from shockpc.landing.landing import PosedLanding
from shockpc.landing.places import Place, PlaceKind
from shockpc.landing.ratings import Strength, TorqueStrength, strength, torque_strength
from shockpc.quantities.parts.of_parts import not_judged
from shockpc.quantities.renamed import renamed_attribute
from shockpc.quantities.selection import quantities_of
from shockpc.quantities.values import LandingValues

R = TypeVar("R", bound="NamedTuple")

NO_KEYS: Mapping[str, str] = {}


def _record_of(kind: PlaceKind) -> Callable[[type[R]], type[R]]:
    """Decorator of a record of one place, whose fields are quantities of a kind by key.

    A field is None without a value. The titles of the quantities document the fields.
    """

    def described(record: type[R]) -> type[R]:
        entries = [entry for entry in quantities_of(kind) if entry.key in record._fields]
        record.__doc__ = f"{record.__doc__}" + "".join(
            f"    {entry.key}: {entry.text}.\n    " for entry in entries
        )
        # The type checker does not see former keys, so that it reports them.
        record.__getattr__ = renamed_attribute  # type: ignore[attr-defined]
        return record

    return described


@_record_of("point")
class PointShock(NamedTuple):
    """Shock at a sensor, or at a point that was asked for.

    Attributes:
        frame: its name.
        body: the body it is fixed to.
        directions: the most and the least severe impact direction.
    """

    frame: str
    body: str
    position: Array
    delta_v: Array
    shock: float
    directions: ExtremeDirections
    peak_g: float | None


@_record_of("part")
class PartMargin(NamedTuple):
    """Margin of a part, at a point or of a joint, to what it withstands.

    Attributes:
        part: its name.
        body: the body it is fixed to, or that its joint carries.
        joint: its joint; empty for a part at a point.
        strength: its damage boundary; of a part of a joint the torque.
        governed_by: which margin is that of the part: by "velocity change", "acceleration" or
            "torque"; empty if it has none.
        missing: why it has none; empty if it has one.
    """

    part: str
    body: str
    joint: str
    strength: Strength | TorqueStrength
    delta_v: Array | None
    shock: float | None
    velocity_margin: float | None
    peak_g: float | None
    acceleration_margin: float | None
    along: float | None
    torque: float | None
    part_margin: float | None
    governed_by: str
    missing: str

    @property
    def speed_change(self) -> float:
        """|Δv| [m/s]; NaN for a part of a joint."""
        return math.nan if self.delta_v is None else math.hypot(*self.delta_v)


@_record_of("contact")
class ContactImpulse(NamedTuple):
    """Impulse of the ground at a contact; masses that cannot give way are infinite.

    Attributes:
        frame: its name.
    """

    frame: str
    point: Array
    impulse: Array | None
    moment: Array | None
    friction_needed: float | None
    approach: Array
    effective_mass_sticking: float
    effective_mass_frictionless: float
    effective_mass: float
    mitigation: float | None
    mitigation_frictionless: float | None
    centre_of_pressure: Array | None
    twist_needed: float | None
    tensile_impulse: float | None


@_record_of("contact")
class StanceImpulse(NamedTuple):
    """Impulse of the ground at a foot that stands already.

    Attributes:
        frame: its name.
    """

    frame: str
    point: Array
    impulse: Array | None
    friction_needed: float | None
    tensile_impulse: float | None


@_record_of("joint")
class JointLoad(NamedTuple):
    """Load of a joint.

    Attributes:
        joint: its name.
    """

    joint: str
    force: Array
    moment: Array
    along: float | None
    delta_qd: float | None


class Bracket(NamedTuple):
    """The shock at one place of a landing with other models of the joints [1].

    Attributes:
        place: a body (its centre of mass), or a sensor.
        free: no reflected inertia; None if massless bodies then make it unsolvable.
        as_modelled: as the scene says.
        locked: every joint holds; None if there is no verdict then, because the contact cannot move
            as the impact asks.
        springs_free: every joint holds but those with a spring, which yield; None without springs,
            or if there is no verdict.
    """

    place: str
    free: float | None
    as_modelled: float
    locked: float | None
    springs_free: float | None


def point_shocks(profile: LandingValues) -> tuple[PointShock, ...]:
    """The shock at sensors and points of a landing."""
    bodies = []
    for place in profile.landing.points:
        is_held = place.body < 0
        bodies.append("world" if is_held else profile.robot.bodies[place.body].name)
    extremes = directions_of(profile, "point")
    directions = [ExtremeDirections(*parts) for parts in zip(*extremes, strict=True)]
    return _records(PointShock, profile, "point", {"body": bodies, "directions": directions})


def directions_of(profile: LandingValues, kind: PlaceKind) -> ExtremeDirections:
    """The most and the least severe impact directions at all places of a kind."""
    return ExtremeDirections(
        profile.value("most_severe_direction", kind),
        profile.value("most_severe", kind),
        profile.value("least_severe_direction", kind),
        profile.value("least_severe", kind),
    )


def part_margins(profile: LandingValues) -> tuple[PartMargin, ...]:
    """The margins of the parts of a landing's scene."""
    landing = profile.landing
    joint_names = {place.number: place.name for place in profile.places("joint")}
    margins = profile.value("part_margin", "part")
    by_velocity = profile.value("velocity_margin", "part")
    columns: dict[str, list[Any]] = {
        "body": [profile.robot.bodies[place.body].name for place in landing.parts],
        "joint": [joint_names.get(place.joint, "") for place in landing.parts],
        "strength": [],
        "governed_by": [],
        "missing": [],
    }
    for k, place in enumerate(landing.parts):
        part = landing.scene.part[place.number]
        joint = columns["joint"][k]
        if joint:
            columns["strength"].append(torque_strength(profile.robot, part, joint))
            governed_by = "torque"
        else:
            columns["strength"].append(strength(part))
            governed_by = "velocity change" if margins[k] == by_velocity[k] else "acceleration"
        missing = ""
        if np.isnan(margins[k]):
            governed_by = ""
            missing = not_judged(landing, place, profile.redundant)
        columns["governed_by"].append(governed_by)
        columns["missing"].append(missing)
    return _records(PartMargin, profile, "part", columns)


def contact_impulses(profile: LandingValues) -> tuple[ContactImpulse, ...]:
    """The impulses, friction and effective masses of the contacts of a landing."""
    landing = profile.landing
    every = _records(ContactImpulse, profile, "contact", {"frame": _feet(landing)})
    return every[: len(landing.contacts)]


def stance_impulses(profile: LandingValues) -> tuple[StanceImpulse, ...]:
    """The impulses of the standing feet of a landing."""
    landing = profile.landing
    every = _records(StanceImpulse, profile, "contact", {"frame": _feet(landing)})
    return every[len(landing.contacts) :]


def _feet(landing: PosedLanding) -> list[str]:
    """The frames of contacts and standing feet."""
    return [held.frame for held in (*landing.contacts, *landing.stance)]


def joint_loads(profile: LandingValues) -> tuple[JointLoad, ...]:
    """The loads of the joints between bodies of a landing."""
    return _records(JointLoad, profile, "joint", {})


def brackets(profile: LandingValues, places: Sequence[Place]) -> tuple[Bracket, ...]:
    """The shock at points of a landing with other models of the joints."""
    keys = {
        "free": "shock_free",
        "as_modelled": "shock",
        "locked": "shock_locked",
        "springs_free": "shock_springs_free",
    }
    return _records(Bracket, profile, "point", {}, keys, places)


def _records(
    record: type[R],
    profile: LandingValues,
    kind: PlaceKind,
    columns: Mapping[str, Sequence[Any]],
    keys: Mapping[str, str] = NO_KEYS,
    places: Sequence[Place] | None = None,
) -> tuple[R, ...]:
    """A record for each place of a kind.

    A field without a column is a quantity; the first one without is the name of the place.

    Args:
        record: the type.
        profile: the landing.
        kind: of the places.
        columns: values of fields that are no quantities, by field.
        keys: of the quantity of a field, where it is not the name of the field.
        places: some places; by default all of the kind.
    """
    at = profile.places(kind) if places is None else places
    names = {record._fields[0]: [place.name for place in at]}
    fields = list[Sequence[Any]]()
    for field in record._fields:
        column = {**names, **columns}.get(field)
        if column is None:
            values = profile.value(keys.get(field, field), kind, places)
            column = [_number(value) for value in values]
        fields.append(column)
    return tuple(record._make(row) for row in zip(*fields, strict=True))


def _number(value: Any) -> Any:
    """A number or a vector, or None where there is none."""
    if np.isnan(value).all():
        return None
    return value if np.ndim(value) else float(value)
