"""Properties of a profile that are quantities: by the name of the property, at all places."""

from collections.abc import Callable
from functools import cached_property
from typing import Any, TypeVar

import numpy as np

from shockpc.core.spatial import Array, freeze
from shockpc.landing.places import PlaceKind
from shockpc.quantities.selection import quantity
from shockpc.quantities.values import LandingValues

T = TypeVar("T")


class OfQuantity(cached_property[T]):
    """A property with the values of the quantity that has its name, at all places of a kind.

    Args:
        kind: of the places.
        convert: from the values at these places to what the property gives.
    """

    def __init__(self, kind: PlaceKind, convert: Callable[[Array], T]) -> None:
        def read(profile: LandingValues) -> T:
            value = convert(profile.value(str(self.attrname), kind))
            freeze(value)
            return value

        super().__init__(read)
        self.kind = kind

    def __set_name__(self, owner: type[Any], name: str) -> None:
        super().__set_name__(owner, name)
        every = "the" if self.kind == "robot" else "each"
        self.__doc__ = f"{quantity(self.kind, name).text} (of {every} {self.kind})."


def each_value(values: Array) -> Array:
    """Values at several places, as they are."""
    return values


def each_flag(values: Array) -> np.ndarray:
    """Values 1 and 0 at several places, as booleans."""
    return np.asarray(values > 0.0)


def only_vector(values: Array) -> Array:
    """The vector (3,) of the only place."""
    return np.asarray(values[0])


def only_number(values: Array) -> float:
    """The number of the only place."""
    return float(values[0])


def only_number_or_none(values: Array) -> float | None:
    """The number of the only place; None where it has none."""
    return None if np.isnan(values[0]) else float(values[0])
