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
from shockpc.profile import impact_jumps, needs_proof
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


def slopes(
    landing: PosedLanding,
    Q: Array,
    strikes: Array,
    rates: Array,
    turns: Array,
    wanted: Sequence[Column],
    trusted: float | None = None,
) -> tuple[dict[str, tuple[Array, Array]], np.ndarray]:
    """Some numbers in N postures, with their derivatives along d ways in which posture and strike change together.

    Args:
        landing: the landing, before which nothing but the robot as a whole moves.
        Q: (N, nq) the postures.
        strikes: (N, S, 3) velocities of the robot before the impact, world axes [m/s].
        rates: (N, d, nv) at which the postures change, tangent of q.
        turns: (N, d, S, 3) rates at which the strikes change, at constant speed.
        wanted: the numbers, each with `has_gradient`.
        trusted: as for `needs_proof`.

    Returns: by name the values (N, S) and the derivatives (N, S, d), NaN where there are none, because the posture is singular, and
        zero of a length that is zero; and whether (N,) double precision is not enough for a posture.
    """
    robot, along, (n, d) = landing.robot, np.swapaxes(rates, 1, 2), rates.shape[:2]
    with one_thread(robot.model.nv):
        state, found = dynamics(robot, Q, landing.joint_model.armature), dict[str, tuple[Array, Array]]()
        twists = (state.J[:, None] * robot.supports[:, None]) @ along[:, None]
        heights = [column for column in wanted if column.selection.quantity in (CLEARANCE, SPREAD)]
        others = [column for column in wanted if column not in heights]
        bodies = list(dict.fromkeys(max(column.place.body, 0) for column in others)) or [0]
        equation, solution, jumps = impact_jumps(landing, state, with_strike=False, bodies=bodies)
        _, unclear = needs_proof(landing, equation, solution, trusted)
        if heights:
            bodily = [column for column in heights if column.selection.quantity is CLEARANCE]
            values, risen = height_rates(landing, state, equation.blocks, twists, [column.place for column in bodily])
            for column in heights:
                k = bodily.index(column) + 1 if column in bodily else 0
                found[column.name] = values[:, None, k], risen[:, None, k]
        if not others:
            return found, unclear
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
            number, value = evaluate(entry, here, where)[:, :, 0], evaluate(linear, here, where)[:, None, :, 0]
            slope = np.stack([evaluate(linear, one, where)[:, :, 0] for one in moved], axis=1)
            if turns.any():
                slope = slope + evaluate(linear, turned, where)[:, :, 0].reshape(slope.shape)
            if linear.vector and axis is None:
                length = np.linalg.norm(value, axis=-1)
                slope = np.sum(slope * value, axis=-1) / np.where(length > 0.0, length, np.inf)
                if entry.length_of is not None:
                    slope = slope * number[:, None] / np.where(length > 0.0, length, np.inf)
            elif axis is not None:
                slope = slope[..., axis]
            found[column.name] = np.asarray(column.selection.scalar(number)), slope.swapaxes(1, 2)
    return found, unclear
