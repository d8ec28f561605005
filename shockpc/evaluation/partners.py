"""Partners of two designs: bodies, joints, points and parts of equal names, or of given pairs."""

from collections.abc import Iterable, Mapping, Sequence
from typing import TypeAlias

from shockpc.landing.places import PlaceKind
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.text.names import matches

KINDS: tuple[PlaceKind, ...] = ("body", "point", "joint", "part")
"""Places that have partners; contacts are partners in their order."""

Partners: TypeAlias = Mapping[PlaceKind, Mapping[str, str]]
"""By kind and by name in the first design: the name in the other."""


def partners(
    first: ShockProfile, other: ShockProfile, pairs: Sequence[tuple[str, str]] = ()
) -> Partners:
    """The partners of two designs, each of one.

    First the given pairs, then equal names.

    Args:
        first: one design.
        other: the other design.
        pairs: names of the first with those of the other; of a name with * both have the same in
            that part.
    """
    by_kind: dict[PlaceKind, dict[str, str]] = {kind: {} for kind in KINDS}
    for name_in_first, name_in_other in pairs:
        for kind, matched in matching(first, other, name_in_first, name_in_other).items():
            _add(by_kind[kind], matched.items())
    for kind in KINDS:
        names = {place.name for place in other.places(kind)}
        equal = [place.name for place in first.places(kind) if place.name in names]
        _add(by_kind[kind], zip(equal, equal, strict=True))
    return by_kind


def _add(partners: dict[str, str], pairs: Iterable[Iterable[str]]) -> None:
    """Add pairs of which neither has a partner yet."""
    for a, b in pairs:
        if a not in partners and b not in partners.values():
            partners[a] = b


def matching(
    first: ShockProfile, other: ShockProfile, name_in_first: str, name_in_other: str
) -> dict[PlaceKind, dict[str, str]]:
    """The partners that the names of a pair mean, by kind.

    There are none where one of the designs has no such names.
    """
    start, star, end = name_in_first.partition("*")
    by_kind: dict[PlaceKind, dict[str, str]] = {kind: {} for kind in KINDS}
    for kind in KINDS:
        names = {place.name for place in other.places(kind)}
        for name in matches(name_in_first, (place.name for place in first.places(kind))):
            partner = name_in_other
            if star:
                partner = name_in_other.replace("*", name[len(start) : len(name) - len(end)])
            if partner in names:
                by_kind[kind][name] = partner
    return by_kind
