"""A family of cases: one landing with one parameter that makes it harder."""

import functools
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Literal, NamedTuple, TypeAlias

from shockpc.robot.robot import Robot, load_robot
from shockpc.scene import Scene

__all__ = ["Axis", "Case", "Family", "known_robot"]


Axis: TypeAlias = Literal["x", "y", "z"]
"""A direction in which a contact or a closure holds."""


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
    """Cases that differ in one number.

    Attributes:
        name: short.
        title: one line for a heading.
        hard: why it is hard.
        parameter: the number, with its unit.
        variants: of the landing.
        values: of the parameter.
        build: variant and value → robot and scene.
        labels: names of the values, where they are numbers of a list.
    """

    name: str
    title: str
    hard: str
    parameter: str
    variants: tuple[str, ...]
    values: tuple[float, ...]
    build: Callable[[str, float], tuple[Robot, Scene]] = field(repr=False)
    labels: tuple[str, ...] = ()

    def cases(self) -> Iterator[Case]:
        """Its cases, variant by variant."""
        for variant in self.variants:
            for value in self.values:
                yield self.case(variant, value)

    def case(self, variant: str, value: float) -> Case:
        """One of its cases."""
        label = self.labels[int(value)] if self.labels else f"{value:g}"
        return Case(self.name, variant, label, lambda: self.build(variant, value))


@functools.cache
def known_robot(name: str) -> Robot:
    """A robot by its name, loaded once."""
    return load_robot(name)
