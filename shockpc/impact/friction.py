"""The ground beyond Eq. 4: contacts that slide (Coulomb friction), in double precision, not proven.

A contact that is stopped along one direction of the ground alone has friction along that one. A
flat contact does not tilt, nor twist if it is stopped in all directions, as in Eq. 4: its moments
are as large as that takes, whatever the friction.

The inertia and the rows of a landing in its posture go to the solver of `core.coulomb`, in the
velocities with which its loops stay closed.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from shockpc.core.coulomb import FrictionImpact, solve_each, solve_friction
from shockpc.core.impulse import Solution
from shockpc.core.inertia import solve_inertia
from shockpc.core.memo import memoized
from shockpc.core.spatial import Array, freeze
from shockpc.impact.contact_rows import ContactRows, contact_rows, row_layout
from shockpc.impact.impact import DoubleImpact, jumps_in_body_axes
from shockpc.impact.landed import solution_in_doubles
from shockpc.impact.stops import stop_rows
from shockpc.landing.landing import Landing, PosedLanding, contact_velocity
from shockpc.method.approach import approach_speeds
from shockpc.method.constraints import NO_AXES, ConstraintBlock, block_wrenches
from shockpc.method.equation import Equation
from shockpc.text.errors import SolveError


class FrictionResult(NamedTuple):
    """A landing with Coulomb friction; contacts, then standing feet.

    Attributes:
        state: "sticks", "slides" or "separates" (takes no impulse) for each.
        velocity: (c, 3) of the contact points after the impact, world axes [m/s].
        solutions: number of solutions found. For one contact these are all.
        residual: largest deviation from Coulomb's and Newton's laws relative to the largest
            velocity of the contacts [1].
        energy_lost: kinetic energy that the impact takes [J].
        impact: with the impulses of friction, for the scene's strike only; None where all contacts
            stick as in Eq. 4.
    """

    state: tuple[str, ...]
    velocity: Array
    solutions: int
    residual: float
    energy_lost: float
    impact: DoubleImpact | None


class FrictionProblem(NamedTuple):
    """What impacts with friction depend on in N postures, for S strikes each, whatever the friction
    and the restitution.

    The m contacts are the contacts and standing feet, and behind them the end stops, which are
    contacts without friction. Each has three rows, two tangents and a normal; nothing moves along
    those in which a contact is not stopped.

    Attributes:
        A: (N, 3m, 3m) Delassus matrices [1/kg].
        before: (N, S, m, 3) velocities along the rows before the impact [m/s].
        restitution: (N, m) e of the scene along the normals.
        stops: number of end stops.
        by_impulse: (N, ny, 3m) jumps of the free velocities for unit impulses.
        stop: (N, ny) jumps with which what turns on a sole stops turning, whatever the impulses
            [rad/s, m/s].
    """

    A: Array
    before: Array
    restitution: Array
    stops: int
    by_impulse: Array
    stop: Array

    def impulses(
        self, mu: Array | float, restitution: float | None = None
    ) -> tuple[Array, dict[int, SolveError]]:
        """The impulses (N, S, 3m) of the contacts [N s], NaN where there are none, and the first
        reason why in each posture.

        Args:
            mu: of each posture (N,), or of all.
            restitution: of the contacts and standing feet along their normals; by default the
                scene's.
        """
        (N, S, m, _), failures = self.before.shape, dict[int, SolveError]()
        mu = np.broadcast_to(mu, N)
        impulses = np.full((N, S, 3 * m), np.nan)
        if m == 1:
            A, before, each = (
                np.repeat(self.A, S, axis=0),
                self.before.reshape(-1, 3),
                np.repeat(mu, S),
            )
            e = (
                np.repeat(self.restitution, S)
                if restitution is None
                else np.full(N * S, restitution)
            )
            known = np.isfinite(A).all(axis=(1, 2)) & np.isfinite(before).all(axis=1)
            impulses.reshape(-1, 3)[known] = solve_each(
                A[known], before[known], each[known], e[known]
            )
        for i, s in np.argwhere(np.isnan(impulses).any(axis=2)).tolist():
            try:
                impulses[i, s] = self.solved(float(mu[i]), restitution, (i, s))[0].impulse.ravel()
            except SolveError as error:
                failures.setdefault(i, error)
        return impulses, failures

    def solved(
        self, mu: float, restitution: float | None = None, of: tuple[int, int] = (0, 0)
    ) -> tuple[FrictionImpact, int]:
        """One impact with a coefficient of friction, and the number of solutions that were found.

        Args:
            mu: the coefficient.
            restitution: as for `impulses`.
            of: posture and strike.

        Raises:
            SolveError: no solution was found, or each gains kinetic energy.
        """
        e, m = self.restitution[of[0]].copy(), self.contacts
        if restitution is not None:
            e[:m] = restitution
        try:
            solutions = solve_friction(
                self.A[of[0]], self.before[of], np.repeat([mu, 0.0], [m, self.stops]), e
            )
        except (np.linalg.LinAlgError, ValueError) as refusal:
            raise SolveError(f"no verdict for a friction of {mu:g}: {refusal}") from None
        if not solutions:
            raise SolveError(
                f"no verdict: no impulse was found that obeys Coulomb's law with a friction of "
                f"{mu:g}; take another one"
            )
        # Of several solutions that in which the contacts stick is the one of Eq. 4.
        best = min(
            solutions,
            key=lambda solution: (solution.gains_energy, set(solution.state[:m]) != {"sticks"}),
        )
        if best.gains_energy:
            gained = (
                f"with friction {mu:g} and the restitution of the contacts the impact would gain "
                f"{best.energy:.3g} J"
            )
            raise SolveError(
                f"no verdict: {gained} of kinetic energy (Newton's restitution is not valid where "
                f"slip stops or reverses); take "
                "less restitution"
            )
        return best, len(solutions)

    @property
    def contacts(self) -> int:
        """Number of contacts and standing feet."""
        return int(self.restitution.shape[1]) - self.stops

    def part(self, postures: np.ndarray) -> "FrictionProblem":
        """The same in some of the postures."""
        return FrictionProblem._make(
            part[postures] if isinstance(part, np.ndarray) else part for part in self
        )

    def scaled(self, factor: float) -> "FrictionProblem":
        """The same with all velocities before the impact times a factor above zero."""
        return self._replace(before=factor * self.before, stop=factor * self.stop)

    def delta(self, impulses: Array) -> Array:
        """Jumps (N, S, ny) of the free velocities.

        Args: impulses (N, S, 3m), as `impulses` gives them.
        """
        return np.asarray(self.stop[:, None] + impulses @ np.swapaxes(self.by_impulse, 1, 2))


def friction_problem(landing: PosedLanding) -> FrictionProblem:
    """The problem of a landing in its posture, with its strike.

    Raises:
        SolveError: the inertia matrix is singular.
    """
    return _problem_of(landing.without_stops)[0]


def _problem_of(
    landing: PosedLanding,
) -> tuple[FrictionProblem, ContactRows, tuple[ConstraintBlock, ...]]:
    """The problem, the rows of contacts and standing feet, and the end stops."""
    rows = contact_rows(landing)
    m = int(rows.number[-1]) + 1
    nothing: tuple[tuple[ConstraintBlock, ...], Array, Array] = (
        (),
        np.zeros((0, landing.robot.model.nv)),
        np.zeros(0),
    )
    stops, along, speeds = stop_rows(landing) if landing.scene.stops else nothing
    along = along if rows.equation.G is None else along @ rows.equation.G[0]
    before, J = np.zeros(3 * (m + len(stops))), np.zeros((3 * (m + len(stops)), len(rows.M)))
    before[rows.index], J[rows.index] = rows.speeds, rows.J
    before[3 * m + 2 :: 3], J[3 * m + 2 :: 3] = speeds + along @ rows.stop, along @ rows.basis
    e = np.concatenate([rows.restitution[rows.normal], [stop.restitution for stop in stops]])
    try:
        by_impulse = np.linalg.solve(rows.M, J.T)
    except np.linalg.LinAlgError as refusal:
        raise SolveError(f"no verdict with friction: {refusal}") from None
    A, velocities = (J @ by_impulse)[None], before.reshape(1, 1, -1, 3)
    problem = FrictionProblem(
        A, velocities, e[None], len(stops), (rows.basis @ by_impulse)[None], rows.stop[None]
    )
    return problem, rows, stops


def friction_problems(
    landing: Landing, equation: Equation, speeds: Array
) -> tuple[FrictionProblem, Array] | None:
    """The problem in N postures, in each of which all rows are independent, and the rows (3m, nc)
    of contacts in those of Eq. 4.

    Args:
        landing: the landing, without end stops.
        equation: Eq. 4 in the postures.
        speeds: (N, S, nc) that each strike's impact undoes along its rows [m/s].

    Returns: None where rows are held rigidly, so that each posture has a separate problem, as
        `friction_problem` has it.
    """
    layout = row_layout(equation.blocks)
    e, normal = layout.restitution, layout.place == 2
    if layout.rigid.any() or landing.scene.stops:
        return None
    to_contacts = np.zeros((3 * (int(layout.number[-1]) + 1), len(layout.rigid)))
    to_contacts[layout.index] = layout.turn / (1.0 + e)[:, None]
    before = (speeds @ to_contacts.T).reshape(*speeds.shape[:2], -1, 3)
    to_contacts[layout.index] = layout.turn
    J = to_contacts @ equation.J_c
    by_impulse = solve_inertia(equation.inertia, np.swapaxes(J, 1, 2))
    restitution = np.broadcast_to(e[normal], (len(J), np.sum(normal)))
    return FrictionProblem(
        J @ by_impulse, before, restitution, 0, by_impulse, np.zeros(by_impulse.shape[:2])
    ), to_contacts


def joined(problems: Sequence[FrictionProblem]) -> FrictionProblem:
    """Problems with as many contacts, stops, free velocities and strikes each as one, in the
    postures of all of them.
    """
    parts = zip(*problems, strict=True)
    return FrictionProblem._make(
        np.concatenate(part) if isinstance(part[0], np.ndarray) else part[0] for part in parts
    )


class _Slipping(DoubleImpact):
    """An impact with friction in N postures for S strikes: its columns are of unit impulses along
    the 3m rows of contacts.
    """

    impulses: Array
    """(N, S, 3m) along these rows [N s]; NaN where an impact has to be looked at by itself."""

    def along(self, columns: Any) -> Any:
        """Columns (N, ..., 3m) for the impulses of each strike (N, S, ...)."""
        return np.einsum("n...k,nsk->ns...", columns, self.impulses)


@memoized()
def with_friction(impact: DoubleImpact) -> _Slipping | None:
    """An impact in N postures for S strikes with the scene's friction, as `friction_of` has each;
    computed once.

    Returns: None where it has to be computed in each posture by itself, because flat contacts or
        loops hold rows rigidly, or stops count. Quantities are NaN where that holds for one
        posture: rows are redundant, or friction has no solution.
    """
    landing, equation, mu = impact.landing, impact.equation, impact.landing.scene.friction
    assert mu is not None
    problems = friction_problems(landing, equation, impact.along(impact.speeds))
    if problems is None:
        return None
    problem, to_contacts = problems
    (n, bodies), size = (len(problem.A), impact.bodies), len(to_contacts.T)
    jumps = jumps_in_body_axes(landing, equation.full(problem.by_impulse), equation.state, bodies)
    # Of the solution of Eq. 4 only these are read.
    impulse = np.broadcast_to(to_contacts.T, (n, *to_contacts.T.shape))
    solution = Solution(
        problem.by_impulse, impulse, np.ones((n, size)), np.full(n, size), np.ones(n), {}, {}
    )
    slipping = _Slipping(
        landing, equation, solution, jumps, bodies, impact.strikes, vars(impact).get("inertias")
    )
    slipping.impulses = np.where(impact.clear[:, None, None], problem.impulses(mu)[0], np.nan)
    return slipping


@memoized()
def friction_of(landing: PosedLanding) -> FrictionResult:
    """The landing with the scene's coefficient of friction; its end stops are contacts without
    friction.

    Impulses along redundant rows are one solution of many, with the same effect.

    Raises:
        SolveError: no solution was found, or each gains kinetic energy.
    """
    landing = landing.without_stops
    problem, rows, stops = _problem_of(landing)
    mu, m = landing.scene.friction, problem.contacts
    before = problem.before[0, 0, :m]
    assert mu is not None
    best, count = problem.solved(mu)
    moved, pushed = problem.delta(best.impulse.reshape(1, 1, -1))[0, 0], best.impulse[m:, 2]
    unstopped, acting = landing, tuple(stops[i] for i in np.flatnonzero(pushed > 0.0))
    landing = replace(landing, acting=acting) if acting else landing
    equation, unstopped_rows = landing.equation(landing.state), len(rows.rigid)
    impulse = np.full((1, len(equation.J_c[0]), 4), np.nan)
    impulse[0, :unstopped_rows, 3], impulse[0, unstopped_rows:, 3] = (
        rows.turn.T @ best.impulse[:m].ravel()[rows.index],
        pushed[pushed > 0.0],
    )
    closing, rigid = (
        equation.H[0] @ moved - equation.J_c[0].T @ impulse[0, :, 3],
        np.flatnonzero(rows.rigid),
    )
    impulse[0, rigid, 3] = np.linalg.lstsq(equation.J_c[0, rigid].T, closing, rcond=1e-10)[0]
    # What is linear in the strike does not exist: friction is not.
    delta = np.full((1, len(moved), 4), np.nan)
    delta[0, :, 3] = moved
    tangential = np.abs(before[:, :2]).max(axis=1) > 1e-12 * np.abs(before).max()
    bounces = np.zeros(m, dtype=bool)
    bounces[rows.number[rows.place < 2]] = rows.restitution[rows.place < 2] > 0.0
    impact = None
    if set(best.state[:m]) != {"sticks"} or np.any(tangential & bounces):
        jumps, plain = (
            jumps_in_body_axes(landing, equation.full(delta), equation.state),
            solution_in_doubles(unstopped),
        )
        freeze(impulse, delta, jumps)
        impact = DoubleImpact(
            landing,
            equation,
            Solution(delta, impulse, plain.scale, plain.rank, plain.condition, {}, {}),
            jumps,
        )
        freeze(impact.delta_qd)
        if plain.choices:
            impact.unique[0, :unstopped_rows] = plain.choices[0].unique
    axes = np.zeros((3 * m, 3))
    axes[rows.index] = rows.axes
    velocity = (best.velocity[:m, None] @ axes.reshape(-1, 3, 3))[:, 0]
    velocity += _free_slip(landing, axes.reshape(-1, 3, 3), equation.full(delta)[..., 3])
    rates = equation.b[0, :, 3]
    if any(block.restitution for block in landing.blocks):
        stilled = tuple(block._replace(restitution=0.0) for block in landing.blocks)
        rates = approach_speeds(landing.state, stilled, landing.before)[0, :, 3]
    lost = -float(np.nan_to_num(impulse[0, :, 3]) @ (rates + equation.J_c[0] @ moved / 2.0))
    freeze(velocity)
    return FrictionResult(best.state[:m], velocity, count, best.residual, lost, impact)


def _free_slip(landing: PosedLanding, axes: Array, delta_qd: Array) -> Array:
    """Velocities (m, 3) of contacts after the impact along the directions in which they slide
    freely, world axes [m/s].

    Args:
        landing: in its posture.
        axes: (m, 3, 3) along which each contact is stopped; the others zero.
        delta_qd: (1, nv) jumps of the joint velocities.
    """
    slip, state = np.zeros((len(axes), 3)), landing.state
    for k in np.unique(np.argwhere(~axes.any(axis=2))[:, 0]).tolist():
        block = landing.blocks[k]
        jump = (block_wrenches(state, block._replace(forces=np.eye(3), moments=NO_AXES)) @ state.J)[
            0
        ]
        jump = (jump * state.ancestors[block.body]) @ delta_qd[0]
        slip[k] = (np.eye(3) - axes[k].T @ axes[k]) @ (
            contact_velocity(landing, state, block)[0] + jump
        )
    return slip


def may_gain_with_friction(impact: DoubleImpact) -> np.ndarray:
    """Whether (N, S) the scene's friction with the contacts' restitution may be refused, as by
    `friction_of`, for a gain of energy.

    A contact gives λ_n (−(1 − e) |v_n⁻| − µ (|v_t⁺| + d·v_t⁻)) / 2 of it, with the direction d of
    the slip, so that only landings with (1 − e) |v_n⁻| < µ |v_t⁻| at a contact are solved. Without
    restitution none gains: λᵀ v⁺ ≤ 0.
    """
    landing, velocity, mu = impact.landing, impact.base_velocities, impact.landing.scene.friction
    e, normals = (
        np.array(values)
        for values in zip(*((c.restitution, c.normal) for c in landing.contacts), strict=True)
    )
    if mu is None or not e.any():
        return np.zeros(velocity.shape[:2], dtype=bool)
    along = np.sum(impact.approach * normals, axis=-1)
    across = np.linalg.norm(impact.approach - along[..., None] * normals, axis=-1)
    doubtful = ((1.0 - e) * np.abs(along) < mu * across).any(axis=-1)
    slipping = with_friction(impact) if doubtful.any() else None
    return np.asarray(
        doubtful if slipping is None else doubtful & np.isnan(slipping.impulses).any(axis=-1)
    )
