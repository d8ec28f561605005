"""The cases of the benchmark: families of landings with one parameter each."""

from shockpc.bench.cases.chains import KNEE, LINKS, MASS_RATIO, UNITS
from shockpc.bench.cases.family import Case, Family
from shockpc.bench.cases.mechanisms import CORNERS, LIGHT, LOOPS
from shockpc.bench.cases.robots import ARMATURE, DOUBLED, FAR, LOCKED_FEET, ROBOTS

__all__ = ["FAMILIES", "Case", "Family", "family"]

FAMILIES = (ROBOTS, MASS_RATIO, KNEE, LINKS, ARMATURE, LIGHT, UNITS, CORNERS, LOCKED_FEET, DOUBLED, LOOPS, FAR)


def family(name: str) -> Family:
    """The family of that name."""
    return next(one for one in FAMILIES if one.name == name)
