"""Step 1 for a robot: from postures, rows and free velocities to the system that `core.impulse` solves."""

from typing import NamedTuple

import numpy as np

from shockpc.core.impulse import Impact, solve_impact, weakest_columns
from shockpc.core.spatial import Array
from shockpc.errors import SolveError
from shockpc.model.bodies import body_jumps
from shockpc.model.dynamics import Dynamics
from shockpc.model.rows import Rows, row_jacobian
from shockpc.robot.robot import Robot

__all__ = ["Equation", "Solution", "impulsive_equation", "solve"]


class Equation(NamedTuple):
    """The impulsive equation of motion in N postures, in the free velocities ẏ, for k motions before the impact.

    Attributes:
        H: (N, ny, ny) GᵀHG, armature included.
        J_c: (N, nc, ny) J_c G, closure rows included.
        b: (N, nc, k) speed to be undone along each row.
        G: (N, nv, ny), or None where all velocities are free.
    """

    H: Array
    J_c: Array
    b: Array
    G: Array | None


def impulsive_equation(state: Dynamics, rows: Rows, armature: Array, G: Array | None) -> Equation:
    """Assemble Eq. 4, reduced by Eq. 7 where some velocities are not free.

    Args:
        state: the robot in N postures.
        rows: what is held.
        armature: (nv,) reflected inertia of the drives, added to H's diagonal [kg m², kg].
        G: (N, nv, ny) columns of the free velocities, or None.
    """
    H, J_c = state.H, row_jacobian(state, rows.W)
    if armature.any():
        H = H + np.diag(armature)
    if G is None:
        return Equation(H, J_c, rows.b, None)
    return Equation(np.swapaxes(G, -1, -2) @ H @ G, J_c @ G, rows.b, G)


class Solution(NamedTuple):
    """Eq. 4 solved, and what it does to every body.

    Attributes:
        equation: what was solved.
        impact: its solution in the free velocities.
        delta_qd: (N, nv, k) jumps of all joint velocities, Δq̇ = G Δẏ [rad/s, m/s].
        jumps: (N, nb, 6, k) jumps of the bodies, body coordinates at their frames' origins [rad/s, m/s].
    """

    equation: Equation
    impact: Impact
    delta_qd: Array
    jumps: Array


def solve(robot: Robot, state: Dynamics, rows: Rows, armature: Array, G: Array | None) -> Solution:
    """Steps 1 and 2: solve the impulsive equation of motion, and carry the jump to every body. Arguments as for the equation.

    Raises:
        SolveError: the inertia cannot be inverted; the text names the bodies to blame.
    """
    equation = impulsive_equation(state, rows, armature, G)
    try:
        impact = solve_impact(equation.H, equation.J_c, equation.b)
    except SolveError:
        singular = next((H for H in equation.H if np.linalg.eigvalsh(H)[0] <= 1e-14 * np.linalg.eigvalsh(H)[-1]), equation.H[0])
        raise SolveError(_blame(robot, equation.G, weakest_columns(singular))) from None
    delta_qd = impact.delta_qd if G is None else G @ impact.delta_qd
    return Solution(equation, impact, delta_qd, body_jumps(state, delta_qd))


def _blame(robot: Robot, G: Array | None, columns: list[int]) -> str:
    """The message for an inertia that cannot be inverted: the bodies whose joints carry none."""
    velocities = columns if G is None else [int(np.argmax(np.abs(G[0, :, column]))) for column in columns]
    names = [
        body.name
        for body in robot.bodies
        if any(0 <= v - robot.model.joints[body.joint].idx_v < robot.model.joints[body.joint].nv for v in velocities)
    ]
    listed = ", ".join(f'"{name}"' for name in names[:6]) + (f" and {len(names) - 6} more" if len(names) > 6 else "")
    return (
        f'{"bodies" if len(names) > 1 else "body"} {listed} of robot "{robot.name}" can move, but no mass or inertia resists it, '
        "so the inertia matrix cannot be inverted; give mass and inertia in the file (mass on a joint's axis does not resist "
        "turning about it), or lock the joints with --lock"
    )
