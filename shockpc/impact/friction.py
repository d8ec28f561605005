"""The ground beyond Eq. 4: contacts that slide (Coulomb friction), in double precision, not proven.

The inertia and the rows of a landing in its posture go to the solver of `core.friction`, in the velocities with which its loops
stay closed.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from shockpc.core.bodies import body_jumps, in_body_axes
from shockpc.core.friction import solve_friction
from shockpc.core.impulse import Solution, solve_impact
from shockpc.core.memo import memoized
from shockpc.core.spatial import Array, freeze
from shockpc.impact.impact import DoubleImpact
from shockpc.impact.solve import independent_rows, rows_as_meant
from shockpc.impact.stops import stop_rows
from shockpc.landing.contact import across
from shockpc.landing.landing import PosedLanding
from shockpc.landing.rows import Equation, slices_of
from shockpc.text.errors import SceneError, SolveError


class FrictionResult(NamedTuple):
    """A landing with Coulomb friction; contacts, then standing feet.

    Attributes:
        state: "sticks", "slides" or "separates" (takes no impulse) for each.
        velocity: (c, 3) of the contact points after the impact, world axes [m/s].
        solutions: number of solutions found. For one contact these are all.
        residual: largest deviation from Coulomb's and Newton's laws relative to the largest velocity of the contacts [1].
        energy_lost: kinetic energy that the impact takes [J].
        impact: with the impulses of friction, for the scene's own strike alone; None where all contacts stick as in Eq. 4.
    """

    state: tuple[str, ...]
    velocity: Array
    solutions: int
    residual: float
    energy_lost: float
    impact: DoubleImpact | None


class ContactRows(NamedTuple):
    """Rows of the contacts in coordinates with which loops stay closed: along two tangents of the ground and its normal.

    Attributes:
        equation: Eq. 4 of the landing.
        turn: (n, m) these rows, of those of the equation that are not of loops.
        axes: (n, 3) along which they are, world axes.
        number: (n,) contact or standing foot of each row.
        normal: (n,) whether a row is along the normal of its contact.
        restitution: (n,) e of each row: of a contact that sticks, with restitution along the normal, zero along the tangents.
        speeds: (n,) along each row before the impact [m/s].
        basis: (ny, m) the free velocities for unit coordinates.
        M: (m, m) inertia.
        J: (n, m) speeds along the rows.
    """

    equation: Equation
    turn: Array
    axes: Array
    number: np.ndarray
    normal: np.ndarray
    restitution: Array
    speeds: Array
    basis: Array
    M: Array
    J: Array


def contact_rows(landing: PosedLanding) -> ContactRows:
    """The rows of contacts and standing feet; of those that slide the normal alone. End stops are left out."""
    landing = landing.without_stops
    equation = landing.equation(landing.state)
    held = [block for block in landing.blocks if block.kind != "closure"]
    axes = [np.array([*across(block.normal), block.normal])[0 if block.size > 1 else 2 :] for block in held]
    number = np.repeat(np.arange(len(held)), [len(own) for own in axes])
    normal = np.append(number[1:] != number[:-1], True)
    e, every = (np.array(values)[number] for values in zip(*((b.restitution, b.rebound is None) for b in held), strict=True))
    turn = np.zeros((len(number), sum(block.size for block in held)))
    for k, (block, rows) in enumerate(zip(held, slices_of(held), strict=True)):
        turn[number == k, rows] = np.linalg.lstsq(block.forces.T, axes[k].T, rcond=None)[0].T
    basis, H = np.eye(equation.H.shape[1]), equation.H[0]
    if loops := landing.blocks[len(held) :]:
        K = equation.J_c[0, turn.shape[1] :][independent_rows(landing, loops)]
        basis = np.linalg.qr(K.T, mode="complete")[0][:, len(K) :]
    J_c, b = (turn @ part[: turn.shape[1]] for part in rows_as_meant(landing))
    restitution = np.where(normal | every, e, 0.0)
    M, speeds = basis.T @ H @ basis, b / (1.0 + restitution)
    return ContactRows(equation, turn, np.concatenate(axes), number, normal, restitution, speeds, basis, M, J_c @ basis)


@memoized()
def friction_of(landing: PosedLanding) -> FrictionResult:
    """The landing with the scene's coefficient of friction; its end stops are contacts without friction.

    Raises:
        SceneError: rows of contacts are redundant.
        SolveError: no solution was found, or each gains kinetic energy.
    """
    landing = landing.without_stops
    rows, mu = contact_rows(landing), landing.scene.friction
    equation, n = rows.equation, rows.turn.shape[1]
    stops, along, speeds = stop_rows(landing) if landing.scene.stops else ((), np.zeros((0, landing.robot.model.nv)), np.zeros(0))
    most = landing.most_independent(landing.state, equation.blocks)
    plain = solve_impact(equation.inertia, equation.J_c, equation.b, equation.terms, equation.tolerance, most)
    if plain.choices and not plain.choices[0].unique[:n].all():
        raise SceneError(
            "friction is solved for contacts whose impulses are determined, but here rows are redundant; leave a contact out"
        )
    before = rows.speeds.reshape(-1, 3)
    e = rows.restitution[2::3]
    assert mu is not None
    feet, k = len(e), len(stops)
    # A stop is a contact with a normal alone.
    J = np.zeros((3 * (feet + k), len(rows.M)))
    J[: 3 * feet], J[3 * feet + 2 :: 3] = rows.J, along @ (rows.basis if equation.G is None else equation.G[0] @ rows.basis)
    velocity = np.concatenate([before, np.column_stack([np.zeros((k, 2)), speeds])])
    e = np.concatenate([e, [stop.restitution for stop in stops]])
    try:
        by_impulse = np.linalg.solve(rows.M, J.T)
        found = solve_friction(J @ by_impulse, velocity, np.repeat([mu, 0.0], [feet, k]), e)
    except np.linalg.LinAlgError as refusal:
        raise SolveError(f"no verdict for a friction of {mu:g}: {refusal}") from None
    if not found:
        raise SolveError(f"no verdict: no impulse was found that obeys Coulomb's law with a friction of {mu:g}; take another one")
    # Of several solutions that in which the contacts stick is the one of Eq. 4.
    best = min(found, key=lambda solution: (solution.gains_energy, set(solution.state[:feet]) != {"sticks"}))
    if best.gains_energy:
        raise SolveError(
            f"no verdict: with a friction of {mu:g} and the restitution of the contacts the impact would gain {best.energy:.3g} J "
            "of kinetic energy (Newton's restitution is not valid where slip stops or reverses); take less restitution"
        )
    moved = rows.basis @ (by_impulse @ best.impulse.ravel())
    pushed = best.impulse[feet:, 2]
    landing, loops = replace(landing, acting=tuple(stops[i] for i in np.flatnonzero(pushed > 0.0))), len(equation.J_c[0])
    equation = landing.equation(landing.state)
    impulse = np.full((1, len(equation.J_c[0]), 4), np.nan)
    impulse[0, :n, 3], impulse[0, loops:, 3] = rows.turn.T @ best.impulse[:feet].ravel(), pushed[pushed > 0.0]
    closing = equation.H[0] @ moved - np.delete(equation.J_c[0], np.s_[n:loops], axis=0).T @ np.delete(
        impulse[0, :, 3], np.s_[n:loops]
    )
    impulse[0, n:loops, 3] = np.linalg.lstsq(equation.J_c[0, n:loops].T, closing, rcond=1e-10)[0]
    # What is linear in the strike does not exist: friction is not.
    delta = np.full((1, len(moved), 4), np.nan)
    delta[0, :, 3] = moved
    jumps = jumps_of(landing, equation.full(delta))
    freeze(impulse, delta, jumps)
    impact = DoubleImpact(landing, equation, Solution(delta, impulse, plain.scale, plain.rank, plain.condition, {}, {}), jumps)
    tangential = np.abs(before[:, :2]).max(axis=1) > 1e-12 * np.abs(before).max()
    as_proven = set(best.state[:feet]) == {"sticks"} and not np.any(tangential & (rows.restitution[::3] > 0.0))
    velocity = (best.velocity[:feet, None] @ rows.axes.reshape(-1, 3, 3))[:, 0]
    freeze(velocity, impact.delta_qd)
    return FrictionResult(best.state[:feet], velocity, len(found), best.residual, -best.energy, None if as_proven else impact)


def gains_with_friction(impact: DoubleImpact) -> np.ndarray:
    """Whether (N, S) the scene's friction with the contacts' restitution is refused, as by `friction_of`, for a gain of energy.

    A contact gives λ_n (−(1 − e) |v_n⁻| − µ (|v_t⁺| + d·v_t⁻)) / 2 of it, with the direction d of the slip, so that only landings
    with (1 − e) |v_n⁻| < µ |v_t⁻| at a contact are solved. Without restitution none gains: λᵀ v⁺ ≤ 0.
    """
    landing, state, H, velocity = impact.landing, impact.state, impact.state.H, impact.base_velocities
    refused, mu = np.zeros(velocity.shape[:2], dtype=bool), landing.scene.friction
    e, normals = (np.array(values) for values in zip(*((c.restitution, c.normal) for c in landing.contacts), strict=True))
    if mu is None or not e.any():
        return refused
    along = np.sum(impact.approach * normals, axis=-1)
    across = np.linalg.norm(impact.approach - along[..., None] * normals, axis=-1)
    for i, s in np.argwhere(((1.0 - e) * np.abs(along) < mu * across).any(axis=-1)).tolist():
        row, before = slice(i, i + 1), landing.before._replace(velocity=velocity[i, s])
        moving = landing.motions(row) if landing.before.velocity.ndim > 1 else replace(landing, before=before)
        own = {part: getattr(state, part)[row] for part in ("J", "rotation", "position", "origin", "Q")}
        try:
            friction_of(replace(moving, state=state._replace(inertia=H[row], **own)))
        except (SceneError, SolveError):
            refused[i, s] = True
    return refused


def jumps_of(landing: PosedLanding, delta_qd: Array) -> Array:
    """Jumps (1, nb, 6, k) of the bodies, body axes, for jumps (1, nv, k) of the joint velocities."""
    robot, state = landing.robot, landing.state
    jumps = body_jumps(state.J, [joint.v for joint in robot.joints], robot.parents, state.position, delta_qd)
    return in_body_axes(jumps, state.rotation)
