"""Kinds of gear between a rotor and its joint, and the sense in which the rotor turns."""

from typing import Literal, TypeAlias

Gear: TypeAlias = Literal["planetary", "belt", "harmonic", "spur"]
"""Planetary with a fixed ring, belts, harmonic with a fixed circular spline, and a single stage of
spur gears.
"""

SENSE: dict[Gear, int] = {"planetary": 1, "belt": 1, "harmonic": -1, "spur": -1}
"""1 if the rotor turns with its joint, −1 if it turns against it, seen from the link that carries
the rotor.
"""
