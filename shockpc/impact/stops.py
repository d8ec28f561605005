"""The end stops that act in an impact, of those that joints are at.

Without them a joint would move beyond its limit.

The rows of contacts, standing feet and loops hold as in Eq. 4; a stop can only push. With w = v⁺ +
e v⁻ (e = 0 where the joint did not move towards the stop) along the stops,

    w ≥ 0,    p ≥ 0,    pᵀ w = 0,

for e = 0 the jump of minimum kinetic energy that obeys them. Stops that act are further rows of Eq.
4, which is then solved, and proven, as it is without them.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from shockpc.core.impulse import Solution
from shockpc.core.spatial import Array
from shockpc.impact.landed import solved
from shockpc.landing.end_stops import (
    at_stops,
    driven_beyond,
    missed_stops,
    stop_constraint,
    stops_at,
)
from shockpc.landing.feet.auto_contact import with_own_faces
from shockpc.landing.landing import PosedLanding
from shockpc.method.constraints import Constraint
from shockpc.method.equation import Equation
from shockpc.text.errors import SceneError, SolveError
from shockpc.text.printed import listed

TAKES = 1e-12
"""Share of the largest impulse of a stop, by the speed that it gives, below which a stop takes
none.
"""

DEPENDS = 1e-8
"""Share of a row, or of the largest speed, below which what others leave of it is rounding."""

LEFT = 1e-6
"""Share of the largest speed up to which one along a stop whose joint the contacts hold is rounding
of double precision.
"""

RELAXED = 1e-9
"""Share of the largest speed by which inequalities may be missed, so that some motion meets those
that leave only one.
"""

MOST_ROUNDS = 20
"""Times that the stops that act and what of the soles carries are sought one after the other."""

CONTRADICTS = 1e-10
"""Residual of the dual problem of `least_push` below which no motion meets the inequalities."""


def stop_rows(landing: PosedLanding) -> tuple[tuple[Constraint, ...], Array, Array]:
    """The stops at which joints are: constraints, rows (k, nv) and speeds (k,).

    Rows give speeds away from the stops; the speeds are those before the impact.
    """
    robot = landing.robot
    sides = stops_at(robot, landing.q, landing.joint_model)
    rows = np.zeros((len(sides), robot.model.nv))
    for k, (joint, side) in enumerate(sides):
        rows[k, joint.v.start] = side
    before = rows @ landing.before.joint_rates
    constraints: list[Constraint] = []
    for (joint, side), speed in zip(sides, before.tolist(), strict=True):
        e = landing.scene.stop_restitution if speed < 0.0 else None
        constraints.append(stop_constraint(robot, joint, side, e or 0.0))
    return tuple(constraints), rows, before


def with_stops(landing: PosedLanding) -> PosedLanding:
    """A landing with the rows of the stops that act, and with what of its soles carries then.

    Stops and corners of soles push only, in one convex problem. Stops follow from the faces of the
    soles, and these from the stops that act: where both stay, they are its solution.

    Raises:
        SolveError: no impulses of stops keep all joints from moving beyond them, or stops and soles
            are not found.
    """
    for _ in range(MOST_ROUNDS):
        stopped = _with_stops(landing)
        landing = with_own_faces(stopped)
        if landing.scene.contact == stopped.scene.contact:
            return stopped
    raise SolveError(
        "no verdict: no state was found in which end stops and soles obey their laws together; "
        "give the kinds of the contacts (--contact-kind)"
    )


def _with_stops(landing: PosedLanding) -> PosedLanding:
    """A landing with the rows of the stops that act on its contacts as they are.

    It is the landing itself where none does.
    """
    bare = landing.without_stops
    constraints, rows, before = stop_rows(bare)
    if not constraints:
        return bare
    equation, solution, _ = solved(bare)
    after = bare.before.joint_rates + equation.full(solution.delta_qd)[0, :, 3]
    if not np.isfinite(after).all():
        return bare
    sides = at_stops(bare.robot, bare.q[None], bare.joint_model)[0]
    if not driven_beyond(sides, after).any():
        return bare
    try:
        to_metric = np.linalg.inv(np.linalg.cholesky(equation.H[0])).T
    except np.linalg.LinAlgError:
        return bare  # the proof names what has no inertia
    stops = _in_metric(rows, to_metric, equation, solution)
    e = np.array([constraint.restitution for constraint in constraints])
    missing = -(rows @ after + e * before)
    fastest = float(np.abs(after).max())
    missing[stops.fixed & (missing <= LEFT * fastest)] = 0.0
    try:
        impulse = least_push(stops.rows, missing)
    except ArithmeticError:
        names = listed((constraint.frame for constraint in constraints), 4)
        raise SolveError(
            "no verdict: the contacts drive joints beyond their stops, whatever these do "
            f"({names}): the mechanism cannot move as they ask; leave a direction or a contact "
            "out, or the stops"
        ) from None
    except RuntimeError as failure:
        raise SolveError(
            "no verdict: the search for the end stops that push does not end; leave the stops out"
        ) from failure
    acts = _acting(stops, impulse, missing, fastest)
    if not acts.any():
        return bare
    return replace(bare, acting=tuple(constraints[k] for k in np.flatnonzero(acts)))


class _MetricRows(NamedTuple):
    """Rows of stops in units of the mass metric, in motions that contacts and loops leave.

    Attributes:
        rows: (k, n) of speeds away from the stops; zero where nothing but rounding is left.
        length: (k,) of what is left of them.
        fixed: (k,) which of them contacts and loops hold already, so that no stop can move them.
        bound: (k,) length up to which what others leave of a row is rounding.
    """

    rows: Array
    length: Array
    fixed: np.ndarray
    bound: Array


def _in_metric(
    rows: Array, to_metric: Array, equation: Equation, solution: Solution
) -> _MetricRows:
    """The rows (k, nv) of stops in units of the mass metric.

    Args:
        rows: (k, nv).
        to_metric: (ny, ny) L⁻ᵀ with H = L Lᵀ.
        equation: of the landing without stops.
        solution: of it.
    """
    reduced = rows if equation.G is None else rows @ equation.G[0]
    bound = DEPENDS * np.linalg.norm(reduced @ to_metric, axis=1)
    held = equation.J_c[0] @ to_metric
    if len(held):
        if 0 in solution.row_spaces:
            held = held[solution.row_spaces[0].rows]
        null_space = np.linalg.qr(held.T, mode="complete")[0][:, len(held) :]
        to_metric = to_metric @ null_space
    left = reduced @ to_metric
    length = np.linalg.norm(left, axis=1)
    fixed = length <= bound
    left[fixed] = 0.0
    return _MetricRows(left, length, fixed, bound)


def _acting(stops: _MetricRows, impulse: Array, missing: Array, fastest: float) -> np.ndarray:
    """Mask (k,) of the stops that act: those that push, and those that share their impulse.

    Args:
        stops: their rows.
        impulse: (k,) as of `least_push`.
        missing: (k,) speeds that are missing along them.
        fastest: largest joint rate after the impact without them.
    """
    speeds = impulse * stops.length
    pushes = speeds > TAKES * speeds.max()
    if not pushes.any():
        return np.asarray(pushes)
    # A stop that others hold as well shares their impulse, in a way that is not determined.
    _, sizes, basis = np.linalg.svd(stops.rows[pushes], full_matrices=False)
    basis = basis[sizes > DEPENDS * sizes[0]]
    left = stops.rows - (stops.rows @ basis.T) @ basis
    depends = np.linalg.norm(left, axis=1) <= stops.bound
    reached = stops.rows @ (stops.rows.T @ impulse)
    stays = np.abs(reached - missing) <= DEPENDS * fastest
    return np.asarray(pushes | (depends & ~stops.fixed & stays))


def refuse_missed(landing: PosedLanding) -> None:
    """Refuse end stops that are to strike but cannot.

    Their joint is not there, or does not move towards them.

    Raises:
        SceneError: the text names them.
    """
    striking = [constraint for constraint in landing.contacts if constraint.kind == "stop"]
    if missed_stops(landing.robot, striking, landing.q[None], landing.before.joint_rates)[0]:
        names = listed((constraint.frame for constraint in striking), 4)
        raise SceneError(
            f"{names}: a joint is not at the end stop that it is to strike, or does not move "
            f"towards it"
        )


def least_push(rows: Array, missing: Array) -> Array:
    """Impulses p ≥ 0 with w = G Gᵀ p − h ≥ 0 and pᵀ w = 0.

    They are those of the x = Gᵀ p of minimum length that meets G x ≥ h.

    By the least-squares problem with non-negative unknowns to which Lawson and Hanson reduce it
    ("Solving Least Squares Problems", 1974, Section 23.4, LDP).

    Args:
        rows: (k, n) G, in units of the mass metric.
        missing: (k,) h, speeds that are missing along the rows.

    Returns: (k,) p; zero along rows that do not push.

    Raises:
        ArithmeticError: no x meets the inequalities.
        RuntimeError: the search for p does not end.
    """
    from scipy.optimize import nnls  # takes longer to import than a landing to compute

    length = np.linalg.norm(rows, axis=1)
    scale = 1.0 / np.where(length > 0.0, length, 1.0)
    G, h = rows * scale[:, None], missing * scale
    largest = float(np.abs(h).max(initial=0.0))
    if largest == 0.0:
        return np.zeros(len(rows))
    h = h - RELAXED * np.where(length > 0.0, largest, np.abs(missing).max())
    E = np.vstack([G.T, h / largest])
    f = np.zeros(len(E))
    f[-1] = 1.0
    u, _ = nnls(E, f)
    left = E @ u - f
    if -left[-1] <= CONTRADICTS:
        raise ArithmeticError("no motion meets the inequalities")
    return np.asarray(u / -left[-1] * largest * scale)
