"""The records of a profile: what there is at one place of a kind, by name; their fields are
quantities of that kind.
"""

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, Protocol, TypeVar

import numpy as np

from shockpc.core.most_severe import ExtremeDirections
from shockpc.core.spatial import Array
from shockpc.landing.places import Place, PlaceKind
from shockpc.landing.ratings import Strength, TorqueStrength
from shockpc.quantities.quantity import Quantity
from shockpc.quantities.renamed import renamed_attribute
from shockpc.quantities.selection import quantities_of, quantity
from shockpc.text.diagnostic import Diagnostic
from shockpc.text.printed import few

R = TypeVar("R", bound="NamedTuple")


def _record_of(kind: PlaceKind) -> Callable[[type[R]], type[R]]:
    """A record of one place: its fields are quantities of a kind by key, None without a value,
    whose titles document them.
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
    """How far a part, at a point or of a joint, is from what it withstands.

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
    """What the ground does at a contact; masses that cannot give way are infinite.

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
    """What the ground does at a foot that stands already.

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
    """What a joint goes through.

    Attributes:
        joint: its name.
    """

    joint: str
    force: Array
    moment: Array
    along: float | None
    delta_qd: float | None


class Bracket(NamedTuple):
    """The same landing with other models of the joints; shock at one place [1].

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


class Health(NamedTuple):
    """How far to trust a profile: the arithmetic, for the robot as loaded.

    Attributes:
        rank: number of independent contact and closure rows.
        rows: number of these rows.
        error_bound: proven error of the reported jumps, relative to each body's motion, the largest
            over the bodies [1].
        body_error_bounds: the same for every body.
        double_error: true error of the solution in double precision, the largest over the bodies
            [1]; inf if it has none.
        data_sensitivity: how far the result moves when every datum changes in its last digit, the
            largest over the bodies [1].
        bits: precision of the ball arithmetic.
        warnings: each with its consequence.
    """

    rank: int
    rows: int
    error_bound: float
    body_error_bounds: tuple[float, ...]
    double_error: float
    data_sensitivity: float
    bits: int
    warnings: tuple[Diagnostic, ...]


class Unknown(NamedTuple):
    """Something that a landing takes for granted; `str` gives it in words, with what to give.

    Attributes:
        kind: what it is about: "drives", "inertia", "geometry", "springs", "contact", "posture",
            "base" or "duration".
        status: "unknown" or "simulation model" of drives that nobody knows, "implausible" of
            inertias, and "missing" of geometry; "published", "derived" or "identified" of drives
            that are known, and "chosen" or "assumed" of the rest.
        subjects: names of the joints, links or contacts.
        deciding: those of the joints that decide about the first number of the answer, the ones
            that count most first.
        text: what is not known, or was chosen; of contacts without their names.
        remedy: what to give, or to change.
        effect: largest over smallest value of the first number that what is known allows [1]; 1
            where that is not computed.
    """

    kind: str
    status: str
    subjects: tuple[str, ...]
    deciding: tuple[str, ...]
    text: str
    remedy: str
    effect: float

    def __str__(self) -> str:
        return f"{self.named}; {self.remedy}" if self.remedy else self.named

    @property
    def named(self) -> str:
        """What is not known, or was chosen, without what to give."""
        return f"{few(self.subjects, 4)}: {self.text}" if self.kind == "contact" else self.text

    @property
    def known(self) -> bool:
        """Whether somebody stands for it: a source of the drives, or a rule by which it was chosen."""
        return self.status not in ("unknown", "simulation model", "implausible", "missing")


class Valued(Protocol):
    """What has places, and values of quantities there: a profile."""

    def places(self, kind: PlaceKind) -> tuple[Place, ...]:
        """The places of one kind."""

    def values(self, wanted: Quantity, places: Sequence[Place] | None = None) -> Array:
        """The values of a quantity at some places, by default all of its kind."""


def records(
    record: type[R],
    profile: Valued,
    kind: PlaceKind,
    places: Sequence[Place] | None = None,
    **given: str | Sequence[Any],
) -> tuple[R, ...]:
    """A record for each place: its first field is the place's name, others are given, or quantities
    by their or given keys.
    """
    names = [place.name for place in (profile.places(kind) if places is None else places)]
    columns: dict[str, Any] = (
        {field: field for field in record._fields} | {record._fields[0]: names} | given
    )
    values = {
        field: map(_number, profile.values(quantity(kind, column), places))
        if isinstance(column, str)
        else column
        for field, column in columns.items()
    }
    return tuple(map(record._make, zip(*values.values(), strict=True)))


def _number(value: Any) -> Any:
    """A number or a vector, or None where there is none."""
    if np.isnan(value).all():
        return None
    return value if np.ndim(value) else float(value)
