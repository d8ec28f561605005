"""What rounding in the inertia and the Jacobians does to the joint-space solution, by trying."""

import numpy as np

from shockpc.core.rounding import shaken_inertia, shaken_jacobian, shaken_rows, units_of
from shockpc.core.spatial import Array
from shockpc.core.tree import Tree
from shockpc.errors import SolveError
from shockpc.model.bodies import at_com
from shockpc.model.dynamics import Dynamics
from shockpc.model.equation import solve
from shockpc.model.rows import Rows
from shockpc.robot.robot import Robot

__all__ = ["sampled_rounding"]


def sampled_rounding(robot: Robot, state: Dynamics, bodies: Tree, rows: Rows, G: Array | None, samples: int) -> Array:
    """What rounding in H and J does to the joint-space solution: the largest change (nb, 6) of every body's jump.

    Sampled with a few mechanisms that rounding cannot tell from this one, at the centres of mass; infinite where one of them
    cannot be solved.

    Args:
        robot: the robot.
        state: its dynamics, first posture.
        bodies: the same as free bodies and joints.
        rows: what is held; the scene's strike in the last column.
        G: (1, nv, ny) columns of the free velocities, or None where all are.
        samples: how many mechanisms.
    """
    draw, units = np.random.default_rng(0), units_of(state.rotation[0])
    size = max(float(np.abs(bodies.com).max()), float(np.abs(bodies.joint).max()))

    def repeated(values: Array) -> Array:
        return np.broadcast_to(values, (samples, *values.shape[1:]))

    several = state._replace(
        H=shaken_inertia(draw, units, repeated(state.H), _inertia_terms(state, bodies)),
        J=shaken_jacobian(draw, units, repeated(state.J), size),
        rotation=repeated(state.rotation),
        position=repeated(state.position),
    )
    shaken = rows._replace(W=shaken_rows(draw, units, repeated(rows.W), size), b=repeated(rows.b[..., -1:]))
    try:
        found = solve(robot, several, shaken, bodies.armature, None if G is None else repeated(G)).jumps[..., 0]
        exact = solve(robot, state, rows, bodies.armature, G).jumps[0, ..., -1]
    except SolveError:
        return np.full((len(robot.bodies), 6), np.inf)
    return np.asarray(np.abs(np.stack([at_com(robot, state, jump - exact) for jump in found])).max(axis=0))


def _inertia_terms(state: Dynamics, bodies: Tree) -> Array:
    """Size (nv,) of the terms that the diagonal of H is a sum of: masses times squares of moments of speed about the base."""
    reach = np.linalg.norm(bodies.com, axis=-1)
    turns, slides = np.linalg.norm(state.J[0, :3], axis=0), np.linalg.norm(state.J[0, 3:], axis=0)
    return np.asarray(bodies.mass @ np.where(state.moves, slides + reach[:, None] * turns, 0.0) ** 2)
