"""Derivatives of quantities by the posture and by the strike, for those that are linear in the jumps, or lengths of such."""

import copy
from collections.abc import Sequence

import numpy as np

from shockpc.core.bodies import in_body_axes
from shockpc.core.spatial import Array
from shockpc.core.threads import one_thread
from shockpc.evaluation.columns import Column
from shockpc.impact.derivatives import derivatives
from shockpc.impact.impact import DoubleImpact
from shockpc.landing.dynamics import dynamics
from shockpc.landing.landing import PosedLanding
from shockpc.profile import ILL_CONDITIONED, impact_jumps, needs_proof
from shockpc.quantities.quantity import evaluate


def has_gradient(landing: PosedLanding, column: Column) -> bool:
    """Whether `slopes` gives the derivatives of a number; of the others differences do.

    They tell too where a contact at a lowest point jumps, or a joint leaves an end stop.
    """
    entry = column.selection.quantity
    if landing.scene.stops or any(contact.lowest or contact.kind == "stop" for contact in landing.contacts):
        return False
    lengthened = entry.length_of is not None and landing.scene.v_in != "com"
    return landing.translates and (entry.linear or lengthened)


def clear(landing: PosedLanding) -> bool:
    """Whether double precision is enough for the posture of a landing."""
    equation, solution, _ = impact_jumps(landing, landing.state)
    return float(needs_proof(landing, equation, solution)[0][0]) <= ILL_CONDITIONED


def slopes(
    landing: PosedLanding, q: Array, strikes: Array, rates: Array, turns: Array, wanted: Sequence[Column]
) -> dict[str, Array]:
    """Derivatives (S, d) of some numbers, by name, along d ways in which posture and strike change together.

    Args:
        landing: the landing, before which nothing but the robot as a whole moves.
        q: (nq,) the posture.
        strikes: (S, 3) velocities of the robot before the impact, world axes [m/s].
        rates: (d, nv) at which the posture changes, tangent of q.
        turns: (d, S, 3) rates at which the strikes change, at constant speed.
        wanted: the numbers, each with `has_gradient`.

    Returns: NaN where there is none, because the posture is singular; of a length that is zero, zero.
    """
    robot, d, S = landing.robot, len(rates), len(strikes)
    with one_thread(robot.model.nv):
        state = dynamics(robot, q[None], landing.joint_model.armature)
        bodies = list(dict.fromkeys(max(column.place.body, 0) for column in wanted))
        equation, solution, jumps = impact_jumps(landing, state, with_strike=False, bodies=bodies)
        change = derivatives(landing, equation, solution, bodies)
        here = DoubleImpact(
            landing, equation, solution, in_body_axes(jumps, state.rotation[:, bodies]), bodies, strikes[None], None
        )
        moved, turned = copy.copy(here), copy.copy(here)
        # In the axes of a body that turns at ω, its jump changes by ω × itself less.
        omega = (state.J[0, :3] * robot.supports[bodies][:, None]) @ rates.T
        rate = np.moveaxis(change.maps[0] @ rates.T, -1, 0).reshape(d, len(bodies), 2, 3, 3)
        rate = rate - np.cross(omega.transpose(2, 0, 1)[:, :, None, None], jumps[0].reshape(-1, 2, 3, 3).swapaxes(-1, -2)).swapaxes(
            -1, -2
        )
        moved.jumps = in_body_axes(rate.reshape(d, len(bodies), 6, 3), np.repeat(state.rotation[:, bodies], d, axis=0))
        moved.delta_qd = np.moveaxis(change.delta_qd[0] @ rates.T, -1, 0)
        moved.impulse = np.moveaxis(change.impulse[0] @ rates.T, -1, 0)
        turned.strikes = turns.reshape(1, d * S, 3)
        found = {}
        for column in wanted:
            entry, where = column.selection.quantity, [column.place]
            linear = entry.length_of or entry
            value, slope = evaluate(linear, here, where)[0, :, 0], evaluate(linear, moved, where)[:, :, 0]
            if turns.any():
                slope = slope + evaluate(linear, turned, where)[0, :, 0].reshape(slope.shape)
            axis = column.selection.axis
            if linear.vector and axis is None:
                length = np.linalg.norm(value, axis=-1)
                slope = np.sum(slope * value, axis=-1) / np.where(length > 0.0, length, np.inf)
                if entry.length_of is not None:
                    slope = slope * evaluate(entry, here, where)[0, :, 0] / np.where(length > 0.0, length, np.inf)
            elif axis is not None:
                slope = slope[..., axis]
            found[column.name] = slope.T
    return found
