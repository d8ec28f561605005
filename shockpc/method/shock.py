"""The method on one screen: the jump of every body in an impact, in N postures.

Step 1: the impulsive equation of motion gives the jump of the joint velocities (shock paper, Eq. 4;
Eq. 7 where some are not free). Step 2: the recursion along the tree turns it into the jump of every
body (Eqs. 8 and 9). Step 3: in the plane, the jump of a body is a point without shock and a radius
(Eqs. 11 and 12).
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from shockpc.core.impulse import RowLimits, Solution, solve_impact
from shockpc.core.spatial import Array, body_jumps, cross
from shockpc.method.constraints import Constraint
from shockpc.method.dynamics import Dynamics
from shockpc.method.equation import Equation, System, equation_of


class Solved(NamedTuple):
    """Steps 1 and 2 in N postures.

    Attributes:
        equation: Eq. 4.
        solution: of it: jumps of the free joint velocities, impulses along the rows.
        jumps: (N, nb, 6, k) jumps (Δω, Δv) of the bodies at their frames' origins, world axes
            [rad/s, m/s].
    """

    equation: Equation
    solution: Solution
    jumps: Array


def shock(
    system: System,
    state: Dynamics,
    constraints: tuple[Constraint, ...],
    limits: RowLimits | None = None,
) -> Solved:
    """Steps 1 and 2 of a system in N postures. Args: as of `equation_of` and `solve_impact`."""
    # Eq. 4, left:   H, J_c,  b = (1 + e) J_c q̇⁻;   Eq. 7:  GᵀHG and J_c G in their place
    equation = equation_of(system, state, constraints)
    solution = solution_of(equation, limits)
    return Solved(equation, solution, jumps_of(equation, solution.delta_qd))


def solution_of(equation: Equation, limits: RowLimits | None = None) -> Solution:
    """Eq. 4, solved; `test_impulse` has it written out, without scaling, rank and condition."""
    # λ = −(J_c H⁻¹ J_cᵀ)⁻¹ b,   Δẏ = H⁻¹ J_cᵀ λ
    return solve_impact(
        equation.inertia, equation.J_c, equation.b, equation.terms, equation.tolerance, limits
    )


def jumps_of(equation: Equation, delta: Array, bodies: Sequence[int] | None = None) -> Array:
    """Jumps (N, nb, 6, k) of the bodies, or of some, by those of the free velocities (N, ny, k)."""
    robot, state = equation.system.robot, equation.state
    # Eq. 7:   Δq̇ = G Δẏ
    delta_qd = equation.full(delta)
    # Eqs. 8 and 9:   Δv̂_i = Δv̂_parent(i) + S_i Δq̇_i,  from the base to the leaves;
    # S_i are the columns of J that belong to the joint of body i.
    columns = [joint.v for joint in robot.joints]
    return body_jumps(state.J, columns, robot.parents, state.position, delta_qd, bodies)


def centre_of_percussion(delta_v: Any, normal: Any, turn: Any) -> Any:
    """Eq. 11:   p = n × Δv / (n·Δω).  Args: Δv (..., 3), n (..., 3), n·Δω (...), not zero."""
    return cross(normal, delta_v) / turn[..., None]


def radius_of_percussion(v_in: Any, turn: Any) -> Any:
    """Eq. 12:   r_p = v_in / |n·Δω|.  Args: v_in (...), n·Δω (...), not zero."""
    return v_in / np.abs(turn)
