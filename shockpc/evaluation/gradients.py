"""Derivatives by posture and strike: of quantities linear in the jumps, of lengths and heights."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from shockpc.core.impulse import Solution
from shockpc.core.spatial import Array, cross_matrix, in_body_axes
from shockpc.core.threads import one_thread
from shockpc.evaluation.column import Column
from shockpc.impact.derivatives import derivatives
from shockpc.impact.impact import ColumnImpact, DoubleImpact
from shockpc.impact.landed import solved
from shockpc.landing.landing import PosedLanding
from shockpc.method.constraints import Constraint
from shockpc.method.dynamics import Dynamics, dynamics
from shockpc.method.equation import Equation
from shockpc.profile import needs_proof
from shockpc.quantities.ground.heights import (
    CLEARANCE,
    HEIGHTS,
    REACH,
    SPREAD,
    height_rates,
    reach_rates,
)
from shockpc.quantities.ground.support import OVERHANG, overhang_rates
from shockpc.quantities.quantity import quantity_values

OF_POSTURE = (*HEIGHTS, OVERHANG)
"""Quantities that do not depend on the strike."""


def has_gradient(landing: PosedLanding, column: Column) -> bool:
    """True if `slopes` gives the derivatives of a number; those of others are differences.

    So are those of all numbers with end stops, or with a contact at a lowest point: a difference
    also shows where a joint leaves a stop, or another point is the lowest.
    """
    entry = column.selection.quantity
    if landing.scene.stops:
        return False
    if any(contact.lowest or contact.kind == "stop" for contact in landing.contacts):
        return False
    if entry in OF_POSTURE:
        return True
    relations = entry.relations
    return landing.translates and (relations.linear or relations.length_of is not None)


class Motions(NamedTuple):
    """Changes of N postures and of S strikes of each, along d directions.

    Attributes:
        along: (N, nv, d) rates at which the postures change, tangent of q.
        twists: (N, nb, 6, d) of the bodies, world axes, about the base.
        strikes: (N, S, 3) velocities of the robot before the impact, world axes [m/s].
        turns: (N, d, S, 3) rates at which the strikes change, at constant speed.
    """

    along: Array
    twists: Array
    strikes: Array
    turns: Array

    def of_columns(self, derivatives: Array) -> Array:
        """The derivatives (N, ..., 3 d) along the ways, of columns by unit strikes.

        Args: derivatives (N, ..., 3, nv), by the velocities of the joints.
        """
        n, nv, d = self.along.shape
        flat = derivatives.reshape(n, -1, nv) @ self.along
        return flat.reshape(*derivatives.shape[:-2], 3 * d)


def slopes(
    landing: PosedLanding,
    Q: Array,
    strikes: Array,
    rates: Array,
    turns: Array,
    wanted: Sequence[Column],
    max_condition: float | None = None,
) -> tuple[dict[str, tuple[Array, Array]], np.ndarray]:
    """Some numbers in N postures, with their derivatives along d directions.

    Along a direction posture and strike change together.

    Args:
        landing: the landing, before which nothing but the robot as a whole moves.
        Q: (N, nq) the postures.
        strikes: (N, S, 3) velocities of the robot before the impact, world axes [m/s].
        rates: (N, d, nv) at which the postures change, tangent of q.
        turns: (N, d, S, 3) rates at which the strikes change, at constant speed.
        wanted: the numbers, each with `has_gradient`.
        max_condition: as for `needs_proof`.

    Returns: by name the values (N, S) and the derivatives (N, S, d), NaN where there are none,
        because the posture is singular, and zero of a length that is zero; and whether (N,) double
        precision is not enough for a posture.
    """
    robot = landing.robot
    with one_thread(3 * robot.model.nv):
        state = dynamics(robot, Q, landing.joint_model)
        along = np.swapaxes(rates, 1, 2)
        # A body moves with its joint and those that carry it.
        jacobians = state.J[:, None] * robot.ancestors[:, None]
        motions = Motions(along, jacobians @ along[:, None], strikes, turns)

        of_impact = [column for column in wanted if column.selection.quantity not in OF_POSTURE]
        bodies = list(dict.fromkeys(max(column.place.body, 0) for column in of_impact)) or [0]
        equation, solution, jumps = solved(landing, state, with_strike=False, bodies=bodies)
        _, unclear = needs_proof(landing, equation, solution, max_condition)
        numbers = _of_posture(landing, state, equation.constraints, motions.twists, wanted)
        impact = _ImpactSlopes(landing, equation, solution, jumps, bodies, motions)
        for column in of_impact:
            numbers[column.name] = impact.slope(column)
    return numbers, unclear


def _of_posture(
    landing: PosedLanding,
    state: Dynamics,
    constraints: Sequence[Constraint],
    twists: Array,
    wanted: Sequence[Column],
) -> dict[str, tuple[Array, Array]]:
    """Values (N, 1) and derivatives (N, 1, d) of numbers that do not depend on the strike."""
    numbers: dict[str, tuple[Array, Array]] = {}
    reaches = [column for column in wanted if column.selection.quantity is REACH]
    if reaches:
        places = [column.place for column in reaches]
        values, rates = reach_rates(landing, state, constraints, twists, places)
        for k, column in enumerate(reaches):
            numbers[column.name] = values[:, None, k], rates[:, None, k]

    heights = [column for column in wanted if column.selection.quantity in (SPREAD, CLEARANCE)]
    if heights:
        places = [column.place for column in heights]
        values, rates = height_rates(landing, state, constraints, twists, places)
        for k, column in enumerate(heights):
            # The spread is the first number, before the clearances.
            number = k + 1 if column.selection.quantity is CLEARANCE else 0
            numbers[column.name] = values[:, None, number], rates[:, None, number]

    for column in wanted:
        if column.selection.quantity is OVERHANG:
            values, rates = overhang_rates(landing, state, twists)
            numbers[column.name] = values[:, None], rates[:, None]
    return numbers


class _ImpactSlopes:
    """Numbers y of an impact that are linear in the strike v, or lengths of such.

    y = v A, where the rows of A are y for unit strikes along x, y and z, so that dy = v dA + dv A.

    Args:
        landing: the landing.
        equation: Eq. 4 in N postures.
        solution: of it, for unit strikes.
        jumps: (N, n, 6, 3) of bodies, world axes.
        bodies: which these are.
        motions: how postures and strikes change.
    """

    def __init__(
        self,
        landing: PosedLanding,
        equation: Equation,
        solution: Solution,
        jumps: Array,
        bodies: list[int],
        motions: Motions,
    ) -> None:
        self.motions = motions
        rotation = equation.state.rotation[:, bodies]
        in_body = in_body_axes(jumps, rotation)
        self.impact = DoubleImpact(landing, equation, solution, in_body, bodies, motions.strikes)
        self.by_strike = ColumnImpact(landing, equation, solution, in_body, bodies)
        change = derivatives(landing, equation, solution, bodies)
        # The axes of a body turn at ω: (Rᵀ j)' = Rᵀ (j' + j × ω).
        turned = _cross_with_rotation(jumps, motions.twists[:, bodies])
        d_jumps = in_body_axes(motions.of_columns(change.maps) + turned, rotation)
        self.by_motion = ColumnImpact(landing, equation, solution, d_jumps, bodies)
        self.by_motion.delta_qd = motions.of_columns(change.delta_qd)
        self.by_motion.impulse = motions.of_columns(change.impulse)

    def slope(self, column: Column) -> tuple[Array, Array]:
        """The values (N, S) of a number and its derivatives (N, S, d)."""
        quantity = column.selection.quantity
        axis = column.selection.axis
        linear = quantity.relations.length_of or quantity
        strikes = self.motions.strikes
        n, S = strikes.shape[:2]
        d = self.motions.along.shape[-1]
        places = [column.place]
        numbers = column.selection.scalar(quantity_values(quantity, self.impact, places)[:, :, 0])

        # dy = v dA + dv A, each (N, S, d, components).
        A = quantity_values(linear, self.by_strike, places).reshape(n, 3, -1)
        dA = quantity_values(linear, self.by_motion, places).reshape(n, 3, -1)
        by_motion = (strikes @ dA).reshape(n, S, d, -1)
        by_turn = (self.motions.turns @ A[:, None]).swapaxes(1, 2)
        dy = by_motion + by_turn
        if linear.vector and axis is None:
            # |y|' = y · y' / |y|, and the number is a multiple of |y|.
            y = strikes @ A
            square = np.sum(y**2, axis=-1)
            ratio = numbers / np.where(square > 0.0, square, np.inf)
            dy = (dy @ y[..., None]) * ratio[..., None, None]
        return numbers, dy[..., axis or 0]


def _cross_with_rotation(jumps: Array, twists: Array) -> Array:
    """The cross products j × ω (N, n, 6, 3 d) of both parts of jumps with rates of rotation.

    Args: jumps (N, n, 6, 3), of 3 strikes; twists (N, n, 6, d), the angular part first.
    """
    n, bodies, _, strikes = jumps.shape
    d = twists.shape[-1]
    # (N, n, part, strike, component) × (N, n, component, d)
    parts = jumps.reshape(n, bodies, 2, 3, strikes).swapaxes(3, 4)
    crossed = cross_matrix(parts) @ twists[:, :, None, None, :3]
    return np.asarray(crossed.swapaxes(3, 4).reshape(n, bodies, 6, strikes * d))
