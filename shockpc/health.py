"""How far to trust a solution: rank, residual, and a second solution that shares nothing with the first."""

from typing import NamedTuple

import numpy as np

from shockpc.blame import contradiction, ill_conditioned, nearly_repeated
from shockpc.core.impulse import independent_rows, least_impulse, residuals, solve_impact
from shockpc.core.maximal import MaximalSolution, refine, solve_maximal
from shockpc.core.rounding import units_of
from shockpc.core.spatial import Array
from shockpc.core.tree import Tree
from shockpc.errors import SceneError
from shockpc.model.bodies import at_com, body_jumps, speed_of
from shockpc.model.dynamics import Dynamics
from shockpc.model.equation import Equation, Solution
from shockpc.model.rows import Rows, about_com, row_jacobian
from shockpc.model.sampling import sampled_rounding
from shockpc.result import Health
from shockpc.robot.robot import Robot

__all__ = [
    "DOUBTFUL",
    "ONE_DRAW",
    "PROMISED",
    "SAMPLES",
    "TRUSTED",
    "UNMOVED",
    "Second",
    "Verdict",
    "judge",
]

TRUSTED = 1e-9
"""Every number is right to this share of its body's own motion, or carries a warning."""

PROMISED = 10.0
"""The true error is never more than so many times the estimate."""

DOUBTFUL = TRUSTED / PROMISED
"""An estimate above this no longer vouches for `TRUSTED`: it calls for the better of two solutions, and a warning."""

SUSPECT = 1e-13
"""From here on the second solution is refined first, for it may be the one that is off."""

ONE_DRAW = 10.0
"""A difference of two solutions is one draw of what the error may be; so many times that covers what one draw may miss."""

UNMOVED = 1e-13
"""A body that moves by less than this share of the fastest one is not told from one that does not move."""

SAMPLES = 12
"""Random changes that sample what rounding does: the largest of so many effects is hardly made too small by chance."""

CANCELLED = 8.0
"""Speeds before the impact that are so much smaller than the terms they are sums of have lost digits worth counting."""

JOINT_SPACE = "joint space (Eq. 4)"
MAXIMAL = "maximal coordinates, refined"


class Second(NamedTuple):
    """The solution in maximal coordinates.

    Attributes:
        found: for the unit strikes along x, y and z, then the scene's own.
        rows: indices of the rows it was found with, independent of one another.
        spread: (nb, 6, 4) what rounding in the data may do to its twists; None if there was no reason to try.
    """

    found: MaximalSolution
    rows: np.ndarray
    spread: Array | None


class Verdict(NamedTuple):
    """A solution, the better of two, and how far to trust it.

    Attributes:
        solution: the one to report.
        health: how far to trust its jumps.
        second: the other opinion, if there is one.
    """

    solution: Solution
    health: Health
    second: Second | None


def judge(robot: Robot, state: Dynamics, bodies: Tree, rows: Rows, solution: Solution) -> Verdict:
    """Hold a solution against one in maximal coordinates, for the scene's strike (the last column).

    The estimate is what the two are apart, ten times, and what rounding of the placements does to both alike. While it vouches for
    `TRUSTED` the first stands. Beyond that the second is refined, what rounding does to each of them is sampled, and the steadier
    one is reported with a warning.

    Args:
        robot: the robot.
        state: its dynamics, first posture.
        bodies: the same as free bodies and joints.
        rows: what is held.
        solution: in joint space.

    Raises:
        SceneError: the mechanism cannot meet its contacts, because they contradict one another or ask for a motion that it does not
            have.
    """
    equation, impact = solution.equation, solution.impact
    b, delta = equation.b[0, :, -1:], impact.delta_qd[0, :, -1:]
    momentum, contact = residuals(equation.H[0], equation.J_c[0], b, delta, impact.impulse[0, :, -1:])
    if contact.max() > 1e-6:
        raise SceneError(contradiction(rows, int(np.argmax(contact)), (equation.J_c[0] @ delta + b)[:, 0]))

    chosen_rows = independent_rows(equation.H[0], equation.J_c[0], int(impact.rank[0]), impact.dead[0])
    W = about_com(rows.W[0], bodies)
    held, units = _held(state, equation.G), units_of(state.rotation[0])
    motion = at_com(robot, state, solution.jumps[0, :, :, -1])
    try:
        other = solve_maximal(bodies, W[chosen_rows], rows.b[0, chosen_rows])
    except np.linalg.LinAlgError:
        # So near a singular posture that the larger system cannot be factorised: the first solution has to be judged by itself.
        other = None
    spread = None
    apart, moving = _compare(robot, motion, other, held)
    if other is not None and np.any(apart[moving] > SUSPECT):
        other, spread = refine(bodies, W[chosen_rows], other, SAMPLES, units)
        apart, moving = _compare(robot, motion, other, held)
    # Both solutions read the same rounded placements, so no difference between them tells what those do to rows that are small
    # differences of large terms, or that nearly repeat one another.
    shared = np.where(held, 0.0, units * (8.0 + _cancellation(state, rows, impact.dead[0])) / 32.0 / float(impact.weakest[0]))
    method, errors = f"{JOINT_SPACE}, checked in maximal coordinates", ONE_DRAW * apart + shared
    warnings: list[str] = []
    if np.any(apart[moving] > SUSPECT) or np.any(errors[moving] > DOUBTFUL):
        # Where two solutions part visibly they may err alike at another body; samples of rounding tell.
        sampled = shared + _relative(robot, sampled_rounding(robot, state, bodies, rows, equation.G, SAMPLES), motion, held)
        errors = np.maximum(errors, sampled)
    if np.any(errors[moving] > DOUBTFUL):
        candidates = {JOINT_SPACE: sampled}
        if other is not None and spread is not None:
            candidates[MAXIMAL] = shared + _relative(robot, spread[..., -1], other.twists[..., -1], held)
        chosen = min(candidates, key=lambda name: float(np.max(candidates[name][moving])))
        errors = candidates[chosen]
        if np.any((apart > PROMISED * sum(candidates.values()))[moving]):
            # A difference that no sample explains is an error of one of the two, and nobody can tell of which.
            errors = np.maximum(errors, ONE_DRAW * apart)
        method = f"{chosen}, the steadier of two solutions"
        still_apart, left = np.where(moving, apart, 0.0), float(np.max(errors[moving], initial=0.0))
        warnings.append(ill_conditioned(robot, rows, float(impact.weakest[0]), still_apart, left, DOUBTFUL, chosen))
        if other is not None and chosen == MAXIMAL:
            solution = _from_maximal(robot, state, other, solution, chosen_rows, held)
            motion = other.twists[..., -1]
            moving = ~held & (speed_of(robot, motion) > UNMOVED * speed_of(robot, motion).max())
    approach = _approach_rounding(robot, state, rows, equation, motion, held, units)
    errors = errors + approach
    if np.any(approach[moving] > DOUBTFUL):
        warnings.append(
            "the speeds before the impact are small differences of large ones, so the shock is good to about "
            f"{approach[moving].max():.0e} of each body's motion only"
        )
    if impact.marginal[0]:
        errors = np.where(held, errors, np.maximum(errors, 1.0))
        warnings.append(nearly_repeated(rows))
    speed = speed_of(robot, motion)
    still = ~moving & (speed > 0.0)
    if still.any():
        which = "1 body moves" if still.sum() == 1 else f"{still.sum()} bodies move"
        most = max(UNMOVED, float(speed[still].max() / speed.max()))
        warnings.append(f"{which} by no more than {most:.0e} of the fastest one; such numbers are rounding")
    health = Health(
        rank=int(impact.rank[0]),
        rows=equation.J_c.shape[1],
        residual=float(max(momentum, contact.max())),
        error_estimate=float(np.max(errors[moving], initial=0.0)),
        body_errors=tuple(map(float, errors)),
        method=method,
        warnings=tuple(warnings),
    )
    return Verdict(solution, health, None if other is None else Second(other, chosen_rows, spread))


def _held(state: Dynamics, G: Array | None) -> np.ndarray:
    """Which bodies (nb,) no free velocity moves, so that they are still exactly, not by rounding."""
    free = np.ones(state.H.shape[-1], dtype=bool) if G is None else G[0].any(axis=1)
    return np.asarray(~(state.moves & free).any(axis=1))


def _cancellation(state: Dynamics, rows: Rows, dead: np.ndarray) -> float:
    """How much larger the terms of a row of J_c are than the row itself, at worst: rounding in them counts that many times."""
    J = np.where(state.moves[:, None, :], np.abs(state.J[0]), 0.0)
    terms = np.einsum("cbk,bkv->cv", np.abs(rows.W[0]), J)
    size = np.linalg.norm(row_jacobian(state, rows.W)[0], axis=1)
    return float(np.max(np.linalg.norm(terms, axis=1)[~dead] / size[~dead], initial=1.0))


def _approach_rounding(
    robot: Robot, state: Dynamics, rows: Rows, equation: Equation, motion: Array, held: np.ndarray, units: float
) -> Array:
    """What rounding in the speeds before the impact does, which may be small differences, to each body's motion (nb,) [1]."""
    terms, b = rows.terms[0], rows.b[0, :, -1]
    if terms.max(initial=0.0) <= CANCELLED * np.abs(b).max(initial=0.0):
        return np.zeros(len(motion))
    delta = solve_impact(equation.H[0], equation.J_c[0], np.diag(terms)).delta_qd
    jumps = body_jumps(state, (delta if equation.G is None else equation.G[0] @ delta)[None])[0]
    moved = [speed_of(robot, at_com(robot, state, jumps[..., k])) for k in range(len(terms))]
    return np.where(held, 0.0, units * np.linalg.norm(moved, axis=0) / np.maximum(speed_of(robot, motion), np.finfo(float).tiny))


def _compare(robot: Robot, motion: Array, other: MaximalSolution | None, held: np.ndarray) -> tuple[Array, np.ndarray]:
    """How far two solutions are apart at every body (nb,), infinitely without a second one; and which bodies move (nb,)."""
    found = motion if other is None else other.twists[..., -1]
    apart = np.where(held, 0.0, np.inf) if other is None else _relative(robot, motion - found, found, held)
    ours, theirs = speed_of(robot, motion), speed_of(robot, found)
    # What one solution moves by more than a trace is moved, until it is known which of them errs.
    return apart, ~held & ((theirs > UNMOVED * theirs.max()) | (ours > TRUSTED * ours.max()))


def _relative(robot: Robot, difference: Array, motion: Array, held: np.ndarray) -> Array:
    """Size of a difference relative to each body's own motion (nb,); 0 for bodies that are held."""
    own = speed_of(robot, motion)
    apart = np.where(held, 0.0, speed_of(robot, difference))
    return np.where(apart > 0.0, apart / np.where(own > 0.0, own, np.finfo(float).tiny), 0.0)


def _from_maximal(
    robot: Robot, state: Dynamics, refined: MaximalSolution, before: Solution, chosen: np.ndarray, held: np.ndarray
) -> Solution:
    """The solution in maximal coordinates, written as the joint-space one is; bodies that nothing can move are at rest."""
    rotation, twists = np.swapaxes(state.rotation[0], -1, -2), np.where(held[:, None, None], 0.0, refined.twists)
    omega, v_com = rotation @ twists[:, :3], rotation @ twists[:, 3:]
    com = np.stack([body.com for body in robot.bodies])
    jumps = np.concatenate([omega, v_com - np.cross(omega, com[..., None], axis=1)], axis=1)[None]
    delta_y = refined.delta_y[None]
    delta_qd = delta_y if before.equation.G is None else before.equation.G @ delta_y
    J_c = before.equation.J_c[0]
    impulse = least_impulse(J_c, before.impact.scale[0], chosen, refined.impulse)
    impact = before.impact._replace(delta_qd=delta_y, impulse=impulse[None])
    return Solution(before.equation, impact, delta_qd, jumps)
