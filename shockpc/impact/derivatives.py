"""Derivatives of steps 1 and 2 by the posture: of the jumps for unit strikes, by q's tangent.

With H Δq̇ = J_cᵀ λ and J_c Δq̇ = −b, the derivative along a joint velocity k solves the same
equations with other right-hand sides,

    H dΔq̇ − J_cᵀ dλ = dJ_cᵀ λ − dH Δq̇,    J_c dΔq̇ = −dJ_c Δq̇,

since b does not change for strikes of the whole robot along fixed axes. Joint k moves all bodies
behind it as one rigid body, with the twist J_k. So the column J_a of a joint behind it changes by
J_k × J_a, and the twist V of a body behind it by J_k × (V − U_k), where U_k is the part that joints
ahead of joint k cause. The body's momentum h = I V changes by −(J_k ×)ᵀ h − I (J_k × U_k), and sums
of this over bodies give dH Δq̇ (Carpentier and Mansard, RSS 2018, of jumps in place of
accelerations).
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from shockpc.core.impulse import Solution
from shockpc.core.inertia import solve_inertia
from shockpc.core.memo import memoized
from shockpc.core.spatial import Array, cross, cross_matrix, motion_cross
from shockpc.landing.contact import lowest_point_turned
from shockpc.landing.joint_model import JointModel
from shockpc.landing.landing import Landing
from shockpc.method.constraints import (
    Constraint,
    constraint_axes,
    constraint_point,
    constraint_wrenches,
    moved_by,
    row_signs,
    slices_of,
    wrenches,
)
from shockpc.method.dynamics import Dynamics, Inertias, spatial_inertias
from shockpc.method.equation import Equation
from shockpc.robot.robot import Robot

BLOCK = 16
"""Postures whose maps are changed together, so that the arrays stay in the processor's cache."""


class Derivatives(NamedTuple):
    """Derivatives by the tangent of q, Pinocchio's layout; NaN where there are none.

    They are for strikes of 1 m/s along world x, y and z.

    Attributes:
        maps: (N, n, 6, 3, nv) of the jumps of bodies, world axes, at their frames' origins.
        delta_qd: (N, nv, 3, nv) of the jumps of the joint velocities.
        impulse: (N, nc, 3, nv) of the impulses along the rows; NaN where redundant rows leave them
            undetermined.
    """

    maps: Array
    delta_qd: Array
    impulse: Array


def derivatives(
    landing: Landing,
    equation: Equation,
    solution: Solution,
    bodies: Sequence[int] | None = None,
    out: Array | None = None,
) -> Derivatives:
    """The derivatives of steps 1 and 2 in N postures.

    They are those of the equations as they stand: a follower, a locked joint and one of a loop each
    have a separate column, in which the others stay. In a posture with redundant rows they are
    those along which the same rows stay redundant; in one that is singular, where fewer rows are
    independent than beside it, there are none.

    Args:
        landing: the landing; strikes of a contact's velocity are not among these.
        equation: step 1.
        solution: of it.
        bodies: indices of those whose jumps are wanted; all by default.
        out: (N, n, 6, 3, nv) into which the derivatives of the maps are written; a new array by
            default.
    """
    state = equation.state
    robot = landing.robot
    turning = _Turning.of(state)
    delta_qd = equation.full(solution.delta_qd[..., :3])
    impulse = solution.independent_impulse[..., :3]

    # dJ_cᵀ λ − dH Δq̇ and −dJ_c Δq̇
    momenta = _momentum_rates(robot, landing.joint_model, state, turning, delta_qd)
    dJ = _row_rates(robot, state, equation.constraints, turning)
    right = momenta.rates + impulse.swapaxes(1, 2)[:, None] @ dJ.swapaxes(1, 2)
    left = delta_qd.swapaxes(1, 2)[:, None] @ dJ
    d_qd, d_impulse = _solved(landing, equation, solution, right, left)

    maps = _map_rates(state, robot.ancestors, momenta, d_qd, bodies, out)
    if robot.free_base:
        _to_body_axes(d_qd, delta_qd)
    return Derivatives(maps, d_qd, d_impulse)


class _Turning(NamedTuple):
    """The rotation of bodies by joint velocities.

    Attributes:
        J: (N, nv, 6) twists of unit joint velocities.
        J_cross: (N, nv, 6, 6) their matrices, as `motion_cross`.
    """

    J: Array
    J_cross: Array

    @staticmethod
    def of(state: Dynamics) -> "_Turning":
        """Those of a robot in N postures."""
        J = np.ascontiguousarray(state.J.swapaxes(1, 2))
        return _Turning(J, motion_cross(J))


def _map_rates(
    state: Dynamics,
    ancestors: np.ndarray,
    momenta: "_MomentumRates",
    d_qd: Array,
    bodies: Sequence[int] | None,
    out: Array | None,
) -> Array:
    """Derivatives (N, n, 6, 3, nv) of the jumps of bodies.

    Arguments are as above, with d_qd (N, nv, 3, nv).
    """
    n, nv = d_qd.shape[:2]
    chosen = slice(None) if bodies is None else list(bodies)
    moves = ancestors[chosen].astype(float)
    position = state.position[:, chosen]
    twists = momenta.twists[:, chosen]
    maps = np.empty((n, len(moves), 6, 3, nv)) if out is None else out
    for k in range(0, n, BLOCK):
        chunk = slice(k, k + BLOCK)
        _jump_rates(
            position[chunk],
            state.J[chunk],
            moves,
            twists[chunk],
            momenta.fixed[chunk],
            d_qd[chunk],
            maps[chunk],
        )
    return maps


def _to_body_axes(d_qd: Array, delta_qd: Array) -> None:
    """Change the derivatives (N, nv, 3, nv) of a free base's velocity to those in body axes.

    It is written in the axes of the body, at its origin, which move with it.
    """
    linear, angular = (
        cross_matrix(delta_qd[:, k : k + 3].swapaxes(1, 2)).swapaxes(1, 2) for k in (0, 3)
    )
    d_qd[:, :3, :, :3] += angular
    d_qd[:, :3, :, 3:6] += linear
    d_qd[:, 3:6, :, 3:6] += angular


@memoized()
def _masks(robot: Robot) -> tuple[Array, Array]:
    """Masks (nv, nv) of the columns that a joint velocity turns, of 1 and 0.

    The first index is that velocity, the second the column.

    Returns: turned, the columns of joints behind the velocity's joint, and those of that joint; and
        ahead, those of joints that carry it, which stay. The columns of a free base stay in the
        world; its velocity is converted to body axes in the end.
    """
    first = np.zeros(robot.model.nv, dtype=int)
    for joint in robot.single_joints:
        first[joint.v] = joint.v.start
    if robot.free_base:
        first[:6] = 6
    carriers = robot.ancestors[np.argmax(robot.ancestors, axis=0)]
    ahead = carriers & (np.arange(len(first)) < first[:, None])
    return (carriers.T & ~ahead).astype(float), ahead.astype(float)


class _MomentumRates(NamedTuple):
    """Derivatives by the posture of the momenta that a jump gives to the bodies.

    Attributes:
        rates: (N, nv, 3, nv) −dH Δq̇.
        twists: (N, nb, 6, 3) V of the bodies.
        fixed: (N, 6, 3 nv) J_k × U_k, as in the module's text.
    """

    rates: Array
    twists: Array
    fixed: Array


def _momentum_rates(
    robot: Robot, joints: JointModel, state: Dynamics, turning: _Turning, delta_qd: Array
) -> _MomentumRates:
    """Derivatives by the posture of the momenta that a jump (N, nv, 3) gives to the bodies.

    Args:
        robot: the robot.
        joints: what they do.
        state: the robot in N postures.
        turning: how joint velocities turn bodies.
        delta_qd: (N, nv, 3) the jump.
    """
    J, J_cross = turning
    n, nv = J.shape[:2]
    turned, ahead = _masks(robot)
    moves = robot.ancestors.T.astype(float)

    # V of each body and J_k × U_k, sums of J_a Δq̇_a over joints that move a body, or are ahead of k
    parts = (J[..., None] * delta_qd[:, :, None]).reshape(n, nv, 18)
    twists = (moves.T @ parts).reshape(n, len(robot.bodies), 6, 3)
    fixed = J_cross @ (ahead @ parts).reshape(n, nv, 6, 3)

    change, F = _momentum_changes(
        spatial_inertias(robot, state, Inertias.of(robot, joints)), moves, twists, fixed, turning
    )
    change = change.transpose(0, 2, 3, 1).reshape(n, 6, 3 * nv)
    fixed = fixed.transpose(0, 2, 3, 1).reshape(n, 6, 3 * nv)
    rates = (J @ change) * np.tile(ahead.T, 3)
    rates += (F @ fixed) * np.tile(turned.T, 3)
    return _MomentumRates(rates.reshape(n, nv, 3, nv), twists, fixed)


def _momentum_changes(
    inertia: Array, moves: Array, twists: Array, fixed: Array, turning: _Turning
) -> tuple[Array, Array]:
    """−dh (N, nv, 6, 3) = (J_k ×)ᵀ h + I (J_k × U_k), and F = I J_k (N, nv, 6), for each joint k.

    h and I are those of all bodies that joint k moves, and F is the momentum of its unit velocity.

    Args:
        inertia: (N, nb, 6, 6) of the bodies.
        moves: (nv, nb) mask of the bodies that each joint moves.
        twists: (N, nb, 6, 3) V of the bodies.
        fixed: (N, nv, 6, 3) J_k × U_k.
        turning: how joint velocities turn bodies.
    """
    n, nb = inertia.shape[:2]
    nv = len(moves)
    # Σ I and Σ I V over the bodies that joint k moves
    composite = (moves @ inertia.reshape(n, nb, 36)).reshape(n, nv, 6, 6)
    momenta = (moves @ (inertia @ twists).reshape(n, nb, 18)).reshape(n, nv, 6, 3)
    products = composite @ np.concatenate([fixed, turning.J[..., None]], axis=3)
    change = products[..., :3] + turning.J_cross.swapaxes(-1, -2) @ momenta
    return change, products[..., 3]


def _row_rates(
    robot: Robot, state: Dynamics, constraints: Sequence[Constraint], turning: _Turning
) -> Array:
    """Derivatives (N, nc, nv, nv) of the rows J_c before any reduction.

    The last axis is that of the tangent; arguments are as above.
    """
    J, J_cross = turning
    n, nv = J.shape[:2]
    turned, _ = _masks(robot)
    out = np.empty((n, sum(constraint.size for constraint in constraints), nv, nv))
    for constraint, rows in zip(constraints, slices_of(constraints), strict=True):
        # A column behind joint k changes by J_k × J_a, and the wrench of a row by that of its ends.
        carried = constraint_wrenches(state, constraint)[:, None] @ J_cross
        change = _wrench_rates(state, constraint, J)
        carried = np.ascontiguousarray(carried.transpose(0, 2, 3, 1))
        change = np.ascontiguousarray(change.transpose(0, 2, 3, 1))
        signed_J = (J * row_signs(state, constraint)[:, None])[:, None]
        dJ = out[:, rows]
        np.matmul(signed_J, carried, out=dJ)
        dJ *= turned.T
        dJ += signed_J @ change
    return out


def _wrench_rates(state: Dynamics, constraint: Constraint, J: Array) -> Array:
    """Derivatives (N, nv, k, 6) of the wrenches of a constraint's rows by each joint velocity."""
    omega, v = np.split(J, 2, axis=-1)
    n = len(constraint.forces)
    moves_point = moved_by(state, constraint.body)[:, None]
    moves_axes = moved_by(state, constraint.axes_body)[:, None]
    point = constraint_point(state, constraint)[:, None]
    axes = constraint_axes(state, constraint)[:, None]
    d_point = (v + cross(omega, point)) * moves_point
    # Of a sole that sticks every point is held, so it does not matter how the lowest one moves
    # over it.
    if constraint.lowest and constraint.size < 6:
        rolls = lowest_point_turned(constraint, state.rotation[:, constraint.body]).swapaxes(1, 2)
        d_point += (omega * moves_point) @ rolls
    d_axes = cross((omega * moves_axes)[:, :, None], axes)
    # of p × a:  p × da + dp × a
    change = wrenches(point, d_axes, n)
    change[:, :, :n, :3] += cross(d_point[:, :, None], axes[:, :, :n])
    return change


def _solved(
    landing: Landing, equation: Equation, solution: Solution, right: Array, left: Array
) -> tuple[Array, Array]:
    """Derivatives of q̇ (N, nv, 3, nv) and λ (N, nc, 3, nv).

    Args: right (N, nv, 3, nv) and left (N, nc, 3, nv), as in the module's text.
    """
    # Rows that depend on others are replaced by zeros, and so are their impulses.
    independent = _independent(landing, equation, solution)
    J_c = equation.J_c * independent[..., None]
    n, nc, ny = J_c.shape
    right = right.reshape(n, len(landing.joint_model.locked), -1)
    if equation.G is not None:
        right = equation.G.swapaxes(1, 2) @ right
    with np.errstate(all="ignore"):
        unit = np.broadcast_to(np.eye(ny), (n, ny, ny))
        inverse = solve_inertia(equation.inertia, unit)
        # H dẏ − J_cᵀ dλ = right and J_c dẏ = −left, with X = H⁻¹ J_cᵀ and Z = H⁻¹ right
        X = inverse @ J_c.swapaxes(1, 2)
        Z = inverse @ right
        A = J_c @ X + (1.0 - independent)[..., None] * np.eye(nc)
        b = left.reshape(n, nc, -1) * independent[..., None] + J_c @ Z
        d_impulse = -np.linalg.solve(A, b)
    d_qd = equation.full(Z + X @ d_impulse)
    determined = (independent != 0.0).all(axis=1)[:, None, None]
    known = np.where(determined, d_impulse, np.nan)
    return d_qd.reshape(n, -1, *left.shape[2:]), known.reshape(left.shape)


def _independent(landing: Landing, equation: Equation, solution: Solution) -> Array:
    """One for each row that is independent, zero for one that follows from others (N, nc).

    NaN in a posture that is singular, where fewer rows are independent than beside it.
    """
    limits = landing.row_limits(equation.state, equation.constraints)
    independent = np.ones(equation.J_c.shape[:2])
    for k, row_space in solution.row_spaces.items():
        regular = not row_space.uncertain and len(row_space.rows) >= limits(k).most
        rows = np.isin(np.arange(independent.shape[1]), row_space.rows)
        independent[k] = rows if regular else np.nan
    return independent


def _jump_rates(
    p: Array, J: Array, moves: Array, twists: Array, fixed: Array, d_qd: Array, out: Array
) -> None:
    """Derivatives (N, n, 6, 3, nv) of the jumps of bodies at their frames' origins.

    They change by the joint velocities of the bodies, and as the bodies turn.

    A body behind joint k turns with it, ω_k × (Δω, Δv), but for the part that joints ahead of it
    cause.
    """
    n, nb = p.shape[:2]
    nv = d_qd.shape[1]
    at = np.zeros((n, nb, 6, 6))  # to the frame's origin: v + ω × p
    at[..., range(6), range(6)] = 1.0
    at[..., 3:, :3] = -cross_matrix(p)
    jumps = (at @ twists).reshape(n, nb, 2, 3, 3).swapaxes(-1, -2)
    turning = cross_matrix(jumps).swapaxes(-2, -3).reshape(n, 18 * nb, 3)  # ω × u = −[u]× ω
    at = at.reshape(n, 6 * nb, 6)
    less = (at @ fixed).reshape(n, 18 * nb, nv)
    less += turning @ J[:, :3]
    less *= np.repeat(moves, 18, axis=0)
    J_bodies = (at @ J) * np.repeat(moves, 6, axis=0)
    np.matmul(J_bodies, d_qd.reshape(n, nv, 3 * nv), out=out.reshape(n, 6 * nb, 3 * nv))
    out -= less.reshape(out.shape)
