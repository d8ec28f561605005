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
from shockpc.method.constraints import NO_AXES, Constraint, constraint_wrenches
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
    """The data of impacts with friction in N postures, for S strikes each.

    They depend neither on the friction nor on the restitution.

    The m contacts are the contacts and standing feet, and behind them the end stops, which are
    contacts without friction. Each has three rows, two tangents and a normal; nothing moves along
    those in which a contact is not stopped.

    Attributes:
        A: (N, 3m, 3m) Delassus matrices [1/kg].
        before: (N, S, m, 3) velocities along the rows before the impact [m/s].
        restitution: (N, m) e of the scene along the normals.
        stops: number of end stops.
        by_impulse: (N, ny, 3m) jumps of the free velocities for unit impulses.
        halt: (N, ny) jumps with which what turns on a sole stops turning, whatever the impulses
            [rad/s, m/s].
    """

    A: Array
    before: Array
    restitution: Array
    stops: int
    by_impulse: Array
    halt: Array

    def impulses(
        self, mu: Array | float, restitution: float | None = None
    ) -> tuple[Array, dict[int, SolveError]]:
        """The impulses (N, S, 3m) of the contacts [N s], and failures by posture.

        Impulses are NaN where there are none; the failure is the first one of the posture.

        Args:
            mu: of each posture (N,), or of all.
            restitution: of the contacts and standing feet along their normals; by default the
                scene's.
        """
        N, S, m, _ = self.before.shape
        mu = np.broadcast_to(mu, N)
        impulses = np.full((N, S, 3 * m), np.nan)
        if m == 1:
            impulses = self._of_one_contact(mu, restitution)
        failures = dict[int, SolveError]()
        for i, s in np.argwhere(np.isnan(impulses).any(axis=2)).tolist():
            try:
                solution, _ = self.solved(float(mu[i]), restitution, (i, s))
            except SolveError as error:
                failures.setdefault(i, error)
            else:
                impulses[i, s] = solution.impulse.ravel()
        return impulses, failures

    def _of_one_contact(self, mu: Array, restitution: float | None) -> Array:
        """The impulses (N, S, 3) of a single contact, all at once; NaN where there are none."""
        N, S = self.before.shape[:2]
        A = np.repeat(self.A, S, axis=0)
        before = self.before.reshape(-1, 3)
        e = np.repeat(self.restitution, S)
        if restitution is not None:
            e = np.full(N * S, restitution)
        impulses = np.full((N * S, 3), np.nan)
        known = np.isfinite(A).all(axis=(1, 2)) & np.isfinite(before).all(axis=1)
        impulses[known] = solve_each(A[known], before[known], np.repeat(mu, S)[known], e[known])
        return impulses.reshape(N, S, 3)

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
        m = self.contacts
        e = self.restitution[of[0]].copy()
        if restitution is not None:
            e[:m] = restitution
        friction = np.repeat([mu, 0.0], [m, self.stops])
        try:
            solutions = solve_friction(self.A[of[0]], self.before[of], friction, e)
        except (np.linalg.LinAlgError, ValueError) as refusal:
            raise SolveError(f"no verdict for a friction of {mu:g}: {refusal}") from None
        if not solutions:
            raise SolveError(
                "no verdict: no impulse was found that obeys Coulomb's law with a friction of "
                f"{mu:g}; change the friction slightly"
            )

        def order(solution: FrictionImpact) -> tuple[bool, bool]:
            """The key by which solutions are sorted: that in which the contacts stick comes first.

            It is the one of Eq. 4. Those that gain energy come last.
            """
            return solution.gains_energy, set(solution.state[:m]) != {"sticks"}

        best = min(solutions, key=order)
        if best.gains_energy:
            raise SolveError(
                f"no verdict: with friction {mu:g} and the restitution of the contacts the impact "
                f"would gain {best.energy:.3g} J of kinetic energy (Newton's restitution is not "
                f"valid where slip stops or reverses); take less restitution"
            )
        return best, len(solutions)

    @property
    def contacts(self) -> int:
        """Number of contacts and standing feet."""
        return int(self.restitution.shape[1]) - self.stops

    def part(self, postures: np.ndarray) -> "FrictionProblem":
        """The problem in some of the postures."""
        return FrictionProblem(
            self.A[postures],
            self.before[postures],
            self.restitution[postures],
            self.stops,
            self.by_impulse[postures],
            self.halt[postures],
        )

    def scaled(self, factor: float) -> "FrictionProblem":
        """The problem with all velocities before the impact times a factor above zero."""
        return self._replace(before=factor * self.before, halt=factor * self.halt)

    def delta(self, impulses: Array) -> Array:
        """Jumps (N, S, ny) of the free velocities.

        Args: impulses (N, S, 3m), as `impulses` gives them.
        """
        return np.asarray(self.halt[:, None] + impulses @ np.swapaxes(self.by_impulse, 1, 2))


def friction_problem(landing: PosedLanding) -> FrictionProblem:
    """The problem of a landing in its posture, with its strike.

    Raises:
        SolveError: the inertia matrix is singular.
    """
    return _problem_of(landing.without_stops)[0]


def _problem_of(
    landing: PosedLanding,
) -> tuple[FrictionProblem, ContactRows, tuple[Constraint, ...]]:
    """The problem, the rows of contacts and standing feet, and the end stops."""
    rows = contact_rows(landing)
    m = int(rows.number[-1]) + 1
    stops: tuple[Constraint, ...] = ()
    along_stops = np.zeros((0, landing.robot.model.nv))
    stop_speeds = np.zeros(0)
    if landing.scene.stops:
        stops, along_stops, stop_speeds = stop_rows(landing)
    if rows.equation.G is not None:
        along_stops = along_stops @ rows.equation.G[0]

    # Three rows a contact; of an end stop the normal alone moves.
    normals = slice(3 * m + 2, None, 3)
    before = np.zeros(3 * (m + len(stops)))
    before[rows.index] = rows.speeds
    before[normals] = stop_speeds + along_stops @ rows.halt
    J = np.zeros((len(before), len(rows.M)))
    J[rows.index] = rows.J
    J[normals] = along_stops @ rows.basis
    e = np.concatenate([rows.restitution[rows.normal], [stop.restitution for stop in stops]])
    try:
        by_impulse = np.linalg.solve(rows.M, J.T)
    except np.linalg.LinAlgError as refusal:
        raise SolveError(f"no verdict with friction: {refusal}") from None
    problem = FrictionProblem(
        A=(J @ by_impulse)[None],
        before=before.reshape(1, 1, -1, 3),
        restitution=e[None],
        stops=len(stops),
        by_impulse=(rows.basis @ by_impulse)[None],
        halt=rows.halt[None],
    )
    return problem, rows, stops


def friction_problems(
    landing: Landing, equation: Equation, speeds: Array
) -> tuple[FrictionProblem, Array] | None:
    """The problem in N postures, in each of which all rows are independent.

    The second array (3m, nc) holds the rows of contacts in those of Eq. 4.

    Args:
        landing: the landing, without end stops.
        equation: Eq. 4 in the postures.
        speeds: (N, S, nc) that each strike's impact undoes along its rows [m/s].

    Returns: None where rows are held rigidly, so that each posture has a separate problem, as
        `friction_problem` has it.
    """
    layout = row_layout(equation.constraints)
    if layout.rigid.any() or landing.scene.stops:
        return None
    contacts = int(layout.number[-1]) + 1
    to_contacts = np.zeros((3 * contacts, len(layout.rigid)))
    to_contacts[layout.index] = layout.turn
    J = to_contacts @ equation.J_c
    by_impulse = solve_inertia(equation.inertia, np.swapaxes(J, 1, 2))

    # The speeds to be undone are (1 + e) times those before.
    to_contacts_before = to_contacts.copy()
    to_contacts_before[layout.index] /= (1.0 + layout.restitution)[:, None]
    before = (speeds @ to_contacts_before.T).reshape(*speeds.shape[:2], -1, 3)
    e = layout.restitution[layout.normal]
    problem = FrictionProblem(
        A=J @ by_impulse,
        before=before,
        restitution=np.broadcast_to(e, (len(J), len(e))),
        stops=0,
        by_impulse=by_impulse,
        halt=np.zeros(by_impulse.shape[:2]),
    )
    return problem, to_contacts


def joined_problems(problems: Sequence[FrictionProblem]) -> FrictionProblem:
    """Problems as one, in the postures of all of them.

    They have equally many contacts, stops, free velocities and strikes.
    """
    return FrictionProblem(
        A=np.concatenate([problem.A for problem in problems]),
        before=np.concatenate([problem.before for problem in problems]),
        restitution=np.concatenate([problem.restitution for problem in problems]),
        stops=problems[0].stops,
        by_impulse=np.concatenate([problem.by_impulse for problem in problems]),
        halt=np.concatenate([problem.halt for problem in problems]),
    )


class _Slipping(DoubleImpact):
    """An impact with friction in N postures for S strikes.

    Its columns are of unit impulses along the 3m rows of contacts.
    """

    impulses: Array
    """(N, S, 3m) along these rows [N s]; NaN where an impact has to be looked at by itself."""

    def along(self, columns: Any) -> Any:
        """Columns (N, ..., 3m) for the impulses of each strike (N, S, ...)."""
        return np.einsum("n...k,nsk->ns...", columns, self.impulses)


@memoized()
def with_friction(impact: DoubleImpact) -> _Slipping | None:
    """An impact in N postures for S strikes with the scene's friction, as by `friction_of`.

    It is computed once.

    Returns: None where it has to be computed in each posture by itself, because flat contacts or
        loops hold rows rigidly, or stops count. Quantities are NaN where that holds for one
        posture: rows are redundant, or friction has no solution.
    """
    landing = impact.landing
    equation = impact.equation
    mu = landing.scene.friction
    assert mu is not None
    problems = friction_problems(landing, equation, impact.along(impact.speeds))
    if problems is None:
        return None
    problem, to_contacts = problems
    n = len(problem.A)
    rows, size = to_contacts.shape
    jumps = jumps_in_body_axes(equation, problem.by_impulse, impact.bodies)
    # Of the solution of Eq. 4 only these are read: columns of unit impulses of the contacts.
    solution = Solution(
        delta_qd=problem.by_impulse,
        impulse=np.broadcast_to(to_contacts.T, (n, size, rows)),
        scale=np.ones((n, size)),
        rank=np.full(n, size),
        condition=np.ones(n),
        row_spaces={},
        independent={},
    )
    inertias = vars(impact).get("inertias")
    slipping = _Slipping(
        landing, equation, solution, jumps, impact.bodies, impact.strikes, inertias
    )
    impulses, _ = problem.impulses(mu)
    slipping.impulses = np.where(impact.clear[:, None, None], impulses, np.nan)
    return slipping


@memoized()
def friction_of(landing: PosedLanding) -> FrictionResult:
    """The landing with the scene's coefficient of friction.

    Its end stops are contacts without friction.

    Impulses along redundant rows are one solution of many, with the same effect.

    Raises:
        SolveError: no solution was found, or each gains kinetic energy.
    """
    bare = landing.without_stops
    problem, rows, stops = _problem_of(bare)
    mu = bare.scene.friction
    assert mu is not None
    solution, count = problem.solved(mu)
    impulses = solution.impulse[: problem.contacts]
    stop_impulses = solution.impulse[problem.contacts :, 2]
    delta_y = problem.delta(solution.impulse.reshape(1, 1, -1))[0, 0]

    # Stops that push are rows behind those of the landing without stops.
    acting = np.flatnonzero(stop_impulses > 0.0)
    stopped = bare
    if len(acting):
        stopped = replace(bare, acting=tuple(stops[i] for i in acting))
    equation = stopped.equation(stopped.state)
    impulse = _along_rows(equation, rows, impulses, stop_impulses[acting], delta_y)
    delta_qd = equation.full(delta_y[None, :, None])[..., 0]

    state = solution.state[: problem.contacts]
    impact = None
    if set(state) != {"sticks"} or _bounces_along_the_ground(problem, rows):
        impact = _impact(stopped, bare, equation, impulse, delta_y)
    velocity = _velocity_after(stopped, rows, solution, delta_qd)
    lost = _energy_lost(stopped, equation, impulse, delta_y)
    freeze(velocity)
    return FrictionResult(state, velocity, count, solution.residual, lost, impact)


def _along_rows(
    equation: Equation, rows: ContactRows, impulses: Array, of_stops: Array, delta_y: Array
) -> Array:
    """Impulses (nc,) along all rows of Eq. 4 [N s].

    Those of contacts follow from their tangents and normals. Those of rows that are held rigidly
    are what the jump still needs: J_rᵀ λ_r = H Δẏ − J_cᵀ λ.

    Args:
        equation: with the stops that act.
        rows: of contacts and standing feet.
        impulses: (m, 3) of contacts.
        of_stops: (s,) of the stops that act.
        delta_y: (ny,) jumps of the free velocities.
    """
    J_c = equation.J_c[0]
    impulse = np.append(rows.turn.T @ impulses.ravel()[rows.index], of_stops)
    missing = equation.H[0] @ delta_y - J_c.T @ impulse
    rigid = np.flatnonzero(rows.rigid)
    impulse[rigid] = np.linalg.lstsq(J_c[rigid].T, missing, rcond=1e-10)[0]
    return impulse


def _bounces_along_the_ground(problem: FrictionProblem, rows: ContactRows) -> bool:
    """True if Eq. 4 reverses tangential velocities, which friction does not."""
    before = problem.before[0, 0, : problem.contacts]
    along = np.abs(before[:, :2]).max(axis=1)
    moves = along > 1e-12 * np.abs(before).max()
    tangents = ~rows.normal
    bounces = np.zeros(problem.contacts, dtype=bool)
    bounces[rows.number[tangents]] = rows.restitution[tangents] > 0.0
    return bool(np.any(moves & bounces))


def _impact(
    landing: PosedLanding,
    unstopped: PosedLanding,
    equation: Equation,
    impulse: Array,
    delta_y: Array,
) -> DoubleImpact:
    """The impact for the scene's strike.

    It has nothing that is linear in the strike, because friction is not.

    Args:
        landing: with the stops that act.
        unstopped: without stops.
        equation: of the landing.
        impulse: (nc,) along its rows.
        delta_y: (ny,) jumps of the free velocities.
    """
    sticking = solution_in_doubles(unstopped)
    impulses = _last_column(impulse)
    delta = _last_column(delta_y)
    jumps = jumps_in_body_axes(equation, delta)
    freeze(impulses, delta, jumps)
    solution = sticking._replace(delta_qd=delta, impulse=impulses, row_spaces={}, independent={})
    impact = DoubleImpact(landing, equation, solution, jumps)
    freeze(impact.delta_qd)
    if sticking.row_spaces:
        unique = sticking.row_spaces[0].unique
        impact.unique[0, : len(unique)] = unique
    return impact


def _last_column(values: Array) -> Array:
    """Values (n,) as the column of the scene's strike (1, n, 4); those of unit strikes are NaN."""
    out = np.full((1, len(values), 4), np.nan)
    out[0, :, 3] = values
    return out


def _energy_lost(
    landing: PosedLanding, equation: Equation, impulse: Array, delta_y: Array
) -> float:
    """The kinetic energy that impulses (nc,) take [J].

    −λᵀ (v⁻ + v⁺) / 2 = −λᵀ (v⁻ + J_c Δẏ / 2).
    """
    v_before = equation.b[0, :, 3]
    if any(constraint.restitution for constraint in landing.constraints):
        # b is (1 + e) v⁻.
        still = tuple(constraint._replace(restitution=0.0) for constraint in landing.constraints)
        v_before = approach_speeds(landing.state, still, landing.before)[0, :, 3]
    mean_velocity = v_before + equation.J_c[0] @ delta_y / 2.0
    return -float(np.nan_to_num(impulse) @ mean_velocity)


def _velocity_after(
    landing: PosedLanding, rows: ContactRows, solution: FrictionImpact, delta_qd: Array
) -> Array:
    """Velocities (m, 3) of the contacts after the impact, world axes [m/s].

    Args:
        landing: in its posture.
        rows: of the m contacts.
        solution: their velocities along these.
        delta_qd: (1, nv) jumps of the joint velocities.
    """
    m = int(rows.number[-1]) + 1
    axes = np.zeros((m, 3, 3))
    axes[rows.number, rows.axis] = rows.axes
    along_rows = (solution.velocity[:m, None] @ axes)[:, 0]
    return along_rows + _free_slip(landing, axes, delta_qd)


def _free_slip(landing: PosedLanding, axes: Array, delta_qd: Array) -> Array:
    """Velocities (m, 3) of contacts after the impact along their free directions [m/s].

    In world axes. Along these directions contacts slide freely.

    Args:
        landing: in its posture.
        axes: (m, 3, 3) along which each contact is stopped; the others zero.
        delta_qd: (1, nv) jumps of the joint velocities.
    """
    state = landing.state
    slip = np.zeros((len(axes), 3))
    free = np.unique(np.argwhere(~axes.any(axis=2))[:, 0])
    for k in free.tolist():
        constraint = landing.constraints[k]
        point = constraint._replace(forces=np.eye(3), moments=NO_AXES)
        J = (constraint_wrenches(state, point) @ state.J)[0] * state.ancestors[constraint.body]
        after = contact_velocity(landing, state, constraint)[0] + J @ delta_qd[0]
        slip[k] = (np.eye(3) - axes[k].T @ axes[k]) @ after
    return slip


def may_gain_with_friction(impact: DoubleImpact) -> np.ndarray:
    """Mask (N, S) of the landings that may be refused for a gain of energy with friction.

    The friction and the contacts' restitution are the scene's; `friction_of` refuses them.

    A contact gives λ_n (−(1 − e) |v_n⁻| − µ (|v_t⁺| + d·v_t⁻)) / 2 of energy, with the direction d
    of the slip, so that only landings with (1 − e) |v_n⁻| < µ |v_t⁻| at a contact are solved.
    Without restitution none gains: λᵀ v⁺ ≤ 0.
    """
    landing = impact.landing
    mu = landing.scene.friction
    e = np.array([contact.restitution for contact in landing.contacts])
    normals = np.array([contact.normal for contact in landing.contacts])
    if mu is None or not e.any():
        return np.zeros(impact.base_velocities.shape[:2], dtype=bool)
    along = np.sum(impact.approach * normals, axis=-1)
    across = np.linalg.norm(impact.approach - along[..., None] * normals, axis=-1)
    may_gain = (1.0 - e) * np.abs(along) < mu * across
    doubtful = may_gain.any(axis=-1)
    if not doubtful.any():
        return np.asarray(doubtful & False)
    slipping = with_friction(impact)
    if slipping is None:
        return np.asarray(doubtful)
    return np.asarray(doubtful & np.isnan(slipping.impulses).any(axis=-1))
