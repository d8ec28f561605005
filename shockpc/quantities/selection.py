"""The table of all quantities, and their names in texts: KEY, KIND.KEY, and KEY.x of a vector."""

import functools
import itertools
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from shockpc.core.percussion import norm
from shockpc.landing.places import PlaceKind
from shockpc.quantities.of_bodies import BODIES
from shockpc.quantities.of_contacts import CONTACTS
from shockpc.quantities.of_joints import JOINTS
from shockpc.quantities.of_points import POINTS
from shockpc.quantities.of_robot import ROBOT
from shockpc.quantities.parts.of_parts import PARTS
from shockpc.quantities.parts.ranges import RANGES
from shockpc.quantities.quantity import Quantity
from shockpc.quantities.renamed import current_name
from shockpc.quantities.with_friction import WITH_FRICTION
from shockpc.text.arguments import checked
from shockpc.text.errors import UnknownName
from shockpc.text.wings import from_wings

QUANTITIES: tuple[Quantity, ...] = (
    *POINTS,
    *BODIES,
    *JOINTS,
    *CONTACTS,
    *ROBOT,
    *WITH_FRICTION,
    *itertools.chain.from_iterable(from_wings("quantities", "QUANTITIES")),
    *RANGES,
    *PARTS,
)
"""All quantities. Of those that share a key the first is meant unless the kind is named."""

WITHOUT_SYMBOLS = frozenset(
    {
        "energy_gained",
        "depth_below_contacts",
        "feasible",
        "feasible_if_tilted",
        "out_of_plane_share",
        "shock_min",
        "shock_max",
        "delta_v_max",
        "energy_share",
        "joint_torque_share",
        "most_severe",
        "most_severe_direction",
        "least_severe",
        "least_severe_direction",
        "friction_needed",
        "tensile_impulse",
        "centre_of_pressure",
        "twist_needed",
        "translates",
    }
)
"""Quantities whose formulas compare numbers or search, so that they have no symbols."""


def has_symbolic_form(quantity: Quantity) -> bool:
    """True if the numbers of a quantity can be written in symbols, for any posture."""
    computed = quantity.computation.postures == "many" and not quantity.relations.role
    return computed and quantity.of != "part" and quantity.key not in WITHOUT_SYMBOLS


_BY_KEY = {(quantity.of, quantity.key): quantity for quantity in QUANTITIES}


class Selection(NamedTuple):
    """A quantity, or a component of one, as a number: of a vector the length is taken.

    Attributes:
        name: as a text names it.
        quantity: the quantity.
        axis: 0, 1 or 2 of a component; None for the number, or the length.
    """

    name: str
    quantity: Quantity
    axis: int | None = None

    def __reduce__(self) -> tuple[Any, ...]:
        return select, (self.name,)

    def scalar(self, values: Any) -> Any:
        """Values (...) of the selection, doubles or balls.

        Args: values (...) or (..., 3) of the quantity.
        """
        if not self.quantity.vector:
            return values
        return np.asarray(norm(values) if self.axis is None else values[..., self.axis])

    def worse(self, values: Any) -> Any:
        """Severities (n,) of values (n,): greater is worse; −∞ where there is none.

        Of signed ones the magnitudes count.

        Of a quantity that is not worse in either direction the largest value counts as the worst.
        """
        sizes = np.abs(values) if self.signed else values
        return np.nan_to_num(
            -sizes if self.quantity.worse == "less" else sizes, nan=-np.inf, posinf=np.inf
        )

    @property
    def signed(self) -> bool:
        """True if the number may be negative."""
        return self.quantity.signed or self.axis is not None


def quantities_of(kind: PlaceKind) -> tuple[Quantity, ...]:
    """The quantities of one kind of place, in the order of the table."""
    return tuple(quantity for quantity in QUANTITIES if quantity.of == kind)


def quantity(kind: PlaceKind, key: str) -> Quantity:
    """The quantity of a kind of place with a key.

    Raises:
        UnknownName: there is none.
    """
    if (kind, key) not in _BY_KEY:
        key = current_name(key)
    if (kind, key) not in _BY_KEY:
        known = [f"{of}.{name}" for of, name in _BY_KEY]
        raise UnknownName(
            "quantity", f"{kind}.{key}", known, "the table of quantities", "shockpc quantities"
        )
    return _BY_KEY[kind, key]


@checked
def select(text: str) -> Selection:
    """The selection that a text means: KEY, or KIND.KEY where several kinds have it.

    A component of a vector has .x, .y or .z after it.

    Raises:
        UnknownName: there is none; the text names the nearest, and the command that lists all.
    """
    names = selections()
    if text not in names:
        text = current_name(text)
    if text not in names:
        raise UnknownName("quantity", text, names, "the table of quantities", "shockpc quantities")
    return names[text]


@functools.cache
def selections() -> Mapping[str, Selection]:
    """All selections of the quantities, by the texts that mean them."""
    names: dict[str, Selection] = {}
    for entry in QUANTITIES:
        parts = [("", None), *((f".{axis}", k) for k, axis in enumerate("xyz") if entry.vector)]
        for suffix, axis in parts:
            for name in (f"{entry.key}{suffix}", f"{entry.of}.{entry.key}{suffix}"):
                names.setdefault(name, Selection(name, entry, axis))
    return names
