"""A family of cases: one landing with one parameter that makes it harder."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

from shockpc.model.contact import Contact
from shockpc.robot.robot import Robot
from shockpc.scene import Scene, Strike

__all__ = ["OBLIQUE", "SLANTED", "Case", "Family", "on"]

OBLIQUE = Strike(velocity=(0.4, 0.1, -0.9))
SLANTED = Strike(speed=1.0, strike_angle_deg=20.0)


def on(*frames: str) -> tuple[Contact, ...]:
    """Sticking contacts at the origins of frames."""
    return tuple(Contact(frame=frame) for frame in frames)


class Case(NamedTuple):
    """One landing of a family.

    Attributes:
        family: name of the family.
        variant: of the landing.
        label: value of the parameter.
        build: returns the robot and the scene.
    """

    family: str
    variant: str
    label: str
    build: Callable[[], tuple[Robot, Scene]]

    @property
    def name(self) -> str:
        """A name that no other case has."""
        return f"{self.family} / {self.variant} / {self.label}"


@dataclass(frozen=True)
class Family:
    """Cases that differ in one parameter.

    Attributes:
        name: short.
        about: what lands, and why it is hard.
        parameter: what its cases differ in, with its unit.
        variants: of the landing.
        values: of the parameter: numbers, or names of robots.
        build: variant and value → robot and scene.
    """

    name: str
    about: str
    parameter: str
    variants: tuple[str, ...]
    values: tuple[float, ...] | tuple[str, ...]
    build: Callable[[str, Any], tuple[Robot, Scene]]

    def cases(self) -> Iterator[Case]:
        """Its cases, variant by variant."""
        for variant in self.variants:
            for value in self.values:
                yield self.case(variant, value)

    def case(self, variant: str, value: float | str) -> Case:
        """One of its cases."""
        label = value if isinstance(value, str) else f"{value:g}"
        return Case(self.name, variant, label, lambda: self.build(variant, value))
