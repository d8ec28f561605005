"""Derivatives of quantities by the posture and by the strike, for those that are linear in the jumps, or lengths of such."""

import copy
from collections.abc import Sequence

import numpy as np

from shockpc.core.bodies import in_body_axes
from shockpc.core.spatial import Array, cross
from shockpc.core.threads import one_thread
from shockpc.evaluation.columns import Column
from shockpc.impact.derivatives import derivatives
from shockpc.impact.impact import DoubleImpact
from shockpc.landing.dynamics import dynamics
from shockpc.landing.landing import PosedLanding
from shockpc.profile import ILL_CONDITIONED, impact_jumps, needs_proof
from shockpc.quantities.heights import CLEARANCE, SPREAD, height_rates
from shockpc.quantities.quantity import evaluate


def has_gradient(landing: PosedLanding, column: Column) -> bool:
    """Whether `slopes` gives the derivatives of a number; of the others differences do.

    They tell too where a contact at a lowest point jumps, or a joint leaves an end stop.
    """
    entry = column.selection.quantity
    if landing.scene.stops or any(contact.lowest or contact.kind == "stop" for contact in landing.contacts):
        return False
    if entry in (CLEARANCE, SPREAD):
        return True
    lengthened = entry.length_of is not None and landing.scene.v_in != "com"
    return landing.translates and (entry.linear or lengthened)


def clear(landing: PosedLanding) -> bool:
    """Whether double precision is enough for the posture of a landing."""
    equation, solution, _ = impact_jumps(landing, landing.state)
    return float(needs_proof(landing, equation, solution)[0][0]) <= ILL_CONDITIONED


def slopes(
    landing: PosedLanding, Q: Array, strikes: Array, rates: Array, turns: Array, wanted: Sequence[Column]
) -> dict[str, Array]:
    """Derivatives (N, S, d) of some numbers in N postures, by name, along d ways in which posture and strike change together.

    Args:
        landing: the landing, before which nothing but the robot as a whole moves.
        Q: (N, nq) the postures.
        strikes: (N, S, 3) velocities of the robot before the impact, world axes [m/s].
        rates: (N, d, nv) at which the postures change, tangent of q.
        turns: (N, d, S, 3) rates at which the strikes change, at constant speed.
        wanted: the numbers, each with `has_gradient`.

    Returns: NaN where there is none, because the posture is singular; of a length that is zero, zero.
    """
    robot, along, (n, d) = landing.robot, np.swapaxes(rates, 1, 2), rates.shape[:2]
    with one_thread(robot.model.nv):
        state, found = dynamics(robot, Q, landing.joint_model.armature), dict[str, Array]()
        twists = (state.J[:, None] * robot.supports[:, None]) @ along[:, None]
        heights = [column for column in wanted if column.selection.quantity in (CLEARANCE, SPREAD)]
        others = [column for column in wanted if column not in heights]
        bodies = list(dict.fromkeys(max(column.place.body, 0) for column in others)) or [0]
        equation, solution, jumps = impact_jumps(landing, state, with_strike=False, bodies=bodies)
        if heights:
            bodily = [column for column in heights if column.selection.quantity is CLEARANCE]
            risen = height_rates(landing, state, equation.blocks, twists, [column.place for column in bodily])
            found |= {column.name: risen[:, None, bodily.index(column) + 1 if column in bodily else 0] for column in heights}
        if not others:
            return found
        change = derivatives(landing, equation, solution, bodies)
        here = DoubleImpact(landing, equation, solution, in_body_axes(jumps, state.rotation[:, bodies]), bodies, strikes)
        moved, turned = [copy.copy(here) for _ in range(d)], copy.copy(here)
        # In the axes of a body that turns at ω, its jump changes by ω × itself less.
        omega = np.moveaxis(twists[:, bodies, :3], -1, 0)[..., None, None, :]
        turning = cross(omega, jumps.reshape(n, -1, 2, 3, 3).swapaxes(-1, -2)).swapaxes(-1, -2).reshape(d, *jumps.shape)
        rate, delta_qd, impulse = (
            np.moveaxis((part.reshape(n, -1, along.shape[1]) @ along).reshape(*part.shape[:-1], d), -1, 0) for part in change
        )
        for one, *parts in zip(moved, rate - turning, delta_qd, impulse, strict=True):
            one.jumps, one.delta_qd, one.impulse = in_body_axes(parts[0], state.rotation[:, bodies]), *parts[1:]
        turned.strikes = turns.reshape(n, -1, 3)
        for column in others:
            entry, where, axis = column.selection.quantity, [column.place], column.selection.axis
            linear = entry.length_of or entry
            value = evaluate(linear, here, where)[:, None, :, 0]
            slope = np.stack([evaluate(linear, one, where)[:, :, 0] for one in moved], axis=1)
            if turns.any():
                slope = slope + evaluate(linear, turned, where)[:, :, 0].reshape(slope.shape)
            if linear.vector and axis is None:
                length = np.linalg.norm(value, axis=-1)
                slope = np.sum(slope * value, axis=-1) / np.where(length > 0.0, length, np.inf)
                if entry.length_of is not None:
                    slope = slope * evaluate(entry, here, where)[:, None, :, 0] / np.where(length > 0.0, length, np.inf)
            elif axis is not None:
                slope = slope[..., axis]
            found[column.name] = slope.swapaxes(1, 2)
    return found
