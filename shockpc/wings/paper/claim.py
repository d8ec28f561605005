"""Claims of the paper and its figures as records.

A claim has what is said, how it is interpreted, what is computed, and when it holds.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

from shockpc import ShockProfile
from shockpc.wings.paper.panel_landings import land

ROUNDING = 1e-11
"""Bound on rounding errors in lengths and shocks of order 1."""

Compute = Callable[..., float]
Options = dict[str, dict[str, Any]]
"""Other interpretations or conditions by name, each as arguments of a claim's function."""


@dataclass(frozen=True)
class Claim:
    """A claim of the paper. It holds if its value lies strictly between two bounds.

    Attributes:
        statement: section, equation, figure or footnote of the paper, and what it says there.
        quantity: name and unit of the value.
        compute: function that returns the value; without arguments under the interpretation.
        interpretation: how the statement is made computable, including the choice of what the text
            leaves open.
        above, below: bounds of the value.
        options: other interpretations.
    """

    statement: str
    quantity: str
    compute: Compute
    interpretation: str
    above: float = -math.inf
    below: float = math.inf
    options: Options = field(default_factory=dict)

    @cached_property
    def value(self) -> float:
        """The value under the interpretation."""
        return float(self.compute())

    @property
    def holds(self) -> bool:
        """True if the claim holds under its interpretation."""
        return self.above < self.value < self.below

    @cached_property
    def alternatives(self) -> dict[str, float]:
        """Those of the other interpretations that change the outcome, with their values."""
        values = {
            name: float(self.compute(**arguments)) for name, arguments in self.options.items()
        }
        return {
            name: value
            for name, value in values.items()
            if (self.above < value < self.below) != self.holds
        }

    @property
    def criterion(self) -> str:
        """The bounds in words."""
        if math.isinf(self.above):
            return f"below {self.below:.4g}"
        return (
            f"above {self.above:.4g}"
            if math.isinf(self.below)
            else f"between {self.above:.4g} and {self.below:.4g}"
        )


class Panel(NamedTuple):
    """A panel of a figure: the letter or angle under it, its scene file, and its content.

    The name of the scene file is without ".toml".
    """

    label: str
    scene: str
    words: str


@dataclass(frozen=True)
class PaperFigure:
    """A figure of the paper that is drawn from a model.

    Attributes:
        number: in the paper.
        title: short description.
        note: what is assumed or not given in the paper.
        panels: from left to right.
        claims: those that the models of the figure can confirm or refute, in the paper's order.
    """

    number: int
    title: str
    note: str
    panels: tuple[Panel, ...]
    claims: list[Claim] = field(default_factory=list)

    @property
    def profiles(self) -> list[ShockProfile]:
        """The shock profile of every panel."""
        return [land(panel.scene) for panel in self.panels]

    def claim(self, statement: str, quantity: str, **record: Any) -> Callable[[Compute], Compute]:
        """Make a function that computes a value a claim; arguments as in `Claim`."""

        def add(compute: Compute) -> Compute:
            self.claims.append(Claim(statement, quantity, compute, **record))
            return compute

        return add
