"""How steps 1 and 2 change with the posture: derivatives of the jumps for unit strikes by the tangent of q.

With H Δq̇ = J_cᵀ λ and J_c Δq̇ = −b, the derivative along a joint velocity k solves the same equations with other right-hand sides,

    H dΔq̇ − J_cᵀ dλ = dJ_cᵀ λ − dH Δq̇,    J_c dΔq̇ = −dJ_c Δq̇,

since b does not change for strikes of the whole robot along fixed axes. Joint k moves all that is behind it as one rigid body, with
the twist J_k. So a column behind it changes by J_k × J_a, an inertia behind it by what the rigid motion makes of it, and dH Δq̇ is
one product of matrices (Featherstone 2008, section 5.3, of the momenta that the jump gives; Carpentier and Mansard, RSS 2018).
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from shockpc.core.impulse import Solution
from shockpc.core.inertia import solve_inertia
from shockpc.core.memo import memoized
from shockpc.core.spatial import Array, cross, cross_matrix
from shockpc.landing.contact import lowest_point_turned
from shockpc.landing.dynamics import Dynamics
from shockpc.landing.landing import Landing
from shockpc.landing.rows import Block, Equation, block_axes, block_point, block_wrenches, slices_of
from shockpc.robot.robot import Robot

BLOCK = 16
"""Postures whose maps are changed together, so that the arrays stay in the processor's cache."""


class Derivatives(NamedTuple):
    """Derivatives by the tangent of q, Pinocchio's layout, for strikes of 1 m/s along world x, y and z; NaN where there are none.

    Attributes:
        maps: (N, n, 6, 3, nv) of the jumps of bodies, world axes, at their frames' origins.
        delta_qd: (N, nv, 3, nv) of the jumps of the joint velocities.
        impulse: (N, nc, 3, nv) of the impulses along the rows; NaN where redundant rows leave them undetermined.
    """

    maps: Array
    delta_qd: Array
    impulse: Array


class _Tree(NamedTuple):
    """Which joint velocities move what.

    Attributes:
        moves: (nv, nb) 1 where one moves a body.
        turned: (nv, nv) 1 where the first moves the second's column: that of a joint behind it, or of its own joint.
        ahead: (nv, nv) 1 where the second's joint carries the first's.
    """

    moves: Array
    turned: Array
    ahead: Array


@memoized()
def _tree(robot: Robot) -> _Tree:
    carried = np.array([i for i, joint in enumerate(robot.joints) for _ in range(joint.v.start, joint.v.stop)])
    first = np.array([joint.v.start for joint in robot.single_joints for _ in range(joint.v.start, joint.v.stop)])
    ahead = robot.supports[carried] & (np.arange(len(first)) < first[:, None])
    masks = robot.supports.T, ahead.T | (first == first[:, None]), ahead
    return _Tree(*(mask.astype(float) for mask in masks))


def derivatives(
    landing: Landing, equation: Equation, solution: Solution, bodies: Sequence[int] | None = None, out: Array | None = None
) -> Derivatives:
    """The derivatives of steps 1 and 2 in N postures.

    They are those of the equations as they stand: a follower, a locked joint and one of a loop each have a column of their own, in
    which the others stay. In a posture with redundant rows they are those along which the same rows stay redundant; in one that is
    singular, where fewer rows are independent than beside it, there are none.

    Args:
        landing: the landing; strikes of a contact's own velocity are not among these.
        equation: step 1.
        solution: of it.
        bodies: indices of those whose jumps are wanted; all by default.
        out: (N, n, 6, 3, nv) into which the derivatives of the maps are written; a new array by default.
    """
    state, robot, tree = equation.state, landing.robot, _tree(landing.robot)
    n, nv, y = len(state.J), robot.model.nv, solution.delta_qd[..., :3]
    delta_qd, impulse = equation.full(y), solution.impulse[..., :3].copy()
    for k, part in solution.independent.items():
        impulse[k] = 0.0
        impulse[k, solution.choices[k].rows] = part[:, :3]
    # Components come first here, then strikes, so that every operation runs over contiguous numbers: (6, 3, N, nv).
    J = np.ascontiguousarray(state.J.swapaxes(0, 1))
    parts = J[:, None] * np.ascontiguousarray(np.moveaxis(delta_qd, 2, 0))
    # Of the twist that the jump gives to each body, what carries joint k has a share U_k, which joint k does not turn.
    U, twists = parts @ tree.ahead.T, parts @ tree.moves
    B = -_carried(J[:, None], U)
    inertia = _inertias(robot, state)
    momenta = _momenta(tuple(part[..., None, :, :] for part in inertia), twists) @ tree.moves.T
    composite = tuple(part @ tree.moves.T for part in inertia)
    A = _carried_wrench(J[:, None], momenta) + _momenta(tuple(part[..., None, :, :] for part in composite), B)
    F, columns = np.ascontiguousarray(_momenta(composite, J).transpose(1, 2, 0)), state.J.swapaxes(1, 2)
    ahead, turned = (np.ascontiguousarray(part.transpose(2, 0, 1, 3)).reshape(n, 6, -1) for part in (A, B))
    right = (-(columns @ ahead) * np.tile(tree.ahead.T, 3) - (F @ turned) * np.tile(tree.turned.T, 3)).reshape(n, nv, 3, nv)
    rows, dJ = _rows(state, equation.blocks, tree, np.ascontiguousarray(columns))
    right += np.swapaxes(impulse, 1, 2)[:, None] @ dJ.swapaxes(1, 2)
    left = np.swapaxes(delta_qd, 1, 2)[:, None] @ dJ
    if (base := _turned_columns(landing, delta_qd)) is not None:  # G changes with the posture, and q̇ = G ẏ with it
        H = state.H
        residual = H @ delta_qd - np.swapaxes(rows, -1, -2) @ impulse
        right -= (H @ base.reshape(n, nv, -1)).reshape(right.shape)
        left += (rows @ base.reshape(n, nv, -1)).reshape(left.shape)
    if equation.G is not None:
        right = (np.swapaxes(equation.G, -1, -2) @ right.reshape(n, nv, -1)).reshape(n, -1, 3, nv)
        if base is not None:
            right[:, :3] -= _turned_residual(landing, state, residual)
    d_y, d_impulse = _solved(landing, equation, solution, right.reshape(*right.shape[:2], -1), left.reshape(*left.shape[:2], -1))
    d_qd = equation.full(d_y).reshape(n, nv, 3, nv)
    if base is not None:
        d_qd += base
    chosen = slice(None) if bodies is None else list(bodies)
    position, moves, twists = state.position[:, chosen], tree.moves.T[chosen], twists[..., chosen]
    maps = np.empty((n, len(moves), 6, 3, nv)) if out is None else out
    for k in range(0, n, BLOCK):
        own = slice(k, k + BLOCK)
        _jumps(position[own], state.J[own], moves, twists[:, :, own], turned[own], d_qd[own], maps[own])
    return Derivatives(maps, d_qd, d_impulse.reshape(*d_impulse.shape[:2], 3, nv))


def _carried(x: Array, y: Array) -> Array:
    """How the rigid motion x changes a twist y (6, ...) that it carries: (ω × ω', v × ω' + ω × v')."""
    return np.concatenate([_cross(x[:3], y[:3]), _cross(x[3:], y[:3]) + _cross(x[:3], y[3:])])


def _carried_wrench(x: Array, f: Array) -> Array:
    """How the rigid motion x changes a wrench or a momentum f (6, ...) that it carries: (ω × n + v × f, ω × f)."""
    return np.concatenate([_cross(x[:3], f[:3]) + _cross(x[3:], f[3:]), _cross(x[:3], f[3:])])


def _cross(a: Array, b: Array) -> Array:
    """A × b of vectors (3, ...)."""
    (x, y, z), (u, v, w) = a, b
    first = y * w
    out = np.empty((3, *first.shape))
    np.subtract(first, z * v, out=out[0])
    np.subtract(z * u, x * w, out=out[1])
    np.subtract(x * v, y * u, out=out[2])
    return out


def _inertias(robot: Robot, state: Dynamics) -> tuple[Array, Array, Array]:
    """Mass (N, nb), its first moment (3, N, nb), and the second (3, 3, N, nb) of the bodies about the common origin."""
    R, m = state.rotation, robot.masses[:, None, None]
    c = state.position + (R @ robot.coms[..., None])[..., 0]
    C = cross_matrix(c)
    second = R @ robot.inertias @ np.swapaxes(R, -1, -2) - m * (C @ C)
    mass = np.broadcast_to(robot.masses, c.shape[:2])
    return mass, np.ascontiguousarray(np.moveaxis(mass[..., None] * c, -1, 0)), np.ascontiguousarray(second.transpose(2, 3, 0, 1))


def _momenta(inertia: tuple[Array, ...], twist: Array) -> Array:
    """Momenta (6, ...) of bodies that move with twists (6, ...): (Ī ω + m c × v, m v − m c × ω)."""
    mass, first, second = inertia
    omega, v = twist[:3], twist[3:]
    angular = _cross(first, v)
    for i, row in enumerate(second):
        for j, entry in enumerate(row):
            angular[i] += entry * omega[j]
    return np.concatenate([angular, mass * v - _cross(first, omega)])


def _rows(state: Dynamics, blocks: Sequence[Block], tree: _Tree, J: Array) -> tuple[Array, Array]:
    """The rows J_c (N, nc, nv) before any reduction, and their derivatives (N, nc, nv, nv), the last axis that of the tangent."""
    n, nv, nc = len(J), J.shape[1], sum(block.size for block in blocks)
    w, change, moved = np.zeros((n, nc, 6)), np.zeros((n, nc, 6, nv)), np.zeros((nc, nv))
    omega, v = J[..., :3], J[..., 3:]
    for block, rows in zip(blocks, slices_of(blocks), strict=True):
        forces = slice(rows.start, rows.start + len(block.forces))
        w[:, rows] = block_wrenches(state, block)
        carriers = [np.zeros(nv) if end < 0 else state.supports[end].astype(float) for end in (block.body, block.other)]
        moved[rows] = carriers[0] - carriers[1]
        point, axes = block_point(state, block), block_axes(state, block)
        d_point = (v + cross(omega, point[:, None])) * carriers[0][:, None]
        if block.lowest:
            d_point += (omega * carriers[0][:, None]) @ lowest_point_turned(block, state.rotation[:, block.body]).swapaxes(1, 2)
        pushed = cross(d_point[:, None], axes[:, : len(block.forces), None])
        change[:, forces, :3] = pushed.swapaxes(-1, -2)
        if block.axes_body >= 0:
            turned = cross((omega * state.supports[block.axes_body][:, None])[:, None], axes[:, :, None])
            change[:, forces, 3:] = turned[:, : len(block.forces)].swapaxes(-1, -2)
            change[:, forces, :3] += cross(point[:, None, None], turned[:, : len(block.forces)]).swapaxes(-1, -2)
            change[:, forces.stop : rows.stop, :3] = turned[:, len(block.forces) :].swapaxes(-1, -2)
    own = J[:, None] @ change
    # A column behind joint k changes by J_k × J_a, of which w · (J_k × J_a) = −(J_k ×* w) · J_a.
    x, f = J.transpose(2, 0, 1)[:, :, None], w.transpose(2, 0, 1)[..., None]
    own -= (J[:, None] @ np.ascontiguousarray(_carried_wrench(x, f).transpose(1, 2, 0, 3))) * tree.turned.T
    return (w @ np.swapaxes(J, 1, 2)) * moved, own * np.repeat(moved[..., None], nv, axis=-1)


def _turned_columns(landing: Landing, delta_qd: Array) -> Array | None:
    """DG ẏ (N, nv, 3, nv) where the base moves in the plane alone, whose columns are written in its axes; None where G is fixed."""
    if landing.base != "planar" or not landing.robot.free_base:
        return None
    out = np.zeros((*delta_qd.shape, delta_qd.shape[1]))
    for part in (slice(0, 3), slice(3, 6)):
        # What stays in the world turns the other way round in the base.
        out[:, part, :, 3:6] = np.swapaxes(cross(delta_qd[:, part].swapaxes(1, 2)[:, :, None], np.eye(3)), -1, -2).swapaxes(1, 2)
    return out


def _turned_residual(landing: Landing, state: Dynamics, residual: Array) -> Array:
    """dGᵀ r (N, 3, 3, nv) of what holds the base in the plane. Args: residual r (N, nv, 3), H Δq̇ − J_cᵀ λ."""
    plane, to_base = landing.plane, np.swapaxes(state.rotation[:, 0], -1, -2)
    out = np.zeros((len(residual), 3, 3, residual.shape[1]))
    for row, (axis, part) in enumerate(((plane.e1, slice(0, 3)), (plane.e2, slice(0, 3)), (plane.normal, slice(3, 6)))):
        turned = cross((to_base @ axis)[:, None], np.eye(3))
        out[:, row, :, 3:6] = np.einsum("nki,nis->nsk", turned, residual[:, part])
    return out


def _solved(landing: Landing, equation: Equation, solution: Solution, right: Array, left: Array) -> tuple[Array, Array]:
    """Derivatives of ẏ (N, ny, m) and λ (N, nc, m). Args: right (N, ny, m) and left (N, nc, m), as in the module's text."""
    J_c, scale, nc = equation.J_c, solution.scale, equation.J_c.shape[1]
    with np.errstate(all="ignore"):
        inverse = solve_inertia(equation.inertia, np.broadcast_to(np.eye(right.shape[1]), (len(right), *2 * right.shape[1:2])))
        X, Z = inverse @ np.swapaxes(J_c, -1, -2), inverse @ right
        A, c = J_c @ X, left + J_c @ Z
        if unclear := list(solution.choices):
            A[unclear] = np.eye(nc)
        scaled = A * (scale[:, :, None] * scale[:, None, :])
        scaled[unclear] = np.eye(nc)
        d_impulse = -scale[:, :, None] * np.linalg.solve(scaled, scale[:, :, None] * c)
        d_y = Z + X @ d_impulse
    most = landing.most_independent(equation.state, equation.blocks) if unclear else None
    for k, choice in solution.choices.items():
        r = choice.rows
        d_impulse[k], limit = np.nan, nc if most is None else most(k)[0]
        if choice.uncertain or len(r) < limit:
            d_y[k] = np.nan
            continue
        part = -np.linalg.solve(J_c[k][r] @ X[k][:, r], c[k][r])
        d_y[k] = Z[k] + X[k][:, r] @ part
        if len(r) == nc:
            d_impulse[k][r] = part
    return d_y, d_impulse


def _jumps(p: Array, J: Array, moves: Array, twists: Array, B: Array, d_qd: Array, out: Array) -> None:
    """Derivatives (N, n, 6, 3, nv) of the jumps of bodies at their frames' origins: by their joint velocities, and as they turn.

    A body behind joint k turns with it, ω_k × (Δω, Δv), but for the share of what carries joint k, which is in B.
    """
    (n, nb), nv = p.shape[:2], d_qd.shape[1]
    at = np.zeros((n, nb, 6, 6))  # to the frame's origin: v + ω × p
    at[..., range(6), range(6)], at[..., 3:, :3] = 1.0, -cross_matrix(p)
    at_origin = np.concatenate([twists[:3], twists[3:] + _cross(twists[:3], np.moveaxis(p, 2, 0)[:, None])])
    turning = np.zeros((n, nb, 2, 3, 3, 3))
    for row, column, other in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):  # ω × u = −[u]× ω
        turning[..., row, :, column] = at_origin[other::3].transpose(2, 3, 0, 1)
        turning[..., column, :, row] = -turning[..., row, :, column]
    shared = at.reshape(n, 6 * nb, 6) @ B
    shared += (turning.reshape(n, 18 * nb, 3) @ np.ascontiguousarray(J[:, :3])).reshape(shared.shape)
    shared *= np.repeat(np.tile(moves, 3), 6, axis=0)
    own = (at.reshape(n, 6 * nb, 6) @ J) * np.repeat(moves, 6, axis=0)
    np.matmul(own, d_qd.reshape(n, nv, 3 * nv), out=out.reshape(shared.shape))
    out += shared.reshape(out.shape)
