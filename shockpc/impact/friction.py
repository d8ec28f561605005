"""The ground beyond Eq. 4: contacts that slide (Coulomb friction), in double precision, not proven.

A contact that is stopped along one direction of the ground alone has friction along that one. A flat contact does not tilt, nor
twist if it is stopped in all directions, as in Eq. 4: its moments are as large as that takes, whatever the friction.

The inertia and the rows of a landing in its posture go to the solver of `core.friction`, in the velocities with which its loops
stay closed.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from shockpc.core.bodies import body_jumps, in_body_axes
from shockpc.core.friction import FrictionImpact, solve_friction
from shockpc.core.impulse import Solution
from shockpc.core.memo import memoized
from shockpc.core.spatial import Array, freeze
from shockpc.impact.impact import DoubleImpact
from shockpc.impact.solve import independent_rows, rows_as_meant, solve_in_doubles
from shockpc.impact.stops import stop_rows
from shockpc.landing.contact import across
from shockpc.landing.landing import PosedLanding, contact_velocity
from shockpc.landing.motion import approach_speeds
from shockpc.landing.rows import NO_AXES, Block, Equation, block_wrenches, slices_of
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
    """Rows of the contacts, in coordinates with which what is held rigidly stays so.

    They are along the tangents of the ground along which a contact is stopped, none to two, and along its normal.

    Attributes:
        equation: Eq. 4 of the landing.
        rigid: (nc,) which rows of the equation are held rigidly: of loops, the tilt of soles, and of feet that stay where they are.
        turn: (n, nc) the rows of contacts, of those of the equation.
        axes: (n, 3) along which they are, world axes.
        number: (n,) contact or standing foot of each row.
        place: (n,) tangent 0 or 1, or normal 2, of each row.
        restitution: (n,) e of each row: of a contact that sticks, with restitution along the normal, zero along the tangents.
        speeds: (n,) along each row before the impact, and after what is held rigidly has stopped [m/s].
        stop: (ny,) jump with which a sole that turns stops turning [rad/s, m/s].
        basis: (ny, m) the free velocities for unit coordinates.
        M: (m, m) inertia.
        J: (n, m) speeds along the rows.
    """

    equation: Equation
    rigid: np.ndarray
    turn: Array
    axes: Array
    number: np.ndarray
    place: np.ndarray
    restitution: Array
    speeds: Array
    stop: Array
    basis: Array
    M: Array
    J: Array

    @property
    def normal(self) -> np.ndarray:
        """Whether each row (n,) is along the normal of its contact."""
        return np.asarray(self.place == 2)


def contact_rows(landing: PosedLanding, stands: bool = False) -> ContactRows:
    """The rows of contacts and standing feet; of a contact that slides along a direction, the others. End stops are left out.

    Args:
        landing: in its posture.
        stands: whether standing feet stay where they are, as in Eq. 4, and have no rows of their own.
    """
    landing = landing.without_stops
    equation, blocks = landing.equation(landing.state), landing.blocks
    own = [k for k, block in enumerate(blocks) if block.kind == "contact" or (block.kind == "stance" and not stands)]
    sides = [_axes(blocks[k]) for k in own]
    axes, place = (np.concatenate(part) for part in zip(*sides, strict=True))
    number = np.repeat(np.arange(len(own)), [len(part) for part, _ in sides])
    e, every = (
        np.array(part)[number] for part in zip(*((blocks[k].restitution, blocks[k].rebound is None) for k in own), strict=True)
    )
    restitution = np.where((place == 2) | every, e, 0.0)
    turn, rigid = np.zeros((len(number), len(equation.J_c[0]))), np.ones(len(equation.J_c[0]), dtype=bool)
    for k, (i, (along, _)) in enumerate(zip(own, sides, strict=True)):
        forces = slice(start := slices_of(blocks)[i].start, start + len(blocks[i].forces))
        turn[number == k, forces] = np.linalg.lstsq(blocks[i].forces.T, along.T, rcond=None)[0].T
        rigid[forces] = False
    basis, H = np.eye(equation.H.shape[1]), equation.H[0]
    stop, (J, b) = np.zeros(len(H)), rows_as_meant(landing)
    held = tuple(block._replace(forces=NO_AXES) if i in own else block for i, block in enumerate(blocks))
    if rigid.any():
        chosen = np.flatnonzero(rigid)[independent_rows(landing, tuple(block for block in held if block.size))]
        K, by_impulse = equation.J_c[0, chosen], np.linalg.solve(H, equation.J_c[0, chosen].T)
        stop = -by_impulse @ np.linalg.solve(K @ by_impulse, equation.b[0, chosen, 3])
        basis = np.linalg.qr(K.T, mode="complete")[0][:, len(K) :]
    speeds = turn @ b / (1.0 + restitution) + turn @ J @ stop
    return ContactRows(
        equation, rigid, turn, axes, number, place, restitution, speeds, stop, basis, basis.T @ H @ basis, turn @ J @ basis
    )


def _axes(block: Block) -> tuple[Array, np.ndarray]:
    """The axes (n, 3) of a contact: tangents of the ground along which it is stopped, and the normal; and which (n,) they are."""
    basis = np.linalg.svd(block.forces)[2][: (rank := np.linalg.matrix_rank(block.forces))]
    if rank == 3:
        return np.array([*across(block.normal), block.normal]), np.arange(3)
    if rank == 1:
        return block.normal[None], np.array([2])
    return np.array([np.cross(np.cross(*basis), block.normal), block.normal]), np.array([0, 2])


class FrictionProblem(NamedTuple):
    """What an impact with friction depends on in one posture, whatever the friction of its contacts and standing feet.

    The m contacts are these, and behind them the end stops, which are contacts without friction.

    Attributes:
        rows: of the contacts and standing feet.
        own: (n,) which of their rows, two tangents and a normal each, these are; nothing moves along the others.
        stops: blocks of the end stops.
        A: (3m, 3m) Delassus matrix [1/kg].
        before: (m, 3) velocities along these rows before the impact [m/s].
        restitution: (m,) e of the scene.
        by_impulse: (ny, 3m) jumps of the free velocities for unit impulses.
    """

    rows: ContactRows
    own: np.ndarray
    stops: tuple[Block, ...]
    A: Array
    before: Array
    restitution: Array
    by_impulse: Array

    @property
    def contacts(self) -> int:
        """Number of contacts and standing feet."""
        return len(self.before) - len(self.stops)

    def solved(self, mu: float, restitution: Array | float | None = None) -> tuple[FrictionImpact, int]:
        """The impact with a coefficient of friction, and the number of solutions that were found.

        Args:
            mu: the coefficient.
            restitution: of the contacts and standing feet along their normals; by default the scene's.

        Raises:
            SolveError: no solution was found, or each gains kinetic energy.
        """
        e, m = self.restitution.copy(), self.contacts
        if restitution is not None:
            e[:m] = restitution
        try:
            found = solve_friction(self.A, self.before, np.repeat([mu, 0.0], [m, len(self.stops)]), e)
        except np.linalg.LinAlgError as refusal:
            raise SolveError(f"no verdict for a friction of {mu:g}: {refusal}") from None
        if not found:
            raise SolveError(
                f"no verdict: no impulse was found that obeys Coulomb's law with a friction of {mu:g}; take another one"
            )
        # Of several solutions that in which the contacts stick is the one of Eq. 4.
        best = min(found, key=lambda solution: (solution.gains_energy, set(solution.state[:m]) != {"sticks"}))
        if best.gains_energy:
            gained = f"with friction {mu:g} and the restitution of the contacts the impact would gain {best.energy:.3g} J"
            raise SolveError(
                f"no verdict: {gained} of kinetic energy (Newton's restitution is not valid where slip stops or reverses); take "
                "less restitution"
            )
        return best, len(found)

    def scaled(self, factor: float) -> "FrictionProblem":
        """The same with all velocities before the impact times a factor above zero."""
        return (
            self
            if factor == 1.0
            else self._replace(before=factor * self.before, rows=self.rows._replace(stop=factor * self.rows.stop))
        )

    def delta(self, impulse: Array) -> Array:
        """Jumps (ny,) of the free velocities. Args: impulse (m, 3) of the contacts [N s]."""
        return np.asarray(self.rows.stop + self.by_impulse @ impulse.ravel())


def friction_problem(landing: PosedLanding) -> FrictionProblem:
    """The problem of a landing with friction.

    Raises:
        SolveError: the inertia matrix is singular.
    """
    landing = landing.without_stops
    rows = contact_rows(landing)
    own, m = 3 * rows.number + rows.place, int(rows.number[-1]) + 1
    nothing: tuple[tuple[Block, ...], Array, Array] = ((), np.zeros((0, landing.robot.model.nv)), np.zeros(0))
    stops, along, speeds = stop_rows(landing) if landing.scene.stops else nothing
    along = along if rows.equation.G is None else along @ rows.equation.G[0]
    before, J = np.zeros(3 * (m + len(stops))), np.zeros((3 * (m + len(stops)), len(rows.M)))
    before[own], J[own] = rows.speeds, rows.J
    before[3 * m + 2 :: 3], J[3 * m + 2 :: 3] = speeds + along @ rows.stop, along @ rows.basis
    e = np.concatenate([rows.restitution[rows.normal], [stop.restitution for stop in stops]])
    try:
        by_impulse = np.linalg.solve(rows.M, J.T)
    except np.linalg.LinAlgError as refusal:
        raise SolveError(f"no verdict with friction: {refusal}") from None
    return FrictionProblem(rows, own, stops, J @ by_impulse, before.reshape(-1, 3), e, rows.basis @ by_impulse)


@memoized()
def friction_of(landing: PosedLanding) -> FrictionResult:
    """The landing with the scene's coefficient of friction; its end stops are contacts without friction.

    Raises:
        SceneError: rows of contacts are redundant.
        SolveError: no solution was found, or each gains kinetic energy.
    """
    landing = landing.without_stops
    problem, mu = friction_problem(landing), landing.scene.friction
    rows, own, m = problem.rows, problem.own, problem.contacts
    before, equation = problem.before[:m], rows.equation
    plain = solve_in_doubles(landing, equation)
    if plain.choices and not plain.choices[0].unique[~rows.rigid].all():
        raise SceneError(
            "friction is solved for contacts whose impulses are determined, but here rows are redundant; leave a contact out"
        )
    assert mu is not None
    best, count = problem.solved(mu)
    moved, pushed = problem.delta(best.impulse), best.impulse[m:, 2]
    landing = replace(landing, acting=tuple(problem.stops[i] for i in np.flatnonzero(pushed > 0.0)))
    equation, own_rows = landing.equation(landing.state), len(rows.rigid)
    impulse = np.full((1, len(equation.J_c[0]), 4), np.nan)
    impulse[0, :own_rows, 3], impulse[0, own_rows:, 3] = rows.turn.T @ best.impulse[:m].ravel()[own], pushed[pushed > 0.0]
    closing, rigid = equation.H[0] @ moved - equation.J_c[0].T @ impulse[0, :, 3], np.flatnonzero(rows.rigid)
    impulse[0, rigid, 3] = np.linalg.lstsq(equation.J_c[0, rigid].T, closing, rcond=1e-10)[0]
    # What is linear in the strike does not exist: friction is not.
    delta = np.full((1, len(moved), 4), np.nan)
    delta[0, :, 3] = moved
    jumps = jumps_of(landing, equation.full(delta))
    freeze(impulse, delta, jumps)
    impact = DoubleImpact(landing, equation, Solution(delta, impulse, plain.scale, plain.rank, plain.condition, {}, {}), jumps)
    tangential = np.abs(before[:, :2]).max(axis=1) > 1e-12 * np.abs(before).max()
    bounces = np.zeros(m, dtype=bool)
    bounces[rows.number[rows.place < 2]] = rows.restitution[rows.place < 2] > 0.0
    as_proven = set(best.state[:m]) == {"sticks"} and not np.any(tangential & bounces)
    axes = np.zeros((3 * m, 3))
    axes[own] = rows.axes
    velocity = (best.velocity[:m, None] @ axes.reshape(-1, 3, 3))[:, 0]
    velocity += _free_slip(landing, axes.reshape(-1, 3, 3), equation.full(delta)[..., 3])
    stilled = tuple(block._replace(restitution=0.0) for block in landing.blocks)
    rates = approach_speeds(landing.state, stilled, landing.before)[0, :, 3]
    lost = -float(np.nan_to_num(impulse[0, :, 3]) @ (rates + equation.J_c[0] @ moved / 2.0))
    freeze(velocity, impact.delta_qd)
    return FrictionResult(best.state[:m], velocity, count, best.residual, lost, None if as_proven else impact)


def _free_slip(landing: PosedLanding, axes: Array, delta_qd: Array) -> Array:
    """Velocities (m, 3) of contacts after the impact along the directions in which they slide freely, world axes [m/s].

    Args:
        landing: in its posture.
        axes: (m, 3, 3) along which each contact is stopped; the others zero.
        delta_qd: (1, nv) jumps of the joint velocities.
    """
    slip, state = np.zeros((len(axes), 3)), landing.state
    for k in np.unique(np.argwhere(~axes.any(axis=2))[:, 0]).tolist():
        block = landing.blocks[k]
        jump = (block_wrenches(state, block._replace(forces=np.eye(3), moments=NO_AXES)) @ state.J)[0]
        jump = (jump * state.supports[block.body]) @ delta_qd[0]
        slip[k] = (np.eye(3) - axes[k].T @ axes[k]) @ (contact_velocity(landing, state, block)[0] + jump)
    return slip


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
