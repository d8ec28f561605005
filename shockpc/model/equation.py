"""Step 1 for a robot: from postures, contacts and free velocities to the system that `core.impulse` solves."""

from typing import NamedTuple

import numpy as np

from shockpc.core.impulse import Impact, solve_impact, weakest_columns
from shockpc.core.spatial import Array
from shockpc.errors import SolveError
from shockpc.model.contact import Touch
from shockpc.model.dynamics import Dynamics, contact_rows
from shockpc.model.robot import Robot

__all__ = ["Equation", "impulsive_equation", "joint_jumps", "solve_equation"]


class Equation(NamedTuple):
    """The impulsive equation of motion in N postures, in the free velocities ẏ, for strikes of 1 m/s along world x, y and z.

    Attributes:
        H: (N, ny, ny) GᵀHG.
        J_c: (N, nc, ny) J_c G.
        b: (N, nc, 3) (1 + e) times the approach along each row.
        G: (N, nv, ny), or None where all velocities are free.
    """

    H: Array
    J_c: Array
    b: Array
    G: Array | None


def impulsive_equation(state: Dynamics, touches: tuple[Touch, ...], G: Array | None) -> Equation:
    """Assemble Eq. 4, reduced by Eq. 7 where some velocities are not free."""
    J_c = contact_rows(state, touches)
    approach = np.concatenate([(1.0 + touch.restitution) * touch.directions for touch in touches])
    b = np.broadcast_to(approach, (len(J_c), *approach.shape))
    if G is None:
        return Equation(state.H, J_c, b, None)
    return Equation(np.swapaxes(G, -1, -2) @ state.H @ G, J_c @ G, b, G)


def solve_equation(robot: Robot, equation: Equation) -> Impact:
    """Solve Eq. 4 for unit strikes.

    Raises:
        SolveError: the inertia cannot be inverted; the text names the bodies to blame.
    """
    try:
        return solve_impact(equation.H, equation.J_c, equation.b)
    except SolveError:
        H = next(H for H in equation.H if np.linalg.eigvalsh(H)[0] <= 1e-14 * np.linalg.eigvalsh(H)[-1] or len(equation.H) == 1)
        raise SolveError(_blame(robot, equation.G, weakest_columns(H))) from None


def joint_jumps(equation: Equation, impact: Impact) -> Array:
    """Jumps of all joint velocities for unit strikes, Δq̇ = G Δẏ (N, nv, 3)."""
    return impact.delta_qd if equation.G is None else equation.G @ impact.delta_qd


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
        f'{"bodies" if len(names) > 1 else "body"} {listed} of robot "{robot.name}" can move but carry no mass or inertia to '
        "resist it, so the inertia matrix cannot be inverted; give them mass and inertia in the file, or make their joints fixed"
    )
