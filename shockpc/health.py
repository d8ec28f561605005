"""How far to trust a profile: rank, residual, and a second solution that shares nothing with the first."""

import numpy as np

from shockpc.core.impulse import residual
from shockpc.core.maximal import Tree, solve_maximal
from shockpc.core.spatial import Array, velocity_at
from shockpc.errors import SceneError
from shockpc.model.dynamics import Dynamics
from shockpc.model.equation import Solution
from shockpc.model.robot import Robot
from shockpc.model.rows import Rows
from shockpc.record import Health

__all__ = ["gyration_radii", "health_of"]

TRUSTED = 1e-9
"""Two solutions that differ by more than this are reported with a warning."""


def health_of(robot: Robot, state: Dynamics, bodies: Tree, rows: Rows, solution: Solution) -> Health:
    """Judge the solution for the scene's strike, the last column.

    Args:
        robot: the robot.
        state: its dynamics, first posture.
        bodies: the same as free bodies and joints.
        rows: what is held.
        solution: what was found.

    Raises:
        SceneError: the mechanism cannot meet its contacts, because they contradict one another or ask for a motion that it does not
            have.
    """
    equation, impact = solution.equation, solution.impact
    b, delta = equation.b[0, :, -1:], impact.delta_qd[0, :, -1:]
    left = float(residual(equation.H[0], equation.J_c[0], b, delta, impact.impulse[0, :, -1:]))
    if left > 1e-6:
        raise SceneError(_contradiction(rows, (equation.J_c[0] @ delta + b)[:, 0], b[:, 0]))
    difference = _difference(robot, state, bodies, rows, solution)
    worst = int(np.argmax(difference))
    estimate = float(difference[worst])
    warnings: tuple[str, ...] = ()
    if estimate > TRUSTED:
        digits = max(0, int(-np.log10(estimate)))
        warnings = (
            f'two independent solutions differ by {estimate:.1e} at body "{robot.bodies[worst].name}", so its numbers hold to '
            f"{digits} digits at best; very light bodies under heavy ones, or a nearly singular chain, are the usual cause",
        )
    return Health(
        rank=int(impact.rank[0]),
        rows=equation.J_c.shape[1],
        residual=left,
        error_estimate=estimate,
        method="joint space (Eq. 4), checked in maximal coordinates",
        warnings=warnings,
    )


def gyration_radii(robot: Robot) -> Array:
    """Radius of gyration of every body about its centre of mass, for the mean axis (nb,) [m]; 0 for a body without mass."""
    mass = np.array([body.mass for body in robot.bodies])
    trace = np.array([np.trace(body.inertia) for body in robot.bodies])
    return np.asarray(np.sqrt(np.maximum(trace, 0.0) / 3.0 / np.where(mass > 0.0, mass, np.inf)))


def _difference(robot: Robot, state: Dynamics, bodies: Tree, rows: Rows, solution: Solution) -> Array:
    """Relative difference (nb,) between every body's jump and the one found in maximal coordinates."""
    W = rows.W[0].copy()
    W[..., :3] -= np.cross(bodies.com, W[..., 3:])
    combine = solution.impact.combine[0, : int(solution.impact.rank[0])]
    jump = solution.jumps[0, :, :, -1]
    other = solve_maximal(bodies, np.einsum("mc,cbk->mbk", combine, W), combine @ rows.b[0, :, -1:])[..., 0]

    rotation = state.rotation[0]
    com = np.stack([body.com for body in robot.bodies])
    omega = (rotation @ jump[:, :3, None])[..., 0]
    v_com = (rotation @ velocity_at(jump[:, :3], jump[:, 3:], com)[..., None])[..., 0]
    length = np.maximum(gyration_radii(robot), 1e-6)

    def size(omega: Array, v: Array) -> Array:
        return np.asarray(np.hypot(np.linalg.norm(v, axis=-1), length * np.linalg.norm(omega, axis=-1)))

    own = size(omega, v_com)
    # A body that hardly moves is measured against what 1e-9 of the fastest one would be: below that there is nothing to be wrong.
    return np.asarray(size(omega - other[:, :3], v_com - other[:, 3:]) / np.maximum(own, 1e-9 * own.max()))


def _contradiction(rows: Rows, left: Array, b: Array) -> str:
    """The message for rows that cannot be met: which one, along what, by how much."""
    row = int(np.argmax(np.abs(left)))
    block, own = next((block, own) for block, own in zip(rows.blocks, rows.slices, strict=True) if row < own.stop)
    axis = " ".join(f"{u:.3g}" for u in block.axes[row - own.start] + 0.0)
    return (
        f"{block.name} strikes at {abs(b[row]):.3g} m/s along ({axis}), but {abs(left[row]):.3g} m/s of that cannot be stopped: "
        "the mechanism cannot move that way here, or another contact asks for the opposite; "
        "leave that direction out of the contact or of the strike, or free the base"
    )
