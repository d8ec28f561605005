"""A family of cases: one landing with one parameter, turned until it hurts."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from shockpc.robot.robot import Robot
from shockpc.scene import Scene

__all__ = ["Case", "Family"]


@dataclass(frozen=True)
class Case:
    """One landing of a family.

    Attributes:
        family: name of the family.
        variant: which of its curves.
        value: of the parameter.
        label: the value as it is shown.
        build: makes the robot and the scene.
    """

    family: str
    variant: str
    value: float
    label: str
    build: Callable[[], tuple[Robot, Scene]] = field(repr=False)

    @property
    def name(self) -> str:
        """A name that no other case has."""
        return f"{self.family} / {self.variant} / {self.label}"


@dataclass(frozen=True)
class Family:
    """Cases that differ in one number.

    Attributes:
        name: short, for files and anchors.
        title: one line for a heading.
        hard: what makes it hard.
        parameter: what the number is, with its unit.
        variants: names of its curves.
        values: of the parameter, in the full suite.
        quick: of the parameter, in the quick suite.
        build: variant and value → robot and scene.
        labels: what to call the values, where they are but numbers of a list.
    """

    name: str
    title: str
    hard: str
    parameter: str
    variants: tuple[str, ...]
    values: tuple[float, ...]
    quick: tuple[float, ...]
    build: Callable[[str, float], tuple[Robot, Scene]] = field(repr=False)
    labels: tuple[str, ...] = ()

    def cases(self, quick: bool = False) -> Iterator[Case]:
        """Its cases, variant by variant."""
        for variant in self.variants:
            for value in self.quick if quick else self.values:
                yield self.case(variant, value)

    def case(self, variant: str, value: float) -> Case:
        """One of its cases."""
        label = self.labels[int(value)] if self.labels else f"{value:g}"
        return Case(self.name, variant, value, label, lambda: self.build(variant, value))
