"""An impact in symbols, for any posture.

A formula that needs the value of a symbol, to compare it or to round it, cannot be written in
symbols: `NoValueError`.
"""

from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import cached_property, reduce
from typing import Any, Self

import casadi
import numpy as np

from shockpc.core.impulse import RowSpace
from shockpc.core.percussion import norm
from shockpc.core.spatial import Array, cross
from shockpc.impact.exact_impact import ExactImpact
from shockpc.impact.impact import Impact
from shockpc.landing.landing import PosedLanding
from shockpc.method.approach import Motion
from shockpc.method.constraints import row_terms
from shockpc.method.exact.arithmetic import NoValueError, Numbers, entries
from shockpc.method.exact.solution import ExactSolution
from shockpc.wings.symbols.casadi_functions import compiled_program
from shockpc.wings.symbols.expressions import SYMBOLS, Symbol, SymbolMatrix, densified, symbols_of
from shockpc.wings.symbols.programs import Program


class SymbolSolution(ExactSolution):
    """Eq. 4 and the jumps in symbols, with the configuration in symbols.

    The arguments are those of `ExactSolution`.
    """

    arithmetic = SYMBOLS

    def set_motion(self, motion: Numbers) -> None:
        """Set the motion before the impact.

        Args: motion, symbols: the velocity of the base (3,), world axes, the rest as it is; or all
            joint velocities (nv,).
        """
        robot = self.posed.system.robot
        if len(motion) == 3:
            assert self.before is not None
            self.before = self.before._replace(velocity=motion)
        elif robot.free_base:
            turn = entries(self._placements[0][0])
            rates = np.concatenate([np.zeros(6), motion[6:]])
            self.before = Motion(turn @ motion[:3], turn @ motion[3:6], rates)
        else:
            self.before = Motion(np.zeros(3), np.zeros(3), motion)

    @cached_property
    def pivot(self) -> Symbol:
        """The smallest pivot of the Delassus matrix, scaled to a unit diagonal.

        It is 1 for orthogonal rows, 0 for dependent ones.
        """
        S = entries(self._by_rows[1])
        diagonal, pivots = np.diagonal(S).copy(), []
        for k in range(len(S)):
            pivots.append(S[k, k] / diagonal[k])
            S[k + 1 :, k + 1 :] = S[k + 1 :, k + 1 :] - S[k + 1 :, k, None] * (
                S[k, k + 1 :] / S[k, k]
            )
        return _least(pivots)

    @cached_property
    def condition(self) -> Symbol:
        """The factor by which rounding is enlarged in double precision [1].

        It is estimated as for `ShockMaps.condition`.

        It is that of the landing's strike alone, and a free base counts along the plane's axes, so
        it is not the same to the digit.
        """
        size, jump = self._sizes, entries(self._solution[0])[:, 3]
        light = _length(jump * size) / (_greatest(map(abs, jump)) * _least(size))
        condition: Symbol = _length(self._stiff * size) / self.pivot * light.max(1.0)
        return condition if self.posed.system.base == "free" else condition * self._cancellation

    @cached_property
    def _responses(self) -> tuple[SymbolMatrix, Numbers]:
        """The first result of `_by_rows`, and the response (ny,) of an estimate.

        The norm of the inertia's inverse is estimated by it.
        """
        # In Pinocchio's order of the free velocities, whose last is the first here.
        signs = np.where(np.arange(len(self._sizes))[::-1] * 2654435761 % 7 < 4, 1.0, -1.0)
        J = self._rows[self.row_space.rows.tolist()]
        X = entries(
            self._by_inertia(self.arithmetic.matrix(np.column_stack([J.T, self._sizes * signs])))
        )
        return self.arithmetic.matrix(X[:, :-1]), X[:, -1]

    @cached_property
    def _by_rows(self) -> tuple[SymbolMatrix, SymbolMatrix]:
        """The matrices of `ExactSolution._by_rows`, in symbols."""
        X = self._responses[0]
        return X, self.arithmetic.symmetric(
            self.arithmetic.matrix(self._rows[self.row_space.rows.tolist()]) * X
        )

    @cached_property
    def _stiff(self) -> Numbers:
        return self._responses[1]

    @cached_property
    def _sizes(self) -> Numbers:
        """The square roots (ny,) of the inertias of the free velocities."""
        if self._mimics:
            return _roots(np.diagonal(entries(self._free_inertia)))
        # The diagonal of the joint-space inertia, by composite bodies, from the tips to the base.
        # With the column (ω, v) of a joint's motion at the base's origin, and the mass m, first
        # moment h and inertia I about it of all that the joint carries:
        # H_kk = armature + ωᵀ I ω + 2 ωᵀ (h × v) + m vᵀ v
        robot = self.posed.system.robot
        composite = self._moments_about_base()
        diagonal = self.own_inertia.copy()
        for i in range(len(composite) - 1, -1, -1):
            mass, h, inertia = composite[i]
            for k in range(robot.joints[i].v.start, robot.joints[i].v.stop):
                omega, v = self.state.J[0, :3, k], self.state.J[0, 3:, k]
                rotation = omega @ inertia @ omega
                coupling = 2 * (omega @ cross(h, v))
                diagonal[k] = diagonal[k] + rotation + coupling + (v @ v) * mass
            parent = robot.parents[i]
            if parent >= 0:
                pairs = zip(composite[parent], composite[i], strict=True)
                composite[parent] = [a + b for a, b in pairs]
        return _roots(diagonal[self._free])

    def _moments_about_base(self) -> list[list[Any]]:
        """Mass, first moment (3,) and inertia (3, 3) of each body about the base's origin."""
        moments_about_base: list[list[Any]] = []
        eye = self.exact(np.eye(3))
        for mass, (_, p), moments in zip(
            self._data.mass.tolist(), self._placements, self._moments, strict=True
        ):
            spatial, r = entries(moments), np.array(p.entries(), dtype=object)
            # The skew-symmetric part of the spatial inertia is that of h.
            h = np.array([spatial[2, 4], spatial[0, 5], spatial[1, 3]], dtype=object)
            # Steiner, r from the base's origin: h + m r, and
            # I + (m rᵀr + 2 rᵀh) 1 − m r rᵀ − r hᵀ − h rᵀ
            spherical = eye * (mass * (r @ r) + 2 * (r @ h))
            apart = spherical - np.outer(r, r) * mass - np.outer(r, h) - np.outer(h, r)
            inertia = spatial[:3, :3] + apart
            moments_about_base.append([self.arithmetic.number(mass), h + r * mass, inertia])
        return moments_about_base

    @cached_property
    def _cancellation(self) -> Symbol:
        """By how much terms cancel in the entries of the rows, as `Equation.cancellation` [1]."""
        terms = row_terms(self.state, self.posed.constraints)[0]
        for follower, leaders in reversed(self._mimics):
            for leader, by in leaders:
                terms[:, leader] = terms[:, leader] + terms[:, follower] * abs(by)
        return _greatest(norm(terms[:, self._free] / self._sizes) / norm(self._rows / self._sizes))


class SymbolImpact(ExactImpact):
    """An impact in symbols: posture and motion of its landing are symbols too."""

    solution: SymbolSolution
    has_values = False

    @classmethod
    def of(cls, landing: PosedLanding, q: casadi.SX, before: casadi.SX) -> Self:
        """The impact of a landing in whatever posture and motion.

        Args:
            landing: the landing; its posture is not used, and its motion not where the symbols say
                it.
            q: (nq,) symbols of the configuration.
            before: those of what is before the impact: the strike (3,), or all joint velocities
                (nv,).

        Raises:
            SingularError: no inertia resists a motion, or the rows depend on one another, in any
                posture.
        """
        rows = RowSpace.every(sum(constraint.size for constraint in landing.constraints))
        solution = SymbolSolution(landing.posed._replace(q=symbols_of(q)), rows)
        solution.set_motion(symbols_of(before))
        moving = replace(landing, q=solution.posed.q, before=solution.before or landing.before)
        return cls(solution, moving)

    @property
    def pivot(self) -> Symbol:
        """The value of `SymbolSolution`."""
        return self.solution.pivot

    @property
    def condition(self) -> Symbol:
        """The value of `SymbolSolution`."""
        return self.solution.condition

    def rounded(self, values: Numbers, size: Callable[[Array], Any]) -> Array:
        """Symbols have no values to be rounded.

        Raises:
            NoValueError: always.
        """
        raise NoValueError


def _roots(values: Numbers) -> Numbers:
    return np.array([value.sqrt() for value in values], dtype=object)


def _length(values: Numbers) -> Any:
    return norm(values).item()


def _greatest(values: Iterable[Symbol]) -> Symbol:
    return reduce(Symbol.max, values)


def _least(values: Iterable[Symbol]) -> Symbol:
    return -_greatest(-value for value in values)


def traced(
    landing: PosedLanding, size: int, formulas: Callable[[Impact], list[Any]]
) -> tuple[casadi.SX, casadi.SX, casadi.SX]:
    """Symbols of the configuration (nq,) and of the motion before (size,), and the results (m,).

    The results are those of the formulas.

    Raises:
        SingularError, NoValueError: as for `SymbolImpact`; a formula compares or rounds numbers.
    """
    q, before = casadi.SX.sym("q", landing.robot.model.nq), casadi.SX.sym("before", size)
    return q, before, densified(formulas(SymbolImpact.of(landing, q, before)))


def program(n: int, formulas: Callable[[Numbers], Iterable[Any]]) -> Program:
    """The steps that arrays of formulas take of n numbers. Raises: as `traced`."""
    x = casadi.SX.sym("x", n)
    return compiled_program([x], densified(formulas(symbols_of(x))))[0]
