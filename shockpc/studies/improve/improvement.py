"""The result of an improvement, and what is said of its variables and of other drives."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.evaluation.cost import ShockCost
from shockpc.evaluation.drive_ends import MOVED, End
from shockpc.evaluation.table import Table
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.text.display import brief, shown_by
from shockpc.text.errors import ShockError

ALONE = {"deg": 1.0, "m": 0.01}
"""By how much an angle or a length changes over the drives for both ends to be given [its unit]."""


class Flatness(NamedTuple):
    """The effect of a variable at the optimum.

    Attributes:
        name: heading, with its unit.
        before: its value before; NaN if it has none, or not a single one.
        after: its value at the optimum.
        bound: which bound it is held by, "minimum" or "maximum"; None if by none.
        set_back: the target if it alone is set back; NaN if there is no such landing.
        low: smallest value of it alone with which the target is at most 5 % worse.
        high: largest.
    """

    name: str
    before: float
    after: float
    bound: str | None
    set_back: float
    low: float
    high: float


class DriveEnd(NamedTuple):
    """An improvement with other drives.

    Attributes:
        given: the number in the landings as given, of the worst [its unit].
        there: at the optimum of the drives as modelled; NaN where a constraint does not hold there.
        best: at the best point that runs from that optimum and from the landing as given find; NaN
            where there is none.
        x: (n,) the variables at that point.
    """

    given: float
    there: float
    best: float
    x: Array


@dataclass(frozen=True, eq=False)
class Improvement:
    """An optimum.

    Attributes:
        cost: what was improved.
        x: (n,) the variables at the optimum.
        before: proven profiles of the landings as they are given, by name.
        after: those at the optimum.
        values: the number in the worst of the landings as given, and at the optimum, proven [its
            unit].
        worst: name of the landing that is the worst at the optimum.
        active: the constraints that hold it there, and the landings that are as bad as the worst.
        variables: what each does.
        runs: target of each run, the best first, step by step, in double precision; NaN where the
            constraints do not hold.
        agreeing: how many runs end within 1 % of the optimum.
        seed: of the random points.
        chosen: what was asked for where nothing was said: a quantity, and what varies.
        ends: with all drives at the smallest inertias that what is known allows, and at the
            largest, or why there is none; empty where all are known exactly, or vary.
    """

    cost: ShockCost = field(repr=False)
    x: Array
    before: dict[str, ShockProfile] = field(repr=False)
    after: dict[str, ShockProfile] = field(repr=False)
    values: tuple[float, float]
    worst: str
    active: tuple[str, ...]
    variables: tuple[Flatness, ...]
    runs: tuple[Array, ...] = field(repr=False)
    agreeing: int
    seed: int
    chosen: tuple[str, ...]
    ends: Mapping[End, DriveEnd | ShockError] = field(default_factory=dict, repr=False)

    _repr_html_ = shown_by("studies.improve.report:improve_report")

    def __repr__(self) -> str:
        changed = []
        for variable in self.variables[:4]:
            changed.append(f"{variable.name} {variable.before:.4g} → {variable.after:.4g}")
        return brief(self, *changed)

    def moves(self, end: DriveEnd) -> bool:
        """True if the optimum with an end of the drives differs.

        The number there differs by more than 1 %, or a variable by 1 degree, 1 cm or 1 % of its
        range.
        """
        _, optimum = self.values
        for value in (end.there, end.best):
            if not math.isclose(optimum, value, rel_tol=MOVED):
                return True
        most = [
            ALONE.get(varied.unit, MOVED * np.ptp(varied.ends)) for varied in self.cost.variations
        ]
        return bool(np.any(np.abs(end.x - self.x) > most))

    @property
    def table(self) -> Table:
        """A row for each variable."""
        header = (
            "variable",
            "as given",
            "optimum",
            "at bound",
            "target if set back",
            "5 % from",
            "5 % to",
        )
        return Table.of_rows(header, self.variables)
