"""Derivatives by the posture and by the strike of quantities that are linear in the jumps, of
lengths of such, and of heights.
"""

from collections.abc import Sequence

import numpy as np

from shockpc.core.spatial import Array, cross_matrix, in_body_axes
from shockpc.core.threads import one_thread
from shockpc.evaluation.column import Column
from shockpc.impact.derivatives import derivatives
from shockpc.impact.impact import ColumnImpact, DoubleImpact
from shockpc.impact.landed import solved
from shockpc.landing.landing import PosedLanding
from shockpc.method.dynamics import dynamics
from shockpc.profile import needs_proof
from shockpc.quantities.heights import CLEARANCE, HEIGHTS, REACH, height_rates, reach_rates
from shockpc.quantities.quantity import evaluate
from shockpc.quantities.support import OVERHANG, overhang_rates


def has_gradient(landing: PosedLanding, column: Column) -> bool:
    """Whether `slopes` gives the derivatives of a number; those of others are differences.

    So are those of all numbers with end stops, or with a contact at a lowest point: a difference
    also shows where a joint leaves a stop, or another point is the lowest.
    """
    entry = column.selection.quantity
    if landing.scene.stops or any(
        contact.lowest or contact.kind == "stop" for contact in landing.contacts
    ):
        return False
    return entry in (*HEIGHTS, OVERHANG) or (
        landing.translates and (entry.relations.linear or entry.relations.length_of is not None)
    )


def slopes(
    landing: PosedLanding,
    Q: Array,
    strikes: Array,
    rates: Array,
    turns: Array,
    wanted: Sequence[Column],
    trusted: float | None = None,
) -> tuple[dict[str, tuple[Array, Array]], np.ndarray]:
    """Some numbers in N postures, with their derivatives along d ways in which posture and strike
    change together.

    Args:
        landing: the landing, before which nothing but the robot as a whole moves.
        Q: (N, nq) the postures.
        strikes: (N, S, 3) velocities of the robot before the impact, world axes [m/s].
        rates: (N, d, nv) at which the postures change, tangent of q.
        turns: (N, d, S, 3) rates at which the strikes change, at constant speed.
        wanted: the numbers, each with `has_gradient`.
        trusted: as for `needs_proof`.

    Returns: by name the values (N, S) and the derivatives (N, S, d), NaN where there are none,
        because the posture is singular, and zero of a length that is zero; and whether (N,) double
        precision is not enough for a posture.
    """
    robot, along, (n, d, nv) = landing.robot, np.swapaxes(rates, 1, 2), rates.shape
    with one_thread(3 * nv):
        state, found = dynamics(robot, Q, landing.joint_model), dict[str, tuple[Array, Array]]()
        twists = (state.J[:, None] * robot.ancestors[:, None]) @ along[:, None]
        others = [
            column for column in wanted if column.selection.quantity not in (*HEIGHTS, OVERHANG)
        ]
        overhangs = [column for column in wanted if column.selection.quantity is OVERHANG]
        reaches = [column for column in wanted if column.selection.quantity is REACH]
        heights = [column for column in wanted if column not in (*others, *overhangs, *reaches)]
        bodies = list(dict.fromkeys(max(column.place.body, 0) for column in others)) or [0]
        equation, solution, jumps = solved(landing, state, with_strike=False, bodies=bodies)
        _, unclear = needs_proof(landing, equation, solution, trusted)
        if heights:
            values, risen = height_rates(
                landing, state, equation.blocks, twists, [column.place for column in heights]
            )
            for k, column in enumerate(heights, start=1):
                number = k if column.selection.quantity is CLEARANCE else 0
                found[column.name] = values[:, None, number], risen[:, None, number]
        if reaches:
            values, risen = reach_rates(
                landing, state, equation.blocks, twists, [column.place for column in reaches]
            )
            found |= {
                column.name: (values[:, None, k], risen[:, None, k])
                for k, column in enumerate(reaches)
            }
        for column in overhangs:
            values, risen = overhang_rates(landing, state, twists)
            found[column.name] = values[:, None], risen[:, None]
        rotation = state.rotation[:, bodies]
        here = DoubleImpact(
            landing, equation, solution, in_body_axes(jumps, rotation), bodies, strikes
        )
        change, *changes = (
            (part.reshape(n, -1, nv) @ along).reshape(*part.shape[:-2], 3 * d)
            for part in derivatives(landing, equation, solution, bodies)
        )
        # In the axes of a body that turns at ω, its jump changes by ω × itself less.
        turned = (
            cross_matrix(jumps.reshape(n, -1, 2, 3, 3).swapaxes(3, 4))
            @ twists[:, bodies, None, None, :3]
        )
        change = in_body_axes(change + turned.swapaxes(3, 4).reshape(change.shape), rotation)
        unit, moved = (
            ColumnImpact(landing, equation, solution, values, bodies)
            for values in (here.jumps, change)
        )
        moved.delta_qd, moved.impulse = changes
        for column in others:
            entry, where, axis = column.selection.quantity, [column.place], column.selection.axis
            linear = entry.relations.length_of or entry
            numbers = column.selection.scalar(evaluate(entry, here, where)[:, :, 0])
            by_strike, d_by_strike = (
                evaluate(linear, impact, where).reshape(n, 3, -1) for impact in (unit, moved)
            )
            slope = (strikes @ d_by_strike).reshape(n, numbers.shape[1], d, -1) + (
                turns @ by_strike[:, None]
            ).swapaxes(1, 2)
            # a length |v| changes by v · dv / |v|, and a multiple of it in proportion
            if linear.vector and axis is None:
                value = strikes @ by_strike
                square = np.sum(value**2, axis=-1)
                slope = (slope @ value[..., None]) * (
                    numbers / np.where(square > 0.0, square, np.inf)
                )[..., None, None]
            found[column.name] = numbers, slope[..., axis or 0]
    return found, unclear
