"""The cases of the benchmark: families of landings with one parameter each."""

from shockpc.bench.cases.chains import KNEE, LINKS, MASS_RATIO
from shockpc.bench.cases.contacts import CORNERS, DOUBLED, LOCKED_FEET, THROUGH_COM
from shockpc.bench.cases.family import Case, Family
from shockpc.bench.cases.inertia import ARMATURE, LIGHT, UNITS
from shockpc.bench.cases.loops import LOOPS
from shockpc.bench.cases.robots import FAR, ROBOTS

__all__ = ["FAMILIES", "Case", "Family", "family"]

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
    FAR,
)


def family(name: str) -> Family:
    """The family of that name."""
    return next(one for one in FAMILIES if one.name == name)
