"""The answer with more than fifty digits, in maximal coordinates: what every method's error is measured against.

Each body has a twist of its own, joints and contacts are constraints. The system is eliminated body by body from the leaves to the
root (what is left of a body, its joint eliminated, is added to its parent), so the work grows with the number of bodies alone and
nothing is ever multiplied into a joint-space inertia:

    F_i = I_i V_i − P_i,   S_iᵀ F_i + a_i q̇_i = τ_i,   V_i = V_parent(i) + S_i q̇_i

A row's response is the motion that a unit of its impulse makes; the rows' impulses then solve a system of their own, A λ = −b,
whose rank `exact_rank` decides. No product code takes part but the reader of the scene.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import mpmath
import numpy as np
from mpmath import mp

from shockpc.bench.exact import DIGITS, Exact, cross, shaken, widen
from shockpc.bench.exact_bodies import Mechanism, Row
from shockpc.bench.exact_rank import least_impulse
from shockpc.bench.exact_rows import mechanism
from shockpc.errors import SolveError
from shockpc.landing import Landing
from shockpc.robot.robot import Robot
from shockpc.scene import Scene

__all__ = ["Reference", "mobility", "reference", "solve_exactly"]


class Reference(NamedTuple):
    """An impact, exactly.

    Attributes:
        jumps: (nb, 6) jump of every body, body coordinates at its frame's origin.
        twists: (nb, 6) the same in world axes, velocity of the centre of mass.
        rates: (n,) jump of the joint rates of each body.
        impulse: (nc,) impulse along each row, of least norm where rows repeat.
        rank: how many rows are independent.
        violation: largest violation of any equation of motion or any row, relative [1].
    """

    jumps: Exact
    twists: Exact
    rates: tuple[Exact, ...]
    impulse: Exact
    rank: int
    violation: float


def reference(robot: Robot, scene: Scene, landing: Landing) -> Reference:
    """Solve a scene exactly; arguments as for `mechanism`.

    Raises:
        SolveError: a joint that nothing resists.
    """
    with mp.workdps(DIGITS):

        def shake(seed: int) -> Exact:
            return mobility(mechanism(robot, scene, landing, shaken(seed)))

        return solve_exactly(mechanism(robot, scene, landing), shake)


class _Step(NamedTuple):
    """One body, eliminated: U = I S and D⁻¹ with D = Sᵀ I S + a."""

    U: Exact
    D_inv: Exact


def solve_exactly(m: Mechanism, shake: Callable[[int], Exact]) -> Reference:
    """The jump of least kinetic energy that meets all rows. Call it inside `mp.workdps(DIGITS)`.

    Args:
        m: bodies, joints and rows.
        shake: matrix A of a mechanism whose doubles differ from this one's by rounding, for a seed.

    Raises:
        SolveError: a joint that nothing resists.
    """
    responses = _responses(m)
    b = np.array([row.b for row in m.rows], dtype=object)
    impulse, rank = least_impulse(mobility(m, responses), -b, shake)
    nb = len(m.parent)
    V = [sum((response[0][i] * x for x, response in zip(impulse, responses, strict=True)), widen(np.zeros(6))) for i in range(nb)]
    rates = tuple(
        sum((response[1][i] * x for x, response in zip(impulse, responses, strict=True)), widen(np.zeros(m.S[i].shape[1])))
        for i in range(nb)
    )
    twists = np.stack([np.concatenate([v[:3], v[3:] + cross(v[:3], c)]) for v, c in zip(V, m.com, strict=True)])
    jumps = np.stack(
        [np.concatenate([R.T @ v[:3], R.T @ (v[3:] + cross(v[:3], p))]) for v, R, p in zip(V, m.rotation, m.position, strict=True)]
    )
    return Reference(jumps, twists, rates, impulse, rank, _violation(m, V, rates, impulse))


def _responses(m: Mechanism) -> list[tuple[list[Exact], list[Exact]]]:
    """Twists and joint rates of all bodies for a unit impulse of each row."""
    steps = _eliminate(m)
    return [_respond(m, steps, row) for row in m.rows]


def mobility(m: Mechanism, responses: list[tuple[list[Exact], list[Exact]]] | None = None) -> Exact:
    """A (nc, nc): the speed along each row for a unit impulse along each other. Responses to each row are found, if not given."""
    n, responses = len(m.rows), responses or _responses(m)
    return np.array([[_work(row, *response) for response in responses] for row in m.rows], dtype=object).reshape(n, n)


def _eliminate(m: Mechanism) -> list[_Step]:
    """Leaf to root: every joint eliminated, what is left of its body added to the parent's."""
    left = list(m.inertia)
    steps: list[_Step] = [_Step(np.empty((6, 0), dtype=object), np.empty((0, 0), dtype=object))] * len(m.parent)
    tied = {place for row in m.rows for place in row.torque}
    size = max(abs(I[k, k]) for I in m.inertia for k in range(6))  # noqa: E741 - the field's own symbol
    for i in range(len(m.parent) - 1, -1, -1):
        S, I = m.S[i], left[i]  # noqa: E741 - the field's own symbol
        if S.shape[1]:
            U = I @ S
            D = S.T @ U
            for k in range(len(D)):
                D[k, k] += m.armature[i][k]
            _refuse_free(size, i, D, tied)
            steps[i] = _Step(U, _inverse(D))
            I = I - U @ steps[i].D_inv @ U.T  # noqa: E741
        if m.parent[i] >= 0:
            left[m.parent[i]] = left[m.parent[i]] + I
    return steps


def _refuse_free(size: Any, i: int, D: Exact, tied: set[tuple[int, int]]) -> None:
    """A rate that nothing resists has no answer, unless a row ties it to another: then a trace of inertia stands in for it.

    The trace is 1e-70 of the heaviest body's: far below every digit that is kept, far above the last one carried.
    """
    for k in range(len(D)):
        if D[k, k] > size * mpmath.mpf(10) ** -60:
            continue
        if (i, k) not in tied:
            raise SolveError(f"body number {i} can move but nothing resists it, so its jump is not determined")
        D[k, k] += size * mpmath.mpf(10) ** -70


def _inverse(D: Exact) -> Exact:
    """Inverse of a small symmetric positive definite matrix, by elimination without pivoting."""
    n = len(D)
    if n == 1:
        return np.array([[1 / D[0, 0]]], dtype=object)
    work = np.concatenate([D, widen(np.eye(n))], axis=1)
    for k in range(n):
        if not work[k, k] > 0:
            raise SolveError("a joint carries no mass along one of its motions, so its jump is not determined")
        work[k] = work[k] / work[k, k]
        for r in range(n):
            if r != k and work[r, k] != 0:
                work[r] = work[r] - work[r, k] * work[k]
    return work[:, n:]


def _respond(m: Mechanism, steps: list[_Step], row: Row) -> tuple[list[Exact], list[Exact]]:
    """Twists (6,) and joint rates of all bodies for a unit impulse of a row: once to the root, once back."""
    nb = len(m.parent)
    P: dict[int, Exact] = dict(row.wrench)
    u: dict[int, Exact] = {}
    for i in range(nb - 1, -1, -1):
        torques = {k: value for (body, k), value in row.torque.items() if body == i}
        if i not in P and not torques:
            continue
        push = P.get(i, widen(np.zeros(6)))
        own = m.S[i].T @ push
        for k, value in torques.items():
            own[k] = own[k] + value
        u[i] = own
        p = m.parent[i]
        if p >= 0:
            rest = push - steps[i].U @ (steps[i].D_inv @ own) if len(own) else push
            P[p] = P[p] + rest if p in P else rest
    V: list[Exact] = []
    rates: list[Exact] = []
    for i, p in enumerate(m.parent):
        above = V[p] if p >= 0 else widen(np.zeros(6))
        drive = -(steps[i].U.T @ above)
        if i in u:
            drive = drive + u[i]
        rates.append(steps[i].D_inv @ drive)
        V.append(above + m.S[i] @ rates[i] if len(rates[i]) else above)
    return V, rates


def _work(row: Row, V: list[Exact], rates: list[Exact]) -> Any:
    """Velocity of a row in a motion: what its unit impulse does work on."""
    work = mp.zero
    for i, wrench in row.wrench.items():
        work += wrench @ V[i]
    for (i, k), value in row.torque.items():
        work += value * rates[i][k]
    return work


def _violation(m: Mechanism, V: list[Exact], rates: tuple[Exact, ...], impulse: Exact) -> float:
    """Put the answer back into every equation: momentum along every joint, and the speed of every row.

    A row that asks for what the mechanism does not have shows here: its speed cannot be undone, whatever the digits.
    """
    nb = len(m.parent)
    through = [m.inertia[i] @ V[i] for i in range(nb)]
    torque = [widen(np.zeros(m.S[i].shape[1])) for i in range(nb)]
    size = max((abs(value) for force in through for value in force), default=mp.zero) or mp.one
    for x, row in zip(impulse, m.rows, strict=True):
        for i, wrench in row.wrench.items():
            through[i] = through[i] - wrench * x
        for (i, k), value in row.torque.items():
            torque[i][k] = torque[i][k] + x * value
    worst = mp.zero
    for i in range(nb - 1, -1, -1):
        if m.S[i].shape[1]:
            left = m.S[i].T @ through[i] + m.armature[i] * rates[i] - torque[i]
            worst = max(worst, *(abs(value) / size for value in left))
        if m.parent[i] >= 0:
            through[m.parent[i]] = through[m.parent[i]] + through[i]
    undone = max((abs(row.b) for row in m.rows), default=mp.zero) or mp.one
    for row in m.rows:
        worst = max(worst, abs(_work(row, V, list(rates)) + row.b) / undone)
    return float(worst)
