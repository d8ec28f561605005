"""The ground beyond Eq. 4: contacts that slide (Coulomb friction), and contacts of finite stiffness.

Both take the inertia and the rows of a landing in its posture, in the velocities with which its loops stay closed, to the solvers
of `core.friction` and `core.stiffness`. All is in double precision and not proven.
"""

import functools
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from shockpc.core.bodies import body_jumps, in_body_axes
from shockpc.core.friction import solve_friction
from shockpc.core.impulse import Solution, solve_impact
from shockpc.core.spatial import Array, freeze
from shockpc.core.stiffness import Elements, Motion, simulate_landing
from shockpc.errors import SceneError, SolveError
from shockpc.exact.proof import motion as size_of
from shockpc.impact import DoubleImpact
from shockpc.landing import PosedLanding
from shockpc.model.contact import across
from shockpc.model.rows import Block, Equation, row_jacobian
from shockpc.places import Place
from shockpc.solve import independent_rows

__all__ = ["FrictionResult", "StiffnessResult", "friction_of", "stiffness_of"]

LEAST_MOTION = 1e-9
"""Share of the fastest body's jump below which a body counts as moved by it, where jumps are compared."""


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


class StiffnessResult(NamedTuple):
    """A landing on contacts of finite stiffness.

    Attributes:
        motion: until all contacts are open.
        full: (nv, n) joint velocities for unit velocities of the coordinates of the motion.
        duration: (c,) time at which each contact opens for the last time [s].
        force: (c,) peak force of each contact, tangential parts included [N].
        force_time: (c,) when it is reached [s].
        torque: (nv,) peak of what the drive of each joint carries along its axis [N m, N]; NaN where loops are closed.
        difference: largest difference between the jumps of a body at the end and in the impulse model, relative to the latter [1].
    """

    motion: Motion
    full: Array
    duration: Array
    force: Array
    force_time: Array
    torque: Array
    difference: float

    def accelerations(self, landing: PosedLanding, places: Sequence[Place]) -> tuple[Array, Array]:
        """Peak accelerations (n,) of points [m/s²], and when (n,) they are reached [s]."""
        points = [Block("contact", place.name, place.body, place.r, np.eye(3)) for place in places]
        rows = row_jacobian(landing.state, points)[0] @ self.full
        return _peak(self.motion, rows.reshape(len(places), 3, -1))


class _Rows(NamedTuple):
    """Rows of the contacts in coordinates with which loops stay closed.

    Attributes:
        landing: with these rows.
        equation: Eq. 4 of it.
        n: number of rows that are not of loops.
        restitution: (n,) e of each row.
        basis: (ny, m) the free velocities for unit coordinates.
        M: (m, m) inertia.
        J: (n, m) speeds along the rows.
    """

    landing: PosedLanding
    equation: Equation
    n: int
    restitution: Array
    basis: Array
    M: Array
    J: Array


def _rows_of(landing: PosedLanding) -> _Rows:
    """The rows, those of contacts that stick along two tangents of the ground and its normal."""
    axes = np.array([*across(landing.up), landing.up])

    def turned(block: Block) -> Block:
        return block._replace(forces=axes) if np.linalg.matrix_rank(block.forces) == 3 else block

    landing = replace(landing, contacts=tuple(map(turned, landing.contacts)), stance=tuple(map(turned, landing.stance)))
    equation = landing.equation(landing.state)
    held = [block for block in landing.blocks if block.kind != "closure"]
    restitution = np.repeat([block.restitution for block in held], [block.size for block in held])
    n, H = len(restitution), equation.H[0]
    basis = np.eye(len(H))
    if loops := landing.blocks[len(held) :]:
        K = equation.J_c[0, n:][independent_rows(landing, loops)]
        basis = np.linalg.qr(K.T, mode="complete")[0][:, len(K) :]
    return _Rows(landing, equation, n, restitution, basis, basis.T @ H @ basis, equation.J_c[0, :n] @ basis)


@functools.lru_cache(maxsize=4)
def friction_of(landing: PosedLanding) -> FrictionResult:
    """The landing with the scene's coefficient of friction.

    Raises:
        SceneError: rows of contacts are redundant.
        SolveError: no solution was found, or each gains kinetic energy.
    """
    rows, mu = _rows_of(landing), landing.scene.friction
    equation, n = rows.equation, rows.n
    plain = solve_impact(equation.inertia, equation.J_c, equation.b, equation.terms)
    if plain.choices and not plain.choices[0].unique[:n].all():
        raise SceneError(
            "friction is solved for contacts whose impulses are determined, but here rows are redundant; leave a contact out"
        )
    before = (equation.b[0, :n, 3] / (1.0 + rows.restitution)).reshape(-1, 3)
    e = rows.restitution[::3]
    assert mu is not None
    try:
        by_impulse = np.linalg.solve(rows.M, rows.J.T)
        found = solve_friction(rows.J @ by_impulse, before, np.full(len(e), mu), e)
    except np.linalg.LinAlgError as refusal:
        raise SolveError(f"no verdict for a friction of {mu:g}: {refusal}") from None
    if not found:
        raise SolveError(f"no verdict: no impulse was found that obeys Coulomb's law with a friction of {mu:g}; take another one")
    # Of several solutions that in which the contacts stick is the one of Eq. 4.
    best = min(found, key=lambda solution: (solution.gains_energy, set(solution.state) != {"sticks"}))
    if best.gains_energy:
        raise SolveError(
            f"no verdict: with a friction of {mu:g} and the restitution of the contacts the impact would gain {best.energy:.3g} J "
            "of kinetic energy (Newton's restitution is not valid where slip stops or reverses); take less restitution"
        )
    moved = rows.basis @ (by_impulse @ best.impulse.ravel())
    impulse = np.full((1, len(equation.J_c[0]), 4), np.nan)
    impulse[0, :n, 3] = best.impulse.ravel()
    closing = equation.H[0] @ moved - equation.J_c[0, :n].T @ impulse[0, :n, 3]
    impulse[0, n:, 3] = np.linalg.lstsq(equation.J_c[0, n:].T, closing, rcond=1e-10)[0]
    # What is linear in the strike does not exist: friction is not.
    delta = np.full((1, len(moved), 4), np.nan)
    delta[0, :, 3] = moved
    jumps = _jumps(landing, equation.full(delta))
    freeze(impulse, delta, jumps)
    impact = DoubleImpact(landing, equation, Solution(delta, impulse, plain.scale, plain.rank, plain.condition, {}, {}), jumps)
    tangential = np.abs(before[:, :2]).max(axis=1) > 1e-12 * np.abs(before).max()
    as_proven = set(best.state) == {"sticks"} and not np.any(tangential & (e > 0.0))
    velocity = best.velocity @ rows.landing.contacts[0].forces
    freeze(velocity, impact.delta_qd)
    return FrictionResult(best.state, velocity, len(found), best.residual, -best.energy, None if as_proven else impact)


@functools.lru_cache(maxsize=4)
def stiffness_of(landing: PosedLanding) -> StiffnessResult:
    """The landing on contacts of the scene's stiffness, with the restitution of the contacts.

    Raises:
        SolveError: the motion cannot be followed.
    """
    rows, k, up = _rows_of(landing), landing.scene.contact_stiffness, landing.up
    assert k is not None
    equation, state = rows.equation, landing.state
    full = rows.basis if equation.G is None else equation.G[0] @ rows.basis
    before = landing.before.joint_rates.copy()
    before[:6] = np.linalg.solve(state.J[0, :, :6], np.concatenate([landing.before.omega, landing.before.velocity]))
    axes = np.concatenate([block.forces for block in rows.landing.contacts])
    number = np.repeat(np.arange(len(landing.contacts)), [block.size for block in rows.landing.contacts])
    normal = np.abs(axes @ up) > 1.0 - 1e-9
    sign = np.where(normal, np.sign(axes @ up), 1.0)
    elements = Elements(rows.J * sign[:, None], np.full(rows.n, k), rows.restitution, number, normal)
    try:
        motion = simulate_landing(rows.M, elements, np.linalg.lstsq(full, before, rcond=None)[0])
        force, force_time = _peak(motion, None, np.stack([np.diag(1.0 * (number == c)) for c in range(len(landing.contacts))]))
        torque = np.full(len(full), np.nan)
        columns = [joint.v.start for joint in landing.robot.single_joints if joint.v.stop - joint.v.start == 1]
        if columns and not landing.loops:
            # A drive carries what moves its rotor; of a joint that is locked or geared to others, what its axis needs beside that.
            armature, G = landing.joint_model.armature, np.eye(len(full)) if equation.G is None else equation.G[0]
            own = np.any(G[:, np.count_nonzero(G, axis=0) == 1] != 0.0, axis=1)
            inertial = np.where(own[:, None], -armature[:, None] * full, (state.H[0] - np.diag(armature)) @ full)
            contact = row_jacobian(state, rows.landing.blocks)[0] * sign[:, None] * ~own
            torque[columns] = _peak(motion, inertial[columns, None], -contact.T[columns, None])[0]
    except (ArithmeticError, np.linalg.LinAlgError) as refusal:
        raise SolveError(f"no verdict for contacts of {k:g} N/m: {refusal}") from None
    opened = [[event.time for event in motion.events if event.kind == "opens" and number[event.element] == c] for c in set(number)]
    plain = solve_impact(equation.inertia, equation.J_c, equation.b, equation.terms)
    jump = full @ motion.at(np.array([motion.duration])).jump[0]
    jumps = _jumps(landing, np.stack([jump, equation.full(plain.delta_qd)[0, :, 3]], axis=-1)[None])[0]
    difference, own = size_of(np.stack([jumps[..., 0] - jumps[..., 1], jumps[..., 1]], axis=-1), landing.robot.rotation_lengths).T
    relative = float(np.max(difference / np.maximum(own, LEAST_MOTION * own.max())))
    freeze(full, force, force_time, torque, duration := np.array([max(times) for times in opened]))
    return StiffnessResult(motion, full, duration, force, force_time, torque, relative)


def _jumps(landing: PosedLanding, delta_qd: Array) -> Array:
    """Jumps (1, nb, 6, k) of the bodies, body axes, for jumps (1, nv, k) of the joint velocities."""
    robot, state = landing.robot, landing.state
    jumps = body_jumps(state.J, [joint.v for joint in robot.joints], robot.parents, state.position, delta_qd)
    return in_body_axes(jumps, state.rotation)


def _peak(motion: Motion, acceleration: Array | None, force: Array | None = None) -> tuple[Array, Array]:
    """As `Motion.peak`, with accelerations left out."""
    if acceleration is None:
        assert force is not None
        acceleration = np.zeros((*force.shape[:2], len(motion.to_velocity)))
    return motion.peak(acceleration, force)
