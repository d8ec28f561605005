"""The impact of one landing in an arithmetic: its solution, and all that follows from it."""

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from shockpc.core.spatial import Array
from shockpc.impact.impact import Impact
from shockpc.landing.landing import PosedLanding
from shockpc.method.constraints import Constraint
from shockpc.method.exact.arithmetic import Numbers
from shockpc.method.exact.balls import Balls, BallSolution, to_double
from shockpc.method.exact.solution import ExactSolution


class ExactImpact(Impact):
    """An impact in one posture (N = S = 1) in an arithmetic.

    Args:
        solution: of Eq. 4.
        landing: whose solution it is.

    Attributes:
        solution: of Eq. 4.
    """

    solution: ExactSolution

    def __init__(self, solution: ExactSolution, landing: PosedLanding) -> None:
        self.solution, self.landing = solution, landing
        self.state, self.constraints = solution.state, solution.posed.constraints
        self.unique = solution.row_space.unique[None]

    def exact(self, values: Array) -> Numbers:
        """Doubles as numbers of the arithmetic."""
        return self.solution.exact(values)

    @cached_property
    def delta_qd(self) -> Numbers:
        """As in `Impact`."""
        return self.solution.delta_qd

    @cached_property
    def impulse(self) -> Numbers:
        """As in `Impact`."""
        return self.solution.impulse

    @cached_property
    def independent_impulse(self) -> Numbers:
        """As in `Impact`."""
        return self.solution.independent_impulse

    @cached_property
    def speeds(self) -> Numbers:
        """As in `Impact`."""
        return self.solution.speeds

    @cached_property
    def jumps(self) -> Numbers:
        """As in `Impact`."""
        return self.solution.jumps

    @property
    def masses(self) -> Numbers:
        """As in `Impact`."""
        return self.solution.masses

    @property
    def coms(self) -> Numbers:
        """As in `Impact`."""
        return self.solution.coms

    @property
    def joint_origins(self) -> Numbers:
        """As in `Impact`."""
        return self.solution.joint_origins

    @property
    def spatial_inertias(self) -> Numbers:
        """As in `Impact`."""
        return self.solution.spatial_inertias

    def joint_power(self, joints: Sequence[tuple[int, int]]) -> Numbers:
        """Power (N, S, n) of the wrenches through joints in unit rates, as in `Impact`.

        Where only the drive resists it is −A Δq̇ (a row of Eq. 4), which sums no balls that cancel.

        A rotor that couples to the link that carries it resists with −(A − c) Δq̇ − c a·Δω.
        """
        bodies = [body for body, _ in joints]
        columns = [column for _, column in joints]
        power = self.along(self.delta_qd)[..., columns] * -self.solution.own_inertia[columns]
        axes = np.swapaxes(self.state.J[:, :3, columns], 1, 2)[:, None]
        coupled = np.sum(axes * self.rotor_moments[:, :, bodies], axis=-1)
        constrained = self.solution.constrained[columns]
        return np.asarray(np.where(constrained, super().joint_power(joints), power - coupled))

    def delassus(
        self, constraint: Constraint, fixed: Sequence[Constraint], independent: list[int]
    ) -> Any:
        """As of `ExactSolution`."""
        return self.solution.delassus(constraint, fixed, independent)

    def rigid_mobility(self, constraint: Constraint) -> Any:
        """As of `ExactSolution`."""
        return self.solution.rigid_mobility(constraint)


class BallImpact(ExactImpact):
    """An impact in balls, at the precision of the present context; arguments as of `ExactImpact`.

    Attributes:
        resistances: of the contacts, by number, where they have been computed.
    """

    def __init__(self, solution: BallSolution, landing: PosedLanding) -> None:
        super().__init__(solution, landing)
        self.resistances: dict[int, Any] = {}

    def rounded(self, values: Balls, size: Callable[[Array], Any]) -> Array:
        """The doubles nearest to balls; doubles as they are."""
        values = np.asarray(values)
        if values.dtype == float:
            return values + 0.0
        return to_double(values, size(values.astype(float)))
