"""The suite: every case is data, a function that builds it, a name and what makes it hard. Tests and bench use the same ones."""

from collections.abc import Iterator

from shockpc.bench.cases.chains import KNEE, LINKS, MASS_RATIO
from shockpc.bench.cases.contacts import CORNERS, DOUBLED, LOCKED_FEET, RESTITUTION, SPEED, THROUGH_COM
from shockpc.bench.cases.family import Case, Family
from shockpc.bench.cases.inertia import ARMATURE, LIGHT, UNITS
from shockpc.bench.cases.loops import LOOPS
from shockpc.bench.cases.robots import FAR, ROBOTS

__all__ = ["FAMILIES", "Case", "Family", "family", "suite"]

FAMILIES = (
    ROBOTS,
    MASS_RATIO,
    KNEE,
    LINKS,
    ARMATURE,
    LIGHT,
    THROUGH_COM,
    UNITS,
    CORNERS,
    LOCKED_FEET,
    DOUBLED,
    LOOPS,
    RESTITUTION,
    SPEED,
    FAR,
)


def suite(name: str) -> Iterator[Case]:
    """All cases of a suite, "quick" or "full"."""
    for one in FAMILIES:
        yield from one.cases(quick=name == "quick")


def family(name: str) -> Family:
    """The family of that name."""
    return next(one for one in FAMILIES if one.name == name)
